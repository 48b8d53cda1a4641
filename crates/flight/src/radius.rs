//! Radii of circles as an ArduPlane takes them (`Plane::update_loiter` of ArduPilot 4.7).

/// Radii up to this count as unset: the vehicle flies its own, m.
const NONE_UP_TO_M: f64 = 1.0;
/// Radius where the ArduPlane's own is unset too, m (`LOITER_RADIUS_DEFAULT`).
const DEFAULT_M: f64 = 60.0;

/// Radius of an ArduPlane's own circles, m, negative anticlockwise, by its `WP_LOITER_RAD`, m. Of 1 m and less it takes
/// the sense alone and circles with 60 m.
pub fn own_radius_m(wp_loiter_rad: f64) -> f64 {
    if wp_loiter_rad.abs() > NONE_UP_TO_M {
        wp_loiter_rad
    } else if wp_loiter_rad < 0.0 {
        -DEFAULT_M
    } else {
        DEFAULT_M
    }
}

/// Radius that an item names, m, whose sign is its sense: 0, or -0, where it is 1 m and less, and the vehicle's own is
/// flown.
pub(crate) fn named_radius_m(signed_m: f64) -> f64 {
    if signed_m.abs() > NONE_UP_TO_M { signed_m } else { 0.0_f64.copysign(signed_m) }
}
