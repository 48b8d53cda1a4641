//! Commands to a vehicle. Each is answered when the vehicle has carried it out and its telemetry shows the effect,
//! where that can be observed. None causes another as a side effect.
//!
//! Each request that describes itself ([`Request::described`]) becomes a path with its name and a body with its values.

use std::fmt;

use axum::Json;
use axum::extract::State;
use axum::response::IntoResponse as _;
use axum::routing::post;
use serde::de::{Deserialize, Deserializer, Error as _, MapAccess, Visitor};
use serde_json::{Map, Value};
use utoipa::openapi::path::{HttpMethod, OperationBuilder, ParameterBuilder, ParameterIn, PathsBuilder};
use utoipa::openapi::request_body::RequestBodyBuilder;
use utoipa::openapi::{ContentBuilder, PathItem, Ref, Required, ResponseBuilder, ResponsesBuilder};
use utoipa::{PartialSchema as _, ToSchema as _};
use utoipa_axum::router::{OpenApiRouter, UtoipaMethodRouter};
use vencejo_vehicle::{Described, Reply, Request};

use super::messages::raw_message;
use crate::dto::Done;
use crate::dto::message::RawMessage;
use crate::extract::{DespiteMixedPlan, OptionalJson, Pilot, Vehicle};
use crate::problem::Problem;
use crate::state::App;

pub(super) fn router() -> OpenApiRouter<App> {
    Request::described().into_iter().fold(OpenApiRouter::new(), |router, request| router.routes(path_of(request)))
}

/// Path of a request.
fn path_of(Described { name, text, values, brings_message }: Described) -> UtoipaMethodRouter<App> {
    let parameter = |name: &str, place, required, text: &str, schema| {
        let parameter = ParameterBuilder::new().name(name).parameter_in(place).required(required);
        parameter.description(Some(text)).schema(Some(schema))
    };
    let brings = if brings_message { RawMessage::name() } else { Done::name() };
    let done = ContentBuilder::new().schema(Some(Ref::from_schema_name(brings))).build();
    let done = ResponseBuilder::new().content("application/json", done).build();
    let takes_values = values.is_some();
    let body = values.map(|values| {
        let required = if values.required.is_empty() { Required::False } else { Required::True };
        let content = ContentBuilder::new().schema(Some(values)).build();
        RequestBodyBuilder::new().content("application/json", content).required(Some(required)).build()
    });
    let id = parameter("id", ParameterIn::Path, Required::True, "The vehicle's id", u16::schema());
    let despite = "Carry it out although the mission on board may be mixed or lead out of reach";
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
    let mut schemas =
        vec![(Done::name().into_owned(), Done::schema()), (RawMessage::name().into_owned(), RawMessage::schema())];
    Request::schemas(&mut schemas);
    let handler = post(
        async move |State(app): State<App>,
                    pilot: Pilot,
                    Vehicle(vehicle): Vehicle,
                    despite: DespiteMixedPlan,
                    given: Result<OptionalJson<Values>, Problem>| {
            let Values(values) = if takes_values { given?.0 } else { Values::default() };
            let request = Request::named(&name, Value::Object(values)).map_err(Problem::invalid)?;
            Ok::<_, Problem>(match pilot.ask(&vehicle, despite, request).await? {
                Reply::Message(message) => Json(raw_message(&app, &vehicle, &message)).into_response(),
                _ => Json(Done {}).into_response(),
            })
        },
    );
    (schemas, paths.build(), handler)
}

/// Values by name, without duplicates. Null counts as absent.
#[derive(Default)]
struct Values(Map<String, Value>);

impl<'de> Deserialize<'de> for Values {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_map(Self::default())
    }
}

impl<'de> Visitor<'de> for Values {
    type Value = Self;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("an object")
    }

    fn visit_map<A: MapAccess<'de>>(mut self, mut access: A) -> Result<Self, A::Error> {
        while let Some((name, value)) = access.next_entry::<String, Value>()? {
            if self.0.contains_key(&name) {
                return Err(A::Error::custom(format_args!("{name} is given twice")));
            }
            self.0.insert(name, value);
        }
        self.0.retain(|_, value| !value.is_null());
        Ok(self)
    }
}
