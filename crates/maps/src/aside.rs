//! Sources whose reading ended the process: what is being read is noted on disk, and a note that outlives its process
//! names what was read as it ended. That source is set aside and reported until its file changes or it is tried again
//! on request.
//!
//! The limits of [`crate::memory`] should make this unnecessary; it covers the unforeseen, so that a file which crashes
//! the process does so once, and not at each start. A note is a file that stays and is blank while nothing is read: two
//! writes of a few bytes, where to make and remove a file took as long as to read a tile. It is not forced to the disk:
//! it has to outlive the process, not the power. One from before the last start of the machine is ignored: power loss,
//! not the file, may have ended the process.

use std::collections::HashMap;
use std::fs::{File, OpenOptions};
use std::io::{Read, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use crate::settings::SourceSettings;
use crate::stamp::Stamp;

/// Bytes of a note at most.
const MAX_NOTE: u64 = 4096;

/// Who reads a source.
#[derive(Default)]
struct Readers {
    /// How many do now.
    count: usize,
    /// Where that is noted; `None` where it cannot be.
    note: Option<File>,
}

impl Readers {
    /// Writes the note over. All marks have one length.
    fn write(&mut self, text: &[u8]) {
        if let Some(note) = &mut self.note {
            let _ = note.seek(SeekFrom::Start(0)).and_then(|_| note.write_all(text));
        }
    }
}

#[derive(Default)]
struct State {
    /// Of each source that was read.
    read: HashMap<String, Readers>,
    /// Files of the sources that are set aside.
    aside: HashMap<String, String>,
    /// Ours, held as long as we run; `None` where it cannot be had, and when we are done.
    run: Option<Run>,
}

/// The notes of one process.
struct Run {
    folder: PathBuf,
    lock: PathBuf,
    /// Locked as long as the process lives.
    _file: File,
}

impl Drop for Run {
    fn drop(&mut self) {
        let _ = std::fs::remove_dir_all(&self.folder);
        let _ = std::fs::remove_file(&self.lock);
    }
}

/// Marks what is being read, and clears the mark.
pub(crate) struct Asides {
    maps: PathBuf,
    state: Mutex<State>,
}

/// A source that is being read, until this is dropped.
pub(crate) struct Reading {
    asides: Arc<Asides>,
    id: String,
}

impl Drop for Reading {
    fn drop(&mut self) {
        let mut state = self.asides.lock();
        let Some(readers) = state.read.get_mut(&self.id) else { return };
        readers.count -= 1;
        if readers.count == 0 {
            readers.write(&[b' '; MARK_LEN]);
        }
    }
}

impl Asides {
    /// Looks at what former processes left behind in a maps folder. Reading goes on in a folder where notes cannot be
    /// written.
    pub(crate) fn open(maps: &Path) -> Arc<Self> {
        let mut state = State::default();
        match collect(maps) {
            Ok((run, aside)) => (state.run, state.aside) = (Some(run), aside),
            Err(error) => tracing::warn!(%error, "what is read of map files cannot be noted"),
        }
        Arc::new(Self { maps: maps.to_owned(), state: Mutex::new(state) })
    }

    fn lock(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Notes that a source is read.
    pub(crate) fn reading(self: &Arc<Self>, settings: &SourceSettings) -> Reading {
        let mut state = self.lock();
        let State { read, run, .. } = &mut *state;
        let readers = read.entry(settings.id.clone()).or_default();
        readers.count += 1;
        if readers.count == 1
            && let Some(run) = run
        {
            if readers.note.is_none() {
                readers.note = File::create(run.folder.join(&settings.id)).ok();
            }
            readers.write(mark(settings, &self.maps).as_bytes());
        }
        Reading { asides: self.clone(), id: settings.id.clone() }
    }

    /// Whether the process ended while this was read. A changed file under the same name starts afresh.
    pub(crate) fn has(&self, settings: &SourceSettings) -> bool {
        let mut state = self.lock();
        let Some(read) = state.aside.get(&settings.id) else { return false };
        if *read == mark(settings, &self.maps) {
            return true;
        }
        state.aside.remove(&settings.id);
        let _ = std::fs::remove_file(folder(&self.maps).join("aside").join(&settings.id));
        false
    }

    /// Lets a source be read again; whether it was set aside.
    pub(crate) fn forgive(&self, id: &str) -> bool {
        let _ = std::fs::remove_file(folder(&self.maps).join("aside").join(id));
        self.lock().aside.remove(id).is_some()
    }

    /// Ends the notes: what is read from now on is read as the process ends in good order.
    pub(crate) fn close(&self) {
        let mut state = self.lock();
        // First the files, that a folder with open ones can be removed on every system.
        state.read.values_mut().for_each(|readers| readers.note = None);
        state.run = None;
    }
}

fn folder(maps: &Path) -> PathBuf {
    maps.join("reading")
}

/// Which start of the machine this is; empty where the system does not provide it. A lock file holds it.
fn this_boot() -> String {
    std::fs::read_to_string("/proc/sys/kernel/random/boot_id").unwrap_or_default()
}

/// Takes over the notes of processes that are gone, and begins our own.
fn collect(maps: &Path) -> std::io::Result<(Run, HashMap<String, String>)> {
    let this_boot = this_boot();
    let base = folder(maps);
    let kept = base.join("aside");
    vencejo_store::make_folder(&kept)?;
    for entry in std::fs::read_dir(&base)?.flatten() {
        let lock = entry.path();
        if lock.extension().is_none_or(|end| end != "run") {
            continue;
        }
        let mut file = OpenOptions::new().read(true).write(true).open(&lock)?;
        if !vencejo_store::lock::try_hold(&file)? {
            continue;
        }
        let mut boot = String::new();
        let is_of_this_boot =
            Read::by_ref(&mut file).take(MAX_NOTE).read_to_string(&mut boot).is_ok() && boot == this_boot;
        let run = Run { folder: lock.with_extension(""), lock, _file: file };
        if !is_of_this_boot {
            continue;
        }
        for note in std::fs::read_dir(&run.folder).into_iter().flatten().flatten() {
            if std::fs::read(note.path()).is_ok_and(|text| text.trim_ascii().is_empty()) {
                continue;
            }
            let id = note.file_name().to_string_lossy().into_owned();
            tracing::error!(source = id, "the program ended while this map source was read; it is set aside");
            let _ = vencejo_store::install(&note.path(), &kept.join(id));
        }
    }
    let mut aside = HashMap::new();
    for note in std::fs::read_dir(&kept)?.flatten().take(crate::file::MAX_SOURCES) {
        let is_short = note.metadata().is_ok_and(|about| about.len() <= MAX_NOTE);
        if let Ok(text) = std::fs::read_to_string(note.path())
            && is_short
        {
            aside.insert(note.file_name().to_string_lossy().into_owned(), text);
        }
    }
    static COUNT: AtomicU64 = AtomicU64::new(0);
    let name = format!("{}-{}", std::process::id(), COUNT.fetch_add(1, Ordering::Relaxed));
    let (own, lock) = (base.join(&name), base.join(format!("{name}.run")));
    let mut file = OpenOptions::new().write(true).create(true).truncate(false).open(&lock)?;
    if !vencejo_store::lock::try_hold(&file)? {
        return Err(std::io::Error::other("another process has the same number"));
    }
    file.write_all(this_boot.as_bytes())?;
    std::fs::create_dir_all(&own)?;
    Ok((Run { folder: own, lock, _file: file }, aside))
}

/// Bytes of a mark.
const MARK_LEN: usize = 16;

/// Which file, or which service, a source is read from.
fn mark(settings: &SourceSettings, maps: &Path) -> String {
    let about = settings.path.as_ref().map(|path| (path, Stamp::at(&maps.join(path))));
    let text = format!("{:?}", (about, settings.fingerprint()));
    format!("{:016x}", crate::settings::fnv1a(text.as_bytes()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::settings::SourceKind;
    use crate::testing::Folder;

    fn source(id: &str) -> SourceSettings {
        SourceSettings { path: Some("a.tif".into()), ..SourceSettings::new(id, "A", SourceKind::Geotiff) }
    }

    /// Ends like a killed process: nothing is cleaned up, and the system releases the lock.
    fn kill(asides: &Asides) {
        kill_at(asides, &this_boot());
    }

    fn kill_at(asides: &Asides, boot: &str) {
        let Some(run) = asides.lock().run.take() else { return };
        let (folder, lock) = (run.folder.clone(), run.lock.clone());
        let notes: Vec<_> = std::fs::read_dir(&folder)
            .expect("there")
            .flatten()
            .map(|note| (note.file_name(), std::fs::read(note.path()).expect("read")))
            .collect();
        drop(run);
        std::fs::create_dir_all(&folder).expect("a folder");
        std::fs::write(lock, boot).expect("written");
        for (name, bytes) in notes {
            std::fs::write(folder.join(name), bytes).expect("written");
        }
    }

    #[test]
    fn what_ended_the_process_is_set_aside_until_it_is_another_or_forgiven() {
        let folder = Folder::new();
        std::fs::write(folder.path().join("a.tif"), b"one").expect("written");
        let first = Asides::open(folder.path());
        drop(first.reading(&source("fine")));
        let (one, two) = (first.reading(&source("bad")), first.reading(&source("bad")));
        drop(one);
        let beside = Asides::open(folder.path());
        assert!(!beside.has(&source("bad")), "the other process still reads it");
        drop(beside);
        kill(&first);
        drop((two, first));

        let second = Asides::open(folder.path());
        assert!(second.has(&source("bad")) && !second.has(&source("fine")));
        drop(second);
        let third = Asides::open(folder.path());
        assert!(third.has(&source("bad")), "also at the start after that");
        std::fs::write(folder.path().join("a.tif"), b"another").expect("written");
        assert!(!third.has(&source("bad")), "another file");

        let reading = third.reading(&source("bad"));
        kill(&third);
        drop((reading, third));
        let fourth = Asides::open(folder.path());
        assert!(fourth.has(&source("bad")));
        assert!(fourth.forgive("bad") && !fourth.has(&source("bad")) && !fourth.forgive("bad"));
        let reading = fourth.reading(&source("bad"));
        fourth.close();
        drop((reading, fourth));
        assert!(!Asides::open(folder.path()).has(&source("bad")), "an end in good order");
    }

    // fault 57: a power cut while a map is read sets no map aside
    #[test]
    fn what_was_read_when_the_power_went_is_read_again() {
        let folder = Folder::new();
        for boot in ["5b1e7a3c-0000-4000-8000-000000000000\n", "half of a", "\0\0\0\0"] {
            let first = Asides::open(folder.path());
            let reading = first.reading(&source("fine"));
            kill_at(&first, boot);
            drop((reading, first));
            let second = Asides::open(folder.path());
            assert!(!second.has(&source("fine")), "{boot:?}");
            let left: Vec<_> = std::fs::read_dir(super::folder(folder.path())).expect("there").flatten().collect();
            assert_eq!(left.len(), 3, "only what is set aside, and the second's own: {left:?}");
        }
    }
}
