//! Telemetry snapshots for Python: each group as a dictionary whose keys are the fields of `vencejo.telemetry`'s classes.

use std::time::Duration;

use pyo3::prelude::*;
use pyo3::types::PyDict;
use vencejo_proto::MonoTime;
use vencejo_vehicle::telemetry::{Imu, Sampled, Telemetry};

/// What a vehicle had said at one moment.
#[pyclass(frozen, module = "vencejo._native")]
pub struct TelemetrySnapshot {
    telemetry: Telemetry,
    taken_at: MonoTime,
}

impl TelemetrySnapshot {
    /// The state at `taken_at`.
    pub fn new(telemetry: Telemetry, taken_at: MonoTime) -> Self {
        Self { telemetry, taken_at }
    }
}

/// Seconds as Python has them.
pub fn seconds(moment: MonoTime) -> f64 {
    moment.as_duration().as_secs_f64()
}

/// A dictionary of the given values plus what all groups have in common.
macro_rules! group {
    ($py:expr, $now:expr, $sampled:expr, |$value:ident| { $($key:ident: $field:expr),* $(,)? }) => {{
        let sampled = $sampled;
        let $value = &sampled.value;
        let dict = common($py, $now, sampled)?;
        $(dict.set_item(pyo3::intern!($py, stringify!($key)), $field)?;)*
        Ok(Some(dict))
    }};
}

fn common<'py, T>(py: Python<'py>, now: MonoTime, sampled: &Sampled<T>) -> PyResult<Bound<'py, PyDict>> {
    let age: Duration = sampled.age(now);
    let dict = PyDict::new(py);
    dict.set_item(pyo3::intern!(py, "age_s"), age.as_secs_f64())?;
    dict.set_item(pyo3::intern!(py, "has_invalid"), sampled.invalid)?;
    Ok(dict)
}

fn imu<'py>(py: Python<'py>, now: MonoTime, imu: Option<&Sampled<Imu>>) -> PyResult<Option<Bound<'py, PyDict>>> {
    let Some(sampled) = imu else { return Ok(None) };
    group!(py, now, sampled, |imu| {
        acc_g: imu.acc_g.map(<(f64, f64, f64)>::from),
        gyro_rad_s: imu.gyro_rad_s.map(<(f64, f64, f64)>::from),
        mag_gauss: imu.mag_gauss.map(<(f64, f64, f64)>::from),
        temperature_c: imu.temperature_c,
    })
}

#[pymethods]
impl TelemetrySnapshot {
    /// When it was taken, seconds on a monotonic clock.
    #[getter]
    fn time_s(&self) -> f64 {
        seconds(self.taken_at)
    }

    /// Values so far that could not be and were not used.
    #[getter]
    fn invalid_values(&self) -> u64 {
        self.telemetry.invalid_values
    }

    /// One group by name, `None` when it was not heard yet.
    fn group<'py>(&self, py: Python<'py>, name: &str) -> PyResult<Option<Bound<'py, PyDict>>> {
        let (t, now) = (&self.telemetry, self.taken_at);
        macro_rules! arm {
            ($field:ident, |$value:ident| $fields:tt) => {{
                let Some(sampled) = &t.$field else { return Ok(None) };
                group!(py, now, sampled, |$value| $fields)
            }};
        }
        match name {
            "heartbeat" => arm!(heartbeat, |h| {
                mode: h.mode.to_string(),
                mode_number: h.mode.custom_mode,
                is_armed: h.is_armed,
                system_status: h.system_status.to_string(),
                mav_type: h.mav_type,
                autopilot: h.autopilot,
            }),
            "attitude" => arm!(attitude, |a| {
                roll_rad: a.roll_rad,
                pitch_rad: a.pitch_rad,
                yaw_rad: a.yaw_rad,
                roll_rate_rad_s: a.roll_rate_rad_s,
                pitch_rate_rad_s: a.pitch_rate_rad_s,
                yaw_rate_rad_s: a.yaw_rate_rad_s,
            }),
            "position" => arm!(position, |p| {
                lat_deg: p.lat_deg,
                lon_deg: p.lon_deg,
                alt_amsl_m: p.alt_amsl_m,
                alt_rel_home_m: p.alt_rel_home_m,
                velocity_north_m_s: p.velocity_north_m_s,
                velocity_east_m_s: p.velocity_east_m_s,
                velocity_down_m_s: p.velocity_down_m_s,
                heading_deg: p.heading_deg,
            }),
            "hud" => arm!(hud, |h| {
                airspeed_m_s: h.airspeed_m_s,
                groundspeed_m_s: h.groundspeed_m_s,
                heading_deg: h.heading_deg,
                throttle_pct: h.throttle_pct,
                alt_amsl_m: h.alt_amsl_m,
                climb_m_s: h.climb_m_s,
            }),
            "gps" => arm!(gps, |g| {
                fix: g.fix.0,
                fix_name: g.fix.name(),
                satellites: g.satellites,
                hdop: g.hdop,
                vdop: g.vdop,
                lat_deg: g.lat_deg,
                lon_deg: g.lon_deg,
                alt_amsl_m: g.alt_amsl_m,
                groundspeed_m_s: g.groundspeed_m_s,
                course_deg: g.course_deg,
                horizontal_accuracy_m: g.horizontal_accuracy_m,
                vertical_accuracy_m: g.vertical_accuracy_m,
            }),
            "sys_status" => arm!(sys_status, |s| {
                is_ready_to_arm: s.is_ready_to_arm(),
                unhealthy_sensors: pyo3::types::PyTuple::new(py, s.unhealthy().collect::<Vec<_>>())?,
                load_pct: s.load_pct,
                voltage_v: s.voltage_v,
                current_a: s.current_a,
                battery_remaining_pct: s.battery_remaining_pct,
                drop_rate_pct: s.drop_rate_pct,
            }),
            "imu" => imu(py, now, t.imus[0].as_ref()),
            "pressure" => arm!(pressure, |p| {
                absolute_pa: p.absolute_pa,
                differential_pa: p.differential_pa,
                temperature_c: p.temperature_c,
            }),
            "wind" => arm!(wind, |w| {
                from_deg: w.from_deg,
                speed_m_s: w.speed_m_s,
                speed_down_m_s: w.speed_down_m_s,
            }),
            "home" => arm!(home, |h| {
                lat_deg: h.lat_deg,
                lon_deg: h.lon_deg,
                alt_amsl_m: h.alt_amsl_m,
            }),
            "mission" => arm!(mission, |m| {
                seq: m.seq,
                total: m.total,
                state: m.state.map(|state| state.to_string()),
            }),
            "nav" => arm!(nav, |n| {
                nav_roll_deg: n.nav_roll_deg,
                nav_pitch_deg: n.nav_pitch_deg,
                nav_bearing_deg: n.nav_bearing_deg,
                target_bearing_deg: n.target_bearing_deg,
                wp_distance_m: n.wp_distance_m,
                alt_error_m: n.alt_error_m,
                airspeed_error_m_s: n.airspeed_error_m_s,
                cross_track_error_m: n.cross_track_error_m,
            }),
            "extended" => arm!(extended, |e| {
                landed: e.landed.to_string(),
                vtol: e.vtol,
            }),
            "ekf" => arm!(ekf, |e| {
                flags: e.flags,
                velocity_variance: e.velocity_variance,
                pos_horiz_variance: e.pos_horiz_variance,
                pos_vert_variance: e.pos_vert_variance,
                compass_variance: e.compass_variance,
                terrain_alt_variance: e.terrain_alt_variance,
            }),
            "vibration" => arm!(vibration, |v| {
                vibration_m_s2: <(Option<f64>, Option<f64>, Option<f64>)>::from(v.vibration_m_s2),
                clipping: <(u32, u32, u32)>::from(v.clipping),
            }),
            "version" => arm!(version, |v| {
                flight_sw: v.flight_sw.to_string(),
                git_hash: v.git_hash.to_string(),
                capabilities: v.capabilities,
                uid: v.uid,
            }),
            "radio" => arm!(radio, |r| {
                rssi: r.rssi,
                remote_rssi: r.remote_rssi,
                noise: r.noise,
                remote_noise: r.remote_noise,
                tx_buffer_pct: r.tx_buffer_pct,
                rx_errors: r.rx_errors,
                fixed: r.fixed,
            }),
            "airspeed" => arm!(airspeed, |a| {
                id: a.id,
                airspeed_m_s: a.airspeed_m_s,
                differential_pa: a.differential_pa,
                temperature_c: a.temperature_c,
                is_unhealthy: a.is_unhealthy,
                is_used: a.is_used,
            }),
            "servos" => arm!(servos, |s| {
                pulse_us: pyo3::types::PyTuple::new(py, s.pulse_us)?,
            }),
            "rc" => arm!(rc, |r| {
                count: r.count,
                pulse_us: pyo3::types::PyTuple::new(py, r.pulse_us)?,
                rssi: r.rssi,
            }),
            "system_time" => arm!(system_time, |s| {
                utc_us: s.utc_us,
                boot_ms: s.boot_ms,
            }),
            "fence" => arm!(fence, |f| {
                is_breached: f.is_breached,
                breach_count: f.breach_count,
                breach_type: f.breach_type,
            }),
            "terrain" => arm!(terrain, |r| {
                ground_amsl_m: r.ground_amsl_m,
                alt_terrain_m: r.alt_terrain_m,
                pending: r.pending,
                loaded: r.loaded,
            }),
            _ => Err(pyo3::exceptions::PyKeyError::new_err(name.to_owned())),
        }
    }

    /// The batteries heard so far.
    fn batteries<'py>(&self, py: Python<'py>) -> PyResult<Vec<Bound<'py, PyDict>>> {
        let batteries = self.telemetry.batteries.iter().flatten().map(|sampled| {
            group!(py, self.taken_at, sampled, |b| {
                id: b.id,
                voltage_v: b.voltage_v,
                current_a: b.current_a,
                consumed_mah: b.consumed_mah,
                consumed_j: b.consumed_j,
                remaining_pct: b.remaining_pct,
                temperature_c: b.temperature_c,
                time_remaining_s: b.time_remaining_s,
            })
        });
        batteries.filter_map(Result::transpose).collect()
    }

    /// Inertial sensors 1 to 3.
    fn imus<'py>(&self, py: Python<'py>) -> PyResult<Vec<Option<Bound<'py, PyDict>>>> {
        self.telemetry.imus.iter().map(|sampled| imu(py, self.taken_at, sampled.as_ref())).collect()
    }
}
