//! Signing of a vehicle's frames, and how to change it. Keys are never sent over this API.

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

/// Signing state of a vehicle; counters start with the server.
#[derive(Debug, Clone, PartialEq, Serialize, ToSchema)]
pub struct SigningInfo {
    /// Whether unsigned frames of the vehicle are refused.
    pub must_sign: bool,
    /// Name of the key in use with the vehicle; null when there is none.
    #[schema(required = true)]
    pub key: Option<String>,
    /// Whether that key is missing on this machine; all frames of the vehicle are refused then.
    pub key_missing: bool,
    /// Names of keys that were sent to the vehicle but that it has not used yet.
    pub unproven: Vec<String>,
    /// Whether its link accepts unsigned frames: USB, loopback, or configured so.
    pub link_accepts_unsigned: bool,
    /// Frames with a valid signature.
    pub verified: u64,
    /// Unsigned frames that were accepted.
    pub unsigned_accepted: u64,
    /// Refused: unsigned.
    pub refused_unsigned: u64,
    /// Refused: signed with another key, or altered in transit.
    pub refused_wrong_key: u64,
    /// Refused: not newer than the last accepted frame.
    pub refused_replayed: u64,
    /// Refused: first frame of its stream, older than a minute.
    pub refused_old: u64,
    /// Refused: timestamp in the future.
    pub refused_future: u64,
    /// Time since the newest verified frame.
    #[schema(required = true)]
    pub verified_age_s: Option<f64>,
    /// Time since the newest refused frame.
    #[schema(required = true)]
    pub refused_age_s: Option<f64>,
}

/// Action on a vehicle's key.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum SigningAct {
    /// Give a key to a vehicle that does not sign.
    SetUp,
    /// Replace the key of a vehicle that signs.
    Rotate,
    /// Remove the key.
    Remove,
}

/// Request to change a vehicle's signing.
#[derive(Debug, Clone, PartialEq, Eq, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct ChangeSigning {
    /// Action to carry out.
    pub act: SigningAct,
    /// The vehicle's system id, repeated as a confirmation.
    pub confirm_system_id: u8,
    /// Whether the key may be sent over a link that others can listen to.
    #[serde(default)]
    pub any_link: bool,
}
