//! Systems of units of FEBio files, by the names that `<units>` has there (FEBio User Manual, "Module").

use std::str::FromStr;

/// A system of units: the second, a length, and a mass or a force.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum UnitSystem {
    /// Metre, kilogram, pascal.
    Si,
    /// Millimetre, newton, megapascal; masses in tonnes.
    MmNewton,
    /// Millimetre, kilogram, kilopascal.
    MmKilogram,
    /// Micrometre, nanonewton, kilopascal; masses in grams.
    UmNanonewton,
    /// Centimetre, gram, barye.
    Cgs,
    /// Millimetre, gram, pascal.
    MmGram,
    /// Millimetre, milligram, millipascal.
    MmMilligram,
}

/// The units of a file in those of the scene.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Units {
    /// Length [m], as also of velocities and accelerations.
    pub length: f64,
    /// Stress [Pa].
    pub stress: f64,
    /// Density [kg/m³].
    pub density: f64,
}

impl UnitSystem {
    const NAMED: [(&'static str, Self); 7] = [
        ("SI", Self::Si),
        ("mm-N-s", Self::MmNewton),
        ("mm-kg-s", Self::MmKilogram),
        ("um-nN-s", Self::UmNanonewton),
        ("CGS", Self::Cgs),
        ("mm-g-s", Self::MmGram),
        ("mm-mg-s", Self::MmMilligram),
    ];

    /// Names of all systems, for messages.
    pub(super) fn names() -> String {
        Self::NAMED.map(|(name, _)| name).join(", ")
    }

    /// The units of the system, in SI.
    pub(super) fn units(self) -> Units {
        // Powers of ten of length, stress and density; a stress is mass/(length s²), a density mass/length³.
        let (length, stress, density) = match self {
            Self::Si => (1.0, 1.0, 1.0),
            Self::MmNewton => (1e-3, 1e6, 1e12),
            Self::MmKilogram => (1e-3, 1e3, 1e9),
            Self::UmNanonewton => (1e-6, 1e3, 1e15),
            Self::Cgs => (1e-2, 1e-1, 1e3),
            Self::MmGram => (1e-3, 1.0, 1e6),
            Self::MmMilligram => (1e-3, 1e-3, 1e3),
        };
        Units { length, stress, density }
    }
}

impl FromStr for UnitSystem {
    type Err = String;

    fn from_str(name: &str) -> Result<Self, String> {
        let found = Self::NAMED.into_iter().find(|(known, _)| known.eq_ignore_ascii_case(name));
        found.map(|(_, system)| system).ok_or_else(|| format!("systems of units are {}", Self::names()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn stress_and_density_have_one_mass() {
        for (_, system) in UnitSystem::NAMED {
            let Units { length, stress, density } = system.units();
            let [by_stress, by_density] = [stress * length, density * length.powi(3)];
            assert!((by_stress / by_density - 1.0).abs() < 1e-12, "{system:?}");
        }
        assert_eq!("mm-n-s".parse(), Ok(UnitSystem::MmNewton));
        let all = "systems of units are SI, mm-N-s, mm-kg-s, um-nN-s, CGS, mm-g-s, mm-mg-s";
        assert_eq!("inch".parse::<UnitSystem>(), Err(all.to_owned()));
    }
}
