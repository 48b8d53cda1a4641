//! From the core's values to those of the API and back. Nothing is decided here but what the core's types demand.

use vencejo_flight::FlightError;
use vencejo_flight::approaches::{Alternative, Flown};
use vencejo_flight::checks::{CheckContext, Finding, Fix};
use vencejo_flight::formats::{ParamEntry, PlanFormat};
use vencejo_flight::geodesy::GeoPoint;
use vencejo_flight::landing::{Landing, LandingCaution, LandingOptions};
use vencejo_flight::plan::{self as core, Command, MavFrame, MissionItem};
use vencejo_flight::progress::ProgressOptions;
use vencejo_link::{self as link, LinkStats};
use vencejo_proto::{Frame, MonoTime, decode_fields, message_name};
use vencejo_station::{Station, VehicleHandle};
use vencejo_vehicle::modes::ModeFamily;
use vencejo_vehicle::telemetry::{
    BATTERY_CRITICAL_PCT, BATTERY_LOW_PCT, LOSS_HIGH_PCT, LOSS_NOTABLE_PCT, LOST_AFTER, STALE_AFTER, TelemetryGroups,
};
use vencejo_vehicle::{self as vehicle, Reply};

use crate::dto;
use crate::dto::message::MessageField;
use crate::dto::recording::FileParam;
use crate::operations::Outcome;

/// Seconds on the station's clock.
pub(crate) fn seconds(moment: MonoTime) -> f64 {
    moment.as_duration().as_secs_f64()
}

fn link_fault(kind: link::FaultKind) -> dto::LinkFault {
    match kind {
        link::FaultKind::AddressInUse => dto::LinkFault::AddressInUse,
        link::FaultKind::NotOurAddress => dto::LinkFault::NotOurAddress,
        link::FaultKind::NoPermission => dto::LinkFault::NoPermission,
        link::FaultKind::NoSerialPort => dto::LinkFault::NoSerialPort,
        link::FaultKind::SerialPortInUse => dto::LinkFault::SerialPortInUse,
        link::FaultKind::NoBaudRate => dto::LinkFault::NoBaudRate,
        link::FaultKind::NoHost => dto::LinkFault::NoHost,
        link::FaultKind::Refused => dto::LinkFault::Refused,
        link::FaultKind::NoAnswer => dto::LinkFault::NoAnswer,
        link::FaultKind::ClosedByPeer => dto::LinkFault::ClosedByPeer,
        link::FaultKind::Other => dto::LinkFault::Other,
    }
}

pub(crate) fn link_info(station: &Station, info: &link::LinkInfo, stats: &LinkStats) -> dto::LinkInfo {
    let now = station.now();
    let (state, fault, detail) = match &info.state {
        link::LinkState::Connecting { last_error, .. } => {
            let fault = last_error.as_ref().map(|fault| link_fault(fault.kind));
            (dto::LinkState::Connecting, fault, last_error.as_ref().map(ToString::to_string))
        }
        link::LinkState::Up { .. } => (dto::LinkState::Up, None, None),
        link::LinkState::Down => (dto::LinkState::Down, None, None),
        link::LinkState::Ended { remark } => (dto::LinkState::Ended, None, remark.clone()),
    };
    dto::LinkInfo {
        id: info.id.0,
        name: info.name.clone(),
        address: info.address.to_string(),
        local_address: station.local_address(info.id).map(|local| local.to_string()),
        state,
        fault,
        detail,
        forward: info.forwards,
        frames_received: stats.received.frames,
        frames_sent: stats.sent.frames,
        bytes_received: stats.received.bytes,
        bytes_sent: stats.sent.bytes,
        bad_crc: stats.bad_crc,
        garbage_bytes: stats.garbage_bytes,
        frames_refused: stats.refused,
        accepts_unsigned: info.accepts_unsigned,
        frames_lost: stats.lost,
        loss_pct: stats.loss_ratio.map(|ratio| ratio * 100.0),
        round_trip_ms: stats.round_trip.map(|round_trip| round_trip.last.as_secs_f64() * 1e3),
        age_s: stats.last_seen.map(|seen| now.since(seen).as_secs_f64()),
        frames_per_s: stats.rates.frames_hz,
        namesake: station.namesake().filter(|(link, _)| *link == info.id).map(|(_, place)| place),
        recent_loss_pct: stats.rates.loss_ratio.map(|ratio| ratio * 100.0),
    }
}

pub(crate) fn signing(vehicle: &VehicleHandle) -> dto::SigningInfo {
    let info = vehicle.signing();
    dto::SigningInfo {
        must_sign: info.must_sign,
        key: info.key,
        key_missing: info.key_missing,
        unproven: info.unproven,
        link_accepts_unsigned: vehicle.link().is_some_and(|(link, _, _)| link.accepts_unsigned),
        verified: info.counts.verified,
        unsigned_accepted: info.counts.unsigned_accepted,
        refused_unsigned: info.counts.unsigned,
        refused_wrong_key: info.counts.wrong_key,
        refused_replayed: info.counts.replayed,
        refused_old: info.counts.old,
        refused_future: info.counts.future,
        verified_age_s: info.verified_age.map(|age| age.as_secs_f64()),
        refused_age_s: info.refused_age.map(|age| age.as_secs_f64()),
    }
}

pub(crate) fn links(station: &Station) -> Vec<dto::LinkInfo> {
    station.links().iter().map(|(info, stats)| link_info(station, info, stats)).collect()
}

/// The link to a vehicle, with the vehicle's own figures instead of those of all that speak there.
fn vehicle_link(vehicle: &VehicleHandle) -> Option<dto::LinkInfo> {
    let (info, stats, source) = vehicle.link()?;
    let now = vehicle.station().now();
    let mut link = link_info(vehicle.station(), &info, &stats);
    if let Some(source) = source {
        link.frames_received = source.received.frames;
        link.bytes_received = source.received.bytes;
        link.frames_lost = source.lost;
        link.loss_pct = source.rates.loss_ratio.map(|ratio| ratio * 100.0);
        link.recent_loss_pct = link.loss_pct;
        link.frames_per_s = source.rates.frames_hz;
        link.age_s = Some(now.since(source.last_seen).as_secs_f64());
    }
    Some(link)
}

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
        link: link.as_ref().map(|link| link.id),
        loss_pct: link.as_ref().and_then(|link| link.loss_pct),
        round_trip_ms: link.as_ref().and_then(|link| link.round_trip_ms),
        is_reached: vehicle.is_reached(),
        rival: vehicle.rival(),
        lacks_terrain: vehicle.lacks_terrain(),
        flight_parameters: flight_parameters(vehicle.flight_parameters()),
    }
}

fn flight_parameters(known: vehicle::FlightParameters) -> dto::FlightParameters {
    let vehicle::FlightParameters { loiter_radius_m, airspeed_m_s, finds_landing, .. } = known;
    dto::FlightParameters { loiter_radius_m, airspeed_m_s, finds_landing }
}

pub(crate) fn vehicle_summaries(station: &Station) -> Vec<dto::VehicleSummary> {
    station.vehicles().iter().map(vehicle_summary).collect()
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
        target_off_m: progress.target_off_m,
        preparation: preparation(vehicle),
    }
}

/// What a flight needs first, while it may be done.
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

pub(crate) fn plan_kind(kind: core::PlanKind) -> dto::PlanKind {
    match kind {
        core::PlanKind::Mission => dto::PlanKind::Mission,
        core::PlanKind::Fence => dto::PlanKind::Fence,
        core::PlanKind::Rally => dto::PlanKind::Rally,
    }
}

pub(crate) fn core_plan_kind(kind: dto::PlanKind) -> core::PlanKind {
    match kind {
        dto::PlanKind::Mission => core::PlanKind::Mission,
        dto::PlanKind::Fence => core::PlanKind::Fence,
        dto::PlanKind::Rally => core::PlanKind::Rally,
    }
}

pub(crate) fn plan_state(state: Option<vehicle::PlanState>) -> dto::PlanState {
    let (certainty, count, hash) = match state {
        Some(vehicle::PlanState::Empty) => (dto::PlanCertainty::Empty, Some(0), None),
        Some(vehicle::PlanState::Verified { count, hash }) => {
            (dto::PlanCertainty::Verified, Some(count), Some(format!("{hash:016x}")))
        }
        Some(vehicle::PlanState::Differs { count, hash }) => {
            (dto::PlanCertainty::Unknown, Some(count), Some(format!("{hash:016x}")))
        }
        _ => (dto::PlanCertainty::Unknown, None, None),
    };
    let detail = state.map_or_else(|| "unknown".to_owned(), |state| state.to_string());
    let may_be_mixed = state.is_some_and(vehicle::PlanState::may_be_mixed);
    dto::PlanState { state: certainty, count, hash, reason: state.and_then(uncertainty), may_be_mixed, detail }
}

/// One part of the plan on board, as far as it is known.
///
/// # Errors
/// For a fence or rally list from the vehicle that cannot be.
pub(crate) fn plan_on_board(vehicle: &VehicleHandle, kind: core::PlanKind) -> Result<dto::PlanOnBoard, FlightError> {
    let (state, list) = vehicle.plan_on_board(kind).unzip();
    let read = match (state, list.flatten()) {
        (_, Some(list)) => Some(core::Plan::from_list(kind, core::Mission::clone(&list))?),
        (Some(vehicle::PlanState::Empty), None) => Some(core::Plan::default()),
        _ => None,
    };
    Ok(dto::PlanOnBoard { state: plan_state(state), plan: read.as_ref().map(plan) })
}

/// How a plan differs from what a vehicle has on board.
pub(crate) fn plan_comparison(vehicle: &VehicleHandle, plan: &core::Plan) -> dto::PlanComparison {
    let part = |kind| {
        let (state, changes) = vehicle.plan_changes(plan, kind)?;
        Some(dto::PartComparison { hash: plan_state(Some(state)).hash, changes })
    };
    dto::PlanComparison {
        mission: part(core::PlanKind::Mission),
        fence: part(core::PlanKind::Fence),
        rally: part(core::PlanKind::Rally),
    }
}

/// Why a plan is not known; `None` when it is.
pub(crate) fn uncertainty(state: vehicle::PlanState) -> Option<dto::PlanUncertainty> {
    let why = match state {
        vehicle::PlanState::Unknown(why) => why,
        vehicle::PlanState::Differs { .. } => return Some(dto::PlanUncertainty::Mixed),
        _ => return None,
    };
    Some(match why {
        vehicle::Unknown::NeverRead => dto::PlanUncertainty::NeverRead,
        vehicle::Unknown::Transferring => dto::PlanUncertainty::Transferring,
        vehicle::Unknown::TransferFailed => dto::PlanUncertainty::TransferFailed,
        vehicle::Unknown::Rebooted => dto::PlanUncertainty::Rebooted,
        vehicle::Unknown::ChangedElsewhere => dto::PlanUncertainty::ChangedElsewhere,
        vehicle::Unknown::SentElsewhere => dto::PlanUncertainty::SentElsewhere,
        vehicle::Unknown::RecordDamaged => dto::PlanUncertainty::RecordDamaged,
        _ => return None,
    })
}

/// Which autopilot it is, by its heartbeat; `None` before the first.
pub(crate) fn mode_family(vehicle: &VehicleHandle) -> Option<ModeFamily> {
    let heartbeat = vehicle.telemetry().0.heartbeat?.value;
    Some(ModeFamily::of(heartbeat.autopilot, heartbeat.mav_type))
}

pub(crate) fn vehicle_state(vehicle: &VehicleHandle) -> dto::VehicleState {
    let (telemetry, now) = vehicle.telemetry();
    let state_of = |kind| plan_state(vehicle.plan_state(kind));
    let family = mode_family(vehicle);
    let mode_names =
        family.map_or_else(Vec::new, |family| family.modes().iter().map(|(_, name)| (*name).to_owned()).collect());
    dto::VehicleState {
        system_id: vehicle.id().number(),
        time_s: seconds(now),
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
    let texts = vehicle.texts().into_iter();
    texts.map(|text| dto::Text { time_s: seconds(text.at), severity: text.severity.0, text: text.text }).collect()
}

/// What a landing is designed from; what is not given is as `usual`.
pub(crate) fn landing_options(
    asked: &dto::LandingRequest,
    usual: LandingOptions,
) -> Result<LandingOptions, FlightError> {
    Ok(LandingOptions {
        course_deg: asked.course_deg,
        coming_from: asked.coming_from.map(point).transpose()?,
        wind: asked.wind,
        ground_rel_home_m: asked.ground_rel_home_m,
        airspeed_m_s: asked.airspeed_m_s.unwrap_or(usual.airspeed_m_s),
        slope: asked.slope.unwrap_or(usual.slope),
        final_height_m: asked.final_height_m.unwrap_or(usual.final_height_m),
        radius_m: asked.radius_m.unwrap_or(usual.radius_m),
        is_clockwise: asked.is_clockwise.unwrap_or(usual.is_clockwise),
        has_land_start: asked.has_land_start.unwrap_or(usual.has_land_start),
    })
}

pub(crate) fn point(place: dto::LatLon) -> Result<GeoPoint, FlightError> {
    GeoPoint::new(place.lat_deg, place.lon_deg)
}

pub(crate) fn landing_alternative(one: &Alternative) -> dto::LandingAlternative {
    let Flown { ending, touch_down_m, rest_m, duration_s } = one.flown;
    dto::LandingAlternative {
        landing: landing(&one.landing),
        is_clockwise: one.is_clockwise,
        crosswind_m_s: one.crosswind_m_s,
        ending,
        touch_down_m,
        rest_m,
        duration_s,
        verdict: one.verdict,
        reasons: one
            .reasons
            .iter()
            .map(|reason| dto::LandingReasonText { message: reason.to_string(), reason: *reason })
            .collect(),
    }
}

pub(crate) fn landing(landing: &Landing) -> dto::Landing {
    let caution = |caution: &LandingCaution| dto::LandingCaution {
        code: caution.as_str().to_owned(),
        message: caution.to_string(),
    };
    dto::Landing {
        items: landing.items.iter().map(item).collect(),
        course_deg: landing.course_deg,
        direction: landing.direction,
        leaves: dto::LatLon { lat_deg: landing.leaves.lat_deg(), lon_deg: landing.leaves.lon_deg() },
        leaves_alt_rel_home_m: landing.leaves_alt_rel_home_m,
        final_m: landing.final_m,
        slope: landing.slope,
        radius_m: landing.radius_m,
        headwind_m_s: landing.headwind_m_s,
        groundspeed_m_s: landing.groundspeed_m_s,
        cautions: landing.cautions.iter().map(caution).collect(),
    }
}

pub(crate) fn finding_fix(finding: Finding, fix: Fix) -> dto::FindingFix {
    dto::FindingFix {
        finding,
        message: fix.message(),
        first_item: fix.first + 1,
        count: fix.count,
        items: fix.items.iter().map(item).collect(),
        kind: fix.kind,
    }
}

pub(crate) fn item(item: &MissionItem) -> dto::PlanItem {
    dto::PlanItem {
        command: item.command.0,
        name: item.command.to_string(),
        frame: item.frame.number(),
        params: item.params,
        autocontinue: item.autocontinue,
    }
}

pub(crate) fn core_item(item: &dto::PlanItem) -> MissionItem {
    MissionItem {
        command: Command(item.command),
        frame: MavFrame::from(item.frame),
        params: item.params,
        autocontinue: item.autocontinue,
    }
}

pub(crate) fn plan_format(format: dto::PlanFormat) -> PlanFormat {
    match format {
        dto::PlanFormat::Plan => PlanFormat::QgcPlan,
        dto::PlanFormat::Waypoints => PlanFormat::Waypoints,
        dto::PlanFormat::Kml => PlanFormat::Kml,
        dto::PlanFormat::Kmz => PlanFormat::Kmz,
        dto::PlanFormat::Geojson => PlanFormat::GeoJson,
        dto::PlanFormat::Gpx => PlanFormat::Gpx,
        dto::PlanFormat::Csv => PlanFormat::Csv,
    }
}

pub(crate) fn plan(plan: &core::Plan) -> dto::Plan {
    let place = |point: &GeoPoint| dto::LatLon { lat_deg: point.lat_deg(), lon_deg: point.lon_deg() };
    let zone = |zone: &core::FenceZone| {
        let (shape, points, radius_m) = match &zone.shape {
            core::FenceShape::Polygon { vertices } => {
                (dto::ZoneShape::Polygon, vertices.iter().map(place).collect(), None)
            }
            core::FenceShape::Circle { center, radius_m } => {
                (dto::ZoneShape::Circle, vec![place(center)], Some(*radius_m))
            }
        };
        dto::FenceZone { inclusion: zone.inclusion, shape, points, radius_m }
    };
    dto::Plan {
        items: plan.mission.items.iter().map(item).collect(),
        home: plan.mission.home,
        fence: dto::Fence {
            zones: plan.fence.zones.iter().map(zone).collect(),
            return_point: plan.fence.return_point.map(|(point, alt_rel_home_m)| dto::ReturnPoint {
                lat_deg: point.lat_deg(),
                lon_deg: point.lon_deg(),
                alt_rel_home_m,
            }),
        },
        rally: plan
            .rally
            .points
            .iter()
            .map(|rally| dto::RallyPoint {
                lat_deg: rally.point.lat_deg(),
                lon_deg: rally.point.lon_deg(),
                alt_m: rally.alt_m,
                frame: rally.frame.number(),
            })
            .collect(),
        complex_items: Vec::new(),
    }
}

/// A plan as a client wrote it.
///
/// # Errors
/// For a position that is not on Earth, a circle without exactly one centre and a radius, or a polygon with a radius, and
/// when there are more than [`core::MAX_ITEMS`] items.
pub(crate) fn core_plan(plan: &dto::Plan) -> Result<core::Plan, FlightError> {
    let counts = [
        plan.items.len(),
        plan.rally.len(),
        plan.fence.zones.iter().map(|zone| zone.points.len()).sum::<usize>() + plan.fence.zones.len(),
    ];
    if let Some(count) = counts.into_iter().find(|count| *count > core::MAX_ITEMS) {
        return Err(FlightError::BadMission {
            index: core::MAX_ITEMS,
            problem: format!("the plan has {count} items; at most {} are taken, so split it", core::MAX_ITEMS),
        });
    }
    plan.home.map_or(Ok(()), |home| home.point().map(drop))?;
    let point = |place: &dto::LatLon| GeoPoint::new(place.lat_deg, place.lon_deg);
    let zone = |(index, zone): (usize, &dto::FenceZone)| {
        let shape = match (zone.shape, zone.radius_m, zone.points.as_slice()) {
            (dto::ZoneShape::Polygon, None, corners) => {
                core::FenceShape::Polygon { vertices: corners.iter().map(point).collect::<Result<_, _>>()? }
            }
            (dto::ZoneShape::Circle, Some(radius_m), [center]) => {
                core::FenceShape::Circle { center: point(center)?, radius_m }
            }
            (dto::ZoneShape::Polygon, Some(_), _) => {
                return Err(FlightError::BadFence {
                    index,
                    problem: "a polygon has no radius; give null, or make it a circle".into(),
                });
            }
            (dto::ZoneShape::Circle, _, points) => {
                return Err(FlightError::BadFence {
                    index,
                    problem: format!("a circle has one centre and a radius, this has {} points", points.len()),
                });
            }
        };
        Ok(core::FenceZone { inclusion: zone.inclusion, shape })
    };
    let rally = |rally: &dto::RallyPoint| {
        let point = GeoPoint::new(rally.lat_deg, rally.lon_deg)?;
        Ok(core::RallyPoint { point, alt_m: rally.alt_m, frame: MavFrame::from(rally.frame) })
    };
    let return_point = plan
        .fence
        .return_point
        .map(|place| Ok::<_, FlightError>((GeoPoint::new(place.lat_deg, place.lon_deg)?, place.alt_rel_home_m)));
    Ok(core::Plan {
        mission: core::Mission { home: plan.home, items: plan.items.iter().map(core_item).collect() },
        fence: core::Fence {
            zones: plan.fence.zones.iter().enumerate().map(zone).collect::<Result<_, _>>()?,
            return_point: return_point.transpose()?,
        },
        rally: core::Rally { points: plan.rally.iter().map(rally).collect::<Result<_, FlightError>>()? },
    })
}

/// What a transfer brought; `None` for a reply that brings nothing.
///
/// # Errors
/// For a fence or rally list from the vehicle that cannot be.
pub(crate) fn outcome(reply: Reply) -> Result<Outcome, FlightError> {
    Ok(match reply {
        Reply::Plan { kind, items, home, position_error_m, .. } => {
            let read = core::Plan::from_list(kind, core::Mission { home, items })?;
            Outcome { result: Some(dto::OperationResult::Plan(plan(&read))), position_error_m }
        }
        Reply::Parameters(params) => {
            let result = Some(dto::OperationResult::Params(params.iter().map(param).collect()));
            Outcome { result, position_error_m: None }
        }
        _ => Outcome::default(),
    })
}

/// A message by the names of its fields.
pub(crate) fn raw_message(frame: &Frame, at: MonoTime) -> dto::RawMessage {
    let (id, source) = (frame.message_id(), frame.source());
    let fields = decode_fields(id, frame.payload()).unwrap_or_default();
    dto::RawMessage {
        name: message_name(id).map_or_else(|| format!("UNKNOWN_{id}"), str::to_owned),
        id,
        system_id: source.system.0,
        component_id: source.component.0,
        time_s: seconds(at),
        fields: fields.iter().map(|(name, value)| ((*name).to_owned(), MessageField::new(value))).collect(),
    }
}

/// A parameter of a file.
pub(crate) fn file_param(entry: &ParamEntry) -> FileParam {
    FileParam { name: entry.name.clone(), value: entry.value }
}

pub(crate) fn param(param: &vehicle::Param) -> dto::Param {
    let kind = match param.value {
        vehicle::ParamValue::U8(_) => "uint8",
        vehicle::ParamValue::I8(_) => "int8",
        vehicle::ParamValue::U16(_) => "uint16",
        vehicle::ParamValue::I16(_) => "int16",
        vehicle::ParamValue::U32(_) => "uint32",
        vehicle::ParamValue::I32(_) => "int32",
        vehicle::ParamValue::F32(_) => "real32",
    };
    dto::Param { name: param.name.as_str().to_owned(), value: param.value.as_f64(), kind: kind.to_owned() }
}

/// An ArduPlane as it comes, as far as a plan's way depends on it.
pub(crate) fn usual_plane() -> serde_json::Value {
    let loiter_radius_m = ProgressOptions::default().loiter_radius_m;
    serde_json::json!({"loiter_radius_m": loiter_radius_m, "airspeed_m_s": CheckContext::default().airspeed_m_s})
}

/// The kind of each `MAV_TYPE` that is one.
pub(crate) fn vehicle_kinds() -> serde_json::Value {
    let kind = |mav_type: u8| Some((mav_type.to_string(), vehicle::VehicleKind::of(mav_type)?.as_str().into()));
    serde_json::Value::Object((0..=u8::MAX).filter_map(kind).collect())
}

/// After how long a value, or a vehicle, counts for less, and for nothing, seconds.
pub(crate) fn ages() -> serde_json::Value {
    serde_json::json!({"stale_s": STALE_AFTER.as_secs_f64(), "lost_s": LOST_AFTER.as_secs_f64()})
}

/// What each `GPS_FIX_TYPE` is worth.
pub(crate) fn gps_fixes() -> serde_json::Value {
    let row = |number| {
        let fix = vehicle::telemetry::GpsFix(number);
        (number.to_string(), serde_json::json!({"name": fix.name(), "is_3d": fix.is_3d()}))
    };
    serde_json::Value::Object(vehicle::telemetry::GpsFix::KNOWN.map(row).collect())
}

/// From when on a value wants somebody's attention.
pub(crate) fn attention() -> serde_json::Value {
    serde_json::json!({
        "battery_low_pct": BATTERY_LOW_PCT, "battery_critical_pct": BATTERY_CRITICAL_PCT,
        "loss_notable_pct": LOSS_NOTABLE_PCT, "loss_high_pct": LOSS_HIGH_PCT,
    })
}

/// The table of commands.
pub(crate) fn commands() -> Vec<dto::CommandInfo> {
    core::command::COMMANDS.iter().map(command_info).collect()
}

fn command_info(info: &core::CommandInfo) -> dto::CommandInfo {
    dto::CommandInfo {
        number: info.command.0,
        name: info.command.to_string(),
        title: info.title.to_owned(),
        category: match info.category {
            core::Category::Nav => dto::CommandCategory::Nav,
            core::Category::Condition => dto::CommandCategory::Condition,
            core::Category::Do => dto::CommandCategory::Do,
            core::Category::Fence => dto::CommandCategory::Fence,
            core::Category::Rally => dto::CommandCategory::Rally,
        },
        support: match info.support {
            core::Support::Flown => dto::CommandSupport::Flown,
            core::Support::NeedsVtol => dto::CommandSupport::NeedsVtol,
            core::Support::Ignored => dto::CommandSupport::Ignored,
            core::Support::List => dto::CommandSupport::List,
        },
        has_position: info.has_position,
        is_destination: info.is_destination,
        params: info
            .params
            .iter()
            .map(|param| dto::CommandParam {
                label: param.label.to_owned(),
                unit: param.unit.symbol().to_owned(),
                min: param.min,
                max: param.max,
                default: param.default,
                choices: param.choices,
            })
            .collect(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn round(plan_before: &dto::Plan) -> dto::Plan {
        plan(&core_plan(plan_before).expect("a plan"))
    }

    #[test]
    fn the_page_has_what_the_core_says() {
        let page = include_str!("../../../gcs/src/lib/domain/core.json");
        let file = "gcs/src/lib/domain/core.json";
        assert!(
            page == crate::core_facts(),
            "{file} is old: cargo run -p vencejo-server --example core_facts > {file}"
        );
    }

    #[test]
    fn a_whole_plan_goes_to_the_core_and_back() {
        let json = serde_json::json!({
            "items": [{"command": 16, "name": "NAV_WAYPOINT", "frame": 3, "autocontinue": true,
                       "params": [0.0, null, 0.0, 0.0, 40.3332, -3.7978, 60.0]}],
            "home": {"lat_deg": 40.3, "lon_deg": -3.8, "alt_amsl_m": 600.0},
            "fence": {
                "zones": [
                    {"inclusion": true, "shape": "polygon", "radius_m": null, "points": [
                        {"lat_deg": 40.0, "lon_deg": -4.0}, {"lat_deg": 41.0, "lon_deg": -4.0},
                        {"lat_deg": 41.0, "lon_deg": -3.0}]},
                    {"inclusion": false, "shape": "circle", "radius_m": 50.0,
                     "points": [{"lat_deg": 40.5, "lon_deg": -3.5}]}],
                "return_point": {"lat_deg": 40.3, "lon_deg": -3.8, "alt_rel_home_m": 80.0}},
            "rally": [{"lat_deg": 40.31, "lon_deg": -3.81, "alt_m": 90.0, "frame": 3}],
        });
        let before: dto::Plan = serde_json::from_value(json.clone()).expect("a plan");
        assert_eq!(serde_json::to_value(round(&before)).expect("JSON"), json);
    }

    #[test]
    fn what_is_no_plan_says_why() {
        let zone = |shape, radius_m, count| dto::Plan {
            fence: dto::Fence {
                zones: vec![dto::FenceZone {
                    inclusion: true,
                    shape,
                    radius_m,
                    points: vec![dto::LatLon { lat_deg: 1.0, lon_deg: 2.0 }; count],
                }],
                return_point: None,
            },
            ..dto::Plan::default()
        };
        let far = dto::Plan {
            rally: vec![dto::RallyPoint { lat_deg: 91.0, lon_deg: 0.0, alt_m: 1.0, frame: 3 }],
            ..dto::Plan::default()
        };
        for (plan, word) in [
            (zone(dto::ZoneShape::Circle, None, 1), "radius"),
            (zone(dto::ZoneShape::Circle, Some(5.0), 2), "2 points"),
            (zone(dto::ZoneShape::Polygon, Some(5.0), 3), "no radius"),
            (far, "91"),
        ] {
            let error = core_plan(&plan).expect_err("not a plan").to_string();
            assert!(error.contains(word), "{error}");
        }
    }

    #[test]
    fn every_command_of_the_table_is_told() {
        let told = commands();
        assert_eq!(told.len(), core::command::COMMANDS.len());
        let waypoint = told.iter().find(|command| command.number == 16).expect("waypoint");
        assert_eq!((waypoint.name.as_str(), waypoint.has_position), ("NAV_WAYPOINT", true));
        assert_eq!(waypoint.params[4].unit, "°");
    }
}
