//! Plane guidance: pure laws `(state, target, params, dt) -> (state, output)`, without a clock, a sensor or an I/O.
//!
//! Three laws, each in its file, and the pilot that joins them:
//!
//! - [`l1`]: where to go → lateral acceleration and bank (Park, Deyst and How 2004),
//! - [`tecs`]: height and speed → throttle and pitch (total energy control, Lambregts 1983),
//! - [`attitude`]: bank, pitch and slip → aileron, elevator, rudder,
//! - [`pilot`]: one control step of a whole plane.
//!
//! The simulated plane flies on them; a rehearsal of a mission can fly the same laws over a simpler model.
//!
//! # Frames and signs
//!
//! Positions are metres north and east in a tangent plane that the caller chooses and keeps ([`NorthEast`]);
//! heights are metres up. Angles are radians: heading, course and bearing clockwise from north, roll right wing
//! down positive, pitch nose up positive. Body rates are right-handed around forward, right, down. Cross-track error is
//! positive when the plane is left of its track (the answer is a right turn).

pub mod attitude;
pub mod l1;
pub mod pilot;
pub mod tecs;

#[cfg(test)]
mod tests;

/// Standard gravity, m/s².
pub const GRAVITY_M_S2: f64 = 9.806_65;

/// A horizontal vector: metres (or metres per second) north and east.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct NorthEast {
    /// Northward component.
    pub north: f64,
    /// Eastward component.
    pub east: f64,
}

impl NorthEast {
    /// A vector from its components.
    pub const fn new(north: f64, east: f64) -> Self {
        Self { north, east }
    }

    /// The unit vector of a bearing in radians from north.
    pub fn from_bearing(bearing_rad: f64) -> Self {
        Self::new(bearing_rad.cos(), bearing_rad.sin())
    }

    /// Euclidean length.
    pub fn length(self) -> f64 {
        self.north.hypot(self.east)
    }

    /// Bearing of the vector, −π to π.
    pub fn bearing_rad(self) -> f64 {
        self.east.atan2(self.north)
    }

    /// Scalar product.
    pub fn dot(self, other: Self) -> f64 {
        self.north * other.north + self.east * other.east
    }

    /// Third component of the cross product in north-east-down: positive when `other` is clockwise of `self`.
    pub fn cross(self, other: Self) -> f64 {
        self.north * other.east - self.east * other.north
    }

    /// The vector of length 1, or `fallback` when it is too short to have a direction.
    #[must_use]
    pub fn unit_or(self, fallback: Self) -> Self {
        let length = self.length();
        if length > 1e-6 { self * (1.0 / length) } else { fallback }
    }
}

impl std::ops::Add for NorthEast {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        Self::new(self.north + other.north, self.east + other.east)
    }
}

impl std::ops::Sub for NorthEast {
    type Output = Self;
    fn sub(self, other: Self) -> Self {
        Self::new(self.north - other.north, self.east - other.east)
    }
}

impl std::ops::Mul<f64> for NorthEast {
    type Output = Self;
    fn mul(self, factor: f64) -> Self {
        Self::new(self.north * factor, self.east * factor)
    }
}

impl std::ops::Neg for NorthEast {
    type Output = Self;
    fn neg(self) -> Self {
        self * -1.0
    }
}

/// Wraps an angle to −π (exclusive) … π (inclusive). Not finite in, not finite out.
pub fn wrap_pi(angle_rad: f64) -> f64 {
    let wrapped = angle_rad.rem_euclid(std::f64::consts::TAU);
    if wrapped > std::f64::consts::PI { wrapped - std::f64::consts::TAU } else { wrapped }
}

/// `value` between `low` and `high`; a value that is not a number becomes `low`.
///
/// Unlike [`f64::clamp`] it never panics, whatever the order of the limits: parameters come from a vehicle.
pub(crate) fn bound(value: f64, low: f64, high: f64) -> f64 {
    if value > low { if value < high { value } else { high.max(low) } } else { low }
}

/// First-order low-pass step: moves `from` towards `to` with time constant `tau_s`.
pub(crate) fn lag(from: f64, to: f64, tau_s: f64, dt_s: f64) -> f64 {
    from + (to - from) * bound(dt_s / (tau_s + dt_s).max(1e-9), 0.0, 1.0)
}
