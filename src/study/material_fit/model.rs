//! Predictions of a law for the tests of a fit, as a function of scaled unknowns.

use crate::mechanics::material::{MaterialError, PathPoint, eval_path};
use crate::scene::material_fit::{Constants, Errors, FitQuestion, Parameter, TestDocument};
use crate::scene::memories::MemoryDocument;
use nalgebra::DVector;

/// The law of a question with its free parameters.
pub struct Model<'a> {
    question: &'a FitQuestion,
    constants: Constants,
    /// The parameters that the fit changes.
    pub parameters: Vec<Parameter>,
}

/// Prediction of the law for one test.
#[derive(Clone, Debug, Default)]
pub struct Prediction {
    /// Nominal stress, or relaxation modulus, at each point [Pa].
    pub values: Vec<f64>,
    /// Smallest and largest principal stretch [-]; `None` of relaxation.
    pub stretches: Option<[f64; 2]>,
}

impl<'a> Model<'a> {
    /// The model of a question that was checked.
    pub fn new(question: &'a FitQuestion) -> Self {
        Self { question, constants: question.constants(), parameters: question.parameters() }
    }

    /// Unknowns of the starting values.
    pub fn start(&self) -> DVector<f64> {
        let unknown = |p: &Parameter| if p.has_fixed_sign { 0.0 } else { p.start / p.scale };
        DVector::from_iterator(self.parameters.len(), self.parameters.iter().map(unknown))
    }

    /// Values of the parameters: of a fixed sign `p₀ eˣ`, otherwise `x` times the scale.
    pub fn values(&self, x: &DVector<f64>) -> Vec<f64> {
        let value =
            |(p, x): (&Parameter, &f64)| if p.has_fixed_sign { p.start * x.exp() } else { p.scale * x };
        self.parameters.iter().zip(x.iter()).map(value).collect()
    }

    /// The constants at unknowns; `None` where a value is no number.
    pub fn constants(&self, x: &DVector<f64>) -> Option<Constants> {
        let values = self.values(x);
        self.constants.with_numbers(self.parameters.iter().map(|p| p.pointer.as_str()).zip(values))
    }

    /// Prediction of the law for every test with the given constants.
    ///
    /// # Errors
    /// The index of the first test at which the law has no stress, and why.
    pub fn predictions(&self, constants: &Constants) -> Result<Vec<Prediction>, (usize, MaterialError)> {
        let tests = self.question.tests.iter().enumerate();
        tests.map(|(i, test)| predict(constants, test).map_err(|error| (i, error))).collect()
    }

    /// Errors of the law at all points, test by test, as the question counts them; `None` where one is no number.
    pub fn residuals(&self, x: &DVector<f64>) -> Option<DVector<f64>> {
        let predictions = self.predictions(&self.constants(x)?).ok()?;
        let residuals = DVector::from_vec(self.residuals_of(&predictions));
        residuals.iter().all(|r| r.is_finite()).then_some(residuals)
    }

    fn residuals_of(&self, predictions: &[Prediction]) -> Vec<f64> {
        let of_point = |(point, model): (&[f64; 2], &f64)| match self.question.errors {
            Errors::Absolute => model - point[1],
            Errors::Relative => (model / point[1]).ln(),
        };
        let tests = self.question.tests.iter().zip(predictions);
        tests.flat_map(|(test, p)| test.points.iter().zip(&p.values).map(of_point)).collect()
    }

    /// Norm of residuals that are rounding of a perfect fit.
    pub fn negligible(&self) -> f64 {
        const ROUNDING: f64 = 1e-9;
        let measured = self.question.tests.iter().flat_map(|test| &test.points);
        ROUNDING
            * match self.question.errors {
                Errors::Absolute => measured.map(|point| point[1] * point[1]).sum::<f64>().sqrt(),
                Errors::Relative => (measured.count() as f64).sqrt(),
            }
    }
}

fn predict(constants: &Constants, test: &TestDocument) -> Result<Prediction, MaterialError> {
    let values = test.points.iter().map(|point| point[0]);
    let Some((path, component)) = test.kind.path() else {
        let values = values.map(|time| relaxation_modulus(constants, time)).collect();
        return Ok(Prediction { values, stretches: None });
    };
    let law = constants.material.to_material().ok_or(MaterialError::NoSuchFibres)?;
    let points = eval_path(&law, law.fibre_directions(), path, &values.collect::<Vec<_>>())?;
    let stress = |point: &PathPoint| point.stress.P[component];
    let stretches = points.iter().flat_map(|point| {
        let squares = (point.F.transpose() * point.F).symmetric_eigenvalues();
        [squares.min().sqrt(), squares.max().sqrt()]
    });
    let range = stretches.fold([1.0_f64; 2], |[least, most], l| [least.min(l), most.max(l)]);
    Ok(Prediction { values: points.iter().map(stress).collect(), stretches: Some(range) })
}

/// G(t) = G∞ (1 + Σ gᵢ e^(−t/τᵢ)) [Pa], with the law's modulus at rest as that of slow or of sudden loading; not a number
/// without a series that can be made.
fn relaxation_modulus(constants: &Constants, time: f64) -> f64 {
    let modulus = || {
        let prony = constants.prony_series.as_ref()?;
        let (slow, _) = prony.slow_law(constants.material.to_material()?)?.moduli_at_rest();
        let series = prony.series();
        let branches = series.branches().iter();
        Some(
            slow * (1.0
                + branches.map(|b| b.relative_modulus * (-time / b.relaxation_time).exp()).sum::<f64>()),
        )
    };
    modulus().unwrap_or(f64::NAN)
}
