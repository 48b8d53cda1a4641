//! Plans: on board (sent, read, removed, each an operation), in files, and what is doubtful in them.

#![allow(unused_qualifications, reason = "utoipa's query parameters name their type in full")]

use axum::Json;
use axum::body::Bytes;
use axum::extract::rejection::{BytesRejection, QueryRejection};
use axum::extract::{DefaultBodyLimit, Query, State};
use axum::http::{HeaderValue, StatusCode, header};
use axum::response::{IntoResponse, Response};
use serde::Deserialize;
use utoipa::IntoParams;
use utoipa_axum::router::OpenApiRouter;
use utoipa_axum::routes;
use vencejo_flight::checks::{Finding, Severity};
use vencejo_flight::formats::{MAX_FILE_BYTES, PlanSettings, read_plan, write_plan_json, write_waypoints};
use vencejo_flight::geodesy::GeoPoint;
use vencejo_flight::landing::design_landing;
use vencejo_flight::plan::{self as core};
use vencejo_station::{Pending, RequestResult, VehicleHandle};
use vencejo_vehicle::Request;

use crate::assess::assess;
use crate::convert;
use crate::dto::cause::Cause;
use crate::dto::{
    CommandInfo, Landing, LandingRequest, Operation, OperationKind, Plan, PlanCheck, PlanFormat, PlanKind, PlanOnBoard,
};
use crate::extract::{Json as Body, Operator, Pilot, Vehicle, Viewer};
use crate::problem::Problem;
use crate::state::App;

type Accepted = (StatusCode, Json<Operation>);

pub(super) fn router() -> OpenApiRouter<App> {
    OpenApiRouter::new()
        .routes(routes!(mission_on_board, upload_mission, clear_mission))
        .routes(routes!(fence_on_board, upload_fence, clear_fence))
        .routes(routes!(rally_on_board, upload_rally, clear_rally))
        .routes(routes!(download_mission))
        .routes(routes!(download_fence))
        .routes(routes!(download_rally))
        .routes(routes!(format_plan))
        .routes(routes!(check))
        .routes(routes!(landing))
        .routes(routes!(list_commands))
        .merge(OpenApiRouter::new().routes(routes!(parse)).layer(DefaultBodyLimit::max(MAX_FILE_BYTES)))
}

fn start(
    app: &App,
    vehicle: &VehicleHandle,
    kind: OperationKind,
    pending: Pending<RequestResult>,
) -> Result<Accepted, Problem> {
    let operation = app.follow(vehicle.system().0, kind, pending)?;
    Ok((StatusCode::ACCEPTED, Json(operation)))
}

/// The request that puts one part of a plan on board.
fn upload(kind: PlanKind, plan: &Plan) -> Result<Request, Problem> {
    let (items, home) = convert::core_plan(plan)?.into_list(convert::core_plan_kind(kind))?;
    // Nothing given is no wish to have nothing on board.
    if items.is_empty() {
        let (part, field) = match kind {
            PlanKind::Mission => ("mission", "items"),
            PlanKind::Fence => ("fence", "fence.zones"),
            PlanKind::Rally => ("rally points", "rally"),
        };
        let expected = format!("at least one; DELETE on this path removes the {part} on board");
        return Err(Problem::invalid_value(field, "empty", &expected));
    }
    Ok(Request::UploadPlan { kind: convert::core_plan_kind(kind), items, home })
}

/// Whether to look for errors first.
#[derive(Debug, Deserialize, IntoParams)]
#[into_params(parameter_in = Query)]
struct Checked {
    /// `false` sends a mission in spite of errors that the checks find.
    check: Option<bool>,
}

/// Refuses a mission that would fail. A fence or rally points are refused by their own rules.
fn require_sound(vehicle: &VehicleHandle, kind: PlanKind, plan: &Plan) -> Result<(), Problem> {
    if kind != PlanKind::Mission || plan.items.is_empty() {
        return Ok(());
    }
    let errors: Vec<_> = vehicle
        .check_upload(&convert::core_plan(plan)?)
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
        #[utoipa::path(get, path = $path, tag = "plans", params(("id" = u8, Path, description = "System id")),
                                            responses((status = 200, body = PlanOnBoard), Problem))]
        async fn $known(_: Viewer, Vehicle(vehicle): Vehicle) -> Result<Json<PlanOnBoard>, Problem> {
            Ok(Json(convert::plan_on_board(&vehicle, core::PlanKind::$kind)?))
        }

        /// Replaces this part of the plan on board by that of the plan given, and reads it back. Done means that the vehicle
        /// has it. The operation's result is the plan on board. A mission in which the checks find an error is refused, and so is
        /// a part with nothing in it: DELETE clears.
        #[utoipa::path(put, path = $path, tag = "plans", params(("id" = u8, Path, description = "System id"), Checked),
                                            request_body = Plan, responses((status = 202, body = Operation), Problem))]
        async fn $upload(
            State(app): State<App>,
            pilot: Pilot,
            Vehicle(vehicle): Vehicle,
            asked: Result<Query<Checked>, QueryRejection>,
            Body(plan): Body<Plan>,
        ) -> Result<Accepted, Problem> {
            if asked?.check.unwrap_or(true) {
                require_sound(&vehicle, PlanKind::$kind, &plan)?;
            }
            let pending = pilot.request(&vehicle, upload(PlanKind::$kind, &plan)?);
            start(&app, &vehicle, OperationKind::$upload_kind, pending)
        }

        /// Reads this part of the plan on board from the vehicle; it is the operation's result.
        #[utoipa::path(post, path = $read_path, tag = "plans", params(("id" = u8, Path, description = "System id")),
                                            responses((status = 202, body = Operation), Problem))]
        async fn $download(
            State(app): State<App>,
            _: Operator,
            Vehicle(vehicle): Vehicle,
        ) -> Result<Accepted, Problem> {
            let request = Request::DownloadPlan { kind: core::PlanKind::$kind };
            start(&app, &vehicle, OperationKind::$download_kind, vehicle.request(request))
        }

        /// Removes this part of the plan on board and checks that it is gone.
        #[utoipa::path(delete, path = $path, tag = "plans", params(("id" = u8, Path, description = "System id")),
                                            responses((status = 202, body = Operation), Problem))]
        async fn $clear(
            State(app): State<App>,
            pilot: Pilot,
            Vehicle(vehicle): Vehicle,
        ) -> Result<Accepted, Problem> {
            let request = Request::ClearPlan { kind: core::PlanKind::$kind };
            start(&app, &vehicle, OperationKind::$clear_kind, pilot.request(&vehicle, request))
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

/// The name of a file.
#[derive(Debug, Deserialize, IntoParams)]
#[into_params(parameter_in = Query)]
struct FileName {
    /// The file's name, for messages alone: the content decides what it is.
    name: Option<String>,
}

/// Reads a plan file of any known kind; the body is the file.
#[utoipa::path(post, path = "/plan/parse", tag = "plans", params(FileName),
    request_body(content = Vec<u8>, content_type = "application/octet-stream"),
    responses((status = 200, body = Plan), Problem))]
async fn parse(
    _: Viewer,
    file: Result<Query<FileName>, QueryRejection>,
    body: Result<Bytes, BytesRejection>,
) -> Result<Json<Plan>, Problem> {
    let (Query(file), body) = (file?, body?);
    let name = file.name.map(|name| name.chars().filter(|c| !c.is_control()).take(100).collect::<String>());
    let plan =
        super::parsed(body, move |bytes| read_plan(bytes, name.as_deref()).map(|read| convert::plan(&read.plan)));
    Ok(Json(plan.await?))
}

/// How to write a file.
#[derive(Debug, Deserialize, IntoParams)]
#[into_params(parameter_in = Query)]
struct FileKind {
    /// `plan` or `waypoints`.
    #[serde(rename = "as")]
    #[param(inline)]
    kind: PlanFormat,
}

/// Writes a plan to a file.
#[utoipa::path(post, path = "/plan/format", tag = "plans", params(FileKind), request_body = Plan,
    responses((status = 200, body = String, content_type = "text/plain"), Problem))]
async fn format_plan(
    _: Viewer,
    kind: Result<Query<FileKind>, QueryRejection>,
    Body(plan): Body<Plan>,
) -> Result<Response, Problem> {
    let (Query(kind), plan) = (kind?, convert::core_plan(&plan)?);
    let (text, mime, name) = match kind.kind {
        PlanFormat::Plan => (
            write_plan_json(&plan, &PlanSettings::default())?,
            "application/json",
            "attachment; filename=\"mission.plan\"",
        ),
        PlanFormat::Waypoints => {
            (write_waypoints(&plan)?, "text/plain; charset=utf-8", "attachment; filename=\"mission.waypoints\"")
        }
    };
    let headers = [
        (header::CONTENT_TYPE, HeaderValue::from_static(mime)),
        (header::CONTENT_DISPOSITION, HeaderValue::from_static(name)),
    ];
    Ok((headers, text).into_response())
}

/// Looks for what would make a plan fail.
#[utoipa::path(post, path = "/plan/check", tag = "plans", request_body = PlanCheck,
    responses((status = 200, body = Vec<Finding>), Problem))]
async fn check(State(app): State<App>, _: Viewer, Body(asked): Body<PlanCheck>) -> Result<Json<Vec<Finding>>, Problem> {
    Ok(Json(assess(&app, asked.vehicle, &asked.plan)?.findings))
}

/// Designs a landing: the items that end a mission, none of their heights tuned by hand.
#[utoipa::path(post, path = "/plan/landing", tag = "plans", request_body = LandingRequest,
    responses((status = 200, body = Landing), Problem))]
async fn landing(_: Viewer, Body(asked): Body<LandingRequest>) -> Result<Json<Landing>, Problem> {
    let point = GeoPoint::new(asked.at.lat_deg, asked.at.lon_deg)?;
    let designed = design_landing(point, &convert::landing_options(&asked)?)?;
    Ok(Json(convert::landing(&designed)))
}

/// The commands that a plan may hold.
#[utoipa::path(get, path = "/commands", tag = "plans", responses((status = 200, body = Vec<CommandInfo>), Problem))]
async fn list_commands(_: Viewer) -> Json<Vec<CommandInfo>> {
    Json(convert::commands())
}
