//! The file format of a recorder: how its files are named, begun, filled and ended.

use std::collections::VecDeque;

use vencejo_proto::MonoTime;

use super::storage::Names;

/// The format of a recorder's files.
pub trait Format: Send + 'static {
    /// The items that are written.
    type Item: Send + 'static;
    /// Whether a file is begun before the first item.
    const BEGINS_AT_ONCE: bool;
    /// How the files are named.
    fn names(&self) -> &Names;
    /// Begins a new file at this moment of the monotonic clock and of UTC. An earlier file that was not ended stays as
    /// it is.
    fn begin(&mut self, at: MonoTime, unix_us: u64);
    /// Writes items, or buffers some of them until [`flush`](Self::flush).
    fn write(&mut self, items: &VecDeque<Self::Item>, out: &mut Vec<u8>);
    /// Writes what was buffered, before a sync to disk.
    fn flush(&mut self, out: &mut Vec<u8>) {
        let _ = out;
    }
    /// Writes a file's trailer. A file without one (of a killed process) can be read all the same.
    fn end(&mut self, out: &mut Vec<u8>) {
        let _ = out;
    }
}
