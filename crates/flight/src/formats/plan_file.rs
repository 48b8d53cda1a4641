//! The content of plan files, independent of their format.

use crate::formats::notes::Note;
use crate::plan::Plan;

/// How a plan is written to a file.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum PlanFormat {
    /// `.plan`: JSON of QGroundControl, version 1. Mission, fence and rally. `.mission`, its ancestor, is read.
    QgcPlan,
    /// `.waypoints`, `.txt`: "QGC WPL 110", tab-separated. Mission, fence or rally.
    Waypoints,
    /// `.fen`, `.ral`, `.txt`: a line for each point. Fence or rally of older programs; read, never written.
    Points,
    /// `.kml`: Google Earth's XML. Everything; heights above home are drawn above the sea.
    Kml,
    /// `.kmz`: a `.kml` in a zip.
    Kmz,
    /// `.geojson`: RFC 7946. Everything, heights among the properties.
    GeoJson,
    /// `.gpx`: routes of satellite receivers, GPX 1.1. Places of a mission with heights above the sea.
    Gpx,
    /// `.csv`: a table with a row for each item, as `.waypoints` has them. Everything.
    Csv,
}

impl PlanFormat {
    /// All that are written.
    pub const WRITTEN: [Self; 7] =
        [Self::QgcPlan, Self::Waypoints, Self::Kml, Self::Kmz, Self::GeoJson, Self::Gpx, Self::Csv];

    /// The format that a file's name asks for by its ending, whatever the case; `None` for any other ending.
    pub fn of_name(name: &str) -> Option<Self> {
        let ending = name.rsplit_once('.')?.1.to_ascii_lowercase();
        match ending.as_str() {
            "txt" => Some(Self::Waypoints),
            _ => Self::WRITTEN.into_iter().find(|format| format.ending() == ending),
        }
    }

    /// The ending of a file's name, without the dot.
    pub const fn ending(self) -> &'static str {
        match self {
            Self::QgcPlan => "plan",
            Self::Waypoints => "waypoints",
            Self::Points => "txt",
            Self::Kml => "kml",
            Self::Kmz => "kmz",
            Self::GeoJson => "geojson",
            Self::Gpx => "gpx",
            Self::Csv => "csv",
        }
    }

    /// The media type, as IANA has it where it has one.
    pub const fn media_type(self) -> &'static str {
        match self {
            Self::QgcPlan => "application/json",
            Self::Waypoints | Self::Points => "text/plain; charset=utf-8",
            Self::Kml => "application/vnd.google-earth.kml+xml",
            Self::Kmz => "application/vnd.google-earth.kmz",
            Self::GeoJson => "application/geo+json",
            Self::Gpx => "application/gpx+xml",
            Self::Csv => "text/csv; charset=utf-8",
        }
    }
}

/// An item of a `.plan` that stands for several: a survey, a corridor, a landing pattern, a structure scan.
///
/// The mission holds the items that it stands for. It is kept beside them, and written in their place as long as they
/// are in the mission as it made them: so QGroundControl opens it as what it was.
#[derive(Debug, Clone, PartialEq, Eq)]
#[cfg_attr(feature = "describe", derive(serde::Serialize, serde::Deserialize, utoipa::ToSchema))]
#[cfg_attr(feature = "describe", serde(deny_unknown_fields))]
pub struct ComplexItem {
    /// `complexItemType`: `survey`, `CorridorScan`, `fwLandingPattern`, `StructureScan`….
    pub kind: String,
    /// The whole of it, as JSON.
    pub json: String,
}

/// The vehicle that a `.plan` file was planned for. QGroundControl offers the commands of this vehicle, and plans times
/// with its speeds; nothing of it is sent to a vehicle.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
#[cfg_attr(feature = "describe", derive(serde::Serialize, serde::Deserialize, utoipa::ToSchema))]
#[cfg_attr(feature = "describe", serde(default, deny_unknown_fields))]
pub struct PlannedFor {
    /// Speed to plan times with, metres per second (airspeed of a plane), 0 to 1000.
    pub cruise_speed_m_s: Option<f64>,
    /// Speed of a vehicle that hovers, metres per second, 0 to 1000.
    pub hover_speed_m_s: Option<f64>,
    /// `MAV_TYPE`; 1 is a fixed-wing plane.
    pub vehicle_type: Option<u8>,
    /// `MAV_AUTOPILOT`; 3 is ArduPilot.
    pub firmware_type: Option<u8>,
}

/// What a plan file holds beside the plan.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct PlanSettings {
    /// The vehicle that it was planned for.
    pub planned_for: PlannedFor,
    /// Items of the mission that stand for several, in the order of the file.
    pub complex_items: Vec<ComplexItem>,
}

/// A plan as read from a file.
#[derive(Debug, Clone, PartialEq)]
pub struct PlanFile {
    /// The plan.
    pub plan: Plan,
    /// Settings beside the plan.
    pub settings: PlanSettings,
    /// How it was written.
    pub format: PlanFormat,
    /// What had to be assumed or left out.
    pub notes: Vec<Note>,
}

/// A plan as written to a file.
#[derive(Debug, Clone, PartialEq)]
pub struct WrittenPlan {
    /// The file.
    pub bytes: Vec<u8>,
    /// Notes on what was changed or left out.
    pub notes: Vec<Note>,
}
