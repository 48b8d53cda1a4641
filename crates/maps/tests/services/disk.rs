//! What becomes of the maps when the disk is full or cannot be written, and when two instances share a folder.

use super::*;

use vencejo_maps::FolderProblem;
use vencejo_store::{Floors, Space};

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn two_instances_on_one_folder_lose_no_source() {
    let (folder, now_s) = (folder(), Arc::new(AtomicI64::new(1_800_000_000)));
    let two = [start(folder.clone(), &now_s, LIMIT).await, start(folder.clone(), &now_s, LIMIT).await];
    let at_first = two[0].list(false).await.expect("a list").sources.len();
    let writers = two.iter().cloned().enumerate().map(|(instance, maps)| {
        tokio::spawn(async move {
            for number in 0..60 {
                let id = format!("s{instance}-{number}");
                let mut settings = SourceSettings::new(&*id, &*id, SourceKind::Xyz);
                settings.url = Some("https://tiles.example/{z}/{x}/{y}".to_owned());
                settings.key = (number == 0).then(|| "secret".to_owned());
                maps.put(settings).await.expect("put");
            }
        })
    });
    for writer in writers.collect::<Vec<_>>() {
        writer.await.expect("no panic");
    }
    for maps in &two {
        let listed = maps.list(false).await.expect("a list");
        assert_eq!((listed.sources.len(), listed.file_error), (at_first + 120, None));
    }
    // What the other added is here at once, to be changed and removed, and its key stays when it is not said again.
    let mut other = SourceSettings::new("s0-0", "renamed", SourceKind::Xyz);
    other.url = Some("https://tiles.example/{z}/{x}/{y}".to_owned());
    two[1].put(other).await.expect("put");
    let text = std::fs::read_to_string(folder.join("sources.toml")).expect("read");
    assert_eq!(text.matches("key = \"secret\"").count(), 2, "{text}");
    two[1].remove("s0-1", false).await.expect("removed");
    assert_eq!(two[0].list(false).await.expect("a list").sources.len(), at_first + 119);
    for maps in &two {
        maps.close();
    }
    std::fs::remove_dir_all(folder).expect("removed");
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn maps_are_shown_where_nothing_can_be_written() {
    let (folder, now_s) = (folder(), Arc::new(AtomicI64::new(1_800_000_000)));
    std::fs::create_dir_all(&folder).expect("a folder");
    std::fs::write(folder.join("no-folder"), "a file in its place").expect("written");
    let maps = start(folder.join("no-folder/maps"), &now_s, LIMIT).await;
    let listed = maps.list(true).await.expect("a list");
    assert!(!listed.sources.is_empty() && listed.sources.iter().all(|source| source.state.status == Status::Unused));
    assert!(matches!(&maps.problems()[..], [FolderProblem::Unwritable(_)]), "{:?}", maps.problems());
    assert!(matches!(maps.put(xyz("https://t.example/{z}/{x}/{y}".to_owned())).await, Err(MapError::Storage(_))));
    assert!(maps.begin_upload("a.mbtiles").await.is_err());
    maps.close();
    std::fs::remove_dir_all(folder).expect("removed");
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn below_the_floor_tiles_are_shown_and_nothing_is_kept() {
    let service = Service::start(|_| Some(answer("200 OK", "", &png()))).await;
    let (folder, now_s, free_mb) = (folder(), Arc::new(AtomicI64::new(1_800_000_000)), Arc::new(AtomicU64::new(1_999)));
    let told_by = free_mb.clone();
    let mut config = MapsConfig::new(folder.clone());
    let clock = now_s.clone();
    config.clock = Arc::new(move || clock.load(Ordering::SeqCst));
    config.space = Space::with_probe(Floors::default(), move |_| Ok(told_by.load(Ordering::SeqCst) * 1_000_000));
    let maps = Maps::start(config).await.expect("maps");
    maps.put(xyz(service.url("{z}/{x}/{y}"))).await.expect("settings are small");
    for _ in 0..2 {
        let tile = maps.tile("a", TILE).await.expect("shown");
        assert_eq!(tile.origin, Origin::Fetched);
    }
    assert!(matches!(&maps.problems()[..], [FolderProblem::LowSpace(_)]), "{:?}", maps.problems());
    assert!(matches!(maps.begin_upload("a.mbtiles").await, Err(MapError::LowSpace(_))));
    assert!(matches!(maps.add_area(area("Field")).await, Err(MapError::LowSpace(_))));
    free_mb.store(2_000, Ordering::SeqCst);
    now_s.fetch_add(3600, Ordering::SeqCst);
    assert_eq!(maps.tile("a", TILE).await.expect("shown").origin, Origin::Fetched);
    assert_ne!(maps.tile("a", TILE).await.expect("shown").origin, Origin::Fetched, "kept now");
    assert!(maps.problems().is_empty());
    let mut upload = maps.begin_upload("a.mbtiles").await.expect("begun");
    free_mb.store(1_000, Ordering::SeqCst);
    assert!(matches!(upload.write(b"x").await, Err(MapError::LowSpace(_))), "also in the middle");
    maps.close();
    drop(maps);
    std::fs::remove_dir_all(folder).expect("removed");
}
