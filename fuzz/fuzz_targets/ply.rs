#![no_main]

include!("program.rs");

program!(Ply);
