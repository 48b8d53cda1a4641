//! TIMESYNC both ways: answers the vehicle's, and measures the round trip and notices restarts with ours.
//!
//! Protocol: mavlink.io, "Time Synchronization Protocol v2". A request has `tc1` 0 and our time in `ts1`; the answer
//! has the vehicle's time in `tc1` and our `ts1` back. Times are nanoseconds.

use std::collections::VecDeque;
use std::time::Duration;

use vencejo_proto::dialect::{MavMessage, TIMESYNC_DATA};
use vencejo_proto::{Address, Message, MonoTime};

/// How often the round trip is measured.
pub const TIMESYNC_PERIOD: Duration = Duration::from_secs(2);
/// Requests whose answers are still awaited; older ones are given up. As many as are sent within [`MAX_ROUND_TRIP`]
/// when answers are late ([`crate::UNREACHED_AFTER`]).
const MAX_OUTSTANDING: usize = 64;
/// An answer that took longer is ignored.
const MAX_ROUND_TRIP: Duration = Duration::from_secs(10);
/// How far rounding may set the vehicle's clock back between two answers.
const BACK_TOLERANCE_NS: i64 = 500_000_000;

/// The meaning of a TIMESYNC message.
#[derive(Debug, Clone, PartialEq)]
#[allow(clippy::large_enum_variant, reason = "moved once, from the queue to the link")]
pub enum TimeSyncEvent {
    /// A request of the vehicle: send this.
    Answer(Message),
    /// The vehicle answered.
    Measured {
        /// From sending to answer.
        round_trip: Duration,
        /// Whether the vehicle's clock is behind its earlier answers: it restarted.
        has_gone_back: bool,
    },
}

/// Time synchronisation with one vehicle.
#[derive(Debug)]
pub struct TimeSync {
    our: Address,
    vehicle: Address,
    next: MonoTime,
    outstanding: VecDeque<i64>,
    round_trip: Option<Duration>,
    newest_vehicle_ns: Option<i64>,
}

impl TimeSync {
    /// Between `our` and `vehicle`; the first request is due at once.
    pub fn new(our: Address, vehicle: Address, now: MonoTime) -> Self {
        Self { our, vehicle, next: now, outstanding: VecDeque::new(), round_trip: None, newest_vehicle_ns: None }
    }

    /// Round trip, smoothed over about eight measurements (RFC 6298, SRTT).
    pub fn round_trip(&self) -> Option<Duration> {
        self.round_trip
    }

    /// Reads a message. `None`: it is not for us.
    pub fn on_message(&mut self, message: &TIMESYNC_DATA, now: MonoTime) -> Option<TimeSyncEvent> {
        if message.tc1 == 0 {
            let is_for_us = (message.target_system == 0 || message.target_system == self.our.system.0)
                && (message.target_component == 0 || message.target_component == self.our.component.0);
            return is_for_us.then(|| TimeSyncEvent::Answer(self.message(our_ns(now), message.ts1)));
        }
        // Ours by its time alone: PX4 v1.17 leaves what was in its memory as the target (`mavlink_timesync.cpp`).
        let index = self.outstanding.iter().position(|sent_ns| *sent_ns == message.ts1)?;
        let sent_ns = self.outstanding[index];
        // Answers to older requests are obsolete.
        self.outstanding.drain(..=index);
        let round_trip = Duration::from_nanos(u64::try_from(our_ns(now) - sent_ns).ok()?);
        if round_trip > MAX_ROUND_TRIP {
            return None;
        }
        self.round_trip = Some(self.round_trip.map_or(round_trip, |smoothed| (smoothed * 7 + round_trip) / 8));
        let has_gone_back =
            self.newest_vehicle_ns.is_some_and(|newest| message.tc1 < newest.saturating_sub(BACK_TOLERANCE_NS));
        self.newest_vehicle_ns = Some(message.tc1);
        Some(TimeSyncEvent::Measured { round_trip, has_gone_back })
    }

    /// Forgets the vehicle's clock, after a restart that was noticed elsewhere.
    pub fn forget_clock(&mut self) {
        self.newest_vehicle_ns = None;
    }

    /// A request, when one is due.
    pub fn on_time(&mut self, now: MonoTime) -> Option<Message> {
        (now >= self.next).then(|| self.ask(now))
    }

    /// A request, before its time.
    pub fn ask(&mut self, now: MonoTime) -> Message {
        self.next = now + TIMESYNC_PERIOD;
        if self.outstanding.len() == MAX_OUTSTANDING {
            self.outstanding.pop_front();
        }
        // 0 would look like no time at all.
        let sent_ns = our_ns(now).max(1);
        self.outstanding.push_back(sent_ns);
        self.message(0, sent_ns)
    }

    /// When [`Self::on_time`] is wanted.
    pub fn deadline(&self) -> MonoTime {
        self.next
    }

    fn message(&self, tc1: i64, ts1: i64) -> Message {
        Message::Dialect(MavMessage::TIMESYNC(TIMESYNC_DATA {
            tc1,
            ts1,
            target_system: self.vehicle.system.0,
            target_component: self.vehicle.component.0,
        }))
    }
}

fn our_ns(now: MonoTime) -> i64 {
    i64::try_from(now.as_duration().as_nanos()).unwrap_or(i64::MAX)
}

#[cfg(test)]
mod tests {
    use super::*;

    const OUR: Address = Address::new(255, 190);

    fn sync() -> TimeSync {
        TimeSync::new(OUR, Address::new(1, 1), at(1_000))
    }

    fn at(ms: u64) -> MonoTime {
        MonoTime::from_millis(ms)
    }

    fn data(message: Message) -> TIMESYNC_DATA {
        match message {
            Message::Dialect(MavMessage::TIMESYNC(data)) => data,
            other => panic!("{other:?}"),
        }
    }

    fn answer(request: &TIMESYNC_DATA, vehicle_ms: i64) -> TIMESYNC_DATA {
        TIMESYNC_DATA { tc1: vehicle_ms * 1_000_000, ts1: request.ts1, target_system: 0, target_component: 0 }
    }

    #[test]
    fn the_round_trip_is_measured() {
        let mut sync = sync();
        let request = data(sync.on_time(at(1_000)).expect("due"));
        assert_eq!((request.tc1, request.ts1), (0, 1_000_000_000));
        assert_eq!(sync.on_time(at(1_001)), None);
        let event = sync.on_message(&answer(&request, 50_020), at(1_040));
        assert_eq!(
            event,
            Some(TimeSyncEvent::Measured { round_trip: Duration::from_millis(40), has_gone_back: false })
        );
        assert_eq!(sync.on_message(&answer(&request, 50_020), at(1_050)), None, "a repeated answer counts once");
        assert_eq!(sync.deadline(), at(3_000));
    }

    #[test]
    fn the_vehicles_requests_are_answered() {
        let request = TIMESYNC_DATA { tc1: 0, ts1: 109_024_706_001, target_system: 0, target_component: 0 };
        let Some(TimeSyncEvent::Answer(answer)) = sync().on_message(&request, at(7)) else { panic!("no answer") };
        let answer = data(answer);
        assert_eq!((answer.tc1, answer.ts1, answer.target_system), (7_000_000, 109_024_706_001, 1));
        let other = TIMESYNC_DATA { target_system: 254, ..request };
        assert_eq!(sync().on_message(&other, at(7)), None);
    }

    #[test]
    fn answers_to_others_are_ignored_and_a_restart_is_seen() {
        let mut sync = sync();
        let first = data(sync.on_time(at(1_000)).expect("due"));
        let foreign = TIMESYNC_DATA { ts1: 5, ..answer(&first, 90_000) };
        assert_eq!(sync.on_message(&foreign, at(1_010)), None);
        sync.on_message(&answer(&first, 90_000), at(1_010)).expect("ours");
        let second = data(sync.on_time(at(3_000)).expect("due"));
        let event = sync.on_message(&answer(&second, 1_500), at(3_010));
        assert!(matches!(event, Some(TimeSyncEvent::Measured { has_gone_back: true, .. })), "{event:?}");
    }

    #[test]
    fn an_answer_is_ours_by_its_time_whatever_its_target() {
        let mut sync = sync();
        let request = data(sync.on_time(at(1_000)).expect("due"));
        // As a PX4 answered.
        let answer = TIMESYNC_DATA { target_system: 255, target_component: 255, ..answer(&request, 50_020) };
        assert!(matches!(sync.on_message(&answer, at(1_040)), Some(TimeSyncEvent::Measured { .. })));
        let other = TIMESYNC_DATA { ts1: request.ts1 + 1, ..answer };
        assert_eq!(sync.on_message(&other, at(1_050)), None);
    }

    #[test]
    fn silence_does_not_pile_up() {
        let mut sync = sync();
        for n in 0..1_000 {
            sync.on_time(at(1_000 + n * 2_000)).expect("due");
        }
        assert!(sync.outstanding.len() <= MAX_OUTSTANDING);
    }
}
