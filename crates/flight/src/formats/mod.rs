//! Files that hold plans and parameters: reading, writing, and telling them apart.
//!
//! Files are untrusted: sizes are bounded, every number is checked, and every error names the line or
//! JSON path, what is wrong and how to mend it.

mod param_file;
mod plan_file;
mod plan_json;
mod point_lists;
mod text;
mod waypoints;

pub use param_file::{ParamDialect, ParamEntry, read_params, write_params};
pub use plan_file::{PlanFile, PlanFormat, PlanSettings};
pub use plan_json::{read_plan_json, write_plan_json};
pub use text::MAX_FILE_BYTES;
pub use waypoints::{read_waypoints, write_waypoints};

use crate::error::{FlightError, Result};
use crate::plan::Plan;
use point_lists::{PointList, point_list_of, read_fence_points, read_rally_points};
use text::text_of;

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
}
