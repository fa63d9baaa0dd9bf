// Polar maps: the exitant hemispheres as disks of (x, y), so that equal areas are equal projected solid angles; both sides seen from the
// room. In: the state. Out: pictures, and the direction under the pointer or the keyboard's cursor.

import type { Direction } from "./core";
import { Disk } from "./disk";
import { make } from "./dom";
import { Legend } from "./legend";
import { isFinerThan, peak, picture } from "./picture";
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
    const isFine = !state.moving && isFinerThan(n, file, band);
    const pictures = fronts.map((front) => picture(file, band, incident, front, n, isFine));
    const largest = pictures.map(peak);
    const scale = Scale.of(state, Math.max(...largest));
    this.disks.forEach((disk, k) => {
      const front = fronts[k]!;
      const edges = state.edges && !state.moving ? file.edges(band, incident, front, n) : null;
      const image = natural ? new ImageData(new Uint8ClampedArray(file.colours(band, incident, front, n, scale)), n) : scale.paint(pictures[k]!);
      disk.draw(front, image, edges, largest[k] === 0);
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
