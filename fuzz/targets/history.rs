//! A ground station that fills its history: answers of an aircraft at any time and in any order, and arbitrary requests
//! to an aircraft.
#![no_main]

use std::collections::BTreeMap;
use std::time::Duration;

use libfuzzer_sys::fuzz_target;
use prost::Message;
use vencejo_fleet::history::fill::{Fill, Question};
use vencejo_fleet::history::{Index, Piece, Stream, Wanted};
use vencejo_proto::MonoTime;

mod quick;
use quick::quick;

fuzz_target!(|data: &[u8]| quick(|| {
    let mut fill = Fill::new(BTreeMap::new());
    let (mut asked, mut now, mut rest) = (None, MonoTime::from_millis(10_000), data);
    fill.on_present(now);
    // A sequence of events, each with kind, delay and length.
    while let Some((&[kind, after, length], tail)) = rest.split_first_chunk::<3>() {
        let (bytes, tail) = tail.split_at(usize::from(length).min(tail.len()));
        rest = tail;
        now += Duration::from_millis(u64::from(after) * 40);
        if let Some(question) = fill.ask(now) {
            if let Question::Piece(wanted) = question {
                assert!(0 < wanted.first && wanted.first <= wanted.last, "nothing is asked for: {wanted:?}");
                assert!(Wanted::read(&wanted.encode_to_vec()).is_ok(), "it cannot be asked: {wanted:?}");
            }
            asked = Some(question);
        }
        match kind & 7 {
            0 | 1 => on_index(&mut fill, kind, bytes, asked, now),
            2 | 3 => on_piece(&mut fill, kind, bytes, asked, now),
            4 => fill.on_silence(now),
            5 => fill.on_hole(now),
            6 => {
                let number = bytes.first_chunk().map_or(u64::from(after), |bytes| u64::from_be_bytes(*bytes));
                let stream = Stream::ALL[usize::from(kind >> 3) % 3];
                assert!(!fill.take(1, stream, number) || !fill.take(1, stream, number), "it is new twice");
            }
            _ => drop(Wanted::read(bytes)),
        }
        for gap in fill.gaps() {
            assert!(gap.first <= gap.last, "{gap:?}");
            let held = &fill.held()[&(gap.boot, gap.stream)];
            assert!(!held.have.contains(gap.first) && !held.have.contains(gap.last), "it is there: {gap:?}");
            assert_eq!(held.lost.contains(gap.first), gap.is_lost, "{gap:?}");
        }
        drop(fill.remembered(usize::from(after)));
    }
}));

/// An arbitrary index, or one that answers the last request.
fn on_index(fill: &mut Fill, kind: u8, bytes: &[u8], asked: Option<Question>, now: MonoTime) {
    let Ok(mut index) = Index::decode(bytes) else { return };
    if let (0, Some(Question::Index(nonce))) = (kind & 8, asked) {
        (index.nonce, index.version) = (nonce, 1);
    }
    // Only readable ones get here.
    if let Ok(index) = Index::read(&index.encode_to_vec()) {
        fill.on_index(&index, now);
    }
}

/// An arbitrary piece, or one that answers the last request, with a valid digest.
fn on_piece(fill: &mut Fill, kind: u8, bytes: &[u8], asked: Option<Question>, now: MonoTime) {
    let Ok(piece) = Piece::decode(bytes) else { return };
    let piece = match asked {
        Some(Question::Piece(wanted)) if kind & 8 == 0 => Piece::of(&wanted, piece.last, piece.entries),
        _ => piece,
    };
    let Ok(piece) = Piece::read(&piece.encode_to_vec()) else { return };
    let before: Vec<bool> = piece.entries.iter().map(|entry| has(fill, &piece, entry.number)).collect();
    if let Ok(new) = fill.on_piece(&piece, now) {
        assert_eq!(new.len(), before.iter().filter(|had| !**had).count(), "new is what was not there");
        assert!(piece.entries.iter().all(|entry| has(fill, &piece, entry.number)), "what came is there");
    }
}

fn has(fill: &Fill, piece: &Piece, number: u64) -> bool {
    let stream = Stream::of_code(piece.stream);
    stream.and_then(|stream| fill.held().get(&(piece.boot, stream))).is_some_and(|held| held.have.contains(number))
}
