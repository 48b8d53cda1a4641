//! Changes of the plans on board by other stations, as far as our links hear their messages to the vehicle and its
//! answers.

use std::sync::Arc;
use std::time::Duration;

use vencejo_flight::plan::PlanKind;
use vencejo_proto::dialect::{MavMessage, MavMissionType};
use vencejo_proto::ftp::{FtpOpcode, FtpPayload};
use vencejo_proto::{Address, Message, MissionAck, MonoTime};

use super::Vehicle;
use super::board::Incoming;
use crate::modes::ModeFamily;
use crate::plan_record::{Doubt, Writer};
use crate::plan_state::{PlanState, Unknown};
use crate::telemetry::Severity;
use crate::transfer::Others;

/// When the number of items on board has not changed for this long, no upload item by item is under way.
const COUNT_REST: Duration = Duration::from_secs(3);

fn kind_of(mission_type: MavMissionType) -> Option<PlanKind> {
    PlanKind::ALL.into_iter().find(|plan| plan.mission_type() == mission_type as u8)
}

impl Vehicle {
    /// A message to the vehicle from another station, or a raw message from a caller: it may change a plan.
    pub(super) fn on_written(&mut self, from: Address, message: &Message, now: MonoTime) {
        match message {
            Message::Dialect(MavMessage::MISSION_COUNT(count)) => {
                self.on_upload_begins(from, count.mission_type, count.count.into(), now);
            }
            Message::Dialect(MavMessage::MISSION_WRITE_PARTIAL_LIST(part)) => {
                self.on_upload_begins(from, part.mission_type, 0, now);
            }
            Message::Dialect(MavMessage::MISSION_CLEAR_ALL(clear)) => {
                for kind in PlanKind::ALL {
                    let is_all = clear.mission_type == MavMissionType::MAV_MISSION_TYPE_ALL;
                    if is_all || clear.mission_type as u8 == kind.mission_type() {
                        self.changed_elsewhere(kind, Others::Changed, now);
                    }
                }
            }
            Message::MissionItemInt(item) if item.mission_type == 0 => {
                if let Some(incoming) = self.goes_on(|incoming| incoming.from == from, now)
                    && let Some(place) = incoming.items.get_mut(usize::from(item.seq))
                {
                    *place = Some(*item);
                }
            }
            Message::MissionItemFloat(item) if item.mission_type == 0 && item.current < 2 => {
                self.goes_on(|incoming| incoming.from == from, now);
            }
            _ => {
                if let Some((_, request)) = FtpPayload::from_message(message) {
                    self.on_file_written(from, &request, now);
                }
            }
        }
    }

    /// Notes progress of another station's upload of a mission, if `is_this` accepts it.
    fn goes_on(&mut self, is_this: impl Fn(&Incoming) -> bool, now: MonoTime) -> Option<&mut Incoming> {
        if !self.on_board.incoming.as_ref().is_some_and(is_this) {
            return None;
        }
        self.beside_ours(PlanKind::Mission, Others::Write, now);
        let incoming = self.on_board.incoming.as_mut()?;
        (incoming.has_begun, incoming.heard_at) = (true, now);
        Some(incoming)
    }

    /// Another station writes a plan file by MAVFTP: it becomes the plan when the session is terminated.
    fn on_file_written(&mut self, from: Address, request: &FtpPayload, now: MonoTime) {
        match request.opcode {
            FtpOpcode::CREATE_FILE | FtpOpcode::OPEN_FILE_WO => {
                let path = String::from_utf8_lossy(&request.data);
                let is_of = |kind: &PlanKind| path.contains(&format!("@MISSION/{kind}.dat"));
                self.on_board.incoming_file =
                    PlanKind::ALL.into_iter().find(is_of).map(|kind| (from, kind)).or(self.on_board.incoming_file);
            }
            FtpOpcode::TERMINATE_SESSION | FtpOpcode::RESET_SESSIONS => {
                if let Some((_, kind)) = self.on_board.incoming_file.take_if(|(writer, _)| *writer == from) {
                    self.changed_elsewhere(kind, Others::Changed, now);
                }
            }
            _ => {}
        }
    }

    /// Another station begins to write a plan.
    fn on_upload_begins(&mut self, from: Address, kind: MavMissionType, count: usize, now: MonoTime) {
        let Some(kind) = kind_of(kind) else { return };
        if kind != PlanKind::Mission {
            return self.changed_elsewhere(kind, Others::Write, now);
        }
        let is_beside_ours = self.beside_ours(kind, Others::Write, now);
        let before = match self.on_board.incoming.take() {
            // The result of our own transfer decides what is known.
            _ if is_beside_ours => None,
            // MISSION_COUNT was repeated.
            Some(incoming) if incoming.from == from && !incoming.has_begun => incoming.before,
            _ => Some((self.plans.get(kind), self.on_board.doubt.clone())),
        };
        let items = vec![None; count.min(vencejo_flight::plan::MAX_ITEMS)];
        self.on_board.incoming = Some(Incoming { from, items, has_begun: false, heard_at: now, before });
        if is_beside_ours {
            return;
        }
        let doubt = Doubt { writer: Writer::Another, sent: None, before: self.before() };
        self.on_board.begin_doubt(doubt);
        self.set_plan(kind, PlanState::Unknown(Unknown::SentElsewhere));
        self.remember();
    }

    /// The vehicle requests an item, of us or of another station.
    pub(super) fn on_asks(&mut self, message: &Message, now: MonoTime) {
        let kind = match message {
            Message::Dialect(MavMessage::MISSION_REQUEST_INT(request)) => request.mission_type,
            Message::Dialect(MavMessage::MISSION_REQUEST(request)) => request.mission_type,
            _ => return,
        };
        if kind as u8 == PlanKind::Mission.mission_type() {
            self.goes_on(|incoming| message.target().includes(incoming.from), now);
        }
    }

    /// The id of a plan has changed. After our upload, any other id than that of our plan means another station's.
    pub(super) fn on_renamed(&mut self, kind: PlanKind, id: Option<u32>, now: MonoTime) {
        let lane = self.transfer.as_ref().filter(|lane| lane.is_about(kind));
        let ours = match lane {
            Some(lane) => lane.machine.written(0).and_then(|(_, ours)| ours),
            None => self.echo(kind, now).and_then(|written| written.plan_id),
        };
        match ours {
            Some(_) if ours == id => {}
            Some(_) => self.changed_elsewhere(kind, Others::Changed, now),
            None => self.told_changed(kind, now),
        }
    }

    /// MISSION_ACK for another station's upload. Returns whether it was one.
    pub(super) fn on_ack_to_another(&mut self, ack: &MissionAck, now: MonoTime) -> bool {
        let is_theirs = |incoming: &mut Incoming| {
            ack.mission_type == 0 && Message::MissionAck(*ack).target().includes(incoming.from)
        };
        /// A stray item; the vehicle goes on.
        const INVALID_SEQUENCE: u8 = 13;
        if ack.result == INVALID_SEQUENCE {
            return self.on_board.incoming.as_mut().is_some_and(is_theirs);
        }
        let others = if ack.result == 0 { Others::Finished } else { Others::Refused };
        let Some(incoming) = self.on_board.incoming.take_if(is_theirs) else {
            return false;
        };
        if self.beside_ours(PlanKind::Mission, others, now) {
            let home = self.first_seq();
            if let Some(lane) = &mut self.transfer
                && others == Others::Finished
                && lane.machine.written(home).is_some()
            {
                lane.theirs = Some(incoming);
            }
            return true;
        }
        if others == Others::Finished {
            self.on_board.end_doubt();
            self.set_plan(PlanKind::Mission, PlanState::Unknown(Unknown::ChangedElsewhere));
        } else if let Some((state, doubt)) = incoming.before.clone().filter(|_| !incoming.has_begun) {
            // Refused before anything was written.
            self.on_board.doubt = doubt;
            // Our copy of a known mission was dropped when the upload began: it is read again.
            let is_known = state.hash().is_some_and(|_| state != PlanState::Empty);
            self.set_plan(
                PlanKind::Mission,
                if is_known { PlanState::Unknown(Unknown::ChangedElsewhere) } else { state },
            );
        } else if incoming.has_begun {
            self.keep_heard(incoming);
        }
        self.remember();
        true
    }

    /// Another station's upload was abandoned. If all of its items were heard, the whole list may be on board.
    pub(super) fn keep_heard(&mut self, incoming: Incoming) {
        let items: Option<Vec<_>> = incoming.items.into_iter().collect();
        if let (Some(doubted), Some(items)) = (&mut self.on_board.doubt, items.filter(|items| !items.is_empty())) {
            doubted.doubt.sent = Some(Arc::new(items));
        }
    }

    /// The number of items on board by MISSION_CURRENT.
    pub(super) fn on_total(&mut self, total: u16, now: MonoTime) {
        let has_moved = self.on_board.total.replace(total).is_some_and(|before| before != total);
        let known = self.plans.get(PlanKind::Mission).count();
        if !has_moved && known.is_none_or(|known| known == total) || self.is_echo(PlanKind::Mission, now) {
            return;
        }
        if self.transfer.as_ref().is_some_and(|lane| lane.is_about(PlanKind::Mission)) {
            // Our own upload changes it too.
            return self.void(PlanKind::Mission, now);
        }
        if self.family() == Some(ModeFamily::Px4) {
            // It stores a list beside the one that it has, and then changes over to it: there is no mixture.
            return self.void(PlanKind::Mission, now);
        }
        self.on_board.moving_until = Some(now + COUNT_REST);
        if self.on_board.doubt.is_none() {
            let moving = match self.why_changed(PlanKind::Mission, now) {
                Unknown::ChangedElsewhere => Unknown::SentElsewhere,
                ours => ours,
            };
            self.set_plan(PlanKind::Mission, PlanState::Unknown(moving));
        }
    }

    /// An ArduPilot tells the length of a list: it does so to all when another station has written it, over whichever
    /// link (`AP_Mission::clear`, `AC_PolyFence_loader::write_fence`, `AP_Rally::append`).
    pub(super) fn on_list_total(&mut self, parameter: &str, now: MonoTime) {
        let kind = match parameter {
            "MIS_TOTAL" => PlanKind::Mission,
            "FENCE_TOTAL" => PlanKind::Fence,
            "RALLY_TOTAL" => PlanKind::Rally,
            _ => return,
        };
        if self.is_ardupilot() {
            let not_before = &mut self.on_board.not_before[kind as usize];
            *not_before = (*not_before).max(now + COUNT_REST);
            self.told_changed(kind, now);
        }
    }

    /// Another station changes a plan: what is known of it is void, and later messages about it are not echoes of our
    /// own writing.
    pub(super) fn changed_elsewhere(&mut self, kind: PlanKind, others: Others, now: MonoTime) {
        self.written[kind as usize] = None;
        if !self.beside_ours(kind, others, now) {
            self.void(kind, now);
        }
    }

    /// Another station acts on the plan that we are writing or reading. Returns whether we are writing: our own
    /// transfer then finds out the result.
    fn beside_ours(&mut self, kind: PlanKind, others: Others, now: MonoTime) -> bool {
        let home = u16::from(self.is_ardupilot() && kind == PlanKind::Mission);
        let Some(lane) = self.transfer.as_mut().filter(|lane| lane.is_about(kind)) else { return false };
        if !lane.machine.writes_plan() {
            lane.is_disturbed = true;
            return false;
        }
        let is_written = lane.machine.written(home).is_some();
        let is_news = is_written && others == Others::Write && !std::mem::replace(&mut lane.is_followed, true);
        if others != Others::Refused {
            lane.theirs = None;
        }
        lane.machine.on_others(others, now);
        if is_news {
            let text = format!("another station writes the {kind} after ours: it is read back when that has ended");
            self.note(Severity::WARNING, text, now);
        }
        true
    }
}
