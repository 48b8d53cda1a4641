//! Which heartbeats are a vehicle's.

use vencejo_proto::Heartbeat;

const MAV_TYPE_GCS: u8 = 6;
const MAV_TYPE_ONBOARD_CONTROLLER: u8 = 18;
const MAV_AUTOPILOT_INVALID: u8 = 8;
const MAVLINK_VERSION: u8 = 3;

/// Whether a heartbeat is that of an autopilot: not of a ground station, camera, radio or on-board computer, and not
/// noise (`mavlink_version` is 3 in all of MAVLink 1 and 2).
pub fn is_autopilot(heartbeat: &Heartbeat) -> bool {
    heartbeat.mavlink_version == MAVLINK_VERSION
        && heartbeat.autopilot != MAV_AUTOPILOT_INVALID
        && !matches!(heartbeat.mav_type, MAV_TYPE_GCS | MAV_TYPE_ONBOARD_CONTROLLER | 26..=28 | 30..=34 | 36..=42)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn stations_computers_and_noise_are_no_vehicle() {
        let plane = Heartbeat { mav_type: 1, autopilot: 3, mavlink_version: 3, ..Heartbeat::default() };
        assert!(is_autopilot(&plane));
        // The default is a ground station's.
        assert!(!is_autopilot(&Heartbeat::default()));
        assert!(!is_autopilot(&Heartbeat { mav_type: MAV_TYPE_ONBOARD_CONTROLLER, ..plane }));
        assert!(!is_autopilot(&Heartbeat { mavlink_version: 77, ..plane }));
        assert!(!is_autopilot(&Heartbeat { mav_type: 26, ..plane }), "a gimbal");
    }
}
