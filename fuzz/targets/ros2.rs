//! Arbitrary ROS 2 traffic: requests to a plane's services and positions to fly to (CDR), their attachments, and tokens.
#![no_main]

use std::collections::BTreeSet;

use libfuzzer_sys::fuzz_target;
use vencejo_fleet::ros2::cdr::Cdr;
use vencejo_fleet::ros2::doctor::examine;
use vencejo_fleet::ros2::message::GeoPoseStamped;
use vencejo_fleet::ros2::name::Names;
use vencejo_fleet::ros2::offer::{Done, Wish};
use vencejo_fleet::ros2::services::offers;
use vencejo_fleet::ros2::setpoint::Target;
use vencejo_fleet::ros2::token::{Attachment, Seen};

mod quick;
use quick::quick;

fuzz_target!(|data: &[u8]| quick(|| {
    let Some((&kind, bytes)) = data.split_first() else { return };
    match kind % 3 {
        0 => {
            for offer in [Names::Mavros, Names::ArduPilot].into_iter().flat_map(offers) {
                let ended = match (offer.read)(bytes) {
                    Ok(Wish::Mode(name)) => Ok(Done { words: name, count: u32::MAX, ..Done::default() }),
                    Ok(wish) => match wish.names() {
                        Some(names) => Ok(Done::without(names, "no")),
                        None => Ok(Done { words: format!("{wish:?}"), ..Done::default() }),
                    },
                    Err(error) => Err(error.to_string().into()),
                };
                assert!((offer.write)(&ended).starts_with(&[0, 1, 0, 0]));
            }
            if let Ok(message) = GeoPoseStamped::from_bytes(bytes) {
                let _ = Target::of(&message).request();
            }
        }
        1 => {
            if let Some(attachment) = Attachment::read(bytes) {
                assert_eq!(attachment.to_bytes(), bytes, "what is written is what was read");
            }
        }
        _ => {
            let seen: BTreeSet<Seen> = String::from_utf8_lossy(bytes).lines().filter_map(Seen::read).collect();
            let (nodes, findings) = examine(&seen, 0);
            assert!(nodes.len() <= seen.len());
            assert!(!findings.iter().any(|finding| finding.text.contains(char::is_control)));
        }
    }
}));
