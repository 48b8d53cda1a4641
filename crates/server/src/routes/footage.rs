//! Footage: camera recordings and images on the server's disk.

use std::io;
use std::path::PathBuf;

use axum::Json;
use axum::body::Body;
use axum::extract::{Request, State};
use axum::http::{HeaderValue, header};
use axum::response::{IntoResponse, Response};
use tower_http::services::ServeFile;
use utoipa_axum::router::OpenApiRouter;
use utoipa_axum::routes;
use vencejo_video::footage::{self, Footage, FootageKind};

use crate::dto::Done;
use crate::dto::cause::{Cause, ResourceKind};
use crate::extract::{Name, Operator, Viewer};
use crate::problem::Problem;
use crate::state::App;

pub(super) fn router() -> OpenApiRouter<App> {
    OpenApiRouter::new().routes(routes!(list_footage)).routes(routes!(get_footage, delete_footage))
}

/// Name of the folder's content, for errors about reading it.
const KEPT: &str = "the cameras' recordings";

fn failed(what: &str, error: &io::Error) -> Problem {
    Problem::new(Cause::Recorder { reason: error.to_string() }, format!("{what}: {error}"))
}

/// Runs blocking disk access off the async threads.
pub(super) async fn read<T: Send + 'static>(
    what: &str,
    work: impl FnOnce() -> io::Result<T> + Send + 'static,
) -> Result<T, Problem> {
    let read = tokio::task::spawn_blocking(work).await.map_err(|_| Problem::closed())?;
    read.map_err(|error| failed(what, &error))
}

async fn find(app: &App, name: String) -> Result<(PathBuf, Footage), Problem> {
    let none = Problem::not_found(ResourceKind::Recording, &name, "there is no such recording or picture")
        .remedy("GET /api/v1/footage lists them");
    let Some(folder) = app.video_folder().map(ToOwned::to_owned) else { return Err(none) };
    let hub = app.video().clone();
    read(KEPT, move || footage::find(&folder, &hub, &name)).await?.ok_or(none)
}

/// Lists camera recordings and images on the server's disk, newest first, at most 1000.
#[utoipa::path(get, path = "/footage", tag = "cameras", responses((status = 200, body = Vec<Footage>), Problem))]
async fn list_footage(State(app): State<App>, _: Viewer) -> Result<Json<Vec<Footage>>, Problem> {
    let Some(folder) = app.video_folder().map(ToOwned::to_owned) else { return Ok(Json(Vec::new())) };
    let hub = app.video().clone();
    read(KEPT, move || footage::list(&folder, &hub)).await.map(Json)
}

/// Returns a recording (Matroska) or image (JPEG), or the requested range of it, so that a player can seek. A file that
/// is still being recorded ends where it ended when the request arrived.
#[utoipa::path(get, path = "/footage/{name}", tag = "cameras", params(("name" = String, Path, description = "File name")),
    responses((status = 200, content_type = "video/x-matroska", body = Vec<u8>),
        (status = 206, description = "The requested range"), Problem))]
async fn get_footage(
    State(app): State<App>,
    _: Viewer,
    Name(name): Name,
    request: Request,
) -> Result<Response, Problem> {
    let (path, found) = find(&app, name).await?;
    let kind = match found.kind {
        FootageKind::Video => "video/x-matroska",
        FootageKind::Picture => "image/jpeg",
    };
    served(path, &found.name, kind, request).await
}

/// Serves a file for download under its name, or the requested range of it.
pub(super) async fn served(
    path: PathBuf,
    name: &str,
    kind: &'static str,
    request: Request,
) -> Result<Response, Problem> {
    let (parts, _) = request.into_parts();
    let served = ServeFile::new(path).try_call(Request::from_parts(parts, Body::empty())).await;
    let mut response = served.map_err(|error| failed(name, &error))?.into_response();
    if response.status().is_success() {
        response.headers_mut().insert(header::CONTENT_TYPE, HeaderValue::from_static(kind));
        let attachment = format!("attachment; filename=\"{}\"", name.replace(['"', '\\'], "_"));
        let attachment = HeaderValue::from_str(&attachment).unwrap_or(HeaderValue::from_static("attachment"));
        response.headers_mut().insert(header::CONTENT_DISPOSITION, attachment);
    }
    Ok(response)
}

/// Deletes a recording or image from the server's disk. A file that is being recorded is not deleted.
#[utoipa::path(delete, path = "/footage/{name}", tag = "cameras", params(("name" = String, Path, description = "File name")),
    responses((status = 200, body = Done), Problem))]
async fn delete_footage(State(app): State<App>, _: Operator, Name(name): Name) -> Result<Json<Done>, Problem> {
    let (path, found) = find(&app, name).await?;
    if found.is_current {
        let reason = format!("{} is being recorded", found.name);
        let problem = Problem::new(Cause::Camera { name: found.camera, reason: reason.clone() }, reason);
        return Err(problem.remedy("end the recording first"));
    }
    read(KEPT, move || std::fs::remove_file(path)).await?;
    Ok(Json(Done {}))
}
