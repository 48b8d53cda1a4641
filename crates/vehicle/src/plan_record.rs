//! The record of a vehicle's mission that outlives the program.

use std::fmt;
use std::sync::Arc;

use vencejo_proto::{MissionItemInt, SystemId};

use crate::telemetry::AutopilotVersion;

/// Permanent name of an aircraft: the id of its hardware, or, where it tells none, its system id, which another one may
/// share. Letters, digits and hyphens only.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct VehicleKey(String);

impl VehicleKey {
    /// The name by system id alone.
    pub fn of_system(system: SystemId) -> Self {
        Self(format!("system-{system}"))
    }

    /// Parses [`Self::as_str`]; `None` for anything else.
    pub fn parse(name: &str) -> Option<Self> {
        let (kind, rest) = name.split_once('-')?;
        let is_named = match kind {
            "uid" => rest.len() == 16,
            "uid2" => (2..=36).contains(&rest.len()),
            "system" => (1..=3).contains(&rest.len()),
            _ => false,
        };
        (is_named && rest.bytes().all(|byte| byte.is_ascii_hexdigit())).then(|| Self(name.to_owned()))
    }

    /// The system id, where the name is one.
    pub fn system(&self) -> Option<SystemId> {
        self.0.strip_prefix("system-").and_then(|id| id.parse().ok()).map(SystemId)
    }

    /// Whether the name is a hardware id.
    pub(crate) fn is_hardware(&self) -> bool {
        self.system().is_none()
    }

    /// The name.
    pub fn as_str(&self) -> &str {
        &self.0
    }
}

/// Hardware ids of AUTOPILOT_VERSION, as far as told. ArduPilot has `uid2` alone, PX4 both; `uid2` is an extension
/// field, which MAVLink 1 leaves out.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(crate) struct HardwareIds {
    uid: Option<u64>,
    uid2: Option<[u8; 18]>,
}

impl HardwareIds {
    pub(crate) fn of_version(version: &AutopilotVersion) -> Self {
        Self { uid: version.uid, uid2: version.uid2 }
    }

    /// Whether they are of another aircraft than `before`: compares `uid2` where both have it, else `uid`. Ids that are
    /// missing on either side prove nothing.
    pub(crate) fn is_another(self, before: Self) -> bool {
        if self == Self::default() || before == Self::default() {
            return false;
        }
        match (self.uid2, before.uid2) {
            (Some(ours), Some(theirs)) => ours != theirs,
            _ => self.uid != before.uid,
        }
    }

    /// These, completed by those told before.
    pub(crate) fn or(self, before: Self) -> Self {
        Self { uid: self.uid.or(before.uid), uid2: self.uid2.or(before.uid2) }
    }

    /// The aircraft's name: by `uid2` where told, else by `uid`; `None` without both.
    pub(crate) fn key(self) -> Option<VehicleKey> {
        let by_uid = || self.uid.map(|uid| format!("uid-{uid:016x}"));
        let by_uid2 = self.uid2.map(|uid2| {
            let end = uid2.iter().rposition(|byte| *byte != 0).map_or(0, |last| last + 1);
            let hex: String = uid2[..end].iter().map(|byte| format!("{byte:02x}")).collect();
            format!("uid2-{hex}")
        });
        by_uid2.or_else(by_uid).map(VehicleKey)
    }
}

impl fmt::Display for VehicleKey {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.0)
    }
}

/// Who was writing a mission.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Writer {
    /// This program.
    Us,
    /// Another station.
    Another,
    /// Unknown: the record cannot be read, and may or may not have held a doubt.
    NotKnown,
}

/// Why the mission on board may be a mixture: an upload began and was not seen to end. A mission that is read then is
/// whole only if it is one of these two, or the one that was verified last.
#[derive(Debug, Clone, PartialEq)]
pub struct Doubt {
    /// Who was uploading.
    pub writer: Writer,
    /// The item list that was being sent, as on the wire, home included; `None` where it was not heard completely.
    pub sent: Option<Arc<Vec<MissionItemInt>>>,
    /// Fingerprint of the mission before; `None` if unknown.
    pub before: Option<u64>,
}

/// What is recorded of an aircraft's mission.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct PlanRecord {
    /// Items and fingerprint of the mission that was read back last.
    pub verified: Option<(u16, u64)>,
    /// Set from before an upload's first message until its end is verified.
    pub doubt: Option<Doubt>,
}

impl PlanRecord {
    /// Stands for a record that cannot be read: it may have held a doubt.
    pub fn damaged() -> Self {
        Self { verified: None, doubt: Some(Doubt { writer: Writer::NotKnown, sent: None, before: None }) }
    }
}

/// A record with its owner.
#[derive(Debug, Clone, PartialEq)]
pub struct StoredRecord {
    /// The aircraft.
    pub key: VehicleKey,
    /// Its system id when the record was written; `None` if unreadable.
    pub system: Option<SystemId>,
    /// The record.
    pub record: PlanRecord,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_vehicle_is_named_by_its_hardware() {
        let mut version = AutopilotVersion {
            flight_sw: 0.into(),
            git_hash: crate::telemetry::GitHash([0; 8]),
            capabilities: 0,
            board_version: 0,
            vendor_id: 0,
            product_id: 0,
            uid: None,
            uid2: None,
        };
        assert_eq!(HardwareIds::of_version(&version).key(), None);
        version.uid = Some(0xabc);
        let by_uid = HardwareIds::of_version(&version).key().expect("a uid");
        assert_eq!(by_uid.as_str(), "uid-0000000000000abc");
        let mut uid2 = [0; 18];
        uid2[..3].copy_from_slice(&[1, 0, 0xfe]);
        version.uid2 = Some(uid2);
        let by_uid2 = HardwareIds::of_version(&version).key().expect("a uid2");
        assert_eq!(by_uid2.as_str(), "uid2-0100fe");
        for key in [by_uid, by_uid2, VehicleKey::of_system(SystemId(1))] {
            assert_eq!(VehicleKey::parse(key.as_str()), Some(key));
        }
        let systems = ["system-7", "uid-0000000000000007", "system-700"].map(|name| VehicleKey::parse(name)?.system());
        assert_eq!(systems, [Some(SystemId(7)), None, None]);
        for name in ["", "uid", "uid-../../etc/passwd", "system-", "system-1/..", "uid2-", "x-1"] {
            assert_eq!(VehicleKey::parse(name), None, "{name}");
        }
    }
}
