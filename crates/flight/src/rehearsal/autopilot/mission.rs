//! Items one after the other: which is next, when a waypoint counts, and the actions between them
//! (`ArduPlane/commands_logic.cpp`, `takeoff.cpp`, `AP_Mission.cpp`).

use std::f64::consts::FRAC_PI_2;

use super::super::body::Body;
use super::super::course::{Spot, is_flown};
use super::super::outcome::{CameraOrder, Ending, Passage};
use super::{Autopilot, Circle, HEIGHT_REACHED_M, Hold, Mode, Stage, TakeOff, has_passed, proportion};
use crate::guidance::l1::Track;
use crate::guidance::tecs::TecsState;
use crate::guidance::{NorthEast, wrap_pi};
use crate::plan::{Command, MissionItem};

impl<'a> Autopilot<'a> {
    /// Starts the first flown item at or after an index; without one the plane returns.
    pub(super) fn start_from(&mut self, index: usize, time_s: f64, body: &Body) {
        // Actions between here and the flown item begin with the first of them.
        self.hold = None;
        let mut at = index;
        let mut first_action = None;
        for _ in 0..255 {
            let Some((found, item)) = self.next_item(at, true) else {
                self.action = None;
                if self.ending.is_none() {
                    self.return_home(body, time_s);
                }
                return;
            };
            self.is_in_landing_sequence = match item.command {
                Command::DO_LAND_START | Command::NAV_LAND => true,
                Command::NAV_TAKEOFF => false,
                _ => self.is_in_landing_sequence,
            };
            if is_flown(item) {
                self.action = first_action;
                if self.begin(found, item, body, time_s) {
                    return;
                }
            } else if first_action.is_none() {
                first_action = Some(found);
            }
            at = found + 1;
        }
        self.return_home(body, time_s);
    }

    /// The item at or after an index, jumps followed and, where `counts`, counted.
    pub(super) fn next_item(&mut self, from: usize, counts: bool) -> Option<(usize, &'a MissionItem)> {
        let mut index = from;
        let mut taken: Vec<usize> = Vec::new();
        for _ in 0..64 {
            let item = self.course.items.get(index)?;
            if item.command != Command::DO_JUMP && item.command != Command::DO_JUMP_TAG {
                return Some((index, item));
            }
            let repeats = item.param(2).unwrap_or(0.0);
            let done = self.jumps.iter().find(|(jump, _)| *jump == index).map_or(0, |(_, count)| *count);
            let done = done + taken.iter().filter(|jump| **jump == index).count() as u32;
            let target = self.course.jump(item);
            if repeats < 0.0 && counts && done >= 1 {
                self.ending = Some(Ending::Endless);
                return None;
            }
            match target {
                Some(target) if repeats < 0.0 || f64::from(done) < repeats => {
                    if counts {
                        match self.jumps.iter_mut().find(|(jump, _)| *jump == index) {
                            Some((_, count)) => *count += 1,
                            None => self.jumps.push((index, 1)),
                        }
                    } else {
                        taken.push(index);
                    }
                    index = target;
                }
                _ => index += 1,
            }
        }
        None
    }

    /// The flown item that would follow the one at an index.
    pub(super) fn following(&mut self, index: usize) -> Option<(usize, &'a MissionItem)> {
        let mut at = index + 1;
        for _ in 0..255 {
            let (found, item) = self.next_item(at, false)?;
            if is_flown(item) {
                return Some((found, item));
            }
            at = found + 1;
        }
        None
    }

    /// Begins an item; `false` for one that ArduPlane passes over.
    fn begin(&mut self, index: usize, item: &MissionItem, body: &Body, time_s: f64) -> bool {
        self.takes_off = None;
        self.stage = Stage::Normal;
        let before = self.mode;
        self.mode = Mode::Auto(index);
        match item.command {
            Command::NAV_TAKEOFF => {
                let (height_m, pitch_rad) = self.course.take_off(item, body);
                self.set_next(Spot { height_m, ..Spot::of(body) }, index, body);
                self.took_off = Some((height_m, pitch_rad));
                self.takes_off = Some(TakeOff {
                    height_m,
                    pitch_rad,
                    began_s: time_s,
                    course_rad: None,
                    fast_since_s: None,
                    levels_off_m: None,
                    is_abort: false,
                });
                self.tecs = TecsState::taking_over(0.0);
            }
            Command::NAV_CONTINUE_AND_CHANGE_ALT => {
                if (self.next.at - self.previous.at).length() < 0.01 {
                    self.next.at =
                        body.position + body.velocity.unit_or(NorthEast::from_bearing(body.heading_rad)) * 1_000.0;
                }
                self.next = self.course.at_height_of(self.next.at, item, body);
                self.slope_m = 0.0;
            }
            Command::NAV_RETURN_TO_LAUNCH => {
                self.open(index, time_s);
                self.return_home(body, time_s);
                return true;
            }
            Command::NAV_WAYPOINT
            | Command::NAV_LAND
            | Command::NAV_LOITER_UNLIM
            | Command::NAV_LOITER_TURNS
            | Command::NAV_LOITER_TIME
            | Command::NAV_LOITER_TO_ALT => {
                let spot = self.course.spot(item, body);
                self.set_next(spot, index, body);
            }
            Command::NAV_DELAY => {
                // It holds back a plane on the ground alone.
                self.mode = before;
                return false;
            }
            Command::NAV_ALTITUDE_WAIT
            | Command::NAV_SCRIPT_TIME
            | Command::NAV_VTOL_TAKEOFF
            | Command::NAV_VTOL_LAND
            | Command::NAV_PAYLOAD_PLACE => {
                self.open(index, time_s);
                self.ending = Some(Ending::NotRehearsed);
                return true;
            }
            _ => {
                self.mode = before;
                return false;
            }
        }
        self.open(index, time_s);
        true
    }

    fn open(&mut self, index: usize, time_s: f64) {
        self.passages.push(Passage {
            item: index,
            begins_s: time_s,
            reached_s: None,
            nearest_m: None,
            is_missed: false,
            height_error_m: None,
            lacks_ground: None,
        });
    }

    /// Flies to a spot along the line from the last one.
    fn set_next(&mut self, spot: Spot, index: usize, body: &Body) {
        if self.next_has_crosstrack {
            self.previous = self.next;
            self.has_crosstrack = true;
        } else {
            self.previous = Spot::of(body);
            self.next_has_crosstrack = true;
            self.has_crosstrack = false;
        }
        self.next = spot;
        if has_passed(self.previous.at, self.next.at, body.position) {
            self.previous = Spot::of(body);
        }
        self.circle = Circle::new();
        self.distance_m = (self.next.at - body.position).length();
        self.proportion = proportion(self.previous.at, self.next.at, body.position);
        let is_landing = self.course.items.get(index).is_some_and(|item| item.command == Command::NAV_LAND);
        self.set_up_slope(body, true, is_landing);
        let onward = self.following(index).map(|(_, item)| self.course.onward(item));
        let leg = self.next.at - self.previous.at;
        self.turn_rad = match onward {
            Some(Some(at)) => wrap_pi((at - self.next.at).bearing_rad() - leg.bearing_rad()),
            _ => FRAC_PI_2,
        };
        self.aim(body);
    }

    fn complete(&mut self, index: usize, time_s: f64, body: &Body) {
        let is_waypoint = self.course.items[index].command == Command::NAV_WAYPOINT;
        let error_m = self.counted_m(body) - self.next.height_m;
        let radius_m = self.plane.waypoint_radius_m * body.eas_to_tas * body.eas_to_tas;
        if let Some(passage) = self.passages.last_mut() {
            passage.reached_s = Some(time_s);
            passage.height_error_m = is_waypoint.then_some(error_m);
            // It may be counted as passed abeam. The turn that follows may still come near.
            passage.is_missed = passage.nearest_m.is_some_and(|nearest_m| nearest_m > radius_m);
        }
        self.start_from(index + 1, time_s, body);
    }

    /// Steers along the item, and goes on when it is done.
    pub(super) fn fly_item(&mut self, index: usize, body: &Body, time_s: f64) -> Track {
        let Some(item) = self.course.items.get(index) else { return Track::Level };
        let (track, is_done) = match item.command {
            Command::NAV_TAKEOFF => self.take_off(body, time_s),
            Command::NAV_WAYPOINT => self.fly_to_waypoint(item, body),
            Command::NAV_LAND if self.takes_off.is_some() => return self.fly_around(index, body, time_s),
            Command::NAV_LAND => (self.land(body), false),
            Command::NAV_CONTINUE_AND_CHANGE_ALT => {
                let along = (self.next.at - self.previous.at).unit_or(body.velocity.unit_or(NorthEast::new(1.0, 0.0)));
                if self.distance_m < 200.0 {
                    self.next.at = self.next.at + along * 300.0;
                }
                let above = self.counted_m(body) - self.next.height_m;
                let is_done = match item.param(1).unwrap_or(0.0) as i64 {
                    1 if above >= 0.0 => true,
                    2 if above <= 0.0 => true,
                    _ => above.abs() <= HEIGHT_REACHED_M,
                };
                (Track::Leg { from: self.previous.at, to: self.next.at }, is_done)
            }
            _ => self.loiter(item, index, body, time_s),
        };
        if is_done {
            self.complete(index, time_s, body);
        }
        track
    }

    fn take_off(&mut self, body: &Body, time_s: f64) -> (Track, bool) {
        let Some(mut takes_off) = self.takes_off else { return (Track::Level, true) };
        let speed = body.velocity.length();
        if takes_off.fast_since_s.is_none() && speed > 5.0 {
            takes_off.fast_since_s = Some(time_s);
        }
        if takes_off.course_rad.is_none() && takes_off.fast_since_s.is_some_and(|since| time_s - since >= 2.0) {
            takes_off.course_rad = Some(body.velocity.bearing_rad());
        }
        let track = takes_off.course_rad.map_or(Track::Level, |heading_rad| Track::Heading { heading_rad });
        self.takes_off = Some(takes_off);
        if body.height_m <= takes_off.height_m {
            return (track, false);
        }
        self.takes_off = None;
        self.previous = Spot::of(body);
        self.next = Spot::of(body);
        self.next_has_crosstrack = false;
        (track, true)
    }

    fn fly_to_waypoint(&mut self, item: &MissionItem, body: &Body) -> (Track, bool) {
        let leg = self.next.at - self.previous.at;
        let beyond_m = item.param(3).unwrap_or(0.0).max(0.0);
        let to = if beyond_m > 0.0 && leg.length() > 0.0 {
            self.next.at + leg.unit_or(leg) * beyond_m
        } else {
            self.next.at
        };
        let from = if self.has_crosstrack { self.previous.at } else { body.position };
        let track = Track::Leg { from, to };
        let has_passed = has_passed(self.previous.at, to, body.position);
        if self.plane.waypoint_max_radius_m > 0.0 && self.distance_m > self.plane.waypoint_max_radius_m {
            if has_passed && beyond_m == 0.0 {
                self.previous = Spot::of(body);
            }
            return (track, false);
        }
        let accepts_m = item
            .param(2)
            .filter(|radius| *radius > 0.0)
            .unwrap_or_else(|| if beyond_m > 0.0 { 0.0 } else { self.turn_distance_m(body) });
        (track, (to - body.position).length() <= accepts_m || has_passed)
    }

    /// How far before a waypoint the turn to the next leg begins, m.
    fn turn_distance_m(&self, body: &Body) -> f64 {
        let radius_m = self.plane.waypoint_radius_m * body.eas_to_tas * body.eas_to_tas;
        let full_m = radius_m.min(self.plane.l1.length_m(body.velocity.length()));
        full_m * (self.turn_rad.abs() / FRAC_PI_2).min(1.0)
    }

    /// Does the actions between the last flown item and the next, one at a time.
    pub(super) fn act(&mut self, time_s: f64) {
        match self.hold {
            Some(Hold::Until(when_s)) if time_s < when_s => return,
            Some(Hold::Within(distance_m)) if self.distance_m >= distance_m => return,
            _ => self.hold = None,
        }
        let Some(at) = self.action else { return };
        let Some((index, item)) = self.next_item(at, false) else {
            self.action = None;
            return;
        };
        if is_flown(item) {
            self.action = None;
            return;
        }
        self.action = Some(index + 1);
        match item.command {
            Command::CONDITION_DELAY => self.hold = Some(Hold::Until(time_s + item.param(1).unwrap_or(0.0))),
            Command::CONDITION_DISTANCE => self.hold = Some(Hold::Within(item.param(1).unwrap_or(0.0))),
            Command::DO_CHANGE_SPEED => {
                let kind = item.param(1).unwrap_or(0.0) as i64;
                let speed = item.param(2).unwrap_or(0.0);
                let tecs = &self.plane.tecs;
                if kind == 0 && speed == -2.0 {
                    self.airspeed_ordered_m_s = None;
                } else if kind == 0 && (tecs.airspeed_min_m_s..=tecs.airspeed_max_m_s).contains(&speed) {
                    self.airspeed_ordered_m_s = Some(speed);
                } else if kind == 1 {
                    self.groundspeed_min_m_s = speed;
                }
            }
            Command::DO_SET_CAM_TRIGG_DIST => self.camera.push(CameraOrder {
                time_s,
                every_m: Some(item.param(1).unwrap_or(0.0).max(0.0)),
                is_at_once: item.param(3) == Some(1.0),
            }),
            // The fifth is "shoot".
            Command::DO_DIGICAM_CONTROL if item.param(5) == Some(1.0) => {
                self.camera.push(CameraOrder { time_s, every_m: None, is_at_once: true });
            }
            _ => {}
        }
    }
}
