//! Rally points: places to return to instead of home, and their way to and from mission items.

use crate::error::{FlightError, Result};
use crate::geodesy::GeoPoint;
use crate::plan::{Command, MavFrame, MissionItem};

/// One place to return to.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RallyPoint {
    /// Where.
    pub point: GeoPoint,
    /// Height to loiter at, metres, in `frame`.
    pub alt_m: f64,
    /// Datum of the height.
    pub frame: MavFrame,
}

impl RallyPoint {
    /// It as an item of a rally list.
    fn to_item(self) -> MissionItem {
        let Self { point, alt_m, frame } = self;
        let item = MissionItem::at(Command::NAV_RALLY_POINT, [0.0; 4], point.lat_deg(), point.lon_deg(), alt_m);
        MissionItem { frame, ..item }
    }

    /// Why it cannot be sent; `None` when it is sound.
    pub fn fault(self) -> Option<String> {
        frame_fault(self.frame).or_else(|| Some(self.to_item().unsendable()?.to_string()))
    }
}

fn frame_fault(frame: MavFrame) -> Option<String> {
    let is_sound = frame.is_supported() && frame != MavFrame::Mission;
    (!is_sound).then(|| format!("{frame} has no meaning for a place; use 0 (sea level), 3 (home) or 10 (terrain)"))
}

/// Rally points of a plan. Empty by default.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Rally {
    /// The points.
    pub points: Vec<RallyPoint>,
}

impl Rally {
    /// The points as items of a rally list (`MAV_MISSION_TYPE_RALLY`).
    pub fn to_items(&self) -> Vec<MissionItem> {
        self.points.iter().map(|rally| rally.to_item()).collect()
    }

    /// Rally points from the items of a rally list.
    ///
    /// # Errors
    /// [`FlightError::BadRally`] for another command, a place off the globe, no height, or a frame that has
    /// no meaning for a place.
    pub fn from_items(items: &[MissionItem]) -> Result<Self> {
        let points = items
            .iter()
            .enumerate()
            .map(|(index, item)| {
                let bad = |problem: String| FlightError::BadRally { index, problem };
                if item.command != Command::NAV_RALLY_POINT {
                    return Err(bad(format!("{} is not a rally point; only command 5100 is", item.command)));
                }
                frame_fault(item.frame).map_or(Ok(()), |fault| Err(bad(fault)))?;
                let (Some(lat_deg), Some(lon_deg), Some(alt_m)) = (item.lat_deg(), item.lon_deg(), item.alt_m()) else {
                    return Err(bad("lacks latitude, longitude or height; set all three".into()));
                };
                let point = GeoPoint::new(lat_deg, lon_deg).map_err(|error| bad(error.to_string()))?;
                Ok(RallyPoint { point, alt_m, frame: item.frame })
            })
            .collect::<Result<_>>()?;
        Ok(Self { points })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plan::{PlanKind, items_from_wire, items_to_wire};
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn rally_points_survive_the_wire(
            places in prop::collection::vec((-900_000_000..=900_000_000_i32, -1_800_000_000..=1_800_000_000_i32, -100..3_000_i16), 0..20),
            frame in prop::sample::select(vec![MavFrame::Global, MavFrame::GlobalRelativeAlt, MavFrame::GlobalTerrainAlt]),
        ) {
            let points = places.into_iter().map(|(lat, lon, alt)| RallyPoint {
                point: GeoPoint::new(f64::from(lat) / 1e7, f64::from(lon) / 1e7).unwrap(),
                alt_m: f64::from(alt),
                frame,
            }).collect();
            let rally = Rally { points };
            let wire = items_to_wire(&rally.to_items(), vencejo_proto::Address::new(1, 1), PlanKind::Rally).unwrap();
            prop_assert_eq!(Rally::from_items(&items_from_wire(&wire, PlanKind::Rally).unwrap()).unwrap(), rally);
        }
    }

    #[test]
    fn malformed_lists_are_refused() {
        let mut no_height = MissionItem::at(Command::NAV_RALLY_POINT, [0.0; 4], 40.0, -3.0, 50.0);
        no_height.params[6] = None;
        let mut local = MissionItem::at(Command::NAV_RALLY_POINT, [0.0; 4], 40.0, -3.0, 50.0);
        local.frame = MavFrame::Other(1);
        for (item, expected) in [
            (MissionItem::waypoint(40.0, -3.0, 50.0), "rally item 0: NAV_WAYPOINT is not a rally point"),
            (no_height, "rally item 0: lacks"),
            (local, "rally item 0: frame 1 has no meaning"),
        ] {
            let error = Rally::from_items(&[item]).unwrap_err().to_string();
            assert!(error.starts_with(expected), "{error}");
        }
    }
}
