//! WebSocket of a camera viewer, separate so that large images never delay telemetry: images as binary messages; the
//! camera's state and the server's time as text.

use std::sync::Arc;

use axum::extract::ws::{CloseFrame, Message, Utf8Bytes, WebSocket, close_code};
use tokio::time::{Duration, MissedTickBehavior, interval, timeout};

use vencejo_video::{Accepts, Camera, Outgoing, ViewerQueue};

use crate::dto::camera::{CameraInfo, CameraMessage};
use crate::sessions::SessionId;
use crate::state::{App, closed, now_unix_us};

/// Largest message of a viewer, bytes: viewers have nothing to send.
pub const MAX_MESSAGE_BYTES: usize = 1024;
/// Time limit for sending one image; after it, the connection counts as dead.
const SEND_TIMEOUT: Duration = Duration::from_secs(10);
/// Interval of the camera's state, the time, and a ping.
const TICK: Duration = Duration::from_secs(1);
/// Ticks without a sign of life after which a viewer counts as gone.
const MAX_SILENT_TICKS: u32 = 6;

/// Why a stream ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum End {
    /// The viewer disconnected, or does not answer.
    Gone,
    /// The session has ended.
    NoSession,
    /// The camera was removed.
    CameraGone,
    /// The server is being closed.
    Closing,
}

impl End {
    fn frame(self) -> Option<CloseFrame> {
        let (code, reason) = match self {
            Self::Gone => return None,
            Self::NoSession => (close_code::POLICY, "the session has ended"),
            Self::CameraGone => (close_code::NORMAL, "the camera was removed"),
            Self::Closing => (close_code::AWAY, "the server is being closed"),
        };
        Some(CloseFrame { code, reason: Utf8Bytes::from_static(reason) })
    }
}

/// Serves one viewer until it disconnects, the camera is removed, or the server is closed.
pub async fn serve(app: App, session: SessionId, camera: Arc<Camera>, accepts: Accepts, mut socket: WebSocket) {
    let queue = camera.watch(accepts);
    let mut closing = app.closing();
    // Also while an image is being sent, which takes long on a slow connection.
    let end = tokio::select! {
        biased;
        () = closed(&mut closing) => End::Closing,
        () = over(&app, session) => End::NoSession,
        end = run(&camera, &queue, &mut socket) => end.unwrap_or_else(|end| end),
    };
    tracing::debug!(%session, camera = camera.name(), dropped = queue.dropped(), ?end, "a viewer disconnected");
    if let Some(frame) = end.frame() {
        // A client that does not read misses the reason, too.
        let _ = timeout(Duration::from_secs(1), socket.send(Message::Close(Some(frame)))).await;
    }
}

/// Waits until a session has ended.
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
        // One image per iteration: on a slow connection the next one is always waiting already.
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

/// Next message to send. Cancellation safe.
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
