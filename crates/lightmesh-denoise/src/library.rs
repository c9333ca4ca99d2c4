//! The C interface of Open Image Denoise 2 (`oidn.h`): the only place with unsafe code.

#![allow(unsafe_code)]

use std::ffi::{CStr, OsStr, c_char, c_int, c_void};
use std::mem::ManuallyDrop;
use std::panic::{self, AssertUnwindSafe};
use std::ptr;

use lightmesh::Progress;

use crate::{Effort, Error, Resources};

/// `OIDNDevice`, `OIDNFilter`.
type Handle = *mut c_void;

/// `OIDN_DEVICE_TYPE_CPU`.
const CPU: c_int = 1;
/// `OIDN_FORMAT_FLOAT3`.
const FLOAT3: c_int = 3;

/// `OIDN_QUALITY_FAST`.
const QUALITY_FAST: c_int = 4;
/// `OIDN_ERROR_NONE`.
const NO_ERROR: c_int = 0;

/// `OIDN_ERROR_CANCELLED`.
const CANCELLED: c_int = 6;

/// `OIDNProgressMonitorFunction`: gets what was given with it and the part that is done; false ends the work.
type Monitor = unsafe extern "C" fn(*mut c_void, f64) -> bool;

/// The loaded library.
#[derive(Debug)]
pub(crate) struct Library {
    new_device: unsafe extern "C" fn(c_int) -> Handle,
    set_device_bool: unsafe extern "C" fn(Handle, *const c_char, bool),
    set_device_int: unsafe extern "C" fn(Handle, *const c_char, c_int),
    get_device_int: unsafe extern "C" fn(Handle, *const c_char) -> c_int,
    get_device_error: unsafe extern "C" fn(Handle, *mut *const c_char) -> c_int,
    commit_device: unsafe extern "C" fn(Handle),
    release_device: unsafe extern "C" fn(Handle),
    new_filter: unsafe extern "C" fn(Handle, *const c_char) -> Handle,
    set_shared_filter_image:
        unsafe extern "C" fn(Handle, *const c_char, *mut c_void, c_int, usize, usize, usize, usize, usize),
    set_filter_progress_monitor_function: unsafe extern "C" fn(Handle, Monitor, *mut c_void),
    set_filter_bool: unsafe extern "C" fn(Handle, *const c_char, bool),
    set_filter_int: unsafe extern "C" fn(Handle, *const c_char, c_int),
    commit_filter: unsafe extern "C" fn(Handle),
    execute_filter: unsafe extern "C" fn(Handle),
    release_filter: unsafe extern "C" fn(Handle),
    /// Stays loaded until the process ends: threads of the library may still run when the last device is gone.
    _library: ManuallyDrop<libloading::Library>,
}

/// What the filter reads, each three values for each pixel, row by row.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Inputs<'a> {
    pub(crate) width: u32,
    pub(crate) height: u32,
    pub(crate) color: &'a [f32],
    pub(crate) albedo: &'a [f32],
    pub(crate) normal: &'a [f32],
}

impl Library {
    /// Loads the library: a file with its folder, or a name that the system's loader finds.
    ///
    /// # Errors
    /// What the loader says, or the function that is missing.
    pub(crate) fn open(file: &OsStr) -> Result<Self, String> {
        // SAFETY: loading runs the static initialisers of the library and of those that it needs, which come with it
        // and expect nothing of us.
        let library = unsafe { load(file) }.map_err(|error| error.to_string())?;
        macro_rules! function {
            ($name:literal) => {{
                // SAFETY: the types are those of the declarations in `oidn.h`, the same in every version 2.x; the
                // copied pointers stay valid because the library is never unloaded.
                let found = unsafe { library.get($name) };
                *found.map_err(|_| format!("version 2 is needed, and it has no function {}", $name))?
            }};
        }
        Ok(Self {
            new_device: function!("oidnNewDevice"),
            set_device_bool: function!("oidnSetDeviceBool"),
            set_device_int: function!("oidnSetDeviceInt"),
            get_device_int: function!("oidnGetDeviceInt"),
            get_device_error: function!("oidnGetDeviceError"),
            commit_device: function!("oidnCommitDevice"),
            release_device: function!("oidnReleaseDevice"),
            new_filter: function!("oidnNewFilter"),
            set_shared_filter_image: function!("oidnSetSharedFilterImage"),
            set_filter_progress_monitor_function: function!("oidnSetFilterProgressMonitorFunction"),
            set_filter_bool: function!("oidnSetFilterBool"),
            set_filter_int: function!("oidnSetFilterInt"),
            commit_filter: function!("oidnCommitFilter"),
            execute_filter: function!("oidnExecuteFilter"),
            release_filter: function!("oidnReleaseFilter"),
            _library: ManuallyDrop::new(library),
        })
    }

    /// Returns a device of so many threads on the processor, ready for filters.
    pub(crate) fn device(&self, threads: usize) -> Result<Device<'_>, Error> {
        // SAFETY: the handle that is returned, or null, belongs to the `Device`, which releases it once.
        let device = Device { library: self, handle: unsafe { (self.new_device)(CPU) } };
        if device.handle.is_null() {
            device.check()?;
            return Err(Error::Library { what: "this processor is not supported".to_owned() });
        }
        let threads = c_int::try_from(threads).unwrap_or(c_int::MAX);
        // SAFETY: the device is not null, and names are ended by zero and outlive the calls.
        unsafe {
            // Threads that are bound to cores would share theirs with those of any other program that does so.
            (self.set_device_bool)(device.handle, c"setAffinity".as_ptr(), false);
            (self.set_device_int)(device.handle, c"numThreads".as_ptr(), threads);
            (self.commit_device)(device.handle);
        }
        device.check()?;
        Ok(device)
    }
}

/// Loads a library; on Windows, those that it needs are looked for beside it.
///
/// # Safety
/// That of [`libloading::Library::new`].
unsafe fn load(file: &OsStr) -> Result<libloading::Library, libloading::Error> {
    #[cfg(windows)]
    if std::path::Path::new(file).is_absolute() {
        use libloading::os::windows::{LOAD_WITH_ALTERED_SEARCH_PATH, Library};
        // SAFETY: the caller's.
        return unsafe { Library::load_with_flags(file, LOAD_WITH_ALTERED_SEARCH_PATH) }.map(Into::into);
    }
    // SAFETY: the caller's.
    unsafe { libloading::Library::new(file) }
}

/// A device of the library, released at its end.
pub(crate) struct Device<'a> {
    library: &'a Library,
    handle: Handle,
}

impl Device<'_> {
    /// Returns the library's version, as in 2.3.1.
    pub(crate) fn version(&self) -> String {
        let number = |name: &CStr| {
            // SAFETY: the device is not null, and the name is ended by zero and outlives the call.
            unsafe { (self.library.get_device_int)(self.handle, name.as_ptr()) }
        };
        format!("{}.{}.{}", number(c"versionMajor"), number(c"versionMinor"), number(c"versionPatch"))
    }

    /// Denoises light without an upper bound by two guides without noise, into `output`.
    ///
    /// # Errors
    /// [`Error::Size`] for images of other sizes, [`Error::Library`], [`Error::Cancelled`].
    pub(crate) fn run(
        &self,
        inputs: Inputs<'_>,
        resources: Resources,
        progress: &dyn Progress,
        output: &mut [f32],
    ) -> Result<(), Error> {
        let Inputs { width, height, color, albedo, normal } = inputs;
        let expected = 3 * u64::from(width) * u64::from(height);
        let images: [(&CStr, _, *mut c_void, usize); 4] = [
            (c"color", "the light", color.as_ptr().cast_mut().cast(), color.len()),
            (c"albedo", "the albedo", albedo.as_ptr().cast_mut().cast(), albedo.len()),
            (c"normal", "the normals", normal.as_ptr().cast_mut().cast(), normal.len()),
            (c"output", "the result", output.as_mut_ptr().cast(), output.len()),
        ];
        for (_, image, _, found) in images {
            let found = found as u64;
            if found != expected {
                return Err(Error::Size { image, width, height, expected, found });
            }
        }
        let library = self.library;
        let Resources { max_memory, effort, .. } = resources;
        let megabytes = c_int::try_from(max_memory >> 20).unwrap_or(c_int::MAX);
        let mut progress = progress;
        // SAFETY: the device is not null. The filter reads the first three images and writes the last; each is a slice
        // of tightly packed values whose length was checked above, borrowed, the last one mutably, until the filter is
        // released, as is what `goes_on` gets. Names are ended by zero and outlive the calls.
        unsafe {
            let filter = Filter { library, handle: (library.new_filter)(self.handle, c"RT".as_ptr()) };
            if filter.handle.is_null() {
                self.check()?;
                return Err(Error::Library { what: "it has no filter RT".to_owned() });
            }
            let size = (width as usize, height as usize);
            for (name, _, values, _) in images {
                (library.set_shared_filter_image)(
                    filter.handle,
                    name.as_ptr(),
                    values,
                    FLOAT3,
                    size.0,
                    size.1,
                    0,
                    0,
                    0,
                );
            }
            (library.set_filter_bool)(filter.handle, c"hdr".as_ptr(), true);
            (library.set_filter_bool)(filter.handle, c"cleanAux".as_ptr(), true);
            if effort == Effort::Fast {
                (library.set_filter_int)(filter.handle, c"quality".as_ptr(), QUALITY_FAST);
            }
            (library.set_filter_int)(filter.handle, c"maxMemoryMB".as_ptr(), megabytes);
            let watched = (&raw mut progress).cast();
            (library.set_filter_progress_monitor_function)(filter.handle, goes_on, watched);
            (library.commit_filter)(filter.handle);
            self.check()?;
            (library.execute_filter)(filter.handle);
        }
        self.check()
    }

    /// Returns the first error since the last call.
    fn check(&self) -> Result<(), Error> {
        let mut message: *const c_char = ptr::null();
        // SAFETY: of a null device, the library tells why it was not made. `message` outlives the call.
        let code = unsafe { (self.library.get_device_error)(self.handle, &mut message) };
        if code == NO_ERROR {
            return Ok(());
        }
        if code == CANCELLED {
            return Err(Error::Cancelled);
        }
        let what = if message.is_null() {
            format!("error {code}")
        } else {
            // SAFETY: the message is ended by zero and lives until the next call of this function.
            unsafe { CStr::from_ptr(message) }.to_string_lossy().into_owned()
        };
        Err(Error::Library { what })
    }
}

impl Drop for Device<'_> {
    fn drop(&mut self) {
        if !self.handle.is_null() {
            // SAFETY: the handle is ours and is released once; filters borrow nothing that outlives `run`.
            unsafe { (self.library.release_device)(self.handle) }
        }
    }
}

/// Whether the work goes on: a [`Monitor`].
///
/// # Safety
/// `progress` points to a `&dyn Progress` that lives as long as the filter.
unsafe extern "C" fn goes_on(progress: *mut c_void, _done: f64) -> bool {
    // SAFETY: the caller's; it is read only, and `Progress` may be used by any thread.
    let progress: &dyn Progress = unsafe { *progress.cast::<&dyn Progress>() };
    // A panic must not leave through the library.
    panic::catch_unwind(AssertUnwindSafe(|| !progress.cancelled())).unwrap_or(false)
}

/// A filter of a device, released at its end.
struct Filter<'a> {
    library: &'a Library,
    handle: Handle,
}

impl Drop for Filter<'_> {
    fn drop(&mut self) {
        if !self.handle.is_null() {
            // SAFETY: the handle is ours and is released once.
            unsafe { (self.library.release_filter)(self.handle) }
        }
    }
}
