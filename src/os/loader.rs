//! Photos are decoded and prepared on a thread of their own, at low priority, while the show goes on.

use super::{
    Failure, caption,
    config::Config,
    scene::{self, Colours, Picture, Scene, Source, Way},
};
use crate::{app::playlist::PhotoId, config::EffectChoice, frame::Size, math::Turns, noise::drive};
use std::{
    fmt,
    path::PathBuf,
    sync::{
        Arc,
        atomic::{AtomicU8, Ordering},
        mpsc::{Receiver, Sender, channel},
    },
    thread,
};

/// A photo that was prepared for a panel of its size.
pub(super) struct Living {
    pub(super) id: PhotoId,
    /// What the information says of it.
    pub(super) caption: String,
    pub(super) size: Size,
    pub(super) picture: Picture,
    /// How it lives.
    pub(super) way: Way,
    /// The photo whose colours a kaleidoscope was asked to take.
    pub(super) colours: Option<PathBuf>,
    /// From where a grown tree is seen; photos have one side.
    pub(super) azimuth: Option<Turns>,
    /// The noises and times of the photo's own look.
    pub(super) drive: drive::Settings,
    /// How long it is to be shown.
    pub(super) seconds: u32,
    /// It, or how it is to be shown, has changed since.
    pub(super) stale: bool,
}

impl Living {
    pub(super) fn is_kaleidoscope(&self) -> bool {
        self.way.effect == EffectChoice::Kaleidoscope
    }
}

/// A photo to be loaded.
pub(super) struct Order {
    pub(super) id: PhotoId,
    /// `None` is the demo photo.
    pub(super) path: Option<PathBuf>,
    /// What a kaleidoscope takes.
    pub(super) colours: Option<Colours>,
    /// How it is to live, where a button has chosen that.
    pub(super) way: Option<Way>,
    /// From where a tree is seen.
    pub(super) azimuth: Turns,
    /// Of the panel.
    pub(super) size: Size,
    pub(super) config: Arc<Config>,
}

/// What has become of an order.
pub(super) type Outcome = (PhotoId, Result<Living, Failure>);

/// How far a kaleidoscope is coded.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Encoding {
    /// Of which photo.
    pub(super) name: Arc<str>,
    /// 1 to 100.
    pub(super) percent: u8,
}

impl fmt::Display for Encoding {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "encoding {} {} %", self.name, self.percent)
    }
}

/// The thread, and the one photo that it may be at.
pub(super) struct Loader {
    /// With the memory to prepare them in.
    orders: Sender<(Order, Vec<u64>)>,
    outcomes: Receiver<Outcome>,
    /// What is being worked at.
    at: Option<PhotoId>,
    /// What that is called.
    name: Arc<str>,
    /// How much of a kaleidoscope is coded, in per cent; 0 while none is.
    coded: Arc<AtomicU8>,
    /// What comes of it is of no use.
    cancelled: bool,
    /// Memory of photos that are no longer shown.
    spare: Vec<Vec<u64>>,
}

/// How much lower than that of the show the priority is, of 19. The picture goes before the next picture.
const NICE: i32 = 10;

impl Loader {
    /// Starts the thread; it ends with the loader.
    ///
    /// # Errors
    /// If the system gives no thread.
    pub(super) fn start() -> Result<Self, Failure> {
        let (orders, inbox) = channel::<(Order, Vec<u64>)>();
        let (outbox, outcomes) = channel();
        let coded = Arc::new(AtomicU8::new(0));
        let progress = Arc::clone(&coded);
        let work = move || {
            // On Linux the priority is each thread's own. Without the right to lower it the picture only may stand for a moment.
            let _ = rustix::process::nice(NICE);
            for (order, storage) in inbox {
                let id = order.id;
                let outcome = load(order, storage, &progress);
                progress.store(0, Ordering::Relaxed);
                if outbox.send((id, outcome)).is_err() {
                    break;
                }
            }
        };
        thread::Builder::new().name("loader".into()).spawn(work)?;
        Ok(Self { orders, outcomes, at: None, name: "".into(), coded, cancelled: false, spare: Vec::new() })
    }

    /// Whether an order is being worked at.
    pub(super) const fn is_busy(&self) -> bool {
        self.at.is_some()
    }

    /// How far the coding is, while there is some.
    pub(super) fn encoding(&self) -> Option<Encoding> {
        let percent = self.coded.load(Ordering::Relaxed);
        (percent > 0).then(|| Encoding { name: Arc::clone(&self.name), percent })
    }

    /// Has a photo loaded and prepared.
    pub(super) fn order(&mut self, order: Order) {
        self.name = order.path.as_deref().map_or("the demo photo".into(), caption::name_of).into();
        let (id, storage) = (order.id, self.spare.pop().unwrap_or_default());
        self.at = self.orders.send((order, storage)).is_ok().then_some(id);
        self.cancelled = false;
    }

    /// Gives up what is being worked at, if it `concerns` that.
    pub(super) fn cancel(&mut self, concerns: impl Fn(PhotoId) -> bool) {
        self.cancelled |= self.at.is_some_and(concerns);
    }

    /// The photo that was ordered, once it is there; does not wait.
    pub(super) fn take(&mut self) -> Option<Outcome> {
        let Ok(outcome) = self.outcomes.try_recv() else { return None };
        self.at = None;
        if !self.cancelled {
            return Some(outcome);
        }
        if let (_, Ok(living)) = outcome {
            self.recycle(living);
        }
        None
    }

    /// Takes the memory of a photo that is no longer shown.
    pub(super) fn recycle(&mut self, living: Living) {
        // One is loaded while one is shown: more is never needed.
        if self.spare.is_empty() {
            self.spare.push(living.picture.into_storage());
        }
    }
}

fn load(order: Order, storage: Vec<u64>, coded: &AtomicU8) -> Result<Living, Failure> {
    let Order { id, path, colours, way, azimuth, size, config } = order;
    let source = path.as_deref().map_or(Source::Demo, Source::File);
    let scene = Scene::load_as(source, colours, way, size, &config)?;
    let mut life = scene::turned(scene.look().life.at(config.frames_per_second), config.rotation);
    life.autumn.azimuth = azimuth;
    Ok(Living {
        id,
        caption: scene.caption().to_owned(),
        size,
        way: scene.way(),
        colours: scene.colours().map(Into::into),
        azimuth: scene.is_grown().then_some(azimuth),
        picture: scene.prepare(&life, storage, |percent| coded.store(percent, Ordering::Relaxed))?,
        drive: life.drive,
        seconds: scene.look().seconds,
        stale: false,
    })
}
