//! Coordinates of maps: Web Mercator and Universal Transverse Mercator, to and from latitude and longitude on WGS-84.
//!
//! Eastings and northings in metres, easting first. Formulas only: which names and axis orders services use for them is
//! their reader's business. ETRS89 in UTM (EPSG:258xx) differs from WGS-84 by its ellipsoid's 0.1 mm and by less than a
//! metre of drift of the European plate; these functions serve it too.

use std::f64::consts::PI;

use crate::geodesy::{GeoPoint, WGS84_A_M, WGS84_F};

/// Latitude at which Web Mercator's square ends, degrees: atan(sinh π).
pub const WEB_MERCATOR_MAX_LAT_DEG: f64 = 85.051_128_779_806_59;
/// Half the side of Web Mercator's square (EPSG:3857), metres.
pub const WEB_MERCATOR_HALF_M: f64 = PI * WGS84_A_M;

/// Easting and northing in EPSG:3857 of a place; latitudes beyond ±[`WEB_MERCATOR_MAX_LAT_DEG`] are brought to the
/// edge. Longitudes beyond ±180 go on, so that a line over the date line stays whole.
///
/// J. P. Snyder, "Map Projections: A Working Manual", USGS Professional Paper 1395 (1987), eq. 7-1 and 7-2, on the
/// sphere of radius a.
pub fn web_mercator_from_geo(lat_deg: f64, lon_deg: f64) -> [f64; 2] {
    let lat = lat_deg.clamp(-WEB_MERCATOR_MAX_LAT_DEG, WEB_MERCATOR_MAX_LAT_DEG).to_radians();
    [WGS84_A_M * lon_deg.to_radians(), WGS84_A_M * lat.tan().asinh()]
}

/// Latitude and longitude, degrees, of EPSG:3857; the longitude is not wrapped. Snyder 1987, eq. 7-4 and 7-5.
pub fn geo_from_web_mercator(x_m: f64, y_m: f64) -> (f64, f64) {
    ((y_m / WGS84_A_M).sinh().atan().to_degrees(), (x_m / WGS84_A_M).to_degrees())
}

/// A zone of Universal Transverse Mercator: a number from 1 to 60 and a hemisphere.
///
/// Krüger's series to n⁶ (C. F. F. Karney, "Transverse Mercator with an accuracy of a few nanometers", J. Geodesy 85
/// (2011), eq. 7 to 36): within 5 nm up to 3 900 km from the central meridian, and still good to a millimetre at 7 600
/// km.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct UtmZone {
    number: u8,
    is_north: bool,
}

impl UtmZone {
    /// The zone of a number from 1 to 60; `None` for others.
    pub const fn new(number: u8, is_north: bool) -> Option<Self> {
        if number >= 1 && number <= 60 { Some(Self { number, is_north }) } else { None }
    }

    /// The zone that maps of a place are made in, with the exceptions of Norway and Svalbard (NIMA TM8358.2, figure 2).
    /// UTM ends at 84° north and 80° south; beyond, this is the zone of the meridian all the same.
    pub fn containing(place: GeoPoint) -> Self {
        let (lat, lon) = (place.lat_deg(), place.lon_deg());
        let number = match (lat, lon) {
            (56.0..64.0, 3.0..12.0) => 32,
            (72.0..=84.0, 0.0..9.0) => 31,
            (72.0..=84.0, 9.0..21.0) => 33,
            (72.0..=84.0, 21.0..33.0) => 35,
            (72.0..=84.0, 33.0..42.0) => 37,
            // 180° east is 180° west, the edge of zone 1
            _ => ((lon + 180.0) / 6.0).floor() as u8 % 60 + 1,
        };
        Self { number, is_north: lat >= 0.0 }
    }

    /// 1 (180° to 174° west) to 60.
    pub const fn number(self) -> u8 {
        self.number
    }

    /// `true` for the northern hemisphere: northings count from the equator, else from 10 000 km south of it.
    pub const fn is_north(self) -> bool {
        self.is_north
    }

    /// Its code in the EPSG register on WGS-84: 32601 to 32660, 32701 to 32760.
    pub const fn epsg(self) -> u32 {
        (if self.is_north { 32_600 } else { 32_700 }) + self.number as u32
    }

    /// Its central meridian, degrees east.
    pub fn central_lon_deg(self) -> f64 {
        f64::from(self.number) * 6.0 - 183.0
    }

    /// Easting and northing of a place, metres. It may lie outside of the zone.
    pub fn project(self, lat_deg: f64, lon_deg: f64) -> [f64; 2] {
        let lon = (lon_deg - self.central_lon_deg()).to_radians();
        let tau = conformal(lat_deg.to_radians().tan());
        // eq. 10: the sphere's transverse Mercator of the conformal latitude
        let xi = tau.atan2(lon.cos());
        let eta = (lon.sin() / tau.hypot(lon.cos())).asinh();
        let (xi, eta) = add_series(&FORWARD, 1.0, xi, eta);
        [FALSE_EASTING_M + SCALE_M * eta, self.false_northing_m() + SCALE_M * xi]
    }

    /// Latitude and longitude, degrees, of an easting and a northing; the longitude is not wrapped.
    pub fn unproject(self, x_m: f64, y_m: f64) -> (f64, f64) {
        let xi = (y_m - self.false_northing_m()) / SCALE_M;
        let eta = (x_m - FALSE_EASTING_M) / SCALE_M;
        let (xi, eta) = add_series(&INVERSE, -1.0, xi, eta);
        // eq. 18
        let tau_conformal = xi.sin() / eta.sinh().hypot(xi.cos());
        let lon = eta.sinh().atan2(xi.cos());
        // eq. 19 to 21: Newton's method, which gains the last digit in two or three steps
        let mut tau = tau_conformal;
        for _ in 0..5 {
            let found = conformal(tau);
            tau += (tau_conformal - found) / found.hypot(1.0) * (1.0 + (1.0 - E2) * tau * tau)
                / ((1.0 - E2) * tau.hypot(1.0));
        }
        (tau.atan().to_degrees(), self.central_lon_deg() + lon.to_degrees())
    }

    const fn false_northing_m(self) -> f64 {
        if self.is_north { 0.0 } else { 10_000_000.0 }
    }
}

const FALSE_EASTING_M: f64 = 500_000.0;
const E2: f64 = WGS84_F * (2.0 - WGS84_F);
const N: f64 = WGS84_F / (2.0 - WGS84_F);
/// Scale on the central meridian, 0.9996, times the rectifying radius (eq. 14).
const SCALE_M: f64 = 0.9996 * WGS84_A_M / (1.0 + N) * (1.0 + N * N / 4.0 * (1.0 + N * N / 16.0 * (1.0 + N * N / 4.0)));

/// Coefficients α of eq. 12, from eq. 35.
const FORWARD: [f64; 6] = polynomials([
    [1.0 / 2.0, -2.0 / 3.0, 5.0 / 16.0, 41.0 / 180.0, -127.0 / 288.0, 7_891.0 / 37_800.0],
    [0.0, 13.0 / 48.0, -3.0 / 5.0, 557.0 / 1_440.0, 281.0 / 630.0, -1_983_433.0 / 1_935_360.0],
    [0.0, 0.0, 61.0 / 240.0, -103.0 / 140.0, 15_061.0 / 26_880.0, 167_603.0 / 181_440.0],
    [0.0, 0.0, 0.0, 49_561.0 / 161_280.0, -179.0 / 168.0, 6_601_661.0 / 7_257_600.0],
    [0.0, 0.0, 0.0, 0.0, 34_729.0 / 80_640.0, -3_418_889.0 / 1_995_840.0],
    [0.0, 0.0, 0.0, 0.0, 0.0, 212_378_941.0 / 319_334_400.0],
]);

/// Coefficients β of eq. 12, from eq. 36.
const INVERSE: [f64; 6] = polynomials([
    [1.0 / 2.0, -2.0 / 3.0, 37.0 / 96.0, -1.0 / 360.0, -81.0 / 512.0, 96_199.0 / 604_800.0],
    [0.0, 1.0 / 48.0, 1.0 / 15.0, -437.0 / 1_440.0, 46.0 / 105.0, -1_118_711.0 / 3_870_720.0],
    [0.0, 0.0, 17.0 / 480.0, -37.0 / 840.0, -209.0 / 4_480.0, 5_569.0 / 90_720.0],
    [0.0, 0.0, 0.0, 4_397.0 / 161_280.0, -11.0 / 504.0, -830_251.0 / 7_257_600.0],
    [0.0, 0.0, 0.0, 0.0, 4_583.0 / 161_280.0, -108_847.0 / 3_991_680.0],
    [0.0, 0.0, 0.0, 0.0, 0.0, 20_648_693.0 / 638_668_800.0],
]);

/// Each row as a polynomial in n, its first term of degree 1.
const fn polynomials(rows: [[f64; 6]; 6]) -> [f64; 6] {
    let mut values = [0.0; 6];
    let mut row = 0;
    while row < 6 {
        let mut term = 6;
        while term > 0 {
            term -= 1;
            values[row] = (values[row] + rows[row][term]) * N;
        }
        row += 1;
    }
    values
}

/// ξ and η with the series of eq. 11 (sign 1) or 15 (sign −1) added.
fn add_series(coefficients: &[f64; 6], sign: f64, xi: f64, eta: f64) -> (f64, f64) {
    let (mut sum_xi, mut sum_eta) = (xi, eta);
    for (order, coefficient) in (1_u8..).zip(coefficients) {
        let twice = 2.0 * f64::from(order);
        let (sin, cos) = (twice * xi).sin_cos();
        sum_xi += sign * coefficient * sin * (twice * eta).cosh();
        sum_eta += sign * coefficient * cos * (twice * eta).sinh();
    }
    (sum_xi, sum_eta)
}

/// Tangent of the conformal latitude from that of the latitude (eq. 7 to 9).
fn conformal(tau: f64) -> f64 {
    let e = E2.sqrt();
    let sigma = (e * (e * tau / tau.hypot(1.0)).atanh()).sinh();
    tau * sigma.hypot(1.0) - sigma * tau.hypot(1.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geodesy::{distance_m, wrap_180_deg};
    use proptest::prelude::*;

    const PROJECTED: &str = include_str!("../../../tests/fixtures/geodesy/projections.csv");

    fn zone(epsg: u32) -> UtmZone {
        UtmZone::new((epsg % 100) as u8, epsg < 32_700).unwrap()
    }

    #[test]
    fn proj_puts_places_where_we_do() {
        let mut checked = [0, 0];
        for row in PROJECTED.lines().skip(1) {
            let values: Vec<f64> = row.split(',').map(|value| value.parse().unwrap()).collect();
            let [epsg, lat_deg, lon_deg, x_m, y_m] = values[..] else { panic!("{row}") };
            let (found, back) = if epsg == 3857.0 {
                checked[0] += 1;
                (web_mercator_from_geo(lat_deg, lon_deg), geo_from_web_mercator(x_m, y_m))
            } else {
                checked[1] += 1;
                let zone = zone(epsg as u32);
                assert_eq!(f64::from(zone.epsg()), epsg);
                (zone.project(lat_deg, lon_deg), zone.unproject(x_m, y_m))
            };
            let off_m = (found[0] - x_m).hypot(found[1] - y_m);
            // a few rounding errors of ten thousand kilometres
            assert!(off_m < 2e-8, "{row}: {found:?} is {off_m} m off");
            let there = GeoPoint::new(back.0, wrap_180_deg(back.1)).unwrap();
            let off_m = distance_m(there, GeoPoint::new(lat_deg, lon_deg).unwrap());
            assert!(off_m < 2e-8, "{row}: {there} is {off_m} m off");
        }
        assert_eq!(checked, [100, 400]);
    }

    #[test]
    fn edges_of_the_square_and_poles() {
        let [x_m, y_m] = web_mercator_from_geo(90.0, 180.0);
        assert!((x_m - WEB_MERCATOR_HALF_M).abs() < 1e-7 && (y_m - WEB_MERCATOR_HALF_M).abs() < 1e-7);
        for (number, is_north) in [(1, true), (60, false)] {
            let zone = UtmZone::new(number, is_north).unwrap();
            for lat_deg in [-90.0, 90.0] {
                let [x_m, y_m] = zone.project(lat_deg, 17.0);
                assert!((x_m - 500_000.0).abs() < 1e-6);
                let (back_deg, _) = zone.unproject(x_m, y_m);
                assert!((back_deg - lat_deg).abs() < 1e-9);
            }
        }
    }

    #[test]
    fn zones_of_places() {
        for (lat_deg, lon_deg, number, is_north) in [
            (40.33, -3.80, 30, true),
            (0.0, -180.0, 1, true),
            (-0.1, 180.0, 1, false),
            (10.0, 179.9, 60, true),
            (60.4, 5.3, 32, true), // Bergen
            (55.9, 5.3, 31, true),
            (78.2, 15.6, 33, true), // Longyearbyen
            (78.2, 20.9, 33, true),
            (78.2, 21.0, 35, true),
            (78.2, 42.0, 38, true),
            (-54.8, -68.3, 19, false),
        ] {
            let zone = UtmZone::containing(GeoPoint::new(lat_deg, lon_deg).unwrap());
            assert_eq!((zone.number(), zone.is_north()), (number, is_north), "{lat_deg}, {lon_deg}");
        }
        assert!(UtmZone::new(0, true).is_none() && UtmZone::new(61, false).is_none());
    }

    proptest! {
        #[test]
        fn there_and_back(number in 1_u8..=60, is_north: bool, lat_deg in -89.9..89.9_f64, aside_deg in -30.0..30.0_f64) {
            let zone = UtmZone::new(number, is_north).unwrap();
            let place = GeoPoint::new(lat_deg, wrap_180_deg(zone.central_lon_deg() + aside_deg)).unwrap();
            let [x_m, y_m] = zone.project(place.lat_deg(), place.lon_deg());
            let (lat_deg, lon_deg) = zone.unproject(x_m, y_m);
            let back = GeoPoint::new(lat_deg, wrap_180_deg(lon_deg)).unwrap();
            prop_assert!(distance_m(place, back) < 1e-7, "{} m off", distance_m(place, back));
            let [x_m, y_m] = web_mercator_from_geo(place.lat_deg().clamp(-85.0, 85.0), place.lon_deg());
            let (lat_deg, lon_deg) = geo_from_web_mercator(x_m, y_m);
            prop_assert!((lat_deg - place.lat_deg().clamp(-85.0, 85.0)).abs() < 1e-12);
            prop_assert!((lon_deg - place.lon_deg()).abs() < 1e-12);
        }
    }
}
