//! The station on board: tells where its aircraft is, and does what whoever has control orders.

use std::collections::{BTreeMap, BTreeSet, HashMap};
use std::path::PathBuf;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

use prost::Message;
use tokio::runtime::Handle;
use tokio::sync::{mpsc, watch};
use tokio::task::JoinHandle;
use vencejo_proto::MonoTime;
use vencejo_station::{DropOldest, Operator, Received, RequestResult, Station, Taken, VehicleHandle};
use zenoh::Session;
use zenoh::qos::Priority;

use self::holdings::{Holdings, PARAM_VALUE};
use self::place::{Place, Renewed};
use self::work::UnderWay;
use super::endpoint::{Endpoint, Way};
use super::history::{Board, HistoryConfig, Told};
use super::membership::Membership;
use super::network;
use crate::authority::{Authority, Claim, Role};
use crate::budget::{Audience, Budget, ECHO_LOST};
use crate::error::FleetError;
use crate::key::{Kind, Name, echo_key, key_of};
use crate::operator::random;
use crate::payload::{Event, State};
use crate::seal::Seal;
use crate::signature::PublicKey;
use crate::speech::{EACH, NEWEST, Speaker};

mod doing;
mod holdings;
mod orders;
pub(super) mod place;
#[cfg(test)]
pub(super) mod tests;
mod work;

/// How often what the autopilot said is looked at: twice as often as it is told at most.
const TICK: Duration = Duration::from_millis(50);
/// How long to wait before a router is dialled again.
const AGAIN: Duration = Duration::from_secs(1);
/// Echoes lost in a row after which a session is opened anew: one that looks alive may not be.
const DEAD_AFTER: u32 = 30;
/// The same where there is another router to go to.
const DEAD_BESIDE_OTHERS: u32 = 8;
/// How long Zenoh may take to be with a router again before another is dialled, where there is one.
const GONE_BESIDE_OTHERS: Duration = Duration::from_secs(1);
/// Echoes lost in a row after which it is told: a router that does not know an aircraft answers nothing.
const TELL_AFTER: u32 = 3;
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
    /// The order for which the parameters are being read, and those that wait for the same.
    reading: Option<(u128, Vec<Claim>)>,
    ended: mpsc::Sender<(Claim, RequestResult)>,
    ends: mpsc::Receiver<(Claim, RequestResult)>,
    /// In whose name orders are done here: whoever has the lease.
    acting: Option<(PublicKey, Arc<Operator>)>,
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

    /// Until the station is closed, or the session is dead.
    async fn serve(
        &mut self,
        session: &Session,
        speaker: &mut Speaker,
        authority: &mut Authority,
        heard: &DropOldest<Received>,
        has_others: bool,
    ) -> Result<Ended, FleetError> {
        let patience = if has_others { DEAD_BESIDE_OTHERS } else { DEAD_AFTER };
        let key = |kind| key_of(&self.config.org, &self.config.name, kind);
        let (state_key, event_key, list_key) = (key(Kind::State), key(Kind::Event), key(Kind::List));
        let declared = network::failed;
        let orders = session.declare_queryable(self.order_key.clone()).complete(true).await.map_err(declared)?;
        let states = session.declare_queryable(state_key.clone()).complete(true).await.map_err(declared)?;
        let events = session.declare_queryable(event_key.clone()).complete(true).await.map_err(declared)?;
        let lists = session.declare_queryable(list_key.clone()).complete(true).await.map_err(declared)?;
        let _answering = match self.history {
            Some(history) => Some(history.answer(session).await?),
            None => None,
        };
        let _token = session.liveliness().declare_token(key(Kind::Alive)).await.map_err(declared)?;
        // For whether anybody hears it. A router whose access control does not let it say so is believed only when no ground station
        // answers the echo either.
        let voice = session.declare_publisher(state_key.clone()).await.map_err(declared)?;
        let hearers = voice.matching_listener().await.map_err(declared)?;
        let mut has_hearers = voice.matching_status().await.map_err(declared)?.matching();
        let mut is_with_since = self.station.now();
        let mut budget = Budget::new(self.config.uplink_bit_s, self.station.now());
        let (echoed, mut echoes) = mpsc::channel(4);
        let (mut sample_due, mut echo_due, mut lost) = (MonoTime::ZERO, MonoTime::ZERO, 0);
        let (numbered, mut numbers) = mpsc::channel(4);
        let (renewed, mut renewals) = mpsc::channel(4);
        let mut tick = tokio::time::interval(TICK);
        tick.set_missed_tick_behavior(tokio::time::MissedTickBehavior::Delay);
        loop {
            tokio::select! {
                _ = tick.tick() => {
                    let now = self.station.now();
                    for event in self.listen(speaker, heard) {
                        network::tell(session, &event_key, &event, Priority::InteractiveHigh).await;
                    }
                    if self.station.is_closed() {
                        return Ok(Ended::Closed);
                    }
                    self.holdings.look(self.vehicle);
                    authority.on_time(now);
                    self.keep_order(authority);
                    if session.info().links().await.next().is_some() {
                        is_with_since = now;
                    } else if has_others && now.since(is_with_since) >= GONE_BESIDE_OTHERS {
                        return Err(self.problem("it has gone"));
                    }
                    let audience = match authority.lease() {
                        Some(_) => Audience::Holder,
                        None if has_hearers || lost < TELL_AFTER => Audience::List,
                        None => Audience::Nobody,
                    };
                    if now >= sample_due {
                        let state = self.sample(speaker, authority);
                        budget.on_sample(state.encoded_len());
                        network::tell(session, &state_key, &state, Priority::Data).await;
                        sample_due = now + budget.interval(audience);
                    } else if lost >= TELL_AFTER || audience == Audience::Nobody {
                        self.unheard(speaker, authority);
                    }
                    if now >= echo_due {
                        echo_due = now + audience.echo_interval();
                        let is_encrypted = self.router.as_ref().is_some_and(|router| router.way() != Way::Tcp);
                        if is_encrypted && !network::is_with_station(session).await {
                            return Err(self.problem("who answers there now is no router of this fleet"));
                        }
                        self.ask_echo(session, echoed.clone(), numbered.clone());
                        if let Some(place) = &mut self.place {
                            place.renew(&renewed, now);
                        }
                    }
                    self.show(authority, budget.rate_hz(audience), lost);
                }
                Some(renewed) = renewals.recv() => match (renewed, self.place.as_mut()) {
                    (Renewed::Certificate(member), Some(place)) => {
                        place.member = *member;
                        self.on_trust(authority);
                        return Ok(Ended::Renewed);
                    }
                    (Renewed::Stations(list), Some(place)) => {
                        if place.take(list) {
                            self.on_trust(authority);
                        }
                    }
                    (_, None) => {}
                },
                Some(number) = numbers.recv() => {
                    if let Some(place) = &mut self.place {
                        place.on_number(number, session, &self.config.org, &renewed, self.station.now());
                    }
                }
                Ok(status) = hearers.recv_async() => {
                    has_hearers = status.matching();
                    if has_hearers && lost >= TELL_AFTER {
                        // Whoever has come is told at once, and echoes that nobody answered say nothing of the uplink.
                        (sample_due, echo_due) = (MonoTime::ZERO, MonoTime::ZERO);
                        budget = Budget::new(self.config.uplink_bit_s, self.station.now());
                    }
                }
                Ok(query) = orders.recv_async() => self.on_order(query, authority),
                Ok(query) = states.recv_async() => {
                    let state = speaker.everything(authority.held(), self.station.now());
                    let state = self.holdings.dress(state, false);
                    network::reply(query, state_key.clone(), vec![state.encode_to_vec()]);
                }
                Ok(query) = events.recv_async() => {
                    let from = query.parameters().get("from").and_then(|from| from.parse().ok()).unwrap_or(1);
                    let kept = speaker.events_from(from).map(Message::encode_to_vec).collect();
                    network::reply(query, event_key.clone(), kept);
                }
                Ok(query) = lists.recv_async() => self.holdings.on_asked(query, list_key.clone(), self.station),
                Some((claim, result)) = self.ends.recv() => self.on_end(&claim, &result, authority),
                Some(took) = echoes.recv() => {
                    lost = if took.is_some() { 0 } else { lost + 1 };
                    match took {
                        Some(took) => budget.on_echo(took, self.station.now()),
                        None => budget.on_echo_lost(),
                    }
                    if lost >= patience {
                        return Err(self.problem("it answers no more"));
                    }
                }
            }
        }
    }

    /// Measures the way to the router and back; ground stations tell the number of their list of each other with it.
    fn ask_echo(&self, session: &Session, echoed: mpsc::Sender<Option<Duration>>, numbered: mpsc::Sender<u64>) {
        let (session, key, station) = (session.clone(), echo_key(&self.config.org), self.station.clone());
        tokio::spawn(async move {
            let began = station.now();
            // Too many are waiting only where nothing is read: the session is at its end.
            let came = || {
                let _ = echoed.try_send(Some(station.now().since(began)));
            };
            let answers = network::echo(&session, &key, ECHO_LOST, came).await;
            if answers.is_empty() {
                let _ = echoed.try_send(None);
            }
            let number = |answer: Vec<u8>| Some(u64::from_be_bytes(answer.try_into().ok()?));
            if let Some(number) = answers.into_iter().filter_map(number).max() {
                let _ = numbered.try_send(number);
            }
        });
    }

    fn problem(&self, problem: &str) -> FleetError {
        let address = self.router.as_ref().map_or_else(String::new, Endpoint::to_string);
        FleetError::Network { address, problem: problem.to_owned() }
    }

    fn show(&self, authority: &Authority, rate_hz: f64, lost: u32) {
        let holder = Some(authority.held().holder).filter(|holder| !holder.is_empty());
        let certificate_ends = self.certificate_ends;
        let silent = "it is reached and answers nothing: has this aircraft been revoked? see: vencejo fleet doctor";
        let problem = (lost >= TELL_AFTER).then(|| self.problem(silent).to_string());
        let problem = problem.or_else(|| self.history.and_then(Board::problem));
        let status = AircraftStatus { is_connected: true, problem, holder, rate_hz, certificate_ends };
        *self.status.lock().unwrap_or_else(PoisonError::into_inner) = status;
    }
}
