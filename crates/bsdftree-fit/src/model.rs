//! A measurement fitted: values for every pair of directions of one part.

use std::borrow::Cow;
use std::sync::Arc;

use bsdftree::direction::Side;
use bsdftree::{Direction, Part};
use rayon::prelude::*;

use crate::blend::{Layers, Recipe, Slice};
use crate::choose::{self, Score};
use crate::forward::{self, Forward, Place, Scaled, Summed, turned};
use crate::frame::Frame;
use crate::lambert::{self, Ray};
use crate::measurement::Symmetry;
use crate::prepare::{self, Points};
use crate::progress::{Progress, Stopped};
use crate::reciprocity::Reciprocity;
use crate::scales::Scales;
use crate::swapped::{Back, Estimates, Places, Swap};
use crate::tree::Values;
use crate::uncertainty::Uncertainty;

/// Relative error between scans where none could be left out.
const BETWEEN: f32 = 0.1;

/// One part of a sample, ready to be asked.
#[derive(Debug)]
pub struct Model {
    /// What it answers for.
    pub part: Part,
    /// What was given or found.
    pub symmetry: Symmetry,
    /// All recipes that were tried, the one in use first.
    pub scores: Vec<Score>,
    /// Whether light goes back as it came; `None` if there are no swapped pairs of scans.
    pub reciprocity: Option<Reciprocity>,
    forward: Arc<Forward>,
    swapped: Option<Swapped>,
    uncertainty: Uncertainty,
}

/// Swapped pairs in use.
#[derive(Debug)]
struct Swapped {
    /// The light that goes back.
    of: Arc<Forward>,
    errors: [f32; 2],
    /// One per channel.
    places: Vec<Places>,
    /// What brings averages of both to their totals, one per channel.
    scales: Vec<Scales>,
    /// What totals grow by outside of the measured incident directions, one per channel.
    growths: Vec<Scales>,
}

/// All exitant directions for one incident direction: what scans say forward, averaged with swapped pairs if they are in use.
pub(crate) struct Both<'a> {
    model: &'a Model,
    channel: usize,
    incident: Ray,
    slice: Slice<'a>,
    outside: f64,
    /// Of the forward slice.
    scale: f32,
}

impl Both<'_> {
    /// The value from scans forward alone.
    #[inline]
    fn forward(&self, o: Ray) -> f32 {
        self.slice.value(o) * self.scale
    }

    #[inline]
    fn averaged(&self, forward: f32, o: Ray, there: Option<&Place>) -> f32 {
        self.estimates(o, there).map_or(forward, |both| both.of(forward))
    }

    /// What the value from scans forward counts, in [0, 1]. `there` is known of the exitant direction as an incident one.
    #[inline]
    pub fn share(&self, o: Ray, there: &Place) -> f32 {
        self.model.swapped.as_ref().map_or(1.0, |swapped| {
            let here = (self.incident, self.outside as f32);
            swapped.back(self.channel).share(&self.slice, &self.model.forward.scans, here, o, there)
        })
    }

    fn estimates(&self, o: Ray, there: Option<&Place>) -> Option<Estimates> {
        let swapped = self.model.swapped.as_ref()?;
        let back = swapped.back(self.channel);
        let known = match there {
            Some(there) => Cow::Borrowed(there),
            None => swapped.places[self.channel].at(&swapped.of, self.channel, o),
        };
        let here = (self.incident, self.outside as f32);
        Some(back.estimates(&self.slice, &self.model.forward.scans, here, o, &known))
    }

    /// What brings values to the total.
    fn factor(&self) -> f32 {
        let swapped = self.model.swapped.as_ref();
        swapped.map_or(1.0, |swapped| {
            swapped.scales[self.channel].at(self.incident, self.slice.apart, self.outside == 0.0)
        })
    }
}

impl Values for Both<'_> {
    /// That which scans foresee, outside of them with what swapped pairs say.
    fn total(&self) -> f64 {
        let growth = self.model.swapped.as_ref().map_or(1.0, |swapped| {
            swapped.growths[self.channel].at(self.incident, self.slice.apart, self.outside == 0.0)
        });
        (self.slice.total * f64::from(growth)).min(1.0)
    }

    /// Not scaled to the total.
    #[inline]
    fn value(&self, o: Ray) -> f32 {
        self.averaged(self.forward(o), o, None)
    }
}

impl Swapped {
    fn back(&self, channel: usize) -> Back<'_> {
        Back::new(&self.of, channel, self.errors)
    }
}

impl Model {
    /// Fits one part with the recipe of the least cross-validated error among those tried; `None` if none can be followed.
    pub(crate) fn new(
        points: Vec<Points>,
        part: Part,
        symmetry: Symmetry,
        tried: &[Recipe],
        n_channels: usize,
        progress: &Progress,
    ) -> Result<Option<Model>, Stopped> {
        let scans = prepare::gridded(prepare::symmetric(points, symmetry), progress)?;
        let line = symmetry == Symmetry::Isotropic;
        let scores = choose::scores(&scans, line, tried, progress)?;
        let Some(&Score { recipe, .. }) = scores.first() else { return Ok(None) };
        let incidence = choose::incidence(&scans, line, recipe.blend, None);
        let layers = (0..n_channels).map(|c| Layers::new(&scans, c, line, recipe, progress));
        let layers = layers.collect::<Result<Vec<Layers>, _>>()?;
        let uncertainty = Uncertainty::new(&scans, &layers[scans[0].main()], line, None, progress)?;
        let forward = Arc::new(Forward::new(scans, line, incidence, layers, progress)?);
        progress.count(1)?;
        Ok(Some(Model { part, symmetry, scores, reciprocity: None, forward, swapped: None, uncertainty }))
    }

    /// How many steps one takes: each recipe, what is done with the best, and swapped pairs.
    pub(crate) fn n_steps(tried: &[Recipe]) -> usize {
        tried.len() + 2
    }

    /// What its scans say, for another part to be asked about swapped pairs.
    pub(crate) fn forward(&self) -> Arc<Forward> {
        Arc::clone(&self.forward)
    }

    /// Compares swapped pairs with a part, which may be this one, and uses them if scans do not contradict that and it predicts left-out
    /// scans better; or as `wanted`, if that can be done. Says whether they are used.
    pub(crate) fn use_swapped(
        &mut self,
        of: Arc<Forward>,
        wanted: Option<bool>,
        progress: &Progress,
    ) -> Result<bool, Stopped> {
        let Forward { scans, line, layers, .. } = &*self.forward;
        let channel = scans[0].main();
        self.reciprocity = Reciprocity::of(scans, &of.scans, *line);
        let best = self.scores[0];
        let lobes = [best.recipe, of.layers[0].recipe].iter().any(|recipe| recipe.frame == Frame::Lobes);
        let holds = self.reciprocity.is_some_and(|found| found.holds) && best.l1.is_finite();
        let always = wanted == Some(true);
        if lobes || wanted == Some(false) || !(holds || always) {
            return Ok(false);
        }
        let between = if best.l1.is_finite() { best.l1 as f32 } else { BETWEEN };
        let errors = [between, choose::beyond(scans, &layers[channel], *line) as f32];
        let swap = Swap { forward: &self.forward, of: &of, channel, errors };
        let left_out = choose::left_out(scans, *line);
        let missed = choose::missed(scans, &layers[channel], *line, Some(&swap), &left_out, progress)?;
        let recipe = Recipe { reciprocal: true, ..best.recipe };
        let better = missed.together < best.l1;
        let score = Score { recipe, l1: missed.together, worst: missed.worst };
        let rank = self.scores.partition_point(|other| other.l1 < score.l1);
        self.scores.insert(if always { 0 } else { rank }, score);
        if !(better || always) {
            return Ok(false);
        }
        self.uncertainty = Uncertainty::new(scans, &layers[channel], *line, Some(&swap), progress)?;
        let channels = 0..layers.len();
        let places = channels.clone().map(|c| Places::new(&of, c)).collect();
        self.swapped = Some(Swapped { of, errors, places, scales: Vec::new(), growths: Vec::new() });
        let tables = channels.map(|c| self.new_scales(c, progress)).collect::<Result<Vec<_>, _>>()?;
        let swapped = self.swapped.as_mut().expect("just set");
        (swapped.scales, swapped.growths) = tables.into_iter().unzip();
        Ok(true)
    }

    /// The recipe in use.
    pub fn recipe(&self) -> Recipe {
        self.scores[0].recipe
    }

    /// Pixels of an edge of scans laid over disks, as a power of two.
    pub(crate) fn log2_pixels(&self) -> u32 {
        self.forward.scans[0].covered.n().ilog2()
    }

    /// Cosine and sine of the turn that brings an isotropic sample's incident direction to where its scans are; of others none.
    pub(crate) fn turn(&self, incident: Ray) -> [f32; 2] {
        self.forward.turn(incident)
    }

    /// All exitant directions for one incident direction (upper hemisphere, and of an isotropic sample in the plane of its scans).
    pub(crate) fn slice(&self, channel: usize, incident: Ray) -> Both<'_> {
        let Scaled { slice, outside, scale } = self.forward.scaled(channel, incident);
        Both { model: self, channel, incident, slice, outside, scale }
    }

    /// Scans that swapped pairs are asked of, if they are in use.
    pub(crate) fn back(&self) -> Option<&Forward> {
        self.swapped.as_ref().map(|swapped| &*swapped.of)
    }

    /// Tables of what brings averages to their totals, and of what totals grow by.
    fn new_scales(&self, channel: usize, progress: &Progress) -> Result<(Scales, Scales), Stopped> {
        /// So far outside \[disk\] the total is half of what is foreseen and half of what averages have: 2° near the normal.
        const HALF: f64 = 0.025;
        /// What swapped pairs change is smooth, so slices are summed over half as many pixels along an edge.
        const N_PIXELS: usize = forward::N_SUMMED / 2;
        let directions = forward::summed_directions(N_PIXELS);
        let swapped = self.swapped.as_ref().expect("swapped pairs are in use");
        let place = |&o: &Ray| swapped.places[channel].at(&swapped.of, channel, o).into_owned();
        let places: Vec<Place> = directions.par_iter().map(place).collect();
        let summed = |incident: Ray| {
            progress.go_on()?;
            let both = self.slice(channel, incident);
            let mut sums = [0f64; 2];
            for (&o, place) in directions.iter().zip(&places) {
                let forward = both.forward(o);
                let pair = [forward, both.averaged(forward, o, Some(place))];
                sums.iter_mut().zip(pair).for_each(|(sum, value)| *sum += f64::from(value * o[2]));
            }
            let (total, apart, outside) = (both.slice.total, both.slice.apart, both.outside);
            let ratio = if sums[0] > 0.0 { sums[1] / sums[0] } else { 1.0 };
            Ok(Summed { sum: total * ratio, total, apart, outside })
        };
        let nodes = Scales::nodes(self.forward.line).into_par_iter();
        let summed = nodes.map(summed).collect::<Result<Vec<Summed>, Stopped>>()?;
        let grown = |s: &Summed| {
            let share = s.outside / (s.outside + HALF);
            (s.total + share * (s.sum - s.total)).min(1.0)
        };
        let scales = summed.iter().map(|s| s.to(grown(s))).collect();
        let growth = |s: &Summed| ((grown(s) / s.total.max(1e-12)) as f32, s.apart, s.outside == 0.0);
        let growths = summed.iter().map(growth).collect();
        Ok((Scales::new(self.forward.line, scales), Scales::new(self.forward.line, growths)))
    }

    /// BSDF \[1/sr\] for pairs of directions, one channel. Pairs on other sides than the part's are 0.
    pub fn eval(&self, channel: usize, incident: &[Direction], exitant: &[Direction]) -> Vec<f64> {
        self.each(incident, exitant, |i| {
            let both = self.slice(channel, i);
            let factor = both.factor();
            move |o| f64::from(both.value(o) * factor)
        })
    }

    /// Standard errors \[1/sr\] of what [`Model::eval`] gives of the main channel.
    pub fn error(&self, incident: &[Direction], exitant: &[Direction]) -> Vec<f64> {
        self.each(incident, exitant, |i| self.error_slice(i))
    }

    /// Standard errors for one incident direction.
    pub(crate) fn error_slice(&self, incident: Ray) -> impl Fn(Ray) -> f64 + '_ {
        let scans = &self.forward.scans;
        let channel = scans[0].main();
        let both = self.slice(channel, incident);
        let factor = both.factor();
        let swapped = self.swapped.as_ref();
        move |o| {
            let (slice, outside) = (&both.slice, both.outside);
            let mut blended = slice.blended(o);
            let covered = slice.sum(o, |w, k, p| w * scans[k].covered.at(p)).clamp(0.0, 1.0);
            let noise2 =
                slice.sum(o, |w, k, p| scans[k].noise.as_ref().map_or(0.0, |n| (w * n.at(p)).powi(2)));
            let noise = f64::from(noise2.sqrt() * both.scale * factor);
            blended.value *= both.scale;
            let place = swapped.map(|swapped| swapped.places[channel].near(o));
            let (apart, outside) =
                match place.and_then(|place| Some((both.estimates(o, Some(place))?, place))) {
                    None => (f64::from(slice.apart), outside),
                    Some((estimates, place)) => {
                        blended.value = estimates.of(blended.value) * factor;
                        let mean = |forward: f32, back: f32| {
                            f64::from(estimates.share * forward + (1.0 - estimates.share) * back)
                        };
                        (mean(slice.apart, place.apart), mean(outside as f32, place.outside))
                    }
                };
            self.uncertainty.error(blended, apart, outside, covered, noise)
        }
    }

    /// A function of each incident direction and then of each exitant one.
    fn each<F: Fn(Ray) -> f64>(
        &self,
        incident: &[Direction],
        exitant: &[Direction],
        at: impl Fn(Ray) -> F + Sync,
    ) -> Vec<f64> {
        let chunk = |(incident, exitant): (&[Direction], &[Direction])| {
            let mut last: Option<(Ray, F)> = None;
            let value = |(&i, &o): (&Direction, &Direction)| {
                if Part::between(Side::of(i), Side::of(o)) != self.part {
                    return 0.0;
                }
                let (i, o) = (lambert::upper(i), lambert::upper(o));
                let turn = self.turn(i);
                let (i, o) = (turned(i, turn), turned(o, turn));
                if last.as_ref().is_none_or(|(before, _)| *before != i) {
                    last = Some((i, at(i)));
                }
                last.as_ref().expect("just set").1(o)
            };
            incident.iter().zip(exitant).map(value).collect::<Vec<f64>>()
        };
        const CHUNK: usize = 2048;
        incident.par_chunks(CHUNK).zip(exitant.par_chunks(CHUNK)).flat_map_iter(chunk).collect()
    }
}
