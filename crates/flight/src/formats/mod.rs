//! Files that hold plans and parameters: reading, writing, and telling them apart.
//!
//! Files are untrusted: sizes are bounded, every number is checked, and every error names the line or
//! JSON path, what is wrong and how to mend it.

mod param_file;
mod plan_json;
mod point_lists;
mod waypoints;

pub use param_file::{ParamDialect, ParamEntry, read_params, write_params};
pub use plan_json::{read_plan_json, write_plan_json};
pub use waypoints::{read_waypoints, write_waypoints};

use crate::error::{FlightError, Result};
use crate::plan::{MAX_ITEMS, Plan};
use point_lists::{PointList, point_list_of, read_fence_points, read_rally_points};

/// Largest file that is read, bytes.
pub const MAX_FILE_BYTES: usize = 16 * 1024 * 1024;

/// How a plan is written to a file.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum PlanFormat {
    /// `.plan`: JSON of QGroundControl, version 1. Mission, fence and rally. `.mission`, its ancestor, is read.
    QgcPlan,
    /// `.waypoints`, `.txt`: "QGC WPL 110", tab-separated. Mission, fence or rally.
    Waypoints,
    /// `.fen`, `.ral`, `.txt`: a line for each point. Fence or rally of older programs; read, never written.
    Points,
}

/// What a plan file says beside the plan. QGroundControl plans for these; no vehicle is told.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct PlanSettings {
    /// Speed to plan times with, metres per second (airspeed of a plane).
    pub cruise_speed_m_s: Option<f64>,
    /// Speed of a vehicle that hovers, metres per second.
    pub hover_speed_m_s: Option<f64>,
    /// `MAV_TYPE`; 1 is a fixed-wing plane.
    pub vehicle_type: Option<u8>,
    /// `MAV_AUTOPILOT`; 3 is ArduPilot.
    pub firmware_type: Option<u8>,
}

/// A plan as read from a file.
#[derive(Debug, Clone, PartialEq)]
pub struct PlanFile {
    /// The plan.
    pub plan: Plan,
    /// What the file says beside it.
    pub settings: PlanSettings,
    /// How it was written.
    pub format: PlanFormat,
}

/// Reads a plan of any known format, told apart by its content.
///
/// `file_name` serves the message alone, when the content is of no known kind.
///
/// # Errors
/// [`FlightError::BadFile`] when the file is too large, empty, not UTF-8 or of no known format, else as
/// [`read_plan_json`] and [`read_waypoints`], whose faults name the place.
pub fn read_plan(bytes: &[u8], file_name: Option<&str>) -> Result<PlanFile> {
    let text = text_of(bytes)?;
    let start = text.trim_start();
    if start.starts_with('{') {
        return read_plan_json(bytes);
    }
    if start.get(..7).is_some_and(|word| word.eq_ignore_ascii_case("QGC WPL")) {
        return Ok(PlanFile {
            plan: read_waypoints(bytes)?,
            settings: PlanSettings::default(),
            format: PlanFormat::Waypoints,
        });
    }
    if let Some(list) = point_list_of(text) {
        let mut plan = Plan::default();
        match list {
            PointList::Fence => plan.fence = read_fence_points(text)?,
            PointList::Rally => plan.rally = read_rally_points(text)?,
        }
        return Ok(PlanFile { plan, settings: PlanSettings::default(), format: PlanFormat::Points });
    }
    let name = file_name.unwrap_or("the file");
    let found = match start.chars().next() {
        Some('<') => "it looks like XML (KML or GPX)",
        Some('[') => "it is a JSON list, a plan is a JSON object",
        _ => "it begins with neither \"{\" nor \"QGC WPL 110\"",
    };
    Err(FlightError::BadFile(format!(
        "{name} is no plan that can be read: {found}. Save it as .plan (QGroundControl) or .waypoints (Mission Planner)"
    )))
}

/// The text of a file: bounded, UTF-8, without byte-order mark, not empty.
fn text_of(bytes: &[u8]) -> Result<&str> {
    if bytes.len() > MAX_FILE_BYTES {
        return Err(FlightError::BadFile(format!(
            "the file has {} bytes; files up to {MAX_FILE_BYTES} bytes are read, so split it",
            bytes.len()
        )));
    }
    if bytes.starts_with(&[0xFF, 0xFE]) || bytes.starts_with(&[0xFE, 0xFF]) || bytes.contains(&0) {
        return Err(FlightError::BadFile(
            "the file is UTF-16 or binary, not text in UTF-8; save it again as UTF-8".into(),
        ));
    }
    let bytes = bytes.strip_prefix(&[0xEF, 0xBB, 0xBF]).unwrap_or(bytes);
    let text = std::str::from_utf8(bytes).map_err(|error| {
        FlightError::BadFile(format!(
            "the file is not UTF-8 text from byte {} on; save it again as UTF-8",
            error.valid_up_to()
        ))
    })?;
    if text.trim().is_empty() {
        return Err(FlightError::BadFile("the file is empty; choose another or save it again".into()));
    }
    Ok(text)
}

/// Text of a file in an error message: cut, and without control characters.
fn shown(text: &str) -> String {
    const MAX_CHARS: usize = 40;
    let mut short: String = text.chars().take(MAX_CHARS).map(|c| if c.is_control() { '?' } else { c }).collect();
    if text.chars().nth(MAX_CHARS).is_some() {
        short.push('…');
    }
    short
}

/// A number of a text file, or what is wrong with it.
fn number(text: &str, column: &str) -> std::result::Result<f64, String> {
    match text.parse::<f64>() {
        Ok(value) if value.is_finite() => Ok(value),
        _ if text.contains(',') => {
            Err(format!("has \"{}\" as its {column}; write decimals with a point, not a comma", shown(text)))
        }
        _ => Err(format!("has \"{}\" as its {column}; a finite number belongs there", shown(text))),
    }
}

/// Why a list of items is too long, if it is.
fn too_many(count: usize) -> Option<String> {
    (count > MAX_ITEMS).then(|| format!("has {count} items; at most {MAX_ITEMS} are read, so split the plan"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn content_decides() {
        let wpl = b"\xEF\xBB\xBF\r\nQGC WPL 110\r\n0\t1\t0\t16\t0\t0\t0\t0\t40\t-3\t600\t1\r\n";
        assert_eq!(read_plan(wpl, Some("misnamed.plan")).unwrap().format, PlanFormat::Waypoints);
        let json = write_plan_json(&Plan::default(), &PlanSettings::default()).unwrap();
        assert_eq!(read_plan(json.as_bytes(), Some("x.waypoints")).unwrap().format, PlanFormat::QgcPlan);
    }

    #[test]
    fn what_is_no_plan_is_refused_with_a_way_out() {
        let utf16: Vec<u8> = "QGC WPL 110".encode_utf16().flat_map(u16::to_le_bytes).collect();
        let large = vec![b' '; MAX_FILE_BYTES + 1];
        let cases: [(&[u8], &str); 8] = [
            (b"", "empty"),
            (b" \r\n\t", "empty"),
            (&utf16, "UTF-16"),
            (b"\xFF\xFEQ\0", "UTF-16"),
            (b"QGC WPL 110 \xC3\x28", "not UTF-8 text from byte 12"),
            (&large, "split it"),
            (b"<kml/>", "KML"),
            (b"hello", "hello.txt is no plan"),
        ];
        for (bytes, expected) in cases {
            let error = read_plan(bytes, Some("hello.txt")).unwrap_err().to_string();
            assert!(error.contains(expected), "{error}");
        }
    }

    #[test]
    fn shown_text_is_short_and_clean() {
        assert_eq!(shown("a\x1b[31m"), "a?[31m");
        assert_eq!(shown(&"x".repeat(1000)).chars().count(), 41);
    }
}
