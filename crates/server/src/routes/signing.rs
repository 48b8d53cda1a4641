//! State and change of a vehicle's signing. Keys never pass through here.

use axum::Json;
use utoipa_axum::router::OpenApiRouter;
use utoipa_axum::routes;
use vencejo_station::SigningChange;

use crate::convert;
use crate::dto::{ChangeSigning, SigningAct, SigningInfo};
use crate::extract::{Json as Body, Pilot, Vehicle, Viewer};
use crate::problem::Problem;
use crate::state::App;

pub(super) fn router() -> OpenApiRouter<App> {
    OpenApiRouter::new().routes(routes!(get_signing, change_signing))
}

/// Returns the signing state of a vehicle.
#[utoipa::path(get, path = "/vehicles/{id}/signing", tag = "signing",
    params(("id" = u16, Path, description = "The vehicle's id")), responses((status = 200, body = SigningInfo), Problem))]
async fn get_signing(_: Viewer, Vehicle(vehicle): Vehicle) -> Json<SigningInfo> {
    Json(convert::signing(&vehicle))
}

/// Sets, replaces or removes a vehicle's signing key, and waits up to 5 s for its frames to confirm the change.
/// Permitted only while it is disarmed. Until the confirmation, frames to it are signed as before.
#[utoipa::path(post, path = "/vehicles/{id}/signing", tag = "signing",
    params(("id" = u16, Path, description = "The vehicle's id")), request_body = ChangeSigning,
    responses((status = 200, body = SigningInfo), Problem))]
async fn change_signing(
    pilot: Pilot,
    Vehicle(vehicle): Vehicle,
    Body(asked): Body<ChangeSigning>,
) -> Result<Json<SigningInfo>, Problem> {
    if vehicle.system().is_some_and(|system| asked.confirm_system_id != system.0) {
        let expected = format!("the vehicle's system id, {}", vehicle.id());
        return Err(Problem::invalid_value("confirm_system_id", asked.confirm_system_id, &expected));
    }
    let change = match asked.act {
        SigningAct::SetUp => SigningChange::SetUp { key: None },
        SigningAct::Rotate => SigningChange::Rotate { key: None },
        SigningAct::Remove => SigningChange::Remove,
    };
    pilot.vehicle(&vehicle).change_signing(change, asked.any_link).wait().await.ok_or_else(Problem::closed)??;
    Ok(Json(convert::signing(&vehicle)))
}
