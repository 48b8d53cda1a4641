//! What the core says of a plan that somebody edits or is about to send.

use vencejo_flight::checks::{CheckContext, check_plan};
use vencejo_flight::progress::{ProgressOptions, trip};
use vencejo_proto::SystemId;

use crate::convert;
use crate::dto::{Assessment, Plan};
use crate::problem::Problem;
use crate::state::App;

/// What the core says of a plan that a vehicle is to fly, an ArduPlane as it comes when there is none.
///
/// # Errors
/// For what is no plan.
pub(crate) fn assess(app: &App, vehicle: Option<u8>, plan: &Plan) -> Result<Assessment, Problem> {
    let plan = convert::core_plan(plan)?;
    let any = CheckContext::default();
    let vehicle = vehicle.and_then(|id| app.station().vehicle(SystemId(id)));
    let findings = vehicle.as_ref().map_or_else(|| check_plan(&plan, &any), |vehicle| vehicle.check_plan(&plan));
    let known = vehicle.and_then(|vehicle| vehicle.trip(&plan.mission));
    let trip = known.unwrap_or_else(|| trip(&plan.mission, Some(any.airspeed_m_s), &ProgressOptions::default()));
    Ok(Assessment { findings, trip })
}
