//! Where a node between classes belongs: on the surface, the edge or the corner at which they meet.

use super::elements::Elements;
use super::grid::{ClassGrid, OUTSIDE};
use super::indicator::Indicator;
use super::labelling::BEYOND;
use crate::mechanics::tensor::{Mat3, Vec3};

/// Steps at each width of the indicators.
const STEPS: usize = 3;

/// Added to the diagonal of the normal equations, relative to their trace [-].
const DAMPING: f64 = 1e-3;

/// Steeper than this over the width of the indicators is a surface [-]; flatter, the node is far from one.
const LEAST_STEP: f64 = 1e-3;

/// How far a node may get from where it was, in edges of its elements [-].
const FARTHEST: f64 = 0.9;

/// Width of the indicators from which normals are taken, in the largest distance of voxels [-]: wide against noise.
const NORMAL_WIDTH: f64 = 3.0;

/// Between this value of an indicator and one less it, a surface is in sight [-].
const NEAR: f64 = 0.02;

impl Node<'_> {
    /// A position no farther from where the node was than it may get [m].
    pub fn bounded(&self, x: Vec3) -> Vec3 {
        let (away, farthest) = (x - self.home, FARTHEST * self.edge + self.reach);
        if away.norm() > farthest { self.home + away * (farthest / away.norm()) } else { x }
    }
}

/// Looks for the surfaces of a grid of classes.
pub struct Surfaces<'a> {
    /// Classes of the voxels.
    pub grid: &'a ClassGrid,
    /// Distance [m] by which each class grows outwards beyond the voxels' surface.
    pub growth: Vec<f64>,
    found: Vec<Indicator>,
}

/// What a node is to do.
#[derive(Clone, Copy, Debug)]
pub struct Node<'a> {
    /// Classes that meet at the node, ascending; two at least.
    pub classes: &'a [u8],
    /// Coordinates that stay as they are.
    pub is_fixed: [bool; 3],
    /// Longest edge of its elements [m].
    pub edge: f64,
    /// Where it was in the octree [m].
    pub home: Vec3,
    /// How much farther than others it may get [m].
    pub reach: f64,
}

/// The classes that meet at each node; empty where there is one only, and unless `also_hanging` for hanging nodes.
pub fn meeting(elements: &Elements, also_hanging: bool) -> Vec<Vec<u8>> {
    let of_node = |(node, around): (usize, &[u8; 8])| {
        let mut classes: Vec<u8> = around.iter().copied().filter(|class| *class != BEYOND).collect();
        classes.sort_unstable();
        classes.dedup();
        let is_free = also_hanging || !elements.hanging.contains_key(&(node as u32));
        if classes.len() > 1 && is_free { classes } else { Vec::new() }
    };
    elements.around.iter().enumerate().map(of_node).collect()
}

impl<'a> Surfaces<'a> {
    /// Surfaces of the voxels themselves.
    pub fn new(grid: &'a ClassGrid) -> Self {
        Self { grid, growth: vec![0.0; grid.count], found: Vec::new() }
    }

    /// Moves a position [m] onto the surfaces between the classes of a node. Where they are not in sight, over ever narrower
    /// indicators: those of the width of its elements see a surface from afar.
    pub fn project(&mut self, node: &Node, from: &Vec3) -> Vec3 {
        let mut x = *from;
        let mut width = if self.sees(node, &x) { 0.0 } else { 0.5 * node.edge };
        loop {
            for _ in 0..STEPS {
                let step = self.step(node, &x, width, false);
                x += step;
                if step.norm() < 1e-3 * width.max(self.grid.coarsest()) {
                    break;
                }
            }
            if width < self.grid.coarsest() {
                break;
            }
            width *= 0.5;
        }
        x += self.step(node, &x, 0.0, true);
        node.bounded(x)
    }

    /// Whether the narrowest indicators of all classes of a node have a slope.
    fn sees(&mut self, node: &Node, x: &Vec3) -> bool {
        self.grid.indicators(x, 0.0, &mut self.found);
        let is_near = |class: &u8| {
            let found = self.found[usize::from(*class)];
            found.value > NEAR && found.value < 1.0 - NEAR
        };
        node.classes.iter().all(is_near)
    }

    /// Moves a position [m] onto the outer surface, whatever is inside, and returns the outward normal there, too.
    pub fn project_outwards(&mut self, node: &Node, from: &Vec3) -> (Vec3, Vec3) {
        let (mut x, mut width) = (*from, 0.5 * (node.edge + node.reach));
        let mut normal = Vec3::zeros();
        loop {
            for _ in 0..STEPS {
                self.grid.indicators(&x, width, &mut self.found);
                let outside = self.found[usize::from(OUTSIDE)];
                let mut gradient = outside.gradient;
                (0..3).filter(|k| node.is_fixed[*k]).for_each(|k| gradient[k] = 0.0);
                let (scale, steepness) = (width.max(self.grid.coarsest()), gradient.norm());
                if steepness * scale < LEAST_STEP {
                    break;
                }
                normal = gradient / steepness;
                x += normal * ((0.5 - outside.value) / steepness).clamp(-scale, scale);
            }
            if width < self.grid.coarsest() {
                break;
            }
            width *= 0.5;
        }
        let inside: Vec<u8> = node.classes.iter().copied().filter(|class| *class != OUTSIDE).collect();
        let growth = inside.iter().map(|class| self.growth[usize::from(*class)]).sum::<f64>();
        x += normal * (growth / inside.len().max(1) as f64);
        (x, normal)
    }

    /// Outward normal of the outer surface near a position [m]; zero out of its sight.
    pub fn outward_normal(&mut self, x: &Vec3) -> Vec3 {
        self.grid.indicators(x, NORMAL_WIDTH * self.grid.coarsest(), &mut self.found);
        self.found[usize::from(OUTSIDE)].gradient.try_normalize(0.0).unwrap_or_else(Vec3::zeros)
    }

    /// Moves a position [m] onto the surfaces between the classes inside, across a normal.
    pub fn project_along(&mut self, node: &Node, from: &Vec3, normal: &Vec3) -> Vec3 {
        let inside: Vec<u8> = node.classes.iter().copied().filter(|class| *class != OUTSIDE).collect();
        if inside.len() < 2 {
            return *from;
        }
        let step = self.step(&Node { classes: &inside, ..*node }, from, 0.0, true);
        from + step - normal * normal.dot(&step)
    }

    /// One step of Gauss and Newton towards φ_a = φ_b for all classes of a node, or where it `grows`, by how much they grow.
    fn step(&mut self, node: &Node, x: &Vec3, width: f64, grows: bool) -> Vec3 {
        self.grid.indicators(x, width, &mut self.found);
        let scale = width.max(self.grid.coarsest());
        let (mut matrix, mut right) = (Mat3::zeros(), Vec3::zeros());
        for (i, &a) in node.classes.iter().enumerate() {
            for &b in &node.classes[i + 1..] {
                let [of_a, of_b] = [a, b].map(|class| self.found[usize::from(class)]);
                let mut gradient = of_a.gradient - of_b.gradient;
                (0..3).filter(|k| node.is_fixed[*k]).for_each(|k| gradient[k] = 0.0);
                let steepness = gradient.norm();
                if steepness * scale < LEAST_STEP {
                    continue;
                }
                // Signed distance inside a, by the gradient; its unit vector points into a.
                let normal = gradient / steepness;
                let distance = ((of_a.value - of_b.value) / steepness).clamp(-scale, scale);
                let [grow_a, grow_b] = [a, b].map(|class| self.growth[usize::from(class)]);
                let residual = if grows { distance + grow_a - grow_b } else { distance };
                let weight = (steepness * scale).min(1.0);
                matrix += normal * normal.transpose() * weight;
                right -= normal * (residual * weight);
            }
        }
        let trace = matrix.trace();
        if trace == 0.0 {
            return Vec3::zeros();
        }
        let damped = matrix + Mat3::identity() * (DAMPING * trace);
        let step = damped.cholesky().map_or_else(Vec3::zeros, |factor| factor.solve(&right));
        let length = step.norm();
        let most = scale + 2.0 * self.growth.iter().fold(0.0_f64, |most, g| most.max(g.abs()));
        if length > most { step * (most / length) } else { step }
    }
}
