//! From MAVLink's axes to those of ROS (REP-103): local north-east-down to east-north-up, body forward-right-down to
//! forward-left-up.

use vencejo_flight::geodesy::{GeoPoint, LocalFrame};
use vencejo_flight::plan::Home;
use vencejo_vehicle::telemetry::{Attitude, Position};

use super::message::{Pose, Quaternion, Vector3};

/// FLU from FRD.
pub fn flu([forward, right, down]: [f64; 3]) -> Vector3 {
    Vector3 { x: forward, y: -right, z: -down }
}

/// ENU from NED.
pub fn enu([north, east, down]: [f64; 3]) -> Vector3 {
    Vector3 { x: east, y: north, z: -down }
}

/// ENU from FLU, as a unit quaternion. Roll is about forward in both; a nose that goes up turns about the right wing,
/// so pitch changes its sign; yaw counts from east, counter-clockwise, in place of from north, clockwise.
pub fn orientation(attitude: &Attitude) -> Option<Quaternion> {
    let (roll, pitch) = (attitude.roll_rad?, -attitude.pitch_rad?);
    let yaw = std::f64::consts::FRAC_PI_2 - attitude.yaw_rad?;
    let [(sr, cr), (sp, cp), (sy, cy)] = [roll, pitch, yaw].map(|angle| (angle / 2.0).sin_cos());
    Some(Quaternion {
        x: sr * cp * cy - cr * sp * sy,
        y: cr * sp * cy + sr * cp * sy,
        z: cr * cp * sy - sr * sp * cy,
        w: cr * cp * cy + sr * sp * sy,
    })
}

/// Body rates, FLU, rad/s.
pub fn rates(attitude: &Attitude) -> Option<Vector3> {
    Some(flu([attitude.roll_rate_rad_s?, attitude.pitch_rate_rad_s?, attitude.yaw_rate_rad_s?]))
}

/// Velocity over ground, ENU, m/s.
pub fn velocity(position: &Position) -> Option<Vector3> {
    Some(enu([position.velocity_north_m_s?, position.velocity_east_m_s?, position.velocity_down_m_s?]))
}

/// A vector of the body in the local frame.
pub fn rotated(q: &Quaternion, v: &Vector3) -> Vector3 {
    let cross =
        |a: [f64; 3], b: [f64; 3]| [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
    let (axis, vector) = ([q.x, q.y, q.z], [v.x, v.y, v.z]);
    let once = cross(axis, vector).map(|part| 2.0 * part);
    let twice = cross(axis, once);
    let [x, y, z] = [0, 1, 2].map(|i| vector[i] + q.w * once[i] + twice[i]);
    Vector3 { x, y, z }
}

/// A vector of the local frame in the body's.
pub fn unrotated(q: &Quaternion, v: &Vector3) -> Vector3 {
    rotated(&Quaternion { x: -q.x, y: -q.y, z: -q.z, w: q.w }, v)
}

/// Where a place is, east, north and up of home, m; up is the height above home as given.
pub fn from_home(home: &Home, lat_deg: f64, lon_deg: f64, up_m: f64) -> Option<Vector3> {
    let origin = GeoPoint::new(home.lat_deg, home.lon_deg).ok()?;
    let [east, north, _] = LocalFrame::new(origin, 0.0).enu_m(GeoPoint::new(lat_deg, lon_deg).ok()?, 0.0);
    Some(Vector3 { x: east, y: north, z: up_m })
}

/// Where the plane is and how it lies in the air, from home.
pub fn pose(home: &Home, position: &Position, attitude: &Attitude) -> Option<Pose> {
    let position = from_home(home, position.lat_deg?, position.lon_deg?, position.alt_rel_home_m?)?;
    Some(Pose { position, orientation: orientation(attitude)? })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn near(found: &Vector3, wanted: [f64; 3]) {
        let off = [found.x - wanted[0], found.y - wanted[1], found.z - wanted[2]];
        assert!(off.iter().all(|part| part.abs() < 1e-9), "{found:?}, wanted {wanted:?}");
    }

    fn attitude(roll_deg: f64, pitch_deg: f64, yaw_deg: f64) -> Quaternion {
        let [roll_rad, pitch_rad, yaw_rad] = [roll_deg, pitch_deg, yaw_deg].map(|angle| Some(angle.to_radians()));
        orientation(&Attitude { roll_rad, pitch_rad, yaw_rad, ..Attitude::default() }).expect("an attitude")
    }

    /// Where the nose, the left wing and the top of a plane point, which anybody can see.
    #[test]
    fn the_axes_of_a_plane_point_where_they_do() {
        let [nose, left, top] =
            [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]].map(|[x, y, z]| Vector3 { x, y, z });
        let north = attitude(0.0, 0.0, 0.0);
        near(&rotated(&north, &nose), [0.0, 1.0, 0.0]);
        near(&rotated(&north, &left), [-1.0, 0.0, 0.0]);
        near(&rotated(&north, &top), [0.0, 0.0, 1.0]);
        near(&rotated(&attitude(0.0, 0.0, 90.0), &nose), [1.0, 0.0, 0.0]);
        // Nose up.
        near(&rotated(&attitude(0.0, 90.0, 0.0), &nose), [0.0, 0.0, 1.0]);
        // Right wing down: the left one is up.
        near(&rotated(&attitude(90.0, 0.0, 0.0), &left), [0.0, 0.0, 1.0]);
        near(&unrotated(&attitude(90.0, 0.0, 0.0), &Vector3 { x: 0.0, y: 0.0, z: 1.0 }), [0.0, 1.0, 0.0]);
        near(&flu([1.0, 2.0, 3.0]), [1.0, -2.0, -3.0]);
        near(&enu([1.0, 2.0, 3.0]), [2.0, 1.0, -3.0]);
        // East of north at 30 degrees of bank, nose 10 up: both ways, from the matrices of MAVLink's own convention.
        let (roll, pitch, yaw) = (30.0_f64.to_radians(), 10.0_f64.to_radians(), 60.0_f64.to_radians());
        let ned_of_right = [
            roll.sin() * pitch.sin() * yaw.cos() - roll.cos() * yaw.sin(),
            roll.sin() * pitch.sin() * yaw.sin() + roll.cos() * yaw.cos(),
            roll.sin() * pitch.cos(),
        ];
        let right = Vector3 { x: 0.0, y: -1.0, z: 0.0 };
        near(&rotated(&attitude(30.0, 10.0, 60.0), &right), [ned_of_right[1], ned_of_right[0], -ned_of_right[2]]);
    }

    #[test]
    fn places_are_counted_from_home() {
        let home = Home { lat_deg: 40.0, lon_deg: -3.0, alt_amsl_m: 600.0 };
        let there = from_home(&home, 40.001, -2.999, 50.0).expect("a place");
        assert!((there.x - 85.4).abs() < 0.1 && (there.y - 111.0).abs() < 0.1 && there.z == 50.0, "{there:?}");
    }
}
