//! A vehicle that no link reaches: what a station on board tells of its plans and parameters.

use std::sync::Arc;

use vencejo_flight::plan::{Mission, PlanKind};

use super::Vehicle;
use crate::plan_state::PlanState;
use crate::transfer::Param;

impl Vehicle {
    /// What is known on board of a plan, and its list where that is known and not empty. Only of one that is hosted
    /// ([`crate::VehicleConfig::is_hosted`]).
    pub fn on_plan_told(&mut self, kind: PlanKind, state: PlanState, list: Option<Mission>) {
        let is_read = matches!(state, PlanState::Verified { .. } | PlanState::Differs { .. });
        self.copies[kind as usize] = list.filter(|_| is_read).map(Arc::new);
        match (kind, state) {
            (PlanKind::Mission, PlanState::Verified { hash, .. } | PlanState::Differs { hash, .. }) => {
                self.tracker.on_mission(hash, false);
            }
            (PlanKind::Mission, PlanState::Empty) => self.tracker.reset(),
            _ => {}
        }
        self.tell_plan(kind, state);
    }

    /// Parameters that a station on board has read.
    pub fn on_parameters_told(&mut self, params: &[Param]) {
        params.iter().for_each(|param| self.learn(param));
    }
}
