//! The use of Zenoh: session settings, queries and errors.

use std::collections::BTreeSet;
use std::time::Duration;

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use prost::Message;
use serde_json::json;
use tokio::time::{Instant, timeout_at};
use zenoh::Session;
use zenoh::bytes::ZBytes;
use zenoh::qos::{CongestionControl, Priority};
use zenoh::query::{ConsolidationMode, Query, QueryTarget};
use zenoh::sample::Locality;

use super::CONTROL_QUEUE;
use super::endpoint::{Endpoint, Transport};
use super::membership::try_address;
use crate::error::FleetError;
use crate::key::{Name, echo_key};
use crate::papers::certificate::{Identity, STATION_PREFIX};
use crate::papers::stations::MAX_STATIONS;
use crate::payload::MAX_BYTES;
use crate::state_source::MAX_ANSWERED;

/// The lease of a transport, ms: a router behind a cut link counts as gone after that. On a bad network a segment is
/// lost three times in a row, which takes as many round trips, and is no cut.
const LEASE_MS: u64 = 4_000;
/// Keep-alives in a lease: one for each 1.3 s in which nothing else is sent, so none beside a state each second.
const KEEP_ALIVES: usize = 3;
/// Most sessions of a router, one for each station. Zenoh's default is 1,000, beyond which stations time out.
const MAX_SESSIONS: usize = 10_000;
/// Most bytes of a defragmented message: more than any payload has. Zenoh's default is a gigabyte.
const MAX_MESSAGE: usize = 4 * MAX_BYTES;
/// The first pause before a lost router is redialled, ms; it doubles up to 4 s.
const REDIAL_MS: u64 = 200;
/// The connect timeout for a router on this machine.
const CONNECT_HERE: Duration = Duration::from_secs(2);
/// The same for a remote one: TCP, TLS and Zenoh take five round trips, of a second each on a bad network, and some are
/// lost.
const CONNECT: Duration = Duration::from_secs(10);

/// The role of a session.
#[derive(Debug, Clone, Copy)]
pub(super) enum Part<'a> {
    /// A client that dials the first reachable one of these routers, with this timeout, and redials.
    Client(&'a [Endpoint], Duration),
    /// A router at this address, linked with these others, with this access control.
    Router(&'a Endpoint, &'a [Endpoint], Option<&'a serde_json::Value>),
}

/// Joins the network of one of these routers. Each is tried by a handshake first, which reports at once why it would
/// not admit us.
pub(super) async fn dial(routers: &[Endpoint], identity: Option<&Identity>) -> Result<Session, FleetError> {
    let first = routers.first().ok_or_else(|| FleetError::Address(String::new()))?;
    let Some(identity) = identity.filter(|_| first.transport() != Transport::Tcp) else {
        return open(Part::Client(routers, CONNECT_HERE), identity).await;
    };
    let mut problem = None;
    for router in routers {
        match try_address(router, identity).await {
            Ok(()) => return open(Part::Client(routers, CONNECT), Some(identity)).await,
            Err(why) => problem = problem.or(Some(FleetError::Network { address: router.to_string(), problem: why })),
        }
    }
    Err(problem.unwrap_or_else(|| FleetError::Address(String::new())))
}

/// Trusted authorities and our own certificate for encrypted transports.
#[derive(Clone, Copy)]
pub(super) struct Papers<'a> {
    /// The certificates of authorities, as PEM.
    pub(super) ca: &'a str,
    /// Our own certificate, if one is used.
    pub(super) own: Option<&'a Identity>,
}

/// Joins the network of a fleet, with certificates if it is encrypted.
pub(super) async fn open(part: Part<'_>, identity: Option<&Identity>) -> Result<Session, FleetError> {
    let session = join(part, identity.map(|identity| Papers { ca: &identity.ca, own: Some(identity) })).await?;
    if let Part::Client([address, ..], _) = part
        && !(is_with_station(&session).await || address.transport() == Transport::Tcp)
    {
        // Closing ends its declarations even if it fails.
        let _ = session.close().await;
        let problem =
            "who answers there shows a certificate that is not that of a ground station or router of this fleet";
        return Err(FleetError::Network { address: address.to_string(), problem: problem.into() });
    }
    Ok(session)
}

/// Joins a network of any kind.
pub(super) async fn join(part: Part<'_>, papers: Option<Papers<'_>>) -> Result<Session, FleetError> {
    let addresses = match part {
        Part::Client(routers, _) => routers,
        Part::Router(listen, ..) => std::slice::from_ref(listen),
    };
    let Some(address) = addresses.first() else { return Err(FleetError::Address(String::new())) };
    let others: &[Endpoint] = if let Part::Router(_, others, _) = part { others } else { &[] };
    let ways: BTreeSet<_> = addresses.iter().chain(others).map(|address| address.transport().as_str()).collect();
    let endpoints: Vec<_> = match part {
        Part::Client(..) => addresses.iter().map(Endpoint::for_zenoh).collect(),
        Part::Router(..) => addresses.iter().map(Endpoint::to_string).collect(),
    };
    let mut settings = vec![
        ("scouting/multicast/enabled", "false".to_owned()),
        ("scouting/gossip/enabled", "false".to_owned()),
        // A router would wait this long for peers that it does not scout for.
        ("scouting/delay", "0".to_owned()),
        ("adminspace/enabled", "false".to_owned()),
        ("transport/link/protocols", json!(ways).to_string()),
        ("transport/link/tx/lease", LEASE_MS.to_string()),
        ("transport/link/tx/keep_alive", KEEP_ALIVES.to_string()),
        ("transport/link/tx/queue/size/control", CONTROL_QUEUE.to_string()),
        ("transport/link/rx/max_message_size", MAX_MESSAGE.to_string()),
        ("transport/unicast/max_sessions", MAX_SESSIONS.to_string()),
        ("transport/unicast/accept_pending", MAX_SESSIONS.to_string()),
    ];
    match part {
        Part::Client(_, patience) => {
            settings.push(("mode", "\"client\"".to_owned()));
            settings.push(("listen/endpoints", "[]".to_owned()));
            settings.push(("connect/endpoints", json!(endpoints).to_string()));
            settings.push(("connect/timeout_ms", patience.as_millis().to_string()));
            settings.push(("connect/retry", format!("{{period_init_ms: {REDIAL_MS}}}")));
        }
        Part::Router(_, others, access) => {
            settings.push(("mode", "\"router\"".to_owned()));
            let others: Vec<_> = others.iter().map(Endpoint::for_zenoh).collect();
            settings.push(("connect/endpoints", json!(others).to_string()));
            settings.push(("connect/retry", format!("{{period_init_ms: {REDIAL_MS}}}")));
            settings.push(("listen/endpoints", json!(endpoints).to_string()));
            settings.push(("listen/exit_on_failure", "true".to_owned()));
            settings.extend(access.map(|access| ("access_control", access.to_string())));
        }
    }
    if address.transport() != Transport::Tcp {
        let why = "make or join a fleet with `vencejo fleet`".to_owned();
        let papers = papers.ok_or_else(|| FleetError::NoCertificates(address.to_string(), why))?;
        // The files' contents, not their names: in a name `;` and `#` have a meaning.
        let text = |pem: &str| format!("\"{}\"", STANDARD.encode(pem));
        settings.extend([
            ("transport/link/tls/enable_mtls", papers.own.is_some().to_string()),
            ("transport/link/tls/verify_name_on_connect", "true".to_owned()),
            ("transport/link/tls/close_link_on_expiration", "true".to_owned()),
            ("transport/link/tls/root_ca_certificate_base64", text(papers.ca)),
        ]);
        if let Some(own) = papers.own {
            settings.extend([
                ("transport/link/tls/connect_certificate_base64", text(&own.certificate)),
                ("transport/link/tls/connect_private_key_base64", text(&own.key)),
                ("transport/link/tls/listen_certificate_base64", text(&own.certificate)),
                ("transport/link/tls/listen_private_key_base64", text(&own.key)),
            ]);
        }
    }
    let failed = |problem: String| FleetError::Network { address: address.to_string(), problem };
    let mut config = zenoh::Config::default();
    for (key, value) in settings {
        // The value is not shown: it may be a key.
        config.insert_json5(key, &value).map_err(|_| failed(format!("{key} cannot be set")))?;
    }
    zenoh::open(config).await.map_err(|error| failed(words(&error)))
}

/// Whether all peers of a session have the certificate of a ground station or router. Zenoh always trusts the public
/// authorities too; none of those signs such a name.
pub(super) async fn is_with_station(session: &Session) -> bool {
    session.info().links().await.all(|link| link.auth_identifier().is_some_and(|name| name.starts_with(STATION_PREFIX)))
}

/// An unencrypted session with the settings of an aircraft: for programs that simulate many of them.
///
/// # Errors
/// [`FleetError::Network`].
pub async fn session_of_an_aircraft(router: &Endpoint) -> Result<Session, FleetError> {
    open(Part::Client(std::slice::from_ref(router), CONNECT), None).await
}

/// Publishes a message. Nothing waits for a slow network: what does not fit is dropped, and what must not be lost is
/// requested again.
pub(super) async fn tell(session: &Session, key: &str, message: &impl Message, priority: Priority) {
    let put = session.put(key, message.encode_to_vec()).congestion_control(CongestionControl::Drop).priority(priority);
    if let Err(error) = put.await {
        // The next one has the same, or it is requested.
        tracing::debug!(%error, key, "not told");
    }
}

/// The result of a query.
#[derive(Debug)]
pub(super) enum Replies {
    /// The answers, at least one.
    Answers(Vec<Vec<u8>>),
    /// The network reports that there is no receiver.
    Nobody,
    /// Nothing came in time.
    Silence,
}

/// Queries at the highest priority, and waits for all replies.
pub(super) async fn ask(session: &Session, selector: &str, payload: Vec<u8>, wait: Duration) -> Replies {
    ask_at(Priority::RealTime, session, selector, payload, wait).await
}

/// Queries at the highest priority for the answer that `decides`. Once another one has come, this is waited for during
/// `others_within` at most: a session that is dead answers never, and counts as a receiver until its lease ends.
pub(super) async fn ask_for(
    session: &Session,
    selector: &str,
    payload: Vec<u8>,
    wait: Duration,
    others_within: Duration,
    decides: impl Fn(&[u8]) -> bool,
) -> Replies {
    let more = |answer: &[u8]| Some(if decides(answer) { Duration::ZERO } else { others_within });
    gather(Priority::RealTime, session, selector, payload, wait, more).await
}

/// Queries, and waits for all replies. Replies have the query's priority; below the highest several are batched, since
/// single ones would mostly be dropped.
pub(super) async fn ask_at(
    priority: Priority,
    session: &Session,
    selector: &str,
    payload: Vec<u8>,
    wait: Duration,
) -> Replies {
    gather(priority, session, selector, payload, wait, |_| None).await
}

/// Queries, and gathers replies: at most [`MAX_ANSWERED`], each no longer than a payload; surplus replies are dropped.
/// After each one, `more` says how long others are waited for at most; `None`: until all have come.
async fn gather(
    priority: Priority,
    session: &Session,
    selector: &str,
    payload: Vec<u8>,
    wait: Duration,
    more: impl Fn(&[u8]) -> Option<Duration>,
) -> Replies {
    let get = session
        .get(selector)
        .payload(payload)
        .target(QueryTarget::All)
        .consolidation(ConsolidationMode::None)
        .congestion_control(CongestionControl::Drop)
        .priority(priority)
        .express(priority == Priority::RealTime)
        .timeout(wait);
    let Ok(replies) = get.await else { return Replies::Nobody };
    let (mut answers, mut until) = (Vec::new(), None::<Instant>);
    while answers.len() < MAX_ANSWERED {
        let next = replies.recv_async();
        let next = match until {
            Some(until) => timeout_at(until, next).await.ok().and_then(Result::ok),
            None => next.await.ok(),
        };
        let Some(reply) = next else { break };
        match reply.into_result() {
            Ok(sample) if sample.payload().len() > MAX_BYTES => {}
            Ok(sample) => {
                let answer = sample.payload().to_bytes().into_owned();
                let at_most = more(&answer).map(|more| Instant::now() + more);
                until = until.into_iter().chain(at_most).min();
                answers.push(answer);
            }
            Err(_) if answers.is_empty() => return Replies::Silence,
            Err(_) => break,
        }
    }
    if answers.is_empty() { Replies::Nobody } else { Replies::Answers(answers) }
}

/// Requests echoes, calls `came` at the first, and returns all: one of several ground stations may be slow.
pub(super) async fn echo(session: &Session, key: &str, wait: Duration, came: impl FnOnce()) -> Vec<Vec<u8>> {
    let get = session
        .get(key)
        .target(QueryTarget::All)
        .consolidation(ConsolidationMode::None)
        .congestion_control(CongestionControl::Drop)
        .priority(Priority::RealTime)
        .express(true)
        .timeout(wait);
    let (mut came, mut answers) = (Some(came), Vec::new());
    let Ok(replies) = get.await else { return answers };
    while answers.len() < MAX_STATIONS
        && let Ok(reply) = replies.recv_async().await
        && let Ok(sample) = reply.into_result()
    {
        if let Some(came) = came.take() {
            came();
        }
        answers.push(sample.payload().to_bytes().into_owned());
    }
    answers
}

/// Whether another session answers a query under a key.
pub(super) async fn is_answered(session: &Session, key: &str, wait: Duration) -> bool {
    let get = session.get(key).target(QueryTarget::All).allowed_destination(Locality::Remote);
    let get = get.consolidation(ConsolidationMode::None).priority(Priority::RealTime).timeout(wait);
    let Ok(replies) = get.await else { return false };
    matches!(replies.recv_async().await.map(zenoh::query::Reply::into_result), Ok(Ok(_)))
}

/// Whether a router of a fleet without encryption answers at this address: other programs listen there too, such as a
/// router of ROS 2.
pub async fn is_router_of(org: &Name, address: &Endpoint) -> bool {
    let part = Part::Client(std::slice::from_ref(address), CONNECT_HERE);
    let Ok(session) = open(part, None).await else { return false };
    let is_router = is_answered(&session, &echo_key(org), CONNECT_HERE).await;
    // Closing ends its declarations even if it fails.
    let _ = session.close().await;
    is_router
}

/// Replies to a query in a task of its own, so that a slow network does not block.
pub(super) fn reply(query: Query, key: String, messages: Vec<Vec<u8>>) {
    tokio::spawn(async move {
        for bytes in messages {
            if let Err(error) = query.reply(key.clone(), bytes).await {
                // The other end asks again.
                tracing::debug!(%error, key, "not answered");
            }
        }
    });
}

/// The bytes of a payload.
pub(super) fn bytes_of(payload: Option<&ZBytes>) -> Vec<u8> {
    payload.map(|payload| payload.to_bytes().into_owned()).unwrap_or_default()
}

/// The text of a Zenoh error, without its source location; and none of it if it shows the settings of a link, which
/// have a key.
fn words(error: &zenoh::Error) -> String {
    let text = error.to_string();
    if text.contains("_base64") {
        return "the certificates cannot be used".to_owned();
    }
    match text.find(".rs:").and_then(|source| text[..source].rfind(" at ")) {
        Some(end) => text[..end].to_owned(),
        None => text,
    }
}

/// An error of a declaration.
pub(super) fn failed(error: zenoh::Error) -> FleetError {
    FleetError::Network { address: "the network".into(), problem: words(&error) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::key::{Kind, Name, key_of, keys_of_all};

    const WAIT: Duration = Duration::from_secs(10);

    #[tokio::test(flavor = "multi_thread", worker_threads = 2)]
    async fn an_answer_is_not_held_back_by_another_receiver_that_is_silent() {
        let at = "tcp/127.0.0.1:0".parse::<Endpoint>().expect("an address").with_port().expect("a port");
        let router = open(Part::Router(&at, &[], None), None).await.expect("a router");
        let (lively, silent) = (session_of_an_aircraft(&at).await, session_of_an_aircraft(&at).await);
        let (lively, silent) = (lively.expect("an aircraft"), silent.expect("a session that is dead"));
        let orders = lively.declare_queryable("order").complete(true).await.expect("declared");
        let held = silent.declare_queryable("order").complete(true).await.expect("declared");
        // What a session declares last is known last.
        let tokens = router.liveliness().declare_subscriber("*").history(true).await.expect("declared");
        let _lively = lively.liveliness().declare_token("lively").await.expect("declared");
        let _silent = silent.liveliness().declare_token("silent").await.expect("declared");
        for _ in 0..2 {
            tokio::time::timeout(WAIT, tokens.recv_async()).await.expect("in time").expect("a token");
        }
        let mut kept = Vec::new();
        for (others_within, decides) in [(Duration::ZERO, false), (WAIT * 10, true)] {
            let asked = ask_for(&router, "order", vec![1], WAIT * 10, others_within, |_| decides);
            let both = async {
                kept.push(held.recv_async().await.expect("a query"));
                reply(orders.recv_async().await.expect("a query"), "order".to_owned(), vec![vec![2]]);
            };
            let (heard, ()) = tokio::time::timeout(WAIT, async { tokio::join!(asked, both) }).await.expect("in time");
            assert!(matches!(&heard, Replies::Answers(answers) if *answers == [[2]]), "{heard:?}");
        }
        for session in [lively, silent, router] {
            session.close().await.expect("closed");
        }
    }

    #[tokio::test(flavor = "multi_thread", worker_threads = 2)]
    async fn who_comes_late_to_a_large_fleet_is_told_of_all() {
        const AIRCRAFT: usize = 1_500;
        let long = |number: usize| format!("{number:0>32}").parse::<Name>().expect("a name");
        let org = long(0);
        let at = "tcp/127.0.0.1:0".parse::<Endpoint>().expect("an address").with_port().expect("a port");
        let router = open(Part::Router(&at, &[], None), None).await.expect("a router");
        let mut tokens = Vec::new();
        for number in 0..AIRCRAFT {
            let token = router.liveliness().declare_token(key_of(&org, &long(number), Kind::Alive));
            tokens.push(token.await.expect("declared"));
        }
        let late = open(Part::Client(&[at], WAIT), None).await.expect("a ground station");
        let told = late.liveliness().declare_subscriber(keys_of_all(&org, Kind::Alive)).history(true);
        let told = told.await.expect("declared");
        let all = async {
            for _ in 0..AIRCRAFT {
                told.recv_async().await.expect("a token");
            }
        };
        assert!(tokio::time::timeout(WAIT, all).await.is_ok(), "all are told");
        for session in [late, router] {
            session.close().await.expect("closed");
        }
    }
}
