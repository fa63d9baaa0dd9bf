//! Every error names the file, the line, what is there and what should be.

use std::path::Path;

use bsdftree_device::{Device, DeviceError, Unit};

fn error(text: &str) -> (DeviceError, String) {
    let text = format!("void plastic white 0 0 5 .8 .8 .8 0 0\n{text}");
    let error = Device::parse_rad(&text, "scene.rad", Path::new("."), Unit::Meter).unwrap_err();
    let message = error.to_string();
    (error, message)
}

/// Asserts that a scene fails at a line with a message that contains all parts.
fn assert_fails(text: &str, line: u32, parts: &[&str]) {
    let (_, message) = error(text);
    assert!(message.starts_with(&format!("scene.rad:{line}: ")), "{text}\n{message}");
    for part in parts {
        assert!(message.contains(part), "{text}\n{message}\nshould contain {part}");
    }
}

#[test]
fn truncated_scenes_name_what_is_missing() {
    for (text, missing) in [
        ("white", "a type"),
        ("white sphere", "a name"),
        ("white sphere s", "number of string arguments of sphere \"s\""),
        ("white sphere s 0", "number of integer arguments"),
        ("white sphere s 0 0", "number of real arguments"),
        ("white sphere s 0 0 4 1 2", "real argument 3 of 4"),
        ("white alias", "the new name"),
        ("white alias a", "the name that the alias stands for"),
    ] {
        assert_fails(text, 2, &[missing, "the end of the file"]);
    }
}

#[test]
fn wrong_arguments_are_named() {
    assert_fails("white sphere s 0 0 4 1 2 x 4", 2, &["real argument 3 of 4", "'x'"]);
    assert_fails("white sphere s 0 0 4 1\n2 nan 4", 3, &["'nan'"]);
    assert_fails("white sphere s 0 0 4 1 2 1e999 4", 2, &["'1e999'"]);
    assert_fails("white sphere s 0 0 4 0x1 2 3 4", 2, &["'0x1'"]);
    assert_fails("white sphere s 0 0 4 1 # comment\n", 2, &["'#'", "comments"]);
    assert_fails("white sphere s -1 0 4", 2, &["number of string arguments", "'-1'"]);
    assert_fails("white sphere s 0 1 5 4 1 2 3 4", 2, &["integer argument 1"]);
    assert_fails("white sphere s 0 0 3 1 2 3", 2, &["4 real arguments (centre, radius)", "found 3"]);
    assert_fails("white polygon p 0 0 10 0 0 0 1 0 0 1 1 0 1", 2, &["three coordinates", "found 10"]);
    assert_fails("white polygon p 0 0 6 0 0 0 1 0 0", 2, &["at least three vertices"]);
    assert_fails("\nvoid plastic m 0 0 4 1 1 1 0", 3, &["5 real arguments", "found 4"]);
    assert_fails("void glass m 1 x 0 3 1 1 1", 2, &["no string arguments", "found 1"]);
}

#[test]
fn false_counts_cost_no_memory() {
    assert_fails("white sphere s 0 0 1000000000000 1 2", 2, &["real argument 3 of 1000000000000"]);
    assert_fails("white sphere s 18446744073709551615", 2, &["string argument 1 of"]);
    assert_fails("white sphere s 99999999999999999999", 2, &["'99999999999999999999'"]);
}

#[test]
fn unknown_names_are_named() {
    assert_fails("wite sphere s 0 0 4 0 0 0 1", 2, &["modifier 'wite' is not defined"]);
    assert_fails("white spere s 0 0 4 0 0 0 1", 2, &["a Radiance type", "'spere'"]);
    assert_fails("void BRTDdata m 0 0 0", 2, &["'BRTDdata'", "Radiance has no such material: use BRTDfunc"]);
    assert_fails("void alias b nothing", 2, &["'nothing' is not defined"]);
    assert_fails("void illum b 1 nothing 0 3 1 1 1", 2, &["'nothing' is not defined"]);
    assert_fails("s sphere s 0 0 4 0 0 0 1", 2, &["modifier 's'"]);
}

#[test]
fn unsupported_modifiers_are_errors_where_they_are_used_only() {
    let library = "void mist stripes 0 0 0\nstripes plastic m 0 0 5 .1 .1 .1 0 0";
    let scene = format!("void plastic white 0 0 5 .8 .8 .8 0 0 {library}");
    assert!(Device::parse_rad(&scene, "s", Path::new("."), Unit::Meter).is_ok());
    let used = format!("{library}\nm ring r 0 0 8 0 0 0 0 0 1 0 1");
    let what = "material type 'mist' (modifier \"stripes\") is not supported: ";
    assert_fails(&used, 2, &[what, "'r' uses it at scene.rad:4"]);
}

#[test]
fn unsupported_surfaces_and_commands_are_errors() {
    assert_fails("white source s 0 0 4 0 0 1 5", 2, &["surface type 'source'", "remove it"]);
    assert_fails("void instance s 1 a.oct 0 0", 2, &["cannot read 'a.oct'", "no such file"]);
    assert_fails("void mesh s 0 0 0", 2, &["a file as string argument 1 of mesh \"s\""]);
    assert_fails("void mesh s 3 a.rtm -t 1 0 0", 2, &["a number as argument 2 of -t for mesh \"s\""]);
    assert_fails("\n!genclock clock", 3, &["command 'genclock'", "--allow-command genclock"]);
    assert_fails("!xform a.rad; rm -rf b", 2, &["';'", "no shell is run"]);
    assert_fails("!xform `ls`", 2, &["'`'"]);
    assert_fails("!xform $HOME/a.rad", 2, &["'$'"]);
    assert_fails("!", 2, &["a command after '!'", "nothing"]);
    assert_fails("!xform a.rad |", 2, &["a command after '!'"]);
    assert_fails("!cat a.rad | xform -rz 90 b.rad", 2, &["no file after '| xform'", "'b.rad'"]);
    assert_fails(&format!("!cat a{}", " | xform".repeat(40)), 2, &["a pipe of 41 programs"]);
}

#[test]
fn wrong_xform_commands_are_named() {
    assert_fails("!xform -rz 90", 2, &["a file for the command to read", "none"]);
    assert_fails("!xform -rz a.rad", 2, &["a number as argument 1 of -rz", "'a.rad'"]);
    assert_fails("!xform -t 1 0 0 -n x a.rad", 2, &["an option of xform", "'-n'"]);
    assert_fails("!xform -f", 2, &["a file name after -f"]);
    assert_fails("!xform nowhere.rad", 2, &["nowhere.rad", "no such file, looked for in"]);
}

#[test]
fn materials_beyond_physics_are_refused_where_they_are_used() {
    for (definition, part) in [
        ("void plastic m 0 0 5 1.2 .5 .5 0 0", "colour between 0 and 1"),
        ("void metal m 0 0 5 .5 .5 .5 -1 0", "specularity between 0 and 1"),
        ("void metal m 0 0 5 .5 .5 .5 1 -.1", "roughness of at least 0"),
        ("void trans m 0 0 7 .5 .5 .5 0 0 2 0", "transmission between 0 and 1"),
        ("void dielectric m 0 0 5 .5 .5 .5 0 0", "index of refraction above 0"),
        ("void glass m 0 0 3 .5 .5 2", "transmissivity between 0 and 1"),
        ("void plastic2 m 4 0 0 0 . 0 6 .5 .5 .5 0 .1 .1", "a direction ux uy uz"),
        ("void plastic2 m 5 1 0 0 . -rz 0 6 .5 .5 .5 0 .1 .1", "argument 1 of -rz"),
        ("white plastic m 0 0 5 .5 .5 .5 0 0", "found the material 'white'"),
    ] {
        let (found, message) = error(&format!("{definition}\nm ring r 0 0 8 0 0 0 0 0 1 0 1"));
        assert!(matches!(found, DeviceError::Unexpected { .. }), "{message}");
        assert!(message.starts_with("scene.rad:2: ") && message.contains(part), "{message}");
    }
}

#[test]
fn missing_files_and_directories_are_named() {
    let missing = Device::read_rad(&["no/such.rad".into()], Unit::Meter).unwrap_err().to_string();
    assert!(missing.contains("cannot read 'no/such.rad'"), "{missing}");
    let directory = Device::read_rad(&[".".into()], Unit::Meter).unwrap_err().to_string();
    assert!(directory.contains("not a regular file"), "{directory}");
}

#[test]
fn overflow_is_an_error() {
    let text = "void plastic p 0 0 5 .5 .5 .5 0 0\np sphere s 0 0 4 1e308 0 0 1e308";
    let error = Device::parse_rad(text, "s", Path::new("."), Unit::Meter).unwrap_err().to_string();
    assert!(error.starts_with("s:2: ") && error.contains("overflow"), "{error}");
}

/// Words that a scene may be made of, right and wrong.
fn words() -> impl proptest::strategy::Strategy<Value = String> {
    use proptest::prelude::*;
    let word = prop_oneof![
        Just("void".to_owned()),
        Just("white".to_owned()),
        "(plastic|polygon|sphere|ring|cone|alias|glass|trans2|illum|mirror|brightfunc|interface)",
        "[0-9]{1,2}",
        "-?[0-9]{1,3}\\.[0-9]e-?[0-9]{1,3}",
        "(\n|#|!|!xform|!cat|-a|-f|\\||\"|'|\\\\)",
        "\\PC{0,4}",
    ];
    prop::collection::vec(word, 0..60).prop_map(|words| words.join(" "))
}

proptest::proptest! {
    #[test]
    fn any_words_make_a_device_or_an_error(text in words()) {
        let text = format!("void plastic white 0 0 5 .8 .8 .8 0 0\n{text}");
        if let Err(error) = Device::parse_rad(&text, "scene.rad", Path::new("."), Unit::Meter) {
            proptest::prop_assert!(error.to_string().starts_with("scene.rad:"), "{error}");
        }
    }
}

#[test]
fn formulas_of_commands_are_named_with_their_command() {
    assert_fails(
        "!gensurf white s s t 'bad(' 9 9",
        2,
        &["the command 'gensurf white s s t bad( 9 9' failed: scene.rad:2: expected a number"],
    );
}
