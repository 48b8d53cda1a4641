//! Values of several alternative kinds, such as a mode by name or by number. Serde's derived readers (`untagged`) do
//! not report what was given instead; this one does.

use std::fmt;

use serde::de::value::{Error as ValueError, SeqAccessDeserializer};
use serde::de::{Deserialize, Deserializer, Error, IntoDeserializer, SeqAccess, Unexpected, Visitor};

/// Converts a list of numbers.
type OfList<T, N> = fn(Vec<Option<N>>) -> T;

/// Reads a value that is a number, a text, or a list of numbers, where these are accepted.
pub struct Kinds<'a, T, N> {
    /// What is accepted, as a phrase after "should be".
    pub expected: &'a str,
    /// Converts a number.
    pub number: fn(N) -> T,
    /// Converts a text; returns `None` for one that is not accepted.
    pub text: fn(&str) -> Option<T>,
    /// Converts a list of numbers, where lists are accepted; null stands for no number.
    pub list: Option<OfList<T, N>>,
}

impl<'de, T, N: Deserialize<'de>> Kinds<'_, T, N> {
    /// Reads it.
    ///
    /// # Errors
    /// The value given, and what is accepted.
    pub fn read<D: Deserializer<'de>>(self, deserializer: D) -> Result<T, D::Error> {
        deserializer.deserialize_any(KindsVisitor(self))
    }
}

struct KindsVisitor<'a, T, N>(Kinds<'a, T, N>);

impl<'de, T, N: Deserialize<'de>> KindsVisitor<'_, T, N> {
    fn number<E: Error>(&self, given: impl IntoDeserializer<'de, ValueError>, said: Unexpected<'_>) -> Result<T, E> {
        let number = N::deserialize(given.into_deserializer());
        number.map(self.0.number).map_err(|_| E::invalid_value(said, self))
    }
}

impl<'de, T, N: Deserialize<'de>> Visitor<'de> for KindsVisitor<'_, T, N> {
    type Value = T;

    fn expecting(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str(self.0.expected)
    }

    fn visit_i64<E: Error>(self, given: i64) -> Result<T, E> {
        self.number(given, Unexpected::Signed(given))
    }

    fn visit_u64<E: Error>(self, given: u64) -> Result<T, E> {
        self.number(given, Unexpected::Unsigned(given))
    }

    fn visit_f64<E: Error>(self, given: f64) -> Result<T, E> {
        self.number(given, Unexpected::Float(given))
    }

    fn visit_str<E: Error>(self, given: &str) -> Result<T, E> {
        (self.0.text)(given).ok_or_else(|| E::invalid_value(Unexpected::Str(given), &self))
    }

    fn visit_seq<A: SeqAccess<'de>>(self, given: A) -> Result<T, A::Error> {
        let Some(list) = self.0.list else { return Err(A::Error::invalid_type(Unexpected::Seq, &self)) };
        Vec::deserialize(SeqAccessDeserializer::new(given)).map(list)
    }
}
