//! Long-running operations: transfers of plans and parameters.

use serde::Serialize;
use utoipa::ToSchema;

use super::{Param, Plan, Problem};

/// State of an operation.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum OperationState {
    /// In progress.
    Running,
    /// Succeeded.
    Done,
    /// Failed; `error` says why.
    Failed,
    /// Cancelled on request.
    Cancelled,
}

/// Kind of an operation.
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

/// Result of an operation.
#[derive(Debug, Clone, PartialEq, Serialize, ToSchema)]
#[serde(untagged)]
pub enum OperationResult {
    /// The plan on board.
    Plan(Plan),
    /// All parameters, by name.
    Params(Vec<Param>),
}

/// A long-running operation.
#[derive(Debug, Clone, PartialEq, Serialize, ToSchema)]
pub struct Operation {
    /// Id of the operation.
    pub id: u64,
    /// Id of the vehicle.
    pub vehicle: u16,
    /// Kind of the operation.
    pub kind: OperationKind,
    /// State of the operation.
    pub state: OperationState,
    /// Progress, in units of `total`.
    pub done: u32,
    /// Total amount of work; 0 when not known yet.
    pub total: u32,
    /// Why it failed.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false)]
    pub error: Option<Problem>,
    /// After an upload to a vehicle that stores positions as 32-bit floats: largest distance between a position on
    /// board and the one that was sent.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false)]
    pub position_error_m: Option<f64>,
    /// The result; only at `GET /operations/{id}`, once the operation is done.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false)]
    pub result: Option<OperationResult>,
}
