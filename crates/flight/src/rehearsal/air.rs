//! The air that a plane is rehearsed in: its density, a steady wind with its profile, and gusts.

use crate::guidance::NorthEast;
use crate::landing::Wind;

/// Height above which the wind is the one given, m, by default.
const FULL_WIND_HEIGHT_M: f64 = 60.0;

/// Exponent of the wind's growth with height over open land (the "one-seventh power law": J. Counihan, "Adiabatic
/// atmospheric boundary layers", Atmospheric Environment 9, 1975).
const OPEN_LAND: f64 = 1.0 / 7.0;

/// Length over which gusts change at the heights of small planes, m (MIL-F-8785C, 3.7.2.2: 1,750 ft above 2,000 ft and
/// less below; 200 m is its value at 500 ft).
const GUST_LENGTH_M: f64 = 200.0;

/// Wind over height, and gusts.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Air {
    /// The wind from [`Self::full_height_m`] upwards.
    pub wind: Wind,
    /// Height above home from which the wind is the one given, m. Default 60.
    pub full_height_m: f64,
    /// Below, the wind is `(height / full_height)^exponent` of it. Default 1/7, over open land.
    pub exponent: f64,
    /// Standard deviation of each horizontal part of the gusts, m/s. Default 0.
    pub gust_m_s: f64,
    /// Which gusts: the same seed gives the same flight.
    pub seed: u64,
}

impl Default for Air {
    fn default() -> Self {
        Self { wind: Wind::default(), full_height_m: FULL_WIND_HEIGHT_M, exponent: OPEN_LAND, gust_m_s: 0.0, seed: 0 }
    }
}

impl From<Wind> for Air {
    fn from(wind: Wind) -> Self {
        Self { wind, ..Self::default() }
    }
}

impl Air {
    /// This wind for a vehicle of these parameters: that of ArduPilot's simulator grows with the square root of height
    /// up to `SIM_WIND_T_ALT` where `SIM_WIND_T` is 0, and not with height else; a real one's is that over open land.
    pub fn of(wind: Wind, get: impl Fn(&str) -> Option<f64>) -> Self {
        match get("SIM_WIND_T").filter(|_| is_ardupilots_simulator(&get)) {
            Some(0.0) => Self {
                full_height_m: get("SIM_WIND_T_ALT").unwrap_or(FULL_WIND_HEIGHT_M),
                exponent: 0.5,
                ..Self::from(wind)
            },
            Some(_) => Self { exponent: 0.0, ..Self::from(wind) },
            None => Self::from(wind),
        }
    }

    /// Velocity of the steady wind at a height above home, or above the ground where that lies lower, m/s: where it
    /// goes to.
    pub fn steady(&self, height_m: f64) -> NorthEast {
        let part = (height_m / self.full_height_m.max(1.0)).clamp(0.0, 1.0);
        let part = if part < 1.0 { part.powf(self.exponent.clamp(0.0, 2.0)) } else { 1.0 };
        NorthEast::from_bearing(self.wind.from_deg.to_radians()) * (-self.wind.speed_m_s * part)
    }
}

/// Slowest step of ArduPilot's simulator, Hz: that of a plane's main loop with sensors. Others that hold its parameters
/// step slower.
const SIMULATOR_HZ: f64 = 300.0;

/// Whether parameters are those of a plane in ArduPilot's simulator (`SIM_RATE_HZ`, 1,200 for its plane).
pub(super) fn is_ardupilots_simulator(get: impl Fn(&str) -> Option<f64>) -> bool {
    get("SIM_RATE_HZ").is_some_and(|rate_hz| rate_hz >= SIMULATOR_HZ)
}

/// True over equivalent airspeed at a height above the sea, `√(ρ₀/ρ)` of the standard atmosphere (ISO 2533), −1 to 20
/// km.
pub(crate) fn eas_to_tas(height_amsl_m: f64) -> f64 {
    let temperature = 1.0 - 2.255_77e-5 * height_amsl_m.clamp(-1_000.0, 20_000.0);
    temperature.powf(-0.5 * 4.255_88)
}

/// Gusts along a flight: a first-order process in each direction (the Dryden form without its zero, MIL-F-8785C
/// 3.7.1.2).
#[derive(Debug, Clone)]
pub(super) struct Gusts {
    state: u64,
    sigma_m_s: f64,
    now: NorthEast,
}

impl Gusts {
    pub fn new(air: &Air) -> Self {
        Self {
            state: air.seed ^ 0x9e37_79b9_7f4a_7c15,
            sigma_m_s: air.gust_m_s.clamp(0.0, 20.0),
            now: NorthEast::default(),
        }
    }

    /// The gust after a step through the air.
    pub fn step(&mut self, airspeed_m_s: f64, dt_s: f64) -> NorthEast {
        if self.sigma_m_s > 0.0 {
            let keep = (-airspeed_m_s.max(1.0) * dt_s / GUST_LENGTH_M).exp();
            let fresh = self.sigma_m_s * (1.0 - keep * keep).sqrt();
            let (north, east) = self.normal_pair();
            self.now = self.now * keep + NorthEast::new(north, east) * fresh;
        }
        self.now
    }

    /// Two independent normal numbers (Box and Muller, 1958).
    fn normal_pair(&mut self) -> (f64, f64) {
        let radius = (-2.0 * (1.0 - self.uniform()).ln()).sqrt();
        let (sin, cos) = (std::f64::consts::TAU * self.uniform()).sin_cos();
        (radius * cos, radius * sin)
    }

    /// 0 to below 1 (SplitMix64: Steele, Lea and Flood, OOPSLA 2014).
    fn uniform(&mut self) -> f64 {
        self.state = self.state.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut mixed = self.state;
        mixed = (mixed ^ (mixed >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        mixed = (mixed ^ (mixed >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        mixed ^= mixed >> 31;
        (mixed >> 11) as f64 / (1_u64 << 53) as f64
    }
}

/// Five independent normal numbers of a seed.
pub(super) fn normals(seed: u64) -> [f64; 5] {
    let mut gusts = Gusts { state: seed ^ 0x5851_f42d_4c95_7f2d, sigma_m_s: 1.0, now: NorthEast::default() };
    let (a, b) = gusts.normal_pair();
    let (c, d) = gusts.normal_pair();
    let (e, _) = gusts.normal_pair();
    [a, b, c, d, e]
}
