//! What of the server's disk does not work, and the draft of a plan that is kept on it.

use serde::de::Error;
use serde::{Deserialize, Deserializer, Serialize};
use serde_json::value::RawValue;
use utoipa::ToSchema;

/// Something that is not being kept.
#[derive(Debug, Clone, PartialEq, Serialize, ToSchema)]
pub struct StorageProblem {
    /// What.
    pub what: StorageClass,
    /// Which camera or map source; null where there is one of its kind.
    #[schema(required = true)]
    pub name: Option<String>,
    /// Why.
    pub fault: StorageFault,
    /// Since when it has been known, seconds on the station's clock.
    pub since_s: f64,
    /// The same in English.
    pub text: String,
}

/// What is kept on the server's disk.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum StorageClass {
    /// The flight recorder.
    Telemetry,
    /// Map tiles, offline areas, the list of sources.
    Maps,
    /// What is known of the missions on board.
    Missions,
    /// Recordings of cameras.
    Video,
    /// The draft of the plan.
    Draft,
    /// The tokens by which browsers get in.
    Tokens,
    /// The signing keys.
    Signing,
    /// Until when the signing keys were used.
    SigningTimes,
}

/// Why something is not being kept.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, ToSchema)]
#[serde(tag = "kind", rename_all = "snake_case")]
pub enum StorageFault {
    /// The disk is too full.
    LowSpace {
        /// Free megabytes.
        free_mb: u64,
        /// Megabytes that stay free.
        floor_mb: u64,
    },
    /// The disk cannot be written: what the system says, in English.
    Unwritable {
        /// What it says.
        reason: String,
    },
    /// A file cannot be read, and is left as it is: why, in English.
    Unreadable {
        /// Why.
        reason: String,
    },
    /// The disk does not answer.
    Stalled,
    /// A damaged file was given another name, and a new one begun.
    SetAside {
        /// What it is called now.
        name: String,
    },
    /// It ended by itself: why, in English.
    Ended {
        /// Why.
        reason: String,
    },
}

impl StorageProblem {
    /// Whether it is the same as another one, of which other figures were told.
    pub fn is_same(&self, other: &Self) -> bool {
        (self.what, &self.name) == (other.what, &other.name)
            && std::mem::discriminant(&self.fault) == std::mem::discriminant(&other.fault)
    }
}

/// Levels of lists and objects in a draft at most.
const MAX_DEPTH: usize = 64;

/// A plan as its author wrote it. It is kept as text, which takes no more memory than it has bytes: whoever reads it checks it.
#[derive(Debug, Clone, Serialize)]
#[serde(transparent)]
pub struct DraftText(Box<RawValue>);

impl DraftText {
    /// A plan of nothing.
    pub fn empty() -> Self {
        Self(RawValue::from_string("{}".to_owned()).expect("invariant: an object"))
    }

    /// JSON: an object.
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

/// Levels of lists and objects in JSON.
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

/// The draft of a plan, as the server keeps it for all operators.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct PlanDraft {
    /// Counts the changes.
    pub revision: u64,
    /// Which browser or program it comes from.
    pub author: String,
    /// Name of the session that it comes from.
    pub by: String,
    /// When it was saved, seconds since 1970 on the server's clock.
    pub saved_unix_s: f64,
    /// The draft, as its author wrote it: whoever reads it checks it.
    #[schema(value_type = Object)]
    pub plan: DraftText,
}

/// The draft, and those that it did not take the place of with their author's knowledge.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct PlanDrafts {
    /// The draft; null when there is none.
    #[schema(required = true)]
    pub current: Option<PlanDraft>,
    /// Drafts that lost a race or were overwritten by somebody else, the newest first, one for each author.
    pub others: Vec<PlanDraft>,
}

/// A change of the draft.
#[derive(Debug, Clone, PartialEq, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct NewPlanDraft {
    /// The revision that it is a change of; 0 when there was none.
    pub base: u64,
    /// Which browser or program it comes from: up to 64 letters, digits, `-` and `_` of its own choice.
    pub author: String,
    /// The draft.
    #[schema(value_type = Object)]
    pub plan: DraftText,
}

/// Which draft is to go.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize, utoipa::IntoParams)]
#[into_params(parameter_in = Query)]
pub struct DraftBase {
    /// Its revision.
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
