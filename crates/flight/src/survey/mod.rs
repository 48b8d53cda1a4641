//! Surveys for a plane: the lines from which it photographs an area or a corridor, and their coverage.
//!
//! [`design_survey`] lays out lines, leads and turns that the plane can fly, with the camera's triggers, as mission
//! items. The plan that holds them is rehearsed as any other ([`crate::rehearsal`]), and [`coverage`] tells from the
//! rehearsed flight where each picture is taken, how much of the area they show, and which lines were missed.
//!
//! | file | what it holds |
//! |---|---|
//! | `camera` | ground sample distance, height and footprint; known cameras |
//! | `region` | the area or corridor, in metres |
//! | `order` | the race-track order of lines |
//! | `turn` | the shortest way that a plane can turn |
//! | `options` | the options and their ranges |
//! | `design` | speeds, distances and course of a survey |
//! | `layout` | lines of an area, passes of a corridor |
//! | `route` | leads, turns and triggers as mission items |
//! | `flown` | pictures and coverage of a rehearsed flight |
//!
//! # Limits
//!
//! The ground is level, at the height that is given, unless heights count from the terrain; obstacles are unknown. The
//! camera is fixed in the plane and looks down when it flies level. A bay of a concave area is flown through, not
//! round.

mod camera;
mod design;
mod flown;
mod layout;
mod options;
mod order;
mod region;
mod route;
mod turn;

#[cfg(test)]
mod tests;

pub use camera::{CAMERAS, Camera, Footprint, KnownCamera, camera_named};
pub use design::{LineCourse, Survey, SurveyCaution, design_survey};
pub use flown::{Coverage, FlownLine, Hole, Photo, coverage, photographs, rehearse_survey};
pub use layout::SurveyLine;
pub use options::SurveyOptions;
pub use region::{LEAST_AREA_M2, LEAST_LINE_M, MAX_CORNERS, SurveyShape};
