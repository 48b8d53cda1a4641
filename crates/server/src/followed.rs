//! Comparison of a flight that is being followed with its forecast.

use vencejo_flight::geodesy::GeoPoint;
use vencejo_flight::progress::Circled;
use vencejo_flight::rehearsal::{Ending, Expected, battery_left_pct, expected_at, expected_before_leaving, low_m};
use vencejo_station::VehicleHandle;

use crate::dto::{Beginning, ExpectedTrack, FlightNow, Outlook, RehearsedFlight};
use crate::problem::Problem;

/// Present time and charge of a vehicle, for later comparison.
pub(crate) fn now(vehicle: &VehicleHandle) -> FlightNow {
    let (telemetry, _) = vehicle.telemetry();
    FlightNow {
        boot_s: telemetry.system_time.map(|time| f64::from(time.value.boot_ms) / 1000.0),
        battery_pct: telemetry.batteries[0].and_then(|battery| battery.value.remaining_pct),
    }
}

/// Outlook of the vehicle's flight, whose remainder is `ahead`.
///
/// # Errors
/// For a track whose lists differ in length, and for invalid positions.
pub(crate) fn outlook(vehicle: &VehicleHandle, ahead: &RehearsedFlight, begun: &Beginning) -> Result<Outlook, Problem> {
    let track = expected(&begun.track)?;
    let (telemetry, _) = vehicle.telemetry();
    let position = telemetry.position.map(|position| position.value);
    let at = position.and_then(|at| GeoPoint::new(at.lat_deg?, at.lon_deg?).ok());
    let progress = vehicle.progress().unwrap_or_default();
    let item = progress.current.and_then(|seq| vehicle.item_of_seq(seq));
    let now = now(vehicle);
    let since_s = now.boot_s.zip(begun.now.boot_s).map(|(now_s, begun_s)| now_s - begun_s);
    // Of an endlessly repeated mission, only one round was rehearsed; for later rounds there is no forecast.
    let is_beyond = ahead.ending == Ending::Endless
        && since_s.zip(track.last()).is_some_and(|(since_s, last)| since_s > last.time_s);
    let expected = match progress.circled {
        _ if is_beyond => None,
        Circled::Nothing => at.and_then(|at| expected_at(&track, at, item.map(index), since_s)),
        Circled::Flown { .. } => item
            .zip(since_s)
            .and_then(|(item, since_s)| expected_before_leaving(&track, index(item), leaves_s(ahead, item)?, since_s)),
        Circled::Unknown => None,
    };
    let height_m = position.and_then(|at| at.alt_rel_home_m);
    let climb_m_s = position.and_then(|at| at.velocity_down_m_s).map(|down_m_s| -down_m_s);
    let battery_pct = || battery_left_pct(begun.now.battery_pct?, now.battery_pct?, since_s?, ahead.ends_s);
    Ok(Outlook {
        late_s: expected.zip(since_s).map(|(expected, since_s)| since_s - expected.time_s),
        low_m: expected.zip(height_m).and_then(|(expected, m)| low_m(&track, &expected, m, climb_m_s)),
        battery_pct: battery_pct(),
    })
}

/// Time until a flight at an item leaves it, seconds from now; `None` where it ends there.
fn leaves_s(ahead: &RehearsedFlight, item: u16) -> Option<f64> {
    let mut moments = ahead.track.time_s.iter().zip(&ahead.track.item);
    moments.find(|(_, flown)| **flown != Some(item)).map(|(time_s, _)| *time_s)
}

fn expected(track: &ExpectedTrack) -> Result<Vec<Expected>, Problem> {
    let count = track.time_s.len();
    let lengths = [track.lat_deg.len(), track.lon_deg.len(), track.height_m.len(), track.item.len()];
    if lengths.iter().any(|length| *length != count) {
        let detail = "the lists of begun.track differ in length: send them as they were in the answer at the beginning";
        return Err(Problem::invalid(detail));
    }
    (0..count)
        .map(|at| {
            Ok(Expected {
                time_s: track.time_s[at],
                point: GeoPoint::new(track.lat_deg[at], track.lon_deg[at])?,
                height_m: track.height_m[at],
                index: track.item[at].map(index),
            })
        })
        .collect()
}

/// Index of an item, counted from 0.
fn index(item: u16) -> usize {
    usize::from(item.saturating_sub(1))
}
