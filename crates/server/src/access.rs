//! Access control by origin: checks of `Host` and `Origin`, and session cookies.

use std::net::{IpAddr, Ipv6Addr, SocketAddr};

use axum::http::uri::Authority;
use axum::http::{HeaderMap, HeaderValue, Uri, header};

use crate::dto::Cause;
use crate::problem::Problem;
use crate::tokens::TokenStore;

/// Access rules of the server.
#[derive(Debug, Clone)]
pub struct Access {
    /// `None`: every client on this machine is an operator.
    pub tokens: Option<TokenStore>,
    /// Listening address.
    pub bound: SocketAddr,
    /// Whether TLS is used.
    pub is_tls: bool,
    /// Host names accepted in `Host`, in addition to IP addresses and `localhost`.
    pub hosts: Vec<String>,
    /// Other origins that may use the API, such as a development server's.
    pub origins: Vec<String>,
}

impl Access {
    /// Whether `Host` names this server. IP addresses cannot be rebound through DNS, so only names must be listed.
    fn is_our_host(&self, authority: &str) -> bool {
        let Some(host) = host_of(authority) else { return false };
        if let Ok(address) = host.trim_start_matches('[').trim_end_matches(']').parse::<IpAddr>() {
            return address.is_loopback() || !self.bound.ip().is_loopback();
        }
        let host = host.trim_end_matches('.');
        host.eq_ignore_ascii_case("localhost") || self.hosts.iter().any(|ours| ours.eq_ignore_ascii_case(host))
    }

    /// Whether a page from `origin` may use the API as reached at `authority`.
    fn is_our_origin(&self, origin: &str, authority: &str) -> bool {
        let scheme = if self.is_tls { "https://" } else { "http://" };
        let is_same = origin.strip_prefix(scheme).is_some_and(|host| host.eq_ignore_ascii_case(authority));
        is_same || self.origins.iter().any(|ours| ours.eq_ignore_ascii_case(origin))
    }

    /// Checks where a request comes from.
    ///
    /// # Errors
    /// [`Cause::Host`] and [`Cause::Origin`].
    pub fn check(&self, uri: &Uri, headers: &HeaderMap) -> Result<(), Problem> {
        // HTTP/1.1 sends the host in a header, HTTP/2 in the URI; a request with both must have the same in both.
        let said = headers.get_all(header::HOST).iter().map(|host| host.to_str().unwrap_or_default());
        let mut said = said.chain(uri.authority().map(Authority::as_str));
        let authority = match said.next() {
            Some(authority) if said.all(|other| other == authority) => authority,
            _ => {
                let cause = Cause::Host { host: None };
                return Err(Problem::new(cause, "the request needs exactly one valid `Host`"));
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

    /// Name of the session cookie, with the port, since cookies are shared by all ports of a host.
    pub fn cookie_name(&self) -> String {
        format!("vencejo_session_{}", self.bound.port())
    }

    /// Session secret in the cookies of a request.
    pub fn cookie<'a>(&self, headers: &'a HeaderMap) -> Option<&'a str> {
        let name = self.cookie_name();
        let cookies = headers.get_all(header::COOKIE).iter().filter_map(|value| value.to_str().ok());
        let mut pairs =
            cookies.flat_map(|cookies| cookies.split(';')).filter_map(|cookie| cookie.trim().split_once('='));
        pairs.find(|(key, _)| *key == name).map(|(_, value)| value)
    }

    /// Header that sets the session cookie; an empty secret removes it.
    pub fn set_cookie(&self, secret: &str) -> HeaderValue {
        let secure = if self.is_tls { "; Secure" } else { "" };
        let age = if secret.is_empty() { "; Max-Age=0" } else { "" };
        let cookie = format!("{}={secret}; Path=/; HttpOnly; SameSite=Strict{secure}{age}", self.cookie_name());
        HeaderValue::from_str(&cookie).expect("invariant: a cookie of hexadecimal digits is a header")
    }
}

/// Whether this can be the `Origin` of a page: `scheme://host[:port]`, without a path.
pub(crate) fn is_origin(text: &str) -> bool {
    let is_scheme =
        |scheme: &str| !scheme.is_empty() && scheme.bytes().all(|byte| byte.is_ascii_alphanumeric() || byte == b'-');
    text.split_once("://")
        .is_some_and(|(scheme, authority)| is_scheme(scheme) && host_of(authority).is_some_and(is_host))
}

/// Whether this can be the host of an address: a name or an IP address, without a port.
pub(crate) fn is_host(text: &str) -> bool {
    let is_ipv6 = text
        .strip_prefix('[')
        .and_then(|text| text.strip_suffix(']'))
        .is_some_and(|text| text.parse::<Ipv6Addr>().is_ok());
    is_ipv6 || !text.is_empty() && text.bytes().all(|byte| byte.is_ascii_alphanumeric() || b"-_.".contains(&byte))
}

/// Host part of `host:port`, `[v6]:port` or `host`.
fn host_of(authority: &str) -> Option<&str> {
    let (host, port) = match authority.rsplit_once(':') {
        Some((host, port)) if !port.contains(']') => (host, port),
        _ => (authority, "0"),
    };
    let is_clean = !host.is_empty() && (host.starts_with('[') == host.ends_with(']'));
    (is_clean && (host.starts_with('[') || !host.contains(':')) && port.parse::<u16>().is_ok()).then_some(host)
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

    // fault 42: other names, names that begin with ours, addresses of other machines: refused
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
    fn what_no_page_and_no_machine_can_have_is_neither_an_origin_nor_a_host() {
        for origin in ["http://localhost:5173", "https://a.example", "http://[::1]:80", "chrome-extension://abc"] {
            assert!(is_origin(origin), "{origin}");
        }
        for origin in ["*", "evil", "null", "", "http://", "://a", "http://*", "http://a/", "http://a:x", "http://u@a"]
        {
            assert!(!is_origin(origin), "{origin}");
        }
        for (host, is_one) in
            [("plane.local", true), ("my_pc", true), ("", false), ("*", false), ("a:80", false), ("http://a", false)]
        {
            assert_eq!(is_host(host), is_one, "{host}");
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
