//! Pieces of a way, drawn or flown, held against the border of a fence's zone.

use crate::geodesy::{GeoPoint, LocalFrame, wrap_180_deg};
use crate::plan::{FenceShape, FenceZone};

/// Metres of a degree of latitude, less than anywhere on Earth.
const M_PER_DEG_LEAST: f64 = 110_000.0;
/// Latitude from which on a circle may lie around a pole, degrees.
const POLAR_DEG: f64 = 89.0;
/// Shortest part of a piece that counts: less is rounding where it touches a border.
const LEAST_PART: f64 = 1e-9;
/// Half width from which on a zone is taken to reach all round the globe, degrees of longitude.
const WIDE_DEG: f64 = 90.0;

/// Two coordinates on a plane.
type Flat = (f64, f64);

/// A zone, with what many pieces are held against.
pub(super) struct Border<'a> {
    zone: &'a FenceZone,
    /// What touches the ground at the middle of a circle.
    frame: LocalFrame,
    /// A box around the zone, degrees: its middle, and half of its height and width.
    middle: GeoPoint,
    half_lat_deg: f64,
    half_lon_deg: f64,
}

impl<'a> Border<'a> {
    /// The border of a sound zone.
    pub fn of(zone: &'a FenceZone) -> Self {
        let (middle, half_lat_deg, half_lon_deg) = match &zone.shape {
            FenceShape::Polygon { vertices } => box_of(vertices),
            FenceShape::Circle { center, radius_m } => {
                let half_lat_deg = radius_m / M_PER_DEG_LEAST;
                let farthest_deg = center.lat_deg().abs() + half_lat_deg;
                let is_polar = farthest_deg >= POLAR_DEG;
                let half_lon_deg = half_lat_deg / farthest_deg.to_radians().cos();
                (*center, half_lat_deg, if is_polar { f64::INFINITY } else { half_lon_deg })
            }
        };
        let half_lon_deg = if half_lon_deg >= WIDE_DEG { f64::INFINITY } else { half_lon_deg };
        Self { zone, frame: LocalFrame::new(middle, 0.0), middle, half_lat_deg, half_lon_deg }
    }

    /// Whether a piece ends on the wrong side, or gets there on the way.
    pub fn is_broken(&self, from: GeoPoint, to: GeoPoint) -> bool {
        let is_inclusion = self.zone.inclusion;
        if !is_inclusion && !self.may_touch(from, to) {
            return false;
        }
        self.zone.shape.contains(to) != is_inclusion || self.is_crossed(from, to)
    }

    /// Whether a piece between two allowed places leaves an inclusion zone or enters an exclusion zone.
    pub fn is_crossed(&self, from: GeoPoint, to: GeoPoint) -> bool {
        match &self.zone.shape {
            // A circle is convex: a piece between two places inside stays inside.
            FenceShape::Circle { .. } if self.zone.inclusion => false,
            _ if !self.may_touch(from, to) => false,
            FenceShape::Polygon { vertices } => crosses_border(self.zone, vertices, from, to),
            FenceShape::Circle { radius_m, .. } => {
                let flat = |point| {
                    let [north_m, east_m, _] = self.frame.ned_m(point, 0.0);
                    (north_m, east_m)
                };
                distance_to_segment(flat(from), flat(to)) < *radius_m
            }
        }
    }

    /// Whether a piece comes near the box around the zone: `false` is sure, `true` is not.
    fn may_touch(&self, from: GeoPoint, to: GeoPoint) -> bool {
        let (lat, lon) = (from.lat_deg() - self.middle.lat_deg(), wrap_180_deg(from.lon_deg() - self.middle.lon_deg()));
        let (by_lat, by_lon) = (to.lat_deg() - from.lat_deg(), wrap_180_deg(to.lon_deg() - from.lon_deg()));
        // The straight line on the ground leaves that between the degrees, and by less than it is long.
        let bow = by_lat.abs() + by_lon.abs();
        let meets = |at: f64, by: f64, half: f64| at.min(at + by) <= half + bow && at.max(at + by) >= -half - bow;
        meets(lat, by_lat, self.half_lat_deg)
            && [-360.0, 0.0, 360.0].iter().any(|turn| meets(lon + turn, by_lon, self.half_lon_deg))
    }
}

/// The middle of a box around the corners of a polygon, and half of its height and width, degrees.
fn box_of(vertices: &[GeoPoint]) -> (GeoPoint, f64, f64) {
    let first = vertices[0];
    let mut lon = first.lon_deg();
    let (mut south, mut north, mut west, mut east) = (first.lat_deg(), first.lat_deg(), lon, lon);
    for corner in vertices {
        lon += wrap_180_deg(corner.lon_deg() - lon);
        (south, north) = (south.min(corner.lat_deg()), north.max(corner.lat_deg()));
        (west, east) = (west.min(lon), east.max(lon));
    }
    let middle = GeoPoint::new(f64::midpoint(south, north), wrap_180_deg(f64::midpoint(west, east)));
    (middle.unwrap_or(first), (north - south) / 2.0, (east - west) / 2.0)
}

/// Whether a piece lies on the wrong side of a polygon's border for a part of its way, ends aside: between two of the places at which it meets
/// an edge. To touch the border, or to go along an edge, is no part.
fn crosses_border(zone: &FenceZone, vertices: &[GeoPoint], from: GeoPoint, to: GeoPoint) -> bool {
    let flat = |point: GeoPoint| (wrap_180_deg(point.lon_deg() - from.lon_deg()), point.lat_deg() - from.lat_deg());
    let (dx, dy) = flat(to);
    let length2 = dx * dx + dy * dy;
    if length2 == 0.0 {
        return false;
    }
    let side = |(x, y): Flat| dx * y - dy * x;
    let part = |(x, y): Flat| (dx * x + dy * y) / length2;
    let mut meets = Vec::new();
    let mut edges_along = Vec::new();
    let mut a = flat(vertices[vertices.len() - 1]);
    for vertex in vertices {
        let b = flat(*vertex);
        let (side_a, side_b) = (side(a), side(b));
        if (a.0 - b.0).abs() >= 180.0 || side_a * side_b > 0.0 {
            // An edge that wraps round the globe is far from the piece; one on one side of it does not meet it.
        } else if side_a == side_b {
            meets.extend([part(a), part(b)]);
            edges_along.push((part(a).min(part(b)), part(a).max(part(b))));
        } else {
            let along = side_a / (side_a - side_b);
            meets.push(part((a.0 + along * (b.0 - a.0), a.1 + along * (b.1 - a.1))));
        }
        a = b;
    }
    if meets.is_empty() {
        return false;
    }
    meets.retain(|at| (0.0..=1.0).contains(at));
    meets.extend([0.0, 1.0]);
    meets.sort_by(f64::total_cmp);
    let is_along = |at: f64| edges_along.iter().any(|(low, high)| (*low..=*high).contains(&at));
    let is_wrong = |at: f64| {
        let point = GeoPoint::new(from.lat_deg() + at * dy, wrap_180_deg(from.lon_deg() + at * dx));
        point.is_ok_and(|point| zone.shape.contains(point) != zone.inclusion)
    };
    let parts = meets.windows(2).filter(|pair| pair[1] - pair[0] > LEAST_PART);
    parts.map(|pair| f64::midpoint(pair[0], pair[1])).any(|middle| !is_along(middle) && is_wrong(middle))
}

/// Distance from the origin to a segment.
fn distance_to_segment(a: Flat, b: Flat) -> f64 {
    let (dx, dy) = (b.0 - a.0, b.1 - a.1);
    let length2 = dx * dx + dy * dy;
    let part = if length2 > 0.0 { (-(a.0 * dx + a.1 * dy) / length2).clamp(0.0, 1.0) } else { 0.0 };
    (a.0 + part * dx).hypot(a.1 + part * dy)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(north: f64, east: f64) -> GeoPoint {
        GeoPoint::new(40.0 + 1e-3 * north, wrap_180_deg(180.0 + 1e-3 * east)).unwrap()
    }

    /// Whether a piece of 10 thousandths of a degree northward over the date line's end crosses a zone.
    fn is_crossed(inclusion: bool, corners: &[(f64, f64)]) -> bool {
        let vertices = corners.iter().map(|(north, east)| at(*north, *east)).collect();
        let zone = FenceZone { inclusion, shape: FenceShape::Polygon { vertices } };
        Border::of(&zone).is_crossed(at(0.0, 0.0), at(10.0, 0.0))
    }

    #[test]
    fn a_piece_crosses_what_it_enters_by_edges_or_by_corners() {
        let diamond = [(3.0, 0.0), (5.0, 2.0), (7.0, 0.0), (5.0, -2.0)];
        assert!(is_crossed(false, &diamond));
        assert!(is_crossed(false, &diamond.map(|(north, east)| (north, east + 0.5))));
        let entered_by_a_corner = [(3.0, 0.0), (7.0, 2.0), (7.0, -2.0)];
        assert!(is_crossed(false, &entered_by_a_corner));
        let bay = [
            (-1.0, -3.0),
            (2.0, -3.0),
            (2.0, 0.0),
            (4.0, 1.0),
            (6.0, 0.0),
            (6.0, -3.0),
            (11.0, -3.0),
            (11.0, 3.0),
            (-1.0, 3.0),
        ];
        assert!(is_crossed(true, &bay), "out by one corner, in by the other");
    }

    #[test]
    fn what_is_only_touched_is_not_crossed() {
        assert!(!is_crossed(false, &[(5.0, 0.0), (7.0, 2.0), (3.0, 2.0)]), "a tip");
        assert!(!is_crossed(false, &[(3.0, 0.0), (7.0, 0.0), (5.0, 2.0)]), "along an edge");
        assert!(!is_crossed(true, &[(-2.0, 0.0), (12.0, 0.0), (5.0, 9.0)]), "along the border inside");
        let neck = [(-1.0, -3.0), (4.0, 0.0), (11.0, -3.0), (11.0, 3.0), (6.0, 0.0), (-1.0, 3.0)];
        assert!(!is_crossed(true, &neck), "past one corner on either side");
        assert!(!is_crossed(false, &[(10.0, 0.0), (12.0, 2.0), (12.0, -2.0)]), "its end at a corner");
        assert!(
            !is_crossed(false, &[(3.0, 1.0), (7.0, 1.0), (5.0, 2.0)])
                && !is_crossed(false, &[(11.0, 0.0), (13.0, 1.0), (13.0, -1.0)])
        );
    }

    #[test]
    fn pieces_far_from_a_zone_are_known_by_its_box() {
        let circle =
            FenceZone { inclusion: false, shape: FenceShape::Circle { center: at(5.0, 0.0), radius_m: 200.0 } };
        let border = Border::of(&circle);
        assert!(border.is_broken(at(5.0, -5.0), at(5.0, 5.0)) && !border.is_broken(at(8.0, -5.0), at(8.0, 5.0)));
        assert!(!border.may_touch(at(5.0, 100.0), at(5.0, 101.0)));
        // As wide as the globe around a pole.
        let pole = GeoPoint::new(89.9, 0.0).unwrap();
        let polar = FenceZone { inclusion: false, shape: FenceShape::Circle { center: pole, radius_m: 20_000.0 } };
        let beyond = |lon_deg: f64| GeoPoint::new(89.95, lon_deg).unwrap();
        assert!(Border::of(&polar).is_broken(beyond(179.0), beyond(-179.0)));
    }
}
