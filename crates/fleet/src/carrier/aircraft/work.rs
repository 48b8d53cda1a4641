//! An order in progress on board: the queries that wait for it, its progress, and its cancellation.

use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use vencejo_flight::plan::{Mission, PlanKind};
use vencejo_station::{Pending, Progress, RequestResult, StationError, VehicleHandle};
use vencejo_vehicle::{Danger, Reply, Request, VehicleError};
use zenoh::query::Query;

use crate::carrier::checked::plan_errors;
use crate::payload::Order;
use crate::signature::PublicKey;

/// Most queries that wait for an order. An order is sent again each four seconds, and each attempt is waited for during
/// twenty: earlier ones have ended on the ground.
const MAX_WAITING: usize = 6;

/// The plan that a request reads, replaces or removes.
pub(super) fn plan_of(request: &Request) -> Option<PlanKind> {
    match request {
        Request::UploadPlan { kind, .. } | Request::ClearPlan { kind } | Request::DownloadPlan { kind } => Some(*kind),
        _ => None,
    }
}

/// An order in progress.
pub(super) struct UnderWay {
    slot: Slot,
    /// The plan that it is about.
    pub(super) plan: Option<PlanKind>,
    /// Whether it acts on the vehicle.
    pub(super) is_act: bool,
    /// The key of its sender, and the order itself.
    pub(super) order: (PublicKey, Order),
    /// The queries that wait for its end.
    pub(super) queries: Vec<Query>,
}

impl UnderWay {
    pub(super) fn new(request: &Request, order: (PublicKey, Order), query: Query) -> Self {
        let slot = Slot::default();
        Self { slot, plan: plan_of(request), is_act: request.is_act(), order, queries: vec![query] }
    }

    pub(super) fn slot(&self) -> Slot {
        self.slot.clone()
    }

    /// The order was sent again.
    pub(super) fn wait(&mut self, query: Query) {
        if self.queries.len() == MAX_WAITING {
            self.queries.remove(0);
        }
        self.queries.push(query);
    }

    /// Shares the request that was started for another order.
    pub(super) fn join(&mut self, slot: Slot) {
        self.slot = slot;
    }

    pub(super) fn writes_plan(&self) -> bool {
        self.plan.is_some() && self.is_act
    }

    /// Its progress; `None` before the first report.
    pub(super) fn progress(&self) -> Option<Progress> {
        let progress = self.slot.lock().pending.as_ref()?.progress();
        (progress.report > 0).then_some(progress)
    }

    /// Cancels it; it still ends.
    pub(super) fn cancel(&self) {
        self.slot.cancel();
    }
}

/// The request, once it has started.
#[derive(Clone, Default)]
pub(super) struct Slot(Arc<Mutex<State>>);

#[derive(Default)]
struct State {
    pending: Option<Pending<RequestResult>>,
    is_cancelled: bool,
    known: Option<Reply>,
}

impl Slot {
    fn lock(&self) -> MutexGuard<'_, State> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn cancel(&self) {
        let pending = {
            let mut state = self.lock();
            state.is_cancelled = true;
            state.pending.clone()
        };
        if let Some(pending) = pending {
            pending.cancel();
        }
    }

    /// Ends it with a known reply, if there is one.
    pub(super) fn end_with(&self, known: Option<Reply>) {
        self.lock().known = known;
    }

    /// Starts it at once, so that orders are executed in the order in which they come; but a plan is checked before, which
    /// takes time.
    pub(super) fn start(
        &self,
        vehicle: VehicleHandle,
        request: Request,
        confirmed: Option<Danger>,
    ) -> impl Future<Output = RequestResult> + Send + use<> {
        let slot = self.clone();
        let known = slot.lock().known.take();
        let unchecked = list_to_check(&request);
        if known.is_none() && unchecked.is_none() {
            slot.begin(&vehicle, request.clone(), confirmed);
        }
        async move {
            if let Some(known) = known {
                return Ok(known);
            }
            if let Some((kind, list)) = unchecked {
                let checked = vehicle.clone();
                let checks = tokio::task::spawn_blocking(move || find_errors(&checked, kind, list));
                checks.await.map_err(|_| StationError::Closed)??;
                slot.begin(&vehicle, request, confirmed);
            }
            let pending = slot.lock().pending.clone();
            match pending {
                Some(pending) => pending.wait().await.unwrap_or(Err(StationError::Closed)),
                None => Err(VehicleError::Cancelled.into()),
            }
        }
    }

    fn begin(&self, vehicle: &VehicleHandle, request: Request, confirmed: Option<Danger>) {
        let mut state = self.lock();
        if !state.is_cancelled {
            state.pending = Some(match confirmed {
                Some(danger) => vehicle.request_naming(request, danger),
                None => vehicle.request(request),
            });
        }
    }
}

/// The list to check before it is uploaded.
fn list_to_check(request: &Request) -> Option<(PlanKind, Mission)> {
    match request {
        Request::UploadPlan { kind, items, home, despite_findings: false } if !items.is_empty() => {
            Some((*kind, Mission { home: *home, items: items.clone() }))
        }
        _ => None,
    }
}

/// Checks a list with what is known on board.
fn find_errors(vehicle: &VehicleHandle, kind: PlanKind, list: Mission) -> Result<(), StationError> {
    let Some(errors) = plan_errors(vehicle, kind, list) else { return Ok(()) };
    let why =
        format!("by what is known on board the plan has {errors}; nothing was sent: mend it, or send it unchecked");
    // Reported on the ground as the refusal of the station on board.
    Err(StationError::RemoteRefused { name: vehicle.id().to_string(), why })
}
