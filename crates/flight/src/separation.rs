//! Conflicts between planned flights: tracks as places with times, compared piece by piece.

use crate::geodesy::{GeoPoint, wrap_180_deg};
use crate::rehearsal::{IsWanted, Sample};

/// Metres of a degree of latitude, for small differences (mean radius of the earth, IUGG 1980).
const M_PER_DEG: f64 = 111_195.0;
/// By how much that may be wrong, m.
const ROUNDING_M: f64 = 1.0;

/// One place of a track.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Place {
    /// On a clock that all tracks have in common, s.
    pub time_s: f64,
    /// Where.
    pub point: GeoPoint,
    /// Height above mean sea level, m.
    pub alt_amsl_m: f64,
}

/// How far apart flights have to be. Nearer than both distances, within the time, is too near.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Limits {
    /// Distance over ground, m, above 0 to 10,000.
    pub horizontal_m: f64,
    /// Difference in height, m, above 0 to 10,000.
    pub vertical_m: f64,
    /// How much earlier or later one may be than its track says, against the other, s, 0 to 3,600.
    pub window_s: f64,
}

impl Default for Limits {
    /// 100 m, 30 m, 10 s.
    fn default() -> Self {
        Self { horizontal_m: 100.0, vertical_m: 30.0, window_s: 10.0 }
    }
}

impl Limits {
    /// The first field out of range, with its value and range; `None` when all are in range.
    pub fn fault(&self) -> Option<(&'static str, f64, f64, f64)> {
        let fields = [
            ("horizontal_m", self.horizontal_m, 1.0, 10_000.0),
            ("vertical_m", self.vertical_m, 1.0, 10_000.0),
            ("window_s", self.window_s, 0.0, 3600.0),
        ];
        fields.into_iter().find(|(_, value, least, most)| !(*least..=*most).contains(value))
    }
}

/// Two flights that come too near to each other.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Conflict {
    /// Indices of the two tracks, the lower first.
    pub tracks: [usize; 2],
    /// From when to when the first is too near to the other, s.
    pub begins_s: f64,
    /// The end of that.
    pub ends_s: f64,
    /// Where each is where they come nearest over ground.
    pub nearest: [Place; 2],
    /// Distance over ground there, m.
    pub horizontal_m: f64,
    /// Difference in height there, m.
    pub vertical_m: f64,
}

/// The places of a rehearsed flight that starts at `starts_s`, from a home so high.
pub fn track_of(samples: &[Sample], starts_s: f64, home_amsl_m: f64) -> Vec<Place> {
    let place = |sample: &Sample| Place {
        time_s: starts_s + sample.time_s,
        point: sample.point,
        alt_amsl_m: home_amsl_m + sample.height_m,
    };
    samples.iter().map(place).collect()
}

/// Where any two of these tracks, each in the order of its times, come too near to each other, earliest first. Between
/// two of its places a plane flies straight at one speed. A pair that separates and comes near again is reported each
/// time. Incomplete once the outcome is not wanted any more.
pub fn conflicts(tracks: &[Vec<Place>], limits: &Limits, is_wanted: IsWanted<'_>) -> Vec<Conflict> {
    let mut found = Vec::new();
    for (first, one) in tracks.iter().enumerate() {
        for (second, other) in tracks.iter().enumerate().skip(first + 1) {
            found.extend(of_pair([first, second], one, other, limits, is_wanted));
        }
    }
    found.sort_by(|one, other| one.begins_s.total_cmp(&other.begins_s));
    found
}

fn of_pair(
    tracks: [usize; 2],
    one: &[Place],
    other: &[Place],
    limits: &Limits,
    is_wanted: IsWanted<'_>,
) -> Vec<Conflict> {
    let mut found = Vec::new();
    let mut open: Option<Conflict> = None;
    let mut from = 0;
    for leg in one.windows(2).take_while(|_| is_wanted()) {
        // Times only go on: what the other left behind before this leg is behind for all that follow.
        while other.get(from + 1).is_some_and(|end| end.time_s < leg[0].time_s - limits.window_s) {
            from += 1;
        }
        let mut here: Option<Conflict> = None;
        for met in other[from.min(other.len())..].windows(2) {
            if met[0].time_s > leg[1].time_s + limits.window_s {
                break;
            }
            if let Some(conflict) = of_legs(tracks, [leg[0], leg[1]], [met[0], met[1]], limits) {
                here = Some(here.map_or(conflict, |known| joined(known, conflict)));
            }
        }
        match (open, here) {
            (Some(known), Some(conflict)) => open = Some(joined(known, conflict)),
            (Some(known), None) => {
                found.push(known);
                open = None;
            }
            (None, _) => open = here,
        }
    }
    found.extend(open);
    found
}

fn joined(one: Conflict, other: Conflict) -> Conflict {
    let nearer = if other.horizontal_m < one.horizontal_m { other } else { one };
    Conflict { begins_s: one.begins_s.min(other.begins_s), ends_s: one.ends_s.max(other.ends_s), ..nearer }
}

/// How far along the two legs, 0 to 1 each.
type Along = [f64; 2];

/// Where two legs come too near. Which pairs of moments are within the time and the height is a polygon in the square
/// of how far each is along its leg; what they are apart over ground is an affine image of it, so the nearest lies on
/// its edge, or the paths cross inside.
fn of_legs(tracks: [usize; 2], one: [Place; 2], other: [Place; 2], limits: &Limits) -> Option<Conflict> {
    let [[a, b], [c, d]] = [one, other].map(|leg| leg.map(|place| place.point.lat_deg()));
    if (a.min(b) - c.max(d)).max(c.min(d) - a.max(b)) * M_PER_DEG > limits.horizontal_m + ROUNDING_M {
        return None;
    }
    let [start, end] = one.map(|place| offset_m(one[0].point, place.point));
    let [met_start, met_end] = other.map(|place| offset_m(one[0].point, place.point));
    let along = [start, end, met_start, met_end];
    for axis in 0..2 {
        let [a, b, c, d] = along.map(|offset| offset[axis]);
        if a.min(b) - c.max(d) > limits.horizontal_m || c.min(d) - a.max(b) > limits.horizontal_m {
            return None;
        }
    }
    let difference = |get: fn(&Place) -> f64| {
        let [one, other] = [one, other].map(|leg| [get(&leg[0]), get(&leg[1])]);
        // Constant, per step along the first leg, per step along the other.
        [one[0] - other[0], one[1] - one[0], other[0] - other[1]]
    };
    let (time, height) = (difference(|place| place.time_s), difference(|place| place.alt_amsl_m));
    let allowed = |mut moments: Vec<Along>| {
        for (line, most) in [(time, limits.window_s), (height, limits.vertical_m)] {
            moments = clipped(&moments, |[s, u]| most - (line[0] + line[1] * s + line[2] * u));
            moments = clipped(&moments, |[s, u]| most + (line[0] + line[1] * s + line[2] * u));
        }
        moments
    };
    let moments = allowed(vec![[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]]);
    let apart = |[s, u]: Along| {
        let axis = |n: usize| start[n] + (end[n] - start[n]) * s - met_start[n] - (met_end[n] - met_start[n]) * u;
        [axis(0), axis(1)]
    };
    let nearest = nearest_of(&moments, apart)?;
    let [x, y] = apart(nearest);
    let horizontal_m = x.hypot(y);
    if horizontal_m >= limits.horizontal_m {
        return None;
    }
    let places = [at(one, nearest[0]), at(other, nearest[1])];
    // Where along the other leg it is nearest to each place of the first.
    let [zero, met] = [[0.0, 0.0], [0.0, 1.0]].map(apart);
    let step = [met[0] - zero[0], met[1] - zero[1]];
    let length = step[0] * step[0] + step[1] * step[1];
    let beside = |s: f64| {
        let [x, y] = apart([s, 0.0]);
        [s, -(x * step[0] + y * step[1]) / length]
    };
    let spine = if length > 0.0 {
        let whole = clipped(&[beside(0.0), beside(1.0)], |[_, u]| u);
        allowed(clipped(&whole, |[_, u]| 1.0 - u))
    } else {
        Vec::new()
    };
    let times = near_times([&moments, &spine], apart, limits.horizontal_m).map(|s| at(one, s).time_s);
    Some(Conflict {
        tracks,
        begins_s: times[0].min(places[0].time_s),
        ends_s: times[1].max(places[0].time_s),
        nearest: places,
        horizontal_m,
        vertical_m: (places[0].alt_amsl_m - places[1].alt_amsl_m).abs(),
    })
}

/// East and north of an origin, on a plane: good for the kilometres of a leg.
fn offset_m(origin: GeoPoint, point: GeoPoint) -> [f64; 2] {
    let latitude = 0.5 * (origin.lat_deg() + point.lat_deg());
    let east_deg = wrap_180_deg(point.lon_deg() - origin.lon_deg());
    [east_deg * latitude.to_radians().cos() * M_PER_DEG, (point.lat_deg() - origin.lat_deg()) * M_PER_DEG]
}

fn at(leg: [Place; 2], along: f64) -> Place {
    let between = |a: f64, b: f64| a + (b - a) * along;
    let [start, end] = leg;
    let lon_deg = start.point.lon_deg() + wrap_180_deg(end.point.lon_deg() - start.point.lon_deg()) * along;
    let lat_deg = between(start.point.lat_deg(), end.point.lat_deg());
    Place {
        time_s: between(start.time_s, end.time_s),
        point: GeoPoint::new(lat_deg, wrap_180_deg(lon_deg)).unwrap_or(start.point),
        alt_amsl_m: between(start.alt_amsl_m, end.alt_amsl_m),
    }
}

/// The part of a convex polygon where `keeps` is not negative, which is affine (Sutherland and Hodgman, 1974).
fn clipped(polygon: &[Along], keeps: impl Fn(Along) -> f64) -> Vec<Along> {
    let mut kept = Vec::with_capacity(polygon.len() + 1);
    for (index, corner) in polygon.iter().enumerate() {
        let next = polygon[(index + 1) % polygon.len()];
        let (here, there) = (keeps(*corner), keeps(next));
        if here >= 0.0 {
            kept.push(*corner);
        }
        if (here >= 0.0) != (there >= 0.0) {
            let share = here / (here - there);
            kept.push([corner[0] + (next[0] - corner[0]) * share, corner[1] + (next[1] - corner[1]) * share]);
        }
    }
    kept
}

/// Edges of a polygon; of one with one corner that corner.
fn edges(polygon: &[Along]) -> impl Iterator<Item = [Along; 2]> + '_ {
    (0..polygon.len()).map(|index| [polygon[index], polygon[(index + 1) % polygon.len()]])
}

/// The moments at which the two are nearest; `None` for no moments.
fn nearest_of(moments: &[Along], apart: impl Fn(Along) -> [f64; 2]) -> Option<Along> {
    let on_edge = |[from, to]: [Along; 2]| {
        let ([ax, ay], [bx, by]) = (apart(from), apart(to));
        let (dx, dy) = (bx - ax, by - ay);
        let length = dx * dx + dy * dy;
        let share = if length > 0.0 { (-(ax * dx + ay * dy) / length).clamp(0.0, 1.0) } else { 0.0 };
        [from[0] + (to[0] - from[0]) * share, from[1] + (to[1] - from[1]) * share]
    };
    let size = |moment: &Along| apart(*moment).map(|axis| axis * axis).iter().sum::<f64>();
    let nearest = edges(moments).map(on_edge).min_by(|one, other| size(one).total_cmp(&size(other)))?;
    Some(crossing(moments, apart).unwrap_or(nearest))
}

/// Where the two paths cross, if that is among the moments.
fn crossing(moments: &[Along], apart: impl Fn(Along) -> [f64; 2]) -> Option<Along> {
    let [zero, one, other] = [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]].map(apart);
    let ([ax, ay], [bx, by]) = ([one[0] - zero[0], one[1] - zero[1]], [other[0] - zero[0], other[1] - zero[1]]);
    let area = ax * by - ay * bx;
    if area.abs() < 1e-9 {
        return None;
    }
    let cross = [(bx * zero[1] - by * zero[0]) / area, (ay * zero[0] - ax * zero[1]) / area];
    // A line or a point has no interior: the edges suffice.
    let twice_area: f64 = edges(moments).map(|[from, to]| from[0] * to[1] - to[0] * from[1]).sum();
    if twice_area.abs() < 1e-12 {
        return None;
    }
    // Left of every edge: the corners go round one way, whichever it is.
    let side =
        |[from, to]: [Along; 2]| (to[0] - from[0]) * (cross[1] - from[1]) - (to[1] - from[1]) * (cross[0] - from[0]);
    let sides: Vec<_> = edges(moments).map(side).collect();
    let is_inside = sides.iter().all(|side| *side >= -1e-12) || sides.iter().all(|side| *side <= 1e-12);
    is_inside.then_some(cross)
}

/// From where to where along the first leg the two are nearer than a distance. Either end of that stretch is on an edge
/// of the moments, or where the other is beside the first.
fn near_times(moments: [&[Along]; 2], apart: impl Fn(Along) -> [f64; 2], distance_m: f64) -> [f64; 2] {
    let mut range = [f64::INFINITY, f64::NEG_INFINITY];
    for [from, to] in moments.into_iter().flat_map(edges) {
        let ([ax, ay], [bx, by]) = (apart(from), apart(to));
        let (dx, dy) = (bx - ax, by - ay);
        // |a + t·d| = distance
        let (a, b, c) = (dx * dx + dy * dy, ax * dx + ay * dy, ax * ax + ay * ay - distance_m * distance_m);
        let shares = if a == 0.0 {
            if c < 0.0 { Some([0.0, 1.0]) } else { None }
        } else {
            let root = b * b - a * c;
            (root >= 0.0).then(|| [(-b - root.sqrt()) / a, (-b + root.sqrt()) / a])
        };
        let Some([enters, leaves]) = shares.filter(|[enters, leaves]| *leaves >= 0.0 && *enters <= 1.0) else {
            continue;
        };
        for share in [enters.max(0.0), leaves.min(1.0)] {
            let s = from[0] + (to[0] - from[0]) * share;
            range = [range[0].min(s), range[1].max(s)];
        }
    }
    range
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn conflicts(tracks: &[Vec<Place>], limits: &Limits) -> Vec<Conflict> {
        super::conflicts(tracks, limits, &|| true)
    }
    use crate::geodesy::{direct, distance_m};

    const HOME: (f64, f64) = (40.3332, -3.7978);

    fn place(time_s: f64, east_m: f64, north_m: f64, alt_amsl_m: f64) -> Place {
        let home = GeoPoint::new(HOME.0, HOME.1).unwrap();
        let point = direct(direct(home, 0.0, north_m), 90.0, east_m);
        Place { time_s, point, alt_amsl_m }
    }

    fn limits(horizontal_m: f64, vertical_m: f64, window_s: f64) -> Limits {
        Limits { horizontal_m, vertical_m, window_s }
    }

    /// A flight eastward through the origin, which it passes at 100 s, at 20 m/s.
    fn eastward(alt_m: f64) -> Vec<Place> {
        (0..=20).map(|n| place(f64::from(n) * 10.0, f64::from(n - 10) * 200.0, 0.0, alt_m)).collect()
    }

    /// A flight northward through the origin, which it passes `late_s` after that.
    fn northward(late_s: f64, alt_m: f64) -> Vec<Place> {
        (0..=20).map(|n| place(late_s + f64::from(n) * 10.0, 0.0, f64::from(n - 10) * 200.0, alt_m)).collect()
    }

    #[test]
    fn two_that_cross_at_the_same_time_are_told_with_place_and_time() {
        let found = conflicts(&[eastward(700.0), northward(0.0, 710.0)], &limits(100.0, 30.0, 0.0));
        let [conflict] = found.as_slice() else { panic!("{found:?}") };
        assert_eq!(conflict.tracks, [0, 1]);
        assert!((conflict.nearest[0].time_s - 100.0).abs() < 0.1 && conflict.horizontal_m < 1.0, "{conflict:?}");
        assert!((conflict.vertical_m - 10.0).abs() < 1e-6);
        // At 45 degrees to each other: 100 m apart 3.54 s before and after.
        assert!((conflict.begins_s - 96.46).abs() < 0.1 && (conflict.ends_s - 103.54).abs() < 0.1, "{conflict:?}");
        let home = GeoPoint::new(HOME.0, HOME.1).unwrap();
        assert!(conflict.nearest.iter().all(|place| distance_m(place.point, home) < 1.0));
    }

    #[test]
    fn height_time_and_distance_each_keep_them_apart() {
        let east = eastward(700.0);
        let near = |other: Vec<Place>, limits| !conflicts(&[east.clone(), other], &limits).is_empty();
        assert!(!near(northward(0.0, 731.0), limits(100.0, 30.0, 0.0)), "31 m above");
        assert!(near(northward(0.0, 729.0), limits(100.0, 30.0, 0.0)));
        for late_s in [10.0, 20.0, 25.0, 30.0] {
            assert!(!near(northward(late_s, 700.0), limits(100.0, 30.0, 0.0)), "{late_s} s later it has passed");
        }
        assert!(near(northward(20.0, 700.0), limits(100.0, 30.0, 20.0)), "unless one may be 20 s late");
        assert!(!near(northward(1000.0, 700.0), limits(100.0, 30.0, 20.0)));
        let beside =
            |off_m: f64| (0..=20).map(move |n| place(f64::from(n) * 10.0, f64::from(n - 10) * 200.0, off_m, 700.0));
        assert!(!near(beside(101.0).collect(), limits(100.0, 30.0, 0.0)));
        assert!(near(beside(99.0).collect(), limits(100.0, 30.0, 0.0)));
    }

    #[test]
    fn each_meeting_is_told_and_one_climbing_through_is_too() {
        // There and back along the same line.
        let back: Vec<_> =
            (0..=20).map(|n| place(200.0 + f64::from(n) * 10.0, f64::from(10 - n) * 200.0, 0.0, 700.0)).collect();
        let there_and_back: Vec<_> = eastward(700.0).into_iter().chain(back.into_iter().skip(1)).collect();
        let still = vec![place(0.0, 0.0, 0.0, 700.0), place(400.0, 0.0, 0.0, 700.0)];
        let found = conflicts(&[there_and_back, still], &limits(50.0, 30.0, 0.0));
        assert_eq!(found.iter().map(|one| one.nearest[0].time_s.round()).collect::<Vec<_>>(), [100.0, 300.0]);
        // It climbs from far below to far above within one leg, and meets on the way.
        let climbing = vec![place(50.0, 0.0, 0.0, 400.0), place(150.0, 0.0, 0.0, 1000.0)];
        let found = conflicts(&[eastward(700.0), climbing], &limits(50.0, 30.0, 0.0));
        assert_eq!(found.len(), 1, "{found:?}");
        assert!((found[0].nearest[1].alt_amsl_m - 700.0).abs() <= 30.0);
    }

    #[test]
    fn what_has_no_length_is_near_nobody() {
        assert_eq!(conflicts(&[], &Limits::default()), []);
        assert_eq!(conflicts(&[vec![], eastward(700.0), vec![place(100.0, 0.0, 0.0, 700.0)]], &Limits::default()), []);
        assert_eq!(limits(100.0, 30.0, -1.0).fault(), Some(("window_s", -1.0, 0.0, 3600.0)));
        assert!(limits(f64::NAN, 30.0, 1.0).fault().is_some() && Limits::default().fault().is_none());
    }

    proptest! {
        // What many samples in time find, this finds too, and as near.
        #[test]
        fn as_near_as_many_samples_say(
            one in prop::collection::vec((-300.0..300.0, -300.0..300.0, 600.0..700.0), 2..6),
            other in prop::collection::vec((-300.0..300.0, -300.0..300.0, 600.0..700.0), 2..6),
        ) {
            let track = |legs: &[(f64, f64, f64)]| -> Vec<Place> {
                legs.iter().enumerate().map(|(n, (x, y, z))| place(n as f64 * 10.0, *x, *y, *z)).collect()
            };
            let (one, other) = (track(&one), track(&other));
            let set = limits(100.0, 30.0, 0.0);
            let found = conflicts(&[one.clone(), other.clone()], &set);
            let moment = |track: &[Place], t: f64| {
                let leg = ((t / 10.0) as usize).min(track.len() - 2);
                at([track[leg], track[leg + 1]], t / 10.0 - leg as f64)
            };
            let end_s = (one.len().min(other.len()) - 1) as f64 * 10.0;
            let mut nearest_m = f64::INFINITY;
            for step in 0..=(end_s * 20.0) as usize {
                let t = step as f64 / 20.0;
                let (a, b) = (moment(&one, t), moment(&other, t));
                let apart_m = distance_m(a.point, b.point);
                if apart_m < 99.0 && (a.alt_amsl_m - b.alt_amsl_m).abs() < 29.5 {
                    nearest_m = nearest_m.min(apart_m);
                    let is_told = found.iter().any(|one| (one.begins_s - 0.3..=one.ends_s + 0.3).contains(&t));
                    prop_assert!(is_told, "at {t} s: {apart_m} m, {found:?}");
                }
            }
            let told_m = found.iter().map(|one| one.horizontal_m).fold(f64::INFINITY, f64::min);
            prop_assert!(told_m <= nearest_m + 1.0, "{told_m} m, but {nearest_m} m");
            for one in &found {
                prop_assert!(one.horizontal_m < 100.0 && one.vertical_m <= 30.0 + 1e-6);
                prop_assert!((one.nearest[0].time_s - one.nearest[1].time_s).abs() < 1e-6);
            }
        }
    }
}
