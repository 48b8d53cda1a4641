//! Who may talk to the server: `Host` and `Origin` checks, cookies, and the headers that keep a page to itself.

use std::io;
use std::net::{IpAddr, SocketAddr};

use axum::extract::{ConnectInfo, Request, State};
use axum::http::uri::Authority;
use axum::http::{HeaderMap, HeaderName, HeaderValue, StatusCode, Uri, header};
use axum::middleware::Next;
use axum::response::{IntoResponse, Response};

use crate::door::Caller;
use crate::dto::Cause;
use crate::problem::Problem;
use crate::state::App;
use crate::tokens::TokenStore;

/// Random bytes of a token or session secret: 128 bits.
const SECRET_BYTES: usize = 16;

/// What the page may load. Map tiles are pictures from any server by https; nothing else comes from elsewhere.
const CONTENT_SECURITY_POLICY: &str = "default-src 'self'; img-src 'self' data: blob: https:; connect-src 'self'; \
    style-src 'self'; style-src-attr 'unsafe-inline'; worker-src 'self' blob:; object-src 'none'; base-uri 'none'; \
    form-action 'self'; frame-ancestors 'none'";

/// Headers of every answer.
const HEADERS: [(HeaderName, &str); 7] = [
    (header::CONTENT_SECURITY_POLICY, CONTENT_SECURITY_POLICY),
    (header::X_CONTENT_TYPE_OPTIONS, "nosniff"),
    (header::X_FRAME_OPTIONS, "DENY"),
    // Tile servers want to know who asks; they learn the address, never the path.
    (header::REFERRER_POLICY, "strict-origin-when-cross-origin"),
    (HeaderName::from_static("cross-origin-opener-policy"), "same-origin"),
    (HeaderName::from_static("cross-origin-resource-policy"), "same-origin"),
    (HeaderName::from_static("permissions-policy"), "camera=(), microphone=(), geolocation=(self)"),
];

/// A random secret in hexadecimal digits.
///
/// # Errors
/// When the system has no random numbers.
pub fn random_secret() -> io::Result<String> {
    let mut bytes = [0_u8; SECRET_BYTES];
    getrandom::fill(&mut bytes).map_err(|error| io::Error::other(error.to_string()))?;
    Ok(bytes.iter().map(|byte| format!("{byte:02x}")).collect())
}

/// Whether two texts are the same, in a time that does not depend on where they differ.
pub fn same(left: &str, right: &str) -> bool {
    let (left, right) = (left.as_bytes(), right.as_bytes());
    left.len() == right.len() && left.iter().zip(right).fold(0, |sum, (a, b)| sum | (a ^ b)) == 0
}

/// Who may talk to the server, and from where.
#[derive(Debug, Clone)]
pub struct Access {
    /// `None`: everybody on this machine is an operator.
    pub tokens: Option<TokenStore>,
    /// Where the server listens.
    pub bound: SocketAddr,
    /// Whether it speaks TLS.
    pub is_tls: bool,
    /// Names of this machine that `Host` may say, beside addresses and `localhost`.
    pub hosts: Vec<String>,
    /// Other origins that may use the API, such as a development server's.
    pub origins: Vec<String>,
}

impl Access {
    /// Whether `Host` names us. Addresses cannot be rebound by anybody's name server, so only names are listed.
    fn is_our_host(&self, authority: &str) -> bool {
        let Some(host) = host_of(authority) else { return false };
        if let Ok(address) = host.trim_start_matches('[').trim_end_matches(']').parse::<IpAddr>() {
            return address.is_loopback() || !self.bound.ip().is_loopback();
        }
        let host = host.trim_end_matches('.');
        host.eq_ignore_ascii_case("localhost") || self.hosts.iter().any(|ours| ours.eq_ignore_ascii_case(host))
    }

    /// Whether a page of `origin` may use the API as reached at `authority`.
    fn is_our_origin(&self, origin: &str, authority: &str) -> bool {
        let scheme = if self.is_tls { "https://" } else { "http://" };
        let is_same = origin.strip_prefix(scheme).is_some_and(|host| host.eq_ignore_ascii_case(authority));
        is_same || self.origins.iter().any(|ours| ours.eq_ignore_ascii_case(origin))
    }

    /// What is wrong with where a request comes from, if anything.
    pub fn check(&self, uri: &Uri, headers: &HeaderMap) -> Result<(), Problem> {
        // HTTP/1.1 says it in a header, HTTP/2 in the address; whoever says both says the same.
        let said = headers.get_all(header::HOST).iter().map(|host| host.to_str().unwrap_or_default());
        let mut said = said.chain(uri.authority().map(Authority::as_str));
        let authority = match said.next() {
            Some(authority) if said.all(|other| other == authority) => authority,
            _ => {
                let cause = Cause::Host { host: None };
                return Err(Problem::new(cause, "the request has no single `Host` that can be read"));
            }
        };
        if !self.is_our_host(authority) {
            let detail = format!("`Host` is {authority:?}, which is not a name of this server");
            let cause = Cause::Host { host: Some(authority.to_owned()) };
            return Err(Problem::new(cause, detail).remedy("use its address, or start it with --allow-host NAME"));
        }
        let origin = headers.get(header::ORIGIN);
        if let Some(origin) = origin
            && !origin.to_str().is_ok_and(|origin| self.is_our_origin(origin, authority))
        {
            let detail = format!("`Origin` is {origin:?}, and only this server's own pages may use it");
            let cause = Cause::Origin { origin: String::from_utf8_lossy(origin.as_bytes()).into_owned() };
            return Err(Problem::new(cause, detail).remedy("open the address that the server shows in its terminal"));
        }
        Ok(())
    }

    /// Name of the session's cookie. Cookies do not know ports, and there may be a server on another one.
    pub fn cookie_name(&self) -> String {
        format!("vencejo_session_{}", self.bound.port())
    }

    /// The session's secret in a request's cookies.
    pub fn cookie<'a>(&self, headers: &'a HeaderMap) -> Option<&'a str> {
        let name = self.cookie_name();
        let cookies = headers.get_all(header::COOKIE).iter().filter_map(|value| value.to_str().ok());
        let mut pairs =
            cookies.flat_map(|cookies| cookies.split(';')).filter_map(|cookie| cookie.trim().split_once('='));
        pairs.find(|(key, _)| *key == name).map(|(_, value)| value)
    }

    /// The header that gives a browser its session; an empty secret takes it away.
    pub fn set_cookie(&self, secret: &str) -> HeaderValue {
        let secure = if self.is_tls { "; Secure" } else { "" };
        let age = if secret.is_empty() { "; Max-Age=0" } else { "" };
        let cookie = format!("{}={secret}; Path=/; HttpOnly; SameSite=Strict{secure}{age}", self.cookie_name());
        HeaderValue::from_str(&cookie).expect("invariant: a cookie of hexadecimal digits is a header")
    }
}

/// The host of `host:port`, `[v6]:port` or `host`.
fn host_of(authority: &str) -> Option<&str> {
    let (host, port) = match authority.rsplit_once(':') {
        Some((host, port)) if !port.contains(']') => (host, port),
        _ => (authority, "0"),
    };
    let is_clean = !host.is_empty() && (host.starts_with('[') == host.ends_with(']'));
    (is_clean && (host.starts_with('[') || !host.contains(':')) && port.parse::<u16>().is_ok()).then_some(host)
}

/// Checks where each request comes from, and puts the headers on each answer.
pub async fn guard(State(app): State<App>, request: Request, next: Next) -> Response {
    let is_api = request.uri().path().starts_with("/api/");
    let mut answering = None;
    if let Some(ConnectInfo(Caller { connection, .. })) = request.extensions().get() {
        answering = connection.asked();
        if answering.is_none() {
            return StatusCode::SERVICE_UNAVAILABLE.into_response();
        }
        if !connection.has_session()
            && app.access().cookie(request.headers()).is_some_and(|it| app.sessions().knows(it))
        {
            connection.showed_session();
        }
    }
    let mut response = match app.access().check(request.uri(), request.headers()) {
        Ok(()) => next.run(request).await,
        Err(problem) => problem.into_response(),
    };
    let headers = response.headers_mut();
    for (name, value) in HEADERS {
        headers.insert(name, HeaderValue::from_static(value));
    }
    // Pictures say themselves how long they hold.
    if is_api && !headers.contains_key(header::CACHE_CONTROL) {
        headers.insert(header::CACHE_CONTROL, HeaderValue::from_static("no-store"));
    }
    if app.access().is_tls {
        headers.insert(header::STRICT_TRANSPORT_SECURITY, HeaderValue::from_static("max-age=31536000"));
    }
    match answering {
        Some(answering) => answering.until_sent(response),
        None => response,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn access(bound: &str) -> Access {
        Access {
            tokens: None,
            bound: bound.parse().expect("an address"),
            is_tls: false,
            hosts: vec!["plane.local".into()],
            origins: vec!["http://localhost:5173".into()],
        }
    }

    fn check(bound: &str, host: &str, origin: Option<&str>) -> Option<String> {
        let mut headers = HeaderMap::new();
        headers.insert(header::HOST, HeaderValue::from_str(host).expect("a header"));
        if let Some(origin) = origin {
            headers.insert(header::ORIGIN, HeaderValue::from_str(origin).expect("a header"));
        }
        access(bound).check(&Uri::from_static("/"), &headers).err().map(|problem| problem.0.r#type)
    }

    // fault 42: other names, names that begin with ours, addresses that are not this machine's: refused
    #[test]
    fn hosts_are_addresses_or_listed_names() {
        const LOOPBACK: &str = "127.0.0.1:8765";
        const ANY: &str = "0.0.0.0:8765";
        for (bound, host, is_ours) in [
            (LOOPBACK, "127.0.0.1:8765", true),
            (LOOPBACK, "localhost:9000", true),
            (LOOPBACK, "LOCALHOST", true),
            (LOOPBACK, "localhost.", true),
            (LOOPBACK, "[::1]:8765", true),
            (LOOPBACK, "plane.local:8765", true),
            (LOOPBACK, "192.168.1.5:8765", false),
            (LOOPBACK, "evil.example:8765", false),
            (LOOPBACK, "localhost.evil.example", false),
            (LOOPBACK, "127.0.0.1.evil.example", false),
            (LOOPBACK, "localhost:x", false),
            (LOOPBACK, "", false),
            (LOOPBACK, "[::1", false),
            (LOOPBACK, "user@localhost", false),
            (ANY, "192.168.1.5:8765", true),
            (ANY, "[fe80::1]:8765", true),
            (ANY, "evil.example", false),
        ] {
            assert_eq!(check(bound, host, None).is_none(), is_ours, "{host} at {bound}");
        }
    }

    #[test]
    fn origins_are_our_own_or_listed() {
        for (origin, is_ours) in [
            ("http://127.0.0.1:8765", true),
            ("http://localhost:5173", true),
            ("https://127.0.0.1:8765", false),
            ("http://127.0.0.1:8766", false),
            ("http://localhost:8765", false),
            ("http://evil.example", false),
            ("null", false),
            ("", false),
        ] {
            let found = check("127.0.0.1:8765", "127.0.0.1:8765", Some(origin));
            assert_eq!(found.is_none(), is_ours, "{origin}");
        }
    }

    #[test]
    fn a_request_says_one_host_where_its_version_says_it() {
        let access = access("127.0.0.1:1");
        let mut headers = HeaderMap::new();
        let (path, whole) = (Uri::from_static("/"), Uri::from_static("https://localhost/"));
        assert!(access.check(&path, &headers).is_err(), "none");
        assert!(access.check(&whole, &headers).is_ok(), "as in HTTP/2");
        assert!(access.check(&Uri::from_static("https://evil.example/"), &headers).is_err());
        headers.append(header::HOST, HeaderValue::from_static("localhost"));
        assert!(access.check(&whole, &headers).is_ok());
        assert!(access.check(&Uri::from_static("http://127.0.0.1/"), &headers).is_err(), "two that differ");
        headers.append(header::HOST, HeaderValue::from_static("evil.example"));
        assert!(access.check(&path, &headers).is_err());
    }

    #[test]
    fn a_cookie_is_found_among_others() {
        let access = access("127.0.0.1:8765");
        let mut headers = HeaderMap::new();
        headers.insert(header::COOKIE, HeaderValue::from_static("a=b; vencejo_session_8765=s3; vencejo_session_1=x"));
        assert_eq!(access.cookie(&headers), Some("s3"));
        let set = access.set_cookie("s3");
        assert_eq!(set, "vencejo_session_8765=s3; Path=/; HttpOnly; SameSite=Strict");
    }
}
