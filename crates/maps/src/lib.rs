//! Maps: where they come from, what is kept of them, and how high the ground is.
//!
//! All sources, whatever they are, come out as tiles of a described grid in the source's own coordinate reference system:
//! who draws reprojects, one way for all. Only configured sources are fetched from; what they answer is checked, bounded and
//! kept, so that the network is used once and a field without it shows what was seen before.
//!
//! | module | owns |
//! |---|---|
//! | [`service`] | the maps of a station: their sources, read from the file and got ready |
//! | [`tiles`], `changes`, `heights` | what is done with them: tiles, changes of the sources, heights of the ground |
//! | [`listing`] | sources as they are shown |
//! | `source` | one source in use: addresses, fetches under way, how it fares |
//! | `aside`, `stamp` | sources whose reading ended the process; what tells files from what they were |
//! | [`settings`], [`file`](mod@file), [`presets`] | what a source is, its file, well-known ones with their terms |
//! | [`cache`] | what is kept, as MBTiles in SQLite |
//! | [`areas`], `area_files`, [`cover`] | what is fetched ahead, files of it, and which tiles that takes |
//! | [`net`] | fetching: who may be asked, how much may be answered |
//! | [`kinds`], `list` | the kinds of sources, a module each: services, files, heights |
//! | [`kind`], [`live`] | what a kind says of itself; how what was opened gives tiles and heights |
//! | [`capabilities`], `address` | what a service offers; addresses |
//! | [`uploads`] | files that are handed in |
//! | [`elevation`] | heights from pictures, interpolation, profiles |
//! | [`crs`], [`grid`] | coordinate reference systems, grids of tiles |
//! | [`memory`] | what decoders may use and what is kept of their work |
//! | [`sniff`], [`raster`], [`xml`] | reading what others wrote, within bounds |

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
