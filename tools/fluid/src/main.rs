//! The command line: see `yurameki-fluid --help`.

fn main() {}
