//! The history of aircraft far away: what is kept on the server's disk, and its files.

use axum::Json;
use axum::extract::{Request, State};
use axum::response::Response;
use utoipa_axum::router::OpenApiRouter;
use utoipa_axum::routes;

use super::footage::{read, served};
use crate::dto::cause::Thing;
use crate::extract::{Name, Place, Viewer};
use crate::history::{self, AircraftHistory};
use crate::problem::Problem;
use crate::state::App;

/// What cannot be read, where a folder cannot.
const KEPT: &str = "the history of aircraft far away";

pub(super) fn router() -> OpenApiRouter<App> {
    OpenApiRouter::new().routes(routes!(list_history)).routes(routes!(get_history_file))
}

/// What is kept of each aircraft of each fleet, far away and on board: its files, and what is missing in them.
#[utoipa::path(get, path = "/history", tag = "recordings", responses((status = 200, body = Vec<AircraftHistory>), Problem))]
async fn list_history(State(app): State<App>, _: Viewer) -> Result<Json<Vec<AircraftHistory>>, Problem> {
    let Some(folder) = app.history_folder().map(ToOwned::to_owned) else { return Ok(Json(Vec::new())) };
    read(KEPT, move || history::list(&folder)).await.map(Json)
}

/// A file of a history (MCAP) as it is on the disk. Parts of it are given to those who ask for a range. One that is being written ends
/// where it was when the request came.
#[utoipa::path(get, path = "/history/{place}/{name}", tag = "recordings",
    params(("place" = String, Path, description = "The fleet, or `_board`"), ("name" = String, Path, description = "Its file")),
    responses((status = 200, content_type = "application/octet-stream", body = Vec<u8>),
        (status = 206, description = "The range that was asked for"), Problem))]
async fn get_history_file(
    State(app): State<App>,
    _: Viewer,
    Place(place): Place,
    Name(name): Name,
    request: Request,
) -> Result<Response, Problem> {
    let none = Problem::not_found(Thing::Recording, &name, "there is no such file of a history")
        .remedy("GET /api/v1/history lists those that are");
    let Some(folder) = app.history_folder().map(ToOwned::to_owned) else { return Err(none) };
    let wanted = name.clone();
    let path = read(KEPT, move || history::find(&folder, &place, &wanted)).await?.ok_or(none)?;
    served(path, &name, "application/octet-stream", request).await
}
