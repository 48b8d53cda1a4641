//! The WebSocket of one camera's viewer, so that a big picture never stands before telemetry: pictures as binary messages, and as
//! text the camera's state and the server's time.

use std::sync::Arc;

use axum::extract::ws::{CloseFrame, Message, Utf8Bytes, WebSocket, close_code};
use tokio::time::{Duration, MissedTickBehavior, interval, timeout};

use vencejo_video::{Accepts, Camera, Outgoing, ViewerQueue};

use crate::dto::camera::{CameraInfo, CameraMessage};
use crate::sessions::SessionId;
use crate::state::{App, closed, now_unix_us};

/// Bytes of a viewer's message at most: it has nothing to say.
pub const MAX_MESSAGE_BYTES: usize = 1024;
/// How long one picture may take to leave. Longer, and the connection is taken for dead.
const SEND_TIMEOUT: Duration = Duration::from_secs(10);
/// How often the viewer hears how the camera is, is told the time, and is asked whether it is there.
const TICK: Duration = Duration::from_secs(1);
/// Ticks without a sign of the viewer after which it is taken for gone.
const MAX_SILENT_TICKS: u32 = 6;

/// Why a stream ends.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum End {
    /// The viewer went, or does not answer any more.
    Gone,
    /// The session is not known any more.
    NoSession,
    /// The camera is not there any more.
    CameraGone,
    /// The server is being closed.
    Closing,
}

impl End {
    fn frame(self) -> Option<CloseFrame> {
        let (code, reason) = match self {
            Self::Gone => return None,
            Self::NoSession => (close_code::POLICY, "the session is over"),
            Self::CameraGone => (close_code::NORMAL, "the camera is gone"),
            Self::Closing => (close_code::AWAY, "the server is being closed"),
        };
        Some(CloseFrame { code, reason: Utf8Bytes::from_static(reason) })
    }
}

/// Serves one viewer until it goes, the camera does, or the server is closed.
pub async fn serve(app: App, session: SessionId, camera: Arc<Camera>, accepts: Accepts, mut socket: WebSocket) {
    let queue = camera.watch(accepts);
    let mut closing = app.closing();
    // Also while a picture leaves, which takes long on a thin line.
    let end = tokio::select! {
        biased;
        () = closed(&mut closing) => End::Closing,
        () = over(&app, session) => End::NoSession,
        end = run(&camera, &queue, &mut socket) => end.unwrap_or_else(|end| end),
    };
    tracing::debug!(%session, camera = camera.name(), dropped = queue.dropped(), ?end, "a viewer went");
    if let Some(frame) = end.frame() {
        // Whoever does not read does not hear why either.
        let _ = timeout(Duration::from_secs(1), socket.send(Message::Close(Some(frame)))).await;
    }
}

/// Waits until a session is not known any more.
async fn over(app: &App, session: SessionId) {
    let mut ticks = interval(TICK);
    loop {
        ticks.tick().await;
        if app.sessions().info(session).is_none() {
            return;
        }
    }
}

async fn run(camera: &Camera, queue: &ViewerQueue, socket: &mut WebSocket) -> Result<End, End> {
    let mut ticks = interval(TICK);
    ticks.set_missed_tick_behavior(MissedTickBehavior::Delay);
    let mut silent_ticks = 0;
    loop {
        // One picture a turn: on a thin line the next one waits already, always.
        tokio::select! {
            biased;
            _ = ticks.tick() => {
                silent_ticks += 1;
                if silent_ticks > MAX_SILENT_TICKS {
                    return Ok(End::Gone);
                }
                send(socket, Message::Text(clock_text())).await?;
                send(socket, Message::Text(camera_text(camera))).await?;
                send(socket, Message::Ping(Vec::new().into())).await?;
            }
            message = socket.recv() => match message {
                Some(Ok(Message::Close(_)) | Err(_)) | None => return Ok(End::Gone),
                Some(Ok(_)) => silent_ticks = 0,
            },
            outgoing = next(queue) => send(socket, match outgoing {
                Outgoing::Status => Message::Text(camera_text(camera)),
                Outgoing::Picture(bytes) => Message::Binary(bytes),
                Outgoing::End => return Ok(End::CameraGone),
            }).await?,
        }
    }
}

/// The next thing to send. Who drops this loses nothing.
async fn next(queue: &ViewerQueue) -> Outgoing {
    loop {
        match queue.take() {
            Some(outgoing) => return outgoing,
            None => queue.wait().await,
        }
    }
}

async fn send(socket: &mut WebSocket, message: Message) -> Result<(), End> {
    match timeout(SEND_TIMEOUT, socket.send(message)).await {
        Ok(Ok(())) => Ok(()),
        Ok(Err(_)) | Err(_) => Err(End::Gone),
    }
}

fn clock_text() -> Utf8Bytes {
    text(&CameraMessage::Clock { unix_us: now_unix_us() })
}

fn camera_text(camera: &Camera) -> Utf8Bytes {
    text(&CameraMessage::Camera(CameraInfo::of(camera, now_unix_us())))
}

fn text(message: &CameraMessage) -> Utf8Bytes {
    serde_json::to_string(message).expect("invariant: the API's types are JSON").into()
}
