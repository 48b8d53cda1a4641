//! What can be asked of one vehicle of a station.

use std::collections::BTreeSet;
use std::sync::{Arc, PoisonError, Weak};
use std::time::Duration;

use vencejo_flight::checks::{CheckContext, Finding, check_plan};
use vencejo_flight::plan::{Mission, Plan, PlanKind};
use vencejo_flight::progress::Trip;
use vencejo_link::{LinkInfo, LinkStats, SendReport, SourceStats};
use vencejo_proto::{Address, Message, MissionSeq, MonoTime, SystemId};
use vencejo_vehicle::telemetry::{Telemetry, Text};
use vencejo_vehicle::{Danger, FlightParameters, FlightPreparation, MissionProgress, PlanState, Request, Vehicle};

use crate::changes::Changes;
use crate::control::{Held, Operator};
use crate::error::StationError;
use crate::pending::Pending;
use crate::queue::DropOldest;
use crate::station::{RequestResult, Shared, Station, VehicleHandle};
use crate::subscriptions::{Observed, Received};

impl VehicleHandle {
    /// Its system id.
    pub fn system(&self) -> SystemId {
        self.system
    }

    /// The station that hears it.
    pub fn station(&self) -> &Station {
        &self.station
    }

    /// A copy of everything that it said, and the moment that it was taken.
    pub fn telemetry(&self) -> (Telemetry, MonoTime) {
        self.station.shared.telemetry(self.system)
    }

    /// The newest texts that it wrote, oldest first.
    pub fn texts(&self) -> Vec<Text> {
        let texts = |vehicle: &Vehicle| vehicle.texts().iter().cloned().collect();
        self.station.shared.with_vehicle(self.system, texts).unwrap_or_default()
    }

    /// Where it stands in its mission.
    pub fn progress(&self) -> Option<MissionProgress> {
        self.station.shared.with_vehicle(self.system, |vehicle| vehicle.progress())
    }

    /// What is known of a plan on board.
    pub fn plan_state(&self, kind: PlanKind) -> Option<PlanState> {
        self.station.shared.with_vehicle(self.system, |vehicle| vehicle.plan_state(kind))
    }

    /// What is known of a plan on board, and its list where that is known and not empty. Nothing is asked of the vehicle: the
    /// station reads by itself what it does not know.
    pub fn plan_on_board(&self, kind: PlanKind) -> Option<(PlanState, Option<Arc<Mission>>)> {
        let known = |vehicle: &Vehicle| (vehicle.plan_state(kind), vehicle.plan_on_board(kind).cloned());
        self.station.shared.with_vehicle(self.system, known)
    }

    /// What is wrong or doubtful in a plan that this vehicle is to fly as it is now.
    pub fn check_plan(&self, plan: &Plan) -> Vec<Finding> {
        check_plan(plan, &self.check_context())
    }

    /// The same before a plan is sent: it may wait on board until the plane flies, so it need not begin with a take-off.
    pub fn check_upload(&self, plan: &Plan) -> Vec<Finding> {
        check_plan(plan, &CheckContext { on_ground: None, ..self.check_context() })
    }

    /// A mission as this vehicle would fly it, in calm air.
    pub fn trip(&self, mission: &Mission) -> Option<Trip> {
        self.station.shared.with_vehicle(self.system, |vehicle| vehicle.trip(mission))
    }

    fn check_context(&self) -> CheckContext {
        self.station.shared.with_vehicle(self.system, Vehicle::check_context).unwrap_or_default()
    }

    /// What its parameters say of how it flies, as far as they were read.
    pub fn flight_parameters(&self) -> FlightParameters {
        self.station.shared.with_vehicle(self.system, Vehicle::flight_parameters).unwrap_or_default()
    }

    /// What a flight needs first; see [`Request::PrepareFlight`].
    pub fn flight_preparation(&self) -> Option<FlightPreparation> {
        self.station.shared.with_vehicle(self.system, |vehicle| vehicle.flight_preparation()).flatten()
    }

    /// The same vehicle, acted on in the name of this operator.
    #[must_use]
    pub fn acting_as(&self, operator: Arc<Operator>) -> Self {
        Self { operator: Some(operator), ..self.clone() }
    }

    /// Asks it for something. The request is checked before anything is sent: an act needs control, which it takes when nobody
    /// has it; a dangerous one ends with [`StationError::NeedsConfirmation`].
    pub fn request(&self, request: Request) -> Pending<RequestResult> {
        self.request_confirmed(request, None)
    }

    /// The same, with the confirmation that the same request brought before.
    pub fn request_confirmed(&self, request: Request, confirmation: Option<&str>) -> Pending<RequestResult> {
        if request.is_act() {
            let danger = |telemetry: &Telemetry, now| Danger::of_request(&request, telemetry, now);
            if let Err(error) = self.admit(danger, || format!("{request:?}"), confirmation) {
                return Pending::ended(Err(error));
            }
        }
        self.station.shared.request(self.system, request)
    }

    /// The same, for a program that confirms by naming what is dangerous: done when that is what it is.
    pub fn request_naming(&self, request: Request, named: Danger) -> Pending<RequestResult> {
        let pending = self.request(request.clone());
        match pending.end() {
            Some(Err(StationError::NeedsConfirmation { challenge })) if challenge.danger == named => {
                self.request_confirmed(request, Some(&challenge.id))
            }
            _ => pending,
        }
    }

    /// The same for [`Self::send`].
    ///
    /// # Errors
    /// As there.
    pub fn send_naming(
        &self,
        message: &Message,
        despite_mixed_plan: bool,
        named: Danger,
    ) -> Result<SendReport, StationError> {
        match self.send(message, despite_mixed_plan, None) {
            Err(StationError::NeedsConfirmation { challenge }) if challenge.danger == named => {
                self.send(message, despite_mixed_plan, Some(&challenge.id))
            }
            other => other,
        }
    }

    /// Sends any message, as it is. There is no answer and no check of its values; it is an act like any other. What arms a vehicle,
    /// has it follow its mission or jump in it is held back while that may be a mixture of two, unless it is
    /// `despite_mixed_plan`.
    ///
    /// # Errors
    /// [`StationError::Control`], [`StationError::NeedsConfirmation`], [`StationError::BadConfirmation`] and
    /// [`VehicleError::PlanUnknown`](vencejo_vehicle::VehicleError::PlanUnknown).
    pub fn send(
        &self,
        message: &Message,
        despite_mixed_plan: bool,
        confirmation: Option<&str>,
    ) -> Result<SendReport, StationError> {
        let danger = |telemetry: &Telemetry, now| Danger::of_message(message, self.system, telemetry, now);
        self.admit(danger, || format!("{message:?}"), confirmation)?;
        self.station.shared.send(self.system, message, despite_mixed_plan)
    }

    /// In whose name it acts.
    fn operator(&self) -> &Operator {
        self.operator.as_deref().unwrap_or(&self.station.shared.operator)
    }

    /// Lets an act through that is no request: nobody else has control.
    pub(crate) fn take_control(&self) -> Result<(), StationError> {
        let taken = self.operator().act(self.station.now());
        taken.map_err(|Held(holder)| StationError::Control { holder })
    }

    /// Lets an act through: whoever does it has control, and a dangerous one is confirmed.
    fn admit(
        &self,
        danger: impl FnOnce(&Telemetry, MonoTime) -> Option<Danger>,
        act: impl FnOnce() -> String,
        confirmation: Option<&str>,
    ) -> Result<(), StationError> {
        let shared = &self.station.shared;
        let (telemetry, now) = self.telemetry();
        self.take_control()?;
        let operator = self.operator();
        if let Some(id) = confirmation {
            let is_good = shared.confirmations().take(id, operator.id(), self.system, &act(), now);
            return if is_good { Ok(()) } else { Err(StationError::BadConfirmation) };
        }
        let Some(danger) = danger(&telemetry, now) else { return Ok(()) };
        let challenge = shared.confirmations().issue(operator.id(), self.system, danger, act(), now);
        // Without random numbers there is no confirmation, and nothing dangerous is done.
        let challenge = challenge.ok_or(StationError::BadConfirmation)?;
        Err(StationError::NeedsConfirmation { challenge: Box::new(challenge) })
    }

    /// Whether it hears us. `false`: it is heard, but answers nothing of ours, so the link works in one direction only. `None`: not
    /// known, because it is not heard or was asked nothing, or because it is a recording.
    pub fn is_reached(&self) -> Option<bool> {
        self.station.shared.is_reached(self.system)
    }

    /// Where another vehicle is heard that uses the same system id, in words. That one is not followed, and nothing is sent to it.
    pub fn rival(&self) -> Option<String> {
        self.station.shared.rival(self.system)
    }

    /// Follows and commands that other vehicle from now on, and this one no more; whether there is one.
    ///
    /// # Errors
    /// [`StationError::Control`].
    pub fn follow_rival(&self) -> Result<bool, StationError> {
        self.take_control()?;
        Ok(self.station.shared.follow_rival(self.system))
    }

    /// Its autopilot's address.
    pub fn address(&self) -> Option<Address> {
        self.station.shared.with_vehicle(self.system, |vehicle| vehicle.address())
    }

    /// Its messages from now on, all or some ids, at most `capacity` waiting.
    pub fn subscribe_messages(&self, ids: Option<BTreeSet<u32>>, capacity: usize) -> Arc<DropOldest<Received>> {
        let core = self.station.shared.core();
        match core.watchers.get(&self.system) {
            Some(watchers) if !self.station.is_closed() => watchers.subscriptions.subscribe(ids, capacity),
            _ => DropOldest::ended(),
        }
    }

    /// Its events from now on, at most `capacity` waiting.
    pub fn subscribe_events(&self, capacity: usize) -> Arc<DropOldest<Observed>> {
        let core = self.station.shared.core();
        match core.watchers.get(&self.system) {
            Some(watchers) if !self.station.is_closed() => {
                let queue = Arc::new(DropOldest::new(capacity));
                watchers.subscriptions.events.lock().unwrap_or_else(PoisonError::into_inner).push(queue.clone());
                queue
            }
            _ => DropOldest::ended(),
        }
    }

    /// What tells that something new came from it.
    pub fn changes(&self) -> Arc<Changes> {
        self.station
            .shared
            .core()
            .watchers
            .get(&self.system)
            .map(|watchers| watchers.changes.clone())
            .unwrap_or_default()
    }

    /// The link that it is reached over, and what was counted of it there.
    pub fn link(&self) -> Option<(LinkInfo, LinkStats, Option<SourceStats>)> {
        let shared = &self.station.shared;
        let (id, _) = *shared.hub().links_of(self.system).first()?;
        let info = shared.hub().links().into_iter().find(|link| link.id == id)?;
        let stats = shared.hub().stats(id).ok()?;
        let address = self.address()?;
        let source = stats.sources.iter().find(|source| source.source == address).cloned();
        Some((info, stats, source))
    }

    /// Place in a plan, counted from 1, of an item on the wire. On an ArduPilot item 0 is home, which is in no plan.
    pub fn item_of_seq(&self, seq: MissionSeq) -> Option<u16> {
        seq.0.checked_add(1 - self.home_items()).filter(|item| *item > 0)
    }

    /// Number on the wire of a plan's item, counted from 1; `None` for 0.
    pub fn seq_of_item(&self, item: u16) -> Option<MissionSeq> {
        (item > 0).then(|| MissionSeq(item - (1 - self.home_items())))
    }

    /// 1 for an autopilot whose missions begin with home, else 0.
    fn home_items(&self) -> u16 {
        u16::from(self.telemetry().0.is_ardupilot())
    }

    /// A number that is another one as soon as something new has come from it: ask for it before looking at the vehicle,
    /// and give it to [`Self::wait_change`] afterwards, so that nothing is missed between the two.
    pub fn change_count(&self) -> u64 {
        self.changes().count()
    }

    /// Waits on this thread until [`Self::change_count`] is no longer `seen`, and gives it back; `None` when it stays so.
    /// Closing the station ends the wait.
    pub fn wait_change(&self, seen: u64, timeout: Duration) -> Option<u64> {
        self.changes().wait_blocking(seen, timeout)
    }

    /// A handle that does not keep the station alive.
    pub fn downgrade(&self) -> WeakVehicleHandle {
        WeakVehicleHandle {
            shared: Arc::downgrade(&self.station.shared),
            system: self.system,
            operator: self.operator.clone(),
        }
    }
}

/// A vehicle of a station that may be gone. Cheap to clone.
#[derive(Clone)]
pub struct WeakVehicleHandle {
    shared: Weak<Shared>,
    system: SystemId,
    operator: Option<Arc<Operator>>,
}

impl WeakVehicleHandle {
    /// The vehicle, unless its station is gone.
    pub fn upgrade(&self) -> Option<VehicleHandle> {
        let station = Station { shared: self.shared.upgrade()? };
        Some(VehicleHandle { station, system: self.system, operator: self.operator.clone() })
    }
}
