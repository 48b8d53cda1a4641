//! Summaries of recordings.

use std::fs::File;
use std::path::PathBuf;

use pyo3::prelude::*;
use pyo3::types::PyDict;
use vencejo_flight::rehearsal::IsWanted;
use vencejo_station::summarize_recording as summarize;

use crate::errors;
use crate::runtime::{self, WhileWanted};

/// Adds the functions of this module.
pub fn register(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_function(wrap_pyfunction!(summarize_recording, module)?)
}

/// The contents of a `.tlog` file, as the fields of `vencejo.recording.RecordingSummary`.
#[pyfunction]
fn summarize_recording(py: Python<'_>, path: PathBuf) -> PyResult<Bound<'_, PyDict>> {
    let name = path.clone();
    let read =
        move |is_wanted: IsWanted<'_>| File::open(&name).and_then(|file| summarize(WhileWanted(file, is_wanted)));
    let summary = runtime::interruptible(py, read)?
        .map_err(|error| errors::raise("FileFormatError", format!("{}: {error}", path.display())))?;
    let fields = PyDict::new(py);
    fields.set_item("frames", summary.frames)?;
    fields.set_item("skipped_bytes", summary.skipped_bytes)?;
    fields.set_item("start_unix_s", summary.start_unix_us.map(|start_us| start_us as f64 / 1e6))?;
    fields.set_item("duration_s", summary.duration.as_secs_f64())?;
    fields.set_item("messages", summary.messages)?;
    let senders = summary.senders.into_iter();
    let senders: Vec<_> =
        senders.map(|(address, sender)| (address.system.0, address.component.0, sender.frames, sender.kind)).collect();
    fields.set_item("senders", senders)?;
    let events = summary.events.into_iter();
    let events: Vec<_> = events.map(|event| (event.at.as_secs_f64(), event.system.0, event.kind, event.text)).collect();
    fields.set_item("events", events)?;
    fields.set_item("events_left_out", summary.events_left_out)?;
    Ok(fields)
}
