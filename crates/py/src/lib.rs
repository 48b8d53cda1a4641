//! The PyO3 module `vencejo._native`: converts between Python and the Rust core, and holds no logic of its own.

use pyo3::prelude::*;

mod guidance;

/// The native core of Vencejo. Use the `vencejo` package, not this module.
#[pymodule]
fn _native(module: &Bound<'_, PyModule>) -> PyResult<()> {
    guidance::register(module)?;
    Ok(())
}
