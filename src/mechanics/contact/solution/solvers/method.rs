//! The solvers by name.

/// Method by which a contact problem is solved.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Method {
    /// Chooses and switches between solvers automatically.
    #[default]
    Hybrid,
    /// Block Gauss–Seidel with the exact solution of each contact.
    Nsgs,
    /// Semismooth Newton on all contacts.
    Newton,
    /// Primal-dual interior points on the second-order cones.
    InteriorPoint,
    /// Proximal points, each by Gauss–Seidel and Newton.
    Proximal,
    /// The fixed point of De Saxcé & Feng.
    DeSaxce,
    /// Extragradient steps of adaptive length.
    Extragradient,
    /// One projection per contact and sweep, with a step length for each contact.
    Uzawa,
    /// Projected gradient with Nesterov's momentum and restarts.
    AcceleratedGradient,
    /// One unknown per contact in frictionless problems; [`Method::Hybrid`] in others.
    Frictionless,
}

impl Method {
    /// All methods, the default first.
    pub const ALL: [Self; 10] = [
        Self::Hybrid,
        Self::Nsgs,
        Self::Newton,
        Self::InteriorPoint,
        Self::Proximal,
        Self::DeSaxce,
        Self::Uzawa,
        Self::Extragradient,
        Self::AcceleratedGradient,
        Self::Frictionless,
    ];

    /// Name in reports and on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::Hybrid => "hybrid",
            Self::Nsgs => "nsgs",
            Self::Newton => "newton",
            Self::InteriorPoint => "interior-point",
            Self::Proximal => "proximal",
            Self::DeSaxce => "de-saxce",
            Self::Uzawa => "uzawa",
            Self::Extragradient => "extragradient",
            Self::AcceleratedGradient => "accelerated-gradient",
            Self::Frictionless => "frictionless",
        }
    }

    /// Whether it allows an infinite μ, which the De Saxcé form does not.
    pub(super) fn takes_full_stick(self) -> bool {
        matches!(self, Self::Hybrid | Self::Nsgs | Self::Newton | Self::Proximal | Self::Frictionless)
    }

    /// The method with a name, if there is one.
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|m| m.name() == name)
    }
}
