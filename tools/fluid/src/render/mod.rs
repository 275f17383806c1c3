//! The animation: the patches' changes over the picture, written as a clip.
