//! Detecting that files have changed since they were read.

use std::fs::Metadata;
use std::path::Path;
use std::time::SystemTime;

use crate::settings::fnv1a;

/// Error text for a file that was replaced since it was opened: offsets of the old one are invalid.
pub(crate) const REPLACED: &str = "it was replaced since it was opened; it is opened anew within seconds";

/// When a file was changed, and its bytes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Stamp {
    changed: Option<SystemTime>,
    bytes: u64,
}

impl Stamp {
    /// By what the system says of a file.
    pub(crate) fn of(about: &Metadata) -> Self {
        Self { changed: about.modified().ok(), bytes: about.len() }
    }

    /// Of a path; `None` without a file. Blocks.
    pub(crate) fn at(path: &Path) -> Option<Self> {
        std::fs::metadata(path).ok().as_ref().map(Self::of)
    }
}

/// The stamp of a file, or those of all that lies in a folder, in one number; `None` without a file. Blocks.
pub(crate) fn of_all(path: &Path) -> Option<u64> {
    let about = std::fs::metadata(path).ok()?;
    let mut stamps = vec![(None, Some(Stamp::of(&about)))];
    if about.is_dir() {
        let entries = std::fs::read_dir(path).ok()?.flatten();
        stamps.extend(entries.map(|entry| (Some(entry.file_name()), Stamp::at(&entry.path()))));
        stamps.sort_by(|a, b| a.0.cmp(&b.0));
    }
    Some(fnv1a(format!("{stamps:?}").as_bytes()))
}
