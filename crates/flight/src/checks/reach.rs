//! Whether a plane can fly to a place at all.

use super::border::distance_to_polygon_m;
use crate::geodesy::{GeoPoint, distance_m};
use crate::plan::{FenceShape, MissionItem};
use crate::progress::target;

/// Farthest from home and from the vehicle that a destination may lie, metres. It is ten times what counts as far from
/// home, and an hour and a half at 37 m/s: a control link without relays ends before, and a place beyond it is nearly
/// always one with its coordinates confused. A longer flight goes in missions whose items count from the vehicle.
pub const REACH_M: f64 = 200_000.0;

/// A place that is out of reach.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct OutOfReach {
    /// To home or the vehicle, whichever is nearer, metres.
    pub distance_m: f64,
    /// Whether the place is in reach with latitude and longitude swapped.
    pub is_swapped: bool,
}

/// How far a place lies from the nearer of home and vehicle, where that is more than [`REACH_M`]; `None` in reach, and
/// where neither is known.
pub fn out_of_reach(place: GeoPoint, home: Option<GeoPoint>, vehicle: Option<GeoPoint>) -> Option<OutOfReach> {
    let nearest_m = |place| {
        let known = home.into_iter().chain(vehicle);
        known.map(|from| distance_m(from, place)).min_by(f64::total_cmp)
    };
    let distance_m = nearest_m(place).filter(|distance_m| *distance_m > REACH_M)?;
    let swapped = GeoPoint::new(place.lon_deg(), place.lat_deg()).ok().and_then(nearest_m);
    Some(OutOfReach { distance_m, is_swapped: swapped.is_some_and(|distance_m| distance_m <= REACH_M) })
}

/// The first destination of a mission that is out of reach, and its index; as [`out_of_reach`].
pub fn first_out_of_reach(
    items: &[MissionItem],
    home: Option<GeoPoint>,
    vehicle: Option<GeoPoint>,
) -> Option<(usize, OutOfReach)> {
    let far = |item| out_of_reach(target(item)?, home, vehicle);
    items.iter().enumerate().find_map(|(index, item)| Some((index, far(item)?)))
}

/// As [`out_of_reach`], for a zone of a fence: the nearest point of its edge. A zone around home
/// or the vehicle is in reach.
pub(super) fn zone_out_of_reach(
    shape: &FenceShape,
    home: Option<GeoPoint>,
    vehicle: Option<GeoPoint>,
) -> Option<OutOfReach> {
    if home.into_iter().chain(vehicle).any(|place| shape.contains(place)) {
        return None;
    }
    let far = |place: &GeoPoint| out_of_reach(*place, home, vehicle);
    match shape {
        FenceShape::Circle { center, radius_m } => {
            let told = far(center)?;
            let distance_m = told.distance_m - radius_m;
            (distance_m > REACH_M).then_some(OutOfReach { distance_m, ..told })
        }
        FenceShape::Polygon { vertices } => {
            let known = home.into_iter().chain(vehicle);
            let distance_m = known.map(|place| distance_to_polygon_m(place, vertices)).min_by(f64::total_cmp)?;
            let is_swapped = vertices.iter().filter_map(far).any(|told| told.is_swapped);
            (distance_m > REACH_M).then_some(OutOfReach { distance_m, is_swapped })
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(lat_deg: f64, lon_deg: f64) -> GeoPoint {
        GeoPoint::new(lat_deg, lon_deg).unwrap()
    }

    #[test]
    fn a_place_is_out_of_reach_of_home_and_vehicle_alike_and_swapped_coordinates_are_told_apart() {
        let home = at(40.333, -3.797);
        let away = at(43.0, -8.0); // 457 km north-west
        let told = |place, vehicle| out_of_reach(place, Some(home), vehicle);
        let swapped = told(at(-3.797, 40.333), None).unwrap();
        assert!(swapped.is_swapped && (swapped.distance_m - 6_638_000.0).abs() < 5_000.0, "{swapped:?}");
        assert_eq!(told(away, None).map(|told| told.is_swapped), Some(false));
        assert_eq!(told(away, Some(at(43.1, -8.0))), None, "near the vehicle");
        assert_eq!(told(home, Some(away)), None, "back home");
        assert_eq!(told(at(42.1, -3.797), None), None, "196 km");
        assert!(told(at(42.2, -3.797), None).is_some(), "207 km");
        assert_eq!(out_of_reach(away, None, None), None);
        // Swapped, the longitude would be no latitude.
        let far_east = out_of_reach(at(37.0, -122.0), Some(at(-35.363, 149.165)), None).unwrap();
        assert!(!far_east.is_swapped);
    }
}
