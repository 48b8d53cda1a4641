//! Assessment of plans while they are edited and before they are uploaded.

use vencejo_flight::alongside::{along, lowest};
use vencejo_flight::checks::{
    CLEARANCE_M, CheckContext, Finding, Inspection, check_plan, fixes, rehearse_and_check, with_flown,
};
use vencejo_flight::ending::mission_end;
use vencejo_flight::geodesy::{GeoPoint, direct};
use vencejo_flight::landing::Wind;
use vencejo_flight::plan::{self, Mission};
use vencejo_flight::profile::profile as height_profile;
use vencejo_flight::progress::{Circled, ProgressOptions, trip};
use vencejo_flight::rehearsal::{
    self, Air, Aircraft, Conditions, Learned, NotRehearsed, Range, Sample, Start, Trigger, glide_range, what_ifs,
};
use vencejo_flight::way::{Way, way};
use vencejo_station::{Runs, VehicleHandle, rehearse_many};

use crate::convert;
use crate::dto::{
    self, Assessment, BatteryLeft, Corridor, Decision, EndingCount, FindingFix, LatLon, LearnedPlane, Plan,
    PlaneProfile, Rehearsal, RehearsalRequest, RehearsedFlight, RehearsedPassage, RehearsedTrack, Spread,
    SpreadRequest, VehicleProfile, WhatIf, WhatIfRequest, WhatIfs,
};
use crate::followed;
use crate::problem::Problem;
use crate::state::App;
use crate::turns::{alone, in_turn};

/// Largest distance between the drawn and the rehearsed track, m.
const DRAWN_WITHIN_M: f64 = 0.7;
/// Most points of a drawn track: no answer is larger than a client takes at once.
const MOST_DRAWN: usize = 10_000;
/// Strongest wind accepted for a rehearsal, m/s: beyond the capability of any plane that Vencejo is for.
const MOST_WIND_M_S: f64 = 60.0;
/// Default number of flights of one plan, and the maximum.
const USUAL_RUNS: usize = 200;
const MOST_RUNS: usize = 1_000;
/// Largest clearance that may be requested, m.
const MOST_CLEARANCE_M: f64 = 1_000.0;

/// Assesses a plan for a vehicle, or for a default ArduPlane without one.
///
/// # Errors
/// For an invalid plan, and for an invalid wind.
pub(crate) fn assess(
    app: &App,
    vehicle: Option<u16>,
    plan: &Plan,
    rehearse_in: Option<Wind>,
    clearance_m: Option<f64>,
    profile: &PlaneProfile,
) -> Result<Assessment, Problem> {
    let plan = convert::core_plan(plan)?;
    let any = CheckContext::default();
    let vehicle = app.vehicle(vehicle);
    let findings = vehicle.as_ref().map_or_else(|| check_plan(&plan, &any), |vehicle| vehicle.check_plan(&plan));
    let known = vehicle.as_ref().and_then(|vehicle| vehicle.trip(&plan.mission));
    let trip = known.unwrap_or_else(|| trip(&plan.mission, Some(any.airspeed_m_s), &ProgressOptions::default()));
    let rehearsal = match rehearse_in {
        Some(wind) => rehearsed(app, vehicle.as_ref(), &plan, wind, clearance_m, profile)?.ok(),
        None => None,
    };
    let findings = match &rehearsal {
        Some(rehearsal) => with_flown(findings, rehearsal.findings.iter().cloned()),
        None => findings,
    };
    Ok(Assessment { findings, trip, rehearsal })
}

/// Route of a plan's mission for a vehicle, or for a default ArduPlane without one, with its altitudes above the
/// terrain loaded so far.
///
/// # Errors
/// For an invalid plan, and for an invalid clearance.
pub(crate) fn laid_out(
    app: &App,
    vehicle: Option<u16>,
    plan: &Plan,
    clearance_m: Option<f64>,
) -> Result<dto::Way, Problem> {
    let plan = convert::core_plan(plan)?;
    let clearance_m = clearance(clearance_m)?;
    let mission = &plan.mission;
    let way = way_of(app.vehicle(vehicle).as_ref(), mission);
    let (map, is_ground_pending) = app.ground_around(&plan, None);
    let profile = height_profile(mission, &way, &|point| map.height_m(point), clearance_m);
    let Way { stops, jumps } = way;
    Ok(dto::Way { stops, jumps, end: mission_end(mission), profile, is_ground_pending })
}

/// Route of a mission for a vehicle, or for a default ArduPlane without one.
pub(crate) fn way_of(vehicle: Option<&VehicleHandle>, mission: &Mission) -> Way {
    let known = vehicle.and_then(|vehicle| vehicle.way(mission));
    known.unwrap_or_else(|| way(mission, CheckContext::default().airspeed_m_s, &ProgressOptions::default()))
}

/// Rehearses a plan over the terrain of the maps, which is loaded first.
///
/// # Errors
/// For an invalid plan, wind or clearance, and when no home is known.
pub(crate) async fn rehearsal(app: &App, asked: &RehearsalRequest) -> Result<Rehearsal, Problem> {
    let plan = convert::core_plan(&asked.plan)?;
    let vehicle = app.vehicle(asked.vehicle);
    app.wait_for_ground(&plan, vehicle.as_ref().and_then(VehicleHandle::home)).await;
    let wind = asked.wind.unwrap_or_default();
    let (app, clearance_m, profile) = (app.clone(), asked.clearance_m, asked.profile.clone());
    in_turn(move || rehearsed(&app, vehicle.as_ref(), &plan, wind, clearance_m, &profile)).await?.map_err(not_rehearsed)
}

/// Finds changes that resolve findings of a plan, over the terrain of the maps, which is loaded first.
///
/// # Errors
/// For an invalid plan, wind or clearance.
pub(crate) async fn fixed(app: &App, asked: &RehearsalRequest) -> Result<Vec<FindingFix>, Problem> {
    let plan = convert::core_plan(&asked.plan)?;
    let vehicle = app.vehicle(asked.vehicle);
    let home = vehicle.as_ref().and_then(VehicleHandle::home);
    app.wait_for_ground(&plan, home).await;
    let wind = asked.wind.unwrap_or_default();
    let (plane, air) = flies_in(vehicle.as_ref(), wind, &asked.profile)?;
    let clearance_m = clearance(asked.clearance_m)?;
    let (map, _) = app.ground_around(&plan, home);
    in_turn(move || {
        let ground = |point| map.height_m(point);
        let conditions = Conditions { home, ground: Some(&ground), ..Conditions::new(&plane, air) };
        let context = vehicle.as_ref().map_or_else(CheckContext::default, VehicleHandle::check_context);
        let inspection = Inspection { context, conditions: Some(conditions), clearance_m };
        Ok(fixes(&plan, &inspection).into_iter().map(|(finding, fix)| convert::finding_fix(finding, fix)).collect())
    })
    .await
}

/// # Errors
/// For an invalid clearance.
fn clearance(clearance_m: Option<f64>) -> Result<f64, Problem> {
    let clearance_m = clearance_m.unwrap_or(CLEARANCE_M);
    if (0.0..=MOST_CLEARANCE_M).contains(&clearance_m) {
        return Ok(clearance_m);
    }
    Err(Problem::out_of_range("clearance_m", clearance_m, 0.0, MOST_CLEARANCE_M))
}

fn rehearsed(
    app: &App,
    vehicle: Option<&VehicleHandle>,
    plan: &plan::Plan,
    wind: Wind,
    clearance_m: Option<f64>,
    profile: &PlaneProfile,
) -> Result<Result<Rehearsal, NotRehearsed>, Problem> {
    let flies_in = flies_in(vehicle, wind, profile)?;
    let clearance_m = clearance(clearance_m)?;
    let (map, is_pending) = app.ground_around(plan, vehicle.and_then(VehicleHandle::home));
    let ground = |point| map.height_m(point);
    let flown = match vehicle {
        Some(vehicle) => vehicle.rehearse(plan, &flies_in, Some(&ground), clearance_m),
        None => {
            let conditions = Conditions { ground: Some(&ground), ..Conditions::new(&flies_in.0, flies_in.1) };
            rehearse_and_check(plan, &conditions, clearance_m)
        }
    };
    let knows_parameters = vehicle.is_some_and(VehicleHandle::knows_how_it_flies);
    let (flown, findings) = match flown {
        Ok(flown) => flown,
        Err(why) => return Ok(Err(why)),
    };
    let mission = &plan.mission;
    let drawn_profile = height_profile(mission, &way_of(vehicle, mission), &|_| None, clearance_m);
    let mut moments = flown.thinned(DRAWN_WITHIN_M);
    let mut along_m = along(&moments, &flown.passages, &drawn_profile);
    let lowest = lowest(mission, &moments, &along_m, clearance_m);
    // Of a flight of hours less is drawn than its least height needs.
    if moments.len() > MOST_DRAWN {
        moments = flown.thinned_to(DRAWN_WITHIN_M, MOST_DRAWN);
        along_m = along(&moments, &flown.passages, &drawn_profile);
    }
    Ok(Ok(Rehearsal {
        lowest,
        along_m: along_m.into_iter().map(|along_m| rounded(along_m, 1)).collect(),
        is_ground_pending: is_pending,
        ..described(&flown, &moments, findings, wind, knows_parameters)
    }))
}

fn described(
    flown: &rehearsal::Rehearsal,
    moments: &[&Sample],
    findings: Vec<Finding>,
    wind: Wind,
    knows_parameters: bool,
) -> Rehearsal {
    let passages = flown.passages.iter().map(|passage| RehearsedPassage {
        item: number(passage.item),
        begins_s: rounded(passage.begins_s, 1),
        reached_s: passage.reached_s.map(|time_s| rounded(time_s, 1)),
        nearest_m: passage.nearest_m.map(|distance_m| rounded(distance_m, 1)),
    });
    Rehearsal {
        airframe: flown.airframe,
        knows_parameters,
        wind,
        findings,
        track: drawn(moments),
        along_m: Vec::new(),
        lowest: None,
        passages: passages.collect(),
        ending: flown.ending,
        touch_down: flown.touch_down.map(|sample| place(sample.point)),
        duration_s: rounded(flown.duration_s, 1),
        distance_m: rounded(flown.distance_m, 0),
        energy_wh: flown.energy_wh,
        battery: flown.battery.ok().map(battery_left),
        battery_unknown: flown.battery.err(),
        is_ground_pending: false,
    }
}

fn drawn(moments: &[&Sample]) -> RehearsedTrack {
    let mut track = RehearsedTrack::default();
    for sample in moments {
        let Sample {
            time_s,
            point,
            height_m,
            ground_m,
            airspeed_m_s,
            groundspeed_m_s,
            bank_deg,
            heading_deg,
            index,
            ..
        } = **sample;
        track.time_s.push(rounded(time_s, 1));
        track.lat_deg.push(rounded(point.lat_deg(), 7));
        track.lon_deg.push(rounded(point.lon_deg(), 7));
        track.height_m.push(rounded(height_m, 1));
        track.ground_m.push(ground_m.map(|ground_m| rounded(ground_m, 1)));
        track.airspeed_m_s.push(rounded(airspeed_m_s, 1));
        track.groundspeed_m_s.push(rounded(groundspeed_m_s, 1));
        track.bank_deg.push(rounded(bank_deg, 0));
        track.heading_deg.push(rounded(heading_deg, 0));
        track.item.push(index.map(number));
    }
    track
}

/// Simulates contingencies at a time in a plan, or from now on.
///
/// # Errors
/// For an invalid plan, wind or time, when no home is known, and for the present flight of a vehicle that does not fly
/// its mission.
pub(crate) async fn what_if(app: App, asked: WhatIfRequest) -> Result<WhatIfs, Problem> {
    let vehicle = app.vehicle(asked.vehicle);
    let plan = match &asked.plan {
        Some(plan) => Some(convert::core_plan(plan)?),
        None => vehicle.as_ref().and_then(VehicleHandle::from_now).map(|(plan, _)| plan),
    };
    if let Some(plan) = plan {
        app.wait_for_ground(&plan, vehicle.as_ref().and_then(VehicleHandle::home)).await;
    }
    in_turn(move || what_if_over_known(&app, &asked)).await
}

/// The same over the terrain loaded so far.
fn what_if_over_known(app: &App, asked: &WhatIfRequest) -> Result<WhatIfs, Problem> {
    let wind = asked.wind.unwrap_or_default();
    let vehicle = app.vehicle(asked.vehicle);
    let (plane, air) = flies_in(vehicle.as_ref(), wind, &asked.profile)?;
    let home = vehicle.as_ref().and_then(VehicleHandle::home);
    let conditions = Conditions { home, ..Conditions::new(&plane, air) };
    let now = || vehicle.as_ref().and_then(VehicleHandle::from_now);
    let (plan, conditions, at_s) = match (&asked.plan, asked.at_s) {
        (Some(plan), Some(at_s)) if at_s.is_finite() && at_s >= 0.0 => (convert::core_plan(plan)?, conditions, at_s),
        (None, None) => {
            let detail = "the vehicle's present flight is not known: give a plan, and at_s, a time in it";
            let (plan, start) = now().ok_or_else(|| Problem::invalid(detail))?;
            (plan, Conditions { start, ..conditions }, 0.0)
        }
        _ => {
            let detail = "a plan needs at_s, a time in it in seconds, 0 or more; omit both for the present flight";
            return Err(Problem::invalid(detail));
        }
    };
    let (map, _) = app.ground_around(&plan, home);
    let ground = |point| map.height_m(point);
    let conditions = Conditions { ground: Some(&ground), ..conditions };
    // Each trigger once, however often the request names it.
    let is_asked = |trigger: &Trigger| asked.triggers.as_ref().is_none_or(|asked| asked.contains(trigger));
    let triggers: Vec<Trigger> = Trigger::ALL.iter().copied().filter(is_asked).collect();
    let found = what_ifs(&plan, &conditions, &triggers, &[at_s]).map_err(not_rehearsed)?;
    let at = found.first().map(|first| first.at);
    let ahead = match asked.at_s {
        None if matches!(conditions.start, Start::Air { doing, .. } if doing.is_open()) => None,
        None => rehearsal::rehearse(&plan, &conditions).ok().as_ref().map(part),
        Some(_) => None,
    };
    let flying = vehicle.as_ref().filter(|_| asked.at_s.is_none());
    let beside = flying.zip(ahead.as_ref()).zip(asked.begun.as_ref());
    let outlook = beside.map(|((vehicle, ahead), begun)| followed::outlook(vehicle, ahead, begun)).transpose()?;
    let is_circle_known = !matches!(conditions.start, Start::Air { circled: Circled::Unknown, .. });
    let range = at.and_then(|at| glide_range(&plan, &conditions, &at).ok()).unwrap_or_default();
    Ok(WhatIfs {
        at_s: at.map_or(at_s, |at| rounded(at.time_s, 1)),
        at: at.map(|at| place(at.point)),
        height_m: at.map_or(0.0, |at| rounded(at.height_m, 1)),
        ahead,
        is_circle_known,
        now: flying.filter(|_| is_circle_known).map(followed::now),
        outlook,
        what_ifs: found.iter().map(described_what_if).collect(),
        glide_range: range.into_iter().map(place).collect(),
    })
}

fn described_what_if(found: &rehearsal::WhatIf) -> WhatIf {
    WhatIf {
        trigger: found.trigger,
        decisions: found
            .decisions
            .iter()
            .map(|decision| Decision { time_s: rounded(decision.time_s, 1), reaction: decision.reaction })
            .collect(),
        reaction: found.reaction(),
        flown: found.flown.as_ref().map(part),
    }
}

fn part(flown: &rehearsal::Rehearsal) -> RehearsedFlight {
    RehearsedFlight {
        track: drawn(&flown.thinned_to(DRAWN_WITHIN_M, MOST_DRAWN)),
        ending: flown.ending,
        touch_down: flown.touch_down.map(|sample| place(sample.point)),
        ends_s: rounded(flown.duration_s, 1),
        distance_m: rounded(flown.distance_m, 0),
        energy_wh: flown.energy_wh,
        battery: flown.battery.ok().map(battery_left),
    }
}

fn battery_left(left: rehearsal::BatteryLeft) -> BatteryLeft {
    BatteryLeft {
        capacity_wh: rounded(left.capacity_wh, 1),
        left_pct: rounded(100.0 * left.left(), 1),
        reserve_pct: rounded(100.0 * left.reserve, 1),
        empty_s: left.empty_s,
    }
}

/// The plane to rehearse with, the vehicle's or a default ArduPlane, with the request's replacements; and the wind.
///
/// # Errors
/// For an invalid wind, airframe or battery.
pub(crate) fn flies_in(
    vehicle: Option<&VehicleHandle>,
    wind: Wind,
    profile: &PlaneProfile,
) -> Result<(Aircraft, Air), Problem> {
    if !(-360.0..=360.0).contains(&wind.from_deg) || !(0.0..=MOST_WIND_M_S).contains(&wind.speed_m_s) {
        let most = MOST_WIND_M_S;
        let detail =
            format!("a wind must have a direction between -360 and 360 degrees, and a speed between 0 and {most} m/s");
        return Err(Problem::invalid(detail));
    }
    let faults = [
        ("profile.airframe", profile.airframe.and_then(|airframe| airframe.fault())),
        ("profile.battery", profile.battery.and_then(|battery| battery.fault())),
    ];
    for (part, fault) in faults {
        if let Some((field, value, (low, high))) = fault {
            return Err(Problem::out_of_range(&format!("{part}.{field}"), value, low, high));
        }
    }
    let any = || (Aircraft::default(), Air::from(wind));
    let (plane, air) = vehicle.map_or_else(any, |vehicle| vehicle.flies_in(wind));
    Ok((plane.with(profile.airframe, profile.battery.as_ref()), air))
}

/// Flies a plan many times over the terrain of the maps. Stops as soon as `is_wanted` returns false.
///
/// # Errors
/// As for [`rehearsal()`], and for a number of flights out of range.
pub(crate) async fn spread(
    app: &App,
    asked: SpreadRequest,
    is_wanted: impl Fn() -> bool + Send + Sync + 'static,
) -> Result<Spread, Problem> {
    let count = asked.runs.unwrap_or(USUAL_RUNS);
    if !(1..=MOST_RUNS).contains(&count) {
        return Err(Problem::out_of_range("runs", count, 1, MOST_RUNS));
    }
    if let Some((field, value, (low, high))) = asked.doubts.fault() {
        return Err(Problem::out_of_range(&format!("doubts.{field}"), value, low, high));
    }
    let plan = convert::core_plan(&asked.plan)?;
    let vehicle = app.vehicle(asked.vehicle);
    let home = vehicle.as_ref().and_then(VehicleHandle::home);
    let wind = asked.wind.unwrap_or_default();
    let (plane, air) = flies_in(vehicle.as_ref(), wind, &asked.profile)?;
    app.wait_for_ground(&plan, home).await;
    let (map, _) = app.ground_around(&plan, home);
    alone(move || {
        let ground = |point| map.height_m(point);
        let conditions =
            Conditions { home, ground: Some(&ground), is_wanted: &is_wanted, ..Conditions::new(&plane, air) };
        let expected = rehearsal::rehearse(&plan, &conditions).map_err(not_rehearsed)?;
        // One processor is left to clients that follow a flight.
        let runs = Runs { count, seed: asked.seed, spared: 1 };
        let spread = rehearse_many(&plan, &conditions, &asked.doubts, expected, &runs);
        spread.as_ref().map(described_spread).map_err(|why| not_rehearsed(*why))
    })
    .await
}

fn described_spread(spread: &rehearsal::Spread) -> Spread {
    let range = |range: Range, factor: f64| Range {
        low: rounded(range.low * factor, 1),
        median: rounded(range.median * factor, 1),
        high: rounded(range.high * factor, 1),
    };
    let mut corridor = Corridor::default();
    let mut track = spread.expected.track.iter();
    for breadth in &spread.corridor {
        let Some(sample) = track.find(|sample| sample.time_s >= breadth.time_s - 0.05) else { break };
        let aside = |across_m: f64| place(direct(sample.point, sample.course_deg + 90.0, across_m));
        corridor.time_s.push(rounded(breadth.time_s, 1));
        corridor.left.push(aside(breadth.across_m.low));
        corridor.right.push(aside(breadth.across_m.high));
        corridor.low_m.push(rounded(sample.height_m + breadth.height_m.low, 1));
        corridor.high_m.push(rounded(sample.height_m + breadth.height_m.high, 1));
    }
    Spread {
        runs: spread.runs,
        endings: spread.endings.iter().map(|&(ending, count)| EndingCount { ending, count }).collect(),
        duration_s: range(spread.duration_s, 1.0),
        energy_wh: spread.energy_wh.map(|energy_wh| range(energy_wh, 1.0)),
        battery_left_pct: spread.battery_left.map(|left| range(left, 100.0)),
        below_reserve: spread.below_reserve,
        touch_down_m: spread.touch_down_m.map(|touch_down_m| range(touch_down_m, 1.0)),
        corridor,
    }
}

/// Converts a learned model.
pub(crate) fn learned_plane(learned: &Learned) -> LearnedPlane {
    LearnedPlane {
        airframe: learned.airframe,
        wind: Wind { from_deg: rounded(learned.wind.from_deg, 1), speed_m_s: rounded(learned.wind.speed_m_s, 2) },
        moments: learned.moments,
        airspeed_error_m_s: rounded(learned.airspeed_error_m_s, 3),
    }
}

/// Data with which a vehicle's plans are rehearsed.
pub(crate) fn vehicle_profile(vehicle: &VehicleHandle) -> VehicleProfile {
    let (plane, _) = vehicle.flies_in(Wind::default());
    VehicleProfile {
        airframe: plane.airframe,
        knows_parameters: vehicle.knows_how_it_flies(),
        capacity_mah: plane.battery.capacity_mah,
        voltage_v: plane.battery.voltage_v.or(plane.airframe.voltage_v),
        charge_pct: 100.0 * plane.battery.charge,
        reserve_pct: 100.0 * plane.battery.reserve,
        learned: vehicle.learned().as_ref().map(learned_plane),
    }
}

fn place(point: GeoPoint) -> LatLon {
    LatLon { lat_deg: rounded(point.lat_deg(), 7), lon_deg: rounded(point.lon_deg(), 7) }
}

pub(crate) fn not_rehearsed(why: NotRehearsed) -> Problem {
    Problem::invalid(why.to_string())
}

/// Number of an item, counted from 1.
fn number(index: usize) -> u16 {
    u16::try_from(index + 1).unwrap_or(u16::MAX)
}

/// Rounds to fewer digits: tracks of thousands of points are sent while a point is dragged.
fn rounded(value: f64, digits: i32) -> f64 {
    let factor = 10_f64.powi(digits);
    (value * factor).round() / factor
}
