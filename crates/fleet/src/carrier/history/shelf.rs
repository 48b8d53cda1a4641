//! The history files in a folder, by what is in them: looked at again each time, as they grow and are deleted.

use std::collections::BTreeMap;
use std::fs::File;
use std::io::{self, Read, Seek, SeekFrom};
use std::path::PathBuf;

use crate::history::page::PageReader;
use crate::history::record::{Entry, Index, MAX_PIECE_BYTES, Piece, Wanted};
use crate::history::{Ranges, Record, Stream};

/// How the files of a folder end.
pub(super) const ENDING: &str = ".mcap";
/// Bytes that are read of a file at once.
const READ_BYTES: u64 = 4 << 20;

/// A part of a file: the least and the largest number of each stream in it.
struct Part {
    offset: u64,
    len: u64,
    spans: BTreeMap<(u64, Stream), (u64, u64)>,
}

#[derive(Default)]
struct Sheet {
    reader: PageReader,
    parts: Vec<Part>,
    numbers: BTreeMap<(u64, Stream), Ranges>,
}

impl Sheet {
    /// Reads on, as far as the file goes now.
    fn read_on(&mut self, path: &PathBuf) -> io::Result<()> {
        let mut file = File::open(path)?;
        loop {
            let at = self.reader.at();
            file.seek(SeekFrom::Start(at))?;
            let mut bytes = Vec::new();
            (&mut file).take(READ_BYTES).read_to_end(&mut bytes)?;
            // A file of another kind, or one that is packed, has nothing for us.
            let Ok(blocks) = self.reader.read(&bytes) else { return Ok(()) };
            for block in blocks {
                let mut spans = BTreeMap::new();
                for record in &block.records {
                    let key = (record.boot, record.stream);
                    let (first, last) = spans.entry(key).or_insert((record.number, record.number));
                    (*first, *last) = ((*first).min(record.number), (*last).max(record.number));
                    self.numbers.entry(key).or_default().add(record.number, record.number);
                }
                self.parts.push(Part { offset: block.offset, len: block.len, spans });
            }
            if self.reader.at() == at {
                return Ok(());
            }
        }
    }
}

/// By what the names of files of one aircraft are in the order of their age: one that was begun in the same second as
/// another has a number behind the time.
pub(super) fn age(name: &str) -> &str {
    name.strip_suffix(ENDING).unwrap_or(name)
}

/// Files of one aircraft.
pub(super) struct Shelf {
    folder: PathBuf,
    prefix: String,
    sheets: BTreeMap<String, Sheet>,
}

impl Shelf {
    /// The files of a folder whose names begin so.
    pub(super) fn new(folder: PathBuf, prefix: String) -> Self {
        Self { folder, prefix, sheets: BTreeMap::new() }
    }

    /// Their names, by age as their names have it.
    pub(super) fn names(&self) -> io::Result<Vec<String>> {
        let entries = match std::fs::read_dir(&self.folder) {
            Ok(entries) => entries,
            Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(Vec::new()),
            Err(error) => return Err(error),
        };
        let names = entries.flatten().filter_map(|entry| entry.file_name().into_string().ok());
        let mut names: Vec<_> = names.filter(|name| name.starts_with(&self.prefix) && name.ends_with(ENDING)).collect();
        names.sort_by(|one, other| age(one).cmp(age(other)));
        Ok(names)
    }

    /// Looks at what is new.
    fn look(&mut self) -> io::Result<()> {
        let names = self.names()?;
        self.sheets.retain(|name, _| names.contains(name));
        for name in names {
            let path = self.folder.join(&name);
            self.sheets.entry(name).or_default().read_on(&path)?;
        }
        Ok(())
    }

    /// What is there of each stream of each boot.
    pub(super) fn numbers(&mut self) -> io::Result<BTreeMap<(u64, Stream), Ranges>> {
        self.look()?;
        let mut all: BTreeMap<(u64, Stream), Ranges> = BTreeMap::new();
        for (key, ranges) in self.sheets.values().flat_map(|sheet| &sheet.numbers) {
            ranges.iter().for_each(|(first, last)| all.entry(*key).or_default().add(first, last));
        }
        Ok(all)
    }

    /// The same for the ground, which asked with `nonce`; `boot` runs.
    pub(super) fn index(&mut self, nonce: u64, boot: u64) -> io::Result<Index> {
        let mut all = self.numbers()?;
        // Boots in the order of the last file that has them: names are of no use where a clock was not set, but nothing
        // is better.
        let mut boots: Vec<u64> = vec![boot];
        for sheet in self.sheets.values().rev() {
            boots.extend(sheet.parts.iter().rev().flat_map(|part| part.spans.keys().map(|(boot, _)| *boot)));
        }
        let mut seen = std::collections::BTreeSet::new();
        boots.retain(|boot| seen.insert(*boot));
        let of_boot = |boot: u64| Stream::ALL.map(|stream| (boot, stream));
        let kept = boots.into_iter().flat_map(of_boot).filter_map(|key| Some((key.0, key.1, all.remove(&key)?)));
        Ok(Index::of(nonce, boot, kept))
    }

    /// The answer to a question; of records at most `most` bytes, but one at least.
    pub(super) fn piece(&mut self, wanted: &Wanted, most: u32) -> io::Result<Piece> {
        self.look()?;
        let most = wanted.max_bytes.min(most).min(MAX_PIECE_BYTES) as usize;
        let stream = Stream::of_code(wanted.stream).filter(|_| wanted.max_bytes > 0);
        let Some(stream) = stream else { return Ok(Piece::of(wanted, wanted.last, Vec::new())) };
        let key = (wanted.boot, stream);
        // Parts that have some of it, the lowest numbers first: they may stand anywhere.
        let mut parts: Vec<_> = self
            .sheets
            .iter()
            .flat_map(|(name, sheet)| sheet.parts.iter().map(move |part| (name, part)))
            .filter_map(|(name, part)| Some((*part.spans.get(&key)?, name.clone(), part.offset, part.len)))
            .filter(|((first, last), ..)| *first <= wanted.last && *last >= wanted.first)
            .collect();
        parts.sort_unstable();
        let (mut found, mut bytes): (BTreeMap<u64, Record>, usize) = (BTreeMap::new(), 0);
        // The parts that were not read hold nothing below this number.
        let mut end = wanted.last;
        for ((first, _), name, offset, len) in parts {
            if bytes > most && first > wanted.first {
                end = end.min(first - 1);
                break;
            }
            for record in self.records(&name, offset, len)? {
                let is_wanted =
                    (record.boot, record.stream) == key && (wanted.first..=wanted.last).contains(&record.number);
                if is_wanted && !found.contains_key(&record.number) {
                    bytes += record.data.len();
                    found.insert(record.number, record);
                }
            }
        }
        let (mut entries, mut bytes) = (Vec::new(), 0);
        for (number, record) in found {
            if number > end {
                break;
            }
            bytes += record.data.len();
            if bytes > most && !entries.is_empty() {
                end = number - 1;
                break;
            }
            let Record { clock_ms, unix_ns, data, .. } = record;
            entries.push(Entry { number, clock_ms, unix_ns, data });
        }
        Ok(Piece::of(wanted, end, entries))
    }

    fn records(&mut self, name: &str, offset: u64, len: u64) -> io::Result<Vec<Record>> {
        let Some(sheet) = self.sheets.get_mut(name) else { return Ok(Vec::new()) };
        let mut file = File::open(self.folder.join(name))?;
        file.seek(SeekFrom::Start(offset))?;
        let mut bytes = Vec::new();
        file.take(len).read_to_end(&mut bytes)?;
        Ok(sheet.reader.block(&bytes).unwrap_or_default())
    }

    /// Of a file, as far as it can be read: the aircraft, where it says it; all records; and bytes that are damaged or
    /// torn off.
    pub(super) fn file(path: &std::path::Path) -> io::Result<(Option<String>, Vec<Record>, u64)> {
        let bytes = std::fs::read(path)?;
        let mut reader = PageReader::default();
        let blocks = reader.read(&bytes).map_err(|error| io::Error::new(io::ErrorKind::InvalidData, error))?;
        let torn = bytes.len() as u64 - reader.at().min(bytes.len() as u64);
        let records = blocks.into_iter().flat_map(|block| block.records).collect();
        Ok((reader.aircraft().map(str::to_owned), records, reader.damaged() + torn))
    }
}
