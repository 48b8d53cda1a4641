//! Time limits for request bodies: a body must arrive at a reasonable speed.

use std::pin::Pin;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::task::{Context, Poll, ready};
use std::time::Duration;

use axum::body::{Body, Bytes, HttpBody};
use axum::extract::Request;
use axum::http::{HeaderValue, header};
use axum::middleware::Next;
use axum::response::{IntoResponse, Response};
use http_body::{Frame, SizeHint};
use tokio::time::{Instant, Sleep, sleep_until};

use crate::dto::Cause;
use crate::problem::Problem;

/// Time limit for a whole body, without the time that its bytes earn.
const PATIENCE: Duration = Duration::from_secs(10);
/// Bytes that earn a body one more second.
const BYTES_PER_S: u64 = 8 * 1024;
/// Time limit for the next chunk, whatever has been earned: a longer silence means that the client is gone.
const SILENCE: Duration = Duration::from_secs(30);

/// A body with time limits.
struct Timely {
    body: Body,
    came: u64,
    waited: Duration,
    /// Start and deadline of the wait for the next chunk.
    waiting: Option<(Instant, Pin<Box<Sleep>>)>,
    is_late: Arc<AtomicBool>,
}

impl HttpBody for Timely {
    type Data = Bytes;
    type Error = axum::Error;

    fn poll_frame(
        mut self: Pin<&mut Self>,
        context: &mut Context<'_>,
    ) -> Poll<Option<Result<Frame<Bytes>, axum::Error>>> {
        if let Poll::Ready(frame) = Pin::new(&mut self.body).poll_frame(context) {
            if let Some((since, _)) = self.waiting.take() {
                self.waited += since.elapsed();
            }
            if let Some(Ok(frame)) = &frame {
                self.came += frame.data_ref().map_or(0, |data| data.len() as u64);
            }
            return Poll::Ready(frame);
        }
        let allowed = PATIENCE + Duration::from_secs_f64(self.came as f64 / BYTES_PER_S as f64);
        let left = allowed.saturating_sub(self.waited).min(SILENCE);
        let now = Instant::now();
        let (_, until) = self.waiting.get_or_insert_with(|| (now, Box::pin(sleep_until(now + left))));
        ready!(until.as_mut().poll(context));
        self.is_late.store(true, Ordering::Relaxed);
        Poll::Ready(Some(Err(axum::Error::new(std::io::Error::from(std::io::ErrorKind::TimedOut)))))
    }

    fn is_end_stream(&self) -> bool {
        self.body.is_end_stream()
    }

    fn size_hint(&self) -> SizeHint {
        self.body.size_hint()
    }
}

/// Middleware that ends requests whose body does not arrive in time.
pub async fn in_time(request: Request, next: Next) -> Response {
    if request.body().is_end_stream() {
        return next.run(request).await;
    }
    if request.headers().contains_key(header::UPGRADE) {
        // The body would have to be read before the upgrade, and a client that sends half of one would block it.
        return last(Problem::invalid("a request for a WebSocket has no body"));
    }
    let is_late = Arc::new(AtomicBool::new(false));
    let request = request.map(|body| {
        let timely = Timely { body, came: 0, waited: Duration::ZERO, waiting: None, is_late: is_late.clone() };
        Body::new(timely)
    });
    let response = next.run(request).await;
    if !is_late.load(Ordering::Relaxed) {
        return response;
    }
    let detail = format!(
        "the request's body arrived too slowly: the limit is {PATIENCE:?}, plus a second for each {BYTES_PER_S} bytes, and {SILENCE:?} between chunks"
    );
    last(Problem::new(Cause::BodyTooSlow, detail))
}

/// Closes the connection after this answer.
fn last(problem: Problem) -> Response {
    let mut response = problem.into_response();
    response.headers_mut().insert(header::CONNECTION, HeaderValue::from_static("close"));
    response
}
