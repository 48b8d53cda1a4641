//! Limits of old firmware, by what the vehicle reports of itself.
//!
//! The reference is ArduPlane 3.x on the APM 2: MAVLink 1 only; mission items as floats (MISSION_ITEM), fences and
//! rally points by messages of their own; commands by COMMAND_LONG only; rates by REQUEST_DATA_STREAM; modes by
//! SET_MODE (its DO_SET_MODE takes `MAV_MODE`); a guided target as a mission item with `current` = 2, a guided height
//! with 3; no TIMESYNC, HOME_POSITION or MAVFTP. It sends no AUTOPILOT_VERSION, or one without the capabilities below.

use vencejo_flight::plan::Keeping;
use vencejo_proto::MavVersion;

use super::Vehicle;
use crate::telemetry::AutopilotVersion;
use crate::transfer::{ItemForm, NoPlanKinds};

impl Vehicle {
    /// Whether it reports one of these capabilities; `None` when nothing can be concluded.
    ///
    /// MAVFTP (2019) is newer than all capabilities queried here. Autopilots other than ArduPilot omit bits that they
    /// should set.
    fn says_it_has(&self, capability: u64) -> Option<bool> {
        let Some(version) = self.telemetry.version.map(|version| version.value) else {
            let is_old = self.is_ardupilot() && self.protocol == MavVersion::V1;
            return is_old.then_some(false);
        };
        let has = version.capabilities & (capability | AutopilotVersion::FTP) != 0;
        (has || self.is_ardupilot()).then_some(has)
    }

    /// Whether COMMAND_INT may be sent.
    pub(super) fn has_command_int(&self) -> bool {
        self.says_it_has(AutopilotVersion::COMMAND_INT) != Some(false)
    }

    /// The message that carries plan items.
    pub(super) fn item_form(&self) -> ItemForm {
        match self.says_it_has(AutopilotVersion::MISSION_INT) {
            Some(true) => ItemForm::Integer,
            Some(false) => ItemForm::Float,
            None => ItemForm::Unknown,
        }
    }

    /// How it stores items.
    pub fn keeping(&self) -> Keeping {
        Keeping { is_ardupilot: self.is_ardupilot(), in_floats: self.item_form() == ItemForm::Float }
    }

    /// Why fences and rally points cannot go by the item protocol.
    pub(super) fn no_plan_kinds(&self) -> Option<NoPlanKinds> {
        if self.item_form() == ItemForm::Float {
            Some(NoPlanKinds::OldFirmware)
        } else {
            (self.protocol == MavVersion::V1).then_some(NoPlanKinds::Mavlink1)
        }
    }

    /// Whether MAVFTP is worth trying: every ArduPilot since 2021 has it; one that does not answer is served item by
    /// item.
    pub(super) fn may_have_ftp(&self) -> bool {
        match self.telemetry.version {
            Some(version) => version.value.has_ftp(),
            None => self.is_ardupilot() && self.protocol == MavVersion::V2,
        }
    }
}
