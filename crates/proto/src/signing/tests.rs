//! Tests of signatures: against what others sign, against forgery, repetition, and clocks that are wrong.

use std::fmt::Write as _;

use rand::{Rng, SeedableRng, rngs::SmallRng};

use super::*;
use crate::{FrameDecoder, Header, Heartbeat, Message};

const CAPTURE: &[u8] = include_bytes!("../../../../tests/fixtures/captures/arduplane-50hz-20s.mavlink");
/// 2026-11-22T08:00:00Z.
const NOW: u64 = 1_795_334_400_000_000;
const SECOND: u64 = 1_000_000;
const DAY: u64 = 24 * 3600 * SECOND;
const YEAR: u64 = 365 * DAY;

fn key(first: u8) -> SigningKey {
    let mut bytes = [0; SigningKey::LEN];
    (0..).zip(&mut bytes).for_each(|(n, byte)| *byte = first + n);
    SigningKey::new(bytes).expect("not zeros")
}

fn recorded() -> Vec<Frame> {
    let mut decoder = FrameDecoder::new();
    decoder.push(CAPTURE);
    std::iter::from_fn(|| decoder.next_frame()).collect()
}

fn heartbeat(version: MavVersion) -> Frame {
    let heartbeat = Heartbeat { mav_type: 1, autopilot: 3, ..Heartbeat::default() };
    Message::Heartbeat(heartbeat).encode(Header { sequence: 7, source: Address::new(1, 1), version })
}

fn signed_at(key: &SigningKey, unix_us: u64) -> Frame {
    heartbeat(MavVersion::V2).signed(key, 0, SigningTime::from_unix_us(unix_us)).expect("can be signed")
}

fn read(bytes: &[u8]) -> Option<Frame> {
    let mut decoder = FrameDecoder::new();
    decoder.push(bytes);
    decoder.next_frame()
}

fn hex(bytes: &[u8]) -> String {
    bytes.iter().fold(String::new(), |mut text, byte| {
        let _ = write!(text, "{byte:02x}");
        text
    })
}

// fault 34: 10,000 frames as pymavlink signs them, 9,618 as the C library does
/// The digest is that of the same 10,000 recorded messages as pymavlink 2.4.50 signs them; the C library (MAVLink 2
/// `mavlink_helpers.h`) accepts and signs the same each of those that its dialect has, 9,618.
#[test]
fn ten_thousand_frames_are_signed_as_pymavlink_and_the_c_library_sign_them() {
    let (key, mut time) = (key(1), SigningTime::from_ticks(0x0123_4567_89ab));
    let mut all = Sha256::new();
    let mut checked = 0;
    let mut verifier = KeyUse::new(key.clone(), SigningTime::default());
    for frame in recorded().iter().take(10_000) {
        let signed = frame.signed(&key, 7, time).expect("can be signed");
        if checked == 0 {
            assert_eq!(hex(signed.bytes()), "fd03010029010124000019c60f00c807ab896745230108feafddeab4");
        }
        all.update(signed.bytes());
        assert_eq!(read(signed.bytes()).as_ref(), Some(&signed), "the decoder takes it");
        assert_eq!(signed.without_signature(), *frame, "and it is the same message");
        assert_eq!(verifier.accept(&signed, 0), Ok(()));
        time = SigningTime::from_ticks(time.ticks() + 1);
        checked += 1;
    }
    assert_eq!(checked, 10_000);
    assert_eq!(hex(&all.finalize()), "ccdb28bd66a3d94548b4e9a23cf9bc18751290009380f0a0e797c16b2a76103d");
}

// fault 34: each changed bit refused
#[test]
fn a_bit_changed_anywhere_is_found() {
    let key = key(1);
    let genuine = signed_at(&key, NOW);
    let mut refused = 0;
    for bit in 0..genuine.bytes().len() * 8 {
        let mut bytes = genuine.bytes().to_vec();
        bytes[bit / 8] ^= 1 << (bit % 8);
        // Only the signature can detect it: a forger recomputes the checksum.
        let forged = Frame::from_checked(bytes.into());
        if !forged.is_signed() || forged.version() != MavVersion::V2 || forged.bytes()[1] != genuine.bytes()[1] {
            continue;
        }
        let mut verifier = KeyUse::new(key.clone(), SigningTime::default());
        assert_eq!(verifier.accept(&forged, NOW), Err(SignatureFault::WrongKey), "bit {bit}");
        assert_eq!(verifier.accept(&genuine, NOW), Ok(()), "and it changed nothing");
        refused += 1;
    }
    assert!(refused > 200, "{refused}");
}

// fault 34: replayed and 61 s old: refused; 59 s: accepted
#[test]
fn what_was_accepted_is_not_accepted_again_and_a_newcomer_may_be_a_minute_old() {
    let mut verifier = KeyUse::new(key(1), SigningTime::default());
    assert_eq!(verifier.accept(&signed_at(&key(1), NOW - 61 * SECOND), NOW), Err(SignatureFault::Old));
    assert_eq!(verifier.accept(&signed_at(&key(1), NOW - 59 * SECOND), NOW), Ok(()));
    let newest = signed_at(&key(1), NOW);
    assert_eq!(verifier.accept(&newest, NOW), Ok(()));
    for again in [&newest, &signed_at(&key(1), NOW - 10)] {
        assert_eq!(verifier.accept(again, NOW), Err(SignatureFault::Replayed));
    }
    assert_eq!(verifier.accept(&heartbeat(MavVersion::V2), NOW), Err(SignatureFault::Unsigned));
    assert_eq!(verifier.accept(&signed_at(&key(2), NOW + 10), NOW), Err(SignatureFault::WrongKey));
}

// fault 35: the true sender goes on
#[test]
fn a_forged_time_of_the_far_future_does_not_silence_the_true_sender() {
    let mut verifier = KeyUse::new(key(1), SigningTime::default());
    assert_eq!(verifier.accept(&signed_at(&key(1), NOW), NOW), Ok(()));
    let poison = heartbeat(MavVersion::V2).signed(&key(2), 0, SigningTime::MAX).expect("can be signed");
    assert_eq!(verifier.accept(&poison, NOW), Err(SignatureFault::WrongKey));
    assert_eq!(verifier.accept(&signed_at(&key(1), NOW + 10), NOW), Ok(()));
    assert_eq!(verifier.latest(), SigningTime::from_unix_us(NOW + 10));
}

// fault 36: a year, two days, the end of time ahead: refused, our time does not follow
#[test]
fn a_year_ahead_is_not_believed_of_the_key_s_owner_either() {
    let mut verifier = KeyUse::new(key(1), SigningTime::from_unix_us(NOW - DAY));
    assert_eq!(verifier.accept(&signed_at(&key(1), NOW), NOW), Ok(()));
    for far in [NOW + YEAR, NOW + 2 * DAY, SigningTime::MAX.unix_us()] {
        assert_eq!(verifier.accept(&signed_at(&key(1), far), NOW), Err(SignatureFault::Future));
    }
    assert_eq!(verifier.next_time(NOW), Ok(SigningTime::from_unix_us(NOW + 10)), "our own time did not follow");
    assert_eq!(verifier.accept(&signed_at(&key(1), NOW + 20), NOW), Ok(()), "the stream goes on");
    // One that started often is ahead by minutes, and is followed.
    assert_eq!(verifier.accept(&signed_at(&key(1), NOW + 600 * SECOND), NOW), Ok(()));
    assert_eq!(verifier.next_time(NOW), Ok(SigningTime::from_unix_us(NOW + 600 * SECOND + 10)));
    // No sender advances the accepted time in small steps.
    let steps = (1..=400).filter(|day| verifier.accept(&signed_at(&key(1), NOW + day * DAY), NOW).is_ok()).count();
    assert_eq!(steps, 1);
}

#[test]
fn a_machine_that_does_not_know_the_time_learns_it_from_who_has_the_key() {
    let stored = SigningTime::from_unix_us(NOW - 30 * DAY);
    let mut verifier = KeyUse::new(key(1), stored);
    assert_eq!(verifier.accept(&signed_at(&key(1), NOW), 0), Ok(()));
    assert!(verifier.next_time(0).expect("there is time") > SigningTime::from_unix_us(NOW));
    let last = heartbeat(MavVersion::V2).signed(&key(1), 0, SigningTime::MAX).expect("can be signed");
    assert_eq!(verifier.accept(&last, 0), Err(SignatureFault::Future), "but not to the end of time");
}

// fault 36: no wrap at 48 bits
#[test]
fn time_neither_repeats_nor_wraps() {
    let mut signer = KeyUse::new(key(1), SigningTime::MAX);
    let start = signer.latest();
    assert!(start < SigningTime::MAX, "a stored time of the end leaves a year");
    // A clock of the year 2105 is not followed.
    assert_eq!(signer.next_time(u64::MAX).map(|time| time.ticks()), Ok(start.ticks() + 1));
    signer.latest = SigningTime::MAX;
    assert_eq!(signer.next_time(NOW), Err(TimeExhausted));
    assert_eq!(signer.sign(&heartbeat(MavVersion::V2), 0, NOW), Err(TimeExhausted));
    assert_eq!(signer.latest(), SigningTime::MAX);
}

// fault 37 (1 seeds): 1,000 restarts: more than 40,000 times in order, 0 of more than 45,000 replays accepted
/// A station that is started a thousand times on a machine whose clock is right, never set, an hour behind or a year
/// ahead, and that ends in order or not.
#[test]
fn over_a_thousand_restarts_with_bad_clocks_time_only_grows_and_nothing_is_accepted_twice() {
    let mut random = SmallRng::seed_from_u64(37);
    let mut stored = SigningTime::default();
    let mut last_signed = SigningTime::default();
    let mut vehicle = KeyUse::new(key(1), SigningTime::default());
    let mut accepted: Vec<Frame> = Vec::new();
    let (mut signed, mut replayed) = (0, 0);
    for run in 0..1000_u64 {
        let truth = NOW + run * 300 * SECOND;
        let clock = [truth, 0, truth - 3600 * SECOND, truth + YEAR][random.random_range(0..4)];
        let mut station = KeyUse::new(key(1), stored);
        let mut reserved = station.reserve(clock);
        for old in accepted.iter().rev().take(50) {
            assert_eq!(station.accept(old, clock), Err(SignatureFault::Replayed), "run {run}");
            replayed += 1;
        }
        for second in 0..random.random_range(1..90) {
            let clock = clock + second * SECOND;
            let time = station.next_time(clock).expect("there is time");
            assert!(time > last_signed, "run {run}: {time:?} after {last_signed:?}");
            last_signed = time;
            signed += 1;
            // The vehicle hears it, follows, and answers.
            let frame = heartbeat(MavVersion::V2).signed(&key(1), 1, time).expect("can be signed");
            if vehicle.accept(&frame, 0).is_ok() {
                let answer = vehicle.sign(&heartbeat(MavVersion::V2), 0, 0).expect("there is time").expect("signed");
                assert_eq!(station.accept(&answer, clock), Ok(()), "run {run}: never cut off");
                accepted.push(answer);
            }
            if second % 30 == 29 {
                reserved = station.reserve(clock);
            }
        }
        stored = if random.random_bool(0.5) { station.latest() } else { reserved };
    }
    assert!(signed > 40_000 && accepted.len() > 40_000 && replayed > 45_000, "{signed} {} {replayed}", accepted.len());
}

#[test]
fn only_the_key_s_owner_opens_a_stream_and_not_without_end() {
    let mut verifier = KeyUse::new(key(1), SigningTime::default());
    let from = |link_id, key: &SigningKey| {
        heartbeat(MavVersion::V2).signed(key, link_id, SigningTime::from_unix_us(NOW)).expect("can be signed")
    };
    for link_id in 0..=255 {
        assert_eq!(verifier.accept(&from(link_id, &key(2)), NOW), Err(SignatureFault::WrongKey));
    }
    assert!(verifier.streams.is_empty());
    for link_id in 0..=255 {
        assert_eq!(verifier.accept(&from(link_id, &key(1)), NOW), Ok(()));
    }
    let other = Message::Heartbeat(Heartbeat::default()).encode(Header {
        sequence: 0,
        source: Address::new(9, 1),
        version: MavVersion::V2,
    });
    let other = other.signed(&key(1), 0, SigningTime::from_unix_us(NOW)).expect("can be signed");
    assert_eq!(verifier.accept(&other, NOW), Err(SignatureFault::TooManyStreams));
}

#[test]
fn mavlink_1_and_unknown_messages_cannot_be_signed_but_what_they_carry_can_be_taken_off() {
    assert_eq!(heartbeat(MavVersion::V1).signed(&key(1), 0, SigningTime::default()), None);
    assert_eq!(heartbeat(MavVersion::V1).signature(), None);
    let mut bytes = vec![0xfd, 1, 1, 0, 0, 1, 1, 0x10, 0xf0, 0xf0, 5, 0xaa, 0xbb];
    bytes.extend([9; SIGNATURE_LEN]);
    let unknown = read(&bytes).expect("a frame");
    assert_eq!(unknown.signed(&key(1), 0, SigningTime::default()), None);
    let bare = unknown.without_signature();
    assert!(!bare.is_signed());
    assert_eq!((bare.bytes().len(), bare.payload()), (13, unknown.payload()));
}

#[test]
fn a_key_is_never_printed() {
    let key = key(0x41);
    assert_eq!(format!("{key:?} {:?}", KeyUse::new(key.clone(), SigningTime::default())).matches("ABCD").count(), 0);
    assert_eq!(format!("{key:?}"), "SigningKey(secret)");
    assert_eq!(SigningKey::new([0; SigningKey::LEN]), None, "zeros mean no key");
    assert_eq!(
        hex(SigningKey::from_passphrase("correct horse").expose()),
        hex(&Sha256::digest(b"correct horse")),
        "as other ground stations make them"
    );
}
