//! Map sources: list, health, configuration, and files for them.

#![allow(unused_qualifications, reason = "utoipa's query parameters name their type in full")]

use axum::Json;
use axum::body::Body;
use axum::extract::rejection::QueryRejection;
use axum::extract::{DefaultBodyLimit, Query, State};
use axum::http::{HeaderMap, StatusCode};
use axum::response::Response;
use serde::Deserialize;
use utoipa::IntoParams;
use utoipa_axum::router::OpenApiRouter;
use utoipa_axum::routes;
use vencejo_maps::capabilities::Capabilities;
use vencejo_maps::geo::Bounds;
use vencejo_maps::kind::KindInfo;
use vencejo_maps::presets::Preset;
use vencejo_maps::settings::SourceSettings;
use vencejo_maps::uploads::MAX_FILE_BYTES;
use vencejo_maps::{MapConfiguration, MapError, MapSource, MapSources, SourceState};

use super::tiles::picture;
use crate::dto::maps::{CapabilitiesRequest, MapAttributions, MapFileInfo, MapFileTaken, MapOrder};
use crate::extract::{Json as JsonBody, Operator, Text, Viewer, ViewerRole};
use crate::problem::Problem;
use crate::state::App;

pub(super) fn router() -> OpenApiRouter<App> {
    OpenApiRouter::new()
        .routes(routes!(list_map_sources))
        .routes(routes!(get_map_config))
        .routes(routes!(put_map_source, delete_map_source))
        .routes(routes!(clear_map_cache))
        .routes(routes!(check_map_source))
        .routes(routes!(get_map_image))
        .routes(routes!(get_map_attribution))
        .routes(routes!(order_map_sources))
        .routes(routes!(list_map_presets))
        .routes(routes!(list_map_kinds))
        .routes(routes!(ask_map_capabilities))
        .routes(routes!(list_map_files))
}

/// Routes that accept whole files.
pub(super) fn file_router() -> OpenApiRouter<App> {
    OpenApiRouter::new().routes(routes!(take_map_file)).layer(DefaultBodyLimit::disable())
}

/// Lists the map sources in drawing order, with their grids and their health. The configuration file is reloaded if it
/// has been edited.
#[utoipa::path(get, path = "/maps/sources", tag = "maps", responses((status = 200, body = MapSources), Problem))]
async fn list_map_sources(State(app): State<App>, ViewerRole(role): ViewerRole) -> Result<Json<MapSources>, Problem> {
    let is_editor = role == crate::dto::Role::Operator;
    Ok(Json(app.maps()?.list(is_editor).await?))
}

/// Returns all settings of the configuration file, without keys.
#[utoipa::path(get, path = "/maps/config", tag = "maps", responses((status = 200, body = MapConfiguration), Problem))]
async fn get_map_config(State(app): State<App>, _: Operator) -> Result<Json<MapConfiguration>, Problem> {
    Ok(Json(app.maps()?.configuration().await?))
}

/// Creates a source, or replaces the one with that id. Comments in the file are kept. An absent key keeps the stored
/// one; an empty key removes it.
#[utoipa::path(put, path = "/maps/sources/{id}", tag = "maps", params(("id" = String, Path, description = "Id of the source")),
    request_body = SourceSettings, responses((status = 200, body = MapSource), Problem))]
async fn put_map_source(
    State(app): State<App>,
    _: Operator,
    Text(id): Text,
    JsonBody(settings): JsonBody<SourceSettings>,
) -> Result<Json<MapSource>, Problem> {
    if settings.id != id {
        return Err(Problem::invalid(format!(
            "id: the settings are those of '{}', but the path says '{id}'",
            settings.id
        )));
    }
    Ok(Json(app.maps()?.put(settings).await?))
}

#[derive(Debug, Deserialize, IntoParams)]
#[into_params(parameter_in = Query)]
struct Removal {
    /// Whether to delete everything cached of it, including offline areas.
    #[serde(default)]
    cache: bool,
}

/// Removes a source.
#[utoipa::path(delete, path = "/maps/sources/{id}", tag = "maps", params(("id" = String, Path, description = "Id of the source"), Removal),
    responses((status = 204), Problem))]
async fn delete_map_source(
    State(app): State<App>,
    _: Operator,
    Text(id): Text,
    removal: Result<Query<Removal>, QueryRejection>,
) -> Result<StatusCode, Problem> {
    let Query(removal) = removal?;
    app.maps()?.remove(&id, removal.cache).await?;
    Ok(StatusCode::NO_CONTENT)
}

/// Clears a source's cache, except for its offline areas.
#[utoipa::path(delete, path = "/maps/sources/{id}/cache", tag = "maps", params(("id" = String, Path, description = "Id of the source")),
    responses((status = 204), Problem))]
async fn clear_map_cache(State(app): State<App>, _: Operator, Text(id): Text) -> Result<StatusCode, Problem> {
    app.maps()?.clear_cache(&id).await?;
    Ok(StatusCode::NO_CONTENT)
}

/// Requests one tile from a source, bypassing its cache, and returns the source's health.
#[utoipa::path(post, path = "/maps/sources/{id}/check", tag = "maps", params(("id" = String, Path, description = "Id of the source")),
    responses((status = 200, body = SourceState), Problem))]
async fn check_map_source(State(app): State<App>, _: Operator, Text(id): Text) -> Result<Json<SourceState>, Problem> {
    Ok(Json(app.maps()?.check(&id).await?))
}

/// Returns the image file of a source of kind `image`.
#[utoipa::path(get, path = "/maps/sources/{id}/image", tag = "maps", params(("id" = String, Path, description = "Id of the source")),
    responses((status = 200, body = Vec<u8>, content_type = "image/*"), (status = 304), Problem))]
async fn get_map_image(
    State(app): State<App>,
    _: Viewer,
    Text(id): Text,
    headers: HeaderMap,
) -> Result<Response, Problem> {
    Ok(picture(app.maps()?.image(&id).await?, &headers))
}

#[derive(Debug, Deserialize, IntoParams)]
#[into_params(parameter_in = Query)]
struct View {
    /// Left edge.
    west_deg: f64,
    /// Lower edge.
    south_deg: f64,
    /// Right edge.
    east_deg: f64,
    /// Upper edge.
    north_deg: f64,
    /// Zoom level of Web Mercator.
    zoom: u8,
}

/// Attributions for a view of a source; most sources have the same ones everywhere.
#[utoipa::path(get, path = "/maps/sources/{id}/attribution", tag = "maps",
    params(("id" = String, Path, description = "Id of the source"), View), responses((status = 200, body = MapAttributions), Problem))]
async fn get_map_attribution(
    State(app): State<App>,
    _: Viewer,
    Text(id): Text,
    view: Result<Query<View>, QueryRejection>,
) -> Result<Json<MapAttributions>, Problem> {
    let Query(View { west_deg, south_deg, east_deg, north_deg, zoom }) = view?;
    let bounds = Bounds { west_deg, south_deg, east_deg, north_deg };
    let (attribution, max_zoom) = app.maps()?.attribution(&id, &bounds, zoom).await?;
    Ok(Json(MapAttributions { attribution, max_zoom }))
}

/// Sets the drawing order.
#[utoipa::path(put, path = "/maps/order", tag = "maps", request_body = MapOrder,
    responses((status = 200, body = MapSources), Problem))]
async fn order_map_sources(
    State(app): State<App>,
    _: Operator,
    JsonBody(order): JsonBody<MapOrder>,
) -> Result<Json<MapSources>, Problem> {
    let maps = app.maps()?;
    maps.set_order(&order.ids).await?;
    Ok(Json(maps.list(true).await?))
}

/// Lists well-known sources with their terms of use.
#[utoipa::path(get, path = "/maps/presets", tag = "maps", responses((status = 200, body = Vec<Preset>), Problem))]
async fn list_map_presets(_: Viewer) -> Json<Vec<Preset>> {
    Json(vencejo_maps::presets::presets())
}

/// Lists the kinds of sources: their settings, possible roles, and accepted files.
#[utoipa::path(get, path = "/maps/kinds", tag = "maps", responses((status = 200, body = Vec<KindInfo>), Problem))]
async fn list_map_kinds(_: Viewer) -> Json<Vec<KindInfo>> {
    Json(vencejo_maps::kinds::infos())
}

/// Returns the capabilities of a WMS or WMTS, which need not be configured as a source.
#[utoipa::path(post, path = "/maps/capabilities", tag = "maps", request_body = CapabilitiesRequest,
    responses((status = 200, body = Capabilities), Problem))]
async fn ask_map_capabilities(
    State(app): State<App>,
    _: Operator,
    JsonBody(asked): JsonBody<CapabilitiesRequest>,
) -> Result<Json<Capabilities>, Problem> {
    let CapabilitiesRequest { kind, url, key, local_network } = asked;
    Ok(Json(app.maps()?.capabilities(kind, &url, key.as_deref(), local_network).await?))
}

/// Lists the files in the maps folder.
#[utoipa::path(get, path = "/maps/files", tag = "maps", responses((status = 200, body = Vec<MapFileInfo>), Problem))]
async fn list_map_files(State(app): State<App>, _: Operator) -> Result<Json<Vec<MapFileInfo>>, Problem> {
    let files = app.maps()?.files().await?;
    let info = |(path, bytes, kind)| MapFileInfo { path, bytes, kind };
    Ok(Json(files.into_iter().map(info).collect()))
}

#[derive(Debug, Deserialize, IntoParams)]
#[into_params(parameter_in = Query)]
struct NewFile {
    /// File name; its extension determines the type.
    name: String,
}

/// Uploads a file to the maps folder; its name must have an extension that `GET /maps/kinds` lists. The body is the
/// file, at most 8 GiB. The answer proposes settings; the source exists only once they are sent back.
#[utoipa::path(post, path = "/maps/files", tag = "maps", params(NewFile),
    request_body(content = Vec<u8>, content_type = "application/octet-stream"),
    responses((status = 201, body = MapFileTaken), Problem))]
async fn take_map_file(
    State(app): State<App>,
    _: Operator,
    file: Result<Query<NewFile>, QueryRejection>,
    body: Body,
) -> Result<(StatusCode, Json<MapFileTaken>), Problem> {
    let (maps, Query(file)) = (app.maps()?, file?);
    let mut upload = maps.begin_upload(&file.name).await?;
    super::streams::take(body, &mut upload, MAX_FILE_BYTES).await?;
    let (path, bytes, settings) = maps.end_upload(upload).await?;
    Ok((StatusCode::CREATED, Json(MapFileTaken { path, bytes, settings })))
}

impl From<MapError> for Problem {
    fn from(error: MapError) -> Self {
        crate::problem::from_maps(&error)
    }
}
