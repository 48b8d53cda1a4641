//! One rehearsal, from its start to its end.

use thiserror::Error;

use super::air::{Air, Gusts};
use super::aircraft::Aircraft;
use super::autopilot::{Autopilot, STEP_S};
use super::battery::BatteryLeft;
use super::body::Body;
use super::course::{Course, Ground};
use super::doing::Doing;
use super::failsafe::{Reaction, Situation};
use super::outcome::{Ending, Rehearsal, Sample};
use crate::geodesy::GeoPoint;
use crate::guidance::{NorthEast, wrap_pi};
use crate::plan::{Command, Home, Plan};
use crate::progress::Circled;

/// Longest flight that is rehearsed, s.
pub(super) const LONGEST_S: f64 = 6.0 * 3_600.0;
/// Decisions between two samples of the track: five samples a second.
const STEPS_A_SAMPLE: u32 = 2;
/// Height of the hand or the catapult that a plane leaves, m.
const HAND_M: f64 = 2.0;
/// Time on the ground after which a plane is taken not to fly, s.
const GROUNDED_S: f64 = 120.0;
/// Time without coming nearer to the next point after which the plane is taken to be held by the wind, s.
const HELD_S: f64 = 600.0;

/// Where the rehearsal begins.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Start {
    /// On the ground at home, with the mission at its beginning. A mission that does not begin with a take-off is begun
    /// in the air, over home and at the height of its first place.
    Ground {
        /// Heading of the nose, degrees from true north; `None`: into the wind, in calm air towards the first place of
        /// the plan.
        heading_deg: Option<f64>,
    },
    /// In the air.
    Air {
        /// Where.
        point: GeoPoint,
        /// Height above home, m.
        height_m: f64,
        /// Heading of the nose, degrees from true north.
        heading_deg: f64,
        /// Airspeed, m/s EAS.
        airspeed_m_s: f64,
        /// Index in `mission.items` of the item that is flown to, or would be in AUTO.
        index: usize,
        /// Its activity.
        doing: Doing,
        /// How much it has flown of the circle at that item; where that is not known, the circle is flown whole.
        circled: Circled,
    },
}

/// Conditions of a rehearsal beside the plan.
#[derive(Clone, Copy)]
pub struct Conditions<'a> {
    /// The plane.
    pub plane: &'a Aircraft,
    /// The air.
    pub air: Air,
    /// Where home is, in place of the plan's.
    pub home: Option<Home>,
    /// Where it begins.
    pub start: Start,
    /// The ground; `None`: level, at home's height and at each landing's, and away from them below a plan that leads
    /// below home.
    pub ground: Option<&'a Ground<'a>>,
    /// Level of the ground where `ground` does not know it, m above home; `None`: as described there.
    pub level_m: Option<f64>,
    /// Longest flight that is rehearsed, s; default and most: six hours.
    pub longest_s: f64,
    /// Whether the outcome is still waited for; asked before each step.
    pub is_wanted: IsWanted<'a>,
}

/// Whether the value is still waited for.
pub type IsWanted<'a> = &'a (dyn Fn() -> bool + Sync);

impl<'a> Conditions<'a> {
    /// From the ground at the plan's home.
    pub const fn new(plane: &'a Aircraft, air: Air) -> Self {
        let start = Start::Ground { heading_deg: None };
        Self { plane, air, home: None, start, ground: None, level_m: None, longest_s: LONGEST_S, is_wanted: &|| true }
    }
}

/// Why a plan is not rehearsed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Error)]
#[non_exhaustive]
pub enum NotRehearsed {
    /// Neither the plan nor the conditions have a home.
    #[error("a rehearsal begins at home: neither the plan nor a vehicle gives one")]
    NoHome,
    /// A home that is not a position.
    #[error("home is not a position on Earth")]
    NoSuchHome,
    /// An item without latitude or longitude.
    #[error("item {item} ({command}) has no latitude or longitude; place it on the map")]
    NoPlace {
        /// Its number, counted from 1.
        item: usize,
        /// Its command.
        command: Command,
    },
    /// [`Conditions::is_wanted`] has become false.
    #[error("the rehearsal was given up")]
    NotWanted,
}

/// Flies a plan.
///
/// # Errors
/// [`NotRehearsed`].
pub fn rehearse(plan: &Plan, conditions: &Conditions<'_>) -> Result<Rehearsal, NotRehearsed> {
    let course = laid_out(plan, conditions)?;
    let mut flight = Flight::new(&course, conditions);
    flight.until(f64::INFINITY);
    if flight.ending.is_none() {
        return Err(NotRehearsed::NotWanted);
    }
    Ok(flight.into_rehearsal())
}

/// The plan around the home that it is flown from.
///
/// # Errors
/// [`NotRehearsed`].
pub(super) fn laid_out<'a>(plan: &Plan, conditions: &Conditions<'a>) -> Result<Course<'a>, NotRehearsed> {
    let home = conditions.home.or(plan.mission.home).ok_or(NotRehearsed::NoHome)?;
    if let Some((index, item)) = plan.mission.items.iter().enumerate().find(|(_, item)| item.lacks_place()) {
        return Err(NotRehearsed::NoPlace { item: index + 1, command: item.command });
    }
    let mut course = Course::new(plan, home, conditions.ground).ok_or(NotRehearsed::NoSuchHome)?;
    if let Some(level_m) = conditions.level_m {
        course.set_level(level_m);
    }
    Ok(course)
}

/// A rehearsal in progress. A copy continues it, or diverts from there.
#[derive(Clone)]
pub(super) struct Flight<'a> {
    course: &'a Course<'a>,
    plane: &'a Aircraft,
    air: Air,
    body: Body,
    autopilot: Autopilot<'a>,
    gusts: Gusts,
    flown: Flown,
    energy_j: f64,
    /// Charge of the battery at the start, J, where known.
    holds_j: Option<f64>,
    /// When it is empty, and the item that is flown then.
    empty: Option<(f64, Option<usize>)>,
    nearest: Nearest,
    step: u32,
    longest_s: f64,
    is_wanted: IsWanted<'a>,
    has_engine: bool,
    ending: Option<Ending>,
}

impl<'a> Flight<'a> {
    pub fn new(course: &'a Course<'a>, conditions: &Conditions<'a>) -> Self {
        let Conditions { plane, air, .. } = *conditions;
        let (body, index, doing) = begin(course, conditions);
        let mut autopilot = Autopilot::new(course, plane, &body, index, doing);
        if let Start::Air { circled: Circled::Flown { turns, time_s }, .. } = conditions.start {
            autopilot.resume_circle(turns, time_s, &body);
        }
        Self {
            course,
            plane,
            air,
            body,
            autopilot,
            gusts: Gusts::new(&air),
            flown: Flown::default(),
            energy_j: 0.0,
            holds_j: plane
                .battery
                .capacity_wh(&plane.airframe)
                .ok()
                .map(|full_wh| full_wh * plane.battery.charge * 3_600.0),
            empty: None,
            nearest: Nearest::default(),
            step: 0,
            longest_s: conditions.longest_s.min(LONGEST_S),
            is_wanted: conditions.is_wanted,
            has_engine: true,
            ending: None,
        }
    }

    /// Since the start, s.
    pub fn time_s(&self) -> f64 {
        f64::from(self.step) * STEP_S
    }

    /// Flies on until a moment or to the end; `false` at the end.
    pub fn until(&mut self, time_s: f64) -> bool {
        while self.ending.is_none() && self.time_s() < time_s && (self.is_wanted)() {
            self.fly_on();
        }
        self.ending.is_none()
    }

    /// Whether the plane has left the ground and is not back on it.
    pub const fn is_in_the_air(&self) -> bool {
        self.body.has_flown && !self.body.is_on_ground
    }

    /// Where the plane is.
    pub fn now(&self) -> Sample {
        Flown::placed(self.course, Flown::moment(self.time_s(), &self.body, &self.autopilot))
    }

    /// Diverts: the track begins anew here.
    pub fn diverts(&mut self) {
        self.flown.moments.clear();
        self.autopilot.ending = None;
    }

    /// Facts that the vehicle decides by.
    pub fn situation(&mut self) -> Situation {
        self.autopilot.situation(&self.body)
    }

    /// The engine stops, unnoticed by the autopilot.
    pub fn loses_engine(&mut self) {
        self.has_engine = false;
        self.autopilot.loses_engine(&self.body);
    }

    /// The vehicle does something else than its mission.
    pub fn reacts(&mut self, reaction: Reaction) {
        self.autopilot.react(reaction, &self.body, self.time_s());
        self.nearest = Nearest::default();
    }

    fn fly_on(&mut self) {
        let time_s = self.time_s();
        let steady = self.air.steady(self.course.above_level_m(self.body.position, self.body.height_m));
        let wind = steady + self.gusts.step(self.body.airspeed_m_s, STEP_S);
        let was_flying = self.is_in_the_air();
        let mut controls = self.autopilot.decide(&self.body, time_s, steady);
        if !self.has_engine {
            controls.throttle = 0.0;
        }
        if self.step.is_multiple_of(STEPS_A_SAMPLE) {
            self.flown.note(time_s, &self.body, &self.autopilot);
        }
        self.ending = self.autopilot.ending.or_else(|| {
            let body = &self.body;
            let rests = body.is_on_ground && body.has_flown && body.velocity.length() < 0.1;
            match () {
                () if rests => Some(if self.flown.landed { Ending::Landed } else { Ending::Ground }),
                () if !body.has_flown && time_s >= GROUNDED_S => Some(Ending::Grounded),
                () if time_s >= self.longest_s => Some(Ending::TooLong),
                () if self.nearest.is_held(&self.autopilot, body, time_s) => Some(Ending::Held),
                () => None,
            }
        });
        if self.ending.is_some() {
            self.flown.note(time_s, &self.body, &self.autopilot);
            return;
        }
        let plane = self.plane;
        let field = self.autopilot.item().or(self.flown.field);
        let ground_m = self.course.stopping_ground_m(field, self.body.position);
        self.body.step(&controls, wind, ground_m, self.course.home.alt_amsl_m, plane, STEP_S);
        if was_flying && self.body.is_on_ground {
            self.flown.landed = self.autopilot.is_landing();
            self.flown.field = self.autopilot.item();
            self.flown.touches(time_s + STEP_S, &self.body, &self.autopilot);
            self.autopilot.has_touched_down(time_s + STEP_S);
        }
        if self.has_engine {
            let power_w = plane.airframe.power_cruise_w.unwrap_or(0.0) * plane.airframe.power(self.body.throttle);
            self.energy_j += power_w * STEP_S;
            if self.empty.is_none() && self.holds_j.is_some_and(|holds_j| self.energy_j > holds_j) {
                self.empty = Some((time_s, self.autopilot.item()));
            }
        }
        self.flown.distance_m += self.body.velocity.length() * STEP_S;
        self.step += 1;
    }

    /// The flight from its start, or from its diversion.
    pub fn into_rehearsal(self) -> Rehearsal {
        let duration_s = self.time_s();
        let Self { course, plane, autopilot, flown, energy_j, empty, ending, .. } = self;
        let energy_wh = energy_j / 3_600.0;
        let battery = plane.battery.capacity_wh(&plane.airframe).map(|capacity_wh| BatteryLeft {
            capacity_wh,
            left_wh: capacity_wh * plane.battery.charge - energy_wh,
            reserve: plane.battery.reserve,
            empty_s: empty.map(|(time_s, _)| time_s),
            empty_index: empty.and_then(|(_, index)| index),
        });
        let placed = |moment: Moment| Flown::placed(course, moment);
        Rehearsal {
            airframe: plane.airframe.origin,
            track: flown.moments.iter().copied().map(placed).collect(),
            touch_down: flown.touch_down.map(placed),
            passages: autopilot.passages,
            camera: autopilot.camera,
            ending: ending.unwrap_or(Ending::TooLong),
            duration_s,
            distance_m: flown.distance_m,
            energy_wh: plane.airframe.power_cruise_w.map(|_| energy_wh),
            battery,
            home_above_ground_m: course.home_above_ground_m(),
        }
    }
}

/// The plane at its start, the item that it begins with, and what it does.
fn begin(course: &Course<'_>, conditions: &Conditions<'_>) -> (Body, usize, Doing) {
    let Conditions { plane, air, .. } = *conditions;
    let flying = |at: NorthEast, height_m: f64, heading: f64, airspeed_m_s: f64| {
        let wind = air.steady(course.above_level_m(at, height_m));
        Body::flying(at, height_m, heading, airspeed_m_s, wind, course.home.alt_amsl_m, plane)
    };
    match conditions.start {
        Start::Ground { heading_deg } => {
            let home = NorthEast::default();
            let first = course.first_place();
            let onward = first.map_or(0.0, |spot| spot.at.bearing_rad());
            if !course.begins_with_take_off() {
                let height_m = first.map_or(100.0, |spot| spot.height_m);
                return (flying(home, height_m, onward, plane.airspeed_cruise_m_s), 0, Doing::Mission);
            }
            let has_wind = air.wind.speed_m_s >= crate::landing::CALM_M_S;
            let nose = if has_wind { air.wind.from_deg.to_radians() } else { onward };
            let heading = wrap_pi(heading_deg.map_or(nose, f64::to_radians));
            if plane.is_launched {
                // From a hand or a catapult, as fast as it has to fly.
                return (flying(home, HAND_M, heading, plane.tecs.airspeed_min_m_s), 0, Doing::Mission);
            }
            (Body::parked(home, heading, plane.airframe.level_pitch_rad), 0, Doing::Mission)
        }
        Start::Air { point, height_m, heading_deg, airspeed_m_s, index, doing, .. } => {
            let heading = wrap_pi(heading_deg.to_radians());
            (flying(course.position(point), height_m, heading, airspeed_m_s), index, doing)
        }
    }
}

/// A moment before it has a place on Earth.
#[derive(Debug, Clone, Copy)]
struct Moment {
    at: NorthEast,
    sample: Sample,
}

/// The track as it grows.
#[derive(Debug, Clone, Default)]
struct Flown {
    moments: Vec<Moment>,
    touch_down: Option<Moment>,
    landed: bool,
    /// The item that it touched the ground on the way to.
    field: Option<usize>,
    distance_m: f64,
}

impl Flown {
    fn moment(time_s: f64, body: &Body, autopilot: &Autopilot<'_>) -> Moment {
        let degrees = |angle: f64| crate::geodesy::wrap_360_deg(angle.to_degrees());
        Moment {
            at: body.position,
            sample: Sample {
                time_s,
                point: autopilot.origin(),
                height_m: body.height_m,
                height_asked_m: autopilot.target_height_m(),
                ground_m: autopilot.ground_below_m(body.position),
                airspeed_m_s: body.airspeed_m_s,
                groundspeed_m_s: body.velocity.length(),
                course_deg: degrees(body.velocity.unit_or(NorthEast::from_bearing(body.heading_rad)).bearing_rad()),
                heading_deg: degrees(body.heading_rad),
                climb_m_s: body.climb_m_s,
                bank_deg: body.bank_rad.to_degrees(),
                pitch_deg: body.pitch_rad.to_degrees(),
                throttle: body.throttle,
                index: autopilot.item(),
            },
        }
    }

    fn note(&mut self, time_s: f64, body: &Body, autopilot: &Autopilot<'_>) {
        if self.moments.last().is_none_or(|last| last.sample.time_s < time_s) {
            self.moments.push(Self::moment(time_s, body, autopilot));
        }
    }

    fn touches(&mut self, time_s: f64, body: &Body, autopilot: &Autopilot<'_>) {
        self.touch_down = Some(Self::moment(time_s, body, autopilot));
    }

    fn placed(course: &Course<'_>, moment: Moment) -> Sample {
        Sample { point: course.point(moment.at), ..moment.sample }
    }
}

/// Whether the plane still comes nearer to where it goes.
#[derive(Debug, Clone, Copy, Default)]
struct Nearest {
    /// Passages begun, nearest distance so far, and when.
    best: Option<(usize, f64, f64)>,
}

impl Nearest {
    fn is_held(&mut self, autopilot: &Autopilot<'_>, body: &Body, time_s: f64) -> bool {
        let Some(distance_m) = autopilot.distance_to_go_m(body) else {
            self.best = None;
            return false;
        };
        let begun = autopilot.passages.len();
        match self.best {
            Some((passage, nearest_m, since_s)) if passage == begun && distance_m > nearest_m - 1.0 => {
                time_s - since_s > HELD_S
            }
            _ => {
                self.best = Some((begun, distance_m, time_s));
                false
            }
        }
    }
}
