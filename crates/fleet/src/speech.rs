//! What an aircraft says: the newest of each of its messages, again and again; and what must not be lost, numbered. No I/O; time comes in.

use std::collections::{BTreeMap, VecDeque};
use std::time::Duration;

use vencejo_proto::{Address, Frame, Message, MonoTime};

use crate::payload::{Event, Held, MAX_MESSAGES, Said, State, VERSION};
use crate::seal::{Picture, Seal};

/// Messages of which the newest is told: what a ground station shows. HEARTBEAT, SYS_STATUS, GPS_RAW_INT, ATTITUDE,
/// GLOBAL_POSITION_INT, MISSION_CURRENT, NAV_CONTROLLER_OUTPUT, VFR_HUD, BATTERY_STATUS, WIND, EKF_STATUS_REPORT, WIND_COV,
/// HOME_POSITION, EXTENDED_SYS_STATE, TERRAIN_REPORT, FENCE_STATUS.
pub const NEWEST: [u32; 16] = [0, 1, 24, 30, 33, 42, 62, 74, 136, 147, 162, 168, 193, 231, 242, 245];
/// Messages of which each one is told: MISSION_ITEM_REACHED, STATUSTEXT.
pub const EACH: [u32; 2] = [46, 253];
/// Messages of the second kind that are kept for whoever missed them.
pub const MAX_EVENTS: usize = 4096;

/// Collects what an autopilot says.
#[derive(Debug)]
pub struct Speaker {
    boot: u64,
    seal: Seal,
    autopilot: Address,
    newest: BTreeMap<u32, (Frame, MonoTime, bool)>,
    sequence: u64,
    events: VecDeque<Event>,
    numbered: u64,
}

impl Speaker {
    /// Nothing yet.
    #[must_use]
    pub fn new(boot: u64, autopilot: Address, seal: Seal) -> Self {
        Self { boot, seal, autopilot, newest: BTreeMap::new(), sequence: 0, events: VecDeque::new(), numbered: 0 }
    }

    /// The autopilot said something; gives the event that is to be told at once.
    pub fn on_frame(&mut self, frame: &Frame, at: MonoTime) -> Option<Event> {
        let id = frame.message_id();
        if frame.source() != self.autopilot {
            return None;
        }
        if NEWEST.contains(&id) {
            self.newest.insert(id, (frame.clone(), at, true));
            return None;
        }
        if !EACH.contains(&id) {
            return None;
        }
        self.numbered += 1;
        let event = Event {
            version: VERSION,
            boot: self.boot,
            number: self.numbered,
            clock_ms: millis(at.as_duration()),
            said: Some(Said::of(frame, 0)),
        };
        if self.events.len() == MAX_EVENTS {
            self.events.pop_front();
        }
        self.events.push_back(event.clone());
        Some(event)
    }

    /// What is new since the sample before.
    pub fn sample(&mut self, held: Held, now: MonoTime) -> State {
        self.state(held, now, true)
    }

    /// Everything, for whoever has just come.
    pub fn everything(&mut self, held: Held, now: MonoTime) -> State {
        self.state(held, now, false)
    }

    fn state(&mut self, held: Held, now: MonoTime, is_sample: bool) -> State {
        self.sequence += u64::from(is_sample);
        let mut said = Vec::new();
        for (frame, at, is_new) in self.newest.values_mut() {
            if !is_sample || *is_new {
                said.push(Said::of(frame, u32::try_from(now.since(*at).as_millis()).unwrap_or(u32::MAX)));
                *is_new &= !is_sample;
            }
        }
        said.truncate(MAX_MESSAGES);
        let clock_ms = millis(now.as_duration());
        State {
            version: VERSION,
            boot: self.boot,
            clock_ms,
            mark: self.seal.picture(clock_ms).mark,
            sequence: self.sequence,
            system: self.autopilot.system.0.into(),
            component: self.autopilot.component.0.into(),
            held: Some(held),
            said,
            events: self.numbered,
            ..State::default()
        }
    }

    /// The events from a number on, oldest first, as far as they are kept.
    pub fn events_from(&self, number: u64) -> impl Iterator<Item = &Event> {
        self.events.iter().filter(move |event| event.number >= number)
    }
}

/// Whole milliseconds.
#[must_use]
pub fn millis(time: Duration) -> u64 {
    u64::try_from(time.as_millis()).unwrap_or(u64::MAX)
}

/// Takes in what an aircraft says, on the ground.
#[derive(Debug, Default)]
pub struct Listener {
    boot: Option<u64>,
    clock_ms: u64,
    mark: u64,
    /// When that was, here.
    at: MonoTime,
    held: Held,
    /// Number of the next event that was not heard.
    next_event: u64,
    /// Number of the newest event that there is, as far as it was told.
    newest_event: u64,
}

/// What is new.
#[derive(Debug, Default, PartialEq)]
pub struct News {
    /// Messages and when they were said, by our clock, oldest first.
    pub said: Vec<(Message, MonoTime)>,
    /// Events that were missed: ask for those from here on.
    pub missed_from: Option<u64>,
}

impl Listener {
    /// A state came.
    pub fn on_state(&mut self, state: &State, now: MonoTime) -> News {
        let is_other = self.boot != Some(state.boot);
        if is_other {
            *self = Self { boot: Some(state.boot), next_event: 1, ..Self::default() };
        } else if state.clock_ms < self.clock_ms {
            // Overtaken by a later one.
            return News::default();
        }
        self.newest_event = self.newest_event.max(state.events);
        (self.clock_ms, self.mark, self.at) = (state.clock_ms, state.mark, now);
        self.held = state.held.clone().unwrap_or_default();
        let of = |said: &Said| Some((said.message()?, before(now, said.age_ms)));
        let mut said: Vec<_> =
            state.said.iter().filter(|said| NEWEST.contains(&said.message_id)).filter_map(of).collect();
        said.sort_by_key(|(_, at)| *at);
        News { said, missed_from: if is_other { Some(1) } else { self.missing() } }
    }

    /// An event came.
    pub fn on_event(&mut self, event: &Event, now: MonoTime) -> News {
        if self.boot != Some(event.boot) || event.number < self.next_event {
            return News::default();
        }
        self.newest_event = self.newest_event.max(event.number);
        if event.number > self.next_event {
            return News { said: Vec::new(), missed_from: Some(self.next_event) };
        }
        self.next_event += 1;
        let said = event.said.as_ref().filter(|said| EACH.contains(&said.message_id)).and_then(Said::message);
        News { said: said.map(|message| (message, now)).into_iter().collect(), missed_from: None }
    }

    /// The answer to a question for missed events has been heard to its end: what is missing still is gone.
    pub fn on_events_asked(&mut self, oldest: Option<u64>) {
        if let Some(oldest) = oldest {
            self.next_event = self.next_event.max(oldest);
        }
    }

    /// From which number on events are missing, where any are.
    #[must_use]
    pub fn missing(&self) -> Option<u64> {
        (self.boot.is_some() && self.newest_event >= self.next_event).then_some(self.next_event)
    }

    /// The boot and the newest picture; `None` before the first.
    #[must_use]
    pub fn picture(&self) -> Option<(u64, Picture)> {
        Some((self.boot?, Picture { at: MonoTime::from_millis(self.clock_ms), mark: self.mark }))
    }

    /// How old that picture is here, at least.
    #[must_use]
    pub fn age(&self, now: MonoTime) -> Duration {
        now.since(self.at)
    }

    /// Who may act, as far as it was told.
    #[must_use]
    pub fn held(&self) -> &Held {
        &self.held
    }
}

fn before(now: MonoTime, age_ms: u32) -> MonoTime {
    MonoTime::from_origin(now.as_duration().saturating_sub(Duration::from_millis(age_ms.into())))
}

#[cfg(test)]
mod tests {
    use vencejo_proto::{Header, Heartbeat, MavVersion, StatusText};

    use super::*;

    const PLANE: Address = Address::new(7, 1);

    fn at(ms: u64) -> MonoTime {
        MonoTime::from_millis(ms)
    }

    fn frame(message: &Message, source: Address) -> Frame {
        message.encode(Header { sequence: 0, source, version: MavVersion::V2 })
    }

    fn heartbeat(custom_mode: u32) -> Message {
        Message::Heartbeat(Heartbeat { custom_mode, ..Heartbeat::default() })
    }

    fn text(text: &str) -> Message {
        Message::StatusText(StatusText { severity: 4, text: text.into(), id: 0, chunk_seq: 0 })
    }

    fn speaker() -> Speaker {
        Speaker::new(1, PLANE, Seal::new(&[7; 32]))
    }

    #[test]
    fn the_newest_is_told_once_and_everything_to_a_newcomer() {
        let mut speaker = speaker();
        speaker.on_frame(&frame(&heartbeat(1), PLANE), at(1_000));
        speaker.on_frame(&frame(&heartbeat(2), PLANE), at(1_900));
        speaker.on_frame(&frame(&heartbeat(9), Address::new(7, 154)), at(1_950));
        let mut listener = Listener::default();
        let state = speaker.sample(Held::default(), at(2_000));
        let news = listener.on_state(&state, at(50_000));
        assert_eq!(news.said, [(heartbeat(2), at(49_900))], "with its age, by the clock here");
        let state = speaker.sample(Held::default(), at(2_100));
        assert_eq!(listener.on_state(&state, at(50_100)).said, []);
        assert_eq!(speaker.everything(Held::default(), at(2_100)).said.len(), 1);
        assert_eq!(listener.picture(), Some((1, Seal::new(&[7; 32]).picture(2_100))));
    }

    #[test]
    fn a_state_that_was_overtaken_is_not_believed() {
        let (mut speaker, mut listener) = (speaker(), Listener::default());
        let early = speaker.sample(Held { holder: "Ana".into(), ..Held::default() }, at(1_000));
        let late = speaker.sample(Held::default(), at(2_000));
        listener.on_state(&late, at(10));
        listener.on_state(&early, at(20));
        let picture = Seal::new(&[7; 32]).picture(2_000);
        assert_eq!((listener.held().holder.as_str(), listener.picture()), ("", Some((1, picture))));
    }

    #[test]
    fn a_missed_event_is_asked_for_and_none_is_told_twice() {
        let (mut speaker, mut listener) = (speaker(), Listener::default());
        listener.on_state(&speaker.sample(Held::default(), at(0)), at(0));
        let events: Vec<_> =
            ["a", "b", "c"].iter().filter_map(|word| speaker.on_frame(&frame(&text(word), PLANE), at(1))).collect();
        assert_eq!(listener.on_event(&events[0], at(1)).said, [(text("a"), at(1))]);
        assert_eq!(listener.on_event(&events[2], at(1)), News { said: vec![], missed_from: Some(2) });
        let told: Vec<_> = speaker.events_from(2).flat_map(|event| listener.on_event(event, at(2)).said).collect();
        assert_eq!(told, [(text("b"), at(2)), (text("c"), at(2))]);
        assert_eq!(listener.on_event(&events[2], at(3)), News::default());
    }

    #[test]
    fn an_event_after_which_none_came_is_missed_when_a_state_tells_of_it() {
        let (mut speaker, mut listener) = (speaker(), Listener::default());
        let missed = |listener: &mut Listener, state| listener.on_state(&state, at(0)).missed_from;
        assert_eq!(missed(&mut listener, speaker.sample(Held::default(), at(0))), Some(1), "by whoever has just come");
        assert_eq!(missed(&mut listener, speaker.sample(Held::default(), at(1))), None);
        let event = speaker.on_frame(&frame(&text("FAILSAFE"), PLANE), at(2)).expect("an event");
        assert_eq!(missed(&mut listener, speaker.sample(Held::default(), at(3))), Some(1));
        assert_eq!(missed(&mut listener, speaker.sample(Held::default(), at(4))), Some(1), "until it is heard");
        assert_eq!(listener.missing(), Some(1));
        listener.on_event(&event, at(5));
        assert_eq!(missed(&mut listener, speaker.sample(Held::default(), at(6))), None);
        assert_eq!(listener.missing(), None);
        // One that came while those before it were asked for is missing still.
        speaker.on_frame(&frame(&text("a"), PLANE), at(7)).expect("an event");
        let last = speaker.on_frame(&frame(&text("b"), PLANE), at(7)).expect("an event");
        assert_eq!(listener.on_event(&last, at(8)).missed_from, Some(2));
        assert_eq!(listener.missing(), Some(2));
    }

    #[test]
    fn what_is_not_kept_any_more_is_gone() {
        let (mut speaker, mut listener) = (speaker(), Listener::default());
        listener.on_state(&speaker.sample(Held::default(), at(0)), at(0));
        for _ in 0..MAX_EVENTS + 10 {
            speaker.on_frame(&frame(&text("x"), PLANE), at(1));
        }
        let oldest = speaker.events_from(1).next().expect("some are kept");
        assert_eq!(oldest.number, 11);
        listener.on_events_asked(Some(oldest.number));
        assert_eq!(listener.on_event(oldest, at(2)).said.len(), 1);
    }

    #[test]
    fn another_boot_begins_anew() {
        let mut listener = Listener::default();
        let mut first = speaker();
        assert_eq!(listener.on_state(&first.sample(Held::default(), at(9_000)), at(0)).missed_from, Some(1));
        let event = first.on_frame(&frame(&text("old"), PLANE), at(9_000)).expect("an event");
        listener.on_event(&event, at(0));
        let mut second = Speaker::new(2, PLANE, Seal::new(&[7; 32]));
        assert_eq!(listener.on_state(&second.sample(Held::default(), at(10)), at(0)).missed_from, Some(1));
        assert_eq!(listener.picture(), Some((2, Seal::new(&[7; 32]).picture(10))));
        assert_eq!(listener.on_event(&event, at(0)), News::default(), "of the boot before");
        let event = second.on_frame(&frame(&text("new"), PLANE), at(10)).expect("an event");
        assert_eq!(listener.on_event(&event, at(0)).said.len(), 1);
    }
}
