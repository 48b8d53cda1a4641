//! Invalid bodies at every route, and bodies that do not arrive.

use std::convert::Infallible;
use std::pin::Pin;
use std::task::{Context, Poll};

use axum::body::Bytes;
use futures_core::Stream;
use tokio::task::{JoinSet, yield_now};
use tokio::time::{Instant, advance};

use super::*;

/// Method, path and description of every operation.
pub fn described() -> Vec<(String, String, Value)> {
    let description: Value = serde_json::from_str(&crate::openapi()).expect("JSON");
    let paths = description["paths"].as_object().expect("paths");
    let of_path = |(path, methods): (&String, &Value)| {
        let path = path.strip_prefix("/api/v1").expect("a path of the API").to_owned();
        let methods = methods.as_object().expect("methods").clone();
        methods.into_iter().map(move |(method, route)| (method.to_ascii_uppercase(), path.clone(), route))
    };
    paths.iter().flat_map(of_path).collect()
}

/// The path with this value for all of its parameters.
pub fn filled(path: &str, with: &str) -> String {
    let parts = path.split('/').map(|part| if part.starts_with('{') { with } else { part });
    parts.collect::<Vec<_>>().join("/")
}

/// Names of a body's values.
fn properties(schema: &Value) -> Vec<String> {
    let description: Value = serde_json::from_str(&crate::openapi()).expect("JSON");
    let one_of = schema["oneOf"].as_array().and_then(|choices| choices.last()).unwrap_or(schema);
    let named = one_of["$ref"].as_str().and_then(|name| description.pointer(name.trim_start_matches('#')));
    let properties = named.unwrap_or(schema)["properties"].as_object();
    properties.map(|properties| properties.keys().cloned().collect()).unwrap_or_default()
}

#[tokio::test]
async fn a_list_is_no_body_of_any_route() {
    let station = station(true);
    let _double = double(&station).await;
    let server = Plain::new(station.clone(), None);
    let cookie = server.session(json!({})).await;
    let mut checked = 0;
    let in_words = |answer: &Answer| {
        if answer.status == 422 {
            let detail = answer.json()["detail"].to_string();
            let of_rust =
                ["invalid type", "expected", "struct", " enum", "untagged", "variant", " field ", "f64", "u16"];
            assert!(of_rust.iter().all(|word| !detail.contains(word)), "{detail}");
        }
    };
    for (method, path, route) in described() {
        let schema = &route["requestBody"]["content"]["application/json"]["schema"];
        // Some bodies are lists, some are files.
        if schema.is_null() || schema["type"] == "array" {
            continue;
        }
        for body in [json!([]), json!([[]]), json!(7)] {
            let answer = server.ask(&method, &filled(&path, "1"), Some(&cookie), Some(body.clone())).await;
            assert_eq!(answer.status, 422, "{method} {path} {body}: {}", String::from_utf8_lossy(&answer.body));
            in_words(&answer);
        }
        for value in properties(schema) {
            for odd in [json!({"odd": [7]}), json!([{}]), json!(-1.5), json!("odd"), json!(true)] {
                let body = json!({(value.as_str()): odd});
                in_words(&server.ask(&method, &filled(&path, "1"), Some(&cookie), Some(body)).await);
            }
        }
        checked += 1;
    }
    assert!(checked >= 30, "{checked}");
    let item = json!({"command": 16, "frame": 3, "params": [0, 0, 0, 0, 40.0, -3.0, 100]});
    for (path, body) in [
        ("mission", json!({})),
        ("mission", json!({"items": []})),
        ("mission", json!({"items": [], "fence": {"zones": []}, "rally": [], "home": null})),
        ("fence", json!({"items": [item]})),
        ("fence", json!({"fence": []})),
        ("fence", json!({"fence": {"zones": []}})),
        ("rally", json!({"items": [item], "rally": []})),
        ("rally", json!({"rally": {}})),
    ] {
        let path = format!("/vehicles/1/plan/{path}");
        let answer = server.ask("PUT", &path, Some(&cookie), Some(body.clone())).await;
        assert_eq!(answer.status, 422, "{path} {body}: {}", String::from_utf8_lossy(&answer.body));
    }
    let answer = server.ask("PUT", "/vehicles/1/plan/mission", Some(&cookie), Some(json!({}))).await.json();
    assert!(answer["detail"].as_str().expect("text").contains("DELETE"), "{answer}");
    assert_eq!(server.ask("GET", "/operations", None, None).await.json(), json!([]), "nothing was begun");
    station.close().await;
}

// fault 43: simple requests from another site, of three types, at every write: 403
#[tokio::test]
async fn simple_requests_of_another_site_are_refused_at_every_write() {
    let server = Plain::new(station(true), None);
    let cookie = server.session(json!({})).await;
    let mut checked = 0;
    for (method, path, _) in described().into_iter().filter(|(method, ..)| method != "GET") {
        for kind in ["text/plain", "application/x-www-form-urlencoded", "multipart/form-data; boundary=x"] {
            let request = Request::builder()
                .method(method.as_str())
                .uri(format!("/api/v1{}", filled(&path, "1")))
                .header(header::HOST, "localhost")
                .header(header::ORIGIN, "http://evil.example")
                .header(header::COOKIE, &cookie)
                .header(header::CONTENT_TYPE, kind)
                .body(Body::from("{}"));
            let answer = server.send(request.expect("a request")).await;
            assert_eq!(answer.status, 403, "{method} {path} {kind}");
            checked += 1;
        }
    }
    assert!(checked >= 150, "{checked}");
}

/// Part of a body, and nothing after it.
pub struct Begun(pub Option<Bytes>);

impl Stream for Begun {
    type Item = Result<Bytes, Infallible>;

    fn poll_next(mut self: Pin<&mut Self>, _: &mut Context<'_>) -> Poll<Option<Self::Item>> {
        self.0.take().map_or(Poll::Pending, |piece| Poll::Ready(Some(Ok(piece))))
    }
}

/// A request with a content type and a body.
fn posted(path: &str, kind: &str, body: Body) -> Request<Body> {
    let request = Request::builder().method("POST").uri(format!("/api/v1{path}")).header(header::HOST, "localhost");
    request.header(header::CONTENT_TYPE, kind).body(body).expect("a request")
}

/// Enough bytes to earn a body two minutes.
fn much() -> Begun {
    Begun(Some(vec![0; 1 << 20].into()))
}

#[tokio::test(start_paused = true)]
async fn a_body_that_does_not_come_is_not_waited_for() {
    let server = Plain::new(station(true), None);
    for (path, body, most_s) in [("/session", Begun(None), 11), ("/plan/parse?name=a.plan", much(), 31)] {
        let begun = Instant::now();
        let answer = server.send(posted(path, "application/json", Body::from_stream(body))).await;
        assert_eq!((answer.status, answer.json()["cause"]["code"].clone()), (408, json!("body-too-slow")), "{path}");
        assert!(begun.elapsed() < Duration::from_secs(most_s), "{path}: {:?}", begun.elapsed());
    }
}

#[tokio::test(start_paused = true)]
async fn a_recording_that_does_not_arrive_does_not_block_others() {
    let server = Plain::new(station(true), None);
    let learn = |body| {
        let router = server.router.clone();
        async move {
            let request = posted("/plan/learn", "application/octet-stream", body);
            let response = router.oneshot(request).await.expect("infallible");
            let status = response.status().as_u16();
            let problem = response.into_body().collect().await.expect("a body").to_bytes();
            (status, serde_json::from_slice::<Value>(&problem).expect("JSON")["cause"].clone())
        }
    };
    let silent: JoinSet<_> = (0..3).map(|_| learn(Body::from_stream(Begun(None)))).collect();
    yield_now().await;
    let begun = Instant::now();
    let (status, cause) = learn(Body::from("no recording")).await;
    assert_eq!((status, cause["code"].clone(), begun.elapsed()), (422, json!("invalid-request"), Duration::ZERO));
    drop(silent);
    // Real threads process these bodies, so the paused clock must not advance by itself.
    let mut begun: JoinSet<_> = (0..3).map(|_| learn(Body::from_stream(much()))).collect();
    let mut ended = Vec::new();
    while ended.len() < 3 {
        tokio::select! {
            biased;
            Some(answer) = begun.join_next() => ended.push(answer.expect("no panic")),
            () = advance(Duration::from_secs(1)) => {}
        }
    }
    let crowd = json!({"code": "too-many", "what": "bodies", "limit": 2});
    assert_eq!(ended[0], (429, crowd), "whoever waits is told so first");
    assert_eq!((ended[2].0, &ended[2].1["code"]), (408, &json!("body-too-slow")));
}
