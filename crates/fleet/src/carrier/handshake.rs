//! TLS handshakes with a peer at an address, over TCP or in QUIC: whether it is there, and why the handshake fails.

use std::io;
use std::net::{Ipv4Addr, Ipv6Addr, SocketAddr};
use std::sync::Arc;
use std::time::{Duration, Instant};

use rustls::ClientConfig;
use rustls::pki_types::ServerName;
use tokio::io::AsyncReadExt;
use tokio::net::TcpStream;
use tokio_rustls::TlsConnector;
use tokio_rustls::client::TlsStream;

use super::endpoint::{Transport, host_of};
use super::tls::{Fault, Side};

/// The ALPN protocols of a Zenoh router over QUIC: since 1.9, and before.
const ZENOH: [&[u8]; 2] = [b"zenoh", b"hq-29"];

/// The first of the 256 error codes of QUIC for TLS alerts: RFC 9001, 4.8.
const CRYPTO_ERRORS: u64 = 0x100;
/// The timeout of each step.
pub(super) const PATIENCE: Duration = Duration::from_secs(5);
/// The least wait for a router's refusal of our certificate, which comes a round trip after the handshake.
pub(super) const REFUSAL: Duration = Duration::from_millis(100);

async fn in_time<T>(what: impl Future<Output = io::Result<T>>) -> io::Result<T> {
    tokio::time::timeout(PATIENCE, what).await.unwrap_or_else(|_| Err(io::ErrorKind::TimedOut.into()))
}

/// Connects to `HOST:PORT`, without TLS yet.
pub(super) async fn reach(address: &str) -> Result<TcpStream, Fault> {
    in_time(TcpStream::connect(&*resolved(address).await?)).await.map_err(|error| Fault::from(&error))
}

async fn resolved(address: &str) -> Result<Vec<SocketAddr>, Fault> {
    let addresses = in_time(tokio::net::lookup_host(address)).await;
    Ok(addresses.map_err(|_| Fault::NoAddress)?.collect())
}

/// Performs a handshake with `HOST:PORT`. An error has whether a peer was there, and why it failed.
pub(super) async fn begin(address: &str, config: Arc<ClientConfig>) -> Result<TlsStream<TcpStream>, (bool, Fault)> {
    let other = |problem: String| (false, Fault::Other(problem));
    let host = host_of(address).unwrap_or(address).to_owned();
    let name = ServerName::try_from(host).map_err(|error| other(error.to_string()))?;
    let stream = reach(address).await.map_err(|fault| (false, fault))?;
    let handshake = in_time(TlsConnector::from(config).connect(name, stream)).await;
    handshake.map_err(|error| (true, Fault::from(&error)))
}

/// Performs a handshake with `HOST:PORT` and waits for a refusal: for `wait` and as long as the handshake took. An
/// error if one side refuses the other.
pub(super) async fn refusal(
    transport: Transport,
    address: &str,
    config: Arc<ClientConfig>,
    wait: Duration,
) -> Result<(), Fault> {
    let began = Instant::now();
    if transport == Transport::Quic {
        let connection = begin_quic(address, &config).await?;
        let closed = tokio::time::timeout(wait + began.elapsed(), connection.closed()).await;
        connection.close(0_u8.into(), &[]);
        return closed.map_or(Ok(()), |error| Err(of_quic(&error)));
    }
    let mut stream = begin(address, config).await.map_err(|(_, fault)| fault)?;
    // A router does not speak first: what comes is a refusal. Connecting took at least two round trips.
    match tokio::time::timeout(wait + began.elapsed(), stream.read_u8()).await {
        Ok(Err(error)) => Err(Fault::from(&error)),
        Ok(Ok(_)) | Err(_) => Ok(()),
    }
}

/// Performs a handshake with a router at `HOST:PORT` over QUIC.
async fn begin_quic(address: &str, config: &ClientConfig) -> Result<quinn::Connection, Fault> {
    let other = |problem: &dyn std::error::Error| Fault::Other(problem.to_string());
    let all = resolved(address).await?;
    // Like Zenoh, which takes the certificate's name from the address that it dials, so it cannot try the addresses one
    // by one.
    let at = *all.first().ok_or(Fault::NoAddress)?;
    let mut config = config.clone();
    config.alpn_protocols = ZENOH.map(Vec::from).into();
    let config = quinn::crypto::rustls::QuicClientConfig::try_from(config).map_err(|error| other(&error))?;
    let any = if at.is_ipv4() { Ipv4Addr::UNSPECIFIED.into() } else { Ipv6Addr::UNSPECIFIED.into() };
    let endpoint = quinn::Endpoint::client(SocketAddr::new(any, 0)).map_err(|error| Fault::from(&error))?;
    let host = host_of(address).unwrap_or(address);
    let dialled = endpoint.connect_with(quinn::ClientConfig::new(Arc::new(config)), at, host);
    let dialled = dialled.map_err(|error| other(&error))?;
    let answered = tokio::time::timeout(PATIENCE, dialled).await.unwrap_or(Err(quinn::ConnectionError::TimedOut));
    answered.map_err(|error| match of_quic(&error) {
        Fault::SilentUdp if all.iter().any(|other| other.ip() != at.ip()) => Fault::SilentUdpAt(at),
        fault => fault,
    })
}

/// Why a connection ended: QUIC carries TLS alerts as error codes of its own.
fn of_quic(error: &quinn::ConnectionError) -> Fault {
    let alert = |code: quinn::TransportErrorCode| {
        let number = u64::from(code).checked_sub(CRYPTO_ERRORS)?;
        u8::try_from(number).ok().map(rustls::AlertDescription::from)
    };
    let told = match error {
        quinn::ConnectionError::TimedOut => return Fault::SilentUdp,
        quinn::ConnectionError::TransportError(ours) => alert(ours.code).map(|alert| (alert, Side::Ours(&ours.reason))),
        quinn::ConnectionError::ConnectionClosed(theirs) => match theirs.error_code {
            quinn::TransportErrorCode::APPLICATION_ERROR => return Fault::HangsUp,
            code => alert(code).map(|alert| (alert, Side::Theirs)),
        },
        quinn::ConnectionError::ApplicationClosed(_) | quinn::ConnectionError::Reset => return Fault::HangsUp,
        _ => None,
    };
    told.map_or_else(|| Fault::Other(error.to_string()), |(alert, side)| Fault::of_alert(alert, side))
}
