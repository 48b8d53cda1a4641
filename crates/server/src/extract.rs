//! What handlers ask of a request: a role, a vehicle, a body. What is missing becomes a problem, never plain text.

use std::sync::Arc;

use axum::body::Bytes;
use axum::extract::{FromRequest, FromRequestParts, RawPathParams, Request};
use axum::http::header;
use axum::http::request::Parts;
use serde::de::DeserializeOwned;
use serde_json::value::RawValue;
use vencejo_station::{Operator as Operating, Pending, RequestResult, StationError, VehicleHandle};
use vencejo_vehicle::{Reply, Request as Act, VehicleId};

use crate::dto::Role;
use crate::dto::cause::Thing;
use crate::problem::Problem;
use crate::sessions::SessionId;
use crate::state::App;
use crate::strict;

fn session(parts: &Parts, app: &App) -> Option<(SessionId, Role)> {
    let secret = app.access().cookie(&parts.headers)?;
    let now = app.now();
    app.sessions().find(secret, now)
}

/// Somebody who may look: everybody on this machine where no token is needed, else a session.
pub struct Viewer;

impl FromRequestParts<App> for Viewer {
    type Rejection = Problem;

    async fn from_request_parts(parts: &mut Parts, app: &App) -> Result<Self, Problem> {
        let may_look = app.access().tokens.is_none() || session(parts, app).is_some();
        may_look.then_some(Self).ok_or_else(Problem::no_session)
    }
}

/// The role of somebody who may look.
pub struct ViewerRole(pub Role);

impl FromRequestParts<App> for ViewerRole {
    type Rejection = Problem;

    async fn from_request_parts(parts: &mut Parts, app: &App) -> Result<Self, Problem> {
        let own = session(parts, app).map(|(_, role)| role);
        let all = app.access().tokens.is_none().then_some(Role::Operator);
        own.or(all).map(Self).ok_or_else(Problem::no_session)
    }
}

/// Any session.
pub struct InSession(pub SessionId);

impl FromRequestParts<App> for InSession {
    type Rejection = Problem;

    async fn from_request_parts(parts: &mut Parts, app: &App) -> Result<Self, Problem> {
        session(parts, app).map(|(id, _)| Self(id)).ok_or_else(Problem::no_session)
    }
}

/// An operator's session, with or without control.
pub struct Operator(pub SessionId);

impl FromRequestParts<App> for Operator {
    type Rejection = Problem;

    async fn from_request_parts(parts: &mut Parts, app: &App) -> Result<Self, Problem> {
        let (id, role) = session(parts, app).ok_or_else(Problem::no_session)?;
        if role < Role::Operator { Err(Problem::viewer()) } else { Ok(Self(id)) }
    }
}

/// Where the confirmation of a dangerous act stands in a request.
pub const CONFIRMATION: &str = "vencejo-confirmation";

/// The operator of a session that holds control, or takes it now because nobody does.
///
/// # Errors
/// When somebody else holds it, and when the session is over.
pub fn in_control(app: &App, session: SessionId) -> Result<Arc<Operating>, Problem> {
    let operator = app.sessions().operator(session).ok_or_else(Problem::no_session)?;
    operator.take(app.now()).map_err(StationError::from)?;
    Ok(operator)
}

/// An operator's session that holds control, or takes it now because nobody does: whoever acts.
pub struct Pilot {
    /// The session.
    pub session: SessionId,
    operator: Arc<Operating>,
    confirmation: Option<String>,
}

impl Pilot {
    /// A vehicle, acted on in this session's name.
    pub fn vehicle(&self, vehicle: &VehicleHandle) -> VehicleHandle {
        vehicle.acting_as(self.operator.clone())
    }

    /// Asks a vehicle for something in this session's name, with the confirmation that came with the request.
    pub fn request(&self, vehicle: &VehicleHandle, request: Act) -> Pending<RequestResult> {
        self.vehicle(vehicle).request_confirmed(request, self.confirmation.as_deref())
    }

    /// The same, and waits for the end, which comes within a bounded time. Whoever hangs up does not take the command back.
    pub async fn ask(
        &self,
        vehicle: &VehicleHandle,
        DespiteMixedPlan(despite): DespiteMixedPlan,
        request: Act,
    ) -> Result<Reply, Problem> {
        let request = if despite { Act::DespiteMixedPlan(Box::new(request)) } else { request };
        Ok(self.request(vehicle, request).wait().await.ok_or_else(Problem::closed)??)
    }

    /// Whether it still may, once the request's body has come: that may take minutes. Requests to vehicles look by themselves.
    ///
    /// # Errors
    /// When somebody else holds control meanwhile, and when the session is over.
    pub fn still_in_control(&self, app: &App) -> Result<(), Problem> {
        in_control(app, self.session).map(|_| ())
    }

    /// The confirmation that came with the request.
    pub fn confirmation(&self) -> Option<&str> {
        self.confirmation.as_deref()
    }
}

impl FromRequestParts<App> for Pilot {
    type Rejection = Problem;

    async fn from_request_parts(parts: &mut Parts, app: &App) -> Result<Self, Problem> {
        let Operator(session) = Operator::from_request_parts(parts, app).await?;
        let operator = in_control(app, session)?;
        let confirmation = parts.headers.get(CONFIRMATION).map(|value| value.to_str().unwrap_or_default().to_owned());
        Ok(Self { session, operator, confirmation })
    }
}

/// The parameter `name` of the path.
async fn path_param(parts: &mut Parts, app: &App, name: &str) -> Result<String, Problem> {
    let params = RawPathParams::from_request_parts(parts, app).await;
    let params = params.map_err(|_| Problem::invalid("the path is not UTF-8"))?;
    let found = params.iter().find(|(key, _)| *key == name).map(|(_, value)| value.to_owned());
    found.ok_or_else(|| Problem::invalid(format!("the path has no {name}")))
}

/// The vehicle that the path names.
pub struct Vehicle(pub VehicleHandle);

impl FromRequestParts<App> for Vehicle {
    type Rejection = Problem;

    async fn from_request_parts(parts: &mut Parts, app: &App) -> Result<Self, Problem> {
        let id = path_param(parts, app, "id").await?;
        let id = id.parse().map(VehicleId::new).map_err(|_| {
            let detail = format!("'{id}' is no vehicle's id; they go from 1 to 255, and from 256 to 65535 far away");
            Problem::not_found(Thing::Vehicle, &id, detail)
        })?;
        app.station().vehicle(id).map(Self).ok_or_else(|| {
            Problem::not_found(Thing::Vehicle, id, format!("no vehicle with id {id} has been heard"))
                .remedy("GET /api/v1/vehicles lists those that were; check the link")
        })
    }
}

/// A number that the path names `id`.
pub struct Id(pub u64);

impl FromRequestParts<App> for Id {
    type Rejection = Problem;

    async fn from_request_parts(parts: &mut Parts, app: &App) -> Result<Self, Problem> {
        let id = path_param(parts, app, "id").await?;
        id.parse().map(Self).map_err(|_| Problem::invalid_value("id", &id, "a whole number"))
    }
}

/// A text that the path names `id`.
pub struct Text(pub String);

impl FromRequestParts<App> for Text {
    type Rejection = Problem;

    async fn from_request_parts(parts: &mut Parts, app: &App) -> Result<Self, Problem> {
        path_param(parts, app, "id").await.map(Self)
    }
}

/// The word that the path names `name`.
pub struct Name(pub String);

impl FromRequestParts<App> for Name {
    type Rejection = Problem;

    async fn from_request_parts(parts: &mut Parts, app: &App) -> Result<Self, Problem> {
        path_param(parts, app, "name").await.map(Self)
    }
}

/// The word that the path names `place`.
pub struct Place(pub String);

impl FromRequestParts<App> for Place {
    type Rejection = Problem;

    async fn from_request_parts(parts: &mut Parts, app: &App) -> Result<Self, Problem> {
        path_param(parts, app, "place").await.map(Self)
    }
}

/// A body of JSON.
pub struct Json<T>(pub T);

impl<T: DeserializeOwned> FromRequest<App> for Json<T> {
    type Rejection = Problem;

    async fn from_request(request: Request, app: &App) -> Result<Self, Problem> {
        // What is not even JSON ends here.
        let axum::Json(body): axum::Json<Box<RawValue>> = axum::Json::from_request(request, app).await?;
        strict::read(body.get()).map(Self).map_err(Problem::invalid)
    }
}

/// A body of JSON, or none, which stands for all defaults.
pub struct OptionalJson<T>(pub T);

impl<T: DeserializeOwned + Default> FromRequest<App> for OptionalJson<T> {
    type Rejection = Problem;

    async fn from_request(request: Request, app: &App) -> Result<Self, Problem> {
        let has_kind = request.headers().contains_key(header::CONTENT_TYPE);
        if has_kind {
            let Json(value) = Json::<Option<T>>::from_request(request, app).await?;
            return Ok(Self(value.unwrap_or_default()));
        }
        let body = Bytes::from_request(request, app).await?;
        if body.is_empty() {
            return Ok(Self(T::default()));
        }
        Err(Problem::invalid("send JSON with `Content-Type: application/json`, or nothing"))
    }
}

/// Whether the request is to be done although the mission on board may be a mixture: `despite_mixed_plan=true` in its query.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct DespiteMixedPlan(pub bool);

impl FromRequestParts<App> for DespiteMixedPlan {
    type Rejection = Problem;

    async fn from_request_parts(parts: &mut Parts, _: &App) -> Result<Self, Problem> {
        let query = parts.uri.query().unwrap_or_default();
        let mut given = query.split('&').filter_map(|pair| pair.strip_prefix("despite_mixed_plan="));
        match given.next() {
            None | Some("false") => Ok(Self(false)),
            Some("true") => Ok(Self(true)),
            Some(other) => Err(Problem::invalid_value("despite_mixed_plan", other, "true or false")),
        }
    }
}
