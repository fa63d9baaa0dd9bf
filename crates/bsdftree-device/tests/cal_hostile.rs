//! Text meant to exhaust the reader or the evaluator of the function language.

use bsdftree_device::cal::{CalError, CalProblem, Context};
use proptest::prelude::*;

fn evaluate(definitions: &str, expression: &str) -> Result<f64, CalError> {
    let mut context = Context::rayinit();
    context.load(definitions, "hostile.cal")?;
    context.compile(expression)?.evaluate(&())
}

fn assert_refused(definitions: &str, expression: &str, message: &str) {
    let error = evaluate(definitions, expression).unwrap_err().to_string();
    assert!(error.contains(message), "{error}\n{message}");
}

const MANY: usize = 1_000_000;

#[test]
fn deep_nesting_is_refused_before_the_stack_ends() {
    let nest = || {
        for (open, close) in
            [("(", ")"), ("sin(", ")"), ("f(1,", ")"), ("-(", ")"), ("2^", ""), ("if(1,", ",2)")]
        {
            for n in [201, 100_000] {
                let text = format!("{}1{}", open.repeat(n), close.repeat(n));
                assert_refused("", &text, "expected at most 200 levels of");
                assert_refused(&format!("a = {}", open.repeat(n)), "1", "expected at most 200 levels of");
            }
            let allowed = format!("{}Px{}", open.repeat(198), close.repeat(198));
            Context::rayinit().compile(&allowed).unwrap();
            evaluate(&format!("h(x) = {}x{};", open.repeat(198), close.repeat(198)), "h(Px)").unwrap_or(0.0);
        }
    };
    // Half of what threads have.
    std::thread::Builder::new().stack_size(1 << 20).spawn(nest).unwrap().join().unwrap();
}

#[test]
fn comments_may_nest_without_bound_but_must_end() {
    assert_eq!(evaluate(&format!("{}{}a = 1;", "{".repeat(MANY), "}".repeat(MANY)), "a").unwrap(), 1.0);
    assert_refused(&"{".repeat(MANY), "1", "expected '}' that ends this comment");
}

#[test]
fn long_words_are_refused_and_long_texts_are_not() {
    assert_refused(&format!("{} = 1;", "a".repeat(MANY)), "1", "at most 127 characters in a name");
    assert_refused("", &"9".repeat(MANY), "a number below 1.8e308");
    assert_refused("", &format!("${}", "9".repeat(MANY)), "the number of a channel");
    assert_eq!(evaluate("", &format!("0.{}", "1".repeat(MANY))).unwrap(), 1.0 / 9.0);
    assert_eq!(evaluate("", &"1+".repeat(MANY / 2)).unwrap_err().at.line, 1);
    let sum = format!("Px{}", "+Px".repeat(MANY / 10));
    assert_eq!(evaluate("", &sum).unwrap(), 0.0);
    let product = format!("x{}", "*x".repeat(MANY / 10));
    assert_eq!(evaluate("x = 1;", &product).unwrap(), 1.0);
    assert_eq!(evaluate(&"a = 1;\n".repeat(MANY / 10), "a").unwrap(), 1.0);
    assert_eq!(evaluate(&";".repeat(MANY), "1").unwrap(), 1.0);
    assert_refused(&format!("f({}) = 1;", "x,".repeat(MANY)), "1", "at most 100 parameters");
    assert_refused("", &format!("max({})", "1,".repeat(MANY)), "at most 4096 arguments of a call");
    assert_refused(
        &format!("f(g) = g({});", "1,".repeat(MANY)),
        "1",
        "at most 100 arguments of a call through",
    );
    assert_eq!(evaluate("n = 4000;", &format!("select(n{})", ",Px+1".repeat(4000))).unwrap(), 1.0);
}

#[test]
fn endless_recursion_names_the_function_and_its_line() {
    for (definitions, expression, message) in [
        ("\nf(x) = f(x + 1);", "f(1)", "hostile.cal:2: 'f' was stopped after 50000 calls within calls"),
        ("\n\nf(x) = 1 + f(x);", "f(1)", "hostile.cal:3: 'f' was stopped"),
        ("f(x) = g(x);\ng(x) = f(x);", "f(1)", "was stopped after 50000 calls"),
        ("f(g) = g(g);", "f(f)", "hostile.cal:1: 'f' was stopped"),
        ("f(x) = f(f(x));", "f(1)", "'f' was stopped"),
        ("f(n) = if(n - .5, f(n - 1) + f(n - 1), 1);", "f(100)", "'f' was stopped after 10000000 operations"),
        ("a = f(1); f(x) = a + f(x);", "a", "is defined by itself"),
        ("f(x) = f(x + Px);", "f(Px)", "'f' was stopped"),
        ("f(x) = 1 + (1 + (1 + (1 + (1 + f(x)))));", "f(1)", "'f' was stopped"),
        ("f(n, s) = if(n - .5, f(n - 1, s + n), s);", "f(1e9, 0)", "'f' was stopped"),
        ("f(x) : f(x + 1); a = f(1);", "a", "'f' was stopped"),
    ] {
        assert_refused(definitions, expression, message);
    }
}

#[test]
fn circles_of_definitions_are_named() {
    for definitions in
        ["a = a;", "a = b; b = a;", "a = b + 1; b = c; c = 2*a;", "a : b; b : a;", "a = f(1); f(x) = a;"]
    {
        let error = evaluate(definitions, "a").unwrap_err();
        assert!(matches!(*error.problem, CalProblem::Circular { .. }), "{definitions}: {error}");
    }
    // A circle of which no formula comes to an end may be avoided.
    assert_eq!(evaluate("a = if(1, 2, b); b = a + b;", "a").unwrap(), 2.0);
}

#[test]
fn long_chains_of_definitions_need_no_stack() {
    let chain = |n: usize| -> String { (1..=n).map(|k| format!("v{k} = v{} + Px;\n", k - 1)).collect() };
    assert_eq!(evaluate(&format!("v0 = 1; {}", chain(40_000)), "v40000").unwrap(), 1.0);
    assert_refused(
        &format!("v0 = 1; {}", chain(100_000)),
        "v100000",
        "was stopped after 50000 calls within calls",
    );
    let constants: String = (1..=100_000).map(|k| format!("c{k} = c{} + c0;\n", k - 1)).collect();
    assert_eq!(evaluate(&format!("c0 = 1; zero = c0 - 1; {constants}"), "c40000").unwrap(), 40_001.0);
    let faulty: String = (1..=20_000).map(|k| format!("b{k} = 1/zero + b{};\n", k - 1)).collect();
    assert_eq!(evaluate(&format!("zero = 1 - 1; b0 = 1; {faulty}"), "b20000").unwrap(), 1.0);
    let functions: String = (1..=40_000).map(|k| format!("f{k}(x) = f{}(x);\n", k - 1)).collect();
    assert_eq!(evaluate(&format!("f0(x) = x; {functions}"), "f40000(3)").unwrap(), 3.0);
}

#[test]
fn costly_constants_do_not_stop_the_reader() {
    // Each would take for ever; they are left for when they are needed.
    let constants = "c : f(1);\n".repeat(20_000);
    let definitions = format!("f(x) : f(x + 1);\n{constants}");
    assert_eq!(evaluate(&definitions, "2").unwrap(), 2.0);
    assert_refused(&definitions, "c", "'f' was stopped");
    let doubling: String = (1..200).map(|n| format!("f{n}(x) : f{}(x) + f{}(x);\n", n - 1, n - 1)).collect();
    assert_refused(&format!("f0(x) : x; {doubling}"), "f199(1)", "operations");
}

#[test]
fn strange_numbers_are_survived() {
    for expression in [
        "select(1e300, 1, 2)",
        "select(-1e300, 1, 2)",
        "arg(-1e300)",
        "noise3(1e300, -1e300, 1e19)",
        "fnoise3(1e300, -1e300, 1e19)",
        "rand(1e300)",
        "select(h*h, 1, 2)",
        "noise3(h*h, h*h - h*h, 0)",
        "fnoise3(h*h, h*h - h*h, 0)",
        "if(h*h - h*h, 1, 2)",
        "floor(h*h)",
        "max(h*h - h*h, 1)",
        "(-h)^h",
    ] {
        let value = evaluate("h = 1e300;", expression).unwrap();
        assert!(value.is_finite(), "{expression} = {value}");
    }
    let error = evaluate("", "arg(1e300)").unwrap_err().to_string();
    assert!(error.contains("arg(4294967295) is missing"), "{error}");
}

/// Text that looks like the language.
fn confetti() -> impl Strategy<Value = String> {
    let pieces = vec![
        "a", "b", "f", "g", "x", "Px", "arg", "if", "select", "max", "sin", "noise3", "(", ")", ",", ";",
        "=", ":", "+", "-", "*", "/", "^", "1", "0", ".5", "2e3", "$1", "$", "`", "{", "}", " ", "\n",
        "f(x) = ", "f(x)", "a = ", "é",
    ];
    proptest::collection::vec(proptest::sample::select(pieces), 0..60).prop_map(|pieces| pieces.concat())
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 5000, rng_seed: proptest::test_runner::RngSeed::Fixed(7), ..Default::default() })]

    #[test]
    fn random_text_is_read_or_refused(definitions in confetti(), expression in confetti()) {
        let mut context = Context::rayinit();
        let _ = context.load(&definitions, "random.cal");
        if let Ok(expression) = context.compile(&expression) {
            let _ = expression.evaluate(&[1.0, 2.0][..]);
        }
        for name in ["a", "f"] {
            if let Ok(function) = context.function(name, 2) {
                let _ = function.call(&[1.0, 2.0], &[1.0][..]);
            }
        }
    }
}
