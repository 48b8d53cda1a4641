//! The PyO3 module `vencejo._native`: converts between Python and the Rust core, and holds no logic of its own.
//!
//! Waiting happens without the GIL, in slices, so that Ctrl-C works. Python is never called from a link's task:
//! callbacks run in threads of their own behind bounded queues.

use pyo3::prelude::*;

mod errors;
#[cfg(feature = "fleet")]
mod films;
#[cfg(feature = "fleet")]
mod fleet;
mod geodesy;
mod ground;
mod guidance;
mod landing;
mod link;
mod messages;
mod operator;
mod pending;
mod plan;
mod recording;
mod rehearsal;
mod replay;
mod requests;
#[cfg(feature = "fleet")]
mod ros2;
mod runtime;
mod separation;
mod serial;
mod server;
mod station;
mod storage;
mod subscription;
mod survey;
mod telemetry;
mod vehicle;
mod video;

/// The native core of Vencejo. Use the `vencejo` package, not this module.
#[pymodule]
fn _native(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add("__version__", env!("CARGO_PKG_VERSION"))?;
    errors::register(module)?;
    #[cfg(feature = "fleet")]
    fleet::register(module)?;
    #[cfg(feature = "fleet")]
    ros2::register(module)?;
    geodesy::register(module)?;
    guidance::register(module)?;
    landing::register(module)?;
    link::register(module)?;
    operator::register(module)?;
    plan::register(module)?;
    recording::register(module)?;
    rehearsal::register(module)?;
    replay::register(module)?;
    requests::register(module)?;
    separation::register(module)?;
    server::register(module)?;
    station::register(module)?;
    storage::register(module)?;
    survey::register(module)?;
    vehicle::register(module)?;
    video::register(module)?;
    module.add_function(wrap_pyfunction!(runtime::abandon, module)?)?;
    module.add_function(wrap_pyfunction!(runtime::forked, module)?)?;
    module.add_function(wrap_pyfunction!(runtime::end_waits, module)?)?;
    module.add_class::<ground::Elevation>()?;
    module.add_class::<messages::PyMessage>()?;
    module.add_class::<pending::PyPending>()?;
    module.add_class::<subscription::Subscription>()?;
    module.add_class::<telemetry::TelemetrySnapshot>()?;
    Ok(())
}
