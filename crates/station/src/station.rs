//! The station itself: it owns the links, the vehicles' state machines, the clock that drives them, and their end.
//!
//! A frame is handled where it is read: the link's task decodes it, feeds the vehicle's state machine, and sends what
//! that wants, without a hop to another task. One more task, the driver, lets time pass and sends our heartbeat.

use std::collections::{BTreeSet, HashMap};
use std::net::SocketAddr;
use std::path::PathBuf;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError, Weak};
use std::time::Duration;

use tokio::runtime::Handle;
use tokio::sync::watch;
use tokio::task::JoinHandle;
use vencejo_link::{
    Clock, Folder, Hub, LinkAddress, LinkHandle, LinkId, LinkInfo, LinkOptions, LinkState, LinkStats, Origin, PeerId,
    Recorder, RecorderConfig, RecorderStatus, Route, SendReport, SinkScope, SystemClock,
};
use vencejo_proto::{Address, Frame, Heartbeat, MavVersion, Message, MonoTime};
use vencejo_store::{Class, Space};
use vencejo_vehicle::telemetry::{LOST_AFTER, Telemetry};
use vencejo_vehicle::{
    Output, RegistryEvent, RegistryOutput, Reply, Request, RequestId, SourceId, Sources, StoredRecord, Taken, Vehicle,
    VehicleConfig, VehicleError, VehicleEvent, VehicleId, Vehicles,
};

use crate::changes::Changes;
use crate::config::StationConfig;
use crate::confirm::Confirmations;
use crate::control::{Control, Operator};
use crate::error::StationError;
use crate::namesake::Namesake;
use crate::pending::{Finisher, Pending};
use crate::queue::DropOldest;
use crate::records::{self, Records};
use crate::remote::Adopted;
use crate::signing::{SigningError, Vault};
use crate::subscriptions::{Observed, Received, Subscriptions};

/// How often our heartbeat goes out, and the driver looks round at the latest (mavlink.io, "Heartbeat protocol").
const HEARTBEAT_INTERVAL: Duration = Duration::from_secs(1);
/// Every so many heartbeats a vehicle that speaks MAVLink 1 is shown that we speak MAVLink 2. An old one skips a frame of 21
/// bytes.
const INVITE_EVERY: u32 = 5;

/// How often it is looked whether keys changed, here or on disk.
const LOOK: Duration = Duration::from_secs(1);
/// How often the keys' times are written: half of what is reserved.
const WRITE_TIMES: Duration = Duration::from_secs(30);
/// `TIMESYNC`: its answers tell the round trip.
const TIMESYNC_ID: u32 = 111;

/// The result of a request to a vehicle.
pub type RequestResult = Result<Reply, StationError>;

/// A ground station without a face. Clones are handles to the same station.
#[derive(Clone)]
pub struct Station {
    pub(crate) shared: Arc<Shared>,
}

/// A vehicle of a station. Cheap to clone. The station lives as long as somebody holds it or one of its vehicles.
#[derive(Debug, Clone)]
pub struct VehicleHandle {
    pub(crate) station: Station,
    pub(crate) id: VehicleId,
    /// In whose name it acts; the station's own when absent.
    pub(crate) operator: Option<Arc<Operator>>,
}

pub(crate) struct Shared {
    pub(crate) config: StationConfig,
    runtime: Handle,
    hub: Hub,
    pub(crate) clock: Arc<dyn Clock>,
    core: Mutex<Core>,
    pub(crate) control: Control,
    /// In whose name the program that has the station acts.
    pub(crate) operator: Arc<Operator>,
    confirmations: Mutex<Confirmations>,
    heartbeat: AtomicBool,
    undecodable: AtomicU64,
    /// When the driver is set to wake, µs on our clock; an earlier deadline has to wake it.
    driver_alarm_us: AtomicU64,
    wake_driver: tokio::sync::Notify,
    closing: watch::Sender<bool>,
    /// How the recording was going when the driver looked last.
    health: watch::Sender<Option<RecorderStatus>>,
    /// The signing keys.
    pub(crate) vault: Option<Vault>,
    /// Why there are none, when they could not be read.
    pub(crate) vault_fault: Option<SigningError>,
    owned: Mutex<Owned>,
    records: Mutex<Option<Records>>,
}

/// What has to be ended in order.
#[derive(Default)]
struct Owned {
    links: Vec<LinkHandle>,
    recorder: Option<Recorder>,
    driver: Option<JoinHandle<()>>,
    keeper: Option<JoinHandle<()>>,
}

/// Everything that changes with each message; under one short lock, never held across an await.
pub(crate) struct Core {
    pub(crate) vehicles: Vehicles,
    /// What is remembered of vehicles from runs before.
    remembered: Vec<StoredRecord>,
    requests: HashMap<(VehicleId, RequestId), Finisher<RequestResult>>,
    /// Requests that have ended, and whose callers are told next.
    ended: Vec<(Finisher<RequestResult>, RequestResult)>,
    waiting: Vec<Waiting>,
    next_waiting: u64,
    pub(crate) watchers: HashMap<VehicleId, Watchers>,
    /// Those that are far away.
    pub(crate) adopted: HashMap<VehicleId, Adopted>,
    /// Of those who watch all vehicles at once.
    pub(crate) subscriptions: Subscriptions,
    /// Another station with our address.
    namesake: Namesake,
}

impl Core {
    fn end_requests(&mut self) {
        self.ended.drain(..).for_each(|(finisher, result)| finisher.finish(result));
    }
}

/// Somebody who waits for a vehicle.
struct Waiting {
    key: u64,
    wanted: Option<VehicleId>,
    since: MonoTime,
    finisher: Finisher<Result<VehicleHandle, StationError>>,
}

/// Who looks at a vehicle.
#[derive(Default)]
pub(crate) struct Watchers {
    pub(crate) changes: Arc<Changes>,
    pub(crate) subscriptions: Subscriptions,
    /// The protocol version that the vehicle speaks.
    pub(crate) version: MavVersion,
    /// From where it is heard, and whether all of that is one vehicle.
    pub(crate) sources: Sources,
    /// Whether it was told that another uses its id.
    is_contested: bool,
    /// Whether it asks for the ground's altitude where nobody here knows it.
    pub(crate) lacks_terrain: bool,
}

impl Station {
    /// Starts a station without links on a tokio runtime.
    ///
    /// # Errors
    /// [`StationError::BadSetting`] for a rate out of range.
    pub fn start(config: StationConfig, runtime: Handle) -> Result<Self, StationError> {
        let _guard = runtime.enter();
        Self::with_clock(config, runtime.clone(), Arc::new(SystemClock::new()))
    }

    /// Starts a station that lives by another clock.
    ///
    /// # Errors
    /// As [`Self::start`].
    pub fn with_clock(config: StationConfig, runtime: Handle, clock: Arc<dyn Clock>) -> Result<Self, StationError> {
        let hub = Hub::new(vec![config.address], clock.clone());
        let vehicle_config = VehicleConfig {
            streams: config.streams()?,
            // Two runs of the program shall not share MAVFTP session numbers.
            seed: clock.unix_us() as u32,
            // Who only listens sends nothing by itself.
            reads_back: config.request_streams,
            keeps_records: config.missions_dir.is_some(),
            ..VehicleConfig::default()
        };
        let start = |dir: &PathBuf| {
            let free_floor_bytes = config.space.floors().bytes(Class::Telemetry);
            let folder = Folder::new(dir).with_space(config.space.clone());
            let limits = RecorderConfig { free_floor_bytes, ..RecorderConfig::default() };
            Recorder::start_with(Box::new(folder), limits, clock.clone())
        };
        let recorder = config.record_dir.as_ref().map(start).transpose();
        let recorder = recorder.map_err(|error| StationError::CannotRecord { reason: error.to_string() })?;
        hub.set_recorder(recorder.as_ref().map(Recorder::handle));
        let remembered = config.missions_dir.as_deref().map(records::read_all).unwrap_or_default();
        let health = watch::channel(recorder.as_ref().map(Recorder::status)).0;
        // Keys that cannot be read keep nobody from flying; it is said.
        let vault = config.signing_dir.as_deref().map(|dir| Vault::open(dir, &hub)).transpose();
        let (vault, vault_fault) = match vault {
            Ok(vault) => (vault, None),
            Err(error) => {
                tracing::error!(%error, "nothing is signed, and nothing is checked");
                (None, Some(error))
            }
        };
        let control = Control::default();
        let operator = Arc::new(control.enlist(&config.operator, clock.now()).yielding());
        // It is there for as long as the station is.
        operator.attach(clock.now());
        let shared = Arc::new(Shared {
            health,
            control,
            operator,
            confirmations: Mutex::default(),
            runtime: runtime.clone(),
            core: Mutex::new(Core {
                vehicles: Vehicles::new(config.address, vehicle_config),
                remembered,
                requests: HashMap::new(),
                ended: Vec::new(),
                waiting: Vec::new(),
                next_waiting: 0,
                watchers: HashMap::new(),
                adopted: HashMap::new(),
                subscriptions: Subscriptions::default(),
                namesake: Namesake::default(),
            }),
            heartbeat: AtomicBool::new(config.heartbeat),
            undecodable: AtomicU64::new(0),
            driver_alarm_us: AtomicU64::new(0),
            wake_driver: tokio::sync::Notify::new(),
            closing: watch::channel(false).0,
            vault,
            vault_fault,
            owned: Mutex::new(Owned { recorder, ..Owned::default() }),
            records: Mutex::new(None),
            hub,
            clock,
            config,
        });
        let sink = {
            // The hub must not keep the station alive.
            let shared = Arc::downgrade(&shared);
            Arc::new(move |origin: Origin, frame: &Frame, now| {
                if let Some(shared) = shared.upgrade() {
                    shared.on_frame(origin, frame, now);
                }
            })
        };
        shared.hub.add_sink(SinkScope::All, sink);
        let weak = Arc::downgrade(&shared);
        shared.hub.set_on_read(Arc::new(move || {
            if let Some(shared) = weak.upgrade() {
                shared.on_read();
            }
        }));
        let weak = Arc::downgrade(&shared);
        shared.hub.set_on_open(Arc::new(move |link| {
            if let Some(shared) = weak.upgrade() {
                shared.on_link_open(link);
            }
        }));
        if let Some(folder) = shared.config.missions_dir.clone() {
            let weak = Arc::downgrade(&shared);
            let started = Records::start(folder, move |system, ticket| {
                if let Some(shared) = weak.upgrade() {
                    shared.on_kept(system, ticket);
                }
            });
            match started {
                Ok(records) => *shared.records() = Some(records),
                Err(error) => tracing::error!(%error, "what is known of missions cannot be written down"),
            }
        }
        let driver = runtime.spawn(drive(Arc::downgrade(&shared), shared.closing.subscribe()));
        shared.owned().driver = Some(driver);
        if shared.vault.is_some() {
            let keeper = runtime.spawn(keep_keys(Arc::downgrade(&shared), shared.closing.subscribe()));
            shared.owned().keeper = Some(keeper);
        }
        Ok(Self { shared })
    }

    /// Opens a link. It connects, and connects again, by itself for ever.
    ///
    /// # Errors
    /// [`StationError::Address`] for a link string that cannot be read, [`StationError::Link`] when there are too many,
    /// [`StationError::Closed`].
    pub fn open_link(&self, address: &str, options: LinkOptions) -> Result<LinkId, StationError> {
        let address: LinkAddress = address.parse()?;
        let _guard = self.shared.runtime.enter();
        // Under the lock that closing takes the links from, so that none is left over.
        let mut owned = self.shared.owned();
        if self.is_closed() {
            return Err(StationError::Closed);
        }
        let handle = self.shared.hub.open(address, options)?;
        let id = handle.id();
        owned.links.push(handle);
        Ok(id)
    }

    /// Closes a link and waits for its tasks to end.
    ///
    /// # Errors
    /// [`StationError::Link`] when there is no such link.
    pub async fn close_link(&self, id: LinkId) -> Result<(), StationError> {
        let handle = {
            let mut owned = self.shared.owned();
            let place = owned.links.iter().position(|link| link.id() == id);
            place.map(|place| owned.links.swap_remove(place))
        };
        let handle = handle.ok_or(StationError::Link(vencejo_link::LinkError::UnknownLink(id)))?;
        handle.close().await;
        Ok(())
    }

    /// The open links, in the order they were opened, and what was counted on each.
    pub fn links(&self) -> Vec<(LinkInfo, LinkStats)> {
        let links = self.shared.hub.links();
        links.into_iter().filter_map(|link| Some((link.clone(), self.shared.hub.stats(link.id).ok()?))).collect()
    }

    /// The address of a link's own socket while it is up: tells the port of a link that was opened with port 0.
    pub fn local_address(&self, id: LinkId) -> Option<SocketAddr> {
        self.shared.owned().links.iter().find(|link| link.id() == id)?.local_address()
    }

    /// The disk's free space, and how much of it stays free of what.
    pub fn space(&self) -> &Space {
        &self.shared.config.space
    }

    /// The recording's folder and state; `None` when nothing is recorded.
    pub fn recorder(&self) -> Option<(PathBuf, RecorderStatus)> {
        let dir = self.shared.config.record_dir.clone()?;
        Some((dir, self.shared.owned().recorder.as_ref().map(Recorder::status)?))
    }

    /// Turns to another status each time that the recording stops, goes on, or stops for another reason; seen within a second,
    /// whatever the disk does. `None` when nothing is recorded.
    pub fn recorder_changes(&self) -> watch::Receiver<Option<RecorderStatus>> {
        self.shared.health.subscribe()
    }

    /// Why what is known of the missions on board is not being written down.
    pub fn missions_fault(&self) -> Option<String> {
        self.shared.records().as_ref().and_then(Records::fault)
    }

    /// Frames so far that were no message of the dialect, or held a value that it does not allow.
    pub fn undecodable_frames(&self) -> u64 {
        self.shared.undecodable.load(Ordering::Relaxed)
    }

    /// Starts or stops our heartbeat.
    pub fn set_heartbeat(&self, enabled: bool) {
        self.shared.heartbeat.store(enabled, Ordering::Relaxed);
        self.shared.wake_driver.notify_one();
    }

    /// The link on which another station is heard that uses our own MAVLink address, and where that is in words.
    pub fn namesake(&self) -> Option<(LinkId, String)> {
        let origin = self.shared.core().namesake.heard(self.shared.clock.now())?;
        Some((origin.link, self.shared.hub.describe(origin)))
    }

    /// The present moment on the station's clock.
    pub fn now(&self) -> MonoTime {
        self.shared.clock.now()
    }

    /// Who may act on its vehicles.
    pub fn control(&self) -> &Control {
        &self.shared.control
    }

    /// The operator in whose name the program acts that started the station: whoever uses a vehicle's handle as it is.
    pub fn operator(&self) -> &Arc<Operator> {
        &self.shared.operator
    }

    /// Somebody else who may act; it is there while it acts, or is attached.
    pub fn enlist(&self, name: &str) -> Operator {
        self.shared.control.enlist(name, self.now())
    }

    /// The vehicles heard so far.
    pub fn vehicles(&self) -> Vec<VehicleHandle> {
        self.shared.core().vehicles.iter().map(|(system, _)| self.handle(system)).collect()
    }

    /// A vehicle by its id, if it was heard.
    pub fn vehicle(&self, id: impl Into<VehicleId>) -> Option<VehicleHandle> {
        let id = id.into();
        self.shared.core().vehicles.get(id).is_some().then(|| self.handle(id))
    }

    /// The messages of all vehicles from now on, also of those that are not heard yet, in the order in which they come: all or some
    /// ids, at most `capacity` waiting. One queue costs a fraction of one for each of many vehicles.
    pub fn subscribe_messages(&self, ids: Option<BTreeSet<u32>>, capacity: usize) -> Arc<DropOldest<Received>> {
        // Under the lock: closing ends what it finds there.
        let core = self.shared.core();
        if self.is_closed() { DropOldest::ended() } else { core.subscriptions.subscribe(ids, capacity) }
    }

    /// Waits for a vehicle, the first that is heard when none is named. Cancelling it ends it with
    /// [`StationError::NoVehicle`].
    pub fn wait_vehicle(&self, wanted: Option<VehicleId>) -> Pending<Result<VehicleHandle, StationError>> {
        let mut core = self.shared.core();
        let found = match wanted {
            Some(system) => core.vehicles.get(system).filter(|vehicle| is_heard(vehicle)).map(|_| system),
            None => core.vehicles.iter().find(|(_, vehicle)| is_heard(vehicle)).map(|(system, _)| system),
        };
        if let Some(system) = found {
            return Pending::ended(Ok(self.handle(system)));
        }
        if self.is_closed() {
            return Pending::ended(Err(StationError::Closed));
        }
        core.waiting.retain(|waiting| !waiting.finisher.is_abandoned());
        let key = core.next_waiting;
        core.next_waiting += 1;
        let shared = Arc::downgrade(&self.shared);
        let (finisher, pending) = Pending::new(move || {
            let Some(shared) = shared.upgrade() else { return };
            let waiting = {
                let mut core = shared.core();
                let place = core.waiting.iter().position(|waiting| waiting.key == key);
                place.map(|place| core.waiting.swap_remove(place))
            };
            if let Some(waiting) = waiting {
                let error = shared.no_vehicle(&waiting);
                waiting.finisher.finish(Err(error));
            }
        });
        core.waiting.push(Waiting { key, wanted, since: self.shared.clock.now(), finisher });
        pending
    }

    /// Ends everything: what is under way ends with [`StationError::Closed`], links and recording are closed and joined.
    /// May be called again.
    pub async fn close(&self) {
        self.shared.end_waits();
        let Owned { links, recorder, driver, keeper } = std::mem::take(&mut *self.shared.owned());
        if let Some(driver) = driver {
            // The driver ends by itself; a join error would be its panic, which has been reported already.
            let _ = driver.await;
        }
        for link in links {
            link.close().await;
        }
        if let Some(keeper) = keeper {
            // As with the driver.
            let _ = keeper.await;
            let kept = self.shared.blocking(|vault, hub| vault.follow(hub).and(vault.write_times(hub, true))).await;
            if let Err(error) = kept {
                tracing::error!(%error, "the times of the signing keys are not on disk");
            }
        }
        self.shared.hub.set_recorder(None);
        let records = self.shared.records().take();
        if let Some(records) = records {
            // It writes what waits, and waits for the disk.
            let closed = self.shared.runtime.spawn_blocking(move || records.close()).await;
            if let Err(error) = closed {
                tracing::error!(%error, "what is known of missions was not written to the end");
            }
        }
        if let Some(recorder) = recorder {
            // It waits for the disk, which the runtime's threads must not.
            let closed = self.shared.runtime.spawn_blocking(move || recorder.close()).await;
            match closed {
                Ok(status) => drop(self.shared.health.send_replace(Some(status))),
                Err(error) => tracing::error!(%error, "the recorder did not end in order"),
            }
        }
    }

    /// Whether [`Self::close`] was called.
    pub fn is_closed(&self) -> bool {
        *self.shared.closing.borrow()
    }

    fn handle(&self, id: VehicleId) -> VehicleHandle {
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

    fn owned(&self) -> MutexGuard<'_, Owned> {
        self.owned.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn records(&self) -> MutexGuard<'_, Option<Records>> {
        self.records.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// A record is on the disk, or cannot be.
    fn on_kept(self: &Arc<Self>, system: VehicleId, ticket: u64) {
        let now = self.clock.now();
        let mut core = self.core();
        if let Some(vehicle) = core.vehicles.get_mut(system) {
            vehicle.on_kept(ticket, now);
        }
        self.settle(&mut core, now);
    }

    pub(crate) fn hub(&self) -> &Hub {
        &self.hub
    }

    /// Tells when the recording stops or goes on. Only its thread waits for the disk, so this is looked at from here.
    fn look_at_recorder(&self) {
        let Some(status) = self.owned().recorder.as_ref().map(Recorder::status) else { return };
        self.health.send_if_modified(|known| {
            let of = |status: &RecorderStatus| (std::mem::discriminant(&status.state), status.since);
            let is_other = known.as_ref().map(of) != Some(of(&status));
            if is_other {
                match status.state.problem() {
                    Some(problem) => tracing::error!(problem, "telemetry is not being recorded"),
                    None => tracing::info!("telemetry is being recorded"),
                }
                *known = Some(status);
            }
            is_other
        });
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

    /// Closed from now on: everything that is waited for ends.
    fn end_waits(&self) {
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

    /// A frame from a link, in the task that read it.
    pub(crate) fn on_frame(self: &Arc<Self>, origin: Origin, frame: &Frame, now: MonoTime) {
        let link = origin.link;
        let Ok(message) = frame.decode() else {
            self.undecodable.fetch_add(1, Ordering::Relaxed);
            return;
        };
        let from = frame.source();
        if from == self.config.address && !self.hub.is_ours(frame) && !self.hub.is_replay(link) {
            self.on_namesake(origin, now);
            return;
        }
        let mut core = self.core();
        if !self.is_the_vehicles(&mut core, origin, from, &message, now) {
            return;
        }
        core.vehicles.on_message(from, &message, now);
        core.vehicles.on_protocol_version(from, frame.version());
        if frame.message_id() == TIMESYNC_ID
            && let Some(round_trip) = core.vehicles.get(from.system).and_then(Vehicle::round_trip)
        {
            // The link may just have been closed; then its figure matters to nobody.
            let _ = self.hub.note_round_trip(link, round_trip);
        }
        let version = core.vehicles.get(from.system).map(Vehicle::protocol_version);
        if version.is_some() {
            core.subscriptions.on_message(Some(link), frame, now);
        }
        if let Some(watchers) = core.watchers.get_mut(&from.system.into()) {
            watchers.version = version.unwrap_or_default();
            watchers.subscriptions.on_message(Some(link), frame, now);
            watchers.changes.notify();
        }
        self.carry_out(&mut core, now);
    }

    /// All that was read in one go has been heard. Whoever is told only now that a command was answered has nothing to ask
    /// for again before a second answer, which came along with the first, is taken for the next command's.
    pub(crate) fn on_read(&self) {
        self.core().end_requests();
    }

    /// Whether a message is of the vehicle that is followed under its id, and not of another that uses the same.
    fn is_the_vehicles(
        &self,
        core: &mut Core,
        origin: Origin,
        from: Address,
        message: &Message,
        now: MonoTime,
    ) -> bool {
        let Some(autopilot) = core.vehicles.get(from.system).map(Vehicle::address) else { return true };
        let Some(watchers) = core.watchers.get_mut(&from.system.into()) else { return true };
        let id = SourceId { link: origin.link.0, peer: origin.peer.0 };
        if autopilot != from {
            // Cameras and radios have no boot clock to go by; those of a known stranger are not the vehicle's.
            return !watchers.sources.is_rival(id);
        }
        let before = watchers.sources.followed();
        let taken = watchers.sources.on_message(id, message, now);
        if watchers.sources.followed() != before {
            // The one that is followed is where this message came from: only a message makes another one that.
            self.hub.choose(from, Some(origin));
        }
        if taken != Taken::Yes {
            self.tell_contest(watchers, from.system.into(), now);
        }
        if taken == Taken::Replaced
            && let Some(vehicle) = core.vehicles.get_mut(from.system)
        {
            vehicle.on_replaced(now);
        }
        taken != Taken::No
    }

    /// Tells when another vehicle begins or ends to use a vehicle's id.
    fn tell_contest(&self, watchers: &mut Watchers, system: VehicleId, now: MonoTime) {
        let rival = watchers.sources.rival(now);
        if rival.is_some() == watchers.is_contested {
            return;
        }
        watchers.is_contested = rival.is_some();
        let event = match rival {
            Some(rival) => {
                let place = self.hub.describe(origin_of(rival));
                tracing::warn!(vehicle = %system, %place, "another vehicle uses the same system id: it is not followed, and nothing is sent to it");
                VehicleEvent::Contested
            }
            None => {
                tracing::info!(vehicle = %system, "the other vehicle with the same system id is not heard any more");
                VehicleEvent::Uncontested
            }
        };
        watchers.subscriptions.on_event(&Observed { event, at: now });
        watchers.changes.notify();
    }

    /// Somebody else uses our own address.
    fn on_namesake(&self, origin: Origin, now: MonoTime) {
        if self.core().namesake.on_frame(origin, now) {
            let place = self.hub.describe(origin);
            tracing::warn!(address = %self.config.address, %place, "another station uses our MAVLink address; give one of the two another system id");
        }
    }

    /// Whether a vehicle hears us. Of a recording nobody can say.
    pub(crate) fn is_reached(&self, system: VehicleId) -> Option<bool> {
        let now = self.clock.now();
        let reached = self.core().vehicles.get(system)?.is_reached(now);
        reached.filter(|_| !self.is_replayed(system))
    }

    /// Whether a vehicle comes from a recording, which answers nothing.
    fn is_replayed(&self, system: VehicleId) -> bool {
        let link = system.system().and_then(|system| self.hub.links_of(system).first().copied());
        link.is_some_and(|(link, _)| self.hub.is_replay(link))
    }

    /// Where else a vehicle's id is used, in words.
    pub(crate) fn rival(&self, system: VehicleId) -> Option<String> {
        let now = self.clock.now();
        let rival = self.core().watchers.get(&system).and_then(|watchers| watchers.sources.rival(now))?;
        Some(self.hub.describe(origin_of(rival)))
    }

    /// Follows the other vehicle of that id; whether there is one.
    pub(crate) fn follow_rival(self: &Arc<Self>, system: VehicleId) -> bool {
        let now = self.clock.now();
        let mut core = self.core();
        let Some(autopilot) = core.vehicles.get(system).map(Vehicle::address) else { return false };
        let Some(watchers) = core.watchers.get_mut(&system) else { return false };
        let has_changed = watchers.sources.follow_rival(now);
        if has_changed {
            self.hub.choose(autopilot, watchers.sources.followed().map(origin_of));
            if let Some(vehicle) = core.vehicles.get_mut(system) {
                vehicle.on_replaced(now);
            }
            self.settle(&mut core, now);
        }
        has_changed
    }

    fn on_registry_event(self: &Arc<Self>, core: &mut Core, event: RegistryEvent) {
        match event {
            RegistryEvent::Appeared(id, address) => {
                tracing::info!(vehicle = %id, %address, "a vehicle is heard");
                self.greet(core, id);
                if !id.is_far() {
                    self.recall(core, id);
                }
            }
            RegistryEvent::Dropped(id, address) => {
                tracing::warn!(vehicle = %id, "a lost vehicle made room for another");
                // Its queues end with it, and whoever waits for news looks again.
                if core.adopted.remove(&id).is_none() {
                    self.hub.choose(address, None);
                }
                if let Some(watchers) = core.watchers.remove(&id) {
                    watchers.changes.notify();
                }
                let lost: Vec<_> = core.requests.keys().filter(|(of, _)| *of == id).copied().collect();
                for key in lost {
                    if let Some(finisher) = core.requests.remove(&key) {
                        finisher.finish(Err(VehicleError::NotHeard { age: LOST_AFTER }.into()));
                    }
                }
            }
            RegistryEvent::Full => {
                tracing::warn!("more vehicles are heard than can be followed; the others are ignored")
            }
            _ => {}
        }
    }

    /// Tells a vehicle that was heard for the first time what is remembered: at once by what was read when the station started,
    /// and by what another program may have written since.
    fn recall(self: &Arc<Self>, core: &mut Core, system: VehicleId) {
        let Some(folder) = self.records().as_ref().map(|records| records.folder().to_owned()) else { return };
        let (remembered, now) = (core.remembered.clone(), self.clock.now());
        if let Some(vehicle) = core.vehicles.get_mut(system) {
            vehicle.on_records(remembered, now);
        }
        let weak = Arc::downgrade(self);
        self.runtime.spawn_blocking(move || {
            let read = records::read_all(&folder);
            let Some(shared) = weak.upgrade() else { return };
            let now = shared.clock.now();
            let mut core = shared.core();
            if core.remembered != read {
                core.remembered.clone_from(&read);
                if let Some(vehicle) = core.vehicles.get_mut(system) {
                    vehicle.on_records(read, now);
                }
            }
            shared.settle(&mut core, now);
        });
    }

    /// A vehicle was heard for the first time.
    pub(crate) fn greet(self: &Arc<Self>, core: &mut Core, system: VehicleId) {
        core.watchers.entry(system).or_default();
        if !core.vehicles.get(system).is_some_and(is_heard) {
            return;
        }
        let is_theirs = |waiting: &mut Waiting| waiting.wanted.is_none_or(|wanted| wanted == system);
        for waiting in core.waiting.extract_if(.., is_theirs) {
            let station = Station { shared: self.clone() };
            waiting.finisher.finish(Ok(station.handle(system)));
        }
    }

    /// Does what the vehicles' state machines want, and tells the callers whose requests have ended.
    pub(crate) fn settle(self: &Arc<Self>, core: &mut Core, now: MonoTime) {
        self.carry_out(core, now);
        core.end_requests();
    }

    /// Does what the vehicles' state machines want, and sees to it that the driver wakes in time.
    fn carry_out(self: &Arc<Self>, core: &mut Core, now: MonoTime) {
        let mut unkept = Vec::new();
        while let Some(output) = core.vehicles.poll_output() {
            let (system, output) = match output {
                RegistryOutput::Vehicle(system, output) => (system, output),
                RegistryOutput::Event(event) => {
                    self.on_registry_event(core, event);
                    continue;
                }
            };
            match output {
                // Nothing that we send gets there.
                Output::Send(_) if core.adopted.contains_key(&system) => {}
                Output::Send(message) => {
                    let version = core.watchers.get(&system).map_or(MavVersion::V2, |watchers| watchers.version);
                    let report = self.hub.send_message(&message, self.config.address, version, Route::Target);
                    if !report.is_sent() {
                        tracing::debug!(vehicle = %system, message = message.name(), "not sent: no link is open to the vehicle");
                    }
                }
                Output::Progress { id, done, total } => {
                    if let Some(finisher) = core.requests.get(&(system, id)) {
                        finisher.progress(done, total);
                    }
                }
                Output::Finished { id, result } => {
                    if let Some(finisher) = core.requests.remove(&(system, id)) {
                        core.ended.push((finisher, result.map_err(StationError::from)));
                    }
                }
                Output::Event(VehicleEvent::Unreached | VehicleEvent::Reached) if self.is_replayed(system) => {}
                Output::Event(event) => {
                    match event {
                        VehicleEvent::Unreached => {
                            tracing::warn!(vehicle = %system, "the vehicle is heard, but answers nothing: it does not hear us");
                        }
                        VehicleEvent::Reached => tracing::info!(vehicle = %system, "the vehicle answers again"),
                        _ => {}
                    }
                    if let Some(watchers) = core.watchers.get(&system) {
                        watchers.subscriptions.on_event(&Observed { event, at: now });
                        watchers.changes.notify();
                    }
                }
                Output::Keep { ticket, stored } => match self.records().as_ref() {
                    Some(records) => records.keep(system, ticket, stored),
                    None => unkept.push((system, ticket)),
                },
                _ => {}
            }
            // Nobody writes them down (any more): who waits for it goes on.
            for (system, ticket) in std::mem::take(&mut unkept) {
                if let Some(vehicle) = core.vehicles.get_mut(system) {
                    vehicle.on_kept(ticket, now);
                }
            }
        }
        if core
            .vehicles
            .deadline()
            .is_some_and(|deadline| deadline.as_micros() < self.driver_alarm_us.load(Ordering::Relaxed))
        {
            self.wake_driver.notify_one();
        }
    }

    /// Starts a request to a vehicle.
    pub(crate) fn request(self: &Arc<Self>, system: VehicleId, request: Request) -> Pending<RequestResult> {
        let now = self.clock.now();
        let mut core = self.core();
        // Under the lock: closing ends what it finds there.
        if *self.closing.borrow() {
            return Pending::ended(Err(StationError::Closed));
        }
        let Some(vehicle) = core.vehicles.get_mut(system) else {
            return Pending::ended(Err(StationError::Vehicle(VehicleError::NotHeard { age: LOST_AFTER })));
        };
        let id = vehicle.request(request, now);
        let shared = Arc::downgrade(self);
        let (finisher, pending) = Pending::new(move || {
            let Some(shared) = shared.upgrade() else { return };
            let now = shared.clock.now();
            let mut core = shared.core();
            if let Some(vehicle) = core.vehicles.get_mut(system) {
                vehicle.cancel(id, now);
            }
            shared.settle(&mut core, now);
        });
        core.requests.insert((system, id), finisher);
        self.settle(&mut core, now);
        pending
    }

    /// Sends any message over a vehicle's link, unless the guard of one to whom it is addressed holds it back.
    pub(crate) fn send(
        self: &Arc<Self>,
        system: VehicleId,
        message: &Message,
        despite_mixed_plan: bool,
    ) -> Result<SendReport, StationError> {
        let now = self.clock.now();
        let mut core = self.core();
        let guarded = core.vehicles.on_sending(message, despite_mixed_plan, now);
        self.settle(&mut core, now);
        guarded?;
        let version = core.watchers.get(&system).map(|watchers| watchers.version).unwrap_or_default();
        Ok(self.hub.send_message(message, self.config.address, version, Route::Target))
    }

    /// Sends a vehicle what it asked for itself, over its link alone; `None` for one far away.
    pub(crate) fn answer(&self, id: VehicleId, message: &Message) -> Option<SendReport> {
        let version = self.core().watchers.get(&id).map(|watchers| watchers.version).unwrap_or_default();
        Some(self.hub.send_message(message, self.config.address, version, Route::System(id.system()?)))
    }

    /// Looks at a vehicle's state machine; `None` when it is not known (any more).
    pub(crate) fn with_vehicle<T>(&self, system: VehicleId, look: impl FnOnce(&Vehicle) -> T) -> Option<T> {
        self.core().vehicles.get(system).map(look)
    }

    /// A copy of a vehicle's telemetry and the moment that it was taken.
    pub(crate) fn telemetry(&self, system: VehicleId) -> (Telemetry, MonoTime) {
        let telemetry = self.with_vehicle(system, |vehicle| *vehicle.telemetry()).unwrap_or_default();
        (telemetry, self.clock.now())
    }

    fn no_vehicle(&self, waiting: &Waiting) -> StationError {
        let links: Vec<_> = self.hub.links().iter().map(describe).collect();
        StationError::NoVehicle {
            wanted: waiting.wanted,
            waited: self.clock.now().since(waiting.since),
            links: if links.is_empty() { "no link".into() } else { links.join(", ") },
        }
    }

    pub(crate) fn vault(&self) -> Result<&Vault, SigningError> {
        let fault = || self.vault_fault.clone().unwrap_or(SigningError::NoFolder);
        self.vault.as_ref().ok_or_else(fault)
    }

    /// Does something with the keys off the runtime's threads.
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

    /// Sends our heartbeat over a link that has just opened: a program that ends before the next beat was heard too.
    fn on_link_open(&self, link: LinkId) {
        if self.heartbeat.load(Ordering::Relaxed) {
            self.send_heartbeat(&self.core(), Route::Link(link), true);
        }
    }

    /// Sends our heartbeat, in the oldest version that a vehicle speaks: everybody reads MAVLink 1.
    ///
    /// With `invites` in MAVLink 2 besides: PX4 and ArduPilots of some years speak MAVLink 1 until they hear MAVLink 2, and
    /// begin so again when they restart.
    fn send_heartbeat(&self, core: &Core, route: Route, invites: bool) {
        let speaks_v1 = core.watchers.values().any(|watchers| watchers.version == MavVersion::V1);
        let version = if speaks_v1 { MavVersion::V1 } else { MavVersion::V2 };
        let send = |version| {
            let heartbeat = Message::Heartbeat(Heartbeat::default());
            // Links without a peer refuse it; there is nobody to miss it.
            let _ = self.hub.send_message(&heartbeat, self.config.address, version, route);
        };
        send(version);
        if speaks_v1 && invites {
            send(MavVersion::V2);
        }
    }
}

/// Whether its heartbeat was heard: one far away is there by its name before.
fn is_heard(vehicle: &Vehicle) -> bool {
    vehicle.telemetry().heartbeat.is_some()
}

fn origin_of(source: SourceId) -> Origin {
    Origin { link: LinkId(source.link), peer: PeerId(source.peer) }
}

/// A link and what is wrong with it, for a sentence.
fn describe(link: &LinkInfo) -> String {
    let state = match &link.state {
        LinkState::Connecting { last_error: Some(error), .. } => format!("not open: {error}"),
        LinkState::Connecting { last_error: None, .. } => "not open yet".into(),
        LinkState::Up { .. } => "open".into(),
        LinkState::Down => "closed".into(),
        LinkState::Ended { .. } => "played to its end".into(),
    };
    format!("{} ({state})", link.address)
}

/// Lets time pass for the vehicles and sends our heartbeat: from the loop that does the work, so that it stops with it.
async fn drive(shared: Weak<Shared>, mut closing: watch::Receiver<bool>) {
    let _guard = DriverGuard(shared.clone());
    let mut heartbeat_due = MonoTime::ZERO;
    let mut heartbeats = 0_u32;
    loop {
        let Some(strong) = shared.upgrade() else { return };
        let now = strong.clock.now();
        strong.look_at_recorder();
        strong.control.expire(now);
        let rest = {
            let mut core = strong.core();
            core.vehicles.on_time(now);
            strong.settle(&mut core, now);
            for (system, watchers) in &mut core.watchers {
                strong.tell_contest(watchers, *system, now);
            }
            if now >= heartbeat_due {
                if strong.heartbeat.load(Ordering::Relaxed) {
                    strong.send_heartbeat(&core, Route::All, heartbeats.is_multiple_of(INVITE_EVERY));
                    heartbeats = heartbeats.wrapping_add(1);
                }
                heartbeat_due = now + HEARTBEAT_INTERVAL;
            }
            let alarm = core.vehicles.deadline().map_or(heartbeat_due, |deadline| deadline.min(heartbeat_due));
            strong.driver_alarm_us.store(alarm.as_micros(), Ordering::Relaxed);
            alarm.since(now)
        };
        let woken = async {
            tokio::select! {
                () = tokio::time::sleep(rest) => {}
                () = strong.wake_driver.notified() => {}
            }
        };
        tokio::select! {
            () = woken => {}
            // An error means that the station is gone, which is an end as well.
            _ = closing.wait_for(|closing| *closing) => return,
        }
    }
}

/// Keeps keys and times in step with the disk, until the station ends.
async fn keep_keys(shared: Weak<Shared>, mut closing: watch::Receiver<bool>) {
    let mut looked = 0;
    loop {
        tokio::select! {
            () = tokio::time::sleep(LOOK) => {}
            // An error means that the station is gone, which is an end as well.
            _ = closing.wait_for(|closing| *closing) => return,
        }
        looked += 1;
        let write_times = looked % (WRITE_TIMES.as_secs() / LOOK.as_secs()) == 0;
        let Some(strong) = shared.upgrade() else { return };
        let kept = strong.blocking(move |vault, hub| {
            vault.follow(hub)?;
            vault.look(hub)?;
            if write_times { vault.write_times(hub, false) } else { Ok(()) }
        });
        if let Err(error) = kept.await {
            tracing::error!(%error, "signing keys or their times are not on disk");
        }
    }
}

/// Without the driver no time-out passes: when it ends for whatever reason, nobody waits for ever.
struct DriverGuard(Weak<Shared>);

impl Drop for DriverGuard {
    fn drop(&mut self) {
        if let Some(shared) = self.0.upgrade() {
            if std::thread::panicking() {
                tracing::error!("the station's driver panicked; the station is closed");
            }
            shared.end_waits();
        }
    }
}

#[cfg(test)]
mod tests;
