//! Answer to a completed request.

use serde::Serialize;
use utoipa::ToSchema;

/// Empty answer: the vehicle accepted the request, and its telemetry shows the effect where it can be observed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, ToSchema)]
pub struct Done {}
