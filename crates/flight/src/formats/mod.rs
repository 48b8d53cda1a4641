//! Files that hold plans and parameters: reading, writing, and telling them apart.
//!
//! Files are untrusted: sizes are bounded, every number is checked, and every error names the line or
//! JSON path, the fault and its remedy.

mod geojson;
mod gpx;
mod json;
mod kml;
mod notes;
mod param_file;
mod places;
mod plan_file;
mod plan_json;
mod point_lists;
mod survey_item;
mod table;
mod text;
mod waypoints;
pub mod xml;

pub use notes::{Note, NoteCode};
pub use param_file::{ParamDialect, ParamEntry, read_params, write_params};
pub use plan_file::{ComplexItem, PlanFile, PlanFormat, PlanSettings, PlannedFor, WrittenPlan};
pub use plan_json::{ComplexPart, complex_parts, edited_complex_items, read_plan_json, write_plan_json};
pub use survey_item::{survey_item, survey_of};
pub use text::MAX_FILE_BYTES;
pub use waypoints::{read_waypoints, write_waypoints};

use vencejo_proto::MissionSeq;

use crate::error::{FlightError, Result};
use crate::plan::{Plan, PlanKind};
use notes::Notes;
use plan_json::read_plan_value;
use point_lists::{PointList, point_list_of, read_fence_points, read_rally_points};
use text::{text_of, too_many};

/// Reads a plan of any known format, told apart by its content.
///
/// `file_name` serves the message alone, when the content is of no known kind. What had to be assumed or left out
/// stands in the notes: heights keep what they count from, and where a file does not say it, that is said.
///
/// # Errors
/// [`FlightError::BadFile`] when the file is too large, empty, not UTF-8 or of no known format, else as
/// [`read_plan_json`] and [`read_waypoints`], whose faults name the place.
pub fn read_plan(bytes: &[u8], file_name: Option<&str>) -> Result<PlanFile> {
    let mut notes = Notes::default();
    let (plan, format) = match content_of(bytes)? {
        Content::Json(value) if geojson::is_geojson(&value) => {
            (geojson::read_geojson(&value, &mut notes)?, PlanFormat::GeoJson)
        }
        Content::Json(value) => {
            let is_named_geojson = file_name.and_then(PlanFormat::of_name) == Some(PlanFormat::GeoJson);
            if is_named_geojson && value.get("fileType").is_none() {
                let problem = "it is JSON without the \"type\" that GeoJSON begins with, such as FeatureCollection";
                return Err(unknown(file_name, problem));
            }
            return read_plan_value(&value);
        }
        Content::Xml { root, is_zipped } => match root.name.as_str() {
            "kml" | "Document" => {
                let format = if is_zipped { PlanFormat::Kmz } else { PlanFormat::Kml };
                (kml::read_kml(&root, &mut notes)?, format)
            }
            "gpx" => (gpx::read_gpx(&root, &mut notes)?, PlanFormat::Gpx),
            other => return Err(unknown(file_name, &format!("it is XML of another kind (<{}>)", text::shown(other)))),
        },
        Content::Text(text) if is_waypoints(text) => return read_waypoints(bytes),
        Content::Text(text) => match point_list_of(text) {
            Some(PointList::Fence) => (Plan { fence: read_fence_points(text)?, ..Plan::default() }, PlanFormat::Points),
            Some(PointList::Rally) => {
                (Plan { rally: read_rally_points(text, &mut notes)?, ..Plan::default() }, PlanFormat::Points)
            }
            None if table::is_table(text) || file_name.and_then(PlanFormat::of_name) == Some(PlanFormat::Csv) => {
                (table::read_table(text, &mut notes)?, PlanFormat::Csv)
            }
            None if text.trim_start().starts_with('[') => {
                return Err(unknown(file_name, "it is a JSON list, a plan is a JSON object"));
            }
            None => {
                return Err(unknown(
                    file_name,
                    "it begins with neither \"{\" nor \"QGC WPL 110\", nor with a row that names the columns lat and lon",
                ));
            }
        },
    };
    Ok(PlanFile { plan, settings: PlanSettings::default(), format, notes: notes.into_vec() })
}

/// Kind of content, by its first bytes.
enum Content<'a> {
    Json(serde_json::Value),
    Xml { root: xml::Element, is_zipped: bool },
    Text(&'a str),
}

fn content_of(bytes: &[u8]) -> Result<Content<'_>> {
    let is_zipped = bytes.starts_with(b"PK\x03\x04");
    if is_zipped && bytes.len() > MAX_FILE_BYTES {
        text_of(bytes)?;
    }
    let unpacked = if is_zipped { Some(kml::kml_of_kmz(bytes)?) } else { None };
    let inner = unpacked.as_deref().unwrap_or(bytes);
    let start = inner.strip_prefix(b"\xEF\xBB\xBF").unwrap_or(inner).trim_ascii_start();
    if is_zipped || (start.starts_with(b"<") && !inner.contains(&0)) {
        let root = xml::Element::parse(inner).map_err(|problem| {
            let todo = if problem.starts_with(xml::TOO_LARGE) { "split it" } else { "save it again" };
            FlightError::BadFile(format!("the file cannot be read: {problem}; {todo}"))
        })?;
        return Ok(Content::Xml { root, is_zipped });
    }
    let text = text_of(bytes)?;
    if text.trim_start().starts_with('{') { json::parse(text).map(Content::Json) } else { Ok(Content::Text(text)) }
}

fn is_waypoints(text: &str) -> bool {
    text.trim_start().get(..7).is_some_and(|word| word.eq_ignore_ascii_case("QGC WPL"))
}

fn unknown(file_name: Option<&str>, found: &str) -> FlightError {
    let name = file_name.unwrap_or("the file");
    FlightError::BadFile(format!(
        "{name} cannot be read as a plan: {found}. Save it as .plan (QGroundControl), .waypoints (Mission Planner), .kml, .kmz, .geojson, .gpx or .csv"
    ))
}

/// Writes a plan in a format; the notes say what the file does not keep as it is.
///
/// A `.waypoints` file holds the mission, of a plan without one its fence, else its rally points.
///
/// # Errors
/// [`FlightError::BadFile`] for a plan of which the format could hold nothing, or only one of two parts, or (GeoJSON,
/// beyond some 6,000 items) more than is read, or (rows) what another list would have, [`FlightError::BadRally`] as
/// [`write_plan_json`]; [`FlightError::BadFile`] too for [`PlanFormat::Points`], which is not written. A plan that
/// could not be sent to a vehicle is refused with the error of sending, because no reader would accept it.
pub fn write_plan(plan: &Plan, settings: &PlanSettings, format: PlanFormat) -> Result<WrittenPlan> {
    plan.mission.home.map_or(Ok(()), |home| home.point().map(drop))?;
    for kind in PlanKind::ALL {
        let (items, _) = plan.clone().into_list(kind)?;
        if let Some(problem) = too_many(items.len()) {
            return Err(FlightError::BadFile(format!("the {kind} {problem}")));
        }
        for (index, item) in items.iter().enumerate() {
            item.check_sendable(MissionSeq(index as u16 + 1))?;
        }
    }
    let mut notes = Notes::default();
    let text = match format {
        PlanFormat::QgcPlan => {
            notes.add(NoteCode::ComplexItemsEdited, edited_complex_items(plan, settings)?.len());
            write_plan_json(plan, settings)?
        }
        PlanFormat::Waypoints => {
            if !plan.mission.items.is_empty() {
                let back = usize::from(plan.fence.return_point.is_some());
                notes.add(NoteCode::FenceNotWritten, plan.fence.zones.len() + back);
                notes.add(NoteCode::RallyNotWritten, plan.rally.points.len());
            }
            write_waypoints(plan)?
        }
        PlanFormat::Kml | PlanFormat::Kmz => kml::write_kml(plan, &mut notes),
        PlanFormat::GeoJson => {
            let text = geojson::write_geojson(plan, &mut notes);
            // everything written can be read
            json::check_size(&text)?;
            text
        }
        PlanFormat::Gpx => gpx::write_gpx(plan, &mut notes)?,
        PlanFormat::Csv => {
            waypoints::check_lists(&plan.mission)?;
            table::write_table(plan)
        }
        PlanFormat::Points => {
            return Err(FlightError::BadFile(
                "lists of points are read, not written; save the plan as .waypoints or .plan".into(),
            ));
        }
    };
    if format != PlanFormat::QgcPlan && *settings != PlanSettings::default() {
        notes.add(NoteCode::SettingsNotWritten, 1);
    }
    let bytes = if format == PlanFormat::Kmz { kml::kmz_of_kml(&text) } else { text.into_bytes() };
    Ok(WrittenPlan { bytes, notes: notes.into_vec() })
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
    fn what_nothing_could_read_is_not_written() {
        use crate::geodesy::GeoPoint;
        use crate::plan::{Fence, FenceShape, FenceZone, Home, MavFrame, Mission, MissionItem, Rally, RallyPoint};
        let home = |lat_deg, alt_amsl_m| Plan {
            mission: Mission { home: Some(Home { lat_deg, lon_deg: -3.0, alt_amsl_m }), items: Vec::new() },
            ..Plan::default()
        };
        let items = |items| Plan::from_mission(Mission { home: None, items });
        let corner = GeoPoint::new(40.0, -3.0).unwrap();
        let line = FenceZone { inclusion: true, shape: FenceShape::Polygon { vertices: vec![corner; 2] } };
        let high = RallyPoint { point: corner, alt_m: 1e308, frame: MavFrame::GlobalRelativeAlt };
        let cases = [
            (home(f64::NAN, 600.0), "latitude NaN"),
            (home(91.0, 600.0), "latitude 91"),
            (home(40.0, 1e308), "home lies 1e308 m above the sea"),
            (
                items(vec![MissionItem::waypoint(40.0, -3.0, 80.0), MissionItem::waypoint(40.0, -3.0, 1e308)]),
                "item 2 (NAV_WAYPOINT): z is 1e308",
            ),
            (items(vec![MissionItem::return_to_launch(); 10_001]), "at most 10000"),
            (Plan { fence: Fence { zones: vec![line], return_point: None }, ..Plan::default() }, "at least 3 corners"),
            (Plan { rally: Rally { points: vec![high] }, ..Plan::default() }, "z is 1e308"),
        ];
        for (plan, expected) in cases {
            for format in PlanFormat::WRITTEN {
                let error = write_plan(&plan, &PlanSettings::default(), format).unwrap_err().to_string();
                assert!(error.contains(expected), "{format:?}: {error}");
            }
        }
    }

    #[test]
    fn what_is_no_plan_is_refused_with_a_way_out() {
        let utf16: Vec<u8> = "QGC WPL 110".encode_utf16().flat_map(u16::to_le_bytes).collect();
        let large = vec![b' '; MAX_FILE_BYTES + 1];
        let points = format!("<gpx><trk><trkseg>{}</trkseg></trk></gpx>", "<trkpt lat='1' lon='2'/>".repeat(100_001));
        let cases: [(&[u8], &str); 11] = [
            (points.as_bytes(), "more than 200000 attributes; split it"),
            (b"{\"version\": 1e400}", "number out of range at line 1 column 17); correct it"),
            (b"{\"version\": 1", "cut short"),
            (b"", "empty"),
            (b" \r\n\t", "empty"),
            (&utf16, "UTF-16"),
            (b"\xFF\xFEQ\0", "UTF-16"),
            (b"QGC WPL 110 \xC3\x28", "not UTF-8 text from byte 12"),
            (&large, "split it"),
            (b"<kml/>", "no point, line or area"),
            (b"hello", "hello.txt cannot be read as a plan"),
        ];
        let error = read_plan(b"{}", Some("map.geojson")).unwrap_err().to_string();
        assert!(
            error.contains("map.geojson cannot be read as a plan") && error.contains("FeatureCollection"),
            "{error}"
        );
        for (bytes, expected) in cases {
            let error = read_plan(bytes, Some("hello.txt")).unwrap_err().to_string();
            assert!(error.contains(expected), "{error}");
        }
    }
}

#[cfg(test)]
#[path = "exchange_tests.rs"]
mod exchange_tests;
