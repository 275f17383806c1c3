//! How patches look: descriptors on a grid, and the vocabulary that makes words of them.
