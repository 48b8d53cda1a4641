//! Backpressure: more messages than a browser reads, over a pipe of known size, with a clock controlled by the test.

use std::future::pending;
use std::io;

use axum::serve::Listener;
use tokio::io::{DuplexStream, duplex};
use tokio::time::{Instant, sleep};
use tokio_tungstenite::tungstenite::protocol::frame::coding::CloseCode;
use vencejo_video::{CameraStatus, Picture, VideoCodec};

use super::*;

/// Bytes in transit to a browser that has stopped reading: three or four messages.
const PIPE: usize = 1024;

/// Accepts one connection, and no others.
struct Once(Option<DuplexStream>);

impl Listener for Once {
    type Io = DuplexStream;
    type Addr = ();

    async fn accept(&mut self) -> (DuplexStream, ()) {
        match self.0.take() {
            Some(stream) => (stream, ()),
            None => pending().await,
        }
    }

    fn local_addr(&self) -> io::Result<()> {
        Ok(())
    }
}

async fn browser(server: &Plain, path: &str) -> WebSocketStream<DuplexStream> {
    let (near, far) = duplex(PIPE);
    let router = server.router.clone();
    tokio::spawn(async move { axum::serve(Once(Some(near)), router).await });
    let mut request = format!("ws://localhost/api/v1{path}").into_client_request().expect("a request");
    request.headers_mut().insert("cookie", cookie_of(&server.app, "ana").parse().expect("a cookie"));
    client_async(request, far).await.expect("a WebSocket").0
}

// fault 63: 300 texts to a browser that stalls for 7 s: each arrives, before everything not yet in transit; 2,800
// messages are dropped
#[tokio::test(start_paused = true)]
async fn telemetry_is_dropped_first() {
    const COMPONENTS: u8 = 40;
    const TEXTS: usize = 300;
    let station = station(true);
    let _double = double_of(&station, COMPONENTS).await;
    let server = Plain::new(station.clone(), None);
    let mut socket = browser(&server, "/ws").await;
    say(&mut socket, json!({"type": "subscribe_messages", "vehicle": 1, "rate_hz": 10})).await;
    for _ in 0..2 * COMPONENTS {
        next(&mut socket, "message").await.expect("telemetry");
    }
    // It stops reading in the middle of a round, while events occur.
    sleep(Duration::from_secs(2)).await;
    for number in 0..TEXTS {
        let text = format!("{number} {}", "x".repeat(100));
        let text = Text { time_s: 0.0, unix_s: None, severity: 6, text };
        server.app.outboxes().put_event(&ServerMessage::Text { vehicle: 1, text });
    }
    sleep(Duration::from_secs(5)).await;
    let (mut texts, mut telemetry) = (0, 0);
    while texts < TEXTS {
        let Some(Ok(WsMessage::Text(message))) = futures_next(&mut socket).await else { panic!("it stays") };
        let message: Value = serde_json::from_str(&message).expect("JSON");
        if message["type"] == "text" {
            assert!(message["text"].as_str().expect("text").starts_with(&format!("{texts} ")), "{message}");
            texts += 1;
        } else {
            assert_eq!(texts, 0, "{message}");
            telemetry += 1;
        }
    }
    assert!(telemetry < 10, "{telemetry} before the texts");
    next(&mut socket, "message").await.expect("telemetry goes on");
    drop(socket);
    station.close().await;
}

#[tokio::test(start_paused = true)]
async fn a_viewer_on_a_thin_line_is_told_the_time_and_when_its_session_is_over() {
    let station = station(true);
    let server = Plain::new(station.clone(), None);
    let feed = server.app.video().add("nose", "test").expect("added");
    feed.set_status(CameraStatus { codec: Some(VideoCodec::H264), ..CameraStatus::default() });
    let mut socket = browser(&server, "/cameras/nose/stream?accept=h264").await;
    let data = vec![9; 4 * PIPE];
    let publish = || {
        let (codec, captured_unix_us) = (VideoCodec::H264, 1_700_000_000_000_000);
        let picture = Picture { codec, is_key: true, width: 640, height: 480, captured_unix_us, data: &data };
        feed.publish(&picture).expect("never waits");
    };
    // Whenever one has been sent, the next is waiting.
    (0..3).for_each(|_| publish());
    let (mut pictures, mut revoked) = (0, None);
    let frame = loop {
        match timeout(PATIENCE, futures_next(&mut socket)).await.expect("it goes on") {
            Some(Ok(WsMessage::Binary(_))) => {
                pictures += 1;
                assert!(pictures < 50, "and nothing else: revoked {revoked:?}");
                publish();
                sleep(Duration::from_millis(400)).await;
            }
            Some(Ok(WsMessage::Text(text))) if revoked.is_none() && pictures > 5 && text.contains("clock") => {
                let now = server.app.now();
                server.app.change_sessions(|sessions| sessions.revoke(crate::dto::Role::Operator, now));
                revoked = Some(Instant::now());
            }
            Some(Ok(WsMessage::Close(frame))) => break frame.expect("a reason"),
            Some(Ok(_)) => {}
            gone => panic!("{gone:?}"),
        }
    };
    assert_eq!((frame.code, frame.reason.as_str()), (CloseCode::Policy, "the session has ended"));
    assert!(revoked.expect("told the time").elapsed() < Duration::from_secs(5));
    drop(socket);
    station.close().await;
}
