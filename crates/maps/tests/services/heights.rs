//! Heights of the ground as the maps tell them: of files that are replaced, over water, above another datum.

use super::*;

/// An `.hgt` with `side` heights a side, all equal.
fn level(side: usize, alt_m: i16) -> Vec<u8> {
    alt_m.to_be_bytes().repeat(side * side)
}

/// Hands a file in, and puts the source that is proposed for it.
async fn hand_in(world: &World, name: &str, data: &[u8]) {
    let mut upload = world.maps.begin_upload(name).await.expect("begun");
    upload.write(data).await.expect("written");
    let (_, _, settings) = world.maps.end_upload(upload).await.expect("taken");
    world.put(settings).await;
}

async fn at(world: &World, lat_deg: f64, lon_deg: f64) -> (Option<f64>, Option<String>) {
    let (found, fault) = world.maps.heights(&[Corner { lat_deg, lon_deg }]).await.expect("asked");
    (found[0].alt_amsl_m, fault)
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_file_of_heights_is_read_as_it_is_now() {
    let world = world().await;
    hand_in(&world, "N40W004.hgt", &level(601, 100)).await;
    assert_eq!(at(&world, 40.5, -3.5).await, (Some(100.0), None));
    // One beside it, and one in its place: the settings that go with them are the same again.
    hand_in(&world, "N40W005.hgt", &level(601, 200)).await;
    assert_eq!(at(&world, 40.5, -4.5).await, (Some(200.0), None));
    hand_in(&world, "N40W004.hgt", &level(1201, 300)).await;
    assert_eq!(at(&world, 40.5, -3.5).await, (Some(300.0), None));
    let bounds = world.maps.describe("heights").await.expect("there").bounds.expect("known");
    assert_eq!((bounds.west_deg, bounds.east_deg), (-5.0, -3.0));

    // By hand: never by the size of the old one, and within seconds by its own.
    std::fs::write(world.folder.join("files/heights/N40W004.hgt"), level(601, 400)).expect("written");
    let (found, fault) = at(&world, 40.5, -3.5).await;
    assert_eq!(found, None);
    assert!(fault.expect("why").contains("replaced"));
    // Heights of the other file are known all the same, in one request too.
    let both = [-3.5, -4.5].map(|lon_deg| Corner { lat_deg: 40.5, lon_deg });
    let (found, fault) = world.maps.heights(&both).await.expect("asked");
    assert_eq!(found.iter().map(|point| point.alt_amsl_m).collect::<Vec<_>>(), [None, Some(200.0)]);
    assert!(fault.expect("why").contains("replaced"));
    world.pass(5);
    assert_eq!(at(&world, 40.5, -3.5).await, (Some(400.0), None));
    std::fs::write(world.folder.join("files/heights/N40W004.hgt"), level(1201, 500)).expect("written");
    assert_eq!(world.maps.check("heights").await.expect("a state").status, Status::Unused, "opened anew at once");
    assert_eq!(at(&world, 40.5, -3.5).await, (Some(500.0), None));
}

/// A place by the pixels of the whole world at zoom 3, from its west; rows are all the same.
fn pixel(column: f64) -> f64 {
    column / 2048.0 * 360.0 - 180.0
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn over_water_the_ground_is_the_waters_surface() {
    // From the west: land 4 m high, a shallow sea, a deep one.
    let service = Service::start(|_| {
        let mut raster = Raster::filled(256, 256, [0, 0, 0, 255]);
        for (x, y) in (0..256).flat_map(|x| (0..256).map(move |y| (x, y))) {
            let value = 32_768
                + if x < 76 {
                    4
                } else if x < 128 {
                    -60
                } else {
                    -4000
                };
            raster.set(x, y, [(value >> 8) as u8, value as u8, 0, 255]);
        }
        Some(answer("200 OK", "", &raster.to_png()))
    })
    .await;
    let world = world().await;
    let settings = terrarium_at(&service);
    let (land, shore, shallow, deep) = (pixel(1099.5), pixel(1100.0), pixel(1120.5), pixel(1200.5));
    for (below_sea_level, expected) in [(false, [4.0, 2.0, 0.0, 0.0]), (true, [4.0, -28.0, -60.0, 0.0])] {
        world.put(SourceSettings { below_sea_level, ..settings.clone() }).await;
        for (lon_deg, expected) in [land, shore, shallow, deep].into_iter().zip(expected) {
            let found = at(&world, 20.0, lon_deg).await.0.expect("known");
            assert!((found - expected).abs() < 1e-6, "{lon_deg}: {found} {expected} {below_sea_level}");
        }
    }
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn without_the_finest_level_a_coarser_one_that_is_there_is_taken() {
    let service = Service::start(|head| {
        // Level 10 has pixels of 153 m at the equator, level 9 of 306 m.
        let is_coarse = head.starts_with("GET /10/384/") || head.starts_with("GET /9/");
        Some(if is_coarse { answer("200 OK", "", &terrarium(0, 0)) } else { answer("500 No", "", b"broken") })
    })
    .await;
    let world = world().await;
    world.put(SourceSettings { min_zoom: Some(1), max_zoom: Some(12), ..terrarium_at(&service) }).await;
    // As an area has them that ends at level 10, and as far around it as there are coarser ones.
    for tile in [(10, 384, 387), (9, 192, 193), (9, 320, 193)] {
        let (level, column, row) = tile;
        world.maps.tile("a", TileId { level, column, row }).await.expect("a tile");
    }
    let asked = [-44.9, 45.1].map(|lon_deg| Corner { lat_deg: 40.0, lon_deg });
    let (found, fault) = world.maps.heights(&asked).await.expect("asked");
    assert!(found[0].alt_amsl_m.is_some(), "{found:?}");
    assert!((found[0].resolution_m.expect("known") - 152.87 * 40.0_f64.to_radians().cos()).abs() < 0.1);
    assert_eq!(found[1].alt_amsl_m, None, "too coarse to stand in");
    assert!(fault.expect("why the finest is missing").contains("broken"));
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn heights_above_an_ellipsoid_are_not_told_as_above_the_sea() {
    let world = world().await;
    for (folder, alt_m) in [("dsm", 570), ("srtm", 600)] {
        std::fs::create_dir_all(world.folder.join("files").join(folder)).expect("a folder");
        std::fs::write(world.folder.join("files").join(folder).join("N40W004.hgt"), level(601, alt_m))
            .expect("written");
    }
    // As it was written by hand before that was refused: the other sources of the file are used.
    let source = |id: &str, more: &str| {
        format!(
            "[[source]]\nid = \"{id}\"\nname = \"{id}\"\nkind = \"dem\"\nrole = \"elevation\"\npath = \"files/{id}\"\n{more}\n"
        )
    };
    let text = [source("dsm", "datum = \"WGS84 ellipsoid\""), source("srtm", "order = 10")].concat();
    std::fs::write(world.folder.join("sources.toml"), text).expect("written");
    let (found, fault) = at(&world, 40.5, -3.5).await;
    assert_eq!(found, Some(600.0));
    assert!(fault.expect("why").contains("gdalwarp"));
    let state = world.state("dsm").await;
    assert_eq!(state.status, Status::Invalid);
    assert!(state.detail.expect("why").contains("ellipsoid"));
    let configured = world.maps.configuration().await.expect("read").sources.remove(0);
    let refused = world.maps.put(configured.clone()).await.expect_err("refused").to_string();
    assert!(refused.contains("datum:") && refused.contains("WGS84 ellipsoid"), "{refused}");
    world.put(SourceSettings { datum: Some("EGM2008".into()), ..configured }).await;
    assert_eq!(at(&world, 40.5, -3.5).await, (Some(570.0), None));
}
