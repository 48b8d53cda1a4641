//! Requests that describe themselves in the core, from a name and Python's values.

use pyo3::exceptions::PyTypeError;
use pyo3::prelude::*;
use pyo3::types::{PyBool, PyDict, PyFloat, PyInt, PyString};
use serde::de::IntoDeserializer;
use serde::de::value::{Error, MapDeserializer};
use serde::forward_to_deserialize_any;
use vencejo_vehicle::Request;

use crate::errors;

/// A value as Python has it.
enum Given {
    Bool(bool),
    Whole(i64),
    Number(f64),
    Text(String),
}

impl Given {
    fn new(name: &str, value: &Bound<'_, PyAny>) -> PyResult<Self> {
        if value.is_instance_of::<PyBool>() {
            return value.extract().map(Self::Bool);
        }
        if value.is_instance_of::<PyString>() {
            return value.extract().map(Self::Text);
        }
        if !value.is_instance_of::<PyFloat>()
            && (value.is_instance_of::<PyInt>() || value.hasattr("__index__")?)
            && let Ok(whole) = value.extract()
        {
            return Ok(Self::Whole(whole));
        }
        let wrong = |_| PyTypeError::new_err(format!("{name} is {value:?}: give a number, a text or True or False"));
        value.extract().map(Self::Number).map_err(wrong)
    }
}

impl IntoDeserializer<'_, Error> for Given {
    type Deserializer = Self;

    fn into_deserializer(self) -> Self {
        self
    }
}

impl<'de> serde::Deserializer<'de> for Given {
    type Error = Error;

    fn deserialize_any<V: serde::de::Visitor<'de>>(self, visitor: V) -> Result<V::Value, Error> {
        match self {
            Self::Bool(value) => visitor.visit_bool(value),
            Self::Whole(value) => visitor.visit_i64(value),
            Self::Number(value) => visitor.visit_f64(value),
            Self::Text(value) => visitor.visit_string(value),
        }
    }

    fn deserialize_option<V: serde::de::Visitor<'de>>(self, visitor: V) -> Result<V::Value, Error> {
        visitor.visit_some(self)
    }

    fn deserialize_newtype_struct<V: serde::de::Visitor<'de>>(
        self,
        _: &'static str,
        visitor: V,
    ) -> Result<V::Value, Error> {
        visitor.visit_newtype_struct(self)
    }

    fn deserialize_enum<V: serde::de::Visitor<'de>>(
        self,
        name: &'static str,
        variants: &'static [&'static str],
        visitor: V,
    ) -> Result<V::Value, Error> {
        match self {
            Self::Text(value) => value.into_deserializer().deserialize_enum(name, variants, visitor),
            other => other.deserialize_any(visitor),
        }
    }

    forward_to_deserialize_any! {
        bool i8 i16 i32 i64 i128 u8 u16 u32 u64 u128 f32 f64 char str string bytes byte_buf unit unit_struct seq tuple tuple_struct map
        struct identifier ignored_any
    }
}

/// The request of this name with these values; `None` is not given.
pub fn named(name: &str, values: &Bound<'_, PyDict>) -> PyResult<Request> {
    let mut given: Vec<(String, Given)> = Vec::with_capacity(values.len());
    for (key, value) in values {
        if !value.is_none() {
            let key: String = key.extract()?;
            let value = Given::new(&key, &value)?;
            given.push((key, value));
        }
    }
    Request::named(name, MapDeserializer::new(given.into_iter()))
        .map_err(|error| errors::raise("InvalidRequest", format!("{name}: {error}")))
}

/// Reads a request without asking a vehicle for it; whether it acts, for which control is needed.
///
/// # Errors
/// `InvalidRequest` for an unknown name, listing those that exist, and for a value that is wrong or missing.
#[pyfunction]
fn check_request(name: &str, values: &Bound<'_, PyDict>) -> PyResult<bool> {
    named(name, values).map(|request| request.is_act())
}

/// Adds what this module has.
pub fn register(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_function(wrap_pyfunction!(check_request, module)?)
}
