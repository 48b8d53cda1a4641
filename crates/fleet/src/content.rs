//! What is too large for an order or an answer: lists of items and of parameters, packed and named by their digest, so that what is there already
//! is not sent again. No I/O.
//!
//! Upward a list goes in parts ([`Tray`]), down in pieces that are asked for ([`Pull`](crate::pull::Pull)); what is whole lies on a [`Shelf`].

use std::collections::VecDeque;
use std::fmt;
use std::io::{Read, Write};
use std::sync::Arc;

use flate2::Compression;
use flate2::read::DeflateDecoder;
use flate2::write::DeflateEncoder;
use prost::Message;
use ring::digest::{SHA256, digest};
use vencejo_flight::plan::{Command, Home, MAX_ITEMS, MavFrame, Mission, MissionItem};
use vencejo_proto::param::{Param, ParamName, ParamType, ParamValue};

use crate::signature::PublicKey;
use crate::wire::{BadPayload, VERSION};

/// Bytes of a packed list at most.
pub const MAX_PACKED: usize = 256 * 1024;
/// Bytes of what is in it at most: 10,000 items are 610 kB, as many parameters half of that.
const MAX_UNPACKED: usize = 1 << 20;
/// Parameters in a list at most, as at a link.
const MAX_PARAMS: usize = 10_000;
/// Bytes of a list that go with an answer; of a longer one its name goes.
pub const MAX_WITH_ANSWER: usize = 12 * 1024;
/// The same for an order, which is sent again and again.
pub const MAX_WITH_ORDER: usize = 1024;
/// Bytes of a part on its way up.
pub const PART_BYTES: usize = 12 * 1024;
/// Lists that lie on a shelf at most.
const MAX_KEPT: usize = 12;
/// Lists that are arriving at once at most.
const MAX_ARRIVING: usize = 4;

/// SHA-256 of a packed list.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Digest(pub [u8; 32]);

impl Digest {
    /// Of these bytes.
    #[must_use]
    pub fn of(bytes: &[u8]) -> Self {
        let mut made = [0; 32];
        made.copy_from_slice(digest(&SHA256, bytes).as_ref());
        Self(made)
    }

    fn read(bytes: &[u8]) -> Result<Self, BadPayload> {
        bytes.try_into().map(Self).map_err(|_| BadPayload::Field("digest"))
    }

    /// The one in this text.
    #[must_use]
    pub fn from_text(text: &str) -> Option<Self> {
        text.parse::<PublicKey>().ok().map(|bytes| Self(bytes.0))
    }
}

impl fmt::Display for Digest {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.iter().try_for_each(|byte| write!(f, "{byte:02x}"))
    }
}

impl fmt::Debug for Digest {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "Digest({self})")
    }
}

/// A packed list, with its bytes or by its name alone.
#[derive(Clone, PartialEq, prost::Message)]
pub struct Content {
    /// [`Digest`] of the bytes.
    #[prost(bytes = "vec", tag = "1")]
    pub digest: Vec<u8>,
    /// How many there are.
    #[prost(uint32, tag = "2")]
    pub length: u32,
    /// The bytes; empty where they come another way.
    #[prost(bytes = "vec", tag = "3")]
    pub here: Vec<u8>,
}

impl Content {
    /// These bytes.
    #[must_use]
    pub fn of(packed: Vec<u8>) -> Self {
        let length = u32::try_from(packed.len()).unwrap_or(u32::MAX);
        Self { digest: Digest::of(&packed).0.to_vec(), length, here: packed }
    }

    /// The same by its name alone, where it has more than `limit` bytes.
    #[must_use]
    pub fn at_most(mut self, limit: usize) -> Self {
        if self.here.len() > limit {
            self.here = Vec::new();
        }
        self
    }

    /// Its name and length.
    ///
    /// # Errors
    /// [`BadPayload::Field`] for a length that no list has, [`BadPayload::Content`] for bytes that are not those named.
    pub fn name(&self) -> Result<(Digest, usize), BadPayload> {
        let (digest, length) = (Digest::read(&self.digest)?, self.length as usize);
        if !(1..=MAX_PACKED).contains(&length) {
            return Err(BadPayload::Field("length"));
        }
        if !self.here.is_empty() && (self.here.len() != length || Digest::of(&self.here) != digest) {
            return Err(BadPayload::Content("it is not what its digest says"));
        }
        Ok((digest, length))
    }
}

/// A part of a list on its way up.
#[derive(Clone, PartialEq, prost::Message)]
pub struct Part {
    /// [`Digest`] of the whole.
    #[prost(bytes = "vec", tag = "1")]
    pub digest: Vec<u8>,
    /// Bytes of the whole.
    #[prost(uint32, tag = "2")]
    pub length: u32,
    /// Where this part begins: a multiple of [`PART_BYTES`].
    #[prost(uint32, tag = "3")]
    pub offset: u32,
    /// The part, as long as a part is, or as what is left.
    #[prost(bytes = "vec", tag = "4")]
    pub bytes: Vec<u8>,
}

impl Part {
    /// The parts of a list.
    #[must_use]
    pub fn all_of(packed: &[u8]) -> Vec<Self> {
        let (name, length) = (Digest::of(packed).0.to_vec(), u32::try_from(packed.len()).unwrap_or(u32::MAX));
        let part = |(number, bytes): (usize, &[u8])| Self {
            digest: name.clone(),
            length,
            offset: u32::try_from(number * PART_BYTES).unwrap_or(u32::MAX),
            bytes: bytes.to_vec(),
        };
        packed.chunks(PART_BYTES).enumerate().map(part).collect()
    }
}

/// A list of items in columns: like numbers side by side pack well.
#[derive(Clone, PartialEq, prost::Message)]
struct Items {
    #[prost(uint32, tag = "1")]
    version: u32,
    /// Latitude, longitude (WGS-84, degrees), height above mean sea level (m); or nothing.
    #[prost(double, repeated, tag = "2")]
    home: Vec<f64>,
    #[prost(uint32, repeated, tag = "3")]
    command: Vec<u32>,
    #[prost(uint32, repeated, tag = "4")]
    frame: Vec<u32>,
    /// A bit for each parameter that is unset, the first lowest; the eighth: wait after the item.
    #[prost(uint32, repeated, tag = "5")]
    flags: Vec<u32>,
    /// All first parameters, then all second…
    #[prost(double, repeated, tag = "6")]
    params: Vec<f64>,
}

const WAITS: u32 = 1 << 7;

/// Packs a list of items.
#[must_use]
pub fn pack_items(list: &Mission) -> Vec<u8> {
    let items = &list.items;
    let flags = |item: &MissionItem| {
        let unset = item.params.iter().enumerate().filter(|(_, param)| param.is_none());
        unset.fold(if item.autocontinue { 0 } else { WAITS }, |flags, (index, _)| flags | 1 << index)
    };
    let column = |index: usize| items.iter().map(move |item| item.params[index].unwrap_or(0.0));
    pack(&Items {
        version: VERSION,
        home: list.home.map(|home| vec![home.lat_deg, home.lon_deg, home.alt_amsl_m]).unwrap_or_default(),
        command: items.iter().map(|item| item.command.0.into()).collect(),
        frame: items.iter().map(|item| item.frame.number().into()).collect(),
        flags: items.iter().map(flags).collect(),
        params: (0..7).flat_map(column).collect(),
    })
}

/// Reads a list of items. Whether they may be sent is another question.
///
/// # Errors
/// [`BadPayload`].
pub fn unpack_items(packed: &[u8]) -> Result<Mission, BadPayload> {
    let list: Items = unpack(packed)?;
    let count = list.command.len();
    let is_whole = [list.frame.len(), list.flags.len()] == [count; 2] && list.params.len() == 7 * count;
    if list.version != VERSION || count > MAX_ITEMS || !is_whole {
        return Err(BadPayload::Field("items"));
    }
    let item = |index: usize| {
        let flags = list.flags[index];
        let param = |number: usize| (flags & 1 << number == 0).then(|| list.params[number * count + index]);
        Ok(MissionItem {
            command: Command(u16::try_from(list.command[index]).map_err(|_| BadPayload::Field("command"))?),
            frame: MavFrame::from(u8::try_from(list.frame[index]).map_err(|_| BadPayload::Field("frame"))?),
            params: std::array::from_fn(param),
            autocontinue: flags & WAITS == 0,
        })
    };
    let home = match list.home[..] {
        [] => None,
        [lat_deg, lon_deg, alt_amsl_m] => Some(Home { lat_deg, lon_deg, alt_amsl_m }),
        _ => return Err(BadPayload::Field("home")),
    };
    Ok(Mission { home, items: (0..count).map(item).collect::<Result<_, _>>()? })
}

#[derive(Clone, PartialEq, prost::Message)]
struct Params {
    #[prost(uint32, tag = "1")]
    version: u32,
    #[prost(string, repeated, tag = "2")]
    name: Vec<String>,
    /// `MAV_PARAM_TYPE`.
    #[prost(uint32, repeated, tag = "3")]
    kind: Vec<u32>,
    /// Each exact.
    #[prost(double, repeated, tag = "4")]
    value: Vec<f64>,
}

/// One parameter, in an answer.
#[derive(Clone, PartialEq, prost::Message)]
pub struct OneParam {
    /// Its name.
    #[prost(string, tag = "1")]
    pub name: String,
    /// `MAV_PARAM_TYPE`.
    #[prost(uint32, tag = "2")]
    pub kind: u32,
    /// Exact.
    #[prost(double, tag = "3")]
    pub value: f64,
}

impl From<&Param> for OneParam {
    fn from(param: &Param) -> Self {
        let kind = param.value.param_type().to_mav() as u32;
        Self { name: param.name.as_str().to_owned(), kind, value: param.value.as_f64() }
    }
}

impl OneParam {
    /// The parameter.
    ///
    /// # Errors
    /// [`BadPayload::Field`] for a name, type or value that cannot be.
    pub fn read(&self) -> Result<Param, BadPayload> {
        param(&self.name, self.kind, self.value)
    }
}

/// A parameter's value of this type.
pub(crate) fn value_of(kind: u32, value: f64) -> Result<ParamValue, BadPayload> {
    use ParamType::{F32, I8, I16, I32, U8, U16, U32};
    let known = [U8, I8, U16, I16, U32, I32, F32].into_iter().find(|known| known.to_mav() as u32 == kind);
    let known = known.ok_or(BadPayload::Field("parameter type"))?;
    ParamValue::new(known, value).map_err(|_| BadPayload::Field("parameter value"))
}

fn param(name: &str, kind: u32, value: f64) -> Result<Param, BadPayload> {
    let name = ParamName::new(name).map_err(|_| BadPayload::Field("parameter name"))?;
    Ok(Param { name, value: value_of(kind, value)? })
}

/// Packs a list of parameters.
#[must_use]
pub fn pack_params(params: &[Param]) -> Vec<u8> {
    pack(&Params {
        version: VERSION,
        name: params.iter().map(|param| param.name.as_str().to_owned()).collect(),
        kind: params.iter().map(|param| param.value.param_type().to_mav() as u32).collect(),
        value: params.iter().map(|param| param.value.as_f64()).collect(),
    })
}

/// Reads a list of parameters.
///
/// # Errors
/// [`BadPayload`].
pub fn unpack_params(packed: &[u8]) -> Result<Vec<Param>, BadPayload> {
    let list: Params = unpack(packed)?;
    let count = list.name.len();
    if list.version != VERSION || count > MAX_PARAMS || [list.kind.len(), list.value.len()] != [count; 2] {
        return Err(BadPayload::Field("parameters"));
    }
    let rows = list.name.iter().zip(list.kind).zip(list.value);
    rows.map(|((name, kind), value)| param(name, kind, value)).collect()
}

fn pack(list: &impl Message) -> Vec<u8> {
    let mut packed = DeflateEncoder::new(Vec::new(), Compression::best());
    packed.write_all(&list.encode_to_vec()).and_then(|()| packed.finish()).expect("invariant: memory takes it")
}

fn unpack<T: Message + Default>(packed: &[u8]) -> Result<T, BadPayload> {
    if packed.len() > MAX_PACKED {
        return Err(BadPayload::TooLarge(packed.len()));
    }
    let mut bytes = Vec::new();
    let read = DeflateDecoder::new(packed).take(MAX_UNPACKED as u64 + 1).read_to_end(&mut bytes);
    read.map_err(|error| BadPayload::Undecodable(error.to_string()))?;
    if bytes.len() > MAX_UNPACKED {
        return Err(BadPayload::TooLarge(bytes.len()));
    }
    T::decode(bytes.as_slice()).map_err(|error| BadPayload::Undecodable(error.to_string()))
}

/// Lists that are whole, the newest; older ones make room.
#[derive(Debug, Default)]
pub struct Shelf(VecDeque<(Digest, Arc<[u8]>)>);

impl Shelf {
    /// Puts a list there.
    pub fn put(&mut self, packed: &[u8]) -> Digest {
        let name = Digest::of(packed);
        if self.get(&name).is_none() {
            self.0.push_front((name, packed.into()));
            self.0.truncate(MAX_KEPT);
        }
        name
    }

    /// One of them; it counts as new again.
    pub fn get(&mut self, name: &Digest) -> Option<Arc<[u8]>> {
        let found = self.0.remove(self.0.iter().position(|(known, _)| known == name)?)?;
        self.0.push_front(found);
        self.0.front().map(|(_, packed)| packed.clone())
    }
}

/// Lists that arrive part by part, in any order, one of each sender.
#[derive(Debug, Default)]
pub struct Tray(VecDeque<Arriving>);

#[derive(Debug)]
struct Arriving {
    of: PublicKey,
    name: Digest,
    bytes: Vec<u8>,
    /// Which parts are there.
    has: Vec<bool>,
}

impl Tray {
    /// A part came; gives the list when it is whole.
    ///
    /// # Errors
    /// [`BadPayload`] for one that fits no list; that list begins anew when all its parts came and are not what their digest says.
    pub fn on_part(&mut self, of: PublicKey, part: &Part) -> Result<Option<Vec<u8>>, BadPayload> {
        let name = Digest::read(&part.digest)?;
        let (length, offset) = (part.length as usize, part.offset as usize);
        if !(1..=MAX_PACKED).contains(&length) {
            return Err(BadPayload::Field("length"));
        }
        if offset >= length || !offset.is_multiple_of(PART_BYTES) {
            return Err(BadPayload::Field("offset"));
        }
        if part.bytes.len() != (length - offset).min(PART_BYTES) {
            return Err(BadPayload::Field("bytes"));
        }
        let is_known = |list: &Arriving| list.of == of && list.name == name && list.bytes.len() == length;
        let mut list = match self.0.iter().position(is_known).and_then(|place| self.0.remove(place)) {
            Some(list) => list,
            None => {
                self.0.retain(|list| list.of != of);
                self.0.truncate(MAX_ARRIVING - 1);
                Arriving { of, name, bytes: vec![0; length], has: vec![false; length.div_ceil(PART_BYTES)] }
            }
        };
        list.bytes[offset..offset + part.bytes.len()].copy_from_slice(&part.bytes);
        list.has[offset / PART_BYTES] = true;
        if !list.has.iter().all(|has| *has) {
            self.0.push_front(list);
            return Ok(None);
        }
        if Digest::of(&list.bytes) != name {
            return Err(BadPayload::Content("its parts are not what its digest says"));
        }
        Ok(Some(list.bytes))
    }
}

#[cfg(test)]
mod tests {
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
        let params: Vec<_> =
            (0..1400).map(|index| Param { name: name(index), value: values[index % values.len()] }).collect();
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
            let whole: Vec<_> =
                parts.iter().filter_map(|part| tray.on_part(ana, part).expect("a part of it")).collect();
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
}
