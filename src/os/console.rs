//! The text console that a bare panel shares with pictures.
//!
//! While pictures are shown the kernel must not write text and a cursor over them (`KD_GRAPHICS`), and a person may still
//! switch to another console (`VT_PROCESS`): the picture steps aside, and is painted anew on return. Everything is put back as
//! it was found, at every end of the program that it lives to see, a panic included; after a kill `yurameki restore-console`
//! does it.
//!
//! A machine without consoles, or a user who may not touch them, goes without: the panel can be drawn to all the same.
//! Names are those of `ioctl_console(2)`.

use crate::display::{BackBuffer, Display, DisplayError, Mode};
use rustix::{
    io::Errno,
    ioctl::{Getter, IntegerSetter, Setter, ioctl},
};
use signal_hook::{SigId, flag, low_level};
use std::{
    fmt,
    fs::{File, OpenOptions},
    io,
    os::unix::fs::OpenOptionsExt,
    panic,
    path::PathBuf,
    sync::{
        Arc, Mutex, Once, PoisonError,
        atomic::{AtomicBool, Ordering},
    },
    thread::{self, ThreadId},
};

const KDSETMODE: u32 = 0x4b3a;
const KDGETMODE: u32 = 0x4b3b;
const VT_GETMODE: u32 = 0x5601;
const VT_SETMODE: u32 = 0x5602;
const VT_GETSTATE: u32 = 0x5603;
const VT_RELDISP: u32 = 0x5605;
const VT_ACTIVATE: u32 = 0x5606;

const KD_TEXT: i32 = 0;
const KD_GRAPHICS: i32 = 1;
/// The kernel switches consoles by itself.
const VT_AUTO: i8 = 0;
/// The kernel asks by a signal before it switches away, and tells by a signal when it has switched back.
const VT_PROCESS: i8 = 1;
/// The signals by which the kernel asks and tells: the first two of those without a meaning of their own. SIGUSR1 is for people.
fn switch_signals() -> [i32; 2] {
    [libc::SIGRTMIN(), libc::SIGRTMIN() + 1]
}

/// Arguments of `VT_RELDISP`: the console may be switched away; it has come back.
const RELEASED: usize = 1;
const ACQUIRED: usize = 2;

/// `struct vt_mode` of `<linux/vt.h>`.
#[derive(Clone, Copy)]
#[repr(C)]
struct VtMode {
    mode: i8,
    waitv: i8,
    relsig: i16,
    acqsig: i16,
    frsig: i16,
}

/// `struct vt_stat` of `<linux/vt.h>`.
#[repr(C)]
struct VtState {
    active: u16,
    signal: u16,
    state: u16,
}

/// A virtual console, `/dev/ttyN`.
struct Terminal {
    file: File,
    number: u16,
}

impl Terminal {
    /// The console that is seen at the moment.
    fn active() -> io::Result<Self> {
        let any = open("/dev/tty0".into())?;
        // SAFETY: VT_GETSTATE fills a `struct vt_stat`.
        let state = unsafe { ioctl(&any, Getter::<VT_GETSTATE, VtState>::new()) }?;
        Ok(Self { file: open(format!("/dev/tty{}", state.active).into())?, number: state.active })
    }

    fn kd_mode(&self) -> Result<i32, Errno> {
        // SAFETY: KDGETMODE fills an int.
        unsafe { ioctl(&self.file, Getter::<KDGETMODE, i32>::new()) }
    }

    fn set_kd_mode(&self, mode: i32) -> Result<(), Errno> {
        // SAFETY: KDSETMODE takes its argument by value and touches no memory.
        unsafe { ioctl(&self.file, IntegerSetter::<KDSETMODE>::new_usize(mode as usize)) }
    }

    fn vt_mode(&self) -> Result<VtMode, Errno> {
        // SAFETY: VT_GETMODE fills a `struct vt_mode`.
        unsafe { ioctl(&self.file, Getter::<VT_GETMODE, VtMode>::new()) }
    }

    fn set_vt_mode(&self, mode: VtMode) -> Result<(), Errno> {
        // SAFETY: VT_SETMODE reads a `struct vt_mode`.
        unsafe { ioctl(&self.file, Setter::<VT_SETMODE, VtMode>::new(mode)) }
    }

    /// Asks the kernel to switch to another console. It asks back by [`VT_PROCESS`] first.
    fn activate(&self, number: u8) -> Result<(), Errno> {
        // SAFETY: VT_ACTIVATE takes its argument by value and touches no memory.
        unsafe { ioctl(&self.file, IntegerSetter::<VT_ACTIVATE>::new_usize(number.into())) }
    }

    fn answer(&self, answer: usize) {
        // SAFETY: VT_RELDISP takes its argument by value and touches no memory.
        let answered = unsafe { ioctl(&self.file, IntegerSetter::<VT_RELDISP>::new_usize(answer)) };
        if let Err(error) = answered {
            log::debug!("tty{}: the switch was not answered: {error}", self.number);
        }
    }
}

/// For writing alone, which is all that the group `tty` may; the calls do not ask for more.
fn open(path: PathBuf) -> io::Result<File> {
    let file = OpenOptions::new().write(true).custom_flags(libc::O_NOCTTY).open(&path);
    file.map_err(|error| io::Error::new(error.kind(), format!("{}: {error}", path.display())))
}

/// The state of the console as a line for people.
pub(super) fn report() -> String {
    let describe = || -> io::Result<String> {
        let terminal = Terminal::active()?;
        let kd = match terminal.kd_mode()? {
            KD_TEXT => "text".into(),
            KD_GRAPHICS => "graphics".into(),
            other => format!("mode {other}"),
        };
        let switching = match terminal.vt_mode()?.mode {
            VT_AUTO => "by the kernel",
            _ => "after asking a program",
        };
        Ok(format!("tty{} is seen: {kd}, switched {switching}", terminal.number))
    };
    describe().unwrap_or_else(|error| format!("no console: {error}"))
}

/// Gives the console back to text, whatever a killed program has left it in.
pub(super) fn restore() -> io::Result<()> {
    let terminal = Terminal::active()?;
    let automatic = VtMode { mode: VT_AUTO, waitv: 0, relsig: 0, acqsig: 0, frsig: 0 };
    let restored = terminal.set_vt_mode(automatic).and_then(|()| terminal.set_kd_mode(KD_TEXT));
    restored.map_err(|error| io::Error::other(format!("/dev/tty{}: {error}", terminal.number)))
}

/// A console as it was found.
struct Found {
    terminal: Terminal,
    kd_mode: i32,
    vt_mode: VtMode,
    /// Who took it: the panic of another thread does not end the pictures.
    by: ThreadId,
}

impl Found {
    fn put_back(self) {
        let Self { terminal, kd_mode, vt_mode, .. } = self;
        if let Err(error) = terminal.set_vt_mode(vt_mode).and(terminal.set_kd_mode(kd_mode)) {
            log::warn!("the console tty{} is not restored: {error}", terminal.number);
        }
    }
}

/// The console that was taken, where a panic finds it too.
static TAKEN: Mutex<Option<Found>> = Mutex::new(None);

/// The console, taken for pictures. Given back on drop, and on a panic of the thread that took it.
struct Console {
    release: Arc<AtomicBool>,
    acquire: Arc<AtomicBool>,
    signals: [SigId; 2],
    /// Another console is seen.
    away: bool,
}

/// What has become of the console since it was looked at last.
enum Turn {
    Ours,
    /// Somebody wants to see another one; [`Console::let_go`] lets them.
    Asked,
    Away,
    Back,
}

impl Console {
    /// Takes the console that is seen at the moment.
    fn take() -> io::Result<Self> {
        let terminal = Terminal::active()?;
        let (kd_mode, vt_mode) = (terminal.kd_mode()?, terminal.vt_mode()?);
        let (release, acquire) = (Arc::new(AtomicBool::new(false)), Arc::new(AtomicBool::new(false)));
        let listen = |signal, flag: &Arc<AtomicBool>| flag::register(signal, Arc::clone(flag));
        let [ask, tell] = switch_signals();
        let signals = [listen(ask, &release)?, listen(tell, &acquire)?];
        let console = Self { release, acquire, signals, away: false };
        put_back_on_panic();
        let number = terminal.number;
        terminal.set_kd_mode(KD_GRAPHICS)?;
        let asked = VtMode { mode: VT_PROCESS, waitv: 0, relsig: ask as i16, acqsig: tell as i16, frsig: 0 };
        let switching = terminal.set_vt_mode(asked);
        *TAKEN.lock().unwrap_or_else(PoisonError::into_inner) =
            Some(Found { terminal, kd_mode, vt_mode, by: thread::current().id() });
        switching?;
        log::debug!("the console tty{number} shows pictures");
        Ok(console)
    }

    /// Looks whether somebody switches consoles.
    fn turn(&mut self) -> Turn {
        if self.acquire.swap(false, Ordering::Relaxed) {
            self.away = false;
            answer(ACQUIRED);
            return Turn::Back;
        }
        if self.release.swap(false, Ordering::Relaxed) {
            return Turn::Asked;
        }
        if self.away { Turn::Away } else { Turn::Ours }
    }

    fn let_go(&mut self) {
        self.away = true;
        answer(RELEASED);
    }
}

impl Drop for Console {
    fn drop(&mut self) {
        put_back();
        for signal in self.signals {
            low_level::unregister(signal);
        }
    }
}

fn answer(answer: usize) {
    if let Some(found) = &*TAKEN.lock().unwrap_or_else(PoisonError::into_inner) {
        found.terminal.answer(answer);
    }
}

fn put_back() {
    if let Some(found) = TAKEN.lock().unwrap_or_else(PoisonError::into_inner).take() {
        found.put_back();
    }
}

/// From now on a panic gives the console back before its message is written, so that it can be read there.
fn put_back_on_panic() {
    static HOOK: Once = Once::new();
    HOOK.call_once(|| {
        let then = panic::take_hook();
        panic::set_hook(Box::new(move |panic| {
            // A lock that is held belongs to this very thread, which is at it already.
            if let Ok(mut taken) = TAKEN.try_lock()
                && let Some(found) = taken.take_if(|found| found.by == thread::current().id())
            {
                found.put_back();
            }
            then(panic);
        }));
    });
}

/// A display that can step aside for another console.
pub(super) trait Shared: Display {
    /// Another console will be seen: whatever others need to show it is let go.
    fn pause(&mut self);
    /// The console has come back, with unknown pixels on the panel.
    fn resume(&mut self);
}

/// A display on the console, where there is one.
pub(super) struct OnConsole<D: Shared> {
    // Dropped in this order: text is seen again once the display has let go of the panel.
    display: D,
    console: Option<Console>,
}

impl<D: Shared> OnConsole<D> {
    /// Takes the console for `display`, if that can be.
    pub(super) fn new(display: D) -> Self {
        let console = Console::take();
        let console = console.inspect_err(|error| log::debug!("the console is not taken: {error}")).ok();
        Self { display, console }
    }

    /// Switches to the console of that number, as Alt and a function key do where the kernel sees them.
    pub(super) fn show_console(&self, number: u8) {
        if let Some(found) = &*TAKEN.lock().unwrap_or_else(PoisonError::into_inner)
            && let Err(error) = found.terminal.activate(number)
        {
            log::warn!("tty{number} cannot be switched to: {error}");
        }
    }

    /// Fails while another console is seen.
    fn look(&mut self) -> Result<(), DisplayError> {
        let Some(console) = &mut self.console else { return Ok(()) };
        match console.turn() {
            Turn::Ours => Ok(()),
            Turn::Asked => {
                log::info!("another console is seen; the picture waits");
                self.display.pause();
                console.let_go();
                Err(DisplayError::Lost)
            }
            Turn::Away => Err(DisplayError::Lost),
            Turn::Back => {
                log::info!("the picture's console is back");
                self.display.resume();
                Ok(())
            }
        }
    }
}

impl<D: Shared> Display for OnConsole<D> {
    fn mode(&self) -> Mode {
        self.display.mode()
    }

    fn back_buffer(&mut self) -> Result<BackBuffer<'_>, DisplayError> {
        self.look()?;
        self.display.back_buffer()
    }

    fn present(&mut self) -> Result<(), DisplayError> {
        // A switch that is asked for now waits for this frame; but nothing is shown while another console is seen.
        if self.console.as_ref().is_some_and(|console| console.away) {
            return Err(DisplayError::Lost);
        }
        self.display.present()
    }

    fn set_power(&mut self, on: bool) -> Result<bool, DisplayError> {
        self.look()?;
        self.display.set_power(on)
    }
}

impl<D: Shared> fmt::Debug for OnConsole<D> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("OnConsole").field("mode", &self.mode()).finish_non_exhaustive()
    }
}
