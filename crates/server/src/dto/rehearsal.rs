//! Assessments of a plan before it is flown: findings, and rehearsals of one flight, of many flights, and of
//! contingencies.

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;
use vencejo_flight::checks::Finding;
use vencejo_flight::landing::Wind;
use vencejo_flight::profile::Clearance;
use vencejo_flight::progress::Trip;
use vencejo_flight::rehearsal::{
    Airframe, BatteryLack, BatterySettings, Doubts, Ending, Origin, Range, Reaction, Trigger,
};

use super::plan::{LatLon, Plan};

/// Assessment of a plan.
#[derive(Debug, Clone, PartialEq, Serialize, ToSchema)]
pub struct Assessment {
    /// Errors and doubts found in it.
    pub findings: Vec<Finding>,
    /// Its mission as flown.
    pub trip: Trip,
    /// Rehearsal of the mission; null when none was requested, or when no home is known.
    #[schema(required = true)]
    pub rehearsal: Option<Rehearsal>,
}

/// Rehearsal of a plan in a wind: the flight as simulated.
#[derive(Debug, Clone, PartialEq, Serialize, ToSchema)]
pub struct Rehearsal {
    /// Source of the airframe data.
    pub airframe: Origin,
    /// Whether the vehicle's own parameters were read; otherwise a default ArduPlane is assumed.
    pub knows_parameters: bool,
    /// Wind of the rehearsal.
    pub wind: Wind,
    /// Errors and doubts that the rehearsal shows; in an assessment, they are also among the plan's findings.
    pub findings: Vec<Finding>,
    /// Track, with as many points as are needed to draw it within a metre.
    pub track: RehearsedTrack,
    /// Position of each track point along the altitude profile of the plan (`plan_way`), metres, in which every item
    /// has its own position. It decreases after a jump.
    pub along_m: Vec<f64>,
    /// Smallest clearance above the ground, in that profile, without take-off, landing and climb-out; null when the
    /// terrain is unknown.
    #[schema(required = true)]
    pub lowest: Option<Clearance>,
    /// Items in the order flown; jumps repeat them.
    pub passages: Vec<RehearsedPassage>,
    /// How the flight ends.
    pub ending: Ending,
    /// Touchdown position; null when the plane does not touch down.
    #[schema(required = true)]
    pub touch_down: Option<LatLon>,
    /// Duration, seconds.
    pub duration_s: f64,
    /// Distance over ground, metres.
    pub distance_m: f64,
    /// Electrical energy; null when the plane's power is unknown.
    #[schema(required = true)]
    pub energy_wh: Option<f64>,
    /// Remaining charge of the battery; null when it cannot be computed.
    #[schema(required = true)]
    pub battery: Option<BatteryLeft>,
    /// The missing data because of which it cannot be computed; otherwise null.
    #[schema(required = true)]
    pub battery_unknown: Option<BatteryLack>,
    /// Whether terrain below the plan is still being loaded and was left out: repeat the request a moment later.
    pub is_ground_pending: bool,
}

/// Charge of a battery after a flight.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, ToSchema)]
pub struct BatteryLeft {
    /// Energy of a full battery.
    pub capacity_wh: f64,
    /// Charge at the end, percent of the capacity; negative when the flight needs more than the battery holds.
    pub left_pct: f64,
    /// Charge that should remain, percent of the capacity.
    pub reserve_pct: f64,
    /// Time at which it is empty, seconds since the beginning of the rehearsed flight; null when it does not become
    /// empty.
    #[schema(required = true)]
    pub empty_s: Option<f64>,
}

/// Airframe and battery for a rehearsal, in place of the vehicle's own.
#[derive(Debug, Clone, PartialEq, Default, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct PlaneProfile {
    /// Airframe, as from `POST /plan/learn` or `GET /vehicles/{id}/profile`.
    #[serde(default)]
    pub airframe: Option<Airframe>,
    /// Battery.
    #[serde(default)]
    pub battery: Option<BatterySettings>,
}

/// Model of a plane, estimated from a flight.
#[derive(Debug, Clone, PartialEq, Serialize, ToSchema)]
pub struct LearnedPlane {
    /// Airframe.
    pub airframe: Airframe,
    /// Wind of that flight.
    pub wind: Wind,
    /// Number of samples used.
    pub moments: usize,
    /// RMS difference between measured and modelled airspeed, metres per second.
    pub airspeed_error_m_s: f64,
}

/// Data with which a vehicle's plans are rehearsed.
#[derive(Debug, Clone, PartialEq, Serialize, ToSchema)]
pub struct VehicleProfile {
    /// Airframe according to its parameters; its power is measured in flight, as far as the flight was followed.
    pub airframe: Airframe,
    /// Whether its parameters were read; otherwise a default ArduPlane is assumed.
    pub knows_parameters: bool,
    /// Charge of a full battery, mAh; null when unknown.
    #[schema(required = true)]
    pub capacity_mah: Option<f64>,
    /// Present battery voltage; null when unknown.
    #[schema(required = true)]
    pub voltage_v: Option<f64>,
    /// Present charge, percent of the capacity; 100 when unknown.
    pub charge_pct: f64,
    /// Charge that should remain after landing, percent of the capacity.
    pub reserve_pct: f64,
    /// Model estimated from at most the last ten minutes of its flight, as far as they were followed; null when that is
    /// too little.
    #[schema(required = true)]
    pub learned: Option<LearnedPlane>,
}

/// A plan to be flown many times under uncertainty.
#[derive(Debug, Clone, PartialEq, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct SpreadRequest {
    /// The plan; without a home, the vehicle's home is used.
    pub plan: Plan,
    /// Vehicle that is to fly it.
    #[serde(default)]
    pub vehicle: Option<u16>,
    /// Expected wind; calm when absent.
    #[serde(default)]
    pub wind: Option<Wind>,
    /// Plane, in place of the vehicle's.
    #[serde(default)]
    pub profile: PlaneProfile,
    /// Number of flights, 1 to 1000; 200 by default.
    #[serde(default)]
    pub runs: Option<usize>,
    /// Uncertainty of the wind and the plane.
    #[serde(default)]
    pub doubts: Doubts,
    /// Random seed; the same seed gives the same result. 0 by default.
    #[serde(default)]
    pub seed: u64,
}

/// Result of many flights of one plan. Ranges contain nine flights in ten.
#[derive(Debug, Clone, PartialEq, Serialize, ToSchema)]
pub struct Spread {
    /// Number of flights.
    pub runs: usize,
    /// Number of flights by ending, most frequent first.
    pub endings: Vec<EndingCount>,
    /// Duration of the flights that ended like the expected one, seconds.
    pub duration_s: Range,
    /// Energy of those flights, Wh; null when the plane's power is unknown.
    #[schema(required = true)]
    pub energy_wh: Option<Range>,
    /// Charge that they leave, percent of the capacity; null when it cannot be computed.
    #[schema(required = true)]
    pub battery_left_pct: Option<Range>,
    /// Number of all flights that leave less than the reserve; null when it cannot be computed.
    #[schema(required = true)]
    pub below_reserve: Option<usize>,
    /// Distance of the touchdowns from the expected one, metres; null when there are none.
    #[schema(required = true)]
    pub touch_down_m: Option<Range>,
    /// Corridor of nine flights in ten, with a point every five seconds.
    pub corridor: Corridor,
}

/// Number of flights with one ending.
#[derive(Debug, Clone, PartialEq, Serialize, ToSchema)]
pub struct EndingCount {
    /// The ending.
    pub ending: Ending,
    /// Number of flights.
    pub count: usize,
}

/// Corridor of flights, as lists of equal length.
#[derive(Debug, Clone, PartialEq, Default, Serialize, ToSchema)]
pub struct Corridor {
    /// Time in the expected flight, seconds, ascending.
    pub time_s: Vec<f64>,
    /// Left edge.
    pub left: Vec<LatLon>,
    /// Right edge.
    pub right: Vec<LatLon>,
    /// Lower edge above home, metres.
    pub low_m: Vec<f64>,
    /// Upper edge above home, metres.
    pub high_m: Vec<f64>,
}

/// Track of a rehearsed flight, as lists of equal length.
#[derive(Debug, Clone, PartialEq, Default, Serialize, ToSchema)]
pub struct RehearsedTrack {
    /// Time since its beginning, seconds, ascending.
    pub time_s: Vec<f64>,
    /// Latitude, degrees.
    pub lat_deg: Vec<f64>,
    /// Longitude, degrees.
    pub lon_deg: Vec<f64>,
    /// Altitude above home, metres.
    pub height_m: Vec<f64>,
    /// Ground elevation below, above home, metres; null when no map contains it.
    pub ground_m: Vec<Option<f64>>,
    /// Equivalent airspeed, metres per second.
    pub airspeed_m_s: Vec<f64>,
    /// Ground speed, metres per second.
    pub groundspeed_m_s: Vec<f64>,
    /// Bank angle, degrees, positive to the right.
    pub bank_deg: Vec<f64>,
    /// Heading of the nose, degrees from true north.
    pub heading_deg: Vec<f64>,
    /// Current item, counted from 1; null during a return and after the landing.
    pub item: Vec<Option<u16>>,
}

/// Passage of one item.
#[derive(Debug, Clone, PartialEq, Serialize, ToSchema)]
pub struct RehearsedPassage {
    /// Number of the item, counted from 1.
    pub item: u16,
    /// Time at which it becomes the current item, seconds.
    pub begins_s: f64,
    /// Time at which it is reached or completed; null when it never is.
    #[schema(required = true)]
    pub reached_s: Option<f64>,
    /// Smallest distance to its position, metres; null for items other than waypoints and landings.
    #[schema(required = true)]
    pub nearest_m: Option<f64>,
}

/// A plan to rehearse.
#[derive(Debug, Clone, PartialEq, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct RehearsalRequest {
    /// The plan; without a home, the vehicle's home is used.
    pub plan: Plan,
    /// Vehicle that is to fly it; the plane is modelled by its parameters, as far as they were read.
    #[serde(default)]
    pub vehicle: Option<u16>,
    /// Wind; calm when absent.
    #[serde(default)]
    pub wind: Option<Wind>,
    /// Clearance to keep above the ground, 0 to 1000; 30 by default.
    #[serde(default)]
    pub clearance_m: Option<f64>,
    /// Plane, in place of the vehicle's.
    #[serde(default)]
    pub profile: PlaneProfile,
}

/// A contingency at a time in a plan or in the present flight.
#[derive(Debug, Clone, PartialEq, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct WhatIfRequest {
    /// The plan, with `at_s`; without a home, the vehicle's home is used. When both are absent, the vehicle's present
    /// flight is continued: its mission, GUIDED, LOITER, CIRCLE, RTL, or a mode steered by a pilot.
    #[serde(default)]
    pub plan: Option<Plan>,
    /// Time in the plan, seconds since the beginning of the rehearsed flight.
    #[serde(default)]
    pub at_s: Option<f64>,
    /// Vehicle that is to fly it; the plane is modelled by its parameters, as far as they were read.
    #[serde(default)]
    pub vehicle: Option<u16>,
    /// Wind; calm when absent.
    #[serde(default)]
    pub wind: Option<Wind>,
    /// Events to examine; all when absent.
    #[serde(default)]
    pub triggers: Option<Vec<Trigger>>,
    /// Plane, in place of the vehicle's.
    #[serde(default)]
    pub profile: PlaneProfile,
    /// For a flight that is being followed: the forecast made when following began, for comparison.
    #[serde(default)]
    pub begun: Option<Beginning>,
}

/// Forecast of a flight, made when following it began, taken from an answer about the present flight.
#[derive(Debug, Clone, PartialEq, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct Beginning {
    /// `now` of that answer.
    pub now: FlightNow,
    /// Track of its `ahead`.
    pub track: ExpectedTrack,
}

/// The part of a rehearsed track that shows whether a flight is late or low, as lists of equal length.
#[derive(Debug, Clone, PartialEq, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct ExpectedTrack {
    /// Time since its beginning, seconds, ascending.
    pub time_s: Vec<f64>,
    /// Latitude, degrees.
    pub lat_deg: Vec<f64>,
    /// Longitude, degrees.
    pub lon_deg: Vec<f64>,
    /// Altitude above home, metres.
    pub height_m: Vec<f64>,
    /// Current item, counted from 1; null during a return and after the landing.
    pub item: Vec<Option<u16>>,
}

/// Time of a flight on the vehicle's own clock, which runs faster in some simulators.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct FlightNow {
    /// Time since the vehicle booted; null when unknown.
    #[schema(required = true)]
    pub boot_s: Option<f64>,
    /// Remaining charge of its battery; null when unknown.
    #[schema(required = true)]
    pub battery_pct: Option<f64>,
}

/// Comparison of a flight with its forecast; values are null when unknown, for example away from the expected track.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, ToSchema)]
pub struct Outlook {
    /// Delay; negative when early.
    #[schema(required = true)]
    pub late_s: Option<f64>,
    /// Altitude below the forecast, metres; negative when above it. Null during take-off and fast changes of altitude.
    #[schema(required = true)]
    pub low_m: Option<f64>,
    /// Expected charge at the end of `ahead` if consumption continues as since the beginning; null until 2 % have been
    /// used.
    #[schema(required = true)]
    pub battery_pct: Option<f64>,
}

/// Contingencies at a time in a flight.
#[derive(Debug, Clone, PartialEq, Serialize, ToSchema)]
pub struct WhatIfs {
    /// The time, seconds since the beginning of the rehearsed flight; 0 is now for the vehicle's present flight.
    pub at_s: f64,
    /// Position of the plane at that time; null on the ground and after the flight, when there are no contingencies.
    #[schema(required = true)]
    pub at: Option<LatLon>,
    /// Altitude above home at that time, metres.
    pub height_m: f64,
    /// Continuation of the flight when nothing happens; null for a time in a plan, whose own rehearsal contains it, and
    /// while a pilot steers.
    #[schema(required = true)]
    pub ahead: Option<RehearsedFlight>,
    /// Whether it is known how much of the present circle has been flown. If not, for example when the station was
    /// started while the vehicle circled, `ahead` includes the whole circle, and whether the flight is late is unknown
    /// until the vehicle proceeds to the next item.
    pub is_circle_known: bool,
    /// For the vehicle's present flight: time and charge from which later requests compare (`begun`); null for a time
    /// in a plan, and while it is unknown how much of its circle has been flown.
    #[schema(required = true)]
    pub now: Option<FlightNow>,
    /// Comparison with the forecast at the beginning; null without `begun` or `ahead`.
    #[schema(required = true)]
    pub outlook: Option<Outlook>,
    /// One result for each requested event.
    pub what_ifs: Vec<WhatIf>,
    /// Area that can be reached without thrust, as a ring of positions clockwise from north.
    pub glide_range: Vec<LatLon>,
}

/// A contingency: one event and its consequences.
#[derive(Debug, Clone, PartialEq, Serialize, ToSchema)]
pub struct WhatIf {
    /// The event.
    pub trigger: Trigger,
    /// Decisions of the vehicle in order of time; empty when its settings do not act on the event.
    pub decisions: Vec<Decision>,
    /// Final reaction.
    pub reaction: Reaction,
    /// Flight after the event; null when the mission continues as rehearsed.
    #[schema(required = true)]
    pub flown: Option<RehearsedFlight>,
}

/// A decision of a vehicle.
#[derive(Debug, Clone, PartialEq, Serialize, ToSchema)]
pub struct Decision {
    /// Time, seconds since the beginning of the rehearsed flight.
    pub time_s: f64,
    /// Reaction.
    pub reaction: Reaction,
}

/// A rehearsed flight from some time to its end.
#[derive(Debug, Clone, PartialEq, Serialize, ToSchema)]
pub struct RehearsedFlight {
    /// Track, with as many points as are needed to draw it within a metre.
    pub track: RehearsedTrack,
    /// How the flight ends.
    pub ending: Ending,
    /// Touchdown position; null when the plane does not touch down.
    #[schema(required = true)]
    pub touch_down: Option<LatLon>,
    /// End time, seconds since the beginning of the rehearsed flight.
    pub ends_s: f64,
    /// Distance over ground since that beginning, metres.
    pub distance_m: f64,
    /// Electrical energy since that beginning; null when the plane's power is unknown.
    #[schema(required = true)]
    pub energy_wh: Option<f64>,
    /// Remaining charge of the battery; null when it cannot be computed.
    #[schema(required = true)]
    pub battery: Option<BatteryLeft>,
}
