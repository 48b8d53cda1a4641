//! Places of maps (points, lines, areas) as plans, and plans as places with their items beside them.
//!
//! KML and GeoJSON know the same things: geometries, each with data of its own. What a plan holds goes into the data,
//! so that such a file keeps everything; places are where the geometry is, so that moving a point in a map program
//! moves the item. What others drew becomes waypoints (lines, else points) and zones of the fence (areas).

use crate::error::{FlightError, Result};
use crate::formats::notes::{NoteCode, Notes};
use crate::formats::text::{shown, too_many};
use crate::geodesy::{GeoPoint, direct};
use crate::plan::{
    Command, Fence, FenceShape, FenceZone, Home, MAX_ITEMS, MavFrame, Mission, MissionItem, Plan, RallyPoint,
};
use crate::progress::alt_amsl_m;

/// A point of a geometry.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Place {
    pub(super) point: GeoPoint,
    /// Height, as the heights of its feature count; `None` where the file has none.
    pub(super) alt_m: Option<f64>,
}

/// A geometry.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Shape {
    Nothing,
    Point(Place),
    Line(Vec<Place>),
    /// The border, then the holes. Each ends before it comes to its first corner again.
    Area(Vec<Vec<Place>>),
}

/// Reference of a feature's heights.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Heights {
    /// Mean sea level, by the format's definition.
    Sea,
    /// The terrain below, as the file says.
    Terrain,
    /// By the standard the ellipsoid: taken as mean sea level.
    Ellipsoid,
}

impl Heights {
    const fn frame(self) -> MavFrame {
        match self {
            Self::Sea | Self::Ellipsoid => MavFrame::Global,
            Self::Terrain => MavFrame::GlobalTerrainAlt,
        }
    }

    const fn note(self) -> NoteCode {
        match self {
            Self::Sea => NoteCode::HeightsAboveSeaLevel,
            Self::Terrain => NoteCode::HeightsAboveTerrain,
            Self::Ellipsoid => NoteCode::HeightsTakenAboveSeaLevel,
        }
    }
}

/// A datum beside a geometry.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Datum {
    Number(f64),
    Flag(bool),
    Word(String),
}

/// A geometry with what stands beside it.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Feature {
    pub(super) shape: Shape,
    pub(super) heights: Heights,
    /// Data by name, texts as the file has them.
    pub(super) data: Vec<(String, Datum)>,
    /// Its place in the file, for messages; when written, its name on the map.
    pub(super) name: String,
    /// Whether the file names or describes it.
    pub(super) is_named: bool,
}

/// The datum that says what a feature is in a plan.
const ROLE: &str = "vencejo";
const PARAMS: [&str; 4] = ["p1", "p2", "p3", "p4"];
/// Corners of a circle that is drawn.
const CIRCLE_CORNERS: usize = 72;

/// Takes off the last corner of a ring where it is the first again, as files have it.
pub(super) fn open_ring(mut ring: Vec<Place>) -> Vec<Place> {
    if ring.len() > 1 && ring.first().map(|place| place.point) == ring.last().map(|place| place.point) {
        ring.pop();
    }
    ring
}

impl Feature {
    /// This feature with the shapes that it consists of, a feature for each.
    ///
    /// The first has the data. The others only learn what they are: a file with many parts and much data does not grow.
    pub(super) fn parts(self, shapes: impl IntoIterator<Item = (Shape, Heights)>) -> Vec<Self> {
        let is_short = |(key, datum): &&(String, Datum)| match datum {
            Datum::Word(word) => key == ROLE && word.len() < 20,
            Datum::Flag(_) => key == "inclusion",
            Datum::Number(_) => false,
        };
        let rest = Self {
            shape: Shape::Nothing,
            heights: self.heights,
            data: self.data.iter().filter(is_short).take(2).cloned().collect(),
            name: self.name.clone(),
            is_named: false,
        };
        let mut shapes = shapes.into_iter();
        let Some((shape, heights)) = shapes.next() else { return vec![self] };
        let mut parts = vec![Self { shape, heights, ..self }];
        parts.extend(shapes.map(|(shape, heights)| Self { shape, heights, ..rest.clone() }));
        parts
    }

    fn bad(&self, problem: impl std::fmt::Display) -> FlightError {
        FlightError::BadFile(format!("{}: {problem}", self.name))
    }

    fn datum(&self, key: &str) -> Option<&Datum> {
        self.data.iter().find(|(name, _)| name == key).map(|(_, datum)| datum)
    }

    fn role(&self) -> Option<&str> {
        match self.datum(ROLE)? {
            Datum::Word(word) => Some(word),
            Datum::Number(_) | Datum::Flag(_) => None,
        }
    }

    fn number(&self, key: &str) -> Result<Option<f64>> {
        let value = match self.datum(key) {
            None => return Ok(None),
            Some(Datum::Number(value)) => Some(*value),
            Some(Datum::Flag(_)) => None,
            Some(Datum::Word(text)) if text.trim().is_empty() => return Ok(None),
            Some(Datum::Word(text)) => text.trim().parse().ok(),
        };
        match value.filter(|value: &f64| value.is_finite()) {
            Some(value) => Ok(Some(value)),
            None => Err(self.bad(format!("its datum {key} is not a number; write one, or take the datum out"))),
        }
    }

    fn required(&self, key: &str) -> Result<f64> {
        self.number(key)?.ok_or_else(|| self.bad(format!("lacks its datum {key}; save the plan again")))
    }

    fn whole(&self, key: &str, max: u16) -> Result<u16> {
        let value = self.required(key)?;
        if value.fract() == 0.0 && (0.0..=f64::from(max)).contains(&value) {
            Ok(value as u16)
        } else {
            Err(self.bad(format!("its datum {key} is {value}; a whole number from 0 to {max} belongs there")))
        }
    }

    fn flag(&self, key: &str) -> Result<bool> {
        match self.datum(key) {
            Some(Datum::Flag(flag)) => Ok(*flag),
            Some(Datum::Word(word)) if word.trim() == "true" => Ok(true),
            Some(Datum::Word(word)) if word.trim() == "false" => Ok(false),
            _ => Err(self.bad(format!("its datum {key} is neither true nor false; save the plan again"))),
        }
    }

    /// Where a feature that is a point lies.
    fn point(&self) -> Result<GeoPoint> {
        match &self.shape {
            Shape::Point(place) => Ok(place.point),
            _ => Err(self.bad("is no point, though its data say that it is one of a plan; save the plan again")),
        }
    }

    /// The item from the feature's data, placed at its geometry.
    fn item(&self) -> Result<MissionItem> {
        let mut params = [None; 7];
        for (param, key) in params.iter_mut().zip(PARAMS) {
            *param = self.number(key)?;
        }
        (params[4], params[5]) = match &self.shape {
            Shape::Point(place) => (Some(place.point.lat_deg()), Some(place.point.lon_deg())),
            _ => (self.number("x")?, self.number("y")?),
        };
        params[6] = self.number("alt_m")?;
        let item = MissionItem {
            command: Command(self.whole("command", u16::MAX)?),
            frame: MavFrame::from(self.whole("frame", 255)? as u8),
            params,
            autocontinue: self.flag("autocontinue")?,
        };
        self.sendable(item)
    }

    fn sendable(&self, item: MissionItem) -> Result<MissionItem> {
        item.unsendable().map_or(Ok(item), |bad| Err(self.bad(bad)))
    }

    fn waypoint(&self, place: Place, notes: &mut Notes) -> Result<MissionItem> {
        let mut item = MissionItem::waypoint(place.point.lat_deg(), place.point.lon_deg(), 0.0);
        item.params[6] = place.alt_m;
        if place.alt_m.is_some() {
            item.frame = self.heights.frame();
            notes.add(self.heights.note(), 1);
        } else {
            notes.add(NoteCode::HeightsMissing, 1);
        }
        self.sendable(item)
    }
}

/// Makes a plan of a file's features.
///
/// # Errors
/// [`FlightError::BadFile`] for a file without a place, an area that cannot be a fence, and damaged data.
pub(super) fn plan_of(features: &[Feature], notes: &mut Notes) -> Result<Plan> {
    let mut plan = Plan::default();
    let mut items = Vec::new();
    let (mut lines, mut points) = (Vec::new(), Vec::new());
    let (mut corners, mut places) = (0, 0);
    for feature in features {
        match feature.role() {
            Some("item") => items.push((feature.number("item")?.unwrap_or(f64::MAX), feature.item()?)),
            Some("home") => {
                let (point, alt_amsl_m) = (feature.point()?, feature.required("alt_amsl_m")?);
                let home = Home { lat_deg: point.lat_deg(), lon_deg: point.lon_deg(), alt_amsl_m };
                home.point().map_err(|error| feature.bad(error.to_string()))?;
                plan.mission.home = Some(home);
            }
            Some("rally") => {
                let frame = MavFrame::from(feature.whole("frame", 255)? as u8);
                let point = RallyPoint { point: feature.point()?, alt_m: feature.required("alt_m")?, frame };
                point.fault().map_or(Ok(()), |fault| Err(feature.bad(fault)))?;
                plan.rally.points.push(point);
            }
            Some("fence-return") => {
                plan.fence.return_point = Some((feature.point()?, feature.required("alt_rel_home_m")?));
                plan.fence.return_fault().map_or(Ok(()), |fault| Err(feature.bad(fault)))?;
            }
            Some("fence-circle") => {
                let shape = FenceShape::Circle { center: feature.point()?, radius_m: feature.required("radius_m")? };
                add_zone(&mut plan.fence, feature, feature.flag("inclusion")?, shape)?;
            }
            Some("drawing") => {}
            role => match &feature.shape {
                Shape::Nothing => notes.add(NoteCode::NotPlaces, 1),
                Shape::Point(place) => points.push((feature, *place)),
                Shape::Line(line) => {
                    places += line.len();
                    lines.push((feature, line));
                }
                Shape::Area(rings) => {
                    let is_ours = role == Some("fence-polygon");
                    let inclusion = !is_ours || feature.flag("inclusion")?;
                    for (index, ring) in rings.iter().enumerate() {
                        corners += ring.len();
                        let vertices = ring.iter().map(|place| place.point).collect();
                        add_zone(
                            &mut plan.fence,
                            feature,
                            inclusion == (index == 0),
                            FenceShape::Polygon { vertices },
                        )?;
                    }
                    if !is_ours {
                        notes.add(NoteCode::AreasTakenAsFence, 1);
                        let is_high = |place: &Place| place.alt_m.is_some_and(|alt_m| alt_m != 0.0);
                        notes.add(NoteCode::AreaHeightsNotKept, usize::from(rings.iter().flatten().any(is_high)));
                    }
                    notes.add(NoteCode::HolesTakenAsFence, rings.len().saturating_sub(1));
                }
            },
        }
        if feature.role().is_none() {
            notes.add(NoteCode::NamesNotKept, usize::from(feature.is_named));
        }
        for count in [items.len(), points.len(), places, corners, plan.fence.zones.len(), plan.rally.points.len()] {
            if let Some(problem) = too_many(count) {
                return Err(feature.bad(problem));
            }
        }
    }
    plan.mission.items = if !items.is_empty() {
        notes.add(NoteCode::PointsLeftOut, points.len() + lines.len());
        renumbered(items, notes)?
    } else if !lines.is_empty() {
        notes.add(NoteCode::PointsLeftOut, points.len());
        notes.add(NoteCode::LinesJoined, if lines.len() > 1 { lines.len() } else { 0 });
        let places = lines.iter().flat_map(|(feature, line)| line.iter().map(move |place| (feature, *place)));
        places.map(|(feature, place)| feature.waypoint(place, notes)).collect::<Result<_>>()?
    } else {
        points.into_iter().map(|(feature, place)| feature.waypoint(place, notes)).collect::<Result<_>>()?
    };
    if plan == Plan::default() && !features.iter().any(|feature| feature.role().is_some()) {
        return Err(FlightError::BadFile(
            "the file holds no point, line or area that a plan could be made of; choose another".into(),
        ));
    }
    Ok(plan)
}

/// Items in the order of the numbers that they had. A map program may have lost some, or copied one: jumps go on to
/// name what they named.
fn renumbered(mut items: Vec<(f64, MissionItem)>, notes: &mut Notes) -> Result<Vec<MissionItem>> {
    items.sort_by(|a, b| a.0.total_cmp(&b.0));
    let numbers: Vec<f64> = items.iter().map(|(number, _)| *number).collect();
    let last = numbers.last().copied().filter(|last| *last <= MAX_ITEMS as f64).unwrap_or_default() as usize;
    notes.add(NoteCode::ItemsMissing, last.saturating_sub(items.len()));
    let is_whole = numbers.iter().enumerate().all(|(place, number)| *number == (place + 1) as f64);
    for (number, item) in items.iter_mut().filter(|(_, item)| !is_whole && item.command == Command::DO_JUMP) {
        let Some(target) = item.params[0].as_mut() else { continue };
        let mut named = (1..).zip(&numbers).filter(|(_, number)| *number == target);
        *target = match (named.next(), named.next()) {
            (Some((place, _)), None) => f64::from(place),
            (found, _) => {
                let problem = if found.is_none() { "is not in the file" } else { "is there twice" };
                return Err(FlightError::BadFile(format!(
                    "item {number} jumps to item {target}, which {problem}; save the plan again, or take the jump out"
                )));
            }
        };
    }
    Ok(items.into_iter().map(|(_, item)| item).collect())
}

fn add_zone(fence: &mut Fence, feature: &Feature, inclusion: bool, shape: FenceShape) -> Result<()> {
    let zone = Fence { zones: vec![FenceZone { inclusion, shape }], return_point: None };
    match zone.fault() {
        Some((_, fault)) => Err(feature.bad(fault)),
        None => {
            fence.zones.extend(zone.zones);
            Ok(())
        }
    }
}

/// A plan as features.
///
/// With `draws_heights` the geometries have heights: above the sea where they are known so, else above the terrain.
pub(super) fn features_of(plan: &Plan, draws_heights: bool, notes: &mut Notes) -> Vec<Feature> {
    let Plan { mission: Mission { home, items }, fence, rally } = plan;
    let mut features = Vec::new();
    let number = |key: &str, value: f64| value.is_finite().then(|| (key.to_owned(), Datum::Number(value)));
    let mut add = |role: &str, name: String, shape, heights, data: Vec<Option<(String, Datum)>>| {
        let role = (ROLE.to_owned(), Datum::Word(role.to_owned()));
        let data = std::iter::once(role).chain(data.into_iter().flatten()).collect();
        features.push(Feature { shape, heights, data, name, is_named: true });
    };
    if let Some((home, point)) = home.and_then(|home| Some((home, home.point().ok()?))) {
        let place = Place { point, alt_m: Some(home.alt_amsl_m) };
        add("home", "Home".into(), Shape::Point(place), Heights::Sea, vec![number("alt_amsl_m", home.alt_amsl_m)]);
    }
    let mut route = Vec::new();
    for (index, item) in items.iter().enumerate() {
        let drawn = drawn(item, *home, draws_heights, notes);
        let name = format!("{} {}", index + 1, item.command);
        let mut data = vec![
            number("item", (index + 1) as f64),
            number("command", f64::from(item.command.0)),
            number("frame", f64::from(item.frame.number())),
            Some(("autocontinue".into(), Datum::Flag(item.autocontinue))),
        ];
        data.extend(PARAMS.iter().zip(item.params).map(|(key, value)| number(key, value?)));
        data.push(item.params[6].and_then(|alt_m| number("alt_m", alt_m)));
        let Some((place, heights)) = drawn else {
            data.push(item.params[4].and_then(|x| number("x", x)));
            data.push(item.params[5].and_then(|y| number("y", y)));
            add("item", name, Shape::Nothing, Heights::Sea, data);
            continue;
        };
        if item.command.is_destination() {
            route.push((place, heights));
        }
        add("item", name, Shape::Point(place), heights, data);
    }
    if route.len() > 1 {
        let heights = route[0].1;
        let is_alike = route.iter().all(|(place, of)| place.alt_m.is_some() && *of == heights);
        let places =
            route.iter().map(|(place, _)| Place { alt_m: place.alt_m.filter(|_| is_alike), ..*place }).collect();
        add("drawing", "Route (drawn; the points count)".into(), Shape::Line(places), heights, Vec::new());
    }
    let flat = |point| Place { point, alt_m: None };
    for (index, zone) in fence.zones.iter().enumerate() {
        let side = if zone.inclusion { "inside" } else { "outside" };
        let name = format!("Fence {}: stay {side}", index + 1);
        let inclusion = Some(("inclusion".to_owned(), Datum::Flag(zone.inclusion)));
        match &zone.shape {
            FenceShape::Polygon { vertices } => {
                let ring = vertices.iter().copied().map(flat).collect();
                add("fence-polygon", name, Shape::Area(vec![ring]), Heights::Sea, vec![inclusion]);
            }
            FenceShape::Circle { center, radius_m } => {
                let data = vec![inclusion.clone(), number("radius_m", *radius_m)];
                add("fence-circle", name.clone(), Shape::Point(flat(*center)), Heights::Sea, data);
                let step_deg = 360.0 / CIRCLE_CORNERS as f64;
                let corner = |index| flat(direct(*center, step_deg * index as f64, *radius_m));
                let ring = (0..CIRCLE_CORNERS).map(corner).collect();
                let name = format!("{name} (drawn; the centre and its radius count)");
                add("drawing", name, Shape::Area(vec![ring]), Heights::Sea, vec![inclusion]);
            }
        }
    }
    if let Some((point, alt_rel_home_m)) = fence.return_point {
        let data = vec![number("alt_rel_home_m", alt_rel_home_m)];
        add("fence-return", "Fence: return here".into(), Shape::Point(flat(point)), Heights::Sea, data);
    }
    for (index, RallyPoint { point, alt_m, frame }) in rally.points.iter().enumerate() {
        let data = vec![number("alt_m", *alt_m), number("frame", f64::from(frame.number()))];
        let item = MissionItem { frame: *frame, ..MissionItem::waypoint(point.lat_deg(), point.lon_deg(), *alt_m) };
        let (place, heights) = drawn(&item, *home, draws_heights, notes).unwrap_or((flat(*point), Heights::Sea));
        add("rally", format!("Rally {}", index + 1), Shape::Point(place), heights, data);
    }
    features
}

/// Where an item is drawn, and how high; `None` without a place.
fn drawn(item: &MissionItem, home: Option<Home>, draws_heights: bool, notes: &mut Notes) -> Option<(Place, Heights)> {
    let point = item.point()?;
    let (alt_m, heights) = match item.frame {
        MavFrame::GlobalTerrainAlt => (item.alt_m(), Heights::Terrain),
        _ => (alt_amsl_m(item, home.map(|home| home.alt_amsl_m)), Heights::Sea),
    };
    let alt_m = alt_m.filter(|alt_m| draws_heights && alt_m.is_finite());
    match alt_m {
        None => notes.add(NoteCode::HeightsNotDrawn, usize::from(item.alt_m().is_some())),
        Some(_) if item.frame == MavFrame::GlobalRelativeAlt => notes.add(NoteCode::HeightsDrawnAboveSeaLevel, 1),
        Some(_) => {}
    }
    Some((Place { point, alt_m }, heights))
}

/// A number of a file where a coordinate belongs, as a checked point.
pub(super) fn point_of(lat: &str, lon: &str) -> std::result::Result<GeoPoint, String> {
    let number = |text: &str, what: &str| {
        text.trim().parse::<f64>().map_err(|_| format!("has \"{}\" as its {what}; degrees belong there", shown(text)))
    };
    GeoPoint::new(number(lat, "latitude")?, number(lon, "longitude")?).map_err(|error| error.to_string())
}

/// A height of a file; empty: no height.
pub(super) fn height_of(text: &str) -> std::result::Result<Option<f64>, String> {
    match text.trim() {
        "" => Ok(None),
        text => match text.parse::<f64>() {
            Ok(value) if value.is_finite() => Ok(Some(value)),
            _ => Err(format!("has \"{}\" as its height; metres belong there", shown(text))),
        },
    }
}
