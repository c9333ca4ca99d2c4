#![no_main]

include!("program.rs");

program!(SceneBytes);
