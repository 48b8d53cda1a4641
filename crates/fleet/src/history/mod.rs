//! What an aircraft said and did, kept: on board, and on the ground, where what was not heard is fetched later.
//!
//! States, events and orders are numbered without holes within one boot of the station on board. So what is missing on
//! the ground is known by numbers, whatever the clocks say, and the bytes that come later are those that would have
//! come then.
//!
//! | module | owns |
//! |---|---|
//! | [`record`] | records, orders as they are kept, questions and answers |
//! | [`ranges`] | sets of numbers |
//! | [`fill`] | what is missing on the ground, and when to ask for it |
//! | [`location`] | a position as Foxglove's map shows it |
//! | `mcap` | the MCAP format, as far as it is needed here |
//! | [`pen`] | records as such a file |
//! | [`page`] | such a file, read in any condition |

pub mod fill;
pub mod location;
mod mcap;
pub mod page;
pub mod pen;
pub mod ranges;
pub mod record;

pub use fill::{Fill, Gap, Question};
pub use ranges::Ranges;
pub use record::{BadPiece, Index, Piece, Record, Stream, Wanted};
