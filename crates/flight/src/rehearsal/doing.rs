//! What a plane in the air does when a rehearsal begins.

use crate::geodesy::GeoPoint;

/// What a plane in the air does when a rehearsal begins.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Doing {
    /// It flies its mission (AUTO).
    Mission,
    /// It returns (RTL).
    Returning,
    /// It flies to a place and circles there (GUIDED).
    Guided {
        /// Where.
        to: GeoPoint,
        /// Height above home, m.
        height_m: f64,
    },
    /// It circles around a place (LOITER).
    Loitering {
        /// Where.
        around: GeoPoint,
        /// Height above home, m.
        height_m: f64,
    },
    /// It circles where it is, as high as it is (CIRCLE).
    Circling,
    /// A pilot steers it: what he will do nobody knows, so only what follows a trigger can be rehearsed.
    Piloted,
}
