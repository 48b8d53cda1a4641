//! All timeouts of the transfers, with their sources.

use std::time::Duration;

/// Silence after which a PX4 has forgotten a transfer (`MAVLINK_MISSION_PROTOCOL_TIMEOUT_DEFAULT`).
pub(super) const FORGOTTEN_AFTER: Duration = Duration::from_secs(5);
/// Wait for an answer before asking again, when nothing is known of the link.
/// <https://mavlink.io/en/services/mission.html>, "Timeouts and Retries": 1500 ms.
pub(crate) const MESSAGE_TIMEOUT: Duration = Duration::from_millis(1500);

/// Wait for one item before asking again. Same place: 250 ms.
pub(crate) const ITEM_TIMEOUT: Duration = Duration::from_millis(250);

/// A vehicle from which nothing that concerns the transfer came for this long is gone. The mission protocol gives up
/// after 5 retries of 1500 ms (7.5 s); ArduPilot ends an upload 8 s after the last item. A bit longer than both, so
/// that it is the vehicle that ends first, and short enough to fail cleanly within 15 s (tests/faults, row 3). On a slow
/// link it is longer: [`RoundTrip::limit`].
pub(crate) const SILENCE_LIMIT: Duration = Duration::from_secs(10);

/// Another station's upload of which nothing is heard for this long has ended: ArduPilot gives one up 8 s after its
/// last item.
pub(crate) const UPLOAD_REST: Duration = Duration::from_secs(10);

/// A transfer that hears the vehicle but gets no further for this long is given up. With 30 % of all packets lost each
/// way ArduPilot's repeated requests (each second) get through with an item about every second time.
pub(crate) const PROGRESS_LIMIT: Duration = Duration::from_secs(30);

/// How often a transfer is begun anew before it is given up (tests/faults, row 1: at most 3).
pub(crate) const RESTARTS: u32 = 3;

/// ArduPlane reads its links in its main loop, 50 times a second (`SCHED_LOOP_RATE`): no answer comes faster than that.
pub(crate) const VEHICLE_TICK: Duration = Duration::from_millis(20);

/// ArduPilot asks again for an item that does not come after 1 s (`MissionItemProtocol::update`;
/// captures/mission-upload-abandoned.tlog).
///
/// It is this that makes an upload item by item slow on a bad link: each lost item or request costs the second, 36 % of
/// the items with 20 % loss each way. Sending an item again before it is asked for again would save half of that and is
/// not done: the copies that turn out to be needless are answered by MISSION_ACK with an error, in which a real refusal
/// would be lost, and one that is late enough is taken for an item of the next upload, that of another station
/// included. Plans go by file where they can, which is not slowed; `TransferConfig::item_window` is for who wants to
/// take that risk.
pub(crate) const REQUEST_REPEAT: Duration = Duration::from_millis(1000);

/// An upload in which the vehicle asks for nothing more is begun anew after this: six of ArduPilot's repeated requests
/// must have been lost, and the vehicle itself still waits (8 s). With 30 % lost each way four are lost once in 250
/// items, which took four attempts in one upload of 70; six once in 2,700.
pub(crate) const STALL_LIMIT: Duration = Duration::from_millis(7000);

/// The same request again within this time is a duplicate made by the link: no vehicle asks again as fast
/// (PX4 after 250 ms, ArduPilot after 1 s).
pub(crate) const DUPLICATE_WINDOW: Duration = Duration::from_millis(100);

/// A vehicle that answered MISSION_REQUEST_LIST but for this long no MISSION_REQUEST_INT, asked at least twice, does
/// not know it. Less than [`SILENCE_LIMIT`] leaves time for the older request.
pub(crate) const INTEGERS_IGNORED_AFTER: Duration = Duration::from_secs(2);

/// How often the first item must have been asked for before MISSION_ITEM_INT counts as not understood. ArduPlane 3.x
/// asks each second and gives up after 6 s.
pub(crate) const INTEGERS_IGNORED: u32 = 3;

/// Wait before asking again when another station is uploading.
pub(crate) const DENIED_WAIT: Duration = Duration::from_millis(1000);

/// Wait before asking a PX4 again that is in another upload. It ends one in which nothing came for 5 s
/// (`MAVLINK_MISSION_PROTOCOL_TIMEOUT_DEFAULT`), and each MISSION_COUNT that it refuses meanwhile counts
/// (v1.17.0, `MavlinkMissionManager::handle_mission_count`): who asks sooner keeps it busy. A little more, for jitter.
pub(crate) const BUSY_WAIT: Duration = Duration::from_millis(5500);

/// A vehicle that announces MAVFTP but answers nothing for this long has it switched off (`BRD_OPTIONS`).
pub(crate) const FTP_ABSENT_AFTER: Duration = Duration::from_secs(3);

/// ArduPilot closes a MAVFTP session that was idle for 3 s when another one asks (`FTP_SESSION_TIMEOUT`). Each of its
/// answers counts as activity, a refusal too: who asks sooner than after 3 s keeps the other one's session alive.
pub(crate) const FTP_BUSY_WAIT: Duration = Duration::from_millis(3200);

/// First wait for a MAVFTP answer when nothing is known of the link: the requests may be repeated without harm.
pub(crate) const FTP_FIRST_TIMEOUT: Duration = Duration::from_millis(500);

/// ArduPlane works off a MAVFTP request in 4 ms: its main loop runs each 20 ms and queues 5. A little slower, so that
/// jitter does not put a sixth into one turn: on ArduPlane 4.6.3 with 200 ms of delay, 4.0 ms lost up to 10 of 109
/// writes,
/// 4.4 ms two.
pub(crate) const FTP_REQUEST_SPACING: Duration = Duration::from_micros(4400);

/// MAVFTP requests that ArduPilot queues; a further one is dropped (`ObjectBuffer<pending_ftp>(5)`).
pub(crate) const FTP_QUEUE: usize = 5;

/// A parameter that the vehicle says nothing about for this long does not exist: older ArduPilots have no PARAM_ERROR.
/// Enough for four tries from [`PARAM_TIMEOUT`] on, each twice as long; on a slow link it is longer: [`RoundTrip::limit`].
pub(crate) const PARAM_ANSWER_LIMIT: Duration = Duration::from_secs(5);

/// First wait for one parameter's answer on an unknown link.
pub(crate) const PARAM_TIMEOUT: Duration = Duration::from_millis(500);

/// Shortest wait before asking again: three turns of the vehicle's main loop.
const MIN_TIMEOUT: Duration = Duration::from_millis(60);
/// Longest wait before asking again on an unknown link.
const MAX_UNKNOWN: Duration = Duration::from_millis(4000);
/// First waits for an answer within which nothing is given up: five tries, the others after twice the first wait. With
/// 20 % lost each way all five are lost once in 170.
const PATIENCE: u32 = 8;
/// Least allowance for variation: two turns of the main loop.
const MIN_VARIATION: Duration = Duration::from_millis(40);

/// The round trip as measured, and the timeout that follows from it (RFC 6298, with ArduPlane's 20 ms loop as the
/// granularity).
#[derive(Debug, Clone)]
pub(crate) struct RoundTrip {
    /// Smoothed round trip and its variation.
    estimate: Option<(Duration, Duration)>,
    /// Shortest round trip seen: the link without queues.
    least: Option<Duration>,
    /// Timeout while nothing is known.
    unknown: Duration,
    /// Doublings since the last answer that was certainly to a first request (Karn's algorithm).
    backoff: u32,
}

impl RoundTrip {
    pub(crate) fn new(known: Option<Duration>, unknown: Duration) -> Self {
        // TIMESYNC is answered by the same loop as everything else: its turn is in the measured time.
        let estimate = known.map(|round_trip| (round_trip.max(VEHICLE_TICK), round_trip / 4));
        Self { estimate, least: known, unknown, backoff: 0 }
    }

    /// An answer to a request that was sent once, with its round trip.
    pub(crate) fn sample(&mut self, took: Duration) {
        self.backoff = 0;
        self.least = Some(self.least.map_or(took, |least| least.min(took)));
        self.estimate = Some(match self.estimate {
            None => (took, took / 2),
            Some((smoothed, variation)) => {
                (smoothed * 7 / 8 + took / 8, variation * 3 / 4 + smoothed.abs_diff(took) / 4)
            }
        });
    }

    /// A request was not answered in time.
    pub(crate) fn timed_out(&mut self) {
        self.backoff = (self.backoff + 1).min(6);
    }

    /// How long to wait for the answer to a first request.
    pub(crate) fn first_timeout(&self) -> Duration {
        self.estimate.map_or(self.unknown, |(smoothed, variation)| {
            (smoothed + (variation * 4).max(MIN_VARIATION)).max(MIN_TIMEOUT)
        })
    }

    /// How long to wait for an answer now.
    pub(crate) fn timeout(&self) -> Duration {
        let first = self.first_timeout();
        let most = match self.estimate {
            None => MAX_UNKNOWN,
            // Four times the usual, on a slow link twice: enough to measure one whose delay has doubled. Longer waits cost
            // more where the answer was lost than they gain where it is late.
            Some(_) => (first * 4).clamp(2 * ITEM_TIMEOUT, MESSAGE_TIMEOUT.max(first * 2)),
        };
        (first * (1 << self.backoff)).min(most)
    }

    /// The time without an answer after which to give up: at least so long, and longer on a slow link.
    pub(crate) fn limit(&self, least: Duration) -> Duration {
        self.estimate.map_or(least, |_| least.max(self.first_timeout() * PATIENCE))
    }

    /// Shortest round trip seen.
    pub(crate) fn least(&self) -> Option<Duration> {
        self.least
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_timeout_follows_the_round_trip() {
        let ms = Duration::from_millis;
        let mut round_trip = RoundTrip::new(None, MESSAGE_TIMEOUT);
        assert_eq!(round_trip.timeout(), MESSAGE_TIMEOUT);
        round_trip.timed_out();
        assert_eq!(round_trip.timeout(), ms(3000));
        for _ in 0..50 {
            round_trip.sample(ms(200));
        }
        assert!((ms(235)..ms(260)).contains(&round_trip.timeout()), "{:?}", round_trip.timeout());
        let near = RoundTrip::new(Some(Duration::ZERO), MESSAGE_TIMEOUT);
        assert_eq!(near.timeout(), MIN_TIMEOUT);
        let mut slow = RoundTrip::new(Some(ms(2000)), MESSAGE_TIMEOUT);
        assert_eq!(slow.timeout(), ms(4000));
        slow.timed_out();
        assert_eq!(slow.timeout(), ms(8000));
        let mut far = RoundTrip::new(Some(ms(1000)), MESSAGE_TIMEOUT);
        for _ in 0..40 {
            far.timed_out();
        }
        assert_eq!(far.timeout(), ms(4000));
        let limits = [&near, &far, &RoundTrip::new(None, MESSAGE_TIMEOUT)].map(|link| link.limit(SILENCE_LIMIT));
        assert_eq!(limits, [SILENCE_LIMIT, ms(16_000), SILENCE_LIMIT]);
        // An answer that takes twice as long comes within the second wait.
        for least in [5, 100, 400, 1600, 2200] {
            let mut settled = RoundTrip::new(None, MESSAGE_TIMEOUT);
            (0..100).for_each(|_| settled.sample(ms(least)));
            settled.timed_out();
            assert!(settled.timeout() > 2 * ms(least), "{least} ms: {:?}", settled.timeout());
        }
    }
}
