//! The beginning of TLS with somebody at an address: whether they are there, and what keeps us apart.

use std::io;
use std::sync::Arc;
use std::time::{Duration, Instant};

use rustls::ClientConfig;
use rustls::pki_types::ServerName;
use tokio::io::AsyncReadExt;
use tokio::net::TcpStream;
use tokio_rustls::TlsConnector;
use tokio_rustls::client::TlsStream;

use super::endpoint::host_of;
use super::tls::Fault;

/// How long somebody is waited for, each time.
pub(super) const PATIENCE: Duration = Duration::from_secs(5);
/// How long a router is listened to at least for its refusal of our certificate, which comes a round trip after the handshake.
pub(super) const REFUSAL: Duration = Duration::from_millis(100);

async fn in_time<T>(what: impl Future<Output = io::Result<T>>) -> io::Result<T> {
    tokio::time::timeout(PATIENCE, what).await.unwrap_or_else(|_| Err(io::ErrorKind::TimedOut.into()))
}

/// A connection with who is at `HOST:PORT`, without TLS yet; or why there is none.
pub(super) async fn reach(address: &str) -> Result<TcpStream, Fault> {
    let addresses = in_time(tokio::net::lookup_host(address)).await;
    let addresses: Vec<_> = addresses.map_err(|_| Fault::NoAddress)?.collect();
    in_time(TcpStream::connect(&*addresses)).await.map_err(|error| Fault::from(&error))
}

/// A handshake with who is at `HOST:PORT`; where that fails, whether anybody was there, and why.
pub(super) async fn begin(address: &str, config: Arc<ClientConfig>) -> Result<TlsStream<TcpStream>, (bool, Fault)> {
    let other = |problem: String| (false, Fault::Other(problem));
    let host = host_of(address).unwrap_or(address).to_owned();
    let name = ServerName::try_from(host).map_err(|error| other(error.to_string()))?;
    let stream = reach(address).await.map_err(|fault| (false, fault))?;
    let handshake = in_time(TlsConnector::from(config).connect(name, stream)).await;
    handshake.map_err(|error| (true, Fault::from(&error)))
}

/// Why whoever is at `HOST:PORT` refuses us, which is waited for so long and what the handshake took, or we them.
pub(super) async fn refusal(address: &str, config: Arc<ClientConfig>, wait: Duration) -> Result<(), Fault> {
    let began = Instant::now();
    let mut stream = begin(address, config).await.map_err(|(_, fault)| fault)?;
    // A router says nothing first: what comes is a refusal. To connect took two round trips at least.
    match tokio::time::timeout(wait + began.elapsed(), stream.read_u8()).await {
        Ok(Err(error)) => Err(Fault::from(&error)),
        Ok(Ok(_)) | Err(_) => Ok(()),
    }
}
