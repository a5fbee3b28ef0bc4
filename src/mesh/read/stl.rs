//! STL: the triangles of a closed surface, ASCII or binary. Corners at the same place are one point; normals in the file are not used.

use super::cursor::{Cursor, Numbers, place_of, shown};
use super::stl_shells::{inside_out, shells};
use crate::mechanics::tensor::Vec3;
use crate::mesh::{MeshError, Place};
use std::collections::{BTreeMap, HashMap};

/// Bytes before the triangles of a binary file, and of one triangle.
const HEADER: usize = 84;
const TRIANGLE: usize = 50;

/// A closed surface, counter-clockwise seen from outside, in the unit of the file.
#[derive(Clone, Debug, PartialEq)]
pub struct ClosedSurface {
    /// Positions of its points, in the unit of the file.
    pub points: Vec<Vec3>,
    /// Corners of its triangles.
    pub triangles: Vec<[u32; 3]>,
}

impl ClosedSurface {
    /// The surface with all coordinates times a factor > 0.
    #[must_use]
    pub fn scaled(mut self, scale: f64) -> Self {
        self.points.iter_mut().for_each(|x| *x *= scale);
        self
    }

    /// Lower and upper corner of the bounding box, in the unit of the file.
    pub fn bounding_box(&self) -> [Vec3; 2] {
        let corner = |fold: fn(&Vec3, &Vec3) -> Vec3| {
            self.points.iter().copied().reduce(|a, b| fold(&a, &b)).unwrap_or_default()
        };
        [corner(Vec3::inf), corner(Vec3::sup)]
    }

    /// Area, in the square of the unit of the file.
    pub fn area(&self) -> f64 {
        let of_triangle = |triangle: &[u32; 3]| {
            let [a, b, c] = triangle.map(|node| self.points[node as usize]);
            0.5 * (b - a).cross(&(c - a)).norm()
        };
        self.triangles.iter().map(of_triangle).sum()
    }

    /// Enclosed volume, in the cube of the unit of the file: the sum of signed tetrahedra over the triangles.
    pub fn volume(&self) -> f64 {
        let of_triangle = |triangle: &[u32; 3]| {
            let [a, b, c] = triangle.map(|node| self.points[node as usize] - self.points[0]);
            a.dot(&b.cross(&c)) / 6.0
        };
        self.triangles.iter().map(of_triangle).sum()
    }
}

/// Number of triangles that the header of a binary file announces.
fn announced(bytes: &[u8]) -> Option<usize> {
    let count = bytes.get(HEADER - 4..HEADER)?.first_chunk::<4>()?;
    Some(u32::from_le_bytes(*count) as usize)
}

/// Whether a file begins as STL does; binary files are recognised by their length.
pub fn begins(bytes: &[u8]) -> bool {
    is_binary(bytes) || bytes.trim_ascii_start().starts_with(b"solid")
}

fn is_binary(bytes: &[u8]) -> bool {
    announced(bytes).and_then(|count| count.checked_mul(TRIANGLE)?.checked_add(HEADER)) == Some(bytes.len())
}

/// Reads a closed surface. A surface that is inside out as a whole is turned.
///
/// # Errors
/// `Malformed`, with its place, for a file that is no STL, is truncated, or has a coordinate that is not finite; `Unsupported` for
/// a surface that is open, or whose triangles are not turned to the same side.
pub fn read_stl(bytes: &[u8]) -> Result<ClosedSurface, MeshError> {
    let mut corners = Corners::default();
    let is_text = !is_binary(bytes) && bytes.trim_ascii_start().starts_with(b"solid");
    if is_text {
        read_text(bytes, &mut corners)?;
    } else {
        read_binary(bytes, &mut corners)?;
    }
    let numbers = if is_text { Numbers::Text } else { Numbers::LittleEndian };
    corners.into_surface(|offset| place_of(bytes, offset, numbers))
}

fn read_binary(bytes: &[u8], corners: &mut Corners) -> Result<(), MeshError> {
    let mut cursor = Cursor::new(bytes);
    cursor.numbers = Numbers::LittleEndian;
    let count = announced(bytes).ok_or_else(|| cursor.error("an STL file has at least 84 bytes"))?;
    let found = bytes.len() - HEADER;
    if found / TRIANGLE != count || !found.is_multiple_of(TRIANGLE) {
        let message =
            format!("the header announces {count} triangles of {TRIANGLE} bytes, and {found} bytes follow");
        return Err(cursor.error_at(HEADER - 4, message));
    }
    cursor.take(HEADER, "the header")?;
    for _ in 0..count {
        let place = cursor.offset();
        let triangle = cursor.take(TRIANGLE, "a triangle")?;
        let (numbers, _) = triangle.as_chunks::<4>();
        let number = |i: usize| f64::from(f32::from_le_bytes(numbers[i]));
        // The first three are the normal.
        let points = [3, 6, 9].map(|i| Vec3::new(number(i), number(i + 1), number(i + 2)));
        corners.add(points, place).map_err(|message| cursor.error_at(place, message))?;
    }
    Ok(())
}

fn read_text(bytes: &[u8], corners: &mut Corners) -> Result<(), MeshError> {
    let mut cursor = Cursor::new(bytes);
    while !cursor.at_end() {
        // A name may follow, of any words.
        expect(&mut cursor, "solid")?;
        cursor.line();
        loop {
            let start = cursor.offset();
            match word(&mut cursor).as_str() {
                "endsolid" => break,
                "facet" => {}
                other => {
                    let message = format!("expected facet or endsolid, found {}", shown(other.as_bytes()));
                    return Err(cursor.error_at(start, message));
                }
            }
            expect(&mut cursor, "normal")?;
            // It may be anything: it is not used.
            (0..3).for_each(|_| drop(word(&mut cursor)));
            expect(&mut cursor, "outer")?;
            expect(&mut cursor, "loop")?;
            let mut points = [Vec3::zeros(); 3];
            for point in &mut points {
                expect(&mut cursor, "vertex")?;
                for i in 0..3 {
                    point[i] = cursor.parsed::<f64>("a coordinate")?;
                }
            }
            corners.add(points, start).map_err(|message| cursor.error_at(start, message))?;
            expect(&mut cursor, "endloop")?;
            expect(&mut cursor, "endfacet")?;
        }
        cursor.line();
    }
    Ok(())
}

/// The next word, in lower case; empty at the end of the file.
fn word(cursor: &mut Cursor) -> String {
    String::from_utf8_lossy(cursor.word()).to_ascii_lowercase()
}

fn expect(cursor: &mut Cursor, expected: &str) -> Result<(), MeshError> {
    let start = cursor.offset();
    let found = word(cursor);
    if found == expected {
        return Ok(());
    }
    Err(cursor.error_at(start, format!("expected {expected}, found {}", shown(found.as_bytes()))))
}

/// Triangles with corners at the same place merged.
#[derive(Default)]
struct Corners {
    points: Vec<Vec3>,
    /// Index of each place, by its bits; only looked up.
    index: HashMap<[u64; 3], u32>,
    triangles: Vec<[u32; 3]>,
    /// Byte offset of each triangle.
    offsets: Vec<usize>,
}

impl Corners {
    /// Adds a triangle at a byte offset; one without an area, of two corners at one place, is omitted.
    fn add(&mut self, points: [Vec3; 3], offset: usize) -> Result<(), String> {
        if !points.iter().flatten().all(|x| x.is_finite()) {
            return Err("a triangle has a coordinate that is not finite".into());
        }
        let mut place = |x: Vec3| {
            // Zero of either sign is one place.
            let key = [x.x + 0.0, x.y + 0.0, x.z + 0.0].map(f64::to_bits);
            *self.index.entry(key).or_insert_with(|| {
                self.points.push(x);
                self.points.len() as u32 - 1
            })
        };
        let [a, b, c] = points.map(&mut place);
        if a != b && b != c && c != a {
            self.triangles.push([a, b, c]);
            self.offsets.push(offset);
        }
        Ok(())
    }

    /// The surface; `place` names the place of a byte offset.
    fn into_surface(self, place: impl Fn(usize) -> Place) -> Result<ClosedSurface, MeshError> {
        let Self { points, triangles, offsets, .. } = self;
        if triangles.is_empty() {
            return Err(MeshError::Unsupported {
                what: format!("{}: the surface has no triangle with an area", place(0)),
                remedy: "export the surface again".into(),
            });
        }
        if let Some(at) = repeated(&triangles) {
            return Err(MeshError::Unsupported {
                what: format!("{}: the surface has a triangle twice", place(offsets[at])),
                remedy: "remove the duplicates, as Remove Duplicate Faces in MeshLab does".into(),
            });
        }
        // Every edge is passed as often in one direction as in the other.
        let mut passes: BTreeMap<[u32; 2], [u32; 2]> = BTreeMap::new();
        for [a, b, c] in &triangles {
            for (from, to) in [(*a, *b), (*b, *c), (*c, *a)] {
                passes.entry([from.min(to), from.max(to)]).or_default()[usize::from(from > to)] += 1;
            }
        }
        let uneven = || passes.iter().filter(|(_, [there, back])| there != back);
        if let Some((edge, [there, back])) = uneven().next() {
            let [a, b] = edge.map(|node| points[node as usize].map(|x| format!("{x}")).as_slice().join(", "));
            let count = uneven().count();
            let has_both = |triangle: &[u32; 3]| edge.iter().all(|node| triangle.contains(node));
            let at = triangles.iter().position(has_both).map_or(0, |first| offsets[first]);
            let (what, remedy) = if (there + back) % 2 == 1 {
                (
                    "is open",
                    "close its holes, as `fill_holes(1e9)` of PyVista does with simple ones, or take its hull by `delaunay_3d().extract_surface()`",
                )
            } else {
                (
                    "is not consistently oriented",
                    "orient its triangles consistently, as `compute_normals` of PyVista does",
                )
            };
            return Err(MeshError::Unsupported {
                what: format!(
                    "{}: the surface {what} at {count} edges, the first from ({a}) to ({b})",
                    place(at)
                ),
                remedy: remedy.into(),
            });
        }
        let mut surface = ClosedSurface { points, triangles };
        let mut all = shells(&surface.points, &surface.triangles);
        // The largest shell is turned outwards.
        if all.iter().max_by(|a, b| a.volume.abs().total_cmp(&b.volume.abs())).is_some_and(|s| s.volume < 0.0)
        {
            surface.triangles.iter_mut().for_each(|[_, b, c]| std::mem::swap(b, c));
            for shell in &mut all {
                shell.volume = -shell.volume;
            }
        }
        match inside_out(&all) {
            Some(shell) => Err(MeshError::Unsupported {
                what: format!(
                    "{}: an outer part of the surface is oriented inwards",
                    place(offsets[shell.triangle])
                ),
                remedy: "reverse the triangles of that part".into(),
            }),
            None => Ok(surface),
        }
    }
}

/// A triangle that is there before, turned to the same side.
fn repeated(triangles: &[[u32; 3]]) -> Option<usize> {
    let mut from_least: Vec<([u32; 3], usize)> = triangles.iter().copied().zip(0..).collect();
    for (triangle, _) in &mut from_least {
        let least = (0..3).min_by_key(|&i| triangle[i]).unwrap_or(0);
        triangle.rotate_left(least);
    }
    from_least.sort_unstable();
    from_least.windows(2).find(|pair| pair[0].0 == pair[1].0).map(|pair| pair[1].1)
}

#[cfg(test)]
#[allow(clippy::unwrap_used)] // tests may panic
mod tests {
    use super::*;

    /// A tetrahedron with its faces outwards, or inwards.
    fn faces(outwards: bool) -> Vec<[[f32; 3]; 3]> {
        let x = [[0.0, 0.0, 0.0], [3.0, 0.0, 0.0], [0.0, 3.0, 0.0], [0.0, 0.0, 3.0]];
        let turned = [[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]];
        turned.map(|[a, b, c]| if outwards { [x[a], x[b], x[c]] } else { [x[a], x[c], x[b]] }).to_vec()
    }

    fn text(faces: &[[[f32; 3]; 3]]) -> String {
        let vertex = |x: &[f32; 3]| format!("vertex {} {} {}\n", x[0], x[1], x[2]);
        let facet = |face: &[[f32; 3]; 3]| {
            let vertices: String = face.iter().map(vertex).collect();
            format!("facet normal nan 0 0\nouter loop\n{vertices}endloop\nendfacet\n")
        };
        format!("solid a b c\n{}endsolid a b c\n", faces.iter().map(facet).collect::<String>())
    }

    fn binary(faces: &[[[f32; 3]; 3]]) -> Vec<u8> {
        // Binary files may begin like text.
        let mut bytes = b"solid".to_vec();
        bytes.resize(80, b' ');
        bytes.extend((faces.len() as u32).to_le_bytes());
        for face in faces {
            bytes.extend([0; 12]);
            bytes.extend(face.iter().flatten().flat_map(|x| x.to_le_bytes()));
            bytes.extend([0; 2]);
        }
        bytes
    }

    #[test]
    fn text_and_binary_give_the_same_closed_surface_whichever_way_it_is_turned() {
        for outwards in [true, false] {
            let surface = read_stl(text(&faces(outwards)).as_bytes()).unwrap();
            assert_eq!((surface.points.len(), surface.triangles.len()), (4, 4));
            assert!((surface.volume() - 4.5).abs() < 1e-12);
            let of_binary = read_stl(&binary(&faces(outwards))).unwrap();
            assert_eq!(of_binary, surface);
            assert!(begins(&binary(&faces(outwards))) && begins(text(&faces(outwards)).as_bytes()));
        }
    }

    #[test]
    fn hostile_files_are_refused_with_a_place() {
        let whole = binary(&faces(true));
        let refusal = |bytes: &[u8]| read_stl(bytes).unwrap_err().to_string();
        for end in 0..whole.len() {
            read_stl(&whole[..end]).unwrap_err();
        }
        let mut huge = whole.clone();
        huge[80..84].copy_from_slice(&u32::MAX.to_le_bytes());
        huge[..5].copy_from_slice(b"huge ");
        assert!(refusal(&huge).contains("announces 4294967295 triangles"), "{}", refusal(&huge));
        let mut nan = whole.clone();
        nan[84 + 50 + 12..84 + 50 + 16].copy_from_slice(&f32::NAN.to_le_bytes());
        assert!(refusal(&nan).starts_with("byte 134: a triangle has a coordinate that is not finite"));
        let ascii = text(&faces(true));
        for end in (0..ascii.len() - 9).step_by(7) {
            read_stl(&ascii.as_bytes()[..end]).unwrap_err();
        }
        assert!(refusal(ascii.replacen("vertex 3", "vertex inf", 1).as_bytes()).contains("line"));
        assert!(
            refusal(ascii.replacen("endloop", "vertex", 1).as_bytes())
                .starts_with("line 7: expected endloop")
        );
        assert!(refusal(b"solid\nendsolid\n").contains("no triangle"));
        assert!(refusal(b"").contains("84 bytes"));
    }

    #[test]
    fn shells_are_bodies_or_cavities_and_never_inside_out() {
        let moved = |faces: Vec<[[f32; 3]; 3]>, by: f32, factor: f32| -> Vec<[[f32; 3]; 3]> {
            faces.into_iter().map(|face| face.map(|x| x.map(|c| by + factor * c))).collect()
        };
        let volume = |other: Vec<[[f32; 3]; 3]>| {
            read_stl(&binary(&[faces(true), other].concat())).map(|surface| surface.volume())
        };
        // Beside it, in it, and as a cavity of it.
        assert!((volume(moved(faces(true), 5.0, 0.5)).unwrap() - 4.5 * 1.125).abs() < 1e-6);
        assert!((volume(moved(faces(false), 0.1, 0.5)).unwrap() - 4.5 * 0.875).abs() < 1e-6);
        let refused = volume(moved(faces(false), 5.0, 0.5)).unwrap_err().to_string();
        assert!(
            refused.starts_with("byte 284: an outer part of the surface is oriented inwards"),
            "{refused}"
        );
        // The whole of it twice.
        let twice = volume(faces(true)).unwrap_err().to_string();
        assert!(twice.contains("has a triangle twice"), "{twice}");
    }

    #[test]
    fn open_and_twisted_surfaces_are_refused_with_the_edge() {
        let mut open = faces(true);
        open.pop();
        let error = read_stl(&binary(&open)).unwrap_err().to_string();
        assert!(
            error.starts_with(
                "byte 84: the surface is open at 3 edges, the first from (0, 0, 0) to (0, 3, 0)"
            ),
            "{error}"
        );
        let error = read_stl(text(&open).as_bytes()).unwrap_err().to_string();
        assert!(error.starts_with("line 2: the surface is open"), "{error}");
        let mut twisted = faces(true);
        twisted[0].swap(1, 2);
        let error = read_stl(&binary(&twisted)).unwrap_err().to_string();
        assert!(error.contains("not consistently oriented at 3 edges"), "{error}");
    }
}
