//! What a vehicle that was asked for something answers.

use serde::Serialize;
use utoipa::ToSchema;

/// Nothing more to say: the vehicle did it, and shows it where that can be seen.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, ToSchema)]
pub struct Done {}
