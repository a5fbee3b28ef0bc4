//! Pictures as PNG: the SVG rendered by resvg with an embedded typeface, so that labels look the same on every machine,
//! whatever its fonts.

use resvg::tiny_skia::{Pixmap, Transform};
use resvg::usvg::{Options, Tree, fontdb::Database};
use std::sync::Arc;

/// DejaVu Sans: letters, digits and signs of Western and Greek scripts and of mathematics; its licence lies beside it.
const TYPEFACE: &[u8] = include_bytes!("font/DejaVuSans.ttf");
const FAMILY: &str = "DejaVu Sans";

/// Pixels of the PNG per unit of the SVG.
const SCALE: f32 = 2.0;

/// Renders a picture as PNG, at twice the size of the SVG in pixels.
///
/// # Errors
/// The message of the drawing library.
pub fn png(svg: &str) -> Result<Vec<u8>, String> {
    let mut fonts = Database::new();
    fonts.load_font_data(TYPEFACE.to_vec());
    fonts.set_sans_serif_family(FAMILY);
    let options = Options { font_family: FAMILY.into(), fontdb: Arc::new(fonts), ..Options::default() };
    let tree = Tree::from_str(svg, &options).map_err(|error| error.to_string())?;
    let size = tree.size();
    let pixels = |length: f32| (SCALE * length).ceil() as u32;
    let (width, height) = (pixels(size.width()), pixels(size.height()));
    let mut picture =
        Pixmap::new(width, height).ok_or_else(|| format!("no picture is {width} by {height} pixels"))?;
    resvg::render(&tree, Transform::from_scale(SCALE, SCALE), &mut picture.as_mut());
    picture.encode_png().map_err(|error| error.to_string())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn dark(label: &str) -> (u32, usize) {
        let svg = format!(
            r#"<svg width="300" height="40" xmlns="http://www.w3.org/2000/svg"><rect width="300" height="40" fill="white"/>
            <text x="5" y="25" font-family="sans-serif" font-size="16">{label}</text></svg>"#
        );
        let picture = Pixmap::decode_png(&png(&svg).unwrap()).unwrap();
        (picture.width(), picture.pixels().iter().filter(|p| p.red() < 128).count())
    }

    #[test]
    fn labels_show_without_any_font_of_the_machine() {
        let (width, blank) = dark("");
        assert_eq!((width, blank), (600, 0));
        assert!(dark("contact patch [mm²]").1 > 1000);
        // Every sign used in labels is in the typeface: a missing one would be a box, and all boxes are alike.
        let signs = ["²", "³", "µ", "·", "×", "τ", "θ", "ξ", "σ", "±", "−", "≤", "⁻", "…", "–"];
        let inks = signs.map(|sign| dark(sign).1);
        assert!(inks.iter().all(|ink| *ink > 0), "{inks:?}");
        let missing = dark("\u{4e00}").1;
        assert!(inks.iter().all(|ink| *ink != missing), "{inks:?}, missing: {missing}");
    }

    #[test]
    fn what_is_no_picture_is_reported() {
        assert!(png("<svg").is_err());
    }
}
