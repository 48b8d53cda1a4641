//! What an ArduPlane keeps of an item, and the comparison of a plan that was sent with the one read back.
//!
//! ArduPilot packs an item into 15 bytes: most parameters are cut to whole numbers or dropped. The rules
//! are data, in the table of [`crate::plan::command`]; this file applies them.

use crate::plan::command::{Category, Command, Storage};
use crate::plan::item::{MavFrame, MissionItem, PARAM_NAMES, f64_from_f32};

/// Largest difference of a float field that is taken for the same value, relative to its size: a few
/// units in the last place of a 32-bit float, for a vehicle that scales by 0.01 in another order.
const FLOAT_TOLERANCE: f64 = 4.0 * (f32::EPSILON as f64);

/// Largest difference of a height that is taken for the same, metres: vehicles keep whole centimetres and
/// differ in whether they cut or round.
const ALT_TOLERANCE_M: f64 = 0.010_5;

/// What ArduPlane keeps of an item and gives back when asked.
///
/// A command that ArduPlane refuses is returned as it is: there is nothing to compare it with.
#[must_use]
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

/// A field of an item.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Field {
    /// The item is missing or one too many.
    Item,
    /// `MAV_CMD`.
    Command,
    /// `MAV_FRAME`.
    Frame,
    /// Parameter 1 to 4, x, y or z: index 0 to 6.
    Param(u8),
}

impl std::fmt::Display for Field {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Self::Item => "item",
            Self::Command => "command",
            Self::Frame => "frame",
            Self::Param(index) => PARAM_NAMES.get(usize::from(*index)).unwrap_or(&"param"),
        })
    }
}

/// One way in which the vehicle's plan is not the one that was sent.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Difference {
    /// Place in the list, from 0 (on ArduPilot item 0 of a mission is home).
    pub seq: usize,
    /// What differs.
    pub field: Field,
    /// What should be there, after ArduPlane's rounding; `None`: nothing.
    pub sent: Option<f64>,
    /// What is there; `None`: nothing.
    pub kept: Option<f64>,
}

impl std::fmt::Display for Difference {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self { seq, field, sent, kept } = self;
        match (field, sent, kept) {
            (Field::Item, Some(command), None) => {
                write!(f, "item {seq} ({}) is missing on the vehicle", Command(*command as u16))
            }
            (Field::Item, _, Some(command)) => {
                write!(f, "item {seq} ({}) is on the vehicle but was not sent", Command(*command as u16))
            }
            (Field::Command, Some(sent), Some(kept)) => {
                write!(f, "item {seq} is {} instead of {}", Command(*kept as u16), Command(*sent as u16))
            }
            _ => {
                let show = |value: &Option<f64>| value.map_or_else(|| "unset".to_owned(), |v| v.to_string());
                write!(f, "item {seq}: {field} is {} instead of {}", show(kept), show(sent))
            }
        }
    }
}

/// Compares a list that was sent with the list read back, item by item, as ArduPlane stores it.
///
/// Both lists are as on the wire: for a mission item 0 is home, of which only the presence is compared,
/// because ArduPilot keeps its own. `autocontinue` is not compared: ArduPilot ignores it. Whole numbers
/// and coordinates must be exact, heights equal to a centimetre, other floats to a few units in their last
/// place.
///
/// # Errors
/// Every difference found, in order of item and field.
pub fn plans_equal_as_stored(
    sent: &[MissionItem],
    read_back: &[MissionItem],
    kind: crate::plan::PlanKind,
) -> Result<(), Vec<Difference>> {
    let mut differences = Vec::new();
    for seq in 0..sent.len().max(read_back.len()) {
        let number = |item: &MissionItem| f64::from(item.command.0);
        let mut differ = |field, sent, kept| differences.push(Difference { seq, field, sent, kept });
        let (sent, kept) = match (sent.get(seq), read_back.get(seq)) {
            (Some(sent), Some(kept)) => (ardupilot_stored(sent), kept),
            (sent, kept) => {
                differ(Field::Item, sent.map(number), kept.map(number));
                continue;
            }
        };
        if kind == crate::plan::PlanKind::Mission && seq == 0 {
            continue;
        }
        if sent.command != kept.command {
            differ(Field::Command, Some(number(&sent)), Some(number(kept)));
            continue;
        }
        if sent.frame != kept.frame {
            let frame = |item: &MissionItem| Some(f64::from(item.frame.number()));
            differ(Field::Frame, frame(&sent), frame(kept));
        }
        let has_position = kept.has_position();
        for index in 0..7 {
            let (sent, kept) = (sent.params[index], kept.params[index]);
            if !same_value(index, has_position, sent.unwrap_or(0.0), kept.unwrap_or(0.0)) {
                differ(Field::Param(index as u8), sent, kept);
            }
        }
    }
    if differences.is_empty() { Ok(()) } else { Err(differences) }
}

fn same_value(index: usize, has_position: bool, sent: f64, kept: f64) -> bool {
    let tolerance = match index {
        4 | 5 => 0.5e-7, // half a unit of the wire, whether degrees or a whole number
        6 if has_position => ALT_TOLERANCE_M,
        _ => FLOAT_TOLERANCE * sent.abs().max(1.0),
    };
    (sent - kept).abs() <= tolerance
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plan::PlanKind;
    use crate::plan::item::MissionItemInt;
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
            assert_eq!(command.is_mission_command(), fact["accepted"].as_bool().unwrap(), "{number}");
            if !command.is_mission_command() {
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
            let same = plans_equal_as_stored(&[home.clone(), sent], &[home, read_back], PlanKind::Mission);
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
    fn each_difference_is_named() {
        let home = MissionItem::waypoint(0.0, 0.0, 0.0);
        let moved_home = MissionItem::waypoint(40.0, -3.0, 600.0);
        let sent = [home.clone(), MissionItem::waypoint(40.0, -3.0, 50.0), MissionItem::return_to_launch()];
        let mut back = [moved_home, ardupilot_stored(&sent[1]), ardupilot_stored(&sent[2])];
        assert_eq!(plans_equal_as_stored(&sent, &back, PlanKind::Mission), Ok(()));

        back[1].params[4] = Some(40.000_000_1);
        back[1].frame = MavFrame::Global;
        back[2].command = Command::NAV_LOITER_UNLIM;
        let found = plans_equal_as_stored(&sent, &back, PlanKind::Mission).unwrap_err();
        let text: Vec<String> = found.iter().map(ToString::to_string).collect();
        assert_eq!(
            text,
            [
                "item 1: frame is 0 instead of 3",
                "item 1: x is 40.0000001 instead of 40",
                "item 2 is NAV_LOITER_UNLIM instead of NAV_RETURN_TO_LAUNCH",
            ]
        );

        let missing = plans_equal_as_stored(&sent, &back[..1], PlanKind::Mission).unwrap_err();
        assert_eq!(missing[1].to_string(), "item 2 (NAV_RETURN_TO_LAUNCH) is missing on the vehicle");
        let extra = plans_equal_as_stored(&sent[..1], &back[..2], PlanKind::Mission).unwrap_err();
        assert_eq!(extra[0].to_string(), "item 1 (NAV_WAYPOINT) is on the vehicle but was not sent");
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
