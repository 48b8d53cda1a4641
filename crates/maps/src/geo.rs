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

impl Bounds {
    /// What is wrong with it.
    #[must_use]
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

    /// The rectangle around the bounds in a system: least x and y, greatest x and y. Over the date line x goes beyond it.
    #[must_use]
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

    /// The bounds around a rectangle of a system; `None` when it is off the map.
    #[must_use]
    pub fn around(crs: Crs, [left, bottom, right, top]: [f64; 4]) -> Option<Self> {
        let mut bounds = (f64::INFINITY, f64::INFINITY, f64::NEG_INFINITY, f64::NEG_INFINITY);
        for step in 0..=16 {
            let share = f64::from(step) / 16.0;
            let (x, y) = (left + (right - left) * share, bottom + (top - bottom) * share);
            for corner in [[x, bottom], [x, top], [left, y], [right, y]] {
                let point = crs.unproject(corner)?;
                let (lat, lon) = (point.lat_deg(), point.lon_deg());
                bounds = (bounds.0.min(lon), bounds.1.min(lat), bounds.2.max(lon), bounds.3.max(lat));
            }
        }
        let (west_deg, south_deg, east_deg, north_deg) = bounds;
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
