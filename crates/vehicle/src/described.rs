//! The requests' descriptions of themselves, from which front ends are generated: name, documentation and values of
//! each, and reading a request from them.

use serde::Deserialize;
use serde::de::value::EnumAccessDeserializer;
use serde::de::{DeserializeSeed, Deserializer, EnumAccess, Error, IntoDeserializer, VariantAccess, Visitor};
use utoipa::openapi::RefOr;
use utoipa::openapi::schema::{AdditionalProperties, Object, Schema};
use utoipa::{Number, PartialSchema, ToSchema};

use crate::choice::Turn;
use crate::misread;
use crate::request::Request;

/// Default values.
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

/// The description of a request.
#[derive(Clone)]
pub struct Described {
    /// Its name: words joined by `-` and `/`.
    pub name: String,
    /// What it does.
    pub text: String,
    /// The schema of its values; `None` when it has no values.
    pub values: Option<Object>,
    /// Whether its result is a message. The others have no result.
    pub brings_message: bool,
}

impl Request {
    /// All requests that describe themselves.
    pub fn described() -> Vec<Described> {
        let RefOr::T(Schema::OneOf(list)) = Self::schema() else { return Vec::new() };
        list.items.into_iter().filter_map(described).collect()
    }

    /// The request of this name with these values.
    ///
    /// # Errors
    /// Which value is wrong, and why; for an unknown name, the known names.
    pub fn named<'de, D: Deserializer<'de>>(name: &str, values: D) -> Result<Self, String> {
        serde_path_to_error::deserialize(EnumAccessDeserializer::new(Named { name, values })).map_err(|error| {
            let path = error.path().to_string();
            let path = path.strip_prefix(name).map_or("", |rest| rest.trim_start_matches('.'));
            misread::in_words(path, &error.inner().to_string(), |value| taken(name, value))
        })
    }
}

/// The constraints of a request's value beyond its type: its unit and range, or the allowed words.
fn taken(name: &str, value: &str) -> Option<String> {
    let request = Request::described().into_iter().find(|request| request.name == name)?;
    let value_is = request.values?.properties.remove(value)?;
    if let RefOr::Ref(reference) = value_is {
        let mut schemas = Vec::new();
        Request::schemas(&mut schemas);
        let (_, schema) =
            schemas.into_iter().find(|(name, _)| reference.ref_location.ends_with(&format!("/{name}")))?;
        let RefOr::T(Schema::Object(Object { enum_values: Some(words), .. })) = schema else { return None };
        let words: Vec<_> = words.iter().filter_map(|word| word.as_str()).collect();
        return Some(words.join(", "));
    }
    let RefOr::T(Schema::Object(schema)) = value_is else { return misread::unit(value).map(str::to_owned) };
    let number = |number: Number| match number {
        Number::Int(number) => number.to_string(),
        Number::UInt(number) => number.to_string(),
        Number::Float(number) => number.to_string(),
    };
    let most = schema.maximum.map(|most| format!("to {}", number(most)));
    let most = most.or_else(|| schema.exclusive_maximum.map(|most| format!("to below {}", number(most))));
    let range = schema.minimum.zip(most).map(|(least, most)| format!("{} {most}", number(least)));
    let told: Vec<_> = misread::unit(value).map(str::to_owned).into_iter().chain(range).collect();
    (!told.is_empty()).then(|| told.join(", "))
}

/// One entry of the schema: a bare name, or an object with the values under the name.
fn described(item: RefOr<Schema>) -> Option<Described> {
    let RefOr::T(Schema::Object(item)) = item else { return None };
    let text = item.description.clone().unwrap_or_default();
    let Some((name, values)) = item.properties.iter().next() else {
        let name = item.enum_values.as_ref()?.first()?.as_str()?.to_owned();
        return Some(Described { name, text, values: None, brings_message: false });
    };
    let RefOr::T(Schema::Object(mut values)) = values.clone() else { return None };
    values.description = None;
    values.additional_properties = Some(Box::new(AdditionalProperties::FreeForm(false)));
    Some(Described { name: name.clone(), text, values: Some(values), brings_message: name == "request-message" })
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

/// The values of a request without values: any that is given is an error.
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
    use serde::de::value::MapDeserializer;
    use serde_json::{Value, json};

    use super::*;
    use crate::choice::{MessageId, MessageRate, ModeChoice};
    use crate::error::VehicleError;
    use crate::vehicle::refusal_of;

    fn read(name: &str, values: Value) -> Result<Request, String> {
        Request::named(name, values)
    }

    #[test]
    fn a_request_is_read_from_its_name_and_values() {
        assert_eq!(read("land", json!({})), Ok(Request::Land));
        assert_eq!(read("mode", json!({"mode": 10})), Ok(Request::SetMode { mode: ModeChoice::Custom(10) }));
        assert_eq!(
            read("course", json!({"course_deg": 90})),
            Ok(Request::GuidedCourse { course_deg: 90.0, accel_m_s2: 5.0 })
        );
        for (given, rate_hz) in [
            (json!(2.5), MessageRate::Hz(2.5)),
            (json!(0), MessageRate::Default),
            (json!("default"), MessageRate::Default),
            (json!("stop"), MessageRate::Stop),
        ] {
            for message in [json!("attitude"), json!("30"), json!(30)] {
                let values = json!({"message": message, "rate_hz": given});
                let request = Request::SetMessageRate { message: MessageId(30), rate_hz };
                assert_eq!(read("set-message-rate", values), Ok(request));
            }
        }
        assert_eq!(read("mission/start", json!({})), Ok(Request::MissionStart { from_item: None }));
    }

    #[test]
    fn what_is_wrong_with_a_value_is_told_in_words() {
        let goto = |key: &str, value: Value| {
            let mut values = json!({"lat_deg": 40, "lon_deg": -3, "alt_m": 80, "alt_frame": "home"});
            values[key] = value;
            values
        };
        let rate = |message: Value, rate_hz: Value| json!({"message": message, "rate_hz": rate_hz});
        for (name, values, says) in [
            ("arm", json!({"force": 1}), "force is 1, should be true or false"),
            ("arm", json!({"froce": true}), "there is no froce; taken are force"),
            ("goto", goto("alt_m", json!("high")), r#"alt_m is "high", should be a number (metres, -1000 to 100000)"#),
            ("goto", goto("alt_m", json!([])), "alt_m is a list, should be a number (metres, -1000 to 100000)"),
            ("goto", goto("lon_deg", json!({})), "lon_deg is an object, should be a number (degrees, -180 to 180)"),
            ("goto", goto("radius_m", json!(true)), "radius_m is true, should be a number (metres, 1 to 30000)"),
            ("goto", goto("alt_frame", json!("sea")), r#"alt_frame is "sea", should be one of amsl, home, terrain"#),
            ("goto", goto("alt_frame", json!(3)), "alt_frame is 3, should be a text (amsl, home, terrain)"),
            (
                "goto",
                goto("kind", json!(3)),
                "there is no kind; taken are lat_deg, lon_deg, alt_m, alt_frame, radius_m",
            ),
            ("speed", json!({"kind": "airspeed"}), "speed_m_s is missing (m/s, 0.1 to 200)"),
            ("speed", json!({"speed_m_s": 14}), "kind is missing (airspeed, groundspeed)"),
            (
                "speed",
                json!({"kind": "light", "speed_m_s": 3e8}),
                r#"kind is "light", should be airspeed or groundspeed"#,
            ),
            (
                "course",
                json!({"course_deg": "N"}),
                r#"course_deg is "N", should be a number (degrees, 0 to below 360)"#,
            ),
            ("mission/start", json!({"from_item": -1}), "from_item is -1, should be a whole number (1 to 65534)"),
            ("mission/current", json!({"item": 1.5}), "item is 1.5, should be a whole number (1 to 65534)"),
            ("mode", json!({"mode": 1.5}), "mode is 1.5, should be the name of a mode or its number"),
            ("land", json!({"alt_m": 30}), "there is no alt_m; no values are taken"),
            ("texts", json!({"text": 5}), "text is 5, should be a text"),
            ("param-list", json!({}), "there is no param-list: one of arm, disarm, mode,"),
            (
                "set-message-rate",
                rate(json!("ATTITUDES"), json!(1)),
                "message: there is no message 'ATTITUDES' in the dialect",
            ),
            (
                "set-message-rate",
                rate(json!(1.5), json!(1)),
                "message is 1.5, should be the name of a message or its number",
            ),
            (
                "set-message-rate",
                rate(json!(30), json!("fast")),
                r#"rate_hz is "fast", should be a number (messages per second), "default" or "stop""#,
            ),
        ] {
            let error = read(name, values).expect_err(name);
            assert!(error.starts_with(says), "{error}");
        }
        let twice: Result<Request, _> =
            Request::named("arm", MapDeserializer::<_, serde::de::value::Error>::new([("force", true); 2].into_iter()));
        assert_eq!(twice, Err("force is given twice".to_owned()));
    }

    #[test]
    fn each_says_what_it_does_and_what_its_values_are() {
        let all = Request::described();
        let names: Vec<_> = all.iter().map(|request| request.name.as_str()).collect();
        assert_eq!(names[..3], ["arm", "disarm", "mode"]);
        assert!(names.contains(&"land") && names.contains(&"mission/pause") && names.len() >= 19, "{names:?}");
        for Described { name, text, values, .. } in &all {
            // References to Rust items mean nothing to other readers.
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
            // One that need not be given is of two types.
            let is_whole = |schema: &Value| schema["type"].to_string().contains("integer");
            let mut whole = serde_json::Map::new();
            for (key, schema) in values["properties"].as_object().into_iter().flatten() {
                let value = match key.as_str() {
                    "alt_frame" => json!("home"),
                    "kind" => json!("airspeed"),
                    "mode" => json!(10),
                    "text" => json!("ready"),
                    "message" => json!("ATTITUDE"),
                    "rate_hz" => json!(10),
                    _ if schema["type"] == "boolean" => json!(true),
                    _ if is_whole(schema) => json!(1),
                    _ => json!(
                        lies(schema, "maximum").or(lies(schema, "exclusiveMaximum")).map_or(1.0, |most| most / 2.0)
                    ),
                };
                whole.insert(key.clone(), value);
            }
            let refused = |values: serde_json::Map<String, Value>| {
                refusal_of(&Request::named(&name, Value::Object(values)).expect("a request"))
            };
            // Preparing a flight needs a heartbeat first.
            let refusal = refused(whole.clone()).filter(|_| name != "prepare-flight");
            assert_eq!(refusal, None, "{name}: {whole:?}");
            for (key, schema) in values["properties"].as_object().into_iter().flatten() {
                let is_whole = is_whole(schema);
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
        assert!(checked >= 44, "{checked}");
        for (rate_hz, is_taken) in [(0.000_499, false), (0.0005, true), (50.0, true), (50.001, false), (-1.0, false)] {
            let request = Request::SetMessageRate { message: MessageId(30), rate_hz: MessageRate::Hz(rate_hz) };
            assert_eq!(refusal_of(&request).is_none(), is_taken, "{rate_hz}");
        }
    }
}
