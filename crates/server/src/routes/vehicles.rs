//! State of the vehicles.

use axum::Json;
use axum::extract::State;
use axum::http::StatusCode;
use utoipa_axum::router::OpenApiRouter;
use utoipa_axum::routes;
use vencejo_station::{FarWish, VehicleHandle};

use crate::convert;
use crate::dto::cause::ResourceKind;
use crate::dto::{DeclinedRequest, Text, VehicleControl, VehicleState, VehicleSummary};
use crate::extract::{Operator, OptionalJson, Pilot, Vehicle, Viewer};
use crate::problem::Problem;
use crate::sessions::SessionId;
use crate::state::App;

pub(super) fn router() -> OpenApiRouter<App> {
    OpenApiRouter::new()
        .routes(routes!(list_vehicles))
        .routes(routes!(get_vehicle))
        .routes(routes!(list_texts))
        .routes(routes!(follow_rival))
        .routes(routes!(request_vehicle_control))
        .routes(routes!(release_vehicle_control))
        .routes(routes!(keep_vehicle_control))
}

/// Requests control of a remote vehicle from the ground station that has it; takes it when none does. The request
/// stands until it is granted, declined or withdrawn. For a vehicle on a link it is `POST /control/request`.
#[utoipa::path(post, path = "/vehicles/{id}/control/request", tag = "vehicles",
    params(("id" = u16, Path, description = "The vehicle's id")), responses((status = 200, body = VehicleControl), Problem))]
async fn request_vehicle_control(
    State(app): State<App>,
    Operator(id): Operator,
    Vehicle(vehicle): Vehicle,
) -> Result<Json<VehicleControl>, Problem> {
    control(&app, id, &vehicle, FarWish::Request).await
}

/// Releases control of a remote vehicle: to the ground station that requests it, if any. Also withdraws a request.
#[utoipa::path(post, path = "/vehicles/{id}/control/release", tag = "vehicles",
    params(("id" = u16, Path, description = "The vehicle's id")), responses((status = 200, body = VehicleControl), Problem))]
async fn release_vehicle_control(
    State(app): State<App>,
    Operator(id): Operator,
    Vehicle(vehicle): Vehicle,
) -> Result<Json<VehicleControl>, Problem> {
    control(&app, id, &vehicle, FarWish::Release).await
}

/// Declines the request of another ground station for control of a remote vehicle that this one has.
#[utoipa::path(post, path = "/vehicles/{id}/control/keep", tag = "vehicles", request_body = Option<DeclinedRequest>,
    params(("id" = u16, Path, description = "The vehicle's id")), responses((status = 200, body = VehicleControl), Problem))]
async fn keep_vehicle_control(
    State(app): State<App>,
    Operator(id): Operator,
    Vehicle(vehicle): Vehicle,
    OptionalJson(declined): OptionalJson<DeclinedRequest>,
) -> Result<Json<VehicleControl>, Problem> {
    control(&app, id, &vehicle, FarWish::Keep { requested_by: declined.requested_by }).await
}

async fn control(
    app: &App,
    session: SessionId,
    vehicle: &VehicleHandle,
    wish: FarWish,
) -> Result<Json<VehicleControl>, Problem> {
    let operator = app.sessions().operator(session).ok_or_else(Problem::no_session)?;
    vehicle.acting_as(operator).control(wish).wait().await.ok_or_else(Problem::closed)??;
    Ok(Json(convert::vehicle_control(vehicle.held())))
}

/// Switches to the other vehicle that uses this system id: it is followed and commanded from now on, in place of the
/// present one.
#[utoipa::path(post, path = "/vehicles/{id}/rival/follow", tag = "vehicles",
    params(("id" = u16, Path, description = "The vehicle's id")), responses((status = 204), Problem))]
async fn follow_rival(pilot: Pilot, Vehicle(vehicle): Vehicle) -> Result<StatusCode, Problem> {
    if pilot.vehicle(&vehicle).follow_rival()? {
        return Ok(StatusCode::NO_CONTENT);
    }
    let id = vehicle.id();
    let detail = format!("no other vehicle with system id {id} is heard");
    Err(Problem::not_found(ResourceKind::Vehicle, id, detail))
}

/// Lists the vehicles heard so far.
#[utoipa::path(get, path = "/vehicles", tag = "vehicles", responses((status = 200, body = Vec<VehicleSummary>), Problem))]
async fn list_vehicles(State(app): State<App>, _: Viewer) -> Json<Vec<VehicleSummary>> {
    Json(convert::vehicle_summaries(app.station()))
}

/// Returns the state of a vehicle.
#[utoipa::path(get, path = "/vehicles/{id}", tag = "vehicles", params(("id" = u16, Path, description = "The vehicle's id")),
    responses((status = 200, body = VehicleState), Problem))]
async fn get_vehicle(_: Viewer, Vehicle(vehicle): Vehicle) -> Json<VehicleState> {
    Json(convert::vehicle_state(&vehicle))
}

/// Returns the newest status texts of a vehicle, oldest first.
#[utoipa::path(get, path = "/vehicles/{id}/texts", tag = "vehicles",
    params(("id" = u16, Path, description = "The vehicle's id")), responses((status = 200, body = Vec<Text>), Problem))]
async fn list_texts(_: Viewer, Vehicle(vehicle): Vehicle) -> Json<Vec<Text>> {
    Json(convert::texts(&vehicle))
}
