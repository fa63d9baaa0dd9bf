//! Following paths, block by block.
//!
//! In: a range of path numbers. Out: what they counted, added to what was counted before, and written to a checkpoint if there is
//! one. Everything random about a path follows from (seed, cell, number), so threads and interruptions change nothing.

use std::ops::Range;
use std::time::Instant;

use bsdftree::Side;
use glam::DVec3;
use rayon::prelude::*;

use crate::bands::Detector;
use crate::checkpoint::RoundFile;
use crate::counts::{Block, Counts, Place, Shape, Slot, Spent};
use crate::diffuse::{Deposits, Laid, Reuse, Walker};
use crate::entrance::Entrance;
use crate::estimate::Counted;
use crate::generate::GenerateError;
use crate::options::{Aperture, Options};
use crate::path::{Departure, Outcome, Scene};
use crate::progress::{Progress, Resumed};
use crate::random::{N_REPLICATES, Start, Stratified};
use crate::scatter::Flux;
use crate::schedule::round_after;
use crate::tally::{Exited, Row, Tally};
use crate::tile::Tile;

/// Follows paths.
pub(crate) struct Counter<'a, D: Detector> {
    pub detector: D,
    pub scene: Scene<D::Light>,
    pub options: &'a Options,
    pub aperture: Aperture,
    pub entrance: Entrance,
    pub tile: Option<Tile>,
    pub reuse: Option<Reuse>,
    pub progress: &'a Progress,
}

/// What a thread counts in.
struct Workspace<D: Detector> {
    /// By band.
    tallies: Vec<[Tally<D::Flux>; 2]>,
    deposits: Option<[Deposits<D::Light>; 2]>,
    bytes: Vec<u8>,
}

impl<D: Detector> Counter<'_, D> {
    /// Before the first path.
    pub fn nothing(&self) -> Counts<D::Flux> {
        let n_incident = self.options.layout.n_incident();
        let empty = |n: usize| [(); 2].map(|()| vec![Row::new(); n]);
        let n_diffused = if self.reuse.is_some() { n_incident } else { 0 };
        let counted = |side| Counted { side, rows: empty(n_incident), diffused: empty(n_diffused) };
        let laid = |reuse: &Reuse| [(); 2].map(|()| [(); 2].map(|()| vec![Laid::default(); reuse.n_cells()]));
        Counts {
            counted: (0..self.detector.n_bands())
                .map(|_| self.options.sides.iter().map(counted).collect())
                .collect(),
            laid: self.reuse.as_ref().map(laid),
        }
    }

    /// Paths of all incident cells: walks from both sides and full paths from those asked for, where diffused light is reused.
    pub fn paths(&self, samples: u64) -> u64 {
        let n_sides = self.options.sides.iter().count() as u64;
        let each = match self.reuse {
            None => n_sides * samples,
            Some(_) => {
                let all = 0..samples;
                let unwanted = (2 - n_sides) * Reuse::unwanted(&all).end;
                n_sides * (samples + Reuse::paths(&all).end) + unwanted
            }
        };
        each * self.options.layout.n_incident() as u64
    }

    /// All blocks: single incident cells, or those in one cell of the model of diffused light.
    pub fn slots<'c>(&self, counts: &'c mut Counts<D::Flux>) -> Vec<Slot<'c, D::Flux>> {
        let n_incident = self.options.layout.n_incident();
        counts.slots(n_incident, self.reuse.as_ref().map_or(1, |reuse| n_incident / reuse.n_cells()))
    }

    /// Follows a round of paths from every incident cell, but for those in the file, and adds all to what was counted.
    pub fn count(
        &self,
        counts: &mut Counts<D::Flux>,
        mut file: Option<&mut RoundFile>,
        round: &Range<u64>,
    ) -> Result<Spent, GenerateError> {
        let mut slots = self.slots(counts);
        let mut done = vec![false; slots.len()];
        let mut before = Spent::default();
        if let Some(file) = file.as_deref_mut() {
            before = self.restore(file, &mut slots, &mut done, round)?;
        }
        let file = file.as_deref();
        let walker = self.reuse.as_ref().map(|reuse| self.walker(reuse));
        let workspace = || Workspace {
            tallies: (0..self.detector.n_bands())
                .map(|_| [(); 2].map(|()| Tally::new(self.options.layout.n_exitant())))
                .collect(),
            deposits: self.reuse.as_ref().map(Reuse::deposits),
            bytes: Vec::new(),
        };
        let started = Instant::now();
        let lost = slots
            .par_iter_mut()
            .enumerate()
            .filter(|(id, _)| !done[*id])
            .map_init(workspace, |workspace, (id, slot)| {
                if self.progress.is_cancelled() {
                    return Err(GenerateError::Cancelled);
                }
                let block = self.block(workspace, walker.as_ref(), &slot.place, round);
                if let Some(error) = self.scene.faults().error() {
                    return Err(GenerateError::Function(error.clone()));
                }
                if let Some(file) = file {
                    file.append(id, &block.view(), &mut workspace.bytes)?;
                }
                self.progress.add(self.paths_of(&slot.place, round));
                let lost = block.lost;
                slot.add(block, round);
                Ok(lost)
            })
            .try_reduce(|| 0, |a, b| Ok(a + b))?;
        Ok(before + Spent { lost, seconds: started.elapsed().as_secs_f64() })
    }

    /// Adds the blocks of a file, and says so if work goes on from there.
    fn restore(
        &self,
        file: &mut RoundFile,
        slots: &mut [Slot<'_, D::Flux>],
        done: &mut [bool],
        round: &Range<u64>,
    ) -> Result<Spent, GenerateError> {
        let mut spent = Spent::default();
        let mut n_paths = 0;
        let shapes: Vec<_> = slots.iter().map(|slot| self.shape(slot)).collect();
        let n_dropped = file.read(&shapes, |id, block: Block<D::Flux>| {
            if !std::mem::replace(&mut done[id], true) {
                spent = spent + Spent { lost: block.lost, seconds: block.seconds };
                n_paths += self.paths_of(&slots[id].place, round);
                slots[id].add(block, round);
            }
        })?;
        self.progress.add(n_paths);
        let n_done = done.iter().filter(|&&d| d).count();
        // Rounds that were made one cannot be counted as one.
        if n_done < done.len() && round_after(round.start, round.end) != *round {
            return Err(file.damaged().into());
        }
        let share = n_done as f64 / done.len() as f64;
        if n_done < done.len() {
            let from = Resumed { samples: round.start, round_end: round.end, share, n_dropped };
            self.progress.resume((round.start > 0 || n_done > 0 || n_dropped > 0).then_some(from));
        }
        Ok(spent)
    }

    pub fn walker<'s>(&'s self, reuse: &'s Reuse) -> Walker<'s, D::Light> {
        reuse.walker(&self.scene, self.tile.as_ref(), &self.options.layout, self.options)
    }

    fn paths_of(&self, place: &Place, round: &Range<u64>) -> u64 {
        let more = match self.reuse.is_some() && place.wanted {
            true => Reuse::paths(round).count() as u64,
            false => 0,
        };
        (walks(place, round).count() as u64 + more) * place.n_cells as u64
    }

    fn block(
        &self,
        workspace: &mut Workspace<D>,
        walker: Option<&Walker<'_, D::Light>>,
        place: &Place,
        round: &Range<u64>,
    ) -> Block<D::Flux> {
        let started = Instant::now();
        let mut block = Block::nothing();
        let Workspace { tallies, deposits, .. } = workspace;
        for cell in place.first_cell..place.first_cell + place.n_cells {
            match (walker, deposits.as_mut()) {
                (Some(walker), Some(deposits)) => {
                    // Light from a side that is not asked for is wanted only for where it is laid down.
                    let mut left = |exited| {
                        if place.wanted {
                            self.tally(tallies, exited);
                        }
                    };
                    let walks = walks(place, round);
                    block.lost += walker.count_walks(place.side, cell, &walks, &mut left, deposits);
                    if place.wanted {
                        drain(&mut block.rows, tallies);
                        let mut left = |exited| self.tally(tallies, exited);
                        block.lost += walker.count_diffused(place.side, cell, round, &mut left);
                        drain(&mut block.diffused, tallies);
                    }
                }
                _ => {
                    block.lost += self.count_cell(place.side, cell, round.clone(), tallies);
                    drain(&mut block.rows, tallies);
                }
            }
        }
        block.laid = deposits.as_mut().map(|halves| halves.each_mut().map(Deposits::drain));
        block.seconds = started.elapsed().as_secs_f64() / rayon::current_num_threads() as f64;
        block
    }

    fn count_cell(
        &self,
        side: Side,
        cell: usize,
        round: Range<u64>,
        tallies: &mut [[Tally<D::Flux>; 2]],
    ) -> u64 {
        let Options { layout, seed, stratified, .. } = self.options;
        let stream = (cell as u64) << 1 | u64::from(side == Side::Back);
        let mut points = Stratified::new(*seed, stream);
        let departures = round.map(|sample| {
            let Start { incident: [u, v], origin, random } = match stratified {
                true => points.start(*seed, stream, sample),
                false => Start::independent(*seed, stream, sample),
            };
            let disk = layout.incident_disk(cell, u, v);
            let direction = DVec3::from_array(side.opposite().direction_from_disk(disk));
            let ray = self.entrance.through_aperture(side, direction, origin);
            let replicate = (sample % N_REPLICATES as u64) as usize;
            Departure { origin: ray.origin, direction, random, tag: (disk, replicate) }
        });
        let mut lost = 0;
        self.scene.follow_all(departures, self.tile.as_ref(), |(disk, replicate), outcome| match outcome {
            Outcome::Left(exitant, weight) => {
                let transmitted = Side::of(exitant.to_array()) != side;
                let cell = layout.exitant_cell(disk, [exitant.x, exitant.y]);
                self.tally(tallies, Exited { transmitted, cell, weight, replicate });
            }
            Outcome::Absorbed => {}
            Outcome::Lost => lost += 1,
        });
        lost
    }

    /// Counts a path in every band.
    #[inline(always)]
    fn tally(&self, tallies: &mut [[Tally<D::Flux>; 2]], exited: Exited<D::Light>) {
        let Exited { transmitted, cell, weight, replicate } = exited;
        for (band, tallies) in tallies.iter_mut().enumerate() {
            tallies[usize::from(transmitted)].add(cell, self.detector.detect(&weight, band), replicate);
        }
    }

    /// What a block of a slot must have.
    fn shape(&self, slot: &Slot<'_, D::Flux>) -> Shape {
        Shape {
            n_bands: slot.rows.len(),
            n_rows: slot.rows.first().map_or(0, |band| band[0].len()),
            n_diffused: slot.diffused.first().map_or(0, |band| band[0].len()),
            n_laid: self.reuse.as_ref().map(|reuse| D::Light::CHANNELS * reuse.n_sites()),
            n_exitant: self.options.layout.n_exitant(),
        }
    }
}

/// Walks of a round from each cell of a block.
fn walks(place: &Place, round: &Range<u64>) -> Range<u64> {
    if place.wanted { round.clone() } else { Reuse::unwanted(round) }
}

/// Moves counts to rows of their own.
fn drain<F: Flux>(rows: &mut Vec<[Vec<Row<F>>; 2]>, tallies: &mut [[Tally<F>; 2]]) {
    rows.resize_with(tallies.len(), Default::default);
    for (rows, tally) in rows.iter_mut().flatten().zip(tallies.iter_mut().flatten()) {
        rows.push(tally.drain());
    }
}
