//! Geodesy on WGS-84 for Python (see `vencejo.geodesy`), by `vencejo-flight`.

use pyo3::prelude::*;
use vencejo_flight::crs::UtmZone;
use vencejo_flight::geodesy::{self, GeoPoint};

use crate::errors;

/// Adds the functions of this module.
pub fn register(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_function(wrap_pyfunction!(distance_m, module)?)?;
    module.add_function(wrap_pyfunction!(geodesic_line, module)?)?;
    module.add_function(wrap_pyfunction!(geodesic_end, module)?)?;
    module.add_function(wrap_pyfunction!(geodesic_points, module)?)?;
    module.add_function(wrap_pyfunction!(utm_from_geo, module)?)?;
    module.add_function(wrap_pyfunction!(geo_from_utm, module)?)?;
    Ok(())
}

fn point(lat_deg: f64, lon_deg: f64) -> PyResult<GeoPoint> {
    GeoPoint::new(lat_deg, lon_deg).map_err(|error| errors::raise("InvalidRequest", error))
}

fn finite(name: &str, value: f64) -> PyResult<f64> {
    if value.is_finite() {
        Ok(value)
    } else {
        Err(errors::raise("InvalidRequest", format!("{name} is {value}, should be a finite number")))
    }
}

/// Length of the geodesic between two points on the WGS-84 ellipsoid, metres.
#[pyfunction]
fn distance_m(lat1_deg: f64, lon1_deg: f64, lat2_deg: f64, lon2_deg: f64) -> PyResult<f64> {
    Ok(geodesy::distance_m(point(lat1_deg, lon1_deg)?, point(lat2_deg, lon2_deg)?))
}

/// Length (metres) and directions at both ends (degrees, 0 to 360) of the geodesic between two points.
#[pyfunction]
fn geodesic_line(lat1_deg: f64, lon1_deg: f64, lat2_deg: f64, lon2_deg: f64) -> PyResult<(f64, f64, f64)> {
    let line = geodesy::inverse(point(lat1_deg, lon1_deg)?, point(lat2_deg, lon2_deg)?);
    Ok((line.distance_m, line.bearing_start_deg, line.bearing_end_deg))
}

/// Where a geodesic from a point, in a direction, ends after a distance: latitude and longitude.
#[pyfunction]
fn geodesic_end(lat_deg: f64, lon_deg: f64, bearing_deg: f64, distance_m: f64) -> PyResult<(f64, f64)> {
    let bearing_deg = finite("bearing_deg", bearing_deg)?;
    let end = geodesy::direct(point(lat_deg, lon_deg)?, bearing_deg, finite("distance_m", distance_m)?);
    Ok((end.lat_deg(), end.lon_deg()))
}

/// Points along a geodesic, ends included, at most `step_m` apart.
#[pyfunction]
fn geodesic_points(
    lat1_deg: f64,
    lon1_deg: f64,
    lat2_deg: f64,
    lon2_deg: f64,
    step_m: f64,
) -> PyResult<Vec<(f64, f64)>> {
    let points = geodesy::points_along(point(lat1_deg, lon1_deg)?, point(lat2_deg, lon2_deg)?, step_m);
    Ok(points.into_iter().map(|point| (point.lat_deg(), point.lon_deg())).collect())
}

/// Zone, hemisphere, easting and northing of a place; in its own zone when none is given.
#[pyfunction]
fn utm_from_geo(lat_deg: f64, lon_deg: f64, zone: Option<(u8, bool)>) -> PyResult<(u8, bool, f64, f64)> {
    let place = point(lat_deg, lon_deg)?;
    let zone = zone.map_or_else(|| Ok(UtmZone::containing(place)), utm_zone)?;
    let [x_m, y_m] = zone.project(lat_deg, lon_deg);
    Ok((zone.number(), zone.is_north(), x_m, y_m))
}

/// Latitude and longitude of an easting and a northing.
#[pyfunction]
fn geo_from_utm(zone: u8, is_north: bool, x_m: f64, y_m: f64) -> PyResult<(f64, f64)> {
    let (lat_deg, lon_deg) =
        utm_zone((zone, is_north))?.unproject(finite("easting_m", x_m)?, finite("northing_m", y_m)?);
    let place = point(lat_deg.clamp(-90.0, 90.0), geodesy::wrap_180_deg(lon_deg))?;
    Ok((place.lat_deg(), place.lon_deg()))
}

fn utm_zone((number, is_north): (u8, bool)) -> PyResult<UtmZone> {
    UtmZone::new(number, is_north)
        .ok_or_else(|| errors::raise("InvalidRequest", format!("UTM has no zone {number}: zones are 1 to 60")))
}
