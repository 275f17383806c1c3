//! Resampling of photos in linear light.
