//! The list of the elements that there are.

use super::Element;

/// The list: calls a macro with what follows its name, and name, nodes, points and one-point formulation (of [`crate::force`])
/// of every element.
macro_rules! for_each_element {
    ($then:ident $($first:tt)*) => {
        $then! {
            $($first)*
            Hex8, 8, 8, ReducedBatch;
            Tet4, 4, 1, NoOnePoint;
            Wedge6, 6, 6, NoOnePoint;
            Tet10, 10, 4, NoOnePoint;
        }
    };
}
pub(crate) use for_each_element;

/// The most nodes of any element.
pub const MOST_NODES: usize = 10;
/// Most quadrature points of any element.
pub const MOST_POINTS: usize = 8;

macro_rules! is_one_point {
    (NoOnePoint) => {
        false
    };
    ($OnePoint:ident) => {
        true
    };
}

macro_rules! kinds {
    ($($Kind:ident, $N:literal, $Q:literal, $OnePoint:ident;)*) => {
        /// The elements that there are.
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        pub enum ElementKind {
            $(#[doc = concat!("See [`", stringify!($Kind), "`].")] $Kind,)*
        }

        impl ElementKind {
            /// All of them, in the order of their discriminants.
            pub const ALL: [Self; [$($N),*].len()] = [$(Self::$Kind),*];

            /// Nodes of one element of this kind.
            pub const fn node_count(self) -> usize {
                match self { $(Self::$Kind => $N,)* }
            }
            /// Number of quadrature points.
            pub const fn point_count(self) -> usize {
                match self { $(Self::$Kind => $Q,)* }
            }
            /// Shape functions of the nodes at a point.
            pub fn shapes_at(self, q: usize) -> &'static [f64] {
                match self { $(Self::$Kind => &<super::$Kind as Element<$N, $Q>>::shapes()[q],)* }
            }
            /// See [`Element::RELATIVE_COST`].
            pub const fn relative_cost(self) -> f64 {
                match self { $(Self::$Kind => <super::$Kind as Element<$N, $Q>>::RELATIVE_COST,)* }
            }
            /// See [`Element::NODAL_PRESSURE`].
            pub const fn has_nodal_pressure(self) -> bool {
                match self { $(Self::$Kind => <super::$Kind as Element<$N, $Q>>::NODAL_PRESSURE,)* }
            }
            /// Whether it has a one-point formulation.
            pub const fn has_one_point(self) -> bool {
                match self { $(Self::$Kind => is_one_point!($OnePoint),)* }
            }
            /// See [`Element::SINGLE_PRECISION`].
            pub const fn has_single_precision(self) -> bool {
                match self { $(Self::$Kind => <super::$Kind as Element<$N, $Q>>::SINGLE_PRECISION,)* }
            }
            /// Pairs of nodes whose distances bound the rate of strain, see [`Element::LENGTHS`].
            pub fn lengths(self) -> &'static [(usize, usize)] {
                match self { $(Self::$Kind => <super::$Kind as Element<$N, $Q>>::LENGTHS,)* }
            }
        }

        $(const _: () = assert!($N <= MOST_NODES && $Q <= MOST_POINTS);)*
    };
}
for_each_element!(kinds);
