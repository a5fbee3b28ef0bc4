//! Contact of a ball pressed into a block, on one thread: detection and solution of one step; an item is one contact.
//!
//! `cargo bench --bench contact`. The step of 0.3 µs moves nodes by less than the neighbourhood of a face, so the
//! closest faces decide; at 3 µs times of impact are needed.

use contuse::mechanics::contact::detection::detector::{Detector as _, Motion};
use contuse::mechanics::contact::detection::node_to_face::NodeToFace;
use contuse::mechanics::contact::solution::gauss_seidel::{Options, Workspace, solve};
use contuse::mechanics::contact::{Contact, ContactLaw, ContactPair, Master, Surface};
use contuse::mechanics::tensor::Vec3;
use contuse::mesh::generate::block::Block;
use contuse::mesh::generate::hollow_ball::HollowBall;
use contuse::mesh::surface::{boundary, boundary_nodes};
use contuse::mesh::{Cells, MeshError};
use divan::counter::ItemsCount;
use divan::{Bencher, black_box};

fn main() {
    divan::main();
}

const SHORT_STEP: f64 = 3e-7;
const LONG_STEP: f64 = 3e-6;

/// A ball that has penetrated a block by 1 mm and continues at 100 m/s; the pressed part is flat.
struct Pressed {
    detector: NodeToFace,
    x: Vec<Vec3>,
    x_end: Vec<Vec3>,
    v: Vec<Vec3>,
    inverse_mass: Vec<Vec3>,
    contacts: Vec<Contact>,
}

impl Pressed {
    fn new(h: f64) -> Result<Self, MeshError> {
        // Block, hollow ball and their surfaces.
        let corner = Vec3::new(-0.05, -0.05, -0.05);
        let block = Block::uniform(corner, Vec3::new(0.1, 0.1, 0.05), [20, 20, 10], "block").generate()?;
        let ball = HollowBall {
            center_m: [0.0, 0.0, 0.014],
            outer_radius_m: 0.015,
            inner_radius_m: 0.012,
            elements_around: 8,
            elements_through: 2,
        }
        .generate()?;
        let first = block.nodes.len() as u32;
        let surface = |cells: &Cells| {
            let faces = boundary(cells);
            Surface::new(boundary_nodes(&faces), faces)
        };
        let surfaces = [surface(&block.cells), surface(&ball.cells.map(|node| node + first))];
        let pairs = [ContactPair { slave: 1, master: Master::Surface(0), law: ContactLaw::of(0.3) }];
        let is_ball = |node: usize| node >= first as usize;
        let at_rest: Vec<Vec3> = block.nodes.iter().chain(&ball.nodes).copied().collect();
        // The list of the broad phase is built where nothing overlaps.
        let lift = |(node, x): (usize, &Vec3)| if is_ball(node) { x + Vec3::z() * 0.0011 } else { *x };
        let apart: Vec<Vec3> = at_rest.iter().enumerate().map(lift).collect();
        let x: Vec<Vec3> = at_rest
            .iter()
            .enumerate()
            .map(|(node, x)| if is_ball(node) { Vec3::new(x.x, x.y, x.z.max(0.0)) } else { *x })
            .collect();
        // Velocities, and positions at the end of the step.
        let falling = |node: usize| if is_ball(node) { Vec3::new(10.0, 0.0, -100.0) } else { Vec3::zeros() };
        let v: Vec<Vec3> = (0..x.len()).map(falling).collect();
        let x_end = x.iter().zip(&v).map(|(x, v)| x + v * h).collect();
        let inverse_mass =
            (0..x.len()).map(|node| Vec3::repeat(if is_ball(node) { 2e5 } else { 5e4 })).collect();
        let detector = NodeToFace::new(&surfaces, &pairs.into_iter().collect(), &apart);
        Ok(Self { detector, x, x_end, v, inverse_mass, contacts: Vec::new() })
    }

    fn detect(&mut self) -> usize {
        self.contacts.clear();
        let found = self.detector.detect(&Motion::of_nodes(&self.x, &self.x_end), &mut self.contacts);
        black_box(found).map_or(0, |()| self.contacts.len())
    }
}

/// All candidates of one step, with a list of the broad phase that is still valid.
#[divan::bench(args = [SHORT_STEP, LONG_STEP])]
fn detection(bencher: Bencher, h: f64) {
    let Ok(mut pressed) = Pressed::new(h) else { return };
    let count = pressed.detect();
    bencher.counter(ItemsCount::new(count)).bench_local(|| pressed.detect());
}

/// Gauss–Seidel iterations to a scaled residual of 10⁻¹⁰.
#[divan::bench(args = [0.0, 0.3])]
fn solution(bencher: Bencher, mu: f64) {
    let Ok(mut pressed) = Pressed::new(SHORT_STEP) else { return };
    let count = pressed.detect();
    let (mut reactions, mut workspace) = (Vec::new(), Workspace::default());
    pressed.contacts.iter_mut().for_each(|contact| contact.law = ContactLaw::of(mu));
    let Pressed { contacts, inverse_mass, v, .. } = &pressed;
    let options = Options::default();
    bencher.counter(ItemsCount::new(count)).with_inputs(|| v.clone()).bench_local_values(|mut v| {
        solve(contacts, inverse_mass, SHORT_STEP, &mut v, &mut reactions, &options, &mut workspace)
    });
}
