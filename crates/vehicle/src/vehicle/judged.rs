//! What a PX4's own checks say: of arming, as texts in the way of other autopilots, and of a mission that it has stored. It
//! acknowledges every mission whose items it knows, and then checks whether it can fly them (`FeasibilityChecker`): one that
//! fails counts as no mission, with its reason as an event, and not always as a text.

use std::time::Duration;

use vencejo_flight::plan::PlanKind;
use vencejo_proto::dialect::MavMessage;
use vencejo_proto::{Message, MonoTime, StatusText};

use super::Vehicle;
use super::operation::State;
use crate::events::REJECTED;
use crate::modes::ModeFamily;
use crate::plan_state::PlanState;
use crate::request::{Output, Reply};
use crate::telemetry::{MissionState, Severity, Text};
use crate::transfer::TransferError;

/// How long after the read-back its checks may take: a MISSION_CURRENT from before may be about the mission before.
const CHECKED_AFTER: Duration = Duration::from_millis(500);
/// How long a MISSION_CURRENT from after that may take: it comes twice a second.
const TOLD_WITHIN: Duration = Duration::from_millis(3_000);
/// Texts of the same words within this are one: what PX4 tells by an event, it may tell by a text too.
const SAME_WITHIN: Duration = Duration::from_secs(2);

fn words(text: &str) -> String {
    text.chars().filter(char::is_ascii_alphanumeric).map(|letter| letter.to_ascii_lowercase()).collect()
}

impl Vehicle {
    pub(super) fn on_event_message(&mut self, message: &Message, now: MonoTime) {
        if self.family() != Some(ModeFamily::Px4) {
            return;
        }
        let request = match message {
            Message::Dialect(MavMessage::EVENT(event)) => {
                let (rejection, request) = self.events.on_event(event, now);
                if let Some(reason) = rejection {
                    self.say(Severity(3), format!("{REJECTED}{reason}"), now);
                    self.end_judging();
                }
                request
            }
            Message::Dialect(MavMessage::CURRENT_EVENT_SEQUENCE(told)) => self.events.on_sequence(told),
            Message::Dialect(MavMessage::RESPONSE_EVENT_ERROR(error)) if message.target().includes(self.our) => {
                self.events.on_error(error);
                None
            }
            _ => None,
        };
        if self.speaks() {
            self.outputs.extend(request.map(Output::Send));
        }
    }

    /// Tells what keeps it from being armed among its texts, where PX4 has not.
    pub(super) fn tell_checks(&mut self, now: MonoTime) {
        let stands = self.telemetry.is_armed() == Some(false) && !self.is_lost;
        let mode = self.telemetry.mode().filter(|_| stands);
        for (severity, text) in self.events.due_texts(mode, now) {
            self.say(severity, text, now);
        }
    }

    fn say(&mut self, severity: Severity, text: String, now: MonoTime) {
        let same = words(&text);
        let is_lately = |told: &&Text| now.since(told.at) <= SAME_WITHIN;
        let is_told = self.texts.iter().rev().take_while(is_lately).any(|told| words(&told.text) == same);
        if !is_told {
            let text = StatusText { severity: severity.0, text, id: 0, chunk_seq: 0 };
            self.on_text(self.address.component, &text, now);
        }
    }

    /// Ends an upload: that of a mission to a PX4, which `began` then, once its checks have told.
    pub(super) fn finish_upload(&mut self, index: usize, reply: Reply, began: MonoTime, now: MonoTime) {
        let is_mission =
            matches!(reply, Reply::Plan { kind: PlanKind::Mission, state: PlanState::Verified { .. }, .. });
        let tells = self.telemetry.mission.is_none_or(|mission| mission.value.state.is_some());
        if is_mission && tells && self.family() == Some(ModeFamily::Px4) {
            let (from, until) = (now + CHECKED_AFTER, now + TOLD_WITHIN);
            self.ops[index].state = State::Judging { reply: Box::new(reply), began, from, until };
        } else {
            self.finish(index, Ok(reply));
        }
    }

    /// Ends uploads whose missions' checks have been told: MISSION_CURRENT or an event has come.
    pub(super) fn end_judging(&mut self) {
        let Some(told_at) = self.telemetry.mission.map(|mission| mission.at) else { return };
        let mut index = 0;
        while index < self.ops.len() {
            match self.ops[index].state {
                State::Judging { from, .. } if told_at < from => index += 1,
                // The reason of a rejection may still be on its way.
                State::Judging { began, from, .. } if self.rejection(began, from).is_none_or(|why| !why.is_empty()) => {
                    self.end_judgement(index);
                }
                _ => index += 1,
            }
        }
    }

    /// Ends an upload by what is known of its mission now.
    pub(super) fn end_judgement(&mut self, index: usize) {
        if let State::Judging { reply, began, from, .. } = std::mem::replace(&mut self.ops[index].state, State::Ready) {
            let rejection = self.rejection(began, from);
            self.finish(index, rejection.map_or(Ok(*reply), |reasons| Err(TransferError::Rejected { reasons }.into())));
        }
    }

    /// Why the mission on board cannot be flown, by the checks of a PX4 as told since `from`; without a reason where none was
    /// told since the upload `began`. Before it knows its height it cannot check, and counts the mission as none without a
    /// reason.
    fn rejection(&self, began: MonoTime, from: MonoTime) -> Option<Vec<String>> {
        let mission = self.telemetry.mission.filter(|mission| mission.at >= from)?.value;
        if mission.state != Some(MissionState::NoMission) || mission.total == Some(0) {
            return None;
        }
        let mut reasons = self.events.rejections(began);
        if reasons.is_empty() {
            for text in self.texts.iter().filter(|text| text.at >= began && text.text.starts_with(REJECTED.trim())) {
                if !reasons.contains(&text.text) {
                    reasons.push(text.text.clone());
                }
            }
        }
        (!reasons.is_empty() || self.telemetry.home.is_some()).then_some(reasons)
    }
}
