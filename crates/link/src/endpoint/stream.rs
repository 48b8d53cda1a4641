//! Owns the work on one open byte stream, TCP or serial: read into the hub, write from the queue.

use tokio::io::{AsyncRead, AsyncReadExt, AsyncWrite, AsyncWriteExt};

use super::{Context, End};
use crate::hub::Intake;
use crate::outlet::StreamQueue;

/// What one read takes at most.
const READ_BYTES: usize = 16 * 1024;

/// Serves a stream until it breaks. `batch_bytes` is what is handed to the system at once: little on a thin line, so
/// that what we say ourselves does not wait behind much. `heard` is called with every frame.
pub(super) async fn serve(
    context: &Context,
    reader: impl AsyncRead + Unpin,
    writer: impl AsyncWrite + Unpin,
    queue: &StreamQueue,
    batch_bytes: usize,
    heard: impl FnMut(&vencejo_proto::Frame),
) -> End {
    tokio::select! {
        biased;
        () = context.cancel.cancelled() => End::Closed,
        end = read(context, reader, heard) => end,
        end = write(writer, queue, batch_bytes) => end,
    }
}

async fn read(
    context: &Context,
    mut reader: impl AsyncRead + Unpin,
    mut heard: impl FnMut(&vencejo_proto::Frame),
) -> End {
    let mut intake = Intake::new();
    let mut buffer = vec![0; READ_BYTES];
    loop {
        match reader.read(&mut buffer).await {
            Ok(0) => return End::Broken("the other end closed the connection".to_owned()),
            Ok(count) => {
                let now = context.hub.clock().now();
                intake.feed(&context.port, &buffer[..count], |frame| {
                    heard(frame);
                    context.hub.receive(&context.port, frame, now);
                });
            }
            Err(error) if error.kind() == std::io::ErrorKind::Interrupted => {}
            Err(error) => return error.into(),
        }
    }
}

async fn write(mut writer: impl AsyncWrite + Unpin, queue: &StreamQueue, batch_bytes: usize) -> End {
    let mut batch = Vec::with_capacity(batch_bytes + 280);
    loop {
        queue.filled().await;
        loop {
            batch.clear();
            queue.take(&mut batch, batch_bytes);
            if batch.is_empty() {
                break;
            }
            if let Err(error) = writer.write_all(&batch).await {
                return error.into();
            }
        }
    }
}
