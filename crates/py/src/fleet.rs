//! Aircraft of a fleet and their ground stations, for Python.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use pyo3::prelude::*;
use vencejo_fleet::authority::Role;
use vencejo_fleet::carrier::{
    Aircraft, AircraftConfig, AircraftStatus, Contents, Endpoint, Ground, GroundConfig, HistoryConfig, Membership,
    Organisation, Standing, is_router_of, join, standing, try_address, unix_now,
};
use vencejo_fleet::key::Name;
use vencejo_fleet::papers::certificate::{Facts, Identity, STATION_PREFIX, WARN_BEFORE_S};
use vencejo_fleet::papers::roll::{Entry, Newcomer, Out, station_called};
use vencejo_fleet::papers::ticket::Ticket;
use vencejo_fleet::signature::PublicKey;
use vencejo_fleet::{FleetError, operator};
use vencejo_station::Silence;
use vencejo_vehicle::VehicleId;

use crate::station::PyStation;
use crate::{errors, runtime};

/// Adds this module's classes.
pub fn register(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add("FLEET_WARN_BEFORE_S", WARN_BEFORE_S)?;
    module.add_class::<PyAircraft>()?;
    module.add_class::<PyGround>()?;
    module.add_class::<PyOrganisation>()?;
    module.add_function(wrap_pyfunction!(history_contents, module)?)?;
    module.add_function(wrap_pyfunction!(fleet_token, module)?)?;
    module.add_function(wrap_pyfunction!(fleet_join, module)?)?;
    module.add_function(wrap_pyfunction!(fleet_member, module)?)?;
    module.add_function(wrap_pyfunction!(fleet_standing, module)?)?;
    module.add_function(wrap_pyfunction!(fleet_try, module)?)?;
    module.add_function(wrap_pyfunction!(fleet_router_answers, module)?)
}

pub fn raise(error: FleetError) -> PyErr {
    let class = match error {
        FleetError::Network { .. } | FleetError::RosUnreached { .. } => "LinkError",
        FleetError::Refused(_) => "NotPossibleNow",
        FleetError::File { .. } | FleetError::NoRandom(_) => "VencejoError",
        _ => "InvalidRequest",
    };
    errors::raise(class, error)
}

fn history_config(station: &PyStation, folder: PathBuf, quota_bytes: u64, with_frames: bool) -> HistoryConfig {
    HistoryConfig { folder, quota_bytes, space: station.station().space().clone(), with_frames }
}

fn endpoints(texts: &[String]) -> Result<Vec<Endpoint>, FleetError> {
    texts.iter().map(|text| text.parse()).collect()
}

/// Whether it is connected to a router, the problem if not, the holder of control, states sent per second, expiry of
/// the certificate, the silence of the autopilot.
type Status = (bool, Option<String>, Option<String>, f64, Option<u64>, Option<Silent>);

/// For how long an autopilot has been silent, s, and its links in words.
type Silent = (f64, String);

fn silent(silence: Option<Silence>) -> Option<Silent> {
    silence.map(|silence| (silence.lasts.as_secs_f64(), silence.links))
}

/// An aircraft of a fleet, on board.
#[pyclass(frozen, name = "FleetAircraft", module = "vencejo._native")]
pub struct PyAircraft(Aircraft);

#[pymethods]
impl PyAircraft {
    #[new]
    #[pyo3(signature = (station, *, org, name, dial, trust, uplink_bit_s, member_file, history))]
    #[expect(clippy::too_many_arguments, reason = "all by name, in Python")]
    fn new(
        py: Python<'_>,
        station: &PyStation,
        org: Option<&str>,
        name: Option<&str>,
        dial: Vec<String>,
        trust: Vec<(String, bool)>,
        uplink_bit_s: Option<f64>,
        member_file: PathBuf,
        history: Option<(PathBuf, u64, bool)>,
    ) -> PyResult<Self> {
        let history = history.map(|(folder, quota, frames)| history_config(station, folder, quota, frames));
        let trusted = |(key, is_chief): (String, bool)| {
            let role = if is_chief { Role::Chief } else { Role::Operator };
            Ok((key.parse::<PublicKey>()?, role))
        };
        let config = || -> Result<Option<AircraftConfig>, FleetError> {
            let trust = trust.into_iter().map(trusted).collect::<Result<BTreeMap<_, _>, FleetError>>()?;
            let member = Membership::read(&member_file)?;
            let (org, name) = match (org, name, &member) {
                (Some(org), Some(name), _) => (org.parse()?, name.parse()?),
                (None, None, Some(member)) => (member.org()?, member.name()?),
                _ => return Ok(None),
            };
            // Of another fleet, it is nothing here.
            let member =
                member.filter(|member| member.org().as_ref() == Ok(&org) && member.name().as_ref() == Ok(&name));
            let mut dial = endpoints(&dial)?;
            if dial.is_empty() && member.is_none() {
                dial.push("tcp/127.0.0.1:7447".parse()?);
            }
            let member = member.map(|member| (member, member_file));
            Ok(Some(AircraftConfig { org, name, dial, member, trust, uplink_bit_s, history }))
        };
        let config = py.detach(config).map_err(raise)?.ok_or_else(|| {
            errors::raise(
                "InvalidRequest",
                "say which fleet (org) and which name in it; or join one first, with a token",
            )
        })?;
        Aircraft::start(station.station(), config, runtime::handle()).map(Self).map_err(raise)
    }

    fn status(&self) -> Status {
        let AircraftStatus { is_connected, problem, holder, rate_hz, certificate_ends, silence } = self.0.status();
        (is_connected, problem, holder, rate_hz, certificate_ends, silent(silence))
    }

    fn close(&self, py: Python<'_>) -> PyResult<()> {
        runtime::wait(py, None, self.0.close()).map(drop)
    }
}

/// Name, system id here, whether it is connected, age of its newest message, holder of control, who asks for it, and the
/// silence of its autopilot.
type Far = (String, Option<u16>, bool, f64, Option<String>, Option<String>, Option<Silent>);

/// A ground station of a fleet.
#[pyclass(frozen, name = "FleetGround", module = "vencejo._native")]
pub struct PyGround(Ground);

/// The files of a ground station's fleet in this folder.
fn standing_in(folder: &Path, org: &Name) -> Standing {
    let organisation = Organisation::below(folder, org.clone());
    let place = folder.join(format!("{org}.json"));
    if organisation.exists() {
        Standing::Authority(organisation)
    } else if place.is_file() {
        Standing::Member(place)
    } else {
        Standing::Alone
    }
}

#[pymethods]
impl PyGround {
    #[new]
    #[pyo3(signature = (station, *, org, listen, dial, door, key_file, overrules, folder, history))]
    #[expect(clippy::too_many_arguments, reason = "all by name, in Python")]
    fn new(
        py: Python<'_>,
        station: &PyStation,
        org: &str,
        listen: Option<&str>,
        dial: Vec<String>,
        door: Option<String>,
        key_file: PathBuf,
        overrules: bool,
        folder: PathBuf,
        history: Option<(PathBuf, u64)>,
    ) -> PyResult<Self> {
        let history = history.map(|(folder, quota)| history_config(station, folder, quota, false));
        let config = || -> Result<GroundConfig, FleetError> {
            let org: Name = org.parse()?;
            Ok(GroundConfig {
                listen: listen.map(str::parse).transpose()?,
                dial: endpoints(&dial)?,
                signer: operator::key_of_file(&key_file)?,
                overrules,
                standing: standing_in(&folder, &org),
                door,
                org,
                history,
            })
        };
        let config = py.detach(config).map_err(raise)?;
        let started = runtime::wait(py, None, Ground::start(station.station(), config, runtime::handle()))?;
        let ground = started.ok_or_else(|| errors::raise("ClosedError", "the fleet was not joined"))?;
        ground.map(Self).map_err(raise)
    }

    /// Where the network is joined.
    #[getter]
    fn endpoint(&self) -> String {
        self.0.endpoint().to_string()
    }

    /// Where aircraft are enrolled.
    #[getter]
    fn door(&self) -> Option<&str> {
        self.0.door()
    }

    /// Its public key.
    #[getter]
    fn key(&self) -> String {
        self.0.key().to_string()
    }

    fn aircraft(&self) -> Vec<Far> {
        let far = |far: vencejo_fleet::carrier::Far| {
            let (id, age_s) = (far.id.map(VehicleId::number), far.age.as_secs_f64());
            (far.name, id, far.is_present, age_s, far.holder, far.asking, silent(far.silence))
        };
        self.0.aircraft().into_iter().map(far).collect()
    }

    /// Whether a router answers, and why not.
    fn status(&self) -> (bool, Option<String>) {
        let status = self.0.status();
        (status.is_connected, status.problem)
    }

    fn close(&self, py: Python<'_>) -> PyResult<()> {
        runtime::wait(py, None, self.0.close()).map(drop)
    }
}

/// A stream of a boot: the boot, the stream's name, the numbers that are there.
type StreamOf = (u64, &'static str, Vec<(u64, u64)>);

/// The aircraft, its streams, UTC of the first record in ns since 1970, duration in s, bytes that could not be read.
type Found = (Option<String>, Vec<StreamOf>, Option<u64>, f64, u64);

/// The contents of a history file.
#[pyfunction]
fn history_contents(py: Python<'_>, path: PathBuf) -> PyResult<Found> {
    let read = py.detach(|| Contents::read(&path));
    let contents = read.map_err(|error| errors::raise("FileFormatError", format!("{}: {error}", path.display())))?;
    let start_unix_ns = contents.start_unix_ns();
    let stream = |(boot, stream, ranges): (u64, vencejo_fleet::history::Stream, vencejo_fleet::history::Ranges)| {
        (boot, stream.as_str(), ranges.iter().collect())
    };
    let streams = contents.streams.into_iter().map(stream).collect();
    let duration_s = contents.duration.as_secs_f64();
    Ok((contents.aircraft, streams, start_unix_ns, duration_s, contents.skipped_bytes))
}

/// From when to when a certificate is good, and for which names.
type Validity = (u64, u64, Vec<String>);

fn validity(facts: Facts) -> Validity {
    (facts.begins, facts.ends, facts.names)
}

/// Name, since when, end of its certificate, when it was revoked; where it is a ground station, its role and where it
/// is a router.
type Enrolled = (String, u64, u64, Option<u64>, Option<(&'static str, Vec<String>)>);

/// An aircraft, or with a role a ground station, which may be a router at some addresses.
fn newcomer(name: &str, role: Option<&str>, routers: Vec<String>) -> Result<Newcomer, FleetError> {
    let newcomer = match role {
        Some(role) => Newcomer::Station(name.parse()?, role_named(role)?, routers),
        None => Newcomer::Aircraft(name.parse()?),
    };
    Organisation::check(&newcomer)?;
    Ok(newcomer)
}

fn role_named(role: &str) -> Result<Role, FleetError> {
    let bad = || FleetError::Role(vencejo_proto::plain(role, 40));
    Role::named(role).ok_or_else(bad)
}

/// A fleet's authority and its roll, in a folder.
#[pyclass(frozen, name = "FleetOrganisation", module = "vencejo._native")]
pub struct PyOrganisation(Organisation);

impl PyOrganisation {
    fn detached<T: Send>(
        &self,
        py: Python<'_>,
        run: impl FnOnce(&Organisation) -> Result<T, FleetError> + Send,
    ) -> PyResult<T> {
        py.detach(|| run(&self.0)).map_err(raise)
    }
}

#[pymethods]
impl PyOrganisation {
    #[new]
    fn new(folder: PathBuf, org: &str) -> PyResult<Self> {
        let org: Name = org.parse().map_err(|error| raise(FleetError::Name(error)))?;
        Ok(Self(Organisation::below(&folder, org)))
    }

    fn exists(&self) -> bool {
        self.0.exists()
    }

    /// Whether the authority was made now; hosts that are new.
    fn init(
        &self,
        py: Python<'_>,
        hosts: Vec<String>,
        given: Option<(String, String)>,
    ) -> PyResult<(bool, Vec<String>)> {
        let made = self.detached(py, |org| org.init(&hosts, given, unix_now()))?;
        Ok((made.authority, made.hosts))
    }

    /// Whether that can be the name of an aircraft, or of a ground station with a role, and where it is a router.
    #[staticmethod]
    fn check_newcomer(name: &str, role: Option<&str>, routers: Vec<String>) -> PyResult<()> {
        newcomer(name, role, routers).map(drop).map_err(raise)
    }

    /// The token; where it is good; when it ends.
    fn enrol(
        &self,
        py: Python<'_>,
        name: &str,
        lasts_s: u64,
        role: Option<&str>,
        routers: Vec<String>,
    ) -> PyResult<(String, Vec<String>, u64)> {
        let now = unix_now();
        let ticket = self.detached(py, |org| org.enrol(&newcomer(name, role, routers)?, lasts_s, now))?;
        Ok((ticket.text(), ticket.doors, now + lasts_s))
    }

    fn revoke(&self, py: Python<'_>, name: &str, is_station: bool) -> PyResult<()> {
        self.detached(py, |org| {
            let name: Name = name.parse()?;
            let common_name = if is_station { station_called(&name) } else { name.to_string() };
            org.change(|roll| roll.revoke(&common_name, unix_now()))
        })
    }

    /// The settings of a router, as JSON.
    fn router_config(&self, py: Python<'_>) -> PyResult<String> {
        self.detached(py, |org| Ok(format!("{:#}", org.router_config()?)))
    }

    /// The authority's certificate, and the ground station's.
    fn certificates(&self, py: Python<'_>) -> PyResult<(Validity, Validity)> {
        let (ca, station) = self.detached(py, Organisation::facts)?;
        Ok((validity(ca), validity(station)))
    }

    /// Routers, doors.
    fn addresses(&self, py: Python<'_>) -> PyResult<(Vec<String>, Vec<String>)> {
        let roll = self.detached(py, Organisation::roll)?;
        Ok((roll.routers, roll.doors))
    }

    /// The members.
    fn members(&self, py: Python<'_>) -> PyResult<Vec<Enrolled>> {
        let roll = self.detached(py, Organisation::roll)?;
        let shown = |(name, entry): (String, Entry)| {
            let post = entry.post.map(|post| (post.role.as_str(), post.routers));
            (name.trim_start_matches(STATION_PREFIX).to_owned(), entry.enrolled, entry.ends, entry.revoked, post)
        };
        Ok(roll.members.into_iter().map(shown).collect())
    }

    /// Tokens that are out: for whom, until when, the role where it is a ground station.
    fn tokens(&self, py: Python<'_>) -> PyResult<Vec<(String, u64, Option<&'static str>)>> {
        let roll = self.detached(py, Organisation::roll)?;
        let name = |out: &Out| out.name.trim_start_matches(STATION_PREFIX).to_owned();
        Ok(roll.open_tokens(unix_now()).map(|out| (name(out), out.ends, out.role.map(Role::as_str))).collect())
    }

    /// The problem of connecting to an address as the ground station; `None` without one.
    fn try_address(&self, py: Python<'_>, address: &str) -> PyResult<Option<String>> {
        let identity = self.detached(py, |org| org.identity(unix_now()))?;
        tried(py, address, &identity)
    }
}

fn tried(py: Python<'_>, address: &str, identity: &Identity) -> PyResult<Option<String>> {
    let address: Endpoint = address.parse().map_err(raise)?;
    Ok(runtime::wait(py, None, try_address(&address, identity))?.and_then(Result::err))
}

/// A place in a fleet.
#[derive(IntoPyObject)]
struct Member {
    org: String,
    name: String,
    is_station: bool,
    role: Option<&'static str>,
    is_router: bool,
    begins: u64,
    ends: u64,
    routers: Vec<String>,
    doors: Vec<String>,
}

fn shown(member: &Membership) -> Result<Member, FleetError> {
    let Facts { begins, ends, .. } = member.facts()?;
    Ok(Member {
        org: member.org()?.to_string(),
        name: member.name()?.to_string(),
        is_station: member.is_station(),
        role: member.role()?.map(Role::as_str),
        is_router: !member.serves()?.is_empty(),
        begins,
        ends,
        routers: member.routers()?.iter().map(Endpoint::to_string).collect(),
        doors: member.doors()?,
    })
}

/// The organisation of a token, and whether it is for a ground station.
#[pyfunction]
fn fleet_token(token: &str) -> PyResult<(String, bool)> {
    let ticket: Ticket = token.parse().map_err(raise)?;
    Ok((ticket.org, ticket.is_station))
}

/// Joins a fleet, a ground station with its key; what is in the file then, and whether it was done now.
#[pyfunction]
fn fleet_join(py: Python<'_>, token: &str, file: PathBuf, key_file: Option<PathBuf>) -> PyResult<(Member, bool)> {
    let operator = py.detach(|| key_file.map(|file| operator::key_of_file(&file)).transpose()).map_err(raise)?;
    let joined = join(token, &file, operator.map(|signer| signer.public()));
    let joined = runtime::wait(py, None, joined)?.ok_or_else(|| errors::raise("ClosedError", "interrupted"))?;
    let (member, is_new) = joined.map_err(raise)?;
    Ok((shown(&member).map_err(raise)?, is_new))
}

/// The membership in a file; `None` without a file.
#[pyfunction]
fn fleet_member(py: Python<'_>, file: PathBuf) -> PyResult<Option<Member>> {
    py.detach(|| Membership::read(&file)?.as_ref().map(shown).transpose()).map_err(raise)
}

/// Why the aircraft of this file would not get its next certificate; `None` where it would.
#[pyfunction]
fn fleet_standing(py: Python<'_>, file: PathBuf) -> PyResult<Option<String>> {
    let member = py.detach(|| Membership::read(&file)).map_err(raise)?;
    let Some(member) = member else { return Ok(None) };
    Ok(runtime::wait(py, None, standing(&member))?.and_then(Result::err))
}

/// The problem of connecting to an address as the aircraft of this file; `None` without one.
#[pyfunction]
fn fleet_try(py: Python<'_>, address: &str, file: PathBuf) -> PyResult<Option<String>> {
    let member = py.detach(|| Membership::read(&file)).map_err(raise)?;
    member.map_or(Ok(None), |member| tried(py, address, &member.identity()))
}

/// Whether a router of this fleet answers at an address without encryption.
#[pyfunction]
fn fleet_router_answers(py: Python<'_>, address: &str, org: &str) -> PyResult<bool> {
    let address: Endpoint = address.parse().map_err(raise)?;
    let org: Name = org.parse().map_err(|error| raise(FleetError::Name(error)))?;
    Ok(runtime::wait(py, None, is_router_of(&org, &address))?.unwrap_or(false))
}
