//! The check of a plan before it is uploaded, whichever way it came.

use vencejo_flight::checks::Severity;
use vencejo_flight::plan::{Mission, Plan, PlanKind};
use vencejo_proto::Counted;
use vencejo_station::VehicleHandle;

/// Most findings in the text; of more, their number.
const MAX_FINDINGS: usize = 5;

/// The errors of a list, by the known parameters of its vehicle and the wind: `2 errors (…; …)`, or `None`. May take
/// some tenths of a second.
pub(super) fn plan_errors(vehicle: &VehicleHandle, kind: PlanKind, list: Mission) -> Option<String> {
    // One that is no list of its kind is refused when it is encoded.
    let found = vehicle.check_upload(kind, &Plan::from_list(kind, list).ok()?, None);
    let errors: Vec<_> =
        found.iter().filter(|finding| finding.severity == Severity::Error).map(ToString::to_string).collect();
    let more = match errors.len().saturating_sub(MAX_FINDINGS) {
        0 => String::new(),
        more => format!("; and {more} more"),
    };
    let told = errors[..errors.len().min(MAX_FINDINGS)].join("; ");
    (!errors.is_empty()).then(|| format!("{} ({told}{more})", Counted(errors.len(), "error")))
}
