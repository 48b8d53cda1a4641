//! What a recorder's files are: how they are named, begun, filled and ended.

use std::collections::VecDeque;

use vencejo_proto::MonoTime;

use super::storage::Names;

/// What is in the files of a recorder.
pub trait Format: Send + 'static {
    /// What is written, one by one.
    type Item: Send + 'static;
    /// Whether a file is begun before there is something to write.
    const BEGINS_AT_ONCE: bool;
    /// How the files are named.
    fn names(&self) -> &Names;
    /// A new file begins, at this moment of the monotonic clock and of UTC. One that was not ended stays as it is.
    fn begin(&mut self, at: MonoTime, unix_us: u64);
    /// Writes these, or holds some of it back until [`flush`](Self::flush).
    fn write(&mut self, items: &VecDeque<Self::Item>, out: &mut Vec<u8>);
    /// Writes what was held back: it is about to be forced to the disk.
    fn flush(&mut self, out: &mut Vec<u8>) {
        let _ = out;
    }
    /// Writes what stands at a file's end. One that was killed has none, and is read all the same.
    fn end(&mut self, out: &mut Vec<u8>) {
        let _ = out;
    }
}
