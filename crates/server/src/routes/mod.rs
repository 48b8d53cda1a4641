//! Routes of the API, one file per group, and their OpenAPI description.

mod cameras;
mod commands;
mod elevation;
mod footage;
mod history;
mod links;
mod maps;
mod maps_areas;
mod messages;
mod operations;
mod params;
mod plans;
mod recordings;
mod replays;
mod separation;
mod sessions;
mod signing;
mod storage;
mod streams;
mod surveys;
mod tiles;
mod vehicles;

pub use messages::message_id;

use axum::body::Bytes;
use axum::extract::{DefaultBodyLimit, State};
use axum::http::Uri;
use axum::response::IntoResponse;
use axum::routing::get;
use axum::{Json, Router, middleware};
use tower_http::compression::CompressionLayer;
use tower_http::compression::predicate::{NotForContentType, Predicate, SizeAbove};
use utoipa::OpenApi;
use utoipa::openapi::OpenApi as Description;
use utoipa_axum::router::OpenApiRouter;
use utoipa_axum::routes;
use vencejo_flight::FlightError;
use vencejo_flight::formats::Note;

use crate::dto::cause::{Cause, ResourceKind};
use crate::problem::Problem;
use crate::state::App;
use crate::turns::in_turn;
use crate::{body, dto, files, guard};

/// Default limit of a request body, bytes.
const MAX_BODY: usize = 64 * 1024;
/// Limit of a plan as JSON, bytes: enough for 10,000 items.
const MAX_PLAN: usize = 8 * 1024 * 1024;

/// Common prefix of all paths.
const PREFIX: &str = "/api/v1";

#[derive(OpenApi)]
#[openapi(
    info(
        title = "Vencejo",
        description = "See and command vehicles. One operator at a time holds control, and the first who acts takes \
                       it. What can end a flight or destroy what is on board is answered with status 428 and a \
                       confirmation: the same request with it in the header `Vencejo-Confirmation` does it, once and \
                       within 15 s. Errors are `application/problem+json` and say what to do. Telemetry comes by the WebSocket `/api/v1/ws`: the \
                       client says `ClientMessage`, the server says `ServerMessage`.",
    ),
    components(schemas(dto::ClientMessage, dto::ServerMessage, dto::camera::CameraMessage, Note))
)]
struct Base;

fn api() -> OpenApiRouter<App> {
    let small = OpenApiRouter::new()
        .routes(routes!(info))
        .merge(sessions::router())
        .merge(links::router())
        .merge(vehicles::router())
        .merge(commands::router())
        .merge(params::router())
        .merge(signing::router())
        .merge(operations::router())
        .merge(cameras::router())
        .merge(footage::router())
        .merge(messages::router())
        .merge(recordings::router())
        .merge(replays::router())
        .merge(history::router())
        .merge(storage::router())
        .merge(maps::router())
        .merge(tiles::router())
        .layer(DefaultBodyLimit::max(MAX_BODY));
    let large = plans::router()
        .merge(surveys::router())
        .merge(separation::router())
        .merge(maps_areas::router())
        .merge(elevation::router())
        .merge(elevation::plan_router());
    let large = large.layer(DefaultBodyLimit::max(MAX_PLAN));
    let files = maps::file_router().merge(maps_areas::file_router()).merge(storage::draft_router());
    OpenApiRouter::with_openapi(Base::openapi()).nest(PREFIX, small.merge(large).merge(files))
}

/// OpenAPI 3.1 description of the API, as committed in schemas/openapi.json.
pub fn description() -> Description {
    let mut description = api().into_openapi();
    description.info.version = crate::VERSION.to_owned();
    description.info.license = None;
    description.info.contact = None;
    description
}

/// Router of everything that the server serves.
pub fn router(app: App) -> Router {
    let (api, _) = api().split_for_parts();
    let openapi = description();
    // Compression only slows down small answers and those that are already compressed.
    let is_open = NotForContentType::IMAGES
        .and(NotForContentType::const_new("font/"))
        .and(NotForContentType::const_new("video/"));
    let worth_packing = SizeAbove::new(1024).and(is_open);
    api.route("/api/v1/openapi.json", get(move || async move { Json(openapi) }))
        .route("/api/v1/ws", get(sessions::websocket))
        .route("/api", get(no_such_path))
        .route("/api/{*rest}", axum::routing::any(no_such_path))
        .fallback(files::serve)
        .method_not_allowed_fallback(no_such_method)
        .layer(CompressionLayer::new().gzip(true).compress_when(worth_packing))
        .layer(middleware::from_fn(body::in_time))
        .layer(middleware::from_fn_with_state(app.clone(), guard::guard))
        .with_state(app)
}

/// Parses an uploaded file off the async threads.
async fn parsed<T: Send + 'static>(
    body: Bytes,
    read: impl FnOnce(&[u8]) -> Result<T, FlightError> + Send + 'static,
) -> Result<T, Problem> {
    in_turn(move || Ok(read(&body)?)).await
}

async fn no_such_path(uri: Uri) -> impl IntoResponse {
    Problem::not_found(ResourceKind::Path, uri.path(), "there is no such path")
        .remedy("GET /api/v1/openapi.json describes the existing ones")
}

async fn no_such_method() -> impl IntoResponse {
    Problem::new(Cause::Method, "this path does not support this method")
        .remedy("GET /api/v1/openapi.json describes the API")
}

/// Returns the server's version, and whether it requires a token. Needs no session.
#[utoipa::path(get, path = "/info", tag = "server", responses((status = 200, body = dto::Info), Problem))]
async fn info(State(app): State<App>) -> Json<dto::Info> {
    Json(dto::Info {
        name: "vencejo".to_owned(),
        version: crate::VERSION.to_owned(),
        needs_token: app.access().tokens.is_some(),
    })
}
