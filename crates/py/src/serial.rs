//! A serde serializer into plain Python values: dictionaries with interned keys, tuples, `None`.

use std::fmt::{self, Display};

use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyString, PyTuple};
use serde::ser::{Impossible, Serialize, SerializeMap, SerializeSeq, SerializeStruct, SerializeTuple, Serializer};

/// The exception that a value, or Python, met on the way.
#[derive(Debug)]
pub struct Failed(PyErr);

impl Display for Failed {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        Display::fmt(&self.0, f)
    }
}

impl std::error::Error for Failed {}

impl serde::ser::Error for Failed {
    fn custom<T: Display>(message: T) -> Self {
        Self(PyValueError::new_err(message.to_string()))
    }
}

impl From<PyErr> for Failed {
    fn from(error: PyErr) -> Self {
        Self(error)
    }
}

impl From<Failed> for PyErr {
    fn from(failed: Failed) -> Self {
        failed.0
    }
}

/// Makes Python values. Numbers stay exact, however many digits they have.
#[derive(Clone, Copy)]
pub struct ToPython<'py> {
    py: Python<'py>,
    /// Whether texts are names, of which Python keeps each once.
    interns: bool,
}

impl<'py> ToPython<'py> {
    /// A serializer of one value.
    pub fn new(py: Python<'py>) -> Self {
        Self { py, interns: false }
    }
}

type Value<'py> = Bound<'py, PyAny>;
type Made<'py> = Result<Value<'py>, Failed>;

macro_rules! plain {
    ($($method:ident: $kind:ty,)*) => {$(
        fn $method(self, value: $kind) -> Made<'py> {
            Ok(value.into_pyobject(self.py).map_err(PyErr::from)?.to_owned().into_any())
        }
    )*};
}

impl<'py> Serializer for ToPython<'py> {
    type Ok = Value<'py>;
    type Error = Failed;
    type SerializeSeq = Sequence<'py>;
    type SerializeTuple = Sequence<'py>;
    type SerializeTupleStruct = Impossible<Value<'py>, Failed>;
    type SerializeTupleVariant = Impossible<Value<'py>, Failed>;
    type SerializeMap = Mapping<'py>;
    type SerializeStruct = Mapping<'py>;
    type SerializeStructVariant = Impossible<Value<'py>, Failed>;

    plain! {
        serialize_bool: bool,
        serialize_i8: i8,
        serialize_i16: i16,
        serialize_i32: i32,
        serialize_i64: i64,
        serialize_u8: u8,
        serialize_u16: u16,
        serialize_u32: u32,
        serialize_u64: u64,
        serialize_f32: f32,
        serialize_f64: f64,
        serialize_char: char,
        serialize_bytes: &[u8],
    }

    fn serialize_str(self, value: &str) -> Made<'py> {
        let text = if self.interns { PyString::intern(self.py, value) } else { PyString::new(self.py, value) };
        Ok(text.into_any())
    }

    fn serialize_none(self) -> Made<'py> {
        Ok(self.py.None().into_bound(self.py))
    }

    fn serialize_some<T: Serialize + ?Sized>(self, value: &T) -> Made<'py> {
        value.serialize(self)
    }

    fn serialize_unit(self) -> Made<'py> {
        self.serialize_none()
    }

    fn serialize_unit_struct(self, _name: &'static str) -> Made<'py> {
        self.serialize_none()
    }

    fn serialize_unit_variant(self, _name: &'static str, _index: u32, variant: &'static str) -> Made<'py> {
        self.serialize_str(variant)
    }

    fn serialize_newtype_struct<T: Serialize + ?Sized>(self, _name: &'static str, value: &T) -> Made<'py> {
        value.serialize(self)
    }

    fn serialize_newtype_variant<T: Serialize + ?Sized>(
        self,
        _name: &'static str,
        _index: u32,
        variant: &'static str,
        value: &T,
    ) -> Made<'py> {
        let mut map = self.serialize_map(Some(1))?;
        map.serialize_entry(variant, value)?;
        SerializeMap::end(map)
    }

    fn serialize_seq(self, length: Option<usize>) -> Result<Sequence<'py>, Failed> {
        Ok(Sequence { to: self, values: Vec::with_capacity(length.unwrap_or(0)) })
    }

    fn serialize_tuple(self, length: usize) -> Result<Sequence<'py>, Failed> {
        self.serialize_seq(Some(length))
    }

    fn serialize_tuple_struct(self, name: &'static str, _length: usize) -> Result<Self::SerializeTupleStruct, Failed> {
        Err(unsupported(name))
    }

    fn serialize_tuple_variant(
        self,
        name: &'static str,
        _index: u32,
        _variant: &'static str,
        _length: usize,
    ) -> Result<Self::SerializeTupleVariant, Failed> {
        Err(unsupported(name))
    }

    fn serialize_map(self, _length: Option<usize>) -> Result<Mapping<'py>, Failed> {
        Ok(Mapping { to: self, dict: PyDict::new(self.py), key: None })
    }

    fn serialize_struct(self, _name: &'static str, length: usize) -> Result<Mapping<'py>, Failed> {
        self.serialize_map(Some(length))
    }

    fn serialize_struct_variant(
        self,
        name: &'static str,
        _index: u32,
        _variant: &'static str,
        _length: usize,
    ) -> Result<Self::SerializeStructVariant, Failed> {
        Err(unsupported(name))
    }

    fn is_human_readable(&self) -> bool {
        false
    }
}

fn unsupported(name: &str) -> Failed {
    serde::ser::Error::custom(format!("{name} has no form in Python"))
}

/// A tuple in the making.
pub struct Sequence<'py> {
    to: ToPython<'py>,
    values: Vec<Value<'py>>,
}

impl<'py> SerializeSeq for Sequence<'py> {
    type Ok = Value<'py>;
    type Error = Failed;

    fn serialize_element<T: Serialize + ?Sized>(&mut self, value: &T) -> Result<(), Failed> {
        self.values.push(value.serialize(self.to)?);
        Ok(())
    }

    fn end(self) -> Made<'py> {
        Ok(PyTuple::new(self.to.py, self.values)?.into_any())
    }
}

impl<'py> SerializeTuple for Sequence<'py> {
    type Ok = Value<'py>;
    type Error = Failed;

    fn serialize_element<T: Serialize + ?Sized>(&mut self, value: &T) -> Result<(), Failed> {
        SerializeSeq::serialize_element(self, value)
    }

    fn end(self) -> Made<'py> {
        SerializeSeq::end(self)
    }
}

/// A dictionary in the making.
pub struct Mapping<'py> {
    to: ToPython<'py>,
    dict: Bound<'py, PyDict>,
    key: Option<Value<'py>>,
}

impl<'py> SerializeMap for Mapping<'py> {
    type Ok = Value<'py>;
    type Error = Failed;

    fn serialize_key<T: Serialize + ?Sized>(&mut self, key: &T) -> Result<(), Failed> {
        self.key = Some(key.serialize(ToPython { interns: true, ..self.to })?);
        Ok(())
    }

    fn serialize_value<T: Serialize + ?Sized>(&mut self, value: &T) -> Result<(), Failed> {
        let key = self.key.take().ok_or_else(|| unsupported("a value without a key"))?;
        Ok(self.dict.set_item(key, value.serialize(self.to)?)?)
    }

    fn end(self) -> Made<'py> {
        Ok(self.dict.into_any())
    }
}

impl<'py> SerializeStruct for Mapping<'py> {
    type Ok = Value<'py>;
    type Error = Failed;

    fn serialize_field<T: Serialize + ?Sized>(&mut self, key: &'static str, value: &T) -> Result<(), Failed> {
        Ok(self.dict.set_item(PyString::intern(self.to.py, key), value.serialize(self.to)?)?)
    }

    fn end(self) -> Made<'py> {
        Ok(self.dict.into_any())
    }
}
