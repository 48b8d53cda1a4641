//! A vehicle that no link reaches: what a station on board tells of its plans, its parameters and what it wrote before.

use std::sync::Arc;

use vencejo_flight::plan::{Mission, PlanKind};
use vencejo_proto::{MonoTime, StatusText};

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

    /// Its autopilot wrote this at some moment before, which tells nothing of what holds now.
    pub fn on_text_told(&mut self, text: &StatusText, at: MonoTime, now: MonoTime) {
        self.on_text_of(self.address.component, text, at, now);
    }
}
