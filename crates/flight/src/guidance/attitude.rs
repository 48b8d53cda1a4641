//! Attitude laws: bank, pitch and slip to aileron, elevator and rudder.
//!
//! Each axis is a time constant from angle error to rate demand, and a rate loop of feed-forward, proportional,
//! integral and derivative parts. Control moments grow with the square of the airspeed and damping moments with its
//! first power (B. Etkin, L. D. Reid, *Dynamics of Flight*, 3rd ed. 1996, tables 4.4 and 5.3), so the feedback parts
//! scale with (V₀/V)² and the feed-forward with V₀/V. Gains are in ArduPlane's unit: radians of a 45° surface travel
//! per rad/s.

use super::{GRAVITY_M_S2, bound, lag, wrap_pi};
use std::f64::consts::FRAC_PI_4;

/// Gains of one rate loop. Defaults depend on the axis: see [`AttitudeParams`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RateGains {
    /// Feed-forward; 0 to 3 (`RLL_RATE_FF`, `PTCH_RATE_FF`).
    pub ff: f64,
    /// Proportional; 0 to 2 (`…_RATE_P`).
    pub p: f64,
    /// Integral, 1/s; 0 to 2 (`…_RATE_I`).
    pub i: f64,
    /// Derivative, s; 0 to 0.1 (`…_RATE_D`).
    pub d: f64,
    /// Limit of the integral part; 0 to 1 (`…_RATE_IMAX`).
    pub integral_max: f64,
}

/// Parameters of the attitude laws.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct AttitudeParams {
    /// Time constant of bank, s; 0.1 to 1, default 0.25 (`RLL2SRV_TCONST`).
    pub roll_tau_s: f64,
    /// Highest roll rate, rad/s; 0 is unlimited, default 90°/s (`RLL2SRV_RMAX`).
    pub roll_rate_max_rad_s: f64,
    /// Roll rate loop; default FF 0.237, P 0.3, I 0.25, D 0.0174, IMAX 0.666 (`RLL_RATE_*`).
    pub roll: RateGains,
    /// Time constant of pitch, s; 0.1 to 1, default 0.25 (`PTCH2SRV_TCONST`).
    pub pitch_tau_s: f64,
    /// Highest pitch rate, rad/s; 0 is unlimited, default 90°/s (`PTCH2SRV_RMAX_UP` and `_DN`).
    pub pitch_rate_max_rad_s: f64,
    /// Pitch rate loop; default FF 0.596, P 0.15, I 0.11, D 0.0073, IMAX 0.666 (`PTCH_RATE_*`).
    pub pitch: RateGains,
    /// Part of the turn's pitch rate that is fed forward; 0.7 to 1.5, default 1 (`PTCH2SRV_RLL`).
    pub turn_pitch: f64,
    /// Rudder per aileron; 0 to 1, default 0.5 (`KFF_RDDRMIX`).
    pub rudder_mix: f64,
    /// Yaw damper, s; 0 to 2, default 0 (`YAW2SRV_DAMP`).
    pub yaw_damping: f64,
    /// Airspeed of the gains, m/s EAS, default 15 (`SCALING_SPEED`).
    pub scaling_speed_m_s: f64,
    /// Slowest and fastest airspeed that scales, m/s EAS; default 10 and 30 (`AIRSPEED_MIN`, `AIRSPEED_MAX`).
    pub airspeed_range_m_s: (f64, f64),
}

impl Default for AttitudeParams {
    fn default() -> Self {
        Self {
            roll_tau_s: 0.25,
            roll_rate_max_rad_s: 90_f64.to_radians(),
            roll: RateGains { ff: 0.237_212, p: 0.3, i: 0.25, d: 0.017_43, integral_max: 0.666 },
            pitch_tau_s: 0.25,
            pitch_rate_max_rad_s: 90_f64.to_radians(),
            pitch: RateGains { ff: 0.595_723, p: 0.15, i: 0.11, d: 0.007_265, integral_max: 0.666 },
            turn_pitch: 1.0,
            rudder_mix: 0.5,
            yaw_damping: 0.0,
            scaling_speed_m_s: 15.0,
            airspeed_range_m_s: (10.0, 30.0),
        }
    }
}

/// Attitude, rates and airspeed.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Attitude {
    /// Bank, rad.
    pub roll_rad: f64,
    /// Pitch, rad.
    pub pitch_rad: f64,
    /// Body rates p, q, r, rad/s.
    pub rates_rad_s: [f64; 3],
    /// Airspeed, m/s EAS.
    pub airspeed_m_s: f64,
    /// True over equivalent airspeed.
    pub eas_to_tas: f64,
}

/// Memory of the laws.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct AttitudeState {
    roll: RateLoop,
    pitch: RateLoop,
    yaw_rate_lag: f64,
}

/// Memory of one rate loop.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct RateLoop {
    integral: f64,
    rate_lag: f64,
}

/// Surface commands, each −1 to 1 of its travel.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Surfaces {
    /// Positive rolls right.
    pub aileron: f64,
    /// Positive pitches up.
    pub elevator: f64,
    /// Positive yaws right.
    pub rudder: f64,
}

/// One step: surfaces that take the plane to a bank and a pitch. `dt_s` 0.001 to 0.1 s.
///
/// `integrate` is false on the ground, where the wheels hold the attitude and an integrator would only wind up.
pub fn stabilise(
    state: AttitudeState,
    now: &Attitude,
    bank_rad: f64,
    pitch_rad: f64,
    integrate: bool,
    params: &AttitudeParams,
    dt_s: f64,
) -> (AttitudeState, Surfaces) {
    let dt = bound(dt_s, 0.001, 0.1);
    let scaler = scaler(now, params);
    let [p, _, r] = now.rates_rad_s;

    let limit = rate_limit(params.roll_rate_max_rad_s);
    let error = wrap_pi(bank_rad - now.roll_rad);
    let demand = bound(error / bound(params.roll_tau_s, 0.05, 5.0), -limit, limit);
    let (roll, aileron) = control_rate(state.roll, demand, p, scaler, integrate, &params.roll, dt);

    let (pitch, elevator) = hold_pitch(state.pitch, now, pitch_rad, integrate, params, dt);

    // Yaw damper against what the turn itself asks, washed out at 0.2 Hz.
    let yaw_error = r - turn_rate(now, params) * bound(now.roll_rad, -1.4, 1.4).cos() * now.pitch_rad.cos();
    let yaw_rate_lag = lag(state.yaw_rate_lag, bound(yaw_error, -10.0, 10.0), 0.8, dt);
    let damper = -params.yaw_damping * (yaw_error - yaw_rate_lag) * scaler;
    let surfaces =
        Surfaces { aileron, elevator, rudder: bound(aileron * params.rudder_mix + damper / FRAC_PI_4, -1.0, 1.0) };
    (AttitudeState { roll, pitch, yaw_rate_lag }, surfaces)
}

/// The pitch axis alone: the elevator that takes the plane to a pitch.
pub(crate) fn hold_pitch(
    state: RateLoop,
    now: &Attitude,
    pitch_rad: f64,
    integrate: bool,
    params: &AttitudeParams,
    dt: f64,
) -> (RateLoop, f64) {
    // A steady turn needs q = ψ̇ sin φ cos θ with ψ̇ = g tan φ / V (Etkin and Reid, eq. 2.9): fed forward.
    let limit = rate_limit(params.pitch_rate_max_rad_s);
    let roll_used = bound(now.roll_rad, -1.4, 1.4);
    let turn_pitch = turn_rate(now, params) * roll_used.sin() * now.pitch_rad.cos() * params.turn_pitch;
    let error = bound(pitch_rad, -1.5, 1.5) - now.pitch_rad;
    let demand = bound(error / bound(params.pitch_tau_s, 0.05, 5.0) * roll_used.cos() + turn_pitch, -limit, limit);
    let [_, q, _] = now.rates_rad_s;
    control_rate(state, demand, q, scaler(now, params), integrate, &params.pitch, dt)
}

impl RateLoop {
    /// At rest with a surface held, −1 to 1.
    pub(crate) fn holding(surface: f64) -> Self {
        Self { integral: bound(surface, -1.0, 1.0) * FRAC_PI_4, rate_lag: 0.0 }
    }
}

fn airspeed(now: &Attitude, params: &AttitudeParams) -> f64 {
    let (slow, fast) = params.airspeed_range_m_s;
    bound(now.airspeed_m_s, slow.max(3.0) * 0.7, fast.max(6.0) * 1.5)
}

/// How much more the surfaces have to move than at the airspeed of the gains.
fn scaler(now: &Attitude, params: &AttitudeParams) -> f64 {
    bound(params.scaling_speed_m_s / airspeed(now, params), 0.3, 3.0)
}

/// Turn rate of a coordinated turn with this bank, rad/s.
fn turn_rate(now: &Attitude, params: &AttitudeParams) -> f64 {
    let tas = airspeed(now, params) * bound(now.eas_to_tas, 0.5, 2.0);
    GRAVITY_M_S2 * bound(now.roll_rad, -1.4, 1.4).tan() / tas
}

fn rate_limit(value: f64) -> f64 {
    if value > 0.0 { value.min(20.0) } else { 20.0 }
}

fn control_rate(
    state: RateLoop,
    demand: f64,
    rate: f64,
    scaler: f64,
    integrate: bool,
    gains: &RateGains,
    dt: f64,
) -> (RateLoop, f64) {
    let rate = bound(rate, -20.0, 20.0);
    let error = demand - rate;
    // 12 Hz, as RLL_RATE_FLTD.
    let rate_lag = lag(state.rate_lag, rate, 0.013, dt);
    let feedback = scaler * scaler;
    let limit = bound(gains.integral_max, 0.0, 1.0);
    let mut integral = bound(state.integral, -limit, limit);
    let derivative = -(rate_lag - state.rate_lag) / dt;
    let sum = gains.ff * demand * scaler + (gains.p * error + gains.d * derivative) * feedback + integral;
    let output = sum / FRAC_PI_4;
    let pushes_out = (output > 1.0 && error > 0.0) || (output < -1.0 && error < 0.0);
    if !integrate {
        integral = lag(integral, 0.0, 1.0, dt);
    } else if !pushes_out {
        integral = bound(integral + gains.i * error * feedback * dt, -limit, limit);
    }
    (RateLoop { integral, rate_lag }, bound(output, -1.0, 1.0))
}
