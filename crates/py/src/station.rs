//! The station for Python.

use std::collections::{BTreeMap, HashMap};
use std::path::{Path, PathBuf};

use pyo3::prelude::*;
use pyo3::types::PyDict;
use tokio::sync::watch;
use vencejo_link::{LinkAddress, LinkId, LinkOptions, RecorderState, RecorderStatus, UnsignedPolicy};
use vencejo_proto::{Address, SigningKey, SystemId};
use vencejo_station::{Station, StationConfig};
use vencejo_vehicle::VehicleId;

use crate::link::{link_dict, signing_dict};
use crate::messages::{message_id, message_ids};
use crate::operator::PyOperator;
use crate::pending::PyPending;
use crate::subscription::Subscription;
use crate::vehicle::PyVehicle;
use crate::{errors, runtime, storage};

/// Adds this module's class and functions.
pub fn register(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_class::<PyStation>()?;
    module.add_class::<PyRecorderChanges>()?;
    module.add_function(wrap_pyfunction!(describe_link, module)?)
}

/// A link string in its canonical form.
#[pyfunction]
fn describe_link(address: &str) -> PyResult<String> {
    let address: LinkAddress = address.parse().map_err(|error| errors::raise("InvalidLink", error))?;
    Ok(address.to_string())
}

/// A recording as `vencejo.values.RecorderInfo` wants it.
fn recorder_dict<'py>(py: Python<'py>, folder: &Path, status: &RecorderStatus) -> PyResult<Bound<'py, PyDict>> {
    let path = match &status.state {
        RecorderState::Recording { file } => Some(folder.join(file)),
        _ => None,
    };
    let dict = PyDict::new(py);
    dict.set_item("is_recording", path.is_some())?;
    dict.set_item("path", path)?;
    dict.set_item("frames", status.frames)?;
    dict.set_item("bytes", status.bytes)?;
    dict.set_item("dropped", status.dropped)?;
    dict.set_item("problem", status.state.problem())?;
    Ok(dict)
}

/// Waits for the recording to stop or to go on.
#[pyclass(frozen, name = "RecorderChanges", module = "vencejo._native")]
pub struct PyRecorderChanges {
    folder: PathBuf,
    /// And whether the first state has yet to be returned.
    changes: tokio::sync::Mutex<(watch::Receiver<Option<RecorderStatus>>, bool)>,
}

#[pymethods]
impl PyRecorderChanges {
    /// The next state; `None` when none came in time, or the station is closed.
    fn next<'py>(&self, py: Python<'py>, timeout_s: Option<f64>) -> PyResult<Option<Bound<'py, PyDict>>> {
        let wait = async {
            let mut held = self.changes.lock().await;
            let (changes, is_first) = &mut *held;
            if !std::mem::take(is_first) {
                changes.changed().await.ok()?;
            }
            changes.borrow_and_update().clone()
        };
        let timeout = timeout_s.map(runtime::timeout).transpose()?;
        let status = runtime::wait(py, timeout, wait)?.flatten();
        status.map(|status| recorder_dict(py, &self.folder, &status)).transpose()
    }
}

/// A ground station without a face.
#[pyclass(frozen, name = "Station", module = "vencejo._native")]
pub struct PyStation {
    station: Station,
}

impl PyStation {
    /// The station, for others of this crate.
    pub fn station(&self) -> Station {
        self.station.clone()
    }
}

#[pymethods]
impl PyStation {
    #[new]
    #[pyo3(signature = (*, system_id, component_id, heartbeat, rate_hz, message_rates, record_dir, missions_dir, signing_dir, request_streams, operator, floors_mb=None))]
    #[allow(clippy::too_many_arguments, reason = "keyword arguments of one constructor")]
    fn new(
        system_id: u8,
        component_id: u8,
        heartbeat: bool,
        rate_hz: f64,
        message_rates: HashMap<String, f64>,
        record_dir: Option<String>,
        missions_dir: Option<String>,
        signing_dir: Option<String>,
        request_streams: bool,
        operator: String,
        floors_mb: Option<(u64, u64, u64)>,
    ) -> PyResult<Self> {
        if system_id == 0 || component_id == 0 {
            return Err(errors::raise(
                "InvalidRequest",
                "our own system and component id go from 1 to 255; 0 means everyone",
            ));
        }
        let message_rates = message_rates
            .into_iter()
            .map(|(name, rate_hz)| Ok((message_id(&name)?, rate_hz)))
            .collect::<PyResult<BTreeMap<_, _>>>()?;
        let config = StationConfig {
            address: Address::new(system_id, component_id),
            heartbeat,
            rate_hz,
            message_rates,
            request_streams,
            operator,
            record_dir: record_dir.map(Into::into),
            missions_dir: missions_dir.map(Into::into),
            space: storage::space(floors_mb)?,
            signing_dir: signing_dir.map(Into::into),
        };
        let station =
            Station::start(config, runtime::handle().clone()).map_err(|error| errors::from_station(&error))?;
        #[cfg(feature = "fleet")]
        crate::films::add(&station);
        Ok(Self { station })
    }

    #[pyo3(signature = (address, *, forward, name, accept_unsigned))]
    fn open_link(
        &self,
        address: &str,
        forward: bool,
        name: Option<String>,
        accept_unsigned: Option<bool>,
    ) -> PyResult<u32> {
        let unsigned = match accept_unsigned {
            None => UnsignedPolicy::ByAddress,
            Some(true) => UnsignedPolicy::Accept,
            Some(false) => UnsignedPolicy::Refuse,
        };
        let id = self.station.open_link(address, LinkOptions { name, forwards: forward, unsigned });
        Ok(id.map_err(|error| errors::from_station(&error))?.0)
    }

    fn close_link(&self, py: Python<'_>, link: u32) -> PyResult<()> {
        let closed = runtime::wait(py, None, self.station.close_link(LinkId(link)))?;
        closed.unwrap_or(Ok(())).map_err(|error| errors::from_station(&error))
    }

    fn links<'py>(&self, py: Python<'py>) -> PyResult<Vec<Bound<'py, PyDict>>> {
        self.station.links().iter().map(|(info, stats)| link_dict(py, info, stats, &self.station)).collect()
    }

    fn recorder<'py>(&self, py: Python<'py>) -> PyResult<Option<Bound<'py, PyDict>>> {
        let Some((folder, status)) = self.station.recorder() else { return Ok(None) };
        recorder_dict(py, &folder, &status).map(Some)
    }

    /// The recording's state, and again each time that it stops or goes on.
    fn recorder_changes(&self) -> Option<PyRecorderChanges> {
        let (folder, _) = self.station.recorder()?;
        let changes = tokio::sync::Mutex::new((self.station.recorder_changes(), true));
        Some(PyRecorderChanges { folder, changes })
    }

    fn vehicle_ids(&self) -> Vec<u16> {
        self.station.vehicles().iter().map(|vehicle| vehicle.id().number()).collect()
    }

    #[pyo3(signature = (system_id))]
    fn wait_vehicle(&self, system_id: Option<u16>) -> PyPending {
        PyPending::of_vehicle(self.station.wait_vehicle(system_id.map(VehicleId::new)), PyVehicle::into_python)
    }

    fn wait_named(&self, name: &str) -> PyPending {
        PyPending::of_vehicle(self.station.wait_named(name), PyVehicle::into_python)
    }

    #[pyo3(signature = (names, capacity))]
    fn subscribe_messages(&self, names: Option<Vec<String>>, capacity: usize) -> PyResult<Subscription> {
        Ok(Subscription::of_messages(self.station.subscribe_messages(message_ids(names)?, capacity)))
    }

    fn signing_of<'py>(&self, py: Python<'py>, system_id: u8) -> PyResult<Bound<'py, PyDict>> {
        signing_dict(py, &self.station.signing_of(SystemId(system_id)))
    }

    fn signing_vehicles(&self) -> Vec<u8> {
        self.station.signing_vehicles().into_iter().map(|system| system.0).collect()
    }

    /// `(name, made_unix_s, system ids)` of each key.
    fn signing_keys(&self) -> PyResult<Vec<(String, u64, Vec<u8>)>> {
        let keys = self.station.signing_keys().map_err(|error| errors::from_station(&error))?;
        let of = |systems: &[SystemId]| systems.iter().map(|system| system.0).collect();
        Ok(keys.into_iter().map(|key| (key.name, key.made_unix_s, of(&key.vehicles))).collect())
    }

    #[pyo3(signature = (name, *, key, passphrase))]
    fn add_signing_key(
        &self,
        py: Python<'_>,
        name: &str,
        key: Option<[u8; SigningKey::LEN]>,
        passphrase: Option<&str>,
    ) -> PyResult<()> {
        let key = match (key, passphrase) {
            (Some(bytes), _) => Some(
                SigningKey::new(bytes).ok_or_else(|| errors::raise("InvalidRequest", "a key of zeros means no key"))?,
            ),
            (None, Some(passphrase)) => Some(SigningKey::from_passphrase(passphrase)),
            (None, None) => None,
        };
        let added = runtime::detached(py, || self.station.add_signing_key(name, key));
        added.map_err(|error| errors::from_station(&error))
    }

    fn export_signing_key(&self, name: &str) -> PyResult<String> {
        self.station.export_signing_key(name).map_err(|error| errors::from_station(&error))
    }

    fn forget_signing_key(&self, py: Python<'_>, name: &str) -> PyResult<()> {
        let forgotten = runtime::detached(py, || self.station.forget_signing_key(name));
        forgotten.map_err(|error| errors::from_station(&error))
    }

    #[pyo3(signature = (system_id, name))]
    fn use_signing_key(&self, py: Python<'_>, system_id: u8, name: Option<&str>) -> PyResult<()> {
        let used = runtime::detached(py, || self.station.use_signing_key(SystemId(system_id), name));
        used.map_err(|error| errors::from_station(&error))
    }

    /// In whose name the program acts.
    fn operator(&self) -> PyOperator {
        PyOperator::new(self.station.operator().clone(), self.station.clone())
    }

    /// Another operator; with `asks`, a refused request asks for control.
    fn enlist(&self, name: &str, asks: bool) -> PyOperator {
        let operator = self.station.enlist(name);
        let operator = if asks {
            operator.asking()
        } else {
            // It is there for as long as the program has it.
            operator.attach(self.station.now());
            operator
        };
        PyOperator::new(operator.into(), self.station.clone())
    }

    fn set_heartbeat(&self, enabled: bool) {
        self.station.set_heartbeat(enabled);
    }

    fn close(&self, py: Python<'_>) -> PyResult<()> {
        runtime::wait(py, None, self.station.close()).map(drop)
    }
}
