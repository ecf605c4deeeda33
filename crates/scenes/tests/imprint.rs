//! The imprint scene: geometry by hand, reproducibility, own meshes and bad ones.

#![allow(clippy::unwrap_used)]

mod common;

use std::f64::consts::TAU;
use std::fmt::Write as _;
use std::fs;
use std::path::{Path, PathBuf};

use common::truth;
use ndarray::{Array2, Axis, Slice};
use taxel_scenes::{Error, Imprint, Scene, Settings, explain};

/// 8 × 8 elements: fast.
fn small() -> Imprint {
    Imprint { elements: 8, ..Imprint::default() }
}

#[test]
fn classes_and_objects_take_turns_and_readings_are_in_range() {
    let scene = small().simulate(120, 1, &[]).unwrap();
    assert_eq!(scene.x.shape(), [120, 8, 8]);
    assert_eq!(scene.class_names, ["bird", "chair", "hand", "head", "plane", "quadruped"]);
    for object in 0..30 {
        let mine: Vec<usize> = (0..120).filter(|&i| scene.group[i] == object).collect();
        assert_eq!(mine.len(), 4, "as many of each object");
        assert!(mine.iter().all(|&i| scene.y[i] == object / 5));
    }
    assert!(scene.x.iter().all(|v| (0.0..=1.0).contains(v)));
    for (name, values) in &scene.truth {
        assert!(values.len() == 120 && values.iter().all(|v| v.is_finite()), "{name}");
    }
    for (i, imprint) in scene.x.outer_iter().enumerate() {
        assert!(imprint.iter().any(|&v| v == 1.0), "imprint {i} touches");
    }
    assert!(truth(&scene, "lift_mm").iter().all(|lift| lift.abs() < 10.0));
    assert!(scene.streams.is_empty());
}

#[test]
fn a_sample_depends_on_seed_and_index_and_not_on_how_many_there_are() {
    let folder = eggs();
    let imprints = Imprint { view: 12, ..folder.scene() };
    let (few, many) = (imprints.simulate(9, 5, &[]).unwrap(), imprints.simulate(40, 5, &[]).unwrap());
    assert_eq!(few, imprints.simulate(9, 5, &[]).unwrap());
    assert_eq!(few.x, many.x.slice_axis(Axis(0), Slice::from(..9)));
    assert_eq!(few.streams[0].1, many.streams[0].1.slice_axis(Axis(0), Slice::from(..9)));
    for ((name, few), (_, many)) in few.truth.iter().zip(&many.truth) {
        assert_eq!(few, &many[..9], "{name}");
    }
    assert_ne!(few.x, imprints.simulate(9, 6, &[]).unwrap().x);
    // The patch is the same whatever the resolution, and whether or not pictures are taken.
    let fine = Imprint { elements: 32, ..folder.scene() }.simulate(9, 5, &[]).unwrap();
    let points = |scene: &Scene| truth(scene, "point_x_mm").to_vec();
    assert_eq!(points(&few), points(&fine));
}

#[test]
fn without_spin_only_the_turn_is_gone() {
    let scene = eggs();
    let with = scene.scene().simulate(30, 2, &[]).unwrap();
    let without = scene.scene().simulate(30, 2, &["spin".into()]).unwrap();
    assert_eq!(truth(&with, "point_y_mm")[..6], truth(&without, "point_y_mm")[..6]);
    assert!(truth(&without, "spin_deg").iter().all(|&spin| spin == 0.0));
    assert!(truth(&with, "spin_deg").iter().any(|&spin| spin > 180.0));
    assert_ne!(with.x, without.x);
    let error = small().simulate(1, 0, &["gravity".into()]).unwrap_err().to_string();
    assert_eq!(error, "scene imprint has no removable effect `gravity`; known: spin");
    assert!(explain("imprint").unwrap().iter().all(|effect| effect.removable == (effect.name == "spin")));
}

#[test]
fn pictures_show_the_object_on_white() {
    let scene = Imprint { view: 40, ..small() }.simulate(30, 1, &[]).unwrap();
    let (name, pictures) = &scene.streams[0];
    assert_eq!((name.as_str(), pictures.shape()), ("view", &[30, 3, 40, 40][..]));
    for picture in pictures.outer_iter() {
        assert!(picture.iter().all(|v| (0.0..=1.0).contains(v)));
        let object = picture.index_axis(Axis(0), 0).iter().filter(|&&v| v < 1.0).count();
        assert!((30..1300).contains(&object), "{object} of 1600 pixels");
        assert!(picture[[0, 0, 0]] == 1.0 && picture[[2, 39, 39]] == 1.0);
    }
}

/// A folder that is gone with the test.
struct Meshes(tempfile::TempDir);

impl Meshes {
    fn new() -> Self {
        Self(tempfile::tempdir().unwrap())
    }

    fn add(self, name: &str, content: impl AsRef<[u8]>) -> Self {
        let path = self.0.path().join(name);
        fs::create_dir_all(path.parent().unwrap()).unwrap();
        fs::write(path, content).unwrap();
        self
    }

    fn scene(&self) -> Imprint {
        Imprint { meshes: Some(self.0.path().into()), ..small() }
    }

    fn refused(&self) -> String {
        let error = self.scene().simulate(4, 0, &[]).unwrap_err();
        assert!(matches!(error, Error::Mesh { .. }), "{error}");
        error.to_string().replace(&format!("{}/", self.0.path().display()), "")
    }
}

/// A ball of `rings` × `2 rings` facets: vertices and triangles.
fn ball(rings: usize, radius: f64) -> (Vec<[f64; 3]>, Vec<[usize; 3]>) {
    let columns = 2 * rings;
    let at = |ring: usize, column: usize| {
        let (polar, turn) = (ring as f64 / rings as f64 * TAU / 2.0, column as f64 / columns as f64 * TAU);
        [radius * polar.sin() * turn.cos(), radius * polar.sin() * turn.sin(), radius * polar.cos()]
    };
    let vertices = (0..=rings).flat_map(|r| (0..columns).map(move |c| at(r, c))).collect();
    let quads = (0..rings).flat_map(|r| (0..columns).map(move |c| (r, c)));
    let triangles = quads.flat_map(|(r, c)| {
        let next = (c + 1) % columns;
        let [a, b] = [r * columns + c, (r + 1) * columns + c];
        let [d, e] = [r * columns + next, (r + 1) * columns + next];
        [[a, b, e], [a, e, d]]
    });
    (vertices, triangles.collect())
}

/// Two classes of longish balls, of no symmetry about any normal.
fn eggs() -> Meshes {
    let (mut vertices, triangles) = ball(14, 1.0);
    vertices.iter_mut().for_each(|v| *v = [v[0] + 0.2 * v[2] * v[2], 0.6 * v[1], 0.4 * v[2]]);
    let egg = off(&vertices, &triangles);
    Meshes::new().add("hen.off", &egg).add("duck.off", &egg)
}

fn off(vertices: &[[f64; 3]], triangles: &[[usize; 3]]) -> String {
    let mut text = format!("OFF # comment\n{} {} 0\n", vertices.len(), triangles.len());
    vertices.iter().for_each(|[x, y, z]| writeln!(text, "{x} {y} {z}").unwrap());
    triangles.iter().for_each(|[a, b, c]| writeln!(text, "3 {a} {b} {c}").unwrap());
    text
}

fn obj(vertices: &[[f64; 3]], triangles: &[[usize; 3]]) -> String {
    let mut text = String::from("# comment\nmtllib nowhere.mtl\n");
    vertices.iter().for_each(|[x, y, z]| writeln!(text, "v {x} {y} {z}").unwrap());
    triangles.iter().for_each(|t| writeln!(text, "f {} {} {}", t[0] + 1, t[1] + 1, t[2] + 1).unwrap());
    text
}

fn stl_text(vertices: &[[f64; 3]], triangles: &[[usize; 3]]) -> String {
    let mut text = String::from("solid ball\n");
    for t in triangles {
        text += "facet normal 0 0 0\nouter loop\n";
        t.iter().for_each(|&v| {
            writeln!(text, "vertex {} {} {}", vertices[v][0], vertices[v][1], vertices[v][2]).unwrap()
        });
        text += "endloop\nendfacet\n";
    }
    text + "endsolid ball\n"
}

/// Binary, with the header that confuses readers.
fn stl_binary(vertices: &[[f64; 3]], triangles: &[[usize; 3]]) -> Vec<u8> {
    let mut bytes = b"solid written by a CAD program\n".to_vec();
    bytes.resize(80, b' ');
    bytes.extend((triangles.len() as u32).to_le_bytes());
    for t in triangles {
        bytes.extend([0u8; 12]);
        t.iter().flat_map(|&v| vertices[v]).for_each(|c| bytes.extend((c as f32).to_le_bytes()));
        bytes.extend([0u8; 2]);
    }
    bytes
}

#[test]
fn a_ball_leaves_the_imprint_that_its_radius_says() {
    let (vertices, triangles) = ball(150, 7.0);
    let folder = Meshes::new()
        .add("a/ball.off", off(&vertices, &triangles))
        .add("b/ball.obj", obj(&vertices, &triangles));
    // Corner to corner of its box the ball is 2 R sqrt(3).
    let radius = 60.0;
    let scene = Imprint { size_mm: 2.0 * radius * 3f64.sqrt(), elements: 11, ..folder.scene() };
    let scene = scene.simulate(20, 3, &[]).unwrap();
    let pitch = 25.5 / 11.0;
    let want = Array2::from_shape_fn((11, 11), |(row, column)| {
        let away = pitch * (row as f64 - 5.0).hypot(column as f64 - 5.0);
        1.0 - (radius - (radius * radius - away * away).sqrt()) / 10.0
    });
    for imprint in scene.x.outer_iter() {
        let gap = imprint.iter().zip(&want).map(|(&v, want)| (f64::from(v) - want).abs()).fold(0.0, f64::max);
        // A facet of 1.2 degrees leans by up to 0.85.
        assert!(gap < 0.03, "{imprint:?}");
    }
    let lifts = truth(&scene, "lift_mm");
    assert!(lifts.iter().all(|&lift| lift < 0.2), "nothing stands out of a ball: {lifts:?}");
    let far = |i: usize| ["x", "y", "z"].map(|a| f64::from(truth(&scene, &format!("point_{a}_mm"))[i]));
    assert!((0..20).all(|i| (far(i).map(|c| c * c).iter().sum::<f64>().sqrt() - radius).abs() < 0.1));
}

#[test]
fn every_format_and_either_winding_feel_the_same() {
    let (vertices, triangles) = ball(20, 1.0);
    let inside_out: Vec<[usize; 3]> = triangles.iter().map(|&[a, b, c]| [a, c, b]).collect();
    let felt = |name: &str, content: Vec<u8>| {
        let folder = Meshes::new().add(&format!("a/{name}"), &content).add(&format!("b/{name}"), &content);
        folder.scene().simulate(6, 1, &["spin".into()]).unwrap().x
    };
    let first = felt("ball.obj", obj(&vertices, &triangles).into());
    let others = [
        ("ball.off", off(&vertices, &triangles).into()),
        ("ball.STL", stl_text(&vertices, &triangles).into()),
        ("anonymous.stl", stl_text(&vertices, &triangles).replacen("solid ball", "solid", 1).into()),
        ("ball.stl", stl_binary(&vertices, &triangles)),
    ];
    for (name, content) in others {
        let gap = (&felt(name, content) - &first).mapv(f32::abs);
        assert!(gap.iter().all(|&v| v < 1e-3), "{name}: {gap}");
    }
    let turned = felt("ball.off", off(&vertices, &inside_out).into());
    assert!(turned.iter().all(|&v| v > 0.0), "felt from outside all the same");
}

#[test]
fn an_open_surface_is_felt_from_either_side() {
    let sheet = "OFF\n4 1 0\n0 0 0\n1 0 0\n1 1 0\n0 1 0\n4 0 1 2 3\n";
    let folder = Meshes::new().add("flat/sheet.off", sheet).add("thin/sheet.off", sheet);
    let scene = folder.scene().simulate(10, 0, &[]).unwrap();
    assert!(scene.x.iter().all(|&v| v == 0.0 || v == 1.0), "flat, or beyond the edge");
    assert!(scene.x.iter().any(|&v| v == 1.0));
}

#[test]
fn a_point_that_the_array_cannot_reach_is_never_probed() {
    // A floor under a roof that is nearer than any approach: only the outer sides can be felt.
    let room = "OFF\n8 2 0\n0 0 0\n9 0 0\n9 9 0\n0 9 0\n0 0 2\n9 0 2\n9 9 2\n0 9 2\n4 0 1 2 3\n4 4 5 6 7\n";
    let folder = Meshes::new().add("a/room.off", room).add("b/room.off", room);
    let scene = folder.scene().simulate(60, 0, &[]).unwrap();
    let (z, up) = (truth(&scene, "point_z_mm"), truth(&scene, "normal_z"));
    assert!(z.iter().zip(up).all(|(z, up)| z * up > 0.0), "outside means upward above and downward below");
    assert!(z.iter().any(|&z| z > 0.0) && z.iter().any(|&z| z < 0.0));
}

#[test]
fn one_file_per_class_will_do() {
    let (vertices, triangles) = ball(8, 1.0);
    let folder =
        Meshes::new().add("ball.obj", obj(&vertices, &triangles)).add("cone.off", off(&vertices, &triangles));
    let scene = folder.add("notes.txt", "by hand").add(".hidden", "").scene().simulate(4, 0, &[]).unwrap();
    assert_eq!(scene.class_names, ["ball", "cone"]);
    assert_eq!(scene.group, [0, 1, 0, 1]);
}

#[test]
fn the_objects_of_a_class_take_turns_however_many_there_are() {
    let sheet = "OFF\n4 1 0\n0 0 0\n1 0 0\n1 1 0\n0 1 0\n4 0 1 2 3\n";
    let names = ["a/1.off", "a/2.off", "b/1.off", "b/2.off", "b/3.off"];
    let folder = names.into_iter().fold(Meshes::new(), |folder, name| folder.add(name, sheet));
    let scene = folder.scene().simulate(8, 0, &[]).unwrap();
    assert_eq!(scene.y, [0, 1, 0, 1, 0, 1, 0, 1]);
    assert_eq!(scene.group, [0, 2, 1, 3, 0, 4, 1, 2]);
}

#[test]
fn bad_meshes_are_refused_by_name() {
    let good = "OFF\n4 1 0\n0 0 0\n1 0 0\n1 1 0\n0 1 0\n4 0 1 2 3\n";
    let refused = |name: &str, content: &[u8]| {
        let error = Meshes::new().add("a/good.off", good).add(&format!("b/{name}"), content).refused();
        assert!(error.starts_with(&format!("b/{name}: ")), "{error}");
        error[name.len() + 4..].to_string()
    };
    for (name, content, reason) in [
        ("no.off", "OFF\n3 0 0\n0 0 0\n1 0 0\n0 1 0\n", "holds no triangles"),
        ("empty.obj", "", "holds no triangles"),
        ("empty.stl", "", "not a readable STL file: "),
        ("nan.off", "OFF\n3 1 0\n0 0 0\n1 nan 0\n0 1 0\n3 0 1 2\n", "vertex 1 is [1.0, NaN, 0.0]"),
        ("nan.obj", "v 0 0 0\nv 1 inf 0\nv 0 1 0\nf 1 2 3\n", "vertex 1 is [1.0, inf, 0.0]"),
        ("index.off", "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 3\n", "triangle 0 is [0, 1, 3] of 3 vertices"),
        (
            "index.obj",
            "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 4\n",
            "not a readable OBJ file: face vertex index out of bounds",
        ),
        ("minus.off", "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 -2\n", "face 0 is \"-2\""),
        ("point.off", "OFF\n3 1 0\n1 1 1\n1 1 1\n1 1 1\n3 0 1 2\n", "is 0 from corner to corner"),
        ("line.off", "OFF\n3 1 0\n0 0 0\n1 0 0\n2 0 0\n3 0 1 2\n", "all triangles are degenerate"),
        ("big.off", "OFF\n3 1 0\n0 0 0\n1e308 0 0\n-1e308 0 0\n3 0 1 2\n", "is inf from corner to corner"),
        ("short.off", "OFF\n3 1 0\n0 0 0\n1 0 0\n", "ends before vertex 2"),
        ("many.off", "OFF\n3 99999999 0\n", "more than 2000000 faces"),
        ("most.off", "OFF\n99999999999 1 0\n", "ends before vertex 0"),
        ("word.off", "COFF\n", "not a readable OFF file: begins with"),
        ("text.stl", "solid x\nfacet normal 0 0 0\nouter loop\nvertex a b c\n", "not a readable STL file"),
    ] {
        let error = refused(name, content.as_bytes());
        assert!(error.starts_with(reason), "{name}: {error}");
        assert!(error.len() > reason.len(), "{name}: no way out in `{error}`");
    }
    let mut cut = stl_binary(&ball(4, 1.0).0, &ball(4, 1.0).1);
    cut[80..84].copy_from_slice(&u32::MAX.to_le_bytes());
    assert!(refused("cut.stl", &cut).starts_with("not a readable STL file"));
    assert!(refused("bytes.off", &[0xff, 0xfe, 0]).starts_with("not a readable OFF file: not text"));
}

#[test]
fn folders_without_meshes_say_what_is_missing() {
    let good = "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n";
    let nowhere = Imprint { meshes: Some(PathBuf::from("/nowhere")), ..small() };
    assert!(
        nowhere
            .simulate(1, 0, &[])
            .unwrap_err()
            .to_string()
            .starts_with("/nowhere: cannot be read as a folder")
    );
    let said =
        |folder: Meshes, words: &str| assert!(folder.refused().contains(words), "{}", folder.refused());
    said(Meshes::new(), "holds no .obj, .stl or .off");
    said(Meshes::new().add("a/good.off", good), "holds one class, `a`");
    said(Meshes::new().add("a/good.off", good).add("b/notes.txt", ""), "b: holds no .obj, .stl or .off");
    said(Meshes::new().add("a/good.off", good).add("b.off", good), "holds both folders and meshes");
    // A needle's eye: nothing but a deep, narrow fold, too large an array.
    let fold = "OFF\n4 2 0\n0 0 0\n0 9 0\n1 4 9\n-1 4 9\n3 0 1 2\n3 1 0 3\n";
    let folder = Meshes::new().add("a/fold.off", fold).add("b/fold.off", fold);
    assert!(folder.scene().simulate(4, 0, &[]).is_ok(), "its outer sides can be felt");
}

#[test]
fn impossible_settings_name_the_key() {
    let refused = |scene: Imprint| scene.simulate(1, 0, &[]).unwrap_err().to_string();
    let default = Imprint::default;
    assert_eq!(refused(Imprint { elements: 0, ..default() }), "elements = 0: must be in 1..=1024");
    assert!(refused(Imprint { elements: 4096, ..default() }).starts_with("elements = 4096"));
    assert!(refused(Imprint { view: 4096, ..default() }).starts_with("view = 4096"));
    assert!(refused(Imprint { pitch_mm: Some(f64::NAN), ..default() }).starts_with("pitch_mm = NaN"));
    assert!(refused(Imprint { depth_mm: 0.0, ..default() }).starts_with("depth_mm = 0"));
    assert!(refused(Imprint { size_mm: -1.0, ..default() }).starts_with("size_mm = -1"));
    assert_eq!(default().simulate(0, 0, &[]).unwrap_err().to_string(), "samples = 0: must be at least 1");
    let read = |json: &str| Settings::read("imprint", &mut serde_json::Deserializer::from_str(json));
    assert_eq!(read(r#"{"elements": 8}"#), Ok(Settings::Imprint(small())));
    let error = read(r#"{"taxels": 8}"#).unwrap_err().to_string();
    assert!(
        error.starts_with("settings of scene imprint: unknown field `taxels`, expected one of `elements`"),
        "{error}"
    );
}

#[test]
#[ignore = "needs TAXEL_DATA"]
fn meshes_of_real_scans_and_models_can_be_felt() {
    let folder = Path::new(&std::env::var("TAXEL_DATA").unwrap()).join("meshes-permissive");
    let scene = Imprint { meshes: Some(folder), view: 24, ..small() }.simulate(44, 0, &[]).unwrap();
    assert_eq!(scene.class_names.len(), 11);
    assert!(scene.x.outer_iter().all(|imprint| imprint.iter().any(|&v| v == 1.0)));
}
