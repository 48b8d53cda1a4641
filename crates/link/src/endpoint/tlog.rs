//! Owns the replay of a recording as a link: its frames come at the recorded pace, times a factor.

use std::io;
use std::path::{Path, PathBuf};
use std::time::Duration;

use tokio::io::AsyncReadExt;
use tokio::time::Instant;

use super::{Context, End};
use crate::tlog::{SkippedBytes, TlogDecoder};

/// What one read takes.
const READ_BYTES: usize = 32 * 1024;
/// A longer pause in a recording, or a step back, is a clock that was set: replayed without waiting.
const LONGEST_PAUSE_US: u64 = 60 * 60 * 1_000_000;
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
        let mut pace = Pace::new(self.speed);
        loop {
            let count = file.read(&mut buffer).await?;
            decoder.push(&buffer[..count]);
            if count == 0 {
                decoder.finish();
            }
            while let Some(entry) = decoder.next_entry() {
                pace.wait_for(entry.unix_us).await;
                context.hub.receive(&context.port, &entry.frame, context.hub.clock().now());
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
    previous_us: Option<u64>,
    due: Instant,
}

impl Pace {
    fn new(speed: f64) -> Self {
        Self { speed, previous_us: None, due: Instant::now() }
    }

    async fn wait_for(&mut self, unix_us: u64) {
        let pause_us = self.previous_us.map_or(0, |previous| unix_us.saturating_sub(previous));
        self.previous_us = Some(unix_us);
        if pause_us <= LONGEST_PAUSE_US {
            self.due += Duration::from_micros(pause_us).div_f64(self.speed);
        }
        // Without this a replay at a great speed would keep its worker thread to itself.
        tokio::task::consume_budget().await;
        if self.due > Instant::now() {
            tokio::time::sleep_until(self.due).await;
        }
    }
}

fn name(path: &Path) -> String {
    path.file_name().unwrap_or(path.as_os_str()).to_string_lossy().into_owned()
}
