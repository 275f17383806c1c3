//! Photos are decoded and prepared on a thread of their own, at low priority, while the show goes on.

use super::{
    Failure,
    config::Config,
    scene::{self, Scene, Source, Way},
};
use crate::{
    app::{Picture, playlist::PhotoId},
    frame::Size,
    noise::drive,
};
use std::{
    path::PathBuf,
    sync::{
        Arc,
        mpsc::{Receiver, Sender, TryRecvError, channel},
    },
    thread,
};

/// A photo that was prepared for a panel of its size.
pub(super) struct Living {
    pub(super) id: PhotoId,
    pub(super) name: String,
    pub(super) size: Size,
    pub(super) picture: Picture<Vec<u64>>,
    /// How it lives.
    pub(super) way: Way,
    /// The noises and times of the photo's own look.
    pub(super) drive: drive::Settings,
    /// How long it is to be shown.
    pub(super) seconds: u32,
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
    size: Size,
    storage: Vec<u64>,
}

/// What has become of an order.
pub(super) type Outcome = (PhotoId, Result<Living, Failure>);

/// The thread, and the one photo that it may be at.
pub(super) struct Loader {
    orders: Sender<Order>,
    outcomes: Receiver<Outcome>,
    busy: bool,
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
    pub(super) fn start(config: Arc<Config>) -> Result<Self, Failure> {
        let (orders, inbox) = channel::<Order>();
        let (outbox, outcomes) = channel();
        let work = move || {
            // On Linux the priority is each thread's own. Without the right to lower it the picture only may stand for a moment.
            let _ = rustix::process::nice(NICE);
            for order in inbox {
                let id = order.id;
                if outbox.send((id, load(order, &config))).is_err() {
                    break;
                }
            }
        };
        thread::Builder::new().name("loader".into()).spawn(work)?;
        Ok(Self { orders, outcomes, busy: false, spare: Vec::new() })
    }

    /// Whether an order is being worked at.
    pub(super) const fn is_busy(&self) -> bool {
        self.busy
    }

    /// Orders a photo for a panel of `size`; without a path, the demo photo. A kaleidoscope takes the colours of the `other` one.
    pub(super) fn order(
        &mut self,
        id: PhotoId,
        path: Option<PathBuf>,
        other: Option<PathBuf>,
        way: Option<Way>,
        size: Size,
    ) {
        let storage = self.spare.pop().unwrap_or_default();
        self.busy = self.orders.send(Order { id, path, other, way, size, storage }).is_ok();
    }

    /// The photo that was ordered, once it is there; does not wait.
    pub(super) fn take(&mut self) -> Option<Outcome> {
        match self.outcomes.try_recv() {
            Ok(outcome) => {
                self.busy = false;
                Some(outcome)
            }
            Err(TryRecvError::Empty | TryRecvError::Disconnected) => None,
        }
    }

    /// Takes the memory of a photo that is no longer shown.
    pub(super) fn recycle(&mut self, living: Living) {
        // One is loaded while one is shown: more is never needed.
        if self.spare.is_empty() {
            self.spare.push(living.picture.into_storage());
        }
    }
}

fn load(order: Order, config: &Config) -> Result<Living, Failure> {
    let Order { id, path, other, way, size, storage } = order;
    let source = path.as_deref().map_or(Source::Demo, Source::File);
    let scene = Scene::load_as(source, other.as_deref(), way, size, config)?;
    let life = scene::turned(scene.look().life.at(config.frames_per_second), config.rotation);
    Ok(Living {
        id,
        name: scene.name().to_owned(),
        size,
        way: scene.way(),
        picture: scene.prepare(&life, storage)?,
        drive: life.drive,
        seconds: scene.look().seconds,
    })
}
