//! Middleware around each request: the checks of its origin, and the security headers.

use axum::extract::{ConnectInfo, Request, State};
use axum::http::{HeaderName, HeaderValue, StatusCode, header};
use axum::middleware::Next;
use axum::response::{IntoResponse, Response};

use crate::door::Caller;
use crate::state::App;

/// What the page may load: map tiles from any server by https; everything else from this server only.
const CONTENT_SECURITY_POLICY: &str = "default-src 'self'; img-src 'self' data: blob: https:; connect-src 'self'; \
    style-src 'self'; style-src-attr 'unsafe-inline'; worker-src 'self' blob:; object-src 'none'; base-uri 'none'; \
    form-action 'self'; frame-ancestors 'none'";

/// Headers of every answer.
const HEADERS: [(HeaderName, &str); 7] = [
    (header::CONTENT_SECURITY_POLICY, CONTENT_SECURITY_POLICY),
    (header::X_CONTENT_TYPE_OPTIONS, "nosniff"),
    (header::X_FRAME_OPTIONS, "DENY"),
    // Tile servers require a referrer; they get the origin, never the path.
    (header::REFERRER_POLICY, "strict-origin-when-cross-origin"),
    (HeaderName::from_static("cross-origin-opener-policy"), "same-origin"),
    (HeaderName::from_static("cross-origin-resource-policy"), "same-origin"),
    (HeaderName::from_static("permissions-policy"), "camera=(), microphone=(), geolocation=(self)"),
];

/// Checks the origin of each request, and adds the headers to each answer.
pub async fn guard(State(app): State<App>, request: Request, next: Next) -> Response {
    let is_api = request.uri().path().starts_with("/api/");
    let mut answering = None;
    if let Some(ConnectInfo(Caller { connection, .. })) = request.extensions().get() {
        answering = connection.asked();
        if answering.is_none() {
            return StatusCode::SERVICE_UNAVAILABLE.into_response();
        }
        if !connection.has_session()
            && app.access().cookie(request.headers()).is_some_and(|it| app.sessions().knows(it))
        {
            connection.showed_session();
        }
    }
    let mut response = match app.access().check(request.uri(), request.headers()) {
        Ok(()) => next.run(request).await,
        Err(problem) => problem.into_response(),
    };
    let headers = response.headers_mut();
    for (name, value) in HEADERS {
        headers.insert(name, HeaderValue::from_static(value));
    }
    // Images set their own cache lifetime.
    if is_api && !headers.contains_key(header::CACHE_CONTROL) {
        headers.insert(header::CACHE_CONTROL, HeaderValue::from_static("no-store"));
    }
    if app.access().is_tls {
        headers.insert(header::STRICT_TRANSPORT_SECURITY, HeaderValue::from_static("max-age=31536000"));
    }
    match answering {
        Some(answering) => answering.until_sent(response),
        None => response,
    }
}
