//! The denoiser: the library, found and tried.

use std::ffi::OsStr;
use std::path::PathBuf;

use lightmesh::Progress;

use crate::library::{Inputs, Library};
use crate::search::{Candidate, Places};
use crate::{Error, Resources};

/// Open Image Denoise, loaded and ready; threads may share it.
#[derive(Debug)]
pub struct Denoiser {
    library: Library,
    version: String,
}

/// What surfaces look like in the same pixels, without noise: three values for each pixel, row by row.
#[derive(Clone, Copy, Debug)]
pub struct Guides<'a> {
    /// The part of light that surfaces send on, RGB in [0, 1]: edges and patterns in it are kept in the light.
    pub albedo: &'a [f32],
    /// Shading normals, of length 1 or, where a pixel sees several, less.
    pub normal: &'a [f32],
}

impl Denoiser {
    /// Loads the library from wherever the environment of this process says that it may be.
    ///
    /// # Errors
    /// [`Error::NotFound`], [`Error::Named`].
    pub fn load() -> Result<Self, Error> {
        Self::load_from(&Places::of_process())
    }

    /// Loads the library from the first of these places that has one which works.
    ///
    /// # Errors
    /// [`Error::NotFound`], [`Error::Named`].
    pub fn load_from(places: &Places) -> Result<Self, Error> {
        let mut tried = Vec::new();
        for candidate in places.candidates() {
            // A file that is there and cannot be used is told with its fault, all others by their names.
            let (path, fault) = match candidate {
                Candidate::Without(folder) => (folder, None),
                Candidate::File(file) => match Self::open(file.as_os_str()) {
                    Ok(denoiser) => return Ok(denoiser),
                    Err(fault) => (file, Some(fault)),
                },
                Candidate::System(name) => match Self::open(OsStr::new(name)) {
                    Ok(denoiser) => return Ok(denoiser),
                    Err(_) => (PathBuf::from(name), None),
                },
            };
            if places.named.is_some() {
                let nothing = || "there is no such file, and no library in a folder of this name".to_owned();
                return Err(Error::Named { path, what: fault.unwrap_or_else(nothing) });
            }
            let fault = fault.map_or(String::new(), |fault| format!(" ({fault})"));
            tried.push(format!("{}{fault}", path.display()));
        }
        Err(Error::NotFound { tried })
    }

    /// Loads a library and tries whether it works on this machine.
    fn open(file: &OsStr) -> Result<Self, String> {
        let library = Library::open(file)?;
        let version = library.device(1).map_err(|error| error.to_string())?.version();
        Ok(Self { library, version })
    }

    /// Returns the library's version, as in 2.3.1.
    pub fn version(&self) -> &str {
        &self.version
    }

    /// Returns the library's name with its version, as files keep it.
    pub fn name(&self) -> String {
        format!("Open Image Denoise {}", self.version)
    }

    /// Returns light without its noise: RGB of any scale, not below 0, row by row from the upper left; what is negative
    /// counts as 0.
    ///
    /// # Errors
    /// [`Error::Size`] for images that are not three values for each pixel, [`Error::Library`], [`Error::Cancelled`] soon after
    /// `progress` says so.
    pub fn denoise(
        &self,
        width: u32,
        height: u32,
        color: &[f32],
        guides: Guides<'_>,
        resources: Resources,
        progress: &dyn Progress,
    ) -> Result<Vec<f32>, Error> {
        let Guides { albedo, normal } = guides;
        let mut output = vec![0.0; color.len()];
        let device = self.library.device(resources.threads.max(1))?;
        let inputs = Inputs { width, height, color, albedo, normal };
        device.run(inputs, resources, progress, &mut output)?;
        Ok(output)
    }
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use crate::Effort;

    /// Runs a test of the library where there is one, and says so where there is none.
    #[expect(clippy::print_stderr, reason = "a test that did not run is to be seen")]
    pub(crate) fn with_library(test: impl FnOnce(&Denoiser)) {
        match Denoiser::load() {
            Ok(denoiser) => test(&denoiser),
            Err(error) => eprintln!("skipped: {error}"),
        }
    }

    /// A number in [0, 1), another one for each index.
    pub(crate) fn random(index: usize) -> f32 {
        let x = (index as u64).wrapping_mul(0x9e37_79b9_7f4a_7c15);
        ((x ^ (x >> 32)).wrapping_mul(0xd6e8_feb8_6659_fd93) >> 40) as f32 / (1 << 24) as f32
    }

    const RESOURCES: Resources = Resources { threads: 2, max_memory: 1 << 30, effort: Effort::Full };

    #[test]
    fn what_is_missing_is_named() {
        let folder = tempfile::tempdir().expect("a folder");
        let nowhere = folder.path().join("nowhere");
        let named = Places { named: Some(nowhere.clone()), ..Places::default() };
        let message = Denoiser::load_from(&named).expect_err("nothing there").to_string();
        assert!(message.starts_with(&format!("LIGHTMESH_OIDN: {}: there is no", nowhere.display())), "{message}");

        let package = Places { package: Some(nowhere.clone()), ..Places::default() };
        // The system may have the library.
        if let Err(error) = Denoiser::load_from(&package) {
            let message = error.to_string();
            for part in ["not found", "nowhere", crate::search::NAMES[0], "pip install pyoidn", "LIGHTMESH_OIDN"] {
                assert!(message.contains(part), "no {part} in {message}");
            }
        }
    }

    /// A file that is no library is refused with the loader's words.
    #[test]
    fn a_broken_file_is_named() {
        let folder = tempfile::tempdir().expect("a folder");
        let file = folder.path().join(crate::search::NAMES[0]);
        std::fs::write(&file, b"not a library").expect("a file");
        let places = Places { named: Some(file.clone()), ..Places::default() };
        let error = Denoiser::load_from(&places).expect_err("no library");
        assert!(matches!(&error, Error::Named { path, .. } if *path == file), "{error}");
    }

    #[test]
    fn sizes_are_checked() {
        with_library(|denoiser| {
            let (light, short) = (vec![1.0; 3 * 8 * 4], vec![1.0; 3 * 8 * 4 - 1]);
            let run = |color, albedo, normal| {
                denoiser.denoise(8, 4, color, Guides { albedo, normal }, RESOURCES, &()).map(|light| light.len())
            };
            assert_eq!(run(&light, &light, &light).expect("an image"), 3 * 8 * 4);
            for (result, image) in [
                (run(&short, &light, &light), "the light"),
                (run(&light, &short, &light), "the albedo"),
                (run(&light, &light, &short), "the normals"),
            ] {
                let message = result.expect_err("a wrong size").to_string();
                assert_eq!(message, format!("{image}: 8 x 4 pixels have 96 values, not 95"));
            }
        });
    }

    /// A progress that says at once that the work is to end.
    struct Stopped;

    impl Progress for Stopped {
        fn cancelled(&self) -> bool {
            true
        }
    }

    #[test]
    fn it_can_be_cancelled() {
        with_library(|denoiser| {
            let light = vec![1.0; 3 * 256 * 256];
            let guides = Guides { albedo: &light, normal: &light };
            let result = denoiser.denoise(256, 256, &light, guides, RESOURCES, &Stopped);
            assert!(matches!(result, Err(Error::Cancelled)), "{:?}", result.map(|light| light.len()));
        });
    }

    /// The same values for any number of threads, with noise that is nearly gone.
    #[test]
    fn noise_goes_whatever_the_threads() {
        with_library(|denoiser| {
            assert!(denoiser.version().starts_with('2'), "{}", denoiser.version());
            let pixels = 96 * 64;
            let (albedo, normal) = (vec![1.0; 3 * pixels], [0.0, 0.0, 1.0].repeat(pixels));
            let color: Vec<f32> = (0..3 * pixels).map(random).collect();
            let run = |threads| {
                let guides = Guides { albedo: &albedo, normal: &normal };
                denoiser.denoise(96, 64, &color, guides, Resources { threads, ..RESOURCES }, &()).expect("light")
            };
            let (one, three) = (run(1), run(3));
            assert!(one == three, "threads change the light");
            let variance = |light: &[f32]| {
                let mean = light.iter().sum::<f32>() / light.len() as f32;
                light.iter().map(|x| (x - mean) * (x - mean)).sum::<f32>() / light.len() as f32
            };
            assert!(variance(&one) < variance(&color) / 20.0, "{} of {}", variance(&one), variance(&color));
        });
    }
}
