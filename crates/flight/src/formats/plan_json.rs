//! `.plan`: the JSON of QGroundControl, plan version 1 (mission 2, geofence and rally points 1 and 2), and its `.mission` of 2016,
//! which is a mission alone.
//!
//! Simple items are kept as they are. Complex items become the simple items that QGroundControl itself
//! would upload: surveys and corridors carry them in the file, landing patterns are expanded here.
//! Until 2017 an item had its place in a member of its own, until 2016 its parameters too; its own ids were called `id`.
//! Format: <https://docs.qgroundcontrol.com/master/en/qgc-dev-guide/file_formats/plan.html>.

use std::collections::HashMap;

use serde::Serialize;
use serde_json::{Map, Value, json};
use vencejo_proto::MissionSeq;

use crate::error::{FlightError, Result};
use crate::formats::plan_file::{PlanFile, PlanFormat, PlanSettings};
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

/// What to do about items that only QGroundControl can work out.
const ITEMS_ELSEWHERE: &str = "its items are not in the file; send the plan from QGroundControl to a vehicle or a simulator, read it back there and save that";

/// A value and where it stands in the file.
#[derive(Clone)]
struct Node<'a> {
    value: &'a Value,
    path: String,
}

impl<'a> Node<'a> {
    fn bad(&self, problem: impl Into<String>) -> FlightError {
        FlightError::BadJson { path: self.path.clone(), problem: problem.into() }
    }

    fn wrong_kind(&self, wanted: &str) -> FlightError {
        let found = match self.value {
            Value::Null => "null".to_owned(),
            Value::Bool(value) => value.to_string(),
            Value::Number(number) => shown(&number.to_string()),
            Value::String(text) => format!("\"{}\"", shown(text)),
            Value::Array(_) => "a list".to_owned(),
            Value::Object(_) => "an object".to_owned(),
        };
        self.bad(format!("is {found} where {wanted} belongs"))
    }

    fn object(&self) -> Result<&'a Map<String, Value>> {
        self.value.as_object().ok_or_else(|| self.wrong_kind("an object"))
    }

    /// A member; absent and null are `None`.
    fn member(&self, key: &str) -> Result<Option<Node<'a>>> {
        let value = self.object()?.get(key).filter(|value| !value.is_null());
        Ok(value.map(|value| Node { value, path: join(&self.path, key) }))
    }

    fn required(&self, key: &str) -> Result<Node<'a>> {
        self.member(key)?.ok_or_else(|| FlightError::BadJson {
            path: join(&self.path, key),
            problem: "is missing; save the plan again with a current QGroundControl, or add it".into(),
        })
    }

    fn list(&self) -> Result<impl ExactSizeIterator<Item = Node<'a>> + use<'a>> {
        let list = self.value.as_array().ok_or_else(|| self.wrong_kind("a list"))?;
        let path = self.path.clone();
        Ok(list.iter().enumerate().map(move |(index, value)| Node { value, path: format!("{path}[{index}]") }))
    }

    fn number(&self) -> Result<f64> {
        self.value.as_f64().filter(|value| value.is_finite()).ok_or_else(|| self.wrong_kind("a number"))
    }

    fn whole(&self, max: u32) -> Result<u32> {
        let value = self.number()?;
        if value.fract() == 0.0 && (0.0..=f64::from(max)).contains(&value) {
            Ok(value as u32)
        } else {
            Err(self.wrong_kind(&format!("a whole number from 0 to {max}")))
        }
    }

    fn flag(&self) -> Result<bool> {
        self.value.as_bool().ok_or_else(|| self.wrong_kind("true or false"))
    }

    fn flag_or(&self, key: &str, default: bool) -> Result<bool> {
        self.member(key)?.map_or(Ok(default), |node| node.flag())
    }

    fn text(&self) -> Result<&'a str> {
        self.value.as_str().ok_or_else(|| self.wrong_kind("a text"))
    }

    /// A part that is only there to be empty need not say its version.
    fn expect_version_if_any(&self, oldest: u32, newest: u32) -> Result<()> {
        let Some(version) = self.member("version")? else { return Ok(()) };
        match version.whole(u32::MAX)? {
            found if (oldest..=newest).contains(&found) => Ok(()),
            found => Err(version.bad(format!(
                "is {found}; versions {oldest} and {newest} are read, so save the plan again with a current QGroundControl"
            ))),
        }
    }

    fn expect_version(&self, wanted: u32) -> Result<()> {
        let version = self.required("version")?;
        match version.whole(u32::MAX)? {
            found if found == wanted => Ok(()),
            found => Err(version.bad(format!(
                "is {found}; only version {wanted} is read, so save the plan again with a current QGroundControl"
            ))),
        }
    }

    /// `[latitude, longitude]`, and a height when there is a third number that is not null.
    fn coordinate(&self) -> Result<(GeoPoint, Option<f64>)> {
        let parts: Vec<_> = self.list()?.collect();
        let (lat, lon, alt) = match parts.as_slice() {
            [lat, lon] => (lat, lon, None),
            [lat, lon, alt] => (lat, lon, Some(alt)),
            _ => return Err(self.wrong_kind("[latitude, longitude] or [latitude, longitude, height]")),
        };
        let point = GeoPoint::new(lat.number()?, lon.number()?).map_err(|error| self.bad(error.to_string()))?;
        let alt_m = alt.filter(|alt| !alt.value.is_null()).map(Node::number).transpose()?;
        Ok((point, alt_m))
    }

    /// `[latitude, longitude, height]`.
    fn place(&self) -> Result<(GeoPoint, f64)> {
        match self.coordinate()? {
            (point, Some(alt_m)) => Ok((point, alt_m)),
            _ => Err(self.wrong_kind("[latitude, longitude, height]")),
        }
    }
}

fn join(path: &str, key: &str) -> String {
    if path == ROOT { key.to_owned() } else { format!("{path}.{key}") }
}

const ROOT: &str = "plan";

/// Bytes that the values of a file may take when they are unfolded.
const MAX_UNFOLDED: usize = 42 * 1024 * 1024;
/// Objects and lists inside each other at most; plans need ten.
const MAX_DEPTH: usize = 64;

/// Looks through JSON before it is unfolded: values take many times the bytes that they are written with.
///
/// Counts what a value, a list, an object and a member take at most in `serde_json`: a list of one value makes room for four, an
/// object for eleven. What is no JSON is counted as well as can be, and refused by who reads it.
fn check_size(text: &str) -> Result<()> {
    const VALUE: usize = 3 * size_of::<Value>();
    const LIST: usize = 4 * size_of::<Value>();
    const OBJECT: usize = 11 * (size_of::<String>() + size_of::<Value>()) + 32;
    const MEMBER: usize = OBJECT / 5;
    let (mut bytes, mut depth, mut is_text, mut is_escaped) = (VALUE, 0_usize, false, false);
    for byte in text.bytes() {
        if is_text {
            bytes += 1;
            is_text = is_escaped || byte != b'"';
            is_escaped = !is_escaped && byte == b'\\';
            continue;
        }
        match byte {
            b'"' => is_text = true,
            b',' => bytes += VALUE,
            b':' => bytes += MEMBER,
            b'[' => (bytes, depth) = (bytes + VALUE + LIST, depth + 1),
            b'{' => (bytes, depth) = (bytes + VALUE + OBJECT, depth + 1),
            b']' | b'}' => depth = depth.saturating_sub(1),
            _ => {}
        }
        if depth > MAX_DEPTH {
            return Err(FlightError::BadFile(format!(
                "the file is more than {MAX_DEPTH} lists and objects deep, which no plan is; choose another"
            )));
        }
        if bytes > MAX_UNFOLDED {
            return Err(FlightError::BadFile(
                "the file holds more values than a plan that can be read; save it without surveys' previews, or split it".into(),
            ));
        }
    }
    Ok(())
}

/// Reads a plan.
///
/// `DO_JUMP` targets, which the file gives as `doJumpId`, become the seq of the item that they mean. One that no item has stays as it
/// is where it could not be taken for another item's seq.
///
/// # Errors
/// [`FlightError::BadJson`] with the JSON path, [`FlightError::BadFile`] when it is no text file.
pub fn read_plan_json(bytes: &[u8]) -> Result<PlanFile> {
    let text = text_of(bytes)?;
    check_size(text)?;
    let value: Value = serde_json::from_str(text).map_err(|error| FlightError::BadJson {
        path: format!("line {}, column {}", error.line(), error.column()),
        problem: format!("is not JSON ({error}); the file is damaged or cut short, save the plan again"),
    })?;
    let root = Node { value: &value, path: ROOT.into() };
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
            value if (0.0..1_000.0).contains(&value) => Ok(Some(value)),
            _ => Err(node.wrong_kind("a speed from 0 to 1000 m/s")),
        }
    };
    let settings = PlanSettings {
        cruise_speed_m_s: speed("cruiseSpeed")?,
        hover_speed_m_s: speed("hoverSpeed")?,
        vehicle_type: small("vehicleType")?,
        firmware_type: small("firmwareType")?.or(small("MAV_AUTOPILOT")?),
    };
    let plan = Plan {
        mission: read_mission(&mission_node)?,
        fence: root.member("geoFence")?.map_or(Ok(Fence::default()), |node| read_fence(&node))?,
        rally: root.member("rallyPoints")?.map_or(Ok(Rally::default()), |node| read_rally(&node))?,
    };
    Ok(PlanFile { plan, settings, format: PlanFormat::QgcPlan })
}

/// Items while they are gathered, with what `DO_JUMP` needs.
#[derive(Default)]
struct Items {
    items: Vec<MissionItem>,
    /// `doJumpId` → seq; `None` when two items claim it.
    seq_of_id: HashMap<u32, Option<usize>>,
    /// Places of `DO_JUMP` items in `items`, with their JSON path.
    jumps: Vec<(usize, String)>,
}

fn read_mission(node: &Node<'_>) -> Result<Mission> {
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
                Some(Home { lat_deg: point.lat_deg(), lon_deg: point.lon_deg(), alt_amsl_m })
            }
            _ => None,
        },
    };
    let mut found = Items::default();
    read_items(&node.required("items")?, &mut found)?;
    let Items { mut items, seq_of_id, jumps } = found;
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
            // Nor is it the seq of another item: it stays what it is, a jump to nowhere, for the check to tell. A plan is saved
            // while it is being edited, too.
            None if target.fract() != 0.0 || !items_there.contains(target) => {}
            None => {
                return Err(FlightError::BadJson {
                    path,
                    problem: format!("jumps to doJumpId {target}, which no item has; choose an item of this plan"),
                });
            }
        }
    }
    Ok(Mission { home, items })
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
                format!("({command}) has {value} as its {field}, {problem}")
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
    match name {
        "fwLandingPattern" => read_landing(node, Command::NAV_LAND, found),
        "vtolLandingPattern" => read_landing(node, Command::NAV_VTOL_LAND, found),
        _ => {
            let transects = node.member("TransectStyleComplexItem")?;
            let items = transects.map_or(Ok(None), |transects| transects.member("Items"))?;
            match items {
                Some(items) => read_items(&items, found),
                None => Err(kind.bad(format!("is \"{}\"; {ITEMS_ELSEWHERE}", shown(name)))),
            }
        }
    }
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
    fence.return_point = match node.member("breachReturn")? {
        None => None,
        Some(place) => place.coordinate().map(|(point, alt_m)| Some((point, alt_m.unwrap_or(0.0))))?,
    };
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
            Ok(RallyPoint { point, alt_m, frame: MavFrame::GlobalRelativeAlt })
        })
        .collect::<Result<_>>()?;
    Ok(Rally { points })
}

/// Writes a plan, four spaces deep and keys in order, as QGroundControl does.
///
/// # Errors
/// [`FlightError::BadRally`] for a rally point whose height is not above home: the format has no place for
/// what the height is counted from.
pub fn write_plan_json(plan: &Plan, settings: &PlanSettings) -> Result<String> {
    if let Some(index) = plan.rally.points.iter().position(|rally| rally.frame != MavFrame::GlobalRelativeAlt) {
        return Err(FlightError::BadRally {
            index,
            problem: "has a height that is not above home, which a .plan file cannot say; convert it".into(),
        });
    }
    let home = plan.mission.home.unwrap_or(Home { lat_deg: 0.0, lon_deg: 0.0, alt_amsl_m: 0.0 });
    let items: Vec<Value> =
        plan.mission.items.iter().enumerate().map(|(index, item)| write_item(index + 1, item)).collect();
    let value = json!({
        "fileType": "Plan",
        "version": 1,
        "groundStation": "Vencejo",
        "geoFence": write_fence(&plan.fence),
        "mission": {
            "version": 2,
            "cruiseSpeed": plain(settings.cruise_speed_m_s.unwrap_or(DEFAULT_CRUISE_M_S)),
            "hoverSpeed": plain(settings.hover_speed_m_s.unwrap_or(DEFAULT_HOVER_M_S)),
            "firmwareType": settings.firmware_type.unwrap_or(DEFAULT_FIRMWARE),
            "vehicleType": settings.vehicle_type.unwrap_or(DEFAULT_VEHICLE),
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

/// A number without ".0" when it is whole, null when it is not finite.
fn plain(value: f64) -> Value {
    const EXACT: f64 = 9_007_199_254_740_992.0; // 2^53
    if value.fract() == 0.0 && value.abs() < EXACT { json!(value as i64) } else { json!(value) }
}

fn place(point: GeoPoint, alt_m: f64) -> Value {
    json!([plain(point.lat_deg()), plain(point.lon_deg()), plain(alt_m)])
}

fn write_item(seq: usize, item: &MissionItem) -> Value {
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
