//! One order on its way, from the ground: sent again with the same id until it is answered or given up. No I/O; time comes in.
//!
//! Silence is not a refusal: an order that met it may have been done. And "nobody is there", which a network says at once, is not
//! silence: that order did not arrive. Only what an aircraft answers is known.

use std::time::Duration;

use vencejo_proto::MonoTime;

use crate::payload::{Answer, End};

/// How long each attempt waits for its answer; the last again and again.
const WAITS: [Duration; 4] =
    [Duration::from_millis(500), Duration::from_secs(1), Duration::from_secs(2), Duration::from_secs(4)];
/// How long to wait when nobody was there: just after a network has healed it says so once more.
pub const AGAIN_AFTER: Duration = Duration::from_millis(200);
/// For how long nobody may be there.
const NOBODY_FOR: Duration = Duration::from_secs(2);

/// What to do next.
#[derive(Debug, Clone, PartialEq)]
pub enum Step {
    /// Wait, then send the order and wait for its answer.
    Send {
        /// How long to wait before.
        after: Duration,
        /// How long to wait for the answer.
        wait: Duration,
    },
    /// It is over.
    End(Outcome),
}

/// How it ended.
#[derive(Debug, Clone, PartialEq)]
pub enum Outcome {
    /// The aircraft's answer.
    Answered(Box<Answer>),
    /// It did not reach the aircraft: nothing was done.
    Unreached,
    /// Nobody knows: it may or may not have been done.
    Unknown {
        /// How often it was sent.
        attempts: u32,
    },
}

/// An order on its way.
#[derive(Debug)]
pub struct Errand {
    began: MonoTime,
    patience: Duration,
    attempts: u32,
    /// Whether it may have arrived.
    silent: bool,
}

impl Errand {
    /// One that is given up after `patience`.
    #[must_use]
    pub fn new(patience: Duration, now: MonoTime) -> Self {
        Self { began: now, patience, attempts: 0, silent: false }
    }

    /// The aircraft tells that it is at it: patience begins anew.
    pub fn on_sign(&mut self, at: MonoTime) {
        self.began = self.began.max(at);
    }

    /// The first step.
    #[must_use]
    pub fn start(&mut self) -> Step {
        self.send(Duration::ZERO)
    }

    /// The network said that nobody is there.
    #[must_use]
    pub fn on_nobody(&mut self, now: MonoTime) -> Step {
        let limit = if self.silent { self.patience } else { NOBODY_FOR.min(self.patience) };
        if now.since(self.began) >= limit { Step::End(self.unanswered()) } else { self.send(AGAIN_AFTER) }
    }

    /// No answer came in time.
    #[must_use]
    pub fn on_silence(&mut self, now: MonoTime) -> Step {
        self.silent = true;
        if now.since(self.began) >= self.patience { Step::End(self.unanswered()) } else { self.send(Duration::ZERO) }
    }

    /// The aircraft answered.
    #[must_use]
    pub fn on_answer(&mut self, answer: Answer) -> Outcome {
        // An attempt before this one may have been done and forgotten since.
        if answer.end() == End::Stale && self.silent {
            return self.unanswered();
        }
        Outcome::Answered(Box::new(answer))
    }

    fn unanswered(&self) -> Outcome {
        if self.silent { Outcome::Unknown { attempts: self.attempts } } else { Outcome::Unreached }
    }

    fn send(&mut self, after: Duration) -> Step {
        let wait = WAITS[(self.attempts as usize).min(WAITS.len() - 1)];
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
        let mut errand = Errand::new(PATIENCE, at(0));
        assert_eq!(errand.start(), Step::Send { after: Duration::ZERO, wait: WAITS[0] });
        assert_eq!(errand.on_answer(stale()), Outcome::Answered(Box::new(stale())), "it was refused: nothing was done");
    }

    #[test]
    fn silence_is_no_answer() {
        let mut errand = Errand::new(PATIENCE, at(0));
        let _ = errand.start();
        let mut waited = at(500);
        while let Step::Send { wait, .. } = errand.on_silence(waited) {
            waited += wait;
        }
        assert!(waited >= at(10_000) && waited <= at(14_000), "{waited}");
        assert_eq!(errand.on_silence(waited), Step::End(Outcome::Unknown { attempts: 5 }));
        let mut errand = Errand::new(PATIENCE, at(0));
        let _ = (errand.start(), errand.on_silence(at(500)));
        assert_eq!(errand.on_answer(stale()), Outcome::Unknown { attempts: 2 }, "the first may have been done");
    }

    #[test]
    fn what_goes_on_is_waited_for() {
        let mut errand = Errand::new(PATIENCE, at(0));
        let _ = (errand.start(), errand.on_silence(at(500)));
        errand.on_sign(at(9_000));
        errand.on_sign(at(3_000));
        assert!(matches!(errand.on_silence(at(18_999)), Step::Send { .. }));
        assert!(matches!(errand.on_silence(at(19_000)), Step::End(Outcome::Unknown { .. })));
    }

    #[test]
    fn nobody_there_means_that_nothing_was_done() {
        let mut errand = Errand::new(PATIENCE, at(0));
        let _ = errand.start();
        assert_eq!(
            errand.on_nobody(at(1)),
            Step::Send { after: AGAIN_AFTER, wait: WAITS[1] },
            "it may just have healed"
        );
        assert_eq!(errand.on_nobody(at(2_000)), Step::End(Outcome::Unreached));
        let mut errand = Errand::new(PATIENCE, at(0));
        let _ = (errand.start(), errand.on_silence(at(500)));
        assert!(matches!(errand.on_nobody(at(2_000)), Step::Send { .. }));
        assert_eq!(
            errand.on_nobody(at(10_000)),
            Step::End(Outcome::Unknown { attempts: 3 }),
            "the first may have arrived"
        );
    }
}
