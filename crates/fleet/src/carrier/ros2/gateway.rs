//! The gateway: which planes are shown, from router to router.

use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

use tokio::runtime::Handle;
use tokio::sync::watch;
use tokio::task::JoinHandle;
use vencejo_proto::MonoTime;
use vencejo_station::Station;
use vencejo_vehicle::VehicleId;
use zenoh::Session;

use super::acts::Acting;
use super::plane::Plane;
use super::router::{RosRouter, check_domain, open};
use crate::error::FleetError;
use crate::ros2::name::{Names, Namespace, Place};
use crate::ros2::token::Node;

/// How often it is looked what there is to say.
const TICK: Duration = Duration::from_millis(50);
/// How often it is looked for planes that are new or gone.
const LOOK_EVERY: Duration = Duration::from_millis(500);
/// How long to wait before a router is dialled again.
const AGAIN: Duration = Duration::from_secs(1);

/// How planes are shown.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct GatewayConfig {
    /// The router.
    pub router: RosRouter,
    /// `ROS_DOMAIN_ID`.
    pub domain: u32,
    /// By whose names.
    pub names: Names,
    /// The namespace of each plane.
    pub namespace: Namespace,
    /// Whether services act; they refuse otherwise.
    pub is_operator: bool,
}

/// How it goes.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct GatewayStatus {
    /// Whether the router is reached.
    pub is_connected: bool,
    /// Why it was not.
    pub problem: Option<String>,
    /// The planes that are shown, by their ids, with what their topics begin with.
    pub planes: Vec<(u16, String)>,
    /// Messages that were sent.
    pub messages: u64,
}

/// The planes of a station, in ROS 2.
pub struct Gateway {
    status: Arc<Mutex<GatewayStatus>>,
    stop: watch::Sender<bool>,
    task: Mutex<Option<JoinHandle<()>>>,
}

impl Gateway {
    /// Shows every vehicle that the station hears or will hear, and reaches for the router for ever.
    ///
    /// # Errors
    /// [`FleetError::Ros`] for a domain that cannot be, [`FleetError::RosOperator`] where services would act for
    /// whoever reaches a router elsewhere.
    pub fn start(station: Station, config: GatewayConfig, runtime: &Handle) -> Result<Self, FleetError> {
        check_domain(config.domain)?;
        if config.is_operator && !config.router.is_here() {
            return Err(FleetError::RosOperator(config.router.to_string()));
        }
        let status = Arc::new(Mutex::new(GatewayStatus::default()));
        let (stop, mut stopped) = watch::channel(false);
        let shown = status.clone();
        let task = runtime.spawn(async move {
            tokio::select! {
                () = live(&station, &config, &shown) => {}
                // An error means that nobody holds the handle any more: the end as well.
                _ = stopped.wait_for(|stopped| *stopped) => {}
            }
        });
        Ok(Self { status, stop, task: Mutex::new(Some(task)) })
    }

    /// How it goes.
    pub fn status(&self) -> GatewayStatus {
        self.status.lock().unwrap_or_else(PoisonError::into_inner).clone()
    }

    /// Takes the planes out of ROS 2. May be called again.
    pub async fn close(&self) {
        self.stop.send_replace(true);
        let task = self.task.lock().unwrap_or_else(PoisonError::into_inner).take();
        if let Some(task) = task {
            // A join error would be its panic, which has been reported already.
            let _ = task.await;
        }
    }
}

async fn live(station: &Station, config: &GatewayConfig, status: &Mutex<GatewayStatus>) {
    let told = |change: &dyn Fn(&mut GatewayStatus)| change(&mut status.lock().unwrap_or_else(PoisonError::into_inner));
    loop {
        match open(&config.router).await {
            Ok(session) => {
                told(&|status| (status.is_connected, status.problem) = (true, None));
                let end = show(&session, station, config, status).await;
                // What it declared ends with it, whatever it says.
                let _ = session.close().await;
                let Err(error) = end else { return };
                told(&|status| (status.is_connected, status.problem) = (false, Some(error.to_string())));
            }
            Err(error) => told(&|status| (status.is_connected, status.problem) = (false, Some(error.to_string()))),
        }
        tokio::time::sleep(AGAIN).await;
    }
}

/// Shows planes until the station is closed. A router that is gone is dialled again by the session itself, which tells
/// it everything anew.
async fn show(
    session: &Session,
    station: &Station,
    config: &GatewayConfig,
    status: &Mutex<GatewayStatus>,
) -> Result<(), FleetError> {
    let acting = Acting::new(station, config.is_operator);
    let mut planes: BTreeMap<VehicleId, Plane> = BTreeMap::new();
    let (mut look_due, mut next_id) = (MonoTime::ZERO, 0);
    let mut tick = tokio::time::interval(TICK);
    tick.set_missed_tick_behavior(tokio::time::MissedTickBehavior::Delay);
    while !station.is_closed() {
        tick.tick().await;
        let now = station.now();
        if now >= look_due {
            look_due = MonoTime::from_origin(now.as_duration() + LOOK_EVERY);
            let vehicles = station.vehicles();
            // With one that is gone go its node, its topics and its services; also if another has its id already.
            planes.retain(|id, plane| !plane.is_gone() && vehicles.iter().any(|vehicle| vehicle.id() == *id));
            for vehicle in vehicles {
                let id = vehicle.id();
                if planes.contains_key(&id) || vehicle.telemetry().0.heartbeat.is_none() {
                    continue;
                }
                let name = vehicle.remote_name();
                let mut place = Place::new(config.names, &config.namespace, name.as_deref(), id.number());
                // One namespace is one plane's, whatever was asked for.
                if planes.values().any(|plane| plane.is_at(&place)) {
                    place = Place::new(config.names, &config.namespace.with_system(), name.as_deref(), id.number());
                }
                let node = Node {
                    domain: config.domain,
                    zid: session.zid().to_string(),
                    id: next_id,
                    namespace: place.namespace.clone(),
                    name: place.node.clone(),
                };
                tracing::info!(%id, topics = place.prefix, "a plane in ROS 2");
                let plane = Plane::declare(session, vehicle, place, config.names, node, &acting).await?;
                next_id += plane.ids();
                planes.insert(id, plane);
            }
            let is_connected = session.info().routers_zid().await.next().is_some();
            let mut status = status.lock().unwrap_or_else(PoisonError::into_inner);
            status.is_connected = is_connected;
            status.problem = (!is_connected).then(|| format!("{} is gone; it is dialled again", config.router));
            status.planes = planes.iter().map(|(id, plane)| (id.number(), plane.prefix().to_owned())).collect();
        }
        let mut sent = 0;
        for plane in planes.values_mut() {
            sent += plane.say().await;
        }
        status.lock().unwrap_or_else(PoisonError::into_inner).messages += sent;
    }
    Ok(())
}
