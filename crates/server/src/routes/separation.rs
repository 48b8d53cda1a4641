//! Separation of planned flights.

use axum::Json;
use axum::extract::State;
use utoipa_axum::router::OpenApiRouter;
use utoipa_axum::routes;

use crate::dto::separation::{Separation, SeparationRequest};
use crate::extract::{Json as Body, Viewer};
use crate::problem::Problem;
use crate::separation;
use crate::state::App;

pub(super) fn router() -> OpenApiRouter<App> {
    OpenApiRouter::new().routes(routes!(separate))
}

/// Finds conflicts between planned flights. Each is rehearsed as its vehicle would fly it, starting from the ground at
/// its home; the answer states these assumptions. Advisory only: no flight is changed.
#[utoipa::path(post, path = "/plan/separation", tag = "plans", request_body = SeparationRequest,
    responses((status = 200, body = Separation), Problem))]
async fn separate(
    State(app): State<App>,
    _: Viewer,
    Body(asked): Body<SeparationRequest>,
) -> Result<Json<Separation>, Problem> {
    separation::separated(&app, asked).await.map(Json)
}
