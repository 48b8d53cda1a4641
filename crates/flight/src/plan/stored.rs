//! Items as an ArduPlane stores them.
//!
//! ArduPilot packs an item into 15 bytes: most parameters are cut to whole numbers or dropped. The rules
//! are data, in the table of [`crate::plan::command`]; this file applies them.

use crate::plan::command::{Category, Storage};
use crate::plan::item::{MavFrame, MissionItem, f64_from_f32};

/// The item as ArduPlane stores it and returns it on request.
///
/// A command that ArduPlane refuses is returned unchanged.
pub fn ardupilot_stored(item: &MissionItem) -> MissionItem {
    let Some(info) = item.command.info() else { return item.clone() };
    let mut params = [None; 7];
    for (index, (kept, param)) in params.iter_mut().zip(info.params).enumerate() {
        let sent = match item.params[index] {
            Some(value) => value,
            None if param.storage == Storage::YawSign => 1.0, // unset heading: to the right
            None => 0.0,
        };
        *kept = Some(match param.storage {
            Storage::DegE7 => (sent * 1e7).round() / 1e7,
            // cut in 32-bit floats as the vehicle does, given back in decimals
            Storage::Centimetres => f64::from((sent as f32 * 100.0) as i32) / 100.0,
            // x and y are whole numbers on the wire, wider than a float can hold
            Storage::LowU8 => f64::from(sent.round() as i32 as u8),
            Storage::LowI16 => f64::from(sent.round() as i32 as i16),
            storage => f64_from_f32(storage.keep(sent as f32)),
        });
    }
    let in_list = matches!(info.category, Category::Fence | Category::Rally);
    let frame = match item.frame {
        _ if !info.has_position || info.category == Category::Fence => MavFrame::Global,
        MavFrame::Mission => MavFrame::Global,
        frame => frame,
    };
    MissionItem { command: item.command, frame, params, autocontinue: !in_list }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plan::item::MissionItemInt;
    use crate::plan::{Command, Support};
    use crate::plan::{Keeping, PlanKind, plans_equal_as_stored};
    use vencejo_proto::{Address, MissionSeq};

    const TARGET: Address = Address::new(1, 1);
    const FACTS: &str = include_str!("../../../../tests/fixtures/facts/arduplane-mission-commands.json");

    fn sample(command: u16) -> MissionItemInt {
        MissionItemInt {
            target: TARGET,
            seq: 1,
            frame: 3,
            command,
            current: 0,
            autocontinue: 1,
            params: [1.25, 2.5, 3.75, 4.5],
            x: 403_355_555,
            y: -37_966_666,
            z: 77.77,
            mission_type: 0,
        }
    }

    #[test]
    fn every_recorded_command_is_stored_as_the_vehicle_stored_it() {
        let facts: serde_json::Value = serde_json::from_str(FACTS).unwrap();
        let (mut accepted, mut refused) = (0, 0);
        for fact in facts["commands"].as_array().unwrap() {
            let number = u16::try_from(fact["command"].as_u64().unwrap()).unwrap();
            let command = Command(number);
            assert_eq!(command.name(), fact["name"].as_str(), "{number}");
            let is_taken = command.info().is_some_and(|info| info.support != Support::List);
            assert_eq!(is_taken, fact["accepted"].as_bool().unwrap(), "{number}");
            if !is_taken {
                refused += 1;
                continue;
            }
            accepted += 1;
            let back = &fact["read_back"];
            let float = |name: &str| back[name].as_f64().unwrap() as f32;
            let int = |name: &str| i32::try_from(back[name].as_i64().unwrap()).unwrap();
            let recorded = MissionItemInt {
                frame: int("frame") as u8,
                autocontinue: int("autocontinue") as u8,
                params: ["param1", "param2", "param3", "param4"].map(float),
                x: int("x"),
                y: int("y"),
                z: float("z"),
                ..sample(number)
            };
            let sent = MissionItem::from_wire(&sample(number)).unwrap();
            let stored = ardupilot_stored(&sent);
            let wire = stored.to_wire(MissionSeq(1), TARGET, PlanKind::Mission, false);
            assert_eq!(wire, recorded, "{command}");
            // and the comparison used after an upload agrees
            let home = MissionItem::waypoint(0.0, 0.0, 0.0);
            let read_back = MissionItem::from_wire(&recorded).unwrap();
            let same =
                plans_equal_as_stored(&[home.clone(), sent], &[home, read_back], PlanKind::Mission, Keeping::ARDUPILOT);
            assert_eq!(same, Ok(()), "{command}");
        }
        assert_eq!((accepted, refused), (60, 72));
    }

    #[test]
    fn storing_twice_changes_nothing() {
        for info in crate::plan::command::COMMANDS {
            for scale in [0.0, -1.0, 0.3, 1.0, 7.7, 90.0] {
                let params = [1.25 * scale, 2.5 * scale, 37.5 * scale, 4.5 * scale];
                let item = MissionItem::at(info.command, params, 40.5, -3.7, 12.345 * scale);
                let once = ardupilot_stored(&item);
                let twice = ardupilot_stored(&once);
                // cutting to hundredths can take one more each time, as on the vehicle
                for (index, param) in info.params.iter().enumerate() {
                    let step = match param.storage {
                        Storage::Centimetres | Storage::CentiU16 => 0.010_1,
                        _ => 0.0,
                    };
                    let (once, twice) = (once.params[index].unwrap(), twice.params[index].unwrap());
                    assert!((twice - once).abs() <= step, "{} x {scale}: {once}, {twice}", info.name);
                }
            }
        }
    }

    #[test]
    fn the_height_is_cut_to_centimetres() {
        let alt = |alt_m| ardupilot_stored(&MissionItem::waypoint(40.0, -3.0, alt_m)).alt_m();
        assert_eq!(alt(77.77), Some(77.76)); // 77.77 is 7776.9995 cm in 32-bit floats
        assert_eq!(alt(600.09), Some(600.09));
        assert_eq!(alt(100.0), Some(100.0));
        assert_eq!(alt(-12.349), Some(-12.34));
    }

    #[test]
    fn frames_without_meaning_read_back_as_zero() {
        let mut item = MissionItem::waypoint(40.0, -3.0, 50.0);
        for (sent, kept) in [
            (MavFrame::Mission, MavFrame::Global),
            (MavFrame::Global, MavFrame::Global),
            (MavFrame::GlobalTerrainAlt, MavFrame::GlobalTerrainAlt),
        ] {
            item.frame = sent;
            assert_eq!(ardupilot_stored(&item).frame, kept);
        }
        assert_eq!(ardupilot_stored(&MissionItem::return_to_launch()).frame, MavFrame::Global);
    }

    #[test]
    fn fence_and_rally_items_are_stored_without_what_they_do_not_use() {
        let mut corner =
            MissionItem::at(Command::NAV_FENCE_POLYGON_VERTEX_INCLUSION, [4.0, 0.0, 0.0, 0.0], 40.0, -3.0, 9.0);
        corner.frame = MavFrame::GlobalRelativeAlt;
        let kept = ardupilot_stored(&corner);
        assert_eq!((kept.frame, kept.params[6], kept.autocontinue), (MavFrame::Global, Some(0.0), false));
        let rally = MissionItem::at(Command::NAV_RALLY_POINT, [0.0; 4], 40.0, -3.0, 60.7);
        let kept = ardupilot_stored(&rally);
        assert_eq!((kept.frame, kept.alt_m()), (MavFrame::GlobalRelativeAlt, Some(60.0)));
    }
}
