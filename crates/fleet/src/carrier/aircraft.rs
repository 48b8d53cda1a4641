//! The station on board: tells where its aircraft is, and does what whoever has control orders.

use std::collections::{BTreeMap, BTreeSet, HashMap};
use std::path::PathBuf;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

use tokio::runtime::Handle;
use tokio::sync::{mpsc, watch};
use tokio::task::JoinHandle;
use vencejo_proto::MonoTime;
use vencejo_station::{DropOldest, Operator, Received, RequestResult, Station, Taken, VehicleHandle};

use self::holdings::{Holdings, PARAM_VALUE};
use self::place::Place;
use self::work::UnderWay;
use super::endpoint::{Endpoint, Way};
use super::history::{Board, HistoryConfig, Told};
use super::membership::Membership;
use super::network;
use crate::authority::{Authority, Claim, Role};
use crate::error::FleetError;
use crate::key::{Kind, Name, key_of};
use crate::operator::random;
use crate::payload::{Event, State};
use crate::seal::Seal;
use crate::signature::PublicKey;
use crate::speech::{EACH, NEWEST, Speaker};

mod doing;
mod holdings;
mod orders;
pub(super) mod place;
mod session;
#[cfg(test)]
pub(super) mod tests;
mod work;

/// How often what the autopilot said is looked at: twice as often as it is told at most.
const TICK: Duration = Duration::from_millis(50);
/// How long to wait before a router is dialled again.
const AGAIN: Duration = Duration::from_secs(1);
/// How often a state is made for the history while nobody hears it: each is fetched later, over a way that may be narrow.
const UNHEARD: Duration = Duration::from_millis(500);
/// Messages of the autopilot that wait for a tick at most.
const WAITING: usize = 1024;

/// How an aircraft takes part in a fleet.
#[derive(Debug, Clone)]
pub struct AircraftConfig {
    /// The organisation.
    pub org: Name,
    /// Its name there.
    pub name: Name,
    /// The routers, in the order in which they are tried; empty: those that its place in the fleet names.
    pub dial: Vec<Endpoint>,
    /// Its place in the fleet, with its certificate, and the file that has it: for TLS and QUIC.
    pub member: Option<(Membership, PathBuf)>,
    /// Whose orders it takes, beside those on its fleet's list of ground stations.
    pub trust: BTreeMap<PublicKey, Role>,
    /// What the uplink carries, where that is known, bit/s.
    pub uplink_bit_s: Option<f64>,
    /// Where its history is kept; nowhere: `None`.
    pub history: Option<HistoryConfig>,
}

/// How it goes.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct AircraftStatus {
    /// Whether a router is reached.
    pub is_connected: bool,
    /// What the network said when it was not.
    pub problem: Option<String>,
    /// Who has control, near or far.
    pub holder: Option<String>,
    /// States told a second.
    pub rate_hz: f64,
    /// When its certificate ends, seconds since 1970.
    pub certificate_ends: Option<u64>,
}

/// An aircraft of a fleet, seen from on board.
pub struct Aircraft {
    status: Arc<Mutex<AircraftStatus>>,
    stop: watch::Sender<bool>,
    task: Mutex<Option<JoinHandle<()>>>,
}

impl Aircraft {
    /// Speaks for the first vehicle that the station hears, from when it hears it, and reaches for the router for ever. From now on the
    /// station's heartbeat goes out only while somebody has control: the autopilot's ground-station failsafe counts it.
    ///
    /// # Errors
    /// [`FleetError::Address`] without a router, [`FleetError::NoCertificates`], [`FleetError::NoRandom`], [`FleetError::File`] where no thread
    /// writes its history.
    pub fn start(station: Station, config: AircraftConfig, runtime: &Handle) -> Result<Self, FleetError> {
        if config.dial.is_empty() && config.member.is_none() {
            return Err(FleetError::Address(String::new()));
        }
        for router in config.dial.iter().filter(|router| router.way() != Way::Tcp) {
            let why = "join the fleet first, with --join TOKEN".to_owned();
            config.member.as_ref().ok_or_else(|| FleetError::NoCertificates(router.to_string(), why))?;
        }
        let (boot, seal) = (u64::from_be_bytes(random()?), Seal::new(&random()?));
        let authority = Authority::new(boot, station.now(), seal.clone());
        let history = config.history.as_ref().map(|history| {
            Board::start(&config.org, &config.name, boot, config.uplink_bit_s, history).map_err(|error| {
                FleetError::File { path: history.folder.display().to_string(), problem: error.to_string() }
            })
        });
        let history = history.transpose()?;
        let status = Arc::new(Mutex::new(AircraftStatus::default()));
        let (stop, mut stopped) = watch::channel(false);
        station.set_heartbeat(false);
        let shown = status.clone();
        let task = runtime.spawn(async move {
            tokio::select! {
                () = live(&station, &config, (authority, seal), &shown, history.as_ref()) => {}
                // An error means that nobody holds the handle any more: the end as well.
                _ = stopped.wait_for(|stopped| *stopped) => {}
            }
            station.set_heartbeat(false);
            if let Some(history) = history {
                history.close().await;
            }
        });
        Ok(Self { status, stop, task: Mutex::new(Some(task)) })
    }

    /// How it goes.
    pub fn status(&self) -> AircraftStatus {
        self.status.lock().unwrap_or_else(PoisonError::into_inner).clone()
    }

    /// Leaves the fleet. May be called again.
    pub async fn close(&self) {
        self.stop.send_replace(true);
        let task = self.task.lock().unwrap_or_else(PoisonError::into_inner).take();
        if let Some(task) = task {
            // A join error would be its panic, which has been reported already.
            let _ = task.await;
        }
    }
}

/// Waits for the vehicle and the router, then flies; for ever.
async fn live(
    station: &Station,
    config: &AircraftConfig,
    (mut authority, seal): (Authority, Seal),
    status: &Arc<Mutex<AircraftStatus>>,
    history: Option<&Board>,
) {
    let Some(Ok(vehicle)) = station.wait_vehicle(None).wait().await else { return };
    let Some(address) = vehicle.address() else { return };
    let mut speaker = Speaker::new(authority.boot(), address, seal);
    let ids: BTreeSet<u32> = NEWEST.iter().chain(&EACH).chain(&[PARAM_VALUE]).copied().collect();
    let heard = vehicle.subscribe_messages(Some(ids), WAITING);
    let frames = history.is_some_and(|history| history.has_frames).then(|| vehicle.subscribe_messages(None, WAITING));
    let mut post = Post::new(station, &vehicle, config, status);
    (post.history, post.frames) = (history, frames);
    for turn in 0.. {
        let routers = post.routers();
        let Some(router) = routers.get(turn % routers.len().max(1)) else { return };
        let identity = post.place.as_ref().map(|place| place.member.identity());
        let dialled = network::dial(std::slice::from_ref(router), identity.as_ref());
        let end = match post.meanwhile(&mut speaker, &mut authority, &heard, dialled).await {
            Ok(session) => {
                post.router = Some(router.clone());
                post.certificate_ends = post.place.as_ref().and_then(|place| Some(place.member.facts().ok()?.ends));
                let end = post.serve(&session, &mut speaker, &mut authority, &heard, routers.len() > 1).await;
                // Its end is the end of what it declared, whatever it says.
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
        {
            let mut status = status.lock().unwrap_or_else(PoisonError::into_inner);
            (status.is_connected, status.problem) = (false, Some(problem));
        }
        // Another router is dialled at once; a pause is made when all have had their turn.
        if (turn + 1) % routers.len() == 0 {
            post.meanwhile(&mut speaker, &mut authority, &heard, tokio::time::sleep(AGAIN)).await;
        }
    }
}

/// Why a session ended where nothing was wrong.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Ended {
    /// The station was closed.
    Closed,
    /// There is a new certificate, which the next one shows.
    Renewed,
}

/// Who has the lease.
struct Acting {
    key: PublicKey,
    /// As it was told, for whom the operator was enlisted.
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

/// What is done for those far away, from session to session.
struct Post<'a> {
    station: &'a Station,
    vehicle: &'a VehicleHandle,
    config: &'a AircraftConfig,
    status: &'a Mutex<AircraftStatus>,
    place: Option<Place>,
    /// Whose orders it takes.
    trust: BTreeMap<PublicKey, Role>,
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
    /// In whose name orders are done here: whoever has the lease.
    acting: Option<Acting>,
    /// What is told and ordered, kept.
    history: Option<&'a Board>,
    /// All that the autopilot says, where that is kept.
    frames: Option<Arc<DropOldest<Received>>>,
    /// When a state is made for the history although nobody hears it.
    unheard_due: MonoTime,
    /// Not before is an order of a stranger kept.
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
        post.trust = post.trusted();
        post
    }

    /// Whose orders it takes: those on the list of its fleet, and those that it was told of here, whose roles go before the list's.
    fn trusted(&self) -> BTreeMap<PublicKey, Role> {
        let mut trusted = self.place.as_ref().and_then(|place| place.member.roles().ok()).unwrap_or_default();
        trusted.extend(&self.config.trust);
        trusted
    }

    /// The routers, in the order in which they are tried.
    fn routers(&self) -> Vec<Endpoint> {
        let listed = || self.place.as_ref().and_then(|place| place.member.routers().ok()).unwrap_or_default();
        if self.config.dial.is_empty() { listed() } else { self.config.dial.clone() }
    }

    /// Takes in what the autopilot said; gives the events.
    fn listen(&mut self, speaker: &mut Speaker, heard: &DropOldest<Received>) -> Vec<Event> {
        let mut events = Vec::new();
        while let Taken::Item(received) = heard.take_ready() {
            if received.frame.message_id() == PARAM_VALUE {
                self.holdings.on_param(&received.frame);
            }
            events.extend(speaker.on_frame(&received.frame, received.at));
        }
        events.iter().for_each(|event| self.keep(&Told::Event(event)));
        while let Some(Taken::Item(received)) = self.frames.as_ref().map(|frames| frames.take_ready()) {
            self.keep(&Told::Frame(received.frame.bytes()));
        }
        events
    }

    fn keep(&self, told: &Told<'_>) {
        if let Some(history) = self.history {
            history.keep(told, self.station.now());
        }
    }

    /// The next state of the numbered series, with what is known of plans and orders.
    fn sample(&mut self, speaker: &mut Speaker, authority: &Authority) -> State {
        let mut state = self.holdings.dress(speaker.sample(authority.held(), self.station.now()), true);
        state.under_way = self.progress();
        self.keep(&Told::State(&state));
        self.unheard_due = self.station.now() + UNHEARD;
        state
    }

    /// Makes a state that nobody hears, for the history, where it is time.
    fn unheard(&mut self, speaker: &mut Speaker, authority: &Authority) {
        if self.history.is_some() && self.station.now() >= self.unheard_due {
            self.sample(speaker, authority);
        }
    }

    /// Does something while no router is reached: time passes, and the history goes on.
    async fn meanwhile<T>(
        &mut self,
        speaker: &mut Speaker,
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
                    self.listen(speaker, heard);
                    self.holdings.look(self.vehicle);
                    authority.on_time(self.station.now());
                    self.keep_order(authority);
                    self.unheard(speaker, authority);
                }
            }
        }
    }
}
