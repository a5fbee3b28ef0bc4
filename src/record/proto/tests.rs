//! The descriptors that are written, and times.

use super::{DECODED, contuse, schema_of, timestamp};
use prost::Message;
use prost_types::FileDescriptorSet;
use std::collections::BTreeSet;

#[test]
fn every_schema_carries_what_it_imports() {
    let mut count = 0;
    for file in &DECODED.file {
        for message in &file.message_type {
            let name = format!("{}.{}", file.package(), message.name());
            let set = FileDescriptorSet::decode(&schema_of(&name).unwrap()[..]).unwrap();
            let mut known = BTreeSet::new();
            for file in &set.file {
                let comes_after = file.dependency.iter().all(|d| known.contains(d));
                assert!(comes_after, "{name}: {} comes too early", file.name());
                known.insert(file.name().to_owned());
            }
            count += 1;
        }
    }
    assert!(count > 20, "only {count} messages");
    assert!(schema_of("foxglove.Nothing").is_err());
}

#[test]
fn the_struct_of_a_mesh_has_the_fields_of_both_messages() {
    let array = |name: &str| Some(contuse::PackedArray { name: name.into(), ..Default::default() });
    let mesh = contuse::ReferenceMesh { hexes: array("h"), cell_nodes: array("n"), ..Default::default() };
    let declared = |name: &str, number: i32| {
        let messages = DECODED.file.iter().flat_map(|file| &file.message_type);
        let mut fields = messages.filter(|message| message.name() == name).flat_map(|message| &message.field);
        fields.any(|field| field.number() == number)
    };
    // Tags of the two fields: numbers 6 and 10, bytes of given length.
    let bytes = mesh.encode_to_vec();
    assert_eq!([bytes[0], bytes[5]], [6 << 3 | 2, 10 << 3 | 2]);
    assert!(declared("ReferenceMesh", 6) && declared("MixedReferenceMesh", 10));
}

#[test]
fn timestamps_are_simulated_time() {
    let t = timestamp(1.25e-4);
    assert_eq!((t.seconds, t.nanos), (0, 125_000));
    assert_eq!(timestamp(-1.0).nanos, 0);
}
