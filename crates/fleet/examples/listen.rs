//! Subscribers to all aircraft of an organisation, each with a session of its own, as a ground station that looks at
//! the whole list: states, events, who is there. They count the states of `crowd … stamped` and those that are missing
//! by their numbers, and how old each is when it is here. With `ask` one of them also asks one aircraft after another
//! for its state, 50 times a second, and measures the answers.
//!
//! `listen ROUTER ORG COUNT SECONDS [ask]`. Prints READY once each has heard of an aircraft, then a line of JSON with
//! what came in those seconds.

#![allow(clippy::print_stdout, reason = "a measuring program")]

use std::error::Error;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant, SystemTime, UNIX_EPOCH};

use vencejo_fleet::carrier::{Endpoint, session_of_an_aircraft};
use vencejo_fleet::key::{Kind, Name, aircraft_of, key_of, keys_of_all};
use zenoh::Session;
use zenoh::qos::{CongestionControl, Priority};
use zenoh::sample::Sample;

/// Ages and times are counted in steps of this…
const STEP_US: u64 = 20;
/// …of which there are so many: up to 2 s. What is older counts as that old, beside the worst.
const STEPS: usize = 100_000;
/// Between two questions.
const ASK_EVERY: Duration = Duration::from_millis(20);
const READY_WITHIN: Duration = Duration::from_secs(30);

/// How often each duration was seen.
struct Durations {
    steps: Vec<u32>,
    count: u64,
    worst_us: u64,
}

impl Durations {
    fn new() -> Self {
        Self { steps: vec![0; STEPS], count: 0, worst_us: 0 }
    }

    fn add(&mut self, us: u64) {
        let step = usize::try_from(us / STEP_US).unwrap_or(STEPS).min(STEPS - 1);
        self.steps[step] += 1;
        self.count += 1;
        self.worst_us = self.worst_us.max(us);
    }

    fn join(&mut self, other: &Self) {
        self.steps.iter_mut().zip(&other.steps).for_each(|(ours, theirs)| *ours += theirs);
        self.count += other.count;
        self.worst_us = self.worst_us.max(other.worst_us);
    }

    /// The duration below which this share lies, µs.
    fn quantile(&self, share: f64) -> u64 {
        let (wanted, mut seen) = ((self.count as f64 * share) as u64, 0);
        for (step, count) in self.steps.iter().enumerate() {
            seen += u64::from(*count);
            if seen > wanted {
                return step as u64 * STEP_US;
            }
        }
        self.worst_us
    }

    fn json(&self) -> String {
        let (median, p99) = (self.quantile(0.5), self.quantile(0.99));
        format!(
            "{{\"count\": {}, \"median_us\": {median}, \"p99_us\": {p99}, \"worst_us\": {}}}",
            self.count, self.worst_us
        )
    }
}

/// A vehicle that was silent for so long counts as lost.
const LOST_AFTER: Duration = vencejo_vehicle::telemetry::LOST_AFTER;

/// The last state of an aircraft.
#[derive(Clone, Copy)]
struct Last {
    number: u64,
    at: Instant,
    longest_silence: Duration,
}

/// What one subscriber heard.
struct Heard {
    /// By the number of the aircraft.
    last: Vec<Option<Last>>,
    is_counting: bool,
    states: u64,
    lost: u64,
    bytes: u64,
    ages: Durations,
}

impl Heard {
    fn on_state(&mut self, org: &Name, sample: &Sample) {
        let Some((number, put_us)) = sample.attachment().and_then(|stamp| stamp_of(&stamp.to_bytes())) else { return };
        let Some(name) = aircraft_of(org, Kind::State, sample.key_expr().as_str()) else { return };
        let Ok(index) = name.trim_start_matches("plane").parse::<usize>() else { return };
        if index >= self.last.len() {
            self.last.resize(index + 1, None);
        }
        let at = Instant::now();
        let last = self.last[index].get_or_insert(Last { number: number - 1, at, longest_silence: Duration::ZERO });
        if self.is_counting {
            last.longest_silence = last.longest_silence.max(at - last.at);
        }
        let missing = number.saturating_sub(last.number + 1);
        (last.number, last.at) = (number, at);
        if !self.is_counting {
            return;
        }
        self.lost += missing;
        self.states += 1;
        self.bytes += sample.payload().len() as u64;
        self.ages.add(utc_us().saturating_sub(put_us));
    }
}

fn stamp_of(bytes: &[u8]) -> Option<(u64, u64)> {
    let (number, put_us) = bytes.split_at_checked(8)?;
    Some((u64::from_le_bytes(number.try_into().ok()?), u64::from_le_bytes(put_us.try_into().ok()?)))
}

fn utc_us() -> u64 {
    SystemTime::now().duration_since(UNIX_EPOCH).map_or(0, |since| u64::try_from(since.as_micros()).unwrap_or(u64::MAX))
}

fn with<T>(heard: &Mutex<Heard>, act: impl FnOnce(&mut Heard) -> T) -> T {
    act(&mut heard.lock().unwrap_or_else(PoisonError::into_inner))
}

/// One subscriber.
async fn subscribe(router: &Endpoint, org: &Name) -> Result<(Session, Arc<Mutex<Heard>>), Box<dyn Error>> {
    let words = |error: zenoh::Error| error.to_string();
    let session = session_of_an_aircraft(router).await?;
    let (last, ages) = (Vec::new(), Durations::new());
    let heard = Arc::new(Mutex::new(Heard { last, is_counting: false, states: 0, lost: 0, bytes: 0, ages }));
    let (here, of) = (heard.clone(), org.clone());
    let states = session.declare_subscriber(keys_of_all(org, Kind::State));
    let hear = move |sample| with(&here, |heard| heard.on_state(&of, &sample));
    states.callback(hear).background().await.map_err(words)?;
    // As the others do; nothing is made of them here.
    let events = session.declare_subscriber(keys_of_all(org, Kind::Event));
    events.callback(drop).background().await.map_err(words)?;
    let tokens = session.liveliness().declare_subscriber(keys_of_all(org, Kind::Alive)).history(true);
    tokens.callback(drop).background().await.map_err(words)?;
    Ok((session, heard))
}

/// Asks one aircraft after another until then.
async fn ask(
    session: &Session,
    org: &Name,
    aircraft: usize,
    until: Instant,
) -> Result<(Durations, u64), Box<dyn Error>> {
    let (mut took, mut unanswered, mut number) = (Durations::new(), 0, 0);
    while Instant::now() < until && aircraft > 0 {
        let name: Name = format!("plane{:04}", number * 7 % aircraft).parse()?;
        let began = Instant::now();
        let get = session.get(key_of(org, &name, Kind::State)).congestion_control(CongestionControl::Drop);
        let replies = get.priority(Priority::RealTime).express(true).await.map_err(|error| error.to_string())?;
        match replies.recv_async().await {
            Ok(reply) if reply.result().is_ok() => took.add(u64::try_from(began.elapsed().as_micros())?),
            _ => unanswered += 1,
        }
        number += 1;
        tokio::time::sleep(ASK_EVERY.saturating_sub(began.elapsed())).await;
    }
    Ok((took, unanswered))
}

async fn measure(
    router: &Endpoint,
    org: &Name,
    count: usize,
    seconds: Duration,
    asks: bool,
) -> Result<(), Box<dyn Error>> {
    let mut subscribers = Vec::new();
    for _ in 0..count {
        subscribers.push(subscribe(router, org).await?);
    }
    let began = Instant::now();
    while !subscribers.iter().all(|(_, heard)| with(heard, |heard| !heard.last.is_empty())) {
        if began.elapsed() > READY_WITHIN {
            return Err("not all of them hear an aircraft: is `crowd … stamped` there?".into());
        }
        tokio::time::sleep(Duration::from_millis(50)).await;
    }
    // What was put while the last of them came is heard by now.
    tokio::time::sleep(Duration::from_secs(1)).await;
    subscribers.iter().for_each(|(_, heard)| with(heard, |heard| heard.is_counting = true));
    println!("READY");
    let until = Instant::now() + seconds;
    let (session, first) = subscribers.first().ok_or("COUNT begins with 1")?;
    let aircraft = with(first, |heard| heard.last.len());
    let (took, unanswered) = ask(session, org, if asks { aircraft } else { 0 }, until).await?;
    tokio::time::sleep_until(until.into()).await;
    let (mut ages, mut states, mut lost, mut bytes) = (Durations::new(), 0, 0, 0);
    let (mut longest_silence, mut were_lost) = (Duration::ZERO, 0);
    for (_, heard) in &subscribers {
        with(heard, |heard| {
            heard.is_counting = false;
            for last in heard.last.iter().flatten() {
                // Whoever has not come back counts until now.
                let silence = last.longest_silence.max(last.at.elapsed());
                longest_silence = longest_silence.max(silence);
                were_lost += u32::from(silence > LOST_AFTER);
            }
            ages.join(&heard.ages);
            states += heard.states;
            lost += heard.lost;
            bytes += heard.bytes;
        });
    }
    println!(
        "{{\"aircraft\": {aircraft}, \"states\": {states}, \"lost\": {lost}, \"payload_bytes\": {bytes}, \
         \"longest_silence_s\": {:.3}, \"were_lost\": {were_lost}, \"ages\": {}, \"asked\": {}, \"unanswered\": {unanswered}}}",
        longest_silence.as_secs_f64(),
        ages.json(),
        took.json()
    );
    // The sessions end with the process.
    std::process::exit(0)
}

fn main() -> Result<(), Box<dyn Error>> {
    let args: Vec<_> = std::env::args().skip(1).collect();
    let usage = "listen ROUTER ORG COUNT SECONDS [ask]";
    let [router, org, count, seconds, rest @ ..] = args.as_slice() else { return Err(usage.into()) };
    let asks = match rest {
        [] => false,
        [word] if word == "ask" => true,
        _ => return Err(usage.into()),
    };
    let (router, org, count, seconds): (Endpoint, Name, usize, f64) =
        (router.parse()?, org.parse()?, count.parse()?, seconds.parse()?);
    let runtime = tokio::runtime::Builder::new_multi_thread().worker_threads(2).enable_all().build()?;
    runtime.block_on(measure(&router, &org, count, Duration::try_from_secs_f64(seconds)?, asks))
}
