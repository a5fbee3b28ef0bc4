//! Kernels of one block of elements on one thread: internal force evaluation, stretch rates, sum of forces at the
//! nodes.
//!
//! `cargo bench --bench element_kernels`; an item is one evaluation of one element, so the throughput column is
//! element-steps per second and core. The block is sheared and stretched, so that fibres are in tension and bulk
//! viscosity acts.

use contuse::mechanics::element::{OfElement, ReferenceGeometry};
use contuse::mechanics::force::{
    Assembly, BlockInput, BlockParameters, ElementBlock, ElementForces, ForceInput, Formulation, Threads,
};
use contuse::mechanics::lanes::Row;
use contuse::mechanics::material::{
    Balzani, BlatzKo, Branch, CoupledNeoHookean, Demiray, FibreFamilies, FibreShear, FungOrthotropic,
    HolzapfelGasserOgden, I4Form, Material, MatrixForm, Memories, MooneyRivlin, NeoHookean, Ogden, OgdenTerm,
    OrthotropicModuli, PengGuoMoran, PronySeries, Softening, StraighteningFibres, VerondaWestmann,
    Volumetric, Weiss, Yeoh,
};
use contuse::mechanics::tensor::{Mat3, Vec3};
use contuse::mesh::generate::block::Block;
use contuse::mesh::{CellKind, Mesh};
use divan::counter::ItemsCount;
use divan::{Bencher, black_box};
use std::fmt;

fn main() {
    divan::main();
}

/// Elements along each axis: 2 000 (in the second-level cache) and 100 000 (in memory).
const SIZES: [[u32; 3]; 2] = [[20, 10, 10], [50, 50, 40]];

#[derive(Clone, Copy)]
enum Law {
    MooneyRivlin,
    NeoHookean,
    CoupledNeoHookean,
    HolzapfelGasserOgden,
    BlatzKo,
    Yeoh,
    Demiray,
    VerondaWestmann,
    Ogden1,
    Ogden3,
    Weiss,
    Fung,
    Balzani,
    PengGuoMoran,
}

impl Law {
    const ALL: [Self; 14] = [
        Self::MooneyRivlin,
        Self::NeoHookean,
        Self::CoupledNeoHookean,
        Self::HolzapfelGasserOgden,
        Self::BlatzKo,
        Self::Yeoh,
        Self::Demiray,
        Self::VerondaWestmann,
        Self::Ogden1,
        Self::Ogden3,
        Self::Weiss,
        Self::Fung,
        Self::Balzani,
        Self::PengGuoMoran,
    ];

    fn name(self) -> &'static str {
        match self {
            Self::MooneyRivlin => "Mooney–Rivlin",
            Self::NeoHookean => "neo-Hookean",
            Self::CoupledNeoHookean => "coupled neo-Hookean",
            Self::HolzapfelGasserOgden => "HGO, two families",
            Self::BlatzKo => "Blatz–Ko",
            Self::Yeoh => "Yeoh",
            Self::Demiray => "Demiray",
            Self::VerondaWestmann => "Veronda–Westmann",
            Self::Ogden1 => "Ogden, one term",
            Self::Ogden3 => "Ogden, three terms",
            Self::Weiss => "Weiss, two families",
            Self::Fung => "Fung",
            Self::Balzani => "Balzani, two families",
            Self::PengGuoMoran => "Peng–Guo–Moran, two families",
        }
    }
}

/// What stress remembers.
#[derive(Clone, Copy)]
enum Memory {
    Prony,
    Softening,
    /// Shear viscosity, which has no history.
    Viscosity,
}

/// One row of the table: a law, a formulation, a kind of cell, a number of hexahedra, which other cells split.
#[derive(Clone, Copy)]
struct Case {
    law: Law,
    formulation: Formulation,
    single_precision: bool,
    kind: CellKind,
    counts: [u32; 3],
}

impl fmt::Display for Case {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        let law = self.law.name();
        let formulation = match self.formulation {
            Formulation::MeanDilatation if self.single_precision => "mean dilatation in single precision",
            Formulation::MeanDilatation => "mean dilatation",
            Formulation::Full => "full",
            Formulation::NodalPressure => "nodal pressure",
            Formulation::Reduced => "reduced",
        };
        let cells = self.kind.table().name;
        write!(f, "{law}, {formulation}, {cells}, {}", self.counts.iter().product::<u32>())
    }
}

/// The laws with their own kernels in the formulations that they support, in both sizes.
fn cases() -> impl Iterator<Item = Case> {
    let kinds = [
        (Law::MooneyRivlin, Formulation::MeanDilatation),
        (Law::MooneyRivlin, Formulation::Full),
        (Law::MooneyRivlin, Formulation::Reduced),
        (Law::NeoHookean, Formulation::MeanDilatation),
        (Law::NeoHookean, Formulation::Full),
        (Law::NeoHookean, Formulation::Reduced),
        (Law::CoupledNeoHookean, Formulation::Full),
        (Law::CoupledNeoHookean, Formulation::Reduced),
        (Law::HolzapfelGasserOgden, Formulation::MeanDilatation),
        (Law::HolzapfelGasserOgden, Formulation::Full),
        (Law::HolzapfelGasserOgden, Formulation::Reduced),
    ];
    let hexahedra = kinds.map(|(law, formulation)| (law, formulation, CellKind::Hex8));
    let others = [
        (Law::NeoHookean, Formulation::MeanDilatation, CellKind::Wedge6),
        (Law::NeoHookean, Formulation::MeanDilatation, CellKind::Tet10),
        (Law::NeoHookean, Formulation::NodalPressure, CellKind::Tet4),
        (Law::NeoHookean, Formulation::Full, CellKind::Tet4),
    ];
    let all = hexahedra.into_iter().chain(others).collect::<Vec<_>>();
    let of_size = move |counts| {
        let all = all.clone();
        all.into_iter().flat_map(move |(law, formulation, kind)| {
            let case = Case { law, formulation, single_precision: false, kind, counts };
            let has_single = kind == CellKind::Hex8 && formulation == Formulation::MeanDilatation;
            [Some(case), has_single.then_some(Case { single_precision: true, ..case })].into_iter().flatten()
        })
    };
    SIZES.into_iter().flat_map(of_size)
}

/// All laws in one formulation each, in the cache.
fn laws() -> impl Iterator<Item = Case> {
    let formulation = |law| match law {
        Law::CoupledNeoHookean | Law::BlatzKo => Formulation::Full,
        _ => Formulation::MeanDilatation,
    };
    Law::ALL.into_iter().map(move |law| Case {
        law,
        formulation: formulation(law),
        single_precision: false,
        kind: CellKind::Hex8,
        counts: SIZES[0],
    })
}

fn material(law: Law) -> Option<Material> {
    let volumetric = Volumetric::LnSquared(1e8);
    let families = FibreFamilies::new(&[[1.0, 0.5, 0.0], [1.0, -0.5, 0.0]])?;
    let ogden = |terms: &[(f64, f64)]| {
        let terms: Vec<_> = terms.iter().map(|(mu, alpha)| OgdenTerm { mu: *mu, alpha: *alpha }).collect();
        Ogden::new(&terms, volumetric)
    };
    Some(match law {
        Law::MooneyRivlin => MooneyRivlin { c10: 5e5, c01: 1e5, volumetric }.into(),
        Law::NeoHookean => NeoHookean { c10: 5e5, volumetric }.into(),
        Law::CoupledNeoHookean => CoupledNeoHookean { mu: 1e6, lambda: 1e8 }.into(),
        Law::HolzapfelGasserOgden => HolzapfelGasserOgden {
            c: 1e5,
            k1: 1e5,
            k2: 1.0,
            kappa: 0.1,
            families,
            i4: I4Form::Full,
            matrix: MatrixForm::Isochoric,
            volumetric,
        }
        .into(),
        Law::BlatzKo => BlatzKo { mu: 1e6 }.into(),
        Law::Yeoh => Yeoh { c10: 5e5, c20: -1e4, c30: 1e3, volumetric }.into(),
        Law::Demiray => Demiray { mu: 1e6, b: 1.0, volumetric }.into(),
        Law::VerondaWestmann => VerondaWestmann { c1: 1e6, c2: 1.0, volumetric }.into(),
        Law::Ogden1 => ogden(&[(1e5, 9.0)])?.into(),
        Law::Ogden3 => ogden(&[(6.3e5, 1.3), (1.2e3, 5.0), (-1e4, -2.0)])?.into(),
        Law::Weiss => Weiss {
            c10: 5e5,
            c01: 1e5,
            fibres: StraighteningFibres::new(1e4, 30.0, 1e7, 1.06),
            families,
            i4: I4Form::Full,
            volumetric,
        }
        .into(),
        Law::Fung => {
            let moduli = OrthotropicModuli { young: [3e6; 3], shear: [1e6; 3], poisson: [0.45; 3] };
            FungOrthotropic::new(1e6, &moduli, volumetric)?.into()
        }
        Law::Balzani => Balzani { c1: 5e5, alpha1: 1e5, alpha2: 2.5, families, volumetric }.into(),
        Law::PengGuoMoran => {
            let shear = FibreShear { gamma: 1e5, beta: 50.0, stretch: 1.05 };
            PengGuoMoran { c10: 5e5, fibre: [1e5, 1e5], shear, families, volumetric }.into()
        }
    })
}

/// Shear viscosity [Pa s], and relaxation and softening.
fn memory(of: Option<Memory>) -> Option<(f64, Memories)> {
    let branch = |(g, tau)| Branch { relative_modulus: g, relaxation_time: tau };
    Some(match of {
        None => (0.0, Memories::NONE),
        Some(Memory::Viscosity) => (10.0, Memories::NONE),
        Some(Memory::Prony) => {
            let prony = PronySeries::new(&[(0.6, 1e-3), (0.4, 1e-2)].map(branch))?;
            (0.0, Memories { prony, ..Memories::NONE })
        }
        Some(Memory::Softening) => {
            let softening = Softening { onset: 1e4, fracture_energy: 100.0 };
            (0.0, Memories { softening, ..Memories::NONE })
        }
    })
}

/// A block of elements in a deformed state, with the buffers of an internal force evaluation.
struct Bench {
    mesh: Mesh,
    blocks: [ElementBlock; 1],
    forces: ElementForces,
    u: Vec<Vec3>,
    history: Vec<Vec<Row>>,
}

impl Bench {
    /// `None` when the case cannot be built, which its bench reports.
    fn new(case: &Case) -> Option<Self> {
        Self::with_memory(case, None)
    }

    fn with_memory(case: &Case, remembered: Option<Memory>) -> Option<Self> {
        let size = Vec3::from(case.counts.map(|n| 1e-3 * f64::from(n)));
        let mesh = Block::uniform(Vec3::zeros(), size, case.counts, "block").generate().ok()?;
        let (shear_viscosity, memory) = memory(remembered)?;
        let mesh = mesh.split_to(case.kind);
        let parameters = BlockParameters {
            material: material(case.law)?,
            formulation: case.formulation,
            single_precision: case.single_precision,
            density: 1000.0,
            linear_viscosity: 0.06,
            quadratic_viscosity: 1.2,
            shear_viscosity,
            memory,
            erosion: None,
        };
        // The block of elements.
        let kind = case.kind.element();
        let input = |e: usize| {
            let corners = OfElement::from_slice(&mesh.cells.points(e, &mesh.nodes));
            BlockInput {
                element: e as u32,
                nodes: OfElement::from_slice(mesh.cells.nodes(e)),
                geometry: ReferenceGeometry::new(kind, &corners),
                corners,
                axes: Mat3::identity(),
            }
        };
        let inputs: Vec<BlockInput> = (0..mesh.cells.len()).map(input).collect();
        let blocks = [ElementBlock::new(0, parameters, 0, &inputs).ok()?];
        let u = mesh.nodes.iter().map(|X| X * 0.01 + Vec3::new(X.y, X.z, X.x) * 0.1).collect();
        let mut history = ElementForces::no_history(&blocks);
        history.as_mut_slice().iter_mut().flatten().for_each(|row| row.0.fill(0.02));
        Some(Self { forces: ElementForces::new(&blocks), mesh, blocks, u, history })
    }

    fn evaluate(&mut self) {
        let input = ForceInput { inverse_step: 1e6, history: &self.history, ..ForceInput::at(&self.u) };
        self.forces.evaluate(&Threads::ONE, &self.blocks, black_box(&input));
    }
}

/// Internal forces, energies and critical time steps.
#[divan::bench(args = cases())]
fn internal_forces(bencher: Bencher, case: Case) {
    let Some(mut bench) = Bench::new(&case) else { return };
    bencher.counter(ItemsCount::new(bench.mesh.cells.len())).bench_local(|| bench.evaluate());
}

/// The same of every law.
#[divan::bench(args = laws())]
fn law(bencher: Bencher, case: Case) {
    let Some(mut bench) = Bench::new(&case) else { return };
    bencher.counter(ItemsCount::new(bench.mesh.cells.len())).bench_local(|| bench.evaluate());
}

/// The second pass that relaxation, softening and viscosity add.
fn second_pass(bencher: Bencher, case: &Case, memory: Memory) {
    let Some(mut bench) = Bench::with_memory(case, Some(memory)) else { return };
    bench.evaluate();
    let Bench { forces, blocks, u, history, mesh } = &mut bench;
    let v: Vec<Vec3> = u.iter().map(|u| u * 100.0).collect();
    let input = ForceInput { inverse_step: 1e6, history, ..ForceInput::at(u) };
    bencher
        .counter(ItemsCount::new(mesh.cells.len()))
        .bench_local(|| forces.add_viscous(&Threads::ONE, blocks, black_box(&input), &v));
}

/// Relaxation: two branches.
#[divan::bench(args = laws().filter(|case| case.formulation == Formulation::MeanDilatation))]
fn relaxation(bencher: Bencher, case: Case) {
    second_pass(bencher, &case, Memory::Prony);
}

/// Softening.
#[divan::bench(args = laws().filter(|case| case.formulation == Formulation::MeanDilatation))]
fn softening(bencher: Bencher, case: Case) {
    second_pass(bencher, &case, Memory::Softening);
}

/// Shear viscosity, of whatever law.
#[divan::bench(args = laws().take(1))]
fn viscosity(bencher: Bencher, case: Case) {
    second_pass(bencher, &case, Memory::Viscosity);
}

/// The limit of the step by stretch rates: measured at every element (`limit` 0), and where a check of the velocities
/// of a chunk suffices.
#[divan::bench(args = SIZES, consts = [false, true])]
fn stretch_rate<const SLOW: bool>(bencher: Bencher, counts: [u32; 3]) {
    let (law, formulation) = (Law::MooneyRivlin, Formulation::MeanDilatation);
    let case = Case { law, formulation, single_precision: false, kind: CellKind::Hex8, counts };
    let Some(mut bench) = Bench::new(&case) else { return };
    bench.evaluate();
    let limit = if SLOW { f64::MAX } else { 0.0 };
    let Bench { forces, blocks, u, mesh, .. } = &mut bench;
    bencher
        .counter(ItemsCount::new(mesh.cells.len()))
        .bench_local(|| forces.largest_stretch_rate(&Threads::ONE, blocks, black_box(u), 1e-9, limit));
}

/// The sum of the chunks' forces at each node.
#[divan::bench(args = SIZES)]
fn assembly(bencher: Bencher, counts: [u32; 3]) {
    let (law, formulation) = (Law::MooneyRivlin, Formulation::MeanDilatation);
    let case = Case { law, formulation, single_precision: false, kind: CellKind::Hex8, counts };
    let Some(mut bench) = Bench::new(&case) else { return };
    bench.evaluate();
    let assembly = Assembly::new(bench.mesh.nodes.len(), &bench.blocks);
    let mut sums = vec![Vec3::zeros(); bench.mesh.nodes.len()];
    bencher.counter(ItemsCount::new(bench.mesh.cells.len())).bench_local(|| {
        for (node, sum) in sums.iter_mut().enumerate() {
            *sum = black_box(&bench.forces).at_node(&assembly, node);
        }
    });
}
