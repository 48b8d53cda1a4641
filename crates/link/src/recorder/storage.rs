//! The storage of recordings: a folder, the names and ages of its files, and which of them are marked as kept.

use std::collections::HashSet;
use std::fs;
use std::io::{self, Write};
use std::path::PathBuf;
use std::sync::mpsc;

use vencejo_store::Space;

/// The suffix of the empty file that marks a recording as kept.
const KEPT: &str = ".keep";

/// A recording in the folder.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct StoredFile {
    /// The file's name.
    pub name: String,
    /// Its size.
    pub bytes: u64,
    /// Whether it is marked as kept, so that it is not deleted to make room.
    pub is_kept: bool,
}

/// The storage of recordings; injected, so that tests can let it fail.
pub trait Storage: Send {
    /// Creates a file that does not exist yet.
    ///
    /// # Errors
    /// [`io::ErrorKind::AlreadyExists`] when it exists, otherwise the error of the disk.
    fn create_new(&mut self, name: &str) -> io::Result<Box<dyn StorageFile>>;
    /// Reopens one of its files for appending, which was closed with this size.
    ///
    /// # Errors
    /// [`io::ErrorKind::InvalidData`] when its size has changed, otherwise the error of the disk.
    fn append(&mut self, name: &str, bytes: u64) -> io::Result<Box<dyn StorageFile>>;
    /// All files.
    ///
    /// # Errors
    /// The error of the disk.
    fn list(&mut self) -> io::Result<Vec<StoredFile>>;
    /// Deletes a file that is not being written.
    ///
    /// # Errors
    /// [`io::ErrorKind::WouldBlock`] when another process is writing it, otherwise the error of the disk.
    fn remove(&mut self, name: &str) -> io::Result<()>;
    /// Free space.
    ///
    /// # Errors
    /// The error of the disk.
    fn free_bytes(&mut self) -> io::Result<u64>;
}

/// A recording being written.
pub trait StorageFile: Write + Send {
    /// Begins to sync what was written until now. Writes do not wait for it.
    fn sync(&mut self) -> Syncing;
}

/// A sync in progress: it can take seconds.
#[derive(Debug)]
pub struct Syncing(mpsc::Receiver<io::Result<()>>);

impl Syncing {
    /// One in progress, and the sender of its result.
    pub fn begun() -> (mpsc::Sender<io::Result<()>>, Self) {
        let (told, end) = mpsc::channel();
        (told, Self(end))
    }

    /// One that has ended.
    pub fn ended(result: io::Result<()>) -> Self {
        let (told, syncing) = Self::begun();
        // The receiver lives.
        let _ = told.send(result);
        syncing
    }

    /// Its result; `None` while in progress.
    pub(super) fn end(&self) -> Option<io::Result<()>> {
        match self.0.try_recv() {
            Ok(result) => Some(result),
            Err(mpsc::TryRecvError::Empty) => None,
            Err(mpsc::TryRecvError::Disconnected) => Some(Err(given_up())),
        }
    }

    /// Waits for its end.
    pub(super) fn wait(self) -> io::Result<()> {
        self.0.recv().unwrap_or_else(|_| Err(given_up()))
    }
}

fn given_up() -> io::Error {
    io::Error::other("what forces recordings to the disk has ended")
}

/// A folder of the file system.
#[derive(Debug)]
pub struct Folder {
    path: PathBuf,
    space: Space,
    /// To the syncing thread, which the first file starts.
    jobs: Option<mpsc::Sender<SyncJob>>,
}

impl Folder {
    /// The folder at `path`, created with the first recording.
    pub fn new(path: impl Into<PathBuf>) -> Self {
        Self { path: path.into(), space: Space::default(), jobs: None }
    }

    fn jobs(&mut self) -> io::Result<mpsc::Sender<SyncJob>> {
        if let Some(jobs) = &self.jobs {
            return Ok(jobs.clone());
        }
        let (jobs, todo) = mpsc::channel::<SyncJob>();
        std::thread::Builder::new()
            .name("vencejo-sync".to_owned())
            .spawn(move || todo.into_iter().for_each(SyncJob::run))?;
        self.jobs = Some(jobs.clone());
        Ok(jobs)
    }

    /// The same with another source for the free space.
    #[must_use]
    pub fn with_space(self, space: Space) -> Self {
        Self { space, ..self }
    }
}

/// Whether a recording of a folder is marked as kept.
pub fn is_kept_recording(folder: &std::path::Path, name: &str) -> bool {
    folder.join(format!("{name}{KEPT}")).exists()
}

/// Marks a recording of a folder as kept (not deleted to make room for new ones), or unmarks it.
///
/// # Errors
/// [`io::ErrorKind::NotFound`] when there is none of that name, otherwise the error of the disk.
pub fn keep_recording(folder: &std::path::Path, name: &str, is_kept: bool) -> io::Result<()> {
    if Names::plain("tlog").age_key(name).is_none() || !folder.join(name).is_file() {
        return Err(io::ErrorKind::NotFound.into());
    }
    let mark = folder.join(format!("{name}{KEPT}"));
    if is_kept {
        return vencejo_store::create(&mark, b"", vencejo_store::Access::Usual).map(drop);
    }
    match fs::remove_file(&mark) {
        Err(error) if error.kind() != io::ErrorKind::NotFound => Err(error),
        _ => vencejo_store::sync_folder(folder),
    }
}

impl Storage for Folder {
    fn create_new(&mut self, name: &str) -> io::Result<Box<dyn StorageFile>> {
        vencejo_store::make_folder(&self.path)?;
        let file = fs::OpenOptions::new().write(true).create_new(true).open(self.path.join(name))?;
        // So that no other process deletes it to make room. It was just created, so the lock is free.
        vencejo_store::lock::try_hold(&file)?;
        Ok(Box::new(FolderFile { file, unsynced_folder: Some(self.path.clone()), jobs: self.jobs()? }))
    }

    fn append(&mut self, name: &str, bytes: u64) -> io::Result<Box<dyn StorageFile>> {
        let file = fs::OpenOptions::new().append(true).open(self.path.join(name))?;
        vencejo_store::lock::try_hold(&file)?;
        let there = file.metadata()?.len();
        if there != bytes {
            let problem = format!("{name} has {there} bytes where {bytes} were written: something else changed it");
            return Err(io::Error::new(io::ErrorKind::InvalidData, problem));
        }
        Ok(Box::new(FolderFile { file, unsynced_folder: None, jobs: self.jobs()? }))
    }

    fn list(&mut self) -> io::Result<Vec<StoredFile>> {
        let mut files = Vec::new();
        for entry in fs::read_dir(&self.path)? {
            let entry = entry?;
            let metadata = entry.metadata()?;
            if metadata.is_file()
                && let Ok(name) = entry.file_name().into_string()
            {
                files.push(StoredFile { name, bytes: metadata.len(), is_kept: false });
            }
        }
        let names: HashSet<String> = files.iter().map(|file| file.name.clone()).collect();
        for file in &mut files {
            file.is_kept = names.contains(&format!("{}{KEPT}", file.name));
        }
        Ok(files)
    }

    fn remove(&mut self, name: &str) -> io::Result<()> {
        let path = self.path.join(name);
        if !vencejo_store::lock::try_hold(&fs::File::open(&path)?)? {
            return Err(io::ErrorKind::WouldBlock.into());
        }
        fs::remove_file(path)
    }

    fn free_bytes(&mut self) -> io::Result<u64> {
        self.space.free_bytes(&self.path)
    }
}

/// A file of a [`Folder`].
struct FolderFile {
    file: fs::File,
    /// Its folder, until the folder is synced with the file's name.
    unsynced_folder: Option<PathBuf>,
    jobs: mpsc::Sender<SyncJob>,
}

impl Write for FolderFile {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.file.write(bytes)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.file.flush()
    }
}

impl StorageFile for FolderFile {
    fn sync(&mut self) -> Syncing {
        let file = match self.file.try_clone() {
            Ok(file) => file,
            Err(error) => return Syncing::ended(Err(error)),
        };
        let (told, syncing) = Syncing::begun();
        // A thread that is gone drops `told`, which ends the sync with an error.
        let _ = self.jobs.send(SyncJob { file, folder: self.unsynced_folder.take(), told });
        syncing
    }
}

/// A request to the syncing thread.
struct SyncJob {
    file: fs::File,
    folder: Option<PathBuf>,
    told: mpsc::Sender<io::Result<()>>,
}

impl SyncJob {
    fn run(self) {
        let folder = self.folder.map_or(Ok(()), |folder| vencejo_store::sync_folder(&folder));
        // The receiver is gone when the recorder has ended.
        let _ = self.told.send(folder.and_then(|()| self.file.sync_data()));
    }
}

/// The file names of a recorder: `PREFIX2026-11-21T08-50-12Z.ENDING`.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Names {
    /// Before the time: empty, or ends with `_`. The quota counts files of any such prefix.
    pub prefix: String,
    /// After the dot.
    pub ending: &'static str,
}

impl Names {
    /// Names without a prefix.
    pub const fn plain(ending: &'static str) -> Self {
        Self { prefix: String::new(), ending }
    }

    /// The name of a file begun at that time, with a number when the name is taken.
    pub(super) fn name(&self, stamp: &str, number: u32) -> String {
        let Self { prefix, ending } = self;
        if number == 0 { format!("{prefix}{stamp}.{ending}") } else { format!("{prefix}{stamp}-{number}.{ending}") }
    }

    /// The sort key by age of a recording's name; `None` for any other name. Names from before the clock of a computer
    /// without a battery was set sort last: their age is unknown.
    pub(super) fn age_key(&self, name: &str) -> Option<(bool, String, u32)> {
        let stem = name.strip_suffix(self.ending)?.strip_suffix('.')?;
        let stem = if self.prefix.is_empty() { stem } else { stem.rsplit_once('_')?.1 };
        let (stamp, rest) = stem.split_at_checked(20)?;
        let pattern = b"dddd-dd-ddTdd-dd-ddZ";
        let fits = stamp
            .bytes()
            .zip(pattern)
            .all(|(byte, kind)| if *kind == b'd' { byte.is_ascii_digit() } else { byte == *kind });
        if !fits {
            return None;
        }
        let number = match rest {
            "" => 0,
            rest => rest.strip_prefix('-')?.parse().ok()?,
        };
        Some((stamp < CLOCK_SET, stamp.to_owned(), number))
    }
}

/// No recording is older than this.
const CLOCK_SET: &str = "2020";

/// The UTC time of a file name. Days to a date as in Howard Hinnant, "chrono-Compatible Low-Level Date Algorithms".
pub(super) fn utc_stamp(unix_s: u64) -> String {
    let (days, second) = (unix_s / 86_400, unix_s % 86_400);
    let shifted = days + 719_468;
    let era = shifted / 146_097;
    let day_of_era = shifted % 146_097;
    let year_of_era = (day_of_era - day_of_era / 1460 + day_of_era / 36_524 - day_of_era / 146_096) / 365;
    let day_of_year = day_of_era - (365 * year_of_era + year_of_era / 4 - year_of_era / 100);
    let month_from_march = (5 * day_of_year + 2) / 153;
    let day = day_of_year - (153 * month_from_march + 2) / 5 + 1;
    let month = if month_from_march < 10 { month_from_march + 3 } else { month_from_march - 9 };
    let year = year_of_era + era * 400 + u64::from(month <= 2);
    format!("{year:04}-{month:02}-{day:02}T{:02}-{:02}-{:02}Z", second / 3600, second / 60 % 60, second % 60)
}
