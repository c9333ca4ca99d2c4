//! The scenes and what they are made of. Metres, Y up, candela.

mod cornell;
mod document;
mod low_discrepancy;
mod room;
mod solids;
mod surface;
mod triangle;
mod window;

pub(crate) use document::Document;

/// A scene and the file that it is written to.
pub(crate) struct SceneFile {
    /// In `scenes/`.
    pub(crate) file_name: &'static str,
    /// What the file says.
    pub(crate) document: Document,
}

/// Every scene, in the order in which `scenes/README.md` lists them.
pub(crate) fn all() -> Vec<SceneFile> {
    let file = |file_name, document| SceneFile { file_name, document };
    vec![
        file("room_5.glb", room::room(5)),
        file("room_10.glb", room::room(10)),
        file("room_15.glb", room::room(15)),
        file("room_100.glb", room::room(100)),
        file("room_1000.glb", room::room(1000)),
        file("triangle.glb", triangle::triangle()),
        file("cornell.glb", cornell::cornell()),
        file("window.glb", window::window()),
    ]
}
