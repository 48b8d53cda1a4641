//! A ground station of a fleet: every aircraft of the organisation is a vehicle of its station.

use std::collections::BTreeMap;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError, Weak};
use std::time::{Duration, Instant};

use tokio::runtime::Handle;
use tokio::sync::{Notify, watch};
use tokio::task::JoinHandle;
use vencejo_station::{Silence, Station};
use vencejo_vehicle::VehicleId;
use vencejo_vehicle::telemetry::LOST_AFTER;
use zenoh::Session;
use zenoh::query::Query;
use zenoh::sample::{Sample, SampleKind};

use self::known::Known;
use self::terms::{List, Looked, Network, Terms};
use super::aircraft::place::ask_list;
use super::door::{Door, blocking};
use super::endpoint::{Endpoint, Transport};
use super::history::{Archive, HistoryConfig};
use super::network;
use crate::authority::RENEW_EVERY;
use crate::content::Shelf;
use crate::error::FleetError;
use crate::key::{Kind, Name, admitted_key, aircraft_of, echo_key, keys_of_all, stations_key};
use crate::operator;
use crate::signature::{PublicKey, Signer};

mod far;
mod known;
mod orders;
mod plans;
mod reach;
mod terms;
#[cfg(test)]
mod tests;

use known::Own;
pub use terms::Standing;

/// Most aircraft that are followed: as many remote vehicles as a station follows.
const MAX_AIRCRAFT: usize = vencejo_vehicle::registry::MAX_FAR;
/// The timeout of orders for control.
const CONTROL_PATIENCE: Duration = Duration::from_secs(5);
/// The timeout of queries.
const READ_WITHIN: Duration = Duration::from_secs(5);
/// How often the roll and the certificates are checked for changes.
const LOOK_EVERY: Duration = Duration::from_secs(1);
/// The pause before a network that was left for such a change is joined again after a failure: a port of QUIC is not
/// free at once.
const AGAIN: Duration = Duration::from_millis(50);
/// How long a router may take to admit a new member.
const REJOINS: Duration = Duration::from_secs(3);

/// How a ground station takes part in a fleet.
#[derive(Debug)]
pub struct GroundConfig {
    /// The organisation.
    pub org: Name,
    /// Its address as a router; port 0 takes a free one. A station that was enrolled as a router has its own.
    pub listen: Option<Endpoint>,
    /// Other routers: it uses the first that is reachable; as a router it links with all of them. Empty: those of its
    /// membership.
    pub dial: Vec<Endpoint>,
    /// Its key, which aircraft trust.
    pub signer: Signer,
    /// Whether it takes control, when it acts or asks, from those who have to yield: another program with its key; an
    /// operator, if it is a chief. Clients that request control by acting do not, and a program that has lost it does
    /// only when it asks.
    pub overrules: bool,
    /// Its standing in the fleet: for TLS and QUIC.
    pub standing: Standing,
    /// Address of the enrolment door, `HOST:PORT`, if it has the authority; port 0 takes a free one.
    pub door: Option<String>,
    /// Where the history of its aircraft is kept; `None` keeps none.
    pub history: Option<HistoryConfig>,
}

/// An aircraft far away, as a ground station sees it.
#[derive(Debug, Clone, PartialEq)]
pub struct Far {
    /// Its name.
    pub name: String,
    /// Its id in this station; `None` before its first state.
    pub id: Option<VehicleId>,
    /// Whether the station on board is reachable, as far as the network knows.
    pub is_present: bool,
    /// Age of its newest state.
    pub age: Duration,
    /// Who has control of it.
    pub holder: Option<String>,
    /// Who asks for control of it.
    pub asking: Option<String>,
    /// The silence of its autopilot, as its station on board reports it; `None` if that is not heard either.
    pub silence: Option<Silence>,
}

/// How a ground station is in its fleet's network.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct GroundStatus {
    /// Whether a router is reached that answers; a router itself is always.
    pub is_connected: bool,
    /// Why not.
    pub problem: Option<String>,
}

/// A ground station of a fleet.
pub struct Ground {
    fleet: Arc<Fleet>,
    door: Mutex<Option<Door>>,
    door_at: Option<String>,
    stop: watch::Sender<bool>,
    task: Mutex<Option<JoinHandle<()>>>,
}

/// What all aircraft share.
struct Fleet {
    org: Name,
    network: Network,
    session: Mutex<Session>,
    /// The address at which that was opened.
    endpoint: Endpoint,
    /// The newest list of ground stations.
    list: Mutex<List>,
    own: Own,
    signer: Signer,
    overrules: bool,
    station: Station,
    aircraft: Mutex<BTreeMap<Name, Arc<FarAircraft>>>,
    /// Whether it was logged that there is no room for more.
    is_full: AtomicBool,
    archive: Option<Arc<Archive>>,
    reach: Mutex<reach::Reach>,
}

/// One aircraft.
struct FarAircraft {
    name: Name,
    fleet: Weak<Fleet>,
    known: Mutex<Known>,
    /// One order for control at a time.
    asking: tokio::sync::Mutex<()>,
    /// Its lists that are cached here.
    shelf: Mutex<Shelf>,
    /// One list is fetched at a time.
    fetching: tokio::sync::Mutex<()>,
}

impl Ground {
    /// Joins the fleet.
    ///
    /// # Errors
    /// [`FleetError`].
    pub async fn start(station: Station, config: GroundConfig, runtime: &Handle) -> Result<Self, FleetError> {
        let dial = config.dial.into_iter().map(Endpoint::dialled).collect::<Result<Vec<_>, _>>()?;
        let listen = config.listen.map(Endpoint::with_port).transpose()?;
        // Without encryption, so on this machine only, there are no names for access rules.
        let is_clear = dial.iter().chain(&listen).any(|endpoint| endpoint.transport() == Transport::Tcp);
        let standing = if is_clear { Standing::Alone } else { config.standing };
        let news = Arc::new(Notify::new());
        let network = Network::new(listen, dial, standing);
        let Looked { terms, list, .. } = network.look(0).await?;
        let joined_at = terms.listen.iter().chain(&terms.dial).next();
        let endpoint = joined_at.cloned().ok_or_else(|| FleetError::Address(String::new()))?;
        let began = Instant::now();
        let session = loop {
            match network.open(&terms).await {
                Ok(session) => break session,
                // A router is away for a moment after an enrolment: maybe ours.
                Err(_) if matches!(network.standing, Standing::Member(_)) && began.elapsed() < REJOINS => {
                    tokio::time::sleep(AGAIN).await;
                }
                Err(error) => return Err(error),
            }
        };
        let door = match (&network.standing, config.door) {
            (Standing::Authority(organisation), Some(door)) => {
                Some(network.open_door(organisation, &door, &config.signer, &news).await?)
            }
            _ => None,
        };
        let (org, signer, overrules) = (config.org, config.signer, config.overrules);
        let own = Own { key: signer.public(), run: u32::from_ne_bytes(operator::random()?) };
        let session = Mutex::new(session);
        let archive = match config.history {
            Some(history) => {
                let of = org.clone();
                let path = history.folder.display().to_string();
                let failed = |error: std::io::Error| FleetError::File { path, problem: error.to_string() };
                Some(Arc::new(blocking(move || Archive::open(of, history).map_err(failed)).await?))
            }
            None => None,
        };
        let fleet = Arc::new(Fleet {
            org,
            network,
            session,
            endpoint,
            list: Mutex::new(list.unwrap_or_default()),
            own,
            signer,
            overrules,
            station,
            aircraft: Mutex::default(),
            is_full: AtomicBool::new(false),
            archive,
            reach: Mutex::default(),
        });
        let (stop, mut stopped) = watch::channel(false);
        let (ready, is_ready) = tokio::sync::oneshot::channel();
        let follow = fleet.clone();
        let task = runtime.spawn(async move {
            tokio::select! {
                () = follow.live(terms, &news, ready) => {}
                () = follow.fill(), if follow.archive.is_some() => {}
                stopped = async { stopped.wait_for(|stopped| *stopped).await.is_ok() } => if !stopped {
                    // The handle was dropped: end too. Close the session here, so that a callback of the network is not
                    // the last to hold it.
                    let _ = follow.session().close().await;
                },
            }
        });
        let failed = |problem: String| FleetError::Network { address: fleet.endpoint.to_string(), problem };
        is_ready.await.map_err(|_| failed("it ended at once".into()))??;
        let (door, door_at) = door.unzip();
        Ok(Self { fleet, door: Mutex::new(door), door_at, stop, task: Mutex::new(Some(task)) })
    }

    /// The address of the network: where its aircraft dial, when it is the router.
    pub fn endpoint(&self) -> &Endpoint {
        &self.fleet.endpoint
    }

    /// Address of the enrolment door, `HOST:PORT`.
    pub fn door(&self) -> Option<&str> {
        self.door_at.as_deref()
    }

    /// Its public key, which aircraft have to trust.
    pub fn key(&self) -> PublicKey {
        self.fleet.signer.public()
    }

    /// How it is in the network.
    pub fn status(&self) -> GroundStatus {
        self.fleet.reach().status(self.fleet.station.now())
    }

    /// The aircraft that were heard of, by name.
    pub fn aircraft(&self) -> Vec<Far> {
        let now = self.fleet.station.now();
        let some = |text: &String| Some(text.clone()).filter(|text| !text.is_empty());
        let far = |(name, aircraft): (&Name, &Arc<FarAircraft>)| {
            let known = aircraft.known();
            Far {
                name: name.to_string(),
                id: known.id,
                is_present: known.is_present,
                age: known.listener.age(now),
                holder: some(&known.listener.held().holder),
                asking: some(&known.listener.held().asking),
                silence: known.listener.silence(now),
            }
        };
        self.fleet.aircraft().iter().map(far).collect()
    }

    /// Releases control of its aircraft and leaves the fleet. May be called again.
    pub async fn close(&self) {
        self.stop.send_replace(true);
        drop(self.door.lock().unwrap_or_else(PoisonError::into_inner).take());
        let task = self.task.lock().unwrap_or_else(PoisonError::into_inner).take();
        if let Some(task) = task {
            // A join error is a panic, which has been reported.
            let _ = task.await;
            let aircraft: Vec<_> = self.fleet.aircraft().values().cloned().collect();
            let claimed = aircraft.into_iter().filter(|aircraft| aircraft.known().is_claimed());
            let releases: Vec<_> = claimed
                .map(|aircraft| tokio::spawn(async move { aircraft.release(Duration::from_millis(500)).await }))
                .collect();
            for release in releases {
                // What is lost of this expires on board by itself.
                let _ = release.await;
            }
            self.fleet.on_left();
            // Its declarations end with the process at the latest.
            let _ = self.fleet.session().close().await;
            if let Some(archive) = self.fleet.archive.clone() {
                // A join error is a panic, which has been reported.
                let _ = tokio::task::spawn_blocking(move || archive.close()).await;
            }
        }
    }
}

impl Fleet {
    fn session(&self) -> Session {
        self.session.lock().unwrap_or_else(PoisonError::into_inner).clone()
    }

    fn list(&self) -> List {
        self.list.lock().unwrap_or_else(PoisonError::into_inner).clone()
    }

    /// Follows the aircraft across sessions: Zenoh's access control cannot change while a session is open.
    async fn live(
        self: &Arc<Self>,
        mut terms: Terms,
        news: &Notify,
        ready: tokio::sync::oneshot::Sender<Result<(), FleetError>>,
    ) {
        let mut ready = Some(ready);
        loop {
            let changed = tokio::select! {
                failed = self.follow(&mut ready, terms.listen.is_some()) => match (failed, ready.take()) {
                    (error, Some(ready)) => return drop(ready.send(Err(error))),
                    (error, None) => {
                        tracing::warn!(%error, "the fleet cannot be followed");
                        tokio::time::sleep(AGAIN).await;
                        terms.clone()
                    }
                },
                changed = self.changed(&terms, news) => changed,
            };
            tracing::info!("who is enrolled, or a certificate, has changed: the network is joined anew");
            // Closing ends its declarations even if it fails.
            let _ = self.session().close().await;
            terms = changed;
            for aircraft in self.aircraft().values() {
                aircraft.known().is_present = false;
            }
            let session = loop {
                match self.network.open(&terms).await {
                    Ok(session) => break session,
                    Err(error) => {
                        tracing::debug!(%error, "the fleet is not there for a moment");
                        self.on_reached(Some(error.to_string()));
                    }
                }
                tokio::time::sleep(AGAIN).await;
            };
            *self.session.lock().unwrap_or_else(PoisonError::into_inner) = session;
        }
    }

    /// Fetches missing history, for ever.
    async fn fill(self: &Arc<Self>) {
        let Some(archive) = self.archive.clone() else { return };
        let is_present = |name: &Name| self.aircraft().get(name).is_some_and(|far| far.known().is_present);
        let is_ours = |name: &Name| self.aircraft().get(name).is_some_and(|far| !far.known().leases.is_empty());
        let station = self.station.clone();
        archive.fill(|| self.session(), is_present, is_ours, move || station.now()).await;
    }

    /// Waits until the terms have changed.
    async fn changed(&self, terms: &Terms, news: &Notify) -> Terms {
        loop {
            // Changes made through the door apply at once; those by another program at the next poll.
            let _ = tokio::time::timeout(LOOK_EVERY, news.notified()).await;
            let have = self.list().0;
            match self.network.look(have).await {
                Ok(Looked { terms: now, list, revoked }) => {
                    if let Some(list) = list {
                        *self.list.lock().unwrap_or_else(PoisonError::into_inner) = list;
                    }
                    for (name, aircraft) in &*self.aircraft() {
                        aircraft.known().is_revoked = revoked.contains(name.as_str());
                    }
                    if now != *terms {
                        return now;
                    }
                }
                Err(error) => tracing::warn!(%error, "who is enrolled cannot be read; what held before holds on"),
            }
        }
    }

    fn aircraft(&self) -> MutexGuard<'_, BTreeMap<Name, Arc<FarAircraft>>> {
        self.aircraft.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Follows the aircraft in this session, for ever; returns why it cannot.
    async fn follow(
        self: &Arc<Self>,
        ready: &mut Option<tokio::sync::oneshot::Sender<Result<(), FleetError>>>,
        is_router: bool,
    ) -> FleetError {
        let session = &self.session();
        let declared = async {
            let failed = network::failed;
            let echoes = session.declare_queryable(echo_key(&self.org)).complete(true);
            let echoes = echoes.callback(self.echo()).await.map_err(failed)?;
            let lists = session.declare_queryable(stations_key(&self.org)).complete(true).await.map_err(failed)?;
            let admitted = session.declare_queryable(admitted_key(&self.org)).complete(true).await.map_err(failed)?;
            let states = session.declare_subscriber(keys_of_all(&self.org, Kind::State));
            let states = states.callback(self.hear(Kind::State)).await.map_err(failed)?;
            let events = session.declare_subscriber(keys_of_all(&self.org, Kind::Event));
            let events = events.callback(self.hear(Kind::Event)).await.map_err(failed)?;
            let tokens = session.liveliness().declare_subscriber(keys_of_all(&self.org, Kind::Alive)).history(true);
            Ok((echoes, lists, admitted, states, events, tokens.await.map_err(failed)?))
        };
        let (_echoes, lists, admitted, _states, _events, tokens) = match declared.await {
            Ok(declared) => declared,
            Err(error) => return error,
        };
        if let Some(ready) = ready.take() {
            // Whoever waits for it may have gone, which ends this too.
            let _ = ready.send(Ok(()));
        }
        let mut renew = tokio::time::interval(RENEW_EVERY);
        renew.set_missed_tick_behavior(tokio::time::MissedTickBehavior::Delay);
        let mut control = self.station.control().news();
        loop {
            tokio::select! {
                // Somebody may be waiting for what the last operator here has given up.
                Ok(()) = control.changed() => {
                    if self.station.control().holder().is_none() {
                        self.renew();
                    }
                }
                Ok(sample) = tokens.recv_async() => {
                    if let Some(aircraft) = self.named(Kind::Alive, sample.key_expr().as_str()) {
                        let is_present = sample.kind() == SampleKind::Put;
                        tracing::info!(aircraft = %aircraft.name, is_present, "an aircraft far away");
                        aircraft.known().is_present = is_present;
                        if let Some(archive) = self.archive.as_ref().filter(|_| is_present) {
                            archive.on_present(&aircraft.name, self.station.now());
                        }
                    }
                }
                Ok(query) = admitted.recv_async() => {
                    let (fleet, have) = (self.clone(), have_of(&query));
                    tokio::spawn(async move {
                        let newer = fleet.network.admitted(have).await;
                        network::reply(query, admitted_key(&fleet.org), newer.into_iter().collect());
                    });
                }
                Ok(query) = lists.recv_async() => {
                    let have = have_of(&query);
                    let list = self.list();
                    let newer = (list.0 > have).then(|| list.1.clone());
                    network::reply(query, stations_key(&self.org), newer.into_iter().collect());
                }
                _ = renew.tick() => {
                    self.renew();
                    self.look_for_router(session, is_router);
                    if let Standing::Member(_) = self.network.standing {
                        // With a router are aircraft as well, each by its name.
                        if !(is_router || network::is_with_station(session).await) {
                            return FleetError::Network {
                                address: self.endpoint.to_string(),
                                problem: "who answers there now is not a router of this fleet".into(),
                            };
                        }
                        let (fleet, session) = (self.clone(), session.clone());
                        tokio::spawn(async move {
                            let stations = ask_list(&session, &stations_key(&fleet.org), fleet.list().0).await;
                            let mut aircraft = Vec::new();
                            if is_router {
                                let have = fleet.network.admitted_number().await;
                                aircraft = ask_list(&session, &admitted_key(&fleet.org), have).await;
                            }
                            fleet.network.keep(stations, aircraft).await;
                        });
                    }
                }
            }
        }
    }

    /// Answers an aircraft's echo where the network reads it, with the number of the newest list of stations, if there
    /// is one.
    fn echo(self: &Arc<Self>) -> impl Fn(Query) + Send + Sync + 'static {
        let (fleet, runtime) = (Arc::downgrade(self), Handle::current());
        move |query| {
            let Some(fleet) = fleet.upgrade() else { return };
            let _there = runtime.enter();
            let number = fleet.list().0;
            let told = if number == 0 { Vec::new() } else { number.to_be_bytes().to_vec() };
            network::reply(query, echo_key(&fleet.org), vec![told]);
        }
    }

    /// Takes in states and events where the network reads them, in their order: to wake somebody else for each of ten
    /// thousand a second costs more than all that is done with them, and a queue between that is full would hold up the
    /// answers behind them.
    fn hear(self: &Arc<Self>, kind: Kind) -> impl Fn(Sample) + Send + Sync + 'static {
        let (fleet, runtime) = (Arc::downgrade(self), Handle::current());
        move |sample| {
            let Some(fleet) = fleet.upgrade() else { return };
            // What is begun here goes on where all else does.
            let _there = runtime.enter();
            let Some(aircraft) = fleet.named(kind, sample.key_expr().as_str()) else { return };
            let bytes = sample.payload().to_bytes();
            if kind == Kind::Event { aircraft.on_event(&bytes) } else { aircraft.on_state(&bytes, true) }
        }
    }

    /// The aircraft that a key is of.
    fn named(self: &Arc<Self>, kind: Kind, key: &str) -> Option<Arc<FarAircraft>> {
        let name = aircraft_of(&self.org, kind, key)?;
        let mut all = self.aircraft();
        if let Some(known) = all.get(name) {
            return Some(known.clone());
        }
        let name: Name = name.parse().ok()?;
        if all.len() >= MAX_AIRCRAFT {
            let now = self.station.now();
            let age = |far: &Arc<FarAircraft>| {
                let known = far.known();
                (!known.is_present && known.leases.is_empty()).then(|| known.listener.age(now))
            };
            let silent = all.iter().filter_map(|(name, far)| Some((age(far).filter(|age| *age > LOST_AFTER)?, name)));
            let Some(gone) = silent.max().map(|(_, name)| name.clone()) else {
                if !self.is_full.swap(true, Ordering::Relaxed) {
                    tracing::warn!(aircraft = %name, "more aircraft are heard of than can be followed; the others are ignored");
                }
                return None;
            };
            tracing::warn!(aircraft = %name, %gone, "an aircraft that went made room for another");
            all.remove(&gone);
        }
        self.is_full.store(false, Ordering::Relaxed);
        let aircraft = Arc::new(FarAircraft::new(name.clone(), self));
        all.insert(name, aircraft.clone());
        Some(aircraft)
    }
}

/// The list number in a query.
fn have_of(query: &Query) -> u64 {
    query.parameters().get("have").and_then(|have| have.parse().ok()).unwrap_or(0)
}
