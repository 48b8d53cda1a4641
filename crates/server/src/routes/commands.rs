//! Commands to a vehicle. Each answers when the vehicle did it, and shows it where that can be seen. None does another as
//! a side effect.
//!
//! A request that describes itself ([`Request::described`]) is a path here by its name, with its values as the body. By hand are those whose
//! values have another form here than in the core.

use axum::Json;
use axum::routing::post;
use serde_json::{Map, Value};
use utoipa::openapi::path::{HttpMethod, OperationBuilder, ParameterBuilder, ParameterIn, PathsBuilder};
use utoipa::openapi::request_body::RequestBodyBuilder;
use utoipa::openapi::{ContentBuilder, PathItem, Ref, Required, ResponseBuilder, ResponsesBuilder};
use utoipa::{PartialSchema as _, ToSchema as _};
use utoipa_axum::router::{OpenApiRouter, UtoipaMethodRouter};
use utoipa_axum::routes;
use vencejo_flight::plan::Home;
use vencejo_proto::MissionSeq;
use vencejo_station::VehicleHandle;
use vencejo_vehicle::{Described, Request};

use crate::dto::{Done, MissionStart, SetHome, SetItem};
use crate::extract::{DespiteMixedPlan, Json as Body, OptionalJson, Pilot, Vehicle};
use crate::problem::Problem;
use crate::state::App;

/// Asks a vehicle for something and waits for the end, which comes within a bounded time. Whoever hangs up does not take
/// the command back.
async fn ask(
    pilot: &Pilot,
    vehicle: &VehicleHandle,
    DespiteMixedPlan(despite): DespiteMixedPlan,
    request: Request,
) -> Result<Json<Done>, Problem> {
    let request = if despite { Request::DespiteMixedPlan(Box::new(request)) } else { request };
    pilot.request(vehicle, request).wait().await.ok_or_else(Problem::closed)??;
    Ok(Json(Done {}))
}

pub(super) fn router() -> OpenApiRouter<App> {
    let by_hand =
        OpenApiRouter::new().routes(routes!(start_mission)).routes(routes!(set_current_item)).routes(routes!(set_home));
    Request::described().into_iter().fold(by_hand, |router, request| router.routes(path_of(request)))
}

/// The path of a request.
fn path_of(Described { name, text, values }: Described) -> UtoipaMethodRouter<App> {
    let parameter = |name: &str, place, required, text: &str, schema| {
        let parameter = ParameterBuilder::new().name(name).parameter_in(place).required(required);
        parameter.description(Some(text)).schema(Some(schema))
    };
    let done = ContentBuilder::new().schema(Some(Ref::from_schema_name("Done"))).build();
    let done = ResponseBuilder::new().content("application/json", done).build();
    let takes_values = values.is_some();
    let body = values.map(|values| {
        let required = if values.required.is_empty() { Required::False } else { Required::True };
        let content = ContentBuilder::new().schema(Some(values)).build();
        RequestBodyBuilder::new().content("application/json", content).required(Some(required)).build()
    });
    let id = parameter("id", ParameterIn::Path, Required::True, "The vehicle's id", u16::schema());
    let despite = "Do it although the mission on board may be mixed";
    let operation = OperationBuilder::new()
        .tag("commands")
        .summary(Some(text))
        .operation_id(Some(name.replace(['-', '/'], "_")))
        .parameter(id)
        .parameter(parameter("despite_mixed_plan", ParameterIn::Query, Required::False, despite, bool::schema()))
        .request_body(body)
        .responses(ResponsesBuilder::new().response("200", done).responses_from_into_responses::<Problem>().build())
        .build();
    let paths =
        PathsBuilder::new().path(format!("/vehicles/{{id}}/{name}"), PathItem::new(HttpMethod::Post, operation));
    let mut schemas = vec![(Done::name().into_owned(), Done::schema())];
    Request::schemas(&mut schemas);
    let handler = post(
        async move |pilot: Pilot,
                    Vehicle(vehicle): Vehicle,
                    despite: DespiteMixedPlan,
                    given: Result<OptionalJson<Map<String, Value>>, Problem>| {
            let mut values = if takes_values { given?.0 } else { Map::new() };
            // Null is what is not given.
            values.retain(|_, value| !value.is_null());
            let request = Request::named(&name, Value::Object(values)).map_err(Problem::invalid)?;
            ask(&pilot, &vehicle, despite, request).await
        },
    );
    (schemas, paths.build(), handler)
}

fn seq(vehicle: &VehicleHandle, item: u16) -> Result<MissionSeq, Problem> {
    vehicle.seq_of_item(item).ok_or_else(|| Problem::invalid_value("item", item, "items are counted from 1"))
}

/// Starts the mission: mode AUTO. Does not arm.
#[utoipa::path(post, path = "/vehicles/{id}/mission/start", tag = "commands", request_body = Option<MissionStart>,
    params(("id" = u16, Path, description = "The vehicle's id"),
        ("despite_mixed_plan" = Option<bool>, Query, description = "Do it although the mission on board may be mixed")),
    responses((status = 200, body = Done), Problem))]
async fn start_mission(
    pilot: Pilot,
    Vehicle(vehicle): Vehicle,
    despite: DespiteMixedPlan,
    OptionalJson(MissionStart { from_item }): OptionalJson<MissionStart>,
) -> Result<Json<Done>, Problem> {
    let from = from_item.map(|item| seq(&vehicle, item)).transpose()?;
    ask(&pilot, &vehicle, despite, Request::MissionStart { from }).await
}

/// Makes an item of the mission the current one.
#[utoipa::path(post, path = "/vehicles/{id}/mission/current", tag = "commands", request_body = SetItem,
    params(("id" = u16, Path, description = "The vehicle's id"),
        ("despite_mixed_plan" = Option<bool>, Query, description = "Do it although the mission on board may be mixed")),
    responses((status = 200, body = Done), Problem))]
async fn set_current_item(
    pilot: Pilot,
    Vehicle(vehicle): Vehicle,
    despite: DespiteMixedPlan,
    Body(SetItem { item }): Body<SetItem>,
) -> Result<Json<Done>, Problem> {
    let request = Request::SetCurrentItem(seq(&vehicle, item)?);
    ask(&pilot, &vehicle, despite, request).await
}

/// Moves home to a position, or to where the vehicle is when none is given.
#[utoipa::path(post, path = "/vehicles/{id}/home", tag = "commands", request_body = Option<SetHome>,
    params(("id" = u16, Path, description = "The vehicle's id"),
        ("despite_mixed_plan" = Option<bool>, Query, description = "Do it although the mission on board may be mixed")),
    responses((status = 200, body = Done), Problem))]
async fn set_home(
    pilot: Pilot,
    Vehicle(vehicle): Vehicle,
    despite: DespiteMixedPlan,
    OptionalJson(given): OptionalJson<SetHome>,
) -> Result<Json<Done>, Problem> {
    let home = match (given.lat_deg, given.lon_deg, given.alt_amsl_m) {
        (None, None, None) => None,
        (Some(lat_deg), Some(lon_deg), Some(alt_amsl_m)) => Some(Home { lat_deg, lon_deg, alt_amsl_m }),
        _ => {
            let said = "home is lat_deg, lon_deg and alt_amsl_m, or none of them for where the vehicle is";
            return Err(Problem::invalid(said));
        }
    };
    ask(&pilot, &vehicle, despite, Request::SetHome(home)).await
}
