//! Raw commands and messages: what is sent and told by the names and in the units of the MAVLink definitions.

use std::collections::BTreeMap;

use serde::{Deserialize, Deserializer, Serialize};
use utoipa::ToSchema;
use vencejo_proto::FieldValue;
use vencejo_vehicle::RateChoice;
use vencejo_vehicle::several::Kinds;

/// A command of MAVLink: its number, or its name with or without `MAV_CMD_`.
#[derive(Debug, Clone, PartialEq, Eq, ToSchema)]
#[serde(untagged)]
pub enum CommandChoice {
    /// Its number.
    Number(u16),
    /// Its name.
    Name(String),
}

impl<'de> Deserialize<'de> for CommandChoice {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let text = |name: &str| Some(Self::Name(name.to_owned()));
        let expected = "the name of a command or its number";
        Kinds { expected, number: Self::Number, text, list: None }.read(deserializer)
    }
}

/// A COMMAND_LONG.
#[derive(Debug, Clone, PartialEq, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct RawCommandLong {
    /// Which command.
    pub command: CommandChoice,
    /// Parameters 1 to 7; those not given are 0, null leaves one to the vehicle (NaN).
    #[serde(default)]
    #[schema(max_items = 7)]
    pub params: Vec<Option<f64>>,
}

/// A COMMAND_INT: its position as scaled integers of its frame.
#[derive(Debug, Clone, PartialEq, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct RawCommandInt {
    /// Which command.
    pub command: CommandChoice,
    /// `MAV_FRAME`.
    pub frame: u8,
    /// Parameters 1 to 4; those not given are 0, null leaves one to the vehicle (NaN).
    #[serde(default)]
    #[schema(max_items = 4)]
    pub params: Vec<Option<f64>>,
    /// Parameter 5; degrees × 10⁷ of latitude in a global frame.
    #[serde(default)]
    pub x: i32,
    /// Parameter 6; degrees × 10⁷ of longitude in a global frame.
    #[serde(default)]
    pub y: i32,
    /// Parameter 7; metres in a global frame.
    #[serde(default)]
    pub z: f64,
}

/// The vehicle took the command.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, ToSchema)]
pub struct Acknowledged {
    /// `result_param2` of its COMMAND_ACK; what it means depends on the command.
    pub result_param2: i32,
}

/// The value of a field, 64-bit numbers without loss. [`MessageFieldShape`] describes it.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[serde(untagged)]
pub enum MessageField {
    /// A number.
    Number(serde_json::Number),
    /// Several.
    Numbers(Vec<Option<serde_json::Number>>),
    /// A text.
    Text(String),
}

impl<'de> Deserialize<'de> for MessageField {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let text = |text: &str| Some(Self::Text(text.to_owned()));
        let expected = "a number, a list of numbers or a text";
        Kinds { expected, number: Self::Number, text, list: Some(Self::Numbers) }.read(deserializer)
    }
}

/// The value of a field; null in place of NaN.
#[derive(ToSchema)]
#[schema(as = MessageField)]
#[serde(untagged)]
#[allow(dead_code, reason = "describes MessageField")]
pub enum MessageFieldShape {
    /// A number.
    Number(Option<f64>),
    /// Several.
    Numbers(Vec<Option<f64>>),
    /// A text.
    Text(String),
}

/// A raw message of MAVLink.
#[derive(Debug, Clone, PartialEq, Serialize, ToSchema)]
pub struct RawMessage {
    /// Its name; `UNKNOWN_12345` when the dialect does not have it.
    pub name: String,
    /// Its id.
    pub id: u32,
    /// System id of its sender.
    pub system_id: u8,
    /// Component id of its sender.
    pub component_id: u8,
    /// When it came, seconds on the station's clock.
    pub time_s: f64,
    /// Its fields, in the units of the wire; enums and bit masks are numbers. Empty when the dialect does not have it.
    #[schema(value_type = BTreeMap<String, MessageFieldShape>)]
    pub fields: BTreeMap<String, Option<MessageField>>,
}

/// A message to send. There is no answer and no check: it is the escape hatch.
#[derive(Debug, Clone, PartialEq, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct NewMessage {
    /// Its name, such as `SET_POSITION_TARGET_GLOBAL_INT`.
    pub name: String,
    /// Its fields; those not given are 0, but `target_system` and `target_component` are the vehicle's.
    #[serde(default)]
    #[schema(value_type = BTreeMap<String, MessageFieldShape>)]
    pub fields: BTreeMap<String, Option<MessageField>>,
}

/// How often a vehicle is to send a message.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct MessageRate {
    /// Messages per second, 0.0005 to 50; `"default"`, or 0, for the vehicle's own rate; `"stop"`, or null, for none.
    #[serde(deserialize_with = "Option::deserialize")]
    #[schema(required = true, value_type = Option<RateChoice>)]
    pub rate_hz: Option<vencejo_vehicle::MessageRate>,
}

fn number(value: &FieldValue) -> Option<serde_json::Number> {
    match value {
        FieldValue::Unsigned(value) => Some((*value).into()),
        FieldValue::Signed(value) => Some((*value).into()),
        FieldValue::Float(value) => serde_json::Number::from_f64(*value),
        FieldValue::Text(_) | FieldValue::List(_) => None,
    }
}

impl MessageField {
    /// What the wire has; `None` for a number that is none.
    pub fn new(value: &FieldValue) -> Option<Self> {
        match value {
            FieldValue::Text(text) => Some(Self::Text(text.clone())),
            FieldValue::List(values) => Some(Self::Numbers(values.iter().map(number).collect())),
            value => number(value).map(Self::Number),
        }
    }

    /// What goes to the wire.
    pub fn to_wire(&self) -> FieldValue {
        let one = |value: &serde_json::Number| {
            let whole = value.as_u64().map(FieldValue::Unsigned).or_else(|| value.as_i64().map(FieldValue::Signed));
            whole.unwrap_or_else(|| FieldValue::Float(value.as_f64().unwrap_or(f64::NAN)))
        };
        match self {
            Self::Number(value) => one(value),
            Self::Numbers(values) => FieldValue::List(
                values.iter().map(|value| value.as_ref().map_or(FieldValue::Float(f64::NAN), one)).collect(),
            ),
            Self::Text(text) => FieldValue::Text(text.clone()),
        }
    }
}
