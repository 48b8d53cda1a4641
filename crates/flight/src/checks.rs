//! Checks of a plan before it is sent: errors and warnings.
//!
//! [`check_plan`] runs before every upload. An error means that the vehicle would refuse the plan, store
//! something else, or fly what cannot be intended; a warning is for the pilot to judge.

mod border;
mod english;
mod finding;
mod fix;
mod reach;
mod rehearsed;
mod surveyed;

pub use finding::{Datum, FenceFault, Finding, FindingCode, FindingKind, Missing, RallyFault, Severity};
pub use fix::{Fix, FixKind, Inspection, fixes};
pub use reach::{OutOfReach, REACH_M, first_out_of_reach, out_of_reach};
pub use rehearsed::{CLEARANCE_M, rehearse_and_check, with_flown};
pub use surveyed::check_survey;

pub use crate::words::Figure;

use self::border::Borders;
use crate::geodesy::{GeoPoint, distance_m};
use crate::guidance::GRAVITY_M_S2;
use crate::landing::STEEP_SLOPE;
use crate::plan::{
    Command, Home, MavFrame, MissionItem, Plan, ShapeFault, Storage, Support, Unit, Wanted, ardupilot_stored,
};
use crate::progress::{alt_amsl_m, jump_index, target};

/// Jumps that every ArduPilot board can track; large ones track 100.
const MAX_JUMPS: usize = 15;

/// How far below home a landing may lie without a word, m: fields slope, and hills are taken off from. More is mostly an
/// altitude above home in the frame of one above sea level.
const GROUND_FALLS_M: f64 = 50.0;

/// Round home the ground is a field, that far, m; and so much higher or lower than home, m, it may be there.
const FIELD_M: f64 = 300.0;
const FIELD_SLOPES_M: f64 = 15.0;

/// What the checks need to know of the vehicle. Defaults: where unknown, those of ArduPilot's simulated plane.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CheckContext {
    /// Home of the vehicle; the plan's own where it is unknown.
    pub home: Option<Home>,
    /// Where the vehicle is.
    pub position: Option<GeoPoint>,
    /// Whether it stands on the ground; `None`: unknown.
    pub on_ground: Option<bool>,
    /// Whether it can hover (quadplane). Default no.
    pub can_hover: bool,
    /// Whether its return looks for the mission's landing sequence (`RTL_AUTOLAND` of ArduPlane); `None`: unknown.
    pub finds_landing: Option<bool>,
    /// Whether it flies the arcs of `NAV_ARC_WAYPOINT`, as ArduCopter does. Default no.
    pub flies_arcs: bool,
    /// Whether one of several inclusion zones of its fence is enough (`FENCE_OPTIONS`, bit 1). Default no.
    pub is_fence_union: bool,
    /// Items that it holds, home included. Default 650.
    pub max_items: usize,
    /// Distance from home that is far, metres. Default 20,000.
    pub far_from_home_m: f64,
    /// Distance from the vehicle to the first destination that is far, metres. Default 5,000.
    pub far_first_m: f64,
    /// Speed that turns are flown with, metres per second. Default 22 (`AIRSPEED_CRUISE`).
    pub airspeed_m_s: f64,
    /// Lowest airspeed that a mission may order, metres per second (`AIRSPEED_MIN`); `None`, the default: unknown.
    pub airspeed_min_m_s: Option<f64>,
    /// Highest airspeed that a mission may order, metres per second (`AIRSPEED_MAX`); `None`, the default: unknown.
    pub airspeed_max_m_s: Option<f64>,
    /// Bank of turns, degrees. Default 45 (`ROLL_LIMIT_DEG`).
    pub bank_deg: f64,
    /// Slope of the final approach that is steep, height over distance. Default [`STEEP_SLOPE`], 0.10.
    pub steep_slope: f64,
}

impl Default for CheckContext {
    fn default() -> Self {
        Self {
            home: None,
            position: None,
            on_ground: None,
            can_hover: false,
            finds_landing: None,
            flies_arcs: false,
            is_fence_union: false,
            max_items: 650,
            far_from_home_m: 20_000.0,
            far_first_m: 5_000.0,
            airspeed_m_s: 22.0,
            airspeed_min_m_s: None,
            airspeed_max_m_s: None,
            bank_deg: 45.0,
            steep_slope: STEEP_SLOPE,
        }
    }
}

impl CheckContext {
    /// With what these parameters of an ArduPlane say.
    pub fn of<'a>(parameters: impl IntoIterator<Item = (&'a String, &'a f64)>) -> Self {
        let mut context = Self::default();
        for (name, value) in parameters {
            context.learn(name, *value);
        }
        context
    }

    /// Takes over what a parameter of an ArduPlane says of these; others are ignored.
    pub fn learn(&mut self, name: &str, value: f64) {
        let size = value.abs();
        match name {
            _ if !value.is_finite() => {}
            "AIRSPEED_CRUISE" if size >= 1.0 => self.airspeed_m_s = size,
            "TRIM_ARSPD_CM" if size >= 100.0 => self.airspeed_m_s = size / 100.0,
            "AIRSPEED_MIN" | "ARSPD_FBW_MIN" => self.airspeed_min_m_s = Some(size),
            "AIRSPEED_MAX" | "ARSPD_FBW_MAX" => self.airspeed_max_m_s = Some(size),
            "RTL_AUTOLAND" => self.finds_landing = Some(size > 0.0),
            "ROLL_LIMIT_DEG" if size >= 1.0 => self.bank_deg = size,
            "LIM_ROLL_CD" if size >= 100.0 => self.bank_deg = size / 100.0,
            "FENCE_OPTIONS" => self.is_fence_union = value as i64 & 1 << 1 != 0,
            "Q_ENABLE" => self.can_hover = size > 0.0,
            // kB of a file of 15 bytes an item, after 4 of its version (`AP_Mission::init`)
            "BRD_SD_MISSION" if size >= 1.0 => self.max_items = (size * 1024.0 - 4.0) as usize / 15,
            _ => {}
        }
    }

    /// Radius of a level turn, metres: v² / (g tan φ).
    pub fn turn_radius_m(&self) -> f64 {
        let bank = self.bank_deg.clamp(5.0, 80.0).to_radians();
        self.airspeed_m_s * self.airspeed_m_s / (GRAVITY_M_S2 * bank.tan())
    }
}

/// `true` when a plan with these findings is not to be sent.
pub fn has_errors(findings: &[Finding]) -> bool {
    findings.iter().any(|finding| finding.severity == Severity::Error)
}

/// Everything that is wrong or doubtful in a plan, in the order of its items; what is about the whole plan
/// comes first.
pub fn check_plan(plan: &Plan, context: &CheckContext) -> Vec<Finding> {
    let mut check = Check { plan, context, home: context.home.or(plan.mission.home), findings: Vec::new() };
    check.size();
    check.items();
    check.flow();
    check.jumps();
    check.fence_and_rally();
    // A list that is far too long is refused already; geometry on it would only take time.
    if plan.mission.items.len() <= context.max_items {
        check.places();
        check.landings();
        check.fence_around_mission();
    }
    let mut findings = check.findings;
    findings.sort_by_key(|finding| (finding.item, finding.severity, finding.code()));
    findings
}

struct Check<'a> {
    plan: &'a Plan,
    context: &'a CheckContext,
    home: Option<Home>,
    findings: Vec<Finding>,
}

/// Whether the plane flies, or lands, at an item. What only waits or runs a script may come before the take-off and
/// after the landing (`AP_Mission::is_takeoff_next`).
fn is_flown(item: &MissionItem) -> bool {
    is_nav(item) && !matches!(item.command, Command::NAV_DELAY | Command::NAV_SCRIPT_TIME)
}

/// Whether a place is at latitude 0, longitude 0: one that nobody has set.
fn is_null_island(point: GeoPoint) -> bool {
    (point.lat_deg(), point.lon_deg()) == (0.0, 0.0)
}

fn is_nav(item: &MissionItem) -> bool {
    item.command.is_nav() && item.command.info().is_none_or(|info| info.support != Support::Ignored)
}

const fn is_jump(item: &MissionItem) -> bool {
    matches!(item.command, Command::DO_JUMP | Command::DO_JUMP_TAG)
}

impl<'a> Check<'a> {
    fn items_of_mission(&self) -> impl Iterator<Item = (usize, &'a MissionItem)> + use<'a> {
        self.plan.mission.items.iter().enumerate()
    }

    fn add(&mut self, severity: Severity, item: Option<(usize, &MissionItem)>, kind: FindingKind) {
        self.findings.push(Finding::new(severity, kind, item));
    }

    fn error(&mut self, item: Option<(usize, &MissionItem)>, kind: FindingKind) {
        self.add(Severity::Error, item, kind);
    }

    fn warn(&mut self, item: Option<(usize, &MissionItem)>, kind: FindingKind) {
        self.add(Severity::Warning, item, kind);
    }

    fn size(&mut self) {
        let count = self.plan.mission.items.len();
        if count == 0 {
            let has_areas = !self.plan.fence.is_empty() || !self.plan.rally.points.is_empty();
            let severity = if has_areas { Severity::Warning } else { Severity::Error };
            self.add(severity, None, FindingKind::EmptyMission { has_areas });
        }
        let max = self.context.max_items.saturating_sub(1);
        if count > max {
            self.error(None, FindingKind::TooManyItems { count, max });
        }
    }

    /// Each item by itself.
    fn items(&mut self) {
        for (index, item) in self.items_of_mission() {
            let about = Some((index, item));
            if let Some(bad) = item.unsendable() {
                let (field, value, wanted) = (bad.field, bad.value, bad.wanted);
                self.error(about, FindingKind::BadValue { field, value, wanted });
                continue;
            }
            let Some(info) = item.command.info().filter(|info| info.support != Support::List) else {
                self.error(about, FindingKind::UnsupportedCommand {});
                continue;
            };
            let is_flown_arc = self.context.flies_arcs && item.command == Command::NAV_ARC_WAYPOINT;
            match info.support {
                Support::Ignored if !is_flown_arc => {
                    self.warn(about, FindingKind::IgnoredCommand { needs_hover: false });
                }
                Support::NeedsVtol if !self.context.can_hover => {
                    self.warn(about, FindingKind::IgnoredCommand { needs_hover: true });
                }
                _ => {}
            }
            self.params(index, item);
            self.airspeed(index, item);
            self.position(index, item);
        }
    }

    fn params(&mut self, index: usize, item: &MissionItem) {
        let Some(info) = item.command.info() else { return };
        let about = Some((index, item));
        let stored = ardupilot_stored(item);
        for (number, param) in info.params.iter().enumerate() {
            // the target of a jump has checks of its own
            let checked = param.is_used() && param.unit != Unit::Item;
            let Some(value) = item.params[number].filter(|_| checked) else { continue };
            let position = matches!(param.storage, Storage::DegE7 | Storage::Centimetres);
            let (unit, label) = (param.unit.symbol(), param.label);
            let below = param.min.is_some_and(|min| value < min);
            let above = param.max.is_some_and(|max| value > max);
            let kept = stored.params[number].unwrap_or(0.0);
            let sign_alone = matches!(param.storage, Storage::LoiterSign | Storage::YawSign | Storage::Positive);
            let is_kept = sign_alone || (kept - value).abs() <= 0.01 * value.abs();
            let is_unused = param.storage == Storage::Dropped;
            if (below || above) && !is_unused {
                let (min, max) = (param.min, param.max);
                let found = FindingKind::ParamOutOfRange { param: number + 1, label, value, unit, min, max };
                // A value out of range that is stored unchanged may be intended; one that is stored differently is not.
                self.add(if is_kept { Severity::Warning } else { Severity::Error }, about, found);
                continue;
            }
            if position || param.storage == Storage::Two {
                continue;
            }
            let measured = !matches!(param.unit, Unit::Choice | Unit::Flag | Unit::Degrees);
            if if is_unused { measured && value != 0.0 } else { !is_kept } {
                self.warn(about, FindingKind::ParamChanged { param: number + 1, label, value, kept, unit, is_unused });
            }
        }
    }

    /// An airspeed outside the vehicle's limits is dropped without a word (`Plane::do_change_speed`).
    fn airspeed(&mut self, index: usize, item: &MissionItem) {
        let is_airspeed = item.command == Command::DO_CHANGE_SPEED && item.param(1).unwrap_or(0.0) == 0.0;
        let Some(speed_m_s) = item.param(2).filter(|speed_m_s| is_airspeed && *speed_m_s > 0.0) else { return };
        let (min_m_s, max_m_s) = (self.context.airspeed_min_m_s, self.context.airspeed_max_m_s);
        if min_m_s.is_some_and(|min_m_s| speed_m_s < min_m_s) || max_m_s.is_some_and(|max_m_s| speed_m_s > max_m_s) {
            self.warn(Some((index, item)), FindingKind::SpeedNotTaken { speed_m_s, min_m_s, max_m_s });
        }
    }

    fn position(&mut self, index: usize, item: &MissionItem) {
        if !item.has_position() {
            return;
        }
        let about = Some((index, item));
        if item.lacks_place() {
            self.error(about, FindingKind::MissingPosition { missing: Missing::Place });
        } else if item.must_lie_somewhere() && (item.lat_deg(), item.lon_deg()) == (Some(0.0), Some(0.0)) {
            // ArduPlane puts the position where it is then for 0/0 (`Plane::set_next_WP`): to land or lower a payload
            // there can be meant, to fly there cannot.
            let is_here = item.command.is_landing() || item.command == Command::NAV_PAYLOAD_PLACE;
            let severity = if is_here { Severity::Warning } else { Severity::Error };
            self.add(severity, about, FindingKind::ZeroCoordinates { is_here });
        }
        // Left out it would be sent as 0 m: a take-off to the height of home.
        if (item.command.is_destination() || item.command.is_takeoff()) && item.alt_m().is_none() {
            self.error(about, FindingKind::MissingPosition { missing: Missing::Height });
        }
        let Some(alt_m) = item.alt_m() else { return };
        let home_alt_m = self.home.map(|home| home.alt_amsl_m);
        let above_home_m = match (alt_amsl_m(item, home_alt_m), home_alt_m) {
            (Some(alt_m), Some(home_m)) => Some(alt_m - home_m),
            _ if item.frame == MavFrame::GlobalRelativeAlt => Some(alt_m),
            _ => None,
        };
        let is_below = |height_m: f64| above_home_m.is_some_and(|above_home_m| above_home_m <= height_m);
        let underground = item.frame == MavFrame::GlobalTerrainAlt && alt_m <= 0.0;
        let is_on_ground = item.command.is_landing() || item.command == Command::NAV_PAYLOAD_PLACE;
        let is_low = if is_on_ground { is_below(-GROUND_FALLS_M) } else { is_below(0.0) || underground };
        let datum = Datum::of(item);
        let home = self.home.and_then(|home| home.point().ok());
        let is_at_home = home.zip(item.point()).is_some_and(|(home, point)| distance_m(home, point) <= FIELD_M);
        let off_m =
            above_home_m.filter(|off_m| item.command.is_landing() && is_at_home && off_m.abs() > FIELD_SLOPES_M);
        if let Some(height_m) = off_m {
            self.error(about, FindingKind::LandingOffField { off_m: height_m.abs(), is_under: height_m < 0.0 });
        } else if item.command.is_takeoff() && is_low {
            self.error(about, FindingKind::TakeoffTooLow { alt_m, datum });
        } else if item.command.is_destination() && is_low {
            self.warn(about, FindingKind::BelowHome { alt_m, datum });
        }
    }

    /// Beginning, end and landing sequences.
    fn flow(&mut self) {
        let nav: Vec<(usize, &MissionItem)> = self.items_of_mission().filter(|(_, item)| is_flown(item)).collect();
        // A plane that waits for a height is carried up by a balloon.
        if let Some(first) = nav.first().copied()
            && !first.1.command.is_takeoff()
            && first.1.command != Command::NAV_ALTITUDE_WAIT
        {
            match self.context.on_ground {
                Some(true) => self.error(Some(first), FindingKind::NoTakeoff {}),
                None => self.warn(Some(first), FindingKind::NoTakeoff {}),
                Some(false) => {}
            }
        }
        if let Some(last) = nav.last().copied()
            && !last.1.command.is_landing()
            && !self.plan.mission.items[last.0..].iter().any(is_endless)
        {
            self.warn(Some(last), FindingKind::NoLanding {});
        }
        for pair in nav.windows(2) {
            let ((index, item), (next_index, next)) = (pair[0], pair[1]);
            // A sequence that begins there is flown independently of the items before it.
            let next_sequence = self.plan.mission.items[index + 1..next_index]
                .iter()
                .any(|one| matches!(one.command, Command::DO_LAND_START | Command::DO_RETURN_PATH_START));
            let next_item = next_index + 1;
            if item.command.is_landing() && !next.command.is_takeoff() && !next_sequence {
                self.warn(Some((index, item)), FindingKind::ItemsAfterLanding { next_item });
            }
            if is_endless(item) && !next_sequence {
                self.warn(Some((index, item)), FindingKind::EndlessLoiter { next_item });
            }
        }
        for (index, item) in self.items_of_mission() {
            if item.command != Command::DO_LAND_START {
                continue;
            }
            // `AP_Arming_Plane::mission_checks`: "DO_LAND_START set and RTL_AUTOLAND disabled"
            if self.context.finds_landing == Some(false) {
                self.warn(Some((index, item)), FindingKind::LandStartDisabled {});
            }
            let sequence = nav.iter().filter(|(place, _)| *place > index);
            if !sequence.clone().any(|(_, item)| item.command.is_landing()) {
                self.error(Some((index, item)), FindingKind::LandStartWithoutLanding { has_landing: false });
            } else if sequence.clone().next().is_some_and(|(_, item)| item.command.is_landing()) {
                self.warn(Some((index, item)), FindingKind::LandStartWithoutLanding { has_landing: true });
            }
        }
    }

    fn jumps(&mut self) {
        let mission = &self.plan.mission;
        let mut count = 0;
        for (index, item) in self.items_of_mission() {
            if !is_jump(item) {
                continue;
            }
            count += 1;
            let about = Some((index, item));
            let Some(to) = jump_index(&mission.items, item) else {
                let target = item.param(1).unwrap_or(0.0);
                self.error(about, FindingKind::JumpTarget { target, last: mission.items.len() });
                continue;
            };
            let repeats = item.param(2).unwrap_or(0.0);
            if to <= index && repeats != 0.0 && !mission.items[to..index].iter().any(is_nav) {
                self.error(about, FindingKind::IdleJump {});
            } else if repeats < 0.0 {
                self.warn(about, FindingKind::EndlessJump {});
            }
        }
        if count > MAX_JUMPS {
            self.warn(None, FindingKind::TooManyJumps { count, max: MAX_JUMPS });
        }
    }

    /// Distances between places.
    fn places(&mut self) {
        let home = self.home.and_then(|home| home.point().ok());
        let turn_radius_m = self.context.turn_radius_m();
        let circles = |item: &MissionItem| item.command != Command::NAV_WAYPOINT;
        let mut previous: Option<(GeoPoint, &MissionItem)> = None;
        for (index, item) in self.items_of_mission() {
            let Some(point) = target(item) else {
                // legs after a jump do not join neighbours
                if matches!(item.command, Command::DO_JUMP | Command::DO_JUMP_TAG | Command::JUMP_TAG) {
                    previous = None;
                }
                continue;
            };
            let about = Some((index, item));
            if let Some(OutOfReach { distance_m, is_swapped }) = out_of_reach(point, home, self.context.position) {
                self.error(about, FindingKind::OutOfReach { distance_m, reach_m: REACH_M, is_swapped });
                previous = None;
                continue;
            }
            let far_m = self.context.far_from_home_m;
            if let Some(distance_m) = home.map(|home| distance_m(home, point)).filter(|d| *d > far_m) {
                self.warn(about, FindingKind::FarFromHome { distance_m, far_m });
            }
            let first = self.plan.mission.items[..index].iter().all(|item| target(item).is_none());
            let start = self.context.position.or(home);
            if first
                && let Some(distance_m) =
                    start.map(|start| distance_m(start, point)).filter(|d| *d > self.context.far_first_m)
            {
                self.warn(about, FindingKind::FarFirst { distance_m });
            }
            if let Some((from, before)) = previous
                && !circles(before)
                && !circles(item)
            {
                let length_m = distance_m(from, point);
                if length_m < turn_radius_m {
                    self.warn(about, FindingKind::ShortLeg { length_m, turn_radius_m });
                }
            }
            previous = Some((point, item));
        }
    }

    /// Slope of each final approach.
    fn landings(&mut self) {
        let home_alt_m = self.home.map(|home| home.alt_amsl_m);
        let mut previous: Option<&MissionItem> = None;
        for (index, item) in self.items_of_mission() {
            let Some(point) = target(item) else { continue };
            let before = previous.replace(item);
            if item.command != Command::NAV_LAND {
                continue;
            }
            let Some((before, from)) = before.and_then(|before| Some((before, target(before)?))) else { continue };
            let drop_m = if before.frame == item.frame {
                before.alt_m().zip(item.alt_m()).map(|(from_m, to_m)| from_m - to_m)
            } else {
                alt_amsl_m(before, home_alt_m).zip(alt_amsl_m(item, home_alt_m)).map(|(from_m, to_m)| from_m - to_m)
            };
            let Some(drop_m) = drop_m else { continue };
            let length_m = distance_m(from, point);
            if drop_m <= 0.0 {
                self.warn(Some((index, item)), FindingKind::FlatApproach {});
            } else if length_m <= 0.0 || drop_m / length_m > self.context.steep_slope {
                let wanted_length_m = drop_m / self.context.steep_slope.max(0.01);
                self.warn(Some((index, item)), FindingKind::SteepApproach { drop_m, length_m, wanted_length_m });
            }
        }
    }

    /// Fence and rally points by themselves.
    fn fence_and_rally(&mut self) {
        if let Some((zone, shape)) = self.plan.fence.fault() {
            let zone = Some(zone + 1);
            let (fault, corners, radius_m) = match shape {
                ShapeFault::TooFewCorners { count } => (FenceFault::TooFewCorners, Some(count), None),
                ShapeFault::TooManyCorners { count } => (FenceFault::TooManyCorners, Some(count), None),
                ShapeFault::Radius { radius_m } => (FenceFault::Radius, None, Some(radius_m)),
            };
            self.error(None, FindingKind::BadFence { fault, zone, corners, radius_m, alt_rel_home_m: None });
        }
        if let Some((point, alt_rel_home_m)) = self.plan.fence.return_point {
            let is_nowhere = is_null_island(point);
            let height = self.plan.fence.return_fault().map(|_| FenceFault::ReturnHeight);
            for fault in height.into_iter().chain(is_nowhere.then_some(FenceFault::ReturnPlace)) {
                let alt_rel_home_m = Some(alt_rel_home_m);
                let found = FindingKind::BadFence { fault, zone: None, corners: None, radius_m: None, alt_rel_home_m };
                self.error(None, found);
            }
        }
        for (index, (rally, item)) in self.plan.rally.points.iter().zip(self.plan.rally.to_items()).enumerate() {
            let found = match item.unsendable() {
                Some(bad) if bad.wanted == Wanted::Frame => Some((Severity::Error, RallyFault::Frame)),
                Some(_) => Some((Severity::Error, RallyFault::Height)),
                None if rally.alt_m.abs() > f64::from(i16::MAX) => Some((Severity::Error, RallyFault::Height)),
                None if rally.frame == MavFrame::GlobalRelativeAlt && rally.alt_m <= 0.0 => {
                    Some((Severity::Warning, RallyFault::NotAboveHome))
                }
                None => None,
            };
            if let Some((severity, fault)) = found {
                let (rally_point, alt_m) = (index + 1, rally.alt_m);
                self.add(severity, None, FindingKind::BadRally { rally_point, fault, alt_m });
            }
        }
        self.areas_out_of_reach();
    }

    /// Rally points, the return point and zones far from everything: the vehicle would fly to those, and be kept from
    /// nothing by these.
    fn areas_out_of_reach(&mut self) {
        let (plan, vehicle) = (self.plan, self.context.position);
        let home = self.home.and_then(|home| home.point().ok());
        let to = |rally_point, fence_zone, told: OutOfReach| FindingKind::AreaOutOfReach {
            rally_point,
            fence_zone,
            distance_m: told.distance_m,
            reach_m: REACH_M,
            is_swapped: told.is_swapped,
        };
        for (index, rally) in plan.rally.points.iter().enumerate() {
            if let Some(told) = out_of_reach(rally.point, home, vehicle) {
                self.error(None, to(Some(index + 1), None, told));
            }
        }
        if let Some((point, _)) = plan.fence.return_point
            && !is_null_island(point)
            && let Some(told) = out_of_reach(point, home, vehicle)
        {
            self.error(None, to(None, None, told));
        }
        for (index, zone) in plan.fence.zones.iter().enumerate() {
            if let Some(told) = reach::zone_out_of_reach(&zone.shape, home, vehicle) {
                self.warn(None, to(None, Some(index + 1), told));
            }
        }
    }

    fn forbidden_by(&self, point: GeoPoint) -> Option<usize> {
        self.plan.fence.forbidden_by(point, self.context.is_fence_union)
    }

    /// Places and legs of the mission within the fence.
    fn fence_around_mission(&mut self) {
        let zones = &self.plan.fence.zones;
        if zones.is_empty() || self.plan.fence.fault().is_some() {
            return;
        }
        let outside = |rally_point, zone: usize| FindingKind::OutsideFence {
            rally_point,
            zone: zone + 1,
            is_inclusion: zones[zone].inclusion,
        };
        for (index, rally) in self.plan.rally.points.iter().enumerate() {
            if let Some(zone) = self.forbidden_by(rally.point) {
                self.error(None, outside(Some(index + 1), zone));
            }
        }
        let home = self.home.and_then(|home| home.point().ok());
        if let Some(zone) = home.and_then(|home| self.forbidden_by(home)) {
            self.error(None, outside(None, zone));
        }
        if let Some((return_point, _)) = self.plan.fence.return_point
            && let Some(zone) = self.forbidden_by(return_point)
        {
            let is_inclusion = zones[zone].inclusion;
            self.error(None, FindingKind::ReturnPointOutsideFence { zone: zone + 1, is_inclusion });
        }
        let borders = Borders::of(&self.plan.fence, self.context.is_fence_union);
        let mut previous = self.context.position.or(home);
        for (index, item) in self.items_of_mission() {
            // From what ends a flight, or is flown again and again, no leg leads on; a circle without an end is a hold,
            // from which a pilot lets it go on.
            let next = self.plan.mission.items[index + 1..].iter().find(|item| is_flown(item));
            let is_down = item.command.is_landing() && !next.is_some_and(|next| next.command.is_takeoff());
            let goes_on = !is_down && (!is_endless(item) || item.command == Command::NAV_LOITER_UNLIM);
            let Some(point) = target(item) else {
                previous = previous.filter(|_| goes_on);
                continue;
            };
            if let Some(zone) = self.forbidden_by(point) {
                self.error(Some((index, item)), outside(None, zone));
                previous = None; // the legs to and from it cross the fence for sure
                continue;
            }
            if let Some(from) = previous
                && let Some(zone) = borders.crossed(from, point)
            {
                self.error(Some((index, item)), FindingKind::LegCrossesFence { zone: zone + 1 });
            }
            previous = Some(point).filter(|_| goes_on);
        }
    }
}

/// Whether the mission never goes on to the next item by itself.
fn is_endless(item: &MissionItem) -> bool {
    matches!(item.command, Command::NAV_LOITER_UNLIM | Command::NAV_RETURN_TO_LAUNCH)
        || is_jump(item) && item.param(2).is_some_and(|repeats| repeats < 0.0)
}

#[cfg(test)]
#[path = "checks_tests.rs"]
mod tests;
