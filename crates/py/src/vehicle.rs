//! A vehicle for Python: every method starts a request or copies state; none waits.

use std::time::Duration;

use pyo3::prelude::*;
use pyo3::types::PyDict;
use vencejo_flight::checks::rehearse_and_check;
use vencejo_flight::landing::Wind;
use vencejo_flight::plan::{Change, Mission, Plan, PlanKind};
use vencejo_flight::rehearsal::{Air, Aircraft, Conditions, NotRehearsed};
use vencejo_proto::{Address, CommandInt, CommandLong, Message, SystemId};
use vencejo_station::{FarWish, SigningChange, StationError, VehicleHandle};
use vencejo_vehicle::modes::{Action, ModeFamily};
use vencejo_vehicle::signing::SETUP_SIGNING_ID;
use vencejo_vehicle::{Danger, PlanState, Request};

use crate::link::{link_dict, signing_dict};
use crate::messages::{fields_of, message_ids};
use crate::operator::PyOperator;
use crate::pending::PyPending;
use crate::plan::{FindingFields, PlanTuple, findings, plan_from_tuple, plan_to_tuple};
use crate::rehearsal::{self, Flown, Followed, LearnedPlane, Profile};
use crate::subscription::Subscription;
use crate::telemetry::{TelemetrySnapshot, seconds};
use crate::{errors, ground, requests, runtime};

/// A change between two plans: its kind, the item here and on board, from 1, and what differs.
type ChangeTuple = (&'static str, Option<usize>, Option<usize>, Vec<&'static str>);

fn change_tuple(change: &Change) -> ChangeTuple {
    match change {
        Change::Added { item } => ("added", Some(*item), None, Vec::new()),
        Change::Removed { on_board } => ("removed", None, Some(*on_board), Vec::new()),
        Change::Changed { item, on_board, fields } => {
            ("changed", Some(*item), Some(*on_board), fields.iter().map(|field| field.as_str()).collect())
        }
    }
}

/// Adds this module's class and functions.
pub fn register(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_class::<PyVehicle>()?;
    module.add_function(wrap_pyfunction!(modes_for, module)?)?;
    module.add_function(wrap_pyfunction!(mode_names, module)?)
}

/// Names of the mode for an act, of every kind of vehicle that has one.
#[pyfunction]
fn modes_for(act: &str) -> PyResult<Vec<&'static str>> {
    let action = match act {
        "mission" => Action::Mission,
        "loiter" => Action::Loiter,
        "return" => Action::ReturnToLaunch,
        "takeoff" => Action::Takeoff,
        "guided" => Action::Guided,
        other => return Err(invalid(format!("'{other}' is not an action with a mode"))),
    };
    Ok(ModeFamily::KNOWN.into_iter().filter_map(|family| action.mode(family)?.name()).collect())
}

/// Names of the modes of a kind of vehicle.
#[pyfunction]
fn mode_names(mav_type: u8, autopilot: u8) -> Vec<&'static str> {
    ModeFamily::of(autopilot, mav_type).modes_of(mav_type).map(|(_, name)| name).collect()
}

/// The longest wait for news in one go.
const LONGEST_WAIT: Duration = Duration::from_secs(1);

/// A vehicle of a station.
#[pyclass(frozen, name = "Vehicle", module = "vencejo._native")]
pub struct PyVehicle {
    vehicle: VehicleHandle,
}

fn kind_of(name: &str) -> PyResult<PlanKind> {
    match name {
        "mission" => Ok(PlanKind::Mission),
        "fence" => Ok(PlanKind::Fence),
        "rally" => Ok(PlanKind::Rally),
        other => Err(invalid(format!("'{other}' is not a kind of plan; choose 'mission', 'fence' or 'rally'"))),
    }
}

fn invalid(message: impl std::fmt::Display) -> PyErr {
    errors::raise("InvalidRequest", message)
}

/// The danger of this name.
fn danger_of(name: &str) -> PyResult<Danger> {
    Danger::from_code(name).ok_or_else(|| {
        let names: Vec<_> = Danger::ALL.into_iter().map(Danger::code).collect();
        invalid(format!("confirm is '{name}': what can be confirmed is {}", names.join(", ")))
    })
}

fn guarded(request: Request, despite_mixed_plan: bool) -> Request {
    if despite_mixed_plan { Request::DespiteMixedPlan(Box::new(request)) } else { request }
}

impl PyVehicle {
    /// A vehicle for Python.
    pub fn new(vehicle: VehicleHandle) -> Self {
        Self { vehicle }
    }

    /// The plane with the chosen airframe and battery, and a wind.
    fn flies_in(&self, (from_deg, speed_m_s): (f64, f64), profile: Profile) -> PyResult<(Aircraft, Air)> {
        let (plane, air) = self.vehicle.flies_in(Wind { from_deg, speed_m_s });
        Ok((profile.of(plane)?, air))
    }

    /// The same as an object of Python.
    pub fn into_python(py: Python<'_>, vehicle: VehicleHandle) -> PyResult<Bound<'_, PyAny>> {
        Ok(Bound::new(py, Self::new(vehicle))?.into_any())
    }

    fn start(&self, py: Python<'_>, request: Request) -> PyPending {
        let pending = runtime::detached(py, || self.vehicle.request(request));
        PyPending::of_request(pending, self.vehicle.clone())
    }

    fn wish(&self, py: Python<'_>, wish: FarWish) -> PyPending {
        PyPending::of_request(runtime::detached(py, || self.vehicle.control(wish)), self.vehicle.clone())
    }

    /// Starts what may be dangerous; `confirm` names what a program knows to be.
    fn start_confirmed(&self, py: Python<'_>, request: Request, confirm: Option<&str>) -> PyResult<PyPending> {
        let Some(named) = confirm.map(danger_of).transpose()? else { return Ok(self.start(py, request)) };
        let pending = runtime::detached(py, || self.vehicle.request_naming(request, named));
        Ok(PyPending::of_request(pending, self.vehicle.clone()))
    }
}

#[pymethods]
impl PyVehicle {
    #[getter]
    fn system_id(&self) -> u16 {
        self.vehicle.id().number()
    }

    /// The same vehicle, acted on in the name of another operator.
    fn acting_as(&self, operator: &PyOperator) -> Self {
        Self { vehicle: self.vehicle.acting_as(operator.operator()) }
    }

    fn telemetry(&self) -> TelemetrySnapshot {
        let (telemetry, now) = self.vehicle.telemetry();
        TelemetrySnapshot::new(telemetry, now)
    }

    /// A counter that changes whenever something new has come.
    fn change_count(&self) -> u64 {
        self.vehicle.change_count()
    }

    /// Waits until the number is no longer `seen`, and gives it back; `None` when it stays so. Who has seen nothing
    /// waits for nothing. At most a second, so that Ctrl-C gets in.
    #[pyo3(signature = (seen, timeout_s))]
    fn wait_change(&self, py: Python<'_>, seen: Option<u64>, timeout_s: f64) -> PyResult<Option<u64>> {
        let timeout = runtime::timeout(timeout_s)?.min(LONGEST_WAIT);
        let count = match seen {
            None => Some(self.vehicle.change_count()),
            Some(seen) => runtime::detached(py, || self.vehicle.wait_change(seen, timeout)),
        };
        py.check_signals()?;
        if self.vehicle.station().is_closed() {
            return Err(errors::from_station(&StationError::Closed));
        }
        Ok(count)
    }

    /// Whether its station is closed: nothing new comes any more.
    fn is_closed(&self) -> bool {
        self.vehicle.station().is_closed()
    }

    fn progress<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let progress = self.vehicle.progress().unwrap_or_default();
        let reached: Vec<u16> = progress.reached.iter().filter_map(|seq| self.vehicle.item_of_seq(*seq)).collect();
        let dict = PyDict::new(py);
        dict.set_item("item", progress.current.and_then(|seq| self.vehicle.item_of_seq(seq)))?;
        dict.set_item("total", progress.total)?;
        dict.set_item("reached", pyo3::types::PyTuple::new(py, reached)?)?;
        dict.set_item("is_complete", progress.is_complete)?;
        dict.set_item("distance_m", progress.distance_to_go_m)?;
        dict.set_item("time_s", progress.time_to_go_s)?;
        dict.set_item("leg_distance_m", progress.distance_to_current_m)?;
        dict.set_item("circled_turns", progress.circled.flown().map(|(turns, _)| turns))?;
        dict.set_item("circled_s", progress.circled.flown().map(|(_, time_s)| time_s))?;
        dict.set_item("target_off_m", progress.target_off_m)?;
        Ok(dict)
    }

    /// The plan on board of one kind as it was read; `None` while it is not known.
    fn plan_on_board(&self, kind: &str) -> PyResult<Option<PlanTuple>> {
        let kind = kind_of(kind)?;
        let list = match self.vehicle.plan_on_board(kind) {
            Some((_, Some(list))) => Mission::clone(&list),
            Some((PlanState::Empty, None)) => Mission::default(),
            _ => return Ok(None),
        };
        let plan = Plan::from_list(kind, list).map_err(|error| errors::raise("TransferError", error))?;
        Ok(Some(plan_to_tuple(&plan)))
    }

    /// How a part of a plan differs from what is on board: of each change its kind, the item here and on board, and
    /// what differs; `None` while what is on board is not known to be whole.
    fn plan_changes(&self, py: Python<'_>, plan: PlanTuple, kind: &str) -> PyResult<Option<Vec<ChangeTuple>>> {
        let (plan, kind) = (plan_from_tuple(plan)?, kind_of(kind)?);
        let changes = py.detach(|| self.vehicle.plan_changes(&plan, kind));
        Ok(changes.map(|(_, changes)| changes.iter().map(change_tuple).collect()))
    }

    fn plan_state<'py>(&self, py: Python<'py>, kind: &str) -> PyResult<Bound<'py, PyDict>> {
        let state = self.vehicle.plan_state(kind_of(kind)?);
        let dict = PyDict::new(py);
        let (name, count, hash) = match state {
            Some(PlanState::Empty) => ("empty", Some(0), None),
            Some(PlanState::Verified { count, hash }) => ("verified", Some(count), Some(format!("{hash:016x}"))),
            Some(PlanState::Differs { count, hash }) => ("unknown", Some(count), Some(format!("{hash:016x}"))),
            _ => ("unknown", None, None),
        };
        dict.set_item("may_be_mixed", state.is_some_and(PlanState::may_be_mixed))?;
        dict.set_item("state", name)?;
        dict.set_item("count", count)?;
        dict.set_item("hash", hash)?;
        dict.set_item("detail", state.map_or_else(|| name.to_owned(), |state| state.to_string()))?;
        Ok(dict)
    }

    fn texts(&self) -> Vec<(f64, u8, String)> {
        self.vehicle.texts().into_iter().map(|text| (seconds(text.at), text.severity.0, text.text)).collect()
    }

    fn link<'py>(&self, py: Python<'py>) -> PyResult<Option<Bound<'py, PyDict>>> {
        let Some((info, stats, source)) = self.vehicle.link() else { return Ok(None) };
        let now = self.vehicle.station().now();
        let dict = link_dict(py, &info, &stats, self.vehicle.station())?;
        if let Some(source) = source {
            // Of all that speak on the link, only the vehicle's own figures.
            dict.set_item("frames_received", source.received.frames)?;
            dict.set_item("bytes_received", source.received.bytes)?;
            dict.set_item("frames_lost", source.lost)?;
            dict.set_item("loss_pct", source.rates.loss_ratio.map(|ratio| ratio * 100.0))?;
            dict.set_item("age_s", now.since(source.last_seen).as_secs_f64())?;
        }
        Ok(Some(dict))
    }

    #[pyo3(signature = (names, capacity))]
    fn subscribe_messages(&self, names: Option<Vec<String>>, capacity: usize) -> PyResult<Subscription> {
        Ok(Subscription::of_messages(self.vehicle.subscribe_messages(message_ids(names)?, capacity)))
    }

    fn subscribe_events(&self, capacity: usize) -> Subscription {
        Subscription::of_events(self.vehicle.subscribe_events(capacity), self.vehicle.downgrade())
    }

    #[pyo3(signature = (name, fields, confirm, despite_mixed_plan))]
    fn send_message(
        &self,
        py: Python<'_>,
        name: &str,
        fields: &Bound<'_, PyDict>,
        confirm: Option<&str>,
        despite_mixed_plan: bool,
    ) -> PyResult<()> {
        let system = self.vehicle.system().unwrap_or(SystemId::BROADCAST);
        let address = self.vehicle.address().unwrap_or(Address { system, ..Address::new(0, 1) });
        let message = Message::from_fields(name, fields_of(name, fields)?, address).map_err(invalid)?;
        if message.id() == SETUP_SIGNING_ID {
            return Err(invalid("SETUP_SIGNING carries a key: use set_up_signing, rotate_signing or remove_signing"));
        }
        let named = confirm.map(danger_of).transpose()?;
        let sent = runtime::detached(py, || match named {
            Some(named) => self.vehicle.send_naming(&message, despite_mixed_plan, named),
            None => self.vehicle.send(&message, despite_mixed_plan, None),
        });
        if sent.map_err(|error| errors::from_station(&error))?.is_sent() {
            Ok(())
        } else {
            Err(errors::raise("LinkError", format!("{} was not sent: no link to the vehicle is open", message.name())))
        }
    }

    /// Asks for what describes itself in the core, by its name and values; `None` stands for a value that is not given.
    /// `confirm` names what a program knows to be dangerous about it.
    #[pyo3(signature = (name, values, confirm, despite_mixed_plan))]
    fn request(
        &self,
        py: Python<'_>,
        name: &str,
        values: &Bound<'_, PyDict>,
        confirm: Option<&str>,
        despite_mixed_plan: bool,
    ) -> PyResult<PyPending> {
        let request = requests::named(name, values)?;
        self.start_confirmed(py, guarded(request, despite_mixed_plan), confirm)
    }

    /// The mode it is in, the mode to change to, whether the mission is set back, whether any of it is needed, and all
    /// in words.
    fn flight_preparation(&self) -> Option<(String, Option<String>, bool, bool, String)> {
        let preparation = self.vehicle.flight_preparation()?;
        Some((
            preparation.from.to_string(),
            preparation.mode.map(|mode| mode.to_string()),
            preparation.rewinds_mission,
            preparation.is_needed(),
            preparation.to_string(),
        ))
    }

    #[pyo3(signature = (command, params, confirm, despite_mixed_plan))]
    fn command_long(
        &self,
        py: Python<'_>,
        command: u16,
        params: [f32; 7],
        confirm: Option<&str>,
        despite_mixed_plan: bool,
    ) -> PyResult<PyPending> {
        let target = Address::new(0, 0);
        let request = Request::RawCommandLong(CommandLong { target, command, confirmation: 0, params });
        self.start_confirmed(py, guarded(request, despite_mixed_plan), confirm)
    }

    #[allow(clippy::too_many_arguments, reason = "the arguments of one command")]
    #[pyo3(signature = (command, frame, params, x, y, z, confirm, despite_mixed_plan))]
    fn command_int(
        &self,
        py: Python<'_>,
        command: u16,
        frame: u8,
        params: [f32; 4],
        x: i32,
        y: i32,
        z: f32,
        confirm: Option<&str>,
        despite_mixed_plan: bool,
    ) -> PyResult<PyPending> {
        let target = Address::new(0, 0);
        let command = CommandInt { target, frame, command, current: 0, autocontinue: 0, params, x, y, z };
        self.start_confirmed(py, guarded(Request::RawCommandInt(command), despite_mixed_plan), confirm)
    }

    /// Findings of a plan that it is to fly now.
    fn check_plan(&self, py: Python<'_>, plan: PlanTuple) -> PyResult<Vec<FindingFields>> {
        let plan = plan_from_tuple(plan)?;
        Ok(findings(py.detach(|| self.vehicle.check_plan(&plan))))
    }

    /// Findings of one part of a plan that is to wait on board until it flies.
    fn check_upload(&self, py: Python<'_>, kind: &str, plan: PlanTuple) -> PyResult<Vec<FindingFields>> {
        let (kind, plan) = (kind_of(kind)?, plan_from_tuple(plan)?);
        Ok(findings(py.detach(|| self.vehicle.check_upload(kind, &plan, None))))
    }

    fn rehearse(
        &self,
        py: Python<'_>,
        plan: PlanTuple,
        wind: (f64, f64),
        profile: Profile,
        ground: Option<Bound<'_, PyAny>>,
        clearance_m: f64,
    ) -> PyResult<Flown> {
        let plan = plan_from_tuple(plan)?;
        let (plane, air) = self.flies_in(wind, profile)?;
        let home = self.vehicle.home();
        let map = ground::around(ground.as_ref(), &plan, home)?;
        runtime::interruptible(py, move |is_wanted| {
            let below = |point| map.height_m(point);
            let home = home.or(plan.mission.home).ok_or(NotRehearsed::NoHome)?;
            let conditions =
                Conditions { home: Some(home), ground: Some(&below), is_wanted, ..Conditions::new(&plane, air) };
            let (flown, found) = rehearse_and_check(&plan, &conditions, clearance_m)?;
            Ok(Flown::new(&flown, found, home.alt_amsl_m))
        })?
        .map_err(|why: NotRehearsed| invalid(why))
    }

    /// The airframe learned from its flight; `None` while there is too little data.
    fn learned(&self, py: Python<'_>) -> Option<LearnedPlane> {
        runtime::detached(py, || self.vehicle.learned()).map(LearnedPlane::from)
    }

    /// At moments of a plan, or from now on; `None` where it is not known to be in the air.
    fn what_if(
        &self,
        py: Python<'_>,
        at: Option<(PlanTuple, Vec<f64>)>,
        triggers: Vec<String>,
        wind: (f64, f64),
        profile: Profile,
        ground: Option<Bound<'_, PyAny>>,
    ) -> PyResult<Option<Vec<Followed>>> {
        let at = at.map(|(plan, moments)| Ok::<_, PyErr>((plan_from_tuple(plan)?, moments))).transpose()?;
        let triggers = rehearsal::triggers_named(&triggers)?;
        let (plane, air) = self.flies_in(wind, profile)?;
        let home = self.vehicle.home();
        let asked = match at {
            Some((plan, moments)) => Some((plan, None, moments)),
            None => self.vehicle.from_now().map(|(plan, start)| (plan, Some(start), vec![0.0])),
        };
        let Some((plan, start, moments)) = asked else { return Ok(None) };
        let map = ground::around(ground.as_ref(), &plan, home)?;
        runtime::interruptible(py, move |is_wanted| {
            let below = |point| map.height_m(point);
            let conditions = Conditions { home, ground: Some(&below), is_wanted, ..Conditions::new(&plane, air) };
            let conditions = Conditions { start: start.unwrap_or(conditions.start), ..conditions };
            rehearsal::what_follows(&plan, &conditions, &triggers, &moments)
        })?
        .map(Some)
        .map_err(invalid)
    }

    fn upload(&self, py: Python<'_>, kind: &str, plan: PlanTuple, despite_findings: bool) -> PyResult<PyPending> {
        let kind = kind_of(kind)?;
        let (items, home) = plan_from_tuple(plan)?.into_list(kind).map_err(invalid)?;
        if items.is_empty() {
            return Err(invalid(format!("the plan has nothing for the {kind}; clear() removes what is on board")));
        }
        Ok(self.start(py, Request::UploadPlan { kind, items, home, despite_findings }))
    }

    fn download(&self, py: Python<'_>, kind: &str) -> PyResult<PyPending> {
        Ok(self.start(py, Request::DownloadPlan { kind: kind_of(kind)? }))
    }

    #[pyo3(signature = (kind, confirm))]
    fn clear(&self, py: Python<'_>, kind: &str, confirm: Option<&str>) -> PyResult<PyPending> {
        self.start_confirmed(py, Request::ClearPlan { kind: kind_of(kind)? }, confirm)
    }

    fn param_list(&self, py: Python<'_>) -> PyPending {
        self.start(py, Request::ParamList)
    }

    fn param_read(&self, py: Python<'_>, name: String) -> PyPending {
        self.start(py, Request::ParamRead { name })
    }

    #[pyo3(signature = (name, value, confirm))]
    fn param_set(&self, py: Python<'_>, name: String, value: f64, confirm: Option<&str>) -> PyResult<PyPending> {
        self.start_confirmed(py, Request::ParamSet { name, value }, confirm)
    }

    fn lacks_terrain(&self) -> bool {
        self.vehicle.lacks_terrain()
    }

    fn remote_name(&self) -> Option<String> {
        self.vehicle.remote_name()
    }

    /// Who has control, whether that is here, who asks for it, and whether that is here.
    fn control(&self) -> (Option<String>, bool, Option<String>, bool) {
        let held = self.vehicle.held();
        (held.holder, held.is_ours, held.requested_by, held.is_request_ours)
    }

    fn has_control(&self) -> bool {
        self.vehicle.has_control()
    }

    fn request_control(&self, py: Python<'_>) -> PyPending {
        self.wish(py, FarWish::Request)
    }

    fn release_control(&self, py: Python<'_>) -> PyPending {
        self.wish(py, FarWish::Release)
    }

    #[pyo3(signature = (requested_by))]
    fn keep_control(&self, py: Python<'_>, requested_by: Option<String>) -> PyPending {
        self.wish(py, FarWish::Keep { requested_by })
    }

    fn is_reached(&self) -> Option<bool> {
        self.vehicle.is_reached()
    }

    fn rival(&self) -> Option<String> {
        self.vehicle.rival()
    }

    fn follow_rival(&self, py: Python<'_>) -> PyResult<bool> {
        runtime::detached(py, || self.vehicle.follow_rival()).map_err(|error| errors::from_station(&error))
    }

    fn signing<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        signing_dict(py, &self.vehicle.signing())
    }

    #[pyo3(signature = (change, *, key, any_link))]
    fn change_signing(&self, change: &str, key: Option<String>, any_link: bool) -> PyResult<PyPending> {
        let change = match change {
            "set_up" => SigningChange::SetUp { key },
            "rotate" => SigningChange::Rotate { key },
            "remove" => SigningChange::Remove,
            other => return Err(invalid(format!("'{other}' is not a change of signing"))),
        };
        Ok(PyPending::of_request(self.vehicle.change_signing(change, any_link), self.vehicle.clone()))
    }
}
