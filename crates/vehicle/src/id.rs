//! Ids of a station's vehicles.

use std::fmt;

use vencejo_proto::SystemId;

/// Identifies a vehicle of a station. 1 to 255: at a link, by its MAVLink system id. 256 to 65,535: a remote vehicle,
/// whose own system id may be shared by many; the number is valid in this station only.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct VehicleId(u16);

impl VehicleId {
    /// The lowest number of a remote vehicle.
    pub const FIRST_FAR: u16 = 256;

    /// From its number; `None` for 0.
    pub const fn new(number: u16) -> Self {
        Self(number)
    }

    /// Its number.
    pub const fn number(self) -> u16 {
        self.0
    }

    /// Its MAVLink system id; `None` for a remote vehicle.
    pub fn system(self) -> Option<SystemId> {
        u8::try_from(self.0).ok().map(SystemId)
    }

    /// Whether it is remote: no link of the station reaches it.
    pub const fn is_far(self) -> bool {
        self.0 >= Self::FIRST_FAR
    }

    /// The numbers of remote vehicles, beginning with the one that belongs to a name (FNV-1a, draft-eastlake-fnv-17,
    /// folded to 16 bits). The first that is free is taken, so an aircraft keeps its number from one start of the
    /// station to the next unless the numbers of two names meet.
    pub fn of_name(name: &str) -> impl Iterator<Item = Self> + use<> {
        const OFFSET: u32 = 0x811c_9dc5;
        const PRIME: u32 = 0x0100_0193;
        let hash = name.bytes().fold(OFFSET, |hash, byte| (hash ^ u32::from(byte)).wrapping_mul(PRIME));
        let (span, folded) = (u32::from(u16::MAX - Self::FIRST_FAR) + 1, hash ^ (hash >> 16));
        let number = move |step: u32| u16::try_from((folded % span + step) % span).unwrap_or_default();
        (0..span).map(move |step| Self(Self::FIRST_FAR + number(step)))
    }
}

impl From<SystemId> for VehicleId {
    fn from(system: SystemId) -> Self {
        Self(system.0.into())
    }
}

impl fmt::Display for VehicleId {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.fmt(f)
    }
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use super::*;

    #[test]
    fn a_name_has_the_same_number_each_time_and_any_number_far_away_can_be_had() {
        let first = |name: &str| VehicleId::of_name(name).next();
        assert_eq!(first("plane7"), first("plane7"));
        let firsts: BTreeSet<_> = (0..1000).filter_map(|n| first(&format!("plane{n}"))).collect();
        assert!(firsts.len() > 950, "{} numbers of 1,000 names", firsts.len());
        let all: BTreeSet<_> = VehicleId::of_name("plane7").collect();
        assert!(all.iter().all(|id| id.is_far() && id.system().is_none()));
        assert_eq!(all.len(), 65_536 - 256);
    }

    #[test]
    fn a_system_id_is_a_vehicle_at_a_link() {
        let id = VehicleId::from(SystemId(255));
        assert_eq!((id.number(), id.system(), id.is_far()), (255, Some(SystemId(255)), false));
    }
}
