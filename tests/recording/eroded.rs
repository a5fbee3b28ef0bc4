//! A body whose elements erode is drawn without them.

use super::record;
use contuse::record::proto::foxglove::SceneUpdate;
use contuse::scene::{Budget, FolderSource, load};
use prost::Message;
use serde_json::{Value, json};

/// A column of three cubes of a metre, pulled at its upper end, of which the one in the middle tears.
fn column() -> Value {
    let layer = |name: &str| json!({"part": name, "thickness_m": 1.0, "elements": 1});
    let part = |name: &str, c10: f64| {
        json!({"part": name, "density_kg_per_m3": 1000.0,
               "material": {"law": "neo_hookean", "c10_pa": c10, "bulk_modulus_pa": 4.0 * c10}})
    };
    let mut middle = part("middle", 5e3);
    middle["erosion"] = json!({"stretch": 1.3});
    json!({
        "name": "column", "end_time_s": 1.0,
        "bodies": [{
            "name": "column", "fixed": [{"set": "z_min"}],
            "prescribed": [{"set": "z_max", "displacement_m": [0, 0, 1], "ramp": {"kind": "linear", "to_s": 1.0}}],
            "mesh": {"generator": {"kind": "layered_block", "size_m": [1.0, 1.0], "elements": [1, 1],
                                   "layers": [layer("upper"), layer("middle"), layer("lower")]}},
            "parts": [part("upper", 1e6), middle, part("lower", 1e6)]
        }],
        "record": {"fields": ["von_mises"], "field_times_s": [0.0, 1.0]},
        "solver": {"error_bars": "none"}
    })
}

#[test]
fn faces_that_erosion_exposes_are_drawn_and_those_of_the_element_are_not() {
    let text = column().to_string();
    let loaded = load(text.as_bytes(), &FolderSource::new("."), &Budget::COMMAND_LINE).unwrap();
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("run.mcap");
    record(&(text, loaded), &path, 1, &|_| None);
    let bytes = std::fs::read(&path).unwrap();
    let messages = mcap::MessageStream::new(&bytes).unwrap().map(Result::unwrap);
    let drawn = messages.filter(|message| message.channel.topic == "/mesh/column").map(|message| {
        let update = SceneUpdate::decode(&*message.data).unwrap();
        let mesh = &update.entities[0].triangles[0];
        assert_eq!(mesh.colors.len(), mesh.points.len());
        let highest = *mesh.indices.iter().max().unwrap() as usize;
        assert_eq!(highest + 1, mesh.points.len());
        (mesh.points.len(), mesh.indices.len() / 3)
    });
    // A column has fourteen faces, two cubes have twelve.
    assert_eq!(drawn.collect::<Vec<_>>(), [(16, 28), (16, 24)]);
}
