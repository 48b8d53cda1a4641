//! The door: the enrolment server, where aircraft and ground stations are enrolled with a token and renew their
//! certificates. TLS, beside the router.

use std::net::SocketAddr;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

use prost::Message;
use tokio::io::{AsyncRead, AsyncReadExt, AsyncWrite, AsyncWriteExt};
use tokio::net::{TcpListener, TcpStream};
use tokio::sync::{Notify, Semaphore};
use tokio::task::JoinHandle;
use tokio_rustls::TlsAcceptor;

use super::organisation::Organisation;
use super::{tls, unix_now};
use crate::error::FleetError;
use crate::papers::certificate::{Facts, facts_of_der};
use crate::papers::roll::Guesses;
use crate::papers::wire::{Asked, BAD_REQUEST, Given, MAX_BYTES};
use crate::payload::VERSION;

/// The time limit of a caller.
const PATIENCE: Duration = Duration::from_secs(10);
/// Most callers at once; further ones wait.
const CALLERS: usize = 16;

/// A door that is open until it is dropped.
pub(super) struct Door(JoinHandle<()>);

impl Drop for Door {
    fn drop(&mut self) {
        self.0.abort();
    }
}

/// State shared by all callers.
struct Desk {
    organisation: Organisation,
    guesses: Mutex<Guesses>,
    opened: Instant,
    /// Notified when the roll has changed.
    news: Arc<Notify>,
}

/// Binds the listener; port 0 takes a free one.
pub(super) async fn listen(address: &str) -> Result<(TcpListener, SocketAddr), FleetError> {
    let failed =
        |error: std::io::Error| FleetError::Network { address: address.to_owned(), problem: error.to_string() };
    let listener = TcpListener::bind(address).await.map_err(failed)?;
    let at = listener.local_addr().map_err(failed)?;
    Ok((listener, at))
}

impl Door {
    /// Starts it.
    pub(super) fn open(listener: TcpListener, organisation: Organisation, news: Arc<Notify>) -> Self {
        let (guesses, opened) = (Mutex::default(), Instant::now());
        let desk = Arc::new(Desk { organisation, guesses, opened, news });
        let callers = Arc::new(Semaphore::new(CALLERS));
        Self(tokio::spawn(async move {
            loop {
                // The semaphore is never closed.
                let Ok(place) = callers.clone().acquire_owned().await else { return };
                let (stream, from) = match listener.accept().await {
                    Ok(accepted) => accepted,
                    Err(error) => {
                        tracing::warn!(%error, "nobody can be enrolled for a moment");
                        tokio::time::sleep(Duration::from_millis(100)).await;
                        continue;
                    }
                };
                let desk = desk.clone();
                tokio::spawn(async move {
                    let _place = place;
                    if tokio::time::timeout(PATIENCE, desk.serve(stream, from)).await.is_err() {
                        tracing::debug!(%from, "a caller at the door took too long");
                    }
                });
            }
        }))
    }
}

impl Desk {
    async fn serve(self: &Arc<Self>, stream: TcpStream, from: SocketAddr) {
        let desk = self.clone();
        // Read anew for each caller: the ground station's own certificate is renewed too.
        let config = blocking(move || tls::server(&desk.organisation.identity(unix_now())?)).await;
        let config = match config {
            Ok(config) => config,
            Err(error) => return tracing::warn!(%error, "nobody can be enrolled"),
        };
        let mut stream = match TlsAcceptor::from(config).accept(stream).await {
            Ok(stream) => stream,
            // One of us does not trust the other; the caller was told.
            Err(error) => return tracing::info!(%from, %error, "a caller at the door went away"),
        };
        let shown = stream.get_ref().1.peer_certificates().and_then(|chain| facts_of_der(chain.first()?).ok());
        let given = match read_message::<Asked>(&mut stream).await {
            Ok(asked) => self.answer(asked, shown, from).await,
            Err(error) => Given::refused(format!("the question cannot be read: {error}")),
        };
        if let Err(error) = write_message(&mut stream, &given).await {
            // The caller asks again, with the same key.
            tracing::info!(%from, %error, "an answer at the door was not heard");
        }
        let _ = stream.shutdown().await;
    }

    async fn answer(self: &Arc<Self>, asked: Asked, shown: Option<Facts>, from: SocketAddr) -> Given {
        let guesses = || self.guesses.lock().unwrap_or_else(PoisonError::into_inner);
        if guesses().must_wait(from.ip(), self.opened.elapsed()) {
            return Given::refused("too many wrong tokens came from this address: wait a minute");
        }
        if asked.version != VERSION {
            return Given::refused("another version of Vencejo asks: use the same on both sides");
        }
        let desk = self.clone();
        let judged = blocking(move || {
            let certificate = desk.organisation.judge(&asked, shown.as_ref(), unix_now())?;
            Ok((certificate, desk.organisation.read("ca.crt")?, desk.organisation.stations()?))
        });
        match judged.await {
            Ok(((name, certificate), ca, stations)) => {
                tracing::info!(%name, %from, "a member of the fleet has a new certificate");
                self.news.notify_one();
                let org = self.organisation.org().to_string();
                Given { version: VERSION, refused: String::new(), org, name, certificate, ca, stations }
            }
            Err(FleetError::Refused(why)) => {
                guesses().wrong(from.ip(), self.opened.elapsed());
                tracing::warn!(%from, why, "a caller at the door was refused");
                Given::refused(why)
            }
            Err(error) => {
                tracing::warn!(%from, %error, "a caller at the door got nothing");
                // Callers are not told what is wrong with our files.
                let why = if matches!(error, FleetError::Certificate { .. }) {
                    BAD_REQUEST
                } else {
                    "something is wrong on the ground; look there"
                };
                Given::refused(why)
            }
        }
    }
}

/// Runs blocking work off the runtime's threads.
pub(super) async fn blocking<T: Send + 'static>(
    run: impl FnOnce() -> Result<T, FleetError> + Send + 'static,
) -> Result<T, FleetError> {
    let ended = |_| FleetError::Network { address: "the fleet".into(), problem: "it was ended".into() };
    tokio::task::spawn_blocking(run).await.map_err(ended)?
}

/// Reads one message: its length, then itself.
pub(super) async fn read_message<M: Message + Default>(stream: &mut (impl AsyncRead + Unpin)) -> std::io::Result<M> {
    let invalid = |why: &str| std::io::Error::new(std::io::ErrorKind::InvalidData, why.to_owned());
    let length = stream.read_u32().await? as usize;
    if length > MAX_BYTES {
        return Err(invalid("it is too long"));
    }
    let mut bytes = vec![0; length];
    stream.read_exact(&mut bytes).await?;
    M::decode(bytes.as_slice()).map_err(|_| invalid("it is no Protocol Buffers"))
}

/// Writes one message.
pub(super) async fn write_message(
    stream: &mut (impl AsyncWrite + Unpin),
    message: &impl Message,
) -> std::io::Result<()> {
    let bytes = message.encode_to_vec();
    let length = u32::try_from(bytes.len()).map_err(std::io::Error::other)?;
    stream.write_all(&[&length.to_be_bytes()[..], &bytes].concat()).await?;
    stream.flush().await
}

#[cfg(test)]
mod tests {
    use super::*;

    #[tokio::test]
    async fn what_is_too_long_or_none_is_not_read() {
        let read = async |bytes: &[u8]| read_message::<Asked>(&mut &*bytes).await.map_err(|error| error.to_string());
        let asked = Asked { version: VERSION, secret: vec![1], request: vec![2], operator: vec![] };
        let mut bytes = Vec::new();
        write_message(&mut bytes, &asked).await.expect("written");
        assert_eq!(read(&bytes).await, Ok(asked));
        assert_eq!(read(&u32::MAX.to_be_bytes()).await, Err("it is too long".to_owned()));
        assert_eq!(read(&[0, 0, 0, 1, 0xff]).await, Err("it is no Protocol Buffers".to_owned()));
        assert!(read(&bytes[..bytes.len() - 1]).await.is_err());
    }
}
