//! The list of laws.

/// Calls a macro with what follows its name, and with every law: its name in documents, its file here and in the scene's materials, its type,
/// and the type of its document.
#[macro_export]
macro_rules! with_laws {
    ($call:ident $($first:tt)*) => {
        $call! {
            $($first)*
            "mooney_rivlin": mooney_rivlin, MooneyRivlin, MooneyRivlinDocument;
            "neo_hookean": neo_hookean, NeoHookean, NeoHookeanDocument;
            "coupled_neo_hookean": neo_hookean, CoupledNeoHookean, CoupledNeoHookeanDocument;
            "holzapfel_gasser_ogden": holzapfel_gasser_ogden, HolzapfelGasserOgden, HolzapfelGasserOgdenDocument;
            "yeoh": yeoh, Yeoh, YeohDocument;
            "demiray": exponential_invariants, Demiray, DemirayDocument;
            "veronda_westmann": exponential_invariants, VerondaWestmann, VerondaWestmannDocument;
            "ogden": ogden, Ogden, OgdenDocument;
            "weiss_transversely_isotropic": weiss, Weiss, WeissDocument;
            "fung_orthotropic": fung, FungOrthotropic, FungOrthotropicDocument;
            "blatz_ko": blatz_ko, BlatzKo, BlatzKoDocument;
            "balzani": balzani, Balzani, BalzaniDocument;
            "peng_guo_moran": peng_guo_moran, PengGuoMoran, PengGuoMoranDocument;
        }
    };
}
