//! Plans, parameters and files to and from a vehicle: one state machine for each transfer, without I/O or clock.
//!
//! Every machine is a [`Transfer`]: pass it the vehicle's messages and the time, send its outputs, and take its result.
//! A machine handles only messages from its vehicle that are addressed to its station (or broadcast) and, for plans,
//! that carry its kind. Nothing here arms, starts, or changes a mode.
//!
//! | machine | does | result |
//! |---|---|---|
//! | [`PlanUpload`] | replaces a plan, reads it back, compares | [`VerifiedPlan`] |
//! | [`PlanDownload`] | reads a plan | [`DownloadedPlan`] |
//! | [`PlanClear`] | removes a plan and checks that it is gone | `()` |
//! | [`ParamList`] | reads all parameters | `Vec<Param>` |
//! | [`ParamRead`] | reads one parameter | [`Param`] |
//! | [`ParamSet`] | writes one parameter, checked by the value that the vehicle then reports | [`Param`] |
//! | [`FtpGet`] | reads a file | `Vec<u8>` |
//!
//! [`PlanRoute`] is the policy between MAVFTP, the item protocol and its older form. ArduPilot has a single MAVFTP
//! session for all channels, so an owner runs **one transfer at a time** per vehicle.
//!
//! ```text
//! PlanUpload ─┬─ ftp::write (mission.dat) ─┐            PlanDownload ─┬─ ftp::read
//!             └─ items::upload ────────────┴─ read back               └─ items::download
//! ```

mod config;
mod download;
mod error;
mod float;
mod ftp;
mod items;
mod params;
mod plan;
mod read_back;
mod route;
mod timing;

#[cfg(test)]
pub(crate) mod testing;
#[cfg(test)]
mod tests;

use vencejo_proto::{Address, Message, MonoTime};

pub use config::{FtpSessions, ItemForm, TransferConfig};
pub use download::{DownloadedPlan, PlanDownload};
pub(crate) use download::{MAX_FILE, file_items};
pub use error::{FTP_OPEN, MissionResult, NoPlanKinds, TransferError};
pub use ftp::FtpGet;
pub(crate) use params::NO_INDEX;
pub use params::{ParamList, ParamRead, ParamSet};
pub(crate) use plan::is_as_sent;
pub use plan::{PlanClear, PlanUpload, VerifiedPlan};
pub(crate) use read_back::Others;
pub use route::PlanRoute;
pub(crate) use timing::UPLOAD_REST;
pub use vencejo_proto::param::{Param, ParamEncoding, ParamName, ParamType, ParamValue};

/// Outputs of a transfer for its owner.
#[derive(Debug, Clone, PartialEq)]
#[allow(clippy::large_enum_variant, reason = "moved once, from the queue to the link")]
pub enum TransferOutput {
    /// Send this to the vehicle.
    Send(Message),
    /// The transfer goes on.
    Progress {
        /// Amount done, in units of `total` (items, parameters or bytes, sent and read back).
        done: u32,
        /// Total amount; 0 when not known yet.
        total: u32,
    },
}

/// A transfer under way.
pub trait Transfer {
    /// Its result.
    type Value;

    /// A message that was received. Messages that do not concern the transfer are ignored.
    fn on_message(&mut self, from: Address, message: &Message, now: MonoTime);

    /// Advances time; call it at [`Transfer::deadline`] or later.
    fn on_time(&mut self, now: MonoTime);

    /// When to call [`Transfer::on_time`] next; `None` when the transfer is over.
    fn deadline(&self) -> Option<MonoTime>;

    /// The next thing to do. Drain it after every call, also after the result is there: a last message may say
    /// good-bye.
    fn poll_output(&mut self) -> Option<TransferOutput>;

    /// The result, once; `None` before, and after it was taken.
    fn result(&mut self) -> Option<Result<Self::Value, TransferError>>;

    /// Gives up: tells the vehicle where the protocol can, and ends with [`TransferError::Cancelled`]. What the vehicle
    /// then holds is unknown until it is read.
    fn cancel(&mut self, now: MonoTime);
}
