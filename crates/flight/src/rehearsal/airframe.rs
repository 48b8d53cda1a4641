//! What flies: lift, drag and thrust of a plane, per mass.

use crate::guidance::tecs::TecsParams;
use crate::guidance::{GRAVITY_M_S2, bound};
use crate::words::words;

/// Lift coefficient of a small plane's cruise, and its slope, 1/rad (a wing of aspect ratio 8; B. Etkin, L. D. Reid,
/// *Dynamics of Flight*, 3rd ed., eq. B.1,1).
const CRUISE_LIFT: f64 = 0.45;
const LIFT_PER_RAD: f64 = 5.5;
/// Drag coefficient of a foam pusher without lift, its idling propeller included, and its induced drag at
/// [`CRUISE_LIFT`] with an Oswald factor of 0.8 (D. P. Raymer, *Aircraft Design*, 6th ed., sections 12.5 and 12.6).
const DRAG_0: f64 = 0.05;
const DRAG_INDUCED: f64 = 0.01;
/// Static thrust of a foam pusher over its weight.
const THRUST_OVER_WEIGHT: f64 = 0.5;
/// Exponent of the power over the throttle by default.
const POWER_EXPONENT: f64 = 2.5;
/// Battery of ArduPilot's simulator, V (`SIM_BATT_VOLTAGE`).
const SIMULATOR_V: f64 = 12.6;

/// Mass, wing area and lift of the plane of ArduPilot's simulator (`SIM_Plane.h`): lift coefficient at no angle of
/// attack, and its slope.
const SIMULATED_KG: f64 = 2.0;
const SIMULATED_M2: f64 = 0.45;
const SIMULATED_LIFT_0: f64 = 0.56;
const SIMULATED_LIFT_PER_RAD: f64 = 6.9;
/// How far its centre of gravity lies behind and above where the forces act, m (`CGOffset`).
const SIMULATED_BEHIND_M: f64 = 0.15;
const SIMULATED_ABOVE_M: f64 = 0.05;

words! {
    /// How a profile of an airframe came about.
    #[derive(Default)]
    #[cfg_attr(feature = "describe", derive(serde::Deserialize))]
    Origin {
        /// A foam pusher, with what the autopilot's parameters say of climb, sink and throttle.
        #[default]
        Parameters = "parameters",
        /// The plane that ArduPilot's simulator flies.
        Simulator = "simulator",
        /// Estimated from a recorded flight.
        Flight = "flight",
    }
}

/// Lift, drag and thrust per mass, at indicated airspeeds.
///
/// The drag polar is parabolic, D = a V² + b n² V⁻² (J. D. Anderson, *Aircraft Performance and Design*, eq. 5.9).
///
/// Where it is known how much a propeller pulls standing still, thrust is T = Ts θ² − (Ts − Tf) θ V / Vc of throttle θ
/// and airspeed V, and nothing at least: ρ n² D⁴ C_T with revolutions n as the throttle and C_T linear in the advance
/// ratio V / (n D), as small propellers have it (J. B. Brandt, M. S. Selig, *Propeller Performance Data at Low Reynolds
/// Numbers*, AIAA 2011-1255). Elsewhere it is taken as independent of speed, which lies between a jet's and a
/// propeller's of constant power, and as linear in throttle on both sides of cruise.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(
    feature = "describe",
    derive(serde::Serialize, serde::Deserialize, utoipa::ToSchema),
    serde(deny_unknown_fields)
)]
pub struct Airframe {
    /// Where this profile comes from.
    pub origin: Origin,
    /// Airspeed that the following is given at, m/s.
    pub cruise_m_s: f64,
    /// Drag in level flight at it, m/s².
    pub drag_m_s2: f64,
    /// Part of that drag which lift induces, 0 to 1.
    pub induced: f64,
    /// Thrust at full throttle, m/s².
    pub thrust_full_m_s2: f64,
    /// The same standing still, no less; `None`: not known, or no propeller's.
    #[cfg_attr(feature = "describe", serde(default), schema(required = true))]
    pub thrust_static_m_s2: Option<f64>,
    /// Deceleration on the ground after a landing in addition to its drag, m/s²: its wheels, brakes, or belly; `None`:
    /// not known, and it slides.
    #[cfg_attr(feature = "describe", serde(default), schema(required = true))]
    pub ground_drag_m_s2: Option<f64>,
    /// Throttle of level flight at it, 0 to 1.
    pub throttle_cruise: f64,
    /// Angle of attack above that of no lift in level flight at it, rad.
    pub attack_rad: f64,
    /// Pitch of the fuselage in level flight at it, rad.
    pub level_pitch_rad: f64,
    /// True airspeed over what the autopilot takes for it; 1 where the pitot tube is right.
    pub pitot: f64,
    /// Whether [`Self::pitot`] is the air's own true over equivalent airspeed: ArduPilot's simulator divides by it
    /// twice (`SIM_Aircraft::update_eas_airspeed`, `SITL_State::_update_airspeed`), and its forces follow.
    pub is_simulated: bool,
    /// How much a turn skids: the side force of the slip that yawing brings, over the centripetal force. A bank turns
    /// the plane `1 / (1 + skid)` as fast as a coordinated turn does; 0, coordinated, unless learned. That of
    /// ArduPilot's simulator holds at sea level.
    pub skid: f64,
    /// Electrical power of level flight at it, W; `None`: not known, and no energy is computed.
    #[cfg_attr(feature = "describe", schema(required = true))]
    pub power_cruise_w: Option<f64>,
    /// Exponent of the power over the throttle: 3 for a propeller whose speed follows the throttle alone (momentum
    /// theory), less where it moves on; measured mostly 2 to 3.
    pub power_exponent: f64,
    /// Voltage of the battery in flight, V; `None`: not known.
    #[cfg_attr(feature = "describe", schema(required = true))]
    pub voltage_v: Option<f64>,
}

impl Airframe {
    /// A foam pusher, with the owner's TECS parameters.
    ///
    /// `TECS_CLMB_MAX` is the climb at full throttle and `TECS_SINK_MIN` the sink without, both at cruise; ArduPlane's
    /// defaults (5 and 2 m/s) are ignored.
    pub fn of_parameters(cruise_m_s: f64, tecs: &TecsParams, pitch_trim_deg: f64) -> Self {
        let cruise = bound(cruise_m_s, 3.0, 100.0);
        let untold = TecsParams::default();
        let accel = |rate_m_s: f64| GRAVITY_M_S2 * bound(rate_m_s, 0.1, 50.0) / cruise;
        let drag = if tecs.sink_min_m_s == untold.sink_min_m_s {
            GRAVITY_M_S2 * (DRAG_0 + DRAG_INDUCED) / CRUISE_LIFT
        } else {
            accel(tecs.sink_min_m_s)
        };
        let thrust = if tecs.climb_max_m_s == untold.climb_max_m_s {
            THRUST_OVER_WEIGHT * GRAVITY_M_S2
        } else {
            drag + accel(tecs.climb_max_m_s)
        };
        Self {
            origin: Origin::Parameters,
            cruise_m_s: cruise,
            drag_m_s2: drag,
            induced: DRAG_INDUCED / (DRAG_0 + DRAG_INDUCED),
            thrust_full_m_s2: thrust.max(1.1 * drag),
            thrust_static_m_s2: None,
            ground_drag_m_s2: None,
            throttle_cruise: bound(tecs.throttle_trim, 0.05, 0.95),
            attack_rad: CRUISE_LIFT / LIFT_PER_RAD,
            level_pitch_rad: pitch_trim_deg.to_radians(),
            pitot: 1.0,
            is_simulated: false,
            skid: 0.0,
            power_cruise_w: None,
            power_exponent: POWER_EXPONENT,
            voltage_v: None,
        }
    }

    /// The plane of ArduPilot's simulator: 2 kg, 0.45 m² of wing with a span of 1.88 m, hanging on its propeller at 70
    /// % throttle (`libraries/SITL/SIM_Plane.h` of ArduPilot 4.7: mass, wing, coefficients of lift and drag).
    ///
    /// `rudder_mix` is the rudder per aileron (`KFF_RDDRMIX`).
    pub fn of_simulator(cruise_m_s: f64, rudder_mix: f64) -> Self {
        let (mass_kg, area_m2, span_m, oswald) = (SIMULATED_KG, SIMULATED_M2, 1.88, 0.9);
        let (drag_0, lift_0, lift_per_rad) = (0.1, SIMULATED_LIFT_0, SIMULATED_LIFT_PER_RAD);
        let cruise = bound(cruise_m_s, 3.0, 100.0);
        let pressure = 0.5 * 1.225 * cruise * cruise * area_m2 / mass_kg;
        let lift = GRAVITY_M_S2 / pressure;
        let induced = lift * lift / (std::f64::consts::PI * oswald * span_m * span_m / area_m2);
        let drag = pressure * (drag_0 + induced);
        let thrust_full = GRAVITY_M_S2 / 0.7;
        // P = 50 A · throttle² (SIM_Plane.cpp).
        let throttle = bound(drag / thrust_full, 0.01, 0.99);
        Self {
            origin: Origin::Simulator,
            cruise_m_s: cruise,
            drag_m_s2: drag,
            induced: induced / (drag_0 + induced),
            thrust_full_m_s2: thrust_full,
            thrust_static_m_s2: None,
            ground_drag_m_s2: None,
            throttle_cruise: throttle,
            attack_rad: lift / lift_per_rad,
            level_pitch_rad: (lift - lift_0) / lift_per_rad,
            pitot: 1.0,
            is_simulated: true,
            skid: simulated_skid(mass_kg, area_m2, span_m, rudder_mix),
            power_cruise_w: Some(50.0 * throttle * throttle * SIMULATOR_V),
            power_exponent: 2.0,
            voltage_v: Some(SIMULATOR_V),
        }
    }

    /// What makes it no airframe: the field, its value and the range that it must be in.
    pub fn fault(&self) -> Option<(&'static str, f64, (f64, f64))> {
        let fields = [
            ("cruise_m_s", self.cruise_m_s, (3.0, 100.0)),
            ("drag_m_s2", self.drag_m_s2, (0.05, 20.0)),
            ("induced", self.induced, (0.0, 1.0)),
            ("thrust_full_m_s2", self.thrust_full_m_s2, (0.05, 60.0)),
            // More where it is faster would be no propeller, and no end to its speed.
            (
                "thrust_static_m_s2",
                self.thrust_static_m_s2.unwrap_or(self.thrust_full_m_s2),
                (self.thrust_full_m_s2, 60.0),
            ),
            ("ground_drag_m_s2", self.ground_drag_m_s2.unwrap_or(1.0), (0.05, 20.0)),
            ("throttle_cruise", self.throttle_cruise, (0.01, 0.99)),
            ("attack_rad", self.attack_rad, (0.005, 0.5)),
            ("level_pitch_rad", self.level_pitch_rad, (-0.5, 0.5)),
            ("pitot", self.pitot, (0.5, 2.0)),
            ("skid", self.skid, (0.0, 5.0)),
            ("power_cruise_w", self.power_cruise_w.unwrap_or(1.0), (0.1, 1e6)),
            ("power_exponent", self.power_exponent, (0.5, 5.0)),
            ("voltage_v", self.voltage_v.unwrap_or(1.0), (1.0, 1_000.0)),
        ];
        // NaN is in no range.
        fields.into_iter().find(|(_, value, (low, high))| !(*low..=*high).contains(value))
    }

    /// True over indicated airspeed where the air's own true over equivalent airspeed is this.
    pub(super) fn true_over_indicated(&self, eas_to_tas: f64) -> f64 {
        self.pitot * if self.is_simulated { eas_to_tas * eas_to_tas } else { eas_to_tas }
    }

    /// How much a turn skids where the air's own true over equivalent airspeed is this.
    pub(super) fn skid(&self, eas_to_tas: f64) -> f64 {
        self.skid / self.skids_less(eas_to_tas)
    }

    /// How much less a turn skids in thin air: the simulator's side force counts it three times, twice in the airspeed
    /// and once in the density (`SIM_Plane::getForce`).
    pub(super) fn skids_less(&self, eas_to_tas: f64) -> f64 {
        if self.is_simulated { eas_to_tas.powi(3) } else { 1.0 }
    }

    /// Change of the simulator's body rate of pitch, rad/s², at an angle of attack counted from no lift (rad), a rate
    /// (rad/s) and an elevator (−1 to 1, positive up): the moments of `SIM_Plane::getTorque`, whose moment of inertia
    /// is 1 kg m².
    pub(super) fn pitch_accel(
        &self,
        airspeed_m_s: f64,
        eas_to_tas: f64,
        lifting_rad: f64,
        rate_rad_s: f64,
        elevator: f64,
    ) -> f64 {
        let chord_m = 0.24;
        let force_n = 0.5 * 1.225 * airspeed_m_s * airspeed_m_s * SIMULATED_M2;
        let attack_rad = lifting_rad - SIMULATED_LIFT_0 / SIMULATED_LIFT_PER_RAD;
        let lift_n = force_n * SIMULATED_LIFT_PER_RAD * lifting_rad;
        let drag_n = SIMULATED_KG * self.drag(airspeed_m_s, lift_n / (SIMULATED_KG * GRAVITY_M_S2));
        let (sin, cos) = attack_rad.sin_cos();
        let (forward_n, down_n) = (lift_n * sin - drag_n * cos, -lift_n * cos - drag_n * sin);
        let damping = -20.0 * chord_m * rate_rad_s / (2.0 * (airspeed_m_s * eas_to_tas).max(1.0));
        force_n * chord_m * (0.045 - 0.7 * attack_rad + damping + elevator) + SIMULATED_BEHIND_M * down_n
            - SIMULATED_ABOVE_M * forward_n
    }

    /// Elevator of the simulator's plane in level flight, −1 to 1.
    pub(super) fn level_elevator(&self, airspeed_m_s: f64) -> f64 {
        let lifting_rad = self.attack_rad * (self.cruise_m_s / airspeed_m_s.max(1.0)).powi(2);
        let of = |elevator| self.pitch_accel(airspeed_m_s, 1.0, lifting_rad, 0.0, elevator);
        let (none, full) = (of(0.0), of(1.0));
        if self.is_simulated && full > none { -none / (full - none) } else { 0.0 }
    }

    /// Drag at an airspeed (m/s) and load factor, m/s².
    pub(super) fn drag(&self, airspeed_m_s: f64, load: f64) -> f64 {
        let square = (airspeed_m_s / self.cruise_m_s).powi(2).max(0.04);
        self.drag_m_s2 * ((1.0 - self.induced) * square + self.induced * load * load / square)
    }

    /// Airspeed of the flattest glide, m/s: where what lift induces is as much as the rest of the drag.
    pub(super) fn flattest_glide_m_s(&self) -> f64 {
        let induced = bound(self.induced, 0.01, 0.99);
        self.cruise_m_s * (induced / (1.0 - induced)).powf(0.25)
    }

    /// Thrust at a throttle and an airspeed (m/s), m/s².
    pub(super) fn thrust(&self, throttle: f64, airspeed_m_s: f64) -> f64 {
        if let Some(still) = self.thrust_static_m_s2 {
            let advance = throttle * airspeed_m_s / self.cruise_m_s;
            (still * throttle * throttle - (still - self.thrust_full_m_s2) * advance).max(0.0)
        } else if throttle < self.throttle_cruise {
            self.drag_m_s2 * throttle / self.throttle_cruise
        } else {
            let above = (throttle - self.throttle_cruise) / (1.0 - self.throttle_cruise);
            self.drag_m_s2 + (self.thrust_full_m_s2 - self.drag_m_s2) * above
        }
    }

    /// Power at a throttle over that of cruise.
    pub(super) fn power(&self, throttle: f64) -> f64 {
        (throttle / self.throttle_cruise).max(0.0).powf(self.power_exponent)
    }
}

/// How much the simulator's plane skids at sea level: in a steady turn the slip β, the aileron and the rudder mixed to
/// it hold the moments of yaw and roll at zero against those of the yaw rate r (`SIM_Plane::getTorque`, coefficients of
/// `SIM_Plane.h`, the centre of gravity 0.15 m behind and 0.05 m above where the forces act). Slip and surfaces so are
/// multiples of r/V, and their side force of the centripetal V r / cos φ.
fn simulated_skid(mass_kg: f64, area_m2: f64, span_m: f64, rudder_mix: f64) -> f64 {
    let (yaw_slip, yaw_rate, yaw_rudder) = (0.25, -1.0, 0.1);
    let (roll_slip, roll_rate, roll_aileron, roll_rudder) = (-0.12, 0.14, 0.25, -0.037);
    let (side_slip, side_rudder) = (-0.98, -0.2);
    let (behind_m, above_m) = (SIMULATED_BEHIND_M, SIMULATED_ABOVE_M);
    let rudder_mix = bound(rudder_mix, 0.0, 1.0);
    // Moments over dynamic pressure and wing area: of slip, of aileron with its rudder, of r/V; first yaw, then roll.
    let yaw = (
        span_m * yaw_slip - behind_m * side_slip,
        (span_m * yaw_rudder - behind_m * side_rudder) * rudder_mix,
        0.5 * span_m * span_m * yaw_rate,
    );
    let roll = (
        span_m * roll_slip + above_m * side_slip,
        span_m * roll_aileron + (span_m * roll_rudder + above_m * side_rudder) * rudder_mix,
        0.5 * span_m * span_m * roll_rate,
    );
    let whole = yaw.0 * roll.1 - yaw.1 * roll.0;
    let slip = (yaw.1 * roll.2 - yaw.2 * roll.1) / whole;
    let aileron = (yaw.2 * roll.0 - yaw.0 * roll.2) / whole;
    -0.5 * 1.225 * area_m2 / mass_kg * (side_slip * slip + side_rudder * rudder_mix * aileron)
}
