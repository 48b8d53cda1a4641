//! What can go wrong with a map, said so that a person in the field knows what to do.

use std::path::PathBuf;

use serde::Serialize;
use thiserror::Error;
use utoipa::ToSchema;
use vencejo_store::{Class, LowSpace};

/// Why there is no tile, source, area or height. Texts never hold a key.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum MapError {
    /// No source of that id is configured.
    #[error("there is no map source '{0}'; GET /api/v1/maps/sources lists them")]
    NoSource(String),
    /// Nothing to draw there: outside of the source, or without a tile.
    #[error("the source has no tile there")]
    NoTile,
    /// The source's service requires a key, which is not set.
    #[error("source '{0}' needs a key: enter yours in the map sources' dialog")]
    KeyMissing(String),
    /// The source cannot be used as it is configured: its file is missing or broken, its layer does not exist.
    #[error("source '{source_id}' cannot be used: {reason}")]
    Unusable {
        /// Which.
        source_id: String,
        /// Why, and what to do.
        reason: String,
    },
    /// Settings of a source that cannot be.
    #[error("source '{source_id}': {}", faults.join("; "))]
    Settings {
        /// Which.
        source_id: String,
        /// Each names its field.
        faults: Vec<String>,
    },
    /// The file of the sources cannot be read as such.
    #[error("{}: {reason}", path.display())]
    SourcesFile {
        /// The file.
        path: PathBuf,
        /// The fault, with the line.
        reason: String,
    },
    /// The service answered with something else than what was asked for.
    #[error("{host}: {reason}")]
    Service {
        /// Who.
        host: String,
        /// The status that it answered with, where that is what was wrong.
        status: Option<u16>,
        /// In its own words where it gave some.
        reason: String,
    },
    /// The service's address lies inside this network, where the source is not permitted to be: it was not asked.
    #[error("{host}: {reason}")]
    LocalAddress {
        /// Who.
        host: String,
        /// Whether the setting `local_network` of the source would permit it.
        is_permissible: bool,
        /// Why, and what to do.
        reason: String,
    },
    /// The service did not answer in time.
    #[error("{host} did not answer within {seconds} s")]
    Timeout {
        /// Who.
        host: String,
        /// How long it was given.
        seconds: u64,
    },
    /// The service is not to be reached.
    #[error("{host} cannot be reached: {reason}")]
    Offline {
        /// Who.
        host: String,
        /// Why, as far as that is known.
        why: Unreached,
        /// Why, in the system's words.
        reason: String,
        /// When it is tried again.
        retry_s: u64,
    },
    /// Too many fetches are under way.
    #[error("too many tiles are being fetched; the network is slower than the map is moved")]
    Busy,
    /// The source's terms, or its kind, allow no offline area.
    #[error("no offline areas of '{source_id}': {reason}")]
    OfflineRefused {
        /// Which.
        source_id: String,
        /// Why.
        reason: String,
    },
    /// An area of more tiles than can be wanted.
    #[error("the area has {tiles} tiles and at most {most} are taken: choose a smaller area or a smaller highest zoom")]
    AreaTooLarge {
        /// Of the area.
        tiles: u64,
        /// Allowed.
        most: u64,
    },
    /// No area of that id.
    #[error("there is no offline area '{0}'")]
    NoArea(String),
    /// A file that was handed in is not what it should be.
    #[error("{name}: {reason}")]
    MapFile {
        /// Its name.
        name: String,
        /// The fault.
        reason: String,
    },
    /// A request that makes no sense.
    #[error("{0}")]
    Request(String),
    /// The disk is too full for maps.
    #[error(transparent)]
    LowSpace(#[from] LowSpace),
    /// This machine's disk or database failed.
    #[error("the map folder: {0}")]
    Storage(String),
    /// The maps are being closed.
    #[error("the maps are being closed")]
    Closed,
}

/// Why a service is not reached.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, ToSchema)]
#[serde(rename_all = "snake_case")]
#[schema(as = MapUnreached)]
pub enum Unreached {
    /// Its name cannot be resolved: no network, or a wrong address.
    NameUnknown,
    /// Its machine refuses connections there.
    Refused,
    /// No connection comes about for another reason.
    NoConnection,
}

/// Why a source does not come, by a stable code with what a sentence about it needs: codes and fields are those of the
/// causes that a tile is refused with.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, ToSchema)]
#[serde(tag = "code", rename_all = "kebab-case")]
#[schema(as = MapSourceCause)]
pub enum SourceCause {
    /// It demands the user's key.
    SourceKey {
        /// Id of the source.
        source: String,
    },
    /// It cannot be used as it is configured.
    SourceInvalid {
        /// Id of the source.
        source: String,
        /// Why, in English.
        problem: String,
    },
    /// Its service answered with something else.
    SourceFailed {
        /// Host of the service.
        service: String,
        /// The HTTP status, where that is what was wrong.
        #[schema(required = true)]
        status: Option<u16>,
        /// In its own words where it gave some.
        problem: String,
    },
    /// Its service's address lies inside this network, where it is not permitted to be: it was not asked.
    SourceLocal {
        /// Host of the service.
        service: String,
        /// Whether the setting `local_network` of the source would permit it.
        is_permissible: bool,
        /// Why, and what to do, in English.
        problem: String,
    },
    /// Its service did not answer in time.
    SourceTimeout {
        /// Host of the service.
        service: String,
        /// How long it was given.
        waited_s: u64,
    },
    /// Its service is not reached.
    SourceOffline {
        /// Host of the service.
        service: String,
        /// Why, as far as that is known.
        why: Unreached,
        /// Why, in English.
        problem: String,
        /// When it is tried again.
        retry_s: u64,
    },
}

impl SourceCause {
    /// The cause within a source; `None` for errors unrelated to a source.
    pub fn of(error: &MapError) -> Option<Self> {
        Some(match error.clone() {
            MapError::KeyMissing(source) => Self::SourceKey { source },
            MapError::Unusable { source_id: source, reason: problem } => Self::SourceInvalid { source, problem },
            MapError::Service { host: service, status, reason: problem } => {
                Self::SourceFailed { service, status, problem }
            }
            MapError::LocalAddress { host: service, is_permissible, reason: problem } => {
                Self::SourceLocal { service, is_permissible, problem }
            }
            MapError::Timeout { host: service, seconds: waited_s } => Self::SourceTimeout { service, waited_s },
            MapError::Offline { host: service, why, reason: problem, retry_s } => {
                Self::SourceOffline { service, why, problem, retry_s }
            }
            _ => return None,
        })
    }
}

/// Result of this crate.
pub type Result<T> = std::result::Result<T, MapError>;

impl MapError {
    /// A fault of this machine's disk or database.
    pub fn storage(error: impl std::fmt::Display) -> Self {
        Self::Storage(error.to_string())
    }

    /// The fault of an uploaded file.
    pub fn file(name: impl Into<String>, reason: impl Into<String>) -> Self {
        Self::MapFile { name: name.into(), reason: reason.into() }
    }

    /// One of each kind, for tables that must know all of them.
    pub fn examples() -> Vec<Self> {
        let text = || "x".to_owned();
        vec![
            Self::NoSource(text()),
            Self::NoTile,
            Self::KeyMissing(text()),
            Self::Unusable { source_id: text(), reason: text() },
            Self::Settings { source_id: text(), faults: vec![text()] },
            Self::SourcesFile { path: PathBuf::from("sources.toml"), reason: text() },
            Self::Service { host: text(), status: Some(403), reason: text() },
            Self::LocalAddress { host: text(), is_permissible: true, reason: text() },
            Self::Timeout { host: text(), seconds: 15 },
            Self::Offline { host: text(), why: Unreached::NameUnknown, reason: text(), retry_s: 5 },
            Self::Busy,
            Self::OfflineRefused { source_id: text(), reason: text() },
            Self::AreaTooLarge { tiles: 2, most: 1 },
            Self::NoArea(text()),
            Self::MapFile { name: text(), reason: text() },
            Self::Request(text()),
            Self::LowSpace(LowSpace { class: Class::Maps, path: PathBuf::from("maps"), free_bytes: 1, floor_bytes: 2 }),
            Self::Storage(text()),
            Self::Closed,
        ]
    }

    /// Whether the network, not the service, is the reason.
    pub const fn is_network(&self) -> bool {
        matches!(self, Self::Offline { .. } | Self::Timeout { .. })
    }
}

impl From<rusqlite::Error> for MapError {
    fn from(error: rusqlite::Error) -> Self {
        Self::storage(error)
    }
}

impl From<std::io::Error> for MapError {
    fn from(error: std::io::Error) -> Self {
        Self::storage(error)
    }
}
