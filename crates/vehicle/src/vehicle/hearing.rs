//! Whether the vehicle hears us: which of its messages are answers, what is asked when none comes, and what then ends.

use vencejo_flight::plan::Command;
use vencejo_proto::dialect::MavMessage;
use vencejo_proto::{Message, MonoTime};

use super::Vehicle;
use crate::command::CommandMessage;
use crate::reach::Probe;
use crate::request::{Output, VehicleEvent};
use crate::transfer::{ItemForm, TransferError, TransferOutput};

/// Whether a message is an answer about a command, a plan, parameters or files.
pub(crate) fn is_answer(message: &Message) -> bool {
    matches!(
        message,
        Message::CommandAck(_)
            | Message::MissionAck(_)
            | Message::MissionItemInt(_)
            | Message::MissionItemFloat(_)
            | Message::Dialect(
                MavMessage::MISSION_REQUEST_INT(_)
                    | MavMessage::MISSION_REQUEST(_)
                    | MavMessage::MISSION_COUNT(_)
                    | MavMessage::FILE_TRANSFER_PROTOCOL(_)
                    | MavMessage::PARAM_ERROR(_)
                    | MavMessage::PARAM_VALUE(_)
            )
    )
}

impl Vehicle {
    /// Whether its firmware is too old to answer TIMESYNC.
    fn is_of_old(&self) -> bool {
        self.item_form() == ItemForm::Float
    }

    /// When to call [`Self::look_whether_reached`] or [`Self::end_unreached`] next.
    pub(super) fn reach_deadline(&self) -> Option<MonoTime> {
        let of_old = self.is_of_old();
        let lanes = [&self.transfer, &self.param].into_iter().flatten().filter(|lane| !lane.is_answered);
        let given_up = lanes.filter_map(|lane| self.reach.gives_up_at(lane.began));
        [self.reach.probe_at(of_old), self.reach.verdict_at(of_old)].into_iter().flatten().chain(given_up).min()
    }

    /// Asks again when an answer is late, and reports when none has come for long.
    pub(super) fn look_whether_reached(&mut self, now: MonoTime) {
        let of_old = self.is_of_old();
        let question = match self.reach.due_probe(of_old, now) {
            Some(Probe::TimeSync) => Some(self.timesync.ask(now)),
            // Every version acknowledges it, even without supporting it; it changes nothing.
            Some(Probe::Command) => {
                let params = [1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0];
                let command = CommandMessage::long(self.address, Command::REQUEST_AUTOPILOT_CAPABILITIES, params);
                Some(command.to_message())
            }
            None => None,
        };
        self.outputs.extend(question.map(Output::Send));
        if self.reach.turns_unreached(of_old, now) {
            self.event(VehicleEvent::Unreached);
        }
    }

    /// Notes answers to us. TIMESYNC is matched by its own time, where it is read.
    pub(super) fn note_answer(&mut self, message: &Message, now: MonoTime) {
        if !is_answer(message) || !message.target().includes(self.our) {
            return;
        }
        let is_command = matches!(message, Message::CommandAck(_));
        let is_param = matches!(message, Message::Dialect(MavMessage::PARAM_VALUE(_)));
        // Parameters are broadcast, also when others requested them.
        if is_param && self.transfer.is_none() && self.param.is_none() {
            return;
        }
        if !is_command {
            for lane in [&mut self.transfer, &mut self.param].into_iter().flatten() {
                lane.is_answered = true;
            }
        }
        let is_news = if is_command { self.reach.on_command_answered(now) } else { self.reach.on_answer(now) };
        self.tell_reached(is_news);
    }

    pub(super) fn tell_reached(&mut self, is_news: bool) {
        if is_news {
            self.event(VehicleEvent::Reached);
        }
    }

    /// Ends transfers that the vehicle has not answered at all, once it is known not to hear us. A transfer in progress
    /// goes on: the vehicle may hold half of it.
    pub(super) fn end_unreached(&mut self, now: MonoTime) {
        for is_single in [false, true] {
            let slot = if is_single { &mut self.param } else { &mut self.transfer };
            let is_over = |began| self.reach.gives_up_at(began).is_some_and(|at| now >= at);
            let Some(mut lane) = slot.take_if(|lane| !lane.is_answered && is_over(lane.began)) else { continue };
            // In case it hears us after all, it must not wait for the rest.
            lane.machine.cancel(now);
            while let Some(output) = lane.machine.poll_output() {
                if let TransferOutput::Send(message) = output {
                    self.outputs.push_back(Output::Send(message));
                }
            }
            let waited = now.since(lane.began);
            self.on_transfer_ended(lane, Err(TransferError::Unreached { waited }), now);
            self.pump(now);
        }
    }
}
