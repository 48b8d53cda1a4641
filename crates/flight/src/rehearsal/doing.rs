//! Activity of a plane in the air when a rehearsal begins.

use crate::geodesy::GeoPoint;

/// Activity of a plane in the air when a rehearsal begins.
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
    /// It has climbed and circles as in LOITER, but a short failsafe leaves it alone (TAKEOFF).
    TookOff {
        /// Around which place.
        around: GeoPoint,
        /// Height above home, m.
        height_m: f64,
    },
    /// A pilot steers it: only reactions to a trigger can be rehearsed.
    Piloted,
    /// It looks for lift (THERMAL): likewise, but its failsafes are those of LOITER.
    Soaring,
}

impl Doing {
    /// Whether its further flight without a trigger is unknown.
    pub fn is_open(self) -> bool {
        matches!(self, Self::Piloted | Self::Soaring)
    }
}
