//! Reads a stream of bytes and says which frames of known messages are in it, eight bytes each: id, sequence, system, component, checksum.
//! `tests/peers/test_c_parser.py` compares it with what the C library finds.

use std::io::{self, Read, Write};

use vencejo_proto::FrameDecoder;

/// A signature, behind the checksum of a signed frame.
const SIGNATURE_LEN: usize = 13;

fn main() -> io::Result<()> {
    let mut decoder = FrameDecoder::new();
    let mut piece = vec![0; 1 << 16];
    let mut output = io::BufWriter::new(io::stdout().lock());
    let mut input = io::stdin().lock();
    loop {
        let count = input.read(&mut piece)?;
        if count == 0 {
            return output.flush();
        }
        decoder.push(&piece[..count]);
        while let Some(frame) = decoder.next_frame() {
            if !frame.is_known() {
                continue;
            }
            let bytes = frame.bytes();
            let end = bytes.len() - if frame.is_signed() { SIGNATURE_LEN } else { 0 };
            let [id0, id1, id2, _] = frame.message_id().to_le_bytes();
            let source = frame.source();
            let [crc0, crc1] = [bytes[end - 2], bytes[end - 1]];
            output.write_all(&[id0, id1, id2, frame.sequence(), source.system.0, source.component.0, crc0, crc1])?;
        }
    }
}
