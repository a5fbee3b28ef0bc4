//! Problems of files: those that cannot be read, and those whose content cannot be used.

use super::problem::{Pointer, Problem, suggest};
use super::source::MeshSourceError;
use crate::mesh::{CellKind, MeshError};

/// A table is a file beside the scene: it cannot be uploaded.
pub(super) fn table_not_found(error: &MeshSourceError, here: &Pointer) -> Problem {
    match error {
        MeshSourceError::NotUploaded { .. } => {
            Problem::error("table_not_found", here, "the service accepts meshes, but no tables")
                .limit("absent, in a job of the service")
                .remedy("upload the mesh as .vtu or .vtk with the columns as cell arrays, and omit \"table\"")
        }
        _ => source_problem(error, here),
    }
}

pub(super) fn mesh_problem(error: &MeshError, here: &Pointer) -> Problem {
    let problem = Problem::error("bad_mesh", here, error.to_string());
    match error {
        MeshError::UnsupportedElements { .. } => problem
            .limit(CellKind::ALL.map(|kind| kind.table().title).join(", "))
            .remedy("mesh with cells of these kinds"),
        MeshError::Malformed { .. } => {
            problem.limit("a valid file of its format").remedy("export the file again, or repair it")
        }
        MeshError::Unsupported { what, remedy } => {
            Problem::error("bad_mesh", here, what.clone()).remedy(remedy.clone())
        }
        _ => problem.limit("a mesh of cells with a finite element").remedy("change the mesh"),
    }
}

pub(super) fn scan_problem(error: &MeshError, here: &Pointer) -> Problem {
    let problem = Problem::error("bad_scan", here, error.to_string());
    match error {
        MeshError::Unsupported { what, remedy } => {
            Problem::error("bad_scan", here, what.clone()).remedy(remedy.clone())
        }
        _ => {
            problem.limit("a valid file of its format").remedy("export the labels again, or repair the file")
        }
    }
}

pub(super) fn source_problem(error: &MeshSourceError, here: &Pointer) -> Problem {
    match error {
        MeshSourceError::NotFound { name, known } => {
            let problem = Problem::error("mesh_not_found", here, error.to_string())
                .limit("a mesh file in the folder of the scene");
            if known.is_empty() {
                problem.remedy("put the file into the folder of the scene, which has no mesh yet")
            } else {
                let others = suggest(name, known.iter().map(String::as_str));
                problem.remedy(format!("{others}; copy files from elsewhere into the folder of the scene"))
            }
        }
        MeshSourceError::NotUploaded { .. } => Problem::error("mesh_not_found", here, error.to_string())
            .limit("the id of an uploaded mesh")
            .remedy("upload the file by `POST /v1/meshes` and name the mesh by the id in the answer"),
        MeshSourceError::OneFile { .. } => Problem::error("mesh_in_many_files", here, error.to_string())
            .limit("a mesh in one file")
            .remedy("put everything into one file"),
        MeshSourceError::Outside { .. } => Problem::error("mesh_outside_folder", here, error.to_string())
            .limit("a relative path without \"..\" and without links that leave the folder")
            .remedy("copy the mesh into the folder of the scene"),
        MeshSourceError::TooLarge { limit, .. } => {
            Problem::error("budget_mesh_bytes", here, error.to_string())
                .limit(format!("at most {limit} bytes"))
                .remedy("use a coarser mesh, or a binary format")
        }
        MeshSourceError::Unreadable { .. } => Problem::error("mesh_unreadable", here, error.to_string())
            .limit("a file that can be read")
            .remedy("check the file and its permissions"),
    }
}
