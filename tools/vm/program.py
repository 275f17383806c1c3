"""The program under test: a static binary, and what its own `render` says the panel must show."""
import functools
import os
import shutil
import subprocess
import tempfile

from picture import Picture

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
WORK = os.path.join(ROOT, "target", "vm")
TARGETS = {"amd64": "x86_64-unknown-linux-musl", "arm64": "aarch64-unknown-linux-musl"}
PHOTO, OTHER_PHOTO = (os.path.join(ROOT, "tests", "data", name) for name in ("demo.jpg", "drawn.jpg"))


class Missing(Exception):
    """What the tests need and is not here, with its cure."""


def _has(target):
    found = subprocess.run(["rustc", "--print", "target-libdir", "--target", target], cwd=ROOT, capture_output=True, text=True)
    return found.returncode == 0 and os.path.isdir(found.stdout.strip())


@functools.lru_cache(maxsize=None)
def build(architecture):
    """Builds it with musl, which has no shared library to miss in the guest; without the slow link-time optimisation, and with the
    names of its functions. Gives the binary."""
    target = TARGETS[architecture]
    if not shutil.which("cargo"):
        raise Missing("cargo is missing; install Rust")
    if not _has(target):
        if shutil.which("rustup"):
            subprocess.run(["rustup", "target", "add", target], cwd=ROOT)
        if not _has(target):
            raise Missing("the Rust target %s is missing and rustup could not add it; `rustup target add %s`" % (target, target))
    settings = {"CARGO_TARGET_DIR": os.path.join(WORK, "build"), "CARGO_PROFILE_RELEASE_LTO": "off",
                "CARGO_PROFILE_RELEASE_CODEGEN_UNITS": "16", "CARGO_PROFILE_RELEASE_STRIP": "none",
                "CARGO_TARGET_AARCH64_UNKNOWN_LINUX_MUSL_LINKER": "rust-lld",
                "BINDGEN_EXTRA_CLANG_ARGS_aarch64_unknown_linux_musl": "-isystem " + _generic_headers()}
    command = ["cargo", "build", "--locked", "--quiet", "--release", "--target", target, "--no-default-features",
               "--features", "kms,linuxfb", "--bin", "yurameki"]
    if subprocess.run(command, cwd=ROOT, env={**os.environ, **settings}).returncode:
        raise RuntimeError("the static program does not build (linuxfb needs libclang: `apt-get install libclang-dev`)")
    return os.path.join(WORK, "build", target, "release", "yurameki")


def _generic_headers():
    """A folder with the kernel's asm/*.h for arm64, whose types are the generic ones: a PC has only its own."""
    folder = os.path.join(WORK, "include")
    os.makedirs(folder, exist_ok=True)
    if not os.path.lexists(os.path.join(folder, "asm")):
        os.symlink("/usr/include/asm-generic", os.path.join(folder, "asm"))
    return folder


@functools.lru_cache(maxsize=None)
def rendered(photo, size, pixel_format, frame):
    """Frame `frame`, from 0, of `yurameki render` on a panel of that size and pixel format."""
    with tempfile.TemporaryDirectory() as folder:
        frames = os.path.join(folder, "frames")
        subprocess.run([build("amd64"), "render", photo, "--out", frames, "--size", "%dx%d" % size, "--frames", str(frame + 1),
                        "--format", pixel_format, "--mask", "none", "--quiet"], check=True)
        names = sorted(os.listdir(frames))
        assert len(names) == frame + 1, names
        return Picture.from_png(os.path.join(frames, names[-1]))
