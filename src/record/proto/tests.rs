//! Compares the structs with the descriptors: the encoding must match the schema, and for Contuse's own messages cover
//! all of it.

use super::contuse::{
    BodyEnergy, BranchEnergy, ContactForces, DepthAbove, Energy, NumberError, PackedArray, PairEnergy,
    PairForces, ReferenceMesh, RigidPose, Stress, Summary,
};
use super::foxglove::{
    Color, KeyValuePair, Level, Log, NumericType, PackedElementField, Point3, PointCloud, Pose, Quaternion,
    SceneEntity, SceneUpdate, TriangleListPrimitive, Vector3, timestamp,
};
use super::{DESCRIPTORS, schema_of};
use prost::Message;
use prost_types::field_descriptor_proto::{Label, Type};
use prost_types::{DescriptorProto, FileDescriptorSet};
use std::collections::{BTreeMap, BTreeSet};

/// All messages by full name.
fn messages() -> BTreeMap<String, DescriptorProto> {
    let files = FileDescriptorSet::decode(DESCRIPTORS).unwrap().file;
    let named = |file: prost_types::FileDescriptorProto| {
        let package = file.package().to_owned();
        file.message_type.into_iter().map(move |m| (format!(".{package}.{}", m.name()), m))
    };
    files.into_iter().flat_map(named).collect()
}

/// Decodes one base-128 number.
fn varint(bytes: &mut &[u8]) -> u64 {
    prost::encoding::decode_varint(bytes).unwrap()
}

fn take<'a>(bytes: &mut &'a [u8], count: usize) -> &'a [u8] {
    let (head, tail) = bytes.split_at(count);
    *bytes = tail;
    head
}

/// Walks through an encoded message and checks every tag against the schema; collects "message.field" of all fields
/// found.
fn walk(mut bytes: &[u8], name: &str, all: &BTreeMap<String, DescriptorProto>, seen: &mut BTreeSet<String>) {
    let schema = &all[name];
    while !bytes.is_empty() {
        let key = varint(&mut bytes);
        let (number, wire) = ((key >> 3) as i32, key & 7);
        let field = schema.field.iter().find(|f| f.number() == number);
        let field = field.unwrap_or_else(|| panic!("{name} has no field {number}"));
        seen.insert(format!("{name}.{}", field.name()));
        let expected = match field.r#type() {
            Type::Double => 1,
            Type::Fixed32 if field.label() == Label::Repeated => 2,
            Type::Fixed32 => 5,
            Type::Message | Type::String | Type::Bytes => 2,
            Type::Uint32 | Type::Uint64 | Type::Int32 | Type::Int64 | Type::Bool | Type::Enum => 0,
            other => panic!("{name}.{}: {other:?} is not used", field.name()),
        };
        assert_eq!(wire, expected, "{name}.{}", field.name());
        match wire {
            0 => _ = varint(&mut bytes),
            1 => _ = take(&mut bytes, 8),
            5 => _ = take(&mut bytes, 4),
            _ => {
                let length = varint(&mut bytes) as usize;
                let inner = take(&mut bytes, length);
                if field.r#type() == Type::Message {
                    walk(inner, field.type_name(), all, seen);
                }
            }
        }
    }
}

fn array() -> PackedArray {
    PackedArray {
        name: "a".into(),
        dtype: "f32".into(),
        count: 1,
        components: 1,
        unit: "m".into(),
        data: vec![0; 4],
    }
}

fn vector() -> Vector3 {
    Vector3 { x: 1.0, y: 2.0, z: 3.0 }
}

/// One message of each kind without default values.
fn examples() -> Vec<(&'static str, Vec<u8>)> {
    let pair = PairForces {
        pair: "p".into(),
        slave_body: "s".into(),
        master_body: "m".into(),
        force_n: Some(vector()),
        force_norm_n: 1.0,
        impulse_n_s: Some(vector()),
        impulse_norm_n_s: 1.0,
        patch_area_m2: 1.0,
        patch_long_axis_m: 1.0,
        patch_short_axis_m: 1.0,
        peak_pressure_pa: 1.0,
        patch_nodes: 1,
        nodes_across_patch: 1,
        contacts: vec![array()],
    };
    let body = BodyEnergy {
        body: "b".into(),
        kinetic_j: 1.0,
        strain_j: 1.0,
        viscous_j: 1.0,
        contact_work_j: 1.0,
        external_work_j: 1.0,
        projection_j: 1.0,
        hourglass_j: 1.0,
        branches_j: 1.0,
        eroded_j: 1.0,
        algorithmic_j: 1.0,
        branches: vec![BranchEnergy { relaxation_time_s: 1.0, stored_j: 1.0, dissipated_j: 1.0 }],
    };
    let pair_energy = PairEnergy {
        pair: "p".into(),
        friction_j: 1.0,
        numerical_contact_j: 1.0,
        work_on_slave_j: 1.0,
        work_on_master_j: 1.0,
        impact_j: 1.0,
    };
    let energy = Energy {
        time_s: 1.0,
        step: 1,
        bodies: vec![body],
        pairs: vec![pair_energy],
        total_j: 1.0,
        initial_total_j: 1.0,
        external_work_j: 1.0,
        balance_error: 1.0,
        absorbed_by_tissue_j: 1.0,
        absorbed_by_tissue_work_j: 1.0,
        momentum_kg_m_per_s: Some(vector()),
        angular_momentum_kg_m2_per_s: Some(vector()),
    };
    let stress =
        Stress { time_s: 1.0, step: 1, body: "b".into(), nodal: vec![array()], element: vec![array()] };
    let reference = ReferenceMesh {
        time_s: 1.0,
        body: "b".into(),
        role: "tissue".into(),
        parts: vec!["p".into()],
        positions: Some(array()),
        hexes: Some(array()),
        part_of: Some(array()),
        flight_velocity_m_per_s: Some(vector()),
        cell_types: None,
        cell_nodes: None,
    };
    let mixed = ReferenceMesh {
        hexes: None,
        cell_types: Some(array()),
        cell_nodes: Some(array()),
        ..reference.clone()
    };
    let pose = RigidPose {
        time_s: 1.0,
        step: 1,
        body: "b".into(),
        position_m: Some(vector()),
        orientation: Some(Quaternion { x: 0.1, y: 0.1, z: 0.1, w: 1.0 }),
        role: "other".into(),
    };
    vec![
        (
            "contuse.v1.ContactForces",
            ContactForces { time_s: 1.0, step: 1, pairs: vec![pair] }.encode_to_vec(),
        ),
        ("contuse.v1.Energy", energy.encode_to_vec()),
        ("contuse.v1.Stress", stress.encode_to_vec()),
        ("contuse.v1.ReferenceMesh", reference.encode_to_vec()),
        ("contuse.v1.MixedReferenceMesh", mixed.encode_to_vec()),
        ("contuse.v1.RigidPose", pose.encode_to_vec()),
        ("contuse.v1.Summary", summary().encode_to_vec()),
    ]
}

fn summary() -> Summary {
    let error = Some(NumberError { half_width: 1.0, resolved: true });
    let depth = DepthAbove {
        threshold_pa: 1.0,
        depth_m: 1.0,
        volume_m3: 1.0,
        depth_error: error,
        volume_error: error,
    };
    Summary {
        time_s: 1.0,
        step: 1,
        withheld: true,
        peak_force_n: 1.0,
        impulse_n_s: 1.0,
        patch_area_m2: 1.0,
        absorbed_energy_j: 1.0,
        balance_error: 1.0,
        numerical_contact_dissipation_j: 1.0,
        depths: vec![depth],
        json: "{}".into(),
        peak_force_error: error,
        impulse_error: error,
        patch_area_error: error,
        absorbed_energy_error: error,
    }
}

fn foxglove_examples() -> Vec<(&'static str, Vec<u8>)> {
    let color = Color { r: 0.1, g: 0.2, b: 0.3, a: 1.0 };
    let orientation = Some(Quaternion { x: 0.1, y: 0.1, z: 0.1, w: 1.0 });
    let triangles = TriangleListPrimitive {
        pose: Some(Pose { position: Some(vector()), orientation }),
        points: vec![Point3 { x: 1.0, y: 2.0, z: 3.0 }],
        color: Some(color),
        colors: vec![color],
        indices: vec![1, 2, 3],
    };
    let entity = SceneEntity {
        timestamp: Some(timestamp(1.5)),
        frame_id: "world".into(),
        id: "b".into(),
        metadata: vec![KeyValuePair { key: "k".into(), value: "v".into() }],
        triangles: vec![triangles],
    };
    let field = PackedElementField { name: "x".into(), offset: 4, r#type: NumericType::Float32.into() };
    let cloud = PointCloud {
        timestamp: Some(timestamp(1.5)),
        frame_id: "world".into(),
        pose: Some(Pose::identity()),
        point_stride: 4,
        fields: vec![field],
        data: vec![0; 4],
    };
    let log = Log {
        timestamp: Some(timestamp(1.5)),
        level: Level::Error.into(),
        message: "m".into(),
        name: "n".into(),
    };
    vec![
        ("foxglove.SceneUpdate", SceneUpdate { entities: vec![entity] }.encode_to_vec()),
        ("foxglove.PointCloud", cloud.encode_to_vec()),
        ("foxglove.Log", log.encode_to_vec()),
    ]
}

#[test]
fn own_messages_are_exactly_their_schema() {
    let all = messages();
    let mut seen = BTreeSet::new();
    for (name, bytes) in examples() {
        walk(&bytes, &format!(".{name}"), &all, &mut seen);
    }
    let own = all.iter().filter(|(name, _)| name.starts_with(".contuse."));
    let wanted =
        own.flat_map(|(name, m)| m.field.iter().map(move |f| format!("{name}.{}", f.name()))).collect();
    let seen: BTreeSet<String> = seen.into_iter().filter(|name| name.starts_with(".contuse.")).collect();
    assert_eq!(seen, wanted);
}

#[test]
fn foxglove_messages_fit_their_schema() {
    let (all, mut seen) = (messages(), BTreeSet::new());
    for (name, bytes) in foxglove_examples() {
        walk(&bytes, &format!(".{name}"), &all, &mut seen);
    }
    for field in
        ["SceneEntity.triangles", "PackedElementField.type", "Log.level", "TriangleListPrimitive.indices"]
    {
        assert!(seen.contains(&format!(".foxglove.{field}")), "{field}");
    }
}

#[test]
fn enumerations_have_the_numbers_of_foxglove() {
    let all = messages();
    let value = |message: &str, name: &str| {
        let values = all[message].enum_type.iter().flat_map(|e| &e.value);
        values.clone().find(|v| v.name() == name).map(prost_types::EnumValueDescriptorProto::number).unwrap()
    };
    assert_eq!(value(".foxglove.PackedElementField", "FLOAT32"), NumericType::Float32 as i32);
    for (name, level) in [("INFO", Level::Info), ("WARNING", Level::Warning), ("ERROR", Level::Error)] {
        assert_eq!(value(".foxglove.Log", name), level as i32);
    }
}

#[test]
fn every_schema_carries_what_it_imports() {
    for (name, _) in examples().into_iter().chain(foxglove_examples()) {
        let set = FileDescriptorSet::decode(&schema_of(name).unwrap()[..]).unwrap();
        let mut known = BTreeSet::new();
        for file in &set.file {
            assert!(
                file.dependency.iter().all(|d| known.contains(d)),
                "{name}: {} comes too early",
                file.name()
            );
            known.insert(file.name().to_owned());
        }
    }
    assert!(schema_of("foxglove.Nothing").is_err());
}

#[test]
fn timestamps_are_simulated_time() {
    let t = timestamp(1.25e-4);
    assert_eq!((t.seconds, t.nanos), (0, 125_000));
    assert_eq!(timestamp(-1.0).nanos, 0);
}
