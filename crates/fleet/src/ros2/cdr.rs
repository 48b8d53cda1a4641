//! CDR as ROS 2 puts it on the wire: version 1, little endian, plain (OMG XTypes 1.3, 7.4.3; DDSI-RTPS 2.5, 10.5).

use std::fmt;

/// What stands before the data: representation CDR_LE, no options.
const HEADER: [u8; 4] = [0, 1, 0, 0];

/// Data that is not what it should be.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct BadCdr(pub &'static str);

impl fmt::Display for BadCdr {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "the data cannot be read: {}", self.0)
    }
}

/// Something that has a form in CDR.
pub trait Cdr: Sized {
    /// Puts it at the end.
    fn put(&self, out: &mut Writer);

    /// Takes it from the front.
    ///
    /// # Errors
    /// [`BadCdr`].
    fn take(from: &mut Reader<'_>) -> Result<Self, BadCdr>;

    /// As it goes over the wire.
    fn to_bytes(&self) -> Vec<u8> {
        let mut out = Writer(HEADER.to_vec());
        self.put(&mut out);
        out.0
    }

    /// From the wire. What follows it is ignored: some senders fill up to four bytes.
    ///
    /// # Errors
    /// [`BadCdr`].
    fn from_bytes(bytes: &[u8]) -> Result<Self, BadCdr> {
        match bytes.split_first_chunk::<4>() {
            Some((header, body)) if header[..2] == HEADER[..2] => Self::take(&mut Reader { body, at: 0 }),
            _ => Err(BadCdr("it is not little-endian CDR")),
        }
    }
}

/// Nothing: the header is all that has to be there.
impl Cdr for () {
    fn put(&self, _: &mut Writer) {}

    fn take(_: &mut Reader<'_>) -> Result<Self, BadCdr> {
        Ok(())
    }
}

/// Data on its way out.
pub struct Writer(Vec<u8>);

/// Data on its way in. Nothing is allocated for more than has come.
pub struct Reader<'a> {
    body: &'a [u8],
    at: usize,
}

impl Writer {
    /// A number stands at a multiple of its size, counted from behind the header.
    fn number<const N: usize>(&mut self, bytes: [u8; N]) {
        let at = self.0.len() - HEADER.len();
        self.0.resize(HEADER.len() + at.next_multiple_of(N), 0);
        self.0.extend_from_slice(&bytes);
    }
}

impl Reader<'_> {
    fn bytes(&mut self, count: usize) -> Result<&[u8], BadCdr> {
        let end = self.at.checked_add(count).ok_or(BadCdr("a length is too large"))?;
        let found = self.body.get(self.at..end).ok_or(BadCdr("it ends too early"))?;
        self.at = end;
        Ok(found)
    }

    fn number<const N: usize>(&mut self) -> Result<[u8; N], BadCdr> {
        self.at = self.at.next_multiple_of(N);
        Ok(self.bytes(N)?.try_into().expect("invariant: as many bytes as asked for"))
    }

    fn left(&self) -> usize {
        self.body.len().saturating_sub(self.at)
    }

    fn length(&mut self) -> Result<usize, BadCdr> {
        let length = usize::try_from(u32::take(self)?).map_err(|_| BadCdr("a length is too large"))?;
        // Everything takes a byte at least.
        if length > self.left() { Err(BadCdr("a length is more than there is")) } else { Ok(length) }
    }
}

macro_rules! numbers {
    ($($number:ty),*) => {$(
        impl Cdr for $number {
            fn put(&self, out: &mut Writer) {
                out.number(self.to_le_bytes());
            }

            fn take(from: &mut Reader<'_>) -> Result<Self, BadCdr> {
                Ok(Self::from_le_bytes(from.number()?))
            }
        }
    )*};
}

numbers!(i8, u8, i16, u16, i32, u32, i64, u64, f32, f64);

impl Cdr for bool {
    fn put(&self, out: &mut Writer) {
        u8::from(*self).put(out);
    }

    fn take(from: &mut Reader<'_>) -> Result<Self, BadCdr> {
        match u8::take(from)? {
            0 => Ok(false),
            1 => Ok(true),
            _ => Err(BadCdr("a bool is neither 0 nor 1")),
        }
    }
}

impl Cdr for String {
    fn put(&self, out: &mut Writer) {
        // A NUL ends it for whoever reads it in C.
        let text = self.split('\0').next().unwrap_or_default();
        u32::try_from(text.len() + 1).expect("invariant: our texts are short").put(out);
        out.0.extend_from_slice(text.as_bytes());
        out.0.push(0);
    }

    fn take(from: &mut Reader<'_>) -> Result<Self, BadCdr> {
        let length = from.length()?;
        let text = match from.bytes(length)?.split_last() {
            None => &[],
            Some((0, text)) => text,
            Some(_) => return Err(BadCdr("a string has no end")),
        };
        let text = std::str::from_utf8(text).map_err(|_| BadCdr("a string is not UTF-8"))?;
        if text.contains('\0') { Err(BadCdr("a string has two ends")) } else { Ok(text.to_owned()) }
    }
}

impl<T: Cdr> Cdr for Vec<T> {
    fn put(&self, out: &mut Writer) {
        u32::try_from(self.len()).expect("invariant: our lists are short").put(out);
        self.iter().for_each(|item| item.put(out));
    }

    fn take(from: &mut Reader<'_>) -> Result<Self, BadCdr> {
        let length = from.length()?;
        (0..length).map(|_| T::take(from)).collect()
    }
}

impl<T: Cdr + Copy + Default, const N: usize> Cdr for [T; N] {
    fn put(&self, out: &mut Writer) {
        self.iter().for_each(|item| item.put(out));
    }

    fn take(from: &mut Reader<'_>) -> Result<Self, BadCdr> {
        let mut all = [T::default(); N];
        for item in &mut all {
            *item = T::take(from)?;
        }
        Ok(all)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_not_it_is_refused() {
        let text = "plane".to_owned().to_bytes();
        assert_eq!(text, b"\0\x01\0\0\x06\0\0\0plane\0");
        assert_eq!(String::from_bytes(&text).as_deref(), Ok("plane"));
        assert_eq!(String::from_bytes(b"\0\x01\0\0\0\0\0\0").as_deref(), Ok(""), "some say nothing at all");
        for cut in 0..text.len() {
            assert!(String::from_bytes(&text[..cut]).is_err(), "{cut}");
        }
        for bad in [
            &b"\0\0\0\0\x06\0\0\0plane\0"[..],
            b"\0\x01\0\0\x05\0\0\0plane\0",
            b"\0\x01\0\0\x06\0\0\0pl\0ne\0",
            b"\0\x01\0\0\x06\0\0\0pla\xffe\0",
            b"\0\x01\0\0\xff\xff\xff\xffplane\0",
        ] {
            assert!(String::from_bytes(bad).is_err(), "{bad:?}");
            assert!(Vec::<u64>::from_bytes(bad).is_err(), "{bad:?}");
        }
        assert!(bool::from_bytes(b"\0\x01\0\0\x02").is_err());
    }
}
