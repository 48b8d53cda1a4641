//! The findings: their kinds with figures. The English texts are in `english`.
//!
//! A kind is a stable code with named figures; a name ends in its unit and datum. Front doors hand both on, so that the
//! same can be shown in other languages and units; [`Finding::message`] and [`Finding::remedy`] are English.

#[cfg(feature = "describe")]
use serde::Serialize;
#[cfg(feature = "describe")]
use utoipa::ToSchema;

use crate::plan::{MAX_VERTICES, MavFrame, MissionItem, SHAPE_MIN_CORNERS, Wanted};
use crate::words::{figured, words};

/// How bad a finding is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[cfg_attr(feature = "describe", derive(Serialize, ToSchema), serde(rename_all = "snake_case"), schema(as = FindingSeverity))]
pub enum Severity {
    /// Not to be sent.
    Error,
    /// For the pilot to judge.
    Warning,
}

words! {
    /// What a height counts from.
    #[cfg_attr(feature = "describe", schema(as = HeightDatum))]
    Datum {
        /// Mean sea level.
        Amsl = "amsl",
        /// Home.
        Home = "home",
        /// The ground below.
        Terrain = "terrain",
    }
}

impl Datum {
    /// What heights of an item count from; `None` for a frame without meaning for a place.
    pub(super) fn of(item: &MissionItem) -> Option<Self> {
        match item.frame {
            MavFrame::Global | MavFrame::Mission => Some(Self::Amsl),
            MavFrame::GlobalRelativeAlt => Some(Self::Home),
            MavFrame::GlobalTerrainAlt => Some(Self::Terrain),
            MavFrame::Other(_) => None,
        }
    }

    const fn words(self) -> &'static str {
        match self {
            Self::Amsl => "above mean sea level",
            Self::Home => "above home",
            Self::Terrain => "above terrain",
        }
    }
}

words! {
    /// Which part of a position is missing.
    #[cfg_attr(feature = "describe", schema(as = MissingPart))]
    Missing {
        /// Latitude or longitude.
        Place = "place",
        /// The height.
        Height = "height",
    }
}

words! {
    /// What is wrong with a fence.
    FenceFault {
        /// A polygon with too few corners.
        TooFewCorners = "too-few-corners",
        /// A polygon with too many corners.
        TooManyCorners = "too-many-corners",
        /// A circle without a radius.
        Radius = "radius",
        /// A return point at a height that cannot be sent.
        ReturnHeight = "return-height",
    }
}

words! {
    /// What is wrong with a rally point.
    RallyFault {
        /// A height that cannot be sent or stored.
        Height = "height",
        /// Not above home.
        NotAboveHome = "not-above-home",
        /// A frame that has no meaning for a place.
        Frame = "frame",
    }
}

macro_rules! kinds {
    ($($(#[doc = $doc:literal])* $name:ident = $code:literal { $($fields:tt)* },)*) => {
        words! {
            /// What kind of finding it is, as in `zero-coordinates`.
            #[non_exhaustive]
            FindingCode { $($(#[doc = $doc])* $name = $code,)* }
        }

        figured! {
            /// Kind of finding, with its figures. `code` is stable; a figure's name ends in its unit.
            #[cfg_attr(feature = "describe", serde(tag = "code", content = "figures", rename_all = "kebab-case"))]
            FindingKind { $($(#[doc = $doc])* $name = $code { $($fields)* },)* }
        }

        impl FindingKind {
            /// The kind without its figures.
            pub const fn code(&self) -> FindingCode {
                match self { $(Self::$name { .. } => FindingCode::$name,)* }
            }
        }
    };
}

kinds! {
    /// There is nothing to fly.
    EmptyMission = "empty-mission" {
        /// Whether the plan has a fence or rally points.
        has_areas: bool,
    },
    /// More items than the vehicle holds.
    TooManyItems = "too-many-items" {
        /// Items, home not counted.
        count: usize,
        /// How many it holds.
        max: usize,
    },
    /// A value that is not finite, off the globe, or in a frame without meaning.
    BadValue = "bad-value" {
        /// Which: `param1` … `param4`, `x`, `y`, `z`, `frame`.
        field: &'static str,
        /// The value; null when it is not a number.
        #[cfg_attr(feature = "describe", schema(value_type = Option<f64>))]
        value: f64,
        /// The requirement that it violates.
        wanted: Wanted,
    },
    /// A command that ArduPlane refuses.
    UnsupportedCommand = "unsupported-command" {},
    /// A command that the vehicle stores and skips.
    IgnoredCommand = "ignored-command" {
        /// Whether a plane that can hover would do it.
        needs_hover: bool,
    },
    /// A parameter outside its range.
    ParamOutOfRange = "param-out-of-range" {
        /// Which, 1 to 7.
        param: usize,
        /// English name of the parameter.
        label: &'static str,
        /// Its value.
        value: f64,
        /// Symbol of the unit; empty when there is none.
        unit: &'static str,
        /// Least; null without one.
        min: Option<f64>,
        /// Most; null without one.
        max: Option<f64>,
    },
    /// A parameter that ArduPlane keeps as another value.
    ParamChanged = "param-changed" {
        /// Which, 1 to 7.
        param: usize,
        /// English name of the parameter.
        label: &'static str,
        /// Its value.
        value: f64,
        /// The value that the vehicle stores.
        kept: f64,
        /// Symbol of the unit; empty when there is none.
        unit: &'static str,
        /// Whether the vehicle does not use the parameter at all.
        is_unused: bool,
    },
    /// A place without latitude, longitude or height.
    MissingPosition = "missing-position" {
        /// The part that is missing.
        missing: Missing,
    },
    /// Latitude and longitude both 0.
    ZeroCoordinates = "zero-coordinates" {
        /// Whether the vehicle does it where it is then.
        is_here: bool,
    },
    /// On the ground, and the mission does not begin with a take-off.
    NoTakeoff = "no-takeoff" {},
    /// A take-off to a height that is not above home.
    TakeoffTooLow = "takeoff-too-low" {
        /// Height that it climbs to.
        alt_m: f64,
        /// What that counts from.
        datum: Option<Datum>,
    },
    /// The mission ends without landing or return.
    NoLanding = "no-landing" {},
    /// Items after a landing.
    ItemsAfterLanding = "items-after-landing" {
        /// The first that is not flown, counted from 1.
        next_item: usize,
    },
    /// A circle without end, and items after it.
    EndlessLoiter = "endless-loiter" {
        /// The first that is not flown, counted from 1.
        next_item: usize,
    },
    /// A start of a landing sequence without landing.
    LandStartWithoutLanding = "land-start-without-landing" {
        /// Whether there is a landing, and it lacks its approach.
        has_landing: bool,
    },
    /// A DO_LAND_START for a vehicle whose `RTL_AUTOLAND` is 0, which refuses to arm with it.
    LandStartDisabled = "land-start-disabled" {},
    /// A jump to nowhere.
    JumpTarget = "jump-target" {
        /// The item or tag that it names.
        target: f64,
        /// The last item there is.
        last: usize,
    },
    /// A jump that repeats for ever.
    EndlessJump = "endless-jump" {},
    /// A jump that runs in a circle without flying.
    IdleJump = "idle-jump" {},
    /// More jumps than the vehicle tracks.
    TooManyJumps = "too-many-jumps" {
        /// Jumps.
        count: usize,
        /// How many small boards track.
        max: usize,
    },
    /// Far from home.
    FarFromHome = "far-from-home" {
        /// How far.
        distance_m: f64,
        /// The limit.
        far_m: f64,
    },
    /// The first destination is far from the plane.
    FarFirst = "far-first" {
        /// How far.
        distance_m: f64,
    },
    /// At or below the height of home, or of the ground.
    BelowHome = "below-home" {
        /// Its height.
        alt_m: f64,
        /// What that counts from.
        datum: Option<Datum>,
    },
    /// A leg shorter than the plane can turn.
    ShortLeg = "short-leg" {
        /// Length of the leg.
        length_m: f64,
        /// Radius of a turn.
        turn_radius_m: f64,
    },
    /// A final approach that is steep.
    SteepApproach = "steep-approach" {
        /// Height lost.
        drop_m: f64,
        /// Length of the approach.
        length_m: f64,
        /// Length from which it would not be steep.
        wanted_length_m: f64,
    },
    /// A final approach that does not descend.
    FlatApproach = "flat-approach" {},
    /// Outside the fence.
    OutsideFence = "outside-fence" {
        /// The rally point, counted from 1; null when it is an item, or home.
        rally_point: Option<usize>,
        /// The zone that forbids it, counted from 1.
        zone: usize,
        /// Whether that is a zone to stay in.
        is_inclusion: bool,
    },
    /// A leg that crosses the fence.
    LegCrossesFence = "leg-crosses-fence" {
        /// The zone, counted from 1.
        zone: usize,
    },
    /// Rehearsed: the plane comes down before it lands.
    FliesIntoGround = "flies-into-ground" {
        /// Where, degrees.
        lat_deg: f64,
        /// Where, degrees.
        lon_deg: f64,
    },
    /// Rehearsed: the plane comes near the ground.
    NearGround = "near-ground" {
        /// How near, at the worst place.
        clearance_m: f64,
        /// The clearance required there.
        wanted_m: f64,
        /// Where, degrees.
        lat_deg: f64,
        /// Where, degrees.
        lon_deg: f64,
    },
    /// Rehearsed: a height counts from the ground, which is not known.
    GroundNotKnown = "ground-not-known" {
        /// Its height above that ground; null without one.
        alt_m: Option<f64>,
        /// Whether the vehicle's terrain data are switched off (`TERRAIN_ENABLE` 0).
        is_off: bool,
    },
    /// Rehearsed: home's height is not that of the ground there.
    HomeOffGround = "home-off-ground" {
        /// How far it is off.
        difference_m: f64,
        /// Whether it lies above the ground.
        is_above: bool,
    },
    /// Rehearsed: the wind does not let the plane come nearer.
    HeldByWind = "held-by-wind" {
        /// The wind.
        wind_m_s: f64,
    },
    /// Rehearsed: the plane flies by and does not come near.
    WaypointMissed = "waypoint-missed" {
        /// How near it comes.
        distance_m: f64,
    },
    /// Rehearsed: the plane is not yet at the height that it should have there.
    HeightNotReached = "height-not-reached" {
        /// How far it is off.
        difference_m: f64,
        /// Whether it is too low.
        is_low: bool,
    },
    /// Rehearsed: the plane leaves the fence on its way.
    LeavesFence = "leaves-fence" {
        /// The zone, counted from 1.
        zone: usize,
    },
    /// Rehearsed: a return that is asked for on the way there ends in the ground.
    ReturnHitsGround = "return-hits-ground" {},
    /// Rehearsed: the wind does not let the plane come back from there.
    ReturnHeldByWind = "return-held-by-wind" {
        /// The wind.
        wind_m_s: f64,
    },
    /// Rehearsed: a return that is asked for on the way there leaves the fence.
    ReturnLeavesFence = "return-leaves-fence" {
        /// The zone, counted from 1.
        zone: usize,
    },
    /// Rehearsed: a landing that is broken off ends in the ground.
    GoAroundHitsGround = "go-around-hits-ground" {},
    /// Rehearsed: the plane touches the ground far from its landing point.
    LandsOff = "lands-off" {
        /// How far.
        distance_m: f64,
        /// Whether that is beyond it.
        is_long: bool,
    },
    /// Rehearsed: the wind comes from behind at the touch-down.
    LandsDownwind = "lands-downwind" {
        /// Its part from behind.
        tailwind_m_s: f64,
    },
    /// Rehearsed: less of the battery is left at the end than should be.
    BatteryBelowReserve = "battery-below-reserve" {
        /// Remaining charge, % of its capacity.
        left_pct: f64,
        /// What should be.
        reserve_pct: f64,
    },
    /// Rehearsed: the battery is empty before the end.
    BatteryEmpty = "battery-empty" {
        /// When, since the start.
        time_s: f64,
        /// Energy that the flight needs beyond what the battery holds.
        lacks_wh: f64,
    },
    /// A fence that every vehicle would refuse.
    BadFence = "bad-fence" {
        /// The fault.
        fault: FenceFault,
        /// The zone, counted from 1; null for the return point.
        zone: Option<usize>,
        /// Corners of the polygon.
        corners: Option<usize>,
        /// Radius of the circle, or null.
        radius_m: Option<f64>,
        /// Height of the return point, above home.
        alt_rel_home_m: Option<f64>,
    },
    /// A rally point that every vehicle would refuse, or that is badly placed.
    BadRally = "bad-rally" {
        /// The rally point, counted from 1.
        rally_point: usize,
        /// The fault.
        fault: RallyFault,
        /// Its height in its frame; null when it is not a number.
        #[cfg_attr(feature = "describe", schema(value_type = Option<f64>))]
        alt_m: f64,
    },
    /// Rehearsed: a line of a survey is not flown, or flown so far aside that no overlap remains.
    SurveyLineMissed = "survey-line-missed" {
        /// The line, counted from 1 in the order flown.
        line: usize,
        /// How far aside; null when it is not flown.
        distance_m: Option<f64>,
    },
    /// Rehearsed: ground that no picture of a survey shows.
    SurveyHoles = "survey-holes" {
        /// How many places.
        holes: usize,
        /// Side of a square as large as the largest.
        side_m: f64,
    },
}

impl std::fmt::Display for FindingCode {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(self.as_str())
    }
}

/// Something wrong or doubtful in a plan. `message` and `remedy` say it in English; `code` and `figures` say the same
/// to programs.
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "describe", derive(Serialize, ToSchema))]
pub struct Finding {
    /// How bad it is.
    pub severity: Severity,
    /// The item, counted from 1 as its seq on ArduPilot; null when it is about the whole plan, home, the fence or rally
    /// points.
    #[cfg_attr(feature = "describe", schema(required = true))]
    pub item: Option<usize>,
    /// The fault.
    pub message: String,
    /// How to fix it.
    pub remedy: String,
    /// The kind, with its figures.
    #[cfg_attr(feature = "describe", serde(flatten))]
    pub kind: FindingKind,
}

impl Finding {
    /// Its code.
    pub const fn code(&self) -> FindingCode {
        self.kind.code()
    }

    /// A finding in words; `item` is the one that it is about, with its index.
    pub(super) fn new(severity: Severity, kind: FindingKind, item: Option<(usize, &MissionItem)>) -> Self {
        let name = item.map_or_else(String::new, |(index, item)| format!("item {} ({})", index + 1, item.command));
        let (message, remedy) = sentences(&kind, &name);
        Self { severity, item: item.map(|(index, _)| index + 1), message, remedy, kind }
    }
}

impl std::fmt::Display for Finding {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}: {}", self.message, self.remedy)
    }
}

/// A height with what it counts from.
fn height(alt_m: f64, datum: Option<Datum>) -> String {
    datum.map_or_else(|| format!("{alt_m} m"), |datum| format!("{alt_m} m {}", datum.words()))
}

/// What is wrong and how to mend it, in English.
fn sentences(kind: &FindingKind, name: &str) -> (String, String) {
    use FindingKind::*;
    let (message, remedy): (String, &str) = match kind {
        EmptyMission { has_areas } => (
            "the mission is empty".to_owned(),
            if *has_areas {
                "send the fence and the rally points alone"
            } else {
                "add items; to empty the vehicle, clear its mission"
            },
        ),
        TooManyItems { count, max } => (
            format!("the mission has {count} items, the vehicle holds {max} beside home"),
            "split it, or widen the distance between survey lines",
        ),
        BadValue { field, value, wanted } => (format!("{name}: {field} is {value}"), wanted.problem()),
        UnsupportedCommand {} => (
            format!("{name} is no mission command of ArduPlane, which refuses the whole mission"),
            "delete it or choose another command",
        ),
        IgnoredCommand { needs_hover: true } => {
            (format!("{name} needs a plane that can hover"), "delete it, or say that the plane is a quadplane")
        }
        IgnoredCommand { needs_hover: false } => {
            (format!("{name} is for other vehicles; ArduPlane skips it"), "delete it")
        }
        ParamOutOfRange { label, value, unit, min, max, .. } => {
            let bound = |value: &Option<f64>| value.map_or("…".to_owned(), |value| value.to_string());
            let remedy = format!("choose from {} to {}", bound(min), bound(max));
            return (format!("{name}: {label} is {value} {unit}").trim_end().to_owned(), remedy);
        }
        ParamChanged { label, value, unit, kept, is_unused, .. } => {
            let value = format!("{value} {unit}");
            (
                format!("{name}: {label} of {} is kept as {kept}", value.trim_end()),
                if *is_unused { "set it to 0: ArduPlane does not use it" } else { "choose a value that is kept" },
            )
        }
        MissingPosition { missing: Missing::Place } => {
            (format!("{name} has no latitude or longitude"), "place it on the map")
        }
        MissingPosition { missing: Missing::Height } => (format!("{name} has no height"), "set one"),
        ZeroCoordinates { is_here: false } => (format!("{name} lies at 0/0, in the Atlantic"), "place it on the map"),
        ZeroCoordinates { is_here: true } => (
            format!("{name} lies at 0/0, so it is done where the plane is then"),
            "place it on the map, unless you mean that",
        ),
        NoTakeoff {} => (
            format!("the mission begins with {name}, not with a take-off"),
            "put a take-off first, or start it in the air",
        ),
        TakeoffTooLow { alt_m, datum } => (
            format!("{name} climbs to {}, which is not above home", height(*alt_m, *datum)),
            "give it a height to climb to, 30 m or more",
        ),
        NoLanding {} => (
            format!("the mission ends with {name}, neither landing nor return"),
            "end it with a landing or a return to launch",
        ),
        ItemsAfterLanding { next_item } => (
            format!("{name} lands before the mission ends; item {next_item} is not flown"),
            "move the landing to the end",
        ),
        EndlessLoiter { next_item } => (
            format!("{name} circles until it is told otherwise; item {next_item} is not flown by itself"),
            "give it turns or a time, or move it to the end",
        ),
        LandStartWithoutLanding { has_landing: false } => {
            (format!("{name} starts a landing sequence, but no landing follows"), "add a landing after it or delete it")
        }
        LandStartWithoutLanding { has_landing: true } => (
            format!("{name} is followed by the landing at once, without an approach"),
            "put a waypoint before the landing, in line with the runway",
        ),
        LandStartDisabled {} => (
            format!("{name}: with RTL_AUTOLAND 0 this vehicle refuses to arm with a landing sequence"),
            "set RTL_AUTOLAND to 2, so that a return flies it, or delete it",
        ),
        JumpTarget { target, last } => {
            return (format!("{name} jumps to {target}, which is no item"), format!("choose an item from 1 to {last}"));
        }
        EndlessJump {} => (
            format!("{name} repeats for ever; what follows it is never flown"),
            "give it a number of repeats, unless you mean it",
        ),
        IdleJump {} => {
            (format!("{name} jumps in a circle in which nothing is flown"), "choose an item before the last waypoint")
        }
        TooManyJumps { count, max } => {
            (format!("the mission has {count} jumps; small boards track {max}"), "repeat items instead of jumping")
        }
        FarFromHome { distance_m, far_m } => {
            return (
                format!("{name} lies {:.1} km from home", distance_m / 1_000.0),
                format!("check it; far is {:.0} km", far_m / 1_000.0),
            );
        }
        FarFirst { distance_m } => (
            format!("{name}, the first destination, lies {:.1} km from the plane", distance_m / 1_000.0),
            "check that the mission is for this place",
        ),
        BelowHome { alt_m, datum } => {
            let level = if *datum == Some(Datum::Terrain) { "the ground" } else { "home" };
            (
                format!("{name} lies at {}, not above {level}", height(*alt_m, *datum)),
                "raise it, unless the terrain falls away there",
            )
        }
        ShortLeg { length_m, turn_radius_m } => (
            format!("the leg to {name} is {length_m:.0} m long, the plane turns within {turn_radius_m:.0} m"),
            "move the waypoints apart or fly slower",
        ),
        SteepApproach { drop_m, length_m, wanted_length_m } => {
            return (
                format!("the approach to {name} drops {drop_m:.0} m in {length_m:.0} m; the plane will land long"),
                format!("begin it {wanted_length_m:.0} m away or more, or lower"),
            );
        }
        FlatApproach {} => {
            (format!("the approach to {name} does not descend"), "raise the waypoint before the landing")
        }
        OutsideFence { rally_point, zone, is_inclusion } => {
            let (subject, remedy) = match rally_point {
                Some(number) => (format!("rally point {number}"), "move it or the fence"),
                None if name.is_empty() => ("home".to_owned(), "move the fence"),
                None => (name.to_owned(), "move it or the fence"),
            };
            let side = if *is_inclusion { "outside inclusion" } else { "inside exclusion" };
            (format!("{subject} lies {side} zone {zone} of the fence"), remedy)
        }
        LegCrossesFence { zone } => {
            (format!("the leg to {name} crosses fence zone {zone}"), "lead it round, or change the fence")
        }
        NearGround { clearance_m, wanted_m, .. } => {
            return (
                format!("on the way to {name} the plane is {:.0} m above the ground", clearance_m.max(0.0)),
                format!("raise it by {:.0} m, or lead it round", (wanted_m - clearance_m).ceil()),
            );
        }
        GroundNotKnown { is_off: false, .. } => (
            format!(
                "the height of {name} counts from the ground, which is not known on the way: neither is the plane's height"
            ),
            "add elevation that covers it to the maps",
        ),
        GroundNotKnown { is_off: true, .. } => (
            format!(
                "the height of {name} counts from the ground, and with TERRAIN_ENABLE 0 the plane takes it from home"
            ),
            "set TERRAIN_ENABLE to 1, or count its height from home",
        ),
        HomeOffGround { difference_m, is_above } => {
            let side = if *is_above { "above" } else { "below" };
            (
                format!("home's height is {difference_m:.0} m {side} the ground that the maps have there"),
                "set home on the ground: heights above mean sea level are off by as much",
            )
        }
        FliesIntoGround { .. } => {
            (format!("on the way to {name} the plane flies into the ground"), "raise it and what lies around it")
        }
        HeldByWind { wind_m_s } => (
            format!("the plane comes no nearer to {name} in {wind_m_s:.0} m/s of wind"),
            "wait for less wind, or fly faster",
        ),
        WaypointMissed { distance_m } => (
            format!("the plane turns too wide for {name} and passes it {distance_m:.0} m away"),
            "move it away from the one before, fly slower, or widen WP_RADIUS",
        ),
        HeightNotReached { difference_m, is_low } => {
            let side = if *is_low { "too low" } else { "too high" };
            (
                format!("the plane is {difference_m:.0} m {side} at {name}"),
                "lengthen the leg, change the height, or climb and sink in a circle",
            )
        }
        LeavesFence { zone } => (
            format!("on the way to {name} the plane leaves the fence at zone {zone}"),
            "keep farther from it: turns are wider than the lines, and a return goes straight",
        ),
        ReturnHitsGround {} => (
            format!("a return that begins on the way to {name} flies into the ground"),
            "raise RTL_ALTITUDE, set RTL_CLIMB_MIN, or lead the way round the hill",
        ),
        ReturnHeldByWind { wind_m_s } => (
            format!("from the way to {name} the plane does not come back in {wind_m_s:.0} m/s of wind"),
            "wait for less wind, or fly faster",
        ),
        ReturnLeavesFence { zone } => (
            format!("a return that begins on the way to {name} leaves the fence at zone {zone}"),
            "set a rally point on this side of it, or fly round",
        ),
        GoAroundHitsGround {} => (
            format!("a go-around on the way to {name} flies into the ground"),
            "land the other way, or give the landing more room to climb out",
        ),
        LandsOff { distance_m, is_long: true } => (
            format!("the plane touches the ground {distance_m:.0} m beyond {name}"),
            "come in lower, slower or against the wind",
        ),
        LandsOff { distance_m, is_long: false } => (
            format!("the plane touches the ground {distance_m:.0} m before {name}"),
            "look at the approach: nothing may stand there",
        ),
        LandsDownwind { tailwind_m_s } => {
            (format!("at {name} {tailwind_m_s:.0} m/s of the wind come from behind"), "land the other way")
        }
        BatteryBelowReserve { left_pct, reserve_pct } => (
            format!("at the end of the flight {left_pct:.0} % of the battery is left, {reserve_pct:.0} % should be"),
            "shorten it, wait for less wind, or take a larger battery",
        ),
        BatteryEmpty { time_s, lacks_wh } => {
            let leg = if name.is_empty() { String::new() } else { format!(", on the way to {name}") };
            (
                format!(
                    "the battery is empty {:.0} min after the start{leg}; the flight wants {lacks_wh:.0} Wh more",
                    time_s / 60.0
                ),
                "shorten it, wait for less wind, or take a larger battery",
            )
        }
        BadFence { fault, zone, corners, radius_m, alt_rel_home_m } => {
            let zone = zone.map_or_else(|| "the fence".to_owned(), |zone| format!("fence zone {zone}"));
            let corners = corners.unwrap_or(0);
            match fault {
                FenceFault::TooFewCorners => (
                    format!("{zone} has {corners} corners, a polygon needs {SHAPE_MIN_CORNERS}"),
                    "add some or delete the zone",
                ),
                FenceFault::TooManyCorners => {
                    (format!("{zone} has {corners} corners, a vehicle takes {MAX_VERTICES}"), "simplify or split it")
                }
                FenceFault::Radius => {
                    let radius = radius_m.map_or_else(|| "no radius".to_owned(), |r| format!("a radius of {r} m"));
                    (format!("{zone} has {radius}, which makes no circle"), "give it one above 0 or delete the zone")
                }
                FenceFault::ReturnHeight => {
                    let height = alt_rel_home_m.map_or_else(|| "no number".to_owned(), |alt_m| format!("{alt_m} m"));
                    (
                        format!("the fence's return point has a height of {height}, which cannot be sent"),
                        "stay within 83,000 m",
                    )
                }
            }
        }
        BadRally { rally_point, fault, alt_m } => match fault {
            RallyFault::Height => {
                (format!("rally point {rally_point} lies at {alt_m} m"), "stay within 32,767 m, as ArduPilot stores it")
            }
            RallyFault::NotAboveHome => {
                (format!("rally point {rally_point} lies at {alt_m} m, not above home"), "raise it")
            }
            RallyFault::Frame => (
                format!("rally point {rally_point} has a frame without meaning for a place"),
                "count its height from sea level, home or the terrain",
            ),
        },
        SurveyLineMissed { line, distance_m } => (
            match distance_m {
                Some(off_m) => format!("at {name} the plane flies line {line} of the survey {off_m:.0} m aside"),
                None => format!("at {name} line {line} of the survey is not flown"),
            },
            "lengthen the lead-in, fly slower, or across the wind",
        ),
        SurveyHoles { holes, side_m } => (
            format!("{holes} places of the survey are on no picture, the largest some {side_m:.0} m across"),
            "overlap more, lengthen the lead-in, or wait for less wind",
        ),
    };
    (message, remedy.to_owned())
}
