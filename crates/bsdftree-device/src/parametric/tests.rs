//! What all families keep to, and measures of closed bodies for the tests of each.

use std::collections::HashMap;

use glam::DVec3;

use super::{Domain, families};
use crate::device::Device;
use crate::unit::Unit;

fn triangles(device: &Device) -> impl Iterator<Item = [DVec3; 3]> {
    device.surfaces.iter().flat_map(|s| s.shape.triangulate())
}

/// Volume by the divergence theorem; positive if fronts are outside.
pub(super) fn volume(device: &Device) -> f64 {
    triangles(device).map(|[a, b, c]| a.dot(b.cross(c)) / 6.0).sum()
}

/// Sum of all area vectors; nothing for a closed surface.
pub(super) fn area_sum(device: &Device) -> DVec3 {
    triangles(device).map(|[a, b, c]| 0.5 * (b - a).cross(c - a)).sum()
}

/// Asserts that every edge of a triangle is met by exactly one triangle from its other side.
pub(super) fn assert_closed(device: &Device) {
    let key = |p: DVec3| (p + DVec3::ZERO).to_array().map(f64::to_bits);
    let mut edges: HashMap<_, i32> = HashMap::new();
    for t in triangles(device) {
        for k in 0..3 {
            let (a, b) = (key(t[k]), key(t[(k + 1) % 3]));
            *edges.entry((a, b)).or_default() += 1;
            *edges.entry((b, a)).or_default() -= 1;
        }
    }
    let open = edges.values().filter(|&&n| n != 0).count();
    assert_eq!(open, 0, "of {} directed edges", edges.len());
    assert!(volume(device) > 0.0);
}

#[test]
fn every_family_keeps_to_the_frame_of_devices() {
    for family in families() {
        let device = Device::from_spec(family.name).unwrap();
        let [low, high] = device.bounds().unwrap();
        assert!(high.z.abs() < 1e-15, "{}: the front is at z = 0, not {}", family.name, high.z);
        assert!((low + high).truncate().length() < 1e-12, "{}: centred", family.name);
        assert!(device.warnings.is_empty());
        assert!(
            device.surfaces.iter().all(|s| !s.shape.is_degenerate() && s.shape.is_planar()),
            "{}",
            family.name
        );
    }
}

#[test]
fn every_family_reads_back_the_same() {
    for spec in [
        "blinds:glazing=0.6,rise=0.005",
        "sawtooth",
        "sawtooth:mirror_faces=down",
        "prism",
        "perforated",
        "mirror",
        "mirror:shape=disk",
    ] {
        let device = Device::from_spec(spec).unwrap();
        let again = Device::parse_rad(&device.to_rad(), spec, ".".as_ref(), Unit::Meter).unwrap();
        // A scene does not say with which period it repeats.
        assert_eq!(again, Device { tile: None, ..device }, "{spec}");
    }
}

#[test]
fn periodic_families_know_one_period_in_their_middle() {
    for (spec, size) in [
        ("blinds:spacing=0.04", [1.0 / 3.0, 0.04]),
        ("sawtooth:period=0.02", [1.0 / 3.0, 0.02]),
        ("prism:period=0.01", [f64::NAN, 0.01]),
        ("perforated:pitch=0.01,diameter=0.004", [0.01, 0.01]),
        ("perforated:pitch=0.01,diameter=0.004,grid=triangular", [0.01, 0.01 * 3f64.sqrt()]),
    ] {
        let device = Device::from_spec(spec).unwrap();
        let ([low, high], [min, max]) = (device.tile.unwrap(), device.bounds().unwrap());
        assert!((low.cmpge(min) & high.cmple(max)).all(), "{spec}: {low} {high} in {min} {max}");
        assert_eq!((low.z, high.z), (min.z, max.z));
        let found = high - low;
        for (axis, size) in size.into_iter().enumerate().filter(|(_, size)| !size.is_nan()) {
            assert!((found[axis] - size).abs() < 1e-12, "{spec}: period {found}");
        }
    }
    assert_eq!(Device::from_spec("mirror:shape=disk").unwrap().tile, None);
    assert_eq!(Device::from_spec("blinds:height=0.08,spacing=0.04").unwrap().tile, None);
}

#[test]
fn every_parameter_is_within_its_own_range_and_explained() {
    for family in families() {
        assert!(!family.summary.is_empty() && family.drawing.lines().count() > 3);
        for p in family.parameters {
            assert!(!p.meaning.is_empty());
            if let Domain::Number { default, least, most } = p.domain {
                assert!(least <= default && default <= most, "{}.{}", family.name, p.name);
            }
            // Given as it is by default, nothing changes.
            let spec = format!("{}:{}={}", family.name, p.name, p.default_text());
            assert_eq!(Device::from_spec(&spec).unwrap(), Device::from_spec(family.name).unwrap(), "{spec}");
        }
    }
}

#[test]
fn wrong_texts_name_what_is_possible() {
    for (spec, part) in [
        ("blind", "the families are blinds, sawtooth, prism, perforated, mirror"),
        ("", "there is no family ''"),
        ("blinds:dept=1", "its parameters are depth, spacing, angle"),
        ("blinds:depth", "'depth' is not of the form parameter=value"),
        ("blinds:depth=x", "depth must be 0.000001 to 100 [m], not 'x'"),
        ("blinds:depth=-1", "not '-1'"),
        ("blinds:depth=NaN", "not 'NaN'"),
        ("blinds:depth=inf", "not 'inf'"),
        ("blinds:depth=0.05,depth=0.06", "depth is given twice"),
        ("perforated:grid=round", "grid must be square or triangular, not 'round'"),
        ("blinds:spacing=0.000001,height=100", "at most 100000 are allowed"),
    ] {
        let error = Device::from_spec(spec).unwrap_err().to_string();
        assert!(error.starts_with(&format!("device '{spec}': ")) && error.contains(part), "{error}");
    }
    assert!(Device::from_spec(" mirror : width = 2 , ").is_ok());
}
