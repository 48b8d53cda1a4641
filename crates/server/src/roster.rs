//! The fleet list: built once a second, sent to each client as a delta.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;
use std::time::Duration;

use serde_json::{Map, Value};
use vencejo_flight::plan::PlanKind;
use vencejo_proto::MonoTime;
use vencejo_station::{Station, VehicleHandle};
use vencejo_vehicle::PlanState;
use vencejo_vehicle::telemetry::Severity;

use crate::convert;
use crate::dto::roster::{RosterChange, RosterRow, RosterText};

/// How long a warning text stays in the list.
const ALARM_FOR: Duration = Duration::from_secs(60);

/// Rows as sent, by id.
type Rows = BTreeMap<u16, Arc<Map<String, Value>>>;

/// The rows of all vehicles at one time.
#[derive(Debug, Clone, Default)]
pub struct Roster {
    /// Seconds on the station's clock.
    pub time_s: f64,
    rows: Rows,
}

impl Roster {
    /// The present rows.
    pub fn now(station: &Station) -> Self {
        let rows = station.shown_vehicles().iter().map(row).collect();
        Self { time_s: convert::seconds(station.now()), rows }
    }

    /// Whether it has no rows: there are no vehicles, or it was never built.
    pub fn is_empty(&self) -> bool {
        self.rows.is_empty()
    }

    /// The same rows, with those of new vehicles added and those of missing ones removed; the others are not rebuilt.
    pub fn with_newcomers(&self, vehicles: &[VehicleHandle], now: MonoTime) -> Self {
        let kept = |vehicle: &VehicleHandle| {
            let id = vehicle.id().number();
            self.rows.get(&id).map_or_else(|| row(vehicle), |row| (id, row.clone()))
        };
        Self { time_s: convert::seconds(now), rows: vehicles.iter().map(kept).collect() }
    }
}

/// The rows that one client has.
#[derive(Debug, Default)]
pub struct SentRows(Rows);

impl SentRows {
    /// The difference to the client's rows: changed rows, and ids of removed ones.
    pub fn changes(&mut self, roster: &Roster) -> (Vec<RosterChange>, Vec<u16>) {
        let changed = roster.rows.iter().filter_map(|(id, row)| {
            let Some(before) = self.0.get(id) else { return Some(RosterChange(row.as_ref().clone())) };
            if Arc::ptr_eq(before, row) {
                return None;
            }
            let is_other = |(name, value): &(&String, &Value)| before.get(*name) != Some(value);
            let mut fields: Map<_, _> =
                row.iter().filter(is_other).map(|(name, value)| (name.clone(), value.clone())).collect();
            if fields.is_empty() {
                return None;
            }
            fields.insert("id".to_owned(), Value::from(*id));
            Some(RosterChange(fields))
        });
        let changed = changed.collect();
        let there: BTreeSet<_> = roster.rows.keys().collect();
        let gone = self.0.keys().filter(|id| !there.contains(id)).copied().collect();
        self.0.clone_from(&roster.rows);
        (changed, gone)
    }
}

fn row(vehicle: &VehicleHandle) -> (u16, Arc<Map<String, Value>>) {
    let row = of_vehicle(vehicle);
    match serde_json::to_value(&row) {
        Ok(Value::Object(fields)) => (row.id, Arc::new(fields)),
        _ => unreachable!("invariant: a row is an object"),
    }
}

/// Rounds a value, so that a row is sent only when it would be displayed differently.
fn rounded(value: Option<f64>, parts: f64) -> Option<f64> {
    value.map(|value| (value * parts).round() / parts)
}

fn of_vehicle(vehicle: &VehicleHandle) -> RosterRow {
    let (telemetry, now) = vehicle.telemetry();
    let heartbeat = telemetry.heartbeat.map(|heartbeat| heartbeat.value);
    let position = telemetry.position.map(|position| position.value);
    let hud = telemetry.hud.map(|hud| hud.value);
    let battery = telemetry.batteries[0].and_then(|battery| battery.value.remaining_pct);
    let battery = battery.or_else(|| telemetry.sys_status.and_then(|status| status.value.battery_remaining_pct));
    let progress = vehicle.progress().unwrap_or_default();
    let held = vehicle.held_far();
    let link = vehicle.link().and_then(|(_, _, source)| source);
    let station_now = vehicle.station().now();
    let heard_ago = link.as_ref().map(|source| station_now.since(source.last_seen));
    let heard_ago = heard_ago.or_else(|| telemetry.heartbeat.map(|heartbeat| heartbeat.age(now)));
    let alarm = vehicle.newest_text(Severity::WARNING, ALARM_FOR);
    RosterRow {
        id: vehicle.id().number(),
        remote_name: vehicle.remote_name(),
        is_recorded: Some(vehicle.is_recorded()),
        mav_type: heartbeat.map(|heartbeat| heartbeat.mav_type),
        mode: heartbeat.map(|heartbeat| heartbeat.mode.to_string()),
        is_armed: heartbeat.map(|heartbeat| heartbeat.is_armed),
        is_on_ground: telemetry.is_on_ground(),
        lat_deg: rounded(position.and_then(|position| position.lat_deg), 1e6),
        lon_deg: rounded(position.and_then(|position| position.lon_deg), 1e6),
        alt_rel_home_m: rounded(position.and_then(|position| position.alt_rel_home_m), 10.0),
        heading_deg: rounded(position.and_then(|position| position.heading_deg), 1.0).map(|heading| heading % 360.0),
        airspeed_m_s: rounded(hud.and_then(|hud| hud.airspeed_m_s), 10.0),
        battery_pct: rounded(battery, 1.0),
        heard_s: rounded(heard_ago.map(|ago| convert::seconds(station_now) - ago.as_secs_f64()), 10.0),
        loss_pct: rounded(link.and_then(|source| source.rates.loss_ratio).map(|ratio| ratio * 100.0), 10.0),
        is_reached: vehicle.is_reached(),
        is_contested: Some(vehicle.rival().is_some()),
        silence: vehicle.silence().map(|silence| silence.links),
        is_held_here: held.as_ref().map(|held| held.is_ours),
        is_requested_here: held.as_ref().map(|held| held.is_request_ours),
        requested_by: held.as_ref().and_then(|held| held.requested_by.clone()),
        holder: held.and_then(|held| held.holder),
        is_revoked: Some(vehicle.is_revoked()),
        item: progress.current.and_then(|seq| vehicle.item_of_seq(seq)),
        items: progress.total,
        is_complete: Some(progress.is_complete),
        target_off_m: rounded(progress.target_off_m, 1.0),
        may_be_mixed: vehicle.plan_state(PlanKind::Mission).map(PlanState::may_be_mixed),
        alarm: alarm.map(|text| RosterText {
            severity: text.severity.0,
            text: text.text,
            time_s: vehicle.moment(text.at).as_secs_f64(),
        }),
    }
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;

    fn roster(rows: &[(u16, Value)]) -> Roster {
        let rows = rows.iter().map(|(id, row)| {
            let Value::Object(fields) = row else { unreachable!() };
            (*id, Arc::new(fields.clone()))
        });
        Roster { time_s: 1.0, rows: rows.collect() }
    }

    fn sent(sent: &mut SentRows, roster: &Roster) -> (Value, Vec<u16>) {
        let (rows, gone) = sent.changes(roster);
        (json!(rows), gone)
    }

    #[test]
    fn each_row_is_sent_whole_once_and_then_its_changes() {
        let mut client = SentRows::default();
        let one = json!({"id": 1, "mode": "AUTO", "lat_deg": 40.1, "holder": "Ana"});
        let two = json!({"id": 300, "mode": "RTL", "lat_deg": null});
        let first = roster(&[(1, one.clone()), (300, two.clone())]);
        assert_eq!(sent(&mut client, &first), (json!([one, two]), vec![]));
        assert_eq!(sent(&mut client, &first), (json!([]), vec![]), "the same again");
        let moved = json!({"id": 1, "mode": "AUTO", "lat_deg": 40.2, "holder": null});
        let second = roster(&[(1, moved), (300, two)]);
        assert_eq!(sent(&mut client, &second), (json!([{"id": 1, "lat_deg": 40.2, "holder": null}]), vec![]));
        assert_eq!(sent(&mut client, &roster(&[])), (json!([]), vec![1, 300]));
    }
}
