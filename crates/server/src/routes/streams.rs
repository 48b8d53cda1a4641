//! Streaming of request and response bodies in chunks, so that memory stays small whatever their size.

use std::io::Read;
use std::path::PathBuf;
use std::pin::Pin;
use std::task::{Context, Poll};

use axum::body::{Body, Bytes, HttpBody};
use http_body::Frame;
use tokio::fs::File;
use tokio::io::{AsyncRead, ReadBuf};
use tokio::sync::mpsc;
use vencejo_maps::MapError;
use vencejo_maps::uploads::Upload;

use crate::dto::Role;
use crate::dto::cause::Cause;
use crate::problem::Problem;
use crate::turns::BodyPlace;

/// Size of a chunk.
const PIECE: usize = 64 * 1024;
/// Chunks waiting to be read.
const PIECES: usize = 4;

/// Request body as a stream of chunks.
struct Pieces {
    body: Body,
    bytes: u64,
    most: u64,
}

impl Pieces {
    const fn of(body: Body, most: u64) -> Self {
        Self { body, bytes: 0, most }
    }

    /// Next chunk; `None` at the end.
    async fn next(&mut self) -> Result<Option<Bytes>, Problem> {
        while let Some(frame) = std::future::poll_fn(|context| Pin::new(&mut self.body).poll_frame(context)).await {
            let frame =
                frame.map_err(|error| Problem::invalid(format!("the file did not arrive completely: {error}")))?;
            let Ok(data) = frame.into_data() else { continue };
            self.bytes += data.len() as u64;
            if self.bytes > self.most {
                let detail = format!("the file has more than {} bytes", self.most);
                return Err(Problem::new(Cause::BodyTooLarge, detail));
            }
            return Ok(Some(data));
        }
        Ok(None)
    }
}

/// Writes a request body to a file.
pub(super) async fn take(body: Body, upload: &mut Upload, most: u64) -> Result<(), Problem> {
    let mut pieces = Pieces::of(body, most);
    while let Some(data) = pieces.next().await? {
        upload.write(&data).await?;
    }
    Ok(())
}

/// Processes a request body while it arrives, off the async threads, limited per role.
pub(super) async fn read<T: Send + 'static>(
    body: Body,
    role: Role,
    most: u64,
    work: impl FnOnce(Coming) -> Result<T, Problem> + Send + 'static,
) -> Result<T, Problem> {
    let mut body = Pieces::of(body, most);
    let mut piece = body.next().await?;
    let place = BodyPlace::wait(role).await?;
    let (come, pieces) = mpsc::channel(PIECES);
    let feeding = async move {
        while let Some(data) = piece {
            // When the reader has stopped, the rest is discarded.
            let _ = come.send(data).await;
            piece = body.next().await?;
        }
        Ok::<_, Problem>(())
    };
    let (fed, done) = tokio::join!(feeding, place.work(move || work(Coming { pieces, rest: Bytes::new() })));
    fed?;
    done
}

/// Reader of an arriving body.
pub(super) struct Coming {
    pieces: mpsc::Receiver<Bytes>,
    rest: Bytes,
}

impl Read for Coming {
    fn read(&mut self, buffer: &mut [u8]) -> std::io::Result<usize> {
        while self.rest.is_empty() {
            match self.pieces.blocking_recv() {
                Some(piece) => self.rest = piece,
                None => return Ok(0),
            }
        }
        let count = buffer.len().min(self.rest.len());
        buffer[..count].copy_from_slice(&self.rest.split_to(count));
        Ok(count)
    }
}

/// Returns a temporary file as a body, and its length; the file is deleted after sending, or when the client
/// disconnects.
pub(super) async fn give(path: PathBuf) -> Result<(Body, u64), Problem> {
    let failed = |error: std::io::Error| Problem::from(MapError::storage(error));
    let file = File::open(&path).await.map_err(failed)?;
    let length = file.metadata().await.map_err(failed)?.len();
    Ok((Body::new(Giving { file, left: length, path }), length))
}

struct Giving {
    file: File,
    left: u64,
    path: PathBuf,
}

impl Drop for Giving {
    fn drop(&mut self) {
        if let Err(error) = std::fs::remove_file(&self.path) {
            tracing::warn!(%error, path = %self.path.display(), "a temporary file cannot be removed");
        }
    }
}

impl HttpBody for Giving {
    type Data = Bytes;
    type Error = std::io::Error;

    fn poll_frame(
        mut self: Pin<&mut Self>,
        context: &mut Context<'_>,
    ) -> Poll<Option<Result<Frame<Bytes>, Self::Error>>> {
        if self.left == 0 {
            return Poll::Ready(None);
        }
        let mut buffer = vec![0; PIECE];
        let mut read = ReadBuf::new(&mut buffer);
        match Pin::new(&mut self.file).poll_read(context, &mut read) {
            Poll::Pending => Poll::Pending,
            Poll::Ready(Err(error)) => Poll::Ready(Some(Err(error))),
            Poll::Ready(Ok(())) => {
                let got = read.filled().len();
                if got == 0 {
                    return Poll::Ready(None);
                }
                buffer.truncate(got);
                self.left = self.left.saturating_sub(got as u64);
                Poll::Ready(Some(Ok(Frame::data(Bytes::from(buffer)))))
            }
        }
    }
}
