//! Replays of recordings.

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

/// A recording that is being replayed. Its aircraft are vehicles of their own, which take no commands.
#[derive(Debug, Clone, PartialEq, Serialize, ToSchema)]
pub struct Replay {
    /// Id of the replay.
    pub id: u32,
    /// Name of the aircraft; the file name without its ending when the recording names none.
    pub name: String,
    /// File name.
    pub file: String,
    /// Ids of its vehicles.
    pub vehicles: Vec<u16>,
    /// Time of the recording's beginning, seconds since 1970; null when unknown.
    #[schema(required = true)]
    pub start_unix_s: Option<f64>,
    /// Time in the recording now, seconds since 1970; null when unknown.
    #[schema(required = true)]
    pub unix_s: Option<f64>,
    /// Position in the recording, from its beginning.
    pub position_s: f64,
    /// Duration of the recording; a pause of more than an hour counts nothing.
    pub duration_s: f64,
    /// Times the recorded pace.
    pub speed: f64,
    /// Whether it stands still.
    pub is_paused: bool,
    /// Whether it has come to its end.
    pub is_over: bool,
    /// Number of times that it went to another position. With each, the vehicles begin anew: earlier values are void.
    pub seeks: u64,
    /// Why it cannot go on, in English; null when there is no fault.
    #[schema(required = true)]
    pub fault: Option<String>,
    /// Bytes of the recording that could not be read.
    pub skipped_bytes: u64,
}

/// A recording to replay: one of `GET /recordings`, or with `place` one of `GET /history`.
#[derive(Debug, Clone, PartialEq, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct NewReplay {
    /// File name.
    pub name: String,
    /// Place of a history file: the fleet, or `_board`.
    #[serde(default)]
    pub place: Option<String>,
    /// Times the recorded pace, 0.01 to 10,000; 1 by default.
    #[serde(default)]
    pub speed: Option<f64>,
    /// Position at which to begin; 0 by default.
    #[serde(default)]
    pub position_s: Option<f64>,
}

/// Changes of a replay; absent fields stay as they are.
#[derive(Debug, Clone, PartialEq, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct ReplayChange {
    /// Whether it stands still. `false` at the end begins again.
    #[serde(default)]
    pub is_paused: Option<bool>,
    /// Times the recorded pace, 0.01 to 10,000.
    #[serde(default)]
    pub speed: Option<f64>,
    /// Position to go to; beyond the end, the end.
    #[serde(default)]
    pub position_s: Option<f64>,
}

/// What happened in a recording.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum ReplayMarkKind {
    /// It was armed.
    Armed,
    /// It was disarmed.
    Disarmed,
    /// It changed its flight mode.
    Mode,
}

/// Something that happened in a recording.
#[derive(Debug, Clone, PartialEq, Serialize, ToSchema)]
pub struct ReplayMark {
    /// Position in the recording.
    pub position_s: f64,
    /// Id of the vehicle.
    pub vehicle: u16,
    /// What happened.
    pub kind: ReplayMarkKind,
    /// The new mode; null for other kinds.
    #[schema(required = true)]
    pub mode: Option<String>,
}
