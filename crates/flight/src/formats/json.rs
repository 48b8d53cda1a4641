//! JSON of a file: bounded before it is unfolded, and read by values that know their path.

use serde_json::{Map, Value, json};

use crate::error::{FlightError, Result};
use crate::formats::text::shown;
use crate::geodesy::GeoPoint;

/// A value and where it stands in the file.
#[derive(Clone)]
pub(super) struct Node<'a> {
    pub(super) value: &'a Value,
    pub(super) path: String,
}

impl<'a> Node<'a> {
    pub(super) fn bad(&self, problem: impl Into<String>) -> FlightError {
        FlightError::BadJson { path: self.path.clone(), problem: problem.into() }
    }

    pub(super) fn wrong_kind(&self, wanted: &str) -> FlightError {
        let found = match self.value {
            Value::Null => "null".to_owned(),
            Value::Bool(value) => value.to_string(),
            Value::Number(number) => shown(&number.to_string()),
            Value::String(text) => format!("\"{}\"", shown(text)),
            Value::Array(_) => "a list".to_owned(),
            Value::Object(_) => "an object".to_owned(),
        };
        self.bad(format!("is {found} where {wanted} belongs"))
    }

    pub(super) fn object(&self) -> Result<&'a Map<String, Value>> {
        self.value.as_object().ok_or_else(|| self.wrong_kind("an object"))
    }

    /// A member; absent and null are `None`.
    pub(super) fn member(&self, key: &str) -> Result<Option<Node<'a>>> {
        let value = self.object()?.get(key).filter(|value| !value.is_null());
        Ok(value.map(|value| Node { value, path: join(&self.path, key) }))
    }

    pub(super) fn required(&self, key: &str) -> Result<Node<'a>> {
        self.member(key)?.ok_or_else(|| FlightError::BadJson {
            path: join(&self.path, key),
            problem: "is missing; save the plan again with a current QGroundControl, or add it".into(),
        })
    }

    pub(super) fn list(&self) -> Result<impl ExactSizeIterator<Item = Node<'a>> + use<'a>> {
        let list = self.value.as_array().ok_or_else(|| self.wrong_kind("a list"))?;
        let path = self.path.clone();
        Ok(list.iter().enumerate().map(move |(index, value)| Node { value, path: format!("{path}[{index}]") }))
    }

    pub(super) fn number(&self) -> Result<f64> {
        self.value.as_f64().filter(|value| value.is_finite()).ok_or_else(|| self.wrong_kind("a number"))
    }

    pub(super) fn whole(&self, max: u32) -> Result<u32> {
        let value = self.number()?;
        if value.fract() == 0.0 && (0.0..=f64::from(max)).contains(&value) {
            Ok(value as u32)
        } else {
            Err(self.wrong_kind(&format!("a whole number from 0 to {max}")))
        }
    }

    pub(super) fn flag(&self) -> Result<bool> {
        self.value.as_bool().ok_or_else(|| self.wrong_kind("true or false"))
    }

    pub(super) fn flag_or(&self, key: &str, default: bool) -> Result<bool> {
        self.member(key)?.map_or(Ok(default), |node| node.flag())
    }

    pub(super) fn text(&self) -> Result<&'a str> {
        self.value.as_str().ok_or_else(|| self.wrong_kind("a text"))
    }

    /// A part that is only there to be empty need not say its version.
    pub(super) fn expect_version_if_any(&self, oldest: u32, newest: u32) -> Result<()> {
        let Some(version) = self.member("version")? else { return Ok(()) };
        match version.whole(u32::MAX)? {
            found if (oldest..=newest).contains(&found) => Ok(()),
            found => Err(version.bad(format!(
                "is {found}; versions {oldest} and {newest} are read, so save the plan again with a current QGroundControl"
            ))),
        }
    }

    pub(super) fn expect_version(&self, wanted: u32) -> Result<()> {
        let version = self.required("version")?;
        match version.whole(u32::MAX)? {
            found if found == wanted => Ok(()),
            found => Err(version.bad(format!(
                "is {found}; only version {wanted} is read, so save the plan again with a current QGroundControl"
            ))),
        }
    }

    /// `[latitude, longitude]`, and a height when there is a third number that is not null.
    pub(super) fn coordinate(&self) -> Result<(GeoPoint, Option<f64>)> {
        let parts: Vec<_> = self.list()?.collect();
        let (lat, lon, alt) = match parts.as_slice() {
            [lat, lon] => (lat, lon, None),
            [lat, lon, alt] => (lat, lon, Some(alt)),
            _ => return Err(self.wrong_kind("[latitude, longitude] or [latitude, longitude, height]")),
        };
        let point = GeoPoint::new(lat.number()?, lon.number()?).map_err(|error| self.bad(error.to_string()))?;
        let alt_m = alt.filter(|alt| !alt.value.is_null()).map(Node::number).transpose()?;
        Ok((point, alt_m))
    }

    /// `[latitude, longitude, height]`.
    pub(super) fn place(&self) -> Result<(GeoPoint, f64)> {
        match self.coordinate()? {
            (point, Some(alt_m)) => Ok((point, alt_m)),
            _ => Err(self.wrong_kind("[latitude, longitude, height]")),
        }
    }
}

/// The path of a member.
pub(super) fn join(path: &str, key: &str) -> String {
    if path == ROOT { key.to_owned() } else { format!("{path}.{key}") }
}

/// Path of the whole file.
pub(super) const ROOT: &str = "plan";

/// Bytes that the values of a file may take when they are unfolded.
const MAX_UNFOLDED: usize = 42 * 1024 * 1024;
/// Objects and lists inside each other at most; plans need ten.
const MAX_DEPTH: usize = 64;

/// JSON of a file.
///
/// # Errors
/// [`FlightError::BadJson`] for what is no JSON, [`FlightError::BadFile`] for what would take too much memory.
pub(super) fn parse(text: &str) -> Result<Value> {
    check_size(text)?;
    serde_json::from_str(text).map_err(|error| {
        let todo = if error.is_eof() {
            "the file is cut short, save the plan again"
        } else {
            "correct it, or save the plan again"
        };
        FlightError::BadJson {
            path: format!("line {}, column {}", error.line(), error.column()),
            problem: format!("is not JSON ({error}); {todo}"),
        }
    })
}

/// Estimates the memory of JSON before it is parsed: values take many times the bytes that they are written with.
///
/// Counts what a value, a list, an object and a member take at most in `serde_json`: a list of one value makes room for
/// four, an object for eleven. Invalid JSON is estimated as well as possible and refused by the parser.
pub(super) fn check_size(text: &str) -> Result<()> {
    const VALUE: usize = 3 * size_of::<Value>();
    const LIST: usize = 4 * size_of::<Value>();
    const OBJECT: usize = 11 * (size_of::<String>() + size_of::<Value>()) + 32;
    const MEMBER: usize = OBJECT / 5;
    let (mut bytes, mut depth, mut is_text, mut is_escaped) = (VALUE, 0_usize, false, false);
    for byte in text.bytes() {
        if is_text {
            bytes += 1;
            is_text = is_escaped || byte != b'"';
            is_escaped = !is_escaped && byte == b'\\';
            continue;
        }
        match byte {
            b'"' => is_text = true,
            b',' => bytes += VALUE,
            b':' => bytes += MEMBER,
            b'[' => (bytes, depth) = (bytes + VALUE + LIST, depth + 1),
            b'{' => (bytes, depth) = (bytes + VALUE + OBJECT, depth + 1),
            b']' | b'}' => depth = depth.saturating_sub(1),
            _ => {}
        }
        if depth > MAX_DEPTH {
            return Err(FlightError::BadFile(format!(
                "the file is more than {MAX_DEPTH} lists and objects deep, which no plan is; choose another"
            )));
        }
        if bytes > MAX_UNFOLDED {
            return Err(FlightError::BadFile(
                "the file holds more values than a plan that can be read; save it without surveys' previews, or split it".into(),
            ));
        }
    }
    Ok(())
}

/// A number without ".0" when it is whole, null when it is not finite.
pub(super) fn plain(value: f64) -> Value {
    const EXACT: f64 = 9_007_199_254_740_992.0; // 2^53
    if value.fract() == 0.0 && value.abs() < EXACT { json!(value as i64) } else { json!(value) }
}
