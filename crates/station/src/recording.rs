//! The contents of a `.tlog` recording: senders, messages, and the events of the flight.
//!
//! The events come from the state machines that follow a live vehicle, driven here by the recording's clock.

use std::collections::BTreeMap;
use std::io::{self, Read};
use std::time::Duration;

use vencejo_flight::rehearsal::Learner;
use vencejo_link::TlogReader;
use vencejo_proto::dialect::MavMessage;
use vencejo_proto::{Address, Message, MonoTime, SystemId, message_name};
use vencejo_vehicle::telemetry::Telemetry;
use vencejo_vehicle::{Output, RegistryOutput, VehicleConfig, VehicleEvent, VehicleId, Vehicles};

/// Most message kinds counted separately; frames of further kinds, which come from noise only, are counted together.
pub const MAX_MESSAGE_KINDS: usize = 1024;
/// Events kept, the oldest; later ones are only counted.
pub const MAX_EVENTS: usize = 20_000;
/// Most deadlines processed between two frames before time jumps.
const MAX_STEPS: usize = 64;

/// Largest recording that a flight is read from, bytes: some hours.
pub const MAX_FLIGHT_BYTES: u64 = 256 * 1024 * 1024;

/// What is in a recording.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct RecordingSummary {
    /// Whole frames.
    pub frames: u64,
    /// Bytes that belong to no whole entry.
    pub skipped_bytes: u64,
    /// Of the first frame, microseconds since the UNIX epoch.
    pub start_unix_us: Option<u64>,
    /// From the first frame to the last.
    pub duration: Duration,
    /// Frames by sender.
    pub senders: BTreeMap<Address, Sender>,
    /// Frames by message; one that the dialect does not know is named by its number.
    pub messages: BTreeMap<String, u64>,
    /// What happened to the vehicles, in order.
    pub events: Vec<RecordedEvent>,
    /// Number of events beyond those kept.
    pub events_left_out: u64,
}

/// A sender.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Sender {
    /// Frames.
    pub frames: u64,
    /// `MAV_TYPE` and `MAV_AUTOPILOT` of its heartbeats.
    pub kind: Option<(u8, u8)>,
}

/// Something that happened to a vehicle.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct RecordedEvent {
    /// Since the first frame.
    pub at: Duration,
    /// The vehicle.
    pub system: SystemId,
    /// Stable name, such as `mode` or `item_reached`.
    pub kind: &'static str,
    /// In words.
    pub text: String,
}

/// Reads a whole recording, in any condition.
///
/// # Errors
/// When `source` cannot be read; damaged bytes are skipped and counted.
pub fn summarize_recording(source: impl Read) -> io::Result<RecordingSummary> {
    let mut reader = TlogReader::new(source);
    let mut summary = RecordingSummary::default();
    // An unused address, so that a recorded ground station counts as another station.
    let mut vehicles = Vehicles::new(Address::new(255, 0), VehicleConfig::default());
    let mut now = MonoTime::ZERO;
    for entry in reader.by_ref() {
        let entry = entry?;
        let start_us = *summary.start_unix_us.get_or_insert(entry.unix_us);
        now = now.max(MonoTime::from_micros(entry.unix_us.saturating_sub(start_us)));
        let source = entry.frame.source();
        summary.frames += 1;
        summary.count_message(entry.frame.message_id());
        let sender = summary.senders.entry(source).or_default();
        sender.frames += 1;
        let Ok(message) = entry.frame.decode() else { continue };
        if let Message::Heartbeat(heartbeat) = &message {
            sender.kind = Some((heartbeat.mav_type, heartbeat.autopilot));
        }
        pass_time(&mut vehicles, now);
        vehicles.on_message(source, &message, now);
        summary.take_events(&mut vehicles, now);
    }
    summary.duration = now.since(MonoTime::ZERO);
    summary.skipped_bytes = reader.skipped().total();
    Ok(summary)
}

/// The flight of a recording's first vehicle, or of the vehicle with this id, for learning its performance; the last
/// flight where the vehicle restarted in between.
///
/// # Errors
/// When `source` cannot be read, and when it has more than [`MAX_FLIGHT_BYTES`].
pub fn recorded_flight(source: impl Read, system: Option<SystemId>) -> io::Result<Learner> {
    flight_within(MAX_FLIGHT_BYTES, source, system)
}

fn flight_within(most: u64, source: impl Read, system: Option<SystemId>) -> io::Result<Learner> {
    let mut source = source.take(most + 1);
    let flight = flight_in(&mut source, system)?;
    if source.limit() == 0 {
        let problem = format!("the recording has more than {most} bytes; cut out the flight that is to be read");
        return Err(io::Error::other(problem));
    }
    Ok(flight)
}

fn flight_in(source: impl Read, system: Option<SystemId>) -> io::Result<Learner> {
    let mut vehicles = Vehicles::new(Address::new(255, 0), VehicleConfig::default());
    let mut flight = Learner::of_recording();
    let (mut chosen, mut start_us) = (system, None);
    for entry in TlogReader::new(source) {
        let entry = entry?;
        let Ok(message) = entry.frame.decode() else { continue };
        let start_us = *start_us.get_or_insert(entry.unix_us);
        let now = MonoTime::from_micros(entry.unix_us.saturating_sub(start_us));
        vehicles.on_message(entry.frame.source(), &message, now);
        while vehicles.poll_output().is_some() {}
        let Message::Dialect(MavMessage::GLOBAL_POSITION_INT(_)) = &message else { continue };
        let system = *chosen.get_or_insert(entry.frame.source().system);
        if entry.frame.source().system != system {
            continue;
        }
        if let Some(moment) = vehicles.get(system).and_then(|vehicle| vehicle.telemetry().recorded(now)) {
            flight.note(moment);
        }
    }
    Ok(flight)
}

/// Telemetry of one vehicle of a recording, sampled while it is read.
pub struct RecordedTelemetry<R> {
    entries: TlogReader<R>,
    vehicles: Vehicles,
    /// The vehicle; the first that is heard when absent.
    wanted: Option<VehicleId>,
    start_us: Option<u64>,
    now: MonoTime,
    period: Duration,
    /// When the next sample may be taken.
    due: MonoTime,
    /// Whether something has arrived since the last sample.
    is_behind: bool,
}

impl<R: Read> RecordedTelemetry<R> {
    /// Samples of a vehicle, by default of the first that is heard: one when something new has arrived, but at most one
    /// in each `period`, and one of the end.
    pub fn new(source: R, wanted: Option<VehicleId>, period: Duration) -> Self {
        Self {
            entries: TlogReader::new(source),
            vehicles: Vehicles::new(Address::new(255, 0), VehicleConfig::default()),
            wanted,
            start_us: None,
            now: MonoTime::ZERO,
            period,
            due: MonoTime::ZERO,
            is_behind: false,
        }
    }

    fn sample(&mut self) -> Option<(MonoTime, Telemetry)> {
        self.is_behind = false;
        Some((self.now, *self.vehicles.get(self.wanted?)?.telemetry()))
    }
}

/// Samples, and their times since the first frame.
impl<R: Read> Iterator for RecordedTelemetry<R> {
    type Item = io::Result<(MonoTime, Telemetry)>;

    fn next(&mut self) -> Option<Self::Item> {
        loop {
            let entry = match self.entries.next() {
                Some(Ok(entry)) => entry,
                Some(Err(error)) => return Some(Err(error)),
                None if self.is_behind => return self.sample().map(Ok),
                None => return None,
            };
            let start_us = *self.start_us.get_or_insert(entry.unix_us);
            self.now = self.now.max(MonoTime::from_micros(entry.unix_us.saturating_sub(start_us)));
            let Ok(message) = entry.frame.decode() else { continue };
            pass_time(&mut self.vehicles, self.now);
            self.vehicles.on_message(entry.frame.source(), &message, self.now);
            while self.vehicles.poll_output().is_some() {}
            let first = || self.vehicles.iter().next().map(|(id, _)| id);
            let Some(id) = self.wanted.or_else(first) else { continue };
            self.wanted = Some(id);
            self.is_behind |= id.system() == Some(entry.frame.source().system);
            if self.is_behind
                && self.now >= self.due
                && let Some(sample) = self.sample()
            {
                self.due = (self.due + self.period).max(self.now);
                return Some(Ok(sample));
            }
        }
    }
}

/// Processes every deadline until `now` in order, so that a silence is noticed; their number is bounded, whatever the
/// recording's clock does.
fn pass_time(vehicles: &mut Vehicles, now: MonoTime) {
    for _ in 0..MAX_STEPS {
        match vehicles.deadline() {
            Some(deadline) if deadline < now => vehicles.on_time(deadline),
            _ => break,
        }
    }
    vehicles.on_time(now);
}

impl RecordingSummary {
    fn count_message(&mut self, id: u32) {
        let known = message_name(id).map_or_else(|| format!("message {id}"), str::to_owned);
        let is_counted = self.messages.contains_key(&known) || self.messages.len() < MAX_MESSAGE_KINDS;
        let name = if is_counted { known } else { "others".to_owned() };
        *self.messages.entry(name).or_default() += 1;
    }

    fn take_events(&mut self, vehicles: &mut Vehicles, now: MonoTime) {
        while let Some(output) = vehicles.poll_output() {
            let RegistryOutput::Vehicle(id, Output::Event(event)) = output else { continue };
            let Some(system) = id.system() else { continue };
            let has_home = vehicles.get(id).is_some_and(|vehicle| vehicle.telemetry().is_ardupilot());
            let Some((kind, text)) = describe(&event, has_home) else { continue };
            if self.events.len() >= MAX_EVENTS {
                self.events_left_out += 1;
                continue;
            }
            self.events.push(RecordedEvent { at: now.since(MonoTime::ZERO), system, kind, text });
        }
    }
}

/// Name and description of an event that is reported for a flight.
fn describe(event: &VehicleEvent, has_home: bool) -> Option<(&'static str, String)> {
    Some(match event {
        VehicleEvent::Lost => ("lost", "not heard for 5 s".to_owned()),
        VehicleEvent::Regained => ("regained", "heard again".to_owned()),
        VehicleEvent::Rebooted => ("rebooted", "the autopilot restarted".to_owned()),
        VehicleEvent::ModeChanged { to, .. } => ("mode", format!("mode {to}")),
        VehicleEvent::ArmedChanged { is_armed: true } => ("armed", "armed".to_owned()),
        VehicleEvent::ArmedChanged { is_armed: false } => ("disarmed", "disarmed".to_owned()),
        VehicleEvent::Text(text) => ("text", text.text.clone()),
        VehicleEvent::ItemReached { seq } => {
            let item = if has_home { seq.0 } else { seq.0.saturating_add(1) };
            ("item_reached", format!("reached item {item}"))
        }
        VehicleEvent::TargetElsewhere { distance_m, .. } => {
            ("target_elsewhere", format!("it flies to {distance_m:.0} m from the item of its plan"))
        }
        VehicleEvent::MissionComplete => ("mission_complete", "the mission is flown to its end".to_owned()),
        _ => return None,
    })
}

#[cfg(test)]
mod tests {
    use std::fs::File;

    use super::*;

    fn capture(name: &str) -> File {
        let path = format!("{}/../../tests/fixtures/captures/{name}", env!("CARGO_MANIFEST_DIR"));
        File::open(&path).unwrap_or_else(|error| panic!("{path}: {error}"))
    }

    #[test]
    fn a_recorded_flight_is_told_from_arming_to_landing() {
        let summary = summarize_recording(capture("arduplane-takeoff-to-landing.tlog")).expect("readable");
        assert!(summary.frames > 10_000, "{}", summary.frames);
        assert_eq!(summary.skipped_bytes, 0);
        assert_eq!(summary.messages.values().sum::<u64>(), summary.frames);
        assert_eq!(summary.senders.values().map(|sender| sender.frames).sum::<u64>(), summary.frames);
        assert_eq!(summary.senders[&Address::new(1, 1)].kind, Some((1, 3)));
        assert!((300..320).contains(&summary.duration.as_secs()), "{:?}", summary.duration);
        let at = |kind: &str, text: &str| {
            let place = summary.events.iter().position(|event| event.kind == kind && event.text.contains(text));
            place.unwrap_or_else(|| panic!("no {kind} {text} in {:#?}", summary.events))
        };
        let story = [
            at("text", "Throttle armed"),
            at("item_reached", "reached item 1"),
            at("item_reached", "reached item 6"),
            at("item_reached", "reached item 10"),
            at("text", "Auto disarmed"),
        ];
        assert!(story.is_sorted(), "{story:?} in {:#?}", summary.events);
        assert!(at("mode", "AUTO") < at("armed", "armed"));
        let kinds: Vec<_> =
            summary.events.iter().map(|event| event.kind).filter(|kind| kind.ends_with("armed")).collect();
        assert_eq!(kinds, ["disarmed", "armed", "disarmed"]);
        assert_eq!(summary.events_left_out, 0);
    }

    #[test]
    fn telemetry_is_sampled_in_order_and_no_faster_than_asked() {
        let file = capture("arduplane-takeoff-to-landing.tlog");
        let samples = RecordedTelemetry::new(file, None, Duration::from_millis(500));
        let samples: Vec<_> = samples.map(|sample| sample.expect("readable")).collect();
        let end = samples.last().map(|(at, _)| at.as_duration().as_secs()).expect("some");
        assert!((300..320).contains(&end), "{end}");
        assert!((560..=2 * 320).contains(&samples.len()), "{}", samples.len());
        assert!(samples.is_sorted_by_key(|(at, _)| *at));
        let armed: Vec<_> = samples.iter().filter_map(|(_, telemetry)| telemetry.is_armed()).collect();
        assert!(armed.contains(&true) && armed.last() == Some(&false));
        let other = RecordedTelemetry::new(
            capture("arduplane-takeoff-to-landing.tlog"),
            Some(VehicleId::new(9)),
            Duration::ZERO,
        );
        assert_eq!(other.count(), 0);
    }

    #[test]
    fn a_source_without_an_end_is_no_flight() {
        let error = flight_within(100_000, io::repeat(0), None).expect_err("endless");
        assert!(error.to_string().contains("more than"), "{error}");
    }

    #[test]
    fn noise_is_no_recording() {
        let noise: Vec<u8> = (0..20_000_u32).map(|i| (i.wrapping_mul(2_654_435_761) >> 13) as u8).collect();
        let summary = summarize_recording(&noise[..]).expect("readable");
        assert_eq!(summary.skipped_bytes, 20_000);
        assert_eq!(summary, RecordingSummary { skipped_bytes: 20_000, ..RecordingSummary::default() });
    }

    #[test]
    fn a_torn_and_damaged_recording_is_read_around_the_damage() {
        let mut bytes = Vec::new();
        capture("mission-upload-items.tlog").read_to_end(&mut bytes).expect("readable");
        let whole = summarize_recording(&bytes[..]).expect("readable");
        bytes.truncate(bytes.len() - 3);
        bytes[100..110].fill(0xff);
        let torn = summarize_recording(&bytes[..]).expect("readable");
        assert!(torn.frames < whole.frames);
        assert!(torn.frames + 4 > whole.frames, "{} of {}", torn.frames, whole.frames);
        assert!(torn.skipped_bytes > 0);
    }
}
