// Polar maps: the exitant hemispheres as disks of (x, y), so that equal areas are equal projected solid angles; both sides seen from the
// room. In: the state. Out: pictures, and the direction under the pointer or the keyboard's cursor.

import type { Direction } from "./core";
import { Disk } from "./disk";
import { make } from "./dom";
import { Legend } from "./legend";
import { Scale } from "./scale";
import { showsTheSame, type State } from "./state";
import type { Set, View } from "./view";

/** Pixels across while the incident direction moves, and at most while it does not. */
const COARSE = 200;
const FINEST = 900;

export class PolarMaps implements View {
  readonly name = "Polar maps";
  readonly element = make("section");
  private readonly disks: readonly [Disk, Disk];
  private readonly legend: Legend;
  private drawn: State | null = null;
  private n = 0;

  constructor(set: Set) {
    const pointed = (pointedAt: Direction | null): void => set({ pointedAt });
    this.disks = [new Disk("reflection", pointed, "reflection"), new Disk("transmission", pointed, "transmission")];
    this.legend = new Legend(set);
    this.element.append(make("div", { className: "maps" }, ...this.disks.map(({ element }) => element)), this.legend.element);
    new ResizeObserver(() => this.drawn && !this.element.hidden && this.draw(this.drawn)).observe(this.element);
  }

  draw(state: State): void {
    // As many pixels as the screen has there.
    const n = state.moving ? COARSE : Math.min(FINEST, Math.round(this.disks[0].width * window.devicePixelRatio) || COARSE);
    if (n !== this.n || !showsTheSame(this.drawn, state)) this.paint(state, n);
    this.drawn = state;
    this.n = n;
    this.disks.forEach((disk) => disk.point(state));
  }

  private paint(state: State, n: number): void {
    const { incident, natural } = state;
    const fronts = [incident[2] > 0, incident[2] <= 0] as const;
    const file = state.first!;
    const band = file.band(state.band);
    // Leaves that are finer than pixels would be missed.
    const isFine = !state.moving && finest(state) > n / 2;
    const pictures = fronts.map((front) => (isFine ? largestOfFour(file.hemisphere(band, incident, front, 2 * n), n) : file.hemisphere(band, incident, front, n)));
    // NaN is never larger.
    const largest = pictures.map((values) => values.reduce((most, value) => (value > most ? value : most), 0));
    const scale = Scale.of(state, Math.max(...largest));
    this.disks.forEach((disk, k) => {
      const front = fronts[k]!;
      const edges = state.edges && !state.moving ? file.edges(band, incident, front, n) : null;
      const picture = natural ? new ImageData(new Uint8ClampedArray(file.colours(band, incident, front, n, scale)), n) : scale.paint(pictures[k]!);
      disk.draw(front, picture, edges, largest[k] === 0);
      disk.ring(needle(pictures[k]!, largest[k]!), n);
    });
    this.legend.draw(state, scale);
  }
}

/** The pixel of the largest value, if it and its like are too few to be seen; else −1. */
function needle(values: Float32Array, largest: number): number {
  let n = 0;
  for (const value of values) if (value > largest / 2) n++;
  return largest > 0 && n < values.length / 2000 ? values.indexOf(largest) : -1;
}

/** Cells along an edge of the finest tree, 0 of matrices. */
function finest({ first, band }: State): number {
  const components = first!.summary.bands.find(({ name }) => name === band)?.components ?? [];
  return Math.max(0, ...components.map(({ form }) => (form.log2_res === undefined ? 0 : 2 ** form.log2_res)));
}

/** Half as large a picture, n × n, without losing what is narrow. */
function largestOfFour(values: Float32Array, n: number): Float32Array {
  const picture = new Float32Array(n * n);
  for (let row = 0; row < n; row++) {
    for (let column = 0; column < n; column++) {
      const corner = 4 * row * n + 2 * column;
      let most = NaN;
      for (const k of [corner, corner + 1, corner + 2 * n, corner + 2 * n + 1]) if (!(values[k]! <= most)) most = Number.isNaN(values[k]!) ? most : values[k]!;
      picture[row * n + column] = most;
    }
  }
  return picture;
}
