//! What a vehicle on the ground needs before a flight: a mode that arms, and a mission set to its beginning.

use std::fmt;

use crate::modes::FlightMode;
use crate::plan_state::PlanState;
use crate::telemetry::{MissionState, Telemetry};

/// What [`crate::Request::PrepareFlight`] would do to a vehicle in its present state.
///
/// After a landing in AUTO the mission stands at the landing, where an ArduPlane refuses to arm ("In landing
/// sequence"). When its mission is replaced there it changes to RTL, in which no ArduPlane arms.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct FlightPreparation {
    /// Its present mode.
    pub from: FlightMode,
    /// The mode to change to; `None` when it arms in the present one, and stays where it is when armed.
    pub mode: Option<FlightMode>,
    /// Whether its mission is set back to the beginning; false when there is no mission.
    pub rewinds_mission: bool,
    /// Whether the mission is known not to be at its beginning.
    pub has_moved_on: bool,
}

impl FlightPreparation {
    pub(crate) fn of(telemetry: &Telemetry, plan: PlanState, first_nav: u16) -> Option<Self> {
        let from = telemetry.mode()?;
        let current = telemetry.mission.map(|mission| mission.value);
        let is_beyond_first = current.is_some_and(|current| current.seq > first_nav);
        let is_complete = current.and_then(|current| current.state) == Some(MissionState::Complete);
        let told = || current.and_then(|current| current.total);
        let rewinds_mission = plan.count().or_else(told).map_or(is_beyond_first, |count| count > 0);
        Some(Self {
            from,
            mode: from.to_arm_in(),
            rewinds_mission,
            has_moved_on: rewinds_mission && (is_beyond_first || is_complete),
        })
    }

    /// Whether a flight needs it.
    pub fn is_needed(self) -> bool {
        self.mode.is_some() || self.has_moved_on
    }
}

impl fmt::Display for FlightPreparation {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if let Some(mode) = self.mode {
            write!(f, "mode {} to {mode}", self.from)?;
        }
        match (self.mode, self.rewinds_mission) {
            (None, false) => f.write_str("nothing to change"),
            (Some(_), true) => f.write_str(", the mission back to its beginning"),
            (None, true) => f.write_str("the mission back to its beginning"),
            (Some(_), false) => Ok(()),
        }
    }
}
