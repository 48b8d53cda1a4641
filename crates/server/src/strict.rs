//! Strict JSON: a structure must be an object. Serde's derived readers also accept a list with the values in order, so
//! that an empty list would stand for all defaults, and `[]` for "nothing given". This reader refuses lists at every
//! depth.

use std::fmt;

use serde::de::{
    Deserialize, DeserializeOwned, DeserializeSeed, Deserializer, EnumAccess, Error, MapAccess, SeqAccess,
    VariantAccess, Visitor,
};
use vencejo_vehicle::misread;

/// Reads JSON strictly.
///
/// # Errors
/// The wrong value, what it is, and what is expected.
pub fn read<T: DeserializeOwned>(text: &str) -> Result<T, String> {
    let mut json = serde_json::Deserializer::from_str(text);
    let read = serde_path_to_error::deserialize(&mut json).map(|Strict(value)| value);
    read.map_err(|error| {
        let path = error.path().to_string();
        let unit = |name: &str| misread::unit(name).map(str::to_owned);
        misread::in_words(path.trim_matches('.'), &error.inner().to_string(), unit)
    })
}

/// A value that is read strictly.
struct Strict<T>(T);

impl<'de, T: Deserialize<'de>> Deserialize<'de> for Strict<T> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        T::deserialize(Objects(deserializer)).map(Self)
    }
}

/// Adapter that makes any deserializer, seed or visitor strict.
struct Objects<T>(T);

macro_rules! forward {
    ($($name:ident)*) => {
        $(fn $name<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, D::Error> {
            self.0.$name(Objects(visitor))
        })*
    };
}

impl<'de, D: Deserializer<'de>> Deserializer<'de> for Objects<D> {
    type Error = D::Error;

    forward! {
        deserialize_any deserialize_bool deserialize_i8 deserialize_i16 deserialize_i32 deserialize_i64 deserialize_i128
        deserialize_u8 deserialize_u16 deserialize_u32 deserialize_u64 deserialize_u128 deserialize_f32 deserialize_f64
        deserialize_char deserialize_str deserialize_string deserialize_bytes deserialize_byte_buf deserialize_option
        deserialize_unit deserialize_seq deserialize_map deserialize_identifier deserialize_ignored_any
    }

    fn deserialize_struct<V: Visitor<'de>>(
        self,
        _: &'static str,
        _: &'static [&'static str],
        visitor: V,
    ) -> Result<V::Value, D::Error> {
        // The essential step: a structure is read like a map.
        self.0.deserialize_map(Objects(visitor))
    }

    fn deserialize_unit_struct<V: Visitor<'de>>(self, name: &'static str, visitor: V) -> Result<V::Value, D::Error> {
        self.0.deserialize_unit_struct(name, Objects(visitor))
    }

    fn deserialize_newtype_struct<V: Visitor<'de>>(self, name: &'static str, visitor: V) -> Result<V::Value, D::Error> {
        self.0.deserialize_newtype_struct(name, Objects(visitor))
    }

    fn deserialize_tuple<V: Visitor<'de>>(self, length: usize, visitor: V) -> Result<V::Value, D::Error> {
        self.0.deserialize_tuple(length, Objects(visitor))
    }

    fn deserialize_tuple_struct<V: Visitor<'de>>(
        self,
        name: &'static str,
        length: usize,
        visitor: V,
    ) -> Result<V::Value, D::Error> {
        self.0.deserialize_tuple_struct(name, length, Objects(visitor))
    }

    fn deserialize_enum<V: Visitor<'de>>(
        self,
        name: &'static str,
        variants: &'static [&'static str],
        visitor: V,
    ) -> Result<V::Value, D::Error> {
        self.0.deserialize_enum(name, variants, Objects(visitor))
    }

    fn is_human_readable(&self) -> bool {
        self.0.is_human_readable()
    }
}

macro_rules! visit {
    ($($name:ident $type:ty),*) => {
        $(fn $name<E: Error>(self, value: $type) -> Result<V::Value, E> {
            self.0.$name(value)
        })*
    };
}

impl<'de, V: Visitor<'de>> Visitor<'de> for Objects<V> {
    type Value = V::Value;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.expecting(f)
    }

    visit! {
        visit_bool bool, visit_i64 i64, visit_i128 i128, visit_u64 u64, visit_u128 u128, visit_f64 f64, visit_char char,
        visit_str &str, visit_borrowed_str &'de str, visit_string String, visit_bytes &[u8], visit_borrowed_bytes &'de [u8],
        visit_byte_buf Vec<u8>
    }

    fn visit_none<E: Error>(self) -> Result<V::Value, E> {
        self.0.visit_none()
    }

    fn visit_unit<E: Error>(self) -> Result<V::Value, E> {
        self.0.visit_unit()
    }

    fn visit_some<D: Deserializer<'de>>(self, deserializer: D) -> Result<V::Value, D::Error> {
        self.0.visit_some(Objects(deserializer))
    }

    fn visit_newtype_struct<D: Deserializer<'de>>(self, deserializer: D) -> Result<V::Value, D::Error> {
        self.0.visit_newtype_struct(Objects(deserializer))
    }

    fn visit_seq<A: SeqAccess<'de>>(self, access: A) -> Result<V::Value, A::Error> {
        self.0.visit_seq(Objects(access))
    }

    fn visit_map<A: MapAccess<'de>>(self, access: A) -> Result<V::Value, A::Error> {
        self.0.visit_map(Objects(access))
    }

    fn visit_enum<A: EnumAccess<'de>>(self, access: A) -> Result<V::Value, A::Error> {
        self.0.visit_enum(Objects(access))
    }
}

impl<'de, S: DeserializeSeed<'de>> DeserializeSeed<'de> for Objects<S> {
    type Value = S::Value;

    fn deserialize<D: Deserializer<'de>>(self, deserializer: D) -> Result<S::Value, D::Error> {
        self.0.deserialize(Objects(deserializer))
    }
}

impl<'de, A: SeqAccess<'de>> SeqAccess<'de> for Objects<A> {
    type Error = A::Error;

    fn next_element_seed<T: DeserializeSeed<'de>>(&mut self, seed: T) -> Result<Option<T::Value>, A::Error> {
        self.0.next_element_seed(Objects(seed))
    }

    fn size_hint(&self) -> Option<usize> {
        self.0.size_hint()
    }
}

impl<'de, A: MapAccess<'de>> MapAccess<'de> for Objects<A> {
    type Error = A::Error;

    fn next_key_seed<K: DeserializeSeed<'de>>(&mut self, seed: K) -> Result<Option<K::Value>, A::Error> {
        self.0.next_key_seed(Objects(seed))
    }

    fn next_value_seed<T: DeserializeSeed<'de>>(&mut self, seed: T) -> Result<T::Value, A::Error> {
        self.0.next_value_seed(Objects(seed))
    }

    fn size_hint(&self) -> Option<usize> {
        self.0.size_hint()
    }
}

impl<'de, A: EnumAccess<'de>> EnumAccess<'de> for Objects<A> {
    type Error = A::Error;
    type Variant = Objects<A::Variant>;

    fn variant_seed<S: DeserializeSeed<'de>>(self, seed: S) -> Result<(S::Value, Self::Variant), A::Error> {
        self.0.variant_seed(Objects(seed)).map(|(value, variant)| (value, Objects(variant)))
    }
}

impl<'de, A: VariantAccess<'de>> VariantAccess<'de> for Objects<A> {
    type Error = A::Error;

    fn unit_variant(self) -> Result<(), A::Error> {
        self.0.unit_variant()
    }

    fn newtype_variant_seed<S: DeserializeSeed<'de>>(self, seed: S) -> Result<S::Value, A::Error> {
        self.0.newtype_variant_seed(Objects(seed))
    }

    fn tuple_variant<V: Visitor<'de>>(self, length: usize, visitor: V) -> Result<V::Value, A::Error> {
        self.0.tuple_variant(length, Objects(visitor))
    }

    fn struct_variant<V: Visitor<'de>>(
        self,
        fields: &'static [&'static str],
        visitor: V,
    ) -> Result<V::Value, A::Error> {
        self.0.struct_variant(fields, Objects(visitor))
    }
}

#[cfg(test)]
mod tests {
    use vencejo_vehicle::ModeChoice;

    use super::*;
    use crate::dto::Plan;
    use crate::dto::message::{MessageField, MessageRate, RawCommandLong};

    #[test]
    fn a_list_is_no_object_at_any_depth() {
        assert!(serde_json::from_str::<Plan>("[]").is_ok(), "what serde makes of it");
        for text in ["[]", "[[]]", "7", "\"\"", "null", r#"{"fence": [[]]}"#, r#"{"home": [40.0, -3.0, 600.0]}"#] {
            let error = read::<Plan>(text).expect_err(text);
            assert!(error.ends_with(", should be an object"), "{text}: {error}");
        }
        assert!(read::<Plan>(r#"{"items": [[16, 3, [0, 0, 0, 0, 40, -3, 100], true]]}"#).is_err());
        assert!(
            read::<MessageRate>("[]").is_err()
                && read::<MessageRate>("[1]").is_err()
                && read::<Option<MessageRate>>("[]").is_err()
        );
    }

    #[test]
    fn everything_else_is_read_as_it_was() {
        let text = r#"{"items": [{"command": 16, "frame": 3, "params": [0, null, 0, 0, 40.5, -3, 100]}],
            "fence": {"zones": [{"inclusion": true, "shape": "circle", "points": [{"lat_deg": 40, "lon_deg": -3}],
            "radius_m": 50}]}, "rally": [], "home": {"lat_deg": 40, "lon_deg": -3, "alt_amsl_m": 600}}"#;
        assert_eq!(read::<Plan>(text), serde_json::from_str::<Plan>(text).map_err(|error| error.to_string()));
        assert!(read::<ModeChoice>(r#""AUTO""#).is_ok() && read::<ModeChoice>("10").is_ok());
        assert!(read::<RawCommandLong>(r#"{"command": "DO_CHANGE_SPEED", "params": [1, null]}"#).is_ok());
    }

    #[test]
    fn what_is_wrong_is_told_by_its_path_and_in_words() {
        for (text, says) in [
            (r#"{"itmes": []}"#, "there is no itmes; taken are items, home, fence, rally, complex_items, planned_for"),
            (r#"{"items": [{"command": 16, "frame": 3}]}"#, "items[0].params is missing"),
            (
                r#"{"items": [{"command": 16, "frame": 300}]}"#,
                "items[0].frame is 300, should be a whole number (0 to 255)",
            ),
            (
                r#"{"items": [{"command": 16, "frame": 3, "params": [1]}]}"#,
                "items[0].params is a list of 1, should be a list of 7",
            ),
            (
                r#"{"home": {"lat_deg": "N", "lon_deg": 1, "alt_amsl_m": 2}}"#,
                r#"home.lat_deg is "N", should be a number (degrees)"#,
            ),
            (r#"{"home": {"lat_deg": 1, "lon_deg": 1}}"#, "home.alt_amsl_m is missing (metres)"),
            (r#"{"home": {"lat_deg": 1, "lat_deg": 1}}"#, "home.lat_deg is given twice"),
            (r#"{"home": 7}"#, "home is 7, should be an object"),
            ("[]", "what was given is a list, should be an object"),
        ] {
            assert_eq!(read::<Plan>(text), Err(says.to_owned()), "{text}");
        }
        let rate = |text: &str| read::<MessageRate>(text).map(|rate| rate.rate_hz);
        assert_eq!(rate("{}"), Err("rate_hz is missing (Hz)".to_owned()));
        assert_eq!(rate(r#"{"rate_hz": null}"#), Ok(None));
        let command = |text: &str| read::<RawCommandLong>(text).map(|raw| raw.command);
        let says = |given: &str| Err(format!("command is {given}, should be the name of a command or its number"));
        for (text, given) in [("true", "true"), ("70000", "70000"), ("[]", "a list"), ("null", "null")] {
            assert_eq!(command(&format!(r#"{{"command": {text}}}"#)), says(given));
        }
        let field = |text: &str| read::<MessageField>(text);
        assert_eq!(
            field("{}"),
            Err("what was given is an object, should be a number, a list of numbers or a text".to_owned())
        );
        assert!(matches!(field("[1, null]"), Ok(MessageField::Numbers(numbers)) if numbers.len() == 2));
        assert!(field("[true]").is_err());
    }
}
