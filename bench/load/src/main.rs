//! The load of the benchmarks: plays prepared MAVLink 2 frames at a steady rate over UDP, each with a
//! fresh sequence number and, where the frame has a place for it, the time of sending.
//!
//! `send` plays to whoever listens. `forward` also owns the far ends of a forwarder, counts what
//! arrives there and measures how long it took. Both end with one line of JSON.
//!
//! The frames file comes from `bench/prepare.py`: records of `u16 length, u8 crc_extra, u16 offset of
//! the u64 time stamp in the frame (0xFFFF: none), frame bytes`, little endian.
//! A stamp is microseconds of CLOCK_MONOTONIC, as Python's `time.monotonic_ns() // 1000`.

#![allow(clippy::print_stdout, clippy::print_stderr)]

use std::collections::HashMap;
use std::net::{SocketAddr, UdpSocket};
use std::process::ExitCode;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::{self, JoinHandle};
use std::time::Duration;

use rustix::net::sockopt::set_socket_recv_buffer_size;
use rustix::time::{ClockId, clock_gettime};

const MAGIC_V2: u8 = 0xFD;
const HEADER_BYTES: usize = 10;
const CHECKSUM_BYTES: usize = 2;
const SIGNATURE_BYTES: usize = 13;
const SIGNED: u8 = 0x01;
const NO_STAMP: u16 = 0xFFFF;
const STAMP_BYTES: usize = 8;
/// Large enough that a sink never is the one that loses (the kernel may grant less).
const SINK_BUFFER_BYTES: usize = 8 << 20;
/// How long sinks go on listening after the last frame was sent.
const DRAIN: Duration = Duration::from_millis(300);

type Result<T> = std::result::Result<T, Box<dyn std::error::Error + Send + Sync>>;

struct Record {
    bytes: Vec<u8>,
    crc_extra: u8,
    stamp_at: Option<usize>,
}

#[derive(Default)]
struct Sunk {
    frames: u64,
    latencies_us: Vec<u64>,
}

fn main() -> ExitCode {
    match run() {
        Ok(line) => {
            println!("{line}");
            ExitCode::SUCCESS
        }
        Err(error) => {
            eprintln!("load: {error}");
            ExitCode::FAILURE
        }
    }
}

fn run() -> Result<String> {
    let mut arguments = std::env::args().skip(1);
    let task = arguments.next().ok_or("say send or forward")?;
    let mut options: HashMap<String, String> = HashMap::new();
    while let Some(name) = arguments.next() {
        let value = arguments.next().ok_or_else(|| format!("{name} needs a value"))?;
        options.insert(name, value);
    }
    let option = |name: &str| options.get(name).ok_or_else(|| format!("{name} is missing"));
    let records = read_records(&std::fs::read(option("--frames")?)?)?;
    let to: SocketAddr = option("--to")?.parse()?;
    let rate: f64 = option("--rate")?.parse()?;
    let seconds: f64 = option("--seconds")?.parse()?;
    let systems: u8 = options.get("--systems").map_or(Ok(1), |text| text.parse())?;
    let sinks: Vec<u16> = match task.as_str() {
        "send" => Vec::new(),
        "forward" => option("--sinks")?.split(',').map(str::parse).collect::<std::result::Result<_, _>>()?,
        other => return Err(format!("unknown task {other}: say send or forward").into()),
    };

    let stop = Arc::new(AtomicBool::new(false));
    let threads =
        sinks.iter().map(|&port| start_sink(port, Arc::clone(&stop))).collect::<Result<Vec<JoinHandle<Sunk>>>>()?;
    let sent = play(records, to, rate, seconds, systems.max(1))?;
    thread::sleep(DRAIN);
    stop.store(true, Ordering::Relaxed);

    let mut received = Vec::new();
    let mut latencies = Vec::new();
    for thread in threads {
        let sunk = thread.join().map_err(|_| "a sink panicked")?;
        received.push(sunk.frames.to_string());
        latencies.extend(sunk.latencies_us);
    }
    latencies.sort_unstable();
    Ok(format!(
        r#"{{"sent": {sent}, "received": [{}], "samples": {}, "median_us": {}, "p99_us": {}}}"#,
        received.join(", "),
        latencies.len(),
        quantile(&latencies, 0.50),
        quantile(&latencies, 0.99),
    ))
}

/// The value below which a share of the sorted samples lies, or JSON's `null`.
fn quantile(sorted: &[u64], share: f64) -> String {
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss, clippy::cast_precision_loss)]
    let index = (sorted.len() as f64 * share) as usize;
    sorted.get(index).map_or_else(|| "null".to_owned(), u64::to_string)
}

fn read_records(file: &[u8]) -> Result<Vec<Record>> {
    let mut records = Vec::new();
    let mut rest = file;
    while let [l0, l1, crc_extra, s0, s1, tail @ ..] = rest {
        let length = usize::from(u16::from_le_bytes([*l0, *l1]));
        let stamp_at = u16::from_le_bytes([*s0, *s1]);
        let bytes = tail.get(..length).ok_or("the frames file ends inside a frame")?.to_vec();
        if bytes.len() < HEADER_BYTES + CHECKSUM_BYTES || bytes[0] != MAGIC_V2 {
            return Err("the frames file holds something else than MAVLink 2 frames".into());
        }
        let stamp_at = (stamp_at != NO_STAMP).then_some(usize::from(stamp_at));
        if stamp_at.is_some_and(|at| at + STAMP_BYTES + CHECKSUM_BYTES > bytes.len()) {
            return Err("a time stamp lies outside its frame".into());
        }
        records.push(Record { bytes, crc_extra: *crc_extra, stamp_at });
        rest = &tail[length..];
    }
    if records.is_empty() {
        return Err("the frames file is empty".into());
    }
    Ok(records)
}

fn now_us() -> u64 {
    let now = clock_gettime(ClockId::Monotonic);
    u64::try_from(now.tv_sec).unwrap_or(0) * 1_000_000 + u64::try_from(now.tv_nsec).unwrap_or(0) / 1000
}

/// Sends at the rate asked for, catching up after a late wake-up so that the mean is exact.
fn play(mut records: Vec<Record>, to: SocketAddr, rate: f64, seconds: f64, systems: u8) -> Result<u64> {
    let socket = UdpSocket::bind(("127.0.0.1", 0))?;
    socket.connect(to)?;
    // One counter per sender, as a real autopilot has; a jump would be counted as loss.
    let mut sequences = vec![0_u8; usize::from(systems)];
    let began_us = now_us();
    let mut sent = 0_u64;
    'play: loop {
        for record in &mut records {
            for system in 0..systems {
                #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss, clippy::cast_precision_loss)]
                let due_us = began_us + (sent as f64 / rate * 1e6) as u64;
                #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
                if due_us > began_us + (seconds * 1e6) as u64 {
                    break 'play;
                }
                let early_us = due_us.saturating_sub(now_us());
                if early_us > 0 {
                    thread::sleep(Duration::from_micros(early_us));
                }
                let sequence = &mut sequences[usize::from(system)];
                record.bytes[4] = *sequence;
                *sequence = sequence.wrapping_add(1);
                if systems > 1 {
                    record.bytes[5] = system + 1;
                }
                if let Some(at) = record.stamp_at {
                    record.bytes[at..at + STAMP_BYTES].copy_from_slice(&now_us().to_le_bytes());
                }
                let end = record.bytes.len() - CHECKSUM_BYTES;
                let crc = x25(&record.bytes[1..end], record.crc_extra);
                record.bytes[end..].copy_from_slice(&crc.to_le_bytes());
                // Nobody there yet (ECONNREFUSED) is the listener's affair, not ours.
                let _ = socket.send(&record.bytes);
                sent += 1;
            }
        }
    }
    Ok(sent)
}

/// CRC-16/MCRF4XX as MAVLink uses it (mavlink.io/en/guide/serialization.html#checksum).
fn x25(bytes: &[u8], extra: u8) -> u16 {
    bytes.iter().chain(std::iter::once(&extra)).fold(0xFFFF_u16, |crc, &byte| {
        let [low, high] = crc.to_le_bytes();
        let mut mixed = byte ^ low;
        mixed ^= mixed << 4;
        let mixed = u16::from(mixed);
        u16::from(high) ^ (mixed << 8) ^ (mixed << 3) ^ (mixed >> 4)
    })
}

fn start_sink(port: u16, stop: Arc<AtomicBool>) -> Result<JoinHandle<Sunk>> {
    let socket = UdpSocket::bind(("127.0.0.1", port))?;
    set_socket_recv_buffer_size(&socket, SINK_BUFFER_BYTES)?;
    socket.set_read_timeout(Some(Duration::from_millis(50)))?;
    Ok(thread::spawn(move || {
        let mut sunk = Sunk::default();
        let mut buffer = [0_u8; 65_536];
        while !stop.load(Ordering::Relaxed) {
            if let Ok(length) = socket.recv(&mut buffer) {
                let arrived_us = now_us();
                count(&buffer[..length], arrived_us, &mut sunk);
            }
        }
        sunk
    }))
}

/// Counts the frames of one datagram that we sent (system 1 … component 1, not a forwarder's own).
fn count(mut datagram: &[u8], arrived_us: u64, sunk: &mut Sunk) {
    const RAW_IMU: u32 = 27;
    while datagram.len() >= HEADER_BYTES + CHECKSUM_BYTES && datagram[0] == MAGIC_V2 {
        let payload = usize::from(datagram[1]);
        let signature = if datagram[2] & SIGNED != 0 { SIGNATURE_BYTES } else { 0 };
        let length = HEADER_BYTES + payload + CHECKSUM_BYTES + signature;
        let Some(frame) = datagram.get(..length) else { return };
        if frame[6] == 1 && frame[5] != 255 {
            sunk.frames += 1;
            if u32::from_le_bytes([frame[7], frame[8], frame[9], 0]) == RAW_IMU
                && let Some(stamp) = frame[HEADER_BYTES..].first_chunk::<STAMP_BYTES>()
            {
                sunk.latencies_us.push(arrived_us.saturating_sub(u64::from_le_bytes(*stamp)));
            }
        }
        datagram = &datagram[length..];
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn checksum_is_the_published_one() {
        // CRC-16/MCRF4XX of "123456789" is 0x6F91; the extra byte is the last digit here.
        assert_eq!(x25(b"12345678", b'9'), 0x6F91);
    }

    #[test]
    fn refuses_a_torn_frames_file() {
        assert!(read_records(&[12, 0, 50, 0xFF, 0xFF, MAGIC_V2, 0]).is_err());
        assert!(read_records(&[]).is_err());
    }

    #[test]
    fn counts_only_whole_frames_of_the_load() {
        let mut frame = vec![MAGIC_V2, 8, 0, 0, 0, 1, 1, 27, 0, 0];
        frame.extend(5_u64.to_le_bytes());
        frame.extend([0, 0]);
        let mut sunk = Sunk::default();
        count(&[frame.clone(), frame.clone()].concat(), 25, &mut sunk);
        count(&frame[..frame.len() - 1], 25, &mut sunk);
        assert_eq!((sunk.frames, sunk.latencies_us), (2, vec![20, 20]));
    }
}
