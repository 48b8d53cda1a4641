//! Names that a plane has in ROS 2.

use std::str::FromStr;

use thiserror::Error;

/// By whose names a plane's topics go.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Names {
    /// Those of MAVROS, below the plane's namespace: `/plane7/mavros/imu/data`.
    #[default]
    Mavros,
    /// Those of ArduPilot's own: `/ap/v1/imu/experimental/data`.
    ArduPilot,
}

/// Something in a name that ROS does not take, or a setting that is none.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
pub enum BadRosName {
    /// Of which names there are.
    #[error("'{0}' are no names here: use mavros or ap")]
    Names(String),
    /// A namespace.
    #[error(
        "'{0}' is not a ROS namespace: use letters, digits, '_' and '/', no digit in front; {{name}} and {{system}} stand for the plane's"
    )]
    Namespace(String),
    /// A domain.
    #[error("domain {0} cannot be: ROS_DOMAIN_ID goes from 0 to 232")]
    Domain(u32),
}

impl FromStr for Names {
    type Err = BadRosName;

    fn from_str(text: &str) -> Result<Self, BadRosName> {
        match text {
            "mavros" => Ok(Self::Mavros),
            "ap" => Ok(Self::ArduPilot),
            _ => Err(BadRosName::Names(vencejo_proto::plain(text, 40))),
        }
    }
}

/// Which namespace each plane has: a text in which `{name}` stands for the plane's name and `{system}` for the id by
/// which the station knows it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Namespace(String);

impl Default for Namespace {
    fn default() -> Self {
        Self("{name}".to_owned())
    }
}

impl FromStr for Namespace {
    type Err = BadRosName;

    fn from_str(text: &str) -> Result<Self, BadRosName> {
        let made = Self(text.trim_matches('/').to_owned());
        if is_namespace(&made.of(None, 1)) { Ok(made) } else { Err(BadRosName::Namespace(shown(text))) }
    }
}

fn shown(text: &str) -> String {
    vencejo_proto::plain(text, 80)
}

fn is_namespace(name: &str) -> bool {
    let is_part = |part: &str| {
        !part.is_empty()
            && !part.starts_with(|first: char| first.is_ascii_digit())
            && part.bytes().all(|byte| byte.is_ascii_alphanumeric() || byte == b'_')
    };
    name.len() <= 128 && name.strip_prefix('/').is_some_and(|name| name.split('/').all(is_part))
}

impl Namespace {
    /// The same with that id behind it: where two planes would have the same.
    pub fn with_system(&self) -> Self {
        Self(format!("{}_{{system}}", self.0))
    }

    /// That of a plane: by its name in a fleet or its recording, else by `vencejo_` and that id. Any name makes one that
    /// ROS takes and does not hide: its letters and digits, with one `_` for what is between them.
    pub fn of(&self, name: Option<&str>, id: u16) -> String {
        let parts = name.unwrap_or_default().split(|sign: char| !sign.is_ascii_alphanumeric());
        let name = parts.filter(|part| !part.is_empty()).collect::<Vec<_>>().join("_");
        let name = match name.bytes().next() {
            Some(first) if first.is_ascii_digit() => format!("vencejo_{name}"),
            Some(_) => name,
            None => format!("vencejo_{id}"),
        };
        format!("/{}", self.0.replace("{name}", &name).replace("{system}", &id.to_string()))
    }
}

/// Where a plane's topics, frames and nodes are.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Place {
    /// What stands before the names of topics, with the slash.
    pub prefix: String,
    /// The node's namespace.
    pub namespace: String,
    /// The node's name.
    pub node: String,
    /// What stands before the names of frames.
    pub frames: String,
    /// The plane's name for people.
    pub plane: String,
}

impl Place {
    /// That of a plane.
    pub fn new(names: Names, namespace: &Namespace, name: Option<&str>, id: u16) -> Self {
        let own = namespace.of(name, id);
        let plane = name.map_or_else(|| own.trim_start_matches('/').to_owned(), str::to_owned);
        match names {
            Names::Mavros => Self {
                prefix: format!("{own}/mavros/"),
                node: "mavros".into(),
                frames: format!("{}/", own.trim_start_matches('/')),
                namespace: own,
                plane,
            },
            Names::ArduPilot => Self {
                prefix: format!("/ap/v{id}/"),
                node: format!("v{id}"),
                frames: String::new(),
                namespace: "/ap".into(),
                plane,
            },
        }
    }

    /// A topic's whole name; one that begins with a slash is whole.
    pub fn topic(&self, name: &str) -> String {
        if name.starts_with('/') { name.to_owned() } else { format!("{}{name}", self.prefix) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_plane_has_a_namespace_of_its_own() {
        let usual = Namespace::default();
        assert_eq!(usual.of(Some("plane-7"), 254), "/plane_7");
        assert_eq!(usual.of(Some("7up"), 254), "/vencejo_7up");
        assert_eq!(usual.of(None, 3), "/vencejo_3");
        // Those of recordings are names of files.
        for (name, namespace) in [
            ("flight #3 (replay)", "/flight_3_replay"),
            ("_hidden/a?*$b", "/hidden_a_b"),
            ("2026-11-27", "/vencejo_2026_11_27"),
            ("vuelo ñ", "/vuelo"),
            ("{system}", "/system"),
            ("#", "/vencejo_3"),
            ("", "/vencejo_3"),
        ] {
            assert_eq!(usual.of(Some(name), 3), namespace);
            assert!(is_namespace(namespace), "{namespace}");
        }
        let other: Namespace = "/uas{system}".parse().expect("a namespace");
        assert_eq!(other.of(None, 3), "/uas3");
        for bad in ["", "/", "a b", "7a", "a//b", "{plane}", "a-b", "{system}", &"x".repeat(200)] {
            assert!(bad.parse::<Namespace>().is_err(), "{bad}");
        }
        let place = Place::new(Names::Mavros, &usual, Some("plane7"), 254);
        assert_eq!(place.topic("imu/data"), "/plane7/mavros/imu/data");
        assert_eq!(place.topic("/tf"), "/tf");
        assert_eq!(
            (place.namespace.as_str(), place.node.as_str(), place.frames.as_str()),
            ("/plane7", "mavros", "plane7/")
        );
        let place = Place::new(Names::ArduPilot, &usual, None, 2);
        assert_eq!(place.topic("navsat"), "/ap/v2/navsat");
        assert!("MAVROS".parse::<Names>().is_err());
    }
}
