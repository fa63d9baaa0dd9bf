//! Materials and their modifiers as Radiance primitives, in metres.
//!
//! In: a material. Out: text; what it is made of is defined before it, under its name with numbers after it. Functions,
//! data and pictures are named by the paths they were found at, with the transformation they have in the device. Two
//! things depend on the scene's unit and so change where that is not the metre: `S` in functions, and patterns on the medium of a
//! dielectric; for the latter a comment says so.

use std::fmt::{self, Write};

use glam::{DMat3, DVec3};

use crate::field::{Field, Formulas, Source, Space, SpectralField, SpectralSource, Words};
use crate::material::{
    BrtdFunction, FunctionGloss, Gloss, GlossKind, Material, Measured, Medium, Modifier, Orientation,
    Redirection, Wgmd,
};

/// Writes the definition of `name`, and before it what it needs.
pub(super) fn write_material(to: &mut String, name: &str, material: &Material) -> fmt::Result {
    Writer { to, name, n_parts: 0 }.material("void", name, material)
}

struct Writer<'a> {
    to: &'a mut String,
    /// Of the material, which those of its parts begin with.
    name: &'a str,
    n_parts: usize,
}

impl Writer<'_> {
    fn part(&mut self) -> String {
        self.n_parts += 1;
        format!("{}.{}", self.name, self.n_parts)
    }

    fn primitive(
        &mut self,
        modifier: &str,
        kind: &str,
        name: &str,
        strings: &[String],
        reals: &[f64],
    ) -> fmt::Result {
        write!(self.to, "\n{modifier} {kind} {name}\n{}", strings.len())?;
        strings.iter().try_for_each(|word| write!(self.to, " {}", quoted(word)))?;
        write!(self.to, "\n0\n{}", reals.len())?;
        reals.iter().try_for_each(|x| write!(self.to, " {x:?}"))?;
        writeln!(self.to)
    }

    fn material(&mut self, modifier: &str, name: &str, material: &Material) -> fmt::Result {
        match material {
            Material::Void => self.primitive(modifier, "illum", name, &[], &[0.0; 3]),
            Material::Black => self.primitive(modifier, "glow", name, &[], &[0.0; 4]),
            Material::Gloss(gloss) => {
                let u = gloss.orientation.map(|u| [u.x, u.y, u.z].map(|x| format!("{x:?}")).to_vec());
                let strings = u.map(|u| [u, vec![".".to_owned()]].concat());
                self.gloss(modifier, name, gloss, strings.as_deref())
            }
            Material::Oriented { gloss, orientation } => {
                self.gloss(modifier, name, gloss, Some(&strings_of(orientation)))
            }
            Material::Glass { transmissivity, index } => {
                let [r, g, b] = transmissivity.to_array();
                self.primitive(modifier, "glass", name, &[], &[r, g, b, *index])
            }
            Material::Mirror { reflectance } => {
                self.primitive(modifier, "mirror", name, &[], &reflectance.to_array())
            }
            Material::Dielectric { inside, outside } => {
                let reals =
                    |medium: &Medium| [&medium.transmittance.to_array()[..], &[medium.index]].concat();
                if *outside == Medium::VACUUM {
                    return self.primitive(
                        modifier,
                        "dielectric",
                        name,
                        &[],
                        &[reals(inside), vec![0.0]].concat(),
                    );
                }
                self.primitive(modifier, "interface", name, &[], &[reals(inside), reals(outside)].concat())
            }
            Material::Function(function) => self.function(modifier, name, function),
            Material::Brtd(brtd) => self.brtd(modifier, name, brtd),
            Material::Measured(measured) => self.measured(modifier, name, measured),
            Material::Ashikhmin(a) => {
                let reals = [&a.diffuse.to_array()[..], &a.specular.to_array(), &a.power].concat();
                self.primitive(modifier, "ashik2", name, &oriented(&a.orientation), &reals)
            }
            Material::Wgmd(wgmd) => self.wgmd(modifier, name, wgmd),
            Material::Prism(prism) => {
                let kind = if prism.redirections.len() == 1 { "prism1" } else { "prism2" };
                let space = &prism.redirections[0].direction.space;
                let formulas =
                    |r: &Redirection| [formulas_of(&r.coefficient), formulas_of(&r.direction)].concat();
                let fields = prism.redirections.iter().flat_map(formulas);
                let strings =
                    [fields.collect(), vec![space.file.path.to_string()], transformation(space)].concat();
                self.primitive(modifier, kind, name, &strings, &space.arguments)
            }
            // Written where the names of other materials are known.
            Material::Antimatter(_) => Ok(()),
            Material::Mixture { amount, foreground, background } => {
                let mut sides = Vec::new();
                for side in [foreground, background] {
                    if **side == Material::Void {
                        sides.push("void".to_owned());
                        continue;
                    }
                    let part = self.part();
                    self.material("void", &part, side)?;
                    sides.push(part);
                }
                self.mixture(modifier, name, sides, amount)
            }
            Material::Modified { modifiers, material, unit } => {
                if matches!(**material, Material::Dielectric { .. }) && *unit != 1.0 {
                    writeln!(
                        self.to,
                        "\n# The patterns of {name} are for a length of {unit} m, here for 1 m."
                    )?;
                }
                let last = self.modifiers(modifiers)?;
                self.material(&last, name, material)
            }
        }
    }

    fn gloss(
        &mut self,
        modifier: &str,
        name: &str,
        gloss: &Gloss,
        strings: Option<&[String]>,
    ) -> fmt::Result {
        let kind = match gloss.kind {
            GlossKind::Plastic => "plastic",
            GlossKind::Metal => "metal",
            GlossKind::Trans => "trans",
        };
        let two = if strings.is_some() { "2" } else { "" };
        let mut reals = vec![gloss.color.x, gloss.color.y, gloss.color.z, gloss.specular, gloss.roughness[0]];
        reals.extend(strings.map(|_| gloss.roughness[1]));
        if gloss.kind == GlossKind::Trans {
            reals.extend([gloss.transmission, gloss.transmitted_specular]);
        }
        self.primitive(modifier, &format!("{kind}{two}"), name, strings.unwrap_or_default(), &reals)
    }

    /// The material's own numbers are the first of its real arguments.
    fn function(&mut self, modifier: &str, name: &str, function: &FunctionGloss) -> fmt::Result {
        let lobe = &function.lobe;
        let kind = match function.kind {
            GlossKind::Plastic => "plas",
            GlossKind::Metal => "met",
            GlossKind::Trans => "trans",
        };
        let form = if lobe.data.is_some() { "data" } else { "func" };
        let mut strings = vec![lobe.function.name.to_string()];
        strings.extend(lobe.data.iter().map(|(data, _)| data.file.path.to_string()));
        strings.push(lobe.space.file.path.to_string());
        strings
            .extend(lobe.data.iter().flat_map(|(_, calls)| calls.iter().map(|call| call.name.to_string())));
        strings.extend(transformation(&lobe.space));
        self.primitive(modifier, &format!("{kind}{form}"), name, &strings, &lobe.space.arguments)
    }

    fn brtd(&mut self, modifier: &str, name: &str, brtd: &BrtdFunction) -> fmt::Result {
        let mut strings = texts(&brtd.specular);
        let lobe =
            |call: &Option<crate::field::Call>| call.as_ref().map_or("0".to_owned(), |c| c.name.to_string());
        strings.extend(brtd.lobe.iter().map(lobe));
        strings.push(brtd.space.file.path.to_string());
        strings.extend(transformation(&brtd.space));
        self.primitive(modifier, "BRTDfunc", name, &strings, &brtd.space.arguments)
    }

    fn measured(&mut self, modifier: &str, name: &str, measured: &Measured) -> fmt::Result {
        let path = measured.file.file.path.to_string();
        let first = if measured.through { vec![path] } else { vec!["0".to_owned(), path] };
        let kind = if measured.through { "aBSDF" } else { "BSDF" };
        let mut reals = measured.diffuse.map(|color| color.to_array()).concat();
        // Those that are nothing at the end are left out.
        let n = 3 * measured.diffuse.iter().rposition(|&color| color != DVec3::ZERO).map_or(0, |k| k + 1);
        reals.truncate(n);
        self.primitive(modifier, kind, name, &[first, oriented(&measured.up)].concat(), &reals)
    }

    fn wgmd(&mut self, modifier: &str, name: &str, wgmd: &Wgmd) -> fmt::Result {
        let mut parts = Vec::new();
        for modifiers in &wgmd.modifiers {
            parts.push(match modifiers {
                None => "inherit".to_owned(),
                Some(modifiers) => self.modifiers(modifiers)?,
            });
        }
        let space = &wgmd.reflection.space;
        let strings = [
            vec![parts[0].clone()],
            formulas_of(&wgmd.reflection),
            vec![parts[1].clone()],
            formulas_of(&wgmd.transmission),
            vec![parts[2].clone()],
            formulas_of(&wgmd.orientation),
            vec![space.file.path.to_string()],
            transformation(space),
        ];
        self.primitive(modifier, "WGMDfunc", name, &strings.concat(), &space.arguments)
    }

    /// Writes modifiers one behind the other; the name of the first of the chain.
    fn modifiers(&mut self, modifiers: &[Modifier]) -> Result<String, fmt::Error> {
        let mut last = "void".to_owned();
        for modifier in modifiers {
            let name = self.part();
            self.modifier(&last, &name, modifier)?;
            last = name;
        }
        Ok(last)
    }

    fn modifier(&mut self, behind: &str, name: &str, modifier: &Modifier) -> fmt::Result {
        match modifier {
            Modifier::Brightness(field) => {
                self.field(behind, ["brightfunc", "brightdata", "", "brighttext"], name, field)
            }
            Modifier::Color(field) => {
                self.field(behind, ["colorfunc", "colordata", "colorpict", "colortext"], name, field)
            }
            Modifier::Texture(field) => self.field(behind, ["texfunc", "texdata", "", ""], name, field),
            Modifier::Spectrum(spectral) => match &spectral.file {
                Some(file) => self.primitive(behind, "specfile", name, &[file.path.to_string()], &[]),
                None => {
                    let w = &spectral.wavelengths_nm;
                    let reals = [&[w[0], w[w.len() - 1]], &spectral.values[..]].concat();
                    self.primitive(behind, "spectrum", name, &[], &reals)
                }
            },
            Modifier::SpectralField(field) => self.spectral(behind, name, field),
            Modifier::Mixture { amount, foreground, background } => {
                let sides = vec![self.modifiers(foreground)?, self.modifiers(background)?];
                self.mixture(behind, name, sides, amount)
            }
        }
    }

    fn field<const N: usize>(
        &mut self,
        behind: &str,
        kinds: [&str; 4],
        name: &str,
        field: &Field<N>,
    ) -> fmt::Result {
        self.primitive(behind, kinds[form(field)], name, &strings_of(field), &reals_of(field))
    }

    fn spectral(&mut self, behind: &str, name: &str, field: &SpectralField) -> fmt::Result {
        let file = field.space.file.path.to_string();
        let (kind, mut strings) = match &field.source {
            SpectralSource::Function { function, .. } => ("specfunc", vec![function.name.to_string(), file]),
            SpectralSource::Data { function, data, coordinates } => {
                let names = vec![function.name.to_string(), data.file.path.to_string(), file];
                ("specdata", [names, texts(coordinates)].concat())
            }
            SpectralSource::Picture { function, picture, coordinates } => {
                let names = vec![function.name.to_string(), picture.file.path.to_string(), file];
                ("specpict", [names, texts(coordinates)].concat())
            }
        };
        strings.extend(transformation(&field.space));
        self.primitive(behind, kind, name, &strings, &field.space.arguments)
    }

    fn mixture(
        &mut self,
        behind: &str,
        name: &str,
        mut sides: Vec<String>,
        amount: &Field<1>,
    ) -> fmt::Result {
        sides.extend(strings_of(amount));
        let kind = ["mixfunc", "mixdata", "mixpict", "mixtext"][form(amount)];
        self.primitive(behind, kind, name, &sides, &reals_of(amount))
    }
}

/// Antimatter, by the names of what it hides.
pub(super) fn write_antimatter(to: &mut String, name: &str, hidden: &[String]) -> fmt::Result {
    Writer { to, name, n_parts: 0 }.primitive("void", "antimatter", name, hidden, &[])
}

/// The string arguments of an orientation, with its function file and transformation.
fn oriented(orientation: &Orientation) -> Vec<String> {
    match orientation {
        Orientation::Constant(u) => {
            let mut strings = u.to_array().map(|x| format!("{x:?}")).to_vec();
            strings.push(".".to_owned());
            strings
        }
        Orientation::Varying(field) => strings_of(field),
    }
}

/// The words of a field that is given by formulas.
fn formulas_of<const N: usize>(field: &Field<N>) -> Vec<String> {
    match &field.source {
        Source::Formulas(formulas) => texts(formulas),
        _ => Vec::new(),
    }
}

/// 0 for formulas, 1 for data, 2 for a picture, 3 for text.
fn form<const N: usize>(field: &Field<N>) -> usize {
    match field.source {
        Source::Formulas(_) => 0,
        Source::Data { .. } => 1,
        Source::Picture { .. } => 2,
        Source::Text { .. } => 3,
    }
}

/// The string arguments of a field, but for the sides of a mixture.
fn strings_of<const N: usize>(field: &Field<N>) -> Vec<String> {
    let file = field.space.file.path.to_string();
    let names =
        |calls: &[crate::field::Call; N]| calls.iter().map(|call| call.name.to_string()).collect::<Vec<_>>();
    let mut strings = match &field.source {
        Source::Formulas(formulas) => [texts(formulas), vec![file]].concat(),
        Source::Data { functions, data, coordinates } => {
            let paths = data.iter().map(|data| data.file.path.to_string()).collect();
            [names(functions), paths, vec![file], texts(coordinates)].concat()
        }
        Source::Picture { functions, picture, coordinates } => {
            [names(functions), vec![picture.file.path.to_string(), file], texts(coordinates)].concat()
        }
        Source::Text { text, .. } => {
            return match &text.words {
                Words::Line(line) => vec![file, ".".to_owned(), line.clone()],
                Words::File(of_text) => vec![file, of_text.path.to_string()],
            };
        }
    };
    strings.extend(transformation(&field.space));
    strings
}

/// The real arguments of a field. Text has no transformation: its vectors are moved.
fn reals_of<const N: usize>(field: &Field<N>) -> Vec<f64> {
    let Source::Text { text, .. } = &field.source else { return field.space.arguments.to_vec() };
    let to_device = field.space.function_from_device.inverse();
    let mut reals = to_device.transform_point3(text.anchor).to_array().to_vec();
    for vector in [text.right, text.down] {
        reals.extend(to_device.transform_vector3(vector).to_array());
    }
    reals.extend(&field.space.arguments[9..]);
    reals
}

fn texts(formulas: &Formulas) -> Vec<String> {
    formulas.texts.iter().map(|text| text.to_string()).collect()
}

/// The words that move functions to where they are in the device.
fn transformation(space: &Space) -> Vec<String> {
    let device_from_function = space.function_from_device.inverse();
    let mut turn: DMat3 = device_from_function.matrix3 * space.scale;
    let mut words = Vec::new();
    let mut push = |word: &str, numbers: &[f64]| {
        words.push(word.to_owned());
        words.extend(numbers.iter().map(|x| format!("{x:?}")));
    };
    if turn.determinant() < 0.0 {
        push("-mx", &[]);
        turn.x_axis = -turn.x_axis;
    }
    if space.scale != 1.0 {
        push("-s", &[1.0 / space.scale]);
    }
    // Turned about x by a, y by b and z by c: the rows of the matrix are its columns' components.
    let sin_b = -turn.x_axis.z;
    let (a, b, c) = if sin_b.abs() < 1.0 - 1e-12 {
        (turn.y_axis.z.atan2(turn.z_axis.z), sin_b.asin(), turn.x_axis.y.atan2(turn.x_axis.x))
    } else {
        ((-turn.z_axis.y).atan2(turn.y_axis.y), std::f64::consts::FRAC_PI_2.copysign(sin_b), 0.0)
    };
    for (word, angle) in [("-rx", a), ("-ry", b), ("-rz", c)] {
        if angle != 0.0 {
            push(word, &[angle.to_degrees()]);
        }
    }
    let offset: DVec3 = device_from_function.translation;
    if offset != DVec3::ZERO {
        push("-t", &offset.to_array());
    }
    words
}

/// A word that is read as one.
fn quoted(word: &str) -> String {
    let plain = !word.is_empty() && !word.contains(|c: char| c.is_whitespace() || c == '"' || c == '\'');
    match (plain, word.contains('"')) {
        (true, _) => word.to_owned(),
        (false, true) => format!("'{word}'"),
        (false, false) => format!("\"{word}\""),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::field::{File, Origin};
    use crate::rad::transform;

    #[test]
    fn transformations_read_back_as_they_were() {
        for text in [
            "",
            "-rx 90",
            "-ry 90 -rx 20",
            "-ry -90 -rz 33 -t 1 2 3",
            "-mx -rz 30",
            "-s 2.5 -my -rx 12 -ry 60 -rz -120 -t .5 -.25 8",
            "-mz -s .0254 -ry 180",
            "-s -1 -t 0 0 1",
        ] {
            let words: Vec<String> = text.split_whitespace().map(str::to_owned).collect();
            let original = transform::single(&words).unwrap();
            let at = crate::error::Place { file: "a".into(), line: 1 };
            let origin = Origin { kind: "texfunc".into(), name: "t".into(), at };
            let file = File { path: ".".into(), digest: 0 };
            let space = Space::new(origin, file, [].into(), original.affine(), original.scale, 1.0);
            let again = transform::single(&transformation(&space)).unwrap();
            for p in [DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z, DVec3::new(3.0, -4.0, 5.0)] {
                assert!(
                    again.point(p).distance(original.point(p)) < 1e-12,
                    "{text}: {:?}",
                    transformation(&space)
                );
            }
        }
    }
}
