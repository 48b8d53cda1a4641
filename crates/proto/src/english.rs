//! Numbers in English sentences.

use std::fmt;
use std::time::Duration;

/// A count with what is counted, such as "1 item" or "2 items"; the plural has an s.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Counted<T>(pub T, pub &'static str);

impl<T: fmt::Display + PartialEq + From<u8>> fmt::Display for Counted<T> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self(count, what) = self;
        write!(f, "{count} {what}{}", if *count == T::from(1) { "" } else { "s" })
    }
}

/// A span of time in seconds, to a tenth, such as "10 s" or "0.5 s".
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Seconds(pub Duration);

impl fmt::Display for Seconds {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} s", (self.0.as_secs_f64() * 10.0).round() / 10.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_read_as_a_person_writes_them() {
        assert_eq!([0, 1, 2].map(|count: u32| Counted(count, "item").to_string()), ["0 items", "1 item", "2 items"]);
        let seconds = [0.000_4, 0.5, 1.001_733_525, 10.001_3].map(|s| Seconds(Duration::from_secs_f64(s)).to_string());
        assert_eq!(seconds, ["0 s", "0.5 s", "1 s", "10 s"]);
    }
}
