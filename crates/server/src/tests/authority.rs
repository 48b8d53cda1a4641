//! Permissions: every route for every role, confirmations of dangerous actions, and invalid bodies.

use std::collections::BTreeSet;
use std::pin::Pin;
use std::task::{Context, Poll, ready};

use axum::response::Response;
use futures_core::Stream;
use tokio::sync::oneshot;
use vencejo_station::FarWish;

use super::bodies::{described, filled};
use super::*;

/// What a route requires of a client.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Needs {
    /// Nothing.
    Nothing,
    /// A token, or a session.
    Token,
    /// A session.
    Session,
    /// An operator's session.
    Operator,
    /// An operator's session that holds control.
    Control,
}

/// Every route except those of self-describing requests, all of which need control. A route that is missing here fails
/// the test: a new route must state who may use it.
const ROUTES: &[(Needs, &[&str])] = &[
    (Needs::Nothing, &["GET /info"]),
    (Needs::Token, &["POST /session"]),
    (
        Needs::Session,
        &[
            "DELETE /session",
            "GET /cameras",
            "GET /cameras/{name}",
            "GET /cameras/{name}/snapshot",
            "GET /cameras/{name}/stream",
            "GET /commands",
            "GET /draft",
            "GET /elevation",
            "GET /footage",
            "GET /footage/{name}",
            "GET /history",
            "GET /history/{place}/{name}",
            "GET /links",
            "GET /networks",
            "GET /serial-ports",
            "GET /maps/areas",
            "GET /maps/areas/{id}",
            "GET /maps/areas/{id}/export",
            "GET /maps/kinds",
            "GET /maps/presets",
            "GET /maps/sources",
            "GET /maps/sources/{id}/attribution",
            "GET /maps/sources/{id}/image",
            "GET /operations",
            "GET /operations/{id}",
            "GET /plan/cameras",
            "GET /recorder",
            "GET /recordings",
            "GET /recordings/{name}",
            "GET /recordings/{name}/summary",
            "GET /replays",
            "GET /replays/{id}/marks",
            "GET /session",
            "GET /storage",
            "GET /tiles/{source}/{z}/{x}/{y}",
            "GET /vehicles",
            "GET /vehicles/{id}",
            "GET /vehicles/{id}/plan/fence",
            "GET /vehicles/{id}/plan/mission",
            "GET /vehicles/{id}/plan/rally",
            "GET /vehicles/{id}/profile",
            "GET /vehicles/{id}/signing",
            "GET /vehicles/{id}/texts",
            "GET /ws",
            "POST /elevation",
            "POST /elevation/profile",
            "POST /maps/areas/estimate",
            "POST /params/format",
            "POST /params/parse",
            "POST /plan/check",
            "POST /plan/complex-items",
            "POST /plan/fixes",
            "POST /plan/format",
            "POST /plan/frame",
            "POST /plan/landing",
            "POST /plan/landing/alternatives",
            "POST /plan/landing/move",
            "POST /plan/learn",
            "POST /plan/parse",
            "POST /plan/rehearse",
            "POST /plan/rehearse/spread",
            "POST /plan/separation",
            "POST /plan/survey",
            "POST /plan/way",
            "POST /plan/what-if",
            "POST /vehicles/{id}/plan/compare",
        ],
    ),
    (
        Needs::Operator,
        &[
            "DELETE /cameras/{name}/recording",
            "DELETE /draft",
            "DELETE /footage/{name}",
            "DELETE /maps/areas/{id}",
            "DELETE /maps/sources/{id}",
            "DELETE /maps/sources/{id}/cache",
            "DELETE /replays/{id}",
            "GET /maps/config",
            "GET /maps/files",
            "GET /vehicles/{id}/params",
            "GET /vehicles/{id}/params/{name}",
            "POST /cameras/{name}/recording",
            "POST /cameras/{name}/snapshot",
            "POST /control/keep",
            "POST /control/release",
            "POST /control/request",
            "POST /maps/areas",
            "POST /maps/areas/import",
            "POST /maps/areas/{id}/pause",
            "POST /maps/areas/{id}/resume",
            "POST /maps/capabilities",
            "POST /maps/files",
            "POST /maps/sources/{id}/check",
            "POST /vehicles/{id}/control/keep",
            "POST /vehicles/{id}/control/release",
            "POST /vehicles/{id}/control/request",
            "POST /vehicles/{id}/messages/{name}/request",
            "POST /vehicles/{id}/plan/fence/read",
            "POST /vehicles/{id}/plan/mission/read",
            "POST /vehicles/{id}/plan/rally/read",
            "PATCH /replays/{id}",
            "POST /replays",
            "PUT /draft",
            "PUT /maps/order",
            "PUT /maps/sources/{id}",
            "PUT /recordings/{name}/keep",
        ],
    ),
    (
        Needs::Control,
        &[
            "DELETE /links/{id}",
            "DELETE /operations/{id}",
            "DELETE /vehicles/{id}/plan/fence",
            "DELETE /vehicles/{id}/plan/mission",
            "DELETE /vehicles/{id}/plan/rally",
            // Refused to clients without that permission.
            "POST /control/take",
            "POST /links",
            "POST /vehicles/{id}/command/int",
            "POST /vehicles/{id}/command/long",
            "POST /vehicles/{id}/messages",
            "POST /vehicles/{id}/rival/follow",
            "POST /vehicles/{id}/signing",
            "PUT /heartbeat",
            "PUT /vehicles/{id}/messages/{name}/rate",
            "PUT /vehicles/{id}/params/{name}",
            "PUT /vehicles/{id}/plan/fence",
            "PUT /vehicles/{id}/plan/mission",
            "PUT /vehicles/{id}/plan/rally",
        ],
    ),
];

// fault 44: no session, viewer, operator without and with control at every route, the WebSocket included
#[tokio::test]
async fn every_role_at_every_route() {
    let station = station(true);
    let tokens = Tokens::random().expect("random");
    let server = Plain::new(station.clone(), Some(tokens.clone()));
    let requests = vencejo_vehicle::Request::described().into_iter();
    let requests: Vec<_> = requests.map(|request| format!("POST /vehicles/{{id}}/{}", request.name)).collect();
    let requests: Vec<_> = requests.iter().map(String::as_str).collect();
    let all = ROUTES.iter().copied().chain([(Needs::Control, requests.as_slice())]);
    let listed: BTreeSet<&str> = all.clone().flat_map(|(_, routes)| routes).copied().collect();
    let mut there: BTreeSet<String> = described().iter().map(|(method, path, _)| format!("{method} {path}")).collect();
    // OpenAPI does not describe WebSockets.
    there.insert("GET /ws".to_owned());
    assert_eq!(there.iter().map(String::as_str).collect::<BTreeSet<_>>(), listed, "each route has its row above");
    let viewer = server.session(json!({"token": tokens.viewer})).await;
    let pilot = server.session(json!({"token": tokens.operator, "name": "Ana"})).await;
    let other = server.session(json!({"token": tokens.operator, "name": "Luis"})).await;
    let mut checked = 0;
    for (needs, routes) in all {
        for route in routes {
            let (method, path) = route.split_once(' ').expect("method and path");
            let path = filled(path, "7");
            // Whatever the previous route did, Ana has control and no session requests it.
            server.ask("POST", "/control/release", Some(&other), None).await;
            server.ask("POST", "/control/take", Some(&pilot), None).await;
            for (who, cookie, expected) in [
                ("nobody", None, (needs != Needs::Nothing).then_some(401)),
                ("viewer", Some(&viewer), matches!(needs, Needs::Operator | Needs::Control).then_some(403)),
                ("operator without control", Some(&other), (needs == Needs::Control).then_some(423)),
                ("operator with control", Some(&pilot), None),
            ] {
                let cookie = match cookie {
                    // This ends the session.
                    Some(_) if *route == "DELETE /session" => Some(
                        server
                            .session(json!({"token": if who == "viewer" { &tokens.viewer } else { &tokens.operator }}))
                            .await,
                    ),
                    cookie => cookie.cloned(),
                };
                let status = server.ask(method, &path, cookie.as_deref(), None).await.status;
                match expected {
                    Some(expected) => assert_eq!(status, expected, "{route} by {who}"),
                    None => assert!(![401, 403, 423].contains(&status), "{route} by {who}: {status}"),
                }
                checked += 1;
            }
        }
    }
    assert_eq!(checked, listed.len() * 4);
    station.close().await;
}

// fault 28: 13 dangerous actions: a wrong, used or other action's confirmation is refused; with the right one, the
// action is carried out once
#[tokio::test]
async fn what_is_dangerous_is_done_once_and_only_confirmed() {
    let station = station(true);
    let double = double(&station).await;
    let server = Plain::new(station.clone(), None);
    let cookie = server.session(json!({"name": "Ana"})).await;
    let send = async |(method, path, body): &(&str, &str, Value), confirmation: Option<&str>| {
        let body = (!body.is_null()).then(|| body.clone());
        server.ask_confirmed(method, &format!("/vehicles/1{path}"), Some(&cookie), body, confirmation).await
    };
    let acts = [
        ("force-arm", ("POST", "/arm", json!({"force": true}))),
        ("force-arm", ("POST", "/command/long", json!({"command": 400, "params": [1, 21196]}))),
        ("force-disarm", ("POST", "/disarm", json!({"force": true}))),
        ("terminate", ("POST", "/command/long", json!({"command": "DO_FLIGHTTERMINATION", "params": [1]}))),
        ("terminate", ("POST", "/command/int", json!({"command": 185, "frame": 0, "params": [1]}))),
        ("clear-mission", ("DELETE", "/plan/mission", Value::Null)),
        ("clear-fence", ("DELETE", "/plan/fence", Value::Null)),
        ("clear-all", ("POST", "/messages", json!({"name": "MISSION_CLEAR_ALL", "fields": {"mission_type": 255}}))),
        ("reboot", ("POST", "/reboot", Value::Null)),
        ("reboot", ("POST", "/command/long", json!({"command": 246, "params": [1]}))),
        ("fence-off", ("PUT", "/params/FENCE_ENABLE", json!({"value": 0}))),
        ("fence-off", ("POST", "/command/long", json!({"command": 207}))),
        ("fence-off", ("POST", "/switch-fence", json!({"on": false}))),
    ];
    let challenge = async |act: &(&str, &str, Value), code: &str| {
        let answer = send(act, None).await;
        let problem = answer.json();
        assert_eq!((answer.status, &problem["cause"]["act"]), (428, &json!(code)), "{act:?}: {problem}");
        assert_eq!((&problem["cause"]["vehicle"], &problem["cause"]["valid_s"]), (&json!(1), &json!(15.0)));
        problem["cause"]["confirmation"].as_str().expect("a confirmation").to_owned()
    };
    let mut refused = 0;
    for (index, (code, act)) in acts.iter().enumerate() {
        for wrong in ["", "0", &"0".repeat(32), "ñ"] {
            assert_eq!(send(act, Some(wrong)).await.status, 412, "{act:?} with {wrong:?}");
            refused += 1;
        }
        let (_, another) = &acts[(index + 1) % acts.len()];
        let given = challenge(act, code).await;
        assert_eq!(send(another, Some(&given)).await.status, 412, "{given} is for {act:?}, not {another:?}");
        assert_eq!(send(act, Some(&given)).await.status, 412, "{act:?}: it was used");
        refused += 2;
    }
    // A harmless action does not accept a wrong confirmation either.
    assert_eq!(send(&("POST", "/arm", json!({})), Some("0")).await.status, 412);
    assert_eq!(refused, acts.len() * 6);
    let (code, arm) = &acts[0];
    let given = challenge(arm, code).await;
    // The simulated vehicle refuses it, which shows that it was sent.
    assert_eq!(send(arm, Some(&given)).await.status, 409);
    assert_eq!(send(arm, Some(&given)).await.status, 412, "once");
    let heard = double.heard.lock().expect("no panic").clone();
    assert_eq!(heard, ["COMMAND_LONG 400"], "nothing else of all that was sent");
    station.close().await;
}

/// A body that does not arrive until the test lets it.
struct Halted {
    /// Notified when the body is awaited.
    asked: Option<oneshot::Sender<()>>,
    rest: Option<oneshot::Receiver<String>>,
}

impl Stream for Halted {
    type Item = Result<String, oneshot::error::RecvError>;

    fn poll_next(mut self: Pin<&mut Self>, context: &mut Context<'_>) -> Poll<Option<Self::Item>> {
        if let Some(asked) = self.asked.take() {
            asked.send(()).expect("the test waits");
        }
        let Some(rest) = &mut self.rest else { return Poll::Ready(None) };
        let rest = ready!(Pin::new(rest).poll(context));
        self.rest = None;
        Poll::Ready(Some(rest))
    }
}

// fault 44: a session that ends while its request is half sent
#[tokio::test]
async fn a_request_ends_with_its_session() {
    let station = station(true);
    let double = double(&station).await;
    let server = Plain::new(station.clone(), None);
    let begin = async |ana: &str, method: &str, path: &str| {
        let ((asked, waits), (send_rest, rest)) = (oneshot::channel(), oneshot::channel());
        let request = Request::builder().method(method).uri(format!("/api/v1{path}")).header(header::HOST, "localhost");
        let request = request.header(header::COOKIE, ana).header(header::CONTENT_TYPE, "application/json");
        let body = Body::from_stream(Halted { asked: Some(asked), rest: Some(rest) });
        let answer = tokio::spawn(server.router.clone().oneshot(request.body(body).expect("a request")));
        waits.await.expect("it is let in, and its body awaited");
        (send_rest, answer)
    };
    let end = async |(send_rest, answer): (oneshot::Sender<String>, JoinHandle<Result<Response, _>>), body: &Value| {
        send_rest.send(body.to_string()).expect("it waits");
        answer.await.expect("no panic").expect("infallible").status().as_u16()
    };
    let requests = [
        ("POST", "/vehicles/1/command/long", json!({"command": "DO_CHANGE_SPEED", "params": [0, 33, -1]})),
        ("POST", "/vehicles/1/messages", json!({"name": "SYSTEM_TIME", "fields": {}})),
        ("POST", "/links", json!({"address": "udpin:127.0.0.1:0"})),
        ("PUT", "/heartbeat", json!({"enabled": false})),
    ];
    let links = station.links().len();
    for (method, path, body) in &requests {
        let ana = server.session(json!({"name": "Ana"})).await;
        let request = begin(&ana, method, path).await;
        let now = server.app.now();
        server.app.change_sessions(|sessions| sessions.revoke(crate::dto::Role::Operator, now));
        assert_eq!(end(request, body).await, 401, "{method} {path}");
        assert_eq!(server.app.sessions().holder_name(), None, "{method} {path}");
        // Control went to another session.
        let ana = server.session(json!({"name": "Ana"})).await;
        let request = begin(&ana, method, path).await;
        station.operator().take_over("Ana", station.now()).expect("by name");
        assert_eq!(end(request, body).await, 423, "{method} {path}");
        station.operator().release(station.now());
        server.ask("DELETE", "/session", Some(&ana), None).await;
    }
    assert_eq!(station.links().len(), links);
    assert_eq!(*double.heard.lock().expect("no panic"), [""; 0]);
    station.close().await;
}

#[tokio::test]
async fn control_of_a_remote_vehicle_is_asked_for_kept_and_given_back_by_who_has_control_here() {
    let station = station(true);
    let willing = Arc::new(Willing::default());
    let far = station.adopt("plane7", Address::new(1, 1), willing.clone()).expect("there is room");
    let server = Plain::new(station.clone(), None);
    let (ana, eva) = (server.session(json!({"name": "Ana"})).await, server.session(json!({"name": "Eva"})).await);
    let path = |act: &str| format!("/vehicles/{far}/control/{act}");
    let answer = server.ask("POST", &path("request"), Some(&ana), None).await;
    let held = json!({"holder": "tower · Luis", "is_held_here": false, "requested_by": "ground · Ana", "is_requested_here": true});
    assert_eq!((answer.status, answer.json()), (200, held.clone()));
    for (act, body) in [("keep", Some(json!({"requested_by": "tower · Luis"}))), ("keep", None), ("release", None)] {
        assert_eq!(server.ask("POST", &path(act), Some(&ana), body).await.status, 200);
    }
    assert_eq!(server.ask("POST", &path("request"), Some(&eva), None).await.status, 423, "Ana has control here");
    let keep = |requested_by: Option<&str>| FarWish::Keep { requested_by: requested_by.map(str::to_owned) };
    let wanted = [FarWish::Request, keep(Some("tower · Luis")), keep(None), FarWish::Release];
    assert_eq!(*willing.0.lock().expect("no panic"), wanted.map(|wish| (wish, "Ana".to_owned())));
    let vehicles = server.ask("GET", "/vehicles", Some(&ana), None).await.json();
    assert_eq!(vehicles[0]["control"], held);
    station.close().await;
}

// fault 31: a program and a page share one lease
#[tokio::test]
async fn a_program_and_a_browser_share_one_lease() {
    let station = station(true);
    let _double = double(&station).await;
    let server = Plain::new(station.clone(), None);
    let vehicle = station.vehicle(vencejo_proto::SystemId(1)).expect("heard");
    let ana = server.session(json!({"name": "Ana"})).await;
    let refused = vehicle.request(vencejo_vehicle::Request::Arm { force: false }).wait().await.expect("an end");
    let held = vencejo_station::StationError::Control { holder: "Ana".into(), vehicle: None };
    assert_eq!(refused, Err(held), "the page that came first has control");
    let read = vencejo_vehicle::Request::Note { severity: vencejo_vehicle::telemetry::Severity(6), text: "x".into() };
    assert!(vehicle.request(read).wait().await.expect("an end").is_ok(), "what acts on nothing needs none");
    station.operator().take_over("Ana", station.now()).expect("by name");
    let answer = server.ask("POST", "/vehicles/1/arm", Some(&ana), None).await;
    assert_eq!((answer.status, &answer.json()["cause"]["holder"]), (423, &json!("program")));
    let session = server.ask("GET", "/session", Some(&ana), None).await.json();
    assert_eq!((&session["has_control"], &session["holder"]), (&json!(false), &json!("program")));
    assert_eq!(server.ask("POST", "/control/take", Some(&ana), None).await.status, 423);
    let given = server.ask("POST", "/control/request", Some(&ana), None).await.json();
    assert_eq!(given["has_control"], true, "a program that does not look who asks gives way");
    server.ask("POST", "/control/release", Some(&ana), None).await;
    // Control is free: the first session that acts takes it.
    assert_eq!(server.ask("POST", "/vehicles/1/arm", Some(&ana), None).await.status, 409);
    assert_eq!(server.ask("GET", "/session", Some(&ana), None).await.json()["has_control"], true);
    station.close().await;
}
