//! Stored history of remote aircraft: the files of a fleet's history (`.mcap`), and their gaps. File names contain the
//! aircraft's name; other files are not shown. Names from clients are compared with existing ones, never used as paths.
//!
//! The files of each fleet are in `ground/FLEET`, with an inventory of record numbers (`NAME.json`) for each aircraft;
//! those recorded by this computer itself are in `board`.

use std::collections::BTreeMap;
use std::fs;
use std::io;
use std::path::{Path, PathBuf};
use std::time::UNIX_EPOCH;

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

/// Place of the history that this computer records on board. No fleet has such a name.
pub const BOARD: &str = "_board";
const ENDING: &str = ".mcap";
const NOTE: &str = ".json";

/// A history file (MCAP).
#[derive(Debug, Clone, PartialEq, Serialize, ToSchema)]
pub struct HistoryFile {
    /// File name.
    pub name: String,
    /// File size.
    pub bytes: u64,
    /// Time of the last change, seconds since 1970; null when the file system does not provide it.
    #[schema(required = true)]
    pub modified_unix_s: Option<f64>,
}

/// A range of records that is missing in a history.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, ToSchema)]
pub struct HistoryGap {
    /// Boot of the onboard computer: 16 hexadecimal digits.
    pub boot: String,
    /// `state`, `event` or `audit`.
    pub stream: String,
    /// First missing number.
    pub first: u64,
    /// Last missing number.
    pub last: u64,
    /// Whether the aircraft no longer has them either; otherwise they are fetched when it is connected.
    pub is_lost: bool,
}

/// Stored history of one aircraft.
#[derive(Debug, Clone, PartialEq, Serialize, ToSchema)]
pub struct AircraftHistory {
    /// The fleet, or `_board` for the history that this computer records on board an aircraft.
    pub place: String,
    /// Name of the aircraft.
    pub name: String,
    /// Files by name, which is also by time if the clock was set.
    pub files: Vec<HistoryFile>,
    /// Total number of records of each stream that were stored; some may have been deleted since, to make room. Empty
    /// when there is no inventory, as on board, where everything is recorded.
    pub records: BTreeMap<String, u64>,
    /// Ranges missing on the ground; null when there is no inventory.
    #[schema(required = true)]
    pub gaps: Option<Vec<HistoryGap>>,
    /// Why the gaps are unknown, in English: the inventory is damaged.
    #[schema(required = true)]
    pub problem: Option<String>,
}

#[derive(Deserialize)]
struct Note {
    streams: Vec<NotedStream>,
}

#[derive(Deserialize)]
struct NotedStream {
    boot: String,
    stream: String,
    have: Vec<(u64, u64)>,
    lost: Vec<(u64, u64)>,
}

fn none_where_missing<T: Default>(result: io::Result<T>) -> io::Result<T> {
    match result {
        Err(error) if error.kind() == io::ErrorKind::NotFound => Ok(T::default()),
        result => result,
    }
}

/// The folders below the top one, by place.
fn places(top: &Path) -> io::Result<Vec<(String, PathBuf)>> {
    let mut places = vec![(BOARD.to_owned(), top.join("board"))];
    let fleets = none_where_missing(fs::read_dir(top.join("ground")).map(Some))?;
    for entry in fleets.into_iter().flatten() {
        let entry = entry?;
        if let (Ok(name), true) = (entry.file_name().into_string(), entry.path().is_dir()) {
            places.push((name, entry.path()));
        }
    }
    places.sort();
    Ok(places)
}

/// Names of the regular files in a folder; empty if the folder does not exist.
fn files(folder: &Path) -> io::Result<Vec<HistoryFile>> {
    let mut found = Vec::new();
    for entry in none_where_missing(fs::read_dir(folder).map(Some))?.into_iter().flatten() {
        let entry = entry?;
        let Ok(name) = entry.file_name().into_string() else { continue };
        // Skips files deleted meanwhile, and symbolic links, which are not ours.
        let Ok(metadata) = entry.metadata() else { continue };
        if metadata.is_file() {
            let modified = metadata.modified().ok().and_then(|at| at.duration_since(UNIX_EPOCH).ok());
            let modified_unix_s = modified.map(|since| since.as_secs_f64());
            found.push(HistoryFile { name, bytes: metadata.len(), modified_unix_s });
        }
    }
    found.sort_by(|a, b| a.name.cmp(&b.name));
    Ok(found)
}

/// Aircraft name in a file name `NAME_TIME.mcap`.
fn aircraft_of(name: &str) -> Option<&str> {
    name.strip_suffix(ENDING)?.rsplit_once('_').map(|(aircraft, _)| aircraft).filter(|aircraft| !aircraft.is_empty())
}

/// Stored histories, by place and name. Reads the disk.
///
/// # Errors
/// When a folder cannot be read.
pub fn list(top: &Path) -> io::Result<Vec<AircraftHistory>> {
    let in_places = places(top)?.into_iter().map(|(place, folder)| in_folder(&place, &folder));
    Ok(in_places.collect::<io::Result<Vec<_>>>()?.concat())
}

/// Stored histories in the folder of one place, by name. Reads the disk.
///
/// # Errors
/// When it cannot be read.
pub fn in_folder(place: &str, folder: &Path) -> io::Result<Vec<AircraftHistory>> {
    let mut kept = BTreeMap::new();
    for file in files(folder)? {
        let name =
            aircraft_of(&file.name).or_else(|| file.name.strip_suffix(NOTE).filter(|name| !name.starts_with('.')));
        let Some(name) = name.map(ToOwned::to_owned) else { continue };
        let aircraft = kept.entry(name.clone()).or_insert_with(|| AircraftHistory {
            place: place.to_owned(),
            name,
            files: Vec::new(),
            records: BTreeMap::new(),
            gaps: None,
            problem: None,
        });
        if file.name.ends_with(ENDING) {
            aircraft.files.push(file);
        } else {
            take_note(&folder.join(&file.name), aircraft);
        }
    }
    Ok(kept.into_values().collect())
}

/// Path of a history file by place and name, if it exists. Reads the disk.
///
/// # Errors
/// When a folder cannot be read.
pub fn find(top: &Path, place: &str, name: &str) -> io::Result<Option<PathBuf>> {
    let Some((_, folder)) = places(top)?.into_iter().find(|(known, _)| known == place) else { return Ok(None) };
    let known = files(&folder)?.into_iter().find(|file| file.name == name && aircraft_of(&file.name).is_some());
    Ok(known.map(|file| folder.join(file.name)))
}

/// Adds the inventory to an aircraft's history.
fn take_note(path: &Path, aircraft: &mut AircraftHistory) {
    let read = fs::read(path).and_then(|bytes| serde_json::from_slice::<Note>(&bytes).map_err(io::Error::from));
    let noted = match read {
        Ok(noted) => noted,
        Err(error) => {
            let name = path.file_name().unwrap_or_default().display();
            aircraft.problem = Some(format!("{name} is damaged ({error}); move it away, and a new one is created"));
            return;
        }
    };
    let mut gaps = Vec::new();
    for NotedStream { boot, stream, have, lost } in noted.streams {
        let count: u64 = have.iter().map(|(first, last)| last.saturating_sub(*first).saturating_add(1)).sum();
        *aircraft.records.entry(stream.clone()).or_default() += count;
        let gap =
            |(first, last), is_lost| HistoryGap { boot: boot.clone(), stream: stream.clone(), first, last, is_lost };
        gaps.extend(lost.iter().map(|span| gap(*span, true)));
        // Numbers that are neither stored nor lost, from 1 on, may still be fetched.
        let mut known: Vec<_> = have.iter().chain(&lost).copied().collect();
        known.sort_unstable();
        let mut next = 1;
        for (first, last) in known {
            if first > next {
                gaps.push(gap((next, first - 1), false));
            }
            next = next.max(last.saturating_add(1));
        }
    }
    aircraft.gaps = Some(gaps);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_kept_is_listed_with_its_gaps_and_nothing_else_is_given() {
        let top = std::env::temp_dir().join(format!("vencejo-history-{}", std::process::id()));
        let (acme, board) = (top.join("ground/acme"), top.join("board"));
        assert_eq!(list(&top).expect("nothing yet"), []);
        for folder in [&acme, &board] {
            fs::create_dir_all(folder).expect("a folder");
        }
        for (folder, name) in [
            (&acme, "plane7_2026-11-25T08-00-00Z.mcap"),
            (&acme, "plane7_2026-11-25T09-00-00Z.mcap"),
            (&acme, "secret.txt"),
            (&acme, "_.mcap"),
            (&board, "plane7_2026-11-25T08-00-00Z.mcap"),
        ] {
            fs::write(folder.join(name), [7; 10]).expect("written");
        }
        let note = r#"{"format":1,"streams":[{"boot":"00000000000000aa","stream":"state","have":[[3,4],[9,9]],"lost":[[7,8]]}]}"#;
        fs::write(acme.join("plane7.json"), note).expect("written");
        fs::write(acme.join("plane8.json"), r#"{"format":1,"streams":[]}"#).expect("written");
        let kept = list(&top).expect("listed");
        let places: Vec<_> =
            kept.iter().map(|each| (each.place.as_str(), each.name.as_str(), each.files.len())).collect();
        assert_eq!(places, [("_board", "plane7", 1), ("acme", "plane7", 2), ("acme", "plane8", 0)]);
        assert_eq!(kept[1].records, [("state".to_owned(), 3)].into());
        let gaps = kept[1].gaps.as_ref().expect("noted");
        let gaps: Vec<_> = gaps.iter().map(|gap| (gap.first, gap.last, gap.is_lost)).collect();
        assert_eq!(gaps, [(7, 8, true), (1, 2, false), (5, 6, false)]);
        let given = |place: &str, name: &str| find(&top, place, name).expect("read").is_some();
        assert!(given("acme", "plane7_2026-11-25T09-00-00Z.mcap") && given(BOARD, "plane7_2026-11-25T08-00-00Z.mcap"));
        for (place, name) in [
            ("acme", "secret.txt"),
            ("acme", "plane7.json"),
            ("acme", "_.mcap"),
            ("..", "x_1.mcap"),
            ("none", "x_1.mcap"),
        ] {
            assert!(!given(place, name), "{place} {name}");
        }
        fs::write(acme.join("plane8.json"), "{").expect("written");
        let kept = list(&top).expect("one that is damaged hides no other");
        assert_eq!((kept[0].gaps.as_ref(), kept[2].gaps.as_ref()), (None, None), "not noted is not whole");
        assert!(kept[2].problem.as_ref().is_some_and(|problem| problem.contains("plane8.json is damaged")));
        assert!(kept[1].gaps.is_some());
        fs::remove_dir_all(top).expect("removed");
    }
}
