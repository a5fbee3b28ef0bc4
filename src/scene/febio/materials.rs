//! Materials of FEBio files (FEBio User Manual, "Materials"; pressure models of uncoupled materials as its source has them).

use super::deck::Deck;
use super::item::Item;
use super::node::{numbers, text, title};
use crate::mesh::read::febio::RIGID;
use crate::scene::document::{I4Invariants, MaterialDocument, MatrixDocument, VolumetricDocument};
use crate::scene::materials::{
    CoupledNeoHookeanDocument, Families, FebioTerm, FungOrthotropicDocument, HolzapfelGasserOgdenDocument,
    MooneyRivlinDocument, NeoHookeanDocument, OgdenDocument, OgdenTerms, VerondaWestmannDocument,
    WeissDocument, YeohDocument,
};
use crate::scene::memories::{BranchDocument, Moduli, PronyDocument};
use crate::scene::part_document::PartDocument;
use roxmltree::Node;

/// Most terms of Ogden's law, Yeoh's law and Prony series in FEBio.
const MOST_TERMS: usize = 6;

/// Names of the numbered parameters.
const C: [&str; MOST_TERMS] = ["c1", "c2", "c3", "c4", "c5", "c6"];
const G: [&str; MOST_TERMS] = ["g1", "g2", "g3", "g4", "g5", "g6"];
const M: [&str; MOST_TERMS] = ["m1", "m2", "m3", "m4", "m5", "m6"];
const T: [&str; MOST_TERMS] = ["t1", "t2", "t3", "t4", "t5", "t6"];

impl<'x> Deck<'x> {
    /// The material as that of a part; `None` where a scene has none such, which is refused.
    pub(super) fn material(&mut self, node: Node<'x, 'x>, part: &str) -> Option<PartDocument> {
        if node.attribute("type") == Some(RIGID) {
            return Some(self.rigid_part(node, part));
        }
        let mut item = Item::new(node);
        // FEBio's density is 1 where none is given.
        let density = if item.take("density").is_some() { item.number("density", self)? } else { 1.0 };
        let viscoelastic = node.attribute("type") == Some("uncoupled viscoelastic");
        let frame = self.frame(&mut item);
        let frame = self.axes_of_elements(node, part, frame);
        let (law, prony) =
            if viscoelastic { self.viscoelastic(&mut item)? } else { (self.law(&mut item, None)?, None) };
        item.finish(&[], self);
        let density = density * self.units.density;
        Some(PartDocument {
            prony_series: prony,
            fibre_frame: frame,
            ..PartDocument::new(part.to_owned(), density, law)
        })
    }

    /// Law and relaxation of an "uncoupled viscoelastic" material: the stress g0 S + Σ gᵢ Hᵢ is that of the law with g0 times its
    /// stiffness under slow loading.
    fn viscoelastic(&mut self, item: &mut Item<'x>) -> Option<(MaterialDocument, Option<PronyDocument>)> {
        let Some(elastic) = item.take("elastic") else {
            self.refuse(item.node, "no <elastic>", "give it the elastic material in FEBio Studio");
            return None;
        };
        let slow = if item.take("g0").is_some() { item.number("g0", self)? } else { 1.0 };
        if slow <= 0.0 {
            self.refuse(item.node, "no stress under slow loading (g0 = 0)", "give g0 a small positive value");
            return None;
        }
        let mut branches = Vec::new();
        for (g, t) in G.into_iter().zip(T) {
            let relative = if item.take(g).is_some() { item.number(g, self)? } else { 0.0 };
            let time = if item.take(t).is_some() { item.number(t, self)? } else { 1.0 };
            if relative != 0.0 {
                branches.push(BranchDocument { relative_modulus: relative / slow, relaxation_time_s: time });
            }
        }
        let mut inner = Item::new(elastic);
        let mut law = self.law(&mut inner, Some(item))?;
        // Only the density of the whole counts.
        inner.finish(&["density"], self);
        law.scale_stiffness(slow);
        let prony = (!branches.is_empty()).then_some(PronyDocument { moduli: Moduli::LongTerm, branches });
        Some((law, prony))
    }

    /// Bulk modulus [Pa] and volumetric energy of an uncoupled material, `usual` where it names none. Within another material the sum
    /// of both moduli counts, and the energy of the other.
    fn bulk(
        &mut self,
        item: &mut Item<'x>,
        whole: Option<&mut Item<'x>>,
        usual: VolumetricDocument,
    ) -> Option<(f64, VolumetricDocument)> {
        let is_inner = whole.is_some();
        let mut modulus = item.number("k", self).unwrap_or(0.0);
        let own = item.text("pressure_model");
        let (item, model, usual) = match whole {
            None => (item, own, usual),
            Some(whole) => {
                modulus += whole.number("k", self).unwrap_or(0.0);
                let model = whole.text("pressure_model");
                (whole, model, VolumetricDocument::LnSquared)
            }
        };
        let volumetric = match model {
            None => usual,
            Some("default" | "0") => VolumetricDocument::LnSquared,
            Some("NIKE3D" | "1" | "Abaqus (GOH)" | "3") => VolumetricDocument::QuadraticLn,
            Some("Abaqus" | "2") => VolumetricDocument::Quadratic,
            Some(other) => {
                self.refuse(item.node, format!("the pressure model {other:?}"), "choose the default one");
                return None;
            }
        };
        if modulus <= 0.0 {
            let what = if is_inner { "no <k> > 0, in it or in its <elastic>" } else { "no <k> > 0" };
            self.refuse(item.node, what, "give it its bulk modulus in FEBio Studio");
            return None;
        }
        Some((modulus * self.units.stress, volumetric))
    }

    /// The law of a material; `whole` is the viscoelastic material around it.
    fn law(&mut self, item: &mut Item<'x>, whole: Option<&mut Item<'x>>) -> Option<MaterialDocument> {
        let kind = item.node.attribute("type").unwrap_or_default();
        let is_coupled = ["neo-Hookean", "HGO unconstrained"].contains(&kind);
        if is_coupled && whole.is_some() {
            self.refuse(item.node, "a coupled law that relaxes", "choose an uncoupled elastic material");
            return None;
        }
        match kind {
            "neo-Hookean" => self.coupled_neo_hookean(item),
            "HGO unconstrained" => {
                let bulk = self.bulk(item, None, VolumetricDocument::QuadraticLn)?;
                self.holzapfel(item, bulk, (I4Invariants::Full, MatrixDocument::Coupled))
            }
            "Holzapfel-Gasser-Ogden" => {
                let bulk = self.bulk(item, whole, VolumetricDocument::QuadraticLn)?;
                self.holzapfel(item, bulk, (I4Invariants::Isochoric, MatrixDocument::Isochoric))
            }
            "incomp neo-Hookean"
            | "Mooney-Rivlin"
            | "Ogden"
            | "Yeoh"
            | "Veronda-Westmann"
            | "Fung orthotropic"
            | "trans iso Mooney-Rivlin" => {
                let bulk = self.bulk(item, whole, VolumetricDocument::LnSquared);
                let law = self.uncoupled(kind, item, bulk.unwrap_or_default());
                bulk.and(law)
            }
            _ => {
                let remedy =
                    "choose one of those listed in docs/meshes.md, or use the mesh of the file alone";
                self.refuse_as(item.node, format!("{}: this law is not supported", title(item.node)), remedy);
                None
            }
        }
    }

    fn coupled_neo_hookean(&mut self, item: &mut Item<'x>) -> Option<MaterialDocument> {
        let (E, nu) = (item.required("E", self), item.required("v", self));
        let (E, nu) = (E? * self.units.stress, nu?);
        if !(E > 0.0 && nu > -1.0 && nu < 0.5) {
            let remedy = "give E > 0 and −1 < v < 0.5; \"incomp neo-Hookean\" with a bulk modulus is nearly incompressible";
            self.refuse(item.node, "a neo-Hookean material that is not stable", remedy);
            return None;
        }
        let lambda_pa = nu * E / ((1.0 + nu) * (1.0 - 2.0 * nu));
        let law = CoupledNeoHookeanDocument { mu_pa: E / (2.0 * (1.0 + nu)), lambda_pa, valid_to: None };
        Some(MaterialDocument::CoupledNeoHookean(law))
    }

    fn holzapfel(
        &mut self,
        item: &mut Item<'x>,
        (bulk_modulus_pa, volumetric): (f64, VolumetricDocument),
        (i4, matrix): (I4Invariants, MatrixDocument),
    ) -> Option<MaterialDocument> {
        let [c, k1, k2, gamma, kappa] =
            ["c", "k1", "k2", "gamma", "kappa"].map(|name| item.required(name, self));
        let (gamma, stress) = (gamma?, self.units.stress);
        Some(MaterialDocument::HolzapfelGasserOgden(HolzapfelGasserOgdenDocument {
            c_pa: c? * stress,
            k1_pa: k1? * stress,
            k2: k2?,
            kappa: kappa?,
            fibres: Families::AnglesDeg(vec![gamma, -gamma]),
            i4,
            matrix,
            bulk_modulus_pa,
            volumetric,
            valid_to: None,
        }))
    }

    /// The laws whose usual pressure model is FEBio's own.
    fn uncoupled(
        &mut self,
        kind: &str,
        item: &mut Item<'x>,
        (bulk_modulus_pa, volumetric): (f64, VolumetricDocument),
    ) -> Option<MaterialDocument> {
        let (stress, valid_to) = (self.units.stress, None);
        Some(match kind {
            "incomp neo-Hookean" => {
                let c10_pa = 0.5 * item.required("G", self)? * stress;
                MaterialDocument::NeoHookean(NeoHookeanDocument {
                    c10_pa,
                    bulk_modulus_pa,
                    volumetric,
                    valid_to,
                })
            }
            "Mooney-Rivlin" => {
                let c01_pa = item.number("c2", self).unwrap_or(0.0) * stress;
                let c10_pa = item.required("c1", self)? * stress;
                let law = MooneyRivlinDocument { c10_pa, c01_pa, bulk_modulus_pa, volumetric, valid_to };
                MaterialDocument::MooneyRivlin(law)
            }
            "Veronda-Westmann" => {
                let (c1, c2) = (item.required("c1", self), item.required("c2", self)?);
                let law = VerondaWestmannDocument {
                    c1_pa: c1? * stress,
                    c2,
                    bulk_modulus_pa,
                    volumetric,
                    valid_to,
                };
                MaterialDocument::VerondaWestmann(law)
            }
            "Yeoh" => {
                let terms = C.map(|name| item.number(name, self).unwrap_or(0.0) * stress);
                if terms[3..].iter().any(|c| *c != 0.0) {
                    self.refuse(item.node, "terms beyond the third", "fit it with c1, c2 and c3 alone");
                }
                let [c10_pa, c20_pa, c30_pa, ..] = terms;
                let law = YeohDocument { c10_pa, c20_pa, c30_pa, bulk_modulus_pa, volumetric, valid_to };
                MaterialDocument::Yeoh(law)
            }
            "Ogden" => {
                let mut terms = Vec::new();
                for (c, m) in C.into_iter().zip(M) {
                    let c_pa = item.number(c, self).unwrap_or(0.0) * stress;
                    // FEBio's power is 1 where none is given.
                    let m = item.number(m, self).unwrap_or(1.0);
                    if c_pa != 0.0 {
                        terms.push(FebioTerm { c_pa, m });
                    }
                }
                let terms = OgdenTerms::Febio(terms);
                MaterialDocument::Ogden(OgdenDocument { terms, bulk_modulus_pa, volumetric, valid_to })
            }
            "Fung orthotropic" => return self.fung(item, (bulk_modulus_pa, volumetric)),
            // "trans iso Mooney-Rivlin"
            _ => return self.weiss(item, (bulk_modulus_pa, volumetric)),
        })
    }

    fn fung(
        &mut self,
        item: &mut Item<'x>,
        (bulk_modulus_pa, volumetric): (f64, VolumetricDocument),
    ) -> Option<MaterialDocument> {
        let stress = self.units.stress;
        let mut three = |names: [&'x str; 3]| names.map(|name| item.required(name, self));
        let (E, shear, nu) =
            (three(["E1", "E2", "E3"]), three(["G12", "G23", "G31"]), three(["v12", "v23", "v31"]));
        let all = |[a, b, c]: [Option<f64>; 3], unit: f64| Some([a? * unit, b? * unit, c? * unit]);
        Some(MaterialDocument::FungOrthotropic(FungOrthotropicDocument {
            c_pa: item.required("c", self)? * stress,
            young_pa: all(E, stress)?,
            shear_pa: all(shear, stress)?,
            poisson: all(nu, 1.0)?,
            bulk_modulus_pa,
            volumetric,
            valid_to: None,
        }))
    }

    fn weiss(
        &mut self,
        item: &mut Item<'x>,
        (bulk_modulus_pa, volumetric): (f64, VolumetricDocument),
    ) -> Option<MaterialDocument> {
        let stress = self.units.stress;
        let [c1, c4, c5, stretch] = ["c1", "c4", "c5", "lam_max"].map(|name| item.required(name, self));
        let fibre = self.fibre(item)?;
        let (c4, c5, straight_stretch) = (c4?, c5?, stretch?);
        // Without c3 FEBio continues the slope of the straight part.
        let c3 = item.number("c3", self).filter(|c3| *c3 != 0.0);
        let c3 = c3.unwrap_or_else(|| c5 / c4 * (-c4 * (straight_stretch - 1.0)).exp());
        Some(MaterialDocument::Weiss(WeissDocument {
            c10_pa: c1? * stress,
            c01_pa: item.number("c2", self).unwrap_or(0.0) * stress,
            c3_pa: c3 * stress,
            c4,
            c5_pa: c5 * stress,
            straight_stretch,
            fibres: Families::Directions(vec![fibre]),
            i4: I4Invariants::Isochoric,
            bulk_modulus_pa,
            volumetric,
            valid_to: None,
        }))
    }

    /// The direction of the fibres in the material axes: a vector, or the angle in the plane of the first two and that from the third.
    fn fibre(&mut self, item: &mut Item<'x>) -> Option<[f64; 3]> {
        let Some(node) = item.take("fiber") else { return Some([1.0, 0.0, 0.0]) };
        match node.attribute("type").unwrap_or("vector") {
            "vector" => {
                let mut inside = Item::new(node);
                let vector = numbers(inside.text("vector").unwrap_or(text(node)));
                if let Some(vector) = vector.and_then(|vector| vector.try_into().ok()) {
                    return Some(vector);
                }
                self.refuse(node, "no direction of three numbers", "give it as x,y,z");
                None
            }
            "angles" => {
                let mut inside = Item::new(node);
                let theta = inside.number("theta", self).unwrap_or(0.0).to_radians();
                let phi = inside.number("phi", self).unwrap_or(90.0).to_radians();
                Some([theta.cos() * phi.sin(), theta.sin() * phi.sin(), phi.cos()])
            }
            other => {
                self.refuse(
                    node,
                    format!("fibres of type {other:?}"),
                    "give them as a vector, and the fibre_frame by hand",
                );
                None
            }
        }
    }
}
