//! Constants of the core for clients: commands, vehicle types, limits.

use vencejo_flight::checks::CheckContext;
use vencejo_flight::plan as core;
use vencejo_flight::progress::ProgressOptions;
use vencejo_vehicle as vehicle;
use vencejo_vehicle::telemetry::{
    BATTERY_CRITICAL_PCT, BATTERY_LOW_PCT, LOSS_HIGH_PCT, LOSS_NOTABLE_PCT, LOST_AFTER, STALE_AFTER,
};

use crate::dto;

/// A default ArduPlane, as far as the route of a plan depends on it.
pub(crate) fn usual_plane() -> serde_json::Value {
    let loiter_radius_m = ProgressOptions::default().loiter_radius_m;
    serde_json::json!({"loiter_radius_m": loiter_radius_m, "airspeed_m_s": CheckContext::default().airspeed_m_s})
}

/// Vehicle kind of each known `MAV_TYPE`.
pub(crate) fn vehicle_kinds() -> serde_json::Value {
    let kind = |mav_type: u8| Some((mav_type.to_string(), vehicle::VehicleKind::of(mav_type)?.as_str().into()));
    serde_json::Value::Object((0..=u8::MAX).filter_map(kind).collect())
}

/// Ages at which a value or a vehicle counts as stale and as lost, seconds.
pub(crate) fn ages() -> serde_json::Value {
    serde_json::json!({"stale_s": STALE_AFTER.as_secs_f64(), "lost_s": LOST_AFTER.as_secs_f64()})
}

/// Quality of each `GPS_FIX_TYPE`.
pub(crate) fn gps_fixes() -> serde_json::Value {
    let row = |number| {
        let fix = vehicle::telemetry::GpsFix(number);
        (number.to_string(), serde_json::json!({"name": fix.name(), "is_3d": fix.is_3d()}))
    };
    serde_json::Value::Object(vehicle::telemetry::GpsFix::KNOWN.map(row).collect())
}

/// Thresholds from which values need attention.
pub(crate) fn attention() -> serde_json::Value {
    serde_json::json!({
        "battery_low_pct": BATTERY_LOW_PCT, "battery_critical_pct": BATTERY_CRITICAL_PCT,
        "loss_notable_pct": LOSS_NOTABLE_PCT, "loss_high_pct": LOSS_HIGH_PCT,
    })
}

/// Table of mission commands.
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

    #[test]
    fn the_page_has_what_the_core_says() {
        let page = include_str!("../../../../gcs/src/lib/domain/core.json");
        let file = "gcs/src/lib/domain/core.json";
        assert!(
            page == crate::core_facts(),
            "{file} is out of date: cargo run -p vencejo-server --example core_facts > {file}"
        );
    }

    #[test]
    fn every_command_of_the_table_is_converted() {
        let told = commands();
        assert_eq!(told.len(), core::command::COMMANDS.len());
        let waypoint = told.iter().find(|command| command.number == 16).expect("waypoint");
        assert_eq!((waypoint.name.as_str(), waypoint.has_position), ("NAV_WAYPOINT", true));
        assert_eq!(waypoint.params[4].unit, "°");
    }
}
