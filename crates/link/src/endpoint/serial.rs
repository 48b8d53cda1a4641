//! Owns serial links: a port opened for us alone, raw, 8 data bits, no parity, one stop bit, no flow control.

use std::sync::Arc;

use serial2_tokio::SerialPort;

use super::{Context, End, stream};
use crate::outlet::StreamQueue;

/// What is handed to the system at once: some 40 ms on a 57,600 baud line.
const BATCH_BYTES: usize = 256;

/// A serial link.
pub(super) struct Serial {
    path: String,
    baud: u32,
    queue: Arc<StreamQueue>,
}

impl Serial {
    pub(super) fn new(path: String, baud: u32, queue: Arc<StreamQueue>) -> Self {
        Self { path, baud, queue }
    }

    pub(super) async fn run(&mut self, context: &Context) -> End {
        let (port, _claim) = match self.open() {
            Ok(opened) => opened,
            Err(error) => return End::Broken(self.explain(&error)),
        };
        let (reader, writer) = tokio::io::split(port);
        self.queue.open();
        context.up(None, 1);
        let end = stream::serve(context, reader, writer, &self.queue, BATCH_BYTES, |_| {}).await;
        self.queue.close();
        match end {
            End::Broken(error) => End::Broken(format!("{}: {error}", self.path)),
            end => end,
        }
    }

    fn open(&self) -> std::io::Result<(SerialPort, Claim)> {
        let claim = Claim::of(&self.path)?;
        let port = SerialPort::open(&self.path, self.baud)?;
        claim.keep_others_out()?;
        // What piled up while nobody listened is old.
        port.discard_input_buffer()?;
        Ok((port, claim))
    }

    fn explain(&self, error: &std::io::Error) -> String {
        use std::io::ErrorKind;
        let hint = match error.kind() {
            ErrorKind::NotFound => "; is it plugged in? `vencejo links` lists the ports",
            ErrorKind::PermissionDenied => {
                "; may you use it? On Linux: `sudo usermod -aG dialout $USER`, then log in again"
            }
            ErrorKind::ResourceBusy | ErrorKind::WouldBlock => "; another program uses it",
            ErrorKind::InvalidInput => "; the port does not have that baud rate",
            _ => "",
        };
        format!("cannot open {} at {} baud: {error}{hint}", self.path, self.baud)
    }
}

impl Drop for Serial {
    fn drop(&mut self) {
        self.queue.close();
    }
}

/// Keeps a port ours for as long as it lives: the lock keeps out programs that ask for it (pyserial, mavlink-router,
/// another of us), the terminal's exclusive mode all others.
#[cfg(unix)]
struct Claim {
    lock: std::fs::File,
}

#[cfg(unix)]
impl Claim {
    fn of(path: &str) -> std::io::Result<Self> {
        use rustix::fs::{FlockOperation, Mode, OFlags, flock, open};
        let flags = OFlags::RDWR | OFlags::NOCTTY | OFlags::NONBLOCK | OFlags::CLOEXEC;
        let lock = std::fs::File::from(open(path, flags, Mode::empty())?);
        flock(&lock, FlockOperation::NonBlockingLockExclusive)?;
        Ok(Self { lock })
    }

    fn keep_others_out(&self) -> std::io::Result<()> {
        rustix::termios::ioctl_tiocexcl(&self.lock)?;
        Ok(())
    }
}

/// Windows opens ports for one program only.
#[cfg(not(unix))]
struct Claim;

#[cfg(not(unix))]
#[allow(clippy::unnecessary_wraps, clippy::unused_self, reason = "the same shape as on Unix")]
impl Claim {
    fn of(_: &str) -> std::io::Result<Self> {
        Ok(Self)
    }

    fn keep_others_out(&self) -> std::io::Result<()> {
        Ok(())
    }
}
