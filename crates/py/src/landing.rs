//! Landing design for Python (see `vencejo.landing`), by `vencejo-flight`.

use std::collections::HashMap;

use pyo3::prelude::*;
use vencejo_flight::FlightError;
use vencejo_flight::approaches::{
    Below, LandingPart, Runway, Site, design, landing_alternatives as alternatives, move_landing as moved, options_of,
};
use vencejo_flight::geodesy::GeoPoint;
use vencejo_flight::landing::{CALM_M_S, Landing, LandingOptions, Wind};
use vencejo_flight::rehearsal::{Air, Aircraft, Conditions};

use crate::plan::{ItemTuple, home_from_tuple, item_from_tuple, item_to_tuple};
use crate::{errors, ground, runtime};

/// Adds what this module has.
pub fn register(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add("CALM_WIND_M_S", CALM_M_S)?;
    module.add_function(wrap_pyfunction!(design_landing, module)?)?;
    module.add_function(wrap_pyfunction!(landing_alternatives, module)?)?;
    module.add_function(wrap_pyfunction!(move_landing, module)?)?;
    module.add_function(wrap_pyfunction!(runway, module)?)
}

type Place = (f64, f64);

fn refused(error: FlightError) -> PyErr {
    errors::raise("InvalidRequest", error)
}

fn point((lat_deg, lon_deg): Place) -> PyResult<GeoPoint> {
    GeoPoint::new(lat_deg, lon_deg).map_err(refused)
}

/// A point, or the two ends of a runway.
#[derive(FromPyObject)]
enum SiteTuple {
    Runway(Place, Place),
    Point(f64, f64),
}

impl SiteTuple {
    fn site(self) -> PyResult<Site> {
        match self {
            Self::Point(lat_deg, lon_deg) => point((lat_deg, lon_deg)).map(Site::Point),
            Self::Runway(begin, end) => Runway::new(point(begin)?, point(end)?).map(Site::Runway).map_err(refused),
        }
    }
}

/// The options of a landing; missing ones are the plane's.
#[derive(FromPyObject)]
struct Asked {
    #[pyo3(item)]
    course_deg: Option<f64>,
    #[pyo3(item)]
    coming_from: Option<Place>,
    #[pyo3(item)]
    wind: Option<Place>,
    #[pyo3(item)]
    ground_rel_home_m: Option<f64>,
    #[pyo3(item)]
    airspeed_m_s: Option<f64>,
    #[pyo3(item)]
    slope: Option<f64>,
    #[pyo3(item)]
    final_height_m: Option<f64>,
    #[pyo3(item)]
    radius_m: Option<f64>,
    #[pyo3(item)]
    is_clockwise: Option<bool>,
    #[pyo3(item)]
    has_land_start: Option<bool>,
    /// The plane's parameters; `None`: a small plane.
    #[pyo3(item)]
    parameters: Option<HashMap<String, f64>>,
}

impl Asked {
    fn get(&self) -> impl Fn(&str) -> Option<f64> {
        |name| self.parameters.as_ref().and_then(|parameters| parameters.get(name).copied())
    }

    fn blows(&self) -> Option<Wind> {
        self.wind.map(|(from_deg, speed_m_s)| Wind { from_deg, speed_m_s })
    }

    fn options(&self) -> PyResult<LandingOptions> {
        let usual = match self.parameters {
            Some(_) => options_of(&Aircraft::from_ardupilot(self.get()), self.blows()),
            None => LandingOptions::default(),
        };
        Ok(LandingOptions {
            course_deg: self.course_deg,
            coming_from: self.coming_from.map(point).transpose()?,
            wind: self.blows(),
            ground_rel_home_m: self.ground_rel_home_m,
            airspeed_m_s: self.airspeed_m_s.unwrap_or(usual.airspeed_m_s),
            slope: self.slope.unwrap_or(usual.slope),
            final_height_m: self.final_height_m.unwrap_or(usual.final_height_m),
            radius_m: self.radius_m.unwrap_or(usual.radius_m),
            is_clockwise: self.is_clockwise.unwrap_or(usual.is_clockwise),
            has_land_start: self.has_land_start.unwrap_or(usual.has_land_start),
        })
    }
}

/// Items, course, what gave it, place and height where the final leg begins, its length, its slope, radius of the
/// circle, headwind, groundspeed, and the cautions by name and text.
type LandingTuple =
    (Vec<ItemTuple>, f64, &'static str, (f64, f64, f64), f64, f64, f64, Option<f64>, Option<f64>, Vec<Said>);
type Said = (&'static str, String);

fn to_tuple(landing: Landing) -> LandingTuple {
    (
        landing.items.iter().map(item_to_tuple).collect(),
        landing.course_deg,
        landing.direction.as_str(),
        (landing.leaves.lat_deg(), landing.leaves.lon_deg(), landing.leaves_alt_rel_home_m),
        landing.final_m,
        landing.slope,
        landing.radius_m,
        landing.headwind_m_s,
        landing.groundspeed_m_s,
        landing.cautions.iter().map(|caution| (caution.as_str(), caution.to_string())).collect(),
    )
}

/// Designs a landing; what is not given of the plane and the shape is the core's default.
#[pyfunction]
fn design_landing(
    site: SiteTuple,
    asked: Asked,
    home: Option<(f64, f64, f64)>,
    ground: Option<Bound<'_, PyAny>>,
) -> PyResult<LandingTuple> {
    let site = site.site()?;
    let home = home.map(home_from_tuple);
    let map = ground::around(ground.as_ref(), &site.surroundings(), home)?;
    let home_m = home.and_then(|home| map.height_m(home.point().ok()?));
    let below = |at| Some(map.height_m(at)? - home_m?);
    let over = home_m.map(|_| &below as &Below<'_>);
    design(site, &asked.options()?, over).map(to_tuple).map_err(refused)
}

/// The landing, whether its circle is clockwise, crosswind; how it ends, where it touches down and rests, how long it
/// takes; verdict, reasons.
type AlternativeTuple =
    (LandingTuple, bool, Option<f64>, (&'static str, Option<f64>, Option<f64>, f64), &'static str, Vec<Said>);

/// The landings at a place, the best first.
#[pyfunction]
fn landing_alternatives(
    py: Python<'_>,
    site: SiteTuple,
    asked: Asked,
    home: Option<(f64, f64, f64)>,
    ground: Option<Bound<'_, PyAny>>,
) -> PyResult<Vec<AlternativeTuple>> {
    let (site, options) = (site.site()?, asked.options()?);
    let home = home.map(home_from_tuple);
    let map = ground::around(ground.as_ref(), &site.surroundings(), home)?;
    let found = runtime::interruptible(py, move |is_wanted| {
        let below = |point| map.height_m(point);
        let plane = Aircraft::from_ardupilot(asked.get());
        let air = Air::of(options.wind.unwrap_or_default(), asked.get());
        let conditions = Conditions { home, ground: Some(&below), is_wanted, ..Conditions::new(&plane, air) };
        alternatives(site, &options, &conditions)
    })?;
    Ok(found
        .map_err(refused)?
        .into_iter()
        .map(|one| {
            let flown = one.flown;
            (
                to_tuple(one.landing),
                one.is_clockwise,
                one.crosswind_m_s,
                (flown.ending.as_str(), flown.touch_down_m, flown.rest_m, flown.duration_s),
                one.verdict.as_str(),
                one.reasons.iter().map(|reason| (reason.as_str(), reason.to_string())).collect(),
            )
        })
        .collect())
}

/// A landing of which one part is moved.
#[pyfunction]
fn move_landing(items: Vec<ItemTuple>, part: &str, to: Place, asked: Asked) -> PyResult<LandingTuple> {
    let part = match part {
        "point" => LandingPart::Point,
        "final-leg" => LandingPart::FinalLeg,
        "circle" => LandingPart::Circle,
        other => {
            let problem = format!("a landing has no part {other:?}: it has a point, a final-leg and a circle");
            return Err(errors::raise("InvalidRequest", problem));
        }
    };
    let items: Vec<_> = items.into_iter().map(item_from_tuple).collect();
    moved(&items, part, point(to)?, &asked.options()?).map(to_tuple).map_err(refused)
}

/// Length and course of a runway, and its landing point from its beginning.
#[pyfunction]
fn runway(begin: Place, end: Place) -> PyResult<(f64, f64, Place)> {
    let runway = Runway::new(point(begin)?, point(end)?).map_err(refused)?;
    let aim = runway.aim();
    Ok((runway.length_m(), runway.course_deg(), (aim.lat_deg(), aim.lon_deg())))
}
