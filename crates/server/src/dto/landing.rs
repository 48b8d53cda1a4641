//! Landings: what one is designed from, and what comes of it.

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;
use vencejo_flight::approaches::{LandingPart, LandingReason, Verdict};
use vencejo_flight::landing::{LandingDirection, Wind};
use vencejo_flight::rehearsal::Ending;

use super::plan::{LatLon, Plan, PlanItem};

/// What a landing is designed from: a point or a runway. What is not given is the vehicle's, as far as its parameters were read, else that of a
/// small plane on an ArduPlane.
#[derive(Debug, Clone, PartialEq, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct LandingRequest {
    /// Where to touch down, in place of a runway.
    #[serde(default)]
    pub at: Option<LatLon>,
    /// The runway, in place of a point: the landing point lies in its middle, on one of more than 300 m at 150 m.
    #[serde(default)]
    pub runway: Option<Runway>,
    /// The vehicle that is to land: airspeed, circle, slope and `DO_LAND_START` are laid out for it.
    #[serde(default)]
    pub vehicle: Option<u16>,
    /// Course of the final leg from true north; of a runway's two directions the nearer one is flown. Without it `coming_from` gives the course, else
    /// the wind; a runway is landed on into the wind, in calm air from its beginning.
    #[serde(default)]
    pub course_deg: Option<f64>,
    /// Where the plane comes from; nearer than 20 m it gives no direction.
    #[serde(default)]
    pub coming_from: Option<LatLon>,
    /// The plan that it is to end, in place of `coming_from` and `home`: the plane comes from that plan's last place before the landing, and lands
    /// into a wind of 2 m/s or more where no course is asked for.
    #[serde(default)]
    pub plan: Option<Plan>,
    /// Below 1 m/s it gives no direction.
    #[serde(default)]
    pub wind: Option<Wind>,
    /// Height of the ground at the point above home, −1000 to 1000; where it is not given, that of the maps, for which `home` is needed;
    /// else home's.
    #[serde(default)]
    pub ground_rel_home_m: Option<f64>,
    /// Where home is: with it the maps tell the ground below the approach, and how near that comes.
    #[serde(default)]
    pub home: Option<LatLon>,
    /// Of the approach, 5 to 60; the vehicle's, else 22.
    #[serde(default)]
    pub airspeed_m_s: Option<f64>,
    /// Steepest slope of the final leg, height over distance, 0.02 to 0.25; 0.08 by default, less for a vehicle that sinks slowly.
    #[serde(default)]
    pub slope: Option<f64>,
    /// Height above the ground where the final leg begins, 15 to 200; 40 by default.
    #[serde(default)]
    pub final_height_m: Option<f64>,
    /// Smallest radius of the circle, 20 to 500; the vehicle's, else 80.
    #[serde(default)]
    pub radius_m: Option<f64>,
    /// Whether the circle is flown clockwise, to the right of the final leg; as the vehicle circles, else yes. Alternatives have both sides.
    #[serde(default)]
    pub is_clockwise: Option<bool>,
    /// Whether `DO_LAND_START` goes before it; where the vehicle's return looks for it, else yes. An ArduPlane with `RTL_AUTOLAND` 0 does not arm
    /// with one.
    #[serde(default)]
    pub has_land_start: Option<bool>,
}

/// A line to land on, in either direction; 20 m to 10 km long.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct Runway {
    /// One end.
    pub begin: LatLon,
    /// The other.
    pub end: LatLon,
}

/// A landing of which one part is moved.
#[derive(Debug, Clone, PartialEq, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct LandingMove {
    /// The landing as it was designed: `DO_LAND_START` or not, `NAV_LOITER_TO_ALT`, `NAV_LAND`, with heights above home.
    pub items: Vec<PlanItem>,
    /// What is moved.
    pub part: LandingPart,
    /// Where to.
    pub to: LatLon,
    /// The wind, where it is known: the leg grows and the circle widens as it needs.
    #[serde(default)]
    pub wind: Option<Wind>,
    /// Height of the ground above home where the point is moved to; without it the point keeps its height.
    #[serde(default)]
    pub ground_rel_home_m: Option<f64>,
    /// The vehicle that is to land.
    #[serde(default)]
    pub vehicle: Option<u16>,
}

/// A landing to choose.
#[derive(Debug, Clone, PartialEq, Serialize, ToSchema)]
pub struct LandingAlternative {
    /// The landing.
    pub landing: Landing,
    /// Whether its circle is flown clockwise, to the right of the final leg.
    pub is_clockwise: bool,
    /// The wind across the final leg, positive from the right; null when no wind is known.
    #[schema(required = true)]
    pub crosswind_m_s: Option<f64>,
    /// How the rehearsed approach ends.
    pub ending: Ending,
    /// Where it touches the ground, metres beyond the point along the final leg, negative before it; null where it does not.
    #[schema(required = true)]
    pub touch_down_m: Option<f64>,
    /// Where the plane comes to rest, likewise.
    #[schema(required = true)]
    pub rest_m: Option<f64>,
    /// Time from the place that the plane comes from, or from home.
    pub duration_s: f64,
    /// Whether to fly it.
    pub verdict: Verdict,
    /// What speaks for and against it.
    pub reasons: Vec<LandingReasonText>,
}

/// What speaks for or against a landing.
#[derive(Debug, Clone, PartialEq, Serialize, ToSchema)]
pub struct LandingReasonText {
    /// It in English.
    pub message: String,
    /// What it is, with its figures.
    #[serde(flatten)]
    pub reason: LandingReason,
}

/// A landing, ready to be the end of a mission.
#[derive(Debug, Clone, PartialEq, Serialize, ToSchema)]
pub struct Landing {
    /// `DO_LAND_START` where asked for, `NAV_LOITER_TO_ALT`, `NAV_LAND`; heights above home.
    pub items: Vec<PlanItem>,
    /// Course of the final leg at the point from true north, 0 to 360.
    pub course_deg: f64,
    /// What gave it.
    pub direction: LandingDirection,
    /// Where the final leg begins.
    pub leaves: LatLon,
    /// Height there.
    pub leaves_alt_rel_home_m: f64,
    /// Length of the final leg.
    pub final_m: f64,
    /// Its slope, height over distance.
    pub slope: f64,
    /// Radius of the circle.
    pub radius_m: f64,
    /// Part of the wind against the plane on the final leg, negative from behind; null when no wind is known.
    #[schema(required = true)]
    pub headwind_m_s: Option<f64>,
    /// Speed over ground on the final leg; null when no wind is known.
    #[schema(required = true)]
    pub groundspeed_m_s: Option<f64>,
    /// What the pilot should know.
    pub cautions: Vec<LandingCaution>,
}

/// What the pilot should know of a landing before it is flown.
#[derive(Debug, Clone, PartialEq, Serialize, ToSchema)]
pub struct LandingCaution {
    /// `ground-not-known`, `steep-approach`, `tailwind` or `ground-near`.
    pub code: String,
    /// It in English.
    pub message: String,
}
