//! Tests of the archive, on folders of their own.

use vencejo_proto::{Address, Header, Heartbeat, MavVersion, Message as MavMessage};
use vencejo_store::{Floors, Space};

use super::*;
use crate::history::fill::Held;
use crate::payload::Held as Control;
use crate::stamp::Stamper;
use crate::state_source::StateSource;

#[test]
fn what_is_noted_is_read_again() {
    let held = Held::of([(1, 5), (9, 9)].into_iter().collect(), [(6, 6)].into_iter().collect());
    let numbers: Numbers = [((u64::MAX, Stream::State), held.clone()), ((7, Stream::Audit), held)].into();
    let file = Some("plane7_2026-11-25T08-00-00Z.mcap".to_owned());
    for unread in [Unread::default(), Unread { file: file.clone(), is_ended: false }, Unread { file, is_ended: true }] {
        assert_eq!(of_text(&to_text(&numbers, unread.clone())), Some((numbers.clone(), unread)));
    }
    for bad in ["", "{}", r#"{"format": 2, "streams": []}"#] {
        assert_eq!(of_text(bad.as_bytes()), None, "{bad}");
    }
}

#[test]
fn each_aircraft_has_its_turn() {
    let names: Vec<Name> = ["a", "b", "c"].map(|name| name.parse().expect("a name")).into();
    let (mut last, mut had) = (None, Vec::new());
    for _ in 0..6 {
        let next = from_behind(names.clone(), last.as_ref()).remove(0);
        had.push(next.to_string());
        last = Some(next);
    }
    assert_eq!(had, ["a", "b", "c", "a", "b", "c"]);
    let gone = "bb".parse().expect("a name");
    assert_eq!(from_behind(names, Some(&gone))[0].as_str(), "c", "one that is not due any more");
}

/// How many aircraft are kept; more than files are open at a time when it is not set.
const AIRCRAFT: &str = "VENCEJO_TEST_AIRCRAFT";

fn many() -> usize {
    std::env::var(AIRCRAFT).ok().and_then(|text| text.parse().ok()).unwrap_or(80)
}

struct Scratch(PathBuf);

impl Scratch {
    fn new(name: &str) -> Self {
        Self(std::env::temp_dir().join(format!("vencejo-archive-{name}-{}", std::process::id())))
    }

    fn archive(&self) -> Arc<Archive> {
        let floors = Floors::from_mb(0, 0, 0).expect("floors");
        let space = Space::with_probe(floors, |_| Ok(u64::MAX));
        let config = HistoryConfig { folder: self.0.clone(), quota_bytes: 1 << 30, space, with_frames: false };
        Arc::new(Archive::open("acme".parse().expect("a name"), config).expect("an archive"))
    }
}

impl Drop for Scratch {
    fn drop(&mut self) {
        // What is left in the temporary folder is of no use to anybody.
        let _ = std::fs::remove_dir_all(&self.0);
    }
}

fn name_of(index: usize) -> Name {
    format!("plane{index}").parse().expect("a name")
}

/// States 1 to `count` of one boot, as bytes too.
fn states(boot: u64, count: u64) -> Vec<(State, Vec<u8>)> {
    let plane = Address::new(7, 1);
    let mut source = StateSource::new(boot, plane, Stamper::new(&[7; 32]));
    let state = |number: u64| {
        let now = MonoTime::from_millis(number * 100);
        let heartbeat = MavMessage::Heartbeat(Heartbeat { custom_mode: number as u32, ..Heartbeat::default() });
        source.on_frame(&heartbeat.encode(Header { sequence: 0, source: plane, version: MavVersion::V2 }), now);
        let state = source.sample(Control::default(), now);
        let bytes = state.encode_to_vec();
        (state, bytes)
    };
    (1..=count).map(state).collect()
}

fn hear(archive: &Archive, index: usize, states: &[(State, Vec<u8>)]) {
    for (state, bytes) in states {
        archive.on_state(&name_of(index), state, bytes, MonoTime::ZERO);
    }
}

fn have(archive: &Archive, index: usize, boot: u64) -> Vec<(u64, u64)> {
    let all = archive.lock();
    let held = all.get(&name_of(index)).and_then(|kept| kept.fill.held().get(&(boot, Stream::State)).cloned());
    held.unwrap_or_default().have.iter().collect()
}

/// What the files of an aircraft have, in their order.
fn written(folder: &std::path::Path, index: usize) -> Vec<Vec<u8>> {
    let shelf = Shelf::new(folder.to_owned(), prefix(name_of(index).as_str()));
    let names = shelf.names().expect("read").into_iter();
    names.flat_map(|name| Shelf::file(&folder.join(name)).expect("read").1).map(|record| record.data).collect()
}

#[tokio::test]
async fn more_aircraft_than_files_may_be_open_are_kept_whole_and_found_again() {
    let scratch = Scratch::new("many");
    let archive = scratch.archive();
    let said = states(5, 20);
    for index in 0..many() {
        hear(&archive, index, &said[..10]);
    }
    archive.close();
    let bytes: Vec<_> = said.iter().map(|(_, bytes)| bytes.clone()).collect();
    for index in 0..many() {
        assert_eq!(written(&scratch.0, index), bytes[..10], "plane{index}, byte by byte");
    }
    // One lost its note, one has an old one, and one is damaged: the newest file says what there is.
    std::fs::remove_file(archive.path(&name_of(0))).expect("removed");
    std::fs::write(archive.path(&name_of(1)), to_text(&Numbers::new(), Unread::default())).expect("written");
    std::fs::write(archive.path(&name_of(2)), "{").expect("written");
    let archive = scratch.archive();
    assert!(archive.lock().values().all(|kept| !kept.may_ask()), "nothing is asked before the files were read");
    archive.read_all().await;
    for index in 0..many() {
        assert_eq!(have(&archive, index, 5), [(1, 10)], "plane{index}");
        hear(&archive, index, &said);
    }
    archive.close();
    for index in 0..many() {
        assert_eq!(written(&scratch.0, index), bytes, "plane{index}: nothing twice, nothing missing");
    }
}

#[test]
fn it_has_room_for_as_many_as_a_station_follows() {
    let scratch = Scratch::new("room");
    let archive = scratch.archive();
    for index in 0..=MAX_AIRCRAFT {
        archive.on_present(&name_of(index), MonoTime::ZERO);
    }
    assert_eq!((MAX_AIRCRAFT, archive.lock().len()), (1024, 1024));
}

#[test]
fn a_file_that_was_begun_in_the_same_second_is_the_newer_one() {
    let scratch = Scratch::new("second");
    let names =
        ["plane1_2026-11-25T08-00-00Z.mcap", "plane1_2026-11-25T08-00-00Z-1.mcap", "plane1_2026-11-25T08-00-01Z.mcap"];
    std::fs::create_dir_all(&scratch.0).expect("made");
    names.iter().rev().for_each(|name| std::fs::write(scratch.0.join(name), "").expect("written"));
    assert_eq!(Shelf::new(scratch.0.clone(), prefix("plane1")).names().expect("read"), names);
}
