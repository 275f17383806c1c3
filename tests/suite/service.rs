//! What the service manager hears of the program, on a socket as systemd has one.

use rustix::{
    fs::{OFlags, fcntl_getfl, fcntl_setfl},
    process::{Pid, Signal, kill_process},
};
use std::{
    fs,
    io::{ErrorKind, PipeReader, PipeWriter, Read, Write, pipe},
    os::unix::net::UnixDatagram,
    path::{Path, PathBuf},
    process::{Child, Command, Stdio},
    time::Duration,
};
use tempfile::TempDir;

/// A service manager with a folder of its own.
struct Manager {
    folder: TempDir,
    socket: UnixDatagram,
}

/// Within this time something is heard of a program that goes on. It is no measure of its speed.
const LONG: Duration = Duration::from_secs(60);

impl Manager {
    fn new() -> Self {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let socket = UnixDatagram::bind(folder.path().join("notify")).expect("a socket");
        socket.set_read_timeout(Some(LONG)).expect("a time");
        Self { folder, socket }
    }

    fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    /// The program, as a service whose watchdog must be fed every 400 ms.
    fn service(&self, words: &[&str]) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_yurameki"));
        command.arg("run").args(words).args(["--display", "sim:64x48", "--mask", "none"]);
        command.env("NOTIFY_SOCKET", self.path("notify")).env("WATCHDOG_USEC", "400000");
        command.env("STATE_DIRECTORY", self.path("state")).env_remove("WATCHDOG_PID").env_remove("RUST_LOG");
        command.stdout(Stdio::null());
        command
    }

    /// The next message, without which the test fails.
    fn hear(&self) -> String {
        let mut bytes = [0; 4096];
        let length = self.socket.recv(&mut bytes).expect("the program says something");
        String::from_utf8(bytes[..length].to_vec()).expect("text")
    }

    fn hear_until(&self, word: &str) -> Vec<String> {
        let mut heard = vec![self.hear()];
        while !heard.last().expect("one at least").contains(word) {
            heard.push(self.hear());
        }
        heard
    }

    /// Whether nothing is said for five times as long as the watchdog waits.
    fn is_silent(&self) -> bool {
        self.socket.set_read_timeout(Some(Duration::from_secs(2))).expect("a time");
        let heard = self.socket.recv(&mut [0; 4096]);
        self.socket.set_read_timeout(Some(LONG)).expect("a time");
        heard.is_err_and(|error| error.kind() == ErrorKind::WouldBlock)
    }
}

fn photo() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/drawn.jpg")
}

fn ends_well(mut child: Child) {
    assert!(child.wait().expect("the program ends").success());
}

fn feeds(messages: &[String]) -> usize {
    messages.iter().filter(|message| message.contains("WATCHDOG=1\n")).count()
}

#[test]
fn a_show_is_ready_once_feeds_the_watchdog_says_how_it_goes_and_that_it_ends() {
    let manager = Manager::new();
    let photo = photo();
    let words = [photo.to_str().expect("text"), "--frames", "30", "--amplitude", "white"];
    let child = manager.service(&words).stderr(Stdio::null()).spawn().expect("the program starts");
    let heard = manager.hear_until("STOPPING=1");
    ends_well(child);
    let ready: Vec<usize> = (0..heard.len()).filter(|&i| heard[i].contains("READY=1\n")).collect();
    let &[ready] = &ready[..] else { panic!("ready {} times: {heard:?}", ready.len()) };
    assert_eq!(feeds(&heard[..ready]), 0, "no watchdog before the first frame: {heard:?}");
    // Thirty frames take two and a half seconds, and every second of them comes after a quarter of the watchdog's time.
    assert!((4..=30).contains(&feeds(&heard[ready..])), "{heard:?}");
    let status = heard.iter().rev().find(|message| message.contains("STATUS=")).expect("a status");
    assert!(status.contains(" fps, drawn.jpg, amplitude white, frequency "), "{status}");
    assert_eq!(heard.last().expect("the end"), "STOPPING=1\n");
}

#[test]
fn a_frame_without_a_photo_is_ready_and_says_what_it_waits_for() {
    let manager = Manager::new();
    let photos = manager.path("photos");
    fs::create_dir(&photos).expect("a folder");
    let config = manager.path("config.toml");
    fs::write(&config, "[photos]\nfolders = [\"photos\"]\n").expect("a file");
    let words = ["--config", config.to_str().expect("text")];
    let child = manager.service(&words).stderr(Stdio::null()).spawn().expect("the program starts");
    assert_eq!(manager.hear(), "READY=1\nWATCHDOG=1\nSTATUS=waiting for a photo\n");
    fs::copy(photo(), photos.join("lake.jpg")).expect("a copy");
    manager.hear_until("STATUS=lake.jpg");
    kill_process(Pid::from_child(&child), Signal::TERM).expect("the program is ours");
    manager.hear_until("STOPPING=1");
    ends_well(child);
}

/// A pipe that has no room.
fn full_pipe() -> (PipeReader, PipeWriter) {
    let (reader, mut writer) = pipe().expect("a pipe");
    let flags = fcntl_getfl(&writer).expect("a pipe has flags");
    fcntl_setfl(&writer, flags | OFlags::NONBLOCK).expect("the pipe is ours");
    while writer.write(&[b'.'; 4096]).is_ok() {}
    fcntl_setfl(&writer, flags).expect("the pipe is ours");
    (reader, writer)
}

#[test]
fn a_loop_that_hangs_starves_the_watchdog() {
    let manager = Manager::new();
    let (mut reader, writer) = full_pipe();
    let photo = photo();
    let words = [photo.to_str().expect("text"), "--frames", "24"];
    let mut child = manager.service(&words).stderr(writer).spawn().expect("the program starts");
    manager.hear_until("READY=1");
    // This is answered by a line of the log, which finds no room: the loop hangs there, and the program lives.
    kill_process(Pid::from_child(&child), Signal::USR1).expect("the program is ours");
    while !manager.is_silent() {}
    assert!(child.try_wait().expect("the program is ours").is_none(), "it lives");
    let log = std::thread::spawn(move || reader.read_to_end(&mut Vec::new()));
    let heard = manager.hear_until("STOPPING=1");
    assert!(feeds(&heard) > 0, "it goes on where it was: {heard:?}");
    ends_well(child);
    log.join().expect("no panic").expect("the log is read");
}
