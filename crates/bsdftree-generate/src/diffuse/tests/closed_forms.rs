//! What follows from energy, symmetry and arithmetic.

use std::f64::consts::PI;
use std::sync::Arc;

use bsdftree::{Basis, Part, Rank};
use bsdftree_device::Device;
use glam::DVec3;

use super::super::*;
use super::support::*;
use crate::layout::Layout;

fn tree(log2_res: u32) -> Layout {
    Layout::Tree { rank: Rank::Four, log2_res }
}

const PLATE: &str = "polygon plate 0 0 12  0 0 0  1 0 0  1 1 0  0 1 0";

#[test]
fn a_diffuser_is_its_reflectance_over_pi() {
    let white = || rad(&format!("void plastic white 0 0 5 .6 .6 .6 0 0\nwhite {PLATE}"));
    for layout in [tree(3), Layout::Klems(Arc::new(Basis::full()))] {
        let setup = Setup::<f64>::new(white(), false, layout);
        let modelled = setup.model(Fineness::default(), 64, 64);
        for part in [Part::ReflectionBack, Part::ReflectionFront] {
            for estimate in modelled.model.estimates(part, 0).unwrap() {
                let worst =
                    estimate.iter().map(|&f| (f64::from(f) * PI / 0.6 - 1.0).abs()).fold(0.0, f64::max);
                assert!(worst < 1e-5, "{part:?}: off by {worst}");
            }
        }
        for part in [Part::TransmissionBack, Part::TransmissionFront] {
            assert!(modelled.model.estimates(part, 0).unwrap()[0].iter().all(|&f| f == 0.0));
        }
    }
}

#[test]
fn colours_are_modelled_each_by_itself() {
    let text = format!("void trans t 0 0 7 .9 .5 .1 0 0 .5 0\nt {PLATE}");
    let setup = Setup::<DVec3>::new(rad(&text), false, tree(2));
    let modelled = setup.model(Fineness::default(), 64, 64);
    for (channel, color) in [0.9, 0.5, 0.1].into_iter().enumerate() {
        for part in Part::ALL {
            for f in &modelled.model.estimates(part, channel).unwrap()[0] {
                assert!((f64::from(*f) * PI / (0.5 * color) - 1.0).abs() < 1e-5, "{part:?} {channel}: {f}");
            }
        }
    }
}

#[test]
fn light_into_a_slab_comes_out_as_fresnel_and_etendue_say() {
    // Of light diffused under a boundary to a medium of index n, the part 1 − (1 − r)/n² is reflected inside, where r is the
    // mean reflectance outside. With all that is sent out from a white bottom at last leaving, nothing is lost.
    let text = format!(
        "void dielectric d 0 0 5 1 1 1 1.5 0\nd {PLATE}
         void plastic white 0 0 5 1 1 1 0 0
         white polygon bottom 0 0 12  0 0 -.2  1 0 -.2  1 1 -.2  0 1 -.2"
    );
    let mut device = rad(&text);
    device.tile = device.bounds();
    let setup = Setup::<f64>::new(device, true, tree(3));
    let modelled = setup.model(Fineness::default(), 2048, 1 << 16);
    let f = setup.total(&modelled, bsdftree::Side::Front);
    for i in 0..64 {
        let total = f[128 * i..128 * (i + 1)].iter().sum::<f64>() * PI / 64.0;
        assert!((total - 1.0).abs() < 0.01, "cell {i}: {total}");
    }
}

#[test]
fn light_that_is_sent_out_leaves_or_is_sent_out_again() {
    for (spec, tiled) in [("sawtooth:mirror=1", true), ("blinds:angle=30", true), ("blinds:angle=30", false)]
    {
        let setup = Setup::<f64>::new(Device::from_spec(spec).unwrap(), tiled, tree(3));
        let sites = setup.sites(Fineness::default());
        let rho = if spec.starts_with("saw") { 0.5 } else { 0.7 };
        let modelled = setup.model_at(&sites, 1024, 4096);
        let (mut sum, mut area) = (0.0, 0.0);
        for (site, leaves, again) in modelled.model.closure(0) {
            let total = leaves + again / rho;
            assert!((total - 1.0).abs() < 0.1, "{spec} site {site}: {leaves} + {again}/{rho}");
            sum += total * sites.area(site);
            area += sites.area(site);
        }
        assert!((sum / area - 1.0).abs() < 0.004, "{spec}: {}", sum / area);
    }
}

#[test]
fn patches_of_grooves_are_strips() {
    let setup = Setup::<f64>::new(Device::from_spec("sawtooth").unwrap(), true, tree(3));
    let cuts = setup.sites(Fineness::default()).cuts();
    assert_eq!(cuts[0], 0, "{cuts:?}");
    assert!(cuts[1] + cuts[2] > 8, "{cuts:?}");
}

#[test]
fn devices_without_diffuse_surfaces_and_rank_3_have_no_model() {
    let setup = Setup::<f64>::new(Device::from_spec("prism").unwrap(), true, tree(3));
    let fineness = Fineness::default();
    let sites = Sites::build(&setup.scene, &setup.device, &setup.entrance, setup.tile.as_ref(), fineness, 7);
    assert!(sites.is_none());
    assert!(model_layout(&Layout::Tree { rank: Rank::Three, log2_res: 5 }).is_none());
    let finest = model_layout(&tree(8)).unwrap();
    assert_eq!(finest.n_incident(), 1 << (2 * MAX_LOG2));
}

#[test]
fn the_two_estimates_tell_their_error() {
    // The mean of a quarter of the squared difference against the variance of the mean over independent runs.
    let setup = Setup::<f64>::new(Device::from_spec("blinds:angle=30").unwrap(), true, tree(2));
    let sites = setup.sites(Fineness::default());
    let runs: Vec<[Vec<f32>; 2]> = (0..24)
        .map(|seed| {
            let rows = setup.rows(&sites, bsdftree::Side::Front, 64, seed);
            let model = setup.exchanged(&sites, [Some(rows), None], 512, seed);
            model.estimates(Part::ReflectionBack, 0).unwrap()
        })
        .collect();
    let n = runs.len() as f64;
    let (mut told, mut seen, mut apart) = (0.0, 0.0, 0.0);
    for k in 0..256 {
        let means = runs.iter().map(|[a, b]| 0.5 * f64::from(a[k] + b[k]));
        let mean = means.clone().sum::<f64>() / n;
        seen += means.map(|m| (m - mean).powi(2)).sum::<f64>() / (n - 1.0);
        told += runs.iter().map(|[a, b]| 0.25 * f64::from(a[k] - b[k]).powi(2)).sum::<f64>() / n;
        apart += runs.iter().map(|[a, b]| f64::from(a[k] - b[k])).sum::<f64>() / n;
    }
    assert!((0.75..1.33).contains(&(told / seen)), "told {told}, seen {seen}");
    // Their differences have no direction: 256 of them, four standard errors, taken for correlated.
    assert!(apart.abs() < 4.0 * 256.0 * (4.0 * told / 256.0 / n).sqrt(), "{apart}");
}

#[test]
fn any_number_of_threads_gives_the_same_bits() {
    let run = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| {
            let setup = Setup::<f64>::new(Device::from_spec("blinds:angle=30").unwrap(), true, tree(3));
            let modelled = setup.model(Fineness { n_pilot: 64, ..Fineness::default() }, 32, 64);
            Part::ALL.map(|part| modelled.model.estimates(part, 0).unwrap())
        })
    };
    let one = run(1);
    assert!(one == run(2) && one == run(7));
}

#[test]
fn light_sent_back_comes_by_the_reversed_cell() {
    for layout in [tree(4), Layout::Klems(Arc::new(Basis::full())), Layout::Klems(Arc::new(Basis::half()))] {
        for cell in 0..layout.n_incident() {
            let [x, y] = layout.incident_disk(cell, 0.3, 0.6);
            let reversed = layout.exitant_cell([0.0, 0.0], [-x, -y]) as usize;
            assert_eq!(layout.reversed(cell), reversed, "{cell}");
        }
    }
}
