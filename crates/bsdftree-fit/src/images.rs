//! How far scans are from images of themselves or of each other: what symmetries are judged by.
//!
//! In: scans over the disk. Out: relative L1 differences, weighted by projected solid angle, over the points whose images lie between measured
//! points too. Points that are their own images say nothing and do not count.

use crate::gridded::Gridded;
use crate::lambert::{self, Ray};
use crate::prepare::{self, Points};
use crate::progress::Progress;

/// How far points are from their images in the plane of incidence, if there are such: [`from_own_image`].
pub(crate) fn asymmetry(scan: Points) -> Option<f64> {
    let alone = prepare::gridded(vec![scan], &Progress::default()).expect("nothing stops it");
    alone.first().and_then(from_own_image)
}

/// How far a scan is from its image in its plane of incidence, if it was measured on both sides.
pub(crate) fn from_own_image(scan: &Gridded) -> Option<f64> {
    let [x, y, _] = scan.incident;
    let r2 = x * x + y * y;
    if r2 < 1e-6 {
        return None;
    }
    from_image(scan, move |[u, v, w]: Ray| {
        let along = 2.0 * (u * x + v * y) / r2;
        [along * x - u, along * y - v, w]
    })
}

/// Relative L1 difference from an image, where that was measured too; `None` if it hardly was.
pub(crate) fn from_image(scan: &Gridded, image: impl Fn(Ray) -> Ray) -> Option<f64> {
    from_image_in(scan, scan, image)
}

/// The same of the image of one scan from another.
pub(crate) fn from_image_in(scan: &Gridded, other: &Gridded, image: impl Fn(Ray) -> Ray) -> Option<f64> {
    const LEAST: usize = 20;
    /// A point that is its own image says nothing.
    const OWN: f32 = 1e-3;
    let channel = scan.main();
    let (mut difference, mut sum, mut n) = (0.0, 0.0, 0);
    for (k, &o) in scan.exitant.iter().enumerate() {
        let there = image(o);
        if std::ptr::eq(scan, other) && (0..3).all(|d| (there[d] - o[d]).abs() < OWN) {
            continue;
        }
        let there = lambert::point(there);
        if other.covered.at(there) > 0.99 {
            let (value, weight) = (scan.values[channel][k], scan.weights[k]);
            difference += f64::from((value - other.rasters[channel].at(there)).abs() * weight);
            sum += f64::from(value * weight);
            n += 1;
        }
    }
    (n >= LEAST && sum > 0.0).then(|| difference / sum)
}
