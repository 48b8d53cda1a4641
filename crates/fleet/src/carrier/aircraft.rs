//! The station on board: publishes the states of its aircraft, and executes the orders of the operator who has control.

use std::collections::{BTreeMap, BTreeSet, HashMap};
use std::path::PathBuf;
use std::sync::{Arc, Mutex, OnceLock, PoisonError};
use std::time::Duration;

use tokio::runtime::Handle;
use tokio::sync::{mpsc, watch};
use tokio::task::JoinHandle;
use vencejo_proto::MonoTime;
use vencejo_station::{DropOldest, Operator, Received, RequestResult, Silence, Station, Taken, VehicleHandle};
use vencejo_vehicle::telemetry::LOST_AFTER;

use self::holdings::{Holdings, PARAM_VALUE};
use self::place::Place;
use self::work::UnderWay;
use super::endpoint::{Endpoint, Transport};
use super::history::{Board, Entry, HistoryConfig};
use super::membership::Membership;
use super::network;
use crate::authority::{Authority, Claim, Role};
use crate::budget::Audience;
use crate::error::FleetError;
use crate::key::{Kind, Name, key_of};
use crate::operator::random;
use crate::payload::{Event, State};
use crate::signature::PublicKey;
use crate::stamp::Stamper;
use crate::state_source::{EACH, NEWEST, StateSource};

mod doing;
mod holdings;
mod orders;
pub(super) mod place;
mod session;
#[cfg(test)]
pub(super) mod tests;
mod work;

/// How often messages of the autopilot are processed: twice the highest rate of states.
const TICK: Duration = Duration::from_millis(50);
/// The pause before a router is dialled again.
const AGAIN: Duration = Duration::from_secs(1);
/// The interval of states for the history while nothing is sent: each is fetched later, over a link that may be slow.
const UNHEARD: Duration = Duration::from_millis(500);
/// Most messages of the autopilot that wait for a tick.
const WAITING: usize = 1024;

/// How an aircraft takes part in a fleet.
#[derive(Debug, Clone)]
pub struct AircraftConfig {
    /// The organisation.
    pub org: Name,
    /// Its name there.
    pub name: Name,
    /// The routers, in the order in which they are tried; empty: those of its membership.
    pub dial: Vec<Endpoint>,
    /// Its membership with its certificate, and its file: for TLS and QUIC.
    pub member: Option<(Membership, PathBuf)>,
    /// Keys whose orders it accepts, besides those on its fleet's list of ground stations.
    pub trust: BTreeMap<PublicKey, Role>,
    /// Capacity of the uplink, bit/s, if known.
    pub uplink_bit_s: Option<f64>,
    /// Where its history is kept; `None` keeps none.
    pub history: Option<HistoryConfig>,
}

/// The status of an aircraft.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct AircraftStatus {
    /// Whether a router is reached.
    pub is_connected: bool,
    /// The network's error when it is not.
    pub problem: Option<String>,
    /// Who has control, near or far.
    pub holder: Option<String>,
    /// States sent per second.
    pub rate_hz: f64,
    /// When its certificate ends, seconds since 1970.
    pub certificate_ends: Option<u64>,
    /// The silence of its autopilot, once it lasts 5 s; that of one that was never heard lasts since the start.
    pub silence: Option<Silence>,
}

/// An aircraft of a fleet, seen from on board.
pub struct Aircraft {
    station: Station,
    began: MonoTime,
    /// The vehicle, once it is heard.
    vehicle: Arc<OnceLock<VehicleHandle>>,
    status: Arc<Mutex<AircraftStatus>>,
    stop: watch::Sender<bool>,
    task: Mutex<Option<JoinHandle<()>>>,
}

impl Aircraft {
    /// Represents the first vehicle that the station hears, and dials the routers for ever. From now on the station
    /// sends its heartbeat only while an operator has control: the autopilot's ground-station failsafe counts it.
    ///
    /// # Errors
    /// [`FleetError::Address`] without a router, [`FleetError::NoCertificates`], [`FleetError::NoRandom`],
    /// [`FleetError::File`] when its history cannot be written.
    pub fn start(station: Station, config: AircraftConfig, runtime: &Handle) -> Result<Self, FleetError> {
        if config.dial.is_empty() && config.member.is_none() {
            return Err(FleetError::Address(String::new()));
        }
        for router in config.dial.iter().filter(|router| router.transport() != Transport::Tcp) {
            let why = "join the fleet first, with --join TOKEN".to_owned();
            config.member.as_ref().ok_or_else(|| FleetError::NoCertificates(router.to_string(), why))?;
        }
        let (boot, stamper) = (u64::from_be_bytes(random()?), Stamper::new(&random()?));
        let authority = Authority::new(boot, station.now(), stamper.clone());
        let history = config.history.as_ref().map(|history| {
            Board::start(&config.org, &config.name, boot, config.uplink_bit_s, history).map_err(|error| {
                FleetError::File { path: history.folder.display().to_string(), problem: error.to_string() }
            })
        });
        let history = history.transpose()?;
        let status = Arc::new(Mutex::new(AircraftStatus::default()));
        let (stop, mut stopped) = watch::channel(false);
        station.set_heartbeat(false);
        let (shown, heard) = (status.clone(), Arc::new(OnceLock::new()));
        let (of, began, vehicle) = (station.clone(), station.now(), heard.clone());
        let task = runtime.spawn(async move {
            tokio::select! {
                () = live(&station, &config, (authority, stamper), (&shown, &heard), history.as_ref()) => {}
                // An error means that the handle was dropped: end too.
                _ = stopped.wait_for(|stopped| *stopped) => {}
            }
            station.set_heartbeat(false);
            if let Some(history) = history {
                history.close().await;
            }
        });
        Ok(Self { station: of, began, vehicle, status, stop, task: Mutex::new(Some(task)) })
    }

    /// The status.
    pub fn status(&self) -> AircraftStatus {
        let heard_at = self.vehicle.get().map_or(Some(self.began), VehicleHandle::heard_at);
        let silence = heard_at.and_then(|heard_at| silence(&self.station, heard_at));
        AircraftStatus { silence, ..self.status.lock().unwrap_or_else(PoisonError::into_inner).clone() }
    }

    /// Leaves the fleet. May be called again.
    pub async fn close(&self) {
        self.stop.send_replace(true);
        let task = self.task.lock().unwrap_or_else(PoisonError::into_inner).take();
        if let Some(task) = task {
            // A join error is a panic, which has been reported.
            let _ = task.await;
        }
    }
}

/// The silence of an autopilot that was last heard then, once it lasts.
fn silence(station: &Station, heard_at: MonoTime) -> Option<Silence> {
    let lasts = station.now().since(heard_at);
    (lasts >= LOST_AFTER).then(|| Silence { lasts, links: station.describe_links() })
}

/// Waits for the vehicle and serves one router after the other, for ever.
async fn live(
    station: &Station,
    config: &AircraftConfig,
    (mut authority, stamper): (Authority, Stamper),
    (status, heard_vehicle): (&Mutex<AircraftStatus>, &OnceLock<VehicleHandle>),
    history: Option<&Board>,
) {
    let Some(Ok(vehicle)) = station.wait_vehicle(None).wait().await else { return };
    let vehicle = heard_vehicle.get_or_init(|| vehicle);
    let Some(address) = vehicle.address() else { return };
    let mut source = StateSource::new(authority.boot(), address, stamper);
    let ids: BTreeSet<u32> = NEWEST.iter().chain(&EACH).chain(&[PARAM_VALUE]).copied().collect();
    let heard = vehicle.subscribe_messages(Some(ids), WAITING);
    let frames = history.is_some_and(|history| history.has_frames).then(|| vehicle.subscribe_messages(None, WAITING));
    let mut post = Post::new(station, vehicle, config, status);
    (post.history, post.frames) = (history, frames);
    let mut failures = 0;
    for turn in 0.. {
        let routers = post.routers();
        let Some(router) = routers.get(turn % routers.len().max(1)) else { return };
        let identity = post.place.as_ref().map(|place| place.member.identity());
        let dialled = network::dial(std::slice::from_ref(router), identity.as_ref());
        let end = match post.meanwhile(&mut source, &mut authority, &heard, dialled).await {
            Ok(session) => {
                failures = 0;
                post.router = Some(router.clone());
                post.certificate_ends = post.place.as_ref().and_then(|place| Some(place.member.facts().ok()?.ends));
                let end = post.serve(&session, &mut source, &mut authority, &heard, routers.len() > 1).await;
                // Closing ends its declarations even if it fails.
                let _ = session.close().await;
                end
            }
            Err(error) => Err(error),
        };
        let problem = match end {
            Ok(Ended::Closed) => return,
            Ok(Ended::Renewed) => continue,
            Err(error) => error.to_string(),
        };
        tracing::debug!(problem, "the router is not reached");
        failures += 1;
        {
            let mut status = status.lock().unwrap_or_else(PoisonError::into_inner);
            // A router is away for a moment when it admits a new member: the cause is reported at the second failure.
            (status.is_connected, status.problem) = (false, Some(problem).filter(|_| failures > 1));
        }
        // Another router is dialled at once; after all of them follows a pause.
        if (turn + 1) % routers.len() == 0 {
            post.meanwhile(&mut source, &mut authority, &heard, tokio::time::sleep(AGAIN)).await;
        }
    }
}

/// Why a session ended where nothing was wrong.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Ended {
    /// The station was closed.
    Closed,
    /// There is a new certificate for the next session.
    Renewed,
}

/// The operator who has the lease.
struct Acting {
    key: PublicKey,
    /// The name under which the operator was enlisted.
    name: String,
    operator: Arc<Operator>,
}

/// A list of parameters that is being read.
struct Reading {
    /// The order for which it was begun.
    id: u128,
    /// The orders that it answers.
    claims: Vec<Claim>,
}

/// The state of the station on board across sessions.
struct Post<'a> {
    station: &'a Station,
    vehicle: &'a VehicleHandle,
    config: &'a AircraftConfig,
    status: &'a Mutex<AircraftStatus>,
    place: Option<Place>,
    /// Keys whose orders it accepts.
    trust: BTreeMap<PublicKey, Role>,
    /// Names of ground stations, by key.
    names: BTreeMap<PublicKey, String>,
    /// When its certificate ends.
    certificate_ends: Option<u64>,
    /// The router of this session.
    router: Option<Endpoint>,
    order_key: String,
    under_way: HashMap<u128, UnderWay>,
    holdings: Holdings,
    /// The parameters that are being read.
    reading: Option<Reading>,
    ended: mpsc::Sender<(Claim, RequestResult)>,
    ends: mpsc::Receiver<(Claim, RequestResult)>,
    /// The operator in whose name orders are executed: the holder of the lease.
    acting: Option<Acting>,
    /// The history of states and orders.
    history: Option<&'a Board>,
    /// All frames of the autopilot, if they are kept.
    frames: Option<Arc<DropOldest<Received>>>,
    /// When the next state is made for the history while nothing is sent.
    unheard_due: MonoTime,
    /// When the next unauthenticated order may be kept.
    stranger_due: MonoTime,
}

impl<'a> Post<'a> {
    fn new(
        station: &'a Station,
        vehicle: &'a VehicleHandle,
        config: &'a AircraftConfig,
        status: &'a Mutex<AircraftStatus>,
    ) -> Self {
        let (ended, ends) = mpsc::channel(64);
        let order_key = key_of(&config.org, &config.name, Kind::Order);
        let mut post = Self {
            station,
            vehicle,
            config,
            status,
            place: config.member.clone().map(Place::new),
            trust: BTreeMap::new(),
            names: BTreeMap::new(),
            certificate_ends: None,
            router: None,
            order_key,
            under_way: HashMap::new(),
            holdings: Holdings::new(vehicle, config.uplink_bit_s),
            reading: None,
            ended,
            ends,
            acting: None,
            history: None,
            frames: None,
            unheard_due: MonoTime::ZERO,
            stranger_due: MonoTime::ZERO,
        };
        (post.trust, post.names) = post.trusted();
        post
    }

    /// Keys whose orders it accepts: those on the list of its fleet, and the configured ones, whose roles take
    /// precedence; and the names on that list.
    fn trusted(&self) -> (BTreeMap<PublicKey, Role>, BTreeMap<PublicKey, String>) {
        let list = self.place.as_ref().and_then(|place| place.member.stations().ok()).unwrap_or_default();
        let mut trusted = list.roles();
        trusted.extend(&self.config.trust);
        (trusted, list.names())
    }

    /// The routers, in the order in which they are tried.
    fn routers(&self) -> Vec<Endpoint> {
        let listed = || self.place.as_ref().and_then(|place| place.member.routers().ok()).unwrap_or_default();
        if self.config.dial.is_empty() { listed() } else { self.config.dial.clone() }
    }

    /// Processes messages of the autopilot; returns the events.
    fn listen(&mut self, source: &mut StateSource, heard: &DropOldest<Received>) -> Vec<Event> {
        let mut events = Vec::new();
        while let Taken::Item(received) = heard.take_ready() {
            if received.frame.message_id() == PARAM_VALUE {
                self.holdings.on_param(&received.frame);
            }
            events.extend(source.on_frame(&received.frame, received.at));
        }
        events.iter().for_each(|event| self.keep(&Entry::Event(event)));
        while let Some(Taken::Item(received)) = self.frames.as_ref().map(|frames| frames.take_ready()) {
            self.keep(&Entry::Frame(received.frame.bytes()));
        }
        events
    }

    /// When the autopilot was last heard, if it is silent, and its silence.
    fn silence(&self) -> Option<(MonoTime, Silence)> {
        let heard_at = self.vehicle.heard_at()?;
        Some((heard_at, silence(self.station, heard_at)?))
    }

    /// Has the state that is made next tell of it. Not earlier: its links are described for that.
    fn tell_silence(&self, source: &mut StateSource) {
        source.on_silence(self.silence().map(|(since, silence)| (since, silence.links)));
    }

    fn keep(&self, told: &Entry<'_>) {
        if let Some(history) = self.history {
            history.keep(told, self.station.now());
        }
    }

    /// The next state of the numbered series, with plans and progress of orders.
    fn sample(&mut self, source: &mut StateSource, authority: &Authority, audience: Audience) -> State {
        self.tell_silence(source);
        let (held, now) = (authority.held(), self.station.now());
        let state = if audience == Audience::Holder { source.sample(held, now) } else { source.sparing(held, now) };
        let mut state = self.holdings.dress(state, true);
        state.under_way = self.progress();
        self.keep(&Entry::State(&state));
        self.unheard_due = self.station.now() + UNHEARD;
        state
    }

    /// Makes a state for the history only, when it is due.
    fn unheard(&mut self, source: &mut StateSource, authority: &Authority) {
        if self.history.is_some() && self.station.now() >= self.unheard_due {
            self.sample(source, authority, Audience::Nobody);
        }
    }

    /// Awaits `what` while no router is reached: leases expire, and the history goes on.
    async fn meanwhile<T>(
        &mut self,
        source: &mut StateSource,
        authority: &mut Authority,
        heard: &DropOldest<Received>,
        what: impl Future<Output = T>,
    ) -> T {
        let mut what = std::pin::pin!(what);
        let mut tick = tokio::time::interval(TICK);
        tick.set_missed_tick_behavior(tokio::time::MissedTickBehavior::Delay);
        loop {
            tokio::select! {
                done = &mut what => return done,
                _ = tick.tick() => {
                    self.listen(source, heard);
                    self.holdings.look(self.vehicle);
                    authority.on_time(self.station.now());
                    self.keep_order(authority);
                    self.unheard(source, authority);
                }
            }
        }
    }
}
