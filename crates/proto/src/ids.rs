//! Identifiers of MAVLink as types of their own, so that a system id is never passed where a component id belongs.

use std::fmt;

/// A MAVLink system id: 1 to 255 for a system, 0 for "all systems" in a target field.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct SystemId(pub u8);

/// A MAVLink component id (`MAV_COMPONENT`): 1 is the autopilot, 190 a mission planner, 191 an on-board computer; 0
/// means "all components" in a target field.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct ComponentId(pub u8);

/// The index of an item in a mission, fence or rally list, as on the wire. On ArduPilot item 0 of a mission is home.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct MissionSeq(pub u16);

/// Who speaks or is spoken to: a component of a system.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Address {
    /// The system, usually one vehicle or one ground station.
    pub system: SystemId,
    /// The component of that system.
    pub component: ComponentId,
}

impl SystemId {
    /// "All systems" in a target field.
    pub const BROADCAST: Self = Self(0);
    /// A ground station, as stations and autopilots come: ArduPilot's `MAV_GCS_SYSID` is this.
    pub const GROUND_STATION: Self = Self(255);
}

impl ComponentId {
    /// "All components" in a target field.
    pub const BROADCAST: Self = Self(0);
    /// The autopilot (`MAV_COMP_ID_AUTOPILOT1`).
    pub const AUTOPILOT: Self = Self(1);
    /// A ground station (`MAV_COMP_ID_MISSIONPLANNER`).
    pub const GROUND_STATION: Self = Self(190);
    /// A computer on board (`MAV_COMP_ID_ONBOARD_COMPUTER`).
    pub const ONBOARD_COMPUTER: Self = Self(191);

    /// Whether it is a computer on board (`MAV_COMP_ID_ONBOARD_COMPUTER` to `…COMPUTER4`).
    pub const fn is_onboard_computer(self) -> bool {
        matches!(self.0, 191..=194)
    }
}

impl Address {
    /// The address of `component` on `system`.
    pub const fn new(system: u8, component: u8) -> Self {
        Self { system: SystemId(system), component: ComponentId(component) }
    }
}

impl fmt::Display for SystemId {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.fmt(f)
    }
}

impl fmt::Display for ComponentId {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.fmt(f)
    }
}

impl fmt::Display for MissionSeq {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.fmt(f)
    }
}

impl fmt::Display for Address {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}/{}", self.system, self.component)
    }
}
