//! What is wrong or doubtful in a plan, before it is sent.
//!
//! [`check_plan`] runs before every upload. An error means that the vehicle would refuse the plan, keep
//! something else, or fly what nobody can want; a warning is for the pilot to judge.

use std::collections::HashSet;

use vencejo_proto::MissionSeq;

use crate::error::FlightError;
use crate::geodesy::{GeoPoint, LocalFrame, distance_m, wrap_180_deg};
use crate::plan::{
    Category, Command, FenceShape, FenceZone, Home, MissionItem, Plan, Storage, Support, Unit, ardupilot_stored,
};
use crate::progress::{alt_amsl_m, jump_index, target};

/// Standard gravity, metres per second squared (ISO 80000-3).
const G_M_S2: f64 = 9.806_65;

/// Jumps that every ArduPilot board can track; large ones track 100.
const MAX_JUMPS: usize = 15;

/// How bad a finding is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Severity {
    /// Not to be sent.
    Error,
    /// For the pilot to judge.
    Warning,
}

macro_rules! codes {
    ($($(#[doc = $doc:literal])* $name:ident = $text:literal,)*) => {
        /// What kind of finding it is. [`FindingCode::as_str`] is stable and fit for scripts.
        #[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
        #[non_exhaustive]
        pub enum FindingCode { $($(#[doc = $doc])* $name,)* }

        impl FindingCode {
            /// All codes.
            pub const ALL: &'static [Self] = &[$(Self::$name,)*];

            /// The code as text, as in `zero-coordinates`.
            #[must_use]
            pub const fn as_str(self) -> &'static str {
                match self { $(Self::$name => $text,)* }
            }
        }
    };
}

codes! {
    /// There is nothing to fly.
    EmptyMission = "empty-mission",
    /// More items than the vehicle holds.
    TooManyItems = "too-many-items",
    /// A value that is not finite, off the globe, or in a frame without meaning.
    BadValue = "bad-value",
    /// A command that ArduPlane refuses.
    UnsupportedCommand = "unsupported-command",
    /// A command that ArduPlane stores and skips.
    IgnoredCommand = "ignored-command",
    /// A parameter outside its range.
    ParamOutOfRange = "param-out-of-range",
    /// A parameter that ArduPlane keeps as another value.
    ParamChanged = "param-changed",
    /// A place without latitude, longitude or height.
    MissingPosition = "missing-position",
    /// Latitude and longitude both 0.
    ZeroCoordinates = "zero-coordinates",
    /// On the ground, and the mission does not begin with a take-off.
    NoTakeoff = "no-takeoff",
    /// A take-off to a height that is not above home.
    TakeoffTooLow = "takeoff-too-low",
    /// Neither landing nor return at the end.
    NoLanding = "no-landing",
    /// Items after a landing.
    ItemsAfterLanding = "items-after-landing",
    /// A start of a landing sequence without landing.
    LandStartWithoutLanding = "land-start-without-landing",
    /// A jump to nowhere.
    JumpTarget = "jump-target",
    /// A jump that repeats for ever.
    EndlessJump = "endless-jump",
    /// A jump that runs in a circle without flying.
    IdleJump = "idle-jump",
    /// More jumps than the vehicle tracks.
    TooManyJumps = "too-many-jumps",
    /// Far from home.
    FarFromHome = "far-from-home",
    /// The first destination is far from the plane.
    FarFirst = "far-first",
    /// At or below the height of home.
    BelowHome = "below-home",
    /// A leg shorter than the plane can turn.
    ShortLeg = "short-leg",
    /// A final approach that is steep.
    SteepApproach = "steep-approach",
    /// A final approach that does not descend.
    FlatApproach = "flat-approach",
    /// Outside the fence.
    OutsideFence = "outside-fence",
    /// A leg that crosses the fence.
    LegCrossesFence = "leg-crosses-fence",
    /// A fence or rally point that no vehicle takes.
    BadFence = "bad-fence",
    /// A rally point that no vehicle takes or that lies badly.
    BadRally = "bad-rally",
}

impl std::fmt::Display for FindingCode {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(self.as_str())
    }
}

/// One thing that is wrong or doubtful.
#[derive(Debug, Clone, PartialEq)]
pub struct Finding {
    /// How bad it is.
    pub severity: Severity,
    /// What kind it is.
    pub code: FindingCode,
    /// Index in `plan.mission.items`; `None` when it is about the whole plan, the fence or rally points.
    pub item: Option<usize>,
    /// What is wrong. Items are called by their seq on ArduPilot: index + 1.
    pub message: String,
    /// How to mend it.
    pub remedy: String,
}

impl std::fmt::Display for Finding {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}: {}", self.message, self.remedy)
    }
}

/// What the checks must know of the vehicle, with the defaults of an ArduPlane.
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
    /// Items that it holds, home included. Default 650.
    pub max_items: usize,
    /// Distance from home that is far, metres. Default 20,000.
    pub far_from_home_m: f64,
    /// Distance from the vehicle to the first destination that is far, metres. Default 5,000.
    pub far_first_m: f64,
    /// Speed that turns are flown with, metres per second. Default 22 (`AIRSPEED_CRUISE`).
    pub airspeed_m_s: f64,
    /// Bank of turns, degrees. Default 45 (`ROLL_LIMIT_DEG`).
    pub bank_deg: f64,
    /// Slope of the final approach that is steep, height over distance. Default 0.10.
    pub steep_slope: f64,
}

impl Default for CheckContext {
    fn default() -> Self {
        Self {
            home: None,
            position: None,
            on_ground: None,
            can_hover: false,
            max_items: 650,
            far_from_home_m: 20_000.0,
            far_first_m: 5_000.0,
            airspeed_m_s: 22.0,
            bank_deg: 45.0,
            steep_slope: 0.10,
        }
    }
}

impl CheckContext {
    /// Radius of a level turn, metres: v² / (g tan φ).
    #[must_use]
    pub fn turn_radius_m(&self) -> f64 {
        let bank = self.bank_deg.clamp(5.0, 80.0).to_radians();
        self.airspeed_m_s * self.airspeed_m_s / (G_M_S2 * bank.tan())
    }
}

/// `true` when a plan with these findings is not to be sent.
#[must_use]
pub fn has_errors(findings: &[Finding]) -> bool {
    findings.iter().any(|finding| finding.severity == Severity::Error)
}

/// Everything that is wrong or doubtful in a plan, in the order of its items; what is about the whole plan
/// comes first.
#[must_use]
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
    findings.sort_by_key(|finding| (finding.item, finding.severity, finding.code));
    findings
}

struct Check<'a> {
    plan: &'a Plan,
    context: &'a CheckContext,
    home: Option<Home>,
    findings: Vec<Finding>,
}

/// An item as messages call it.
fn name(index: usize, item: &MissionItem) -> String {
    format!("item {} ({})", index + 1, item.command)
}

fn is_nav(item: &MissionItem) -> bool {
    item.command.info().is_some_and(|info| info.category == Category::Nav && info.support != Support::Ignored)
}

impl<'a> Check<'a> {
    fn items_of_mission(&self) -> impl Iterator<Item = (usize, &'a MissionItem)> + use<'a> {
        self.plan.mission.items.iter().enumerate()
    }

    fn add(
        &mut self,
        severity: Severity,
        code: FindingCode,
        item: Option<usize>,
        message: impl Into<String>,
        remedy: impl Into<String>,
    ) {
        self.findings.push(Finding { severity, code, item, message: message.into(), remedy: remedy.into() });
    }

    fn error(&mut self, code: FindingCode, item: Option<usize>, message: impl Into<String>, remedy: impl Into<String>) {
        self.add(Severity::Error, code, item, message, remedy);
    }

    fn warn(&mut self, code: FindingCode, item: Option<usize>, message: impl Into<String>, remedy: impl Into<String>) {
        self.add(Severity::Warning, code, item, message, remedy);
    }

    fn size(&mut self) {
        let count = self.plan.mission.items.len();
        if count == 0 {
            let message = "the mission is empty";
            if self.plan.fence.is_empty() && self.plan.rally.points.is_empty() {
                self.error(
                    FindingCode::EmptyMission,
                    None,
                    message,
                    "add items; to empty the vehicle, clear its mission",
                );
            } else {
                self.warn(FindingCode::EmptyMission, None, message, "send the fence and the rally points alone");
            }
        }
        let max = self.context.max_items.saturating_sub(1);
        if count > max {
            self.error(
                FindingCode::TooManyItems,
                None,
                format!("the mission has {count} items, the vehicle holds {max} beside home"),
                "split it, or widen the distance between survey lines",
            );
        }
    }

    /// Each item by itself.
    fn items(&mut self) {
        for (index, item) in self.items_of_mission() {
            let name = name(index, item);
            let seq = MissionSeq(u16::try_from(index + 1).unwrap_or(u16::MAX));
            if let Err(error) = item.check_sendable(seq) {
                let (message, remedy) = match error {
                    FlightError::BadItem { field, value, problem, .. } => {
                        (format!("{name}: {field} is {value}"), problem.to_owned())
                    }
                    other => (format!("{name} cannot be sent"), other.to_string()),
                };
                self.error(FindingCode::BadValue, Some(index), message, remedy);
                continue;
            }
            let Some(info) = item.command.info().filter(|info| info.support != Support::List) else {
                self.error(
                    FindingCode::UnsupportedCommand,
                    Some(index),
                    format!("{name} is no mission command of ArduPlane, which refuses the whole mission"),
                    "delete it or choose another command",
                );
                continue;
            };
            match info.support {
                Support::Ignored => self.warn(
                    FindingCode::IgnoredCommand,
                    Some(index),
                    format!("{name} is for other vehicles; ArduPlane skips it"),
                    "delete it",
                ),
                Support::NeedsVtol if !self.context.can_hover => self.warn(
                    FindingCode::IgnoredCommand,
                    Some(index),
                    format!("{name} needs a plane that can hover"),
                    "delete it, or say that the plane is a quadplane",
                ),
                _ => {}
            }
            self.params(index, item, &name);
            self.position(index, item, &name);
        }
    }

    fn params(&mut self, index: usize, item: &MissionItem, name: &str) {
        let Some(info) = item.command.info() else { return };
        let stored = ardupilot_stored(item);
        for (number, param) in info.params.iter().enumerate() {
            // the target of a jump has checks of its own
            let checked = param.is_used() && param.unit != Unit::Item;
            let Some(value) = item.params[number].filter(|_| checked) else { continue };
            let position = matches!(param.storage, Storage::DegE7 | Storage::Centimetres);
            let unit = param.unit.symbol();
            let label = param.label;
            let below = param.min.is_some_and(|min| value < min);
            let above = param.max.is_some_and(|max| value > max);
            if (below || above) && param.storage != Storage::Dropped {
                let bound = |value: Option<f64>| value.map_or("…".to_owned(), |value| value.to_string());
                self.error(
                    FindingCode::ParamOutOfRange,
                    Some(index),
                    format!("{name}: {label} is {value} {unit}"),
                    format!("choose from {} to {}", bound(param.min), bound(param.max)),
                );
                continue;
            }
            if position || param.storage == Storage::Two {
                continue;
            }
            let kept = stored.params[number].unwrap_or(0.0);
            let measured = !matches!(param.unit, Unit::Choice | Unit::Flag | Unit::Degrees);
            let dropped = param.storage == Storage::Dropped;
            let matters = if dropped { measured && value != 0.0 } else { (kept - value).abs() > 0.01 * value.abs() };
            let sign_alone = matches!(param.storage, Storage::LoiterSign | Storage::YawSign | Storage::Positive);
            if matters && !sign_alone {
                self.warn(
                    FindingCode::ParamChanged,
                    Some(index),
                    format!("{name}: {label} of {value} {unit} is kept as {kept}"),
                    if dropped { "set it to 0: ArduPlane does not use it" } else { "choose a value that is kept" },
                );
            }
        }
    }

    fn position(&mut self, index: usize, item: &MissionItem, name: &str) {
        if !item.has_position() {
            return;
        }
        let must_lie_somewhere = !item.command.may_stay_in_place();
        if must_lie_somewhere && (item.lat_deg().is_none() || item.lon_deg().is_none()) {
            self.error(
                FindingCode::MissingPosition,
                Some(index),
                format!("{name} has no latitude or longitude"),
                "place it on the map",
            );
        } else if must_lie_somewhere && (item.lat_deg(), item.lon_deg()) == (Some(0.0), Some(0.0)) {
            self.error(
                FindingCode::ZeroCoordinates,
                Some(index),
                format!("{name} lies at 0/0, in the Atlantic"),
                "place it on the map",
            );
        }
        if item.command.is_destination() && item.alt_m().is_none() {
            self.error(FindingCode::MissingPosition, Some(index), format!("{name} has no height"), "set one");
        }
        let Some(alt_m) = item.alt_m() else { return };
        let home_alt_m = self.home.map(|home| home.alt_amsl_m);
        let above_home_m = match (alt_amsl_m(item, home_alt_m), home_alt_m) {
            (Some(alt_m), Some(home_m)) => Some(alt_m - home_m),
            _ if item.frame == crate::plan::MavFrame::GlobalRelativeAlt => Some(alt_m),
            _ => None,
        };
        let at_most_home = above_home_m.is_some_and(|height_m| height_m <= 0.0);
        let underground = item.frame == crate::plan::MavFrame::GlobalTerrainAlt && alt_m <= 0.0;
        if item.command.is_takeoff() && (at_most_home || underground) {
            self.error(
                FindingCode::TakeoffTooLow,
                Some(index),
                format!("{name} climbs to {alt_m} m {}, which is not above home", item.frame),
                "give it a height to climb to, 30 m or more",
            );
        } else if item.command.is_destination()
            && !item.command.is_landing()
            && item.command != Command::NAV_PAYLOAD_PLACE
            && (at_most_home || underground)
        {
            let level = if underground { "the ground" } else { "home" };
            self.warn(
                FindingCode::BelowHome,
                Some(index),
                format!("{name} lies at {alt_m} m {}, not above {level}", item.frame),
                "raise it, unless the terrain falls away there",
            );
        }
    }

    /// Beginning, end and landing sequences.
    fn flow(&mut self) {
        let nav: Vec<(usize, &MissionItem)> = self.items_of_mission().filter(|(_, item)| is_nav(item)).collect();
        if let Some((index, first)) = nav.first().copied()
            && !first.command.is_takeoff()
        {
            let message = format!("the mission begins with {}, not with a take-off", name(index, first));
            let remedy = "put a take-off first, or start it in the air";
            match self.context.on_ground {
                Some(true) => self.error(FindingCode::NoTakeoff, Some(index), message, remedy),
                None => self.warn(FindingCode::NoTakeoff, Some(index), message, remedy),
                Some(false) => {}
            }
        }
        let endless = self
            .items_of_mission()
            .last()
            .is_some_and(|(_, item)| item.command == Command::DO_JUMP && item.param(2).is_some_and(|n| n < 0.0));
        if let Some((index, last)) = nav.last().copied()
            && !endless
            && !last.command.is_landing()
            && !matches!(last.command, Command::NAV_RETURN_TO_LAUNCH | Command::NAV_LOITER_UNLIM)
        {
            self.warn(
                FindingCode::NoLanding,
                Some(index),
                format!("the mission ends with {}, neither landing nor return", name(index, last)),
                "end it with a landing or a return to launch",
            );
        }
        for pair in nav.windows(2) {
            let ((index, landing), (next_index, next)) = (pair[0], pair[1]);
            let next_sequence = self.plan.mission.items[index + 1..next_index]
                .iter()
                .any(|item| item.command == Command::DO_LAND_START);
            if landing.command.is_landing() && !next.command.is_takeoff() && !next_sequence {
                self.warn(
                    FindingCode::ItemsAfterLanding,
                    Some(index),
                    format!(
                        "{} lands before the mission ends; {} is not flown",
                        name(index, landing),
                        name(next_index, next)
                    ),
                    "move the landing to the end",
                );
            }
        }
        for (index, item) in self.items_of_mission() {
            if item.command != Command::DO_LAND_START {
                continue;
            }
            let sequence = nav.iter().filter(|(place, _)| *place > index);
            if !sequence.clone().any(|(_, item)| item.command.is_landing()) {
                self.error(
                    FindingCode::LandStartWithoutLanding,
                    Some(index),
                    format!("{} starts a landing sequence, but no landing follows", name(index, item)),
                    "add a landing after it or delete it",
                );
            } else if sequence.clone().next().is_some_and(|(_, item)| item.command.is_landing()) {
                self.warn(
                    FindingCode::LandStartWithoutLanding,
                    Some(index),
                    format!("{} is followed by the landing at once, without an approach", name(index, item)),
                    "put a waypoint before the landing, in line with the runway",
                );
            }
        }
    }

    fn jumps(&mut self) {
        let mission = &self.plan.mission;
        let mut count = 0;
        for (index, item) in self.items_of_mission() {
            if !matches!(item.command, Command::DO_JUMP | Command::DO_JUMP_TAG) {
                continue;
            }
            count += 1;
            let name = name(index, item);
            let Some(to) = jump_index(mission, item) else {
                let target = item.param(1).unwrap_or(0.0);
                self.error(
                    FindingCode::JumpTarget,
                    Some(index),
                    format!("{name} jumps to {target}, which is no item"),
                    format!("choose an item from 1 to {}", mission.items.len()),
                );
                continue;
            };
            let repeats = item.param(2).unwrap_or(0.0);
            if to <= index && repeats != 0.0 && !mission.items[to..index].iter().any(is_nav) {
                self.error(
                    FindingCode::IdleJump,
                    Some(index),
                    format!("{name} jumps in a circle in which nothing is flown"),
                    "choose an item before the last waypoint",
                );
            } else if repeats < 0.0 {
                self.warn(
                    FindingCode::EndlessJump,
                    Some(index),
                    format!("{name} repeats for ever; what follows it is never flown"),
                    "give it a number of repeats, unless you mean it",
                );
            }
        }
        if count > MAX_JUMPS {
            self.warn(
                FindingCode::TooManyJumps,
                None,
                format!("the mission has {count} jumps; small boards track {MAX_JUMPS}"),
                "repeat items instead of jumping",
            );
        }
    }

    /// Distances between places.
    fn places(&mut self) {
        let home = self.home.and_then(|home| home.point().ok());
        let turn_m = self.context.turn_radius_m();
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
            let name = name(index, item);
            if let Some(far_m) = home.map(|home| distance_m(home, point)).filter(|d| *d > self.context.far_from_home_m)
            {
                self.warn(
                    FindingCode::FarFromHome,
                    Some(index),
                    format!("{name} lies {:.1} km from home", far_m / 1_000.0),
                    format!("check it; far is {:.0} km", self.context.far_from_home_m / 1_000.0),
                );
            }
            let first = self.plan.mission.items[..index].iter().all(|item| target(item).is_none());
            let start = self.context.position.or(home);
            if first
                && let Some(far_m) =
                    start.map(|start| distance_m(start, point)).filter(|d| *d > self.context.far_first_m)
            {
                self.warn(
                    FindingCode::FarFirst,
                    Some(index),
                    format!("{name}, the first destination, lies {:.1} km from the plane", far_m / 1_000.0),
                    "check that the mission is for this place",
                );
            }
            if let Some((from, before)) = previous
                && !circles(before)
                && !circles(item)
            {
                let length_m = distance_m(from, point);
                if length_m < turn_m {
                    self.warn(
                        FindingCode::ShortLeg,
                        Some(index),
                        format!("the leg to {name} is {length_m:.0} m long, the plane turns within {turn_m:.0} m"),
                        "move the waypoints apart or fly slower",
                    );
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
            let name = name(index, item);
            let length_m = distance_m(from, point);
            if drop_m <= 0.0 {
                self.warn(
                    FindingCode::FlatApproach,
                    Some(index),
                    format!("the approach to {name} does not descend"),
                    "raise the waypoint before the landing",
                );
            } else if length_m <= 0.0 || drop_m / length_m > self.context.steep_slope {
                self.warn(
                    FindingCode::SteepApproach,
                    Some(index),
                    format!("the approach to {name} drops {drop_m:.0} m in {length_m:.0} m; the plane will land long"),
                    format!("begin it {:.0} m away or more, or lower", drop_m / self.context.steep_slope.max(0.01)),
                );
            }
        }
    }

    /// Fence and rally points by themselves.
    fn fence_and_rally(&mut self) {
        if let Err(error) = self.plan.fence.validate() {
            self.error(FindingCode::BadFence, None, error.to_string(), "mend or delete it");
        }
        for (index, item) in self.plan.fence.to_items().iter().enumerate() {
            let seq = MissionSeq(u16::try_from(index).unwrap_or(u16::MAX));
            if let Err(error) = item.check_sendable(seq) {
                self.error(FindingCode::BadFence, None, format!("fence: {error}"), "mend or delete it");
            }
        }
        for (index, (rally, item)) in self.plan.rally.points.iter().zip(self.plan.rally.to_items()).enumerate() {
            let seq = MissionSeq(u16::try_from(index).unwrap_or(u16::MAX));
            let number = index + 1;
            if let Err(error) = item.check_sendable(seq) {
                self.error(FindingCode::BadRally, None, format!("rally point {number}: {error}"), "mend or delete it");
            } else if rally.alt_m.abs() > f64::from(i16::MAX) {
                self.error(
                    FindingCode::BadRally,
                    None,
                    format!("rally point {number} lies at {} m", rally.alt_m),
                    "stay within 32,767 m, as ArduPilot stores it",
                );
            } else if rally.frame == crate::plan::MavFrame::GlobalRelativeAlt && rally.alt_m <= 0.0 {
                self.warn(
                    FindingCode::BadRally,
                    None,
                    format!("rally point {number} lies at {} m, not above home", rally.alt_m),
                    "raise it",
                );
            }
        }
    }

    /// Places and legs of the mission within the fence.
    fn fence_around_mission(&mut self) {
        let zones = &self.plan.fence.zones;
        if zones.is_empty() || self.plan.fence.validate().is_err() {
            return;
        }
        for (index, rally) in self.plan.rally.points.iter().enumerate() {
            if let Some(zone) = self.plan.fence.forbidden_by(rally.point) {
                let message = format!("rally point {} lies {}", index + 1, side(zone, &zones[zone]));
                self.error(FindingCode::OutsideFence, None, message, "move it or the fence");
            }
        }
        let home = self.home.and_then(|home| home.point().ok());
        if let Some(zone) = home.and_then(|home| self.plan.fence.forbidden_by(home)) {
            let message = format!("home lies {}", side(zone, &zones[zone]));
            self.error(FindingCode::OutsideFence, None, message, "move the fence");
        }
        let mut previous = self.context.position.or(home);
        let mut outside: HashSet<usize> = HashSet::new();
        for (index, item) in self.items_of_mission() {
            let Some(point) = target(item) else { continue };
            if let Some(zone) = self.plan.fence.forbidden_by(point) {
                let message = format!("{} lies {}", name(index, item), side(zone, &zones[zone]));
                self.error(FindingCode::OutsideFence, Some(index), message, "move it or the fence");
                outside.insert(index);
                previous = None; // the legs to and from it cross the fence for sure
                continue;
            }
            if let Some(from) = previous
                && let Some(zone) = zones.iter().position(|zone| crosses(zone, from, point))
            {
                let message = format!("the leg to {} crosses fence zone {}", name(index, item), zone + 1);
                self.error(FindingCode::LegCrossesFence, Some(index), message, "lead it round, or change the fence");
            }
            previous = Some(point);
        }
    }
}

fn side(index: usize, zone: &FenceZone) -> String {
    let side = if zone.inclusion { "outside inclusion" } else { "inside exclusion" };
    format!("{side} zone {} of the fence", index + 1)
}

/// Whether a leg between two allowed places leaves an inclusion zone or enters an exclusion zone.
fn crosses(zone: &FenceZone, from: GeoPoint, to: GeoPoint) -> bool {
    match &zone.shape {
        FenceShape::Polygon { vertices } => {
            let flat =
                |point: GeoPoint| (from.lon_deg() + wrap_180_deg(point.lon_deg() - from.lon_deg()), point.lat_deg());
            let leg = (flat(from), flat(to));
            (0..vertices.len()).any(|index| {
                let edge = (flat(vertices[index]), flat(vertices[(index + 1) % vertices.len()]));
                // an edge that wraps round the globe is far from the leg
                (edge.0.0 - edge.1.0).abs() < 180.0 && segments_cross(leg, edge)
            })
        }
        // A circle is convex: a leg between two places inside stays inside.
        FenceShape::Circle { .. } if zone.inclusion => false,
        FenceShape::Circle { center, radius_m } => {
            let frame = LocalFrame::new(*center, 0.0);
            let flat = |point| {
                let [north_m, east_m, _] = frame.ned_m(point, 0.0);
                (north_m, east_m)
            };
            distance_to_segment(flat(from), flat(to)) < *radius_m
        }
    }
}

type Flat = (f64, f64);

/// Whether two segments cross each other (touching at an end does not count).
fn segments_cross(a: (Flat, Flat), b: (Flat, Flat)) -> bool {
    let side = |(p, q): (Flat, Flat), r: Flat| (q.0 - p.0) * (r.1 - p.1) - (q.1 - p.1) * (r.0 - p.0);
    side(a, b.0) * side(a, b.1) < 0.0 && side(b, a.0) * side(b, a.1) < 0.0
}

/// Distance from the origin to a segment.
fn distance_to_segment(a: Flat, b: Flat) -> f64 {
    let (dx, dy) = (b.0 - a.0, b.1 - a.1);
    let length2 = dx * dx + dy * dy;
    let part = if length2 > 0.0 { (-(a.0 * dx + a.1 * dy) / length2).clamp(0.0, 1.0) } else { 0.0 };
    (a.0 + part * dx).hypot(a.1 + part * dy)
}

#[cfg(test)]
#[path = "checks_tests.rs"]
mod tests;
