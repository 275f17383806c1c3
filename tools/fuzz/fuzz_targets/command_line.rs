//! Any words are a command or a message; a display that a command may have can be made.
#![no_main]

use clap::Parser;
use libfuzzer_sys::fuzz_target;
use yurameki::{
    display::sim::{Buffering, Sim, memory_len},
    os::args::{Args, Command, DisplayChoice},
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
            if let Some(DisplayChoice::Sim(spec)) = run.display
                && spec.0.len_bytes() < 1 << 20
            {
                let memory = vec![0; memory_len(spec.0, Buffering::Double)];
                let rate = run.fps.unwrap_or(12) * 1000;
                Sim::new(memory, spec.0, Buffering::Double, rate).expect("a layout that was accepted");
            }
        }
        Some(Command::Render(render)) => {
            let _ = render.rate();
        }
        _ => {}
    }
});
