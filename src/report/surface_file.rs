//! Surfaces as files of triangles: STL and PLY, both binary and in metres.

use super::surface::{BodySurface, Surfaces};
use std::io::{self, Write};

/// Length of the header of an STL file [bytes].
const STL_HEADER: usize = 80;

/// Writes all bodies as one binary STL file: 80 bytes of text, the number of triangles, and for each its normal and
/// corners as f32.
///
/// # Errors
/// If writing fails.
pub fn write_stl(surfaces: &Surfaces, out: &mut dyn Write) -> io::Result<()> {
    let mut header = [b' '; STL_HEADER];
    let text = format!("Contuse: deformed surfaces at {:e} s, in metres", surfaces.time_s);
    header[..text.len()].copy_from_slice(text.as_bytes());
    out.write_all(&header)?;
    out.write_all(&(triangle_count(surfaces) as u32).to_le_bytes())?;
    for body in &surfaces.bodies {
        for triangle in &body.triangles {
            let corners = triangle.map(|corner| body.positions[corner as usize]);
            std::iter::once(normal(&corners)).chain(corners).try_for_each(|x| put(x, out))?;
            // The unused attribute.
            out.write_all(&[0; 2])?;
        }
    }
    Ok(())
}

/// Writes all bodies as one binary PLY file: corners as f32, and triangles with the number of their body.
///
/// # Errors
/// If writing fails.
pub fn write_ply(surfaces: &Surfaces, out: &mut dyn Write) -> io::Result<()> {
    writeln!(out, "ply\nformat binary_little_endian 1.0")?;
    writeln!(out, "comment Contuse: deformed surfaces at {:e} s, in metres", surfaces.time_s)?;
    for (i, body) in surfaces.bodies.iter().enumerate() {
        writeln!(out, "comment body {i}: {}", body.name.replace(char::is_control, " "))?;
    }
    let corners: usize = surfaces.bodies.iter().map(|body| body.positions.len()).sum();
    writeln!(out, "element vertex {corners}\nproperty float x\nproperty float y\nproperty float z")?;
    writeln!(
        out,
        "element face {}\nproperty list uchar int vertex_indices\nproperty int body\nend_header",
        triangle_count(surfaces)
    )?;
    surfaces.bodies.iter().flat_map(|body| &body.positions).try_for_each(|&x| put(x, out))?;
    let mut first = 0;
    for (number, BodySurface { positions, triangles, .. }) in (0_u32..).zip(&surfaces.bodies) {
        for triangle in triangles {
            out.write_all(&[3])?;
            let numbers = triangle.map(|corner| first + corner).into_iter().chain([number]);
            numbers.map(u32::to_le_bytes).try_for_each(|bytes| out.write_all(&bytes))?;
        }
        first += positions.len() as u32;
    }
    Ok(())
}

fn triangle_count(surfaces: &Surfaces) -> usize {
    surfaces.bodies.iter().map(|body| body.triangles.len()).sum()
}

fn put(x: [f32; 3], out: &mut dyn Write) -> io::Result<()> {
    x.iter().try_for_each(|x| out.write_all(&x.to_le_bytes()))
}

/// Unit normal by the right-hand rule; zero for a triangle without area.
fn normal(corners: &[[f32; 3]; 3]) -> [f32; 3] {
    let [a, b, c] = corners.map(|x| x.map(f64::from));
    let (u, v): ([f64; 3], [f64; 3]) =
        (std::array::from_fn(|i| b[i] - a[i]), std::array::from_fn(|i| c[i] - a[i]));
    let n = [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]];
    let length = n.iter().map(|x| x * x).sum::<f64>().sqrt();
    if length > 0.0 { n.map(|x| (x / length) as f32) } else { [0.0; 3] }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn triangle() -> Surfaces {
        let body = BodySurface {
            name: "a\nb".into(),
            positions: vec![[0.0; 3], [2.0, 0.0, 0.0], [0.0, 3.0, 0.0]],
            triangles: vec![[0, 1, 2]],
        };
        Surfaces { time_s: 5e-4, bodies: vec![body.clone(), body] }
    }

    #[test]
    fn an_stl_file_is_header_count_and_triangles() {
        let mut file = Vec::new();
        write_stl(&triangle(), &mut file).unwrap();
        assert_eq!(file.len(), 80 + 4 + 2 * 50);
        assert!(
            file.starts_with(b"Contuse: deformed surfaces at 5e-4 s") && file[80..84] == 2u32.to_le_bytes()
        );
        let numbers: Vec<f32> =
            file[84..84 + 48].as_chunks().0.iter().map(|b| f32::from_le_bytes(*b)).collect();
        assert_eq!(numbers, [0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 2.0, 0.0, 0.0, 0.0, 3.0, 0.0]);
    }

    #[test]
    fn a_ply_file_numbers_corners_across_bodies() {
        let mut file = Vec::new();
        write_ply(&triangle(), &mut file).unwrap();
        let end = file.windows(11).position(|w| w == b"end_header\n").unwrap() + 11;
        let header = std::str::from_utf8(&file[..end]).unwrap();
        assert!(
            header.contains("comment body 1: a b\n") && header.contains("element vertex 6\n"),
            "{header}"
        );
        assert!(header.contains("element face 2\n"), "{header}");
        assert_eq!(file.len(), end + 6 * 12 + 2 * 17);
        let last: Vec<u32> =
            file[file.len() - 16..].as_chunks().0.iter().map(|b| u32::from_le_bytes(*b)).collect();
        assert_eq!(last, [3, 4, 5, 1]);
    }
}
