//! What a plane says in ROS 2 when it happens: its texts, and the waypoints that it reaches.

use vencejo_station::Observed;
use vencejo_vehicle::VehicleEvent;

use super::cdr::Cdr;
use super::message::{Header, Message, StatusText, WaypointReached};
use super::moment::Moment;
use super::name::Names;

/// A topic of news: its name below the plane's, its type, and `RIHS01_…`.
pub type Topic = (&'static str, &'static str, &'static str);

const TOPICS: [Topic; 2] = [
    ("statustext/recv", StatusText::TYPE, StatusText::HASH),
    ("mission/reached", WaypointReached::TYPE, WaypointReached::HASH),
];

/// The topics of a plane's news.
pub fn topics(names: Names) -> &'static [Topic] {
    match names {
        Names::Mavros => &TOPICS,
        Names::ArduPilot => &[],
    }
}

/// What there is to say of an event: the number of the topic, and the message.
pub fn of(observed: &Observed, moment: &Moment<'_>) -> Option<(usize, Vec<u8>)> {
    let header = |at| Header { frame_id: String::new(), ..moment.header(at, "") };
    Some(match &observed.event {
        VehicleEvent::Text(text) => {
            let said = StatusText { header: header(text.at), severity: text.severity.0, text: text.text.clone() };
            (0, said.to_bytes())
        }
        VehicleEvent::ItemReached { seq } => {
            // Just now; `observed.at` is of the station's clock, which a replayed vehicle does not go by.
            (1, WaypointReached { header: header(moment.now), wp_seq: seq.0 }.to_bytes())
        }
        _ => return None,
    })
}
