//! Running requests: their commands, the effects that prove them, their results.

use std::time::Duration;

use vencejo_flight::plan::{Command, MissionItem};
use vencejo_proto::{Message, MonoTime};

use super::Vehicle;
use super::operation::{Commanding, EFFECT_WITHIN, Op, Seen, State, WORD_WITHIN};
use super::steps::{Effect, Fallback, Step};
use crate::command::{CommandId, CommandMessage, CommandOutcome, CommandOutput, CommandResult, Unanswered, WhenBusy};
use crate::error::VehicleError;
use crate::modes::{Action, FlightMode, ModeFamily};
use crate::request::{Output, Reply, Request, RequestId};
use crate::telemetry::{LOST_AFTER, LandedState, MissionState, Severity, Text};

/// Most requests running or waiting at once; more are refused.
pub(super) const MAX_REQUESTS: usize = 64;
/// How long a requested message may take.
const MESSAGE_WITHIN: Duration = Duration::from_secs(2);
/// How long to wait for the vehicle's texts about a target that it has accepted, and about a refusal; for arming they
/// are a list.
const OBJECTED_WITHIN: Duration = Duration::from_millis(1_000);
const REASONS_AFTER: Duration = Duration::from_millis(400);
const ARM_REASONS_AFTER: Duration = Duration::from_millis(1_000);
/// What PX4 writes of a target that it does not take (`navigator_main.cpp`).
const OBJECTION: &str = "outside geofence";
/// How texts about failing checks begin, of ArduPilot and of PX4.
const CHECKS: [&str; 3] = ["PreArm: ", "Arm: ", "Preflight Fail: "];
/// ArduPilot repeats failing pre-arm checks every 30 s; those are used when it is silent at the refusal. PX4 writes each
/// when it begins to fail, and at a refusal only that something does.
const PREARM_REPEATED: Duration = Duration::from_secs(35);
/// Words of a NOTICE or INFO by which ArduPilot says why it does not do what was asked ("Mode change to LOITER denied,
/// in fence recovery", "Parachute not enabled", "Disarm to allow calibration"); such texts are not warnings.
const DENIALS: [&str; 7] = ["denied", "disabled", "not enabled", "failed", "unable", "q_enable", "disarm to"];
/// What stands before the number of the message that ArduPilot's texts about rates are about: "No ap_message for mavlink
/// id (133)", "Requested rate for message ID 27 too fast". Rates that a station asks for are refused in between.
const NAMES_MESSAGE: [&str; 2] = ["mavlink id (", "message ID "];
/// Most reasons that an error carries.
const MAX_REASONS: usize = 16;

/// Whether a text is about a message, and the command is not about that one.
fn is_of_other(text: &str, command: &Commanding) -> bool {
    let named = NAMES_MESSAGE.iter().find_map(|words| Some(text.split_once(words)?.1));
    let named = named.and_then(|rest| rest.split(|c: char| !c.is_ascii_digit()).next()?.parse::<u16>().ok());
    let is_about = matches!(command.message.command(), Command::SET_MESSAGE_INTERVAL | Command::REQUEST_MESSAGE);
    named.is_some_and(|number| !is_about || f32::from(number) != command.message.first_param())
}

impl Vehicle {
    /// Ends waits that have timed out.
    pub(super) fn end_waits(&mut self, now: MonoTime) {
        for index in 0..self.ops.len() {
            self.wait_for_a_word(index, now);
        }
        self.tell_again(now);
        let mut index = 0;
        while index < self.ops.len() {
            let result = match &self.ops[index].state {
                State::Awaiting { command, until, .. } if now >= *until && command.effect == Effect::Unobjected => {
                    let command = command.clone();
                    if self.reasons(&command, now).iter().any(|text| text.contains(OBJECTION)) {
                        Some(Err(self.refused(&command, CommandResult::DENIED, now)))
                    } else {
                        let id = self.ops[index].id;
                        self.ops[index].state = State::Ready;
                        self.advance(id, now);
                        continue;
                    }
                }
                State::Refused { command, result, until } if now >= *until => {
                    Some(Err(self.refused(command, *result, now)))
                }
                State::Awaiting { command, until, .. } if now >= *until => Some(Err(self.not_confirmed(command, now))),
                State::Judging { until, .. } if now >= *until => {
                    self.end_judgement(index);
                    continue;
                }
                _ => None,
            };
            match result {
                Some(result) => self.finish(index, result),
                None => index += 1,
            }
        }
    }

    fn refused(&self, command: &Commanding, result: CommandResult, now: MonoTime) -> VehicleError {
        let reasons = self.reasons(command, now);
        let mode = self.telemetry.mode().filter(|_| command.effect == Effect::Armed(true));
        let cure = mode.and_then(|mode| mode.curing(&reasons));
        VehicleError::CommandRefused {
            target: command.message.target().into(),
            command: command.name(),
            result,
            reasons,
            cure,
        }
    }

    pub(super) fn not_confirmed(&self, command: &Commanding, now: MonoTime) -> VehicleError {
        let is_since = |at: MonoTime| at >= self.telling_from(command);
        let heartbeat = self.telemetry.heartbeat.filter(|heartbeat| is_since(heartbeat.at));
        let mission = self.telemetry.mission.filter(|mission| is_since(mission.at));
        let shown = |text: Option<String>| text.unwrap_or_else(|| "nothing".to_owned());
        // Counted from 1, as everywhere: item 0 is the home of an ArduPilot.
        let item = |seq: u16| format!("item {}", seq + 1 - self.first_seq());
        let armed = |is_armed: bool| if is_armed { "armed" } else { "disarmed" }.to_owned();
        let (wanted, observed) = match command.effect {
            Effect::Received(message_id) => return VehicleError::MessageNotReceived { message_id },
            Effect::Armed(is_armed) => (armed(is_armed), shown(heartbeat.map(|h| armed(h.value.is_armed)))),
            Effect::Mode(mode) | Effect::MissionMode { mode, .. } => {
                let is_idle = |shown: FlightMode| shown == mode && command.effect != Effect::Mode(mode);
                let without = |shown| if is_idle(shown) { " without a running mission" } else { "" };
                // ArduPlane takes the position for its target whatever comes of the mode.
                let target = if command.message.command() == Command::DO_REPOSITION {
                    "; it may fly there all the same"
                } else {
                    ""
                };
                let observed = heartbeat.map(|h| format!("mode {}{}{target}", h.value.mode, without(h.value.mode)));
                (format!("mode {mode}"), shown(observed))
            }
            Effect::NotBefore(seq) | Effect::Current(seq) => (item(seq), shown(mission.map(|m| item(m.value.seq)))),
            Effect::AtBeginning(last) => {
                let wanted = format!("the mission's beginning ({})", item(last));
                (wanted, shown(mission.map(|m| item(m.value.seq))))
            }
            Effect::Acknowledged
            | Effect::Airborne
            | Effect::JumpedFrom(_)
            | Effect::JumpedTo { .. }
            | Effect::Restarted
            | Effect::Unobjected => ("its effect".to_owned(), shown(None)),
        };
        VehicleError::NotConfirmed {
            command: command.name(),
            wanted,
            observed,
            within: now.since(command.first_sent),
            reasons: self.reasons(command, now),
        }
    }

    /// What the vehicle wrote about a command: failing checks for arming, else warnings and worse since it was sent,
    /// and what says as a notice or information that something was denied. Why it does not send a message so often
    /// ArduPilot tells as information too.
    pub(super) fn reasons(&self, command: &Commanding, now: MonoTime) -> Vec<String> {
        let is_check = |text: &&Text| CHECKS.iter().any(|begin| text.text.starts_with(begin));
        let is_of_rate = command.message.command() == Command::SET_MESSAGE_INTERVAL;
        let is_denial = |text: &str| {
            let text = text.to_lowercase();
            DENIALS.iter().any(|words| text.contains(words)) || is_of_rate && text.contains("message")
        };
        let is_warning = |text: &&Text| {
            text.severity <= Severity::WARNING || text.severity <= Severity::INFO && is_denial(&text.text)
        };
        let since = |moment: MonoTime| {
            let texts = self.texts.iter().rev();
            let of_it = |text: &&Text| text.component == self.address.component && !is_of_other(&text.text, command);
            texts.take_while(move |text| text.at >= moment).filter(of_it)
        };
        let is_arming = command.effect == Effect::Armed(true);
        let is_px4 = self.family() == Some(ModeFamily::Px4);
        // It reports them again when it refuses.
        let mode = if is_arming { self.telemetry.mode() } else { command.effect.mode() };
        let failing = mode.filter(|_| is_px4).and_then(|mode| self.events.failing(mode));
        let mut found: Vec<&Text> =
            if is_arming { since(command.first_sent).filter(is_check).collect() } else { Vec::new() };
        if found.is_empty() {
            found = since(command.first_sent).filter(is_warning).collect();
        }
        if is_arming && failing.is_none() && (found.is_empty() || is_px4) {
            let age = now.as_duration().saturating_sub(PREARM_REPEATED);
            found.extend(since(MonoTime::from_origin(age)).filter(is_check));
        }
        let mut reasons: Vec<String> = Vec::new();
        for text in found.into_iter().rev() {
            if !reasons.contains(&text.text) && reasons.len() < MAX_REASONS {
                reasons.push(text.text.clone());
            }
        }
        for (_, text) in failing.iter().flatten() {
            if !reasons.contains(text) && reasons.len() < MAX_REASONS {
                reasons.push(text.clone());
            }
        }
        if is_arming && is_px4 && failing.is_none() {
            reasons.extend(self.lacks_mission());
        }
        let is_forced =
            |message: &CommandMessage| matches!(message, CommandMessage::Long(long) if long.params[1] != 0.0);
        if is_arming && is_px4 && is_forced(&command.message) {
            reasons.push("a PX4 runs its checks also when it is to be armed by force".to_owned());
        }
        reasons
    }

    /// Why a PX4 does not arm in AUTO_MISSION, which it tells by no text.
    fn lacks_mission(&self) -> Option<String> {
        let mode = self.telemetry.mode().filter(|mode| mode.follows_mission())?;
        let is_none = self.telemetry.mission?.value.state == Some(MissionState::NoMission);
        is_none.then(|| format!("mode {mode}, and no mission on board that it can fly"))
    }

    /// Starts a request. Its result comes as [`Output::Finished`], also for an immediate refusal.
    pub fn request(&mut self, request: Request, now: MonoTime) -> RequestId {
        let id = RequestId(self.next_request);
        self.next_request += 1;
        self.has_requested |= !matches!(request, Request::Note { .. });
        if let Err(error) = self.begin(id, request, now) {
            self.outputs.push_back(Output::Finished { id, result: Err(error) });
        }
        self.pump(now);
        id
    }

    pub(super) fn begin(&mut self, id: RequestId, mut request: Request, now: MonoTime) -> Result<(), VehicleError> {
        if self.pending() >= MAX_REQUESTS {
            return Err(VehicleError::TooManyRequests { limit: MAX_REQUESTS });
        }
        let mut despite_mixed_plan = false;
        while let Request::DespiteMixedPlan(inner) = request {
            (despite_mixed_plan, request) = (true, *inner);
        }
        let wants_acknowledgement = matches!(request, Request::RawCommandLong(_) | Request::RawCommandInt(_));
        let rate = match request {
            Request::SetMessageRate { message, rate_hz } => Some((message.0, rate_hz)),
            _ => None,
        };
        let mut steps = self.context(now).steps(request)?;
        self.guard_steps(&steps, despite_mixed_plan, now)?;
        if let Some((message_id, rate)) = rate {
            self.streams.set_rate(message_id, rate)?;
        }
        if let Some(copy) = self.fresh_copy(steps.make_contiguous(), now) {
            self.outputs.push_back(Output::Finished { id, result: Ok(copy) });
            return Ok(());
        }
        let is_transfer =
            |step: &Step| matches!(step, Step::Upload(..) | Step::Download(_) | Step::Clear(_) | Step::ParamList);
        // MISSION_ACK answers a guided target too: it could not be distinguished from another's or a plan's.
        let is_guided = |step: &Step| matches!(step, Step::Tell { message: Message::MissionItemFloat(_), .. });
        let needs_lane = steps.iter().any(|step| is_transfer(step) || is_guided(step));
        if self.make_room(id, steps.make_contiguous(), needs_lane, now) {
            return Ok(());
        }
        let is_guiding = self.ops.iter().any(|op| matches!(op.state, State::Telling(ref telling) if telling.wants_ack));
        if steps.iter().any(is_guided) && (self.transfer.is_some() || is_guiding) {
            let running = self.transfer.as_ref().map_or("guided target", |lane| lane.machine.name());
            return Err(VehicleError::TransferBusy { running });
        }
        if steps.iter().any(is_transfer) && is_guiding {
            return Err(VehicleError::TransferBusy { running: "guided target" });
        }
        let is_recording = || self.ops.iter().any(|op| matches!(op.state, State::Recording { .. }));
        if needs_lane && is_recording() {
            return Err(VehicleError::TransferBusy { running: "plan upload" });
        }
        if steps.iter().any(is_transfer)
            && let Some(running) = &self.transfer
        {
            return Err(VehicleError::TransferBusy { running: running.machine.name() });
        }
        self.ops.push(Op { wants_acknowledgement, ..Op::new(id, steps) });
        self.advance(id, now);
        Ok(())
    }

    /// Cancels a request; its result is [`VehicleError::Cancelled`]. A command that was sent may still be executed.
    pub fn cancel(&mut self, id: RequestId, now: MonoTime) {
        let Some(index) = self.ops.iter().position(|op| op.id == id) else { return };
        match &self.ops[index].state {
            State::Transferring => {
                for lane in [&mut self.transfer, &mut self.param].into_iter().flatten() {
                    if lane.id == id {
                        lane.cancel(now);
                    }
                }
                // The lane ends the request.
                self.pump(now);
                return;
            }
            State::Commanding { id: command, .. } => self.commands.forget(*command, now),
            State::Recording { before, .. } => {
                let before = before.clone();
                self.take_back(before);
            }
            _ => {}
        }
        self.finish(index, Err(VehicleError::Cancelled));
        self.pump(now);
    }

    /// Cancels all requests: the vehicle or its owner goes away. Each result still comes as [`Output::Finished`].
    pub fn close(&mut self, now: MonoTime) {
        let ids: Vec<_> = self.ops.iter().map(|op| op.id).collect();
        for id in ids {
            self.cancel(id, now);
        }
    }

    /// Begins the next step of a request, or ends it.
    pub(super) fn advance(&mut self, id: RequestId, now: MonoTime) {
        let Some(index) = self.ops.iter().position(|op| op.id == id) else { return };
        let Some(step) = self.ops[index].steps.pop_front() else {
            let op = &self.ops[index];
            let reply = match op.acknowledged {
                Some(result_param2) if op.wants_acknowledgement => Reply::Acknowledged { result_param2 },
                _ => Reply::Done,
            };
            self.finish(index, Ok(reply));
            return;
        };
        match step {
            Step::Command { message, unanswered, when_busy, effect, fallback } => {
                let command = Commanding {
                    message,
                    effect,
                    fallback,
                    first_sent: now,
                    last_sent: now,
                    mode_before: self.telemetry.mode(),
                };
                self.send_command(index, command, unanswered, when_busy, now);
            }
            Step::Tell { command, message, effect } => {
                let command = Commanding {
                    message: command,
                    effect,
                    fallback: None,
                    first_sent: now,
                    last_sent: now,
                    mode_before: self.telemetry.mode(),
                };
                self.tell(index, command, message, now);
            }
            Step::Send(message) => {
                self.outputs.push_back(Output::Send(message));
                self.advance(id, now);
            }
            Step::GoOnFrom(seq) => {
                if self.telemetry.mission.is_some_and(|mission| self.has_begun_anew(mission.value.seq, seq)) {
                    let again = self.context(now).set_current(seq).proved_by(Effect::NotBefore(seq));
                    self.ops[index].steps.push_front(again);
                }
                self.advance(id, now);
            }
            Step::Note(severity, text) => {
                self.note(severity, text, now);
                self.advance(id, now);
            }
            Step::ParamRead(_) | Step::ParamSet(..) if self.param_lane_is_busy() => {
                self.ops[index].state = State::WaitingForLane(step);
            }
            step => self.start_transfer(index, step, now),
        }
    }

    /// Whether a mission that shows this item has begun anew instead of going on from item `seq`. After an interruption,
    /// one with DO_SET_RESUME_REPEAT_DIST repeats a part of its way: it has begun anew only at its first item.
    fn has_begun_anew(&self, shown: u16, seq: u16) -> bool {
        let is_repeat = |item: &MissionItem| item.command == Command::DO_SET_RESUME_REPEAT_DIST;
        let repeats = self.mission().is_some_and(|mission| mission.items.iter().any(is_repeat));
        shown < seq && (!repeats || shown <= self.first_nav())
    }

    pub(super) fn send_command(
        &mut self,
        index: usize,
        command: Commanding,
        unanswered: Unanswered,
        when_busy: WhenBusy,
        now: MonoTime,
    ) {
        match self.commands.submit(command.message, unanswered, when_busy, now) {
            Ok(id) => self.ops[index].state = State::Commanding { command, id, asked: false },
            Err(_) => self.finish(index, Err(VehicleError::CommandBusy { command: command.name() })),
        }
    }

    pub(super) fn finish(&mut self, index: usize, result: Result<Reply, VehicleError>) {
        let op = self.ops.remove(index);
        if !self.on_board.is_own(op.id) {
            self.on_board.is_stirred = true;
            self.outputs.push_back(Output::Finished { id: op.id, result });
        }
    }

    pub(super) fn on_command_output(&mut self, output: CommandOutput, now: MonoTime) {
        match output {
            CommandOutput::Send(message) => {
                self.reach.on_question(now);
                self.outputs.push_back(Output::Send(message));
            }
            CommandOutput::Progress { id, percent } => {
                if let Some(op) = self.op_commanding(id) {
                    let id = self.ops[op].id;
                    let done = u32::from(percent.unwrap_or(0));
                    self.outputs.push_back(Output::Progress {
                        id,
                        done,
                        total: if percent.is_some() { 100 } else { 0 },
                    });
                }
            }
            CommandOutput::Unanswered { id } => {
                if let Some(index) = self.op_commanding(id) {
                    if let State::Commanding { asked, .. } = &mut self.ops[index].state {
                        *asked = true;
                    }
                    self.check_effect(index, now);
                }
            }
            CommandOutput::Finished { id, outcome } => match self.op_commanding(id) {
                Some(index) => self.on_command_finished(index, outcome, now),
                None => {
                    self.streams.on_finished(id, outcome, &mut self.commands, now);
                }
            },
        }
    }

    pub(super) fn op_commanding(&self, command: CommandId) -> Option<usize> {
        self.ops.iter().position(|op| matches!(op.state, State::Commanding { id, .. } if id == command))
    }

    /// Extends the wait for an effect about which the vehicle has reported nothing yet: that does not show that it is
    /// missing.
    fn wait_for_a_word(&mut self, index: usize, now: MonoTime) {
        let (command, until) = match &self.ops[index].state {
            State::Awaiting { command, until, is_overdue: false } => (command, *until),
            State::Telling(telling) if !telling.is_overdue && !telling.waits_for_ack() => {
                (&telling.command, telling.until)
            }
            _ => return,
        };
        if now < until
            || matches!(command.effect, Effect::Received(_) | Effect::Unobjected)
            || self.seen(command) != Seen::NotYet
        {
            return;
        }
        let (until, is_overdue) = match &mut self.ops[index].state {
            State::Awaiting { until, is_overdue, .. } => (until, is_overdue),
            State::Telling(telling) => (&mut telling.until, &mut telling.is_overdue),
            _ => return,
        };
        (*until, *is_overdue) = (*until + (WORD_WITHIN - EFFECT_WITHIN), true);
    }

    pub(super) fn on_command_finished(&mut self, index: usize, outcome: CommandOutcome, now: MonoTime) {
        let State::Commanding { command, .. } = std::mem::replace(&mut self.ops[index].state, State::Ready) else {
            return;
        };
        match outcome {
            CommandOutcome::TimedOut { attempts } => {
                let error = VehicleError::CommandTimeout {
                    target: command.message.target().into(),
                    command: command.name(),
                    attempts,
                    reasons: Vec::new(),
                };
                self.finish(index, Err(error));
            }
            CommandOutcome::Answered { result: CommandResult::ACCEPTED, result_param2 } => {
                self.ops[index].acknowledged = Some(result_param2);
                let within = match command.effect {
                    Effect::Acknowledged
                    | Effect::Airborne
                    | Effect::JumpedFrom(_)
                    | Effect::JumpedTo { .. }
                    | Effect::Restarted => None,
                    Effect::Unobjected => Some(OBJECTED_WITHIN),
                    Effect::Received(_) => Some(MESSAGE_WITHIN.max(self.round_trip().unwrap_or_default() * 2)),
                    Effect::Armed(_)
                    | Effect::Mode(_)
                    | Effect::MissionMode { .. }
                    | Effect::Current(_)
                    | Effect::NotBefore(_)
                    | Effect::AtBeginning(_) => Some(EFFECT_WITHIN),
                };
                match within {
                    Some(within) => {
                        self.ops[index].state = State::Awaiting { command, until: now + within, is_overdue: false };
                        self.check_effect(index, now);
                    }
                    None => {
                        let id = self.ops[index].id;
                        self.advance(id, now);
                    }
                }
            }
            CommandOutcome::Answered { result: CommandResult::UNSUPPORTED, .. } if command.fallback.is_some() => {
                self.fall_back(index, command, now);
            }
            CommandOutcome::Answered { result, .. } => {
                let wait = if matches!(command.effect, Effect::Armed(_)) { ARM_REASONS_AFTER } else { REASONS_AFTER };
                self.ops[index].state = State::Refused { command, result, until: now + wait };
            }
        }
    }

    pub(super) fn fall_back(&mut self, index: usize, mut command: Commanding, now: MonoTime) {
        command.last_sent = now;
        match command.fallback.take() {
            Some(Fallback::Command(message)) => {
                command.message = message;
                let unanswered = Unanswered::for_command(message.command());
                self.send_command(index, command, unanswered, WhenBusy::Refuse, now);
            }
            Some(Fallback::Message(message, effect)) => {
                command.effect = effect;
                self.tell(index, command, message, now);
            }
            None => {}
        }
    }

    /// Checks whether awaited effects are shown.
    pub(super) fn check_effects(&mut self, now: MonoTime) {
        let mut index = 0;
        while index < self.ops.len() {
            let id = self.ops[index].id;
            self.check_effect(index, now);
            if self.ops.get(index).is_some_and(|op| op.id == id) {
                index += 1;
            }
        }
    }

    pub(super) fn check_effect(&mut self, index: usize, now: MonoTime) {
        let (command, under_way) = match &self.ops[index].state {
            State::Commanding { command, id, asked } => (command, Some((*id, *asked))),
            State::Awaiting { command, .. } => (command, None),
            State::Telling(_) => return self.check_telling(index, now),
            _ => return,
        };
        let seen = self.seen(command);
        let op = self.ops[index].id;
        match (seen, under_way) {
            (Seen::Shown, Some((id, asked))) => {
                // Without an answer only an explicit report counts, or one after the answer was overdue.
                let is_reported = matches!(command.effect, Effect::Armed(_)) || command.effect.mode().is_some();
                let is_proof = is_reported || asked;
                if is_proof {
                    self.commands.forget(id, now);
                    self.ops[index].state = State::Ready;
                    self.advance(op, now);
                }
            }
            (Seen::Shown, None) => {
                self.ops[index].state = State::Ready;
                self.advance(op, now);
            }
            (Seen::NotShown | Seen::Overtaken(_), None) => {
                if matches!(self.ops[index].state, State::Awaiting { is_overdue: true, .. }) {
                    let error = self.not_confirmed(command, now);
                    self.finish(index, Err(error));
                }
            }
            (Seen::NotShown, Some((id, true))) => {
                self.commands.repeat(id, now);
                if let State::Commanding { command, asked, .. } = &mut self.ops[index].state {
                    command.last_sent = now;
                    *asked = false;
                }
            }
            (Seen::Overtaken(observed), Some((id, true))) => {
                let error = VehicleError::NotConfirmed {
                    command: command.name(),
                    wanted: command
                        .effect
                        .mode()
                        .map_or_else(|| "its effect".to_owned(), |mode| format!("mode {mode}")),
                    observed,
                    within: now.since(command.last_sent),
                    reasons: self.reasons(command, now),
                };
                self.commands.forget(id, now);
                self.finish(index, Err(error));
            }
            _ => {}
        }
    }

    /// From when reports count against a command: those on their way when it was sent prove nothing.
    fn telling_from(&self, command: &Commanding) -> MonoTime {
        command.last_sent + self.config.commands.timeout / 2
    }

    /// The state of a command's effect by the vehicle's reports since it was sent.
    pub(super) fn seen(&self, command: &Commanding) -> Seen {
        let fresh = self.telling_from(command);
        let by_heartbeat = |is_shown: bool, at: MonoTime| {
            if is_shown && at >= command.first_sent {
                Seen::Shown
            } else if !is_shown && at >= fresh {
                Seen::NotShown
            } else {
                Seen::NotYet
            }
        };
        match command.effect {
            Effect::Armed(is_armed) => self
                .telemetry
                .heartbeat
                .map_or(Seen::NotYet, |heartbeat| by_heartbeat(heartbeat.value.is_armed == is_armed, heartbeat.at)),
            Effect::Mode(mode) | Effect::MissionMode { mode, .. } => {
                self.telemetry.heartbeat.map_or(Seen::NotYet, |heartbeat| {
                    let shown = heartbeat.value.mode;
                    match by_heartbeat(shown == mode, heartbeat.at) {
                        Seen::Shown if !self.shows_mission(command.effect, heartbeat.at) => Seen::NotYet,
                        Seen::NotShown if command.mode_before.is_some_and(|before| before != shown) => {
                            Seen::Overtaken(format!("mode {shown}"))
                        }
                        seen => seen,
                    }
                })
            }
            Effect::Airborne => self.telemetry.extended.map_or(Seen::NotYet, |extended| match extended.value.landed {
                LandedState::InAir | LandedState::TakingOff => by_heartbeat(true, extended.at),
                LandedState::OnGround => by_heartbeat(false, extended.at),
                LandedState::Undefined | LandedState::Landing => Seen::NotYet,
            }),
            Effect::JumpedFrom(before) => self.telemetry.mission.map_or(Seen::NotYet, |mission| {
                by_heartbeat(before.is_some_and(|before| before != mission.value.seq), mission.at)
            }),
            Effect::JumpedTo { from, to } => self
                .telemetry
                .mission
                .filter(|mission| [from, to].contains(&mission.value.seq))
                .map_or(Seen::NotYet, |mission| by_heartbeat(mission.value.seq == to, mission.at)),
            Effect::Current(seq) => self
                .telemetry
                .mission
                .map_or(Seen::NotYet, |mission| by_heartbeat(mission.value.seq == seq, mission.at)),
            Effect::NotBefore(seq) => self
                .telemetry
                .mission
                .map_or(Seen::NotYet, |mission| by_heartbeat(mission.value.seq >= seq, mission.at)),
            Effect::AtBeginning(last) => self
                .telemetry
                .mission
                .map_or(Seen::NotYet, |mission| by_heartbeat(mission.value.seq <= last, mission.at)),
            Effect::Unobjected => self.telemetry.heartbeat.map_or(Seen::NotYet, |heartbeat| {
                let shown = heartbeat.value.mode;
                let is_its = Action::Loiter.mode(shown.family) == Some(shown) || command.mode_before == Some(shown);
                match by_heartbeat(false, heartbeat.at) {
                    Seen::NotShown if !is_its => Seen::Overtaken(format!("mode {shown}")),
                    seen => seen,
                }
            }),
            Effect::Acknowledged | Effect::Received(_) | Effect::Restarted => Seen::NotYet,
        }
    }

    /// Whether MISSION_CURRENT has shown since then what a change to a mission's mode brings about. A vehicle that does
    /// not send it, or without a state, is believed.
    fn shows_mission(&self, effect: Effect, since: MonoTime) -> bool {
        let Effect::MissionMode { has_begun, .. } = effect else { return true };
        let Some(mission) = self.telemetry.mission.filter(|mission| since.since(mission.at) <= LOST_AFTER) else {
            return true;
        };
        let is_shown = match mission.value.state {
            None | Some(MissionState::Active) => true,
            Some(MissionState::NotStarted) => !has_begun && mission.value.in_mission_mode == Some(true),
            _ => false,
        };
        is_shown && mission.at >= since
    }

    /// Passes a message to the request that awaits it.
    pub(super) fn on_awaited(&mut self, message: &Message, now: MonoTime) {
        let wants = |command: &Commanding| command.effect == Effect::Received(message.id());
        let mut index = 0;
        while index < self.ops.len() {
            match &self.ops[index].state {
                State::Commanding { command, id, .. } if wants(command) => {
                    // The message may overtake the acknowledgement.
                    self.commands.forget(*id, now);
                }
                State::Awaiting { command, .. } if wants(command) => {}
                _ => {
                    index += 1;
                    continue;
                }
            }
            self.finish(index, Ok(Reply::Message(Box::new(message.clone()))));
        }
    }
}
