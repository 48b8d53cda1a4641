//! Raw messages for Python, by the names of their fields.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::{Mutex, PoisonError};

use pyo3::prelude::*;
use pyo3::sync::{MutexExt, PyOnceLock};
use pyo3::types::{PyBool, PyByteArray, PyBytes, PyDict, PyFloat, PyMapping, PyMappingProxy, PyString, PyTuple};
use vencejo_proto::{FieldValue, Frame, MonoTime, decode_fields, message_name};
use vencejo_vehicle::MessageId;

use crate::errors;
use crate::telemetry::seconds;

/// The ids of messages by their names; `None` is all.
pub fn message_ids(names: Option<Vec<String>>) -> PyResult<Option<BTreeSet<u32>>> {
    names.map(|names| names.iter().map(|name| message_id(name)).collect()).transpose()
}

/// A raw MAVLink message. Its fields are read when they are asked for: most of those that are called back never are.
#[pyclass(frozen, name = "MavlinkMessage", module = "vencejo._native")]
pub struct PyMessage {
    #[pyo3(get)]
    name: Py<PyString>,
    #[pyo3(get)]
    system_id: u8,
    #[pyo3(get)]
    component_id: u8,
    #[pyo3(get)]
    time_s: f64,
    #[pyo3(get)]
    id: u32,
    #[pyo3(get)]
    payload: Py<PyBytes>,
    fields: PyOnceLock<Py<PyMappingProxy>>,
}

/// The id of a message by its name, or its number.
pub fn message_id(name: &str) -> PyResult<u32> {
    name.parse::<MessageId>().map(|id| id.0).map_err(|error| errors::raise("InvalidRequest", error))
}

/// The name of a message, as one string for all messages of an id.
fn name_of(py: Python<'_>, id: u32) -> Py<PyString> {
    static NAMES: Mutex<BTreeMap<u32, Py<PyString>>> = Mutex::new(BTreeMap::new());
    let Some(name) = message_name(id) else { return PyString::new(py, &format!("UNKNOWN_{id}")).unbind() };
    let mut names = NAMES.lock_py_attached(py).unwrap_or_else(PoisonError::into_inner);
    names.entry(id).or_insert_with(|| PyString::intern(py, name).unbind()).clone_ref(py)
}

impl PyMessage {
    /// A message as it was received.
    pub fn received(py: Python<'_>, frame: &Frame, at: MonoTime) -> Self {
        let (id, source) = (frame.message_id(), frame.source());
        // A copy: what a program keeps must not keep what else came in the same datagrams.
        let payload = PyBytes::new(py, frame.payload());
        Self::new(name_of(py, id), source.system.0, source.component.0, seconds(at), id, payload.unbind())
    }

    /// The values that identify it, in the order of its constructor.
    fn parts<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyTuple>> {
        (&self.name, self.system_id, self.component_id, self.time_s, self.id, &self.payload).into_pyobject(py)
    }
}

#[pymethods]
impl PyMessage {
    #[new]
    fn new(name: Py<PyString>, system_id: u8, component_id: u8, time_s: f64, id: u32, payload: Py<PyBytes>) -> Self {
        Self { name, system_id, component_id, time_s, id, payload, fields: PyOnceLock::new() }
    }

    /// The fields by their names, in the order of the wire; `payload` alone for a message that the dialect does not
    /// have.
    #[getter]
    fn fields<'py>(&self, py: Python<'py>) -> PyResult<&Bound<'py, PyMappingProxy>> {
        let proxy = self.fields.get_or_try_init(py, || {
            let dict = PyDict::new(py);
            match decode_fields(self.id, self.payload.as_bytes(py)) {
                Some(fields) => {
                    for (name, value) in &fields {
                        dict.set_item(*name, to_python(py, value)?)?;
                    }
                }
                None => dict.set_item("payload", &self.payload)?,
            }
            Ok::<_, PyErr>(PyMappingProxy::new(py, dict.cast::<PyMapping>()?).unbind())
        })?;
        Ok(proxy.bind(py))
    }

    fn __eq__(&self, py: Python<'_>, other: &Self) -> PyResult<bool> {
        self.parts(py)?.eq(other.parts(py)?)
    }

    fn __hash__(&self, py: Python<'_>) -> PyResult<isize> {
        self.parts(py)?.hash()
    }

    fn __repr__(&self, py: Python<'_>) -> PyResult<String> {
        let Self { name, system_id, component_id, time_s, id, payload, .. } = self;
        let (name, payload) = (name.bind(py).repr()?, payload.bind(py).repr()?);
        Ok(format!(
            "MavlinkMessage(name={name}, system_id={system_id}, component_id={component_id}, time_s={time_s}, id={id}, \
             payload={payload})"
        ))
    }

    fn __getnewargs__<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyTuple>> {
        self.parts(py)
    }
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

/// The given fields: numbers, texts, bytes, or sequences of numbers; `None` stands for a missing field.
pub fn fields_of(message: &str, fields: &Bound<'_, PyDict>) -> PyResult<BTreeMap<String, FieldValue>> {
    let mut given = BTreeMap::new();
    for (name, value) in fields.iter().filter(|(_, value)| !value.is_none()) {
        let name = name.extract::<String>()?;
        let value = to_wire(&value, true).map_err(|_| {
            let kind = value.get_type();
            errors::raise("InvalidRequest", format!("{message}.{name} takes numbers or text, not {kind}"))
        })?;
        given.insert(name, value);
    }
    Ok(given)
}

/// Values of a sequence that are looked at: a payload has no more bytes, and an iterator need not end.
const MOST_VALUES: usize = 256;

/// An element of a sequence is not a sequence: it could contain itself.
fn to_wire(value: &Bound<'_, PyAny>, may_be_sequence: bool) -> PyResult<FieldValue> {
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
    if may_be_sequence && let Ok(values) = value.try_iter() {
        let values = values.take(MOST_VALUES).map(|value| to_wire(&value?, false));
        return Ok(FieldValue::List(values.collect::<PyResult<_>>()?));
    }
    Ok(FieldValue::Float(value.extract()?))
}
