//! The way of a plane from one line to the next: the shortest that turns no tighter than it can, as corners for
//! waypoints.
//!
//! L. E. Dubins, "On curves of minimal length with a constraint on average curvature", Amer. J. Math. 79 (1957): the
//! shortest way between two places with a course each is an arc, a straight line or an arc, and an arc, all arcs of the
//! smallest radius. The six kinds and their lengths are those of A. M. Shkel and V. Lumelsky, "Classification of the
//! Dubins set", Robotics and Autonomous Systems 34 (2001), eq. 6 to 11, here in their geometric form.

use std::f64::consts::{FRAC_PI_2, TAU};

use crate::guidance::NorthEast;

/// A place and a course.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Pose {
    /// Where.
    pub at: NorthEast,
    /// Course, radians from north.
    pub course_rad: f64,
}

/// A piece of a way.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Piece {
    /// Its angle, radians, positive to the right.
    Arc(f64),
    /// Its length, m.
    Straight(f64),
}

/// Arcs below this do not count as turns, radians.
const NO_TURN_RAD: f64 = 0.02;

/// Where two lines that touch an arc meet.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Corner {
    /// Where.
    pub at: NorthEast,
    /// How far before it the arc begins, and how far after it the arc ends, m.
    pub tangent_m: f64,
}

/// The corners of the shortest way from one pose to another with arcs of this radius, neither pose among them.
///
/// Each arc is given by the corners of the lines that touch it, a right angle or less at each: a plane that begins its
/// turn before a waypoint, as ArduPlane does at the distance that the item gives it, flies the arc.
pub fn corners(from: Pose, to: Pose, radius_m: f64) -> Vec<Corner> {
    let mut corners = Vec::new();
    let mut pose = from;
    for piece in shortest(from, to, radius_m) {
        match piece {
            Piece::Straight(length_m) => pose.at = pose.at + NorthEast::from_bearing(pose.course_rad) * length_m,
            Piece::Arc(angle) => {
                let parts = (angle.abs() / FRAC_PI_2 - 1e-9).ceil().max(1.0);
                let part = angle / parts;
                let tangent_m = radius_m * (part.abs() / 2.0).tan();
                for _ in 0..parts as u32 {
                    let corner = pose.at + NorthEast::from_bearing(pose.course_rad) * tangent_m;
                    pose.course_rad += part;
                    pose.at = corner + NorthEast::from_bearing(pose.course_rad) * tangent_m;
                    if part.abs() > NO_TURN_RAD {
                        corners.push(Corner { at: corner, tangent_m });
                    }
                }
            }
        }
    }
    corners
}

/// The shortest of the six ways.
fn shortest(from: Pose, to: Pose, radius_m: f64) -> [Piece; 3] {
    let centre =
        |pose: Pose, side: f64| pose.at + NorthEast::from_bearing(pose.course_rad + side * FRAC_PI_2) * radius_m;
    let turn = |from: f64, to: f64, side: f64| {
        let angle = (side * (to - from)).rem_euclid(TAU);
        // Rounding would turn an arc of 0 into a whole circle.
        side * if angle > TAU - 1e-9 { 0.0 } else { angle }
    };
    let mut best = (f64::INFINITY, [Piece::Straight(0.0); 3]);
    let mut consider = |pieces: [Piece; 3]| {
        let length = |piece: Piece| match piece {
            Piece::Arc(angle) => angle.abs() * radius_m,
            Piece::Straight(length_m) => length_m,
        };
        let length_m = pieces.into_iter().map(length).sum::<f64>();
        if length_m < best.0 {
            best = (length_m, pieces);
        }
    };
    for first in [1.0, -1.0] {
        for last in [1.0, -1.0] {
            let between = centre(to, last) - centre(from, first);
            let (apart_m, bearing) = (between.length(), between.bearing_rad());
            // Round both circles the same way the line is as long as their centres are apart; round them in opposite
            // ways it crosses.
            let across = if first == last { 0.0 } else { 2.0 * radius_m };
            if apart_m >= across {
                let course = bearing + first * (across / apart_m.max(1e-9)).min(1.0).asin();
                let line_m = (apart_m * apart_m - across * across).max(0.0).sqrt();
                consider([
                    Piece::Arc(turn(from.course_rad, course, first)),
                    Piece::Straight(line_m),
                    Piece::Arc(turn(course, to.course_rad, last)),
                ]);
            }
            // A third circle that touches both, on either side of the line between their centres.
            if first == last && apart_m < 4.0 * radius_m {
                let inner = (apart_m / (4.0 * radius_m)).acos();
                for side in [1.0, -1.0] {
                    let middle =
                        centre(from, first) + NorthEast::from_bearing(bearing + side * inner) * (2.0 * radius_m);
                    let touch = |one: NorthEast| (middle - one).bearing_rad() + first * FRAC_PI_2;
                    let (out, back) = (touch(centre(from, first)), touch(centre(to, last)));
                    consider([
                        Piece::Arc(turn(from.course_rad, out, first)),
                        Piece::Arc(turn(out, back, -first)),
                        Piece::Arc(turn(back, to.course_rad, last)),
                    ]);
                }
            }
        }
    }
    best.1
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::guidance::wrap_pi;
    use proptest::prelude::*;
    use std::f64::consts::PI;

    fn pose(north: f64, east: f64, course_deg: f64) -> Pose {
        Pose { at: NorthEast::new(north, east), course_rad: course_deg.to_radians() }
    }

    #[test]
    fn a_wide_turn_has_two_corners_and_a_narrow_one_goes_round() {
        let wide = corners(pose(0.0, 0.0, 0.0), pose(0.0, 200.0, 180.0), 50.0);
        assert_eq!(wide.len(), 2);
        assert!(
            (wide[0].at - NorthEast::new(50.0, 0.0)).length() < 1e-9
                && (wide[1].at - NorthEast::new(50.0, 200.0)).length() < 1e-9
        );
        let narrow = corners(pose(0.0, 0.0, 0.0), pose(0.0, 20.0, 180.0), 50.0);
        assert!(narrow.len() >= 4, "{narrow:?}");
        assert!(narrow.iter().any(|corner| corner.at.east < 0.0), "out to the other side first: {narrow:?}");
        assert_eq!(corners(pose(0.0, 0.0, 0.0), pose(500.0, 0.0, 0.0), 50.0), []);
    }

    proptest! {
        /// Where it ends is where it should, whatever way it takes, and it is no longer than a known way.
        #[test]
        fn the_way_leads_there(north in -900.0..900.0, east in -900.0..900.0, out_deg in 0.0..360.0, in_deg in 0.0..360.0, radius_m in 20.0..150.0) {
            let (from, to) = (pose(0.0, 0.0, out_deg), pose(north, east, in_deg));
            let mut end = from;
            let mut length_m = 0.0;
            for piece in shortest(from, to, radius_m) {
                match piece {
                    Piece::Straight(way_m) => {
                        end.at = end.at + NorthEast::from_bearing(end.course_rad) * way_m;
                        length_m += way_m;
                    }
                    Piece::Arc(angle) => {
                        let side = FRAC_PI_2.copysign(angle);
                        let centre = end.at + NorthEast::from_bearing(end.course_rad + side) * radius_m;
                        end.course_rad += angle;
                        end.at = centre - NorthEast::from_bearing(end.course_rad + side) * radius_m;
                        length_m += angle.abs() * radius_m;
                    }
                }
            }
            prop_assert!((end.at - to.at).length() < 1e-3, "{end:?} {to:?}");
            prop_assert!(wrap_pi(end.course_rad - to.course_rad).abs() < 1e-6);
            // Dubins: never longer than the straight way and both circles, and a third where they overlap.
            prop_assert!(length_m <= to.at.length() + (2.0 * TAU + PI) * radius_m);
            prop_assert!(length_m >= to.at.length() - 1e-6);
        }
    }
}
