//! Commands to a vehicle. Each answers when the vehicle did it, and shows it where that can be seen. None does another as
//! a side effect.

use axum::Json;
use utoipa_axum::router::OpenApiRouter;
use utoipa_axum::routes;
use vencejo_flight::plan::Home;
use vencejo_proto::MissionSeq;
use vencejo_station::VehicleHandle;
use vencejo_vehicle::telemetry::Severity;
use vencejo_vehicle::{self as core, ModeChoice, Request, Turn};

use crate::dto::{
    AbortLanding, AltFrame, ClimbTo, Done, FlyCourse, Force, Goto, MissionStart, Mode, NewNote, SetAltitude, SetHome,
    SetItem, SetMode, SetSpeed, SetVelocity, SpeedKind, Takeoff,
};
use crate::extract::{DespiteMixedPlan, Json as Body, OptionalJson, Pilot, Vehicle};
use crate::problem::Problem;
use crate::state::App;

/// Asks a vehicle for something and waits for the end, which comes within a bounded time. Whoever hangs up does not take
/// the command back.
async fn ask(
    pilot: &Pilot,
    vehicle: &VehicleHandle,
    DespiteMixedPlan(despite): DespiteMixedPlan,
    request: Request,
) -> Result<Json<Done>, Problem> {
    let request = if despite { Request::DespiteMixedPlan(Box::new(request)) } else { request };
    pilot.request(vehicle, request).wait().await.ok_or_else(Problem::closed)??;
    Ok(Json(Done {}))
}

/// A command without a body, with an optional one, or with one.
macro_rules! command {
    ($(#[$doc:meta])* $name:ident, $path:tt, |$vehicle:ident| $request:expr) => {
        $(#[$doc])*
        #[utoipa::path(post, path = $path, tag = "commands", params(("id" = u16, Path, description = "The vehicle's id"),
            ("despite_mixed_plan" = Option<bool>, Query, description = "Do it although the mission on board may be mixed")),
            responses((status = 200, body = Done), Problem))]
        async fn $name(
            pilot: Pilot,
            Vehicle($vehicle): Vehicle,
            despite: DespiteMixedPlan,
        ) -> Result<Json<Done>, Problem> {
            ask(&pilot, &$vehicle, despite, $request).await
        }
    };
    ($(#[$doc:meta])* $name:ident, $path:tt, optional $body:tt, |$vehicle:ident, $value:ident| $request:expr) => {
        $(#[$doc])*
        #[utoipa::path(post, path = $path, tag = "commands", params(("id" = u16, Path, description = "The vehicle's id"),
            ("despite_mixed_plan" = Option<bool>, Query, description = "Do it although the mission on board may be mixed")),
            request_body = Option<$body>, responses((status = 200, body = Done), Problem))]
        async fn $name(
            pilot: Pilot,
            Vehicle($vehicle): Vehicle,
            despite: DespiteMixedPlan,
            OptionalJson($value): OptionalJson<$body>,
        ) -> Result<Json<Done>, Problem> {
            ask(&pilot, &$vehicle, despite, $request).await
        }
    };
    ($(#[$doc:meta])* $name:ident, $path:tt, $body:tt, |$vehicle:ident, $value:ident| $request:expr) => {
        $(#[$doc])*
        #[utoipa::path(post, path = $path, tag = "commands", params(("id" = u16, Path, description = "The vehicle's id"),
            ("despite_mixed_plan" = Option<bool>, Query, description = "Do it although the mission on board may be mixed")),
            request_body = $body, responses((status = 200, body = Done), Problem))]
        async fn $name(
            pilot: Pilot,
            Vehicle($vehicle): Vehicle,
            despite: DespiteMixedPlan,
            Body($value): Body<$body>,
        ) -> Result<Json<Done>, Problem> {
            ask(&pilot, &$vehicle, despite, $request).await
        }
    };
}

pub(super) fn router() -> OpenApiRouter<App> {
    OpenApiRouter::new()
        .routes(routes!(arm))
        .routes(routes!(disarm))
        .routes(routes!(set_mode))
        .routes(routes!(takeoff))
        .routes(routes!(goto))
        .routes(routes!(set_speed))
        .routes(routes!(set_altitude))
        .routes(routes!(fly_course))
        .routes(routes!(climb_to))
        .routes(routes!(set_velocity))
        .routes(routes!(add_note))
        .routes(routes!(loiter))
        .routes(routes!(return_to_launch))
        .routes(routes!(land))
        .routes(routes!(abort_landing))
        .routes(routes!(prepare_flight))
        .routes(routes!(start_mission))
        .routes(routes!(pause_mission))
        .routes(routes!(resume_mission))
        .routes(routes!(set_current_item))
        .routes(routes!(set_home))
        .routes(routes!(reboot))
}

/// A bank of 27 degrees.
const COURSE_ACCEL_M_S2: f64 = 5.0;

fn severity(given: Option<u8>) -> Result<Severity, Problem> {
    match given.unwrap_or(6) {
        severity @ 0..=7 => Ok(Severity(severity)),
        other => Err(Problem::invalid_value("severity", other, "0, an emergency, to 7, debug")),
    }
}

fn alt_frame(frame: AltFrame) -> core::AltFrame {
    match frame {
        AltFrame::Home => core::AltFrame::RelHome,
        AltFrame::Amsl => core::AltFrame::Amsl,
        AltFrame::Terrain => core::AltFrame::Terrain,
    }
}

fn seq(vehicle: &VehicleHandle, item: u16) -> Result<MissionSeq, Problem> {
    vehicle.seq_of_item(item).ok_or_else(|| Problem::invalid_value("item", item, "items are counted from 1"))
}

fn home(home: SetHome) -> Result<Option<Home>, Problem> {
    match (home.lat_deg, home.lon_deg, home.alt_amsl_m) {
        (None, None, None) => Ok(None),
        (Some(lat_deg), Some(lon_deg), Some(alt_amsl_m)) => Ok(Some(Home { lat_deg, lon_deg, alt_amsl_m })),
        _ => Err(Problem::invalid("home is lat_deg, lon_deg and alt_amsl_m, or none of them for where the vehicle is")),
    }
}

command! {
    /// Arms. Refused with the vehicle's reasons when its checks fail; `force` skips them.
    arm, "/vehicles/{id}/arm", optional Force, |vehicle, body| Request::Arm { force: body.force }
}
command! {
    /// Disarms; `force` does so in the air.
    disarm, "/vehicles/{id}/disarm", optional Force, |vehicle, body| Request::Disarm { force: body.force }
}
command! {
    /// Changes the flight mode.
    set_mode, "/vehicles/{id}/mode", SetMode, |vehicle, body| Request::SetMode(match body.mode {
        Mode::Number(number) => ModeChoice::Custom(number),
        Mode::Name(name) => ModeChoice::Name(name),
    })
}
command! {
    /// Takes off. A plane rolls when it is armed, or at once when it already is.
    takeoff, "/vehicles/{id}/takeoff", Takeoff, |vehicle, body| Request::Takeoff { alt_rel_home_m: body.alt_rel_home_m }
}
command! {
    /// Flies to a position and circles there, in mode GUIDED.
    goto, "/vehicles/{id}/goto", Goto, |vehicle, body| Request::Reposition {
        lat_deg: body.lat_deg,
        lon_deg: body.lon_deg,
        alt_m: body.alt_m,
        alt_frame: alt_frame(body.alt_frame),
        radius_m: body.radius_m,
        turn: if body.clockwise.unwrap_or(true) { Turn::Clockwise } else { Turn::CounterClockwise },
        speed_m_s: body.speed_m_s,
        change_mode: body.change_mode.unwrap_or(true),
    }
}
command! {
    /// Changes the speed.
    set_speed, "/vehicles/{id}/speed", SetSpeed, |vehicle, body| Request::ChangeSpeed {
        kind: match body.kind {
            SpeedKind::Airspeed => core::SpeedKind::Airspeed,
            SpeedKind::Groundspeed => core::SpeedKind::Groundspeed,
        },
        speed_m_s: body.speed_m_s,
    }
}
command! {
    /// Changes the height of the present target; a plane must be in GUIDED or LOITER.
    set_altitude, "/vehicles/{id}/altitude", SetAltitude,
    |vehicle, body| Request::ChangeAltitude { alt_m: body.alt_m, alt_frame: alt_frame(body.alt_frame) }
}
command! {
    /// Turns to a course over ground and stays on it. Only for an ArduPlane that is in GUIDED.
    fly_course, "/vehicles/{id}/course", FlyCourse, |vehicle, body| Request::GuidedCourse {
        course_deg: body.course_deg,
        accel_m_s2: body.accel_m_s2.unwrap_or(COURSE_ACCEL_M_S2),
    }
}
command! {
    /// Climbs or sinks to a height at a rate. Only for an ArduPlane that is in GUIDED.
    climb_to, "/vehicles/{id}/climb", ClimbTo, |vehicle, body| Request::GuidedClimb {
        alt_m: body.alt_m,
        alt_frame: alt_frame(body.alt_frame),
        rate_m_s: body.rate_m_s,
    }
}
command! {
    /// Flies at a velocity. Only for what hovers, in GUIDED or OFFBOARD. It has no answer, and the vehicle stops when it hears no
    /// more of it: after 3 s an ArduCopter, after 0.5 s a PX4.
    set_velocity, "/vehicles/{id}/velocity", SetVelocity, |vehicle, body| Request::Velocity {
        forward_m_s: body.forward_m_s,
        right_m_s: body.right_m_s,
        down_m_s: body.down_m_s,
        yaw_rate_rad_s: body.yaw_rate_rad_s,
    }
}
command! {
    /// Puts a text of ours beside the vehicle's own, for whoever watches it through this station. Nothing is sent.
    add_note, "/vehicles/{id}/texts", NewNote, |vehicle, body| Request::Note {
        severity: severity(body.severity)?,
        text: body.text,
    }
}
command! {
    /// Circles here: mode LOITER.
    loiter, "/vehicles/{id}/loiter", |vehicle| Request::LoiterHere
}
command! {
    /// Returns to launch: mode RTL.
    return_to_launch, "/vehicles/{id}/return-to-launch", |vehicle| Request::ReturnToLaunch
}
command! {
    /// Lands: a plane flies the landing of its mission.
    land, "/vehicles/{id}/land", |vehicle| Request::Land
}
command! {
    /// Aborts a landing and climbs.
    abort_landing, "/vehicles/{id}/abort-landing", optional AbortLanding,
    |vehicle, body| Request::AbortLanding { alt_rel_home_m: body.alt_rel_home_m }
}
command! {
    /// Prepares a flight, on the ground and disarmed: changes to a mode that arms where the present one does not, and sets the
    /// mission back to its beginning. `progress.preparation` tells what it changes. It neither arms nor starts.
    prepare_flight, "/vehicles/{id}/prepare-flight", |vehicle| Request::PrepareFlight
}
command! {
    /// Starts the mission: mode AUTO. Does not arm.
    start_mission, "/vehicles/{id}/mission/start", optional MissionStart,
    |vehicle, body| Request::MissionStart { from: body.from_item.map(|item| seq(&vehicle, item)).transpose()? }
}
command! {
    /// Interrupts the mission: mode LOITER.
    pause_mission, "/vehicles/{id}/mission/pause", |vehicle| Request::MissionPause
}
command! {
    /// Goes on with the mission where it stands: mode AUTO.
    resume_mission, "/vehicles/{id}/mission/resume", |vehicle| Request::MissionResume
}
command! {
    /// Makes an item of the mission the current one.
    set_current_item, "/vehicles/{id}/mission/current", SetItem,
    |vehicle, body| Request::SetCurrentItem(seq(&vehicle, body.item)?)
}
command! {
    /// Moves home to a position, or to where the vehicle is when none is given.
    set_home, "/vehicles/{id}/home", optional SetHome, |vehicle, body| Request::SetHome(home(body)?)
}
command! {
    /// Reboots the autopilot; only while it is disarmed.
    reboot, "/vehicles/{id}/reboot", |vehicle| Request::Reboot
}
