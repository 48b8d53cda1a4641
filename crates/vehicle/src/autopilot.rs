//! What a vehicle is by its HEARTBEAT.

use crate::modes::ModeFamily;

/// `MAV_AUTOPILOT_ARDUPILOTMEGA`.
const ARDUPILOT: u8 = 3;
/// `MAV_AUTOPILOT_PX4`.
const PX4: u8 = 12;

/// The autopilot and type that a HEARTBEAT names.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct AutopilotType {
    /// `MAV_AUTOPILOT`: 3 ArduPilot, 12 PX4.
    pub autopilot: u8,
    /// `MAV_TYPE`: 1 fixed wing, 2 quadrotor, 19 to 25 VTOL.
    pub mav_type: u8,
}

impl AutopilotType {
    /// Whether it is an ArduPilot, whose missions begin with home as item 0.
    pub fn is_ardupilot(self) -> bool {
        self.autopilot == ARDUPILOT
    }

    /// Whether it is a PX4.
    pub fn is_px4(self) -> bool {
        self.autopilot == PX4
    }

    /// Whose mode numbers it uses.
    pub fn family(self) -> ModeFamily {
        ModeFamily::of(self.autopilot, self.mav_type)
    }
}
