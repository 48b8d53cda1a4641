//! Bytes from a link, in chunks of any size: every frame found is valid, and is equal when encoded again.
#![no_main]

use libfuzzer_sys::fuzz_target;
use vencejo_proto::{Frame, FrameDecoder, Header};

mod quick;
use quick::quick;

fuzz_target!(|data: &[u8]| quick(|| {
    let Some((&piece, bytes)) = data.split_first() else { return };
    let mut decoder = FrameDecoder::new();
    for part in bytes.chunks(usize::from(piece).max(1)) {
        decoder.push(part);
        while let Some(frame) = decoder.next_frame() {
            check(&frame);
        }
    }
    let mut datagrams = FrameDecoder::new();
    datagrams.push_datagram(bytes);
    while let Some(frame) = datagrams.next_frame() {
        check(&frame);
    }
}));

fn check(frame: &Frame) {
    let _ = (frame.target(), frame.is_signed(), frame.is_known());
    let Ok(message) = frame.decode() else { return };
    let header = Header { source: frame.source(), sequence: frame.sequence(), version: frame.version() };
    let again = message.encode(header);
    // NaN is not equal to itself; bytes are.
    let twice = again.decode().expect("what was written is read").encode(header);
    assert_eq!(again.bytes(), twice.bytes());
}
