//! How a station opens and ends replays, and what their vehicles tell.

use std::io;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex};
use std::time::Duration;

use tokio::sync::watch;
use vencejo_proto::{Address, MonoTime};
use vencejo_vehicle::{Danger, Request, VehicleId};

use super::film::Film;
use super::handle::{MAX_REPLAYS, OpenFilm, Replay, ReplayId, ReplayOptions, Shared, State};
use super::pace::{Pace, SPEEDS};
use super::{playing, tlog};
use crate::error::StationError;
use crate::remote::{Carried, FarHeld, FarWish, Remote, Telling};
use crate::station::{Station, VehicleHandle};

/// Refuses everything.
struct Recorded {
    name: String,
}

impl Remote for Recorded {
    fn request(self: Arc<Self>, _: Request, _: Option<Danger>, _: String, _: Telling) -> Carried {
        Box::pin(async move { Err(StationError::Replayed { vehicle: self.name.clone() }) })
    }

    fn control(self: Arc<Self>, _: FarWish, _: String) -> Carried {
        Box::pin(async move { Err(StationError::Replayed { vehicle: self.name.clone() }) })
    }

    fn held(&self) -> FarHeld {
        FarHeld::default()
    }

    fn is_recording(&self) -> bool {
        true
    }
}

impl Station {
    /// Makes files with this ending (without its dot) replayable. `.tlog` is already.
    pub fn add_film_format(&self, ending: &'static str, open: OpenFilm) {
        self.shared.replays().formats.insert(ending, open);
    }

    /// Replays a recording: its aircraft appear as vehicles of their own. A recording that is looked at already goes on
    /// from the start of these options instead, for all who look at it.
    ///
    /// # Errors
    /// [`StationError::BadRecording`] when it cannot be read or holds no aircraft, [`StationError::TooManyReplays`],
    /// [`StationError::TooManyVehicles`], [`StationError::Closed`].
    pub async fn open_replay(&self, path: &Path, options: ReplayOptions) -> Result<Replay, StationError> {
        let file = path.file_name().unwrap_or(path.as_os_str()).to_string_lossy().into_owned();
        let bad = |reason: String| StationError::BadRecording { file: file.clone(), reason };
        let opened = path.to_owned();
        let ending = path.extension().and_then(|ending| ending.to_str()).map(str::to_ascii_lowercase);
        let format = ending.and_then(|ending| self.shared.replays().formats.get(ending.as_str()).cloned());
        let open = move || -> io::Result<(PathBuf, Box<dyn Film>)> {
            let opened = opened.canonicalize()?;
            let film = match format {
                Some(open) => open(&opened)?,
                None => Box::new(tlog::TlogFilm::open(&opened)?),
            };
            Ok((opened, film))
        };
        let read = self.shared.runtime().spawn_blocking(open).await.map_err(|_| StationError::Closed)?;
        let (path, film) = read.map_err(|error| bad(error.to_string()))?;
        let info = film.info().clone();
        if info.autopilots.is_empty() {
            return Err(bad("there is no state of an aircraft in it".to_owned()));
        }
        let mut replays = self.shared.replays();
        if self.is_closed() {
            return Err(StationError::Closed);
        }
        let is_it = |known: &Replay| known.is_aside() && !options.stands_in && known.path() == path;
        if let Some((known, _)) = replays.open.iter().find(|(known, _)| is_it(known)) {
            known.set_speed(options.speed);
            known.seek(options.start);
            known.play();
            return Ok(known.clone());
        }
        if replays.open.len() >= MAX_REPLAYS {
            return Err(StationError::TooManyReplays);
        }
        let stem = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
        let name = info.aircraft.clone().unwrap_or(stem);
        let vehicles = self.adopt_recorded(&name, &info.autopilots)?;
        replays.count += 1;
        let (wake, woken) = watch::channel(());
        let pace = Pace::new(options.start, info.duration, options.speed.clamp(*SPEEDS.start(), *SPEEDS.end()));
        let state = State { limit: pace.place(), pace, is_over: false, seeks: 1, fault: None, clock: None };
        let replay = Replay {
            shared: Arc::new(Shared {
                id: replays.count,
                name,
                path,
                info,
                stands_in: options.stands_in,
                vehicles,
                state: Mutex::new(state),
                wake,
                done: watch::Sender::new(0),
            }),
        };
        self.shared.show_replay(&replay);
        let (shared, played) = (Arc::downgrade(&self.shared), replay.clone());
        let task = async move {
            playing::play(shared, played.clone(), film, options.repeat, woken).await;
            // A film that failed for good, or the station is gone: nobody waits for a place any more.
            played.on_closed();
        };
        replays.open.push((replay.clone(), self.shared.runtime().spawn(task)));
        Ok(replay)
    }

    /// Adopts the aircraft of a recording, under names that no others have.
    fn adopt_recorded(&self, name: &str, autopilots: &[Address]) -> Result<Vec<(Address, VehicleId)>, StationError> {
        let mut vehicles = Vec::new();
        for address in autopilots {
            let of_several = if autopilots.len() > 1 { format!(" {}", address.system) } else { String::new() };
            let unused = |number: &u32| {
                let again = if *number > 1 { format!(" {number}") } else { String::new() };
                let name = format!("{name}{of_several} (replay{again})");
                (!self.shared.core().adopted.values().any(|adopted| *adopted.name == *name)).then_some(name)
            };
            let Some(name) = (1..=MAX_REPLAYS as u32 + 1).find_map(|number| unused(&number)) else { continue };
            let recorded = Arc::new(Recorded { name: name.clone() });
            match self.adopt(&name, *address, recorded) {
                Some(id) => vehicles.push((*address, id)),
                None => {
                    self.shared.dismiss(vehicles.iter().map(|(_, id)| *id));
                    return Err(StationError::TooManyVehicles);
                }
            }
        }
        Ok(vehicles)
    }

    /// The open replays, in the order they were opened.
    pub fn replays(&self) -> Vec<Replay> {
        self.shared.replays().open.iter().map(|(replay, _)| replay.clone()).collect()
    }

    /// Ends a replay; its vehicles go. Whether there was one.
    pub async fn close_replay(&self, id: ReplayId) -> bool {
        let found = {
            let mut replays = self.shared.replays();
            let place = replays.open.iter().position(|(replay, _)| replay.id() == id);
            place.map(|place| replays.open.remove(place))
        };
        let Some((replay, task)) = found else { return false };
        task.abort();
        // Cancelled, or it has ended by itself; a panic was reported.
        let _ = task.await;
        replay.on_closed();
        self.shared.dismiss(replay.vehicles());
        true
    }

    /// Ends all replays.
    pub(crate) async fn end_replays(&self) {
        let open = std::mem::take(&mut self.shared.replays().open);
        for (replay, task) in open {
            task.abort();
            let _ = task.await;
            replay.on_closed();
        }
    }
}

impl VehicleHandle {
    /// The replay that it belongs to.
    pub fn replay(&self) -> Option<Replay> {
        self.station.shared.core().shown(self.id).map(|shown| shown.replay.clone())
    }

    /// Whether it comes from a recording, be it a replay or a link that plays one: it takes no requests.
    pub fn is_recorded(&self) -> bool {
        self.station.shared.core().admit(self.id).is_err()
    }

    /// A moment that it gave: the time of the station's clock, or of a replayed vehicle the position in its recording.
    pub fn moment(&self, at: MonoTime) -> Duration {
        let is_of_replay = self.station.shared.core().shown(self.id).is_some();
        if is_of_replay { playing::place_of(at) } else { at.as_duration() }
    }
}
