//! Plans that a real ArduPlane took and gave back, against what this crate says that it keeps.
//!
//! `tests/fixtures/captures/*.tlog` hold whole conversations; `data/arduplane-stored-items.json` hundreds of
//! items with random parameters (origin in the file).

use std::path::Path;

use serde_json::Value;
use vencejo_flight::plan::{
    Fence, Keeping, MissionItem, PlanKind, Rally, ardupilot_stored, items_from_wire, plans_equal_as_stored,
};
use vencejo_proto::{Address, FrameDecoder, Message, MissionItemInt};

/// The items of one kind in a recording, by who sent them: the station's and the vehicle's.
fn recorded(file: &str, kind: PlanKind) -> (Vec<MissionItemInt>, Vec<MissionItemInt>) {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/fixtures/captures").join(file);
    let bytes = std::fs::read(path).expect("the capture is part of the repository");
    let mut decoder = FrameDecoder::new();
    let (mut station, mut vehicle) = (Vec::new(), Vec::new());
    // the 8-byte time before each frame is skipped as noise
    for chunk in bytes.chunks(256) {
        decoder.push(chunk);
        while let Some(frame) = decoder.next_frame() {
            let Ok(Message::MissionItemInt(item)) = frame.decode() else { continue };
            if item.mission_type == kind.mission_type() {
                let list = if frame.source().system.0 == 255 { &mut station } else { &mut vehicle };
                if list.iter().all(|known: &MissionItemInt| known.seq != item.seq) {
                    list.push(item);
                }
            }
        }
    }
    (station, vehicle)
}

fn items(wire: &[MissionItemInt], kind: PlanKind) -> Vec<MissionItem> {
    assert!(!wire.is_empty());
    items_from_wire(wire, kind).expect("a real vehicle sent it")
}

// fault 50: recorded missions read back as sent
#[test]
fn the_missions_read_back_are_the_missions_sent() {
    let (sent, _) = recorded("mission-upload-items.tlog", PlanKind::Mission);
    let (_, kept) = recorded("mission-download-items.tlog", PlanKind::Mission);
    assert_eq!((sent.len(), kept.len()), (12, 12));
    let kind = PlanKind::Mission;
    assert_eq!(plans_equal_as_stored(&items(&sent, kind), &items(&kept, kind), kind, Keeping::ARDUPILOT), Ok(()));

    let mut changed = items(&kept, kind);
    changed[4].params[6] = Some(100.5);
    assert_eq!(plans_equal_as_stored(&items(&sent, kind), &changed, kind, Keeping::ARDUPILOT).unwrap_err().len(), 1);
}

#[test]
fn the_fence_and_the_rally_points_read_back_are_those_sent() {
    for (kind, count) in [(PlanKind::Fence, 4), (PlanKind::Rally, 1)] {
        let (sent, kept) = recorded("fence-and-rally-upload.tlog", kind);
        let (sent, kept) = (items(&sent, kind), items(&kept, kind));
        assert_eq!((sent.len(), kept.len()), (count, count));
        assert_eq!(plans_equal_as_stored(&sent, &kept, kind, Keeping::ARDUPILOT), Ok(()));
        match kind {
            PlanKind::Fence => assert_eq!(Fence::from_items(&kept).unwrap().to_items(), sent),
            _ => assert_eq!(Rally::from_items(&kept).unwrap().to_items(), sent),
        }
    }
}

#[test]
fn random_items_are_kept_as_the_vehicle_kept_them() {
    let data: Value = serde_json::from_str(include_str!("data/arduplane-stored-items.json")).unwrap();
    let item = |row: &Value| {
        let float = |index: usize| row[index].as_f64().unwrap() as f32;
        let int = |index: usize| i32::try_from(row[index].as_i64().unwrap()).unwrap();
        let wire = MissionItemInt {
            target: Address::new(1, 1),
            seq: 1,
            frame: int(1) as u8,
            command: int(0) as u16,
            current: 0,
            autocontinue: 1,
            params: [float(2), float(3), float(4), float(5)],
            x: int(6),
            y: int(7),
            z: float(8),
            mission_type: 0,
        };
        MissionItem::from_wire(&wire).unwrap()
    };
    let home = MissionItem::waypoint(0.0, 0.0, 0.0);
    let mut wrong = Vec::new();
    let rows = data["sent_and_kept"].as_array().unwrap();
    for pair in rows {
        let (sent, kept) = (item(&pair[0]), item(&pair[1]));
        // the comparison forgives a centimetre, what we say that is kept must not need it
        if sent.has_position() {
            assert_eq!(ardupilot_stored(&sent).alt_m(), kept.alt_m(), "{pair}");
        }
        if let Err(differences) = plans_equal_as_stored(
            &[home.clone(), sent.clone()],
            &[home.clone(), kept],
            PlanKind::Mission,
            Keeping::ARDUPILOT,
        ) {
            wrong.push(format!("{pair}: {} (stored {:?})", differences[0], ardupilot_stored(&sent).params));
        }
    }
    assert!(rows.len() > 400);
    assert!(wrong.is_empty(), "{} of {}:\n{}", wrong.len(), rows.len(), wrong.join("\n"));
}
