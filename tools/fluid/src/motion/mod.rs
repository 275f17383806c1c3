//! How patches move: optical flow, and its spectrum over time.
