//! What networks and services do to those who ask them: drip, cut, reset, speak something else, fail in between.

use super::*;

use tokio::io::AsyncWriteExt as _;

/// A service that does as it likes with its connections.
async fn raw<F>(address: &str, behave: impl Fn(TcpStream) -> F + Send + Sync + 'static) -> (SocketAddr, JoinHandle<()>)
where
    F: Future<Output = ()> + Send + 'static,
{
    let listener = TcpListener::bind(address).await.expect("a socket");
    let bound = listener.local_addr().expect("bound");
    let task = tokio::spawn(async move {
        while let Ok((mut stream, _)) = listener.accept().await {
            let mut head = [0; 4096];
            let _ = stream.read(&mut head).await;
            tokio::spawn(behave(stream));
        }
    });
    (bound, task)
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_service_that_drips_is_given_up() {
    let (address, task) = raw("127.0.0.1:0", |mut stream| async move {
        let _ = stream.write_all(b"HTTP/1.1 200 OK\r\nContent-Length: 100000\r\n\r\n").await;
        while stream.write_all(b"x").await.is_ok() {
            tokio::time::sleep(Duration::from_millis(20)).await;
        }
    })
    .await;
    let world = world_with(Duration::from_millis(300)).await;
    world.put(xyz(format!("http://{address}/{{z}}/{{x}}/{{y}}"))).await;
    let error = error(&world.maps).await;
    assert!(matches!(error, MapError::Timeout { .. }), "{error:?}");
    task.abort();
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_connection_that_is_reset_or_speaks_something_else_is_told() {
    let (reset, first) = raw("127.0.0.1:0", |mut stream| async move {
        let _ = stream.write_all(b"HTTP/1.1 200 OK\r\nContent-Length: 100000\r\n\r\nabc").await;
        // Dropped with the rest unread: the other side gets a reset.
        let _ = stream.set_zero_linger();
    })
    .await;
    // A settings frame of HTTP/2, which was not agreed upon.
    let (http2, second) = raw("127.0.0.1:0", |mut stream| async move {
        let _ = stream.write_all(&[0, 0, 0, 4, 0, 0, 0, 0, 0]).await;
    })
    .await;
    let headers = "X-Long: 1\r\n".repeat(20_000);
    let (many, third) = raw("127.0.0.1:0", move |mut stream| {
        let headers = headers.clone();
        async move {
            let _ = stream.write_all(format!("HTTP/1.1 200 OK\r\n{headers}\r\n").as_bytes()).await;
        }
    })
    .await;
    for (scheme, address, said) in [
        ("http", reset, "cut short"),
        ("http", http2, "broken"),
        ("http", many, "broken"),
        ("https", http2, "cannot be reached"),
    ] {
        let world = world_with(Duration::from_secs(5)).await;
        world.put(xyz(format!("{scheme}://{address}/{{z}}/{{x}}/{{y}}"))).await;
        let error = error(&world.maps).await;
        assert!(error.to_string().contains(said), "{scheme} {said}: {error}");
    }
    for task in [first, second, third] {
        task.abort();
    }
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_service_may_be_at_an_address_of_ipv6() {
    let (address, task) = raw("[::1]:0", |mut stream| async move {
        let _ = stream.write_all(&answer("200 OK", "", &png())).await;
        let _ = stream.shutdown().await;
    })
    .await;
    let world = world().await;
    world.put(xyz(format!("http://{address}/{{z}}/{{x}}/{{y}}"))).await;
    assert_eq!(world.maps.tile("a", TILE).await.expect("a tile").origin, Origin::Fetched);
    task.abort();
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn who_waits_for_a_silent_service_does_not_ask_it_again() {
    let service = Service::start(|_| None).await;
    let world = world_with(Duration::from_millis(1500)).await;
    world.put(SourceSettings { parallel: Some(4), ..xyz(service.url("{z}/{x}/{y}")) }).await;
    let wanted: Vec<_> = (0..40)
        .map(|number| {
            let maps = world.maps.clone();
            tokio::spawn(async move { maps.tile("a", TileId { level: 6, column: number, row: 1 }).await })
        })
        .collect();
    for tile in wanted {
        assert!(tile.await.expect("ended").expect_err("silent").is_network());
    }
    assert!(service.count() <= 12, "{}", service.count());
    // The number at once follows the settings without a new start.
    world.pass(61);
    service.now(|_| Some(answer("200 OK", "", &png())));
    service.most_at_once.store(0, Ordering::SeqCst);
    world.put(SourceSettings { parallel: Some(1), ..xyz(service.url("{z}/{x}/{y}")) }).await;
    let wanted: Vec<_> = (0..6)
        .map(|number| {
            let maps = world.maps.clone();
            tokio::spawn(async move { maps.tile("a", TileId { level: 6, column: number, row: 2 }).await })
        })
        .collect();
    for tile in wanted {
        assert!(tile.await.expect("ended").is_ok());
    }
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn what_was_seen_stays_when_the_service_has_it_no_more() {
    let service = Service::start(|_| Some(answer("200 OK", "Cache-Control: max-age=60\r\n", &png()))).await;
    let world = world().await;
    world.put(xyz(service.url("{z}/{x}/{y}"))).await;
    assert_eq!(world.maps.tile("a", TILE).await.expect("a tile").origin, Origin::Fetched);
    world.pass(61);
    service.now(|_| Some(answer("404 None", "", b"being repaired")));
    assert_eq!(world.maps.tile("a", TILE).await.expect("a tile").origin, Origin::Stale);
    // For a day it is not asked for again.
    assert_eq!((world.maps.tile("a", TILE).await.expect("a tile").origin, service.count()), (Origin::Hit, 2));
    world.pass(86_401);
    service.now(|_| Some(answer("200 OK", "", &png())));
    assert_eq!(world.maps.tile("a", TILE).await.expect("a tile").origin, Origin::Fetched);
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_cache_that_fails_does_not_make_the_map_blank() {
    let service = Service::start(|_| Some(answer("200 OK", "", &png()))).await;
    let world = world().await;
    world.put(xyz(service.url("{z}/{x}/{y}"))).await;
    let cache = std::fs::read_dir(world.folder.join("cache")).expect("a folder").flatten();
    let cache = cache.map(|file| file.path()).find(|path| path.extension().is_some_and(|end| end == "mbtiles"));
    let other = rusqlite::Connection::open(cache.expect("there")).expect("opened");
    other.execute_batch("DROP VIEW tiles; DROP TABLE images;").expect("broken");
    assert_eq!(world.maps.tile("a", TILE).await.expect("a tile").origin, Origin::Fetched);
    assert!(world.state("a").await.last_error.expect("told").contains("no such table"));
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn an_area_is_not_done_when_its_tiles_may_not_be_kept() {
    let service = Service::start(|_| Some(answer("200 OK", "Cache-Control: no-store\r\n", &png()))).await;
    let world = world().await;
    world.put(SourceSettings { max_zoom: Some(15), ..xyz(service.url("{z}/{x}/{y}")) }).await;
    let made = world.maps.add_area(area("Field")).await.expect("made");
    let failed = async {
        loop {
            let area = world.maps.area(&made.id).await.expect("there");
            if area.state != AreaState::Running {
                return area;
            }
            tokio::time::sleep(Duration::from_millis(5)).await;
        }
    };
    let ended = tokio::time::timeout(LIMIT, failed).await.expect("in time");
    assert_eq!(ended.done, 0);
    assert!(ended.detail.expect("why").contains("could not be kept"));
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn of_two_processes_one_fetches_an_area_and_either_may_pause_it() {
    let service = Service::start(|_| Some(answer("200 OK", "", &png()))).await;
    let world = world().await;
    world.put(SourceSettings { parallel: Some(1), ..xyz(service.url("{z}/{x}/{y}")) }).await;
    let gate = Arc::new(Notify::new());
    *service.gate.lock().expect("lock") = Some(gate.clone());
    let mut news = world.maps.news();
    let made = world.maps.add_area(area("Field")).await.expect("made");
    assert!(news.has_changed().expect("open"));
    wait_for(|| service.count() == 1).await;
    // Another one of the same folder goes on with what runs, as after a crash, but it does run.
    let other = start(world.folder.clone(), &world.now_s, Duration::from_secs(20)).await;
    assert_eq!(other.area(&made.id).await.expect("there").state, AreaState::Running);
    assert_eq!(other.pause_area(&made.id).await.expect("paused").state, AreaState::Paused);
    *service.gate.lock().expect("lock") = None;
    gate.notify_waiters();
    // The first one ends its batch, which is all of this small area or less, and leaves the state as it is.
    news.borrow_and_update();
    tokio::time::timeout(LIMIT, news.changed()).await.expect("in time").expect("open");
    assert_eq!(other.area(&made.id).await.expect("there").state, AreaState::Paused);
    other.resume_area(&made.id).await.expect("resumed");
    let done = wait_state(&other, &made.id, AreaState::Done).await;
    assert_eq!((done.done, service.count()), (done.tiles, done.tiles as usize), "each tile was fetched once");
    other.close();
}
