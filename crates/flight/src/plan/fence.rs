//! The geofence: zones to stay in or out of, and its way to and from mission items.

use crate::error::{FlightError, Result};
use crate::geodesy::{GeoPoint, distance_m, point_in_polygon};
use crate::plan::{Command, MavFrame, MissionItem};

/// Shape of a zone.
#[derive(Debug, Clone, PartialEq)]
pub enum FenceShape {
    /// Three or more corners in order; the last joins the first.
    Polygon {
        /// The corners.
        vertices: Vec<GeoPoint>,
    },
    /// All points within a distance of a centre.
    Circle {
        /// The centre.
        center: GeoPoint,
        /// Radius, metres, more than 0.
        radius_m: f64,
    },
}

/// One zone of a fence.
#[derive(Debug, Clone, PartialEq)]
pub struct FenceZone {
    /// `true`: stay inside; `false`: stay outside.
    pub inclusion: bool,
    /// Its border.
    pub shape: FenceShape,
}

/// A geofence. Empty by default.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Fence {
    /// Zones, all of which apply.
    pub zones: Vec<FenceZone>,
    /// Where to return to after a breach, when the vehicle is told to use it, with its height above home
    /// in metres.
    pub return_point: Option<(GeoPoint, f64)>,
}

/// Most corners that a polygon may have: ArduPilot counts them in 8 bits.
pub const MAX_VERTICES: usize = 255;

/// Fewest corners that make a polygon.
pub const SHAPE_MIN_CORNERS: usize = 3;

impl FenceShape {
    /// `true` when the point lies inside the border.
    pub fn contains(&self, point: GeoPoint) -> bool {
        match self {
            Self::Polygon { vertices } => point_in_polygon(point, vertices),
            Self::Circle { center, radius_m } => distance_m(*center, point) <= *radius_m,
        }
    }

    /// The fault of the shape; `None` when it is sound.
    fn fault(&self) -> Option<ShapeFault> {
        match self {
            Self::Polygon { vertices } if vertices.len() < SHAPE_MIN_CORNERS => {
                Some(ShapeFault::TooFewCorners { count: vertices.len() })
            }
            Self::Polygon { vertices } if vertices.len() > MAX_VERTICES => {
                Some(ShapeFault::TooManyCorners { count: vertices.len() })
            }
            // As on the wire: a radius that underflows there is invalid.
            Self::Circle { radius_m, .. } if !((*radius_m as f32).is_finite() && *radius_m as f32 > 0.0) => {
                Some(ShapeFault::Radius { radius_m: *radius_m })
            }
            _ => None,
        }
    }
}

/// Fault of a shape that every vehicle would refuse.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum ShapeFault {
    /// A polygon with fewer than [`SHAPE_MIN_CORNERS`].
    TooFewCorners {
        /// How many it has.
        count: usize,
    },
    /// A polygon with more than [`MAX_VERTICES`].
    TooManyCorners {
        /// How many it has.
        count: usize,
    },
    /// A radius that makes no circle.
    Radius {
        /// The radius, metres; not finite, or not above 0.
        radius_m: f64,
    },
}

impl std::fmt::Display for ShapeFault {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::TooFewCorners { count } => {
                write!(f, "a polygon needs at least {SHAPE_MIN_CORNERS} corners, this has {count}; add some")
            }
            Self::TooManyCorners { count } => {
                write!(f, "a polygon holds at most {MAX_VERTICES} corners, this has {count}; simplify or split it")
            }
            Self::Radius { radius_m } => write!(f, "a radius of {radius_m} m makes no circle; give one above 0"),
        }
    }
}

impl Fence {
    /// `true` without zones and return point.
    pub fn is_empty(&self) -> bool {
        self.zones.is_empty() && self.return_point.is_none()
    }

    /// Whether each zone has a shape that a vehicle takes.
    ///
    /// # Errors
    /// [`FlightError::BadFence`] for a polygon with fewer than 3 or more than 255 corners and for a circle
    /// without a radius; the index is that of the zone.
    pub fn validate(&self) -> Result<()> {
        self.fault().map_or(Ok(()), |(index, fault)| Err(FlightError::BadFence { index, problem: fault.to_string() }))
    }

    /// The first zone that every vehicle would refuse, by index, and why; `None` when all are sound.
    pub fn fault(&self) -> Option<(usize, ShapeFault)> {
        self.zones.iter().enumerate().find_map(|(index, zone)| Some((index, zone.shape.fault()?)))
    }

    /// The first zone that forbids a place, by index; `None` when the place is allowed.
    ///
    /// As on ArduPilot a place must lie outside every exclusion zone and inside every inclusion zone; inside one of
    /// them where `is_union` says so (`FENCE_OPTIONS`, bit 1). The first of them stands for all then.
    pub fn forbidden_by(&self, point: GeoPoint, is_union: bool) -> Option<usize> {
        let is_included = is_union && self.zones.iter().any(|zone| zone.inclusion && zone.shape.contains(point));
        self.zones.iter().position(|zone| {
            let is_wrong = zone.shape.contains(point) != zone.inclusion;
            is_wrong && !(zone.inclusion && is_included)
        })
    }

    /// The fence as items of a fence list (`MAV_MISSION_TYPE_FENCE`), frame global.
    ///
    /// Parameter 1 of a corner is the number of corners of its polygon, of a circle its radius in metres
    /// (<https://mavlink.io/en/services/mission.html#geofence-plans>).
    pub fn to_items(&self) -> Vec<MissionItem> {
        let item = |command, param1: f64, point: GeoPoint, alt_m| MissionItem {
            frame: MavFrame::Global,
            ..MissionItem::at(command, [param1, 0.0, 0.0, 0.0], point.lat_deg(), point.lon_deg(), alt_m)
        };
        let mut items = Vec::new();
        for zone in &self.zones {
            match &zone.shape {
                FenceShape::Polygon { vertices } => {
                    let command = if zone.inclusion {
                        Command::NAV_FENCE_POLYGON_VERTEX_INCLUSION
                    } else {
                        Command::NAV_FENCE_POLYGON_VERTEX_EXCLUSION
                    };
                    let count = vertices.len() as f64;
                    items.extend(vertices.iter().map(|vertex| item(command, count, *vertex, 0.0)));
                }
                FenceShape::Circle { center, radius_m } => {
                    let command = if zone.inclusion {
                        Command::NAV_FENCE_CIRCLE_INCLUSION
                    } else {
                        Command::NAV_FENCE_CIRCLE_EXCLUSION
                    };
                    items.push(item(command, *radius_m, *center, 0.0));
                }
            }
        }
        items.extend(self.return_item());
        items
    }

    fn return_item(&self) -> Option<MissionItem> {
        let (point, alt_rel_home_m) = self.return_point?;
        let (lat_deg, lon_deg) = (point.lat_deg(), point.lon_deg());
        Some(MissionItem::at(Command::NAV_FENCE_RETURN_POINT, [0.0; 4], lat_deg, lon_deg, alt_rel_home_m))
    }

    /// Why its return point cannot be sent; `None` without one, and when it is sound.
    pub fn return_fault(&self) -> Option<String> {
        Some(self.return_item()?.unsendable()?.to_string())
    }

    /// A fence from the items of a fence list.
    ///
    /// # Errors
    /// [`FlightError::BadFence`] for another command, a polygon whose corners are not as many as they say or
    /// disagree, a circle without radius, a place off the globe, or a second return point.
    pub fn from_items(items: &[MissionItem]) -> Result<Self> {
        let mut fence = Self::default();
        let mut index = 0;
        while let Some(item) = items.get(index) {
            let bad = |problem: String| FlightError::BadFence { index, problem };
            let point = position(item).ok_or_else(|| bad("has no position on Earth; set one".into()))?;
            let inclusion = matches!(
                item.command,
                Command::NAV_FENCE_POLYGON_VERTEX_INCLUSION | Command::NAV_FENCE_CIRCLE_INCLUSION
            );
            match item.command {
                Command::NAV_FENCE_POLYGON_VERTEX_INCLUSION | Command::NAV_FENCE_POLYGON_VERTEX_EXCLUSION => {
                    let vertices = polygon(&items[index..]).map_err(bad)?;
                    index += vertices.len();
                    fence.zones.push(FenceZone { inclusion, shape: FenceShape::Polygon { vertices } });
                    continue;
                }
                Command::NAV_FENCE_CIRCLE_INCLUSION | Command::NAV_FENCE_CIRCLE_EXCLUSION => {
                    let shape = FenceShape::Circle { center: point, radius_m: item.param(1).unwrap_or(0.0) };
                    if let Some(fault) = shape.fault() {
                        return Err(bad(fault.to_string()));
                    }
                    fence.zones.push(FenceZone { inclusion, shape });
                }
                Command::NAV_FENCE_RETURN_POINT => {
                    if fence.return_point.is_some() {
                        return Err(bad("is a second return point; a fence has one".into()));
                    }
                    fence.return_point = Some((point, item.alt_m().unwrap_or(0.0)));
                }
                other => {
                    return Err(bad(format!("{other} is not part of a fence; only commands 5000 to 5004 are")));
                }
            }
            index += 1;
        }
        Ok(fence)
    }
}

/// The position of an item, 0/0 included.
fn position(item: &MissionItem) -> Option<GeoPoint> {
    GeoPoint::new(item.lat_deg()?, item.lon_deg()?).ok()
}

/// The corners of the polygon at the head of a list.
fn polygon(items: &[MissionItem]) -> std::result::Result<Vec<GeoPoint>, String> {
    let first = items.first().ok_or("is missing")?;
    let count = first.param(1).unwrap_or(0.0);
    if count.fract() != 0.0 || !(3.0..=MAX_VERTICES as f64).contains(&count) {
        return Err(format!(
            "says that its polygon has {count} corners; a polygon has 3 to {MAX_VERTICES}, read or save the fence again"
        ));
    }
    let count = count as usize;
    let corners = items.get(..count).ok_or_else(|| {
        format!(
            "starts a polygon of {count} corners but only {} items are left; read or save the fence again",
            items.len()
        )
    })?;
    corners
        .iter()
        .enumerate()
        .map(|(offset, item)| {
            if item.command != first.command || item.param(1) != first.param(1) {
                return Err(format!(
                    "starts a polygon of {count} corners but corner {} is {} of {}; read or save the fence again",
                    offset + 1,
                    item.command,
                    item.param(1).unwrap_or(0.0)
                ));
            }
            position(item).ok_or_else(|| {
                format!("starts a polygon whose corner {} has no position on Earth; set one", offset + 1)
            })
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn at(lat_deg: f64, lon_deg: f64) -> GeoPoint {
        GeoPoint::new(lat_deg, lon_deg).unwrap()
    }

    fn corner(count: f64, lat_deg: f64) -> MissionItem {
        MissionItem::at(Command::NAV_FENCE_POLYGON_VERTEX_INCLUSION, [count, 0.0, 0.0, 0.0], lat_deg, -3.0, 0.0)
    }

    fn points() -> impl Strategy<Value = GeoPoint> {
        // degE7 steps, as on the wire
        (-900_000_000..=900_000_000_i32, -1_800_000_000..=1_800_000_000_i32)
            .prop_map(|(lat, lon)| at(f64::from(lat) / 1e7, f64::from(lon) / 1e7))
    }

    fn zones() -> impl Strategy<Value = FenceZone> {
        let polygon = prop::collection::vec(points(), 3..12).prop_map(|vertices| FenceShape::Polygon { vertices });
        let circle = (points(), 1..100_000_u32)
            .prop_map(|(center, radius)| FenceShape::Circle { center, radius_m: f64::from(radius) });
        (any::<bool>(), prop_oneof![polygon, circle]).prop_map(|(inclusion, shape)| FenceZone { inclusion, shape })
    }

    proptest! {
        #[test]
        fn a_fence_survives_the_wire(
            zones in prop::collection::vec(zones(), 0..5),
            return_point in prop::option::of((points(), 0..500_i32)),
        ) {
            let fence = Fence { zones, return_point: return_point.map(|(point, alt)| (point, f64::from(alt))) };
            let wire = crate::plan::items_to_wire(
                &fence.to_items(), vencejo_proto::Address::new(1, 1), crate::plan::PlanKind::Fence,
            ).unwrap();
            let items = crate::plan::items_from_wire(&wire, crate::plan::PlanKind::Fence).unwrap();
            prop_assert_eq!(Fence::from_items(&items).unwrap(), fence);
        }
    }

    #[test]
    fn malformed_lists_are_refused_with_the_place() {
        let cases: [(&[MissionItem], &str); 7] = [
            (&[corner(2.0, 40.0), corner(2.0, 41.0)], "fence item 0: says that its polygon has 2 corners"),
            (&[corner(3.0, 40.0), corner(3.0, 41.0)], "fence item 0: starts a polygon of 3 corners but only 2"),
            (
                &[corner(3.0, 40.0), corner(3.0, 41.0), corner(4.0, 42.0)],
                "fence item 0: starts a polygon of 3 corners but corner 3",
            ),
            (&[MissionItem::waypoint(40.0, -3.0, 0.0)], "fence item 0: NAV_WAYPOINT is not part of a fence"),
            (
                &[MissionItem::at(Command::NAV_FENCE_CIRCLE_INCLUSION, [0.0; 4], 40.0, -3.0, 0.0)],
                "fence item 0: a radius of 0 m",
            ),
            (
                &[MissionItem::at(Command::NAV_FENCE_CIRCLE_INCLUSION, [1e-60, 0.0, 0.0, 0.0], 40.0, -3.0, 0.0)],
                "fence item 0: a radius of 0.00",
            ),
            (&[corner(f64::MAX, 40.0)], "fence item 0: says that its polygon has 1797"),
        ];
        for (items, expected) in cases {
            let error = Fence::from_items(items).unwrap_err().to_string();
            assert!(error.starts_with(expected), "{error}");
        }
    }

    #[test]
    fn a_place_must_satisfy_every_zone() {
        let circle = |inclusion, radius_m| FenceZone {
            inclusion,
            shape: FenceShape::Circle { center: at(40.0, -3.0), radius_m },
        };
        let fence = Fence { zones: vec![circle(true, 1_000.0), circle(false, 100.0)], return_point: None };
        for is_union in [false, true] {
            assert_eq!(fence.forbidden_by(at(40.0, -3.0), is_union), Some(1));
            assert_eq!(fence.forbidden_by(at(40.005, -3.0), is_union), None);
            assert_eq!(fence.forbidden_by(at(40.02, -3.0), is_union), Some(0));
        }
    }
}
