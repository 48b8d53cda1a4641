//! The options of a survey and their ranges.

use super::camera::Camera;
use super::region::SurveyShape;
use crate::error::{FlightError, Result, SurveyProblem};
use crate::geodesy::GeoPoint;
use crate::landing::Wind;

/// How a survey is flown, with defaults. Ground sample distance or height, and a camera or a spacing, have to be given.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SurveyOptions {
    /// The camera; `None`: unknown, with `height_m` and `spacing_m` given.
    pub camera: Option<Camera>,
    /// Whether the wide side of the picture lies across the track. Default yes.
    pub is_landscape: bool,
    /// Ground that a pixel is to cover, m, 0.0005 to 10; `None`: from `height_m`.
    pub gsd_m: Option<f64>,
    /// Height above the ground, m, 5 to 10,000; `None`: from `gsd_m`.
    pub height_m: Option<f64>,
    /// Part of a picture that the next one on the line shows too, 0 to 0.95. Default 0.75.
    pub front_overlap: f64,
    /// Part of a picture that those of the next line show too, 0 to 0.95. Default 0.65.
    pub side_overlap: f64,
    /// Distance between two lines, m, 1 to 10,000, in place of that from `side_overlap`.
    pub spacing_m: Option<f64>,
    /// Distance between two pictures, m, 0.5 to 10,000, in place of that from `front_overlap`; without a camera `None`
    /// takes no pictures.
    pub trigger_m: Option<f64>,
    /// Course of the lines of an area, degrees from true north; `None`: across the wind, in calm air along the area.
    pub course_deg: Option<f64>,
    /// Expected wind; `None`: calm.
    pub wind: Option<Wind>,
    /// How far beyond the edge pictures reach, m, 0 to 1,000; `None`: so far that the overlap holds up to the edge.
    pub margin_m: Option<f64>,
    /// Straight way before the first picture of a line, m, 0 to 5,000; `None`: long enough to settle on it.
    pub lead_in_m: Option<f64>,
    /// Whether heights count from the ground below (frame 10) and not from home.
    pub is_above_terrain: bool,
    /// Height of the ground above home, m, −1,000 to 10,000; `None`: unknown, home's is taken. Nothing above terrain.
    pub ground_rel_home_m: Option<f64>,
    /// Airspeed of the survey, m/s EAS, 5 to 60, set by an item; `None`: the plane's cruise.
    pub airspeed_m_s: Option<f64>,
    /// Height of home above the sea, m: thin air needs wider turns. Default 0.
    pub home_amsl_m: f64,
    /// Where the plane comes from: the survey begins at the end that is nearest; `None`: downwind, and goes on against
    /// the wind.
    pub coming_from: Option<GeoPoint>,
    /// Items that the vehicle holds. Default 650, of which home is one.
    pub max_items: usize,
}

impl Default for SurveyOptions {
    fn default() -> Self {
        Self {
            camera: None,
            is_landscape: true,
            gsd_m: None,
            height_m: None,
            front_overlap: 0.75,
            side_overlap: 0.65,
            spacing_m: None,
            trigger_m: None,
            course_deg: None,
            wind: None,
            margin_m: None,
            lead_in_m: None,
            is_above_terrain: false,
            ground_rel_home_m: None,
            airspeed_m_s: None,
            home_amsl_m: 0.0,
            coming_from: None,
            max_items: 650,
        }
    }
}

pub(super) fn unclear<T>(problem: &'static str) -> Result<T> {
    Err(FlightError::BadSurvey(SurveyProblem::Unclear(problem)))
}

pub(super) fn in_range(option: &'static str, value: f64, low: f64, high: f64) -> Result<()> {
    // NaN is in no range.
    if (low..=high).contains(&value) {
        Ok(())
    } else {
        Err(FlightError::BadSurvey(SurveyProblem::OutOfRange { option, value, low, high }))
    }
}

/// Whatever can be out of its range, and its range.
pub(super) fn check(shape: &SurveyShape, options: &SurveyOptions) -> Result<()> {
    let or = |value: Option<f64>, fine: f64| value.unwrap_or(fine);
    let wind = options.wind.unwrap_or_default();
    for (option, value, low, high) in [
        ("gsd_m", or(options.gsd_m, 1.0), 0.000_5, 10.0),
        ("height_m", or(options.height_m, 5.0), 5.0, 10_000.0),
        ("front_overlap", options.front_overlap, 0.0, 0.95),
        ("side_overlap", options.side_overlap, 0.0, 0.95),
        ("spacing_m", or(options.spacing_m, 1.0), 1.0, 10_000.0),
        ("trigger_m", or(options.trigger_m, 1.0), 0.5, 10_000.0),
        ("course_deg", or(options.course_deg, 0.0), -360.0, 360.0),
        ("wind from_deg", wind.from_deg, -360.0, 360.0),
        ("wind speed_m_s", wind.speed_m_s, 0.0, 60.0),
        ("margin_m", or(options.margin_m, 0.0), 0.0, 1_000.0),
        ("lead_in_m", or(options.lead_in_m, 0.0), 0.0, 5_000.0),
        ("ground_rel_home_m", or(options.ground_rel_home_m, 0.0), -1_000.0, 10_000.0),
        ("airspeed_m_s", or(options.airspeed_m_s, 5.0), 5.0, 60.0),
        ("home_amsl_m", options.home_amsl_m, -1_000.0, 10_000.0),
    ] {
        in_range(option, value, low, high)?;
    }
    if let SurveyShape::Corridor { width_m, .. } = shape {
        in_range("width_m", *width_m, 0.0, 5_000.0)?;
    }
    if let Some(camera) = options.camera {
        for (option, value, low, high) in [
            ("sensor_width_mm", camera.sensor_width_mm, 0.5, 200.0),
            ("sensor_height_mm", camera.sensor_height_mm, 0.5, 200.0),
            ("image_width_px", f64::from(camera.image_width_px), 16.0, 100_000.0),
            ("image_height_px", f64::from(camera.image_height_px), 16.0, 100_000.0),
            ("focal_length_mm", camera.focal_length_mm, 0.5, 2_000.0),
            ("min_interval_s", camera.min_interval_s, 0.0, 60.0),
        ] {
            in_range(option, value, low, high)?;
        }
    }
    Ok(())
}
