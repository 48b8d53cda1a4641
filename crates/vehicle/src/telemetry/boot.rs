//! Detects restarts of the autopilot: its time since boot goes back. Where it jumps ahead, it may be another autopilot.

use std::time::Duration;

use vencejo_proto::MonoTime;

/// Reordering of messages on their way, in the vehicle's time.
const REORDER_MS: u32 = 500;
/// Messages in a row, each newer than the one before, that prove that the clock went back: a repeated old datagram does
/// not.
const PROOFS: u32 = 3;
/// The 32-bit counter wraps after 49.7 days.
const WRAP_ZONE_MS: u32 = 60_000;
/// Shortest silence in which a vehicle can restart: the fastest boards need about this long.
const SILENCE: Duration = Duration::from_secs(1);
/// After such a silence the clock must have caught up with ours, up to this much.
const LAG: Duration = Duration::from_secs(1);
/// How long a backlog of old messages may take to drain after a silence.
const DRAIN: Duration = Duration::from_secs(3);
/// A clock that has advanced by no more than this over a silence stood still meanwhile, as that of a simulator that was
/// paused. Between two states of a remote vehicle lies a second or two.
const STOOD_STILL_MS: u32 = 3_000;

/// An event shown by the time since boot.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum BootEvent {
    /// The autopilot restarted. Everything received before `since` is from before the restart.
    Rebooted {
        /// When the first message after the restart arrived.
        since: MonoTime,
    },
    /// After a silence it is ahead of the time that has passed, by more than 1 s: another autopilot may be there, which
    /// has been up for longer. So is a simulator that is faster than time, and a link that was late before.
    RanAhead,
}

/// Follows the time since boot of one autopilot.
#[derive(Debug, Default)]
pub struct BootClock {
    newest: Option<(u32, MonoTime)>,
    /// The first time that was heard after a silence, if it was slightly before the newest.
    earlier_ms: Option<u32>,
    back: Option<Back>,
    lag: Option<Lag>,
}

/// Messages from before the newest time.
#[derive(Debug)]
struct Back {
    since: MonoTime,
    boot_ms: u32,
    proofs: u32,
}

/// After a silence the vehicle's clock is behind ours.
#[derive(Debug)]
struct Lag {
    since: MonoTime,
    /// The time since boot then.
    first_ms: u32,
    anchor: (u32, MonoTime),
}

impl BootClock {
    /// Reads the time since boot of a message.
    ///
    /// A restart shows in two ways: the time goes back for several messages in a row (one old datagram that was delayed
    /// is no restart), or, after a silence, it stays behind by more than 1 s. The second is for a restart soon after
    /// boot, whose time has grown past the old one when it is heard: that takes a silence as long as the old life was,
    /// so no silence, pause or delay makes a vehicle that has been up for longer look restarted. A clock that stood still
    /// in the silence and runs on from there is no restart either.
    pub fn observe(&mut self, boot_ms: u32, now: MonoTime) -> Option<BootEvent> {
        let Some((newest_ms, newest_at)) = self.newest else {
            self.newest = Some((boot_ms, now));
            return None;
        };
        let has_wrapped = newest_ms > u32::MAX - WRAP_ZONE_MS && boot_ms < WRAP_ZONE_MS;
        if boot_ms >= newest_ms || has_wrapped {
            self.back = None;
            let silence = now.since(newest_at);
            let could_hide_a_life = u128::from(newest_ms) <= silence.as_millis() + u128::from(REORDER_MS);
            let first_ms = self.earlier_ms.take().unwrap_or(boot_ms);
            if silence > SILENCE && could_hide_a_life {
                self.lag = Some(Lag { since: now, first_ms, anchor: (newest_ms, newest_at) });
            }
            self.newest = Some((boot_ms, now));
            let passed = Duration::from_millis(u64::from(boot_ms.wrapping_sub(newest_ms)));
            if silence > SILENCE && passed > silence + LAG {
                return Some(BootEvent::RanAhead);
            }
            return self.check_lag(boot_ms, now);
        }
        if newest_ms - boot_ms <= REORDER_MS {
            self.back = None;
            if now.since(newest_at) > SILENCE {
                self.earlier_ms.get_or_insert(boot_ms);
            }
            return None;
        }
        match &mut self.back {
            Some(back) if boot_ms > back.boot_ms => {
                back.boot_ms = boot_ms;
                back.proofs += 1;
                if back.proofs >= PROOFS {
                    let since = back.since;
                    return Some(self.rebooted(boot_ms, since, now));
                }
            }
            Some(back) if back.boot_ms - boot_ms <= REORDER_MS => {}
            _ => self.back = Some(Back { since: now, boot_ms, proofs: 1 }),
        }
        None
    }

    fn check_lag(&mut self, boot_ms: u32, now: MonoTime) -> Option<BootEvent> {
        let lag = self.lag.as_ref()?;
        let (anchor_ms, anchor_at) = lag.anchor;
        let passed = Duration::from_millis(u64::from(boot_ms.wrapping_sub(anchor_ms)));
        if now.since(anchor_at) <= passed + LAG {
            self.lag = None;
            return None;
        }
        if now.since(lag.since) < DRAIN {
            return None;
        }
        // Messages from before a restart may come first.
        let runs_on =
            Duration::from_millis(u64::from(boot_ms.wrapping_sub(lag.first_ms))) <= now.since(lag.since) + LAG;
        let stood_still = lag.first_ms.checked_sub(anchor_ms).is_some_and(|ahead_ms| ahead_ms <= STOOD_STILL_MS);
        if stood_still && runs_on {
            self.lag = None;
            return None;
        }
        let since = lag.since;
        Some(self.rebooted(boot_ms, since, now))
    }

    fn rebooted(&mut self, boot_ms: u32, since: MonoTime, now: MonoTime) -> BootEvent {
        *self = Self { newest: Some((boot_ms, now)), ..Self::default() };
        BootEvent::Rebooted { since }
    }

    /// Starts anew, after a restart that was noticed elsewhere.
    pub fn reset(&mut self) {
        *self = Self::default();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(ms: u64) -> MonoTime {
        MonoTime::from_millis(ms)
    }

    /// Feeds (boot_ms, our ms) pairs; returns when a restart was noticed.
    fn noticed(samples: &[(u32, u64)]) -> Option<u64> {
        let mut clock = BootClock::default();
        samples.iter().find_map(|(boot_ms, ms)| clock.observe(*boot_ms, at(*ms)).map(|_| *ms))
    }

    #[test]
    fn a_clock_that_goes_on_is_no_restart() {
        let samples: Vec<_> = (0..1_000).map(|n| (5_000 + n * 100, u64::from(n) * 100)).collect();
        assert_eq!(noticed(&samples), None);
    }

    // fault 15: at its third message
    #[test]
    fn a_restart_is_noticed_at_the_third_message() {
        let mut samples: Vec<_> = (0..100).map(|n| (60_000 + n * 100, u64::from(n) * 100)).collect();
        samples.extend((0..5).map(|n| (1_200 + n * 100, 15_000 + u64::from(n) * 100)));
        assert_eq!(noticed(&samples), Some(15_200));
    }

    #[test]
    fn reordering_and_repeated_old_messages_are_no_restart() {
        assert_eq!(noticed(&[(1_000, 0), (1_300, 300), (1_100, 310), (1_400, 400), (1_200, 410)]), None);
        let mut samples = Vec::new();
        for n in 0..50u32 {
            samples.push((100_000 + n * 100, u64::from(n) * 100));
            // An old datagram, three times, as a broken network repeats it.
            samples.extend([(50_000, u64::from(n) * 100 + 1); 3]);
        }
        assert_eq!(noticed(&samples), None);
    }

    #[test]
    fn the_counter_wraps_without_a_restart() {
        let samples: Vec<_> =
            (0..20u32).map(|n| ((u32::MAX - 950).wrapping_add(n * 100), u64::from(n) * 100)).collect();
        assert!(samples.iter().any(|(boot_ms, _)| *boot_ms < 1_000));
        assert_eq!(noticed(&samples), None);
        // But a restart after 30 days is one.
        assert_eq!(noticed(&[(2_592_000_000, 0), (900, 9_000), (1_000, 9_100), (1_100, 9_200)]), Some(9_200));
    }

    #[test]
    fn a_restart_during_a_silence_shows_by_the_lag() {
        // Up 5 s, restarted, silent 20 s: the time did not go back, but 10 s are missing.
        let mut samples = vec![(5_000, 0)];
        samples.extend((0..50).map(|n| (15_000 + n * 100, 20_000 + u64::from(n) * 100)));
        assert_eq!(noticed(&samples), Some(23_000));
    }

    #[test]
    fn a_second_restart_soon_after_the_first_is_noticed_too() {
        let mut clock = BootClock::default();
        let mut noticed = Vec::new();
        let mut hear = |boot_ms: u32, ms: u64| {
            if clock.observe(boot_ms, at(ms)).is_some() {
                noticed.push(ms);
            }
        };
        for n in 0..100u32 {
            hear(60_000 + n * 100, u64::from(n) * 100);
        }
        for n in 0..4u32 {
            hear(1_200 + n * 100, 15_000 + u64::from(n) * 100);
        }
        // Two seconds later it is up again: its time is as near to the old one as that of a message that was overtaken.
        for n in 0..60u32 {
            hear(1_100 + n * 100, 17_300 + u64::from(n) * 100);
        }
        assert_eq!(noticed.len(), 2, "{noticed:?}");
        assert!(noticed[1] < 22_000, "{noticed:?}");
    }

    #[test]
    fn a_long_silence_of_a_vehicle_that_was_up_for_longer_is_no_restart() {
        // A simulator that was paused for 20 s, or a link that stays late by 8 s.
        let mut samples = vec![(300_000, 0)];
        samples.extend((0..100).map(|n| (300_100 + n * 100, 20_000 + u64::from(n) * 100)));
        assert_eq!(noticed(&samples), None);
    }

    #[test]
    fn a_clock_that_stood_still_as_long_as_the_vehicle_was_up_is_no_restart() {
        // A simulator that was paused for 25 s after 20 s; as it is heard on its link, and far away.
        for (first_ms, step) in [(20_100, 1), (21_900, 20)] {
            let mut samples = vec![(20_000, 0)];
            samples.extend((0..1_000).step_by(step).map(|n: u32| (first_ms + n * 100, 25_000 + u64::from(n) * 100)));
            assert_eq!(noticed(&samples), None, "{first_ms}");
        }
        // The same, and its last words from before a restart come first.
        let mut samples = vec![(5_000, 0), (5_100, 20_000), (5_200, 20_010)];
        samples.extend((0..50).map(|n| (15_000 + n * 100, 20_020 + u64::from(n) * 100)));
        assert_eq!(noticed(&samples), Some(23_020));
    }

    #[test]
    fn a_backlog_after_a_silence_is_no_restart() {
        let mut samples = vec![(5_000, 0)];
        // Ten seconds of messages arrive within one.
        samples.extend((1..100).map(|n| (5_000 + n * 100, 10_000 + u64::from(n) * 10)));
        samples.extend((0..100).map(|n| (16_000 + n * 100, 11_000 + u64::from(n) * 100)));
        assert_eq!(noticed(&samples), None);
    }
}
