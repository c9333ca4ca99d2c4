//! How much memory a reader takes.

use std::alloc::{GlobalAlloc, Layout, System};
use std::sync::atomic::{AtomicUsize, Ordering::Relaxed};

/// The system's allocator with a count of living bytes and their peak.
struct Counting;

static LIVING: AtomicUsize = AtomicUsize::new(0);
static PEAK: AtomicUsize = AtomicUsize::new(0);

fn grown(bytes: usize) {
    let living = LIVING.fetch_add(bytes, Relaxed) + bytes;
    if living > PEAK.load(Relaxed) {
        PEAK.store(living, Relaxed);
    }
}

// SAFETY: every call goes to `System` unchanged; only counters are touched besides.
#[allow(unsafe_code)]
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        grown(layout.size());
        // SAFETY: the caller's promise is System's.
        unsafe { System.alloc(layout) }
    }

    unsafe fn alloc_zeroed(&self, layout: Layout) -> *mut u8 {
        grown(layout.size());
        // SAFETY: the caller's promise is System's.
        unsafe { System.alloc_zeroed(layout) }
    }

    unsafe fn realloc(&self, pointer: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        // Both blocks may be there while one is copied to the other.
        grown(size);
        LIVING.fetch_sub(layout.size(), Relaxed);
        // SAFETY: the caller's promise is System's.
        unsafe { System.realloc(pointer, layout, size) }
    }

    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        LIVING.fetch_sub(layout.size(), Relaxed);
        // SAFETY: the caller's promise is System's.
        unsafe { System.dealloc(pointer, layout) }
    }
}

#[global_allocator]
static ALLOCATOR: Counting = Counting;

/// What a reader may take besides its limit: the state of the decoders of pictures. Empirical.
const DECODERS: usize = 2 << 20;

/// Does some work, which may take `limit` bytes and what decoders need.
///
/// # Panics
/// If it takes more.
pub(crate) fn within<T>(limit: u64, work: impl FnOnce() -> T) -> T {
    let before = LIVING.load(Relaxed);
    PEAK.store(before, Relaxed);
    let result = work();
    let took = PEAK.load(Relaxed).saturating_sub(before);
    assert!(took <= limit as usize + DECODERS, "the reader took {took} bytes, its limit is {limit}");
    result
}

/// Makes this thread the only one that works: inputs are small, and what one thread takes of memory can be counted.
pub fn take_thread_pool() {
    // A second call changes nothing.
    let _ = rayon::ThreadPoolBuilder::new().num_threads(1).use_current_thread().build_global();
}
