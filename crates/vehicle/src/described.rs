//! What the list of requests says of itself, for the doors that are made from it: each one's name, documentation and values, and a request
//! read from them.

use serde::Deserialize;
use serde::de::value::EnumAccessDeserializer;
use serde::de::{DeserializeSeed, Deserializer, EnumAccess, Error, IntoDeserializer, VariantAccess, Visitor};
use utoipa::PartialSchema;
use utoipa::openapi::RefOr;
use utoipa::openapi::schema::{AdditionalProperties, Object, Schema};

use crate::request::{Request, Turn};

/// Values that stand where none is given.
pub(crate) mod given {
    use crate::telemetry::Severity;

    pub(crate) const fn yes() -> bool {
        true
    }

    pub(crate) const fn accel_m_s2() -> f64 {
        5.0
    }

    pub(crate) const fn info() -> Severity {
        Severity::INFO
    }
}

impl From<bool> for Turn {
    fn from(is_clockwise: bool) -> Self {
        if is_clockwise { Self::Clockwise } else { Self::CounterClockwise }
    }
}

impl From<Turn> for bool {
    fn from(turn: Turn) -> Self {
        turn == Turn::Clockwise
    }
}

/// A request as it describes itself.
#[derive(Clone)]
pub struct Described {
    /// Its name: of words, with `-` and `/` between them.
    pub name: String,
    /// What it does.
    pub text: String,
    /// Its values; `None` when it has none.
    pub values: Option<Object>,
}

impl Request {
    /// All requests that describe themselves.
    #[must_use]
    pub fn described() -> Vec<Described> {
        let RefOr::T(Schema::OneOf(list)) = Self::schema() else { return Vec::new() };
        list.items.into_iter().filter_map(described).collect()
    }

    /// The request of this name with these values.
    ///
    /// # Errors
    /// Which value is wrong, and why; the names that there are, for a name that is none.
    pub fn named<'de, D: Deserializer<'de>>(name: &str, values: D) -> Result<Self, String> {
        serde_path_to_error::deserialize(EnumAccessDeserializer::new(Named { name, values })).map_err(|error| {
            let path = error.path().to_string();
            let of_value =
                path.strip_prefix(name).map(|rest| rest.trim_start_matches('.')).filter(|rest| !rest.is_empty());
            of_value.map_or_else(|| error.inner().to_string(), |value| format!("{value}: {}", error.inner()))
        })
    }
}

/// One of the list as it stands there: a name that is all there is, or an object that has the values under it.
fn described(item: RefOr<Schema>) -> Option<Described> {
    let RefOr::T(Schema::Object(item)) = item else { return None };
    let text = item.description.clone().unwrap_or_default();
    let Some((name, values)) = item.properties.iter().next() else {
        let name = item.enum_values.as_ref()?.first()?.as_str()?.to_owned();
        return Some(Described { name, text, values: None });
    };
    let RefOr::T(Schema::Object(mut values)) = values.clone() else { return None };
    values.description = None;
    values.additional_properties = Some(Box::new(AdditionalProperties::FreeForm(false)));
    Some(Described { name: name.clone(), text, values: Some(values) })
}

/// A variant by its name, and what reads its values.
struct Named<'a, D> {
    name: &'a str,
    values: D,
}

impl<'de, D: Deserializer<'de>> EnumAccess<'de> for Named<'_, D> {
    type Error = D::Error;
    type Variant = Values<D>;

    fn variant_seed<S: DeserializeSeed<'de>>(self, seed: S) -> Result<(S::Value, Values<D>), D::Error> {
        Ok((seed.deserialize(self.name.into_deserializer())?, Values(self.values)))
    }
}

struct Values<D>(D);

/// The values of what takes none: one that is given is told, not passed over.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Nothing {}

impl<'de, D: Deserializer<'de>> VariantAccess<'de> for Values<D> {
    type Error = D::Error;

    fn unit_variant(self) -> Result<(), D::Error> {
        Nothing::deserialize(self.0).map(|Nothing {}| ())
    }

    fn newtype_variant_seed<S: DeserializeSeed<'de>>(self, seed: S) -> Result<S::Value, D::Error> {
        seed.deserialize(self.0)
    }

    fn tuple_variant<V: Visitor<'de>>(self, _: usize, _: V) -> Result<V::Value, D::Error> {
        Err(D::Error::custom("values have names"))
    }

    fn struct_variant<V: Visitor<'de>>(self, _: &'static [&'static str], visitor: V) -> Result<V::Value, D::Error> {
        self.0.deserialize_map(visitor)
    }
}

#[cfg(test)]
mod tests {
    use serde_json::{Value, json};

    use super::*;
    use crate::error::VehicleError;
    use crate::request::ModeChoice;
    use crate::vehicle::refusal_of;

    #[test]
    fn a_request_is_read_from_its_name_and_values() {
        let read = |name: &str, values: Value| Request::named(name, values);
        assert_eq!(read("land", json!({})), Ok(Request::Land));
        assert_eq!(read("mode", json!({"mode": 10})), Ok(Request::SetMode { mode: ModeChoice::Custom(10) }));
        assert_eq!(
            read("course", json!({"course_deg": 90})),
            Ok(Request::GuidedCourse { course_deg: 90.0, accel_m_s2: 5.0 })
        );
        for (name, values, says) in [
            ("arm", json!({"force": 1}), "force: invalid type: integer `1`, expected a boolean"),
            ("speed", json!({"kind": "airspeed"}), "missing field `speed_m_s`"),
            (
                "speed",
                json!({"kind": "light", "speed_m_s": 3e8}),
                "kind: unknown variant `light`, expected `airspeed` or `groundspeed`",
            ),
            ("arm", json!({"froce": true}), "froce: unknown field `froce`, expected `force`"),
            ("mode", json!({"mode": 1.5}), "mode: a mode is given by its name or its number"),
            ("land", json!({"alt_m": 30}), "unknown field `alt_m`, there are no fields"),
            ("param-list", json!({}), "unknown variant `param-list`, expected one of `arm`, `disarm`"),
        ] {
            let error = read(name, values).expect_err(name);
            assert!(error.starts_with(says), "{error}");
        }
    }

    #[test]
    fn each_says_what_it_does_and_what_its_values_are() {
        let all = Request::described();
        let names: Vec<_> = all.iter().map(|request| request.name.as_str()).collect();
        assert_eq!(names[..3], ["arm", "disarm", "mode"]);
        assert!(names.contains(&"land") && names.contains(&"mission/pause") && names.len() >= 19, "{names:?}");
        for Described { name, text, values } in &all {
            // References of Rust mean nothing to others.
            assert!(!text.is_empty() && !text.contains("[`"), "{name}: {text}");
            for (value, schema) in values.iter().flat_map(|values| &values.properties) {
                let schema = serde_json::to_value(schema).expect("JSON");
                assert!(
                    schema["description"].as_str().is_some_and(|text| !text.is_empty()),
                    "{name}.{value}: {schema}"
                );
            }
        }
    }

    /// What the schema tells is what is looked at before anything is sent.
    #[test]
    fn beyond_its_range_no_value_is_sent() {
        let mut checked = 0;
        for Described { name, values, .. } in Request::described() {
            let values = serde_json::to_value(values).expect("JSON");
            let lies = |schema: &Value, bound: &str| schema[bound].as_f64();
            let mut whole = serde_json::Map::new();
            for (key, schema) in values["properties"].as_object().into_iter().flatten() {
                let value = match key.as_str() {
                    "alt_frame" => json!("home"),
                    "kind" => json!("airspeed"),
                    "mode" => json!(10),
                    "text" => json!("ready"),
                    _ if schema["type"] == "boolean" => json!(true),
                    _ if schema["type"] == "integer" => json!(1),
                    _ => json!(
                        lies(schema, "maximum").or(lies(schema, "exclusiveMaximum")).map_or(1.0, |most| most / 2.0)
                    ),
                };
                whole.insert(key.clone(), value);
            }
            let refused = |values: serde_json::Map<String, Value>| {
                refusal_of(&Request::named(&name, Value::Object(values)).expect("a request"))
            };
            // A flight is prepared only by whoever was heard.
            let refusal = refused(whole.clone()).filter(|_| name != "prepare-flight");
            assert_eq!(refusal, None, "{name}: {whole:?}");
            for (key, schema) in values["properties"].as_object().into_iter().flatten() {
                let is_whole = schema["type"] == "integer";
                let step = if is_whole { 1.0 } else { 0.001 };
                let bounds = [
                    lies(schema, "minimum").map(|least| least - step),
                    lies(schema, "maximum").map(|most| most + step),
                    lies(schema, "exclusiveMaximum"),
                ];
                // Below 0 no whole number is read.
                for beyond in bounds.into_iter().flatten().filter(|beyond| !is_whole || *beyond >= 0.0) {
                    let beyond = if is_whole { json!(beyond as u64) } else { json!(beyond) };
                    let mut values = whole.clone();
                    values.insert(key.clone(), beyond.clone());
                    let refusal = refused(values);
                    let is_told =
                        matches!(&refusal, Some(VehicleError::InvalidValue { field, .. }) if *field == key.as_str());
                    assert!(is_told, "{name}: {key} = {beyond}: {refusal:?}");
                    checked += 1;
                }
            }
        }
        assert!(checked >= 35, "{checked}");
    }
}
