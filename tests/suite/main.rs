//! What the library promises, seen from outside: one module a theme.

mod logbook;
mod noise;
mod spectrum;
