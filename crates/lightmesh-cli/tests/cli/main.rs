//! The program from the outside: what is typed, what comes back.

mod aov;
mod compare;
mod environment;
#[cfg(unix)]
mod interrupt;
mod place;
mod render;
