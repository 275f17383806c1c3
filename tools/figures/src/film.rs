//! A photo, alive, frame by frame.

use crate::Failure;
use std::path::PathBuf;
use yurameki::{
    app::Show,
    config::{DEFAULT_FRAMES_PER_SECOND, Life, Preset},
    display::sim::{Buffering, Sim, memory_len},
    effect::shimmer::{Shimmer, storage_len},
    frame::{FrameRef, Layout, PixelFormat, Size},
    noise::drive,
    os::{
        args::{Look, size},
        config::Config,
        scene::{Scene, Source},
    },
};

/// Which photo, how large, and how it lives.
#[derive(Debug, clap::Args)]
pub(crate) struct Subject {
    /// The photo, instead of the built-in one.
    #[arg(long, value_name = "FILE")]
    photo: Option<PathBuf>,
    /// Width and height in pixels.
    #[arg(long, value_name = "WxH", default_value = "640x427", value_parser = size)]
    pub(crate) size: Size,
    /// How it lives.
    #[command(flatten)]
    pub(crate) look: Look,
}

impl Subject {
    /// Loads the photo.
    pub(crate) fn load(&self) -> Result<Scene, Failure> {
        let source = self.photo.as_deref().map_or(Source::Demo, Source::File);
        Scene::load(source, self.size, &self.config()).map_err(|failure| failure.to_string().into())
    }

    /// How it lives: as the paper's poplar, unless another preset or single settings were asked for.
    pub(crate) fn life(&self) -> Life {
        let mut life = self.config().plain_look().life;
        if self.look.preset.is_none() && self.look.range.is_none() {
            let mut paper = Life::default();
            Preset::Poplar.apply(&mut paper);
            life.shimmer.range = paper.shimmer.range;
        }
        life
    }

    /// The noises' seed.
    pub(crate) fn seed(&self) -> u64 {
        self.look.seed.unwrap_or(self.config().seed)
    }

    fn config(&self) -> Config {
        Config { typed: self.look.clone(), ..Config::default() }
    }
}

/// The frames of a photo that was prepared once.
pub(crate) struct Film<'a> {
    name: &'a str,
    shimmer: Shimmer<&'a mut [u64]>,
    layout: Layout,
}

impl<'a> Film<'a> {
    /// The film of `scene`, in memory that [`Self::storage`] has made for its size.
    pub(crate) fn new(scene: &'a Scene, life: &Life, storage: &'a mut [u64]) -> Result<Self, Failure> {
        let photo = scene.photo();
        let shimmer = Shimmer::prepare(photo, &life.shimmer, storage)?;
        Ok(Self {
            name: scene.caption(),
            shimmer,
            layout: Layout::new(photo.size, PixelFormat::Bgr888, None)?,
        })
    }

    /// What a film of `size` takes.
    pub(crate) fn storage(size: Size) -> Vec<u64> {
        vec![0; storage_len(size)]
    }

    /// Where the pixels of its frames lie: red, green, blue, without a gap.
    pub(crate) const fn layout(&self) -> Layout {
        self.layout
    }
}

/// One showing of a film, from the still photo on.
pub(crate) struct Showing {
    show: Show,
    panel: Sim<Vec<u8>>,
}

impl Showing {
    /// A showing of `film`, driven by noise.
    pub(crate) fn new(film: &Film<'_>, drive: drive::Settings, seed: u64) -> Result<Self, Failure> {
        let memory = vec![0; memory_len(film.layout, Buffering::Single)];
        let panel = Sim::new(memory, film.layout, Buffering::Single, 0)?;
        Ok(Self { show: Show::new(drive, DEFAULT_FRAMES_PER_SECOND, seed), panel })
    }

    /// The next frame.
    pub(crate) fn frame(&mut self, film: &mut Film<'_>) -> Result<FrameRef<'_>, Failure> {
        self.show.turn(&mut film.shimmer, film.name, &mut self.panel)?;
        Ok(self.panel.shown().ok_or("the simulated panel shows nothing")?)
    }
}
