//! The function language beside Radiance's own programs, live.

#[path = "cal/cases.rs"]
mod cases;
#[path = "cal/radiance.rs"]
mod radiance;

use bsdftree_device::cal::{CalError, Context, Inputs, Scratch};
use bsdftree_testing::radiance::{programs, pyradiance};
use bsdftree_testing::real_folder;
use proptest::prelude::*;
use proptest::strategy::ValueTree;
use proptest::test_runner::TestRunner;
use radiance::{ARGUMENTS, Ray};

/// What we make of definitions and an expression: the value and the number of faults.
fn ours(definitions: &str, expression: &str) -> Result<(f64, u32), CalError> {
    let mut context = Context::new();
    context.define(definitions)?;
    let mut scratch = Scratch::default();
    let value = context.compile(expression)?.evaluate_in(&(), &mut scratch)?;
    Ok((value, scratch.faults()))
}

fn agree(a: f64, b: f64, tolerance: f64) -> bool {
    a == b || (a - b).abs() <= tolerance * a.abs().max(b.abs()).max(1.0)
}

#[test]
fn hand_written_cases_are_as_in_rcalc() {
    if programs().is_none() {
        return;
    }
    assert!(cases::CASES.len() >= 200, "{}", cases::CASES.len());
    let mut wrong = vec![];
    for (definitions, expression) in cases::CASES {
        let theirs = radiance::rcalc(&format!("{definitions};$1 = {expression};")).map(|values| values[0]);
        let ours = ours(definitions, expression);
        let same = match (&ours, theirs) {
            (Err(_), None) => true,
            (Ok((value, _)), Some(theirs)) => agree(*value, theirs, 1e-14),
            _ => false,
        };
        if !same {
            wrong.push(format!("{definitions} | {expression}: {ours:?}, rcalc {theirs:?}"));
        }
    }
    assert!(wrong.is_empty(), "{} of {}:\n{}", wrong.len(), cases::CASES.len(), wrong.join("\n"));
}

const HELPERS: &str = "a = 1.5; b = -2; c = .25; d = 3; k : 4; z = 0;
    sq(x) = x*x; lin(t, p, q) = (1 - t)*p + t*q; pick(i, x, y) = if(i, x, y); on(f, x) = f(x);
    run(n, x) = if(n - .5, run(n - 1, x/2 + 1), x);";

/// Expressions whose values are exact in binary, so that steps and decisions fall the same way everywhere.
fn exact() -> impl Strategy<Value = String> {
    let leaf = prop_oneof![
        proptest::sample::select(vec!["a", "b", "c", "d", "k", "z", "0", "1", "2", ".5", "1.75", "8"])
            .prop_map(str::to_owned),
    ];
    leaf.prop_recursive(4, 40, 4, |inner| {
        let pair = (inner.clone(), inner.clone());
        prop_oneof![
            (pair.clone(), proptest::sample::select(vec!["+", "-", "*"]))
                .prop_map(|((l, r), op)| format!("{l}{op}({r})")),
            (pair.clone(), proptest::sample::select(vec!["+", "-"]))
                .prop_map(|((l, r), op)| format!("({l}){op}{r}")),
            inner.clone().prop_map(|x| format!("-({x})")),
            inner.clone().prop_map(|x| format!("floor({x})")),
            inner.clone().prop_map(|x| format!("ceil(({x})*.5)")),
            inner.clone().prop_map(|x| format!("sq({x})")),
            inner.clone().prop_map(|x| format!("on(sq, {x})")),
            inner.clone().prop_map(|x| format!("run(3, {x})")),
            inner.clone().prop_map(|x| format!("({x})^2")),
            inner.clone().prop_map(|x| format!("({x})/4")),
            pair.clone().prop_map(|(x, y)| format!("max({x}, {y}, 1)")),
            pair.clone().prop_map(|(x, y)| format!("min({x}, {y})")),
            (inner.clone(), pair.clone()).prop_map(|(x, (y, z))| format!("if({x}, {y}, {z})")),
            (inner.clone(), pair.clone()).prop_map(|(x, (y, z))| format!("pick({x}, {y}, {z})")),
            (inner.clone(), pair.clone()).prop_map(|(x, (y, z))| format!("lin({x}, {y}, {z})")),
            (inner.clone(), pair).prop_map(|(x, (y, z))| format!("select({x}, {y}, {z}, 7)")),
        ]
    })
}

/// Smooth functions of exact values.
fn smooth() -> impl Strategy<Value = String> {
    let unary = |inner: BoxedStrategy<String>| {
        let names = vec!["sin", "cos", "atan", "tan"];
        (inner, proptest::sample::select(names)).prop_map(|(x, f)| format!("{f}({x})"))
    };
    let leaf = unary(exact().prop_map(|x| format!("({x})/16")).boxed());
    leaf.prop_recursive(3, 16, 3, move |inner| {
        let pair = (inner.clone(), inner.clone());
        prop_oneof![
            pair.clone().prop_map(|(x, y)| format!("({x})*({y})")),
            pair.clone().prop_map(|(x, y)| format!("({x}) + ({y})")),
            pair.clone().prop_map(|(x, y)| format!("({x})/(2 + cos({y}))")),
            pair.clone().prop_map(|(x, y)| format!("(2 + sin({x}))^sin({y})")),
            pair.clone().prop_map(|(x, y)| format!("atan2({x}, 2 + cos({y}))")),
            inner.clone().prop_map(|x| format!("exp(sin({x}))")),
            inner.clone().prop_map(|x| format!("sqrt(2 + sin({x}))")),
            inner.clone().prop_map(|x| format!("log(2 + cos({x}))")),
            inner.clone().prop_map(|x| format!("log10(2 + cos({x}))")),
            inner.clone().prop_map(|x| format!("acos(sin({x})/2)")),
            inner.prop_map(|x| format!("on(asin, cos({x})/2)")),
        ]
    })
}

fn assert_agree_with_rcalc(strategy: impl Strategy<Value = String>, n: usize, tolerance: f64) {
    if programs().is_none() {
        return;
    }
    let mut runner = TestRunner::deterministic();
    let expressions: Vec<String> =
        (0..n).map(|_| strategy.new_tree(&mut runner).unwrap().current()).collect();
    // After a fault the value means nothing, and is not always the same.
    let mut n_compared = 0;
    for chunk in expressions.chunks(100) {
        let outputs: String =
            (1..).zip(chunk).map(|(at, expression)| format!("${at} = {expression};\n")).collect();
        let theirs = radiance::rcalc(&format!("{HELPERS}\n{outputs}")).expect("rcalc reads what we generate");
        for (expression, theirs) in chunk.iter().zip(theirs) {
            let (value, faults) =
                ours(HELPERS, expression).unwrap_or_else(|error| panic!("{expression}: {error}"));
            if faults == 0 {
                assert!(agree(value, theirs, tolerance), "{expression} = {value}, rcalc {theirs}");
                n_compared += 1;
            }
        }
    }
    assert!(n_compared > n / 2, "{n_compared} of {n}");
}

#[test]
fn random_exact_expressions_are_as_in_rcalc() {
    assert_agree_with_rcalc(exact(), 2000, 0.0);
}

#[test]
fn random_smooth_expressions_are_as_in_rcalc() {
    assert_agree_with_rcalc(smooth(), 2000, 1e-11);
}

/// What a ray that meets the plane z = 0 from above supplies.
struct OnPlane(Ray);

impl Inputs for OnPlane {
    fn channel(&self, n: u32) -> f64 {
        let Ray { origin, direction } = self.0;
        let distance = -origin[2] / direction[2];
        match n {
            1..=3 => direction[n as usize - 1],
            4..=6 => [0.0, 0.0, 1.0][n as usize - 4],
            7..=9 => origin[n as usize - 7] + distance * direction[n as usize - 7],
            10 | 25 => distance,
            11 => -direction[2],
            12 => 1.0,
            16 | 20 | 24 => 1.0,
            _ => 0.0,
        }
    }

    fn argument(&self, n: u32) -> f64 {
        ARGUMENTS[..].argument(n)
    }
}

fn rays() -> Vec<Ray> {
    (0..60)
        .map(|i| {
            let i = f64::from(i);
            let [x, y] = [(i * 0.618).fract() * 7.0 - 3.5, (i * 0.414).fract() * 5.0 - 2.5];
            let [tilt, turn] = [(i * 0.267).fract() * 1.2, i * 2.4];
            let direction = [tilt.sin() * turn.cos(), tilt.sin() * turn.sin(), -tilt.cos()];
            Ray { origin: [x, y, 1.0], direction }
        })
        .collect()
}

/// Compares for all rays without faults; both may also refuse. How many were compared, or what is wrong.
fn compare_with_rtrace(file: &str, expression: &str) -> Result<usize, String> {
    let rays = rays();
    let theirs = radiance::rtrace(file, expression, &rays);
    let ours: Result<Vec<Option<f64>>, CalError> = (|| {
        let mut context = Context::rayinit();
        context.enter_file("case.cal");
        context.load(file, "case.cal")?;
        let expression = context.compile(expression)?;
        let mut scratch = Scratch::default();
        let mut value = |ray| {
            let value = expression.evaluate_in(&OnPlane(ray), &mut scratch)?;
            Ok((scratch.faults() == 0).then_some(value))
        };
        rays.iter().map(|&ray| value(ray)).collect()
    })();
    let (ours, theirs) = match (ours, theirs) {
        (Err(_), None) => return Ok(0),
        (Ok(ours), Some(theirs)) if ours.len() == theirs.len() => (ours, theirs),
        (ours, theirs) => return Err(format!("{file} | {expression}: {ours:?}, rtrace {theirs:?}")),
    };
    for ((ray, ours), theirs) in rays.iter().zip(&ours).zip(theirs) {
        if let &Some(ours) = ours
            && !agree(ours, theirs, 3e-6)
        {
            return Err(format!("{file} | {expression}: {ours}, rtrace {theirs}, {ray:?}"));
        }
    }
    Ok(ours.iter().flatten().count())
}

fn assert_as_in_rtrace<'a>(cases: impl IntoIterator<Item = (&'a str, &'a str)>) {
    if programs().is_none() {
        return;
    }
    let wrong: Vec<String> = cases
        .into_iter()
        .filter_map(|(file, expression)| compare_with_rtrace(file, expression).err())
        .collect();
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn rays_supply_the_same_names() {
    let names = [
        "Dx", "Dy", "Dz", "Nx", "Ny", "Nz", "Px", "Py", "Pz", "T", "Ts", "Rdot", "S", "Tx", "Ty", "Tz", "Ix",
        "Iy", "Iz", "Jx", "Jy", "Jz", "Kx", "Ky", "Kz", "Lu", "Lv", "AC", "A1", "A2", "A3", "A4", "A5",
        "arg(0)", "arg(3)", "arg(2.6)", "arg(7)", "D(2)", "N(3)", "P(1)", "$1", "$7", "$11", "$25", "$28",
        "U", "V", "PI", "DEGREE", "FTINY",
    ];
    assert_as_in_rtrace(names.map(|name| ("", name)));
}

#[test]
fn standard_functions_have_the_same_values() {
    let expressions = [
        "and(Px,Py)",
        "or(Px,Py)",
        "xor(Px,Py)",
        "not(Px)",
        "abs(Px)",
        "sgn(Px)",
        "sq(Px)",
        "frac(Px)",
        "mod(Px,.3)",
        "mod(Px,-.3)",
        "tri(Px,.3)",
        "inside(-1,Px,1)",
        "bound(-1,Px,1)",
        "linterp(Px,2,Py)",
        "noop(Px)",
        "clip(Px)",
        "noneg(Px)",
        "red(Px,1,2)",
        "green(1,Px,2)",
        "blue(1,2,Px)",
        "grey(Px,Py,1)",
        "clip_r(Px,0,0)",
        "clip_g(0,Px,0)",
        "clip_b(0,0,Px)",
        "clipgrey(Px,Py,1)",
        "dot(D,N)",
        "dot(P,D)",
        "cross(1,D,P)",
        "cross(2,D,P)",
        "cross(3,D,P)",
        "fade(1,2,Px)",
        "fade(1,2,9*Px)",
        "hermite(1,Py,3,-2,Px)",
        "bezier(1,Py,3,-2,Px)",
        "bspline(1,Py,3,-2,Px)",
        "Acos(Px)",
        "Asin(Px)",
        "Atan2(Px,Py)",
        "Exp(99*Px)",
        "Sqrt(Px)",
        "unif2norm(rand(Px))",
        "nrand(Px)",
        "rand(Px)",
        "rand(100*Px*Py)",
        "erf(Px)",
        "erfc(Px)",
    ];
    assert_as_in_rtrace(expressions.map(|expression| ("", expression)));
}

#[test]
fn noise_has_the_same_values() {
    let expressions = [
        "noise3(Px,Py,.3)",
        "noise3(10*Px,Py,-7.7)",
        "noise3(Px,1,2)",
        "noise3(1e4*Px,1e4*Py,5e5)",
        "noise3x(Px,Py,.3)",
        "noise3y(Px,Py,.3)",
        "noise3z(Px,Py,.3)",
        "noise3a(Px,Py,.3)",
        "noise3b(Px,Py,.3)",
        "noise3c(Px,Py,.3)",
        "noise3d(2,Px,Py,.3)",
        "fnoise3(Px,Py,.3)",
        "fnoise3(-7*Px,3*Py,.9)",
        "fnoise3(Px,.5,2)",
        "turbulence(Px,Py,.3,.01)",
        "turbulencex(Px,Py,.3,.03)",
        "turbulencey(Px,Py,.3,.03)",
        "turbulencez(Px,Py,.3,.03)",
    ];
    assert_as_in_rtrace(expressions.map(|expression| ("", expression)));
}

#[test]
fn files_mean_the_same_to_the_renderer() {
    assert_as_in_rtrace([
        // Constants are taken where they are used, variables where they are needed.
        ("c : 3; b = c; c : 4;", "b"),
        ("c = 3; b = c; c = 4;", "b"),
        ("f(x) : 2*x; b = f(3); f(x) : 5*x;", "b"),
        ("f(x) = 2*x; b = f(3); f(x) = 5*x;", "b"),
        ("b = sqrt(9); sqrt(x) = 7;", "b"),
        ("b = sqrt(Rdot); sqrt(x) = 7;", "b"),
        // Scopes: a file's own names come first, from where they are known.
        ("sq(x) = -x; b = sq(3);", "b"),
        ("b = sq(3); sq(x) = -x;", "b"),
        ("b = sq(Px); sq(x) = -x;", "b"),
        ("sq(x) = -x;", "sq(Px)"),
        ("sq(x) = -x;", "sq`(Px)"),
        ("sq(x) = -x;", "`sq(Px)"),
        ("", "`sq(Px)"),
        ("Px = 5;", "Px + Px` + `Px"),
        ("a = 1;", "a`case"),
        ("a` = 1;", "a"),
        ("a = 1;", "a`"),
        ("a(Px) = Px;", "a(7)"),
        // What cannot be evaluated may stand where it is not reached.
        ("a = nobody;", "if(1, 2, a)"),
        ("a = nobody;", "a"),
        ("a = arg(9);", "if(1, 2, a)"),
        ("a = arg(9);", "a"),
        ("f(x) = 1/0*x;", "f(Px)"),
        ("f(x) = x/(1 - 1);", "1"),
        ("f(x) = 0*nobody;", "f(1)"),
        ("f(x) = 0/Px + 0^Px + Px^0 + 1^Px + Px^1;", "f(1)"),
        ("$1 = 3;", "1"),
        ("f(x, y) = x + y;", "f(1)"),
        ("f(x, y) = x;", "f(Px, nobody)"),
        ("tile(n) = floor(n/A1); chess = if(mod(tile(Px) + tile(Py), 2) - .5, A2, A3);", "chess"),
        ("s(n, x) = if(n - .5, sin(n*x)/n + s(n - 1, x), 0);", "s(20, Px)"),
        ("wood = tri(sqrt(Px*Px + Py*Py) + .1*turbulence(Px, Py, 0, .1), .2);", "wood"),
    ]);
}

#[test]
fn the_prism_is_as_in_rtrace() {
    let path = real_folder().join("radiance/prism.cal");
    let (Ok(file), Some(_)) = (std::fs::read_to_string(&path), programs()) else {
        eprintln!("SKIPPED: {} or rtrace is not there", path.display());
        return;
    };
    for name in ["coef1", "dx1", "dy1", "dz1", "coef2", "dx2", "dy2", "dz2"] {
        let n_compared = compare_with_rtrace(&file, name).unwrap();
        assert!(n_compared > 20, "{name}: {n_compared}");
    }
}

#[test]
fn library_files_of_radiance_and_the_prism_are_read() {
    let library = pyradiance().map(|folder| folder.join("lib"));
    for (folder, at_least) in [(Some(real_folder().join("radiance")), 1), (library, 100)] {
        let Some(files) = folder.and_then(|folder| std::fs::read_dir(folder).ok()) else {
            eprintln!("SKIPPED: no files of Radiance");
            continue;
        };
        let mut n_read = 0;
        for path in files
            .map(|file| file.unwrap().path())
            .filter(|path| path.extension().is_some_and(|end| end == "cal"))
        {
            let text = String::from_utf8_lossy(&std::fs::read(&path).unwrap()).into_owned();
            let name = path.file_name().unwrap().to_str().unwrap();
            Context::new().load(&text, name).unwrap();
            let mut context = Context::rayinit();
            context.enter_file(name);
            // Only three files are for rcalc or pcomb alone, because they have outputs.
            match context.load(&text, name) {
                Ok(()) => n_read += 1,
                Err(error) => assert!(error.to_string().contains("found '$'"), "{error}"),
            }
        }
        assert!(n_read >= at_least, "{n_read}");
    }
}
