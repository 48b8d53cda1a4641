//! Heights, also above the ground below, bank, pitch and throttle (`ArduPlane/altitude.cpp`, `Attitude.cpp`).

use std::f64::consts::PI;

use super::super::body::Body;
use super::super::outcome::GroundLack;
use super::{Autopilot, Mode, STEP_S, Stage, TakeOff, has_passed, proportion};
use crate::guidance::l1::{self, Motion, Track};
use crate::guidance::tecs::{self, Demand, Energy, Phase};
use crate::guidance::{NorthEast, bound};

/// Least bank that stall prevention leaves, rad.
const LEAST_BANK_RAD: f64 = 25.0 * PI / 180.0;
/// Least height at which a climb is flown as a slope, m above home.
const SLOPES_ABOVE_M: f64 = 20.0;
/// Decisions between two looks at the ground ahead: half a second, in which it is 10 m nearer.
const STEPS_A_LOOK: u32 = 5;
/// How far ahead it looks at the most, m, whatever it is set to (the range of `TERRAIN_LOOKAHD`), and at how many
/// places.
const LOOKS_AHEAD_M: f64 = 10_000.0;
const MOST_LOOKS: f64 = 200.0;

impl Autopilot<'_> {
    /// Target height for now.
    pub(super) fn aim(&mut self, body: &Body) {
        self.look_down(body);
        let counted_m = match self.stage {
            Stage::Flare { .. } => self.next.height_m,
            Stage::Approach | Stage::PreFlare => self.slope_height_m(body),
            Stage::Normal => {
                let circles = self.is_on_circle();
                if circles || self.slope_m == 0.0 || has_passed(self.previous.at, self.next.at, body.position) {
                    self.next.height_m
                } else {
                    self.on_slope_m(body)
                }
            }
        };
        self.follower.follows = self.next.follows_ground && self.follower.ground_m.is_some();
        self.target_height_m = counted_m + if self.follower.follows { self.above_ground_ahead_m(body) } else { 0.0 };
    }

    /// Height of the plane in the terms of the next spot: above home, or above the ground below the plane.
    pub(super) fn counted_m(&self, body: &Body) -> f64 {
        body.height_m - self.follower.ground_m.filter(|_| self.next.follows_ground).unwrap_or(0.0)
    }

    /// Height of the ground at a position above home, m, as the autopilot knows it.
    pub(super) fn ground_ahead_m(&self, at: NorthEast) -> Option<f64> {
        if self.plane.knows_terrain { self.course.followed_ground_m(at) } else { None }
    }

    /// Looks at the ground below where the height counts from it. Where that is not known the last known ground counts.
    fn look_down(&mut self, body: &Body) {
        if !self.next.follows_ground {
            return;
        }
        let ground_m = self.ground_ahead_m(body.position);
        self.follower.is_known = ground_m.is_some();
        self.follower.ground_m = ground_m.or(self.follower.ground_m);
    }

    /// Whether the item that is flown lacks the ground that its height counts from.
    pub(super) fn note_ground(&mut self) {
        if !self.next.follows_ground || self.follower.is_known {
            return;
        }
        if let (Mode::Auto(_), Some(passage)) = (self.mode, self.passages.last_mut()) {
            passage.lacks_ground = Some(if self.plane.knows_terrain { GroundLack::Unknown } else { GroundLack::Off });
        }
    }

    /// Height of the ground below, and by how much more the plane must be higher to clear what lies ahead in time, m
    /// (`Plane::lookahead_adjustment`, `AP_Terrain::lookahead`).
    fn above_ground_ahead_m(&mut self, body: &Body) -> f64 {
        let ground_m = self.follower.ground_m.unwrap_or(0.0);
        self.follower.steps = self.follower.steps.wrapping_add(1);
        let (speed, bearing) = (body.velocity.length(), (self.next.at - body.position).unit_or(NorthEast::default()));
        let far_m = self.distance_m.min(self.plane.terrain_lookahead_m).min(LOOKS_AHEAD_M);
        if self.is_on_circle() || speed < 1.0 {
            self.follower.rise_m = 0.0;
        } else if self.follower.steps.is_multiple_of(STEPS_A_LOOK) {
            let spacing_m = self.plane.terrain_spacing_m.max(10.0).max(far_m / MOST_LOOKS);
            let climbs_m = 0.5 * self.plane.tecs.climb_max_m_s / speed * spacing_m;
            let looks = (far_m / spacing_m).ceil().max(0.0) as u32;
            let rise_m = (1..=looks).filter_map(|look| {
                let ahead_m = self.ground_ahead_m(body.position + bearing * (f64::from(look) * spacing_m))?;
                Some(ahead_m - ground_m - f64::from(look) * climbs_m)
            });
            let rise_m = rise_m.fold(0.0, f64::max) + self.slope_m.min(0.0);
            self.follower.rise_m = bound(rise_m, 0.0, 1_000.0);
        }
        ground_m + self.follower.rise_m
    }

    fn on_slope_m(&mut self, body: &Body) -> f64 {
        let part = bound(1.0 - proportion(self.previous.at, self.next.at, body.position), 0.0, 1.0);
        let mut height_m = self.next.height_m - self.slope_m * part;
        let above_m = self.plane.slope_max_above_m;
        let now_m = self.counted_m(body);
        let rise_m = if self.follower.follows { self.follower.rise_m } else { 0.0 };
        if above_m > 0.0 && self.slope_m > 0.0 && now_m > height_m + rise_m + above_m {
            // Far above a climbing slope: a new one begins here.
            let from_here = self.slope_between(now_m, false);
            height_m = self.next.height_m - from_here * part;
            self.slope_m = if part > 0.0 { from_here / part } else { from_here };
        }
        if self.next.follows_ground && self.follower.ground_m.is_some() {
            return height_m;
        }
        let (low, high) = if self.next.height_m < self.previous.height_m {
            (self.next.height_m, self.previous.height_m)
        } else {
            (self.previous.height_m, self.next.height_m)
        };
        bound(height_m, low, high)
    }

    pub(super) fn airspeed_target_m_s(&self, body: &Body) -> f64 {
        let plane = self.plane;
        let mut target = self.airspeed_ordered_m_s.unwrap_or(plane.airspeed_cruise_m_s);
        if self.flies_landing() {
            let base = match self.stage {
                Stage::Normal => plane.airspeed_cruise_m_s,
                Stage::PreFlare | Stage::Flare { .. } if plane.preflare_airspeed_m_s > 0.0 => {
                    plane.preflare_airspeed_m_s
                }
                _ => plane.approach_airspeed(),
            };
            let headwind = -self.wind.dot(NorthEast::from_bearing(body.heading_rad));
            let with_wind = base + headwind * bound(plane.approach_wind_part, 0.0, 1.0);
            target = bound(with_wind, base, plane.airspeed_cruise_m_s.max(base));
        }
        if self.groundspeed_min_m_s > 0.0 {
            let forward = body.velocity.dot(NorthEast::from_bearing(body.heading_rad));
            target = target.max(body.airspeed_m_s + (self.groundspeed_min_m_s - forward) / body.eas_to_tas);
        }
        bound(target, plane.tecs.airspeed_min_m_s, plane.tecs.airspeed_max_m_s)
    }

    pub(super) fn bank(&mut self, body: &Body, track: Track) -> f64 {
        let continues = self.track.is_some_and(|before| track.continues(&before));
        if !continues {
            self.l1.on_circle = false;
        }
        self.track = Some(track);
        let motion = Motion { position: body.position, velocity: body.velocity, heading_rad: body.heading_rad };
        let (l1, output) = l1::steer(self.l1, &motion, &track, &self.plane.l1, STEP_S);
        self.l1 = l1;
        let mut limit = self.plane.bank_max_deg.to_radians() * body.pitch_rad.cos();
        if let Some(takes_off) = self.takes_off {
            limit = limit.min(self.take_off_bank_rad(body));
            if takes_off.course_rad.is_none() {
                limit = 0.0;
            }
        }
        let level = self.plane.bank_level_deg.to_radians();
        if matches!(self.stage, Stage::Flare { .. })
            || matches!(self.mode, Mode::Return { has_climbed: false, .. }) && self.plane.return_climb_min_m > 0.0
        {
            limit = limit.min(level);
        }
        let wanted = match self.mode {
            Mode::Circling { .. } => limit / 3.0,
            Mode::Gliding => 0.0,
            _ => output.bank_rad(body.pitch_rad),
        };
        let mut bank = bound(wanted, -limit, limit);
        self.load = 1.0 / bank.abs().min(85_f64.to_radians()).cos().sqrt();
        if self.plane.prevents_stall {
            let most = self.smoothed_airspeed_m_s / self.plane.tecs.airspeed_min_m_s.max(1.0);
            if most <= 1.0 {
                limit = limit.min(LEAST_BANK_RAD);
            } else if most < self.load {
                limit = limit.min((1.0 / (most * most)).acos().max(LEAST_BANK_RAD));
            }
            bank = bound(bank, -limit, limit);
        }
        bank
    }

    fn take_off_bank_rad(&self, body: &Body) -> f64 {
        let level = self.plane.bank_level_deg.to_radians();
        let full = self.plane.bank_max_deg.to_radians();
        let low_m = self.plane.takeoff_level_height_m.max(0.0);
        let part = if low_m > 0.0 { bound((body.height_m - low_m) / (2.0 * low_m), 0.0, 1.0) } else { 1.0 };
        level + (full - level) * part
    }

    pub(super) fn pitch_and_throttle(&mut self, body: &Body, time_s: f64) -> (f64, f64) {
        if matches!(self.mode, Mode::Gliding | Mode::Landed) {
            return (0.0, 0.0);
        }
        let plane = self.plane;
        let mut demand = Demand {
            height_m: self.target_height_m,
            airspeed_m_s: self.airspeed_target_m_s(body),
            phase: Phase::Cruise,
            pitch_min_rad: plane.pitch_min_deg.to_radians(),
            pitch_max_rad: plane.pitch_max_deg.to_radians(),
            throttle_min: plane.throttle_min.max(0.0),
            throttle_max: plane.throttle_max,
        };
        if plane.prevents_stall {
            let least = plane.tecs.airspeed_min_m_s * self.load;
            demand.airspeed_m_s = demand.airspeed_m_s.max(least.min(plane.tecs.airspeed_max_m_s));
        }
        if let Some(takes_off) = self.takes_off {
            if time_s - takes_off.began_s < plane.takeoff_delay_s {
                return (0.0, 0.0);
            }
            demand.phase = Phase::Climbout;
            demand.pitch_min_rad = self.take_off_pitch_rad(body, takes_off);
            demand.throttle_max = plane.takeoff_throttle;
            demand.throttle_min = plane.takeoff_throttle;
        } else if let Stage::Flare { height_m, sink_m_s } = self.stage {
            let now_m = (self.counted_m(body) - self.next.height_m).max(0.0);
            demand.phase = Phase::Flare { height_m: now_m, start_height_m: height_m, start_sink_m_s: sink_m_s };
            demand.throttle_max = 0.0;
            demand.throttle_min = 0.0;
            if plane.flare_pitch_max_deg > 0.0 {
                demand.pitch_max_rad = plane.flare_pitch_max_deg.to_radians();
            }
            let part = bound(1.0 - now_m / height_m.max(0.1), 0.0, 1.0);
            demand.pitch_min_rad = (1.0 - part) * demand.pitch_min_rad + part * plane.flare_pitch_deg.to_radians();
        } else if self.flies_landing() {
            demand.phase = Phase::Approach { proportion: self.proportion };
        } else if matches!(self.mode, Mode::Return { has_climbed: false, .. }) && plane.return_climb_min_m > 0.0 {
            demand.height_m = demand.height_m.max(self.previous.height_m) + plane.return_climb_min_m + 10.0;
        }
        let energy = Energy {
            height_m: body.height_m,
            climb_m_s: body.climb_m_s,
            airspeed_m_s: body.airspeed_m_s,
            eas_to_tas: body.eas_to_tas,
            accel_m_s2: body.accel_m_s2,
            roll_rad: body.bank_rad,
            pitch_rad: body.pitch_rad - plane.pitch_trim_deg.to_radians(),
        };
        let (tecs, output) = tecs::manage(self.tecs, &energy, &demand, &plane.tecs, STEP_S);
        self.tecs = tecs;
        (output.pitch_rad, output.throttle)
    }

    /// Least pitch of a take-off: the item's, fading before its height is reached.
    fn take_off_pitch_rad(&mut self, body: &Body, takes_off: TakeOff) -> f64 {
        let left_m = takes_off.height_m - body.height_m;
        let fades_s = self.plane.takeoff_level_off_s;
        if fades_s <= 0.0 || takes_off.is_abort {
            return takes_off.pitch_rad;
        }
        if let Some(from_m) = takes_off.levels_off_m {
            return takes_off.pitch_rad * bound(left_m / from_m, 0.0, 1.0);
        }
        if body.climb_m_s > 0.1 && body.height_m >= 10.0 && left_m > 0.0 && left_m / body.climb_m_s <= fades_s {
            self.takes_off = Some(TakeOff { levels_off_m: Some(left_m), ..takes_off });
        }
        takes_off.pitch_rad
    }

    pub(super) fn set_up_slope(&mut self, body: &Body, is_mission: bool, is_landing: bool) {
        self.look_down(body);
        let height_m = self.counted_m(body);
        let descends = height_m > self.next.height_m;
        let slopes = descends || (is_mission && !self.plane.climbs_at_once && body.height_m > SLOPES_ABOVE_M);
        // On the way from one height above ground to the next the present one counts; else the numbers do, whatever
        // they count from.
        let from_m = if self.next.follows_ground && self.follower.follows { height_m } else { self.previous.height_m };
        self.slope_m = if slopes { self.slope_between(from_m, is_landing) } else { 0.0 };
    }

    fn slope_between(&self, from_m: f64, is_landing: bool) -> f64 {
        let slope_m = self.next.height_m - from_m;
        let least_m = self.plane.slope_min_m;
        if !is_landing && (least_m <= 0.0 || slope_m.abs() < least_m) { 0.0 } else { slope_m }
    }
}
