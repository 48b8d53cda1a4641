//! The payloads of states, orders and answers: Protocol Buffers, version 1.
//!
//! The telemetry of an aircraft is sent as the payloads of its own MAVLink messages, the newest of each, unmodified:
//! all stations decode them with the same decoder, and have all that a station at a direct link has. Unknown fields of
//! a later version are skipped; a sample of another [`VERSION`] is not read.

use crate::content::Part;
use crate::deed::{Act, Nothing};
use crate::outcome::Outcome;
use crate::plans::PlanTold;
pub use crate::wire::{BadPayload, MAX_BYTES, MAX_MESSAGES, MAX_TEXT, Said, VERSION};

/// Who may act on the aircraft.
#[derive(Clone, PartialEq, prost::Message)]
pub struct Held {
    /// Incremented with each grant.
    #[prost(uint64, tag = "1")]
    pub epoch: u64,
    /// Name of the holder of control; empty if there is none.
    #[prost(string, tag = "2")]
    pub holder: String,
    /// Its public key; empty for one on board or at a direct link.
    #[prost(bytes = "vec", tag = "3")]
    pub key: Vec<u8>,
    /// Name of the operator who asks for control.
    #[prost(string, tag = "4")]
    pub asking: String,
    /// Its public key.
    #[prost(bytes = "vec", tag = "5")]
    pub asking_key: Vec<u8>,
    /// The holder's [`Order::run`].
    #[prost(uint32, tag = "6")]
    pub run: u32,
    /// That of who asks.
    #[prost(uint32, tag = "7")]
    pub asking_run: u32,
}

/// The state of an aircraft: what is new since the sample before; on request, everything.
#[derive(Clone, PartialEq, prost::Message)]
pub struct State {
    /// [`VERSION`].
    #[prost(uint32, tag = "1")]
    pub version: u32,
    /// A random number of each start of the station on board.
    #[prost(fixed64, tag = "2")]
    pub boot: u64,
    /// The clock on board, ms.
    #[prost(uint64, tag = "3")]
    pub clock_ms: u64,
    /// Counts the samples.
    #[prost(uint64, tag = "4")]
    pub sequence: u64,
    /// MAVLink system id of the aircraft.
    #[prost(uint32, tag = "5")]
    pub system: u32,
    /// MAVLink component id of its autopilot.
    #[prost(uint32, tag = "6")]
    pub component: u32,
    /// Who may act; in a sample only if it has changed, and each second.
    #[prost(message, optional, tag = "7")]
    pub held: Option<Held>,
    /// Messages of the autopilot, in columns: their MAVLink ids…
    #[prost(uint32, repeated, tag = "8")]
    pub message_ids: Vec<u32>,
    /// …how long before the sample was made each came, ms…
    #[prost(uint32, repeated, tag = "14")]
    pub ages_ms: Vec<u32>,
    /// …how many bytes each has…
    #[prost(uint32, repeated, tag = "15")]
    pub sizes: Vec<u32>,
    /// …and their MAVLink 2 payloads, one after the other, each without the zeros at its end.
    #[prost(bytes = "vec", tag = "16")]
    pub payloads: Vec<u8>,
    /// Version of the plan states on board.
    #[prost(uint32, tag = "9")]
    pub plans_version: u32,
    /// The plan states, if new.
    #[prost(message, repeated, tag = "10")]
    pub plans: Vec<PlanTold>,
    /// Progress of long orders.
    #[prost(message, repeated, tag = "11")]
    pub under_way: Vec<UnderWay>,
    /// Mark of `clock_ms`: an order that is based on this state has both.
    #[prost(fixed64, tag = "12")]
    pub mark: u64,
    /// Number of the newest [`Event`] of this boot; 0 before the first.
    #[prost(uint64, tag = "13")]
    pub events: u64,
    /// While the autopilot is silent: when it was last heard, by the clock on board, ms.
    #[prost(uint64, optional, tag = "17")]
    pub silent_since_ms: Option<u64>,
    /// The links to it and their states, in words, while it is silent; in a sample every ten seconds.
    #[prost(string, tag = "18")]
    pub links: String,
}

/// The progress of an order.
#[derive(Clone, PartialEq, prost::Message)]
pub struct UnderWay {
    /// The order's id.
    #[prost(bytes = "vec", tag = "1")]
    pub id: Vec<u8>,
    /// Amount done, in units of `total`.
    #[prost(uint32, tag = "2")]
    pub done: u32,
    /// Total amount; 0 when not known yet.
    #[prost(uint32, tag = "3")]
    pub total: u32,
}

/// A message of the autopilot that must not be lost, numbered from 1.
#[derive(Clone, PartialEq, prost::Message)]
pub struct Event {
    /// [`VERSION`].
    #[prost(uint32, tag = "1")]
    pub version: u32,
    /// As in [`State`].
    #[prost(fixed64, tag = "2")]
    pub boot: u64,
    /// Its number in this boot, without gaps.
    #[prost(uint64, tag = "3")]
    pub number: u64,
    /// The clock on board when it came, ms.
    #[prost(uint64, tag = "4")]
    pub clock_ms: u64,
    /// The message.
    #[prost(message, optional, tag = "5")]
    pub said: Option<Said>,
    /// In the reply to a query: number of the oldest event kept; earlier ones are gone.
    #[prost(uint64, tag = "6")]
    pub kept_from: u64,
}

/// An operator's order.
#[derive(Clone, PartialEq, prost::Message)]
pub struct Order {
    /// [`VERSION`].
    #[prost(uint32, tag = "1")]
    pub version: u32,
    /// The organisation…
    #[prost(string, tag = "2")]
    pub org: String,
    /// …and the aircraft that it is for.
    #[prost(string, tag = "3")]
    pub aircraft: String,
    /// The boot that it is for.
    #[prost(fixed64, tag = "4")]
    pub boot: u64,
    /// The epoch in which its operator holds control; 0 to ask for control.
    #[prost(uint64, tag = "5")]
    pub epoch: u64,
    /// 16 random bytes; a resent order has the same.
    #[prost(bytes = "vec", tag = "6")]
    pub id: Vec<u8>,
    /// The clock on board in the newest state that its operator had, ms, from which the age of that state is computed.
    #[prost(uint64, tag = "7")]
    pub based_on_ms: u64,
    /// Name of the operator, for others to read.
    #[prost(string, tag = "8")]
    pub operator: String,
    /// The mark of `based_on_ms` in that state.
    #[prost(fixed64, tag = "16")]
    pub mark: u64,
    /// A random number of each program: those with one key need control each for itself.
    #[prost(uint32, tag = "19")]
    pub run: u32,
    /// What.
    #[prost(oneof = "Want", tags = "9, 10, 11, 13, 14, 15, 17")]
    pub want: Option<Want>,
}

/// How control is asked for.
#[derive(Clone, Copy, PartialEq, Eq, prost::Message)]
pub struct Ask {
    /// Only if it may be had at once, or to keep up a request: none is made.
    #[prost(bool, tag = "1")]
    pub only_if_free: bool,
    /// It is taken from those who have to yield: another program with the same key; an operator, for a chief.
    #[prost(bool, tag = "2")]
    pub overrules: bool,
    /// Where it is taken from somebody, it goes back there when it is given up and nobody asks for it: for a program,
    /// whose end would otherwise leave an aircraft in flight without a ground station.
    #[prost(bool, tag = "3")]
    pub borrows: bool,
}

/// What an order can be about.
#[derive(Clone, PartialEq, prost::Oneof)]
pub enum Want {
    /// Control; while another has it, it is asked for it.
    #[prost(message, tag = "9")]
    Ask(Ask),
    /// To keep control.
    #[prost(message, tag = "10")]
    Renew(Nothing),
    /// To give control up, to the station that asks for it if there is one, or else to whom it was borrowed from; or to
    /// withdraw the request for it.
    #[prost(message, tag = "11")]
    Release(Nothing),
    /// To do something.
    #[prost(message, tag = "13")]
    Act(Act),
    /// To receive a part of a list for a later order.
    #[prost(message, tag = "14")]
    Part(Part),
    /// To recall the order of this id.
    #[prost(bytes = "vec", tag = "15")]
    Recall(Vec<u8>),
    /// To keep control, and decline the request of the station with this public key.
    #[prost(bytes = "vec", tag = "17")]
    Keep(Vec<u8>),
}

/// A signed order.
#[derive(Clone, PartialEq, prost::Message)]
pub struct Signed {
    /// Public key of the signer.
    #[prost(bytes = "vec", tag = "1")]
    pub key: Vec<u8>,
    /// The order's bytes, as they were signed.
    #[prost(bytes = "vec", tag = "2")]
    pub order: Vec<u8>,
    /// The signature.
    #[prost(bytes = "vec", tag = "3")]
    pub signature: Vec<u8>,
}

/// How an order ended on board.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, prost::Enumeration)]
#[repr(i32)]
pub enum End {
    /// Never sent.
    Unspecified = 0,
    /// Done, and seen to be done.
    Done = 1,
    /// Control is granted, in the answer's epoch.
    Granted = 2,
    /// Another operator has control, and was shown the request.
    Asked = 3,
    /// Another operator has control.
    Held = 4,
    /// Never done: the state that it was based on is too old.
    Stale = 5,
    /// Not done, for the reason in `why`.
    Refused = 6,
    /// The autopilot refused.
    CommandRefused = 7,
    /// The autopilot was asked and did not answer, or does not show it, or the order is too old to be remembered: it may
    /// or may not have been done.
    Unknown = 8,
    /// A transfer failed; see the outcome.
    Failed = 9,
    /// Not done: its list has not arrived completely.
    ListMissing = 10,
}

/// The answer to an order.
#[derive(Clone, PartialEq, prost::Message)]
pub struct Answer {
    /// [`VERSION`].
    #[prost(uint32, tag = "1")]
    pub version: u32,
    /// The order's id.
    #[prost(bytes = "vec", tag = "2")]
    pub id: Vec<u8>,
    /// How it ended.
    #[prost(enumeration = "End", tag = "3")]
    pub end: i32,
    /// Why, in English.
    #[prost(string, tag = "4")]
    pub why: String,
    /// Who holds control.
    #[prost(string, tag = "5")]
    pub holder: String,
    /// The epoch of this grant.
    #[prost(uint64, tag = "6")]
    pub epoch: u64,
    /// The command that the autopilot refused or did not answer (`MAV_CMD`).
    #[prost(uint32, tag = "7")]
    pub command: u32,
    /// How it refused (`MAV_RESULT`).
    #[prost(uint32, tag = "8")]
    pub result: u32,
    /// What the autopilot wrote about it.
    #[prost(string, repeated, tag = "9")]
    pub reasons: Vec<String>,
    /// Number of the mode that cures it, plus one; 0 for none.
    #[prost(uint64, tag = "10")]
    pub cure: u64,
    /// What it yields.
    #[prost(oneof = "Outcome", tags = "11, 12, 13, 14, 15, 16")]
    pub outcome: Option<Outcome>,
    /// The order is for another boot: how long this one has run, ms; 0: it is for this one. Before that, no order was
    /// done here.
    #[prost(uint64, tag = "17")]
    pub boot_age_ms: u64,
    /// What shows the effect of an act that has ended, so that it is seen on the ground with the answer.
    #[prost(message, optional, boxed, tag = "18")]
    pub state: Option<Box<State>>,
}

/// A message with a version.
trait Versioned: prost::Message + Default {
    fn version(&self) -> u32;
}

macro_rules! versioned {
    ($($name:ty),*) => {
        $(impl Versioned for $name {
            fn version(&self) -> u32 {
                self.version
            }
        })*
    };
}
versioned!(State, Event, Order, Answer);

fn read<T: Versioned>(bytes: &[u8]) -> Result<T, BadPayload> {
    let read = read_bare::<T>(bytes)?;
    if read.version() == VERSION { Ok(read) } else { Err(BadPayload::Version(read.version())) }
}

fn read_bare<T: prost::Message + Default>(bytes: &[u8]) -> Result<T, BadPayload> {
    if bytes.len() > MAX_BYTES {
        return Err(BadPayload::TooLarge(bytes.len()));
    }
    T::decode(bytes).map_err(|error| BadPayload::Undecodable(error.to_string()))
}

/// Most bytes of an operator's name; on board, the name of the ground station is put before it.
const MAX_OPERATOR: usize = 160;
const MAX_HOLDER: usize = MAX_OPERATOR + 40;

fn is_name(name: &str, most: usize) -> bool {
    name.len() <= most && !name.contains(char::is_control)
}

impl State {
    /// Adds a message of the autopilot.
    pub fn say(&mut self, said: &Said) {
        self.message_ids.push(said.message_id);
        self.ages_ms.push(said.age_ms);
        // A payload has 255 bytes at most.
        self.sizes.push(u32::try_from(said.payload.len()).unwrap_or(u32::MAX));
        self.payloads.extend(&said.payload);
    }

    /// The messages of the autopilot.
    pub fn said(&self) -> impl Iterator<Item = Said> {
        let columns = self.message_ids.iter().zip(&self.ages_ms).zip(&self.sizes);
        columns.scan(self.payloads.as_slice(), |rest, ((&message_id, &age_ms), &size)| {
            let (payload, others) = rest.split_at_checked(usize::try_from(size).ok()?)?;
            *rest = others;
            Some(Said { message_id, payload: payload.to_vec(), age_ms })
        })
    }

    /// Reads one.
    ///
    /// # Errors
    /// [`BadPayload`].
    pub fn read(bytes: &[u8]) -> Result<Self, BadPayload> {
        read::<Self>(bytes)?.checked()
    }

    fn checked(mut self) -> Result<Self, BadPayload> {
        self.links = vencejo_proto::plain(&self.links, MAX_TEXT);
        if !(1..=255).contains(&self.system) {
            return Err(BadPayload::Field("system"));
        }
        if self.component > 255 {
            return Err(BadPayload::Field("component"));
        }
        let count = self.message_ids.len();
        if [count, self.plans.len(), self.under_way.len()].into_iter().any(|count| count > MAX_MESSAGES) {
            return Err(BadPayload::Field("message_ids"));
        }
        let size = self.sizes.iter().try_fold(0_usize, |all, size| all.checked_add(usize::try_from(*size).ok()?));
        if (self.ages_ms.len(), self.sizes.len(), size) != (count, count, Some(self.payloads.len())) {
            return Err(BadPayload::Field("sizes"));
        }
        let is_bad = |name: &String| !is_name(name, MAX_HOLDER);
        if self.held.as_ref().is_some_and(|held| is_bad(&held.holder) || is_bad(&held.asking)) {
            return Err(BadPayload::Field("held"));
        }
        Ok(self)
    }
}

impl Event {
    /// Reads one.
    ///
    /// # Errors
    /// [`BadPayload`].
    pub fn read(bytes: &[u8]) -> Result<Self, BadPayload> {
        let event: Self = read(bytes)?;
        if event.number == 0 || event.said.is_none() {
            return Err(BadPayload::Field("number or said"));
        }
        Ok(event)
    }
}

impl Order {
    /// Reads one.
    ///
    /// # Errors
    /// [`BadPayload`].
    pub fn read(bytes: &[u8]) -> Result<Self, BadPayload> {
        let order: Self = read(bytes)?;
        if order.id.len() != 16 {
            return Err(BadPayload::Field("id"));
        }
        if !is_name(&order.operator, MAX_OPERATOR) {
            return Err(BadPayload::Field("operator"));
        }
        Ok(order)
    }

    /// Its id as a number.
    pub fn id(&self) -> u128 {
        self.id.as_slice().try_into().map_or(0, u128::from_be_bytes)
    }
}

impl Signed {
    /// Reads one. The signature is not verified here.
    ///
    /// # Errors
    /// [`BadPayload`].
    pub fn read(bytes: &[u8]) -> Result<Self, BadPayload> {
        read_bare(bytes)
    }
}

impl Answer {
    /// Reads one.
    ///
    /// # Errors
    /// [`BadPayload`].
    pub fn read(bytes: &[u8]) -> Result<Self, BadPayload> {
        let mut answer: Self = read(bytes)?;
        if matches!(End::try_from(answer.end), Err(_) | Ok(End::Unspecified)) {
            return Err(BadPayload::Field("end"));
        }
        let clean = |text: &mut String| {
            *text = vencejo_proto::plain(text, MAX_TEXT);
        };
        clean(&mut answer.why);
        clean(&mut answer.holder);
        answer.reasons.truncate(MAX_MESSAGES);
        answer.reasons.iter_mut().for_each(clean);
        answer.state = answer.state.map(|state| state.checked().map(Box::new)).transpose()?;
        Ok(answer)
    }
}

#[cfg(test)]
mod tests {
    use prost::Message as _;
    use vencejo_proto::{Address, Header, Heartbeat, MavVersion, Message};

    use super::*;
    use crate::deed::Deed;

    #[test]
    fn a_message_comes_out_as_it_went_in() {
        let heartbeat =
            Message::Heartbeat(Heartbeat { mav_type: 1, autopilot: 3, custom_mode: 10, ..Heartbeat::default() });
        for version in [MavVersion::V1, MavVersion::V2] {
            let frame = heartbeat.encode(Header { sequence: 1, source: Address::new(7, 1), version });
            assert_eq!(Said::of(&frame, 3).message().as_ref(), Some(&heartbeat), "{version:?}");
        }
    }

    /// Bytes written down by hand, field by field, from the description of Protocol Buffers: what two versions of this
    /// program say to each other does not change by itself.
    #[test]
    fn the_bytes_of_an_order_are_what_they_are() {
        let order = Order {
            version: 1,
            org: "acme".into(),
            aircraft: "p7".into(),
            boot: 2,
            epoch: 3,
            id: vec![9; 16],
            based_on_ms: 300,
            operator: "Ana".into(),
            mark: 8,
            run: 0,
            want: Some(Want::Act(Act { deed: Some(Deed::Mode("RTL".into())), ..Act::default() })),
        };
        let mut bytes = vec![0x08, 1, 0x12, 4];
        bytes.extend(b"acme");
        bytes.extend([0x1a, 2]);
        bytes.extend(b"p7");
        bytes.extend([0x21, 2, 0, 0, 0, 0, 0, 0, 0, 0x28, 3, 0x32, 16]);
        bytes.extend([9; 16]);
        bytes.extend([0x38, 0xac, 0x02, 0x42, 3]);
        bytes.extend(b"Ana");
        bytes.extend([0x6a, 5, 0x2a, 3]);
        bytes.extend(b"RTL");
        bytes.extend([0x81, 0x01, 8, 0, 0, 0, 0, 0, 0, 0]);
        assert_eq!(order.encode_to_vec(), bytes);
        assert_eq!(Order::read(&bytes), Ok(order));
    }

    #[test]
    fn what_cannot_be_is_not_read() {
        let state = State { version: VERSION, system: 1, ..State::default() };
        assert!(State::read(&state.encode_to_vec()).is_ok());
        let other = State { version: 2, ..state.clone() };
        assert_eq!(State::read(&other.encode_to_vec()), Err(BadPayload::Version(2)));
        let nobody = State { system: 0, ..state.clone() };
        assert_eq!(State::read(&nobody.encode_to_vec()), Err(BadPayload::Field("system")));
        let mut flood = state.clone();
        (0..=MAX_MESSAGES).for_each(|_| flood.say(&Said::default()));
        assert_eq!(State::read(&flood.encode_to_vec()), Err(BadPayload::Field("message_ids")));
        let mut torn = state;
        torn.say(&Said { message_id: 0, payload: vec![7; 9], age_ms: 20 });
        assert_eq!(State::read(&torn.encode_to_vec()).map(|state| state.said().count()), Ok(1));
        torn.payloads.pop();
        assert_eq!(State::read(&torn.encode_to_vec()), Err(BadPayload::Field("sizes")));
        assert_eq!(State::read(&vec![0; MAX_BYTES + 1]), Err(BadPayload::TooLarge(MAX_BYTES + 1)));
        let short = Order { version: VERSION, id: vec![1; 15], ..Order::default() };
        assert_eq!(Order::read(&short.encode_to_vec()), Err(BadPayload::Field("id")));
        let endless = Answer { version: VERSION, ..Answer::default() };
        assert_eq!(Answer::read(&endless.encode_to_vec()), Err(BadPayload::Field("end")));
        let holder = Held { holder: "x".repeat(MAX_HOLDER + 1), ..Held::default() };
        let boasting = State { system: 1, held: Some(holder), ..State::default() };
        let answer =
            Answer { version: VERSION, end: End::Done.into(), state: Some(Box::new(boasting)), ..Answer::default() };
        assert_eq!(Answer::read(&answer.encode_to_vec()), Err(BadPayload::Field("held")));
    }

    #[test]
    fn no_payload_panics() {
        let mut seed = 1_u64;
        for length in 0..2000 {
            let bytes: Vec<u8> = (0..length % 97)
                .map(|_| {
                    seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
                    (seed >> 56) as u8
                })
                .collect();
            let read = (State::read(&bytes), Event::read(&bytes), Order::read(&bytes), Answer::read(&bytes));
            assert!(read.0.is_err() || read.1.is_err() || read.2.is_err() || read.3.is_err());
        }
    }
}
