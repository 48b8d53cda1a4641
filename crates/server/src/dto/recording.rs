//! The recordings of this station, and what is in one.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

/// The recording of this session.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, ToSchema)]
pub struct Recorder {
    /// Whether frames are being written.
    pub is_recording: bool,
    /// Name of the file that is being written.
    #[schema(required = true)]
    pub file: Option<String>,
    /// Frames written in this session.
    pub frames: u64,
    /// Bytes written in this session.
    pub bytes: u64,
    /// Frames that the disk was too slow for, or that could not be written.
    pub dropped: u64,
    /// Why nothing is written.
    #[schema(required = true)]
    pub problem: Option<String>,
}

/// A recording on the server's disk.
#[derive(Debug, Clone, PartialEq, Serialize, ToSchema)]
pub struct Recording {
    /// Name of its file.
    pub name: String,
    /// Its size.
    pub bytes: u64,
    /// When it was written last, seconds since 1970; null when the system does not say.
    #[schema(required = true)]
    pub modified_unix_s: Option<f64>,
    /// Whether it is being written now.
    pub is_current: bool,
    /// Whether somebody keeps it: it is not deleted to make room for new ones.
    pub is_kept: bool,
}

/// Whether a recording is to be kept.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct KeepRecording {
    /// Keep it.
    pub is_kept: bool,
}

/// Who spoke in a recording.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, ToSchema)]
pub struct Sender {
    /// System id.
    pub system_id: u8,
    /// Component id.
    pub component_id: u8,
    /// Frames.
    pub frames: u64,
    /// `MAV_TYPE` of its heartbeats; null when it sent none.
    #[schema(required = true)]
    pub mav_type: Option<u8>,
    /// `MAV_AUTOPILOT` of its heartbeats; null when it sent none.
    #[schema(required = true)]
    pub autopilot: Option<u8>,
}

/// Something that happened to a vehicle in a recording.
#[derive(Debug, Clone, PartialEq, Serialize, ToSchema)]
pub struct RecordedEvent {
    /// Since the first frame.
    pub time_s: f64,
    /// The vehicle.
    pub system_id: u8,
    /// Such as `mode`, `armed`, `disarmed`, `text`, `item_reached`, `lost`.
    pub kind: String,
    /// In words; the vehicle's own for `text`.
    pub text: String,
}

/// What is in a recording.
#[derive(Debug, Clone, PartialEq, Serialize, ToSchema)]
pub struct RecordingSummary {
    /// Whole frames.
    pub frames: u64,
    /// Bytes that belong to no whole frame: damage, or a torn end.
    pub skipped_bytes: u64,
    /// Time of the first frame, seconds since 1970; null when there is none.
    #[schema(required = true)]
    pub start_unix_s: Option<f64>,
    /// From the first frame to the last.
    pub duration_s: f64,
    /// Who spoke.
    pub senders: Vec<Sender>,
    /// Frames of each message by name.
    pub messages: BTreeMap<String, u64>,
    /// What happened, in order.
    pub events: Vec<RecordedEvent>,
    /// Later events for which there was no room.
    pub events_left_out: u64,
}

/// Whether our heartbeat is sent.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct SetHeartbeat {
    /// Send it.
    pub enabled: bool,
}

/// One parameter of a file.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct FileParam {
    /// Its name: capital letters, digits and underscores, up to 16.
    pub name: String,
    /// Its value.
    pub value: f64,
}
