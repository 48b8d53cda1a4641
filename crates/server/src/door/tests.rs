//! Connection limits over real sockets: many clients that send nothing, incomplete requests, or more than they read.

use std::net::{IpAddr, SocketAddr};
use std::time::Duration;

use serde_json::json;
use tokio::io::{AsyncReadExt, AsyncWriteExt};
use tokio::net::{TcpSocket, TcpStream};
use tokio::runtime::Handle;
use tokio::time::{Instant, timeout};
use tokio_tungstenite::tungstenite::Message;

use super::limits::network_of;
use super::*;
use crate::tests::{PATIENCE, Plain, Ws, connect_to, cookie, futures_next, put, station};
use crate::{Server, ServerConfig, Tokens};

/// A server with few slots and short time limits.
async fn serve(limits: DoorLimits) -> (vencejo_station::Station, Server) {
    let station = station(true);
    let config = ServerConfig { bind: SocketAddr::from(([127, 0, 0, 1], 0)), ..ServerConfig::default() };
    let server = Server::start_within(limits, station.clone(), config, &Handle::current()).await.expect("a server");
    (station, server)
}

fn limits(connections: usize) -> DoorLimits {
    // No time limit applies here unless a test sets it.
    let (ask_within, stall) = (Duration::from_secs(3600), Duration::from_secs(3600));
    DoorLimits { connections, per_address: connections, of_loopback: connections, ask_within, stall }
}

/// Everything that the server sends until it disconnects.
async fn rest(stream: &mut TcpStream) -> Vec<u8> {
    let mut all = Vec::new();
    // A reset connection has ended, too.
    let _ = timeout(PATIENCE, stream.read_to_end(&mut all)).await.expect("it ends");
    all
}

async fn says(server: &Server, text: &str) -> TcpStream {
    let mut stream = TcpStream::connect(server.address()).await.expect("connected");
    stream.write_all(text.as_bytes()).await.expect("sent");
    stream
}

async fn is_answered(server: &Server) -> bool {
    let mut stream = says(server, "GET /api/v1/info HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n\r\n").await;
    rest(&mut stream).await.starts_with(b"HTTP/1.1 200")
}

const HALF_A_BODY: &str =
    "POST /api/v1/session HTTP/1.1\r\nHost: localhost\r\nContent-Type: application/json\r\nContent-Length: 50\r\n\r\n{";

// fault 47: 40 incomplete requests at 8 slots: other clients are answered
#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn many_incomplete_requests_do_not_lock_out_others() {
    let (station, server) = serve(limits(8)).await;
    let mut halves = Vec::new();
    for number in 0..40 {
        halves.push(says(&server, ["", "GET /api/v1/in", HALF_A_BODY][number % 3]).await);
    }
    assert!(is_answered(&server).await);
    // The oldest one was closed.
    assert_eq!(rest(&mut halves[0]).await, b"");
    server.close().await;
    station.close().await;
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn connections_being_served_are_not_closed() {
    let (station, server) = serve(limits(2)).await;
    let (ana, luis) = (cookie(&server, "ana"), cookie(&server, "luis"));
    let mut first = connect_to(&server, "/api/v1/ws", &ana, None).await.expect("a WebSocket");
    let second = connect_to(&server, "/api/v1/ws", &luis, None).await.expect("a WebSocket");
    // With all slots in use, a new connection waits in the backlog, and is accepted when one closes.
    let newcomer = tokio::spawn({
        let address = server.address();
        async move {
            let mut stream = TcpStream::connect(address).await.expect("in the queue");
            stream
                .write_all(b"GET /api/v1/info HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n\r\n")
                .await
                .expect("sent");
            rest(&mut stream).await
        }
    });
    assert!(matches!(futures_next(&mut first).await, Some(Ok(Message::Text(_)))), "it is served on");
    assert!(!newcomer.is_finished());
    drop(second);
    assert!(newcomer.await.expect("ended").starts_with(b"HTTP/1.1 200"));
    server.close().await;
    station.close().await;
}

// fault 47: idle connections with a session make room
#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn an_idle_connection_makes_room_for_a_new_one() {
    let (station, server) = serve(limits(3)).await;
    let (ana, luis) = (cookie(&server, "ana"), cookie(&server, "luis"));
    let mut socket = connect_to(&server, "/api/v1/ws", &ana, None).await.expect("a WebSocket");
    let mut resting = Vec::new();
    for _ in 0..2 {
        let request = format!("GET /api/v1/session HTTP/1.1\r\nHost: localhost\r\nCookie: {luis}\r\n\r\n");
        let mut stream = says(&server, &request).await;
        let mut answer = [0; 12];
        stream.read_exact(&mut answer).await.expect("an answer");
        assert_eq!(&answer, b"HTTP/1.1 200");
        resting.push(stream);
    }
    assert!(is_answered(&server).await);
    rest(&mut resting[0]).await;
    assert!(matches!(futures_next(&mut socket).await, Some(Ok(Message::Text(_)))), "a WebSocket is served on");
    server.close().await;
    station.close().await;
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_connection_without_a_request_is_closed() {
    let (station, server) = serve(DoorLimits { ask_within: Duration::from_millis(100), ..limits(8) }).await;
    let (mut silent, mut half) = (says(&server, "").await, says(&server, "GET / HTTP/1.1\r\nHo").await);
    let mut preface = says(&server, "PRI * HTTP/2.0\r\n").await;
    for stream in [&mut silent, &mut half, &mut preface] {
        assert_eq!(rest(stream).await, b"");
    }
    // One with a request may stay.
    let mut asked = says(&server, "GET /api/v1/info HTTP/1.1\r\nHost: localhost\r\n\r\n").await;
    assert!(timeout(Duration::from_millis(300), rest_of_one(&mut asked)).await.is_err(), "it stays open");
    server.close().await;
    station.close().await;
}

/// Reads until the server disconnects.
async fn rest_of_one(stream: &mut TcpStream) {
    while stream.read(&mut [0; 4096]).await.is_ok_and(|count| count > 0) {}
}

// fault 47: a client that does not read answers is disconnected
#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_client_that_does_not_read_is_disconnected() {
    let (station, server) = serve(DoorLimits { stall: Duration::from_millis(200), ..limits(8) }).await;
    let socket = TcpSocket::new_v4().expect("a socket");
    socket.set_recv_buffer_size(4096).expect("a small buffer");
    let mut stream = socket.connect(server.address()).await.expect("connected");
    let asked = 100;
    for _ in 0..asked {
        stream.write_all(b"GET /api/v1/openapi.json HTTP/1.1\r\nHost: localhost\r\n\r\n").await.expect("sent");
    }
    let mut answer = [0; 12];
    stream.read_exact(&mut answer).await.expect("it is served");
    // Nothing is read until the server has disconnected, however long that takes: a client that reads is not
    // disconnected.
    let let_go = async {
        while server.connections() > 0 {
            tokio::time::sleep(Duration::from_millis(10)).await;
        }
    };
    timeout(PATIENCE, let_go).await.expect("it is let go");
    assert!(rest(&mut stream).await.len() < crate::openapi().len() * asked / 2, "less than what was asked for");
    server.close().await;
    station.close().await;
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn half_an_upgrade_is_no_upgrade() {
    let (station, server) = serve(limits(8)).await;
    let ana = cookie(&server, "ana");
    let request = format!(
        "GET /api/v1/ws HTTP/1.1\r\nHost: localhost\r\nConnection: Upgrade\r\nUpgrade: websocket\r\nCookie: {ana}\r\n\
         Sec-WebSocket-Version: 13\r\nSec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\nContent-Length: 10\r\n\r\n123"
    );
    let mut half = says(&server, &request).await;
    let answer = rest(&mut half).await;
    assert!(answer.starts_with(b"HTTP/1.1 422"), "{}", String::from_utf8_lossy(&answer));
    server.close().await;
    station.close().await;
}

// fault 47: a client that only requests pongs is disconnected
#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn pings_count_as_messages_do() {
    let (station, server) = serve(limits(8)).await;
    let ana = cookie(&server, "ana");
    let mut socket = connect_to(&server, "/api/v1/ws", &ana, None).await.expect("a WebSocket");
    // It reads nothing, and repeatedly requests a pong of 125 bytes.
    let flood = async {
        let ping = Message::Ping(vec![0; 125].into());
        for sent in 0_u64.. {
            if put(&mut socket, ping.clone()).await.is_err() {
                return sent;
            }
        }
        0
    };
    let sent = timeout(PATIENCE, flood).await.expect("it is let go");
    assert!(sent > 100, "{sent}");
    let mut reason = None;
    while let Some(Ok(message)) = futures_next(&mut socket).await {
        if let Message::Close(Some(frame)) = message {
            reason = Some(u16::from(frame.code));
        }
    }
    assert!(reason.is_none_or(|code| code == 1008), "{reason:?}");
    server.close().await;
    station.close().await;
}

// fault 44: slowed after 10 wrong tokens
#[tokio::test]
async fn guessing_tokens_is_slowed_after_ten() {
    let tokens = Tokens::random().expect("random");
    let server = Plain::new(station(true), Some(tokens.clone()));
    let pilot = server.session(json!({"token": tokens.operator})).await;
    for _ in 0..10 {
        assert_eq!(server.ask("POST", "/session", None, Some(json!({"token": "guess"}))).await.status, 401);
    }
    for token in ["guess", &tokens.operator] {
        let answer = server.ask("POST", "/session", None, Some(json!({"token": token}))).await;
        assert_eq!((answer.status, answer.json()["cause"]["code"].clone()), (429, json!("tokens-slowed")));
    }
    assert_eq!(server.ask("GET", "/session", Some(&pilot), None).await.status, 200, "who is in stays in");
}

// fault 44: sessions and WebSockets end within 5 s
#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_token_that_is_replaced_ends_its_sessions_and_their_websockets() {
    let station = station(true);
    let folder =
        std::env::temp_dir().join(format!("vencejo-revoke-{}", crate::tokens::random_secret().expect("random")));
    let path = folder.join("tokens.json");
    let bind = SocketAddr::from(([127, 0, 0, 1], 0));
    let config = ServerConfig { bind, token_file: Some(path.clone()), ..ServerConfig::default() };
    let server = Server::start(station.clone(), config, &Handle::current()).await.expect("a server");
    let before = server.tokens().expect("tokens");
    let ana = cookie(&server, "ana");
    let mut socket: Ws = connect_to(&server, "/api/v1/ws", &ana, None).await.expect("a WebSocket");
    let _inside = server.operator("this program").expect("a place");
    let begun = Instant::now();
    Tokens::renew(&path, false, true).expect("renewed");
    let closed = async {
        loop {
            match futures_next(&mut socket).await {
                Some(Ok(Message::Close(frame))) => return frame.map(|frame| u16::from(frame.code)),
                Some(Ok(_)) => {}
                Some(Err(_)) | None => return None,
            }
        }
    };
    assert_eq!(timeout(Duration::from_secs(5), closed).await.expect("within 5 s"), Some(1008), "{:?}", begun.elapsed());
    let after = server.tokens().expect("tokens");
    assert_eq!((&after.viewer, after.role(&before.operator)), (&before.viewer, None));
    let app = server.app();
    assert!(app.sessions().has_operator(app.now()), "what runs in the server needs no token");
    server.close().await;
    station.close().await;
    std::fs::remove_dir_all(&folder).expect("removed");
}

#[test]
fn one_address_takes_no_more_than_its_share() {
    let slots = Arc::new(Slots::default());
    let limits = DoorLimits::of(64);
    let address = |last: u8| IpAddr::from([192, 0, 2, last]);
    let (mut taken, mut served) = (Vec::new(), Vec::new());
    for _ in 0..1000 {
        let connection = slots.enter(address(1), &limits).expect("the oldest makes room");
        connection.showed_session();
        served.push(connection.asked());
        taken.push(connection);
        if taken.len() == limits.per_address {
            break;
        }
    }
    assert!(slots.enter(address(1), &limits).is_err(), "all of them are being served");
    assert!(slots.enter("::ffff:192.0.2.1".parse().expect("an address"), &limits).is_err(), "the same in IPv6");
    assert!(slots.enter(address(2), &limits).is_ok());
    slots.leave(&taken[0]);
    let newcomer = slots.enter(address(1), &limits).expect("a free place");
    newcomer.showed_session();
    served.push(newcomer.asked());
    assert!(slots.enter(address(1), &limits).is_err());
    // Of the idle ones, the one idle for longest is closed and accepts no more requests.
    (served[5], served[3]) = (None, None);
    assert!(slots.enter(address(1), &limits).is_ok());
    assert!(taken[5].asked().is_none() && taken[3].asked().is_some());
    let v6 = |text: &str| network_of(text.parse().expect("an address"));
    assert_eq!(v6("2001:db8:1:2:3:4:5:6"), v6("2001:db8:1:2::1"));
    assert_ne!(v6("2001:db8:1:2::1"), v6("2001:db8:1:3::1"));
}
