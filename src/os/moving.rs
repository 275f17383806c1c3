//! `yurameki render --source`: a kaleidoscope of a photo that shimmers, or of a film.

use super::{
    Failure,
    args::{self, Motion},
    config::{Config, Look},
    interrupt::Interrupt,
    photo::{self, Limits, Options},
    render::write,
    scene::{Scene, Source, Way, load_reference},
};
use crate::{
    app::Show,
    config::{EffectChoice, Life},
    effect::{
        Effect, Moment,
        kaleidoscope::{Moving, Reference, Still, moving_storage_len},
    },
    math::{Factor, smoothstep},
    noise::{
        drive::{Drive, Oscillator},
        guard::Guard,
    },
};
use std::path::{Path, PathBuf};

pub(super) fn film(args: &args::Render, motion: Motion) -> Result<(), Failure> {
    if args.look.effect != Some(EffectChoice::Kaleidoscope) {
        return Err(Failure::new("--source is what a kaleidoscope is made of; add --effect kaleidoscope"));
    }
    let Some(path) = &args.photo else { unreachable!("a kaleidoscope asks for a photo") };
    let config = Config { typed: args.look.clone(), ..Config::default() };
    match motion {
        Motion::Shimmer => of_shimmer(args, path, &config),
        Motion::Frames => of_frames(args, path, &config),
    }
}

/// The photo shimmers as it does without a kaleidoscope: what its mask leaves still stays the photo. A clip plays.
fn of_shimmer(args: &args::Render, path: &Path, config: &Config) -> Result<(), Failure> {
    let mode = config.plain_look().life.kaleidoscope.mode;
    let way = Way { effect: EffectChoice::Shimmer, mode };
    let scene = Scene::load_as(Source::File(path), None, Some(way), args.size, config)?;
    let life = scene.look().life.at(args.fps);
    let mut shimmer = scene.prepare(&life, Vec::new(), |_| ())?;
    let mut oscillator = Oscillator::new(life.drive, args.look.seed.unwrap_or(config.seed));
    let mut guard = Guard::default();
    let photo = Still { size: args.size, rgb: scene.photo().rgb };
    let mut frame = 0;
    write_moving(args, scene.look(), &life, photo, |moving| {
        // As without a kaleidoscope, it comes alive within a second.
        let share = (u64::from(args.fps.min(frame)) << Factor::FRAC_NBITS) / u64::from(args.fps);
        let onset = smoothstep(Factor::from_bits(share as i32));
        guard.set(shimmer.sensitivity(), args.fps);
        moving.see(&shimmer.at(Drive { onset, ..guard.limit(oscillator.step()) }));
        frame += 1;
        Ok(())
    })
}

/// The pictures of a folder, in the order of their names, from the start again after the last.
fn of_frames(args: &args::Render, folder: &Path, config: &Config) -> Result<(), Failure> {
    let paths = photo::list([folder])?;
    let look = config.plain_look();
    let options = Options { fit: look.fit, background: look.background, ..Options::new(args.size) };
    let mut frames = paths.iter().cycle();
    let mut next = || -> Result<photo::Photo, Failure> {
        let none =
            || Failure::new(format!("{}: no frames are there; name a folder of pictures", folder.display()));
        let path: &PathBuf = frames.next().ok_or_else(none)?;
        Ok(photo::load(path, &options)?)
    };
    let (first, life) = (next()?, look.life.at(args.fps));
    let mut shown = Some(first.clone());
    write_moving(args, &look, &life, Still { size: args.size, rgb: &first.rgb }, |moving| {
        let frame = shown.take().map_or_else(&mut next, Ok)?;
        moving.see(&Still { size: args.size, rgb: &frame.rgb });
        Ok(())
    })
}

/// Writes the film of a source that begins with `first`; `see` shows the kaleidoscope the next frame of it.
fn write_moving(
    args: &args::Render,
    look: &Look,
    life: &Life,
    first: Still<'_>,
    mut see: impl FnMut(&mut Moving<Vec<u64>>) -> Result<(), Failure>,
) -> Result<(), Failure> {
    let interrupt = Interrupt::install()?;
    let other = load_reference(look.reference.as_deref(), look, &Limits::default())?;
    let own = Reference { size: first.size, rgb: first.rgb };
    let reference = other.as_ref().map_or(own, |other| Reference { size: other.size, rgb: &other.rgb });
    let storage = vec![0; moving_storage_len(first.size())];
    let mut moving = Moving::prepare(&first, reference, &life.kaleidoscope, storage)?;
    let seed = args.look.seed.unwrap_or(Config::default().seed);
    let mut show = Show::new(life.drive, args.fps, seed);
    write(args, &interrupt, |_, panel| {
        see(&mut moving)?;
        Ok(show.turn(&mut moving, "", panel)?)
    })
}
