//! Detects two computers that use one aircraft name: a copied card, or a name enrolled twice. No I/O; time is passed
//! in.
//!
//! The station on board draws a random boot number at each start, so a new number mostly means a restart and is
//! followed at once. An earlier number never comes back: what still arrives under it was delayed by the network, or
//! comes from another computer that is still running. Its clock tells which. In the second case the newcomer was not a
//! restart: the first computer is followed again, and the newcomer is the rival until the first has been silent for
//! [`THERE_FOR`].

use std::collections::VecDeque;
use std::time::Duration;

use vencejo_proto::MonoTime;

/// How long after its last state a computer counts as present: twice the longest interval between states.
pub const THERE_FOR: Duration = Duration::from_secs(10);
/// The largest difference between the delays of two messages. A state made sooner than this after another boot began
/// may have been delayed.
pub const HELD_BACK: Duration = Duration::from_secs(1);
/// Most other boots remembered of one aircraft.
const MAX_BOOTS: usize = 8;

/// A boot that is not followed any more.
#[derive(Debug)]
struct Rival {
    boot: u64,
    /// A lower bound of its clock when another boot was followed in its place, ms. Delayed states are no later.
    clock_ms: u64,
    /// When it was heard last, delayed states aside.
    heard_at: MonoTime,
    /// Whether it is known to be a computer of its own, not one that has restarted.
    is_other: bool,
    next_event: u64,
}

/// What a state says about the boot that it is from.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Speaks {
    /// A boot that was not heard before.
    New,
    /// An earlier boot; the state was delayed.
    Late,
    /// Another computer than the one that is followed.
    Rival,
    /// The computer that was followed until just now: the boot after it was not its restart.
    First,
}

/// The boots of an aircraft besides the one that is followed.
#[derive(Debug, Default)]
pub struct Rivals(VecDeque<Rival>);

impl Rivals {
    /// Another boot is followed from now on; this one was heard last at `heard_at`, and its clock is at `clock_ms` now,
    /// at least. `is_other` when it is known to be another computer.
    pub fn put(&mut self, boot: u64, clock_ms: u64, heard_at: MonoTime, is_other: bool, next_event: u64) {
        self.0.push_front(Rival { boot, clock_ms, heard_at, is_other, next_event });
        self.0.truncate(MAX_BOOTS);
    }

    /// A state of this boot came, which is not the one that is followed.
    pub fn on_state(&mut self, boot: u64, clock_ms: u64, now: MonoTime) -> Speaks {
        let Some(rival) = self.0.iter_mut().find(|rival| rival.boot == boot) else { return Speaks::New };
        if Duration::from_millis(clock_ms.saturating_sub(rival.clock_ms)) <= HELD_BACK {
            return Speaks::Late;
        }
        let was_silent = now.since(std::mem::replace(&mut rival.heard_at, now));
        let was_followed = !std::mem::replace(&mut rival.is_other, true);
        if was_followed && was_silent < THERE_FOR { Speaks::First } else { Speaks::Rival }
    }

    /// Removes a boot that is followed again; the number of the next event of it that was not heard.
    pub fn take(&mut self, boot: u64) -> Option<u64> {
        let place = self.0.iter().position(|rival| rival.boot == boot)?;
        self.0.remove(place).map(|rival| rival.next_event)
    }

    /// Until when another computer counts as present; `None` if none is known to be.
    pub fn there_until(&self, now: MonoTime) -> Option<MonoTime> {
        let there = self.0.iter().filter(|rival| rival.is_other).map(|rival| rival.heard_at);
        Some(there.max()? + THERE_FOR).filter(|until| *until > now)
    }

    /// When this boot was heard last.
    pub fn heard_at(&self, boot: u64) -> Option<MonoTime> {
        self.0.iter().find(|rival| rival.boot == boot).map(|rival| rival.heard_at)
    }
}

#[cfg(test)]
mod tests {
    use vencejo_proto::{Heartbeat, Message};

    use super::*;
    use crate::payload::{Held, Said, State};
    use crate::state_source::{Listener, StateUpdate};

    fn at(ms: u64) -> MonoTime {
        MonoTime::from_millis(ms)
    }

    /// A computer that says that it is in this mode.
    fn state(boot: u64, clock_ms: u64, events: u64) -> State {
        let mode = Heartbeat { custom_mode: u32::try_from(boot).expect("small"), ..Heartbeat::default() };
        let said = [Said::of_message(&Message::Heartbeat(mode))];
        let mut state = State { boot, clock_ms, events, held: Some(Held::default()), ..State::default() };
        said.iter().for_each(|said| state.say(said));
        state
    }

    fn shown(listener: &Listener) -> Option<u64> {
        listener.stamp().map(|(boot, _)| boot)
    }

    #[test]
    fn a_station_that_starts_again_is_believed_and_its_last_words_are_those_of_before() {
        let mut listener = Listener::default();
        listener.on_state(&state(1, 50_000, 0), at(1_000));
        let news = listener.on_state(&state(2, 400, 0), at(4_000));
        assert_eq!((shown(&listener), news.said.len(), news.missed_from), (Some(2), 1, Some(1)));
        // It was said before the other began, whenever it comes.
        for late_ms in [4_010, 9_000, 60_000] {
            assert_eq!(listener.on_state(&state(1, 53_900, 0), at(late_ms)), StateUpdate::default());
            assert_eq!((shown(&listener), listener.contested_until(at(late_ms))), (Some(2), None));
        }
    }

    #[test]
    fn the_first_of_two_computers_is_followed_and_the_other_is_noticed() {
        let mut listener = Listener::default();
        listener.on_state(&state(1, 50_000, 3), at(1_000));
        listener.on_state(&state(2, 7_000, 0), at(1_500));
        assert_eq!(
            (shown(&listener), listener.contested_until(at(1_500))),
            (Some(2), None),
            "as far as is known the first has started again"
        );
        assert_eq!(listener.settled_at(), at(4_500));
        assert_eq!(
            listener.on_state(&state(1, 51_500, 3), at(2_500)),
            StateUpdate::default(),
            "that may have been delayed"
        );
        let news = listener.on_state(&state(1, 51_600, 3), at(2_600));
        assert_eq!((shown(&listener), news.said.len(), news.missed_from), (Some(1), 1, Some(1)), "it never went");
        assert_eq!(listener.settled_at(), at(2_600));
        assert_eq!(listener.contested_until(at(2_600)), Some(at(1_500) + THERE_FOR));
        for turn in 4..20 {
            let now = at(turn * 1_000);
            assert_eq!(listener.on_state(&state(2, 5_500 + turn * 1_000, 0), now), StateUpdate::default());
            assert_eq!(listener.on_everything(&state(2, 5_500 + turn * 1_000, 0), now), StateUpdate::default());
            assert_eq!(listener.contested_until(now), Some(now + THERE_FOR));
            listener.on_state(&state(1, 49_000 + turn * 1_000, 3), now);
            assert_eq!((shown(&listener), listener.heard_at(1), listener.heard_at(2)), (Some(1), Some(now), Some(now)));
        }
        listener.on_state(&state(1, 79_000, 0), at(29_000));
        assert_eq!((shown(&listener), listener.contested_until(at(29_000))), (Some(1), None), "the other fell silent");
    }

    #[test]
    fn the_other_computer_is_followed_when_the_first_has_gone() {
        let mut listener = Listener::default();
        for (boot, clock_ms, now_ms) in [(1, 50_000, 1_000), (2, 7_000, 1_500), (1, 52_000, 3_000)] {
            listener.on_state(&state(boot, clock_ms, 0), at(now_ms));
        }
        let mut told = Vec::new();
        for turn in 4..14_u64 {
            let news = listener.on_state(&state(2, 5_500 + turn * 1_000, 5), at(turn * 1_000));
            told.push((news.said.len(), listener.contested_until(at(turn * 1_000)).is_some()));
        }
        assert_eq!(told, [[(0, true); 9].as_slice(), &[(1, false)]].concat());
        assert_eq!(shown(&listener), Some(2));
        assert!(listener.lacks_some(at(13_000)), "what it said meanwhile was not taken in");
        // The first is back, after longer than anything is delayed: now it is the rival.
        listener.on_state(&state(1, 99_000, 0), at(14_000));
        assert_eq!((shown(&listener), listener.contested_until(at(14_000))), (Some(2), Some(at(24_000))));
    }

    #[test]
    fn a_computer_that_was_silent_when_another_began_does_not_displace_it() {
        let mut listener = Listener::default();
        listener.on_state(&state(1, 50_000, 0), at(1_000));
        listener.on_state(&state(2, 7_000, 0), at(9_000));
        listener.on_state(&state(2, 8_500, 0), at(10_500));
        listener.on_state(&state(1, 60_000, 0), at(11_000));
        assert_eq!((shown(&listener), listener.contested_until(at(11_000))), (Some(2), Some(at(21_000))));
    }

    #[test]
    fn a_computer_that_starts_again_and_again_is_no_other_one() {
        let mut listener = Listener::default();
        for boot in 1..100 {
            listener.on_state(&state(boot, 1_000, 0), at(boot * 3_000));
            assert_eq!((shown(&listener), listener.contested_until(at(boot * 3_000))), (Some(boot), None));
        }
        assert_eq!((listener.heard_at(99 - MAX_BOOTS as u64).is_some(), listener.heard_at(1)), (true, None));
    }
}
