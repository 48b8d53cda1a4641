//! Sessions, control, and the WebSocket handshake.

use std::net::{IpAddr, Ipv4Addr};

use axum::Json;
use axum::extract::{ConnectInfo, State, WebSocketUpgrade};
use axum::http::{Extensions, HeaderMap, StatusCode, header};
use axum::response::{AppendHeaders, IntoResponse, Response};
use utoipa_axum::router::OpenApiRouter;
use utoipa_axum::routes;

use crate::door::Caller;
use crate::dto::cause::{Cause, LimitKind};
use crate::dto::{DeclinedRequest, NewSession, Role, SessionInfo};
use crate::extract::{InSession, Operator, OptionalJson};
use crate::problem::Problem;
use crate::sessions::{MAX_SESSIONS, MAX_SOCKETS, NotGiven, SessionId};
use crate::state::App;
use crate::tokens::{TokenStore, random_secret};
use crate::ws::{self, SocketGuard};

pub(super) fn router() -> OpenApiRouter<App> {
    OpenApiRouter::new()
        .routes(routes!(open_session, get_session, close_session))
        .routes(routes!(take_control))
        .routes(routes!(release_control))
        .routes(routes!(request_control))
        .routes(routes!(keep_control))
}

fn info(app: &App, id: SessionId) -> Result<Json<SessionInfo>, Problem> {
    app.sessions().info(id).map(Json).ok_or_else(Problem::no_session)
}

/// Opens a session, or returns the one of the cookie. An operator receives control when no session holds it.
#[utoipa::path(post, path = "/session", tag = "session", request_body = Option<NewSession>,
    responses((status = 200, body = SessionInfo, description = "Sets the session's cookie"), Problem))]
async fn open_session(
    State(app): State<App>,
    headers: HeaderMap,
    extensions: Extensions,
    OptionalJson(new): OptionalJson<NewSession>,
) -> Result<Response, Problem> {
    let now = app.now();
    let known = app.access().cookie(&headers).and_then(|secret| app.sessions().find(secret, now));
    let role = match (&app.access().tokens, &new.token) {
        (None, _) => Some(Role::Operator),
        (Some(tokens), Some(token)) => Some(role_of(&app, tokens, token, caller_of(&extensions))?),
        (Some(_), None) => None,
    };
    if let Some((id, known_role)) = known
        && role.is_none_or(|role| role == known_role)
    {
        return info(&app, id).map(IntoResponse::into_response);
    }
    let role = role.ok_or_else(Problem::no_session)?;
    let secret = random_secret()
        .map_err(|error| Problem::new(Cause::Internal, format!("the system cannot provide random numbers: {error}")))?;
    let opened = app.change_sessions(|sessions| sessions.open(secret.clone(), role, new.name.as_deref(), now));
    let opened = opened.ok_or_else(|| {
        Problem::too_many(LimitKind::Sessions, MAX_SESSIONS, "the limit of sessions is reached; close one, or wait")
    })?;
    let cookie = app.access().set_cookie(&secret);
    Ok((AppendHeaders([(header::SET_COOKIE, cookie)]), Json(opened)).into_response())
}

/// Client address for rate limiting; for IPv6 its network, in which a client can use any address.
fn caller_of(extensions: &Extensions) -> IpAddr {
    // Without a connection, the request is our own: a test.
    let caller = extensions.get::<ConnectInfo<Caller>>();
    caller.map_or(IpAddr::V4(Ipv4Addr::LOCALHOST), |ConnectInfo(caller)| caller.connection.from())
}

/// Role of a token, unless too many wrong tokens came from that address.
fn role_of(app: &App, tokens: &TokenStore, token: &str, from: IpAddr) -> Result<Role, Problem> {
    let now = app.now();
    if let Some(wait) = app.throttle().wait(from, now) {
        return Err(Problem::tokens_slowed(wait));
    }
    let Some(role) = tokens.now().role(token) else {
        app.throttle().wrong(from, now);
        return Err(Problem::bad_token());
    };
    app.throttle().right(from);
    Ok(role)
}

/// Returns the session of the cookie.
#[utoipa::path(get, path = "/session", tag = "session", responses((status = 200, body = SessionInfo), Problem))]
async fn get_session(State(app): State<App>, InSession(id): InSession) -> Result<Json<SessionInfo>, Problem> {
    info(&app, id)
}

/// Ends the session and releases control.
#[utoipa::path(delete, path = "/session", tag = "session", responses((status = 204), Problem))]
async fn close_session(State(app): State<App>, headers: HeaderMap, _: InSession) -> Response {
    let now = app.now();
    if let Some(secret) = app.access().cookie(&headers) {
        app.change_sessions(|sessions| sessions.close(secret, now));
    }
    let cookie = app.access().set_cookie("");
    (StatusCode::NO_CONTENT, AppendHeaders([(header::SET_COOKIE, cookie)])).into_response()
}

fn not_given(reason: NotGiven) -> Problem {
    match reason {
        NotGiven::NoSession => Problem::no_session(),
        NotGiven::Viewer => Problem::viewer(),
        NotGiven::Held(holder) => Problem::no_control(Some(&holder)),
    }
}

/// Takes control, if no other session holds it.
#[utoipa::path(post, path = "/control/take", tag = "session", responses((status = 200, body = SessionInfo), Problem))]
async fn take_control(State(app): State<App>, Operator(id): Operator) -> Result<Json<SessionInfo>, Problem> {
    let now = app.now();
    app.change_sessions(|sessions| sessions.take(id, now)).map_err(not_given)?;
    info(&app, id)
}

/// Releases control: to the session that requests it, if any. Also withdraws a request of this session.
#[utoipa::path(post, path = "/control/release", tag = "session", responses((status = 200, body = SessionInfo), Problem))]
async fn release_control(State(app): State<App>, Operator(id): Operator) -> Result<Json<SessionInfo>, Problem> {
    let now = app.now();
    app.change_sessions(|sessions| sessions.release(id, now));
    info(&app, id)
}

/// Requests control from the session that holds it; takes it when none does.
#[utoipa::path(post, path = "/control/request", tag = "session", responses((status = 200, body = SessionInfo), Problem))]
async fn request_control(State(app): State<App>, Operator(id): Operator) -> Result<Json<SessionInfo>, Problem> {
    let now = app.now();
    app.change_sessions(|sessions| sessions.request(id, now)).map_err(not_given)?;
    info(&app, id)
}

/// Declines the request of another operator for the control that this session holds. One that requests it by acting does
/// not request it again for five minutes, while this session holds control.
#[utoipa::path(post, path = "/control/keep", tag = "session", request_body = Option<DeclinedRequest>,
    responses((status = 200, body = SessionInfo), Problem))]
async fn keep_control(
    State(app): State<App>,
    Operator(id): Operator,
    OptionalJson(declined): OptionalJson<DeclinedRequest>,
) -> Result<Json<SessionInfo>, Problem> {
    let now = app.now();
    app.change_sessions(|sessions| sessions.decline(id, declined.requested_by.as_deref(), now));
    info(&app, id)
}

/// WebSocket handshake. OpenAPI cannot describe the WebSocket itself; its messages are in the schema.
pub(super) async fn websocket(
    State(app): State<App>,
    InSession(id): InSession,
    upgrade: WebSocketUpgrade,
) -> Result<Response, Problem> {
    let Some(alive) = app.alive() else { return Err(Problem::closed()) };
    // Counted before the upgrade, so that simultaneous requests cannot exceed the limit.
    let Some(place) = SocketGuard::open(app, id) else {
        let detail = "the limit of WebSockets is reached; close one";
        return Err(Problem::too_many(LimitKind::Sockets, MAX_SOCKETS, detail));
    };
    Ok(ws::bounded(upgrade, ws::MAX_MESSAGE_BYTES, ws::MAX_SENT_BYTES).on_upgrade(async move |socket| {
        ws::serve(place, socket).await;
        drop(alive);
    }))
}
