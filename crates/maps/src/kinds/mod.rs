//! The kinds of map sources: of each how it is read, and what it says of itself (`kind::Kind`). A new kind is
//! a module here, with its line below and in `list.rs`.

pub mod dem;
pub mod folder;
pub mod geotiff;
pub mod google;
pub mod image;
pub mod mbtiles;
pub mod pmtiles;
pub mod wms;
pub mod wmts;
pub mod xyz;

use std::collections::BTreeSet;

use crate::kind::{Kind, KindInfo};
use crate::settings::{Caching, Role, SourceKind, SourceSettings};

/// Makes the way from a kind's name to what it says of itself.
macro_rules! ways {
    ($($(#[doc = $doc:literal])+ $kind:ident => $module:ident,)+) => {
        impl SourceKind {
            /// The driver of the kind.
            pub(crate) fn driver(self) -> &'static dyn Kind {
                match self {
                    $(Self::$kind => &$module::Driver,)+
                }
            }
        }
    };
}

every_kind!(ways);

/// All kinds, as forms and programs need to know them.
pub fn infos() -> Vec<KindInfo> {
    let info = |kind: &SourceKind| {
        let driver = kind.driver();
        KindInfo {
            kind: *kind,
            fields: driver.fields().to_vec(),
            roles: driver.roles().to_vec(),
            file_ends: driver.file_ends().to_vec(),
            address_signs: driver.address_signs().to_vec(),
            has_capabilities: driver.offer().is_some(),
            needs_key: driver.needs_key(),
        }
    };
    SourceKind::ALL.iter().map(info).collect()
}

/// Kinds that a file can be by its name.
pub fn kind_of(name: &str) -> Option<SourceKind> {
    let lower = name.to_ascii_lowercase();
    let is_its = |kind: &&SourceKind| kind.driver().file_ends().iter().any(|end| lower.ends_with(end));
    SourceKind::ALL.iter().find(is_its).copied()
}

/// Ends of the names of files that can be handed in.
pub fn file_ends() -> Vec<&'static str> {
    SourceKind::ALL.iter().flat_map(|kind| kind.driver().file_ends()).copied().collect()
}

/// Settings that depend on the kind.
impl SourceSettings {
    /// Settings with defaults for everything else.
    pub fn new(id: impl Into<String>, name: impl Into<String>, kind: SourceKind) -> Self {
        let role = kind.driver().roles().first().copied().unwrap_or_default();
        Self { role, ..Self::unsaid(id, name, kind) }
    }

    /// Whether the service demands a key of the user's.
    pub fn needs_key(&self) -> bool {
        self.kind.driver().needs_key()
            || [&self.url, &self.attribution_url].into_iter().flatten().any(|url| url.contains("{key}"))
            || self.parameters.values().any(|value| value.contains("{key}"))
    }

    /// The hosts that its key is for: those of the addresses that the user gave.
    pub fn key_hosts(&self) -> BTreeSet<String> {
        let url = self.url.as_deref().or(self.kind.driver().own_url());
        let given = [url, self.attribution_url.as_deref()];
        given.into_iter().flatten().flat_map(|url| crate::address::hosts(url, &self.subdomains)).collect()
    }

    /// Whether it is read from files of this machine.
    pub fn is_file(&self) -> bool {
        self.kind.driver().is_file(self)
    }

    /// Why offline areas of it are forbidden.
    pub fn offline_refusal(&self) -> Option<String> {
        if self.is_file() {
            return Some("its tiles are in a file of this machine already".to_owned());
        }
        let refused = self.kind.driver().no_offline();
        if self.offline && self.cache == Caching::Keep && refused.is_none() {
            return None;
        }
        let usual = match (refused, self.cache) {
            (Some(reason), _) => reason,
            (None, Caching::Keep) => "its settings say that its terms forbid it",
            (None, _) => "its tiles may not be kept",
        };
        Some(self.offline_reason.clone().unwrap_or_else(|| usual.to_owned()))
    }

    /// All that is wrong, each naming its field.
    pub fn faults(&self) -> Vec<String> {
        let mut faults = self.general_faults();
        let driver = self.kind.driver();
        let is_heights = driver.roles() == [Role::Elevation];
        if is_heights && self.role != Role::Elevation {
            faults.push(format!("role: kind {} is for role elevation", self.kind.name()));
        }
        if !is_heights && self.role == Role::Elevation && self.encoding.is_none() {
            faults.push("encoding: heights from tiles are written as terrarium or terrain-rgb".to_owned());
        }
        driver.faults(self, &mut faults);
        faults
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_kind_says_what_it_takes() {
        let settings = SourceSettings::unsaid("a", "A", SourceKind::Xyz);
        let of_settings = |field: &str| {
            let text = format!(r#"{{"id": "a", "name": "A", "kind": "xyz", "{field}": null}}"#);
            serde_json::from_str::<SourceSettings>(&text).is_ok_and(|read| read == settings)
        };
        assert!(!of_settings("colour"));
        for KindInfo { kind, fields, roles, file_ends, address_signs, .. } in infos() {
            assert_eq!(serde_json::to_value(kind).expect("a name"), kind.name(), "its module is named as it is itself");
            assert!(!roles.is_empty() && !fields.is_empty(), "{kind:?}");
            assert!(address_signs.is_empty() || fields.contains(&"url"), "{kind:?} has no address");
            assert!(address_signs.iter().all(|sign| sign.to_lowercase() == *sign), "{kind:?}: {address_signs:?}");
            for field in fields {
                assert!(of_settings(field), "{kind:?}: '{field}' is no field of the settings");
            }
            for end in file_ends {
                assert_eq!(kind_of(&format!("FIELD{}", end.to_uppercase())), Some(kind), "{end}: two kinds claim it");
            }
        }
        assert_eq!(kind_of("field.doc"), None);
    }
}
