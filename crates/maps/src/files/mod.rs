//! Sources that are files of this machine: tiles, pictures and heights.

pub mod dem;
pub mod geotiff;
mod lzw;
pub mod mbtiles;
pub mod overlay;
pub mod pmtiles;
mod tags;

use bytes::Bytes;

use crate::error::Result;
use crate::geo::Bounds;
use crate::grid::{TileGrid, TileId};
use crate::settings::Attribution;

/// A file whose tiles are shown.
pub trait TileFile: Send + Sync {
    /// The grid of its tiles.
    fn grid(&self) -> &TileGrid;
    /// What it says about itself.
    fn about(&self) -> About;
    /// A tile's picture; `None` when it has none there. Blocks.
    ///
    /// # Errors
    /// [`crate::MapError::Unusable`] when the file is broken.
    fn tile(&self, tile: TileId) -> Result<Option<Bytes>>;
}

/// What a file says about itself.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct About {
    /// Its name.
    pub name: Option<String>,
    /// Where it has something.
    pub bounds: Option<Bounds>,
    /// Whom to name.
    pub attribution: Option<Attribution>,
    /// Whether it is made to lie over another map.
    pub is_overlay: bool,
    /// Finest zoom, for files of Web Mercator tiles.
    pub max_zoom: Option<u8>,
}
