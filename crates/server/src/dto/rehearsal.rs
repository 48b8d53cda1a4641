//! What is told of a plan before it is flown: findings, and rehearsals, once, many times, and when something happens on the way.

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

/// What the core says of a plan.
#[derive(Debug, Clone, PartialEq, Serialize, ToSchema)]
pub struct Assessment {
    /// What is wrong or doubtful in it.
    pub findings: Vec<Finding>,
    /// Its mission as it is flown.
    pub trip: Trip,
    /// The plane's way through it; null where it was not asked for, or no home is known.
    #[schema(required = true)]
    pub rehearsal: Option<Rehearsal>,
}

/// A plan as the plane would fly it in a wind.
#[derive(Debug, Clone, PartialEq, Serialize, ToSchema)]
pub struct Rehearsal {
    /// What is taken for the plane.
    pub airframe: Origin,
    /// Whether the vehicle's own parameters were read; without, it is an ArduPlane as it comes.
    pub knows_parameters: bool,
    /// The wind of it.
    pub wind: Wind,
    /// What it shows to be wrong or doubtful; in an assessment these are among the plan's findings too.
    pub findings: Vec<Finding>,
    /// The track, as many moments as it takes to draw it within a metre.
    pub track: RehearsedTrack,
    /// Where each moment of the track stands in the height profile of the plan (`plan_way`), metres: each item is where it is there. After a jump it
    /// goes back.
    pub along_m: Vec<f64>,
    /// Where it is nearest to the ground, in that profile; take-off, landing and the climb out apart. Null where the ground is nowhere known.
    #[schema(required = true)]
    pub lowest: Option<Clearance>,
    /// The items in the order flown; jumps repeat them.
    pub passages: Vec<RehearsedPassage>,
    /// How it ends.
    pub ending: Ending,
    /// Where the ground is touched; null where it is not.
    #[schema(required = true)]
    pub touch_down: Option<LatLon>,
    /// Until its end, seconds.
    pub duration_s: f64,
    /// Way over ground, metres.
    pub distance_m: f64,
    /// Electrical energy; null where the plane's power is not known.
    #[schema(required = true)]
    pub energy_wh: Option<f64>,
    /// What is left of the battery; null where that cannot be told.
    #[schema(required = true)]
    pub battery: Option<BatteryLeft>,
    /// What is not known, so that it cannot; else null.
    #[schema(required = true)]
    pub battery_unknown: Option<BatteryLack>,
    /// Whether ground below the plan is still being looked up that this was flown without: ask again a moment later.
    pub is_ground_pending: bool,
}

/// What a flight leaves of a battery.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, ToSchema)]
pub struct BatteryLeft {
    /// Energy of a full one.
    pub capacity_wh: f64,
    /// Left at the end, of its capacity; below 0 as much more is wanted than it holds.
    pub left_pct: f64,
    /// What should be left, likewise.
    pub reserve_pct: f64,
    /// When it is empty, seconds since the rehearsed flight's beginning; null: it is not.
    #[schema(required = true)]
    pub empty_s: Option<f64>,
}

/// The airframe and the battery that a plan is rehearsed with in place of the vehicle's.
#[derive(Debug, Clone, PartialEq, Default, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct PlaneProfile {
    /// As `POST /plan/learn` and `GET /vehicles/{id}/profile` tell it.
    #[serde(default)]
    pub airframe: Option<Airframe>,
    /// What is said of the battery.
    #[serde(default)]
    pub battery: Option<BatterySettings>,
}

/// What a flight taught of the plane that flew it.
#[derive(Debug, Clone, PartialEq, Serialize, ToSchema)]
pub struct LearnedPlane {
    /// It.
    pub airframe: Airframe,
    /// The wind of that flight.
    pub wind: Wind,
    /// Moments that it rests on.
    pub moments: usize,
    /// How far measured and modelled airspeeds are apart, metres a second RMS.
    pub airspeed_error_m_s: f64,
}

/// What a vehicle's plans are rehearsed with.
#[derive(Debug, Clone, PartialEq, Serialize, ToSchema)]
pub struct VehicleProfile {
    /// The airframe, as its parameters tell it; its power is that of its flight as far as it was followed.
    pub airframe: Airframe,
    /// Whether its parameters were read; without, it is an ArduPlane as it comes.
    pub knows_parameters: bool,
    /// Charge of a full battery, mAh; null where it is not known.
    #[schema(required = true)]
    pub capacity_mah: Option<f64>,
    /// Its voltage now; null where it is not known.
    #[schema(required = true)]
    pub voltage_v: Option<f64>,
    /// What it holds, of its capacity; 100 where nothing is told.
    pub charge_pct: f64,
    /// What should be left at a landing, of its capacity.
    pub reserve_pct: f64,
    /// What its flight teaches, as far as it was followed and no longer than the last ten minutes in the air; null where that is too little.
    #[schema(required = true)]
    pub learned: Option<LearnedPlane>,
}

/// A plan to fly many times.
#[derive(Debug, Clone, PartialEq, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct SpreadRequest {
    /// The plan; without a home the vehicle's is taken.
    pub plan: Plan,
    /// The vehicle that is to fly it.
    #[serde(default)]
    pub vehicle: Option<u16>,
    /// The expected wind; calm when absent.
    #[serde(default)]
    pub wind: Option<Wind>,
    /// The plane, in place of the vehicle's.
    #[serde(default)]
    pub profile: PlaneProfile,
    /// Flights, 1 to 1000; 200 by default.
    #[serde(default)]
    pub runs: Option<usize>,
    /// How much may be otherwise than expected.
    #[serde(default)]
    pub doubts: Doubts,
    /// Which winds and planes; the same seed gives the same answer. 0 by default.
    #[serde(default)]
    pub seed: u64,
}

/// What many flights of one plan show. A range is that of nine flights in ten.
#[derive(Debug, Clone, PartialEq, Serialize, ToSchema)]
pub struct Spread {
    /// Flights.
    pub runs: usize,
    /// How many ended how, the most first.
    pub endings: Vec<EndingCount>,
    /// Duration of those that ended as the expected one, seconds.
    pub duration_s: Range,
    /// Energy of the same, Wh; null where the plane's power is not known.
    #[schema(required = true)]
    pub energy_wh: Option<Range>,
    /// What the same leave of the battery, % of its capacity; null where that cannot be told.
    #[schema(required = true)]
    pub battery_left_pct: Option<Range>,
    /// How many of all leave less than its reserve; null likewise.
    #[schema(required = true)]
    pub below_reserve: Option<usize>,
    /// Distance of touch-downs from the expected one, metres; null without any.
    #[schema(required = true)]
    pub touch_down_m: Option<Range>,
    /// Where nine flights in ten pass, a moment every five seconds.
    pub corridor: Corridor,
}

/// How often a flight ended so.
#[derive(Debug, Clone, PartialEq, Serialize, ToSchema)]
pub struct EndingCount {
    /// How.
    pub ending: Ending,
    /// How often.
    pub count: usize,
}

/// Both sides of where flights pass, a list for each value.
#[derive(Debug, Clone, PartialEq, Default, Serialize, ToSchema)]
pub struct Corridor {
    /// Moments of the expected flight, seconds, growing.
    pub time_s: Vec<f64>,
    /// The left side.
    pub left: Vec<LatLon>,
    /// The right side.
    pub right: Vec<LatLon>,
    /// Lowest above home, metres.
    pub low_m: Vec<f64>,
    /// Highest, likewise.
    pub high_m: Vec<f64>,
}

/// Moments of a rehearsed flight, a list for each value.
#[derive(Debug, Clone, PartialEq, Default, Serialize, ToSchema)]
pub struct RehearsedTrack {
    /// Since its beginning, seconds, growing.
    pub time_s: Vec<f64>,
    /// Degrees.
    pub lat_deg: Vec<f64>,
    /// Degrees.
    pub lon_deg: Vec<f64>,
    /// Above home, metres.
    pub height_m: Vec<f64>,
    /// Height of the ground below, above home, metres; null where no map knows it.
    pub ground_m: Vec<Option<f64>>,
    /// Equivalent airspeed, metres a second.
    pub airspeed_m_s: Vec<f64>,
    /// Over ground, metres a second.
    pub groundspeed_m_s: Vec<f64>,
    /// Bank, degrees, to the right positive.
    pub bank_deg: Vec<f64>,
    /// Heading of the nose, degrees from true north.
    pub heading_deg: Vec<f64>,
    /// Item that is flown, counted from 1; null in a return and after the landing.
    pub item: Vec<Option<u16>>,
}

/// One item on the way.
#[derive(Debug, Clone, PartialEq, Serialize, ToSchema)]
pub struct RehearsedPassage {
    /// Counted from 1.
    pub item: u16,
    /// When the plane begins to fly to it, seconds.
    pub begins_s: f64,
    /// When it is reached or done; null: never.
    #[schema(required = true)]
    pub reached_s: Option<f64>,
    /// How near the plane comes to its place, metres; null for what is no waypoint and no landing.
    #[schema(required = true)]
    pub nearest_m: Option<f64>,
}

/// A plan to rehearse.
#[derive(Debug, Clone, PartialEq, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct RehearsalRequest {
    /// The plan; without a home the vehicle's is taken.
    pub plan: Plan,
    /// The vehicle that is to fly it: its parameters, as far as they were read, are the plane's.
    #[serde(default)]
    pub vehicle: Option<u16>,
    /// The wind; calm when absent.
    #[serde(default)]
    pub wind: Option<Wind>,
    /// Height above the ground that the flight should keep, 0 to 1000; 30 by default.
    #[serde(default)]
    pub clearance_m: Option<f64>,
    /// The plane, in place of the vehicle's.
    #[serde(default)]
    pub profile: PlaneProfile,
}

/// What may happen at a moment of a plan, and wants to be known.
#[derive(Debug, Clone, PartialEq, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct WhatIfRequest {
    /// The plan, with `at_s`; without a home the vehicle's is taken. Absent both: from now on as the vehicle flies, in its mission, GUIDED,
    /// LOITER, CIRCLE, RTL, or a mode that a pilot steers.
    #[serde(default)]
    pub plan: Option<Plan>,
    /// A moment of the plan, seconds since the rehearsed flight's beginning.
    #[serde(default)]
    pub at_s: Option<f64>,
    /// The vehicle that is to fly it: its parameters, as far as they were read, are the plane's.
    #[serde(default)]
    pub vehicle: Option<u16>,
    /// The wind; calm when absent.
    #[serde(default)]
    pub wind: Option<Wind>,
    /// What happens; everything when absent.
    #[serde(default)]
    pub triggers: Option<Vec<Trigger>>,
    /// The plane, in place of the vehicle's.
    #[serde(default)]
    pub profile: PlaneProfile,
    /// Of a flight that is followed: what was expected of it when that began, beside which it is told how it goes.
    #[serde(default)]
    pub begun: Option<Beginning>,
}

/// A flight as it was expected when somebody began to follow it, of an answer about now.
#[derive(Debug, Clone, PartialEq, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct Beginning {
    /// `now` of that answer.
    pub now: FlightNow,
    /// The track of its `ahead`.
    pub track: ExpectedTrack,
}

/// Of a rehearsed track, what tells whether a flight is late or low: lists of one length.
#[derive(Debug, Clone, PartialEq, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct ExpectedTrack {
    /// Since its beginning, seconds, growing.
    pub time_s: Vec<f64>,
    /// Degrees.
    pub lat_deg: Vec<f64>,
    /// Degrees.
    pub lon_deg: Vec<f64>,
    /// Above home, metres.
    pub height_m: Vec<f64>,
    /// Item that is flown, counted from 1; null in a return and after the landing.
    pub item: Vec<Option<u16>>,
}

/// A moment of a flight by the vehicle's own clock, which runs faster in some simulators.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct FlightNow {
    /// Since the vehicle booted; null while it has not said.
    #[schema(required = true)]
    pub boot_s: Option<f64>,
    /// What is left of its battery; null likewise.
    #[schema(required = true)]
    pub battery_pct: Option<f64>,
}

/// How a flight goes beside what was expected; null is not known, as away from the expected track.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, ToSchema)]
pub struct Outlook {
    /// Later than expected; negative: earlier.
    #[schema(required = true)]
    pub late_s: Option<f64>,
    /// Lower than expected, metres; negative: higher.
    #[schema(required = true)]
    pub low_m: Option<f64>,
    /// What will be left of the battery at the end of `ahead`, if it goes on as since the beginning; null while less than 2 % were used.
    #[schema(required = true)]
    pub battery_pct: Option<f64>,
}

/// What follows from a moment of a plan.
#[derive(Debug, Clone, PartialEq, Serialize, ToSchema)]
pub struct WhatIfs {
    /// When, seconds since the rehearsed flight's beginning; 0 is now where the vehicle flies it.
    pub at_s: f64,
    /// Where the plane is then; null on the ground and after the flight, where nothing follows.
    #[schema(required = true)]
    pub at: Option<LatLon>,
    /// Height above home then, metres.
    pub height_m: f64,
    /// The flight as it goes on when nothing happens; null where the moment is one of the plan's own rehearsal, and where
    /// a pilot steers.
    #[schema(required = true)]
    pub ahead: Option<RehearsedFlight>,
    /// Whether it is known how much was flown of the circle that the vehicle flies now. Where not, as when the station was started
    /// while it circled, `ahead` flies it whole, and nobody is told whether the flight is late until it goes on to the next item.
    pub is_circle_known: bool,
    /// Of a vehicle as it flies now, by what to know this moment later (`begun`); null for a moment of a plan, and while how much of
    /// its circle was flown is not known.
    #[schema(required = true)]
    pub now: Option<FlightNow>,
    /// How it goes beside what was expected when it began; null without `begun`, and without `ahead`.
    #[schema(required = true)]
    pub outlook: Option<Outlook>,
    /// One for each that was asked for.
    pub what_ifs: Vec<WhatIf>,
    /// The ground that may be reached without thrust, as a ring of places clockwise from north.
    pub glide_range: Vec<LatLon>,
}

/// What follows from one thing that happens.
#[derive(Debug, Clone, PartialEq, Serialize, ToSchema)]
pub struct WhatIf {
    /// What happens.
    pub trigger: Trigger,
    /// What the vehicle decides, in order of time; none where its settings do not act on it.
    pub decisions: Vec<Decision>,
    /// What it ends with.
    pub reaction: Reaction,
    /// The flight from there; null where the mission goes on as rehearsed.
    #[schema(required = true)]
    pub flown: Option<RehearsedFlight>,
}

/// One decision of a vehicle.
#[derive(Debug, Clone, PartialEq, Serialize, ToSchema)]
pub struct Decision {
    /// When, seconds since the rehearsed flight's beginning.
    pub time_s: f64,
    /// What it does.
    pub reaction: Reaction,
}

/// A part of a rehearsed flight, to its end.
#[derive(Debug, Clone, PartialEq, Serialize, ToSchema)]
pub struct RehearsedFlight {
    /// The track, as many moments as it takes to draw it within a metre.
    pub track: RehearsedTrack,
    /// How it ends.
    pub ending: Ending,
    /// Where the ground is touched; null where it is not.
    #[schema(required = true)]
    pub touch_down: Option<LatLon>,
    /// Its end, seconds since the rehearsed flight's beginning.
    pub ends_s: f64,
    /// Way over ground since that beginning, metres.
    pub distance_m: f64,
    /// Electrical energy since that beginning; null where the plane's power is not known.
    #[schema(required = true)]
    pub energy_wh: Option<f64>,
    /// What is left of the battery; null where that cannot be told.
    #[schema(required = true)]
    pub battery: Option<BatteryLeft>,
}
