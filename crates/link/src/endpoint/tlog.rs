//! Owns the replay of a recording as a link, at the recorded pace times a factor.

use std::io;
use std::path::{Path, PathBuf};
use std::time::Duration;

use tokio::io::AsyncReadExt;
use tokio::time::Instant;

use super::{Context, End};
use crate::onward::Onward;
use crate::outlet::Peer;
use crate::played::PlayedTime;
use crate::tlog::{SkippedBytes, TlogDecoder};

/// Bytes of one read.
const READ_BYTES: usize = 32 * 1024;
/// A loop through a recording without a frame, or without duration, must not spin.
const REPEAT_PAUSE: Duration = Duration::from_millis(100);

/// A replay.
pub(super) struct Replay {
    path: PathBuf,
    speed: f64,
    repeat: bool,
}

impl Replay {
    pub(super) fn new(path: PathBuf, speed: f64, repeat: bool) -> Self {
        Self { path, speed, repeat }
    }

    pub(super) async fn run(&mut self, context: &Context) -> End {
        let mut is_up = false;
        loop {
            match self.play(context, &mut is_up).await {
                Err(error) => return End::Over(Some(format!("cannot read {}: {error}", self.path.display()))),
                Ok(_) if self.repeat => {
                    tokio::time::sleep(REPEAT_PAUSE).await;
                    context.hub.on_connected(&context.port);
                }
                Ok(skipped) => {
                    let bytes = skipped.total();
                    return End::Over(
                        (bytes > 0).then(|| format!("{bytes} bytes of {} could not be read", name(&self.path))),
                    );
                }
            }
        }
    }

    async fn play(&self, context: &Context, is_up: &mut bool) -> io::Result<SkippedBytes> {
        let mut file = tokio::fs::File::open(&self.path).await?;
        if !*is_up {
            *is_up = true;
            context.up(None, 1);
        }
        let mut decoder = TlogDecoder::new();
        let mut buffer = vec![0; READ_BYTES];
        let (mut pace, mut onward) = (Pace::new(self.speed), Onward::default());
        loop {
            let count = file.read(&mut buffer).await?;
            decoder.push(&buffer[..count]);
            if count == 0 {
                decoder.finish();
            }
            while let Some(entry) = decoder.next_entry() {
                pace.wait_for(entry.unix_us).await;
                let now = context.hub.clock().now();
                context.hub.receive(&context.port, Peer::default(), &entry.frame, now, &mut onward);
                context.hub.end_reading(&mut onward);
            }
            if count == 0 {
                return Ok(decoder.skipped());
            }
        }
    }
}

/// Turns recorded time into waiting.
struct Pace {
    speed: f64,
    began: Instant,
    time: PlayedTime,
}

impl Pace {
    fn new(speed: f64) -> Self {
        Self { speed, began: Instant::now(), time: PlayedTime::default() }
    }

    async fn wait_for(&mut self, unix_us: u64) {
        let due = self.began + Duration::from_micros(self.time.until(unix_us)).div_f64(self.speed);
        // Without this a replay at a great speed would keep its worker thread to itself.
        tokio::task::consume_budget().await;
        if due > Instant::now() {
            tokio::time::sleep_until(due).await;
        }
    }
}

fn name(path: &Path) -> String {
    path.file_name().unwrap_or(path.as_os_str()).to_string_lossy().into_owned()
}

#[cfg(test)]
mod tests {
    use tokio::time::Instant;

    use crate::testing::{Listening, TempDir, heartbeat};
    use crate::tlog::write_entry;
    use crate::{LinkOptions, LinkState};

    /// A recording of heartbeats at these milliseconds, numbered from 0.
    fn recording(folder: &TempDir, times_ms: &[u64], tail: &[u8]) -> String {
        let mut bytes = Vec::new();
        for (sequence, ms) in times_ms.iter().enumerate() {
            write_entry(&mut bytes, 1_700_000_000_000_000 + ms * 1000, &heartbeat(1, 1, sequence as u8));
        }
        bytes.extend_from_slice(tail);
        let path = folder.0.join("flight.tlog");
        std::fs::write(&path, bytes).unwrap();
        path.display().to_string()
    }

    async fn times(listening: &mut Listening, count: usize) -> Vec<u128> {
        let start = Instant::now();
        let mut times = Vec::new();
        for _ in 0..count {
            listening.next().await;
            times.push(start.elapsed().as_millis());
        }
        times
    }

    #[tokio::test(start_paused = true)]
    async fn frames_come_at_the_recorded_pace_and_then_it_ends() {
        let folder = TempDir::new();
        let path = recording(&folder, &[0, 100, 100, 1000, 4000], &[]);
        let mut listening = Listening::new();
        let mut link = listening.hub.open(format!("tlog:{path}").parse().unwrap(), LinkOptions::default()).unwrap();
        assert_eq!(times(&mut listening, 5).await, [0, 100, 100, 1000, 4000]);
        let ended = link.wait_for(|state| matches!(state, LinkState::Ended { .. })).await;
        assert_eq!(ended, LinkState::Ended { remark: None });
        assert_eq!(listening.hub.links()[0].state, LinkState::Ended { remark: None }, "listed until it is closed");
        link.close().await;
        assert!(listening.hub.links().is_empty());
    }

    #[tokio::test(start_paused = true)]
    async fn faster_and_over_a_clock_that_was_set() {
        let folder = TempDir::new();
        let year_ms = 365 * 24 * 3600 * 1000;
        let path = recording(&folder, &[1000, 2000, year_ms, year_ms + 500, 10, 510], b"torn");
        let mut listening = Listening::new();
        let address = format!("tlog:{path}?speed=10").parse().unwrap();
        let mut link = listening.hub.open(address, LinkOptions::default()).unwrap();
        assert_eq!(times(&mut listening, 6).await, [0, 100, 100, 150, 150, 200]);
        let ended = link.wait_for(|state| matches!(state, LinkState::Ended { .. })).await;
        assert_eq!(ended, LinkState::Ended { remark: Some("4 bytes of flight.tlog could not be read".to_owned()) });
    }

    #[tokio::test(start_paused = true)]
    async fn again_and_again_when_asked() {
        let folder = TempDir::new();
        let path = recording(&folder, &[0, 10], &[]);
        let mut listening = Listening::new();
        let address = format!("tlog:{path}?loop=true").parse().unwrap();
        let link = listening.hub.open(address, LinkOptions::default()).unwrap();
        for _ in 0..200 {
            // The wait between rounds is less than a second: equal frames a round apart are told from copies.
            assert_eq!(listening.next().await, heartbeat(1, 1, 0));
            assert_eq!(listening.next().await, heartbeat(1, 1, 1));
        }
        link.close().await;
    }

    #[tokio::test(start_paused = true)]
    async fn a_missing_file_ends_it_with_the_reason() {
        let listening = Listening::new();
        let mut link =
            listening.hub.open("tlog:/nowhere/flight.tlog".parse().unwrap(), LinkOptions::default()).unwrap();
        let ended = link.wait_for(|state| matches!(state, LinkState::Ended { .. })).await;
        assert!(format!("{ended:?}").contains("cannot read /nowhere/flight.tlog"), "{ended:?}");
    }
}
