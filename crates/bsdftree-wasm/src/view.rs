//! What pictures are made of: values over hemispheres, slices and totals, from look-ups of the core.
//!
//! In: a [`Band`] and a direction. Out: arrays in the order that they are painted, row by row from the top; f32, as trees have them, in 1/sr
//! without a cosine. A hemisphere is seen as the disk of (x, y), so that equal areas are equal projected solid angles; Y is up and X
//! is right, for either side: both are seen from the room.

use bsdftree::color::rgb_from_xyz;
use bsdftree::direction::direction_from_polar;
use bsdftree::{Band, Direction, Lobes, Side};
use std::f64::consts::FRAC_PI_2;

use crate::mosaic::depth;

/// The widest picture \[pixel\].
const MOST_PIXELS: usize = 2048;

/// Values \[1/sr\] for one incident direction.
pub fn values(band: &Band, incident: Direction, exitant: &[Direction]) -> Vec<f32> {
    let mut found = vec![0.0; exitant.len()];
    band.eval_many(&vec![incident; exitant.len()], exitant, &mut found);
    found.into_iter().map(|value| value as f32).collect()
}

/// Values \[1/sr\] over the exitant hemisphere, `n` × `n`; NaN outside of the disk. Pixels are asked at their centres.
pub fn hemisphere(band: &Band, incident: Direction, side: Side, n: usize) -> Vec<f32> {
    let disk = Disk::new(side, n);
    disk.spread(&values(band, incident, &disk.exitant), f32::NAN)
}

/// How bright a value is on the screen.
#[derive(Clone, Copy, Debug)]
pub struct Tone {
    /// The value \[1/sr\] that is full.
    pub white: f64,
    /// Powers of ten from black to full; 0 is brightness in proportion to the value.
    pub decades: f64,
}

impl Tone {
    /// Grey is grey: the white of colours in files, that of equal energy, becomes that of the screen.
    fn pixel(self, xyz: [f64; 3]) -> [u8; 4] {
        let luminance = xyz[1];
        let factor = if self.decades == 0.0 {
            1.0 / self.white
        } else if luminance > 0.0 {
            (1.0 + (luminance / self.white).log10() / self.decades).clamp(0.0, 1.0) / luminance
        } else {
            0.0
        };
        let [r, g, b] = rgb_from_xyz(xyz.map(|c| c * factor)).map(srgb);
        [r, g, b, 255]
    }
}

/// The same as pixels of sRGB with alpha, 0 outside of the disk.
pub fn colours(band: &Band, incident: Direction, side: Side, n: usize, tone: Tone) -> Vec<u8> {
    let disk = Disk::new(side, n);
    disk.spread(&pixels(band, incident, &disk.exitant, tone), [0; 4]).concat()
}

/// Opaque pixels of sRGB for one incident direction.
pub fn pixels(band: &Band, incident: Direction, exitant: &[Direction], tone: Tone) -> Vec<[u8; 4]> {
    let mut xyz = vec![[0.0; 3]; exitant.len()];
    band.eval_xyz_many(&vec![incident; exitant.len()], exitant, &mut xyz);
    xyz.into_iter().map(|xyz| tone.pixel(xyz)).collect()
}

/// IEC 61966-2-1's curve.
fn srgb(linear: f64) -> u8 {
    let c = linear.clamp(0.0, 1.0);
    let curved = if c <= 0.003_130_8 { 12.92 * c } else { 1.055 * c.powf(1.0 / 2.4) - 0.055 };
    (255.0 * curved).round() as u8
}

/// 1 where the cell of a pixel is another than that of the pixel left of it or above it, else 0; `n` × `n`.
pub fn edges(band: &Band, incident: Direction, side: Side, n: usize) -> Vec<u8> {
    let disk = Disk::new(side, n);
    let Some((component, reversed)) = band.answering(Side::of(incident), side) else {
        return vec![0; disk.n * disk.n];
    };
    let key = |&exitant| Some(component.luminance.cell(incident, exitant, reversed).key);
    let keys: Vec<Option<u64>> = disk.exitant.iter().map(key).collect();
    let keys = disk.spread(&keys, None);
    let differs =
        |k: usize, other: usize| keys[k].is_some() && keys[other].is_some() && keys[k] != keys[other];
    (0..keys.len())
        .map(|k| {
            let (row, column) = (k / disk.n, k % disk.n);
            u8::from((column > 0 && differs(k, k - 1)) || (row > 0 && differs(k, k - disk.n)))
        })
        .collect()
}

/// How fine the cells are that an exitant hemisphere is cut into ([`depth`]), `n` × `n`; NaN outside of the disk and where nothing goes.
pub fn depths(band: &Band, incident: Direction, side: Side, n: usize) -> Vec<f32> {
    let disk = Disk::new(side, n);
    let mut extents = vec![f64::NAN; disk.exitant.len()];
    if let Some((component, reversed)) = band.answering(Side::of(incident), side) {
        let incident = vec![incident; disk.exitant.len()];
        component.luminance.projected_solid_angle_many(&incident, &disk.exitant, reversed, &mut extents);
    }
    disk.spread(&extents.into_iter().map(depth).collect::<Vec<f32>>(), f32::NAN)
}

/// Values \[1/sr\] in the incidence plane, for `n` angles from the normal between −90° and 90°, at the middles of equal steps. Positive ones lie on
/// the side that mirrored and straight light goes to. At normal incidence the plane is that of X.
pub fn slice(band: &Band, incident: Direction, side: Side, n: usize) -> Vec<f32> {
    let [x, y, _] = incident;
    let phi = if x == 0.0 && y == 0.0 { 0.0 } else { f64::atan2(-y, -x) };
    let exitant: Vec<Direction> = middles(n)
        .map(|t| {
            let [x, y, z] = direction_from_polar((2.0 * t - 1.0) * FRAC_PI_2, phi);
            [x, y, side.sign() * z]
        })
        .collect();
    values(band, incident, &exitant)
}

/// Directional-hemispherical reflectances, then transmittances, of `n` angles of incidence from 0° to 90°, at the middles of equal steps.
pub fn totals(band: &Band, side: Side, phi: f64, n: usize) -> Vec<f32> {
    let incident: Vec<Direction> = middles(n)
        .map(|t| {
            let [x, y, z] = direction_from_polar(t * FRAC_PI_2, phi);
            [x, y, side.sign() * z]
        })
        .collect();
    let mut totals = Vec::with_capacity(2 * incident.len());
    for lobes in [Lobes::Reflection, Lobes::Transmission] {
        let mut found = vec![0.0; incident.len()];
        band.hemispherical_many(&incident, lobes, &mut found);
        totals.extend(found.into_iter().map(|total| total as f32));
    }
    totals
}

fn middles(n: usize) -> impl Iterator<Item = f64> {
    let n = n.min(MOST_PIXELS);
    (0..n).map(move |k| (k as f64 + 0.5) / n as f64)
}

/// A hemisphere's picture: the directions of those pixels whose centres are in the disk.
struct Disk {
    n: usize,
    places: Vec<usize>,
    exitant: Vec<Direction>,
}

impl Disk {
    fn new(side: Side, n: usize) -> Disk {
        let n = n.min(MOST_PIXELS);
        let (mut places, mut exitant) = (Vec::new(), Vec::new());
        for place in 0..n * n {
            let x = (2 * (place % n) + 1) as f64 / n as f64 - 1.0;
            let y = 1.0 - (2 * (place / n) + 1) as f64 / n as f64;
            if x * x + y * y < 1.0 {
                places.push(place);
                exitant.push(side.direction_from_disk([x, y]));
            }
        }
        Disk { n, places, exitant }
    }

    /// The whole picture from what its directions have.
    fn spread<T: Copy>(&self, found: &[T], outside: T) -> Vec<T> {
        let mut picture = vec![outside; self.n * self.n];
        self.places.iter().zip(found).for_each(|(&place, &value)| picture[place] = value);
        picture
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use super::*;
    use bsdftree::{Component, Part, Rank, Tree};

    /// Mean over the pixels of a hemisphere times π: its share of light.
    fn share(hemisphere: &[f32]) -> f64 {
        let inside: Vec<f64> = hemisphere.iter().filter(|v| !v.is_nan()).map(|&v| f64::from(v)).collect();
        PI * inside.iter().sum::<f64>() / inside.len() as f64
    }

    /// All values differ: 4 × 4 incident by 4 × 4 exitant cells.
    fn tree() -> Tree {
        let values: Vec<f32> = (0..256).map(|k| 0.1 + k as f32).collect();
        Tree::from_grid(Rank::Four, &values).unwrap()
    }

    fn band() -> Band {
        let mut band = Band::new("Visible");
        band.insert(Part::ReflectionBack, Component::grey(tree().into()));
        band
    }

    #[test]
    fn a_pixel_is_the_value_of_its_direction() {
        let incident = direction_from_polar(0.7, 1.0);
        let n = 32;
        let picture = hemisphere(&band(), incident, Side::Front, n);
        let exitant = [2.0 * 20.5 / 32.0 - 1.0, 1.0 - 2.0 * 5.5 / 32.0];
        let exitant = Side::Front.direction_from_disk(exitant);
        assert_eq!(picture[5 * n + 20], band().eval(incident, exitant) as f32);
        assert!(picture[0].is_nan());
        // The other side is black.
        assert_eq!(share(&hemisphere(&band(), incident, Side::Back, n)), 0.0);
    }

    #[test]
    fn the_mean_of_a_hemisphere_is_its_total() {
        let incident = direction_from_polar(0.7, 1.0);
        let total = band().hemispherical(incident, Lobes::Reflection);
        let found = share(&hemisphere(&band(), incident, Side::Front, 1024));
        assert!((found / total - 1.0).abs() < 1e-3, "{found} {total}");
    }

    #[test]
    fn edges_are_where_cells_meet() {
        let marks = edges(&band(), direction_from_polar(0.7, 1.0), Side::Front, 64);
        // Between the second and third cell of four, at x = 0.
        for row in 10..30 {
            assert_eq!(marks[row * 64 + 32], 1, "{row}");
        }
        assert!(marks.iter().filter(|&&mark| mark == 1).count() < 64 * 64 / 5);
    }

    #[test]
    fn depths_are_those_of_cells() {
        let (incident, n) = (direction_from_polar(0.7, 1.0), 16);
        let picture = depths(&band(), incident, Side::Front, n);
        assert!(picture.iter().all(|&depth| depth.is_nan() || depth == 2.0));
        assert!(picture.contains(&2.0));
        assert!(
            depths(&band(), incident, Side::Back, n).iter().all(|depth| depth.is_nan()),
            "nothing goes there"
        );
    }

    #[test]
    fn a_slice_of_positive_angles_is_where_mirrored_light_goes() {
        let n = 64;
        let mirror: Vec<f32> = (0..256).map(|k| if k >> 4 == k & 15 { 5.0 } else { 0.0 }).collect();
        let mut band = Band::new("Visible");
        let mirror = Tree::from_grid(Rank::Four, &mirror).unwrap();
        band.insert(Part::ReflectionBack, Component::grey(mirror.into()));
        let slice = slice(&band, direction_from_polar(0.9, 2.0), Side::Front, n);
        assert!(slice[n / 2 + (n as f64 * 0.9 / PI) as usize] == 5.0);
        assert!(slice[..n / 4].iter().all(|&value| value == 0.0));
    }

    #[test]
    fn totals_are_those_of_the_core() {
        let found = totals(&band(), Side::Front, 0.3, 9);
        assert_eq!(found.len(), 18);
        let incident = direction_from_polar(4.5 / 9.0 * FRAC_PI_2, 0.3);
        assert_eq!(found[4], band().hemispherical(incident, Lobes::Reflection) as f32);
        assert_eq!(found[13], 0.0);
    }

    #[test]
    fn grey_is_grey_and_full_at_white() {
        let mut band = Band::new("Visible");
        band.insert(Part::ReflectionBack, Component::grey(Tree::uniform(Rank::Four, 0.25).into()));
        for (white, decades) in [(0.25, 0.0), (0.25, 4.0)] {
            let pixels = colours(&band, [0.0, 0.0, 1.0], Side::Front, 9, Tone { white, decades });
            assert_eq!(pixels[..4], [0; 4]);
            let middle = 4 * (9 * 4 + 4);
            let middle = &pixels[middle..middle + 4];
            assert!(middle.iter().all(|&c| c >= 254), "{middle:?}");
        }
        // A hundredth is half of four decades.
        let pixel = Tone { white: 25.0, decades: 4.0 }.pixel([0.25; 3]);
        assert!(pixel[..3].iter().all(|&c| c.abs_diff(srgb(0.5)) <= 1), "{pixel:?}");
        assert_eq!(Tone { white: 25.0, decades: 4.0 }.pixel([0.0; 3]), [0, 0, 0, 255]);
    }
}
