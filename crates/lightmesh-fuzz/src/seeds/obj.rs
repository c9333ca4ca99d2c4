//! OBJ files with their material libraries.

use super::Seed;
use crate::targets::obj::LIBRARY;

const SQUARE: &str = "\
mtllib library.mtl
o square
v -1 -1 0
v 1 -1 0 1 0.5 0.25
v 1 1 0
v -1 1 .5
vt 0 0
vt 1 0
vt 1 1
vn 0 0 1
g front
usemtl paper
f 1/1/1 2/2/1 3/3/1 4//1
usemtl glass
f -4 -3 -2
s 1
l 1 2
p 1
# end
";

const MATERIALS: &str = "\
newmtl paper
Kd 0.8 0.7 0.6
Ks 0.04 0.04 0.04
Ke 10 5 0
illum 2
map_Kd -s 2 2 -o 0.5 0 t.png
norm -bm 0.5 t.png
newmtl glass
Tf 0.9 0.9 0.9
d 0.5
Ni 1.5
illum 4
map_d t.png
map_Ke -clamp on t.png
";

/// A polygon of seven corners that is not convex.
const POLYGON: &str = "\
v 0 0 0
v 4 0 0
v 4 3 0
v 3 1 0
v 2 3 0
v 1 1 0
v 0 3 0
f 1 2 3 4 5 6 7
f 1 2 \\
3
";

pub(crate) fn seeds() -> Vec<Seed> {
    let both = [SQUARE.as_bytes(), LIBRARY, MATERIALS.as_bytes()].concat();
    vec![
        Seed::new("square.obj", both),
        Seed::new("polygon.obj", POLYGON),
        Seed::new("far.obj", "v 1e7 2e6 0\nv 10000001 2e6 0\nv 1e7 2000001 0\nf 1 2 3\n"),
    ]
}
