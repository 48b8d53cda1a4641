//! Writing a file as a whole: into a temporary one of the same folder, forced to the disk, renamed, and the folder
//! forced to the disk too. Whoever reads, now or after a power cut, finds the file as it was or as it is to be, never
//! half of it.

use std::ffi::{OsStr, OsString};
use std::fs::{self, File, OpenOptions};
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Duration;

/// How old a temporary file must be to be one that a crash left behind.
const LEFTOVER: Duration = Duration::from_secs(3600);
/// The end of the names of temporary files.
const TEMPORARY: &str = ".tmp";

/// Who may read a file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Access {
    /// Its owner alone: it may hold keys, or where somebody flies.
    Owner,
    /// Whoever the system lets, as with any file that a person saves. A file that is replaced keeps who may read it.
    Usual,
}

/// What is about to be done; tests fail it here.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Step {
    Create,
    Write,
    Sync,
    Rename,
    SyncFolder,
}

/// What is asked before each step.
type Gate<'a> = &'a mut dyn FnMut(Step) -> io::Result<()>;

/// How the finished temporary file gets its name.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Naming {
    Replace,
    /// Only where nothing has the name.
    New,
}

/// Writes a file as a whole, in the place of one that may be there. The folder of one of our own, which its owner alone
/// reads, is made where it is missing; where a person wants a file, a folder that is missing is a slip of the pen.
///
/// A link is followed: what it points to is replaced. What is no plain file, such as a pipe, is written straight into.
///
/// # Errors
/// Whatever the disk says. The file is then as it was, unless only the last step failed.
pub fn write(path: &Path, bytes: &[u8], access: Access) -> io::Result<()> {
    put(path, bytes, access, Naming::Replace, &mut |_| Ok(())).map(drop)
}

/// Writes a file as a whole where there is none of that name; whether that was so.
///
/// # Errors
/// Whatever the disk says.
pub fn create(path: &Path, bytes: &[u8], access: Access) -> io::Result<bool> {
    put(path, bytes, access, Naming::New, &mut |_| Ok(()))
}

/// Puts a finished file under its name, in the place of one that may be there; both must be on the same disk.
///
/// # Errors
/// Whatever the disk says.
pub fn install(temporary: &Path, path: &Path) -> io::Result<()> {
    File::open(temporary)?.sync_all()?;
    fs::rename(temporary, path)?;
    sync_folder(folder_of(path))
}

/// Makes a folder with all above it, and forces their entries to the disk.
///
/// # Errors
/// Whatever the disk says.
pub fn make_folder(folder: &Path) -> io::Result<()> {
    let missing: Vec<_> = folder.ancestors().take_while(|path| !is_here(path) && !path.is_dir()).collect();
    fs::create_dir_all(folder)?;
    missing.into_iter().try_for_each(|made| sync_folder(folder_of(made)))
}

/// Whether files can be made in a folder, by making one; the folder is made where it is missing.
///
/// # Errors
/// Whatever the disk says: it is read-only, full, or not ours.
pub fn try_folder(folder: &Path) -> io::Result<()> {
    make_folder(folder)?;
    let probe = folder.join(temporary_name(OsStr::new("probe")));
    OpenOptions::new().write(true).create_new(true).open(&probe)?;
    fs::remove_file(probe)
}

/// Makes the names in a folder durable.
///
/// # Errors
/// Whatever the disk says.
pub fn sync_folder(folder: &Path) -> io::Result<()> {
    #[cfg(unix)]
    File::open(folder)?.sync_all()?;
    #[cfg(not(unix))]
    let _ = folder;
    Ok(())
}

/// Gives a damaged file another name beside it, which nothing had, so that what is in it can still be saved. Returns
/// it.
///
/// # Errors
/// Whatever the disk says.
pub fn set_aside(path: &Path) -> io::Result<PathBuf> {
    let name = |number: u32| {
        let end = if number == 1 { ".broken".to_owned() } else { format!(".broken-{number}") };
        with_end(path, &end)
    };
    let free = (1..=1000).map(name).find(|name| !name.exists());
    let free = free.ok_or_else(|| io::Error::other(format!("too many damaged files are beside {}", path.display())))?;
    fs::rename(path, &free)?;
    sync_folder(folder_of(path))?;
    Ok(free)
}

/// A path with more at its end.
pub(crate) fn with_end(path: &Path, end: &str) -> PathBuf {
    let mut name = path.as_os_str().to_owned();
    name.push(end);
    PathBuf::from(name)
}

/// The folder that a file is in.
pub(crate) fn folder_of(path: &Path) -> &Path {
    path.parent().filter(|folder| !is_here(folder)).unwrap_or_else(|| Path::new("."))
}

fn is_here(path: &Path) -> bool {
    path.as_os_str().is_empty()
}

fn put(path: &Path, bytes: &[u8], access: Access, naming: Naming, gate: Gate<'_>) -> io::Result<bool> {
    let target = match fs::symlink_metadata(path) {
        Ok(about) if about.is_symlink() => fs::canonicalize(path).unwrap_or_else(|_| path.to_owned()),
        _ => path.to_owned(),
    };
    let before = fs::metadata(&target).ok();
    if let Some(about) = &before {
        if naming == Naming::New {
            return Ok(false);
        }
        if !about.is_file() {
            return OpenOptions::new().write(true).open(&target)?.write_all(bytes).map(|()| true);
        }
    }
    let folder = folder_of(&target);
    if access == Access::Owner {
        make_folder(folder)?;
    }
    let name = target.file_name().ok_or_else(|| io::Error::other(format!("{} names no file", path.display())))?;
    remove_leftovers(folder, name);
    let temporary = folder.join(temporary_name(name));
    let kept = before.filter(|_| access == Access::Usual).map(|about| about.permissions());
    let result = fill(&temporary, bytes, access, kept, gate).and_then(|()| {
        gate(Step::Rename)?;
        name_it(&temporary, &target, naming)
    });
    if !matches!(result, Ok(true)) {
        // What went wrong is told; that this failed too would add nothing.
        let _ = fs::remove_file(&temporary);
    }
    if result? {
        gate(Step::SyncFolder)?;
        sync_folder(folder)?;
        return Ok(true);
    }
    Ok(false)
}

fn fill(
    temporary: &Path,
    bytes: &[u8],
    access: Access,
    kept: Option<fs::Permissions>,
    gate: Gate<'_>,
) -> io::Result<()> {
    gate(Step::Create)?;
    let mut options = OpenOptions::new();
    options.write(true).create_new(true);
    #[cfg(unix)]
    if access == Access::Owner {
        std::os::unix::fs::OpenOptionsExt::mode(&mut options, 0o600);
    }
    #[cfg(not(unix))]
    let _ = access;
    let mut file = options.open(temporary)?;
    if let Some(permissions) = kept {
        file.set_permissions(permissions)?;
    }
    gate(Step::Write)?;
    file.write_all(bytes)?;
    gate(Step::Sync)?;
    file.sync_all()
}

fn name_it(temporary: &Path, target: &Path, naming: Naming) -> io::Result<bool> {
    if naming == Naming::Replace {
        return fs::rename(temporary, target).map(|()| true);
    }
    match fs::hard_link(temporary, target) {
        Ok(()) => {
            // One more name for the same file is no harm.
            let _ = fs::remove_file(temporary);
            Ok(true)
        }
        Err(error) if error.kind() == io::ErrorKind::AlreadyExists => Ok(false),
        // A disk that has no links, such as a card from a camera.
        Err(_) if target.exists() => Ok(false),
        Err(_) => fs::rename(temporary, target).map(|()| true),
    }
}

fn temporary_name(name: &OsStr) -> OsString {
    static COUNT: AtomicU64 = AtomicU64::new(0);
    let count = COUNT.fetch_add(1, Ordering::Relaxed);
    let mut temporary = OsString::from(".");
    temporary.push(name);
    temporary.push(format!(".{}-{count}{TEMPORARY}", std::process::id()));
    temporary
}

/// Removes what a crash left of earlier writings of a file. Another process may be writing: only what is old goes, and
/// nothing of a process that lives, since a clock that was set, or a machine that slept, makes every file look old.
fn remove_leftovers(folder: &Path, name: &OsStr) {
    let begin = format!(".{}.", name.to_string_lossy());
    let Ok(files) = fs::read_dir(folder) else { return };
    for file in files.flatten() {
        let found = file.file_name();
        let found = found.to_string_lossy();
        let Some(rest) = found.strip_prefix(&begin).and_then(|rest| rest.strip_suffix(TEMPORARY)) else { continue };
        if rest.split('-').next().is_some_and(is_alive) {
            continue;
        }
        let age = file.metadata().and_then(|about| about.modified()).ok().and_then(|at| at.elapsed().ok());
        if age.is_some_and(|age| age > LEFTOVER) {
            let _ = fs::remove_file(file.path());
        }
    }
}

/// Whether a process of this number is there, as far as the system shows it (Linux does).
fn is_alive(process: &str) -> bool {
    process.parse::<u32>().is_ok_and(|process| Path::new("/proc").join(process.to_string()).exists())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::Scratch;

    const STEPS: [Step; 5] = [Step::Create, Step::Write, Step::Sync, Step::Rename, Step::SyncFolder];

    // fault 57: write, sync, rename, sync of the folder: in this order
    #[test]
    fn each_step_is_taken_in_the_order_that_a_power_cut_demands() {
        let folder = Scratch::new("order");
        let mut taken = Vec::new();
        let mut note = |step| {
            taken.push(step);
            Ok(())
        };
        put(&folder.path().join("a"), b"new", Access::Owner, Naming::Replace, &mut note).expect("written");
        assert_eq!(taken, STEPS);
    }

    // fault 57: a failure at each step leaves the old file or the new one
    #[test]
    fn a_failure_at_any_step_leaves_the_old_file_or_the_new_and_nothing_else() {
        for failing in STEPS {
            let folder = Scratch::new("steps");
            let path = folder.path().join("a");
            write(&path, b"old", Access::Owner).expect("written");
            let full = || io::Error::from_raw_os_error(28);
            let mut gate = |step| if step == failing { Err(full()) } else { Ok(()) };
            let error = put(&path, b"new", Access::Owner, Naming::Replace, &mut gate).expect_err("it failed");
            assert_eq!(error.raw_os_error(), Some(28), "{failing:?}");
            let expected: &[u8] = if failing == Step::SyncFolder { b"new" } else { b"old" };
            assert_eq!(fs::read(&path).expect("there"), expected, "{failing:?}");
            assert_eq!(folder.names(), ["a"], "{failing:?}");
        }
    }

    #[test]
    fn only_one_of_many_makes_a_new_file() {
        let folder = Scratch::new("create");
        let path = folder.path().join("deep/er/tokens");
        let made = std::thread::scope(|scope| {
            let writers: Vec<_> = (0..16_u8)
                .map(|i| {
                    scope.spawn({
                        let path = &path;
                        move || create(path, &[i; 1000], Access::Owner)
                    })
                })
                .collect();
            writers.into_iter().map(|writer| writer.join().expect("no panic").expect("no error")).collect::<Vec<_>>()
        });
        assert_eq!(made.iter().filter(|made| **made).count(), 1);
        let bytes = fs::read(&path).expect("there");
        assert_eq!(bytes, vec![bytes[0]; 1000]);
        assert!(made[usize::from(bytes[0])], "it holds what its maker wrote");
        assert_eq!(fs::read_dir(path.parent().expect("a folder")).expect("listed").count(), 1);
    }

    #[cfg(unix)]
    #[test]
    fn who_may_read_and_links_and_pipes() {
        use std::os::unix::fs::{PermissionsExt, symlink};
        let folder = Scratch::new("kinds");
        let mode = |path: &Path| fs::metadata(path).expect("there").permissions().mode() & 0o777;
        let (own, usual, link) = (folder.path().join("own"), folder.path().join("usual"), folder.path().join("link"));
        write(&own, b"key", Access::Owner).expect("written");
        assert_eq!(mode(&own), 0o600);
        fs::write(&usual, b"old").expect("written");
        fs::set_permissions(&usual, fs::Permissions::from_mode(0o664)).expect("set");
        symlink(&usual, &link).expect("linked");
        write(&link, b"new", Access::Usual).expect("written");
        assert!(fs::symlink_metadata(&link).expect("there").is_symlink());
        assert_eq!((fs::read(&usual).expect("there"), mode(&usual)), (b"new".to_vec(), 0o664));
        write(Path::new("/dev/null"), b"gone", Access::Usual).expect("written");
        assert!(!fs::metadata("/dev/null").expect("there").is_file());
    }

    #[test]
    fn what_is_damaged_is_set_aside_and_never_overwritten() {
        let folder = Scratch::new("aside");
        let path = folder.path().join("tiles");
        for text in ["first", "second"] {
            fs::write(&path, text).expect("written");
            set_aside(&path).expect("moved");
        }
        assert_eq!(folder.names(), ["tiles.broken", "tiles.broken-2"]);
        assert_eq!(fs::read_to_string(folder.path().join("tiles.broken")).expect("there"), "first");
    }

    #[test]
    fn leftovers_of_a_crash_go_when_they_are_old() {
        let folder = Scratch::new("leftovers");
        // No process has numbers so large: Linux ends at 2^22.
        let (old, young, other) = (".a.4294967001-1.tmp", ".a.4294967002-1.tmp", ".b.4294967001-1.tmp");
        for name in [old, young, other] {
            fs::write(folder.path().join(name), "half").expect("written");
        }
        for name in [old, other] {
            let file = File::options().write(true).open(folder.path().join(name)).expect("opened");
            file.set_modified(std::time::SystemTime::now() - 2 * LEFTOVER).expect("set");
        }
        write(&folder.path().join("a"), b"whole", Access::Owner).expect("written");
        assert_eq!(folder.names(), [young, other, "a"]);
    }

    // fault 61: a clock an hour ahead takes no file away from whoever is writing it
    #[cfg(target_os = "linux")]
    #[test]
    fn what_a_living_process_writes_is_no_leftover_however_old_it_looks() {
        let folder = Scratch::new("alive");
        let being_written = format!(".a.{}-7000.tmp", std::process::id());
        let path = folder.path().join(&being_written);
        fs::write(&path, "half").expect("written");
        let file = File::options().write(true).open(&path).expect("opened");
        file.set_modified(std::time::SystemTime::now() - 2 * LEFTOVER).expect("set");
        write(&folder.path().join("a"), b"whole", Access::Owner).expect("written");
        assert_eq!(folder.names(), [being_written.as_str(), "a"]);
    }
}
