//! A numerical setting: what a study may change in a scene without changing the physical problem.

use crate::scene::document::{
    ContactSolver, ErrorBarsDocument, Formulation, Generator, IntegratorDocument, MeshDocument, SceneDocument,
};
use serde::Serialize;
use std::f64::consts::FRAC_1_SQRT_2;

/// Ratio of requested to mean implicit step from which the mean is named [-].
const NAMED_CUT: f64 = 2.0;

/// Numerical setting relative to the document.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Setting {
    /// Mesh level: 0 that of the document, +1 every element split into eight, −1 numbers of elements halved.
    pub mesh_level: i32,
    /// Factor on the numbers of elements of generated meshes, rounded.
    #[serde(skip_serializing_if = "is_one")]
    pub mesh_factor: f64,
    /// Whether the mesh is that of the level below with every element split into eight on its facets: new nodes are not
    /// on the true surface.
    #[serde(skip_serializing_if = "is_false")]
    pub on_facets: bool,
    /// Element formulation of every part; `None` for that of the document.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub formulation: Option<Formulation>,
    /// Factor on the bulk modulus of every split law.
    #[serde(skip_serializing_if = "is_one")]
    pub bulk_factor: f64,
    /// Divisor of the safety factor of the time step.
    pub step_divisor: f64,
    /// Implicit steps of this length [s]; `None` for the document's own time integration.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub implicit_step_s: Option<f64>,
    /// Tolerance of the contact solver; `None` for that of the document.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub contact_tolerance: Option<f64>,
    /// Solver of contact problems; `None` for that of the document.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub contact_solver: Option<ContactSolver>,
    /// Fraction of the mass of boundary nodes moved inwards; `None` for that of the document.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub mass_redistribution: Option<f64>,
}

impl Setting {
    /// The setting of the document.
    pub const OWN: Self = Self {
        mesh_level: 0,
        mesh_factor: 1.0,
        on_facets: false,
        formulation: None,
        bulk_factor: 1.0,
        step_divisor: 1.0,
        implicit_step_s: None,
        contact_tolerance: None,
        contact_solver: None,
        mass_redistribution: None,
    };

    /// Scene with this setting, with the mesh to be split if there is one; `None` if impossible: a mesh from a file
    /// cannot be coarsened.
    pub fn apply(&self, document: &SceneDocument) -> Option<SceneDocument> {
        let mut document = document.clone();
        // The study compares the runs themselves.
        document.solver.error_bars = ErrorBarsDocument::None;
        document.accuracy = None;
        if (self.mesh_level != 0 || !is_one(&self.mesh_factor)) && !document.has_mesh() {
            return None;
        }
        for body in &mut document.bodies {
            // A rigid body has no mesh.
            if let Some(mesh) = &mut body.mesh {
                let factor = self.mesh_factor * 2.0_f64.powi(self.mesh_level - i32::from(self.on_facets));
                change_mesh(mesh, factor)?;
                body.refinement.iter_mut().for_each(|refinement| refinement.size_m /= factor);
            }
            for part in &mut body.parts {
                part.formulation = self.formulation.or(part.formulation);
                part.material.scale_bulk_modulus(self.bulk_factor);
            }
        }
        if let Some(step_s) = self.implicit_step_s {
            document.integrator = IntegratorDocument::implicit(step_s);
        }
        // Time step, contact solver and mass.
        document.integrator.divide_step(self.step_divisor);
        if let Some(tolerance) = self.contact_tolerance {
            document.contact.tolerance = tolerance;
        }
        document.solver.contact = self.contact_solver.or(document.solver.contact);
        if let Some(fraction) = self.mass_redistribution {
            document.contact.mass_redistribution = fraction;
        }
        Some(document)
    }

    /// Human-readable name of the formulation, if it is not the scene's own.
    pub fn formulation_name(&self) -> Option<&'static str> {
        self.formulation.map(|formulation| match formulation {
            Formulation::MeanDilatation => "mean dilatation",
            Formulation::MeanDilatationSingle => "mean dilatation in single precision",
            Formulation::Full => "full",
            Formulation::Reduced => "reduced",
        })
    }

    /// Human-readable name such as "mesh +1, reduced, step / 2".
    pub fn name(&self) -> String {
        self.named(|step| format!("implicit steps of {step:.1e} s"))
    }

    /// The name for a run with this mean step [s]: steps are cut as required by contact or strain, and a run with much
    /// shorter steps than its name says would be misleading.
    pub fn name_with_mean_step(&self, mean: f64) -> String {
        if self.implicit_step_s.is_none_or(|step| NAMED_CUT * mean >= step) {
            return self.name();
        }
        self.named(|step| format!("implicit steps of at most {step:.1e} s (mean {mean:.1e} s)"))
    }

    fn named(&self, implicit_steps: impl Fn(f64) -> String) -> String {
        let is_between = self.mesh_factor.to_bits() == FRAC_1_SQRT_2.to_bits();
        let mesh = if is_between {
            // Half a level below its own: −½ is between −1 and 0.
            let (sign, whole) =
                if self.mesh_level > 0 { ('+', self.mesh_level - 1) } else { ('-', -self.mesh_level) };
            format!("mesh {sign}{whole}½").replace("0½", "½")
        } else {
            format!("mesh {:+}", self.mesh_level).replace("+0", "0")
        };
        let parts = [
            Some(mesh),
            (!is_one(&self.mesh_factor) && !is_between)
                .then(|| format!("numbers of elements × {:.2}", self.mesh_factor)),
            self.on_facets.then(|| "on the facets".to_owned()),
            self.formulation_name().map(str::to_owned),
            (!is_one(&self.bulk_factor)).then(|| format!("bulk moduli × {}", self.bulk_factor)),
            (self.step_divisor > 1.0).then(|| format!("step / {}", self.step_divisor)),
            self.implicit_step_s.map(implicit_steps),
            self.contact_tolerance.map(|tolerance| format!("contact to {tolerance:.0e}")),
            self.contact_solver.map(|solver| format!("contact by {}", solver.method().name())),
            self.mass_redistribution
                .map(|fraction| format!("{:.0} % of boundary mass inwards", 100.0 * fraction)),
        ];
        parts.into_iter().flatten().collect::<Vec<_>>().join(", ")
    }
}

#[allow(clippy::trivially_copy_pass_by_ref)] // serde's signature
fn is_one(factor: &f64) -> bool {
    factor.to_bits() == 1.0_f64.to_bits()
}

#[allow(clippy::trivially_copy_pass_by_ref)] // serde's signature
fn is_false(flag: &bool) -> bool {
    !flag
}

/// Multiplies the numbers of elements by `factor`. Meshes from files can only be split, so by powers of two; existing
/// splits may be undone. `None` if impossible or without effect.
fn change_mesh(mesh: &mut MeshDocument, factor: f64) -> Option<()> {
    if is_one(&factor) {
        return Some(());
    }
    match mesh {
        MeshDocument::File(file) => {
            let levels = factor.log2().round();
            let is_split = (levels.exp2() / factor - 1.0).abs() < 1e-9;
            #[allow(clippy::cast_possible_truncation)] // it is small
            let levels = is_split.then_some(levels as i32)?;
            file.refine = file.refine.checked_add_signed(levels)?;
            Some(())
        }
        MeshDocument::Generator(generator) => change_counts(generator, factor),
        MeshDocument::Segmentation(scan) => {
            scan.divide_sizes(factor);
            Some(())
        }
    }
}

/// Fewest elements of a direction that has more than one, as long as any direction can change [-]: one element across a layer bends
/// and shears otherwise than two, which is no sequence that converges.
const FEWEST_ACROSS: f64 = 2.0;

/// Largest change of a number of elements that makes it even, relative to the exact one [-].
const EVEN: f64 = 0.125;

/// Numbers of elements times a factor; halves are rounded up. An even number across the middle of a body stays even where there is one nearby, so that the mesh of a
/// symmetric scene stays symmetric. `None` when nothing would change. Gradings stay: their size fields
/// are the same for any number ([`crate::mesh::generate::grading`]), so meshes are nested.
fn change_counts(generator: &mut Generator, factor: f64) -> Option<()> {
    let across = generator.counts_across();
    let changed = |(elements, is_across): (u32, &bool), fewest: f64| {
        let own = f64::from(elements);
        let (exact, even) = (own * factor, 2.0 * (0.5 * own * factor).round());
        let stays_even = *is_across && elements.is_multiple_of(2) && (even - exact).abs() <= EVEN * exact;
        (if stays_even { even } else { exact.round() }).max(own.min(fewest))
    };
    let counts: Vec<u32> = generator.counts_mut().into_iter().map(|count| *count).collect();
    let does_change = |fewest: &f64| {
        counts
            .iter()
            .zip(&across)
            .any(|(count, across)| !is_equal(changed((*count, across), *fewest), *count))
    };
    let fewest = [FEWEST_ACROSS, 1.0].into_iter().find(does_change)?;
    for (elements, is_across) in generator.counts_mut().into_iter().zip(&across) {
        let count = changed((*elements, is_across), fewest);
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
        // the bound is checked, and it is positive
        let count = (count <= f64::from(u32::MAX)).then_some(count as u32)?;
        *elements = count;
    }
    Some(())
}

/// Whether a whole number is that count.
#[allow(clippy::float_cmp)] // both are whole
fn is_equal(count: f64, elements: u32) -> bool {
    count == f64::from(elements)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn implicit_steps_that_were_cut_are_not_named_as_if_they_were_not() {
        let setting = Setting { implicit_step_s: Some(0.5), ..Setting::OWN };
        assert_eq!(
            setting.name_with_mean_step(0.1),
            "mesh 0, implicit steps of at most 5.0e-1 s (mean 1.0e-1 s)"
        );
        assert_eq!(setting.name_with_mean_step(0.26), "mesh 0, implicit steps of 5.0e-1 s");
        assert_eq!(Setting::OWN.name_with_mean_step(1e-9), "mesh 0");
    }
}
