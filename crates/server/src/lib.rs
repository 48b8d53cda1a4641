//! HTTP and WebSocket interface: the API of `schemas/openapi.json`, its access control, and the web app's files.
//!
//! It contains no protocol logic: a handler converts, calls the [`vencejo_station::Station`], and waits for the result.
//!
//! | module | owns |
//! |---|---|
//! | `routes` | the paths, one file per group, and their OpenAPI description |
//! | [`dto`] | the types of the API |
//! | `convert` | conversion between the core's values and those types |
//! | `problem` | the mapping of the core's errors to `application/problem+json` |
//! | `access`, `tokens` | `Host`, `Origin`, security headers; tokens, and rate limiting of wrong ones |
//! | `sessions` | sessions, pure; the control lease is the station's |
//! | `door`, `body` | limits of connections, in total and per address, and of their time |
//! | `strict` | JSON in which a structure must be an object |
//! | `operations` | long-running operations |
//! | `operator` | a session of this program itself |
//! | `ws`, `outbox` | the WebSocket: a task and a bounded outbox for each client |
//! | `roster` | the fleet list, sent to each client as a delta |
//! | `separation` | separation of planned flights |
//! | `drafts` | the draft of the plan, with revisions, on disk |
//! | `storage` | storage faults |
//! | `state` | state shared by the handlers, and the task that informs the clients |
//! | `viewer` | a WebSocket for each viewer of a camera |
//! | `files` | the web app |
//!
//! # Permissions
//!
//! | | read (GET, WebSocket) | download plans and parameters from the vehicle | command |
//! |---|---|---|---|
//! | viewer | yes | no | no |
//! | operator | yes | yes | while it holds control; takes it when it is free |
//!
//! On a loopback address without tokens, every client is an operator. Sessions are authenticated by a cookie that
//! scripts cannot read and that pages of other sites do not send.

mod access;
mod assess;
mod body;
mod convert;
mod door;
mod drafts;
pub mod dto;
mod extract;
mod files;
mod followed;
mod ground;
mod guard;
pub mod history;
mod landings;
mod levels;
mod operations;
mod operator;
mod outbox;
mod problem;
mod questions;
mod roster;
mod routes;
mod separation;
mod server;
mod sessions;
mod squares;
mod state;
mod storage;
#[doc(hidden)] // for fuzz/
pub mod strict;
mod terrain;
#[cfg(test)]
mod tests;
mod tokens;
mod turns;
mod viewer;
mod ws;

pub use files::has_app;
pub use operator::Operator;
pub use server::{Server, ServerConfig, ServerError};
pub use tokens::Tokens;

/// Version of the package.
pub const VERSION: &str = env!("CARGO_PKG_VERSION");

/// Constants of the core that the page embeds as `gcs/src/lib/domain/core.json`: a default ArduPlane, the vehicle
/// types, ages of stale values, quality of GPS fixes, thresholds for attention, and the table of mission commands.
pub fn core_facts() -> String {
    let (plane, kinds, ages) = (convert::usual_plane(), convert::vehicle_kinds(), convert::ages());
    let (fixes, attention) = (convert::gps_fixes(), convert::attention());
    let row = |info| serde_json::to_string(&info).expect("invariant: a command is JSON");
    let rows: Vec<String> = convert::commands().into_iter().map(row).collect();
    format!(
        "{{\n\"plane\": {plane},\n\"kinds\": {kinds},\n\"ages\": {ages},\n\"fixes\": {fixes},\n\"attention\": {attention},\n\
         \"commands\": [\n{}\n]\n}}\n",
        rows.join(",\n")
    )
}

/// OpenAPI 3.1 description of the API, as in `schemas/openapi.json`.
pub fn openapi() -> String {
    let mut text = routes::description().to_pretty_json().expect("invariant: the description is JSON");
    text.push('\n');
    text
}
