//! Scenes of small FEBio files: two blocks of one hexahedron each, in millimetres and newtons.

mod rigid;

use super::{UnitSystem, scene_of_febio};
use crate::mechanics::material::eval_point;
use crate::mechanics::tensor::Mat3;
use crate::scene::document::MaterialDocument;
use crate::scene::{Budget, MeshBytes, MeshSource, MeshSourceError, Problems, load};
use serde_json::{Value, json};

/// Nodes 1 to 8 of a block at z = 0 to 10, nodes 9 to 16 of one above it with a gap of 1.
fn file(material: &str, sections: &str) -> String {
    let square = [(0, 0), (10, 0), (10, 10), (0, 10)];
    let levels = [0, 10, 11, 21];
    let at = levels.iter().flat_map(|z| square.map(|(x, y)| (x, y, *z)));
    let node = |(id, (x, y, z)): (usize, _)| format!("<node id=\"{id}\">{x},{y},{z}</node>\n");
    let nodes: String = (1..).zip(at).map(node).collect();
    format!(
        "<febio_spec version=\"4.0\">\n<Module type=\"solid\"><units>mm-N-s</units></Module>\n\
         <Material><material id=\"1\" name=\"stuff\" {material}</material></Material>\n\
         <Mesh><Nodes name=\"all\">\n{nodes}</Nodes>\n\
         <Elements type=\"hex8\" name=\"lower\"><elem id=\"1\">1,2,3,4,5,6,7,8</elem></Elements>\n\
         <Elements type=\"hex8\" name=\"upper\"><elem id=\"2\">9,10,11,12,13,14,15,16</elem></Elements>\n\
         <NodeSet name=\"bottom\">1,2,3,4</NodeSet><NodeSet name=\"top\">13,14,15,16</NodeSet>\n\
         <NodeSet name=\"above\">9,10,11,12,13,14,15,16</NodeSet>\n\
         <Surface name=\"first\"><quad4 id=\"1\">5,6,7,8</quad4></Surface>\n\
         <Surface name=\"second\"><quad4 id=\"1\">9,12,11,10</quad4></Surface>\n\
         <SurfacePair name=\"gap\"><primary>first</primary><secondary>second</secondary></SurfacePair>\n\
         </Mesh>\n<MeshDomains><SolidDomain name=\"lower\" mat=\"stuff\"/><SolidDomain name=\"upper\" mat=\"stuff\"/></MeshDomains>\n\
         {sections}</febio_spec>\n"
    )
}

const NEO_HOOKEAN: &str = "type=\"neo-Hookean\"><density>1e-9</density><E>0.1</E><v>0.4</v>";

fn scene_of(text: &str) -> Result<Value, Problems> {
    scene_of_febio(text.as_bytes(), "blocks.feb", None).unwrap().1
}

/// The messages of the problems of a file.
fn refused(text: &str) -> Vec<String> {
    scene_of(text).unwrap_err().0.into_iter().map(|problem| problem.message).collect()
}

fn material(xml: &str) -> Value {
    scene_of(&file(xml, "")).unwrap()["bodies"][0]["parts"][0].clone()
}

#[test]
fn laws_have_the_stresses_of_febio() {
    let reference: Value =
        serde_json::from_str(include_str!("../../../../tests/data/material_reference.json")).unwrap();
    let mut cases = 0;
    for set in reference["materials"].as_array().unwrap() {
        let parameters = set["params"].as_object().unwrap();
        let parameter = |(name, value): (&String, &Value)| {
            format!("<{name}>{}</{name}>", value.to_string().trim_matches('"'))
        };
        let parameters: String = parameters.iter().map(parameter).collect();
        let xml = file(&format!("type={}>{parameters}", set["febio_type"]), "").replace("mm-N-s", "SI");
        let part = &scene_of(&xml).unwrap()["bodies"][0]["parts"][0];
        assert_eq!(part["density_kg_per_m3"], 1.0);
        let law: MaterialDocument = serde_json::from_value(part["material"].clone()).unwrap();
        let law = law.to_material().unwrap();
        for case in set["cases"].as_array().unwrap() {
            let F = Mat3::from_fn(|i, j| case["F"][i][j].as_f64().unwrap());
            let stress = |i: usize, j: usize| {
                let name = ["x", "y", "z"][i.min(j)].to_owned() + ["x", "y", "z"][i.max(j)];
                case["cauchy_Pa"][name].as_f64().unwrap()
            };
            let expected = Mat3::from_fn(stress);
            let error = (eval_point(&law, &F).unwrap().cauchy - expected).amax() / expected.amax();
            assert!(error < 1e-11, "{} {}: {error}", set["name"], case["case"]);
            cases += 1;
        }
    }
    assert_eq!(cases, 29);
}

#[test]
fn parameters_are_in_the_units_of_the_file() {
    let part = material(NEO_HOOKEAN);
    assert!((part["density_kg_per_m3"].as_f64().unwrap() - 1000.0).abs() < 1e-9);
    assert!((part["material"]["mu_pa"].as_f64().unwrap() - 0.1e6 / 2.8).abs() < 1e-6);
    let yeoh = material("type=\"Yeoh\"><c1>0.01</c1><c2>0.002</c2><k>10</k>");
    assert_eq!(yeoh["material"]["law"], "yeoh");
    assert_eq!(yeoh["material"]["bulk_modulus_pa"], 1e7);
    let fung = material(
        "type=\"Fung orthotropic\"><E1>1</E1><E2>2</E2><E3>3</E3><G12>1</G12><G23>1</G23><G31>1</G31><v12>0.1</v12><v23>0.1</v23>\
         <v31>0.1</v31><c>1</c><k>10</k><mat_axis type=\"vector\"><a>0,1,0</a><d>0,0,1</d></mat_axis>",
    );
    assert_eq!(
        fung["fibre_frame"],
        json!({"kind": "constant", "axis": [0.0, 1.0, 0.0], "plane": [0.0, 0.0, 1.0]})
    );
    assert_eq!(fung["material"]["young_pa"], json!([1e6, 2e6, 3e6]));
    let weiss = material(
        "type=\"trans iso Mooney-Rivlin\"><c1>1</c1><c3>0</c3><c4>10</c4><c5>5</c5><lam_max>1.1</lam_max><k>100</k>\
         <fiber type=\"angles\"><theta>90</theta><phi>90</phi></fiber>",
    );
    let c3 = weiss["material"]["c3_pa"].as_f64().unwrap();
    assert!((c3 - 5e6 / 10.0 * (-1.0_f64).exp()).abs() < 1e-6);
    let fibre = &weiss["material"]["fibres"]["directions"][0];
    assert!((fibre[1].as_f64().unwrap() - 1.0).abs() < 1e-15 && fibre[0].as_f64().unwrap().abs() < 1e-15);
    // The stress g0 S + Σ g H of FEBio, relative to g0 S.
    let viscous = material(
        "type=\"uncoupled viscoelastic\"><g0>0.5</g0><g1>0.25</g1><t1>0.1</t1><k>10</k>\
         <elastic type=\"Mooney-Rivlin\"><c1>0.02</c1><c2>0</c2></elastic>",
    );
    assert_eq!(viscous["material"]["c10_pa"], 1e4);
    let branch = json!({"relative_modulus": 0.5, "relaxation_time_s": 0.1});
    assert_eq!(viscous["prony_series"]["branches"], json!([branch]));
}

const SECTIONS: &str = "<Control><analysis>STATIC</analysis><time_steps>10</time_steps><step_size>0.1</step_size></Control>\n\
    <Boundary><bc name=\"a\" type=\"zero displacement\" node_set=\"bottom\"><x_dof>1</x_dof><y_dof>1</y_dof><z_dof>1</z_dof></bc>\n\
    <bc name=\"b\" type=\"prescribed displacement\" node_set=\"top\"><dof>z</dof><value lc=\"1\">-2</value><relative>0</relative></bc></Boundary>\n\
    <Loads><surface_load type=\"pressure\" surface=\"first\"><pressure lc=\"1\">0.01</pressure><linear>0</linear></surface_load>\n\
    <body_load type=\"const\"><z lc=\"1\">9810</z></body_load></Loads>\n\
    <Contact><contact type=\"sliding-elastic\" surface_pair=\"gap\"><penalty>5</penalty><fric_coeff>0.3</fric_coeff></contact></Contact>\n\
    <LoadData><load_controller id=\"1\" type=\"loadcurve\"><interpolate>SMOOTH</interpolate><points><pt>0,0</pt><pt>1,1</pt></points>\
    </load_controller></LoadData>\n<Output/>\n";

struct One(String);
impl MeshSource for One {
    fn read(&self, name: &str, _: u64) -> Result<MeshBytes, MeshSourceError> {
        Ok(MeshBytes { file_name: name.to_owned(), bytes: self.0.clone().into_bytes() })
    }
}

#[test]
fn conditions_loads_and_contact_are_those_of_the_file_and_validate() {
    let text = file(NEO_HOOKEAN, SECTIONS);
    let scene = scene_of(&text).unwrap();
    let ramp = json!({"kind": "table", "times_s": [0.0, 1.0], "factors": [0.0, 1.0]});
    let [lower, upper] = [&scene["bodies"][0], &scene["bodies"][1]];
    assert_eq!(lower["fixed"], json!([{"set": "bottom", "axes": ["x", "y", "z"]}]));
    let pressure = json!({"kind": "pressure", "set": "first", "pressure_pa": 1e4, "ramp": ramp});
    assert_eq!(lower["face_loads"], json!([pressure]));
    assert_eq!(upper["prescribed"][0]["displacement_m"], json!([0.0, 0.0, -0.002]));
    assert_eq!(upper["prescribed"][0]["ramp"], ramp);
    // FEBio subtracts a body force.
    assert_eq!(scene["gravity_m_per_s2"], json!([-0.0, -0.0, -9.81]));
    assert_eq!(scene["contact"]["pairs"], json!([{"between": ["lower", "upper"], "friction": 0.3}]));
    assert_eq!(scene["contact"]["self_contact"], "none");
    assert_eq!(scene["integrator"], json!({"kind": "quasi_static", "step_s": 0.1}));
    assert_eq!(scene["end_time_s"], 1.0);
    load(scene.to_string().as_bytes(), &One(text), &Budget::COMMAND_LINE).unwrap();
}

#[test]
fn bodies_fly_with_their_initial_velocity() {
    let flying =
        "<Initial><ic type=\"velocity\" node_set=\"above\"><value>0,0,-3000</value></ic></Initial>\n";
    let scene = scene_of(&file(NEO_HOOKEAN, flying)).unwrap();
    assert_eq!(scene["bodies"][1]["velocity_m_per_s"], json!([0.0, 0.0, -3.0]));
    assert!(scene["bodies"][0].get("velocity_m_per_s").is_none());
    let found = refused(&file(NEO_HOOKEAN, &flying.replace("above", "top")));
    assert!(found[0].contains("line 31: <ic") && found[0].contains("a part of a body"), "{found:?}");
}

#[test]
fn what_has_no_counterpart_is_refused_with_its_line() {
    let whole = file(NEO_HOOKEAN, SECTIONS);
    let with = |from: &str, to: &str| {
        assert!(whole.contains(from), "{from}");
        refused(&whole.replace(from, to))
    };
    for (from, to, line, what) in [
        ("type=\"neo-Hookean\"", "type=\"Holmes-Mow\"", 3, "this law is not supported"),
        ("type=\"neo-Hookean\"", "type=\"rigid body\"", 3, "a rigid body that is free along Rx, Ry, Rz, Ru"),
        ("<E>0.1</E>", "<E type=\"map\">m</E>", 3, "not a constant number"),
        ("<v>0.4</v>", "<v>0.4</v><beta>1</beta>", 3, "<beta> in <material"),
        ("<v>0.4</v>", "", 3, "no <v>"),
        ("STATIC", "STEADY-STATE", 31, "steady-state"),
        ("type=\"zero displacement\"", "type=\"zero rotation\"", 32, "zero rotation"),
        ("node_set=\"bottom\"", "node_set=\"sole\"", 32, "\"sole\""),
        ("<relative>0", "<relative>1", 33, "relative"),
        ("<dof>z", "<dof>Rx", 33, "\"Rx\""),
        ("<linear>0", "<linear>1", 34, "does not follow"),
        ("type=\"pressure\"", "type=\"bearing load\"", 34, "bearing load"),
        ("<z lc=\"1\">", "<z lc=\"7\">", 35, "no load curve 7"),
        ("type=\"sliding-elastic\"", "type=\"tied-elastic\"", 36, "tied-elastic"),
        ("<penalty>5", "<tension>1</tension><penalty>5", 36, "tension"),
        ("<Output/>", "<Foo/>", 38, "<Foo"),
        ("<Output/>", "<Foo>1</Foo>", 38, "<Foo"),
        ("<Output/>", "<Rigid><rigid_bc type=\"rigid_fixed\"/></Rigid>", 38, "there is no rigid body"),
        ("<Output/>", "<Rigid><rigid_load type=\"rigid_force\"/></Rigid>", 38, "<rigid_load"),
        ("<Output/>", "<MeshData><ElementData type=\"shell thickness\"/></MeshData>", 38, "shell thickness"),
    ] {
        let found = with(from, to);
        let place = format!("line {line}: ");
        assert!(found.iter().any(|m| m.starts_with(&place) && m.contains(what)), "{to}: {found:?}");
    }
    let found = with("SMOOTH</interpolate><points><pt>0,0</pt>", "STEP</interpolate><points><pt>0,0</pt>");
    assert_eq!(found.len(), 3, "{found:?}");
    assert!(found.iter().all(|m| m.contains("\"STEP\" of 2 points")), "{found:?}");
    assert_eq!(with("type=\"solid\"", "type=\"biphasic\"").len(), 1);
}

#[test]
fn units_have_to_be_named_once() {
    let text = file(NEO_HOOKEAN, "").replace("<units>mm-N-s</units>", "");
    let found = scene_of(&text).unwrap_err();
    assert_eq!(
        [&*found.0[0].code, &found.0[0].remedy[..40]],
        [super::NO_UNITS, "give those of the file with --units: SI,"]
    );
    let asked = |text: &str, units| scene_of_febio(text.as_bytes(), "blocks.feb", Some(units)).unwrap().1;
    assert_eq!(asked(&text, UnitSystem::MmNewton).unwrap(), scene_of(&file(NEO_HOOKEAN, "")).unwrap());
    let found = asked(&file(NEO_HOOKEAN, ""), UnitSystem::Si).unwrap_err();
    assert!(found.0[0].message.contains("units other"), "{found:?}");
}

#[test]
fn files_of_version_2_5_and_3_0_have_other_words() {
    let old = file(
        NEO_HOOKEAN,
        "<Boundary><fix bc=\"x,y\" node_set=\"bottom\"/></Boundary>\n<Step><Control><time_steps>4</time_steps>\
         <step_size>0.25</step_size><analysis type=\"dynamic\"/></Control><Boundary><prescribe bc=\"z\" node_set=\"top\">\
         <scale lc=\"1\">-2</scale></prescribe></Boundary></Step>\n<LoadData><loadcurve id=\"1\" type=\"linear\"><point>0,0</point>\
         <point>1,1</point></loadcurve></LoadData>\n",
    );
    let domains =
        old.find("<MeshDomains>").unwrap()..old.find("</MeshDomains>").unwrap() + "</MeshDomains>".len();
    let mut old = old.replace("version=\"4.0\"", "version=\"2.5\"");
    old.replace_range(domains, "");
    let old = old.replace("Mesh>", "Geometry>").replace("type=\"hex8\"", "type=\"hex8\" mat=\"1\"");
    let scene = scene_of(&old).unwrap();
    assert_eq!(scene["bodies"][0]["fixed"], json!([{"set": "bottom", "axes": ["x", "y"]}]));
    assert_eq!(scene["bodies"][1]["prescribed"][0]["axes"], json!(["z"]));
    assert_eq!(scene["integrator"], json!({"kind": "auto"}));
    let new = file(
        NEO_HOOKEAN,
        "<Boundary><bc type=\"fix\" node_set=\"bottom\"><dofs>x,y</dofs></bc></Boundary>\n",
    );
    let new = new.replace("version=\"4.0\"", "version=\"3.0\"");
    assert_eq!(scene_of(&new).unwrap()["bodies"][0]["fixed"], scene["bodies"][0]["fixed"]);
}
