//! Plans: on board (sent, read, removed, each an operation), in files, and what is doubtful in them.

#![allow(unused_qualifications, reason = "utoipa's query parameters name their type in full")]

use std::fs::File;
use std::io::{self, BufReader};
use std::sync::Arc;

use axum::Json;
use axum::body::{self, Bytes, HttpBody as _};
use axum::extract::rejection::{BytesRejection, QueryRejection};
use axum::extract::{DefaultBodyLimit, Query, State};
use axum::http::{HeaderName, HeaderValue, StatusCode, header};
use axum::response::{IntoResponse, Response};
use serde::Deserialize;
use utoipa::IntoParams;
use utoipa_axum::router::OpenApiRouter;
use utoipa_axum::routes;
use vencejo_flight::checks::{Finding, Severity};
use vencejo_flight::formats::{MAX_FILE_BYTES, Note, PlanSettings, read_plan, write_plan};
use vencejo_flight::landing::Wind;
use vencejo_flight::plan::{self as core};
use vencejo_flight::rehearsal::{Aircraft, Learner};
use vencejo_proto::SystemId;
use vencejo_station::{MAX_FLIGHT_BYTES, Pending, RequestResult, VehicleHandle, recorded_flight};
use vencejo_vehicle::Request;

use super::{recordings, streams};
use crate::assess::{self, assess};
use crate::convert;
use crate::dto::cause::Cause;
use crate::dto::{
    CommandInfo, CountedItems, FindingFix, FrameChange, Landing, LandingAlternative, LandingMove, LandingRequest,
    LearnedPlane, Operation, OperationKind, Plan, PlanCheck, PlanComparison, PlanFormat, PlanKind, PlanOnBoard,
    PlaneProfile, Rehearsal, RehearsalRequest, Spread, SpreadRequest, VehicleProfile, Way, WayRequest, WhatIfRequest,
    WhatIfs,
};
use crate::extract::{Json as Body, Operator, Pilot, Vehicle, Viewer, ViewerRole};
use crate::landings;
use crate::levels;
use crate::problem::Problem;
use crate::sessions::SessionId;
use crate::state::App;
use crate::turns::{in_turn, quickly};

type Accepted = (StatusCode, Json<Operation>);

pub(super) fn router() -> OpenApiRouter<App> {
    OpenApiRouter::new()
        .routes(routes!(mission_on_board, upload_mission, clear_mission))
        .routes(routes!(fence_on_board, upload_fence, clear_fence))
        .routes(routes!(rally_on_board, upload_rally, clear_rally))
        .routes(routes!(download_mission))
        .routes(routes!(download_fence))
        .routes(routes!(download_rally))
        .routes(routes!(compare))
        .routes(routes!(format_plan))
        .routes(routes!(check))
        .routes(routes!(way))
        .routes(routes!(landing))
        .routes(routes!(alternatives))
        .routes(routes!(moved_landing))
        .routes(routes!(counted_from))
        .routes(routes!(rehearse))
        .routes(routes!(plan_fixes))
        .routes(routes!(rehearse_many))
        .routes(routes!(profile))
        .merge(OpenApiRouter::new().routes(routes!(learn)).layer(DefaultBodyLimit::disable()))
        .routes(routes!(what_if))
        .routes(routes!(list_commands))
        .merge(OpenApiRouter::new().routes(routes!(parse)).layer(DefaultBodyLimit::max(MAX_FILE_BYTES)))
}

fn start(
    app: &App,
    by: SessionId,
    vehicle: &VehicleHandle,
    kind: OperationKind,
    pending: Pending<RequestResult>,
) -> Result<Accepted, Problem> {
    let operation = app.follow(by, vehicle.id().number(), kind, pending)?;
    Ok((StatusCode::ACCEPTED, Json(operation)))
}

/// The request that puts one part of a plan on board.
fn upload(kind: PlanKind, plan: &Plan, despite_findings: bool) -> Result<Request, Problem> {
    let (items, home) = convert::core_plan(plan)?.into_list(convert::core_plan_kind(kind))?;
    // Nothing given is no wish to have nothing on board.
    if items.is_empty() {
        let (part, field) = match kind {
            PlanKind::Mission => ("mission", "items"),
            PlanKind::Fence => ("fence", "fence.zones"),
            PlanKind::Rally => ("rally points", "rally"),
        };
        let expected = format!("one or more; DELETE on this path removes the {part} on board");
        return Err(Problem::invalid_value(field, "empty", &expected));
    }
    Ok(Request::UploadPlan { kind: convert::core_plan_kind(kind), items, home, despite_findings })
}

/// Whether to look for errors first.
#[derive(Debug, Deserialize, IntoParams)]
#[into_params(parameter_in = Query)]
struct Checked {
    /// `false` sends a mission in spite of errors that the checks find.
    check: Option<bool>,
}

/// Refuses a mission that would fail. A fence or rally points are refused by their own rules.
async fn require_sound(app: &App, vehicle: &VehicleHandle, kind: PlanKind, plan: &Plan) -> Result<(), Problem> {
    if kind != PlanKind::Mission || plan.items.is_empty() {
        return Ok(());
    }
    let (vehicle, plan) = (vehicle.clone(), convert::core_plan(plan)?);
    let (map, _) = app.ground_around(&plan, vehicle.home());
    let found = in_turn(move || Ok(vehicle.check_upload(&plan, Some(&|point| map.height_m(point))))).await?;
    let errors: Vec<_> = found
        .into_iter()
        .filter(|finding| finding.severity == Severity::Error)
        .map(|finding| finding.to_string())
        .collect();
    if errors.is_empty() {
        return Ok(());
    }
    let detail = format!("the plan has {} errors: nothing was sent; POST /api/v1/plan/check tells more", errors.len());
    Err(Problem::new(Cause::PlanUnsound { errors: errors.len() as u64 }, detail).reasons(errors))
}

/// What can be done with one kind of plan on board.
macro_rules! plan_routes {
    ($path:tt, $kind:ident, $known:ident, $upload:ident = $upload_kind:ident, $read_path:tt,
     $download:ident = $download_kind:ident, $clear:ident = $clear_kind:ident) => {
        /// What is known of this part of the plan on board. Nothing is asked of the vehicle: the station itself reads what it
        /// does not know, and tells by the WebSocket's `plan_state` when that changes.
        #[utoipa::path(get, path = $path, tag = "plans", params(("id" = u16, Path, description = "The vehicle's id")),
                                            responses((status = 200, body = PlanOnBoard), Problem))]
        async fn $known(_: Viewer, Vehicle(vehicle): Vehicle) -> Result<Json<PlanOnBoard>, Problem> {
            Ok(Json(convert::plan_on_board(&vehicle, core::PlanKind::$kind)?))
        }

        /// Replaces this part of the plan on board by that of the plan given, and reads it back. Done means that the vehicle
        /// has it. The operation's result is the plan on board. A mission in which the checks find an error is refused, and so is
        /// a part with nothing in it: DELETE clears.
        #[utoipa::path(put, path = $path, tag = "plans", params(("id" = u16, Path, description = "The vehicle's id"), Checked),
                                            request_body = Plan, responses((status = 202, body = Operation), Problem))]
        async fn $upload(
            State(app): State<App>,
            pilot: Pilot,
            Vehicle(vehicle): Vehicle,
            asked: Result<Query<Checked>, QueryRejection>,
            Body(plan): Body<Plan>,
        ) -> Result<Accepted, Problem> {
            let check = asked?.check.unwrap_or(true);
            if check {
                require_sound(&app, &vehicle, PlanKind::$kind, &plan).await?;
            }
            let pending = pilot.request(&vehicle, upload(PlanKind::$kind, &plan, !check)?);
            start(&app, pilot.session, &vehicle, OperationKind::$upload_kind, pending)
        }

        /// Reads this part of the plan on board from the vehicle; it is the operation's result.
        #[utoipa::path(post, path = $read_path, tag = "plans", params(("id" = u16, Path, description = "The vehicle's id")),
                                            responses((status = 202, body = Operation), Problem))]
        async fn $download(
            State(app): State<App>,
            Operator(session): Operator,
            Vehicle(vehicle): Vehicle,
        ) -> Result<Accepted, Problem> {
            let request = Request::DownloadPlan { kind: core::PlanKind::$kind };
            start(&app, session, &vehicle, OperationKind::$download_kind, vehicle.request(request))
        }

        /// Removes this part of the plan on board and checks that it is gone.
        #[utoipa::path(delete, path = $path, tag = "plans", params(("id" = u16, Path, description = "The vehicle's id")),
                                            responses((status = 202, body = Operation), Problem))]
        async fn $clear(
            State(app): State<App>,
            pilot: Pilot,
            Vehicle(vehicle): Vehicle,
        ) -> Result<Accepted, Problem> {
            let request = Request::ClearPlan { kind: core::PlanKind::$kind };
            start(&app, pilot.session, &vehicle, OperationKind::$clear_kind, pilot.request(&vehicle, request))
        }
    };
}

plan_routes!(
    "/vehicles/{id}/plan/mission",
    Mission,
    mission_on_board,
    upload_mission = UploadMission,
    "/vehicles/{id}/plan/mission/read",
    download_mission = DownloadMission,
    clear_mission = ClearMission
);
plan_routes!(
    "/vehicles/{id}/plan/fence",
    Fence,
    fence_on_board,
    upload_fence = UploadFence,
    "/vehicles/{id}/plan/fence/read",
    download_fence = DownloadFence,
    clear_fence = ClearFence
);
plan_routes!(
    "/vehicles/{id}/plan/rally",
    Rally,
    rally_on_board,
    upload_rally = UploadRally,
    "/vehicles/{id}/plan/rally/read",
    download_rally = DownloadRally,
    clear_rally = ClearRally
);

/// How a plan differs from what is on board: what was added, removed and changed, by what this vehicle can keep of an item. Nothing is
/// asked of the vehicle.
#[utoipa::path(post, path = "/vehicles/{id}/plan/compare", tag = "plans", params(("id" = u16, Path, description = "The vehicle's id")),
    request_body = Plan, responses((status = 200, body = PlanComparison), Problem))]
async fn compare(
    _: Viewer,
    Vehicle(vehicle): Vehicle,
    Body(plan): Body<Plan>,
) -> Result<Json<PlanComparison>, Problem> {
    quickly(move || Ok(Json(convert::plan_comparison(&vehicle, &convert::core_plan(&plan)?)))).await
}

/// The name of a file.
#[derive(Debug, Deserialize, IntoParams)]
#[into_params(parameter_in = Query)]
struct FileName {
    /// The file's name, for messages alone: the content decides what it is.
    name: Option<String>,
}

/// What a reader had to assume or leave out, and what a writer did not keep: JSON, a list of `PlanFileNote`.
const NOTES: HeaderName = HeaderName::from_static("vencejo-notes");

fn notes_header(notes: &[Note]) -> (HeaderName, HeaderValue) {
    let text = serde_json::to_string(notes).expect("invariant: codes and numbers are JSON");
    (NOTES, HeaderValue::try_from(text).expect("invariant: codes and numbers are ASCII"))
}

/// Reads a plan file of any known kind; the body is the file. What the file does not say, and what of it a plan cannot hold, is in the
/// header `Vencejo-Notes`.
#[utoipa::path(post, path = "/plan/parse", tag = "plans", params(FileName),
    request_body(content = Vec<u8>, content_type = "application/octet-stream"),
    responses((status = 200, body = Plan, headers(("Vencejo-Notes" = String, description = "JSON: a list of `PlanFileNote`"))), Problem))]
async fn parse(
    _: Viewer,
    file: Result<Query<FileName>, QueryRejection>,
    body: Result<Bytes, BytesRejection>,
) -> Result<Response, Problem> {
    let (Query(file), body) = (file?, body?);
    let name = file.name.map(|name| name.chars().filter(|c| !c.is_control()).take(100).collect::<String>());
    let read = super::parsed(body, move |bytes| read_plan(bytes, name.as_deref())).await?;
    let plan = Plan { complex_items: read.settings.complex_items, ..convert::plan(&read.plan) };
    Ok(([notes_header(&read.notes)], Json(plan)).into_response())
}

/// How to write a file.
#[derive(Debug, Deserialize, IntoParams)]
#[into_params(parameter_in = Query)]
struct FileKind {
    /// By the ending of the file's name.
    #[serde(rename = "as")]
    #[param(inline)]
    kind: PlanFormat,
}

/// Writes a plan to a file. What the file does not keep as it is in the plan is in the header `Vencejo-Notes`.
#[utoipa::path(post, path = "/plan/format", tag = "plans", params(FileKind), request_body = Plan,
    responses((status = 200, body = Vec<u8>, content_type = "application/octet-stream",
               headers(("Vencejo-Notes" = String, description = "JSON: a list of `PlanFileNote`"))), Problem))]
async fn format_plan(
    _: Viewer,
    kind: Result<Query<FileKind>, QueryRejection>,
    Body(plan): Body<Plan>,
) -> Result<Response, Problem> {
    let Query(kind) = kind?;
    let settings = PlanSettings { complex_items: plan.complex_items.clone(), ..PlanSettings::default() };
    let plan = convert::core_plan(&plan)?;
    let format = convert::plan_format(kind.kind);
    let written = in_turn(move || Ok(write_plan(&plan, &settings, format)?)).await?;
    let name = HeaderValue::try_from(format!("attachment; filename=\"mission.{}\"", format.ending()));
    let headers = [
        (header::CONTENT_TYPE, HeaderValue::from_static(format.media_type())),
        (header::CONTENT_DISPOSITION, name.expect("invariant: endings are ASCII")),
        notes_header(&written.notes),
    ];
    Ok((headers, written.bytes).into_response())
}

/// Looks for what would make a plan fail.
#[utoipa::path(post, path = "/plan/check", tag = "plans", request_body = PlanCheck,
    responses((status = 200, body = Vec<Finding>), Problem))]
async fn check(State(app): State<App>, _: Viewer, Body(asked): Body<PlanCheck>) -> Result<Json<Vec<Finding>>, Problem> {
    let profile = PlaneProfile::default();
    in_turn(move || Ok(Json(assess(&app, asked.vehicle, &asked.plan, None, None, &profile)?.findings))).await
}

/// The way of a plan's mission as it is drawn: the line from place to place, circles, jumps, lengths and courses; and its heights, with the
/// ground below. While a point is dragged, ask over the WebSocket (`plan_way`).
#[utoipa::path(post, path = "/plan/way", tag = "plans", request_body = WayRequest,
    responses((status = 200, body = Way), Problem))]
async fn way(State(app): State<App>, _: Viewer, Body(asked): Body<WayRequest>) -> Result<Json<Way>, Problem> {
    quickly(move || assess::laid_out(&app, asked.vehicle, &asked.plan, asked.clearance_m)).await.map(Json)
}

/// Designs a landing: the items that end a mission, none of their heights tuned by hand.
#[utoipa::path(post, path = "/plan/landing", tag = "plans", request_body = LandingRequest,
    responses((status = 200, body = Landing), Problem))]
async fn landing(
    State(app): State<App>,
    _: Viewer,
    Body(asked): Body<LandingRequest>,
) -> Result<Json<Landing>, Problem> {
    landings::designed(&app, &asked).await.map(Json)
}

/// The landings at a place, the best for this wind first: each direction of a runway, or of a fan of courses, with its circle on either side, and what
/// speaks for and against it. Each is rehearsed from `coming_from`, else from home.
#[utoipa::path(post, path = "/plan/landing/alternatives", tag = "plans", request_body = LandingRequest,
    responses((status = 200, body = Vec<LandingAlternative>), Problem))]
async fn alternatives(
    State(app): State<App>,
    _: Viewer,
    Body(asked): Body<LandingRequest>,
) -> Result<Json<Vec<LandingAlternative>>, Problem> {
    landings::alternatives(app, asked).await.map(Json)
}

/// A landing of which one part is moved; the rest follows.
#[utoipa::path(post, path = "/plan/landing/move", tag = "plans", request_body = LandingMove,
    responses((status = 200, body = Landing), Problem))]
async fn moved_landing(
    State(app): State<App>,
    _: Viewer,
    Body(asked): Body<LandingMove>,
) -> Result<Json<Landing>, Problem> {
    landings::moved(&app, &asked).map(Json)
}

/// Items with their heights counted from another level: at the same height in space where both levels are known, else with the same number,
/// and named in `unconverted`.
#[utoipa::path(post, path = "/plan/frame", tag = "plans", request_body = FrameChange,
    responses((status = 200, body = CountedItems), Problem))]
async fn counted_from(
    State(app): State<App>,
    _: Viewer,
    Body(asked): Body<FrameChange>,
) -> Result<Json<CountedItems>, Problem> {
    levels::counted(&app, &asked).await.map(Json)
}

/// Rehearses a plan: the track that the plane would really fly in a wind, when it reaches each item, and where it ends.
#[utoipa::path(post, path = "/plan/rehearse", tag = "plans", request_body = RehearsalRequest,
    responses((status = 200, body = Rehearsal), Problem))]
async fn rehearse(
    State(app): State<App>,
    _: Viewer,
    Body(asked): Body<RehearsalRequest>,
) -> Result<Json<Rehearsal>, Problem> {
    assess::rehearsal(&app, &asked).await.map(Json)
}

/// Which findings of a plan a change of its items, or of one parameter of the vehicle, resolves: each is tried, checked and rehearsed before it is
/// told. That may take seconds.
#[utoipa::path(post, path = "/plan/fixes", tag = "plans", request_body = RehearsalRequest,
    responses((status = 200, body = Vec<FindingFix>), Problem))]
async fn plan_fixes(
    State(app): State<App>,
    _: Viewer,
    Body(asked): Body<RehearsalRequest>,
) -> Result<Json<Vec<FindingFix>>, Problem> {
    assess::fixed(&app, &asked).await.map(Json)
}

/// Flies a plan many times in winds and with planes that are not quite those expected: where it may pass, and what the odds are. One is flown
/// after the other; who ends his request ends the flying.
#[utoipa::path(post, path = "/plan/rehearse/spread", tag = "plans", request_body = SpreadRequest,
    responses((status = 200, body = Spread), Problem))]
async fn rehearse_many(
    State(app): State<App>,
    _: Viewer,
    Body(asked): Body<SpreadRequest>,
) -> Result<Json<Spread>, Problem> {
    // Whoever goes away drops this.
    let asks = Arc::new(());
    let asking = Arc::downgrade(&asks);
    let spread = assess::spread(&app, asked, move || asking.strong_count() > 0).await;
    drop(asks);
    spread.map(Json)
}

/// What this vehicle's plans are rehearsed with, and what its flight teaches of it: that may be handed to a rehearsal as its `profile`.
#[utoipa::path(get, path = "/vehicles/{id}/profile", tag = "plans", params(("id" = u16, Path, description = "The vehicle's id")),
    responses((status = 200, body = VehicleProfile), Problem))]
async fn profile(_: Viewer, Vehicle(vehicle): Vehicle) -> Result<Json<VehicleProfile>, Problem> {
    in_turn(move || Ok(assess::vehicle_profile(&vehicle))).await.map(Json)
}

/// What to learn a plane from.
#[derive(Debug, Deserialize, IntoParams)]
#[into_params(parameter_in = Query)]
struct LearnFrom {
    /// The name of a recording on the server's disk, in place of a body.
    recording: Option<String>,
    /// The vehicle whose parameters, as far as they were read, are the plane's.
    vehicle: Option<u16>,
    /// Which vehicle of the recording; the first that tells its position when absent.
    system: Option<u8>,
}

/// Learns a plane from a recording of its flight, a `.tlog`: the body, or one on the server's disk. It takes a minute or two in the air, with
/// position, attitude and airspeed, in more than one direction. What the flight does not show keeps the value of the parameters.
#[utoipa::path(post, path = "/plan/learn", tag = "plans", params(LearnFrom),
    request_body(content = Vec<u8>, content_type = "application/octet-stream"),
    responses((status = 200, body = LearnedPlane), Problem))]
async fn learn(
    State(app): State<App>,
    ViewerRole(role): ViewerRole,
    from: Result<Query<LearnFrom>, QueryRejection>,
    body: body::Body,
) -> Result<Json<LearnedPlane>, Problem> {
    let Query(from) = from?;
    let vehicle = app.vehicle(from.vehicle);
    let plane = vehicle.map_or_else(Aircraft::default, |vehicle| vehicle.flies_in(Wind::default()).0);
    let system = from.system.map(SystemId);
    let Some(name) = &from.recording else {
        let work = move |body| learned(recorded_flight(body, system), &plane);
        return streams::read(body, role, MAX_FLIGHT_BYTES, work).await;
    };
    if !body.is_end_stream() {
        return Err(Problem::invalid("a recording is the body, or one on the server's disk, not both"));
    }
    let path = recordings::find(&app, name).await?.0;
    let flight = move || File::open(path).and_then(|file| recorded_flight(BufReader::new(file), system));
    in_turn(move || learned(flight(), &plane)).await
}

fn learned(flight: io::Result<Learner>, plane: &Aircraft) -> Result<Json<LearnedPlane>, Problem> {
    let flight = flight.map_err(|error| Problem::invalid(format!("the recording cannot be read: {error}")))?;
    let learned = flight.learned(plane).ok_or_else(|| {
        Problem::invalid(
            "no flight to learn from: it takes a minute or two in the air, with position, attitude and airspeed, in more than one direction",
        )
    })?;
    Ok(Json(assess::learned_plane(&learned)))
}

/// What follows when the link, the battery or the engine fails at a moment of a plan, or a return is asked for; of a vehicle in its
/// mission also from now on.
#[utoipa::path(post, path = "/plan/what-if", tag = "plans", request_body = WhatIfRequest,
    responses((status = 200, body = WhatIfs), Problem))]
async fn what_if(
    State(app): State<App>,
    _: Viewer,
    Body(asked): Body<WhatIfRequest>,
) -> Result<Json<WhatIfs>, Problem> {
    assess::what_if(app, asked).await.map(Json)
}

/// The commands that a plan may hold.
#[utoipa::path(get, path = "/commands", tag = "plans", responses((status = 200, body = Vec<CommandInfo>), Problem))]
async fn list_commands(_: Viewer) -> Json<Vec<CommandInfo>> {
    Json(convert::commands())
}
