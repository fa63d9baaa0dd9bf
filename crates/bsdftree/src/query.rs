//! What renderers ask of a BSDF: value, sample, density, totals.
//!
//! Directions are unit vectors away from the surface; which side they lie on chooses the component
//! ([`Band::answering`]). The BSDF has no cosine: multiply by |cos θ_exitant| to render.

use crate::bsdf::{Band, Component, Lobe, Scattering};
use crate::color::xyz_from_yuv;
use crate::cumulative::BELOW_ONE;
use crate::direction::{Direction, Side};

/// A direction sampled from a BSDF.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sample {
    /// Where the light goes. Meaningless where `pdf` is 0.
    pub exitant: Direction,
    /// Density of `exitant` \[1/sr of solid angle\]; 0 where the BSDF is black.
    pub pdf: f64,
    /// BSDF × |cos θ_exitant| / pdf: the fraction of light that this sample stands for.
    pub weight: f64,
}

impl Sample {
    /// Of a value \[1/sr\] over a point of the disk, when `total` of the light is scattered.
    #[inline(always)]
    pub(crate) fn new(side: Side, disk: [f64; 2], value: f64, total: f64) -> Sample {
        let exitant = side.direction_from_disk(disk);
        Sample { exitant, pdf: density(value, exitant, total), weight: total }
    }

    /// Where there is no light.
    pub(crate) fn black(incident: Direction) -> Sample {
        Sample { exitant: incident, pdf: 0.0, weight: 0.0 }
    }
}

/// Density \[1/sr of solid angle\] of samples in proportion to BSDF × |cos θ|.
#[inline(always)]
pub(crate) fn density(value: f64, exitant: Direction, total: f64) -> f64 {
    if total > 0.0 { value * exitant[2].abs() / total } else { 0.0 }
}

/// Which of two lobes a number chooses, and what is left of it for a choice inside. Rounding never chooses one that is black.
#[inline(always)]
pub(crate) fn chosen(u: f64, before: f64, after: f64) -> (bool, f64) {
    let target = u * (before + after);
    let (is_second, inside) = match target < before || after <= 0.0 {
        true => (false, target / before),
        false => (true, (target - before) / after),
    };
    (is_second, inside.min(BELOW_ONE))
}

/// Which exitant side a query is about.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Lobes {
    /// Both.
    #[default]
    All,
    /// The side that the light comes from.
    Reflection,
    /// The other side.
    Transmission,
}

impl Lobes {
    pub(crate) fn include(self, incident: Side, exitant: Side) -> bool {
        match self {
            Lobes::All => true,
            Lobes::Reflection => incident == exitant,
            Lobes::Transmission => incident != exitant,
        }
    }
}

impl Band {
    /// BSDF \[1/sr\], no cosine; 0 where there is no component.
    pub fn eval(&self, incident: Direction, exitant: Direction) -> f64 {
        self.answering(Side::of(incident), Side::of(exitant))
            .map_or(0.0, |(component, reversed)| component.luminance.eval(incident, exitant, reversed))
    }

    /// BSDF as CIE X, Y, Z \[1/sr\], no cosine; equal numbers where the component has no colour.
    pub fn eval_xyz(&self, incident: Direction, exitant: Direction) -> [f64; 3] {
        self.answering(Side::of(incident), Side::of(exitant))
            .map_or([0.0; 3], |(component, reversed)| component.eval_xyz(incident, exitant, reversed))
    }

    /// Directional-hemispherical scattering: the fraction of light from `incident` that leaves by `lobes`.
    pub fn hemispherical(&self, incident: Direction, lobes: Lobes) -> f64 {
        self.exits(incident, lobes)
            .map(|(_, scattering, reversed)| scattering.hemispherical(incident, reversed))
            // Not `sum`, which is -0 of nothing.
            .fold(0.0, |total, part| total + part)
    }

    /// A direction chosen in proportion to BSDF × |cos θ|, from one number in \[0, 1), or two. Stratified numbers give
    /// stratified directions: `u` runs along a Hilbert curve through the reflected hemisphere, then the transmitted one.
    pub fn sample(&self, incident: Direction, u: f64, v: Option<f64>, lobes: Lobes) -> Sample {
        let mut exits = self.exits(incident, lobes).map(|(side, function, reversed)| {
            let lobe = function.lobe(incident, reversed);
            (side, lobe.total(), lobe)
        });
        let (first, second) = (exits.next(), exits.next());
        let total_of =
            |exit: &Option<(Side, f64, Lobe<'_>)>| exit.as_ref().map_or(0.0, |(_, total, _)| *total);
        let (before, after) = (total_of(&first), total_of(&second));
        let (is_second, inside) = chosen(u, before, after);
        let exit = if is_second { second } else { first };
        let sampled = exit.and_then(|(side, _, lobe)| Some((side, lobe.sample(inside, v)?)));
        match sampled {
            Some((side, (disk, value))) => Sample::new(side, disk, value, before + after),
            None => Sample::black(incident),
        }
    }

    /// Density \[1/sr of solid angle\] with which [`Band::sample`] chooses `exitant`.
    pub fn pdf(&self, incident: Direction, exitant: Direction, lobes: Lobes) -> f64 {
        if !lobes.include(Side::of(incident), Side::of(exitant)) {
            return 0.0;
        }
        density(self.eval(incident, exitant), exitant, self.hemispherical(incident, lobes))
    }

    /// Projected solid angle \[sr\] of the cell that holds `exitant`, or `None` where there is no component.
    pub fn projected_solid_angle(&self, incident: Direction, exitant: Direction) -> Option<f64> {
        let (component, reversed) = self.answering(Side::of(incident), Side::of(exitant))?;
        Some(component.luminance.projected_solid_angle(incident, exitant, reversed))
    }

    /// Smallest and largest projected solid angle \[sr\] of the exitant cells, or `None` where there is no component.
    pub fn projected_solid_angle_range(&self, incident: Direction, lobes: Lobes) -> Option<[f64; 2]> {
        self.exits(incident, lobes)
            .map(|(_, scattering, reversed)| scattering.projected_solid_angle_range(incident, reversed))
            .reduce(|a, b| [a[0].min(b[0]), a[1].max(b[1])])
    }

    /// What light from a direction may leave through: exitant side, function, whether it is reversed.
    pub(crate) fn exits(
        &self,
        incident: Direction,
        lobes: Lobes,
    ) -> impl Iterator<Item = (Side, &Scattering, bool)> {
        let from = Side::of(incident);
        [from, from.opposite()].into_iter().filter(move |&to| lobes.include(from, to)).filter_map(move |to| {
            let (component, reversed) = self.answering(from, to)?;
            Some((to, &component.luminance, reversed))
        })
    }
}

impl Component {
    /// CIE X, Y, Z \[1/sr\] for a pair of directions; which sides they lie on does not matter here.
    pub fn eval_xyz(&self, incident: Direction, exitant: Direction, reversed: bool) -> [f64; 3] {
        let y = self.luminance.eval(incident, exitant, reversed);
        match &self.chroma {
            None => [y; 3],
            Some(chroma) => {
                let [a, b] = [0, 1].map(|k: usize| chroma[k].eval(incident, exitant, reversed));
                match self.luminance {
                    Scattering::Tree(_) => xyz_from_yuv(y, [a, b]),
                    Scattering::Matrix(_) => [a, y, b],
                }
            }
        }
    }
}
