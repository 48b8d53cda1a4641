//! Circles: how they are counted, and when they are left (`ArduPlane/navigation.cpp`, `commands_logic.cpp`).

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use super::super::body::Body;
use super::super::course::Spot;
use super::super::outcome::Ending;
use super::{Autopilot, HEIGHT_REACHED_M};
use crate::guidance::l1::{Track, Turn};
use crate::guidance::{NorthEast, wrap_pi};
use crate::plan::{Command, MissionItem};

/// Laps between two looks whether a circle still climbs or sinks.
const STUCK_LAPS: f64 = 3.0;
/// How straight the way on must lie to leave a circle, rad; the same again for each lap flown.
pub(super) const LINED_UP_RAD: f64 = 10.0 * PI / 180.0;

impl Autopilot<'_> {
    /// Resumes the first item's circle after `turns` flown in `time_s`; ignored for other items.
    pub fn resume_circle(&mut self, turns: f64, time_s: f64, body: &Body) {
        let command = self.item().and_then(|index| self.course.items.get(index)).map(|item| item.command);
        if let Some(Command::NAV_LOITER_TURNS | Command::NAV_LOITER_TIME | Command::NAV_LOITER_TO_ALT) = command {
            let swept_rad = turns * TAU;
            self.circle.swept_rad = Some(swept_rad);
            self.circle.since_s = Some(-time_s);
            self.circle.bearing_rad = (self.next.at - body.position).bearing_rad();
            self.circle.look_height_m = body.height_m;
            self.circle.next_look_rad = swept_rad + STUCK_LAPS * TAU;
        }
    }

    pub(super) fn loiter(&mut self, item: &MissionItem, index: usize, body: &Body, time_s: f64) -> (Track, bool) {
        let (radius_m, is_anticlockwise) = match item.command {
            Command::NAV_LOITER_TO_ALT => sized(item.param(2)),
            // Its circle is the vehicle's own; the third parameter gives the direction alone.
            Command::NAV_LOITER_TIME => (0.0, item.param(3).is_some_and(|radius| radius < 0.0)),
            _ => sized(item.param(3)),
        };
        let track = self.circle_around(radius_m, is_anticlockwise, true, body, time_s);
        let is_flown = self.circle.swept_rad.is_some();
        if !self.circle.is_done {
            self.circle.is_done = match item.command {
                Command::NAV_LOITER_UNLIM => {
                    self.end_after_laps(Ending::Unlimited);
                    false
                }
                Command::NAV_LOITER_TURNS => is_flown && self.circle.swept() > item.param(1).unwrap_or(0.0) * TAU,
                Command::NAV_LOITER_TIME => {
                    self.circle.since_s.is_some_and(|since| time_s - since > item.param(1).unwrap_or(0.0))
                }
                _ => is_flown && (self.circle.has_height || self.circle.is_stuck),
            };
            if self.circle.is_done {
                self.circle.swept_rad = Some(0.0);
            }
        }
        let leaves = self.circle.is_done && self.is_lined_up(item, index, body);
        (track, leaves)
    }

    pub(super) fn circle_around(
        &mut self,
        radius_m: f64,
        is_anticlockwise: bool,
        is_mission: bool,
        body: &Body,
        time_s: f64,
    ) -> Track {
        let (radius_m, turn) = self.plane.circle(radius_m, is_anticlockwise);
        self.circle.radius_m = radius_m;
        self.circle.turn = turn;
        let wide_m = self.widened_m(body);
        if self.circle.since_s.is_none() && (self.is_on_circle() || self.proportion > 1.0) {
            self.circle.since_s = Some(time_s);
        }
        if self.circle.since_s.is_none() && is_mission && self.has_crosstrack && self.distance_m > 3.0 * wide_m {
            return Track::Leg { from: self.previous.at, to: self.next.at };
        }
        Track::Circle { centre: self.next.at, radius_m: wide_m, turn }
    }

    /// Whether the circle around the next place is being flown; not the one before, which the last decision was about.
    pub(super) fn is_on_circle(&self) -> bool {
        self.l1.on_circle && matches!(self.track, Some(Track::Circle { centre, .. }) if centre == self.next.at)
    }

    /// Radius of the circle over ground: the true airspeed grows with height, the bank does not.
    fn widened_m(&self, body: &Body) -> f64 {
        let radius_m = self.circle.radius_m;
        let wider_m = radius_m * body.eas_to_tas * body.eas_to_tas;
        let bank = self.plane.loiter_bank_deg.clamp(0.0, 89.0).to_radians();
        let airspeed = self.airspeed_target_m_s(body);
        if bank <= 0.0 {
            return wider_m;
        }
        let sea_level_m = airspeed * airspeed / (bank.tan() * crate::guidance::GRAVITY_M_S2);
        if sea_level_m > radius_m { wider_m } else { (sea_level_m * body.eas_to_tas * body.eas_to_tas).max(radius_m) }
    }

    /// Counts the angle flown, by what was steered for last (`Plane::loiter_angle_update` comes before the new target
    /// is steered for): a circle right after another is counted from its first moment, from the bearing of the other's
    /// centre on.
    pub(super) fn count_circle(&mut self, body: &Body) {
        let (centre, is_on) = match self.track {
            Some(Track::Circle { centre, .. }) => (centre, self.l1.on_circle),
            _ => (self.next.at, false),
        };
        let bearing = (centre - body.position).bearing_rad();
        let circle = &mut self.circle;
        match circle.swept_rad {
            None if is_on => {
                circle.swept_rad = Some(0.0);
                circle.look_height_m = body.height_m;
                circle.next_look_rad = STUCK_LAPS * TAU;
            }
            Some(swept) => {
                let sign = if circle.turn == Turn::Clockwise { 1.0 } else { -1.0 };
                circle.swept_rad = Some(swept + sign * wrap_pi(bearing - circle.bearing_rad));
            }
            None => {}
        }
        circle.bearing_rad = bearing;
        // The height asked for may still be that of the slope that led here: the autopilot's is the circle's from its
        // first moment.
        if is_on && (body.height_m - self.next.height_m).abs() < HEIGHT_REACHED_M {
            circle.has_height = true;
            circle.is_stuck = false;
            circle.next_look_rad = circle.swept() + STUCK_LAPS * TAU;
        } else if !circle.has_height && circle.next_look_rad > 0.0 && circle.swept().abs() >= circle.next_look_rad {
            circle.is_stuck = (body.height_m - circle.look_height_m).abs() < HEIGHT_REACHED_M;
            circle.look_height_m = body.height_m;
            circle.next_look_rad += STUCK_LAPS * TAU;
        }
    }

    /// Whether the circle may be left towards the item that follows.
    fn is_lined_up(&mut self, item: &MissionItem, index: usize, body: &Body) -> bool {
        let Some((_, following)) = self.following(index) else { return true };
        let radius_m = self.widened_m(body);
        let out = (body.position - self.next.at).unit_or(NorthEast::new(1.0, 0.0)) * radius_m;
        let target = self.course.onward(following).map_or(NorthEast::default(), |at| at - self.next.at);
        let target_m = target.length();
        if radius_m <= 0.0 || target_m <= 0.0 {
            return true;
        }
        let side = if self.circle.turn == Turn::Clockwise { 1.0 } else { -1.0 };
        let wanted = if target_m >= radius_m {
            (target - out).bearing_rad()
        } else {
            // Nothing lines up with a point within the circle: the nearer its centre, the sooner it turns off.
            let segment = 2.0 * ((radius_m - target_m) / (2.0 * radius_m)).asin();
            target.bearing_rad() + (FRAC_PI_2 - segment) * side
        };
        let heading = out.bearing_rad() + FRAC_PI_2 * side;
        let laps = (self.circle.swept().abs() / TAU).floor();
        if wrap_pi(wanted - heading).abs() > LINED_UP_RAD * (1.0 + laps) {
            return false;
        }
        // The fourth parameter: the next leg begins where the circle is left, not at its centre.
        if item.param(4).is_some_and(|exit| exit > 0.0) {
            self.next = Spot::of(body);
        }
        true
    }
}

/// Radius of a circle item, and whether it is flown anticlockwise.
fn sized(radius_m: Option<f64>) -> (f64, bool) {
    let radius_m = radius_m.unwrap_or(0.0);
    (radius_m.abs(), radius_m < 0.0)
}
