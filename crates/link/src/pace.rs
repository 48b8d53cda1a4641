//! Owns the batching of a fast reader: a wake-up costs as much as handling ten items, so what comes faster than it can
//! be used one by one is read a few at a time.

use std::time::{Duration, Instant};

/// Below this mean interval items are read several at a time.
const FAST: Duration = Duration::from_micros(250);
/// A longer silence counts as this long.
const SILENCE: Duration = Duration::from_secs(1);

/// A reader that may be late by one pause while it would otherwise be woken more often than every 250 µs. What already
/// comes a few at a time wakes it less often than that, and is read at once.
#[derive(Debug)]
pub struct Pace {
    pause: Duration,
    /// When it was drained last.
    looked: Option<Instant>,
    /// Items read since.
    taken: u32,
    /// Whether it paused then: several items have come since, each of which would have woken it.
    paused: bool,
    /// The recent mean interval between two wake-ups, as they are without a pause.
    gap: Duration,
}

impl Pace {
    /// A reader that has read nothing yet, with pauses of this length.
    pub const fn new(pause: Duration) -> Self {
        Self { pause, looked: None, taken: 0, paused: false, gap: SILENCE }
    }

    /// Counts an item.
    pub const fn on_taken(&mut self) {
        self.taken = self.taken.saturating_add(1);
    }

    /// It paused, whether or not [`Self::pause`] said so: a reader may go on for a while.
    pub const fn on_paused(&mut self) {
        self.paused = true;
    }

    /// It is drained: how long to pause before waiting for the next item; zero when none was read since.
    pub fn pause(&mut self, now: Instant) -> Option<Duration> {
        let since = self.looked.replace(now).map(|looked| now.saturating_duration_since(looked));
        let taken = std::mem::take(&mut self.taken);
        if let (Some(since), 1..) = (since, taken) {
            let wakeups = if self.paused { taken } else { 1 };
            self.gap = (self.gap * 3 + since.min(SILENCE) / wakeups) / 4;
        }
        self.paused = taken > 0 && self.gap < FAST;
        self.paused.then_some(self.pause)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_reader_lets_several_come_while_they_come_fast() {
        let (mut pace, mut now) = (Pace::new(Duration::from_millis(1)), Instant::now());
        let mut reads = |count: u32, each: Duration| {
            now += each * count;
            (0..count).for_each(|_| pace.on_taken());
            pace.pause(now).is_some()
        };
        let (slow, fast) = (Duration::from_millis(1), Duration::from_micros(100));
        assert!((0..100).all(|_| !reads(1, slow)), "each is read at once");
        assert!((0..100).all(|_| !reads(10, fast)), "what comes ten at a time wakes it seldom enough");
        assert!((0..3).all(|_| !reads(1, fast)), "a few that come together are no stream");
        assert!((0..100).any(|_| reads(1, fast)));
        assert!((0..100).all(|_| reads(10, fast)));
        assert!((0..5).any(|_| !reads(1, slow)), "and soon at once again");
        assert!((0..100).any(|_| reads(1, fast)));
        assert!(!reads(0, slow), "none came");
        reads(1, Duration::from_secs(3600));
        assert!(!reads(0, slow), "after a silence");
    }

    #[test]
    fn a_reader_that_goes_on_with_pauses_is_not_slowed_down_by_a_gap() {
        let (mut pace, mut now) = (Pace::new(Duration::from_millis(1)), Instant::now());
        let mut read = |pace: &mut Pace, count: u32, since: Duration| {
            now += since;
            (0..count).for_each(|_| pace.on_taken());
            pace.pause(now).is_some()
        };
        assert!((0..100).any(|_| read(&mut pace, 1, Duration::from_micros(100))));
        assert!((0..100).all(|number| {
            let count = if number % 2 == 0 { 10 } else { 0 };
            let is_fast = read(&mut pace, count, Duration::from_millis(1));
            pace.on_paused();
            is_fast == (count > 0)
        }));
    }
}
