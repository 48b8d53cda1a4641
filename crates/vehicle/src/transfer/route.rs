//! The protocols that carry a plan to and from the vehicle.

use vencejo_flight::plan::PlanKind;

use super::{ItemForm, TransferConfig, TransferError};

/// The protocol that carries a plan.
///
/// The policy:
///
/// 1. An ArduPilot that announces MAVFTP gets the whole plan as a file, which is many times faster and replaces the old plan
///    at once. Everything else, and an ArduPilot whose MAVFTP does not answer, refuses, is used by another station, or did
///    not take the file as it was, goes item by item; there the vehicle names the item that it refuses. An empty plan goes
///    item by item too. A vehicle that falls silent is not asked again by another route.
/// 2. Items go as MISSION_ITEM_INT. They go as MISSION_ITEM, with positions in 32-bit floats, when
///    [`TransferConfig::item_form`] says that the vehicle has only that ([`ItemForm::Float`]: its AUTOPILOT_VERSION lacks
///    `MAV_PROTOCOL_CAPABILITY_MISSION_INT`, or it is an ArduPilot on MAVLink 1 that has none). When it is not known
///    ([`ItemForm::Unknown`]), MISSION_ITEM_INT is tried, and given up for MISSION_ITEM when the vehicle answers everything
///    but that: an upload, when it asks for the first item by MISSION_REQUEST a third time; a download, when
///    MISSION_REQUEST_LIST is answered but for 2 s and two tries no MISSION_REQUEST_INT is. That a vehicle asks by MISSION_REQUEST is no
///    sign by itself: ArduPlane of today does, also for an upload of MISSION_ITEM_INT. Both ways back begin anew with
///    MISSION_COUNT or MISSION_REQUEST_LIST, before the first item has gone over.
/// 3. What went as floats is not what was meant to the last digit: it counts as the plan that was sent when every position
///    is within what the roundings can do ([`VerifiedPlan::position_error_m`](super::VerifiedPlan) says how far off the worst is). Parameter 4 of
///    a position (whence the track after a loiter is counted) may be lost, because ArduPlane 3.x has no room for it; any
///    other parameter that it does not keep, such as the radius of a loiter without end, is [`TransferError::NotAsSent`].
/// 4. Fences and rally points go by the item protocol only where a message says which plan it is about
///    ([`TransferConfig::no_plan_kinds`]); else [`TransferError::OnlyMission`], and nothing is sent. By file they go.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum PlanRoute {
    /// As a plan file over MAVFTP.
    Ftp,
    /// By the item protocol.
    Items,
    /// By the item protocol, positions in 32-bit floats.
    FloatItems,
}

impl PlanRoute {
    /// The route to try first.
    pub fn first(config: &TransferConfig) -> Self {
        if config.is_ardupilot && config.has_ftp { Self::Ftp } else { Self::items(config) }
    }

    /// The item-by-item route.
    pub(super) fn items(config: &TransferConfig) -> Self {
        if config.item_form == ItemForm::Float { Self::FloatItems } else { Self::Items }
    }

    /// The message that it carries items in.
    pub(super) fn form(self, config: &TransferConfig) -> ItemForm {
        match (self, config.item_form) {
            (Self::FloatItems, _) => ItemForm::Float,
            (_, ItemForm::Unknown) => ItemForm::Unknown,
            _ => ItemForm::Integer,
        }
    }

    /// The route to try after this one failed, if there is one.
    pub fn after(self, error: &TransferError, config: &TransferConfig, kind: PlanKind) -> Option<Self> {
        let by_items = matches!(
            error,
            TransferError::Ftp { .. }
                | TransferError::FtpBusy { .. }
                | TransferError::BadFile { .. }
                | TransferError::TooMany { .. }
                | TransferError::NoProgress { .. }
                | TransferError::NotAsSent { .. }
                | TransferError::FtpAbsent { .. }
        );
        match self {
            Self::Ftp => (by_items && config.refuses_items(kind).is_none()).then(|| Self::items(config)),
            Self::Items => matches!(error, TransferError::IntegerItemsIgnored).then_some(Self::FloatItems),
            Self::FloatItems => None,
        }
    }
}
