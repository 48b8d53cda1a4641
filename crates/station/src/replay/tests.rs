//! Replays under a paused clock: pace, places, the end, and a live vehicle beside them.

use std::io::Write;
use std::path::PathBuf;
use std::time::Duration;

use tokio::runtime::Handle;
use tokio::time::sleep;
use vencejo_flight::plan::{MissionItem, PlanKind, items_to_wire};
use vencejo_link::{LinkId, Origin, PeerId, write_entry};
use vencejo_proto::dialect::{HOME_POSITION_DATA, MISSION_COUNT_DATA, MavMessage};
use vencejo_proto::{Address, ComponentId, Header, Heartbeat, MavVersion, Message, StatusText, SystemId};
use vencejo_vehicle::Request;
use vencejo_vehicle::telemetry::Severity;

use super::{MarkKind, Replay, ReplayOptions};
use crate::{Station, StationConfig, StationError, Taken, VehicleHandle};

const START_US: u64 = 1_700_000_000_000_000;
const PLANE: Address = Address::new(1, 1);
/// `MANUAL` to `AUTO` of an ArduPlane.
const MODES: [u32; 3] = [0, 5, 10];

struct Folder(PathBuf);

impl Folder {
    fn new(name: &str) -> Self {
        let folder = std::env::temp_dir().join(format!("vencejo-replay-{name}-{}", std::process::id()));
        std::fs::create_dir_all(&folder).expect("a folder");
        Self(folder)
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        let _ = std::fs::remove_dir_all(&self.0);
    }
}

fn heartbeat(custom_mode: u32) -> Message {
    Message::Heartbeat(Heartbeat { mav_type: 1, autopilot: 3, custom_mode, ..Heartbeat::default() })
}

fn header(source: Address) -> Header {
    Header { sequence: 0, source, version: MavVersion::V2 }
}

/// A minute: a heartbeat each second, in another mode each 20 s; home at 2 s; a text at 30 s; silence from 41 s to 55 s.
fn recording(folder: &Folder, name: &str) -> PathBuf {
    let mut bytes = Vec::new();
    let mut write = |ms: u64, message: &Message| {
        write_entry(&mut bytes, START_US + ms * 1000, &message.encode(header(PLANE)));
    };
    for second in 0..=60_u64 {
        if second == 2 {
            write(
                2_500,
                &Message::Dialect(MavMessage::HOME_POSITION(HOME_POSITION_DATA {
                    latitude: 404_000_000,
                    ..Default::default()
                })),
            );
        }
        if second == 30 {
            write(30_500, &Message::StatusText(StatusText { severity: 2, text: "Engine".into(), id: 0, chunk_seq: 0 }));
        }
        if !(42..55).contains(&second) {
            write(second * 1000, &heartbeat(MODES[(second / 20).min(2) as usize]));
        }
    }
    let path = folder.0.join(name);
    std::fs::File::create(&path).and_then(|mut file| file.write_all(&bytes)).expect("written");
    path
}

fn station() -> Station {
    Station::start(StationConfig::default(), Handle::current()).expect("a station starts")
}

fn vehicle(station: &Station, replay: &Replay) -> VehicleHandle {
    station.vehicle(replay.vehicles().next().expect("one")).expect("it is there")
}

fn mode(vehicle: &VehicleHandle) -> Option<String> {
    vehicle.telemetry().0.mode().map(|mode| mode.to_string())
}

/// Age of the heartbeat, ms.
fn age_ms(vehicle: &VehicleHandle) -> Option<u128> {
    let (telemetry, now) = vehicle.telemetry();
    telemetry.heartbeat.map(|heartbeat| heartbeat.age(now).as_millis())
}

/// Until the replay has shown all that it should have by now.
async fn settled(replay: &Replay) {
    // Reading is done off the runtime, during which a paused clock stands still.
    sleep(Duration::from_millis(1)).await;
    let _ = replay.status();
}

/// Half a minute with a mission of one item that is read at 10 s, and with one of two items from 20 s on.
fn recording_with_plans(folder: &Folder) -> PathBuf {
    let mut bytes = Vec::new();
    let mut write =
        |ms: u64, message: &Message| write_entry(&mut bytes, START_US + ms * 1000, &message.encode(header(PLANE)));
    for second in 0..=30_u64 {
        write(second * 1000, &heartbeat(10));
        let count = match second {
            10 => 2,
            20 => 3,
            _ => continue,
        };
        let items: Vec<_> = (0..count).map(|at| MissionItem::waypoint(40.1, -3.7, 80.0 + f64::from(at))).collect();
        let counted = MISSION_COUNT_DATA { count, target_system: 255, target_component: 190, ..Default::default() };
        write(second * 1000 + 100, &Message::Dialect(MavMessage::MISSION_COUNT(counted)));
        for item in items_to_wire(&items, Address::new(255, 190), PlanKind::Mission).expect("items") {
            write(second * 1000 + 200, &Message::MissionItemInt(item));
        }
    }
    let path = folder.0.join("plans.tlog");
    std::fs::write(&path, bytes).expect("written");
    path
}

#[tokio::test(start_paused = true)]
async fn it_shows_the_plan_that_was_on_board_at_each_place() {
    let (folder, station) = (Folder::new("plans"), station());
    let options = ReplayOptions { start: Duration::from_secs(15), ..ReplayOptions::default() };
    let replay = station.open_replay(&recording_with_plans(&folder), options).await.expect("it is opened");
    let items = |replay: &Replay| {
        let (state, list) = vehicle(&station, replay).plan_on_board(PlanKind::Mission).expect("it is there");
        (state.count(), list.map(|list| list.items.len()))
    };
    settled(&replay).await;
    assert_eq!(items(&replay), (Some(1), Some(1)), "what was read before");
    sleep(Duration::from_secs(6)).await;
    assert_eq!(items(&replay), (Some(2), Some(2)));
    replay.pause();
    for (place, count) in [(5, None), (19, Some(1)), (25, Some(2))] {
        replay.seek(Duration::from_secs(place));
        settled(&replay).await;
        assert_eq!(items(&replay), (count, count.map(usize::from)), "at {place} s");
    }
    station.close().await;
}

#[tokio::test(start_paused = true)]
async fn it_is_paused_and_played_at_any_speed_in_the_time_of_the_recording() {
    let (folder, station) = (Folder::new("pace"), station());
    let path = recording(&folder, "flight.tlog");
    let replay = station.open_replay(&path, ReplayOptions::default()).await.expect("it is opened");
    assert_eq!((replay.name(), replay.info().duration), ("flight", Duration::from_secs(60)));
    let modes: Vec<_> = replay.info().marks.iter().map(|mark| (mark.at.as_secs(), mark.kind.clone())).collect();
    assert_eq!(modes, [(20, MarkKind::Mode("FBWA".into())), (40, MarkKind::Mode("AUTO".into()))]);
    let plane = vehicle(&station, &replay);
    assert!(plane.is_recorded() && plane.id().is_far(), "it has an id of its own");
    sleep(Duration::from_millis(10_200)).await;
    assert_eq!((mode(&plane).as_deref(), plane.texts().len()), (Some("MANUAL"), 0));
    let status = replay.status();
    assert_eq!(
        (status.position.as_millis() / 100, status.unix_us.map(|us| (us - START_US) / 100_000)),
        (102, Some(102))
    );
    replay.pause();
    settled(&replay).await;
    let before = age_ms(&plane);
    sleep(Duration::from_secs(3600)).await;
    assert_eq!((replay.status().position.as_millis() / 100, age_ms(&plane)), (102, before), "time stands still");
    replay.set_speed(4.0);
    replay.play();
    sleep(Duration::from_millis(3_000)).await;
    assert_eq!((replay.status().position.as_secs(), mode(&plane).as_deref()), (22, Some("FBWA")));
    assert!(age_ms(&plane).is_some_and(|age| age <= 1_000), "{:?}", age_ms(&plane));
    replay.set_speed(0.5);
    sleep(Duration::from_secs(20)).await;
    assert_eq!(replay.status().position.as_secs(), 32);
    let text = plane.newest_text(Severity::WARNING, Duration::from_secs(5)).expect("a text of the last seconds");
    assert_eq!(plane.moment(text.at).as_secs(), 30, "its time is its place in the recording");
    station.close().await;
}

#[tokio::test(start_paused = true)]
async fn its_texts_have_the_utc_of_the_recorders_clock_which_was_set() {
    const SET_US: u64 = 26 * 3600 * 1_000_000;
    let (folder, station) = (Folder::new("clock"), station());
    let mut bytes = Vec::new();
    for second in 0..=30_u64 {
        let unix_us = START_US + second * 1_000_000 + if second < 20 { 0 } else { SET_US };
        write_entry(&mut bytes, unix_us, &heartbeat(0).encode(header(PLANE)));
        if second % 15 == 10 {
            let text = StatusText { severity: 6, text: second.to_string(), id: 0, chunk_seq: 0 };
            write_entry(&mut bytes, unix_us, &Message::StatusText(text).encode(header(PLANE)));
        }
    }
    let path = folder.0.join("set.tlog");
    std::fs::write(&path, bytes).expect("written");
    let replay = station.open_replay(&path, ReplayOptions::default()).await.expect("it is opened");
    let plane = vehicle(&station, &replay);
    let texts = || {
        let utc = |at| replay.unix_us_at(plane.moment(at)).map(|unix_us| unix_us - START_US);
        plane.texts().into_iter().map(|text| (text.text, utc(text.at))).collect::<Vec<_>>()
    };
    let told = [("10".to_owned(), Some(10_000_000)), ("25".to_owned(), Some(25_000_000 + SET_US))];
    sleep(Duration::from_secs(28)).await;
    assert_eq!(texts(), told);
    replay.seek(Duration::from_secs(27));
    replay.arrived().await;
    assert_eq!(texts(), told, "at another place too");
    station.close().await;
}

#[tokio::test(start_paused = true)]
async fn at_another_place_nothing_from_elsewhere_is_current() {
    let (folder, station) = (Folder::new("seek"), station());
    let path = recording(&folder, "flight.tlog");
    let options = ReplayOptions { start: Duration::from_secs(50), ..ReplayOptions::default() };
    let replay = station.open_replay(&path, options).await.expect("it is opened");
    replay.pause();
    settled(&replay).await;
    let plane = vehicle(&station, &replay);
    let known =
        |plane: &VehicleHandle| (mode(plane), age_ms(plane), plane.telemetry().0.home.is_some(), plane.texts().len());
    assert_eq!(
        known(&plane),
        (Some("AUTO".into()), Some(9_000), true, 1),
        "what was known after nine seconds of silence"
    );
    let (telemetry, now) = plane.telemetry();
    assert_eq!(telemetry.home.map(|home| home.age(now).as_millis()), Some(47_500));
    replay.seek(Duration::from_millis(1_200));
    assert_eq!(replay.status().seeks, 1, "it is not there yet");
    replay.arrived().await;
    assert_eq!(known(&plane), (Some("MANUAL".into()), Some(200), false, 0), "there was neither home nor text yet");
    assert_eq!(
        (replay.status().position.as_millis(), replay.status().seeks, replay.status().is_paused),
        (1_200, 2, true)
    );
    replay.seek(Duration::from_secs(25));
    replay.seek(Duration::from_secs(20));
    settled(&replay).await;
    assert_eq!(known(&plane), (Some("FBWA".into()), Some(0), true, 0), "the last one counts");
    let events = plane.subscribe_events(64);
    replay.seek(Duration::from_secs(50));
    replay.arrived().await;
    assert_eq!(known(&plane).3, 1);
    assert!(matches!(events.take_ready(), Taken::TimedOut), "what was known there is no news");
    station.close().await;
}

#[tokio::test(start_paused = true)]
async fn it_stays_at_its_end_begins_again_when_played_and_goes_when_closed() {
    let (folder, station) = (Folder::new("end"), station());
    let path = recording(&folder, "flight.tlog");
    let options = ReplayOptions { speed: 10.0, ..ReplayOptions::default() };
    let replay = station.open_replay(&path, options).await.expect("it is opened");
    let plane = vehicle(&station, &replay);
    sleep(Duration::from_secs(7)).await;
    let at_the_end = replay.status();
    assert!(at_the_end.is_over && at_the_end.position == Duration::from_secs(60), "{at_the_end:?}");
    sleep(Duration::from_secs(3600)).await;
    assert_eq!((replay.status(), age_ms(&plane)), (at_the_end, Some(0)), "it stays there");
    replay.play();
    sleep(Duration::from_millis(2_150)).await;
    assert_eq!((replay.status().is_over, mode(&plane).as_deref()), (false, Some("FBWA")));
    let again = station.open_replay(&path, ReplayOptions::default()).await.expect("the same one");
    assert_eq!((again.id(), station.replays().len()), (replay.id(), 1));
    settled(&replay).await;
    assert_eq!(mode(&plane).as_deref(), Some("MANUAL"));
    assert!(station.close_replay(replay.id()).await && !station.close_replay(replay.id()).await);
    assert!(station.vehicle(plane.id()).is_none() && station.replays().is_empty());
    let repeat = ReplayOptions { speed: 60.0, repeat: true, ..ReplayOptions::default() };
    let endless = station.open_replay(&path, repeat).await.expect("it is opened again");
    sleep(Duration::from_secs(5)).await;
    assert!(endless.status().seeks > 3 && !endless.status().is_over, "{:?}", endless.status());
    station.close().await;
}

#[tokio::test(start_paused = true)]
async fn a_live_vehicle_and_its_recording_stay_two_whatever_their_ids() {
    let (folder, station) = (Folder::new("two"), station());
    let hear = |custom_mode| {
        let origin = Origin { link: LinkId(0), peer: PeerId(0) };
        let source = Address { system: SystemId(1), component: ComponentId(1) };
        station.shared.on_frame(origin, &heartbeat(custom_mode).encode(header(source)), station.now());
    };
    let early = station.open_replay(&recording(&folder, "early.tlog"), ReplayOptions::default()).await.expect("opened");
    early.arrived().await;
    let waiting = station.wait_vehicle(None);
    settled(&early).await;
    assert!(waiting.end().is_none(), "no recording is taken for the plane");
    assert!(station.close_replay(early.id()).await && early.status().is_over);
    hear(10);
    assert!(waiting.wait().await.is_some_and(|found| found.is_ok_and(|plane| plane.id() == SystemId(1).into())));
    let one = station.open_replay(&recording(&folder, "a.tlog"), ReplayOptions::default()).await.expect("opened");
    let other = station.open_replay(&recording(&folder, "b.tlog"), ReplayOptions::default()).await.expect("opened");
    hear(10);
    sleep(Duration::from_secs(3)).await;
    let live = station.vehicle(SystemId(1)).expect("heard");
    assert_eq!(station.vehicles().len(), 1, "those that are only looked at are not taken for the station's");
    let names: Vec<_> = station.shown_vehicles().iter().map(|vehicle| (vehicle.remote_name(), mode(vehicle))).collect();
    let told = |name: Option<&str>, mode: &str| (name.map(str::to_owned), Some(mode.to_owned()));
    assert_eq!(names.len(), 3);
    assert_eq!((live.is_recorded(), live.rival(), mode(&live).as_deref()), (false, None, Some("AUTO")));
    for name in ["a (replay)", "b (replay)"] {
        assert!(names.contains(&told(Some(name), "MANUAL")), "{names:?}");
    }
    for replay in [one, other] {
        let recorded = vehicle(&station, &replay);
        let refused = recorded.request(Request::ReturnToLaunch).wait().await;
        assert!(matches!(refused, Some(Err(StationError::Replayed { .. }))), "{refused:?}");
        assert!(matches!(recorded.send(&heartbeat(0), false, None), Err(StationError::Replayed { .. })));
        assert_eq!((recorded.is_reached(), recorded.held_far()), (None, None));
    }
    let noise = folder.0.join("noise.tlog");
    std::fs::write(&noise, [7; 5000]).expect("written");
    for path in [&noise, &folder.0.join("none.tlog")] {
        let refused = station.open_replay(path, ReplayOptions::default()).await;
        assert!(matches!(refused, Err(StationError::BadRecording { .. })), "{refused:?}");
    }
    station.close().await;
}
