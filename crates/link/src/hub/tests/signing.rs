//! Tests of signatures on links: who is believed, what an attacker gains, and with what we sign.

use vencejo_proto::{FrameDecoder, Heartbeat, KeyUse, SignatureFault, dialect};

use super::*;
use crate::clock::testing::WALL_START_US;
use crate::signing::{SigningCounts, UnsignedPolicy};

const VEHICLE: SystemId = SystemId(1);
const OLD: KeyId = KeyId(1);
const NEW: KeyId = KeyId(2);

fn key(id: KeyId) -> SigningKey {
    SigningKey::new([id.0 as u8; SigningKey::LEN]).unwrap()
}

fn has(keys: &[KeyId], signs_with: Option<KeyId>, must_sign: bool) -> VehicleKeys {
    VehicleKeys { keys: keys.to_vec(), signs_with, must_sign }
}

/// The other end: it signs as a vehicle does, a little later each time.
struct Signer(KeyUse);

impl Signer {
    fn new(id: KeyId) -> Self {
        Self(KeyUse::new(key(id), SigningTime::default()))
    }

    fn sign(&mut self, frame: &Frame) -> Frame {
        self.0.sign(frame, 0, WALL_START_US + 10_000_000).unwrap().unwrap()
    }
}

impl Bench {
    /// A hub whose vehicle 1 must sign with the old key.
    fn signing(forwards: &[bool]) -> (Self, Signer) {
        let bench = Self::new(forwards);
        bench.hub.add_signing_key(OLD, key(OLD), SigningTime::default());
        bench.hub.set_vehicle_keys(VEHICLE, has(&[OLD], Some(OLD), true));
        (bench, Signer::new(OLD))
    }

    fn counts(&self) -> SigningCounts {
        self.hub.signing(VEHICLE).unwrap().counts
    }
}

fn v1(frame: &Frame) -> Frame {
    let header = Header { sequence: frame.sequence(), source: frame.source(), version: MavVersion::V1 };
    frame.decode().unwrap().encode(header)
}

// fault 38: MAVLink 1, unsigned, wrongly signed, damaged and unknown frames: 0 heard, 0 forwarded, 0 routes; RADIO_STATUS passes
#[test]
fn what_is_not_signed_goes_nowhere_but_the_report_of_a_radio() {
    let (bench, mut vehicle) = Bench::signing(&[false, true]);
    let heard = bench.listen(SinkScope::All);
    let plain = heartbeat(1, 1, 0);
    let genuine = vehicle.sign(&plain);
    let mut torn = genuine.bytes().to_vec();
    *torn.last_mut().unwrap() ^= 1;
    let mut decoder = FrameDecoder::new();
    decoder.push(&torn);
    let forged = [v1(&plain), plain.clone(), signed(&plain), decoder.next_frame().unwrap(), unknown(1, 1, 0)];
    for frame in &forged {
        bench.receive(0, frame);
    }
    assert!(heard.lock().unwrap().is_empty());
    assert!(bench.given().iter().all(Vec::is_empty), "not passed on either");
    assert!(bench.hub.links_of(VEHICLE).is_empty(), "and no route was learned");
    let counts = bench.counts();
    assert_eq!((counts.verified, counts.unsigned, counts.wrong_key, counts.refused()), (0, 3, 2, 5));
    assert_eq!(bench.hub.stats(bench.ports[0].id).unwrap().refused, 5);
    assert_eq!(bench.hub.stats(bench.ports[0].id).unwrap().last_seen, None, "nobody was heard");

    let radio = dialect::MavMessage::RADIO_STATUS(dialect::RADIO_STATUS_DATA::default());
    let header = Header { sequence: 9, source: Address::new(1, 68), version: MavVersion::V1 };
    bench.receive(0, &Message::Dialect(radio).encode(header));
    bench.receive(0, &genuine);
    let ids: Vec<_> = heard.lock().unwrap().iter().map(|(_, frame)| frame.message_id()).collect();
    assert_eq!(ids, [109, 0]);
    assert_eq!(bench.given()[1], [genuine], "untouched");
}

// fault 38: without the key 0 frames are believed
#[test]
fn who_lost_the_key_hears_nothing_rather_than_everything() {
    let bench = Bench::new(&[false]);
    let heard = bench.listen(SinkScope::All);
    bench.hub.set_vehicle_keys(VEHICLE, has(&[OLD], Some(OLD), true));
    bench.receive(0, &heartbeat(1, 1, 0));
    bench.receive(0, &Signer::new(OLD).sign(&heartbeat(1, 1, 1)));
    assert!(heard.lock().unwrap().is_empty());
    assert_eq!(bench.counts().refused(), 2);
}

// fault 35: largest time with a wrong and with the right key: the next true frame is heard; the attacker is not the way to the vehicle
#[test]
fn repetition_and_poison_harm_nobody() {
    let (bench, mut vehicle) = Bench::signing(&[false, false]);
    let heard = bench.listen(SinkScope::All);
    let first = vehicle.sign(&heartbeat(1, 1, 0));
    bench.receive(0, &first);
    bench.clock.advance_ms(2000);
    bench.receive(0, &first);
    let poison = |with: &SigningKey| heartbeat(1, 1, 1).signed(with, 0, SigningTime::MAX).unwrap();
    bench.receive(1, &poison(&key(NEW)));
    bench.receive(1, &poison(&key(OLD)));
    bench.receive(0, &vehicle.sign(&heartbeat(1, 1, 2)));
    assert_eq!(heard.lock().unwrap().len(), 2, "the true ones");
    let counts = bench.counts();
    assert_eq!((counts.verified, counts.replayed, counts.wrong_key, counts.future), (2, 1, 1, 1));
    let links: Vec<_> = bench.hub.links_of(VEHICLE).into_iter().map(|(link, _)| link).collect();
    assert_eq!(links, [bench.ports[0].id], "the attacker's link is not the way to the vehicle");
}

#[test]
fn a_signed_frame_over_a_second_link_is_a_copy_and_teaches_its_route() {
    let (bench, mut vehicle) = Bench::signing(&[false, false]);
    let heard = bench.listen(SinkScope::All);
    for sequence in 0..100 {
        bench.clock.advance_ms(10);
        let frame = vehicle.sign(&heartbeat(1, 1, sequence));
        bench.receive(usize::from(sequence % 3 == 0), &frame);
        bench.receive(usize::from(sequence % 3 != 0), &frame);
    }
    assert_eq!((heard.lock().unwrap().len(), bench.counts().verified, bench.counts().refused()), (100, 100, 0));
    let stats = |port: &Arc<Port>| bench.hub.stats(port.id).unwrap();
    assert_eq!(bench.ports.iter().map(|port| stats(port).copies).sum::<u64>(), 100);
    assert!(bench.ports.iter().all(|port| (stats(port).received.frames, stats(port).lost) == (100, 0)));
    assert_eq!(bench.hub.links_of(VEHICLE).len(), 2);
    let frame = vehicle.sign(&heartbeat(1, 1, 100));
    bench.receive(0, &frame);
    let mut forged = frame.bytes().to_vec();
    *forged.last_mut().unwrap() ^= 1;
    let mut decoder = FrameDecoder::new();
    decoder.push(&forged);
    bench.receive(1, &decoder.next_frame().unwrap());
    assert_eq!(bench.counts().wrong_key, 1, "with another signature it is no copy");
}

#[test]
fn a_peer_is_known_by_admitted_frames_alone() {
    let (bench, mut vehicle) = Bench::signing(&[false]);
    let systems = crate::systems::SystemSet::default();
    let hears = |frame: &Frame| {
        let peer = Peer { id: PeerId(1), systems: Some(&systems) };
        bench.hub.receive(&bench.ports[0], peer, frame, bench.clock.now(), &mut Onward::default());
        systems.contains(VEHICLE)
    };
    assert!(!hears(&heartbeat(1, 1, 0)), "anybody may say so");
    assert!(hears(&vehicle.sign(&heartbeat(1, 1, 1))));
}

#[cfg(unix)]
#[test]
fn a_device_is_looked_at_anew_at_each_connection() {
    use std::os::unix::fs::symlink;

    let (bench, folder) = (Bench::new(&[]), crate::testing::TempDir::new());
    let [by_id, acm, usb] = ["usb-ArduPilot_1", "ttyACM0", "ttyUSB0"].map(|name| folder.0.join(name));
    let (_, state) = watch::channel(LinkState::Down);
    let address = format!("serial:{}:115200", by_id.display()).parse().unwrap();
    let port = bench.hub.attach(address, LinkOptions::default(), Arc::new(Kept::with_room(0)), state).unwrap();
    let is_believed = || bench.hub.links()[0].accepts_unsigned;
    assert!(!is_believed(), "it is not plugged in");
    for (device, expected) in [(&acm, true), (&usb, false), (&acm, true)] {
        std::fs::write(device, "").unwrap();
        symlink(device, &by_id).unwrap();
        bench.hub.on_connected(&port);
        assert_eq!(is_believed(), expected, "{}", device.display());
        std::fs::remove_file(&by_id).unwrap();
    }
}

#[test]
fn a_link_that_nobody_else_can_reach_is_believed() {
    let (mut bench, _) = Bench::signing(&[]);
    for (text, unsigned, believed) in [
        ("udpin:127.0.0.1:14550", UnsignedPolicy::ByAddress, true),
        ("tcp:localhost:5760", UnsignedPolicy::ByAddress, true),
        ("tcp:[::1]:5760", UnsignedPolicy::ByAddress, true),
        ("/dev/ttyACM0", UnsignedPolicy::ByAddress, true),
        ("/dev/ttyUSB0,57600", UnsignedPolicy::ByAddress, false),
        ("udpin:0.0.0.0:14550", UnsignedPolicy::ByAddress, false),
        ("tcp:192.168.1.7:5760", UnsignedPolicy::ByAddress, false),
        ("udpbcast:127.255.255.255:14550", UnsignedPolicy::ByAddress, false),
        ("tcp:192.168.1.7:5760", UnsignedPolicy::Accept, true),
        ("tcp:127.0.0.1:5760", UnsignedPolicy::Refuse, false),
    ] {
        let (_, state) = watch::channel(LinkState::Down);
        let options = LinkOptions { unsigned, ..LinkOptions::default() };
        let port = bench.hub.attach(text.parse().unwrap(), options, Arc::new(Kept::with_room(0)), state).unwrap();
        assert_eq!(bench.hub.links().last().unwrap().accepts_unsigned, believed, "{text}");
        let before = bench.counts();
        bench.hub.receive(&port, Peer::default(), &heartbeat(1, 1, 0), bench.clock.now(), &mut Onward::default());
        let after = bench.counts();
        assert_eq!(after.unsigned_accepted - before.unsigned_accepted, u64::from(believed), "{text}");
        assert_eq!(after.refused() - before.refused(), u64::from(!believed), "{text}");
        bench.ports.push(port);
    }
}

#[test]
fn each_frame_is_signed_as_it_leaves_and_for_whom() {
    let (bench, mut vehicle) = Bench::signing(&[false, false]);
    bench.receive(0, &vehicle.sign(&heartbeat(1, 1, 0)));
    bench.receive(1, &heartbeat(2, 1, 0));
    let mut there = KeyUse::new(key(OLD), SigningTime::default());
    let send = |message: &Message, version| bench.hub.send_message(message, US, version, Route::Target);
    for command in 0..50 {
        bench.clock.advance_ms(1);
        let report = send(&command_to(1, command), MavVersion::V1);
        assert!(report.is_sent());
        let given = bench.given();
        assert_eq!((given[0].len(), given[1].len()), (1, 0));
        assert_eq!(there.accept(&given[0][0], bench.clock.unix_us()), Ok(()), "each later than the one before");
    }
    assert!(send(&command_to(2, 1), MavVersion::V2).is_sent());
    assert!(!bench.given()[1][0].is_signed(), "another vehicle has no key");
    // For everyone: signed where the key was seen, and as asked for besides when that is MAVLink 1.
    let everyone = Message::Heartbeat(Heartbeat::default());
    let _ = bench.hub.send_message(&everyone, US, MavVersion::V2, Route::All);
    let kinds = |frames: &[Frame]| frames.iter().map(|frame| (frame.version(), frame.is_signed())).collect::<Vec<_>>();
    let given = bench.given();
    assert_eq!(kinds(&given[0]), [(MavVersion::V2, true)]);
    assert_eq!(kinds(&given[1]), [(MavVersion::V2, false)]);
    let _ = bench.hub.send_message(&everyone, US, MavVersion::V1, Route::All);
    let given = bench.given();
    assert_eq!(kinds(&given[0]), [(MavVersion::V2, true), (MavVersion::V1, false)]);
    assert_eq!(kinds(&given[1]), [(MavVersion::V1, false)]);
}

#[test]
fn a_vehicle_that_was_away_for_a_month_is_found_again() {
    // Its time stood still. Its frames are refused as old, but they show who it is: it is answered, and follows.
    let (bench, _) = Bench::signing(&[false]);
    let heard = bench.listen(SinkScope::All);
    let month_ago = SigningTime::from_unix_us(WALL_START_US - 30 * 86_400_000_000);
    let mut vehicle = KeyUse::new(key(OLD), month_ago);
    bench.receive(0, &vehicle.sign(&heartbeat(1, 1, 0), 0, 0).unwrap().unwrap());
    assert_eq!((heard.lock().unwrap().len(), bench.counts().old), (0, 1));
    let _ = bench.hub.send_message(&Message::Heartbeat(Heartbeat::default()), US, MavVersion::V2, Route::All);
    assert_eq!(vehicle.accept(&bench.given()[0][0], 0), Ok(()));
    bench.receive(0, &vehicle.sign(&heartbeat(1, 1, 1), 0, 0).unwrap().unwrap());
    assert_eq!((heard.lock().unwrap().len(), bench.counts().verified), (1, 1));
}

#[test]
fn we_sign_with_the_key_that_the_vehicle_showed_last() {
    let (bench, mut old) = Bench::signing(&[false]);
    bench.hub.add_signing_key(NEW, key(NEW), SigningTime::default());
    bench.hub.set_vehicle_keys(VEHICLE, has(&[OLD, NEW], Some(OLD), true));
    let mut new = Signer::new(NEW);
    let signs_with = || bench.hub.signing(VEHICLE).unwrap().keys.signs_with;
    bench.receive(0, &old.sign(&heartbeat(1, 1, 0)));
    assert_eq!(signs_with(), Some(OLD));
    bench.receive(0, &new.sign(&heartbeat(1, 1, 1)));
    assert_eq!(signs_with(), Some(NEW));
    bench.receive(0, &old.sign(&heartbeat(1, 1, 2)));
    assert_eq!(signs_with(), Some(NEW), "what was under way changes nothing");
    bench.clock.advance_ms(2001);
    bench.receive(0, &old.sign(&heartbeat(1, 1, 3)));
    assert_eq!(signs_with(), Some(OLD), "but one that went back is followed");
    assert_eq!(bench.counts().verified, 4, "and none of it was ever refused");
    bench.hub.set_vehicle_keys(VEHICLE, has(&[NEW], Some(NEW), true));
    bench.receive(0, &old.sign(&heartbeat(1, 1, 4)));
    assert_eq!(bench.counts().wrong_key, 1, "a key that was replaced is worth nothing");
}

#[test]
fn an_unsigned_vehicle_is_believed_until_it_shows_the_key() {
    let bench = Bench::new(&[false]);
    let heard = bench.listen(SinkScope::All);
    bench.hub.add_signing_key(NEW, key(NEW), SigningTime::default());
    bench.hub.set_vehicle_keys(VEHICLE, has(&[NEW], None, false));
    bench.receive(0, &heartbeat(1, 1, 0));
    let state = bench.hub.signing(VEHICLE).unwrap();
    assert_eq!((state.keys.signs_with, state.counts.unsigned_accepted, state.changes), (None, 1, 0));
    bench.receive(0, &Signer::new(NEW).sign(&heartbeat(1, 1, 1)));
    bench.receive(0, &heartbeat(1, 1, 2));
    let state = bench.hub.signing(VEHICLE).unwrap();
    assert_eq!((state.keys, state.changes), (has(&[NEW], Some(NEW), true), 1));
    assert_eq!((state.counts.verified, state.counts.unsigned), (1, 1));
    assert_eq!(heard.lock().unwrap().len(), 2);
}

#[test]
fn who_reaches_us_without_a_key_does_not_reach_the_vehicle_through_us() {
    let (bench, mut vehicle) = Bench::signing(&[false, true]);
    bench.receive(0, &vehicle.sign(&heartbeat(1, 1, 0)));
    bench.given();
    let header = |sequence| Header { sequence, source: Address::new(254, 190), version: MavVersion::V2 };
    for (sequence, system) in [(0, 1), (1, 0)] {
        bench.receive(1, &command_to(system, 400).encode(header(sequence)));
    }
    assert!(bench.given()[0].is_empty(), "the vehicle's own USB would have taken it");
    let mut station = Signer::new(OLD);
    let command = station.sign(&command_to(1, 400).encode(header(2)));
    bench.receive(1, &command);
    assert_eq!(bench.given()[0], [command]);
}

#[test]
fn keys_that_pass_by_are_shown_to_nobody() {
    let bench = Bench::new(&[true, true]);
    let heard = bench.listen(SinkScope::All);
    bench.receive(0, &setup_signing((254, 190), (255, 190), 0));
    bench.receive(0, &setup_signing((254, 190), (0, 0), 1));
    assert!(heard.lock().unwrap().is_empty());
    assert!(bench.given().iter().all(Vec::is_empty));
}

#[test]
fn time_is_kept_for_the_next_run() {
    let (bench, mut vehicle) = Bench::signing(&[false]);
    bench.receive(0, &vehicle.sign(&heartbeat(1, 1, 0)));
    let frame = vehicle.sign(&heartbeat(1, 1, 1));
    bench.receive(0, &frame);
    let [(id, latest, reserved)] = bench.hub.signing_times()[..] else { panic!("one key") };
    assert_eq!((id, latest), (OLD, frame.signature().unwrap().time));
    assert!(reserved > latest);
    let mut next = KeyUse::new(key(OLD), latest);
    assert_eq!(next.accept(&frame, 0), Err(SignatureFault::Replayed));
}
