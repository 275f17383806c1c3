//! Reading videos and folders of frames, and whether they suit.
