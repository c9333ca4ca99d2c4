//! Hostile input for the readers of lightmesh: where it begins ([`Target::seeds`]), how it is damaged
//! ([`Target::mutate`]) and what must hold whatever it is ([`Target::run`]).
//!
//! The programs in the repository's `fuzz/` are for cargo fuzz, which finds its way by coverage and needs a nightly
//! compiler; the program `try_targets` ([`trial`]) tries such inputs on a stable one, and is part of `.ci/run`.

#![deny(unsafe_code)]

mod exercise;
mod memory;
mod mutate;
mod seeds;
mod target;
mod targets;
pub mod trial;

pub use exercise::Depth;
pub use memory::take_thread_pool;
pub use seeds::Seed;
pub use target::Target;
