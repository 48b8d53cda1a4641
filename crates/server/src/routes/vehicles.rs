//! State of the vehicles.

use axum::Json;
use axum::extract::State;
use axum::http::StatusCode;
use utoipa_axum::router::OpenApiRouter;
use utoipa_axum::routes;

use crate::convert;
use crate::dto::cause::ResourceKind;
use crate::dto::{Text, VehicleState, VehicleSummary};
use crate::extract::{Pilot, Vehicle, Viewer};
use crate::problem::Problem;
use crate::state::App;

pub(super) fn router() -> OpenApiRouter<App> {
    OpenApiRouter::new()
        .routes(routes!(list_vehicles))
        .routes(routes!(get_vehicle))
        .routes(routes!(list_texts))
        .routes(routes!(follow_rival))
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
