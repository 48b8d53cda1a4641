//! Why somebody in ROS 2 sees nothing: looked for in the tokens of all who are there.

use std::collections::{BTreeMap, BTreeSet};

use super::token::{Kind, NO_HASH, Seen, SeenTopic};

/// Findings of one kind that are told at most: what is wrong with a name is wrong many times.
const MAX_FINDINGS: usize = 50;
/// Letters by which a name may be off and still be meant.
const NEAR: usize = 3;

/// A node that is there.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
pub struct NodeFound {
    /// `ROS_DOMAIN_ID`.
    pub domain: u32,
    /// Its whole name.
    pub name: String,
    /// How many topics it sends.
    pub publishers: usize,
    /// How many it hears.
    pub subscriptions: usize,
    /// How many services it answers.
    pub services: usize,
}

/// Something that was found.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
pub struct Finding {
    /// Whether nothing arrives because of it.
    pub is_wrong: bool,
    /// A stable name.
    pub code: &'static str,
    /// In words, with what to do.
    pub text: String,
}

fn finding(is_wrong: bool, code: &'static str, text: String) -> Finding {
    Finding { is_wrong, code, text }
}

/// The nodes of all domains, and what is wrong with those of ours.
pub fn examine(seen: &BTreeSet<Seen>, domain: u32) -> (Vec<NodeFound>, Vec<Finding>) {
    let nodes = nodes(seen);
    let mut found = Vec::new();
    if nodes.is_empty() {
        let text = "no node of ROS 2 is there: are they started with RMW_IMPLEMENTATION=rmw_zenoh_cpp, and do they use this router?";
        return (nodes, vec![finding(true, "no-nodes", text.to_owned())]);
    }
    let mut others: BTreeMap<u32, Vec<&str>> = BTreeMap::new();
    for node in nodes.iter().filter(|node| node.domain != domain) {
        others.entry(node.domain).or_default().push(&node.name);
    }
    for (other, names) in others {
        let text = format!(
            "{} in domain {other}, not in {domain}, and {} nothing of it: set ROS_DOMAIN_ID={domain} for {}, or --ros2-domain {other} here",
            listed(&names),
            if names.len() == 1 { "sees" } else { "see" },
            if names.len() == 1 { "it" } else { "them" }
        );
        found.push(finding(true, "other-domain", text));
    }
    let ours = || seen.iter().filter(|seen| seen.domain == domain);
    let with = |kind: Kind| {
        ours().filter(move |seen| seen.kind == kind).filter_map(|seen| Some((seen.node.as_str(), seen.topic.as_ref()?)))
    };
    if !with(Kind::Publisher).any(|(_, topic)| topic.kind == "sensor_msgs/msg/NavSatFix") {
        let text = format!(
            "no plane is in domain {domain}: is `vencejo serve --ros2 --ros2-domain {domain}` running, with this router?"
        );
        found.push(finding(true, "no-plane", text));
    }
    for (hears, says) in [(Kind::Subscription, Kind::Publisher), (Kind::Client, Kind::Service)] {
        let said: Vec<_> = with(says).collect();
        for (node, topic) in with(hears) {
            found.extend(compare(node, hears, topic, says, &said));
        }
    }
    found.sort_by(|a, b| b.is_wrong.cmp(&a.is_wrong).then_with(|| (a.code, &a.text).cmp(&(b.code, &b.text))));
    found.dedup();
    found.truncate(MAX_FINDINGS);
    (nodes, found)
}

fn nodes(seen: &BTreeSet<Seen>) -> Vec<NodeFound> {
    let mut nodes: BTreeMap<(u32, &str), NodeFound> = BTreeMap::new();
    for token in seen {
        let new = || NodeFound {
            domain: token.domain,
            name: token.node.clone(),
            publishers: 0,
            subscriptions: 0,
            services: 0,
        };
        let node = nodes.entry((token.domain, &token.node)).or_insert_with(new);
        match token.kind {
            Kind::Publisher => node.publishers += 1,
            Kind::Subscription => node.subscriptions += 1,
            Kind::Service => node.services += 1,
            Kind::Node | Kind::Client => {}
        }
    }
    nodes.into_values().collect()
}

/// What keeps one who hears from all who say.
fn compare(node: &str, hears: Kind, topic: &SeenTopic, says: Kind, said: &[(&str, &SeenTopic)]) -> Vec<Finding> {
    let SeenTopic { name, kind, hash, .. } = topic;
    let same: Vec<_> = said.iter().filter(|(_, other)| other.name == *name).collect();
    let mut found = Vec::new();
    for (who, other) in &same {
        if other.kind != *kind {
            let text = format!("{node} takes {name} as {kind}, {who} has it as {}: use the same type", other.kind);
            found.push(finding(true, "type-differs", text));
        } else if other.hash != *hash {
            let humble = [(node, hash), (*who, &other.hash)].into_iter().find(|(_, hash)| *hash == NO_HASH);
            found.push(match humble {
                Some((old, _)) => finding(
                    true,
                    "humble",
                    format!("{old} is ROS 2 Humble, whose keys have no type hash ({NO_HASH}), so {name} does not get through: use Jazzy or newer"),
                ),
                None => finding(
                    true,
                    "hash-differs",
                    format!("{node} and {who} have other definitions of {kind} for {name}: {hash} and {}; use the same version", other.hash),
                ),
            });
        } else if hears == Kind::Subscription {
            if topic.is_transient_local && !other.is_transient_local {
                let text = format!(
                    "{node} wants what {who} said of {name} before it came, which is not kept: it gets what comes from now on"
                );
                found.push(finding(false, "not-kept", text));
            }
            if topic.is_reliable && !other.is_reliable {
                let text = format!(
                    "{node} wants {name} without a loss, {who} sends it best effort: it comes, but some may be missing"
                );
                found.push(finding(false, "best-effort", text));
            }
        }
    }
    if same.is_empty() {
        let last = |name: &str| name.rsplit('/').next().unwrap_or_default().to_owned();
        let near = said.iter().filter(|(_, other)| {
            distance(&other.name, name) <= NEAR || (other.kind == *kind && last(&other.name) == last(name))
        });
        let near: BTreeSet<&str> = near.map(|(_, other)| other.name.as_str()).collect();
        if !near.is_empty() {
            let near: Vec<_> = near.into_iter().take(5).collect();
            let text = format!("{node}: no {says} of {name}; is {} meant?", near.join(" or "));
            found.push(finding(true, "near-name", text));
        }
    }
    found
}

fn listed(names: &[&str]) -> String {
    let shown = names.iter().take(5).copied().collect::<Vec<_>>().join(", ");
    let more = names.len().saturating_sub(5);
    match (names.len(), more) {
        (1, _) => format!("{shown} is"),
        (_, 0) => format!("{shown} are"),
        _ => format!("{shown} and {more} more are"),
    }
}

/// Letters to change, leave out or put in (Levenshtein).
fn distance(one: &str, other: &str) -> usize {
    let other: Vec<char> = other.chars().collect();
    let mut row: Vec<usize> = (0..=other.len()).collect();
    for (index, letter) in one.chars().enumerate() {
        let mut corner = std::mem::replace(&mut row[0], index + 1);
        for (place, theirs) in other.iter().enumerate() {
            let change = corner + usize::from(letter != *theirs);
            corner = row[place + 1];
            row[place + 1] = change.min(row[place] + 1).min(corner + 1);
        }
    }
    row[other.len()]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ros2::message::{Imu, Message, NavSatFix};
    use crate::ros2::token::Node;

    const OTHER: &str = "RIHS01_0000000000000000000000000000000000000000000000000000000000000000";

    fn node(domain: u32, name: &str) -> Node {
        Node { domain, zid: "a1".into(), id: 0, namespace: "/".into(), name: name.into() }
    }

    fn codes(tokens: &[String], domain: u32) -> Vec<(&'static str, String)> {
        let seen = tokens.iter().filter_map(|token| Seen::read(token)).collect();
        examine(&seen, domain).1.into_iter().map(|finding| (finding.code, finding.text)).collect()
    }

    fn plane() -> Vec<String> {
        let plane = node(0, "mavros");
        vec![
            plane.token(),
            plane.token_of(1, Kind::Publisher, "/plane7/mavros/imu/data", Imu::TYPE, Imu::HASH),
            plane.token_of(2, Kind::Publisher, "/plane7/mavros/fix", NavSatFix::TYPE, NavSatFix::HASH),
        ]
    }

    fn heard(domain: u32, name: &str, kind: &str, hash: &str) -> Vec<String> {
        let rviz = node(domain, "rviz");
        let mut all = plane();
        all.extend([rviz.token(), rviz.token_of(1, Kind::Subscription, name, kind, hash)]);
        all
    }

    #[test]
    fn each_reason_is_told_from_the_others() {
        assert_eq!(codes(&[], 0)[0].0, "no-nodes");
        let good = "/plane7/mavros/imu/data";
        assert_eq!(codes(&heard(0, good, Imu::TYPE, Imu::HASH), 0), []);
        for (tokens, code, says) in [
            (
                heard(5, good, Imu::TYPE, Imu::HASH),
                "other-domain",
                "/rviz is in domain 5, not in 0, and sees nothing of it: set ROS_DOMAIN_ID=0 for it",
            ),
            (heard(0, good, "sensor_msgs/msg/Image", OTHER), "type-differs", "sensor_msgs/msg/Image"),
            (heard(0, good, Imu::TYPE, OTHER), "hash-differs", Imu::HASH),
            (heard(0, good, Imu::TYPE, NO_HASH), "humble", "/rviz is ROS 2 Humble"),
            (heard(0, "/plane7/mavros/imu/dat", Imu::TYPE, Imu::HASH), "near-name", good),
            (heard(0, "/mavros/imu/data", Imu::TYPE, Imu::HASH), "near-name", good),
        ] {
            let found = codes(&tokens, 0);
            assert!(found.len() == 1 && found[0].0 == code && found[0].1.contains(says), "{code}: {found:?}");
        }
        assert_eq!(codes(&heard(0, "/chatter", "std_msgs/msg/String", OTHER), 0), [], "somebody else's matter");
        let late = heard(0, good, Imu::TYPE, Imu::HASH).into_iter().map(|token| match token.contains("/MS/") {
            true => token.replace("/::,10", "/:1:,10"),
            false => token.replace("/::,10", "/2::,10"),
        });
        let found: Vec<_> = codes(&late.collect::<Vec<_>>(), 0).into_iter().map(|(code, _)| code).collect();
        assert_eq!(found, ["best-effort", "not-kept"]);
        assert_eq!(codes(&plane()[..1], 0)[0].0, "no-plane");
    }

    #[test]
    fn nodes_are_counted_and_whoever_floods_is_cut_short() {
        let mut tokens = plane();
        for number in 0..200 {
            tokens.push(node(0, "flood").token_of(
                number,
                Kind::Subscription,
                &format!("/{number}/imu/data"),
                Imu::TYPE,
                Imu::HASH,
            ));
        }
        let seen = tokens.iter().filter_map(|token| Seen::read(token)).collect();
        let (nodes, found) = examine(&seen, 0);
        let counts: Vec<_> =
            nodes.iter().map(|node| (node.name.as_str(), node.publishers, node.subscriptions)).collect();
        assert_eq!(counts, [("/flood", 0, 200), ("/mavros", 2, 0)]);
        assert_eq!(found.len(), MAX_FINDINGS);
        assert_eq!((distance("kitten", "sitting"), distance("", "abc"), distance("a", "a")), (3, 3, 0));
    }
}
