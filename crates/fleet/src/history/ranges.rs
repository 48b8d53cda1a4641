//! Sets of numbers that mostly follow each other.

use std::collections::BTreeMap;

/// A set of numbers, as ranges that neither touch nor overlap.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Ranges(BTreeMap<u64, u64>);

impl Ranges {
    /// Adds the numbers from `first` to `last`.
    pub fn add(&mut self, first: u64, last: u64) {
        let (mut first, mut last) = (first, last);
        // Those that touch it or overlap begin not behind it.
        while let Some((&from, &to)) = self.0.range(..=last.saturating_add(1)).next_back()
            && to.saturating_add(1) >= first
        {
            self.0.remove(&from);
            (first, last) = (first.min(from), last.max(to));
        }
        self.0.insert(first, last);
    }

    /// Takes a number out.
    pub fn remove(&mut self, number: u64) {
        let Some((&first, &last)) = self.0.range(..=number).next_back().filter(|(_, last)| **last >= number) else {
            return;
        };
        self.0.remove(&first);
        if first < number {
            self.0.insert(first, number - 1);
        }
        if number < last {
            self.0.insert(number + 1, last);
        }
    }

    /// Whether it has this number.
    pub fn contains(&self, number: u64) -> bool {
        self.0.range(..=number).next_back().is_some_and(|(_, &last)| last >= number)
    }

    /// The ranges, first and last number of each, ascending.
    pub fn iter(&self) -> impl Iterator<Item = (u64, u64)> {
        self.0.iter().map(|(&first, &last)| (first, last))
    }

    /// How many ranges there are.
    pub fn spans(&self) -> usize {
        self.0.len()
    }

    /// How many numbers there are.
    pub fn count(&self) -> u64 {
        self.iter().map(|(first, last)| last - first + 1).sum()
    }

    /// The largest number.
    pub fn last(&self) -> Option<u64> {
        self.0.last_key_value().map(|(_, &last)| last)
    }

    /// What `first` to `last` has that this has not, ascending.
    pub fn missing(&self, first: u64, last: u64) -> Vec<(u64, u64)> {
        let (mut missing, mut at) = (Vec::new(), first);
        let before = self.0.range(..first).next_back();
        for (&from, &to) in before.into_iter().chain(self.0.range(first..=last.max(first))) {
            if from > at {
                missing.push((at, from - 1));
            }
            at = at.max(to.saturating_add(1));
        }
        if at <= last {
            missing.push((at, last));
        }
        missing
    }
}

impl FromIterator<(u64, u64)> for Ranges {
    fn from_iter<I: IntoIterator<Item = (u64, u64)>>(spans: I) -> Self {
        let mut ranges = Self::default();
        spans.into_iter().for_each(|(first, last)| ranges.add(first, last));
        ranges
    }
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use rand::rngs::SmallRng;
    use rand::{Rng, SeedableRng};

    use super::*;

    #[test]
    fn it_is_the_set_that_it_stands_for() {
        for seed in 0..200 {
            let mut rng = SmallRng::seed_from_u64(seed);
            let (mut ranges, mut set) = (Ranges::default(), BTreeSet::new());
            for _ in 0..30 {
                let first = rng.random_range(1..60);
                let last = first + rng.random_range(0..6);
                ranges.add(first, last);
                set.extend(first..=last);
                let gone = rng.random_range(1..66);
                ranges.remove(gone);
                set.remove(&gone);
            }
            assert_eq!(ranges.count(), set.len() as u64);
            assert_eq!(ranges.last(), set.last().copied());
            assert!((0..80).all(|number| ranges.contains(number) == set.contains(&number)), "seed {seed}");
            let spans: Vec<_> = ranges.iter().collect();
            assert!(spans.windows(2).all(|pair| pair[0].1 + 1 < pair[1].0), "seed {seed}: {spans:?}");
            let (from, to) = (rng.random_range(1..40), rng.random_range(30..70));
            let missing: Vec<u64> = ranges.missing(from, to).into_iter().flat_map(|(a, b)| a..=b).collect();
            assert_eq!(missing, (from..=to).filter(|number| !set.contains(number)).collect::<Vec<_>>(), "seed {seed}");
        }
    }
}
