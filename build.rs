//! Writes the structs of the messages of a recording, from the compiled descriptors of `api/recording.proto` and of Foxglove.

use prost::Message;
use prost_types::FileDescriptorSet;

const DESCRIPTORS: &str = "api/recording.fds";

fn main() -> Result<(), Box<dyn std::error::Error>> {
    println!("cargo::rerun-if-changed={DESCRIPTORS}");
    let mut descriptors = FileDescriptorSet::decode(&*std::fs::read(DESCRIPTORS)?)?;
    // The two messages of a mesh are one struct: they have all fields in common but those of the cells.
    let mut messages: Vec<_> = descriptors.file.iter_mut().flat_map(|file| &mut file.message_type).collect();
    let mixed = messages.iter().find(|message| message.name() == "MixedReferenceMesh");
    let fields = mixed.map(|message| message.field.clone()).unwrap_or_default();
    if let Some(mesh) = messages.iter_mut().find(|message| message.name() == "ReferenceMesh") {
        let new =
            fields.into_iter().filter(|field| mesh.field.iter().all(|known| known.number != field.number));
        mesh.field.extend(new.collect::<Vec<_>>());
    }
    prost_build::Config::new().compile_fds(descriptors)?;
    Ok(())
}
