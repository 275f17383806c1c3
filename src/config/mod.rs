//! # Configuration
