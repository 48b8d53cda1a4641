//! Total energy control of height and speed: throttle from the total energy rate, pitch from its distribution.
//!
//! After A. A. Lambregts, *Vertical Flight Path and Speed Control Autopilot Design Using Total Energy Principles*,
//! AIAA 83-2239 (1983). Per unit of mass the specific total energy is `E = g h + V²/2` and the specific energy balance
//! `B = g h − V²/2`, so that
//!
//! ```text
//! Ė = g ḣ + V V̇      (his eq. 3: thrust minus drag makes it)
//! Ḃ = g ḣ − V V̇      (elevator exchanges one for the other)
//! ```
//!
//! Height and speed errors become demands for ḣ and V̇ through one time constant; throttle answers for Ė, pitch for Ḃ,
//! each with feed-forward, damping and an integrator. Parameters carry ArduPlane's names and defaults.

use super::{GRAVITY_M_S2, bound, lag};

/// Parameters of the energy controller.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TecsParams {
    /// Time constant of height and speed errors, s; 3 to 10, default 5 (`TECS_TIME_CONST`).
    pub time_constant_s: f64,
    /// The same in landing, s; 1 to 5, default 2 (`TECS_LAND_TCONST`).
    pub land_time_constant_s: f64,
    /// Climb rate at full throttle, m/s; 0.1 to 20, default 5 (`TECS_CLMB_MAX`).
    pub climb_max_m_s: f64,
    /// Sink rate at least throttle and cruise speed, m/s; 0.1 to 10, default 2 (`TECS_SINK_MIN`).
    pub sink_min_m_s: f64,
    /// Sink rate never to exceed, m/s; 0 to 20, default 5 (`TECS_SINK_MAX`).
    pub sink_max_m_s: f64,
    /// Whether pitch looks after height (0), speed (2) or both (1); default 1 (`TECS_SPDWEIGHT`).
    pub speed_weight: f64,
    /// The same in landing; −1 goes from `speed_weight` to 0 along the approach; default −1 (`TECS_LAND_SPDWGT`).
    pub land_speed_weight: f64,
    /// Integrator gain, 1/s; 0 to 0.5, default 0.3 (`TECS_INTEG_GAIN`).
    pub integrator_gain_per_s: f64,
    /// Throttle damping; 0.1 to 1, default 0.5 (`TECS_THR_DAMP`).
    pub throttle_damping: f64,
    /// Pitch damping; 0.1 to 1, default 0.3 (`TECS_PTCH_DAMP`).
    pub pitch_damping: f64,
    /// Pitch damping in landing; 0.1 to 1, default 0.5 (`TECS_LAND_DAMP`).
    pub land_pitch_damping: f64,
    /// Extra energy rate of a 45° bank, m/s of climb equivalent; 5 to 30, default 10 (`TECS_RLL2THR`).
    pub roll_compensation_m_s: f64,
    /// Vertical acceleration limit of height corrections, m/s²; 1 to 10, default 7 (`TECS_VERT_ACC`).
    pub vertical_accel_max_m_s2: f64,
    /// Smoothing of the height demand, s; 1 to 5, default 3 (`TECS_HDEM_TCONST`).
    pub height_demand_tau_s: f64,
    /// Sink rate wanted at touchdown, m/s; 0 to 2, default 0.25 (`TECS_LAND_SINK`).
    pub land_sink_m_s: f64,
    /// Throttle of level flight at cruise speed, 0 to 1, default 0.5 (`TRIM_THROTTLE`).
    pub throttle_trim: f64,
    /// Slew limit of the throttle, 1/s; 0 is none, default 1 (`THR_SLEWRATE`).
    pub throttle_slew_per_s: f64,
    /// Slowest airspeed, m/s EAS; 5 to 100, default 10 (`AIRSPEED_MIN`).
    pub airspeed_min_m_s: f64,
    /// Fastest airspeed, m/s EAS; 5 to 100, default 30 (`AIRSPEED_MAX`).
    pub airspeed_max_m_s: f64,
}

impl Default for TecsParams {
    fn default() -> Self {
        Self {
            time_constant_s: 5.0,
            land_time_constant_s: 2.0,
            climb_max_m_s: 5.0,
            sink_min_m_s: 2.0,
            sink_max_m_s: 5.0,
            speed_weight: 1.0,
            land_speed_weight: -1.0,
            integrator_gain_per_s: 0.3,
            throttle_damping: 0.5,
            pitch_damping: 0.3,
            land_pitch_damping: 0.5,
            roll_compensation_m_s: 10.0,
            vertical_accel_max_m_s2: 7.0,
            height_demand_tau_s: 3.0,
            land_sink_m_s: 0.25,
            throttle_trim: 0.5,
            throttle_slew_per_s: 1.0,
            airspeed_min_m_s: 10.0,
            airspeed_max_m_s: 30.0,
        }
    }
}

/// What the flight is doing, as far as energy is concerned.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub enum Phase {
    /// Climb, cruise and descent.
    #[default]
    Cruise,
    /// Full-throttle climb: pitch looks after the speed, and stays above `pitch_min`.
    Climbout,
    /// Final approach: the faster time constant, and the weight moving to height.
    Approach {
        /// Part of the final leg that is flown, 0 to 1.
        proportion: f64,
    },
    /// Round-out over the runway: a sink rate that fades with height, throttle closed.
    Flare {
        /// Height over the runway now, m.
        height_m: f64,
        /// Height where the flare began, m.
        start_height_m: f64,
        /// Sink rate when the flare began, m/s, positive down.
        start_sink_m_s: f64,
    },
}

/// What is wanted.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Demand {
    /// Height, m (same zero as the measured height).
    pub height_m: f64,
    /// Airspeed, m/s EAS.
    pub airspeed_m_s: f64,
    /// Phase of the flight.
    pub phase: Phase,
    /// Lowest pitch allowed, rad.
    pub pitch_min_rad: f64,
    /// Highest pitch allowed, rad.
    pub pitch_max_rad: f64,
    /// Least throttle, 0 to 1.
    pub throttle_min: f64,
    /// Most throttle, 0 to 1.
    pub throttle_max: f64,
}

/// What is measured.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Energy {
    /// Height, m.
    pub height_m: f64,
    /// Climb rate, m/s.
    pub climb_m_s: f64,
    /// Airspeed, m/s EAS.
    pub airspeed_m_s: f64,
    /// True over equivalent airspeed, √(ρ₀/ρ).
    pub eas_to_tas: f64,
    /// Change of speed along the body's forward axis without gravity's part, m/s².
    pub accel_m_s2: f64,
    /// Bank, rad.
    pub roll_rad: f64,
    /// Pitch, rad.
    pub pitch_rad: f64,
}

/// Memory of the controller. `None` before the first step: it then starts from what is measured, without a jump.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct TecsState {
    memory: Option<Memory>,
    throttle: Option<f64>,
}

impl TecsState {
    /// A fresh state that takes over from a throttle set by other means.
    #[must_use]
    pub fn taking_over(throttle: f64) -> Self {
        Self { memory: None, throttle: Some(throttle) }
    }
}

#[derive(Debug, Clone, Copy, PartialEq)]
struct Memory {
    target_m: f64,
    slope_m_s: f64,
    path_m: f64,
    path_rate_m_s: f64,
    accel_m_s2: f64,
    energy_rate: f64,
    throttle: f64,
    throttle_integral: f64,
    pitch_rad: f64,
    pitch_integral_rad: f64,
}

/// Answer of the controller.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct TecsOutput {
    /// Throttle, 0 to 1.
    pub throttle: f64,
    /// Pitch demand, rad.
    pub pitch_rad: f64,
    /// Height demand after smoothing, m.
    pub height_demand_m: f64,
    /// Airspeed demand after limits, m/s EAS.
    pub airspeed_demand_m_s: f64,
    /// True while the plane is too slow and everything goes into speed.
    pub underspeed: bool,
}

/// One step of the energy controller; `dt_s` 0.001 to 0.1 s.
#[must_use]
pub fn manage(
    state: TecsState,
    now: &Energy,
    demand: &Demand,
    params: &TecsParams,
    dt_s: f64,
) -> (TecsState, TecsOutput) {
    let dt = bound(dt_s, 0.001, 0.1);
    let g = GRAVITY_M_S2;
    let speed = (now.airspeed_m_s.max(3.0) * bound(now.eas_to_tas, 0.5, 2.0)).min(200.0);
    let climb_max = bound(params.climb_max_m_s, 0.1, 50.0);
    let sink_max = bound(params.sink_max_m_s, 0.1, 50.0);
    let sink_min = bound(params.sink_min_m_s, 0.1, 50.0);
    let mut memory = state.memory.unwrap_or(Memory {
        target_m: now.height_m,
        slope_m_s: 0.0,
        path_m: now.height_m,
        path_rate_m_s: now.climb_m_s,
        accel_m_s2: 0.0,
        energy_rate: 0.0,
        throttle: bound(state.throttle.unwrap_or(params.throttle_trim), 0.0, 1.0),
        throttle_integral: 0.0,
        pitch_rad: now.pitch_rad,
        pitch_integral_rad: now.pitch_rad - (now.climb_m_s / speed).clamp(-0.5, 0.5),
    });

    // Height demand: rate-limited, then a smooth path of height and rate that meets it.
    let before = memory.target_m;
    let tau_h = bound(params.height_demand_tau_s, 0.1, 20.0);
    if matches!(demand.phase, Phase::Climbout) {
        // The climb is as it is; the path goes with it and starts from there afterwards.
        memory.target_m = now.height_m;
        memory.slope_m_s = 0.0;
        memory.path_m = now.height_m;
        memory.path_rate_m_s = now.climb_m_s;
    } else {
        memory.target_m = bound(demand.height_m, before - sink_max * dt, before + climb_max * dt);
        // A target that slides (a glide slope) is fed forward, one that jumped is caught up with.
        let slides = (demand.height_m - before).abs() < 1.0;
        let rate = if slides { (memory.target_m - before) / dt } else { 0.0 };
        memory.slope_m_s = lag(memory.slope_m_s, rate, 1.0, dt);
        let wanted = (memory.target_m - memory.path_m) / tau_h + memory.slope_m_s;
        let wanted = bound(wanted, -sink_max, climb_max);
        memory.path_rate_m_s = lag(memory.path_rate_m_s, wanted, tau_h / 4.0, dt);
        memory.path_m += memory.path_rate_m_s * dt;
    }
    let height_demand = memory.path_m;

    // Demands for ḣ and V̇.
    let (tau, damping) = match demand.phase {
        Phase::Approach { .. } | Phase::Flare { .. } => (params.land_time_constant_s, params.land_pitch_damping),
        Phase::Cruise | Phase::Climbout => (params.time_constant_s, params.pitch_damping),
    };
    let tau = bound(tau, 0.5, 30.0);
    let damping = bound(damping, 0.0, 2.0);
    let climb_demand = match demand.phase {
        Phase::Flare { height_m, start_height_m, start_sink_m_s } => {
            let left = bound(height_m / start_height_m.max(0.1), 0.0, 1.0);
            let touch = bound(params.land_sink_m_s, 0.0, 2.0);
            -(touch + (bound(start_sink_m_s, touch, sink_max.max(touch)) - touch) * left)
        }
        _ => bound((height_demand - now.height_m) / tau + memory.path_rate_m_s, -sink_max, climb_max),
    };
    let airspeed_demand =
        bound(demand.airspeed_m_s, params.airspeed_min_m_s, params.airspeed_max_m_s.max(params.airspeed_min_m_s));
    let speed_error = (airspeed_demand - now.airspeed_m_s) * bound(now.eas_to_tas, 0.5, 2.0);
    let rate_max = climb_max * g;
    let rate_min = -sink_min * g;
    let accel_demand = bound(speed_error / tau, 0.5 * rate_min / speed, 0.5 * rate_max / speed);
    memory.accel_m_s2 = lag(memory.accel_m_s2, bound(now.accel_m_s2, -20.0, 20.0), 0.25, dt);

    // Total energy → throttle.
    let energy_demand = g * climb_demand + speed * accel_demand;
    let energy_rate = g * now.climb_m_s + speed * memory.accel_m_s2;
    memory.energy_rate = lag(memory.energy_rate, energy_rate, 0.5, dt);
    let per_throttle = rate_max - rate_min;
    let energy_error = bound(energy_demand - memory.energy_rate, -per_throttle, per_throttle);
    let cos_roll = now.roll_rad.cos().abs().max(0.5);
    // Induced drag grows with the square of the load factor 1/cos φ.
    let turn_drag = params.roll_compensation_m_s * (1.0 / (cos_roll * cos_roll) - 1.0);
    let throttle_min = bound(demand.throttle_min, 0.0, 1.0);
    let throttle_max = bound(demand.throttle_max, throttle_min, 1.0);
    let underspeed = now.airspeed_m_s < 0.9 * params.airspeed_min_m_s && !matches!(demand.phase, Phase::Flare { .. });
    let open = params.throttle_trim
        + (energy_demand + turn_drag) / per_throttle
        + params.throttle_damping * energy_error / per_throttle;
    let wanted = open + memory.throttle_integral;
    let mut throttle = bound(wanted, throttle_min, throttle_max);
    let pushes_out = (wanted > throttle_max && energy_error > 0.0) || (wanted < throttle_min && energy_error < 0.0);
    if matches!(demand.phase, Phase::Cruise | Phase::Approach { .. }) && !pushes_out && !underspeed {
        memory.throttle_integral = bound(
            memory.throttle_integral + params.integrator_gain_per_s * energy_error / per_throttle * dt * 0.5,
            -0.6,
            0.6,
        );
    }
    if underspeed {
        throttle = throttle_max;
    }
    if matches!(demand.phase, Phase::Climbout) {
        throttle = throttle_max;
    }
    if params.throttle_slew_per_s > 0.0 {
        let step = params.throttle_slew_per_s * dt;
        throttle = bound(throttle, memory.throttle - step, memory.throttle + step);
    }
    if matches!(demand.phase, Phase::Flare { .. }) {
        throttle = throttle_min;
    }
    memory.throttle = bound(throttle, throttle_min, throttle_max);

    // Energy balance → pitch.
    let weight = match demand.phase {
        _ if underspeed => 2.0,
        Phase::Climbout => 2.0,
        Phase::Flare { .. } => 0.0,
        Phase::Approach { proportion } if params.land_speed_weight < 0.0 => {
            params.speed_weight * (1.0 - bound(proportion, 0.0, 1.0))
        }
        Phase::Approach { .. } => params.land_speed_weight,
        Phase::Cruise => params.speed_weight,
    };
    let kinetic = bound(weight, 0.0, 1.0);
    let potential = bound(2.0 - weight, 0.0, 1.0);
    let balance_demand = potential * g * climb_demand - kinetic * speed * accel_demand;
    let balance = potential * g * now.climb_m_s - kinetic * speed * memory.accel_m_s2;
    let balance_error = balance_demand - balance;
    let per_radian = speed * g;
    let pitch_min = bound(demand.pitch_min_rad, -1.5, 1.5);
    let pitch_max = bound(demand.pitch_max_rad, pitch_min, 1.5);
    let wanted = (balance_demand + damping * balance_error) / per_radian + memory.pitch_integral_rad;
    let pushes_out = (wanted > pitch_max && balance_error > 0.0) || (wanted < pitch_min && balance_error < 0.0);
    if !pushes_out {
        // The flare has seconds only, and the speed falling under it: its integrator is as fast as it is short.
        let gain = if matches!(demand.phase, Phase::Flare { .. }) { 4.0 } else { 1.0 };
        memory.pitch_integral_rad = bound(
            memory.pitch_integral_rad + gain * params.integrator_gain_per_s * balance_error / per_radian * dt,
            -0.35,
            0.35,
        );
    }
    let pitch = bound(wanted, pitch_min, pitch_max);
    // V θ̇ is the vertical acceleration.
    let step = bound(params.vertical_accel_max_m_s2, 0.5, 50.0) / speed * dt;
    memory.pitch_rad = bound(bound(pitch, memory.pitch_rad - step, memory.pitch_rad + step), pitch_min, pitch_max);

    let output = TecsOutput {
        throttle: memory.throttle,
        pitch_rad: memory.pitch_rad,
        height_demand_m: height_demand,
        airspeed_demand_m_s: airspeed_demand,
        underspeed,
    };
    (TecsState { memory: Some(memory), throttle: None }, output)
}
