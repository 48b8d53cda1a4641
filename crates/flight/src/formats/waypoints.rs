//! "QGC WPL 110": a mission as lines of twelve columns, item 0 being home.
//!
//! Columns: index, current, frame, command, parameters 1 to 4, x (latitude), y (longitude), z (height),
//! autocontinue (<https://mavlink.io/en/file_formats/#mission_plain_text_file>).

use std::fmt::Write as _;

use crate::error::{FlightError, Result};
use crate::formats::{shown, text_of, too_many};
use crate::plan::{Command, Home, MavFrame, Mission, MissionItem};

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

/// Reads a mission.
///
/// Columns may be separated by tabs or spaces, lines end with LF or CRLF; empty lines and lines that begin
/// with `#` are skipped. The altitude frame of each item is kept. "NaN" in parameters 1 to 4 means unset.
///
/// # Errors
/// [`FlightError::BadLine`] with the line and what to do; [`FlightError::BadFile`] when it is no text file.
pub fn read_waypoints(bytes: &[u8]) -> Result<Mission> {
    let mut lines = text_of(bytes)?
        .lines()
        .enumerate()
        .map(|(index, line)| (index + 1, line.trim()))
        .filter(|(_, line)| !line.is_empty() && !line.starts_with('#'));

    let (line, header) = lines
        .next()
        .ok_or_else(|| FlightError::BadFile("the file holds nothing but comments; choose another".into()))?;
    let words: Vec<_> = header.split_whitespace().collect();
    match words.as_slice() {
        ["QGC", "WPL", "110"] => {}
        ["QGC", "WPL", version] => {
            return Err(bad(
                line,
                format!(
                    "is version {} of the format; only 110 is read, so save the mission again with a current ground station",
                    shown(version)
                ),
            ));
        }
        _ => {
            return Err(bad(line, format!("is \"{}\" where \"QGC WPL 110\" belongs", shown(header))));
        }
    }

    let mut mission = Mission::default();
    for (row, (line, text)) in lines.enumerate() {
        let item = read_row(text, row).map_err(|problem| bad(line, problem))?;
        if row == 0 {
            if item.command != Command::NAV_WAYPOINT {
                return Err(bad(
                    line,
                    format!(
                        "is {} where home belongs: the first line holds home as a waypoint (command 16); insert it",
                        item.command
                    ),
                ));
            }
            mission.home = Home::from_item(&item);
        } else {
            mission.items.push(item);
        }
        if let Some(problem) = too_many(mission.items.len()) {
            return Err(bad(line, problem));
        }
    }
    Ok(mission)
}

fn bad(line: usize, problem: String) -> FlightError {
    FlightError::BadLine { line, problem }
}

fn read_row(text: &str, expected: usize) -> std::result::Result<MissionItem, String> {
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
    if index != expected {
        return Err(format!("has index {index} where {expected} belongs; number the lines from 0 without gaps"));
    }
    whole(1, 255)?;
    let frame = MavFrame::from(whole(2, 255)? as u8);
    let command = Command(whole(3, u16::MAX)?);
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
        Ok(()) => Ok(item),
        Err(FlightError::BadItem { field, value, problem, .. }) => {
            Err(format!("({command}) has {value} as its {field}, {problem}"))
        }
        Err(other) => Err(other.to_string()),
    }
}

fn number(text: &str, column: &str) -> std::result::Result<f64, String> {
    match text.parse::<f64>() {
        Ok(value) if value.is_finite() => Ok(value),
        _ if text.contains(',') => {
            Err(format!("has \"{}\" as its {column}; write decimals with a point, not a comma", shown(text)))
        }
        _ => Err(format!("has \"{}\" as its {column}; a finite number belongs there", shown(text))),
    }
}

/// Writes a mission. An unknown home is written as 0/0; unset parameters as 0, as ArduPilot takes them.
#[must_use]
pub fn write_waypoints(mission: &Mission) -> String {
    let mut text = String::from("QGC WPL 110\n");
    let home = mission.home.unwrap_or(Home { lat_deg: 0.0, lon_deg: 0.0, alt_amsl_m: 0.0 }).to_item();
    for (index, item) in std::iter::once(&home).chain(&mission.items).enumerate() {
        let current = u8::from(index == 0);
        let _ = write!(text, "{index}\t{current}\t{}\t{}", item.frame.number(), item.command.0);
        for param in item.params {
            let _ = write!(text, "\t{}", param.unwrap_or(0.0));
        }
        let _ = writeln!(text, "\t{}", u8::from(item.autocontinue));
    }
    text
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use proptest::prelude::*;

    const SAMPLE: &str = "QGC WPL 110\n\
        0\t1\t0\t16\t0\t0\t0\t0\t40.33320000\t-3.79780000\t600.000000\t1\n\
        1\t0\t3\t22\t12.00000000\t0.00000000\t0.00000000\t0.00000000\t40.33320000\t-3.80133520\t60.000000\t1\n\
        2\t0\t10\t16\t0\t0\t0\tNaN\t40.3332\t-3.806049\t80\t1\n\
        3\t0\t2\t178\t0\t14\t-1\t0\t0\t0\t0\t1\n";

    #[test]
    fn a_mission_is_read() {
        let mission = read_waypoints(SAMPLE.as_bytes()).unwrap();
        assert_eq!(mission.home, Some(Home { lat_deg: 40.3332, lon_deg: -3.7978, alt_amsl_m: 600.0 }));
        assert_eq!(mission.items.len(), 3);
        assert_eq!(mission.items[0], MissionItem::takeoff(40.3332, -3.801_335_2, 60.0, 12.0));
        assert_eq!(mission.items[1].frame, MavFrame::GlobalTerrainAlt);
        assert_eq!(mission.items[1].params[3], None);
        assert_eq!(mission.items[2].command, Command::DO_CHANGE_SPEED);
    }

    #[test]
    fn separators_and_line_ends_do_not_matter() {
        let expected = read_waypoints(SAMPLE.as_bytes()).unwrap();
        let crlf = SAMPLE.replace('\n', "\r\n");
        let spaces = SAMPLE.replace('\t', "  ");
        let comments = SAMPLE.replacen('\n', "\n\n# by hand\n", 1);
        let bom = format!("\u{FEFF}{SAMPLE}");
        for variant in [crlf, spaces, comments, bom] {
            assert_eq!(read_waypoints(variant.as_bytes()).unwrap(), expected);
        }
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
            ("\n2\t", "\n7\t", "line 4: has index 7 where 2 belongs"),
            ("\t10\t16", "\t10\t70000", "line 4: has 70000 as its command"),
            ("\t10\t16", "\t10\t16.5", "line 4: has 16.5 as its command"),
            ("\t10\t16", "\t8\t16", "line 4: (NAV_WAYPOINT) has 8 as its frame"),
            ("\n0\t1\t0\t16", "\n0\t1\t0\t22", "line 2: is NAV_TAKEOFF where home belongs"),
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
            prop_assert_eq!(read_waypoints(write_waypoints(&mission).as_bytes()).unwrap(), mission);
        }

        #[test]
        fn any_text_is_read_or_refused(text in "(QGC WPL 110\n)?[0-9.,eE+\\-\t \nNa#]{0,400}") {
            let _ = read_waypoints(text.as_bytes());
        }

        // fault 53 (256 cases): any bytes as a plan
        #[test]
        fn any_bytes_are_read_or_refused(bytes in prop::collection::vec(any::<u8>(), 0..300)) {
            let _ = crate::formats::read_plan(&bytes, None);
            let _ = crate::formats::read_params(&bytes);
        }
    }
}
