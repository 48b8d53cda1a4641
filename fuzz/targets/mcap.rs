//! A history file in any condition, as read by a replay and by an archive.
#![no_main]

use libfuzzer_sys::fuzz_target;
use vencejo_fleet::history::page::{Block, PageReader};

mod quick;
use quick::quick;

const MAGIC: &[u8] = b"\x89MCAP0\r\n";

fuzz_target!(|data: &[u8]| quick(|| {
    let Some((&piece, bytes)) = data.split_first() else { return };
    // Half of the inputs get a valid beginning.
    let file = if piece & 1 == 0 { [MAGIC, bytes].concat() } else { bytes.to_vec() };
    let mut once = PageReader::default();
    let Ok(blocks) = once.read(&file) else { return };
    assert!(once.at() <= file.len() as u64 && once.damaged() <= once.at());
    // The content of a block can be found again.
    for block in &blocks {
        let bytes = &file[block.offset as usize..(block.offset + block.len) as usize];
        assert_eq!(once.clone().block(bytes).map(|records| records.len()), Ok(block.records.len()));
    }
    // A growing file is read like a complete one.
    let (mut reader, mut grown, mut end) = (PageReader::default(), Vec::<Block>::new(), 0);
    while end < file.len() {
        end = (end + 1 + usize::from(piece)).min(file.len());
        let from = reader.at() as usize;
        grown.extend(reader.read(&file[from..end]).expect("it was read at once"));
    }
    assert_eq!((grown, reader.aircraft()), (blocks, once.aircraft()));
}));
