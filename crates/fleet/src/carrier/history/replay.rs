//! Replay of a history file: its states go to a station like those of a remote aircraft, and orders are refused.

use std::collections::BTreeMap;
use std::io;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use tokio::runtime::Handle;
use tokio::sync::watch;
use tokio::task::JoinHandle;
use tokio::time::Instant;
use vencejo_proto::{Address, ComponentId, SystemId};
use vencejo_station::{Carried, FarHeld, Remote, Station, StationError, Telling};
use vencejo_vehicle::{Danger, Request, VehicleId};

use super::shelf::Shelf;
use crate::history::{Ranges, Record, Stream};
use crate::payload::{Event, Said, State};
use crate::state_source::{Listener, StateUpdate};

/// The pause between two boots; the real one is unknown.
const BETWEEN_BOOTS_MS: u64 = 1000;
/// The pause between two rounds.
const REPEAT_PAUSE: Duration = Duration::from_millis(100);

/// The contents of a history file.
#[derive(Debug, Clone, PartialEq)]
pub struct Contents {
    /// The aircraft, where the file says it.
    pub aircraft: Option<String>,
    /// Its streams by boot, in the order in which the boots begin in the file: what is there of each.
    pub streams: Vec<(u64, Stream, Ranges)>,
    /// UTC of the first record as it was estimated, ns since 1970.
    pub start_unix_ns: Option<u64>,
    /// How long the boots were in it, all together.
    pub duration: Duration,
    /// Bytes that could not be read: damaged, or torn off at the end.
    pub skipped_bytes: u64,
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
        let (aircraft, mut records, skipped_bytes) = Shelf::file(path)?;
        let mut boots: Vec<u64> = Vec::new();
        let mut streams: BTreeMap<(usize, Stream), Ranges> = BTreeMap::new();
        for record in &records {
            let at = boots.iter().position(|boot| *boot == record.boot).unwrap_or_else(|| {
                boots.push(record.boot);
                boots.len() - 1
            });
            streams.entry((at, record.stream)).or_default().add(record.number, record.number);
        }
        let start_unix_ns = records.iter().map(|record| record.unix_ns).min();
        // By boot and the clock on board: what was fetched later stands later in the file.
        let place = |record: &Record| boots.iter().position(|boot| *boot == record.boot);
        records.sort_by_cached_key(|record| (place(record), record.clock_ms, record.stream, record.number));
        records.dedup_by_key(|record| (record.boot, record.stream, record.number));
        let (mut timeline, mut end_ms) = (Vec::new(), 0);
        // The boot, when it begins here, and its clock then.
        let mut begun: Option<(u64, u64, u64)> = None;
        for record in &records {
            let (boot, clock_ms) = (record.boot, record.clock_ms);
            let next_ms = if begun.is_some() { end_ms + BETWEEN_BOOTS_MS } else { 0 };
            let now = begun.filter(|(of, ..)| *of == boot).unwrap_or((boot, next_ms, clock_ms));
            let (_, offset, first) = now;
            begun = Some(now);
            end_ms = offset + (clock_ms - first);
            let shown = match record.stream {
                Stream::State => State::read(&record.data).ok().map(|state| Shown::State(Box::new(state))),
                Stream::Event => Event::read(&record.data).ok().map(|event| Shown::Event(Box::new(event))),
                Stream::Audit => None,
            };
            timeline.extend(shown.map(|shown| (end_ms, shown)));
        }
        let streams = streams.into_iter().map(|((at, stream), ranges)| (boots[at], stream, ranges)).collect();
        let duration = Duration::from_millis(end_ms);
        Ok(Self { aircraft, streams, start_unix_ns, duration, skipped_bytes, timeline })
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

/// The status of a replay.
#[derive(Debug, Clone, PartialEq)]
pub struct ReplayStatus {
    /// Its id in the station; `None` before its first state.
    pub id: Option<VehicleId>,
    /// Its position in the file.
    pub position: Duration,
    /// The duration of the file.
    pub duration: Duration,
    /// Whether it has come to the end.
    pub is_over: bool,
}

/// A history file that is played into a station.
pub struct Replay {
    shared: Arc<Shared>,
    seek: watch::Sender<Duration>,
    task: Mutex<Option<JoinHandle<()>>>,
}

struct Shared {
    name: String,
    status: Mutex<ReplayStatus>,
}

impl Shared {
    fn status(&self) -> MutexGuard<'_, ReplayStatus> {
        self.status.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Remote for Shared {
    fn request(self: Arc<Self>, _: Request, _: Option<Danger>, _: String, _: Telling) -> Carried {
        Box::pin(async move { Err(StationError::Replayed { vehicle: self.name.clone() }) })
    }

    fn held(&self) -> FarHeld {
        FarHeld::default()
    }

    fn is_recording(&self) -> bool {
        true
    }
}

impl Replay {
    /// Plays a file into a station, as a vehicle of its own, from `start` on, `speed` times as fast as it was; again
    /// and again where it is to `repeat`.
    ///
    /// # Errors
    /// When the file cannot be read, or holds nothing that can be seen.
    pub async fn start(
        station: Station,
        path: PathBuf,
        speed: f64,
        start: Duration,
        repeat: bool,
        runtime: &Handle,
    ) -> io::Result<Self> {
        let name = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
        let read = runtime.spawn_blocking(move || Contents::read(&path));
        let contents = read.await.map_err(io::Error::other)??;
        let autopilot = contents.timeline.iter().find_map(|(_, shown)| match shown {
            Shown::State(state) => Some(Address {
                system: SystemId(u8::try_from(state.system).ok()?),
                component: ComponentId(u8::try_from(state.component).ok()?),
            }),
            Shown::Event(_) => None,
        });
        let autopilot = autopilot
            .ok_or_else(|| io::Error::new(io::ErrorKind::InvalidData, "there is no state of an aircraft in it"))?;
        let name = format!("{} (replay)", contents.aircraft.clone().unwrap_or(name));
        let status = ReplayStatus { id: None, position: start, duration: contents.duration, is_over: false };
        let shared = Arc::new(Shared { name, status: Mutex::new(status) });
        let (seek, sought) = watch::channel(start);
        let task = runtime.spawn(play(station, contents, autopilot, speed, repeat, shared.clone(), sought));
        Ok(Self { shared, seek, task: Mutex::new(Some(task)) })
    }

    /// The name of its vehicle.
    pub fn name(&self) -> &str {
        &self.shared.name
    }

    /// The status.
    pub fn status(&self) -> ReplayStatus {
        self.shared.status().clone()
    }

    /// Goes on from there.
    pub fn seek(&self, position: Duration) {
        self.seek.send_replace(position);
    }

    /// Ends it. May be called again.
    pub fn close(&self) {
        if let Some(task) = self.task.lock().unwrap_or_else(PoisonError::into_inner).take() {
            task.abort();
        }
    }
}

impl Drop for Replay {
    fn drop(&mut self) {
        self.close();
    }
}

async fn play(
    station: Station,
    contents: Contents,
    autopilot: Address,
    speed: f64,
    repeat: bool,
    shared: Arc<Shared>,
    mut sought: watch::Receiver<Duration>,
) {
    let mut id = None;
    let mut show = |news: StateUpdate| {
        for _ in 0..2 {
            let known = match id {
                Some(known) => known,
                None => match station.adopt(&shared.name, autopilot, shared.clone()) {
                    Some(adopted) => adopted,
                    None => return,
                },
            };
            id = Some(known);
            shared.status().id = id;
            if station.on_remote(known, &news.said) {
                return;
            }
            // It made room for another vehicle, and is adopted again.
            id = None;
        }
    };
    let millis = |time: Duration| u64::try_from(time.as_millis()).unwrap_or(u64::MAX);
    let mut start = *sought.borrow_and_update();
    loop {
        let shown = shared.status().id;
        if let Some(id) = shown {
            station.on_remote_sought(id);
        }
        let from = start.min(contents.duration);
        let mut place = contents.timeline.partition_point(|(at, _)| *at < millis(from));
        let mut listener = Listener::default();
        if let Some(before) = contents.before(place) {
            show(listener.on_state(&before, station.now()));
        }
        let (began, mut is_sought) = (Instant::now(), false);
        shared.status().is_over = false;
        while let Some((at, shown)) = contents.timeline.get(place) {
            let at = Duration::from_millis(*at);
            let due = began + at.saturating_sub(from).div_f64(speed);
            tokio::select! {
                biased;
                Ok(()) = sought.changed() => {
                    is_sought = true;
                    break;
                }
                () = tokio::time::sleep_until(due) => {}
            }
            // Without this a replay at a great speed would keep its thread to itself.
            tokio::task::consume_budget().await;
            let now = station.now();
            show(match shown {
                Shown::State(state) => listener.on_state(state, now),
                Shown::Event(event) => {
                    listener.pass_over(event.number);
                    listener.on_event(event, now)
                }
            });
            shared.status().position = at;
            place += 1;
        }
        if !is_sought && repeat {
            // A file of one moment must not spin.
            tokio::time::sleep(REPEAT_PAUSE).await;
            start = Duration::ZERO;
            continue;
        }
        if !is_sought {
            shared.status().is_over = true;
            if sought.changed().await.is_err() {
                return;
            }
        }
        start = *sought.borrow_and_update();
    }
}

#[cfg(test)]
mod tests {
    use tokio::time::timeout;
    use vencejo_proto::dialect::{HOME_POSITION_DATA, MavMessage, VFR_HUD_DATA};
    use vencejo_proto::{Heartbeat, Message};
    use vencejo_station::StationConfig;

    use super::*;

    #[tokio::test]
    async fn a_value_is_as_old_as_it_was_there_wherever_the_replay_begins_or_goes_on() {
        const HOME_AT_S: u64 = 60;
        let state = |at_s: u64| {
            let clock_ms = at_s * 1000;
            let mut state = State { boot: 7, clock_ms, system: 1, component: 1, ..State::default() };
            let heartbeat = Heartbeat { mav_type: 1, autopilot: 3, ..Heartbeat::default() };
            state.say(&Said::of_message(&Message::Heartbeat(heartbeat)));
            state.say(&Said::of_message(&Message::Dialect(MavMessage::VFR_HUD(VFR_HUD_DATA::default()))));
            if at_s == HOME_AT_S {
                let home = HOME_POSITION_DATA { latitude: 400_000_000, longitude: -30_000_000, ..Default::default() };
                state.say(&Said::of_message(&Message::Dialect(MavMessage::HOME_POSITION(home))));
            }
            (clock_ms, Shown::State(Box::new(state)))
        };
        let contents = Contents {
            aircraft: None,
            streams: Vec::new(),
            start_unix_ns: None,
            duration: Duration::from_secs(600),
            skipped_bytes: 0,
            timeline: (0..=600).map(state).collect(),
        };
        let station = Station::start(StationConfig::default(), Handle::current()).expect("a station");
        let status =
            ReplayStatus { id: None, position: Duration::from_secs(300), duration: contents.duration, is_over: false };
        let shared = Arc::new(Shared { name: "plane7 (replay)".into(), status: Mutex::new(status) });
        let (seek, sought) = watch::channel(Duration::from_secs(590));
        let autopilot = Address { system: SystemId(1), component: ComponentId(1) };
        let playing = tokio::spawn(play(station.clone(), contents, autopilot, 1.0, false, shared.clone(), sought));
        for (place_s, home_before_s) in [(590, Some(529)), (30, None), (61, Some(0)), (590, Some(529))] {
            seek.send_replace(Duration::from_secs(place_s));
            let is_there = || shared.status().id.is_some() && shared.status().position.as_secs().abs_diff(place_s) < 20;
            timeout(Duration::from_secs(20), async {
                while !is_there() {
                    tokio::time::sleep(Duration::from_millis(10)).await;
                }
            })
            .await
            .expect("it is shown");
            let id = shared.status().id.expect("it is shown");
            let (telemetry, _) = station.vehicle(id).expect("known").telemetry();
            let hud = telemetry.hud.expect("each second");
            let before_s = telemetry.home.map(|home| hud.at.since(home.at).as_secs());
            assert_eq!(before_s.map(|before_s| before_s / 100), home_before_s.map(|before_s: u64| before_s / 100));
        }
        playing.abort();
        station.close().await;
    }

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
            start_unix_ns: None,
            duration: Duration::from_secs(600),
            skipped_bytes: 0,
            timeline: vec![state(0, 147), state(599_000, 74), state(600_000, 33)],
        };
        let before = contents.before(3).expect("states");
        let ages: Vec<_> = before.said().map(|said| (said.message_id, said.age_ms)).collect();
        assert_eq!(ages, [(33, 300), (74, 1_300), (147, 600_300)]);
    }
}
