//! The plane as a point mass: bank and pitch follow their demands, lift and thrust do the rest.
//!
//! In path axes (B. Etkin, L. D. Reid, *Dynamics of Flight*, 3rd ed., section 4.5; flat, still Earth, no sideslip):
//!
//! ```text
//! V̇ = T − D − g sin γ        L cos φ = V γ̇ + g cos γ        ψ̇ V cos γ = L sin φ
//! ```
//!
//! all per mass. Lift grows with the angle of attack, whose part in the pitch of a banked plane is α cos φ: so pitch
//! that is held while banking keeps the flight path, which is what an autopilot's pitch law does.

use super::air::eas_to_tas;
use super::aircraft::Aircraft;
use crate::guidance::attitude::{self, Attitude, RateLoop};
use crate::guidance::{GRAVITY_M_S2, NorthEast, bound, lag, wrap_pi};

/// Step of the integration, s.
const STEP_S: f64 = 0.02;
/// Rolling friction of small wheels on firm turf (D. P. Raymer, *Aircraft Design*, 6th ed., table 17.1).
const ROLLING: f64 = 0.05;
/// Friction of a plane that slides to its rest (the same table, brakes on).
const SLIDING: f64 = 0.4;
/// Slowest allowed airspeed over the stall's, as ArduPilot asks for `AIRSPEED_MIN`.
const MIN_OVER_STALL: f64 = 1.2;
/// Airspeed over the slowest allowed one at which a rolling plane may raise its nose, where nothing else is set.
const ROTATE_OVER_MIN: f64 = 1.1;

/// Steps a second of ArduPilot's simulator (`SIM_RATE_HZ` of its plane), and the height within which its ground holds a
/// plane, m.
const SIMULATOR_HZ: f64 = 1_200.0;
const HELD_WITHIN_M: f64 = 0.001;

/// Demands of the autopilot.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Controls {
    pub bank_rad: f64,
    /// Pitch of the fuselage, rad.
    pub pitch_rad: f64,
    /// 0 to 1.
    pub throttle: f64,
    /// Whether it takes off or flares: flies with full or without throttle, whatever height and speed come of it.
    pub is_open: bool,
}

/// Where the plane is and how it moves.
#[derive(Debug, Clone, Copy)]
pub(super) struct Body {
    pub position: NorthEast,
    /// Above home, m.
    pub height_m: f64,
    /// Over ground, m/s.
    pub velocity: NorthEast,
    pub climb_m_s: f64,
    pub bank_rad: f64,
    pub pitch_rad: f64,
    /// Body rate of pitch, rad/s, and the law that moves the elevator; in take-off and flare of ArduPilot's simulator
    /// alone.
    pitch_rate_rad_s: f64,
    pitch_loop: Option<RateLoop>,
    pub heading_rad: f64,
    /// As the autopilot has it.
    pub airspeed_m_s: f64,
    /// True over equivalent airspeed of this air, as the autopilot has it.
    pub eas_to_tas: f64,
    /// True over indicated airspeed.
    factor: f64,
    /// Change of the true airspeed, m/s².
    pub accel_m_s2: f64,
    pub throttle: f64,
    pub is_on_ground: bool,
    /// Whether the ground ends the flight: it has been in the air.
    pub has_flown: bool,
}

/// How far below the ground a climbing plane has flown into it, m.
const INTO_M: f64 = 1.0;

impl Body {
    /// At rest on the ground.
    pub fn parked(position: NorthEast, heading_rad: f64, level_pitch_rad: f64) -> Self {
        Self {
            position,
            height_m: 0.0,
            velocity: NorthEast::default(),
            climb_m_s: 0.0,
            bank_rad: 0.0,
            pitch_rad: level_pitch_rad,
            pitch_rate_rad_s: 0.0,
            pitch_loop: None,
            heading_rad,
            airspeed_m_s: 0.0,
            eas_to_tas: 1.0,
            factor: 1.0,
            accel_m_s2: 0.0,
            throttle: 0.0,
            is_on_ground: true,
            has_flown: false,
        }
    }

    /// In the air, level, at an airspeed (EAS) along a heading.
    pub fn flying(
        position: NorthEast,
        height_m: f64,
        heading_rad: f64,
        airspeed_m_s: f64,
        wind: NorthEast,
        home_amsl_m: f64,
        plane: &Aircraft,
    ) -> Self {
        let eas_to_tas = eas_to_tas(home_amsl_m + height_m);
        let factor = plane.airframe.true_over_indicated(eas_to_tas);
        Self {
            height_m,
            velocity: NorthEast::from_bearing(heading_rad) * (airspeed_m_s * factor) + wind,
            airspeed_m_s,
            eas_to_tas,
            factor,
            throttle: plane.airframe.throttle_cruise,
            is_on_ground: false,
            has_flown: true,
            ..Self::parked(position, heading_rad, plane.airframe.level_pitch_rad)
        }
    }

    /// Moves on by `dt_s` in a wind that is steady for that long.
    pub fn step(
        &mut self,
        controls: &Controls,
        wind: NorthEast,
        ground_height_m: f64,
        home_amsl_m: f64,
        plane: &Aircraft,
        dt_s: f64,
    ) {
        self.eas_to_tas = eas_to_tas(home_amsl_m + self.height_m);
        self.factor = plane.airframe.true_over_indicated(self.eas_to_tas);
        self.throttle = controls.throttle;
        if self.is_on_ground && !self.has_flown && plane.airframe.is_simulated {
            self.roll_simulated(controls, wind, ground_height_m, plane, dt_s);
        } else if self.is_on_ground {
            self.roll(controls, wind, ground_height_m, plane, dt_s);
        } else {
            self.fly(controls, wind, ground_height_m, plane, dt_s);
        }
    }

    fn fly(&mut self, controls: &Controls, wind: NorthEast, ground_height_m: f64, plane: &Aircraft, dt_s: f64) {
        let air = self.velocity - wind;
        let horizontal = air.length().max(0.5);
        let mut speed = horizontal.hypot(self.climb_m_s);
        let mut path = (self.climb_m_s / speed).asin();
        let mut heading = air.bearing_rad();
        let began = speed;
        let roll_rate = limit_or(plane.roll_rate_max_deg_s);
        let count = (dt_s / STEP_S).ceil().max(1.0);
        let dt = dt_s / count;
        let mut moved = NorthEast::default();
        let skid = plane.airframe.skid(self.eas_to_tas);
        for _ in 0..count as usize {
            let rate = (controls.bank_rad - self.bank_rad) / plane.roll_tau_s.max(0.05);
            self.bank_rad += bound(rate, -roll_rate, roll_rate) * dt;
            let airspeed = speed / self.factor;
            self.pitch(controls, airspeed, path, plane, dt);
            let (vertical, load) = lift(self, airspeed, path, plane);
            let (sin_path, cos_path) = path.sin_cos();
            let turn = vertical * self.bank_rad.tan() / (speed * cos_path.max(0.2) * (1.0 + skid));
            let accel = plane.airframe.thrust(controls.throttle, airspeed)
                - plane.airframe.drag(airspeed, load)
                - GRAVITY_M_S2 * sin_path;
            speed = (speed + accel * dt).max(1.0);
            path = bound(path + (vertical - GRAVITY_M_S2 * cos_path) / speed * dt, -1.2, 1.2);
            heading += turn * dt;
            let (sin_path, cos_path) = path.sin_cos();
            moved = moved + NorthEast::from_bearing(heading) * (speed * cos_path * dt);
            self.height_m += speed * sin_path * dt;
        }
        let (sin_path, cos_path) = path.sin_cos();
        self.accel_m_s2 = (speed - began) / dt_s;
        self.position = self.position + moved + wind * dt_s;
        self.velocity = NorthEast::from_bearing(heading) * (speed * cos_path) + wind;
        self.climb_m_s = speed * sin_path;
        self.heading_rad = wrap_pi(heading);
        self.airspeed_m_s = speed / self.factor;
        // What climbs from the ground is not stopped by it, what flies into rising ground is.
        if self.height_m <= ground_height_m && (self.climb_m_s <= 0.0 || self.height_m < ground_height_m - INTO_M) {
            self.height_m = ground_height_m;
            self.climb_m_s = 0.0;
            self.is_on_ground = true;
        }
    }

    /// Pitch follows its demand with the autopilot's time constant: its loops for height and speed take out what the
    /// trim lags. In a take-off and in a flare they do not, and the speed changes fast: there the nose is where the
    /// elevator has moved it, if the moments are known, and lags while the trim comes from the integrator of the rate
    /// loop.
    fn pitch(&mut self, controls: &Controls, airspeed_m_s: f64, path_rad: f64, plane: &Aircraft, dt: f64) {
        if !(plane.airframe.is_simulated && controls.is_open) {
            self.pitch_rad = lag(self.pitch_rad, controls.pitch_rad, plane.pitch_tau_s.max(0.05), dt);
            self.pitch_loop = None;
            self.pitch_rate_rad_s = 0.0;
            return;
        }
        let now = Attitude {
            pitch_rad: self.pitch_rad,
            rates_rad_s: [0.0, self.pitch_rate_rad_s, 0.0],
            airspeed_m_s,
            eas_to_tas: self.eas_to_tas,
            ..Attitude::default()
        };
        let asked_rad = controls.pitch_rad;
        let holding = self.pitch_loop.unwrap_or_else(|| RateLoop::holding(plane.airframe.level_elevator(airspeed_m_s)));
        let (pitch_loop, elevator) = attitude::hold_pitch(holding, &now, asked_rad, true, &plane.attitude, dt);
        self.pitch_loop = Some(pitch_loop);
        let lifting_rad = attack(self, path_rad, plane);
        let accel =
            plane.airframe.pitch_accel(airspeed_m_s, self.eas_to_tas, lifting_rad, self.pitch_rate_rad_s, elevator);
        self.pitch_rate_rad_s += accel * dt;
        self.pitch_rad += self.pitch_rate_rad_s * dt;
    }

    /// The take-off run of ArduPilot's simulator. Its ground stops every rotation after each of its steps, so that the
    /// nose rises by the moment of one step at a time and not at all below 5 m/s; and it holds what has not risen by a
    /// millimetre within one step, so that the plane must climb at more than a metre a second to leave it
    /// (`SIM_Aircraft::update_dynamics` and `on_ground`).
    fn roll_simulated(
        &mut self,
        controls: &Controls,
        wind: NorthEast,
        ground_height_m: f64,
        plane: &Aircraft,
        dt_s: f64,
    ) {
        let nose = NorthEast::from_bearing(self.heading_rad);
        let began = self.velocity.length();
        let (mut speed, mut moved_m) = (began, 0.0);
        self.height_m = ground_height_m;
        self.bank_rad = 0.0;
        let count = (dt_s / STEP_S).ceil().max(1.0);
        let dt = dt_s / count;
        for _ in 0..count as usize {
            let along = (nose * speed - wind).dot(nose).max(0.0);
            let airspeed = along / self.factor;
            let wanted = if airspeed >= plane.rotate_airspeed_m_s { controls.pitch_rad } else { 0.0 };
            // Slower the autopilot's integrators are held (`AP_PitchController`).
            let is_fast = airspeed > 0.5 * plane.tecs.airspeed_min_m_s;
            let path = self.climb_m_s.atan2(along.max(1.0));
            let (vertical, load) = lift(self, airspeed, path, plane);
            let now = Attitude {
                pitch_rad: self.pitch_rad,
                airspeed_m_s: airspeed,
                eas_to_tas: self.eas_to_tas,
                ..Attitude::default()
            };
            let (pitch_loop, elevator) =
                attitude::hold_pitch(self.pitch_loop.unwrap_or_default(), &now, wanted, is_fast, &plane.attitude, dt);
            self.pitch_loop = Some(pitch_loop);
            let accel = plane.airframe.pitch_accel(airspeed, self.eas_to_tas, attack(self, path, plane), 0.0, elevator);
            let rises_rad = if speed > 5.0 { accel / SIMULATOR_HZ * dt } else { -self.pitch_rad };
            self.pitch_rad = (self.pitch_rad + rises_rad).max(0.0);
            self.climb_m_s = (self.climb_m_s + (vertical - GRAVITY_M_S2) * dt).max(0.0);
            let accel =
                plane.airframe.thrust(controls.throttle, airspeed) - plane.airframe.drag(airspeed, load) - 0.3 * speed;
            speed = (speed + accel * dt).max(0.0);
            moved_m += speed * dt;
        }
        self.position = self.position + nose * moved_m;
        self.velocity = nose * speed;
        self.accel_m_s2 = (speed - began) / dt_s;
        self.airspeed_m_s = (self.velocity - wind).dot(nose).max(0.0) / self.factor;
        if self.climb_m_s > HELD_WITHIN_M * SIMULATOR_HZ {
            self.is_on_ground = false;
            self.has_flown = true;
        }
    }

    /// A take-off run along the heading, or the way to rest after a touch-down along the course.
    fn roll(&mut self, controls: &Controls, wind: NorthEast, ground_height_m: f64, plane: &Aircraft, dt_s: f64) {
        self.height_m = ground_height_m;
        let nose = NorthEast::from_bearing(self.heading_rad);
        let along = if self.has_flown { self.velocity.unit_or(nose) } else { nose };
        let speed = self.velocity.length();
        let airspeed = (along * speed - wind).dot(nose).max(0.0) / self.factor;
        self.bank_rad = 0.0;
        let level = plane.airframe.level_pitch_rad;
        let rotates = plane.rotate_airspeed_m_s.max(ROTATE_OVER_MIN * plane.tecs.airspeed_min_m_s);
        let wanted = if !self.has_flown && airspeed >= rotates { controls.pitch_rad } else { level };
        self.pitch_rad = lag(self.pitch_rad, wanted, plane.pitch_tau_s.max(0.05), dt_s);
        let (vertical, _) = lift(self, airspeed, 0.0, plane);
        let weight = (GRAVITY_M_S2 - vertical).max(0.0);
        let friction = match (plane.airframe.is_simulated, self.has_flown) {
            // The simulator's ground holds back by 0.3 of the speed (SIM_Plane.cpp).
            (true, _) => 0.3 * speed,
            (false, true) => plane.airframe.ground_drag_m_s2.unwrap_or(SLIDING * GRAVITY_M_S2),
            (false, false) => ROLLING * weight,
        };
        let thrust = if self.has_flown { 0.0 } else { plane.airframe.thrust(controls.throttle, airspeed) };
        let accel = thrust - plane.airframe.drag(airspeed, 0.0) - friction;
        let next = (speed + accel * dt_s).max(0.0);
        self.position = self.position + along * (0.5 * (speed + next) * dt_s);
        self.accel_m_s2 = (next - speed) / dt_s;
        self.velocity = along * next;
        self.airspeed_m_s = (self.velocity - wind).dot(nose).max(0.0) / self.factor;
        self.climb_m_s = 0.0;
        if !self.has_flown && vertical > GRAVITY_M_S2 && self.pitch_rad >= level {
            self.is_on_ground = false;
            self.has_flown = true;
        }
    }
}

/// Angle of attack counted from no lift, times the cosine of the bank, rad.
fn attack(body: &Body, path_rad: f64, plane: &Aircraft) -> f64 {
    body.pitch_rad - plane.airframe.level_pitch_rad - path_rad + plane.airframe.attack_rad
}

/// Vertical part of the lift per mass, m/s², and the load factor.
fn lift(body: &Body, airspeed_m_s: f64, path_rad: f64, plane: &Aircraft) -> (f64, f64) {
    let cos_bank = body.bank_rad.cos().max(0.1);
    let square = (airspeed_m_s / plane.airframe.cruise_m_s).powi(2);
    let load = square * attack(body, path_rad, plane) / plane.airframe.attack_rad / cos_bank;
    let most = (MIN_OVER_STALL * airspeed_m_s / plane.tecs.airspeed_min_m_s.max(1.0)).powi(2);
    let load = bound(load, -0.5 * most, most);
    (GRAVITY_M_S2 * load * cos_bank, load)
}

/// A rate limit in rad/s; 0: no limit.
fn limit_or(deg_s: f64) -> f64 {
    if deg_s > 0.0 { deg_s.to_radians() } else { f64::INFINITY }
}
