//! The stream of one connection. It ends when no first request arrives in time, when the peer stops reading, or when
//! the connection has to make room for another.

use std::future::Future;
use std::io::{self, IoSlice};
use std::pin::Pin;
use std::sync::Arc;
use std::sync::atomic::Ordering;
use std::task::{Context, Poll, ready};
use std::time::Duration;

use tokio::io::{AsyncRead, AsyncWrite, ReadBuf};
use tokio::time::{Sleep, sleep, timeout};

use super::limits::{Connection, DoorLimits, Slot};

/// A stream with its slot and its limits.
pub struct Guarded<S> {
    stream: S,
    stall: Duration,
    /// Runs while the peer does not read.
    stalled: Option<Pin<Box<Sleep>>>,
    /// Becomes ready when the connection is to end.
    end: Pin<Box<dyn Future<Output = io::Error> + Send>>,
    _slot: Slot,
}

impl<S> std::fmt::Debug for Guarded<S> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Guarded").finish_non_exhaustive()
    }
}

/// Waits until the connection is to end, and returns the reason.
async fn end_of(connection: Arc<Connection>, ask_within: Duration) -> io::Error {
    let in_time = timeout(ask_within, connection.end.notified()).await;
    if in_time.is_err() {
        if !connection.has_asked.load(Ordering::Relaxed) {
            return io::Error::new(io::ErrorKind::TimedOut, "no complete request arrived");
        }
        connection.end.notified().await;
    }
    io::Error::new(io::ErrorKind::ConnectionAborted, "made room for another connection")
}

impl<S> Guarded<S> {
    pub(super) fn new(stream: S, slot: Slot, limits: &DoorLimits) -> Self {
        let end = Box::pin(end_of(slot.connection.clone(), limits.ask_within));
        Self { stream, stall: limits.stall, stalled: None, end, _slot: slot }
    }

    /// Returns an error if the connection is to end now.
    fn look(&mut self, context: &mut Context<'_>) -> io::Result<()> {
        match self.end.as_mut().poll(context) {
            Poll::Ready(why) => {
                // Further polls get the same answer, and no future is polled after its completion.
                self.end = Box::pin(std::future::ready(io::Error::from(why.kind())));
                Err(why)
            }
            Poll::Pending => Ok(()),
        }
    }

    /// Updates the stall timer with the result of a write.
    fn wrote<T>(&mut self, context: &mut Context<'_>, wrote: Poll<io::Result<T>>) -> Poll<io::Result<T>> {
        if wrote.is_ready() {
            self.stalled = None;
            return wrote;
        }
        let stall = self.stall;
        let stalled = self.stalled.get_or_insert_with(|| Box::pin(sleep(stall)));
        ready!(stalled.as_mut().poll(context));
        Poll::Ready(Err(io::Error::new(io::ErrorKind::TimedOut, "the client reads nothing")))
    }
}

impl<S: AsyncRead + Unpin> AsyncRead for Guarded<S> {
    fn poll_read(
        mut self: Pin<&mut Self>,
        context: &mut Context<'_>,
        buffer: &mut ReadBuf<'_>,
    ) -> Poll<io::Result<()>> {
        self.look(context)?;
        Pin::new(&mut self.stream).poll_read(context, buffer)
    }
}

impl<S: AsyncWrite + Unpin> AsyncWrite for Guarded<S> {
    fn poll_write(mut self: Pin<&mut Self>, context: &mut Context<'_>, bytes: &[u8]) -> Poll<io::Result<usize>> {
        self.look(context)?;
        let wrote = Pin::new(&mut self.stream).poll_write(context, bytes);
        self.wrote(context, wrote)
    }

    fn poll_write_vectored(
        mut self: Pin<&mut Self>,
        context: &mut Context<'_>,
        slices: &[IoSlice<'_>],
    ) -> Poll<io::Result<usize>> {
        self.look(context)?;
        let wrote = Pin::new(&mut self.stream).poll_write_vectored(context, slices);
        self.wrote(context, wrote)
    }

    fn is_write_vectored(&self) -> bool {
        self.stream.is_write_vectored()
    }

    fn poll_flush(mut self: Pin<&mut Self>, context: &mut Context<'_>) -> Poll<io::Result<()>> {
        self.look(context)?;
        Pin::new(&mut self.stream).poll_flush(context)
    }

    fn poll_shutdown(mut self: Pin<&mut Self>, context: &mut Context<'_>) -> Poll<io::Result<()>> {
        self.look(context)?;
        Pin::new(&mut self.stream).poll_shutdown(context)
    }
}
