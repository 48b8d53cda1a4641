//! The area of a survey, in metres around its middle: an area, or a corridor along a line.

use crate::error::{FlightError, Result, SurveyProblem};
use crate::geodesy::{GeoPoint, direct, inverse};
use crate::guidance::NorthEast;

/// Most corners of an area or points of a line.
pub const MAX_CORNERS: usize = 1_000;
/// Smallest area, m²: less is a slip of the finger.
pub const LEAST_AREA_M2: f64 = 100.0;
/// Shortest line of a corridor, m.
pub const LEAST_LINE_M: f64 = 10.0;
/// Farthest corner from the middle, m: beyond, lines of a map are no longer straight.
const FARTHEST_M: f64 = 25_000.0;
/// Corners nearer to each other than this are one, m.
const SAME_M: f64 = 0.01;

/// Shape to survey.
#[derive(Debug, Clone, PartialEq)]
pub enum SurveyShape {
    /// An area, by its corners in order; the last joins the first. It may be concave, and may not cross itself.
    Area(Vec<GeoPoint>),
    /// A strip along a line.
    Corridor {
        /// The points of the line, in order.
        line: Vec<GeoPoint>,
        /// Width of the strip, m, 0 to 5,000; 0: one pass along the line.
        width_m: f64,
    },
}

impl SurveyShape {
    /// Its corners or points.
    pub fn points(&self) -> &[GeoPoint] {
        match self {
            Self::Area(corners) => corners,
            Self::Corridor { line, .. } => line,
        }
    }
}

/// Metres around a place: bearing and distance from it are true, as in the rehearsal.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Plane {
    origin: GeoPoint,
}

impl Plane {
    pub fn at(&self, point: GeoPoint) -> NorthEast {
        let line = inverse(self.origin, point);
        NorthEast::from_bearing(line.bearing_start_deg.to_radians()) * line.distance_m
    }

    pub fn point(&self, at: NorthEast) -> GeoPoint {
        direct(self.origin, at.bearing_rad().to_degrees(), at.length())
    }
}

/// A shape laid out in metres, and known to be sound.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Region {
    pub plane: Plane,
    /// Corners of the area or points of the line.
    pub points: Vec<NorthEast>,
    /// Width of a corridor, m; `None`: an area.
    pub width_m: Option<f64>,
}

impl Region {
    /// Metres around a place.
    pub fn around(origin: GeoPoint) -> Plane {
        Plane { origin }
    }

    /// # Errors
    /// [`FlightError::BadSurvey`] for a shape that cannot be covered, with the corner.
    pub fn new(shape: &SurveyShape) -> Result<Self> {
        let bad = |problem| Err(FlightError::BadSurvey(problem));
        let given = shape.points();
        let is_area = matches!(shape, SurveyShape::Area(_));
        if given.len() > MAX_CORNERS {
            return bad(SurveyProblem::TooManyCorners { count: given.len(), max: MAX_CORNERS });
        }
        let least = if is_area { 3 } else { 2 };
        let Some(first) = given.first() else { return bad(SurveyProblem::TooFewCorners { count: 0, least }) };
        // Around the middle of the box, as seen from the first corner: it may lie across the date line.
        let about = Plane { origin: *first };
        let seen: Vec<NorthEast> = given.iter().map(|point| about.at(*point)).collect();
        let middle = |axis: fn(&NorthEast) -> f64| {
            let (low, high) = range(seen.iter().map(axis));
            0.5 * (low + high)
        };
        let origin = about.point(NorthEast::new(middle(|at| at.north), middle(|at| at.east)));
        let plane = Plane { origin };
        let mut points: Vec<NorthEast> = Vec::with_capacity(given.len());
        for (index, point) in given.iter().enumerate() {
            let at = plane.at(*point);
            if at.length() > FARTHEST_M {
                return bad(SurveyProblem::TooLarge { corner: index + 1, most_m: 2.0 * FARTHEST_M });
            }
            if points.last().is_none_or(|last| (at - *last).length() > SAME_M) {
                points.push(at);
            }
        }
        if is_area && points.len() > 1 && (points[0] - points[points.len() - 1]).length() <= SAME_M {
            points.pop();
        }
        if points.len() < least {
            return bad(SurveyProblem::TooFewCorners { count: points.len(), least });
        }
        let region = match shape {
            SurveyShape::Area(_) => Self { plane, points, width_m: None },
            SurveyShape::Corridor { width_m, .. } => Self { plane, points, width_m: Some(*width_m) },
        };
        if is_area {
            if let Some((one, other)) = region.crossing() {
                return bad(SurveyProblem::CrossesItself { one: one + 1, other: other + 1 });
            }
            let area_m2 = region.area_m2();
            if area_m2 < LEAST_AREA_M2 {
                return bad(SurveyProblem::TooSmall { size: area_m2, least: LEAST_AREA_M2, unit: "m²" });
            }
        } else {
            let length_m: f64 = region.points.windows(2).map(|pair| (pair[1] - pair[0]).length()).sum();
            if length_m < LEAST_LINE_M {
                return bad(SurveyProblem::TooSmall { size: length_m, least: LEAST_LINE_M, unit: "m" });
            }
        }
        Ok(region)
    }

    /// Its sides: of an area all around.
    pub fn sides(&self) -> impl Iterator<Item = (NorthEast, NorthEast)> + '_ {
        let count = self.points.len();
        let sides = if self.width_m.is_some() { count - 1 } else { count };
        (0..sides).map(move |index| (self.points[index], self.points[(index + 1) % count]))
    }

    /// Size of the area; of a corridor its length times its width, m².
    pub fn area_m2(&self) -> f64 {
        match self.width_m {
            Some(width_m) => width_m * self.sides().map(|(from, to)| (to - from).length()).sum::<f64>(),
            // The shoelace formula.
            None => 0.5 * self.sides().map(|(from, to)| from.cross(to)).sum::<f64>().abs(),
        }
    }

    /// Whether a place lies in it; of a corridor, one that is at least twice this wide.
    pub fn contains(&self, at: NorthEast, least_half_m: f64) -> bool {
        match self.width_m {
            Some(width_m) => self.sides().enumerate().any(|(index, (from, to))| {
                let side = to - from;
                let along = (at - from).dot(side) / side.dot(side);
                // It ends square at the ends of its line, and round at its corners.
                let is_beyond = (index == 0 && along < 0.0) || (index + 2 == self.points.len() && along > 1.0);
                let half_m = (0.5 * width_m).max(least_half_m);
                !is_beyond && (from + side * along.clamp(0.0, 1.0) - at).length() <= half_m
            }),
            None => {
                let is_crossed = |(from, to): (NorthEast, NorthEast)| {
                    (from.east > at.east) != (to.east > at.east)
                        && at.north
                            < from.north + (to.north - from.north) * (at.east - from.east) / (to.east - from.east)
                };
                self.sides().filter(|side| is_crossed(*side)).count() % 2 == 1
            }
        }
    }

    /// Two sides that meet where they should not, by the corners that they begin at.
    fn crossing(&self) -> Option<(usize, usize)> {
        let sides: Vec<_> = self.sides().collect();
        let count = sides.len();
        (0..count).find_map(|one| {
            let other = (one + 1..count).find(|other| {
                let follow = *other == one + 1 || (one == 0 && *other == count - 1);
                meet(sides[one], sides[*other], follow)
            })?;
            Some((one, other))
        })
    }
}

/// Whether two sides cross or touch; of two that follow each other, whether one leads back along the other.
fn meet((a, b): (NorthEast, NorthEast), (c, d): (NorthEast, NorthEast), follow: bool) -> bool {
    let side = |from: NorthEast, to: NorthEast, at: NorthEast| (to - from).cross(at - from);
    if follow {
        let (one, other) = (b - a, d - c);
        return one.cross(other).abs() < 1e-9 * one.length() * other.length() && one.dot(other) < 0.0;
    }
    let within = |from: NorthEast, to: NorthEast, at: NorthEast| {
        let line = to - from;
        (0.0..=line.dot(line)).contains(&(at - from).dot(line))
    };
    let (c_side, d_side) = (side(a, b, c), side(a, b, d));
    let (a_side, b_side) = (side(c, d, a), side(c, d, b));
    if c_side * d_side < 0.0 && a_side * b_side < 0.0 {
        return true;
    }
    (c_side == 0.0 && within(a, b, c))
        || (d_side == 0.0 && within(a, b, d))
        || (a_side == 0.0 && within(c, d, a))
        || (b_side == 0.0 && within(c, d, b))
}

/// Least and greatest of some numbers.
pub(super) fn range(values: impl Iterator<Item = f64>) -> (f64, f64) {
    values.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), value| (low.min(value), high.max(value)))
}

/// Stretches brought in order, those that overlap or lie no farther than `gap` apart made one.
pub(super) fn merged(mut stretches: Vec<(f64, f64)>, gap: f64) -> Vec<(f64, f64)> {
    stretches.sort_by(|one, other| one.0.total_cmp(&other.0));
    let mut merged: Vec<(f64, f64)> = Vec::with_capacity(stretches.len());
    for (from, to) in stretches {
        match merged.last_mut() {
            Some(last) if from <= last.1 + gap => last.1 = last.1.max(to),
            _ => merged.push((from, to)),
        }
    }
    merged
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(north: f64, east: f64) -> GeoPoint {
        direct(direct(GeoPoint::new(40.0, -4.0).unwrap(), 0.0, north), 90.0, east)
    }

    fn area(corners: &[(f64, f64)]) -> Result<Region> {
        Region::new(&SurveyShape::Area(corners.iter().map(|(north, east)| at(*north, *east)).collect()))
    }

    #[test]
    fn sound_areas_are_taken_and_the_others_told() {
        let square = area(&[(0.0, 0.0), (0.0, 400.0), (300.0, 400.0), (300.0, 0.0)]).unwrap();
        assert!((square.area_m2() - 120_000.0).abs() < 5.0, "{}", square.area_m2());
        assert!(square.contains(NorthEast::new(0.0, 0.0), 0.0) && !square.contains(NorthEast::new(0.0, 201.0), 0.0));
        // Clockwise or not, with its first corner again at its end.
        assert!(area(&[(0.0, 0.0), (300.0, 0.0), (300.0, 400.0), (0.0, 400.0), (0.0, 0.0)]).is_ok());
        for (corners, says) in [
            (vec![(0.0, 0.0), (0.0, 100.0), (0.0, 100.0)], "2 corners"),
            (
                vec![(0.0, 0.0), (300.0, 400.0), (0.0, 400.0), (300.0, 0.0)],
                "the side from corner 1 crosses the side from corner 3",
            ),
            (vec![(0.0, 0.0), (0.0, 400.0), (0.0, 200.0)], "crosses"),
            (vec![(0.0, 0.0), (0.0, 9.0), (9.0, 9.0), (9.0, 0.0)], "81 m²"),
            (vec![(0.0, 0.0), (0.0, 90_000.0), (90_000.0, 0.0)], "corner 1 lies"),
        ] {
            let error = area(&corners).unwrap_err().to_string();
            assert!(error.contains(says), "{error}");
        }
        let empty = Region::new(&SurveyShape::Area(Vec::new())).unwrap_err().to_string();
        assert!(empty.contains("0 corners"), "{empty}");
        let dot = SurveyShape::Corridor { line: vec![at(0.0, 0.0), at(0.0, 3.0)], width_m: 50.0 };
        assert!(Region::new(&dot).unwrap_err().to_string().contains("3 m"));
    }

    #[test]
    fn an_area_may_lie_across_the_date_line() {
        let corners = [(-10.0, 179.99), (-10.0, -179.99), (-9.99, -179.99), (-9.99, 179.99)];
        let corners = corners.map(|(lat, lon)| GeoPoint::new(lat, lon).unwrap());
        let region = Region::new(&SurveyShape::Area(corners.to_vec())).unwrap();
        assert!((region.area_m2() / 1e6 - 2.424).abs() < 0.02, "{}", region.area_m2());
    }

    #[test]
    fn a_corridor_holds_what_is_near_its_line() {
        let line = vec![at(0.0, 0.0), at(500.0, 0.0), at(500.0, 500.0)];
        let region = Region::new(&SurveyShape::Corridor { line: line.clone(), width_m: 60.0 }).unwrap();
        for (north, east, is_in) in
            [(250.0, 29.0, true), (250.0, 31.0, false), (-20.0, 0.0, false), (520.0, -20.0, true)]
        {
            assert_eq!(region.contains(region.plane.at(at(north, east)), 0.0), is_in, "{north} {east}");
        }
        assert!((region.area_m2() - 60_000.0).abs() < 10.0);
    }
}
