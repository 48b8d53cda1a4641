//! Lists of items and parameters on the network of a fleet: packed, in parts and in pieces.
#![no_main]

use std::time::Duration;

use libfuzzer_sys::fuzz_target;
use prost::Message;
use vencejo_fleet::content::{
    Content, Digest, PART_BYTES, Part, Tray, pack_items, pack_params, unpack_items, unpack_params,
};
use vencejo_fleet::pull::{PIECE_BYTES, Pull};
use vencejo_fleet::signature::PublicKey;

mod quick;
use quick::quick;

fuzz_target!(|data: &[u8]| quick(|| {
    let Some((&kind, bytes)) = data.split_first() else { return };
    match kind % 5 {
        0 => unpacked(bytes),
        1 => unpacked(&stored(bytes)),
        2 => pulled(bytes),
        3 => put_together(bytes),
        _ => drop(Content::decode(bytes).map(|content| content.name())),
    }
}));

/// A list that is unpacked and packed again is the same.
fn unpacked(packed: &[u8]) {
    // Compared as Debug text, since NaN is not equal to itself.
    if let Ok(list) = unpack_items(packed) {
        assert_eq!(format!("{:?}", unpack_items(&pack_items(&list))), format!("{:?}", Ok::<_, ()>(list)));
    }
    if let Ok(list) = unpack_params(packed) {
        assert_eq!(format!("{:?}", unpack_params(&pack_params(&list))), format!("{:?}", Ok::<_, ()>(list)));
    }
}

/// DEFLATE without compression (RFC 1951, 3.2.4), so that the fuzzer sees the content directly.
fn stored(bytes: &[u8]) -> Vec<u8> {
    let bytes = &bytes[..bytes.len().min(usize::from(u16::MAX))];
    let length = bytes.len() as u16;
    [&[1], &length.to_le_bytes()[..], &(!length).to_le_bytes(), bytes].concat()
}

/// Downloaded pieces: their order, delay, and missing or surplus bytes.
fn pulled(bytes: &[u8]) {
    let Some((&[pieces, over, seed], mut steps)) = bytes.split_first_chunk::<3>() else { return };
    let list = vec![seed; (usize::from(pieces % 12) * PIECE_BYTES + usize::from(over)).max(1)];
    let mut pull = Pull::new(Digest::of(&list), list.len());
    while let Some((&[which, took, change], tail)) = steps.split_first_chunk::<3>() {
        steps = tail;
        while pull.next_piece().is_some() {}
        let offset = usize::from(which) * PIECE_BYTES / if change & 128 == 0 { 1 } else { 7 };
        if change == 255 {
            pull.on_silence(offset);
            continue;
        }
        let piece = list.get(offset..).map_or(&list[..0], |rest| &rest[..rest.len().min(PIECE_BYTES)]);
        let piece = [piece, &list[..usize::from(change & 3).min(list.len())]].concat();
        let came = pull.on_piece(offset, &piece, Duration::from_millis(u64::from(took) * 10));
        assert!(came.is_err() || change & 3 == 0, "a piece that is too long is taken");
        let (here, all) = pull.progress();
        assert!(here <= all);
    }
    if let Some(whole) = pull.whole() {
        assert_eq!(whole, Ok(list.as_slice()), "whole is what was named");
    }
}

/// Uploaded parts of three senders: arbitrary, or of a valid list with one change.
fn put_together(bytes: &[u8]) {
    let list: Vec<u8> = (0..2 * PART_BYTES + 100).map(|at| at as u8).collect();
    let parts = Part::all_of(&list);
    let mut tray = Tray::default();
    let mut rest = bytes;
    while let Some((&[sender, which, length], tail)) = rest.split_first_chunk::<3>() {
        let (bytes, tail) = tail.split_at(usize::from(length).min(tail.len()));
        rest = tail;
        let part = match (parts.get(usize::from(which)), Part::decode(bytes)) {
            (Some(part), _) => part.clone(),
            (None, Ok(part)) => part,
            (None, Err(_)) => continue,
        };
        if let Ok(Some(whole)) = tray.on_part(PublicKey([sender % 3; 32]), &part) {
            assert_eq!(Digest::of(&whole).0.as_slice(), part.digest, "whole is what was named");
        }
    }
}
