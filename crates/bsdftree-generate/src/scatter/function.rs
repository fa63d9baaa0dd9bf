//! Materials that are functions: `plasfunc`, `metfunc`, `transfunc`, `BRTDfunc` and the forms with data.
//!
//! In: a meeting. Out: a direction drawn evenly in projected solid angle on one side, with the BSDF there times π over the
//! side's probability as its weight; of `BRTDfunc` also the mirrored and the unscattered direction. Source: Radiance's
//! reference manual ("Materials"). As everywhere here, the ray that functions know as D is the one that arrives on its
//! way from the light. Deviations: light below the surface itself is lost, where Radiance asks only for the perturbed normal; what
//! Radiance adds for indirect light as if it were diffuse is scattered by the function.

use std::f64::consts::{FRAC_1_PI, PI};
use std::sync::Arc;

use bsdftree_device::field::{FieldError, RayState};
use bsdftree_device::material::{BrtdFunction, FunctionGloss, GlossKind};
use glam::DVec3;

use super::faults::Watch;
use super::frame::cosine_direction;
use super::shading::{Facing, Shade, Shading, ray_state};
use super::{Meeting, Scatter, Spectrum};
use crate::random::Random;

/// `plasfunc` and the like.
#[derive(Clone, Debug)]
pub(super) struct FunctionShading {
    pub function: Arc<FunctionGloss>,
    pub watch: Watch,
}

impl FunctionShading {
    /// What is diffused, and what goes by the function, on the side of the ray and on the other.
    fn shares<S: Spectrum>(&self, shade: &Shade<S>) -> [[S; 2]; 2] {
        let FunctionGloss { kind, color, specular, transmission, transmitted_specular, .. } = *self.function;
        let color = S::from_rgb(color) * shade.color;
        let through = transmission * (1.0 - specular);
        let specular_through = through * transmitted_specular;
        let highlight = if kind == GlossKind::Metal { color } else { S::WHITE };
        [
            [color * (1.0 - through - specular).max(0.0), highlight * specular],
            [color * (through - specular_through), color * specular_through],
        ]
    }

    /// As functions see the meeting: both normals are on the side of the ray.
    fn state(&self, meeting: &Meeting, shade: &Shade<impl Spectrum>, facing: &Facing) -> RayState {
        RayState {
            normal: facing.surface,
            perturbed_normal: facing.normal,
            perturbed_cosine: facing.cosine,
            color: self.function.color * shade.rgb,
            ..ray_state(meeting)
        }
    }

    /// BSDF towards a direction away from the surface, without cosine \[1/sr\].
    pub fn evaluate<S: Spectrum>(
        &self,
        meeting: &Meeting,
        shade: &Shade<S>,
        exitant: DVec3,
    ) -> Result<S, FieldError> {
        let facing = Facing::new(meeting, shade);
        let [diffuse, specular] = self.shares(shade)[usize::from(exitant.dot(facing.normal) <= 0.0)];
        if specular == S::BLACK {
            return Ok(diffuse * FRAC_1_PI);
        }
        let value = self.function.lobe.at(&self.state(meeting, shade, &facing), exitant)?;
        Ok(diffuse * FRAC_1_PI + specular * value.max(0.0))
    }
}

impl<S: Spectrum> Shading<S> for FunctionShading {
    fn scatter(&self, meeting: &Meeting, shade: &Shade<S>, random: &mut Random) -> Option<Scatter<S>> {
        let facing = Facing::new(meeting, shade);
        let weights = self.shares(shade).map(|[a, b]| a.luminance() + b.luminance());
        self.watch.see_albedo(self.shares(shade).iter().map(|[diffuse, _]| diffuse.luminance()).sum());
        let (below, probability) = side(weights, random)?;
        let exitant = drawn(&facing, below, random)?;
        let value = self.watch.checked(self.evaluate(meeting, shade, exitant))?;
        (value.luminance() > 0.0).then(|| facing.scatter(exitant, value * (PI / probability)))
    }
}

/// `BRTDfunc`.
#[derive(Clone, Debug)]
pub(super) struct BrtdShading {
    pub function: Arc<BrtdFunction>,
    pub watch: Watch,
}

impl BrtdShading {
    /// As functions see the meeting: the normal is that of the front, the perturbed one on the side of the ray.
    fn state(&self, meeting: &Meeting, shade: &Shade<impl Spectrum>, facing: &Facing) -> RayState {
        let (perturbed_normal, perturbed_cosine) = (facing.normal, facing.cosine);
        RayState { perturbed_normal, perturbed_cosine, color: shade.rgb, ..ray_state(meeting) }
    }

    /// What is diffused on the side of the ray and on the other.
    fn diffuse<S: Spectrum>(&self, meeting: &Meeting, shade: &Shade<S>) -> [S; 2] {
        let reflection = self.function.diffuse_reflection[usize::from(!meeting.is_front())];
        [reflection, self.function.diffuse_transmission].map(|rgb| S::from_rgb(rgb) * shade.color)
    }

    /// The fractions of light that are mirrored and that go straight on.
    pub fn specular<S: Spectrum>(&self, meeting: &Meeting, shade: &Shade<S>) -> Result<[S; 2], FieldError> {
        let state = self.state(meeting, shade, &Facing::new(meeting, shade));
        let [r, g, b, s, t, u] = self.function.specular_at(&state)?;
        Ok([[r, g, b], [s, t, u]].map(|rgb| S::from_rgb(DVec3::from_array(rgb).max(DVec3::ZERO))))
    }

    /// BSDF towards a direction away from the surface, without cosine \[1/sr\], but for the two specular parts.
    pub fn evaluate<S: Spectrum>(
        &self,
        meeting: &Meeting,
        shade: &Shade<S>,
        exitant: DVec3,
    ) -> Result<S, FieldError> {
        let facing = Facing::new(meeting, shade);
        let below = usize::from(exitant.dot(facing.normal) <= 0.0);
        let diffuse = self.diffuse(meeting, shade)[below] * FRAC_1_PI;
        let rgb = DVec3::from_array(self.function.lobe_at(&self.state(meeting, shade, &facing), exitant)?);
        Ok(diffuse + S::from_rgb(rgb.max(DVec3::ZERO)))
    }
}

impl<S: Spectrum> Shading<S> for BrtdShading {
    fn scatter(&self, meeting: &Meeting, shade: &Shade<S>, random: &mut Random) -> Option<Scatter<S>> {
        let facing = Facing::new(meeting, shade);
        let specular = self.watch.checked(self.specular(meeting, shade))?;
        let [mirrored, through] = specular.map(S::luminance);
        let diffuse = self.diffuse(meeting, shade).map(S::luminance);
        self.watch.see_albedo(mirrored + through + diffuse[0] + diffuse[1]);
        // How much the function scatters is not known: as if all.
        let lobe = f64::from(u8::from(self.function.lobe.iter().any(Option::is_some)));
        let spread = diffuse.map(|d| d + lobe);
        let total = mirrored + through + spread[0] + spread[1];
        let place = random.next_open() * total;
        if place < mirrored {
            return Some(facing.scatter(facing.mirrored(meeting.incoming), specular[0] * (total / mirrored)));
        }
        if place < mirrored + through {
            let straight =
                (meeting.incoming - facing.perturbation).try_normalize().unwrap_or(meeting.incoming);
            return Some(facing.scatter(straight, specular[1] * (total / through)));
        }
        let (below, probability) = side(spread, random)?;
        let probability = probability * (spread[0] + spread[1]) / total;
        let exitant = drawn(&facing, below, random)?;
        let value = self.watch.checked(self.evaluate(meeting, shade, exitant))?;
        (value.luminance() > 0.0).then(|| facing.scatter(exitant, value * (PI / probability)))
    }
}

/// Takes the side of the ray or the other by their weights; whether it is the other, and its probability.
fn side([above, below]: [f64; 2], random: &mut Random) -> Option<(bool, f64)> {
    let total = above + below;
    if total <= 0.0 {
        return None;
    }
    let is_below = random.next_open() * total >= above;
    Some((is_below, if is_below { below } else { above } / total))
}

/// A direction drawn by its cosine to the perturbed normal; `None` if it leaves on the wrong side of the surface.
fn drawn(facing: &Facing, below: bool, random: &mut Random) -> Option<DVec3> {
    let exitant = cosine_direction(if below { -facing.normal } else { facing.normal }, random);
    (facing.is_above(exitant) != below).then_some(exitant)
}

#[cfg(test)]
mod tests {
    use bsdftree_device::{Device, Material, Unit};

    use super::super::PreparedMaterial;
    use super::super::test_support::polar;
    use super::*;

    const FUNCTIONS: &str =
        "lobe(x,y,z,o) = .3*(1.2 + x)*(1 + .5*z)*(1.1 + .3*Dy); side(x,y,z,o) = if(z, .1, .25)*(2 - y);";

    fn material(text: &str) -> Material {
        let folder = tempfile::tempdir().unwrap();
        std::fs::write(folder.path().join("f.cal"), FUNCTIONS).unwrap();
        let text = format!("void {text}\nm ring r 0 0 8 0 0 0 0 0 1 0 1");
        let device = Device::parse_rad(&text, "s.rad", folder.path(), Unit::Meter).unwrap();
        device.materials[0].material.clone()
    }

    /// Means over samples, of functions that tell directions apart, are integrals over the hemispheres; 200 × 200 midpoints, and
    /// |z| < 5 of 12 means each.
    #[test]
    fn samples_are_distributed_as_the_evaluated_functions() {
        let moments: [fn(DVec3) -> f64; 6] =
            [|_| 1.0, |d| d.x, |d| d.y, |d| d.z, |d| d.x * d.z, |d| f64::from(u8::from(d.z > 0.0))];
        for text in [
            "plasfunc m 2 lobe f.cal 0 4 .5 .5 .5 .3",
            "metfunc m 4 lobe f.cal -rz 40 0 4 .5 .5 .5 .3",
            "transfunc m 2 side f.cal 0 6 .5 .5 .5 .3 .6 .5",
            "BRTDfunc m 10 0 0 0 0 0 0 side side side f.cal 0 9 .1 .1 .1 .2 .2 .2 .05 .05 .05",
        ] {
            let device = material(text);
            let prepared = PreparedMaterial::<f64>::new(&device);
            let watch = Watch::new("m", &Default::default());
            for theta in [20.0, 130.0] {
                let meeting = Meeting::new(DVec3::Z, -polar(theta, 50.0));
                let shade = Shade::<f64>::of(&meeting);
                let value = |d: DVec3| match &device {
                    Material::Function(function) => {
                        FunctionShading { function: function.clone(), watch: watch.clone() }
                            .evaluate(&meeting, &shade, d)
                            .unwrap()
                    }
                    Material::Brtd(function) => {
                        BrtdShading { function: function.clone(), watch: watch.clone() }
                            .evaluate(&meeting, &shade, d)
                            .unwrap()
                    }
                    other => panic!("{other:?}"),
                };
                let mut random = Random::new(61, theta as u64, 0);
                let n = 40_000;
                let samples: Vec<_> = (0..n).map(|_| prepared.scatter(&meeting, &mut random)).collect();
                for (k, moment) in moments.iter().enumerate() {
                    let of = |s: &Option<Scatter<f64>>| s.map_or(0.0, |s| s.weight * moment(s.direction));
                    let mean = samples.iter().map(of).sum::<f64>() / f64::from(n);
                    let square = samples.iter().map(|s| of(s).powi(2)).sum::<f64>() / f64::from(n);
                    let error = ((square - mean * mean).max(0.0) / f64::from(n)).sqrt();
                    let mut integral = 0.0;
                    for sign in [1.0, -1.0] {
                        for i in 0..200 {
                            for j in 0..200 {
                                let [u, v] = [i, j].map(|k| (f64::from(k) + 0.5) / 200.0);
                                let d = DVec3::new(
                                    u.sqrt() * (2.0 * PI * v).cos(),
                                    u.sqrt() * (2.0 * PI * v).sin(),
                                    sign * (1.0 - u).sqrt(),
                                );
                                integral += value(d) * moment(d) * PI / 40_000.0;
                            }
                        }
                    }
                    assert!(
                        (mean - integral).abs() < 5.0 * error + 1e-4,
                        "{text} {theta} {k}: {mean} ± {error}, not {integral}"
                    );
                }
            }
        }
    }
}
