//! What is kept of aircraft far away: the files of a fleet's history (`.mcap`), and what is missing in them. Their names tell the aircraft;
//! nothing else in the folders is shown, and what a client names is compared with what is there, never made a path of.
//!
//! The files of each fleet are in `ground/FLEET` with a note of their numbers (`NAME.json`) beside those of each aircraft, those of this
//! computer's own in `board`.

use std::collections::BTreeMap;
use std::fs;
use std::io;
use std::path::{Path, PathBuf};
use std::time::UNIX_EPOCH;

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

/// The place of what this computer keeps on board. No fleet has such a name.
pub const BOARD: &str = "_board";
const ENDING: &str = ".mcap";
const NOTE: &str = ".json";

/// A file of a history (MCAP).
#[derive(Debug, Clone, PartialEq, Serialize, ToSchema)]
pub struct HistoryFile {
    /// Its name.
    pub name: String,
    /// Its size.
    pub bytes: u64,
    /// When it was written last, seconds since 1970; null when the system does not say.
    #[schema(required = true)]
    pub modified_unix_s: Option<f64>,
}

/// Numbers of records that are not in a history.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, ToSchema)]
pub struct HistoryGap {
    /// The boot on board: 16 hexadecimal digits.
    pub boot: String,
    /// `state`, `event` or `audit`.
    pub stream: String,
    /// The first number.
    pub first: u64,
    /// The last number.
    pub last: u64,
    /// Whether the aircraft has them no more; else they are fetched when it is there.
    pub is_lost: bool,
}

/// What is kept of one aircraft.
#[derive(Debug, Clone, PartialEq, Serialize, ToSchema)]
pub struct AircraftHistory {
    /// The fleet, or `_board` for what this computer keeps on board of an aircraft.
    pub place: String,
    /// The aircraft's name.
    pub name: String,
    /// Its files, by name, which is by time where the clock was set.
    pub files: Vec<HistoryFile>,
    /// How many records of each stream were ever in the files; some may have been deleted since, to make room. Empty where that is not
    /// noted, as on board, where all is kept.
    pub records: BTreeMap<String, u64>,
    /// What is missing of it on the ground; null where that is not noted.
    #[schema(required = true)]
    pub gaps: Option<Vec<HistoryGap>>,
    /// Why what is missing is not known, in English: its note is damaged.
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

/// The names of the regular files of a folder; none where there is no such folder.
fn files(folder: &Path) -> io::Result<Vec<HistoryFile>> {
    let mut found = Vec::new();
    for entry in none_where_missing(fs::read_dir(folder).map(Some))?.into_iter().flatten() {
        let entry = entry?;
        let Ok(name) = entry.file_name().into_string() else { continue };
        // One that was deleted meanwhile is not there; a link is not one of ours.
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

/// The aircraft of a file `NAME_TIME.mcap`.
fn aircraft_of(name: &str) -> Option<&str> {
    name.strip_suffix(ENDING)?.rsplit_once('_').map(|(aircraft, _)| aircraft).filter(|aircraft| !aircraft.is_empty())
}

/// What is kept, by place and name. Reads the disk.
///
/// # Errors
/// When a folder cannot be read.
pub fn list(top: &Path) -> io::Result<Vec<AircraftHistory>> {
    let in_places = places(top)?.into_iter().map(|(place, folder)| in_folder(&place, &folder));
    Ok(in_places.collect::<io::Result<Vec<_>>>()?.concat())
}

/// What is kept in the folder of a place, by name. Reads the disk.
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

/// The file of that name in a place, if it is one of a history. Reads the disk.
///
/// # Errors
/// When a folder cannot be read.
pub fn find(top: &Path, place: &str, name: &str) -> io::Result<Option<PathBuf>> {
    let Some((_, folder)) = places(top)?.into_iter().find(|(known, _)| known == place) else { return Ok(None) };
    let known = files(&folder)?.into_iter().find(|file| file.name == name && aircraft_of(&file.name).is_some());
    Ok(known.map(|file| folder.join(file.name)))
}

/// Takes in what is noted beside the files of an aircraft.
fn take_note(path: &Path, aircraft: &mut AircraftHistory) {
    let read = fs::read(path).and_then(|bytes| serde_json::from_slice::<Note>(&bytes).map_err(io::Error::from));
    let noted = match read {
        Ok(noted) => noted,
        Err(error) => {
            let name = path.file_name().unwrap_or_default().display();
            aircraft.problem = Some(format!("{name} is damaged ({error}): move it away, and it is made anew"));
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
        // What neither has, from 1 on, may still be fetched.
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
