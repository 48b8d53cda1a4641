//! The format of the flight recorder: `.tlog`, each frame with its time.

use std::collections::VecDeque;

use vencejo_proto::{Frame, MonoTime};

use super::format::Format;
use super::storage::Names;
use crate::port::LinkId;
use crate::tlog::write_entry;

/// A frame on its way to the disk.
pub struct Noted {
    pub(super) at: MonoTime,
    pub(super) link: LinkId,
    pub(super) frame: Frame,
}

/// Frames in `.tlog` format. Time stamps follow the monotonic clock from the wall time at which the file was begun, so
/// they do not step when the wall clock is set.
pub struct Frames {
    names: Names,
    begun_at: MonoTime,
    begun_unix_us: u64,
    newest_us: u64,
}

impl Default for Frames {
    fn default() -> Self {
        Self { names: Names::plain("tlog"), begun_at: MonoTime::ZERO, begun_unix_us: 0, newest_us: 0 }
    }
}

impl Frames {
    /// The time stamp of the next entry, never before the last one: frames come from several threads and overtake each
    /// other by some 0.1 ms. Some readers take the lowest two bits as the number of the link.
    fn next_unix_us(&mut self, at: MonoTime, link: LinkId) -> u64 {
        let base = i128::from(self.begun_unix_us);
        let offset = i128::from(at.as_micros()) - i128::from(self.begun_at.as_micros());
        self.newest_us = self.newest_us.max(u64::try_from(base + offset).unwrap_or(0) & !3);
        self.newest_us | u64::from(link.0.wrapping_sub(1) & 3)
    }
}

impl Format for Frames {
    type Item = Noted;
    const BEGINS_AT_ONCE: bool = true;

    fn names(&self) -> &Names {
        &self.names
    }

    fn begin(&mut self, at: MonoTime, unix_us: u64) {
        (self.begun_at, self.begun_unix_us, self.newest_us) = (at, unix_us, 0);
    }

    fn write(&mut self, items: &VecDeque<Noted>, out: &mut Vec<u8>) {
        for noted in items {
            write_entry(out, self.next_unix_us(noted.at, noted.link), &noted.frame);
        }
    }
}
