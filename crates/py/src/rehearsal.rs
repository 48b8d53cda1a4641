//! Rehearsal for Python (see `vencejo.rehearsal`), by `vencejo-flight`.

use std::collections::HashMap;
use std::fs::File;
use std::io;
use std::path::PathBuf;

use pyo3::prelude::*;
use vencejo_flight::Plain;
use vencejo_flight::checks::{CheckContext, Finding, Inspection, fixes, rehearse_and_check};
use vencejo_flight::landing::Wind;
use vencejo_flight::plan::Plan;
use vencejo_flight::rehearsal::{
    Air, Aircraft, Airframe, BatteryLack, BatterySettings, Conditions, Doubts, Learned, NotRehearsed, Origin, Range,
    Rehearsal, Sample, Start, Trigger, WhatIf, glide_range, what_ifs,
};
use vencejo_proto::SystemId;
use vencejo_station::{Runs, recorded_flight};

use crate::errors;
use crate::ground;
use crate::plan::{Figures, FindingFields, PlanTuple, figures, findings, plan_from_tuple, plan_to_tuple};
use crate::runtime::{self, WhileWanted};

/// Adds what this module has.
pub fn register(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_function(wrap_pyfunction!(rehearse, module)?)?;
    module.add_function(wrap_pyfunction!(rehearse_many, module)?)?;
    module.add_function(wrap_pyfunction!(plan_fixes, module)?)?;
    module.add_function(wrap_pyfunction!(what_if, module)?)?;
    module.add_function(wrap_pyfunction!(learn_plane, module)?)
}

/// A moment, by the names of `vencejo.rehearsal.Moment`.
#[derive(IntoPyObject)]
pub struct Moment {
    time_s: f64,
    lat_deg: f64,
    lon_deg: f64,
    alt_amsl_m: f64,
    alt_rel_home_m: f64,
    alt_asked_m: f64,
    clearance_m: Option<f64>,
    airspeed_m_s: f64,
    groundspeed_m_s: f64,
    climb_m_s: f64,
    course_deg: f64,
    heading_deg: f64,
    bank_deg: f64,
    pitch_deg: f64,
    throttle: f64,
    item: Option<usize>,
}

/// An item as flown, by the names of `vencejo.rehearsal.Passage`.
#[derive(IntoPyObject)]
struct Passage {
    item: usize,
    begins_s: f64,
    reached_s: Option<f64>,
    nearest_m: Option<f64>,
}

/// A battery at the end, by the names of `vencejo.airframe.BatteryLeft`.
#[derive(IntoPyObject)]
struct BatteryLeft {
    capacity_wh: f64,
    left_wh: f64,
    reserve: f64,
    empty_s: Option<f64>,
    empty_item: Option<usize>,
}

/// A rehearsal, by the names of `vencejo.rehearsal.Rehearsal`.
#[derive(IntoPyObject)]
pub struct Flown {
    airframe: &'static str,
    findings: Vec<FindingFields>,
    track: Vec<Moment>,
    passages: Vec<Passage>,
    ending: &'static str,
    touch_down: Option<Moment>,
    duration_s: f64,
    distance_m: f64,
    energy_wh: Option<f64>,
    battery: Option<BatteryLeft>,
    battery_unknown: Option<&'static str>,
}

/// An airframe, by the names of `vencejo.airframe.Airframe`.
#[derive(FromPyObject, IntoPyObject)]
pub struct AirframeFields {
    cruise_m_s: f64,
    drag_m_s2: f64,
    induced: f64,
    thrust_full_m_s2: f64,
    throttle_cruise: f64,
    attack_rad: f64,
    level_pitch_rad: f64,
    pitot: f64,
    skid: f64,
    power_cruise_w: Option<f64>,
    is_simulated: bool,
    power_exponent: f64,
    voltage_v: Option<f64>,
    thrust_static_m_s2: Option<f64>,
    ground_drag_m_s2: Option<f64>,
}

impl From<AirframeFields> for Airframe {
    fn from(fields: AirframeFields) -> Self {
        Self {
            origin: Origin::Flight,
            cruise_m_s: fields.cruise_m_s,
            drag_m_s2: fields.drag_m_s2,
            induced: fields.induced,
            thrust_full_m_s2: fields.thrust_full_m_s2,
            throttle_cruise: fields.throttle_cruise,
            attack_rad: fields.attack_rad,
            level_pitch_rad: fields.level_pitch_rad,
            pitot: fields.pitot,
            skid: fields.skid,
            power_cruise_w: fields.power_cruise_w,
            is_simulated: fields.is_simulated,
            power_exponent: fields.power_exponent,
            voltage_v: fields.voltage_v,
            thrust_static_m_s2: fields.thrust_static_m_s2,
            ground_drag_m_s2: fields.ground_drag_m_s2,
        }
    }
}

impl From<Airframe> for AirframeFields {
    fn from(airframe: Airframe) -> Self {
        Self {
            cruise_m_s: airframe.cruise_m_s,
            drag_m_s2: airframe.drag_m_s2,
            induced: airframe.induced,
            thrust_full_m_s2: airframe.thrust_full_m_s2,
            throttle_cruise: airframe.throttle_cruise,
            attack_rad: airframe.attack_rad,
            level_pitch_rad: airframe.level_pitch_rad,
            pitot: airframe.pitot,
            skid: airframe.skid,
            power_cruise_w: airframe.power_cruise_w,
            is_simulated: airframe.is_simulated,
            power_exponent: airframe.power_exponent,
            voltage_v: airframe.voltage_v,
            thrust_static_m_s2: airframe.thrust_static_m_s2,
            ground_drag_m_s2: airframe.ground_drag_m_s2,
        }
    }
}

/// A battery as `vencejo.rehearsal.Battery` has it.
#[derive(FromPyObject)]
pub struct GivenBattery {
    capacity_mah: Option<f64>,
    voltage_v: Option<f64>,
    charge_pct: Option<f64>,
    reserve_pct: Option<f64>,
    power_cruise_w: Option<f64>,
}

/// The chosen airframe and battery.
#[derive(FromPyObject)]
pub struct Profile {
    #[pyo3(item)]
    airframe: Option<AirframeFields>,
    #[pyo3(item)]
    battery: Option<GivenBattery>,
}

impl Profile {
    /// The plane with them.
    ///
    /// # Errors
    /// `InvalidRequest` for a number out of its range.
    pub fn of(self, plane: Aircraft) -> PyResult<Aircraft> {
        let airframe = self.airframe.map(Airframe::from);
        let battery = self.battery.map(|given| BatterySettings {
            capacity_mah: given.capacity_mah,
            voltage_v: given.voltage_v,
            charge_pct: given.charge_pct,
            reserve_pct: given.reserve_pct,
            power_cruise_w: given.power_cruise_w,
        });
        let faults = [
            ("airframe", airframe.and_then(|airframe| airframe.fault())),
            ("battery", battery.and_then(|battery| battery.fault())),
        ];
        for (part, fault) in faults {
            if let Some((field, value, (low, high))) = fault {
                let problem = format!("{part}.{field} is {}, should be {low} to {high}", Plain(value));
                return Err(errors::raise("InvalidRequest", problem));
            }
        }
        Ok(plane.with(airframe, battery.as_ref()))
    }
}

/// The conditions of a rehearsal.
#[derive(FromPyObject)]
struct Given {
    #[pyo3(item)]
    parameters: HashMap<String, f64>,
    #[pyo3(item)]
    profile: Profile,
    #[pyo3(item)]
    wind: (f64, f64),
    #[pyo3(item)]
    gust_m_s: f64,
    #[pyo3(item)]
    seed: u64,
    #[pyo3(item)]
    heading_deg: Option<f64>,
    #[pyo3(item)]
    clearance_m: f64,
}

impl Given {
    fn plane_and_air(self) -> PyResult<(Aircraft, Air)> {
        let get = |name: &str| self.parameters.get(name).copied();
        let (from_deg, speed_m_s) = self.wind;
        let air = Air { gust_m_s: self.gust_m_s, seed: self.seed, ..Air::of(Wind { from_deg, speed_m_s }, get) };
        Ok((self.profile.of(Aircraft::from_ardupilot(get))?, air))
    }
}

/// Asks something of a plan and its conditions, with the clearance to keep, m.
///
/// # Errors
/// `InvalidRequest` for a plan that is not rehearsed; what a signal handler of Python raises meanwhile.
fn ask<T: Send + 'static>(
    py: Python<'_>,
    plan: PlanTuple,
    given: Given,
    ground: Option<&Bound<'_, PyAny>>,
    question: impl FnOnce(&Plan, &Conditions<'_>, f64) -> Result<T, NotRehearsed> + Send + 'static,
) -> PyResult<T> {
    let plan = plan_from_tuple(plan)?;
    let map = ground::around(ground, &plan, None)?;
    let (start, clearance_m) = (Start::Ground { heading_deg: given.heading_deg }, given.clearance_m);
    let (plane, air) = given.plane_and_air()?;
    runtime::interruptible(py, move |is_wanted| {
        let below = |point| map.height_m(point);
        let conditions = Conditions { start, ground: Some(&below), is_wanted, ..Conditions::new(&plane, air) };
        question(&plan, &conditions, clearance_m)
    })?
    .map_err(|why| errors::raise("InvalidRequest", why))
}

/// Altitude of the home that a plan is rehearsed from, m above mean sea level.
///
/// # Errors
/// [`NotRehearsed::NoHome`].
fn home_amsl_m(plan: &Plan, conditions: &Conditions<'_>) -> Result<f64, NotRehearsed> {
    conditions.home.or(plan.mission.home).map(|home| home.alt_amsl_m).ok_or(NotRehearsed::NoHome)
}

/// A change that resolves a finding, by the names of `vencejo.rehearsal.Fix`.
#[derive(IntoPyObject)]
struct Fixed {
    finding: FindingFields,
    does: &'static str,
    message: String,
    plan: PlanTuple,
    figures: Figures,
}

/// Changes of a plan that resolve its findings; without a home it is not rehearsed.
#[pyfunction]
#[pyo3(signature = (plan, *, parameters, wind, on_ground, ground, clearance_m))]
fn plan_fixes(
    py: Python<'_>,
    plan: PlanTuple,
    parameters: HashMap<String, f64>,
    wind: (f64, f64),
    on_ground: Option<bool>,
    ground: Option<Bound<'_, PyAny>>,
    clearance_m: f64,
) -> PyResult<Vec<Fixed>> {
    let plan = plan_from_tuple(plan)?;
    let map = ground::around(ground.as_ref(), &plan, None)?;
    runtime::interruptible(py, move |is_wanted| {
        let below = |point| map.height_m(point);
        let get = |name: &str| parameters.get(name).copied();
        let plane = Aircraft::from_ardupilot(get);
        let air = Air::of(Wind { from_deg: wind.0, speed_m_s: wind.1 }, get);
        let conditions = Some(Conditions { ground: Some(&below), is_wanted, ..Conditions::new(&plane, air) });
        let context = CheckContext { on_ground, ..CheckContext::of(&parameters) };
        let found = fixes(&plan, &Inspection { context, conditions, clearance_m });
        let told = found.into_iter().filter_map(|(finding, fix)| {
            let finding = findings(vec![finding]).pop()?;
            Some(Fixed {
                finding,
                does: fix.kind.as_str(),
                message: fix.message(),
                plan: plan_to_tuple(&fix.applied(&plan)),
                figures: figures(fix.kind.figures()),
            })
        });
        told.collect()
    })
}

/// Flies a plan with a plane of these parameters.
#[pyfunction]
#[pyo3(signature = (plan, given, ground))]
fn rehearse(py: Python<'_>, plan: PlanTuple, given: Given, ground: Option<Bound<'_, PyAny>>) -> PyResult<Flown> {
    ask(py, plan, given, ground.as_ref(), |plan, conditions, clearance_m| {
        let home_amsl_m = home_amsl_m(plan, conditions)?;
        rehearse_and_check(plan, conditions, clearance_m).map(|(flown, found)| Flown::new(&flown, found, home_amsl_m))
    })
}

/// Nine flights in ten, by the names of `vencejo.rehearsal.Range`.
#[derive(IntoPyObject)]
struct Nine {
    low: f64,
    median: f64,
    high: f64,
}

impl From<Range> for Nine {
    fn from(Range { low, median, high }: Range) -> Self {
        Self { low, median, high }
    }
}

/// A moment of the corridor, by the names of `vencejo.rehearsal.Breadth`.
#[derive(IntoPyObject)]
struct Breadth {
    time_s: f64,
    across_m: Nine,
    height_m: Nine,
}

/// Many flights, by the names of `vencejo.rehearsal.Spread`.
#[derive(IntoPyObject)]
struct Spread {
    expected: Flown,
    runs: usize,
    endings: Vec<(&'static str, usize)>,
    duration_s: Nine,
    energy_wh: Option<Nine>,
    battery_left: Option<Nine>,
    below_reserve: Option<usize>,
    touch_down_m: Option<Nine>,
    corridor: Vec<Breadth>,
}

/// Flies a plan many times, on all processors.
#[pyfunction]
#[pyo3(signature = (plan, given, ground, *, doubts, runs, seed))]
fn rehearse_many(
    py: Python<'_>,
    plan: PlanTuple,
    given: Given,
    ground: Option<Bound<'_, PyAny>>,
    doubts: (f64, f64, f64, f64, f64, f64),
    runs: usize,
    seed: u64,
) -> PyResult<Spread> {
    let (wind_speed_m_s, wind_from_deg, gust_m_s, thrust, drag, power) = doubts;
    let doubts = Doubts { wind_speed_m_s, wind_from_deg, gust_m_s, thrust, drag, power };
    ask(py, plan, given, ground.as_ref(), move |plan, conditions, clearance_m| {
        let home_amsl_m = home_amsl_m(plan, conditions)?;
        let (expected, found) = rehearse_and_check(plan, conditions, clearance_m)?;
        let runs = Runs { count: runs, seed, spared: 0 };
        let spread = vencejo_station::rehearse_many(plan, conditions, &doubts, expected, &runs)?;
        let breadth =
            |time_s, across: Range, height: Range| Breadth { time_s, across_m: across.into(), height_m: height.into() };
        Ok(Spread {
            expected: Flown::new(&spread.expected, found, home_amsl_m),
            runs: spread.runs,
            endings: spread.endings.into_iter().map(|(ending, count)| (ending.as_str(), count)).collect(),
            duration_s: spread.duration_s.into(),
            energy_wh: spread.energy_wh.map(Nine::from),
            battery_left: spread.battery_left.map(Nine::from),
            below_reserve: spread.below_reserve,
            touch_down_m: spread.touch_down_m.map(Nine::from),
            corridor: spread.corridor.iter().map(|at| breadth(at.time_s, at.across_m, at.height_m)).collect(),
        })
    })
}

/// A decision, by the names of `vencejo.what_if.Decision`.
#[derive(IntoPyObject)]
struct Decided {
    time_s: f64,
    reaction: &'static str,
}

/// What follows from a trigger, by the names of `vencejo.what_if.WhatIf`.
#[derive(IntoPyObject)]
pub struct Followed {
    trigger: &'static str,
    at: Moment,
    decisions: Vec<Decided>,
    reaction: &'static str,
    flown: Option<Flown>,
    glide_range: Vec<(f64, f64)>,
}

/// What follows from triggers at moments of a plan.
#[pyfunction]
#[pyo3(signature = (plan, given, ground, *, triggers, moments))]
fn what_if(
    py: Python<'_>,
    plan: PlanTuple,
    given: Given,
    ground: Option<Bound<'_, PyAny>>,
    triggers: Vec<String>,
    moments: Vec<f64>,
) -> PyResult<Vec<Followed>> {
    let triggers = triggers_named(&triggers)?;
    ask(py, plan, given, ground.as_ref(), move |plan, conditions, _| {
        what_follows(plan, conditions, &triggers, &moments)
    })
}

/// # Errors
/// `InvalidRequest` for an unknown name.
pub fn triggers_named(names: &[String]) -> PyResult<Vec<Trigger>> {
    let named = |name: &String| {
        let known = Trigger::ALL.iter().copied().find(|trigger| trigger.as_str() == name);
        let all = || Trigger::ALL.iter().map(|trigger| trigger.as_str()).collect::<Vec<_>>().join(", ");
        known.ok_or_else(|| errors::raise("InvalidRequest", format!("{name:?} is none of {}", all())))
    };
    names.iter().map(named).collect()
}

/// What follows.
///
/// # Errors
/// [`NotRehearsed`].
pub fn what_follows(
    plan: &Plan,
    conditions: &Conditions<'_>,
    triggers: &[Trigger],
    moments: &[f64],
) -> Result<Vec<Followed>, NotRehearsed> {
    let home_amsl_m = home_amsl_m(plan, conditions)?;
    let followed = |found: &WhatIf| Followed {
        trigger: found.trigger.as_str(),
        at: Moment::new(&found.at, home_amsl_m),
        decisions: (found.decisions.iter())
            .map(|decision| Decided { time_s: decision.time_s, reaction: decision.reaction.as_str() })
            .collect(),
        reaction: found.reaction().as_str(),
        flown: found.flown.as_ref().map(|flown| Flown::new(flown, Vec::new(), home_amsl_m)),
        glide_range: (glide_range(plan, conditions, &found.at).unwrap_or_default().iter())
            .map(|point| (point.lat_deg(), point.lon_deg()))
            .collect(),
    };
    Ok(what_ifs(plan, conditions, triggers, moments)?.iter().map(followed).collect())
}

/// A learned plane, by the names of `vencejo.airframe.Learned`.
#[derive(IntoPyObject)]
pub struct LearnedPlane {
    airframe: AirframeFields,
    wind: LearnedWind,
    moments: usize,
    airspeed_error_m_s: f64,
}

/// By the names of `vencejo.landing.Wind`.
#[derive(IntoPyObject)]
struct LearnedWind {
    from_deg: f64,
    speed_m_s: f64,
}

impl From<Learned> for LearnedPlane {
    fn from(learned: Learned) -> Self {
        let airframe = learned.airframe.into();
        let Wind { from_deg, speed_m_s } = learned.wind;
        let (moments, airspeed_error_m_s) = (learned.moments, learned.airspeed_error_m_s);
        Self { airframe, wind: LearnedWind { from_deg, speed_m_s }, moments, airspeed_error_m_s }
    }
}

/// Learns an airframe from a recording; `None` if there is too little data.
#[pyfunction]
#[pyo3(signature = (path, *, parameters, system))]
fn learn_plane(
    py: Python<'_>,
    path: PathBuf,
    parameters: HashMap<String, f64>,
    system: Option<u8>,
) -> PyResult<Option<LearnedPlane>> {
    let name = path.clone();
    let learned = runtime::interruptible(py, move |is_wanted| {
        let file = WhileWanted(File::open(&name)?, is_wanted);
        let flight = recorded_flight(file, system.map(SystemId))?;
        Ok(flight.learned(&Aircraft::from_ardupilot(|name| parameters.get(name).copied())))
    })?;
    let learned =
        learned.map_err(|error: io::Error| errors::raise("FileFormatError", format!("{}: {error}", path.display())))?;
    Ok(learned.map(LearnedPlane::from))
}

impl Flown {
    /// A rehearsal with its findings; home's altitude is that of mean sea level, m.
    pub fn new(flown: &Rehearsal, found: Vec<Finding>, home_amsl_m: f64) -> Self {
        let moment = |sample: &Sample| Moment::new(sample, home_amsl_m);
        Self {
            airframe: flown.airframe.as_str(),
            findings: findings(found),
            track: flown.track.iter().map(moment).collect(),
            passages: (flown.passages.iter())
                .map(|passage| Passage {
                    item: passage.item + 1,
                    begins_s: passage.begins_s,
                    reached_s: passage.reached_s,
                    nearest_m: passage.nearest_m,
                })
                .collect(),
            ending: flown.ending.as_str(),
            touch_down: flown.touch_down.as_ref().map(moment),
            duration_s: flown.duration_s,
            distance_m: flown.distance_m,
            energy_wh: flown.energy_wh,
            battery: flown.battery.ok().map(|left| BatteryLeft {
                capacity_wh: left.capacity_wh,
                left_wh: left.left_wh,
                reserve: left.reserve,
                empty_s: left.empty_s,
                empty_item: left.empty_index.map(|index| index + 1),
            }),
            battery_unknown: flown.battery.err().map(BatteryLack::as_str),
        }
    }
}

impl Moment {
    fn new(sample: &Sample, home_amsl_m: f64) -> Self {
        Self {
            time_s: sample.time_s,
            lat_deg: sample.point.lat_deg(),
            lon_deg: sample.point.lon_deg(),
            alt_amsl_m: home_amsl_m + sample.height_m,
            alt_rel_home_m: sample.height_m,
            alt_asked_m: sample.height_asked_m,
            clearance_m: sample.clearance_m(),
            airspeed_m_s: sample.airspeed_m_s,
            groundspeed_m_s: sample.groundspeed_m_s,
            climb_m_s: sample.climb_m_s,
            course_deg: sample.course_deg,
            heading_deg: sample.heading_deg,
            bank_deg: sample.bank_deg,
            pitch_deg: sample.pitch_deg,
            throttle: sample.throttle,
            item: sample.index.map(|index| index + 1),
        }
    }
}
