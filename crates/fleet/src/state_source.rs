//! The states of an aircraft: the newest of each of its messages, repeatedly, and numbered events that must not be
//! lost; their source on board and the listener on the ground. No I/O; time is passed in.

use std::collections::{BTreeMap, VecDeque};
use std::time::Duration;

use vencejo_proto::{Address, Frame, Message, MonoTime};
use vencejo_station::Silence;
use vencejo_vehicle::telemetry::LOST_AFTER;

use crate::payload::{Event, Held, Said, State, VERSION};
use crate::rivals::{HELD_BACK, Rivals, Speaks, THERE_FOR};
use crate::stamp::{Stamper, StateStamp};

/// Messages of which the newest is sent: what a ground station shows. HEARTBEAT, SYS_STATUS, GPS_RAW_INT, ATTITUDE,
/// GLOBAL_POSITION_INT, MISSION_CURRENT, NAV_CONTROLLER_OUTPUT, VFR_HUD, BATTERY_STATUS, WIND, EKF_STATUS_REPORT,
/// WIND_COV, HOME_POSITION, EXTENDED_SYS_STATE, TERRAIN_REPORT, FENCE_STATUS.
pub const NEWEST: [u32; 16] = [0, 1, 24, 30, 33, 42, 62, 74, 136, 147, 162, 168, 193, 231, 242, 245];
/// Those that are in each state for a list, if they are new: HEARTBEAT, GLOBAL_POSITION_INT, VFR_HUD.
const QUICK: [u32; 3] = [0, 33, 74];
/// The least time between two of another message in states for a list: in every second one, of which the age stays below
/// that at which it is shown as stale ([`vencejo_vehicle::telemetry::STALE_AFTER`]).
const SPARING: Duration = Duration::from_millis(1_500);
/// Who has control is sent again after this, where it has not changed.
const HELD_AGAIN: Duration = Duration::from_secs(1);
/// The links of a silent autopilot are sent again after this.
const LINKS_AGAIN: Duration = Duration::from_secs(10);
/// Those that show the effect of an act: HEARTBEAT, MISSION_CURRENT, EXTENDED_SYS_STATE.
const EFFECTS: [u32; 3] = [0, 42, 245];
/// Messages of which each one is sent: MISSION_ITEM_REACHED, STATUSTEXT.
pub const EACH: [u32; 2] = [ITEM_REACHED, 253];
const ITEM_REACHED: u32 = 46;
/// Older MISSION_ITEM_REACHED are dropped on the ground: they may be of another mission than the one that is known.
const REACHED_WITHIN: Duration = Duration::from_secs(10);
/// Most events kept for stations that missed them.
pub const MAX_EVENTS: usize = 4096;
/// The least time between two requests for everything after lost samples: a sample has two messages, everything
/// sixteen, and samples are mostly lost on a full uplink.
const EVERYTHING_AGAIN: Duration = Duration::from_secs(10);
/// Most events in one answer: some 5 KB, which delay other messages little.
pub const MAX_ANSWERED: usize = 64;

/// Collects the messages of an autopilot, on board.
#[derive(Debug)]
pub struct StateSource {
    boot: u64,
    stamper: Stamper,
    autopilot: Address,
    newest: BTreeMap<u32, Newest>,
    /// Who had control in the last sample that has it, and when that was made.
    held: Option<(Held, MonoTime)>,
    /// When the autopilot was last heard and its links in words, while it is silent.
    silence: Option<(MonoTime, String)>,
    /// When a sample last had the links.
    links_at: Option<MonoTime>,
    sequence: u64,
    events: VecDeque<Event>,
    numbered: u64,
}

/// The newest of one message.
#[derive(Debug)]
struct Newest {
    frame: Frame,
    at: MonoTime,
    /// Whether no sample has it.
    is_new: bool,
    /// When a sample had one last.
    sampled: Option<MonoTime>,
}

/// What a state has.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Extent {
    Everything,
    New,
    Sparing,
    Effects,
}

impl StateSource {
    /// A source without messages.
    pub fn new(boot: u64, autopilot: Address, stamper: Stamper) -> Self {
        Self {
            boot,
            stamper,
            autopilot,
            newest: BTreeMap::new(),
            held: None,
            silence: None,
            links_at: None,
            sequence: 0,
            events: VecDeque::new(),
            numbered: 0,
        }
    }

    /// The autopilot is silent: when it was last heard, and its links in words; `None` when it is heard.
    pub fn on_silence(&mut self, silence: Option<(MonoTime, String)>) {
        self.links_at.take_if(|_| silence.is_none());
        self.silence = silence;
    }

    /// Adds a message of the autopilot; returns the event to send at once, if it is one.
    pub fn on_frame(&mut self, frame: &Frame, at: MonoTime) -> Option<Event> {
        let id = frame.message_id();
        if frame.source() != self.autopilot {
            return None;
        }
        if NEWEST.contains(&id) {
            let sampled = self.newest.get(&id).and_then(|newest| newest.sampled);
            self.newest.insert(id, Newest { frame: frame.clone(), at, is_new: true, sampled });
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
            kept_from: 0,
        };
        if self.events.len() == MAX_EVENTS {
            self.events.pop_front();
        }
        self.events.push_back(event.clone());
        Some(event)
    }

    /// What is new since the sample before.
    pub fn sample(&mut self, held: Held, now: MonoTime) -> State {
        self.state(held, now, Extent::New)
    }

    /// The same for a list: of most messages less often.
    pub fn sparing(&mut self, held: Held, now: MonoTime) -> State {
        self.state(held, now, Extent::Sparing)
    }

    /// Everything, for new subscribers.
    pub fn everything(&mut self, held: Held, now: MonoTime) -> State {
        self.state(held, now, Extent::Everything)
    }

    /// What shows the effect of an act that has ended now.
    pub fn effects(&mut self, held: Held, now: MonoTime) -> State {
        self.state(held, now, Extent::Effects)
    }

    fn state(&mut self, held: Held, now: MonoTime, extent: Extent) -> State {
        let is_sample = matches!(extent, Extent::New | Extent::Sparing);
        self.sequence += u64::from(is_sample);
        let clock_ms = millis(now.as_duration());
        let mut state = State {
            version: VERSION,
            boot: self.boot,
            clock_ms,
            mark: self.stamper.stamp(clock_ms).mark,
            sequence: self.sequence,
            system: self.autopilot.system.0.into(),
            component: self.autopilot.component.0.into(),
            events: self.numbered,
            ..State::default()
        };
        for (id, newest) in &mut self.newest {
            let is_due = match extent {
                Extent::Everything => true,
                Extent::Effects => EFFECTS.contains(id),
                Extent::Sparing if !QUICK.contains(id) => {
                    newest.is_new && newest.sampled.is_none_or(|at| now.since(at) >= SPARING)
                }
                Extent::New | Extent::Sparing => newest.is_new,
            };
            if is_due {
                let age_ms = u32::try_from(now.since(newest.at).as_millis()).unwrap_or(u32::MAX);
                state.say(&Said::of(&newest.frame, age_ms));
                if is_sample {
                    (newest.is_new, newest.sampled) = (false, Some(now));
                }
            }
        }
        let is_known = |(known, at): &(Held, MonoTime)| *known == held && now.since(*at) < HELD_AGAIN;
        if !is_sample || !self.held.as_ref().is_some_and(is_known) {
            if is_sample {
                self.held = Some((held.clone(), now));
            }
            state.held = Some(held);
        }
        if let Some((since, links)) = &self.silence {
            state.silent_since_ms = Some(millis(since.as_duration()));
            if !is_sample || self.links_at.is_none_or(|at| now.since(at) >= LINKS_AGAIN) {
                state.links.clone_from(links);
                self.links_at = if is_sample { Some(now) } else { self.links_at };
            }
        }
        state
    }

    /// The events from a number on: oldest first, as far as they are kept, at most [`MAX_ANSWERED`].
    pub fn events_from(&self, number: u64) -> impl Iterator<Item = Event> {
        let kept_from = self.events.front().map_or(0, |oldest| oldest.number);
        let wanted = self.events.iter().filter(move |event| event.number >= number).take(MAX_ANSWERED);
        wanted.map(move |event| Event { kept_from, ..event.clone() })
    }
}

/// Whole milliseconds.
pub fn millis(time: Duration) -> u64 {
    u64::try_from(time.as_millis()).unwrap_or(u64::MAX)
}

/// Receives the states of an aircraft, on the ground.
#[derive(Debug, Default)]
pub struct Listener {
    boot: Option<u64>,
    clock_ms: u64,
    mark: u64,
    /// When that was heard, by our clock.
    at: MonoTime,
    held: Held,
    /// Since when its autopilot is silent, by the clock on board, ms, and its links in words.
    silence: Option<(u64, String)>,
    /// Number of the next event that was not heard.
    next_event: u64,
    /// Number of the newest event known to exist.
    newest_event: u64,
    /// When each message that was heard came, by the clock on board, ms.
    heard: BTreeMap<u32, u64>,
    /// Numbers of the first and the last of the newest samples between which none is missing.
    run: Option<(u64, u64)>,
    /// The number of the sample that the last complete state covers, and when it came.
    told: Option<(u64, MonoTime)>,
    /// The other boots.
    rivals: Rivals,
    /// The time between the last two samples.
    interval: Duration,
    /// When it is clear whether this boot is a restart of the one before, or another computer.
    settled_at: MonoTime,
}

/// The news of a state or event.
#[derive(Debug, Default, PartialEq)]
pub struct StateUpdate {
    /// Messages and when they were sent, by our clock, oldest first.
    pub said: Vec<(Message, MonoTime)>,
    /// The first missed event, from which on events are to be requested.
    pub missed_from: Option<u64>,
}

impl Listener {
    /// Processes the reply to a request for everything.
    pub fn on_everything(&mut self, state: &State, now: MonoTime) -> StateUpdate {
        let Some(news) = self.take_in(state, now) else { return StateUpdate::default() };
        self.told = Some((state.sequence.max(self.told.map_or(0, |(number, _)| number)), now));
        news
    }

    /// Processes a sample.
    pub fn on_state(&mut self, state: &State, now: MonoTime) -> StateUpdate {
        let before = (self.boot, self.clock_ms);
        let Some(news) = self.take_in(state, now) else { return StateUpdate::default() };
        if before.0 == self.boot {
            self.interval = Duration::from_millis(self.clock_ms.saturating_sub(before.1));
        }
        self.run = match self.run {
            Some((first, last)) if state.sequence <= last.saturating_add(1) => Some((first, last.max(state.sequence))),
            _ => Some((state.sequence, state.sequence)),
        };
        news
    }

    /// Processes what an answer of the followed boot has of its state, which says nothing about lost samples.
    pub fn on_effects(&mut self, state: &State, now: MonoTime) -> StateUpdate {
        let news = if self.boot == Some(state.boot) { self.take_in(state, now) } else { None };
        news.map(|news| StateUpdate { missed_from: None, ..news }).unwrap_or_default()
    }

    /// A state of another boot than the one that is followed came; whether that boot is followed from now on.
    fn turns_to(&mut self, state: &State, now: MonoTime) -> bool {
        let speaks = self.rivals.on_state(state.boot, state.clock_ms, now);
        match speaks {
            Speaks::New | Speaks::First => {}
            Speaks::Rival if self.age(now) >= THERE_FOR => {}
            Speaks::Rival | Speaks::Late => return false,
        }
        let mut rivals = std::mem::take(&mut self.rivals);
        let next_event = rivals.take(state.boot).unwrap_or(1);
        if let Some(boot) = self.boot {
            let clock_ms = self.clock_ms.saturating_add(millis(self.age(now)));
            rivals.put(boot, clock_ms, self.at, speaks != Speaks::New, self.next_event);
        }
        // Until then the one before may say that it never went.
        let is_doubtful = speaks == Speaks::New && self.boot.is_some() && self.age(now) < THERE_FOR;
        let settled_at =
            if is_doubtful { now + 2 * HELD_BACK + self.interval.clamp(HELD_BACK, THERE_FOR) } else { now };
        *self = Self { boot: Some(state.boot), next_event, rivals, settled_at, ..Self::default() };
        true
    }

    /// `None` for a state of a boot that is not followed.
    fn take_in(&mut self, state: &State, now: MonoTime) -> Option<StateUpdate> {
        let is_other = self.boot != Some(state.boot);
        if is_other && !self.turns_to(state, now) {
            return None;
        }
        // A state that a later one has overtaken is not shown, but may have messages that were not heard otherwise.
        if state.clock_ms >= self.clock_ms {
            (self.clock_ms, self.mark, self.at) = (state.clock_ms, state.mark, now);
            if let Some(held) = &state.held {
                self.held.clone_from(held);
            }
            let known = self.silence.take().map(|(_, links)| links).filter(|_| state.links.is_empty());
            let links = known.unwrap_or_else(|| state.links.clone());
            self.silence = state.silent_since_ms.map(|since_ms| (since_ms, links));
        }
        self.newest_event = self.newest_event.max(state.events);
        let mut said = Vec::new();
        for told in state.said().filter(|said| NEWEST.contains(&said.message_id)) {
            let came_ms = state.clock_ms.saturating_sub(told.age_ms.into());
            let is_newer = self.heard.get(&told.message_id).is_none_or(|heard_ms| came_ms >= *heard_ms);
            if let Some(message) = told.message().filter(|_| is_newer) {
                self.heard.insert(told.message_id, came_ms);
                said.push((message, self.moment(came_ms, now)));
            }
        }
        said.sort_by_key(|(_, at)| *at);
        Some(StateUpdate { said, missed_from: if is_other { Some(self.next_event) } else { self.missing() } })
    }

    /// Processes an event.
    pub fn on_event(&mut self, event: &Event, now: MonoTime) -> StateUpdate {
        if self.boot != Some(event.boot) || event.number < self.next_event {
            return StateUpdate::default();
        }
        self.newest_event = self.newest_event.max(event.number);
        if event.number > self.next_event {
            return StateUpdate { said: Vec::new(), missed_from: Some(self.next_event) };
        }
        self.next_event = event.number.saturating_add(1);
        let at = self.moment(event.clock_ms, now);
        let is_told = |id| EACH.contains(&id) && (id != ITEM_REACHED || now.since(at) <= REACHED_WITHIN);
        let said = event.said.as_ref().filter(|said| is_told(said.message_id)).and_then(Said::message);
        StateUpdate { said: said.map(|message| (message, at)).into_iter().collect(), missed_from: None }
    }

    /// Processes the reply to a request for events, or what was not lost of it: gaps are to be requested again.
    pub fn on_events(&mut self, mut events: Vec<Event>, now: MonoTime) -> Vec<(Message, MonoTime)> {
        events.retain(|event| self.boot == Some(event.boot));
        events.sort_by_key(|event| event.number);
        if let Some(oldest) = events.first() {
            // An earlier version does not report which events it keeps: take the oldest that came.
            let told = events.iter().map(|event| event.kept_from).max().filter(|kept_from| *kept_from > 0);
            self.pass_over(told.unwrap_or(oldest.number));
        }
        events.iter().flat_map(|event| self.on_event(event, now).said).collect()
    }

    /// Skips the events before this one, which are not available.
    pub fn pass_over(&mut self, number: u64) {
        self.next_event = self.next_event.max(number);
    }

    /// Whether to request everything: a sample has only what is new, and some samples were lost. Not again at once.
    pub fn lacks_some(&self, now: MonoTime) -> bool {
        let Some((told, at)) = self.told else { return self.boot.is_some() };
        self.run.is_some_and(|(first, _)| first > told.saturating_add(1)) && now.since(at) >= EVERYTHING_AGAIN
    }

    /// The first missing event, if any.
    pub fn missing(&self) -> Option<u64> {
        (self.boot.is_some() && self.newest_event >= self.next_event).then_some(self.next_event)
    }

    /// The boot and the stamp of the newest state; `None` before the first.
    pub fn stamp(&self) -> Option<(u64, StateStamp)> {
        Some((self.boot?, StateStamp { at: MonoTime::from_millis(self.clock_ms), mark: self.mark }))
    }

    /// Until when another computer with this aircraft's name counts as present; `None` if there is none.
    pub fn contested_until(&self, now: MonoTime) -> Option<MonoTime> {
        self.rivals.there_until(now)
    }

    /// When it is clear whether the followed boot is a restart of the one before, or another computer.
    pub fn settled_at(&self) -> MonoTime {
        self.settled_at
    }

    /// When this boot was heard last.
    pub fn heard_at(&self, boot: u64) -> Option<MonoTime> {
        if self.boot == Some(boot) { Some(self.at) } else { self.rivals.heard_at(boot) }
    }

    /// The age of the newest state, at least.
    pub fn age(&self, now: MonoTime) -> Duration {
        now.since(self.at)
    }

    /// The silence of its autopilot, by the newest state; `None` if the station on board is silent too.
    pub fn silence(&self, now: MonoTime) -> Option<Silence> {
        let (since_ms, links) = self.silence.as_ref().filter(|_| self.age(now) < LOST_AFTER)?;
        let lasts = Duration::from_millis(self.clock_ms.saturating_sub(*since_ms)) + self.age(now);
        Some(Silence { lasts, links: links.clone() })
    }

    /// Who may act, by the newest state.
    pub fn held(&self) -> &Held {
        &self.held
    }

    /// Converts a time of the clock on board to ours, by the newest state.
    fn moment(&self, clock_ms: u64, now: MonoTime) -> MonoTime {
        let later = Duration::from_millis(clock_ms.saturating_sub(self.clock_ms));
        let earlier = Duration::from_millis(self.clock_ms.saturating_sub(clock_ms));
        MonoTime::from_origin((self.at.as_duration() + later).saturating_sub(earlier)).min(now)
    }
}

#[cfg(test)]
mod tests {
    use prost::Message as _;
    use vencejo_proto::dialect::{
        BATTERY_STATUS_DATA, HOME_POSITION_DATA, MISSION_ITEM_REACHED_DATA, MavMessage, VFR_HUD_DATA,
    };
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

    fn source() -> StateSource {
        StateSource::new(1, PLANE, Stamper::new(&[7; 32]))
    }

    #[test]
    fn the_newest_is_told_once_and_everything_to_a_newcomer() {
        let mut source = source();
        source.on_frame(&frame(&heartbeat(1), PLANE), at(1_000));
        source.on_frame(&frame(&heartbeat(2), PLANE), at(1_900));
        source.on_frame(&frame(&heartbeat(9), Address::new(7, 154)), at(1_950));
        let mut listener = Listener::default();
        let state = source.sample(Held::default(), at(2_000));
        let news = listener.on_state(&state, at(50_000));
        assert_eq!(news.said, [(heartbeat(2), at(49_900))], "with its age, by the clock here");
        let state = source.sample(Held::default(), at(2_100));
        assert_eq!(listener.on_state(&state, at(50_100)).said, []);
        assert_eq!(source.everything(Held::default(), at(2_100)).message_ids, [0]);
        assert_eq!(listener.stamp(), Some((1, Stamper::new(&[7; 32]).stamp(2_100))));
    }

    #[test]
    fn a_list_is_told_most_messages_in_every_second_state_and_of_a_holder_who_has_changed() {
        let mut source = source();
        let vfr_hud = Message::Dialect(MavMessage::VFR_HUD(VFR_HUD_DATA::default()));
        let battery = Message::Dialect(MavMessage::BATTERY_STATUS(BATTERY_STATUS_DATA::default()));
        let ana = Held { holder: "Ana".into(), ..Held::default() };
        let mut told = Vec::new();
        for second in 1..=4 {
            for message in [&vfr_hud, &battery] {
                source.on_frame(&frame(message, PLANE), at(second * 1_000));
            }
            let state = source.sparing(ana.clone(), at(second * 1_000));
            told.push((state.message_ids, state.held.is_some()));
        }
        let (some, all) = (vec![74], vec![74, 147]);
        assert_eq!(told, [(all.clone(), true), (some.clone(), true), (all, true), (some, true)]);
        source.on_frame(&frame(&battery, PLANE), at(4_050));
        let state = source.sample(ana.clone(), at(4_100));
        assert_eq!((state.message_ids, state.held), (vec![147], None), "who has control is told all there is");
        let mut listener = Listener::default();
        listener.on_state(&source.sample(ana.clone(), at(5_000)), at(0));
        listener.on_state(&source.sample(ana.clone(), at(5_100)), at(100));
        assert_eq!(listener.held(), &ana);
        listener.on_state(&source.sample(Held::default(), at(5_200)), at(200));
        assert_eq!(listener.held(), &Held::default());
    }

    #[test]
    fn the_silence_of_an_autopilot_is_told_as_long_as_it_lasts_and_costs_little() {
        let (mut source, mut listener) = (source(), Listener::default());
        source.on_frame(&frame(&heartbeat(1), PLANE), at(1_000));
        let spoken = source.sparing(Held::default(), at(1_000));
        listener.on_state(&spoken, at(51_000));
        assert_eq!(listener.silence(at(51_000)), None);
        let silence =
            |lasts_ms, links: &str| Some(Silence { lasts: Duration::from_millis(lasts_ms), links: links.into() });
        source.on_silence(Some((at(1_000), "ttyS0 (open)".into())));
        let mut links = Vec::new();
        for second in 6..=20 {
            let state = source.sparing(Held::default(), at(second * 1_000));
            assert!(state.encoded_len() < spoken.encoded_len() + 30, "{}", state.encoded_len());
            links.extend((!state.links.is_empty()).then_some(second));
            if second != 6 {
                listener.on_state(&state, at(50_000 + second * 1_000));
            }
        }
        assert_eq!(links, [6, 16]);
        assert_eq!(listener.silence(at(70_500)), silence(19_500, "ttyS0 (open)"));
        assert_eq!(listener.silence(at(75_000)), None, "the network is cut: nothing is known of the autopilot");
        source.on_silence(Some((at(1_000), "ttyS0 (not open)".into())));
        let mut newcomer = Listener::default();
        newcomer.on_everything(&source.everything(Held::default(), at(21_000)), at(1_000));
        assert_eq!(newcomer.silence(at(1_000)), silence(20_000, "ttyS0 (not open)"));
        source.on_silence(None);
        listener.on_state(&source.sparing(Held::default(), at(22_000)), at(72_000));
        assert_eq!(listener.silence(at(72_000)), None);
    }

    #[test]
    fn a_state_that_was_overtaken_is_not_believed() {
        let (mut source, mut listener) = (source(), Listener::default());
        let early = source.sample(Held { holder: "Ana".into(), ..Held::default() }, at(1_000));
        let late = source.sample(Held::default(), at(2_000));
        listener.on_state(&late, at(10));
        listener.on_state(&early, at(20));
        let picture = Stamper::new(&[7; 32]).stamp(2_000);
        assert_eq!((listener.held().holder.as_str(), listener.stamp()), ("", Some((1, picture))));
    }

    #[test]
    fn a_missed_event_is_asked_for_and_none_is_told_twice() {
        let (mut source, mut listener) = (source(), Listener::default());
        listener.on_state(&source.sample(Held::default(), at(0)), at(0));
        let events: Vec<_> =
            ["a", "b", "c"].iter().filter_map(|word| source.on_frame(&frame(&text(word), PLANE), at(1))).collect();
        assert_eq!(listener.on_event(&events[0], at(1)).said, [(text("a"), at(1))]);
        assert_eq!(listener.on_event(&events[2], at(1)), StateUpdate { said: vec![], missed_from: Some(2) });
        let told = listener.on_events(source.events_from(2).collect(), at(2));
        assert_eq!(told, [(text("b"), at(1)), (text("c"), at(1))]);
        assert_eq!(listener.on_event(&events[2], at(3)), StateUpdate::default());
    }

    #[test]
    fn an_event_after_which_none_came_is_missed_when_a_state_tells_of_it() {
        let (mut source, mut listener) = (source(), Listener::default());
        let missed = |listener: &mut Listener, state| listener.on_state(&state, at(0)).missed_from;
        assert_eq!(missed(&mut listener, source.sample(Held::default(), at(0))), Some(1), "by whoever has just come");
        assert_eq!(missed(&mut listener, source.sample(Held::default(), at(1))), None);
        let event = source.on_frame(&frame(&text("FAILSAFE"), PLANE), at(2)).expect("an event");
        assert_eq!(missed(&mut listener, source.sample(Held::default(), at(3))), Some(1));
        assert_eq!(missed(&mut listener, source.sample(Held::default(), at(4))), Some(1), "until it is heard");
        assert_eq!(listener.missing(), Some(1));
        listener.on_event(&event, at(5));
        assert_eq!(missed(&mut listener, source.sample(Held::default(), at(6))), None);
        assert_eq!(listener.missing(), None);
        // One that came while those before it were asked for is missing still.
        source.on_frame(&frame(&text("a"), PLANE), at(7)).expect("an event");
        let last = source.on_frame(&frame(&text("b"), PLANE), at(7)).expect("an event");
        assert_eq!(listener.on_event(&last, at(8)).missed_from, Some(2));
        assert_eq!(listener.missing(), Some(2));
    }

    #[test]
    fn what_is_not_kept_any_more_is_gone() {
        let (mut source, mut listener) = (source(), Listener::default());
        listener.on_state(&source.sample(Held::default(), at(0)), at(0));
        for _ in 0..MAX_EVENTS + 10 {
            source.on_frame(&frame(&text("x"), PLANE), at(1));
        }
        let mut told: Vec<_> = source.events_from(1).collect();
        assert_eq!((told.len(), told[0].number), (MAX_ANSWERED, 11));
        // What got lost of an answer is not gone.
        told.retain(|event| ![11, 14].contains(&event.number));
        assert_eq!((listener.on_events(told, at(2)), listener.missing()), (vec![], Some(11)));
        let mut told: Vec<_> = source.events_from(11).collect();
        told.retain(|event| event.number != 14);
        assert_eq!((listener.on_events(told, at(2)).len(), listener.missing()), (3, Some(14)));
        listener.on_state(&source.sample(Held::default(), at(2)), at(2));
        while let Some(from) = listener.missing() {
            assert!(!listener.on_events(source.events_from(from).collect(), at(3)).is_empty());
        }
    }

    #[test]
    fn what_is_caught_up_with_was_said_when_it_was_said() {
        let (mut source, mut listener) = (source(), Listener::default());
        let reached = Message::Dialect(MavMessage::MISSION_ITEM_REACHED(MISSION_ITEM_REACHED_DATA { seq: 3 }));
        source.on_frame(&frame(&text("a"), PLANE), at(1_000));
        source.on_frame(&frame(&reached, PLANE), at(49_000));
        source.on_frame(&frame(&reached, PLANE), at(51_000));
        listener.on_state(&source.sample(Held::default(), at(60_000)), at(500_000));
        let told = listener.on_events(source.events_from(1).collect(), at(500_200));
        assert_eq!(told, [(text("a"), at(441_000)), (reached, at(491_000))], "and no item of who knows which mission");
        let event = source.on_frame(&frame(&text("b"), PLANE), at(60_400)).expect("an event");
        assert_eq!(listener.on_event(&event, at(500_500)).said, [(text("b"), at(500_400))]);
        let event = source.on_frame(&frame(&text("c"), PLANE), at(99_000)).expect("an event");
        assert_eq!(listener.on_event(&event, at(500_600)).said, [(text("c"), at(500_600))], "not in time to come");
    }

    #[test]
    fn a_lost_sample_has_everything_asked_for_once() {
        let (mut source, mut listener) = (source(), Listener::default());
        let mut say = |listener: &mut Listener, seconds: u64, comes: bool| {
            source.on_frame(&frame(&heartbeat(1), PLANE), at(seconds * 1_000));
            let sample = source.sample(Held::default(), at(seconds * 1_000));
            if comes {
                listener.on_state(&sample, at(seconds * 1_000));
            }
            (listener.lacks_some(at(seconds * 1_000)), sample, source.everything(Held::default(), at(seconds * 1_000)))
        };
        assert!(!listener.lacks_some(at(0)), "of whom nothing was heard yet");
        let (lacks, before, everything) = say(&mut listener, 1, true);
        assert!(lacks, "by whoever has just come");
        listener.on_everything(&everything, at(1_000));
        assert!(!say(&mut listener, 2, true).0);
        let (_, lost, _) = say(&mut listener, 3, false);
        assert!(!say(&mut listener, 4, true).0, "not yet: everything was told 3 s ago");
        assert!(say(&mut listener, 11, true).0 && say(&mut listener, 12, true).0, "until it comes");
        let everything = say(&mut listener, 13, false).2;
        assert!(say(&mut listener, 14, true).0);
        listener.on_everything(&everything, at(14_000));
        for late in [before, lost] {
            listener.on_state(&late, at(14_000));
        }
        assert!(!say(&mut listener, 50, true).0, "what comes late takes nothing back");
    }

    #[test]
    fn everything_tells_what_was_not_heard_also_where_a_sample_has_overtaken_it() {
        let (mut source, mut listener) = (source(), Listener::default());
        let home =
            Message::Dialect(MavMessage::HOME_POSITION(HOME_POSITION_DATA { latitude: 7, ..Default::default() }));
        source.on_frame(&frame(&home, PLANE), at(500));
        source.on_frame(&frame(&heartbeat(1), PLANE), at(600));
        source.sample(Held::default(), at(700));
        let everything = source.everything(Held::default(), at(1_000));
        source.on_frame(&frame(&heartbeat(2), PLANE), at(1_400));
        listener.on_state(&source.sample(Held { holder: "Ana".into(), ..Held::default() }, at(1_500)), at(50_000));
        assert!(listener.lacks_some(at(50_000)));
        let news = listener.on_everything(&everything, at(50_100));
        assert_eq!(news.said, [(home, at(49_000))], "and not the heartbeat before the last");
        assert!(!listener.lacks_some(at(90_000)), "its answer and what was heard since are all");
        assert_eq!(listener.held().holder, "Ana");
        let mut second = StateSource::new(2, PLANE, Stamper::new(&[7; 32]));
        listener.on_state(&second.sample(Held::default(), at(10)), at(60_000));
        assert!(listener.lacks_some(at(50_200)), "it started again");
    }

    #[test]
    fn another_boot_begins_anew() {
        let mut listener = Listener::default();
        let mut first = source();
        assert_eq!(listener.on_state(&first.sample(Held::default(), at(9_000)), at(0)).missed_from, Some(1));
        let event = first.on_frame(&frame(&text("old"), PLANE), at(9_000)).expect("an event");
        listener.on_event(&event, at(0));
        let mut second = StateSource::new(2, PLANE, Stamper::new(&[7; 32]));
        assert_eq!(listener.on_state(&second.sample(Held::default(), at(10)), at(0)).missed_from, Some(1));
        assert_eq!(listener.stamp(), Some((2, Stamper::new(&[7; 32]).stamp(10))));
        assert_eq!(listener.on_event(&event, at(0)), StateUpdate::default(), "of the boot before");
        let event = second.on_frame(&frame(&text("new"), PLANE), at(10)).expect("an event");
        assert_eq!(listener.on_event(&event, at(0)).said.len(), 1);
    }
}
