//! The station's flight recorder, its recordings, and its heartbeat.

use std::fs::File;
use std::io::{self, Read};
use std::path::{Path, PathBuf};
use std::pin::Pin;
use std::task::{Context, Poll};
use std::time::{Duration, UNIX_EPOCH};

use axum::Json;
use axum::body::{Body, Bytes};
use axum::extract::State;
use axum::http::{HeaderValue, header};
use axum::response::{IntoResponse, Response};
use futures_core::Stream;
use tokio::io::AsyncReadExt;
use tokio::sync::mpsc;
use utoipa_axum::router::OpenApiRouter;
use utoipa_axum::routes;
use vencejo_link::RecorderState;
use vencejo_station::summarize_recording;

use crate::dto::Done;
use crate::dto::cause::{Cause, ResourceKind};
use crate::dto::recording::{
    KeepRecording, RecordedEvent, Recorder, Recording, RecordingSummary, Sender, SetHeartbeat,
};
use crate::extract::{Json as Asked, Name, Operator, Pilot, Viewer};
use crate::problem::Problem;
use crate::state::App;
use crate::turns::in_turn;

/// Size of a chunk read ahead of the client, and number of such chunks.
const CHUNK: usize = 64 * 1024;
const AHEAD: usize = 4;
/// Limit of listed recordings; the newest are listed.
const MAX_LISTED: usize = 1000;
/// The year 2200: stamps beyond are damaged.
const LATEST_UNIX_US: u64 = 7_258_118_400_000_000;
const EXTENSION: &str = "tlog";

pub(super) fn router() -> OpenApiRouter<App> {
    OpenApiRouter::new()
        .routes(routes!(recorder))
        .routes(routes!(list_recordings))
        .routes(routes!(get_recording))
        .routes(routes!(summarize))
        .routes(routes!(keep))
        .routes(routes!(set_heartbeat))
}

/// Returns the state of the flight recorder; null when it is off.
#[utoipa::path(get, path = "/recorder", tag = "recordings", responses((status = 200, body = Option<Recorder>), Problem))]
async fn recorder(State(app): State<App>, _: Viewer) -> Json<Option<Recorder>> {
    Json(app.station().recorder().map(|(_, status)| {
        let problem = status.state.problem();
        let file = match status.state {
            RecorderState::Recording { file } => Some(file),
            _ => None,
        };
        let is_recording = file.is_some();
        Recorder { is_recording, file, frames: status.frames, bytes: status.bytes, dropped: status.dropped, problem }
    }))
}

fn failed(error: &io::Error) -> Problem {
    Problem::new(Cause::Recorder { reason: error.to_string() }, format!("the recordings cannot be read: {error}"))
}

/// Recordings in the recorder's folder, newest first. Empty while the recorder is off.
async fn listed(app: &App) -> Result<(PathBuf, Vec<Recording>), Problem> {
    let Some((folder, status)) = app.station().recorder() else { return Ok((PathBuf::new(), Vec::new())) };
    let current = match status.state {
        RecorderState::Recording { file } => Some(file),
        _ => None,
    };
    let read = move || -> io::Result<(PathBuf, Vec<Recording>)> {
        let mut found = Vec::new();
        let entries = match std::fs::read_dir(&folder) {
            Ok(entries) => entries,
            // The recorder creates the folder with its first file.
            Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok((folder, found)),
            Err(error) => return Err(error),
        };
        for entry in entries {
            let entry = entry?;
            // The recorder may have just deleted it.
            let Ok(metadata) = entry.metadata() else { continue };
            let Ok(name) = entry.file_name().into_string() else { continue };
            if !metadata.is_file() || Path::new(&name).extension().is_none_or(|kind| kind != EXTENSION) {
                continue;
            }
            let age = metadata.modified().ok().and_then(|at| at.duration_since(UNIX_EPOCH).ok());
            let is_current = current.as_ref() == Some(&name);
            let modified_unix_s = age.as_ref().map(Duration::as_secs_f64);
            let is_kept = vencejo_link::is_kept_recording(&folder, &name);
            let start_unix_s = start_of(&entry.path());
            found.push(Recording { name, bytes: metadata.len(), modified_unix_s, start_unix_s, is_current, is_kept });
        }
        found.sort_by(|a, b| b.modified_unix_s.partial_cmp(&a.modified_unix_s).unwrap_or(std::cmp::Ordering::Equal));
        found.truncate(MAX_LISTED);
        Ok((folder, found))
    };
    let read = tokio::task::spawn_blocking(read).await.map_err(|_| Problem::closed())?;
    read.map_err(|error| failed(&error))
}

/// Time of the first frame, seconds since 1970; `None` when there is none, or its stamp is damaged.
fn start_of(path: &Path) -> Option<f64> {
    let mut stamp = [0; 8];
    File::open(path).and_then(|mut file| file.read_exact(&mut stamp)).ok()?;
    let unix_us = u64::from_be_bytes(stamp);
    (1..=LATEST_UNIX_US).contains(&unix_us).then(|| unix_us as f64 / 1e6)
}

/// Lists the recordings on the server's disk, newest first; empty when this session is not recorded.
#[utoipa::path(get, path = "/recordings", tag = "recordings", responses((status = 200, body = Vec<Recording>), Problem))]
async fn list_recordings(State(app): State<App>, _: Viewer) -> Result<Json<Vec<Recording>>, Problem> {
    listed(&app).await.map(|(_, recordings)| Json(recordings))
}

/// Path of a listed recording. A client's name is only compared with the listed ones, never used as a path.
pub(super) async fn find(app: &App, name: &str) -> Result<(PathBuf, Recording), Problem> {
    let (folder, recordings) = listed(app).await?;
    let found = recordings.into_iter().find(|recording| recording.name == name);
    let found = found.ok_or_else(|| Problem::not_found(ResourceKind::Recording, name, "there is no such recording"))?;
    Ok((folder.join(&found.name), found))
}

/// Body stream of a file, read no faster than the client takes it.
struct Chunks(mpsc::Receiver<io::Result<Bytes>>);

impl Stream for Chunks {
    type Item = io::Result<Bytes>;

    fn poll_next(mut self: Pin<&mut Self>, context: &mut Context<'_>) -> Poll<Option<Self::Item>> {
        self.0.poll_recv(context)
    }
}

/// Returns a recording: before each frame, 8 bytes of big-endian microseconds since 1970. A file that is still being
/// recorded ends where it ended when the request arrived.
#[utoipa::path(get, path = "/recordings/{name}", tag = "recordings", params(("name" = String, Path, description = "File name")),
    responses((status = 200, content_type = "application/octet-stream", body = Vec<u8>), Problem))]
async fn get_recording(State(app): State<App>, _: Viewer, Name(name): Name) -> Result<Response, Problem> {
    let (path, recording) = find(&app, &name).await?;
    let file = tokio::fs::File::open(&path).await.map_err(|error| failed(&error))?;
    let (sender, receiver) = mpsc::channel(AHEAD);
    let Some(alive) = app.alive() else { return Err(Problem::closed()) };
    let mut closing = app.closing();
    let mut file = file.take(recording.bytes);
    tokio::spawn(async move {
        let send = async {
            loop {
                let mut chunk = Vec::with_capacity(CHUNK);
                let read = (&mut file).take(CHUNK as u64).read_to_end(&mut chunk).await;
                let is_over = !matches!(read, Ok(count) if count > 0);
                let chunk = read.map(|_| Bytes::from(chunk));
                let is_empty = matches!(&chunk, Ok(chunk) if chunk.is_empty());
                if is_empty || sender.send(chunk).await.is_err() || is_over {
                    return;
                }
            }
        };
        tokio::select! {
            () = send => {}
            () = crate::state::closed(&mut closing) => {}
        }
        drop(alive);
    });
    let attachment = format!("attachment; filename=\"{}\"", name.replace(['"', '\\'], "_"));
    let headers = [
        (header::CONTENT_TYPE, HeaderValue::from_static("application/octet-stream")),
        (header::CONTENT_LENGTH, HeaderValue::from(recording.bytes)),
        (
            header::CONTENT_DISPOSITION,
            HeaderValue::from_str(&attachment).unwrap_or_else(|_| HeaderValue::from_static("attachment")),
        ),
    ];
    Ok((headers, Body::from_stream(Chunks(receiver))).into_response())
}

/// Protects a recording from being deleted to make room for new ones, or ends the protection.
#[utoipa::path(put, path = "/recordings/{name}/keep", tag = "recordings", request_body = KeepRecording,
    params(("name" = String, Path, description = "File name")), responses((status = 200, body = Done), Problem))]
async fn keep(
    State(app): State<App>,
    _: Operator,
    Name(name): Name,
    Asked(KeepRecording { is_kept }): Asked<KeepRecording>,
) -> Result<Json<Done>, Problem> {
    let (path, _) = find(&app, &name).await?;
    let keep = move || {
        let folder = path.parent().unwrap_or_else(|| Path::new("."));
        vencejo_link::keep_recording(folder, &name, is_kept).map_err(|error| match error.kind() {
            io::ErrorKind::NotFound => Problem::not_found(ResourceKind::Recording, &name, "there is no such recording"),
            _ => failed(&error),
        })
    };
    tokio::task::spawn_blocking(keep).await.map_err(|_| Problem::closed())??;
    Ok(Json(Done {}))
}

/// Summarizes a recording: its senders, its messages, and the events of its vehicles.
#[utoipa::path(get, path = "/recordings/{name}/summary", tag = "recordings",
    params(("name" = String, Path, description = "File name")), responses((status = 200, body = RecordingSummary), Problem))]
async fn summarize(State(app): State<App>, _: Viewer, Name(name): Name) -> Result<Json<RecordingSummary>, Problem> {
    let (path, _) = find(&app, &name).await?;
    let summarize = move || File::open(path).and_then(summarize_recording).map_err(|error| failed(&error));
    let summary = in_turn(summarize).await?;
    Ok(Json(RecordingSummary {
        frames: summary.frames,
        skipped_bytes: summary.skipped_bytes,
        start_unix_s: summary.start_unix_us.map(|start_us| start_us as f64 / 1e6),
        duration_s: summary.duration.as_secs_f64(),
        senders: summary
            .senders
            .into_iter()
            .map(|(address, sender)| Sender {
                system_id: address.system.0,
                component_id: address.component.0,
                frames: sender.frames,
                mav_type: sender.kind.map(|(mav_type, _)| mav_type),
                autopilot: sender.kind.map(|(_, autopilot)| autopilot),
            })
            .collect(),
        messages: summary.messages,
        events: summary
            .events
            .into_iter()
            .map(|event| RecordedEvent {
                time_s: event.at.as_secs_f64(),
                system_id: event.system.0,
                kind: event.kind.to_owned(),
                text: event.text,
            })
            .collect(),
        events_left_out: summary.events_left_out,
    }))
}

/// Starts or stops the station's heartbeat, on which the vehicles' ground-station failsafe depends. On board a vehicle, it
/// is sent while an operator's page or program has its WebSocket open, and 5 s longer.
#[utoipa::path(put, path = "/heartbeat", tag = "station", request_body = SetHeartbeat,
    responses((status = 200, body = Done), Problem))]
async fn set_heartbeat(
    State(app): State<App>,
    pilot: Pilot,
    Asked(SetHeartbeat { enabled }): Asked<SetHeartbeat>,
) -> Result<Json<Done>, Problem> {
    pilot.still_in_control(&app)?;
    if app.is_on_board() {
        let detail = "on board a vehicle, the heartbeat is sent while an operator's WebSocket is open, and 5 s longer";
        return Err(Problem::new(Cause::HeartbeatFollowsOperator, detail));
    }
    app.station().set_heartbeat(enabled);
    Ok(Json(Done {}))
}
