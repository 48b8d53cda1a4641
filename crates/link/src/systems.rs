//! Owns the set of systems heard from one peer: 256 bits, written by the reading task, read by any sender.

use std::sync::atomic::{AtomicU64, Ordering};

use vencejo_proto::SystemId;

/// System ids heard from one peer of a link that has several.
#[derive(Debug, Default)]
pub(crate) struct SystemSet {
    bits: [AtomicU64; 4],
}

impl SystemSet {
    pub(crate) fn insert(&self, system: SystemId) {
        let (word, bit) = place(system);
        if self.bits[word].load(Ordering::Relaxed) & bit == 0 {
            self.bits[word].fetch_or(bit, Ordering::Relaxed);
        }
    }

    pub(crate) fn contains(&self, system: SystemId) -> bool {
        let (word, bit) = place(system);
        self.bits[word].load(Ordering::Relaxed) & bit != 0
    }
}

fn place(system: SystemId) -> (usize, u64) {
    (usize::from(system.0 >> 6), 1 << (system.0 & 63))
}
