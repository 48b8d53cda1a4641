//! How a vehicle signs, and the change of it. No key ever goes over this interface.

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

/// How a vehicle signs its frames, counted since the server began.
#[derive(Debug, Clone, PartialEq, Serialize, ToSchema)]
pub struct SigningInfo {
    /// Whether what it does not sign is refused.
    pub must_sign: bool,
    /// Name of the key that it is talked to with.
    #[schema(required = true)]
    pub key: Option<String>,
    /// Whether that key is gone from this machine: nothing of the vehicle is believed then.
    pub key_missing: bool,
    /// Names of keys that were sent to it and that it has not shown.
    pub unproven: Vec<String>,
    /// Whether its link is believed without signatures: USB, loopback, or opened so.
    pub link_accepts_unsigned: bool,
    /// Frames with a right and new signature.
    pub verified: u64,
    /// Frames without one that were accepted.
    pub unsigned_accepted: u64,
    /// Refused: not signed.
    pub refused_unsigned: u64,
    /// Refused: signed with another key, or changed on the way.
    pub refused_wrong_key: u64,
    /// Refused: not later than what was accepted before.
    pub refused_replayed: u64,
    /// Refused: the first of its stream, older than a minute.
    pub refused_old: u64,
    /// Refused: its time lies in the future.
    pub refused_future: u64,
    /// Time since the newest verified frame.
    #[schema(required = true)]
    pub verified_age_s: Option<f64>,
    /// Time since the newest refused frame.
    #[schema(required = true)]
    pub refused_age_s: Option<f64>,
}

/// What is to be done with a vehicle's key.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum SigningAct {
    /// Give a new key to a vehicle that does not sign.
    SetUp,
    /// Give another key to a vehicle that signs.
    Rotate,
    /// Take its key away.
    Remove,
}

/// A change of a vehicle's signing.
#[derive(Debug, Clone, PartialEq, Eq, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct ChangeSigning {
    /// What is to be done.
    pub act: SigningAct,
    /// The vehicle's system id once more: who asks means this vehicle, and means it.
    pub confirm_system_id: u8,
    /// Whether the key may go over a link that others can listen to.
    #[serde(default)]
    pub any_link: bool,
}
