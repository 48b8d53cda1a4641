//! Ground elevations: at positions, and along a line or a plan.

#![allow(unused_qualifications, reason = "utoipa's query parameters name their type in full")]

use axum::Json;
use axum::extract::rejection::QueryRejection;
use axum::extract::{Query, State};
use serde::Deserialize;
use utoipa::IntoParams;
use utoipa_axum::router::OpenApiRouter;
use utoipa_axum::routes;
use vencejo_maps::elevation::{ElevationPoint, Profile};
use vencejo_maps::geo::Corner;

use super::maps_areas::{corners, route_of};
use crate::dto::maps::{ElevationRequest, Elevations, ProfileRequest};
use crate::extract::{Json as JsonBody, Viewer};
use crate::problem::Problem;
use crate::state::App;

pub(super) fn router() -> OpenApiRouter<App> {
    OpenApiRouter::new().routes(routes!(get_elevation, get_elevations))
}

/// Routes that accept a plan.
pub(super) fn plan_router() -> OpenApiRouter<App> {
    OpenApiRouter::new().routes(routes!(get_elevation_profile))
}

#[derive(Debug, Deserialize, IntoParams)]
#[into_params(parameter_in = Query)]
struct Place {
    /// WGS-84 latitude.
    lat_deg: f64,
    /// WGS-84 longitude.
    lon_deg: f64,
}

/// Ground elevation at a position; null when unknown. The list of map sources shows which of them fail.
#[utoipa::path(get, path = "/elevation", tag = "elevation", params(Place),
    responses((status = 200, body = ElevationPoint), Problem))]
async fn get_elevation(
    State(app): State<App>,
    _: Viewer,
    place: Result<Query<Place>, QueryRejection>,
) -> Result<Json<ElevationPoint>, Problem> {
    let Query(Place { lat_deg, lon_deg }) = place?;
    let (points, _) = app.maps()?.heights(&[Corner { lat_deg, lon_deg }]).await?;
    Ok(Json(points.into_iter().next().unwrap_or_default()))
}

/// Ground elevations at up to 2000 positions.
#[utoipa::path(post, path = "/elevation", tag = "elevation", request_body = ElevationRequest,
    responses((status = 200, body = Elevations), Problem))]
async fn get_elevations(
    State(app): State<App>,
    _: Viewer,
    JsonBody(asked): JsonBody<ElevationRequest>,
) -> Result<Json<Elevations>, Problem> {
    let (points, error) = app.maps()?.heights(&corners(&asked.points)).await?;
    Ok(Json(Elevations { points, error }))
}

/// Terrain profile along a line, or along a plan's legs from its home.
#[utoipa::path(post, path = "/elevation/profile", tag = "elevation", request_body = ProfileRequest,
    responses((status = 200, body = Profile), Problem))]
async fn get_elevation_profile(
    State(app): State<App>,
    _: Viewer,
    JsonBody(asked): JsonBody<ProfileRequest>,
) -> Result<Json<Profile>, Problem> {
    let points = match (&asked.plan, asked.points.is_empty()) {
        (Some(plan), true) => route_of(plan)?,
        (None, false) => corners(&asked.points),
        _ => return Err(Problem::invalid("either points or a plan is needed")),
    };
    Ok(Json(app.maps()?.profile(&points, asked.spacing_m).await?))
}
