//! The one error type of this crate.
//!
//! Every message says what was wrong, where (item, line or JSON path) and what to do about it.

use crate::plan::Command;

/// Everything that this crate refuses.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum FlightError {
    /// A latitude or longitude that is not on the globe.
    #[error(
        "latitude {lat_deg}, longitude {lon_deg} is not a position on Earth: latitude goes from -90 to 90 degrees, longitude from -180 to 180"
    )]
    NotOnEarth {
        /// Latitude given, degrees.
        lat_deg: f64,
        /// Longitude given, degrees.
        lon_deg: f64,
    },
    /// A plan item holds a value that cannot be sent or used.
    #[error("item {seq} ({command}): {field} is {value}, {problem}")]
    BadItem {
        /// Sequence number on the wire.
        seq: u16,
        /// What the item does.
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
        /// What is wrong and how to mend it.
        problem: String,
    },
    /// A list of rally items that does not describe rally points.
    #[error("rally item {index}: {problem}")]
    BadRally {
        /// Position in the list, from 0.
        index: usize,
        /// What is wrong and how to mend it.
        problem: String,
    },
    /// A list of mission items that cannot be a mission.
    #[error("mission item {index}: {problem}")]
    BadMission {
        /// Position in the list, from 0.
        index: usize,
        /// What is wrong and how to mend it.
        problem: String,
    },
    /// A text file with a fault in one line.
    #[error("line {line}: {problem}")]
    BadLine {
        /// Line number, from 1.
        line: usize,
        /// What is wrong and how to mend it.
        problem: String,
    },
    /// A JSON file with a fault at one place.
    #[error("{path}: {problem}")]
    BadJson {
        /// Where, as in `mission.items[3].params[4]`; `line 4, column 7` when the text is not JSON.
        path: String,
        /// What is wrong and how to mend it.
        problem: String,
    },
    /// A landing that cannot be designed as it is asked for.
    #[error("landing: {0}")]
    BadLanding(LandingProblem),
    /// A file that cannot be read as a whole.
    #[error("{0}")]
    BadFile(String),
}

/// Why a landing cannot be designed.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum LandingProblem {
    /// An option is out of its range.
    #[error("{option} is {value}: it goes from {low} to {high}")]
    OutOfRange {
        /// Its name.
        option: &'static str,
        /// What was given.
        value: f64,
        /// The least.
        low: f64,
        /// The most.
        high: f64,
    },
    /// Neither course, nor where the plane comes from, nor wind.
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
}

/// Result with [`FlightError`].
pub type Result<T> = std::result::Result<T, FlightError>;
