//! CSV: a row for each item, columns by the names in the first row.
//!
//! Our own tables have a row for home, then the lists of `.waypoints`: fence and rally points are items too. Of other
//! tables latitude and longitude are enough; with semicolons or tabs between the columns decimals may have commas, as
//! spreadsheets write them.

use csv::{ReaderBuilder, StringRecord, Writer};

use crate::error::{FlightError, Result};
use crate::formats::notes::{NoteCode, Notes};
use crate::formats::text::{number, shown, too_many};
use crate::formats::waypoints::{List, kind_of};
use crate::plan::{Command, Fence, Home, MavFrame, Mission, MissionItem, Plan, PlanKind, Rally};

const HEADER: [&str; 11] = ["item", "command", "name", "frame", "p1", "p2", "p3", "p4", "lat_deg", "lon_deg", "alt_m"];
/// Beyond it no table of places goes.
const MAX_COLUMNS: usize = 200;
/// What stands in the column `item` of home.
const HOME: &str = "home";

/// Names of columns in lower case, letters and digits only, and their content.
const LATITUDES: [&str; 4] = ["latdeg", "lat", "latitude", "latitud"];
const LONGITUDES: [&str; 6] = ["londeg", "lon", "lng", "long", "longitude", "longitud"];
const HEIGHTS: [(&str, Option<MavFrame>); 17] = [
    ("altm", None),
    ("alt", None),
    ("altitude", None),
    ("altitudem", None),
    ("height", None),
    ("heightm", None),
    ("ele", None),
    ("elevation", None),
    ("altitud", None),
    ("altura", None),
    ("altamslm", Some(MavFrame::Global)),
    ("altamsl", Some(MavFrame::Global)),
    ("amsl", Some(MavFrame::Global)),
    ("altrelhomem", Some(MavFrame::GlobalRelativeAlt)),
    ("altrelhome", Some(MavFrame::GlobalRelativeAlt)),
    ("altterrainm", Some(MavFrame::GlobalTerrainAlt)),
    ("altagl", Some(MavFrame::GlobalTerrainAlt)),
];

/// Where the columns of a table are.
struct Columns {
    lat: usize,
    lon: usize,
    alt: Option<(usize, Option<MavFrame>)>,
    item: Option<usize>,
    command: Option<usize>,
    frame: Option<usize>,
    params: [Option<usize>; 4],
    autocontinue: Option<usize>,
    has_name: bool,
}

impl Columns {
    /// By the first row; `None` where it does not name latitude and longitude.
    fn of(header: &StringRecord) -> Option<Self> {
        let plain = |name: &str| {
            name.chars().filter(|c| c.is_ascii_alphanumeric()).map(|c| c.to_ascii_lowercase()).collect::<String>()
        };
        let names: Vec<String> = header.iter().take(MAX_COLUMNS).map(plain).collect();
        let one_of = |wanted: &[&str]| names.iter().position(|name| wanted.contains(&name.as_str()));
        let param = |number: usize| one_of(&[&format!("p{number}"), &format!("param{number}")]);
        let alt = names.iter().enumerate().find_map(|(place, name)| {
            HEIGHTS.iter().find(|(wanted, _)| wanted == name).map(|(_, frame)| (place, *frame))
        });
        Some(Self {
            lat: one_of(&LATITUDES)?,
            lon: one_of(&LONGITUDES)?,
            alt,
            item: one_of(&["item"]),
            command: one_of(&["command"]),
            frame: one_of(&["frame"]),
            params: [param(1), param(2), param(3), param(4)],
            autocontinue: one_of(&["autocontinue"]),
            has_name: one_of(&["name", "nombre", "description"]).is_some(),
        })
    }
}

/// What separates the columns, by the first line: what stands there most often of those that programs write.
fn separator(text: &str) -> u8 {
    let first = text.trim_start().lines().next().unwrap_or_default();
    let count = |separator: u8| first.bytes().filter(|byte| *byte == separator).count();
    [b',', b';', b'\t'].into_iter().rev().max_by_key(|separator| count(*separator)).unwrap_or(b',')
}

fn rows(text: &str) -> (u8, csv::Reader<&[u8]>) {
    let separator = separator(text);
    let reader = ReaderBuilder::new()
        .delimiter(separator)
        .has_headers(false)
        .flexible(true)
        .trim(csv::Trim::All)
        .from_reader(text.trim_start().as_bytes());
    (separator, reader)
}

/// Whether a text is a table that names latitude and longitude.
pub(super) fn is_table(text: &str) -> bool {
    let (_, mut reader) = rows(text);
    let mut header = StringRecord::new();
    reader.read_record(&mut header).is_ok_and(|found| found) && Columns::of(&header).is_some()
}

/// Reads a table.
///
/// # Errors
/// [`FlightError::BadLine`] with the line and what to do.
pub(super) fn read_table(text: &str, notes: &mut Notes) -> Result<Plan> {
    let body = text.trim_start();
    let mut lines_before = text[..text.len() - body.len()].matches('\n').count();
    let (separator, mut reader) = rows(text);
    let mut row = StringRecord::new();
    let bad = |line: usize, problem: String| FlightError::BadLine { line, problem };
    let mut counted_to = 0;
    // The next row and the line that it ends on; the reader's own count leaves out empty lines.
    let mut read = |row: &mut StringRecord| -> Result<Option<usize>> {
        let found = reader.read_record(row);
        let end = body.get(..reader.position().byte() as usize).unwrap_or(body).trim_end_matches(['\r', '\n']).len();
        lines_before +=
            body.as_bytes().get(counted_to..end).unwrap_or_default().iter().filter(|byte| **byte == b'\n').count();
        counted_to = counted_to.max(end);
        match found {
            Ok(is_there) => Ok(is_there.then_some(lines_before + 1)),
            Err(error) => {
                Err(bad(lines_before + 1, format!("cannot be read ({error}); save the table again as CSV in UTF-8")))
            }
        }
    };
    let columns = match read(&mut row)?.map(|_| Columns::of(&row)) {
        Some(Some(columns)) => columns,
        _ => {
            return Err(bad(
                1,
                "does not name the columns; the first line of a table needs lat and lon among its names, as in lat,lon,alt_rel_home_m".into(),
            ));
        }
    };
    let mut plan = Plan::default();
    let (mut fence, mut rally) = (List::default(), List::default());
    let mut count = 0;
    while let Some(line) = read(&mut row)? {
        if row.iter().all(str::is_empty) {
            continue;
        }
        let at_line = |problem| bad(line, problem);
        let row = Row { fields: &row, columns: &columns, has_decimal_commas: separator != b',' };
        if row.text(columns.item).eq_ignore_ascii_case(HOME) {
            plan.mission.home = Some(row.home().map_err(at_line)?);
            continue;
        }
        count += 1;
        if let Some(problem) = too_many(count) {
            return Err(bad(line, problem));
        }
        let Some(item) = row.item(notes).map_err(at_line)? else {
            notes.add(NoteCode::NotPlaces, 1);
            continue;
        };
        match kind_of(item.command) {
            PlanKind::Mission => plan.mission.items.push(item),
            PlanKind::Fence => fence.push(line, item),
            PlanKind::Rally => rally.push(line, item),
        }
    }
    if count == 0 && plan.mission.home.is_none() {
        return Err(FlightError::BadFile("the table has no rows below its names; choose another".into()));
    }
    notes.add(NoteCode::NamesNotKept, if columns.has_name && columns.command.is_none() { count } else { 0 });
    plan.fence = Fence::from_items(&fence.items).map_err(|error| fence.at_its_line(error))?;
    plan.rally = Rally::from_items(&rally.items).map_err(|error| rally.at_its_line(error))?;
    Ok(plan)
}

/// A row of a table.
struct Row<'a> {
    fields: &'a StringRecord,
    columns: &'a Columns,
    has_decimal_commas: bool,
}

impl Row<'_> {
    fn text(&self, column: Option<usize>) -> &str {
        column.and_then(|column| self.fields.get(column)).unwrap_or_default()
    }

    /// A number; `None` where the field is empty.
    fn number(&self, column: Option<usize>, name: &str) -> std::result::Result<Option<f64>, String> {
        match self.text(column) {
            "" => Ok(None),
            text if self.has_decimal_commas => number(&text.replacen(',', ".", 1), name).map(Some),
            text => number(text, name).map(Some),
        }
    }

    fn whole(&self, column: Option<usize>, name: &str, max: u16) -> std::result::Result<Option<u16>, String> {
        match self.number(column, name)? {
            None => Ok(None),
            Some(value) if value.fract() == 0.0 && (0.0..=f64::from(max)).contains(&value) => Ok(Some(value as u16)),
            Some(value) => Err(format!("has {value} as its {name}; that is a whole number from 0 to {max}")),
        }
    }

    fn place(&self) -> std::result::Result<[Option<f64>; 3], String> {
        let columns = self.columns;
        Ok([
            self.number(Some(columns.lat), "latitude")?,
            self.number(Some(columns.lon), "longitude")?,
            self.number(columns.alt.map(|(column, _)| column), "altitude")?,
        ])
    }

    fn home(&self) -> std::result::Result<Home, String> {
        let [Some(lat_deg), Some(lon_deg), Some(alt_amsl_m)] = self.place()? else {
            return Err("is home, which needs a latitude, a longitude and an altitude above mean sea level".into());
        };
        let home = Home { lat_deg, lon_deg, alt_amsl_m };
        home.point().map_err(|error| error.to_string())?;
        Ok(home)
    }

    /// The item of a row; `None` for a row without command and place.
    fn item(&self, notes: &mut Notes) -> std::result::Result<Option<MissionItem>, String> {
        let columns = self.columns;
        let command = match self.text(columns.command) {
            "" => None,
            text => match Command::from_name(text) {
                Some(command) => Some(command),
                None if text.starts_with(|c: char| c.is_ascii_alphabetic()) => {
                    return Err(format!(
                        "has \"{}\" as its command; a MAV_CMD belongs there, by number or by name as in NAV_WAYPOINT",
                        shown(text)
                    ));
                }
                None => self.whole(columns.command, "command", u16::MAX)?.map(Command),
            },
        };
        let [lat, lon, alt] = self.place()?;
        if command.is_none() && lat.is_none() && lon.is_none() {
            return Ok(None);
        }
        let frame = match self.whole(columns.frame, "frame", 255)? {
            Some(number) => Some(MavFrame::from(number as u8)),
            None => columns.alt.and_then(|(_, frame)| frame),
        };
        let mut params = [None; 7];
        for (number, column) in columns.params.into_iter().enumerate() {
            params[number] = self.number(column, &format!("parameter {}", number + 1))?;
        }
        if command.is_none() {
            // columns that are missing have the values of a new waypoint
            params[..4].iter_mut().for_each(|param| *param = param.or(Some(0.0)));
            if lat.is_none() || lon.is_none() {
                return Err("has one of latitude and longitude; give both".into());
            }
        }
        (params[4], params[5], params[6]) = (lat, lon, alt);
        let autocontinue = match self.text(columns.autocontinue) {
            "" | "1" | "true" => true,
            "0" | "false" => false,
            other => return Err(format!("has \"{}\" as its autocontinue; that is true or false", shown(other))),
        };
        let item = MissionItem {
            command: command.unwrap_or(Command::NAV_WAYPOINT),
            frame: frame.unwrap_or(MavFrame::GlobalRelativeAlt),
            params,
            autocontinue,
        };
        if let Some(bad) = item.unsendable() {
            return Err(bad.to_string());
        }
        if item.command.is_destination() || item.command.is_takeoff() {
            notes.add(NoteCode::HeightsMissing, usize::from(alt.is_none()));
            notes.add(NoteCode::HeightsTakenAboveHome, usize::from(alt.is_some() && frame.is_none()));
        }
        Ok(Some(item))
    }
}

/// Writes a table.
pub(super) fn write_table(plan: &Plan) -> String {
    let Plan { mission: Mission { home, items }, fence, rally } = plan;
    let number =
        |value: Option<f64>| value.filter(|value| value.is_finite()).map_or_else(String::new, |v| v.to_string());
    let row = |name: String, item: &MissionItem| {
        let command = item.command.0.to_string();
        let mut row = vec![name, command, item.command.to_string(), item.frame.number().to_string()];
        row.extend(item.params.map(number));
        row.push(item.autocontinue.to_string());
        row
    };
    let mut table = Writer::from_writer(Vec::new());
    let mut write = |row: Vec<String>| table.write_record(row).expect("invariant: rows of one length go to memory");
    write(HEADER.iter().chain(&["autocontinue"]).map(|name| (*name).to_owned()).collect());
    if let Some(home) = home {
        write(row(HOME.into(), &home.to_item()));
    }
    for (index, item) in items.iter().enumerate() {
        write(row((index + 1).to_string(), item));
    }
    for item in fence.to_items().iter().chain(&rally.to_items()) {
        write(row(String::new(), item));
    }
    let bytes = table.into_inner().expect("invariant: memory is flushed without error");
    String::from_utf8(bytes).expect("invariant: a table of numbers and names is UTF-8")
}
