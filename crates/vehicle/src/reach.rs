//! Whether the vehicle hears us: a link may work in one direction only, and telemetry does not show a dead uplink.
//!
//! Any answer shows that we are heard. TIMESYNC is sent every 2 s; when an answer of any kind is late, every
//! [`PROBE_PERIOD`]. A vehicle that is heard all that time, was asked [`QUESTIONS`] times and has answered
//! nothing for [`UNREACHED_AFTER`] is *heard but not reached*, until its next answer.
//!
//! With a share p of all frames lost each way a question stays unanswered with probability 1 − (1 − p)²: 0.36 for p =
//! 20 %, 0.51 for 30 %. A false alarm needs the first question and [`QUESTIONS`] more unanswered, 0.36¹³ = 2 in a
//! million or 0.51¹³ = 2 in ten thousand of the questions that are asked.
//!
//! While the vehicle is not heard, both directions may be dead: questions of that time do not count.

use std::time::Duration;

use vencejo_proto::MonoTime;

use crate::telemetry::LOST_AFTER;

/// Time without an answer after which a vehicle that is heard counts as not reached. Below the 5 s within which that
/// has to be reported (tests/faults, row 11), and after which an unanswered act is given up.
pub const UNREACHED_AFTER: Duration = Duration::from_millis(4_500);

/// Interval of questions while an answer is late.
const PROBE_PERIOD: Duration = Duration::from_millis(200);
/// Interval of questions while it is not reached.
const SEARCH_PERIOD: Duration = Duration::from_millis(500);
/// Questions without an answer, beside the first, before it counts as not reached.
const QUESTIONS: u32 = 12;
/// An answer is late after 1.25 round trips, within these bounds.
const PATIENCE: (Duration, Duration) = (Duration::from_millis(400), Duration::from_secs(3));
/// The same while the round trip is unknown.
const UNKNOWN_PATIENCE: Duration = Duration::from_millis(500);
/// A vehicle that was silent for longer was not heard in between; heartbeats come each second.
const HEARD_WITHIN: Duration = Duration::from_millis(1_500);
/// A transfer to a vehicle that is not reached is given up after this without an answer: time for [`QUESTIONS`], and
/// with what comes before short of 5 s.
const TRANSFER_GIVEN_UP_AFTER: Duration = Duration::from_millis(3_000);

/// A question to a vehicle that does not answer.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Probe {
    /// TIMESYNC.
    TimeSync,
    /// A command, for a vehicle too old for TIMESYNC.
    Command,
}

/// The state of the uplink to a vehicle.
#[derive(Debug, Default)]
pub(crate) struct Reach {
    answered_at: Option<MonoTime>,
    answers_timesync: bool,
    answers_commands: bool,
    /// The first question since the last answer, or since the vehicle was heard again.
    asked_since: Option<MonoTime>,
    probed_at: Option<MonoTime>,
    /// When it was last heard.
    heard_at: MonoTime,
    patience: Option<Duration>,
    is_unreached: bool,
}

impl Reach {
    /// A message that calls for an answer is sent.
    pub(crate) fn on_question(&mut self, now: MonoTime) {
        self.asked_since.get_or_insert(now);
    }

    /// TIMESYNC is sent. No answer is awaited from a vehicle that answers other messages, but never this one.
    pub(crate) fn on_timesync_asked(&mut self, now: MonoTime) {
        if self.answers_timesync || self.answered_at.is_none() {
            self.on_question(now);
        }
    }

    /// A message of the vehicle was received.
    pub(crate) fn on_heard(&mut self, now: MonoTime) {
        if now.since(self.heard_at) > HEARD_WITHIN && self.asked_since.is_some() {
            self.asked_since = Some(now);
        }
        self.heard_at = now;
    }

    /// It is no longer heard: whether it hears us is unknown.
    pub(crate) fn on_lost(&mut self) {
        self.is_unreached = false;
    }

    /// Our TIMESYNC was answered. Returns whether it was not reached before.
    pub(crate) fn on_timesync(&mut self, round_trip: Option<Duration>, now: MonoTime) -> bool {
        self.answers_timesync = true;
        self.patience = round_trip.map(|round_trip| (round_trip * 5 / 4).clamp(PATIENCE.0, PATIENCE.1));
        self.on_answer(now)
    }

    /// A command of ours was answered. Returns whether it was not reached before.
    pub(crate) fn on_command_answered(&mut self, now: MonoTime) -> bool {
        self.answers_commands = true;
        self.on_answer(now)
    }

    /// Anything of ours was answered. Returns whether it was not reached before.
    pub(crate) fn on_answer(&mut self, now: MonoTime) -> bool {
        self.answered_at = Some(now);
        self.asked_since = None;
        std::mem::take(&mut self.is_unreached)
    }

    /// Whether it hears us; `None` when unknown.
    pub(crate) fn is_reached(&self, now: MonoTime) -> Option<bool> {
        if self.is_unreached {
            return Some(false);
        }
        let answered = self.answered_at?;
        (self.asked_since.is_some() || now.since(answered) <= LOST_AFTER).then_some(true)
    }

    /// When a transfer that `began` then and was not answered has to be given up; `None` while the vehicle is reached.
    pub(crate) fn gives_up_at(&self, began: MonoTime) -> Option<MonoTime> {
        self.is_unreached.then_some(began + TRANSFER_GIVEN_UP_AFTER)
    }

    fn patience(&self) -> Duration {
        self.patience.unwrap_or(UNKNOWN_PATIENCE)
    }

    /// The suitable question for the vehicle, or for one `of_old` without TIMESYNC; `None` when it answers neither.
    fn probe(&self, of_old: bool) -> Option<Probe> {
        if self.answers_timesync || self.answered_at.is_none() {
            Some(Probe::TimeSync)
        } else {
            (of_old && self.answers_commands).then_some(Probe::Command)
        }
    }

    /// When [`Self::due_probe`] is wanted.
    pub(crate) fn probe_at(&self, of_old: bool) -> Option<MonoTime> {
        self.probe(of_old)?;
        let late = self.asked_since? + self.patience();
        let period = if self.is_unreached { SEARCH_PERIOD } else { PROBE_PERIOD };
        let at = self.probed_at.map_or(late, |probed| late.max(probed + period));
        // A vehicle that is not heard cannot be heard answering.
        (at <= self.heard_at + LOST_AFTER).then_some(at)
    }

    /// A question that is due because an answer is late.
    pub(crate) fn due_probe(&mut self, of_old: bool, now: MonoTime) -> Option<Probe> {
        self.probe_at(of_old).filter(|at| now >= *at)?;
        self.probed_at = Some(now);
        self.probe(of_old)
    }

    /// When [`Self::turns_unreached`] is wanted.
    pub(crate) fn verdict_at(&self, of_old: bool) -> Option<MonoTime> {
        if self.is_unreached {
            return None;
        }
        self.probe(of_old)?;
        let since = self.asked_since?;
        // The last question needs its time too.
        let asked = since + self.patience() * 2 + PROBE_PERIOD * (QUESTIONS - 1);
        let silent = self.answered_at.unwrap_or(since) + UNREACHED_AFTER;
        let at = asked.max(silent);
        (at <= self.heard_at + HEARD_WITHIN).then_some(at)
    }

    /// Whether it is found now not to be reached.
    pub(crate) fn turns_unreached(&mut self, of_old: bool, now: MonoTime) -> bool {
        let is_due = self.verdict_at(of_old).is_some_and(|at| now >= at);
        self.is_unreached |= is_due;
        is_due
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(ms: u64) -> MonoTime {
        MonoTime::from_millis(ms)
    }

    /// Heard each tenth of a second, and asked what is due; when it turned unreached.
    fn watch(reach: &mut Reach, of_old: bool, ms: std::ops::Range<u64>) -> Option<u64> {
        ms.step_by(100).find(|ms| {
            reach.on_heard(at(*ms));
            reach.due_probe(of_old, at(*ms));
            reach.turns_unreached(of_old, at(*ms))
        })
    }

    #[test]
    fn silence_after_a_question_is_told_in_time_and_ends_with_the_first_answer() {
        let mut reach = Reach::default();
        reach.on_heard(at(1_000));
        reach.on_timesync_asked(at(1_000));
        assert!(!reach.on_timesync(Some(Duration::from_millis(50)), at(1_050)));
        assert_eq!(reach.is_reached(at(1_100)), Some(true));
        reach.on_question(at(1_100));
        assert_eq!(watch(&mut reach, false, 1_100..9_000), Some(5_600));
        assert_eq!(reach.is_reached(at(5_600)), Some(false));
        assert_eq!(reach.gives_up_at(at(1_100)), Some(at(4_100)));
        assert!(reach.on_answer(at(5_700)), "news");
        assert_eq!(reach.is_reached(at(5_700)), Some(true));
        assert_eq!(reach.is_reached(at(60_000)), None, "nothing was asked for long");
    }

    #[test]
    fn twelve_questions_fit_whatever_the_round_trip() {
        for round_trip_ms in [0, 200, 500, 1_000, 2_000] {
            let mut reach = Reach::default();
            let round_trip = Duration::from_millis(round_trip_ms);
            reach.on_timesync(Some(round_trip), at(10_000));
            reach.on_question(at(11_900));
            // In time for an answer to arrive.
            let mut asked = Vec::new();
            for ms in 11_900..30_000 {
                reach.on_heard(at(ms));
                if reach.due_probe(false, at(ms)).is_some() {
                    asked.push(at(ms) + round_trip);
                }
                if reach.turns_unreached(false, at(ms)) {
                    asked.retain(|arrives| *arrives <= at(ms));
                    break;
                }
            }
            assert!(reach.is_unreached);
            assert!(asked.len() >= QUESTIONS as usize, "{round_trip_ms} ms: {}", asked.len());
        }
    }

    #[test]
    fn nothing_is_said_of_a_vehicle_that_is_not_heard() {
        let mut reach = Reach::default();
        reach.on_heard(at(1_000));
        reach.on_timesync(None, at(1_000));
        reach.on_question(at(1_100));
        assert_eq!(reach.verdict_at(false), None, "not heard for 1.5 s by then");
        for ms in 1_100..60_000 {
            reach.due_probe(false, at(ms));
            assert!(!reach.turns_unreached(false, at(ms)));
        }
        // Heard again: it gets the time of its own.
        let told = watch(&mut reach, false, 60_000..70_000).expect("told");
        assert!((63_000..=63_500).contains(&told), "{told}");
    }

    #[test]
    fn who_never_answers_timesync_is_asked_by_what_it_answers() {
        let mut reach = Reach::default();
        reach.on_heard(at(1_000));
        reach.on_answer(at(1_000));
        reach.on_timesync_asked(at(2_000));
        assert_eq!(watch(&mut reach, true, 2_000..30_000), None, "nothing that it answers was asked");
        // A command that it does not know, of one that answers plans alone.
        reach.on_question(at(30_000));
        assert_eq!(watch(&mut reach, true, 30_000..60_000), None);
        reach.on_command_answered(at(60_000));
        reach.on_question(at(60_100));
        assert_eq!(reach.due_probe(true, at(60_700)), Some(Probe::Command));
        assert_eq!(watch(&mut reach, false, 60_000..70_000), None, "nobody knows that this one is old");
        assert!(watch(&mut reach, true, 70_000..80_000).is_some());
    }
}
