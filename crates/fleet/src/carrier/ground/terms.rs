//! How a ground station joins the network: its addresses, certificate, access control, and list of ground stations.

use std::collections::BTreeSet;
use std::path::PathBuf;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

use serde_json::Value;
use tokio::sync::Notify;
use zenoh::Session;

use super::super::door::{self, Door, blocking};
use super::super::endpoint::Endpoint;
use super::super::membership::{self, Membership};
use super::super::network::{self, Part};
use super::super::organisation::Organisation;
use super::super::unix_now;
use crate::error::FleetError;
use crate::papers::certificate::Identity;
use crate::signature::Signer;

/// How often a due certificate is requested.
const RENEW_EVERY: Duration = Duration::from_secs(3600);

/// The standing of a ground station in its fleet.
#[derive(Debug, Clone, Default)]
pub enum Standing {
    /// None: unencrypted.
    #[default]
    Alone,
    /// It has the authority.
    Authority(Organisation),
    /// A member, with its membership in a file, enrolled by the station that has the authority.
    Member(PathBuf),
}

/// How the network is joined.
pub(super) struct Network {
    /// Its configured address as a router.
    pub listen: Option<Endpoint>,
    /// The configured routers to dial; empty for those of the list.
    pub dial: Vec<Endpoint>,
    pub standing: Standing,
    /// When a certificate was requested last.
    asked: Mutex<Option<Instant>>,
}

/// Certificate and access control: when they change, the network is joined anew.
#[derive(Debug, Clone, PartialEq, Default)]
pub(super) struct Terms {
    /// Its address as a router.
    pub listen: Option<Endpoint>,
    /// The routers that it dials: the first that is reachable, or as a router all of them.
    pub dial: Vec<Endpoint>,
    identity: Option<Identity>,
    access: Option<Value>,
}

/// What is found about a membership at one time.
pub(super) struct Looked {
    pub terms: Terms,
    /// The list of ground stations, if its number differs.
    pub list: Option<List>,
    /// The members whose certificates were revoked, as far as they are known: with the authority.
    pub revoked: BTreeSet<String>,
}

/// A signed list of ground stations and its number.
pub(super) type List = Arc<(u64, Vec<u8>)>;

impl Network {
    pub(super) fn new(listen: Option<Endpoint>, dial: Vec<Endpoint>, standing: Standing) -> Self {
        Self { listen, dial, standing, asked: Mutex::default() }
    }

    /// The present state of the membership, for a ground station that has the list of this number.
    pub(super) async fn look(&self, have: u64) -> Result<Looked, FleetError> {
        let revoked = BTreeSet::new();
        let (listen, dial) = (self.listen.clone(), self.dial.clone());
        match self.standing.clone() {
            Standing::Alone => Ok(Looked { terms: Terms { listen, dial, ..Terms::default() }, list: None, revoked }),
            Standing::Authority(organisation) => {
                blocking(move || {
                    let access = listen.is_some().then(|| organisation.access()).transpose()?;
                    let identity = Some(organisation.identity(unix_now())?);
                    let roll = organisation.roll()?;
                    let number = roll.number;
                    let list = if number == have { None } else { Some((number, organisation.stations()?).into()) };
                    let revoked = roll.revoked().map(str::to_owned).collect();
                    Ok(Looked { terms: Terms { listen, dial, identity, access }, list, revoked })
                })
                .await
            }
            Standing::Member(file) => {
                let (path, none) = (file.clone(), format!("{}", file.display()));
                let member = blocking(move || Membership::read(&path)).await?.ok_or_else(|| FleetError::File {
                    path: none,
                    problem: "it is gone: join the fleet again with a new token".into(),
                })?;
                let member = self.renewed(member, &file).await;
                let serves = member.serves()?;
                let listen = match (listen, serves.first()) {
                    (Some(listen), None) => {
                        let why = "this ground station was not enrolled as a router: leave that address out, or join with \
                                   a token of vencejo fleet enrol NAME --router ADDRESS";
                        return Err(FleetError::NoCertificates(listen.to_string(), why.into()));
                    }
                    (Some(listen), Some(_)) => Some(listen),
                    // On all addresses of this machine; unless another program is the router there, which is dialled.
                    (None, serves) => {
                        let is_there = |own: &Endpoint| dial.iter().any(|to| to.is_here() && to.at(own.host()) == *own);
                        serves.filter(|own| !is_there(own)).map(|own| own.at("0.0.0.0"))
                    }
                };
                let access = listen.is_some().then(|| member.access()).transpose()?;
                let others = |router: &Endpoint| !serves.contains(router);
                let dial = if dial.is_empty() { member.routers()?.into_iter().filter(others).collect() } else { dial };
                let number = member.stations()?.number;
                let list = if number == have { None } else { Some((number, member.signed_stations()?).into()) };
                let terms = Terms { listen, dial, identity: Some(member.identity()), access };
                Ok(Looked { terms, list, revoked })
            }
        }
    }

    /// Our certificate; `None` without one, and if it cannot be read.
    pub(super) async fn identity(&self) -> Option<Identity> {
        let standing = self.standing.clone();
        let read = blocking(move || match standing {
            Standing::Alone => Ok(None),
            Standing::Authority(organisation) => organisation.identity(unix_now()).map(Some),
            Standing::Member(file) => Ok(Membership::read(&file)?.map(|member| member.identity())),
        });
        read.await.ok().flatten()
    }

    /// The membership with its next certificate, if it is due and can be had.
    async fn renewed(&self, member: Membership, file: &std::path::Path) -> Membership {
        if !member.facts().is_ok_and(|facts| facts.is_due(unix_now())) {
            return member;
        }
        {
            let mut asked = self.asked.lock().unwrap_or_else(PoisonError::into_inner);
            if asked.is_some_and(|asked| asked.elapsed() < RENEW_EVERY) {
                return member;
            }
            *asked = Some(Instant::now());
        }
        match membership::renew(&member, file).await {
            Ok(renewed) => renewed,
            Err(error) => {
                tracing::warn!(%error, "the certificate was not renewed; it is tried again each hour");
                member
            }
        }
    }

    pub(super) async fn open(&self, terms: &Terms) -> Result<Session, FleetError> {
        let identity = terms.identity.as_ref();
        match &terms.listen {
            Some(listen) => network::open(Part::Router(listen, &terms.dial, terms.access.as_ref()), identity).await,
            None => network::dial(&terms.dial, identity).await,
        }
    }

    /// Opens the door, and stores its address, the router's, and our key.
    pub(super) async fn open_door(
        &self,
        organisation: &Organisation,
        address: &str,
        signer: &Signer,
        news: &Arc<Notify>,
    ) -> Result<(Door, String), FleetError> {
        let (listener, at) = door::listen(address).await?;
        let (noted, listen, dial) = (organisation.clone(), self.listen.clone(), self.dial.clone());
        let operator = signer.public().to_string();
        blocking(move || {
            let (given, is_dialled) = listen.map_or((dial, true), |listen| (vec![listen], false));
            let routers = given.iter().map(|endpoint| noted.routers(endpoint, is_dialled));
            let routers: Vec<_> = routers.collect::<Result<Vec<_>, _>>()?.concat();
            let doors = noted.doors(at)?;
            noted.change(|roll| {
                (roll.routers, roll.doors, roll.operator) = (routers, doors, Some(operator));
                Ok(())
            })
        })
        .await?;
        Ok((Door::open(listener, organisation.clone(), news.clone()), at.to_string()))
    }

    /// Stores newer lists of ground stations and aircraft in the membership: the next look finds them.
    pub(super) async fn keep(&self, stations: Vec<Vec<u8>>, aircraft: Vec<Vec<u8>>) {
        let Standing::Member(file) = self.standing.clone() else { return };
        let kept = blocking(move || {
            stations.iter().try_for_each(|list| Membership::keep_stations(&file, list))?;
            aircraft.iter().try_for_each(|list| Membership::keep_admitted(&file, list))
        });
        if let Err(error) = kept.await {
            tracing::warn!(%error, "a list that another ground station has is not taken");
        }
    }

    /// The signed list of aircraft that routers admit, if newer than this number.
    pub(super) async fn admitted(&self, have: u64) -> Option<Vec<u8>> {
        let standing = self.standing.clone();
        let found = blocking(move || match standing {
            Standing::Alone => Ok(None),
            Standing::Authority(organisation) => organisation.admitted(have),
            Standing::Member(file) => {
                let kept = Membership::read(&file)?.map(|member| member.admitted()).transpose()?.flatten();
                Ok(kept.filter(|(list, _)| list.number > have).map(|(_, signed)| signed))
            }
        });
        found.await.unwrap_or_else(|error| {
            tracing::warn!(%error, "the list of aircraft is not told");
            None
        })
    }

    /// The number of our list of aircraft.
    pub(super) async fn admitted_number(&self) -> u64 {
        let Standing::Member(file) = self.standing.clone() else { return 0 };
        let kept =
            blocking(move || Ok(Membership::read(&file)?.map(|member| member.admitted()).transpose()?.flatten()));
        kept.await.ok().flatten().map_or(0, |(list, _)| list.number)
    }
}
