//! Offline areas: estimate, create, pause, remove, export and import.

#![allow(unused_qualifications, reason = "utoipa's query parameters name their type in full")]

use axum::Json;
use axum::body::Body;
use axum::extract::rejection::QueryRejection;
use axum::extract::{DefaultBodyLimit, Query, State};
use axum::http::{HeaderValue, StatusCode, header};
use axum::response::{IntoResponse, Response};
use serde::Deserialize;
use utoipa::IntoParams;
use utoipa_axum::router::OpenApiRouter;
use utoipa_axum::routes;
use vencejo_maps::cover::Shape;
use vencejo_maps::geo::Corner;
use vencejo_maps::uploads::MAX_FILE_BYTES;
use vencejo_maps::{Area, Estimate, NewArea};

use crate::convert;
use crate::dto::maps::{AreaRequest, AreaShape};
use crate::dto::{LatLon, Plan};
use crate::extract::{Json as JsonBody, Operator, Text, Viewer};
use crate::problem::Problem;
use crate::state::App;

pub(super) fn router() -> OpenApiRouter<App> {
    OpenApiRouter::new()
        .routes(routes!(estimate_map_area))
        .routes(routes!(list_map_areas, add_map_area))
        .routes(routes!(get_map_area, remove_map_area))
        .routes(routes!(pause_map_area))
        .routes(routes!(resume_map_area))
        .routes(routes!(export_map_area))
}

/// Routes that accept whole files.
pub(super) fn file_router() -> OpenApiRouter<App> {
    OpenApiRouter::new().routes(routes!(import_map_area)).layer(DefaultBodyLimit::disable())
}

pub(super) fn corners(points: &[LatLon]) -> Vec<Corner> {
    points.iter().map(|at| Corner { lat_deg: at.lat_deg, lon_deg: at.lon_deg }).collect()
}

/// Home and the positions of a plan's mission, in order.
pub(super) fn route_of(plan: &Plan) -> Result<Vec<Corner>, Problem> {
    let core = convert::core_plan(plan)?;
    let home = plan.home.map(|home| Corner { lat_deg: home.lat_deg, lon_deg: home.lon_deg });
    let places = core.mission.items.iter().filter_map(vencejo_flight::plan::MissionItem::point);
    let points: Vec<Corner> =
        home.into_iter().chain(places.map(|at| Corner { lat_deg: at.lat_deg(), lon_deg: at.lon_deg() })).collect();
    if points.is_empty() { Err(Problem::invalid("plan: it has no position")) } else { Ok(points) }
}

fn wanted(asked: AreaRequest) -> Result<NewArea, Problem> {
    let shape = match asked.shape {
        AreaShape::Box(bounds) => Shape::Box(bounds),
        AreaShape::Polygon { points } => Shape::Polygon { points: corners(&points) },
        AreaShape::Route { points, buffer_m } => Shape::Route { points: corners(&points), buffer_m },
        AreaShape::Plan { plan, buffer_m } => Shape::Route { points: route_of(&plan)?, buffer_m },
    };
    let AreaRequest { source, name, min_level, max_level, .. } = asked;
    Ok(NewArea { source, name, shape, min_level, max_level })
}

/// Estimates an area: number of tiles, and bytes still to be downloaded.
#[utoipa::path(post, path = "/maps/areas/estimate", tag = "maps", request_body = AreaRequest,
    responses((status = 200, body = Estimate), Problem))]
async fn estimate_map_area(
    State(app): State<App>,
    _: Viewer,
    JsonBody(asked): JsonBody<AreaRequest>,
) -> Result<Json<Estimate>, Problem> {
    Ok(Json(app.maps()?.estimate_area(&wanted(asked)?).await?))
}

/// Lists the offline areas of all sources, oldest first.
#[utoipa::path(get, path = "/maps/areas", tag = "maps", responses((status = 200, body = Vec<Area>), Problem))]
async fn list_map_areas(State(app): State<App>, _: Viewer) -> Result<Json<Vec<Area>>, Problem> {
    Ok(Json(app.maps()?.areas().await?))
}

/// Creates an offline area and starts its download. Refused when the source's terms of use forbid it.
#[utoipa::path(post, path = "/maps/areas", tag = "maps", request_body = AreaRequest,
    responses((status = 201, body = Area), Problem))]
async fn add_map_area(
    State(app): State<App>,
    _: Operator,
    JsonBody(asked): JsonBody<AreaRequest>,
) -> Result<(StatusCode, Json<Area>), Problem> {
    Ok((StatusCode::CREATED, Json(app.maps()?.add_area(wanted(asked)?).await?)))
}

/// Returns an offline area.
#[utoipa::path(get, path = "/maps/areas/{id}", tag = "maps", params(("id" = String, Path, description = "Id of the area")),
    responses((status = 200, body = Area), Problem))]
async fn get_map_area(State(app): State<App>, _: Viewer, Text(id): Text) -> Result<Json<Area>, Problem> {
    Ok(Json(app.maps()?.area(&id).await?))
}

/// Removes an offline area. Its tiles stay in the cache until they are evicted as least recently used.
#[utoipa::path(delete, path = "/maps/areas/{id}", tag = "maps", params(("id" = String, Path, description = "Id of the area")),
    responses((status = 204), Problem))]
async fn remove_map_area(State(app): State<App>, _: Operator, Text(id): Text) -> Result<StatusCode, Problem> {
    app.maps()?.remove_area(&id).await?;
    Ok(StatusCode::NO_CONTENT)
}

/// Pauses the download of an area.
#[utoipa::path(post, path = "/maps/areas/{id}/pause", tag = "maps", params(("id" = String, Path, description = "Id of the area")),
    responses((status = 200, body = Area), Problem))]
async fn pause_map_area(State(app): State<App>, _: Operator, Text(id): Text) -> Result<Json<Area>, Problem> {
    Ok(Json(app.maps()?.pause_area(&id).await?))
}

/// Resumes an area and retries failed tiles.
#[utoipa::path(post, path = "/maps/areas/{id}/resume", tag = "maps", params(("id" = String, Path, description = "Id of the area")),
    responses((status = 200, body = Area), Problem))]
async fn resume_map_area(State(app): State<App>, _: Operator, Text(id): Text) -> Result<Json<Area>, Problem> {
    Ok(Json(app.maps()?.resume_area(&id).await?))
}

/// Exports the downloaded part of an area as an MBTiles file.
#[utoipa::path(get, path = "/maps/areas/{id}/export", tag = "maps", params(("id" = String, Path, description = "Id of the area")),
    responses((status = 200, body = Vec<u8>, content_type = "application/x-sqlite3"), Problem))]
async fn export_map_area(State(app): State<App>, _: Viewer, Text(id): Text) -> Result<Response, Problem> {
    let (path, name) = app.maps()?.export_area(&id).await?;
    let name: String =
        name.chars().map(|c| if c.is_ascii_alphanumeric() || matches!(c, '-' | '_' | '.') { c } else { '_' }).collect();
    let (body, length) = super::streams::give(path).await?;
    let disposition = HeaderValue::from_str(&format!("attachment; filename=\"{name}.mbtiles\""));
    let headers = [
        (header::CONTENT_TYPE, HeaderValue::from_static("application/x-sqlite3")),
        (header::CONTENT_LENGTH, HeaderValue::from(length)),
        (header::CONTENT_DISPOSITION, disposition.expect("invariant: plain characters are a header")),
    ];
    Ok((headers, body).into_response())
}

#[derive(Debug, Deserialize, IntoParams)]
#[into_params(parameter_in = Query)]
struct Import {
    /// Id of the source to which the tiles belong.
    source: String,
    /// Display name of the area; the file's own name when empty.
    #[serde(default)]
    name: String,
}

/// Imports an exported MBTiles file, of this or another station, into a source's cache, as a completed area.
#[utoipa::path(post, path = "/maps/areas/import", tag = "maps", params(Import),
    request_body(content = Vec<u8>, content_type = "application/octet-stream"),
    responses((status = 201, body = Area), Problem))]
async fn import_map_area(
    State(app): State<App>,
    _: Operator,
    import: Result<Query<Import>, QueryRejection>,
    body: Body,
) -> Result<(StatusCode, Json<Area>), Problem> {
    let (maps, Query(import)) = (app.maps()?, import?);
    let mut upload = maps.begin_upload("import.mbtiles").await?;
    super::streams::take(body, &mut upload, MAX_FILE_BYTES).await?;
    let area = maps.import_area(&import.source, &import.name, upload.path().to_owned()).await?;
    Ok((StatusCode::CREATED, Json(area)))
}
