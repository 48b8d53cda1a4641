//! Bounded queues of messages and events for Python.

use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use pyo3::prelude::*;
use pyo3::types::{PyDict, PyTuple};
use vencejo_link::Pace;
use vencejo_proto::MonoTime;
use vencejo_station::{DropOldest, Observed, Received, Taken, WeakVehicleHandle};
use vencejo_vehicle::VehicleEvent;

use crate::messages::PyMessage;
use crate::runtime;
use crate::telemetry::seconds;

/// How long Python's signal handlers wait at most.
const SIGNAL_INTERVAL: Duration = Duration::from_millis(100);
/// How late a callback may be while entries come faster than it could be called for each at once.
const PAUSE: Duration = Duration::from_millis(1);

#[derive(Clone)]
enum Queue {
    Messages(Arc<DropOldest<Received>>),
    Events(Arc<DropOldest<Observed>>, WeakVehicleHandle),
}

/// How to wait for an entry.
#[derive(Clone, Copy)]
enum Wait<'a> {
    /// As long as this.
    Until(Duration),
    /// For ever, a little late when they come fast.
    Paced(&'a Mutex<Pace>),
}

fn next_of<T: Send>(py: Python<'_>, queue: &DropOldest<T>, wait: Wait<'_>) -> Taken<T> {
    let taken = match (queue.take_ready(), wait) {
        (Taken::TimedOut, Wait::Until(timeout)) => runtime::detached(py, || queue.take_blocking(Some(timeout))),
        (Taken::TimedOut, Wait::Paced(pace)) => runtime::detached(py, || queue.take_paced(&mut lock(pace))),
        (taken, _) => taken,
    };
    if let (Taken::Item(_), Wait::Paced(pace)) = (&taken, wait) {
        lock(pace).on_taken();
    }
    taken
}

fn lock(pace: &Mutex<Pace>) -> MutexGuard<'_, Pace> {
    pace.lock().unwrap_or_else(PoisonError::into_inner)
}

fn to_python<'py, T>(
    taken: Taken<T>,
    convert: impl FnOnce(T) -> PyResult<Bound<'py, PyAny>>,
) -> PyResult<Taken<Bound<'py, PyAny>>> {
    Ok(match taken {
        Taken::Item(item) => Taken::Item(convert(item)?),
        Taken::TimedOut => Taken::TimedOut,
        Taken::Closed => Taken::Closed,
    })
}

impl Queue {
    /// The next entry: what waits already, or, without the GIL, what comes in time.
    ///
    /// A reader that is behind so has all that waits with one acquisition of the GIL.
    fn take<'py>(&self, py: Python<'py>, wait: Wait<'_>) -> PyResult<Taken<Bound<'py, PyAny>>> {
        match self {
            Self::Messages(queue) => {
                let taken = next_of(py, queue, wait);
                to_python(taken, |received| {
                    Ok(Bound::new(py, PyMessage::received(py, &received.frame, received.at))?.into_any())
                })
            }
            Self::Events(queue, vehicle) => {
                let taken = next_of(py, queue, wait);
                to_python(taken, |observed| event_tuple(py, vehicle, &observed.event, observed.at))
            }
        }
    }

    fn close(&self) {
        match self {
            Self::Messages(queue) => queue.close(),
            Self::Events(queue, _) => queue.close(),
        }
    }

    fn dropped(&self) -> u64 {
        match self {
            Self::Messages(queue) => queue.dropped(),
            Self::Events(queue, _) => queue.dropped(),
        }
    }

    fn is_closed(&self) -> bool {
        match self {
            Self::Messages(queue) => queue.is_closed(),
            Self::Events(queue, _) => queue.is_closed(),
        }
    }
}

/// A bounded queue of what happens on a vehicle.
#[pyclass(frozen, module = "vencejo._native")]
pub struct Subscription {
    queue: Queue,
    /// How the thread that calls back takes them.
    pace: Mutex<Pace>,
    /// Whether the reader itself has ended it: then it wants no more of what waits either.
    is_ended: AtomicBool,
    failed: AtomicU64,
    home: runtime::Home,
}

impl Subscription {
    /// A queue of messages.
    pub fn of_messages(queue: Arc<DropOldest<Received>>) -> Self {
        Self::of(Queue::Messages(queue))
    }

    /// A queue of events.
    pub fn of_events(queue: Arc<DropOldest<Observed>>, vehicle: WeakVehicleHandle) -> Self {
        Self::of(Queue::Events(queue, vehicle))
    }

    fn of(queue: Queue) -> Self {
        Self {
            queue,
            pace: Mutex::new(Pace::new(PAUSE)),
            is_ended: AtomicBool::new(false),
            failed: AtomicU64::new(0),
            home: runtime::Home::here(),
        }
    }
}

#[pymethods]
impl Subscription {
    /// Entries dropped because they were not read in time.
    #[getter]
    fn dropped(&self) -> u64 {
        self.queue.dropped()
    }

    /// Calls that raised an exception.
    #[getter]
    fn failed(&self) -> u64 {
        self.failed.load(Ordering::Relaxed)
    }

    /// Counts a call that raised.
    fn on_failed(&self) {
        self.failed.fetch_add(1, Ordering::Relaxed);
    }

    /// Whether nothing will be added: what waits can still be taken.
    #[getter]
    fn is_closed(&self) -> bool {
        self.queue.is_closed()
    }

    /// Takes the oldest entry; `None` when nothing comes in time or the queue is closed.
    #[pyo3(signature = (timeout_s))]
    fn get<'py>(&self, py: Python<'py>, timeout_s: Option<f64>) -> PyResult<Option<Bound<'py, PyAny>>> {
        self.home.check("subscription")?;
        let timeout = timeout_s.map(runtime::timeout).transpose()?;
        let deadline = timeout.and_then(|timeout| Instant::now().checked_add(timeout));
        loop {
            let rest = deadline.map_or(SIGNAL_INTERVAL, |deadline| {
                deadline.saturating_duration_since(Instant::now()).min(SIGNAL_INTERVAL)
            });
            match self.queue.take(py, Wait::Until(rest))? {
                Taken::Item(item) => return Ok(Some(item)),
                Taken::Closed => return Ok(None),
                Taken::TimedOut => py.check_signals()?,
            }
            if deadline.is_some_and(|deadline| Instant::now() >= deadline) {
                return Ok(None);
            }
        }
    }

    /// As `get` without a time-out, for the thread that calls back, which no signal is for: nothing more once `close`
    /// was called.
    fn next<'py>(&self, py: Python<'py>) -> PyResult<Option<Bound<'py, PyAny>>> {
        let is_ended = || self.is_ended.load(Ordering::Acquire);
        if is_ended() {
            return Ok(None);
        }
        Ok(match self.queue.take(py, Wait::Paced(&self.pace))? {
            Taken::Item(item) if !is_ended() => Some(item),
            _ => None,
        })
    }

    /// Ends it. A callback that runs comes to its end; what waits is not called back any more, but `get` still gives
    /// it.
    fn close(&self) {
        self.is_ended.store(true, Ordering::Release);
        self.queue.close();
    }

    fn __enter__(slf: PyRef<'_, Self>) -> PyRef<'_, Self> {
        slf
    }

    #[pyo3(signature = (*_exception))]
    fn __exit__(&self, _exception: &Bound<'_, PyTuple>) {
        self.close();
    }
}

impl Drop for Subscription {
    fn drop(&mut self) {
        // Nobody can read it any more.
        self.queue.close();
    }
}

/// `(kind, time, detail)` of an event.
fn event_tuple<'py>(
    py: Python<'py>,
    vehicle: &WeakVehicleHandle,
    event: &VehicleEvent,
    at: MonoTime,
) -> PyResult<Bound<'py, PyAny>> {
    let detail = PyDict::new(py);
    let item_of = |seq| vehicle.upgrade().and_then(|vehicle| vehicle.item_of_seq(seq));
    let kind = match event {
        VehicleEvent::Lost => "lost",
        VehicleEvent::Regained => "regained",
        VehicleEvent::Unreached => "unreached",
        VehicleEvent::Reached => "reached",
        VehicleEvent::Rebooted => "rebooted",
        VehicleEvent::ModeChanged { from, to } => {
            detail.set_item("from", from.map(|from| from.to_string()))?;
            detail.set_item("mode", to.to_string())?;
            "mode"
        }
        VehicleEvent::ArmedChanged { is_armed } => {
            detail.set_item("is_armed", is_armed)?;
            if *is_armed { "armed" } else { "disarmed" }
        }
        VehicleEvent::LandedChanged { landed } => {
            detail.set_item("landed", landed.to_string())?;
            "landed"
        }
        VehicleEvent::Text(text) => {
            detail.set_item("severity", text.severity.0)?;
            detail.set_item("text", &text.text)?;
            "text"
        }
        VehicleEvent::CurrentItemChanged { seq } => {
            detail.set_item("item", item_of(*seq))?;
            "item"
        }
        VehicleEvent::ItemReached { seq } => {
            detail.set_item("item", item_of(*seq))?;
            "item_reached"
        }
        VehicleEvent::MissionComplete => "mission_complete",
        VehicleEvent::PlanStateChanged { kind, state } => {
            detail.set_item("kind", kind.to_string())?;
            detail.set_item("state", state.to_string())?;
            "plan"
        }
        VehicleEvent::TargetElsewhere { seq, distance_m } => {
            detail.set_item("item", item_of(*seq))?;
            detail.set_item("distance_m", distance_m)?;
            "target_elsewhere"
        }
        VehicleEvent::TargetAsPlanned { seq } => {
            detail.set_item("item", item_of(*seq))?;
            "target_as_planned"
        }
        VehicleEvent::ParamChanged(param) => {
            detail.set_item("name", param.name.as_str())?;
            detail.set_item("value", param.value.as_f64())?;
            "param"
        }
        VehicleEvent::HomeChanged => "home",
        VehicleEvent::StreamsFellBack => "streams_fell_back",
        VehicleEvent::Contested => "contested",
        VehicleEvent::Uncontested => "uncontested",
        VehicleEvent::TerrainUnknown => "terrain_unknown",
        VehicleEvent::TerrainKnown => "terrain_known",
        _ => "other",
    };
    Ok((kind, seconds(at), detail).into_pyobject(py)?.into_any())
}
