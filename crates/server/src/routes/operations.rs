//! Operations: list, result and cancellation.

use axum::Json;
use axum::extract::State;
use axum::http::StatusCode;
use utoipa_axum::router::OpenApiRouter;
use utoipa_axum::routes;

use crate::dto::Operation;
use crate::dto::cause::ResourceKind;
use crate::extract::{Id, Operator, Viewer, in_control};
use crate::problem::Problem;
use crate::state::App;

pub(super) fn router() -> OpenApiRouter<App> {
    OpenApiRouter::new().routes(routes!(list_operations)).routes(routes!(get_operation, cancel_operation))
}

fn gone(id: u64) -> Problem {
    Problem::not_found(ResourceKind::Operation, id, format!("there is no operation {id}, or it ended long ago"))
}

/// Lists running and recently ended operations, without their results.
#[utoipa::path(get, path = "/operations", tag = "operations", responses((status = 200, body = Vec<Operation>), Problem))]
async fn list_operations(State(app): State<App>, _: Viewer) -> Json<Vec<Operation>> {
    Json(app.operations().list())
}

/// Returns an operation, with its result once it is done.
#[utoipa::path(get, path = "/operations/{id}", tag = "operations", params(("id" = u64, Path, description = "Id of the operation")),
    responses((status = 200, body = Operation), Problem))]
async fn get_operation(State(app): State<App>, _: Viewer, Id(id): Id) -> Result<Json<Operation>, Problem> {
    app.operations().get(id).map(Json).ok_or_else(|| gone(id))
}

/// Cancels an operation; permitted for the session that started it and for the holder of control. The part of the plan
/// concerned is unknown until it is read again.
#[utoipa::path(delete, path = "/operations/{id}", tag = "operations", params(("id" = u64, Path, description = "Id of the operation")),
    responses((status = 202, body = Operation), Problem))]
async fn cancel_operation(
    State(app): State<App>,
    Operator(session): Operator,
    Id(id): Id,
) -> Result<(StatusCode, Json<Operation>), Problem> {
    if app.operations().begun_by(id) != Some(session) {
        in_control(&app, session)?;
    }
    let operation = app.operations().cancel(id).ok_or_else(|| gone(id))?;
    Ok((StatusCode::ACCEPTED, Json(operation)))
}
