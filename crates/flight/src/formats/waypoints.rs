//! "QGC WPL 110": a mission, a fence or rally points as lines of twelve columns, item 0 being home.
//!
//! Columns: index, current, frame, command, parameters 1 to 4, x (latitude), y (longitude), z (height),
//! autocontinue (<https://mavlink.io/en/file_formats/#mission_plain_text_file>).
//!
//! Undocumented practice of the programs that write it: Mission Planner begins a fence or rally list with home too, at
//! times twice, and home without a position has command 0; MAVProxy's fence and rally lists have no home, nor have
//! missions that a companion wrote for PX4 (the first line is the take-off) or saved without item 0 (the first index is
//! 1). Version 120, of old QGroundControl, never has home. All of them go by the order of the lines, not by the index.
//! A line belongs to the list of its command, so a file with several lists in it is read whole.

use std::fmt::Write as _;

use crate::error::{FlightError, Plain, Result};
use crate::formats::notes::{NoteCode, Notes};
use crate::formats::plan_file::{PlanFile, PlanFormat, PlanSettings};
use crate::formats::text::{number, shown, text_of, too_many};
use crate::plan::{Category, Command, Fence, Home, MavFrame, Mission, MissionItem, Plan, PlanKind, Rally};

const COLUMNS: [&str; 12] = [
    "index",
    "current",
    "frame",
    "command",
    "parameter 1",
    "parameter 2",
    "parameter 3",
    "parameter 4",
    "latitude",
    "longitude",
    "height",
    "autocontinue",
];

/// A line that holds an item.
struct Row {
    line: usize,
    index: usize,
    item: MissionItem,
}

/// Reads the mission, fence and rally points of a file: the command of a line says to which list it belongs.
///
/// Columns may be separated by tabs or spaces, lines end with LF or CRLF; empty lines and what follows a `#` are
/// skipped. The altitude frame of each item is kept. "NaN" in parameters 1 to 4 means unset. The first line is home
/// when its index is 0 and it is a waypoint; home is unknown if that line is not in frame 0 (mean sea level). The order
/// of the lines counts; a `DO_JUMP` goes to the line with the index that it names, though numbers between may be
/// missing. A note tells where the items are not numbered in sequence.
///
/// # Errors
/// [`FlightError::BadLine`] with the line and what to do; [`FlightError::BadFile`] when it is not a text file.
pub fn read_waypoints(bytes: &[u8]) -> Result<PlanFile> {
    let mut lines = text_of(bytes)?
        .lines()
        .enumerate()
        .map(|(index, line)| (index + 1, line.split('#').next().unwrap_or_default().trim()))
        .filter(|(_, line)| !line.is_empty());

    let (line, header) = lines
        .next()
        .ok_or_else(|| FlightError::BadFile("the file holds nothing but comments; choose another".into()))?;
    let words: Vec<_> = header.split_whitespace().collect();
    let may_have_home = match words.as_slice() {
        ["QGC", "WPL", "110"] => true,
        ["QGC", "WPL", "120"] => false,
        ["QGC", "WPL", version] => {
            return Err(bad(
                line,
                format!(
                    "is version {} of the format; 110 and 120 are read, so save the mission again with a current ground station",
                    shown(version)
                ),
            ));
        }
        _ => {
            return Err(bad(line, format!("is \"{}\" where \"QGC WPL 110\" belongs", shown(header))));
        }
    };

    let mut rows: Vec<Row> = Vec::new();
    let mut home: Option<MissionItem> = None;
    let mut notes = Notes::default();
    let mut previous = None;
    for (place, (line, text)) in lines.enumerate() {
        let row = read_row(line, text, may_have_home && place == 0).map_err(|problem| bad(line, problem))?;
        let is_next = previous.replace(row.index).is_none_or(|previous| row.index == previous + 1);
        notes.add(NoteCode::ItemsRenumbered, usize::from(!is_next));
        if may_have_home && place == 0 && row.index == 0 && row.item.command == Command::NAV_WAYPOINT {
            home = Some(row.item);
            continue;
        }
        rows.push(row);
        if let Some(problem) = too_many(rows.len()) {
            return Err(bad(line, problem));
        }
    }
    let is_home_in_file = home.is_some();
    drop_second_home(&mut rows, home.as_ref().and_then(Home::from_item));
    follow_jumps(&mut rows, is_home_in_file)?;
    // Home's height must be above mean sea level; another one leaves home unknown.
    let home = home.filter(|item| item.frame == MavFrame::Global).as_ref().and_then(Home::from_item);
    let mut plan = Plan::from_mission(Mission { home, items: Vec::new() });
    let (mut fence, mut rally) = (List::default(), List::default());
    for row in rows {
        match kind_of(row.item.command) {
            PlanKind::Mission => plan.mission.items.push(row.item),
            PlanKind::Fence => fence.push(row.line, row.item),
            PlanKind::Rally => rally.push(row.line, row.item),
        }
    }
    plan.fence = Fence::from_items(&fence.items).map_err(|error| fence.at_its_line(error))?;
    plan.rally = Rally::from_items(&rally.items).map_err(|error| rally.at_its_line(error))?;
    Ok(PlanFile { plan, settings: PlanSettings::default(), format: PlanFormat::Waypoints, notes: notes.into_vec() })
}

/// The items of a fence or rally list, and their lines.
#[derive(Default)]
pub(super) struct List {
    pub(super) items: Vec<MissionItem>,
    lines: Vec<usize>,
}

impl List {
    pub(super) fn push(&mut self, line: usize, item: MissionItem) {
        self.items.push(item);
        self.lines.push(line);
    }

    /// A fault of the list as one of the line.
    pub(super) fn at_its_line(&self, error: FlightError) -> FlightError {
        match error {
            FlightError::BadFence { index, problem } | FlightError::BadRally { index, problem } => {
                bad(self.lines.get(index).copied().unwrap_or_default(), problem)
            }
            other => other,
        }
    }
}

/// The list to which a command belongs.
pub(super) fn kind_of(command: Command) -> PlanKind {
    match command.info().map(|info| info.category) {
        Some(Category::Fence) => PlanKind::Fence,
        Some(Category::Rally) => PlanKind::Rally,
        _ => PlanKind::Mission,
    }
}

/// Mission Planner repeats home before a fence that it read together with home: that line is not a waypoint.
fn drop_second_home(rows: &mut Vec<Row>, home: Option<Home>) {
    const SAME_DEG: f64 = 1e-6;
    let [first, others @ ..] = rows.as_slice() else { return };
    let is_home = first.item.command == Command::NAV_WAYPOINT
        && home.is_some_and(|home| {
            let near = |value: Option<f64>, deg: f64| value.is_some_and(|value| (value - deg).abs() < SAME_DEG);
            near(first.item.lat_deg(), home.lat_deg) && near(first.item.lon_deg(), home.lon_deg)
        });
    if is_home && !others.is_empty() && others.iter().all(|row| kind_of(row.item.command) != PlanKind::Mission) {
        rows.remove(0);
    }
}

/// A jump names the index of a line; in a mission it names a seq, which is 1 for the first item.
///
/// With numbers missing, as after deleting lines by hand, the index is meant: it still names the item that it named
/// before. Where the numbers do not increase, the target of a jump is ambiguous.
fn follow_jumps(rows: &mut [Row], is_home_in_file: bool) -> Result<()> {
    let Some(first) = rows.first().map(|row| row.index) else { return Ok(()) };
    let first_number = if is_home_in_file { 1 } else { first.min(1) };
    let is_whole = rows.iter().enumerate().all(|(place, row)| row.index == first_number + place);
    let of_the_file = first_number as f64..=(first_number + rows.len() - 1) as f64;
    let disorder =
        rows.windows(2).find(|pair| pair[1].index <= pair[0].index).map(|pair| (pair[1].line, pair[1].index));
    let mission = rows.iter().filter(|row| kind_of(row.item.command) == PlanKind::Mission);
    let numbers: Vec<f64> = mission.map(|row| row.index as f64).collect();
    for row in rows.iter_mut().filter(|row| row.item.command == Command::DO_JUMP) {
        let Some(target) = row.item.params[0].as_mut() else { continue };
        if let Some((line, index)) = disorder {
            return Err(bad(
                row.line,
                format!(
                    "(DO_JUMP) jumps to {target}, but which item is that? Line {line} has index {index} again or too late; number the lines in their order"
                ),
            ));
        }
        *target = match numbers.iter().position(|number| number == target) {
            Some(place) => (place + 1) as f64,
            // beyond the end or before the beginning: reported by the checks
            None if is_whole && !of_the_file.contains(target) => *target + (1 - first_number) as f64,
            None => {
                return Err(bad(
                    row.line,
                    format!(
                        "(DO_JUMP) jumps to {target}, but no item of the mission has that index; write the index of the item that it shall go to"
                    ),
                ));
            }
        };
    }
    Ok(())
}

fn bad(line: usize, problem: String) -> FlightError {
    FlightError::BadLine { line, problem }
}

fn read_row(line: usize, text: &str, may_be_home: bool) -> std::result::Result<Row, String> {
    let columns: Vec<&str> = text.split_whitespace().take(COLUMNS.len() + 1).collect();
    if columns.len() != COLUMNS.len() {
        if text.matches(',').count() >= COLUMNS.len() - 1 {
            return Err("separates its columns by commas; separate them by tabs".into());
        }
        let count = if columns.len() > COLUMNS.len() { "more than 12".into() } else { columns.len().to_string() };
        return Err(format!(
            "has {count} columns; each line needs 12: index, current, frame, command, 4 parameters, latitude, longitude, height, autocontinue"
        ));
    }
    let whole = |column: usize, max: u16| {
        // some programs write whole numbers as "16.000000"
        let value = number(columns[column], COLUMNS[column])?;
        if value.fract() != 0.0 || !(0.0..=f64::from(max)).contains(&value) {
            return Err(format!(
                "has {} as its {}; that is a whole number from 0 to {max}",
                shown(columns[column]),
                COLUMNS[column]
            ));
        }
        Ok(value as u16)
    };
    let index = usize::from(whole(0, u16::MAX)?);
    whole(1, 255)?;
    let frame = MavFrame::from(whole(2, 255)? as u8);
    let command = match Command(whole(3, u16::MAX)?) {
        // Mission Planner's home that was never set
        Command(0) if may_be_home && index == 0 => Command::NAV_WAYPOINT,
        other => other,
    };
    let autocontinue = whole(11, 255)? != 0;
    let mut params = [None; 7];
    for (position, param) in params.iter_mut().enumerate() {
        let column = position + 4;
        let unset = position < 4 && columns[column].eq_ignore_ascii_case("nan");
        *param = if unset { None } else { Some(number(columns[column], COLUMNS[column])?) };
    }
    let item = MissionItem { command, frame, params, autocontinue };
    // seq is not shown: the line is
    match item.check_sendable(vencejo_proto::MissionSeq(index as u16)) {
        Ok(()) => Ok(Row { line, index, item }),
        Err(FlightError::BadItem { field, value, problem, .. }) => {
            Err(format!("({command}) has {} as its {field}, {problem}", Plain(value)))
        }
        Err(other) => Err(other.to_string()),
    }
}

/// Whether a list of rows holds a mission: a row is of the list that its command belongs to.
///
/// # Errors
/// [`FlightError::BadFile`] for an item of a fence or a rally point in a mission.
pub(super) fn check_lists(mission: &Mission) -> Result<()> {
    let mut items = mission.items.iter().enumerate();
    items.find(|(_, item)| kind_of(item.command) != PlanKind::Mission).map_or(Ok(()), |(index, item)| {
        Err(FlightError::BadFile(format!(
            "item {} of the mission is {}, which such a file has in a list of its own; delete it, or save the plan as .plan",
            index + 1,
            item.command
        )))
    })
}

/// Writes the mission of a plan; of one without a mission its fence, else its rally points.
///
/// An unknown home is written as 0/0, an unset parameter as it is sent: "NaN" where the command knows it (heading of a
/// waypoint, take-off or landing), else 0.
///
/// # Errors
/// [`FlightError::BadFile`] for a fence and rally points without a mission: a file holds one of the two; and for an
/// item of a fence or a rally point in a mission, which would be read as another list.
pub fn write_waypoints(plan: &Plan) -> Result<String> {
    let Plan { mission, fence, rally } = plan;
    let points = match (mission.items.is_empty(), fence.is_empty(), rally.points.is_empty()) {
        (true, false, false) => {
            return Err(FlightError::BadFile(
                "a .waypoints file holds a mission, a fence or rally points, this is a fence with rally points; save it as .plan".into(),
            ));
        }
        (true, false, true) => fence.to_items(),
        (true, true, false) => rally.to_items(),
        _ => Vec::new(),
    };
    check_lists(mission)?;
    let mut text = String::from("QGC WPL 110\n");
    let home = mission.home.unwrap_or(Home { lat_deg: 0.0, lon_deg: 0.0, alt_amsl_m: 0.0 }).to_item();
    for (index, item) in std::iter::once(&home).chain(&mission.items).chain(&points).enumerate() {
        let current = u8::from(index == 0);
        let _ = write!(text, "{index}\t{current}\t{}\t{}", item.frame.number(), item.command.0);
        for (place, param) in item.params.into_iter().enumerate() {
            let _ = match param {
                Some(value) => write!(text, "\t{value}"),
                None if item.command.param_may_be_unset(place) => write!(text, "\tNaN"),
                None => write!(text, "\t0"),
            };
        }
        let _ = writeln!(text, "\t{}", u8::from(item.autocontinue));
    }
    Ok(text)
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use crate::formats::{PlanFormat, PlanSettings, write_plan};
    use proptest::prelude::*;

    const SAMPLE: &str = "QGC WPL 110\n\
        0\t1\t0\t16\t0\t0\t0\t0\t40.33320000\t-3.79780000\t600.000000\t1\n\
        1\t0\t3\t22\t12.00000000\t0.00000000\t0.00000000\t0.00000000\t40.33320000\t-3.80133520\t60.000000\t1\n\
        2\t0\t10\t16\t0\t0\t0\tNaN\t40.3332\t-3.806049\t80\t1\n\
        3\t0\t2\t178\t0\t14\t-1\t0\t0\t0\t0\t1\n";

    #[test]
    fn an_item_of_another_list_is_not_written_among_those_of_a_mission() {
        let circle = MissionItem::at(Command::NAV_FENCE_CIRCLE_INCLUSION, [0.0; 4], 40.0, -3.0, 0.0);
        let items = vec![MissionItem::waypoint(40.0, -3.0, 80.0), circle];
        let plan = Plan::from_mission(Mission { home: None, items });
        for format in [PlanFormat::Waypoints, PlanFormat::Csv] {
            let error = write_plan(&plan, &PlanSettings::default(), format).unwrap_err().to_string();
            assert!(error.contains("item 2 of the mission is NAV_FENCE_CIRCLE_INCLUSION"), "{error}");
        }
    }

    #[test]
    fn a_mission_is_read() {
        let mission = read_waypoints(SAMPLE.as_bytes()).unwrap().plan.mission;
        assert_eq!(mission.home, Some(Home { lat_deg: 40.3332, lon_deg: -3.7978, alt_amsl_m: 600.0 }));
        assert_eq!(mission.items.len(), 3);
        assert_eq!(mission.items[0], MissionItem::takeoff(40.3332, -3.801_335_2, 60.0, 12.0));
        assert_eq!(mission.items[1].frame, MavFrame::GlobalTerrainAlt);
        // Home's height has to count from the sea.
        let relative = SAMPLE.replacen("0\t1\t0\t16", "0\t1\t3\t16", 1);
        let mission = read_waypoints(relative.as_bytes()).unwrap().plan.mission;
        assert_eq!((mission.home, mission.items.len()), (None, 3));
        assert_eq!(mission.items[1].params[3], None);
        assert_eq!(mission.items[2].command, Command::DO_CHANGE_SPEED);
    }

    #[test]
    fn separators_and_line_ends_do_not_matter() {
        let expected = read_waypoints(SAMPLE.as_bytes()).unwrap();
        let crlf = SAMPLE.replace('\n', "\r\n");
        let spaces = SAMPLE.replace('\t', "  ");
        let comments = SAMPLE.replacen('\n', "\n\n# by hand\n", 1).replacen("80\t1\n", "80\t1 # turn here\n", 1);
        let bom = format!("\u{FEFF}{SAMPLE}");
        for variant in [crlf, spaces, comments, bom] {
            assert_eq!(read_waypoints(variant.as_bytes()).unwrap(), expected);
        }
    }

    #[test]
    fn a_jump_goes_to_the_index_that_it_names_and_a_break_in_the_indices_is_noted() {
        let rows = |indices: [u16; 4], command: &str| {
            let mut text = "QGC WPL 110\n0 1 0 16 0 0 0 0 40 -3 600 1\n".to_owned();
            for (place, index) in indices.into_iter().enumerate() {
                let _ = writeln!(text, "{index} 0 3 16 0 0 0 0 40.{place} -3 50 1");
            }
            let _ = writeln!(text, "{} 0 3 {command} 1", indices[3] + 1);
            let file = read_waypoints(text.as_bytes()).unwrap();
            let notes: Vec<_> = file.notes.iter().map(|note| (note.code, note.count)).collect();
            (file.plan.mission.items[4].params[0], notes)
        };
        let jump = "177 4 2 0 0 0 0 0";
        assert_eq!(rows([1, 2, 3, 4], jump), (Some(4.0), vec![]));
        assert_eq!(rows([1, 2, 4, 5], jump), (Some(3.0), vec![(NoteCode::ItemsRenumbered, 1)]));
        // in disorder, but no jump asks for an index
        assert_eq!(rows([7, 3, 3, 4], "20 0 0 0 0 0 0 0").1, [(NoteCode::ItemsRenumbered, 3)]);
    }

    #[test]
    fn each_fault_is_named_with_its_line() {
        let cases = [
            ("QGC WPL 110", "QGC WPL 100", "line 1: is version 100"),
            ("QGC WPL 110", "WPL", "line 1: is \"WPL\""),
            (
                "40.3332\t-3.806049",
                "40,3332\t-3.806049",
                "line 4: has \"40,3332\" as its latitude; write decimals with a point",
            ),
            ("-3.806049", "-183.806049", "line 4: (NAV_WAYPOINT) has -183.806049 as its y"),
            ("\t80\t1", "\tNaN\t1", "line 4: has \"NaN\" as its height"),
            ("\t80\t1", "\t1e999\t1", "line 4: has \"1e999\" as its height"),
            ("\t80\t1", "\t80", "line 4: has 11 columns"),
            ("\t80\t1", "\t80\t1\t1", "line 4: has more than 12 columns"),
            (
                "178\t0\t14",
                "177\t1\t14\t0\t0\t0\t0\t0\t1\n3\t0\t2\t178\t0\t14",
                "line 5: (DO_JUMP) jumps to 1, but which item is that? Line 6 has index 3 again",
            ),
            (
                "178\t0\t14",
                "177\t5\t14\t0\t0\t0\t0\t0\t1\n7\t0\t2\t178\t0\t14",
                "line 5: (DO_JUMP) jumps to 5, but no item of the mission has that index",
            ),
            ("2\t178\t0", "1\t5100\t0", "line 5: (NAV_RALLY_POINT) has 1 as its frame"),
            ("\t10\t16", "\t10\t70000", "line 4: has 70000 as its command"),
            ("\t10\t16", "\t10\t16.5", "line 4: has 16.5 as its command"),
            ("\t10\t16", "\t8\t16", "line 4: (NAV_WAYPOINT) has 8 as its frame"),
        ];
        for (from, to, expected) in cases {
            assert!(SAMPLE.contains(from), "{from}");
            let error = read_waypoints(SAMPLE.replacen(from, to, 1).as_bytes()).unwrap_err().to_string();
            assert!(error.starts_with(expected), "{error}");
        }
        let commas = SAMPLE.replace('\t', ",");
        assert!(read_waypoints(commas.as_bytes()).unwrap_err().to_string().contains("by tabs"));
    }

    #[test]
    fn too_many_items_are_refused() {
        let mut text = String::from("QGC WPL 110\n");
        for index in 0..=crate::plan::MAX_ITEMS + 1 {
            let _ = writeln!(text, "{index} 0 3 16 0 0 0 0 40 -3 50 1");
        }
        assert!(read_waypoints(text.as_bytes()).unwrap_err().to_string().contains("at most 10000"));
    }

    pub(crate) fn missions() -> impl Strategy<Value = Mission> {
        let commands: Vec<Command> = crate::plan::command::COMMANDS
            .iter()
            .filter(|info| info.support != crate::plan::Support::List && info.command != Command::DO_JUMP)
            .map(|info| info.command)
            .collect();
        let frames = vec![MavFrame::Global, MavFrame::GlobalRelativeAlt, MavFrame::GlobalTerrainAlt];
        let item = (
            prop::sample::select(commands),
            prop::sample::select(frames),
            prop::array::uniform4(-1e6..1e6_f64),
            (-90.0..=90.0_f64, -180.0..=180.0_f64, -500.0..9_000.0_f64),
            any::<bool>(),
        )
            .prop_map(|(command, frame, [p1, p2, p3, p4], (x, y, z), autocontinue)| MissionItem {
                command,
                frame,
                params: [p1, p2, p3, p4, x, y, z].map(Some),
                autocontinue,
            });
        let home = (-90.0..=90.0_f64, 0.001..=180.0_f64, -400.0..5_000.0_f64)
            .prop_map(|(lat_deg, lon_deg, alt_amsl_m)| Home { lat_deg, lon_deg, alt_amsl_m });
        (prop::option::of(home), prop::collection::vec(item, 0..20)).prop_map(|(home, items)| Mission { home, items })
    }

    proptest! {
        // fault 50 (256 cases): random missions written and read as .waypoints: equal
        #[test]
        fn a_mission_survives_the_file(mission in missions()) {
            let plan = Plan::from_mission(mission);
            prop_assert_eq!(read_waypoints(write_waypoints(&plan).unwrap().as_bytes()).unwrap().plan, plan);
        }

        #[test]
        fn any_text_is_read_or_refused(text in "(QGC WPL 1[12]0\n|RALLY |[0-9]{2} [0-9]{2}\n)?[0-9.,eE+\\-\t \nNa#]{0,400}") {
            let _ = crate::formats::read_plan(text.as_bytes(), None);
        }

        #[test]
        fn any_rows_are_refused_or_keep_their_meaning(
            version in "1[12]0",
            rows in prop::collection::vec(
                (0..4_u8, prop::sample::select(vec![0_u16, 16, 16, 22, 177, 5000, 5001, 5001, 5002, 5003, 5100]), 0..5_u8, "40|NaN|-?[0-9]{1,2}"), 0..9,
            ),
            is_numbered: bool,
            first in 0..2_usize,
        ) {
            let mut text = format!("QGC WPL {version}\n");
            for (place, (index, command, param, lat)) in rows.into_iter().enumerate() {
                let index = if is_numbered { place + first } else { usize::from(index) };
                let _ = writeln!(text, "{index} 0 3 {command} {param} 0 0 NaN {lat} -3 50 1");
            }
            if let Ok(Plan { mission, fence, rally }) = read_waypoints(text.as_bytes()).map(|file| file.plan) {
                // one file for each list
                let home = Plan::from_mission(Mission { home: mission.home, items: Vec::new() });
                for part in [Plan::from_mission(mission), Plan { fence, ..home.clone() }, Plan { rally, ..home.clone() }] {
                    let again = read_waypoints(write_waypoints(&part).unwrap().as_bytes()).unwrap().plan;
                    prop_assert_eq!(again.fence, part.fence);
                    prop_assert_eq!(again.rally, part.rally);
                    prop_assert_eq!(again.mission.items.len(), part.mission.items.len());
                    prop_assert_eq!(again.mission.home, part.mission.home);
                }
            }
        }

        // fault 53 (256 cases): any bytes as a plan
        #[test]
        fn any_bytes_are_read_or_refused(bytes in prop::collection::vec(any::<u8>(), 0..300)) {
            let _ = crate::formats::read_plan(&bytes, None);
            let _ = crate::formats::read_params(&bytes);
        }
    }
}
