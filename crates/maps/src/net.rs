//! Fetching from the services that are configured, and from nowhere else: private addresses are reached only where a
//! source says so, link-local ones never; redirects are followed by hand and checked; a key goes to its source's host
//! and to no other; answers are bounded, and texts never hold a key.

use std::collections::{BTreeSet, HashMap};
use std::error::Error as StdError;
use std::fmt;
use std::net::{IpAddr, Ipv4Addr, Ipv6Addr, SocketAddr};
use std::ops::Range;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, SystemTime};

use bytes::{Bytes, BytesMut};
use reqwest::dns::{Addrs, Name, Resolve, Resolving};
use reqwest::header::{self, HeaderMap, HeaderName};
use reqwest::{Client, redirect};
use serde::Deserialize;
use tokio::sync::{OwnedSemaphorePermit, Semaphore};
use url::{Host, Url};

use crate::error::{MapError, Result, Unreached};
use crate::settings::SourceSettings;
use crate::sniff;

/// User-Agent, which operators of tile servers require.
pub const USER_AGENT: &str =
    concat!("Vencejo/", env!("CARGO_PKG_VERSION"), " (+https://github.com/jderobot/vencejo; ground station)");
/// Redirects that are followed.
const MAX_REDIRECTS: usize = 5;
/// Default of concurrent fetches from a host.
const DEFAULT_PARALLEL: u8 = 4;

/// How long services are given.
#[derive(Debug, Clone, Copy)]
pub struct Patience {
    /// To accept a connection.
    pub connect: Duration,
    /// For a whole answer.
    pub whole: Duration,
}

impl Default for Patience {
    fn default() -> Self {
        Self { connect: Duration::from_secs(6), whole: Duration::from_secs(20) }
    }
}

/// What to fetch, and under which rules.
#[derive(Debug, Clone)]
pub struct Request {
    /// From where.
    pub url: Url,
    /// Host of the source's own address when private addresses are allowed there.
    pub local_host: Option<String>,
    /// Of the copy at hand.
    pub etag: Option<String>,
    /// Of the copy at hand.
    pub last_modified: Option<String>,
    /// Bytes of the answer at most, unpacked.
    pub max_bytes: usize,
    /// Sent as JSON by POST, when there is one.
    pub json: Option<String>,
    /// The user's key, which no message may hold.
    pub secret: Option<String>,
    /// The hosts that the key is for.
    pub key_hosts: BTreeSet<String>,
    /// Fetches at once from this host.
    pub parallel: u8,
    /// Only these bytes of the file, its first and one beyond its last.
    pub range: Option<Range<u64>>,
}

impl Request {
    /// A plain request of a source's.
    ///
    /// # Errors
    /// [`MapError::Request`] for an invalid address.
    pub fn new(settings: &SourceSettings, url: &str, max_bytes: usize) -> Result<Self> {
        let secret = settings.key().map(str::to_owned);
        let parsed = Url::parse(url)
            .map_err(|error| MapError::Request(hide(&format!("{url:?} is no address: {error}"), secret.as_deref())))?;
        if !matches!(parsed.scheme(), "http" | "https") {
            return Err(MapError::Request("addresses of services begin with https:// or http://".to_owned()));
        }
        let request = Self {
            local_host: local_host(settings),
            key_hosts: settings.key_hosts(),
            url: parsed,
            etag: None,
            last_modified: None,
            max_bytes,
            json: None,
            secret,
            parallel: settings.parallel.unwrap_or(DEFAULT_PARALLEL),
            range: None,
        };
        match request.stray_key(&request.url) {
            Some(reason) => Err(MapError::Service { host: shown(&request.url), status: None, reason }),
            None => Ok(request),
        }
    }

    /// Why an address may not be asked: it holds the key, and is not of a host that the key is for.
    fn stray_key(&self, url: &Url) -> Option<String> {
        let secret = self.secret.as_deref().filter(|secret| secret.len() >= MIN_SECRET)?;
        let is_own = url.host_str().is_some_and(|host| self.key_hosts.contains(host));
        let has_key = url.as_str().contains(secret) || url.as_str().contains(&crate::address::escape(secret));
        (has_key && !is_own).then(|| {
            let hosts: Vec<&str> = self.key_hosts.iter().map(String::as_str).collect();
            format!("would be given the key, which is for {} alone; nothing was sent", hosts.join(", "))
        })
    }
}

/// Characters of a key from which on it is looked for in addresses: what is shorter is in many by chance.
const MIN_SECRET: usize = 4;

/// The host of a source's own address, when the source says that it is in this network.
fn local_host(settings: &SourceSettings) -> Option<String> {
    let plain: String =
        settings.url.as_deref()?.chars().map(|c| if matches!(c, '{' | '}') { '0' } else { c }).collect();
    let url = Url::parse(&plain).ok()?;
    settings.local_network.then(|| url.host_str().unwrap_or_default().to_owned())
}

/// Whether an address may be asked: any on the public Internet; in this network where the source says that it is there,
/// but for those of the link itself, of many receivers, and where clouds keep the keys of their machines.
pub fn may_ask(ip: IpAddr, is_own: bool) -> bool {
    is_public(ip) || (is_own && !is_never(ip))
}

fn is_never(ip: IpAddr) -> bool {
    match ip {
        IpAddr::V4(ip) => {
            let [a, ..] = ip.octets();
            ip.is_link_local() || ip.is_multicast() || a == 0 || a >= 240 || ip == Ipv4Addr::new(100, 100, 100, 200)
        }
        IpAddr::V6(ip) => match ip.to_ipv4() {
            Some(v4) if ip != Ipv6Addr::LOCALHOST => is_never(v4.into()),
            _ => {
                let words = ip.segments();
                let is_cloud = words == [0xfd00, 0xec2, 0, 0, 0, 0, 0, 0x254];
                // Addresses that embed others belong to the Internet; private networks do not need them.
                let is_within = words[0] == 0x2002 || words[..2] == [0x64, 0xff9b];
                ip.is_unspecified() || ip.is_multicast() || words[0] & 0xffc0 == 0xfe80 || is_cloud || is_within
            }
        },
    }
}

/// Whether an address is on the public Internet (IANA's special-purpose registries).
pub fn is_public(ip: IpAddr) -> bool {
    match ip {
        IpAddr::V4(ip) => is_public_v4(ip),
        IpAddr::V6(ip) => is_public_v6(ip),
    }
}

fn is_public_v4(ip: Ipv4Addr) -> bool {
    let [a, b, c, _] = ip.octets();
    !(ip.is_loopback()
        || ip.is_private()
        || ip.is_link_local()
        || ip.is_unspecified()
        || ip.is_broadcast()
        || ip.is_documentation()
        || ip.is_multicast()
        || a == 0
        || a >= 240
        || (a == 100 && (64..128).contains(&b))
        || (a == 192 && b == 0 && c == 0)
        || (a == 198 && (18..20).contains(&b)))
}

fn is_public_v6(ip: Ipv6Addr) -> bool {
    let words = ip.segments();
    let embedded = |high: u16, low: u16| {
        let ([a, b], [c, d]) = (high.to_be_bytes(), low.to_be_bytes());
        Ipv4Addr::new(a, b, c, d)
    };
    if let Some(v4) = ip.to_ipv4() {
        return is_public_v4(v4);
    }
    match words {
        // NAT64 (RFC 6052) and 6to4 (RFC 3056) hold an IPv4 address.
        [0x64, 0xff9b, 0, 0, 0, 0, high, low] => is_public_v4(embedded(high, low)),
        [0x2002, high, low, ..] => is_public_v4(embedded(high, low)),
        // Global unicast without documentation and Teredo.
        [first, second, ..] => first & 0xe000 == 0x2000 && !(first == 0x2001 && (second == 0xdb8 || second == 0)),
    }
}

/// Answer of a service.
#[derive(Debug, Clone)]
pub struct Answer {
    /// HTTP status.
    pub status: u16,
    /// To ask again with.
    pub etag: Option<String>,
    /// To ask again with.
    pub last_modified: Option<String>,
    /// How long it may be cached.
    pub freshness: Freshness,
    /// When to come back, where the service says so.
    pub retry_after: Option<Duration>,
    /// Bytes of the whole file, where a part of it was asked for and came.
    pub whole_bytes: Option<u64>,
    /// The body, unpacked.
    pub body: Bytes,
}

/// How long an answer is new, as its headers say (RFC 9111).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Freshness {
    /// May not be kept at all.
    pub no_store: bool,
    /// Fresh for this long; `None` where the answer does not say.
    pub lifetime: Option<Duration>,
}

impl Freshness {
    fn of(headers: &HeaderMap) -> Self {
        let text = |name: HeaderName| headers.get(name).and_then(|value| value.to_str().ok());
        let date = |name: HeaderName| text(name).and_then(|text| httpdate::parse_http_date(text).ok());
        let mut no_store = false;
        let mut lifetime = None;
        let directives = headers.get_all(header::CACHE_CONTROL).iter().filter_map(|value| value.to_str().ok());
        for directive in directives.flat_map(|value| value.split(',')).map(|d| d.trim().to_ascii_lowercase()) {
            if directive == "no-store" {
                no_store = true;
            } else if directive == "no-cache" {
                lifetime = Some(Duration::ZERO);
            } else if let Some(seconds) = directive.strip_prefix("max-age=")
                && lifetime.is_none()
            {
                lifetime = seconds.trim_matches('"').parse().ok().map(Duration::from_secs);
            }
        }
        if lifetime.is_none() && headers.contains_key(header::EXPIRES) {
            let from = date(header::DATE).unwrap_or_else(SystemTime::now);
            // An unreadable date, such as 0, is in the past.
            lifetime = Some(date(header::EXPIRES).and_then(|at| at.duration_since(from).ok()).unwrap_or_default());
        }
        let age = text(header::AGE).and_then(|age| age.trim().parse().ok()).map_or(Duration::ZERO, Duration::from_secs);
        Self { no_store, lifetime: lifetime.map(|lifetime| lifetime.saturating_sub(age)) }
    }
}

/// Why an address is not asked.
#[derive(Debug)]
struct Forbidden {
    /// Whether it may be asked for a source of the local network.
    is_permissible: bool,
    reason: String,
}

impl fmt::Display for Forbidden {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.reason)
    }
}

impl StdError for Forbidden {}

/// A host name that could not be resolved.
#[derive(Debug)]
struct NameUnknown(std::io::Error);

impl fmt::Display for NameUnknown {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.fmt(f)
    }
}

impl StdError for NameUnknown {}

fn forbidden(host: &str, ip: IpAddr) -> Forbidden {
    // Brackets of an address are of its URL.
    let bare = host.trim_matches(['[', ']']);
    let who = if bare == ip.to_string() { format!("{ip} is") } else { format!("{host} is {ip},") };
    let is_permissible = !is_never(ip);
    let reason = if !is_permissible {
        format!("{who} an address inside this network that is never asked for maps")
    } else {
        format!(
            "{who} an address inside this network, where this source is not configured to be; if the service is in your network, \
             say so: tick \"The service is in this local network\" in the source's settings, or set local_network = true in \
             sources.toml (on the command line: --local-network)"
        )
    };
    Forbidden { is_permissible, reason }
}

/// Resolves names to allowed addresses only, so that a name rebound to a private address fails.
struct Allowed {
    is_own: bool,
}

impl Resolve for Allowed {
    fn resolve(&self, name: Name) -> Resolving {
        let is_own = self.is_own;
        Box::pin(async move {
            let found = tokio::net::lookup_host((name.as_str(), 0)).await.map_err(NameUnknown)?;
            let found: Vec<SocketAddr> = found.collect();
            let allowed: Vec<_> = found.iter().copied().filter(|address| may_ask(address.ip(), is_own)).collect();
            match (allowed.is_empty(), found.first()) {
                (true, Some(private)) => Err(forbidden(name.as_str(), private.ip()).into()),
                _ => Ok(Box::new(allowed.into_iter()) as Addrs),
            }
        })
    }
}

/// Limits of concurrent fetches per host.
type Gate = (u8, Arc<Semaphore>);

/// Fetches; one for all sources.
#[derive(Clone)]
pub struct Fetcher {
    public: Client,
    local: Client,
    patience: Patience,
    /// By host: the limit of concurrent fetches and its semaphore.
    hosts: Arc<Mutex<HashMap<String, Gate>>>,
}

impl fmt::Debug for Fetcher {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Fetcher").field("patience", &self.patience).finish_non_exhaustive()
    }
}

impl Fetcher {
    /// A fetcher.
    ///
    /// # Errors
    /// [`MapError::Storage`] when this machine's certificates cannot be read.
    pub fn new(patience: Patience) -> Result<Self> {
        // Of all that TLS is linked with, only this provider is in the binary; being first or second is the same.
        let _ = rustls::crypto::ring::default_provider().install_default();
        let builder = || {
            Client::builder()
                .user_agent(USER_AGENT)
                .connect_timeout(patience.connect)
                .timeout(patience.whole)
                .redirect(redirect::Policy::none())
                .pool_idle_timeout(Duration::from_secs(60))
                .no_proxy()
        };
        let failed =
            |error: reqwest::Error| MapError::storage(format!("no connections can be made: {}", cause(&error)));
        Ok(Self {
            public: builder().dns_resolver(Arc::new(Allowed { is_own: false })).build().map_err(failed)?,
            local: builder().dns_resolver(Arc::new(Allowed { is_own: true })).build().map_err(failed)?,
            patience,
            hosts: Arc::default(),
        })
    }

    /// Fetches, following redirects.
    ///
    /// # Errors
    /// [`MapError::Service`], [`MapError::LocalAddress`], [`MapError::Timeout`], [`MapError::Offline`].
    pub async fn fetch(&self, request: &Request) -> Result<Answer> {
        let turn = self.turn(request).await?;
        self.fetch_in_turn(request, turn).await
    }

    /// Waits until a request may be sent to its host, of which few are at once.
    pub(crate) async fn turn(&self, request: &Request) -> Result<OwnedSemaphorePermit> {
        let host = request.url.host_str().unwrap_or_default().to_owned();
        let gate = {
            let mut hosts = self.hosts.lock().unwrap_or_else(PoisonError::into_inner);
            let parallel = request.parallel.max(1);
            let new = || (parallel, Arc::new(Semaphore::new(parallel.into())));
            let gate = hosts.entry(host).or_insert_with(new);
            if gate.0 != parallel {
                // The settings have changed; waiters at the old semaphore pass it as before.
                *gate = new();
            }
            gate.1.clone()
        };
        gate.acquire_owned().await.map_err(|_| MapError::Closed)
    }

    /// Fetches when it is its turn.
    pub(crate) async fn fetch_in_turn(&self, request: &Request, _turn: OwnedSemaphorePermit) -> Result<Answer> {
        let mut url = request.url.clone();
        for _ in 0..=MAX_REDIRECTS {
            let response = self.send(request, &url).await?;
            let status = response.status().as_u16();
            if !matches!(status, 301 | 302 | 303 | 307 | 308) {
                return self.read(request, &url, response).await;
            }
            let target = response.headers().get(header::LOCATION).and_then(|target| target.to_str().ok());
            let next = target.and_then(|target| url.join(target).ok());
            let next = next.ok_or_else(|| self.service(request, &url, "redirects to nowhere"))?;
            let is_downgrade = url.scheme() == "https" && next.scheme() != "https";
            if is_downgrade || !matches!(next.scheme(), "http" | "https") {
                return Err(self.service(
                    request,
                    &url,
                    &format!("redirects to {}, which is not followed", shown(&next)),
                ));
            }
            if let Some(reason) = request.stray_key(&next) {
                return Err(self.service(request, &next, &reason));
            }
            url = next;
        }
        Err(self.service(request, &url, "redirects without end"))
    }

    async fn send(&self, request: &Request, url: &Url) -> Result<reqwest::Response> {
        let host = url.host_str().unwrap_or_default();
        let is_own = request.local_host.as_deref() == Some(host);
        let literal = match url.host() {
            Some(Host::Ipv4(ip)) => Some(IpAddr::V4(ip)),
            Some(Host::Ipv6(ip)) => Some(IpAddr::V6(ip)),
            _ => None,
        };
        // Addresses written as numbers never pass the resolver.
        if let Some(ip) = literal.filter(|ip| !may_ask(*ip, is_own)) {
            return Err(not_asked(request, url, &forbidden(host, ip)));
        }
        let client = if is_own { &self.local } else { &self.public };
        let mut asked = match &request.json {
            Some(json) => client.post(url.clone()).header(header::CONTENT_TYPE, "application/json").body(json.clone()),
            None => client.get(url.clone()),
        };
        if let Some(range) = &request.range {
            // Packed, the bytes would be others.
            asked = asked
                .header(header::RANGE, format!("bytes={}-{}", range.start, range.end.saturating_sub(1)))
                .header(header::ACCEPT_ENCODING, "identity");
        }
        if let Some(etag) = &request.etag {
            asked = asked.header(header::IF_NONE_MATCH, etag);
        }
        if let Some(date) = &request.last_modified {
            asked = asked.header(header::IF_MODIFIED_SINCE, date);
        }
        let response = asked.send().await.map_err(|error| self.failed(request, url, &error))?;
        // Whatever was resolved, this is the connected address.
        if let Some(address) = response.remote_addr().filter(|address| !may_ask(address.ip(), is_own)) {
            return Err(not_asked(request, url, &forbidden(host, address.ip())));
        }
        Ok(response)
    }

    async fn read(&self, request: &Request, url: &Url, mut response: reqwest::Response) -> Result<Answer> {
        let headers = response.headers();
        let text = |name: HeaderName| headers.get(name).and_then(|value| value.to_str().ok()).map(str::to_owned);
        // Headers that are kept are bounded as well.
        let short = |name: HeaderName| text(name).filter(|text| text.len() <= 256);
        let mut answer = Answer {
            status: response.status().as_u16(),
            etag: short(header::ETAG),
            last_modified: short(header::LAST_MODIFIED),
            freshness: Freshness::of(headers),
            retry_after: text(header::RETRY_AFTER).and_then(|text| text.trim().parse().ok()).map(Duration::from_secs),
            whole_bytes: None,
            body: Bytes::new(),
        };
        if let Some(range) = &request.range {
            match answer.status {
                200 => {
                    return Err(self.service(
                        request,
                        url,
                        "answers with the whole file where a part was asked for (it knows no Range requests); download the file \
                         and add it as a file",
                    ));
                }
                206 => {
                    let said = text(header::CONTENT_RANGE);
                    let part = said.as_deref().and_then(content_range);
                    let is_asked_for = |(first, end, whole): &(u64, u64, u64)| {
                        *first == range.start && *end == range.end.min(*whole) && *first < *end
                    };
                    let Some((_, _, whole)) = part.filter(is_asked_for) else {
                        let said = said.unwrap_or_else(|| "no range".to_owned());
                        let reason = format!("answers with another part of the file than was asked for ({said})");
                        return Err(self.service(request, url, &reason));
                    };
                    answer.whole_bytes = Some(whole);
                }
                _ => {}
            }
        }
        let too_large = || self.service(request, url, &format!("answers with more than {} bytes", request.max_bytes));
        if response.content_length().is_some_and(|length| length > request.max_bytes as u64) {
            return Err(too_large());
        }
        let mut body = BytesMut::new();
        while let Some(part) = response.chunk().await.map_err(|error| self.failed(request, url, &error))? {
            if body.len() + part.len() > request.max_bytes {
                return Err(too_large());
            }
            body.extend_from_slice(&part);
        }
        let wanted =
            request.range.as_ref().zip(answer.whole_bytes).map(|(range, whole)| range.end.min(whole) - range.start);
        if wanted.is_some_and(|wanted| wanted != body.len() as u64) {
            return Err(self.service(request, url, "the answer was cut short"));
        }
        answer.body = body.freeze();
        Ok(answer)
    }

    fn service(&self, request: &Request, url: &Url, reason: &str) -> MapError {
        MapError::Service { host: shown(url), status: None, reason: hide(reason, request.secret.as_deref()) }
    }

    fn failed(&self, request: &Request, url: &Url, error: &reqwest::Error) -> MapError {
        let host = shown(url);
        if let Some(refusal) = find::<Forbidden>(error) {
            return not_asked(request, url, refusal);
        }
        if error.is_timeout() {
            return MapError::Timeout { host, seconds: self.patience.whole.as_secs().max(1) };
        }
        let reason = hide(&cause(error), request.secret.as_deref());
        if error.is_connect() {
            return MapError::Offline { host, why: unreached(error), reason, retry_s: 0 };
        }
        MapError::Service { host, status: None, reason: format!("the answer was cut short or is broken ({reason})") }
    }
}

fn not_asked(request: &Request, url: &Url, refusal: &Forbidden) -> MapError {
    MapError::LocalAddress {
        host: shown(url),
        is_permissible: refusal.is_permissible,
        reason: hide(&refusal.reason, request.secret.as_deref()),
    }
}

/// First byte, one beyond the last, and bytes of the whole, of a `Content-Range` (RFC 9110, section 14.4).
fn content_range(text: &str) -> Option<(u64, u64, u64)> {
    let (range, whole) = text.trim().strip_prefix("bytes")?.trim().split_once('/')?;
    let (first, last) = range.split_once('-')?;
    Some((first.trim().parse().ok()?, last.trim().parse::<u64>().ok()?.checked_add(1)?, whole.trim().parse().ok()?))
}

/// Host and port of an address: paths and queries may hold secrets.
pub fn shown(url: &Url) -> String {
    // `file:` and the like have no host.
    let Some(host) = url.host_str() else { return format!("{}:", url.scheme()) };
    url.port().map_or_else(|| host.to_owned(), |port| format!("{host}:{port}"))
}

/// A text without the user's key.
pub fn hide(text: &str, secret: Option<&str>) -> String {
    match secret {
        Some(secret) if !secret.is_empty() => text.replace(secret, "…").replace(&crate::address::escape(secret), "…"),
        _ => text.to_owned(),
    }
}

/// Text for a status of a service.
pub(crate) fn words(status: u16, body: &[u8]) -> String {
    #[derive(Deserialize)]
    struct Wrapped {
        error: Said,
    }
    #[derive(Deserialize)]
    struct Said {
        message: String,
    }
    let said = serde_json::from_slice::<Wrapped>(body).map(|wrapped| sniff::one_line(&wrapped.error.message, 300));
    let said = said.unwrap_or_else(|_| sniff::words(body));
    if said.is_empty() { format!("HTTP status {status}") } else { format!("HTTP status {status}: {said}") }
}

/// The error for a status other than 200.
pub(crate) fn refused(request: &Request, answer: &Answer) -> MapError {
    let words = words(answer.status, &answer.body);
    let help = match answer.status {
        401 | 403 => "; check the key, and whether the service may be used from here",
        429 => "; it takes no more for now",
        _ => "",
    };
    MapError::Service {
        host: shown(&request.url),
        status: Some(answer.status),
        reason: hide(&format!("answers with {words}{help}"), request.secret.as_deref()),
    }
}

/// Why no connection came about.
fn unreached(error: &(dyn StdError + 'static)) -> Unreached {
    if find::<NameUnknown>(error).is_some() {
        Unreached::NameUnknown
    } else if find::<std::io::Error>(error).is_some_and(|error| error.kind() == std::io::ErrorKind::ConnectionRefused) {
        Unreached::Refused
    } else {
        Unreached::NoConnection
    }
}

fn find<'a, E: StdError + 'static>(error: &'a (dyn StdError + 'static)) -> Option<&'a E> {
    let mut next = Some(error);
    while let Some(error) = next {
        if let Some(found) = error.downcast_ref::<E>() {
            return Some(found);
        }
        next = error.source();
    }
    None
}

/// The innermost error, which is the informative one.
fn cause(error: &(dyn StdError + 'static)) -> String {
    let mut last = error;
    while let Some(next) = last.source() {
        last = next;
    }
    last.to_string()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::settings::SourceKind;

    fn source(url: &str) -> SourceSettings {
        SourceSettings { url: Some(url.to_owned()), ..SourceSettings::new("a", "A", SourceKind::Xyz) }
    }

    #[test]
    fn why_no_connection_came_about_is_told_apart() {
        use std::io::{Error, ErrorKind};
        #[derive(Debug, thiserror::Error)]
        #[error("not connected")]
        struct Outer(#[source] Box<dyn StdError>);
        let inside = |error: Box<dyn StdError>| unreached(&Outer(error));
        assert_eq!(inside(Box::new(NameUnknown(Error::other("no such name")))), Unreached::NameUnknown);
        assert_eq!(inside(Box::new(Error::from(ErrorKind::ConnectionRefused))), Unreached::Refused);
        assert_eq!(inside(Box::new(Error::from(ErrorKind::NetworkUnreachable))), Unreached::NoConnection);
    }

    #[test]
    fn addresses_are_public_or_not() {
        for (ip, public) in [
            ("8.8.8.8", true),
            ("2a00:1450:4003:80f::200e", true),
            ("127.0.0.1", false),
            ("10.1.2.3", false),
            ("172.31.0.1", false),
            ("192.168.1.1", false),
            ("169.254.169.254", false),
            ("100.64.0.1", false),
            ("0.0.0.0", false),
            ("224.0.0.1", false),
            ("255.255.255.255", false),
            ("::1", false),
            ("::", false),
            ("::ffff:127.0.0.1", false),
            ("::ffff:8.8.8.8", true),
            ("fe80::1", false),
            ("fd00::1", false),
            ("64:ff9b::7f00:1", false),
            ("2002:7f00:1::", false),
            ("ff02::1", false),
        ] {
            assert_eq!(is_public(ip.parse().expect("an address")), public, "{ip}");
        }
    }

    #[test]
    fn only_where_a_source_says_so_it_is_local() {
        for (url, host) in [
            ("http://127.0.0.1:8000/{z}/{x}/{y}", "127.0.0.1"),
            ("http://[::1]/{z}/{x}/{y}", "[::1]"),
            ("http://nas/{z}/{x}/{y}", "nas"),
            ("https://maps.example/{z}/{x}/{y}", "maps.example"),
        ] {
            let mut named = source(url);
            assert_eq!(local_host(&named), None, "{url}");
            named.local_network = true;
            assert_eq!(local_host(&named).as_deref(), Some(host), "{url}");
        }
    }

    // fault 48: link-local and metadata addresses: never; private ones only where a person says so
    #[test]
    fn some_addresses_are_never_asked() {
        for (ip, own) in [
            ("192.168.1.10", true),
            ("10.1.2.3", true),
            ("127.0.0.1", true),
            ("100.64.0.1", true),
            ("::1", true),
            ("fd12:3456::1", true),
            ("::ffff:192.168.1.10", true),
            ("169.254.169.254", false),
            ("::ffff:169.254.169.254", false),
            ("64:ff9b::a9fe:a9fe", false),
            ("2002:a9fe:a9fe::1", false),
            ("fe80::1", false),
            ("fd00:ec2::254", false),
            ("100.100.100.200", false),
            ("0.0.0.0", false),
            ("::", false),
            ("255.255.255.255", false),
            ("224.0.0.251", false),
            ("ff02::fb", false),
        ] {
            let address = ip.parse().expect("an address");
            assert!(!may_ask(address, false), "{ip}");
            assert_eq!(may_ask(address, true), own, "{ip}");
            assert_eq!(forbidden("x", address).to_string().contains("local_network = true"), own, "{ip}");
        }
        assert!(may_ask("8.8.8.8".parse().expect("an address"), false));
    }

    #[test]
    fn a_key_goes_to_its_own_hosts_alone() {
        let mut named = source("https://{s}.tiles.example/{z}/{x}/{y}?key={key}");
        named.subdomains = vec!["a".into(), "b".into()];
        named.key = Some("s3cret key".into());
        let ask = |settings: &SourceSettings, url: &str| Request::new(settings, url, 1).map(drop);
        for url in ["https://a.tiles.example/1?key=s3cret%20key", "https://other.example/without"] {
            assert!(ask(&named, url).is_ok(), "{url}");
        }
        for url in ["https://evil.example/?key=s3cret%20key", "https://c.tiles.example/?key=s3cret%20key"] {
            let error = ask(&named, url).expect_err("another host").to_string();
            assert!(error.contains("nothing was sent") && !error.contains("s3cret"), "{error}");
        }
        // The service's redirect is not the user's address.
        let request = Request::new(&named, "https://b.tiles.example/1?key=s3cret%20key", 1).expect("its own");
        let target = request.url.join("https://evil.example/?key=s3cret%20key").expect("an address");
        assert!(request.stray_key(&target).is_some());
        let google = SourceSettings { key: Some("s3cret".into()), ..SourceSettings::new("g", "G", SourceKind::Google) };
        assert!(ask(&google, "https://tile.googleapis.com/v1/createSession?key=s3cret").is_ok());
        assert!(ask(&google, "https://evil.example/v1/createSession?key=s3cret").is_err());
    }

    #[test]
    fn freshness_follows_the_headers() {
        let of = |pairs: &[(HeaderName, &str)]| {
            Freshness::of(&pairs.iter().map(|(name, value)| (name.clone(), value.parse().expect("a value"))).collect())
        };
        let seconds = |s| Some(Duration::from_secs(s));
        assert_eq!(of(&[]), Freshness::default());
        assert_eq!(of(&[(header::CACHE_CONTROL, "public, max-age=60"), (header::AGE, "10")]).lifetime, seconds(50));
        assert_eq!(of(&[(header::CACHE_CONTROL, "no-cache, max-age=60")]).lifetime, seconds(0));
        assert!(of(&[(header::CACHE_CONTROL, "no-store")]).no_store);
        let dated =
            [(header::DATE, "Sun, 06 Nov 1994 08:49:37 GMT"), (header::EXPIRES, "Sun, 06 Nov 1994 08:50:37 GMT")];
        assert_eq!(of(&dated).lifetime, seconds(60));
        assert_eq!(of(&[(header::EXPIRES, "0")]).lifetime, seconds(0));
    }

    #[test]
    fn a_key_is_never_told() {
        assert_eq!(hide("http://a/?key=s3 cret and s3%20cret", Some("s3 cret")), "http://a/?key=… and …");
        assert_eq!(hide("nothing", Some("")), "nothing");
    }
}
