//! The database of videos: a catalogue, the frames, and what is known of every patch.
