"""Compiles api/recording.proto, api/mixed_mesh.proto and the Foxglove schemas to api/recording.fds, the descriptors that every recording carries.

    python tests/python/compile_schemas.py           writes api/recording.fds
    python tests/python/compile_schemas.py --check   fails when api/recording.fds is not what the .proto files say, or
                                                     api/foxglove/ is not what Foxglove publishes on PyPI
"""

import importlib
import pathlib
import sys
import tempfile

import grpc_tools
from google.protobuf import descriptor_pb2
from grpc_tools import protoc

API = pathlib.Path(__file__).resolve().parents[2] / "api"
ROOTS = ["recording.proto", "mixed_mesh.proto", "foxglove/SceneUpdate.proto", "foxglove/PointCloud.proto", "foxglove/Log.proto"]


def compile_schemas() -> descriptor_pb2.FileDescriptorSet:
    """The descriptors of all messages of a recording, dependencies before their dependents."""
    well_known = pathlib.Path(grpc_tools.__file__).parent / "_proto"
    with tempfile.TemporaryDirectory() as folder:
        out = pathlib.Path(folder) / "recording.fds"
        arguments = [f"-I{API}", f"-I{well_known}", "--include_imports", f"--descriptor_set_out={out}", *ROOTS]
        if protoc.main(["protoc", *arguments]) != 0:
            raise SystemExit("protoc failed")
        return descriptor_pb2.FileDescriptorSet.FromString(out.read_bytes())


def normalised(files: descriptor_pb2.FileDescriptorSet) -> dict[str, bytes]:
    """What the files say, by name."""
    return {file.name: file.SerializeToString(deterministic=True) for file in files.file}


def check_foxglove(files: descriptor_pb2.FileDescriptorSet) -> int:
    """Compares names, numbers and types with the published schemas; the number of messages compared."""
    count = 0
    for file in files.file:
        if file.package != "foxglove":
            continue
        stem = pathlib.PurePosixPath(file.name).stem
        published = descriptor_pb2.FileDescriptorProto()
        importlib.import_module(f"foxglove_schemas_protobuf.{stem}_pb2").DESCRIPTOR.CopyToProto(published)
        for ours, theirs in zip(file.message_type, published.message_type, strict=True):
            for message in (ours, theirs):
                for field in message.field:
                    field.ClearField("json_name")  # protoc fills it in, the package may not
            if ours != theirs:
                raise SystemExit(f"foxglove.{ours.name} is not what is published")
            count += 1
    return count


def main() -> None:
    compiled, path = compile_schemas(), API / "recording.fds"
    if sys.argv[1:] == ["--check"]:
        held = descriptor_pb2.FileDescriptorSet.FromString(path.read_bytes())
        if normalised(held) != normalised(compiled):
            raise SystemExit(f"{path} is not what the .proto files say: run {__file__}")
        print(f"{path.name}: {len(held.file)} files agree with their text")
        print(f"api/foxglove: {check_foxglove(compiled)} messages agree with foxglove-schemas-protobuf")
    else:
        path.write_bytes(compiled.SerializeToString(deterministic=True))
        print(f"{path}: {len(compiled.file)} files, {path.stat().st_size} bytes")


if __name__ == "__main__":
    main()
