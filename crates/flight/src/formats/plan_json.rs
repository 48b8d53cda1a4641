//! `.plan`: the JSON of QGroundControl, plan version 1 (mission 2, geofence and rally points 1 and 2), and its
//! `.mission` of 2016, which is a mission alone.
//!
//! Simple items are kept as they are. Complex items become the simple items that QGroundControl itself would upload:
//! surveys and corridors carry them in the file, landing patterns are expanded here. Of a structure scan, and of a
//! survey of before 2018, the file has nothing that could be flown: it becomes one item that every vehicle refuses.
//! Whatever they become, complex items are kept beside the mission ([`ComplexItem`]), and written again where their
//! items still are. Until 2017 an item had its place in a member of its own, until 2016 its parameters too; its own ids
//! were called `id`. Format: <https://docs.qgroundcontrol.com/master/en/qgc-dev-guide/file_formats/plan.html>.

use std::collections::HashMap;

use serde::Serialize;
use serde_json::{Value, json};
use vencejo_proto::MissionSeq;

use crate::error::{FlightError, Plain, Result};
use crate::formats::json::{Node, ROOT, check_size, join, parse, plain};
use crate::formats::notes::{NoteCode, Notes};
use crate::formats::plan_file::{ComplexItem, PlanFile, PlanFormat, PlanSettings, PlannedFor};
use crate::formats::text::{shown, text_of, too_many};
use crate::geodesy::GeoPoint;
use crate::plan::{
    Command, Fence, FenceShape, FenceZone, Home, MavFrame, Mission, MissionItem, Plan, Rally, RallyPoint,
};

/// QGroundControl's "AltitudeMode": what the height of an item is counted from.
const ALTITUDE_RELATIVE: u8 = 1;
const ALTITUDE_ABSOLUTE: u8 = 2;
const ALTITUDE_TERRAIN_FRAME: u8 = 4;

/// `MAV_AUTOPILOT` and `MAV_TYPE` to write when the plan does not say.
const DEFAULT_FIRMWARE: u8 = 3;
const DEFAULT_VEHICLE: u8 = 1;
/// Speeds to write when the plan does not say, metres per second: QGroundControl insists on a number.
const DEFAULT_CRUISE_M_S: f64 = 15.0;
const DEFAULT_HOVER_M_S: f64 = 5.0;

/// Version of the mission files of 2016.
const MISSION_OF_2016: &str = "1.0";

/// Placeholder for a complex item whose items only QGroundControl can compute: `MAV_CMD_USER_1`, which ArduPlane
/// refuses, so that such a mission is not sent. Parameter 1 tells one from another.
const ELSEWHERE: Command = Command(31_010);

/// Where a survey or corridor has its own items.
const ITEMS: &str = "/TransectStyleComplexItem/Items";

/// Most complex items of a plan: each is looked for among all its items.
const MAX_COMPLEX_ITEMS: usize = 1_000;

/// What to do about items that only QGroundControl can work out.
const ITEMS_ELSEWHERE: &str = "its items are not in the file; send the plan from QGroundControl to a vehicle or a simulator, read it back there and save that";

/// Reads a plan.
///
/// `DO_JUMP` targets, which the file gives as `doJumpId`, become the seq of the item that they mean. One that no item
/// has stays as it is where it could not be taken for another item's seq.
///
/// # Errors
/// [`FlightError::BadJson`] with the JSON path, [`FlightError::BadFile`] when it is not a text file.
pub fn read_plan_json(bytes: &[u8]) -> Result<PlanFile> {
    read_plan_value(&parse(text_of(bytes)?)?)
}

/// Reads a plan that is JSON already.
pub(super) fn read_plan_value(value: &Value) -> Result<PlanFile> {
    let root = Node { value, path: ROOT.into() };
    let mission_node = match root.member("fileType")? {
        // before plans there were missions
        None if root.member("items")?.is_some() => root.clone(),
        _ => {
            let file_type = root.required("fileType")?;
            if file_type.text()? != "Plan" {
                return Err(file_type.bad(format!(
                    "is \"{}\"; only files of type \"Plan\" hold a plan, choose another",
                    shown(file_type.text()?)
                )));
            }
            root.expect_version(1)?;
            root.required("mission")?
        }
    };
    let version = mission_node.required("version")?;
    if version.value.as_str() != Some(MISSION_OF_2016) {
        mission_node.expect_version(2)?;
    }
    let small = |key: &str| -> Result<Option<u8>> {
        mission_node.member(key)?.map(|node| node.whole(255).map(|value| value as u8)).transpose()
    };
    let speed = |key: &str| -> Result<Option<f64>> {
        let Some(node) = mission_node.member(key)? else { return Ok(None) };
        match node.number()? {
            value if is_speed(value) => Ok(Some(value)),
            _ => Err(node.wrong_kind("a speed from 0 to 1000 m/s")),
        }
    };
    let mut notes = Notes::default();
    let (mission, complex_items) = read_mission(&mission_node, &mut notes)?;
    let planned_for = PlannedFor {
        cruise_speed_m_s: speed("cruiseSpeed")?,
        hover_speed_m_s: speed("hoverSpeed")?,
        vehicle_type: small("vehicleType")?,
        firmware_type: small("firmwareType")?.or(small("MAV_AUTOPILOT")?),
    };
    let settings = PlanSettings { planned_for, complex_items };
    let plan = Plan {
        mission,
        fence: root.member("geoFence")?.map_or(Ok(Fence::default()), |node| read_fence(&node))?,
        rally: root.member("rallyPoints")?.map_or(Ok(Rally::default()), |node| read_rally(&node))?,
    };
    Ok(PlanFile { plan, settings, format: PlanFormat::QgcPlan, notes: notes.into_vec() })
}

/// Items while they are gathered, with what `DO_JUMP` needs.
#[derive(Default)]
struct Items {
    items: Vec<MissionItem>,
    /// `doJumpId` → seq; `None` when two items claim it.
    seq_of_id: HashMap<u32, Option<usize>>,
    /// Places of `DO_JUMP` items in `items`, with their JSON path.
    jumps: Vec<(usize, String)>,
    complex: Vec<ComplexItem>,
    /// How many complex items have a placeholder.
    elsewhere: usize,
}

fn read_mission(node: &Node<'_>, notes: &mut Notes) -> Result<(Mission, Vec<ComplexItem>)> {
    if let Some(complex) = node.member("complexItems")?
        && complex.list()?.len() > 0
    {
        return Err(complex.bad(format!("holds surveys; {ITEMS_ELSEWHERE}")));
    }
    let home = match node.member("plannedHomePosition")? {
        // an item with its coordinate, in 2016
        Some(home) if home.value.is_object() => Some(home.required("coordinate")?),
        home => home,
    };
    let home = match home {
        None => None,
        // QGroundControl did not know where it was
        Some(home) if home.list()?.any(|part| part.value.is_null()) => None,
        Some(home) => match home.coordinate()? {
            (point, Some(alt_amsl_m)) if (point.lat_deg(), point.lon_deg()) != (0.0, 0.0) => {
                let at = Home { lat_deg: point.lat_deg(), lon_deg: point.lon_deg(), alt_amsl_m };
                at.point().map_err(|error| home.bad(error.to_string()))?;
                Some(at)
            }
            _ => None,
        },
    };
    let mut found = Items::default();
    read_items(&node.required("items")?, &mut found)?;
    let Items { mut items, seq_of_id, jumps, complex, elsewhere } = found;
    notes.add(NoteCode::ItemsElsewhere, elsewhere);
    let items_there = 1.0..=items.len() as f64;
    for (place, path) in jumps {
        let Some(target) = items[place].params[0].as_mut() else { continue };
        // A list without ids (written by hand) means seq numbers.
        if seq_of_id.is_empty() {
            continue;
        }
        let id = if target.fract() == 0.0 && *target >= 0.0 { *target as u32 } else { u32::MAX };
        match seq_of_id.get(&id) {
            Some(Some(seq)) => *target = *seq as f64,
            Some(None) => {
                return Err(FlightError::BadJson {
                    path,
                    problem: format!("jumps to doJumpId {id}, which two items have; give each its own"),
                });
            }
            // Nor is it the seq of another item: it stays a jump to a missing item, which the checks report. A plan is
            // saved while it is being edited, too.
            None if target.fract() != 0.0 || !items_there.contains(target) => {}
            None => {
                return Err(FlightError::BadJson {
                    path,
                    problem: format!("jumps to doJumpId {target}, which no item has; choose an item of this plan"),
                });
            }
        }
    }
    Ok((Mission { home, items }, complex))
}

fn read_items(list: &Node<'_>, found: &mut Items) -> Result<()> {
    for node in list.list()? {
        let kind = node.required("type")?;
        match kind.text()? {
            "SimpleItem" | "missionItem" => read_simple(&node, found)?,
            "ComplexItem" => read_complex(&node, found)?,
            other => {
                return Err(
                    kind.bad(format!("is \"{}\"; items are of type \"SimpleItem\" or \"ComplexItem\"", shown(other)))
                );
            }
        }
        if let Some(problem) = too_many(found.items.len()) {
            return Err(list.bad(problem));
        }
    }
    Ok(())
}

fn read_simple(node: &Node<'_>, found: &mut Items) -> Result<()> {
    let command = Command(node.required("command")?.whole(u32::from(u16::MAX))? as u16);
    let frame = MavFrame::from(node.required("frame")?.whole(255)? as u8);
    let (list, values) = seven_params(node)?;
    let mut params = [None; 7];
    for (param, value) in params.iter_mut().zip(values) {
        *param = if value.value.is_null() { None } else { Some(value.number()?) };
    }
    let item = MissionItem { command, frame, params, autocontinue: node.flag_or("autoContinue", true)? };
    if let Err(error) = item.check_sendable(MissionSeq(0)) {
        let problem = match error {
            FlightError::BadItem { field, value, problem, .. } => {
                format!("({command}) has {} as its {field}, {problem}", Plain(value))
            }
            other => other.to_string(),
        };
        return Err(node.bad(problem));
    }
    // item 0 on the wire is home
    let seq = found.items.len() + 1;
    if let Some(id) = node.member("doJumpId")?.map_or_else(|| node.member("id"), |id| Ok(Some(id)))? {
        let id = id.whole(u32::MAX)?;
        found.seq_of_id.entry(id).and_modify(|seq| *seq = None).or_insert(Some(seq));
    }
    if command == Command::DO_JUMP {
        found.jumps.push((found.items.len(), list));
    }
    found.items.push(item);
    Ok(())
}

/// The parameters of an item and where they stand: a list of 7, or 4 with the place apart, each on its own in 2016.
fn seven_params<'a>(node: &Node<'a>) -> Result<(String, Vec<Node<'a>>)> {
    let (path, mut values) = match node.member("params")? {
        None if node.member("param1")?.is_some() => {
            let values = ["param1", "param2", "param3", "param4"].map(|key| node.required(key));
            (join(&node.path, "param1"), values.into_iter().collect::<Result<Vec<_>>>()?)
        }
        _ => {
            let list = node.required("params")?;
            let values = list.list()?.collect();
            (list.path, values)
        }
    };
    if values.len() == 4
        && let Some(coordinate) = node.member("coordinate")?
    {
        values.extend(coordinate.list()?);
    }
    if values.len() == 7 {
        return Ok((path, values));
    }
    let problem = format!("has {} values; an item has 7 parameters, null where unset", values.len());
    Err(FlightError::BadJson { path, problem })
}

fn read_complex(node: &Node<'_>, found: &mut Items) -> Result<()> {
    let kind = node.required("complexItemType")?;
    let name = kind.text()?;
    let known = found.complex.len();
    match name {
        "fwLandingPattern" => read_landing(node, Command::NAV_LAND, found)?,
        "vtolLandingPattern" => read_landing(node, Command::NAV_VTOL_LAND, found)?,
        _ => {
            let transects = node.member("TransectStyleComplexItem")?;
            match transects.map_or(Ok(None), |transects| transects.member("Items"))? {
                Some(items) if items.list()?.len() > 0 => read_items(&items, found)?,
                _ => {
                    found.items.push(MissionItem::action(ELSEWHERE, [f64::from(digest(node.value)), 0.0, 0.0, 0.0]));
                    found.elsewhere += 1;
                }
            }
        }
    }
    // A complex item inside of another is kept with it.
    found.complex.truncate(known);
    if known >= MAX_COMPLEX_ITEMS {
        return Err(node.bad(format!("is one of more than {MAX_COMPLEX_ITEMS} complex items; split the plan")));
    }
    found.complex.push(ComplexItem { kind: name.to_owned(), json: node.value.to_string() });
    Ok(())
}

/// A number of 24 bits, which a float holds, by which one value can be told from another (FNV-1a of its text, folded).
fn digest(value: &Value) -> u32 {
    let hash = value
        .to_string()
        .bytes()
        .fold(0x811c_9dc5_u32, |hash, byte| (hash ^ u32::from(byte)).wrapping_mul(0x0100_0193));
    (hash >> 24) ^ (hash & 0x00ff_ffff)
}

/// Where complex items go when a mission is written.
struct Placed<'a> {
    /// Index of the first item that it stands for, how many these are, and it.
    at: Vec<(usize, usize, Value)>,
    /// Those whose items are no longer in the mission as they made them.
    edited: Vec<&'a ComplexItem>,
    /// All of them, in the order in which they were given.
    parts: Vec<ComplexPart>,
}

/// Where the items of a complex item are in a mission.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ComplexPart {
    /// Index of the first; `None` when they are no longer there as it made them.
    pub first: Option<usize>,
    /// How many items it made.
    pub count: usize,
}

/// Looks for the items of complex items in a mission: together, in their order, as they were made, and no jump leads
/// among them.
fn placed<'a>(items: &[MissionItem], complex_items: &'a [ComplexItem]) -> Result<Placed<'a>> {
    let targets: Vec<f64> =
        items.iter().filter(|item| item.command == Command::DO_JUMP).filter_map(|item| item.param(1)).collect();
    if complex_items.len() > MAX_COMPLEX_ITEMS {
        let problem = format!("are {}; at most {MAX_COMPLEX_ITEMS} are taken, so split the plan", complex_items.len());
        return Err(FlightError::BadJson { path: "complex items".into(), problem });
    }
    let mut placed = Placed { at: Vec::new(), edited: Vec::new(), parts: Vec::new() };
    for complex in complex_items {
        check_size(&complex.json)?;
        let value: Value = serde_json::from_str(&complex.json).map_err(|error| FlightError::BadJson {
            path: "complex item".into(),
            problem: format!("is not JSON ({error}); give it as it was read"),
        })?;
        let mut made = Items::default();
        read_complex(&Node { value: &value, path: "complex item".into() }, &mut made)?;
        let count = made.items.len();
        let is_free = |first: usize| placed.at.iter().all(|(at, taken, _)| first + count <= *at || at + taken <= first);
        // Its own items have numbers that a jump can name, those of a landing pattern have no numbers.
        let has_numbers = value.pointer(ITEMS).is_some();
        let is_led_into = |first: usize| {
            let seqs = (first + 1) as f64..=(first + count) as f64;
            !has_numbers && targets.iter().any(|target| seqs.contains(target))
        };
        let first = (0..(items.len() + 1).saturating_sub(count))
            .find(|first| items[*first..*first + count] == made.items && is_free(*first) && !is_led_into(*first));
        match first {
            Some(first) => placed.at.push((first, count, numbered(value, first + 1))),
            None => placed.edited.push(complex),
        }
        placed.parts.push(ComplexPart { first, count });
    }
    placed.at.sort_by_key(|(first, ..)| *first);
    Ok(placed)
}

/// A complex item whose own items have the numbers that they have in the mission.
fn numbered(mut value: Value, first_seq: usize) -> Value {
    let items = value.pointer_mut(ITEMS).and_then(Value::as_array_mut);
    for (index, item) in items.into_iter().flatten().enumerate() {
        if let Some(item) = item.as_object_mut() {
            item.insert("doJumpId".into(), json!(first_seq + index));
        }
    }
    value
}

/// Those complex items that [`write_plan_json`] will not write: their items were changed, and are written one by one.
///
/// # Errors
/// [`FlightError::BadJson`] for a value that is not a complex item.
pub fn edited_complex_items<'a>(plan: &Plan, settings: &'a PlanSettings) -> Result<Vec<&'a ComplexItem>> {
    Ok(placed(&plan.mission.items, &settings.complex_items)?.edited)
}

/// Where the items of each complex item are in the mission, in the order of the complex items.
///
/// # Errors
/// [`FlightError::BadJson`] for a value that is not a complex item.
pub fn complex_parts(plan: &Plan, settings: &PlanSettings) -> Result<Vec<ComplexPart>> {
    Ok(placed(&plan.mission.items, &settings.complex_items)?.parts)
}

/// A landing pattern as QGroundControl expands it: start of landing, speed, camera off, approach, landing.
fn read_landing(node: &Node<'_>, land: Command, found: &mut Items) -> Result<()> {
    let version = node.required("version")?;
    let relative = match (version.whole(u32::MAX)?, node.member("altitudesAreRelative")?) {
        // landing patterns of VTOLs are of version 1 and say it as those of version 2 do
        (1 | 2, Some(relative)) => relative.flag()?,
        (1, None) => {
            let loiter = node.required("loiterAltitudeRelative")?.flag()?;
            let landing = node.required("landAltitudeRelative")?.flag()?;
            if loiter != landing {
                return Err(node.bad(
                    "counts its approach height and its landing height from different levels; make both relative or both absolute",
                ));
            }
            loiter
        }
        (2, None) => node.required("altitudesAreRelative")?.flag()?,
        (other, _) => {
            return Err(version.bad(format!("is {other}; landing patterns of version 1 and 2 are read")));
        }
    };
    let frame = if relative { MavFrame::GlobalRelativeAlt } else { MavFrame::Global };
    let approach = match node.member("landingApproachCoordinate")? {
        Some(approach) => approach,
        None => node.required("loiterCoordinate")?,
    };
    let (approach_point, approach_alt_m) = approach.place()?;
    let (land_point, land_alt_m) = node.required("landCoordinate")?.place()?;

    found.items.push(MissionItem::action(Command::DO_LAND_START, [0.0; 4]));
    if node.flag_or("useDoChangeSpeed", false)? {
        let speed_m_s = node.required("finalApproachSpeed")?.number()?;
        found.items.push(MissionItem::action(Command::DO_CHANGE_SPEED, [0.0, speed_m_s, -1.0, 0.0]));
    }
    if node.flag_or("stopTakingPhotos", false)? {
        found.items.push(MissionItem::action(Command::DO_SET_CAM_TRIGG_DIST, [0.0; 4]));
        found.items.push(MissionItem::action(Command::IMAGE_STOP_CAPTURE, [0.0; 4]));
    }
    if node.flag_or("stopVideoPhotos", false)? {
        found.items.push(MissionItem::action(Command::VIDEO_STOP_CAPTURE, [0.0; 4]));
    }
    let (lat_deg, lon_deg) = (approach_point.lat_deg(), approach_point.lon_deg());
    let mut item = if node.flag_or("useLoiterToAlt", true)? {
        let radius_m = node.required("loiterRadius")?.number()?;
        let clockwise = node.flag_or("loiterClockwise", true)?;
        let signed_m = if clockwise { radius_m } else { -radius_m };
        let mut item = MissionItem::loiter_to_alt(lat_deg, lon_deg, approach_alt_m, signed_m);
        item.params[0] = Some(1.0); // leave when headed for the landing point
        item
    } else {
        let mut item = MissionItem::waypoint(lat_deg, lon_deg, approach_alt_m);
        item.params[3] = None;
        item
    };
    item.frame = frame;
    let mut landing = MissionItem::at(land, [0.0; 4], land_point.lat_deg(), land_point.lon_deg(), land_alt_m);
    landing.frame = frame;
    if land == Command::NAV_VTOL_LAND {
        landing.params[3] = None;
    }
    for item in [&item, &landing] {
        item.check_sendable(MissionSeq(0)).map_err(|error| node.bad(error.to_string()))?;
    }
    found.items.extend([item, landing]);
    Ok(())
}

fn read_fence(node: &Node<'_>) -> Result<Fence> {
    let mut fence = Fence::default();
    let polygons = node.member("polygons")?;
    let circles = node.member("circles")?;
    node.expect_version_if_any(1, 2)?;
    // one item is left for the return point
    let mut vertices_left = crate::plan::MAX_ITEMS - 1;
    let mut add = |node: &Node<'_>, inclusion: bool, shape: FenceShape, items: usize| {
        let zone = FenceZone { inclusion, shape };
        vertices_left = vertices_left
            .checked_sub(items)
            .ok_or_else(|| node.bad("makes the fence larger than can be read; simplify it"))?;
        let single = Fence { zones: vec![zone], return_point: None };
        single.validate().map_err(|error| match error {
            FlightError::BadFence { problem, .. } => node.bad(problem),
            other => other,
        })?;
        fence.zones.extend(single.zones);
        Ok::<_, FlightError>(())
    };
    let inclusion = |zone: &Node<'_>| zone.required("inclusion")?.flag();
    let corners =
        |list: &Node<'_>| list.list()?.map(|corner| Ok(corner.coordinate()?.0)).collect::<Result<Vec<GeoPoint>>>();
    // version 1 had one polygon, to stay inside
    if let Some(polygon) = node.member("polygon")? {
        let vertices = corners(&polygon)?;
        let count = vertices.len();
        if count > 0 {
            add(&polygon, true, FenceShape::Polygon { vertices }, count)?;
        }
    }
    if let Some(polygons) = polygons {
        for polygon in polygons.list()? {
            let vertices = corners(&polygon.required("polygon")?)?;
            let count = vertices.len();
            add(&polygon, inclusion(&polygon)?, FenceShape::Polygon { vertices }, count)?;
        }
    }
    if let Some(circles) = circles {
        for circle in circles.list()? {
            let shape = circle.required("circle")?;
            let center = shape.required("center")?.coordinate()?.0;
            let radius_m = shape.required("radius")?.number()?;
            add(&circle, inclusion(&circle)?, FenceShape::Circle { center, radius_m }, 1)?;
        }
    }
    if let Some(place) = node.member("breachReturn")? {
        let (point, alt_m) = place.coordinate()?;
        fence.return_point = Some((point, alt_m.unwrap_or(0.0)));
        fence.return_fault().map_or(Ok(()), |fault| Err(place.bad(fault)))?;
    }
    Ok(fence)
}

fn read_rally(node: &Node<'_>) -> Result<Rally> {
    node.expect_version_if_any(1, 2)?;
    let Some(list) = node.member("points")? else { return Ok(Rally::default()) };
    let list_items = list.list()?;
    if let Some(problem) = too_many(list_items.len()) {
        return Err(list.bad(problem));
    }
    let points = list_items
        .map(|place| {
            let (point, alt_m) = place.place()?;
            let point = RallyPoint { point, alt_m, frame: MavFrame::GlobalRelativeAlt };
            point.fault().map_or(Ok(point), |fault| Err(place.bad(fault)))
        })
        .collect::<Result<_>>()?;
    Ok(Rally { points })
}

/// Writes a plan, four spaces deep and keys in order, as QGroundControl does.
///
/// A complex item of the settings stands for its items where they are in the mission as it made them; where they were
/// changed they are written one by one ([`edited_complex_items`]).
///
/// # Errors
/// [`FlightError::BadJson`] for an invalid complex item, and for a speed that is not from 0 to 1000 m/s.
/// [`FlightError::BadRally`] for a rally point whose height is not above home: the format has no place for
/// what the height is counted from.
pub fn write_plan_json(plan: &Plan, settings: &PlanSettings) -> Result<String> {
    if let Some(index) = plan.rally.points.iter().position(|rally| rally.frame != MavFrame::GlobalRelativeAlt) {
        return Err(FlightError::BadRally {
            index,
            problem: "has a height that is not above home, which a .plan file cannot say; convert it".into(),
        });
    }
    let PlannedFor { cruise_speed_m_s, hover_speed_m_s, vehicle_type, firmware_type } = settings.planned_for;
    for (path, speed_m_s) in [("mission.cruiseSpeed", cruise_speed_m_s), ("mission.hoverSpeed", hover_speed_m_s)] {
        if let Some(speed_m_s) = speed_m_s.filter(|speed_m_s| !is_speed(*speed_m_s)) {
            let problem = format!("is {speed_m_s} m/s; give a speed from 0 to 1000 m/s");
            return Err(FlightError::BadJson { path: path.into(), problem });
        }
    }
    let home = plan.mission.home.unwrap_or(Home { lat_deg: 0.0, lon_deg: 0.0, alt_amsl_m: 0.0 });
    let mut items = Vec::with_capacity(plan.mission.items.len());
    let mut next = 0;
    let simple = |range: std::ops::Range<usize>| {
        let list = &plan.mission.items;
        range.map(|index| write_item(index + 1, &list[index])).collect::<Vec<_>>()
    };
    for (first, count, value) in placed(&plan.mission.items, &settings.complex_items)?.at {
        items.extend(simple(next..first));
        items.push(value);
        next = first + count;
    }
    items.extend(simple(next..plan.mission.items.len()));
    let value = json!({
        "fileType": "Plan",
        "version": 1,
        "groundStation": "Vencejo",
        "geoFence": write_fence(&plan.fence),
        "mission": {
            "version": 2,
            "cruiseSpeed": plain(cruise_speed_m_s.unwrap_or(DEFAULT_CRUISE_M_S)),
            "hoverSpeed": plain(hover_speed_m_s.unwrap_or(DEFAULT_HOVER_M_S)),
            "firmwareType": firmware_type.unwrap_or(DEFAULT_FIRMWARE),
            "vehicleType": vehicle_type.unwrap_or(DEFAULT_VEHICLE),
            "plannedHomePosition": [plain(home.lat_deg), plain(home.lon_deg), plain(home.alt_amsl_m)],
            "items": items,
        },
        "rallyPoints": {
            "version": 2,
            "points": plan.rally.points.iter().map(|rally| place(rally.point, rally.alt_m)).collect::<Vec<_>>(),
        },
    });
    let mut text = Vec::new();
    let formatter = serde_json::ser::PrettyFormatter::with_indent(b"    ");
    value
        .serialize(&mut serde_json::Serializer::with_formatter(&mut text, formatter))
        .expect("invariant: a JSON value is written to memory without error");
    text.push(b'\n');
    Ok(String::from_utf8(text).expect("invariant: JSON is UTF-8"))
}

fn is_speed(value_m_s: f64) -> bool {
    (0.0..1_000.0).contains(&value_m_s)
}

fn place(point: GeoPoint, alt_m: f64) -> Value {
    json!([plain(point.lat_deg()), plain(point.lon_deg()), plain(alt_m)])
}

pub(super) fn write_item(seq: usize, item: &MissionItem) -> Value {
    let mut value = json!({
        "type": "SimpleItem",
        "command": item.command.0,
        "frame": item.frame.number(),
        "params": item.params.map(|param| param.map_or(Value::Null, plain)),
        "autoContinue": item.autocontinue,
        "doJumpId": seq,
    });
    let mode = match item.frame {
        MavFrame::GlobalRelativeAlt => Some(ALTITUDE_RELATIVE),
        MavFrame::Global => Some(ALTITUDE_ABSOLUTE),
        MavFrame::GlobalTerrainAlt => Some(ALTITUDE_TERRAIN_FRAME),
        MavFrame::Mission | MavFrame::Other(_) => None,
    };
    if let (Some(mode), Some(alt_m)) = (mode, item.alt_m()) {
        value["AltitudeMode"] = json!(mode);
        value["Altitude"] = plain(alt_m);
        value["AMSLAltAboveTerrain"] = Value::Null;
    }
    value
}

fn write_fence(fence: &Fence) -> Value {
    let (mut polygons, mut circles) = (Vec::new(), Vec::new());
    for zone in &fence.zones {
        match &zone.shape {
            FenceShape::Polygon { vertices } => polygons.push(json!({
                "version": 1,
                "inclusion": zone.inclusion,
                "polygon": vertices.iter().map(|v| [plain(v.lat_deg()), plain(v.lon_deg())]).collect::<Vec<_>>(),
            })),
            FenceShape::Circle { center, radius_m } => circles.push(json!({
                "version": 1,
                "inclusion": zone.inclusion,
                "circle": { "center": [plain(center.lat_deg()), plain(center.lon_deg())], "radius": plain(*radius_m) },
            })),
        }
    }
    let mut value = json!({ "version": 2, "polygons": polygons, "circles": circles });
    if let Some((point, alt_m)) = fence.return_point {
        value["breachReturn"] = place(point, alt_m);
    }
    value
}

#[cfg(test)]
#[path = "plan_json_tests.rs"]
mod tests;
