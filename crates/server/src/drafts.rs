//! The draft of the plan, kept on the server so that it is not in one browser alone: one for all operators, with a
//! revision, so that nobody overwrites changes that they have not seen. Conflicting drafts are kept too.

use std::path::PathBuf;
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::{SystemTime, UNIX_EPOCH};

use vencejo_store::{Access, Lock};

use crate::dto::cause::Cause;
use crate::dto::storage::{DraftText, NewPlanDraft, PlanDraft, PlanDrafts};
use crate::problem::Problem;

/// Largest draft as JSON, bytes: some 5,000 items.
pub const MAX_DRAFT: usize = 1024 * 1024;
/// Conflicting drafts that are kept, one per author; the oldest is dropped first.
const MAX_OTHERS: usize = 4;
/// Largest file, bytes.
const MAX_FILE: u64 = (MAX_DRAFT as u64 + 4096) * (MAX_OTHERS as u64 + 1);
/// Longest author, characters.
const MAX_AUTHOR: usize = 64;

/// Why the draft is kept in memory only.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum DraftFault {
    /// The file cannot be read or written.
    Unwritable(String),
    /// The file was damaged and has been renamed.
    SetAside(String),
}

/// The drafts of a server. Calls block on disk access.
#[derive(Debug, Default)]
pub struct Drafts {
    /// `None`: in memory only.
    path: Option<PathBuf>,
    state: Mutex<State>,
}

#[derive(Debug, Default)]
struct State {
    /// As read or written last.
    kept: PlanDrafts,
    fault: Option<DraftFault>,
}

impl Drafts {
    /// Drafts stored in a file, which need not exist yet.
    pub fn new(path: Option<PathBuf>) -> Self {
        let drafts = Self { path, state: Mutex::default() };
        drafts.read(&mut drafts.lock());
        drafts
    }

    /// Current and conflicting drafts.
    pub fn get(&self) -> PlanDrafts {
        let mut state = self.lock();
        self.read(&mut state);
        state.kept.clone()
    }

    /// Why the draft is kept in memory only.
    pub fn fault(&self) -> Option<DraftFault> {
        self.lock().fault.clone()
    }

    /// Stores a draft that is based on the current one.
    ///
    /// # Errors
    /// [`Cause::DraftConflict`] when it is based on an older one: then both are kept. [`Cause::TooLarge`],
    /// [`Cause::InvalidRequest`].
    pub fn put(&self, new: NewPlanDraft, by: String) -> Result<PlanDraft, Problem> {
        check(&new)?;
        self.change(|kept| {
            let revision = kept.current.as_ref().map_or(0, |current| current.revision);
            let draft =
                PlanDraft { revision: revision + 1, author: new.author, by, saved_unix_s: unix_s(), plan: new.plan };
            if revision != new.base {
                let problem = conflict(kept);
                keep_beside(kept, draft);
                return Err(problem);
            }
            kept.others.retain(|other| other.author != draft.author);
            if let Some(before) = kept.current.replace(draft.clone())
                && before.author != draft.author
            {
                keep_beside(kept, before);
            }
            Ok(draft)
        })
    }

    /// Removes the draft and the conflicting ones.
    ///
    /// # Errors
    /// [`Cause::DraftConflict`] when the current draft has another revision.
    pub fn remove(&self, base: u64) -> Result<(), Problem> {
        self.change(|kept| {
            if kept.current.as_ref().map_or(0, |current| current.revision) != base {
                return Err(conflict(kept));
            }
            // The revision continues, so that a change based on an old draft does not fit a new one.
            let empty = |current: PlanDraft| PlanDraft { revision: base + 1, plan: DraftText::empty(), ..current };
            *kept = PlanDrafts { current: kept.current.take().map(empty), others: Vec::new() };
            Ok(())
        })
    }

    /// Applies a change to the file's present content, which another instance may have written.
    fn change<T>(&self, change: impl FnOnce(&mut PlanDrafts) -> Result<T, Problem>) -> Result<T, Problem> {
        let mut state = self.lock();
        let lock = self.path.as_ref().map(|path| Lock::of(path, vencejo_store::lock::PATIENCE));
        self.read(&mut state);
        let result = change(&mut state.kept);
        if let Some(path) = &self.path {
            let text = serde_json::to_vec(&state.kept).expect("invariant: the API's types are JSON");
            let written = match lock {
                Some(Err(error)) => Err(error),
                _ => vencejo_store::write(path, &text, Access::Owner),
            };
            match written {
                Err(error) => state.fault = Some(DraftFault::Unwritable(error.to_string())),
                Ok(()) if matches!(state.fault, Some(DraftFault::Unwritable(_))) => state.fault = None,
                Ok(()) => {}
            }
        }
        result
    }

    /// Reads the file, unless memory is newer because it could not be written.
    fn read(&self, state: &mut State) {
        let Some(path) = &self.path else { return };
        if matches!(state.fault, Some(DraftFault::Unwritable(_))) && state.kept != PlanDrafts::default() {
            return;
        }
        let bytes = match std::fs::metadata(path) {
            Ok(about) if about.len() > MAX_FILE => Ok(Vec::new()),
            Ok(_) => std::fs::read(path),
            Err(error) => Err(error),
        };
        match bytes {
            Err(error) if error.kind() == std::io::ErrorKind::NotFound => {}
            Err(error) => state.fault = Some(DraftFault::Unwritable(error.to_string())),
            Ok(bytes) => match serde_json::from_slice(&bytes) {
                Ok(kept) => state.kept = kept,
                Err(_) => {
                    state.fault = Some(match vencejo_store::set_aside(path) {
                        Ok(aside) => DraftFault::SetAside(aside.display().to_string()),
                        Err(error) => DraftFault::Unwritable(error.to_string()),
                    });
                }
            },
        }
    }

    fn lock(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

fn keep_beside(kept: &mut PlanDrafts, draft: PlanDraft) {
    kept.others.retain(|other| other.author != draft.author);
    kept.others.insert(0, draft);
    kept.others.truncate(MAX_OTHERS);
}

fn conflict(kept: &PlanDrafts) -> Problem {
    let (revision, by) = kept.current.as_ref().map_or((0, ""), |current| (current.revision, current.by.as_str()));
    let cause = Cause::DraftConflict { revision, by: by.to_owned() };
    Problem::new(cause, format!("the draft is at revision {revision} by now; yours is kept as a conflicting draft"))
        .remedy("GET /api/v1/draft, then send yours again based on that revision, or use the current draft")
}

fn check(new: &NewPlanDraft) -> Result<(), Problem> {
    let is_plain = |byte: u8| byte.is_ascii_alphanumeric() || b"-_".contains(&byte);
    if !(1..=MAX_AUTHOR).contains(&new.author.len()) || !new.author.bytes().all(is_plain) {
        return Err(Problem::invalid(format!("author: takes 1 to {MAX_AUTHOR} letters, digits, - and _")));
    }
    let bytes = new.plan.get().len();
    if bytes > MAX_DRAFT {
        let cause = Cause::TooLarge { what: "the draft".to_owned(), count: bytes as u64, limit: MAX_DRAFT as u64 };
        return Err(Problem::new(cause, format!("the draft has {bytes} bytes, should be at most {MAX_DRAFT}")));
    }
    Ok(())
}

fn unix_s() -> f64 {
    SystemTime::now().duration_since(UNIX_EPOCH).map_or(0.0, |since| since.as_secs_f64())
}

#[cfg(test)]
mod tests {
    use std::path::Path;
    use std::sync::atomic::{AtomicU32, Ordering};

    use serde_json::json;

    use super::*;

    struct Folder(PathBuf);

    impl Folder {
        fn new() -> Self {
            static COUNT: AtomicU32 = AtomicU32::new(0);
            let name = format!("vencejo-drafts-{}-{}", std::process::id(), COUNT.fetch_add(1, Ordering::Relaxed));
            let path = std::env::temp_dir().join(name);
            std::fs::create_dir_all(&path).expect("a folder");
            Self(path)
        }
    }

    impl Drop for Folder {
        fn drop(&mut self) {
            let _ = std::fs::remove_dir_all(&self.0);
        }
    }

    fn draft(base: u64, author: &str, count: u32) -> NewPlanDraft {
        let text = json!({"base": base, "author": author, "plan": {"items": vec![1; count as usize]}});
        serde_json::from_str(&text.to_string()).expect("a draft")
    }

    fn at(path: &Path) -> Drafts {
        Drafts::new(Some(path.to_owned()))
    }

    #[test]
    fn a_draft_survives_a_restart_and_nobody_overwrites_what_they_have_not_seen() {
        let folder = Folder::new();
        let path = folder.0.join("plan-draft.json");
        let drafts = at(&path);
        assert_eq!(drafts.get(), PlanDrafts::default());
        assert_eq!(drafts.put(draft(0, "a", 1), "Ana".into()).expect("taken").revision, 1);
        assert_eq!(drafts.put(draft(1, "a", 2), "Ana".into()).expect("taken").revision, 2);
        // Another browser, at another instance of the server on the same folder.
        let other = at(&path);
        let refused = other.put(draft(1, "b", 3), "Ben".into()).expect_err("it had seen 1");
        assert_eq!(refused.0.cause, Cause::DraftConflict { revision: 2, by: "Ana".into() });
        let both = at(&path).get();
        let current = both.current.expect("one");
        assert_eq!((current.revision, &*current.by, current.plan.get()), (2, "Ana", r#"{"items":[1,1]}"#));
        assert_eq!((both.others.len(), &*both.others[0].by), (1, "Ben"), "both are kept");
        // Having seen it, Ben overwrites it; Ana's is kept.
        assert_eq!(other.put(draft(2, "b", 3), "Ben".into()).expect("taken").revision, 3);
        let kept = drafts.get();
        assert_eq!(kept.others.iter().map(|other| &*other.by).collect::<Vec<_>>(), ["Ana"]);
        assert!(drafts.remove(2).is_err());
        drafts.remove(3).expect("removed");
        let kept = at(&path).get();
        assert!(kept.others.is_empty() && kept.current.expect("its count").plan == DraftText::empty());
        assert!(other.put(draft(3, "b", 1), "Ben".into()).is_err(), "an old change does not fit");
    }

    #[test]
    fn of_many_at_once_one_wins_and_the_others_are_told() {
        let folder = Folder::new();
        let path = folder.0.join("plan-draft.json");
        let won: usize = std::thread::scope(|scope| {
            let racers: Vec<_> = (0..5)
                .map(|number| {
                    let path = &path;
                    scope.spawn(move || at(path).put(draft(0, &format!("a{number}"), 1), String::new()).is_ok())
                })
                .collect();
            racers.into_iter().map(|racer| usize::from(racer.join().expect("no panic"))).sum()
        });
        assert_eq!(won, 1);
        assert_eq!(at(&path).get().others.len(), 4, "nothing is lost");
    }

    #[test]
    fn what_is_too_large_or_of_nobody_is_refused() {
        let drafts = Drafts::new(None);
        let large = json!({"base": 0, "author": "a", "plan": {"x": "y".repeat(MAX_DRAFT)}}).to_string();
        let large = serde_json::from_str(&large).expect("a draft");
        assert!(matches!(drafts.put(large, String::new()).expect_err("too large").0.cause, Cause::TooLarge { .. }));
        for author in ["", "a b", &"a".repeat(65)] {
            assert!(drafts.put(draft(0, author, 1), String::new()).is_err(), "{author}");
        }
        for author in 0..20 {
            let _ = drafts.put(draft(99, &format!("a{author}"), 1), String::new());
        }
        assert_eq!(drafts.get().others.len(), MAX_OTHERS);
    }

    #[test]
    fn without_a_disk_it_is_in_memory_and_a_damaged_file_is_set_aside() {
        let folder = Folder::new();
        std::fs::write(folder.0.join("file"), "no folder").expect("written");
        let drafts = at(&folder.0.join("file/plan-draft.json"));
        drafts.put(draft(0, "a", 1), "Ana".into()).expect("taken");
        assert!(matches!(drafts.fault(), Some(DraftFault::Unwritable(_))), "{:?}", drafts.fault());
        assert_eq!(drafts.get().current.expect("in memory").revision, 1);
        assert_eq!(drafts.put(draft(1, "a", 1), "Ana".into()).expect("taken").revision, 2);
        let path = folder.0.join("plan-draft.json");
        std::fs::write(&path, "{\"current\": 7").expect("written");
        let drafts = at(&path);
        let Some(DraftFault::SetAside(aside)) = drafts.fault() else { panic!("{:?}", drafts.fault()) };
        assert_eq!(std::fs::read_to_string(aside).expect("there"), "{\"current\": 7");
        drafts.put(draft(0, "a", 1), "Ana".into()).expect("a new one");
    }
}
