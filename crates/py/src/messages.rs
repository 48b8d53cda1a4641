//! Raw messages for Python, by the names of their fields.

use std::collections::BTreeMap;

use pyo3::prelude::*;
use pyo3::types::{PyBool, PyByteArray, PyBytes, PyDict, PyFloat, PyString, PyTuple};
use vencejo_proto::{FieldValue, Frame, MonoTime, decode_fields};

use crate::errors;
use crate::telemetry::seconds;

/// Adds this module's function.
pub fn register(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_function(wrap_pyfunction!(message_fields, module)?)
}

/// The id of a message by its name.
pub fn message_id(name: &str) -> PyResult<u32> {
    vencejo_proto::message_id_of(name).ok_or_else(|| {
        errors::raise("InvalidRequest", format!("'{name}' is no message of the dialect; names are like 'ATTITUDE'"))
    })
}

/// `(name, system id, component id, time, message id, payload)` of a message.
pub fn message_tuple<'py>(py: Python<'py>, frame: &Frame, at: MonoTime) -> PyResult<Bound<'py, PyTuple>> {
    let (id, source) = (frame.message_id(), frame.source());
    let name = match vencejo_proto::message_name(id) {
        Some(name) => PyString::intern(py, name),
        None => PyString::new(py, &format!("UNKNOWN_{id}")),
    };
    let payload = PyBytes::new(py, frame.payload());
    (name, source.system.0, source.component.0, seconds(at), id, payload).into_pyobject(py)
}

/// The fields of a payload by their names, in the order of the wire. `None` for a message that the dialect does not have.
#[pyfunction]
fn message_fields<'py>(py: Python<'py>, id: u32, payload: &[u8]) -> PyResult<Option<Bound<'py, PyDict>>> {
    let Some(fields) = decode_fields(id, payload) else { return Ok(None) };
    let dict = PyDict::new(py);
    for (name, value) in &fields {
        dict.set_item(*name, to_python(py, value)?)?;
    }
    Ok(Some(dict))
}

fn to_python<'py>(py: Python<'py>, value: &FieldValue) -> PyResult<Bound<'py, PyAny>> {
    Ok(match value {
        FieldValue::Unsigned(value) => value.into_pyobject(py)?.into_any(),
        FieldValue::Signed(value) => value.into_pyobject(py)?.into_any(),
        FieldValue::Float(value) => value.into_pyobject(py)?.into_any(),
        FieldValue::Text(value) => value.into_pyobject(py)?.into_any(),
        FieldValue::List(values) => {
            values.iter().map(|value| to_python(py, value)).collect::<PyResult<Vec<_>>>()?.into_pyobject(py)?
        }
    })
}

/// The fields that are given: numbers, texts, bytes, or sequences of numbers; `None` is none.
pub fn fields_of(message: &str, fields: &Bound<'_, PyDict>) -> PyResult<BTreeMap<String, FieldValue>> {
    let mut given = BTreeMap::new();
    for (name, value) in fields.iter().filter(|(_, value)| !value.is_none()) {
        let name = name.extract::<String>()?;
        let value = to_wire(&value).map_err(|_| {
            let kind = value.get_type();
            errors::raise("InvalidRequest", format!("{message}.{name} takes numbers or text, not {kind}"))
        })?;
        given.insert(name, value);
    }
    Ok(given)
}

fn to_wire(value: &Bound<'_, PyAny>) -> PyResult<FieldValue> {
    if let Ok(text) = value.cast::<PyString>() {
        return Ok(FieldValue::Text(text.to_str()?.to_owned()));
    }
    if value.is_instance_of::<PyBytes>() || value.is_instance_of::<PyByteArray>() {
        let bytes = value.extract::<Vec<u8>>()?;
        return Ok(FieldValue::List(bytes.into_iter().map(|byte| FieldValue::Unsigned(byte.into())).collect()));
    }
    if value.is_instance_of::<PyBool>() {
        return Ok(FieldValue::Unsigned(value.extract::<bool>()?.into()));
    }
    if value.is_instance_of::<PyFloat>() {
        return Ok(FieldValue::Float(value.extract()?));
    }
    // Whole numbers of any kind first, those of numpy too; what is left of numbers has a fraction.
    if let Ok(whole) = value.extract::<u64>() {
        return Ok(FieldValue::Unsigned(whole));
    }
    if let Ok(whole) = value.extract::<i64>() {
        return Ok(FieldValue::Signed(whole));
    }
    if let Ok(values) = value.try_iter() {
        return Ok(FieldValue::List(values.map(|value| to_wire(&value?)).collect::<PyResult<_>>()?));
    }
    Ok(FieldValue::Float(value.extract()?))
}
