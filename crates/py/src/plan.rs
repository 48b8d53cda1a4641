//! Plans between Python's plain tuples (see `vencejo.plan`) and `vencejo-flight`.

use std::borrow::Cow;
use std::collections::BTreeMap;

use pyo3::prelude::*;
use pyo3::types::PyBytes;
use vencejo_flight::checks::{CheckContext, Figure, Finding, Severity, check_plan as check};
use vencejo_flight::formats::{
    self, ComplexItem, Note, ParamDialect, ParamEntry, PlanFormat, PlanSettings, PlannedFor, read_params, write_params,
    write_plan,
};
use vencejo_flight::geodesy::GeoPoint;
use vencejo_flight::plan::{
    Command, Fence, FenceShape, FenceZone, Home, MavFrame, Mission, MissionItem, Plan, Rally, RallyPoint,
};
use vencejo_flight::progress::ProgressOptions;

use crate::{errors, runtime};

/// `(command, frame, seven parameters, autocontinue)`.
pub type ItemTuple = (u16, u8, [Option<f64>; 7], bool);
/// `(is inclusion, corners or the centre, radius of a circle)`.
type ZoneTuple = (bool, Vec<(f64, f64)>, Option<f64>);
/// `(home, items, fence zones, fence return point, rally points)`.
pub type PlanTuple =
    (Option<(f64, f64, f64)>, Vec<ItemTuple>, Vec<ZoneTuple>, Option<(f64, f64, f64)>, Vec<(f64, f64, f64, u8)>);
/// Settings of a plan file: `(cruise speed, hover speed, MAV_TYPE, MAV_AUTOPILOT, complex items by kind and JSON)`.
type SettingsTuple = (Option<f64>, Option<f64>, Option<u8>, Option<u8>, Vec<(String, String)>);

/// Adds the functions of this module.
pub fn register(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add("PLAN_ENDINGS", PlanFormat::WRITTEN.map(PlanFormat::ending))?;
    module.add_function(wrap_pyfunction!(command_name, module)?)?;
    module.add_function(wrap_pyfunction!(command_title, module)?)?;
    module.add_function(wrap_pyfunction!(command_number, module)?)?;
    module.add_function(wrap_pyfunction!(command_has_position, module)?)?;
    module.add_function(wrap_pyfunction!(command_is_nav, module)?)?;
    module.add_function(wrap_pyfunction!(parse_plan, module)?)?;
    module.add_function(wrap_pyfunction!(format_plan, module)?)?;
    module.add_function(wrap_pyfunction!(edited_complex_items, module)?)?;
    module.add_function(wrap_pyfunction!(complex_parts, module)?)?;
    module.add_function(wrap_pyfunction!(check_plan, module)?)?;
    module.add_function(wrap_pyfunction!(mission_length_m, module)?)?;
    module.add_function(wrap_pyfunction!(parse_params, module)?)?;
    module.add_function(wrap_pyfunction!(format_params, module)?)?;
    Ok(())
}

fn point(lat_deg: f64, lon_deg: f64) -> PyResult<GeoPoint> {
    GeoPoint::new(lat_deg, lon_deg).map_err(|error| errors::raise("InvalidRequest", error))
}

/// A home position from Python.
pub fn home_from_tuple((lat_deg, lon_deg, alt_amsl_m): (f64, f64, f64)) -> Home {
    Home { lat_deg, lon_deg, alt_amsl_m }
}

pub fn item_from_tuple((command, frame, params, autocontinue): ItemTuple) -> MissionItem {
    MissionItem { command: Command(command), frame: MavFrame::from(frame), params, autocontinue }
}

pub fn item_to_tuple(item: &MissionItem) -> ItemTuple {
    (item.command.0, item.frame.number(), item.params, item.autocontinue)
}

/// A plan from Python.
///
/// # Errors
/// `InvalidRequest` for a home, a fence or a rally point that is not a position on Earth.
pub fn plan_from_tuple((home, items, zones, return_point, rally): PlanTuple) -> PyResult<Plan> {
    let zones = zones
        .into_iter()
        .map(|(inclusion, corners, radius_m)| {
            let mut corners = corners.into_iter().map(|(lat, lon)| point(lat, lon)).collect::<PyResult<Vec<_>>>()?;
            let shape = match (radius_m, corners.len()) {
                (None, _) => FenceShape::Polygon { vertices: corners },
                (Some(radius_m), 1) => FenceShape::Circle { center: corners.remove(0), radius_m },
                (Some(_), count) => {
                    let message = format!("a fence circle has one centre, not {count}");
                    return Err(errors::raise("InvalidRequest", message));
                }
            };
            Ok(FenceZone { inclusion, shape })
        })
        .collect::<PyResult<Vec<_>>>()?;
    let return_point = return_point
        .map(|(lat, lon, alt_rel_home_m)| Ok::<_, PyErr>((point(lat, lon)?, alt_rel_home_m)))
        .transpose()?;
    let points = rally
        .into_iter()
        .map(|(lat, lon, alt_m, frame)| Ok(RallyPoint { point: point(lat, lon)?, alt_m, frame: MavFrame::from(frame) }))
        .collect::<PyResult<Vec<_>>>()?;
    let home = home.map(home_from_tuple);
    if let Some(Err(error)) = home.map(|home| home.point()) {
        return Err(errors::raise("InvalidRequest", format!("the plan's home: {error}")));
    }
    Ok(Plan {
        mission: Mission { home, items: items.into_iter().map(item_from_tuple).collect() },
        fence: Fence { zones, return_point },
        rally: Rally { points },
    })
}

/// A plan for Python.
pub fn plan_to_tuple(plan: &Plan) -> PlanTuple {
    let position = |point: &GeoPoint| (point.lat_deg(), point.lon_deg());
    let zones = plan
        .fence
        .zones
        .iter()
        .map(|zone| match &zone.shape {
            FenceShape::Polygon { vertices } => (zone.inclusion, vertices.iter().map(position).collect(), None),
            FenceShape::Circle { center, radius_m } => (zone.inclusion, vec![position(center)], Some(*radius_m)),
        })
        .collect();
    (
        plan.mission.home.map(|home| (home.lat_deg, home.lon_deg, home.alt_amsl_m)),
        plan.mission.items.iter().map(item_to_tuple).collect(),
        zones,
        plan.fence.return_point.map(|(point, alt_rel_home_m)| (point.lat_deg(), point.lon_deg(), alt_rel_home_m)),
        plan.rally
            .points
            .iter()
            .map(|rally| (rally.point.lat_deg(), rally.point.lon_deg(), rally.alt_m, rally.frame.number()))
            .collect(),
    )
}

/// The name of a MAV_CMD without its prefix, or `MAV_CMD 12345`.
#[pyfunction]
fn command_name(command: u16) -> String {
    Command(command).to_string()
}

/// The English title of a MAV_CMD; `None` for one that ArduPlane does not accept.
#[pyfunction]
fn command_title(command: u16) -> Option<&'static str> {
    Command(command).info().map(|info| info.title)
}

/// The number of a MAV_CMD by name, with or without its prefix.
#[pyfunction]
fn command_number(name: &str) -> Option<u16> {
    Command::from_name(name).map(|command| command.0)
}

/// Whether a MAV_CMD uses x, y, z as a position. Commands that are not known are taken to have one.
#[pyfunction]
fn command_has_position(command: u16) -> bool {
    Command(command).has_position().unwrap_or(true)
}

/// Whether the mission stands at an item with this MAV_CMD until it is done.
#[pyfunction]
fn command_is_nav(command: u16) -> bool {
    Command(command).is_nav()
}

/// A note of a reader or writer: code, how many it concerns, message.
type NoteTuple = (&'static str, usize, String);

fn notes(found: &[Note]) -> Vec<NoteTuple> {
    found.iter().map(|note| (note.code.as_str(), note.count, note.to_string())).collect()
}

/// Reads a plan file of any known kind.
#[pyfunction]
fn parse_plan(
    py: Python<'_>,
    data: &Bound<'_, PyBytes>,
    name: &str,
) -> PyResult<(PlanTuple, SettingsTuple, Vec<NoteTuple>)> {
    let data = data.as_bytes();
    let file = runtime::detached(py, || formats::read_plan(data, Some(name)))
        .map_err(|error| errors::raise("FileFormatError", error))?;
    let PlanSettings { planned_for, complex_items } = file.settings;
    let PlannedFor { cruise_speed_m_s, hover_speed_m_s, vehicle_type, firmware_type } = planned_for;
    let complex_items = complex_items.into_iter().map(|complex| (complex.kind, complex.json)).collect();
    let settings = (cruise_speed_m_s, hover_speed_m_s, vehicle_type, firmware_type, complex_items);
    Ok((plan_to_tuple(&file.plan), settings, notes(&file.notes)))
}

/// Writes a plan in the format that the ending of a name asks for; with what the file does not keep as it is.
#[pyfunction]
fn format_plan(plan: PlanTuple, settings: SettingsTuple, name: &str) -> PyResult<(Cow<'static, [u8]>, Vec<NoteTuple>)> {
    let settings = settings_from_tuple(settings);
    let format = PlanFormat::of_name(name).ok_or_else(|| {
        let endings: Vec<String> = PlanFormat::WRITTEN.iter().map(|format| format!(".{}", format.ending())).collect();
        let ending = name.rsplit_once('.').map_or("", |(_, ending)| ending);
        let message = format!("a plan is saved as {}, not as \".{ending}\"; rename it", endings.join(", "));
        errors::raise("FileFormatError", message)
    })?;
    let written = write_plan(&plan_from_tuple(plan)?, &settings, format)
        .map_err(|error| errors::raise("FileFormatError", error))?;
    Ok((written.bytes.into(), notes(&written.notes)))
}

/// Index of the first item of each complex item, none when they were edited, and how many it made.
#[pyfunction]
fn complex_parts(plan: PlanTuple, settings: SettingsTuple) -> PyResult<Vec<(Option<usize>, usize)>> {
    let parts = formats::complex_parts(&plan_from_tuple(plan)?, &settings_from_tuple(settings))
        .map_err(|error| errors::raise("FileFormatError", error))?;
    Ok(parts.iter().map(|part| (part.first, part.count)).collect())
}

/// Which of the complex items, by their place in the list, are no longer in the plan as they made it.
#[pyfunction]
fn edited_complex_items(plan: PlanTuple, settings: SettingsTuple) -> PyResult<Vec<usize>> {
    let settings = settings_from_tuple(settings);
    let edited = formats::edited_complex_items(&plan_from_tuple(plan)?, &settings)
        .map_err(|error| errors::raise("FileFormatError", error))?;
    let is_edited = |complex: &ComplexItem| edited.iter().any(|edited| std::ptr::eq(*edited, complex));
    let numbered = settings.complex_items.iter().enumerate();
    Ok(numbered.filter(|(_, complex)| is_edited(complex)).map(|(index, _)| index).collect())
}

fn settings_from_tuple(settings: SettingsTuple) -> PlanSettings {
    let (cruise_speed_m_s, hover_speed_m_s, vehicle_type, firmware_type, complex_items) = settings;
    let complex_items = complex_items.into_iter().map(|(kind, json)| ComplexItem { kind, json }).collect();
    let planned_for = PlannedFor { cruise_speed_m_s, hover_speed_m_s, vehicle_type, firmware_type };
    PlanSettings { planned_for, complex_items }
}

/// A finding, by the names of `vencejo.findings.Finding`.
#[derive(IntoPyObject)]
pub struct FindingFields {
    severity: &'static str,
    code: &'static str,
    item: Option<usize>,
    message: String,
    remedy: String,
    figures: Figures,
}

/// Figures by name.
pub type Figures = BTreeMap<&'static str, Option<FigureValue>>;

/// A figure of a finding; one that is absent is `None`.
#[derive(IntoPyObject)]
pub enum FigureValue {
    Flag(bool),
    Count(usize),
    Number(f64),
    Word(&'static str),
}

fn figure_value(figure: Figure) -> Option<FigureValue> {
    match figure {
        Figure::Absent => None,
        Figure::Flag(flag) => Some(FigureValue::Flag(flag)),
        Figure::Count(count) => Some(FigureValue::Count(count)),
        Figure::Number(number) => Some(FigureValue::Number(number)),
        Figure::Word(word) => Some(FigureValue::Word(word)),
    }
}

/// Looks for what would make a plan fail.
#[pyfunction]
fn check_plan(
    plan: PlanTuple,
    position: Option<(f64, f64)>,
    on_ground: Option<bool>,
    parameters: BTreeMap<String, f64>,
) -> PyResult<Vec<FindingFields>> {
    let plan = plan_from_tuple(plan)?;
    let position = position.map(|(lat, lon)| point(lat, lon)).transpose()?;
    let context = CheckContext { position, on_ground, ..CheckContext::of(&parameters) };
    Ok(findings(check(&plan, &context)))
}

/// Figures for Python.
pub fn figures(named: Vec<(&'static str, Figure)>) -> Figures {
    named.into_iter().map(|(name, figure)| (name, figure_value(figure))).collect()
}

/// Findings for Python.
pub fn findings(found: Vec<Finding>) -> Vec<FindingFields> {
    found
        .into_iter()
        .map(|finding| FindingFields {
            severity: if finding.severity == Severity::Error { "error" } else { "warning" },
            code: finding.code().as_str(),
            item: finding.item,
            figures: figures(finding.kind.figures()),
            message: finding.message,
            remedy: finding.remedy,
        })
        .collect()
}

/// Length of a mission's way, circles included; `None` when it has no end or no place.
#[pyfunction]
fn mission_length_m(plan: PlanTuple) -> PyResult<Option<f64>> {
    let mission = plan_from_tuple(plan)?.mission;
    Ok(vencejo_flight::progress::trip(&mission, None, &ProgressOptions::default()).distance_m)
}

/// Reads a parameter file of any known kind.
#[pyfunction]
fn parse_params(data: &[u8]) -> PyResult<Vec<(String, f64)>> {
    let entries = read_params(data).map_err(|error| errors::raise("FileFormatError", error))?;
    Ok(entries.into_iter().map(|entry| (entry.name, entry.value)).collect())
}

/// Writes a parameter file.
#[pyfunction]
fn format_params(params: Vec<(String, f64)>) -> PyResult<String> {
    let entries: Vec<_> =
        params.into_iter().map(|(name, value)| ParamEntry { name, value, mav_param_type: None }).collect();
    let text = write_params(&entries, ParamDialect::MissionPlanner);
    // A name or a value that a file cannot hold is found while it is still known.
    read_params(text.as_bytes()).map_err(|error| errors::raise("InvalidRequest", error))?;
    Ok(text)
}
