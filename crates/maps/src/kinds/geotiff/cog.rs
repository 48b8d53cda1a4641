//! GeoTIFFs that are read over the network, in parts (cloud-optimised GeoTIFF, OGC 21-026): what a tile needs is asked
//! for by range requests, kept for a while in blocks, and unpacked as from a file. The reading itself knows no network:
//! where bytes are missing it says which, they are fetched, and it starts again.

use std::collections::{BTreeMap, BTreeSet};
use std::io::{self, Read, Seek, SeekFrom};
use std::ops::Range;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use bytes::Bytes;
use serde::{Deserialize, Serialize};
use tokio::sync::{Semaphore, SemaphorePermit};
use tokio::task::JoinSet;

use super::file::GeoTiff;
use super::input::Input;
use crate::aside::Asides;
use crate::crs::Crs;
use crate::error::{MapError, Result};
use crate::geo::Bounds;
use crate::grid::{Level, TileGrid, TileId};
use crate::live::{About, TileFile};
use crate::net::{Answer, Fetcher, Freshness, Request, refused};
use crate::settings::SourceSettings;
use crate::source::Term;
use crate::task::blocking;

/// Bytes of a block.
const BLOCK: u64 = 16 * 1024;
/// Bytes that are asked for first: most files say in them all that is needed.
const FIRST: u64 = 64 * 1024;
/// Bytes of blocks that are kept of one file.
const KEPT: usize = 32 * 1024 * 1024;
/// Bytes of one request at most.
const MAX_REQUEST: u64 = 4 * 1024 * 1024;
/// Bytes that one tile may need.
const MAX_NEED: u64 = 24 * 1024 * 1024;
/// Bytes that may be read before the first tile: the lists of pieces of a very large file.
const MAX_HEAD: u64 = 24 * 1024 * 1024;
/// Tiles of one file that are made at once.
const AT_ONCE: usize = 4;
/// How long a file is taken for the same without asking, seconds.
const SURE_S: i64 = 60;

/// Identity of a file: when one of these differs, it was replaced.
#[derive(Debug, Clone, PartialEq, Eq)]
struct Version {
    etag: Option<String>,
    last_modified: Option<String>,
    bytes: u64,
}

impl Version {
    fn of(answer: &Answer) -> Option<Self> {
        let (etag, last_modified) = (answer.etag.clone(), answer.last_modified.clone());
        Some(Self { etag, last_modified, bytes: answer.whole_bytes? })
    }

    /// As text, for the tiles made from it.
    fn mark(&self) -> String {
        let text = format!("{:?}", (&self.etag, &self.last_modified, self.bytes));
        format!("{:016x}", crate::settings::fnv1a(text.as_bytes()))
    }
}

#[derive(Debug, Default)]
struct Inner {
    /// By number, with when it was used last.
    blocks: BTreeMap<u64, (u64, Bytes)>,
    uses: u64,
    bytes: usize,
    missing: BTreeSet<u64>,
}

/// The blocks of a file that are here.
#[derive(Debug)]
struct Blocks {
    bytes: u64,
    kept: Mutex<Inner>,
}

impl Blocks {
    fn new(bytes: u64) -> Self {
        Self { bytes, kept: Mutex::default() }
    }

    fn lock(&self) -> MutexGuard<'_, Inner> {
        self.kept.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Puts in what begins with a block.
    fn put(&self, start: u64, data: &Bytes) {
        let mut kept = self.lock();
        for (number, block) in (start / BLOCK..).zip(data.chunks(BLOCK as usize)) {
            kept.uses += 1;
            let used = kept.uses;
            // A copy: a slice would keep the whole answer.
            let before = kept.blocks.insert(number, (used, Bytes::copy_from_slice(block)));
            kept.bytes = kept.bytes + block.len() - before.map_or(0, |(_, block)| block.len());
        }
        if kept.bytes > KEPT {
            let mut ages: Vec<(u64, u64)> = kept.blocks.iter().map(|(number, (used, _))| (*used, *number)).collect();
            ages.sort_unstable();
            for (_, number) in ages {
                if kept.bytes <= KEPT / 4 * 3 {
                    break;
                }
                if let Some((_, block)) = kept.blocks.remove(&number) {
                    kept.bytes -= block.len();
                }
            }
        }
    }

    /// The missing parts of ranges, as ranges of whole blocks.
    fn lacks(&self, ranges: &[Range<u64>]) -> Vec<Range<u64>> {
        let kept = self.lock();
        let numbers = ranges
            .iter()
            .filter(|range| range.start < range.end)
            .flat_map(|range| range.start / BLOCK..=(range.end.min(self.bytes).saturating_sub(1)) / BLOCK)
            .filter(|number| number * BLOCK < self.bytes && !kept.blocks.contains_key(number));
        joined(&numbers.collect(), self.bytes)
    }

    /// Takes the ranges missed since the last call.
    fn take_missing(&self) -> BTreeSet<u64> {
        std::mem::take(&mut self.lock().missing)
    }
}

/// Blocks that follow each other as ranges of bytes that one request may ask for.
fn joined(numbers: &BTreeSet<u64>, bytes: u64) -> Vec<Range<u64>> {
    let mut ranges: Vec<Range<u64>> = Vec::new();
    for number in numbers {
        let (start, end) = (number * BLOCK, (number * BLOCK + BLOCK).min(bytes));
        match ranges.last_mut() {
            Some(last) if last.end == start && end - last.start <= MAX_REQUEST => last.end = end,
            _ => ranges.push(start..end),
        }
    }
    ranges
}

/// Reads what is here; notes what is not.
struct Reader {
    blocks: Arc<Blocks>,
    at: u64,
}

impl Read for Reader {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        if self.at >= self.blocks.bytes || buffer.is_empty() {
            return Ok(0);
        }
        let number = self.at / BLOCK;
        let mut kept = self.blocks.lock();
        kept.uses += 1;
        let now = kept.uses;
        let Some((used, block)) = kept.blocks.get_mut(&number) else {
            kept.missing.insert(number);
            return Err(io::Error::other("a part of the file is not here yet"));
        };
        *used = now;
        let rest = block.get((self.at % BLOCK) as usize..).unwrap_or_default();
        let count = rest.len().min(buffer.len());
        buffer[..count].copy_from_slice(&rest[..count]);
        self.at += count as u64;
        Ok(count)
    }
}

impl Seek for Reader {
    fn seek(&mut self, to: SeekFrom) -> io::Result<u64> {
        let wrong = || io::Error::new(io::ErrorKind::InvalidInput, "a place before the file's begin");
        self.at = match to {
            SeekFrom::Start(at) => at,
            SeekFrom::End(off) => self.blocks.bytes.checked_add_signed(off).ok_or_else(wrong)?,
            SeekFrom::Current(off) => self.at.checked_add_signed(off).ok_or_else(wrong)?,
        };
        Ok(self.at)
    }
}

/// Facts of a file that are kept with the cache, for use without the network.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(crate) struct Known {
    crs: String,
    levels: Vec<Level>,
    extent: Option<[f64; 4]>,
    bounds: Option<Bounds>,
}

impl Known {
    fn of(tiff: &GeoTiff) -> Self {
        let grid = tiff.grid();
        let (crs, levels, extent) = (grid.crs.code(), grid.levels.clone(), grid.extent);
        Self { crs, levels, extent, bounds: tiff.bounds() }
    }

    /// The grid of its tiles.
    pub(crate) fn grid(&self) -> Option<TileGrid> {
        let mut grid = TileGrid::new(Crs::parse(&self.crs)?, self.levels.clone());
        grid.extent = self.extent;
        Some(grid)
    }

    /// Its description.
    pub(crate) fn about(&self) -> About {
        About { bounds: self.bounds, is_overlay: true, ..About::default() }
    }
}

/// A file that was begun to be read.
struct Opened {
    tiff: Arc<GeoTiff>,
    blocks: Arc<Blocks>,
    version: Version,
    freshness: Freshness,
}

/// A tile with its notes.
pub(crate) struct Made {
    /// The picture; `None` where the file has no data.
    pub(crate) data: Option<Bytes>,
    /// Which file it is of.
    pub(crate) mark: String,
    /// How long that is new.
    pub(crate) freshness: Freshness,
    /// Bytes that came for it.
    pub(crate) bytes: u64,
}

/// A GeoTIFF at an address.
pub(crate) struct RemoteTiff {
    asides: Arc<Asides>,
    /// With how long it is taken for the same without asking.
    opened: tokio::sync::Mutex<Option<(Term, Arc<Opened>)>>,
    gate: Semaphore,
}

impl RemoteTiff {
    /// One that was not read yet.
    pub(crate) fn new(asides: Arc<Asides>) -> Self {
        Self { asides, opened: tokio::sync::Mutex::default(), gate: Semaphore::new(AT_ONCE) }
    }
}

/// Why a file could not be read.
enum Fault {
    /// It was replaced while it was read.
    Changed,
    Other(MapError),
}

impl From<MapError> for Fault {
    fn from(error: MapError) -> Self {
        Self::Other(error)
    }
}

/// One file of one fetcher.
#[derive(Clone)]
struct Remote<'a> {
    fetcher: &'a Fetcher,
    settings: &'a SourceSettings,
    url: &'a str,
    asides: &'a Arc<Asides>,
}

impl Remote<'_> {
    fn host(&self) -> String {
        url::Url::parse(self.url).map_or_else(|_| "?".to_owned(), |url| crate::net::shown(&url))
    }

    fn error(&self, reason: impl Into<String>) -> MapError {
        MapError::Service { host: self.host(), status: None, reason: reason.into() }
    }

    fn request(&self, range: Range<u64>) -> Result<Request> {
        let bytes = usize::try_from(range.end.saturating_sub(range.start)).unwrap_or(usize::MAX);
        let mut request = Request::new(self.settings, self.url, bytes.max(64 * 1024))?;
        request.range = Some(range);
        Ok(request)
    }

    /// A part of the file.
    async fn part(&self, range: Range<u64>) -> Result<Answer> {
        let request = self.request(range)?;
        let answer = self.fetcher.fetch(&request).await?;
        match answer.status {
            206 => Ok(answer),
            416 => Err(self.error("the file is empty, or shorter than it was")),
            _ => Err(refused(&request, &answer)),
        }
    }

    /// Fetches ranges, a few at once as the host allows, and puts them in their places.
    async fn fill(
        &self,
        blocks: &Blocks,
        version: &Version,
        ranges: Vec<Range<u64>>,
    ) -> std::result::Result<u64, Fault> {
        let mut fetches = JoinSet::new();
        for range in ranges {
            let request = self.request(range.clone())?;
            let fetcher = self.fetcher.clone();
            fetches.spawn(async move { (range, fetcher.fetch(&request).await, request) });
        }
        let mut bytes = 0;
        while let Some(done) = fetches.join_next().await {
            let (range, answer, request) = done.map_err(|_| MapError::Closed)?;
            let answer = answer?;
            match answer.status {
                206 if Version::of(&answer).as_ref() == Some(version) => {
                    bytes += answer.body.len() as u64;
                    blocks.put(range.start, &answer.body);
                }
                206 | 416 => return Err(Fault::Changed),
                _ => return Err(refused(&request, &answer).into()),
            }
        }
        Ok(bytes)
    }

    async fn open(&self) -> std::result::Result<Opened, Fault> {
        let first = self.part(0..FIRST).await?;
        let version = Version::of(&first).ok_or_else(|| self.error("does not say how large the file is"))?;
        let blocks = Arc::new(Blocks::new(version.bytes));
        blocks.put(0, &first.body);
        let mut read = 0;
        let mut ahead = 1;
        let mut last_end = 0;
        loop {
            let opened = blocks.clone();
            let name = self.host();
            let reading = self.asides.reading(self.settings);
            let tiff = blocking(move || {
                let _reading = reading;
                let input = opened.clone();
                let open = move || Ok(Box::new(Reader { blocks: input.clone(), at: 0 }) as Box<dyn Input>);
                Ok(GeoTiff::read(name, Box::new(open)))
            });
            let reason = match tiff.await? {
                Ok(tiff) => {
                    let freshness = first.freshness;
                    return Ok(Opened { tiff: Arc::new(tiff), blocks, version, freshness });
                }
                Err(reason) => reason,
            };
            let missing = blocks.take_missing();
            let Some(block) = missing.first().copied() else { return Err(self.error(reason).into()) };
            // Long lists are read one block after the other: more of them each time.
            ahead = if block == last_end { (ahead * 2).min(MAX_REQUEST / BLOCK) } else { 1 };
            last_end = block + ahead;
            let wanted = blocks.lacks(std::slice::from_ref(&(block * BLOCK..(last_end * BLOCK).min(version.bytes))));
            read += wanted.iter().map(|range| range.end - range.start).sum::<u64>();
            if read > MAX_HEAD {
                return Err(self.error(format!("the file's lists of pieces have more than {MAX_HEAD} bytes")).into());
            }
            self.fill(&blocks, &version, wanted).await?;
        }
    }

    async fn make(&self, opened: &Opened, tile: TileId) -> std::result::Result<Made, Fault> {
        let mut bytes = 0;
        for _ in 0..4 {
            let wanted = opened.blocks.lacks(&opened.tiff.needs(tile)?);
            let size: u64 = wanted.iter().map(|range| range.end - range.start).sum();
            if size > MAX_NEED {
                let reason = format!(
                    "a tile needs {} MB of the file: it has no overviews, or is not tiled; make a cloud-optimised GeoTIFF of \
                     it (gdal_translate -of COG)",
                    size / 1_000_000
                );
                return Err(self.error(reason).into());
            }
            bytes += self.fill(&opened.blocks, &opened.version, wanted).await?;
            let tiff = opened.tiff.clone();
            let reading = self.asides.reading(self.settings);
            let made = move || {
                let _reading = reading;
                Ok(tiff.tile(tile))
            };
            match blocking(made).await? {
                Ok(data) => {
                    let (mark, freshness) = (opened.version.mark(), opened.freshness);
                    return Ok(Made { data, mark, freshness, bytes });
                }
                Err(error) => {
                    // Blocks evicted in between are fetched again.
                    let missing = opened.blocks.take_missing();
                    if missing.is_empty() {
                        return Err(self.error(error.to_string()).into());
                    }
                    bytes += self.fill(&opened.blocks, &opened.version, joined(&missing, opened.version.bytes)).await?;
                }
            }
        }
        Err(self.error("the file needs more memory than there is for it").into())
    }
}

impl RemoteTiff {
    /// Its description; the file is read as far as needed.
    pub(crate) async fn known(
        &self,
        fetcher: &Fetcher,
        settings: &SourceSettings,
        url: &str,
        now_s: i64,
    ) -> Result<Known> {
        let remote = Remote { fetcher, settings, url, asides: &self.asides };
        Ok(Known::of(&self.opened(&remote, now_s).await?.tiff))
    }

    /// The present file, if it is still the one that a tile was made from.
    pub(crate) async fn is_still(
        &self,
        mark: &str,
        fetcher: &Fetcher,
        settings: &SourceSettings,
        url: &str,
        now_s: i64,
    ) -> Result<Option<Freshness>> {
        let remote = Remote { fetcher, settings, url, asides: &self.asides };
        let opened = self.opened(&remote, now_s).await?;
        Ok((opened.version.mark() == mark).then_some(opened.freshness))
    }

    async fn opened(&self, remote: &Remote<'_>, now_s: i64) -> Result<Arc<Opened>> {
        // Held while it is opened: one does, the others wait.
        let mut opened = self.opened.lock().await;
        if let Some((sure, known)) = opened.as_mut() {
            if sure.left_s(now_s).is_some() {
                return Ok(known.clone());
            }
            // A small part shows whether it is the same file.
            let answer = remote.part(0..BLOCK.min(known.version.bytes)).await?;
            if Version::of(&answer).as_ref() == Some(&known.version) {
                *sure = Term::new(now_s, SURE_S);
                return Ok(known.clone());
            }
        }
        *opened = None;
        let new = match remote.open().await {
            Err(Fault::Changed) => remote.open().await,
            other => other,
        };
        let new = Arc::new(new.map_err(|fault| changed(remote, fault))?);
        *opened = Some((Term::new(now_s, SURE_S), new.clone()));
        Ok(new)
    }

    /// Waits until a tile may be made: few are at once, since each takes memory and a thread.
    pub(crate) async fn turn(&self) -> Result<SemaphorePermit<'_>> {
        self.gate.acquire().await.map_err(|_| MapError::Closed)
    }

    /// A tile, with whatever has to be fetched for it; to be called in turn. A file that was replaced meanwhile is read
    /// again, once.
    pub(crate) async fn tile(
        &self,
        fetcher: &Fetcher,
        settings: &SourceSettings,
        url: &str,
        tile: TileId,
        now_s: i64,
    ) -> Result<Made> {
        let remote = Remote { fetcher, settings, url, asides: &self.asides };
        let opened = self.opened(&remote, now_s).await?;
        match remote.make(&opened, tile).await {
            Err(Fault::Changed) => {
                self.forget(&opened).await;
                let again = self.opened(&remote, now_s).await?;
                if Known::of(&again.tiff) != Known::of(&opened.tiff) {
                    return Err(remote.error(MOVED));
                }
                let made = remote.make(&again, tile).await;
                if matches!(made, Err(Fault::Changed)) {
                    self.forget(&again).await;
                }
                made.map_err(|fault| changed(&remote, fault))
            }
            made => made.map_err(|fault| changed(&remote, fault)),
        }
    }

    /// Whether what was read last lies on a grid, by which tiles were asked for.
    pub(crate) async fn lies_on(&self, grid: Option<&TileGrid>) -> bool {
        let opened = self.opened.lock().await;
        let Some((own, grid)) = opened.as_ref().map(|(_, opened)| opened.tiff.grid()).zip(grid) else { return true };
        own.crs == grid.crs && own.levels == grid.levels
    }

    async fn forget(&self, opened: &Arc<Opened>) {
        let mut known = self.opened.lock().await;
        if known.as_ref().is_some_and(|(_, known)| Arc::ptr_eq(known, opened)) {
            *known = None;
        }
    }
}

/// Error text when another file is at the same address.
pub(crate) const MOVED: &str =
    "the file was replaced by one that lies elsewhere or has other pixels; add it as a source of another id";

fn changed(remote: &Remote<'_>, fault: Fault) -> MapError {
    match fault {
        Fault::Changed => remote.error("the file changes while it is read; it is tried again later"),
        Fault::Other(error) => error,
    }
}
