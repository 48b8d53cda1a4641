//! GeoTIFFs that are read over the network in parts: the same picture as from the file, and servers that misbehave.

use super::*;

const ROOT: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../../tests/fixtures/maps");

fn fixture(name: &str) -> Vec<u8> {
    std::fs::read(format!("{ROOT}/{name}")).expect("a fixture")
}

/// First and last byte that a request asks for.
fn asked_range(head: &str) -> Option<(usize, usize)> {
    let line =
        head.lines().find_map(|line| line.to_ascii_lowercase().strip_prefix("range: bytes=").map(str::to_owned))?;
    let (first, last) = line.split_once('-')?;
    Some((first.parse().ok()?, last.parse().ok()?))
}

/// A part of a file as a server gives it.
fn part(file: &[u8], etag: &str, head: &str) -> Vec<u8> {
    let Some((first, last)) = asked_range(head) else { return answer("200 OK", "", file) };
    let end = (last + 1).min(file.len());
    let headers = format!("ETag: {etag}\r\nContent-Range: bytes {first}-{}/{}\r\n", end - 1, file.len());
    answer("206 Partial Content", &headers, &file[first..end])
}

fn cog(url: String) -> SourceSettings {
    SourceSettings {
        url: Some(url),
        role: Role::Overlay,
        local_network: true,
        ..SourceSettings::new("a", "A", SourceKind::Geotiff)
    }
}

async fn serving(file: Vec<u8>) -> (World, Service) {
    let service = Service::start(move |head| Some(part(&file, "\"1\"", head))).await;
    let world = world_with(Duration::from_millis(1500)).await;
    world.put(cog(service.url("field.tif"))).await;
    (world, service)
}

fn all_tiles(grid: &vencejo_maps::grid::TileGrid) -> Vec<TileId> {
    let tiles = |level: u8| {
        let [columns, rows] = grid.levels[usize::from(level)].size.expect("known");
        (0..rows).flat_map(move |row| (0..columns).map(move |column| TileId { level, column, row }))
    };
    (grid.min_level..=grid.max_level).flat_map(tiles).collect()
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_cog_shows_over_the_network_what_it_shows_from_the_disk() {
    for (name, tolerance) in
        [("cog-deflate.tif", 0), ("cog-lzw.tif", 0), ("cog-jpeg-mask.tif", 24), ("cog-none.tif", 0)]
    {
        let file = fixture(name);
        let (world, service) = serving(file.clone()).await;
        std::fs::write(world.folder.join("files/f.tif"), &file).expect("written");
        let local =
            SourceSettings { path: Some("files/f.tif".into()), ..SourceSettings::new("f", "F", SourceKind::Geotiff) };
        world.put(local).await;
        let shown = world.maps.describe("a").await.expect("there");
        let grid = shown.grid.expect("known");
        assert_eq!((grid.crs.code().as_str(), grid.max_level), ("EPSG:25830", 1), "{name}");
        assert!((shown.bounds.expect("known").north_deg - 40.333).abs() < 0.001, "{name}");
        assert!(shown.offline.allowed && shown.may_cache);
        let mut count = 0;
        for tile in all_tiles(&grid) {
            let (remote, local) = (world.maps.tile("a", tile).await, world.maps.tile("f", tile).await);
            assert_eq!(remote.as_ref().map(|tile| &tile.data), local.as_ref().map(|tile| &tile.data), "{name} {tile}");
            count += usize::from(remote.is_ok_and(|tile| tile.origin == Origin::Fetched));
        }
        assert!(count >= 3, "{name}: {count}");
        assert!(service.asked.lock().expect("lock").iter().all(|head| asked_range(head).is_some()), "{name}");
        assert!(service.count() <= 12, "{name}: {} requests", service.count());
        // The colours drawn: JPEG uses another colour model.
        let tile = world.maps.tile("a", TileId { level: 1, column: 0, row: 0 }).await.expect("a tile");
        assert_eq!(tile.origin, Origin::Hit);
        let picture = Raster::read(&tile.data, 1 << 20).expect("a picture");
        let near = |[x, y]: [u32; 2], wanted: [u8; 3]| {
            let [r, g, b, alpha] = picture.pixel(x, y);
            let is_near = [r, g, b].iter().zip(wanted).all(|(found, wanted)| found.abs_diff(wanted) <= tolerance);
            assert!(is_near && alpha == 255, "{name} {x} {y}: {:?} {wanted:?}", picture.pixel(x, y));
        };
        match name {
            "cog-none.tif" => near([40, 30], [30, 30, 30]),
            "cog-jpeg-mask.tif" => {
                near([150, 200], [230, 210, 40]);
                assert_eq!((picture.pixel(40, 30)[3], picture.pixel(99, 9)[3], picture.pixel(100, 9)[3]), (0, 0, 255));
            }
            _ => {
                near([40, 30], [220, 30, 30]);
                near([150, 200], [230, 210, 40]);
                near([240, 10], [40, 130, 60]);
            }
        }
    }
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_large_cog_is_read_in_parts() {
    // What lies between the head and the end is never asked for, however long it is.
    let mut file = fixture("cog-lzw.tif");
    file.resize(3_000_000, 0);
    let (world, service) = serving(file).await;
    assert!(world.maps.tile("a", TileId { level: 0, column: 0, row: 0 }).await.is_ok());
    let asked: usize = service
        .asked
        .lock()
        .expect("lock")
        .iter()
        .filter_map(|head| asked_range(head))
        .map(|(first, last)| last + 1 - first)
        .sum();
    assert!(asked < 200_000, "{asked}");
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_cog_is_asked_whether_it_changed_and_kept_for_the_field() {
    let (world, service) = serving(fixture("cog-deflate.tif")).await;
    let tile = TileId { level: 0, column: 0, row: 0 };
    let origin = async || world.maps.tile("a", tile).await.expect("a tile").origin;
    assert_eq!(origin().await, Origin::Fetched);
    let before = service.count();
    assert_eq!((origin().await, service.count()), (Origin::Hit, before));
    world.pass(8 * 86_400);
    assert_eq!((origin().await, service.count()), (Origin::Revalidated, before + 1), "one small part tells");
    let wanted = NewArea {
        source: "a".into(),
        name: "Field".into(),
        shape: Shape::Box(Bounds { west_deg: -3.9, south_deg: 40.2, east_deg: -3.7, north_deg: 40.4 }),
        min_level: 0,
        max_level: 1,
    };
    let made = world.maps.add_area(wanted).await.expect("made");
    let done = wait_state(&world.maps, &made.id, AreaState::Done).await;
    assert_eq!((done.done, done.failed), (5, 0));
    drop(service);
    world.maps.close();
    world.pass(30 * 86_400);
    let again = start(world.folder.clone(), &world.now_s, Duration::from_secs(5)).await;
    assert_eq!(again.describe("a").await.expect("there").grid.expect("known").crs.code(), "EPSG:25830");
    assert_eq!(again.tile("a", TileId { level: 1, ..tile }).await.expect("a tile").origin, Origin::Stale);
    again.close();
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_file_that_is_replaced_meanwhile_is_opened_anew_for_its_tiles() {
    let world = world().await;
    let path = world.folder.join("files/f.tif");
    std::fs::write(&path, fixture("cog-deflate.tif")).expect("written");
    let local =
        SourceSettings { path: Some("files/f.tif".into()), ..SourceSettings::new("f", "F", SourceKind::Geotiff) };
    world.put(local).await;
    world.maps.list(false).await.expect("listed");
    std::fs::write(&path, fixture("cog-none.tif")).expect("written");
    let tile = TileId { level: 1, column: 0, row: 0 };
    let error = world.maps.tile("f", tile).await.expect_err("another file");
    assert!(error.to_string().contains("replaced"), "{error}");
    // Without any listing of the sources, a tile request after some seconds reopens it.
    world.pass(5);
    world.maps.tile("f", tile).await.expect("opened anew");
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_cog_that_is_replaced_meanwhile_is_read_anew() {
    let file = fixture("cog-deflate.tif");
    let (world, service) = serving(file.clone()).await;
    let other = file.clone();
    service.now(move |head| Some(part(&other, "\"2\"", head)));
    let tile = TileId { level: 1, column: 0, row: 0 };
    // All of this small file came with the first part; the next minute it is looked at again.
    world.pass(61);
    assert_eq!(world.maps.tile("a", tile).await.expect("a tile").origin, Origin::Fetched);
    // Another area at the same address is another map.
    world.pass(61);
    let moved = fixture("cog-none.tif");
    service.now(move |head| Some(part(&moved, "\"3\"", head)));
    let error = world.maps.tile("a", TileId { level: 1, column: 1, row: 0 }).await.expect_err("moved");
    assert!(error.to_string().contains("replaced"), "{error}");
    // A file that changes with every part is reported.
    let mut long = fixture("cog-none.tif");
    long.resize(400_000, 0);
    let count = AtomicUsize::new(0);
    let restless = Service::start(move |head| {
        let number = count.fetch_add(1, Ordering::SeqCst);
        Some(part(&long, &format!("\"{number}\""), head))
    })
    .await;
    world.put(cog(restless.url("restless.tif"))).await;
    let error = world.maps.tile("a", tile).await.expect_err("restless");
    assert!(error.to_string().contains("changes while it is read"), "{error}");
    assert!(restless.count() <= 12, "{}", restless.count());
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn servers_that_give_no_parts_or_wrong_ones_are_told() {
    let file = fixture("cog-lzw.tif");
    let whole = file.clone();
    let cut = file.clone();
    let shifted = file.clone();
    let cases: Vec<(Behaviour, &str)> = vec![
        (Arc::new(move |_| Some(answer("200 OK", "", &whole))), "knows no Range requests"),
        (
            Arc::new(move |_| {
                let head = format!(
                    "HTTP/1.1 206 Part\r\nContent-Range: bytes 0-{}/{}\r\nContent-Length: {}\r\n\r\n",
                    cut.len() - 1,
                    cut.len(),
                    cut.len()
                );
                Some([head.as_bytes(), &cut[..100]].concat())
            }),
            "cut short",
        ),
        (
            Arc::new(move |_| {
                Some(answer("206 Part", &format!("Content-Range: bytes 5-99/{}\r\n", shifted.len()), &shifted[5..100]))
            }),
            "another part",
        ),
        (Arc::new(|_| Some(answer("206 Part", "", b"II*\0"))), "another part"),
        (Arc::new(|_| Some(answer("206 Part", "Content-Range: bytes 0-99/100\r\n", &[b'I'; 60]))), "cut short"),
        (Arc::new(|head| Some(part(&[7; 5000], "\"1\"", head))), "no TIFF"),
        (Arc::new(|_| Some(answer("416 No", "Content-Range: bytes */0\r\n", b""))), "empty"),
        (
            Arc::new(|_| Some(answer("302 Found", "Location: http://127.0.0.2:9/x\r\n", b""))),
            "an address inside this network",
        ),
        (Arc::new(|_| Some(answer("404 None", "", b"no such file"))), "404"),
        // A list of pieces that lies beyond all measure.
        (
            Arc::new(|head| {
                let mut file = vec![0; 200_000];
                file[..8].copy_from_slice(b"II*\0\xff\xff\xff\x7f");
                Some(part(&file, "\"1\"", head))
            }),
            "no TIFF",
        ),
    ];
    for (behaviour, said) in cases {
        let service = Service::start(move |head| behaviour(head)).await;
        let world = world_with(Duration::from_millis(1500)).await;
        world.put(cog(service.url("field.tif"))).await;
        let error = error(&world.maps).await;
        assert!(error.to_string().contains(said), "{said}: {error}");
        assert!(service.count() <= 6, "{said}: {}", service.count());
        assert!(world.state("a").await.detail.expect("why").contains(said), "{said}");
    }
    let both = SourceSettings { path: Some("files/a.tif".into()), ..cog("https://a.example/{z}.tif".into()) };
    assert_eq!(both.faults().len(), 2, "{:?}", both.faults());
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_file_that_is_handed_in_is_proposed_by_its_own_name() {
    let world = world().await;
    let mut upload = world.maps.begin_upload("field.tif").await.expect("begun");
    upload.write(&fixture("cog-jpeg-mask.tif")).await.expect("written");
    let (path, _, settings) = world.maps.end_upload(upload).await.expect("taken");
    assert_eq!((path.as_str(), settings.name.as_str(), settings.id.as_str()), ("files/field.tif", "field", "field"));
}
