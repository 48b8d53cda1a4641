//! The limits and the status of a recorder.

use std::time::Duration;

use vencejo_proto::MonoTime;
use vencejo_store::{Class, Floors};

/// Frames that wait for the disk: about 16 s at 1,000 frames/s.
pub(super) const QUEUE_ITEMS: usize = 16_384;
/// How often the writer looks for frames.
pub(super) const WRITE_INTERVAL: Duration = Duration::from_millis(200);
/// How often written data is synced to disk, and free space and quota are checked.
pub(super) const SYNC_INTERVAL: Duration = Duration::from_secs(1);

/// The recorder's limits.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct RecorderConfig {
    /// A file that has grown to this size is closed, and the next one begun. 512 MiB by default: about two days of an
    /// aircraft at 10 Hz.
    pub max_file_bytes: u64,
    /// The age at which a file is closed too; unlimited by default.
    pub max_file_age: Option<Duration>,
    /// Quota of all recordings of the folder, 8 GiB by default. At least one file.
    pub quota_bytes: u64,
    /// Free space of the disk below which nothing is written, 500 MB by default.
    pub free_floor_bytes: u64,
    /// The wait before another try when writing has failed, 1 s by default; it doubles with each try that fails.
    pub retry_after: Duration,
    /// The longest wait before another try, 30 s by default.
    pub retry_at_most: Duration,
    /// Capacity of the queue, 16,384 frames by default. Overflow: see
    /// [`RecorderHandle::put`](super::RecorderHandle::put) and [`RecorderHandle::offer`](super::RecorderHandle::offer).
    pub queue_items: usize,
}

impl Default for RecorderConfig {
    fn default() -> Self {
        Self {
            max_file_bytes: 512 << 20,
            max_file_age: None,
            quota_bytes: 8 << 30,
            free_floor_bytes: Floors::default().bytes(Class::Telemetry),
            retry_after: Duration::from_secs(1),
            retry_at_most: Duration::from_secs(30),
            queue_items: QUEUE_ITEMS,
        }
    }
}

/// The status of a recording.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct RecorderStatus {
    /// The state of the recorder.
    pub state: RecorderState,
    /// Since when it has been recording or not recording.
    pub since: MonoTime,
    /// Frames written in this session.
    pub frames: u64,
    /// Of these, frames that were synced to disk; counted anew after a failure.
    pub synced: u64,
    /// Bytes written in this session.
    pub bytes: u64,
    /// Frames that were not recorded: queue full, or nothing could be written.
    pub dropped: u64,
    /// Number of failures; after each, frames that were not synced may be missing.
    pub failures: u64,
}

/// The state of a recorder.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum RecorderState {
    /// About to open its file.
    Starting,
    /// Writing.
    Recording {
        /// The file's name in the folder.
        file: String,
    },
    /// Nothing is written, because the disk is nearly full.
    LowSpace {
        /// Free bytes.
        free_bytes: u64,
        /// Free bytes required.
        floor_bytes: u64,
    },
    /// Nothing is written, because writing failed; it is tried again.
    Failing {
        /// What went wrong.
        error: String,
    },
    /// Nothing is written, because the disk does not answer.
    Stalled,
    /// Closed.
    Closed,
}

impl RecorderState {
    /// Why nothing is written, in English; `None` while it writes or is about to.
    pub fn problem(&self) -> Option<String> {
        match self {
            Self::Starting | Self::Recording { .. } => None,
            Self::LowSpace { free_bytes, floor_bytes } => Some(format!(
                "only {} MB are free on the disk, and {} MB stay free of telemetry",
                free_bytes / 1_000_000,
                floor_bytes / 1_000_000
            )),
            Self::Failing { error } => Some(error.clone()),
            Self::Stalled => Some("the disk does not answer".to_owned()),
            Self::Closed => Some("closed".to_owned()),
        }
    }
}
