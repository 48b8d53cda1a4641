//! A list on its way down, on the ground: asked for piece by piece, so that what the answers take of a narrow uplink is
//! what the asker lets be on its way at once. No I/O; how long each took comes in.

use std::time::Duration;

use crate::content::Digest;
use crate::wire::BadPayload;

/// Bytes of a piece: an eighth of a second at 256 kbit/s, so that an answer to an order never waits for long behind
/// one.
pub const PIECE_BYTES: usize = 4 * 1024;
/// Pieces on their way at once: at first, and at most.
const WINDOW: usize = 2;
const MAX_WINDOW: usize = 8;
/// A piece that takes so much longer than the fastest waited in a line.
const LATE: Duration = Duration::from_millis(100);

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Piece {
    Missing,
    OnItsWay,
    Here,
}

/// What has come of a list.
#[derive(Debug)]
pub struct Pull {
    name: Digest,
    bytes: Vec<u8>,
    pieces: Vec<Piece>,
    window: usize,
    fastest: Option<Duration>,
}

impl Pull {
    /// Of the list with this name and length.
    pub fn new(name: Digest, length: usize) -> Self {
        let pieces = vec![Piece::Missing; length.div_ceil(PIECE_BYTES)];
        Self { name, bytes: vec![0; length], pieces, window: WINDOW, fastest: None }
    }

    /// Where the piece begins that is to be asked for now, if one is. Ask again until there is none.
    pub fn next_piece(&mut self) -> Option<usize> {
        let on_its_way = self.pieces.iter().filter(|piece| **piece == Piece::OnItsWay).count();
        if on_its_way >= self.window {
            return None;
        }
        let number = self.pieces.iter().position(|piece| *piece == Piece::Missing)?;
        self.pieces[number] = Piece::OnItsWay;
        Some(number * PIECE_BYTES)
    }

    /// The piece that begins there came after this time.
    ///
    /// # Errors
    /// [`BadPayload::Field`] where it is not as long as it has to be.
    pub fn on_piece(&mut self, offset: usize, bytes: &[u8], took: Duration) -> Result<(), BadPayload> {
        let length = self.bytes.len().saturating_sub(offset).min(PIECE_BYTES);
        if bytes.len() != length || length == 0 || !offset.is_multiple_of(PIECE_BYTES) {
            self.on_silence(offset);
            return Err(BadPayload::Field("piece"));
        }
        self.bytes[offset..offset + length].copy_from_slice(bytes);
        self.pieces[offset / PIECE_BYTES] = Piece::Here;
        let fastest = self.fastest.map_or(took, |fastest| fastest.min(took));
        self.fastest = Some(fastest);
        let is_late = took > fastest * 2 + LATE;
        self.window = if is_late { (self.window / 2).max(1) } else { (self.window + 1).min(MAX_WINDOW) };
        Ok(())
    }

    /// The piece that begins there did not come.
    pub fn on_silence(&mut self, offset: usize) {
        if let Some(piece) = self.pieces.get_mut(offset / PIECE_BYTES).filter(|piece| **piece == Piece::OnItsWay) {
            *piece = Piece::Missing;
            self.window = 1;
        }
    }

    /// Bytes that are here, and all.
    pub fn progress(&self) -> (u32, u32) {
        let here = self.pieces.iter().filter(|piece| **piece == Piece::Here).count();
        let here = (here * PIECE_BYTES).min(self.bytes.len());
        (u32::try_from(here).unwrap_or(u32::MAX), u32::try_from(self.bytes.len()).unwrap_or(u32::MAX))
    }

    /// The list, when it is whole.
    ///
    /// # Errors
    /// [`BadPayload::Content`] where it is not what its digest says.
    pub fn whole(&self) -> Option<Result<&[u8], BadPayload>> {
        let is_whole = self.pieces.iter().all(|piece| *piece == Piece::Here);
        let is_named = || Digest::of(&self.bytes) == self.name;
        is_whole.then(|| {
            if is_named() {
                Ok(self.bytes.as_slice())
            } else {
                Err(BadPayload::Content("its pieces are not what its digest says"))
            }
        })
    }
}

#[cfg(test)]
mod tests {
    use rand::rngs::SmallRng;
    use rand::{Rng, SeedableRng};

    use super::*;

    fn list() -> Vec<u8> {
        (0..10 * PIECE_BYTES + 100).map(|n| (n * 7 + n / 256) as u8).collect()
    }

    #[test]
    fn what_is_lost_is_asked_for_again_and_what_is_whole_is_what_was_named() {
        let list = list();
        for seed in 0..200 {
            let mut rng = SmallRng::seed_from_u64(seed);
            let mut pull = Pull::new(Digest::of(&list), list.len());
            let (mut on_its_way, mut asked) = (Vec::new(), 0);
            while pull.whole().is_none() {
                while let Some(offset) = pull.next_piece() {
                    on_its_way.push(offset);
                    asked += 1;
                }
                assert!((1..=MAX_WINDOW).contains(&on_its_way.len()), "seed {seed}");
                let offset = on_its_way.swap_remove(rng.random_range(0..on_its_way.len()));
                let took = Duration::from_millis(rng.random_range(50..500));
                match rng.random_range(0..10) {
                    0..2 => pull.on_silence(offset),
                    2 => assert!(pull.on_piece(offset, b"short", took).is_err()),
                    _ => {
                        let end = (offset + PIECE_BYTES).min(list.len());
                        assert_eq!(pull.on_piece(offset, &list[offset..end], took), Ok(()));
                    }
                }
            }
            assert_eq!(pull.whole(), Some(Ok(list.as_slice())), "seed {seed}");
            assert!(asked < 60 && pull.progress() == (41_060, 41_060), "seed {seed}: {asked}");
        }
        let mut forged = Pull::new(Digest::of(b"else"), 4);
        assert_eq!(forged.next_piece(), Some(0));
        assert_eq!(forged.on_piece(0, b"list", Duration::ZERO), Ok(()));
        assert!(matches!(forged.whole(), Some(Err(BadPayload::Content(_)))));
    }

    #[test]
    fn a_narrow_way_is_not_filled_and_a_wide_one_is_used() {
        // Those of a batch come one behind the other: the first after `first_ms`, each further one so much later.
        let window = |first_ms: u64, each_ms: u64| {
            let list = list();
            let mut pull = Pull::new(Digest::of(&list), list.len());
            let mut most = 0;
            while pull.whole().is_none() {
                let asked: Vec<_> = std::iter::from_fn(|| pull.next_piece()).collect();
                most = most.max(asked.len());
                for (place, offset) in asked.iter().enumerate() {
                    let end = (offset + PIECE_BYTES).min(list.len());
                    let took = Duration::from_millis(first_ms + each_ms * place as u64);
                    pull.on_piece(*offset, &list[*offset..end], took).expect("a piece");
                }
            }
            most
        };
        assert!(window(200, 1) > 4, "far away, but wide");
        assert!(window(600, 500) <= 4, "64 kbit/s");
    }
}
