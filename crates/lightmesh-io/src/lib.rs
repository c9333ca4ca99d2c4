//! Scenes in, pictures out.
