//! How a request ended, as ROS 2 is told.

use vencejo_station::{Pending, RequestResult, StationError};
use vencejo_vehicle::{Reply, VehicleError};

use crate::ros2::offer::Failed;

/// Waits for the end of a request.
pub(super) async fn end_of(pending: Pending<RequestResult>) -> Result<Reply, Failed> {
    match pending.wait().await {
        Some(Ok(reply)) => Ok(reply),
        Some(Err(error)) => Err(failed(&error)),
        None => Err("the station was closed; whether it was done is not known".into()),
    }
}

/// An error as ROS 2 is told, whose services have no field for a confirmation.
fn failed(error: &StationError) -> Failed {
    match error {
        StationError::NeedsConfirmation { challenge } => {
            let (danger, words) = (challenge.danger, challenge.danger.words());
            format!("it {words}, which needs a confirmation, and ROS 2 has none: use the web app, or Python with confirm=\"{danger}\"; nothing was sent").into()
        }
        StationError::Vehicle(VehicleError::CommandRefused { result, .. }) => {
            Failed { why: error.to_string(), result: result.0 }
        }
        _ => error.to_string().into(),
    }
}
