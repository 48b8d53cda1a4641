//! A recording that stands in for a plane, beside one that flies.

use vencejo_link::write_entry;
use vencejo_proto::{Header, MavVersion};
use vencejo_station::ReplayOptions;

use super::*;
use crate::carrier::tests::Scratch;

const NAME: &str = "/flight_3_replay/mavros";

/// A heartbeat, and another one 20 s later.
fn recording(folder: &Scratch) -> std::path::PathBuf {
    let heartbeat = Mavlink::Heartbeat(Heartbeat { mav_type: 1, autopilot: 3, ..Heartbeat::default() });
    let frame = heartbeat.encode(Header { sequence: 0, source: Address::new(1, 1), version: MavVersion::V2 });
    let mut bytes = Vec::new();
    for second in [0, 20] {
        write_entry(&mut bytes, 1_700_000_000_000_000 + second * 1_000_000, &frame);
    }
    let path = folder.0.join("flight #3.tlog");
    std::fs::write(&path, bytes).expect("written");
    path
}

#[tokio::test(flavor = "multi_thread")]
async fn it_goes_by_the_time_of_its_recording_and_is_gone_with_it() {
    let ((router, at), folder) = (router().await, Scratch::new());
    let station = Station::start(StationConfig::default(), Handle::current()).expect("a station");
    let id = station.adopt("plane-7", Address::new(1, 1), Arc::new(Far::default())).expect("there is room");
    beat(&station, id);
    let open = async || {
        let options = ReplayOptions { stands_in: true, ..ReplayOptions::default() };
        station.open_replay(&recording(&folder), options).await.expect("opened")
    };
    let replay = open().await;
    replay.pause();
    let states =
        router.declare_subscriber(key(0, &format!("{NAME}/state"), State::TYPE, State::HASH)).await.expect("declared");
    let gateway = Gateway::start(station.clone(), config(&at, false), &Handle::current()).expect("a gateway");
    // Silent since 10 s, and then at a place before that.
    for (place_s, is_connected) in [(1, true), (10, false), (2, true)] {
        replay.seek(Duration::from_secs(place_s));
        let told = async {
            loop {
                let state = states.recv_async().await.expect("a message");
                if State::from_bytes(&state.payload().to_bytes()).expect("a state").connected == is_connected {
                    return;
                }
            }
        };
        tokio::time::timeout(WAIT, told).await.unwrap_or_else(|_| panic!("what it is at {place_s} s is told"));
    }
    let until_shown = async |wanted: &[&str]| {
        let shown = async {
            while !gateway.status().planes.iter().map(|(_, name)| name.as_str()).eq(wanted.iter().copied()) {
                tokio::task::yield_now().await;
            }
        };
        tokio::time::timeout(WAIT, shown).await.unwrap_or_else(|_| panic!("{:?}", gateway.status()));
    };
    let mut both = [NAME, "/plane_7/mavros"];
    if replay.vehicles().next() > Some(id) {
        both.reverse();
    }
    until_shown(&both).await;
    assert!(station.close_replay(replay.id()).await);
    until_shown(&["/plane_7/mavros"]).await;
    // The router hears of it a moment later.
    let gone = async {
        loop {
            let found = examine(&config(&at, false).router, 0).await.expect("reached");
            if found.nodes.iter().map(|node| node.name.as_str()).eq(["/plane_7/mavros", "/plane_7/mavros/param"]) {
                return;
            }
        }
    };
    tokio::time::timeout(WAIT, gone).await.expect("it is gone from the router too");
    // Its name is free again.
    open().await;
    until_shown(&both).await;
    gateway.close().await;
    station.close().await;
}
