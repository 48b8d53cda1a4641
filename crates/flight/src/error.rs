//! The one error type of this crate.
//!
//! Every message names the fault, its place (item, line or JSON path) and the remedy.

use std::fmt;

use vencejo_proto::Counted;

use crate::plan::Command;

/// Everything that this crate refuses.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum FlightError {
    /// A latitude or longitude that is not on the globe.
    #[error(
        "latitude {}, longitude {} is not a position on Earth: latitude goes from -90 to 90 degrees, longitude from -180 to 180",
        Plain(*lat_deg),
        Plain(*lon_deg)
    )]
    NotOnEarth {
        /// Latitude given, degrees.
        lat_deg: f64,
        /// Longitude given, degrees.
        lon_deg: f64,
    },
    /// A home that is higher or lower than anything flies.
    #[error("home lies {} m above the sea, but a height stays within 83,000 m", Plain(*alt_amsl_m))]
    HomeHeight {
        /// Height given, metres above mean sea level.
        alt_amsl_m: f64,
    },
    /// A plan item holds a value that cannot be sent or used.
    #[error("item {seq} ({command}): {field} is {}, {problem}", Plain(*value))]
    BadItem {
        /// Sequence number on the wire.
        seq: u16,
        /// Its command.
        command: Command,
        /// Name of the field: `param1` … `param4`, `x`, `y`, `z`, `frame`.
        field: &'static str,
        /// The value found.
        value: f64,
        /// Why it is wrong and what would be right.
        problem: &'static str,
    },
    /// A `MAV_MISSION_TYPE` other than mission, fence and rally.
    #[error("plan kind {0} is unknown: 0 is a mission, 1 a fence, 2 rally points")]
    UnknownPlanKind(u8),
    /// A list of fence items that does not describe a fence.
    #[error("fence item {index}: {problem}")]
    BadFence {
        /// Position in the list, from 0.
        index: usize,
        /// The fault and its remedy.
        problem: String,
    },
    /// A list of rally items that does not describe rally points.
    #[error("rally item {index}: {problem}")]
    BadRally {
        /// Position in the list, from 0.
        index: usize,
        /// The fault and its remedy.
        problem: String,
    },
    /// A list of mission items that cannot be a mission.
    #[error("mission item {}: {problem}", index + 1)]
    BadMission {
        /// Position in the list, from 0.
        index: usize,
        /// The fault and its remedy.
        problem: String,
    },
    /// A text file with a fault in one line.
    #[error("line {line}: {problem}")]
    BadLine {
        /// Line number, from 1.
        line: usize,
        /// The fault and its remedy.
        problem: String,
    },
    /// A JSON file with a fault at one place.
    #[error("{path}: {problem}")]
    BadJson {
        /// Where, as in `mission.items[3].params[4]`; `line 4, column 7` when the text is not JSON.
        path: String,
        /// The fault and its remedy.
        problem: String,
    },
    /// A landing that cannot be designed as it is asked for.
    #[error("landing: {0}")]
    BadLanding(LandingProblem),
    /// A survey that cannot be laid out as it is asked for.
    #[error("survey: {0}")]
    BadSurvey(SurveyProblem),
    /// A file that cannot be read as a whole.
    #[error("{0}")]
    BadFile(String),
}

/// A number in a message: extreme ones in scientific notation, so that no message is hundreds of digits long.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Plain(pub f64);

impl fmt::Display for Plain {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self(value) = self;
        if *value == 0.0 || !value.is_finite() || (1e-9..1e15).contains(&value.abs()) {
            write!(f, "{value}")
        } else {
            write!(f, "{value:e}")
        }
    }
}

/// Why a landing cannot be designed.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum LandingProblem {
    /// An option is out of its range.
    #[error("{option} is {}, should be {low} to {high}", Plain(*value))]
    OutOfRange {
        /// Its name.
        option: &'static str,
        /// The value.
        value: f64,
        /// The least.
        low: f64,
        /// The most.
        high: f64,
    },
    /// Course, origin and wind are all missing.
    #[error(
        "nothing says in which direction to land: give the runway's course, a place at least {nearest_m} m away that the plane comes from, or the wind"
    )]
    NoDirection {
        /// How far away that place must lie at least, m.
        nearest_m: f64,
    },
    /// It would not get to the point, or not slowly enough.
    #[error(
        "with {wind_m_s:.0} m/s of wind a plane of {airspeed_m_s:.0} m/s does not come in on course {course_deg:.0}: land faster, into the wind, or later"
    )]
    TooMuchWind {
        /// The wind's speed, m/s.
        wind_m_s: f64,
        /// The plane's, m/s.
        airspeed_m_s: f64,
        /// Course of the final leg, degrees from true north.
        course_deg: f64,
    },
    /// A part of something else was to be moved.
    #[error(
        "only a landing as it is designed can be moved: a circle down (NAV_LOITER_TO_ALT) and NAV_LAND, with heights above home"
    )]
    NotDesigned,
}

/// Why a survey cannot be laid out.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum SurveyProblem {
    /// An option is out of its range.
    #[error("{option} is {}, should be {low} to {high}", Plain(*value))]
    OutOfRange {
        /// Its name.
        option: &'static str,
        /// The value.
        value: f64,
        /// The least.
        low: f64,
        /// The most.
        high: f64,
    },
    /// An option that is missing, or one beside another that says the same.
    #[error("{0}")]
    Unclear(&'static str),
    /// Too few places to make an area or a line.
    #[error("the shape has {}, it needs {least} or more that differ: add some", Counted(*count, "corner"))]
    TooFewCorners {
        /// How many there are.
        count: usize,
        /// How many it needs.
        least: usize,
    },
    /// More corners than are worked with.
    #[error("the shape has {count} corners, at most {max} are worked with: simplify it")]
    TooManyCorners {
        /// How many there are.
        count: usize,
        /// The most.
        max: usize,
    },
    /// Two sides of the area cross or touch.
    #[error("the side from corner {one} crosses the side from corner {other}: move one of them, or make two areas")]
    CrossesItself {
        /// The corner that one begins at, counted from 1.
        one: usize,
        /// The corner that the other begins at.
        other: usize,
    },
    /// Smaller than anybody can mean.
    #[error("the shape measures {size:.0} {unit}, less than {least} {unit}: draw it larger")]
    TooSmall {
        /// The quantity.
        size: f64,
        /// The least.
        least: f64,
        /// `m²` of an area, `m` of a line.
        unit: &'static str,
    },
    /// Larger than a plane covers from one place.
    #[error("corner {corner} lies outside the {most_m:.0} m that a survey may measure: check it, or split the shape")]
    TooLarge {
        /// The corner, counted from 1.
        corner: usize,
        /// The most, m.
        most_m: f64,
    },
    /// The plane would not get along the lines, or not steadily.
    #[error(
        "with {wind_m_s:.0} m/s of wind a plane of {airspeed_m_s:.0} m/s does not get along lines of course {course_deg:.0}: fly faster, along another course, or later"
    )]
    TooMuchWind {
        /// The wind's speed, m/s.
        wind_m_s: f64,
        /// The plane's, m/s.
        airspeed_m_s: f64,
        /// Course of the lines, degrees from true north.
        course_deg: f64,
    },
    /// More items than the vehicle holds.
    #[error(
        "it takes {count} items or more, the vehicle holds {max}: widen the spacing, fly higher, overlap less, or split the shape"
    )]
    TooManyItems {
        /// How many, at least.
        count: usize,
        /// The most.
        max: usize,
    },
}

/// Result with [`FlightError`].
pub type Result<T> = std::result::Result<T, FlightError>;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_number_fits_into_its_message() {
        let shown = [0.0, 91.0, -3.7, 1e14, 1e-9, 1e308, -1e-300, f64::NAN, f64::NEG_INFINITY]
            .map(|value| Plain(value).to_string());
        assert_eq!(shown, ["0", "91", "-3.7", "100000000000000", "0.000000001", "1e308", "-1e-300", "NaN", "-inf"]);
        let odd = SurveyProblem::OutOfRange { option: "height_m", value: 1e308, low: 5.0, high: 10_000.0 };
        assert_eq!(FlightError::BadSurvey(odd).to_string(), "survey: height_m is 1e308, should be 5 to 10000");
    }
}
