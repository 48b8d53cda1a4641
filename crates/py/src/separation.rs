//! Planned flights held against each other, for Python.

use pyo3::prelude::*;
use vencejo_flight::geodesy::GeoPoint;
use vencejo_flight::separation::{Conflict, Limits, Place, conflicts};

use crate::{errors, runtime};

/// Time, latitude, longitude, height above mean sea level.
type PlaceTuple = (f64, f64, f64, f64);
/// Indices of the tracks, begin, end, places, distance over ground, difference in height.
type ConflictTuple = ((usize, usize), f64, f64, (PlaceTuple, PlaceTuple), f64, f64);

/// Adds its function to the module.
pub fn register(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_function(wrap_pyfunction!(separation_conflicts, module)?)
}

/// Where any two tracks come too near to each other.
#[pyfunction]
#[pyo3(signature = (tracks, *, horizontal_m, vertical_m, window_s))]
fn separation_conflicts(
    py: Python<'_>,
    tracks: Vec<Vec<PlaceTuple>>,
    horizontal_m: f64,
    vertical_m: f64,
    window_s: f64,
) -> PyResult<Vec<ConflictTuple>> {
    let limits = Limits { horizontal_m, vertical_m, window_s };
    if let Some((field, value, least, most)) = limits.fault() {
        return Err(errors::raise("InvalidRequest", format!("{field} is {value}, should be {least} to {most}")));
    }
    let place = |(time_s, lat_deg, lon_deg, alt_amsl_m): PlaceTuple| {
        let point = GeoPoint::new(lat_deg, lon_deg).map_err(|error| errors::raise("InvalidRequest", error))?;
        if !time_s.is_finite() || !alt_amsl_m.is_finite() {
            return Err(errors::raise("InvalidRequest", "times and heights are finite numbers"));
        }
        Ok(Place { time_s, point, alt_amsl_m })
    };
    let tracks = tracks.into_iter().map(|track| track.into_iter().map(place).collect::<PyResult<Vec<_>>>());
    let tracks = tracks.collect::<PyResult<Vec<_>>>()?;
    runtime::interruptible(py, move |is_wanted| conflicts(&tracks, &limits, is_wanted).iter().map(tuple).collect())
}

fn tuple(found: &Conflict) -> ConflictTuple {
    let place = |place: &Place| (place.time_s, place.point.lat_deg(), place.point.lon_deg(), place.alt_amsl_m);
    let [first, second] = found.tracks;
    let nearest = (place(&found.nearest[0]), place(&found.nearest[1]));
    ((first, second), found.begins_s, found.ends_s, nearest, found.horizontal_m, found.vertical_m)
}
