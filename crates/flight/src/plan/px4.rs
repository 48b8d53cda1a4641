//! Items as a PX4 takes and keeps them: `parse_mavlink_mission_item` and `format_mavlink_mission_item` of v1.17.0.

use super::{Command, MavFrame, MissionItem};

/// What becomes of a parameter.
#[derive(Debug, Clone, Copy)]
enum Kept {
    /// It reads back as 0.
    Dropped,
    /// Kept as a 32-bit float.
    Float,
    /// More than 0 reads back as 1, anything else as 0.
    Positive,
    /// An angle, which reads back as 0 to 360 degrees.
    Yaw,
}

use Kept::{Dropped, Float, Positive, Yaw};

/// Parameters 1 to 4 of the commands that have a position. Of the others it keeps all as they are.
const KEPT: [(Command, [Kept; 4]); 8] = [
    (Command::NAV_WAYPOINT, [Float, Float, Dropped, Yaw]),
    (Command::NAV_LOITER_UNLIM, [Dropped, Dropped, Float, Yaw]),
    (Command::NAV_LOITER_TIME, [Float, Positive, Float, Positive]),
    (Command::NAV_LOITER_TO_ALT, [Positive, Float, Dropped, Positive]),
    (Command::NAV_LAND, [Dropped, Float, Dropped, Yaw]),
    (Command::NAV_TAKEOFF, [Dropped, Dropped, Dropped, Yaw]),
    (Command::NAV_VTOL_TAKEOFF, [Dropped, Dropped, Dropped, Yaw]),
    (Command::NAV_VTOL_LAND, [Dropped, Dropped, Dropped, Yaw]),
];

/// A parameter (index 0 to 6) of a command as a PX4 gives it back.
pub(super) fn px4_kept(command: Command, index: u8, sent: f64) -> f64 {
    let kept = KEPT.iter().find(|(known, _)| *known == command).and_then(|(_, params)| params.get(usize::from(index)));
    match kept {
        Some(Dropped) => 0.0,
        Some(Positive) => f64::from(u8::from(sent > 0.0)),
        Some(Yaw) => sent.rem_euclid(360.0),
        Some(Float) | None => sent,
    }
}

/// The item in the form that a PX4 takes: one without a position in `MAV_FRAME_MISSION`, in any other frame it refuses
/// the command. There it takes DO_LAND_START too, whose place it does not use, and would keep in 32-bit floats.
pub(super) fn px4_form(item: &MissionItem) -> MissionItem {
    let is_land_start = item.command == Command::DO_LAND_START;
    if !is_land_start && item.command.has_position() != Some(false) {
        return item.clone();
    }
    let mut params = item.params;
    if is_land_start {
        params[4..].fill(Some(0.0));
    }
    MissionItem { frame: MavFrame::Mission, params, ..item.clone() }
}
