//! Photos are decoded and prepared on a thread of their own, at low priority, while the show goes on.

use super::{
    Failure,
    config::Config,
    scene::{self, Scene, Source, Way},
};
use crate::{
    app::{Picture, playlist::PhotoId},
    frame::Size,
    math::Turns,
    noise::drive,
};
use std::{
    path::PathBuf,
    sync::{
        Arc,
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
    pub(super) picture: Picture<Vec<u64>>,
    /// How it lives.
    pub(super) way: Way,
    /// From where a grown tree is seen; photos have one side.
    pub(super) azimuth: Option<Turns>,
    /// The noises and times of the photo's own look.
    pub(super) drive: drive::Settings,
    /// How long it is to be shown.
    pub(super) seconds: u32,
    /// It, or how it is to be shown, has changed since.
    pub(super) stale: bool,
}

/// A photo to be loaded.
struct Order {
    id: PhotoId,
    /// `None` is the demo photo.
    path: Option<PathBuf>,
    /// The photo whose colours a kaleidoscope takes.
    other: Option<PathBuf>,
    /// How it is to live, where a button has chosen that.
    way: Option<Way>,
    /// From where a tree is seen.
    azimuth: Turns,
    size: Size,
    storage: Vec<u64>,
    config: Arc<Config>,
}

/// What has become of an order.
pub(super) type Outcome = (PhotoId, Result<Living, Failure>);

/// The thread, and the one photo that it may be at.
pub(super) struct Loader {
    orders: Sender<Order>,
    outcomes: Receiver<Outcome>,
    /// What is being worked at.
    at: Option<PhotoId>,
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
        let (orders, inbox) = channel::<Order>();
        let (outbox, outcomes) = channel();
        let work = move || {
            // On Linux the priority is each thread's own. Without the right to lower it the picture only may stand for a moment.
            let _ = rustix::process::nice(NICE);
            for order in inbox {
                let id = order.id;
                if outbox.send((id, load(order))).is_err() {
                    break;
                }
            }
        };
        thread::Builder::new().name("loader".into()).spawn(work)?;
        Ok(Self { orders, outcomes, at: None, cancelled: false, spare: Vec::new() })
    }

    /// Whether an order is being worked at.
    pub(super) const fn is_busy(&self) -> bool {
        self.at.is_some()
    }

    /// Orders a photo for a panel of `size`, as `config` says; without a path, the demo photo. A kaleidoscope takes the colours of
    /// the `other` one; a tree is seen from the `azimuth`.
    #[expect(clippy::too_many_arguments, reason = "they are what an order is made of")]
    pub(super) fn order(
        &mut self,
        id: PhotoId,
        path: Option<PathBuf>,
        other: Option<PathBuf>,
        way: Option<Way>,
        azimuth: Turns,
        size: Size,
        config: &Arc<Config>,
    ) {
        let (storage, config) = (self.spare.pop().unwrap_or_default(), Arc::clone(config));
        let order = Order { id, path, other, way, azimuth, size, storage, config };
        self.at = self.orders.send(order).is_ok().then_some(id);
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

fn load(order: Order) -> Result<Living, Failure> {
    let Order { id, path, other, way, azimuth, size, storage, config } = order;
    let source = path.as_deref().map_or(Source::Demo, Source::File);
    let scene = Scene::load_as(source, other.as_deref(), way, size, &config)?;
    let mut life = scene::turned(scene.look().life.at(config.frames_per_second), config.rotation);
    life.autumn.azimuth = azimuth;
    Ok(Living {
        id,
        caption: scene.caption().to_owned(),
        size,
        way: scene.way(),
        azimuth: scene.is_grown().then_some(azimuth),
        picture: scene.prepare(&life, storage)?,
        drive: life.drive,
        seconds: scene.look().seconds,
        stale: false,
    })
}
