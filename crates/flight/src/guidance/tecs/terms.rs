//! Inputs and outputs of the energy controller.

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
    /// Pitch damping of the flare; 0.1 to 1, default 0.5 (`TECS_LAND_DAMP`).
    pub land_pitch_damping: f64,
    /// Extra energy rate of a 45° bank, m/s of climb equivalent; 5 to 30, default 10 (`TECS_RLL2THR`).
    pub roll_compensation_m_s: f64,
    /// Vertical acceleration limit of height corrections, m/s²; 1 to 10, default 7 (`TECS_VERT_ACC`).
    pub vertical_accel_max_m_s2: f64,
    /// Lag of the height demand, s; 1 to 5, default 3 (`TECS_HDEM_TCONST`).
    pub height_demand_tau_s: f64,
    /// Sink rate wanted at touchdown, m/s; 0 to 2, default 0.25 (`TECS_LAND_SINK`).
    pub land_sink_m_s: f64,
    /// Height below which the flare asks for that sink rate, m; default 1 (`TECS_FLARE_HGT`).
    pub flare_hold_height_m: f64,
    /// Integrator gain in a full-throttle climb, 1/s; default 0 (`TECS_TKOFF_IGAIN`).
    pub climbout_integrator_gain_per_s: f64,
    /// Integrator gain in landing, 1/s; default 0, as in flight (`TECS_LAND_IGAIN`).
    pub land_integrator_gain_per_s: f64,
    /// Sink rate never to exceed in landing, m/s; default 0, as in flight (`TECS_APPR_SMAX`).
    pub land_sink_max_m_s: f64,
    /// Damping of the throttle in landing; default 0, as in flight (`TECS_LAND_TDAMP`).
    pub land_throttle_damping: f64,
    /// Damping of the pitch on the approach; default 0, as in flight (`TECS_LAND_PDAMP`).
    pub approach_pitch_damping: f64,
    /// Whether the airspeed is measured; without, pitch looks after the height alone and throttle follows the pitch.
    /// Default yes.
    pub has_airspeed: bool,
    /// Throttle of level flight at cruise speed, 0 to 1, default 0.5 (`TRIM_THROTTLE`).
    pub throttle_trim: f64,
    /// Slew limit of the throttle, 1/s; 0: no limit; default 1 (`THR_SLEWRATE`).
    pub throttle_slew_per_s: f64,
    /// Cruise airspeed, m/s EAS; 5 to 100, default 22 (`AIRSPEED_CRUISE`).
    pub airspeed_cruise_m_s: f64,
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
            flare_hold_height_m: 1.0,
            climbout_integrator_gain_per_s: 0.0,
            land_integrator_gain_per_s: 0.0,
            land_sink_max_m_s: 0.0,
            land_throttle_damping: 0.0,
            approach_pitch_damping: 0.0,
            has_airspeed: true,
            throttle_trim: 0.5,
            throttle_slew_per_s: 1.0,
            airspeed_cruise_m_s: 22.0,
            airspeed_min_m_s: 10.0,
            airspeed_max_m_s: 30.0,
        }
    }
}

/// Phase of flight, as the energy law distinguishes them.
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

/// Demands.
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

/// Measurements.
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
