//! Measures the whole receive path: bytes → frames → hub (counters, routing) → listener → decoded message.
//!
//! ```text
//! cargo run --release -p vencejo-link --example decode -- tests/fixtures/captures/arduplane-50hz-20s.mavlink
//! ```
//! Prints one line of JSON: `decode_hz` is the decoder and the messages alone, from memory; `socket_to_listener_hz` is
//! all of it, from a loopback TCP connection, with the sender on the same core.
#![allow(clippy::print_stdout, reason = "a measuring program")]

use std::error::Error;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Instant;

use tokio::io::AsyncWriteExt;
use tokio::net::TcpStream;
use vencejo_link::{Hub, LinkOptions, LinkState, SinkScope, SystemClock};
use vencejo_proto::{Address, FrameDecoder};

const ROUNDS: usize = 50;

#[tokio::main(flavor = "current_thread")]
async fn main() -> Result<(), Box<dyn Error>> {
    let path =
        std::env::args().nth(1).unwrap_or_else(|| "tests/fixtures/captures/arduplane-50hz-20s.mavlink".to_owned());
    let bytes = std::fs::read(&path)?;

    // The decoder and the messages alone.
    let start = Instant::now();
    let (mut bare, mut bare_failed) = (0u64, 0u64);
    for _ in 0..ROUNDS {
        let mut decoder = FrameDecoder::new();
        for piece in bytes.chunks(16 * 1024) {
            decoder.push(piece);
            while let Some(frame) = decoder.next_frame() {
                match std::hint::black_box(frame.decode()) {
                    Ok(_) => bare += 1,
                    Err(_) => bare_failed += 1,
                }
            }
        }
    }
    let bare_hz = bare as f64 / start.elapsed().as_secs_f64();

    // The same over a socket and through the hub.
    let hub = Hub::new(vec![Address::new(255, 190)], Arc::new(SystemClock::new()));
    let decoded = Arc::new(AtomicU64::new(0));
    let counter = decoded.clone();
    hub.add_sink(
        SinkScope::All,
        Arc::new(move |_, frame, _| {
            if std::hint::black_box(frame.decode()).is_ok() {
                counter.fetch_add(1, Ordering::Relaxed);
            }
        }),
    );
    let mut link = hub.open("tcpin:127.0.0.1:0".parse()?, LinkOptions::default())?;
    link.wait_for(LinkState::is_up).await;
    let place = link.local_address().ok_or("the link is not up")?;
    let expected = bare / ROUNDS as u64 * ROUNDS as u64;
    let start = Instant::now();
    let mut stream = TcpStream::connect(place).await?;
    for _ in 0..ROUNDS {
        stream.write_all(&bytes).await?;
    }
    while decoded.load(Ordering::Relaxed) < expected {
        tokio::task::yield_now().await;
    }
    let whole_hz = expected as f64 / start.elapsed().as_secs_f64();
    let stats = hub.stats(link.id())?;
    println!(
        "{{\"messages\": {bare}, \"undecodable\": {bare_failed}, \"decode_hz\": {bare_hz:.0}, \"socket_to_listener_hz\": {whole_hz:.0}, \
         \"lost\": {}, \"bad_crc\": {}}}",
        stats.lost, stats.bad_crc
    );
    link.close().await;
    Ok(())
}
