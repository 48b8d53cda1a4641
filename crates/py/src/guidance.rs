//! Guidance laws of `vencejo-flight` for the simulated plane: one call per control step, numbers in and out.

use pyo3::prelude::*;
use pyo3::types::PyDict;
use vencejo_flight::guidance::NorthEast;
use vencejo_flight::guidance::l1::{Track, Turn};
use vencejo_flight::guidance::pilot::{self, Lateral, Orders, PilotOutput, PilotParams, PilotState, Sensed, Vertical};
use vencejo_flight::guidance::tecs::{Demand, Phase};

/// The laws that fly the simulated plane: L1, total energy and attitude.
///
/// Orders stay until they are given again; `step` is one control step. Positions are in the local frame, north and east
/// of its origin; heights are above the same datum in all calls. Surfaces go from −1 to 1, throttle from 0 to 1.
#[pyclass(module = "vencejo._native")]
struct PlanePilot {
    state: PilotState,
    params: PilotParams,
    orders: Orders,
    output: PilotOutput,
}

/// The output of one control step.
#[pyclass(frozen, get_all, module = "vencejo._native")]
struct ControlStep {
    aileron: f64,
    elevator: f64,
    rudder: f64,
    throttle: f64,
    /// Demands of the attitude laws.
    bank_rad: f64,
    pitch_rad: f64,
    /// Bearings to the reference point and to the target, and the error of the bearing.
    nav_bearing_rad: f64,
    target_bearing_rad: f64,
    bearing_error_rad: f64,
    xtrack_error_m: f64,
    l1_length_m: f64,
    /// Zero without energy control.
    airspeed_demand_m_s: f64,
}

#[allow(
    clippy::too_many_arguments,
    reason = "keywords from Python at every control step; an object for each vector would cost more than the call"
)]
#[pymethods]
impl PlanePilot {
    /// A pilot with default parameters, wings level, motor off.
    #[new]
    fn new() -> Self {
        Self {
            state: PilotState::default(),
            params: PilotParams::default(),
            orders: Orders {
                lateral: Lateral::Track(Track::Level),
                vertical: Vertical::Pitch { pitch_rad: 0.0, throttle: 0.0 },
                bank_max_rad: 1.0,
                rudder: 0.0,
                ground_heading_rad: None,
                on_ground: true,
                throttle_off: true,
            },
            output: PilotOutput::default(),
        }
    }

    /// Takes ArduPlane's parameters by name; a missing name keeps its default.
    fn set_params(&mut self, params: &Bound<'_, PyDict>) {
        self.params = PilotParams::from_ardupilot(|name| {
            params.get_item(name).ok().flatten().and_then(|value| value.extract().ok())
        });
    }

    /// Forgets integrators and filters.
    fn reset(&mut self) {
        self.state = PilotState::default();
        self.output = PilotOutput::default();
    }

    /// Follows the leg from one point to the next.
    #[pyo3(signature = (*, from_north_m, from_east_m, to_north_m, to_east_m))]
    fn fly_leg(&mut self, from_north_m: f64, from_east_m: f64, to_north_m: f64, to_east_m: f64) {
        self.orders.lateral = Lateral::Track(Track::Leg {
            from: NorthEast::new(from_north_m, from_east_m),
            to: NorthEast::new(to_north_m, to_east_m),
        });
    }

    /// Circles around a point.
    #[pyo3(signature = (*, north_m, east_m, radius_m, clockwise))]
    fn fly_circle(&mut self, north_m: f64, east_m: f64, radius_m: f64, clockwise: bool) {
        let circle = Track::Circle {
            centre: NorthEast::new(north_m, east_m),
            radius_m,
            turn: if clockwise { Turn::Clockwise } else { Turn::Anticlockwise },
        };
        // Whether the circle is being flown is known after the next step only.
        if !matches!(self.orders.lateral, Lateral::Track(before) if circle.continues(&before)) {
            self.output.on_circle = false;
        }
        self.orders.lateral = Lateral::Track(circle);
    }

    /// Holds a heading.
    fn fly_heading(&mut self, heading_rad: f64) {
        self.orders.lateral = Lateral::Track(Track::Heading { heading_rad });
    }

    /// Holds the wings level.
    fn fly_level(&mut self) {
        self.orders.lateral = Lateral::Track(Track::Level);
    }

    /// Holds a bank.
    fn fly_bank(&mut self, bank_rad: f64) {
        self.orders.lateral = Lateral::Bank(bank_rad);
    }

    /// Passes the stick to the aileron.
    fn stick_aileron(&mut self, aileron: f64) {
        self.orders.lateral = Lateral::Stick(aileron);
    }

    /// Energy control in flight, or with `climbout` a full-throttle climb.
    #[pyo3(signature = (*, height_m, airspeed_m_s, climbout, pitch_min_rad, pitch_max_rad, throttle_min, throttle_max))]
    fn fly_energy(
        &mut self,
        height_m: f64,
        airspeed_m_s: f64,
        climbout: bool,
        pitch_min_rad: f64,
        pitch_max_rad: f64,
        throttle_min: f64,
        throttle_max: f64,
    ) {
        let phase = if climbout { Phase::Climbout } else { Phase::Cruise };
        self.orders.vertical = Vertical::Energy(Demand {
            height_m,
            airspeed_m_s,
            phase,
            pitch_min_rad,
            pitch_max_rad,
            throttle_min,
            throttle_max,
        });
    }

    /// Energy control on final approach; `proportion` of the leg is flown.
    #[pyo3(signature = (*, height_m, airspeed_m_s, proportion, pitch_min_rad, pitch_max_rad, throttle_max))]
    fn fly_approach(
        &mut self,
        height_m: f64,
        airspeed_m_s: f64,
        proportion: f64,
        pitch_min_rad: f64,
        pitch_max_rad: f64,
        throttle_max: f64,
    ) {
        self.orders.vertical = Vertical::Energy(Demand {
            height_m,
            airspeed_m_s,
            phase: Phase::Approach { proportion },
            pitch_min_rad,
            pitch_max_rad,
            throttle_min: 0.0,
            throttle_max,
        });
    }

    /// Rounds out over the runway, motor off.
    #[pyo3(signature = (*, height_m, start_height_m, start_sink_m_s, airspeed_m_s, pitch_min_rad, pitch_max_rad))]
    fn fly_flare(
        &mut self,
        height_m: f64,
        start_height_m: f64,
        start_sink_m_s: f64,
        airspeed_m_s: f64,
        pitch_min_rad: f64,
        pitch_max_rad: f64,
    ) {
        self.orders.vertical = Vertical::Energy(Demand {
            height_m,
            airspeed_m_s,
            phase: Phase::Flare { height_m, start_height_m, start_sink_m_s },
            pitch_min_rad,
            pitch_max_rad,
            throttle_min: 0.0,
            throttle_max: 0.0,
        });
    }

    /// Holds a pitch with a throttle.
    fn fly_pitch(&mut self, pitch_rad: f64, throttle: f64) {
        self.orders.vertical = Vertical::Pitch { pitch_rad, throttle };
    }

    /// Passes the sticks to elevator and throttle.
    fn stick_elevator(&mut self, elevator: f64, throttle: f64) {
        self.orders.vertical = Vertical::Stick { elevator, throttle };
    }

    /// Bank limit, added rudder, heading to steer on the ground, and what holds the plane.
    #[pyo3(signature = (*, bank_max_rad, rudder, ground_heading_rad, on_ground, throttle_off))]
    fn set_limits(
        &mut self,
        bank_max_rad: f64,
        rudder: f64,
        ground_heading_rad: Option<f64>,
        on_ground: bool,
        throttle_off: bool,
    ) {
        self.orders.bank_max_rad = bank_max_rad;
        self.orders.rudder = rudder;
        self.orders.ground_heading_rad = ground_heading_rad;
        self.orders.on_ground = on_ground;
        self.orders.throttle_off = throttle_off;
    }

    /// One control step: `(aileron, elevator, rudder, throttle)`.
    #[pyo3(signature = (
        *,
        north_m,
        east_m,
        height_m,
        velocity_north_m_s,
        velocity_east_m_s,
        climb_m_s,
        roll_rad,
        pitch_rad,
        heading_rad,
        roll_rate_rad_s,
        pitch_rate_rad_s,
        yaw_rate_rad_s,
        airspeed_m_s,
        eas_to_tas,
        forward_accel_m_s2,
        dt_s,
    ))]
    fn step(
        &mut self,
        north_m: f64,
        east_m: f64,
        height_m: f64,
        velocity_north_m_s: f64,
        velocity_east_m_s: f64,
        climb_m_s: f64,
        roll_rad: f64,
        pitch_rad: f64,
        heading_rad: f64,
        roll_rate_rad_s: f64,
        pitch_rate_rad_s: f64,
        yaw_rate_rad_s: f64,
        airspeed_m_s: f64,
        eas_to_tas: f64,
        forward_accel_m_s2: f64,
        dt_s: f64,
    ) -> ControlStep {
        let sensed = Sensed {
            position: NorthEast::new(north_m, east_m),
            height_m,
            velocity: NorthEast::new(velocity_north_m_s, velocity_east_m_s),
            climb_m_s,
            roll_rad,
            pitch_rad,
            heading_rad,
            rates_rad_s: [roll_rate_rad_s, pitch_rate_rad_s, yaw_rate_rad_s],
            airspeed_m_s,
            eas_to_tas,
            forward_accel_m_s2,
        };
        (self.state, self.output) = pilot::step(self.state, &sensed, &self.orders, &self.params, dt_s);
        self.output()
    }

    /// The output of the newest step; zero before the first and after `reset`.
    #[getter]
    fn output(&self) -> ControlStep {
        let PilotOutput { surfaces, throttle, bank_rad, pitch_rad, lateral, energy, .. } = &self.output;
        ControlStep {
            aileron: surfaces.aileron,
            elevator: surfaces.elevator,
            rudder: surfaces.rudder,
            throttle: *throttle,
            bank_rad: *bank_rad,
            pitch_rad: *pitch_rad,
            nav_bearing_rad: lateral.nav_bearing_rad,
            target_bearing_rad: lateral.target_bearing_rad,
            bearing_error_rad: lateral.bearing_error_rad,
            xtrack_error_m: lateral.xtrack_error_m,
            l1_length_m: lateral.length_m,
            airspeed_demand_m_s: energy.airspeed_demand_m_s,
        }
    }

    /// True once the ordered circle is being flown.
    #[getter]
    fn on_circle(&self) -> bool {
        self.output.on_circle
    }
}

/// Adds the guidance classes to the native module.
pub fn register(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_class::<ControlStep>()?;
    module.add_class::<PlanePilot>()
}
