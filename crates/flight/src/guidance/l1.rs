//! L1 lateral guidance: follows a leg, a circle or a heading and answers with a lateral acceleration.
//!
//! The law is eq. (1) of S. Park, J. Deyst and J. P. How, *A New Nonlinear Guidance Logic for Trajectory Tracking*,
//! AIAA Guidance, Navigation and Control Conference, August 2004 (AIAA 2004-4900):
//!
//! ```text
//! a = 2 V² / L1 · sin η
//! ```
//!
//! where η is the angle from the ground velocity to the reference point on the path, L1 ahead. Their linearisation
//! (section II.C) is a second-order system with ω = √2 V / L1 and ζ = 1/√2. As in ArduPlane, period and damping are
//! chosen instead: with `K = 4 ζ²` in place of 2 and `L1 = ζ T V / π` the linear system has damping ζ and period T at
//! every speed, because L1 grows with the ground speed.

use super::{GRAVITY_M_S2, NorthEast, bound, wrap_pi};
use std::f64::consts::{FRAC_1_SQRT_2, FRAC_PI_2, PI, SQRT_2, TAU};

/// Parameters of the lateral guidance.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct L1Params {
    /// Period of the tracking loop, s; 1 to 60, default 15 (`NAVL1_PERIOD`).
    pub period_s: f64,
    /// Damping ratio of the tracking loop; 0.6 to 1, default 0.75 (`NAVL1_DAMPING`).
    pub damping: f64,
    /// Gain of the cross-track integrator, 1/s; 0 to 0.1, default 0.02, 0 is off (`NAVL1_XTRACK_I`).
    pub xtrack_gain_per_s: f64,
}

impl Default for L1Params {
    fn default() -> Self {
        Self { period_s: 15.0, damping: 0.75, xtrack_gain_per_s: 0.02 }
    }
}

impl L1Params {
    fn period(&self) -> f64 {
        bound(self.period_s, 1.0, 60.0)
    }

    fn damping(&self) -> f64 {
        bound(self.damping, 0.3, 2.0)
    }

    /// L1 length at a ground speed, m: `ζ T V / π`.
    pub fn length_m(&self, groundspeed_m_s: f64) -> f64 {
        self.damping() * self.period() * groundspeed_m_s.max(0.1) / PI
    }
}

/// Which way a circle is flown, seen from above.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Turn {
    /// To the right; a positive radius in a mission.
    #[default]
    Clockwise,
    /// To the left; a negative radius in a mission.
    Anticlockwise,
}

impl Turn {
    fn sign(self) -> f64 {
        match self {
            Self::Clockwise => 1.0,
            Self::Anticlockwise => -1.0,
        }
    }
}

/// What to follow.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Track {
    /// The straight line from one point to the next.
    Leg {
        /// Where the leg starts.
        from: NorthEast,
        /// Where it ends.
        to: NorthEast,
    },
    /// A circle around a point; flown to directly while it is far.
    Circle {
        /// Centre.
        centre: NorthEast,
        /// Radius over ground, m, above 0.
        radius_m: f64,
        /// Direction of flight.
        turn: Turn,
    },
    /// A heading of the nose, radians from north.
    Heading {
        /// The heading.
        heading_rad: f64,
    },
    /// Wings level, wherever that leads.
    Level,
}

impl Track {
    /// True when going on from `previous` to this track is not a new target: the same circle, its radius at most 10 %
    /// other (it grows with height, as the true airspeed does), or an equal track.
    pub fn continues(&self, previous: &Self) -> bool {
        match (self, previous) {
            (
                Self::Circle { centre, radius_m, turn },
                Self::Circle { centre: centre_before, radius_m: radius_before, turn: turn_before },
            ) => {
                centre == centre_before
                    && turn == turn_before
                    && (radius_m - radius_before).abs() <= 0.1 * radius_before.abs()
            }
            _ => self == previous,
        }
    }
}

/// How the plane moves over the ground.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Motion {
    /// Position in the tangent plane, m.
    pub position: NorthEast,
    /// Velocity over ground, m/s.
    pub velocity: NorthEast,
    /// Heading of the nose, radians from north.
    pub heading_rad: f64,
}

/// Memory of the law between two steps.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct L1State {
    /// Angle that the cross-track integrator adds, rad, within ±0.1.
    pub xtrack_integral_rad: f64,
    /// Last angle to the reference point, rad.
    pub eta_rad: f64,
    /// True once a circle is being flown (not still approached).
    pub on_circle: bool,
}

/// Answer of the law.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct L1Output {
    /// Lateral acceleration demand, m/s², positive to the right.
    pub lateral_accel_m_s2: f64,
    /// Bearing of the reference point, rad, −π to π.
    pub nav_bearing_rad: f64,
    /// Bearing of the target (end of leg, centre of circle, heading), rad, −π to π.
    pub target_bearing_rad: f64,
    /// Angle from the ground velocity to the reference point, rad.
    pub bearing_error_rad: f64,
    /// Cross-track error, m: positive left of a leg, positive outside a circle.
    pub xtrack_error_m: f64,
    /// L1 length in use, m.
    pub length_m: f64,
}

impl L1Output {
    /// Bank of a coordinated turn with this acceleration, rad: `tan φ = a / (g cos θ)`.
    ///
    /// `pitch_rad` is used within ±60°.
    pub fn bank_rad(&self, pitch_rad: f64) -> f64 {
        let pitch = bound(pitch_rad, -PI / 3.0, PI / 3.0);
        (self.lateral_accel_m_s2 / (GRAVITY_M_S2 * pitch.cos())).atan()
    }
}

/// One step of the lateral law.
///
/// `dt_s` is the time since the last step, 0 to 0.1 s (more counts as 0.1).
pub fn steer(state: L1State, motion: &Motion, track: &Track, params: &L1Params, dt_s: f64) -> (L1State, L1Output) {
    let dt_s = bound(dt_s, 0.0, 0.1);
    match *track {
        Track::Leg { from, to } => follow_leg(state, motion, from, to, params, dt_s),
        Track::Circle { centre, radius_m, turn } => {
            follow_circle(state, motion, centre, radius_m.abs().max(1.0), turn, params)
        }
        Track::Heading { heading_rad } => hold_heading(motion, heading_rad, params),
        Track::Level => {
            let heading = wrap_pi(motion.heading_rad);
            let output = L1Output {
                nav_bearing_rad: heading,
                target_bearing_rad: heading,
                length_m: params.length_m(motion.velocity.length()),
                ..L1Output::default()
            };
            (L1State::default(), output)
        }
    }
}

/// Velocity used for steering: when nearly still or blown backwards, along the nose.
fn steering_velocity(motion: &Motion) -> NorthEast {
    let nose = NorthEast::from_bearing(motion.heading_rad);
    let speed = motion.velocity.length();
    if speed < 0.1 || motion.velocity.dot(nose) <= 0.0 { nose * 0.1 } else { motion.velocity }
}

fn follow_leg(
    state: L1State,
    motion: &Motion,
    from: NorthEast,
    to: NorthEast,
    params: &L1Params,
    dt_s: f64,
) -> (L1State, L1Output) {
    let velocity = steering_velocity(motion);
    let speed = velocity.length();
    let length = params.length_m(speed);
    let to_target = to - motion.position;
    let nose = NorthEast::from_bearing(motion.heading_rad);

    let leg = to - from;
    let leg_length = leg.length();
    let along = if leg_length > 1e-6 { leg * (1.0 / leg_length) } else { to_target.unit_or(nose) };
    let from_start = motion.position - from;
    let xtrack = from_start.cross(along);
    let along_distance = from_start.dot(along);
    let start_distance = from_start.length();

    let mut integral = state.xtrack_integral_rad;
    let (eta, nav_bearing) = if start_distance > length && along_distance < -FRAC_1_SQRT_2 * start_distance.max(1.0) {
        // Far behind the start of the leg: fly to the start first.
        towards(velocity, -from_start.unit_or(nose))
    } else if along_distance > leg_length + 3.0 * speed {
        // Three seconds past the end: turn back to it.
        towards(velocity, to_target.unit_or(nose))
    } else {
        // On the leg: η = η₁ + η₂ (fig. 2 of the paper), η₁ limited so that the track is met at 45° at most.
        let eta2 = velocity.cross(along).atan2(velocity.dot(along));
        let mut eta1 = bound(xtrack / length.max(0.1), -FRAC_1_SQRT_2, FRAC_1_SQRT_2).asin();
        if params.xtrack_gain_per_s <= 0.0 {
            integral = 0.0;
        } else if eta1.abs() < 5_f64.to_radians() {
            // Removes what a trim error leaves; 0.1 rad is as much as a level that is off can need.
            integral = bound(integral + eta1 * params.xtrack_gain_per_s * dt_s, -0.1, 0.1);
        }
        eta1 += integral;
        (eta1 + eta2, wrap_pi(along.bearing_rad() + eta1))
    };
    let target_bearing = to_target.unit_or(nose).bearing_rad();
    let eta = keep_decision(eta, &state, target_bearing, motion.heading_rad);
    let limited = bound(eta, -FRAC_PI_2, FRAC_PI_2);
    let output = L1Output {
        lateral_accel_m_s2: gain(params) * speed * speed / length * limited.sin(),
        nav_bearing_rad: nav_bearing,
        target_bearing_rad: target_bearing,
        bearing_error_rad: limited,
        xtrack_error_m: xtrack,
        length_m: length,
    };
    (L1State { xtrack_integral_rad: integral, eta_rad: eta, on_circle: false }, output)
}

/// `K = 4 ζ²`: 2 in the paper, where ζ is 1/√2.
fn gain(params: &L1Params) -> f64 {
    4.0 * params.damping() * params.damping()
}

/// Angle from the velocity to a direction, and the direction's bearing.
fn towards(velocity: NorthEast, direction: NorthEast) -> (f64, f64) {
    (velocity.cross(direction).atan2(velocity.dot(direction)), direction.bearing_rad())
}

/// Keeps turning the way it began when the target is straight behind, where the sign of η flips with every gust.
fn keep_decision(eta: f64, state: &L1State, target_bearing: f64, heading: f64) -> f64 {
    let behind = 0.9 * PI;
    let nose_away = wrap_pi(target_bearing - heading).abs() > 120_f64.to_radians();
    if eta.abs() > behind && state.eta_rad.abs() > behind && nose_away && eta * state.eta_rad < 0.0 {
        state.eta_rad
    } else {
        eta
    }
}

/// A circle: capture by the L1 law towards the centre, then proportional-derivative control of the radius around the
/// centripetal acceleration, `a = V_t²/r + ω² e + 2 ζ ω ė` with ω = 2π/T; the smaller demand wins while outside, so
/// that one takes over from the other without a step. (Circles are section III of the paper; the derivative law
/// replaces it because it also holds circles smaller than L1.)
fn follow_circle(
    state: L1State,
    motion: &Motion,
    centre: NorthEast,
    radius_m: f64,
    turn: Turn,
    params: &L1Params,
) -> (L1State, L1Output) {
    let speed = motion.velocity.length().max(1.0);
    let length = params.length_m(speed);
    let omega = TAU / params.period();
    let nose = NorthEast::from_bearing(motion.heading_rad);

    let from_centre = motion.position - centre;
    let distance = from_centre.length();
    let outward = if distance > 0.1 { from_centre * (1.0 / distance) } else { motion.velocity.unit_or(nose) };

    // Capture.
    let across = outward.cross(motion.velocity);
    let inward_speed = -motion.velocity.dot(outward);
    let target_bearing = (-outward).bearing_rad();
    let eta = keep_decision(across.atan2(inward_speed), &state, target_bearing, motion.heading_rad);
    let limited = bound(eta, -FRAC_PI_2, FRAC_PI_2);
    let capture = gain(params) * speed * speed / length * limited.sin();

    // Circle.
    let error = distance - radius_m;
    let tangential = across * turn.sign();
    let mut correction = error * omega * omega - inward_speed * 2.0 * params.damping() * omega;
    if inward_speed < 0.0 && tangential < 0.0 {
        // Flying the wrong way round and outwards: never tighten the wrong turn.
        correction = correction.max(0.0);
    }
    let centripetal = tangential * tangential / distance.max(0.5 * radius_m);
    let circle = turn.sign() * (correction + centripetal);

    let capturing = error > 0.0 && turn.sign() * capture < turn.sign() * circle;
    let output = L1Output {
        lateral_accel_m_s2: if capturing { capture } else { circle },
        nav_bearing_rad: target_bearing,
        target_bearing_rad: target_bearing,
        bearing_error_rad: if capturing { limited } else { 0.0 },
        xtrack_error_m: error,
        length_m: length,
    };
    // Once on the circle, a gust that pushes the plane out does not undo it as long as the target stays
    // (the caller starts from a fresh state when it gives another circle).
    let state = L1State { xtrack_integral_rad: 0.0, eta_rad: eta, on_circle: state.on_circle || !capturing };
    (state, output)
}

/// A heading: `a = 2 V ω sin ν` with ω = √2 π / T, the linear system of the paper with L1 = V / ω.
fn hold_heading(motion: &Motion, heading_rad: f64, params: &L1Params) -> (L1State, L1Output) {
    let speed = motion.velocity.length();
    let omega = SQRT_2 * PI / params.period();
    let error = wrap_pi(heading_rad - motion.heading_rad);
    let limited = bound(error, -FRAC_PI_2, FRAC_PI_2);
    let output = L1Output {
        lateral_accel_m_s2: 2.0 * limited.sin() * speed * omega,
        nav_bearing_rad: wrap_pi(heading_rad),
        target_bearing_rad: wrap_pi(heading_rad),
        bearing_error_rad: error,
        xtrack_error_m: 0.0,
        length_m: speed / omega,
    };
    (L1State::default(), output)
}
