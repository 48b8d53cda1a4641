//! Work that blocks, off the runtime's threads.

use crate::error::{MapError, Result};

/// Error text when a blocking task panicked.
pub(crate) const FAILED_INSIDE: &str =
    "reading it failed inside the program, which is a fault of the program: please report it, with the file if you may";

/// Runs what blocks off the runtime's threads.
pub(crate) async fn blocking<T: Send + 'static>(work: impl FnOnce() -> Result<T> + Send + 'static) -> Result<T> {
    tokio::task::spawn_blocking(work).await.unwrap_or_else(|error| {
        Err(if error.is_panic() { MapError::file("a map", FAILED_INSIDE) } else { MapError::Closed })
    })
}
