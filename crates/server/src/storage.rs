//! What of the server's disk does not work, said once for all front doors.

use vencejo_link::{RecorderState, RecorderStatus};
use vencejo_maps::FolderProblem;
use vencejo_store::LowSpace;

use crate::convert;
use crate::drafts::DraftFault;
use crate::dto::storage::{StorageClass, StorageFault, StorageProblem};
use crate::state::App;

/// Why no telemetry is recorded.
pub fn recorder_problem(status: &RecorderStatus) -> Option<StorageProblem> {
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

/// What is said when looking at the folders takes too long.
pub fn stalled(since_s: f64) -> StorageProblem {
    let text = "maps are shown, but none are kept: the disk does not answer".to_owned();
    StorageProblem { since_s, ..of(StorageClass::Maps, StorageFault::Stalled, text) }
}

/// What is wrong with the folders of maps, missions, drafts and cameras, and since when as far as `known` tells. Looks at the disk.
pub fn folder_problems(app: &App, known: &[StorageProblem]) -> Vec<StorageProblem> {
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
            let text = format!("maps are shown, but none are kept: {reason}");
            of(StorageClass::Maps, StorageFault::Unwritable { reason }, text)
        }
        FolderProblem::LowSpace(low) => {
            let LowSpace { free_bytes, floor_bytes, .. } = low;
            of(
                StorageClass::Maps,
                low_space(free_bytes, floor_bytes),
                format!("maps are shown, but none are kept: {low}"),
            )
        }
        FolderProblem::SetAside { source, aside } => {
            let text =
                format!("the cache of map source '{source}' was damaged: it is {aside} now, and a new one was begun");
            let fault = StorageFault::SetAside { name: file_name(&aside) };
            StorageProblem { name: Some(source), ..of(StorageClass::Maps, fault, text) }
        }
    });
    let draft = app.drafts().fault().map(|fault| match fault {
        DraftFault::Unwritable(reason) => {
            let text = format!("the plan's draft is kept in memory alone: {reason}");
            of(StorageClass::Draft, StorageFault::Unwritable { reason }, text)
        }
        DraftFault::SetAside(aside) => {
            let text = format!("the file of the plan's draft was damaged: it is {aside} now");
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
                format!("the file of the tokens was damaged: it is {name} now; new ones were made")
            }
            StorageFault::Unwritable { reason } => format!("the tokens are for this run alone: {reason}"),
            _ => "the tokens are for this run alone".to_owned(),
        };
        of(StorageClass::Tokens, fault, text)
    });
    let signing = app.station().signing_fault().map(|reason| {
        let text = format!("nothing is signed, and nothing is checked: {reason}");
        of(StorageClass::Signing, StorageFault::Unreadable { reason }, text)
    });
    let missions = app.station().missions_fault().map(|reason| {
        let text = format!("a doubt about the mission on board ends with this program: {reason}");
        of(StorageClass::Missions, StorageFault::Unwritable { reason }, text)
    });
    maps.chain(missions).chain(draft).chain(tokens).chain(signing).chain(video).collect()
}

const fn of(what: StorageClass, fault: StorageFault, text: String) -> StorageProblem {
    StorageProblem { what, name: None, fault, since_s: 0.0, text }
}

const fn low_space(free_bytes: u64, floor_bytes: u64) -> StorageFault {
    StorageFault::LowSpace { free_mb: free_bytes / 1_000_000, floor_mb: floor_bytes / 1_000_000 }
}

/// Clients learn the name, not the folder.
fn file_name(path: &str) -> String {
    std::path::Path::new(path).file_name().map_or_else(String::new, |name| name.to_string_lossy().into_owned())
}
