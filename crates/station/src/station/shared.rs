//! The shared state of a station's handles, and the part under one lock that changes with each message.

use std::collections::HashMap;
use std::sync::atomic::{AtomicBool, AtomicU64};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use tokio::runtime::Handle;
use tokio::sync::watch;
use tokio::task::JoinHandle;
use vencejo_link::{Clock, Hub, LinkHandle, Recorder, RecorderStatus};
use vencejo_proto::{Address, MavVersion, MonoTime};
use vencejo_vehicle::telemetry::Telemetry;
use vencejo_vehicle::{Reply, RequestId, Sources, StoredRecord, Vehicle, VehicleId, Vehicles};

use crate::changes::Changes;
use crate::config::StationConfig;
use crate::confirm::Confirmations;
use crate::control::{Control, Operator};
use crate::error::{StationError, Wanted};
use crate::namesake::Namesake;
use crate::pending::Finisher;
use crate::records::Records;
use crate::remote::{Adopted, FarNetwork};
use crate::replay::{Replays, Shown};
use crate::signing::{SigningError, Vault};
use crate::subscriptions::Subscriptions;

/// The result of a request to a vehicle.
pub type RequestResult = Result<Reply, StationError>;

/// A ground station without a user interface. Clones are handles to the same station.
#[derive(Clone)]
pub struct Station {
    pub(crate) shared: Arc<Shared>,
}

/// A vehicle of a station. Cheap to clone. The station lives as long as a handle to it or to one of its vehicles.
#[derive(Debug, Clone)]
pub struct VehicleHandle {
    pub(crate) station: Station,
    pub(crate) id: VehicleId,
    /// The operator it acts for; the station's own when absent.
    pub(crate) operator: Option<Arc<Operator>>,
}

pub(crate) struct Shared {
    pub(crate) config: StationConfig,
    pub(super) runtime: Handle,
    pub(super) hub: Hub,
    pub(crate) clock: Arc<dyn Clock>,
    pub(super) core: Mutex<Core>,
    pub(crate) control: Control,
    /// The operator of the program that owns the station.
    pub(crate) operator: Arc<Operator>,
    pub(super) confirmations: Mutex<Confirmations>,
    pub(super) heartbeat: AtomicBool,
    /// When the driver will wake, µs on our clock; an earlier deadline has to wake it.
    pub(super) driver_alarm_us: AtomicU64,
    pub(super) wake_driver: tokio::sync::Notify,
    pub(super) closing: watch::Sender<bool>,
    /// State of the recording when the driver last looked.
    pub(super) health: watch::Sender<Option<RecorderStatus>>,
    /// The networks of fleets.
    pub(crate) networks: watch::Sender<Vec<FarNetwork>>,
    /// The signing keys.
    pub(crate) vault: Option<Vault>,
    /// Why they could not be read.
    pub(crate) vault_fault: Option<SigningError>,
    pub(super) owned: Mutex<Owned>,
    pub(super) records: Mutex<Option<Records>>,
    pub(super) replays: Mutex<Replays>,
}

/// Tasks and resources that are shut down in order.
#[derive(Default)]
pub(super) struct Owned {
    pub(super) links: Vec<LinkHandle>,
    pub(super) recorder: Option<Recorder>,
    pub(super) driver: Option<JoinHandle<()>>,
    pub(super) keeper: Option<JoinHandle<()>>,
}

/// Everything that changes with each message; under one short lock, never held across an await.
pub(crate) struct Core {
    pub(crate) vehicles: Vehicles,
    /// Records of vehicles from earlier runs.
    pub(super) remembered: Vec<StoredRecord>,
    pub(super) requests: HashMap<(VehicleId, RequestId), Finisher<RequestResult>>,
    /// Requests that have ended and whose callers are to be notified.
    pub(super) ended: Vec<(Finisher<RequestResult>, RequestResult)>,
    pub(super) waiting: Vec<Waiting>,
    pub(super) next_waiting: u64,
    pub(crate) watchers: HashMap<VehicleId, Watchers>,
    /// Remote vehicles.
    pub(crate) adopted: HashMap<VehicleId, Adopted>,
    /// Subscribers to all vehicles.
    pub(crate) subscriptions: Subscriptions,
    /// Another station with our address.
    pub(super) namesake: Namesake,
}

impl Core {
    /// What a vehicle of a replay has for the station.
    pub(crate) fn shown(&self, id: VehicleId) -> Option<&Shown> {
        self.adopted.get(&id)?.shown.as_ref()
    }

    /// The present moment of a vehicle of a replay, in the time of its recording.
    pub(crate) fn replay_time(&self, id: VehicleId) -> Option<MonoTime> {
        self.shown(id).map(|shown| shown.now)
    }

    /// Whether a vehicle is one of a recording that is only looked at.
    pub(super) fn is_aside(&self, id: VehicleId) -> bool {
        self.shown(id).is_some_and(|shown| shown.replay.is_aside())
    }

    /// Whether a vehicle of a replay is shown what was known at a place to which it went: that is no news.
    pub(super) fn is_shown_past(&self, id: VehicleId) -> bool {
        self.shown(id).is_some_and(|shown| shown.is_past)
    }

    /// The name of a remote vehicle.
    pub(super) fn name_of(&self, id: VehicleId) -> Option<&str> {
        self.adopted.get(&id).map(|adopted| &*adopted.name)
    }

    pub(super) fn end_requests(&mut self) {
        self.ended.drain(..).for_each(|(finisher, result)| finisher.finish(result));
    }
}

/// A caller that waits for a vehicle.
pub(super) struct Waiting {
    pub(super) key: u64,
    pub(super) wanted: Wanted,
    pub(super) since: MonoTime,
    pub(super) finisher: Finisher<Result<VehicleHandle, StationError>>,
}

/// The subscribers of a vehicle, and its state in this station.
#[derive(Default)]
pub(crate) struct Watchers {
    pub(crate) changes: Arc<Changes>,
    pub(crate) subscriptions: Subscriptions,
    /// The protocol version that the vehicle speaks.
    pub(crate) version: MavVersion,
    /// The sources it is heard from, and whether they are one vehicle.
    pub(crate) sources: Sources,
    /// Of a remote vehicle: the place of another computer with its name, and until when it counts as present.
    pub(super) far_rival: Option<(String, MonoTime)>,
    /// Whether it was reported that another uses its id or name.
    pub(super) is_contested: bool,
    /// Whether it asks for terrain that no map here has.
    pub(crate) lacks_terrain: bool,
}

impl Station {
    pub(super) fn handle(&self, id: VehicleId) -> VehicleHandle {
        VehicleHandle { station: self.clone(), id, operator: None }
    }
}

impl std::fmt::Debug for Station {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Station").field("address", &self.shared.config.address).finish_non_exhaustive()
    }
}

impl Shared {
    pub(crate) fn core(&self) -> MutexGuard<'_, Core> {
        self.core.lock().unwrap_or_else(PoisonError::into_inner)
    }

    pub(crate) fn confirmations(&self) -> MutexGuard<'_, Confirmations> {
        self.confirmations.lock().unwrap_or_else(PoisonError::into_inner)
    }

    pub(super) fn owned(&self) -> MutexGuard<'_, Owned> {
        self.owned.lock().unwrap_or_else(PoisonError::into_inner)
    }

    pub(super) fn records(&self) -> MutexGuard<'_, Option<Records>> {
        self.records.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Not to be locked while the core is.
    pub(crate) fn replays(&self) -> MutexGuard<'_, Replays> {
        self.replays.lock().unwrap_or_else(PoisonError::into_inner)
    }

    pub(crate) fn hub(&self) -> &Hub {
        &self.hub
    }

    /// Becomes true when the station is closed.
    pub(crate) fn closing(&self) -> watch::Receiver<bool> {
        self.closing.subscribe()
    }

    pub(crate) fn runtime(&self) -> &Handle {
        &self.runtime
    }

    pub(crate) fn our_address(&self) -> Address {
        self.config.address
    }

    pub(crate) fn vault(&self) -> Result<&Vault, SigningError> {
        let fault = || self.vault_fault.clone().unwrap_or(SigningError::NoFolder);
        self.vault.as_ref().ok_or_else(fault)
    }

    /// Runs a closure on the keys, off the runtime's threads.
    pub(crate) async fn blocking<T: Send + 'static>(
        self: &Arc<Self>,
        work: impl FnOnce(&Vault, &Hub) -> Result<T, SigningError> + Send + 'static,
    ) -> Result<T, StationError> {
        let shared = self.clone();
        let done = self.runtime.spawn_blocking(move || {
            let vault = shared.vault()?;
            work(vault, &shared.hub)
        });
        done.await.map_err(|_| StationError::Closed)?.map_err(StationError::from)
    }

    /// Reads from a vehicle's state machine; `None` when the vehicle is not known.
    pub(crate) fn with_vehicle<T>(&self, system: VehicleId, look: impl FnOnce(&Vehicle) -> T) -> Option<T> {
        self.core().vehicles.get(system).map(look)
    }

    /// A copy of a vehicle's telemetry and the moment that it was taken, of a replayed one in the time of its recording.
    pub(crate) fn telemetry(&self, system: VehicleId) -> (Telemetry, MonoTime) {
        let core = self.core();
        let telemetry = core.vehicles.get(system).map(|vehicle| *vehicle.telemetry()).unwrap_or_default();
        (telemetry, core.replay_time(system).unwrap_or_else(|| self.clock.now()))
    }

    /// Marks it closed: all waits end.
    pub(super) fn end_waits(&self) {
        self.closing.send_replace(true);
        let (requests, waiting) = {
            let mut core = self.core();
            core.subscriptions.close();
            for watchers in core.watchers.values() {
                watchers.subscriptions.close();
                watchers.changes.notify();
            }
            (std::mem::take(&mut core.requests), std::mem::take(&mut core.waiting))
        };
        for (_, finisher) in requests {
            finisher.finish(Err(StationError::Closed));
        }
        for waiting in waiting {
            waiting.finisher.finish(Err(StationError::Closed));
        }
    }
}

/// Whether its heartbeat was heard: one far away is there by its name before.
pub(super) fn is_heard(vehicle: &Vehicle) -> bool {
    vehicle.telemetry().heartbeat.is_some()
}
