//! Plans: on board (upload, download and clear, each as an operation), in files, and their checks.

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
use vencejo_flight::formats::{MAX_FILE_BYTES, Note, PlanSettings, PlannedFor, read_plan, write_plan};
use vencejo_flight::landing::Wind;
use vencejo_flight::plan::{self as core};
use vencejo_flight::rehearsal::{Aircraft, Learner};
use vencejo_proto::{Counted, SystemId, plain};
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

/// Request that uploads one part of a plan.
fn upload(kind: PlanKind, plan: &Plan, despite_findings: bool) -> Result<Request, Problem> {
    let (items, home) = convert::core_plan(plan)?.into_list(convert::core_plan_kind(kind))?;
    // An empty list is not a request to clear the part.
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

/// Whether to check for errors first.
#[derive(Debug, Deserialize, IntoParams)]
#[into_params(parameter_in = Query)]
struct Checked {
    /// `false` uploads it in spite of errors found by the checks.
    check: Option<bool>,
}

/// Refuses what the checks find would fail.
async fn require_sound(app: &App, vehicle: &VehicleHandle, kind: PlanKind, plan: &Plan) -> Result<(), Problem> {
    if kind == PlanKind::Mission && plan.items.is_empty() {
        return Ok(());
    }
    let (vehicle, plan, kind) = (vehicle.clone(), convert::core_plan(plan)?, convert::core_plan_kind(kind));
    let (map, _) = app.ground_around(&plan, vehicle.home());
    let found = in_turn(move || Ok(vehicle.check_upload(kind, &plan, Some(&|point| map.height_m(point))))).await?;
    let errors: Vec<_> = found
        .into_iter()
        .filter(|finding| finding.severity == Severity::Error)
        .map(|finding| finding.to_string())
        .collect();
    if errors.is_empty() {
        return Ok(());
    }
    let found = Counted(errors.len(), "error");
    let detail = format!("the plan has {found}: nothing was sent; POST /api/v1/plan/check lists all");
    Err(Problem::new(Cause::PlanUnsound { errors: errors.len() as u64 }, detail).reasons(errors))
}

/// Routes for one part of the plan on board.
macro_rules! plan_routes {
    ($path:tt, $kind:ident, $known:ident, $upload:ident = $upload_kind:ident, $read_path:tt,
     $download:ident = $download_kind:ident, $clear:ident = $clear_kind:ident) => {
        /// Returns this part of the plan on board, as far as it is known. Sends nothing to the vehicle: the station
        /// reads unknown parts by itself and reports changes with the WebSocket's `plan_state`.
        #[utoipa::path(get, path = $path, tag = "plans", params(("id" = u16, Path, description = "The vehicle's id")),
                                            responses((status = 200, body = PlanOnBoard), Problem))]
        async fn $known(_: Viewer, Vehicle(vehicle): Vehicle) -> Result<Json<PlanOnBoard>, Problem> {
            Ok(Json(convert::plan_on_board(&vehicle, core::PlanKind::$kind)?))
        }

        /// Replaces this part of the plan on board by that of the given plan, and reads it back. Once the operation is
        /// done, the vehicle has it; the result of the operation is the plan on board. One with errors found by the checks
        /// is refused, and so is an empty part: DELETE clears it.
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

        /// Reads this part of the plan on board; it is the result of the operation.
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

        /// Clears this part of the plan on board and verifies that it is empty.
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

/// Compares a plan with the one on board: items added, removed and changed, at the vehicle's storage precision. Sends
/// nothing to the vehicle.
#[utoipa::path(post, path = "/vehicles/{id}/plan/compare", tag = "plans", params(("id" = u16, Path, description = "The vehicle's id")),
    request_body = Plan, responses((status = 200, body = PlanComparison), Problem))]
async fn compare(
    _: Viewer,
    Vehicle(vehicle): Vehicle,
    Body(plan): Body<Plan>,
) -> Result<Json<PlanComparison>, Problem> {
    quickly(move || Ok(Json(convert::plan_comparison(&vehicle, &convert::core_plan(&plan)?)))).await
}

/// Name of a file.
#[derive(Debug, Deserialize, IntoParams)]
#[into_params(parameter_in = Query)]
struct FileName {
    /// The file name, for messages only: the content determines the format.
    name: Option<String>,
}

/// Assumptions and omissions in reading or writing a file: JSON, a list of `PlanFileNote`.
const NOTES: HeaderName = HeaderName::from_static("vencejo-notes");

fn notes_header(notes: &[Note]) -> (HeaderName, HeaderValue) {
    let text = serde_json::to_string(notes).expect("invariant: codes and numbers are JSON");
    (NOTES, HeaderValue::try_from(text).expect("invariant: codes and numbers are ASCII"))
}

/// Parses a plan file of any supported format; the body is the file. Assumptions and omissions are in the header
/// `Vencejo-Notes`.
#[utoipa::path(post, path = "/plan/parse", tag = "plans", params(FileName),
    request_body(content = Vec<u8>, content_type = "application/octet-stream"),
    responses((status = 200, body = Plan, headers(("Vencejo-Notes" = String, description = "JSON: a list of `PlanFileNote`"))), Problem))]
async fn parse(
    _: Viewer,
    file: Result<Query<FileName>, QueryRejection>,
    body: Result<Bytes, BytesRejection>,
) -> Result<Response, Problem> {
    let (Query(file), body) = (file?, body?);
    let name = file.name.map(|name| plain(&name, 100));
    let read = super::parsed(body, move |bytes| read_plan(bytes, name.as_deref())).await?;
    let PlanSettings { planned_for, complex_items } = read.settings;
    let planned_for = (planned_for != PlannedFor::default()).then_some(planned_for);
    let plan = Plan { planned_for, complex_items, ..convert::plan(&read.plan) };
    Ok(([notes_header(&read.notes)], Json(plan)).into_response())
}

/// Format of a file.
#[derive(Debug, Deserialize, IntoParams)]
#[into_params(parameter_in = Query)]
struct FileKind {
    /// Format, named by its file extension.
    #[serde(rename = "as")]
    #[param(inline)]
    kind: PlanFormat,
}

/// Formats a plan as a file. Parts of the plan that the file does not preserve are in the header `Vencejo-Notes`.
#[utoipa::path(post, path = "/plan/format", tag = "plans", params(FileKind), request_body = Plan,
    responses((status = 200,
               content((Vec<u8> = "application/json"), (Vec<u8> = "text/plain"), (Vec<u8> = "text/csv"),
                       (Vec<u8> = "application/vnd.google-earth.kml+xml"), (Vec<u8> = "application/vnd.google-earth.kmz"),
                       (Vec<u8> = "application/geo+json"), (Vec<u8> = "application/gpx+xml")),
               headers(("Vencejo-Notes" = String, description = "JSON: a list of `PlanFileNote`"))), Problem))]
async fn format_plan(
    _: Viewer,
    kind: Result<Query<FileKind>, QueryRejection>,
    Body(plan): Body<Plan>,
) -> Result<Response, Problem> {
    let Query(kind) = kind?;
    let planned_for = plan.planned_for.unwrap_or_default();
    let settings = PlanSettings { planned_for, complex_items: plan.complex_items.clone() };
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

/// Checks a plan for anything that would make it fail.
#[utoipa::path(post, path = "/plan/check", tag = "plans", request_body = PlanCheck,
    responses((status = 200, body = Vec<Finding>), Problem))]
async fn check(State(app): State<App>, _: Viewer, Body(asked): Body<PlanCheck>) -> Result<Json<Vec<Finding>>, Problem> {
    let profile = PlaneProfile::default();
    in_turn(move || Ok(Json(assess(&app, asked.vehicle, &asked.plan, None, None, &profile)?.findings))).await
}

/// Returns the route of a plan's mission as drawn on the map: lines between positions, circles, jumps, lengths and
/// courses; and its altitude profile with the terrain below. While a point is dragged, use the WebSocket (`plan_way`).
#[utoipa::path(post, path = "/plan/way", tag = "plans", request_body = WayRequest,
    responses((status = 200, body = Way), Problem))]
async fn way(State(app): State<App>, _: Viewer, Body(asked): Body<WayRequest>) -> Result<Json<Way>, Problem> {
    quickly(move || assess::laid_out(&app, asked.vehicle, &asked.plan, asked.clearance_m)).await.map(Json)
}

/// Designs a landing: the items that end a mission, with computed altitudes.
#[utoipa::path(post, path = "/plan/landing", tag = "plans", request_body = LandingRequest,
    responses((status = 200, body = Landing), Problem))]
async fn landing(
    State(app): State<App>,
    _: Viewer,
    Body(asked): Body<LandingRequest>,
) -> Result<Json<Landing>, Problem> {
    landings::designed(&app, &asked).await.map(Json)
}

/// Proposes landings at a position, the best for this wind first: each direction of a runway, or of a fan of courses,
/// with its circle on either side, and the reasons for and against it. Each is rehearsed from `coming_from`, else from
/// home.
#[utoipa::path(post, path = "/plan/landing/alternatives", tag = "plans", request_body = LandingRequest,
    responses((status = 200, body = Vec<LandingAlternative>), Problem))]
async fn alternatives(
    State(app): State<App>,
    _: Viewer,
    Body(asked): Body<LandingRequest>,
) -> Result<Json<Vec<LandingAlternative>>, Problem> {
    landings::alternatives(app, asked).await.map(Json)
}

/// Moves one part of a landing and adapts the rest.
#[utoipa::path(post, path = "/plan/landing/move", tag = "plans", request_body = LandingMove,
    responses((status = 200, body = Landing), Problem))]
async fn moved_landing(
    State(app): State<App>,
    _: Viewer,
    Body(asked): Body<LandingMove>,
) -> Result<Json<Landing>, Problem> {
    landings::moved(&app, &asked).map(Json)
}

/// Converts altitudes of items to another frame. Where a reference level is unknown, an item keeps its number and is
/// listed in `unconverted`.
#[utoipa::path(post, path = "/plan/frame", tag = "plans", request_body = FrameChange,
    responses((status = 200, body = CountedItems), Problem))]
async fn counted_from(
    State(app): State<App>,
    _: Viewer,
    Body(asked): Body<FrameChange>,
) -> Result<Json<CountedItems>, Problem> {
    levels::counted(&app, &asked).await.map(Json)
}

/// Rehearses a plan: the track that the plane would fly in a wind, when it reaches each item, and where it ends.
#[utoipa::path(post, path = "/plan/rehearse", tag = "plans", request_body = RehearsalRequest,
    responses((status = 200, body = Rehearsal), Problem))]
async fn rehearse(
    State(app): State<App>,
    _: Viewer,
    Body(asked): Body<RehearsalRequest>,
) -> Result<Json<Rehearsal>, Problem> {
    assess::rehearsal(&app, &asked).await.map(Json)
}

/// Finds changes of a plan's items, or of one vehicle parameter, that resolve its findings. Each is applied, checked
/// and rehearsed first, which can take seconds.
#[utoipa::path(post, path = "/plan/fixes", tag = "plans", request_body = RehearsalRequest,
    responses((status = 200, body = Vec<FindingFix>), Problem))]
async fn plan_fixes(
    State(app): State<App>,
    _: Viewer,
    Body(asked): Body<RehearsalRequest>,
) -> Result<Json<Vec<FindingFix>>, Problem> {
    assess::fixed(&app, &asked).await.map(Json)
}

/// Flies a plan many times in winds and with planes that differ from the expected ones: the corridor of the flights and
/// the frequency of their endings. Such requests are processed one at a time; closing the connection cancels one.
#[utoipa::path(post, path = "/plan/rehearse/spread", tag = "plans", request_body = SpreadRequest,
    responses((status = 200, body = Spread), Problem))]
async fn rehearse_many(
    State(app): State<App>,
    _: Viewer,
    Body(asked): Body<SpreadRequest>,
) -> Result<Json<Spread>, Problem> {
    // Dropped when the client disconnects.
    let asks = Arc::new(());
    let asking = Arc::downgrade(&asks);
    let spread = assess::spread(&app, asked, move || asking.strong_count() > 0).await;
    drop(asks);
    spread.map(Json)
}

/// Returns the data with which this vehicle's plans are rehearsed, and the model estimated from its flight, which can
/// be given to a rehearsal as its `profile`.
#[utoipa::path(get, path = "/vehicles/{id}/profile", tag = "plans", params(("id" = u16, Path, description = "The vehicle's id")),
    responses((status = 200, body = VehicleProfile), Problem))]
async fn profile(_: Viewer, Vehicle(vehicle): Vehicle) -> Result<Json<VehicleProfile>, Problem> {
    in_turn(move || Ok(assess::vehicle_profile(&vehicle))).await.map(Json)
}

/// Source of the flight to learn from.
#[derive(Debug, Deserialize, IntoParams)]
#[into_params(parameter_in = Query)]
struct LearnFrom {
    /// Name of a recording on the server's disk, in place of a body.
    recording: Option<String>,
    /// Vehicle whose parameters, as far as they were read, describe the plane.
    vehicle: Option<u16>,
    /// System id of the vehicle in the recording; the first that reports its position when absent.
    system: Option<u8>,
}

/// Estimates the model of a plane from a recording of its flight, a `.tlog`: the body, or a file on the server's disk.
/// It needs a minute or two in the air, with position, attitude and airspeed, in more than one direction. Values that
/// the flight does not show are taken from the parameters.
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
        return Err(Problem::invalid(
            "give a recording as the body, or the name of one on the server's disk, not both",
        ));
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

/// Simulates what follows when the link, the battery or the engine fails, or a return is commanded, at a time in a plan
/// or, for a vehicle in flight, from now on.
#[utoipa::path(post, path = "/plan/what-if", tag = "plans", request_body = WhatIfRequest,
    responses((status = 200, body = WhatIfs), Problem))]
async fn what_if(
    State(app): State<App>,
    _: Viewer,
    Body(asked): Body<WhatIfRequest>,
) -> Result<Json<WhatIfs>, Problem> {
    assess::what_if(app, asked).await.map(Json)
}

/// Lists the commands that a plan may contain.
#[utoipa::path(get, path = "/commands", tag = "plans", responses((status = 200, body = Vec<CommandInfo>), Problem))]
async fn list_commands(_: Viewer) -> Json<Vec<CommandInfo>> {
    Json(convert::commands())
}
