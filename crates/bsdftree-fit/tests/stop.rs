//! Work that is stopped leaves the rest undone, and counts its steps as it said.

use std::sync::atomic::Ordering;
use std::thread;

use bsdftree::Rank;
use bsdftree_fit::{Fit, FitError, Frame, Measurement, Options, Progress, Scan};

/// Unit vector \[rad\].
fn direction(theta: f64, phi: f64) -> [f64; 3] {
    [theta.sin() * phi.cos(), theta.sin() * phi.sin(), theta.cos()]
}

/// A glossy lobe around the mirror direction, from rings of incident directions.
fn glossy(n_azimuths: usize) -> Measurement {
    let azimuth = |k: usize, n: usize| std::f64::consts::TAU * k as f64 / n as f64;
    let exitant: Vec<[f64; 3]> = (0..40)
        .flat_map(|t| (0..60).map(move |p| direction(0.02 + 0.0385 * f64::from(t), azimuth(p, 60))))
        .collect();
    let scan = |theta: f64, phi: f64| {
        let incident = direction(theta, phi);
        let [x, y, z] = incident;
        let value = |o: &[f64; 3]| 0.05 + (z * o[2] - x * o[0] - y * o[1]).max(0.0).powi(30);
        let values = exitant.iter().map(value).collect();
        Scan { incident, exitant: exitant.clone(), values, ..Scan::default() }
    };
    let rings = [0.3, 0.7, 1.1].into_iter().flat_map(|t| (0..n_azimuths).map(move |k| (t, k)));
    let mut scans = vec![scan(0.0, 0.0)];
    scans.extend(rings.map(|(theta, k)| scan(theta, azimuth(k, n_azimuths))));
    Measurement { n_channels: 1, scans, ..Measurement::default() }
}

/// Steps done and to do.
fn counts(progress: &Progress) -> (usize, usize) {
    (progress.done.load(Ordering::Relaxed), progress.total.load(Ordering::Relaxed))
}

/// Stops work as soon as it has done `after` steps; says what came of it and how many it did.
fn stopped_after<T: Send>(
    after: usize,
    work: impl FnOnce(&Progress) -> Result<T, FitError> + Send,
) -> (Result<T, FitError>, usize, usize) {
    let progress = Progress::default();
    let result = thread::scope(|scope| {
        let worker = scope.spawn(|| work(&progress));
        while !worker.is_finished() && counts(&progress).0 < after {
            thread::yield_now();
        }
        progress.stop.store(true, Ordering::Relaxed);
        worker.join().expect("no panic")
    });
    let (done, total) = counts(&progress);
    (result, done, total)
}

#[test]
fn a_stopped_fit_leaves_steps_undone() {
    let measurement = glossy(12);
    for after in [0, 1, 20] {
        let (result, done, total) = stopped_after(after, |p| Fit::new(&measurement, &Options::default(), p));
        assert!(matches!(result, Err(FitError::Stopped(_))), "{after}: {done} of {total}");
        assert!(after == 0 || (after..total).contains(&done), "{after}: {done} of {total}");
    }
}

#[test]
fn stopped_trees_leave_cells_undone() {
    let fit = Fit::new(&glossy(6), &Options::default(), &Progress::default()).unwrap();
    for after in [0, 1, 100] {
        let (result, done, total) = stopped_after(after, |p| fit.bsdf(Rank::Four, 6, 0.01, p));
        assert!(matches!(result, Err(FitError::Stopped(_))), "{after}: {done} of {total}");
        assert!(after == 0 || (after..total).contains(&done), "{after}: {done} of {total}");
    }
}

#[test]
fn a_fit_does_the_steps_that_it_said() {
    // Found by cross-validation, assumed from one quadrant, and given.
    let all = glossy(8);
    let quadrant = |scan: &Scan| scan.incident[0] >= -1e-9 && scan.incident[1] >= -1e-9;
    let scans = all.scans.iter().filter(|scan| quadrant(scan)).cloned().collect();
    let quarter = Measurement { scans, ..all.clone() };
    let given = Options {
        symmetry: Some(bsdftree_fit::Symmetry::Isotropic),
        frame: Some(Frame::Rotation),
        ..Options::default()
    };
    for (measurement, options) in [(&all, Options::default()), (&quarter, Options::default()), (&all, given)]
    {
        let progress = Progress::default();
        Fit::new(measurement, &options, &progress).unwrap();
        let (done, total) = counts(&progress);
        assert!(done == total && total > 0, "{done} of {total}");
    }
}
