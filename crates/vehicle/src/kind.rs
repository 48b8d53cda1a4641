//! Kinds of vehicles by `MAV_TYPE`.

/// `MAV_TYPE_FIXED_WING`.
pub(crate) const FIXED_WING: u8 = 1;

/// A kind of vehicle.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum VehicleKind {
    /// A fixed wing.
    Plane,
    /// A multicopter or helicopter.
    Copter,
    /// A plane that can also hover.
    Vtol,
    /// On wheels.
    Rover,
    /// On the water.
    Boat,
    /// Under water.
    Sub,
}

impl VehicleKind {
    /// The kind of a `MAV_TYPE`; `None` for any other type, such as an antenna tracker.
    pub const fn of(mav_type: u8) -> Option<Self> {
        Some(match mav_type {
            FIXED_WING => Self::Plane,
            2 | 3 | 4 | 13 | 14 | 15 | 29 | 35 => Self::Copter,
            10 => Self::Rover,
            11 => Self::Boat,
            12 => Self::Sub,
            19..=25 => Self::Vtol,
            _ => return None,
        })
    }

    /// Its stable name for programs.
    pub const fn as_str(self) -> &'static str {
        match self {
            Self::Plane => "plane",
            Self::Copter => "copter",
            Self::Vtol => "vtol",
            Self::Rover => "rover",
            Self::Boat => "boat",
            Self::Sub => "sub",
        }
    }

    /// Whether it can hover.
    pub const fn can_hover(self) -> bool {
        matches!(self, Self::Copter | Self::Vtol)
    }
}
