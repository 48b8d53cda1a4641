//! What a station on board keeps for ground stations: lists received and offered, the state of the plans, and the
//! parameters as they were read.

use std::sync::Arc;
use std::time::Duration;

use vencejo_flight::plan::PlanKind;
use vencejo_proto::dialect::MavMessage;
use vencejo_proto::param::{Param, ParamEncoding, ParamName};
use vencejo_proto::{Frame, Message, MonoTime};
use vencejo_station::{DropOldest, Observed, Station, Taken, VehicleHandle};
use vencejo_vehicle::{Reply, VehicleEvent};
use zenoh::query::Query;

use crate::budget::Pacer;
use crate::content::{Content, Digest, Part, Shelf, Tray, pack_items};
use crate::deed::{Act, Deed};
use crate::outcome::Outcome;
use crate::payload::{Answer, BadPayload, State};
use crate::plans::Plans;
use crate::pull::PIECE_BYTES;
use crate::signature::PublicKey;

/// `PARAM_VALUE`: a parameter was changed or requested.
pub(super) const PARAM_VALUE: u32 = 22;
/// Parameters read longer ago than this are read again: an autopilot does not report all changes.
const READ_AGAIN: Duration = Duration::from_secs(600);
/// Most events of the vehicle that wait for a tick.
const WAITING: usize = 64;

pub(super) struct Holdings {
    shelf: Shelf,
    tray: Tray,
    plans: Plans,
    /// The plan states published last.
    told_version: u32,
    pacer: Pacer,
    params: Option<(Vec<Param>, MonoTime)>,
    events: Arc<DropOldest<Observed>>,
}

impl Holdings {
    pub(super) fn new(vehicle: &VehicleHandle, uplink_bit_s: Option<f64>) -> Self {
        Self {
            shelf: Shelf::default(),
            tray: Tray::default(),
            plans: Plans::default(),
            told_version: 0,
            pacer: Pacer::new(uplink_bit_s),
            params: None,
            events: vehicle.subscribe_events(WAITING),
        }
    }

    /// Updates it from the station.
    pub(super) fn look(&mut self, vehicle: &VehicleHandle) {
        while let Taken::Item(observed) = self.events.take_ready() {
            if observed.event == VehicleEvent::Rebooted {
                self.params = None;
            }
        }
        for kind in PlanKind::ALL {
            let Some((state, list)) = vehicle.plan_on_board(kind) else { continue };
            let shelf = &mut self.shelf;
            self.plans.on_state(kind, state, || {
                let packed = pack_items(list.as_deref()?);
                shelf.put(&packed);
                Some(Content::of(packed)).filter(|list| list.name().is_ok())
            });
        }
        self.keep_told();
    }

    /// Keeps every list available whose name is published, however many lists have come since.
    fn keep_told(&mut self) {
        let lists = self.plans.told().iter().filter_map(|told| told.list.as_ref()?.name().ok());
        for (name, _) in lists {
            self.shelf.get(&name);
        }
    }

    /// A parameter of the autopilot: when it differs from what was read, the read list is discarded.
    pub(super) fn on_param(&mut self, frame: &Frame) {
        let Ok(Message::Dialect(MavMessage::PARAM_VALUE(told))) = frame.decode() else { return };
        let Some(name) = ParamName::from_field(&told.param_id) else { return };
        let is_same = |param: &Param| {
            param.name == name
                && [ParamEncoding::CCast, ParamEncoding::Bytewise]
                    .into_iter()
                    .any(|encoding| param.value.to_wire(encoding).to_bits() == told.param_value.to_bits())
        };
        self.params.take_if(|(params, _)| !params.iter().any(is_same));
    }

    /// An order read a parameter, or set it and read it back.
    pub(super) fn on_param_read(&mut self, param: &Param) {
        let is_same = |listed: &Param| (listed.name, listed.value) == (param.name, param.value);
        self.params.take_if(|(params, _)| !params.iter().any(is_same));
    }

    pub(super) fn on_params_read(&mut self, params: &[Param], now: MonoTime) {
        self.params = Some((params.to_vec(), now));
    }

    /// The parameters as they were read, if still valid.
    pub(super) fn known_params(&self, now: MonoTime) -> Option<Reply> {
        let (params, at) = self.params.as_ref()?;
        (now.since(*at) < READ_AGAIN).then(|| Reply::Parameters(params.clone()))
    }

    /// Adds changed plans to a sample, and all plans to a complete state.
    pub(super) fn dress(&mut self, mut state: State, is_sample: bool) -> State {
        state.plans_version = self.plans.version();
        if !is_sample || self.told_version != self.plans.version() {
            state.plans = self.plans.told().to_vec();
        }
        if is_sample {
            self.told_version = self.plans.version();
        }
        state
    }

    pub(super) fn on_part(&mut self, of: PublicKey, part: &Part) -> Result<(), BadPayload> {
        if let Some(packed) = self.tray.on_part(of, part)? {
            self.shelf.put(&packed);
        }
        Ok(())
    }

    /// Fills the list into an order that has it by name only; whether it is there.
    pub(super) fn fill(&mut self, act: &mut Act) -> bool {
        let Some(Deed::PlanPut(put)) = &mut act.deed else { return true };
        let Some(list) = put.list.as_mut().filter(|list| list.here.is_empty()) else { return true };
        let Some(packed) = list.name().ok().and_then(|(name, _)| self.shelf.get(&name)) else { return false };
        list.here = packed.to_vec();
        true
    }

    /// Whether the plan that an order is to replace or remove is the one that its sender has seen.
    pub(super) fn admit(&self, act: &Act) -> Result<(), String> {
        let (kind, revision) = match &act.deed {
            Some(Deed::PlanPut(put)) => (put.kind, put.revision),
            Some(Deed::PlanClear(clear)) => (clear.kind, clear.revision),
            _ => return Ok(()),
        };
        let kind = crate::plans::kind_of(kind).map_err(|error| error.to_string())?;
        self.plans.admit(kind, revision)
    }

    /// Moves a long list of an answer to the shelf.
    pub(super) fn complete(&mut self, mut answer: Answer, kind: Option<PlanKind>) -> Answer {
        if let Some(content) = answer.outcome.as_mut().and_then(Outcome::content) {
            self.shelf.put(&content.here);
        }
        if let (Some(Outcome::Plan(plan)), Some(kind)) = (&mut answer.outcome, kind) {
            plan.told = Some(self.plans.told()[kind as usize].clone());
        }
        answer.outcome = answer.outcome.map(Outcome::short);
        answer
    }

    /// Replies to a query for a piece of a list when the uplink has room; with nothing for an unknown list.
    pub(super) fn on_asked(&mut self, query: Query, key: String, station: &Station) {
        let parameters = query.parameters();
        let name = parameters.get("list").and_then(Digest::from_text);
        let from = parameters.get("from").and_then(|from| from.parse::<usize>().ok()).unwrap_or(0);
        let packed = name.and_then(|name| self.shelf.get(&name));
        let piece = packed.and_then(|packed| {
            let end = packed.len().min(from.checked_add(PIECE_BYTES)?);
            packed.get(from..end).map(<[u8]>::to_vec)
        });
        let piece = piece.unwrap_or_default();
        let wait = self.pacer.wait(piece.len(), station.now());
        tokio::spawn(async move {
            tokio::time::sleep(wait).await;
            if let Err(error) = query.reply(key.clone(), piece).await {
                // The ground station asks again.
                tracing::debug!(%error, key, "not answered");
            }
        });
    }
}

#[cfg(test)]
mod tests {
    use vencejo_flight::plan::{Mission, MissionItem};
    use vencejo_vehicle::PlanState;

    use super::super::tests::on_board;
    use super::*;

    #[tokio::test]
    async fn the_plan_on_board_is_there_to_be_asked_for_after_many_others_have_come() {
        let station = on_board().await;
        let mut holdings = Holdings::new(&station.vehicles()[0], None);
        let packed =
            |n: i32| pack_items(&Mission { home: None, items: vec![MissionItem::waypoint(1.0, f64::from(n), 100.0)] });
        let name = holdings.shelf.put(&packed(0));
        let verified = PlanState::Verified { count: 1, hash: 7 };
        holdings.plans.on_state(PlanKind::Rally, verified, || Some(Content::of(packed(0))));
        for n in 1..40 {
            holdings.shelf.put(&packed(n));
            holdings.keep_told();
        }
        assert!(holdings.shelf.get(&name).is_some());
        station.close().await;
    }
}
