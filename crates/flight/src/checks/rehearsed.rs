//! What a rehearsed flight shows to be wrong or doubtful in a plan.

use super::finding::{Finding, FindingCode, FindingKind, Severity};
use crate::geodesy::{GeoPoint, inverse, wrap_180_deg};
use crate::landing::Wind;
use crate::plan::{Command, MissionItem, Plan};
use crate::rehearsal::{Conditions, Ending, GroundLack, Rehearsal, Sample, Trigger, WhatIf, rehearse, what_ifs};

/// Difference of height at a waypoint that is worth a word, m: less is what turns and gusts bring.
const HEIGHT_OFF_M: f64 = 15.0;
/// How far beyond and before its point a touch-down may lie, m. An ArduPlane touches some 40 m before it and rolls there.
const LONG_M: f64 = 30.0;
const SHORT_M: f64 = 80.0;
/// Wind from behind at the touch-down that is worth a word, m/s.
const TAILWIND_M_S: f64 = 2.0;
/// Height above the ground that a plan should keep unless a person says another, m.
pub const CLEARANCE_M: f64 = 30.0;
/// Part of the height above the field that must be left above the ground after a take-off and on an approach.
const FREE_PART: f64 = 0.5;
/// Height above the field below which that is not asked, m: terrain data are off by as much (SRTM is mostly within 8 m).
const FIELD_M: f64 = 15.0;
/// How far home's height may be off the ground there, m; an ArduPlane corrects by up to 30 (`TERRAIN_OFS_MAX`).
const HOME_OFF_M: f64 = 30.0;

/// Moments of a flight that a return is rehearsed from.
const RETURNS: u32 = 24;

/// Parts of a final leg after which a landing is broken off, and how long before the touch-down it is left at that, s: a plane that has begun
/// to flare is nearly down.
const GO_AROUNDS: [f64; 4] = [0.25, 0.5, 0.75, 1.0];
const FLARES_S: f64 = 4.0;

/// Flies a plan, and finds what its flight shows to be wrong or doubtful, in the order of the items; each item once for each kind. From
/// 24 moments a return is flown too, and from four of the final leg a go-around. `None` as [`rehearse`].
///
/// `clearance_m` is the height above the ground that it should keep where that is known ([`CLEARANCE_M`] is usual). Until the plane has
/// climbed to it or has reached the item after the first, and on the approach to a landing, half the height above the field is enough.
#[must_use]
pub fn rehearse_and_check(
    plan: &Plan,
    conditions: &Conditions<'_>,
    clearance_m: f64,
) -> Option<(Rehearsal, Vec<Finding>)> {
    let Looked { flown, findings, .. } = look(plan, conditions, clearance_m)?;
    Some((flown, findings))
}

/// A plan that was flown and looked at.
pub(super) struct Looked {
    pub flown: Rehearsal,
    pub findings: Vec<Finding>,
    /// How long all that was flown for it takes, s.
    pub all_s: f64,
}

/// As [`rehearse_and_check`].
pub(super) fn look(plan: &Plan, conditions: &Conditions<'_>, clearance_m: f64) -> Option<Looked> {
    let flown = rehearse(plan, conditions)?;
    let mut moments: Vec<f64> =
        (1..=RETURNS).map(|n| flown.duration_s * f64::from(n) / f64::from(RETURNS + 1)).collect();
    moments.extend(on_final_legs(plan, &flown));
    moments.sort_by(f64::total_cmp);
    let asked = what_ifs(plan, conditions, &[Trigger::ReturnAsked, Trigger::GoAround], &moments)?;
    let others_s = asked.iter().filter_map(|asked| Some(asked.flown.as_ref()?.duration_s - asked.at.time_s));
    let all_s = 2.0 * flown.duration_s + others_s.sum::<f64>();
    let (returns, go_arounds): (Vec<_>, Vec<_>) =
        asked.into_iter().partition(|asked| asked.trigger == Trigger::ReturnAsked);
    let mut found = Found { plan, findings: Vec::new() };
    found.flight(&flown, conditions.air.wind);
    found.ground(&flown, clearance_m);
    found.battery(&flown);
    found.returns(&returns, conditions.air.wind);
    found.go_arounds(&go_arounds);
    let Found { mut findings, .. } = found;
    findings.sort_by_key(|finding| finding.item);
    Some(Looked { flown, findings, all_s })
}

/// What is wrong or doubtful in a plan that was rehearsed: what its lines show but for the legs that look short, for the flight shows whether
/// they are, and what the flight shows.
#[must_use]
pub fn with_flown(mut drawn: Vec<Finding>, flown: impl IntoIterator<Item = Finding>) -> Vec<Finding> {
    drawn.retain(|finding| finding.code() != FindingCode::ShortLeg);
    drawn.extend(flown);
    drawn
}

/// What was found so far.
struct Found<'a> {
    plan: &'a Plan,
    findings: Vec<Finding>,
}

impl Found<'_> {
    fn tell(&mut self, severity: Severity, index: usize, kind: FindingKind) {
        let item = self.plan.mission.items.get(index).map(|item| (index, item));
        let finding = Finding::new(severity, kind, item);
        let is_new = |before: &Finding| before.item != finding.item || before.code() != finding.code();
        if self.findings.iter().all(is_new) {
            self.findings.push(finding);
        }
    }

    /// Zones of the fence that a track lies on the wrong side of, counted from 1, and the items flown there.
    fn left_zones(&self, flown: &Rehearsal) -> Vec<(Option<usize>, usize)> {
        let fence = &self.plan.fence;
        if fence.zones.is_empty() || fence.fault().is_some() {
            return Vec::new();
        }
        let zone = |sample: &Sample| Some((sample.index, fence.forbidden_by(sample.point)? + 1));
        flown.thinned(2.0).into_iter().filter_map(zone).collect()
    }

    /// Returns from moments of the flight, told at the item that is flown then.
    fn returns(&mut self, returns: &[WhatIf], wind: Wind) {
        for asked in returns {
            let (Some(index), Some(flown)) = (asked.at.index, &asked.flown) else { continue };
            // From a landing's last metres nothing returns.
            if self.plan.mission.items.get(index).is_some_and(|item| item.command == Command::NAV_LAND) {
                continue;
            }
            // What the mission itself does there is told already.
            let own: Vec<FindingCode> =
                self.findings.iter().filter(|finding| finding.item == Some(index + 1)).map(Finding::code).collect();
            match flown.ending {
                Ending::Ground => self.tell(Severity::Error, index, FindingKind::ReturnHitsGround {}),
                Ending::Held if !own.contains(&FindingCode::HeldByWind) => {
                    self.tell(Severity::Warning, index, FindingKind::ReturnHeldByWind { wind_m_s: wind.speed_m_s });
                }
                _ => {}
            }
            let zones = if own.contains(&FindingCode::LeavesFence) { Vec::new() } else { self.left_zones(flown) };
            for (_, zone) in zones {
                self.tell(Severity::Warning, index, FindingKind::ReturnLeavesFence { zone });
            }
        }
    }

    /// Landings broken off.
    fn go_arounds(&mut self, asked: &[WhatIf]) {
        for asked in asked {
            let hits = asked.flown.as_ref().is_some_and(|flown| flown.ending == Ending::Ground);
            if let Some(index) = asked.at.index.filter(|_| hits) {
                self.tell(Severity::Warning, index, FindingKind::GoAroundHitsGround {});
            }
        }
    }

    fn flight(&mut self, flown: &Rehearsal, wind: Wind) {
        for passage in &flown.passages {
            if passage.is_missed {
                let distance_m = passage.nearest_m.unwrap_or(f64::NAN);
                self.tell(Severity::Warning, passage.item, FindingKind::WaypointMissed { distance_m });
            }
            if let Some(off_m) = passage.height_error_m.filter(|off_m| off_m.abs() > HEIGHT_OFF_M) {
                let kind = FindingKind::HeightNotReached { difference_m: off_m.abs(), is_low: off_m < 0.0 };
                self.tell(Severity::Warning, passage.item, kind);
            }
        }
        for (index, zone) in self.left_zones(flown) {
            if let Some(index) = index {
                self.tell(Severity::Error, index, FindingKind::LeavesFence { zone });
            }
        }
        let last = flown.passages.last().map_or(0, |passage| passage.item);
        match flown.ending {
            Ending::Ground => {
                let at = flown.touch_down.or(flown.track.last().copied()).map(|sample| sample.point);
                let (lat_deg, lon_deg) = at.map_or((f64::NAN, f64::NAN), |at| (at.lat_deg(), at.lon_deg()));
                self.tell(Severity::Error, last, FindingKind::FliesIntoGround { lat_deg, lon_deg });
            }
            Ending::Held => self.tell(Severity::Error, last, FindingKind::HeldByWind { wind_m_s: wind.speed_m_s }),
            Ending::Landed => self.landing(flown, last, wind),
            _ => {}
        }
    }

    fn ground(&mut self, flown: &Rehearsal, clearance_m: f64) {
        for passage in &flown.passages {
            let Some(lack) = passage.lacks_ground else { continue };
            let item = self.plan.mission.items.get(passage.item);
            let alt_m = item.and_then(|item| item.alt_m().or(item.param(7)));
            let kind = FindingKind::GroundNotKnown { alt_m, is_off: lack == GroundLack::Off };
            self.tell(Severity::Warning, passage.item, kind);
        }
        let hits = flown.ending == Ending::Ground;
        for (index, sample, wanted_m) in too_near(self.plan, flown, clearance_m) {
            // What ends in the ground is said once.
            if !(hits && flown.passages.last().is_some_and(|last| last.item == index)) {
                let near_m = sample.clearance_m().unwrap_or(f64::NAN);
                let (lat_deg, lon_deg) = (sample.point.lat_deg(), sample.point.lon_deg());
                let kind = FindingKind::NearGround { clearance_m: near_m, wanted_m, lat_deg, lon_deg };
                self.tell(Severity::Warning, index, kind);
            }
        }
        if let Some(off_m) = flown.home_above_ground_m.filter(|off_m| off_m.abs() > HOME_OFF_M) {
            let kind = FindingKind::HomeOffGround { difference_m: off_m.abs(), is_above: off_m > 0.0 };
            self.findings.push(Finding::new(Severity::Warning, kind, None));
        }
    }

    /// Nothing where it is not known what is left.
    fn battery(&mut self, flown: &Rehearsal) {
        let Ok(battery) = flown.battery else { return };
        let (severity, index, kind) = match battery.empty_s {
            Some(time_s) => {
                let kind = FindingKind::BatteryEmpty { time_s, lacks_wh: -battery.left_wh };
                (Severity::Error, battery.empty_index, kind)
            }
            None if battery.is_below_reserve() => {
                let (left_pct, reserve_pct) = (100.0 * battery.left(), 100.0 * battery.reserve);
                let last = flown.passages.last().map(|passage| passage.item);
                (Severity::Warning, last, FindingKind::BatteryBelowReserve { left_pct, reserve_pct })
            }
            None => return,
        };
        match index {
            Some(index) => self.tell(severity, index, kind),
            None => self.findings.push(Finding::new(severity, kind, None)),
        }
    }

    fn landing(&mut self, flown: &Rehearsal, last: usize, wind: Wind) {
        let item = self.plan.mission.items.get(last).filter(|item| item.command == Command::NAV_LAND);
        let (Some(point), Some(down)) = (item.and_then(MissionItem::point), flown.touch_down) else { return };
        let beyond_m = beyond_m(point, down.point, down.course_deg);
        if !(-SHORT_M..=LONG_M).contains(&beyond_m) {
            let kind = FindingKind::LandsOff { distance_m: beyond_m.abs(), is_long: beyond_m > 0.0 };
            self.tell(Severity::Warning, last, kind);
        }
        let angle = wrap_180_deg(wind.from_deg - down.course_deg).to_radians();
        let tailwind_m_s = -wind.speed_m_s * angle.cos();
        if tailwind_m_s >= TAILWIND_M_S {
            self.tell(Severity::Warning, last, FindingKind::LandsDownwind { tailwind_m_s });
        }
    }
}

/// Moments of the final legs that a landing is broken off at, in order, s.
fn on_final_legs(plan: &Plan, flown: &Rehearsal) -> Vec<f64> {
    let Some(down) = flown.touch_down else { return Vec::new() };
    let lands = |item: usize| plan.mission.items.get(item).is_some_and(|item| item.command == Command::NAV_LAND);
    let last = flown.passages.last().filter(|passage| lands(passage.item) && passage.begins_s < down.time_s - FLARES_S);
    let from_s = last.map(|passage| passage.begins_s);
    let at = |part: f64| from_s.map(|from_s| from_s + (down.time_s - FLARES_S - from_s) * part);
    GO_AROUNDS.into_iter().filter_map(at).collect()
}

/// The worst place of each item on the way to which the plane comes too near the ground, and how much it should be above it there.
fn too_near<'a>(plan: &Plan, flown: &'a Rehearsal, clearance_m: f64) -> Vec<(usize, &'a Sample, f64)> {
    let mut worst: Vec<(usize, &Sample, f64)> = Vec::new();
    let touches_s = flown.touch_down.map_or(f64::INFINITY, |down| down.time_s);
    // What lands last is where the height above the field counts from on the way to it.
    let field_m = |index: usize| {
        let lands = |item: &&MissionItem| item.command == Command::NAV_LAND;
        plan.mission.items.get(index).filter(lands).map(|_| flown.touch_down.map_or(0.0, |down| down.height_m))
    };
    let away_s = flown.passages.get(1).and_then(|passage| passage.reached_s).unwrap_or(f64::INFINITY);
    let mut passages = flown.passages.iter().peekable();
    let mut item = 0;
    let mut has_climbed = false;
    for sample in flown.track.iter().filter(|sample| sample.time_s < touches_s) {
        while let Some(passage) = passages.next_if(|passage| passage.begins_s <= sample.time_s) {
            item = passage.item;
        }
        let Some(above_m) = sample.clearance_m() else { continue };
        has_climbed |= above_m >= clearance_m || sample.time_s > away_s;
        let wanted_m = match field_m(item) {
            None if has_climbed => clearance_m,
            field_m => {
                let height_m = sample.height_m - field_m.unwrap_or(0.0);
                if height_m < FIELD_M {
                    continue;
                }
                clearance_m.min(FREE_PART * height_m)
            }
        };
        if above_m >= wanted_m {
            continue;
        }
        match worst.iter_mut().find(|(index, ..)| *index == item) {
            Some(before) if before.2 - before.1.clearance_m().unwrap_or(f64::NAN) < wanted_m - above_m => {
                *before = (item, sample, wanted_m);
            }
            Some(_) => {}
            None => worst.push((item, sample, wanted_m)),
        }
    }
    worst
}

/// How far a place lies beyond a point along a course, m.
fn beyond_m(point: GeoPoint, place: GeoPoint, course_deg: f64) -> f64 {
    let line = inverse(point, place);
    line.distance_m * wrap_180_deg(line.bearing_start_deg - course_deg).to_radians().cos()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::checks::{CheckContext, check_plan};
    use crate::geodesy::direct;
    use crate::landing::{LandingOptions, design_landing};
    use crate::plan::{Fence, FenceShape, FenceZone, Home, Mission};
    use crate::rehearsal::{Air, Aircraft};

    const HOME: Home = Home { lat_deg: 40.3332, lon_deg: -3.7978, alt_amsl_m: 600.0 };

    fn waypoint(bearing_deg: f64, distance_m: f64, height_m: f64) -> MissionItem {
        let point = direct(HOME.point().unwrap(), bearing_deg, distance_m);
        MissionItem::waypoint(point.lat_deg(), point.lon_deg(), height_m)
    }

    fn found(items: Vec<MissionItem>, fence: Fence, wind: Wind) -> Vec<(FindingCode, Option<usize>)> {
        let takeoff = MissionItem::takeoff(HOME.lat_deg, HOME.lon_deg, 50.0, 12.0);
        let items = std::iter::once(takeoff).chain(items).collect();
        let plan = Plan { fence, ..Plan::from_mission(Mission { home: Some(HOME), items }) };
        let plane = Aircraft::default();
        let (_, found) = rehearse_and_check(&plan, &Conditions::new(&plane, Air::from(wind)), CLEARANCE_M).unwrap();
        found.iter().map(|finding| (finding.code(), finding.item)).collect()
    }

    #[test]
    fn a_plan_that_can_be_flown_is_let_be() {
        let landing = design_landing(
            HOME.point().unwrap(),
            &LandingOptions { course_deg: Some(270.0), ..LandingOptions::default() },
        );
        let items = [waypoint(0.0, 800.0, 70.0), waypoint(60.0, 1_500.0, 80.0)];
        let wind = Wind { from_deg: 280.0, speed_m_s: 5.0 };
        assert_eq!(found(items.into_iter().chain(landing.unwrap().items).collect(), Fence::default(), wind), []);
    }

    #[test]
    fn what_the_lines_do_not_show_is_found() {
        let calm = Wind::default();
        let high = vec![waypoint(0.0, 800.0, 70.0), waypoint(0.0, 1_200.0, 300.0)];
        assert_eq!(found(high, Fence::default(), calm), [(FindingCode::HeightNotReached, Some(3))]);
        // Back past the start of the turn: 60 m are less than the plane can turn in.
        let narrow = vec![waypoint(0.0, 1_000.0, 60.0), waypoint(3.4, 1_000.0, 60.0), waypoint(3.4, 900.0, 60.0)];
        let codes = found(narrow, Fence::default(), Wind { from_deg: 270.0, speed_m_s: 9.0 });
        assert!(codes.contains(&(FindingCode::WaypointMissed, Some(4))), "{codes:?}");
        // Straight on they are nothing to turn in.
        let straight = vec![waypoint(0.0, 1_000.0, 60.0), waypoint(0.0, 1_040.0, 60.0), waypoint(0.0, 1_500.0, 60.0)];
        let items =
            std::iter::once(MissionItem::takeoff(HOME.lat_deg, HOME.lon_deg, 50.0, 12.0)).chain(straight.clone());
        let mission = Mission { home: Some(HOME), items: items.collect() };
        let short = |found: &[Finding]| found.iter().any(|finding| finding.code() == FindingCode::ShortLeg);
        let drawn = check_plan(&Plan::from_mission(mission), &CheckContext::default());
        assert!(short(&drawn) && found(straight, Fence::default(), calm).is_empty());
        assert!(!short(&with_flown(drawn, [])));
        let center = HOME.point().unwrap();
        let zone = FenceZone { inclusion: true, shape: FenceShape::Circle { center, radius_m: 1_030.0 } };
        let fence = Fence { zones: vec![zone], return_point: None };
        let near = vec![waypoint(0.0, 1_000.0, 60.0), waypoint(-10.0, 990.0, 60.0)];
        let fast = Wind { from_deg: 180.0, speed_m_s: 9.0 };
        assert_eq!(found(near, fence, fast), [(FindingCode::LeavesFence, Some(3))]);
        assert_eq!(
            found(vec![waypoint(0.0, 2_000.0, -40.0)], Fence::default(), calm),
            [(FindingCode::FliesIntoGround, Some(2))]
        );
        let gale = Wind { from_deg: 0.0, speed_m_s: 30.0 };
        assert_eq!(
            found(vec![waypoint(0.0, 2_000.0, 60.0)], Fence::default(), gale),
            [(FindingCode::HeldByWind, Some(2))]
        );
        let land = MissionItem::land(HOME.lat_deg, HOME.lon_deg, 0.0);
        let steep = vec![waypoint(90.0, 1_500.0, 60.0), waypoint(90.0, 350.0, 60.0), land];
        let codes = found(steep, Fence::default(), Wind { from_deg: 90.0, speed_m_s: 6.0 });
        assert_eq!(codes, [(FindingCode::LandsOff, Some(4)), (FindingCode::LandsDownwind, Some(4))]);
    }

    #[test]
    fn a_battery_that_does_not_last_is_found() {
        use crate::rehearsal::{Airframe, Battery};
        let found = |charge: f64, power_w: Option<f64>| {
            let airframe = Airframe { power_cruise_w: power_w, ..Aircraft::default().airframe };
            let battery = Battery { capacity_mah: Some(2_200.0), voltage_v: Some(11.1), charge, ..Battery::default() };
            let plane = Aircraft { airframe, battery, ..Aircraft::default() };
            let takeoff = MissionItem::takeoff(HOME.lat_deg, HOME.lon_deg, 50.0, 12.0);
            let items = vec![
                takeoff,
                waypoint(0.0, 2_000.0, 60.0),
                MissionItem::action(Command::NAV_RETURN_TO_LAUNCH, [0.0; 4]),
            ];
            let plan = Plan::from_mission(Mission { home: Some(HOME), items });
            rehearse_and_check(&plan, &Conditions::new(&plane, Air::default()), CLEARANCE_M).unwrap().1
        };
        assert_eq!(found(1.0, Some(100.0)), []);
        let low = found(0.5, Some(100.0));
        assert_eq!((low[0].code(), low[0].severity), (FindingCode::BatteryBelowReserve, Severity::Warning));
        assert!(low[0].message.contains("20 % should be"), "{}", low[0].message);
        let empty = found(0.05, Some(100.0));
        assert_eq!((empty[0].code(), empty[0].severity), (FindingCode::BatteryEmpty, Severity::Error));
        assert_eq!(found(0.05, None), [], "nothing is found where the power is not known");
    }

    #[test]
    fn a_go_around_into_a_hill_is_found() {
        let plane = Aircraft::default();
        let options = LandingOptions { course_deg: Some(270.0), ..LandingOptions::default() };
        let landing = design_landing(HOME.point().unwrap(), &options).unwrap();
        let takeoff = MissionItem::takeoff(HOME.lat_deg, HOME.lon_deg, 50.0, 12.0);
        let items: Vec<_> = [takeoff, waypoint(0.0, 800.0, 70.0)].into_iter().chain(landing.items).collect();
        let plan = Plan::from_mission(Mission { home: Some(HOME), items });
        // A wall of a hill 120 m beyond the point, where only a plane that climbs away comes.
        let hill = |at: GeoPoint| {
            let line = inverse(HOME.point().unwrap(), at);
            let west_m = -line.distance_m * line.bearing_start_deg.to_radians().sin();
            Some(if west_m > 120.0 { 680.0 } else { 600.0 })
        };
        let conditions = Conditions {
            start: crate::rehearsal::Start::Ground { heading_deg: Some(90.0) },
            ..Conditions::new(&plane, Air::default())
        };
        let codes = |conditions: &Conditions<'_>| -> Vec<_> {
            let (_, found) = rehearse_and_check(&plan, conditions, CLEARANCE_M).unwrap();
            found.iter().map(|finding| (finding.code(), finding.item)).collect()
        };
        let about = (FindingCode::GoAroundHitsGround, Some(5));
        assert!(!codes(&conditions).contains(&about));
        assert!(codes(&Conditions { ground: Some(&hill), ..conditions }).contains(&about));
    }

    #[test]
    fn returns_from_the_way_are_looked_at() {
        // Round a hill of 120 m and a zone to keep out of, 1 km north; home is flat.
        let way = [(60.0, 1_200.0), (0.0, 2_400.0), (-60.0, 1_200.0)];
        let items = way.map(|(bearing_deg, distance_m)| waypoint(bearing_deg, distance_m, 80.0));
        let takeoff = MissionItem::takeoff(HOME.lat_deg, HOME.lon_deg, 50.0, 12.0);
        let items: Vec<MissionItem> = std::iter::once(takeoff).chain(items).collect();
        let center = direct(HOME.point().unwrap(), 0.0, 1_000.0);
        let zone = FenceZone { inclusion: false, shape: FenceShape::Circle { center, radius_m: 200.0 } };
        let fence = Fence { zones: vec![zone], return_point: None };
        let plan = Plan { fence, ..Plan::from_mission(Mission { home: Some(HOME), items }) };
        let hill =
            |point: GeoPoint| Some(600.0 + if crate::geodesy::distance_m(point, center) < 150.0 { 120.0 } else { 0.0 });
        let plane = Aircraft::default();
        let codes = |conditions: &Conditions<'_>| -> Vec<(FindingCode, Option<usize>)> {
            let (_, found) = rehearse_and_check(&plan, conditions, CLEARANCE_M).unwrap();
            found.iter().map(|finding| (finding.code(), finding.item)).collect()
        };
        let flat = Conditions::new(&plane, Air::default());
        let across = codes(&flat);
        assert!(across.contains(&(FindingCode::ReturnLeavesFence, Some(3))), "{across:?}");
        assert!(across.iter().all(|(code, _)| *code == FindingCode::ReturnLeavesFence), "{across:?}");
        let into = codes(&Conditions { ground: Some(&hill), ..flat });
        assert!(into.iter().any(|(code, _)| *code == FindingCode::ReturnHitsGround), "{into:?}");
        let higher = Aircraft { return_height_m: 150.0, ..plane };
        let over = codes(&Conditions { ground: Some(&hill), plane: &higher, ..flat });
        assert!(over.iter().all(|(code, _)| *code != FindingCode::ReturnHitsGround), "{over:?}");
    }

    #[test]
    fn the_ground_is_kept_away_from() {
        let calm = Air::default();
        let found_from = |height_m: f64, items: Vec<MissionItem>, ground: &crate::rehearsal::Ground<'_>| {
            let takeoff = MissionItem::takeoff(HOME.lat_deg, HOME.lon_deg, height_m, 12.0);
            let items = std::iter::once(takeoff).chain(items).collect();
            let plan = Plan::from_mission(Mission { home: Some(HOME), items });
            let plane = Aircraft::default();
            let conditions = Conditions { ground: Some(ground), ..Conditions::new(&plane, calm) };
            let (_, found) = rehearse_and_check(&plan, &conditions, CLEARANCE_M).unwrap();
            let of_flight = |finding: &Finding| finding.code() != FindingCode::ReturnHitsGround;
            let found = found.into_iter().filter(of_flight);
            found.map(|finding| (finding.item, finding.kind)).collect::<Vec<_>>()
        };
        let found = |items: Vec<MissionItem>, ground: &crate::rehearsal::Ground<'_>| found_from(50.0, items, ground);
        let away_m = |point: GeoPoint| inverse(HOME.point().unwrap(), point).distance_m;
        // A hill of 60 m, 2 km north of home, 300 m round.
        let top = direct(HOME.point().unwrap(), 0.0, 2_000.0);
        let hill = |point: GeoPoint| Some(600.0 + if inverse(top, point).distance_m < 300.0 { 60.0 } else { 0.0 });
        // Low all the way: the climb does not excuse that.
        let flat = |_: GeoPoint| Some(600.0);
        let creeping = vec![waypoint(0.0, 800.0, 20.0), waypoint(0.0, 2_000.0, 20.0), waypoint(90.0, 2_000.0, 20.0)];
        let creeping = found_from(20.0, creeping, &flat);
        assert!(matches!(creeping[..], [(Some(3), FindingKind::NearGround { .. }), (Some(4), _)]), "{creeping:?}");
        let high = || vec![waypoint(0.0, 800.0, 95.0), waypoint(0.0, 3_000.0, 95.0)];
        assert_eq!(found(high(), &hill), []);
        let [(Some(3), FindingKind::NearGround { clearance_m, wanted_m, lat_deg, .. })] =
            found(vec![waypoint(0.0, 800.0, 75.0), waypoint(0.0, 3_000.0, 75.0)], &hill)[..]
        else {
            panic!("15 m above the hill")
        };
        assert!((13.0..17.0).contains(&clearance_m) && wanted_m == 30.0, "{clearance_m}");
        assert!((lat_deg - top.lat_deg()).abs() < 0.003);
        let low = found(vec![waypoint(0.0, 800.0, 50.0), waypoint(0.0, 3_000.0, 50.0)], &hill);
        let [(Some(3), FindingKind::FliesIntoGround { lat_deg, .. })] = low[..] else { panic!("{low:?}") };
        assert!((lat_deg - top.lat_deg() + 0.0027).abs() < 0.0003, "at its foot");
        // Ground that rises as fast as the plane climbs after its take-off: half the height is not left.
        let rising = |point: GeoPoint| Some(600.0 + 0.08 * (away_m(point) - 200.0).clamp(0.0, 1_500.0));
        let codes: Vec<_> = found(high(), &rising).iter().map(|(item, kind)| (*item, kind.code())).collect();
        assert!(
            codes.contains(&(Some(2), FindingCode::NearGround))
                || codes.contains(&(Some(3), FindingCode::FliesIntoGround)),
            "{codes:?}"
        );
        // Home far from the ground: everything above sea level is off.
        let sea = |_: GeoPoint| Some(0.0);
        assert_eq!(found(high(), &sea), [(None, FindingKind::HomeOffGround { difference_m: 600.0, is_above: true })]);
        let frame = crate::plan::MavFrame::GlobalTerrainAlt;
        let terrain = MissionItem { frame, ..waypoint(0.0, 800.0, 75.0) };
        let unknown = |point: GeoPoint| (away_m(point) < 300.0).then_some(600.0);
        assert_eq!(
            found(vec![terrain], &unknown),
            [(Some(2), FindingKind::GroundNotKnown { alt_m: Some(75.0), is_off: false })]
        );
    }
}
