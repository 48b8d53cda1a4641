//! Planned flights held against each other.

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

/// Where planned flights come too near to each other. Each is rehearsed as its vehicle would fly it, from the ground at its home and from its
/// start on; that is an assumption, and said in the answer. It tells: nothing is flown differently for it.
#[utoipa::path(post, path = "/plan/separation", tag = "plans", request_body = SeparationRequest,
    responses((status = 200, body = Separation), Problem))]
async fn separate(
    State(app): State<App>,
    _: Viewer,
    Body(asked): Body<SeparationRequest>,
) -> Result<Json<Separation>, Problem> {
    separation::separated(&app, asked).await.map(Json)
}
