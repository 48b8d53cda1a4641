//! An area: where it is, and how far.

use serde::Serialize;
use utoipa::ToSchema;

use crate::cover::Shape;

/// State of an area.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, ToSchema)]
#[serde(rename_all = "snake_case")]
#[schema(as = MapAreaState)]
pub enum AreaState {
    /// On its way, or waiting for the network.
    Running,
    /// Until it is resumed.
    Paused,
    /// All is here, but for what failed.
    Done,
    /// Given up.
    Failed,
}

impl AreaState {
    pub(super) const fn name(self) -> &'static str {
        match self {
            Self::Running => "running",
            Self::Paused => "paused",
            Self::Done => "done",
            Self::Failed => "failed",
        }
    }

    pub(super) fn of(name: &str) -> Self {
        match name {
            "running" => Self::Running,
            "paused" => Self::Paused,
            "done" => Self::Done,
            _ => Self::Failed,
        }
    }
}

/// An offline area.
#[derive(Debug, Clone, PartialEq, Serialize, ToSchema)]
#[schema(as = MapArea)]
pub struct Area {
    /// Its id.
    pub id: String,
    /// The source that it is of.
    pub source: String,
    /// Display name.
    pub name: String,
    /// Where it is.
    pub shape: Shape,
    /// Coarsest level of the source's grid.
    pub min_level: u8,
    /// Finest level of the source's grid.
    pub max_level: u8,
    /// How it stands.
    pub state: AreaState,
    /// Why it waits, or what failed.
    #[schema(required = true)]
    pub detail: Option<String>,
    /// Tiles in all.
    pub tiles: u64,
    /// Tiles that are here, or that the service has not.
    pub done: u64,
    /// Tiles that could not be had.
    pub failed: u64,
    /// Bytes that were fetched for it.
    pub bytes: u64,
    /// Seconds since 1970.
    pub created_at: i64,
    /// How fast it goes.
    #[schema(required = true)]
    pub rate_tiles_s: Option<f64>,
}

/// How many tiles of one level.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, ToSchema)]
#[schema(as = MapLevelCount)]
pub struct LevelCount {
    /// Which.
    pub level: u8,
    /// How many.
    pub tiles: u64,
}

/// Size of an area before it is fetched.
#[derive(Debug, Clone, PartialEq, Serialize, ToSchema)]
#[schema(as = MapAreaEstimate)]
pub struct Estimate {
    /// In all.
    pub tiles: u64,
    /// Already here.
    pub have: u64,
    /// Still to be fetched, about.
    pub bytes: u64,
    /// Of a tile.
    pub tile_bytes: u64,
    /// Whether that is measured on tiles of this source, or only usual.
    pub tile_bytes_measured: bool,
    /// By level.
    pub levels: Vec<LevelCount>,
    /// Tiles that are taken at most.
    pub max_tiles: u64,
    /// Why it would be refused.
    #[schema(required = true)]
    pub refused: Option<String>,
}

/// An area to make.
#[derive(Debug, Clone, PartialEq)]
pub struct NewArea {
    /// The source that it is of.
    pub source: String,
    /// Display name.
    pub name: String,
    /// Where it is.
    pub shape: Shape,
    /// Coarsest level of the source's grid.
    pub min_level: u8,
    /// Finest level of the source's grid.
    pub max_level: u8,
}
