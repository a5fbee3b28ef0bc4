//! Files written here are read again; damaged and hostile ones are refused with their place.
#![allow(clippy::unwrap_used)] // tests may panic

use super::gzip::crc32;
use super::*;
use crate::mechanics::tensor::Vec3;

/// A small volume with steps along oblique axes, in millimetres.
pub(crate) struct Written {
    pub(crate) dims: [usize; 3],
    pub(crate) labels: Vec<u8>,
    pub(crate) origin_mm: Vec3,
    pub(crate) steps_mm: [Vec3; 3],
}

impl Written {
    fn small() -> Self {
        let (sin, cos) = (0.6, 0.8);
        Self {
            dims: [3, 4, 2],
            labels: (0..24).map(|i| [0, 7, 2][i % 3]).collect(),
            origin_mm: Vec3::new(10.0, -20.0, 30.0),
            steps_mm: [
                Vec3::new(cos, sin, 0.0) * 0.5,
                Vec3::new(-sin, cos, 0.0) * 0.75,
                Vec3::new(0.0, 0.0, 2.0),
            ],
        }
    }

    /// NIfTI-1 with an sform; each voxel as these bytes of type `datatype`.
    pub(crate) fn nifti(&self, datatype: i16, voxel: impl Fn(u8) -> Vec<u8>) -> Vec<u8> {
        let mut header = vec![0_u8; 352];
        let mut put = |at: usize, bytes: &[u8]| header[at..at + bytes.len()].copy_from_slice(bytes);
        put(0, &348_i32.to_le_bytes());
        for (i, n) in [3, self.dims[0], self.dims[1], self.dims[2], 1, 1, 1, 1].into_iter().enumerate() {
            put(40 + 2 * i, &i16::try_from(n).unwrap().to_le_bytes());
        }
        put(70, &datatype.to_le_bytes());
        put(108, &352_f32.to_le_bytes());
        put(112, &1_f32.to_le_bytes());
        put(123, &[2]);
        put(254, &1_i16.to_le_bytes());
        for i in 0..3 {
            let row = [self.steps_mm[0][i], self.steps_mm[1][i], self.steps_mm[2][i], self.origin_mm[i]];
            for (j, x) in row.into_iter().enumerate() {
                put(280 + 16 * i + 4 * j, &(x as f32).to_le_bytes());
            }
        }
        put(344, b"n+1\0");
        header.extend(self.labels.iter().flat_map(|label| voxel(*label)));
        header
    }

    /// NRRD in the space of DICOM.
    fn nrrd(&self, encoding: &str) -> Vec<u8> {
        let vector = |v: &Vec3| format!("({},{},{})", -v.x, -v.y, v.z);
        let [a, b, c] = self.dims;
        let mut file = format!(
            "NRRD0004\n# made by a test\ntype: unsigned char\ndimension: 3\nspace: left-posterior-superior\nsizes: {a} {b} {c}\n\
             space directions: {} {} {}\nkinds: domain domain domain\nencoding: {encoding}\nspace units: \"mm\" \"mm\" \"mm\"\n\
             space origin: {}\nSegment0_Name:=bone\n\n",
            vector(&self.steps_mm[0]), vector(&self.steps_mm[1]), vector(&self.steps_mm[2]), vector(&self.origin_mm)
        )
        .into_bytes();
        file.extend(if encoding == "raw" { self.labels.clone() } else { gzipped(&self.labels) });
        file
    }

    /// The scan as MetaImage, whose x and y axes point the other way.
    fn metaimage(&self, is_compressed: bool) -> Vec<u8> {
        let spacing = self.steps_mm.map(|step| step.norm());
        let unit: Vec<Vec3> = self.steps_mm.iter().zip(spacing).map(|(step, length)| step / length).collect();
        let row = |v: &Vec3| format!("{} {} {}", -v.x, -v.y, v.z);
        let [a, b, c] = self.dims;
        let mut file = format!(
            "ObjectType = Image\nNDims = 3\nBinaryData = True\nBinaryDataByteOrderMSB = False\nCompressedData = {}\n\
             TransformMatrix = {} {} {}\nOffset = {}\nElementSpacing = {} {} {}\nDimSize = {a} {b} {c}\nElementType = MET_UCHAR\n\
             ElementDataFile = LOCAL\n",
            if is_compressed { "True" } else { "False" },
            row(&unit[0]), row(&unit[1]), row(&unit[2]), row(&self.origin_mm), spacing[0], spacing[1], spacing[2]
        )
        .into_bytes();
        file.extend(if is_compressed {
            miniz_oxide::deflate::compress_to_vec_zlib(&self.labels, 6)
        } else {
            self.labels.clone()
        });
        file
    }
}

/// A file of gzip.
pub(crate) fn gzipped(content: &[u8]) -> Vec<u8> {
    let mut file = vec![0x1f, 0x8b, 8, 0, 0, 0, 0, 0, 0, 3];
    file.extend(miniz_oxide::deflate::compress_to_vec(content, 6));
    file.extend(crc32(content).to_le_bytes());
    file.extend((content.len() as u32).to_le_bytes());
    file
}

fn assert_small(volume: &LabelVolume) {
    let written = Written::small();
    assert_eq!(volume.dims, written.dims);
    assert_eq!(volume.values, [0, 2, 7]);
    let labels: Vec<i64> = volume.labels.iter().map(|index| volume.values[usize::from(*index)]).collect();
    assert_eq!(labels, written.labels.iter().map(|label| i64::from(*label)).collect::<Vec<_>>());
    assert!((volume.origin - written.origin_mm * 1e-3).norm() < 1e-8, "{}", volume.origin);
    for (found, step) in volume.steps.iter().zip(written.steps_mm) {
        assert!((found - step * 1e-3).norm() < 1e-9, "{found}");
    }
    let counts = volume.counts();
    assert_eq!(counts.iter().map(|c| (c.label, c.voxels)).collect::<Vec<_>>(), [(0, 8), (2, 8), (7, 8)]);
    assert!((counts[1].volume_m3 / (8.0 * 0.75e-9) - 1.0).abs() < 1e-6);
}

#[test]
fn a_grid_with_shear_is_refused_in_every_format() {
    let mut written = Written::small();
    written.steps_mm[0] += written.steps_mm[1] * 0.1;
    for (file, format) in
        [(written.nrrd("raw"), VolumeFormat::Nrrd), (written.metaimage(false), VolumeFormat::MetaImage)]
    {
        let refused = read_labels(&file, format, 1000).unwrap_err().to_string();
        assert!(refused.contains("not at right angles"), "{refused}");
    }
}

/// Bytes of a voxel with a label.
type Encode = fn(u8) -> Vec<u8>;

#[test]
fn every_type_of_number_is_read() {
    let written = Written::small();
    let types: [(i16, Encode); 10] = [
        (2, |v| vec![v]),
        (256, |v| vec![v]),
        (512, |v| u16::from(v).to_le_bytes().to_vec()),
        (4, |v| i16::from(v).to_le_bytes().to_vec()),
        (768, |v| u32::from(v).to_le_bytes().to_vec()),
        (8, |v| i32::from(v).to_le_bytes().to_vec()),
        (1280, |v| u64::from(v).to_le_bytes().to_vec()),
        (1024, |v| i64::from(v).to_le_bytes().to_vec()),
        (16, |v| f32::from(v).to_le_bytes().to_vec()),
        (64, |v| f64::from(v).to_le_bytes().to_vec()),
    ];
    for (datatype, voxel) in types {
        let file = written.nifti(datatype, voxel);
        assert_small(&read_labels(&file, VolumeFormat::Nifti, 1000).unwrap());
        assert_small(
            &read_labels(&gzipped(&file), VolumeFormat::sniff(&gzipped(&file)).unwrap(), 1000).unwrap(),
        );
    }
}

#[test]
fn nrrd_and_metaimage_are_the_same_volume() {
    let written = Written::small();
    for file in [written.nrrd("raw"), written.nrrd("gzip"), written.metaimage(false), written.metaimage(true)]
    {
        assert_small(&read_labels(&file, VolumeFormat::sniff(&file).unwrap(), 1000).unwrap());
    }
}

#[test]
fn a_quaternion_and_the_other_byte_order_are_read() {
    let written = Written::small();
    let mut file = written.nifti(2, |v| vec![v]);
    // A rotation by θ about z with sin θ = 0.6: its quaternion has d = sin θ/2.
    file[254..256].fill(0);
    file[252..254].copy_from_slice(&1_i16.to_le_bytes());
    for (at, value) in [
        (76, 1.0),
        (80, 0.5),
        (84, 0.75),
        (88, 2.0),
        (264, 0.1_f64.sqrt()),
        (268, 10.0),
        (272, -20.0),
        (276, 30.0),
    ] {
        file[at..at + 4].copy_from_slice(&(value as f32).to_le_bytes());
    }
    assert_small(&read_labels(&file, VolumeFormat::Nifti, 1000).unwrap());
    // The same header with the most significant byte first.
    let mut swapped = file.clone();
    let mut reverse = |at: usize, size: usize| swapped[at..at + size].reverse();
    reverse(0, 4);
    (40..76).step_by(2).for_each(|at| reverse(at, 2));
    (76..120).step_by(4).for_each(|at| reverse(at, 4));
    (252..256).step_by(2).for_each(|at| reverse(at, 2));
    (256..328).step_by(4).for_each(|at| reverse(at, 4));
    assert_small(&read_labels(&swapped, VolumeFormat::sniff(&swapped).unwrap(), 1000).unwrap());
}

#[test]
fn what_is_cut_short_is_refused_at_its_end() {
    let written = Written::small();
    let plain = written.nifti(2, |v| vec![v]);
    for file in
        [plain.clone(), gzipped(&plain), written.nrrd("raw"), written.nrrd("gzip"), written.metaimage(true)]
    {
        let format = VolumeFormat::sniff(&file).unwrap();
        // The check sum of gzip is the last to be read, before the length.
        for end in 0..file.len() - 4 {
            let error = read_labels(&file[..end], format, 1000);
            assert!(
                matches!(error, Err(MeshError::Malformed { .. } | MeshError::Unsupported { .. })),
                "{end}"
            );
        }
    }
}

#[test]
fn sizes_are_checked_before_anything_is_allocated() {
    let written = Written::small();
    let mut file = written.nifti(2, |v| vec![v]);
    let refused =
        |file: &[u8], limit: u64| read_labels(file, VolumeFormat::Nifti, limit).unwrap_err().to_string();
    assert!(refused(&file, 23).contains("more than the 23 bytes"), "{}", refused(&file, 23));
    for i in 0..3 {
        file[42 + 2 * i..44 + 2 * i].copy_from_slice(&i16::MAX.to_le_bytes());
    }
    assert!(refused(&file, 1 << 30).contains("crop the scan"));
    // Within the limit, but not in the file; compressed, not in any stream of that length.
    assert!(refused(&file, 1 << 60).starts_with("byte 376: "), "{}", refused(&file, 1 << 60));
    assert!(refused(&gzipped(&file), 1 << 60).contains("decompress to"));
    // A bomb: what is beyond the announced size is not decompressed.
    let mut bomb = written.nifti(2, |v| vec![v]);
    bomb.resize(64 << 20, 0);
    assert!(refused(&gzipped(&bomb), 1000).contains("are 376 bytes, but decompress to more"));
}

#[test]
fn nifti_1_has_its_axes_in_single_precision_and_is_the_same_as_another_file_with_these_numbers() {
    let mut written = Written::small();
    let exact = read_labels(&written.nrrd("raw"), VolumeFormat::Nrrd, 1000).unwrap();
    let nifti = read_labels(&written.nifti(2, |v| vec![v]), VolumeFormat::Nifti, 1000).unwrap();
    assert_ne!(exact.steps, nifti.steps);
    written.steps_mm = written.steps_mm.map(|step| step.map(|x| f64::from(x as f32)));
    let rounded = read_labels(&written.nrrd("raw"), VolumeFormat::Nrrd, 1000).unwrap();
    assert_eq!((rounded.steps, rounded.origin), (nifti.steps, nifti.origin));
}

#[test]
fn bytes_after_the_voxels_are_refused() {
    let written = Written::small();
    for mut file in [written.nifti(2, |v| vec![v]), written.nrrd("raw"), written.metaimage(false)] {
        let end = file.len();
        file.extend([0, 0, 0]);
        let message = read_labels(&file, VolumeFormat::sniff(&file).unwrap(), 1000).unwrap_err().to_string();
        let place = format!("byte {end}: the voxels are 24 bytes");
        assert!(message.starts_with(&place) && message.contains("3 bytes follow"), "{message}");
    }
    for mut file in [gzipped(&written.nifti(2, |v| vec![v])), written.nrrd("gzip"), written.metaimage(true)] {
        file.extend(b"rest");
        let message = read_labels(&file, VolumeFormat::sniff(&file).unwrap(), 1000).unwrap_err().to_string();
        assert!(message.contains("4 bytes follow the compressed data"), "{message}");
    }
    // Members of gzip one after another are one content.
    let plain = written.nifti(2, |v| vec![v]);
    let members = [gzipped(&plain[..200]), gzipped(&plain[200..360]), gzipped(&plain[360..])].concat();
    assert_small(&read_labels(&members, VolumeFormat::Nifti, 1000).unwrap());
}

#[test]
fn headers_say_everything_once_with_positive_distances() {
    let written = Written::small();
    let with = |file: Vec<u8>, from: &str, to: &str| {
        let text = String::from_utf8(file).unwrap();
        assert!(text.contains(from), "{from}");
        let file = text.replacen(from, to, 1).into_bytes();
        read_labels(&file, VolumeFormat::sniff(&file).unwrap(), 1000).map_err(|error| error.to_string())
    };
    let nrrd = || written.nrrd("raw");
    let twice = with(nrrd(), "kinds:", "Type: short\nkinds:").unwrap_err();
    assert_eq!(twice, "line 8: \"type\" was given in line 3 already: remove one of them");
    // Keys of users are none of the format.
    assert_small(&with(nrrd(), "kinds:", "type:=short\ntype:=int\nkinds:").unwrap());
    let directions = "space directions: ";
    let turned = with(nrrd(), directions, "spacings: 1 -1 1\nabove: ").unwrap_err();
    assert!(turned.starts_with("line 7: ") && turned.contains("\"space directions\""), "{turned}");
    let twice = with(written.metaimage(false), "DimSize", "NDims = 2\nDimSize").unwrap_err();
    assert!(twice.contains("\"ndims\" was given in line 2 already"), "{twice}");
    let turned = with(written.metaimage(false), "ElementSpacing = ", "ElementSpacing = -").unwrap_err();
    assert!(turned.starts_with("line 8: ") && turned.contains("\"TransformMatrix\""), "{turned}");
}

#[test]
fn voxels_that_are_no_labels_are_refused_with_their_byte() {
    let written = Written::small();
    let refused = |file: &[u8]| read_labels(file, VolumeFormat::Nifti, 1 << 20).unwrap_err().to_string();
    let mut file = written.nifti(16, |v| f32::from(v).to_le_bytes().to_vec());
    for (value, word) in [(f32::NAN, "NaN"), (1.5, "1.5"), (f32::INFINITY, "inf")] {
        file[352 + 20..352 + 24].copy_from_slice(&value.to_le_bytes());
        let message = refused(&file);
        assert!(message.starts_with("byte 372: ") && message.contains(word), "{message}");
    }
    let many = Written { dims: [40, 30, 1], labels: vec![0; 1200], ..Written::small() };
    let mut file = many.nifti(512, |_| vec![0, 0]);
    (0..1200_u16).for_each(|i| {
        file[352 + 2 * usize::from(i)..354 + 2 * usize::from(i)].copy_from_slice(&i.to_le_bytes());
    });
    assert!(refused(&file).contains("segment it"));
    // A grid without volume, a matrix that is not finite, several volumes, no magic.
    let plain = written.nifti(2, |v| vec![v]);
    for (at, bytes, word) in [
        (280, [0_u8; 48].to_vec(), "an edge of 0e0 m"),
        (280, f32::NAN.to_le_bytes().to_vec(), "an edge of NaN m"),
        (48, [0, 1].to_vec(), "one volume"),
        (40, [9, 0].to_vec(), "dimensions"),
        (42, [0, 0].to_vec(), "has none"),
        (42, [255, 255].to_vec(), "-1 voxels"),
        (70, [128, 0].to_vec(), "type 128"),
        (108, f32::NAN.to_le_bytes().to_vec(), "begin at"),
        (344, b"ni1".to_vec(), "one file"),
        (344, b"abc".to_vec(), "mark"),
    ] {
        let mut file = plain.clone();
        file[at..at + bytes.len()].copy_from_slice(&bytes);
        if at == 48 {
            file[40] = 4;
        }
        assert!(refused(&file).contains(word), "{word}: {}", refused(&file));
    }
}

proptest::proptest! {
    #[test]
    fn no_bytes_make_a_reader_panic(at in 0_usize..400, bytes in proptest::collection::vec(0_u8.., 1..12), which in 0..4) {
        let written = Written::small();
        let mut file = match which {
            0 => written.nifti(2, |v| vec![v]),
            1 => written.nrrd("gzip"),
            2 => written.metaimage(true),
            _ => gzipped(&written.nifti(2, |v| vec![v])),
        };
        let at = at.min(file.len() - 1);
        let end = (at + bytes.len()).min(file.len());
        file[at..end].copy_from_slice(&bytes[..end - at]);
        for format in VolumeFormat::ALL {
            let _ = read_labels(&file, format, 1 << 20);
        }
    }
}
