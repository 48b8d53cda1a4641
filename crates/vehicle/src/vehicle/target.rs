//! Whether the plane flies to where its plan says: the target that it tells, against the current item of the plan that was read
//! from it. A mission that was read back can still not be the one that is flown, and one that another station changed unseen is
//! another one.
//!
//! Only an ArduPlane that is armed and in AUTO, and only items whose target is their own position: waypoints, loiters and the
//! landing point. Its POSITION_TARGET_GLOBAL_INT names that position exactly, in the same moment as MISSION_CURRENT (recorded
//! flights: take-off, waypoints, loiters, a jump, landing). Where that message does not come, distance and bearing of
//! NAV_CONTROLLER_OUTPUT say it less well, for waypoints alone.

use std::time::Duration;

use vencejo_flight::geodesy::{GeoPoint, direct, distance_m};
use vencejo_flight::plan::{Command, MissionItem, PlanKind};
use vencejo_proto::dialect::POSITION_TARGET_GLOBAL_INT_DATA;
use vencejo_proto::{MissionSeq, MonoTime};

use super::{TargetWatch, Vehicle};
use crate::modes::ModeFamily;
use crate::request::VehicleEvent;
use crate::telemetry::{MissionState, Severity};

/// A target that is farther than this from the item's position is another one, metres.
const ELSEWHERE_M: f64 = 50.0;
/// How long it must be so. The target is told twice a second, MISSION_CURRENT too: the alarm comes within 3 s.
const FOR_AT_LEAST: Duration = Duration::from_millis(1_400);
/// Reports that must say so.
const REPORTS: u32 = 3;
/// What was said this long ago says nothing of now.
const OUTDATED: Duration = Duration::from_secs(3);
/// Share of the distance by which a target of NAV_CONTROLLER_OUTPUT may be off: bearings are whole degrees, and the position and
/// the distance are of different moments.
const BEARING_ERROR: f64 = 0.05;
/// DO_SET_RESUME_REPEAT_DIST: after an interruption the plane flies a part of its way once more, to where no item is.
const REPEATS_WAY: Command = Command(215);

/// Items that a plane flies to as they are.
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
    /// The plane tells its target.
    pub(super) fn on_target(&mut self, target: &POSITION_TARGET_GLOBAL_INT_DATA, now: MonoTime) {
        self.target.told_at = Some(now);
        let (lat_deg, lon_deg) = (f64::from(target.lat_int) / 1e7, f64::from(target.lon_int) / 1e7);
        if let Some(point) = GeoPoint::new(lat_deg, lon_deg).ok().filter(|_| target.lat_int != 0 || target.lon_int != 0)
        {
            self.compare_target(point, 0.0, false, now);
        }
    }

    /// It tells how far and in which direction its target is.
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
        // 65,535 m is "that far or farther".
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

    /// How far the plane's target is from the current item of its plan, while that is an alarm, metres.
    pub(super) fn target_off_m(&self) -> Option<f64> {
        self.target.alarmed.map(|(_, distance_m)| distance_m)
    }

    /// The mission is not flown (any more): where it leads to concerns nobody.
    pub(super) fn forget_target(&mut self) {
        self.target = TargetWatch { told_at: self.target.told_at, ..TargetWatch::default() };
    }

    /// The current item and where the plane must be flying to; `None` where nothing can be said.
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
        if mission.items.iter().any(|item| item.command == REPEATS_WAY) {
            return None;
        }
        let item = mission.items.get(usize::from(current.seq.checked_sub(self.first_seq())?))?;
        // In a landing approach the controller aims beyond the point; around a loiter at its circle.
        let is_comparable = !is_by_bearing || item.command == Command::NAV_WAYPOINT;
        Some((current.seq, target_of(item).filter(|_| is_comparable)?))
    }
}
