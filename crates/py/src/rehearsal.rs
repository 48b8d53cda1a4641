//! Rehearsal for Python (see `vencejo.rehearsal`), by `vencejo-flight`.

use std::collections::HashMap;
use std::fs::File;
use std::path::PathBuf;

use pyo3::prelude::*;
use pyo3::types::PyDict;
use vencejo_flight::checks::{CheckContext, Finding, Inspection, fixes, rehearse_and_check};
use vencejo_flight::landing::Wind;
use vencejo_flight::plan::Plan;
use vencejo_flight::rehearsal::{
    Air, Aircraft, Airframe, BatteryLack, BatterySettings, Conditions, Doubts, Learned, Origin, Range, Rehearsal,
    Sample, Start, Trigger, glide_range, what_ifs,
};
use vencejo_proto::SystemId;
use vencejo_station::{Runs, recorded_flight};

use crate::errors;
use crate::ground;
use crate::plan::{FigureTuple, FindingTuple, PlanTuple, figures, findings, plan_from_tuple, plan_to_tuple};
use crate::runtime;

/// Adds what this module has.
pub fn register(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_function(wrap_pyfunction!(rehearse, module)?)?;
    module.add_function(wrap_pyfunction!(rehearse_many, module)?)?;
    module.add_function(wrap_pyfunction!(plan_fixes, module)?)?;
    module.add_function(wrap_pyfunction!(what_if, module)?)?;
    module.add_function(wrap_pyfunction!(learn_plane, module)?)
}

/// Time, latitude, longitude, heights above sea and above home, height asked for, height above ground; airspeed,
/// groundspeed, climb; course, heading, bank, pitch; throttle; item counted from 1.
type Moment = ((f64, f64, f64, f64, f64, f64, Option<f64>), (f64, f64, f64), (f64, f64, f64, f64), f64, Option<usize>);
/// Item counted from 1, when it begins and is reached, how near the plane comes.
type PassageTuple = (usize, f64, Option<f64>, Option<f64>);
/// Origin of the airframe, findings, track, items, ending, touch-down, duration, distance, energy, and the battery at
/// the end, or why it is not known.
pub type RehearsalTuple = (
    &'static str,
    Vec<FindingTuple>,
    Vec<Moment>,
    Vec<PassageTuple>,
    &'static str,
    Option<Moment>,
    f64,
    f64,
    Option<f64>,
    Option<BatteryTuple>,
    Option<&'static str>,
);
/// Energy of a full battery and what is left, Wh; part that should be left; when it is empty, and the item then,
/// counted from 1.
type BatteryTuple = (f64, f64, f64, Option<f64>, Option<usize>);

/// An airframe as `vencejo.rehearsal.Airframe` has it.
#[derive(FromPyObject)]
pub struct GivenAirframe {
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
    airframe: Option<GivenAirframe>,
    #[pyo3(item)]
    battery: Option<GivenBattery>,
}

impl Profile {
    /// The plane with them.
    ///
    /// # Errors
    /// `InvalidRequest` for a number out of its range.
    pub fn of(self, plane: Aircraft) -> PyResult<Aircraft> {
        let airframe = self.airframe.map(|given| Airframe {
            origin: Origin::Flight,
            cruise_m_s: given.cruise_m_s,
            drag_m_s2: given.drag_m_s2,
            induced: given.induced,
            thrust_full_m_s2: given.thrust_full_m_s2,
            thrust_static_m_s2: given.thrust_static_m_s2,
            ground_drag_m_s2: given.ground_drag_m_s2,
            throttle_cruise: given.throttle_cruise,
            attack_rad: given.attack_rad,
            level_pitch_rad: given.level_pitch_rad,
            pitot: given.pitot,
            skid: given.skid,
            power_cruise_w: given.power_cruise_w,
            is_simulated: given.is_simulated,
            power_exponent: given.power_exponent,
            voltage_v: given.voltage_v,
        });
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
                let problem = format!("{part}.{field} is {value}, should be {low} to {high}");
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

/// Whether the answer is still waited for.
type IsWanted<'a> = &'a (dyn Fn() -> bool + Sync);

/// Asks something of a plan and its conditions, with home's altitude above sea level and the clearance to keep, m.
///
/// # Errors
/// `InvalidRequest` without a home on Earth; what a signal handler of Python raises meanwhile.
fn ask<T: Send>(
    py: Python<'_>,
    plan: PlanTuple,
    given: Given,
    ground: Option<&Bound<'_, PyAny>>,
    question: impl FnOnce(&Plan, &Conditions<'_>, (f64, f64), IsWanted<'_>) -> Option<T> + Send,
) -> PyResult<T> {
    let plan = plan_from_tuple(plan)?;
    let Some(home) = plan.mission.home else {
        return Err(errors::raise("InvalidRequest", "a rehearsal begins at home: the plan has none"));
    };
    let map = ground::around(ground, &plan, None)?;
    let below = |point| map.height_m(point);
    let (start, clearance_m) = (Start::Ground { heading_deg: given.heading_deg }, given.clearance_m);
    let (plane, air) = given.plane_and_air()?;
    runtime::interruptible(py, |is_wanted| {
        let conditions = Conditions { start, ground: Some(&below), ..Conditions::new(&plane, air) };
        question(&plan, &conditions, (home.alt_amsl_m, clearance_m), is_wanted)
    })?
    .ok_or_else(|| errors::raise("InvalidRequest", "the plan's home is not a position on Earth"))
}

/// The finding, what the change does, its figures, it in English, and the plan with it.
type FixTuple = (FindingTuple, &'static str, FigureTuple, String, PlanTuple);

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
) -> PyResult<Vec<FixTuple>> {
    let plan = plan_from_tuple(plan)?;
    let map = ground::around(ground.as_ref(), &plan, None)?;
    let below = |point| map.height_m(point);
    Ok(py.detach(|| {
        let get = |name: &str| parameters.get(name).copied();
        let plane = Aircraft::from_ardupilot(get);
        let air = Air::of(Wind { from_deg: wind.0, speed_m_s: wind.1 }, get);
        let conditions = Some(Conditions { ground: Some(&below), ..Conditions::new(&plane, air) });
        let finds_landing = get("RTL_AUTOLAND").map(|value| value > 0.0);
        let context = CheckContext { on_ground, finds_landing, ..CheckContext::default() };
        let found = fixes(&plan, &Inspection { context, conditions, clearance_m });
        let told = found.into_iter().filter_map(|(finding, fix)| {
            let finding = findings(vec![finding]).pop()?;
            let with = figures(fix.kind.figures());
            Some((finding, fix.kind.as_str(), with, fix.message(), plan_to_tuple(&fix.applied(&plan))))
        });
        told.collect()
    }))
}

/// Flies a plan with a plane of these parameters.
#[pyfunction]
#[pyo3(signature = (plan, given, ground))]
fn rehearse(
    py: Python<'_>,
    plan: PlanTuple,
    given: Given,
    ground: Option<Bound<'_, PyAny>>,
) -> PyResult<RehearsalTuple> {
    ask(py, plan, given, ground.as_ref(), |plan, conditions, (home_amsl_m, clearance_m), _| {
        rehearse_and_check(plan, conditions, clearance_m).map(|(flown, found)| to_tuple(&flown, found, home_amsl_m))
    })
}

/// Least, median and most of nine in ten.
type RangeTuple = (f64, f64, f64);
/// The expected flight, flights, how many ended how, duration, energy, part of the battery left and how many leave less
/// than its reserve, distance of touch-downs, and of each moment of the corridor its time, how far across and how much
/// higher.
type SpreadTuple = (
    RehearsalTuple,
    usize,
    Vec<(&'static str, usize)>,
    RangeTuple,
    Option<RangeTuple>,
    (Option<RangeTuple>, Option<usize>),
    Option<RangeTuple>,
    Vec<(f64, RangeTuple, RangeTuple)>,
);

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
) -> PyResult<SpreadTuple> {
    let (wind_speed_m_s, wind_from_deg, gust_m_s, thrust, drag, power) = doubts;
    let doubts = Doubts { wind_speed_m_s, wind_from_deg, gust_m_s, thrust, drag, power };
    ask(py, plan, given, ground.as_ref(), |plan, conditions, (home_amsl_m, clearance_m), is_wanted| {
        let (expected, found) = rehearse_and_check(plan, conditions, clearance_m)?;
        let runs = Runs { count: runs, seed, spared: 0 };
        let spread = vencejo_station::rehearse_many(plan, conditions, &doubts, expected, &runs, is_wanted)?;
        let range = |range: Range| (range.low, range.median, range.high);
        Some((
            to_tuple(&spread.expected, found, home_amsl_m),
            spread.runs,
            spread.endings.into_iter().map(|(ending, count)| (ending.as_str(), count)).collect(),
            range(spread.duration_s),
            spread.energy_wh.map(range),
            (spread.battery_left.map(range), spread.below_reserve),
            spread.touch_down_m.map(range),
            spread.corridor.iter().map(|at| (at.time_s, range(at.across_m), range(at.height_m))).collect(),
        ))
    })
}

/// Trigger, moment, decisions (when, what), final reaction, the flight from there, and the ground within gliding range.
pub type WhatIfTuple =
    (&'static str, Moment, Vec<(f64, &'static str)>, &'static str, Option<RehearsalTuple>, Vec<(f64, f64)>);

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
) -> PyResult<Vec<WhatIfTuple>> {
    let triggers = triggers_named(&triggers)?;
    ask(py, plan, given, ground.as_ref(), |plan, conditions, _, _| {
        what_if_tuples(plan, conditions, &triggers, &moments)
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

/// What follows; `None` without a home.
pub fn what_if_tuples(
    plan: &Plan,
    conditions: &Conditions<'_>,
    triggers: &[Trigger],
    moments: &[f64],
) -> Option<Vec<WhatIfTuple>> {
    let home_amsl_m = conditions.home.or(plan.mission.home)?.alt_amsl_m;
    let found = what_ifs(plan, conditions, triggers, moments)?;
    let told = found.iter().map(|found| {
        let decisions = found.decisions.iter().map(|decision| (decision.time_s, decision.reaction.as_str()));
        let range = glide_range(plan, conditions, &found.at).unwrap_or_default();
        (
            found.trigger.as_str(),
            moment(&found.at, home_amsl_m),
            decisions.collect(),
            found.reaction().as_str(),
            found.flown.as_ref().map(|flown| to_tuple(flown, Vec::new(), home_amsl_m)),
            range.iter().map(|point| (point.lat_deg(), point.lon_deg())).collect(),
        )
    });
    Some(told.collect())
}

/// An airframe by the names of its fields, the direction and speed of the wind, moments, and what is left of the
/// airspeed.
pub type LearnedTuple<'py> = (Bound<'py, PyDict>, (f64, f64), usize, f64);

/// A learned airframe, for Python.
pub fn learned_tuple<'py>(py: Python<'py>, learned: &Learned) -> PyResult<LearnedTuple<'py>> {
    let frame = learned.airframe;
    let fields = PyDict::new(py);
    for (name, value) in [
        ("cruise_m_s", frame.cruise_m_s),
        ("drag_m_s2", frame.drag_m_s2),
        ("induced", frame.induced),
        ("thrust_full_m_s2", frame.thrust_full_m_s2),
        ("throttle_cruise", frame.throttle_cruise),
        ("attack_rad", frame.attack_rad),
        ("level_pitch_rad", frame.level_pitch_rad),
        ("pitot", frame.pitot),
        ("skid", frame.skid),
        ("power_exponent", frame.power_exponent),
    ] {
        fields.set_item(name, value)?;
    }
    fields.set_item("power_cruise_w", frame.power_cruise_w)?;
    fields.set_item("voltage_v", frame.voltage_v)?;
    fields.set_item("thrust_static_m_s2", frame.thrust_static_m_s2)?;
    fields.set_item("ground_drag_m_s2", frame.ground_drag_m_s2)?;
    fields.set_item("is_simulated", frame.is_simulated)?;
    Ok((fields, (learned.wind.from_deg, learned.wind.speed_m_s), learned.moments, learned.airspeed_error_m_s))
}

/// Learns an airframe from a recording; `None` if there is too little data.
#[pyfunction]
#[pyo3(signature = (path, *, parameters, system))]
fn learn_plane<'py>(
    py: Python<'py>,
    path: PathBuf,
    parameters: HashMap<String, f64>,
    system: Option<u8>,
) -> PyResult<Option<LearnedTuple<'py>>> {
    let learned = py.detach(|| {
        let flight = File::open(&path)
            .and_then(|file| recorded_flight(file, system.map(SystemId)))
            .map_err(|error| errors::raise("FileFormatError", format!("{}: {error}", path.display())))?;
        Ok::<_, PyErr>(flight.learned(&Aircraft::from_ardupilot(|name| parameters.get(name).copied())))
    })?;
    learned.map(|learned| learned_tuple(py, &learned)).transpose()
}

/// A rehearsal for Python.
pub fn to_tuple(flown: &Rehearsal, found: Vec<Finding>, home_amsl_m: f64) -> RehearsalTuple {
    let moment = |sample: &Sample| moment(sample, home_amsl_m);
    let passages =
        flown.passages.iter().map(|passage| (passage.item + 1, passage.begins_s, passage.reached_s, passage.nearest_m));
    (
        flown.airframe.as_str(),
        findings(found),
        flown.track.iter().map(moment).collect(),
        passages.collect(),
        flown.ending.as_str(),
        flown.touch_down.as_ref().map(moment),
        flown.duration_s,
        flown.distance_m,
        flown.energy_wh,
        flown.battery.ok().map(|left| {
            (left.capacity_wh, left.left_wh, left.reserve, left.empty_s, left.empty_index.map(|index| index + 1))
        }),
        flown.battery.err().map(BatteryLack::as_str),
    )
}

fn moment(sample: &Sample, home_amsl_m: f64) -> Moment {
    let (lat_deg, lon_deg) = (sample.point.lat_deg(), sample.point.lon_deg());
    (
        (
            sample.time_s,
            lat_deg,
            lon_deg,
            home_amsl_m + sample.height_m,
            sample.height_m,
            sample.height_asked_m,
            sample.clearance_m(),
        ),
        (sample.airspeed_m_s, sample.groundspeed_m_s, sample.climb_m_s),
        (sample.course_deg, sample.heading_deg, sample.bank_deg, sample.pitch_deg),
        sample.throttle,
        sample.index.map(|index| index + 1),
    )
}
