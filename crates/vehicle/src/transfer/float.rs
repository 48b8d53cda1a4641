//! Plan items with positions in 32-bit floats (MISSION_ITEM), and how much of a position they lose.
//!
//! A float has 24 binary digits. A position in degrees passes through four roundings on its way to an ArduPilot from
//! before MISSION_ITEM_INT and back (`AP_Mission::mavlink_to_mission_cmd`, `mission_cmd_to_mavlink` of ArduPlane 3.x):
//!
//! 1. to a float when it is sent: off by at most u = 2⁻²⁴ of its size,
//! 2. times 1e7 in floats: u again,
//! 3. cut to a whole number, which loses something only below 2²⁴ · 1e-7 = 1.7°: at most 1e-7°,
//! 4. divided by 1e7 in floats when it is read back: u again.
//!
//! Together 3u of the coordinate's size, and the whole number (and ours) of degE7: at latitude 40° that is 7.2e-6° or
//! 0.8 m, at longitude 180° on the equator 3.6 m. Nothing that is farther off is taken for rounding.

use vencejo_flight::plan::{Command, Difference, Field, MissionItem};
use vencejo_proto::{MissionItemFloat, MissionItemInt};

/// Half a unit in the last place of a 32-bit float, relative to its size.
const UNIT_ROUNDOFF: f64 = f32::EPSILON as f64 / 2.0;

/// Roundings to a float from sending to reading back.
const ROUNDINGS: f64 = 3.0;

/// Cut to whole degE7 by the vehicle (1), rounded to them by us (0.5), and room for the products of the roundings.
const WHOLE_NUMBERS_DEG: f64 = 1.6e-7;

/// Length of a degree of latitude on the WGS-84 equator's radius, metres (π/180 · 6,378,137).
const DEGREE_M: f64 = 111_319.49;

/// Largest difference in degrees that the roundings can make to a coordinate.
pub(super) fn tolerance_deg(coordinate_deg: f64) -> f64 {
    ROUNDINGS * UNIT_ROUNDOFF * coordinate_deg.abs() + WHOLE_NUMBERS_DEG
}

/// Whether x and y of an item are degrees. An item that cannot be read has raw numbers.
fn has_position(item: &MissionItemInt) -> bool {
    let anywhere = MissionItemInt { x: 0, y: 0, z: 0.0, params: [0.0; 4], ..*item };
    MissionItem::from_wire(&anywhere).is_ok_and(|item| item.has_position())
}

/// An item as MISSION_ITEM carries it.
pub(super) fn to_float(item: &MissionItemInt) -> MissionItemFloat {
    let has_position = has_position(item);
    let coordinate = |value: i32| if has_position { (f64::from(value) * 1e-7) as f32 } else { value as f32 };
    let MissionItemInt { target, seq, frame, command, current, autocontinue, params, x, y, z, mission_type } = *item;
    let (x, y) = (coordinate(x), coordinate(y));
    MissionItemFloat { target, seq, frame, command, current, autocontinue, params, x, y, z, mission_type }
}

/// An item from MISSION_ITEM. Numbers that no whole number can hold saturate; the reader of the list refuses them.
pub(super) fn from_float(item: &MissionItemFloat) -> MissionItemInt {
    let MissionItemFloat { target, seq, frame, command, current, autocontinue, params, x, y, z, mission_type } = *item;
    let mut whole =
        MissionItemInt { target, seq, frame, command, current, autocontinue, params, x: 0, y: 0, z, mission_type };
    let scale = if has_position(&whole) { 1e7 } else { 1.0 };
    // NaN becomes 0; `as` saturates, and the largest number means "unset", which must not come of nonsense.
    let coordinate = |value: f32| ((f64::from(value) * scale).round() as i32).min(i32::MAX - 1);
    (whole.x, whole.y) = (coordinate(x), coordinate(y));
    whole
}

/// Which differences between a list sent and a list read back are more than rounding, and than the two details of a loiter
/// and a landing that ArduPlane 3.x has no room for ([`is_of_old`]).
pub(super) fn beyond_rounding(differences: Vec<Difference>, sent: &[MissionItem]) -> Vec<Difference> {
    differences.into_iter().filter(|difference| !is_of_old(difference, sent)).collect()
}

/// Whether a difference is one that ArduPlane 3.x makes to every such item, and that leaves it the same to fly.
fn is_of_old(difference: &Difference, sent: &[MissionItem]) -> bool {
    let Some(item) = sent.get(difference.seq) else { return false };
    let (before, after) = (difference.sent.unwrap_or(0.0), difference.kept.unwrap_or(0.0));
    match difference.field {
        Field::Param(4 | 5) if item.has_position() => (before - after).abs() <= tolerance_deg(before),
        // It keeps the sense of a loiter alone, and shows "clockwise, with my own radius" as 1.
        Field::Param(2) if item.command == Command::NAV_LOITER_UNLIM => before == 0.0 && after == 1.0,
        // Whence the track after a loiter is counted, and the sense in which a landing is turned to, came later.
        Field::Param(3) if item.has_position() => after == 0.0,
        _ => false,
    }
}

/// Largest distance between a position sent and the same read back, metres. Item 0 is left out where it is home
/// (`first` = 1): ArduPilot has its own.
pub(super) fn largest_error_m(sent: &[MissionItem], read_back: &[MissionItem], first: usize) -> f64 {
    let distance_m = |sent: &MissionItem, kept: &MissionItem| {
        let (north, east) = (sent.lat_deg()? - kept.lat_deg()?, sent.lon_deg()? - kept.lon_deg()?);
        Some(DEGREE_M * north.hypot(east * sent.lat_deg()?.to_radians().cos()))
    };
    let pairs = sent.iter().zip(read_back).skip(first);
    pairs.filter_map(|(sent, kept)| distance_m(sent, kept)).fold(0.0, f64::max)
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;
    use vencejo_flight::plan::PlanKind;
    use vencejo_proto::{Address, MissionSeq};

    use super::*;

    /// What ArduPlane 3.x keeps of a coordinate, and says that it has: in 32-bit floats.
    fn kept_deg(sent: f32) -> f32 {
        let stored = (1.0e7_f32 * sent) as i32;
        stored as f32 / 1.0e7_f32
    }

    proptest! {
        #[test]
        fn no_coordinate_leaves_the_tolerance(deg_e7 in -1_800_000_000i32..=1_800_000_000) {
            let sent = f64::from(deg_e7) / 1e7;
            let item = MissionItem::waypoint(0.0, sent, 50.0);
            let wire = item.to_wire(MissionSeq(1), Address::new(1, 1), PlanKind::Mission, false);
            let float = to_float(&wire);
            let back = from_float(&MissionItemFloat { y: kept_deg(float.y), ..float });
            let error = (f64::from(back.y) / 1e7 - sent).abs();
            prop_assert!(error <= tolerance_deg(sent), "{error} at {sent}");
        }
    }

    #[test]
    fn the_tolerance_is_not_idle() {
        // Somewhere the roundings add up to half of it and more, and it is about a metre where Spain is.
        let worst = (20_000_000..1_800_000_000).step_by(1_777).map(|deg_e7| {
            let sent = f64::from(deg_e7) / 1e7;
            (f64::from(kept_deg(sent as f32)) - sent).abs() / tolerance_deg(sent)
        });
        let worst = worst.fold(0.0, f64::max);
        assert!((0.5..=1.0).contains(&worst), "{worst}");
        assert!((0.7..1.0).contains(&(DEGREE_M * tolerance_deg(40.33))), "{}", DEGREE_M * tolerance_deg(40.33));
        assert!((3.5..3.7).contains(&(DEGREE_M * tolerance_deg(180.0))));
    }

    #[test]
    fn raw_numbers_stay_what_they_are() {
        let mut wire =
            MissionItem::change_airspeed(14.0).to_wire(MissionSeq(1), Address::new(1, 1), PlanKind::Mission, false);
        (wire.x, wire.y) = (7, -8);
        let float = to_float(&wire);
        assert_eq!((float.x, float.y), (7.0, -8.0));
        assert_eq!(from_float(&float), wire);
        let nonsense = MissionItemFloat { x: f32::NAN, y: f32::INFINITY, command: Command::NAV_WAYPOINT.0, ..float };
        assert!(MissionItem::from_wire(&from_float(&nonsense)).is_err(), "infinity is no longitude");
    }
}
