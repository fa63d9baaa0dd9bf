//! What the language means, case by case.

use super::*;

fn value(definitions: &str, expression: &str) -> f64 {
    let mut context = Context::rayinit();
    context.define(definitions).unwrap();
    context.compile(expression).unwrap().evaluate(&()).unwrap()
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
