//! What keeps a mission from being sent, whichever way it came.

use vencejo_flight::checks::Severity;
use vencejo_flight::plan::{Mission, Plan};
use vencejo_station::VehicleHandle;

/// Findings that are told; of more, their number.
const MAX_FINDINGS: usize = 5;

/// What would make a mission fail, by what is known of its vehicle: its parameters, the wind. `2 errors (…; …)`, or `None` where it seems
/// sound. It may take some tenths of a second.
pub(super) fn mission_errors(vehicle: &VehicleHandle, mission: Mission) -> Option<String> {
    let found = vehicle.check_upload(&Plan::from_mission(mission), None);
    let errors: Vec<_> =
        found.iter().filter(|finding| finding.severity == Severity::Error).map(ToString::to_string).collect();
    let more = match errors.len().saturating_sub(MAX_FINDINGS) {
        0 => String::new(),
        more => format!("; and {more} more"),
    };
    let told = errors[..errors.len().min(MAX_FINDINGS)].join("; ");
    (!errors.is_empty()).then(|| format!("{} errors ({told}{more})", errors.len()))
}
