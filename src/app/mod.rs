//! # The program's decisions
