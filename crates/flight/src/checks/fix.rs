//! Computed fixes: for a finding, a change of the items that resolves it.
//!
//! Each is verified before it is offered: applied, checked and rehearsed again. One that leaves the finding, or adds an
//! error, is dropped.

use super::finding::{Finding, FindingCode, FindingKind, Severity};
use super::rehearsed::look;
use super::{CheckContext, check_plan, with_flown};
use crate::approaches::{Site, landing_alternatives, options_of};
use crate::geodesy::{GeoPoint, direct, inverse};
use crate::landing::LandingOptions;
use crate::plan::{Command, MavFrame, MissionItem, Plan};
use crate::progress::target;
use crate::rehearsal::{Aircraft, Autoland, Conditions};
use crate::words::figured;

/// Plans that are looked through at the most, with what each would be after a change.
const MOST_TRIES: usize = 32;
/// Budget of simulated flight time, s, after which no further fix is tried: some
/// seconds of a processor.
const MOST_FLOWN_S: f64 = 72.0 * 3_600.0;
/// Landings that are tried of those there are to choose from.
const MOST_LANDINGS: usize = 4;
/// Height of a take-off that is added, m above home.
const TAKEOFF_M: f64 = 50.0;
/// Pitch of a take-off that is added, degrees (`TKOFF_LVL_PITCH`).
const TAKEOFF_PITCH_DEG: f64 = 15.0;
/// How much a way into the ground is raised by, m: the least that helps.
const RAISES_M: [f64; 3] = [30.0, 60.0, 120.0];
/// How far a waypoint that is flown by is moved away from the one before, m: likewise.
const MOVES_M: [f64; 5] = [50.0, 100.0, 150.0, 200.0, 300.0];
/// Values of `RTL_AUTOLAND` with which a return flies the landing sequence: straight to the landing, or home first.
const FLY_LANDING: [f64; 2] = [2.0, 1.0];

figured! {
    /// Kind of fix, with its figures. `code` is stable; a figure's name ends in its unit.
    #[cfg_attr(feature = "describe", serde(tag = "does", content = "with", rename_all = "kebab-case"))]
    FixKind {
        /// Sets a parameter of the item.
        SetParam = "set-param" {
            /// English name of the parameter.
            label: &'static str,
            /// Its value.
            value: f64,
            /// Symbol of the unit; empty when there is none.
            unit: &'static str,
        },
        /// Deletes the item.
        DeleteItem = "delete-item" {},
        /// Puts a take-off first.
        AddTakeoff = "add-takeoff" {
            /// Height that it climbs to, above home.
            alt_m: f64,
        },
        /// Climbs to another height.
        RaiseTakeoff = "raise-takeoff" {
            /// Height that it climbs to, above home.
            alt_m: f64,
        },
        /// Ends the mission with a landing at home.
        AddLanding = "add-landing" {
            /// Course of its final leg.
            course_deg: f64,
        },
        /// Lays the landing out again at the same point.
        TurnLanding = "turn-landing" {
            /// Course of its final leg.
            course_deg: f64,
        },
        /// Climbs or sinks in a circle before the item.
        AddCircle = "add-circle" {
            /// Height that it is left at, as the item's counts.
            alt_m: f64,
        },
        /// Raises the item, and the one before.
        Raise = "raise" {
            /// By how much.
            difference_m: f64,
        },
        /// Moves the item away from the one before.
        MoveAway = "move-away" {
            /// By how much.
            distance_m: f64,
        },
        /// Sets a parameter of the vehicle. The items stay.
        SetParameter = "set-parameter" {
            /// Its name.
            name: &'static str,
            /// Its value.
            value: f64,
        },
    }
}

/// A remedy that was tried: with these items in the place of others, the finding is gone.
#[derive(Debug, Clone, PartialEq)]
pub struct Fix {
    /// The kind of change, with its figures.
    pub kind: FixKind,
    /// Index of the first item that it replaces; the number of items: it adds at the end.
    pub first: usize,
    /// How many it replaces.
    pub count: usize,
    /// What stands there then.
    pub items: Vec<MissionItem>,
}

impl Fix {
    /// The plan with the fix applied. Jump targets follow their items; a jump to a deleted item leads to what replaced
    /// it.
    pub fn applied(&self, plan: &Plan) -> Plan {
        let mut plan = plan.clone();
        let (first, count, added) = (self.first, self.count, self.items.len());
        let moved = |number: f64| match number - 1.0 {
            index if index >= (first + count) as f64 => number + added as f64 - count as f64,
            index if index >= (first + added.max(1)) as f64 => (first + 1) as f64,
            _ => number,
        };
        let items = &mut plan.mission.items;
        for item in items.iter_mut().filter(|item| item.command == Command::DO_JUMP) {
            if let Some(number) = item.params[0].as_mut().filter(|number| **number >= 1.0) {
                *number = moved(*number);
            }
        }
        // An item that is replaced by itself with other values keeps where it jumps to.
        items.splice(first..first + count, self.items.iter().cloned());
        plan
    }

    /// English description.
    pub fn message(&self) -> String {
        match &self.kind {
            FixKind::SetParam { label, value, unit } => format!("set {label} to {value} {unit}").trim_end().to_owned(),
            FixKind::DeleteItem {} => format!("delete item {}", self.first + 1),
            FixKind::AddTakeoff { alt_m } => format!("put a take-off to {alt_m} m first"),
            FixKind::RaiseTakeoff { alt_m } => format!("climb to {alt_m} m"),
            FixKind::AddLanding { course_deg } => format!("add a landing at home on course {course_deg:.0}°"),
            FixKind::TurnLanding { course_deg } => format!("land on course {course_deg:.0}°"),
            FixKind::AddCircle { alt_m } => format!("add a circle to {alt_m} m before it"),
            FixKind::Raise { difference_m } => format!("raise it by {difference_m:.0} m, and the item before"),
            FixKind::MoveAway { distance_m } => format!("move it {distance_m:.0} m away from the item before"),
            FixKind::SetParameter { name, value } => format!("set {name} to {value}"),
        }
    }
}

/// Everything that a plan is checked against.
#[derive(Clone, Copy)]
pub struct Inspection<'a> {
    /// Known facts of the vehicle.
    pub context: CheckContext,
    /// Conditions of the rehearsal; `None`: no rehearsal.
    pub conditions: Option<Conditions<'a>>,
    /// Height above the ground that the flight should keep, m.
    pub clearance_m: f64,
}

impl Inspection<'_> {
    /// The findings of checks and rehearsal.
    pub fn findings(&self, plan: &Plan) -> Vec<Finding> {
        self.look(plan).0
    }

    /// The same, and how long all that is flown for it takes, s.
    fn look(&self, plan: &Plan) -> (Vec<Finding>, f64) {
        let drawn = check_plan(plan, &self.context);
        match self.conditions.as_ref().and_then(|conditions| look(plan, conditions, self.clearance_m).ok()) {
            Some(looked) => (with_flown(drawn, looked.findings), looked.all_s),
            None => (drawn, 0.0),
        }
    }
}

/// Findings of a plan that a change of its items, or of one parameter of the vehicle, resolves, each with the first
/// such change that was found. Of findings of one kind with the same item the first alone.
pub fn fixes(plan: &Plan, inspection: &Inspection<'_>) -> Vec<(Finding, Fix)> {
    let (found, mut flown_s) = inspection.look(plan);
    let mut tries = MOST_TRIES;
    let mut fixed: Vec<(Finding, Fix)> = Vec::new();
    for finding in &found {
        if fixed.iter().any(|(other, _)| other.item == finding.item && other.code() == finding.code()) {
            continue;
        }
        for fix in candidates(plan, inspection, finding) {
            if tries == 0 || flown_s > MOST_FLOWN_S {
                return fixed;
            }
            tries -= 1;
            let (resolves, took_s) = tried(plan, inspection, &found, finding, &fix);
            flown_s += took_s;
            if resolves {
                fixed.push((finding.clone(), fix));
                break;
            }
        }
    }
    fixed
}

/// Whether the finding is gone after a change, and no error is there that was not; and how long all that is flown for
/// it takes, s.
fn tried(plan: &Plan, inspection: &Inspection<'_>, before: &[Finding], finding: &Finding, fix: &Fix) -> (bool, f64) {
    let mut inspection = *inspection;
    let plane: Aircraft;
    if let FixKind::SetParameter { value, .. } = fix.kind {
        inspection.context.finds_landing = Some(true);
        if let Some(conditions) = &mut inspection.conditions {
            plane = Aircraft { autoland: Autoland::of_parameter(value), ..*conditions.plane };
            conditions.plane = &plane;
        }
    }
    let (after, flown_s) = inspection.look(&fix.applied(plan));
    let count = |found: &[Finding], code: FindingCode, is_error: bool| {
        found.iter().filter(|one| one.code() == code && (!is_error || one.severity == Severity::Error)).count()
    };
    let is_gone = count(&after, finding.code(), false) < count(before, finding.code(), false);
    let is_worse = |one: &Finding| {
        one.severity == Severity::Error && count(&after, one.code(), true) > count(before, one.code(), true)
    };
    (is_gone && !after.iter().any(is_worse), flown_s)
}

/// Changes that may resolve a finding, the best first.
fn candidates(plan: &Plan, inspection: &Inspection<'_>, finding: &Finding) -> Vec<Fix> {
    let items = &plan.mission.items;
    let Some(number) = finding.item else { return Vec::new() };
    let index = number - 1;
    let Some(item) = items.get(index) else { return Vec::new() };
    let change = |kind: FixKind, item: MissionItem| vec![Fix { kind, first: index, count: 1, items: vec![item] }];
    let param = |param: usize, label: &'static str, value: f64, unit: &'static str| {
        let mut item = item.clone();
        item.params[param - 1] = Some(value);
        change(FixKind::SetParam { label, value, unit }, item)
    };
    let delete = || vec![Fix { kind: FixKind::DeleteItem {}, first: index, count: 1, items: Vec::new() }];
    match &finding.kind {
        FindingKind::EndlessJump {} => param(2, "Repeats", 1.0, ""),
        FindingKind::ParamOutOfRange { param: number, label, value, unit, min, max } => {
            let bound = if min.is_some_and(|min| *value < min) { *min } else { *max };
            bound.map_or_else(Vec::new, |bound| param(*number, label, bound, unit))
        }
        FindingKind::ParamChanged { param: number, label, kept, unit, is_unused, .. } => {
            param(*number, label, if *is_unused { 0.0 } else { *kept }, unit)
        }
        FindingKind::SpeedNotTaken { speed_m_s, min_m_s, max_m_s } => {
            let bound = if min_m_s.is_some_and(|min_m_s| *speed_m_s < min_m_s) { *min_m_s } else { *max_m_s };
            bound.map_or_else(Vec::new, |bound| param(2, "Speed", bound, "m/s"))
        }
        FindingKind::UnsupportedCommand {}
        | FindingKind::IgnoredCommand { .. }
        | FindingKind::IdleJump {}
        | FindingKind::LandStartWithoutLanding { has_landing: false } => delete(),
        FindingKind::LandStartDisabled {} => {
            let kind = |value| FixKind::SetParameter { name: "RTL_AUTOLAND", value };
            FLY_LANDING.map(|value| Fix { kind: kind(value), first: index, count: 0, items: Vec::new() }).to_vec()
        }
        FindingKind::NoTakeoff {} => home_of(plan, inspection).map_or_else(Vec::new, |home| {
            let takeoff = MissionItem::takeoff(home.lat_deg(), home.lon_deg(), TAKEOFF_M, TAKEOFF_PITCH_DEG);
            let kind = FixKind::AddTakeoff { alt_m: TAKEOFF_M };
            vec![Fix { kind, first: 0, count: 0, items: vec![takeoff] }]
        }),
        FindingKind::TakeoffTooLow { .. } => {
            let mut params = item.params;
            params[6] = Some(TAKEOFF_M);
            let takeoff = MissionItem { frame: MavFrame::GlobalRelativeAlt, params, ..item.clone() };
            change(FixKind::RaiseTakeoff { alt_m: TAKEOFF_M }, takeoff)
        }
        FindingKind::NoLanding {} => home_of(plan, inspection).map_or_else(Vec::new, |home| {
            let kind = |course_deg| FixKind::AddLanding { course_deg };
            landings(plan, inspection, items.len(), 0, home, Some(0.0), &kind)
        }),
        FindingKind::SteepApproach { .. }
        | FindingKind::FlatApproach {}
        | FindingKind::LandsOff { .. }
        | FindingKind::LandsDownwind { .. } => turned(plan, inspection, index),
        FindingKind::LandStartWithoutLanding { has_landing: true } => turned(plan, inspection, index + 1),
        FindingKind::HeightNotReached { .. } => circles(plan, inspection, index),
        FindingKind::WaypointMissed { .. } if item.command == Command::NAV_WAYPOINT => {
            let Some((before, at)) = place_before(plan, inspection, index).zip(item.point()) else { return Vec::new() };
            let course_deg = inverse(before, at).bearing_start_deg;
            let moved = |distance_m: &f64| {
                let to = direct(at, course_deg, *distance_m);
                let mut params = item.params;
                (params[4], params[5]) = (Some(to.lat_deg()), Some(to.lon_deg()));
                let items = vec![MissionItem { params, ..item.clone() }];
                Fix { kind: FixKind::MoveAway { distance_m: *distance_m }, first: index, count: 1, items }
            };
            MOVES_M.iter().map(moved).collect()
        }
        FindingKind::NearGround { clearance_m, wanted_m, .. } => {
            let least_m = (wanted_m - clearance_m).ceil() + 1.0;
            [least_m, 1.5 * least_m, 2.0 * least_m].iter().filter_map(|by_m| raised(plan, index, by_m.ceil())).collect()
        }
        FindingKind::FliesIntoGround { .. } => RAISES_M.iter().filter_map(|by_m| raised(plan, index, *by_m)).collect(),
        _ => Vec::new(),
    }
}

fn home_of(plan: &Plan, inspection: &Inspection<'_>) -> Option<GeoPoint> {
    inspection.context.home.or(plan.mission.home)?.point().ok()
}

/// The place that is flown to before an item; home before the first.
fn place_before(plan: &Plan, inspection: &Inspection<'_>, index: usize) -> Option<GeoPoint> {
    plan.mission.items[..index].iter().rev().find_map(target).or_else(|| home_of(plan, inspection))
}

/// Landings at a point, in the place of some items.
fn landings(
    plan: &Plan,
    inspection: &Inspection<'_>,
    first: usize,
    count: usize,
    point: GeoPoint,
    ground_rel_home_m: Option<f64>,
    kind: &dyn Fn(f64) -> FixKind,
) -> Vec<Fix> {
    let Some(conditions) = inspection.conditions else { return Vec::new() };
    let wind = conditions.air.wind;
    let old = &plan.mission.items[first..first + count];
    let had_land_start = old.iter().any(|item| item.command == Command::DO_LAND_START);
    let options = LandingOptions {
        coming_from: place_before(plan, inspection, first),
        ground_rel_home_m,
        has_land_start: had_land_start || inspection.context.finds_landing == Some(true),
        ..options_of(conditions.plane, Some(wind))
    };
    let found = landing_alternatives(Site::Point(point), &options, &conditions).unwrap_or_default();
    let fix =
        |landing: crate::landing::Landing| Fix { kind: kind(landing.course_deg), first, count, items: landing.items };
    found.into_iter().take(MOST_LANDINGS).map(|one| fix(one.landing)).collect()
}

/// The landing at an index on another course: with the circle down and the start of the sequence that belong to it.
fn turned(plan: &Plan, inspection: &Inspection<'_>, index: usize) -> Vec<Fix> {
    let items = &plan.mission.items;
    let Some(land) = items.get(index).filter(|item| item.command == Command::NAV_LAND) else { return Vec::new() };
    let Some(point) = land.point() else { return Vec::new() };
    let is_before = |index: usize, command: Command| index > 0 && items[index - 1].command == command;
    let mut first = index;
    if is_before(first, Command::NAV_LOITER_TO_ALT) {
        first -= 1;
    }
    if is_before(first, Command::DO_LAND_START) {
        first -= 1;
    }
    let ground_m = land.alt_m().filter(|_| land.frame == MavFrame::GlobalRelativeAlt);
    let kind = |course_deg| FixKind::TurnLanding { course_deg };
    landings(plan, inspection, first, index + 1 - first, point, ground_m, &kind)
}

/// A circle to the height of an item, where the plane comes from, or at the item.
fn circles(plan: &Plan, inspection: &Inspection<'_>, index: usize) -> Vec<Fix> {
    let item = &plan.mission.items[index];
    let Some((alt_m, at)) = item.alt_m().zip(item.point()) else { return Vec::new() };
    let usual = Aircraft::default();
    let plane = inspection.conditions.map_or(&usual, |conditions| conditions.plane);
    let circle = |at: GeoPoint| {
        let circle = MissionItem::loiter_to_alt(at.lat_deg(), at.lon_deg(), alt_m, plane.loiter_radius_m);
        let items = vec![MissionItem { frame: item.frame, ..circle }];
        Fix { kind: FixKind::AddCircle { alt_m }, first: index, count: 0, items }
    };
    place_before(plan, inspection, index).into_iter().chain([at]).map(circle).collect()
}

/// An item and the one that is flown to before it, higher; `None` where one of them cannot be raised.
fn raised(plan: &Plan, index: usize, by_m: f64) -> Option<Fix> {
    let items = &plan.mission.items;
    let can_rise = |item: &MissionItem| item.command.is_destination() && !item.command.is_landing();
    can_rise(&items[index]).then_some(())?;
    let first = items[..index].iter().rposition(|item| target(item).is_some());
    let first = first.filter(|before| can_rise(&items[*before])).unwrap_or(index);
    let mut changed = items[first..=index].to_vec();
    for item in changed.iter_mut().filter(|item| can_rise(item)) {
        item.params[6] = Some(item.alt_m()? + by_m);
    }
    Some(Fix { kind: FixKind::Raise { difference_m: by_m }, first, count: index + 1 - first, items: changed })
}

#[cfg(test)]
#[path = "fix_tests.rs"]
mod tests;
