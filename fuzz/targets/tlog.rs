//! A recording in any condition: every byte belongs to an entry or is counted as skipped.
#![no_main]

use libfuzzer_sys::fuzz_target;
use vencejo_link::TlogDecoder;

mod quick;
use quick::quick;

/// Timestamp before each frame.
const STAMP_LEN: usize = 8;

fuzz_target!(|data: &[u8]| quick(|| {
    let Some((&piece, bytes)) = data.split_first() else { return };
    let mut decoder = TlogDecoder::new();
    let mut used = 0;
    let mut take = |decoder: &mut TlogDecoder| {
        while let Some(entry) = decoder.next_entry() {
            used += (STAMP_LEN + entry.frame.bytes().len()) as u64;
        }
    };
    for part in bytes.chunks(usize::from(piece).max(1)) {
        decoder.push(part);
        take(&mut decoder);
    }
    decoder.finish();
    take(&mut decoder);
    assert_eq!(used + decoder.skipped().total(), bytes.len() as u64);
}));
