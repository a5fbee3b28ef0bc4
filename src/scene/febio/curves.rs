//! Load curves of FEBio files.

use super::node::{elements, numbers, text};
use roxmltree::Node;
use std::collections::BTreeMap;

/// A load curve, or why it has no counterpart in a scene.
pub(super) type Curves = BTreeMap<String, Result<Curve, String>>;

/// A piecewise linear load curve.
#[derive(Clone, Debug)]
pub(super) struct Curve {
    /// Time [s] and factor of each point, ascending.
    pub points: Vec<[f64; 2]>,
    /// Whether it has its first and last values beyond its ends.
    pub is_constant_beyond: bool,
}

/// The load curves of a file by their numbers.
pub(super) fn curves<'x>(root: Node<'x, 'x>) -> Curves {
    let section = elements(root).filter(|node| node.has_tag_name("LoadData"));
    let curve = |node: Node<'x, 'x>| Some((node.attribute("id")?.to_owned(), curve(node)));
    section.flat_map(elements).filter_map(curve).collect()
}

fn curve<'x>(node: Node<'x, 'x>) -> Result<Curve, String> {
    let is_new = node.has_tag_name("load_controller");
    let setting = |new: &'static str, old: &'static str| {
        let child = elements(node).find(|child| child.has_tag_name(new)).map(text);
        if is_new { child } else { node.attribute(old) }.map(str::to_ascii_lowercase)
    };
    if is_new && node.attribute("type") != Some("loadcurve") {
        return Err(format!("a load controller of type {:?}", node.attribute("type").unwrap_or_default()));
    }
    let points =
        node.descendants().filter(|node| ["pt", "point", "loadpoint"].contains(&node.tag_name().name()));
    let pair = |node| numbers(text(node)).and_then(|pair| <[f64; 2]>::try_from(pair).ok());
    let points: Option<Vec<[f64; 2]>> = points.map(pair).collect();
    let points =
        points.filter(|points| !points.is_empty()).ok_or("a load curve without points of two numbers")?;
    if points.windows(2).any(|pair| pair[1][0] <= pair[0][0]) {
        return Err("a load curve whose times do not ascend".into());
    }
    let is_constant = points.iter().all(|point| point[1].to_bits() == points[0][1].to_bits());
    // FEBio's default, and its smooth curve of two points, are linear.
    let kind = setting("interpolate", "type").unwrap_or_else(|| "linear".into());
    if kind != "linear" && !is_constant && !(kind == "smooth" && points.len() == 2) {
        return Err(format!(
            "a load curve with interpolation {:?} of {} points",
            kind.to_uppercase(),
            points.len()
        ));
    }
    let beyond = setting("extend", "extend").unwrap_or_else(|| "constant".into());
    Ok(Curve { points, is_constant_beyond: beyond == "constant" || is_constant })
}
