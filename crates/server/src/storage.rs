//! Storage faults, collected once for all interfaces.

use std::time::Duration;

use tokio::time::{MissedTickBehavior, interval};
use vencejo_link::{RecorderState, RecorderStatus};
use vencejo_maps::FolderProblem;
use vencejo_proto::MonoTime;
use vencejo_store::LowSpace;

use crate::convert;
use crate::drafts::DraftFault;
use crate::dto::storage::{StorageClass, StorageFault, StorageProblem};
use crate::state::{Alive, App, closed};

/// Interval at which folders are checked for free space and writability.
const LOOK_AT_DISK: Duration = Duration::from_secs(2);

/// Reports storage faults to the clients until the server is closed. Those of the flight recorder are reported as soon
/// as its state changes; folders are checked off the async threads, since a disk may not respond.
pub async fn tell(app: App, _alive: Alive) {
    let (mut recorder, mut closing) = (app.station().recorder_changes(), app.closing());
    let mut ticks = interval(LOOK_AT_DISK);
    ticks.set_missed_tick_behavior(MissedTickBehavior::Delay);
    let mut folders = Vec::new();
    let mut looking: Option<(tokio::task::JoinHandle<Vec<StorageProblem>>, MonoTime)> = None;
    loop {
        let recording = recorder.borrow().as_ref().and_then(recorder_problem);
        let problems = recording.into_iter().chain(folders.iter().cloned()).collect();
        app.tell_storage_problems(problems);
        let since = looking.as_ref().map(|(_, since)| *since);
        let looked = async {
            match &mut looking {
                Some((looking, _)) => looking.await.unwrap_or_default(),
                None => std::future::pending().await,
            }
        };
        tokio::select! {
            () = closed(&mut closing) => return,
            // An error means that the station is gone, which also ends this task.
            changed = recorder.changed() => if changed.is_err() { return },
            found = looked => (folders, looking) = (found, None),
            _ = ticks.tick() => match since {
                // The check of the last tick has not returned: the disk does not respond.
                Some(since) => folders = vec![stalled(convert::seconds(since))],
                None => {
                    let since = app.now();
                    let (app, known) = (app.clone(), folders.clone());
                    let look = tokio::task::spawn_blocking(move || folder_problems(&app, &known));
                    looking = Some((look, since));
                }
            },
        }
    }
}

/// Why telemetry is not recorded.
fn recorder_problem(status: &RecorderStatus) -> Option<StorageProblem> {
    let fault = match &status.state {
        RecorderState::Starting | RecorderState::Recording { .. } | RecorderState::Closed => return None,
        RecorderState::LowSpace { free_bytes, floor_bytes } => low_space(*free_bytes, *floor_bytes),
        RecorderState::Failing { error } => StorageFault::Unwritable { reason: error.clone() },
        RecorderState::Stalled => StorageFault::Stalled,
    };
    let text = format!("telemetry is not being recorded: {}", status.state.problem().unwrap_or_default());
    Some(StorageProblem {
        what: StorageClass::Telemetry,
        name: None,
        fault,
        since_s: convert::seconds(status.since),
        text,
    })
}

/// The fault reported when checking the folders takes too long.
fn stalled(since_s: f64) -> StorageProblem {
    let text = "maps are shown, but not stored: the disk does not respond".to_owned();
    StorageProblem { since_s, ..of(StorageClass::Maps, StorageFault::Stalled, text) }
}

/// Faults of the folders of maps, missions, drafts and cameras, with their start times as far as `known` has them.
/// Accesses the disk.
fn folder_problems(app: &App, known: &[StorageProblem]) -> Vec<StorageProblem> {
    let now_s = convert::seconds(app.now());
    let since = |mut problem: StorageProblem| {
        problem.since_s = known.iter().find(|other| other.is_same(&problem)).map_or(now_s, |other| other.since_s);
        problem
    };
    found(app).into_iter().map(since).collect()
}

fn found(app: &App) -> Vec<StorageProblem> {
    let maps = app.maps().map(vencejo_maps::Maps::problems).unwrap_or_default();
    let maps = maps.into_iter().map(|problem| match problem {
        FolderProblem::Unwritable(reason) => {
            let text = format!("maps are shown, but not stored: {reason}");
            of(StorageClass::Maps, StorageFault::Unwritable { reason }, text)
        }
        FolderProblem::LowSpace(low) => {
            let LowSpace { free_bytes, floor_bytes, .. } = low;
            of(StorageClass::Maps, low_space(free_bytes, floor_bytes), format!("maps are shown, but not stored: {low}"))
        }
        FolderProblem::SetAside { source, aside } => {
            let text = format!(
                "the cache of map source '{source}' was damaged; it was renamed to {aside}, and a new one was started"
            );
            let fault = StorageFault::SetAside { name: file_name(&aside) };
            StorageProblem { name: Some(source), ..of(StorageClass::Maps, fault, text) }
        }
    });
    let draft = app.drafts().fault().map(|fault| match fault {
        DraftFault::Unwritable(reason) => {
            let text = format!("the plan's draft is kept in memory only: {reason}");
            of(StorageClass::Draft, StorageFault::Unwritable { reason }, text)
        }
        DraftFault::SetAside(aside) => {
            let text = format!("the file of the plan's draft was damaged; it was renamed to {aside}");
            of(StorageClass::Draft, StorageFault::SetAside { name: file_name(&aside) }, text)
        }
    });
    let video = app.video().cameras().into_iter().filter_map(|camera| {
        let reason = camera.status().recording?.problem?;
        let text = format!("camera '{}' is not being recorded: {reason}", camera.name());
        let name = Some(camera.name().to_owned());
        Some(StorageProblem { name, ..of(StorageClass::Video, StorageFault::Ended { reason }, text) })
    });
    let tokens = app.token_fault().map(|fault| {
        let text = match &fault {
            StorageFault::SetAside { name } => {
                format!("the file of the tokens was damaged; it was renamed to {name}, and new tokens were created")
            }
            StorageFault::Unwritable { reason } => format!("the tokens are valid for this run only: {reason}"),
            _ => "the tokens are valid for this run only".to_owned(),
        };
        of(StorageClass::Tokens, fault, text)
    });
    let signing = app.station().signing_fault().map(|reason| {
        let text = format!("frames are neither signed nor verified: {reason}");
        of(StorageClass::Signing, StorageFault::Unreadable { reason }, text)
    });
    let times = app.station().signing_times_fault().map(|reason| {
        let text =
            format!("frames are signed and verified, but after a restart recorded frames could be replayed: {reason}");
        of(StorageClass::SigningTimes, StorageFault::Unwritable { reason }, text)
    });
    let missions = app.station().missions_fault().map(|reason| {
        let text = format!("a doubt about the mission on board ends with this program: {reason}");
        of(StorageClass::Missions, StorageFault::Unwritable { reason }, text)
    });
    maps.chain(missions).chain(draft).chain(tokens).chain(signing).chain(times).chain(video).collect()
}

const fn of(what: StorageClass, fault: StorageFault, text: String) -> StorageProblem {
    StorageProblem { what, name: None, fault, since_s: 0.0, text }
}

const fn low_space(free_bytes: u64, floor_bytes: u64) -> StorageFault {
    StorageFault::LowSpace { free_mb: free_bytes / 1_000_000, floor_mb: floor_bytes / 1_000_000 }
}

/// Clients learn the file name, not the folder.
fn file_name(path: &str) -> String {
    std::path::Path::new(path).file_name().map_or_else(String::new, |name| name.to_string_lossy().into_owned())
}
