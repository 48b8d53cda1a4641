//! A request in progress; its connection is not closed for another one until the answer has been sent.

use std::pin::Pin;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::task::{Context, Poll};

use axum::body::{Body, Bytes, HttpBody};
use axum::http::StatusCode;
use axum::response::Response;
use http_body::{Frame, SizeHint};

use super::limits::Connection;

/// Number of answers that have ended, over all connections.
static ENDS: AtomicU64 = AtomicU64::new(1);

impl Connection {
    /// Registers a complete request. `None` if the connection has already been given up for another; the request is
    /// then ignored.
    pub fn asked(self: &Arc<Self>) -> Option<Answering> {
        self.has_asked.store(true, Ordering::Relaxed);
        // ENDED marks a connection that accepts no more requests.
        let begun =
            self.under_way.fetch_update(Ordering::SeqCst, Ordering::SeqCst, |count: usize| count.checked_add(1));
        begun.is_ok().then(|| Answering(self.clone()))
    }
}

/// A request in progress; it ends when this is dropped.
#[derive(Debug)]
pub struct Answering(Arc<Connection>);

impl Answering {
    /// Keeps the request in progress until the answer has been sent; for a WebSocket, as long as the connection lives.
    pub fn until_sent(self, response: Response) -> Response {
        if response.status() == StatusCode::SWITCHING_PROTOCOLS {
            self.0.under_way.fetch_add(1, Ordering::SeqCst);
            return response;
        }
        response.map(|body| Body::new(Answer { body, _answering: self }))
    }
}

impl Drop for Answering {
    fn drop(&mut self) {
        let Self(connection) = self;
        connection.rests_since.store(ENDS.fetch_add(1, Ordering::Relaxed), Ordering::Relaxed);
        connection.under_way.fetch_sub(1, Ordering::SeqCst);
        // A connection may be waiting for a slot.
        connection.freed.notify_one();
    }
}

/// The body of an answer.
struct Answer {
    body: Body,
    _answering: Answering,
}

impl HttpBody for Answer {
    type Data = Bytes;
    type Error = axum::Error;

    fn poll_frame(
        mut self: Pin<&mut Self>,
        context: &mut Context<'_>,
    ) -> Poll<Option<Result<Frame<Bytes>, axum::Error>>> {
        Pin::new(&mut self.body).poll_frame(context)
    }

    fn is_end_stream(&self) -> bool {
        self.body.is_end_stream()
    }

    fn size_hint(&self) -> SizeHint {
        self.body.size_hint()
    }
}
