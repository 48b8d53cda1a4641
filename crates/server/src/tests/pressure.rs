//! More to tell than a browser takes: over a pipe of known size, under a clock that the test moves.

use std::future::pending;
use std::io;

use axum::serve::Listener;
use tokio::io::{DuplexStream, duplex};
use tokio::time::sleep;

use super::*;

/// Bytes on the way to a browser that stopped reading: three or four messages.
const PIPE: usize = 1024;

/// One connection, and nobody after it.
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

async fn browser(server: &Plain) -> WebSocketStream<DuplexStream> {
    let (near, far) = duplex(PIPE);
    let router = server.router.clone();
    tokio::spawn(async move { axum::serve(Once(Some(near)), router).await });
    let mut request = "ws://localhost/api/v1/ws".into_client_request().expect("a request");
    request.headers_mut().insert("cookie", cookie_of(&server.app, "ana").parse().expect("a cookie"));
    client_async(request, far).await.expect("a WebSocket").0
}

// fault 63: 300 texts to a browser that stalls for 7 s: each arrives, before all but what was on the way; 2,800 messages are dropped
#[tokio::test(start_paused = true)]
async fn telemetry_is_dropped_first() {
    const COMPONENTS: u8 = 40;
    const TEXTS: usize = 300;
    let station = station(true);
    let _double = double_of(&station, COMPONENTS).await;
    let server = Plain::new(station.clone(), None);
    let mut socket = browser(&server).await;
    say(&mut socket, json!({"type": "subscribe_messages", "vehicle": 1, "rate_hz": 10})).await;
    for _ in 0..2 * COMPONENTS {
        next(&mut socket, "message").await.expect("telemetry");
    }
    // It stops reading in the middle of a round, and things happen.
    sleep(Duration::from_secs(2)).await;
    for number in 0..TEXTS {
        let text = format!("{number} {}", "x".repeat(100));
        server.app.outboxes().put_event(&ServerMessage::Text { vehicle: 1, severity: 6, text, time_s: 0.0 });
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
