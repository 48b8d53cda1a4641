//! Places and rectangles on the Earth.

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

use crate::crs::Crs;

/// A rectangle of the Earth. West greater than east: over the date line.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
#[schema(as = MapBounds)]
pub struct Bounds {
    /// −180 to 180.
    pub west_deg: f64,
    /// −90 to 90.
    pub south_deg: f64,
    /// −180 to 180.
    pub east_deg: f64,
    /// −90 to 90.
    pub north_deg: f64,
}

/// Difference of longitude that counts as zero: a tenth of a millimetre.
const NOTHING_DEG: f64 = 1e-9;

impl Bounds {
    /// Its fault; `None` when it is valid.
    pub fn fault(&self) -> Option<String> {
        let is_lon = |lon: f64| (-180.0..=180.0).contains(&lon);
        let is_lat = |lat: f64| (-90.0..=90.0).contains(&lat);
        if !is_lon(self.west_deg) || !is_lon(self.east_deg) {
            return Some("longitudes go from -180 to 180".to_owned());
        }
        if !is_lat(self.south_deg) || !is_lat(self.north_deg) {
            return Some("latitudes go from -90 to 90".to_owned());
        }
        (self.south_deg >= self.north_deg).then(|| "south_deg must be less than north_deg".to_owned())
    }

    /// The rectangle around the bounds in a system: least x and y, greatest x and y. Over the date line x goes beyond
    /// it.
    pub fn extent_in(&self, crs: Crs) -> [f64; 4] {
        let east_deg = if self.east_deg < self.west_deg { self.east_deg + 360.0 } else { self.east_deg };
        let mut extent = [f64::INFINITY, f64::INFINITY, f64::NEG_INFINITY, f64::NEG_INFINITY];
        // Borders are curves in UTM: a few points of each side are enough for a rectangle that is a little too small by
        // less than a tile; 32 a side keep it below a millionth of the side.
        for step in 0..=32 {
            let share = f64::from(step) / 32.0;
            let lat = self.south_deg + (self.north_deg - self.south_deg) * share;
            let lon = self.west_deg + (east_deg - self.west_deg) * share;
            for [x, y] in [
                crs.project(lat, self.west_deg),
                crs.project(lat, east_deg),
                crs.project(self.south_deg, lon),
                crs.project(self.north_deg, lon),
            ] {
                extent = [extent[0].min(x), extent[1].min(y), extent[2].max(x), extent[3].max(y)];
            }
        }
        extent
    }

    /// The bounds around a rectangle of a system, also one over the date line; `None` when it is off the map.
    pub fn around(crs: Crs, [left, bottom, right, top]: [f64; 4]) -> Option<Self> {
        let mut bounds = (f64::INFINITY, f64::INFINITY, f64::NEG_INFINITY, f64::NEG_INFINITY);
        let mut before_deg = None;
        let sides = [([left, bottom], [right, bottom]), ([right, bottom], [right, top])];
        let sides = sides.into_iter().chain([([right, top], [left, top]), ([left, top], [left, bottom])]);
        for (from, to) in sides {
            for step in 0..=16 {
                let share = f64::from(step) / 16.0;
                let point = crs.unproject([0, 1].map(|axis| from[axis] + (to[axis] - from[axis]) * share))?;
                // A place on the date line is east or west of it as its neighbour is: +180 stays apart from -180.
                let turns = before_deg.map_or(0.0, |before: f64| ((before - point.lon_deg()) / 360.0).round());
                let (lat, lon) = (point.lat_deg(), point.lon_deg() + 360.0 * turns);
                before_deg = Some(lon);
                bounds = (bounds.0.min(lon), bounds.1.min(lat), bounds.2.max(lon), bounds.3.max(lat));
            }
        }
        let (west_deg, south_deg, east_deg, north_deg) = bounds;
        if east_deg - west_deg >= 360.0 - NOTHING_DEG {
            return Some(Self { west_deg: -180.0, south_deg, east_deg: 180.0, north_deg });
        }
        // One that begins at the date line lies east of it, one that ends there west.
        let turned = |lon: f64, past: f64| lon - 360.0 * ((lon - past) / 360.0).floor();
        let west_deg = turned(west_deg, -180.0 - NOTHING_DEG).max(-180.0);
        let east_deg = (-turned(-east_deg, -180.0 - NOTHING_DEG)).min(180.0);
        Some(Self { west_deg, south_deg, east_deg, north_deg })
    }
}

/// A place on the ground.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
#[schema(as = MapCorner)]
pub struct Corner {
    /// WGS-84 latitude.
    pub lat_deg: f64,
    /// WGS-84 longitude.
    pub lon_deg: f64,
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// Of bounds, to a part of a metre.
    fn is_near(found: &Bounds, [west_deg, south_deg, east_deg, north_deg]: [f64; 4]) -> bool {
        let apart = [
            found.west_deg - west_deg,
            found.south_deg - south_deg,
            found.east_deg - east_deg,
            found.north_deg - north_deg,
        ];
        apart.iter().all(|apart_deg| apart_deg.abs() < 1e-6)
    }

    #[test]
    fn the_date_line_is_east_of_what_lies_west_of_it() {
        let crs = Crs::Crs84;
        for (extent, expected) in [
            ([170.0, -10.0, 180.0, 10.0], [170.0, -10.0, 180.0, 10.0]),
            ([-180.0, -10.0, -170.0, 10.0], [-180.0, -10.0, -170.0, 10.0]),
            ([180.0, -10.0, 190.0, 10.0], [-180.0, -10.0, -170.0, 10.0]),
            ([170.0, -10.0, 190.0, 10.0], [170.0, -10.0, -170.0, 10.0]),
            ([-180.0, -90.0, 180.0, 90.0], [-180.0, -90.0, 180.0, 90.0]),
            ([0.0, -90.0, 360.0, 90.0], [-180.0, -90.0, 180.0, 90.0]),
        ] {
            let found = Bounds::around(crs, extent).expect("on the map");
            assert!(is_near(&found, expected), "{extent:?}: {found:?}");
        }
    }

    proptest! {
        /// A rectangle comes back as it was, wherever it lies: beside the date line, up to it and over it.
        #[test]
        fn bounds_come_back_from_their_extent(
            west in prop_oneof![-180.0..180.0_f64, Just(-180.0), 178.0..180.0_f64],
            width in prop_oneof![1e-3..300.0_f64, Just(2.0)],
            ends_at_the_line in any::<bool>(),
            south in -80.0..70.0_f64,
            height in 1e-3..10.0_f64,
            is_mercator in any::<bool>(),
        ) {
            let crs = if is_mercator { Crs::WebMercator } else { Crs::Crs84 };
            let east = if ends_at_the_line { 180.0 } else { west + width };
            prop_assume!(east - west < 359.0);
            let east_deg = if east > 180.0 { east - 360.0 } else { east };
            let given = Bounds { west_deg: west, south_deg: south, east_deg, north_deg: south + height };
            let found = Bounds::around(crs, given.extent_in(crs)).expect("on the map");
            prop_assert_eq!(found.fault(), None);
            prop_assert!(is_near(&found, [west, south, east_deg, south + height]), "{:?} became {:?}", given, found);
        }
    }
}
