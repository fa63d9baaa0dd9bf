//! `replmarks`: triangles that mark places become what belongs there.
//!
//! A mark is a polygon of a certain modifier: its longest side is left aside, the next is the new x axis, the next the direction of
//! the new y axis, and where those two meet is the new origin. Deviations: numbers are not cut to six decimals,
//! and commands in what it reads are left as they are, so `-e` is refused where there are any.

use glam::{DMat3, DVec3};

use super::Environment;
use super::arguments::Arguments;
use crate::error::DeviceError;
use crate::rad::{Content, Primitive, Statement, command_word};

const USAGE: &str = "[-e] [-s size] [-m modout] {-x objfile | -i octree | -I mesh} modname .. [file ..]";

/// What to replace, and where to read it.
pub(crate) struct Marks {
    rules: Vec<Rule>,
    /// Whether commands in the files are to be replaced in as well.
    expands: bool,
    /// What to read; nothing: what comes through the pipe.
    pub files: Vec<String>,
}

struct Rule {
    modifier: String,
    by: By,
    file: String,
    new_modifier: Option<String>,
    /// Size of the object for a mark of length 1, if it is not to keep its own.
    size: Option<f64>,
}

#[derive(Clone, Copy)]
enum By {
    Command,
    Primitive(&'static str),
}

impl Marks {
    /// Reads the words after `replmarks`.
    pub(crate) fn parse(words: &[String], environment: &Environment) -> Result<Marks, DeviceError> {
        let mut arguments = Arguments::new("replmarks", USAGE, words, environment.at);
        let mut marks = Marks { rules: Vec::new(), expands: false, files: Vec::new() };
        let (mut new_modifier, mut size) = (None, None);
        while let Some(option) = arguments.peek().filter(|word| word.starts_with('-')) {
            arguments.next();
            let by = match option {
                "-e" => {
                    marks.expands = true;
                    continue;
                }
                "-m" => {
                    new_modifier = Some(arguments.word("a modifier after -m")?.to_owned());
                    continue;
                }
                "-s" => {
                    size = Some(arguments.number_that("a size above 0 after -s", |s| s > 0.0)?);
                    continue;
                }
                "-x" => By::Command,
                "-i" => By::Primitive("instance"),
                "-I" => By::Primitive("mesh"),
                other => return Err(arguments.unknown(other)),
            };
            let file = arguments.word(&format!("a file after {option}"))?.to_owned();
            let modifier = arguments.word("the modifier of the marks")?.to_owned();
            marks.rules.push(Rule { modifier, by, file, new_modifier: new_modifier.take(), size });
        }
        if marks.rules.is_empty() {
            return Err(arguments.unexpected("-x, -i or -I", arguments.peek()));
        }
        while let Some(file) = arguments.next() {
            marks.files.push(file.to_owned());
        }
        Ok(marks)
    }

    /// The statements with the marks among them replaced.
    pub(crate) fn apply(
        &self,
        statements: &[Statement],
        environment: &Environment,
    ) -> Result<Vec<Statement>, DeviceError> {
        let replace = |statement: &Statement| match &statement.content {
            Content::Command(_) if self.expands => Err(DeviceError::Unsupported {
                at: environment.at.clone(),
                what: format!("replmarks -e over a command (line {} of its input)", statement.line),
                advice: "put what the command makes into the file instead of the command".to_owned(),
            }),
            Content::Primitive(p) if p.kind == "polygon" => {
                let rule = self.rules.iter().find(|rule| rule.modifier == p.modifier);
                Ok(rule.and_then(|rule| rule.replacement(p, statement.line)))
            }
            _ => Ok(None),
        };
        statements
            .iter()
            .map(|statement| Ok(replace(statement)?.unwrap_or_else(|| statement.clone())))
            .collect()
    }
}

impl Rule {
    /// What stands in the place of a mark; `None` if the polygon is none.
    fn replacement(&self, mark: &Primitive, line: u32) -> Option<Statement> {
        let frame = Frame::of(mark)?;
        let mut words: Vec<String> = Vec::new();
        let mut add = |option: &str, numbers: &[f64]| {
            words.push(option.to_owned());
            words.extend(numbers.iter().map(|x| format!("{x:?}")));
        };
        if let Some(size) = self.size {
            add("-s", &[size * frame.length]);
        }
        for (option, angle) in ["-rx", "-ry", "-rz"].into_iter().zip(frame.angles_deg()) {
            if angle != 0.0 {
                add(option, &[angle]);
            }
        }
        add("-t", &frame.origin.to_array());
        Some(match self.by {
            By::Primitive(kind) => {
                let modifier = self.new_modifier.as_deref().unwrap_or("void");
                let strings: Vec<&str> =
                    std::iter::once(&*self.file).chain(words.iter().map(|w| &**w)).collect();
                Statement::made(line, modifier, kind, mark.name.clone(), &strings, Vec::new())
            }
            By::Command => {
                let mut command = format!("xform -n {}", command_word(&mark.name));
                if let Some(modifier) = &self.new_modifier {
                    command += &format!(" -m {}", command_word(modifier));
                }
                command += &format!(" {} {}", words.join(" "), command_word(&self.file));
                Statement { line, content: Content::Command(command) }
            }
        })
    }
}

/// Where a mark puts things.
struct Frame {
    origin: DVec3,
    axes: DMat3,
    /// Length of the mark along its x axis.
    length: f64,
}

impl Frame {
    /// `None` for polygons of less than three corners or without area.
    fn of(mark: &Primitive) -> Option<Frame> {
        let corners: Vec<DVec3> = mark.reals.chunks_exact(3).map(DVec3::from_slice).collect();
        let n = corners.len();
        if n < 3 {
            return None;
        }
        let side = |k: usize| corners[(k + 1) % n] - corners[k];
        let mut by_length: Vec<usize> = (0..n).collect();
        by_length.sort_by(|&a, &b| side(b).length_squared().total_cmp(&side(a).length_squared()));
        let (x, y) = (by_length[1], by_length[2]);
        // The sides meet where one ends and the other begins; if they do not meet, x begins where its side does.
        let [along, up] = if (x + 1) % n == y { [-side(x), side(y)] } else { [side(x), -side(y)] };
        let origin = corners[if (x + 1) % n == y { y } else { x }];
        let x_axis = along.try_normalize()?;
        let z_axis = along.cross(up).try_normalize()?;
        Some(Frame {
            origin,
            axes: DMat3::from_cols(x_axis, z_axis.cross(x_axis), z_axis),
            length: along.length(),
        })
    }

    /// Angles of turns about x, y and z, in this order.
    fn angles_deg(&self) -> [f64; 3] {
        let (x, y, z) = (self.axes.x_axis, self.axes.y_axis, self.axes.z_axis);
        let about_y = -x.z.clamp(-1.0, 1.0).asin();
        let (about_x, about_z) = if x.truncate().length() > 1e-9 {
            (y.z.atan2(z.z), x.y.atan2(x.x))
        } else {
            // x is upright: turns about x and z are the same.
            (0.0, (-y.x).atan2(y.y))
        };
        [about_x, about_y, about_z].map(f64::to_degrees)
    }
}
