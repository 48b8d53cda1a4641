//! A plane's health as ROS shows it: levels, sentences and figures.

use vencejo_vehicle::telemetry::LOST_AFTER;

use super::message::{DiagnosticStatus, KeyValue};
use super::moment::Moment;

const OK: u8 = 0;
const WARN: u8 = 1;
const ERROR: u8 = 2;
const STALE: u8 = 3;

/// What is known of a plane's heartbeat, receiver, battery and sensors; of one that is not heard any more, that alone.
pub fn of(moment: &Moment<'_>) -> Vec<DiagnosticStatus> {
    let plane = &moment.place.plane;
    let status = |what: &str, level, message: String, values: Vec<(&str, Option<String>)>| DiagnosticStatus {
        level,
        name: format!("{plane}: {what}"),
        message,
        hardware_id: plane.clone(),
        values: values
            .into_iter()
            .filter_map(|(key, value)| Some(KeyValue { key: key.into(), value: value? }))
            .collect(),
    };
    let Some(heartbeat) = moment.telemetry.heartbeat else { return Vec::new() };
    let age = heartbeat.age(moment.now);
    if age > LOST_AFTER {
        return vec![status("Heartbeat", STALE, format!("nothing heard for {:.0} s", age.as_secs_f64()), Vec::new())];
    }
    let value = heartbeat.value;
    let mut all = vec![status(
        "Heartbeat",
        OK,
        format!("{}, {}", value.mode, if value.is_armed { "armed" } else { "disarmed" }),
        vec![("Mode", Some(value.mode.to_string())), ("System status", Some(value.system_status.to_string()))],
    )];
    if let Some(gps) = moment.fresh(moment.telemetry.gps).map(|gps| gps.value) {
        let values = vec![
            ("Fix", Some(gps.fix.to_string())),
            ("Satellites", gps.satellites.map(|count| count.to_string())),
            ("HDOP", gps.hdop.map(|hdop| format!("{hdop:.2}"))),
            ("Horizontal accuracy (m)", gps.horizontal_accuracy_m.map(|metres| format!("{metres:.2}"))),
        ];
        let level = if gps.fix.is_3d() { OK } else { WARN };
        all.push(status("GPS", level, gps.fix.to_string(), values));
    }
    if let Some(power) = moment.fresh(moment.telemetry.sys_status).map(|power| power.value) {
        let bad: Vec<&str> = power.unhealthy_sensors.names().filter(|name| *name != "pre-arm check").collect();
        let values = vec![
            ("Voltage (V)", power.voltage_v.map(|volts| format!("{volts:.2}"))),
            ("Current (A)", power.current_a.map(|amperes| format!("{amperes:.2}"))),
            ("Remaining (%)", power.battery_remaining_pct.map(|percent| format!("{percent:.0}"))),
        ];
        if let Some(volts) = power.voltage_v {
            let level = if bad.contains(&"battery") { ERROR } else { OK };
            all.push(status("Battery", level, format!("{volts:.2} V"), values));
        }
        let values = vec![
            ("Ready to arm", power.is_ready_to_arm.map(|is_ready| is_ready.to_string())),
            ("Load (%)", power.load_pct.map(|percent| format!("{percent:.0}"))),
        ];
        let (level, message) = if bad.is_empty() {
            (OK, "all sensors in use work".to_owned())
        } else {
            (ERROR, format!("these do not work: {}", bad.join(", ")))
        };
        all.push(status("Sensors", level, message, values));
    }
    all
}
