//! What a PX4 stores of an item: `parse_mavlink_mission_item` and `format_mavlink_mission_item` of v1.17.0.

use vencejo_flight::plan::Command;
use vencejo_proto::MissionItemInt;

/// What it gives back of an item, or its `MAV_MISSION_RESULT`.
pub(super) fn stored(item: &MissionItemInt) -> Result<MissionItemInt, u8> {
    const UNSUPPORTED: u8 = 3;
    const UNSUPPORTED_FRAME: u8 = 2;
    let [p1, p2, p3, p4] = item.params;
    let flag = |value: f32| f32::from(u8::from(value > 0.0));
    let yaw = p4.to_radians().rem_euclid(std::f32::consts::TAU).to_degrees();
    let command = Command(item.command);
    let (frame, params) = match item.frame {
        0 | 3 | 5 | 6 => {
            let params = match command {
                Command::NAV_WAYPOINT => [p1, p2, 0.0, yaw],
                Command::NAV_LOITER_UNLIM => [0.0, 0.0, p3, yaw],
                Command::NAV_LOITER_TIME => [p1, flag(p2), p3, flag(p4)],
                Command::NAV_LOITER_TO_ALT => [flag(p1), p2, 0.0, flag(p4)],
                Command::NAV_LAND => [0.0, p2, 0.0, yaw],
                Command::NAV_TAKEOFF | Command::NAV_VTOL_TAKEOFF | Command::NAV_VTOL_LAND => [0.0, 0.0, 0.0, yaw],
                Command::NAV_FENCE_POLYGON_VERTEX_INCLUSION | Command::NAV_FENCE_CIRCLE_INCLUSION => {
                    [p1, 0.0, 0.0, 0.0]
                }
                Command::NAV_RALLY_POINT => [0.0; 4],
                _ => return Err(UNSUPPORTED),
            };
            (if matches!(item.frame, 0 | 5) { 5 } else { 6 }, params)
        }
        2 => match command {
            Command::DO_JUMP
            | Command::DO_CHANGE_SPEED
            | Command::DO_LAND_START
            | Command::NAV_RETURN_TO_LAUNCH
            | Command::CONDITION_DELAY => (2, item.params),
            _ => return Err(UNSUPPORTED),
        },
        _ => return Err(UNSUPPORTED_FRAME),
    };
    // Without coordinates it keeps x and y in 32-bit floats.
    let whole = |value: i32| if frame == 2 { value as f32 as i32 } else { value };
    Ok(MissionItemInt { frame, params, x: whole(item.x), y: whole(item.y), ..*item })
}
