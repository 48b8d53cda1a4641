//! Cameras over real sockets, and footage over HTTP.

use std::time::Duration;

use axum::body::Body;
use axum::http::{HeaderMap, Request};
use http_body_util::BodyExt;
use serde_json::{Value, json};
use tokio::time::timeout;
use tokio_tungstenite::tungstenite::Message;
use tower::ServiceExt;
use vencejo_video::{CameraRecording, CameraState, CameraStatus, HEADER_BYTES, Picture, VideoCodec};

use super::{Ws, connect_to, cookie, futures_next, serve, station};
use crate::{Server, ServerConfig, routes};

/// Time limit of a step; a hang fails the test.
const PATIENCE: Duration = Duration::from_secs(20);

fn picture(codec: VideoCodec, is_key: bool, data: &[u8]) -> Picture<'_> {
    Picture { codec, is_key, width: 640, height: 480, captured_unix_us: 1_700_000_000_000_000, data }
}

fn live(codec: VideoCodec) -> CameraStatus {
    CameraStatus { state: CameraState::Live, codec: Some(codec), ..CameraStatus::default() }
}

/// Next text message of a kind.
async fn text(socket: &mut Ws, kind: &str) -> Value {
    let find = async {
        loop {
            match futures_next(socket).await.expect("open").expect("a message") {
                Message::Text(text) => {
                    let value: Value = serde_json::from_str(&text).expect("JSON");
                    if value["type"] == kind {
                        return value;
                    }
                }
                Message::Close(frame) => panic!("closed: {frame:?}"),
                _ => {}
            }
        }
    };
    timeout(PATIENCE, find).await.unwrap_or_else(|_| panic!("no {kind}"))
}

/// Data of the next image; `None` at the end.
async fn code(socket: &mut Ws) -> Option<Vec<u8>> {
    let find = async {
        loop {
            match futures_next(socket).await {
                Some(Ok(Message::Binary(bytes))) => return Some(bytes[HEADER_BYTES..].to_vec()),
                Some(Ok(Message::Close(_)) | Err(_)) | None => return None,
                Some(Ok(_)) => {}
            }
        }
    };
    timeout(PATIENCE, find).await.expect("a picture or the end")
}

async fn viewers(server: &Server, count: usize) {
    let there = async {
        while server.video().viewers() != count {
            tokio::time::sleep(Duration::from_millis(1)).await;
        }
    };
    timeout(PATIENCE, there).await.unwrap_or_else(|_| panic!("{} viewers", server.video().viewers()));
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_stream_over_a_socket_of_its_own() {
    let station = station(true);
    let server = serve(&station, ServerConfig::default()).await;
    let ana = cookie(&server, "ana");
    let feed = server.video().add("nose", "rtsp://…@camera/").expect("added");
    feed.set_status(live(VideoCodec::H264));
    const PATH: &str = "/api/v1/cameras/nose/stream?accept=h264,jpeg";
    assert_eq!(connect_to(&server, PATH, "", None).await.err(), Some(401), "not without a session");
    assert_eq!(connect_to(&server, PATH, &ana, Some("http://evil.example")).await.err(), Some(403));
    assert_eq!(connect_to(&server, "/api/v1/cameras/tail/stream", &ana, None).await.err(), Some(404));
    let mut socket = connect_to(&server, PATH, &ana, None).await.expect("a stream");
    viewers(&server, 1).await;
    let told = text(&mut socket, "camera").await;
    assert_eq!(
        (&told["name"], &told["state"], &told["source"]),
        (&json!("nose"), &json!("live"), &json!("rtsp://…@camera/"))
    );
    assert!(text(&mut socket, "clock").await["unix_us"].as_u64().expect("a time") > 1_700_000_000_000_000);
    feed.publish(&picture(VideoCodec::H264, true, b"first")).expect("published");
    assert_eq!(code(&mut socket).await.as_deref(), Some(&b"first"[..]));
    feed.set_status(CameraStatus {
        state: CameraState::Dead,
        reason: Some("unplugged".into()),
        ..live(VideoCodec::H264)
    });
    while text(&mut socket, "camera").await["reason"] != "unplugged" {}
    drop(socket);
    viewers(&server, 0).await;
    let mut socket = connect_to(&server, PATH, &ana, None).await.expect("a stream");
    assert_eq!(code(&mut socket).await.as_deref(), Some(&b"first"[..]), "what there is is shown at once");
    feed.close();
    assert_eq!(code(&mut socket).await, None);
    server.close().await;
    station.close().await;
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn one_who_does_not_read_holds_nobody_up() {
    let station = station(true);
    let server = serve(&station, ServerConfig::default()).await;
    let ana = cookie(&server, "ana");
    let feed = server.video().add("nose", "test").expect("added");
    feed.set_status(live(VideoCodec::H264));
    const PATH: &str = "/api/v1/cameras/nose/stream?accept=h264";
    let slow = connect_to(&server, PATH, &ana, None).await.expect("a stream");
    let mut quick = connect_to(&server, PATH, &ana, None).await.expect("a stream");
    viewers(&server, 2).await;
    let large = vec![9_u8; 1 << 20];
    for number in 0..64_u32 {
        feed.publish(&picture(VideoCodec::H264, number == 0, &large)).expect("never waits");
        assert_eq!(code(&mut quick).await.expect("a picture").len(), large.len(), "{number}");
    }
    assert_eq!(server.clients(), 0, "these are no telemetry clients");
    drop(slow);
    server.close().await;
    assert_eq!(server.video().viewers(), 0);
    station.close().await;
}

/// A request without a socket: status, headers and body.
async fn ask(server: &Server, method: &str, path: &str, headers: &[(&str, &str)]) -> (u16, HeaderMap, Vec<u8>) {
    let mut request = Request::builder().method(method).uri(format!("/api/v1{path}")).header("host", "localhost");
    for (name, value) in headers {
        request = request.header(*name, *value);
    }
    let request = request.body(Body::empty()).expect("a request");
    let response = routes::router(server.app().clone()).oneshot(request).await.expect("infallible");
    let (status, headers) = (response.status().as_u16(), response.headers().clone());
    (status, headers, response.into_body().collect().await.expect("a body").to_bytes().to_vec())
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn footage_is_listed_read_in_parts_and_deleted_and_nothing_else_is() {
    let folder = std::env::temp_dir().join(format!("vencejo-footage-{}", std::process::id()));
    std::fs::create_dir_all(folder.join("2026-11-21_16-00-09_nose.mkv")).expect("a folder");
    std::fs::write(folder.join("secret.txt"), "secret").expect("written");
    let names = ["2026-11-21_16-00-00_nose.mkv", "2026-11-21_16-00-01_nose.jpg", "2026-11-21_16-00-02_nose.2.mkv"];
    for name in names {
        std::fs::write(folder.join(name), vec![7_u8; 3000]).expect("written");
    }
    let station = station(true);
    let config = ServerConfig { video_folder: Some(folder.clone()), ..ServerConfig::default() };
    let server = serve(&station, config).await;
    let feed = server.video().add("nose", "test").expect("added");
    let recording = CameraRecording { file: names[2].into(), duration_s: 1.0, bytes: 3000, problem: None };
    feed.set_status(CameraStatus { recording: Some(recording), ..live(VideoCodec::H264) });

    let (status, _, body) = ask(&server, "GET", "/footage", &[]).await;
    let listed: Value = serde_json::from_slice(&body).expect("JSON");
    let listed: Vec<_> = listed.as_array().expect("a list").iter().collect();
    let told = |key: &str| listed.iter().map(|one| one[key].clone()).collect::<Vec<_>>();
    assert_eq!(status, 200);
    assert_eq!(told("name"), [names[2], names[1], names[0]], "the newest first");
    assert_eq!(told("kind"), ["video", "picture", "video"]);
    assert_eq!(told("is_current"), [true, false, false]);
    assert_eq!((&listed[0]["camera"], &listed[2]["begin_unix_s"]), (&json!("nose"), &json!(1_795_276_800_u64)));

    let whole = format!("/footage/{}", names[0]);
    let (status, headers, body) = ask(&server, "GET", &whole, &[("accept-encoding", "gzip")]).await;
    assert_eq!((status, body.len()), (200, 3000), "whole, and not packed");
    assert_eq!(headers["content-type"], "video/x-matroska");
    assert_eq!(headers["content-disposition"], format!("attachment; filename=\"{}\"", names[0]));
    assert_eq!(headers["accept-ranges"], "bytes");
    let (status, headers, body) = ask(&server, "GET", &whole, &[("range", "bytes=1000-1099")]).await;
    assert_eq!(
        (status, body.len(), &headers["content-range"]),
        (206, 100, &"bytes 1000-1099/3000".parse().expect("a value"))
    );
    assert_eq!(ask(&server, "GET", &whole, &[("range", "bytes=9000-")]).await.0, 416);
    for other in [
        "secret.txt",
        "..%2Fsecret.txt",
        "2026-11-21_16-00-09_nose.mkv",
        "%2Fetc%2Fpasswd",
        "2026-11-21_16-00-00_nose.mkv%00",
    ] {
        assert_eq!(ask(&server, "GET", &format!("/footage/{other}"), &[]).await.0, 404, "{other}");
    }

    assert_eq!(ask(&server, "DELETE", &whole, &[]).await.0, 401, "not without a session");
    let ana = cookie(&server, "ana");
    let ana = [("cookie", ana.as_str())];
    assert_eq!(ask(&server, "DELETE", &format!("/footage/{}", names[2]), &ana).await.0, 409, "it is being recorded");
    assert_eq!(ask(&server, "DELETE", &whole, &ana).await.0, 200);
    assert_eq!(ask(&server, "DELETE", &whole, &ana).await.0, 404);
    let left: Vec<_> = names.iter().map(|name| folder.join(name).is_file()).collect();
    assert_eq!(left, [false, true, true]);
    server.close().await;
    station.close().await;
    std::fs::remove_dir_all(folder).expect("removed");
}
