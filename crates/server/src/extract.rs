//! Extractors for handlers: a role, a vehicle, a body. Rejections are problems, never plain text.

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
use crate::dto::cause::ResourceKind;
use crate::problem::Problem;
use crate::sessions::SessionId;
use crate::state::App;
use crate::strict;

fn session(parts: &Parts, app: &App) -> Option<(SessionId, Role)> {
    let secret = app.access().cookie(&parts.headers)?;
    let now = app.now();
    app.sessions().find(secret, now)
}

/// A client that may read: any on this machine where no token is needed, else one with a session.
pub struct Viewer;

impl FromRequestParts<App> for Viewer {
    type Rejection = Problem;

    async fn from_request_parts(parts: &mut Parts, app: &App) -> Result<Self, Problem> {
        let may_look = app.access().tokens.is_none() || session(parts, app).is_some();
        may_look.then_some(Self).ok_or_else(Problem::no_session)
    }
}

/// Role of a client that may read.
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

/// Header with the confirmation of a dangerous action.
pub const CONFIRMATION: &str = "vencejo-confirmation";

/// The operator of a session that holds control, or takes it now because it is free.
///
/// # Errors
/// When another session holds control, and when the session has ended.
pub fn in_control(app: &App, session: SessionId) -> Result<Arc<Operating>, Problem> {
    let operator = app.sessions().operator(session).ok_or_else(Problem::no_session)?;
    operator.take(app.now()).map_err(StationError::from)?;
    Ok(operator)
}

/// An operator's session that holds control, or takes it now because it is free: may command.
pub struct Pilot {
    /// The session.
    pub session: SessionId,
    operator: Arc<Operating>,
    confirmation: Option<String>,
}

impl Pilot {
    /// Handle to a vehicle that acts in this session's name.
    pub fn vehicle(&self, vehicle: &VehicleHandle) -> VehicleHandle {
        vehicle.acting_as(self.operator.clone())
    }

    /// Sends a request to a vehicle in this session's name, with the confirmation of the HTTP request.
    pub fn request(&self, vehicle: &VehicleHandle, request: Act) -> Pending<RequestResult> {
        self.vehicle(vehicle).request_confirmed(request, self.confirmation.as_deref())
    }

    /// The same, and waits for the end, which comes within a bounded time. A disconnecting client does not cancel the
    /// command.
    ///
    /// # Errors
    /// The vehicle's refusal or failure, and when the server is closed.
    pub async fn ask(
        &self,
        vehicle: &VehicleHandle,
        DespiteMixedPlan(despite): DespiteMixedPlan,
        request: Act,
    ) -> Result<Reply, Problem> {
        let request = if despite { Act::DespiteMixedPlan(Box::new(request)) } else { request };
        Ok(self.request(vehicle, request).wait().await.ok_or_else(Problem::closed)??)
    }

    /// Checks control again after the request's body has arrived, which may take minutes. Requests to vehicles check it
    /// themselves.
    ///
    /// # Errors
    /// When another session holds control meanwhile, and when the session has ended.
    pub fn still_in_control(&self, app: &App) -> Result<(), Problem> {
        in_control(app, self.session).map(|_| ())
    }

    /// Confirmation sent with the request.
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

/// Path parameter `name`.
async fn path_param(parts: &mut Parts, app: &App, name: &str) -> Result<String, Problem> {
    let params = RawPathParams::from_request_parts(parts, app).await;
    let params = params.map_err(|_| Problem::invalid("the path is not UTF-8"))?;
    let found = params.iter().find(|(key, _)| *key == name).map(|(_, value)| value.to_owned());
    found.ok_or_else(|| Problem::invalid(format!("the path has no {name}")))
}

/// The vehicle named in the path.
pub struct Vehicle(pub VehicleHandle);

impl FromRequestParts<App> for Vehicle {
    type Rejection = Problem;

    async fn from_request_parts(parts: &mut Parts, app: &App) -> Result<Self, Problem> {
        let id = path_param(parts, app, "id").await?;
        let id = id.parse().map(VehicleId::new).map_err(|_| {
            let detail = format!("'{id}' is not a vehicle id; they are 1 to 255, and 256 to 65535 for remote vehicles");
            Problem::not_found(ResourceKind::Vehicle, &id, detail)
        })?;
        app.station().vehicle(id).map(Self).ok_or_else(|| {
            Problem::not_found(ResourceKind::Vehicle, id, format!("no vehicle with id {id} has been heard"))
                .remedy("GET /api/v1/vehicles lists those that were heard; check the link")
        })
    }
}

/// The number `id` of the path.
pub struct Id(pub u64);

impl FromRequestParts<App> for Id {
    type Rejection = Problem;

    async fn from_request_parts(parts: &mut Parts, app: &App) -> Result<Self, Problem> {
        let id = path_param(parts, app, "id").await?;
        id.parse().map(Self).map_err(|_| Problem::invalid_value("id", &id, "a whole number"))
    }
}

/// The text `id` of the path.
pub struct Text(pub String);

impl FromRequestParts<App> for Text {
    type Rejection = Problem;

    async fn from_request_parts(parts: &mut Parts, app: &App) -> Result<Self, Problem> {
        path_param(parts, app, "id").await.map(Self)
    }
}

/// The text `name` of the path.
pub struct Name(pub String);

impl FromRequestParts<App> for Name {
    type Rejection = Problem;

    async fn from_request_parts(parts: &mut Parts, app: &App) -> Result<Self, Problem> {
        path_param(parts, app, "name").await.map(Self)
    }
}

/// The text `place` of the path.
pub struct Place(pub String);

impl FromRequestParts<App> for Place {
    type Rejection = Problem;

    async fn from_request_parts(parts: &mut Parts, app: &App) -> Result<Self, Problem> {
        path_param(parts, app, "place").await.map(Self)
    }
}

/// A JSON body.
pub struct Json<T>(pub T);

impl<T: DeserializeOwned> FromRequest<App> for Json<T> {
    type Rejection = Problem;

    async fn from_request(request: Request, app: &App) -> Result<Self, Problem> {
        // Invalid JSON is rejected here.
        let axum::Json(body): axum::Json<Box<RawValue>> = axum::Json::from_request(request, app).await?;
        strict::read(body.get()).map(Self).map_err(Problem::invalid)
    }
}

/// A JSON body, or an empty one, which stands for all defaults.
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

/// Query parameter `despite_mixed_plan=true`: carry out the request although the mission on board may be a mixture or lead
/// out of reach.
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
