//! Raw MAVLink commands and messages, with the names and units of the MAVLink definitions.

use std::collections::BTreeMap;

use serde::{Deserialize, Deserializer, Serialize};
use utoipa::ToSchema;
use vencejo_proto::FieldValue;
use vencejo_vehicle::RateChoice;
use vencejo_vehicle::several::Kinds;

/// A MAVLink command: its number, or its name with or without `MAV_CMD_`.
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
    /// Command.
    pub command: CommandChoice,
    /// Parameters 1 to 7. Missing ones are 0; null is sent as NaN, which lets the vehicle choose.
    #[serde(default)]
    #[schema(max_items = 7)]
    pub params: Vec<Option<f64>>,
}

/// A COMMAND_INT, whose position is given as scaled integers in its frame.
#[derive(Debug, Clone, PartialEq, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct RawCommandInt {
    /// Command.
    pub command: CommandChoice,
    /// `MAV_FRAME`.
    pub frame: u8,
    /// Parameters 1 to 4. Missing ones are 0; null is sent as NaN, which lets the vehicle choose.
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

/// Acknowledgement of a command that the vehicle accepted.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, ToSchema)]
pub struct Acknowledged {
    /// `result_param2` of the COMMAND_ACK; its meaning depends on the command.
    pub result_param2: i32,
}

/// Value of a message field; 64-bit numbers are lossless. [`MessageFieldShape`] describes it in the schema.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[serde(untagged)]
pub enum MessageField {
    /// A number.
    Number(serde_json::Number),
    /// An array of numbers.
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

/// Value of a message field; null stands for NaN.
#[derive(ToSchema)]
#[schema(as = MessageField)]
#[serde(untagged)]
#[allow(dead_code, reason = "describes MessageField")]
pub enum MessageFieldShape {
    /// A number.
    Number(Option<f64>),
    /// An array of numbers.
    Numbers(Vec<Option<f64>>),
    /// A text.
    Text(String),
}

/// A raw MAVLink message.
#[derive(Debug, Clone, PartialEq, Serialize, ToSchema)]
pub struct RawMessage {
    /// Message name; `UNKNOWN_12345` when the dialect does not contain it.
    pub name: String,
    /// Message id.
    pub id: u32,
    /// System id of its sender.
    pub system_id: u8,
    /// Component id of its sender.
    pub component_id: u8,
    /// Time of reception, seconds on the station's clock.
    pub time_s: f64,
    /// Fields in the units of the MAVLink definition; enums and bit masks are numbers. Empty when the dialect does not
    /// contain the message.
    #[schema(value_type = BTreeMap<String, MessageFieldShape>)]
    pub fields: BTreeMap<String, Option<MessageField>>,
}

/// A raw message to send. No answer is awaited. `POST /vehicles/{id}/messages` says what is refused.
#[derive(Debug, Clone, PartialEq, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct NewMessage {
    /// Message name, such as `SET_POSITION_TARGET_GLOBAL_INT`.
    pub name: String,
    /// Fields. Missing ones are 0, except that `target_system` and `target_component` default to the vehicle's.
    #[serde(default)]
    #[schema(value_type = BTreeMap<String, MessageFieldShape>)]
    pub fields: BTreeMap<String, Option<MessageField>>,
}

/// Requested rate of a message.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct MessageRate {
    /// Messages per second, 0.0005 to 50; `"default"` or 0 for the vehicle's own rate; `"stop"` or null to stop it.
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
    /// Converts a decoded field; `None` for a number that is not finite.
    pub fn new(value: &FieldValue) -> Option<Self> {
        match value {
            FieldValue::Text(text) => Some(Self::Text(text.clone())),
            FieldValue::List(values) => Some(Self::Numbers(values.iter().map(number).collect())),
            value => number(value).map(Self::Number),
        }
    }

    /// Converts it to a value that can be encoded.
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
