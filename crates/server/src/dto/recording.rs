//! Recordings of this station, and their contents.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

/// State of the flight recorder.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, ToSchema)]
pub struct Recorder {
    /// Whether frames are being recorded.
    pub is_recording: bool,
    /// Name of the current file; null when there is none.
    #[schema(required = true)]
    pub file: Option<String>,
    /// Frames recorded in this session.
    pub frames: u64,
    /// Bytes recorded in this session.
    pub bytes: u64,
    /// Frames lost because the disk was too slow or failed.
    pub dropped: u64,
    /// Why nothing is recorded; null when there is no fault.
    #[schema(required = true)]
    pub problem: Option<String>,
}

/// A recording on the server's disk.
#[derive(Debug, Clone, PartialEq, Serialize, ToSchema)]
pub struct Recording {
    /// File name.
    pub name: String,
    /// File size.
    pub bytes: u64,
    /// Time of the last change, seconds since 1970; null when the file system does not provide it.
    #[schema(required = true)]
    pub modified_unix_s: Option<f64>,
    /// Time of the first frame, seconds since 1970; null when there is none.
    #[schema(required = true)]
    pub start_unix_s: Option<f64>,
    /// Whether it is being recorded now.
    pub is_current: bool,
    /// Whether it is protected from deletion when space for new recordings is needed.
    pub is_kept: bool,
}

/// Protection of a recording from deletion.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct KeepRecording {
    /// Whether to protect it.
    pub is_kept: bool,
}

/// A sender in a recording.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, ToSchema)]
pub struct Sender {
    /// System id.
    pub system_id: u8,
    /// Component id.
    pub component_id: u8,
    /// Number of frames.
    pub frames: u64,
    /// `MAV_TYPE` of its heartbeats; null when there were none.
    #[schema(required = true)]
    pub mav_type: Option<u8>,
    /// `MAV_AUTOPILOT` of its heartbeats; null when there were none.
    #[schema(required = true)]
    pub autopilot: Option<u8>,
}

/// An event of a vehicle in a recording.
#[derive(Debug, Clone, PartialEq, Serialize, ToSchema)]
pub struct RecordedEvent {
    /// Time since the first frame.
    pub time_s: f64,
    /// System id of the vehicle.
    pub system_id: u8,
    /// Kind of the event, such as `mode`, `armed`, `disarmed`, `text`, `item_reached`, `lost`.
    pub kind: String,
    /// Description; for `text`, the vehicle's own text.
    pub text: String,
}

/// Contents of a recording.
#[derive(Debug, Clone, PartialEq, Serialize, ToSchema)]
pub struct RecordingSummary {
    /// Complete frames.
    pub frames: u64,
    /// Bytes outside of complete frames: damage, or a truncated end.
    pub skipped_bytes: u64,
    /// Time of the first frame, seconds since 1970; null when there is no frame.
    #[schema(required = true)]
    pub start_unix_s: Option<f64>,
    /// Time from the first frame to the last.
    pub duration_s: f64,
    /// Senders.
    pub senders: Vec<Sender>,
    /// Number of frames of each message, by name.
    pub messages: BTreeMap<String, u64>,
    /// Events in order.
    pub events: Vec<RecordedEvent>,
    /// Number of later events that are not listed, for lack of space.
    pub events_left_out: u64,
}

/// Switches the station's heartbeat.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct SetHeartbeat {
    /// Whether to send it.
    pub enabled: bool,
}

/// One parameter of a parameter file.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct FileParam {
    /// Name: up to 16 capital letters, digits and underscores.
    pub name: String,
    /// Value.
    pub value: f64,
}
