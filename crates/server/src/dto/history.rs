//! What is kept of aircraft far away.

use std::collections::BTreeMap;

use serde::Serialize;
use utoipa::ToSchema;

use crate::history;

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
    /// How many records of each stream were ever in the files; some may have been deleted since, to make room. Empty on board, where
    /// all is kept.
    pub records: BTreeMap<String, u64>,
    /// What is missing of it on the ground.
    pub gaps: Vec<HistoryGap>,
}

impl From<history::Kept> for AircraftHistory {
    fn from(kept: history::Kept) -> Self {
        let history::Kept { place, name, files, records, gaps } = kept;
        let file = |file: history::HistoryFile| {
            let history::HistoryFile { name, bytes, modified_unix_s } = file;
            HistoryFile { name, bytes, modified_unix_s }
        };
        let gap = |gap: history::Gap| {
            let history::Gap { boot, stream, first, last, is_lost } = gap;
            HistoryGap { boot, stream, first, last, is_lost }
        };
        Self {
            place,
            name,
            files: files.into_iter().map(file).collect(),
            records,
            gaps: gaps.into_iter().map(gap).collect(),
        }
    }
}
