//! Plans and their state on board, in both directions.

use vencejo_flight::FlightError;
use vencejo_flight::formats::PlanFormat;
use vencejo_flight::geodesy::GeoPoint;
use vencejo_flight::plan::{self as core, Command, MavFrame, MissionItem};
use vencejo_station::VehicleHandle;
use vencejo_vehicle as vehicle;

use crate::dto;

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
/// For an invalid fence or rally list from the vehicle.
pub(crate) fn plan_on_board(vehicle: &VehicleHandle, kind: core::PlanKind) -> Result<dto::PlanOnBoard, FlightError> {
    let (state, list) = vehicle.plan_on_board(kind).unzip();
    let read = match (state, list.flatten()) {
        (_, Some(list)) => Some(core::Plan::from_list(kind, core::Mission::clone(&list))?),
        (Some(vehicle::PlanState::Empty), None) => Some(core::Plan::default()),
        _ => None,
    };
    Ok(dto::PlanOnBoard { state: plan_state(state), plan: read.as_ref().map(plan) })
}

/// Compares a plan with the one on board.
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

/// Why a plan is unknown; `None` when it is known.
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
        planned_for: None,
    }
}

/// Converts a plan from a client.
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
            problem: format!("the plan has {count} items; at most {} are accepted, so split it", core::MAX_ITEMS),
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
                    problem: format!("a circle has one centre and a radius, not {} points", points.len()),
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

#[cfg(test)]
mod tests {
    use super::*;

    fn round(plan_before: &dto::Plan) -> dto::Plan {
        plan(&core_plan(plan_before).expect("a plan"))
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
}
