//! Lists that are too large for an order or an answer: mission items and parameters, packed and named by their digest,
//! so that a list that is there already is not sent again. No I/O.
//!
//! A list is sent up in parts ([`Tray`]) and fetched down in pieces ([`Pull`](crate::pull::Pull)); complete lists are
//! cached on a [`Shelf`].

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

/// Most bytes of a packed list.
pub const MAX_PACKED: usize = 256 * 1024;
/// Most unpacked bytes: 10,000 items are 610 kB, as many parameters half of that.
const MAX_UNPACKED: usize = 1 << 20;
/// Most parameters in a list, as at a link.
const MAX_PARAMS: usize = 10_000;
/// Lists up to this size are sent with an answer; of longer ones only the name.
pub const MAX_WITH_ANSWER: usize = 12 * 1024;
/// The same for an order, which is sent repeatedly.
pub const MAX_WITH_ORDER: usize = 1024;
/// Bytes of a part on its way up.
pub const PART_BYTES: usize = 12 * 1024;
/// Most lists on a shelf.
const MAX_KEPT: usize = 12;
/// Most lists that are received at once.
const MAX_ARRIVING: usize = 4;

/// SHA-256 of a packed list.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Digest(pub [u8; 32]);

impl Digest {
    /// The digest of these bytes.
    pub fn of(bytes: &[u8]) -> Self {
        let mut made = [0; 32];
        made.copy_from_slice(digest(&SHA256, bytes).as_ref());
        Self(made)
    }

    fn read(bytes: &[u8]) -> Result<Self, BadPayload> {
        bytes.try_into().map(Self).map_err(|_| BadPayload::Field("digest"))
    }

    /// Parses its text.
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

/// A packed list, with its bytes or by name only.
#[derive(Clone, PartialEq, prost::Message)]
pub struct Content {
    /// [`Digest`] of the bytes.
    #[prost(bytes = "vec", tag = "1")]
    pub digest: Vec<u8>,
    /// Number of bytes.
    #[prost(uint32, tag = "2")]
    pub length: u32,
    /// The bytes; empty when they are sent separately.
    #[prost(bytes = "vec", tag = "3")]
    pub here: Vec<u8>,
}

impl Content {
    /// These bytes.
    pub fn of(packed: Vec<u8>) -> Self {
        let length = u32::try_from(packed.len()).unwrap_or(u32::MAX);
        Self { digest: Digest::of(&packed).0.to_vec(), length, here: packed }
    }

    /// The same by name only when it has more than `limit` bytes.
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
    /// [`BadPayload::Field`] for an invalid length, [`BadPayload::Content`] for bytes that do not match the digest.
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
    /// The bytes: [`PART_BYTES`], or the rest.
    #[prost(bytes = "vec", tag = "4")]
    pub bytes: Vec<u8>,
}

impl Part {
    /// The parts of a list.
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

/// A list of items in columns, which compress well.
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
    /// A bit for each unset parameter, the first lowest; the eighth: wait after the item.
    #[prost(uint32, repeated, tag = "5")]
    flags: Vec<u32>,
    /// All first parameters, then all second…
    #[prost(double, repeated, tag = "6")]
    params: Vec<f64>,
}

const WAITS: u32 = 1 << 7;

/// Packs a list of items.
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

/// Reads a list of items. It is not checked whether they may be uploaded.
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
    /// [`BadPayload::Field`] for an invalid name, type or value.
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
    Ok(Param::new(name, value_of(kind, value)?))
}

/// Packs a list of parameters.
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

/// The newest complete lists; older ones are dropped.
#[derive(Debug, Default)]
pub struct Shelf(VecDeque<(Digest, Arc<[u8]>)>);

impl Shelf {
    /// Adds a list.
    pub fn put(&mut self, packed: &[u8]) -> Digest {
        let name = Digest::of(packed);
        if self.get(&name).is_none() {
            self.0.push_front((name, packed.into()));
            self.0.truncate(MAX_KEPT);
        }
        name
    }

    /// A list; it becomes the newest.
    pub fn get(&mut self, name: &Digest) -> Option<Arc<[u8]>> {
        let found = self.0.remove(self.0.iter().position(|(known, _)| known == name)?)?;
        self.0.push_front(found);
        self.0.front().map(|(_, packed)| packed.clone())
    }
}

/// Lists that are received in parts, in any order, one per sender.
#[derive(Debug, Default)]
pub struct Tray(VecDeque<Arriving>);

#[derive(Debug)]
struct Arriving {
    of: PublicKey,
    name: Digest,
    bytes: Vec<u8>,
    /// The parts received.
    has: Vec<bool>,
}

impl Tray {
    /// Adds a part; returns the list when it is complete.
    ///
    /// # Errors
    /// [`BadPayload`] for a part that fits no list. When all parts have come and do not match the digest, the list
    /// begins anew.
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
mod tests;
