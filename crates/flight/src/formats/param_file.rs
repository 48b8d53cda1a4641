//! Parameter files: `NAME,value` (Mission Planner), `NAME value` (MAVProxy) and the five columns of
//! QGroundControl.
//!
//! The three are told apart line by line. QGroundControl's columns are system id, component id, name,
//! value and `MAV_PARAM_TYPE`.

use std::collections::HashMap;
use std::fmt::Write as _;

use crate::error::{FlightError, Result};
use crate::formats::text::{shown, text_of};

/// Longest name that MAVLink carries, bytes.
pub const MAX_NAME_BYTES: usize = 16;

/// Most parameters in a file; a vehicle has about 1,400.
pub const MAX_PARAMS: usize = 20_000;

/// One parameter of a file.
#[derive(Debug, Clone, PartialEq)]
pub struct ParamEntry {
    /// Its name: 1 to 16 capital letters, digits and underscores.
    pub name: String,
    /// Its value, finite.
    pub value: f64,
    /// `MAV_PARAM_TYPE`, when the file says it.
    pub mav_param_type: Option<u8>,
}

/// Whose way of writing to follow.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum ParamDialect {
    /// `NAME,value`, as in `.param`.
    MissionPlanner,
    /// `NAME value`, as in `.parm`.
    MavProxy,
    /// Tab-separated with system, component and type, as in `.params`.
    QGroundControl,
}

/// Reads parameters in the order of the file. Text after `#` is a comment; `@READONLY` after a value, as
/// MAVProxy writes, is skipped.
///
/// # Errors
/// [`FlightError::BadLine`] for an invalid name or value, and for a name given twice with two values;
/// [`FlightError::BadFile`] when it is not a text file or has no parameter.
pub fn read_params(bytes: &[u8]) -> Result<Vec<ParamEntry>> {
    let mut entries: Vec<ParamEntry> = Vec::new();
    let mut places: HashMap<String, (usize, usize)> = HashMap::new(); // name → line, place in entries
    for (index, line) in text_of(bytes)?.lines().enumerate() {
        let line_number = index + 1;
        let bad = |problem: String| FlightError::BadLine { line: line_number, problem };
        let text = line.split('#').next().unwrap_or_default().trim();
        if text.is_empty() {
            continue;
        }
        let entry = read_line(text).map_err(bad)?;
        if let Some((line, place)) = places.get(&entry.name) {
            if entries[*place].value != entry.value {
                return Err(bad(format!(
                    "gives {} the value {}, line {line} gave it {}; delete one of the two",
                    entry.name, entry.value, entries[*place].value
                )));
            }
            continue;
        }
        if entries.len() == MAX_PARAMS {
            return Err(bad(format!("is one more than the {MAX_PARAMS} parameters that a file may hold")));
        }
        places.insert(entry.name.clone(), (line_number, entries.len()));
        entries.push(entry);
    }
    if entries.is_empty() {
        return Err(FlightError::BadFile("the file holds no parameter; choose another".into()));
    }
    Ok(entries)
}

fn read_line(text: &str) -> std::result::Result<ParamEntry, String> {
    let words: Vec<&str> = text
        .split(|c: char| c.is_whitespace() || c == ',' || c == '=')
        .filter(|word| !word.is_empty())
        .take(7)
        .collect();
    let starts_with_id = words.first().is_some_and(|word| word.parse::<u8>().is_ok());
    let (name, value, kind) = match words.as_slice() {
        [_, _, name, value, kind] if starts_with_id => (name, value, Some(kind)),
        [name, value] => (name, value, None),
        [name, value, "@READONLY"] => (name, value, None),
        [name, value, kind] if !text.contains(',') => (name, value, Some(kind)),
        [_, _, _] => {
            return Err("has a comma too many; write NAME,value with a point for decimals".into());
        }
        _ => {
            return Err(format!("\"{}\" is no parameter; write NAME,value or NAME value", shown(text)));
        }
    };
    let named = |c: char| c.is_ascii_uppercase() || c.is_ascii_digit() || c == '_';
    if name.len() > MAX_NAME_BYTES || !name.chars().all(named) {
        return Err(format!(
            "\"{}\" is not a parameter name: that is 1 to {MAX_NAME_BYTES} capital letters, digits and underscores",
            shown(name)
        ));
    }
    let value = value
        .parse::<f64>()
        .ok()
        .filter(|value| value.is_finite() && value.abs() <= f64::from(f32::MAX))
        .ok_or_else(|| format!("gives {name} the value \"{}\"; a finite number belongs there", shown(value)))?;
    let mav_param_type = kind
        .map(|kind| {
            kind.parse::<u8>()
                .ok()
                .filter(|kind| (1..=10).contains(kind))
                .ok_or_else(|| format!("gives {name} the type \"{}\"; MAV_PARAM_TYPE goes from 1 to 10", shown(kind)))
        })
        .transpose()?;
    Ok(ParamEntry { name: (*name).to_owned(), value, mav_param_type })
}

/// Writes parameters in the order given, one a line.
///
/// `MAV_PARAM_TYPE` is written for QGroundControl alone; 9 (32-bit float) where it is not known, with
/// system 1 and component 1.
pub fn write_params(entries: &[ParamEntry], dialect: ParamDialect) -> String {
    let mut text = String::new();
    if dialect == ParamDialect::QGroundControl {
        text.push_str("# Vehicle-Id\tComponent-Id\tName\tValue\tType\n");
    }
    for ParamEntry { name, value, mav_param_type } in entries {
        let _ = match dialect {
            ParamDialect::MissionPlanner => writeln!(text, "{name},{value}"),
            ParamDialect::MavProxy => writeln!(text, "{name:<16} {value}"),
            ParamDialect::QGroundControl => {
                writeln!(text, "1\t1\t{name}\t{value}\t{}", mav_param_type.unwrap_or(9))
            }
        };
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn entry(name: &str, value: f64, mav_param_type: Option<u8>) -> ParamEntry {
        ParamEntry { name: name.into(), value, mav_param_type }
    }

    #[test]
    fn the_three_dialects_are_read() {
        let text = "# comment\r\n#NOTE: x\nAIRSPEED_CRUISE,22\nARSPD_USE  1 # on\nRTL_ALTITUDE\t-1.5e1\n\
                    STAT_BOOTCNT 7 @READONLY\nWP_RADIUS = 90\n1\t1\tTKOFF_ALT\t50\t9\nSYSID 1 2\n\n";
        assert_eq!(
            read_params(text.as_bytes()).unwrap(),
            [
                entry("AIRSPEED_CRUISE", 22.0, None),
                entry("ARSPD_USE", 1.0, None),
                entry("RTL_ALTITUDE", -15.0, None),
                entry("STAT_BOOTCNT", 7.0, None),
                entry("WP_RADIUS", 90.0, None),
                entry("TKOFF_ALT", 50.0, Some(9)),
                entry("SYSID", 1.0, Some(2)),
            ]
        );
    }

    #[test]
    fn the_recorded_file_is_read_whole() {
        let bytes = include_bytes!("../../../../tests/fixtures/captures/arduplane-params.parm");
        let entries = read_params(bytes).unwrap();
        assert_eq!(entries.len(), 1_399);
        assert!(entries.iter().all(|entry| entry.mav_param_type.is_some()));
    }

    #[test]
    fn each_fault_is_named_with_its_line() {
        for (line, expected) in [
            ("AIRSPEED_CRUISE,22,5", "line 2: has a comma too many"),
            ("AIRSPEED_CRUISE", "line 2: \"AIRSPEED_CRUISE\" is no parameter"),
            ("airspeed 3", "line 2: \"airspeed\" is not a parameter name"),
            ("A_NAME_OF_17_CHARS 3", "line 2: \"A_NAME_OF_17_CHARS\" is not a parameter name"),
            ("A nan", "line 2: gives A the value \"nan\""),
            ("A 1e39", "line 2: gives A the value \"1e39\""),
            ("A 1e999", "line 2: gives A the value \"1e999\""),
            ("A 0x10", "line 2: gives A the value \"0x10\""),
            ("1 1 A 5 77", "line 2: gives A the type \"77\""),
            ("B 2", "line 2: gives B the value 2, line 1 gave it 1"),
        ] {
            let error = read_params(format!("B 1\n{line}\n").as_bytes()).unwrap_err().to_string();
            assert!(error.starts_with(expected), "{error}");
        }
        assert_eq!(read_params(b"B 1\nB 1.0\n").unwrap().len(), 1);
        assert!(read_params(b"# nothing\n").unwrap_err().to_string().contains("no parameter"));
    }

    proptest! {
        #[test]
        fn parameters_survive_the_file(
            values in prop::collection::btree_map("[A-Z][A-Z0-9_]{0,15}", (any::<f32>().prop_filter("finite", |v| v.is_finite()), 1..=10_u8), 1..40),
            dialect in prop::sample::select(vec![ParamDialect::MissionPlanner, ParamDialect::MavProxy, ParamDialect::QGroundControl]),
        ) {
            let typed = dialect == ParamDialect::QGroundControl;
            let entries: Vec<_> = values.into_iter()
                .map(|(name, (value, kind))| entry(&name, f64::from(value), typed.then_some(kind)))
                .collect();
            prop_assert_eq!(read_params(write_params(&entries, dialect).as_bytes()).unwrap(), entries);
        }
    }
}
