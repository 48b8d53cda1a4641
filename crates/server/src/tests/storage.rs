//! A full disk, a read-only disk, and a draft that two people change.

use std::path::PathBuf;
use std::sync::atomic::AtomicU64;
use std::sync::{Condvar, Mutex};
use std::time::Instant;

use vencejo_store::{Floors, Space};

use super::*;

const MB: u64 = 1_000_000;

struct Folder(PathBuf);

impl Folder {
    fn new() -> Self {
        static COUNT: AtomicU32 = AtomicU32::new(0);
        let count = COUNT.fetch_add(1, Ordering::Relaxed);
        let path = std::env::temp_dir().join(format!("vencejo-storage-{}-{count}", std::process::id()));
        std::fs::create_dir_all(&path).expect("a folder");
        Self(path)
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        let _ = std::fs::remove_dir_all(&self.0);
    }
}

/// Reported data classes, with the kind of fault.
fn told(message: &Value) -> Vec<(String, String)> {
    let problems = message["problems"].as_array().expect("a list");
    let text = |value: &Value| value.as_str().expect("a text").to_owned();
    problems.iter().map(|problem| (text(&problem["what"]), text(&problem["fault"]["kind"]))).collect()
}

fn low(whats: &[&str]) -> Vec<(String, String)> {
    whats.iter().map(|what| ((*what).to_owned(), "low_space".to_owned())).collect()
}

async fn next_told(socket: &mut Ws, wanted: &[(String, String)]) -> Duration {
    let began = Instant::now();
    while told(&next(socket, "storage").await.expect("it goes on")) != wanted {}
    began.elapsed()
}

// fault 58: reported on the WebSocket within 5 s, maps first, the recorder last; heartbeats go on
#[tokio::test]
async fn a_disk_that_fills_up_is_told_within_five_seconds_and_the_flight_recorder_stops_last() {
    let (folder, free_mb) = (Folder::new(), Arc::new(AtomicU64::new(10_000)));
    let told_by = free_mb.clone();
    let space = Space::with_probe(Floors::default(), move |_| Ok(told_by.load(Ordering::SeqCst) * MB));
    let config = StationConfig {
        request_streams: false,
        record_dir: Some(folder.0.join("telemetry")),
        space: space.clone(),
        ..StationConfig::default()
    };
    let station = Station::start(config, Handle::current()).expect("a station");
    let double = double(&station).await;
    let server =
        serve(&station, ServerConfig { maps_folder: Some(folder.0.join("maps")), space, ..ServerConfig::default() })
            .await;
    let ana = cookie(&server, "ana");
    let mut socket = connect(&server, &ana, None).await.expect("a WebSocket");
    next_told(&mut socket, &[]).await;
    let mut slowest = Duration::ZERO;
    for (mb, expected) in [(1_500, low(&["maps"])), (400, low(&["telemetry", "maps"])), (3_000, Vec::new())] {
        free_mb.store(mb, Ordering::SeqCst);
        let waited = next_told(&mut socket, &expected).await;
        slowest = slowest.max(waited);
        assert!(waited < Duration::from_secs(5), "{mb} MB free: told after {waited:?}");
        // Whatever the disk does, the vehicle can be commanded.
        let before = double.heartbeats.load(Ordering::SeqCst);
        timeout(PATIENCE, async {
            while double.heartbeats.load(Ordering::SeqCst) == before {
                tokio::time::sleep(Duration::from_millis(10)).await;
            }
        })
        .await
        .expect("our heartbeat goes on");
    }
    eprintln!("slowest told: {slowest:?}");
    server.close().await;
    station.close().await;
}

// fault 58: a disk that does not respond is reported within 5 s
#[tokio::test]
async fn a_disk_that_does_not_answer_is_told_and_so_is_that_it_does_again() {
    let (folder, answers) = (Folder::new(), Arc::new((Mutex::new(false), Condvar::new())));
    let asked = answers.clone();
    let space = Space::with_probe(Floors::default(), move |_| {
        let (does, changed) = &*asked;
        // A test that fails meanwhile waits for this thread.
        let _does = changed.wait_timeout_while(does.lock().expect("held by none that failed"), PATIENCE, |does| !*does);
        Ok(10_000 * MB)
    });
    let station = station(true);
    let config = ServerConfig { maps_folder: Some(folder.0.join("maps")), space, ..ServerConfig::default() };
    let server = serve(&station, config).await;
    let mut socket = connect(&server, &cookie(&server, "ana"), None).await.expect("a WebSocket");
    let waited = next_told(&mut socket, &[("maps".to_owned(), "stalled".to_owned())]).await;
    assert!(waited < Duration::from_secs(5), "{waited:?}");
    *answers.0.lock().expect("held by none that failed") = true;
    answers.1.notify_all();
    next_told(&mut socket, &[]).await;
    server.close().await;
    station.close().await;
}

// fault 58: a server starts without a disk, reports it, and shows maps
#[tokio::test]
async fn a_server_starts_where_nothing_can_be_written_and_says_so() {
    let folder = Folder::new();
    std::fs::write(folder.0.join("no-folder"), "a file in its place").expect("written");
    let data = folder.0.join("no-folder/data");
    // The keys can be read, but their timestamps cannot be stored.
    let signing = folder.0.join("signing");
    std::fs::create_dir_all(signing.join("times.json/in the way")).expect("a folder");
    let key = json!({"id": 1, "name": "one", "made_unix_s": 0, "key": "7".repeat(64)});
    let keys = json!({"next_id": 1, "keys": [key], "vehicles": {}});
    std::fs::write(signing.join("keys.json"), keys.to_string()).expect("written");
    let config = StationConfig {
        request_streams: false,
        record_dir: Some(data.join("telemetry")),
        signing_dir: Some(signing),
        ..StationConfig::default()
    };
    let station = Station::start(config, Handle::current()).expect("a station");
    assert_eq!(station.signing_keys().expect("they are used").len(), 1);
    let server = serve(
        &station,
        ServerConfig {
            token_file: Some(data.join("tokens.json")),
            maps_folder: Some(data.join("maps")),
            draft_file: Some(data.join("draft.json")),
            ..ServerConfig::default()
        },
    )
    .await;
    assert!(server.tokens().is_some(), "for this run");
    let mut changes = server.app().storage_changes();
    let all = |problems: &Vec<crate::dto::storage::StorageProblem>| {
        let wanted = ["telemetry", "maps", "draft", "tokens", "signing_times"];
        let told = told(&json!({"problems": problems}));
        told.iter().all(|(_, kind)| kind == "unwritable")
            && told.iter().map(|(what, _)| what.as_str()).collect::<Vec<_>>() == wanted
    };
    // The draft is reported once there is one.
    let draft = json!({"base": 0, "author": "a", "plan": {"items": []}});
    let draft = serde_json::from_value(draft).expect("a draft");
    server.app().drafts().put(draft, "ana".to_owned()).expect("in memory");
    timeout(PATIENCE, changes.wait_for(all)).await.expect("told").expect("open");
    let maps = server.app().maps().expect("maps").list(false).await.expect("a list");
    assert!(!maps.sources.is_empty(), "maps are shown all the same");
    server.close().await;
    station.close().await;
}

#[test]
fn damaged_tokens_are_set_aside_and_wrong_ones_are_refused() {
    let folder = Folder::new();
    let path = folder.0.join("tokens.json");
    std::fs::write(&path, "").expect("written");
    let (tokens, fault) = Tokens::load_or_make(&path).expect("new ones");
    assert!(
        matches!(fault, Some(crate::dto::storage::StorageFault::SetAside { name }) if name == "tokens.json.broken")
    );
    let (again, fault) = Tokens::load_or_make(&path).expect("kept");
    assert!(again == tokens && fault.is_none());
    std::fs::write(&path, r#"{"viewer": "a", "operator": "b"}"#).expect("written");
    assert!(Tokens::load_or_make(&path).is_err(), "somebody wrote them by hand");
}

#[tokio::test]
async fn the_draft_of_a_plan_is_shared_and_a_race_for_it_is_told() {
    let station = station(true);
    let server = serve(&station, ServerConfig::default()).await;
    let plain =
        Plain { app: server.app().clone(), router: routes::router(server.app().clone()), _ended: mpsc::channel(1).1 };
    let ana = cookie(&server, "ana");
    let ben = cookie(&server, "ben");
    let mut socket = connect(&server, &ben, None).await.expect("a WebSocket");
    let put = |cookie: String, base: u32, author: &'static str, items: usize| {
        let body = json!({"base": base, "author": author, "plan": {"items": vec![1; items]}});
        let plain = &plain;
        async move { plain.ask("PUT", "/draft", Some(&cookie), Some(body)).await }
    };
    assert_eq!(plain.ask("GET", "/draft", Some(&ana), None).await.json(), json!({"current": null, "others": []}));
    let saved = put(ana.clone(), 0, "a", 2).await.json();
    assert_eq!((&saved["revision"], &saved["by"]), (&json!(1), &json!("ana")));
    let news = next(&mut socket, "draft").await.expect("told");
    assert_eq!((&news["revision"], &news["author"]), (&json!(1), &json!("a")));
    let refused = put(ben.clone(), 0, "b", 3).await;
    assert_eq!(
        (refused.status, &refused.json()["cause"]),
        (409, &json!({"code": "draft-conflict", "revision": 1, "by": "ana"}))
    );
    let both = plain.ask("GET", "/draft", Some(&ben), None).await.json();
    assert_eq!(both["current"]["plan"]["items"].as_array().map(Vec::len), Some(2));
    assert_eq!(
        (&both["others"][0]["by"], both["others"][0]["plan"]["items"].as_array().map(Vec::len)),
        (&json!("ben"), Some(3))
    );
    assert_eq!(plain.ask("PUT", "/draft", None, Some(json!({"base": 1, "author": "x", "plan": {}}))).await.status, 401);
    assert_eq!(plain.ask("DELETE", "/draft?base=0", Some(&ana), None).await.status, 409);
    assert_eq!(plain.ask("DELETE", "/draft?base=1", Some(&ana), None).await.status, 204);
    let large = json!({"base": 2, "author": "a", "plan": {"x": "y".repeat(2_000_000)}});
    assert_eq!(plain.ask("PUT", "/draft", Some(&ana), Some(large)).await.status, 413);
    server.close().await;
    station.close().await;
}
