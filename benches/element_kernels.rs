//! Kernels of one block of elements on one thread: internal force evaluation, stretch rates, sum of forces at the
//! nodes.
//!
//! `cargo bench --bench element_kernels`; an item is one evaluation of one element, so the throughput column is
//! element-steps per second and core. The block is sheared and stretched, so that fibres are in tension and bulk
//! viscosity acts.

use contuse::mechanics::element::ReferenceGeometry;
use contuse::mechanics::force::{
    Assembly, BlockInput, BlockParameters, ElementBlock, ElementForces, ForceInput, Formulation, Threads,
};
use contuse::mechanics::lanes::Row;
use contuse::mechanics::material::{
    CoupledNeoHookean, FibreFamilies, HolzapfelGasserOgden, I4Form, Material, MatrixForm, MooneyRivlin,
    NeoHookean, Volumetric,
};
use contuse::mechanics::tensor::{Mat3, Vec3};
use contuse::mesh::generate::block::Block;
use contuse::mesh::{CellKind, Mesh};
use contuse::scene::elements::element_of;
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
}

/// One row of the table: a law, a formulation, a kind of cell, a number of hexahedra, which other cells split.
#[derive(Clone, Copy)]
struct Case {
    law: Law,
    formulation: Formulation,
    kind: CellKind,
    counts: [u32; 3],
}

impl fmt::Display for Case {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        let law = match self.law {
            Law::MooneyRivlin => "Mooney–Rivlin",
            Law::NeoHookean => "neo-Hookean",
            Law::CoupledNeoHookean => "coupled neo-Hookean",
            Law::HolzapfelGasserOgden => "HGO, two families",
        };
        let formulation = match self.formulation {
            Formulation::MeanDilatation => "mean dilatation",
            Formulation::Full => "full",
            Formulation::NodalPressure => "nodal pressure",
            Formulation::Reduced => "reduced",
        };
        let cells = self.kind.table().name;
        write!(f, "{law}, {formulation}, {cells}, {}", self.counts.iter().product::<u32>())
    }
}

/// Every law in the formulations that it supports, in both sizes.
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
        all.into_iter().map(move |(law, formulation, kind)| Case { law, formulation, kind, counts })
    };
    SIZES.into_iter().flat_map(of_size)
}

fn material(law: Law) -> Option<Material> {
    let volumetric = Volumetric::LnSquared(1e8);
    Some(match law {
        Law::MooneyRivlin => Material::MooneyRivlin(MooneyRivlin { c10: 5e5, c01: 1e5, volumetric }),
        Law::NeoHookean => Material::NeoHookean(NeoHookean { c10: 5e5, volumetric }),
        Law::CoupledNeoHookean => Material::CoupledNeoHookean(CoupledNeoHookean { mu: 1e6, lambda: 1e8 }),
        Law::HolzapfelGasserOgden => Material::HolzapfelGasserOgden(HolzapfelGasserOgden {
            c: 1e5,
            k1: 1e5,
            k2: 1.0,
            kappa: 0.1,
            families: FibreFamilies::new(&[[1.0, 0.5, 0.0], [1.0, -0.5, 0.0]])?,
            i4: I4Form::Full,
            matrix: MatrixForm::Isochoric,
            volumetric,
        }),
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
        let size = Vec3::from(case.counts.map(|n| 1e-3 * f64::from(n)));
        let mesh = Block::uniform(Vec3::zeros(), size, case.counts, "block").generate().ok()?;
        let mesh = match case.kind {
            CellKind::Hex8 => mesh,
            CellKind::Wedge6 => mesh.split_to_wedges(),
            CellKind::Tet4 => mesh.split_to_tetrahedra(),
            CellKind::Tet10 => mesh.split_to_tetrahedra().to_quadratic_tetrahedra(),
        };
        let parameters = BlockParameters {
            material: material(case.law)?,
            formulation: case.formulation,
            density: 1000.0,
            linear_viscosity: 0.06,
            quadratic_viscosity: 1.2,
            shear_viscosity: 0.0,
            memory: contuse::mechanics::material::Memories::NONE,
            erosion: None,
        };
        // The block of elements.
        let kind = element_of(case.kind)?;
        let input = |e: usize| {
            let corners = mesh.cells.points(e, &mesh.nodes).to_vec();
            BlockInput {
                element: e as u32,
                nodes: mesh.cells.nodes(e).to_vec(),
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
        let input = ForceInput { u: &self.u, inverse_step: 1e6, history: &self.history };
        self.forces.evaluate(&Threads::ONE, &self.blocks, black_box(&input));
    }
}

/// Internal forces, energies and critical time steps.
#[divan::bench(args = cases())]
fn force_sweep(bencher: Bencher, case: Case) {
    let Some(mut bench) = Bench::new(&case) else { return };
    bencher.counter(ItemsCount::new(bench.mesh.cells.len())).bench_local(|| bench.evaluate());
}

/// The limit of the step by stretch rates: measured at every element (`limit` 0), and where a check of the velocities
/// of a chunk suffices.
#[divan::bench(args = SIZES, consts = [false, true])]
fn stretch_rate<const SLOW: bool>(bencher: Bencher, counts: [u32; 3]) {
    let (law, formulation) = (Law::MooneyRivlin, Formulation::MeanDilatation);
    let case = Case { law, formulation, kind: CellKind::Hex8, counts };
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
    let case = Case { law, formulation, kind: CellKind::Hex8, counts };
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
