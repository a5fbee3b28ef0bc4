//! Material axes of FEBio files: of a material, or of each element.

use super::deck::Deck;
use super::item::Item;
use super::node::numbers;
use crate::scene::document::FibreFrameDocument;
use roxmltree::Node;

impl<'x> Deck<'x> {
    /// The axes of a material, if it has any that are not refused.
    pub(super) fn frame(&mut self, item: &mut Item<'x>) -> Option<FibreFrameDocument> {
        let node = item.take("mat_axis")?;
        let mut axes = Item::new(node);
        let is_vector = node.attribute("type").is_none_or(|kind| kind == "vector");
        let mut vector = |name, else_: [f64; 3]| match axes.text(name) {
            None => Some(else_),
            Some(text) => numbers(text).and_then(|vector| vector.try_into().ok()),
        };
        if let (true, Some(axis), Some(plane)) =
            (is_vector, vector("a", [1.0, 0.0, 0.0]), vector("d", [0.0, 1.0, 0.0]))
        {
            return Some(FibreFrameDocument::Constant { axis, plane });
        }
        self.refuse(node, "material axes other than two vectors a and d", "give them as vectors");
        None
    }

    /// The axes of a part, whose elements may each have some in the file, in place of `frame` of the material.
    pub(super) fn axes_of_elements(
        &mut self,
        node: Node<'x, 'x>,
        part: &str,
        frame: Option<FibreFrameDocument>,
    ) -> Option<FibreFrameDocument> {
        let index = self.mesh.parts.iter().position(|own| own == part);
        let of_part = self.mesh.part_of.iter().zip(self.has_axes);
        let own = of_part.filter(|(part, _)| Some(**part as usize) == index);
        let [count, without] = own.fold([0, 0], |[n, m], (_, has)| [n + 1, m + u32::from(!has)]);
        if without == count {
            return frame;
        }
        if without > 0 {
            let what = format!(
                "{without} of the {count} elements of {part:?} have no axes in <MeshData>, and others have"
            );
            self.refuse(node, what, "give all elements of the part axes, or none");
        }
        if frame.is_some() {
            let what = format!("axes of its own, beside those of the elements of {part:?} in <MeshData>");
            self.refuse(node, what, "remove <mat_axis> of the material, or the element data");
        }
        Some(FibreFrameDocument::Mesh {})
    }
}
