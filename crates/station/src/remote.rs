//! Remote vehicles, which a station on board reaches and no link of ours: how requests are carried to one.

use std::future::Future;
use std::pin::Pin;
use std::sync::Arc;
use std::time::Duration;

use vencejo_proto::MonoTime;
use vencejo_vehicle::{Danger, Reply, Request};

use crate::error::StationError;
use crate::replay::Shown;

/// A request on its way to a vehicle far away.
pub type Carried = Pin<Box<dyn Future<Output = Result<Reply, StationError>> + Send>>;

/// Reports the progress of a request: amount done, and total (0 when not known).
pub type Telling = Arc<dyn Fn(u32, u32) + Send + Sync>;

/// What carries requests to one vehicle far away.
pub trait Remote: Send + Sync {
    /// Carries a request there, in the name of `operator`, with the danger that a person has confirmed; ends with what
    /// became of it. Whoever gives it up drops it.
    fn request(
        self: Arc<Self>,
        request: Request,
        confirmed: Option<Danger>,
        operator: String,
        telling: Telling,
    ) -> Carried;

    /// Has control of it requested, released or kept, in the name of `operator`.
    fn control(self: Arc<Self>, wish: FarWish, operator: String) -> Carried;

    /// Who has control of it, as far as its station has reported.
    fn held(&self) -> FarHeld;

    /// The silence of its autopilot, if its station on board is heard and reports it. Default none.
    fn silence(&self) -> Option<Silence> {
        None
    }

    /// Whether its certificate was revoked, as far as this station knows. Default no.
    fn is_revoked(&self) -> bool {
        false
    }

    /// Whether it is played from a recording, and takes no requests. Default no.
    fn is_recording(&self) -> bool {
        false
    }
}

/// A change of control of a vehicle far away.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum FarWish {
    /// To ask the holder for control, or take it if it is free.
    Request,
    /// To give control up: it goes to the station that asks for it, or is free. Withdraws a request.
    Release,
    /// To decline a request.
    Keep {
        /// The operator whose request is meant; `None` for the present one.
        requested_by: Option<String>,
    },
}

/// Who has control of a vehicle far away.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct FarHeld {
    /// Name of the operator; `None` when control is free.
    pub holder: Option<String>,
    /// Whether that is an operator of this station.
    pub is_ours: bool,
    /// Name of the operator who asks for control.
    pub requested_by: Option<String>,
    /// Whether that is an operator of this station.
    pub is_request_ours: bool,
}

/// The network of a fleet, over which vehicles far away are heard.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub struct FarNetwork {
    /// Name of the fleet.
    pub name: String,
    /// Why its vehicles are not heard here; `None` while all is well.
    pub problem: Option<String>,
}

/// The silence of an autopilot, as the station on board sees it.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Silence {
    /// Time since it was last heard on board.
    pub lasts: Duration,
    /// The links of the station on board and their states, in words.
    pub links: String,
}

/// A vehicle far away, as the station has it.
pub(crate) struct Adopted {
    pub(crate) name: Arc<str>,
    pub(crate) remote: Arc<dyn Remote>,
    /// The latest moment at which it said something.
    pub(crate) said_at: MonoTime,
    /// Its replay, if it is a recorded one.
    pub(crate) shown: Option<Shown>,
}
