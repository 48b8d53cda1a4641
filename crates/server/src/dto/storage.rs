//! Storage faults, and the draft of a plan, which the server keeps on disk.

use serde::de::Error;
use serde::{Deserialize, Deserializer, Serialize};
use serde_json::value::RawValue;
use utoipa::ToSchema;

/// A storage fault: data that is not being kept.
#[derive(Debug, Clone, PartialEq, Serialize, ToSchema)]
pub struct StorageProblem {
    /// Kind of data.
    pub what: StorageClass,
    /// Name of the camera or map source; null for data that exists once.
    #[schema(required = true)]
    pub name: Option<String>,
    /// The fault.
    pub fault: StorageFault,
    /// Time since which it is known, seconds on the station's clock.
    pub since_s: f64,
    /// Description in English.
    pub text: String,
}

/// Kinds of data on the server's disk.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum StorageClass {
    /// Recordings of the flight recorder.
    Telemetry,
    /// Map tiles, offline areas and the list of map sources.
    Maps,
    /// Records about the missions on board.
    Missions,
    /// Camera recordings.
    Video,
    /// Draft of the plan.
    Draft,
    /// Access tokens.
    Tokens,
    /// Signing keys.
    Signing,
    /// Timestamps up to which the signing keys have been used.
    SigningTimes,
}

/// Kind of a storage fault.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, ToSchema)]
#[serde(tag = "kind", rename_all = "snake_case")]
pub enum StorageFault {
    /// The disk is too full.
    LowSpace {
        /// Free megabytes.
        free_mb: u64,
        /// Megabytes that must stay free.
        floor_mb: u64,
    },
    /// The disk cannot be written.
    Unwritable {
        /// Message of the operating system, in English.
        reason: String,
    },
    /// A file cannot be read; it is left unchanged.
    Unreadable {
        /// The reason, in English.
        reason: String,
    },
    /// The disk does not respond.
    Stalled,
    /// A damaged file was renamed, and a new one was started.
    SetAside {
        /// New name of the damaged file.
        name: String,
    },
    /// The recording ended by itself.
    Ended {
        /// The reason, in English.
        reason: String,
    },
}

impl StorageProblem {
    /// Whether both are the same fault, whatever its figures.
    pub fn is_same(&self, other: &Self) -> bool {
        (self.what, &self.name) == (other.what, &other.name)
            && std::mem::discriminant(&self.fault) == std::mem::discriminant(&other.fault)
    }
}

/// Largest nesting depth of lists and objects in a draft.
const MAX_DEPTH: usize = 64;

/// A plan as written by its author. It is kept as text, to need no more memory than it has bytes; its readers validate
/// it.
#[derive(Debug, Clone, Serialize)]
#[serde(transparent)]
pub struct DraftText(Box<RawValue>);

impl DraftText {
    /// A draft without content.
    pub fn empty() -> Self {
        Self(RawValue::from_string("{}".to_owned()).expect("invariant: an object"))
    }

    /// The JSON text, an object.
    pub fn get(&self) -> &str {
        self.0.get()
    }
}

impl PartialEq for DraftText {
    fn eq(&self, other: &Self) -> bool {
        self.get() == other.get()
    }
}

impl<'de> Deserialize<'de> for DraftText {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let text = Box::<RawValue>::deserialize(deserializer)?;
        if !text.get().starts_with('{') {
            return Err(D::Error::custom("a plan is an object"));
        }
        if depth(text.get()) > MAX_DEPTH {
            return Err(D::Error::custom(format!("a plan has at most {MAX_DEPTH} levels of lists and objects")));
        }
        Ok(Self(text))
    }
}

/// Nesting depth of lists and objects in JSON.
fn depth(text: &str) -> usize {
    let (mut now, mut most, mut is_text, mut is_escaped) = (0_usize, 0, false, false);
    for byte in text.bytes() {
        match byte {
            _ if is_escaped => is_escaped = false,
            b'\\' if is_text => is_escaped = true,
            b'"' => is_text = !is_text,
            b'[' | b'{' if !is_text => now += 1,
            b']' | b'}' if !is_text => now = now.saturating_sub(1),
            _ => {}
        }
        most = most.max(now);
    }
    most
}

/// Draft of a plan, shared by all operators.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct PlanDraft {
    /// Revision number, incremented with each change.
    pub revision: u64,
    /// Browser or program that wrote it.
    pub author: String,
    /// Name of the session that wrote it.
    pub by: String,
    /// Time of saving, seconds since 1970 on the server's clock.
    pub saved_unix_s: f64,
    /// The plan as written by its author; readers must validate it.
    #[schema(value_type = Object)]
    pub plan: DraftText,
}

/// The current draft and conflicting drafts.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct PlanDrafts {
    /// The current draft; null when there is none.
    #[schema(required = true)]
    pub current: Option<PlanDraft>,
    /// Drafts that lost a race or were overwritten by another author, newest first, at most one per author.
    pub others: Vec<PlanDraft>,
}

/// A new version of the draft.
#[derive(Debug, Clone, PartialEq, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct NewPlanDraft {
    /// Revision on which it is based; 0 when there was none.
    pub base: u64,
    /// Browser or program that wrote it: an identifier of its choice, up to 64 letters, digits, `-` and `_`.
    pub author: String,
    /// The plan.
    #[schema(value_type = Object)]
    pub plan: DraftText,
}

/// Draft to delete.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize, utoipa::IntoParams)]
#[into_params(parameter_in = Query)]
pub struct DraftBase {
    /// Revision of the draft.
    pub base: u64,
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(plan: &str) -> Result<String, String> {
        let text = format!(r#"{{"base": 0, "author": "a", "plan": {plan}}}"#);
        let new: Result<NewPlanDraft, _> = serde_json::from_str(&text);
        new.map(|new| new.plan.get().to_owned()).map_err(|error| error.to_string())
    }

    #[test]
    fn a_draft_is_an_object_and_not_deep() {
        for plan in ["{}", r#"{"items": [1, 2.50, "]]{\"["]}"#] {
            assert_eq!(read(plan).as_deref(), Ok(plan), "as it was written");
        }
        for plan in ["[]", "null", "7", r#""{}""#] {
            assert!(read(plan).expect_err(plan).contains("is an object"));
        }
        let nested = |levels: usize| format!(r#"{{"x": {}1{}}}"#, "[".repeat(levels), "]".repeat(levels));
        assert!(read(&nested(MAX_DEPTH - 1)).is_ok());
        assert!(read(&nested(MAX_DEPTH)).expect_err("deep").contains("64 levels"));
        assert!(read(&nested(300_000)).is_err());
    }
}
