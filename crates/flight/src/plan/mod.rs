//! Plans: mission, fence and rally points, and their MAVLink items.
//!
//! Values keep their unit and datum; nothing here communicates with a vehicle. [`ardupilot_stored`] knows what an
//! ArduPlane keeps of an item, [`Keeping`] how a plan read back is compared with the one sent, and [`plan_changes`] how
//! one that is edited differs from the one on board.

mod changes;
pub mod command;
mod datum;
mod difference;
mod fence;
mod item;
mod px4;
mod rally;
mod stored;

pub use changes::{Change, ChangedField, plan_changes};
pub use command::{Category, Choice, ChoiceWord, Command, CommandInfo, ParamInfo, Storage, Support, Unit};
pub use datum::{Levels, UnknownLevel, counted_from};
pub use difference::{Difference, Field, Keeping, float_tolerance_deg, plans_equal_as_stored};
pub use fence::{Fence, FenceShape, FenceZone, MAX_VERTICES, SHAPE_MIN_CORNERS, ShapeFault};
pub use item::{MavFrame, MissionItem, PlanKind, Unsendable, Wanted};
pub use rally::{Rally, RallyPoint};
pub use stored::ardupilot_stored;

use std::borrow::Cow;

use vencejo_proto::{Address, MissionSeq};

use crate::error::{FlightError, Result};
use crate::geodesy::GeoPoint;
use crate::plan::item::MissionItemInt;

/// Most items that a plan may hold in memory or in a file; no vehicle takes as many.
pub const MAX_ITEMS: usize = 10_000;

/// Where heights relative to home are counted from.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "describe", derive(serde::Serialize, serde::Deserialize, utoipa::ToSchema))]
#[cfg_attr(feature = "describe", serde(deny_unknown_fields))]
pub struct Home {
    /// WGS-84 latitude.
    pub lat_deg: f64,
    /// WGS-84 longitude.
    pub lon_deg: f64,
    /// Height above mean sea level, metres.
    pub alt_amsl_m: f64,
}

impl Home {
    /// The home position as a checked point.
    ///
    /// # Errors
    /// [`FlightError::NotOnEarth`] when the coordinates are not finite or out of range, [`FlightError::HomeHeight`]
    /// when the height is.
    pub fn point(&self) -> Result<GeoPoint> {
        let point = GeoPoint::new(self.lat_deg, self.lon_deg)?;
        if self.to_item().unsendable().is_some() {
            return Err(FlightError::HomeHeight { alt_amsl_m: self.alt_amsl_m });
        }
        Ok(point)
    }

    /// The item that stands for home in a mission list: an absolute waypoint.
    pub fn to_item(self) -> MissionItem {
        let mut item = MissionItem::waypoint(self.lat_deg, self.lon_deg, self.alt_amsl_m);
        item.frame = MavFrame::Global;
        item
    }

    /// Home from item 0 of a mission list; `None` when it is unset (0/0) or no position.
    pub fn from_item(item: &MissionItem) -> Option<Self> {
        let lat_deg = item.lat_deg()?;
        let lon_deg = item.lon_deg()?;
        let alt_amsl_m = item.alt_m().unwrap_or(0.0);
        let unset = lat_deg == 0.0 && lon_deg == 0.0;
        (!unset).then_some(Self { lat_deg, lon_deg, alt_amsl_m })
    }
}

/// A mission: home, if it is known, and the items **without** home.
///
/// On ArduPilot item 0 of the list on the wire is home, so `items[0]` has seq 1 there; on PX4 it has seq 0.
/// [`Mission::to_wire`] takes care of that, also in what a `DO_JUMP` names: here `items[0]` is 1 for all vehicles.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Mission {
    /// Planned home; the vehicle sets its own when it arms.
    pub home: Option<Home>,
    /// What to do, in order.
    pub items: Vec<MissionItem>,
}

impl Mission {
    /// The list as sent to a vehicle, seq 0 upwards.
    ///
    /// With `with_home` item 0 is home (ArduPilot); an unknown home is sent as 0/0, which ArduPilot
    /// replaces by its own. Without it (PX4) `items[0]` is item 0, and items without a position go in
    /// `MAV_FRAME_MISSION`, the only frame in which PX4 takes them.
    ///
    /// # Errors
    /// [`FlightError::BadItem`] for a value that may not be sent, [`FlightError::BadMission`] when there
    /// are more than 65,535 items.
    pub fn to_wire(&self, target: Address, with_home: bool) -> Result<Vec<MissionItemInt>> {
        if !with_home {
            let mut items: Vec<_> = self.items.iter().map(px4::px4_form).collect();
            move_jumps(&mut items, -1.0);
            return items_to_wire(&items, target, PlanKind::Mission);
        }
        let home =
            self.home.map_or_else(|| Home { lat_deg: 0.0, lon_deg: 0.0, alt_amsl_m: 0.0 }.to_item(), Home::to_item);
        items_to_wire([&home].into_iter().chain(&self.items), target, PlanKind::Mission)
    }

    /// A mission from the list of a vehicle, sorted by seq, complete from 0.
    ///
    /// # Errors
    /// [`FlightError::BadMission`] for a list with gaps or of another kind, [`FlightError::BadItem`] for an
    /// item with values that cannot be.
    pub fn from_wire(wire: &[MissionItemInt], with_home: bool) -> Result<Self> {
        let mut items = items_from_wire(wire, PlanKind::Mission)?;
        let home = if with_home && !items.is_empty() { Home::from_item(&items.remove(0)) } else { None };
        if !with_home {
            move_jumps(&mut items, 1.0);
        }
        Ok(Self { home, items })
    }
}

/// Shifts the targets of a mission's `DO_JUMP`s: by −1 for a list that does not begin with home and so counts from 0
/// what a mission counts from 1, 1 back.
pub fn move_jumps(items: &mut [MissionItem], by: f64) {
    for item in items.iter_mut().filter(|item| item.command == Command::DO_JUMP) {
        item.params[0] = item.params[0].map(|target| target + by);
    }
}

/// Everything that is sent to a vehicle before a flight.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Plan {
    /// What to fly.
    pub mission: Mission,
    /// Where to stay.
    pub fence: Fence,
    /// Where to return to when home is farther.
    pub rally: Rally,
}

impl Plan {
    /// A plan of a mission alone.
    pub fn from_mission(mission: Mission) -> Self {
        Self { mission, ..Self::default() }
    }

    /// The items of one kind as they are uploaded, without seq, and the home of a mission.
    ///
    /// # Errors
    /// [`FlightError::BadFence`] for an invalid zone.
    pub fn into_list(self, kind: PlanKind) -> Result<(Vec<MissionItem>, Option<Home>)> {
        Ok(match kind {
            PlanKind::Mission => (self.mission.items, self.mission.home),
            PlanKind::Fence => {
                self.fence.validate()?;
                (self.fence.to_items(), None)
            }
            PlanKind::Rally => (self.rally.to_items(), None),
        })
    }

    /// The items of one kind as they are, also of a fence that is half drawn.
    pub fn items(&self, kind: PlanKind) -> Cow<'_, [MissionItem]> {
        match kind {
            PlanKind::Mission => Cow::Borrowed(&self.mission.items),
            PlanKind::Fence => Cow::Owned(self.fence.to_items()),
            PlanKind::Rally => Cow::Owned(self.rally.to_items()),
        }
    }

    /// A plan of one list alone, as [`Self::into_list`] gives it.
    ///
    /// # Errors
    /// [`FlightError::BadFence`] and [`FlightError::BadItem`] for items that are not a fence or rally points.
    pub fn from_list(kind: PlanKind, list: Mission) -> Result<Self> {
        let mut plan = Self::default();
        match kind {
            PlanKind::Mission => plan.mission = list,
            PlanKind::Fence => plan.fence = Fence::from_items(&list.items)?,
            PlanKind::Rally => plan.rally = Rally::from_items(&list.items)?,
        }
        Ok(plan)
    }

    /// The list of one kind as sent to the vehicle. `with_home` matters to the mission alone.
    ///
    /// # Errors
    /// As [`Mission::to_wire`].
    pub fn to_wire(&self, kind: PlanKind, target: Address, with_home: bool) -> Result<Vec<MissionItemInt>> {
        match kind {
            PlanKind::Mission => self.mission.to_wire(target, with_home),
            PlanKind::Fence => items_to_wire(self.fence.to_items().iter(), target, kind),
            PlanKind::Rally => items_to_wire(self.rally.to_items().iter(), target, kind),
        }
    }
}

/// Numbers, checks and encodes a list of items.
///
/// # Errors
/// [`FlightError::BadItem`] for a value that may not be sent, [`FlightError::BadMission`] when there are
/// more than 65,535 items.
pub fn items_to_wire<'a>(
    items: impl IntoIterator<Item = &'a MissionItem>,
    target: Address,
    kind: PlanKind,
) -> Result<Vec<MissionItemInt>> {
    let mut wire = Vec::new();
    for (index, item) in items.into_iter().enumerate() {
        let seq = u16::try_from(index).map(MissionSeq).map_err(|_| FlightError::BadMission {
            index,
            problem: "a plan holds at most 65,535 items; split it".into(),
        })?;
        item.check_sendable(seq)?;
        wire.push(item.to_wire(seq, target, kind, false));
    }
    Ok(wire)
}

/// Decodes a list that must be complete and in order, seq 0 upwards.
///
/// # Errors
/// [`FlightError::BadMission`] for a gap, a repetition or another kind of plan; as
/// [`MissionItem::from_wire`] for the items.
pub fn items_from_wire(wire: &[MissionItemInt], kind: PlanKind) -> Result<Vec<MissionItem>> {
    wire.iter()
        .enumerate()
        .map(|(index, item)| {
            if usize::from(item.seq) != index {
                return Err(FlightError::BadMission {
                    index,
                    problem: format!("has seq {} where {index} belongs; read the plan again", item.seq),
                });
            }
            if item.mission_type != kind.mission_type() {
                return Err(FlightError::BadMission {
                    index,
                    problem: format!(
                        "is of plan kind {} in a list of kind {}; read the plan again",
                        item.mission_type,
                        kind.mission_type()
                    ),
                });
            }
            MissionItem::from_wire(item)
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    // A PX4 has no home in its list and jumps to the seq that the item has there, as QGroundControl sends it.
    #[test]
    fn a_jump_goes_to_the_same_item_with_home_on_the_wire_and_without() {
        let mut items = vec![MissionItem::waypoint(40.0, -3.0, 80.0); 3];
        items.push(MissionItem::jump(MissionSeq(1), 2));
        // A tag is the item's own, and no number of an item.
        items.push(MissionItem::action(Command::DO_JUMP_TAG, [7.0, 1.0, 0.0, 0.0]));
        let mission = Mission { home: None, items };
        for (with_home, target) in [(true, 1.0), (false, 0.0)] {
            let wire = mission.to_wire(Address::new(1, 1), with_home).unwrap();
            let first = usize::from(with_home);
            assert_eq!((wire[first + 3].params[0], wire[first + 3].params[1]), (target, 2.0));
            assert_eq!(wire[first + 4].params[0], 7.0);
            assert_eq!(Mission::from_wire(&wire, with_home).unwrap(), mission);
        }
    }
}
