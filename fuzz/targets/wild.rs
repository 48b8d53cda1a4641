//! Numbers from bytes: mostly realistic, sometimes not.
#![allow(dead_code)]

/// The remaining bytes; zeros after them.
pub struct Wild<'a>(pub &'a [u8]);

impl Wild<'_> {
    /// The next byte.
    pub fn byte(&mut self) -> u8 {
        let Some((first, rest)) = self.0.split_first() else { return 0 };
        self.0 = rest;
        *first
    }

    /// One of the given values.
    pub fn one_of<T: Copy>(&mut self, all: &[T]) -> T {
        all[usize::from(self.byte()) % all.len()]
    }

    /// A random boolean.
    pub fn flag(&mut self) -> bool {
        self.byte() & 1 == 1
    }

    /// A number between −`most` and `most` in 65,536 steps; a special value for one first byte in sixteen.
    pub fn number(&mut self, most: f64) -> f64 {
        const ODD: [f64; 16] = [
            f64::NAN,
            f64::INFINITY,
            f64::NEG_INFINITY,
            -0.0,
            1e308,
            -1e308,
            1e-308,
            1e-9,
            -1e-9,
            1e9,
            -1e9,
            1e6,
            -1.0,
            65_536.0,
            4_294_967_296.0,
            180.0,
        ];
        match self.byte() {
            odd @ 240.. => ODD[usize::from(odd - 240)],
            high => f64::from(i16::from_be_bytes([high.wrapping_mul(17), self.byte()])) / 32_768.0 * most,
        }
    }

    /// Value of a setting: often a small integer, as switches, choices, counts and disabled limits have; one in sixteen
    /// of these is negative.
    pub fn setting(&mut self, most: f64) -> f64 {
        match self.byte() {
            whole @ ..120 => f64::from(whole % 8),
            below @ 120..128 => -f64::from(below - 119),
            _ => self.number(most),
        }
    }

    /// Like [`Self::number`], or `None`.
    pub fn maybe(&mut self, most: f64) -> Option<f64> {
        if self.flag() { Some(self.number(most)) } else { None }
    }
}
