//! Zenoh's access control for a router, made from the roll: who may publish and receive what.
//!
//! Everything is denied by default, and every kind of message has to be named. A subject is the common name of a
//! certificate. A router sees its neighbour, not the author: what comes over another router has that router's name. So
//! orders are signed, and this is the second line of defence.

use serde_json::{Value, json};

use crate::key::{Kind, Name, keys_of_all, keys_of_hub};

/// The members that a router admits, by the common names of their certificates.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct LetIn {
    /// Ground stations.
    pub stations: Vec<String>,
    /// Other routers.
    pub routers: Vec<String>,
    /// Aircraft.
    pub aircraft: Vec<String>,
}

/// The access control of a router: a value of its configuration, as `access_control`.
pub fn control(org: &Name, admitted: &LetIn) -> Value {
    let (all, hub, states) = (format!("vencejo/1/{org}/**"), keys_of_hub(org), keys_of_all(org, Kind::State));
    let rule = |id: &str, flow: &str, key: &str, messages: &[&str]| json!({"id": id, "permission": "allow", "flows": [flow], "messages": messages, "key_exprs": [key]});
    let tells = ["put", "delete", "reply", "declare_queryable", "liveliness_token"];
    let asks = ["query", "declare_subscriber", "liveliness_query", "declare_liveliness_subscriber"];
    // No aircraft's name begins with `_`, so none can be taken for one of these.
    let mut rules = vec![
        rule("_stations-ask", "ingress", &all, &asks),
        rule("_stations-are-told", "egress", &all, &tells),
        // A station behind a router answers the aircraft's echo requests and queries for the list of stations.
        rule("_stations-answer", "ingress", &hub, &["reply", "declare_queryable"]),
        rule("_stations-are-asked", "egress", &hub, &["query"]),
        rule("_aircraft-ask", "ingress", &hub, &["query"]),
        rule("_aircraft-are-answered", "egress", &hub, &["reply", "declare_queryable"]),
        // Aircraft may see whether anyone subscribes to all states, and throttle themselves when nobody does.
        rule("_aircraft-are-heard", "egress", &states, &["declare_subscriber"]),
    ];
    let mut subjects = vec![json!({"id": "_stations", "cert_common_names": admitted.stations})];
    let of_stations = ["_stations-ask", "_stations-are-told", "_stations-answer", "_stations-are-asked"];
    let mut policies = vec![json!({"rules": of_stations, "subjects": ["_stations"]})];
    if !admitted.routers.is_empty() {
        // Linked routers forward everything to each other: only the router with the author's link knows the author.
        let passes: Vec<_> = tells.iter().chain(&asks).copied().collect();
        for (id, flow) in [("_routers-bring", "ingress"), ("_routers-are-brought", "egress")] {
            rules.push(rule(id, flow, &all, &passes));
        }
        subjects.push(json!({"id": "_routers", "cert_common_names": admitted.routers}));
        policies.push(json!({"rules": ["_routers-bring", "_routers-are-brought"], "subjects": ["_routers"]}));
    }
    for name in &admitted.aircraft {
        let (own, tell, hear) =
            (format!("vencejo/1/{org}/{name}/**"), format!("{name}-tells"), format!("{name}-is-asked"));
        rules.push(rule(&tell, "ingress", &own, &tells));
        rules.push(rule(&hear, "egress", &own, &asks));
        subjects.push(json!({"id": name, "cert_common_names": [name]}));
        let rules = [tell.as_str(), hear.as_str(), "_aircraft-ask", "_aircraft-are-answered", "_aircraft-are-heard"];
        policies.push(json!({"rules": rules, "subjects": [name]}));
    }
    json!({"enabled": true, "default_permission": "deny", "rules": rules, "subjects": subjects, "policies": policies})
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_aircraft_has_its_own_prefix_and_the_hub_and_nothing_else() {
        let org = "acme".parse().expect("a name");
        let admitted = LetIn {
            stations: vec!["_ground".into()],
            routers: Vec::new(),
            aircraft: vec!["plane7".into(), "stations".into()],
        };
        let made = control(&org, &admitted);
        assert_eq!(made["default_permission"], "deny");
        let policy = &made["policies"][1];
        let mut keys = Vec::new();
        for rule in made["rules"].as_array().expect("rules") {
            if policy["rules"].as_array().expect("rules").contains(&rule["id"]) {
                assert_eq!(rule["permission"], "allow");
                keys.push((rule["flows"][0].as_str(), rule["key_exprs"][0].as_str()));
            }
        }
        let (own, hub) = (Some("vencejo/1/acme/plane7/**"), Some("vencejo/1/acme/_hub/*"));
        let (ingress, egress, states) = (Some("ingress"), Some("egress"), Some("vencejo/1/acme/*/state"));
        assert_eq!(keys, [(ingress, hub), (egress, hub), (egress, states), (ingress, own), (egress, own)]);
    }
}
