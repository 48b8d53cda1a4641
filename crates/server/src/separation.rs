//! Rehearses planned flights and checks their separation.

use vencejo_flight::checks::{CLEARANCE_M, rehearse_and_check};
use vencejo_flight::landing::Wind;
use vencejo_flight::plan::Plan;
use vencejo_flight::rehearsal::{Conditions, NotRehearsed, Rehearsal};
use vencejo_flight::separation::{self as core, Limits, Place, track_of};
use vencejo_station::VehicleHandle;

use crate::assess::{flies_in, not_rehearsed};
use crate::convert;
use crate::dto::PlaneProfile;
use crate::dto::separation::{
    AssumedFlight, Conflict, ConflictPlace, PlannedFlight, Separation, SeparationLimits, SeparationRequest,
};
use crate::problem::Problem;
use crate::state::App;
use crate::turns::in_turn;

/// Largest number of flights in a check: each is rehearsed, and each pair compared.
const MOST_FLIGHTS: usize = 32;
/// Largest distance between the compared and the rehearsed track, m.
const TRACK_WITHIN_M: f64 = 1.0;
/// Latest start time, s.
const LATEST_S: f64 = 86_400.0;

/// # Errors
/// For fewer than two flights or too many, invalid limits, start times and plans, an unknown plan on board, and when no
/// home is known.
pub(crate) async fn separated(app: &App, asked: SeparationRequest) -> Result<Separation, Problem> {
    let count = asked.flights.len();
    if !(2..=MOST_FLIGHTS).contains(&count) {
        return Err(Problem::invalid_value("flights", count, &format!("2 to {MOST_FLIGHTS} flights")));
    }
    let usual = Limits::default();
    let limits = Limits {
        horizontal_m: asked.horizontal_m.unwrap_or(usual.horizontal_m),
        vertical_m: asked.vertical_m.unwrap_or(usual.vertical_m),
        window_s: asked.window_s.unwrap_or(usual.window_s),
    };
    if let Some((field, value, least, most)) = limits.fault() {
        return Err(Problem::out_of_range(field, value, least, most));
    }
    let wind = asked.wind.unwrap_or_default();
    let flights = asked.flights.into_iter().enumerate().map(|(index, flight)| planned(app, index + 1, flight));
    let flights = flights.collect::<Result<Vec<_>, _>>()?;
    in_turn(move || {
        let mut assumed = Vec::new();
        let mut tracks = Vec::new();
        for Planned { vehicle, plan, starts_s } in &flights {
            let (flown, home_amsl_m) = flown(vehicle.as_ref(), plan, wind)?;
            assumed.push(AssumedFlight {
                vehicle: vehicle.as_ref().map(|vehicle| vehicle.id().number()),
                starts_s: *starts_s,
                ends_s: starts_s + flown.duration_s,
                ending: flown.ending,
            });
            let thinned: Vec<_> = flown.thinned(TRACK_WITHIN_M).into_iter().copied().collect();
            tracks.push(track_of(&thinned, *starts_s, home_amsl_m));
        }
        let conflicts = core::conflicts(&tracks, &limits, &|| true).iter().map(conflict).collect();
        let Limits { horizontal_m, vertical_m, window_s } = limits;
        let limits = SeparationLimits { horizontal_m, vertical_m, window_s };
        Ok(Separation { flights: assumed, wind, limits, conflicts })
    })
    .await
}

struct Planned {
    vehicle: Option<VehicleHandle>,
    plan: Plan,
    starts_s: f64,
}

fn planned(app: &App, number: usize, flight: PlannedFlight) -> Result<Planned, Problem> {
    let starts_s = flight.starts_s.unwrap_or(0.0);
    if !(0.0..=LATEST_S).contains(&starts_s) {
        return Err(Problem::out_of_range("starts_s", starts_s, 0.0, LATEST_S));
    }
    let vehicle = app.vehicle(flight.vehicle);
    let plan = match flight.plan {
        Some(plan) => convert::core_plan(&plan)?,
        None => vehicle.as_ref().and_then(VehicleHandle::known_plan).ok_or_else(|| {
            Problem::invalid(format!("flight {number} has no plan, and the mission on board is unknown"))
                .remedy("give its plan, or read the vehicle's mission first")
        })?,
    };
    Ok(Planned { vehicle, plan, starts_s })
}

fn flown(vehicle: Option<&VehicleHandle>, plan: &Plan, wind: Wind) -> Result<(Rehearsal, f64), Problem> {
    let flies_in = flies_in(vehicle, wind, &PlaneProfile::default())?;
    let home = vehicle.and_then(VehicleHandle::home).or(plan.mission.home);
    let flown = match vehicle {
        Some(vehicle) => vehicle.rehearse(plan, &flies_in, None, CLEARANCE_M),
        None => rehearse_and_check(plan, &Conditions::new(&flies_in.0, flies_in.1), CLEARANCE_M),
    };
    let (flown, _) = flown.map_err(not_rehearsed)?;
    Ok((flown, home.ok_or_else(|| not_rehearsed(NotRehearsed::NoHome))?.alt_amsl_m))
}

fn conflict(found: &core::Conflict) -> Conflict {
    let place = |place: &Place| ConflictPlace {
        time_s: place.time_s,
        lat_deg: place.point.lat_deg(),
        lon_deg: place.point.lon_deg(),
        alt_amsl_m: place.alt_amsl_m,
    };
    let [first, second] = found.tracks.map(|index| index + 1);
    Conflict {
        flights: [first, second],
        begins_s: found.begins_s,
        ends_s: found.ends_s,
        nearest: [place(&found.nearest[0]), place(&found.nearest[1])],
        horizontal_m: found.horizontal_m,
        vertical_m: found.vertical_m,
        message: format!(
            "flights {first} and {second} come within {:.0} m over ground and {:.0} m in height of each other at {:.0} s",
            found.horizontal_m, found.vertical_m, found.nearest[0].time_s,
        ),
    }
}
