//! The function language: a file, its last line a formula. Whatever it says is read or refused, and evaluated or stopped.
#![no_main]

use bsdftree_device::cal::{Context, Scratch};
use libfuzzer_sys::fuzz_target;

fuzz_target!(|text: &str| {
    let (file, formula) = text.trim_end().rsplit_once('\n').unwrap_or(("", text));
    let mut context = Context::rayinit();
    context.enter_file("fuzz.cal");
    let _ = context.load(file, "fuzz.cal");
    let mut scratch = Scratch::with_max_steps(20_000);
    let arguments = &[1.5, -2.0, 0.25][..];
    if let Ok(expression) = context.compile(formula) {
        let value = expression.evaluate_in(arguments, &mut scratch);
        // The same again, whatever memory was left.
        let again = expression.evaluate_in(arguments, &mut scratch.clone());
        assert_eq!(
            value.map(f64::to_bits).map_err(|e| e.to_string()),
            again.map(f64::to_bits).map_err(|e| e.to_string())
        );
        if let (Some(value), true) = (expression.constant(), expression.uses().is_empty()) {
            assert!(!value.is_nan() || scratch.faults() == 0);
        }
    }
    for name in ["f", "g", "a"] {
        if let Ok(function) = context.function(name, 2) {
            let _ = function.call_in(&[1.0, 2.0], arguments, &mut scratch);
        }
    }
    // As rcalc has it, too.
    let mut calculator = Context::new();
    if calculator.define(text).is_ok()
        && let Some(output) = calculator.output(1)
    {
        let _ = output.evaluate_in(arguments, &mut scratch);
    }
});
