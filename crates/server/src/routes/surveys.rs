//! Surveys: designed and rehearsed in one request, while a user draws an area.

use axum::Json;
use axum::extract::State;
use utoipa_axum::router::OpenApiRouter;
use utoipa_axum::routes;
use vencejo_flight::checks::check_survey;
use vencejo_flight::formats::{self, PlanSettings, survey_item, survey_of};
use vencejo_flight::geodesy::GeoPoint;
use vencejo_flight::plan::{Home, Plan as CorePlan};
use vencejo_flight::rehearsal::{Aircraft, Conditions};
use vencejo_flight::survey::{self as core, CAMERAS, Coverage, SurveyOptions, SurveyShape};
use vencejo_station::VehicleHandle;

use crate::convert;
use crate::dto::survey::{
    ComplexPart, FlownLine, FlownSurvey, NamedCamera, Survey, SurveyCaution, SurveyHole, SurveyRequest,
};
use crate::dto::{LatLon, Plan};
use crate::extract::{Json as Body, Viewer};
use crate::problem::Problem;
use crate::state::App;
use crate::turns::in_turn;

pub(super) fn router() -> OpenApiRouter<App> {
    OpenApiRouter::new().routes(routes!(survey)).routes(routes!(cameras)).routes(routes!(complex_parts))
}

/// Lists cameras in use on small planes.
#[utoipa::path(get, path = "/plan/cameras", tag = "plans", responses((status = 200, body = Vec<NamedCamera>), Problem))]
async fn cameras(_: Viewer) -> Json<Vec<NamedCamera>> {
    let named = |known: &core::KnownCamera| NamedCamera { name: known.name.to_owned(), camera: known.camera };
    Json(CAMERAS.iter().map(named).collect())
}

/// Locates the items of each complex item in the mission, in the order of `complex_items`, with the design requests of
/// surveys among them.
#[utoipa::path(post, path = "/plan/complex-items", tag = "plans", request_body = Plan,
    responses((status = 200, body = Vec<ComplexPart>), Problem))]
async fn complex_parts(_: Viewer, Body(plan): Body<Plan>) -> Result<Json<Vec<ComplexPart>>, Problem> {
    let settings = PlanSettings { complex_items: plan.complex_items.clone(), ..PlanSettings::default() };
    in_turn(move || parts_of(&convert::core_plan(&plan)?, settings)).await.map(Json)
}

fn parts_of(plan: &CorePlan, settings: PlanSettings) -> Result<Vec<ComplexPart>, Problem> {
    let parts = formats::complex_parts(plan, &settings)?;
    let parts_of_plan = parts.iter().zip(settings.complex_items).map(|(part, complex)| ComplexPart {
        first_item: part.first.map(|index| index + 1),
        count: part.count,
        survey: survey_of(&complex).map(|(shape, options)| request(&shape, &options)),
        kind: complex.kind,
    });
    Ok(parts_of_plan.collect())
}

/// Design request that would produce this survey.
fn request(shape: &SurveyShape, options: &SurveyOptions) -> SurveyRequest {
    let (points, width_m) = match shape {
        SurveyShape::Area(corners) => (corners, None),
        SurveyShape::Corridor { line, width_m } => (line, Some(*width_m)),
    };
    SurveyRequest {
        places: points.iter().map(place).collect(),
        width_m,
        camera: options.camera,
        is_landscape: options.is_landscape,
        gsd_m: options.gsd_m,
        height_m: options.height_m,
        front_overlap: Some(options.front_overlap),
        side_overlap: Some(options.side_overlap),
        spacing_m: options.spacing_m,
        trigger_m: options.trigger_m,
        course_deg: options.course_deg,
        wind: options.wind,
        margin_m: options.margin_m,
        lead_in_m: options.lead_in_m,
        is_above_terrain: options.is_above_terrain,
        ground_rel_home_m: options.ground_rel_home_m,
        airspeed_m_s: options.airspeed_m_s,
        home: None,
        coming_from: options.coming_from.as_ref().map(place),
        vehicle: None,
    }
}

fn place(point: &GeoPoint) -> LatLon {
    LatLon { lat_deg: point.lat_deg(), lon_deg: point.lon_deg() }
}

/// Designs and rehearses a survey of an area or a corridor: the items, the position of each image, and the coverage.
#[utoipa::path(post, path = "/plan/survey", tag = "plans", request_body = SurveyRequest,
    responses((status = 200, body = Survey), Problem))]
async fn survey(State(app): State<App>, _: Viewer, Body(asked): Body<SurveyRequest>) -> Result<Json<Survey>, Problem> {
    in_turn(move || laid_out(&app, &asked)).await.map(Json)
}

fn laid_out(app: &App, asked: &SurveyRequest) -> Result<Survey, Problem> {
    let vehicle = app.vehicle(asked.vehicle);
    let home = asked.home.or_else(|| vehicle.as_ref().and_then(VehicleHandle::home));
    if let Some(home) = home {
        home.point()?;
    }
    let (shape, options) = what_is_asked(asked, home)?;
    let wind = options.wind.unwrap_or_default();
    let (plane, air) =
        vehicle.as_ref().map_or_else(|| (Aircraft::default(), wind.into()), |vehicle| vehicle.flies_in(wind));
    let laid = core::design_survey(&shape, &options, &plane)?;
    let (flown, coverage) = core::rehearse_survey(&laid, &Conditions { home, ..Conditions::new(&plane, air) })
        .ok_or_else(|| Problem::invalid("the survey has no place to begin at"))?;
    let knows_parameters = vehicle.is_some_and(|vehicle| vehicle.knows_how_it_flies());
    Ok(described(&laid, &coverage, flown.duration_s, knows_parameters))
}

fn what_is_asked(asked: &SurveyRequest, home: Option<Home>) -> Result<(SurveyShape, SurveyOptions), Problem> {
    let points = asked.places.iter().copied().map(convert::point).collect::<Result<Vec<_>, _>>()?;
    let shape = match asked.width_m {
        Some(width_m) => SurveyShape::Corridor { line: points, width_m },
        None => SurveyShape::Area(points),
    };
    let usual = SurveyOptions::default();
    let options = SurveyOptions {
        camera: asked.camera,
        is_landscape: asked.is_landscape,
        gsd_m: asked.gsd_m,
        height_m: asked.height_m,
        front_overlap: asked.front_overlap.unwrap_or(usual.front_overlap),
        side_overlap: asked.side_overlap.unwrap_or(usual.side_overlap),
        spacing_m: asked.spacing_m,
        trigger_m: asked.trigger_m,
        course_deg: asked.course_deg,
        wind: asked.wind,
        margin_m: asked.margin_m,
        lead_in_m: asked.lead_in_m,
        is_above_terrain: asked.is_above_terrain,
        ground_rel_home_m: asked.ground_rel_home_m,
        airspeed_m_s: asked.airspeed_m_s,
        home_amsl_m: home.map_or(0.0, |home| home.alt_amsl_m),
        coming_from: asked.coming_from.map(convert::point).transpose()?,
        max_items: usual.max_items,
    };
    Ok((shape, options))
}

fn described(laid: &core::Survey, coverage: &Coverage, duration_s: f64, knows_parameters: bool) -> Survey {
    Survey {
        items: laid.items.iter().map(convert::item).collect(),
        lines: laid.lines.iter().map(|line| line.points.iter().map(place).collect()).collect(),
        next_entry: laid.next_entry().as_ref().map(place),
        course_deg: laid.course_deg,
        course_from: laid.course_from,
        height_m: laid.height_m,
        gsd_m: laid.gsd_m,
        footprint_across_m: laid.footprint.map(|print| print.across_m),
        footprint_along_m: laid.footprint.map(|print| print.along_m),
        spacing_m: laid.spacing_m,
        trigger_m: laid.trigger_m,
        turn_radius_m: laid.turn_radius_m,
        lead_in_m: laid.lead_in_m,
        lead_out_m: laid.lead_out_m,
        groundspeed_min_m_s: laid.groundspeed_m_s.0,
        groundspeed_max_m_s: laid.groundspeed_m_s.1,
        crab_deg: laid.crab_deg,
        area_m2: laid.area_m2,
        line_m: laid.line_m,
        length_m: laid.length_m,
        duration_s: laid.duration_s,
        photos: laid.photos as u64,
        cautions: laid
            .cautions
            .iter()
            .map(|caution| SurveyCaution { code: caution.as_str().to_owned(), message: caution.to_string() })
            .collect(),
        complex_item: survey_item(laid),
        flown: FlownSurvey {
            knows_parameters,
            photos: coverage.photos.iter().map(|photo| place(&photo.point)).collect(),
            footprints: coverage
                .footprints
                .iter()
                .map(|corners| corners.map(|corners| corners.iter().map(place).collect()))
                .collect(),
            covered: coverage.covered,
            overlapped: coverage.overlapped,
            views_promised: coverage.views_promised as u64,
            holes: coverage
                .holes
                .iter()
                .map(|hole| SurveyHole { at: place(&hole.point), area_m2: hole.area_m2 })
                .collect(),
            lines: coverage
                .lines
                .iter()
                .map(|line| FlownLine { off_m: line.off_m, photos: line.photos as u64, is_missed: line.is_missed })
                .collect(),
            duration_s,
            findings: check_survey(laid, coverage, &laid.items, 0),
        },
    }
}
