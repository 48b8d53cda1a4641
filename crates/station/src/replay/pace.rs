//! Owns the clock of a replay: where in the recording it is, and how long until a place is reached. It follows tokio's
//! clock, paused or not.

use std::time::Duration;

use tokio::time::Instant;

/// Slowest and fastest pace, times the recorded one.
pub const SPEEDS: std::ops::RangeInclusive<f64> = 0.01..=10_000.0;

/// Where a replay is, and how it goes on from there.
#[derive(Debug, Clone, Copy)]
pub(super) struct Pace {
    /// A place, and when the replay was there.
    from: (Duration, Instant),
    /// The end.
    end: Duration,
    pub(super) speed: f64,
    pub(super) is_paused: bool,
}

impl Pace {
    pub(super) fn new(place: Duration, end: Duration, speed: f64) -> Self {
        Self { from: (place.min(end), Instant::now()), end, speed, is_paused: false }
    }

    /// Where it is.
    pub(super) fn place(&self) -> Duration {
        let (place, at) = self.from;
        let on = if self.is_paused { Duration::ZERO } else { at.elapsed().mul_f64(self.speed) };
        place.saturating_add(on).min(self.end)
    }

    /// Goes on from another place.
    pub(super) fn seek(&mut self, place: Duration) {
        self.from = (place.min(self.end), Instant::now());
    }

    /// Goes on from here at another pace, or stops here.
    pub(super) fn set(&mut self, speed: f64, is_paused: bool) {
        self.seek(self.place());
        (self.speed, self.is_paused) = (speed, is_paused);
    }

    /// When it is at a place; `None` while it is paused.
    pub(super) fn due(&self, place: Duration) -> Option<Instant> {
        let (from, at) = self.from;
        let wait = place.saturating_sub(from).div_f64(self.speed);
        (!self.is_paused).then(|| at + wait)
    }
}
