//! The hub, its feeds and the viewers' queues, by plain calls.

use std::time::Duration;

use tokio::time::{advance, timeout};

use crate::queue::{MAX_BYTES, MAX_WAIT};
use crate::*;

fn picture(codec: VideoCodec, is_key: bool, data: &[u8]) -> Picture<'_> {
    Picture { codec, is_key, width: 640, height: 480, captured_unix_us: 1_700_000_000_000_000, data }
}

fn live(codec: VideoCodec) -> CameraStatus {
    CameraStatus { state: CameraState::Live, codec: Some(codec), ..CameraStatus::default() }
}

/// First data byte of each waiting image.
fn waiting(queue: &ViewerQueue) -> Vec<u8> {
    std::iter::from_fn(|| queue.take())
        .filter_map(|outgoing| match outgoing {
            Outgoing::Picture(bytes) => Some(bytes[HEADER_BYTES]),
            Outgoing::Status | Outgoing::End => None,
        })
        .collect()
}

const SHOWS_H264: Accepts = Accepts { h264: true };
const SHOWS_JPEG: Accepts = Accepts { h264: false };

#[test]
fn the_header_is_as_described() {
    let bytes = WireFrame::new(&picture(VideoCodec::H264, true, b"code"), 7).bytes;
    let expected: Vec<u8> = [
        &[1, 1, 1, 0][..],
        &[0x80, 0x02, 0xe0, 0x01],
        &1_700_000_000_000_000_u64.to_le_bytes(),
        &[7, 0, 0, 0],
        b"code",
    ]
    .concat();
    assert_eq!(bytes, expected);
}

#[tokio::test]
async fn who_comes_begins_at_the_last_key_frame() {
    let hub = VideoHub::default();
    let feed = hub.add("nose", "test").expect("added");
    feed.set_status(live(VideoCodec::H264));
    let camera = hub.camera("nose").expect("there");
    let early = camera.watch(SHOWS_H264);
    for (is_key, data) in [(false, [0]), (true, [1]), (false, [2]), (true, [3]), (false, [4])] {
        feed.publish(&picture(VideoCodec::H264, is_key, &data)).expect("published");
    }
    assert_eq!(waiting(&early), [1, 2, 3, 4], "nothing before a key frame");
    let late = camera.watch(SHOWS_H264);
    assert_eq!(waiting(&late), [3, 4]);
    feed.publish(&picture(VideoCodec::H264, false, &[5])).expect("published");
    assert_eq!((waiting(&early), waiting(&late)), (vec![5], vec![5]));
    assert_eq!(hub.viewers(), 2);
    drop(early);
    assert_eq!(hub.viewers(), 1);
}

#[tokio::test]
async fn the_first_picture_is_for_who_comes_next_too() {
    for codec in [VideoCodec::Jpeg, VideoCodec::H264] {
        let hub = VideoHub::default();
        let feed = hub.add("nose", "test").expect("added");
        let camera = hub.camera("nose").expect("there");
        let early = camera.watch(SHOWS_H264);
        feed.publish(&picture(codec, true, &[1])).expect("published");
        feed.set_status(live(codec));
        assert_eq!(waiting(&camera.watch(SHOWS_H264)), [1], "{codec:?} that came before it was said to come");
        assert_eq!(waiting(&early), [1], "{codec:?} to who was there already");
        let other = if codec == VideoCodec::H264 { VideoCodec::Jpeg } else { VideoCodec::H264 };
        feed.set_status(live(other));
        assert!(waiting(&camera.watch(SHOWS_H264)).is_empty(), "{codec:?} is of another stream");
        feed.publish(&picture(other, true, &[2])).expect("published");
        feed.set_status(CameraStatus { state: CameraState::Dead, ..CameraStatus::default() });
        assert!(waiting(&camera.watch(SHOWS_H264)).is_empty(), "nothing of a camera that is gone");
    }
}

#[tokio::test]
async fn each_is_sent_what_it_can_show() {
    let hub = VideoHub::default();
    let feed = hub.add("nose", "test").expect("added");
    let camera = hub.camera("nose").expect("there");
    let (modern, plain) = (camera.watch(SHOWS_H264), camera.watch(SHOWS_JPEG));
    assert_eq!(feed.demand(), Demand { h264: 0, jpeg: 2 }, "JPEG as long as nothing else is known");
    feed.set_status(live(VideoCodec::H264));
    assert_eq!(feed.demand(), Demand { h264: 1, jpeg: 1 });
    feed.publish(&picture(VideoCodec::H264, true, &[1])).expect("published");
    feed.publish(&picture(VideoCodec::Jpeg, true, &[2])).expect("published");
    assert_eq!((waiting(&modern), waiting(&plain)), (vec![1], vec![2]));
    feed.set_status(live(VideoCodec::Jpeg));
    feed.publish(&picture(VideoCodec::Jpeg, true, &[3])).expect("published");
    assert_eq!((waiting(&modern), waiting(&plain)), (vec![3], vec![3]));
}

#[tokio::test(start_paused = true)]
async fn a_slow_viewer_goes_on_at_the_next_key_frame_and_the_others_get_everything() {
    let hub = VideoHub::default();
    let feed = hub.add("nose", "test").expect("added");
    feed.set_status(live(VideoCodec::H264));
    let camera = hub.camera("nose").expect("there");
    let (slow, quick) = (camera.watch(SHOWS_H264), camera.watch(SHOWS_H264));
    let mut seen = Vec::new();
    for number in 0..100_u8 {
        feed.publish(&picture(VideoCodec::H264, number % 60 == 0, &[number])).expect("published");
        seen.extend(waiting(&quick));
        advance(MAX_WAIT / 50).await;
    }
    assert_eq!(seen, (0..100).collect::<Vec<u8>>());
    let late = waiting(&slow);
    assert_eq!(late.first(), Some(&60), "{late:?}");
    assert_eq!(slow.dropped() + late.len() as u64, 100);
    assert_eq!(quick.dropped(), 0);
}

#[tokio::test]
async fn of_still_pictures_the_newest_waits_and_too_much_is_never_kept() {
    let hub = VideoHub::default();
    let feed = hub.add("nose", "test").expect("added");
    feed.set_status(live(VideoCodec::Jpeg));
    let camera = hub.camera("nose").expect("there");
    let viewer = camera.watch(SHOWS_JPEG);
    for number in 0..10 {
        feed.publish(&picture(VideoCodec::Jpeg, true, &[number])).expect("published");
    }
    assert_eq!((waiting(&viewer), viewer.dropped()), (vec![9], 9));
    feed.set_status(live(VideoCodec::H264));
    let viewer = camera.watch(SHOWS_H264);
    let large = vec![1_u8; MAX_BYTES / 2];
    for is_key in [true, false, false, false] {
        feed.publish(&picture(VideoCodec::H264, is_key, &large)).expect("published");
    }
    assert!(waiting(&viewer).len() <= 1, "dropped with what it built on");
}

#[tokio::test]
async fn what_cannot_be_is_refused() {
    let hub = VideoHub::default();
    for name in ["", "a/b", "..", "a b", "ñ", &"x".repeat(MAX_NAME + 1)] {
        assert!(matches!(hub.add(name, "test"), Err(CameraError::BadName(_))), "{name}");
    }
    let feed = hub.add("nose", "test").expect("added");
    assert_eq!(hub.add("nose", "test").err(), Some(CameraError::Taken("nose".into())));
    assert_eq!(feed.publish(&picture(VideoCodec::Jpeg, true, b"")), Err(CameraError::BadPicture(0)));
    let others: Vec<_> =
        (1..MAX_CAMERAS).map(|number| hub.add(&format!("c{number}"), "test").expect("added")).collect();
    assert_eq!(hub.add("more", "test").err(), Some(CameraError::TooMany));
    drop(others);
    assert_eq!(hub.cameras().len(), 1);
    feed.close();
    feed.close();
    assert!(hub.camera("nose").is_none());
    assert_eq!(feed.publish(&picture(VideoCodec::Jpeg, true, b"x")), Err(CameraError::Gone));
}

#[tokio::test]
async fn requests_reach_the_feeder_and_end_with_it() {
    let hub = VideoHub::default();
    let feed = hub.add("nose", "test").expect("added");
    let camera = hub.camera("nose").expect("there");
    let (answer, ()) = tokio::join!(camera.ask(CameraRequest::Snapshot), async {
        let request = feed.next_request().await.expect("a request");
        assert_eq!(request.request, CameraRequest::Snapshot);
        request.answer(Ok(b"jpeg".to_vec()));
    });
    assert_eq!(answer, Ok(b"jpeg".to_vec()));
    let (answer, ()) = tokio::join!(camera.ask(CameraRequest::StartRecording), async {
        feed.next_request().await.expect("a request").answer(Err("the disk is full".into()));
    });
    assert_eq!(answer, Err(CameraError::Refused("the disk is full".into())));
    let (answer, ()) = tokio::join!(camera.ask(CameraRequest::Snapshot), async {
        drop(feed.next_request().await);
    });
    assert_eq!(answer, Err(CameraError::Gone), "an answer that was never given is none");
    let (left, ()) = tokio::join!(camera.ask(CameraRequest::Snapshot), async { feed.close() });
    assert_eq!(left, Err(CameraError::Gone));
    assert!(timeout(Duration::from_secs(20), feed.next_request()).await.expect("at once").is_none());
    assert_eq!(camera.ask(CameraRequest::Snapshot).await, Err(CameraError::Gone));
}
