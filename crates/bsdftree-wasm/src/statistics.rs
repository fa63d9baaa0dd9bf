//! How a function is divided: its cells by size, what light is in them, which values there are.
//!
//! In: a tree or a matrix. Out: JSON. Cells are leaves of trees, by depth (edge 2^-depth of the square), or pairs of patches of matrices, by exitant
//! ring. Shares are of projected solid angle of incident times that of exitant directions; the half of the incident axis of rank 3 that is never
//! used has none. As `bsdftree.plot.stats` in Python.

use bsdftree::tree::Leaf;
use bsdftree::{Basis, Matrix, Rank, Scattering, Tree};
use serde_json::{Value, json};

/// The histogram's columns for each decade of values, and the most decades below the largest one.
const BINS_OF_DECADE: i32 = 8;
const MOST_DECADES: i32 = 8;

#[derive(Clone, Default)]
struct Group {
    label: String,
    n_cells: u64,
    share: f64,
    flux: f64,
}

/// What there is of cells, values and light.
pub fn statistics(function: &Scattering) -> Value {
    let mut groups = match function {
        Scattering::Tree(tree) => labelled((0..=tree.arena().log2_res()).map(|depth| format!("2^{depth}"))),
        Scattering::Matrix(matrix) => labelled(matrix.exitant().rings().iter().map(|ring| {
            let [lower, upper] = ring.bounds_deg;
            format!("{lower}–{upper}°")
        })),
    };
    let mut histogram = Histogram::default();
    each_cell(function, |cell| {
        let group = &mut groups[cell.group];
        group.n_cells += 1;
        group.share += cell.share;
        group.flux += cell.share * f64::from(cell.value);
        histogram.add(&cell);
    });
    let flux: f64 = groups.iter().map(|group| group.flux).sum();
    let light = |part: f64| if flux > 0.0 { part / flux } else { 0.0 };
    let told: Vec<Value> = groups
        .iter()
        .map(|g| json!({ "label": g.label, "n_cells": g.n_cells, "share": g.share, "light": light(g.flux) }))
        .collect();
    json!({
        "kind": match function { Scattering::Tree(_) => "depth", Scattering::Matrix(_) => "exitant ring" },
        "groups": told,
        "histogram": histogram.told(light),
    })
}

fn labelled(labels: impl Iterator<Item = String>) -> Vec<Group> {
    labels.map(|label| Group { label, ..Group::default() }).collect()
}

/// How many cells and how much light there is of which values: columns of equal ratio.
struct Histogram {
    /// For all values that an `f32` has, from [`FIRST_DECADE`] up.
    columns: Vec<(u64, f64)>,
    n_black: u64,
}

/// Of the smallest `f32`, and how many there are up to the largest.
const FIRST_DECADE: i32 = -45;
const N_DECADES: i32 = 84;

impl Default for Histogram {
    fn default() -> Histogram {
        Histogram { columns: vec![(0, 0.0); (N_DECADES * BINS_OF_DECADE) as usize], n_black: 0 }
    }
}

impl Histogram {
    fn add(&mut self, cell: &Cell) {
        if cell.value > 0.0 {
            let value = f64::from(cell.value);
            let place = (value.log10() - f64::from(FIRST_DECADE)) * f64::from(BINS_OF_DECADE);
            let column = &mut self.columns[place as usize];
            *column = (column.0 + 1, column.1 + cell.share * value);
        } else {
            self.n_black += 1;
        }
    }

    /// Between two powers of ten, at most [`MOST_DECADES`] apart: what is smaller counts in the first column.
    fn told(self, light: impl Fn(f64) -> f64) -> Value {
        let is_met = |(n, _): &(u64, f64)| *n > 0;
        let n_all = self.n_black + self.columns.iter().map(|(n, _)| n).sum::<u64>();
        let decade = |column: usize| column as i32 / BINS_OF_DECADE;
        // From 1 to 10 if all is black.
        let last = self.columns.iter().rposition(is_met).map_or(1 - FIRST_DECADE, |k| decade(k) + 1);
        let first = self.columns.iter().position(is_met).map_or(last - 1, decade).max(last - MOST_DECADES);
        let (below, shown) =
            self.columns[..(last * BINS_OF_DECADE) as usize].split_at((first * BINS_OF_DECADE) as usize);
        let mut shown = shown.to_vec();
        for (n, flux) in below {
            shown[0] = (shown[0].0 + n, shown[0].1 + flux);
        }
        json!({
            "first_decade": first + FIRST_DECADE,
            "last_decade": last + FIRST_DECADE,
            "n_cells": shown.iter().map(|(n, _)| *n).collect::<Vec<u64>>(),
            "light": shown.iter().map(|(_, flux)| light(*flux)).collect::<Vec<f64>>(),
            "black": self.n_black as f64 / n_all as f64,
        })
    }
}

struct Cell {
    group: usize,
    /// Of all pairs of directions.
    share: f64,
    /// \[1/sr\]
    value: f32,
}

fn each_cell(function: &Scattering, mut see: impl FnMut(Cell)) {
    match function {
        Scattering::Tree(tree) => {
            tree.leaves().for_each(|leaf| {
                see(Cell { group: leaf.level as usize, share: share(tree, &leaf), value: leaf.value });
            });
        }
        Scattering::Matrix(matrix) => each_pair(matrix, see),
    }
}

/// A leaf's part of all pairs of directions.
pub fn share(tree: &Tree, leaf: &Leaf) -> f64 {
    let edge = 0.5f64.powi(leaf.level as i32);
    match tree.rank() {
        Rank::Four => edge.powi(4),
        Rank::Three => {
            // d0 is ½ at the normal and 0 at grazing: the sine is 1 − 2 d0, the projected solid angle goes as its square.
            let square = |end: u32| (1.0 - 2.0 * f64::from(leaf.cell[0] + end) * edge).max(0.0).powi(2);
            (square(0) - square(1)) * edge * edge
        }
    }
}

fn each_pair(matrix: &Matrix, mut see: impl FnMut(Cell)) {
    let shares = |basis: &Basis| -> Vec<f64> {
        let areas: Vec<f64> = (0..basis.n_patches()).map(|k| basis.projected_solid_angle(k)).collect();
        let whole: f64 = areas.iter().sum();
        areas.into_iter().map(|area| area / whole).collect()
    };
    let (incident, exitant) = (shares(matrix.incident()), shares(matrix.exitant()));
    let rings = matrix.exitant().rings().iter().enumerate();
    let groups: Vec<usize> = rings.flat_map(|(k, ring)| vec![k; ring.n_phi as usize]).collect();
    for (values, from) in matrix.values().chunks_exact(exitant.len()).zip(incident) {
        for ((&value, to), &group) in values.iter().zip(&exitant).zip(&groups) {
            see(Cell { group, share: from * to, value });
        }
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::*;
    use bsdftree::direction::direction_from_polar;

    fn sum(values: &Value, key: &str) -> f64 {
        values.as_array().unwrap().iter().map(|group| group[key].as_f64().unwrap()).sum()
    }

    #[test]
    fn shares_are_whole_and_light_is_where_values_are() {
        let values =
            |n: usize| (0..n).map(|k| if k % 2 == 0 { 0.0 } else { 1.0 + k as f32 }).collect::<Vec<f32>>();
        let basis = Arc::new(Basis::quarter());
        let n = basis.n_patches();
        let functions: [Scattering; 3] = [
            Tree::from_grid(Rank::Four, &values(256)).unwrap().into(),
            Tree::from_grid(Rank::Three, &values(512)).unwrap().into(),
            Matrix::new(basis.clone(), basis, values(n * n)).unwrap().into(),
        ];
        for function in functions {
            let found = statistics(&function);
            for key in ["share", "light"] {
                assert!((sum(&found["groups"], key) - 1.0).abs() < 1e-12, "{found}");
            }
            assert_eq!(sum(&found["groups"], "n_cells"), function.n_values() as f64);
            let histogram = &found["histogram"];
            let all = |key: &str| {
                histogram[key].as_array().unwrap().iter().map(|n| n.as_f64().unwrap()).sum::<f64>()
            };
            assert!((all("light") - 1.0).abs() < 1e-12);
            let black = histogram["black"].as_f64().unwrap();
            assert_eq!(all("n_cells"), ((1.0 - black) * function.n_values() as f64).round());
            assert!((black - 0.5).abs() < 1e-2);
        }
    }

    #[test]
    fn light_of_rank_3_is_weighted_as_totals_are() {
        // Light at one range of polar angles only: that of the second quarter of the incident axis.
        let values: Vec<f32> = (0..64).map(|k| if k / 16 == 1 { 1.0 } else { 0.0 }).collect();
        let tree = Tree::from_grid(Rank::Three, &values).unwrap();
        let shares: f64 = tree.leaves().filter(|leaf| leaf.value > 0.0).map(|leaf| share(&tree, &leaf)).sum();
        // sin θ < ½ is a quarter of the projected solid angle.
        assert!((shares - 0.25).abs() < 1e-12);
        assert!(tree.hemispherical(direction_from_polar(0.5, 1.0), false) > 0.0);
        assert_eq!(tree.hemispherical(direction_from_polar(0.6, 1.0), false), 0.0);
    }

    #[test]
    fn a_black_function_has_no_light() {
        let found = statistics(&Tree::uniform(Rank::Four, 0.0).into());
        assert_eq!(sum(&found["groups"], "light"), 0.0);
        assert_eq!(found["histogram"]["black"], 1.0);
    }
}
