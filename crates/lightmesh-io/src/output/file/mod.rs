//! Files that appear whole or not at all, and never in the place of something that is still needed.
//!
//! The content of a file NAME grows in `.NAME.lightmesh.partial` beside it, which is locked as long as its writer lives
//! and then gets the file's name. So a second writer of the same file finds out that it is not alone, and what a
//! writer that was killed left behind is told from what is still written: nobody holds its lock.
//!
//! | the name is that of | what happens |
//! |---|---|
//! | a file, or of nothing | it is replaced as a whole; its permissions stay |
//! | a symbolic link | the file that it leads to is replaced or made; the link stays |
//! | a pipe, a device, a socket | the finished content is written to it |
//! | `/dev/stdout`, `/dev/fd/N` | the finished content is written to what is open there |
//! | a folder | it is refused |

mod batch;
mod claim;
mod destination;
mod fault;
mod identity;
mod partial;
mod staged;
mod stream;

#[cfg(test)]
mod tests;

#[cfg(test)]
pub(crate) use self::fault::{Step, during};
pub use self::{batch::Batch, claim::claim, identity::is_same_file, staged::StagedFile};
