//! What ROS 2 asks of a plane, done through the station's lease like everybody else's acts.

use std::sync::Arc;

use tokio::runtime::Handle;
use tokio::sync::{Semaphore, SemaphorePermit, mpsc};
use vencejo_flight::plan::{Mission, PlanKind};
use vencejo_proto::{Address, CommandLong, MissionSeq};
use vencejo_station::{Operator, Pending, RequestResult, Station, VehicleHandle};
use vencejo_vehicle::telemetry::Freshness;
use vencejo_vehicle::{Danger, ModeChoice, Reply, Request};
use zenoh::query::Query;

use super::ends::end_of;
use super::params;
use crate::carrier::checked::plan_errors;
use crate::carrier::network::bytes_of;
use crate::carrier::utc_ns;
use crate::ros2::message::{LongWanted, Waypoint};
use crate::ros2::mission;
use crate::ros2::offer::{Done, Ended, Failed, Offer, Wish};
use crate::ros2::token::Attachment;

/// Requests to vehicles that are under way at most, of all who ask.
const AT_ONCE: usize = 16;
/// Answers that are made at once at most, those included.
const ANSWERS: usize = 256;
/// What a gateway says that only reads.
pub(super) const READS: &str = "this gateway only reads; it acts when it is started with --ros2-role operator";

/// A command to the autopilot itself.
const THE_AUTOPILOT: Address = Address::new(0, 0);

/// In whose name it is acted.
pub(super) struct Acting {
    /// `None`: it only reads.
    operator: Option<Arc<Operator>>,
    places: Semaphore,
    answers: Arc<Semaphore>,
    runtime: Handle,
}

impl Acting {
    /// An operator of its own, that gives control to whoever asks for it, and asks for it when it is refused.
    pub(super) fn new(station: &Station, is_operator: bool) -> Arc<Self> {
        Arc::new(Self {
            operator: is_operator.then(|| Arc::new(station.enlist("ROS 2").asking())),
            places: Semaphore::new(AT_ONCE),
            answers: Arc::new(Semaphore::new(ANSWERS)),
            runtime: Handle::current(),
        })
    }

    /// Somebody asks. Never waits: a thread of the network calls.
    pub(super) fn on_query(
        self: &Arc<Self>,
        query: Query,
        key: &str,
        offer: Offer,
        vehicle: &VehicleHandle,
        lines: &mpsc::Sender<(bool, String)>,
    ) {
        let attachment = query.attachment().map(|bytes| bytes.to_bytes().into_owned());
        // What does not say who asks is nobody of ROS.
        let Some(asked) = attachment.as_deref().and_then(Attachment::read) else { return };
        let Ok(answer) = self.answers.clone().try_acquire_owned() else {
            tracing::warn!(service = key, "more is asked by ROS 2 than can be answered at once; this is not answered");
            return;
        };
        let (acting, key, vehicle, lines) = (self.clone(), key.to_owned(), vehicle.clone(), lines.clone());
        self.runtime.spawn(async move {
            let ended = match (offer.read)(&bytes_of(query.payload())) {
                Ok(wish) => acting.done(&vehicle, wish).await,
                Err(error) => Err(error.to_string().into()),
            };
            let problem = ended.as_ref().map_or_else(|failed| Some(failed.why.clone()), Done::problem);
            let is_good = problem.is_none();
            let words = problem.unwrap_or_else(|| match &ended {
                Ok(Done { words, .. }) if !words.is_empty() => format!("done: {words}"),
                _ => "done".to_owned(),
            });
            let line = format!("{}: {words}", offer.name);
            tracing::info!(vehicle = %vehicle.id(), line, "asked by ROS 2");
            // Nobody has to read it.
            let _ = lines.try_send((is_good, line));
            let attachment = Attachment { sent_ns: utc_ns(), ..asked };
            if let Err(error) = query.reply(key, (offer.write)(&ended)).attachment(attachment.to_bytes()).await {
                // Whoever asked asks again.
                tracing::debug!(%error, "not answered");
            }
            drop(answer);
        });
    }

    async fn done(&self, vehicle: &VehicleHandle, wish: Wish) -> Ended {
        if wish == Wish::IsReady {
            let (telemetry, now) = vehicle.telemetry();
            let fresh = telemetry.sys_status.filter(|status| status.freshness(now) == Freshness::Fresh);
            return match fresh.and_then(|status| status.value.is_ready_to_arm) {
                Some(true) => Ok(Done { words: "it is ready to arm".to_owned(), ..Done::default() }),
                Some(false) => Err("its pre-arm checks fail".into()),
                None => Err("it does not say whether it is ready to arm".into()),
            };
        }
        let (vehicle, _place) = match (self.acting(vehicle), wish.names()) {
            (Err(failed), Some(names)) => return Ok(Done::without(names, &failed.why)),
            (acting, _) => acting?,
        };
        let wish = match wish {
            Wish::Push(start, waypoints) => return push(&vehicle, start, waypoints).await,
            Wish::Params(names) => return params::read(&vehicle, names).await,
            Wish::SetParams(wanted) => return params::write(&vehicle, wanted).await,
            wish => wish,
        };
        Ok(match end_of(Self::asked(&vehicle, wish)?).await? {
            Reply::Plan { items, .. } => {
                let count = mission::count(items.len(), vehicle.telemetry().0.is_ardupilot());
                Done { words: format!("{count} waypoints"), count, ..Done::default() }
            }
            _ => Done::default(),
        })
    }

    /// Whether it acts.
    pub(super) fn is_operator(&self) -> bool {
        self.operator.is_some()
    }

    /// Starts a request, and tells how it ended.
    pub(super) fn start(
        self: &Arc<Self>,
        vehicle: &VehicleHandle,
        request: Request,
        ended: impl FnOnce(Result<(), String>) + Send + 'static,
    ) {
        let (acting, vehicle) = (self.clone(), vehicle.clone());
        self.runtime.spawn(async move {
            let end = acting.carried(&vehicle, request).await;
            ended(end.map(drop).map_err(|failed| failed.why));
        });
    }

    async fn carried(&self, vehicle: &VehicleHandle, request: Request) -> Result<Reply, Failed> {
        let (vehicle, _place) = self.acting(vehicle)?;
        end_of(vehicle.request(request)).await
    }

    /// A vehicle that is asked by the operator, and a place among all requests.
    fn acting(&self, vehicle: &VehicleHandle) -> Result<(VehicleHandle, SemaphorePermit<'_>), Failed> {
        let operator = self.operator.clone().ok_or(READS)?;
        // A client of ROS waits for its answer for ever: one that has to ask again is told.
        let place = self.places.try_acquire();
        let place = place.map_err(|_| format!("{AT_ONCE} requests are under way; ask again when one has ended"))?;
        Ok((vehicle.acting_as(operator), place))
    }

    fn asked(vehicle: &VehicleHandle, wish: Wish) -> Result<Pending<RequestResult>, String> {
        let kind = PlanKind::Mission;
        Ok(match wish {
            Wish::Arm(true) => vehicle.request(Request::Arm { force: false }),
            Wish::Arm(false) => vehicle.request(Request::Disarm { force: false }),
            Wish::Mode(name) if name.is_empty() => {
                return Err("a mode is named in custom_mode, such as AUTO; base_mode alone says too little".to_owned());
            }
            Wish::Mode(name) => {
                let mode = name.parse().map_or_else(|_| ModeChoice::Name(name), ModeChoice::Custom);
                vehicle.request(Request::SetMode { mode })
            }
            Wish::Takeoff(alt_rel_home_m) => vehicle.request(Request::Takeoff { alt_rel_home_m }),
            Wish::Land => vehicle.request(Request::Land),
            Wish::Home(place) => {
                let [lat_deg, lon_deg, alt_amsl_m] = place.map_or([None; 3], |place| place.map(Some));
                vehicle.request(Request::SetHome { lat_deg, lon_deg, alt_amsl_m })
            }
            Wish::Current(seq) => {
                let item = vehicle.item_of_seq(MissionSeq(seq));
                let item =
                    item.ok_or("waypoint 0 is home on ArduPilot, and is not flown to; the mission begins with 1")?;
                vehicle.request(Request::SetCurrentItem { item })
            }
            Wish::Command(wanted) => vehicle.request(Request::RawCommandLong(long(&wanted)?)),
            Wish::Return => vehicle.request(Request::ReturnToLaunch),
            Wish::Loiter => vehicle.request(Request::LoiterHere),
            Wish::Start => vehicle.request(Request::MissionStart { from_item: None }),
            Wish::Clear if !is_disarmed(vehicle) => {
                return Err("the mission of a vehicle that is armed is not cleared from ROS 2: disarm it first, or clear it in the web app".to_owned());
            }
            // Who calls it names what is dangerous: that is what it is for.
            Wish::Clear => vehicle.request_naming(Request::ClearPlan { kind }, Danger::Clear(kind)),
            Wish::Pull => vehicle.request(Request::DownloadPlan { kind }),
            Wish::SetAtOnce => {
                return Err("an autopilot takes one parameter after the other: use set_parameters".to_owned());
            }
            Wish::Push(..) | Wish::Params(_) | Wish::SetParams(_) | Wish::IsReady => {
                return Err("it is not a single act".to_owned());
            }
        })
    }
}

/// Whether it is known to be disarmed.
fn is_disarmed(vehicle: &VehicleHandle) -> bool {
    let (telemetry, now) = vehicle.telemetry();
    let heard = telemetry.heartbeat.filter(|heartbeat| heartbeat.freshness(now) != Freshness::Lost);
    heard.is_some_and(|heartbeat| !heartbeat.value.is_armed)
}

/// A command as it is sent to the autopilot.
fn long(wanted: &LongWanted) -> Result<CommandLong, String> {
    let LongWanted { broadcast, command, param1, param2, param3, param4, param5, param6, param7, .. } = *wanted;
    if broadcast {
        return Err("a command is sent to one vehicle: leave broadcast false".to_owned());
    }
    let params = [param1, param2, param3, param4, param5, param6, param7];
    if params.iter().any(|param| param.is_infinite()) {
        return Err("a parameter is infinite; NaN leaves it to the vehicle".to_owned());
    }
    Ok(CommandLong { target: THE_AUTOPILOT, command, confirmation: 0, params })
}

/// Replaces the mission, or some of its waypoints: checked as by every other door, and done when the vehicle has it.
async fn push(vehicle: &VehicleHandle, start: u16, waypoints: Vec<Waypoint>) -> Ended {
    let (kind, has_home) = (PlanKind::Mission, vehicle.telemetry().0.is_ardupilot());
    let mission = if start == 0 {
        mission::whole(&waypoints, has_home)?
    } else {
        // What is on board now, not what it was when somebody last looked.
        match end_of(vehicle.request(Request::DownloadPlan { kind })).await? {
            Reply::Plan { items, home, .. } => mission::spliced(Mission { home, items }, start, &waypoints, has_home)?,
            _ => return Err("the mission on board was not read".into()),
        }
    };
    let (checked, unchecked) = (vehicle.clone(), mission.clone());
    let errors = tokio::task::spawn_blocking(move || plan_errors(&checked, kind, unchecked)).await;
    if let Some(errors) = errors.map_err(|_| "the checks failed; nothing was sent")? {
        return Err(format!("the mission has {errors}; nothing was sent").into());
    }
    let Mission { home, items } = mission;
    end_of(vehicle.request(Request::UploadPlan { kind, items, home, despite_findings: false })).await?;
    let count = u32::try_from(waypoints.len()).unwrap_or(u32::MAX);
    Ok(Done { words: format!("{count} waypoints, and the vehicle has them"), count, ..Done::default() })
}
