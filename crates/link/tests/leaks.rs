//! 1,000 reconnections leak no task, thread or descriptor. A program of its own, for it counts those of the process.
#![cfg(target_os = "linux")]

use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use tokio::io::AsyncWriteExt;
use tokio::net::{TcpListener, TcpStream};
use tokio::runtime::Handle;
use vencejo_link::{Hub, LinkOptions, LinkState, SinkScope, SystemClock};
use vencejo_proto::{Address, Header, Heartbeat, MavVersion, Message};

const CYCLES: u32 = 1000;

/// (descriptors, threads, tasks)
fn held() -> (usize, usize, usize) {
    let count = |path: &str| std::fs::read_dir(path).expect("Linux has /proc").count();
    (count("/proc/self/fd"), count("/proc/self/task"), Handle::current().metrics().num_alive_tasks())
}

fn heartbeat(sequence: u32) -> Vec<u8> {
    let header = Header { sequence: sequence as u8, source: Address::new(1, 1), version: MavVersion::V2 };
    Message::Heartbeat(Heartbeat::default()).encode(header).bytes().to_vec()
}

// fault 13: 1,000 connections closed or reset, 1,000 clients, 1,000 links: no descriptor, thread or task more
#[tokio::test(start_paused = true)]
async fn a_thousand_reconnections_leak_nothing() {
    let hub = Hub::new(vec![Address::new(255, 190)], Arc::new(SystemClock::new()));
    let heard = Arc::new(AtomicU64::new(0));
    let counter = heard.clone();
    hub.add_sink(
        SinkScope::All,
        Arc::new(move |_, _, _| {
            counter.fetch_add(1, Ordering::SeqCst);
        }),
    );
    let before_all = held();

    // A client whose server goes away each time, half of the times without a word, and by a reset.
    let server = TcpListener::bind("127.0.0.1:0").await.expect("a port");
    let place = server.local_addr().expect("its address");
    let link = hub.open(format!("tcp:{place}").parse().expect("an address"), LinkOptions::default()).expect("room");
    let mut before = None;
    for cycle in 0..CYCLES {
        let (mut stream, _) = server.accept().await.expect("the client comes back");
        if cycle % 2 == 0 {
            stream.write_all(&heartbeat(cycle)).await.expect("it listens");
        } else {
            stream.set_zero_linger().expect("a socket option");
        }
        drop(stream);
        if cycle == 10 {
            before = Some(held());
        }
    }
    let (descriptors, threads, tasks) = held();
    let (descriptors_before, threads_before, tasks_before) = before.expect("it went round");
    assert!(descriptors <= descriptors_before + 2, "{descriptors_before} descriptors became {descriptors}");
    assert_eq!((threads, tasks), (threads_before, tasks_before));
    assert!(heard.load(Ordering::SeqCst) >= u64::from(CYCLES / 2) - 1);
    link.close().await;
    drop(server);

    // A server whose clients come and go.
    let mut link = hub.open("tcpin:127.0.0.1:0".parse().expect("an address"), LinkOptions::default()).expect("room");
    link.wait_for(LinkState::is_up).await;
    let place = link.local_address().expect("it is up");
    for cycle in 0..CYCLES {
        let mut client = TcpStream::connect(place).await.expect("it listens");
        client.write_all(&heartbeat(cycle)).await.expect("it is there");
        link.wait_for(|state| matches!(state, LinkState::Up { peers: 1.., .. })).await;
        drop(client);
        link.wait_for(|state| matches!(state, LinkState::Up { peers: 0, .. })).await;
    }
    link.close().await;

    // Links that are opened and closed.
    for text in ["udpin:127.0.0.1:0", "udpout:127.0.0.1:9", "tcpin:127.0.0.1:0", "tcp:127.0.0.1:9", "/dev/no-such-port"]
    {
        for _ in 0..CYCLES / 5 {
            let mut link = hub.open(text.parse().expect("an address"), LinkOptions::default()).expect("room");
            link.wait_for(|state| !matches!(state, LinkState::Connecting { last_error: None, .. })).await;
            link.close().await;
        }
    }
    assert!(hub.links().is_empty());
    assert_eq!(held(), before_all);
}
