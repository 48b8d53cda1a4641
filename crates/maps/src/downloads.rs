//! The downloads of offline areas that are under way.

use std::collections::HashMap;
use std::sync::atomic::AtomicU64;
use std::sync::{Arc, Mutex};

use tokio::sync::{Semaphore, watch};

/// Areas that download at once.
const AT_ONCE: usize = 2;

#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Rate {
    pub(crate) tiles_s: Option<f64>,
}

/// The downloads under way.
#[derive(Debug)]
pub(crate) struct Running {
    /// By area: which run it is, and what stops it.
    pub(crate) stops: Mutex<HashMap<String, (u64, watch::Sender<bool>)>>,
    pub(crate) runs: AtomicU64,
    pub(crate) rates: Mutex<HashMap<String, Rate>>,
    pub(crate) gate: Arc<Semaphore>,
}

impl Default for Running {
    fn default() -> Self {
        Self {
            stops: Mutex::default(),
            runs: AtomicU64::new(0),
            rates: Mutex::default(),
            gate: Arc::new(Semaphore::new(AT_ONCE)),
        }
    }
}
