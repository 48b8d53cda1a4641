//! Owns the work on an open byte stream, TCP or serial: read into the hub, write from the queue.

use std::time::Duration;

use tokio::io::{AsyncRead, AsyncReadExt, AsyncWrite, AsyncWriteExt};

use super::{Context, End};
use crate::fault::{FaultKind, LinkFault};
use crate::onward::Onward;
use crate::outlet::{Peer, StreamQueue};
use crate::port::Intake;

/// Most bytes of one read.
const READ_BYTES: usize = 16 * 1024;
/// How long a closing link may take to send what is queued and to see the other end close.
pub(super) const GOOD_BYE: Duration = Duration::from_millis(500);

/// Serves a stream from `peer` until it breaks. `batch_bytes` is handed to the system at once: few on a slow line, so
/// that our own frames do not queue behind many.
pub(super) async fn serve(
    context: &Context,
    peer: Peer<'_>,
    mut reader: impl AsyncRead + Unpin,
    mut writer: impl AsyncWrite + Unpin,
    queue: &StreamQueue,
    batch_bytes: usize,
) -> End {
    let end = tokio::select! {
        biased;
        () = context.cancel.cancelled() => End::Closed,
        end = read(context, peer, &mut reader) => end,
        end = write(&mut writer, queue, batch_bytes) => end,
    };
    if matches!(end, End::Closed) {
        // Queued frames matter: they cancel a transfer, or close a file. An error ends the link as well.
        let _ = tokio::time::timeout(GOOD_BYE, good_bye(&mut reader, &mut writer, queue)).await;
    }
    end
}

/// Sends what is queued, shuts the write half down, and reads until the other end closes too: closing a socket with
/// unread bytes resets the connection and loses what was just sent.
async fn good_bye(
    reader: &mut (impl AsyncRead + Unpin),
    writer: &mut (impl AsyncWrite + Unpin),
    queue: &StreamQueue,
) -> std::io::Result<()> {
    let mut batch = Vec::new();
    queue.take(&mut batch, usize::MAX);
    writer.write_all(&batch).await?;
    writer.flush().await?;
    writer.shutdown().await?;
    let mut rest = [0; 4096];
    while reader.read(&mut rest).await? > 0 {}
    Ok(())
}

async fn read(context: &Context, peer: Peer<'_>, reader: &mut (impl AsyncRead + Unpin)) -> End {
    let (mut intake, mut onward) = (Intake::new(), Onward::default());
    let mut buffer = vec![0; READ_BYTES];
    loop {
        match reader.read(&mut buffer).await {
            Ok(0) => {
                return End::Broken(LinkFault::new(FaultKind::ClosedByPeer, "the other end closed the connection"));
            }
            Ok(count) => {
                let now = context.hub.clock().now();
                intake.feed(&context.port, &buffer[..count], |frame| {
                    context.hub.receive(&context.port, peer, frame, now, &mut onward);
                });
                context.hub.end_reading(&mut onward);
            }
            Err(error) if error.kind() == std::io::ErrorKind::Interrupted => {}
            Err(error) => return error.into(),
        }
    }
}

async fn write(writer: &mut (impl AsyncWrite + Unpin), queue: &StreamQueue, batch_bytes: usize) -> End {
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
