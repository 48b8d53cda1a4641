//! An operation under way, as Python sees it.

use std::time::Duration;

use pyo3::prelude::*;
use vencejo_flight::plan::{Mission, Plan};
use vencejo_proto::{Address, Header, MavVersion};
use vencejo_station::{Pending, RequestResult, StationError, VehicleHandle};
use vencejo_vehicle::{Param, ParamValue, Reply};

use crate::messages::PyMessage;
use crate::plan::plan_to_tuple;
use crate::{errors, runtime};

/// Makes what came of a wait an object of Python.
type ToPython = fn(Python<'_>, VehicleHandle) -> PyResult<Bound<'_, PyAny>>;

/// The operation that is waited for.
enum Inner {
    Request(Pending<RequestResult>, VehicleHandle),
    Vehicle(Pending<Result<VehicleHandle, StationError>>, ToPython),
}

/// An operation under way.
#[pyclass(frozen, name = "Pending", module = "vencejo._native")]
pub struct PyPending {
    inner: Inner,
    home: runtime::Home,
}

impl PyPending {
    /// A request to a vehicle.
    pub fn of_request(pending: Pending<RequestResult>, vehicle: VehicleHandle) -> Self {
        Self { inner: Inner::Request(pending, vehicle), home: runtime::Home::here() }
    }

    /// A wait for a vehicle.
    pub fn of_vehicle(pending: Pending<Result<VehicleHandle, StationError>>, to_python: ToPython) -> Self {
        Self { inner: Inner::Vehicle(pending, to_python), home: runtime::Home::here() }
    }
}

/// Waits for the end; an operation that still runs after the timeout is cancelled.
fn end_of<T: Clone + Send + Sync>(
    py: Python<'_>,
    pending: &Pending<Result<T, StationError>>,
    timeout: Option<Duration>,
) -> PyResult<T> {
    let mut end = runtime::wait(py, timeout, pending.wait())?;
    if end.is_none() {
        runtime::detached(py, || pending.cancel());
        end = runtime::wait(py, None, pending.wait())?;
    }
    end.flatten().unwrap_or(Err(StationError::Closed)).map_err(|error| errors::from_station(&error))
}

async fn has_ended<T: Clone>(pending: Pending<T>) {
    pending.wait().await;
}

#[pymethods]
impl PyPending {
    /// Waits for the end and gives its value, or raises. After `timeout_s` an operation that still runs is cancelled.
    #[pyo3(signature = (timeout_s))]
    fn wait<'py>(&self, py: Python<'py>, timeout_s: Option<f64>) -> PyResult<Bound<'py, PyAny>> {
        self.home.check("operation")?;
        let timeout = timeout_s.map(runtime::timeout).transpose()?;
        match &self.inner {
            Inner::Request(pending, vehicle) => reply_to_python(py, vehicle, end_of(py, pending, timeout)?),
            Inner::Vehicle(pending, to_python) => to_python(py, end_of(py, pending, timeout)?),
        }
    }

    /// Whether it has ended.
    fn done(&self) -> bool {
        match &self.inner {
            Inner::Request(pending, _) => pending.end().is_some(),
            Inner::Vehicle(pending, _) => pending.end().is_some(),
        }
    }

    /// `(done, total)` of the newest report, `None` before the first.
    fn progress(&self) -> Option<(u32, u32)> {
        let progress = match &self.inner {
            Inner::Request(pending, _) => pending.progress(),
            Inner::Vehicle(pending, _) => pending.progress(),
        };
        (progress.report > 0).then_some((progress.done, progress.total))
    }

    /// After an upload to a vehicle that keeps positions as 32-bit floats: how far the farthest is from where it was
    /// sent to be.
    fn position_error_m(&self) -> Option<f64> {
        match &self.inner {
            Inner::Request(pending, _) => match pending.end() {
                Some(Ok(Reply::Plan { position_error_m, .. })) => position_error_m,
                _ => None,
            },
            Inner::Vehicle(..) => None,
        }
    }

    /// Waits for a report other than number `seen`: `(number, done, total)`, or `None` once it has ended.
    fn wait_progress(&self, py: Python<'_>, seen: u64) -> PyResult<Option<(u64, u32, u32)>> {
        self.home.check("operation")?;
        let progress = match &self.inner {
            Inner::Request(pending, _) => runtime::wait(py, None, pending.next_progress(seen))?,
            Inner::Vehicle(pending, _) => runtime::wait(py, None, pending.next_progress(seen))?,
        };
        Ok(progress.flatten().map(|progress| (progress.report, progress.done, progress.total)))
    }

    /// Gives it up; it ends with `Cancelled`. Nothing in another process, where it does not go on.
    fn cancel(&self, py: Python<'_>) {
        if self.home != runtime::Home::here() {
            return;
        }
        runtime::detached(py, || match &self.inner {
            Inner::Request(pending, _) => pending.cancel(),
            Inner::Vehicle(pending, _) => pending.cancel(),
        });
    }

    /// Calls a function once it has ended, in a thread of its own.
    fn on_done(&self, callback: Py<PyAny>) -> PyResult<()> {
        self.home.check("operation")?;
        let ended: std::pin::Pin<Box<dyn Future<Output = ()> + Send>> = match &self.inner {
            Inner::Request(pending, _) => Box::pin(has_ended(pending.clone())),
            Inner::Vehicle(pending, _) => Box::pin(has_ended(pending.clone())),
        };
        runtime::handle().spawn(async move {
            ended.await;
            tokio::task::spawn_blocking(move || {
                runtime::attached(|py| {
                    if let Err(error) = callback.call0(py) {
                        error.write_unraisable(py, Some(callback.bind(py)));
                    }
                });
            });
        });
        Ok(())
    }
}

/// `(name, value, MAV_PARAM_TYPE, default)`.
fn parameter_tuple(parameter: Param) -> (String, f64, u8, Option<f64>) {
    let value = parameter.value;
    let default = parameter.default.map(ParamValue::as_f64);
    (parameter.name.as_str().to_owned(), value.as_f64(), value.param_type().to_mav() as u8, default)
}

/// The value of a reply: plans, parameters and messages as tuples, `result_param2` as an integer, otherwise `None`.
fn reply_to_python<'py>(py: Python<'py>, vehicle: &VehicleHandle, reply: Reply) -> PyResult<Bound<'py, PyAny>> {
    Ok(match reply {
        Reply::Acknowledged { result_param2 } => result_param2.into_pyobject(py)?.into_any(),
        Reply::Message(message) => {
            let source = vehicle.address().unwrap_or(Address::new(0, 1));
            let frame = message.encode(Header { sequence: 0, source, version: MavVersion::V2 });
            Bound::new(py, PyMessage::received(py, &frame, vehicle.station().now()))?.into_any()
        }
        Reply::Plan { kind, items, home, .. } => {
            let plan = Plan::from_list(kind, Mission { home, items })
                .map_err(|error| errors::raise("TransferError", error))?;
            plan_to_tuple(&plan).into_pyobject(py)?.into_any()
        }
        Reply::Parameters(parameters) => {
            parameters.into_iter().map(parameter_tuple).collect::<Vec<_>>().into_pyobject(py)?.into_any()
        }
        Reply::Parameter(parameter) => parameter_tuple(parameter).into_pyobject(py)?.into_any(),
        _ => py.None().into_bound(py),
    })
}
