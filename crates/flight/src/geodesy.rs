//! Geometry on the WGS-84 ellipsoid: distances, bearings, legs, local frames and polygons.
//!
//! Distances along the ground are geodesics (C. F. F. Karney, "Algorithms for geodesics", J. Geodesy 87,
//! 2013), from the `geographiclib-rs` crate. Local frames go through Earth-centred coordinates, so they
//! are exact at any distance.

use std::sync::LazyLock;

use geographiclib_rs::{DirectGeodesic, Geodesic, InverseGeodesic};

use crate::error::{FlightError, Result};

/// Equatorial radius of WGS-84, metres (NIMA TR8350.2, table 3.1).
pub const WGS84_A_M: f64 = 6_378_137.0;
/// Flattening of WGS-84 (NIMA TR8350.2, table 3.1).
pub const WGS84_F: f64 = 1.0 / 298.257_223_563;
/// First eccentricity squared.
const E2: f64 = WGS84_F * (2.0 - WGS84_F);

static WGS84: LazyLock<Geodesic> = LazyLock::new(Geodesic::wgs84);

/// A place on the ellipsoid: latitude −90 to 90, longitude −180 to 180 degrees, both finite.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GeoPoint {
    lat_deg: f64,
    lon_deg: f64,
}

impl GeoPoint {
    /// A checked point.
    ///
    /// # Errors
    /// [`FlightError::NotOnEarth`] when a value is not finite or out of range.
    pub fn new(lat_deg: f64, lon_deg: f64) -> Result<Self> {
        // written so that NaN fails
        if lat_deg.abs() <= 90.0 && lon_deg.abs() <= 180.0 {
            Ok(Self { lat_deg, lon_deg })
        } else {
            Err(FlightError::NotOnEarth { lat_deg, lon_deg })
        }
    }

    /// Latitude, degrees, north positive.
    pub const fn lat_deg(self) -> f64 {
        self.lat_deg
    }

    /// Longitude, degrees, east positive.
    pub const fn lon_deg(self) -> f64 {
        self.lon_deg
    }
}

impl std::fmt::Display for GeoPoint {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{:.7}, {:.7}", self.lat_deg, self.lon_deg)
    }
}

/// The shortest line between two points.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Line {
    /// Length, metres.
    pub distance_m: f64,
    /// Direction at the start, degrees clockwise from true north, 0 to 360.
    pub bearing_start_deg: f64,
    /// Direction at the end (onwards), degrees clockwise from true north, 0 to 360.
    pub bearing_end_deg: f64,
}

/// An angle brought to 0 (inclusive) … 360 (exclusive) degrees.
pub fn wrap_360_deg(angle_deg: f64) -> f64 {
    let wrapped = angle_deg.rem_euclid(360.0);
    // rem_euclid rounds up to 360 for tiny negative angles
    if wrapped >= 360.0 { 0.0 } else { wrapped }
}

/// An angle brought to −180 (inclusive) … 180 (exclusive) degrees.
pub fn wrap_180_deg(angle_deg: f64) -> f64 {
    let wrapped = wrap_360_deg(angle_deg);
    if wrapped >= 180.0 { wrapped - 360.0 } else { wrapped }
}

/// The shortest line from one point to another.
pub fn inverse(from: GeoPoint, to: GeoPoint) -> Line {
    let (distance_m, start_deg, end_deg, _) = WGS84.inverse(from.lat_deg, from.lon_deg, to.lat_deg, to.lon_deg);
    Line { distance_m, bearing_start_deg: wrap_360_deg(start_deg), bearing_end_deg: wrap_360_deg(end_deg) }
}

/// Where a line from a point, in a direction, ends after a distance (either sign).
pub fn direct(from: GeoPoint, bearing_deg: f64, distance_m: f64) -> GeoPoint {
    let (lat_deg, lon_deg, _) = WGS84.direct(from.lat_deg, from.lon_deg, bearing_deg, distance_m);
    GeoPoint { lat_deg: lat_deg.clamp(-90.0, 90.0), lon_deg: wrap_180_deg(lon_deg) }
}

/// Distance along the ground, metres.
pub fn distance_m(from: GeoPoint, to: GeoPoint) -> f64 {
    WGS84.inverse(from.lat_deg, from.lon_deg, to.lat_deg, to.lon_deg)
}

/// Direction from one point to another at the start, degrees clockwise from true north, 0 to 360.
pub fn bearing_deg(from: GeoPoint, to: GeoPoint) -> f64 {
    inverse(from, to).bearing_start_deg
}

/// Length of a line through points, metres.
#[cfg(test)]
pub(crate) fn polyline_length_m(points: &[GeoPoint]) -> f64 {
    points.windows(2).map(|pair| distance_m(pair[0], pair[1])).sum()
}

/// Points along the geodesic leg `from` → `to`, both ends included, equally far apart and at most `step_m` metres: what
/// a map must draw for a leg that bends.
///
/// At least one piece, at most [`MAX_PIECES`]; a `step_m` that is not above 0 gives that many.
pub fn points_along(from: GeoPoint, to: GeoPoint, step_m: f64) -> Vec<GeoPoint> {
    let leg = inverse(from, to);
    let wanted = (leg.distance_m / step_m).ceil();
    // written so that NaN and infinity give most
    let pieces = if wanted <= f64::from(MAX_PIECES) && step_m > 0.0 { (wanted as u32).max(1) } else { MAX_PIECES };
    let inner = (1..pieces).map(|piece| {
        let part = f64::from(piece) / f64::from(pieces);
        direct(from, leg.bearing_start_deg, leg.distance_m * part)
    });
    std::iter::once(from).chain(inner).chain(std::iter::once(to)).collect()
}

/// Most pieces into which [`points_along`] divides a leg: 20 km each for half the way around the Earth.
pub const MAX_PIECES: u32 = 1_024;

/// Where a position is with respect to a leg.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LegOffset {
    /// Distance along the leg of the nearest point on it (extended both ways), metres from its start;
    /// negative before the start.
    pub along_m: f64,
    /// Distance from that point, metres; positive to the right of the leg.
    pub cross_m: f64,
    /// Length of the leg, metres.
    pub length_m: f64,
}

/// Where `position` is with respect to the geodesic leg `from` → `to`.
///
/// The foot of the perpendicular is found by iteration: from a guess on the leg, step by the part of the
/// line to `position` that lies along the leg, until the step is below 0.1 mm. The error of one step is
/// of the order of the cross-track distance times (distance / Earth radius)², so two or three steps
/// do within a few hundred kilometres.
pub fn leg_offset(from: GeoPoint, to: GeoPoint, position: GeoPoint) -> LegOffset {
    let leg = inverse(from, to);
    if leg.distance_m == 0.0 {
        return LegOffset { along_m: 0.0, cross_m: distance_m(from, position), length_m: 0.0 };
    }
    let mut along_m = 0.0;
    let mut cross_m = 0.0;
    for _ in 0..20 {
        let (lat_deg, lon_deg, course_deg) = WGS84.direct(from.lat_deg, from.lon_deg, leg.bearing_start_deg, along_m);
        let (distance, bearing, _, _): (f64, f64, f64, f64) =
            WGS84.inverse(lat_deg, lon_deg, position.lat_deg, position.lon_deg);
        let angle = (bearing - course_deg).to_radians();
        let step = distance * angle.cos();
        cross_m = distance * angle.sin();
        along_m += step;
        if step.abs() < 1e-4 {
            break;
        }
    }
    LegOffset { along_m, cross_m, length_m: leg.distance_m }
}

/// `true` when a point lies inside a polygon.
///
/// Edges are straight in latitude and longitude, as autopilots take them, and may cross the date line; a
/// polygon around a pole is not supported. A polygon of fewer than three corners contains nothing.
pub fn point_in_polygon(point: GeoPoint, corners: &[GeoPoint]) -> bool {
    let Some(first) = corners.first().filter(|_| corners.len() >= 3) else { return false };
    // Longitudes unrolled from corner to corner, so that no edge jumps by 360 degrees.
    let mut unrolled = Vec::with_capacity(corners.len());
    let mut lon_deg = first.lon_deg;
    for corner in corners {
        lon_deg += wrap_180_deg(corner.lon_deg - lon_deg);
        unrolled.push((corner.lat_deg, lon_deg));
    }
    let (low, high) = unrolled
        .iter()
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), (_, lon)| (low.min(*lon), high.max(*lon)));
    [-360.0, 0.0, 360.0]
        .into_iter()
        .map(|turn| point.lon_deg + turn)
        .any(|lon_deg| (low..=high).contains(&lon_deg) && crosses_odd(&unrolled, point.lat_deg, lon_deg))
}

/// Even–odd rule: a ray to the north crosses the border an odd number of times.
fn crosses_odd(corners: &[(f64, f64)], lat_deg: f64, lon_deg: f64) -> bool {
    let mut inside = false;
    let mut previous = corners.len() - 1;
    for current in 0..corners.len() {
        let (lat_a, lon_a) = corners[previous];
        let (lat_b, lon_b) = corners[current];
        if (lon_a > lon_deg) != (lon_b > lon_deg) {
            let lat_at = lat_a + (lat_b - lat_a) * (lon_deg - lon_a) / (lon_b - lon_a);
            inside ^= lat_deg < lat_at;
        }
        previous = current;
    }
    inside
}

/// A tangent frame at an origin: north, east, down (or east, north, up), metres.
///
/// Conversions go through Earth-centred, Earth-fixed coordinates (ECEF); heights are above the
/// ellipsoid. Over a few kilometres a height above mean sea level may stand in: the geoid is almost
/// parallel.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LocalFrame {
    origin: GeoPoint,
    origin_height_m: f64,
    origin_ecef_m: [f64; 3],
    /// Rows north, east, down; columns x, y, z of ECEF.
    ned_from_ecef: [[f64; 3]; 3],
}

impl LocalFrame {
    /// The frame that touches the ellipsoid's parallel surface at this place and height (metres).
    pub fn new(origin: GeoPoint, origin_height_m: f64) -> Self {
        let (sin_lat, cos_lat) = origin.lat_deg.to_radians().sin_cos();
        let (sin_lon, cos_lon) = origin.lon_deg.to_radians().sin_cos();
        Self {
            origin,
            origin_height_m,
            origin_ecef_m: ecef_m(origin, origin_height_m),
            ned_from_ecef: [
                [-sin_lat * cos_lon, -sin_lat * sin_lon, cos_lat],
                [-sin_lon, cos_lon, 0.0],
                [-cos_lat * cos_lon, -cos_lat * sin_lon, -sin_lat],
            ],
        }
    }

    /// Where the frame touches.
    pub const fn origin(&self) -> GeoPoint {
        self.origin
    }

    /// Height of the origin, metres.
    pub const fn origin_height_m(&self) -> f64 {
        self.origin_height_m
    }

    /// North, east, down of a place, metres.
    pub fn ned_m(&self, point: GeoPoint, height_m: f64) -> [f64; 3] {
        let ecef = ecef_m(point, height_m);
        let delta = [0, 1, 2].map(|axis| ecef[axis] - self.origin_ecef_m[axis]);
        self.ned_from_ecef.map(|row| row[0] * delta[0] + row[1] * delta[1] + row[2] * delta[2])
    }

    /// East, north, up of a place, metres.
    pub fn enu_m(&self, point: GeoPoint, height_m: f64) -> [f64; 3] {
        let [north, east, down] = self.ned_m(point, height_m);
        [east, north, -down]
    }

    /// The place and height (metres) of north, east, down.
    pub fn geodetic_from_ned(&self, ned_m: [f64; 3]) -> (GeoPoint, f64) {
        let ecef = [0, 1, 2].map(|axis| {
            self.origin_ecef_m[axis] + (0..3).map(|row| self.ned_from_ecef[row][axis] * ned_m[row]).sum::<f64>()
        });
        geodetic_from_ecef(ecef)
    }
}

/// Earth-centred coordinates of a place and height above the ellipsoid, metres (NIMA TR8350.2, eq. 4-14).
pub fn ecef_m(point: GeoPoint, height_m: f64) -> [f64; 3] {
    let (sin_lat, cos_lat) = point.lat_deg.to_radians().sin_cos();
    let (sin_lon, cos_lon) = point.lon_deg.to_radians().sin_cos();
    let n = WGS84_A_M / (1.0 - E2 * sin_lat * sin_lat).sqrt();
    let r = (n + height_m) * cos_lat;
    [r * cos_lon, r * sin_lon, (n * (1.0 - E2) + height_m) * sin_lat]
}

/// Place and height above the ellipsoid (metres) of Earth-centred coordinates.
///
/// B. R. Bowring, "The accuracy of geodetic latitude and height equations", Survey Review 28 (1985),
/// iterated on the reduced latitude: exact to nanometres for any place above Earth's core.
pub fn geodetic_from_ecef(ecef_m: [f64; 3]) -> (GeoPoint, f64) {
    let [x, y, z] = ecef_m;
    let b = WGS84_A_M * (1.0 - WGS84_F);
    let second_e2 = E2 / (1.0 - E2);
    let p = x.hypot(y);
    let mut reduced = (z * WGS84_A_M).atan2(p * b);
    let mut lat = 0.0;
    for _ in 0..4 {
        let (sin_b, cos_b) = reduced.sin_cos();
        lat = (z + second_e2 * b * sin_b.powi(3)).atan2(p - E2 * WGS84_A_M * cos_b.powi(3));
        reduced = ((1.0 - WGS84_F) * lat.sin()).atan2(lat.cos());
    }
    let (sin_lat, cos_lat) = lat.sin_cos();
    // Bowring 1985, eq. 7: no division, so it holds at the poles too.
    let height_m = p * cos_lat + z * sin_lat - WGS84_A_M * (1.0 - E2 * sin_lat * sin_lat).sqrt();
    let lat_deg = lat.to_degrees().clamp(-90.0, 90.0);
    let lon_deg = y.atan2(x).to_degrees().clamp(-180.0, 180.0);
    (GeoPoint { lat_deg, lon_deg }, height_m)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn at(lat_deg: f64, lon_deg: f64) -> GeoPoint {
        GeoPoint::new(lat_deg, lon_deg).unwrap()
    }

    #[test]
    fn known_lines() {
        // Example of GeographicLib's GeodSolve: JFK to LHR.
        let line = inverse(at(40.6, -73.8), at(51.6, -0.5));
        assert!((line.distance_m - 5_551_759.400_318_679).abs() < 1e-3);
        assert!((line.bearing_start_deg - 51.198_882_845_579_824).abs() < 1e-9);
        assert!((line.bearing_end_deg - 107.821_776_735_514_22).abs() < 1e-9);
        // One degree of the equator.
        assert!((distance_m(at(0.0, 179.5), at(0.0, -179.5)) - 111_319.490_793).abs() < 1e-3);
    }

    #[test]
    fn points_off_the_globe_are_refused() {
        for (lat_deg, lon_deg) in [(90.1, 0.0), (0.0, -180.1), (f64::NAN, 0.0), (0.0, f64::INFINITY)] {
            assert!(GeoPoint::new(lat_deg, lon_deg).is_err());
        }
        assert!(GeoPoint::new(-90.0, 180.0).is_ok());
    }

    #[test]
    fn angles_wrap() {
        for (angle, to_360, to_180) in
            [(0.0, 0.0, 0.0), (360.0, 0.0, 0.0), (-90.0, 270.0, -90.0), (540.0, 180.0, -180.0), (-1e-20, 0.0, 0.0)]
        {
            assert_eq!(wrap_360_deg(angle), to_360);
            assert_eq!(wrap_180_deg(angle), to_180);
        }
    }

    #[test]
    fn offsets_have_the_sign_of_the_side() {
        let (from, to) = (at(40.0, -4.0), at(40.1, -4.0));
        let right = leg_offset(from, to, at(40.05, -3.99));
        assert!((right.cross_m - 854.0).abs() < 1.0 && (right.along_m - right.length_m / 2.0).abs() < 2.0);
        assert!(leg_offset(from, to, at(40.05, -4.01)).cross_m < 0.0);
        assert!(leg_offset(from, to, at(39.9, -4.0)).along_m < 0.0);
        assert_eq!(leg_offset(from, from, from), LegOffset { along_m: 0.0, cross_m: 0.0, length_m: 0.0 });
    }

    #[test]
    fn polygons_may_cross_the_date_line() {
        let square = |west: f64, east: f64| [at(-10.0, west), at(-10.0, east), at(10.0, east), at(10.0, west)];
        let pacific = square(170.0, -170.0);
        assert!(point_in_polygon(at(0.0, 180.0), &pacific));
        assert!(point_in_polygon(at(0.0, -180.0), &pacific));
        assert!(point_in_polygon(at(5.0, -175.0), &pacific));
        assert!(!point_in_polygon(at(0.0, 0.0), &pacific));
        assert!(!point_in_polygon(at(11.0, 175.0), &pacific));
        let greenwich = square(-10.0, 10.0);
        assert!(point_in_polygon(at(0.0, 0.0), &greenwich));
        assert!(!point_in_polygon(at(0.0, 180.0), &greenwich));
        assert!(!point_in_polygon(at(0.0, 0.0), &greenwich[..2]));
    }

    fn rows(csv: &str) -> Vec<(&str, Vec<f64>)> {
        csv.lines().skip(1).map(|row| (row, row.split(',').filter_map(|value| value.parse().ok()).collect())).collect()
    }

    #[test]
    fn geographiclib_measures_the_same_lines() {
        let rows = rows(include_str!("../../../tests/fixtures/geodesy/geodesics.csv"));
        assert!(rows.len() >= 500);
        for (row, values) in rows {
            let [lat1, lon1, lat2, lon2, azi1, _, s12, third_lat, third_lon] = values[..] else { panic!("{row}") };
            let (from, to, third) = (at(lat1, lon1), at(lat2, lon2), at(third_lat, third_lon));
            let line = inverse(from, to);
            assert!((line.distance_m - s12).abs() < 1e-6, "{row}: {line:?}");
            assert_eq!(distance_m(from, to), line.distance_m);
            // Our direction leads there, and theirs too; nearly antipodal places have more than one.
            for (bearing, onward) in [(line.bearing_start_deg, to), (wrap_360_deg(azi1), to)] {
                assert!(distance_m(direct(from, bearing, s12), onward) < 1e-6, "{row}: {bearing}");
            }
            assert!(distance_m(direct(from, azi1, s12 / 3.0), third) < 1e-6, "{row}");
            if wrap_180_deg(line.bearing_start_deg - azi1).abs() < 1e-6 {
                let points = points_along(from, to, s12 / 2.5);
                assert!(s12 == 0.0 || points.len() == 4, "{row}");
                assert!(s12 == 0.0 || distance_m(points[1], third) < 1e-3, "{row}");
                assert!((polyline_length_m(&points) - s12).abs() < 1e-6, "{row}");
            }
        }
    }

    #[test]
    fn proj_sees_the_same_local_frames() {
        let rows = rows(include_str!("../../../tests/fixtures/geodesy/local.csv"));
        assert!(rows.len() >= 100);
        let apart = |a: [f64; 3], b: [f64; 3]| (0..3).map(|axis| (a[axis] - b[axis]).powi(2)).sum::<f64>().sqrt();
        for (row, values) in rows {
            let [lat0, lon0, h0, lat, lon, h, x, y, z, east, north, up] = values[..] else { panic!("{row}") };
            let (frame, place) = (LocalFrame::new(at(lat0, lon0), h0), at(lat, lon));
            assert!(apart(ecef_m(place, h), [x, y, z]) < 1e-8, "{row}");
            assert!(apart(frame.enu_m(place, h), [east, north, up]) < 2e-8, "{row}");
            for (back, height_m) in [geodetic_from_ecef([x, y, z]), frame.geodetic_from_ned([north, east, -up])] {
                assert!(distance_m(back, place) < 1e-6 && (height_m - h).abs() < 1e-6, "{row}: {back} {height_m}");
            }
        }
    }

    #[test]
    fn a_leg_is_divided_within_bounds() {
        let (from, to) = (at(40.0, -4.0), at(40.0, 4.0));
        assert_eq!(points_along(from, to, 1e9), [from, to]);
        assert_eq!(points_along(from, from, 100.0), [from, from]);
        let points = points_along(from, to, 20_000.0);
        assert_eq!(points.len(), 36);
        // The shortest way between places of one latitude leads nearer to the pole.
        assert!(points[17].lat_deg() > 40.0);
        for step_m in [0.0, -1.0, f64::NAN, 1e-9] {
            assert_eq!(points_along(from, to, step_m).len(), MAX_PIECES as usize + 1);
        }
        let dateline = points_along(at(0.0, 179.0), at(0.0, -179.0), 50_000.0);
        assert!(dateline.windows(2).all(|pair| distance_m(pair[0], pair[1]) < 50_000.0));
    }

    fn places() -> impl Strategy<Value = GeoPoint> {
        (-89.9..89.9_f64, -180.0..180.0_f64).prop_map(|(lat, lon)| at(lat, lon))
    }

    proptest! {
        #[test]
        fn direct_undoes_inverse(a in places(), b in places()) {
            let line = inverse(a, b);
            prop_assert!((0.0..360.0).contains(&line.bearing_start_deg));
            let back = direct(a, line.bearing_start_deg, line.distance_m);
            prop_assert!(distance_m(back, b) <= 1e-3, "{} m off", distance_m(back, b));
        }

        #[test]
        fn a_leg_offset_rebuilds_the_position(
            a in (-80.0..80.0_f64, -180.0..180.0_f64), course in 0.0..360.0_f64,
            length in 10.0..50_000.0_f64, along in -20_000.0..60_000.0_f64, cross in -20_000.0..20_000.0_f64,
        ) {
            let from = at(a.0, a.1);
            let to = direct(from, course, length);
            let bearing = inverse(from, to).bearing_start_deg;
            let foot = direct(from, bearing, along);
            let onward = if along == 0.0 { bearing } else {
                let line = inverse(from, foot);
                if along > 0.0 { line.bearing_end_deg } else { line.bearing_end_deg + 180.0 }
            };
            let position = direct(foot, onward + 90.0, cross);
            let offset = leg_offset(from, to, position);
            prop_assert!((offset.along_m - along).abs() < 0.01, "{offset:?}");
            prop_assert!((offset.cross_m - cross).abs() < 0.01, "{offset:?}");
        }

        #[test]
        fn local_frames_go_there_and_back(
            origin in places(), ned in prop::array::uniform3(-100_000.0..100_000.0_f64), height in -100.0..5_000.0_f64,
        ) {
            let frame = LocalFrame::new(origin, height);
            let (point, height_m) = frame.geodetic_from_ned(ned);
            let again = frame.ned_m(point, height_m);
            for axis in 0..3 {
                prop_assert!((again[axis] - ned[axis]).abs() < 1e-6);
            }
            let [east, north, up] = frame.enu_m(point, height_m);
            prop_assert!((north - ned[0]).abs() < 1e-6 && (east - ned[1]).abs() < 1e-6 && (up + ned[2]).abs() < 1e-6);
        }

        #[test]
        fn a_local_frame_agrees_with_geodesics_nearby(
            origin in places(), course in 0.0..360.0_f64, distance in 1.0..1_000.0_f64,
        ) {
            let [north, east, down] = LocalFrame::new(origin, 0.0).ned_m(direct(origin, course, distance), 0.0);
            prop_assert!((north.hypot(east) - distance).abs() < 0.01);
            prop_assert!((wrap_180_deg(east.atan2(north).to_degrees() - course)).abs() < 0.01);
            prop_assert!((0.0..0.1).contains(&(down + 1e-6)));
        }
    }
}
