//! `--preview`: the picture so far, in a file that is rewritten while the render improves.

use std::{
    path::PathBuf,
    sync::{
        Mutex, PoisonError,
        mpsc::{self, SyncSender},
    },
    thread,
    time::{Duration, Instant},
};

use lightmesh::{Image, Progress, Stage, Viewer};
use lightmesh_io::output::{Metadata, StagedFile, write_png};

use crate::{
    args::Exposure,
    exit::Failure,
    interrupt,
    outputs::{self, fill},
    progress::Bar,
};

/// The least time from the end of writing one preview to the next one.
const PERIOD: Duration = Duration::from_secs(1);

/// The least pause, as a multiple of the time that writing took, so that one core spends a tenth of its time on
/// previews at most. Writing takes some 0.1 s per million pixels.
const PAUSE: u32 = 9;

/// The file, and how pictures are shown in it: as in any PNG that `render` writes.
#[derive(Debug)]
pub(crate) struct Preview<'a> {
    pub(crate) path: PathBuf,
    /// Empty, and ours: for the next picture. `None` after a failure.
    pub(crate) next: Mutex<Option<StagedFile>>,
    pub(crate) exposure: Exposure,
    pub(crate) metadata: &'a Metadata,
}

impl Preview<'_> {
    /// Runs `work` with a progress that shows on `bar`, while another thread writes the pictures so far. When this
    /// returns, the last of them is written. The first failure to write one goes to `warn`.
    pub(crate) fn follow<T>(&self, bar: &Bar, warn: impl Fn(&str) + Send, work: impl FnOnce(&dyn Progress) -> T) -> T {
        let due = Mutex::new(Due::Now);
        let (pictures, received) = mpsc::sync_channel(1);
        thread::scope(|scope| {
            let due = &due;
            let write_all = move || {
                // A pool of its own: that of the render is busy.
                let pool = rayon::ThreadPoolBuilder::new().num_threads(1).use_current_thread().build();
                let write = |picture: &Image| match &pool {
                    Ok(pool) => pool.install(|| self.write(picture)),
                    Err(_) => self.write(picture),
                };
                let mut failed = false;
                for picture in received {
                    let started = Instant::now();
                    // What is interrupted ends: the file stays as it is.
                    if !interrupt::pressed()
                        && let Err(failure) = write(&picture)
                        && !std::mem::replace(&mut failed, true)
                    {
                        bar.set_aside(|| warn(&format!("the preview is not up to date: {}", failure.message())));
                    }
                    let pause = PERIOD.max(started.elapsed() * PAUSE);
                    *due.lock().unwrap_or_else(PoisonError::into_inner) = Due::At(Instant::now() + pause);
                }
            };
            // Without a thread for it there is no preview.
            match thread::Builder::new().spawn_scoped(scope, write_all) {
                Ok(_) => work(&Writer { bar, due, pictures }),
                Err(_) => work(bar),
            }
        })
    }

    /// Writes the file: whole, or it stays as it was.
    fn write(&self, picture: &Image) -> Result<(), Failure> {
        let ev = self.exposure.for_picture(picture);
        let mut next = self.next.lock().unwrap_or_else(PoisonError::into_inner);
        let file = match next.take() {
            Some(file) => file,
            None => StagedFile::create(&self.path).map_err(Failure::work)?,
        };
        let file = fill(file, |file| write_png(file, picture, ev, self.metadata))?;
        outputs::commit([file])?;
        // Stay the only one who writes it.
        *next = StagedFile::create(&self.path).ok();
        next.iter().for_each(outputs::remove_at_end);
        Ok(())
    }
}

/// When the next picture is wanted.
#[derive(Debug)]
enum Due {
    Now,
    /// Not before this.
    At(Instant),
    /// Not while this one is written.
    WhenWritten,
}

/// Hands pictures to the thread that writes them, and everything else to the bar.
struct Writer<'a> {
    bar: &'a Bar,
    due: &'a Mutex<Due>,
    pictures: SyncSender<Image>,
}

impl Progress for Writer<'_> {
    fn report(&self, stage: Stage, done: u64, total: u64, rays: u64) {
        self.bar.report(stage, done, total, rays);
    }

    fn cancelled(&self) -> bool {
        self.bar.cancelled()
    }

    fn viewer(&self) -> Option<&dyn Viewer> {
        Some(self)
    }
}

impl Viewer for Writer<'_> {
    fn wants_picture(&self) -> bool {
        match *self.due.lock().unwrap_or_else(PoisonError::into_inner) {
            Due::Now => true,
            Due::At(time) => Instant::now() >= time,
            Due::WhenWritten => false,
        }
    }

    fn show(&self, picture: Image) {
        *self.due.lock().unwrap_or_else(PoisonError::into_inner) = Due::WhenWritten;
        // The thread is there as long as this is.
        let _ = self.pictures.send(picture);
    }
}
