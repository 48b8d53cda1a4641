//! Plan items with positions in 32-bit floats (MISSION_ITEM), and how much of a position they lost (at most
//! [`float_tolerance_deg`](vencejo_flight::plan::float_tolerance_deg)).

use vencejo_flight::geodesy::wrap_180_deg;
use vencejo_flight::plan::MissionItem;
use vencejo_proto::{MissionItemFloat, MissionItemInt};

/// Length of a degree of latitude on the WGS-84 equator's radius, metres (π/180 · 6,378,137).
const DEGREE_M: f64 = 111_319.49;

/// Whether x and y of an item are degrees. An unreadable item has raw numbers.
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
    // NaN becomes 0; `as` saturates, and the largest number means "unset", which an invalid value must not become.
    let coordinate = |value: f32| ((f64::from(value) * scale).round() as i32).min(i32::MAX - 1);
    (whole.x, whole.y) = (coordinate(x), coordinate(y));
    whole
}

/// Largest distance between a position sent and the same read back, metres. Item 0 is left out where it is home
/// (`first` = 1): ArduPilot has its own.
pub(super) fn largest_error_m(sent: &[MissionItem], read_back: &[MissionItem], first: usize) -> f64 {
    let distance_m = |sent: &MissionItem, kept: &MissionItem| {
        let (north, east) = (sent.lat_deg()? - kept.lat_deg()?, wrap_180_deg(sent.lon_deg()? - kept.lon_deg()?));
        Some(DEGREE_M * north.hypot(east * sent.lat_deg()?.to_radians().cos()))
    };
    let pairs = sent.iter().zip(read_back).skip(first);
    pairs.filter_map(|(sent, kept)| distance_m(sent, kept)).fold(0.0, f64::max)
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;
    use vencejo_flight::plan::{Command, PlanKind, float_tolerance_deg};
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
            prop_assert!(error <= float_tolerance_deg(sent), "{error} at {sent}");
        }
    }

    #[test]
    fn the_tolerance_is_not_idle() {
        // Somewhere the roundings add up to half of it and more, and it is about a metre where Spain is.
        let worst = (20_000_000..1_800_000_000).step_by(1_777).map(|deg_e7| {
            let sent = f64::from(deg_e7) / 1e7;
            (f64::from(kept_deg(sent as f32)) - sent).abs() / float_tolerance_deg(sent)
        });
        let worst = worst.fold(0.0, f64::max);
        assert!((0.5..=1.0).contains(&worst), "{worst}");
        assert!(
            (0.7..1.0).contains(&(DEGREE_M * float_tolerance_deg(40.33))),
            "{}",
            DEGREE_M * float_tolerance_deg(40.33)
        );
        assert!((3.5..3.7).contains(&(DEGREE_M * float_tolerance_deg(180.0))));
    }

    #[test]
    fn the_date_line_is_as_near_from_either_side() {
        let at = |lon_deg| [MissionItem::waypoint(0.0, lon_deg, 50.0)];
        for (sent, kept, apart_deg) in [(179.999_9, -179.999_9, 2e-4), (-180.0, 180.0, 0.0), (10.0, 10.000_1, 1e-4)] {
            let error_m = largest_error_m(&at(sent), &at(kept), 0);
            assert!((error_m - DEGREE_M * apart_deg).abs() < 1e-3, "{sent} {kept}: {error_m}");
        }
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
