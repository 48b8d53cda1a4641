//! The events of PX4 (v1.17) that say why it does not arm, and why it rejects a mission: their ids by their names, and
//! their texts with the arguments in order.

/// `MAV_COMP_ID_AUTOPILOT1` as the component of an event's id.
const AUTOPILOT: u32 = 1 << 24;

/// The id of an event of the autopilot: 24 bits of the FNV-1a hash of its name (`libevents`, `event_id_calculator`).
pub(crate) const fn id(name: &str) -> u32 {
    let (bytes, mut hash, mut at) = (name.as_bytes(), 0x811c_9dc5_u32, 0);
    while at < bytes.len() {
        hash = (hash ^ bytes[at] as u32).wrapping_mul(0x0100_0193);
        at += 1;
    }
    AUTOPILOT | hash & 0xff_ffff
}

/// Begins a report of all checks that fail.
pub(super) const ARMING_SUMMARY: u32 = id("commander_arming_check_summary");
/// Ends it.
pub(super) const HEALTH_SUMMARY: u32 = id("commander_health_summary");

/// A text with its arguments: `{u8}`, `{i16}`, `{u16}`, `{u32}`, `{f32}`, as they follow one another.
type Named = (u32, &'static str);

/// Reasons to reject a mission (`FeasibilityChecker.cpp`, `mission_feasibility_checker.cpp`).
pub(super) const REJECTIONS: &[Named] = &[
    (id("navigator_mis_no_home_rel_alt"), "no home position, and item {i16} has an altitude above home"),
    (id("navigator_mis_unsup_cmd"), "item {u16}: command {u16} is not supported"),
    (id("navigator_mis_starts_w_landing"), "it begins with the landing"),
    (id("navigator_mis_starts_w_landing2"), "it begins with the landing"),
    (id("navigator_mis_takeoff_too_low"), "the take-off ends too low, at least {f32} m above home are needed"),
    (id("navigator_mis_takeoff_not_first"), "the take-off is not its first item"),
    (id("navigator_mis_takeoff_missing"), "it has no take-off (MIS_TKO_LAND_REQ)"),
    (id("navigator_mis_land_missing"), "it has no landing (MIS_TKO_LAND_REQ)"),
    (id("feasibility_mis_in_air_landing_req"), "it has no landing (MIS_TKO_LAND_REQ)"),
    (id("navigator_mis_takeoff_or_land_missing"), "take-off or landing is missing (MIS_TKO_LAND_REQ)"),
    (id("navigator_mis_add_land_or_rm_to"), "it has a take-off, but no landing (MIS_TKO_LAND_REQ)"),
    (id("navigator_mis_add_to_or_rm_land"), "it has a landing, but no take-off (MIS_TKO_LAND_REQ)"),
    (id("navigator_mis_approach_wp_below_land"), "the item before the landing is not above the landing point"),
    (id("navigator_mis_land_wp_inside_orbit_radius"), "the landing point lies within the circle before it"),
    (
        id("navigator_mis_unsupported_landing_approach_wp"),
        "the item before the landing is neither NAV_WAYPOINT nor NAV_LOITER_TO_ALT",
    ),
    (id("navigator_mis_glide_slope_too_steep"), "the landing is steeper than {u8}.{u8} degrees (FW_LND_ANG)"),
    (
        id("navigator_mis_correct_glide_slope"),
        "begin the final approach at most {u32} m above the landing point, or at least {u32} m before it",
    ),
    (id("navigator_mis_multiple_land"), "more than one DO_LAND_START"),
    (id("navigator_mis_land_before_rtl"), "DO_LAND_START before a return to launch"),
    (id("navigator_mis_invalid_land"), "DO_LAND_START behind the landing"),
    (id("navigator_mis_vtol_items"), "items of a VTOL, which the vehicle is not"),
    (id("navigator_mis_wp_gate_too_close"), "a waypoint {f32} m from its gate, at least {f32} m are needed"),
    (id("navigator_mis_first_wp_far"), "its first position is {u32} m from home (MIS_DIST_1WP)"),
    (id("navigator_mis_geofence_violation"), "item {i16} lies outside of the fence"),
    (id("navigator_mis_geofence_no_home"), "the fence needs a home position"),
    (id("navigator_mis_geofence_no_home2"), "the fence needs a home position"),
    (id("navigator_mis_no_pos_lock"), "the vehicle does not know its position yet"),
    (id("mission_failed_to_read_wp"), "item {u16} could not be read from its memory"),
];

/// Checks before arming (`HealthAndArmingChecks/checks`). Their first arguments are the modes that they keep from being
/// armed in, and a component. The words lead to the remedies of [`crate::Refusal`].
pub(super) const CHECKS: &[Named] = &[
    (id("check_accel_missing"), "Accel Sensor {u8} missing"),
    (id("check_accel_no_data"), "No valid data from Accel {u8}"),
    (id("check_accel_not_calibrated"), "Accel {u8} uncalibrated"),
    (id("check_imu_accel_inconsistent"), "Accel {u8} inconsistent"),
    (id("check_estimator_high_accel_bias"), "High Accelerometer Bias"),
    (id("check_gyro_missing"), "Gyro Sensor {u8} missing"),
    (id("check_gyro_no_data"), "No valid data from Gyro {u8}"),
    (id("check_gyro_not_calibrated"), "Gyro {u8} uncalibrated"),
    (id("check_imu_gyro_inconsistent"), "Gyro {u8} inconsistent"),
    (id("check_estimator_high_gyro_bias"), "High Gyro Bias"),
    (id("check_modes_angular_velocity"), "Gyro: no valid rates of turn"),
    (id("check_mag_missing"), "Compass Sensor {u8} missing"),
    (id("check_mag_no_data"), "No valid data from Compass {u8}"),
    (id("check_mag_not_calibrated"), "Compass {u8} uncalibrated"),
    (id("check_mag_fault"), "Compass {u8} fault"),
    (id("check_mag_consistency"), "Compasses {i16}° inconsistent"),
    (id("check_mag_sys_has_mag_missing"), "Found {u8} compass (required: {u8})"),
    (id("check_estimator_mag_fault"), "Compass is no longer used"),
    (id("check_estimator_mag_interference"), "Mag field disturbed: strong magnetic interference"),
    (id("check_baro_missing"), "barometer {u8} missing"),
    (id("check_baro_no_data"), "No valid data from Baro {u8}"),
    (id("check_airspeed_invalid"), "Airspeed invalid"),
    (id("check_airspeed_no_data"), "Airspeed: no data"),
    (id("check_airspeed_too_high"), "Airspeed too high"),
    (id("check_distance_sensor_missing"), "Distance Sensor {u8} missing"),
    (id("check_distance_sensor_invalid"), "No valid distance sensor {u8} data"),
    (id("check_optical_sensor_missing"), "Optical flow sensor missing"),
    (id("check_optical_flow_sensor_invalid"), "No valid optical flow data"),
    (id("check_estimator_gps_fix_too_low"), "GPS: no 3D fix"),
    (id("check_estimator_gps_num_sats_too_low"), "GPS accuracy: too few satellites"),
    (id("check_estimator_gps_pdop_too_high"), "GPS accuracy: PDOP too high"),
    (id("check_estimator_gps_hor_pos_err_too_high"), "GPS accuracy: horizontal error too large"),
    (id("check_estimator_gps_vert_pos_err_too_high"), "GPS accuracy: vertical error too large"),
    (id("check_estimator_gps_speed_acc_too_low"), "GPS accuracy: error of the speed too large"),
    (id("check_estimator_gps_hor_pos_drift_too_high"), "GPS accuracy: the horizontal position drifts"),
    (id("check_estimator_gps_vert_pos_drift_too_high"), "GPS accuracy: the altitude drifts"),
    (id("check_estimator_gps_hor_speed_drift_too_high"), "GPS accuracy: the horizontal speed drifts"),
    (id("check_estimator_gps_vert_speed_drift_too_high"), "GPS accuracy: the vertical speed drifts"),
    (id("check_estimator_gps_generic"), "GPS accuracy: poor quality"),
    (id("check_estimator_gps_not_fusing"), "GPS is not used by the position estimate"),
    (id("check_estimator_gps_jamming_critical"), "GPS is jammed"),
    (id("check_estimator_gps_spoofed"), "GPS signal is spoofed"),
    (id("check_estimator_gnss_fault"), "GPS heading is not reliable"),
    (id("check_estimator_missing_data"), "EKF: no data yet"),
    (id("check_estimator_heading_not_stable"), "heading estimate not stable"),
    (id("check_estimator_hgt_not_stable"), "height estimate not stable"),
    (id("check_estimator_hor_pos_not_stable"), "horizontal position unstable"),
    (id("check_estimator_hor_vel_not_stable"), "horizontal velocity unstable"),
    (id("check_estimator_vert_vel_not_stable"), "vertical velocity unstable"),
    (id("check_estimator_low_position_accuracy"), "Position estimate has low accuracy"),
    (id("check_modes_attitude"), "No attitude estimate"),
    (id("check_modes_local_pos"), "No position estimate"),
    (id("check_modes_global_pos"), "No position estimate in latitude and longitude"),
    (id("check_modes_local_alt"), "No position estimate: altitude unknown"),
    (id("check_system_no_global_pos"), "No position estimate in latitude and longitude (COM_ARM_WO_GPS)"),
    (id("check_modes_home_position"), "Home not set"),
    (id("check_system_no_home_pos"), "Home not set"),
    (id("check_modes_mission"), "No mission on board that it can fly"),
    (id("check_modes_offboard_signal"), "OFFBOARD: nothing steers it"),
    (id("check_modes_manual_control"), "RC: no control input"),
    (id("check_modes_cannot_takeoff"), "This mode is not armable"),
    (id("check_external_modes_unavailable"), "The mode is not registered"),
    (id("check_external_modes_unresponsive"), "The mode does not respond"),
    (id("check_mission_failure"), "Mission cannot be completed"),
    (id("check_navigator_failure_hagl"), "Waypoint above the greatest height over ground"),
    (id("check_battery_missing"), "Battery {u8} missing"),
    (id("check_battery_disconnected"), "Battery {u8} disconnected"),
    (id("check_battery_unhealthy"), "Battery unhealthy"),
    (id("check_battery_fault"), "Battery {u8} has a fault"),
    (id("check_battery_low"), "Low battery"),
    (id("check_battery_critical"), "Critical battery"),
    (id("check_battery_emergency"), "Emergency battery level"),
    (id("check_battery_rem_flight_time_low"), "Battery: the remaining flight time is low"),
    (id("check_avionics_power_low"), "Board voltage low: {f32} V"),
    (id("check_avionics_power_high"), "Board voltage high: {f32} V"),
    (id("check_avionics_power_missing"), "Board voltage: power module not connected"),
    (id("check_avionics_power_redundancy"), "Power redundancy not met: {u8} of {u8}"),
    (id("check_missing_system_power"), "Board voltage: unknown"),
    (id("check_power_oc_periph"), "Overcurrent of the 5 V supply of the peripherals"),
    (id("check_power_oc_hipower"), "Overcurrent of the 5 V supply for high power"),
    (id("check_escs_offline"), "ESC {u8} offline"),
    (id("check_escs_fault"), "ESC {u8} has a fault"),
    (id("check_escs_telem_missing"), "ESC telemetry missing"),
    (id("check_failure_detector_arm_esc"), "ESC failure detected"),
    (id("check_failure_detector_motor"), "Motor failure detected"),
    (id("check_failure_detector_imbalanced_prop"), "Imbalanced propeller detected"),
    (id("check_failure_detector_roll"), "Attitude failure (roll)"),
    (id("check_failure_detector_pitch"), "Attitude failure (pitch)"),
    (id("check_failure_detector_alt"), "Altitude failure"),
    (id("check_failure_detector_ext"), "triggered by external system"),
    (id("check_rc_min_too_small"), "RC{u8}_MIN is below {u16}"),
    (id("check_rc_max_too_high"), "RC{u8}_MAX is above {u16}"),
    (id("check_rc_trim_too_small"), "RC{u8}_TRIM is below MIN ({i16} < {i16})"),
    (id("check_rc_trim_too_high"), "RC{u8}_TRIM is above MAX ({i16} > {i16})"),
    (id("check_rc_dl_no_dllink"), "No connection to the ground station (NAV_DLL_ACT)"),
    (id("check_man_control_kill_engaged"), "Kill switch engaged"),
    (id("check_man_control_rtl_engaged"), "RTL switch engaged"),
    (id("check_man_control_landing_gear_up"), "Landing gear switch set in UP position"),
    (id("check_system_safety_button"), "Press safety button first"),
    (id("check_armable_configuration"), "Vehicle is in safety configuration"),
    (id("check_system_arm_auth_failed"), "Arm authorisation denied"),
    (id("check_system_usb_connected"), "USB is connected"),
    (id("check_system_flight_term_active"), "Flight termination active"),
    (id("check_system_vtol_in_transition"), "Vehicle is in transition state"),
    (id("check_system_vtol_in_fw_mode"), "Vehicle is not in multicopter mode"),
    (id("check_vtol_fixed_wing_system_failure"), "VTOL fixed-wing system failure detected"),
    (id("check_gf_no_home"), "Fence: its return needs a home position"),
    (id("check_gf_violation_max_alt"), "Fence: above the greatest altitude"),
    (id("check_gf_violation_max_hor_dist"), "Fence: beyond the greatest distance from home"),
    (id("check_gf_violation_custom_gf"), "Fence: near or outside of it"),
    (id("check_flight_time_limit"), "Maximum flight time reached"),
    (id("check_wind_too_high"), "Wind of {f32} m/s is above the limit"),
    (id("check_cpuload_too_high"), "CPU load too high: {f32} %"),
    (id("check_ram_usage_too_high"), "RAM usage too high: {f32} %"),
    (id("check_missing_cpuload"), "No CPU and RAM load information"),
    (id("check_missing_fmu_sdcard"), "SD card missing"),
    (id("check_hardfault_present"), "SD card: crash dumps are present"),
    (id("check_parachute_missing"), "Parachute system missing"),
    (id("check_parachute_unhealthy"), "Parachute system not ready"),
    (id("check_open_drone_id_missing"), "Open Drone ID system missing"),
    (id("check_open_drone_id_unhealthy"), "Open Drone ID system not ready"),
];

/// The text of an event in a table, with its arguments, little-endian and without padding.
pub(super) fn text_of(table: &[Named], event: u32, arguments: &[u8]) -> Option<String> {
    let (_, text) = table.iter().find(|(known, _)| *known == event)?;
    Some(filled(text, arguments))
}

fn filled(text: &str, mut arguments: &[u8]) -> String {
    let mut take = |size: usize| {
        let mut bytes = [0; 4];
        let (head, rest) = arguments.split_at(size.min(arguments.len()));
        bytes[..head.len()].copy_from_slice(head);
        arguments = rest;
        u32::from_le_bytes(bytes)
    };
    let mut pieces = text.split(['{', '}']);
    let mut whole = pieces.next().unwrap_or_default().to_owned();
    while let Some(kind) = pieces.next() {
        whole += &match kind {
            "u8" => take(1).to_string(),
            "u16" => take(2).to_string(),
            "i16" => (take(2) as u16 as i16).to_string(),
            "u32" => take(4).to_string(),
            _ => format!("{:.1}", f32::from_bits(take(4))),
        };
        whole += pieces.next().unwrap_or_default();
    }
    whole
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use super::*;

    #[test]
    fn ids_are_those_that_px4_sends() {
        // Recorded of v1.17.0.
        assert_eq!(id("navigator_mis_glide_slope_too_steep"), 0x0148_d925);
        assert_eq!(id("navigator_mis_correct_glide_slope"), 0x01b0_9425);
        assert_eq!((ARMING_SUMMARY, HEALTH_SUMMARY), (0x01a8_93e0, 0x011d_3727));
        assert_eq!(id("check_modes_mission"), 0x0105_c2d9);
        let ids: BTreeSet<_> = CHECKS.iter().chain(REJECTIONS).map(|(id, _)| id).collect();
        assert_eq!(ids.len(), CHECKS.len() + REJECTIONS.len());
    }

    #[test]
    fn arguments_are_filled_in() {
        let steep = id("navigator_mis_correct_glide_slope");
        let text = text_of(REJECTIONS, steep, &[0x13, 0, 0, 0, 0xf1, 3, 0, 0]).expect("known");
        assert_eq!(text, "begin the final approach at most 19 m above the landing point, or at least 1009 m before it");
        assert_eq!(
            filled("RC{u8}: {i16} < {u16}, {f32} V", &[3, 0xfe, 0xff, 16, 39, 0, 0, 0xa0, 0x40]),
            "RC3: -2 < 10000, 5.0 V"
        );
        assert_eq!(filled("Battery {u8} missing", &[]), "Battery 0 missing");
        for (_, text) in CHECKS.iter().chain(REJECTIONS) {
            let kinds: Vec<_> = text.split(['{', '}']).skip(1).step_by(2).collect();
            assert!(kinds.iter().all(|kind| ["u8", "u16", "i16", "u32", "f32"].contains(kind)), "{text}");
        }
    }
}
