//! Guidance laws of `vencejo-flight` for the simulated plane.

use pyo3::prelude::*;

/// Adds the guidance classes to the native module.
pub fn register(_module: &Bound<'_, PyModule>) -> PyResult<()> {
    Ok(())
}
