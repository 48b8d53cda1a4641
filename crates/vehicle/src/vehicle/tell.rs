//! Messages in place of commands, for old firmware: SET_MODE, MISSION_SET_CURRENT, and MISSION_ITEM for a guided
//! target. They have no COMMAND_ACK; their effect, or MISSION_ACK, proves them.
//!
//! Like an unanswered command they are repeated only when the vehicle's own reports show that they had no effect and
//! the mode was not changed by others meanwhile.

use std::time::Duration;

use vencejo_proto::{Message, MissionAck, MonoTime};

use super::Vehicle;
use super::operation::{Commanding, EFFECT_WITHIN, Seen, State, Telling};
use super::steps::Effect;
use crate::command::CommandResult;
use crate::error::VehicleError;

impl Vehicle {
    fn tell_again_after(&self) -> Duration {
        self.config.commands.timeout.max(self.round_trip().unwrap_or_default() * 2)
    }

    /// Sends a message in place of a command.
    pub(super) fn tell(&mut self, index: usize, mut command: Commanding, message: Message, now: MonoTime) {
        command.last_sent = now;
        let wants_ack = matches!(message, Message::MissionItemFloat(_));
        self.reach.on_question(now);
        self.outputs.push_back(super::Output::Send(message.clone()));
        let (retry_at, until) = (now + self.tell_again_after(), now + EFFECT_WITHIN);
        let telling =
            Telling { command, message, wants_ack, has_ack: false, attempts: 1, retry_at, until, is_overdue: false };
        self.ops[index].state = State::Telling(Box::new(telling));
    }

    /// Whether a MISSION_ACK answers a guided target or altitude, and not a plan.
    pub(super) fn on_guided_ack(&mut self, ack: &MissionAck, now: MonoTime) -> bool {
        let is_waiting = |state: &State| matches!(state, State::Telling(telling) if telling.waits_for_ack());
        let Some(index) = self.ops.iter().position(|op| is_waiting(&op.state)) else { return false };
        if ack.mission_type != 0 || self.transfer.is_some() {
            return false;
        }
        let State::Telling(telling) = &mut self.ops[index].state else { return false };
        if ack.result == 0 {
            telling.has_ack = true;
            self.check_telling(index, now);
        } else {
            // A command's refusal has no MAV_MISSION_RESULT; its text goes with the reasons.
            let reasons = vec![crate::transfer::MissionResult(ack.result).to_string()];
            let error = VehicleError::CommandRefused {
                target: self.address.into(),
                command: telling.command.name(),
                result: CommandResult::FAILED,
                reasons,
                cure: None,
            };
            self.finish(index, Err(error));
        }
        true
    }

    /// Checks whether the sent message has taken effect.
    pub(super) fn check_telling(&mut self, index: usize, now: MonoTime) {
        let State::Telling(telling) = &self.ops[index].state else { return };
        let command = &telling.command;
        let seen = self.seen(command);
        let is_shown = command.effect == Effect::Acknowledged || seen == Seen::Shown;
        // A change of mode proves that the message came; a mode that was there before does not.
        let is_change = command.effect.mode().is_some_and(|mode| command.mode_before != Some(mode));
        if is_shown && (!telling.waits_for_ack() || is_change) {
            if matches!(command.effect, Effect::Current(_) | Effect::NotBefore(_) | Effect::AtBeginning(_)) {
                self.on_jump();
            }
            let id = self.ops[index].id;
            self.ops[index].state = State::Ready;
            self.advance(id, now);
        } else if telling.is_overdue && seen != Seen::NotYet {
            let error = self.not_confirmed(command, now);
            self.finish(index, Err(error));
        }
    }

    /// Repeats messages without effect, or gives them up.
    pub(super) fn tell_again(&mut self, now: MonoTime) {
        let mut index = 0;
        while index < self.ops.len() {
            let error = match &self.ops[index].state {
                State::Telling(telling) if now >= telling.deadline() => self.retold(telling, now),
                _ => {
                    index += 1;
                    continue;
                }
            };
            if let Some(error) = error {
                self.finish(index, Err(error));
                continue;
            }
            let again = self.tell_again_after();
            let State::Telling(telling) = &self.ops[index].state else { continue };
            // Without a report since the last transmission nothing is known.
            let is_silent =
                telling.command.effect != Effect::Acknowledged && self.seen(&telling.command) == Seen::NotYet;
            let State::Telling(telling) = &mut self.ops[index].state else { continue };
            telling.retry_at = now + again;
            if !is_silent && !telling.has_ack {
                telling.attempts += 1;
                telling.command.last_sent = now;
                self.outputs.push_back(super::Output::Send(telling.message.clone()));
            }
            index += 1;
        }
    }

    /// Why a message is not repeated.
    fn retold(&self, telling: &Telling, now: MonoTime) -> Option<VehicleError> {
        let command = &telling.command;
        if matches!(self.seen(command), Seen::Overtaken(_)) {
            return Some(self.not_confirmed(command, now));
        }
        (now >= telling.until).then(|| {
            if telling.waits_for_ack() {
                VehicleError::CommandTimeout {
                    target: self.address.into(),
                    command: command.name(),
                    attempts: telling.attempts,
                    reasons: Vec::new(),
                }
            } else {
                self.not_confirmed(command, now)
            }
        })
    }
}
