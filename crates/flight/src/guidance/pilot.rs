//! One control step of a whole plane: L1, TECS and the attitude laws joined, from what is sensed to what moves.

use super::attitude::{self, Attitude, AttitudeParams, AttitudeState, Surfaces};
use super::l1::{self, L1Output, L1Params, L1State, Motion, Track};
use super::tecs::{self, Demand, Energy, TecsOutput, TecsParams, TecsState};
use super::{NorthEast, bound, wrap_pi};

/// The plane's sensed state.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Sensed {
    /// Position in the tangent plane, m.
    pub position: NorthEast,
    /// Height, m, over whatever zero the demands use.
    pub height_m: f64,
    /// Velocity over ground, m/s.
    pub velocity: NorthEast,
    /// Climb rate, m/s.
    pub climb_m_s: f64,
    /// Bank, rad.
    pub roll_rad: f64,
    /// Pitch, rad.
    pub pitch_rad: f64,
    /// Heading of the nose, rad.
    pub heading_rad: f64,
    /// Body rates p, q, r, rad/s.
    pub rates_rad_s: [f64; 3],
    /// Airspeed, m/s EAS.
    pub airspeed_m_s: f64,
    /// True over equivalent airspeed.
    pub eas_to_tas: f64,
    /// Specific force along the forward axis, m/s² (what an accelerometer shows).
    pub forward_accel_m_s2: f64,
}

impl Sensed {
    fn is_finite(&self) -> bool {
        [
            self.position.north,
            self.position.east,
            self.height_m,
            self.velocity.north,
            self.velocity.east,
            self.climb_m_s,
            self.roll_rad,
            self.pitch_rad,
            self.heading_rad,
            self.airspeed_m_s,
            self.eas_to_tas,
            self.forward_accel_m_s2,
        ]
        .iter()
        .chain(&self.rates_rad_s)
        .all(|value| value.is_finite())
    }
}

/// Who decides the bank.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Lateral {
    /// The L1 law along a track.
    Track(Track),
    /// A bank angle, rad.
    Bank(f64),
    /// The pilot's stick, straight to the aileron, −1 to 1.
    Stick(f64),
}

/// Who decides pitch and throttle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Vertical {
    /// The energy law.
    Energy(Demand),
    /// A pitch angle, rad, and a throttle, 0 to 1.
    Pitch {
        /// Pitch, rad.
        pitch_rad: f64,
        /// Throttle, 0 to 1.
        throttle: f64,
    },
    /// The pilot's sticks, straight to elevator (−1 to 1) and throttle (0 to 1).
    Stick {
        /// Elevator, −1 to 1, positive up.
        elevator: f64,
        /// Throttle, 0 to 1.
        throttle: f64,
    },
}

/// Demands for this step.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Orders {
    /// Who decides the bank.
    pub lateral: Lateral,
    /// Who decides pitch and throttle.
    pub vertical: Vertical,
    /// Bank limit, rad.
    pub bank_max_rad: f64,
    /// Rudder added to the coordination, −1 to 1.
    pub rudder: f64,
    /// Heading that rudder and nose wheel hold while rolling on the ground, rad.
    pub ground_heading_rad: Option<f64>,
    /// True while the wheels carry the plane.
    pub on_ground: bool,
    /// True when the motor may not turn.
    pub throttle_off: bool,
}

/// Parameters of the three laws.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct PilotParams {
    /// Lateral guidance.
    pub l1: L1Params,
    /// Height and speed.
    pub tecs: TecsParams,
    /// Attitude.
    pub attitude: AttitudeParams,
}

impl PilotParams {
    /// Parameters from an ArduPlane parameter set; a name that `get` does not know keeps its default.
    ///
    /// The rate gains, limits and speeds are read by the names given at each field.
    pub fn from_ardupilot(get: impl Fn(&str) -> Option<f64>) -> Self {
        let mut params = Self::default();
        let read = |name: &str, into: &mut f64, factor: f64| {
            if let Some(value) = get(name).filter(|value| value.is_finite()) {
                *into = value * factor;
            }
        };
        let degree = 1_f64.to_radians();
        read("NAVL1_PERIOD", &mut params.l1.period_s, 1.0);
        read("NAVL1_DAMPING", &mut params.l1.damping, 1.0);
        read("NAVL1_XTRACK_I", &mut params.l1.xtrack_gain_per_s, 1.0);

        let tecs = &mut params.tecs;
        read("TECS_TIME_CONST", &mut tecs.time_constant_s, 1.0);
        read("TECS_LAND_TCONST", &mut tecs.land_time_constant_s, 1.0);
        read("TECS_CLMB_MAX", &mut tecs.climb_max_m_s, 1.0);
        read("TECS_SINK_MIN", &mut tecs.sink_min_m_s, 1.0);
        read("TECS_SINK_MAX", &mut tecs.sink_max_m_s, 1.0);
        read("TECS_SPDWEIGHT", &mut tecs.speed_weight, 1.0);
        read("TECS_LAND_SPDWGT", &mut tecs.land_speed_weight, 1.0);
        read("TECS_INTEG_GAIN", &mut tecs.integrator_gain_per_s, 1.0);
        read("TECS_THR_DAMP", &mut tecs.throttle_damping, 1.0);
        read("TECS_PTCH_DAMP", &mut tecs.pitch_damping, 1.0);
        read("TECS_LAND_DAMP", &mut tecs.land_pitch_damping, 1.0);
        read("TECS_RLL2THR", &mut tecs.roll_compensation_m_s, 1.0);
        read("TECS_VERT_ACC", &mut tecs.vertical_accel_max_m_s2, 1.0);
        read("TECS_HDEM_TCONST", &mut tecs.height_demand_tau_s, 1.0);
        read("TECS_LAND_SINK", &mut tecs.land_sink_m_s, 1.0);
        read("TECS_FLARE_HGT", &mut tecs.flare_hold_height_m, 1.0);
        read("TECS_TKOFF_IGAIN", &mut tecs.climbout_integrator_gain_per_s, 1.0);
        read("TECS_LAND_IGAIN", &mut tecs.land_integrator_gain_per_s, 1.0);
        read("TECS_LAND_TDAMP", &mut tecs.land_throttle_damping, 1.0);
        read("TECS_LAND_PDAMP", &mut tecs.approach_pitch_damping, 1.0);
        read("TECS_APPR_SMAX", &mut tecs.land_sink_max_m_s, 1.0);
        read("TRIM_THROTTLE", &mut tecs.throttle_trim, 0.01);
        read("THR_SLEWRATE", &mut tecs.throttle_slew_per_s, 0.01);
        read("AIRSPEED_CRUISE", &mut tecs.airspeed_cruise_m_s, 1.0);
        read("AIRSPEED_MIN", &mut tecs.airspeed_min_m_s, 1.0);
        read("AIRSPEED_MAX", &mut tecs.airspeed_max_m_s, 1.0);

        tecs.has_airspeed =
            get("ARSPD_TYPE").is_none_or(|value| value != 0.0) && get("ARSPD_USE").is_none_or(|value| value != 0.0);

        let attitude = &mut params.attitude;
        read("RLL2SRV_TCONST", &mut attitude.roll_tau_s, 1.0);
        read("RLL2SRV_RMAX", &mut attitude.roll_rate_max_rad_s, degree);
        read("PTCH2SRV_TCONST", &mut attitude.pitch_tau_s, 1.0);
        read("PTCH2SRV_RMAX_UP", &mut attitude.pitch_rate_max_rad_s, degree);
        read("PTCH2SRV_RLL", &mut attitude.turn_pitch, 1.0);
        read("KFF_RDDRMIX", &mut attitude.rudder_mix, 1.0);
        read("YAW2SRV_DAMP", &mut attitude.yaw_damping, 1.0);
        read("SCALING_SPEED", &mut attitude.scaling_speed_m_s, 1.0);
        attitude.airspeed_range_m_s = (tecs.airspeed_min_m_s, tecs.airspeed_max_m_s);
        for (prefix, gains) in [("RLL", &mut attitude.roll), ("PTCH", &mut attitude.pitch)] {
            read(&format!("{prefix}_RATE_FF"), &mut gains.ff, 1.0);
            read(&format!("{prefix}_RATE_P"), &mut gains.p, 1.0);
            read(&format!("{prefix}_RATE_I"), &mut gains.i, 1.0);
            read(&format!("{prefix}_RATE_D"), &mut gains.d, 1.0);
            read(&format!("{prefix}_RATE_IMAX"), &mut gains.integral_max, 1.0);
        }
        params
    }
}

/// Memory of the three laws.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct PilotState {
    l1: L1State,
    tecs: TecsState,
    attitude: AttitudeState,
    track: Option<Track>,
}

/// What moves, and why.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct PilotOutput {
    /// Surfaces, −1 to 1.
    pub surfaces: Surfaces,
    /// Throttle, 0 to 1.
    pub throttle: f64,
    /// Bank demand, rad.
    pub bank_rad: f64,
    /// Pitch demand, rad.
    pub pitch_rad: f64,
    /// Lateral law; zero when the bank comes from elsewhere.
    pub lateral: L1Output,
    /// Energy law; zero when pitch comes from elsewhere.
    pub energy: TecsOutput,
    /// True once a circle is being flown.
    pub on_circle: bool,
}

/// One control step; `dt_s` 0.001 to 0.1 s. Not finite in: surfaces neutral, motor off, memory kept.
pub fn step(
    state: PilotState,
    sensed: &Sensed,
    orders: &Orders,
    params: &PilotParams,
    dt_s: f64,
) -> (PilotState, PilotOutput) {
    if !sensed.is_finite() {
        return (state, PilotOutput::default());
    }
    let mut next = state;
    let mut output = PilotOutput::default();
    let bank_max = bound(orders.bank_max_rad, 0.0, 1.5);

    let mut stick_aileron = None;
    next.track = None;
    match orders.lateral {
        Lateral::Track(track) => {
            if !state.track.is_some_and(|previous| track.continues(&previous)) {
                next.l1.on_circle = false;
            }
            let motion =
                Motion { position: sensed.position, velocity: sensed.velocity, heading_rad: sensed.heading_rad };
            (next.l1, output.lateral) = l1::steer(next.l1, &motion, &track, &params.l1, dt_s);
            next.track = Some(track);
            output.bank_rad = bound(output.lateral.bank_rad(sensed.pitch_rad), -bank_max, bank_max);
        }
        Lateral::Bank(bank) => output.bank_rad = bound(bank, -bank_max, bank_max),
        Lateral::Stick(aileron) => {
            output.bank_rad = sensed.roll_rad;
            stick_aileron = Some(bound(aileron, -1.0, 1.0));
        }
    }
    output.on_circle = next.l1.on_circle && next.track.is_some();

    let mut stick_elevator = None;
    match orders.vertical {
        Vertical::Energy(demand) => {
            let energy = Energy {
                height_m: sensed.height_m,
                climb_m_s: sensed.climb_m_s,
                airspeed_m_s: sensed.airspeed_m_s,
                eas_to_tas: sensed.eas_to_tas,
                accel_m_s2: sensed.forward_accel_m_s2 - super::GRAVITY_M_S2 * sensed.pitch_rad.sin(),
                roll_rad: sensed.roll_rad,
                pitch_rad: sensed.pitch_rad,
            };
            (next.tecs, output.energy) = tecs::manage(state.tecs, &energy, &demand, &params.tecs, dt_s);
            output.pitch_rad = output.energy.pitch_rad;
            output.throttle = output.energy.throttle;
        }
        Vertical::Pitch { pitch_rad, throttle } => {
            output.pitch_rad = bound(pitch_rad, -1.5, 1.5);
            output.throttle = bound(throttle, 0.0, 1.0);
            next.tecs = TecsState::taking_over(output.throttle);
        }
        Vertical::Stick { elevator, throttle } => {
            output.pitch_rad = sensed.pitch_rad;
            output.throttle = bound(throttle, 0.0, 1.0);
            next.tecs = TecsState::taking_over(output.throttle);
            stick_elevator = Some(bound(elevator, -1.0, 1.0));
        }
    }
    if orders.throttle_off {
        output.throttle = 0.0;
    }

    let now = Attitude {
        roll_rad: sensed.roll_rad,
        pitch_rad: sensed.pitch_rad,
        rates_rad_s: sensed.rates_rad_s,
        airspeed_m_s: sensed.airspeed_m_s,
        eas_to_tas: sensed.eas_to_tas,
    };
    let integrate = !orders.on_ground;
    (next.attitude, output.surfaces) =
        attitude::stabilise(state.attitude, &now, output.bank_rad, output.pitch_rad, integrate, &params.attitude, dt_s);
    if let Some(aileron) = stick_aileron {
        output.surfaces.aileron = aileron;
        output.surfaces.rudder = 0.0;
    }
    if let Some(elevator) = stick_elevator {
        output.surfaces.elevator = elevator;
    }
    let steering = match orders.ground_heading_rad {
        Some(heading) if orders.on_ground => {
            // A second and a half to come back on course; the yaw rate damps it.
            let error = wrap_pi(heading - sensed.heading_rad);
            bound(1.5 * error - 0.4 * sensed.rates_rad_s[2], -1.0, 1.0)
        }
        _ => 0.0,
    };
    let coordination = if orders.on_ground { 0.0 } else { output.surfaces.rudder };
    output.surfaces.rudder = bound(coordination + steering + orders.rudder, -1.0, 1.0);
    (next, output)
}
