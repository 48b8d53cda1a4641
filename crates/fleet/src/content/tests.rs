//! Tests of lists, their parts, and where they are kept.

use rand::rngs::SmallRng;
use rand::seq::SliceRandom;
use rand::{Rng, SeedableRng};

use super::*;

fn mission(count: usize) -> Mission {
    let mut items: Vec<_> = (0..count)
        .map(|n| MissionItem::waypoint(40.0 + n as f64 * 1.123_456_789e-4, -3.7 - n as f64 * 1e-4, 80.1))
        .collect();
    if let Some(item) = items.get_mut(1) {
        item.params[3] = None;
        item.autocontinue = false;
        item.frame = MavFrame::Other(7);
    }
    Mission { home: Some(Home { lat_deg: 40.1, lon_deg: -3.7, alt_amsl_m: 612.34 }), items }
}

fn noise(length: usize, seed: u64) -> Vec<u8> {
    let mut rng = SmallRng::seed_from_u64(seed);
    (0..length).map(|_| rng.random()).collect()
}

#[test]
fn lists_come_out_as_they_went_in() {
    for count in [0, 1, 650, MAX_ITEMS] {
        let list = mission(count);
        let packed = pack_items(&list);
        assert_eq!(unpack_items(&packed), Ok(list), "{count} items in {} bytes", packed.len());
        assert!(packed.len() <= MAX_PACKED && (count != 650 || packed.len() < 16_000), "{}", packed.len());
    }
    let values = [ParamValue::F32(0.1), ParamValue::I32(i32::MIN), ParamValue::U32(u32::MAX), ParamValue::I8(-1)];
    let name = |index| ParamName::new(&format!("PARAM_{index}")).expect("a name");
    let params: Vec<_> = (0..1400).map(|index| Param::new(name(index), values[index % values.len()])).collect();
    assert_eq!(unpack_params(&pack_params(&params)), Ok(params.clone()));
    assert_eq!(OneParam::from(&params[1]).read(), Ok(params[1]));
}

#[test]
fn what_cannot_be_is_not_read() {
    for bytes in [&b""[..], b"nonsense", &noise(300, 1)] {
        assert!(unpack_items(bytes).is_err() && unpack_params(bytes).is_err());
    }
    let bomb = pack(&Items { version: VERSION, params: vec![0.0; MAX_UNPACKED], ..Items::default() });
    assert!(bomb.len() < MAX_PACKED && matches!(unpack_items(&bomb), Err(BadPayload::TooLarge(_))));
    assert!(matches!(unpack_items(&vec![0; MAX_PACKED + 1]), Err(BadPayload::TooLarge(_))));
    let torn = Items { version: VERSION, command: vec![16; 2], params: vec![0.0; 14], ..Items::default() };
    assert_eq!(unpack_items(&pack(&torn)), Err(BadPayload::Field("items")));
    let odd = OneParam { name: "A".into(), kind: 9, value: f64::NAN };
    assert_eq!(odd.read(), Err(BadPayload::Field("parameter value")));
    assert!(OneParam { kind: 10, value: 1.0, ..odd.clone() }.read().is_err());
    assert!(OneParam { name: "a b".into(), value: 1.0, ..odd }.read().is_err());
    let content = Content::of(b"list".to_vec());
    assert!(content.name().is_ok());
    assert!(Content { here: b"life".to_vec(), ..content.clone() }.name().is_err());
    assert!(Content { length: 0, ..content.clone() }.name().is_err());
    assert_eq!(content.clone().at_most(3).here, b"");
    assert_eq!(Digest::from_text(&Digest::of(b"list").to_string()), Some(Digest::of(b"list")));
}

#[test]
fn parts_make_a_list_in_any_order_and_no_other() {
    let (ana, ben) = (PublicKey([1; 32]), PublicKey([2; 32]));
    let list = noise(5 * PART_BYTES + 17, 2);
    let mut tray = Tray::default();
    for seed in 0..50 {
        let mut parts = Part::all_of(&list);
        parts.extend(parts.clone());
        parts.shuffle(&mut SmallRng::seed_from_u64(seed));
        let whole: Vec<_> = parts.iter().filter_map(|part| tray.on_part(ana, part).expect("a part of it")).collect();
        assert!(!whole.is_empty() && whole.iter().all(|whole| *whole == list), "seed {seed}");
        tray = Tray::default();
    }
    let mut parts = Part::all_of(&list);
    parts[3].bytes[5] ^= 1;
    let ends: Vec<_> = parts.iter().map(|part| tray.on_part(ana, part)).collect();
    assert!(matches!(ends.last(), Some(Err(BadPayload::Content(_)))), "not what it says");
    let good = Part::all_of(&list);
    for part in &good[1..] {
        assert_eq!(tray.on_part(ana, part), Ok(None));
    }
    assert_eq!(tray.on_part(ben, &good[0]), Ok(None), "another's parts are another list");
    assert_eq!(tray.on_part(ana, &good[0]), Ok(Some(list)));
    let odd = |change: &dyn Fn(&mut Part)| {
        let mut part = good[0].clone();
        change(&mut part);
        Tray::default().on_part(ana, &part)
    };
    assert!(odd(&|part| part.length = u32::MAX).is_err());
    assert!(odd(&|part| part.offset = 1).is_err());
    assert!(odd(&|part| part.bytes.push(0)).is_err());
    assert!(odd(&|part| part.digest = vec![]).is_err());
}

#[test]
fn a_shelf_and_a_tray_have_an_end() {
    let mut shelf = Shelf::default();
    let first = shelf.put(b"first");
    for number in 0..MAX_KEPT - 1 {
        shelf.put(number.to_string().as_bytes());
    }
    assert!(shelf.get(&first).is_some(), "asked for, it is new again");
    shelf.put(b"one more");
    assert!(shelf.get(&first).is_some() && shelf.get(&Digest::of(b"0")).is_none());
    let mut tray = Tray::default();
    for number in 0..50 {
        let parts = Part::all_of(&noise(2 * PART_BYTES, number));
        let of = PublicKey([u8::try_from(number % 9).expect("small"); 32]);
        assert_eq!(tray.on_part(of, &parts[0]), Ok(None));
    }
    assert_eq!(tray.0.len(), MAX_ARRIVING);
}
