//! What is known on the ground of one aircraft far away.

use std::collections::BTreeMap;

use vencejo_proto::{Address, MonoTime};
use vencejo_station::Telling;
use vencejo_vehicle::VehicleId;

use crate::payload::UnderWay;
use crate::plans::{PlanTold, PlansHeard};
use crate::speech::Listener;

#[derive(Default)]
pub(super) struct Known {
    pub(super) listener: Listener,
    pub(super) is_present: bool,
    /// Its id in our station, since it was taken on.
    pub(super) id: Option<VehicleId>,
    /// Its autopilot's own address, on board.
    pub(super) autopilot: Option<Address>,
    /// The boot and the epoch in which we have control.
    pub(super) lease: Option<(u64, u64)>,
    /// Whether its missed events are being asked for.
    pub(super) is_catching_up: bool,
    /// What it told of its plans, and what of that is shown here.
    pub(super) plans: PlansHeard,
    pub(super) plans_shown: [Option<PlanTold>; 3],
    /// Whether plans are being asked for.
    pub(super) is_asking_plans: bool,
    /// Orders on their way whose progress is told, by id.
    pub(super) followed: BTreeMap<Vec<u8>, Followed>,
}

/// An order whose progress is told.
pub(super) struct Followed {
    pub(super) telling: Telling,
    /// When it was heard of last.
    pub(super) heard_at: MonoTime,
}

impl Known {
    /// A state told how far orders have come.
    pub(super) fn follow(&mut self, under_way: &[UnderWay], now: MonoTime) {
        for told in under_way {
            if let Some(followed) = self.followed.get_mut(&told.id) {
                followed.heard_at = now;
                (followed.telling)(told.done, told.total);
            }
        }
    }
}
