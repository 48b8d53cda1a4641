//! The HTTP and WebSocket front door: the API of `schemas/openapi.json`, who may use it, and the web app's files.
//!
//! It holds no protocol logic: a handler converts, calls the [`vencejo_station::Station`], and waits for what comes back.
//!
//! | module | owns |
//! |---|---|
//! | `routes` | the paths, a file for each group, and their description |
//! | [`dto`] | the types on the wire |
//! | `convert` | from the core's values to those and back |
//! | `problem` | the one table from the core's errors to `application/problem+json` |
//! | `access`, `tokens` | `Host`, `Origin`, security headers; tokens, and what slows down who guesses them |
//! | `sessions` | sessions, pure; the control lease is the station's |
//! | `door`, `body` | how many connections there may be, from whom, and how long each may keep us waiting |
//! | `strict` | JSON in which an object is an object |
//! | `operations` | what takes a while |
//! | `operator` | a session of this very program |
//! | `ws`, `outbox` | the WebSocket: a task and a bounded box for each client |
//! | `roster` | the list of many vehicles, as far as it changed for each client |
//! | `separation` | planned flights held against each other |
//! | `drafts` | the draft of the plan, with revisions, on the disk |
//! | `storage` | what of the disk does not work |
//! | `state` | what handlers share, and the task that tells the clients what goes on |
//! | `viewer` | a WebSocket for each viewer of a camera |
//! | `files` | the web app |
//!
//! # Who may do what
//!
//! | | looks (GET, WebSocket) | reads plans and parameters off the vehicle | commands |
//! |---|---|---|---|
//! | viewer | yes | no | no |
//! | operator | yes | yes | while it holds control; takes it when nobody does |
//!
//! On a loopback address without tokens everybody is an operator. Sessions are proven by a cookie that no script can read
//! and no other site's page sends.

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

/// The version of the package.
pub const VERSION: &str = env!("CARGO_PKG_VERSION");

/// What the page has of the core without asking, as `gcs/src/lib/domain/core.json` holds it: an ArduPlane as it comes, the kinds of
/// vehicles, how old a value may be, what a GPS fix is worth, from when on a value wants attention, and the table of mission commands.
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

/// The description of the API (OpenAPI 3.1) as `schemas/openapi.json` holds it.
pub fn openapi() -> String {
    let mut text = routes::description().to_pretty_json().expect("invariant: the description is JSON");
    text.push('\n');
    text
}
