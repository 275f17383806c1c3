//! What a frame remembers: it is whole whatever happens, and nothing that happens to it stops the show.

use crate::logbook;
use proptest::prelude::*;
use std::{
    env, fs,
    io::{BufRead as _, BufReader},
    os::unix::{ffi::OsStrExt as _, fs::symlink},
    path::{Path, PathBuf},
    process::{Command, Stdio},
    thread,
    time::Duration,
};
use yurameki::{
    app::playlist::{EARLY, HISTORY, PhotoId, Snapshot},
    config::Order,
    noise::Kind,
    os::state::{Fault, Memory, State, default_folder},
};

/// A state that differs from that of every other `number` in each of its parts, and is long enough to be torn.
fn state(number: u64) -> State {
    let id = |i: u64| PhotoId(number.wrapping_mul(0x9e37_79b9_7f4a_7c15).wrapping_add(i));
    State {
        playlist: Snapshot {
            order: Order::NAMES[number as usize % 3].1,
            salt: number,
            place: number.checked_sub(1).map(|before| (before, id(0))),
            history: (0..HISTORY as u64).map(id).collect(),
            back: number as usize % HISTORY,
            early: (0..number % (EARLY as u64 + 1)).map(|i| (id(i), i)).collect(),
        },
        amplitude: Some(Kind::ALL[number as usize % 8]),
        frequency: number.is_multiple_of(2).then_some(Kind::Brown),
    }
}

fn open(folder: &Path) -> (Memory, Option<State>) {
    Memory::open(Some(folder.to_owned()))
}

fn warnings() -> Vec<String> {
    logbook::lines().into_iter().filter(|line| line.starts_with("WARN")).collect()
}

#[test]
fn what_was_written_is_read_again() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path().join("not there yet");
    let (mut memory, nothing) = open(&folder);
    assert_eq!(nothing, None);
    for number in [0, 1, 2, 300] {
        memory.keep_now(&state(number));
        assert_eq!(open(&folder).1, Some(state(number)));
    }
    assert_eq!(fs::read_dir(&folder).expect("a folder").count(), 1, "nothing else is left");
}

#[test]
fn the_card_is_written_to_once_a_minute_and_only_for_something_new() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("state");
    let (mut memory, _) = open(folder.path());
    let mut asked = 0;
    for second in 0..150 {
        memory.keep(Duration::from_secs(second), || {
            asked += 1;
            state(second)
        });
        let want = second / 60 * 60;
        assert_eq!(State::from_text(&fs::read(&path).expect("a file")), Ok(state(want)));
    }
    assert_eq!(asked, 3);
    memory.keep_now(&state(149));
    fs::remove_file(&path).expect("it is there");
    memory.keep_now(&state(149));
    assert!(!path.exists(), "nothing new, nothing written");
}

#[test]
fn a_state_that_was_cut_or_changed_is_refused() {
    let text = state(7).to_text().into_bytes();
    assert_eq!(State::from_text(&text), Ok(state(7)));
    for cut in 0..text.len() {
        assert!(State::from_text(&text[..cut]).is_err(), "cut at {cut}");
    }
    for bit in 0..8 * text.len() {
        let mut flipped = text.clone();
        flipped[bit / 8] ^= 1 << (bit % 8);
        assert!(State::from_text(&flipped).is_err(), "bit {bit}");
    }
}

#[test]
fn a_bad_state_is_put_aside_with_one_warning() {
    let whole = state(3).to_text();
    let cases = [
        (whole[..200].to_owned(), "damaged"),
        (whole.replacen("state 1 ", "state 2 ", 1), "version 2"),
        (whole.replacen("state 1 ", "state 0 ", 1), "version 0"),
        (String::new(), "no state"),
        ("\u{0}".repeat(4096), "no state"),
        ("x".repeat(2 << 20), "too long"),
    ];
    for (text, why) in cases {
        let folder = tempfile::tempdir().expect("a folder");
        fs::write(folder.path().join("state"), &text).expect("written");
        logbook::lines();
        let (mut memory, nothing) = open(folder.path());
        assert_eq!(nothing, None, "{why}");
        let warnings = warnings();
        assert!(
            matches!(&warnings[..], [one] if one.contains(why) && one.contains("state.bad")),
            "{warnings:?}"
        );
        assert_eq!(fs::read(folder.path().join("state.bad")).expect("kept"), text.as_bytes());
        memory.keep_now(&state(1));
        assert_eq!(open(folder.path()).1, Some(state(1)), "the show goes on");
    }
    assert_eq!(State::from_text(b"yurameki state x y\n"), Err(Fault::Foreign));
}

#[test]
fn a_folder_that_cannot_be_written_is_told_once_and_the_show_goes_on() {
    let folder = tempfile::tempdir().expect("a folder");
    // A file where the folder should be.
    let below = folder.path().join("file/state");
    fs::write(folder.path().join("file"), "").expect("written");
    logbook::lines();
    let (mut memory, _) = open(&below);
    warnings();
    for number in 0..5 {
        memory.keep_now(&state(number));
        memory.hide(Path::new("/photos/a.jpg"));
    }
    assert_eq!(warnings().len(), 1);
    assert_eq!(memory.hidden(), [PathBuf::from("/photos/a.jpg")], "it is hidden all the same");
    let (mut nowhere, _) = Memory::open(None);
    nowhere.keep_now(&state(1));
    nowhere.hide(Path::new("/b.jpg"));
    assert_eq!((warnings().len(), nowhere.hidden().len()), (1, 1));
}

#[test]
fn a_full_disk_is_told_once_and_keeps_the_old_state() {
    let folder = tempfile::tempdir().expect("a folder");
    let (mut memory, _) = open(folder.path());
    memory.keep_now(&state(1));
    logbook::lines();
    for number in 2..5 {
        // Writing there fails with ENOSPC.
        symlink("/dev/full", folder.path().join("state.new")).expect("a link");
        memory.keep_now(&state(number));
        assert_eq!(open(folder.path()).1, Some(state(1)));
        assert!(fs::symlink_metadata(folder.path().join("state.new")).is_err(), "it takes no room");
    }
    assert_eq!(warnings().len(), 1);
    memory.keep_now(&state(9));
    assert_eq!(open(folder.path()).1, Some(state(9)));
}

#[test]
fn what_an_interrupted_write_leaves_is_harmless() {
    let folder = tempfile::tempdir().expect("a folder");
    open(folder.path()).0.keep_now(&state(1));
    let new = state(2).to_text();
    for len in [0, 1, 100, new.len()] {
        fs::write(folder.path().join("state.new"), &new[..len]).expect("written");
        let (mut memory, old) = open(folder.path());
        assert_eq!(old, Some(state(1)));
        memory.keep_now(&state(3));
        assert_eq!(open(folder.path()).1, Some(state(3)));
        memory.keep_now(&state(1));
    }
}

#[test]
fn hidden_photos_are_a_list_that_people_can_edit() {
    let folder = tempfile::tempdir().expect("a folder");
    let list = folder.path().join("hidden.txt");
    let odd = PathBuf::from(std::ffi::OsStr::from_bytes(b"/p/a\nb\\n \xff.jpg"));
    let (mut memory, _) = open(folder.path());
    memory.hide(Path::new("/p/one.jpg"));
    memory.hide(Path::new("/p/one.jpg"));
    memory.hide(&odd);
    let (again, _) = open(folder.path());
    assert_eq!(again.hidden(), [PathBuf::from("/p/one.jpg"), odd]);
    fs::write(&list, "# not nice\n\n/p/two.jpg").expect("written");
    let (mut memory, _) = open(folder.path());
    memory.hide(Path::new("/p/three.jpg"));
    assert_eq!(fs::read_to_string(&list).expect("a text"), "# not nice\n\n/p/two.jpg\n/p/three.jpg\n");
}

#[test]
fn the_folder_is_that_of_the_service_else_that_of_the_person() {
    let folder = |variables: &[(&str, &str)]| {
        let find = |name: &str| variables.iter().find(|(key, _)| *key == name).map(|(_, value)| value.into());
        default_folder(find)
    };
    let (service, state, home) =
        (("STATE_DIRECTORY", "/var/lib/a:/var/lib/b"), ("XDG_STATE_HOME", "/state"), ("HOME", "/home/me"));
    assert_eq!(folder(&[service, state, home]), Some("/var/lib/a".into()));
    assert_eq!(folder(&[state, home]), Some("/state/yurameki".into()));
    assert_eq!(folder(&[("STATE_DIRECTORY", ""), home]), Some("/home/me/.local/state/yurameki".into()));
    assert_eq!(
        folder(&[("XDG_STATE_HOME", "relative"), home]),
        Some("/home/me/.local/state/yurameki".into())
    );
    assert_eq!(folder(&[]), None);
}

const CHILD: &str = "YURAMEKI_STATE_CHILD";

/// Kills a process that writes the state without a pause, at moments that are spread over the time of a few writes. More of them:
/// `YURAMEKI_KILLS=500`.
#[test]
fn a_state_whose_writer_is_killed_is_old_or_new() {
    if let Some(folder) = env::var_os(CHILD) {
        let (mut memory, _) = open(Path::new(&folder));
        for number in 1.. {
            memory.keep_now(&state(number));
            if number == 1 {
                println!("written");
            }
        }
    }
    let kills = env::var("YURAMEKI_KILLS").ok().and_then(|text| text.parse().ok()).unwrap_or(60);
    let folder = tempfile::tempdir().expect("a folder");
    let (mut numbers, mut leftovers) = (Vec::new(), 0);
    for kill in 0..kills {
        let mut child = Command::new(env::current_exe().expect("this program"))
            .args(["--exact", "state::a_state_whose_writer_is_killed_is_old_or_new", "--nocapture"])
            .env(CHILD, folder.path())
            .stdout(Stdio::piped())
            .spawn()
            .expect("it can be started again");
        let output = BufReader::new(child.stdout.take().expect("piped"));
        assert!(output.lines().map_while(Result::ok).any(|line| line.contains("written")));
        // No result hangs on how long this is; 37 is coprime to 97, so that the moments are spread.
        thread::sleep(Duration::from_micros(kill * 37 % 97 * 40));
        child.kill().expect("it runs for ever");
        child.wait().expect("killed");
        let text = fs::read(folder.path().join("state")).expect("there from the first write on");
        let found = State::from_text(&text).unwrap_or_else(|fault| panic!("kill {kill}: {fault}"));
        assert_eq!(found, state(found.playlist.salt), "kill {kill}");
        numbers.push(found.playlist.salt);
        leftovers += u32::from(folder.path().join("state.new").exists());
    }
    let most = numbers.iter().max().expect("there were kills");
    eprintln!("{kills} kills, {leftovers} of them within a write; up to {most} writes before");
}

proptest! {
    #[test]
    fn a_state_from_outside_never_panics(text in prop::collection::vec(any::<u8>(), 0..400)) {
        prop_assert!(State::from_text(&text).is_err());
    }
}
