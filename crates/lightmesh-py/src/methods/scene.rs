//! The methods of Scene.

use std::path::PathBuf;

use glam::Vec3;
use lightmesh::geometry::{Sphere, TriangleMesh};
use lightmesh::{Camera, Instance, Light, Method, SceneData};
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyDict};

use crate::camera::PyCamera;
use crate::image::PyImage;
use crate::light::PyLight;
use crate::light_mesh::{self, PyLightMesh};
use crate::listener::Listener;
use crate::material::PyMaterial;
use crate::scene::{self, MaterialArg, Origin, PyScene, material_index, scene_camera, transform_or_identity};
use crate::{arrays, keywords, meters, render};

/// A point as a tuple of Python, metres.
type Point = (f32, f32, f32);

#[pymethods]
impl PyScene {
    /// An empty scene.
    #[new]
    fn new() -> Self {
        Self::draft(Origin::default(), SceneData::default())
    }

    /// Reads a scene file: glTF (.gltf, .glb), Wavefront OBJ or PLY.
    ///
    /// units: what the numbers of punctual lights mean: "gltf" (candela, lux) or "blender" (its exporter's, 683 times
    /// as much).
    /// allow_outside: let the file's URIs leave its folder.
    /// max_memory: the most that reading and building may take, bytes or with a unit as in "4GiB"; None: half of the
    /// machine's memory. More is a MemoryLimitError.
    /// scene: which scene of the file, by name or index; None: the file's own choice.
    ///
    /// The property warnings tells what was left out or mended.
    #[staticmethod]
    #[pyo3(
        signature = (path, *, units="gltf", allow_outside=false, max_memory=None, scene=None),
        text_signature = "(path, *, units='gltf', allow_outside=False, max_memory=None, scene=None)"
    )]
    fn load(
        py: Python<'_>,
        path: PathBuf,
        units: &str,
        allow_outside: bool,
        max_memory: Option<&Bound<'_, PyAny>>,
        scene: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<Self> {
        let options = scene::load_options(py, units, allow_outside, max_memory, scene)?;
        scene::load(py, path, options)
    }

    /// Writes the scene as bytes, for other processes of this version of lightmesh; from_bytes reads them. Pickling
    /// does the same.
    fn to_bytes<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyBytes>> {
        scene::bytes::write(py, self)
    }

    /// Reads the scene that to_bytes wrote.
    #[staticmethod]
    fn from_bytes(py: Python<'_>, data: &[u8]) -> PyResult<Self> {
        scene::bytes::read(py, data)
    }

    fn __reduce__<'py>(slf: &Bound<'py, Self>) -> PyResult<(Bound<'py, PyAny>, (Bound<'py, PyBytes>,))> {
        let py = slf.py();
        Ok((slf.get_type().getattr("from_bytes")?, (slf.get().to_bytes(py)?,)))
    }

    /// Adds a material; returns its index.
    fn add_material(&self, material: PyRef<'_, PyMaterial>) -> usize {
        self.edit(|data| material.add_to(data))
    }

    /// Adds a triangle mesh, and places it once; returns its index.
    ///
    /// positions: (N, 3), metres. triangles: (M, 3), whole numbers, indices of positions, counter-clockwise from the
    /// front.
    /// normals: (N, 3), shading normals; None: those of the triangles. uvs: (N, 2), texture coordinates, (0, 0) an
    /// image's first texel.
    /// colors: (N, 3) or (N, 4), linear, multiply the base colour.
    /// transform: (4, 4), turns column vectors of the mesh into the world's; None: they are the world's.
    /// material: a Material, or the index of one that was added; None: glTF's default, white.
    #[pyo3(signature = (positions, triangles, *, normals=None, uvs=None, colors=None, transform=None, material=None, name=""))]
    #[expect(clippy::too_many_arguments, reason = "keywords of Python")]
    fn add_mesh(
        &self,
        positions: &Bound<'_, PyAny>,
        triangles: &Bound<'_, PyAny>,
        normals: Option<&Bound<'_, PyAny>>,
        uvs: Option<&Bound<'_, PyAny>>,
        colors: Option<&Bound<'_, PyAny>>,
        transform: Option<&Bound<'_, PyAny>>,
        material: Option<MaterialArg<'_>>,
        name: &str,
    ) -> PyResult<usize> {
        let mesh = TriangleMesh {
            name: name.to_owned(),
            positions: arrays::vec3s(positions, "positions")?,
            triangles: arrays::triangles(triangles, "triangles")?,
            normals: normals.map_or(Ok(Vec::new()), |value| arrays::vec3s(value, "normals"))?,
            uvs: [uvs.map_or(Ok(Vec::new()), |value| arrays::vec2s(value, "uvs"))?, Vec::new()],
            colors: colors.map_or(Ok(Vec::new()), |value| arrays::colors(value, "colors"))?,
            ..TriangleMesh::default()
        };
        let world_from_object = transform_or_identity(transform)?;
        self.try_edit(positions.py(), |data| {
            let material = material_index(data, material)?;
            data.meshes.push(TriangleMesh { material, ..mesh });
            let mesh = data.meshes.len() - 1;
            data.instances.push(Instance { mesh, world_from_object: scene::placed(data, world_from_object) });
            Ok(mesh)
        })
    }

    /// Places a mesh that was added before once more; its triangles are shared.
    ///
    /// mesh: its index. transform: (4, 4), turns column vectors of the mesh into the world's.
    fn add_instance(&self, mesh: usize, transform: &Bound<'_, PyAny>) -> PyResult<()> {
        let world_from_object = transform_or_identity(Some(transform))?;
        self.try_edit(transform.py(), |data| {
            let meshes = data.meshes.len();
            if mesh >= meshes {
                return Err(format!("mesh: there is no {mesh}; the scene has {meshes}"));
            }
            data.instances.push(Instance { mesh, world_from_object: scene::placed(data, world_from_object) });
            Ok(())
        })
    }

    /// Adds a sphere.
    ///
    /// center: (3,), metres. radius: metres, above 0. material: as for add_mesh.
    #[pyo3(signature = (center, radius, *, material=None))]
    fn add_sphere(&self, center: &Bound<'_, PyAny>, radius: f32, material: Option<MaterialArg<'_>>) -> PyResult<()> {
        let py = center.py();
        let center = arrays::vec3(center, "center")?;
        self.try_edit(py, |data| {
            let material = material_index(data, material)?;
            data.spheres.push(Sphere { center: scene::relative(data, center), radius, material });
            Ok(())
        })
    }

    /// Adds a light without extent that shines alike in every direction.
    ///
    /// position: (3,), metres. intensity: candela per channel, (3,) or one number. range: metres at which it ends;
    /// None: nowhere.
    #[pyo3(signature = (position, intensity, *, range=None))]
    fn add_point_light(
        &self,
        position: &Bound<'_, PyAny>,
        intensity: &Bound<'_, PyAny>,
        range: Option<f32>,
    ) -> PyResult<()> {
        let position = arrays::vec3(position, "position")?;
        let intensity_cd = arrays::color(intensity, "intensity")?;
        self.edit(|data| {
            let position = scene::relative(data, position);
            data.lights.push(Light::Point { position, intensity_cd, range });
        });
        Ok(())
    }

    /// Adds a light without extent that shines in a cone with a soft edge.
    ///
    /// position: (3,), metres. direction: (3,), the way it shines. intensity: candela per channel on the axis, (3,) or
    /// one number.
    /// inner_cone_angle, outer_cone_angle: half angles, radians: inside the first it is full, outside the second, at
    /// most pi/2, dark.
    #[pyo3(
        signature = (position, direction, intensity, *, inner_cone_angle=0.0, outer_cone_angle=std::f32::consts::FRAC_PI_4, range=None),
        text_signature = "($self, position, direction, intensity, *, inner_cone_angle=0.0, outer_cone_angle=0.7853981633974483, range=None)"
    )]
    fn add_spot_light(
        &self,
        position: &Bound<'_, PyAny>,
        direction: &Bound<'_, PyAny>,
        intensity: &Bound<'_, PyAny>,
        inner_cone_angle: f32,
        outer_cone_angle: f32,
        range: Option<f32>,
    ) -> PyResult<()> {
        let position = arrays::vec3(position, "position")?;
        let direction = arrays::direction(direction, "direction")?;
        let intensity_cd = arrays::color(intensity, "intensity")?;
        let light =
            |position| Light::Spot { position, direction, intensity_cd, range, inner_cone_angle, outer_cone_angle };
        self.edit(|data| data.lights.push(light(scene::relative(data, position))));
        Ok(())
    }

    /// Adds a light that is infinitely far away.
    ///
    /// direction: (3,), the way it shines. illuminance: lux per channel on a surface that faces it, (3,) or one number.
    fn add_directional_light(&self, direction: &Bound<'_, PyAny>, illuminance: &Bound<'_, PyAny>) -> PyResult<()> {
        let direction = arrays::direction(direction, "direction")?;
        let illuminance_lux = arrays::color(illuminance, "illuminance")?;
        self.edit(|data| data.lights.push(Light::Directional { direction, illuminance_lux }));
        Ok(())
    }

    /// Adds a camera, so that render finds it by its name or index; returns its index.
    fn add_camera(&self, camera: PyRef<'_, PyCamera>) -> usize {
        self.edit(|data| {
            data.cameras.push(camera.camera.clone());
            data.cameras.len() - 1
        })
    }

    /// Replaces the environment, which lights the scene from all sides; None removes it.
    ///
    /// environment: a colour, (3,) or one number, or a latitude-longitude map, (H, W, 3), linear, whose middle is +X
    /// and whose first row is up (+Y); cd/m² per channel, times strength. rotation: degrees about +Y, counter-clockwise
    /// seen from above.
    #[pyo3(signature = (environment, *, strength=1.0, rotation=0.0))]
    fn set_environment(&self, environment: Option<&Bound<'_, PyAny>>, strength: f32, rotation: f32) -> PyResult<()> {
        let environment = environment.map(|value| scene::environment(value, strength, rotation)).transpose()?;
        self.edit(|data| data.environment = environment);
        Ok(())
    }

    /// The file that the scene was read from and every file that it names, as absolute paths; empty for a scene made of
    /// arrays. Image.save and LightMesh.save do not replace them.
    #[getter]
    fn files(&self) -> Vec<PathBuf> {
        self.origin.files.to_vec()
    }

    /// The number of triangles; those of a mesh count once for each of its instances.
    #[getter]
    fn triangle_count(&self) -> u64 {
        self.with_data(|data| {
            let count = |i: &Instance| data.meshes.get(i.mesh).map_or(0, |mesh| mesh.triangles.len() as u64);
            data.instances.iter().map(count).sum()
        })
    }

    /// Point, spot and directional lights.
    #[getter]
    fn lights(&self) -> Vec<PyLight> {
        self.with_data(|data| data.lights.iter().map(|&light| PyLight { light }).collect())
    }

    /// Cameras, in the order of their indices.
    #[getter]
    fn cameras(&self) -> Vec<PyCamera> {
        let camera = |camera: &Camera| PyCamera { camera: camera.clone() };
        self.with_data(|data| data.cameras.iter().map(camera).collect())
    }

    /// The box around all surfaces: its least and its largest corner, metres.
    #[getter]
    fn bounds(&self, py: Python<'_>) -> PyResult<(Point, Point)> {
        let built = self.built(py)?;
        let (bounds, origin) = (built.scene.bounds(), built.scene.data().origin);
        let world = |p: Vec3| (p.as_dvec3() + origin).as_vec3().into();
        Ok((world(bounds.min), world(bounds.max)))
    }

    /// Warnings: what was left out, mended or cannot be shown as it was meant, one sentence each.
    #[getter]
    fn warnings(&self) -> Vec<String> {
        self.all_warnings()
    }

    /// The number of light samples that represent all emitters, as the scene was last rendered.
    #[getter]
    fn light_sample_count(&self, py: Python<'_>) -> PyResult<u64> {
        Ok(self.built(py)?.scene.light_sample_count())
    }

    /// Renders a picture; the options are those of `lightmesh render`, whose --help says more.
    ///
    /// camera: a Camera, or the name or index of one of the scene's; None: the first, or one that frames the scene.
    /// size: (width, height) or "WxH", pixels; None: 1280 wide, the height from the camera's aspect.
    /// method: "auto" (None), "mesh", "paper", "standard" (also called "exact"), "hybrid", "unbiased" or "path". quality:
    /// "preview", "normal" (None) or "final", with "auto": an error of 10, 5 or 2% of the picture's mean.
    /// spp: samples per pixel; None: 4, and up to most_spp (None: 64) where there is noise; with time_limit (seconds) as
    /// many as there is time for.
    /// bounces: diffuse interreflections. error: bound on the error of the picture, relative to its mean, with
    /// "auto", in place of quality.
    /// depth, cutoff: how far mirrored and refracted rays are followed. falloff: "r2" or "C+r".
    /// light_error: error of the sum over many lights. seed: of all randomness.
    /// environment: .hdr or .exr file, (r, g, b) or "#rrggbb", in place of the scene's; environment_strength multiplies
    /// it, and environment_rotation turns it, degrees. light_samples: for each thing with a size that shines.
    /// light_radius: metres, makes lights spheres. Where no light reaches what the camera sees, there is the soft light of
    /// a studio, and in closed rooms a lamp at the camera; environment="black" leaves it dark.
    /// spacing, indirect_spacing: metres, "1/K" of the scene's longest edge, or "auto". gather_rays: at a point of the
    /// indirect mesh. near_rays: short ones at each pixel, for what is nearer than 1.5 of its spacings.
    /// refine: how often meshes may halve their spacing. lod_distance: metres from the camera within which they are denser.
    /// rays: with method "unbiased". interpolation: "auto", "trilinear", "trilinear:RULE", "nearest", "sphere" or
    /// "sphere:R".
    /// weight, field_falloff, paper_scale: variants of the paper.
    /// aov: names of layers, as a list or with commas: albedo, normal, depth, direct, indirect, mesh_level, mesh_valid,
    /// points.
    /// threads: None: one for each core, or as many as RAYON_NUM_THREADS says; more than 4 for each core, or 64, are cut
    /// down with a RuntimeWarning. The picture is the same. max_memory: bytes or "4GiB"; more is a
    /// MemoryLimitError.
    /// mesh: a LightMesh of this scene that keeps the light between pictures; options that are not given are the
    /// mesh's.
    /// progress: True shows a bar (needs tqdm); or a function of (stage, done, total, rays), which may raise to end the
    /// render.
    /// denoise: take the noise out with Open Image Denoise (pip install pyoidn), an Error where that is not installed; the
    /// picture is then not bit for bit the same on every machine. Image.denoise does it later.
    ///
    /// Ctrl-C raises KeyboardInterrupt soon. The picture is the same bit for bit whatever the threads, the progress and
    /// the mesh's past.
    #[pyo3(
        signature = (*, camera=None, mesh=None, progress=None, denoise=false, **options),
        text_signature = "($self, *, camera=None, size=None, method=None, quality=None, spp=None, most_spp=None, time_limit=None, bounces=3, error=None, depth=8, cutoff=0.001, falloff='r2', light_error=0.01, seed=0, environment=None, environment_strength=1.0, environment_rotation=0.0, light_samples=64, light_radius=0.0, spacing='auto', indirect_spacing='auto', gather_rays=None, near_rays=None, refine=None, lod_distance=None, rays=4, interpolation='auto', weight='constant', field_falloff='r2', paper_scale='visibility', aov=None, threads=None, max_memory=None, mesh=None, progress=None, denoise=False)"
    )]
    fn render(
        slf: &Bound<'_, Self>,
        camera: Option<&Bound<'_, PyAny>>,
        mesh: Option<&Bound<'_, PyLightMesh>>,
        progress: Option<&Bound<'_, PyAny>>,
        denoise: bool,
        options: Option<&Bound<'_, PyDict>>,
    ) -> PyResult<PyImage> {
        let (py, scene) = (slf.py(), slf.get());
        let chosen = keywords::chosen("render", options)?;
        let camera = scene_camera(scene.state().data(), camera)?;
        let lit = light_mesh::lit_scene(slf, mesh, &chosen, Some(&camera))?;
        let progress = Listener::new(py, progress)?;
        let result = render::render(py, scene, lit, camera, mesh.map(Bound::get), denoise, progress.callback());
        progress.close(result)
    }

    /// Measures the irradiance at meters, direct and indirect light together: (N, 3), lux per channel, float32.
    ///
    /// positions: (N, 3), metres; on surfaces or in the open. normals: (N, 3), or (3,) for all, of any length: which
    /// way they face.
    /// method: "standard" is exact direct light and no other; "path" is the ground truth with spp samples a meter
    /// (None: 4), their noise falls with the root of spp; "unbiased" has noise too, and the rest read a mesh as
    /// LightMesh.irradiance does.
    /// mesh: a LightMesh of this scene that keeps the light; options that are not given are the mesh's.
    /// The other options are those of render, but for those of pictures; progress counts meters, with "path" samples.
    #[pyo3(
        signature = (positions, normals, *, mesh=None, progress=None, **options),
        text_signature = "($self, positions, normals, *, method='mesh', spp=None, bounces=3, depth=8, falloff='r2', light_error=0.01, seed=0, environment=None, environment_strength=1.0, environment_rotation=0.0, light_samples=64, light_radius=0.0, spacing='auto', indirect_spacing='auto', gather_rays=None, near_rays=None, rays=4, interpolation='auto', weight='constant', field_falloff='r2', paper_scale='visibility', threads=None, max_memory=None, mesh=None, progress=None)"
    )]
    fn irradiance<'py>(
        slf: &Bound<'py, Self>,
        positions: &Bound<'py, PyAny>,
        normals: &Bound<'py, PyAny>,
        mesh: Option<&Bound<'py, PyLightMesh>>,
        progress: Option<&Bound<'py, PyAny>>,
        options: Option<&Bound<'py, PyDict>>,
    ) -> PyResult<Bound<'py, PyAny>> {
        // error, quality, refine, lod_distance and time_limit are known too, so that it is said why meters do not have them.
        let mut chosen = keywords::chosen_without("irradiance", &["size", "aov", "cutoff"], options)?;
        if mesh.is_none() {
            chosen.prefer_method(Method::MESH);
        }
        let meters = arrays::meters(positions, normals)?;
        let lit = light_mesh::lit_scene(slf, mesh, &chosen, None)?;
        let options = lit.keywords.mesh_options();
        let mesh = mesh.map(|mesh| &mesh.get().mesh);
        meters::measure(slf.py(), lit, options, meters, mesh, progress)?.irradiance(slf.py())
    }

    fn __repr__(&self) -> String {
        let name = &self.origin.name;
        self.with_data(|data| {
            let triangles: usize = data.meshes.iter().map(|mesh| mesh.triangles.len()).sum();
            let (lights, cameras) = (data.lights.len(), data.cameras.len());
            format!("<lightmesh.Scene {name:?}, {triangles} triangles, {lights} lights, {cameras} cameras>")
        })
    }
}
