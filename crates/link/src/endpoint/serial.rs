//! Owns serial links: a port opened exclusively, raw, 8 data bits, no parity, one stop bit, no flow control.

use std::sync::Arc;

use serial2_tokio::SerialPort;

use super::{Context, End, stream};
use crate::fault::{FaultKind, LinkFault};
use crate::outlet::{Peer, StreamQueue};

/// Bytes handed to the system at once: some 40 ms on a 57,600 baud line.
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
        let end = stream::serve(context, Peer::default(), reader, writer, &self.queue, BATCH_BYTES).await;
        self.queue.close();
        match end {
            End::Broken(fault) => End::Broken(LinkFault::new(fault.kind, format!("{}: {fault}", self.path))),
            end => end,
        }
    }

    fn open(&self) -> std::io::Result<(SerialPort, Claim)> {
        let claim = Claim::of(&self.path)?;
        let port = SerialPort::open(&self.path, self.baud)?;
        claim.keep_others_out()?;
        // What was received before the port was opened is stale.
        port.discard_input_buffer()?;
        Ok((port, claim))
    }

    fn explain(&self, error: &std::io::Error) -> LinkFault {
        use std::io::ErrorKind;
        let (kind, hint) = match error.kind() {
            ErrorKind::NotFound => {
                (FaultKind::NoSerialPort, "; is it plugged in? On Linux `ls /dev/serial/by-id` shows what is")
            }
            ErrorKind::PermissionDenied => (
                FaultKind::NoSerialPermission,
                "; may you use it? On Linux: `sudo usermod -aG dialout $USER`, then log in again",
            ),
            ErrorKind::ResourceBusy | ErrorKind::WouldBlock => {
                (FaultKind::SerialPortInUse, "; another program uses it")
            }
            ErrorKind::InvalidInput => (FaultKind::NoBaudRate, "; the port does not have that baud rate"),
            _ => (FaultKind::Other, ""),
        };
        LinkFault::new(kind, format!("cannot open {} at {} baud: {error}{hint}", self.path, self.baud))
    }
}

impl Drop for Serial {
    fn drop(&mut self) {
        self.queue.close();
    }
}

/// Exclusive use of a port while it lives: the lock keeps out programs that take it too (pyserial, mavlink-router, this
/// one), the terminal's exclusive mode all others.
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

#[cfg(unix)]
#[cfg(test)]
mod tests {
    use std::io::{Read, Write};
    use std::path::Path;

    use rustix::pty::{OpenptFlags, grantpt, openpt, ptsname, unlockpt};

    use crate::testing::{Listening, TempDir, US, heartbeat, in_time, say_something};
    use crate::{LinkOptions, LinkState};
    use vencejo_proto::{Frame, FrameDecoder};

    /// The other end of a serial line; the link opens `port`.
    struct Line {
        master: std::fs::File,
        port: String,
    }

    impl Line {
        fn new() -> Self {
            let master = openpt(OpenptFlags::RDWR | OpenptFlags::NOCTTY | OpenptFlags::CLOEXEC).unwrap();
            grantpt(&master).unwrap();
            unlockpt(&master).unwrap();
            let port = ptsname(&master, Vec::new()).unwrap().into_string().unwrap();
            Self { master: master.into(), port }
        }

        /// Plugs the line in under a name that stays.
        fn plug(path: &Path) -> Self {
            let line = Self::new();
            let _ = std::fs::remove_file(path);
            std::os::unix::fs::symlink(&line.port, path).unwrap();
            line
        }

        async fn hears(&self) -> Frame {
            let mut master = self.master.try_clone().unwrap();
            let read = tokio::task::spawn_blocking(move || {
                let mut decoder = FrameDecoder::new();
                loop {
                    let mut byte = [0];
                    master.read_exact(&mut byte).unwrap();
                    decoder.push(&byte);
                    if let Some(frame) = decoder.next_frame() {
                        return frame;
                    }
                }
            });
            in_time(read).await.unwrap()
        }
    }

    #[tokio::test]
    async fn frames_go_both_ways_raw() {
        let mut listening = Listening::new();
        let mut line = Line::new();
        let link = listening.open(&format!("serial:{}:115200", line.port)).await;
        // All byte values that a terminal would change or act on occur here.
        let bytes: Vec<u8> = (0..=255).collect();
        line.master.write_all(&bytes).unwrap();
        for sequence in 0..=255 {
            line.master.write_all(heartbeat(1, 1, sequence).bytes()).unwrap();
        }
        // What looks like the start of a frame at the end of the ramp swallows at most the first few.
        let mut heard = Vec::new();
        while heard.last() != Some(&255) {
            let frame = listening.next().await;
            if frame.is_known() {
                heard.push(frame.sequence());
            }
        }
        let expected: Vec<u8> = (heard[0]..=255).collect();
        assert_eq!(heard, expected);
        assert!(heard[0] < 14, "{}", heard[0]);
        for _ in 0..30 {
            assert_eq!(say_something(&listening.hub), 1);
        }
        for sequence in 0..30 {
            let frame = line.hears().await;
            assert_eq!((frame.source(), frame.sequence()), (US, sequence));
        }
        link.close().await;
    }

    #[tokio::test]
    async fn a_port_is_ours_alone_and_free_afterwards() {
        let listening = Listening::new();
        let line = Line::new();
        let address = format!("serial:{}:57600", line.port);
        let first = listening.open(&address).await;
        let mut second = listening.hub.open(address.parse().unwrap(), LinkOptions::default()).unwrap();
        let state =
            in_time(second.wait_for(|state| matches!(state, LinkState::Connecting { last_error: Some(_), .. }))).await;
        assert!(format!("{state:?}").contains("another program uses it"), "{state:?}");
        first.close().await;
        in_time(second.wait_for(LinkState::is_up)).await;
        second.close().await;
    }

    // fault 13: a serial line that is unplugged and plugged in again three times goes on
    #[tokio::test]
    async fn unplugged_and_plugged_in_again() {
        let mut listening = Listening::new();
        let folder = TempDir::new();
        let path = folder.0.join("ttyACM0");
        let mut line = Line::plug(&path);
        let mut link = listening.open(&format!("serial:{}:57600", path.display())).await;
        for round in 0..3 {
            line.master.write_all(heartbeat(1, 1, round).bytes()).unwrap();
            assert_eq!(listening.next().await, heartbeat(1, 1, round));
            drop(line);
            in_time(link.wait_for(|state| !state.is_up())).await;
            assert_eq!(say_something(&listening.hub), 0, "nothing is kept for later");
            line = Line::plug(&path);
            in_time(link.wait_for(LinkState::is_up)).await;
        }
        link.close().await;
    }
}
