//! The lines over an area and the passes along a corridor, with the stretches that are photographed.

use std::f64::consts::TAU;

use super::region::{Region, merged, range};
use crate::geodesy::{GeoPoint, wrap_360_deg};
use crate::guidance::NorthEast;

/// A stretch that is photographed without a stop.
#[derive(Debug, Clone, PartialEq)]
pub struct SurveyLine {
    /// From the first picture to the last, with the corners of a corridor between.
    pub points: Vec<GeoPoint>,
    /// Index in `items` of the waypoint where pictures begin; the camera is switched on after it.
    pub entry: usize,
    /// Index in `items` of the waypoint where they end.
    pub exit: usize,
}

/// A piece of a pass that is flown without a turn that would bank the camera away.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Leg {
    /// Two places or more.
    pub(super) points: Vec<NorthEast>,
    /// Where pictures are taken: from and to, m along it, in order.
    pub(super) shots: Vec<(f64, f64)>,
}

impl Leg {
    /// The whole way, photographed from end to end.
    pub(super) fn whole(points: Vec<NorthEast>) -> Self {
        let length_m = points.windows(2).map(|pair| (pair[1] - pair[0]).length()).sum();
        Self { points, shots: vec![(0.0, length_m)] }
    }

    pub(super) fn start(&self) -> NorthEast {
        self.points[0]
    }

    pub(super) fn end(&self) -> NorthEast {
        self.points[self.points.len() - 1]
    }

    pub(super) fn course_rad(&self) -> f64 {
        (self.points[1] - self.points[0]).bearing_rad()
    }

    pub(super) fn course_deg(&self) -> f64 {
        wrap_360_deg(self.course_rad().to_degrees())
    }

    pub(super) fn last_course_rad(&self) -> f64 {
        (self.end() - self.points[self.points.len() - 2]).bearing_rad()
    }

    pub(super) fn reversed(mut self) -> Self {
        let length_m: f64 = self.points.windows(2).map(|pair| (pair[1] - pair[0]).length()).sum();
        self.points.reverse();
        self.shots = self.shots.iter().rev().map(|(from, to)| (length_m - to, length_m - from)).collect();
        self
    }

    /// A place of it.
    pub(super) fn at(&self, along_m: f64) -> NorthEast {
        let mut left_m = along_m;
        let last = self.points.len() - 2;
        for (index, pair) in self.points.windows(2).enumerate() {
            let side = pair[1] - pair[0];
            if left_m <= side.length() || index == last {
                return pair[0] + side.unit_or(side) * left_m;
            }
            left_m -= side.length();
        }
        self.end()
    }
}

/// One flight over the region, of one leg or more.
pub(super) type Pass = Vec<Leg>;

/// What lines are laid out with.
pub(super) struct Layout<'a> {
    pub(super) region: &'a Region,
    pub(super) spacing_m: f64,
    /// Width that a line's pictures show without a gap.
    pub(super) strip_m: f64,
    /// How far beyond the edge pictures reach: along the lines, and across.
    pub(super) margins_m: (f64, f64),
    /// Gaps between stretches that are photographed rather than left out.
    pub(super) join_m: f64,
    /// Course change that is flown with the camera on.
    pub(super) gentle_rad: f64,
}

impl Layout<'_> {
    /// How many lines a width takes and how far the first lies from its middle; their number where they are too many.
    pub(super) fn across(&self, width_m: f64, most: usize) -> Result<(usize, f64), usize> {
        let count = (width_m / self.spacing_m - 1e-9).ceil().max(1.0) as usize;
        let first_m = -0.5 * (count as f64 - 1.0) * self.spacing_m;
        if count > most { Err(count) } else { Ok((count, first_m)) }
    }

    /// Parallel lines over an area, those on the left of the course first.
    pub(super) fn over_area(&self, course_rad: f64, most: usize) -> Result<Vec<Pass>, usize> {
        let ahead = NorthEast::from_bearing(course_rad);
        let right = NorthEast::from_bearing(course_rad + 0.25 * TAU);
        let (along_m, across_m) = self.margins_m;
        let (low, high) = range(self.region.points.iter().map(|at| at.dot(right)));
        let (count, first_m) = self.across(high - low + 2.0 * across_m, most)?;
        let middle_m = 0.5 * (low + high);
        let passes = (0..count).filter_map(|index| {
            let line_m = middle_m + first_m + index as f64 * self.spacing_m;
            let half_m = 0.5 * self.spacing_m + across_m;
            let inside = self.within(ahead, right, line_m - half_m, line_m + half_m);
            let wide = inside.into_iter().map(|(from, to)| (from - along_m, to + along_m)).collect();
            let shots = merged(wide, self.join_m);
            let (from, to) = (shots.first()?.0, shots.last()?.1);
            let points = [from, to].map(|at| ahead * at + right * line_m).to_vec();
            Some(vec![Leg { points, shots: shots.iter().map(|(begin, end)| (begin - from, end - from)).collect() }])
        });
        Ok(passes.collect())
    }

    /// Where, along the lines, the area has a part in the strip between two distances to their right.
    ///
    /// Whatever of it lies in the strip ends at its sides, or at the border of the strip inside it; so these reach as
    /// far.
    pub(super) fn within(&self, ahead: NorthEast, right: NorthEast, low_m: f64, high_m: f64) -> Vec<(f64, f64)> {
        let mut found = Vec::new();
        let mut crossings = [Vec::new(), Vec::new()];
        for (from, to) in self.region.sides() {
            let (one, other) = ((from.dot(ahead), from.dot(right)), (to.dot(ahead), to.dot(right)));
            let at = |across: f64| one.0 + (other.0 - one.0) * ((across - one.1) / (other.1 - one.1));
            for (border, crossed) in [low_m, high_m].into_iter().zip(&mut crossings) {
                if (one.1 > border) != (other.1 > border) {
                    crossed.push(at(border));
                }
            }
            let (least, most) = (one.1.min(other.1).max(low_m), one.1.max(other.1).min(high_m));
            if least <= most {
                let ends = if (other.1 - one.1).abs() < 1e-9 { [one.0, other.0] } else { [at(least), at(most)] };
                found.push((ends[0].min(ends[1]), ends[0].max(ends[1])));
            }
        }
        for mut crossed in crossings {
            crossed.sort_by(f64::total_cmp);
            found.extend(crossed.chunks_exact(2).map(|pair| (pair[0], pair[1])));
        }
        merged(found, 1e-6)
    }

    /// Passes along a corridor's line, those on its left first.
    pub(super) fn along_line(&self, width_m: f64, most: usize) -> Result<Vec<Pass>, usize> {
        let (along_m, across_m) = self.margins_m;
        // One pass shows a strip: a narrower corridor needs no more.
        let width_m = if width_m <= self.strip_m { 0.0 } else { width_m + 2.0 * across_m };
        let (count, first_m) = self.across(width_m, most)?;
        let stretches = self.stretches();
        if count.saturating_mul(stretches.len()) > most {
            return Err(count.saturating_mul(stretches.len()));
        }
        let half_m = 0.5 * width_m.max(self.spacing_m);
        let pass = |index: usize| {
            let aside_m = first_m + index as f64 * self.spacing_m;
            let leg = |(number, stretch): (usize, &Vec<NorthEast>)| {
                let mut points = beside(stretch, aside_m);
                // Beyond a corner that is flown straight over, as far as the corner of the strip lies.
                let beyond = |other: Option<&Vec<NorthEast>>| {
                    other
                        .map_or(along_m, |other| along_m + half_m * (0.5 * turn_between(stretch, other)).tan().min(2.0))
                };
                let before = number.checked_sub(1).and_then(|before| stretches.get(before));
                lengthen(&mut points, beyond(before), beyond(stretches.get(number + 1)));
                Leg::whole(points)
            };
            stretches.iter().enumerate().map(leg).collect()
        };
        Ok((0..count).map(pass).collect())
    }

    /// The line cut at the corners that cannot be flown with the camera on.
    pub(super) fn stretches(&self) -> Vec<Vec<NorthEast>> {
        let mut stretches = vec![vec![self.region.points[0]]];
        for (index, point) in self.region.points.iter().enumerate().skip(1) {
            if let Some(stretch) = stretches.last_mut() {
                stretch.push(*point);
            }
            let Some(next) = self.region.points.get(index + 1) else { break };
            let before = *point - self.region.points[index - 1];
            let onward = *next - *point;
            if crate::guidance::wrap_pi(onward.bearing_rad() - before.bearing_rad()).abs() > self.gentle_rad {
                stretches.push(vec![*point]);
            }
        }
        stretches
    }
}

/// Angle between the end of one stretch and the beginning of another that follows or goes before it, radians, 0 to π.
pub(super) fn turn_between(one: &[NorthEast], other: &[NorthEast]) -> f64 {
    let (first, then) = if one.last() == other.first() { (one, other) } else { (other, one) };
    let out = (first[first.len() - 1] - first[first.len() - 2]).bearing_rad();
    crate::guidance::wrap_pi((then[1] - then[0]).bearing_rad() - out).abs()
}

/// A line beside another, m to its right; its corners lie where the sides beside meet.
pub(super) fn beside(line: &[NorthEast], aside_m: f64) -> Vec<NorthEast> {
    let right = |index: usize| {
        let side = line[index + 1] - line[index];
        NorthEast::from_bearing(side.bearing_rad() + 0.25 * TAU)
    };
    let last = line.len() - 1;
    let place = |index: usize| {
        let (before, after) = (right(index.saturating_sub(1)), right(index.min(last - 1)));
        // Both are a right angle from their side: their sum leads to where the two lines meet. Gentle corners alone are
        // here.
        let both = before + after;
        line[index] + both * (2.0 * aside_m / both.dot(both).max(0.5))
    };
    (0..=last).map(place).collect()
}

/// Moves the ends of a line outward.
pub(super) fn lengthen(points: &mut [NorthEast], before_m: f64, after_m: f64) {
    let last = points.len() - 1;
    let first_side = points[1] - points[0];
    let last_side = points[last] - points[last - 1];
    points[0] = points[0] - first_side.unit_or(first_side) * before_m;
    points[last] = points[last] + last_side.unit_or(last_side) * after_m;
}
