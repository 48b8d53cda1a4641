//! The coordinate reference systems that maps come in, by their EPSG codes, and the way between them and places on
//! Earth.
//!
//! Coordinates here are always easting or longitude first, as browsers take them. The axis order of services is given
//! by [`Crs::is_north_first`].

use std::f64::consts::PI;

use vencejo_flight::crs::{UtmZone, geo_from_web_mercator, web_mercator_from_geo};
pub use vencejo_flight::crs::{
    WEB_MERCATOR_HALF_M as MERCATOR_HALF_M, WEB_MERCATOR_MAX_LAT_DEG as MERCATOR_MAX_LAT_DEG,
};
use vencejo_flight::geodesy::{GeoPoint, WGS84_A_M, wrap_180_deg};

/// Metres of a degree of the equator, by which WMTS counts the size of pixels in degrees (OGC 07-057r7, annex E).
pub const METRES_PER_DEGREE: f64 = WGS84_A_M * PI / 180.0;

/// A coordinate reference system that both the server and the browser know.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Crs {
    /// EPSG:3857, and its old name 900913.
    WebMercator,
    /// Longitude and latitude in degrees: EPSG:4326 and, for Europe, 4258.
    Geographic {
        /// 4326 or 4258.
        epsg: u32,
    },
    /// Longitude and latitude with longitude first for services too (OGC's CRS:84).
    Crs84,
    /// Universal Transverse Mercator: EPSG:326xx, 327xx (WGS 84) and 25828 to 25838 (ETRS89).
    Utm {
        /// Its code.
        epsg: u32,
        /// Its zone.
        zone: UtmZone,
    },
}

impl Crs {
    /// The system of a code or name: `EPSG:25830`, `urn:ogc:def:crs:EPSG::25830`, `CRS:84`,
    /// `http://www.opengis.net/def/crs/EPSG/0/3857`.
    pub fn parse(name: &str) -> Option<Self> {
        let name = name.trim().to_ascii_uppercase();
        let code = name.rsplit([':', '/', '#']).next()?;
        if name.contains("CRS84") || (name.contains("CRS") && code == "84") {
            return Some(Self::Crs84);
        }
        if !name.contains("EPSG") {
            return None;
        }
        Self::from_epsg(code.parse().ok()?)
    }

    /// The system of an EPSG code.
    pub fn from_epsg(epsg: u32) -> Option<Self> {
        let (number, is_north) = match epsg {
            3857 | 900_913 | 102_100 | 102_113 | 3785 => return Some(Self::WebMercator),
            4326 | 4258 => return Some(Self::Geographic { epsg }),
            32_601..=32_660 => (epsg - 32_600, true),
            32_701..=32_760 => (epsg - 32_700, false),
            25_828..=25_838 => (epsg - 25_800, true),
            _ => return None,
        };
        Some(Self::Utm { epsg, zone: UtmZone::new(u8::try_from(number).ok()?, is_north)? })
    }

    /// Its code as OpenLayers and services write it.
    pub fn code(self) -> String {
        match self {
            Self::WebMercator => "EPSG:3857".to_owned(),
            Self::Geographic { epsg } | Self::Utm { epsg, .. } => format!("EPSG:{epsg}"),
            Self::Crs84 => "CRS:84".to_owned(),
        }
    }

    /// The code for a browser, which knows no [`Crs::Crs84`] apart from 4326.
    pub fn browser_code(self) -> String {
        if self == Self::Crs84 { "EPSG:4326".to_owned() } else { self.code() }
    }

    /// Its definition for proj4, where browsers do not bring it along.
    pub fn proj4(self) -> Option<String> {
        match self {
            Self::WebMercator | Self::Crs84 | Self::Geographic { epsg: 4326 } => None,
            Self::Geographic { .. } => Some("+proj=longlat +ellps=GRS80 +towgs84=0,0,0,0,0,0,0 +no_defs".to_owned()),
            Self::Utm { epsg, zone } => {
                let datum = if epsg < 30_000 { "+ellps=GRS80 +towgs84=0,0,0,0,0,0,0" } else { "+datum=WGS84" };
                let south = if zone.is_north() { "" } else { " +south" };
                Some(format!("+proj=utm +zone={}{south} {datum} +units=m +no_defs", zone.number()))
            }
        }
    }

    /// Whether services that follow the EPSG register (WMS 1.3.0, WMTS) expect latitude first.
    pub const fn is_north_first(self) -> bool {
        matches!(self, Self::Geographic { .. })
    }

    /// Whether coordinates are degrees.
    pub const fn is_degrees(self) -> bool {
        matches!(self, Self::Geographic { .. } | Self::Crs84)
    }

    /// Metres of a unit, as WMTS counts them.
    pub const fn metres_per_unit(self) -> f64 {
        if self.is_degrees() { METRES_PER_DEGREE } else { 1.0 }
    }

    /// How wide the world is, where it is round from east to west.
    pub const fn world_width(self) -> Option<f64> {
        match self {
            Self::WebMercator => Some(2.0 * MERCATOR_HALF_M),
            Self::Geographic { .. } | Self::Crs84 => Some(360.0),
            Self::Utm { .. } => None,
        }
    }

    /// Easting or longitude, and northing or latitude, of a place. Latitudes beyond Web Mercator's square are brought
    /// to its edge. A longitude may go beyond ±180, so that areas over the date line stay whole.
    pub fn project(self, lat_deg: f64, lon_deg: f64) -> [f64; 2] {
        match self {
            Self::WebMercator => web_mercator_from_geo(lat_deg, lon_deg),
            Self::Geographic { .. } | Self::Crs84 => [lon_deg, lat_deg],
            Self::Utm { zone, .. } => zone.project(lat_deg, lon_deg),
        }
    }

    /// The place of coordinates; `None` when they are off the map.
    pub fn unproject(self, [x, y]: [f64; 2]) -> Option<GeoPoint> {
        let (lat_deg, lon_deg) = match self {
            Self::WebMercator => geo_from_web_mercator(x, y),
            Self::Geographic { .. } | Self::Crs84 => (y, x),
            Self::Utm { zone, .. } => zone.unproject(x, y),
        };
        GeoPoint::new(lat_deg.clamp(-90.0, 90.0), wrap_180_deg(lon_deg)).ok()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn names_of_all_kinds_are_understood() {
        for (name, code, north_first) in [
            ("EPSG:3857", "EPSG:3857", false),
            ("epsg:900913", "EPSG:3857", false),
            ("urn:ogc:def:crs:EPSG::25830", "EPSG:25830", false),
            ("urn:ogc:def:crs:EPSG:6.18.3:3857", "EPSG:3857", false),
            ("http://www.opengis.net/def/crs/EPSG/0/4326", "EPSG:4326", true),
            ("http://www.opengis.net/gml/srs/epsg.xml#4258", "EPSG:4258", true),
            ("CRS:84", "CRS:84", false),
            ("urn:ogc:def:crs:OGC:1.3:CRS84", "CRS:84", false),
            ("EPSG:32730", "EPSG:32730", false),
        ] {
            let crs = Crs::parse(name).unwrap_or_else(|| panic!("{name}"));
            assert_eq!((crs.code().as_str(), crs.is_north_first()), (code, north_first), "{name}");
        }
        for name in ["", "EPSG:", "EPSG:2154", "EPSG:32661", "EPSG:25827", "AUTO:42001", "4326"] {
            assert_eq!(Crs::parse(name), None, "{name}");
        }
    }

    #[test]
    fn known_places_are_where_they_must_be() {
        // The corners of a square, and a zone's central meridian, where UTM is exact by definition.
        let utm = Crs::from_epsg(25_830).expect("known");
        let [x, y] = utm.project(0.0, -3.0);
        assert!((x - 500_000.0).abs() < 1e-6 && y.abs() < 1e-6);
        assert_eq!(Crs::from_epsg(4326).expect("known").project(40.3332, -3.7978), [-3.7978, 40.3332]);
        let [x, y] = Crs::WebMercator.project(MERCATOR_MAX_LAT_DEG, 180.0);
        assert!((x - MERCATOR_HALF_M).abs() < 1e-6 && (y - MERCATOR_HALF_M).abs() < 1e-6);
    }

    proptest! {
        #[test]
        fn there_and_back(zone in 1_u8..=60, lat in -79.0..79.0_f64, off in -5.0..5.0_f64) {
            let lon = f64::from(zone) * 6.0 - 183.0 + off;
            let north = Crs::from_epsg(32_600 + u32::from(zone)).expect("known");
            let south = Crs::from_epsg(32_700 + u32::from(zone)).expect("known");
            for crs in [Crs::WebMercator, Crs::Geographic { epsg: 4326 }, north, south] {
                let back = crs.unproject(crs.project(lat, lon)).expect("on Earth");
                let turn = wrap_180_deg(back.lon_deg() - lon);
                prop_assert!((back.lat_deg() - lat).abs() < 1e-9 && turn.abs() < 1e-9, "{crs:?} {back}");
            }
        }
    }
}
