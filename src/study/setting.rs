//! A setting of the numerics: what a study changes in a scene without changing its question.

use crate::scene::document::{
    ContactSolver, Count, ErrorBarsDocument, Formulation, Generator, IntegratorDocument, MeshDocument,
    SceneDocument,
};
use serde::Serialize;

/// Implicit steps that were cut to less than one of so many parts, on average, are named [-].
const NAMED_CUT: f64 = 2.0;

/// How a scene is computed, relative to its document.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Setting {
    /// Mesh: 0 that of the document, +1 every element split into eight, −1 numbers of elements halved.
    pub mesh_level: i32,
    /// The mesh is that of the level below with every element split into eight on its facets: the nodes that are new are not on
    /// the true surface.
    #[serde(skip_serializing_if = "is_false")]
    pub on_facets: bool,
    /// Element formulation of every part; `None` for what the document says.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub formulation: Option<Formulation>,
    /// The time step's safety factor is divided by this.
    pub step_divisor: f64,
    /// Implicit steps of this length [s]; `None` for the document's own stepping.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub implicit_step_s: Option<f64>,
    /// Tolerance of the contact solver; `None` for what the document says.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub contact_tolerance: Option<f64>,
    /// Solver of contact problems; `None` for what the document says.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub contact_solver: Option<ContactSolver>,
    /// Share of the mass of skin nodes that is moved inwards; `None` for what the document says.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub mass_redistribution: Option<f64>,
}

impl Setting {
    /// What the document says.
    pub const OWN: Self = Self {
        mesh_level: 0,
        on_facets: false,
        formulation: None,
        step_divisor: 1.0,
        implicit_step_s: None,
        contact_tolerance: None,
        contact_solver: None,
        mass_redistribution: None,
    };

    /// The scene computed like this, with the mesh that is to be split where one is; `None` where it cannot be: a mesh from a file
    /// is not made coarser.
    pub fn apply(&self, document: &SceneDocument) -> Option<SceneDocument> {
        let mut document = document.clone();
        // The study compares the runs themselves.
        document.solver.error_bars = ErrorBarsDocument::None;
        if self.mesh_level != 0 && document.bodies.iter().all(|body| body.mesh.is_none()) {
            return None;
        }
        for body in &mut document.bodies {
            // A rigid body has no mesh.
            if let Some(mesh) = &mut body.mesh {
                let level = self.mesh_level - i32::from(self.on_facets);
                change_mesh(mesh, level)?;
                body.refinement.iter_mut().for_each(|refinement| refinement.size_m *= 0.5_f64.powi(level));
            }
            for part in &mut body.parts {
                part.formulation = self.formulation.or(part.formulation);
            }
        }
        if let Some(step_s) = self.implicit_step_s {
            document.integrator = IntegratorDocument::implicit(step_s);
        }
        document.integrator.divide_step(self.step_divisor);
        if let Some(tolerance) = self.contact_tolerance {
            document.contact.tolerance = tolerance;
        }
        document.solver.contact = self.contact_solver.or(document.solver.contact);
        if let Some(share) = self.mass_redistribution {
            document.contact.mass_redistribution = share;
        }
        Some(document)
    }

    /// The formulation's name for people, where it is not the scene's own.
    pub fn formulation_name(&self) -> Option<&'static str> {
        self.formulation.map(|formulation| match formulation {
            Formulation::MeanDilatation => "mean dilatation",
            Formulation::Full => "full",
            Formulation::Reduced => "reduced",
        })
    }

    /// A name for people: "mesh +1, reduced, step / 2".
    pub fn name(&self) -> String {
        self.named(|step| format!("implicit steps of {step:.1e} s"))
    }

    /// The same of a run whose steps were so long on average [s]: steps are cut where contact or strain ask for it, and a run of much
    /// shorter ones than its name says would say nothing of those.
    pub fn name_with_mean_step(&self, mean: f64) -> String {
        if self.implicit_step_s.is_none_or(|step| NAMED_CUT * mean >= step) {
            return self.name();
        }
        self.named(|step| format!("implicit steps of at most {step:.1e} s (mean {mean:.1e} s)"))
    }

    fn named(&self, implicit_steps: impl Fn(f64) -> String) -> String {
        let parts = [
            Some(format!("mesh {:+}", self.mesh_level).replace("+0", "0")),
            self.on_facets.then(|| "on the facets".to_owned()),
            self.formulation_name().map(str::to_owned),
            (self.step_divisor > 1.0).then(|| format!("step / {}", self.step_divisor)),
            self.implicit_step_s.map(implicit_steps),
            self.contact_tolerance.map(|tolerance| format!("contact to {tolerance:.0e}")),
            self.contact_solver.map(|solver| format!("contact by {}", solver.name())),
            self.mass_redistribution
                .map(|share| format!("{:.0} % of the skin's mass inwards", 100.0 * share)),
        ];
        parts.into_iter().flatten().collect::<Vec<_>>().join(", ")
    }
}

#[allow(clippy::trivially_copy_pass_by_ref)] // serde's signature
fn is_false(flag: &bool) -> bool {
    !flag
}

fn change_mesh(mesh: &mut MeshDocument, level: i32) -> Option<()> {
    match mesh {
        MeshDocument::File(file) => {
            file.refine = file.refine.checked_add_signed(level)?;
            Some(())
        }
        MeshDocument::Generator(generator) => change_counts(generator, level),
    }
}

/// Doubles or halves the numbers of elements; where a number is odd, or one, a half is rounded up. `None` when nothing would
/// change.
fn change_counts(generator: &mut Generator, level: i32) -> Option<()> {
    let factor = 2_u32.checked_pow(level.unsigned_abs())?;
    let mut has_changed = level == 0;
    for Count { elements, grading, series } in generator.counts_mut() {
        let before = *elements;
        *elements = if level < 0 { before.div_ceil(factor) } else { before.checked_mul(factor)? };
        has_changed |= *elements != before;
        if let Some(grading) = grading {
            *grading = nested_grading(*grading, before.div_ceil(series), elements.div_ceil(series));
        }
    }
    has_changed.then_some(())
}

/// The grading of `after` elements in a geometric series whose cuts are among those of `before` elements, or hold them.
///
/// n elements of ratio G grow by q = G^(1/(n−1)) from one to the next; two of them merged grow by q².
fn nested_grading(grading: f64, before: u32, after: u32) -> f64 {
    if before < 2 || after == before {
        return grading;
    }
    let growth = grading.ln() / f64::from(before - 1) * f64::from(before) / f64::from(after);
    (growth * f64::from(after - 1)).exp()
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

    #[test]
    fn gradings_are_those_of_merged_elements() {
        // 1, 2, 4, 8 → 3, 12
        assert!((nested_grading(8.0, 4, 2) - 4.0).abs() < 1e-12);
        assert!((nested_grading(4.0, 2, 4) - 8.0).abs() < 1e-12);
        assert!((nested_grading(5.0, 1, 2) - 5.0).abs() < 1e-12);
    }
}
