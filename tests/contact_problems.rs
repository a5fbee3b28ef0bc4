//! Saved frictional contact problems, solved by every solver: errors measured anew, references, agreement, bad input.
#![allow(clippy::unwrap_used, clippy::float_cmp)] // tests may panic; exactly is what is meant

use contuse::mechanics::contact::solution::delassus::Delassus;
use contuse::mechanics::contact::solution::local::natural_map;
use contuse::mechanics::contact::solution::problem::{ContactProblem, ProblemError};
use contuse::mechanics::contact::solution::solvers::{
    MatrixFree, Method, Options, SolveReport, solve, solve_frictionless, solve_matrix_free,
};
use contuse::record::{NamedContactProblem, contact_problem_document, read_contact_problem};
use serde_json::Value;
use std::path::{Path, PathBuf};

/// The one that no solver here solves to 1e-8 within a few seconds.
const HARDEST: &str = "28_RockPile_tob1";

fn files() -> Vec<PathBuf> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/contact_problems");
    let mut files: Vec<PathBuf> = std::fs::read_dir(folder).unwrap().map(|e| e.unwrap().path()).collect();
    files.retain(|path| path.extension().is_some_and(|e| e == "json"));
    files.sort();
    files
}

fn read(path: &Path) -> (Value, NamedContactProblem) {
    let bytes = std::fs::read(path).unwrap();
    (serde_json::from_slice(&bytes).unwrap(), read_contact_problem(&bytes, "").unwrap())
}

fn solve_from_rest(problem: &ContactProblem, options: &Options) -> (Vec<f64>, SolveReport) {
    let mut r = vec![0.0; problem.q().len()];
    let report = solve(problem, &mut r, options);
    (r, report)
}

/// The scaled error by its definition, without any of the library's sums.
fn error_by_definition(problem: &ContactProblem, r: &[f64]) -> f64 {
    let u = problem.velocity(r);
    let (mut f2, mut r2, mut q2) = (0.0, 0.0, 0.0);
    for c in 0..problem.contacts() {
        let at = |x: &[f64]| [x[3 * c], x[3 * c + 1], x[3 * c + 2]];
        let W = problem.W().diagonal_block(c);
        let d = (W[0][0] + W[1][1] + W[2][2]) / 3.0;
        let squared = |a: [f64; 3]| a.iter().map(|x| x * x).sum::<f64>();
        f2 += d * squared(natural_map(at(r), at(&u), problem.mu()[c], 1.0 / d));
        r2 += d * squared(at(r));
        q2 += squared(at(problem.q())) / d;
    }
    f2.sqrt() / r2.max(q2).sqrt()
}

fn distance(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b).powi(2)).sum::<f64>().sqrt()
}

fn size(a: &[f64]) -> f64 {
    a.iter().map(|a| a * a).sum::<f64>().sqrt()
}

#[test]
fn the_default_solves_all_problems_but_the_hardest() {
    let files = files();
    assert_eq!(files.len(), 22);
    for path in &files {
        let (_, NamedContactProblem { name, problem }) = read(path);
        if name == HARDEST {
            continue;
        }
        let (r, report) = solve_from_rest(&problem, &Options::default());
        assert!(report.converged && report.error_scaled <= 1e-8, "{name}: {report:?}");
        let error = error_by_definition(&problem, &r);
        assert!(error <= 1.000_001e-8, "{name}: {error:e}");
        assert!(report.failed_contacts == 0, "{name}: {report:?}");
    }
}

#[test]
fn the_hardest_problem_ends_as_a_best_iterate_that_says_so() {
    // Few iterations, so that the test is quick: what matters is that nothing is claimed.
    let path = files().into_iter().find(|p| p.to_string_lossy().contains(HARDEST)).unwrap();
    let (_, NamedContactProblem { problem, .. }) = read(&path);
    let options = Options { max_iterations: Some(150), ..Options::default() };
    let (r, report) = solve_from_rest(&problem, &options);
    assert!(!report.converged && report.error_scaled > 1e-8, "{report:?}");
    assert!(report.error_scaled < 0.1, "the best iterate is far from rest: {report:?}");
    assert!((error_by_definition(&problem, &r) / report.error_scaled - 1.0).abs() < 1e-6);
}

#[test]
fn solutions_of_reference_are_found() {
    let mut compared = 0;
    for path in files() {
        let (document, NamedContactProblem { name, problem }) = read(&path);
        let Some(reference) = document["reference"]["r"].as_array() else { continue };
        let reference: Vec<f64> = reference.iter().map(|x| x.as_f64().unwrap()).collect();
        assert!(problem.error_scaled(&reference) < 1e-12, "{name}: the reference is one");
        let options = Options { tolerance: 1e-11, ..Options::default() };
        let (r, report) = solve_from_rest(&problem, &options);
        let u = [problem.velocity(&r), problem.velocity(&reference)];
        // Friction on a rank deficient W has many solutions, and their slips need not agree.
        let unique = !name.contains("rankdef");
        if unique {
            assert!(report.converged, "{name}: {report:?}");
            assert!(distance(&r, &reference) <= 1e-7 * size(&reference), "{name}: reactions");
            assert!(distance(&u[0], &u[1]) <= 1e-7 * size(problem.q()), "{name}: velocities");
            compared += 1;
        }
    }
    assert_eq!(compared, 7);
}

#[test]
fn solvers_agree_on_what_they_solve() {
    // Full rank and of moderate size, so that the solution is one and the slow solvers are quick.
    for name in ["01_", "03_", "10_", "14_", "g01", "g02", "g03", "g05"] {
        let path = files().into_iter().find(|p| p.file_name().unwrap().to_string_lossy().starts_with(name));
        let (_, NamedContactProblem { name, problem }) = read(&path.unwrap());
        let (expected, _) = solve_from_rest(&problem, &Options { tolerance: 1e-12, ..Options::default() });
        for method in Method::ALL {
            let options = Options { method, tolerance: 1e-9, ..Options::default() };
            let (r, report) = solve_from_rest(&problem, &options);
            assert_eq!(report.converged, report.error_scaled <= 1e-9);
            if report.converged {
                let off = distance(&r, &expected) / size(&expected).max(f64::MIN_POSITIVE);
                assert!(r == expected || off < 1e-6, "{name} by {}: {off:e}", method.name());
            } else {
                assert!(method == Method::InteriorPoint, "{name} by {}: {report:?}", method.name());
            }
        }
    }
}

#[test]
fn normals_alone_give_the_reactions_of_three_rows_without_friction() {
    let mut compared = 0;
    for path in files().iter().filter(|p| p.to_string_lossy().contains("g0")) {
        let (_, NamedContactProblem { name, problem }) = read(path);
        let (n, rows) = (problem.contacts(), problem.q().len());
        let mut whole = vec![0.0; rows * rows];
        problem.W().for_each_block(|c, d, block| {
            for (i, j) in (0..9).map(|k| (k / 3, k % 3)) {
                whole[(3 * c + i) * rows + 3 * d + j] = block[i][j];
            }
        });
        let W: Vec<f64> = (0..n * n).map(|k| whole[3 * (k / n) * rows + 3 * (k % n)]).collect();
        let q: Vec<f64> = problem.q().iter().step_by(3).copied().collect();
        let options = Options { tolerance: 1e-12, ..Options::default() };
        let mut r = vec![0.0; n];
        let report = solve_frictionless(&W, &q, &mut r, &options).unwrap();
        let without =
            ContactProblem::new(Delassus::dense(n, whole).unwrap(), problem.q().to_vec(), vec![0.0; n]);
        let (expected, other) = solve_from_rest(&without.unwrap(), &options);
        if report.converged && other.converged && !name.contains("rankdef") {
            let expected: Vec<f64> = expected.iter().step_by(3).copied().collect();
            assert!(distance(&r, &expected) <= 1e-8 * size(&expected).max(f64::MIN_POSITIVE), "{name}");
            compared += 1;
        }
    }
    assert!(compared >= 4, "{compared}");
    let nonsense = solve_frictionless(&[f64::NAN], &[-1.0], &mut [0.0], &Options::default());
    assert!(matches!(nonsense, Err(ProblemError::NotFinite { array: "W", .. })));
}

#[test]
fn the_same_problem_has_the_same_bits() {
    let (_, NamedContactProblem { problem, .. }) = read(&files()[8]);
    let solutions: Vec<_> = (0..2).map(|_| solve_from_rest(&problem, &Options::default())).collect();
    assert_eq!(solutions[0], solutions[1]);
}

#[test]
fn units_do_not_matter() {
    let (_, NamedContactProblem { problem, .. }) = read(&files()[6]);
    let (_, expected) = solve_from_rest(&problem, &Options::default());
    // W in other units of mass, q in others of speed.
    let mut blocks = Vec::new();
    problem.W().for_each_block(|c, d, block| blocks.push((c, d, block.map(|row| row.map(|x| x * 1024.0)))));
    let W = Delassus::from_blocks(problem.contacts(), blocks).unwrap();
    let q = problem.q().iter().map(|q| q / 4096.0).collect();
    let scaled = ContactProblem::new(W, q, problem.mu().to_vec()).unwrap();
    let (_, report) = solve_from_rest(&scaled, &Options::default());
    assert!(report.converged);
    assert!((report.error_scaled - expected.error_scaled).abs() <= 1e-9);
}

#[test]
fn odd_input_is_solved_or_reported() {
    let eye = |w: f64| vec![w, 0.0, 0.0, 0.0, w, 0.0, 0.0, 0.0, w];
    let problem = |W: Vec<f64>, q: [f64; 3], mu: f64| {
        ContactProblem::new(Delassus::dense(1, W).unwrap(), q.to_vec(), vec![mu])
    };
    for method in Method::ALL {
        let options = Options { method, ..Options::default() };
        let solved =
            |W: Vec<f64>, q: [f64; 3], mu: f64| solve_from_rest(&problem(W, q, mu).unwrap(), &options);
        // Nothing is requested, nothing moves, nothing rubs, everything sticks.
        assert_eq!(solved(eye(1.0), [0.0; 3], 0.5).0, [0.0; 3], "{method:?}");
        assert!(solved(eye(0.0), [1.0, 2.0, 0.0], 0.5).1.converged, "{method:?}");
        assert!(!solved(eye(0.0), [-1.0, 0.0, 0.0], 0.5).1.converged, "{method:?}: a wall cannot give way");
        assert!(solved(eye(1e6), [-1.0, 0.3, 0.0], 0.0).1.converged, "{method:?}: light masses");
        let (r, report) = solved(eye(2.0), [-1.0, 0.3, 0.2], 1e3);
        // Steps of the size of 1/‖W‖ take too many iterations where μ is huge, and say so.
        let sure = [Method::Hybrid, Method::Frictionless, Method::Nsgs, Method::Newton, Method::Proximal];
        assert!(report.converged || !sure.contains(&method), "{method:?}: {report:?}");
        assert!(!report.converged || (r[1] + 0.15).abs() < 1e-6, "{method:?}: {r:?}");
    }
    let not_finite = problem(eye(f64::NAN), [0.0; 3], 0.5);
    assert!(matches!(not_finite, Err(ProblemError::NotFinite { array: "W", .. })));
    assert!(matches!(problem(eye(1.0), [f64::NAN; 3], 0.5), Err(ProblemError::NotFinite { array: "q", .. })));
    assert!(matches!(problem(eye(1.0), [0.0; 3], -0.1), Err(ProblemError::Friction { .. })));
    // A start that is no number is no start.
    let mut r = [f64::NAN; 3];
    assert!(solve(&problem(eye(1.0), [-1.0, 0.0, 0.0], 0.5).unwrap(), &mut r, &Options::default()).converged);
    assert_eq!(r, [1.0, 0.0, 0.0]);
    // Nor is one whose square overflows.
    let mut r = [1e300, -1e200, 0.0];
    assert!(solve(&problem(eye(1.0), [-1.0, 0.0, 0.0], 0.5).unwrap(), &mut r, &Options::default()).converged);
    assert_eq!(r, [1.0, 0.0, 0.0]);
}

#[test]
fn a_file_of_another_order_or_beyond_all_size_is_refused() {
    let sound = serde_json::json!({
        "name": "one", "nc": 1, "frame": "per contact (n,t1,t2): index 3*c is normal", "mu": [0.3], "q": [-1, 0, 0],
        "W": {"format": "dense", "order": "row-major", "shape": [3, 3], "v": [1, 0, 0, 0, 1, 0, 0, 0, 1]}
    });
    assert!(read_contact_problem(sound.to_string().as_bytes(), "").is_ok());
    let breaks = [
        ("/frame", serde_json::json!("per contact (t1,t2,n)")),
        ("/W/order", serde_json::json!("column-major")),
        ("/W/shape", serde_json::json!([3, 1])),
        ("/W/v/4", serde_json::json!(1e308)),
        ("/q/0", serde_json::json!(-1e200)),
    ];
    for (pointer, value) in breaks {
        let mut document = sound.clone();
        *document.pointer_mut(pointer).unwrap() = value.clone();
        let problems = read_contact_problem(document.to_string().as_bytes(), "").unwrap_err();
        let [problem] = &problems.0[..] else { panic!("{pointer}: {problems}") };
        assert_eq!((&problem.pointer[..], &problem.value), (pointer, &value));
        assert!(!problem.limit.is_empty() && !problem.remedy.is_empty(), "{problem}");
    }
    // What no single entry shows: next to nothing moves.
    let tiny = Delassus::dense(1, vec![1e-300, 0.0, 0.0, 0.0, 1e-300, 0.0, 0.0, 0.0, 1e-300]).unwrap();
    let refused = ContactProblem::new(tiny, vec![-1.0, 0.0, 0.0], vec![0.3]);
    assert!(matches!(refused, Err(ProblemError::OutOfRange { array: "W", index: 0, .. })));
}

#[test]
fn a_problem_is_read_as_it_was_written() {
    for path in [&files()[6], &files()[14]] {
        let (_, named) = read(path);
        let text = contact_problem_document(&named, "a test").to_string();
        let again = read_contact_problem(text.as_bytes(), "").unwrap();
        let r: Vec<f64> = (0..named.problem.q().len()).map(|i| (i as f64).sin()).collect();
        assert_eq!(again.problem.q(), named.problem.q());
        assert!(distance(&again.problem.velocity(&r), &named.problem.velocity(&r)) <= 1e-9 * size(&r));
    }
}

#[test]
fn every_problem_of_a_bad_file_is_reported_with_its_place() {
    let bad = br#"{"name": 1, "nc": 2, "mu": [0.3], "q": [0, "a", 1], "W": {"format": "coo", "i": [9], "j": [0], "v": [1]}}"#;
    let problems = read_contact_problem(bad, "x.json#").unwrap_err();
    let places: Vec<&str> = problems.0.iter().map(|p| p.pointer.as_str()).collect();
    assert_eq!(places, ["x.json#/name", "x.json#/q/1", "x.json#/nc", "x.json#/W/i/0"]);
    for text in ["", "[]", "{}", r#"{"name": "a", "mu": [], "q": [], "W": {"format": "sym-upper-b64"}}"#] {
        assert!(read_contact_problem(text.as_bytes(), "").is_err(), "{text}");
    }
}

proptest::proptest! {
    #![proptest_config(proptest::test_runner::Config::with_cases(64))]

    #[test]
    fn random_problems_are_solved(
        contacts in 1_usize..12,
        rank in 1_usize..40,
        numbers in proptest::collection::vec(-1.0_f64..1.0, 40 * 36 + 36),
        mu in 0.0_f64..0.9,
    ) {
        // W = A Aᵀ of any rank, q = A v: with velocities that reactions can stop, a solution exists (Acary et al. 2011).
        let n = 3 * contacts;
        let a = |i: usize, k: usize| numbers[40 * i + k];
        let v = &numbers[40 * 36..];
        let W = (0..n * n).map(|ij| (0..rank).map(|k| a(ij / n, k) * a(ij % n, k)).sum::<f64>()).collect();
        let q = (0..n).map(|i| (0..rank).map(|k| a(i, k) * v[k % 36]).sum::<f64>()).collect();
        let problem = ContactProblem::new(Delassus::dense(contacts, W).unwrap(), q, vec![mu; contacts]).unwrap();
        let options = Options { max_iterations: Some(3000), ..Options::default() };
        let (r, report) = solve_from_rest(&problem, &options);
        // What is said of the solution is true, whatever is said.
        let error = error_by_definition(&problem, &r);
        proptest::prop_assert!((error - report.error_scaled).abs() <= 1e-12 + 1e-6 * error);
        proptest::prop_assert!(!report.converged || report.error_scaled <= 1e-8);
        // Where W is regular with room to spare, there is a solution, and it is found.
        proptest::prop_assert!(report.converged || rank < n + 4, "{:?}, rank {} of {}", report, rank, n);
    }
}

#[test]
fn products_with_w_are_enough() {
    for name in
        ["12_OneObject-i1028", "g05_hex_36c_nu4999", "g10_hex_196c_mixedmu_nu4999", "g12_hex_400c_nu49_mu06"]
    {
        let path =
            Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("tests/data/contact_problems/{name}.json"));
        let (_, NamedContactProblem { problem, .. }) = read(&path);
        let zero = vec![0.0; problem.q().len()];
        let diagonal: Vec<_> = (0..problem.contacts()).map(|c| problem.W().diagonal_block(c)).collect();
        let mut products_of = Vec::new();
        for method in [Method::AcceleratedGradient, Method::Hybrid] {
            let mut products = 0;
            let product = &mut |r: &[f64], u: &mut [f64]| {
                products += 1;
                problem.W().apply(r, &zero, u);
            };
            let mut r = zero.clone();
            let mut free = MatrixFree { product, diagonal: &diagonal, q: problem.q(), mu: problem.mu() };
            let options = Options { method, ..Options::default() };
            let report = solve_matrix_free(&mut free, &mut r, &options).unwrap();
            assert!(report.converged, "{name}: {report:?}");
            assert!(error_by_definition(&problem, &r) <= 1e-8, "{name}");
            // Products with W sum in another order than its stored rows: the error, a difference of near equals, is equal to rounding.
            let difference = (report.error_scaled - problem.error_scaled(&r)).abs();
            assert!(difference <= 1e-6 * report.error_scaled, "{name}: {difference:e}");
            // Two products an iteration, those of the step's length, and those at both ends.
            let is_gradient = report.solver == Method::AcceleratedGradient;
            assert!(!is_gradient || products <= 2 * report.iterations + 32, "{name}: {products} products");
            products_of.push(products);
        }
        // Newton steps need fewer.
        assert!(2 * products_of[1] < products_of[0], "{name}: {products_of:?}");
    }
}

#[test]
fn nodes_held_along_a_tangent_do_not_slow_newton_steps() {
    // As in a plane of symmetry: along a tangent every third contact has no compliance but rounding.
    let (_, NamedContactProblem { problem, .. }) = read(
        &Path::new(env!("CARGO_MANIFEST_DIR"))
            .join("tests/data/contact_problems/g12_hex_400c_nu49_mu06.json"),
    );
    let part = |i: usize| if i % 9 == 2 { 1e-16 } else { 1.0 };
    let parts = |x: &[f64]| x.iter().enumerate().map(|(i, x)| part(i) * x).collect::<Vec<f64>>();
    let (zero, q) = (vec![0.0; problem.q().len()], parts(problem.q()));
    let block = |c: usize| {
        let own = problem.W().diagonal_block(c);
        std::array::from_fn(|i| std::array::from_fn(|j| part(3 * c + i) * own[i][j] * part(3 * c + j)))
    };
    let diagonal: Vec<_> = (0..problem.contacts()).map(block).collect();
    let product = &mut |r: &[f64], u: &mut [f64]| {
        problem.W().apply(&parts(r), &zero, u);
        let held = parts(u);
        u.copy_from_slice(&held);
    };
    let mut free = MatrixFree { product, diagonal: &diagonal, q: &q, mu: problem.mu() };
    let report = solve_matrix_free(&mut free, &mut zero.clone(), &Options::default()).unwrap();
    assert!(report.converged && report.solver == Method::Newton, "{report:?}");
}

#[test]
fn products_with_nonsense_are_refused() {
    let diagonal = [[[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]];
    let solve = |q: &[f64], mu: &[f64]| {
        let product = &mut |r: &[f64], u: &mut [f64]| u.copy_from_slice(r);
        let mut free = MatrixFree { product, diagonal: &diagonal, q, mu };
        solve_matrix_free(&mut free, &mut [0.0; 3], &Options::default()).unwrap_err()
    };
    assert_eq!(solve(&[0.0; 2], &[0.3]), ProblemError::Length { array: "q", expected: 3, given: 2 });
    assert_eq!(solve(&[0.0, f64::NAN, 0.0], &[0.3]), ProblemError::NotFinite { array: "q", index: 1 });
    // Full stick has no cone to project on.
    assert_eq!(solve(&[0.0; 3], &[f64::INFINITY]), ProblemError::Friction { contact: 0, mu: f64::INFINITY });
}

/// Reactions that were printed are taken as a start, by the name of the problem: nothing is left to do.
#[test]
fn contact_problems_start_from_given_reactions() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
    let problem =
        Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/contact_problems/12_OneObject-i1028.json");
    let problem = problem.to_str().unwrap();
    let solve = |more: &[&str]| {
        let mut command = std::process::Command::new(env!("CARGO_BIN_EXE_contuse"));
        command.args(["contact-problem", "--json", problem]).args(more).output().unwrap()
    };
    let from_rest = solve(&[]);
    std::fs::write(path("start.json"), &from_rest.stdout).unwrap();
    let iterations = |output: &std::process::Output| {
        let rows: Value = serde_json::from_slice(&output.stdout).unwrap();
        assert_eq!(rows[0]["converged"], true);
        rows[0]["iterations"].as_u64().unwrap()
    };
    assert!(iterations(&from_rest) > 0);
    assert_eq!(iterations(&solve(&["--start", &path("start.json")])), 0);
    // The table has what is left of the free velocities, too.
    let mut command = std::process::Command::new(env!("CARGO_BIN_EXE_contuse"));
    let table =
        String::from_utf8(command.args(["contact-problem", problem]).output().unwrap().stdout).unwrap();
    assert!(table.contains("of free  of motion"), "{table}");
    // Of another problem, of another length, and beyond all size.
    let start = |name: &str, r: &[f64]| serde_json::json!([{"name": name, "r": r}]).to_string();
    let mut large = [0.0; 69];
    large[68] = -1e300;
    let (other, own) = ("other", "12_OneObject-i1028");
    let wrong = [
        (start(other, &[]), "no reactions of 12_OneObject-i1028"),
        (start(own, &[0.0; 3]), "needs 69"),
        (start(own, &large), "r[68] of 12_OneObject-i1028 is -1e300, at most 1e100"),
    ];
    for (start, said) in wrong {
        std::fs::write(path("start.json"), start).unwrap();
        let output = solve(&["--start", &path("start.json")]);
        assert_eq!(output.status.code(), Some(2));
        let answer = String::from_utf8_lossy(&output.stderr);
        assert!(answer.contains(said), "{answer}");
    }
}

/// Reactions beside which the free velocities are lost in rounding hide neither a contact that opens nor one that must be stopped.
#[test]
fn reactions_beyond_rounding_are_no_start() {
    let unit = |i: usize, j: usize| if i == j { 1.0 } else { 0.0 };
    let between_two =
        |i: usize, j: usize| if (i < 3) == (j < 3) { unit(i % 3, j % 3) } else { -unit(i % 3, j % 3) };
    let problem = |contacts: usize, w: &dyn Fn(usize, usize) -> f64, q: &[f64]| {
        let n = 3 * contacts;
        let W = Delassus::dense(contacts, (0..n * n).map(|k| w(k / n, k % n)).collect()).unwrap();
        ContactProblem::new(W, q.to_vec(), vec![0.5; contacts]).unwrap()
    };
    let opening = problem(2, &between_two, &[0.0, 0.0, 0.0, 0.5, 0.0, 0.0]);
    let approaching = problem(1, &unit, &[-1.0, 0.1, 0.0]);
    for large in [1e8, 1e16, 1e100] {
        let start = [large, 0.0, 0.0, large, 0.0, 0.0];
        let errors = opening.errors(&start);
        assert!(errors.of_motion >= 1.0 - 1e-12, "{large}: {errors:?}");
        for method in [Method::Hybrid, Method::Nsgs, Method::Newton, Method::Uzawa, Method::Proximal] {
            for problem in [&opening, &approaching] {
                let mut r = start[..problem.q().len()].to_vec();
                let report = solve(problem, &mut r, &Options { method, ..Options::default() });
                assert!(report.converged && size(&r) < 1.1, "{large}, {method:?}: {report:?}, {r:?}");
            }
        }
    }
}
