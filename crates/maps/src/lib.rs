//! Maps: where they come from, what is kept of them, and how high the ground is.
//!
//! All sources, whatever they are, come out as tiles of a described grid in the source's own coordinate reference system:
//! who draws reprojects, one way for all. Only configured sources are fetched from; what they answer is checked, bounded and
//! kept, so that the network is used once and a field without it shows what was seen before.
//!
//! | module | owns |
//! |---|---|
//! | [`service`] | the maps of a station: tiles, changes, heights |
//! | `source` | one source in use: addresses, fetches under way, how it fares |
//! | [`settings`], [`file`](mod@file), [`presets`] | what a source is, its file, well-known ones with their terms |
//! | [`cache`] | what is kept, as MBTiles in SQLite |
//! | [`areas`], [`cover`] | what is fetched ahead, and which tiles that takes |
//! | [`net`] | fetching: who may be asked, how much may be answered |
//! | [`wms`], [`wmts`], [`xyz`], `google` | the services |
//! | [`files`] | MBTiles, PMTiles, GeoTIFF, pictures with corners, files of heights |
//! | [`uploads`] | files that are handed in |
//! | [`elevation`] | heights from pictures, interpolation, profiles |
//! | [`crs`], [`grid`] | coordinate reference systems, grids of tiles |
//! | [`sniff`], [`raster`], [`xml`] | reading what others wrote, within bounds |

pub mod areas;
pub mod cache;
pub mod cover;
pub mod crs;
pub mod elevation;
pub mod error;
pub mod file;
pub mod files;
mod google;
pub mod grid;
pub mod net;
pub mod presets;
pub mod raster;
pub mod service;
pub mod settings;
pub mod sniff;
mod source;
#[cfg(test)]
mod testing;
pub mod uploads;
pub mod wms;
pub mod wmts;
pub mod xml;
pub mod xyz;

pub use areas::{Area, AreaState, Estimate, NewArea};
pub use error::{MapError, Result};
pub use service::{MapSource, MapSources, Maps, MapsConfig, Origin, Tile};
pub use source::{CacheState, SourceState, Status};
