//! What our own HEARTBEAT says. Its owner sends it once a second, from the loop that does the work, so that it stops
//! when that loop does: the vehicle's ground-station failsafe counts on it.

use std::time::Duration;

use vencejo_proto::{Heartbeat, Message};

/// How often a heartbeat is sent.
pub const HEARTBEAT_PERIOD: Duration = Duration::from_secs(1);

const MAV_TYPE_GCS: u8 = 6;
const MAV_TYPE_ONBOARD_CONTROLLER: u8 = 18;
const MAV_AUTOPILOT_INVALID: u8 = 8;
const MAV_STATE_ACTIVE: u8 = 4;
const MAVLINK_VERSION: u8 = 3;

/// The heartbeat of a ground station. On board it is sent only while an operator's session is alive.
pub fn ground_station() -> Message {
    heartbeat(MAV_TYPE_GCS)
}

/// The heartbeat of a computer on board, which no failsafe counts as a ground station.
pub fn onboard_computer() -> Message {
    heartbeat(MAV_TYPE_ONBOARD_CONTROLLER)
}

fn heartbeat(mav_type: u8) -> Message {
    Message::Heartbeat(Heartbeat {
        custom_mode: 0,
        mav_type,
        autopilot: MAV_AUTOPILOT_INVALID,
        base_mode: 0,
        system_status: MAV_STATE_ACTIVE,
        mavlink_version: MAVLINK_VERSION,
    })
}

/// Whether a heartbeat is that of an autopilot, the heart of a vehicle: not a ground station, camera, radio or
/// on-board computer, and not noise (`mavlink_version` is 3 in all of MAVLink 1 and 2).
pub fn is_autopilot(heartbeat: &Heartbeat) -> bool {
    heartbeat.mavlink_version == MAVLINK_VERSION
        && heartbeat.autopilot != MAV_AUTOPILOT_INVALID
        && !matches!(heartbeat.mav_type, MAV_TYPE_GCS | MAV_TYPE_ONBOARD_CONTROLLER | 26..=28 | 30..=34 | 36..=42)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn our_heartbeats_are_no_vehicle() {
        for message in [ground_station(), onboard_computer()] {
            let Message::Heartbeat(heartbeat) = message else { panic!("{message:?}") };
            assert!(!is_autopilot(&heartbeat));
            assert!(!heartbeat.is_armed());
        }
        let plane = Heartbeat { mav_type: 1, autopilot: 3, mavlink_version: 3, ..Heartbeat::default() };
        assert!(is_autopilot(&plane));
        assert!(!is_autopilot(&Heartbeat { mavlink_version: 77, ..plane }));
        assert!(!is_autopilot(&Heartbeat { mav_type: 26, ..plane }), "a gimbal");
    }
}
