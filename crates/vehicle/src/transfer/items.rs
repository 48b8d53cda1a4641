//! The item protocol: a plan to or from the vehicle, one message for each item
//! (<https://mavlink.io/en/services/mission.html>).
//!
//! What the vehicle holds after an upload is not checked here; [`super::plan`] reads it back.

mod download;
mod upload;

use std::collections::VecDeque;

use vencejo_flight::plan::PlanKind;
use vencejo_proto::dialect::MavMissionType;
use vencejo_proto::{Message, MissionAck};

use super::{MissionResult, TransferConfig, TransferOutput};

pub(crate) use download::ItemDownload;
pub(crate) use upload::{ItemUpload, ItemsSent};

/// ArduPilot answers an item that comes when it expects none with [`MissionResult::ERROR`]
/// (`GCS_MAVLINK::handle_mission_item`), so late copies of the last item bring some of them after an upload. This many
/// of our questions may be answered so.
const LATE_ERRORS: u32 = 3;

/// [`MissionResult::ERROR`]s that may belong to a previous upload. Late copies come in any number, but together: of
/// those between two questions of ours one counts. A real error answers each question.
#[derive(Debug, Default)]
struct LateErrors {
    questions: u32,
    is_counted: bool,
}

impl LateErrors {
    /// A question is sent.
    fn on_question(&mut self) {
        self.is_counted = false;
    }

    /// Whether the error that came may be late.
    fn may_be_late(&mut self) -> bool {
        self.questions += u32::from(!std::mem::replace(&mut self.is_counted, true));
        self.questions <= LATE_ERRORS
    }
}

/// Outputs of a machine. Bounded because the owner drains it after every call, which adds at most a window of items.
pub(crate) type Outbox = VecDeque<TransferOutput>;

pub(crate) fn mav_mission_type(kind: PlanKind) -> MavMissionType {
    match kind {
        PlanKind::Mission => MavMissionType::MAV_MISSION_TYPE_MISSION,
        PlanKind::Fence => MavMissionType::MAV_MISSION_TYPE_FENCE,
        PlanKind::Rally => MavMissionType::MAV_MISSION_TYPE_RALLY,
    }
}

/// Our MISSION_ACK to the vehicle.
pub(crate) fn ack(config: &TransferConfig, kind: PlanKind, result: MissionResult) -> Message {
    Message::MissionAck(MissionAck {
        target: config.vehicle,
        result: result.0,
        mission_type: kind.mission_type(),
        opaque_id: 0,
    })
}
