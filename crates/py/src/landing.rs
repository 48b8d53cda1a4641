//! Landing design for Python (see `vencejo.landing`), by `vencejo-flight`.

use pyo3::prelude::*;
use vencejo_flight::geodesy::GeoPoint;
use vencejo_flight::landing::{CALM_M_S, LandingOptions, Wind, design_landing as design};
use vencejo_flight::plan::{Mission, Plan};

use crate::errors;
use crate::plan::{ItemTuple, plan_to_tuple};

/// Adds what this module has.
pub fn register(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add("CALM_WIND_M_S", CALM_M_S)?;
    module.add_function(wrap_pyfunction!(design_landing, module)?)
}

fn point((lat_deg, lon_deg): (f64, f64)) -> PyResult<GeoPoint> {
    GeoPoint::new(lat_deg, lon_deg).map_err(|error| errors::raise("InvalidRequest", error))
}

/// Items, course, what gave it, place and height where the final leg begins, its length, its slope, radius of the circle,
/// headwind, groundspeed, and the cautions by name and text.
type LandingTuple = (
    Vec<ItemTuple>,
    f64,
    &'static str,
    (f64, f64, f64),
    f64,
    f64,
    f64,
    Option<f64>,
    Option<f64>,
    Vec<(&'static str, String)>,
);

/// Designs a landing; what is not given of the plane and the shape is the core's default.
#[pyfunction]
#[pyo3(signature = (
    at, *, course_deg, coming_from, wind, ground_rel_home_m, airspeed_m_s, slope, final_height_m, radius_m, is_clockwise,
    has_land_start
))]
// As Python gives them: by name.
#[allow(clippy::too_many_arguments)]
fn design_landing(
    at: (f64, f64),
    course_deg: Option<f64>,
    coming_from: Option<(f64, f64)>,
    wind: Option<(f64, f64)>,
    ground_rel_home_m: Option<f64>,
    airspeed_m_s: Option<f64>,
    slope: Option<f64>,
    final_height_m: Option<f64>,
    radius_m: Option<f64>,
    is_clockwise: bool,
    has_land_start: bool,
) -> PyResult<LandingTuple> {
    let usual = LandingOptions::default();
    let options = LandingOptions {
        course_deg,
        coming_from: coming_from.map(point).transpose()?,
        wind: wind.map(|(from_deg, speed_m_s)| Wind { from_deg, speed_m_s }),
        ground_rel_home_m,
        airspeed_m_s: airspeed_m_s.unwrap_or(usual.airspeed_m_s),
        slope: slope.unwrap_or(usual.slope),
        final_height_m: final_height_m.unwrap_or(usual.final_height_m),
        radius_m: radius_m.unwrap_or(usual.radius_m),
        is_clockwise,
        has_land_start,
    };
    let landing = design(point(at)?, &options).map_err(|error| errors::raise("InvalidRequest", error))?;
    let mission = Mission { items: landing.items, ..Mission::default() };
    let (_, items, ..) = plan_to_tuple(&Plan { mission, ..Plan::default() });
    Ok((
        items,
        landing.course_deg,
        landing.direction.as_str(),
        (landing.leaves.lat_deg(), landing.leaves.lon_deg(), landing.leaves_alt_rel_home_m),
        landing.final_m,
        landing.slope,
        landing.radius_m,
        landing.headwind_m_s,
        landing.groundspeed_m_s,
        landing.cautions.iter().map(|caution| (caution.as_str(), caution.to_string())).collect(),
    ))
}
