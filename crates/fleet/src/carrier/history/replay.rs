//! The contents of a history file, and the file as a film that a station replays.

use std::collections::BTreeMap;
use std::io;
use std::path::Path;
use std::time::Duration;

use vencejo_proto::{Address, ComponentId, SystemId};
use vencejo_station::{Film, FilmInfo, Moment};

use super::shelf::Shelf;
use crate::history::{Ranges, Record, Stream};
use crate::payload::{Event, Said, State};

/// The pause between two boots; the real one is unknown.
const BETWEEN_BOOTS_MS: u64 = 1000;
/// Most events before a place that belong to it.
const EVENTS_BEFORE: usize = 64;

/// The contents of a history file.
#[derive(Debug, Clone, PartialEq)]
pub struct Contents {
    /// The aircraft, where the file says it.
    pub aircraft: Option<String>,
    /// Its streams by boot, in the order in which the boots begin in the file: what is there of each.
    pub streams: Vec<(u64, Stream, Ranges)>,
    /// How long the boots were in it, all together.
    pub duration: Duration,
    /// Bytes that could not be read: damaged, or torn off at the end.
    pub skipped_bytes: u64,
    /// When each boot begins: its time in the file, ms, and UTC by its last record, ns since 1970.
    begins: Vec<(u64, u64)>,
    /// What there is to be seen, with its time in the file.
    timeline: Vec<(u64, Shown)>,
}

#[derive(Debug, Clone, PartialEq)]
enum Shown {
    State(Box<State>),
    Event(Box<Event>),
}

impl Contents {
    /// Reads a file in any condition. It blocks.
    ///
    /// # Errors
    /// When it cannot be read or is no history.
    pub fn read(path: &Path) -> io::Result<Self> {
        let (aircraft, records, skipped_bytes) = Shelf::file(path)?;
        Ok(Self::of(aircraft, records, skipped_bytes))
    }

    fn of(aircraft: Option<String>, mut records: Vec<Record>, skipped_bytes: u64) -> Self {
        let mut boots: Vec<u64> = Vec::new();
        let mut streams: BTreeMap<(usize, Stream), Ranges> = BTreeMap::new();
        for record in &records {
            let at = boots.iter().position(|boot| *boot == record.boot).unwrap_or_else(|| {
                boots.push(record.boot);
                boots.len() - 1
            });
            streams.entry((at, record.stream)).or_default().add(record.number, record.number);
        }
        // By boot and the clock on board: what was fetched later stands later in the file.
        let place = |record: &Record| boots.iter().position(|boot| *boot == record.boot);
        records.sort_by_cached_key(|record| (place(record), record.clock_ms, record.stream, record.number));
        records.dedup_by_key(|record| (record.boot, record.stream, record.number));
        let (mut timeline, mut begins, mut end_ms) = (Vec::new(), Vec::new(), 0);
        for boot in records.chunk_by(|one, next| one.boot == next.boot) {
            let (Some(first), Some(last)) = (boot.first(), boot.last()) else { continue };
            let begins_ms = if begins.is_empty() { 0 } else { end_ms + BETWEEN_BOOTS_MS };
            // The clock on board may have been set in the course of the boot.
            let lasts_ns = (last.clock_ms - first.clock_ms).saturating_mul(1_000_000);
            begins.push((begins_ms, last.unix_ns.saturating_sub(lasts_ns)));
            for record in boot {
                end_ms = begins_ms + (record.clock_ms - first.clock_ms);
                let shown = match record.stream {
                    Stream::State => State::read(&record.data).ok().map(|state| Shown::State(Box::new(state))),
                    Stream::Event => Event::read(&record.data).ok().map(|event| Shown::Event(Box::new(event))),
                    Stream::Audit => None,
                };
                timeline.extend(shown.map(|shown| (end_ms, shown)));
            }
        }
        let streams = streams.into_iter().map(|((at, stream), ranges)| (boots[at], stream, ranges)).collect();
        let duration = Duration::from_millis(end_ms);
        Self { aircraft, streams, begins, duration, skipped_bytes, timeline }
    }

    /// UTC of the first record as it was estimated, ns since 1970.
    pub fn start_unix_ns(&self) -> Option<u64> {
        self.unix_ns(0)
    }

    /// UTC at a time in the file, ms.
    fn unix_ns(&self, at_ms: u64) -> Option<u64> {
        let (begins_ms, unix_ns) = self.begins.iter().rev().find(|(begins_ms, _)| *begins_ms <= at_ms)?;
        Some(unix_ns.saturating_add((at_ms - begins_ms).saturating_mul(1_000_000)))
    }

    /// The newest of each message before a place in the timeline, with its age at the last state there, as one state.
    fn before(&self, place: usize) -> Option<State> {
        let mut newest: Option<State> = None;
        for (_, shown) in &self.timeline[..place] {
            let Shown::State(state) = shown else { continue };
            let earlier = newest.take().filter(|earlier| earlier.boot == state.boot).unwrap_or_default();
            let mut merged = (**state).clone();
            merged.held = merged.held.or_else(|| earlier.held.clone());
            let later_ms = u32::try_from(state.clock_ms.saturating_sub(earlier.clock_ms)).unwrap_or(u32::MAX);
            earlier
                .said()
                .filter(|said| !state.message_ids.contains(&said.message_id))
                .map(|said| Said { age_ms: said.age_ms.saturating_add(later_ms), ..said })
                .for_each(|said| merged.say(&said));
            newest = Some(merged);
        }
        newest
    }
}

/// A history file as a film.
struct HistoryFilm {
    info: FilmInfo,
    autopilot: Address,
    contents: Contents,
    /// Place in the timeline of what is read next.
    place: usize,
    /// When each message that was read was said, by its id: states repeat them.
    heard: BTreeMap<u32, Duration>,
    /// Time of the last moment that was read: time does not go back.
    last: Duration,
}

/// Opens a history file for a replay. It blocks.
///
/// # Errors
/// When the file cannot be read, or holds nothing that can be seen.
pub fn open_film(path: &Path) -> io::Result<Box<dyn Film>> {
    Ok(Box::new(HistoryFilm::new(Contents::read(path)?)?))
}

impl HistoryFilm {
    fn new(contents: Contents) -> io::Result<Self> {
        let autopilot = contents.timeline.iter().find_map(|(_, shown)| match shown {
            Shown::State(state) => Some(Address {
                system: SystemId(u8::try_from(state.system).ok()?),
                component: ComponentId(u8::try_from(state.component).ok()?),
            }),
            Shown::Event(_) => None,
        });
        let autopilot = autopilot
            .ok_or_else(|| io::Error::new(io::ErrorKind::InvalidData, "there is no state of an aircraft in it"))?;
        let info = FilmInfo {
            autopilots: vec![autopilot],
            aircraft: contents.aircraft.clone(),
            start_unix_us: contents.start_unix_ns().map(|unix_ns| unix_ns / 1000),
            duration: contents.duration,
            marks: Vec::new(),
            plans: Vec::new(),
            skipped_bytes: contents.skipped_bytes,
        };
        Ok(Self { info, autopilot, contents, place: 0, heard: BTreeMap::new(), last: Duration::ZERO })
    }

    /// What a state or event at a time says that was not said before.
    fn take_in(&mut self, at_ms: u64, shown: &Shown) -> Vec<Moment> {
        let (at, unix_ns) = (Duration::from_millis(at_ms), self.contents.unix_ns(at_ms));
        let (said, is_each) = match shown {
            Shown::State(state) => (state.said().collect(), false),
            Shown::Event(event) => (event.said.iter().cloned().collect::<Vec<_>>(), true),
        };
        let mut moments = Vec::new();
        for said in said {
            let said_at = at.saturating_sub(Duration::from_millis(said.age_ms.into()));
            let is_known = !is_each && self.heard.get(&said.message_id).is_some_and(|heard| *heard >= said_at);
            let Some(message) = said.message().filter(|_| !is_known) else { continue };
            self.heard.insert(said.message_id, said_at);
            // Of its boot, also where it was said before the first record of that.
            let unix_us = unix_ns.map(|unix_ns| (unix_ns / 1000).saturating_sub(u64::from(said.age_ms) * 1000));
            moments.push(Moment { at: said_at, unix_us, from: self.autopilot, message });
        }
        moments.sort_by_key(|moment| moment.at);
        for moment in &mut moments {
            moment.at = moment.at.max(self.last);
            self.last = moment.at;
        }
        moments
    }
}

impl Film for HistoryFilm {
    fn info(&self) -> &FilmInfo {
        &self.info
    }

    fn seek(&mut self, to: Duration) -> io::Result<Vec<Moment>> {
        let to_ms = u64::try_from(to.as_millis()).unwrap_or(u64::MAX);
        self.place = self.contents.timeline.partition_point(|(at_ms, _)| *at_ms <= to_ms);
        self.heard.clear();
        self.last = Duration::ZERO;
        let until = &self.contents.timeline[..self.place];
        let newest_ms = until.iter().rev().find(|(_, shown)| matches!(shown, Shown::State(_))).map(|(at_ms, _)| *at_ms);
        let events = until.iter().rev().filter(|(_, shown)| matches!(shown, Shown::Event(_))).take(EVENTS_BEFORE);
        let events: Vec<_> = events.cloned().collect();
        let mut past = Vec::new();
        for (at_ms, event) in events.iter().rev() {
            past.extend(self.take_in(*at_ms, event));
        }
        self.last = Duration::ZERO;
        if let Some((at_ms, before)) = newest_ms.zip(self.contents.before(self.place)) {
            past.extend(self.take_in(at_ms, &Shown::State(Box::new(before))));
        }
        past.sort_by_key(|moment| moment.at);
        Ok(past)
    }

    fn read(&mut self) -> io::Result<Vec<Moment>> {
        let mut moments = Vec::new();
        while moments.is_empty() {
            let Some((at_ms, shown)) = self.contents.timeline.get(self.place).cloned() else { break };
            self.place += 1;
            moments = self.take_in(at_ms, &shown);
        }
        Ok(moments)
    }
}

#[cfg(test)]
mod tests {
    use prost::Message as _;
    use vencejo_proto::{Header, Heartbeat, MavVersion, Message};

    use super::*;
    use crate::payload::VERSION;

    #[test]
    fn a_value_from_before_the_place_has_its_age_there() {
        let state = |clock_ms, message_id| {
            let mut state = State { boot: 7, clock_ms, ..State::default() };
            state.say(&Said { message_id, payload: vec![1], age_ms: 300 });
            (clock_ms, Shown::State(Box::new(state)))
        };
        let contents = Contents {
            aircraft: None,
            streams: Vec::new(),
            begins: Vec::new(),
            duration: Duration::from_secs(600),
            skipped_bytes: 0,
            timeline: vec![state(0, 147), state(599_000, 74), state(600_000, 33)],
        };
        let before = contents.before(3).expect("states");
        let ages: Vec<_> = before.said().map(|said| (said.message_id, said.age_ms)).collect();
        assert_eq!(ages, [(33, 300), (74, 1_300), (147, 600_300)]);
    }

    #[test]
    fn each_boot_is_shown_at_its_own_utc() {
        const NINE: u64 = 1_800_000_000_000_000_000;
        const HOUR: u64 = 3_600_000_000_000;
        let record = |boot, clock_ms, unix_ns| {
            let mut state = State { version: VERSION, boot, clock_ms, system: 1, component: 1, ..State::default() };
            let frame = Message::Heartbeat(Heartbeat { autopilot: 3, mav_type: 1, ..Heartbeat::default() });
            let header = Header { sequence: 0, source: Address::new(1, 1), version: MavVersion::V2 };
            state.say(&Said::of(&frame.encode(header), 0));
            Record { stream: Stream::State, boot, number: clock_ms, clock_ms, unix_ns, data: state.encode_to_vec() }
        };
        // The computer's clock is set while it runs. Six hours later it is switched on again.
        let records = vec![
            record(7, 5_000, 20_000_000_000),
            record(7, 65_000, NINE + HOUR / 60),
            record(8, 1_000, NINE + 6 * HOUR),
            record(8, 3_000, NINE + 6 * HOUR + 2_000_000_000),
        ];
        let mut film = HistoryFilm::new(Contents::of(None, records, 0)).expect("an aircraft");
        assert_eq!(film.info.start_unix_us, Some(NINE / 1000));
        film.seek(Duration::ZERO).expect("read");
        let mut next = || film.read().expect("read")[0].unix_us;
        let told = [next(), next(), next()];
        assert_eq!(
            told,
            [NINE + HOUR / 60, NINE + 6 * HOUR, NINE + 6 * HOUR + 2_000_000_000].map(|ns| Some(ns / 1000))
        );
    }

    #[test]
    fn a_film_goes_to_every_place_with_what_was_known_there_and_repeats_nothing() {
        let heartbeat = |clock_ms: u64, age_ms| {
            let mut state = State { boot: 7, clock_ms, system: 1, component: 1, ..State::default() };
            let frame = Message::Heartbeat(Heartbeat { autopilot: 3, mav_type: 1, ..Heartbeat::default() });
            let header = Header { sequence: 0, source: Address::new(1, 1), version: MavVersion::V2 };
            state.say(&Said::of(&frame.encode(header), age_ms));
            (clock_ms, Shown::State(Box::new(state)))
        };
        // The third repeats the second's.
        let timeline = vec![heartbeat(0, 0), heartbeat(1_000, 100), heartbeat(2_000, 1_100), heartbeat(3_000, 0)];
        let contents = Contents {
            aircraft: Some("plane7".into()),
            streams: Vec::new(),
            begins: vec![(0, 1_700_000_000_000_000_000)],
            duration: Duration::from_secs(3),
            skipped_bytes: 0,
            timeline,
        };
        let mut film = HistoryFilm::new(contents).expect("an aircraft");
        let at = |moments: Vec<Moment>| moments.iter().map(|moment| moment.at.as_millis()).collect::<Vec<_>>();
        assert_eq!(at(film.seek(Duration::from_millis(2_500)).expect("read")), [900]);
        assert_eq!(film.read().expect("read")[0].unix_us, Some(1_700_000_003_000_000));
        assert_eq!(at(film.read().expect("read")), [0_u128; 0]);
        assert_eq!(at(film.seek(Duration::ZERO).expect("read")), [0]);
        assert_eq!((at(film.read().expect("read")), at(film.read().expect("read"))), (vec![900], vec![3_000]));
    }
}
