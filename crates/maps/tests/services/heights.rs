//! Heights of the ground as the maps tell them: of files that are replaced, over water, above another datum.

use super::*;

/// An `.hgt` of so many heights a side, all of one height.
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
    world.pass(5);
    assert_eq!(at(&world, 40.5, -3.5).await, (Some(400.0), None));
    std::fs::write(world.folder.join("files/heights/N40W004.hgt"), level(1201, 500)).expect("written");
    assert_eq!(world.maps.check("heights").await.expect("a state").status, Status::Unused, "opened anew at once");
    assert_eq!(at(&world, 40.5, -3.5).await, (Some(500.0), None));
}
