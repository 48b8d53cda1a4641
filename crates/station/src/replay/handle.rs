//! A replay: its state, and what may be done with it. The task that plays it follows.

use std::collections::HashMap;
use std::io;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use tokio::sync::watch;
use tokio::task::JoinHandle;
use vencejo_proto::{Address, MonoTime};
use vencejo_vehicle::VehicleId;

use super::clock::RecordedClock;
use super::film::{Film, FilmInfo, Moment};
use super::pace::{Pace, SPEEDS};

/// Most replays open at once.
pub const MAX_REPLAYS: usize = 8;

/// The number of seeks that are done of a closed replay, for which nobody waits any more.
const CLOSED: u64 = u64::MAX;

/// Identifies a replay of a station; never reused.
pub type ReplayId = u32;

/// Opens a recording of some format. It may block.
pub type OpenFilm = Arc<dyn Fn(&Path) -> io::Result<Box<dyn Film>> + Send + Sync>;

/// How a replay begins.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ReplayOptions {
    /// Times the recorded pace, within [`SPEEDS`].
    pub speed: f64,
    /// From where in the recording.
    pub start: Duration,
    /// Whether it begins again at the end.
    pub repeat: bool,
    /// Whether its aircraft are taken for the station's vehicles, as those of a link are
    /// ([`Station::vehicles`](crate::Station::vehicles)). Otherwise they are only looked at: beside them an aircraft that
    /// is heard later must still be the first.
    pub stands_in: bool,
}

impl Default for ReplayOptions {
    fn default() -> Self {
        Self { speed: 1.0, start: Duration::ZERO, repeat: false, stands_in: false }
    }
}

/// The state of a replay.
#[derive(Debug, Clone, PartialEq)]
pub struct ReplayStatus {
    /// Its place in the recording.
    pub position: Duration,
    /// UTC there, microseconds since 1970, if the recording has it.
    pub unix_us: Option<u64>,
    /// Times the recorded pace.
    pub speed: f64,
    /// Whether it stands still.
    pub is_paused: bool,
    /// Whether it has come to the end, or was closed.
    pub is_over: bool,
    /// How often it went to another place, and is there. After that nothing from before holds any more.
    pub seeks: u64,
    /// Why it cannot go on.
    pub fault: Option<String>,
}

/// A replay of a station. Clones are handles to the same one.
#[derive(Clone)]
pub struct Replay {
    pub(super) shared: Arc<Shared>,
}

pub(super) struct Shared {
    pub(super) id: ReplayId,
    pub(super) name: String,
    pub(super) path: PathBuf,
    pub(super) info: FilmInfo,
    pub(super) stands_in: bool,
    pub(super) vehicles: Vec<(Address, VehicleId)>,
    pub(super) state: Mutex<State>,
    /// Wakes the task.
    pub(super) wake: watch::Sender<()>,
    /// How many of the state's seeks are done; [`CLOSED`] once it is closed.
    pub(super) done: watch::Sender<u64>,
}

pub(super) struct State {
    pub(super) pace: Pace,
    /// Nothing beyond is shown yet.
    pub(super) limit: Duration,
    pub(super) is_over: bool,
    /// How often it was asked to go to another place.
    pub(super) seeks: u64,
    pub(super) fault: Option<String>,
    /// The recorder's clock until the present place.
    pub(super) clock: Option<RecordedClock>,
}

/// The replays of a station.
#[derive(Default)]
pub(crate) struct Replays {
    pub(super) formats: HashMap<&'static str, OpenFilm>,
    pub(super) open: Vec<(Replay, JoinHandle<()>)>,
    pub(super) count: ReplayId,
}

/// What a vehicle of a replay has for its station.
pub(crate) struct Shown {
    pub(crate) replay: Replay,
    /// The present moment in the time of its recording.
    pub(crate) now: MonoTime,
    /// Whether it was last shown what was known at the beginning of a place, which is no news.
    pub(crate) is_past: bool,
    /// How many of the recording's plans were shown.
    pub(super) plans: usize,
}

impl std::fmt::Debug for Replay {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Replay")
            .field("path", &self.shared.path)
            .field("status", &self.status())
            .finish_non_exhaustive()
    }
}

impl Replay {
    pub(super) fn state(&self) -> MutexGuard<'_, State> {
        self.shared.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Its id.
    pub fn id(&self) -> ReplayId {
        self.shared.id
    }

    /// The aircraft, or the file's name without its ending where the recording names none.
    pub fn name(&self) -> &str {
        &self.shared.name
    }

    /// The file.
    pub fn path(&self) -> &Path {
        &self.shared.path
    }

    /// What the recording is about.
    pub fn info(&self) -> &FilmInfo {
        &self.shared.info
    }

    /// Its vehicles.
    pub fn vehicles(&self) -> impl Iterator<Item = VehicleId> + '_ {
        self.shared.vehicles.iter().map(|(_, id)| *id)
    }

    /// The vehicle of an autopilot.
    pub fn vehicle_of(&self, autopilot: Address) -> Option<VehicleId> {
        self.shared.vehicles.iter().find(|(address, _)| *address == autopilot).map(|(_, id)| *id)
    }

    /// Its state.
    pub fn status(&self) -> ReplayStatus {
        let state = self.state();
        let done = *self.shared.done.borrow();
        let position = state.pace.place().min(state.limit);
        ReplayStatus {
            position,
            unix_us: state.unix_us_at(position),
            speed: state.pace.speed,
            is_paused: state.pace.is_paused,
            is_over: state.is_over || done == CLOSED,
            seeks: state.seeks.min(done),
            fault: state.fault.clone(),
        }
    }

    /// UTC of a place that was shown since it last went to another one, microseconds since 1970, if the recording has
    /// it.
    pub fn unix_us_at(&self, place: Duration) -> Option<u64> {
        self.state().unix_us_at(place)
    }

    /// Stops where it is.
    pub fn pause(&self) {
        self.change(|state| state.pace.set(state.pace.speed, true));
    }

    /// Goes on; at the end, from the beginning.
    pub fn play(&self) {
        self.change(|state| {
            state.pace.set(state.pace.speed, false);
            if state.is_over {
                state.seek(Duration::ZERO);
            }
        });
    }

    /// Goes on at another pace; one outside of [`SPEEDS`] becomes the nearest one.
    pub fn set_speed(&self, speed: f64) {
        let speed = if speed.is_finite() { speed.clamp(*SPEEDS.start(), *SPEEDS.end()) } else { 1.0 };
        self.change(|state| state.pace.set(speed, state.pace.is_paused));
    }

    /// It is closed.
    pub(super) fn on_closed(&self) {
        self.shared.done.send_replace(CLOSED);
    }

    /// Whether its aircraft are only looked at.
    pub(crate) fn is_aside(&self) -> bool {
        !self.shared.stands_in
    }

    /// Waits until it is where it was last told to go, cannot go there, or is closed.
    pub async fn arrived(&self) {
        let seeks = self.state().seeks;
        // The sender is in the replay.
        let _ = self.shared.done.subscribe().wait_for(|done| *done >= seeks).await;
    }

    /// Goes to another place: the vehicles begin anew there, as soon as that is read ([`Self::arrived`]). It stays paused
    /// if it was.
    pub fn seek(&self, to: Duration) {
        self.change(|state| state.seek(to));
    }

    fn change(&self, change: impl FnOnce(&mut State)) {
        change(&mut self.state());
        self.shared.wake.send_replace(());
    }
}

impl State {
    /// Takes the UTC of moments that are shown.
    pub(super) fn set_clock(&mut self, said: &[Moment]) {
        for (at, unix_us) in said.iter().filter_map(|moment| Some((moment.at, moment.unix_us?))) {
            self.clock.get_or_insert_default().hear(at, unix_us);
        }
    }

    fn unix_us_at(&self, place: Duration) -> Option<u64> {
        self.clock.as_ref()?.at(place)
    }

    pub(super) fn seek(&mut self, to: Duration) {
        self.pace.seek(to);
        self.limit = self.pace.place();
        self.seeks += 1;
        self.is_over = false;
    }
}
