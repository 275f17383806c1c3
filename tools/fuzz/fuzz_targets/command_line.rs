//! Any words are a command or a message; a command has a life at any rate, and its first frames can be driven.
#![no_main]

use clap::Parser;
use libfuzzer_sys::fuzz_target;
use yurameki::{
    display::sim::{Buffering, Sim, memory_len},
    noise::drive::Oscillator,
    os::args::{Args, Command, DisplayChoice, Look},
};

fuzz_target!(|text: &str| {
    let words = std::iter::once("yurameki").chain(text.split(['\n', '\0']));
    let args = match Args::try_parse_from(words) {
        Ok(args) => args,
        Err(error) => {
            assert!(!error.to_string().is_empty());
            return;
        }
    };
    match args.command {
        Some(Command::Run(run)) => {
            live(&run.look, run.fps);
            if let DisplayChoice::Sim(spec) = run.display
                && spec.0.len_bytes() < 1 << 20
            {
                let memory = vec![0; memory_len(spec.0, Buffering::Double)];
                Sim::new(memory, spec.0, Buffering::Double, run.fps * 1000).expect("a layout that was accepted");
            }
        }
        Some(Command::Render(render)) => {
            let _ = render.rate();
            live(&render.look, render.fps);
        }
        Some(Command::Noise(_) | Command::Mask(_)) | None => {}
    }
});

fn live(look: &Look, frames_per_second: u32) {
    let mut oscillator = Oscillator::new(look.life().at(frames_per_second).drive, look.seed);
    for _ in 0..3 {
        let drive = oscillator.step();
        assert!((0..=1 << 28).contains(&drive.amplitude.to_bits()));
        assert!((0..=2 << 28).contains(&drive.frequency.to_bits()));
    }
}
