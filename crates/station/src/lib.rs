//! The station: everything that is not a pure function or a wire format, behind one façade.
//!
//! A [`Station`] owns links ([`vencejo_link`]), one state machine for each vehicle ([`vencejo_vehicle`]), the clock
//! that drives them, the recording, and the shutdown of all of these. Front doors (Python, HTTP, Ice) hold no protocol
//! logic: they convert values, call a [`VehicleHandle`], and wait for a [`Pending`].
//!
//! Every act on a vehicle is made in the name of an [`Operator`], and one of them at a time holds [`Control`]: the
//! first to act takes it. Acts that [`Danger`](vencejo_vehicle::Danger) names need the confirmation that the station
//! issued for them.
//!
//! ```no_run
//! use vencejo_link::LinkOptions;
//! use vencejo_station::{Station, StationConfig};
//! use vencejo_vehicle::Request;
//!
//! # async fn example() -> Result<(), vencejo_station::StationError> {
//! let station = Station::start(StationConfig::default(), tokio::runtime::Handle::current())?;
//! station.open_link("udpin:0.0.0.0:14550", LinkOptions::default())?;
//! let vehicle = station.wait_vehicle(None).wait().await.expect("the station is open")?;
//! vehicle.request(Request::ReturnToLaunch).wait().await.expect("the station is open")?;
//! station.close().await;
//! # Ok(())
//! # }
//! ```

mod adoption;
mod changes;
mod config;
mod confirm;
mod control;
mod error;
mod namesake;
mod pending;
mod queue;
mod recording;
mod records;
mod remote;
mod replay;
mod signing;
mod spread;
mod station;
mod subscriptions;
mod vehicle;

pub use changes::Changes;
pub use config::StationConfig;
pub use confirm::{Challenge, VALID_FOR};
pub use control::{Control, GRACE, NotTaken, Operator, OperatorId};
pub use error::{StationError, Wanted};
pub use pending::{Pending, Progress};
pub use queue::{DropOldest, Taken};
pub use recording::{
    MAX_FLIGHT_BYTES, RecordedEvent, RecordedTelemetry, RecordingSummary, Sender, recorded_flight, summarize_recording,
};
pub use remote::{Carried, FarHeld, FarNetwork, FarWish, Remote, Silence, Telling};
pub use replay::{
    Film, FilmInfo, MAX_MARKS, MAX_REPLAYS, Mark, MarkKind, Moment, OpenFilm, Replay, ReplayId, ReplayOptions,
    ReplayStatus, SPEEDS,
};
pub use signing::{KeyInfo, SigningChange, SigningError, SigningInfo};
pub use spread::{Runs, rehearse_many};
pub use station::{RequestResult, Station, VehicleHandle};
pub use subscriptions::{Observed, Received};
pub use vehicle::WeakVehicleHandle;
