//! The one table from the core's errors to `application/problem+json` (RFC 9457).

use axum::extract::rejection::{BytesRejection, JsonRejection, QueryRejection};
use axum::http::{HeaderValue, StatusCode, header};
use axum::response::{IntoResponse, Response};
use std::collections::BTreeMap;

use utoipa::IntoResponses;
use utoipa::openapi::{ContentBuilder, Ref, RefOr, Response as Described, ResponseBuilder};
use vencejo_flight::FlightError;
use vencejo_link::LinkError;
use vencejo_station::StationError;
use vencejo_vehicle::VehicleError;
use vencejo_vehicle::transfer::TransferError;

use crate::dto;

/// Differences of a plan that are listed at most.
const MAX_REASONS: usize = 50;

/// What a handler ends with when it cannot do what it was asked for.
#[derive(Debug, Clone, PartialEq)]
pub struct Problem(pub Box<dto::Problem>);

impl IntoResponses for Problem {
    fn responses() -> BTreeMap<String, RefOr<Described>> {
        let content = ContentBuilder::new().schema(Some(Ref::from_schema_name("Problem"))).build();
        let response = ResponseBuilder::new().description("What was wrong and what to do");
        let response = response.content("application/problem+json", content).build();
        BTreeMap::from([("default".to_owned(), RefOr::T(response))])
    }
}

impl Problem {
    /// A problem of a kind: `kind` is the stable end of its `type`.
    pub fn new(status: StatusCode, kind: &str, title: &str, detail: impl Into<String>) -> Self {
        Self(Box::new(dto::Problem {
            r#type: format!("urn:vencejo:{kind}"),
            title: title.to_owned(),
            status: status.as_u16(),
            detail: detail.into(),
            reasons: Vec::new(),
            remedy: None,
        }))
    }

    /// With what to do about it.
    #[must_use]
    pub fn remedy(mut self, remedy: impl Into<String>) -> Self {
        self.0.remedy = Some(remedy.into());
        self
    }

    fn reasons(mut self, reasons: impl IntoIterator<Item = String>) -> Self {
        self.0.reasons = reasons.into_iter().take(MAX_REASONS).collect();
        let mut remedies: Vec<&str> = Vec::new();
        for remedy in self.0.reasons.iter().filter_map(|reason| remedy_for(reason)) {
            if !remedies.contains(&remedy) {
                remedies.push(remedy);
            }
        }
        self.0.remedy = (!remedies.is_empty()).then(|| remedies.join("; "));
        self
    }

    /// The request makes no sense.
    pub fn invalid(detail: impl Into<String>) -> Self {
        Self::new(StatusCode::UNPROCESSABLE_ENTITY, "invalid-request", "Not a valid request", detail)
    }

    /// There is no such thing.
    pub fn not_found(detail: impl Into<String>) -> Self {
        Self::new(StatusCode::NOT_FOUND, "not-found", "Not found", detail)
    }

    /// Something that only a session may do.
    pub fn no_session() -> Self {
        Self::new(StatusCode::UNAUTHORIZED, "no-session", "No session", "this needs a session, and yours is not known")
            .remedy("open one with POST /api/v1/session, with the token that the server shows in its terminal")
    }

    /// A token that is none of ours.
    pub fn bad_token() -> Self {
        Self::new(StatusCode::UNAUTHORIZED, "bad-token", "Wrong token", "this token is not one of this server's")
            .remedy("copy the whole address from the server's terminal")
    }

    /// Something that viewers may not do.
    pub fn viewer() -> Self {
        Self::new(StatusCode::FORBIDDEN, "role", "Not allowed to a viewer", "this session may look but not command")
            .remedy("open a session with the operator's token")
    }

    /// Something that needs control, which another session has or nobody.
    pub fn no_control(holder: Option<&str>) -> Self {
        let problem = |detail: String| Self::new(StatusCode::LOCKED, "control", "Control is elsewhere", detail);
        match holder {
            Some(holder) => {
                problem(format!("{holder} holds control")).remedy("ask for it: POST /api/v1/control/request")
            }
            None => problem("nobody holds control".into()).remedy("take it: POST /api/v1/control/take"),
        }
    }

    /// Too much at once.
    pub fn too_many(detail: impl Into<String>) -> Self {
        Self::new(StatusCode::TOO_MANY_REQUESTS, "too-many", "Too much at once", detail)
    }

    /// The server is on its way down, or a task of it has died.
    pub fn closed() -> Self {
        from_station(&StationError::Closed)
    }
}

/// What helps against a vehicle's reason, where it is known. The texts are ArduPlane's.
fn remedy_for(reason: &str) -> Option<&'static str> {
    const REMEDIES: [(&str, &str); 6] = [
        ("RTL_AUTOLAND", "set parameter RTL_AUTOLAND to 2 (or 1), or take DO_LAND_START out of the mission"),
        ("mode not armable", "choose another mode, such as MANUAL or FBWA; AUTO arms only with a mission on board"),
        ("GPS", "wait until the GPS has a 3D fix, under open sky"),
        ("Compass", "move away from metal and magnets, or calibrate the compass"),
        ("Throttle", "bring the throttle stick to its lowest position"),
        ("attery", "check the battery: charge, connection, and the failsafe's limits"),
    ];
    REMEDIES.iter().find(|(word, _)| reason.contains(word)).map(|(_, remedy)| *remedy)
}

impl IntoResponse for Problem {
    fn into_response(self) -> Response {
        let status = StatusCode::from_u16(self.0.status).unwrap_or(StatusCode::INTERNAL_SERVER_ERROR);
        let mut response = (status, axum::Json(*self.0)).into_response();
        let kind = HeaderValue::from_static("application/problem+json");
        response.headers_mut().insert(header::CONTENT_TYPE, kind);
        response
    }
}

/// The problem for an error of the station.
pub fn from_station(error: &StationError) -> Problem {
    let problem = |status, kind, title| Problem::new(status, kind, title, error.to_string());
    match error {
        StationError::Vehicle(error) => from_vehicle(error),
        StationError::Address(_) => problem(StatusCode::UNPROCESSABLE_ENTITY, "link-address", "Not a link string"),
        StationError::Link(LinkError::UnknownLink(_)) => problem(StatusCode::NOT_FOUND, "not-found", "No such link"),
        StationError::Link(_) => problem(StatusCode::CONFLICT, "link", "The link cannot be opened"),
        StationError::NoVehicle { .. } => problem(StatusCode::NOT_FOUND, "no-vehicle", "No such vehicle"),
        StationError::Closed => problem(StatusCode::SERVICE_UNAVAILABLE, "closed", "The station is closed"),
        StationError::CannotRecord { .. } => {
            problem(StatusCode::INTERNAL_SERVER_ERROR, "recorder", "Nothing can be recorded")
        }
        _ => problem(StatusCode::INTERNAL_SERVER_ERROR, "internal", "Something went wrong"),
    }
}

/// The problem for an error of a vehicle.
pub fn from_vehicle(error: &VehicleError) -> Problem {
    let problem = |status, kind, title| Problem::new(status, kind, title, error.to_string());
    match error {
        VehicleError::CommandRefused { reasons, .. } => {
            problem(StatusCode::CONFLICT, "command-refused", "The vehicle refused").reasons(reasons.iter().cloned())
        }
        VehicleError::NotConfirmed { reasons, .. } => {
            problem(StatusCode::GATEWAY_TIMEOUT, "not-confirmed", "The vehicle does not show it")
                .reasons(reasons.iter().cloned())
        }
        VehicleError::CommandTimeout { .. } | VehicleError::MessageNotReceived { .. } => {
            problem(StatusCode::GATEWAY_TIMEOUT, "timeout", "The vehicle did not answer")
        }
        VehicleError::NotHeard { .. } => {
            problem(StatusCode::GATEWAY_TIMEOUT, "vehicle-lost", "The vehicle is not heard")
        }
        VehicleError::CommandBusy { .. } | VehicleError::TransferBusy { .. } => {
            problem(StatusCode::CONFLICT, "busy", "Something else is under way")
        }
        VehicleError::TooManyRequests { .. } => problem(StatusCode::TOO_MANY_REQUESTS, "too-many", "Too much at once"),
        VehicleError::Transfer(error) => from_transfer(error),
        VehicleError::UnknownMode(_) | VehicleError::NoModeFor { .. } => {
            problem(StatusCode::UNPROCESSABLE_ENTITY, "unknown-mode", "No such mode")
        }
        VehicleError::InvalidValue { .. } => {
            problem(StatusCode::UNPROCESSABLE_ENTITY, "invalid-request", "Not a valid request")
        }
        VehicleError::Plan(error) => from_flight(error),
        VehicleError::PlanUnknown { .. } => {
            problem(StatusCode::CONFLICT, "plan-unknown", "The plan on board is not known")
        }
        VehicleError::TooOld { .. } => problem(StatusCode::CONFLICT, "too-old", "The vehicle's firmware is too old"),
        VehicleError::Armed { .. } => problem(StatusCode::CONFLICT, "armed", "The vehicle is armed"),
        VehicleError::HomeUnknown => problem(StatusCode::CONFLICT, "home-unknown", "Home is not known"),
        VehicleError::Rebooted => problem(StatusCode::CONFLICT, "rebooted", "The vehicle restarted"),
        VehicleError::Cancelled => problem(StatusCode::CONFLICT, "cancelled", "Cancelled"),
        _ => problem(StatusCode::INTERNAL_SERVER_ERROR, "internal", "Something went wrong"),
    }
}

/// The problem for an error of a transfer.
pub fn from_transfer(error: &TransferError) -> Problem {
    let problem = |status, kind, title| Problem::new(status, kind, title, error.to_string());
    match error {
        TransferError::Timeout { .. } | TransferError::NoProgress { .. } => {
            problem(StatusCode::GATEWAY_TIMEOUT, "timeout", "The vehicle did not answer")
        }
        TransferError::Refused { .. } => problem(StatusCode::CONFLICT, "plan-refused", "The vehicle refused the plan"),
        TransferError::NotAsSent { differences, .. } => {
            problem(StatusCode::CONFLICT, "plan-mismatch", "The vehicle holds another plan")
                .reasons(differences.iter().map(ToString::to_string))
        }
        TransferError::Unverified { .. } => {
            problem(StatusCode::GATEWAY_TIMEOUT, "unverified", "What the vehicle holds is unknown")
        }
        TransferError::OnlyMission { .. } => {
            problem(StatusCode::CONFLICT, "only-mission", "The vehicle takes only its mission")
        }
        TransferError::IntegerItemsIgnored => problem(StatusCode::BAD_GATEWAY, "too-old", "The vehicle is too old"),
        TransferError::NotCleared { .. } => problem(StatusCode::CONFLICT, "not-cleared", "The plan is still on board"),
        TransferError::TooMany { .. } => problem(StatusCode::UNPROCESSABLE_ENTITY, "too-large", "Too large"),
        TransferError::BadList { .. } => {
            problem(StatusCode::UNPROCESSABLE_ENTITY, "invalid-request", "Not a valid request")
        }
        TransferError::Item(error) => from_flight(error),
        TransferError::Ftp { .. } | TransferError::BadFile { .. } => {
            problem(StatusCode::BAD_GATEWAY, "vehicle-file", "The vehicle's file cannot be used")
        }
        TransferError::FtpBusy { .. } => problem(StatusCode::CONFLICT, "busy", "Something else is under way"),
        TransferError::Param(_) => {
            problem(StatusCode::UNPROCESSABLE_ENTITY, "invalid-request", "Not a valid parameter")
        }
        TransferError::UnknownParam { .. } => problem(StatusCode::NOT_FOUND, "unknown-param", "No such parameter"),
        TransferError::ParamRefused { .. } | TransferError::ParamNotKept { .. } => {
            problem(StatusCode::CONFLICT, "param-refused", "The vehicle did not take the value")
        }
        TransferError::Cancelled => problem(StatusCode::CONFLICT, "cancelled", "Cancelled"),
        _ => problem(StatusCode::INTERNAL_SERVER_ERROR, "internal", "Something went wrong"),
    }
}

/// The problem for a plan or file that is none.
pub fn from_flight(error: &FlightError) -> Problem {
    Problem::new(StatusCode::UNPROCESSABLE_ENTITY, "invalid-plan", "Not a valid plan", error.to_string())
}

impl From<StationError> for Problem {
    fn from(error: StationError) -> Self {
        from_station(&error)
    }
}

impl From<FlightError> for Problem {
    fn from(error: FlightError) -> Self {
        from_flight(&error)
    }
}

fn unreadable(status: StatusCode, text: String) -> Problem {
    match status {
        StatusCode::PAYLOAD_TOO_LARGE => {
            Problem::new(status, "too-large", "Too large", "the request's body is too large")
        }
        StatusCode::UNSUPPORTED_MEDIA_TYPE => {
            Problem::new(status, "media-type", "Not JSON", "send JSON with `Content-Type: application/json`")
        }
        StatusCode::UNPROCESSABLE_ENTITY => Problem::invalid(text),
        _ => Problem::new(status, "bad-request", "The request cannot be read", text),
    }
}

impl From<JsonRejection> for Problem {
    fn from(rejection: JsonRejection) -> Self {
        unreadable(rejection.status(), rejection.body_text())
    }
}

impl From<BytesRejection> for Problem {
    fn from(rejection: BytesRejection) -> Self {
        unreadable(rejection.status(), rejection.body_text())
    }
}

impl From<QueryRejection> for Problem {
    fn from(rejection: QueryRejection) -> Self {
        unreadable(StatusCode::UNPROCESSABLE_ENTITY, rejection.body_text())
    }
}

#[cfg(test)]
mod tests;
