//! Files over the wire, a piece at a time: memory stays small whatever their size.

use std::path::PathBuf;
use std::pin::Pin;
use std::task::{Context, Poll};

use axum::body::{Body, Bytes, HttpBody};
use http_body::Frame;
use tokio::fs::File;
use tokio::io::{AsyncRead, ReadBuf};
use vencejo_maps::MapError;
use vencejo_maps::uploads::Upload;

use crate::dto::cause::Cause;
use crate::problem::Problem;

/// Bytes of a piece.
const PIECE: usize = 64 * 1024;

/// Writes a request's body to a file.
pub(super) async fn take(body: Body, upload: &mut Upload, most: u64) -> Result<(), Problem> {
    let mut body = std::pin::pin!(body);
    while let Some(frame) = std::future::poll_fn(|context| body.as_mut().poll_frame(context)).await {
        let frame = frame.map_err(|error| Problem::invalid(format!("the file did not come whole: {error}")))?;
        let Ok(data) = frame.into_data() else { continue };
        if upload.bytes() + data.len() as u64 > most {
            let detail = format!("the file has more than {most} bytes");
            return Err(Problem::new(Cause::BodyTooLarge, detail));
        }
        upload.write(&data).await?;
    }
    Ok(())
}

/// A temporary file as a body, and its length; the file is gone when it was sent, or nobody wants it any more.
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
            tracing::warn!(%error, path = %self.path.display(), "a temporary file stays");
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
