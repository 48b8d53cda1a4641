//! Flight history of remote aircraft: files on the server's disk.

use std::path::PathBuf;

use axum::Json;
use axum::extract::{Request, State};
use axum::response::Response;
use utoipa_axum::router::OpenApiRouter;
use utoipa_axum::routes;

use super::footage::{read, served};
use crate::dto::cause::ResourceKind;
use crate::extract::{Name, Place, Viewer};
use crate::history::{self, AircraftHistory};
use crate::problem::Problem;
use crate::state::App;

/// Name of the folder's content, for errors about reading it.
const KEPT: &str = "the history of remote aircraft";

pub(super) fn router() -> OpenApiRouter<App> {
    OpenApiRouter::new().routes(routes!(list_history)).routes(routes!(get_history_file))
}

/// Lists the stored history of each aircraft of each fleet, remote or on board: its files, and their gaps.
#[utoipa::path(get, path = "/history", tag = "recordings", responses((status = 200, body = Vec<AircraftHistory>), Problem))]
async fn list_history(State(app): State<App>, _: Viewer) -> Result<Json<Vec<AircraftHistory>>, Problem> {
    let Some(folder) = app.history_folder().map(ToOwned::to_owned) else { return Ok(Json(Vec::new())) };
    read(KEPT, move || history::list(&folder)).await.map(Json)
}

/// Returns a history file (MCAP), or the requested range of it. A file that is still being written ends where it ended
/// when the request arrived.
#[utoipa::path(get, path = "/history/{place}/{name}", tag = "recordings",
    params(("place" = String, Path, description = "The fleet, or `_board`"), ("name" = String, Path, description = "File name")),
    responses((status = 200, content_type = "application/octet-stream", body = Vec<u8>),
        (status = 206, description = "The requested range"), Problem))]
async fn get_history_file(
    State(app): State<App>,
    _: Viewer,
    Place(place): Place,
    Name(name): Name,
    request: Request,
) -> Result<Response, Problem> {
    served(find(&app, &place, &name).await?, &name, "application/octet-stream", request).await
}

/// Path of a history file. A client's names are only compared with those of existing files, never used as a path.
pub(super) async fn find(app: &App, place: &str, name: &str) -> Result<PathBuf, Problem> {
    let none = Problem::not_found(ResourceKind::Recording, name, "there is no such file of a history")
        .remedy("GET /api/v1/history lists them");
    let Some(folder) = app.history_folder().map(ToOwned::to_owned) else { return Err(none) };
    let (place, wanted) = (place.to_owned(), name.to_owned());
    read(KEPT, move || history::find(&folder, &place, &wanted)).await?.ok_or(none)
}
