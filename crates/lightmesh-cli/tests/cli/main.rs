//! The program from the outside: what is typed, what comes back.

mod aov;
mod compare;
mod denoise;
mod docs;
mod environment;
mod exposure;
mod help;
mod hostile;
#[cfg(unix)]
mod interrupt;
mod mesh_file;
mod options;
mod output_files;
mod place;
#[cfg(unix)]
mod preview;
mod render;
mod reproduce;
mod threads;
mod time_limit;
