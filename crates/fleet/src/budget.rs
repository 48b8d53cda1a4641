//! How often an aircraft says where it is: as often as is wanted and its uplink carries. No I/O; time comes in.
//!
//! Priorities do not help on a full modem: what waits there waits in one line. So what is sent is held below what the uplink
//! carries. Each second the aircraft asks for an echo; while that comes late, or not at all, the rate goes down a rung, and after
//! ten to twenty good seconds it goes up one. What is above is tried: echoes follow each other for some seconds then, so that the
//! line is not full before that is seen, and a rung that was too much is left alone for three times as long. Aircraft that share an
//! uplink do not try at one moment, for each waits a time of its own.

use std::time::Duration;

use rand::Rng;
use rand::rngs::SmallRng;
use vencejo_proto::MonoTime;

/// Samples a second, best first. The last is faster than a vehicle is lost ([`vencejo_vehicle::telemetry::LOST_AFTER`]).
pub const LADDER_HZ: [f64; 5] = [10.0, 5.0, 2.0, 1.0, 0.5];
/// The rung of an aircraft that nobody has chosen: 1 Hz.
const LISTED: usize = 3;
/// Samples a second of an aircraft that nobody hears: whoever comes is told at once, so this is for a network that does not say who does.
pub const UNHEARD_HZ: f64 = 0.2;
/// How often an echo is asked for.
const ECHO_INTERVAL: Duration = Duration::from_secs(1);
/// The same while nobody hears the aircraft.
const UNHEARD_ECHO_INTERVAL: Duration = Duration::from_secs(5);
/// An echo that has not come by then counts as lost.
pub const ECHO_LOST: Duration = Duration::from_secs(3);
/// An echo that takes longer is late, unless even the fastest takes a third of it.
const LATE: Duration = Duration::from_millis(500);
/// So much more than the fastest, several times in a row, is a line that fills, unless echoes mostly scatter by half of it.
const FILLING: Duration = Duration::from_millis(150);
/// How many in a row: of those that come each second, and of those after a rung was climbed.
const IN_A_ROW: usize = 3;
const IN_A_ROW_TRYING: usize = 2;
/// Good echoes for one to two times this earn a rung.
const GOOD_FOR: Duration = Duration::from_secs(10);
/// The same, at most, of a rung that was too much: each time it is three times as long.
const AGAIN_AFTER: Duration = Duration::from_secs(320);
/// After a rung was climbed echoes follow each other for so long, …
const TRYING: Duration = Duration::from_secs(5);
/// … each so long after the one before was asked for, or when that has come.
const TRYING_ECHO_INTERVAL: Duration = Duration::from_millis(250);
/// Who goes down within this of having climbed has climbed too far.
const PROVEN_AFTER: Duration = Duration::from_secs(60);
/// The fastest echo is looked for over one to two times this. A line that fills must not be taken for a long way.
const MEMORY: Duration = Duration::from_secs(300);
/// Late for so long on the last rung is a way that is slower for good, as over another router.
const SLOWER_AFTER: Duration = Duration::from_secs(10);
/// Share of a new echo in how far echoes scatter.
const SCATTER_SHARE: u32 = 32;
/// Share of the uplink that samples may fill.
const SHARE: f64 = 0.6;
/// Bytes on the wire beside a sample of its own: TCP, IP and what the network adds (measured: 27 of Zenoh, batched; TLS 29, TCP/IP 40).
const OVERHEAD_BYTES: usize = 96;

/// Who hears an aircraft.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Audience {
    /// Nobody subscribes to its states.
    Nobody,
    /// Ground stations, each in a list of many.
    List,
    /// Somebody who has control of it.
    Holder,
}

/// The rate at which an aircraft may speak.
#[derive(Debug, Clone)]
pub struct Budget {
    uplink_bit_s: Option<f64>,
    /// The best rung that the uplink is believed to carry.
    rung: usize,
    /// When the next one is earned, while echoes are good.
    earned_at: Option<MonoTime>,
    /// How long they have to be for each rung.
    good_for: [Duration; LADDER_HZ.len()],
    /// When this rung was climbed to, until it is proven.
    climbed: Option<MonoTime>,
    /// Echoes that were asked for before say nothing of the present rung.
    judged_from: MonoTime,
    /// The last that counted, newest last.
    recent: [Option<Duration>; IN_A_ROW],
    /// How much longer than the fastest they mostly take.
    scatter: Duration,
    /// The fastest echo of the present and of the last stretch of [`MEMORY`].
    fastest: [Option<Duration>; 2],
    stretch_began: MonoTime,
    /// Since when they have been late on the last rung.
    slow_since: Option<MonoTime>,
    /// When one was asked for last, and whether it has come.
    asked: Option<MonoTime>,
    has_come: bool,
    /// Size of samples, smoothed.
    sample_bytes: f64,
    rng: SmallRng,
}

impl Budget {
    /// Of an uplink of `uplink_bit_s`, where that is known. `rng` says when a rung is tried.
    #[must_use]
    pub fn new(uplink_bit_s: Option<f64>, rng: SmallRng, now: MonoTime) -> Self {
        Self {
            uplink_bit_s,
            // It is not known yet what the uplink carries: begin where the list is.
            rung: LISTED,
            earned_at: None,
            good_for: [GOOD_FOR; LADDER_HZ.len()],
            climbed: None,
            judged_from: now,
            recent: [None; IN_A_ROW],
            scatter: Duration::ZERO,
            fastest: [None; 2],
            stretch_began: now,
            slow_since: None,
            asked: None,
            has_come: false,
            sample_bytes: 0.0,
            rng,
        }
    }

    /// Whether an echo is to be asked for now; then it counts as asked for.
    pub fn asks_echo(&mut self, audience: Audience, now: MonoTime) -> bool {
        let interval = match self.climbed {
            Some(climbed) if self.has_come && now.since(climbed) < TRYING => TRYING_ECHO_INTERVAL,
            _ if audience == Audience::Nobody => UNHEARD_ECHO_INTERVAL,
            _ => ECHO_INTERVAL,
        };
        let is_due = self.asked.is_none_or(|asked| now.since(asked) >= interval);
        if is_due {
            (self.asked, self.has_come) = (Some(now), false);
        }
        is_due
    }

    /// An echo came back after this time.
    pub fn on_echo(&mut self, took: Duration, now: MonoTime) {
        self.has_come = true;
        if now.since(self.stretch_began) >= MEMORY {
            self.fastest = [None, self.fastest[0]];
            self.stretch_began = now;
        }
        self.fastest[0] = Some(self.fastest[0].map_or(took, |fastest| fastest.min(took)));
        if took > now.since(self.judged_from) {
            return;
        }
        let fastest = self.fastest.into_iter().flatten().min().unwrap_or(took);
        self.recent.rotate_left(1);
        self.recent[IN_A_ROW - 1] = Some(took);
        if took > LATE.max(fastest * 3) || self.fills(fastest, now) {
            self.step_down(now);
            return;
        }
        self.scatter = (self.scatter * (SCATTER_SHARE - 1) + (took - fastest)) / SCATTER_SHARE;
        self.slow_since = None;
        if self.climbed.is_some_and(|climbed| now.since(climbed) >= PROVEN_AFTER) {
            self.good_for[self.rung] = GOOD_FOR;
            self.climbed = None;
        }
        self.climb(now);
    }

    /// Whether the line fills: the last echoes all took longer than they mostly do.
    fn fills(&self, fastest: Duration, now: MonoTime) -> bool {
        let is_trying = self.climbed.is_some_and(|climbed| now.since(climbed) < TRYING);
        let count = if is_trying { IN_A_ROW_TRYING } else { IN_A_ROW };
        let most = fastest + FILLING.max(self.scatter * 2);
        self.recent[IN_A_ROW - count..].iter().all(|took| took.is_some_and(|took| took > most))
    }

    fn climb(&mut self, now: MonoTime) {
        let Some(next) = self.rung.checked_sub(1) else { return };
        let earned_at =
            *self.earned_at.get_or_insert_with(|| now + self.good_for[next].mul_f64(1.0 + self.rng.random::<f64>()));
        if now >= earned_at {
            self.climbed = Some(now);
            self.stand_on(next, now);
        }
    }

    /// An echo did not come within [`ECHO_LOST`].
    pub fn on_echo_lost(&mut self, now: MonoTime) {
        if now.since(self.judged_from) >= ECHO_LOST {
            self.step_down(now);
        }
    }

    fn step_down(&mut self, now: MonoTime) {
        if self.climbed.take().is_some() {
            let good_for = &mut self.good_for[self.rung];
            *good_for = (*good_for * 3).min(AGAIN_AFTER);
        }
        let last = LADDER_HZ.len() - 1;
        if self.rung == last && now.since(*self.slow_since.get_or_insert(now)) >= SLOWER_AFTER {
            (self.fastest, self.stretch_began, self.slow_since) = ([None; 2], now, None);
            self.good_for = [GOOD_FOR; LADDER_HZ.len()];
        }
        self.stand_on((self.rung + 1).min(last), now);
    }

    fn stand_on(&mut self, rung: usize, now: MonoTime) {
        self.rung = rung;
        (self.earned_at, self.judged_from, self.recent) = (None, now, [None; IN_A_ROW]);
    }

    /// A sample of this size went out.
    pub fn on_sample(&mut self, bytes: usize) {
        let bytes = (bytes + OVERHEAD_BYTES) as f64;
        self.sample_bytes = if self.sample_bytes == 0.0 { bytes } else { 0.9 * self.sample_bytes + 0.1 * bytes };
    }

    /// Samples a second now.
    #[must_use]
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
    #[must_use]
    pub fn interval(&self, audience: Audience) -> Duration {
        Duration::from_secs_f64(1.0 / self.rate_hz(audience))
    }
}

/// Share of the uplink that lists may fill, beside the samples.
const LISTS_SHARE: f64 = 0.25;

/// When the next piece of a list may go: where the uplink is known, lists fill a share of it; elsewhere who asks for them sees to it.
#[derive(Debug, Clone)]
pub struct Pacer {
    uplink_bit_s: Option<f64>,
    free_at: MonoTime,
}

impl Pacer {
    /// Of an uplink of `uplink_bit_s`, where that is known.
    #[must_use]
    pub fn new(uplink_bit_s: Option<f64>) -> Self {
        Self { uplink_bit_s, free_at: MonoTime::ZERO }
    }

    /// How long a piece of this size has to wait; it counts as sent then.
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
    use rand::SeedableRng;

    use super::*;

    fn rng(seed: u64) -> SmallRng {
        SmallRng::seed_from_u64(seed)
    }

    /// A budget and its clock, an echo each second.
    struct Bench(Budget, MonoTime);

    impl Bench {
        fn new(uplink_bit_s: Option<f64>) -> Self {
            Self(Budget::new(uplink_bit_s, rng(1), MonoTime::ZERO), MonoTime::ZERO)
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
        assert_eq!(bench.echoes(11, 50), 2.0, "ten to twenty good seconds earn a rung");
        assert_eq!(bench.echoes(42, 50), 10.0);
        assert_eq!((bench.echoes(100, 50), bench.0.rate_hz(Audience::List)), (10.0, 1.0));
    }

    #[test]
    fn to_nobody_little_is_said_however_good_the_uplink_is() {
        let mut bench = Bench::new(None);
        bench.echoes(100, 50);
        assert_eq!(bench.0.interval(Audience::Nobody), Duration::from_secs(5));
        let mut asked = |audience, after_s| {
            bench.1 += Duration::from_secs(after_s);
            bench.0.asks_echo(audience, bench.1)
        };
        assert!(asked(Audience::Nobody, 5) && !asked(Audience::Nobody, 1) && asked(Audience::List, 0));
    }

    #[test]
    fn late_and_lost_echoes_slow_it_down() {
        let mut bench = Bench::new(None);
        bench.echoes(64, 50);
        assert_eq!(bench.echoes(1, 500), 10.0, "half a second is not late");
        assert_eq!(bench.echoes(1, 501), 5.0);
        let mut lost = |times| {
            for _ in 0..times {
                bench.1 += ECHO_LOST;
                bench.0.on_echo_lost(bench.1);
                bench.0.on_echo_lost(bench.1);
                bench.0.on_echo(Duration::from_secs(1), bench.1 + Duration::from_millis(10));
            }
            bench.0.rate_hz(Audience::Holder)
        };
        assert_eq!(lost(1), 2.0, "what was asked for before says nothing of the new rung");
        lost(9);
        assert_eq!((bench.0.rate_hz(Audience::Holder), bench.0.rate_hz(Audience::List)), (0.5, 0.5), "never silent");
    }

    #[test]
    fn a_long_way_is_not_a_full_one() {
        let mut bench = Bench::new(None);
        assert_eq!(bench.echoes(64, 600), 10.0, "a satellite takes that long");
        assert_eq!(bench.echoes(1, 1801), 5.0);
        let mut moved = Bench::new(None);
        moved.echoes(60, 50);
        moved.echoes(60, 700);
        assert_eq!(
            moved.echoes(60, 700),
            10.0,
            "the fast way is gone for good: forgotten when slower speech does not help"
        );
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

    /// An uplink of a fixed width that aircraft share, with a queue as in a modem: 500 bytes a sample, and a tenth of a second there
    /// and back, with up to `jitter_s` more. How long an order takes at 99 %, and the samples a second of each.
    fn shared(aircraft: u64, bit_s: f64, jitter_s: f64, seed: u64) -> (f64, f64) {
        const STEP: Duration = Duration::from_millis(10);
        let (mut way, mut now, mut queue_bit) = (rng(seed), MonoTime::ZERO, 0.0_f64);
        let mut all: Vec<_> = (0..aircraft)
            .map(|each| (Budget::new(None, rng(seed * 100 + each), now), now + STEP * each as u32))
            .collect();
        let (mut orders_s, mut samples, mut under_way) = (Vec::new(), 0_u32, Vec::new());
        for step in 0..180_000 {
            now += STEP;
            queue_bit = (queue_bit - bit_s * STEP.as_secs_f64()).max(0.0);
            let mut takes_s = |queue_bit: f64| 0.1 + queue_bit / bit_s + jitter_s * way.random::<f64>();
            for (index, (budget, sample_due)) in all.iter_mut().enumerate() {
                if budget.asks_echo(Audience::Holder, now) {
                    queue_bit += 800.0;
                    under_way.push((index, now, Duration::from_secs_f64(takes_s(queue_bit))));
                }
                if now >= *sample_due {
                    *sample_due = now + budget.interval(Audience::Holder);
                    queue_bit += 596.0 * 8.0;
                    samples += 1;
                }
            }
            if step > 3_500 && step % 25 == 0 {
                orders_s.push(takes_s(queue_bit));
            }
            under_way.retain(|&(index, asked, took)| {
                let is_over = now.since(asked) >= took.min(ECHO_LOST);
                match is_over {
                    true if took > ECHO_LOST => all[index].0.on_echo_lost(now),
                    true => all[index].0.on_echo(took, now),
                    false => {}
                }
                !is_over
            });
        }
        orders_s.sort_by(f64::total_cmp);
        (orders_s[orders_s.len() * 99 / 100], f64::from(samples) / aircraft as f64 / 1_800.0)
    }

    #[test]
    fn a_narrow_uplink_stays_free_for_orders_and_is_used() {
        for seed in 0..4 {
            let (order_s, rate_hz) = shared(1, 30_000.0, 0.0, seed);
            assert!(order_s < 0.7 && rate_hz > 4.5, "{order_s} s, {rate_hz} of 6.3 a second");
            let (order_s, rate_hz) = shared(8, 256_000.0, 0.0, seed);
            assert!(order_s < 0.35 && rate_hz > 5.5, "{order_s} s, {rate_hz} of 6.7 a second");
            let (order_s, rate_hz) = shared(8, 100_000.0, 0.0, seed);
            assert!(order_s < 0.45 && rate_hz > 1.5, "{order_s} s, {rate_hz} of 2.6 a second");
        }
    }

    #[test]
    fn a_way_that_scatters_is_not_a_full_one() {
        for jitter_s in [0.1, 0.3] {
            let (_, rate_hz) = shared(1, 10_000_000.0, jitter_s, 1);
            assert!(rate_hz > 8.0, "{rate_hz} samples a second at {jitter_s} s");
        }
    }
}
