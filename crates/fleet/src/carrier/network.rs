//! Zenoh as it is used here: what its sessions are told, and its words for what happened.

use std::time::Duration;

use prost::Message;
use zenoh::Session;
use zenoh::bytes::ZBytes;
use zenoh::qos::{CongestionControl, Priority};
use zenoh::query::{ConsolidationMode, Query, QueryTarget};

use super::endpoint::Endpoint;
use crate::error::FleetError;
use crate::payload::MAX_BYTES;
use crate::speech::MAX_EVENTS;

/// How long a router that is gone is believed in, ms; where the way to it is cut, its end is known after that.
const LEASE_MS: u64 = 2_000;
/// Stations that one router takes: each holds one session. Zenoh's own limit is 1,000, and the next one only times out.
const MAX_SESSIONS: usize = 10_000;
/// Bytes of a message at most, as it comes out of the pieces that it came in: more than any payload has. Zenoh's own limit is a gigabyte.
const MAX_MESSAGE: usize = 4 * MAX_BYTES;
/// How long a router is waited for.
const CONNECT: Duration = Duration::from_secs(2);

/// How a station takes part.
#[derive(Debug, Clone, Copy)]
pub(super) enum Part {
    /// It dials a router.
    Client(Endpoint),
    /// It is the router.
    Router(Endpoint),
}

/// Joins the network.
pub(super) async fn open(part: Part) -> Result<Session, FleetError> {
    let mut settings = vec![
        ("scouting/multicast/enabled", "false".to_owned()),
        ("scouting/gossip/enabled", "false".to_owned()),
        ("adminspace/enabled", "false".to_owned()),
        ("transport/link/tx/lease", LEASE_MS.to_string()),
        ("transport/link/tx/keep_alive", "4".to_owned()),
        ("transport/link/rx/max_message_size", MAX_MESSAGE.to_string()),
        ("transport/unicast/max_sessions", MAX_SESSIONS.to_string()),
        ("transport/unicast/accept_pending", MAX_SESSIONS.to_string()),
    ];
    let address = match part {
        Part::Client(router) => {
            settings.push(("mode", "\"client\"".to_owned()));
            settings.push(("listen/endpoints", "[]".to_owned()));
            settings.push(("connect/endpoints", format!("[\"{router}\"]")));
            settings.push(("connect/timeout_ms", CONNECT.as_millis().to_string()));
            router
        }
        Part::Router(listen) => {
            settings.push(("mode", "\"router\"".to_owned()));
            settings.push(("listen/endpoints", format!("[\"{listen}\"]")));
            settings.push(("listen/exit_on_failure", "true".to_owned()));
            listen
        }
    };
    let failed = |problem: String| FleetError::Network { address: address.to_string(), problem };
    let mut config = zenoh::Config::default();
    for (key, value) in settings {
        config.insert_json5(key, &value).map_err(|error| failed(format!("{key}: {error}")))?;
    }
    zenoh::open(config).await.map_err(|error| failed(error.to_string()))
}

/// Tells everybody. Nothing waits for a slow network: what does not fit is dropped, and what must not be lost is asked for again.
pub(super) async fn tell(session: &Session, key: &str, message: &impl Message, priority: Priority) {
    let put = session.put(key, message.encode_to_vec()).congestion_control(CongestionControl::Drop).priority(priority);
    if let Err(error) = put.await {
        // The next one tells the same, or is asked for.
        tracing::debug!(%error, key, "not told");
    }
}

/// How a question ended.
#[derive(Debug)]
pub(super) enum Heard {
    /// The answers, at least one.
    Answers(Vec<Vec<u8>>),
    /// Nobody has an answer, says the network.
    Nobody,
    /// Nothing came in time.
    Silence,
}

/// Asks, and waits for all the answers: as many as there can be events, each no longer than a payload. What is more, nobody meant.
pub(super) async fn ask(session: &Session, selector: &str, payload: Vec<u8>, wait: Duration) -> Heard {
    let get = session
        .get(selector)
        .payload(payload)
        .target(QueryTarget::All)
        .consolidation(ConsolidationMode::None)
        .congestion_control(CongestionControl::Drop)
        .priority(Priority::RealTime)
        .express(true)
        .timeout(wait);
    let Ok(replies) = get.await else { return Heard::Nobody };
    let mut answers = Vec::new();
    while answers.len() < MAX_EVENTS
        && let Ok(reply) = replies.recv_async().await
    {
        match reply.into_result() {
            Ok(sample) if sample.payload().len() > MAX_BYTES => {}
            Ok(sample) => answers.push(sample.payload().to_bytes().into_owned()),
            Err(_) if answers.is_empty() => return Heard::Silence,
            Err(_) => break,
        }
    }
    if answers.is_empty() { Heard::Nobody } else { Heard::Answers(answers) }
}

/// Answers a question, in a task of its own: a slow network keeps nobody from flying.
pub(super) fn reply(query: Query, key: String, messages: Vec<Vec<u8>>) {
    tokio::spawn(async move {
        for bytes in messages {
            if let Err(error) = query.reply(key.clone(), bytes).await {
                // Whoever asked asks again.
                tracing::debug!(%error, key, "not answered");
            }
        }
    });
}

/// The bytes of a payload.
pub(super) fn bytes_of(payload: Option<&ZBytes>) -> Vec<u8> {
    payload.map(|payload| payload.to_bytes().into_owned()).unwrap_or_default()
}

/// An error of the network, where something is declared.
pub(super) fn failed(error: zenoh::Error) -> FleetError {
    FleetError::Network { address: "the network".into(), problem: error.to_string() }
}
