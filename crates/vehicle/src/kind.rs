//! What kind of vehicle a `MAV_TYPE` is.

/// A kind of vehicle.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum VehicleKind {
    /// A fixed wing.
    Plane,
    /// A multicopter or helicopter.
    Copter,
    /// A plane that hovers, too.
    Vtol,
    /// On wheels.
    Rover,
    /// On the water.
    Boat,
    /// Below it.
    Sub,
}

impl VehicleKind {
    /// The kind of a `MAV_TYPE`; `None` for what is none of these, as a tracker of antennas.
    pub const fn of(mav_type: u8) -> Option<Self> {
        Some(match mav_type {
            1 => Self::Plane,
            2 | 3 | 4 | 13 | 14 | 15 | 29 | 35 => Self::Copter,
            10 => Self::Rover,
            11 => Self::Boat,
            12 => Self::Sub,
            19..=25 => Self::Vtol,
            _ => return None,
        })
    }

    /// A word for it, stable and fit for scripts.
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
