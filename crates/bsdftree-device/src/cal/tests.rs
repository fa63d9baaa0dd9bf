//! What the language means, case by case.

use super::*;
use crate::error::Place;

fn value(definitions: &str, expression: &str) -> f64 {
    let mut context = Context::rayinit();
    context.define(definitions).unwrap();
    context.compile(expression).unwrap().evaluate(&()).unwrap()
}

fn faults(definitions: &str, expression: &str) -> (f64, u32) {
    let mut context = Context::rayinit();
    context.define(definitions).unwrap();
    let mut scratch = Scratch::default();
    (context.compile(expression).unwrap().evaluate_in(&(), &mut scratch).unwrap(), scratch.faults())
}

/// A ray whose channel n is n, and three real arguments.
struct Numbered;

impl Inputs for Numbered {
    fn channel(&self, n: u32) -> f64 {
        n.into()
    }

    fn argument(&self, n: u32) -> f64 {
        [3.0, 10.0, 20.0, 30.0][n as usize]
    }
}

#[test]
fn operators_bind_as_in_radiance() {
    for (expression, expected) in [
        ("1 + 2 * 3", 7.0),
        ("2 - 3 - 4", -5.0),
        ("8 / 4 / 2", 1.0),
        ("2 ^ 3 ^ 2", 512.0),
        ("-2 ^ 2", 4.0),
        ("2 ^ -1", 0.5),
        ("1 + +2", 3.0),
        ("3 - -(2)", 5.0),
    ] {
        assert_eq!(value("", expression), expected, "{expression}");
        // With variables nothing is folded.
        let (definitions, named) = ("n1 = 1; n2 = 2; n3 = 3; n4 = 4; n8 = 8;", named_digits(expression));
        assert_eq!(value(definitions, &named), expected, "{named}");
    }
}

fn named_digits(expression: &str) -> String {
    expression.chars().map(|c| if c.is_ascii_digit() { format!("n{c}") } else { c.to_string() }).collect()
}

#[test]
fn what_is_not_finite_is_zero_and_a_fault() {
    let definitions = "zero = 0; minus = -1; big = 1000;";
    for expression in [
        "1/zero",
        "zero/zero",
        "sqrt(minus)",
        "log(zero)",
        "exp(big)",
        "minus^.5",
        "big^big",
        "acos(big)",
        "zero^minus",
    ] {
        assert_eq!(faults(definitions, expression), (0.0, 1), "{expression}");
        assert_eq!(faults(definitions, &format!("3 + {expression}")), (3.0, 1), "{expression}");
    }
    assert_eq!(faults(definitions, "select(9, 1, 2)"), (0.0, 1));
    assert_eq!(faults(definitions, "exp(-big)"), (0.0, 0));
    assert_eq!(faults(definitions, "if(zero, 1/zero, 2)"), (2.0, 0));
    // Sums and products are not looked at.
    assert_eq!(faults("huge = 1e300;", "huge*huge"), (f64::INFINITY, 0));
}

#[test]
fn each_standard_name_of_the_ray_has_its_channel() {
    let names = "Dx Dy Dz Nx Ny Nz Px Py Pz T Rdot S Tx Ty Tz Ix Iy Iz Jx Jy Jz Kx Ky Kz Ts Lu Lv \
                 NxP NyP NzP RdotP CrP CgP CbP DxA DyA DzA";
    let context = Context::rayinit();
    for (name, channel) in names.split_whitespace().zip(1u32..) {
        let expression = context.compile(name).unwrap();
        assert_eq!(expression.evaluate(&Numbered).unwrap(), f64::from(channel), "{name}");
        assert!(expression.uses().channel(channel) && !expression.uses().channel(channel + 1), "{name}");
    }
    use rayinit::*;
    assert_eq!(
        [RAY_DISTANCE, MESH_UV, PERTURBED_NORMAL, PERTURBED_COSINE, PERTURBED_COLOR, SOURCE_DIRECTION],
        [25, 26, 28, 31, 32, 35]
    );
}

#[test]
fn channels_beyond_those_of_a_ray_are_refused_when_needed() {
    let context = Context::rayinit();
    let error = context.compile("$28").unwrap().evaluate(&Numbered).unwrap_err();
    assert!(
        error
            .to_string()
            .starts_with("expression:1: expected a channel that a ray has, $1 to $27, found $28")
    );
    assert_eq!(Context::new().compile("$28").unwrap().evaluate(&Numbered).unwrap(), 28.0);
    assert_eq!(value("a = $28;", "if(1, 2, a)"), 2.0);
}

#[test]
fn real_arguments_are_counted_and_missing_ones_named() {
    let context = Context::rayinit();
    let value = |text: &str| context.compile(text).unwrap().evaluate(&Numbered);
    assert_eq!(value("AC").unwrap(), 3.0);
    assert_eq!(value("A1 + arg(AC)").unwrap(), 40.0);
    let error = value("A4").unwrap_err().to_string();
    assert!(error.contains("arg(4) is missing, found 3 real arguments"), "{error}");
    assert_eq!(context.compile("A2").unwrap().evaluate(&[1.0, 7.0][..]).unwrap(), 7.0);
}

#[test]
fn functions_are_called_with_numbers() {
    let mut context = Context::rayinit();
    context.define("f(x, y) = x - y + Px; first(g, x) = x;").unwrap();
    let call = |name: &str, arguments: &[f64]| {
        context.function(name, arguments.len()).unwrap().call(arguments, &Numbered)
    };
    assert_eq!(call("f", &[5.0, 2.0]).unwrap(), 10.0);
    assert_eq!(call("f", &[5.0, 2.0, 99.0]).unwrap(), 10.0);
    assert_eq!(call("atan2", &[1.0, 1.0]).unwrap(), std::f64::consts::FRAC_PI_4);
    assert_eq!(call("if", &[-1.0, 2.0, 3.0]).unwrap(), 3.0);
    assert_eq!(call("select", &[2.0, 5.0, 6.0]).unwrap(), 6.0);
    assert_eq!(call("max", &[2.0, 5.0, 4.0]).unwrap(), 5.0);
    assert_eq!(call("first", &[7.0, 8.0]).unwrap(), 8.0);
    let error = call("f", &[5.0]).unwrap_err().to_string();
    assert!(error.contains("function 'f' needs its argument 2, found 1"), "{error}");
    let error = context.function("nobody", 1).unwrap_err().to_string();
    assert!(error.contains("function 'nobody' is not defined"), "{error}");
    assert_eq!(
        [context.n_parameters("f"), context.n_parameters("atan2"), context.n_parameters("Px")],
        [Some(2), Some(2), None]
    );
    assert!(context.is_variable("Px") && !context.is_variable("f") && !context.is_variable("nobody"));
}

#[test]
fn arguments_are_computed_once_and_only_when_needed() {
    // Without keeping values, this would take 2^60 steps.
    let definitions = "double(x) = x + x; tower(n) = if(n - .5, double(tower(n - 1)), 1);";
    assert_eq!(value(definitions, "tower(60)"), 2f64.powi(60));
    let passed_on = "down(n, x) = if(n - .5, down(n - 1, x), x + x);";
    assert_eq!(value(passed_on, "down(50, sqrt(4))"), 4.0);
    assert_eq!(value("first(a, b) = a; endless(x) = endless(x + 1);", "first(1, endless(1))"), 1.0);
}

#[test]
fn variables_are_computed_once_per_evaluation() {
    let chain: String = (1..=60).map(|n| format!("v{n} = v{} + v{};", n - 1, n - 1)).collect();
    let mut context = Context::rayinit();
    context.define(&format!("v0 = Px; {chain}")).unwrap();
    assert_eq!(context.compile("v60").unwrap().evaluate(&Numbered).unwrap(), 7.0 * 2f64.powi(60));
}

#[test]
fn formulas_together_share_their_variables() {
    let mut context = Context::rayinit();
    context
        .define("slow = s(1000); s(n) = if(n - .5, s(n - 1) + Px, 0); r = slow; g = 2*slow; b = 3;")
        .unwrap();
    let place = Place { file: "x.rad".into(), line: 7 };
    let mut scratch = Scratch::default();
    let mut values = [0.0; 3];
    let together = context.compile_all(["r", "g", "b"], &place).unwrap();
    together.evaluate_in(&Numbered, &mut scratch, &mut values).unwrap();
    assert_eq!(values, [7000.0, 14000.0, 3.0]);
    let steps = scratch.steps();
    context.compile("r").unwrap().evaluate_in(&Numbered, &mut scratch).unwrap();
    assert!(steps < scratch.steps() + 20, "{steps} {}", scratch.steps());
}

#[test]
fn a_file_has_a_scope_of_its_own() {
    let mut context = Context::rayinit();
    context.enter_file("one.cal");
    context.load("size = 1; sq(x) = -x; all = size + sq(3);", "one.cal").unwrap();
    context.enter_file("two.cal");
    context.load("size = 2; all = size + sq(3) + 100*size`one;", "two.cal").unwrap();
    let value = |context: &Context, text: &str| context.compile(text).unwrap().evaluate(&()).unwrap();
    assert_eq!(value(&context, "all"), 111.0);
    context.enter_file("one.cal");
    assert_eq!(value(&context, "all"), -2.0);
    context.enter("");
    assert_eq!(value(&context, "all`one + all`two"), 109.0);
    assert!(context.compile("size").unwrap().evaluate(&()).is_err());
    assert_eq!(value(&context, "sq(3)"), 9.0);
}

#[test]
fn clones_go_their_own_ways() {
    let mut one = Context::rayinit();
    one.define("a = 1;").unwrap();
    let mut two = one.clone();
    assert_eq!(one, two);
    two.define("a = 2;").unwrap();
    assert_ne!(one, two);
    assert_eq!(one.compile("a").unwrap().constant(), Some(1.0));
    assert_eq!(two.compile("a").unwrap().constant(), Some(2.0));
    assert_eq!(one.compile("a").unwrap(), one.clone().compile("a").unwrap());
    assert_ne!(one.compile("Px").unwrap(), one.compile("Py").unwrap());
}

#[test]
fn an_error_leaves_a_context_as_it_was() {
    let mut context = Context::rayinit();
    let before = context.clone();
    assert!(context.load("a = 1; b = ;", "x.cal").is_err());
    assert_eq!(context, before);
}

#[test]
fn constants_and_dependencies_are_known_without_a_ray() {
    let mut context = Context::rayinit();
    context.define("c = f(3); f(x) = x*PI; p = g(f); g(h) = h(Px); d = if(A1, Rdot, 1); m = Lu;").unwrap();
    let compiled = |text: &str| context.compile(text).unwrap();
    assert_eq!(compiled("c").constant(), Some(3.0 * std::f64::consts::PI));
    assert!(compiled("c").uses().is_empty());
    let uses = compiled("p").uses();
    assert!(uses.position() && !uses.direction() && !uses.arguments() && uses.any_channel());
    let uses = compiled("d").uses();
    assert!(!uses.position() && uses.direction() && uses.arguments());
    assert!(compiled("m").uses().position());
    assert!(!compiled("arg(1)").uses().any_channel());
    assert_eq!(compiled("arg(1)").constant(), None);
    // A fault is no constant, so that it is counted each time.
    assert_eq!(compiled("sqrt(0 - f(1))").constant(), None);
}

#[test]
fn names_without_definition_are_known_before_evaluation() {
    let mut context = Context::rayinit();
    context.load("a = if(1, 2, b);\nb = nobody + f(1);\nunused = nothing;", "x.cal").unwrap();
    let expression = context.compile("a").unwrap();
    assert_eq!(expression.evaluate(&()).unwrap(), 2.0);
    let problems: Vec<String> = expression.problems().iter().map(ToString::to_string).collect();
    assert_eq!(
        problems,
        [
            "x.cal:2: variable 'nobody' is not defined: define it in the function file, or correct its name",
            "x.cal:2: function 'f' is not defined: define it in the function file, or correct its name",
        ]
    );
}

#[test]
fn errors_name_file_and_line_and_what_to_do() {
    for (text, expected) in [
        (
            "a = 1;\nb = 2 +;",
            "x.cal:2: expected a number, a name, '$', '(' or a sign, found ';': complete the formula",
        ),
        (
            "a = 1\nb = 2;",
            "x.cal:2: expected an operator or ';', found 'b': end the definition of 'a' by ';'",
        ),
        ("a = (1;", "x.cal:1: expected an operator or ')', found ';': close the parenthesis by ')'"),
        ("a = f(1;", "x.cal:1: expected an operator, ',' or ')', found ';': close the call of 'f' by ')'"),
        ("\n\n2 = 3;", "x.cal:3: expected the name of a definition, found '2': a name begins with a letter"),
        ("a 3;", "x.cal:1: expected '=' or ':' after 'a', found '3': define it by '='"),
        (
            "a = 1 {\n{ }\n",
            "x.cal:1: expected '}' that ends this comment, found the end of the text: comments nest",
        ),
        ("f(x, 1) = 2;", "x.cal:1: expected the name of a parameter, found '1': a name begins with a letter"),
        ("f(`x) = 2;", "x.cal:1: expected the name of a parameter, found '`x': a parameter has no backquote"),
        ("a = 2e;", "x.cal:1: expected digits of an exponent, found ';': write them, or leave out the e"),
        ("a = .;", "x.cal:1: expected a digit after the decimal point, found ';': write 0 for zero"),
        ("a = 1e999;", "x.cal:1: expected a number below 1.8e308, found '1e999': write a smaller number"),
        ("a = $0;", "x.cal:1: expected the number of a channel after '$', found '0': write $1, $2, …"),
        ("a = $;", "x.cal:1: expected the number of a channel after '$', found ';': write $1, $2, …"),
        (
            "$1 = 2;",
            "x.cal:1: expected the name of a definition, found '$': outputs such as '$1 = …' belong to rcalc",
        ),
        (
            "a = b/0;",
            "x.cal:1: expected a divisor other than 0, found the constant 0: divide by something else",
        ),
        ("a = --1;", "x.cal:1: expected a number, a name, '$', '(' or a sign, found '-': one sign at most"),
        (
            "a = f();",
            "x.cal:1: expected a number, a name, '$', '(' or a sign, found ')': a call has at least one",
        ),
        ("a = 1 ö;", "x.cal:1: expected an operator or ';', found 'ö': end the definition of 'a' by ';'"),
        ("a = 1 \0;", "x.cal:1: expected an operator or ';', found '\\0': end"),
    ] {
        let error = Context::rayinit().load(text, "x.cal").unwrap_err().to_string();
        assert!(error.starts_with(expected), "{text:?}\n{error}\n{expected}");
    }
}

#[test]
fn outputs_are_for_the_calculator_alone() {
    let mut context = Context::new();
    context.define("a = 2; $1 = a*$3; $2 = 5; $1 = a*$4;").unwrap();
    let output = |n| context.output(n).map(|output| output.evaluate(&Numbered).unwrap());
    assert_eq!([output(1), output(2), output(3)], [Some(8.0), Some(5.0), None]);
}

#[test]
fn local_coordinates_are_right_handed_and_unit() {
    struct Tilted;
    impl Inputs for Tilted {
        fn channel(&self, n: u32) -> f64 {
            match n {
                1..=3 => [0.48, -0.64, -0.6][n as usize - 1],
                28..=30 => [0.36, 0.48, 0.8][n as usize - 28],
                _ => 0.0,
            }
        }
        fn argument(&self, n: u32) -> f64 {
            [3.0, 0.0, 0.0, 2.0][n as usize]
        }
    }
    let context = Context::rayinit();
    let value = |text: &str| context.compile(text).unwrap().evaluate(&Tilted).unwrap();
    let near = |a: f64, b: f64| assert!((a - b).abs() < 1e-12, "{a} {b}");
    near(value("Ldz(NxP, NyP, NzP)"), 1.0);
    near(value("Ldx(NxP, NyP, NzP)"), 0.0);
    near(value("Ldy(NxP, NyP, NzP)"), 0.0);
    near(value("sq(Ldx(.6, 0, .8)) + sq(Ldy(.6, 0, .8)) + sq(Ldz(.6, 0, .8))"), 1.0);
    // Across the up-vector (0, 0, 2) and the normal: V lies horizontally.
    near(value("Ldy(0, 0, 1)"), 0.0);
    near(value("sq(Idx) + sq(Idy) + sq(Ldz(-Dx, -Dy, -Dz))"), 1.0);
}
