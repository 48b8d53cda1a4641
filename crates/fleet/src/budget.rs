//! The rate of an aircraft's states: as often as wanted and as its uplink carries. No I/O; time is passed in.
//!
//! Priorities do not help on a full modem, which has a single queue. So the rate is kept below the uplink's capacity:
//! each second the aircraft asks for an echo, in a list each five; while echoes are late or lost the rate goes down a
//! rung, and after ten good seconds it goes up one.

use std::time::Duration;

use vencejo_proto::MonoTime;

/// Samples a second, best first. The last is faster than a vehicle is lost
/// ([`vencejo_vehicle::telemetry::LOST_AFTER`]).
pub const LADDER_HZ: [f64; 5] = [10.0, 5.0, 2.0, 1.0, 0.5];
/// The rung of an aircraft that nobody controls: 1 Hz.
const LISTED: usize = 3;
/// Samples a second without subscribers. A new subscriber gets a state at once, so this is for networks that do not
/// report subscribers.
pub const UNHEARD_HZ: f64 = 0.2;
/// The interval between echo requests of an aircraft that somebody controls, or whose echoes are lost.
pub const ECHO_INTERVAL: Duration = Duration::from_secs(1);
/// The same of others: what they send hardly fills an uplink.
const SELDOM_ECHO_INTERVAL: Duration = Duration::from_secs(5);
/// An echo that has not come by then counts as lost.
pub const ECHO_LOST: Duration = Duration::from_secs(3);
/// An echo that takes longer is late, unless even the fastest takes a third of it.
const LATE: Duration = Duration::from_millis(500);
/// Good echoes for this long raise the rate by a rung.
const GOOD_FOR: Duration = Duration::from_secs(10);
/// How long the fastest echo counts, at least.
const MEMORY: Duration = Duration::from_secs(30);
/// Share of the uplink that samples may fill.
const SHARE: f64 = 0.6;
/// Overhead of a sample on the wire, bytes: TCP, IP and what the network adds (measured: 27 of Zenoh, batched; TLS 29,
/// TCP/IP 40).
const OVERHEAD_BYTES: usize = 96;

/// The audience of an aircraft.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Audience {
    /// Nobody subscribes to its states.
    Nobody,
    /// Ground stations, each in a list of many.
    List,
    /// A station that has control of it.
    Holder,
}

impl Audience {
    /// Time between two echoes, of which the last ones were lost or not.
    pub fn echo_interval(self, are_lost: bool) -> Duration {
        match self {
            Self::Holder => ECHO_INTERVAL,
            Self::List if are_lost => ECHO_INTERVAL,
            Self::List | Self::Nobody => SELDOM_ECHO_INTERVAL,
        }
    }
}

/// The fastest answer of the last time, one to two times as long as `memory`: another way may be slower for good.
#[derive(Debug, Clone)]
pub(crate) struct Fastest {
    memory: Duration,
    /// Of the present stretch of `memory` and of the last one.
    stretches: [Option<Duration>; 2],
    began: MonoTime,
}

impl Fastest {
    pub(crate) const fn new(memory: Duration, now: MonoTime) -> Self {
        Self { memory, stretches: [None; 2], began: now }
    }

    /// An answer took this long; gives the fastest.
    pub(crate) fn on_answer(&mut self, took: Duration, now: MonoTime) -> Duration {
        if now.since(self.began) >= self.memory {
            self.stretches = [None, self.stretches[0]];
            self.began = now;
        }
        self.stretches[0] = Some(self.stretches[0].map_or(took, |fastest| fastest.min(took)));
        self.stretches.into_iter().flatten().min().unwrap_or(took)
    }
}

/// The rate of an aircraft's states.
#[derive(Debug, Clone)]
pub struct Budget {
    uplink_bit_s: Option<f64>,
    /// The best rung that the uplink is believed to carry.
    rung: usize,
    good_since: Option<MonoTime>,
    fastest: Fastest,
    /// Size of samples, smoothed.
    sample_bytes: f64,
}

impl Budget {
    /// For an uplink of `uplink_bit_s`, if known.
    pub fn new(uplink_bit_s: Option<f64>, now: MonoTime) -> Self {
        // The uplink's capacity is not known yet: begin at the list's rate.
        let fastest = Fastest::new(MEMORY, now);
        Self { uplink_bit_s, rung: LISTED, good_since: None, fastest, sample_bytes: 0.0 }
    }

    /// An echo came back after this time.
    pub fn on_echo(&mut self, took: Duration, now: MonoTime) {
        if took > LATE.max(self.fastest.on_answer(took, now) * 3) {
            self.step_down();
            return;
        }
        let since = *self.good_since.get_or_insert(now);
        if now.since(since) >= GOOD_FOR {
            self.rung = self.rung.saturating_sub(1);
            self.good_since = Some(now);
        }
    }

    /// An echo was lost.
    pub fn on_echo_lost(&mut self) {
        self.step_down();
    }

    fn step_down(&mut self) {
        self.rung = (self.rung + 1).min(LADDER_HZ.len() - 1);
        self.good_since = None;
    }

    /// A sample of this size went out.
    pub fn on_sample(&mut self, bytes: usize) {
        let bytes = (bytes + OVERHEAD_BYTES) as f64;
        self.sample_bytes = if self.sample_bytes == 0.0 { bytes } else { 0.9 * self.sample_bytes + 0.1 * bytes };
    }

    /// Samples a second now.
    pub fn rate_hz(&self, audience: Audience) -> f64 {
        let wanted = match audience {
            Audience::Nobody => return UNHEARD_HZ,
            Audience::List => LISTED,
            Audience::Holder => 0,
        };
        let wanted = wanted.max(self.rung);
        // The uplink's share; the last rung always goes.
        let fits = |rate: &f64| self.uplink_bit_s.is_none_or(|bit_s| rate * self.sample_bytes * 8.0 <= SHARE * bit_s);
        LADDER_HZ[wanted..].iter().copied().find(fits).unwrap_or(LADDER_HZ[LADDER_HZ.len() - 1])
    }

    /// Time between samples.
    pub fn interval(&self, audience: Audience) -> Duration {
        Duration::from_secs_f64(1.0 / self.rate_hz(audience))
    }
}

/// Share of the uplink that lists may fill, beside the samples.
const LISTS_SHARE: f64 = 0.25;

/// When the next piece of a list may be sent: lists fill a share of a known uplink; otherwise the requesting side
/// limits the rate.
#[derive(Debug, Clone)]
pub struct Pacer {
    uplink_bit_s: Option<f64>,
    free_at: MonoTime,
}

impl Pacer {
    /// For an uplink of `uplink_bit_s`, if known.
    pub fn new(uplink_bit_s: Option<f64>) -> Self {
        Self { uplink_bit_s, free_at: MonoTime::ZERO }
    }

    /// How long a piece of this size has to wait; it is counted as sent.
    pub fn wait(&mut self, bytes: usize, now: MonoTime) -> Duration {
        let Some(bit_s) = self.uplink_bit_s else { return Duration::ZERO };
        let goes = self.free_at.max(now);
        let takes_s = (bytes + OVERHEAD_BYTES) as f64 * 8.0 / (LISTS_SHARE * bit_s).max(1.0);
        self.free_at = goes + Duration::from_secs_f64(takes_s.min(60.0));
        goes.since(now)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A budget and its clock, an echo each second.
    struct Bench(Budget, MonoTime);

    impl Bench {
        fn new(uplink_bit_s: Option<f64>) -> Self {
            Self(Budget::new(uplink_bit_s, MonoTime::ZERO), MonoTime::ZERO)
        }

        fn echoes(&mut self, seconds: u32, ms: u64) -> f64 {
            for _ in 0..seconds {
                self.1 += ECHO_INTERVAL;
                self.0.on_echo(Duration::from_millis(ms), self.1);
            }
            self.0.rate_hz(Audience::Holder)
        }
    }

    #[test]
    fn a_good_uplink_is_used_and_a_list_is_not_hurried() {
        let mut bench = Bench::new(None);
        assert_eq!(bench.0.rate_hz(Audience::Holder), 1.0, "nothing is known yet");
        assert_eq!(bench.echoes(10, 50), 1.0);
        assert_eq!(bench.echoes(1, 50), 2.0, "ten good seconds earn a rung");
        assert_eq!(bench.echoes(20, 50), 10.0);
        assert_eq!((bench.echoes(100, 50), bench.0.rate_hz(Audience::List)), (10.0, 1.0));
    }

    #[test]
    fn to_nobody_little_is_said_however_good_the_uplink_is() {
        let mut bench = Bench::new(None);
        bench.echoes(100, 50);
        assert_eq!(bench.0.interval(Audience::Nobody), Duration::from_secs(5));
        assert_eq!(Audience::Nobody.echo_interval(true), Audience::List.echo_interval(false));
        assert_eq!(Audience::List.echo_interval(true), Audience::Holder.echo_interval(false));
    }

    #[test]
    fn late_and_lost_echoes_slow_it_down() {
        let mut bench = Bench::new(None);
        bench.echoes(40, 50);
        assert_eq!(bench.echoes(1, 500), 10.0, "half a second is not late");
        assert_eq!(bench.echoes(1, 501), 5.0);
        bench.0.on_echo_lost();
        assert_eq!(bench.0.rate_hz(Audience::Holder), 2.0);
        for _ in 0..9 {
            bench.0.on_echo_lost();
        }
        assert_eq!((bench.0.rate_hz(Audience::Holder), bench.0.rate_hz(Audience::List)), (0.5, 0.5), "never silent");
    }

    #[test]
    fn a_long_way_is_not_a_full_one() {
        let mut bench = Bench::new(None);
        assert_eq!(bench.echoes(60, 600), 10.0, "a satellite takes that long");
        assert_eq!(bench.echoes(1, 1801), 5.0);
        let mut moved = Bench::new(None);
        moved.echoes(60, 50);
        moved.echoes(60, 700);
        assert_eq!(moved.echoes(60, 700), 10.0, "the fast way is gone for good: forgotten after a minute");
    }

    #[test]
    fn samples_fill_a_share_of_a_known_uplink() {
        let mut bench = Bench::new(Some(20_000.0));
        for _ in 0..100 {
            bench.0.on_sample(120);
        }
        // (120 + 96) bytes × 8 = 1,728 bit; 60 % of 20 kbit/s carry 6.9 of them a second.
        assert_eq!(bench.echoes(100, 50), 5.0);
        let mut thin = Bench::new(Some(100.0));
        thin.0.on_sample(120);
        assert_eq!(thin.echoes(100, 50), 0.5);
    }

    #[test]
    fn lists_fill_a_share_of_a_known_uplink_and_wait_for_nothing_else() {
        let mut pacer = Pacer::new(Some(100_000.0));
        let mut now = MonoTime::from_millis(1_000);
        let mut waited = Duration::ZERO;
        for _ in 0..10 {
            let wait = pacer.wait(4_000, now);
            now += wait;
            waited += wait;
        }
        // Nine times (4,000 + 96) bytes × 8 at 25 kbit/s.
        assert!((waited.as_secs_f64() - 11.8).abs() < 0.01, "{waited:?}");
        assert_eq!(pacer.wait(4_000, now + Duration::from_secs(5)), Duration::ZERO);
        let mut free = Pacer::new(None);
        assert_eq!([free.wait(1 << 20, now), free.wait(1 << 20, now)], [Duration::ZERO; 2]);
    }

    /// An uplink of a fixed width, with a queue as in a modem: the ladder finds a rate that leaves it free.
    #[test]
    fn a_narrow_uplink_stays_free_for_commands() {
        let (mut budget, mut now) = (Budget::new(None, MonoTime::ZERO), MonoTime::ZERO);
        let (mut queue_bit, mut late, mut samples) = (0.0_f64, 0, 0.0);
        for _ in 0..600 {
            now += ECHO_INTERVAL;
            let rate = budget.rate_hz(Audience::Holder);
            samples += rate;
            queue_bit = (queue_bit + rate * 216.0 * 8.0 - 6_000.0).max(0.0);
            let took = Duration::from_secs_f64(0.08 + queue_bit / 6_000.0);
            late += u32::from(took > Duration::from_secs(1));
            if took > ECHO_LOST { budget.on_echo_lost() } else { budget.on_echo(took, now) }
        }
        assert!(late < 60, "{late} of 600 seconds had an echo of more than one");
        assert!(samples / 600.0 >= 1.5, "{samples} samples of 2,083 that would fit");
    }
}
