//! The solvers by name.

/// Calls a macro with the solvers that a scene may name: documentation, variant, and name in reports and on the command
/// line; the default is the first. Not among them is `frictionless`: with friction it is the hybrid, and without any the default
/// has one unknown per contact anyway.
#[macro_export]
macro_rules! with_contact_solvers {
    ($call:ident) => {
        $call! {
            /// Selects a solver for the problem, and switches when it stalls.
            Hybrid "hybrid",
            /// Block Gauss–Seidel with the exact solution of each contact.
            Nsgs "nsgs",
            /// Semismooth Newton on all contacts.
            Newton "newton",
            /// Primal-dual interior points on the second-order cones.
            InteriorPoint "interior-point",
            /// Proximal points, each by Gauss–Seidel and Newton.
            Proximal "proximal",
            /// Fixed-point iteration of De Saxcé & Feng.
            DeSaxce "de-saxce",
            /// Uzawa iteration: one projection per contact and iteration, each contact with its own step length.
            Uzawa "uzawa",
            /// Extragradient method with adaptive step length.
            Extragradient "extragradient",
            /// Projected gradient with Nesterov's momentum and restarts.
            AcceleratedGradient "accelerated-gradient",
        }
    };
}

macro_rules! methods {
    ($($(#[$doc:meta])* $variant:ident $name:literal,)*) => {
        /// Method by which a contact problem is solved.
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        pub enum Method {
            $($(#[$doc])* $variant,)*
            /// One unknown per contact in frictionless problems; [`Method::Hybrid`] in others.
            Frictionless,
        }

        impl Method {
            /// All methods, the default first.
            pub const ALL: [Self; [$($name),*].len() + 1] = [$(Self::$variant,)* Self::Frictionless];

            /// Name in reports and on the command line.
            pub fn name(self) -> &'static str {
                match self {
                    $(Self::$variant => $name,)*
                    Self::Frictionless => "frictionless",
                }
            }
        }
    };
}

with_contact_solvers!(methods);

impl Default for Method {
    fn default() -> Self {
        Self::ALL[0]
    }
}

impl Method {
    /// Whether it allows an infinite μ, which the De Saxcé form does not.
    pub(super) fn takes_full_stick(self) -> bool {
        matches!(self, Self::Hybrid | Self::Nsgs | Self::Newton | Self::Proximal | Self::Frictionless)
    }

    /// The method with a name, if there is one.
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|m| m.name() == name)
    }
}
