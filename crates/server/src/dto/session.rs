//! Who is there, and what they may do.

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

/// What a session may do.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum Role {
    /// Looks.
    Viewer,
    /// Commands as well, while it holds control.
    Operator,
}

/// Who wants a session.
#[derive(Debug, Clone, PartialEq, Deserialize, ToSchema, Default)]
#[serde(deny_unknown_fields)]
pub struct NewSession {
    /// The token from the server's terminal; needed when `GET /info` says so.
    #[serde(default)]
    pub token: Option<String>,
    /// Name to show to others, up to 40 characters.
    #[serde(default)]
    pub name: Option<String>,
}

/// A session as its owner sees it. The secret that proves it is in the cookie.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, ToSchema)]
pub struct SessionInfo {
    /// Public id.
    pub session: String,
    /// Its name.
    pub name: String,
    /// What it may do.
    pub role: Role,
    /// Whether it holds control.
    pub has_control: bool,
    /// Name of the session that holds control; null when nobody does.
    #[schema(required = true)]
    pub holder: Option<String>,
    /// Name of the session that asks for control; null when nobody does.
    #[schema(required = true)]
    pub requested_by: Option<String>,
}
