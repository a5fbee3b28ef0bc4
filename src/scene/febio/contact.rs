//! Contact of FEBio files.

use super::deck::Deck;
use super::item::Item;
use super::node::{elements, text, title};
use crate::mesh::read::febio::Origin;
use crate::scene::document::PairDocument;
use roxmltree::Node;

/// Parameters of FEBio's method, which penalises gaps, and of its search.
const OF_THE_METHOD: [&str; 22] = [
    "laugon",
    "tolerance",
    "gaptol",
    "penalty",
    "auto_penalty",
    "update_penalty",
    "two_pass",
    "knmult",
    "ktmult",
    "search_tol",
    "search_tolerance",
    "symmetric_stiffness",
    "search_radius",
    "seg_up",
    "minaug",
    "maxaug",
    "node_reloc",
    "smooth_aug",
    "smooth_fls",
    "fric_penalty",
    "dxtol",
    "flip_primary",
];

impl<'x> Deck<'x> {
    /// A contact between the bodies that two surfaces belong to.
    pub(super) fn contact(&mut self, node: Node<'x, 'x>) {
        let kind = node.attribute("type").unwrap_or_default();
        if !["sliding-elastic", "sliding-facet-on-facet", "sliding-node-on-facet"].contains(&kind) {
            let remedy =
                "contact here slides with friction and separates: parts that are tied share their nodes";
            return self.refuse_as(node, title(node), remedy);
        }
        let mut item = Item::new(node);
        let friction =
            if item.take("fric_coeff").is_some() { item.number("fric_coeff", self) } else { Some(0.0) };
        if item.flag("tension") {
            self.refuse(node, "a contact that bears tension", "set <tension> to 0");
        }
        if item.take("offset").is_some() && item.number("offset", self).is_some_and(|offset| offset != 0.0) {
            self.refuse(node, "an offset of the surfaces", "set <offset> to 0");
        }
        for flag in ["flip_secondary", "shell_bottom_primary", "shell_bottom_secondary"] {
            if item.flag(flag) {
                self.refuse(
                    node,
                    format!("<{flag}>"),
                    "a surface of a body has its normal outwards: set it to 0",
                );
            }
        }
        item.finish(&OF_THE_METHOD, self);
        let (Some(friction), Some(pair)) = (friction, self.pair(node)) else { return };
        let pairs = pair[0].iter().flat_map(|a| pair[1].iter().map(move |b| [*a, *b]));
        for [a, b] in pairs.collect::<Vec<_>>() {
            let between = [a, b].map(|body| self.bodies[body].name.clone());
            let is_it = |other: &&PairDocument| between.iter().all(|name| other.between.contains(name));
            match self.pairs.iter().find(is_it).and_then(|other| other.friction) {
                Some(known) if known.to_bits() != friction.to_bits() => {
                    let what = format!("a friction of {friction}, where these bodies have {known} already");
                    return self.refuse(
                        node,
                        what,
                        "a pair of bodies has one friction: give all contacts of them the same",
                    );
                }
                Some(_) => {}
                None => self.pairs.push(PairDocument { between, friction: Some(friction) }),
            }
        }
    }

    /// The bodies of both surfaces of a pair.
    fn pair(&mut self, node: Node<'x, 'x>) -> Option<[Vec<usize>; 2]> {
        let named = node.attribute("surface_pair").unwrap_or_default();
        let mut sections = elements(self.mesh_section).filter(|section| section.has_tag_name("SurfacePair"));
        let Some(pair) = sections.find(|pair| pair.attribute("name") == Some(named)) else {
            self.refuse(node, format!("no surface pair {named:?}"), "name one in the mesh");
            return None;
        };
        let surface = |words: [&str; 2]| {
            let side = elements(pair).find(|side| words.contains(&side.tag_name().name()))?;
            Some(
                side.attribute("surface")
                    .unwrap_or_else(|| text(side))
                    .trim_start_matches("@surface:")
                    .to_owned(),
            )
        };
        let sides = [["primary", "slave"], ["secondary", "master"]].map(surface);
        let bodies = sides.map(|side| {
            let set = self.sets.get(&(Origin::Surface, side?))?;
            let nodes = self.mesh.node_sets.get(set)?;
            Some((0..self.bodies.len()).filter(|&body| self.bodies[body].has_any(nodes)).collect())
        });
        let [Some(a), Some(b)] = bodies else {
            let remedy = "name two surfaces of volume elements; those of shells are not read";
            self.refuse(node, format!("surfaces of the pair {named:?} without volume elements"), remedy);
            return None;
        };
        Some([a, b])
    }
}
