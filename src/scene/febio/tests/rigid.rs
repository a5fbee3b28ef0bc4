//! Rigid bodies and axes of elements of small FEBio files, against the same scenes written as documents.

use super::{NEO_HOOKEAN, One, file, refused, scene_of, scene_of_febio};
use crate::mechanics::tensor::Vec3;
use crate::scene::{Budget, load};
use serde_json::{Value, json};

/// The file with the upper block, or another part, as a rigid body.
fn rigid(part: &str, sections: &str) -> String {
    let punch = "<material id=\"2\" name=\"punch\" type=\"rigid body\"><density>7.8e-9</density><E>1</E><v>0.3</v>\
         <center_of_mass>5,5,16</center_of_mass></material></Material>";
    let text = file(NEO_HOOKEAN, sections).replace("</Material>", punch);
    text.replace(&format!("name=\"{part}\" mat=\"stuff\""), &format!("name=\"{part}\" mat=\"punch\""))
}

const FIXED: &str =
    "<Rx_dof>1</Rx_dof><Ry_dof>1</Ry_dof><Ru_dof>1</Ru_dof><Rv_dof>1</Rv_dof><Rw_dof>1</Rw_dof>";

/// The upper block comes down on the lower one, and moves along.
fn sections() -> String {
    format!(
        "<Control><analysis>STATIC</analysis><time_steps>10</time_steps><step_size>0.1</step_size></Control>\n\
         <Boundary><bc type=\"zero displacement\" node_set=\"bottom\"><x_dof>1</x_dof><y_dof>1</y_dof><z_dof>1</z_dof></bc></Boundary>\n\
         <Rigid><rigid_bc name=\"held\" type=\"rigid_fixed\"><rb>punch</rb>{FIXED}</rigid_bc>\n\
         <rigid_bc name=\"down\" type=\"rigid_displacement\"><rb>2</rb><dof>z</dof><value lc=\"1\">-2</value></rigid_bc></Rigid>\n\
         <Contact><contact type=\"sliding-elastic\" surface_pair=\"gap\"><fric_coeff>0.3</fric_coeff></contact></Contact>\n\
         <LoadData><load_controller id=\"1\" type=\"loadcurve\"><points><pt>0,0</pt><pt>1,1</pt></points></load_controller></LoadData>\n"
    )
}

#[test]
fn a_rigid_part_that_is_moved_is_a_body_of_prescribed_nodes() {
    let text = rigid("upper", &sections());
    let scene = scene_of(&text).unwrap();
    let ramp = json!({"kind": "table", "times_s": [0.0, 1.0], "factors": [0.0, 1.0]});
    let by_hand = json!({
        "name": "blocks", "description": scene["description"], "end_time_s": 1.0,
        "integrator": {"kind": "quasi_static", "step_s": 0.1},
        "contact": {"pairs": [{"between": ["lower", "upper"], "friction": 0.3}], "self_contact": "none"},
        "bodies": [
            {"name": "lower", "role": "tissue", "placement": scene["bodies"][0]["placement"],
             "mesh": {"file": {"name": "blocks.feb", "parts": ["lower"]}},
             "parts": scene["bodies"][0]["parts"], "fixed": [{"set": "bottom", "axes": ["x", "y", "z"]}]},
            {"name": "upper", "role": "projectile", "placement": scene["bodies"][1]["placement"],
             "mesh": {"file": {"name": "blocks.feb", "parts": ["upper"]}},
             "parts": [{"part": "upper", "density_kg_per_m3": 1000.0,
                        "material": {"law": "neo_hookean", "c10_pa": 1000.0, "bulk_modulus_pa": 1e5}}],
             "fixed": [{"set": "upper", "axes": ["x", "y"]}],
             "prescribed": [{"set": "upper", "displacement_m": [0.0, 0.0, -0.002], "axes": ["z"], "ramp": ramp}]}
        ]
    });
    let loaded = |scene: &Value| {
        load(scene.to_string().as_bytes(), &One(text.clone()), &Budget::COMMAND_LINE).unwrap().scene
    };
    let [own, by_hand] = [loaded(&scene), loaded(&by_hand)];
    assert_eq!(own.document, by_hand.document);
    assert_eq!(own.content_hash, by_hand.content_hash);
    assert_eq!(own.bodies[1].mesh.node_sets["upper"].len(), 8);
    // Sets of the file keep their names.
    let named = text.replace("NodeSet name=\"above\"", "NodeSet name=\"upper\"");
    let fixed = &scene_of(&named).unwrap()["bodies"][1]["fixed"];
    assert_eq!(fixed, &json!([{"set": "upper_rigid_body", "axes": ["x", "y"]}]));
}

#[test]
fn nodes_that_move_with_a_rigid_body_have_its_motion() {
    // The upper block is held as a whole, and so is the top of the lower one.
    let held = format!(
        "<Boundary><bc type=\"rigid\" node_set=\"bottom\"><rb>punch</rb></bc></Boundary>\n\
         <Rigid><rigid_bc type=\"rigid_fixed\"><rb>punch</rb>{FIXED}<Rz_dof>1</Rz_dof></rigid_bc></Rigid>\n"
    );
    let scene = scene_of(&rigid("upper", &held)).unwrap();
    let all = ["x", "y", "z"];
    assert_eq!(scene["bodies"][0]["fixed"], json!([{"set": "bottom", "axes": all}]));
    assert_eq!(scene["bodies"][1]["fixed"], json!([{"set": "upper", "axes": all}]));
    // The same in the words of versions 3.0 and 2.5.
    let older = "<Boundary><bc type=\"rigid\" node_set=\"bottom\"><rb>2</rb></bc></Boundary>\n\
         <Rigid><rigid_constraint type=\"fix\"><rb>2</rb><dofs>Rx,Ry,Ru,Rv,Rw</dofs></rigid_constraint>\
         <rigid_constraint type=\"prescribe\"><rb>2</rb><dof>Rz</dof><value>1</value></rigid_constraint></Rigid>\n";
    let moved = scene_of(&rigid("upper", older).replace("version=\"4.0\"", "version=\"3.0\"")).unwrap();
    let old = "<Boundary><rigid rb=\"2\" node_set=\"bottom\"/><rigid_body mat=\"2\"><fixed bc=\"x\"/><fixed bc=\"y\"/><fixed bc=\"Rx\"/>\
         <fixed bc=\"Ry\"/><fixed bc=\"Rz\"/><prescribed bc=\"z\">1</prescribed></rigid_body></Boundary>\n";
    assert_eq!(scene_of(&rigid("upper", old)).unwrap(), moved);
    assert_eq!(moved["bodies"][1]["prescribed"][0]["displacement_m"], json!([0.0, 0.0, 0.001]));
    assert_eq!(moved["bodies"][0]["prescribed"][0]["set"], "bottom");
}

#[test]
fn a_rigid_part_of_a_body_keeps_its_elements_and_holds_what_it_shares() {
    // The upper block stands on the lower one, and shares its nodes.
    let text = rigid("upper", &sections().replace("<Contact>", "<!--").replace("</Contact>", "-->"));
    let text = text.replace("9,10,11,12,13,14,15,16</elem>", "5,6,7,8,13,14,15,16</elem>");
    let text = text.replace("<quad4 id=\"1\">9,12,11,10</quad4>", "<quad4 id=\"1\">13,14,15,16</quad4>");
    let scene = scene_of(&text).unwrap();
    let bodies = scene["bodies"].as_array().unwrap();
    assert_eq!((bodies.len(), bodies[0]["parts"].as_array().unwrap().len()), (1, 2));
    assert_eq!(bodies[0]["fixed"][1], json!({"set": "upper", "axes": ["x", "y"]}));
    assert_eq!(bodies[0]["prescribed"][0]["set"], "upper");
    let loaded = load(scene.to_string().as_bytes(), &One(text), &Budget::COMMAND_LINE).unwrap();
    assert_eq!(loaded.scene.bodies[0].mesh.node_sets["upper"].len(), 8);
}

#[test]
fn rigid_bodies_that_are_free_or_turn_are_refused_with_their_line() {
    let whole = sections();
    for (from, to, line, what) in [
        ("<Rw_dof>1</Rw_dof>", "", 3, "free along Rw"),
        ("<Rx_dof>1", "<Rx_dof>0", 3, "free along Rx"),
        ("<rb>punch</rb>", "<rb>stuff</rb>", 33, "there is no rigid body \"stuff\""),
        ("<dof>z", "<dof>Ru", 34, "a prescribed rotation"),
        ("<dof>z", "<dof>q", 34, "the degree of freedom \"q\""),
        ("<dof>z", "<dof>x", 34, "a second motion of a rigid body"),
        ("<dof>z", "<relative>1</relative><dof>z", 34, "relative"),
        ("rigid_displacement", "rigid_rotation", 34, "rigid_rotation"),
        ("<rb>2", "<force>1</force><rb>2", 34, "<force>"),
    ] {
        assert!(whole.contains(from), "{from}");
        let found = refused(&rigid("upper", &whole.replace(from, to)));
        let place = format!("line {line}: ");
        assert!(found.iter().any(|m| m.starts_with(&place) && m.contains(what)), "{to}: {found:?}");
    }
}

const FIBRES: &str = "type=\"trans iso Mooney-Rivlin\"><density>1e-9</density><c1>0.01</c1><c3>0.01</c3><c4>10</c4><c5>1</c5><lam_max>1.1</lam_max><k>10</k>";

#[test]
fn axes_of_elements_are_those_of_the_mesh() {
    let data = |kind: &str, lower: &str| {
        format!(
            "<MeshData><ElementData type=\"{kind}\" elem_set=\"lower\"><elem lid=\"1\">{lower}</elem></ElementData></MeshData>\n"
        )
    };
    let text = file(FIBRES, &data("fiber", "0,3,4"));
    let (mesh, scene) = scene_of_febio(text.as_bytes(), "blocks.feb", None).unwrap();
    let scene = scene.unwrap();
    assert_eq!(scene["bodies"][0]["parts"][0]["fibre_frame"], json!({"kind": "mesh"}));
    assert!(scene["bodies"][1]["parts"][0].get("fibre_frame").is_none());
    let e1 = mesh.axes[0][0];
    assert!((e1.x.abs() + (e1.y - 0.6).abs() + (e1.z - 0.8).abs()) < 1e-15, "{e1}");
    assert_eq!(mesh.axes[1][0], Vec3::x());
    assert!(!mesh.notes.iter().any(|note| note.contains("MeshData")), "{:?}", mesh.notes);
    // The run reads the same file.
    let mut full = scene.clone();
    full["end_time_s"] = json!(0.01);
    let bodies = full["bodies"].as_array_mut().unwrap();
    bodies[1]["velocity_m_per_s"] = json!([0, 0, -1]);
    let loaded = load(full.to_string().as_bytes(), &One(text), &Budget::COMMAND_LINE).unwrap();
    assert!((loaded.scene.bodies[0].axes[0].column(0) - e1).norm() < 1e-15);

    let text = file(FIBRES, &data("mat_axis", "<a>0,0,2</a><d>0,1,1</d>"));
    let (mesh, _) = scene_of_febio(text.as_bytes(), "blocks.feb", None).unwrap();
    let [e1, e2, e3] = mesh.axes[0];
    assert!((e1.z - 1.0).abs() + (e2.y - 1.0).abs() + (e3.x + 1.0).abs() < 1e-15, "{e1} {e2} {e3}");
    let broken = |kind: &str, lower: &str| {
        scene_of_febio(file(FIBRES, &data(kind, lower)).as_bytes(), "blocks.feb", None)
            .unwrap_err()
            .to_string()
    };
    for (kind, lower, what) in [
        ("fiber", "0,0,0", "expected a direction of three numbers, found \"0,0,0\""),
        ("mat_axis", "<a>1,0,0</a>", "<elem> has no <d>"),
        ("mat_axis", "<a>1,0,0</a><d>-2,0,0</d>", "are parallel"),
    ] {
        let found = broken(kind, lower);
        assert!(found.starts_with("line 31: ") && found.contains(what), "{found}");
    }
    let [other, far] =
        [("elem_set=\"lower\"", "elem_set=\"x\""), ("lid=\"1\"", "lid=\"2\"")].map(|(from, to)| {
            let text = file(FIBRES, &data("fiber", "1,0,0")).replace(from, to);
            scene_of_febio(text.as_bytes(), "blocks.feb", None).unwrap_err().to_string()
        });
    assert!(other.contains("there is no element set \"x\""), "{other}");
    assert!(far.contains("lid 2 is no volume element of its set, which has 1 elements"), "{far}");
    let twice = FIBRES.to_owned() + "<mat_axis type=\"vector\"><a>1,0,0</a><d>0,1,0</d></mat_axis>";
    let found = refused(&file(&twice, &data("fiber", "1,0,0")));
    assert!(
        found[0].starts_with("line 3: ") && found[0].contains("beside those of the elements"),
        "{found:?}"
    );
}
