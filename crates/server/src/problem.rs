//! Error answers, as `application/problem+json` (RFC 9457): a [`Cause`] for programs, English texts for people.

use axum::extract::rejection::{BytesRejection, JsonRejection, QueryRejection};
use axum::http::{HeaderValue, StatusCode, header};
use axum::response::{IntoResponse, Response};
use std::collections::BTreeMap;
use std::fmt::{Debug, Display};

use utoipa::IntoResponses;
use utoipa::openapi::{ContentBuilder, Ref, RefOr, Response as Described, ResponseBuilder};
use vencejo_station::StationError;
use vencejo_vehicle::{Refusal, misread};

use crate::dto;
use crate::dto::cause::{Cause, LimitKind, ResourceKind};

mod from_core;

pub use self::from_core::{from_flight, from_maps, from_station};

/// Largest number of plan differences that are listed.
const MAX_REASONS: usize = 50;

/// Error of a handler.
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
    /// A problem: its type, status and title follow from the cause; `detail` says in English what was wrong, where, and
    /// how to correct it.
    pub fn new(cause: Cause, detail: impl Into<String>) -> Self {
        let (status, title) = cause.kind();
        Self(Box::new(dto::Problem {
            r#type: format!("urn:vencejo:{}", cause.code()),
            title: title.to_owned(),
            status: status.as_u16(),
            detail: detail.into(),
            reasons: Vec::new(),
            refusals: Vec::new(),
            remedy: None,
            cause,
        }))
    }

    /// Adds a remedy.
    #[must_use]
    pub fn remedy(mut self, remedy: impl Into<String>) -> Self {
        self.0.remedy = Some(remedy.into());
        self
    }

    /// Adds lines with details.
    #[must_use]
    pub fn reasons(mut self, reasons: impl IntoIterator<Item = String>) -> Self {
        self.0.reasons = reasons.into_iter().take(MAX_REASONS).collect();
        self
    }

    /// Adds the vehicle's texts, and remedies for them.
    fn refused(mut self, reasons: &[String], remedies: &[&str]) -> Self {
        self = self.reasons(reasons.iter().cloned());
        let refusals: Vec<_> = self.0.reasons.iter().map(|reason| Refusal::of(reason)).collect();
        if !remedies.is_empty() {
            self.0.remedy = Some(remedies.join("; "));
        }
        self.0.refusals = refusals.into_iter().map(|refusal| refusal.map(dto::RefusalCode::from)).collect();
        self
    }

    /// An invalid request.
    pub fn invalid(detail: impl Into<String>) -> Self {
        let detail = detail.into();
        Self::new(Cause::InvalidRequest { problem: detail.clone() }, detail)
    }

    /// An invalid value.
    pub fn invalid_value(field: &str, value: impl ToString, expected: &str) -> Self {
        let value = value.to_string();
        let detail = format!("{field} is {value}, should be {expected}");
        Self::new(Cause::InvalidValue { field: field.to_owned(), value, expected: expected.to_owned() }, detail)
    }

    /// A number out of its range.
    pub fn out_of_range<T: Display + Debug>(field: &str, value: T, low: T, high: T) -> Self {
        let mut shown = value.to_string();
        if shown.len() > 20 {
            // in scientific notation, where hundreds of digits would follow
            shown = format!("{value:?}");
        }
        Self::invalid_value(field, shown, &format!("{low} to {high}"))
    }

    /// A missing resource.
    pub fn not_found(what: ResourceKind, name: impl ToString, detail: impl Into<String>) -> Self {
        Self::new(Cause::NotFound { what, name: name.to_string() }, detail)
    }

    /// A missing session.
    pub fn no_session() -> Self {
        Self::new(Cause::NoSession, "this needs a session, and there is none or it has expired")
            .remedy("open one with POST /api/v1/session and the token from the server's terminal")
    }

    /// An unknown token.
    pub fn bad_token() -> Self {
        Self::new(Cause::BadToken, "this token is not one of this server's")
            .remedy("copy the whole address from the server's terminal")
    }

    /// A token from an address that has sent too many wrong ones.
    pub fn tokens_slowed(wait: std::time::Duration) -> Self {
        let wait_s = wait.as_secs().max(1);
        Self::new(Cause::TokensSlowed { wait_s }, "too many wrong tokens came from this address")
            .remedy(format!("wait {wait_s} s, then copy the whole address from the server's terminal"))
    }

    /// A request that viewers may not make.
    pub fn viewer() -> Self {
        Self::new(Cause::Role, "viewers may not do this").remedy("open a session with the operator's token")
    }

    /// A request that needs control, which is free or held by another session.
    pub fn no_control(holder: Option<&str>) -> Self {
        let cause = Cause::Control { holder: holder.map(str::to_owned) };
        match holder {
            Some(holder) => {
                Self::new(cause, format!("{holder} holds control")).remedy("ask for it: POST /api/v1/control/request")
            }
            None => Self::new(cause, "no session holds control").remedy("take it: POST /api/v1/control/take"),
        }
    }

    /// An exceeded limit.
    pub fn too_many(what: LimitKind, limit: usize, detail: impl Into<String>) -> Self {
        Self::new(Cause::TooMany { what, limit: limit as u64 }, detail)
    }

    /// The server is shutting down, or one of its tasks has died.
    pub fn closed() -> Self {
        Self::new(Cause::Closed, StationError::Closed.to_string())
    }
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

fn unreadable(status: StatusCode, text: String) -> Problem {
    match status {
        StatusCode::PAYLOAD_TOO_LARGE => Problem::new(Cause::BodyTooLarge, "the request's body is too large"),
        StatusCode::UNSUPPORTED_MEDIA_TYPE => {
            Problem::new(Cause::MediaType, "send JSON with `Content-Type: application/json`")
        }
        _ => {
            let mut problem = Problem::invalid(text);
            // Invalid JSON keeps its own status, for clients that look at the status only.
            problem.0.status = status.as_u16();
            problem
        }
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
        let text = rejection.body_text();
        let said = text.split_once("query string: ").map_or(text.as_str(), |(_, said)| said);
        let is_name = |path: &str| path.bytes().all(|byte| byte.is_ascii_alphanumeric() || byte == b'_');
        let (path, said) = said.split_once(": ").filter(|(path, _)| is_name(path)).unwrap_or(("", said));
        Self::invalid(misread::in_words(path, said, |name| misread::unit(name).map(str::to_owned)))
    }
}

#[cfg(test)]
mod tests;
