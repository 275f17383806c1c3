//! What people rely on, a theme a module.

mod output;
