//! Requests that move plans and parameters: which transfer runs, and the state after it ends.

use std::sync::Arc;

use vencejo_flight::plan::PlanKind;
use vencejo_flight::radius::own_radius_m;
use vencejo_proto::dialect::PARAM_VALUE_DATA;
use vencejo_proto::param::{ParamEncoding, ParamName, ParamType, ParamValue};
use vencejo_proto::{Message, MissionItemInt, MonoTime, SystemId};

use super::Vehicle;
use super::lane::{Lane, Machine, PlanBefore, Written, Yield};
use super::onboard::STATION_PARAMETERS;
use super::operation::{Op, State};
use super::steps::Step;
use crate::error::VehicleError;
use crate::modes::ModeFamily;
use crate::plan_state::{PlanState, Unknown, read_plan};
use crate::request::{Output, Reply, VehicleEvent};
use crate::transfer::{
    NO_INDEX, Others, Param, ParamList, ParamRead, ParamSet, PlanClear, PlanDownload, PlanUpload, TransferConfig,
    TransferError, TransferOutput,
};

/// Capability bits: how integers are put into PARAM_VALUE (`MAV_PROTOCOL_CAPABILITY_PARAM_ENCODE_BYTEWISE`, `_C_CAST`).
const PARAM_BYTEWISE: u64 = 16;
const PARAM_C_CAST: u64 = 1 << 17;

#[derive(Clone, Copy)]
enum LaneName {
    Transfer,
    Param,
}

impl Vehicle {
    pub(super) fn param_lane_is_busy(&self) -> bool {
        // A parameter of a running list would be taken for the answer to a single read.
        let is_listing = self.transfer.as_ref().is_some_and(|lane| matches!(lane.machine, Machine::List(_)));
        self.param.is_some() || is_listing
    }

    /// Whether we are writing this plan, or about to.
    pub(super) fn writes(&self, kind: PlanKind) -> bool {
        let is_recording = |op: &Op| matches!(&op.state, State::Recording { before, .. } if before.kind == kind);
        self.transfer.as_ref().is_some_and(|lane| lane.is_about(kind) && lane.machine.writes_plan())
            || self.ops.iter().any(is_recording)
    }

    pub(super) fn transfer_config(&self) -> TransferConfig {
        let is_ardupilot = self.is_ardupilot();
        TransferConfig {
            vehicle: self.address,
            station: self.our,
            is_ardupilot,
            has_ftp: self.may_have_ftp(),
            item_form: self.item_form(),
            no_plan_kinds: self.no_plan_kinds(),
            param_encoding: self.param_encoding(),
            round_trip: self.timesync.round_trip(),
            item_window: self.config.item_window,
            ftp_sessions: self.ftp_sessions.clone(),
        }
    }

    /// How it puts integers into PARAM_VALUE: as its capabilities say; those of a PX4 byte by byte and those of an
    /// ArduPilot as numbers, told or not; else as its values have shown.
    fn param_encoding(&self) -> Option<ParamEncoding> {
        let capabilities = self.telemetry.version.map_or(0, |version| version.value.capabilities);
        let is_px4 = self.family() == Some(ModeFamily::Px4);
        if is_px4 || capabilities & PARAM_BYTEWISE != 0 {
            Some(ParamEncoding::Bytewise)
        } else if self.is_ardupilot() || capabilities & PARAM_C_CAST != 0 {
            Some(ParamEncoding::CCast)
        } else {
            self.shown_encodings.only()
        }
    }

    pub(super) fn start_transfer(&mut self, index: usize, step: Step, now: MonoTime) {
        let (kind, sent) = match &step {
            Step::Upload(kind, items) => (*kind, Some(items.clone())),
            Step::Clear(kind) => (*kind, Some(Vec::new())),
            _ => return self.run_transfer(index, step, None, now),
        };
        let doubt = self.on_board.doubt.clone();
        let before = PlanBefore { kind, state: self.plans.get(kind), doubt };
        let wait = match (kind, sent) {
            (PlanKind::Mission, Some(sent)) => self.doubt_before_sending(sent, now),
            _ => None,
        };
        self.set_plan(kind, PlanState::Unknown(Unknown::Transferring));
        match wait {
            Some((ticket, until)) => self.ops[index].state = State::Recording { step, before, ticket, until },
            None => self.run_transfer(index, step, Some(before), now),
        }
    }

    /// Nothing of an upload was sent: restores the state before.
    pub(super) fn take_back(&mut self, before: PlanBefore) {
        if before.kind == PlanKind::Mission {
            self.on_board.doubt = before.doubt;
        }
        // A list that was known has been let go of, and is read again.
        let was_there = before.state.count().is_some_and(|count| count > 0);
        let is_gone = was_there && self.plan_on_board(before.kind).is_none();
        let again = PlanState::Unknown(Unknown::ChangedElsewhere);
        self.set_plan(before.kind, if is_gone { again } else { before.state });
        self.remember();
    }

    /// Sets a transfer going; of one that writes a plan `before` is what was known of that.
    pub(super) fn run_transfer(&mut self, index: usize, step: Step, before: Option<PlanBefore>, now: MonoTime) {
        let config = self.transfer_config();
        let id = self.ops[index].id;
        self.ops[index].state = State::Transferring;
        let read = |kind: PlanKind| Some(PlanBefore { kind, state: self.plans.get(kind), doubt: None });
        let (plan_before, machine) = match step {
            Step::Upload(kind, items) => {
                (before, Machine::Upload(Box::new(PlanUpload::new(&config, kind, items, now))))
            }
            Step::Download(kind) => (read(kind), Machine::Download(Box::new(PlanDownload::new(&config, kind, now)))),
            Step::Clear(kind) => (before, Machine::Clear(Box::new(PlanClear::new(&config, kind, now)), kind)),
            Step::ParamList => (None, Machine::List(Box::new(ParamList::new(&config, now)))),
            Step::ParamRead(name) => (None, Machine::Read(Box::new(ParamRead::new(&config, name, now)))),
            Step::ParamSet(name, value) => (None, Machine::Set(Box::new(ParamSet::new(&config, name, value, now)))),
            Step::Command { .. } | Step::Tell { .. } | Step::Send(_) | Step::GoOnFrom(_) | Step::Note(..) => {
                unreachable!("invariant: commands do not go by a lane")
            }
        };
        let is_single = matches!(machine, Machine::Read(_) | Machine::Set(_));
        let writes_mission = machine.writes_plan() && plan_before.as_ref().is_some_and(|b| b.kind == PlanKind::Mission);
        let mut lane = Lane {
            id,
            machine,
            plan_before,
            is_disturbed: false,
            is_followed: false,
            theirs: None,
            ended: None,
            began: now,
            is_answered: false,
        };
        if let Some(incoming) = self.on_board.incoming.as_mut().filter(|_| writes_mission) {
            incoming.before = None;
            lane.machine.on_others(Others::Write, incoming.heard_at);
        }
        if is_single { self.param = Some(lane) } else { self.transfer = Some(lane) }
    }

    pub(super) fn drain_lanes(&mut self, now: MonoTime) {
        for slot in [LaneName::Transfer, LaneName::Param] {
            let is_held = self.holds_verdict();
            let lane = match slot {
                LaneName::Transfer => &mut self.transfer,
                LaneName::Param => &mut self.param,
            };
            let Some(running) = lane else { continue };
            while let Some(output) = running.machine.poll_output() {
                self.outputs.push_back(match output {
                    TransferOutput::Send(message) => {
                        // MISSION_ACK is itself an answer.
                        if !matches!(message, Message::MissionAck(_)) {
                            self.reach.on_question(now);
                        }
                        Output::Send(message)
                    }
                    TransferOutput::Progress { done, total } => Output::Progress { id: running.id, done, total },
                });
            }
            if let Some(result) = running.end(is_held)
                && let Some(ended) = lane.take()
            {
                self.on_transfer_ended(ended, result, now);
            }
        }
    }

    pub(super) fn on_transfer_ended(&mut self, lane: Lane, result: Result<Yield, TransferError>, now: MonoTime) {
        let (writes, plan_id) = (lane.machine.writes_plan(), lane.machine.plan_id());
        let written = lane.plan_before.filter(|_| writes);
        if let Some(before) = &written {
            let is_unfinished = result.is_err() && !matches!(result, Err(TransferError::OnlyMission { .. }));
            self.written[before.kind as usize] = Some(Written { at: now, plan_id, is_unfinished });
        }
        let own = self.on_board_own(lane.id).map(|what| (what, result.as_ref().err().cloned()));
        let result = match result {
            Ok(Yield::Plan { kind, wire, position_error_m }) => {
                let reply = self.on_plan(kind, &wire, position_error_m, lane.is_disturbed, writes, now);
                if reply.is_err() && writes {
                    self.set_plan(kind, PlanState::Unknown(Unknown::TransferFailed));
                }
                reply
            }
            Ok(Yield::Parameters(params)) => {
                params.iter().for_each(|param| self.learn(param));
                Ok(Reply::Parameters(params))
            }
            Ok(Yield::Parameter(param)) => {
                self.learn_one(&param);
                Ok(Reply::Parameter(param))
            }
            Err(error) => {
                match written {
                    Some(before) if matches!(error, TransferError::OnlyMission { .. }) => self.take_back(before),
                    Some(before) => {
                        if let Some(theirs) = lane.theirs {
                            self.keep_heard(theirs);
                        }
                        self.set_plan(before.kind, PlanState::Unknown(Unknown::TransferFailed));
                    }
                    None => {}
                }
                Err(match error {
                    TransferError::Cancelled => VehicleError::Cancelled,
                    // Of one that has been silent for half of that time nothing is known.
                    TransferError::UnknownParam { told: false, .. }
                        if 2 * now.since(self.heard_at) >= now.since(lane.began) =>
                    {
                        let waited = now.since(lane.began);
                        VehicleError::Transfer(TransferError::Timeout { step: "PARAM_REQUEST_READ", waited })
                    }
                    error => VehicleError::Transfer(error),
                })
            }
        };
        self.remember();
        if let Some(index) = self.ops.iter().position(|op| op.id == lane.id) {
            if result.is_ok() && !self.ops[index].steps.is_empty() {
                self.ops[index].state = State::Ready;
                self.advance(lane.id, now);
            } else {
                match result {
                    Ok(reply) if writes => self.finish_upload(index, reply, lane.began, now),
                    result => self.finish(index, result),
                }
            }
        }
        if let Some((what, error)) = own {
            self.on_own_read(what, error.as_ref(), now);
        }
    }

    /// A parameter's value: an ArduPilot sends each that is set, by whomever, to all (`GCS::send_parameter_value`). One
    /// that is known is updated.
    pub(super) fn on_param_told(&mut self, told: &PARAM_VALUE_DATA, now: MonoTime) {
        let Some(name) = ParamName::from_field(&told.param_id) else { return };
        if told.param_index == NO_INDEX {
            self.on_list_total(name.as_str(), now);
        }
        let read = ParamType::from_mav(told.param_type).zip(self.param_encoding());
        let Some((param_type, encoding)) = read.filter(|_| self.parameters.contains_key(&name)) else { return };
        if let Some(value) = ParamValue::from_wire(told.param_value, param_type, encoding) {
            self.learn_one(&Param::new(name, value));
        }
    }

    /// Takes over a parameter, and reports it when it was known with another value.
    pub(super) fn learn_one(&mut self, param: &Param) {
        let is_changed = self.parameters.get(&param.name).is_some_and(|before| *before != param.value.as_f64());
        self.learn(param);
        if is_changed {
            self.event(VehicleEvent::ParamChanged(*param));
        }
    }

    /// Takes over parameters that our own calculations need.
    pub(super) fn learn(&mut self, param: &Param) {
        let (name, value) = (param.name.as_str(), param.value.as_f64());
        Arc::make_mut(&mut self.parameters).insert(param.name, value);
        self.limits.learn(name, value);
        match name {
            "WP_LOITER_RAD" => self.flight_parameters.loiter_radius_m = Some(own_radius_m(value)),
            "AIRSPEED_CRUISE" if value.abs() >= 1.0 => self.flight_parameters.airspeed_m_s = Some(value.abs()),
            "TRIM_ARSPD_CM" if value.abs() >= 100.0 => self.flight_parameters.airspeed_m_s = Some(value.abs() / 100.0),
            "RTL_AUTOLAND" => self.flight_parameters.finds_landing = self.limits.finds_landing,
            _ => {}
        }
    }

    /// System id of the ground stations whose heartbeats its failsafe counts (`MAV_GCS_SYSID`, before ArduPilot 4.7
    /// `SYSID_MYGCS`). `None`: not read.
    pub fn counted_station(&self) -> Option<SystemId> {
        let read = |name| self.parameters.get(&ParamName::new(name).ok()?).map(|value| *value as u8);
        STATION_PARAMETERS.into_iter().find_map(read).filter(|number| *number > 0).map(SystemId)
    }

    /// A plan was read from the vehicle: now it is known, unless it was `changed` meanwhile. `is_ours` is one that we
    /// have just sent.
    ///
    /// # Errors
    /// [`VehicleError::NotHeard`] for a mission while it is not known whether it begins with home.
    pub(super) fn on_plan(
        &mut self,
        kind: PlanKind,
        wire: &[MissionItemInt],
        position_error_m: Option<f64>,
        changed: bool,
        is_ours: bool,
        now: MonoTime,
    ) -> Result<Reply, VehicleError> {
        let is_ardupilot = self.context(now).is_ardupilot();
        let has_home = kind == PlanKind::Mission && is_ardupilot?;
        let (list, read) = read_plan(kind, wire, has_home)?;
        let state = match kind {
            // An upload that goes on says so in the plan's state.
            _ if changed && self.plans.get(kind).may_be_mixed() => self.plans.get(kind),
            _ if changed => PlanState::Unknown(self.why_changed(kind, now)),
            PlanKind::Mission if is_ours => {
                self.on_board.end_doubt();
                read
            }
            PlanKind::Mission => self.judge(wire, read),
            PlanKind::Fence | PlanKind::Rally => read,
        };
        if kind == PlanKind::Mission {
            // A message with the number of items before may have been the last one.
            self.on_board.total = state.count().or(self.on_board.total);
            match state {
                PlanState::Verified { hash, .. } | PlanState::Differs { hash, .. } => {
                    self.tracker.on_mission(hash, is_ours);
                }
                PlanState::Empty => self.tracker.reset(),
                PlanState::Unknown(_) => {}
            }
        }
        self.copies[kind as usize] = (!list.items.is_empty()).then(|| Arc::new(list.clone()));
        self.set_plan(kind, state);
        if self.is_starting() {
            self.doubt_copy(kind, now);
        }
        Ok(Reply::Plan { kind, items: list.items, home: list.home, state, position_error_m })
    }
}
