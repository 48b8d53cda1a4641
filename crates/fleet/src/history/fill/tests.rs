//! Schedules: an aircraft that writes, is restarted and deletes, and a ground station that hears some of it, over a way
//! that loses, doubles, delays and is cut by a seed. And the time that a long cut takes to be filled on a narrow
//! uplink.

use rand::rngs::SmallRng;
use rand::{Rng, SeedableRng};

use super::super::record::{Entry, Span};
use super::*;

/// What is on the disk on board.
#[derive(Default)]
struct Board {
    boot: u64,
    records: BTreeMap<(u64, Stream), BTreeMap<u64, Vec<u8>>>,
    /// Everything that was ever written.
    ever: BTreeMap<(u64, Stream, u64), Vec<u8>>,
}

impl Board {
    fn write(&mut self, stream: Stream, rng: &mut SmallRng) -> (u64, Vec<u8>) {
        let kept = self.records.entry((self.boot, stream)).or_default();
        let number = self.ever.range((self.boot, stream, 0)..=(self.boot, stream, u64::MAX)).count() as u64 + 1;
        let data: Vec<u8> = (0..rng.random_range(20..300)).map(|_| rng.random()).collect();
        kept.insert(number, data.clone());
        self.ever.insert((self.boot, stream, number), data.clone());
        (number, data)
    }

    fn index(&self, nonce: u64) -> Index {
        let ranges = |kept: &BTreeMap<u64, Vec<u8>>| kept.keys().map(|&number| (number, number)).collect();
        // Boots count up here.
        let kept = self.records.iter().rev().filter(|(_, kept)| !kept.is_empty());
        Index::of(nonce, self.boot, kept.map(|(&(boot, stream), kept)| (boot, stream, ranges(kept))))
    }

    fn piece(&self, wanted: &Wanted) -> Piece {
        let stream = Stream::of_code(wanted.stream).expect("a stream");
        let (mut entries, mut bytes, mut end) = (Vec::new(), 0, wanted.last);
        let none = BTreeMap::new();
        for (&number, data) in
            self.records.get(&(wanted.boot, stream)).unwrap_or(&none).range(wanted.first..=wanted.last)
        {
            if bytes > 0 && bytes + data.len() > wanted.max_bytes as usize {
                end = number - 1;
                break;
            }
            bytes += data.len();
            entries.push(Entry { number, clock_ms: number * 100, unix_ns: 0, data: data.clone() });
        }
        Piece::of(wanted, end, entries)
    }
}

/// A ground station, and the way to it.
struct World {
    rng: SmallRng,
    now: MonoTime,
    board: Board,
    fill: Fill,
    archive: BTreeMap<(u64, Stream, u64), Vec<u8>>,
    is_cut: bool,
    /// Answers on their way: when they come.
    answers: Vec<(MonoTime, Answer)>,
    /// When the outstanding question is given up.
    given_up: MonoTime,
    asked: u64,
}

#[derive(Clone)]
enum Answer {
    Index(Index),
    Piece(Piece),
}

impl World {
    fn new(seed: u64) -> Self {
        Self {
            rng: SmallRng::seed_from_u64(seed),
            now: MonoTime::ZERO,
            board: Board { boot: 1, ..Board::default() },
            fill: Fill::new(BTreeMap::new()),
            archive: BTreeMap::new(),
            is_cut: false,
            answers: Vec::new(),
            given_up: MonoTime::ZERO,
            asked: 0,
        }
    }

    fn keep(&mut self, key: (u64, Stream, u64), data: Vec<u8>) {
        assert!(self.archive.insert(key, data).is_none(), "{key:?} came into the archive twice");
    }

    fn step(&mut self, is_bad: bool) {
        self.now += Duration::from_millis(50);
        if self.now >= self.given_up && self.fill.asked.is_some() {
            self.fill.on_silence(self.now);
        }
        let (come, wait): (Vec<_>, Vec<_>) = self.answers.drain(..).partition(|(at, _)| *at <= self.now);
        self.answers = wait;
        for (_, answer) in come {
            match answer {
                Answer::Index(index) => drop(self.fill.on_index(&index, self.now)),
                Answer::Piece(piece) => {
                    for record in self.fill.on_piece(&piece, self.now).unwrap_or_default() {
                        self.keep((record.boot, record.stream, record.number), record.data);
                    }
                }
            }
        }
        let Some(question) = self.fill.ask(self.now) else { return };
        (self.given_up, self.asked) = (self.now + ANSWER_WITHIN, self.asked + 1);
        if self.is_cut || (is_bad && self.rng.random_bool(0.3)) {
            return;
        }
        let answer = match question {
            Question::Index(nonce) => Answer::Index(self.board.index(nonce)),
            Question::Piece(wanted) => Answer::Piece(self.board.piece(&wanted)),
        };
        for _ in 0..1 + u32::from(is_bad && self.rng.random_bool(0.2)) {
            // Some come when nobody waits any more.
            let takes = Duration::from_millis(self.rng.random_range(20..if is_bad { 8_000 } else { 200 }));
            self.answers.push((self.now + takes, answer.clone()));
        }
    }

    /// The aircraft goes on for a while.
    fn live(&mut self) {
        for _ in 0..self.rng.random_range(0..4) {
            let stream = Stream::ALL[self.rng.random_range(0..3)];
            let (number, data) = self.board.write(stream, &mut self.rng);
            let is_told = stream != Stream::Audit && !self.is_cut && self.rng.random_bool(0.8);
            if is_told && self.fill.take(self.board.boot, stream, number) {
                self.keep((self.board.boot, stream, number), data);
            }
        }
        match self.rng.random_range(0..200) {
            0 => self.board.boot += 1,
            1 => {
                // The oldest is deleted to make room.
                if let Some(kept) = self.board.records.values_mut().next() {
                    let half = kept.keys().copied().take(kept.len() / 2 + 1).collect::<Vec<_>>();
                    half.iter().for_each(|number| drop(kept.remove(number)));
                }
                self.board.records.retain(|_, kept| !kept.is_empty());
            }
            2..5 => self.is_cut = !self.is_cut,
            _ => {}
        }
    }
}

/// Whatever the network did, in the end the archive has, byte for byte, all that is still on board; nothing twice; what
/// is not to be had is told as that, and not asked for any more.
#[test]
fn schedules_end_with_all_that_is_to_be_had() {
    let seeds = std::env::var("VENCEJO_TEST_SEEDS").ok().and_then(|seeds| seeds.parse().ok()).unwrap_or(300);
    let (mut filled, mut lost) = (0, 0);
    for seed in 0..seeds {
        let mut world = World::new(seed);
        for _ in 0..400 {
            world.live();
            world.step(true);
        }
        let heard = world.archive.len();
        world.is_cut = false;
        world.fill.on_present(world.now);
        for _ in 0..6_000 {
            world.step(false);
        }
        for (&(boot, stream), kept) in &world.board.records {
            for (&number, data) in kept {
                assert_eq!(
                    world.archive.get(&(boot, stream, number)),
                    Some(data),
                    "seed {seed}: {boot} {stream:?} {number}"
                );
            }
        }
        for (key, data) in &world.archive {
            assert_eq!(world.board.ever.get(key), Some(data), "seed {seed}: {key:?}");
        }
        let archived: BTreeSet<_> = world.archive.keys().copied().collect();
        for gap in world.fill.gaps() {
            assert!(gap.is_lost, "seed {seed}: {gap:?} is still asked for");
            assert!((gap.first..=gap.last).all(|number| !archived.contains(&(gap.boot, gap.stream, number))));
            lost += gap.last - gap.first + 1;
        }
        filled += world.archive.len() - heard;
        let before = world.asked;
        for _ in 0..1_200 {
            world.step(false);
        }
        assert!(
            world.asked - before <= 3,
            "seed {seed}: {} questions in a minute in which nothing is missing",
            world.asked - before
        );
    }
    assert!(filled > 1_000 && lost > 100, "{filled} filled, {lost} lost: the schedules try nothing");
}

/// A ten-minute cut at 10 Hz, over an uplink of 256 kbit/s that carries the states of the present as well: how long it
/// takes, and how long an order waits behind what is on the way.
#[test]
fn a_ten_minute_cut_is_filled_while_orders_keep_their_way() {
    const UPLINK_BIT_S: f64 = 256_000.0;
    const STATE_BYTES: usize = 330;
    let ms = |s: f64| MonoTime::from_micros((s * 1e6) as u64);
    for (rate_hz, most_s) in [(10.0, 330.0), (1.0, 40.0)] {
        let mut board = Board { boot: 7, ..Board::default() };
        let cut = (600.0 * rate_hz) as u64;
        let records = (1..=cut).map(|number| (number, vec![number as u8; STATE_BYTES])).collect();
        board.records.insert((7, Stream::State), records);
        let mut fill = Fill::new(BTreeMap::new());
        // The queue of the modem: when its last bit is through. Round trips take 80 ms besides.
        let (mut now, mut free_at, mut waits, mut filled) = (0.0_f64, 0.0_f64, Vec::new(), 0);
        let (mut state_due, mut answer) = (0.0, None);
        while filled < cut {
            assert!(now < 600.0, "{filled} of {cut} in ten minutes");
            now += 0.005;
            if now >= state_due {
                free_at = free_at.max(now) + (STATE_BYTES + 96) as f64 * 8.0 / UPLINK_BIT_S;
                state_due += 1.0 / rate_hz;
            }
            waits.push((free_at - now).max(0.0));
            match answer.take_if(|(at, _): &mut (f64, Answer)| *at <= now) {
                Some((_, Answer::Index(index))) => assert!(fill.on_index(&index, ms(now))),
                Some((_, Answer::Piece(piece))) => {
                    filled += fill.on_piece(&piece, ms(now)).expect("a piece").len() as u64
                }
                None => {}
            }
            let Some(question) = fill.ask(ms(now)) else { continue };
            let (reply, bytes) = match question {
                Question::Index(nonce) => (Answer::Index(board.index(nonce)), 200),
                Question::Piece(wanted) => {
                    let piece = board.piece(&wanted);
                    let bytes = prost::Message::encoded_len(&piece);
                    (Answer::Piece(piece), bytes + 96)
                }
            };
            free_at = free_at.max(now + 0.04) + bytes as f64 * 8.0 / UPLINK_BIT_S;
            answer = Some((free_at + 0.04, reply));
        }
        waits.sort_by(f64::total_cmp);
        let p99_ms = waits[waits.len() * 99 / 100] * 1e3;
        println!("{rate_hz} Hz: ten minutes filled in {now:.0} s, an answer to an order waits {p99_ms:.0} ms (p99)");
        assert!(now < most_s, "{rate_hz} Hz: {now:.0} s");
        assert!(p99_ms <= 250.0, "{rate_hz} Hz: an order waits {p99_ms:.0} ms");
    }
}

#[test]
fn pieces_grow_again_on_a_way_that_is_slower_for_good() {
    let mut board = Board { boot: 7, ..Board::default() };
    let records = (1..=10_000).map(|number| (number, vec![number as u8; 1_000])).collect();
    board.records.insert((7, Stream::State), records);
    let (mut fill, mut now) = (Fill::new(BTreeMap::new()), MonoTime::ZERO);
    let mut fill_until = |end_s: u64, took| {
        let mut sizes = Vec::new();
        while now < MonoTime::from_millis(end_s * 1_000) {
            now += Duration::from_millis(5);
            let Some(question) = fill.ask(now) else { continue };
            now += took;
            match question {
                Question::Index(nonce) => assert!(fill.on_index(&board.index(nonce), now)),
                Question::Piece(wanted) => {
                    sizes.push(wanted.max_bytes);
                    fill.on_piece(&board.piece(&wanted), now).expect("a piece");
                }
            }
        }
        sizes
    };
    assert!(fill_until(10, Duration::from_millis(40)).contains(&MAX_PIECE_BYTES));
    let sizes = fill_until(150, Duration::from_millis(300));
    assert!(sizes.contains(&LEAST_BYTES), "the pieces may have been too large");
    assert_eq!(sizes.last(), Some(&MAX_PIECE_BYTES), "it is the way");
}

#[test]
fn what_nobody_asked_for_or_what_was_changed_is_not_used() {
    let mut fill = Fill::new(BTreeMap::new());
    let now = MonoTime::from_millis(1);
    let index = Index::of(1, 7, [(7, Stream::Event, [(1, 9)].into_iter().collect())]);
    assert!(!fill.on_index(&index, now));
    assert_eq!(fill.ask(now), Some(Question::Index(1)));
    assert!(!fill.on_index(&Index { nonce: 9, ..index.clone() }, now), "an answer to another question");
    assert_eq!(fill.ask(now), None, "one question at a time");
    assert!(fill.on_index(&Index::read(&prost::Message::encode_to_vec(&index)).expect("read"), now));
    let later = MonoTime::from_millis(5_000);
    let Some(Question::Piece(wanted)) = fill.ask(later) else { panic!("nothing is asked for") };
    assert_eq!((wanted.first, wanted.last, wanted.boot), (1, 9, 7));
    let entry = |number| Entry { number, clock_ms: 1, unix_ns: 2, data: vec![3; 10] };
    let good = Piece::of(&wanted, 2, vec![entry(1), entry(2)]);
    let mut bytes = prost::Message::encode_to_vec(&good);
    assert_eq!(Piece::read(&bytes).as_ref(), Ok(&good));
    bytes[12] ^= 1;
    assert!(Piece::read(&bytes).is_err());
    let others = [
        Piece { boot: 8, ..good.clone() },
        Piece { last: 10, ..good.clone() },
        Piece::of(&wanted, 2, vec![entry(2), entry(1)]),
        Piece::of(&wanted, 2, vec![entry(3)]),
    ];
    for other in &others {
        assert_eq!(fill.on_piece(other, later), Err(BadPiece::Other), "{other:?}");
    }
    assert_eq!(fill.on_piece(&good, later).map(|new| new.len()), Ok(2));
    assert_eq!(fill.on_piece(&good, later), Err(BadPiece::Other), "a second time");
    let endless = Index {
        kept: vec![super::super::record::Kept { boot: 7, stream: 1, spans: vec![Span { first: 0, last: u64::MAX }] }],
        ..index
    };
    assert!(Index::read(&prost::Message::encode_to_vec(&endless)).is_err());
}
