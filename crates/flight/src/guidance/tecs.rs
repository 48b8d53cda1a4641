//! Total energy control of height and speed: throttle from the total energy, pitch from its distribution.
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
//! The law is ArduPlane's form of it (`AP_TECS` of ArduPilot 4.7), so that a plane flown by it zooms, lags and
//! overshoots as one flown by ArduPlane does: demands for height and speed are limited in rate and smoothed; the error
//! of E and Ė moves the throttle around what level flight needs, the error of B and Ḃ the pitch, each with an
//! integrator that stops where its output is at its limit. Parameters carry ArduPlane's names and defaults.

mod terms;

pub use terms::{Demand, Energy, Phase, TecsOutput, TecsParams};

use super::{GRAVITY_M_S2, bound, lag};

/// Memory of the controller. `None` before the first step: it then starts from what is measured, without a jump.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct TecsState {
    memory: Option<Memory>,
    throttle: Option<f64>,
}

impl TecsState {
    /// A fresh state that takes over from a throttle set by other means.
    pub fn taking_over(throttle: f64) -> Self {
        Self { memory: None, throttle: Some(throttle) }
    }
}

/// State of the law between two steps.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Memory {
    /// Demand of height as it came, and as it was passed on, m.
    asked_m: f64,
    /// After the limit of its rate, m.
    limited_m: f64,
    /// After the lag, m.
    lagged_m: f64,
    /// Last height demand, m.
    height_m: f64,
    /// Parts of the climb and sink limits that are left while the plane cannot follow, 0 to 1.
    climb_part: f64,
    sink_part: f64,
    /// Demand of true airspeed after the limit of its rate, m/s, and the slow part of that rate.
    speed_m_s: f64,
    speed_rate_slow: f64,
    /// Slow part of the measured change of speed, m/s².
    accel_slow: f64,
    /// Fastest true airspeed that is asked for now, m/s.
    speed_max_m_s: f64,
    energy_rate_error: f64,
    throttle: f64,
    throttle_slewed: f64,
    throttle_integral: f64,
    throttle_clip: Clip,
    pitch_rad: f64,
    pitch_unlimited_rad: f64,
    balance_integral: f64,
    speed_integral: f64,
    balance_clip: Clip,
    pitch_demand_slow: f64,
    pitch_slow: f64,
    /// Time that it has been too slow, s.
    underspeed_s: Option<f64>,
    sinks_badly: bool,
    flare: Option<Flare>,
}

/// A flare from its first step on.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Flare {
    climb_m_s: f64,
    /// Height profile from the demanded height, and from the measured one, m.
    from_demand_m: f64,
    from_height_m: f64,
}

/// Where an output stands at its limit.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Clip {
    Low,
    No,
    High,
}

impl Clip {
    fn of(value: f64, low: f64, high: f64) -> Self {
        if value > high {
            Self::High
        } else if value < low {
            Self::Low
        } else {
            Self::No
        }
    }
}

impl Memory {
    /// At rest around what is measured.
    fn new(now: &Energy, speed_m_s: f64, throttle: f64, throttle_trim: f64) -> Self {
        Self {
            asked_m: now.height_m,
            limited_m: now.height_m,
            lagged_m: now.height_m,
            height_m: now.height_m,
            climb_part: 1.0,
            sink_part: 1.0,
            speed_m_s,
            speed_rate_slow: 0.0,
            accel_slow: now.accel_m_s2,
            speed_max_m_s: f64::INFINITY,
            energy_rate_error: 0.0,
            throttle,
            throttle_slewed: throttle_trim,
            throttle_integral: 0.0,
            throttle_clip: Clip::No,
            pitch_rad: now.pitch_rad,
            pitch_unlimited_rad: now.pitch_rad,
            balance_integral: 0.0,
            speed_integral: 0.0,
            balance_clip: Clip::No,
            pitch_demand_slow: now.pitch_rad,
            pitch_slow: now.pitch_rad,
            underspeed_s: None,
            sinks_badly: false,
            flare: None,
        }
    }
}

/// Limits and weights of one step.
struct Limits {
    dt: f64,
    tau: f64,
    climb_m_s: f64,
    sink_m_s: f64,
    /// Specific energy rates at most and least throttle, m²/s³.
    rate_max: f64,
    rate_min: f64,
    speed_min: f64,
    pitch_min: f64,
    pitch_max: f64,
    throttle_min: f64,
    throttle_max: f64,
    integrator: f64,
}

/// One step of the energy controller; `dt_s` 0.001 to 0.1 s.
pub fn manage(
    state: TecsState,
    now: &Energy,
    demand: &Demand,
    params: &TecsParams,
    dt_s: f64,
) -> (TecsState, TecsOutput) {
    let dt = bound(dt_s, 0.001, 0.1);
    let ratio = bound(now.eas_to_tas, 0.5, 2.0);
    let speed = (now.airspeed_m_s.max(3.0) * ratio).min(200.0);
    let mut memory = state.memory.unwrap_or_else(|| {
        let throttle = bound(state.throttle.unwrap_or(params.throttle_trim), 0.0, 1.0);
        Memory::new(now, speed, throttle, bound(params.throttle_trim, 0.0, 1.0))
    });
    let lands = matches!(demand.phase, Phase::Approach { .. } | Phase::Flare { .. });
    let throttle_before = memory.throttle;
    let pitch_min = bound(demand.pitch_min_rad, -1.5, 1.5);
    let throttle_min = bound(demand.throttle_min, 0.0, 1.0);
    let climb_max = bound(params.climb_max_m_s, 0.1, 50.0) * memory.climb_part;
    let limits = Limits {
        dt,
        tau: bound(if lands { params.land_time_constant_s } else { params.time_constant_s }, 0.1, 30.0),
        climb_m_s: climb_max,
        sink_m_s: if lands && params.land_sink_max_m_s > 0.0 {
            bound(params.land_sink_max_m_s, 0.1, 50.0)
        } else {
            bound(params.sink_max_m_s, 0.1, 50.0) * memory.sink_part
        },
        rate_max: climb_max.max(0.01) * GRAVITY_M_S2,
        rate_min: -bound(params.sink_min_m_s, 0.1, 50.0) * GRAVITY_M_S2,
        // Stall prevention: lift has to carry the load of the bank.
        speed_min: params.airspeed_min_m_s.max(1.0) * ratio / now.roll_rad.cos().clamp(0.09, 1.0).sqrt(),
        pitch_min,
        pitch_max: bound(demand.pitch_max_rad, pitch_min, 1.5),
        throttle_min,
        throttle_max: bound(demand.throttle_max, throttle_min, 1.0),
        integrator: match demand.phase {
            Phase::Climbout => params.climbout_integrator_gain_per_s,
            _ if lands && params.land_integrator_gain_per_s > 0.0 => params.land_integrator_gain_per_s,
            _ => params.integrator_gain_per_s,
        },
    };
    let accel = bound(now.accel_m_s2, -20.0, 20.0);
    memory.accel_slow = lag(memory.accel_slow, accel, limits.tau, dt);

    let speed_rate = memory.ask_speed(speed, ratio, demand, params, &limits);
    let climb = memory.ask_height(now, demand, params, &limits);
    let is_slow = memory.watch_speed(speed, now, demand, &limits);

    // Energies: what is asked for, what is there, and their rates; the slow part of a measured change of speed is its
    // error.
    let potential = GRAVITY_M_S2 * (memory.height_m - now.height_m);
    let kinetic = 0.5 * (memory.speed_m_s * memory.speed_m_s - speed * speed);
    let potential_rate = GRAVITY_M_S2 * now.climb_m_s;
    let kinetic_rate = speed * (accel - memory.accel_slow);
    let kinetic_rate_asked = speed * (speed_rate - memory.speed_rate_slow);
    let rates = Rates { speed, potential, kinetic, potential_rate, kinetic_rate, kinetic_rate_asked, climb };

    memory.ask_pitch(&rates, demand, params, &limits);
    if params.has_airspeed {
        memory.ask_throttle(now, &rates, demand, params, &limits);
    } else {
        memory.throttle_by_pitch(now, params, &limits);
    }
    if params.throttle_slew_per_s > 0.0 {
        // The servo's own limit, in addition to that of the demand.
        let step = params.throttle_slew_per_s * dt;
        memory.throttle = bound(memory.throttle, throttle_before - step, throttle_before + step);
    }
    let output = TecsOutput {
        throttle: memory.throttle,
        pitch_rad: memory.pitch_rad,
        height_demand_m: memory.height_m,
        airspeed_demand_m_s: memory.speed_m_s / ratio,
        underspeed: is_slow,
    };
    (TecsState { memory: Some(memory), throttle: None }, output)
}

/// Errors of the specific energies (asked minus there), m²/s², and their rates, m²/s³.
struct Rates {
    /// True airspeed, m/s.
    speed: f64,
    potential: f64,
    kinetic: f64,
    potential_rate: f64,
    kinetic_rate: f64,
    kinetic_rate_asked: f64,
    /// Climb that the height demand itself has, m/s.
    climb: f64,
}

impl Memory {
    /// Demand of true airspeed; answers with its rate, m/s².
    fn ask_speed(&mut self, speed: f64, ratio: f64, demand: &Demand, params: &TecsParams, limits: &Limits) -> f64 {
        let fastest = (params.airspeed_max_m_s.max(params.airspeed_min_m_s) * ratio).max(limits.speed_min);
        let cruise = params.airspeed_cruise_m_s.max(1.0) * ratio;
        // Half of the energy is left to the height; a plane that cannot climb at full throttle is asked to fly slower.
        let gain = 0.5 * limits.rate_max / speed.max(limits.speed_min);
        let loss = 0.5 * limits.rate_min / speed.max(limits.speed_min);
        self.speed_max_m_s = match self.throttle_clip {
            Clip::High => (self.speed_max_m_s + limits.dt * loss).max(cruise),
            _ => self.speed_max_m_s + limits.dt * gain,
        };
        self.speed_max_m_s = self.speed_max_m_s.min(fastest).max(limits.speed_min);
        if matches!(demand.phase, Phase::Climbout) {
            self.speed_m_s = bound(demand.airspeed_m_s * ratio, limits.speed_min, self.speed_max_m_s);
        }
        let asked = if self.sinks_badly || self.underspeed_s.is_some() { 0.0 } else { demand.airspeed_m_s * ratio };
        let asked = bound(asked, limits.speed_min, self.speed_max_m_s);
        let fastest_gain = 0.5 * limits.rate_max / speed;
        let at_max = -0.9 * bound(params.sink_max_m_s, 0.1, 50.0) * GRAVITY_M_S2 / self.speed_max_m_s;
        let at_cruise = 0.9 * limits.rate_min / cruise;
        let part = if self.speed_max_m_s > cruise { (speed - cruise) / (self.speed_max_m_s - cruise) } else { 0.0 };
        let fastest_loss = at_cruise + (at_max - at_cruise) * bound(part, 0.0, 1.0);
        let rate = bound((asked - self.speed_m_s) / limits.dt, fastest_loss, fastest_gain);
        self.speed_m_s = bound(self.speed_m_s + rate * limits.dt, limits.speed_min, self.speed_max_m_s);
        self.speed_rate_slow = lag(self.speed_rate_slow, rate, limits.tau, limits.dt);
        rate
    }

    /// Demand of height; answers with its climb, m/s.
    fn ask_height(&mut self, now: &Energy, demand: &Demand, params: &TecsParams, limits: &Limits) -> f64 {
        let dt = limits.dt;
        let lag_s = bound(params.height_demand_tau_s, dt, 20.0);
        match demand.phase {
            Phase::Climbout => {
                // The climb is not controlled here; afterwards the demand starts from it.
                *self = Self {
                    asked_m: now.height_m,
                    limited_m: now.height_m,
                    lagged_m: now.height_m,
                    height_m: now.height_m,
                    climb_part: 1.0,
                    sink_part: 1.0,
                    flare: None,
                    ..*self
                };
                0.0
            }
            Phase::Flare { height_m, start_height_m, start_sink_m_s } => {
                self.asked_m = now.height_m;
                self.limited_m = now.height_m;
                self.lagged_m = now.height_m;
                let mut flare = self.flare.unwrap_or(Flare {
                    climb_m_s: -start_sink_m_s,
                    from_demand_m: self.height_m - now.height_m + height_m,
                    from_height_m: height_m,
                });
                let hold = params.flare_hold_height_m;
                let part = if start_height_m > hold {
                    bound((start_height_m - height_m) / (start_height_m - hold), 0.0, 1.0)
                } else {
                    1.0
                };
                let climb = flare.climb_m_s * (1.0 - part) - bound(params.land_sink_m_s, 0.0, 5.0) * part;
                flare.from_demand_m += climb * dt;
                flare.from_height_m += climb * dt;
                self.flare = Some(flare);
                self.height_m =
                    flare.from_demand_m * (1.0 - part) + flare.from_height_m * part + now.height_m - height_m;
                climb
            }
            Phase::Cruise | Phase::Approach { .. } => {
                self.flare = None;
                // What cannot be followed is not asked for yet.
                let cannot_climb = self.pitch_unlimited_rad > limits.pitch_max || self.throttle_clip == Clip::High;
                let cannot_sink = self.pitch_unlimited_rad < limits.pitch_min || self.throttle_clip == Clip::Low;
                let before = self.asked_m;
                let held = (cannot_climb && demand.height_m > before) || (cannot_sink && demand.height_m < before);
                let asked = if held { before } else { demand.height_m };
                self.asked_m = asked;
                let wanted = 0.5 * (asked + before);
                self.limited_m =
                    bound(wanted, self.limited_m - limits.sink_m_s * dt, self.limited_m + limits.climb_m_s * dt);
                let climb = (self.limited_m - self.lagged_m) / lag_s;
                self.lagged_m = lag(self.lagged_m, self.limited_m, lag_s, dt);
                let previous = self.height_m;
                self.height_m = self.lagged_m;
                if matches!(demand.phase, Phase::Approach { .. }) {
                    self.height_m += lag_s * climb;
                } else {
                    let cannot_climb = cannot_climb || self.balance_clip == Clip::High;
                    let cannot_sink = cannot_sink || self.balance_clip == Clip::Low;
                    let part = dt / (dt + lag_s);
                    if cannot_climb && self.height_m > previous {
                        self.climb_part *= 1.0 - part;
                    } else if cannot_sink && self.height_m < previous {
                        self.sink_part *= 1.0 - part;
                    } else {
                        self.climb_part += (1.0 - self.climb_part) * part;
                        self.sink_part += (1.0 - self.sink_part) * part;
                    }
                }
                climb
            }
        }
    }

    /// Whether the plane is too slow: at full throttle below 0.9 of the slowest speed, until it is 15 % above for three
    /// seconds or has its height.
    fn watch_speed(&mut self, speed: f64, now: &Energy, demand: &Demand, limits: &Limits) -> bool {
        let is_too_slow = speed < 0.9 * limits.speed_min;
        let flares = matches!(demand.phase, Phase::Flare { .. });
        self.underspeed_s = match self.underspeed_s {
            _ if matches!(demand.phase, Phase::Climbout) => None,
            Some(since) if speed >= 1.15 * limits.speed_min && since > 3.0 => None,
            _ if is_too_slow && self.throttle >= 0.95 * limits.throttle_max && !flares => Some(0.0),
            Some(since) if now.height_m < self.height_m => Some(since + limits.dt),
            _ => None,
        };
        self.underspeed_s.is_some()
    }

    fn ask_throttle(&mut self, now: &Energy, rates: &Rates, demand: &Demand, params: &TecsParams, limits: &Limits) {
        let (speed, is_slow) = (rates.speed, self.underspeed_s.is_some());
        let dt = limits.dt;
        // No error of height that would cost or bring more speed than is allowed.
        let most = (0.5 * (speed * speed - limits.speed_min * limits.speed_min)).max(0.0);
        let least = (0.5 * (speed * speed - self.speed_max_m_s * self.speed_max_m_s)).min(0.0);
        let error = bound(rates.potential, least, most) + rates.kinetic;
        let rate_asked =
            bound(rates.potential / limits.tau + rates.kinetic_rate_asked, limits.rate_min, limits.rate_max);
        let rate_error = rate_asked - rates.potential_rate - rates.kinetic_rate;
        // Half a second against the noise of the measured rates.
        self.energy_rate_error += (2.0 * dt).min(1.0) * (rate_error - self.energy_rate_error);
        let range = (limits.throttle_max - limits.throttle_min).max(0.01);
        let per_throttle = (limits.rate_max - limits.rate_min) / range;
        let gain = 1.0 / (limits.tau * per_throttle);
        let cos = now.roll_rad.cos();
        // Induced drag grows with the square of the load factor 1/cos φ.
        let turn = params.roll_compensation_m_s * (1.0 / bound(cos * cos, 0.1, 1.0) - 1.0);
        let lands = matches!(demand.phase, Phase::Approach { .. } | Phase::Flare { .. });
        let damping = if lands && params.land_throttle_damping > 0.0 {
            params.land_throttle_damping
        } else {
            params.throttle_damping
        };
        let ahead = params.throttle_trim + (rate_asked + turn) / per_throttle;
        let mut throttle = (error + self.energy_rate_error * damping) * gain + ahead;
        // The integrator may drive the throttle to its limit and a tenth beyond, for noise.
        let span = 0.5 * (limits.throttle_max - limits.throttle_min);
        let highest = bound(limits.throttle_max - throttle + 0.1, -span, span);
        let lowest = bound(limits.throttle_min - throttle - 0.1, -span, span);
        self.throttle_integral += error * limits.integrator * dt * gain;
        if !matches!(demand.phase, Phase::Climbout) {
            self.throttle_integral = bound(self.throttle_integral, lowest.min(highest), highest.max(lowest));
        }
        if params.throttle_slew_per_s > 0.0 {
            let step = params.throttle_slew_per_s * range * dt;
            throttle = bound(throttle, self.throttle_slewed - step, self.throttle_slewed + step);
            self.throttle_slewed = throttle;
        }
        throttle += self.throttle_integral;
        match demand.phase {
            Phase::Flare { .. } => throttle = limits.throttle_min,
            Phase::Climbout => throttle = limits.throttle_max,
            _ if is_slow => throttle = limits.throttle_max,
            _ => {}
        }
        self.sinks_badly = !is_slow
            && (error > 200.0
                && rates.potential_rate + rates.kinetic_rate < 0.0
                && throttle >= 0.9 * limits.throttle_max
                || self.sinks_badly && error > 0.0);
        self.throttle_clip = Clip::of(throttle, limits.throttle_min, limits.throttle_max);
        self.throttle = bound(throttle, limits.throttle_min, limits.throttle_max);
    }

    /// Without a measured airspeed the pitch that is asked for and flown gives the throttle.
    fn throttle_by_pitch(&mut self, now: &Energy, params: &TecsParams, limits: &Limits) {
        let dt = limits.dt;
        self.pitch_demand_slow = lag(self.pitch_demand_slow, self.pitch_rad, limits.tau, dt);
        self.pitch_slow = lag(self.pitch_slow, now.pitch_rad, limits.tau, dt);
        let pitch = self.pitch_rad - self.pitch_demand_slow + self.pitch_slow;
        let trim = params.throttle_trim;
        let mut throttle = if pitch > 0.0 && limits.pitch_max > 0.0 {
            trim + (limits.throttle_max - trim) * pitch / limits.pitch_max
        } else if pitch < 0.0 && limits.pitch_min < 0.0 {
            trim + (limits.throttle_min - trim) * pitch / limits.pitch_min
        } else {
            trim
        };
        let cos = now.roll_rad.cos();
        let turn = params.roll_compensation_m_s * (1.0 / bound(cos * cos, 0.1, 1.0) - 1.0);
        throttle += turn / (limits.rate_max - limits.rate_min) * (limits.throttle_max - limits.throttle_min);
        self.throttle_clip = Clip::No;
        self.throttle = bound(throttle, limits.throttle_min, limits.throttle_max);
    }

    fn ask_pitch(&mut self, rates: &Rates, demand: &Demand, params: &TecsParams, limits: &Limits) {
        let (speed, is_slow) = (rates.speed, self.underspeed_s.is_some());
        let dt = limits.dt;
        let weight = match demand.phase {
            _ if !params.has_airspeed => 0.0,
            _ if is_slow => 2.0,
            Phase::Climbout => 2.0,
            Phase::Approach { proportion } if params.land_speed_weight < 0.0 => {
                params.speed_weight * (1.0 - bound(proportion, 0.0, 1.0))
            }
            Phase::Flare { .. } if params.land_speed_weight < 0.0 => 0.0,
            Phase::Approach { .. } | Phase::Flare { .. } => params.land_speed_weight,
            Phase::Cruise => params.speed_weight,
        };
        let for_speed = bound(weight, 0.0, 1.0);
        let for_height = bound(2.0 - weight, 0.0, 1.0);
        let per_radian = speed * GRAVITY_M_S2;

        let error = rates.potential * for_height - rates.kinetic * for_speed;
        let asked = rates.climb * GRAVITY_M_S2 * for_height + error / limits.tau;
        let least = -bound(params.sink_max_m_s, 0.1, 50.0) * GRAVITY_M_S2;
        let most = bound(params.climb_max_m_s, 0.1, 50.0) * GRAVITY_M_S2;
        self.balance_clip = Clip::of(asked, least, most);
        let asked = bound(asked, least, most);
        let rate_error = asked - (rates.potential_rate * for_height - rates.kinetic_rate * for_speed);
        let damping = match demand.phase {
            Phase::Flare { .. } => params.land_pitch_damping,
            Phase::Approach { .. } if params.approach_pitch_damping > 0.0 => params.approach_pitch_damping,
            _ => params.pitch_damping,
        };
        let mut total = asked + rate_error * damping;
        if matches!(demand.phase, Phase::Climbout) {
            // No speed error asks for the least pitch of the climb.
            total += limits.pitch_min * per_radian;
        }
        // The integrator may drive the pitch five degrees beyond its limits, for gusts.
        let beyond = 5_f64.to_radians();
        let low = per_radian * (limits.pitch_min - beyond) - total;
        let high = per_radian * (limits.pitch_max + beyond) - total;
        let step = bound(rate_error * limits.integrator * dt, -0.1 * (high - low), 0.1 * (high - low));
        self.pitch_unlimited_rad = (total + self.balance_integral + step + self.speed_integral) / per_radian;
        let pushes_out = (self.pitch_unlimited_rad > limits.pitch_max && step > 0.0)
            || (self.pitch_unlimited_rad < limits.pitch_min && step < 0.0);
        if pushes_out {
            let keep = 1.0 - dt / (dt + limits.tau);
            self.balance_integral *= keep;
            self.speed_integral *= keep;
        } else {
            self.balance_integral += step;
            self.speed_integral -= rates.kinetic * for_speed * dt / limits.tau;
        }
        self.balance_integral = bound(self.balance_integral, low, high);
        let quarter = 0.25 * (limits.pitch_max - limits.pitch_min) * per_radian;
        self.speed_integral = bound(self.speed_integral, -quarter, quarter);
        self.pitch_unlimited_rad = (total + self.balance_integral + self.speed_integral) / per_radian;
        let pitch = bound(self.pitch_unlimited_rad, limits.pitch_min, limits.pitch_max);
        // V θ̇ is the vertical acceleration.
        let turn = bound(params.vertical_accel_max_m_s2, 0.5, 50.0) / speed * dt;
        let pitch = bound(pitch, self.pitch_rad - turn, self.pitch_rad + turn);
        self.pitch_rad = bound(pitch, limits.pitch_min, limits.pitch_max);
    }
}
