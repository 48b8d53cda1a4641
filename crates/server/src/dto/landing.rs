//! Landings: design request and result.

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;
use vencejo_flight::approaches::{LandingPart, LandingReason, Verdict};
use vencejo_flight::landing::{LandingDirection, Wind};
use vencejo_flight::rehearsal::Ending;

use super::plan::{LatLon, Plan, PlanItem};

/// Design request for a landing at a point or on a runway. Values that are not given come from the vehicle's
/// parameters, as far as they were read, else from the defaults for a small plane with ArduPlane.
#[derive(Debug, Clone, PartialEq, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct LandingRequest {
    /// Landing point, in place of a runway.
    #[serde(default)]
    pub at: Option<LatLon>,
    /// Runway, in place of a point. The landing point is its middle, or 150 m from its beginning when it is longer than
    /// 300 m.
    #[serde(default)]
    pub runway: Option<Runway>,
    /// Vehicle that is to land: airspeed, circle, slope and `DO_LAND_START` are chosen for it.
    #[serde(default)]
    pub vehicle: Option<u16>,
    /// Course of the final leg, from true north; of a runway's two directions, the nearer one is used. When absent,
    /// `coming_from` gives the course, else the wind; a runway is landed on into the wind, or in calm air from its
    /// beginning.
    #[serde(default)]
    pub course_deg: Option<f64>,
    /// Position that the plane comes from; it gives no direction when it is nearer than 20 m.
    #[serde(default)]
    pub coming_from: Option<LatLon>,
    /// Plan that the landing is to end, in place of `coming_from` and `home`. The plane comes from the plan's last
    /// position before the landing; when no course is given, it lands into a wind of 2 m/s or more.
    #[serde(default)]
    pub plan: Option<Plan>,
    /// Wind; below 1 m/s it gives no direction.
    #[serde(default)]
    pub wind: Option<Wind>,
    /// Ground elevation at the landing point above home, −1000 to 1000. When absent, the maps give it, for which `home`
    /// is needed; else it is home's.
    #[serde(default)]
    pub ground_rel_home_m: Option<f64>,
    /// Home position. With it, the maps give the terrain below the approach and the clearance above it.
    #[serde(default)]
    pub home: Option<LatLon>,
    /// Approach airspeed, 5 to 60; by default the vehicle's, else 22.
    #[serde(default)]
    pub airspeed_m_s: Option<f64>,
    /// Steepest slope of the final leg, height over distance, 0.02 to 0.25; by default 0.08, or less for a vehicle with
    /// a low sink rate.
    #[serde(default)]
    pub slope: Option<f64>,
    /// Height above the ground at which the final leg begins, 15 to 200; 40 by default.
    #[serde(default)]
    pub final_height_m: Option<f64>,
    /// Smallest radius of the circle, 20 to 500; by default the vehicle's, else 80.
    #[serde(default)]
    pub radius_m: Option<f64>,
    /// Whether the circle is clockwise, to the right of the final leg; by default as the vehicle circles, else yes.
    /// Alternatives include both sides.
    #[serde(default)]
    pub is_clockwise: Option<bool>,
    /// Whether `DO_LAND_START` precedes the landing; by default yes, unless the vehicle's return does not use it. An
    /// ArduPlane with `RTL_AUTOLAND` 0 refuses to arm with one.
    #[serde(default)]
    pub has_land_start: Option<bool>,
}

/// A runway, usable in both directions; 20 m to 10 km long.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct Runway {
    /// One end.
    pub begin: LatLon,
    /// The other end.
    pub end: LatLon,
}

/// A designed landing with one part moved.
#[derive(Debug, Clone, PartialEq, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct LandingMove {
    /// The landing as designed: an optional `DO_LAND_START`, `NAV_LOITER_TO_ALT`, `NAV_LAND`, with altitudes above
    /// home.
    pub items: Vec<PlanItem>,
    /// Part to move.
    pub part: LandingPart,
    /// New position.
    pub to: LatLon,
    /// Wind, where known: the final leg and the circle are enlarged as it requires.
    #[serde(default)]
    pub wind: Option<Wind>,
    /// Ground elevation above home at the landing point's new position; when absent, the point keeps its altitude.
    #[serde(default)]
    pub ground_rel_home_m: Option<f64>,
    /// Vehicle that is to land.
    #[serde(default)]
    pub vehicle: Option<u16>,
}

/// One of several possible landings.
#[derive(Debug, Clone, PartialEq, Serialize, ToSchema)]
pub struct LandingAlternative {
    /// The landing.
    pub landing: Landing,
    /// Whether its circle is clockwise, to the right of the final leg.
    pub is_clockwise: bool,
    /// Crosswind on the final leg, positive from the right; null when the wind is unknown.
    #[schema(required = true)]
    pub crosswind_m_s: Option<f64>,
    /// How the rehearsed approach ends.
    pub ending: Ending,
    /// Distance of the touchdown from the landing point along the final leg, metres, negative before it; null when the
    /// plane does not touch down.
    #[schema(required = true)]
    pub touch_down_m: Option<f64>,
    /// Distance of the plane's final position from the landing point, likewise.
    #[schema(required = true)]
    pub rest_m: Option<f64>,
    /// Time from the preceding position, or from home.
    pub duration_s: f64,
    /// Recommendation.
    pub verdict: Verdict,
    /// Reasons for and against it.
    pub reasons: Vec<LandingReasonText>,
}

/// A reason for or against a landing.
#[derive(Debug, Clone, PartialEq, Serialize, ToSchema)]
pub struct LandingReasonText {
    /// The reason in English.
    pub message: String,
    /// The reason, with its values.
    #[serde(flatten)]
    pub reason: LandingReason,
}

/// A landing, ready to be appended to a mission.
#[derive(Debug, Clone, PartialEq, Serialize, ToSchema)]
pub struct Landing {
    /// An optional `DO_LAND_START`, `NAV_LOITER_TO_ALT`, `NAV_LAND`; altitudes above home.
    pub items: Vec<PlanItem>,
    /// Course of the final leg, from true north, 0 to 360.
    pub course_deg: f64,
    /// What determined the course.
    pub direction: LandingDirection,
    /// Beginning of the final leg.
    pub leaves: LatLon,
    /// Altitude there, above home.
    pub leaves_alt_rel_home_m: f64,
    /// Length of the final leg.
    pub final_m: f64,
    /// Slope of the final leg, height over distance.
    pub slope: f64,
    /// Radius of the circle.
    pub radius_m: f64,
    /// Headwind on the final leg, negative for a tailwind; null when the wind is unknown.
    #[schema(required = true)]
    pub headwind_m_s: Option<f64>,
    /// Ground speed on the final leg; null when the wind is unknown.
    #[schema(required = true)]
    pub groundspeed_m_s: Option<f64>,
    /// Cautions for the pilot.
    pub cautions: Vec<LandingCaution>,
}

/// A caution for the pilot before a landing is flown.
#[derive(Debug, Clone, PartialEq, Serialize, ToSchema)]
pub struct LandingCaution {
    /// `ground-not-known`, `steep-approach`, `tailwind` or `ground-near`.
    pub code: String,
    /// The caution in English.
    pub message: String,
}
