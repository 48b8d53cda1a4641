//! Files of the web app, embedded in the binary: with their media types, long caching of files whose names carry a
//! hash, compressed by the build, and the app's page for each of its own paths.

use axum::http::{HeaderMap, HeaderValue, Method, StatusCode, Uri, header};
use axum::response::{Html, IntoResponse, Response};

use crate::dto::cause::{Cause, ResourceKind};
use crate::problem::Problem;

/// Page shown when the app is not in this build.
const NO_APP: &str = "<!doctype html><html lang=\"en\"><meta charset=\"utf-8\"><title>Vencejo</title>\
    <h1>The ground station's pages are not in this build</h1>\
    <p>The server works: its API is described at <a href=\"/api/v1/openapi.json\">/api/v1/openapi.json</a>.</p>\
    <p>To have the pages, build them (<code>npm ci &amp;&amp; npm run build</code> in <code>gcs/</code>) and then the \
    package, or install a released package.</p></html>";

/// Extension of the compressed variant of a file (gcs/scripts/pack.mjs).
const PACKED: &str = ".gz";

/// A file of the app.
struct File {
    bytes: std::borrow::Cow<'static, [u8]>,
    hash: [u8; 32],
}

#[cfg(feature = "app")]
fn find(path: &str) -> Option<File> {
    /// Empty when the app was not built before the binary.
    #[derive(rust_embed::RustEmbed)]
    #[folder = "../../gcs/dist"]
    #[allow_missing = true]
    struct Dist;

    let file = Dist::get(path)?;
    Some(File { hash: file.metadata.sha256_hash(), bytes: file.data })
}

#[cfg(not(feature = "app"))]
fn find(_path: &str) -> Option<File> {
    None
}

/// Whether this build contains the web app.
pub fn has_app() -> bool {
    find("index.html").is_some()
}

/// Serves every path outside of the API.
pub async fn serve(method: Method, uri: Uri, headers: HeaderMap) -> Response {
    if method != Method::GET && method != Method::HEAD {
        let detail = "the app's pages support GET only";
        return ([(header::ALLOW, "GET, HEAD")], Problem::new(Cause::Method, detail)).into_response();
    }
    answer(uri.path(), &headers, find)
}

fn answer(path: &str, headers: &HeaderMap, find: impl Fn(&str) -> Option<File>) -> Response {
    let name = path.trim_start_matches('/');
    let is_file = name.rsplit('/').next().is_some_and(|last| last.contains('.'));
    let (name, file) = match find(name) {
        Some(file) if !name.is_empty() => (name, Some(file)),
        // A path of the app, which does its own routing.
        _ if !is_file => ("index.html", find("index.html")),
        _ => return Problem::not_found(ResourceKind::File, path, "there is no such file").into_response(),
    };
    let Some(file) = file else {
        return (StatusCode::SERVICE_UNAVAILABLE, [(header::CACHE_CONTROL, "no-store")], Html(NO_APP)).into_response();
    };
    let packed = is_gzip_accepted(headers).then(|| find(&format!("{name}{PACKED}"))).flatten();
    let tag: String = file.hash.iter().take(16).map(|byte| format!("{byte:02x}")).collect();
    let tag = format!("\"{tag}\"");
    let caching = if name.starts_with("assets/") { "public, max-age=31536000, immutable" } else { "no-cache" };
    let has_it = headers.get(header::IF_NONE_MATCH).and_then(|tags| tags.to_str().ok());
    // The tag of a compressed answer comes back as a weak one.
    let has_it = has_it.is_some_and(|tags| tags.split(',').any(|known| known.trim().trim_start_matches("W/") == tag));
    let headers = [
        (header::CONTENT_TYPE, HeaderValue::from_static(mime(name))),
        (header::CACHE_CONTROL, HeaderValue::from_static(caching)),
        (header::ETAG, HeaderValue::from_str(&tag).expect("invariant: hexadecimal digits are a header")),
    ];
    if has_it {
        return (StatusCode::NOT_MODIFIED, headers).into_response();
    }
    let Some(packed) = packed else { return (headers, file.bytes.into_owned()).into_response() };
    let [kind, caching, _] = headers;
    let headers = [
        kind,
        caching,
        (header::ETAG, HeaderValue::from_str(&format!("W/{tag}")).expect("invariant: hexadecimal digits are a header")),
        (header::CONTENT_ENCODING, HeaderValue::from_static("gzip")),
        (header::VARY, HeaderValue::from_static("accept-encoding")),
    ];
    (headers, packed.bytes.into_owned()).into_response()
}

/// Whether a client accepts gzip (RFC 9110, 12.5.3) by name; with `*` alone it gets the uncompressed file.
fn is_gzip_accepted(headers: &HeaderMap) -> bool {
    let codings = headers.get_all(header::ACCEPT_ENCODING).iter().filter_map(|value| value.to_str().ok());
    codings.flat_map(|codings| codings.split(',')).any(|coding| {
        let (name, weight) = coding.split_once(';').unwrap_or((coding, ""));
        let is_refused = weight.trim().strip_prefix("q=").is_some_and(|q| q.trim().parse() == Ok(0.0));
        name.trim().eq_ignore_ascii_case("gzip") && !is_refused
    })
}

/// Media type of a file by its name. With `nosniff`, browsers do not run files of unknown types.
fn mime(name: &str) -> &'static str {
    match name.rsplit('.').next().unwrap_or_default() {
        "html" => "text/html; charset=utf-8",
        "js" | "mjs" => "text/javascript; charset=utf-8",
        "css" => "text/css; charset=utf-8",
        "json" | "map" | "geojson" => "application/json",
        "webmanifest" => "application/manifest+json",
        "svg" => "image/svg+xml",
        "png" => "image/png",
        "jpg" | "jpeg" => "image/jpeg",
        "webp" => "image/webp",
        "ico" => "image/x-icon",
        "woff2" => "font/woff2",
        "wasm" => "application/wasm",
        "txt" => "text/plain; charset=utf-8",
        _ => "application/octet-stream",
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn app(path: &str) -> Option<File> {
        let text = match path {
            "index.html" => "page",
            "assets/index-abc123.js" => "code",
            "assets/index-abc123.js.gz" => "packed code",
            "favicon.svg" => "picture",
            _ => return None,
        };
        Some(File { bytes: text.as_bytes().into(), hash: [7; 32] })
    }

    fn get(path: &str) -> (u16, String, String) {
        let response = answer(path, &HeaderMap::new(), app);
        let header = |name| response.headers().get(name).map_or("", |value| value.to_str().expect("text")).to_owned();
        (response.status().as_u16(), header(header::CONTENT_TYPE), header(header::CACHE_CONTROL))
    }

    #[test]
    fn files_have_their_type_and_only_hashed_ones_are_kept() {
        let own = |text: &str| text.to_owned();
        let page = (200, own("text/html; charset=utf-8"), own("no-cache"));
        assert_eq!(get("/"), page);
        assert_eq!(get("/index.html"), page);
        assert_eq!(get("/plan/3"), page, "a path of the app is its page");
        let immutable = own("public, max-age=31536000, immutable");
        assert_eq!(get("/assets/index-abc123.js"), (200, own("text/javascript; charset=utf-8"), immutable));
        assert_eq!(get("/favicon.svg"), (200, own("image/svg+xml"), own("no-cache")));
        for path in ["/assets/gone.js", "/../Cargo.toml", "/..%2fCargo.toml"] {
            assert_eq!(get(path).0, 404, "{path}");
        }
    }

    #[test]
    fn what_the_build_packed_is_sent_so_to_whom_takes_it() {
        let get = |accepted: &'static str, path| {
            let headers = HeaderMap::from_iter([(header::ACCEPT_ENCODING, HeaderValue::from_static(accepted))]);
            let answer = answer(path, &headers, app);
            let header = |name| answer.headers().get(name).map(|value| value.to_str().expect("text").to_owned());
            (header(header::CONTENT_TYPE), header(header::CONTENT_ENCODING), header(header::VARY), header(header::ETAG))
        };
        let own = |text: &str| Some(text.to_owned());
        let (code, plain) = (own("text/javascript; charset=utf-8"), own("\"07070707070707070707070707070707\""));
        let weak = own("W/\"07070707070707070707070707070707\"");
        for accepted in ["gzip", "br, GZIP;q=0.5", "deflate,gzip ; q=1.0"] {
            let packed = (code.clone(), own("gzip"), own("accept-encoding"), weak.clone());
            assert_eq!(get(accepted, "/assets/index-abc123.js"), packed, "{accepted}");
        }
        for accepted in ["", "br", "gzip;q=0", "gzip; q=0.000", "*"] {
            assert_eq!(
                get(accepted, "/assets/index-abc123.js"),
                (code.clone(), None, None, plain.clone()),
                "{accepted}"
            );
        }
        assert_eq!(get("gzip", "/favicon.svg").1, None, "too small to be packed");
    }

    #[test]
    fn what_the_browser_has_is_not_sent_again() {
        let mut headers = HeaderMap::new();
        let tag = answer("/", &headers, app).headers()[header::ETAG].clone();
        headers.insert(header::IF_NONE_MATCH, tag);
        assert_eq!(answer("/", &headers, app).status(), StatusCode::NOT_MODIFIED);
    }

    #[test]
    fn without_the_app_a_page_says_so() {
        let response = answer("/", &HeaderMap::new(), |_| None);
        assert_eq!(response.status(), StatusCode::SERVICE_UNAVAILABLE);
        assert!(NO_APP.contains("npm run build"));
    }
}
