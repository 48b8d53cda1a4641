//! Surveys for Python (see `vencejo.survey`), by `vencejo-flight`.

use std::collections::HashMap;

use pyo3::prelude::*;
use vencejo_flight::checks::check_survey;
use vencejo_flight::formats::{self, ComplexItem, survey_item};
use vencejo_flight::geodesy::GeoPoint;
use vencejo_flight::landing::Wind;
use vencejo_flight::plan::{Home, Mission, Plan};
use vencejo_flight::rehearsal::{Air, Aircraft, Conditions};
use vencejo_flight::survey::{
    CAMERAS, Camera, Coverage, Survey, SurveyOptions, SurveyShape, design_survey as design, rehearse_survey,
};

use crate::plan::{FindingFields, ItemTuple, findings, plan_to_tuple};
use crate::{errors, runtime};

/// Adds what this module has.
pub fn register(module: &Bound<'_, PyModule>) -> PyResult<()> {
    let cameras: Vec<_> = CAMERAS.iter().map(|known| (known.name, camera_to_tuple(&known.camera))).collect();
    module.add("CAMERAS", cameras)?;
    module.add_function(wrap_pyfunction!(survey_of, module)?)?;
    module.add_function(wrap_pyfunction!(design_survey, module)?)
}

/// Width and height of the sensor, mm; those of the picture, pixels; focal length, mm; least interval, s.
type CameraTuple = (f64, f64, u32, u32, f64, f64);

fn camera_to_tuple(camera: &Camera) -> CameraTuple {
    (
        camera.sensor_width_mm,
        camera.sensor_height_mm,
        camera.image_width_px,
        camera.image_height_px,
        camera.focal_length_mm,
        camera.min_interval_s,
    )
}

/// The options of a survey, by the names of [`SurveyOptions`].
#[derive(FromPyObject, IntoPyObject)]
#[pyo3(from_item_all)]
struct Asked {
    camera: Option<CameraTuple>,
    is_landscape: bool,
    gsd_m: Option<f64>,
    height_m: Option<f64>,
    front_overlap: f64,
    side_overlap: f64,
    spacing_m: Option<f64>,
    trigger_m: Option<f64>,
    course_deg: Option<f64>,
    wind: Option<(f64, f64)>,
    margin_m: Option<f64>,
    lead_in_m: Option<f64>,
    is_above_terrain: bool,
    ground_rel_home_m: Option<f64>,
    airspeed_m_s: Option<f64>,
    home: Option<(f64, f64, f64)>,
    coming_from: Option<(f64, f64)>,
    max_items: usize,
}

/// The laid-out survey, by the names of `vencejo.survey.Survey`.
#[derive(IntoPyObject)]
struct Laid {
    items: Vec<ItemTuple>,
    lines: Vec<Vec<(f64, f64)>>,
    course_deg: f64,
    course_from: &'static str,
    height_m: f64,
    gsd_m: Option<f64>,
    footprint_m: Option<(f64, f64)>,
    spacing_m: f64,
    trigger_m: Option<f64>,
    turn_radius_m: f64,
    lead_in_m: f64,
    lead_out_m: f64,
    groundspeed_m_s: (f64, f64),
    crab_deg: f64,
    area_m2: f64,
    line_m: f64,
    length_m: f64,
    duration_s: f64,
    photos: usize,
    cautions: Vec<(&'static str, String)>,
    flown: Flown,
    complex_item: (String, String),
}

/// Its rehearsed flight, by the names of `vencejo.survey.FlownSurvey`.
#[derive(IntoPyObject)]
struct Flown {
    photos: Vec<PhotoTuple>,
    covered: Option<f64>,
    overlapped: Option<f64>,
    views_promised: usize,
    holes: Vec<((f64, f64), f64)>,
    lines: Vec<(Option<f64>, usize, bool)>,
    duration_s: f64,
    findings: Vec<FindingFields>,
}

/// Time; latitude, longitude, height above home; heading, bank, pitch; corners of the ground that it shows.
type PhotoTuple = (f64, (f64, f64, f64), (f64, f64, f64), Option<Vec<(f64, f64)>>);

fn place(point: GeoPoint) -> (f64, f64) {
    (point.lat_deg(), point.lon_deg())
}

fn point((lat_deg, lon_deg): (f64, f64)) -> PyResult<GeoPoint> {
    GeoPoint::new(lat_deg, lon_deg).map_err(|error| errors::raise("InvalidRequest", error))
}

/// Places of an area or a line, the width of a corridor, and the options.
type SurveyTuple = (Vec<(f64, f64)>, Option<f64>, Asked);

/// The survey of a complex item of a plan; `None` for another kind of item.
#[pyfunction]
fn survey_of(kind: String, json: String) -> Option<SurveyTuple> {
    let (shape, options) = formats::survey_of(&ComplexItem { kind, json })?;
    let (points, width_m) = match shape {
        SurveyShape::Area(corners) => (corners, None),
        SurveyShape::Corridor { line, width_m } => (line, Some(width_m)),
    };
    let asked = Asked {
        camera: options.camera.as_ref().map(camera_to_tuple),
        is_landscape: options.is_landscape,
        gsd_m: options.gsd_m,
        height_m: options.height_m,
        front_overlap: options.front_overlap,
        side_overlap: options.side_overlap,
        spacing_m: options.spacing_m,
        trigger_m: options.trigger_m,
        course_deg: options.course_deg,
        wind: options.wind.map(|wind| (wind.from_deg, wind.speed_m_s)),
        margin_m: options.margin_m,
        lead_in_m: options.lead_in_m,
        is_above_terrain: options.is_above_terrain,
        ground_rel_home_m: options.ground_rel_home_m,
        airspeed_m_s: options.airspeed_m_s,
        home: None,
        coming_from: options.coming_from.map(place),
        max_items: options.max_items,
    };
    Some((points.into_iter().map(place).collect(), width_m, asked))
}

/// Lays out a survey and rehearses it: of an area by its corners, or with a width of a corridor by the points of its
/// line.
#[pyfunction]
#[pyo3(signature = (places, *, width_m, asked, parameters))]
fn design_survey(
    py: Python<'_>,
    places: Vec<(f64, f64)>,
    width_m: Option<f64>,
    asked: Asked,
    parameters: HashMap<String, f64>,
) -> PyResult<Laid> {
    let points = places.into_iter().map(point).collect::<PyResult<Vec<_>>>()?;
    let shape = match width_m {
        Some(width_m) => SurveyShape::Corridor { line: points, width_m },
        None => SurveyShape::Area(points),
    };
    let home = asked.home.map(|(lat_deg, lon_deg, alt_amsl_m)| Home { lat_deg, lon_deg, alt_amsl_m });
    if let Some(home) = home {
        point((home.lat_deg, home.lon_deg))?;
    }
    let options = SurveyOptions {
        camera: asked.camera.map(
            |(sensor_width_mm, sensor_height_mm, image_width_px, image_height_px, focal, interval)| Camera {
                sensor_width_mm,
                sensor_height_mm,
                image_width_px,
                image_height_px,
                focal_length_mm: focal,
                min_interval_s: interval,
            },
        ),
        is_landscape: asked.is_landscape,
        gsd_m: asked.gsd_m,
        height_m: asked.height_m,
        front_overlap: asked.front_overlap,
        side_overlap: asked.side_overlap,
        spacing_m: asked.spacing_m,
        trigger_m: asked.trigger_m,
        course_deg: asked.course_deg,
        wind: asked.wind.map(|(from_deg, speed_m_s)| Wind { from_deg, speed_m_s }),
        margin_m: asked.margin_m,
        lead_in_m: asked.lead_in_m,
        is_above_terrain: asked.is_above_terrain,
        ground_rel_home_m: asked.ground_rel_home_m,
        airspeed_m_s: asked.airspeed_m_s,
        home_amsl_m: home.map_or(0.0, |home| home.alt_amsl_m),
        coming_from: asked.coming_from.map(point).transpose()?,
        max_items: asked.max_items,
    };
    let laid_out = runtime::interruptible(py, move |is_wanted| {
        let get = |name: &str| parameters.get(name).copied();
        let plane = Aircraft::from_ardupilot(get);
        let survey = design(&shape, &options, &plane).map_err(|error| error.to_string())?;
        let air = Air::of(options.wind.unwrap_or_default(), get);
        let conditions = Conditions { home, is_wanted, ..Conditions::new(&plane, air) };
        let (flown, coverage) = rehearse_survey(&survey, &conditions).ok_or("the survey has no place to begin at")?;
        Ok(laid(&survey, &coverage, flown.duration_s))
    });
    laid_out?.map_err(|problem: String| errors::raise("InvalidRequest", problem))
}

fn laid(survey: &Survey, coverage: &Coverage, duration_s: f64) -> Laid {
    let mission = Mission { items: survey.items.clone(), ..Mission::default() };
    let (_, items, ..) = plan_to_tuple(&Plan::from_mission(mission));
    let photos = coverage.photos.iter().zip(&coverage.footprints).map(|(photo, print)| {
        let (lat_deg, lon_deg) = place(photo.point);
        let shown = print.map(|corners| corners.into_iter().map(place).collect());
        (photo.time_s, (lat_deg, lon_deg, photo.height_m), (photo.heading_deg, photo.bank_deg, photo.pitch_deg), shown)
    });
    Laid {
        items,
        lines: survey.lines.iter().map(|line| line.points.iter().copied().map(place).collect()).collect(),
        course_deg: survey.course_deg,
        course_from: survey.course_from.as_str(),
        height_m: survey.height_m,
        gsd_m: survey.gsd_m,
        footprint_m: survey.footprint.map(|print| (print.across_m, print.along_m)),
        spacing_m: survey.spacing_m,
        trigger_m: survey.trigger_m,
        turn_radius_m: survey.turn_radius_m,
        lead_in_m: survey.lead_in_m,
        lead_out_m: survey.lead_out_m,
        groundspeed_m_s: survey.groundspeed_m_s,
        crab_deg: survey.crab_deg,
        area_m2: survey.area_m2,
        line_m: survey.line_m,
        length_m: survey.length_m,
        duration_s: survey.duration_s,
        photos: survey.photos,
        cautions: survey.cautions.iter().map(|caution| (caution.as_str(), caution.to_string())).collect(),
        flown: Flown {
            photos: photos.collect(),
            covered: coverage.covered,
            overlapped: coverage.overlapped,
            views_promised: coverage.views_promised,
            holes: coverage.holes.iter().map(|hole| (place(hole.point), hole.area_m2)).collect(),
            lines: coverage.lines.iter().map(|line| (line.off_m, line.photos, line.is_missed)).collect(),
            duration_s,
            findings: findings(check_survey(survey, coverage, &survey.items, 0)),
        },
        complex_item: {
            let complex = survey_item(survey);
            (complex.kind, complex.json)
        },
    }
}
