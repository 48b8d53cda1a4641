//! The number of MAVFTP requests in flight, and their pace.

use std::time::Duration;

use vencejo_proto::MonoTime;

use crate::transfer::timing::{FTP_QUEUE, FTP_REQUEST_SPACING, RoundTrip, VEHICLE_TICK};

/// Most requests in flight.
const MAX_WINDOW: usize = 64;
/// Least number of requests in flight that keeps a slow line busy.
const MIN_WINDOW: usize = 2;
/// A round trip this much above twice the shortest means that requests wait in a queue.
const QUEUEING: Duration = Duration::from_millis(60);

/// Paces requests to one that works off five in each turn of a 20 ms loop and drops a sixth.
///
/// Up to five are sent at once: with no delay on the link their answers let the next five go, right in time for the
/// next turn. With a delay, as many more as the vehicle works off in that time, evenly spaced. When round trips grow,
/// the line is the bottleneck and fewer are kept on the way (as in delay-based congestion control; loss says nothing
/// here).
#[derive(Debug)]
pub(super) struct Pace {
    /// Requests at once, if the line is thinner than the vehicle is fast.
    limit: usize,
    /// Vehicles other than ArduPilot are asked one thing at a time.
    pipelined: bool,
    next_at: MonoTime,
}

impl Pace {
    pub(super) fn new(pipelined: bool) -> Self {
        Self { limit: MAX_WINDOW, pipelined, next_at: MonoTime::ZERO }
    }

    fn window(&self, round_trip: &RoundTrip) -> usize {
        if !self.pipelined {
            return 1;
        }
        let delay = round_trip.least().unwrap_or_default().saturating_sub(VEHICLE_TICK);
        let on_the_way = (delay.as_micros() / FTP_REQUEST_SPACING.as_micros()) as usize;
        (FTP_QUEUE + on_the_way).min(self.limit)
    }

    /// Whether another request may be sent now, with this many in flight.
    pub(super) fn may_send(&self, on_the_way: usize, round_trip: &RoundTrip, now: MonoTime) -> bool {
        on_the_way < self.window(round_trip) && (on_the_way < FTP_QUEUE || now >= self.next_at)
    }

    /// When the next request may be sent; `None` when an answer must come first.
    pub(super) fn next_at(&self, on_the_way: usize, round_trip: &RoundTrip) -> Option<MonoTime> {
        (on_the_way < self.window(round_trip)).then_some(self.next_at)
    }

    pub(super) fn sent(&mut self, now: MonoTime) {
        // A timer that fires late is caught up with, but not by more than one request.
        let earliest = MonoTime::ZERO + now.as_duration().saturating_sub(FTP_REQUEST_SPACING);
        self.next_at = self.next_at.max(earliest) + FTP_REQUEST_SPACING;
    }

    /// A request sent once was answered after this round trip.
    pub(super) fn answered(&mut self, took: Duration, on_the_way: usize, round_trip: &RoundTrip) {
        let least = round_trip.least().unwrap_or(took).max(VEHICLE_TICK);
        if took > 2 * least + QUEUEING {
            self.limit = self.limit.min(on_the_way.max(1) * 7 / 8).max(MIN_WINDOW);
        } else {
            self.limit = (self.limit + 1).min(MAX_WINDOW);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::transfer::timing::FTP_FIRST_TIMEOUT;

    #[test]
    fn the_window_is_what_the_vehicle_works_off_in_a_round_trip() {
        let known = |ms| RoundTrip::new(Some(Duration::from_millis(ms)), FTP_FIRST_TIMEOUT);
        let pace = Pace::new(true);
        assert_eq!(pace.window(&RoundTrip::new(None, FTP_FIRST_TIMEOUT)), 5);
        assert_eq!(pace.window(&known(0)), 5);
        let far = pace.window(&known(200));
        assert!((44..=48).contains(&far), "{far}");
        assert_eq!(pace.window(&known(5000)), MAX_WINDOW);
        assert_eq!(Pace::new(false).window(&known(200)), 1);
    }

    #[test]
    fn a_queue_on_the_line_narrows_the_window() {
        let round_trip = RoundTrip::new(Some(Duration::from_millis(40)), FTP_FIRST_TIMEOUT);
        let mut pace = Pace::new(true);
        for _ in 0..20 {
            pace.answered(Duration::from_millis(600), 10, &round_trip);
        }
        assert_eq!(pace.window(&round_trip), 8);
        for _ in 0..20 {
            pace.answered(Duration::from_millis(600), 3, &round_trip);
        }
        assert_eq!(pace.window(&round_trip), MIN_WINDOW);
        for _ in 0..80 {
            pace.answered(Duration::from_millis(50), 3, &round_trip);
        }
        assert!(pace.window(&round_trip) > 5);
    }

    #[test]
    fn requests_behind_the_first_five_are_spaced() {
        let round_trip = RoundTrip::new(Some(Duration::from_millis(200)), FTP_FIRST_TIMEOUT);
        let mut pace = Pace::new(true);
        let mut now = MonoTime::from_millis(1000);
        for on_the_way in 0..5 {
            assert!(pace.may_send(on_the_way, &round_trip, now));
            pace.sent(now);
        }
        let mut sent = 5;
        while now < MonoTime::from_millis(1100) {
            now += Duration::from_micros(500);
            if pace.may_send(sent, &round_trip, now) {
                pace.sent(now);
                sent += 1;
            }
        }
        assert!((20..=30).contains(&sent), "{sent} in 100 ms");
    }
}
