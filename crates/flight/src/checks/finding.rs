//! The findings: their kinds with figures. The English texts are in `english`.
//!
//! A kind is a stable code with named figures; a name ends in its unit and datum. Front doors hand both on, so that the
//! same can be shown in other languages and units; [`Finding::message`] and [`Finding::remedy`] are English.

#[cfg(feature = "describe")]
use serde::Serialize;
#[cfg(feature = "describe")]
use utoipa::ToSchema;

use crate::plan::{MavFrame, MissionItem, Wanted};
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

    pub(super) const fn words(self) -> &'static str {
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
        /// A return point at latitude 0, longitude 0.
        ReturnPlace = "return-place",
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
    /// An airspeed outside the limits of the vehicle, which keeps the one it has.
    SpeedNotTaken = "speed-not-taken" {
        /// The airspeed.
        speed_m_s: f64,
        /// The lowest that it takes; null when it is not known.
        min_m_s: Option<f64>,
        /// The highest that it takes; null when it is not known.
        max_m_s: Option<f64>,
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
    /// Farther from home and from the plane than it flies.
    OutOfReach = "out-of-reach" {
        /// To home or the plane, whichever is nearer.
        distance_m: f64,
        /// The limit.
        reach_m: f64,
        /// Whether the place is in reach with latitude and longitude swapped.
        is_swapped: bool,
    },
    /// A rally point, zone or return point that is as far away: nearly always one with its coordinates confused, and then
    /// nothing is where it is wanted.
    AreaOutOfReach = "area-out-of-reach" {
        /// The rally point, counted from 1.
        rally_point: Option<usize>,
        /// The zone of the fence, counted from 1; null, as the rally point, for the fence's return point.
        fence_zone: Option<usize>,
        /// To home or the plane, whichever is nearer; of a zone to its edge.
        distance_m: f64,
        /// The limit.
        reach_m: f64,
        /// Whether it is in reach with latitude and longitude swapped.
        is_swapped: bool,
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
    /// A landing on the field of home, at another height than the field's.
    LandingOffField = "landing-off-field" {
        /// How far its point lies above the field.
        off_m: f64,
        /// Whether it lies under it, so far.
        is_under: bool,
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
    /// The return point of the fence is outside the fence.
    ReturnPointOutsideFence = "return-point-outside-fence" {
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
}

impl std::fmt::Display for Finding {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}: {}", self.message, self.remedy)
    }
}
