//! Whatever is in a mesh file, reading it ends with a sound mesh or with an error: it never panics, and it never makes room for
//! what a file merely claims to hold.

use crate::file_changes::{apply, change};
use contuse::mechanics::tensor::Vec3;
use contuse::mesh::Mesh;
use contuse::mesh::generate::block::Block;
use contuse::mesh::read::{MeshFormat, read_mesh};
use contuse::mesh::write::gmsh::{Encoding, Version, write_gmsh};
use proptest::prelude::*;
use std::sync::LazyLock;

/// A file of every format and encoding: a block of a few elements with its node sets.
static FILES: LazyLock<Vec<(MeshFormat, Vec<u8>)>> = LazyLock::new(|| {
    let block = Block::uniform(Vec3::zeros(), Vec3::repeat(0.01), [2, 3, 1], "block").generate().unwrap();
    let mut files = Vec::new();
    for version in [Version::V2_2, Version::V4_1] {
        for encoding in [Encoding::Ascii, Encoding::LittleEndian, Encoding::BigEndian] {
            files.push((MeshFormat::Gmsh, write_gmsh(&block, version, encoding)));
        }
    }
    files.push((MeshFormat::Abaqus, abaqus(&block).into_bytes()));
    files
});

/// The mesh as an Abaqus file, with sets by list and by range.
fn abaqus(mesh: &Mesh) -> String {
    let mut text = "*HEADING\n a block\n** a comment\n*NODE, NSET=all\n".to_owned();
    for (i, x) in mesh.nodes.iter().enumerate() {
        text += &format!("{}, {:e}, {:e}, {:e}\n", i + 1, x.x, x.y, x.z);
    }
    text += "*ELEMENT, TYPE=C3D8, ELSET=block\n";
    for (i, cell) in mesh.cells.iter().enumerate() {
        let nodes: Vec<String> = cell.nodes.iter().map(|node| (node + 1).to_string()).collect();
        text += &format!("{}, {}\n", i + 1, nodes.join(", "));
    }
    text += "*NSET, NSET=some\n1, 2, 3\n*NSET, NSET=range, GENERATE\n1, 7, 2\n*ELSET, ELSET=part\n1, 2\n";
    text + "*SOLID SECTION, ELSET=block, MATERIAL=m\n*MATERIAL, NAME=m\n*ELASTIC\n1000, 0.3\n*STEP\n*END STEP\n"
}

/// What every mesh keeps to, whatever it was read from.
fn check(format: MeshFormat, bytes: &[u8]) -> Result<(), TestCaseError> {
    match read_mesh(bytes, format) {
        Ok(mesh) => {
            let nodes = mesh.nodes.len();
            prop_assert!(!mesh.cells.is_empty() && mesh.part_of.len() == mesh.cells.len());
            prop_assert!(mesh.nodes.iter().all(|x| x.iter().all(|c| c.is_finite())));
            prop_assert!(mesh.cells.connectivity().iter().all(|node| (*node as usize) < nodes));
            // A file has some bytes for each node.
            prop_assert!(nodes <= bytes.len());
        }
        Err(error) => prop_assert!(!error.to_string().is_empty()),
    }
    Ok(())
}

#[test]
fn the_files_are_read_as_they_are() {
    for (format, bytes) in FILES.iter() {
        let mesh = read_mesh(bytes, *format).unwrap();
        assert_eq!((mesh.nodes.len(), mesh.cells.len()), (24, 6));
    }
}

proptest! {
    #[test]
    fn a_changed_file_is_read_or_refused(
        file in any::<prop::sample::Index>(),
        changes in prop::collection::vec(change(), 1..5),
    ) {
        let (format, bytes) = file.get(&FILES);
        let mut bytes = bytes.clone();
        for change in changes {
            apply(&mut bytes, change);
        }
        check(*format, &bytes)?;
    }

    #[test]
    fn a_file_in_the_wrong_format_is_refused(
        file in any::<prop::sample::Index>(),
        format in prop::sample::select(MeshFormat::ALL.to_vec()),
        length in any::<prop::sample::Index>(),
    ) {
        let (_, bytes) = file.get(&FILES);
        check(format, &bytes[..length.index(bytes.len())])?;
    }
}
