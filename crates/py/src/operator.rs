//! Operators for Python: the program itself, a session of a server, or another front end of this process.

use std::sync::Arc;

use pyo3::prelude::*;
use vencejo_server::Operator as Session;
use vencejo_station::{Operator, Station};

use crate::errors;

/// Adds this module's class.
pub fn register(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_class::<PyOperator>()
}

/// An operator of a station's vehicles.
#[pyclass(frozen, name = "Operator", module = "vencejo._native")]
pub struct PyOperator {
    operator: Arc<Operator>,
    station: Station,
    /// Of a server, when it is one.
    session: Option<Session>,
}

impl PyOperator {
    /// One of a station.
    pub fn new(operator: Arc<Operator>, station: Station) -> Self {
        Self { operator, station, session: None }
    }

    /// One that a server shows as a session.
    pub fn of_session(session: Session, station: Station) -> Self {
        Self { operator: session.to_station(), station, session: Some(session) }
    }

    /// To act in its name.
    pub fn operator(&self) -> Arc<Operator> {
        self.operator.clone()
    }
}

#[pymethods]
impl PyOperator {
    fn name(&self) -> String {
        self.operator.name()
    }

    fn has_control(&self) -> bool {
        self.operator.has_control()
    }

    fn holder(&self) -> Option<String> {
        self.operator.control().holder()
    }

    fn requested_by(&self) -> Option<String> {
        self.operator.control().requested_by()
    }

    fn take(&self) -> bool {
        self.operator.take(self.station.now()).is_ok()
    }

    fn take_over(&self, holder: &str) -> PyResult<()> {
        let taken = self.operator.take_over(holder, self.station.now());
        taken.map_err(|reason| errors::from_station(&reason.into()))
    }

    fn request(&self) -> bool {
        self.operator.request(self.station.now())
    }

    fn keep(&self, requested_by: Option<&str>) {
        self.operator.keep(requested_by, self.station.now());
    }

    fn release(&self) {
        self.operator.release(self.station.now());
    }

    fn attach(&self) {
        self.operator.attach(self.station.now());
    }

    fn detach(&self) {
        self.operator.detach(self.station.now());
    }

    fn close(&self) {
        match &self.session {
            Some(session) => session.close(),
            None => self.operator.release(self.station.now()),
        }
    }
}
