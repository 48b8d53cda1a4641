//! Whether the plane's target is that of its plan: the reported target against the current item of the plan read from
//! it. A mission that was read back may still not be the one that is flown, for example after another station has
//! changed it unseen.
//!
//! Only an ArduPlane that is armed and in AUTO, and only items whose target is their own position: waypoints, loiters
//! and the landing point. Its POSITION_TARGET_GLOBAL_INT gives that position exactly, at the same time as
//! MISSION_CURRENT (recorded flights: take-off, waypoints, loiters, a jump, landing). Without that message, distance
//! and bearing of NAV_CONTROLLER_OUTPUT give it less accurately, for waypoints only.

use std::time::Duration;

use vencejo_flight::geodesy::{GeoPoint, direct, distance_m};
use vencejo_flight::plan::{Command, MissionItem, PlanKind};
use vencejo_proto::dialect::POSITION_TARGET_GLOBAL_INT_DATA;
use vencejo_proto::{MissionSeq, MonoTime};

use super::{TargetWatch, Vehicle};
use crate::modes::ModeFamily;
use crate::request::VehicleEvent;
use crate::telemetry::{MissionState, Severity};

/// Distance of the target from the item's position above which it counts as different, metres.
const ELSEWHERE_M: f64 = 50.0;
/// How long it must differ. The target is reported twice a second, as is MISSION_CURRENT: the alarm comes within 3 s.
const FOR_AT_LEAST: Duration = Duration::from_millis(1_400);
/// Number of reports that must show it.
const REPORTS: u32 = 3;
/// Age above which a report is outdated.
const OUTDATED: Duration = Duration::from_secs(3);
/// Error of a target from NAV_CONTROLLER_OUTPUT as a share of the distance: bearings are whole degrees, and position
/// and distance are of different times.
const BEARING_ERROR: f64 = 0.05;
/// The target of an item that a plane flies to directly.
fn target_of(item: &MissionItem) -> Option<GeoPoint> {
    let is_own_position = matches!(
        item.command,
        Command::NAV_WAYPOINT
            | Command::NAV_LOITER_UNLIM
            | Command::NAV_LOITER_TURNS
            | Command::NAV_LOITER_TIME
            | Command::NAV_LOITER_TO_ALT
            | Command::NAV_LAND
    );
    item.point().filter(|_| is_own_position)
}

impl Vehicle {
    /// The plane reports its target.
    pub(super) fn on_target(&mut self, target: &POSITION_TARGET_GLOBAL_INT_DATA, now: MonoTime) {
        self.target.told_at = Some(now);
        let (lat_deg, lon_deg) = (f64::from(target.lat_int) / 1e7, f64::from(target.lon_int) / 1e7);
        if let Some(point) = GeoPoint::new(lat_deg, lon_deg).ok().filter(|_| target.lat_int != 0 || target.lon_int != 0)
        {
            self.compare_target(point, 0.0, false, now);
        }
    }

    /// The plane reports distance and bearing of its target.
    pub(super) fn on_nav(&mut self, now: MonoTime) {
        if self.target.told_at.is_some_and(|at| now.since(at) < OUTDATED) {
            return;
        }
        let (Some(nav), Some(position)) = (self.telemetry.nav, self.telemetry.position) else { return };
        let (Some(bearing_deg), Some(wp_distance_m)) = (nav.value.target_bearing_deg, nav.value.wp_distance_m) else {
            return;
        };
        let (Some(lat_deg), Some(lon_deg)) = (position.value.lat_deg, position.value.lon_deg) else { return };
        let Ok(here) = GeoPoint::new(lat_deg, lon_deg) else { return };
        // 65,535 m stands for this distance or more.
        if now.since(position.at) > Duration::from_secs(1) || wp_distance_m >= 65_535.0 {
            return;
        }
        let error_m = BEARING_ERROR * wp_distance_m + 20.0;
        self.compare_target(direct(here, bearing_deg, wp_distance_m), error_m, true, now);
    }

    fn compare_target(&mut self, target: GeoPoint, error_m: f64, is_by_bearing: bool, now: MonoTime) {
        let Some((seq, expected)) = self.expected_target(is_by_bearing, now) else {
            (self.target.seq, self.target.elsewhere) = (None, None);
            return;
        };
        if self.target.seq.replace(seq) != Some(seq) {
            self.target.elsewhere = None;
        }
        let distance_m = distance_m(target, expected);
        if distance_m <= ELSEWHERE_M + error_m {
            self.target.elsewhere = None;
            if self.target.alarmed.take().is_some() {
                self.event(VehicleEvent::TargetAsPlanned { seq: MissionSeq(seq) });
            }
            return;
        }
        let (since, reports) = self.target.elsewhere.unwrap_or((now, 0));
        self.target.elsewhere = Some((since, reports + 1));
        let is_sure = now.since(since) >= FOR_AT_LEAST && reports + 1 >= REPORTS;
        if is_sure && self.target.alarmed.replace((seq, distance_m)).is_none_or(|(alarmed, _)| alarmed != seq) {
            self.event(VehicleEvent::TargetElsewhere { seq: MissionSeq(seq), distance_m });
            let item = seq + 1 - self.first_seq();
            let (lat_deg, lon_deg) = (target.lat_deg(), target.lon_deg());
            let text = format!(
                "it flies to {lat_deg:.5}, {lon_deg:.5}: {distance_m:.0} m from item {item} of the plan that was read from it; \
                 be ready to take over or to change the mode"
            );
            self.note(Severity::CRITICAL, text, now);
            // Another station may have changed the mission where we did not hear it.
            self.doubt_copy(PlanKind::Mission, now);
        }
    }

    /// Distance of the plane's target from the current item of its plan, while that is an alarm, metres.
    pub(super) fn target_off_m(&self) -> Option<f64> {
        self.target.alarmed.map(|(_, distance_m)| distance_m)
    }

    /// The mission is not flown: its target is not checked.
    pub(super) fn forget_target(&mut self) {
        self.target = TargetWatch { told_at: self.target.told_at, ..TargetWatch::default() };
    }

    /// The current item and the target it implies; `None` where that is unknown.
    fn expected_target(&self, is_by_bearing: bool, now: MonoTime) -> Option<(u16, GeoPoint)> {
        let heartbeat = self.telemetry.heartbeat.map(|heartbeat| heartbeat.value)?;
        let is_flown = heartbeat.is_armed && heartbeat.mode.follows_mission();
        if !is_flown || heartbeat.mode.family != ModeFamily::ArduPlane {
            return None;
        }
        let current = self.telemetry.mission.filter(|mission| now.since(mission.at) < OUTDATED)?.value;
        if !matches!(current.state, None | Some(MissionState::Active)) {
            return None;
        }
        let mission = self.mission()?;
        // After an interruption the plane repeats a part of its way, where no item is.
        if mission.items.iter().any(|item| item.command == Command::DO_SET_RESUME_REPEAT_DIST) {
            return None;
        }
        let item = mission.items.get(usize::from(current.seq.checked_sub(self.first_seq())?))?;
        // On a landing approach the controller aims beyond the point; in a loiter, at its circle.
        let is_comparable = !is_by_bearing || item.command == Command::NAV_WAYPOINT;
        Some((current.seq, target_of(item).filter(|_| is_comparable)?))
    }
}
