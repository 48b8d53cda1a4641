//! Links and their signatures for Python.

use pyo3::prelude::*;
use pyo3::types::{PyDict, PyTuple};
use vencejo_link::{LinkInfo, LinkState, LinkStats};
use vencejo_station::{SigningInfo, Station};

/// Adds the functions of this module.
pub fn register(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_function(wrap_pyfunction!(serial_ports, module)?)
}

/// The serial ports of this machine, as `vencejo.link.SerialPort` wants them.
#[pyfunction]
fn serial_ports(py: Python<'_>) -> PyResult<Vec<Bound<'_, PyDict>>> {
    let port_dict = |port: vencejo_link::SerialPort| {
        let dict = PyDict::new(py);
        dict.set_item("device", port.device)?;
        dict.set_item("lasting_path", port.lasting_path)?;
        dict.set_item("description", port.description)?;
        dict.set_item("usual_baud", port.usual_baud)?;
        dict.set_item("is_in_use", port.is_in_use)?;
        dict.set_item("is_allowed", port.is_allowed)?;
        Ok(dict)
    };
    py.detach(vencejo_link::serial_ports).into_iter().map(port_dict).collect()
}

/// A link as `vencejo.station.LinkInfo` wants it.
pub fn link_dict<'py>(
    py: Python<'py>,
    info: &LinkInfo,
    stats: &LinkStats,
    station: &Station,
) -> PyResult<Bound<'py, PyDict>> {
    let now = station.now();
    let (state, detail) = match &info.state {
        LinkState::Connecting { last_error, .. } => ("connecting", last_error.as_ref().map(ToString::to_string)),
        LinkState::Up { .. } => ("up", None),
        LinkState::Down => ("down", None),
        LinkState::Ended { remark } => ("ended", remark.clone()),
    };
    let dict = PyDict::new(py);
    dict.set_item("id", info.id.0)?;
    dict.set_item("name", &info.name)?;
    dict.set_item("address", info.address.to_string())?;
    dict.set_item("local_address", station.local_address(info.id).map(|local| local.to_string()))?;
    dict.set_item("state", state)?;
    dict.set_item("detail", detail)?;
    dict.set_item("frames_received", stats.received.frames)?;
    dict.set_item("frames_sent", stats.sent.frames)?;
    dict.set_item("bytes_received", stats.received.bytes)?;
    dict.set_item("bytes_sent", stats.sent.bytes)?;
    dict.set_item("bad_crc", stats.bad_crc)?;
    dict.set_item("garbage_bytes", stats.garbage_bytes)?;
    dict.set_item("accepts_unsigned", info.accepts_unsigned)?;
    dict.set_item("frames_refused", stats.refused)?;
    dict.set_item("frames_lost", stats.lost)?;
    dict.set_item("loss_pct", stats.loss_ratio.map(|ratio| ratio * 100.0))?;
    dict.set_item("round_trip_ms", stats.round_trip.map(|round_trip| round_trip.last.as_secs_f64() * 1e3))?;
    dict.set_item("age_s", stats.last_seen.map(|seen| now.since(seen).as_secs_f64()))?;
    Ok(dict)
}

/// How a vehicle signs, as `vencejo.signing.SigningInfo` wants it.
pub fn signing_dict<'py>(py: Python<'py>, info: &SigningInfo) -> PyResult<Bound<'py, PyDict>> {
    let dict = PyDict::new(py);
    dict.set_item("must_sign", info.must_sign)?;
    dict.set_item("key", &info.key)?;
    dict.set_item("key_missing", info.key_missing)?;
    dict.set_item("unproven", PyTuple::new(py, &info.unproven)?)?;
    dict.set_item("verified", info.counts.verified)?;
    dict.set_item("unsigned_accepted", info.counts.unsigned_accepted)?;
    dict.set_item("refused_unsigned", info.counts.unsigned)?;
    dict.set_item("refused_wrong_key", info.counts.wrong_key)?;
    dict.set_item("refused_replayed", info.counts.replayed)?;
    dict.set_item("refused_old", info.counts.old)?;
    dict.set_item("refused_future", info.counts.future)?;
    dict.set_item("verified_age_s", info.verified_age.map(|age| age.as_secs_f64()))?;
    dict.set_item("refused_age_s", info.refused_age.map(|age| age.as_secs_f64()))?;
    Ok(dict)
}
