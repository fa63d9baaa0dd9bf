// Two files beside each other for one incident direction: both on one scale, their difference, their ratio, and a table of how far components are apart, which the core
// counts. In: the state. Out: pictures, and the exitant direction under the pointer. In the table "light" is a share of evenly diffuse light.

import { Bar } from "./bar";
import type { Difference, Direction, Opened } from "./core";
import { difference, differenceScale, DIVERGING_PIXELS, paint, RATIO, ratio } from "./difference";
import { Disk } from "./disk";
import { make } from "./dom";
import { Legend } from "./legend";
import { isFinerThan, largestOfFour, peak } from "./picture";
import { Scale } from "./scale";
import { showsTheSame, type State } from "./state";
import type { Set, View } from "./view";

const FINE = 320;
const COARSE = 160;
const HEAD = ["component", "relative L1", "light, A", "light, B", "B − A", "RMS of totals", "largest B − A of one direction"];

export class Compare implements View {
  readonly name = "Compare";
  readonly element = make("section", { id: "compare" });
  private readonly rows: readonly [Row, Row];
  private readonly names = make("div", { className: "four names" });
  private readonly legend: Legend;
  private readonly bars = [new Bar(), new Bar()] as const;
  private readonly table = make("table");
  private readonly shown = make("div", { className: "shown" });
  private readonly without = make("p", { className: "hint" });
  private drawn: State | null = null;
  private known = { one: null as Opened | null, other: null as Opened | null, band: "" };

  constructor(set: Set) {
    const pointed = (pointedAt: Direction | null): void => set({ pointedAt });
    this.rows = [new Row("reflection", pointed), new Row("transmission", pointed)];
    this.legend = new Legend(set);
    const legends = make("div", { className: "four legends" }, this.legend.element, ...this.bars.map(({ element }) => element));
    this.shown.append(this.names, ...this.rows.map(({ element }) => element), legends, this.table);
    this.element.append(this.without, this.shown);
  }

  draw(state: State): void {
    const { first, compared } = state;
    const one = first!;
    const missing = !compared || compared.band(state.band) < 0;
    this.without.hidden = !missing;
    this.shown.hidden = missing;
    if (missing) {
      this.without.textContent = compared
        ? `${compared.name} has no band ${state.band}; choose another band or file.`
        : "Open a second file, or choose one under “beside”, to see both at one incident direction with their difference and ratio: a tree and a Klems matrix of one device, or a tree before and after it was reduced.";
      return;
    }
    if (!showsTheSame(this.drawn, state)) this.paint(one, compared, state);
    this.drawn = state;
    this.rows.forEach((row) => row.point(state));
    if (!state.moving) this.count(one, compared, state.band);
  }

  private paint(one: Opened, other: Opened, state: State): void {
    const n = state.moving ? COARSE : FINE;
    const fronts = [state.incident[2] > 0, state.incident[2] <= 0];
    // Both as finely as the finer one, so that what is compared lies at the same places.
    const isFine = !state.moving && [one, other].some((file) => isFinerThan(n, file, file.band(state.band)));
    const places = isFine ? 2 * n : n;
    const values = (file: Opened, front: boolean): Float32Array => file.hemisphere(file.band(state.band), state.incident, front, places);
    const drawn = (values: Float32Array): Float32Array => (isFine ? largestOfFour(values, n) : values);
    const samples = fronts.map((front) => [values(one, front), values(other, front)] as const);
    const pictures = samples.map(([a, b]) => [drawn(a), drawn(b)] as const);
    const largest = pictures.map((pair) => Math.max(...pair.map(peak)));
    const scale = Scale.of(state, Math.max(...largest));
    const apart = samples.map(([a, b]) => drawn(difference(a, b)));
    const most = Math.max(...apart.map((values) => peak(values.map(Math.abs))));
    const differences = differenceScale(state.decades / 2, most || scale.highest);
    this.names.replaceChildren(...[`A: ${one.name}`, `B: ${other.name}`, "difference B − A", "ratio B / A"].map((text) => make("span", { title: text }, text)));
    this.rows.forEach((row, k) => {
      // One without light is left out, unless there is none at all.
      row.element.hidden = largest[k] === 0 && (largest[1 - k]! > 0 || k === 1);
      const [a, b] = pictures[k]!;
      row.draw(fronts[k]!, [scale.paint(a), scale.paint(b), paint(apart[k]!, differences, false), paint(ratio(a, b), RATIO, true)], largest[k] === 0);
    });
    this.legend.draw({ ...state, natural: false }, scale);
    this.bars[0].draw(DIVERGING_PIXELS, differences.labels, state.decades > 0 ? "sr⁻¹, log" : "sr⁻¹");
    this.bars[1].draw(DIVERGING_PIXELS, RATIO.labels, "log");
  }

  /** Fills the table, once for each pair of files. */
  private count(one: Opened, other: Opened, band: string): void {
    const { known } = this;
    if (known.one === one && known.other === other && known.band === band) return;
    const asked = (this.known = { one, other, band });
    const progress = make("td", { colSpan: HEAD.length }, "counting …");
    this.table.replaceChildren(rowOf(HEAD, "th"), make("tr", {}, progress));
    const told = (done: number): boolean => {
      progress.textContent = `counting … ${Math.round(100 * done)} %`;
      return this.known === asked;
    };
    // After the pictures are on the screen.
    setTimeout(() => {
      void one.differences(other, one.band(band), told).then((found) => {
        if (this.known === asked) this.table.replaceChildren(rowOf(HEAD, "th"), ...found.map(rowFor));
      });
    }, 60);
  }
}

/** Both files, their difference and ratio for one side that light goes to. */
class Row {
  readonly element = make("div", { className: "four disks" });
  private readonly disks: readonly Disk[];

  constructor(kind: "reflection" | "transmission", pointed: (exitant: Direction | null) => void) {
    this.disks = [1, 2, 3, 4].map(() => new Disk(kind, pointed));
    this.element.append(...this.disks.map(({ element }) => element));
  }

  draw(front: boolean, images: readonly ImageData[], isBlack: boolean): void {
    this.disks.forEach((disk, k) => {
      disk.draw(front, images[k]!, null, isBlack);
      disk.ring(-1, 1);
    });
  }

  point(state: State): void {
    this.disks.forEach((disk) => disk.point(state));
  }
}

function rowOf(texts: readonly string[], tag: "th" | "td"): HTMLElement {
  return make("tr", {}, ...texts.map((text) => make(tag, {}, text)));
}

function rowFor(found: Difference): HTMLElement {
  const { part, relative_l1, totals, rms_total, worst_total, worst_theta_deg, worst_phi_deg } = found;
  const percent = (share: number): string => `${(100 * share).toFixed(3)} %`;
  const apart = (share: number): string => `${share < 0 ? "−" : "+"}${percent(Math.abs(share))}`;
  const row = rowOf(
    [
      part.replace("_", " "),
      relative_l1 === null ? "–" : `${(100 * relative_l1).toFixed(2)} %`,
      ...totals.map(percent),
      apart(totals[1] - totals[0]),
      percent(rms_total),
      `${apart(worst_total)} from θ ${worst_theta_deg}°, φ ${worst_phi_deg}°`,
    ],
    "td",
  );
  // In full, for whoever tests it.
  row.dataset["found"] = JSON.stringify(found);
  return row;
}
