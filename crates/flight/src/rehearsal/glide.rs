//! How far a plane without thrust gets.

use super::air::eas_to_tas;
use super::course::Course;
use super::fly::{Conditions, NotRehearsed, laid_out};
use super::outcome::Sample;
use crate::geodesy::{GeoPoint, wrap_180_deg};
use crate::guidance::{GRAVITY_M_S2, NorthEast, bound};
use crate::plan::Plan;

/// Directions that the glide is tried in.
const DIRECTIONS: u32 = 72;
/// Bank of the turn into the direction, degrees.
const TURN_BANK_DEG: f64 = 30.0;
/// Step along the glide, s.
const STEP_S: f64 = 1.0;
/// Longest glide, s.
const LONGEST_S: f64 = 3_600.0;

/// The ground that a plane may reach without thrust from a moment of its flight: where it comes down when it turns into
/// each of 72 directions with 30° of bank and glides straight on at the airspeed of its flattest glide, in this wind
/// and over this ground. The first is north, the others follow clockwise. Empty on
/// the ground.
///
/// In calm air a plane sinks over `1 m` of way by `D/W`, least where drag is least; with the polar `a V² + b n² V⁻²`
/// that is at `V = (b/a)^¼` (J. D. Anderson, *Aircraft Performance and Design*, eq. 5.36), held above the slowest
/// airspeed. The nose is held so that the course over ground is the direction (wind triangle); where the wind does not
/// allow it, it is the direction in the air.
///
/// # Errors
/// As [`rehearse`](super::rehearse).
pub fn glide_range(plan: &Plan, conditions: &Conditions<'_>, from: &Sample) -> Result<Vec<GeoPoint>, NotRehearsed> {
    let course = laid_out(plan, conditions)?;
    let start = course.position(from.point);
    if from.height_m <= course.assumed_ground_m(start) {
        return Ok(Vec::new());
    }
    let directions = (0..DIRECTIONS).map(|index| f64::from(index) * 360.0 / f64::from(DIRECTIONS));
    Ok(directions.map(|toward_deg| course.point(comes_down(&course, conditions, from, start, toward_deg))).collect())
}

/// Where the glide in one direction ends.
fn comes_down(
    course: &Course<'_>,
    conditions: &Conditions<'_>,
    from: &Sample,
    start: NorthEast,
    toward_deg: f64,
) -> NorthEast {
    let Conditions { plane, air, .. } = *conditions;
    let airspeed_m_s = plane.airframe.flattest_glide_m_s().max(plane.tecs.airspeed_min_m_s);
    let bank_rad = TURN_BANK_DEG.min(plane.bank_max_deg).max(5.0).to_radians();
    let (mut at, mut height_m, mut heading_deg) = (start, from.height_m, from.heading_deg);
    let mut time_s = 0.0;
    while time_s < LONGEST_S {
        let wind = air.steady(course.above_level_m(at, height_m));
        let eas_to_tas = eas_to_tas(course.home.alt_amsl_m + height_m);
        let factor = plane.airframe.true_over_indicated(eas_to_tas);
        let speed_m_s = airspeed_m_s * factor;
        let wanted_deg = heading_over_ground_deg(toward_deg, speed_m_s, wind);
        let left_deg = wrap_180_deg(wanted_deg - heading_deg);
        let rate_deg_s =
            (GRAVITY_M_S2 * bank_rad.tan() / speed_m_s / (1.0 + plane.airframe.skid(eas_to_tas))).to_degrees();
        let turns_deg = bound(left_deg, -rate_deg_s * STEP_S, rate_deg_s * STEP_S);
        let load = if left_deg.abs() > rate_deg_s * STEP_S { 1.0 / bank_rad.cos() } else { 1.0 };
        let middle = NorthEast::from_bearing((heading_deg + 0.5 * turns_deg).to_radians());
        heading_deg += turns_deg;
        let sink_m_s = speed_m_s * plane.airframe.drag(airspeed_m_s, load) / GRAVITY_M_S2;
        let moved = (middle * speed_m_s + wind) * STEP_S;
        let next_height_m = height_m - sink_m_s * STEP_S;
        let ground_m = course.assumed_ground_m(at + moved);
        if next_height_m <= ground_m {
            let above_m = height_m - course.assumed_ground_m(at);
            let below_m = ground_m - next_height_m;
            return at + moved * bound(above_m / (above_m + below_m).max(0.01), 0.0, 1.0);
        }
        (at, height_m) = (at + moved, next_height_m);
        time_s += STEP_S;
    }
    at
}

/// Heading of the nose whose course over ground is the one wanted.
fn heading_over_ground_deg(course_deg: f64, speed_m_s: f64, wind: NorthEast) -> f64 {
    let along = NorthEast::from_bearing(course_deg.to_radians());
    let across = along.cross(wind) / speed_m_s;
    if across.abs() < 1.0 { course_deg - across.asin().to_degrees() } else { course_deg }
}
