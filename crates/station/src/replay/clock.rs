//! The recorder's clock: UTC of the places in a recording. A pause that counts nothing, or a step of that clock, moves it
//! against the places.

use std::collections::VecDeque;
use std::time::Duration;

/// Smaller differences are disorder among the entries, not a clock that was set.
const SAME_US: u64 = 1_000_000;
/// Most stretches kept, as many as a vehicle keeps texts; the oldest are forgotten.
const MAX_STRETCHES: usize = 256;

/// The clock at the places that were shown.
#[derive(Debug, Default)]
pub(super) struct RecordedClock {
    /// Where each stretch of an even clock begins, and its UTC there, microseconds since 1970; by place.
    stretches: VecDeque<(Duration, u64)>,
}

impl RecordedClock {
    /// Takes the UTC of a place; places come in order.
    pub(super) fn hear(&mut self, at: Duration, unix_us: u64) {
        if self.at(at).is_some_and(|known| known.abs_diff(unix_us) <= SAME_US) {
            return;
        }
        if self.stretches.len() == MAX_STRETCHES {
            self.stretches.pop_front();
        }
        self.stretches.push_back((at, unix_us));
    }

    /// UTC of a place, microseconds since 1970; `None` before the first that is known.
    pub(super) fn at(&self, place: Duration) -> Option<u64> {
        let later = self.stretches.partition_point(|(begin, _)| *begin <= place);
        let (begin, unix_us) = self.stretches.get(later.checked_sub(1)?)?;
        Some(unix_us.saturating_add(u64::try_from((place - *begin).as_micros()).unwrap_or(u64::MAX)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const S: u64 = 1_000_000;

    #[test]
    fn it_goes_with_the_places_and_steps_as_the_recorders_did() {
        let at = |clock: &RecordedClock, place_s| clock.at(Duration::from_secs(place_s)).map(|us| us / S);
        let mut clock = RecordedClock::default();
        assert_eq!(at(&clock, 5), None);
        for (place_s, unix_us) in [(10, 1_010 * S), (11, 1_011 * S - 400_000), (20, 8_220 * S), (30, 500 * S)] {
            clock.hear(Duration::from_secs(place_s), unix_us);
        }
        let known = [5, 10, 12, 19, 20, 29, 31].map(|place_s| at(&clock, place_s));
        assert_eq!(known, [None, Some(1_010), Some(1_012), Some(1_019), Some(8_220), Some(8_229), Some(501)]);
        for place_s in 0..3_000 {
            clock.hear(Duration::from_secs(100 + place_s), place_s * 1_000 * S);
        }
        assert_eq!((clock.stretches.len(), at(&clock, 3_099)), (MAX_STRETCHES, Some(2_999_000)));
    }
}
