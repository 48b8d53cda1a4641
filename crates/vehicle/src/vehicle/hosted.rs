//! A remote vehicle: reports of its station on board about plans, parameters and earlier texts.

use std::sync::Arc;

use vencejo_flight::plan::{Mission, PlanKind};
use vencejo_proto::{MonoTime, StatusText};

use super::Vehicle;
use crate::plan_state::PlanState;
use crate::transfer::Param;

impl Vehicle {
    /// The state of a plan as known on board, and its items where they are known and not empty. Only for a hosted
    /// vehicle ([`crate::VehicleConfig::is_hosted`]).
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
        match params {
            [param] => self.learn_one(param),
            params => params.iter().for_each(|param| self.learn(param)),
        }
    }

    /// A text that its autopilot wrote at an earlier time, which says nothing about the present.
    pub fn on_text_told(&mut self, text: &StatusText, at: MonoTime, now: MonoTime) {
        self.on_text_of(self.address.component, text, at, now);
    }
}
