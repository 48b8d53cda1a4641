//! Sessions and their roles.

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

/// Role of a session.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum Role {
    /// Read only.
    Viewer,
    /// May also command, while it holds control.
    Operator,
}

/// Request for a session.
#[derive(Debug, Clone, PartialEq, Deserialize, ToSchema, Default)]
#[serde(deny_unknown_fields)]
pub struct NewSession {
    /// Access token, printed on the server's terminal; required when `GET /info` says so.
    #[serde(default)]
    pub token: Option<String>,
    /// Display name, up to 40 characters.
    #[serde(default)]
    pub name: Option<String>,
}

/// The request for control that is declined.
#[derive(Debug, Clone, PartialEq, Eq, Deserialize, ToSchema, Default)]
#[serde(deny_unknown_fields)]
pub struct DeclinedRequest {
    /// Name of the operator whose request is declined, as the session's `requested_by` had it; the present one when
    /// absent.
    #[serde(default)]
    pub requested_by: Option<String>,
}

/// Who has control of a vehicle.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, ToSchema)]
pub struct VehicleControl {
    /// Name of the operator who has control, after that of the ground station; null when nobody has it.
    #[schema(required = true)]
    pub holder: Option<String>,
    /// Whether that is an operator of this station.
    pub is_held_here: bool,
    /// Name of the operator who asks for control; null when there is none.
    #[schema(required = true)]
    pub requested_by: Option<String>,
    /// Whether that is an operator of this station.
    pub is_requested_here: bool,
}

/// A session, as its owner sees it. The secret that authenticates it is in the cookie.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, ToSchema)]
pub struct SessionInfo {
    /// Public id of the session.
    pub session: String,
    /// Display name.
    pub name: String,
    /// Role of the session.
    pub role: Role,
    /// Whether the session holds control.
    pub has_control: bool,
    /// Name of the session that holds control; null when there is none.
    #[schema(required = true)]
    pub holder: Option<String>,
    /// Name of the session that requests control; null when there is none.
    #[schema(required = true)]
    pub requested_by: Option<String>,
}
