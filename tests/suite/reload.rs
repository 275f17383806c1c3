//! A configuration that is read anew while photos are shown, and what changes beside a photo.

use crate::cli::data;
use rustix::process::{Pid, Signal, kill_process};
use std::{
    fs,
    io::{BufRead, BufReader, Lines},
    path::{Path, PathBuf},
    process::{Child, ChildStderr, Command, Stdio},
};
use tempfile::TempDir;

/// The program at work, and the folder with its photos and its configuration.
struct Running {
    folder: TempDir,
    child: Child,
    lines: Lines<BufReader<ChildStderr>>,
}

impl Running {
    /// Starts it with the folders `a` and `b`, a photo in each and something that is none, and a configuration of `a`.
    fn start() -> Self {
        let folder = tempfile::tempdir().expect("a temporary folder");
        for name in ["a", "b"] {
            let photos = folder.path().join(name);
            fs::create_dir(&photos).expect("created");
            fs::copy(data("drawn.jpg"), photos.join("photo.jpg")).expect("copied");
            fs::write(photos.join(format!("no-{name}.jpg")), "no photo").expect("written");
        }
        configure(folder.path(), "", "a");
        let mut child = Command::new(env!("CARGO_BIN_EXE_yurameki"))
            .args(["run", "--display", "sim:64x48", "--config"])
            .arg(folder.path().join("config.toml"))
            .env_remove("RUST_LOG")
            .stdin(Stdio::null())
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .expect("the program starts");
        let lines = BufReader::new(child.stderr.take().expect("piped")).lines();
        Self { folder, child, lines }
    }

    fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    /// Waits for a line that the program writes with `part` in it, and gives it.
    fn until(&mut self, part: &str) -> String {
        let mut seen = Vec::new();
        for line in self.lines.by_ref().map(|line| line.expect("text")) {
            if line.contains(part) {
                return line;
            }
            seen.push(line);
        }
        panic!("the program has ended without a line with {part:?}, after {seen:#?}");
    }

    fn signal(&self, signal: Signal) {
        kill_process(Pid::from_child(&self.child), signal).expect("the program is ours");
    }

    /// Ends it, and gives its exit code and what it printed.
    fn end(self) -> (Option<i32>, String) {
        self.signal(Signal::TERM);
        drop(self.lines);
        let output = self.child.wait_with_output().expect("it ends");
        (output.status.code(), String::from_utf8(output.stdout).expect("text"))
    }
}

/// Writes a configuration with the photos of one folder: a line for the section of the display, and the folder.
fn configure(folder: &Path, display: &str, photos: &str) {
    let text = format!("[display]\nfps = 20\n{display}\n[photos]\nseconds = 5\nfolders = [\"{photos}\"]\n");
    fs::write(folder.join("config.toml"), text).expect("written");
}

#[test]
fn a_new_configuration_holds_at_once_and_a_wrong_one_not_at_all() {
    let mut running = Running::start();
    // The handler is there before the first photo is loaded.
    running.until("no-a.jpg: is not a picture");

    configure(running.folder.path(), "rotatoin = 90", "b");
    running.signal(Signal::USR1);
    let line = running.until("config.toml:3:1");
    assert!(line.contains("did you mean rotation?"), "{line}");
    running.until("the configuration stays as it was");

    configure(running.folder.path(), "rotation = 90\noutput = \"window\"\nbacklight = \"none-such\"", "b");
    running.signal(Signal::USR1);
    running.until("display.backlight: takes effect at the next start");
    running.until("the configuration was read anew");
    running.until("no-b.jpg: is not a picture");

    let (code, stdout) = running.end();
    assert_eq!(code, Some(0));
    assert!(stdout.contains("frames, "), "{stdout:?}");
}

#[test]
fn a_sidecar_that_comes_beside_the_photo_that_is_shown_is_read() {
    let mut running = Running::start();
    running.until("no-a.jpg: is not a picture");
    let sidecar = running.path("a/photo.toml");
    fs::write(&sidecar, "wnid = 90").expect("written");
    let line = running.until("photo.toml:1:1");
    assert!(line.contains("did you mean wind?"), "{line}");
    assert_eq!(running.end().0, Some(0));
}
