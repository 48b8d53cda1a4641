//! Tests of the hub: counting, routing, forwarding and listeners together.

use std::sync::atomic::{AtomicU32, Ordering};

use super::*;
use crate::clock::testing::ManualClock;
use crate::outlet::{Class, Sent};
use crate::testing::{US, command_to, heartbeat, radio_status, setup_signing, signed, unknown};

/// An outlet that keeps what it is given, and refuses what is beyond its room.
struct Kept {
    frames: Mutex<Vec<Frame>>,
    room: usize,
}

impl Kept {
    fn with_room(room: usize) -> Self {
        Self { frames: Mutex::default(), room }
    }
}

impl Outlet for Kept {
    fn send(&self, frame: &Frame, _: To, _: Class) -> Sent {
        let mut frames = self.frames.lock().unwrap();
        if frames.len() >= self.room {
            return Sent::Full;
        }
        frames.push(frame.clone());
        Sent::Accepted { displaced: 0 }
    }
}

struct Bench {
    hub: Hub,
    clock: Arc<ManualClock>,
    ports: Vec<Arc<Port>>,
    outlets: Vec<Arc<Kept>>,
}

impl Bench {
    /// A hub with links that forward or not.
    fn new(forwards: &[bool]) -> Self {
        let clock = Arc::new(ManualClock::default());
        clock.advance_ms(10_000);
        let mut bench = Self { hub: Hub::new(vec![US], clock.clone()), clock, ports: Vec::new(), outlets: Vec::new() };
        for forwards in forwards {
            bench.add(*forwards, usize::MAX);
        }
        bench
    }

    fn add(&mut self, forwards: bool, room: usize) {
        let outlet = Arc::new(Kept::with_room(room));
        let (_, state) = watch::channel(LinkState::Down);
        let options = LinkOptions { forwards, ..LinkOptions::default() };
        let port = self.hub.attach("udpin:".parse().unwrap(), options, outlet.clone(), state).unwrap();
        self.ports.push(port);
        self.outlets.push(outlet);
    }

    /// A link that plays a recording.
    fn replay(&mut self, forwards: bool) {
        let (_, state) = watch::channel(LinkState::Down);
        let options = LinkOptions { forwards, ..LinkOptions::default() };
        let outlet = Arc::new(Kept::with_room(0));
        let port = self.hub.attach("tlog:flight.tlog".parse().unwrap(), options, outlet.clone(), state).unwrap();
        self.ports.push(port);
        self.outlets.push(outlet);
    }

    fn receive(&self, link: usize, frame: &Frame) {
        let mut onward = Onward::default();
        self.hub.receive(&self.ports[link], Peer::default(), frame, self.clock.now(), &mut onward);
        self.hub.end_reading(&mut onward);
    }

    /// What each link was given since the last look.
    fn given(&self) -> Vec<Vec<Frame>> {
        self.outlets.iter().map(|outlet| std::mem::take(&mut *outlet.frames.lock().unwrap())).collect()
    }

    fn listen(&self, scope: SinkScope) -> Arc<Mutex<Vec<(LinkId, Frame)>>> {
        let heard = Arc::new(Mutex::new(Vec::new()));
        let sink = heard.clone();
        self.hub.add_sink(
            scope,
            Arc::new(move |origin: Origin, frame: &Frame, _| sink.lock().unwrap().push((origin.link, frame.clone()))),
        );
        heard
    }
}

#[test]
fn two_links_pass_frames_on_when_one_of_them_forwards() {
    let bench = Bench::new(&[false, false, true, true]);
    let frame = heartbeat(1, 1, 0);
    bench.receive(0, &frame);
    let given = bench.given();
    assert!(given[0].is_empty() && given[1].is_empty(), "vehicles' links keep to themselves");
    assert_eq!((&given[2], &given[3]), (&vec![frame.clone()], &vec![frame]), "untouched");
    let ground = heartbeat(254, 190, 0);
    bench.receive(2, &ground);
    assert_eq!(bench.given().iter().map(Vec::len).collect::<Vec<_>>(), [1, 1, 0, 1]);
}

#[test]
fn signed_and_unknown_frames_pass_as_they_are() {
    let bench = Bench::new(&[false, true]);
    for frame in [signed(&heartbeat(1, 1, 0)), unknown(1, 1, 1)] {
        bench.receive(0, &frame);
        let given = bench.given();
        assert_eq!(given[1].len(), 1);
        assert_eq!(given[1][0].bytes(), frame.bytes());
    }
}

#[test]
fn keys_and_radio_reports_are_not_passed_on() {
    let bench = Bench::new(&[true, true]);
    let heard = bench.listen(SinkScope::ForUs);
    bench.receive(1, &heartbeat(1, 1, 0));
    bench.given();
    bench.receive(0, &setup_signing((254, 190), (1, 1), 0));
    bench.receive(1, &radio_status(0));
    assert_eq!(bench.given(), [Vec::new(), Vec::new()]);
    let heard = heard.lock().unwrap();
    assert_eq!(heard.last().unwrap().1.message_id(), 109, "but we hear how the radio is");
}

#[test]
fn two_routers_joined_by_two_cables_do_not_storm() {
    // Another router without a memory sends everything from one cable back over the other.
    let bench = Bench::new(&[true, true, true]);
    let heard = bench.listen(SinkScope::All);
    let mut rounds = 0;
    for sequence in 0..50 {
        bench.clock.advance_ms(20);
        bench.receive(0, &heartbeat(1, 1, sequence));
        let mut given = bench.given();
        while !(given[1].is_empty() && given[2].is_empty()) {
            rounds += 1;
            assert!(rounds < 1000, "a storm");
            bench.clock.advance_ms(1);
            given[1].iter().for_each(|frame| bench.receive(2, frame));
            given[2].iter().for_each(|frame| bench.receive(1, frame));
            given = bench.given();
        }
    }
    assert_eq!(heard.lock().unwrap().len(), 50, "each is heard once");
    let copies: u64 = bench.ports.iter().map(|port| bench.hub.stats(port.id).unwrap().copies).sum();
    assert!(copies >= 99, "{copies}");
}

#[test]
fn a_second_link_to_the_same_vehicle_is_counted_but_heard_once() {
    let bench = Bench::new(&[false, false]);
    let heard = bench.listen(SinkScope::All);
    for sequence in 0..100 {
        bench.clock.advance_ms(20);
        bench.receive(usize::from(sequence % 3 == 0), &heartbeat(1, 1, sequence));
        bench.receive(usize::from(sequence % 3 != 0), &heartbeat(1, 1, sequence));
    }
    assert_eq!(heard.lock().unwrap().len(), 100);
    for port in &bench.ports {
        let stats = bench.hub.stats(port.id).unwrap();
        assert_eq!((stats.received.frames, stats.lost), (100, 0), "each link is judged by all that it brings");
    }
}

// fault 14: the other link within 3 s after the first fell silent, each command over one link alone
#[test]
fn a_command_goes_over_one_link_and_changes_over_within_the_failover_time() {
    let bench = Bench::new(&[false, false]);
    let command = command_to(1, 400);
    let send = || bench.hub.send_message(&command, US, MavVersion::V2, Route::Target);
    assert!(!send().is_sent(), "never heard: nowhere");
    let mut over = Vec::new();
    for sequence in 0..40 {
        bench.clock.advance_ms(250);
        if sequence < 10 {
            bench.receive(0, &heartbeat(1, 1, sequence));
        }
        bench.receive(1, &heartbeat(1, 1, sequence));
        assert_eq!(send(), SendReport { accepted: 1, refused: 0 });
        let given = bench.given();
        assert_eq!(given[0].len() + given[1].len(), 1, "never twice");
        over.push(given[1].len());
    }
    let change = over.iter().position(|over| *over == 1).unwrap();
    assert!((10..=22).contains(&change), "within 3 s after the link fell silent, not before: {change}");
    assert!(over[change..].iter().all(|over| *over == 1));
    assert_eq!(bench.hub.links_of(SystemId(1)).first().unwrap().0, bench.ports[1].id);
    // A chosen origin comes first.
    let origin = Origin { link: bench.ports[0].id, peer: PeerId(0) };
    bench.hub.choose(Address::new(1, 1), Some(origin));
    assert_eq!(bench.hub.links_of(SystemId(1)).first().unwrap().0, bench.ports[0].id);
}

#[test]
fn a_message_without_a_target_goes_to_one_system_over_the_link_that_it_is_heard_on() {
    let bench = Bench::new(&[false, false]);
    let message = Message::Heartbeat(vencejo_proto::Heartbeat::default());
    let send = |system| bench.hub.send_message(&message, US, MavVersion::V2, Route::System(SystemId(system))).accepted;
    assert_eq!(send(1), 0, "never heard: nowhere");
    bench.receive(1, &heartbeat(1, 1, 0));
    bench.receive(0, &heartbeat(2, 1, 0));
    assert_eq!((send(1), send(1), send(2)), (1, 1, 1));
    assert_eq!(bench.given().iter().map(Vec::len).collect::<Vec<_>>(), [1, 2]);
}

#[test]
fn each_link_has_its_own_frame_counter() {
    let bench = Bench::new(&[false, false]);
    let message = Message::Heartbeat(vencejo_proto::Heartbeat::default());
    for _ in 0..3 {
        assert_eq!(bench.hub.send_message(&message, US, MavVersion::V2, Route::All).accepted, 2);
        let only = Route::Link(bench.ports[1].id);
        assert_eq!(bench.hub.send_message(&message, US, MavVersion::V1, only).accepted, 1);
    }
    let numbers: Vec<Vec<u8>> =
        bench.given().iter().map(|frames| frames.iter().map(Frame::sequence).collect()).collect();
    assert_eq!(numbers, [vec![0, 1, 2], vec![0, 1, 2, 3, 4, 5]]);
}

#[test]
fn what_a_recording_holds_is_shown_to_tees_and_flies_nothing() {
    // A plane at a link of its own, one behind a tee, and a tee for another ground station.
    let mut bench = Bench::new(&[false, true, true]);
    bench.replay(true);
    let header = |sequence| Header { sequence, source: Address::new(255, 200), version: MavVersion::V2 };
    let order = |system, sequence| command_to(system, 400).encode(header(sequence));
    bench.receive(3, &heartbeat(1, 1, 0));
    bench.receive(3, &order(1, 0));
    let (seen, at_tee) = (bench.given(), [heartbeat(1, 1, 0), order(1, 0)]);
    assert_eq!(seen, [vec![], at_tee.to_vec(), at_tee.to_vec(), vec![]], "both sides of the conversation");
    bench.receive(0, &heartbeat(1, 1, 1));
    bench.receive(1, &heartbeat(2, 1, 0));
    bench.given();
    for (system, sequence) in [(1, 1), (2, 2), (0, 3)] {
        bench.receive(3, &order(system, sequence));
    }
    assert_eq!(bench.given(), [vec![], vec![], vec![order(0, 3)], vec![]], "none that a live vehicle would follow");
    bench.receive(3, &heartbeat(1, 1, 2));
    assert_eq!(bench.given().iter().map(Vec::len).collect::<Vec<_>>(), [0, 1, 1, 0]);
}

#[test]
fn refusals_are_reported_and_counted() {
    let mut bench = Bench::new(&[false]);
    bench.add(false, 0);
    let report = bench.hub.send(&heartbeat(255, 190, 0), Route::All);
    assert_eq!(report, SendReport { accepted: 1, refused: 1 });
    let stats = bench.hub.stats(bench.ports[1].id).unwrap();
    assert_eq!((stats.sent.frames, stats.dropped), (0, 1));
    let gone = bench.hub.send(&heartbeat(255, 190, 1), Route::Link(LinkId(999)));
    assert_eq!(gone, SendReport::default());
}

#[test]
fn what_is_read_together_is_passed_on_together_as_far_as_there_is_room() {
    let mut bench = Bench::new(&[true, true]);
    bench.add(true, 3);
    let frames: Vec<_> = (0..5).map(|sequence| heartbeat(1, 1, sequence)).collect();
    let mut onward = Onward::default();
    for frame in &frames {
        bench.hub.receive(&bench.ports[0], Peer::default(), frame, bench.clock.now(), &mut onward);
    }
    assert_eq!(bench.given(), [vec![], vec![], vec![]], "not before all of it is read");
    bench.hub.end_reading(&mut onward);
    bench.hub.end_reading(&mut onward);
    assert_eq!(bench.given(), [vec![], frames.clone(), frames[..3].to_vec()], "once, in their order");
    let counted = |link: usize| {
        let stats = bench.hub.stats(bench.ports[link].id).unwrap();
        (stats.sent.frames, stats.dropped)
    };
    assert_eq!((counted(1), counted(2)), ((5, 0), (3, 2)));
    // Much of it does not wait for the end.
    let flood = (0..200).map(|n| heartbeat(2, 1, n));
    flood.for_each(|frame| bench.hub.receive(&bench.ports[0], Peer::default(), &frame, bench.clock.now(), &mut onward));
    assert!(bench.given()[1].len() > 150);
}

#[test]
fn scopes() {
    let bench = Bench::new(&[true, true]);
    let (all, ours) = (bench.listen(SinkScope::All), bench.listen(SinkScope::ForUs));
    let count = || (all.lock().unwrap().len(), ours.lock().unwrap().len());
    bench.receive(0, &heartbeat(1, 1, 0));
    assert_eq!(count(), (1, 1));
    let to_another =
        command_to(9, 400).encode(Header { sequence: 0, source: Address::new(254, 1), version: MavVersion::V2 });
    bench.receive(1, &to_another);
    assert_eq!(count(), (2, 1));
    let to_us =
        Message::CommandLong(vencejo_proto::CommandLong { target: US, command: 1, confirmation: 0, params: [0.0; 7] });
    bench.receive(0, &to_us.encode(Header { sequence: 1, source: Address::new(1, 1), version: MavVersion::V2 }));
    assert_eq!(count(), (3, 2));
    bench.hub.set_locals(vec![Address::new(9, 1)]);
    bench.clock.advance_ms(2000);
    bench.receive(1, &to_another);
    assert_eq!(count(), (4, 3), "we have become the other");
}

#[test]
fn a_listener_may_call_the_hub() {
    let bench = Bench::new(&[false]);
    let hub = bench.hub.clone();
    let calls = Arc::new(AtomicU32::new(0));
    let counter = calls.clone();
    bench.hub.add_sink(
        SinkScope::All,
        Arc::new(move |origin: Origin, _, _| {
            let message = command_to(1, 400);
            assert!(hub.send_message(&message, US, MavVersion::V2, Route::Target).is_sent());
            hub.note_round_trip(origin.link, Duration::from_millis(7)).unwrap();
            counter.fetch_add(1, Ordering::SeqCst);
        }),
    );
    bench.receive(0, &heartbeat(1, 1, 0));
    assert_eq!(calls.load(Ordering::SeqCst), 1);
    assert_eq!(bench.given()[0].len(), 1);
    let stats = bench.hub.stats(bench.ports[0].id).unwrap();
    assert_eq!(stats.round_trip.unwrap().last, Duration::from_millis(7));
}

#[test]
fn a_closed_link_is_forgotten() {
    let bench = Bench::new(&[true, true]);
    bench.receive(0, &heartbeat(1, 1, 0));
    assert_eq!(bench.hub.links_of(SystemId(1)).len(), 1);
    bench.hub.detach(&bench.ports[0]);
    assert!(bench.hub.links_of(SystemId(1)).is_empty());
    bench.given();
    bench.receive(0, &heartbeat(1, 1, 1));
    assert_eq!(bench.given()[1].len(), 0, "its task may still be reading, but nobody listens");
    assert!(!bench.hub.send_message(&command_to(1, 400), US, MavVersion::V2, Route::Target).is_sent());
}

#[test]
fn both_directions_are_recorded_once() {
    let bench = Bench::new(&[false, true]);
    let folder = crate::testing::TempDir::new();
    let recorder = crate::Recorder::start(
        &folder.0,
        crate::RecorderConfig { free_floor_bytes: 0, ..Default::default() },
        bench.clock.clone(),
    )
    .unwrap();
    bench.hub.set_recorder(Some(recorder.handle()));
    bench.receive(0, &heartbeat(1, 1, 0));
    let _ = bench.hub.send(&heartbeat(255, 190, 0), Route::All);
    bench.receive(1, &setup_signing((254, 190), (1, 1), 0));
    bench.hub.set_recorder(None);
    bench.receive(0, &heartbeat(1, 1, 1));
    let status = recorder.close();
    assert_eq!((status.frames, status.dropped), (2, 0));
    let file = std::fs::read_dir(&folder.0).unwrap().next().unwrap().unwrap().path();
    let entries: Vec<_> =
        crate::TlogReader::new(std::fs::File::open(file).unwrap()).map(|entry| entry.unwrap().frame).collect();
    assert_eq!(entries, [heartbeat(1, 1, 0), heartbeat(255, 190, 0)]);
}

mod signing;
