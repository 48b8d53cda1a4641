//! Maps: sources, caches, and heights of the ground.
//!
//! All kinds of sources give tiles of a described grid in the source's own coordinate reference system: the client
//! reprojects, in one way for all. Only configured sources are fetched from; what they answer is checked, bounded and
//! kept, so that the network is used once and tiles seen before work without it.
//!
//! | module | owns |
//! |---|---|
//! | [`service`] | the maps of a station: their sources, read from the file and got ready |
//! | `tiles`, `changes`, `heights` | serving tiles, changing the sources, heights of the ground |
//! | [`listing`] | sources as they are shown |
//! | `source` | one source in use: addresses, fetches in flight, its health |
//! | `aside`, `stamp` | sources whose reading ended the process; detecting changed files |
//! | [`settings`], [`file`](mod@file), [`presets`] | settings of a source, their file, well-known sources with their terms |
//! | [`cache`] | cached tiles, as MBTiles in SQLite |
//! | [`areas`], `area_files`, [`cover`] | offline areas, their export and import, and the tiles that cover a shape |
//! | [`net`] | fetching: allowed hosts, size limits |
//! | [`kinds`], `list` | the kinds of sources, a module each: services, files, heights |
//! | [`kind`], [`live`] | interfaces of a kind, and of an opened source |
//! | [`capabilities`], `address` | capabilities of services; addresses |
//! | [`uploads`] | uploaded files |
//! | [`elevation`] | heights from pictures, interpolation, profiles |
//! | [`crs`], [`grid`] | coordinate reference systems, grids of tiles |
//! | [`memory`] | memory limits of decoders, and the shared caches of their results |
//! | [`sniff`], [`raster`], [`xml`] | reading untrusted files, within bounds |

#[macro_use]
mod list;

mod address;
mod area_files;
pub mod areas;
mod aside;
pub mod cache;
pub mod capabilities;
mod changes;
pub mod cover;
pub mod crs;
mod downloads;
pub mod elevation;
pub mod error;
pub mod file;
pub mod geo;
pub mod grid;
mod heights;
pub mod kind;
pub mod kinds;
pub mod listing;
pub mod live;
pub mod memory;
pub mod net;
pub mod presets;
pub mod raster;
pub mod service;
pub mod settings;
mod shown;
pub mod sniff;
mod source;
mod stamp;
mod task;
#[cfg(test)]
mod testing;
pub mod tile;
mod tiles;
pub mod uploads;
pub mod xml;

pub use areas::{Area, AreaState, Estimate, NewArea};
pub use error::{MapError, Result, SourceCause, Unreached};
pub use listing::{MapConfiguration, MapSource, MapSources};
pub use service::{FolderProblem, Maps, MapsConfig};
pub use source::{CacheState, SourceState, Status};
pub use tile::{Origin, Tile};
