//! Replays of recordings: open, control, close.

use std::time::Duration;

use axum::Json;
use axum::extract::State;
use axum::http::StatusCode;
use utoipa_axum::router::OpenApiRouter;
use utoipa_axum::routes;
use vencejo_station::{self as station, MarkKind, ReplayOptions, SPEEDS};

use crate::convert;
use crate::dto::cause::ResourceKind;
use crate::dto::replay::{NewReplay, Replay, ReplayChange, ReplayMark, ReplayMarkKind};
use crate::extract::{Id, Json as Asked, Operator, Viewer};
use crate::problem::Problem;
use crate::state::App;

use super::{history, recordings};

pub(super) fn router() -> OpenApiRouter<App> {
    OpenApiRouter::new()
        .routes(routes!(list_replays, open_replay))
        .routes(routes!(change_replay, close_replay))
        .routes(routes!(list_marks))
}

fn speed_in(speed: Option<f64>) -> Result<Option<f64>, Problem> {
    match speed.filter(|speed| !SPEEDS.contains(speed)) {
        Some(speed) => Err(Problem::out_of_range("speed", speed, *SPEEDS.start(), *SPEEDS.end())),
        None => Ok(speed),
    }
}

fn position_in(position_s: Option<f64>) -> Result<Option<Duration>, Problem> {
    let bad = |position_s: f64| Problem::out_of_range("position_s", position_s, 0.0, f64::from(u32::MAX));
    position_s.map(|position_s| Duration::try_from_secs_f64(position_s).map_err(|_| bad(position_s))).transpose()
}

fn find(app: &App, id: u64) -> Result<station::Replay, Problem> {
    let found = app.station().replays().into_iter().find(|replay| u64::from(replay.id()) == id);
    found.ok_or_else(|| Problem::not_found(ResourceKind::Replay, id, "there is no such replay"))
}

/// Lists the recordings that are being replayed.
#[utoipa::path(get, path = "/replays", tag = "recordings", responses((status = 200, body = Vec<Replay>), Problem))]
async fn list_replays(State(app): State<App>, _: Viewer) -> Json<Vec<Replay>> {
    Json(app.station().replays().iter().map(convert::replay).collect())
}

/// Replays a recording. Its aircraft appear as vehicles of their own, beside the live ones. A recording that is replayed
/// already goes to the given position instead. Reading a recording of 2 GB takes some seconds.
#[utoipa::path(post, path = "/replays", tag = "recordings", request_body = NewReplay,
    responses((status = 201, body = Replay), Problem))]
async fn open_replay(
    State(app): State<App>,
    _: Operator,
    Asked(new): Asked<NewReplay>,
) -> Result<(StatusCode, Json<Replay>), Problem> {
    let speed = speed_in(new.speed)?.unwrap_or(1.0);
    let start = position_in(new.position_s)?.unwrap_or_default();
    let path = match new.place {
        Some(place) => history::find(&app, &place, &new.name).await?,
        None => recordings::find(&app, &new.name).await?.0,
    };
    let replay = app.station().open_replay(&path, ReplayOptions { speed, start, ..ReplayOptions::default() }).await?;
    Ok((StatusCode::CREATED, Json(convert::replay(&replay))))
}

/// Pauses a replay, lets it go on, changes its speed, or goes to another position; answers once it is there.
#[utoipa::path(patch, path = "/replays/{id}", tag = "recordings", request_body = ReplayChange,
    params(("id" = u32, Path, description = "The replay's id")), responses((status = 200, body = Replay), Problem))]
async fn change_replay(
    State(app): State<App>,
    _: Operator,
    Id(id): Id,
    Asked(change): Asked<ReplayChange>,
) -> Result<Json<Replay>, Problem> {
    let (speed, position) = (speed_in(change.speed)?, position_in(change.position_s)?);
    let replay = find(&app, id)?;
    if let Some(speed) = speed {
        replay.set_speed(speed);
    }
    if let Some(position) = position {
        replay.seek(position);
    }
    match change.is_paused {
        Some(true) => replay.pause(),
        Some(false) => replay.play(),
        None => {}
    }
    replay.arrived().await;
    Ok(Json(convert::replay(&replay)))
}

/// Ends a replay; its vehicles disappear.
#[utoipa::path(delete, path = "/replays/{id}", tag = "recordings",
    params(("id" = u32, Path, description = "The replay's id")), responses((status = 204), Problem))]
async fn close_replay(State(app): State<App>, _: Operator, Id(id): Id) -> Result<StatusCode, Problem> {
    let replay = find(&app, id)?;
    app.station().close_replay(replay.id()).await;
    Ok(StatusCode::NO_CONTENT)
}

/// Lists when aircraft of a recording were armed or disarmed, or changed their mode; the first 500. Empty for a history file.
#[utoipa::path(get, path = "/replays/{id}/marks", tag = "recordings",
    params(("id" = u32, Path, description = "The replay's id")), responses((status = 200, body = Vec<ReplayMark>), Problem))]
async fn list_marks(State(app): State<App>, _: Viewer, Id(id): Id) -> Result<Json<Vec<ReplayMark>>, Problem> {
    let replay = find(&app, id)?;
    let marks = replay.info().marks.iter().filter_map(|mark| {
        let (kind, mode) = match &mark.kind {
            MarkKind::Armed => (ReplayMarkKind::Armed, None),
            MarkKind::Disarmed => (ReplayMarkKind::Disarmed, None),
            MarkKind::Mode(mode) => (ReplayMarkKind::Mode, Some(mode.clone())),
        };
        let vehicle = replay.vehicle_of(mark.from)?.number();
        Some(ReplayMark { position_s: mark.at.as_secs_f64(), vehicle, kind, mode })
    });
    Ok(Json(marks.collect()))
}
