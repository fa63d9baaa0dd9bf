// The tree itself: how fine its cells are for the present incident direction, and how many, with what light and which values. Of matrices the same for patches. In: the
// state. Out: maps of depth, bars, sizes, and the exitant direction under the pointer.

import { Bar } from "./bar";
import { Bars } from "./bars";
import type { Component, Direction, ErrorByFlux, Opened, Statistics } from "./core";
import { DepthScale, superscript } from "./depth";
import { Disk } from "./disk";
import { make } from "./dom";
import { VIRIDIS_PIXELS } from "./scale";
import { showsTheSame, type State } from "./state";
import type { Set, View } from "./view";

const FINE = 400;
const COARSE = 200;

export class TreeView implements View {
  readonly name = "Tree";
  readonly element = make("section", { id: "tree" });
  private readonly disks: [Disk, Disk];
  private readonly bar = new Bar();
  private readonly facts = make("dl");
  private readonly title = make("h2");
  private readonly charts = [new Bars(), new Bars(), new Bars()] as const;
  private drawn: State | null = null;
  private known = { file: null as Opened | null, band: -1, part: "", hasErrors: false };

  constructor(set: Set) {
    const pointed = (pointedAt: Direction | null): void => set({ pointedAt });
    this.disks = [new Disk("reflection", pointed), new Disk("transmission", pointed)];
    const maps = make("div", { className: "maps" }, ...this.disks.map(({ element }) => element));
    const now = make("div", { className: "now" }, make("h2", {}, "How fine cells are for this incident direction"), maps, this.bar.element);
    const all = make("div", { className: "all" }, this.title, this.facts, ...this.charts.map(({ element }) => element));
    this.element.append(now, all);
  }

  draw(state: State): void {
    const file = state.first!;
    const band = file.band(state.band);
    if (!showsTheSame(this.drawn, state)) this.paint(file, band, state);
    this.drawn = state;
    this.disks.forEach((disk) => disk.point(state));
    const { hasErrors } = file;
    const { known } = this;
    if (known.file === file && known.band === band && known.part === state.part && known.hasErrors === hasErrors) return;
    this.known = { file, band, part: state.part, hasErrors };
    const component = file.summary.bands[band]!.components.find(({ part }) => part === state.part)!;
    this.divide(file, component, file.statistics(band, state.part), hasErrors ? file.errorsByFlux(band) : []);
  }

  /** The maps of depth. */
  private paint(file: Opened, band: number, { incident, moving }: State): void {
    const n = moving ? COARSE : FINE;
    const fronts = [incident[2] > 0, incident[2] <= 0] as const;
    const pictures = fronts.map((front) => file.depths(band, incident, front, n));
    // The same for all directions.
    const deepest = Math.max(0, ...file.summary.bands[band]!.components.map(({ form }) => form.log2_res ?? 0));
    const scale = deepest > 0 ? new DepthScale(deepest) : DepthScale.of(...pictures);
    const areBlack = pictures.map((picture) => picture.every((depth) => Number.isNaN(depth)));
    this.disks.forEach((disk, k) => {
      // One without cells is left out, unless there are none at all.
      disk.element.hidden = areBlack[k]! && (!areBlack[1 - k] || k === 1);
      disk.draw(fronts[k]!, scale.paint(pictures[k]!), null, areBlack[k]!);
      disk.ring(-1, n);
    });
    this.bar.draw(VIRIDIS_PIXELS, scale.labels(), "cells along each axis");
  }

  private divide(file: Opened, component: Component, statistics: Statistics, errors: ErrorByFlux[]): void {
    this.title.textContent = component.part.replace("_", " ").replace(/^./, (letter) => letter.toUpperCase());
    const known = errors.find(({ part }) => part === component.part);
    const facts = [...shapeOf(component), ["memory", bytes(component.n_bytes)], ["file", bytes(file.size)], ...(known ? errorsTold(known) : [])];
    this.facts.replaceChildren(...facts.flatMap(([term, text]) => [make("dt", {}, term!), make("dd", {}, text!)]));
    const { groups, histogram, kind } = statistics;
    const isTree = kind === "depth";
    const labels = groups.map(({ label }) => (isTree ? label.replace(/\^(\d+)/, (_, depth) => superscript(Number(depth))) : label));
    const x = isTree ? "cells along each axis" : "exitant ring, polar angle";
    const [counts, shares, values] = this.charts;
    const what = isTree ? "leaves" : "pairs of patches";
    counts.draw({ title: isTree ? "Leaves" : "Pairs of patches", series: [{ name: what, kind: "cells", values: groups.map((g) => g.n_cells) }], labels, x, isLog: true });
    shares.draw({
      title: "Shares",
      series: [
        { name: "of pairs of directions", kind: "directions", values: groups.map(({ share }) => share) },
        { name: "of scattered light", kind: "light", values: groups.map(({ light }) => light) },
      ],
      labels,
      x,
      isLog: false,
    });
    const all = component.n_values;
    const black = histogram.black > 5e-4 ? `; ${(100 * histogram.black).toFixed(1)} % of ${what} are 0` : "";
    values.draw({
      title: "Values",
      series: [
        { name: `of ${what}`, kind: "cells", values: histogram.n_cells.map((count) => count / all) },
        { name: "of scattered light", kind: "light", values: histogram.light },
      ],
      labels: histogram.n_cells.concat(0).map((_, k) => (k % BINS === 0 ? power(histogram.first_decade + k / BINS) : "")),
      x: `BSDF [sr⁻¹]${black}`,
      isLog: false,
    });
  }
}

/** Columns of the histogram for each decade. */
const BINS = 8;

function power(decade: number): string {
  return decade >= 0 && decade < 4 ? String(10 ** decade) : `10${decade < 0 ? "⁻" : ""}${superscript(Math.abs(decade))}`;
}

function shapeOf({ form }: Component): [string, string][] {
  if (form.rank === undefined) return [["matrix", `${form.incident_basis}, ${form.n_incident} × ${form.n_exitant}`]];
  const uniform = 2 ** (form.rank * form.log2_res!);
  return [
    ["tree", `rank ${form.rank}, finest 2${superscript(form.log2_res!)} along each axis`],
    ["leaves", `${form.n_leaves!.toLocaleString("en")}, 1 for ${Number((uniform / form.n_leaves!).toPrecision(3)).toLocaleString("en")} cells of the uniform grid`],
  ];
}

function errorsTold({ mean, uncertain }: ErrorByFlux): [string, string][] {
  return [["standard error", `${(100 * mean).toPrecision(3)} % by light; over 25 % for ${(100 * uncertain).toPrecision(3)} % of the light`]];
}

function bytes(n: number): string {
  const [unit, name] = n >= 1e6 ? [1e6, "MB"] : n >= 1e3 ? [1e3, "kB"] : [1, "bytes"];
  return `${Number((n / unit).toPrecision(3))} ${name}`;
}
