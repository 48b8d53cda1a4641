//! Moving one part of a landing: the other parts follow.

use super::{RADIUS_M, SLOPE};
use crate::error::{FlightError, LandingProblem, Result};
use crate::geodesy::{GeoPoint, inverse, wrap_360_deg};
use crate::landing::{Landing, LandingOptions, design_landing};
use crate::plan::{Command, MavFrame, MissionItem};

/// A part of a landing that can be moved.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "describe", derive(serde::Deserialize, utoipa::ToSchema), serde(rename_all = "kebab-case"))]
pub enum LandingPart {
    /// The point: the landing moves with it, its course and slope stay.
    Point,
    /// Where the final leg begins: it gives the course and the length, and with them the slope.
    FinalLeg,
    /// The centre of the circle, likewise.
    Circle,
}

/// A landing as it was designed, with one part somewhere else: the rest follows, the heights of the point and of the
/// final leg's beginning stay. The slope stays between 0.02 and 0.25.
///
/// # Errors
/// As [`design_landing`], and when the items are not a landing of this kind: a circle down, then the landing, both with
/// places and with heights above home.
pub fn move_landing(
    items: &[MissionItem],
    part: LandingPart,
    to: GeoPoint,
    options: &LandingOptions,
) -> Result<Landing> {
    let shape = Shape::of(items).ok_or(FlightError::BadLanding(LandingProblem::NotDesigned))?;
    let side = shape.radius_m.signum();
    let from_circle = |point: GeoPoint, centre: GeoPoint| {
        let line = inverse(centre, point);
        let final_m = (line.distance_m.powi(2) - shape.radius_m.powi(2)).max(1.0).sqrt();
        // The centre lies abeam of where the leg begins: the way to the point turns from the leg by the angle that the
        // radius covers.
        (line.bearing_end_deg + side * (shape.radius_m.abs() / final_m).atan().to_degrees(), final_m)
    };
    let (point, (course_deg, final_m)) = match part {
        LandingPart::Point => (to, from_circle(shape.point, shape.centre)),
        LandingPart::Circle => (shape.point, from_circle(shape.point, to)),
        LandingPart::FinalLeg => {
            let line = inverse(to, shape.point);
            (shape.point, (line.bearing_end_deg, line.distance_m.max(1.0)))
        }
    };
    design_landing(
        point,
        &LandingOptions {
            course_deg: Some(wrap_360_deg(course_deg)),
            ground_rel_home_m: options
                .ground_rel_home_m
                .filter(|_| part == LandingPart::Point)
                .or(Some(shape.ground_m)),
            slope: (shape.final_height_m / final_m).clamp(SLOPE.0, SLOPE.1),
            final_height_m: shape.final_height_m,
            radius_m: shape.radius_m.abs().clamp(RADIUS_M.0, RADIUS_M.1),
            is_clockwise: side > 0.0,
            has_land_start: shape.has_land_start,
            ..*options
        },
    )
}

/// How many of a mission's last items are a landing as one is designed, [`move_landing`]'s; `None` if they are not one.
pub(crate) fn designed_items(items: &[MissionItem]) -> Option<usize> {
    let last = |count: usize| items.len().checked_sub(count).map(|from| &items[from..]);
    [3, 2].into_iter().find(|count| last(*count).and_then(Shape::of).is_some())
}

/// The parts of a designed landing.
struct Shape {
    point: GeoPoint,
    centre: GeoPoint,
    /// Negative anticlockwise.
    radius_m: f64,
    ground_m: f64,
    final_height_m: f64,
    has_land_start: bool,
}

impl Shape {
    fn of(items: &[MissionItem]) -> Option<Self> {
        let (circle, land, has_land_start) = match items {
            [start, circle, land] if start.command == Command::DO_LAND_START => (circle, land, true),
            [circle, land] => (circle, land, false),
            _ => return None,
        };
        let is_landing = circle.command == Command::NAV_LOITER_TO_ALT && land.command == Command::NAV_LAND;
        let has_same_datum = circle.frame == land.frame;
        let (ground_m, alt_m) = (land.alt_m()?, circle.alt_m()?);
        (is_landing && has_same_datum && circle.frame == MavFrame::GlobalRelativeAlt).then_some(())?;
        Some(Self {
            point: land.point()?,
            centre: circle.point()?,
            radius_m: circle.param(2).filter(|radius_m| radius_m.abs() > 1.0)?,
            ground_m,
            final_height_m: alt_m - ground_m,
            has_land_start,
        })
    }
}
