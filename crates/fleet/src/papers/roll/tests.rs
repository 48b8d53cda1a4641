//! Who gets in, who is put out, and what is kept of it.

use super::*;
use crate::papers::DAY_S;

const NOW: u64 = 1_800_000_000;
/// How long a token is good, s.
const TOKEN_S: u64 = 3_600;

fn plane(text: &str) -> Newcomer {
    Newcomer::Aircraft(text.parse().expect("a name"))
}

fn ticket(secret: u8) -> Ticket {
    Ticket { secret: vec![secret; 16], ..Ticket::default() }
}

fn says(result: Result<impl std::fmt::Debug, FleetError>, what: &str) {
    let error = result.expect_err(what).to_string();
    assert!(error.contains(what), "{error}");
}

#[test]
fn a_token_is_good_once_and_for_its_time() {
    let mut roll = Roll::new(vec![]);
    roll.promise(&plane("plane7"), &ticket(1), TOKEN_S, NOW).expect("promised");
    assert_eq!(roll.open_tokens(NOW).count(), 1);
    assert!(!String::from_utf8(roll.bytes()).expect("text").contains(&hex(&[1; 16])), "the secret is not kept");
    says(roll.redeem(&[2; 16], &[1; 32], NOW), "does not know");
    says(roll.redeem(&[1; 16], &[1; 32], NOW + TOKEN_S), "expired");
    assert_eq!(roll.redeem(&[1; 16], &[1; 32], NOW + TOKEN_S - 1), Ok(("plane7".to_owned(), None)));
    // The answer was lost: the same computer asks again.
    assert_eq!(roll.redeem(&[1; 16], &[1; 32], NOW + TOKEN_S - 1), Ok(("plane7".to_owned(), None)));
    says(roll.redeem(&[1; 16], &[3; 32], NOW), "has been used");
    assert_eq!(roll.open_tokens(NOW).count(), 0);
    roll.promise(&plane("plane7"), &ticket(4), TOKEN_S, NOW).expect("promised");
    says(roll.redeem(&[1; 16], &[1; 32], NOW), "does not know");
}

#[test]
fn who_was_put_out_stays_out_and_its_name_waits_for_its_certificate() {
    let mut roll = Roll::new(vec![]);
    says(roll.revoke("plane7", NOW), "no aircraft plane7");
    roll.enter("plane7", &[1; 32], None, NOW + 90 * DAY_S, NOW);
    roll.enter("plane8", &[2; 32], None, NOW + 90 * DAY_S, NOW);
    assert_eq!(roll.renew("plane7", &[1; 32]), Ok(()));
    says(roll.renew("plane7", &[2; 32]), "enrolled again");
    says(roll.renew("plane9", &[1; 32]), "no plane9");
    // It has a new key, or has not heard that it has.
    roll.enter("plane7", &[3; 32], Some(&[1; 32]), NOW + 90 * DAY_S, NOW);
    assert_eq!(roll.renew("plane7", &[1; 32]), roll.renew("plane7", &[3; 32]));
    roll.enter("plane7", &[4; 32], Some(&[3; 32]), NOW + 90 * DAY_S, NOW);
    says(roll.renew("plane7", &[1; 32]), "enrolled again");
    roll.revoke("plane7", NOW).expect("revoked");
    says(roll.renew("plane7", &[4; 32]), "revoked");
    assert_eq!(roll.admitted(false).collect::<Vec<_>>(), ["plane8"]);
    says(roll.promise(&plane("plane7"), &ticket(1), TOKEN_S, NOW), "ends in 90 days");
    roll.promise(&plane("plane7"), &ticket(1), TOKEN_S, NOW + 90 * DAY_S).expect("free again");
}

#[test]
fn a_ground_station_is_listed_with_its_role_until_it_is_put_out() {
    let org = "acme".parse().expect("a name");
    let mut roll = Roll::new(vec![]);
    roll.operator = Some(PublicKey([9; 32]).to_string());
    let tower = |role| Newcomer::Station("tower".parse().expect("a name"), role, vec![]);
    roll.promise(&tower(Role::Chief), &ticket(1), TOKEN_S, NOW).expect("promised");
    let before = roll.clone();
    let (name, role) = roll.redeem(&[1; 16], &[1; 32], NOW).expect("good");
    assert_eq!((name.as_str(), role), ("_tower", Some((Role::Chief, vec![]))));
    roll.enter(&name, &[1; 32], None, NOW + 90 * DAY_S, NOW);
    says(roll.clone().post(&name, (Role::Chief, vec![]), &PublicKey([9; 32])), "another ground station's");
    roll.post(&name, (Role::Chief, vec![]), &PublicKey([1; 32])).expect("posted");
    roll.number_after(&before, &org, NOW);
    let listed: Vec<_> = roll.stations(&org).stations.into_iter().map(|each| (each.name, each.role)).collect();
    assert_eq!(listed, [("ground".into(), "operator".into()), ("tower".into(), "chief".into())]);
    assert_eq!(roll.number, NOW);
    assert_eq!((roll.admitted(true).count(), roll.admitted(false).count()), (1, 0));
    // An aircraft of the same name is somebody else, and changes nothing of the list.
    let before = roll.clone();
    roll.enter("tower", &[2; 32], None, NOW + 90 * DAY_S, NOW);
    roll.number_after(&before, &org, NOW + 1);
    assert_eq!(roll.number, NOW);
    // A renewed certificate leaves it its role. Put out, it is on the list no more, whatever the clock says.
    roll.enter(&name, &[3; 32], Some(&[1; 32]), NOW + 90 * DAY_S, NOW);
    assert_eq!(roll.stations(&org), before.stations(&org));
    roll.revoke(&name, NOW).expect("revoked");
    roll.number_after(&before, &org, NOW - 7);
    assert_eq!((roll.stations(&org).stations.len(), roll.number), (1, NOW + 1));
    says(roll.promise(&tower(Role::Operator), &ticket(2), TOKEN_S, NOW), "tower was revoked");
    let ground = Newcomer::Station("ground".parse().expect("a name"), Role::Operator, vec![]);
    says(roll.promise(&ground, &ticket(2), TOKEN_S, NOW), "has the authority");
}

#[test]
fn a_roll_is_read_as_it_is_kept() {
    let mut roll = Roll::new(vec!["ground.local".into()]);
    roll.enter("plane7", &[1; 32], None, NOW, NOW);
    roll.promise(&plane("plane8"), &ticket(1), TOKEN_S, NOW).expect("promised");
    assert_eq!(Roll::read(&roll.bytes()), Ok(roll));
    let damaged = br#"{"version": 1, "hosts": [], "members": {"plane7": 5}}"#;
    let told = Roll::read(damaged).expect_err("plane7 is a number");
    assert!(told.starts_with("members.plane7: ") && told.contains("line 1"), "{told}");
    assert!(Roll::read(b"{\"version\": 3, \"hosts\": []}").is_err_and(|error| error.contains("version 3")));
    let first = br#"{"version": 1, "hosts": ["ground"], "aircraft": {"plane7": {"enrolled": 1, "ends": 2, "key": "00", "revoked": 2}}}"#;
    let read = Roll::read(first).expect("the first version");
    assert_eq!(read.members["plane7"].revoked, Some(2), "whoever was put out stays out");
    assert_eq!(Roll::read(&read.bytes()), Ok(read));
}

#[test]
fn whoever_guesses_has_to_wait_and_nobody_else() {
    let (eve, ana) = (IpAddr::from([10, 0, 0, 1]), IpAddr::from([10, 0, 0, 2]));
    let mut guesses = Guesses::default();
    for second in 0..10 {
        assert!(!guesses.must_wait(eve, Duration::from_secs(second)));
        guesses.wrong(eve, Duration::from_secs(second));
    }
    assert!(guesses.must_wait(eve, Duration::from_secs(59)) && !guesses.must_wait(ana, Duration::from_secs(59)));
    assert!(!guesses.must_wait(eve, Duration::from_secs(60)));
}
