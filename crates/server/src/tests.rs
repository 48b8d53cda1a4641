//! The whole API: by plain calls, and over real sockets, with a vehicle that answers over UDP.

mod authority;
mod bodies;
mod cameras;
mod pressure;
mod storage;

use std::net::SocketAddr;
use std::sync::atomic::{AtomicU32, Ordering};
use std::sync::{Arc, Mutex};
use std::time::Duration;

use axum::Router;
use axum::body::Body;
use axum::http::{HeaderName, Method, Request, header};
use http_body_util::BodyExt;
use serde_json::{Value, json};
use tokio::io::{AsyncRead, AsyncWrite};
use tokio::net::{TcpStream, UdpSocket};
use tokio::runtime::Handle;
use tokio::sync::mpsc;
use tokio::task::JoinHandle;
use tokio::time::timeout;
use tokio_tungstenite::tungstenite::Message as WsMessage;
use tokio_tungstenite::tungstenite::client::IntoClientRequest;
use tokio_tungstenite::{WebSocketStream, client_async};
use tower::ServiceExt;
use vencejo_link::{LinkOptions, LinkState, RecorderState};
use vencejo_proto::{Address, CommandAck, FrameDecoder, Header, Heartbeat, MavVersion, Message, StatusText};
use vencejo_station::{Station, StationConfig};

use crate::Tokens;
use crate::access::Access;
use crate::dto::{ServerMessage, Text};
use crate::outbox::MAX_EVENTS;
use crate::state::{App, AppParts};
use crate::ws::MAX_SENT_BYTES;
use crate::{Server, ServerConfig, ServerError, routes};

/// Time limit of a step; a hang fails the test.
pub const PATIENCE: Duration = Duration::from_secs(20);

pub fn station(heartbeat: bool) -> Station {
    let config = StationConfig { request_streams: false, heartbeat, ..StationConfig::default() };
    Station::start(config, Handle::current()).expect("a station")
}

/// The handlers without a socket.
pub struct Plain {
    app: App,
    router: Router,
    _ended: mpsc::Receiver<()>,
}

pub struct Answer {
    pub status: u16,
    cookie: Option<String>,
    kind: String,
    notes: Option<String>,
    body: Vec<u8>,
}

impl Answer {
    pub fn json(&self) -> Value {
        serde_json::from_slice(&self.body)
            .unwrap_or_else(|error| panic!("{error}: {:?}", String::from_utf8_lossy(&self.body)))
    }
}

impl Plain {
    pub fn new(station: Station, tokens: Option<Tokens>) -> Self {
        let (alive, _ended) = mpsc::channel(1);
        let bound = SocketAddr::from(([127, 0, 0, 1], 8765));
        let access =
            Access { tokens: tokens.map(Into::into), bound, is_tls: false, hosts: Vec::new(), origins: Vec::new() };
        let app = App::new(station, access, AppParts::default(), alive);
        Self { router: routes::router(app.clone()), app, _ended }
    }

    pub async fn send(&self, request: Request<Body>) -> Answer {
        let response = self.router.clone().oneshot(request).await.expect("infallible");
        let (status, headers) = (response.status().as_u16(), response.headers().clone());
        let text = |name| headers.get(name).and_then(|value| value.to_str().ok()).map(str::to_owned);
        let body = response.into_body().collect().await.expect("a body").to_bytes().to_vec();
        let cookie = text(header::SET_COOKIE).and_then(|cookie| Some(cookie.split(';').next()?.to_owned()));
        Answer {
            status,
            cookie,
            kind: text(header::CONTENT_TYPE).unwrap_or_default(),
            notes: text(HeaderName::from_static("vencejo-notes")),
            body,
        }
    }

    /// A request as a browser's own page makes it; with `body` as JSON, if any.
    pub async fn ask(&self, method: &str, path: &str, cookie: Option<&str>, body: Option<Value>) -> Answer {
        self.ask_confirmed(method, path, cookie, body, None).await
    }

    /// The same, with a confirmation issued by the station.
    pub async fn ask_confirmed(
        &self,
        method: &str,
        path: &str,
        cookie: Option<&str>,
        body: Option<Value>,
        confirmation: Option<&str>,
    ) -> Answer {
        let mut request =
            Request::builder().method(method).uri(format!("/api/v1{path}")).header(header::HOST, "localhost");
        for (name, value) in [(header::COOKIE.as_str(), cookie), (crate::extract::CONFIRMATION, confirmation)] {
            if let Some(value) = value {
                request = request.header(name, value);
            }
        }
        let request = match body {
            Some(body) => request.header(header::CONTENT_TYPE, "application/json").body(Body::from(body.to_string())),
            None => request.body(Body::empty()),
        };
        self.send(request.expect("a request")).await
    }

    pub async fn session(&self, body: Value) -> String {
        let answer = self.ask("POST", "/session", None, Some(body)).await;
        assert_eq!(answer.status, 200, "{}", answer.json());
        answer.cookie.expect("a cookie")
    }
}

/// A vehicle that sends heartbeats and refuses to arm, with a reason.
struct Double {
    /// Our heartbeats that it received.
    heartbeats: Arc<AtomicU32>,
    /// Other messages received that could change something.
    heard: Arc<Mutex<Vec<String>>>,
    task: JoinHandle<()>,
}

impl Drop for Double {
    fn drop(&mut self) {
        self.task.abort();
    }
}

async fn double(station: &Station) -> Double {
    double_of(station, 1).await
}

/// The same, with several components that all send heartbeats.
async fn double_of(station: &Station, components: u8) -> Double {
    let link = station.open_link("udpin:127.0.0.1:0", LinkOptions::default()).expect("a link");
    let local = loop {
        let is_up = station.links().iter().any(|(info, _)| matches!(info.state, LinkState::Up { .. }));
        match station.local_address(link) {
            Some(local) if is_up => break local,
            _ => tokio::time::sleep(Duration::from_millis(1)).await,
        }
    };
    let socket = UdpSocket::bind("127.0.0.1:0").await.expect("a socket");
    socket.connect(local).await.expect("connected");
    let heartbeats = Arc::new(AtomicU32::new(0));
    let heard = Arc::default();
    let task = tokio::spawn(fly(socket, components, heartbeats.clone(), Arc::clone(&heard)));
    station.wait_vehicle(None).wait().await.expect("open").expect("heard");
    Double { heartbeats, heard, task }
}

async fn fly(socket: UdpSocket, components: u8, heartbeats: Arc<AtomicU32>, heard: Arc<Mutex<Vec<String>>>) {
    let mut sequence = 0_u8;
    let mut frame_of = |component: u8, message: &Message| {
        sequence = sequence.wrapping_add(1);
        let header = Header { sequence, source: Address::new(1, component), version: MavVersion::V2 };
        message.encode(header).bytes().to_vec()
    };
    let mut beats = tokio::time::interval(Duration::from_millis(50));
    let mut decoder = FrameDecoder::new();
    let mut buffer = [0_u8; 2048];
    loop {
        tokio::select! {
            _ = beats.tick() => {
                let heartbeat = Heartbeat { mav_type: 1, autopilot: 3, mavlink_version: 3, system_status: 3, ..Heartbeat::default() };
                for component in 1..=components {
                    // The station may be gone by the end of a test.
                    let _ = socket.send(&frame_of(component, &Message::Heartbeat(heartbeat))).await;
                }
            }
            Ok(length) = socket.recv(&mut buffer) => {
                decoder.push(&buffer[..length]);
                while let Some(received) = decoder.next_frame() {
                    let told = match received.decode() {
                        Ok(Message::CommandLong(command)) if command.command != 512 => Some(format!("COMMAND_LONG {}", command.command)),
                        Ok(Message::Dialect(message)) => {
                            let name = Message::Dialect(message).name();
                            (name != "TIMESYNC").then(|| name.to_owned())
                        }
                        Ok(Message::CommandInt(command)) => Some(format!("COMMAND_INT {}", command.command)),
                        _ => None,
                    };
                    heard.lock().expect("no panic").extend(told);
                    match received.decode() {
                        Ok(Message::Heartbeat(_)) => { heartbeats.fetch_add(1, Ordering::SeqCst); }
                        Ok(Message::CommandLong(command)) if command.command == 400 => {
                            let text = "DO_LAND_START set and RTL_AUTOLAND disabled".to_owned();
                            let text = StatusText { severity: 2, text, id: 0, chunk_seq: 0 };
                            let _ = socket.send(&frame_of(1, &Message::StatusText(text))).await;
                            let ack = CommandAck {
                                command: 400, result: 4, progress: 0, result_param2: 0, target: received.source(),
                            };
                            let _ = socket.send(&frame_of(1, &Message::CommandAck(ack))).await;
                        }
                        _ => {}
                    }
                }
            }
        }
    }
}

#[test]
fn the_committed_description_is_the_one_that_is_served() {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../../schemas/openapi.json");
    let committed = std::fs::read_to_string(path).expect("schemas/openapi.json");
    assert!(
        committed == crate::openapi(),
        "schemas/openapi.json is old: cargo run -p vencejo-server --example openapi > schemas/openapi.json"
    );
}

#[tokio::test]
async fn an_operation_is_cancelled_by_its_session_or_the_holder_of_control() {
    let station = station(true);
    let _double = double(&station).await;
    let server = Plain::new(station.clone(), None);
    let [pilot, reader, other] = [
        server.session(json!({"name": "Ana"})).await,
        server.session(json!({"name": "Luis"})).await,
        server.session(json!({"name": "Eva"})).await,
    ];
    let taken = server.ask("POST", "/control/take", Some(&pilot), None).await;
    assert!(taken.status < 300, "{}", taken.status);
    for who in [&reader, &pilot] {
        // The vehicle does not answer, so the operation runs until it is cancelled.
        let begun = server.ask("GET", "/vehicles/1/params", Some(&reader), None).await.json();
        let path = format!("/operations/{}", begun["id"]);
        assert_eq!(server.ask("DELETE", &path, Some(&other), None).await.status, 423);
        assert_eq!(server.ask("GET", &path, None, None).await.json()["state"], "running");
        assert_eq!(server.ask("DELETE", &path, Some(who), None).await.status, 202);
        while server.ask("GET", &path, None, None).await.json()["state"] == "running" {
            tokio::time::sleep(Duration::from_millis(1)).await;
        }
        assert_eq!(server.ask("GET", &path, None, None).await.json()["state"], "cancelled");
    }
}

#[tokio::test]
async fn operations_are_numbered_above_those_of_an_earlier_run() {
    let station = station(true);
    let _double = double(&station).await;
    let mut last = crate::state::now_unix_us() / 1000;
    let server = Plain::new(station.clone(), None);
    let pilot = server.session(json!({})).await;
    for _ in 0..2 {
        let begun = server.ask("GET", "/vehicles/1/params", Some(&pilot), None).await.json();
        let id = begun["id"].as_u64().expect("it is under way");
        assert!(id > last && id < 1 << 53, "{id} after {last}");
        last = id;
        assert_eq!(server.ask("DELETE", &format!("/operations/{id}"), Some(&pilot), None).await.status, 202);
        while server.ask("GET", &format!("/operations/{id}"), None, None).await.json()["state"] == "running" {
            tokio::time::sleep(Duration::from_millis(1)).await;
        }
    }
    station.close().await;
}

// fault 44: no session, viewer, operator with and without control at 15 routes
#[tokio::test]
async fn who_may_do_what() {
    let station = station(true);
    let _double = double(&station).await;
    let tokens = Tokens::random().expect("random");
    let server = Plain::new(station.clone(), Some(tokens.clone()));
    let viewer = server.session(json!({"token": tokens.viewer})).await;
    let pilot = server.session(json!({"token": tokens.operator, "name": "Ana"})).await;
    let other = server.session(json!({"token": tokens.operator, "name": "Luis"})).await;
    let mut checked = 0;
    let looks =
        [("GET", "/vehicles"), ("GET", "/vehicles/1"), ("GET", "/links"), ("GET", "/operations"), ("GET", "/commands")];
    let reads = [("GET", "/vehicles/1/params/NOT A NAME AT ALL")];
    let commands = [
        ("POST", "/vehicles/1/arm"),
        ("POST", "/vehicles/1/mode"),
        ("PUT", "/vehicles/1/plan/mission"),
        ("DELETE", "/vehicles/1/plan/fence"),
        ("PUT", "/vehicles/1/params/X"),
        ("POST", "/links"),
        ("DELETE", "/links/99"),
        ("DELETE", "/operations/99"),
        ("POST", "/vehicles/1/reboot"),
    ];
    let sessions = [
        (None, [401, 401, 401]),
        (Some(&viewer), [200, 403, 403]),
        (Some(&other), [200, 0, 423]),
        (Some(&pilot), [200, 0, 0]),
    ];
    for (cookie, [look, read, command]) in sessions {
        let rows = [(looks.as_slice(), look), (reads.as_slice(), read), (commands.as_slice(), command)];
        for (paths, expected) in rows {
            for (method, path) in paths {
                if expected == 0 && *path == "/vehicles/1/reboot"
                    || expected == 0 && *method == "DELETE" && path.contains("plan")
                {
                    continue; // would wait for a vehicle that does not answer
                }
                let path = path.replace(' ', "%20");
                let answer = server.ask(method, &path, cookie.map(String::as_str), None).await;
                let status = answer.status;
                if expected == 0 {
                    assert!(![401, 403, 423].contains(&status), "{method} {path}: {status}");
                } else {
                    assert_eq!(status, expected, "{method} {path} with {cookie:?}");
                }
                checked += 1;
            }
        }
    }
    assert!(checked > 50, "{checked}");
    assert_eq!(server.ask("POST", "/session", None, Some(json!({"token": "guess"}))).await.status, 401);
    assert_eq!(server.ask("POST", "/session", None, Some(json!({}))).await.status, 401);
    assert_eq!(server.ask("GET", "/vehicles", Some("vencejo_session_8765=guess"), None).await.status, 401);
    assert_eq!(server.ask("GET", "/info", None, None).await.json()["needs_token"], true);
    station.close().await;
}

#[tokio::test]
async fn control_is_handed_from_one_to_the_other() {
    let server = Plain::new(station(true), None);
    let ana = server.session(json!({"name": "Ana"})).await;
    let luis = server.session(json!({"name": "Luis"})).await;
    let ask = async |cookie: &str, path| server.ask("POST", path, Some(cookie), None).await;
    let refused = ask(&luis, "/control/take").await;
    assert_eq!((refused.status, refused.kind.as_str()), (423, "application/problem+json"));
    assert!(refused.json()["detail"].as_str().expect("text").contains("Ana"));
    assert_eq!(ask(&luis, "/control/request").await.json()["has_control"], false);
    let asked = server.ask("GET", "/session", Some(&ana), None).await.json();
    assert_eq!((asked["has_control"].as_bool(), asked["requested_by"].as_str()), (Some(true), Some("Luis")));
    let keep = async |body| server.ask("POST", "/control/keep", Some(&ana), body).await.json();
    assert_eq!(keep(Some(json!({"requested_by": "Eva"}))).await["requested_by"], "Luis");
    assert_eq!(keep(Some(json!({"requested_by": "Luis"}))).await["requested_by"], json!(null));
    ask(&luis, "/control/request").await;
    assert_eq!(keep(None).await["requested_by"], json!(null));
    ask(&luis, "/control/request").await;
    ask(&ana, "/control/release").await;
    assert_eq!(server.ask("GET", "/session", Some(&luis), None).await.json()["has_control"], true);
    let again = server.ask("POST", "/session", Some(&luis), Some(json!({}))).await;
    assert_eq!(again.json()["name"], "Luis", "a page that is loaded again keeps its session");
    assert_eq!(server.ask("DELETE", "/session", Some(&luis), None).await.status, 204);
    assert_eq!(ask(&luis, "/control/take").await.status, 401);
    assert_eq!(ask(&ana, "/control/take").await.json()["has_control"], true);
}

// fault 41: Origin of another site and null: 403
// fault 42: another Host: 403 at pages, API and WebSocket
#[tokio::test]
async fn requests_from_elsewhere_are_refused_whatever_they_want() {
    let server = Plain::new(station(true), None);
    for path in ["/", "/api/v1/info", "/api/v1/ws", "/assets/x.js", "/api/v1/session"] {
        for (host, origin) in
            [("evil.example", None), ("localhost", Some("http://evil.example")), ("localhost", Some("null"))]
        {
            let mut request = Request::builder().uri(path).header(header::HOST, host);
            if let Some(origin) = origin {
                request = request.header(header::ORIGIN, origin);
            }
            let answer = server.send(request.body(Body::empty()).expect("a request")).await;
            assert_eq!(answer.status, 403, "{path} from {host} {origin:?}");
        }
    }
}

// fault 46: Content-Security-Policy: own scripts only, no eval, no frames
#[tokio::test]
async fn every_answer_keeps_the_page_to_itself() {
    let server = Plain::new(station(true), None);
    for path in ["/", "/api/v1/info", "/api/v1/nothing"] {
        let request = Request::builder().uri(path).header(header::HOST, "localhost").body(Body::empty());
        let response = server.router.clone().oneshot(request.expect("a request")).await.expect("infallible");
        let headers = response.headers();
        let policy = headers[header::CONTENT_SECURITY_POLICY].to_str().expect("text");
        assert!(policy.starts_with("default-src 'self'") && policy.contains("frame-ancestors 'none'"), "{policy}");
        assert!(!policy.contains("unsafe-eval") && !policy.contains("script-src"), "scripts are our own: {policy}");
        assert_eq!(headers[header::X_CONTENT_TYPE_OPTIONS], "nosniff");
        assert!(!headers.contains_key(header::ACCESS_CONTROL_ALLOW_ORIGIN));
    }
}

#[tokio::test]
async fn a_mission_that_may_be_mixed_is_flown_only_by_name() {
    let station = station(true);
    let _double = double(&station).await;
    let server = Plain::new(station.clone(), None);
    let cookie = server.session(json!({"name": "Ana"})).await;
    let cookie = Some(cookie.as_str());
    // An upload that starts and never ends.
    let begins = json!({"name": "MISSION_COUNT", "fields": {"count": 9}});
    let asked = server.ask("POST", "/vehicles/1/messages", cookie, Some(begins.clone())).await.json();
    let confirmation = asked["cause"]["confirmation"].as_str();
    let sent = server.ask_confirmed("POST", "/vehicles/1/messages", cookie, Some(begins), confirmation).await;
    assert_eq!(sent.status, 200, "{}", sent.json());
    let state = server.ask("GET", "/vehicles/1", cookie, None).await.json()["plan_states"]["mission"].clone();
    assert_eq!((&state["may_be_mixed"], &state["reason"]), (&json!(true), &json!("sent_elsewhere")));
    let raw = |name, fields| Some(json!({"name": name, "fields": fields}));
    let arming = json!({"command": 400, "param1": 1});
    for (path, body) in [
        ("arm", None),
        ("mode", Some(json!({"mode": "AUTO"}))),
        ("mission/start", None),
        ("mission/resume", None),
        ("mission/current", Some(json!({"item": 2}))),
        ("command/long", Some(json!({"command": "COMPONENT_ARM_DISARM", "params": [1]}))),
        ("command/int", Some(json!({"command": "MISSION_START", "frame": 0, "params": [], "x": 0, "y": 0, "z": 0}))),
        ("messages", raw("COMMAND_LONG", arming.clone())),
        ("messages", raw("COMMAND_INT", arming)),
        ("messages", raw("SET_MODE", json!({"base_mode": 1, "custom_mode": 10}))),
        ("messages", raw("MISSION_SET_CURRENT", json!({"seq": 2}))),
    ] {
        let answer = server.ask("POST", &format!("/vehicles/1/{path}"), cookie, body.clone()).await;
        let problem = answer.json();
        assert_eq!(
            (answer.status, problem["type"].as_str()),
            (409, Some("urn:vencejo:plan-unknown")),
            "{path} {body:?}: {problem}"
        );
    }
    // With the parameter, the command reaches the vehicle, which refuses it for its own reason; the override is
    // recorded as an event.
    let path = "/vehicles/1/arm?despite_mixed_plan=";
    let answer = server.ask("POST", &format!("{path}true"), cookie, None).await;
    assert_eq!(answer.json()["type"], "urn:vencejo:command-refused");
    let jump = raw("MISSION_SET_CURRENT", json!({"seq": 2}));
    let answer = server.ask("POST", "/vehicles/1/messages?despite_mixed_plan=true", cookie, jump).await;
    assert_eq!(answer.status, 200);
    let texts = server.ask("GET", "/vehicles/1/texts", cookie, None).await.json().to_string();
    for act in ["arming", "jumping in the mission"] {
        assert!(texts.contains(&format!("{act} by override, although the mission on board is unknown")), "{texts}");
    }
    for (value, status) in [("false", 409), ("yes", 422)] {
        assert_eq!(server.ask("POST", &format!("{path}{value}"), cookie, None).await.status, status, "{value}");
    }
    station.close().await;
}

#[tokio::test]
async fn what_cannot_be_read_says_why() {
    let station = station(true);
    let _double = double(&station).await;
    let server = Plain::new(station.clone(), None);
    let session = server.session(json!({})).await;
    let cookie = Some(session.as_str());
    for (method, path, body, status) in [
        ("POST", "/vehicles/1/takeoff", Some(json!({"alt": 50})), 422),
        ("POST", "/vehicles/1/takeoff", Some(json!({"alt_rel_home_m": -5})), 422),
        ("POST", "/vehicles/1/takeoff", None, 422),
        ("POST", "/vehicles/1/mission/current", None, 422),
        ("POST", "/vehicles/1/request-message", Some(json!({"message": "ATTITUDES"})), 422),
        ("POST", "/vehicles/1/set-message-rate", Some(json!({"message": "ATTITUDE", "rate_hz": -1})), 422),
        ("PUT", "/vehicles/1/messages/ATTITUDE/rate", Some(json!({})), 422),
        ("POST", "/vehicles/1/mode", Some(json!({"mode": "NO_SUCH_MODE"})), 422),
        ("POST", "/vehicles/1/mission/current", Some(json!({"item": 0})), 422),
        ("POST", "/vehicles/1/home", Some(json!({"lat_deg": 40.0})), 422),
        ("POST", "/vehicles/1/goto", Some(json!({"lat_deg": 91, "lon_deg": 0, "alt_m": 50, "alt_frame": "home"})), 422),
        ("POST", "/vehicles/7/arm", None, 404),
        ("POST", "/vehicles/x/arm", None, 404),
        ("GET", "/vehicles/7", None, 404),
        ("GET", "/nothing", None, 404),
        ("GET", "/operations/7", None, 404),
        ("DELETE", "/links/7", None, 404),
        ("POST", "/links", Some(json!({"address": "nonsense"})), 422),
        ("POST", "/links", Some(json!({"address": "tlog:/etc/passwd"})), 422),
        ("POST", "/links", Some(json!({"address": " TLogReader:///etc/passwd"})), 422),
        ("POST", "/links", Some(json!({"address": "/etc/flight.tlog"})), 422),
        ("POST", "/links", Some(json!({"address": "flights/one.TLOG"})), 422),
        ("POST", "/links", Some(json!({"address": "C:\\flights\\one.tlog"})), 422),
        ("PATCH", "/links", None, 405),
        ("DELETE", "/draft?base=x", None, 422),
        ("DELETE", "/draft", None, 422),
        ("PUT", "/vehicles/1/plan/mission", Some(json!({"items": [{"command": 16, "frame": 3, "params": [1]}]})), 422),
        ("POST", "/plan/format", Some(json!({})), 422),
        ("POST", "/session", Some(json!({"name": "x".repeat(100_000)})), 413),
    ] {
        let answer = server.ask(method, path, cookie, body).await;
        assert_eq!(answer.status, status, "{method} {path}: {}", String::from_utf8_lossy(&answer.body));
        assert_eq!(answer.kind, "application/problem+json", "{method} {path}");
        assert_eq!(answer.json()["status"], status);
    }
    let twice = Request::builder().method("POST").uri("/api/v1/vehicles/1/disarm").header(header::HOST, "localhost");
    let twice = twice.header(header::COOKIE, &session).header(header::CONTENT_TYPE, "application/json");
    let twice = twice.body(Body::from(r#"{"force": false, "force": true}"#)).expect("a request");
    assert_eq!(server.send(twice).await.json()["detail"], "force is given twice");
    let query = server.ask("GET", "/elevation?lat_deg=north", cookie, None).await;
    assert_eq!(query.json()["detail"], "lat_deg is not a number (degrees)");
    let broken = Request::builder()
        .method(Method::POST)
        .uri("/api/v1/session")
        .header(header::HOST, "localhost")
        .header(header::CONTENT_TYPE, "application/json")
        .body(Body::from("{"));
    assert_eq!(server.send(broken.expect("a request")).await.status, 400);
    station.close().await;
}

#[tokio::test]
async fn a_refusal_comes_with_the_vehicles_reasons() {
    let station = station(true);
    let _double = double(&station).await;
    let server = Plain::new(station.clone(), None);
    let cookie = server.session(json!({})).await;
    let answer = server.ask("POST", "/vehicles/1/arm", Some(&cookie), None).await;
    let problem = answer.json();
    assert_eq!((answer.status, &problem["type"]), (409, &json!("urn:vencejo:command-refused")), "{problem}");
    assert_eq!(problem["reasons"], json!(["DO_LAND_START set and RTL_AUTOLAND disabled"]));
    assert!(problem["remedy"].as_str().expect("known").contains("RTL_AUTOLAND"));
    let state = server.ask("GET", "/vehicles/1", None, None).await.json();
    assert_eq!(state["telemetry"]["heartbeat"]["is_armed"], false);
    assert_eq!(state["plan_states"]["mission"]["state"], "unknown");
    let known = server.ask("GET", "/vehicles/1/plan/mission", None, None).await.json();
    assert_eq!(known, json!({"state": state["plan_states"]["mission"], "plan": null}));
    let compared =
        server.ask("POST", "/vehicles/1/plan/compare", Some(&cookie), Some(json!({"items": []}))).await.json();
    assert_eq!(compared, json!({"mission": null, "fence": null, "rally": null}), "unknown is not the same");
    assert!(state["mode_names"].as_array().expect("a list").contains(&json!("AUTO")));
    let texts = server.ask("GET", "/vehicles/1/texts", None, None).await.json();
    assert_eq!(texts[0]["severity"], 2);
    station.close().await;
}

#[tokio::test]
async fn plans_in_files_and_on_the_wire_are_the_same() {
    let server = Plain::new(station(true), None);
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../../python/vencejo/data/demo.waypoints");
    let file = std::fs::read(path).expect("the demo mission");
    let parse = |file: Vec<u8>| {
        let request = Request::builder().method("POST").uri("/api/v1/plan/parse?name=demo.waypoints");
        request.header(header::HOST, "localhost").body(Body::from(file)).expect("a request")
    };
    let plan = server.send(parse(file)).await.json();
    assert!(plan["items"].as_array().expect("items").len() > 5);
    for kind in ["plan", "waypoints", "kml", "kmz", "geojson", "csv"] {
        let written = server.ask("POST", &format!("/plan/format?as={kind}"), None, Some(plan.clone())).await;
        assert_eq!(written.status, 200);
        assert_eq!(server.send(parse(written.body)).await.json()["items"], plan["items"], "{kind}");
    }
    // The notes contain what a file does not preserve or state.
    let route = server.ask("POST", "/plan/format?as=gpx", None, Some(plan.clone())).await;
    assert_eq!(route.kind, "application/gpx+xml");
    let notes = |answer: &Answer| serde_json::from_str::<Value>(answer.notes.as_deref().expect("notes")).expect("JSON");
    let lost = notes(&route);
    assert_eq!(lost[0]["code"], "heights-written-above-sea-level", "{lost}");
    let read = server.send(parse(route.body)).await;
    let count = read.json()["items"].as_array().map(Vec::len);
    assert_eq!(notes(&read)[0], json!({"code": "heights-above-sea-level", "count": count}));
    let checked = server.ask("POST", "/plan/check", None, Some(json!({"plan": plan}))).await.json();
    assert_eq!(checked, json!([]), "the demo mission is a good one");
    let way = server.ask("POST", "/plan/way", None, Some(json!({"plan": plan}))).await.json();
    let first = &way["stops"][0];
    assert_eq!((&first["item"], &first["leg"]["kind"]), (&json!(1), &json!("takeoff")), "{first}");
    assert_eq!(first["leg"]["from_item"], Value::Null);
    assert!(way["stops"].as_array().expect("a list").iter().any(|stop| stop["loiter"]["kind"] == "turns"), "{way}");
    let ground = &way["profile"]["ground"];
    let places = ground["distance_m"].as_array().expect("a list").len();
    assert_eq!((ground["unknown"].as_u64(), &ground["lowest"]), (Some(places as u64), &Value::Null), "{ground}");
    let refused = server.ask("POST", "/plan/way", None, Some(json!({"plan": plan, "clearance_m": -1.0}))).await;
    assert_eq!(refused.status, 422);
    let mut bad = plan.clone();
    bad["items"][1]["params"][4] = json!(0.0);
    bad["items"][1]["params"][5] = json!(0.0);
    let found = server.ask("POST", "/plan/check", None, Some(json!({"plan": bad}))).await.json();
    assert!(found.as_array().expect("a list").iter().any(|finding| finding["item"] == 2), "{found}");
    assert_eq!(server.send(parse(b"<kml/>".to_vec())).await.status, 422);
}

#[tokio::test]
async fn a_landing_is_designed_as_the_core_does() {
    let server = Plain::new(station(true), None);
    let at = json!({"lat_deg": 40.3332, "lon_deg": -3.7978});
    let ask = async |body| server.ask("POST", "/plan/landing", None, Some(body)).await;
    let west = json!({"lat_deg": 40.3332, "lon_deg": -3.82});
    let landing = ask(json!({"at": at, "coming_from": west, "has_land_start": false})).await.json();
    let commands: Vec<_> = landing["items"].as_array().expect("items").iter().map(|item| &item["command"]).collect();
    assert_eq!(commands, [&json!(31), &json!(21)], "a circle down, and the landing");
    assert_eq!((&landing["direction"], &landing["final_m"]), (&json!("coming-from"), &json!(500.0)));
    assert_eq!(landing["cautions"][0]["code"], "ground-not-known");
    // The same from the plan that it is to end, without a significant wind.
    let waypoint = json!({"command": 16, "frame": 3, "params": [0, 0, 0, 0, 40.3332, -3.82, 80]});
    let ending = json!({"at": at, "plan": {"items": [waypoint]}, "has_land_start": false});
    assert_eq!(ask(ending.clone()).await.json()["items"], landing["items"]);
    let windy = json!({"at": at, "plan": ending["plan"], "wind": {"from_deg": 10.0, "speed_m_s": 5.0}});
    assert_eq!(ask(windy).await.json()["course_deg"], 10.0);
    let nowhere = ask(json!({"at": at})).await;
    assert_eq!((nowhere.status, nowhere.json()["cause"]["code"].clone()), (422, json!("landing-direction")));
    let gale = json!({"at": at, "course_deg": 0.0, "wind": {"from_deg": 90.0, "speed_m_s": 23.0}});
    assert_eq!(ask(gale).await.json()["cause"]["code"], "landing-wind");
    let steep = ask(json!({"at": at, "course_deg": 0.0, "slope": 0.5})).await.json();
    assert_eq!((&steep["cause"]["code"], &steep["cause"]["field"]), (&json!("invalid-value"), &json!("slope")));
    assert_eq!(ask(json!({"course_deg": 0.0})).await.status, 422, "neither point nor runway");
}

#[tokio::test]
async fn landings_to_choose_from_and_one_that_is_moved_are_the_cores() {
    let server = Plain::new(station(true), None);
    let (begin, end) =
        (json!({"lat_deg": 40.3332, "lon_deg": -3.7978}), json!({"lat_deg": 40.3332, "lon_deg": -3.7938}));
    let asked = json!({"runway": {"begin": begin, "end": end}, "wind": {"from_deg": 255.0, "speed_m_s": 6.0}});
    let found = server.ask("POST", "/plan/landing/alternatives", None, Some(asked.clone())).await.json();
    let best = &found[0];
    assert_eq!(found.as_array().map(Vec::len), Some(4));
    assert_eq!((&best["verdict"], &best["ending"]), (&json!("good"), &json!("landed")));
    assert_eq!(
        (&best["reasons"][0]["code"], &best["reasons"][0]["message"]),
        (&json!("headwind"), &json!("6 m/s of headwind"))
    );
    let designed = server.ask("POST", "/plan/landing", None, Some(asked)).await.json();
    assert_eq!(best["landing"]["course_deg"], designed["course_deg"]);

    let items = &designed["items"];
    let to = json!({"lat_deg": 40.3342, "lon_deg": -3.7958});
    let moved = json!({"items": items, "part": "point", "to": to});
    let moved = server.ask("POST", "/plan/landing/move", None, Some(moved)).await.json();
    assert_eq!(moved["items"][2]["params"][4], json!(40.3342));
    let home = json!({"lat_deg": 40.3332, "lon_deg": -3.7978, "alt_amsl_m": 690.0});
    let counted = json!({"plan": {"items": items, "home": home}, "frame": "amsl"});
    let counted = server.ask("POST", "/plan/frame", None, Some(counted)).await.json();
    assert_eq!(counted["unconverted"], json!([]));
    let homeless = json!({"plan": {"items": items}, "frame": "amsl", "vehicle": 77});
    let homeless = server.ask("POST", "/plan/frame", None, Some(homeless)).await.json();
    assert_eq!(homeless["items"][2]["params"], items[2]["params"]);
    assert_eq!(homeless["unconverted"][0], json!({"item": 1, "level": "home"}));
    let counted = &counted["items"];
    let before_m = items[2]["params"][6].as_f64().expect("a height");
    assert_eq!((&counted[2]["frame"], counted[2]["params"][6].as_f64()), (&json!(0), Some(before_m + 690.0)));
    let only = json!({"items": [items[2]], "part": "circle", "to": to});
    assert_eq!(server.ask("POST", "/plan/landing/move", None, Some(only)).await.status, 422);
}

#[tokio::test]
async fn a_survey_is_laid_out_as_the_core_does_and_goes_into_a_file() {
    let server = Plain::new(station(true), None);
    let ask = async |body| server.ask("POST", "/plan/survey", None, Some(body)).await;
    let cameras = server.ask("GET", "/plan/cameras", None, None).await.json();
    let camera =
        cameras.as_array().expect("a list").iter().find(|known| known["name"] == "Sony a6000 16mm").expect("known");
    let places = json!([
        {"lat_deg": 40.33, "lon_deg": -3.80}, {"lat_deg": 40.33, "lon_deg": -3.79}, {"lat_deg": 40.335, "lon_deg": -3.79},
    ]);
    let wind = json!({"from_deg": 30.0, "speed_m_s": 5.0});
    let asked = json!({"places": places, "camera": camera["camera"], "gsd_m": 0.03, "wind": wind, "vehicle": 1});
    let survey = ask(asked.clone()).await.json();
    assert_eq!((&survey["course_from"], &survey["flown"]["covered"]), (&json!("across-wind"), &json!(1.0)), "{survey}");
    assert_eq!(
        survey["flown"]["photos"].as_array().map(Vec::len),
        survey["flown"]["footprints"].as_array().map(Vec::len)
    );
    assert_eq!(survey["cautions"][0]["code"], "ground-not-known");
    // In a plan file it is one complex item, and is read back as such.
    let px4_vtol = json!({"cruise_speed_m_s": 21.0, "hover_speed_m_s": 5.0, "vehicle_type": 20, "firmware_type": 12});
    let plan =
        json!({"items": survey["items"], "complex_items": [survey["complex_item"]], "planned_for": px4_vtol.clone()});
    let file = server.ask("POST", "/plan/format?as=plan", None, Some(plan.clone())).await.body;
    let written: Value = serde_json::from_slice(&file).expect("JSON");
    assert_eq!(written["mission"]["items"][0]["complexItemType"], "survey");
    let request = Request::builder().method("POST").uri("/api/v1/plan/parse").header(header::HOST, "localhost");
    let read = server.send(request.body(Body::from(file)).expect("a request")).await.json();
    assert_eq!(read["items"], plan["items"]);
    assert_eq!((&read["complex_items"][0]["kind"], &read["planned_for"]), (&json!("survey"), &px4_vtol));
    // It can be designed again from this part; after editing its items by hand, it is no longer a survey.
    let parts_of = async |plan: &Value| {
        let plan = json!({"items": plan["items"], "complex_items": plan["complex_items"]});
        server.ask("POST", "/plan/complex-items", None, Some(plan)).await.json()[0].clone()
    };
    let part = parts_of(&read).await;
    assert_eq!((&part["first_item"], &part["count"]), (&json!(1), &json!(survey["items"].as_array().map(Vec::len))));
    let mut again = part["survey"].clone();
    again["vehicle"] = json!(1);
    assert_eq!(ask(again).await.json()["items"], plan["items"]);
    let mut edited = read.clone();
    edited["items"][0]["params"][6] = json!(50.0);
    assert_eq!(parts_of(&edited).await["first_item"], json!(null));
    let code = |answer: &Value| answer["cause"]["code"].clone();
    let mut bow = asked.clone();
    bow["places"] = json!([places[0], places[1], places[2], {"lat_deg": 40.325, "lon_deg": -3.795}]);
    let bow = ask(bow).await;
    assert_eq!((bow.status, code(&bow.json())), (422, json!("survey-crosses")));
    for (field, value, expected) in [
        ("gsd_m", json!(0.003), "survey-items"),
        ("gsd_m", json!(null), "bad-survey"),
        ("side_overlap", json!(2.0), "invalid-value"),
        ("wind", json!({"from_deg": 0.0, "speed_m_s": 30.0}), "survey-wind"),
    ] {
        let mut other = asked.clone();
        other[field] = value;
        assert_eq!(code(&ask(other).await.json()), json!(expected), "{field}");
    }
}

#[tokio::test]
async fn a_plan_is_rehearsed_as_the_core_does() {
    let server = Plain::new(station(true), None);
    let item = |command: u16, lat_deg: f64, alt_m: f64| json!({"command": command, "frame": 3, "params": [12.0, 0.0, 0.0, null, lat_deg, -3.7978, alt_m]});
    let home = json!({"lat_deg": 40.3332, "lon_deg": -3.7978, "alt_amsl_m": 600.0});
    let plan = |home: Value| json!({"home": home, "items": [item(22, 40.3332, 50.0), item(16, 40.35, 80.0)]});
    let ask = async |body| server.ask("POST", "/plan/rehearse", None, Some(body)).await;
    let flown = ask(json!({"plan": plan(home.clone()), "wind": {"from_deg": 270.0, "speed_m_s": 6.0}})).await.json();
    assert_eq!((&flown["ending"], &flown["airframe"]), (&json!("returned"), &json!("parameters")), "{flown}");
    assert_eq!(flown["passages"][1]["item"], 2);
    let fixes = server.ask("POST", "/plan/fixes", None, Some(json!({"plan": plan(home.clone())}))).await.json();
    let [hold, fix] = fixes.as_array().expect("a list").as_slice() else { panic!("{fixes}") };
    assert_eq!(
        (&hold["does"], &hold["with"]["value"], &hold["items"][0]["params"][0]),
        (&json!("set-param"), &json!(0.0), &json!(0.0))
    );
    assert_eq!((&fix["finding"]["code"], &fix["does"]), (&json!("no-landing"), &json!("add-landing")));
    assert_eq!((&fix["first_item"], &fix["count"], &fix["items"][1]["command"]), (&json!(3), &json!(0), &json!(21)));
    let count = flown["track"]["time_s"].as_array().expect("times").len();
    assert!(count > 10 && flown["track"]["item"].as_array().expect("items").len() == count);
    let along_m = flown["along_m"].as_array().expect("places in the profile");
    assert_eq!((along_m.len(), &flown["lowest"]), (count, &Value::Null), "no ground is known");
    let nowhere = ask(json!({"plan": plan(Value::Null)})).await;
    assert_eq!(nowhere.status, 422, "{:?}", nowhere.json());
    let gale = ask(json!({"plan": plan(home), "wind": {"from_deg": 270.0, "speed_m_s": 600.0}})).await;
    assert_eq!(gale.status, 422);
}

#[tokio::test]
async fn planned_flights_are_held_against_each_other() {
    let server = Plain::new(station(true), None);
    let item = |command: u16, lat_deg: f64, alt_m: f64| json!({"command": command, "frame": 3, "params": [12.0, 0.0, 0.0, null, lat_deg, -3.7978, alt_m]});
    let home = json!({"lat_deg": 40.3332, "lon_deg": -3.7978, "alt_amsl_m": 600.0});
    let plan = json!({"home": home, "items": [item(22, 40.3332, 50.0), item(16, 40.35, 80.0)]});
    let ask = async |body| server.ask("POST", "/plan/separation", None, Some(body)).await;
    let flights = |starts_s: f64| json!([{"plan": plan}, {"plan": plan, "starts_s": starts_s}]);
    let together = ask(json!({"flights": flights(0.0)})).await.json();
    let found = &together["conflicts"][0];
    assert_eq!((&found["flights"], &found["horizontal_m"]), (&json!([1, 2]), &json!(0.0)), "{together}");
    assert!(found["message"].as_str().expect("words").contains("flights 1 and 2 come within 0 m"));
    assert_eq!(together["limits"], json!({"horizontal_m": 100.0, "vertical_m": 30.0, "window_s": 10.0}));
    assert_eq!(together["flights"][0]["ending"], "returned");
    let ends_s = together["flights"][0]["ends_s"].as_f64().expect("an end");
    let apart = ask(json!({"flights": flights(ends_s + 11.0)})).await.json();
    assert_eq!((&apart["conflicts"], &apart["flights"][1]["starts_s"]), (&json!([]), &json!(ends_s + 11.0)));
    for wrong in [
        json!({"flights": [{"plan": plan}]}),
        json!({"flights": vec![json!({"plan": plan}); 33]}),
        json!({"flights": flights(-1.0)}),
        json!({"flights": flights(0.0), "window_s": -1.0}),
        json!({"flights": [{"plan": plan}, {"vehicle": 9}]}),
    ] {
        let answer = ask(wrong.clone()).await;
        assert_eq!(answer.status, 422, "{wrong}: {}", answer.json());
    }
}

pub type Ws = WebSocketStream<TcpStream>;

/// A stream that a WebSocket can use.
pub trait Stream: AsyncRead + AsyncWrite + Unpin {}

impl<S: AsyncRead + AsyncWrite + Unpin> Stream for S {}

async fn connect(server: &Server, cookie: &str, origin: Option<&str>) -> Result<Ws, u16> {
    connect_to(server, "/api/v1/ws", cookie, origin).await
}

pub async fn connect_to(server: &Server, path: &str, cookie: &str, origin: Option<&str>) -> Result<Ws, u16> {
    let address = server.address();
    let mut request = format!("ws://{address}{path}").into_client_request().expect("a request");
    request.headers_mut().insert("cookie", cookie.parse().expect("a cookie"));
    if let Some(origin) = origin {
        request.headers_mut().insert("origin", origin.parse().expect("an origin"));
    }
    let socket = tokio::net::TcpSocket::new_v4().expect("a socket");
    socket.set_recv_buffer_size(4096).expect("a small buffer");
    let stream = socket.connect(address).await.expect("connected");
    match client_async(request, stream).await {
        Ok((socket, _)) => Ok(socket),
        Err(tokio_tungstenite::tungstenite::Error::Http(response)) => Err(response.status().as_u16()),
        Err(error) => panic!("{error}"),
    }
}

/// Next message of a type; `None` when the connection ended.
async fn next<S: Stream>(socket: &mut WebSocketStream<S>, kind: &str) -> Option<Value> {
    let find = async {
        loop {
            match futures_next(socket).await {
                Some(Ok(WsMessage::Text(text))) => {
                    let value: Value = serde_json::from_str(&text).expect("JSON");
                    if value["type"] == kind {
                        return Some(value);
                    }
                }
                Some(Ok(WsMessage::Close(frame))) => {
                    return (kind == "close").then(|| {
                        let frame = frame.expect("a reason");
                        json!({"code": u16::from(frame.code), "reason": frame.reason.as_str()})
                    });
                }
                Some(Ok(_)) => {}
                Some(Err(_)) | None => return None,
            }
        }
    };
    timeout(PATIENCE, find).await.unwrap_or_else(|_| panic!("no {kind}"))
}

pub async fn futures_next<S: Stream>(
    socket: &mut WebSocketStream<S>,
) -> Option<Result<WsMessage, tokio_tungstenite::tungstenite::Error>> {
    use std::pin::Pin;
    std::future::poll_fn(|context| futures_core::Stream::poll_next(Pin::new(&mut *socket), context)).await
}

/// Sends a message; fails when the connection is gone.
pub async fn put<S: Stream>(
    socket: &mut WebSocketStream<S>,
    message: WsMessage,
) -> Result<(), tokio_tungstenite::tungstenite::Error> {
    use std::pin::Pin;

    use futures_sink::Sink;
    std::future::poll_fn(|context| Sink::poll_ready(Pin::new(&mut *socket), context)).await?;
    Sink::start_send(Pin::new(&mut *socket), message)?;
    std::future::poll_fn(|context| Sink::poll_flush(Pin::new(&mut *socket), context)).await
}

async fn say<S: Stream>(socket: &mut WebSocketStream<S>, message: Value) {
    put(socket, WsMessage::text(message.to_string())).await.expect("sent");
}

pub async fn serve(station: &Station, config: ServerConfig) -> Server {
    let config = ServerConfig { bind: SocketAddr::from(([127, 0, 0, 1], 0)), ..config };
    Server::start(station.clone(), config, &Handle::current()).await.expect("a server")
}

/// A session created in the server's own state, without HTTP.
pub fn cookie(server: &Server, name: &str) -> String {
    cookie_of(server.app(), name)
}

fn cookie_of(app: &App, name: &str) -> String {
    let now = app.now();
    let role = crate::dto::Role::Operator;
    app.change_sessions(|sessions| sessions.open(name.to_owned(), role, Some(name), now)).expect("a place");
    format!("{}={name}", app.access().cookie_name())
}

// fault 41: without a session 401, from another page 403
#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn the_websocket_sends_what_a_client_subscribed_to() {
    let station = station(true);
    let _double = double(&station).await;
    let server = serve(&station, ServerConfig::default()).await;
    let ana = cookie(&server, "ana");
    assert_eq!(connect(&server, "", None).await.err(), Some(401));
    assert_eq!(connect(&server, &ana, Some("http://evil.example")).await.err(), Some(403));
    let own = format!("http://{}", server.address());
    let mut socket = connect(&server, &ana, Some(&own)).await.expect("a WebSocket");
    let hello = next(&mut socket, "hello").await.expect("hello");
    assert_eq!((&hello["has_control"], &hello["role"]), (&json!(true), &json!("operator")));
    let vehicles = next(&mut socket, "vehicles").await.expect("vehicles");
    assert_eq!(vehicles["vehicles"][0]["system_id"], 1);
    say(&mut socket, json!({"type": "subscribe", "vehicle": 1, "rate_hz": 50})).await;
    for _ in 0..3 {
        let telemetry = next(&mut socket, "telemetry").await.expect("telemetry");
        assert_eq!(telemetry["groups"]["heartbeat"]["is_armed"], false, "{telemetry}");
    }
    say(&mut socket, json!({"type": "subscribe", "vehicle": 1, "rate_hz": 500})).await;
    assert!(next(&mut socket, "error").await.expect("an error")["detail"].as_str().expect("text").contains("1 to 50"));
    say(&mut socket, json!({"nonsense": 1})).await;
    next(&mut socket, "error").await.expect("an error");
    server.close().await;
    assert_eq!(next(&mut socket, "close").await.expect("a reason")["code"], 1001);
    station.close().await;
}

/// A remote aircraft that carries out all requests, and keeps a list of those for control.
#[derive(Default)]
pub struct Willing(pub Mutex<Vec<(vencejo_station::FarWish, String)>>);

impl vencejo_station::Remote for Willing {
    fn request(
        self: Arc<Self>,
        _: vencejo_vehicle::Request,
        _: Option<vencejo_vehicle::Danger>,
        _: String,
        _: vencejo_station::Telling,
    ) -> vencejo_station::Carried {
        Box::pin(std::future::ready(Ok(vencejo_vehicle::Reply::Done)))
    }

    fn control(self: Arc<Self>, wish: vencejo_station::FarWish, operator: String) -> vencejo_station::Carried {
        self.0.lock().expect("no panic").push((wish, operator));
        Box::pin(std::future::ready(Ok(vencejo_vehicle::Reply::Done)))
    }

    fn held(&self) -> vencejo_station::FarHeld {
        let (holder, requested_by) = (Some("tower · Luis".into()), Some("ground · Ana".into()));
        vencejo_station::FarHeld { holder, is_ours: false, requested_by, is_request_ours: true }
    }
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn the_roster_is_sent_whole_once_and_then_its_changes() {
    let station = station(true);
    let far = station.adopt("plane7", Address::new(1, 1), Arc::new(Willing::default())).expect("there is room");
    let heartbeat = |custom_mode| {
        let heartbeat = Heartbeat { mav_type: 1, autopilot: 3, custom_mode, ..Heartbeat::default() };
        [(Message::Heartbeat(heartbeat), station.now())]
    };
    station.on_remote(far, &heartbeat(10));
    let server = serve(&station, ServerConfig::default()).await;
    let mut socket = connect(&server, &cookie(&server, "ana"), None).await.expect("a WebSocket");
    let id = far.number();
    say(&mut socket, json!({"type": "subscribe_roster"})).await;
    let first = next(&mut socket, "roster").await.expect("the roster");
    let row = &first["rows"][0];
    assert_eq!((&row["id"], &row["remote_name"], &row["mode"]), (&json!(id), &json!("plane7"), &json!("AUTO")));
    assert_eq!((&row["holder"], &row["lat_deg"]), (&json!("tower · Luis"), &Value::Null));
    let asked = json!({"requested_by": "ground · Ana", "is_requested_here": true, "is_held_here": false});
    assert!(asked.as_object().expect("fields").iter().all(|(name, value)| row[name] == *value), "{row}");
    assert_eq!(first["followed"], json!([]));
    say(&mut socket, json!({"type": "subscribe", "vehicle": id, "rate_hz": 1})).await;
    // Once subscribed to its telemetry, the aircraft is among the followed ones.
    next(&mut socket, "telemetry").await.expect("telemetry");
    station.on_remote(far, &heartbeat(11));
    let changed = loop {
        let roster = next(&mut socket, "roster").await.expect("the roster");
        if roster["rows"][0]["mode"] == "RTL" {
            break roster;
        }
    };
    assert_eq!(
        changed["followed"][0]["system_id"], id,
        "what is followed comes with all that the list of vehicles says"
    );
    assert!(changed["rows"][0].get("remote_name").is_none(), "what is as before is not told: {changed}");
    // A client subscribed to the roster no longer receives the list, and receives it again after unsubscribing.
    say(&mut socket, json!({"type": "unsubscribe_roster"})).await;
    let vehicles = next(&mut socket, "vehicles").await.expect("vehicles");
    assert_eq!(vehicles["vehicles"][0]["system_id"], id);
    server.close().await;
    station.close().await;
}

// fault 47: 10,240 events: the other clients receive each, the slow one is disconnected
#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_slow_reader_is_let_go_and_the_others_hear_everything() {
    let station = station(true);
    let server = serve(&station, ServerConfig::default()).await;
    let (slow, quick) = (cookie(&server, "slow"), cookie(&server, "quick"));
    let mut slow = connect(&server, &slow, None).await.expect("a WebSocket");
    let mut quick = connect(&server, &quick, None).await.expect("a WebSocket");
    next(&mut slow, "hello").await.expect("hello");
    next(&mut quick, "hello").await.expect("hello");
    assert_eq!(server.clients(), 2);
    let texts = 20 * MAX_EVENTS;
    for number in 0..texts {
        let text = format!("{number} {}", "x".repeat(200));
        let text = Text { time_s: 0.0, unix_s: None, severity: 6, text };
        server.app().outboxes().put_event(&ServerMessage::Text { vehicle: 1, text });
        let heard = next(&mut quick, "text").await.expect("the quick one stays");
        assert!(heard["text"].as_str().expect("text").starts_with(&format!("{number} ")));
    }
    let gone = async {
        while server.clients() > 1 {
            tokio::time::sleep(Duration::from_millis(1)).await;
        }
    };
    timeout(PATIENCE, gone).await.expect("the slow one is let go");
    server.close().await;
    station.close().await;
}

/// Such as the assessment of a flight of hours.
#[tokio::test]
async fn a_long_message_ends_no_connection() {
    let station = station(true);
    let server = serve(&station, ServerConfig::default()).await;
    let mut client = connect(&server, &cookie(&server, "client"), None).await.expect("a WebSocket");
    for _ in 0..2 {
        let text = Text { time_s: 0.0, unix_s: None, severity: 6, text: "x".repeat(MAX_SENT_BYTES - 200) };
        server.app().outboxes().put_event(&ServerMessage::Text { vehicle: 1, text });
        let heard = next(&mut client, "text").await.expect("it comes");
        assert_eq!(heard["text"].as_str().map(str::len), Some(MAX_SENT_BYTES - 200));
    }
    server.close().await;
    station.close().await;
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn the_lease_ends_with_the_websocket() {
    let station = station(true);
    let server = serve(&station, ServerConfig::default()).await;
    let (ana, luis) = (cookie(&server, "ana"), cookie(&server, "luis"));
    let first = connect(&server, &ana, None).await.expect("a WebSocket");
    let mut second = connect(&server, &luis, None).await.expect("a WebSocket");
    assert_eq!(next(&mut second, "hello").await.expect("hello")["holder"], "ana");
    let app = server.app();
    let now = app.now();
    let luis_id = app.sessions().find("luis", now).expect("open").0;
    app.change_sessions(|sessions| sessions.request(luis_id, now)).expect("asked");
    assert_eq!(next(&mut second, "control").await.expect("control")["requested_by"], "luis");
    drop(first);
    let handed = next(&mut second, "control").await.expect("control");
    assert_eq!((&handed["has_control"], &handed["holder"]), (&json!(true), &json!("luis")));
    server.close().await;
    station.close().await;
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn on_board_heartbeats_need_an_operator() {
    let station = station(true);
    station.set_heartbeat(false);
    let server = serve(&station, ServerConfig { on_board: true, ..ServerConfig::default() }).await;
    let double = double(&station).await;
    assert_eq!(double.heartbeats.load(Ordering::SeqCst), 0);
    let ana = cookie(&server, "ana");
    let _socket = connect(&server, &ana, None).await.expect("a WebSocket");
    let heard = async {
        while double.heartbeats.load(Ordering::SeqCst) == 0 {
            tokio::time::sleep(Duration::from_millis(1)).await;
        }
    };
    timeout(PATIENCE, heard).await.expect("heartbeats while an operator is there");
    server.close().await;
    station.close().await;
}

// fault 40: 0.0.0.0 without tokens, or without TLS unless explicitly waived: refused
#[tokio::test]
async fn others_are_let_in_with_tokens_and_tls_only() {
    let station = station(true);
    let open = ServerConfig { bind: SocketAddr::from(([0, 0, 0, 0], 0)), plain_http: true, ..ServerConfig::default() };
    let error = Server::start(station.clone(), open.clone(), &Handle::current()).await.expect_err("refused");
    assert!(matches!(error, ServerError::NoTokens(_)), "{error}");
    let tokens = std::env::temp_dir().join(format!("vencejo-no-tls-{}.json", std::process::id()));
    let plain = ServerConfig { token_file: Some(tokens.clone()), plain_http: false, ..open };
    let error = Server::start(station.clone(), plain, &Handle::current()).await.expect_err("refused");
    assert!(matches!(error, ServerError::NoTls(_)) && error.to_string().contains("--plain-http"), "{error}");
    assert!(!tokens.exists(), "nothing is left behind");
    let server = serve(&station, ServerConfig::default()).await;
    let config = ServerConfig { bind: server.address(), ..ServerConfig::default() };
    let error = Server::start(station.clone(), config, &Handle::current()).await.expect_err("taken");
    assert!(error.to_string().contains("another port"), "{error}");
    server.close().await;
    server.close().await;
    station.close().await;
}

#[tokio::test]
async fn a_request_over_a_real_socket() {
    use tokio::io::{AsyncReadExt, AsyncWriteExt};
    let station = station(true);
    let server = serve(&station, ServerConfig::default()).await;
    let mut stream = TcpStream::connect(server.address()).await.expect("connected");
    stream.write_all(b"GET /api/v1/info HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n\r\n").await.expect("sent");
    let mut answer = String::new();
    timeout(PATIENCE, stream.read_to_string(&mut answer)).await.expect("in time").expect("read");
    assert!(answer.starts_with("HTTP/1.1 200") && answer.contains("\"name\":\"vencejo\""), "{answer}");
    server.close().await;
    assert!(TcpStream::connect(server.address()).await.is_err(), "nobody listens any more");
    station.close().await;
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn raw_messages_are_sent_by_name_the_newest_of_each() {
    let station = station(true);
    let _double = double(&station).await;
    let server = serve(&station, ServerConfig::default()).await;
    let ana = cookie(&server, "ana");
    let mut socket = connect(&server, &ana, None).await.expect("a WebSocket");
    let subscribe = |names: Value, rate_hz: u32| json!({"type": "subscribe_messages", "vehicle": 1, "names": names, "rate_hz": rate_hz});
    say(&mut socket, subscribe(json!(["HEARTBEAT"]), 2)).await;
    let first = next(&mut socket, "message").await.expect("a message");
    assert_eq!(
        (&first["vehicle"], &first["message"]["name"], &first["message"]["fields"]["autopilot"]),
        (&json!(1), &json!("HEARTBEAT"), &json!(3)),
        "{first}"
    );
    let second = next(&mut socket, "message").await.expect("a message");
    let counts = [&first, &second].map(|message| message["count"].as_u64().expect("a number"));
    assert!(counts[1] > counts[0] + 2, "20 a second came, 2 are told: {counts:?}");
    say(&mut socket, subscribe(json!(["NO_SUCH_MESSAGE"]), 2)).await;
    assert_eq!(next(&mut socket, "error").await.expect("an error")["cause"]["code"], "not-found");
    say(&mut socket, subscribe(Value::Null, 51)).await;
    assert_eq!(next(&mut socket, "error").await.expect("an error")["cause"]["field"], "rate_hz");
    server.close().await;
    station.close().await;
}

/// Known attempts to escape from a folder to a file: each parent step and separator in many encodings.
fn ways_out(file: &str) -> Vec<String> {
    let ups =
        ["..", "%2e%2e", "%2E.", ".%2e", "%252e%252e", "..;", "..%00", "....", "%c0%ae%c0%ae", "%uff0e%uff0e", ".%20."];
    let separators = ["/", "%2f", "%2F", "%5c", "%255c", "%252f", "//", "/./", "%c0%af", "%2f/"];
    let mut ways = Vec::new();
    for up in ups {
        for separator in separators {
            for depth in 1..=5 {
                let steps = [up, separator].concat().repeat(depth);
                ways.push(format!("{steps}{file}"));
                ways.push(format!("flight.tlog{separator}{steps}{file}"));
            }
        }
    }
    ways.extend([format!("%2f{file}"), format!("file:%2f%2f%2f{file}"), format!("C:%5c{file}"), format!("~%2f{file}")]);
    ways
}

// fault 48: more than 5,000 requests, 0 files from outside
#[tokio::test]
async fn a_thousand_ways_out_of_the_folders_lead_nowhere() {
    const SECRET: &[u8] = b"nobody was to read this";
    let base = std::env::temp_dir().join(format!("vencejo-ways-out-{}", std::process::id()));
    let folder = base.join("a/b/c/flights");
    std::fs::create_dir_all(&folder).expect("made");
    let outside = ["", "a", "a/b", "a/b/c"].map(|place| base.join(place).join("secret.tlog"));
    for path in &outside {
        std::fs::write(path, SECRET).expect("written");
    }
    std::fs::write(folder.join("flight.tlog"), b"").expect("written");
    let config = StationConfig { request_streams: false, record_dir: Some(folder.clone()), ..StationConfig::default() };
    let station = Station::start(config, Handle::current()).expect("a station");
    let server = Plain::new(station.clone(), None);
    let operator = server.session(json!({})).await;
    let mut tried = 0;
    for way in ways_out("secret.tlog") {
        for (method, path) in [
            ("GET", format!("/api/v1/recordings/{way}")),
            ("GET", format!("/api/v1/recordings/{way}/summary")),
            ("GET", format!("/api/v1/footage/{way}")),
            ("GET", format!("/api/v1/history/acme/{way}")),
            ("GET", format!("/api/v1/history/{way}/plane7_1.mcap")),
            ("DELETE", format!("/api/v1/footage/{way}")),
            ("GET", format!("/api/v1/tiles/{way}/0/0/0")),
            ("GET", format!("/{way}")),
            ("GET", format!("/assets/{way}")),
        ] {
            // Paths that a URI cannot contain are rejected before sending.
            let request = Request::builder().method(method).uri(&path).header(header::HOST, "localhost");
            let Ok(request) = request.header(header::COOKIE, &operator).body(Body::empty()) else { continue };
            let answer = server.send(request).await;
            assert!(!answer.body.windows(SECRET.len()).any(|part| part == SECRET), "{method} {path}");
            tried += 1;
        }
    }
    assert!(tried > 5_000, "{tried}");
    assert!(outside.iter().all(|path| std::fs::read(path).is_ok_and(|bytes| bytes == SECRET)), "nothing was removed");
    station.close().await;
    std::fs::remove_dir_all(&base).expect("removed");
}

#[tokio::test]
async fn recordings_are_listed_and_read_and_nothing_else_is() {
    let folder = std::env::temp_dir().join(format!("vencejo-recordings-{}", std::process::id()));
    std::fs::create_dir_all(&folder).expect("made");
    std::fs::write(folder.join("../vencejo-secret.tlog"), b"no").expect("written");
    std::fs::write(folder.join("notes.txt"), b"no").expect("written");
    let capture = concat!(env!("CARGO_MANIFEST_DIR"), "/../../tests/fixtures/captures/mission-upload-items.tlog");
    std::fs::copy(capture, folder.join("flight.tlog")).expect("copied");
    let config = StationConfig { request_streams: false, record_dir: Some(folder.clone()), ..StationConfig::default() };
    let station = Station::start(config, Handle::current()).expect("a station");
    let server = Plain::new(station.clone(), None);
    let listed = server.ask("GET", "/recordings", None, None).await.json();
    let names: Vec<_> = listed.as_array().expect("a list").iter().map(|one| one["name"].clone()).collect();
    assert!(names.contains(&json!("flight.tlog")) && !names.contains(&json!("notes.txt")), "{listed}");
    let read = server.ask("GET", "/recordings/flight.tlog", None, None).await;
    assert_eq!((read.status, read.body), (200, std::fs::read(capture).expect("read")));
    let summary = server.ask("GET", "/recordings/flight.tlog/summary", None, None).await.json();
    assert!(summary["frames"].as_u64().expect("a number") > 10, "{summary}");
    for name in ["..%2Fvencejo-secret.tlog", "notes.txt", "%2Fetc%2Fpasswd", "flight"] {
        let refused = server.ask("GET", &format!("/recordings/{name}"), None, None).await;
        assert_eq!((refused.status, refused.json()["cause"]["code"].clone()), (404, json!("not-found")), "{name}");
    }
    assert!(server.ask("GET", "/recorder", None, None).await.json()["dropped"].is_u64());
    let old = "2026-01-01T00-00-00Z.tlog";
    std::fs::copy(capture, folder.join(old)).expect("copied");
    let cookie = server.session(json!({})).await;
    for is_kept in [true, false] {
        let path = format!("/recordings/{old}/keep");
        assert_eq!(server.ask("PUT", &path, Some(&cookie), Some(json!({"is_kept": is_kept}))).await.status, 200);
        let listed = server.ask("GET", "/recordings", None, None).await.json();
        let found = listed.as_array().expect("a list").iter().find(|one| one["name"] == old).expect("listed").clone();
        assert_eq!(found["is_kept"], is_kept);
    }
    let begun = async {
        while !matches!(station.recorder().expect("one").1.state, RecorderState::Recording { .. }) {
            tokio::time::sleep(Duration::from_millis(5)).await;
        }
    };
    timeout(PATIENCE, begun).await.expect("it records");
    std::fs::remove_dir_all(&folder).expect("removed");
    let listed = server.ask("GET", "/recordings", None, None).await;
    assert_eq!((listed.status, listed.json()), (200, json!([])), "a folder that is not there yet holds none");
    station.close().await;
    std::fs::remove_file(folder.with_file_name("vencejo-secret.tlog")).expect("removed");
}

#[tokio::test]
async fn a_raw_command_is_answered_and_a_message_has_fields() {
    let station = station(true);
    let _double = double(&station).await;
    let server = Plain::new(station.clone(), None);
    let cookie = server.session(json!({})).await;
    let ask = async |method, path, body| server.ask(method, path, Some(cookie.as_str()), Some(body)).await;
    let refused =
        ask("POST", "/vehicles/1/command/long", json!({"command": "COMPONENT_ARM_DISARM", "params": [1]})).await;
    assert_eq!((refused.status, refused.json()["cause"]["result"].clone()), (409, json!("FAILED")));
    for (path, body, status, code) in [
        ("/vehicles/1/command/long", json!({"command": "NO_SUCH"}), 404, "not-found"),
        ("/vehicles/1/command/long", json!({"command": 400, "params": [1e300]}), 422, "invalid-value"),
        (
            "/vehicles/1/command/int",
            json!({"command": 192, "frame": 3, "params": [1, 2, 3, 4, 5]}),
            422,
            "invalid-value",
        ),
        ("/vehicles/1/messages", json!({"name": "NO_SUCH"}), 404, "not-found"),
        ("/vehicles/1/messages", json!({"name": "ATTITUDE", "fields": {"roll": "left"}}), 422, "invalid-request"),
        ("/vehicles/1/messages/NO_SUCH/request", Value::Null, 404, "not-found"),
    ] {
        let answer = ask("POST", path, body.clone()).await;
        assert_eq!((answer.status, answer.json()["cause"]["code"].clone()), (status, json!(code)), "{path} {body}");
    }
    let sent = json!({"name": "PARAM_REQUEST_READ", "fields": {"param_id": "WP_RADIUS", "param_index": -1}});
    assert_eq!(ask("POST", "/vehicles/1/messages", sent).await.status, 200);
    let rate =
        server.ask("PUT", "/vehicles/1/messages/ATTITUDE/rate", Some(&cookie), Some(json!({"rate_hz": 500}))).await;
    assert_eq!(rate.json()["cause"]["field"], "rate_hz");
    let note = ask("POST", "/vehicles/1/texts", json!({"text": "hello", "severity": 9})).await;
    assert_eq!(note.json()["cause"]["field"], "severity");
    assert_eq!(ask("POST", "/vehicles/1/texts", json!({"text": "hello"})).await.status, 200);
    let texts = server.ask("GET", "/vehicles/1/texts", None, None).await.json();
    assert_eq!(texts.as_array().and_then(|texts| texts.last()).map(|text| &text["text"]), Some(&json!("hello")));
    let params = b"WP_RADIUS,60\n".to_vec();
    let request = Request::builder().method("POST").uri("/api/v1/params/parse").header(header::HOST, "localhost");
    let parsed = server.send(request.body(Body::from(params.clone())).expect("a request")).await.json();
    assert_eq!(parsed, json!([{"name": "WP_RADIUS", "value": 60.0}]));
    assert_eq!(server.ask("POST", "/params/format", None, Some(parsed)).await.body, params);
    assert_eq!(server.ask("PUT", "/heartbeat", Some(&cookie), Some(json!({"enabled": true}))).await.status, 200);
    station.close().await;
}

#[tokio::test]
async fn a_mission_with_errors_is_not_sent() {
    let station = station(true);
    let _double = double(&station).await;
    let server = Plain::new(station.clone(), None);
    let cookie = server.session(json!({})).await;
    let item = json!({"command": 16, "frame": 3, "params": [0, 0, 0, 0, 0.0, 0.0, 50.0]});
    let answer = server.ask("PUT", "/vehicles/1/plan/mission", Some(&cookie), Some(json!({"items": [item]}))).await;
    let problem = answer.json();
    assert_eq!((answer.status, &problem["cause"]["code"]), (422, &json!("plan-unsound")), "{problem}");
    assert!(!problem["reasons"].as_array().expect("a list").is_empty());
    assert_eq!(server.ask("GET", "/operations", None, None).await.json(), json!([]), "nothing was sent");
    station.close().await;
}
