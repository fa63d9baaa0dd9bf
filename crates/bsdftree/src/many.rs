//! Queries for many directions at once: what single calls give, to the bit, many times as fast.
//!
//! In: arrays. Out: arrays. Directions are taken in chunks, and those of a chunk that lie on the same sides together, since one
//! component answers for them ([`Band::answering`]).

use crate::bsdf::{Band, Component, Scattering};
use crate::color::xyz_from_yuv;
use crate::direction::{Direction, Side};
use crate::query::{Lobes, Sample, chosen, density};

/// Directions that are sorted by their sides together: few enough for the caches, many enough for whole blocks.
const CHUNK: usize = 512;

impl Band {
    /// [`Band::eval`] for many pairs.
    ///
    /// # Panics
    /// If the lengths differ.
    pub fn eval_many(&self, incident: &[Direction], exitant: &[Direction], values: &mut [f64]) {
        self.over_pairs(incident, exitant, values, 0.0, |component, reversed, incident, exitant, values| {
            component.luminance.eval_many(incident, exitant, reversed, values);
        });
    }

    /// [`Band::projected_solid_angle`] for many pairs; NaN where there is no component.
    ///
    /// # Panics
    /// If the lengths differ.
    pub fn projected_solid_angle_many(
        &self,
        incident: &[Direction],
        exitant: &[Direction],
        angles: &mut [f64],
    ) {
        let luminance =
            |component: &Component, reversed, incident: &[_], exitant: &[_], angles: &mut [f64]| {
                component.luminance.projected_solid_angle_many(incident, exitant, reversed, angles);
            };
        self.over_pairs(incident, exitant, angles, f64::NAN, luminance);
    }

    /// [`Band::eval_xyz`] for many pairs.
    ///
    /// # Panics
    /// If the lengths differ.
    pub fn eval_xyz_many(&self, incident: &[Direction], exitant: &[Direction], values: &mut [[f64; 3]]) {
        self.over_pairs(
            incident,
            exitant,
            values,
            [0.0; 3],
            |component, reversed, incident, exitant, values| {
                component.eval_xyz_many(incident, exitant, reversed, values);
            },
        );
    }

    /// [`Band::hemispherical`] for many incident directions.
    ///
    /// # Panics
    /// If the lengths differ.
    pub fn hemispherical_many(&self, incident: &[Direction], lobes: Lobes, totals: &mut [f64]) {
        assert_eq!(incident.len(), totals.len(), "a total for each incident direction");
        let mut more = [0.0; CHUNK];
        for (incident, totals) in incident.chunks(CHUNK).zip(totals.chunks_mut(CHUNK)) {
            by_key(incident.iter().map(|&i| key(i, i)), |key, places| {
                let incident = gathered(incident, places);
                let mut sums = [0.0; CHUNK];
                for (_, scattering, reversed) in self.exits_of(sides(key)[0], lobes) {
                    let more = &mut more[..incident.len()];
                    scattering.hemispherical_many(&incident, reversed, more);
                    sums.iter_mut().zip(more).for_each(|(sum, more)| *sum += *more);
                }
                places.iter().zip(sums).for_each(|(&place, sum)| totals[place] = sum);
            });
        }
    }

    /// [`Band::pdf`] for many pairs.
    ///
    /// # Panics
    /// If the lengths differ.
    pub fn pdf_many(
        &self,
        incident: &[Direction],
        exitant: &[Direction],
        lobes: Lobes,
        densities: &mut [f64],
    ) {
        self.eval_many(incident, exitant, densities);
        let mut totals = [0.0; CHUNK];
        let pairs = incident.chunks(CHUNK).zip(exitant.chunks(CHUNK));
        for ((incident, exitant), densities) in pairs.zip(densities.chunks_mut(CHUNK)) {
            let totals = &mut totals[..incident.len()];
            self.hemispherical_many(incident, lobes, totals);
            for (k, value) in densities.iter_mut().enumerate() {
                let included = lobes.include(Side::of(incident[k]), Side::of(exitant[k]));
                *value = if included { density(*value, exitant[k], totals[k]) } else { 0.0 };
            }
        }
    }

    /// [`Band::sample`] for many incident directions, each with a number of its own, or two.
    ///
    /// # Panics
    /// If the lengths differ.
    pub fn sample_many(
        &self,
        incident: &[Direction],
        u: &[f64],
        v: Option<&[f64]>,
        lobes: Lobes,
        samples: &mut [Sample],
    ) {
        assert_eq!(incident.len(), u.len(), "a number for each incident direction");
        assert!(v.is_none_or(|v| v.len() == u.len()), "two numbers for each incident direction");
        assert_eq!(incident.len(), samples.len(), "a sample for each incident direction");
        for (index, samples) in samples.chunks_mut(CHUNK).enumerate() {
            let range = index * CHUNK..index * CHUNK + samples.len();
            let (incident, u) = (&incident[range.clone()], &u[range.clone()]);
            let v = v.map(|v| &v[range]);
            by_key(incident.iter().map(|&i| key(i, i)), |key, places| {
                self.sample_side(sides(key)[0], places, incident, u, v, lobes, samples);
            });
        }
    }

    /// [`Band::sample_many`] for the directions at some places of a chunk, which all lie on one side.
    #[allow(clippy::too_many_arguments, reason = "those of sample_many, and which of them")]
    fn sample_side(
        &self,
        side: Side,
        places: &[usize],
        incident: &[Direction],
        u: &[f64],
        v: Option<&[f64]>,
        lobes: Lobes,
        samples: &mut [Sample],
    ) {
        let n = places.len();
        let from = gathered(incident, places);
        let exits: Vec<_> = self.exits_of(side, lobes).collect();
        let mut totals = [[0.0; CHUNK]; 2];
        for ((_, scattering, reversed), totals) in exits.iter().zip(&mut totals) {
            scattering.hemispherical_many(&from, *reversed, &mut totals[..n]);
        }
        let choices: Vec<_> = (0..n).map(|k| chosen(u[places[k]], totals[0][k], totals[1][k])).collect();
        let mut sampled = vec![([0.0; 2], 0.0); n];
        for (e, &(to, scattering, reversed)) in exits.iter().enumerate() {
            let those: Vec<usize> = (0..n).filter(|&k| usize::from(choices[k].0) == e).collect();
            let from = gathered(&from, &those);
            let inside: Vec<f64> = those.iter().map(|&k| choices[k].1).collect();
            let across: Option<Vec<f64>> = v.map(|v| those.iter().map(|&k| v[places[k]]).collect());
            let sampled = &mut sampled[..those.len()];
            scattering.sample_many(&from, reversed, &inside, across.as_deref(), sampled);
            for (&k, &(disk, value)) in those.iter().zip(sampled.iter()) {
                let total = totals[0][k] + totals[1][k];
                samples[places[k]] = match value > 0.0 {
                    true => Sample::new(to, disk, value, total),
                    false => Sample::black(incident[places[k]]),
                };
            }
        }
        if exits.is_empty() {
            places.iter().for_each(|&place| samples[place] = Sample::black(incident[place]));
        }
    }

    /// Calls `f` for pairs of the same sides with what answers for them; `absent` where nothing does.
    fn over_pairs<T: Copy>(
        &self,
        incident: &[Direction],
        exitant: &[Direction],
        values: &mut [T],
        absent: T,
        f: impl Fn(&Component, bool, &[Direction], &[Direction], &mut [T]),
    ) {
        assert_eq!(incident.len(), exitant.len(), "as many exitant as incident directions");
        assert_eq!(incident.len(), values.len(), "a value for each pair of directions");
        let mut found = [absent; CHUNK];
        let pairs = incident.chunks(CHUNK).zip(exitant.chunks(CHUNK));
        for ((incident, exitant), values) in pairs.zip(values.chunks_mut(CHUNK)) {
            by_key(incident.iter().zip(exitant).map(|(&i, &o)| key(i, o)), |key, places| {
                let [from, to] = sides(key);
                let found = &mut found[..places.len()];
                match self.answering(from, to) {
                    None => found.fill(absent),
                    Some((component, reversed)) if places.len() == incident.len() => {
                        return f(component, reversed, incident, exitant, values);
                    }
                    Some((component, reversed)) => {
                        f(
                            component,
                            reversed,
                            &gathered(incident, places),
                            &gathered(exitant, places),
                            found,
                        );
                    }
                }
                places.iter().zip(found).for_each(|(&place, found)| values[place] = *found);
            });
        }
    }

    /// As [`Band::exits`], for any direction of a side.
    fn exits_of(&self, side: Side, lobes: Lobes) -> impl Iterator<Item = (Side, &Scattering, bool)> {
        self.exits([0.0, 0.0, side.sign()], lobes)
    }
}

impl Component {
    /// [`Component::eval_xyz`] for many pairs.
    fn eval_xyz_many(
        &self,
        incident: &[Direction],
        exitant: &[Direction],
        reversed: bool,
        values: &mut [[f64; 3]],
    ) {
        let of = |function: &Scattering| {
            let mut values = vec![0.0; incident.len()];
            function.eval_many(incident, exitant, reversed, &mut values);
            values
        };
        let luminance = of(&self.luminance);
        match &self.chroma {
            None => values.iter_mut().zip(luminance).for_each(|(value, y)| *value = [y; 3]),
            Some([a, b]) => {
                let chroma = of(a).into_iter().zip(of(b));
                for ((value, y), (a, b)) in values.iter_mut().zip(luminance).zip(chroma) {
                    *value = match self.luminance {
                        Scattering::Tree(_) => xyz_from_yuv(y, [a, b]),
                        Scattering::Matrix(_) => [a, y, b],
                    };
                }
            }
        }
    }
}

/// The sides of a pair as a number below 4.
#[inline(always)]
fn key(incident: Direction, exitant: Direction) -> usize {
    usize::from(Side::of(incident) == Side::Front) << 1 | usize::from(Side::of(exitant) == Side::Front)
}

/// Incident and exitant side of a key.
fn sides(key: usize) -> [Side; 2] {
    [key >> 1, key & 1].map(|bit| if bit == 1 { Side::Front } else { Side::Back })
}

/// Calls `f` for each key that occurs in a chunk with the places where it does.
fn by_key(keys: impl Iterator<Item = usize>, mut f: impl FnMut(usize, &[usize])) {
    let mut places = [[0; CHUNK]; 4];
    let mut n = [0; 4];
    for (place, key) in keys.enumerate() {
        places[key][n[key]] = place;
        n[key] += 1;
    }
    for key in 0..4 {
        if n[key] > 0 {
            f(key, &places[key][..n[key]]);
        }
    }
}

fn gathered(directions: &[Direction], places: &[usize]) -> Vec<Direction> {
    places.iter().map(|&place| directions[place]).collect()
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use proptest::prelude::*;

    use super::*;
    use crate::bsdf::{Component, Part};
    use crate::klems::{Basis, Matrix};
    use crate::tree::{Rank, Tree};

    /// A band of trees of both ranks, one of them coloured, without one transmission; or of matrices, one of them absent.
    fn band(matrices: bool) -> Band {
        let mut band = Band::new("Visible");
        if matrices {
            let basis = Arc::new(Basis::quarter());
            let n = basis.n_patches();
            let matrix = |k: usize| {
                let values = (0..n * n).map(|i| if i % 3 == 0 { 0.0 } else { (i * k % 17) as f32 * 0.01 });
                Scattering::from(
                    Matrix::new(Arc::clone(&basis), Arc::clone(&basis), values.collect()).unwrap(),
                )
            };
            band.insert(
                Part::TransmissionFront,
                Component { luminance: matrix(3), chroma: Some([matrix(5), matrix(7)]) },
            );
            band.insert(Part::ReflectionBack, Component::grey(matrix(11)));
            return band;
        }
        let tree = |rank: Rank, scale: f32| {
            let n = 1usize << (2 * rank.dimensions());
            let values: Vec<f32> =
                (0..n).map(|k| if k % 5 < 2 { 0.0 } else { (k % 37) as f32 * scale }).collect();
            Scattering::from(Tree::from_grid(rank, &values).unwrap())
        };
        let chroma = [tree(Rank::Four, 0.01), tree(Rank::Four, 0.012)];
        band.insert(
            Part::ReflectionFront,
            Component { luminance: tree(Rank::Four, 0.01), chroma: Some(chroma) },
        );
        band.insert(Part::TransmissionBack, Component::grey(tree(Rank::Four, 0.02)));
        band.insert(Part::ReflectionBack, Component::grey(tree(Rank::Three, 0.01)));
        band
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(40))]
        #[test]
        fn many_answers_are_those_of_single_calls_to_the_bit(
            pairs in prop::collection::vec((prop::array::uniform6(-1.0..1.0f64), 0.0..1.0f64, 0.0..1.0f64), 0..1200),
        ) {
            let unit = |v: [f64; 3]| crate::direction::normalized(v).unwrap_or([0.0, 0.0, 1.0]);
            let incident: Vec<_> = pairs.iter().map(|(p, ..)| unit([p[0], p[1], p[2]])).collect();
            let exitant: Vec<_> = pairs.iter().map(|(p, ..)| unit([p[3], p[4], p[5]])).collect();
            let (u, v): (Vec<_>, Vec<_>) = pairs.iter().map(|&(_, u, v)| (u, v)).unzip();
            let n = pairs.len();
            for band in [band(false), band(true)] {
                let (mut values, mut colors) = (vec![-1.0; n], vec![[-1.0; 3]; n]);
                band.eval_many(&incident, &exitant, &mut values);
                band.eval_xyz_many(&incident, &exitant, &mut colors);
                let mut angles = vec![-1.0; n];
                band.projected_solid_angle_many(&incident, &exitant, &mut angles);
                for k in 0..n {
                    prop_assert_eq!(values[k], band.eval(incident[k], exitant[k]));
                    let angle = band.projected_solid_angle(incident[k], exitant[k]).unwrap_or(f64::NAN);
                    prop_assert!(angles[k] == angle || angles[k].is_nan() && angle.is_nan());
                    prop_assert_eq!(colors[k], band.eval_xyz(incident[k], exitant[k]));
                }
                for lobes in [Lobes::All, Lobes::Reflection, Lobes::Transmission] {
                    band.hemispherical_many(&incident, lobes, &mut values);
                    for k in 0..n {
                        prop_assert_eq!(values[k], band.hemispherical(incident[k], lobes));
                    }
                    band.pdf_many(&incident, &exitant, lobes, &mut values);
                    for k in 0..n {
                        prop_assert_eq!(values[k], band.pdf(incident[k], exitant[k], lobes));
                    }
                    for v in [None, Some(&v[..])] {
                        let mut samples = vec![Sample::black([2.0; 3]); n];
                        band.sample_many(&incident, &u, v, lobes, &mut samples);
                        for k in 0..n {
                            prop_assert_eq!(samples[k], band.sample(incident[k], u[k], v.map(|v| v[k]), lobes));
                        }
                    }
                }
            }
        }
    }
}
