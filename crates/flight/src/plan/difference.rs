//! Differences between two items as far as a vehicle can store them, and the comparison of a plan that was sent with
//! the one read back.

use vencejo_proto::{Address, MissionSeq};

use crate::geodesy::wrap_180_deg;
use crate::plan::item::{MissionItem, PARAM_NAMES};
use crate::plan::px4::{px4_form, px4_kept};
use crate::plan::{Command, PlanKind, ardupilot_stored};

/// Largest difference of a float field that an ArduPilot's arithmetic makes, relative to its size: a few units in the
/// last place of a 32-bit float, for a vehicle that scales by 0.01 in another order.
const FLOAT_TOLERANCE: f64 = 4.0 * (f32::EPSILON as f64);
/// The same for a vehicle that hands back what it was sent, which may have been a decimal.
const AS_SENT_TOLERANCE: f64 = 1e-6;
/// Half a unit of degE7, degrees; x and y that are whole numbers must be exact.
const HALF_DEG_E7: f64 = 0.5e-7;
/// Largest difference of a height that an ArduPilot makes, metres: it keeps whole centimetres and may cut or round.
const ALT_TOLERANCE_M: f64 = 0.010_5;

/// Half a unit in the last place of a 32-bit float, relative to its size.
const UNIT_ROUNDOFF: f64 = f32::EPSILON as f64 / 2.0;
/// Roundings of a position to a float from sending to reading back.
const ROUNDINGS: f64 = 3.0;
/// Cut to whole degE7 by the vehicle (1), rounded to them by us (0.5), and room for the products of the roundings.
const WHOLE_NUMBERS_DEG: f64 = 1.6e-7;

/// Largest difference, degrees, that 32-bit floats make to a coordinate on its way to an old vehicle and back.
///
/// A float has 24 binary digits. A position in degrees passes through four roundings on its way to an ArduPilot from
/// before MISSION_ITEM_INT and back (`AP_Mission::mavlink_to_mission_cmd`, `mission_cmd_to_mavlink` of ArduPlane 3.x):
///
/// 1. to a float when it is sent: off by at most u = 2⁻²⁴ of its size,
/// 2. times 1e7 in floats: u again,
/// 3. cut to a whole number, which loses something only below 2²⁴ · 1e-7 = 1.7°: at most 1e-7°,
/// 4. divided by 1e7 in floats when it is read back: u again.
///
/// Together 3u of the coordinate's size, and the whole number (and ours) of degE7: at latitude 40° that is 7.2e-6° or
/// 0.8 m, at longitude 180° on the equator 3.6 m. Nothing that is farther off is taken for rounding.
pub fn float_tolerance_deg(coordinate_deg: f64) -> f64 {
    ROUNDINGS * UNIT_ROUNDOFF * coordinate_deg.abs() + WHOLE_NUMBERS_DEG
}

/// How a vehicle keeps the items that it is sent.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Keeping {
    /// It packs them as an ArduPlane does ([`ardupilot_stored`]); others give back what they were sent, or as PX4 only
    /// what they use of it.
    pub is_ardupilot: bool,
    /// They go to it with positions in 32-bit floats (MISSION_ITEM), as to ArduPlane 3.x: that rounds positions
    /// ([`float_tolerance_deg`]), and keeps no detail of a loiter and a landing that came later.
    pub in_floats: bool,
}

impl Keeping {
    /// An ArduPilot of today.
    pub const ARDUPILOT: Self = Self { is_ardupilot: true, in_floats: false };
    /// A vehicle that gives back what it was sent, or what it uses of it.
    pub const AS_SENT: Self = Self { is_ardupilot: false, in_floats: false };

    /// The item as it is stored, as far as that is known.
    pub(super) fn kept(self, item: &MissionItem) -> MissionItem {
        if self.is_ardupilot {
            return ardupilot_stored(item);
        }
        let wire = px4_form(item).to_wire(MissionSeq(0), Address::new(0, 0), PlanKind::Mission, false);
        MissionItem::from_wire(&wire).unwrap_or_else(|_| item.clone())
    }

    /// The fields in which the item read back differs from `expected`, as the one sent is stored. If the command
    /// differs, nothing else is compared.
    pub(super) fn fields_that_differ<'a>(
        self,
        expected: &'a MissionItem,
        read_back: &'a MissionItem,
    ) -> impl Iterator<Item = Field> + 'a {
        let is_same_command = expected.command == read_back.command;
        // A vehicle that echoes items may report any frame for one without position.
        let has_frame = self.is_ardupilot || expected.has_position();
        let is_other_frame = is_same_command && has_frame && expected.frame != read_back.frame;
        let first = [(!is_same_command).then_some(Field::Command), is_other_frame.then_some(Field::Frame)];
        let value = |item: &MissionItem, index: u8| item.params[usize::from(index)].unwrap_or(0.0);
        let params = (0..7).filter(move |&index| {
            is_same_command && !self.is_same_value(expected, index, value(expected, index), value(read_back, index))
        });
        first.into_iter().flatten().chain(params.map(Field::Param))
    }

    fn is_same_value(self, expected: &MissionItem, index: u8, sent: f64, kept: f64) -> bool {
        let has_position = expected.has_position();
        let kept_otherwise = || !self.is_ardupilot && is_of_px4(expected.command, index, sent, kept);
        let tolerance = match index {
            4 | 5 if self.in_floats && has_position => float_tolerance_deg(sent),
            4 | 5 => HALF_DEG_E7,
            6 if self.is_ardupilot && has_position => ALT_TOLERANCE_M,
            _ if self.is_ardupilot => FLOAT_TOLERANCE * sent.abs().max(1.0),
            _ => AS_SENT_TOLERANCE * sent.abs().max(1e-3),
        };
        let is_longitude = index == 5 && has_position;
        let apart = if is_longitude { wrap_180_deg(sent - kept) } else { sent - kept };
        apart.abs() <= tolerance || (self.in_floats && is_of_old(expected, index, sent, kept)) || kept_otherwise()
    }
}

/// Whether a difference is one that PX4 makes to every such item: it gives back what it uses alone.
fn is_of_px4(command: Command, index: u8, sent: f64, kept: f64) -> bool {
    let expected = px4_kept(command, index, sent);
    // An angle passes through radians in 32-bit floats.
    expected != sent && (expected - kept).abs() <= AS_SENT_TOLERANCE * expected.abs().max(1e-3)
}

/// Whether a difference is one that ArduPlane 3.x makes to every such item without changing its flight.
fn is_of_old(expected: &MissionItem, index: u8, sent: f64, kept: f64) -> bool {
    match index {
        // It keeps the sense of a loiter alone, and shows "clockwise, with my own radius" as 1.
        2 => expected.command == Command::NAV_LOITER_UNLIM && sent == 0.0 && kept == 1.0,
        // Whence the track after a loiter is counted, and the sense in which a landing is turned to, came later.
        3 => expected.has_position() && kept == 0.0,
        _ => false,
    }
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

/// One difference between the vehicle's plan and the one that was sent.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Difference {
    /// Place in the list, from 0 (on ArduPilot item 0 of a mission is home).
    pub seq: usize,
    /// What differs.
    pub field: Field,
    /// The expected value, after ArduPlane's rounding; `None`: no value.
    pub sent: Option<f64>,
    /// The value found; `None`: no value.
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

/// Compares a list that was sent with the list read back, item by item, as the vehicle keeps it.
///
/// Both lists are as on the wire: for a mission of an ArduPilot item 0 is home, of which only the presence is compared,
/// because it keeps its own. `autocontinue` is not compared: ArduPilot ignores it. Whole numbers and coordinates must
/// be exact; an ArduPilot's heights equal to a centimetre, its other floats to a few units in their last place; of
/// another vehicle all of them to a millionth. Positions in floats may be rounded ([`Keeping::in_floats`]).
///
/// # Errors
/// Every difference found, in order of item and field.
pub fn plans_equal_as_stored(
    sent: &[MissionItem],
    read_back: &[MissionItem],
    kind: PlanKind,
    keeping: Keeping,
) -> Result<(), Vec<Difference>> {
    let number = |item: &MissionItem| f64::from(item.command.0);
    let mut differences = Vec::new();
    for seq in 0..sent.len().max(read_back.len()) {
        let (expected, kept) = match (sent.get(seq), read_back.get(seq)) {
            (Some(_), Some(_)) if seq == 0 && kind == PlanKind::Mission && keeping.is_ardupilot => continue,
            (Some(sent), Some(kept)) => (keeping.kept(sent), kept),
            (sent, kept) => {
                let (sent, kept) = (sent.map(number), kept.map(number));
                differences.push(Difference { seq, field: Field::Item, sent, kept });
                continue;
            }
        };
        differences.extend(keeping.fields_that_differ(&expected, kept).map(|field| {
            let value = |item: &MissionItem| match field {
                Field::Item | Field::Command => Some(number(item)),
                Field::Frame => Some(f64::from(item.frame.number())),
                Field::Param(index) => item.params[usize::from(index)],
            };
            Difference { seq, field, sent: value(&expected), kept: value(kept) }
        }));
    }
    if differences.is_empty() { Ok(()) } else { Err(differences) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plan::MavFrame;

    #[test]
    fn each_difference_is_named() {
        let home = MissionItem::waypoint(0.0, 0.0, 0.0);
        let moved_home = MissionItem::waypoint(40.0, -3.0, 600.0);
        let sent = [home.clone(), MissionItem::waypoint(40.0, -3.0, 50.0), MissionItem::return_to_launch()];
        let mut back = [moved_home, ardupilot_stored(&sent[1]), ardupilot_stored(&sent[2])];
        assert_eq!(plans_equal_as_stored(&sent, &back, PlanKind::Mission, Keeping::ARDUPILOT), Ok(()));

        back[1].params[4] = Some(40.000_000_1);
        back[1].frame = MavFrame::Global;
        back[2].command = Command::NAV_LOITER_UNLIM;
        let found = plans_equal_as_stored(&sent, &back, PlanKind::Mission, Keeping::ARDUPILOT).unwrap_err();
        let text: Vec<String> = found.iter().map(ToString::to_string).collect();
        assert_eq!(
            text,
            [
                "item 1: frame is 0 instead of 3",
                "item 1: x is 40.0000001 instead of 40",
                "item 2 is NAV_LOITER_UNLIM instead of NAV_RETURN_TO_LAUNCH",
            ]
        );

        let missing = plans_equal_as_stored(&sent, &back[..1], PlanKind::Mission, Keeping::ARDUPILOT).unwrap_err();
        assert_eq!(missing[1].to_string(), "item 2 (NAV_RETURN_TO_LAUNCH) is missing on the vehicle");
        let extra = plans_equal_as_stored(&sent[..1], &back[..2], PlanKind::Mission, Keeping::ARDUPILOT).unwrap_err();
        assert_eq!(extra[0].to_string(), "item 1 (NAV_WAYPOINT) is on the vehicle but was not sent");
    }
}
