//! The program as schedulers run it: shards, a merge, and a process that is killed.

use image::{Rgb, RgbImage};
use std::{
    fs,
    path::Path,
    process::{Command, Output},
};

const PROGRAM: &str = env!("CARGO_BIN_EXE_yurameki-fluid");

/// Three rivers as folders of frames.
fn rivers(folder: &Path) {
    for seed in 0..3u32 {
        let river = folder.join(format!("water_{seed}"));
        fs::create_dir_all(&river).unwrap();
        for frame in 0..14u32 {
            let picture = RgbImage::from_fn(144, 120, |x, y| {
                let (x, y, t) = (x as f32 - (1.0 + seed as f32) * frame as f32, y as f32, frame as f32);
                let level = (0.31 * x + 0.12 * y + seed as f32).sin() + (0.37 * y - 0.17 * x).cos();
                let level = if y < 80.0 { level + (0.9 * t + 0.2 * y).sin() } else { (0.5 * y).sin() };
                Rgb([(128.0 + 30.0 * level) as u8; 3])
            });
            picture.save(river.join(format!("{frame}.png"))).unwrap();
        }
    }
}

fn run(arguments: &[&str]) -> Output {
    Command::new(PROGRAM).args(arguments).output().unwrap()
}

fn told(output: &Output) -> String {
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8_lossy(&output.stdout).into_owned()
}

/// What is in a database, its directory's name and sizes left out.
fn content(db: &str) -> Vec<String> {
    told(&run(&["stats", "--db", db])).lines().skip(1).map(str::to_owned).collect()
}

#[test]
fn shards_in_processes_of_their_own_make_the_same_database() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
    rivers(&folder.path().join("videos"));
    told(&run(&["index", &at("videos"), "--db", &at("whole"), "--jobs", "2"]));
    for shard in ["1/2", "2/2"] {
        let part = at(&format!("part{}", &shard[..1]));
        told(&run(&["index", &at("videos"), "--db", &part, "--shard", shard, "--jobs", "1"]));
        let refused = run(&["merge", &at("nothing"), "--db", &at("joined")]);
        assert!(
            !refused.status.success() && String::from_utf8_lossy(&refused.stderr).contains("no database")
        );
    }
    told(&run(&["merge", &at("part1"), &at("part2"), "--db", &at("joined")]));
    assert_eq!(content(&at("joined")), content(&at("whole")));
    assert!(told(&run(&["check", "--db", &at("joined")])).contains("all is well"));
}

#[test]
fn a_killed_process_loses_no_more_than_the_video_in_work() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
    rivers(&folder.path().join("videos"));
    let mut child = Command::new(PROGRAM)
        .args(["index", &at("videos"), "--db", &at("db"), "--jobs", "1"])
        .stdout(std::process::Stdio::piped())
        .spawn()
        .unwrap();
    // Its first line says that a video is in.
    let mut line = String::new();
    std::io::BufRead::read_line(&mut std::io::BufReader::new(child.stdout.take().unwrap()), &mut line)
        .unwrap();
    child.kill().unwrap();
    child.wait().unwrap();
    assert!(line.contains("taken: water"), "{line}");
    let again = told(&run(&["index", &at("videos"), "--db", &at("db"), "--jobs", "1"]));
    assert!(again.contains("water_0 known"), "{again}");
    told(&run(&["index", &at("videos"), "--db", &at("whole")]));
    assert_eq!(content(&at("db")), content(&at("whole")));
}

#[test]
fn the_line_for_gnu_parallel_works() {
    if Command::new("parallel").arg("--version").output().is_err() {
        eprintln!("skipped: there is no GNU parallel");
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
    rivers(&folder.path().join("videos"));
    let programs = Path::new(PROGRAM).parent().unwrap().to_str().unwrap();
    let path = format!("{programs}:{}", std::env::var("PATH").unwrap_or_default());
    let script = concat!(env!("CARGO_MANIFEST_DIR"), "/cluster/gnu-parallel.sh");
    // Five shards for three videos: two of them have nothing to do.
    let output = Command::new(script)
        .args([&at("videos"), &at("db"), "5", "--jobs", "2"])
        .env("PATH", path)
        .output()
        .unwrap();
    told(&output);
    told(&run(&["index", &at("videos"), "--db", &at("whole")]));
    assert_eq!(content(&at("db")), content(&at("whole")));
}
