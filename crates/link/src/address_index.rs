//! Owns the map from MAVLink addresses to small numbers: one load per look-up, and memory is touched only where it is
//! used.

use vencejo_proto::Address;

/// Numbers addresses from 0 on, up to a limit.
pub(crate) struct AddressIndex {
    /// Index by system × 256 + component; 0 means none, otherwise the number plus one.
    table: Vec<u16>,
}

impl AddressIndex {
    pub(crate) fn new() -> Self {
        Self { table: vec![0; 1 << 16] }
    }

    pub(crate) fn get(&self, address: Address) -> Option<usize> {
        self.table[slot(address)].checked_sub(1).map(usize::from)
    }

    pub(crate) fn set(&mut self, address: Address, number: usize) {
        debug_assert!(number < usize::from(u16::MAX));
        self.table[slot(address)] = number as u16 + 1;
    }

    pub(crate) fn remove(&mut self, address: Address) {
        self.table[slot(address)] = 0;
    }
}

fn slot(address: Address) -> usize {
    usize::from(address.system.0) << 8 | usize::from(address.component.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn remembers_and_forgets() {
        let mut index = AddressIndex::new();
        assert_eq!(index.get(Address::new(255, 255)), None);
        index.set(Address::new(255, 255), 0);
        index.set(Address::new(1, 2), 7);
        assert_eq!(index.get(Address::new(255, 255)), Some(0));
        assert_eq!(index.get(Address::new(1, 2)), Some(7));
        assert_eq!(index.get(Address::new(2, 1)), None);
        index.remove(Address::new(1, 2));
        assert_eq!(index.get(Address::new(1, 2)), None);
    }
}
