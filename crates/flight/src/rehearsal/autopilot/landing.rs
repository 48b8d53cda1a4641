//! The return to launch, the landing, and one that is broken off (`ArduPlane/mode_rtl.cpp`, `AP_Landing_Slope.cpp`).

use std::f64::consts::{FRAC_PI_2, PI};

use super::super::aircraft::Autoland;
use super::super::body::Body;
use super::super::course::Spot;
use super::super::outcome::Ending;
use super::circles::LINED_UP_RAD;
use super::{Autopilot, Mode, Stage, TakeOff, proportion};
use crate::guidance::l1::Track;
use crate::guidance::{NorthEast, bound};
use crate::plan::{Command, MissionItem};

/// The same before a return goes on to the landing, m.
const RETURN_HEIGHT_REACHED_M: f64 = 10.0;
/// How far beyond the landing point the approach's slope is drawn, m.
const BEYOND_LANDING_M: f64 = 500.0;
/// How far ahead of the plane its course is drawn, m: beyond the point, so that nothing turns there.
const AHEAD_OF_LANDING_M: f64 = 200.0;
/// Height above home that a landing broken off climbs to, m, and its least pitch, rad, where neither the landing nor a
/// take-off gives one (`Plane::do_land`).
const ABORT_HEIGHT_M: f64 = 30.0;
const ABORT_PITCH_RAD: f64 = 10.0 * PI / 180.0;

impl Autopilot<'_> {
    pub(super) fn return_home(&mut self, body: &Body, time_s: f64) {
        self.leave_mission(Mode::Return { has_climbed: false, looked_for_landing: false }, body);
        let height_m = if self.plane.return_height_m < 0.0 { body.height_m } else { self.plane.return_height_m };
        self.next = self.course.nearest_return(body, height_m, self.plane);
        if self.plane.return_follows_terrain && !self.next.follows_ground {
            // The height above home becomes one above the ground there (`Plane::setup_terrain_target_alt`).
            if let Some(ground_m) = self.ground_ahead_m(self.next.at) {
                self.next = Spot { height_m: self.next.height_m - ground_m, follows_ground: true, ..self.next };
            }
        }
        self.distance_m = (self.next.at - body.position).length();
        self.set_up_slope(body, false, false);
        self.turn_rad = FRAC_PI_2;
        match self.plane.autoland {
            Autoland::AtOnce => self.look_for_landing(self.course.nearest_landing(body), body, time_s),
            Autoland::ReturnPath => self.look_for_landing(self.course.nearest_on_return_path(body), body, time_s),
            Autoland::Never | Autoland::AfterReturn => {}
        }
    }

    /// Goes from a return to the landing at an item, if there is one. Where nothing is flown from there on but the next
    /// return, the vehicle changes to and fro between AUTO and RTL (`ModeRTL::navigate`) and gets home all the same:
    /// that return does not look for a landing.
    fn look_for_landing(&mut self, index: Option<usize>, body: &Body, time_s: f64) {
        if self.is_looking_for_landing {
            return;
        }
        self.is_looking_for_landing = true;
        self.join(index, body, time_s);
        self.is_looking_for_landing = false;
        if let Mode::Return { looked_for_landing, .. } = &mut self.mode {
            *looked_for_landing |= index.is_some();
        }
    }

    pub(super) fn fly_return(&mut self, body: &Body, time_s: f64) -> Track {
        let radius_m = self.plane.return_radius_m;
        let track = self.circle_around(radius_m.abs(), radius_m < 0.0, false, body, time_s);
        if let Mode::Return { has_climbed: false, looked_for_landing } = self.mode {
            let climbs_m = self.plane.return_climb_min_m;
            if climbs_m <= 0.0 || body.height_m - self.previous.height_m > climbs_m {
                if climbs_m > 0.0 {
                    self.previous = Spot::of(body);
                    self.set_up_slope(body, false, false);
                }
                self.mode = Mode::Return { has_climbed: true, looked_for_landing };
            }
        }
        let is_there = self.is_on_circle();
        if is_there && let Some(passage) = self.passages.last_mut() {
            passage.reached_s.get_or_insert(time_s);
        }
        if let Mode::Return { has_climbed, looked_for_landing: false } = self.mode
            && is_there
            && (self.target_height_m - body.height_m).abs() < RETURN_HEIGHT_REACHED_M
        {
            self.mode = Mode::Return { has_climbed, looked_for_landing: true };
            if self.plane.autoland == Autoland::AfterReturn {
                self.look_for_landing(self.course.nearest_landing(body), body, time_s);
            }
        }
        if self.item().is_none() {
            self.end_after_laps(Ending::Returned);
        }
        track
    }

    /// Goes on with the mission at an item, if there is one, straight from here.
    fn join(&mut self, index: Option<usize>, body: &Body, time_s: f64) {
        if let Some(index) = index {
            self.previous = Spot::of(body);
            self.next = Spot::of(body);
            self.start_from(index, time_s, body);
        }
    }

    pub(super) fn land(&mut self, body: &Body) -> Track {
        let height_m = self.counted_m(body) - self.next.height_m;
        if self.stage == Stage::Normal {
            let after_circle = self
                .passages
                .iter()
                .rev()
                .nth(1)
                .and_then(|passage| self.course.items.get(passage.item))
                .is_some_and(|item| item.command == Command::NAV_LOITER_TO_ALT);
            let leg = (self.next.at - self.previous.at).unit_or(NorthEast::new(1.0, 0.0));
            let across_m = (body.position - self.previous.at).cross(leg);
            let is_aligned = self.l1.eta_rad.abs() < LINED_UP_RAD;
            let part = self.proportion;
            if after_circle
                || (part >= 0.0 && is_aligned && across_m.abs() < 5.0)
                || (part > 0.15 && is_aligned && body.height_m < self.previous.height_m)
                || part > 0.5
            {
                self.stage = Stage::Approach;
            }
        }
        let sink_m_s = self.smoothed_sink_m_s;
        let is_low = height_m <= self.plane.flare_height_m
            || (self.plane.flare_time_s > 0.0
                && height_m <= sink_m_s * self.plane.flare_time_s
                && self.proportion > 0.5);
        let comes_in = matches!(self.stage, Stage::Approach | Stage::PreFlare);
        if (comes_in && is_low) || (self.proportion >= 1.0 && !matches!(self.stage, Stage::Flare { .. })) {
            self.stage = Stage::Flare { height_m: height_m.max(0.1), sink_m_s: -body.climb_m_s };
        } else if self.stage == Stage::Approach && self.plane.preflare_airspeed_m_s > 0.0 {
            let by_height = self.plane.preflare_height_m > 0.0 && height_m <= self.plane.preflare_height_m;
            let by_time = self.plane.preflare_time_s > 0.0 && height_m <= sink_m_s * self.plane.preflare_time_s;
            if by_height || by_time {
                self.stage = Stage::PreFlare;
            }
        }
        // The line goes on beyond the point, so that nothing turns there.
        let along = (self.next.at - self.previous.at).unit_or(NorthEast::new(1.0, 0.0));
        let ahead_m = (body.position - self.previous.at).length() + AHEAD_OF_LANDING_M;
        Track::Leg { from: self.previous.at, to: self.next.at + along * ahead_m }
    }

    /// Breaks a landing off: by the abort pattern of the mission, if it has one (`Plane::trigger_land_abort`); else
    /// full throttle, wings level, up to the height that the landing gives in its first parameter, else that of the
    /// last take-off (`Plane::do_land`, `AP_Landing::verify_abort_landing`). The course of the approach is asked for
    /// but not flown: the bank of a climb-out waits for that of a take-off run, which is forgotten by then
    /// (`Plane::takeoff_calc_roll`). Nor does the nose come down before the height is there
    /// (`Plane::get_takeoff_pitch_min_cd`).
    pub(super) fn go_around(&mut self, body: &Body, time_s: f64) {
        if let Some(index) = self.course.nearest_abort(body) {
            self.is_in_landing_sequence = false;
            self.next_has_crosstrack = false;
            self.join(Some(index), body, time_s);
            return;
        }
        let Some(item) = self.item().and_then(|index| self.course.items.get(index)) else { return };
        let given_m = item.param(1).filter(|height_m| *height_m > 0.0);
        let (height_m, pitch_rad) =
            self.took_off.filter(|took_off| took_off.0 > 0.0).unwrap_or((ABORT_HEIGHT_M, ABORT_PITCH_RAD));
        self.stage = Stage::Normal;
        self.takes_off = Some(TakeOff {
            height_m: given_m.unwrap_or(height_m),
            pitch_rad,
            began_s: time_s - self.plane.takeoff_delay_s,
            course_rad: None,
            fast_since_s: None,
            levels_off_m: None,
            is_abort: true,
        });
    }

    /// Climbs away, and begins the landing again: at an item that climbs straight on after it, else at the nearest
    /// DO_LAND_START, else at the place before the landing; without one it returns
    /// (`AP_Landing::restart_landing_sequence`).
    pub(super) fn fly_around(&mut self, index: usize, body: &Body, time_s: f64) -> Track {
        let Some(TakeOff { height_m, .. }) = self.takes_off else { return Track::Level };
        if body.height_m > height_m {
            let climbs = |item: &MissionItem| {
                item.command == Command::NAV_CONTINUE_AND_CHANGE_ALT
                    && matches!(item.param(1).unwrap_or(0.0) as i64, 0 | 1)
            };
            let climbs_on = self.course.items.get(index + 1).filter(|item| climbs(item)).map(|_| index + 1);
            let before = || {
                let flown = self.passages.iter().rev().skip(1).map(|passage| passage.item);
                flown.into_iter().find(|item| self.course.places[*item].is_some())
            };
            let again = climbs_on.or_else(|| self.course.nearest_landing(body)).or_else(before);
            self.takes_off = None;
            self.next_has_crosstrack = false;
            match again {
                Some(index) => self.join(Some(index), body, time_s),
                None => self.return_home(body, time_s),
            }
        }
        Track::Level
    }

    /// Height on the glide slope, m above home: to a point that lies before and above the landing by what the flare
    /// needs.
    pub(super) fn slope_height_m(&mut self, body: &Body) -> f64 {
        let plane = self.plane;
        let total_m = (self.next.at - self.previous.at).length().max(1.0);
        let sinks_m = self.previous.height_m - self.next.height_m;
        let groundspeed = body.velocity.length().max(0.5);
        let sink_m_s = sinks_m / (total_m / groundspeed).max(0.5);
        let mut aim_m = plane.flare_time_s * sink_m_s;
        if aim_m <= 0.0 {
            aim_m = plane.flare_height_m;
        }
        if plane.flare_height_m > 0.0 {
            aim_m = aim_m.min(2.0 * plane.flare_height_m);
        }
        let weight = bound(plane.flare_aim, 0.0, 1.0);
        let mean_sink = (weight * plane.tecs.land_sink_m_s + (1.0 - weight) * sink_m_s).max(0.1);
        let flare_m = (groundspeed * aim_m / mean_sink).min(0.5 * total_m);
        let slope = (sinks_m - aim_m) / (total_m - flare_m);
        let along = (self.next.at - self.previous.at).unit_or(NorthEast::new(1.0, 0.0));
        let end = self.next.at + along * (BEYOND_LANDING_M - flare_m);
        let end_m = self.next.height_m + aim_m - slope * BEYOND_LANDING_M;
        let part = bound(1.0 - proportion(self.previous.at, end, body.position), 0.0, 1.0);
        let height_m = end_m + (self.previous.height_m - end_m) * part;
        bound(height_m, end_m.min(self.previous.height_m), end_m.max(self.previous.height_m))
    }
}
