//! Viewers of a picture while it is rendered.

use crate::Image;

/// Receives the picture so far, again and again while it improves: a window, or a file that is rewritten. Give it to a
/// render with [`Progress::viewer`](crate::progress::Progress::viewer).
///
/// First come coarse previews: the picture in blocks of 8 × 8 pixels, then of 4 × 4 and, from 4 samples per pixel on,
/// of 2 × 2. They cost a sixteenth of the samples at most, and the finished picture does not depend on them. Then every
/// pixel that has samples is shown as their mean, and the others as in the preview. The last picture is the finished
/// one.
///
/// Both methods are called by the thread that renders, which waits for them: hand long work to another one.
pub trait Viewer {
    /// Whether the viewer wants a newer picture now. The renderer calls this after each wave of some 65000 rays, in
    /// most scenes every few tens of milliseconds. Making a picture takes some nanoseconds for each pixel.
    fn wants_picture(&self) -> bool {
        true
    }

    /// Receives the picture so far: linear, cd/m², always of the full size. The finished one always comes,
    /// unless the render is cancelled or fails.
    fn show(&self, picture: Image);
}
