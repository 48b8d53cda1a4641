//! Replays of recordings: each recorded aircraft becomes a vehicle of its own, next to the live ones, whatever its system
//! id was, and takes no requests.
//!
//! | part | what it does |
//! |---|---|
//! | `film` | what is played, whatever its file format |
//! | `tlog` | a `.tlog` as a film; other formats are added by [`add_film_format`](crate::Station::add_film_format) |
//! | `clock` | UTC of the places that were shown |
//! | `pace` | where a replay is, and how it goes on |
//! | `handle` | a replay and its state |
//! | `opening` | how a station opens and ends one |
//! | `playing` | the task that shows a film |
//!
//! A replayed vehicle lives in the time of its recording: ages and the detection of silence follow that, at any speed, and
//! stand still while it is paused. At another place it begins anew, with what was known there, so that no value from
//! another time looks current.

mod clock;
mod film;
mod handle;
mod opening;
mod pace;
mod playing;
#[cfg(test)]
mod tests;
mod tlog;

pub use self::film::{Film, FilmInfo, MAX_MARKS, Mark, MarkKind, Moment};
pub use self::handle::{MAX_REPLAYS, OpenFilm, Replay, ReplayId, ReplayOptions, ReplayStatus};
pub(crate) use self::handle::{Replays, Shown};
pub use self::pace::SPEEDS;
