//! Renders the pictures of the experiments; one that several experiments need is rendered once.

use std::collections::{HashMap, VecDeque};
use std::rc::Rc;

use lightmesh::metrics::difference;
use lightmesh::{
    Camera, EmitterOptions, Image, LightMesh, Method, PictureOptions, Progress, RenderOptions, RenderStats, Scene,
    SceneData, Spacing, render,
};

use crate::error::Error;
use crate::scenes::{self, SceneName};
use crate::watcher::Watcher;

/// Scenes and pictures of a run.
pub(crate) struct Lab<'a> {
    /// Whether pictures are small.
    pub(crate) quick: bool,
    watcher: &'a dyn Watcher,
    places: HashMap<String, Rc<Place>>,
    shots: HashMap<String, Rc<Shot>>,
    /// The names of the shots, the oldest first.
    order: VecDeque<String>,
    /// Bytes that the pictures may take.
    budget: usize,
    /// Bytes that they take.
    bytes: usize,
}

/// The most bytes of pictures that are kept for later experiments. The oldest are dropped first, and rendered again if
/// they are needed.
const BUDGET: usize = 256 << 20;

/// A scene, ready for rays, and a camera.
pub(crate) struct Place {
    name: String,
    pub(crate) data: SceneData,
    pub(crate) scene: Scene,
    pub(crate) camera: Camera,
}

/// A picture, rendered with an empty mesh, and its statistics.
pub(crate) struct Shot {
    pub(crate) image: Image,
    pub(crate) stats: RenderStats,
}

impl Shot {
    fn bytes(&self) -> usize {
        size_of_val(self.image.pixels.as_slice())
    }

    /// Returns the render time, seconds.
    pub(crate) fn seconds(&self) -> f64 {
        self.stats.seconds.render
    }

    /// Returns the root mean square difference from the other picture, as a fraction of that one's mean.
    pub(crate) fn error(&self, truth: &Self) -> f64 {
        difference(&self.image.pixels, &truth.image.pixels).relrmse
    }
}

/// Lets the watcher stop a render.
struct Stop<'a>(&'a dyn Watcher);

impl Progress for Stop<'_> {
    fn cancelled(&self) -> bool {
        self.0.cancelled()
    }
}

impl<'a> Lab<'a> {
    pub(crate) fn new(quick: bool, watcher: &'a dyn Watcher) -> Self {
        let (places, shots) = (HashMap::new(), HashMap::new());
        Self { quick, watcher, places, shots, order: VecDeque::new(), budget: BUDGET, bytes: 0 }
    }

    /// Returns a scene with its own camera.
    pub(crate) fn place(&mut self, name: SceneName) -> Result<Rc<Place>, Error> {
        self.place_with(name, &EmitterOptions::default(), None)
    }

    /// Returns a scene with other light samples, or another camera.
    pub(crate) fn place_with(
        &mut self,
        name: SceneName,
        emitters: &EmitterOptions,
        camera: Option<Camera>,
    ) -> Result<Rc<Place>, Error> {
        let key = format!("{name:?} {emitters:?} {camera:?}");
        if let Some(place) = self.places.get(&key) {
            return Ok(Rc::clone(place));
        }
        let (data, own) = scenes::read(name)?;
        let scene = Scene::with_emitters(data.clone(), emitters)?;
        let place = Rc::new(Place { name: key.clone(), data, scene, camera: camera.unwrap_or(own) });
        self.places.insert(key, Rc::clone(&place));
        Ok(place)
    }

    /// Builds a scene that is in no file, with this name.
    pub(crate) fn made_up(&self, name: String, data: SceneData, camera: Camera) -> Result<Place, Error> {
        Ok(Place { name, scene: Scene::new(data.clone())?, data, camera })
    }

    /// Returns a picture of a place; renders it if it is not kept.
    pub(crate) fn shot(&mut self, place: &Place, options: &RenderOptions) -> Result<Rc<Shot>, Error> {
        let key = format!("{} {options:?}", place.name);
        if let Some(shot) = self.shots.get(&key) {
            return Ok(Rc::clone(shot));
        }
        let shot = Rc::new(self.take(place, options)?);
        self.bytes += shot.bytes();
        self.order.push_back(key.clone());
        self.shots.insert(key, Rc::clone(&shot));
        while self.bytes > self.budget
            && let Some(oldest) = self.order.pop_front()
        {
            self.bytes -= self.shots.remove(&oldest).map_or(0, |shot| shot.bytes());
        }
        Ok(shot)
    }

    /// Renders a picture.
    fn take(&self, place: &Place, options: &RenderOptions) -> Result<Shot, Error> {
        let PictureOptions { width, height, .. } = options.picture;
        self.watcher.picture(&format!("{}, {width} × {height}", options.method));
        let mut mesh = LightMesh::new(&place.scene, options)?;
        let frame = render(&place.scene, &place.camera, options, &mut mesh, &Stop(self.watcher))?;
        Ok(Shot { image: frame.image, stats: frame.stats })
    }

    /// Measures the render time of each of several options, seconds: the median of three interleaved runs, or one run
    /// if a picture takes longer than two seconds. The pictures are kept as [`Lab::shot`] keeps them.
    pub(crate) fn race(&mut self, place: &Place, ways: &[RenderOptions]) -> Result<Vec<f64>, Error> {
        let mut seconds: Vec<Vec<f64>> = Vec::new();
        for options in ways {
            seconds.push(vec![self.shot(place, options)?.seconds()]);
        }
        let runs = if self.quick { 1 } else { 3 };
        for _ in 1..runs {
            for (options, seconds) in ways.iter().zip(&mut seconds) {
                if seconds[0] < LONG {
                    seconds.push(self.take(place, options)?.seconds());
                }
            }
        }
        Ok(seconds.into_iter().map(median).collect())
    }
}

impl Lab<'_> {
    /// Returns the shortest render time of a few runs on this many threads, seconds.
    pub(crate) fn fastest(&self, place: &Place, options: &RenderOptions, threads: usize) -> Result<f64, Error> {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build()?;
        let stop = Stop(self.watcher);
        let mut fastest = f64::INFINITY;
        for _ in 0..if self.quick { 1 } else { 5 } {
            self.watcher.picture(&format!("{threads} threads"));
            let frame = pool.install(|| {
                let mut mesh = LightMesh::new(&place.scene, options)?;
                render(&place.scene, &place.camera, options, &mut mesh, &stop)
            });
            fastest = fastest.min(frame?.stats.seconds.render);
        }
        Ok(fastest)
    }
}

/// Pictures that take longer than this are timed once, seconds.
const LONG: f64 = 2.0;

/// Returns the median.
fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values.get(values.len() / 2).copied().unwrap_or(f64::NAN)
}

/// Options for direct light at pixel centres, with a mesh of this many points along the longest edge of the scene.
pub(crate) fn direct(method: Method, size: (u32, u32), points: f32) -> RenderOptions {
    let (width, height) = size;
    RenderOptions::default().with(|o| {
        o.method = method;
        o.picture.width = width;
        o.picture.height = height;
        o.picture.spp = 1;
        o.transport.bounces = 0;
        o.mesh.spacing = Spacing::Fraction(points);
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_same_picture_is_taken_once() {
        let mut lab = Lab::new(true, &());
        let place = lab.place(SceneName::Cornell).expect("scene");
        let options = direct(Method::Standard, (8, 8), 10.0);
        let first = lab.shot(&place, &options).expect("picture");
        let second = lab.shot(&place, &options).expect("picture");
        assert!(Rc::ptr_eq(&first, &second));
        assert_eq!(first.error(&second), 0.0);
        assert_eq!(median(vec![3.0, 1.0, 2.0]), 2.0);
        // Room for one picture: the next one takes its place.
        lab.budget = 8 * 8 * 12;
        let other = lab.shot(&place, &RenderOptions { seed: 1, ..options.clone() }).expect("picture");
        assert!(!Rc::ptr_eq(&first, &lab.shot(&place, &options).expect("picture")));
        assert_eq!((lab.shots.len(), lab.bytes), (1, other.bytes()));
    }
}
