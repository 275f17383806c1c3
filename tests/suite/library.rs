//! Folders that are watched, by the thread that does it in the program.

use std::{
    fs,
    path::Path,
    thread,
    time::{Duration, Instant},
};
use yurameki::{
    app::playlist::PhotoId,
    config::Order,
    os::library::{Library, photo_id},
};

/// Waits until the library lists `want`, in this order, and gives the photos that were told as changed meanwhile.
fn wait_for(library: &mut Library, want: &[&Path]) -> Vec<PhotoId> {
    let want: Vec<_> = want.iter().map(|path| photo_id(path)).collect();
    let (mut changed, start) = (Vec::new(), Instant::now());
    while library.photos() != want {
        assert!(start.elapsed() < Duration::from_secs(50), "before the slow poll could have found it");
        thread::sleep(Duration::from_millis(20));
        changed.extend(library.news().unwrap_or_default().changed);
    }
    changed
}

#[test]
fn photos_that_come_and_go_and_folders_that_come_late_are_seen() {
    let folder = tempfile::tempdir().expect("a folder");
    let (here, late) = (folder.path().join("here"), folder.path().join("late"));
    fs::create_dir(&here).expect("created");
    let [a, b, c, d] = ["a.jpg", "b.jpg", "in/c.jpg", "d.jpg"].map(|name| here.join(name));
    fs::write(&a, "a").expect("written");
    let mut library = Library::watch(&[&here, &late], Order::Name);
    wait_for(&mut library, &[&a]);
    assert_eq!(library.path(photo_id(&a)), Some(a.as_path()));

    fs::create_dir(here.join("in")).expect("created");
    for path in [&b, &c, &d] {
        fs::write(path, "x").expect("written");
    }
    fs::remove_file(&a).expect("removed");
    wait_for(&mut library, &[&b, &d, &c]);
    assert_eq!(library.path(photo_id(&a)), None);

    // A stick.
    fs::create_dir(&late).expect("created");
    let e = late.join("e.jpg");
    fs::write(&e, "e").expect("written");
    wait_for(&mut library, &[&b, &d, &c, &e]);
    fs::remove_dir_all(&late).expect("removed");
    wait_for(&mut library, &[&b, &d, &c]);

    fs::write(&d, "another picture").expect("written");
    let f = here.join("f.jpg");
    fs::write(&f, "f").expect("written");
    let mut changed = wait_for(&mut library, &[&b, &d, &f, &c]);
    let start = Instant::now();
    while changed.is_empty() {
        assert!(start.elapsed() < Duration::from_secs(50));
        thread::sleep(Duration::from_millis(20));
        changed.extend(library.news().unwrap_or_default().changed);
    }
    assert_eq!(changed, [photo_id(&d)]);
}
