//! What takes a while: transfers of plans and parameters.

use serde::Serialize;
use utoipa::ToSchema;

use super::{Param, Plan, Problem};

/// How an operation stands.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum OperationState {
    /// Under way.
    Running,
    /// Succeeded.
    Done,
    /// Failed; `error` says why.
    Failed,
    /// Given up on request.
    Cancelled,
}

/// What an operation does.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum OperationKind {
    /// Sends a mission and reads it back.
    UploadMission,
    /// Sends a fence and reads it back.
    UploadFence,
    /// Sends rally points and reads them back.
    UploadRally,
    /// Reads the mission.
    DownloadMission,
    /// Reads the fence.
    DownloadFence,
    /// Reads the rally points.
    DownloadRally,
    /// Removes the mission.
    ClearMission,
    /// Removes the fence.
    ClearFence,
    /// Removes the rally points.
    ClearRally,
    /// Reads all parameters.
    ReadParams,
}

/// What an operation brought.
#[derive(Debug, Clone, PartialEq, Serialize, ToSchema)]
#[serde(untagged)]
pub enum OperationResult {
    /// The plan on board.
    Plan(Plan),
    /// All parameters, by name.
    Params(Vec<Param>),
}

/// Something that takes a while.
#[derive(Debug, Clone, PartialEq, Serialize, ToSchema)]
pub struct Operation {
    /// Its id.
    pub id: u64,
    /// The vehicle.
    pub vehicle: u16,
    /// What it does.
    pub kind: OperationKind,
    /// How it stands.
    pub state: OperationState,
    /// How much is done, in units of `total`.
    pub done: u32,
    /// How much there is; 0 when not known yet.
    pub total: u32,
    /// Why it failed.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false)]
    pub error: Option<Problem>,
    /// After an upload to a vehicle that keeps positions as 32-bit floats: how far the farthest place on board is from where it
    /// was sent to be.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false)]
    pub position_error_m: Option<f64>,
    /// What it brought; only at `GET /operations/{id}`, once done.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false)]
    pub result: Option<OperationResult>,
}
