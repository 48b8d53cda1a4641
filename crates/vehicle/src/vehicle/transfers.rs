//! Requests that move plans and parameters: which transfer runs, and what is known when it ends.

use std::sync::Arc;

use vencejo_flight::plan::{Mission, PlanKind, items_from_wire};
use vencejo_proto::param::ParamEncoding;
use vencejo_proto::{MissionItemInt, MonoTime};

use super::Vehicle;
use super::lane::{Lane, Machine, Yield};
use super::ops::State;
use super::steps::Step;
use crate::error::VehicleError;
use crate::plan_state::{PlanState, Unknown, hash_items};
use crate::request::{Output, Reply};
use crate::transfer::{
    Param, ParamList, ParamRead, ParamSet, PlanClear, PlanDownload, PlanUpload, TransferConfig, TransferError,
    TransferOutput,
};

/// Capability bit: integers are put into PARAM_VALUE byte by byte (`MAV_PROTOCOL_CAPABILITY_PARAM_ENCODE_BYTEWISE`).
const PARAM_BYTEWISE: u64 = 16;

#[derive(Clone, Copy)]
enum LaneName {
    Transfer,
    Param,
}

impl Vehicle {
    pub(super) fn param_lane_is_busy(&self) -> bool {
        // A list of parameters would be taken for the answer to a single one.
        let is_listing = self.transfer.as_ref().is_some_and(|lane| matches!(lane.machine, Machine::List(_)));
        self.param.is_some() || is_listing
    }

    pub(super) fn transfer_config(&self) -> TransferConfig {
        let is_ardupilot = self.is_ardupilot();
        let version = self.telemetry.version.map(|version| version.value);
        let is_bytewise = version.is_some_and(|version| version.capabilities & PARAM_BYTEWISE != 0);
        TransferConfig {
            vehicle: self.address,
            station: self.our,
            is_ardupilot,
            has_ftp: self.may_have_ftp(),
            item_form: self.item_form(),
            no_plan_kinds: self.no_plan_kinds(),
            param_encoding: if is_bytewise { ParamEncoding::Bytewise } else { ParamEncoding::CCast },
            round_trip: self.timesync.round_trip(),
            item_window: self.config.item_window,
            ftp_sessions: self.ftp_sessions.clone(),
        }
    }

    pub(super) fn start_transfer(&mut self, index: usize, step: Step, now: MonoTime) {
        let config = self.transfer_config();
        let id = self.ops[index].id;
        self.ops[index].state = State::Transferring;
        let before = |kind: PlanKind| Some((kind, self.plans.get(kind)));
        let (plan_before, machine) = match step {
            Step::Upload(kind, items) => {
                (before(kind), Machine::Upload(Box::new(PlanUpload::new(&config, kind, items, now))))
            }
            Step::Download(kind) => (before(kind), Machine::Download(Box::new(PlanDownload::new(&config, kind, now)))),
            Step::Clear(kind) => (before(kind), Machine::Clear(Box::new(PlanClear::new(&config, kind, now)), kind)),
            Step::ParamList => (None, Machine::List(Box::new(ParamList::new(&config, now)))),
            Step::ParamRead(name) => (None, Machine::Read(Box::new(ParamRead::new(&config, name, now)))),
            Step::ParamSet(name, value) => (None, Machine::Set(Box::new(ParamSet::new(&config, name, value, now)))),
            Step::Command { .. } | Step::Tell { .. } | Step::Send(_) | Step::Note(..) => {
                unreachable!("invariant: commands do not go by a lane")
            }
        };
        if let (Some((kind, _)), true) = (plan_before, machine.writes_plan()) {
            self.set_plan(kind, PlanState::Unknown(Unknown::Transferring));
        }
        let is_single = matches!(machine, Machine::Read(_) | Machine::Set(_));
        let lane = Some(Lane { id, machine, plan_before, is_disturbed: false });
        if is_single { self.param = lane } else { self.transfer = lane }
    }

    pub(super) fn drain_lanes(&mut self, now: MonoTime) {
        for slot in [LaneName::Transfer, LaneName::Param] {
            let lane = match slot {
                LaneName::Transfer => &mut self.transfer,
                LaneName::Param => &mut self.param,
            };
            let Some(running) = lane else { continue };
            while let Some(output) = running.machine.poll_output() {
                self.outputs.push_back(match output {
                    TransferOutput::Send(message) => Output::Send(message),
                    TransferOutput::Progress { done, total } => Output::Progress { id: running.id, done, total },
                });
            }
            if let Some(result) = running.machine.result()
                && let Some(ended) = lane.take()
            {
                self.on_transfer_ended(ended, result, now);
            }
        }
    }

    pub(super) fn on_transfer_ended(&mut self, lane: Lane, result: Result<Yield, TransferError>, now: MonoTime) {
        if let Some((kind, _)) = lane.plan_before
            && lane.machine.writes_plan()
        {
            self.written[kind as usize] = Some(now);
        }
        let result = match result {
            Ok(Yield::Plan { kind, wire, position_error_m }) => {
                self.on_plan(kind, &wire, position_error_m, lane.is_disturbed)
            }
            Ok(Yield::Parameters(params)) => {
                params.iter().for_each(|param| self.learn(param));
                Ok(Reply::Parameters(params))
            }
            Ok(Yield::Parameter(param)) => {
                self.learn(&param);
                Ok(Reply::Parameter(param))
            }
            Err(error) => {
                if let Some((kind, before)) = lane.plan_before
                    && lane.machine.writes_plan()
                {
                    let was_sent = !matches!(error, TransferError::OnlyMission { .. });
                    self.set_plan(kind, if was_sent { PlanState::Unknown(Unknown::TransferFailed) } else { before });
                }
                Err(match error {
                    TransferError::Cancelled => VehicleError::Cancelled,
                    error => VehicleError::Transfer(error),
                })
            }
        };
        let Some(index) = self.ops.iter().position(|op| op.id == lane.id) else { return };
        if result.is_ok() && !self.ops[index].steps.is_empty() {
            self.ops[index].state = State::Ready;
            self.advance(lane.id, now);
        } else {
            self.finish(index, result);
        }
    }

    /// Parameters that our own reckoning needs.
    pub(super) fn learn(&mut self, param: &Param) {
        let value = param.value.as_f64().abs();
        if param.name.as_str() == "WP_LOITER_RAD" && value >= 1.0 {
            self.progress_options.loiter_radius_m = value;
        }
    }

    /// A plan was read from the vehicle: now it is known, unless it was `changed` meanwhile.
    pub(super) fn on_plan(
        &mut self,
        kind: PlanKind,
        wire: &[MissionItemInt],
        position_error_m: Option<f64>,
        changed: bool,
    ) -> Result<Reply, VehicleError> {
        let has_home = kind == PlanKind::Mission && self.is_ardupilot();
        let mission = match kind {
            PlanKind::Mission => Mission::from_wire(wire, has_home)?,
            PlanKind::Fence | PlanKind::Rally => Mission { home: None, items: items_from_wire(wire, kind)? },
        };
        let items = &mission.items;
        let state = if changed {
            PlanState::Unknown(Unknown::ChangedElsewhere)
        } else if items.is_empty() {
            PlanState::Empty
        } else {
            let count = u16::try_from(items.len()).unwrap_or(u16::MAX);
            PlanState::Verified { count, hash: hash_items(&wire[usize::from(has_home)..]) }
        };
        if kind == PlanKind::Mission {
            if self.plans.get(kind) != state {
                self.tracker.reset();
            }
            self.mission = (!items.is_empty()).then(|| Arc::new(mission.clone()));
        }
        self.set_plan(kind, state);
        Ok(Reply::Plan { kind, items: mission.items, home: mission.home, state, position_error_m })
    }
}
