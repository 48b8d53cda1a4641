//! Plans to and from the vehicle: which way, in which order, and whether the vehicle has what was sent.
//! (sketch: signatures only, bodies follow)
// All implement `Transfer`.
// PlanUpload::new(config: &TransferConfig, kind: PlanKind, items: Vec<MissionItemInt>, now) -> Self    Value = VerifiedPlan
//   `items` as on the wire, home included for an ArduPilot mission (Mission::to_wire(target, with_home)).
// PlanDownload::new(config, kind, now)   Value = DownloadedPlan
// PlanClear::new(config, kind, now)      Value = ()
// pub struct VerifiedPlan { pub kind: PlanKind, pub items: Vec<MissionItemInt> /* as read back, home included */, pub route: PlanRoute }
// pub struct DownloadedPlan { pub kind: PlanKind, pub items: Vec<MissionItemInt>, pub route: PlanRoute }
// pub enum PlanRoute { Ftp, Items }
