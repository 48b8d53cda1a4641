//! The maps against services that behave and that do not, over real sockets on this machine, under a clock that the
//! test moves.

mod cog;
mod disk;
mod heights;
mod misbehaving;

use std::collections::BTreeMap;
use std::net::SocketAddr;
use std::path::PathBuf;
use std::sync::atomic::{AtomicI64, AtomicU64, AtomicUsize, Ordering};
use std::sync::{Arc, Mutex};
use std::time::Duration;

use tokio::io::{AsyncReadExt, AsyncWriteExt};
use tokio::net::{TcpListener, TcpStream};
use tokio::sync::Notify;
use tokio::task::JoinHandle;
use vencejo_maps::cover::Shape;
use vencejo_maps::geo::{Bounds, Corner};
use vencejo_maps::grid::TileId;
use vencejo_maps::net::Patience;
use vencejo_maps::raster::Raster;
use vencejo_maps::settings::{Caching, Encoding, Role, SourceKind, SourceSettings};
use vencejo_maps::{AreaState, MapError, Maps, MapsConfig, NewArea, Origin, SourceCause, Status, Unreached};

/// A hang is a failure.
const LIMIT: Duration = Duration::from_secs(30);
const TILE: TileId = TileId { level: 3, column: 4, row: 2 };

fn png() -> Vec<u8> {
    Raster::filled(256, 256, [1, 2, 3, 255]).to_png()
}

fn answer(status: &str, headers: &str, body: &[u8]) -> Vec<u8> {
    let head = format!("HTTP/1.1 {status}\r\n{headers}Content-Length: {}\r\nConnection: close\r\n\r\n", body.len());
    [head.into_bytes(), body.to_vec()].concat()
}

/// What a service does with a request: the bytes of its answer, or `None` for silence.
type Behaviour = Arc<dyn Fn(&str) -> Option<Vec<u8>> + Send + Sync>;

/// A scripted service.
struct Service {
    address: SocketAddr,
    asked: Arc<Mutex<Vec<String>>>,
    behaviour: Arc<Mutex<Behaviour>>,
    /// While it is set, answers wait for a permit.
    gate: Arc<Mutex<Option<Arc<Notify>>>>,
    most_at_once: Arc<AtomicUsize>,
    task: JoinHandle<()>,
}

impl Drop for Service {
    fn drop(&mut self) {
        self.task.abort();
    }
}

impl Service {
    async fn start(behaviour: impl Fn(&str) -> Option<Vec<u8>> + Send + Sync + 'static) -> Self {
        let listener = TcpListener::bind("127.0.0.1:0").await.expect("a socket");
        let address = listener.local_addr().expect("bound");
        let asked: Arc<Mutex<Vec<String>>> = Arc::default();
        let behaviour: Arc<Mutex<Behaviour>> = Arc::new(Mutex::new(Arc::new(behaviour)));
        let gate: Arc<Mutex<Option<Arc<Notify>>>> = Arc::default();
        let (at_once, most_at_once) = (Arc::new(AtomicUsize::new(0)), Arc::new(AtomicUsize::new(0)));
        let shared = (asked.clone(), behaviour.clone(), gate.clone(), at_once, most_at_once.clone());
        let task = tokio::spawn(async move {
            while let Ok((stream, _)) = listener.accept().await {
                tokio::spawn(serve(stream, shared.clone()));
            }
        });
        Self { address, asked, behaviour, gate, most_at_once, task }
    }

    fn now(&self, behaviour: impl Fn(&str) -> Option<Vec<u8>> + Send + Sync + 'static) {
        *self.behaviour.lock().expect("lock") = Arc::new(behaviour);
    }

    fn count(&self) -> usize {
        self.asked.lock().expect("lock").len()
    }

    fn last(&self) -> String {
        self.asked.lock().expect("lock").last().cloned().expect("asked")
    }

    fn url(&self, rest: &str) -> String {
        format!("http://{}/{rest}", self.address)
    }
}

type Shared = (
    Arc<Mutex<Vec<String>>>,
    Arc<Mutex<Behaviour>>,
    Arc<Mutex<Option<Arc<Notify>>>>,
    Arc<AtomicUsize>,
    Arc<AtomicUsize>,
);

async fn serve(mut stream: TcpStream, (asked, behaviour, gate, at_once, most): Shared) {
    let mut head = Vec::new();
    let mut byte = [0_u8; 1024];
    while !head.windows(4).any(|end| end == b"\r\n\r\n") {
        match stream.read(&mut byte).await {
            Ok(0) | Err(_) => return,
            Ok(count) => head.extend_from_slice(&byte[..count]),
        }
    }
    let head = String::from_utf8_lossy(&head).into_owned();
    asked.lock().expect("lock").push(head.clone());
    most.fetch_max(at_once.fetch_add(1, Ordering::SeqCst) + 1, Ordering::SeqCst);
    let closed = gate.lock().expect("lock").clone();
    if let Some(gate) = closed {
        gate.notified().await;
    }
    let behave = behaviour.lock().expect("lock").clone();
    if let Some(bytes) = behave(&head) {
        // The other side may hang up on what is too long.
        let _ = stream.write_all(&bytes).await;
        let _ = stream.shutdown().await;
    } else {
        // Silent until the other side gives up.
        let _ = stream.read(&mut byte).await;
    }
    at_once.fetch_sub(1, Ordering::SeqCst);
}

struct World {
    maps: Maps,
    now_s: Arc<AtomicI64>,
    folder: PathBuf,
}

impl Drop for World {
    fn drop(&mut self) {
        self.maps.close();
        let _ = std::fs::remove_dir_all(&self.folder);
    }
}

fn folder() -> PathBuf {
    static COUNT: AtomicU64 = AtomicU64::new(0);
    let name = format!("vencejo-maps-it-{}-{}", std::process::id(), COUNT.fetch_add(1, Ordering::Relaxed));
    std::env::temp_dir().join(name)
}

async fn start(folder: PathBuf, now_s: &Arc<AtomicI64>, whole: Duration) -> Maps {
    let clock = now_s.clone();
    let mut config = MapsConfig::new(folder);
    config.patience = Patience { connect: Duration::from_secs(5), whole };
    config.clock = Arc::new(move || clock.load(Ordering::SeqCst));
    Maps::start(config).await.expect("maps")
}

/// Maps without sources.
async fn world() -> World {
    world_with(Duration::from_secs(20)).await
}

async fn world_with(whole: Duration) -> World {
    let (folder, now_s) = (folder(), Arc::new(AtomicI64::new(1_800_000_000)));
    std::fs::create_dir_all(&folder).expect("a folder");
    std::fs::write(folder.join("sources.toml"), "").expect("written");
    World { maps: start(folder.clone(), &now_s, whole).await, now_s, folder }
}

impl World {
    fn pass(&self, seconds: i64) {
        self.now_s.fetch_add(seconds, Ordering::SeqCst);
    }

    async fn put(&self, settings: SourceSettings) {
        self.maps.put(settings).await.expect("put");
    }

    async fn state(&self, id: &str) -> vencejo_maps::SourceState {
        self.maps.describe(id).await.expect("there").state
    }
}

fn xyz(url: String) -> SourceSettings {
    SourceSettings { url: Some(url), local_network: true, ..SourceSettings::new("a", "A", SourceKind::Xyz) }
}

/// Heights of a service, at level 3 alone.
fn terrarium_at(service: &Service) -> SourceSettings {
    SourceSettings {
        role: Role::Elevation,
        encoding: Some(Encoding::Terrarium),
        min_zoom: Some(3),
        max_zoom: Some(3),
        ..xyz(service.url("{z}/{x}/{y}"))
    }
}

async fn error(maps: &Maps) -> MapError {
    tokio::time::timeout(LIMIT, maps.tile("a", TILE)).await.expect("in time").expect_err("an error")
}

/// One tile of a service that behaves so.
async fn meets(behaviour: impl Fn(&str) -> Option<Vec<u8>> + Send + Sync + 'static) -> (MapError, World, Service) {
    let service = Service::start(behaviour).await;
    let world = world_with(Duration::from_millis(1500)).await;
    world.put(xyz(service.url("{z}/{x}/{y}"))).await;
    (error(&world.maps).await, world, service)
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn services_that_misbehave_are_told_with_their_own_words() {
    let exception: &[u8] =
        b"<?xml version='1.0'?><ServiceExceptionReport><ServiceException code='LayerNotDefined'>no layer 'x'</ServiceException></ServiceExceptionReport>";
    let cut = png()[..200].to_vec();
    let html: &[u8] = b"<!doctype html><title>Hotel Wi-Fi</title><p>Please sign in</p>";
    let many = format!("<ServiceExceptionReport>{}</ServiceExceptionReport>", "<a>".repeat(10_000));
    let cases: Vec<(Vec<u8>, &str)> = vec![
        (answer("200 OK", "Content-Type: image/png\r\n", exception), "no layer 'x' (LayerNotDefined)"),
        (answer("200 OK", "Content-Type: image/png\r\n", html), "a web page: Hotel Wi-Fi Please sign in"),
        (answer("200 OK", "Content-Type: image/png\r\n", b""), "nothing"),
        (answer("200 OK", "Content-Type: image/png\r\n", &cut), "cut short"),
        (answer("200 OK", "", many.as_bytes()), "XML"),
        (answer("500 Oops", "", b"<html>database down</html>"), "500: database down"),
        (
            answer("403 No", "", b"{\"error\": {\"message\": \"API key not valid\"}}"),
            "403: API key not valid; check the key",
        ),
        (b"HTTP/1.1 200 OK\r\nContent-Length: 1000\r\n\r\nshort".to_vec(), "cut short"),
        (b"HTTP/1.1 200 OK\r\nContent-Length: 99999999999\r\n\r\n".to_vec(), "more than 8388608 bytes"),
        (b"nonsense\r\n\r\n".to_vec(), "broken"),
        (answer("302 Found", "Location: http://127.0.0.2:9/x\r\n", b""), "an address inside this network"),
        (answer("302 Found", "Location: http://[::1]:9/x\r\n", b""), "an address inside this network"),
        (answer("302 Found", "Location: http://localhost:9/x\r\n", b""), "an address inside this network"),
        (answer("302 Found", "Location: http://169.254.169.254/latest\r\n", b""), "never asked for maps"),
        (answer("302 Found", "Location: file:///etc/passwd\r\n", b""), "not followed"),
        (answer("302 Found", "Location: /again\r\n", b""), "redirects without end"),
        (answer("302 Found", "", b""), "redirects to nowhere"),
    ];
    for (bytes, said) in cases {
        let (error, world, _service) = meets(move |_| Some(bytes.clone())).await;
        let is_of_service = matches!(error, MapError::Service { .. } | MapError::LocalAddress { .. });
        assert!(is_of_service, "{said}: {error:?}");
        assert!(error.to_string().contains(said), "{said}: {error}");
        let state = world.state("a").await;
        assert_eq!((state.status, state.failed), (Status::Failing, 1), "{said}");
        assert!(state.detail.expect("why").contains(said));
    }
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn what_never_ends_is_cut_off() {
    // Without a length, and packed into little.
    let (error, _world, _service) = meets(|_| {
        let mut bytes = b"HTTP/1.1 200 OK\r\nContent-Type: image/png\r\n\r\n".to_vec();
        bytes.resize(9 * 1024 * 1024, 0);
        Some(bytes)
    })
    .await;
    assert!(error.to_string().contains("more than"), "{error}");
    let mut packer = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::best());
    std::io::Write::write_all(&mut packer, &vec![0; 20 * 1024 * 1024]).expect("packed");
    let packed = packer.finish().expect("packed");
    assert!(packed.len() < 1024 * 1024);
    let (error, _world, _service) = meets(move |_| Some(answer("200 OK", "Content-Encoding: gzip\r\n", &packed))).await;
    assert!(error.to_string().contains("more than"), "{error}");
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_source_that_works_again_says_so_at_once() {
    let (_, world, service) = meets(|_| Some(answer("500 Oops", "", b"down"))).await;
    assert_eq!(world.state("a").await.status, Status::Failing);
    // No second goes by between the failure and the test, which asks also for what was not to be asked for again yet.
    service.now(|_| Some(answer("200 OK", "", &png())));
    let state = world.maps.check("a").await.expect("a state");
    assert_eq!((state.status, state.detail), (Status::Ok, None));
    assert_eq!(world.maps.tile("a", TILE).await.expect("a tile").origin, Origin::Fetched);
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn silence_ends_and_is_remembered() {
    let (error, world, service) = meets(|_| None).await;
    assert!(matches!(error, MapError::Timeout { .. }), "{error:?}");
    assert_eq!(world.state("a").await.status, Status::Offline);
    // Not asked again for a while.
    assert!(world.maps.tile("a", TILE).await.is_err());
    assert_eq!(service.count(), 1);
    world.pass(61);
    service.now(|_| Some(answer("200 OK", "", &png())));
    assert_eq!(world.maps.tile("a", TILE).await.expect("a tile").origin, Origin::Fetched);
    assert_eq!(world.state("a").await.status, Status::Ok);
    // A clock that is set back makes no wait longer: neither a tile's nor that of the whole service.
    let other = TileId { column: 5, ..TILE };
    for refusal in [answer("500 No", "", b"down"), answer("503 Busy", "Retry-After: 60\r\n", b"")] {
        service.now(move |_| Some(refusal.clone()));
        assert!(world.maps.tile("a", other).await.is_err());
        service.now(|_| Some(answer("404 None", "", b"")));
        assert_ne!(world.maps.tile("a", other).await, Err(MapError::NoTile), "not asked again at once");
        world.pass(-3600);
        assert_eq!(world.maps.tile("a", other).await, Err(MapError::NoTile));
        world.pass(86_400 + 3600);
    }
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn capabilities_that_are_bombs_do_no_harm() {
    let bomb = "<!DOCTYPE a [<!ENTITY a 'aaaaaaaaaa'><!ENTITY b '&a;&a;&a;&a;&a;&a;&a;&a;'><!ENTITY c '&b;&b;&b;&b;&b;&b;'>]>\
                <WMS_Capabilities version='1.3.0'><Service><Title>&c;</Title></Service></WMS_Capabilities>";
    let deep = format!("<WMS_Capabilities>{}", "<Layer>".repeat(1_000_000));
    for text in [bomb.to_owned(), deep, "<html>hello</html>".to_owned()] {
        let service = Service::start(move |_| Some(answer("200 OK", "", text.as_bytes()))).await;
        let world = world().await;
        let asked = world.maps.capabilities(SourceKind::Wms, &service.url("wms"), None, true).await;
        assert!(matches!(asked, Err(MapError::Service { .. })), "{asked:?}");
    }
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_tile_is_fetched_once_then_asked_about_then_shown_old() {
    let service =
        Service::start(|_| Some(answer("200 OK", "ETag: \"v1\"\r\nCache-Control: max-age=60\r\n", &png()))).await;
    let world = world().await;
    world.put(xyz(service.url("{z}/{x}/{y}"))).await;
    let origin = async || world.maps.tile("a", TILE).await.expect("a tile").origin;
    assert_eq!(origin().await, Origin::Fetched);
    assert!(service.last().to_lowercase().contains("user-agent: vencejo/"), "{}", service.last());
    world.pass(59);
    assert_eq!((origin().await, service.count()), (Origin::Hit, 1));
    world.pass(2);
    service.now(|head| {
        let asks = head.to_lowercase().contains("if-none-match: \"v1\"");
        Some(if asks { answer("304 Same", "Cache-Control: max-age=60\r\n", b"") } else { answer("500 No", "", b"") })
    });
    assert_eq!((origin().await, service.count()), (Origin::Revalidated, 2));
    world.pass(30);
    assert_eq!(origin().await, Origin::Hit);
    world.pass(3600);
    service.now(|_| Some(answer("500 No", "", b"down")));
    assert_eq!((origin().await, service.count()), (Origin::Stale, 3));
    assert_eq!((origin().await, service.count()), (Origin::Stale, 3), "not asked again at once");
    let state = world.state("a").await;
    assert_eq!((state.status, state.stale, state.revalidated, state.hits), (Status::Failing, 2, 1, 2));
    let status = match &state.cause {
        Some(SourceCause::SourceFailed { status, .. }) => *status,
        other => panic!("{other:?}"),
    };
    assert!(status.is_some_and(|status| status >= 500), "{status:?}");
    assert!(state.detail.expect("why").contains("down"));
    // The network goes, and the station restarts: cached tiles are there.
    let address = service.address;
    drop(service);
    world.maps.close();
    let again = start(world.folder.clone(), &world.now_s, Duration::from_secs(5)).await;
    assert_eq!(again.tile("a", TILE).await.expect("a tile").origin, Origin::Stale);
    let other = again.tile("a", TileId { column: 5, ..TILE }).await;
    assert!(matches!(other, Err(MapError::Offline { why: Unreached::Refused, .. })), "{other:?} {address}");
    let state = again.describe("a").await.expect("there").state;
    assert_eq!(state.status, Status::Offline);
    let Some(SourceCause::SourceOffline { service, why, .. }) = state.cause else { panic!("{:?}", state.cause) };
    assert_eq!((service, why), (address.to_string(), Unreached::Refused));
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn what_is_not_there_is_remembered_and_what_may_not_be_kept_is_not() {
    let service = Service::start(|_| Some(answer("404 None", "", b""))).await;
    let world = world().await;
    world.put(xyz(service.url("{z}/{x}/{y}"))).await;
    for _ in 0..3 {
        assert_eq!(world.maps.tile("a", TILE).await, Err(MapError::NoTile));
    }
    assert_eq!(service.count(), 1);
    world.pass(86_401);
    service.now(|_| Some(answer("200 OK", "Cache-Control: no-store\r\n", &png())));
    for count in 2..4 {
        assert_eq!(world.maps.tile("a", TILE).await.expect("a tile").origin, Origin::Fetched);
        assert_eq!(service.count(), count, "not kept");
    }
    // Outside of its bounds a source is not requested.
    assert_eq!(world.maps.tile("a", TileId { level: 3, column: 8, row: 0 }).await, Err(MapError::NoTile));
    assert_eq!(service.count(), 3);
    // By the headers alone, and not one second longer, whatever fails.
    let mut settings = xyz(service.url("{z}/{x}/{y}"));
    settings.cache = Caching::Headers;
    world.put(settings).await;
    service.now(|_| Some(answer("200 OK", "Cache-Control: max-age=60\r\n", &png())));
    let tile = TileId { column: 6, ..TILE };
    assert_eq!(world.maps.tile("a", tile).await.expect("a tile").origin, Origin::Fetched);
    assert_eq!(world.maps.tile("a", tile).await.expect("a tile").origin, Origin::Hit);
    world.pass(61);
    service.now(|_| Some(answer("500 No", "", b"")));
    assert!(world.maps.tile("a", tile).await.is_err(), "nothing old is shown");
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn many_who_want_the_same_tile_make_one_request_and_a_host_gets_few_at_once() {
    let service = Service::start(|_| Some(answer("200 OK", "", &png()))).await;
    let world = world().await;
    let mut settings = xyz(service.url("{z}/{x}/{y}"));
    settings.parallel = Some(2);
    world.put(settings).await;
    let gate = Arc::new(Notify::new());
    *service.gate.lock().expect("lock") = Some(gate.clone());
    let wanted: Vec<_> = (0..20)
        .map(|_| {
            let maps = world.maps.clone();
            tokio::spawn(async move { maps.tile("a", TILE).await.map(|tile| tile.origin) })
        })
        .collect();
    wait_for(|| service.count() == 1).await;
    gate.notify_one();
    for tile in wanted {
        // Who comes late finds it in the cache.
        let origin = tile.await.expect("ended");
        assert!(matches!(origin, Ok(Origin::Fetched | Origin::Hit)), "{origin:?}");
    }
    assert_eq!(service.count(), 1);
    *service.gate.lock().expect("lock") = None;
    let others: Vec<_> = (0..8)
        .map(|column| {
            let maps = world.maps.clone();
            tokio::spawn(async move { maps.tile("a", TileId { level: 3, column, row: 7 }).await.is_ok() })
        })
        .collect();
    for tile in others {
        assert!(tile.await.expect("ended"));
    }
    assert!(service.most_at_once.load(Ordering::SeqCst) <= 2);
    // A request that missed the cache before the tile came finds it there afterwards.
    let before = service.count();
    let crowd: Vec<_> = (0..480)
        .map(|one| {
            let maps = world.maps.clone();
            tokio::spawn(async move { maps.tile("a", TileId { level: 6, column: one / 8, row: 3 }).await.is_ok() })
        })
        .collect();
    for tile in crowd {
        assert!(tile.await.expect("ended"));
    }
    assert_eq!(service.count(), before + 60);
    // Who moves on is not waited for.
    *service.gate.lock().expect("lock") = Some(gate.clone());
    let before = service.count();
    let left = {
        let maps = world.maps.clone();
        tokio::spawn(async move { maps.tile("a", TileId { level: 4, column: 1, row: 1 }).await })
    };
    wait_for(|| service.count() > before).await;
    left.abort();
    *service.gate.lock().expect("lock") = None;
    gate.notify_waiters();
    assert!(world.maps.tile("a", TileId { level: 4, column: 1, row: 1 }).await.is_ok());
}

async fn wait_for(condition: impl Fn() -> bool) {
    let waiting = async {
        while !condition() {
            tokio::time::sleep(Duration::from_millis(2)).await;
        }
    };
    tokio::time::timeout(LIMIT, waiting).await.expect("in time");
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn keys_are_kept_used_and_never_told() {
    let service = Service::start(|head| {
        let said = head.contains("key=s3cret");
        Some(if said { answer("403 No", "", b"the key s3cret is not valid") } else { answer("400 No", "", b"no key") })
    })
    .await;
    let world = world().await;
    let mut settings = xyz(service.url("{z}/{x}/{y}?key={key}"));
    world.put(settings.clone()).await;
    assert_eq!(world.maps.tile("a", TILE).await, Err(MapError::KeyMissing("a".into())));
    assert_eq!((world.state("a").await.status, service.count()), (Status::KeyMissing, 0));
    settings.key = Some("s3cret".into());
    world.put(settings.clone()).await;
    let error = error(&world.maps).await;
    assert!(error.to_string().contains("the key … is not valid") && !error.to_string().contains("s3cret"), "{error}");
    let configuration = world.maps.configuration().await.expect("read");
    assert_eq!((configuration.sources[0].key.as_ref(), configuration.sources[0].has_key), (None, Some(true)));
    // Absent keeps it, empty removes it.
    settings.key = None;
    world.put(settings.clone()).await;
    assert!(world.maps.describe("a").await.expect("there").has_key);
    settings.key = Some(String::new());
    world.put(settings).await;
    assert!(!world.maps.describe("a").await.expect("there").has_key);
    assert!(!std::fs::read_to_string(world.folder.join("sources.toml")).expect("read").contains("s3cret"));
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn the_file_may_be_edited_by_hand_at_any_time() {
    let world = world().await;
    let path = world.folder.join("sources.toml");
    let text =
        "# mine\n[[source]]\nid = \"m\"\nname = \"M\"\nkind = \"xyz\"\nurl = \"http://127.0.0.1:9/{z}/{x}/{y}\"\n";
    std::fs::write(&path, text).expect("written");
    let listed = world.maps.list(true).await.expect("listed");
    assert_eq!((listed.sources[0].id.as_str(), listed.file_error), ("m", None));
    std::fs::write(&path, text.replace("kind", "kid")).expect("written");
    let listed = world.maps.list(true).await.expect("listed");
    let error = listed.file_error.expect("wrong");
    assert!(error.contains("line 5") && error.contains("kid"), "{error}");
    assert_eq!(listed.sources.len(), 1, "the last right one is in use");
    assert!(matches!(
        world.maps.put(xyz("http://a.example/{z}/{x}/{y}".into())).await,
        Err(MapError::SourcesFile { .. })
    ));
    let wrong = world.maps.put(SourceSettings { opacity: 7.0, ..xyz("http://a/{z}".into()) }).await;
    assert!(matches!(&wrong, Err(MapError::Settings { faults, .. }) if faults.len() == 2), "{wrong:?}");
    let ups = ["..", "..\\", "%2e%2e", "....", ". .", "\u{ff0e}\u{ff0e}"];
    let mut tried = 0;
    for up in ups {
        for separator in ["/", "\\", "//", "/./", "%2f", ":"] {
            for depth in 1..=4 {
                let name = format!("{}evil.mbtiles", [up, separator].concat().repeat(depth));
                let is_plain = !name.contains(['/', '\\', ':', '*', '?', '"', '<', '>', '|']) && !name.starts_with('.');
                match world.maps.begin_upload(&name).await {
                    Ok(upload) => {
                        assert!(is_plain, "{name}");
                        assert_eq!(upload.path().parent(), Some(&*world.folder.join("tmp")), "{name}");
                    }
                    Err(error) => assert!(matches!(error, MapError::MapFile { .. }), "{name}"),
                }
                tried += 1;
            }
        }
    }
    assert_eq!(tried, 144);
    for path in ["/etc/passwd", "../x.mbtiles", "a/../../x", "C:\\x"] {
        let settings = SourceSettings { path: Some(path.into()), ..SourceSettings::new("f", "F", SourceKind::Mbtiles) };
        let refused = world.maps.put(settings).await.expect_err("outside");
        assert!(refused.to_string().contains("maps folder"), "{refused}");
    }
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_new_installation_has_the_sources_that_need_no_key() {
    let (folder, now_s) = (folder(), Arc::new(AtomicI64::new(0)));
    let maps = start(folder.clone(), &now_s, Duration::from_secs(1)).await;
    let listed = maps.list(false).await.expect("listed");
    let ids: Vec<&str> = listed.sources.iter().map(|source| source.id.as_str()).collect();
    assert_eq!(ids, ["pnoa", "ign-base", "osm", "esri-imagery", "sentinel2", "terrain"]);
    assert!(listed.file.is_empty(), "viewers need not know where it is");
    assert!(listed.sources.iter().all(|source| source.grid.is_some() && source.state.status == Status::Unused));
    let osm = &listed.sources[2];
    assert!(!osm.offline.allowed && osm.offline.reason.as_ref().expect("why").contains("policy"));
    let shape = Shape::Box(Bounds { west_deg: -4.0, south_deg: 40.0, east_deg: -3.9, north_deg: 40.1 });
    let wanted = NewArea { source: "osm".into(), name: "x".into(), shape, min_level: 10, max_level: 12 };
    assert!(maps.estimate_area(&wanted).await.expect("reckoned").refused.is_some());
    assert!(matches!(maps.add_area(wanted).await, Err(MapError::OfflineRefused { .. })));
    maps.close();
    std::fs::remove_dir_all(folder).expect("removed");
}

fn field() -> Shape {
    Shape::Route {
        points: vec![Corner { lat_deg: 40.0, lon_deg: -4.0 }, Corner { lat_deg: 40.02, lon_deg: -3.98 }],
        buffer_m: 500.0,
    }
}

fn area(name: &str) -> NewArea {
    NewArea { source: "a".into(), name: name.into(), shape: field(), min_level: 10, max_level: 15 }
}

async fn wait_state(maps: &Maps, id: &str, state: AreaState) -> vencejo_maps::Area {
    let waiting = async {
        loop {
            let area = maps.area(id).await.expect("there");
            if area.state == state {
                return area;
            }
            tokio::time::sleep(Duration::from_millis(5)).await;
        }
    };
    tokio::time::timeout(LIMIT, waiting).await.unwrap_or_else(|_| panic!("{state:?} in time"))
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn an_area_survives_a_crash_and_goes_to_another_station() {
    let service = Service::start(|_| Some(answer("200 OK", "", &png()))).await;
    let world = world().await;
    let mut settings = xyz(service.url("{z}/{x}/{y}"));
    settings.max_mb = Some(1);
    world.put(settings.clone()).await;
    let estimate = world.maps.estimate_area(&area("Field")).await.expect("reckoned");
    assert!(estimate.tiles > 10 && estimate.have == 0 && estimate.refused.is_none(), "{estimate:?}");
    let gate = Arc::new(Notify::new());
    *service.gate.lock().expect("lock") = Some(gate.clone());
    let made = world.maps.add_area(area("Field")).await.expect("made");
    assert_eq!((made.tiles, made.state), (estimate.tiles, AreaState::Running));
    wait_for(|| service.count() >= 4).await;
    for _ in 0..4 {
        gate.notify_one();
        tokio::task::yield_now().await;
    }
    wait_for(|| service.count() >= 6).await;
    // The process ends in the middle; another one goes on.
    world.maps.close();
    *service.gate.lock().expect("lock") = None;
    gate.notify_waiters();
    let before = service.count();
    let again = start(world.folder.clone(), &world.now_s, Duration::from_secs(20)).await;
    let done = wait_state(&again, &made.id, AreaState::Done).await;
    assert_eq!((done.done, done.failed, done.name.as_str()), (estimate.tiles, 0, "Field"));
    assert!(service.count() - before <= estimate.tiles as usize, "what was there was not fetched again");
    let estimate = again.estimate_area(&area("Field")).await.expect("reckoned");
    assert_eq!((estimate.have, estimate.bytes, estimate.tile_bytes_measured), (estimate.tiles, 0, true));
    assert_eq!(again.describe("a").await.expect("there").state.cache.expect("kept").pinned_tiles, estimate.tiles);
    // Without the network it is all there.
    let (path, name) = again.export_area(&made.id).await.expect("exported");
    assert_eq!(name, "Field");
    drop(service);
    let other = world_at(&settings).await;
    let taken = other.maps.import_area("a", "", path.clone()).await.expect("imported");
    assert_eq!((taken.state, taken.done, taken.name.as_str()), (AreaState::Done, estimate.tiles, "Field"));
    assert_eq!(taken.shape, field());
    for tile in vencejo_maps::cover::tiles(
        other.maps.describe("a").await.expect("there").grid.as_ref().expect("known"),
        &field(),
        10..=15,
        100_000,
    )
    .expect("tiles")
    {
        assert_eq!(other.maps.tile("a", tile).await.expect("a tile").origin, Origin::Hit);
    }
    other.maps.remove_area(&taken.id).await.expect("removed");
    assert_eq!(other.maps.area(&taken.id).await, Err(MapError::NoArea(taken.id)));
    // A file of another grid does not fit.
    let mut wide = settings.clone();
    wide.tile_px = Some(512);
    other.put(wide).await;
    let refused = other.maps.import_area("a", "", path.clone()).await.expect_err("another grid");
    assert!(refused.to_string().contains("another grid"), "{refused}");
    std::fs::write(&path, "no database, but of some length, so that it can be taken for one at first sight")
        .expect("written");
    assert!(matches!(other.maps.import_area("a", "", path).await, Err(MapError::MapFile { .. })));
    again.close();
}

async fn world_at(settings: &SourceSettings) -> World {
    let world = world().await;
    world.put(settings.clone()).await;
    world
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn an_area_pauses_goes_on_and_tells_what_failed() {
    let service = Service::start(|head| {
        let bad = head.starts_with("GET /15/");
        Some(if bad { answer("500 No", "", b"disk full") } else { answer("200 OK", "", &png()) })
    })
    .await;
    let world = world().await;
    let mut settings = xyz(service.url("{z}/{x}/{y}"));
    settings.max_zoom = Some(15);
    world.put(settings).await;
    let gate = Arc::new(Notify::new());
    *service.gate.lock().expect("lock") = Some(gate.clone());
    let made = world.maps.add_area(area("Field")).await.expect("made");
    wait_for(|| service.count() >= 1).await;
    assert_eq!(world.maps.pause_area(&made.id).await.expect("paused").state, AreaState::Paused);
    *service.gate.lock().expect("lock") = None;
    gate.notify_waiters();
    world.maps.resume_area(&made.id).await.expect("resumed");
    let ended = async {
        loop {
            let area = world.maps.area(&made.id).await.expect("there");
            if area.state != AreaState::Running {
                return area;
            }
            tokio::time::sleep(Duration::from_millis(5)).await;
        }
    };
    let ended = tokio::time::timeout(LIMIT, ended).await.expect("in time");
    assert!(ended.failed > 0 && ended.done > 0 && ended.detail.expect("why").contains("disk full"));
    world.pass(60);
    service.now(|_| Some(answer("200 OK", "", &png())));
    world.maps.resume_area(&made.id).await.expect("resumed");
    let done = wait_state(&world.maps, &made.id, AreaState::Done).await;
    assert_eq!((done.done, done.failed, done.detail), (done.tiles, 0, None));
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn google_opens_one_session_and_a_new_one_when_it_is_ended() {
    let sessions = Arc::new(AtomicUsize::new(0));
    let opened = sessions.clone();
    let service = Service::start(move |head| {
        let line = head.lines().next().unwrap_or_default();
        Some(if line.starts_with("POST /v1/createSession?key=k") {
            let number = opened.fetch_add(1, Ordering::SeqCst) + 1;
            let text = format!("{{\"session\": \"s{number}\", \"expiry\": \"1801209600\", \"tileWidth\": 256}}");
            answer("200 OK", "", text.as_bytes())
        } else if line.contains("/tile/v1/viewport") {
            answer("200 OK", "", b"{\"copyright\": \"Map data <b>2026</b>\", \"maxZoomRects\": [{\"maxZoom\": 19}]}")
        } else if line.contains("session=s1") && opened.load(Ordering::SeqCst) > 1 {
            answer("403 No", "", b"")
        } else {
            answer("200 OK", "Cache-Control: private, max-age=60\r\n", &png())
        })
    })
    .await;
    let world = world().await;
    let settings = SourceSettings {
        url: Some(service.url("")),
        key: Some("k".into()),
        cache: Caching::Headers,
        local_network: true,
        ..SourceSettings::new("a", "G", SourceKind::Google)
    };
    world.put(settings).await;
    for column in 0..3 {
        assert!(world.maps.tile("a", TileId { column, ..TILE }).await.is_ok());
    }
    assert_eq!(sessions.load(Ordering::SeqCst), 1);
    let view = Bounds { west_deg: -4.0, south_deg: 40.0, east_deg: -3.0, north_deg: 41.0 };
    let (named, max_zoom) = world.maps.attribution("a", &view, 12).await.expect("told");
    assert_eq!((named[0].text.as_str(), max_zoom), ("Map data 2026", Some(19)));
    // Ended before its time: one more is opened, once.
    sessions.store(2, Ordering::SeqCst);
    assert!(world.maps.tile("a", TileId { column: 6, ..TILE }).await.is_ok());
    assert_eq!(sessions.load(Ordering::SeqCst), 3);
    let described = world.maps.describe("a").await.expect("there");
    assert!(described.attribution_by_view && !described.may_cache && !described.offline.allowed);
    assert_eq!(described.logo.as_deref(), Some("google"));
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_wmts_is_known_without_the_network_once_it_was_read() {
    let capabilities = "<Capabilities version='1.0.0'><Contents><Layer><Identifier>l</Identifier>\
        <Style isDefault='true'><Identifier>d</Identifier></Style><Format>image/png</Format>\
        <TileMatrixSetLink><TileMatrixSet>m</TileMatrixSet></TileMatrixSetLink></Layer>\
        <TileMatrixSet><Identifier>m</Identifier><SupportedCRS>EPSG:25830</SupportedCRS><TileMatrix><Identifier>0</Identifier>\
        <ScaleDenominator>35714285.714</ScaleDenominator><TopLeftCorner>0 10000000</TopLeftCorner><TileWidth>256</TileWidth>\
        <TileHeight>256</TileHeight><MatrixWidth>4</MatrixWidth><MatrixHeight>4</MatrixHeight></TileMatrix></TileMatrixSet></Contents></Capabilities>";
    let service = Service::start(move |head| {
        let is_tile = head.contains("REQUEST=GetTile") && head.contains("TILEROW=2&TILECOL=1");
        Some(if is_tile { answer("200 OK", "", &png()) } else { answer("200 OK", "", capabilities.as_bytes()) })
    })
    .await;
    let world = world().await;
    let settings = SourceSettings {
        url: Some(service.url("wmts")),
        layer: Some("l".into()),
        local_network: true,
        ..SourceSettings::new("a", "W", SourceKind::Wmts)
    };
    world.put(settings).await;
    let tile = TileId { level: 0, column: 1, row: 2 };
    assert!(world.maps.tile("a", tile).await.is_ok());
    drop(service);
    world.maps.close();
    let again = start(world.folder.clone(), &world.now_s, Duration::from_secs(5)).await;
    let grid = again.describe("a").await.expect("there").grid.expect("known");
    assert_eq!((grid.crs.code().as_str(), grid.levels[0].resolution.round()), ("EPSG:25830", 10_000.0));
    assert_eq!(again.tile("a", tile).await.expect("a tile").origin, Origin::Hit);
    again.close();
}

/// Terrarium tiles whose height is the pixel's column plus twice its row, over the whole world at zoom 3.
fn terrarium(column: u32, row: u32) -> Vec<u8> {
    let mut raster = Raster::filled(256, 256, [0, 0, 0, 255]);
    for y in 0..256 {
        for x in 0..256 {
            let value = 32_768 + (column * 256 + x) + 2 * (row * 256 + y);
            raster.set(x, y, [(value >> 8) as u8, value as u8, 0, 255]);
        }
    }
    raster.to_png()
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn heights_lie_between_pixels_even_over_the_edges_of_tiles() {
    let service = Service::start(|head| {
        let path = head.split_whitespace().nth(1).unwrap_or_default();
        let numbers: Vec<u32> = path.split('/').filter_map(|part| part.parse().ok()).collect();
        let [3, column, row] = *numbers.as_slice() else { return Some(answer("404 None", "", b"")) };
        Some(if (column, row) == (7, 7) {
            answer("500 No", "", b"broken")
        } else {
            answer("200 OK", "", &terrarium(column, row))
        })
    })
    .await;
    let world = world().await;
    let settings = terrarium_at(&service);
    world.put(settings).await;
    let grid = world.maps.describe("a").await.expect("there").grid.expect("known");
    let place = |column: f64, row: f64| {
        let resolution = grid.levels[3].resolution;
        let [left, top] = grid.levels[3].origin;
        let at = grid.crs.unproject([left + column * resolution, top - row * resolution]).expect("on Earth");
        Corner { lat_deg: at.lat_deg(), lon_deg: at.lon_deg() }
    };
    let wanted: BTreeMap<&str, (f64, f64)> = BTreeMap::from([
        ("the middle of a pixel", (1000.5, 900.5)),
        ("between pixels", (1000.75, 900.9)),
        ("between tiles", (1024.0, 1024.0)),
        ("the corner of four", (768.1, 1279.9)),
    ]);
    let points: Vec<Corner> = wanted.values().map(|(column, row)| place(*column, *row)).collect();
    let (found, fault) = world.maps.heights(&points).await.expect("asked");
    assert_eq!(fault, None);
    for ((name, (column, row)), point) in wanted.iter().zip(&found) {
        let height = point.alt_amsl_m.expect(name);
        let expected = (column - 0.5) + 2.0 * (row - 0.5);
        assert!((height - expected).abs() < 1e-3, "{name}: {height} {expected}");
        assert_eq!((point.source.as_deref(), point.datum.as_deref()), (Some("a"), Some("EGM96")));
    }
    // What fails stays unknown, and says why.
    let (found, fault) = world.maps.heights(&[place(1900.0, 1900.0)]).await.expect("asked");
    assert_eq!(found[0].alt_amsl_m, None);
    assert!(fault.expect("why").contains("broken"));
    let profile = world.maps.profile(&[points[0], points[1]], Some(1000.0)).await.expect("a profile");
    assert!(profile.unknown == 0 && profile.sources == ["a"] && profile.samples.len() >= 2);
    assert!(world.maps.heights(&[Corner { lat_deg: 91.0, lon_deg: 0.0 }]).await.is_err());
}

// fault 48: 0 requests to a private address that was not allowed
#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_private_address_needs_the_users_word() {
    let service = Service::start(|_| Some(answer("200 OK", "", &png()))).await;
    let world = world().await;
    let mut settings = SourceSettings { local_network: false, ..xyz(service.url("{z}/{x}/{y}")) };
    world.put(settings.clone()).await;
    let told = error(&world.maps).await;
    assert!(matches!(told, MapError::LocalAddress { is_permissible: true, .. }), "{told:?}");
    let told = told.to_string();
    assert!(told.contains("127.0.0.1 is an address inside this network"), "{told}");
    assert!(told.contains("local_network = true"), "how it is done: {told}");
    let asked = world.maps.capabilities(SourceKind::Wms, &service.url("wms"), None, false).await;
    assert!(asked.expect_err("not asked").to_string().contains("inside this network"));
    assert_eq!(service.count(), 0, "nobody was asked");
    settings.local_network = true;
    world.put(settings).await;
    assert!(world.maps.tile("a", TILE).await.is_ok());
    for url in ["http://169.254.169.254/{z}/{x}/{y}", "http://[fe80::1]/{z}/{x}/{y}", "http://0.0.0.0:1/{z}/{x}/{y}"] {
        world.put(xyz(url.to_owned())).await;
        let told = error(&world.maps).await.to_string();
        assert!(told.contains("never asked for maps"), "{told}");
    }
}

// fault 48: 0 requests with the key at another host
#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_key_never_follows_its_source_to_another_host() {
    let other = Service::start(|_| Some(answer("200 OK", "", &png()))).await;
    let port = other.address.port();
    // A service that hands its visitors on, with all that they brought.
    let service = Service::start(move |head| {
        let path = head.split_whitespace().nth(1).unwrap_or_default().to_owned();
        Some(answer("302 Found", &format!("Location: http://localhost:{port}{path}\r\n"), b""))
    })
    .await;
    let world = world().await;
    let settings = SourceSettings { key: Some("s3cret".into()), ..xyz(service.url("{z}/{x}/{y}?key={key}")) };
    world.put(settings.clone()).await;
    let told = error(&world.maps).await.to_string();
    assert!(told.contains("would be given the key, which is for 127.0.0.1 alone"), "{told}");
    assert!(!told.contains("s3cret") && service.last().contains("s3cret"));
    // Who changes the address does not have the key, and does not get it sent to where it was never meant for.
    let moved = SourceSettings { key: None, ..xyz(format!("http://localhost:{port}/{{z}}/{{x}}/{{y}}?key={{key}}")) };
    let refused = world.maps.put(moved.clone()).await.expect_err("refused").to_string();
    assert!(refused.contains("key: it was given for 127.0.0.1; enter it once more"), "{refused}");
    let beside = SourceSettings {
        key: None,
        attribution_url: Some(format!("http://localhost:{port}/?key={{key}}")),
        ..settings.clone()
    };
    assert!(matches!(world.maps.put(beside).await, Err(MapError::Settings { .. })));
    assert_eq!(other.count(), 0, "nothing of it came there");
    // The same host is another address of the same service.
    world.put(SourceSettings { key: None, ..xyz(service.url("tiles/{z}/{x}/{y}?key={key}")) }).await;
    assert!(world.maps.describe("a").await.expect("there").has_key);
    world.put(SourceSettings { key: Some("s3cret".into()), ..moved }).await;
    assert!(world.maps.tile("a", TILE).await.is_ok(), "given anew");
    assert!(other.last().contains("s3cret"));
}

#[cfg(unix)]
#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_source_whose_reading_ended_the_process_is_set_aside_and_told() {
    let folder = folder();
    std::fs::create_dir_all(folder.join("files")).expect("a folder");
    // A file that is read as long as the test wants.
    let (file, reading) = (folder.join("files/a.tif"), folder.join("reading"));
    assert!(std::process::Command::new("mkfifo").arg(&file).status().expect("run").success());
    let text = "[[source]]\nid = \"a\"\nname = \"A\"\nkind = \"geotiff\"\npath = \"files/a.tif\"\n";
    std::fs::write(folder.join("sources.toml"), text).expect("written");
    let now_s = Arc::new(AtomicI64::new(1_000));
    let (there, clock) = (folder.clone(), now_s.clone());
    let first = tokio::spawn(async move { start(there, &clock, Duration::from_secs(5)).await });
    let note = || {
        let runs = std::fs::read_dir(&reading).ok()?.flatten();
        runs.filter_map(|run| std::fs::read(run.path().join("a")).ok()).find(|note| !note.is_empty())
    };
    let limit = std::time::Instant::now() + LIMIT;
    let left = loop {
        if let Some(note) = note() {
            break note;
        }
        assert!(std::time::Instant::now() < limit, "no note");
        tokio::task::yield_now().await;
    };
    // What a process leaves behind that ends there: its notes, and a released lock with the boot id in it.
    let boot = std::fs::read("/proc/sys/kernel/random/boot_id").unwrap_or_default();
    std::fs::create_dir_all(reading.join("gone")).expect("a folder");
    std::fs::write(reading.join("gone/a"), left).expect("written");
    std::fs::write(reading.join("gone.run"), boot).expect("written");
    drop(std::fs::OpenOptions::new().write(true).open(&file).expect("opened"));
    first.await.expect("started").close();

    for restart in 0..2 {
        let maps = start(folder.clone(), &now_s, Duration::from_secs(5)).await;
        let world = World { maps, now_s: now_s.clone(), folder: PathBuf::new() };
        let state = world.state("a").await;
        assert_eq!(state.status, Status::SetAside, "start {restart}");
        assert!(state.detail.expect("told").contains("replace the file"));
        assert!(matches!(error(&world.maps).await, MapError::Unusable { .. }));
    }
    // Another file in its place is read; so is the same one when it is tried again on request.
    std::fs::remove_file(&file).expect("removed");
    std::fs::copy(concat!(env!("CARGO_MANIFEST_DIR"), "/../../tests/fixtures/maps/cog-jpeg-mask.tif"), &file)
        .expect("copied");
    let maps = start(folder.clone(), &now_s, Duration::from_secs(5)).await;
    let world = World { maps, now_s, folder };
    assert_eq!(world.maps.check("a").await.expect("a state").status, Status::Ok);
}
