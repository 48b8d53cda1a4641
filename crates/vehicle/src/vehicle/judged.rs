//! What a PX4's own checks say of a mission that it has stored. It acknowledges every mission whose items it knows, and
//! then checks whether it can fly them (`FeasibilityChecker`): one that fails counts as no mission, with its reason as an
//! event, and not always as a text.

use std::time::Duration;

use vencejo_flight::plan::PlanKind;
use vencejo_proto::MonoTime;

use super::Vehicle;
use super::operation::State;
use crate::error::VehicleError;
use crate::modes::ModeFamily;
use crate::plan_state::PlanState;
use crate::request::Reply;
use crate::telemetry::MissionState;

/// How long after the read-back its checks may take: a MISSION_CURRENT from before may be about the mission before.
const CHECKED_AFTER: Duration = Duration::from_millis(500);
/// How long a MISSION_CURRENT from after that may take: it comes twice a second.
const TOLD_WITHIN: Duration = Duration::from_millis(3_000);
/// How its reasons begin.
const REJECTED: &str = "Mission rejected";

impl Vehicle {
    /// Ends an upload: that of a mission to a PX4, which `began` then, once its checks have told.
    pub(super) fn finish_upload(&mut self, index: usize, reply: Reply, began: MonoTime, now: MonoTime) {
        let is_mission =
            matches!(reply, Reply::Plan { kind: PlanKind::Mission, state: PlanState::Verified { .. }, .. });
        let tells = self.telemetry.mission.is_none_or(|mission| mission.value.state.is_some());
        if is_mission && tells && self.family() == Some(ModeFamily::Px4) {
            let (from, until) = (now + CHECKED_AFTER, now + TOLD_WITHIN);
            self.ops[index].state = State::Judging { reply: Box::new(reply), began, from, until };
        } else {
            self.finish(index, Ok(reply));
        }
    }

    /// MISSION_CURRENT has come.
    pub(super) fn end_judging(&mut self) {
        let Some(mission) = self.telemetry.mission else { return };
        let is_told = |state: &State| matches!(state, State::Judging { from, .. } if mission.at >= *from);
        while let Some(index) = self.ops.iter().position(|op| is_told(&op.state)) {
            let State::Judging { reply, began, .. } = std::mem::replace(&mut self.ops[index].state, State::Ready)
            else {
                return;
            };
            let rejection = self.rejection(began);
            self.finish(index, rejection.map_or(Ok(*reply), Err));
        }
    }

    /// Why the mission on board cannot be flown, by the checks of a PX4. Before it knows its height it cannot check, and
    /// counts the mission as none without a text.
    fn rejection(&self, since: MonoTime) -> Option<VehicleError> {
        let mission = self.telemetry.mission?.value;
        if mission.state != Some(MissionState::NoMission) || mission.total == Some(0) {
            return None;
        }
        let mut reasons: Vec<&str> = Vec::new();
        for text in self.texts.iter().filter(|text| text.at >= since && text.text.starts_with(REJECTED)) {
            if !reasons.contains(&text.text.as_str()) {
                reasons.push(&text.text);
            }
        }
        if reasons.is_empty() && self.telemetry.home.is_none() {
            return None;
        }
        let why = if reasons.is_empty() { String::new() } else { format!(" ({})", reasons.join("; ")) };
        Some(VehicleError::InvalidValue {
            field: "the mission on board",
            value: format!("as it was sent, but rejected by the vehicle's own checks{why}"),
            expected: "one that passes them (a take-off first, a landing not steeper than FW_LND_ANG, all of it inside \
                       the fence): the vehicle does not fly this one",
        })
    }
}
