//! What is left of the memory limit for the two fields of a light mesh, beside the scene and the picture.

use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use super::scene::Scene;
use crate::{Error, Method, RenderOptions};

/// Returns what rays and their hits take beside what every render takes, some 40 MiB: those that go on from surfaces, and
/// buffers of threads. Measured with two rooms and 2 and 64 threads, rounded up.
fn bytes_of_rays(options: &RenderOptions) -> u64 {
    let rays = match options.method {
        Method::Unbiased { .. } => 80 << 20,
        Method::Hybrid => 24 << 20,
        _ => 0,
    };
    rays + (rayon::current_num_threads() as u64).saturating_sub(THREADS) * BYTES_PER_THREAD
}

/// What a thread takes, bytes, and how many do not count. Empirical.
const BYTES_PER_THREAD: u64 = 1 << 19;
const THREADS: u64 = 8;

/// The share of one field: it may hold what the limit leaves beside the scene, the picture and the other field.
#[derive(Clone, Debug)]
pub(crate) struct FieldMemory {
    account: Arc<Account>,
    /// Which of the two fields.
    own: usize,
}

#[derive(Debug)]
struct Account {
    limit_bytes: u64,
    /// What the scene, the picture and its rays take.
    scene_bytes: u64,
    /// By field: what it holds, and more while it is filled.
    held: [AtomicU64; 2],
}

impl FieldMemory {
    /// The shares of the two fields of a mesh, which hold nothing yet; beside a picture of the options' size, if there is
    /// one.
    pub(crate) fn pair(scene: &Scene, options: &RenderOptions, has_picture: bool) -> [Self; 2] {
        let picture = if has_picture { options.picture_bytes(scene.has_unlit()) } else { 0 };
        let account = Account {
            limit_bytes: options.limits.max_memory,
            scene_bytes: scene.bytes().saturating_add(picture).saturating_add(bytes_of_rays(options)),
            held: Default::default(),
        };
        let account = Arc::new(account);
        [0, 1].map(|own| Self { account: Arc::clone(&account), own })
    }

    /// A share beside what all hold now, of a field that is made from this one.
    pub(crate) fn detached(&self) -> Self {
        let Account { limit_bytes, scene_bytes, held } = &*self.account;
        let held: u64 = held.iter().map(|bytes| bytes.load(Ordering::Relaxed)).sum();
        let account = Account { limit_bytes: *limit_bytes, scene_bytes: scene_bytes + held, held: Default::default() };
        Self { account: Arc::new(account), own: self.own }
    }

    /// What the field may hold, bytes.
    pub(crate) fn left(&self) -> u64 {
        let Account { limit_bytes, scene_bytes, .. } = *self.account;
        limit_bytes.saturating_sub(scene_bytes).saturating_sub(self.of_other())
    }

    fn of_other(&self) -> u64 {
        self.account.held[1 - self.own].load(Ordering::Relaxed)
    }

    /// Notes what the field holds.
    pub(crate) fn hold(&self, bytes: u64) {
        self.account.held[self.own].store(bytes, Ordering::Relaxed);
    }

    /// Notes what the field is about to hold, if that fits; `advice`: which setting to change where it does not.
    ///
    /// # Errors
    /// [`Error::OutOfMemory`].
    pub(crate) fn reserve(&self, bytes: u64, advice: &'static str) -> Result<(), Error> {
        if bytes <= self.left() {
            self.hold(bytes);
            return Ok(());
        }
        Err(Error::OutOfMemory {
            what: "the scene, the picture and the light mesh",
            needed_bytes: self.account.scene_bytes.saturating_add(self.of_other()).saturating_add(bytes),
            limit_bytes: self.account.limit_bytes,
            advice,
        })
    }
}
