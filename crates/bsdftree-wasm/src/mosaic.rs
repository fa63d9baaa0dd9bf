//! The whole function in one picture, as G. Ward's talks on tensor trees show it: a tile for each incident cell, in it all exitant directions.
//!
//! In: a function, how fine tiles and their pixels are, and the part of the picture that is wanted. Out: f32 of that part, row by row from the top.
//! What one pixel is does not depend on the part: a picture can be looked at as a map is, down to single cells.
//!
//! A place follows the direction in which light *heads*, of a tile the incident light, inside of it what leaves, so that light that is mirrored or goes straight on
//! keeps its place. Trees of rank 4 and matrices: tiles lie as the Shirley–Chiu square, X to the right and Y up. Rank 3: one tile for each
//! range of polar angles, from normal to grazing in reading order; the light heads to the right. `bsdftree.plot.mosaic` in Python has the same tiles.
//!
//! Pixels of trees are means over their incident and exitant cell; only leaves that they meet are walked over. Pixels of matrices are means over their exitant cell,
//! by 128 × 128 samples of a tile, for the incident direction in the middle of the tile.

use std::f64::consts::PI;
use std::ops::Range;

use bsdftree::square::disk_from_square;
use bsdftree::tree::{Arena, Content, Position, Slot};
use bsdftree::{Basis, Direction, Matrix, Part, Rank, Scattering, Side, Tree};

/// The widest and highest part of a picture \[pixel\].
const MOST_PIXELS: u32 = 4096;

/// The finest tiles: 2^9 along an axis.
const MOST_LOG2_TILES: u32 = 9;

/// The finest pixels of a tile: where a matrix's borders lie is told to 2^-10, a tree's leaves are no finer.
const MOST_LOG2_EXITANT: u32 = 15;
const MATRIX_LOG2_EXITANT: u32 = 10;

/// Tiles of a matrix that are worth looking at: fine beside Klems's patches.
const MATRIX_LOG2_TILES: u32 = 7;

/// Samples of a matrix along each axis of a tile, where pixels are coarser: so fine that no patch is missed.
const LOG2_SAMPLES: u32 = 7;

/// Bits of a coordinate of [`Position::corner`] at its finest.
const CORNER_BITS: u32 = 15;

/// What a pixel shows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Quantity {
    /// BSDF \[1/sr\].
    Value,
    /// How fine the exitant cell is: ½·log2(π / projected solid angle). Of a leaf, how many times the square was halved along each axis.
    Depth,
}

/// How the tiles of a function lie.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Layout {
    rank: Rank,
    log2_tiles: u32,
    /// Tiles beside each other.
    pub columns: u32,
    /// Rows of tiles.
    pub rows: u32,
}

/// A part of a picture \[pixel\], from its top left.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Window {
    /// Columns left of it.
    pub x: u32,
    /// Rows above it.
    pub y: u32,
    /// Columns.
    pub width: u32,
    /// Rows.
    pub height: u32,
}

/// The finest tiles, and the finest pixels of a tile, that show more than coarser ones: log2 of their number along an axis.
pub fn finest(function: &Scattering) -> [u32; 2] {
    match function {
        Scattering::Tree(tree) => {
            let log2_res = tree.arena().log2_res();
            [log2_res.min(MOST_LOG2_TILES).max(least(tree.rank())), log2_res]
        }
        Scattering::Matrix(_) => [MATRIX_LOG2_TILES, MATRIX_LOG2_EXITANT],
    }
}

/// Of rank 3 only the half of the incident axis that is used has tiles, at least one.
fn least(rank: Rank) -> u32 {
    u32::from(rank == Rank::Three)
}

impl Layout {
    /// 2^`log2_tiles` incident cells along each axis, as near to that as there is.
    pub fn new(function: &Scattering, log2_tiles: u32) -> Layout {
        let rank = match function {
            Scattering::Tree(tree) => tree.rank(),
            Scattering::Matrix(_) => Rank::Four,
        };
        let log2_tiles = log2_tiles.clamp(least(rank), MOST_LOG2_TILES);
        let [log2_columns, log2_rows] = match rank {
            Rank::Four => [log2_tiles; 2],
            Rank::Three => [log2_tiles / 2, log2_tiles - 1 - log2_tiles / 2],
        };
        Layout { rank, log2_tiles, columns: 1 << log2_columns, rows: 1 << log2_rows }
    }

    /// The incident cell of a tile, in units of 2^-log2_tiles.
    fn cell(self, column: u32, row: u32) -> [u32; 2] {
        match self.rank {
            Rank::Four => [column, self.rows - 1 - row],
            Rank::Three => [self.columns * self.rows - 1 - (row * self.columns + column), 0],
        }
    }

    /// The tile of an incident cell.
    fn tile(self, [c0, c1]: [u32; 2]) -> [u32; 2] {
        match self.rank {
            Rank::Four => [c0, self.rows - 1 - c1],
            Rank::Three => {
                let n = self.columns * self.rows;
                let k = n - 1 - c0.min(n - 1);
                [k % self.columns, k / self.columns]
            }
        }
    }

    /// The incident direction in the middle of a tile, on the front.
    fn incident(self, column: u32, row: u32) -> Direction {
        let n = f64::from(1u32 << self.log2_tiles);
        let [c0, c1] = self.cell(column, row).map(|c| (f64::from(c) + 0.5) / n);
        let heading = match self.rank {
            Rank::Four => disk_from_square([c0, c1]),
            Rank::Three => [1.0 - 2.0 * c0, 0.0],
        };
        Side::Front.direction_from_disk(heading.map(|c| -c))
    }

    /// The pair of directions at a place, counted in tiles from the top left: the incident one is that of the middle of its tile.
    pub fn directions_at(self, part: Part, [x, y]: [f64; 2]) -> [Direction; 2] {
        let [(column, across), (row, down)] = [(x, self.columns), (y, self.rows)].map(|(c, n)| {
            let tile = c.max(0.0).floor().min(f64::from(n - 1));
            (tile as u32, (c - tile).clamp(0.0, 1.0))
        });
        let incident = on(self.incident(column, row), part.incident_side());
        [incident, part.exitant_side().direction_from_disk(disk_from_square([across, 1.0 - down]))]
    }

    /// Where a pair of directions lies, counted in tiles from the top left.
    pub fn place_of(self, incident: Direction, exitant: Direction) -> [f64; 2] {
        let position = Position::new(self.rank, incident, exitant);
        let coarse = position.corner(self.log2_tiles);
        let [column, row] = self.tile([coarse[0] as u32, coarse[1] as u32]);
        let fine = position.corner(CORNER_BITS);
        let first = self.rank.dimensions() - 2;
        let [across, up] =
            [fine[first], fine[first + 1]].map(|c| (c as f64 + 0.5) / f64::from(1u32 << CORNER_BITS));
        [f64::from(column) + across, f64::from(row) + 1.0 - up]
    }
}

fn on([x, y, z]: Direction, side: Side) -> Direction {
    [x, y, side.sign() * z.abs()]
}

/// A part of the picture that has 2^`log2_exitant` pixels along each axis of a tile; what lies outside of the picture is not there, so look at what
/// [`Window::within`] leaves of it.
pub fn mosaic(
    function: &Scattering,
    quantity: Quantity,
    layout: Layout,
    log2_exitant: u32,
    window: Window,
) -> Vec<f32> {
    let log2_exitant = log2_exitant.min(MOST_LOG2_EXITANT);
    let window = window.within(layout, log2_exitant);
    let mut pixels = vec![0.0; window.width as usize * window.height as usize];
    match function {
        Scattering::Tree(tree) => paint_tree(tree, quantity, layout, log2_exitant, window, &mut pixels),
        Scattering::Matrix(matrix) => {
            paint_matrix(matrix, quantity, layout, log2_exitant, window, &mut pixels)
        }
    }
    pixels
}

impl Window {
    /// What of it lies in the picture, and is not too large.
    pub fn within(self, layout: Layout, log2_exitant: u32) -> Window {
        let cut = |from: u32, n: u32, tiles: u32| {
            let from = from.min(tiles << log2_exitant);
            (from, n.min((tiles << log2_exitant) - from).min(MOST_PIXELS))
        };
        let ((x, width), (y, height)) =
            (cut(self.x, self.width, layout.columns), cut(self.y, self.height, layout.rows));
        Window { x, y, width, height }
    }

    /// The tiles that it meets, and of each what columns and rows of it.
    fn tiles(self, log2_exitant: u32) -> impl Iterator<Item = ([u32; 2], [Range<u32>; 2])> {
        let met = move |from: u32, n: u32| {
            let tiles =
                if n == 0 { 0..0 } else { from >> log2_exitant..((from + n - 1) >> log2_exitant) + 1 };
            tiles.map(move |tile| {
                let corner = tile << log2_exitant;
                (tile, from.max(corner) - corner..(from + n).min(corner + (1 << log2_exitant)) - corner)
            })
        };
        met(self.y, self.height).flat_map(move |(row, down)| {
            met(self.x, self.width).map(move |(column, across)| ([column, row], [across, down.clone()]))
        })
    }
}

fn paint_tree(
    tree: &Tree,
    quantity: Quantity,
    layout: Layout,
    log2_exitant: u32,
    window: Window,
    pixels: &mut [f32],
) {
    let n = 1u32 << log2_exitant;
    for ([column, row], [across, down]) in window.tiles(log2_exitant) {
        // Rows count downwards, the second coordinate upwards.
        let up = n - down.end..n - down.start;
        let mut walk = Walk {
            arena: tree.arena(),
            quantity,
            incident: layout.cell(column, row),
            log2_tiles: layout.log2_tiles,
            log2_exitant,
            left: (column << log2_exitant).wrapping_sub(window.x),
            bottom: ((row + 1) << log2_exitant).wrapping_sub(window.y + 1),
            width: window.width as usize,
            met: [across, up],
            pixels,
        };
        walk.descend(tree.arena().root(), 0, [0; 2], 1.0);
    }
}

/// Over the leaves of one tile.
struct Walk<'a> {
    arena: &'a Arena,
    quantity: Quantity,
    incident: [u32; 2],
    log2_tiles: u32,
    log2_exitant: u32,
    /// Where the tile's lower left pixel lies in the part, which may be outside of it.
    left: u32,
    bottom: u32,
    width: usize,
    /// Pixels of the tile that are in the part, Y up.
    met: [Range<u32>; 2],
    pixels: &'a mut [f32],
}

impl Walk<'_> {
    /// Below a slot whose exitant cell has that corner in units of its edge; `weight`: its share of each pixel that it lies in.
    fn descend(&mut self, slot: Slot, level: u32, corner: [u32; 2], weight: f32) {
        let Some(extent) = self.extent(level, corner) else { return };
        let node = match slot.content() {
            Content::Leaf(value) => return self.paint(value, level, extent, weight),
            Content::Node(node) => node,
        };
        let children = self.arena.children(node);
        let n_incident = self.arena.rank().dimensions() - 2;
        // All of the incident children below a tile, else the one that the tile lies in.
        let (incident, share) = match level < self.log2_tiles {
            true => {
                let bit = |c: u32| (c >> (self.log2_tiles - 1 - level) & 1) as usize;
                let own =
                    self.incident.iter().take(n_incident).enumerate().fold(0, |k, (i, &c)| k | bit(c) << i);
                (own..own + 1, 1.0)
            }
            false => (0..1 << n_incident, 1.0 / (1 << n_incident) as f32),
        };
        let weight = if level < self.log2_exitant { weight * share } else { 0.25 * weight * share };
        for k in 0..4 {
            let corner = [corner[0] << 1 | (k & 1), corner[1] << 1 | k >> 1];
            for i in incident.clone() {
                self.descend(children[i | (k as usize) << n_incident], level + 1, corner, weight);
            }
        }
    }

    /// The pixels of the tile that an exitant cell lies in and that are in the part.
    fn extent(&self, level: u32, corner: [u32; 2]) -> Option<[Range<u32>; 2]> {
        let mut extent = [0..0, 0..0];
        for (k, extent) in extent.iter_mut().enumerate() {
            let (from, n) = match level <= self.log2_exitant {
                true => (corner[k] << (self.log2_exitant - level), 1 << (self.log2_exitant - level)),
                false => (corner[k] >> (level - self.log2_exitant), 1),
            };
            *extent = from.max(self.met[k].start)..(from + n).min(self.met[k].end);
            if extent.start >= extent.end {
                return None;
            }
        }
        Some(extent)
    }

    fn paint(&mut self, value: f32, level: u32, [across, up]: [Range<u32>; 2], weight: f32) {
        let share = weight
            * match self.quantity {
                Quantity::Value => value,
                Quantity::Depth => level as f32,
            };
        for y in up {
            let row = self.bottom.wrapping_sub(y) as usize * self.width;
            let place = |x: u32| row + self.left.wrapping_add(x) as usize;
            self.pixels[place(across.start)..=place(across.end - 1)]
                .iter_mut()
                .for_each(|pixel| *pixel += share);
        }
    }
}

fn paint_matrix(
    matrix: &Matrix,
    quantity: Quantity,
    layout: Layout,
    log2_exitant: u32,
    window: Window,
    pixels: &mut [f32],
) {
    let basis = matrix.exitant();
    let depths: Vec<f32> = (0..basis.n_patches()).map(|k| depth(basis.projected_solid_angle(k))).collect();
    let shares = (log2_exitant < LOG2_SAMPLES).then(|| Shares::new(basis, log2_exitant));
    for ([column, row], [across, down]) in window.tiles(log2_exitant) {
        let [x, y, z] = layout.incident(column, row);
        let incident = matrix.incident().patch([-x, -y, z]);
        let of_patch = match quantity {
            Quantity::Value => &matrix.values()[incident * basis.n_patches()..][..basis.n_patches()],
            Quantity::Depth => &depths,
        };
        for y in down {
            let line = ((row << log2_exitant) + y - window.y) as usize * window.width as usize;
            for x in across.clone() {
                pixels[line + ((column << log2_exitant) + x - window.x) as usize] = match &shares {
                    Some(shares) => shares.mean(of_patch, x, y),
                    None => of_patch[patch_at(basis, log2_exitant, x, y)],
                };
            }
        }
    }
}

/// The patch at the middle of a pixel of a tile, whose rows count downwards.
fn patch_at(basis: &Basis, log2_exitant: u32, x: u32, y: u32) -> usize {
    let middle = |k: u32| (f64::from(k) + 0.5) / f64::from(1u32 << log2_exitant);
    basis.patch(Side::Front.direction_from_disk(disk_from_square([middle(x), 1.0 - middle(y)])))
}

/// Which patches lie in each pixel of a tile, and with what share of it: of all samples, of which pixels have equally many.
struct Shares {
    log2_exitant: u32,
    /// Where the patches of each pixel begin, and end.
    ends: Vec<u32>,
    of_pixels: Vec<(u32, f32)>,
}

impl Shares {
    fn new(basis: &Basis, log2_exitant: u32) -> Shares {
        let (n, n_samples) = (1u32 << log2_exitant, 1u32 << (LOG2_SAMPLES - log2_exitant));
        let share = 1.0 / (n_samples * n_samples) as f32;
        let (mut ends, mut of_pixels) = (vec![0], Vec::new());
        for pixel in 0..n * n {
            let corner = [pixel % n * n_samples, pixel / n * n_samples];
            let first = of_pixels.len();
            for k in 0..n_samples * n_samples {
                let (x, y) = (corner[0] + k % n_samples, corner[1] + k / n_samples);
                let patch = patch_at(basis, LOG2_SAMPLES, x, y) as u32;
                match of_pixels[first..].iter_mut().find(|(known, _)| *known == patch) {
                    Some((_, sum)) => *sum += share,
                    None => of_pixels.push((patch, share)),
                }
            }
            ends.push(of_pixels.len() as u32);
        }
        Shares { log2_exitant, ends, of_pixels }
    }

    fn mean(&self, of_patch: &[f32], x: u32, y: u32) -> f32 {
        let pixel = ((y << self.log2_exitant) + x) as usize;
        let patches = &self.of_pixels[self.ends[pixel] as usize..self.ends[pixel + 1] as usize];
        patches.iter().map(|&(patch, share)| share * of_patch[patch as usize]).sum()
    }
}

/// How often the hemisphere was halved along each axis to become that small \[sr\].
pub fn depth(projected_solid_angle: f64) -> f32 {
    (0.5 * (PI / projected_solid_angle).log2()) as f32
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::*;
    use bsdftree::tree::TreeBuilder;

    /// Fine where the first and third coordinates are low, coarse elsewhere; all values differ.
    fn uneven(rank: Rank) -> Scattering {
        let mut builder = TreeBuilder::new(rank);
        let n = 1usize << (2 * rank.dimensions());
        let mut fine = |k: usize| {
            let values: Vec<f32> = (0..n).map(|j| 100.0 + (k * n + j) as f32).collect();
            builder.grid(&values, 2).unwrap()
        };
        let children: Vec<_> = (0..rank.n_children())
            .map(|k| if k & 5 == 0 { fine(k) } else { Slot::leaf(2.0 + k as f32) })
            .collect();
        let root = builder.node(&children).unwrap();
        Tree::new(builder.finish(root)).into()
    }

    fn klems() -> Scattering {
        let basis = Arc::new(Basis::quarter());
        let n = basis.n_patches();
        let values = (0..n * n).map(|k| 0.1 + k as f32).collect();
        Matrix::new(basis.clone(), basis, values).unwrap().into()
    }

    fn functions() -> [Scattering; 3] {
        [uneven(Rank::Four), uneven(Rank::Three), klems()]
    }

    fn whole(layout: Layout, log2_exitant: u32) -> Window {
        Window { x: 0, y: 0, width: layout.columns << log2_exitant, height: layout.rows << log2_exitant }
    }

    #[test]
    fn a_fine_pixel_is_the_cell_of_its_directions() {
        let part = Part::TransmissionBack;
        for function in functions() {
            let layout = Layout::new(&function, 3);
            let log2_exitant = if matches!(function, Scattering::Matrix(_)) { LOG2_SAMPLES } else { 3 };
            let window = whole(layout, log2_exitant);
            let [values, depths] = [Quantity::Value, Quantity::Depth]
                .map(|quantity| mosaic(&function, quantity, layout, log2_exitant, window));
            for k in 0..values.len() {
                let (x, y) = (k as u32 % window.width, k as u32 / window.width);
                let place = [x, y].map(|c| (f64::from(c) + 0.5) / f64::from(1u32 << log2_exitant));
                let [incident, exitant] = layout.directions_at(part, place);
                assert!(incident[2] > 0.0 && exitant[2] < 0.0);
                let cell = function.cell(incident, exitant, false);
                assert_eq!(f64::from(values[k]), cell.value, "{layout:?} {place:?}");
                assert!((depths[k] - depth(cell.projected_solid_angle)).abs() < 1e-6);
                let back = layout.place_of(incident, exitant);
                assert!((0..2).all(|k| (back[k] - place[k]).abs() < 1e-4), "{layout:?} {place:?} {back:?}");
            }
        }
    }

    #[test]
    fn a_part_is_cut_from_the_whole() {
        for function in functions() {
            for [log2_tiles, log2_exitant] in [[3, 3], [2, 5], [1, 2]] {
                let layout = Layout::new(&function, log2_tiles);
                let all = whole(layout, log2_exitant);
                let window = Window { x: 3, y: 1, width: 6, height: 4 }.within(layout, log2_exitant);
                let picture = mosaic(&function, Quantity::Value, layout, log2_exitant, all);
                let part = mosaic(&function, Quantity::Value, layout, log2_exitant, window);
                assert_eq!(part.len(), (window.width * window.height) as usize);
                for (k, &value) in part.iter().enumerate() {
                    let (x, y) = (window.x + k as u32 % window.width, window.y + k as u32 / window.width);
                    assert_eq!(value, picture[(y * all.width + x) as usize]);
                }
            }
        }
    }

    #[test]
    fn coarse_pixels_are_means_of_fine_ones() {
        for function in functions() {
            let picture =
                |layout, log2| mosaic(&function, Quantity::Value, layout, log2, whole(layout, log2));
            let layout = Layout::new(&function, 3);
            let finest = if matches!(function, Scattering::Matrix(_)) { LOG2_SAMPLES } else { 3 };
            let (fine, coarse) = (picture(layout, finest), picture(layout, finest - 2));
            let [wide, narrow] = [finest, finest - 2].map(|log2| (layout.columns << log2) as usize);
            for (k, &value) in coarse.iter().enumerate() {
                let (x, y) = (4 * (k % narrow), 4 * (k / narrow));
                let mean = (0..16).map(|j| fine[(y + j / 4) * wide + x + j % 4]).sum::<f32>() / 16.0;
                assert!((value / mean - 1.0).abs() < 1e-5, "{k}: {value} {mean}");
            }
        }
        // And of incident cells.
        for function in [uneven(Rank::Four), uneven(Rank::Three)] {
            let picture =
                |layout, log2| mosaic(&function, Quantity::Value, layout, log2, whole(layout, log2));
            let mean = |picture: Vec<f32>| picture.iter().sum::<f32>() / picture.len() as f32;
            let [fine, coarse] =
                [3, 1].map(|log2_tiles| mean(picture(Layout::new(&function, log2_tiles), 3)));
            assert!((fine / coarse - 1.0).abs() < 1e-5, "{fine} {coarse}");
        }
    }

    #[test]
    fn what_lies_outside_of_the_picture_is_not_there() {
        let function = uneven(Rank::Four);
        let layout = Layout::new(&function, 3);
        let window = Window { x: 60, y: 64, width: u32::MAX, height: 9 };
        assert_eq!(window.within(layout, 3), Window { x: 60, y: 64, width: 4, height: 0 });
        assert!(mosaic(&function, Quantity::Value, layout, 3, window).is_empty());
    }

    #[test]
    fn tiles_of_rank_3_go_from_normal_to_grazing() {
        let function = uneven(Rank::Three);
        let layout = Layout::new(&function, 6);
        assert_eq!([layout.columns, layout.rows], [8, 4]);
        let sine = |x: f64, y: f64| layout.directions_at(Part::ReflectionBack, [x, y])[0][0];
        assert!(
            (sine(0.5, 0.5) + 1.0 / 64.0).abs() < 1e-12,
            "the light heads to the right: it comes from the left"
        );
        assert!(sine(1.5, 0.5) < sine(0.5, 0.5) && sine(0.5, 1.5) < sine(7.5, 0.5));
    }
}
