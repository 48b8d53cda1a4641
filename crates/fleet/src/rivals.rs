//! Whether two computers speak as one aircraft: a copied card, or a name that was given twice. No I/O; time comes in.
//!
//! The station on board has another number each time that it starts, so that a new one is believed at once. It never has an earlier one again:
//! what an earlier one says after that is its last words, which the network has held back, or the word of another computer that is there
//! still. Its clock tells which.

use std::collections::VecDeque;
use std::time::Duration;

use vencejo_proto::MonoTime;

/// For so long after it spoke a computer counts as there: twice as long as the longest pause that one makes.
pub const THERE_FOR: Duration = Duration::from_secs(10);
/// How much longer one thing may be under way than another: what is made so soon after another boot began may be last words still.
pub const HELD_BACK: Duration = Duration::from_secs(1);
/// Earlier boots that are remembered of one aircraft.
const MAX_BOOTS: usize = 8;

/// A boot that was believed until another began.
#[derive(Debug)]
struct Rival {
    boot: u64,
    /// Its clock then, at least, ms. Whatever went before the other began is no later.
    clock_ms: u64,
    /// When it was heard last, but for last words.
    heard_at: MonoTime,
    /// Whether that was after the other began.
    is_there: bool,
    next_event: u64,
}

/// The boots of an aircraft before the one that is believed.
#[derive(Debug, Default)]
pub struct Rivals(VecDeque<Rival>);

impl Rivals {
    /// Another boot begins; this one was heard last at `heard_at`, and its clock is at `clock_ms` now, at least.
    pub fn put(&mut self, boot: u64, clock_ms: u64, heard_at: MonoTime, next_event: u64) {
        self.0.push_front(Rival { boot, clock_ms, heard_at, is_there: false, next_event });
        self.0.truncate(MAX_BOOTS);
    }

    /// A state of this boot came: whether the boot is an earlier one.
    pub fn on_state(&mut self, boot: u64, clock_ms: u64, now: MonoTime) -> bool {
        let Some(rival) = self.0.iter_mut().find(|rival| rival.boot == boot) else { return false };
        if Duration::from_millis(clock_ms.saturating_sub(rival.clock_ms)) > HELD_BACK {
            (rival.heard_at, rival.is_there) = (now, true);
        }
        true
    }

    /// Takes a boot that speaks back, to be believed again: the next event that was not heard of it.
    pub fn take(&mut self, boot: u64) -> Option<u64> {
        let place = self.0.iter().position(|rival| rival.boot == boot && rival.is_there)?;
        self.0.remove(place).map(|rival| rival.next_event)
    }

    /// Until when another computer counts as there, as far as is known; `None` where none does.
    pub fn there_until(&self, now: MonoTime) -> Option<MonoTime> {
        let there = self.0.iter().filter(|rival| rival.is_there).map(|rival| rival.heard_at);
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
    use crate::speech::{Listener, News};

    fn at(ms: u64) -> MonoTime {
        MonoTime::from_millis(ms)
    }

    /// A computer that says that it is in this mode.
    fn state(boot: u64, clock_ms: u64, events: u64) -> State {
        let mode = Heartbeat { custom_mode: u32::try_from(boot).expect("small"), ..Heartbeat::default() };
        let said = vec![Said::of_message(&Message::Heartbeat(mode))];
        State { boot, clock_ms, said, events, held: Some(Held::default()), ..State::default() }
    }

    fn shown(listener: &Listener) -> Option<u64> {
        listener.picture().map(|(boot, _)| boot)
    }

    #[test]
    fn a_station_that_starts_again_is_believed_and_its_last_words_are_those_of_before() {
        let mut listener = Listener::default();
        listener.on_state(&state(1, 50_000, 0), at(1_000));
        let news = listener.on_state(&state(2, 400, 0), at(4_000));
        assert_eq!((shown(&listener), news.said.len(), news.missed_from), (Some(2), 1, Some(1)));
        // It was said before the other began, whenever it comes.
        for late_ms in [4_010, 9_000, 60_000] {
            assert_eq!(listener.on_state(&state(1, 53_900, 0), at(late_ms)), News::default());
            assert_eq!((shown(&listener), listener.contested_until(at(late_ms))), (Some(2), None));
        }
    }

    #[test]
    fn two_computers_that_speak_as_one_aircraft_are_noticed_and_the_one_that_is_left_is_believed() {
        let mut listener = Listener::default();
        listener.on_state(&state(1, 50_000, 3), at(1_000));
        listener.on_state(&state(2, 7_000, 0), at(1_500));
        assert_eq!(listener.contested_until(at(1_500)), None, "as far as is known the first has started again");
        for turn in 3..20 {
            let now = at(turn * 1_000);
            assert_eq!(listener.on_state(&state(1, 49_000 + turn * 1_000, 3), now), News::default());
            assert_eq!(listener.on_everything(&state(1, 49_000 + turn * 1_000, 3), now), News::default());
            assert_eq!(listener.contested_until(now), Some(now + THERE_FOR));
            listener.on_state(&state(2, 5_500 + turn * 1_000, 0), now);
            assert_eq!((shown(&listener), listener.heard_at(1), listener.heard_at(2)), (Some(2), Some(now), Some(now)));
        }
        listener.on_state(&state(2, 40_000, 0), at(29_000));
        assert_eq!((shown(&listener), listener.contested_until(at(29_000))), (Some(2), None), "the first fell silent");
    }

    #[test]
    fn the_earlier_one_is_believed_again_when_the_later_one_has_gone() {
        let mut listener = Listener::default();
        listener.on_state(&state(1, 50_000, 0), at(1_000));
        listener.on_state(&state(2, 7_000, 0), at(1_500));
        let mut told = Vec::new();
        for turn in 3..13_u64 {
            let news = listener.on_state(&state(1, 49_000 + turn * 1_000, 5), at(turn * 1_000));
            told.push((news.said.len(), listener.contested_until(at(turn * 1_000)).is_some()));
        }
        assert_eq!(told, [[(0, true); 9].as_slice(), &[(1, false)]].concat());
        assert_eq!(shown(&listener), Some(1));
        assert!(listener.lacks_some(at(12_000)), "what it said meanwhile was not taken in");
        // The other one is back: it is the one of before now.
        listener.on_state(&state(2, 99_000, 0), at(13_000));
        assert_eq!((shown(&listener), listener.contested_until(at(13_000))), (Some(1), Some(at(23_000))));
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
