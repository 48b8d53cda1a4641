//! Who is there in ROS 2: asked of a router.

use std::collections::BTreeSet;
use std::time::Duration;

use super::router::{RosRouter, check_domain, open};
use crate::carrier::network::failed;
use crate::error::FleetError;
use crate::ros2::doctor::{Finding, NodeFound};
use crate::ros2::token::{Seen, TOKENS};

/// How long tokens are waited for.
const PATIENCE: Duration = Duration::from_secs(3);
/// Tokens that are looked at, at most.
const MAX_TOKENS: usize = 100_000;

/// What was found.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Examined {
    /// The nodes of all domains.
    pub nodes: Vec<NodeFound>,
    /// What is wrong.
    pub findings: Vec<Finding>,
}

/// Looks who is at a router, and why those of a domain see nothing of each other.
///
/// # Errors
/// [`FleetError::Network`] when the router is not reached, [`FleetError::Ros`] for a domain that cannot be.
pub async fn examine(router: &RosRouter, domain: u32) -> Result<Examined, FleetError> {
    check_domain(domain)?;
    let session = open(router).await?;
    let replies = session.liveliness().get(format!("{TOKENS}/**")).timeout(PATIENCE).await.map_err(failed)?;
    // The same may come more than once.
    let mut seen = BTreeSet::new();
    while let Ok(reply) = replies.recv_async().await {
        let Ok(sample) = reply.into_result() else { continue };
        seen.extend(Seen::read(sample.key_expr().as_str()));
        if seen.len() >= MAX_TOKENS {
            break;
        }
    }
    // What it declared ends with it, whatever it says.
    let _ = session.close().await;
    let (nodes, findings) = crate::ros2::doctor::examine(&seen, domain);
    Ok(Examined { nodes, findings })
}
