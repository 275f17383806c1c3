//! `yurameki render`: a photo's first seconds, to a file.

use super::{
    Failure, args,
    config::Config,
    interrupt::Interrupt,
    moving,
    output::{FrameHash, Target, Writer},
    progress::Progress,
    scene::{Picture, Scene, Source},
    stdout::print_line,
};
use crate::{
    app::Show,
    display::sim::{self, Buffering, Sim},
    frame::Layout,
};
use clap::Parser;
use rustix::process::getuid;
use std::env;

/// The demo photo, to a file in the folder for temporary files.
pub(super) fn demo() -> Result<(), Failure> {
    let out = env::temp_dir().join(format!("yurameki-demo-{}.webp", getuid().as_raw()));
    let out = out.to_string_lossy();
    let words = ["yurameki", "render", "demo", "--out", &out, "--size", "480x320", "--frames", "60"];
    let Some(args::Command::Render(args)) = args::Args::parse_from(words).command else {
        unreachable!("`render` was asked for")
    };
    film(&args, Source::Demo)?;
    print_line(format_args!("{out}: the demo photo, alive for {} seconds", args.frames / args.fps))
}

/// What is left of a film that was stopped.
fn stopped(args: &args::Render) -> &'static str {
    match args.out {
        Some(Target::Stdout) => "stopped; the video on standard output ends early",
        Some(Target::File { .. } | Target::Folder(_)) => "stopped; nothing was written",
        None => "stopped",
    }
}

pub(super) fn render(args: &args::Render) -> Result<(), Failure> {
    match args.source {
        Some(motion) => moving::film(args, motion),
        None => film(args, args.photo.as_deref().map_or(Source::Demo, Source::File)),
    }
}

fn film(args: &args::Render, source: Source<'_>) -> Result<(), Failure> {
    let interrupt = Interrupt::install()?;
    let config = Config { typed: args.look.clone(), ..Config::default() };
    let scene = Scene::load(source, args.size, &config)?;
    let life = scene.look().life.at(args.fps);
    let mut picture = scene.prepare(&life, Vec::new(), |_| ())?;
    let mut show = Show::new(life.drive, args.fps, args.look.seed.unwrap_or(config.seed));
    if args.frames == 1 && matches!(picture, Picture::Kaleidoscope(_)) {
        // There is no second frame in which it could come out of the photo.
        show.come_alive();
    }
    write(args, &interrupt, |done, panel| {
        picture.set_stage(scene.look().season.of_film(done, args.frames));
        Ok(show.turn(&mut picture, scene.caption(), panel)?)
    })
}

/// Writes the frames that `turn`, told how many there were before, shows on a panel.
pub(super) fn write(
    args: &args::Render,
    interrupt: &Interrupt,
    mut turn: impl FnMut(u32, &mut Sim<Vec<u8>>) -> Result<(), Failure>,
) -> Result<(), Failure> {
    let layout = Layout::new(args.size, args.format, None)?;
    let memory = vec![0; sim::memory_len(layout, Buffering::Single)];
    let mut panel = Sim::new(memory, layout, Buffering::Single, 0)?;
    let open = |target: &Target| Writer::create(target, args.size, args.rate(), args.frames);
    let mut writer = args.out.as_ref().map(open).transpose()?;
    let mut hash = args.hash.then(FrameHash::new);
    let progress = Progress::new(args.frames, args.quiet);
    for done in 0..args.frames {
        if interrupt.requested() {
            return Err(Failure::new(stopped(args)));
        }
        turn(done, &mut panel)?;
        let Some(frame) = panel.shown() else { unreachable!("a frame was just presented") };
        if let Some(writer) = &mut writer {
            writer.write(frame)?;
        }
        if let Some(hash) = &mut hash {
            hash.update(frame);
        }
        progress.frame_done();
    }
    drop(progress);
    if let Some(writer) = writer {
        writer.finish()?;
    }
    if let Some(hash) = hash {
        print_line(hash.hex())?;
    }
    Ok(())
}
