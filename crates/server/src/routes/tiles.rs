//! Map tiles, from the sources' files, caches and services.

use axum::extract::rejection::PathRejection;
use axum::extract::{Path, State};
use axum::http::{HeaderMap, HeaderName, HeaderValue, StatusCode, header};
use axum::response::{IntoResponse, Response};
use utoipa_axum::router::OpenApiRouter;
use utoipa_axum::routes;
use vencejo_maps::Tile;
use vencejo_maps::grid::TileId;

use crate::dto::cause::ResourceKind;
use crate::extract::Viewer;
use crate::problem::Problem;
use crate::state::App;

pub(super) fn router() -> OpenApiRouter<App> {
    OpenApiRouter::new().routes(routes!(tile))
}

/// Returns a tile of a source's grid: level, column from the left, row from the top. `Vencejo-Tile` names its origin:
/// `hit`, `stale` (from the cache because the source fails), `fetched`, `revalidated` or `file`.
#[utoipa::path(get, path = "/tiles/{source}/{z}/{x}/{y}", tag = "maps",
    params(("source" = String, Path, description = "Id of a source"), ("z" = u8, Path, description = "Level of its grid"),
           ("x" = u32, Path, description = "Column"), ("y" = u32, Path, description = "Row")),
    responses((status = 200, body = Vec<u8>, content_type = "image/*"), (status = 304), Problem))]
async fn tile(
    State(app): State<App>,
    _: Viewer,
    path: Result<Path<(String, String, String, String)>, PathRejection>,
    headers: HeaderMap,
) -> Result<Response, Problem> {
    let Path((source, level, column, row)) = path.map_err(|error| Problem::invalid(error.body_text()))?;
    let numbers = (level.parse(), column.parse(), row.parse());
    let (Ok(level), Ok(column), Ok(row)) = numbers else {
        return Err(Problem::not_found(ResourceKind::Path, format!("{level}/{column}/{row}"), "tiles are numbered"));
    };
    let tile = app.maps()?.tile(&source, TileId { level, column, row }).await?;
    Ok(picture(tile, &headers))
}

/// Answer with an image, or "not modified" when the browser has it already.
pub(super) fn picture(tile: Tile, headers: &HeaderMap) -> Response {
    let tag = format!("\"{:016x}\"", tile.hash);
    let known = headers.get(header::IF_NONE_MATCH).and_then(|tags| tags.to_str().ok());
    let has_it = known.is_some_and(|tags| tags.split(',').any(|known| known.trim().trim_start_matches("W/") == tag));
    let text = |text: String| HeaderValue::from_str(&text).expect("invariant: plain characters are a header");
    let headers = [
        (header::CONTENT_TYPE, HeaderValue::from_static(tile.picture.mime())),
        (header::CACHE_CONTROL, text(format!("private, max-age={}", tile.max_age_s))),
        (header::ETAG, text(tag)),
        (HeaderName::from_static("vencejo-tile"), HeaderValue::from_static(tile.origin.name())),
    ];
    if has_it { (StatusCode::NOT_MODIFIED, headers).into_response() } else { (headers, tile.data).into_response() }
}
