//! The window on a real X server without a screen (Xvfb), seen and driven from outside as a person would.
//!
//! The window lives in a process of its own, this test program run again: it takes one turn of a loop for each line on its
//! standard input and tells on standard error what happened. So nothing here waits for time to pass.

use std::{
    collections::HashSet,
    env,
    io::{BufRead as _, BufReader, ErrorKind, Lines, Write as _, stdin},
    process::{Child, ChildStderr, ChildStdin, Command, Stdio},
};
use x11rb::{
    connection::Connection as _,
    protocol::{
        xproto::{
            AtomEnum, ClientMessageEvent, ConfigureWindowAux, ConnectionExt as _, CreateGCAux, EventMask,
            ImageFormat, InputFocus, KEY_PRESS_EVENT, KEY_RELEASE_EVENT, Rectangle,
        },
        xtest::ConnectionExt as _,
    },
    rust_connection::RustConnection,
};
use yurameki::{
    display::{BackBuffer, Display as _, DisplayError},
    frame::Size,
    input::Buttons as _,
    os::window::Window,
};

const TITLE: &str = "Yurameki under test";
const FIRST_SIZE: Size = Size::new(641, 360);
const RESIZED: Size = Size::new(333, 500);
/// Set in the process that holds the window.
const CHILD: &str = "YURAMEKI_TEST_WINDOW";
/// What is written to that process for a turn in which it presents nothing, as while the show is paused.
const LISTEN: &str = "listen";
/// Turns within which everything must have happened; a dozen are needed.
const PATIENCE: usize = 3_000;

#[test]
fn a_window_shows_frames_takes_keys_follows_its_size_and_closes() {
    if env::var_os(CHILD).is_some() {
        return hold_a_window();
    }
    let Some(server) = XServer::start() else { return };
    let mut program = Program::start(&server.name);
    let (desk, _) = RustConnection::connect(Some(&server.name)).expect("Xvfb answers");
    let desk = Desk { desk };

    program.until("mode 641×360");
    let window = program.until_some(|| desk.window());
    program.until_some(|| desk.shows(window, FIRST_SIZE).then_some(()));

    desk.focus(window);
    for (keysym, button) in KEYS {
        desk.press(keysym);
        program.until(&format!("press {button}"));
    }

    desk.resize(window, RESIZED);
    program.until("mode 333×500");
    program.until_some(|| desk.shows(window, RESIZED).then_some(()));

    desk.spill_ink(window, RESIZED);
    assert!(!desk.shows(window, RESIZED), "the ink is seen");
    program.only_listen = true;
    program.until_some(|| desk.shows(window, RESIZED).then_some(()));
    program.only_listen = false;

    desk.close(window);
    program.until("closed");
    assert!(program.child.wait().expect("it ends").success());
}

#[test]
fn a_screen_that_is_not_there_is_named_with_its_cure() {
    // The number stands for a port beyond 65535: no server has it.
    let mut program = Program::start(":59999");
    let told = program.until("refused");
    assert!(told.contains("DISPLAY=:59999") && told.contains("--display sim:"), "{told}");
    let mut program = Program::start("");
    let told = program.until("refused");
    assert!(told.contains("neither WAYLAND_DISPLAY nor DISPLAY is set"), "{told}");
}

/// The X keysyms of the frame's buttons.
const KEYS: [(u32, &str); 8] = [
    (0xff51, "left"),
    (0xff53, "right"),
    (0xff52, "up"),
    (0xff54, "down"),
    (0xff0d, "enter"),
    (0x20, "space"),
    (0x69, "i"),
    (0xff1b, "esc"),
];

/// The process that holds the window: a turn of a loop for each line that comes in.
fn hold_a_window() {
    let mut window = match Window::open(TITLE, Some(FIRST_SIZE)) {
        Ok(window) => window,
        Err(error) => return eprintln!("refused: {error}"),
    };
    eprintln!("mode {}", window.mode().layout.size);
    for (turn, wish) in (0..).zip(stdin().lines()) {
        while let Some(press) = window.next_press(turn) {
            eprintln!("press {press}");
        }
        if wish.expect("text") == LISTEN {
            eprintln!("turn");
            continue;
        }
        let outcome = window.back_buffer().map(paint).and_then(|()| window.present());
        match outcome {
            Ok(()) => {}
            Err(DisplayError::ModeChanged) => eprintln!("mode {}", window.mode().layout.size),
            Err(DisplayError::Closed) => return eprintln!("closed"),
            Err(DisplayError::Lost) => panic!("the window is lost"),
        }
        eprintln!("turn");
    }
}

/// Paints a picture whose colours tell their place, once: the next back buffer still holds it.
fn paint(mut back: BackBuffer<'_>) {
    let size = back.frame.layout().size;
    for y in (0..size.height).take_while(|_| back.age == 0) {
        for (x, pixel) in (0..).zip(back.frame.row(y).chunks_exact_mut(4)) {
            let [red, green, blue] = colour(x, y);
            pixel.copy_from_slice(&[blue, green, red, 255]);
        }
    }
}

fn colour(x: u32, y: u32) -> [u8; 3] {
    [x as u8, y as u8, (x / 256 * 16 + y / 256) as u8]
}

/// An X server without a screen, gone with this value.
struct XServer {
    child: Child,
    name: String,
}

impl XServer {
    fn start() -> Option<Self> {
        let arguments = ["-displayfd", "1", "-screen", "0", "1280x720x24", "-nolisten", "tcp", "-noreset"];
        let started =
            Command::new("Xvfb").args(arguments).stdout(Stdio::piped()).stderr(Stdio::null()).spawn();
        let mut child = match started {
            Err(error) if error.kind() == ErrorKind::NotFound => {
                eprintln!("skipped: Xvfb is not installed");
                return None;
            }
            started => started.expect("Xvfb starts"),
        };
        let mut number = String::new();
        let stdout = child.stdout.take().expect("piped");
        BufReader::new(stdout).read_line(&mut number).expect("Xvfb tells its display");
        Some(Self { child, name: format!(":{}", number.trim()) })
    }
}

impl Drop for XServer {
    fn drop(&mut self) {
        self.child.kill().and_then(|()| self.child.wait()).expect("Xvfb ends");
    }
}

/// The program with the window, seen from outside.
struct Program {
    child: Child,
    turns: ChildStdin,
    told: Lines<BufReader<ChildStderr>>,
    /// Whether its turns are such that present nothing.
    only_listen: bool,
}

impl Program {
    fn start(display: &str) -> Self {
        let test = "window::a_window_shows_frames_takes_keys_follows_its_size_and_closes";
        let mut child = Command::new(env::current_exe().expect("this program"))
            .args(["--exact", test, "--nocapture"])
            .env(CHILD, "1")
            .env("DISPLAY", display)
            .env_remove("WAYLAND_DISPLAY")
            .env_remove("WAYLAND_SOCKET")
            .stdin(Stdio::piped())
            .stdout(Stdio::null())
            .stderr(Stdio::piped())
            .spawn()
            .expect("this program starts again");
        let turns = child.stdin.take().expect("piped");
        let told = BufReader::new(child.stderr.take().expect("piped")).lines();
        Self { child, turns, told, only_listen: false }
    }

    /// Lets it take turns until it tells a line that begins with `wanted`.
    fn until(&mut self, wanted: &str) -> String {
        for _ in 0..PATIENCE {
            // A program that has ended takes no more turns, and has told why.
            let _ = writeln!(self.turns, "{}", if self.only_listen { LISTEN } else { "" });
            loop {
                let line = self.told.next().unwrap_or_else(|| panic!("it ended before \"{wanted}\""));
                let line = line.expect("text");
                if line.starts_with(wanted) {
                    // To the end of the turn: one that still goes on could paint over what is done to the window next.
                    let _ = line == "turn"
                        || self.told.by_ref().any(|told| told.is_ok_and(|told| told == "turn"));
                    return line;
                }
                if line == "turn" {
                    break;
                }
            }
        }
        panic!("no \"{wanted}\" in {PATIENCE} turns");
    }

    /// Lets it take turns until `look` sees something.
    fn until_some<T>(&mut self, mut look: impl FnMut() -> Option<T>) -> T {
        (0..PATIENCE)
            .find_map(|_| {
                self.until("turn");
                look()
            })
            .unwrap_or_else(|| panic!("not seen in {PATIENCE} turns"))
    }
}

/// What a person at the X server sees and does.
struct Desk {
    desk: RustConnection,
}

impl Desk {
    fn root(&self) -> u32 {
        self.desk.setup().roots[0].root
    }

    fn windows(&self) -> Vec<u32> {
        let tree = self.desk.query_tree(self.root()).expect("asked").reply().expect("answered");
        tree.children
    }

    fn window(&self) -> Option<u32> {
        self.windows().into_iter().find(|&window| {
            let title = self.desk.get_property(false, window, AtomEnum::WM_NAME, AtomEnum::ANY, 0, 64);
            title.expect("asked").reply().is_ok_and(|title| title.value == TITLE.as_bytes())
        })
    }

    /// The pixels of `size` in the window, bytes B, G, R, X; none while they cannot be seen.
    fn pixels(&self, window: u32, size: Size) -> Option<Vec<u8>> {
        let (width, height) = (size.width as u16, size.height as u16);
        let image = self.desk.get_image(ImageFormat::Z_PIXMAP, window, 0, 0, width, height, !0);
        Some(image.expect("asked").reply().ok()?.data)
    }

    /// Whether the window shows the picture in that size, to the pixel.
    fn shows(&self, window: u32, size: Size) -> bool {
        let places = (0..size.height).flat_map(|y| (0..size.width).map(move |x| (x, y)));
        self.pixels(window, size).is_some_and(|pixels| {
            places.zip(pixels.chunks_exact(4)).all(|((x, y), pixel)| {
                let [red, green, blue] = colour(x, y);
                pixel[..3] == [blue, green, red]
            })
        })
    }

    fn focus(&self, window: u32) {
        let focus = self.desk.set_input_focus(InputFocus::PARENT, window, x11rb::CURRENT_TIME);
        focus.expect("asked").check().expect("given");
    }

    fn press(&self, keysym: u32) {
        let (least, most) = (self.desk.setup().min_keycode, self.desk.setup().max_keycode);
        let map = self.desk.get_keyboard_mapping(least, most - least + 1).expect("asked");
        let map = map.reply().expect("answered");
        let mut keys = map.keysyms.chunks_exact(usize::from(map.keysyms_per_keycode));
        let key = keys.position(|keysyms| keysyms.contains(&keysym)).expect("the keyboard has the key");
        for event in [KEY_PRESS_EVENT, KEY_RELEASE_EVENT] {
            let fake = self.desk.xtest_fake_input(event, least + key as u8, 0, self.root(), 0, 0, 0);
            fake.expect("asked").check().expect("pressed");
        }
    }

    fn resize(&self, window: u32, size: Size) {
        let change = ConfigureWindowAux::new().width(size.width).height(size.height);
        self.desk.configure_window(window, &change).expect("asked").check().expect("resized");
    }

    /// Paints the window over, and has the server tell it that its picture is lost.
    fn spill_ink(&self, window: u32, size: Size) {
        let (width, height) = (size.width as u16, size.height as u16);
        let ink = self.desk.generate_id().expect("a free number");
        self.desk.create_gc(ink, window, &CreateGCAux::new()).expect("asked").check().expect("created");
        let spot = Rectangle { x: 0, y: 0, width, height };
        self.desk.poly_fill_rectangle(window, ink, &[spot]).expect("asked").check().expect("painted");
        self.desk.clear_area(true, window, 0, 0, width, height).expect("asked").check().expect("told");
    }

    /// Asks the window to close, as the button in its title bar does.
    fn close(&self, window: u32) {
        let atom = |name: &str| {
            let atom = self.desk.intern_atom(false, name.as_bytes()).expect("asked");
            atom.reply().expect("answered").atom
        };
        let delete = [atom("WM_DELETE_WINDOW"), x11rb::CURRENT_TIME, 0, 0, 0];
        let message = ClientMessageEvent::new(32, window, atom("WM_PROTOCOLS"), delete);
        let sent = self.desk.send_event(false, window, EventMask::NO_EVENT, message);
        sent.expect("asked").check().expect("sent");
    }
}

#[test]
fn the_program_shows_its_demo_in_a_window() {
    let Some(server) = XServer::start() else { return };
    let (desk, _) = RustConnection::connect(Some(&server.name)).expect("Xvfb answers");
    let desk = Desk { desk };
    let mut program = Command::new(env!("CARGO_BIN_EXE_yurameki"))
        .args(["run", "--display", "window", "--frames", "60", "--fps", "60"])
        .env("DISPLAY", &server.name)
        .env_remove("WAYLAND_DISPLAY")
        .env_remove("WAYLAND_SOCKET")
        .spawn()
        .expect("the program starts");
    let mut most_colours = 0;
    let status = loop {
        if let Some(status) = program.try_wait().expect("a child of this one") {
            break status;
        }
        // The screen is 1280 × 720, and the window takes three quarters of it.
        for window in desk.windows() {
            if let Some(pixels) = desk.pixels(window, Size::new(960, 540)) {
                let colours: HashSet<&[u8]> = pixels.chunks_exact(4).collect();
                most_colours = most_colours.max(colours.len());
            }
        }
    };
    assert!(status.success(), "{status}");
    assert!(most_colours > 1000, "a photo has thousands of colours; seen: {most_colours}");
}
