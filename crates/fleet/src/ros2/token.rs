//! How ROS 2 finds each other on Zenoh (`rmw_zenoh_cpp`): keys of topics and services, liveliness tokens of nodes and
//! what they have, and what comes along with each message.

use std::fmt;

use twox_hash::XxHash3_128;

/// What stands in a key where a definition has no hash: ROS 2 Humble.
pub const NO_HASH: &str = "TypeHashNotSupported";
/// Before all tokens.
pub const TOKENS: &str = "@ros2_lv";
/// Quality of what we send: reliable, volatile, the last ten.
const OURS: &str = "::,10:,:,:,,";
/// Quality of what we hear, `SensorDataQoS`: best effort, volatile, the last five.
const HEARD: &str = "2::,5:,:,:,,";

/// What a node can have.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Kind {
    /// The node itself.
    Node,
    /// Sends a topic.
    Publisher,
    /// Hears a topic.
    Subscription,
    /// Answers a service.
    Service,
    /// Asks a service.
    Client,
}

impl Kind {
    const ALL: [(Self, &'static str); 5] = [
        (Self::Node, "NN"),
        (Self::Publisher, "MP"),
        (Self::Subscription, "MS"),
        (Self::Service, "SS"),
        (Self::Client, "SC"),
    ];

    fn code(self) -> &'static str {
        Self::ALL.iter().find(|(kind, _)| *kind == self).map_or("", |(_, code)| code)
    }
}

/// `sensor_msgs/msg/Imu` as a key has it: `sensor_msgs::msg::dds_::Imu_`.
pub fn mangled(kind: &str) -> String {
    let (package, name) = kind.rsplit_once('/').unwrap_or(("", kind));
    format!("{}::dds_::{name}_", package.replace('/', "::"))
}

/// The other way round; what has not that form stays as it is.
pub fn plain(mangled: &str) -> String {
    match mangled.strip_suffix('_').and_then(|kind| kind.split_once("::dds_::")) {
        Some((package, name)) => format!("{}/{name}", package.replace("::", "/")),
        None => mangled.to_owned(),
    }
}

/// The key under which a topic's messages go, and a service is asked.
pub fn key(domain: u32, name: &str, kind: &str, hash: &str) -> String {
    format!("{domain}/{}/{}/{hash}", name.trim_matches('/'), mangled(kind))
}

/// A node of ours.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Node {
    /// `ROS_DOMAIN_ID`.
    pub domain: u32,
    /// Of our session.
    pub zid: String,
    /// Its number in our session; what it has counts on from there.
    pub id: u32,
    /// Such as `/plane7`, or `/`.
    pub namespace: String,
    /// Such as `mavros`.
    pub name: String,
}

impl Node {
    fn start(&self, id: u32, kind: Kind) -> String {
        let Self { domain, zid, id: node, namespace, name } = self;
        let code = kind.code();
        format!("{TOKENS}/{domain}/{zid}/{node}/{id}/{code}/%/{}/{name}", namespace.replace('/', "%"))
    }

    /// Its token.
    pub fn token(&self) -> String {
        self.start(self.id, Kind::Node)
    }

    /// The token of something that it has: a topic or service with its whole name.
    pub fn token_of(&self, id: u32, kind: Kind, name: &str, of: &str, hash: &str) -> String {
        self.with_quality(id, kind, (name, of, hash), OURS)
    }

    /// The token of a topic that it hears as sensor data.
    pub fn token_of_heard(&self, id: u32, name: &str, of: &str, hash: &str) -> String {
        self.with_quality(id, Kind::Subscription, (name, of, hash), HEARD)
    }

    fn with_quality(&self, id: u32, kind: Kind, (name, of, hash): (&str, &str, &str), quality: &str) -> String {
        format!("{}/{}/{}/{hash}/{quality}", self.start(id, kind), name.replace('/', "%"), mangled(of))
    }
}

/// What tells a sender apart: the hash of its token.
pub fn gid(token: &str) -> [u8; 16] {
    XxHash3_128::oneshot(token.as_bytes()).to_le_bytes()
}

/// What comes along with a message, a request and a reply.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Attachment {
    /// Counts from 1.
    pub sequence: i64,
    /// When it was sent, UTC since 1970, ns.
    pub sent_ns: i64,
    /// Who sent it, or asked.
    pub gid: [u8; 16],
}

impl Attachment {
    /// As it goes over the wire.
    pub fn to_bytes(&self) -> Vec<u8> {
        let Self { sequence, sent_ns, gid } = self;
        [&sequence.to_le_bytes()[..], &sent_ns.to_le_bytes(), &[16], gid].concat()
    }

    /// From the wire; `None` for anything else.
    pub fn read(bytes: &[u8]) -> Option<Self> {
        let (sequence, rest) = bytes.split_first_chunk()?;
        let (sent_ns, rest) = rest.split_first_chunk()?;
        let gid = rest.strip_prefix(&[16])?.try_into().ok()?;
        Some(Self { sequence: i64::from_le_bytes(*sequence), sent_ns: i64::from_le_bytes(*sent_ns), gid })
    }
}

/// What somebody's token says.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Seen {
    /// `ROS_DOMAIN_ID`.
    pub domain: u32,
    /// Of its session.
    pub zid: String,
    /// What it is.
    pub kind: Kind,
    /// The node's whole name.
    pub node: String,
    /// What it has; `None` for the node itself.
    pub topic: Option<SeenTopic>,
}

/// A topic or a service of somebody.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct SeenTopic {
    /// Its whole name.
    pub name: String,
    /// Such as `sensor_msgs/msg/Imu`.
    pub kind: String,
    /// `RIHS01_…`, or [`NO_HASH`].
    pub hash: String,
    /// Whether nothing is to get lost; `false` for best effort.
    pub is_reliable: bool,
    /// Whether whoever comes later gets the last messages too.
    pub is_transient_local: bool,
}

impl Seen {
    /// Reads a token; `None` for one of another form. Anybody may write one: it is text to show, nothing more.
    pub fn read(token: &str) -> Option<Self> {
        let parts: Vec<&str> = token.split('/').collect();
        let [TOKENS, domain, zid, _, _, code, _, namespace, name, rest @ ..] = parts.as_slice() else { return None };
        let kind = Kind::ALL.iter().find(|(_, known)| known == code)?.0;
        let shown = |text: &str| vencejo_proto::plain(&text.replace('%', "/"), 256);
        let topic = match (kind, rest) {
            (Kind::Node, _) => None,
            (_, [name, kind, hash, qos]) => {
                let mut qos = qos.split(':');
                let (reliability, durability) = (qos.next()?, qos.next()?);
                Some(SeenTopic {
                    name: shown(name),
                    kind: plain(&shown(kind)),
                    hash: shown(hash),
                    is_reliable: reliability != "2",
                    is_transient_local: durability == "1",
                })
            }
            _ => return None,
        };
        let node = format!("{}/{}", shown(namespace).trim_end_matches('/'), shown(name));
        Some(Self { domain: domain.parse().ok()?, zid: shown(zid), kind, node, topic })
    }
}

impl fmt::Display for Kind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Node => "node",
            Self::Publisher => "publisher",
            Self::Subscription => "subscription",
            Self::Service => "service",
            Self::Client => "client",
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Strings as `rmw_zenoh_cpp`'s own design document has them.
    #[test]
    fn tokens_and_keys_have_the_form_that_others_expect() {
        let hash = "RIHS01_df668c740482bbd48fb39d76a70dfd4bd59db1288021743503259e948f6b1a18";
        assert_eq!(
            key(0, "/chatter", "std_msgs/msg/String", hash),
            format!("0/chatter/std_msgs::msg::dds_::String_/{hash}")
        );
        let node = Node {
            domain: 2,
            zid: "aac3178e146ba6f1fc6e6a4085e77f21".into(),
            id: 0,
            namespace: "/".into(),
            name: "listener".into(),
        };
        assert_eq!(node.token(), "@ros2_lv/2/aac3178e146ba6f1fc6e6a4085e77f21/0/0/NN/%/%/listener");
        let token = node.token_of(10, Kind::Subscription, "/chatter", "std_msgs/msg/String", hash);
        assert_eq!(
            token,
            format!(
                "@ros2_lv/2/aac3178e146ba6f1fc6e6a4085e77f21/0/10/MS/%/%/listener/%chatter/std_msgs::msg::dds_::String_/{hash}/\
                 ::,10:,:,:,,"
            )
        );
        let seen = Seen::read(&token).expect("a token");
        assert_eq!((seen.domain, seen.kind, seen.node.as_str()), (2, Kind::Subscription, "/listener"));
        let topic = seen.topic.expect("a topic");
        assert_eq!((topic.name.as_str(), topic.kind.as_str()), ("/chatter", "std_msgs/msg/String"));
        assert!(topic.hash == hash && topic.is_reliable && !topic.is_transient_local);
        let heard = node.token_of_heard(10, "/chatter", "std_msgs/msg/String", hash);
        assert_eq!(heard, token.replace("/::,10:", "/2::,5:"));
        let inner = Node { namespace: "/plane7".into(), name: "mavros".into(), ..node };
        assert!(inner.token().ends_with("/NN/%/%plane7/mavros"));
        assert_eq!(Seen::read(&inner.token()).map(|seen| seen.node).as_deref(), Some("/plane7/mavros"));
    }

    #[test]
    fn what_is_no_token_is_none() {
        for bad in [
            "",
            "@ros2_lv",
            "@ros2_lv/0/a/0/0/NN/%/%",
            "@ros2_lv/x/a/0/0/NN/%/%/n",
            "@ros2_lv/0/a/0/0/XX/%/%/n",
            "@ros2_lv/0/a/0/0/MP/%/%/n/%t/T/H",
            "@ros2_lv/0/a/0/0/MP/%/%/n/%t/T/H/2",
        ] {
            assert_eq!(Seen::read(bad), None, "{bad}");
        }
        let loud =
            Seen::read("@ros2_lv/0/a/0/0/MP/%/%/n\u{1b}[31m/%t/T/TypeHashNotSupported/2:1:,1:,:,:,,").expect("a token");
        assert_eq!(loud.node, "/n[31m");
        let topic = loud.topic.expect("a topic");
        assert!(!topic.is_reliable && topic.is_transient_local && topic.hash == NO_HASH);
    }

    /// Figures: xxhash 4.1 (Python's `xxhash.xxh3_128`), 128 bits with the low half first.
    #[test]
    fn a_sender_is_known_by_the_hash_of_its_token() {
        let hashes = [
            ("", 0x99aa_06d3_0147_98d8_6001_c324_468d_497f_u128),
            (
                "@ros2_lv/2/aac3178e146ba6f1fc6e6a4085e77f21/0/0/NN/%/%/listener",
                0x1259_7823_c81a_d102_8785_cbda_9979_8749,
            ),
        ];
        for (token, hash) in hashes {
            assert_eq!(gid(token), hash.to_le_bytes(), "{token}");
        }
        let attachment = Attachment { sequence: 7, sent_ns: 1_700_000_000_000_000_001, gid: gid("x") };
        let bytes = attachment.to_bytes();
        assert_eq!(bytes.len(), 33);
        assert_eq!(Attachment::read(&bytes), Some(attachment));
        assert_eq!(Attachment::read(&bytes[..32]), None);
        assert_eq!(Attachment::read(&[&bytes[..], &[0]].concat()), None);
    }
}
