//! The autopilot of the rehearsal: a mission flown item by item, and the return to launch.
//!
//! This file holds its state, the decision of one step, and its reactions to failures; `mission`, `circles`, `landing`
//! and `controls` the details. What it decides ten times a second is what ArduPlane decides there: when a waypoint
//! counts, when a circle is left, which height along a leg, when it flares (`ArduPlane/commands_logic.cpp`,
//! `navigation.cpp`, `altitude.cpp`, `takeoff.cpp`, `mode_rtl.cpp`, `AP_Landing_Slope.cpp` and `AP_Mission.cpp` of
//! ArduPilot 4.7 are the source of these rules).

mod circles;
mod controls;
mod landing;
mod mission;

use std::f64::consts::{FRAC_PI_2, TAU};

use super::aircraft::{Aircraft, Autoland};
use super::body::{Body, Controls};
use super::course::{Course, Spot, is_flown};
use super::doing::Doing;
use super::failsafe::{Duty, Reaction, Situation};
use super::outcome::{CameraOrder, Ending, Passage};
use crate::geodesy::GeoPoint;
use crate::guidance::l1::{L1State, Track, Turn};
use crate::guidance::tecs::TecsState;
use crate::guidance::{NorthEast, wrap_pi};
use crate::plan::Command;

/// Time between two decisions, s: ArduPlane navigates at 10 Hz.
pub(super) const STEP_S: f64 = 0.1;
/// A height counts as reached this near, m.
const HEIGHT_REACHED_M: f64 = 5.0;
/// Time in which the autopilot learns the wind, s: its states follow a change of speed over some turns (EKF3's wind
/// states with their process noise of 0.1 m/s²).
const WIND_LEARNED_S: f64 = 20.0;
/// How long a plane that a pilot steers is flown straight on beyond the last failsafe, s.
const PILOTED_S: f64 = 10.0;
/// Laps of a circle without end that are rehearsed.
const LAPS_SHOWN: f64 = 1.0;

/// Stage of a landing.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Stage {
    /// Flying to the slope.
    Normal,
    Approach,
    PreFlare,
    /// Throttle closed, with the height and sink rate of its beginning.
    Flare {
        height_m: f64,
        sink_m_s: f64,
    },
}

/// A circle being flown.
#[derive(Debug, Clone, Copy)]
struct Circle {
    turn: Turn,
    /// As ordered, before it is widened in thin air.
    radius_m: f64,
    /// Angle flown on it since it was reached, rad; `None`: not yet.
    swept_rad: Option<f64>,
    bearing_rad: f64,
    since_s: Option<f64>,
    has_height: bool,
    is_stuck: bool,
    next_look_rad: f64,
    look_height_m: f64,
    /// Turns, time or height are done, only the heading of its exit is missing.
    is_done: bool,
}

impl Circle {
    const fn new() -> Self {
        Self {
            turn: Turn::Clockwise,
            radius_m: 0.0,
            swept_rad: None,
            bearing_rad: 0.0,
            since_s: None,
            has_height: false,
            is_stuck: false,
            next_look_rad: 0.0,
            look_height_m: 0.0,
            is_done: false,
        }
    }

    fn swept(&self) -> f64 {
        self.swept_rad.unwrap_or(0.0)
    }
}

/// Mode of flight.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Mode {
    /// The item at this index of the mission.
    Auto(usize),
    /// Returning to home or a rally point.
    Return { has_climbed: bool, looked_for_landing: bool },
    /// Flying to a place outside of the mission, and circling there (GUIDED, LOITER).
    Holding(Duty),
    /// Straight on at this height, because the pilot's commands, or thermals, are not known.
    Piloted(Duty),
    /// Circling where the failsafe found it, at a third of its bank limit; ends after a turn.
    Circling { turned_rad: f64, course_rad: f64 },
    /// Gliding straight ahead with the nose level.
    Gliding,
    /// Rolling out or standing.
    Landed,
}

/// The autopilot's memory.
#[derive(Clone)]
pub(super) struct Autopilot<'a> {
    course: &'a Course<'a>,
    plane: &'a Aircraft,
    mode: Mode,
    l1: L1State,
    tecs: TecsState,
    track: Option<Track>,
    previous: Spot,
    next: Spot,
    has_crosstrack: bool,
    next_has_crosstrack: bool,
    distance_m: f64,
    proportion: f64,
    turn_rad: f64,
    /// Height between the ends of a leg that is flown as a slope; 0: straight to the next height.
    slope_m: f64,
    target_height_m: f64,
    follower: Follower,
    circle: Circle,
    stage: Stage,
    takes_off: Option<TakeOff>,
    /// Height, m above home, and least pitch, rad, of the last take-off.
    took_off: Option<(f64, f64)>,
    airspeed_ordered_m_s: Option<f64>,
    groundspeed_min_m_s: f64,
    /// Whether a DO_LAND_START was passed, or a landing begun.
    is_in_landing_sequence: bool,
    /// Whether a return is on its way to the first item of a landing, so that one which leads back to it is not looked
    /// for again.
    is_looking_for_landing: bool,
    /// Item that the mission was left at, for CIRCLE or FBWA.
    left_at: usize,
    /// Times that each jump was taken.
    jumps: Vec<(usize, u32)>,
    /// The next action to look at, and what holds it back.
    action: Option<usize>,
    hold: Option<Hold>,
    smoothed_airspeed_m_s: f64,
    smoothed_sink_m_s: f64,
    load: f64,
    wind: NorthEast,
    pub passages: Vec<Passage>,
    /// Orders to the camera.
    pub camera: Vec<CameraOrder>,
    pub ending: Option<Ending>,
}

#[derive(Debug, Clone, Copy)]
struct TakeOff {
    height_m: f64,
    pitch_rad: f64,
    began_s: f64,
    /// Course held once the plane is fast enough, rad.
    course_rad: Option<f64>,
    fast_since_s: Option<f64>,
    /// Height still to climb when the least pitch began to fade.
    levels_off_m: Option<f64>,
    /// Whether it is a landing that was broken off.
    is_abort: bool,
}

/// The autopilot's knowledge of the ground while its height counts from it.
#[derive(Debug, Clone, Copy, Default)]
struct Follower {
    /// Height of the ground below above home, m; the last known where it is not known now.
    ground_m: Option<f64>,
    is_known: bool,
    /// Whether the height that is asked for counts from it.
    follows: bool,
    /// How much higher the plane must be for what lies ahead, m.
    rise_m: f64,
    steps: u32,
}

/// A condition before further actions.
#[derive(Debug, Clone, Copy)]
enum Hold {
    Until(f64),
    Within(f64),
}

impl<'a> Autopilot<'a> {
    /// In AUTO at the beginning of the mission, or at the item of this index; or doing something else.
    pub fn new(course: &'a Course<'a>, plane: &'a Aircraft, body: &Body, index: usize, doing: Doing) -> Self {
        let mut autopilot = Self {
            course,
            plane,
            mode: Mode::Auto(index),
            l1: L1State::default(),
            tecs: TecsState::default(),
            track: None,
            previous: Spot::of(body),
            next: Spot::of(body),
            has_crosstrack: false,
            next_has_crosstrack: false,
            distance_m: 0.0,
            proportion: 1.0,
            turn_rad: FRAC_PI_2,
            slope_m: 0.0,
            target_height_m: body.height_m,
            follower: Follower::default(),
            circle: Circle::new(),
            stage: Stage::Normal,
            takes_off: None,
            took_off: None,
            airspeed_ordered_m_s: None,
            groundspeed_min_m_s: plane.groundspeed_min_m_s,
            is_in_landing_sequence: false,
            is_looking_for_landing: false,
            left_at: index,
            jumps: Vec::new(),
            action: None,
            hold: None,
            smoothed_airspeed_m_s: body.airspeed_m_s,
            smoothed_sink_m_s: 0.0,
            load: 1.0,
            wind: NorthEast::default(),
            passages: Vec::new(),
            camera: Vec::new(),
            ending: None,
        };
        // A plane in the air took off as its mission says.
        let flown = &course.items[..index.min(course.items.len())];
        autopilot.took_off =
            flown.iter().rfind(|item| item.command == Command::NAV_TAKEOFF).map(|item| course.take_off(item, body));
        match doing {
            Doing::Mission => autopilot.start_from(index, 0.0, body),
            Doing::Returning => autopilot.return_home(body, 0.0),
            Doing::Guided { to, height_m } => autopilot.hold_at(Duty::Guided, to, height_m, body),
            Doing::Loitering { around, height_m } => autopilot.hold_at(Duty::Loiter, around, height_m, body),
            Doing::Circling => autopilot.react(Reaction::Circles, body, 0.0),
            Doing::TookOff { around, height_m } => autopilot.hold_at(Duty::Circling, around, height_m, body),
            Doing::Piloted => autopilot.leave_mission(Mode::Piloted(Duty::Piloted), body),
            Doing::Soaring => autopilot.leave_mission(Mode::Piloted(Duty::Loiter), body),
        }
        autopilot
    }

    fn hold_at(&mut self, duty: Duty, point: GeoPoint, height_m: f64, body: &Body) {
        self.leave_mission(Mode::Holding(duty), body);
        self.next = Spot { at: self.course.position(point), height_m, follows_ground: false };
        self.distance_m = (self.next.at - body.position).length();
        self.set_up_slope(body, false, false);
    }

    /// A plane without an engine glides straight ahead here.
    pub fn loses_engine(&mut self, body: &Body) {
        if matches!(self.mode, Mode::Piloted(_)) {
            self.leave_mission(Mode::Gliding, body);
        }
    }

    /// Index of the item that is flown; `None` in a return.
    pub fn item(&self) -> Option<usize> {
        match self.mode {
            Mode::Auto(index) => Some(index),
            Mode::Return { .. }
            | Mode::Holding(_)
            | Mode::Piloted(_)
            | Mode::Circling { .. }
            | Mode::Gliding
            | Mode::Landed => None,
        }
    }

    /// Height that is asked for, m above home.
    pub fn target_height_m(&self) -> f64 {
        self.target_height_m
    }

    /// Home, where the plan is laid out around.
    pub fn origin(&self) -> GeoPoint {
        self.course.origin()
    }

    /// Height of the ground below a position above home, m, where it is known.
    pub fn ground_below_m(&self, at: NorthEast) -> Option<f64> {
        self.course.ground_m(at)
    }

    /// Whether the ground under the plane is where its landing ends.
    pub fn is_landing(&self) -> bool {
        matches!(self.stage, Stage::Flare { .. })
    }

    /// Distance to the next place, m; `None` on a circle and on the ground, where it does not shrink.
    pub fn distance_to_go_m(&self, body: &Body) -> Option<f64> {
        let circles = self.circle.since_s.is_some() || self.circle.swept_rad.is_some() || self.has_left_mission();
        (!circles && !body.is_on_ground && self.takes_off.is_none()).then_some(self.distance_m)
    }

    /// One decision.
    pub fn decide(&mut self, body: &Body, time_s: f64, wind: NorthEast) -> Controls {
        self.smoothed_airspeed_m_s += 0.2 * (body.airspeed_m_s - self.smoothed_airspeed_m_s);
        self.smoothed_sink_m_s += 0.2 * (-body.climb_m_s - self.smoothed_sink_m_s);
        self.distance_m = (self.next.at - body.position).length();
        self.proportion = proportion(self.previous.at, self.next.at, body.position);
        self.count_circle(body);
        let track = match self.mode {
            Mode::Auto(index) => self.fly_item(index, body, time_s),
            Mode::Return { .. } => self.fly_return(body, time_s),
            Mode::Circling { turned_rad, course_rad } => {
                let now_rad = body.velocity.bearing_rad();
                let turned_rad = turned_rad + wrap_pi(now_rad - course_rad);
                self.mode = Mode::Circling { turned_rad, course_rad: now_rad };
                if turned_rad >= LAPS_SHOWN * TAU {
                    self.ending = Some(Ending::Unlimited);
                }
                Track::Level
            }
            Mode::Holding(_) => {
                let track = self.circle_around(0.0, false, false, body, time_s);
                self.end_after_laps(Ending::Unlimited);
                track
            }
            Mode::Piloted(_) => {
                let failsafes = &self.plane.failsafes;
                if time_s > failsafes.short_s + failsafes.long_s + PILOTED_S {
                    self.ending = Some(Ending::NotRehearsed);
                }
                Track::Level
            }
            Mode::Gliding | Mode::Landed => Track::Level,
        };
        if self.item().is_some() {
            self.act(time_s);
        }
        self.note_nearest(body);
        self.aim(body);
        self.note_ground();
        let bank_rad = self.bank(body, track);
        // The autopilot's wind is a filtered estimate.
        self.wind = self.wind + (wind - self.wind) * (STEP_S / WIND_LEARNED_S);
        let (pitch_rad, throttle) = self.pitch_and_throttle(body, time_s);
        let is_open = self.takes_off.is_some() || matches!(self.stage, Stage::Flare { .. });
        Controls { bank_rad, pitch_rad: pitch_rad + self.plane.pitch_trim_deg.to_radians(), throttle, is_open }
    }

    /// The plane touched the ground: a landing is flown now, anything else is not.
    pub fn has_touched_down(&mut self, time_s: f64) {
        if self.is_landing()
            && let Some(passage) = self.passages.last_mut()
        {
            passage.reached_s.get_or_insert(time_s);
        }
        self.mode = Mode::Landed;
    }

    // Failsafes.

    /// Facts that the failsafes decide by.
    pub fn situation(&mut self, body: &Body) -> Situation {
        let is_landing = self.flies_landing();
        let onward_m = self.item().and_then(|index| self.way_to_landing_m(index, body));
        let by_start_m = self.course.nearest_landing(body).and_then(|index| self.way_to_landing_m(index, body));
        let duty = match self.mode {
            Mode::Auto(_) | Mode::Landed => Duty::Mission,
            Mode::Return { .. } => Duty::Return,
            Mode::Holding(duty) | Mode::Piloted(duty) => duty,
            Mode::Circling { .. } => Duty::Circling,
            Mode::Gliding => Duty::Piloted,
        };
        Situation {
            duty,
            is_landing,
            is_in_landing_sequence: is_landing || self.is_in_landing_sequence,
            returns_to_landing: self.plane.autoland == Autoland::AtOnce,
            is_near_its_landing: onward_m.zip(by_start_m).is_some_and(|(onward_m, by_start_m)| onward_m <= by_start_m),
        }
    }

    fn has_left_mission(&self) -> bool {
        matches!(self.mode, Mode::Circling { .. } | Mode::Gliding | Mode::Piloted(_))
    }

    /// Does something else than the mission; whatever is being landed or circled is left.
    pub fn react(&mut self, reaction: Reaction, body: &Body, time_s: f64) {
        self.left_at = self.item().unwrap_or(self.left_at);
        match reaction {
            Reaction::GoesOn => {}
            Reaction::FliesMission => {
                self.leave_mission(Mode::Auto(self.left_at), body);
                self.start_from(self.left_at, time_s, body);
            }
            Reaction::GoesAround => self.go_around(body, time_s),
            Reaction::Returns => self.return_home(body, time_s),
            Reaction::Lands => match self.course.nearest_landing(body) {
                Some(index) => {
                    self.is_in_landing_sequence = false;
                    self.start_from(index, time_s, body);
                }
                None => self.return_home(body, time_s),
            },
            Reaction::Circles => {
                let circling = Mode::Circling { turned_rad: 0.0, course_rad: body.velocity.bearing_rad() };
                self.leave_mission(circling, body);
            }
            Reaction::Glides => self.leave_mission(Mode::Gliding, body),
            Reaction::NotRehearsed => self.ending = Some(Ending::NotRehearsed),
        }
    }

    /// Flies on from here, as after a change of mode.
    fn leave_mission(&mut self, mode: Mode, body: &Body) {
        self.mode = mode;
        self.takes_off = None;
        self.stage = Stage::Normal;
        self.next_has_crosstrack = false;
        self.has_crosstrack = false;
        self.airspeed_ordered_m_s = None;
        self.previous = Spot::of(body);
        self.next = Spot::of(body);
        self.slope_m = 0.0;
        self.circle = Circle::new();
    }

    /// Way from here to the landing that the mission comes to from an item on, m; `None` where it comes to no landing,
    /// or where the way has more than waypoints (`AP_Mission::distance_to_landing`).
    fn way_to_landing_m(&mut self, index: usize, body: &Body) -> Option<f64> {
        let (mut at, mut from, mut way_m) = (index, body.position, 0.0);
        for _ in 0..255 {
            let (found, item) = self.next_item(at, false)?;
            at = found + 1;
            match item.command {
                Command::NAV_WAYPOINT | Command::NAV_SPLINE_WAYPOINT | Command::NAV_LAND => {
                    if let Some(place) = self.course.places[found] {
                        way_m += (place - from).length();
                        from = place;
                    }
                    if item.command == Command::NAV_LAND {
                        return Some(way_m);
                    }
                }
                Command::CONDITION_DELAY => return None,
                _ if is_flown(item) => return None,
                _ => {}
            }
        }
        None
    }

    /// How near the plane came to the items that it flew last: a turn cuts, or swings out behind.
    fn note_nearest(&mut self, body: &Body) {
        let count = self.passages.len();
        for passage in &mut self.passages[count.saturating_sub(2)..] {
            let Some(at) = self.course.passed_place(passage.item) else { continue };
            let distance_m = (at - body.position).length();
            if passage.nearest_m.is_none_or(|nearest_m| distance_m < nearest_m) {
                passage.nearest_m = Some(distance_m);
                let radius_m = self.plane.waypoint_radius_m * body.eas_to_tas * body.eas_to_tas;
                passage.is_missed = passage.reached_s.is_some() && distance_m > radius_m;
            }
        }
    }

    /// Whether the item that is flown is a landing.
    fn flies_landing(&self) -> bool {
        self.item().and_then(|index| self.course.items.get(index)).is_some_and(|item| item.command == Command::NAV_LAND)
    }

    /// Laps shown of an endless circle.
    fn end_after_laps(&mut self, ending: Ending) {
        if self.circle.swept() >= LAPS_SHOWN * TAU {
            self.ending.get_or_insert(ending);
        }
    }
}

/// Part of a leg that lies behind a position: 0 at its start, 1 at its end; 1 for a leg without length.
fn proportion(from: NorthEast, to: NorthEast, position: NorthEast) -> f64 {
    let leg = to - from;
    let square = leg.dot(leg);
    if square < 0.001 { 1.0 } else { (position - from).dot(leg) / square }
}

fn has_passed(from: NorthEast, to: NorthEast, position: NorthEast) -> bool {
    proportion(from, to, position) >= 1.0
}
