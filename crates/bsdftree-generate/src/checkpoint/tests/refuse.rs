//! What is refused, and why.

use std::fs;

use bsdftree_device::material::Material;

use super::*;
use crate::options::Aperture;
use crate::{Sides, checkpoint};

fn refusal(device: &Device, options: &Options, directory: &Path) -> String {
    let options = Options { checkpoint: Some(directory.into()), ..options.clone() };
    let before = names(directory);
    let error = generate(device, &options, &Progress::default()).expect_err("refused");
    assert!(matches!(error, GenerateError::Checkpoint(_)));
    assert_eq!(names(directory), before, "nothing is touched");
    error.to_string()
}

#[test]
fn another_generation_is_refused_with_what_differs() {
    let kept = directory();
    let options = tiny(Rank::Four);
    resumed(&options, kept.path());
    let aperture = Aperture { min: [-0.1, -0.1, -0.1], max: [0.1, 0.1, 0.0] };
    let others = [
        (Options { seed: 1, ..options.clone() }, "seed 1 here, but 0 there"),
        (
            Options { layout: Layout::Tree { rank: Rank::Four, log2_res: 3 }, ..options.clone() },
            "layout tree of rank 4 with 2^3 cells per axis here, but tree of rank 4 with 2^2",
        ),
        (tiny(Rank::Three), "layout tree of rank 3"),
        (Options { sides: Sides::Front, ..options.clone() }, "sides front here, but both there"),
        (Options { color: true, ..options.clone() }, "color yes here, but no there"),
        (Options { reuse: false, ..options.clone() }, "reuse no here, but yes, "),
        (Options { stratified: false, ..options.clone() }, "sampling random here, but sobol there"),
        (Options { tile: true, ..options.clone() }, "tile yes here, but no there"),
        (
            Options { aperture: Some(aperture), ..options.clone() },
            "aperture [-0.1, -0.1, -0.1] to [0.1, 0.1, 0.0] m here, but ",
        ),
    ];
    for (other, expected) in others {
        let message = refusal(&blinds(), &other, kept.path());
        assert!(message.contains(expected) && message.contains("another directory"), "{message}");
    }
}

#[test]
fn another_device_is_refused_with_its_line_and_another_name_is_not() {
    let kept = directory();
    let options = tiny(Rank::Four);
    let (_, expected) = resumed(&options, kept.path());
    let mut device = blinds();
    for (k, surface) in device.surfaces.iter_mut().enumerate() {
        surface.name = format!("slat{k}");
    }
    device.materials[0].name = "white paint".into();
    let same = Options { checkpoint: Some(kept.path().into()), ..options.clone() };
    assert_eq!(bits(&generate(&device, &same, &Progress::default()).expect("the same device")), expected);
    let Material::Gloss(gloss) = &mut device.materials[0].material else { panic!("slats are painted") };
    gloss.color *= 0.5;
    let message = refusal(&device, &options, kept.path());
    assert!(message.contains("the device has, as line") && message.contains("plastic m1"), "{message}");
    device.surfaces.pop();
    assert!(refusal(&device, &options, kept.path()).contains("the device has"));
}

#[test]
fn devices_that_differ_in_a_function_file_are_told_apart_but_not_by_its_place() {
    let patterned = |definition: &str, line: &str| {
        let folder = directory();
        fs::write(folder.path().join("f.cal"), definition).expect("written");
        let text = format!(
            "{line}void brightfunc dirt 2 f f.cal 0 0\ndirt plastic p 0 0 5 .5 .5 .5 0 0\n\
             p polygon s 0 0 9 0 0 0 1 0 0 0 1 0"
        );
        Device::parse_rad(&text, "s.rad", folder.path(), bsdftree_device::Unit::Meter).expect("a device")
    };
    let kept = directory();
    let options = Options { samples: 10, ..tiny(Rank::Three) };
    let kept_options = Options { checkpoint: Some(kept.path().into()), ..options.clone() };
    let device = patterned("f = .5;", "");
    generate(&device, &kept_options, &Progress::default()).expect("a generation");
    // Elsewhere, and on another line.
    generate(&patterned("f = .5;", "\n\n"), &kept_options, &Progress::default()).expect("the same device");
    let message = refusal(&patterned("f = .6;", ""), &options, kept.path());
    assert!(message.contains("the device has, as line") && message.contains("m1 is Modified"), "{message}");
}

#[test]
fn another_version_or_format_is_refused() {
    let kept = directory();
    let options = tiny(Rank::Three);
    resumed(&options, kept.path());
    let path = kept.path().join(checkpoint::JOB);
    let text = fs::read_to_string(&path).expect("text");
    let version = env!("CARGO_PKG_VERSION");
    for (from, to, expected) in [
        (format!("version: {version}"), "version: 0.0.7".into(), "here, but 0.0.7 there"),
        ("checkpoint 3".into(), String::from("checkpoint 4"), "format 3 here, but 4 there"),
        ("bsdftree".into(), "another".into(), "is no checkpoint"),
        ("device:".into(), "dev".into(), "is no checkpoint"),
    ] {
        fs::write(&path, text.replacen(&from, &to, 1)).expect("written");
        let message = refusal(&blinds(), &options, kept.path());
        assert!(message.contains(expected), "{message}");
    }
    fs::write(&path, [0xff, 0xfe]).expect("written");
    assert!(refusal(&blinds(), &options, kept.path()).contains("is no checkpoint"));
}

#[test]
fn directories_of_others_are_left_alone() {
    let others = directory();
    fs::write(others.path().join("thesis.tex"), "dear reader").expect("written");
    let message = refusal(&blinds(), &tiny(Rank::Three), others.path());
    assert!(message.contains("\"thesis.tex\"") && message.contains("empty directory"), "{message}");
    assert_eq!(fs::read_to_string(others.path().join("thesis.tex")).expect("there"), "dear reader");
    let path = others.path().join("thesis.tex");
    let options = Options { checkpoint: Some(path.clone()), ..tiny(Rank::Three) };
    let message = run(&options).expect_err("a file").to_string();
    assert!(message.contains("cannot make") && message.contains("thesis.tex"), "{message}");
}

#[test]
fn a_checkpoint_killed_at_birth_begins_again() {
    let kept = directory();
    fs::write(kept.path().join("checkpoint.lock"), "").expect("written");
    fs::write(kept.path().join("checkpoint.txt.new"), "bsdftree check").expect("written");
    let options = tiny(Rank::Three);
    assert_eq!(resumed(&options, kept.path()).1, direct(&options));
    assert_eq!(names(kept.path()), ["0-64.blocks", "64-100.blocks", "checkpoint.lock", "checkpoint.txt"]);
}

#[test]
fn two_runs_do_not_share_a_directory() {
    let kept = directory();
    let options = tiny(Rank::Three);
    resumed(&options, kept.path());
    let lock = fs::File::open(kept.path().join("checkpoint.lock")).expect("a lock");
    lock.try_lock().expect("nobody has it");
    let message = refusal(&blinds(), &options, kept.path());
    assert!(message.contains("in use by another run"), "{message}");
    drop(lock);
    resumed(&options, kept.path());
}
