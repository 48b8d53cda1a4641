//! The handle to one vehicle of a station: its state, requests, messages and events.

use std::collections::BTreeSet;
use std::sync::{Arc, PoisonError, Weak};
use std::time::Duration;

use vencejo_flight::checks::{
    CLEARANCE_M, CheckContext, Finding, FindingCode, Severity, check_plan, rehearse_and_check, with_flown,
};
use vencejo_flight::geodesy::{GeoPoint, direct};
use vencejo_flight::landing::Wind;
use vencejo_flight::plan::{Change, Fence, Home, Mission, Plan, PlanKind, Rally, plan_changes};
use vencejo_flight::progress::{Circled, Trip, trip};
use vencejo_flight::rehearsal::{Air, Aircraft, Conditions, Doing, Ground, Learned, NotRehearsed, Rehearsal, Start};
use vencejo_flight::way::{Way, way};
use vencejo_link::{LinkInfo, LinkStats, SendReport, SourceStats};
use vencejo_proto::param::ParamName;
use vencejo_proto::{Address, Message, MissionSeq, MonoTime, SystemId};
use vencejo_vehicle::modes::ModeFamily;
use vencejo_vehicle::telemetry::{self, Telemetry, Text};
use vencejo_vehicle::{
    Conduct, Danger, FlightParameters, FlightPreparation, MissionProgress, PlanState, Reply, Request, TerrainBlock,
    Vehicle, VehicleEvent, VehicleId,
};

use crate::changes::Changes;
use crate::confirm::Challenge;
use crate::control::Operator;
use crate::error::StationError;
use crate::pending::Pending;
use crate::queue::DropOldest;
use crate::remote::{FarHeld, FarWish, Silence};
use crate::station::{RequestResult, Shared, Station, VehicleHandle};
use crate::subscriptions::{Observed, Received};

/// Distance below the target altitude at which a take-off is done, m (`ArduPlane/mode_takeoff.cpp`).
const TAKEN_OFF_M: f64 = 2.0;

impl VehicleHandle {
    /// Its id in this station.
    pub fn id(&self) -> VehicleId {
        self.id
    }

    /// Its MAVLink system id, by which links know it; `None` for a remote vehicle.
    pub fn system(&self) -> Option<SystemId> {
        self.id.system()
    }

    /// The station that hears it.
    pub fn station(&self) -> &Station {
        &self.station
    }

    /// A copy of its telemetry, and the time at which it was taken: of a replayed vehicle in the time of its recording.
    pub fn telemetry(&self) -> (Telemetry, MonoTime) {
        self.station.shared.telemetry(self.id)
    }

    /// Its newest STATUSTEXT messages, oldest first.
    pub fn texts(&self) -> Vec<Text> {
        let texts = |vehicle: &Vehicle| vehicle.texts().iter().cloned().collect();
        self.station.shared.with_vehicle(self.id, texts).unwrap_or_default()
    }

    /// Its newest text of this severity or worse, received within a time. Texts stamped with the clock's origin are
    /// skipped: a remote vehicle wrote them before this station started, at an unknown time.
    pub fn newest_text(&self, severity: telemetry::Severity, within: Duration) -> Option<Text> {
        let (_, now) = self.telemetry();
        let is_fresh = |text: &&Text| text.at > MonoTime::ZERO && now.since(text.at) <= within;
        let is_wanted = |text: &&Text| text.severity <= severity && is_fresh(text);
        let newest = |vehicle: &Vehicle| vehicle.texts().iter().rev().find(is_wanted).cloned();
        self.station.shared.with_vehicle(self.id, newest).flatten()
    }

    /// Who has control of a remote vehicle; `None` for one at a link, or of a recording.
    pub fn held_far(&self) -> Option<FarHeld> {
        self.station.shared.remote(self.id).filter(|remote| !remote.is_recording()).map(|remote| remote.held())
    }

    /// The silence of a remote vehicle's autopilot, if its station on board is heard and reports it. `None` if the
    /// station on board is not heard either: then nothing is known of the autopilot.
    pub fn silence(&self) -> Option<Silence> {
        self.station.shared.remote(self.id)?.silence()
    }

    /// When its autopilot was last heard.
    pub fn heard_at(&self) -> Option<MonoTime> {
        self.station.shared.with_vehicle(self.id, Vehicle::heard_at)
    }

    /// Who has control of it: of a vehicle at a link, who has control of this station.
    pub fn held(&self) -> FarHeld {
        let of_station = || {
            let control = self.station.control();
            let (holder, requested_by) = (control.holder(), control.requested_by());
            FarHeld { is_ours: holder.is_some(), is_request_ours: requested_by.is_some(), holder, requested_by }
        };
        self.held_far().unwrap_or_else(of_station)
    }

    /// Whether its operator has control of it: a remote vehicle's is this station's besides.
    pub fn has_control(&self) -> bool {
        self.held().is_ours && self.operator().has_control()
    }

    /// Requests, releases or keeps control of it. Control of a vehicle at a link is that of this station; for that of a
    /// remote one, an operator needs this station's too, and takes it if it is free. Of a vehicle at a link a request
    /// may stand when this has ended ([`Self::has_control`]).
    pub fn control(&self, wish: FarWish) -> Pending<RequestResult> {
        if let Err(error) = self.station.shared.admit_control(self.id) {
            return Pending::ended(Err(error));
        }
        let (now, operator) = (self.station.now(), self.operator());
        let Some(remote) = self.station.shared.remote(self.id) else {
            match wish {
                FarWish::Request => {
                    operator.request(now);
                }
                FarWish::Release => operator.release(now),
                FarWish::Keep { requested_by } => operator.keep(requested_by.as_deref(), now),
            }
            return Pending::ended(Ok(Reply::Done));
        };
        if let Err(error) = self.take_control() {
            return Pending::ended(Err(error));
        }
        let name = operator.name();
        self.station.shared.carry(|_| remote.control(wish, name))
    }

    /// Whether its certificate was revoked in its fleet, as far as is known here.
    pub fn is_revoked(&self) -> bool {
        self.station.shared.remote(self.id).is_some_and(|remote| remote.is_revoked())
    }

    /// Its progress in the mission.
    pub fn progress(&self) -> Option<MissionProgress> {
        self.station.shared.with_vehicle(self.id, |vehicle| vehicle.progress())
    }

    /// Its present conduct: following a mission, landing, circling.
    pub fn conduct(&self) -> Conduct {
        self.station.shared.with_vehicle(self.id, |vehicle| vehicle.conduct()).unwrap_or_default()
    }

    /// The state of a plan on board.
    pub fn plan_state(&self, kind: PlanKind) -> Option<PlanState> {
        self.station.shared.with_vehicle(self.id, |vehicle| vehicle.plan_state(kind))
    }

    /// The state of a plan on board, and its items where they are known and not empty. Sends nothing: the station reads
    /// unknown plans by itself.
    pub fn plan_on_board(&self, kind: PlanKind) -> Option<(PlanState, Option<Arc<Mission>>)> {
        let known = |vehicle: &Vehicle| (vehicle.plan_state(kind), vehicle.plan_on_board(kind).cloned());
        self.station.shared.with_vehicle(self.id, known)
    }

    /// The mission on board, with the fence and the rally points as far as they are known; `None` while the mission is
    /// not.
    pub fn known_plan(&self) -> Option<Plan> {
        let part = |kind| Plan::from_list(kind, self.plan_on_board(kind)?.1?.as_ref().clone()).ok();
        let mission = part(PlanKind::Mission)?.mission;
        let fence = part(PlanKind::Fence).unwrap_or_default().fence;
        Some(Plan { mission, fence, rally: part(PlanKind::Rally).unwrap_or_default().rally })
    }

    /// The differences of one part of a plan from the one on board, as this vehicle stores items, and the state of the
    /// latter; `None` while that is not verified.
    pub fn plan_changes(&self, plan: &Plan, kind: PlanKind) -> Option<(PlanState, Vec<Change>)> {
        let known = |vehicle: &Vehicle| {
            let list = vehicle.plan_on_board(kind).cloned();
            (vehicle.plan_state(kind), list, vehicle.keeping())
        };
        let (state, list, keeping) = self.station.shared.with_vehicle(self.id, known)?;
        let on_board = match (state, list) {
            (PlanState::Empty, _) => Plan::default(),
            (PlanState::Verified { .. }, Some(list)) => Plan::from_list(kind, Mission::clone(&list)).ok()?,
            _ => return None,
        };
        Some((state, plan_changes(&plan.items(kind), &on_board.items(kind), keeping)))
    }

    /// Findings in a plan for this vehicle in its present state.
    pub fn check_plan(&self, plan: &Plan) -> Vec<Finding> {
        check_plan(plan, &self.check_context())
    }

    /// The same before an upload: the plan may wait on board until the plane flies, so it need not begin with a
    /// take-off. A plan without errors is rehearsed too, where the plane's parameters were read: in the wind that it
    /// estimates, or in calm air, over `ground` as far as that is known. That may take some tenths of a second. Of a
    /// fence or rally points that are sent alone only the places are checked: the mission may be another by the flight.
    pub fn check_upload(&self, kind: PlanKind, plan: &Plan, ground: Option<&Ground<'_>>) -> Vec<Finding> {
        let context = CheckContext { on_ground: None, ..self.check_context() };
        if kind != PlanKind::Mission {
            let areas = Plan {
                mission: Mission { items: Vec::new(), ..plan.mission },
                fence: if kind == PlanKind::Fence { plan.fence.clone() } else { Fence::default() },
                rally: if kind == PlanKind::Rally { plan.rally.clone() } else { Rally::default() },
            };
            let is_of_areas = |finding: &Finding| {
                matches!(finding.code(), FindingCode::AreaOutOfReach | FindingCode::BadFence | FindingCode::BadRally)
            };
            return check_plan(&areas, &context).into_iter().filter(is_of_areas).collect();
        }
        let mut found = check_plan(plan, &context);
        let is_sound = found.iter().all(|finding| finding.severity != Severity::Error);
        if is_sound && !context.can_hover && !plan.mission.items.is_empty() && self.knows_how_it_flies() {
            let told = self.telemetry().0.wind.map(|wind| wind.value);
            let wind = told.and_then(|wind| Some(Wind { from_deg: wind.from_deg?, speed_m_s: wind.speed_m_s? }));
            let wind = wind.unwrap_or_default();
            if let Ok((_, flown)) = self.rehearse(plan, &self.flies_in(wind), ground, CLEARANCE_M) {
                found = with_flown(found, flown);
            }
        }
        found
    }

    /// A mission as this vehicle would fly it, in calm air.
    pub fn trip(&self, mission: &Mission) -> Option<Trip> {
        let (airspeed_m_s, options) = self.station.shared.with_vehicle(self.id, Vehicle::progress_terms)?;
        Some(trip(mission, Some(airspeed_m_s), &options))
    }

    /// The way of a mission as it is drawn for this vehicle.
    pub fn way(&self, mission: &Mission) -> Option<Way> {
        let (airspeed_m_s, options) = self.station.shared.with_vehicle(self.id, Vehicle::progress_terms)?;
        Some(way(mission, airspeed_m_s, &options))
    }

    /// What the checks know of this vehicle.
    pub fn check_context(&self) -> CheckContext {
        self.station.shared.with_vehicle(self.id, Vehicle::check_context).unwrap_or_default()
    }

    /// Flight parameters, as far as they were read.
    pub fn flight_parameters(&self) -> FlightParameters {
        self.station.shared.with_vehicle(self.id, Vehicle::flight_parameters).unwrap_or_default()
    }

    /// Rehearses a plan with the plane and wind of [`Self::flies_in`], from the ground at its home, with the findings
    /// of that. `clearance_m` is the least height above ground, where that is known.
    ///
    /// # Errors
    /// [`NotRehearsed`].
    pub fn rehearse(
        &self,
        plan: &Plan,
        (plane, air): &(Aircraft, Air),
        ground: Option<&Ground<'_>>,
        clearance_m: f64,
    ) -> Result<(Rehearsal, Vec<Finding>), NotRehearsed> {
        let conditions = Conditions { home: self.home(), ground, ..Conditions::new(plane, *air) };
        rehearse_and_check(plan, &conditions, clearance_m)
    }

    /// This plane in a wind, for a rehearsal: with its parameters as far as they were read, and ArduPlane's defaults
    /// for the others. The battery is taken from its telemetry; its power, which no parameter gives, from the flight
    /// followed so far.
    pub fn flies_in(&self, wind: Wind) -> (Aircraft, Air) {
        let known = self.station.shared.with_vehicle(self.id, Vehicle::parameters).unwrap_or_default();
        let get = |name: &str| ParamName::new(name).ok().and_then(|name| known.get(&name).copied());
        let mut plane = Aircraft::from_ardupilot(get);
        let (telemetry, _) = self.telemetry();
        let battery = telemetry.batteries[0].map(|battery| battery.value);
        let status = telemetry.sys_status.map(|status| status.value);
        plane.battery = plane.battery.as_told(
            battery.and_then(|battery| battery.voltage_v).or(status.and_then(|status| status.voltage_v)),
            battery.and_then(|battery| battery.consumed_mah),
            battery
                .and_then(|battery| battery.remaining_pct)
                .or(status.and_then(|status| status.battery_remaining_pct))
                .map(|left_pct| left_pct / 100.0),
        );
        if let Some(Learned { airframe, .. }) =
            self.learned_of(&plane).filter(|_| plane.airframe.power_cruise_w.is_none())
        {
            plane.airframe.power_cruise_w = airframe.power_cruise_w;
            plane.airframe.power_exponent = airframe.power_exponent;
            plane.airframe.voltage_v = airframe.voltage_v;
        }
        (plane, Air::of(wind, get))
    }

    /// The value of a parameter, if it was read.
    fn parameter(&self, name: &str) -> Option<f64> {
        let name = ParamName::new(name).ok()?;
        self.station.shared.with_vehicle(self.id, |vehicle| vehicle.parameters().get(&name).copied()).flatten()
    }

    /// Performance learned from its flight, from at most the last ten minutes in the air; `None` where that is too
    /// little.
    pub fn learned(&self) -> Option<Learned> {
        self.learned_of(&self.flies_in(Wind::default()).0)
    }

    fn learned_of(&self, plane: &Aircraft) -> Option<Learned> {
        // Learning takes milliseconds: done on a copy, outside the lock.
        let learner = self.station.shared.with_vehicle(self.id, |vehicle| vehicle.learner().clone());
        learner?.learned(plane)
    }

    /// Its present position and activity as the start of a rehearsal; `None` on the ground, and where they are not
    /// known. Known for ArduPlane in most modes, for others in the mode that follows the mission.
    pub fn in_flight(&self) -> Option<Start> {
        let (telemetry, _) = self.telemetry();
        let mode = telemetry.mode()?;
        if telemetry.is_on_ground() != Some(false) {
            return None;
        }
        let position = telemetry.position?.value;
        let (point, height_m) = (GeoPoint::new(position.lat_deg?, position.lon_deg?).ok()?, position.alt_rel_home_m?);
        let progress = self.progress()?;
        let current = progress.current.and_then(|seq| self.item_of_seq(seq));
        let current = current.map(|item| usize::from(item - 1));
        // The target of ArduPlane's navigation controller; the centre of a circle.
        let target = || {
            let nav = telemetry.nav?.value;
            let to = direct(point, nav.target_bearing_deg?, nav.wp_distance_m?);
            Some((to, height_m + nav.alt_error_m.unwrap_or(0.0)))
        };
        let doing = if mode.follows_mission() {
            current?;
            Doing::Mission
        } else if mode.family == ModeFamily::ArduPlane {
            match mode.custom_mode {
                1 => Doing::Circling,
                11 => Doing::Returning,
                // TAKEOFF while it climbs steers by its course, and its failsafes wait until it is done.
                13 if height_m >= self.parameter("TKOFF_ALT").unwrap_or(50.0) - TAKEN_OFF_M => {
                    target().map(|(around, height_m)| Doing::TookOff { around, height_m })?
                }
                12 => target().map(|(around, height_m)| Doing::Loitering { around, height_m })?,
                15 => target().map(|(to, height_m)| Doing::Guided { to, height_m })?,
                // MANUAL, STABILIZE, TRAINING, ACRO, FBWA, FBWB, CRUISE and AUTOTUNE.
                0 | 2..=8 => Doing::Piloted,
                24 => Doing::Soaring,
                _ => return None,
            }
        } else {
            return None;
        };
        Some(Start::Air {
            point,
            height_m,
            heading_deg: position.heading_deg?,
            airspeed_m_s: telemetry.hud?.value.airspeed_m_s?,
            index: current.unwrap_or(0),
            doing,
            circled: if doing == Doing::Mission { progress.circled } else { Circled::Nothing },
        })
    }

    /// Plan and start of a rehearsal from now on: [`Self::in_flight`] with the plan on board. For a plane that does not
    /// follow its mission an unknown plan counts as empty. `None` as there, and where the mission that it follows is
    /// not known.
    pub fn from_now(&self) -> Option<(Plan, Start)> {
        let start = self.in_flight()?;
        let follows = matches!(start, Start::Air { doing: Doing::Mission, .. });
        let plan = self.known_plan().or_else(|| (!follows).then(Plan::default))?;
        Some((plan, start))
    }

    /// Its home position, if it is known.
    pub fn home(&self) -> Option<Home> {
        self.check_context().home
    }

    /// Whether the parameters that a rehearsal needs were read.
    pub fn knows_how_it_flies(&self) -> bool {
        let known = self.station.shared.with_vehicle(self.id, Vehicle::parameters).unwrap_or_default();
        ["NAVL1_PERIOD", "TECS_TIME_CONST"]
            .iter()
            .all(|name| ParamName::new(name).is_ok_and(|name| known.contains_key(&name)))
    }

    /// What a flight needs first; see [`Request::PrepareFlight`].
    pub fn flight_preparation(&self) -> Option<FlightPreparation> {
        self.station.shared.with_vehicle(self.id, |vehicle| vehicle.flight_preparation()).flatten()
    }

    /// A handle that acts in the name of this operator.
    pub fn acting_as(&self, operator: Arc<Operator>) -> Self {
        Self { operator: Some(operator), ..self.clone() }
    }

    /// Starts a request. It is checked before anything is sent: an act needs control, which it takes when that is free;
    /// a dangerous one ends with [`StationError::NeedsConfirmation`].
    pub fn request(&self, request: Request) -> Pending<RequestResult> {
        self.request_confirmed(request, None)
    }

    /// The same, with the confirmation that the first request returned.
    pub fn request_confirmed(&self, request: Request, confirmation: Option<&str>) -> Pending<RequestResult> {
        let mut confirmed = None;
        if request.is_act() {
            let danger = |telemetry: &Telemetry, now| Danger::of_request(&request, telemetry, now);
            if let Err(error) = self.admit(danger, || format!("{request:?}"), confirmation) {
                return Pending::ended(Err(error));
            }
            if confirmation.is_some() {
                let (telemetry, now) = self.telemetry();
                confirmed = Danger::of_request(&request, &telemetry, now);
            }
        }
        match self.station.shared.remote(self.id) {
            // A note is not sent: it is shown here.
            Some(remote) if !matches!(request, Request::Note { .. }) => {
                let operator = self.operator().name();
                self.station.shared.carry(|telling| remote.request(request, confirmed, operator, telling))
            }
            _ => self.station.shared.request(self.id, request),
        }
    }

    /// The same, for a program that confirms by naming the danger: done when it names the right one.
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

    /// Sends any message as it is, without waiting for an answer. It is an act like any other. Messages that arm the
    /// vehicle or start or jump in its mission are refused while that may be a mixture of two, and those that have it
    /// follow the mission also where that leads out of reach, or where home and position are not known, unless
    /// `despite_mixed_plan`.
    ///
    /// # Errors
    /// [`StationError::Control`], [`StationError::NeedsConfirmation`], [`StationError::BadConfirmation`],
    /// [`StationError::Replayed`], [`StationError::RemoteRefused`] for a remote vehicle, and of
    /// [`VehicleError`](vencejo_vehicle::VehicleError) `PlanUnknown`, `OutOfReach`, `HomeUnknown`, `Landing` and
    /// `InvalidValue`.
    pub fn send(
        &self,
        message: &Message,
        despite_mixed_plan: bool,
        confirmation: Option<&str>,
    ) -> Result<SendReport, StationError> {
        self.station.shared.core().admit(self.id)?;
        let Some(system) = self.system() else {
            let name = self.remote_name().unwrap_or_default();
            let why = "a raw message has no answer, so its result would stay unknown: use a command by its number (COMMAND_LONG, \
                       COMMAND_INT), or send it from a station on board or at a direct link"
                .to_owned();
            return Err(StationError::RemoteRefused { name, why });
        };
        let danger = |telemetry: &Telemetry, now| Danger::of_message(message, system, telemetry, now);
        self.admit(danger, || format!("{message:?}"), confirmation)?;
        self.station.shared.send(self.id, message, despite_mixed_plan)
    }

    /// Answers a block of terrain that the vehicle requested, with altitudes above mean sea level in the order of
    /// [`TerrainBlock::places`]; returns whether all are known. Needs no control: the vehicle asked for it. A station
    /// that only listens does not answer.
    pub fn answer_terrain(&self, block: &TerrainBlock, alt_amsl_m: impl IntoIterator<Item = Option<f64>>) -> bool {
        let Some(answer) = block.answer(alt_amsl_m) else { return false };
        let shared = &self.station.shared;
        if shared.config.request_streams && shared.answer(self.id, &answer).is_some_and(|sent| !sent.is_sent()) {
            tracing::debug!(vehicle = %self.id, "terrain was not sent: no link is open to the vehicle; it will ask again");
        }
        true
    }

    /// Whether it asks for terrain that no map here has.
    pub fn lacks_terrain(&self) -> bool {
        self.station.shared.core().watchers.get(&self.id).is_some_and(|watchers| watchers.lacks_terrain)
    }

    /// Notes whether all the terrain that it last asked for is known; subscribers get an event on a change.
    pub fn tell_terrain(&self, is_known: bool) {
        let mut core = self.station.shared.core();
        let Some(watchers) = core.watchers.get_mut(&self.id) else { return };
        if watchers.lacks_terrain != is_known {
            return;
        }
        watchers.lacks_terrain = !is_known;
        let event = if is_known { VehicleEvent::TerrainKnown } else { VehicleEvent::TerrainUnknown };
        watchers.subscriptions.on_event(&Observed { event, at: self.station.now() });
        watchers.changes.notify();
    }

    /// The operator it acts for.
    fn operator(&self) -> &Operator {
        self.operator.as_deref().unwrap_or(&self.station.shared.operator)
    }

    /// Checks that the caller may act (for acts that are not a `Request`).
    pub(crate) fn take_control(&self) -> Result<(), StationError> {
        Ok(self.operator().act(self.station.now())?)
    }

    /// Admits an act: the vehicle is not a recording, the operator has control, and a dangerous act is confirmed.
    fn admit(
        &self,
        danger: impl FnOnce(&Telemetry, MonoTime) -> Option<Danger>,
        act: impl FnOnce() -> String,
        confirmation: Option<&str>,
    ) -> Result<(), StationError> {
        let shared = &self.station.shared;
        shared.core().admit(self.id)?;
        let (telemetry, now) = self.telemetry();
        self.take_control()?;
        let operator = self.operator();
        if let Some(id) = confirmation {
            let is_good = shared.confirmations().take(id, operator.id(), self.id, &act(), now);
            return if is_good { Ok(()) } else { Err(StationError::BadConfirmation) };
        }
        let Some(danger) = danger(&telemetry, now) else { return Ok(()) };
        let challenge = shared.confirmations().issue(operator.id(), self.id, danger, act(), now);
        // Without random numbers there is no confirmation, and nothing dangerous is done.
        let challenge = Challenge { name: self.remote_name(), ..challenge.ok_or(StationError::BadConfirmation)? };
        Err(StationError::NeedsConfirmation { challenge: Box::new(challenge) })
    }

    /// Whether it hears us. `false`: it is heard but does not answer, so the link works in one direction only. `None`:
    /// not known, because it is not heard, was asked nothing, or is a recording.
    pub fn is_reached(&self) -> Option<bool> {
        self.station.shared.is_reached(self.id)
    }

    /// The place, in words, of another vehicle with the same system id: it is not followed, and nothing is sent to it.
    /// For a remote vehicle, the place of another computer with its name: orders go only to the one heard first.
    pub fn rival(&self) -> Option<String> {
        self.station.shared.rival(self.id)
    }

    /// Follows and commands that other vehicle instead from now on; whether there is one. Not possible for a remote
    /// vehicle.
    ///
    /// # Errors
    /// [`StationError::Control`].
    pub fn follow_rival(&self) -> Result<bool, StationError> {
        self.take_control()?;
        Ok(self.station.shared.follow_rival(self.id))
    }

    /// Its autopilot's address.
    pub fn address(&self) -> Option<Address> {
        self.station.shared.with_vehicle(self.id, |vehicle| vehicle.address())
    }

    /// Its messages from now on, all or some ids, at most `capacity` waiting.
    pub fn subscribe_messages(&self, ids: Option<BTreeSet<u32>>, capacity: usize) -> Arc<DropOldest<Received>> {
        let core = self.station.shared.core();
        match core.watchers.get(&self.id) {
            Some(watchers) if !self.station.is_closed() => watchers.subscriptions.subscribe(ids, capacity),
            _ => DropOldest::ended(),
        }
    }

    /// Its events from now on, at most `capacity` waiting.
    pub fn subscribe_events(&self, capacity: usize) -> Arc<DropOldest<Observed>> {
        let core = self.station.shared.core();
        match core.watchers.get(&self.id) {
            Some(watchers) if !self.station.is_closed() => {
                let queue = Arc::new(DropOldest::new(capacity));
                watchers.subscriptions.events.lock().unwrap_or_else(PoisonError::into_inner).push(queue.clone());
                queue
            }
            _ => DropOldest::ended(),
        }
    }

    /// Notifies of anything new from it.
    pub fn changes(&self) -> Arc<Changes> {
        self.station.shared.core().watchers.get(&self.id).map(|watchers| watchers.changes.clone()).unwrap_or_default()
    }

    /// The link that it is reached over, and its counts there.
    pub fn link(&self) -> Option<(LinkInfo, LinkStats, Option<SourceStats>)> {
        let shared = &self.station.shared;
        let (id, _) = *shared.hub().links_of(self.system()?).first()?;
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

    /// 1 for an autopilot whose missions begin with home, else 0.
    fn home_items(&self) -> u16 {
        u16::from(self.telemetry().0.is_ardupilot())
    }

    /// A counter that changes whenever something new has come from it: read it before looking at the vehicle, and pass
    /// it to [`Self::wait_change`] afterwards, so that nothing is missed in between.
    pub fn change_count(&self) -> u64 {
        self.changes().count()
    }

    /// Blocks this thread until [`Self::change_count`] is no longer `seen`, and returns it; `None` after the time-out.
    /// Closing the station ends the wait.
    pub fn wait_change(&self, seen: u64, timeout: Duration) -> Option<u64> {
        self.changes().wait_blocking(seen, timeout)
    }

    /// A handle that does not keep the station alive.
    pub fn downgrade(&self) -> WeakVehicleHandle {
        WeakVehicleHandle { shared: Arc::downgrade(&self.station.shared), id: self.id, operator: self.operator.clone() }
    }
}

/// A vehicle of a station that may be gone. Cheap to clone.
#[derive(Clone)]
pub struct WeakVehicleHandle {
    shared: Weak<Shared>,
    id: VehicleId,
    operator: Option<Arc<Operator>>,
}

impl WeakVehicleHandle {
    /// The vehicle, unless its station is gone.
    pub fn upgrade(&self) -> Option<VehicleHandle> {
        let station = Station { shared: self.shared.upgrade()? };
        Some(VehicleHandle { station, id: self.id, operator: self.operator.clone() })
    }
}
