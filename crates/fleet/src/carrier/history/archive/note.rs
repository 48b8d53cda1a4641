//! `NAME.json` beside the files of an aircraft: what they have, by numbers.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use crate::history::fill::Held;
use crate::history::{Ranges, Stream};

/// How the names of notes end.
pub(super) const ENDING: &str = ".json";
const FORMAT: u32 = 1;

/// What there is of each stream of each boot.
pub(super) type Numbers = BTreeMap<(u64, Stream), Held>;

/// `NAME.json`.
#[derive(Serialize, Deserialize)]
struct Noted {
    format: u32,
    streams: Vec<NotedStream>,
    /// The file that was written last.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    file: Option<String>,
    /// Whether that was ended and is all here. Else it may have more, as those after it.
    #[serde(default)]
    is_ended: bool,
}

/// From where the files may have more than the note.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub(super) struct Unread {
    /// The last file that the note knows; without one it is the newest that is read.
    pub(super) file: Option<String>,
    /// Whether that has no more.
    pub(super) is_ended: bool,
}

#[derive(Serialize, Deserialize)]
struct NotedStream {
    /// In hexadecimal: JavaScript has no such numbers.
    boot: String,
    stream: String,
    have: Vec<(u64, u64)>,
    lost: Vec<(u64, u64)>,
}

/// The note.
pub(super) fn to_text(numbers: &Numbers, unread: Unread) -> Vec<u8> {
    let Unread { file, is_ended } = unread;
    let stream = |(&(boot, stream), held): (&(u64, Stream), &Held)| NotedStream {
        boot: format!("{boot:016x}"),
        stream: stream.as_str().to_owned(),
        have: held.have.iter().collect(),
        lost: held.lost.iter().collect(),
    };
    let noted = Noted { format: FORMAT, streams: numbers.iter().map(stream).collect(), file, is_ended };
    serde_json::to_vec(&noted).unwrap_or_default()
}

/// What a note says; `None`: it is none of ours, or damaged.
pub(super) fn of_text(text: &[u8]) -> Option<(Numbers, Unread)> {
    let noted: Noted = serde_json::from_slice(text).ok().filter(|noted: &Noted| noted.format == FORMAT)?;
    let of = |ranges: Vec<(u64, u64)>| -> Ranges {
        ranges.into_iter().filter(|(first, last)| 0 < *first && first <= last && *last < u64::MAX).collect()
    };
    let streams = noted.streams.into_iter().filter_map(|streams| {
        let boot = u64::from_str_radix(&streams.boot, 16).ok()?;
        let stream = Stream::ALL.into_iter().find(|stream| stream.as_str() == streams.stream)?;
        Some(((boot, stream), Held::of(of(streams.have), of(streams.lost))))
    });
    Some((streams.collect(), Unread { file: noted.file, is_ended: noted.is_ended }))
}
