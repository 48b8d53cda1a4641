//! Cameras: list, images and recording.

#![allow(unused_qualifications, reason = "utoipa's query parameters name their type in full")]

use std::sync::Arc;

use axum::Json;
use axum::extract::rejection::QueryRejection;
use axum::extract::{FromRequestParts, Query, State, WebSocketUpgrade};
use axum::http::request::Parts;
use axum::http::{HeaderValue, header};
use axum::response::{IntoResponse, Response};
use serde::Deserialize;
use tokio::time::{Duration, timeout};
use utoipa::IntoParams;
use utoipa_axum::router::OpenApiRouter;
use utoipa_axum::routes;
use vencejo_video::{self as video, Accepts, CameraError, CameraRequest};

use crate::dto::camera::CameraInfo;
use crate::dto::cause::{Cause, LimitKind, ResourceKind};
use crate::extract::{InSession, Name, Operator, Viewer};
use crate::problem::Problem;
use crate::state::{App, now_unix_us};
use crate::{viewer, ws};

/// Time limit for a camera's answer.
const PATIENCE: Duration = Duration::from_secs(10);

pub(super) fn router() -> OpenApiRouter<App> {
    OpenApiRouter::new()
        .routes(routes!(list_cameras))
        .routes(routes!(get_camera))
        .routes(routes!(snapshot, keep_snapshot))
        .routes(routes!(start_recording, stop_recording))
        .routes(routes!(watch))
}

/// Extractor for the camera named in the path.
struct Camera(Arc<video::Camera>);

impl FromRequestParts<App> for Camera {
    type Rejection = Problem;

    async fn from_request_parts(parts: &mut Parts, app: &App) -> Result<Self, Problem> {
        let Name(name) = Name::from_request_parts(parts, app).await?;
        app.video().camera(&name).map(Self).ok_or_else(|| {
            Problem::not_found(ResourceKind::Camera, &name, format!("there is no camera '{name}'"))
                .remedy("GET /api/v1/cameras lists the cameras; `vencejo serve --camera NAME=SOURCE` adds one")
        })
    }
}

fn problem(camera: &video::Camera, error: &CameraError) -> Problem {
    let name = camera.name();
    match error {
        CameraError::Gone => Problem::not_found(ResourceKind::Camera, name, format!("the camera '{name}' is gone")),
        _ => Problem::new(Cause::Camera { name: name.to_owned(), reason: error.to_string() }, error.to_string()),
    }
}

async fn ask(camera: &video::Camera, request: CameraRequest) -> Result<Vec<u8>, Problem> {
    let answer = timeout(PATIENCE, camera.ask(request)).await.unwrap_or(Err(CameraError::Busy));
    answer.map_err(|error| problem(camera, &error))
}

fn info(camera: &video::Camera) -> Json<CameraInfo> {
    Json(CameraInfo::of(camera, now_unix_us()))
}

/// Lists the cameras by name.
#[utoipa::path(get, path = "/cameras", tag = "cameras", responses((status = 200, body = Vec<CameraInfo>), Problem))]
async fn list_cameras(State(app): State<App>, _: Viewer) -> Json<Vec<CameraInfo>> {
    let now_unix_us = now_unix_us();
    Json(app.video().cameras().iter().map(|camera| CameraInfo::of(camera, now_unix_us)).collect())
}

/// A camera.
#[utoipa::path(get, path = "/cameras/{name}", tag = "cameras", params(("name" = String, Path, description = "The camera's name")),
    responses((status = 200, body = CameraInfo), Problem))]
async fn get_camera(_: Viewer, Camera(camera): Camera) -> Json<CameraInfo> {
    info(&camera)
}

/// Takes a still image: the newest one, with time, position, altitudes and attitude of the vehicle, where known, in its
/// EXIF and XMP data.
#[utoipa::path(get, path = "/cameras/{name}/snapshot", tag = "cameras",
    params(("name" = String, Path, description = "The camera's name")),
    responses((status = 200, body = Vec<u8>, content_type = "image/jpeg"), Problem))]
async fn snapshot(_: Viewer, Camera(camera): Camera) -> Result<Response, Problem> {
    let jpeg = ask(&camera, CameraRequest::Snapshot).await?;
    Ok(([(header::CONTENT_TYPE, HeaderValue::from_static("image/jpeg"))], jpeg).into_response())
}

/// Takes a still image as GET does, and also stores it beside the recordings.
#[utoipa::path(post, path = "/cameras/{name}/snapshot", tag = "cameras",
    params(("name" = String, Path, description = "The camera's name")),
    responses((status = 200, body = Vec<u8>, content_type = "image/jpeg"), Problem))]
async fn keep_snapshot(_: Operator, Camera(camera): Camera) -> Result<Response, Problem> {
    let jpeg = ask(&camera, CameraRequest::KeepSnapshot).await?;
    Ok(([(header::CONTENT_TYPE, HeaderValue::from_static("image/jpeg"))], jpeg).into_response())
}

/// Starts recording the camera to a file on the machine to which it is connected. Sends nothing to the vehicle.
#[utoipa::path(post, path = "/cameras/{name}/recording", tag = "cameras",
    params(("name" = String, Path, description = "The camera's name")), responses((status = 200, body = CameraInfo), Problem))]
async fn start_recording(_: Operator, Camera(camera): Camera) -> Result<Json<CameraInfo>, Problem> {
    ask(&camera, CameraRequest::StartRecording).await?;
    Ok(info(&camera))
}

/// Stops the recording.
#[utoipa::path(delete, path = "/cameras/{name}/recording", tag = "cameras",
    params(("name" = String, Path, description = "The camera's name")), responses((status = 200, body = CameraInfo), Problem))]
async fn stop_recording(_: Operator, Camera(camera): Camera) -> Result<Json<CameraInfo>, Problem> {
    ask(&camera, CameraRequest::StopRecording).await?;
    Ok(info(&camera))
}

/// Capabilities of a viewer.
#[derive(Debug, Deserialize, IntoParams)]
#[into_params(parameter_in = Query)]
struct Shows {
    /// `h264` if the viewer can decode it; otherwise, all images are sent as JPEG.
    accept: Option<String>,
}

/// The camera's images, on a WebSocket of their own. Text messages are `CameraMessage`. Binary messages are images: a
/// header of 20 bytes, all numbers little-endian, then the encoded image. Header: version (u8, is 1); codec (u8: 1
/// H.264 byte stream, one access unit, key frames with their parameter sets; 2 JPEG); flags (u8: bit 0 key frame); 0
/// (u8); width, height (u16 each); time of capture (u64, microseconds since 1970); number of the image (u32). A slow
/// viewer misses images and continues at a key frame.
#[utoipa::path(get, path = "/cameras/{name}/stream", tag = "cameras",
    params(Shows, ("name" = String, Path, description = "The camera's name")),
    responses((status = 101, description = "The WebSocket"), Problem))]
async fn watch(
    State(app): State<App>,
    InSession(session): InSession,
    Camera(camera): Camera,
    shows: Result<Query<Shows>, QueryRejection>,
    upgrade: WebSocketUpgrade,
) -> Result<Response, Problem> {
    let Query(shows) = shows?;
    let accepts = Accepts { h264: shows.accept.is_some_and(|accept| accept.split(',').any(|codec| codec == "h264")) };
    if app.video().viewers() >= video::MAX_VIEWERS {
        let detail = "the limit of viewers is reached; close a camera's window";
        return Err(Problem::too_many(LimitKind::Viewers, video::MAX_VIEWERS, detail));
    }
    let Some(alive) = app.alive() else { return Err(Problem::closed()) };
    Ok(ws::bounded(upgrade, viewer::MAX_MESSAGE_BYTES, video::MAX_FRAME_BYTES).on_upgrade(async move |socket| {
        viewer::serve(app, session, camera, accepts, socket).await;
        drop(alive);
    }))
}
