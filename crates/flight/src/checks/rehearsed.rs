//! Findings from a plan's rehearsed flight.

use super::border::Borders;
use super::finding::{Finding, FindingCode, FindingKind, Severity};
use crate::geodesy::{GeoPoint, inverse, wrap_180_deg};
use crate::landing::Wind;
use crate::plan::{Command, MissionItem, Plan};
use crate::rehearsal::{
    Conditions, Ending, GroundLack, NotRehearsed, Rehearsal, Sample, Trigger, WhatIf, rehearse, what_ifs,
};

/// Difference of height at a waypoint that is worth a word, m: less is what turns and gusts bring.
const HEIGHT_OFF_M: f64 = 15.0;
/// How far beyond and before its point a touch-down may lie, m. An ArduPlane touches some 40 m before it and rolls
/// there.
const LONG_M: f64 = 30.0;
const SHORT_M: f64 = 80.0;
/// Wind from behind at the touch-down that is worth a word, m/s.
const TAILWIND_M_S: f64 = 2.0;
/// Height above the ground that a plan should keep unless a person says another, m.
pub const CLEARANCE_M: f64 = 30.0;
/// Part of the height above the field that must be left above the ground after a take-off and on an approach.
const FREE_PART: f64 = 0.5;
/// Height above the field below which that is not asked, m: terrain data are off by as much (SRTM is mostly within 8
/// m).
const FIELD_M: f64 = 15.0;
/// How far home's height may be off the ground there, m; an ArduPlane corrects by up to 30 (`TERRAIN_OFS_MAX`).
const HOME_OFF_M: f64 = 30.0;

/// How far the pieces that are held against a fence may be off the track, m.
const OFF_TRACK_M: f64 = 2.0;

/// Moments of a flight that a return is rehearsed from.
const RETURNS: u32 = 24;

/// Parts of a final leg after which a landing is broken off, and how long before the touch-down it is left at that, s:
/// a plane that has begun to flare is nearly down.
const GO_AROUNDS: [f64; 4] = [0.25, 0.5, 0.75, 1.0];
const FLARES_S: f64 = 4.0;

/// Flies a plan, and finds what its flight shows to be wrong or doubtful, in the order of the items; each item once for
/// each kind. From 24 moments a return is flown too, and from four of the final leg a go-around.
///
/// `clearance_m` is the height above the ground that it should keep where that is known ([`CLEARANCE_M`] is usual).
/// Until the plane has climbed to it or has reached the item after the first, and on the approach to a landing, half
/// the height above the field is enough.
///
/// # Errors
/// As [`rehearse`].
pub fn rehearse_and_check(
    plan: &Plan,
    conditions: &Conditions<'_>,
    clearance_m: f64,
) -> Result<(Rehearsal, Vec<Finding>), NotRehearsed> {
    let Looked { flown, findings, .. } = look(plan, conditions, clearance_m)?;
    Ok((flown, findings))
}

/// A plan that was flown and looked at.
pub(super) struct Looked {
    pub flown: Rehearsal,
    pub findings: Vec<Finding>,
    /// How long all that was flown for it takes, s.
    pub all_s: f64,
}

/// As [`rehearse_and_check`].
pub(super) fn look(plan: &Plan, conditions: &Conditions<'_>, clearance_m: f64) -> Result<Looked, NotRehearsed> {
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
    let is_fenced = !plan.fence.zones.is_empty() && plan.fence.fault().is_none();
    let borders = is_fenced.then(|| Borders::of(&plan.fence, conditions.plane.is_fence_union));
    let mut found = Found { plan, borders, findings: Vec::new() };
    found.flight(&flown, conditions.air.wind);
    found.ground(&flown, clearance_m);
    found.battery(&flown);
    found.returns(&returns, conditions.air.wind);
    found.go_arounds(&go_arounds);
    let Found { mut findings, .. } = found;
    findings.sort_by_key(|finding| finding.item);
    Ok(Looked { flown, findings, all_s })
}

/// Merges the findings of a plan's lines with those of its rehearsal. Short legs are dropped, because the flight shows
/// whether they are too short.
pub fn with_flown(mut drawn: Vec<Finding>, flown: impl IntoIterator<Item = Finding>) -> Vec<Finding> {
    drawn.retain(|finding| finding.code() != FindingCode::ShortLeg);
    drawn.extend(flown);
    drawn
}

/// Findings collected so far.
struct Found<'a> {
    plan: &'a Plan,
    /// Of a sound fence with zones.
    borders: Option<Borders<'a>>,
    findings: Vec<Finding>,
}

impl Found<'_> {
    /// Adds a finding about an item; without one it is about the way home.
    fn tell(&mut self, severity: Severity, index: impl Into<Option<usize>>, kind: FindingKind) {
        let item = index.into().and_then(|index| Some((index, self.plan.mission.items.get(index)?)));
        let finding = Finding::new(severity, kind, item);
        let is_new = |before: &Finding| before.item != finding.item || before.code() != finding.code();
        if self.findings.iter().all(is_new) {
            self.findings.push(finding);
        }
    }

    /// Zones of the fence that a flight gets to the wrong side of, counted from 1, with the item flown then.
    fn left_zones<'f>(&self, flown: &'f Rehearsal) -> impl Iterator<Item = (Option<usize>, usize)> + use<'_, 'f> {
        let kept = if self.borders.is_some() { flown.thinned(OFF_TRACK_M) } else { Vec::new() };
        let mut before: Option<GeoPoint> = None;
        with_items(flown, kept).filter_map(move |(item, sample)| {
            let from = before.replace(sample.point).unwrap_or(sample.point);
            let zone = self.borders.as_ref()?.broken(from, sample.point)?;
            Some((item, zone + 1))
        })
    }

    /// Returns from moments of the flight, told at the item that is flown then.
    fn returns(&mut self, returns: &[WhatIf], wind: Wind) {
        for asked in returns {
            let (Some(index), Some(flown)) = (asked.at.index, &asked.flown) else { continue };
            // No return starts in the last metres of a landing.
            if self.plan.mission.items.get(index).is_some_and(|item| item.command == Command::NAV_LAND) {
                continue;
            }
            // The mission's own finding there is reported already.
            let own: Vec<FindingCode> =
                self.findings.iter().filter(|finding| finding.item == Some(index + 1)).map(Finding::code).collect();
            match flown.ending {
                Ending::Ground => self.tell(Severity::Error, index, FindingKind::ReturnHitsGround {}),
                Ending::Held if !own.contains(&FindingCode::HeldByWind) => {
                    self.tell(Severity::Warning, index, FindingKind::ReturnHeldByWind { wind_m_s: wind.speed_m_s });
                }
                _ => {}
            }
            let is_out = own.contains(&FindingCode::LeavesFence);
            let left = if is_out { None } else { self.left_zones(flown).next() };
            if let Some((_, zone)) = left {
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
        let left: Vec<_> = self.left_zones(flown).collect();
        for (index, zone) in left {
            self.tell(Severity::Error, index, FindingKind::LeavesFence { zone });
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
            if !(hits && flown.passages.last().map(|last| last.item) == index) {
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
        self.tell(severity, index, kind);
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

/// Samples of a flight until it touches the ground, each with the item that was begun last, or whose end the plane
/// returns after; `None` before the first.
fn with_items<'a>(
    flown: &'a Rehearsal,
    samples: impl IntoIterator<Item = &'a Sample>,
) -> impl Iterator<Item = (Option<usize>, &'a Sample)> {
    let touches_s = flown.touch_down.map_or(f64::INFINITY, |down| down.time_s);
    let mut passages = flown.passages.iter().peekable();
    let mut item = None;
    samples.into_iter().filter(move |sample| sample.time_s < touches_s).map(move |sample| {
        while let Some(passage) = passages.next_if(|passage| passage.begins_s <= sample.time_s) {
            item = Some(passage.item);
        }
        (item, sample)
    })
}

/// The worst place of each item on the way to which the plane comes too near the ground, and how much it should be
/// above it there.
fn too_near<'a>(plan: &Plan, flown: &'a Rehearsal, clearance_m: f64) -> Vec<(Option<usize>, &'a Sample, f64)> {
    let mut worst: Vec<(Option<usize>, &Sample, f64)> = Vec::new();
    // On the way to a landing the height above the field counts from its touch-down.
    let field_m = |index: usize| {
        let lands = |item: &&MissionItem| item.command == Command::NAV_LAND;
        plan.mission.items.get(index).filter(lands).map(|_| flown.touch_down.map_or(0.0, |down| down.height_m))
    };
    let away_s = flown.passages.get(1).and_then(|passage| passage.reached_s).unwrap_or(f64::INFINITY);
    let mut has_climbed = false;
    for (item, sample) in with_items(flown, &flown.track) {
        let Some(above_m) = sample.clearance_m() else { continue };
        has_climbed |= above_m >= clearance_m || sample.time_s > away_s;
        let wanted_m = match item.and_then(field_m) {
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
#[path = "rehearsed_tests.rs"]
mod tests;
