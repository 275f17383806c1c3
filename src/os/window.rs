//! A window on the PC, on X11 or Wayland.
//!
//! The program's own loop stays in charge: the window system's events are taken in passing, whenever a back buffer, a
//! present or a press is asked for, and nothing here waits for them.
//!
//! Keys: ← → ↑ ↓ ENTER SPACE I ESC are the frame's buttons. F or F11 enters and leaves full screen, where the pointer is
//! hidden. A window that loses the focus has its buttons released.

use super::panics::without_panic;
use crate::{
    display::{BackBuffer, Display, DisplayError, Mode},
    frame::{FrameMut, Layout, PixelFormat, Size},
    input::{
        Button, Buttons, Press,
        gesture::{Edge, Gestures},
        key_map::KeyMap,
    },
};
use std::{
    env, fmt,
    num::NonZeroU32,
    rc::Rc,
    time::{Duration, Instant},
};
use winit::{
    application::ApplicationHandler,
    dpi::PhysicalSize,
    event::{ElementState, KeyEvent, WindowEvent},
    event_loop::{ActiveEventLoop, EventLoop, OwnedDisplayHandle},
    keyboard::{Key, NamedKey},
    platform::{
        pump_events::{EventLoopExtPumpEvents as _, PumpStatus},
        x11::EventLoopBuilderExtX11 as _,
    },
    window::{Fullscreen, WindowId},
};

/// A window that shows frames, and the buttons of the keyboard while the window has the focus.
///
/// Its mode is the inside of the window in physical pixels, as XRGB8888. When a person resizes it, one call fails with
/// [`DisplayError::ModeChanged`], and the mode has the new size. Frames are painted in the program's own memory and copied to
/// the window system's on present, so that a back buffer is always 1 present old.
pub struct Window {
    // Dropped in this order: the surface before the connection that it draws through.
    shown: Shown,
    events: EventLoop<()>,
}

/// Whether there is a screen to open a window on: a window system has left its address in the environment. Whether it
/// answers shows only when a window is opened.
pub fn is_possible() -> bool {
    ["WAYLAND_DISPLAY", "WAYLAND_SOCKET", "DISPLAY"]
        .iter()
        .any(|name| env::var_os(name).is_some_and(|value| !value.is_empty()))
}

impl Window {
    /// Opens a window with `title`, the inside of `size` pixels, or three quarters of the screen. A program can open one
    /// window in its life.
    pub fn open(title: &str, size: Option<Size>) -> Result<Self, WindowError> {
        if !is_possible() {
            return Err(WindowError::NoScreen);
        }
        // winit panics where a library of the window system is not installed (`libxkbcommon-x11.so`) and where an X server
        // lacks an extension. For this program those are reasons to go on without a window.
        without_panic(|| Self::try_open(title, size)).unwrap_or_else(|cause| Err(WindowError::Refused(cause)))
    }

    fn try_open(title: &str, size: Option<Size>) -> Result<Self, WindowError> {
        let mut builder = EventLoop::builder();
        // For Wayland too: it matters to neither window system which thread asks.
        builder.with_any_thread(true);
        let mut events = builder.build().map_err(refused)?;
        let mut opening = Opening { title, size, outcome: None };
        // The first round of events asks for the window.
        let _ = events.pump_app_events(Some(Duration::ZERO), &mut opening);
        let window = opening.outcome.unwrap_or_else(|| Err(refused("it gives no answer")))?;
        let shown = Shown::new(Rc::new(window), events.owned_display_handle()).map_err(refused)?;
        Ok(Self { shown, events })
    }

    /// Takes the events there are, and sends what was drawn on its way.
    fn pump(&mut self) {
        if !self.shown.closed {
            let status = self.events.pump_app_events(Some(Duration::ZERO), &mut self.shown);
            self.shown.closed |= matches!(status, PumpStatus::Exit(_));
        }
    }
}

impl Display for Window {
    fn mode(&self) -> Mode {
        self.shown.mode
    }

    fn back_buffer(&mut self) -> Result<BackBuffer<'_>, DisplayError> {
        self.pump();
        self.shown.settle()?;
        let Shown { mode, ref mut pixels, age, .. } = self.shown;
        let frame =
            FrameMut::new(bytemuck::cast_slice_mut(pixels), mode.layout).map_err(|_| DisplayError::Lost)?;
        Ok(BackBuffer { frame, age })
    }

    fn present(&mut self) -> Result<(), DisplayError> {
        self.shown.settle()?;
        self.shown.age = 1;
        self.shown.draw().map_err(|error| {
            log::warn!("the window cannot be drawn: {error}");
            DisplayError::Lost
        })?;
        self.pump();
        Ok(())
    }
}

impl Buttons for Window {
    fn next_press(&mut self, _frame: u64) -> Option<Press> {
        self.shown.gestures.next_press().or_else(|| {
            self.pump();
            self.shown.gestures.advance(self.shown.start.elapsed());
            self.shown.gestures.next_press()
        })
    }

    fn set_keys(&mut self, keys: KeyMap) {
        self.shown.gestures.set_keys(keys);
    }
}

impl fmt::Debug for Window {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Window").field("mode", &self.shown.mode).finish_non_exhaustive()
    }
}

/// Asks for a window once the window system listens.
struct Opening<'a> {
    title: &'a str,
    size: Option<Size>,
    outcome: Option<Result<winit::window::Window, WindowError>>,
}

impl ApplicationHandler for Opening<'_> {
    fn resumed(&mut self, events: &ActiveEventLoop) {
        let size = match self.size {
            Some(Size { width, height }) => PhysicalSize::new(width, height),
            None => three_quarters_of_the_screen(events),
        };
        let attributes =
            winit::window::Window::default_attributes().with_title(self.title).with_inner_size(size);
        self.outcome = Some(events.create_window(attributes).map_err(refused));
    }

    fn window_event(&mut self, _: &ActiveEventLoop, _: WindowId, _: WindowEvent) {}
}

fn three_quarters_of_the_screen(events: &ActiveEventLoop) -> PhysicalSize<u32> {
    // Where no screen tells its size: 1280 × 720 in the end, which fits every PC screen of today.
    let unknown = PhysicalSize::new(1707, 960);
    let monitor = events.primary_monitor().or_else(|| events.available_monitors().next());
    let screen = monitor.map(|monitor| monitor.size()).filter(|size| size.width.min(size.height) > 0);
    let PhysicalSize { width, height } = screen.unwrap_or(unknown);
    PhysicalSize::new(width.div_ceil(4) * 3, height.div_ceil(4) * 3)
}

/// The window once it is there.
struct Shown {
    surface: softbuffer::Surface<OwnedDisplayHandle, Rc<winit::window::Window>>,
    mode: Mode,
    /// The inside of the window as the window system told it last; the mode follows when the program next asks.
    size: Size,
    /// The frame, rows without gaps, each pixel with the bytes of XRGB8888 in memory.
    pixels: Vec<u32>,
    age: u32,
    /// Whether the window system has lost what was drawn.
    exposed: bool,
    closed: bool,
    gestures: Gestures,
    /// From when the times of gestures count.
    start: Instant,
}

impl Shown {
    fn new(
        window: Rc<winit::window::Window>,
        display: OwnedDisplayHandle,
    ) -> Result<Self, softbuffer::SoftBufferError> {
        let context = softbuffer::Context::new(display)?;
        let size = frame_size(window.inner_size()).unwrap_or(Size::new(1, 1));
        let surface = softbuffer::Surface::new(&context, window)?;
        let mut shown = Self {
            surface,
            mode: Mode { layout: layout_of(size), refresh_millihertz: 0 },
            size,
            pixels: Vec::new(),
            age: 0,
            exposed: false,
            closed: false,
            // Keys come debounced. Their times are those of the pumping, when several may come at once.
            gestures: Gestures::new(KeyMap::default(), Duration::ZERO),
            start: Instant::now(),
        };
        shown.adopt(size)?;
        Ok(shown)
    }

    /// Takes on the window's size as its mode.
    fn adopt(&mut self, size: Size) -> Result<(), softbuffer::SoftBufferError> {
        let (width, height) = (at_least_one(size.width), at_least_one(size.height));
        self.surface.resize(width, height)?;
        let monitor = self.surface.window().current_monitor();
        let refresh_millihertz = monitor.and_then(|monitor| monitor.refresh_rate_millihertz()).unwrap_or(0);
        self.mode = Mode { layout: layout_of(size), refresh_millihertz };
        self.pixels.clear();
        self.pixels.resize(size.pixels(), 0);
        self.age = 0;
        Ok(())
    }

    /// Tells the program what has become of the window since it last asked.
    fn settle(&mut self) -> Result<(), DisplayError> {
        if self.closed {
            return Err(DisplayError::Closed);
        }
        if self.size == self.mode.layout.size {
            return Ok(());
        }
        self.adopt(self.size).map_err(|error| {
            log::warn!("the window cannot be drawn at {}: {error}", self.size);
            DisplayError::Lost
        })?;
        Err(DisplayError::ModeChanged)
    }

    /// Copies the frame to the window.
    fn draw(&mut self) -> Result<(), softbuffer::SoftBufferError> {
        let mut buffer = self.surface.buffer_mut()?;
        for (to, &from) in buffer.iter_mut().zip(&self.pixels) {
            // softbuffer wants numbers, with the upper 8 bits 0; the frame's X bytes are 255.
            *to = u32::from_le(from) & 0x00ff_ffff;
        }
        buffer.present()
    }

    fn key(&mut self, key: &Key, pressed: bool) {
        match key {
            Key::Named(NamedKey::F11) if pressed => self.toggle_full_screen(),
            Key::Character(letter) if pressed && letter.eq_ignore_ascii_case("f") => {
                self.toggle_full_screen()
            }
            key => {
                if let Some(button) = button_of(key) {
                    self.gestures.edge(Edge { button, pressed, at: self.start.elapsed() });
                }
            }
        }
    }

    fn toggle_full_screen(&self) {
        let window = self.surface.window();
        let enter = window.fullscreen().is_none();
        window.set_fullscreen(enter.then_some(Fullscreen::Borderless(None)));
        window.set_cursor_visible(!enter);
    }
}

impl ApplicationHandler for Shown {
    fn resumed(&mut self, _: &ActiveEventLoop) {}

    fn window_event(&mut self, _: &ActiveEventLoop, _: WindowId, event: WindowEvent) {
        match event {
            WindowEvent::CloseRequested | WindowEvent::Destroyed => self.closed = true,
            WindowEvent::Resized(size) => self.size = frame_size(size).unwrap_or(self.size),
            WindowEvent::RedrawRequested => self.exposed = true,
            WindowEvent::Focused(false) => self.gestures.release_all(self.start.elapsed()),
            // A synthetic press tells of a key that was down before the window had the focus.
            WindowEvent::KeyboardInput { event: KeyEvent { repeat: true, .. }, .. }
            | WindowEvent::KeyboardInput {
                event: KeyEvent { state: ElementState::Pressed, .. },
                is_synthetic: true,
                ..
            } => {}
            WindowEvent::KeyboardInput { event: KeyEvent { logical_key, state, .. }, .. } => {
                self.key(&logical_key, state.is_pressed());
            }
            _ => {}
        }
    }

    /// Draws the last frame again where the window system has lost it: a frame that stands still is not presented again.
    fn about_to_wait(&mut self, _: &ActiveEventLoop) {
        let lost = core::mem::take(&mut self.exposed);
        if lost && self.age > 0 && self.size == self.mode.layout.size {
            // A failure shows again at the next present, which tells it.
            let _ = self.draw();
        }
    }
}

/// The button that a key stands for.
fn button_of(key: &Key) -> Option<Button> {
    match key {
        Key::Named(NamedKey::ArrowLeft) => Some(Button::Left),
        Key::Named(NamedKey::ArrowRight) => Some(Button::Right),
        Key::Named(NamedKey::ArrowUp) => Some(Button::Up),
        Key::Named(NamedKey::ArrowDown) => Some(Button::Down),
        Key::Named(NamedKey::Enter) => Some(Button::Enter),
        Key::Named(NamedKey::Space) => Some(Button::Space),
        Key::Named(NamedKey::Escape) => Some(Button::Escape),
        Key::Character(letter) if letter.eq_ignore_ascii_case("i") => Some(Button::Info),
        _ => None,
    }
}

/// The frame for a window of that size, cut at the longest side of a frame; none while the window has no inside.
fn frame_size(size: PhysicalSize<u32>) -> Option<Size> {
    let size = Size::new(size.width.min(Layout::MAX_SIDE), size.height.min(Layout::MAX_SIDE));
    (size.pixels() > 0).then_some(size)
}

fn layout_of(size: Size) -> Layout {
    let format = PixelFormat::Xrgb8888;
    Layout { size, format, stride_bytes: size.width as usize * format.bytes_per_pixel() }
}

fn at_least_one(side: u32) -> NonZeroU32 {
    NonZeroU32::new(side).unwrap_or(NonZeroU32::MIN)
}

/// Why there is no window.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum WindowError {
    /// The environment names no window system.
    NoScreen,
    /// The window system cannot be reached, or gives no window; with what it says.
    Refused(String),
}

impl fmt::Display for WindowError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NoScreen => f.write_str(
                "there is no screen for a window: neither WAYLAND_DISPLAY nor DISPLAY is set; \
                 start the program within a desktop, or use --display sim:1280x720",
            ),
            Self::Refused(cause) => {
                f.write_str("no window could be opened on ")?;
                for name in ["WAYLAND_DISPLAY", "DISPLAY"] {
                    if let Some(value) = env::var_os(name).filter(|value| !value.is_empty()) {
                        return write!(
                            f,
                            "{name}={}: {cause}; check that this screen is there and yours to use, or unset {name}, \
                             or use --display sim:1280x720",
                            value.display()
                        );
                    }
                }
                write!(f, "this screen: {cause}")
            }
        }
    }
}

impl std::error::Error for WindowError {}

/// The failure as the window system tells it. winit puts the place in its own source before that
/// (`os error at src/linux/mod.rs:788: …`), which helps nobody here.
fn refused(error: impl fmt::Display) -> WindowError {
    let told = error.to_string();
    let after_the_place = told.split_once(".rs:").and_then(|(_, rest)| rest.split_once(": "));
    WindowError::Refused(after_the_place.map_or(told.as_str(), |(_, cause)| cause).to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn keys_stand_for_their_buttons_whatever_their_case() {
        let letter = |letter: &str| button_of(&Key::Character(letter.into()));
        assert_eq!([letter("i"), letter("I"), letter("k")], [Some(Button::Info), Some(Button::Info), None]);
        assert_eq!(button_of(&Key::Named(NamedKey::Escape)), Some(Button::Escape));
        assert_eq!(button_of(&Key::Named(NamedKey::Shift)), None);
    }

    #[test]
    fn a_refusal_tells_the_cause_without_a_place_in_foreign_source() {
        let cause = |told: &str| refused(told);
        assert_eq!(cause("os error at /a/b/mod.rs:788: No server"), WindowError::Refused("No server".into()));
        assert_eq!(cause("no memory: 3"), WindowError::Refused("no memory: 3".into()));
    }

    #[test]
    fn a_frame_follows_the_window_within_its_limits() {
        assert_eq!(frame_size(PhysicalSize::new(801, 3)), Some(Size::new(801, 3)));
        assert_eq!(frame_size(PhysicalSize::new(0, 3)), None);
        assert_eq!(frame_size(PhysicalSize::new(40_000, 3)), Some(Size::new(Layout::MAX_SIDE, 3)));
    }
}
