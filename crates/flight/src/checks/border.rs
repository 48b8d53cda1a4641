//! Pieces of a way, drawn or flown, held against the border of a fence's zone.

use crate::geodesy::{GeoPoint, LocalFrame, wrap_180_deg};
use crate::plan::{Fence, FenceShape, FenceZone};

/// Metres of a degree of latitude, on a sphere.
const M_PER_DEG: f64 = 111_195.0;
/// The same, less than anywhere on Earth.
const M_PER_DEG_LEAST: f64 = 110_000.0;
/// Latitude from which on a circle may lie around a pole, degrees.
const POLAR_DEG: f64 = 89.0;
/// Shortest part of a piece that counts: less is rounding where it touches a border.
const LEAST_PART: f64 = 1e-9;
/// Half width from which on a zone is taken to reach all round the globe, degrees of longitude.
const WIDE_DEG: f64 = 90.0;

/// Two coordinates on a plane.
type Flat = (f64, f64);

/// The zones of a fence, with what many pieces are held against.
pub(super) struct Borders<'a> {
    fence: &'a Fence,
    borders: Vec<Border<'a>>,
    /// Whether one of several inclusion zones is enough (`FENCE_OPTIONS` of ArduPilot, bit 1).
    is_union: bool,
}

impl<'a> Borders<'a> {
    /// The borders of a sound fence.
    pub fn of(fence: &'a Fence, is_union: bool) -> Self {
        let inclusions = fence.zones.iter().filter(|zone| zone.inclusion).count();
        let borders = fence.zones.iter().map(Border::of).collect();
        Self { fence, borders, is_union: is_union && inclusions > 1 }
    }

    /// The first zone, by index, that forbids the end of a piece or is left or entered on the way.
    pub fn broken(&self, from: GeoPoint, to: GeoPoint) -> Option<usize> {
        self.alone().find(|(_, border)| border.is_broken(from, to)).map(|(index, _)| index).or_else(|| {
            let zone = self.union()?;
            (self.fence.forbidden_by(to, true) == Some(zone) || self.leaves_union(from, to)).then_some(zone)
        })
    }

    /// The first zone, by index, that a piece between two allowed places leaves or enters.
    pub fn crossed(&self, from: GeoPoint, to: GeoPoint) -> Option<usize> {
        let crossed = self.alone().find(|(_, border)| border.is_crossed(from, to)).map(|(index, _)| index);
        crossed.or_else(|| self.union().filter(|_| self.leaves_union(from, to)))
    }

    /// Zones that count each by itself.
    fn alone(&self) -> impl Iterator<Item = (usize, &Border<'a>)> {
        self.borders.iter().enumerate().filter(|(_, border)| !(self.is_union && border.zone.inclusion))
    }

    /// The inclusion zone that stands for all of them.
    fn union(&self) -> Option<usize> {
        self.borders.iter().position(|border| border.zone.inclusion).filter(|_| self.is_union)
    }

    /// Whether a part of a piece lies in no inclusion zone.
    fn leaves_union(&self, from: GeoPoint, to: GeoPoint) -> bool {
        let piece = Piece::new(from, to);
        let inclusions = || self.borders.iter().filter(|border| border.zone.inclusion);
        let mut meets = Meets::default();
        for border in inclusions() {
            match &border.zone.shape {
                FenceShape::Polygon { vertices } => piece.meet(vertices, &mut meets),
                FenceShape::Circle { radius_m, .. } => {
                    meets.at.extend(circle_meets(border.flat(from), border.flat(to), *radius_m));
                }
            }
        }
        let is_included = |point| inclusions().any(|border| border.zone.shape.contains(point));
        piece.has_part(meets, |point| !is_included(point))
    }
}

/// A zone, with what many pieces are held against.
struct Border<'a> {
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
    fn of(zone: &'a FenceZone) -> Self {
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
    fn is_broken(&self, from: GeoPoint, to: GeoPoint) -> bool {
        let is_inclusion = self.zone.inclusion;
        if !is_inclusion && !self.may_touch(from, to) {
            return false;
        }
        self.zone.shape.contains(to) != is_inclusion || self.is_crossed(from, to)
    }

    /// Whether a piece between two allowed places leaves an inclusion zone or enters an exclusion zone.
    fn is_crossed(&self, from: GeoPoint, to: GeoPoint) -> bool {
        match &self.zone.shape {
            // A circle is convex: a piece between two places inside stays inside.
            FenceShape::Circle { .. } if self.zone.inclusion => false,
            _ if !self.may_touch(from, to) => false,
            FenceShape::Polygon { vertices } => {
                let (piece, mut meets) = (Piece::new(from, to), Meets::default());
                piece.meet(vertices, &mut meets);
                let is_wrong = |point| self.zone.shape.contains(point) != self.zone.inclusion;
                !meets.at.is_empty() && piece.has_part(meets, is_wrong)
            }
            FenceShape::Circle { radius_m, .. } => distance_to_segment(self.flat(from), self.flat(to)) < *radius_m,
        }
    }

    /// A place on the plane that touches the ground at the middle of the zone, m.
    fn flat(&self, point: GeoPoint) -> Flat {
        let [north_m, east_m, _] = self.frame.ned_m(point, 0.0);
        (north_m, east_m)
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

/// A piece of a way, straight between the degrees.
struct Piece {
    from: GeoPoint,
    dx: f64,
    dy: f64,
}

/// Where a piece meets borders, in parts of its length.
#[derive(Default)]
struct Meets {
    at: Vec<f64>,
    /// Edges that it goes along.
    along: Vec<(f64, f64)>,
}

impl Piece {
    fn new(from: GeoPoint, to: GeoPoint) -> Self {
        let (dx, dy) = flat(from, to);
        Self { from, dx, dy }
    }

    /// Adds where it meets the edges of a polygon.
    fn meet(&self, vertices: &[GeoPoint], meets: &mut Meets) {
        let (dx, dy) = (self.dx, self.dy);
        let length2 = dx * dx + dy * dy;
        if length2 == 0.0 {
            return;
        }
        let side = |(x, y): Flat| dx * y - dy * x;
        let part = |(x, y): Flat| (dx * x + dy * y) / length2;
        let mut a = flat(self.from, vertices[vertices.len() - 1]);
        for vertex in vertices {
            let b = flat(self.from, *vertex);
            let (side_a, side_b) = (side(a), side(b));
            if (a.0 - b.0).abs() >= 180.0 || side_a * side_b > 0.0 {
                // An edge that wraps round the globe is far from the piece; one on one side of it does not meet it.
            } else if side_a == side_b {
                meets.at.extend([part(a), part(b)]);
                meets.along.push((part(a).min(part(b)), part(a).max(part(b))));
            } else {
                let along = side_a / (side_a - side_b);
                meets.at.push(part((a.0 + along * (b.0 - a.0), a.1 + along * (b.1 - a.1))));
            }
            a = b;
        }
    }

    /// Whether `is_such` holds between two of the places where it meets borders. Touching a border, or going along
    /// an edge, does not count.
    fn has_part(&self, Meets { mut at, along }: Meets, is_such: impl Fn(GeoPoint) -> bool) -> bool {
        at.retain(|at| (0.0..=1.0).contains(at));
        at.extend([0.0, 1.0]);
        at.sort_by(f64::total_cmp);
        let is_along = |at: f64| along.iter().any(|(low, high)| (*low..=*high).contains(&at));
        let place = |at: f64| {
            GeoPoint::new(self.from.lat_deg() + at * self.dy, wrap_180_deg(self.from.lon_deg() + at * self.dx))
        };
        let parts = at.windows(2).filter(|pair| pair[1] - pair[0] > LEAST_PART);
        parts
            .map(|pair| f64::midpoint(pair[0], pair[1]))
            .any(|middle| !is_along(middle) && place(middle).is_ok_and(&is_such))
    }
}

/// Degrees eastward and northward from one place to another.
fn flat(from: GeoPoint, point: GeoPoint) -> Flat {
    (wrap_180_deg(point.lon_deg() - from.lon_deg()), point.lat_deg() - from.lat_deg())
}

/// Where a piece meets a circle round the origin, in parts of its length.
fn circle_meets(a: Flat, b: Flat, radius: f64) -> impl Iterator<Item = f64> {
    let (dx, dy) = (b.0 - a.0, b.1 - a.1);
    let length2 = dx * dx + dy * dy;
    let middle = -(a.0 * dx + a.1 * dy) / length2;
    let half = (middle * middle - (a.0 * a.0 + a.1 * a.1 - radius * radius) / length2).sqrt();
    // No meets for a piece without length or beside the circle: not finite.
    [middle - half, middle + half].into_iter().filter(|at| at.is_finite())
}

/// Distance from a place to the edge of a polygon, m; infinite for one without corners. With the degrees of the place:
/// the nearer, the more exact.
pub(super) fn distance_to_polygon_m(place: GeoPoint, vertices: &[GeoPoint]) -> f64 {
    let per_east = M_PER_DEG * place.lat_deg().to_radians().cos();
    let at = |(east, north): Flat| (east * per_east, north * M_PER_DEG);
    let edges = vertices.iter().zip(vertices.iter().cycle().skip(1));
    // From one corner to the next, not each from the place: opposite to it that would lead round the Earth.
    let ends = edges.map(|(a, b)| (flat(place, *a), flat(*a, *b)));
    ends.map(|(from, step)| distance_to_segment(at(from), at((from.0 + step.0, from.1 + step.1))))
        .fold(f64::INFINITY, f64::min)
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

    #[test]
    fn one_of_several_inclusion_zones_is_enough_where_they_are_a_union() {
        let square = |north: f64, half: f64| {
            let corners = [(-1.0, -1.0), (-1.0, 1.0), (1.0, 1.0), (1.0, -1.0)];
            let vertices = corners.map(|(y, x)| at(north + half * y, half * x)).to_vec();
            FenceZone { inclusion: true, shape: FenceShape::Polygon { vertices } }
        };
        let circle = |north: f64, radius_m: f64, inclusion| FenceZone {
            inclusion,
            shape: FenceShape::Circle { center: at(north, 0.0), radius_m },
        };
        let crossed = |zones: &[FenceZone], is_union: bool| {
            let fence = Fence { zones: zones.to_vec(), return_point: None };
            Borders::of(&fence, is_union).broken(at(0.0, 0.0), at(10.0, 0.0))
        };
        // Two that overlap, and a gap of a thousandth of a degree between two.
        let overlapping = [square(0.0, 6.0), square(10.0, 6.0)];
        assert_eq!((crossed(&overlapping, false), crossed(&overlapping, true)), (Some(0), None));
        assert_eq!(crossed(&[square(0.0, 4.5), square(10.0, 4.5)], true), Some(0));
        // Side by side they share an edge; a circle of 111 m more than the half joins a square.
        assert_eq!(crossed(&[square(0.0, 5.0), square(10.0, 5.0)], true), None);
        assert_eq!(crossed(&[circle(0.0, 666.0, true), square(10.0, 5.0)], true), None);
        assert_eq!(crossed(&[circle(0.0, 444.0, true), square(10.0, 5.0)], true), Some(0));
        assert_eq!(crossed(&[square(0.0, 6.0), square(10.0, 6.0), circle(5.0, 50.0, false)], true), Some(2));
        assert_eq!(crossed(&[square(0.0, 6.0), square(30.0, 6.0)], true), Some(0), "its end lies in none");
    }
}
