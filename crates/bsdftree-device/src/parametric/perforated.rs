//! An opaque sheet with round holes on a square or triangular grid.
//!
//! The circles are polygons of the same area, so the openness is exact: π d² / (4 p²) on the square grid and
//! π d² / (2√3 p²) on the triangular one. Geometry: the sheet fills −thickness ≤ z ≤ 0; it is made of half cells, each
//! with half a hole, so that all polygons are simple and rows can be shifted by half a pitch. Limit: holes stay within
//! their row of cells, so on the triangular grid d must be below √3/2 p. There, cells of
//! neighbouring rows share lines but not corners; the lines are exactly straight.

use std::f64::consts::{PI, TAU};

use glam::{DVec2, DVec3, dvec2};

use super::builder::{Builder, plastic};
use super::family::{Domain, Family, Parameter, Values};
use crate::device::Device;

pub(super) const FAMILY: Family = Family {
    name: "perforated",
    summary: "an opaque sheet with round holes on a square or triangular grid",
    drawing: r"
        square grid           triangular grid
        o   o   o             o   o   o
                                o   o
        o   o   o             o   o   o
        |<->| pitch           |<->| pitch         +Y
                                                   |
        o: diameter                                +-- +X
",
    parameters: &[
        Parameter {
            name: "diameter",
            unit: "m",
            domain: Domain::length(0.003),
            meaning: "diameter of the holes",
        },
        Parameter {
            name: "pitch",
            unit: "m",
            domain: Domain::length(0.005),
            meaning: "distance of neighbouring holes",
        },
        Parameter {
            name: "grid",
            unit: "",
            domain: Domain::Word(&["square", "triangular"]),
            meaning: "how the holes lie",
        },
        Parameter {
            name: "sides",
            unit: "",
            domain: Domain::Number { default: 24.0, least: 4.0, most: 360.0 },
            meaning: "sides of the polygons that stand for the circles; even",
        },
        Parameter {
            name: "thickness",
            unit: "m",
            domain: Domain::length_or_zero(0.001),
            meaning: "thickness of the sheet; 0 is a single surface",
        },
        Parameter {
            name: "reflectance",
            unit: "",
            domain: Domain::fraction(0.7),
            meaning: "reflectance of the sheet's colour (Radiance plastic)",
        },
        Parameter { name: "specular", unit: "", domain: Domain::fraction(0.0), meaning: "specular fraction" },
        Parameter {
            name: "roughness",
            unit: "",
            domain: Domain::fraction(0.0),
            meaning: "RMS slope of the specular part",
        },
        Parameter {
            name: "width",
            unit: "m",
            domain: Domain::length(0.1),
            meaning: "extent along X, cut to whole cells",
        },
        Parameter {
            name: "height",
            unit: "m",
            domain: Domain::length(0.1),
            meaning: "extent along Y, cut to whole cells",
        },
    ],
    build,
};

/// Most half cells of a sheet.
const MOST_HALVES: usize = 1_000_000;

fn build(values: &Values) -> Result<Device, String> {
    let sheet = Sheet::of(values)?;
    let mut builder = Builder::default();
    let material =
        plastic(values.number("reflectance"), values.number("specular"), values.number("roughness"));
    let material = builder.material("sheet", &material);
    for row in 0..sheet.n_rows {
        for half in 0..2 * sheet.n_columns {
            sheet.half_cell(&mut builder, row, half, material);
        }
    }
    // Cells are whole: neighbours only meet at their borders. Rows of a triangular grid repeat in pairs.
    let (column, n) = (sheet.n_columns / 2, if sheet.triangular { 2 } else { 1 });
    let row = sheet.n_rows / 2 / n * n;
    let row = row.min(sheet.n_rows - n);
    let x = [2 * column, 2 * column + 2].map(|half| sheet.x(half));
    Ok(builder.finish_periodic(x, [sheet.y(row), sheet.y(row + n)]))
}

/// The grid of cells; columns are counted in halves.
struct Sheet {
    n_columns: usize,
    n_rows: usize,
    pitch: f64,
    row_height: f64,
    triangular: bool,
    /// Half of the hole around the origin with x ≥ 0, from its top to its bottom.
    half_hole: Vec<DVec2>,
    thickness: f64,
}

impl Sheet {
    fn of(values: &Values) -> Result<Self, String> {
        let (pitch, diameter) = (values.number("pitch"), values.number("diameter"));
        let triangular = values.word("grid") == "triangular";
        let row_height = if triangular { 0.75f64.sqrt() * pitch } else { pitch };
        let sides = values.number("sides");
        if sides % 2.0 != 0.0 {
            return Err(format!("sides must be an even number, not {sides}"));
        }
        // A polygon of n sides with this radius has the area of the circle.
        let radius = 0.5 * diameter * (PI / (0.5 * sides * (TAU / sides).sin())).sqrt();
        if radius >= 0.4999 * row_height {
            let most = 2.0 * 0.4999 * row_height * (0.5 * diameter / radius);
            return Err(format!(
                "diameter must be below {most:.6} m for holes that do not touch at this pitch"
            ));
        }
        let n_columns = values.n_fit("width", "pitch")?;
        let mut n_rows = (values.number("height") / row_height + 1e-9).floor() as usize;
        if triangular {
            n_rows -= n_rows % 2;
        }
        if n_rows == 0 {
            return Err(format!(
                "height must be at least {:.6} m",
                row_height * if triangular { 2.0 } else { 1.0 }
            ));
        }
        if n_columns.saturating_mul(n_rows) > MOST_HALVES / 2 {
            return Err(format!(
                "it would have {} holes; at most {} are allowed",
                n_columns * n_rows,
                MOST_HALVES / 2
            ));
        }
        let n_arc = sides as usize / 2;
        let half_hole = (0..=n_arc).map(|k| {
            // The ends lie exactly on the middle line, where the other half joins.
            let (sin, cos) = (PI * k as f64 / n_arc as f64).sin_cos();
            radius * dvec2(if k == 0 || k == n_arc { 0.0 } else { sin }, cos)
        });
        let half_hole = half_hole.collect();
        Ok(Sheet {
            n_columns,
            n_rows,
            pitch,
            row_height,
            triangular,
            half_hole,
            thickness: values.number("thickness"),
        })
    }

    fn x(&self, half: usize) -> f64 {
        (half as f64 - self.n_columns as f64) * 0.5 * self.pitch
    }

    fn y(&self, row: usize) -> f64 {
        (row as f64 - 0.5 * self.n_rows as f64) * self.row_height
    }

    /// The half cell between columns `half` and `half + 1`, in halves.
    fn half_cell(&self, builder: &mut Builder, row: usize, half: usize, material: u32) {
        let shifted = self.triangular && row % 2 == 1;
        // Hole centres are at odd halves, in shifted rows at even ones.
        let right_of_hole = (half % 2 == 1) != shifted;
        let (inner, outer) = if right_of_hole { (half, half + 1) } else { (half + 1, half) };
        let (inner, outer) = (self.x(inner), self.x(outer));
        let (low, high) = (self.y(row), self.y(row + 1));
        let middle = 0.5 * (low + high);
        let side = if right_of_hole { 1.0 } else { -1.0 };
        let mut outline = vec![dvec2(inner, low), dvec2(outer, low), dvec2(outer, high), dvec2(inner, high)];
        outline.extend(self.half_hole.iter().map(|p| dvec2(inner + side * p.x, middle + p.y)));
        if !right_of_hole {
            outline.reverse();
        }
        let name = format!("sheet.{row}.{half}");
        builder.polygon(format!("{name}.front"), outline.iter().map(|p| p.extend(0.0)).collect(), material);
        if self.thickness == 0.0 {
            return;
        }
        let back = -self.thickness;
        builder.polygon(
            format!("{name}.back"),
            outline.iter().rev().map(|p| p.extend(back)).collect(),
            material,
        );
        for (k, &p) in outline.iter().enumerate() {
            let q = outline[(k + 1) % outline.len()];
            if !self.is_shared(p, q, inner, low, high) {
                let wall: [DVec3; 4] = [p.extend(back), q.extend(back), q.extend(0.0), p.extend(0.0)];
                builder.polygon(format!("{name}.wall.{k}"), wall.to_vec(), material);
            }
        }
    }

    /// Whether the edge of a half cell is where another half cell joins.
    fn is_shared(&self, p: DVec2, q: DVec2, inner: f64, low: f64, high: f64) -> bool {
        let border_x = [self.x(0), self.x(2 * self.n_columns)];
        let border_y = [self.y(0), self.y(self.n_rows)];
        let straight = (p.x == q.x && (p.x == inner || p.y == low || p.y == high))
            || p.y == q.y && (p.y == low || p.y == high);
        let on_border = (p.x == q.x && border_x.contains(&p.x)) || (p.y == q.y && border_y.contains(&p.y));
        straight && !on_border
    }
}

#[cfg(test)]
mod tests {
    use super::super::tests::{area_sum, volume};
    use super::*;

    fn front_area(device: &Device) -> f64 {
        device.surfaces.iter().filter(|s| s.name.ends_with("front")).map(|s| s.shape.area()).sum()
    }

    #[test]
    fn openness_is_the_closed_form() {
        for (grid, sides) in
            [("square", 24), ("triangular", 24), ("square", 4), ("triangular", 30), ("square", 6)]
        {
            let (d, p) = (0.003, 0.0051);
            let spec = format!("perforated:grid={grid},sides={sides},diameter={d},pitch={p}");
            let device = Device::from_spec(&spec).unwrap();
            let [low, high] = device.bounds().unwrap();
            let whole = (high - low).x * (high - low).y;
            let expected = match grid {
                "square" => PI * d * d / (4.0 * p * p),
                _ => PI * d * d / (2.0 * 3f64.sqrt() * p * p),
            };
            let openness = 1.0 - front_area(&device) / whole;
            assert!((openness - expected).abs() < 1e-12, "{spec}: {openness} is not {expected}");
        }
    }

    #[test]
    fn thick_sheets_are_closed() {
        for grid in ["square", "triangular"] {
            let device =
                Device::from_spec(&format!("perforated:grid={grid},height=0.02,width=0.02")).unwrap();
            assert!((volume(&device) - front_area(&device) * 0.001).abs() < 1e-15);
            // The surface of a closed body has no net area, here also not where its faces only touch along parts.
            assert!(area_sum(&device).length() < 1e-15, "{}", area_sum(&device));
            // Walls: the holes' perimeters and the border, cut where half holes meet it.
            let walls: f64 =
                device.surfaces.iter().filter(|s| s.name.contains("wall")).map(|s| s.shape.area()).sum();
            let [low, high] = device.bounds().unwrap();
            let size = high - low;
            let n_holes = (size.x * size.y
                / (0.005f64.powi(2) * if grid == "square" { 1.0 } else { 0.75f64.sqrt() }))
            .round();
            let radius = 0.0015 * (PI / (12.0 * (TAU / 24.0).sin())).sqrt();
            let perimeter = 24.0 * 2.0 * radius * (PI / 24.0).sin();
            let cut = if grid == "square" {
                0.0
            } else {
                4.0 * radius * (size.y / (0.75f64.sqrt() * 0.005) / 2.0).round()
            };
            let expected = 0.001 * (n_holes * perimeter + 2.0 * (size.x + size.y) - cut);
            assert!((walls / expected - 1.0).abs() < 1e-12, "{grid}: {walls} is not {expected}");
        }
    }

    #[test]
    fn triangular_holes_have_six_neighbours() {
        let sheet_row = 0.75f64.sqrt() * 0.005;
        // Holes of neighbouring rows are a half pitch and a row apart.
        assert!((0.0025f64.hypot(sheet_row) - 0.005).abs() < 1e-15);
        let device = Device::from_spec("perforated:grid=triangular,thickness=0").unwrap();
        assert!(device.surfaces.iter().all(|s| s.name.ends_with("front")));
        assert_eq!(device.surfaces.len(), 2 * 20 * 22);
    }

    #[test]
    fn holes_that_touch_are_refused() {
        for (spec, fits) in [
            ("diameter=0.005", false),
            ("diameter=0.0049", true),
            ("diameter=0.0044,grid=triangular", false),
            ("diameter=0.0042,grid=triangular", true),
            ("sides=7", false),
            ("sides=24.5", false),
            ("height=0.005,grid=triangular", false),
            ("width=100,height=100", false),
        ] {
            assert_eq!(Device::from_spec(&format!("perforated:{spec}")).is_ok(), fits, "{spec}");
        }
    }
}
