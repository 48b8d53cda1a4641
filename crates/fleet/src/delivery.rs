//! Delivery of one order from the ground: resent with the same id until it is answered or given up. No I/O; time is
//! passed in.
//!
//! No answer is not a refusal: the order may have been executed. "No receiver", which the network reports at once, is
//! not silence: that order did not arrive. Only an aircraft's answer is certain.

use std::time::Duration;

use vencejo_proto::MonoTime;

use crate::payload::{Answer, End};
use crate::rivals::HELD_BACK;

/// After how long without an answer the order is sent again, at least; the last again and again.
const WAITS: [Duration; 4] =
    [Duration::from_millis(500), Duration::from_secs(1), Duration::from_secs(2), Duration::from_secs(4)];
/// The slowest answer that counts for the way: a slower one waited for a network. Two thirds of the longest wait.
const SLOWEST: Duration = Duration::from_millis(2_700);
/// How long to wait when there was no receiver: the network reports that once more just after it has healed.
pub const AGAIN_AFTER: Duration = Duration::from_millis(200);
/// How long there may be no receiver.
const NOBODY_FOR: Duration = Duration::from_secs(2);

/// What to do next.
#[derive(Debug, Clone, PartialEq)]
pub enum Step {
    /// Wait, then send the order and wait for an answer, to this attempt or to an earlier one.
    Send {
        /// How long to wait before.
        after: Duration,
        /// How long to wait for the answer.
        wait: Duration,
    },
    /// It has ended.
    End(Outcome),
}

/// How it ended.
#[derive(Debug, Clone, PartialEq)]
pub enum Outcome {
    /// The aircraft's answer.
    Answered(Box<Answer>),
    /// It did not reach the aircraft: nothing was done.
    Unreached,
    /// Unknown: it may or may not have been done.
    Unknown {
        /// How often it was sent.
        attempts: u32,
        /// Time since it was sent, or since its last sign of life.
        waited: Duration,
    },
}

/// How long answers take that are given at once: the slowest, which counts less with each one after it.
#[derive(Debug, Clone, Copy, Default)]
pub struct RoundTrip(Duration);

impl RoundTrip {
    /// An answer took this long.
    pub fn on_answer(&mut self, took: Duration) {
        let took = took.min(SLOWEST);
        self.0 = took.max((self.0 * 7 + took) / 8);
    }

    /// The least time after which an answer is late.
    fn late(self) -> Duration {
        (self.0 * 3 / 2).min(WAITS[WAITS.len() - 1])
    }
}

/// An order being delivered.
#[derive(Debug, Clone)]
pub struct OrderDelivery {
    began: MonoTime,
    patience: Duration,
    late: Duration,
    attempts: u32,
    /// Whether it may have arrived.
    silent: bool,
    /// When it was sent for the first time that may have arrived.
    sent_at: MonoTime,
}

impl OrderDelivery {
    /// A delivery that is given up after `patience`; zero: sent once, and waited for as long as any.
    pub fn new(patience: Duration, round_trip: RoundTrip, now: MonoTime) -> Self {
        Self { began: now, patience, late: round_trip.late(), attempts: 0, silent: false, sent_at: now }
    }

    /// A progress report restarts the timeout.
    pub fn on_sign(&mut self, at: MonoTime) {
        self.began = self.began.max(at);
    }

    /// The first step.
    #[must_use]
    pub fn start(&mut self) -> Step {
        self.send(Duration::ZERO, self.began)
    }

    /// The network reported that there is no receiver.
    #[must_use]
    pub fn on_nobody(&mut self, now: MonoTime) -> Step {
        let limit = if self.silent { self.patience } else { NOBODY_FOR.min(self.patience) };
        if now.since(self.began) >= limit { Step::End(self.unanswered(now)) } else { self.send(AGAIN_AFTER, now) }
    }

    /// No answer came in time.
    #[must_use]
    pub fn on_silence(&mut self, now: MonoTime) -> Step {
        self.silence(Duration::ZERO, now)
    }

    /// The aircraft answered; the boot that the order is for was heard last at `heard_at`.
    #[must_use]
    pub fn on_answer(&mut self, mut answer: Answer, heard_at: MonoTime, now: MonoTime) -> Step {
        if answer.end() == End::Unknown && answer.boot_age_ms > 0 {
            let age = Duration::from_millis(answer.boot_age_ms);
            if heard_at + age > now + HELD_BACK {
                // Both run: another computer uses this aircraft's name, and does not know what the addressed one does.
                return self.silence(AGAIN_AFTER, now);
            }
            if age >= now.since(self.sent_at) {
                // The addressed run had ended when it was sent for the first time: nothing was done.
                answer.set_end(End::Stale);
                return Step::End(Outcome::Answered(Box::new(answer)));
            }
        }
        Step::End(Outcome::Answered(Box::new(answer)))
    }

    fn silence(&mut self, after: Duration, now: MonoTime) -> Step {
        self.silent = true;
        let is_over = now.since(self.began) >= self.patience;
        if is_over { Step::End(self.unanswered(now)) } else { self.send(after, now) }
    }

    fn unanswered(&self, now: MonoTime) -> Outcome {
        if self.silent {
            Outcome::Unknown { attempts: self.attempts, waited: now.since(self.began) }
        } else {
            Outcome::Unreached
        }
    }

    fn send(&mut self, after: Duration, now: MonoTime) -> Step {
        if !self.silent {
            self.sent_at = now + after;
        }
        let longest = WAITS.len() - 1;
        let wait = WAITS[(self.attempts as usize).min(longest)].max(self.late);
        // Each renewal is sent once: it shows a way that has become slow.
        let wait = if self.patience.is_zero() { WAITS[longest] } else { wait.min(self.patience) };
        self.attempts += 1;
        Step::Send { after, wait }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const PATIENCE: Duration = Duration::from_secs(10);

    fn at(ms: u64) -> MonoTime {
        MonoTime::from_millis(ms)
    }

    fn stale() -> Answer {
        Answer { end: End::Stale.into(), ..Answer::default() }
    }

    #[test]
    fn an_answer_is_an_answer() {
        let mut delivery = OrderDelivery::new(PATIENCE, RoundTrip::default(), at(0));
        assert_eq!(delivery.start(), Step::Send { after: Duration::ZERO, wait: WAITS[0] });
        assert_eq!(
            delivery.on_answer(stale(), at(0), at(600)),
            Step::End(Outcome::Answered(Box::new(stale()))),
            "it was refused: nothing was done"
        );
    }

    #[test]
    fn silence_is_no_answer() {
        let mut delivery = OrderDelivery::new(PATIENCE, RoundTrip::default(), at(0));
        let _ = delivery.start();
        let mut waited = at(500);
        while let Step::Send { wait, .. } = delivery.on_silence(waited) {
            waited += wait;
        }
        assert!(waited >= at(10_000) && waited <= at(14_000), "{waited}");
        let unknown = Outcome::Unknown { attempts: 5, waited: waited.since(at(0)) };
        assert_eq!(delivery.on_silence(waited), Step::End(unknown));
        let mut delivery = OrderDelivery::new(PATIENCE, RoundTrip::default(), at(0));
        let _ = (delivery.start(), delivery.on_silence(at(500)));
        assert_eq!(
            delivery.on_answer(stale(), at(0), at(600)),
            Step::End(Outcome::Answered(Box::new(stale()))),
            "none was done: on board they would know"
        );
    }

    #[test]
    fn what_takes_long_is_not_asked_again_before_it_can_be_answered() {
        let mut round_trip = RoundTrip::default();
        let wait = |round_trip| match OrderDelivery::new(PATIENCE, round_trip, at(0)).start() {
            Step::Send { wait, .. } => wait,
            Step::End(end) => panic!("{end:?}"),
        };
        round_trip.on_answer(Duration::from_millis(100));
        assert_eq!(wait(round_trip), WAITS[0]);
        round_trip.on_answer(Duration::from_millis(1_600));
        assert_eq!(wait(round_trip), Duration::from_millis(2_400));
        round_trip.on_answer(Duration::from_millis(800));
        assert_eq!(wait(round_trip), Duration::from_millis(2_250), "one may be as slow again");
        (0..40).for_each(|_| round_trip.on_answer(Duration::from_millis(100)));
        assert_eq!(wait(round_trip), WAITS[0], "it was another way");
        round_trip.on_answer(Duration::from_secs(60));
        assert_eq!(wait(round_trip), WAITS[3]);
        (0..4).for_each(|_| round_trip.on_answer(Duration::from_millis(100)));
        assert!(wait(round_trip) < Duration::from_millis(2_500), "a cut is no round trip");
    }

    #[test]
    fn an_order_that_is_sent_once_is_waited_for_and_a_short_patience_is_kept() {
        let mut slow = RoundTrip::default();
        slow.on_answer(Duration::from_secs(15));
        let start = |patience, round_trip| OrderDelivery::new(patience, round_trip, at(0)).start();
        let send = |wait| Step::Send { after: Duration::ZERO, wait };
        assert_eq!(start(Duration::ZERO, RoundTrip::default()), send(WAITS[3]));
        assert_eq!(start(Duration::from_millis(500), slow), send(Duration::from_millis(500)));
    }

    fn of_boot(boot_age_ms: u64) -> Answer {
        Answer { end: End::Unknown.into(), boot_age_ms, ..Answer::default() }
    }

    #[test]
    fn what_another_computer_of_that_name_says_is_no_answer() {
        let mut delivery = OrderDelivery::new(PATIENCE, RoundTrip::default(), at(0));
        let _ = delivery.start();
        // Each of them says that it has run for an hour; the one that was meant was heard just now.
        let other = || of_boot(3_600_000);
        let again = delivery.on_answer(other(), at(0), at(40));
        assert_eq!(again, Step::Send { after: AGAIN_AFTER, wait: WAITS[1] });
        let done = Answer { end: End::Done.into(), ..Answer::default() };
        let ended = delivery.clone().on_answer(done.clone(), at(300), at(400));
        assert_eq!(ended, Step::End(Outcome::Answered(Box::new(done))));
        let mut given_up = delivery.clone();
        let _ = given_up.on_answer(other(), at(9_000), at(9_500));
        let unknown = Outcome::Unknown { attempts: 3, waited: PATIENCE };
        assert_eq!(given_up.on_answer(other(), at(9_500), at(10_000)), Step::End(unknown));
        // It was heard soon after the other one began: these may be its last words.
        let ended = delivery.on_answer(of_boot(1_000), at(9_400), at(9_500));
        assert!(matches!(ended, Step::End(Outcome::Answered(answer)) if answer.end() == End::Unknown));
    }

    #[test]
    fn what_met_a_station_that_had_started_before_was_not_done() {
        let end = |delivery: &mut OrderDelivery, age_ms, now| match delivery.on_answer(of_boot(age_ms), at(0), at(now))
        {
            Step::End(Outcome::Answered(answer)) => answer.end(),
            other => panic!("{other:?}"),
        };
        let mut delivery = OrderDelivery::new(PATIENCE, RoundTrip::default(), at(0));
        let _ = delivery.start();
        assert_eq!(end(&mut delivery.clone(), 40, 40), End::Stale, "it ran before that was sent");
        assert_eq!(end(&mut delivery.clone(), 39, 40), End::Unknown, "the one before may have been there still");
        assert_eq!(end(&mut delivery.clone(), 0, 40), End::Unknown, "the autopilot did not answer");
        let mut again = delivery.clone();
        let _ = (again.on_nobody(at(1)), again.on_nobody(at(202)));
        assert_eq!(end(&mut again, 10, 410), End::Stale, "twice nobody was there");
        let _ = delivery.on_silence(at(500));
        assert_eq!(end(&mut delivery.clone(), 400, 600), End::Unknown, "the first may have been done before");
        assert_eq!(end(&mut delivery, 600, 600), End::Stale, "the same one was there all along");
    }

    #[test]
    fn what_goes_on_is_waited_for() {
        let mut delivery = OrderDelivery::new(PATIENCE, RoundTrip::default(), at(0));
        let _ = (delivery.start(), delivery.on_silence(at(500)));
        delivery.on_sign(at(9_000));
        delivery.on_sign(at(3_000));
        assert!(matches!(delivery.on_silence(at(18_999)), Step::Send { .. }));
        let end = delivery.on_silence(at(19_000));
        assert!(matches!(end, Step::End(Outcome::Unknown { waited: PATIENCE, .. })), "{end:?}");
    }

    #[test]
    fn nobody_there_means_that_nothing_was_done() {
        let mut delivery = OrderDelivery::new(PATIENCE, RoundTrip::default(), at(0));
        let _ = delivery.start();
        assert_eq!(
            delivery.on_nobody(at(1)),
            Step::Send { after: AGAIN_AFTER, wait: WAITS[1] },
            "it may just have healed"
        );
        assert_eq!(delivery.on_nobody(at(2_000)), Step::End(Outcome::Unreached));
        let mut delivery = OrderDelivery::new(PATIENCE, RoundTrip::default(), at(0));
        let _ = (delivery.start(), delivery.on_silence(at(500)));
        assert!(matches!(delivery.on_nobody(at(2_000)), Step::Send { .. }));
        assert_eq!(
            delivery.on_nobody(at(10_000)),
            Step::End(Outcome::Unknown { attempts: 3, waited: PATIENCE }),
            "the first may have arrived"
        );
    }
}
