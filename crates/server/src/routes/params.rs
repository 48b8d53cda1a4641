//! Parameters of a vehicle.

use axum::Json;
use axum::extract::State;
use axum::http::StatusCode;
use utoipa_axum::router::OpenApiRouter;
use utoipa_axum::routes;
use vencejo_station::VehicleHandle;
use vencejo_vehicle::{Reply, Request};

use crate::convert;
use crate::dto::{NewParam, Operation, OperationKind, Param};
use crate::extract::{Json as Body, Name, Operator, Pilot, Vehicle};
use crate::problem::Problem;
use crate::state::App;

pub(super) fn router() -> OpenApiRouter<App> {
    OpenApiRouter::new().routes(routes!(read_params)).routes(routes!(get_param, set_param))
}

/// Reads all parameters; the operation's result is the list.
#[utoipa::path(get, path = "/vehicles/{id}/params", tag = "params", params(("id" = u8, Path, description = "System id")),
    responses((status = 202, body = Operation), Problem))]
async fn read_params(
    State(app): State<App>,
    _: Operator,
    Vehicle(vehicle): Vehicle,
) -> Result<(StatusCode, Json<Operation>), Problem> {
    let pending = vehicle.request(Request::ParamList);
    let operation = app.follow(vehicle.system().0, OperationKind::ReadParams, pending)?;
    Ok((StatusCode::ACCEPTED, Json(operation)))
}

async fn ask(vehicle: &VehicleHandle, request: Request) -> Result<Json<Param>, Problem> {
    match vehicle.request(request).wait().await.ok_or_else(Problem::closed)?? {
        Reply::Parameter(param) => Ok(Json(convert::param(&param))),
        _ => Err(Problem::closed()),
    }
}

/// Reads one parameter from the vehicle.
#[utoipa::path(get, path = "/vehicles/{id}/params/{name}", tag = "params",
    params(("id" = u8, Path, description = "System id"), ("name" = String, Path, description = "Up to 16 characters")),
    responses((status = 200, body = Param), Problem))]
async fn get_param(_: Operator, Vehicle(vehicle): Vehicle, Name(name): Name) -> Result<Json<Param>, Problem> {
    ask(&vehicle, Request::ParamRead { name }).await
}

/// Writes one parameter; answers with the value that the vehicle keeps.
#[utoipa::path(put, path = "/vehicles/{id}/params/{name}", tag = "params", request_body = NewParam,
    params(("id" = u8, Path, description = "System id"), ("name" = String, Path, description = "Up to 16 characters")),
    responses((status = 200, body = Param), Problem))]
async fn set_param(
    _: Pilot,
    Vehicle(vehicle): Vehicle,
    Name(name): Name,
    Body(new): Body<NewParam>,
) -> Result<Json<Param>, Problem> {
    ask(&vehicle, Request::ParamSet { name, value: new.value }).await
}
