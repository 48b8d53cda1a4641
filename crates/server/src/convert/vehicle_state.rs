//! Vehicles: their summary and their state.

use vencejo_flight::plan as core;
use vencejo_station::{FarHeld, Station, VehicleHandle};
use vencejo_vehicle as vehicle;
use vencejo_vehicle::modes::ModeFamily;
use vencejo_vehicle::telemetry::{TelemetryGroups, Text};

use super::link::vehicle_link;
use super::plan::plan_state;
use super::replay::replay;
use super::units::seconds;
use crate::dto;

pub(crate) fn vehicle_summary(vehicle: &VehicleHandle) -> dto::VehicleSummary {
    let (telemetry, now) = vehicle.telemetry();
    let heartbeat = telemetry.heartbeat;
    let link = vehicle_link(vehicle);
    dto::VehicleSummary {
        system_id: vehicle.id().number(),
        mav_type: heartbeat.map(|heartbeat| heartbeat.value.mav_type),
        autopilot: heartbeat.map(|heartbeat| heartbeat.value.autopilot),
        mode: heartbeat.map(|heartbeat| heartbeat.value.mode.to_string()),
        is_armed: heartbeat.map(|heartbeat| heartbeat.value.is_armed),
        age_s: link
            .as_ref()
            .and_then(|link| link.age_s)
            .or_else(|| heartbeat.map(|heartbeat| heartbeat.age(now).as_secs_f64())),
        remote_name: vehicle.remote_name(),
        control: vehicle.held_far().map(vehicle_control),
        is_revoked: vehicle.is_revoked(),
        link: link.as_ref().map(|link| link.id),
        loss_pct: link.as_ref().and_then(|link| link.loss_pct),
        round_trip_ms: link.as_ref().and_then(|link| link.round_trip_ms),
        is_reached: vehicle.is_reached(),
        rival: vehicle.rival(),
        silence: vehicle.silence().map(|silence| silence.links),
        is_recorded: vehicle.is_recorded(),
        replay: vehicle.replay().as_ref().map(replay),
        lacks_terrain: vehicle.lacks_terrain() && !vehicle.is_recorded(),
        flight_parameters: flight_parameters(vehicle.flight_parameters()),
    }
}

pub(crate) fn vehicle_control(held: FarHeld) -> dto::VehicleControl {
    let FarHeld { holder, is_ours: is_held_here, requested_by, is_request_ours: is_requested_here } = held;
    dto::VehicleControl { holder, is_held_here, requested_by, is_requested_here }
}

fn flight_parameters(known: vehicle::FlightParameters) -> dto::FlightParameters {
    let vehicle::FlightParameters { loiter_radius_m, airspeed_m_s, finds_landing, .. } = known;
    // The API gives the absolute radius; `POST /plan/way` returns the direction of circles.
    dto::FlightParameters { loiter_radius_m: loiter_radius_m.map(f64::abs), airspeed_m_s, finds_landing }
}

pub(crate) fn vehicle_summaries(station: &Station) -> Vec<dto::VehicleSummary> {
    station.shown_vehicles().iter().map(vehicle_summary).collect()
}

pub(crate) fn progress(vehicle: &VehicleHandle) -> dto::MissionProgress {
    let progress = vehicle.progress().unwrap_or_default();
    let conduct = vehicle.conduct();
    dto::MissionProgress {
        follows_mission: conduct.follows_mission,
        is_landing: conduct.is_landing,
        turn_rate_deg_s: conduct.turn_rate_rad_s.map(f64::to_degrees),
        item: progress.current.and_then(|seq| vehicle.item_of_seq(seq)),
        total: progress.total,
        reached: progress.reached.iter().filter_map(|seq| vehicle.item_of_seq(*seq)).collect(),
        is_complete: progress.is_complete,
        distance_m: progress.distance_to_go_m,
        time_s: progress.time_to_go_s,
        leg_distance_m: progress.distance_to_current_m,
        circled_turns: progress.circled.flown().map(|(turns, _)| turns),
        circled_s: progress.circled.flown().map(|(_, time_s)| time_s),
        target_off_m: progress.target_off_m,
        preparation: preparation(vehicle),
    }
}

/// Steps needed before a flight, while it can be prepared.
fn preparation(vehicle: &VehicleHandle) -> Option<dto::FlightPreparation> {
    let (telemetry, _) = vehicle.telemetry();
    if telemetry.heartbeat.is_none_or(|heartbeat| heartbeat.value.is_armed) || telemetry.is_on_ground() == Some(false) {
        return None;
    }
    let preparation = vehicle.flight_preparation().filter(|preparation| preparation.is_needed())?;
    Some(dto::FlightPreparation {
        from_mode: preparation.from.to_string(),
        mode: preparation.mode.map(|mode| mode.to_string()),
        rewinds_mission: preparation.rewinds_mission,
    })
}

/// Autopilot family according to the heartbeat; `None` before the first.
fn mode_family(vehicle: &VehicleHandle) -> Option<ModeFamily> {
    let heartbeat = vehicle.telemetry().0.heartbeat?.value;
    Some(ModeFamily::of(heartbeat.autopilot, heartbeat.mav_type))
}

pub(crate) fn vehicle_state(vehicle: &VehicleHandle) -> dto::VehicleState {
    let (telemetry, now) = vehicle.telemetry();
    let state_of = |kind| plan_state(vehicle.plan_state(kind));
    let family = mode_family(vehicle);
    let mav_type = telemetry.autopilot_type().map_or(0, |known| known.mav_type);
    let mode_names =
        family.map_or_else(Vec::new, |family| family.modes_of(mav_type).map(|(_, name)| name.to_owned()).collect());
    dto::VehicleState {
        system_id: vehicle.id().number(),
        time_s: seconds(vehicle.station().now()),
        telemetry: TelemetryGroups::all(&telemetry, now),
        progress: progress(vehicle),
        plan_states: dto::PlanStates {
            mission: state_of(core::PlanKind::Mission),
            fence: state_of(core::PlanKind::Fence),
            rally: state_of(core::PlanKind::Rally),
        },
        mode_names,
        flies_arcs: family.is_some_and(ModeFamily::flies_arcs),
        link: vehicle_link(vehicle),
    }
}

pub(crate) fn texts(vehicle: &VehicleHandle) -> Vec<dto::Text> {
    vehicle.texts().into_iter().map(|one| text(vehicle, one)).collect()
}

pub(crate) fn text(vehicle: &VehicleHandle, Text { at, severity, text, .. }: Text) -> dto::Text {
    let at = vehicle.moment(at);
    let unix_us = vehicle.replay().and_then(|replay| replay.unix_us_at(at));
    dto::Text { time_s: at.as_secs_f64(), unix_s: unix_us.map(|us| us as f64 / 1e6), severity: severity.0, text }
}
