// Totals: the share of light that is reflected and transmitted into all directions, over the angle of incidence, at the present azimuth; a plot
// for each side that light comes from. In: the state. Out: curves, and another angle of incidence when they are clicked or dragged.

import type { Opened } from "./core";
import { fromPolar, MOST_THETA_DEG, toPolar } from "./directions";
import { make } from "./dom";
import { type Curve, type Figure, Plot } from "./plot";
import type { State } from "./state";
import type { Set, View } from "./view";

/** Angles from 0° to 90°, while still and while the incident direction moves. */
const FINE = 90;
const COARSE = 30;
const TICKS = [0, 0.2, 0.4, 0.6, 0.8, 1].map((value) => ({ value, text: String(value) }));

export class Totals implements View {
  readonly name = "Totals";
  readonly element = make("section", { id: "totals" });
  private readonly plots: readonly [TotalsOfSide, TotalsOfSide];

  constructor(set: Set) {
    this.plots = [new TotalsOfSide(true, set), new TotalsOfSide(false, set)];
    this.element.append(make("div", { className: "maps" }, ...this.plots.map(({ element }) => element)));
  }

  draw(state: State): void {
    this.plots.forEach((plot) => plot.draw(state));
  }
}

class TotalsOfSide {
  readonly element: HTMLElement;
  private readonly told = make("p", { className: "told" });
  private readonly plot: Plot;
  private figure: Figure | null = null;
  private phiDeg = 0;
  private known = { file: null as Opened | null, compared: null as Opened | null, band: "", phiDeg: NaN, n: 0 };
  private at: number | null = null;
  private present = 0;

  constructor(
    private readonly front: boolean,
    set: Set,
  ) {
    const axes = { x: "angle of incidence", y: "share of light", from: 0, to: 90, step: 15 };
    this.plot = new Plot(
      axes,
      (at) => {
        this.at = at?.x ?? null;
        this.tell();
      },
      (x, moving) => set({ incident: fromPolar(Math.min(x, MOST_THETA_DEG), this.phiDeg, front), moving }),
    );
    this.element = make("figure", {}, make("figcaption", {}, `light from ${front ? "the room (+Z)" : "outside (−Z)"}`), this.plot.element, this.told);
  }

  draw(state: State): void {
    const { thetaDeg, phiDeg } = toPolar(state.incident);
    this.phiDeg = phiDeg;
    const curves = this.curves(state, phiDeg);
    const most = Math.max(1, ...curves.map(({ values }) => Math.max(...values)));
    const isPresent = state.incident[2] > 0 === this.front;
    this.figure = {
      curves,
      place: (value) => Math.min(1, Math.max(0, value / most)),
      ticks: TICKS,
      compared: state.compared?.name ?? null,
      marks: isPresent ? [{ x: thetaDeg, text: `${thetaDeg.toFixed(1)}°` }] : [],
    };
    this.plot.draw(this.figure);
    this.present = thetaDeg;
    this.tell();
  }

  /** They depend on the azimuth alone, and stay as they are while it does. */
  private curves(state: State, phiDeg: number): readonly Curve[] {
    const { first, compared, band, moving } = state;
    const n = moving ? COARSE : FINE;
    const { known } = this;
    const same = known.file === first && known.compared === compared && known.band === band && known.phiDeg === phiDeg && known.n >= n;
    if (same && this.figure) return this.figure.curves;
    this.known = { file: first, compared, band, phiDeg, n };
    return [first, compared].filter((file) => file !== null).flatMap((file, k) => {
      const totals = file.totals(file.band(band), this.front, (phiDeg * Math.PI) / 180, n);
      const [reflected, transmitted] = [totals.slice(0, n), totals.slice(n)];
      const both = reflected.map((share, l) => share + (transmitted[l] ?? 0));
      return k === 0
        ? Object.entries({ reflected, transmitted, both }).map(([verb, values]) => ({ label: verb, kind: verb, values }))
        : Object.entries({ reflected, transmitted }).map(([verb, values]) => ({ label: "", kind: `${verb} compared`, values }));
    });
  }

  /** The shares at the cursor, else at the incident angle. */
  private tell(): void {
    if (!this.figure) return;
    const x = this.at ?? this.present;
    const at = (values: Float32Array): string => (values[Math.min(values.length - 1, Math.floor((x / 90) * values.length))] ?? 0).toFixed(4);
    const told = (curves: readonly Curve[]): string => curves.map(({ kind, values }) => `${kind.split(" ")[0]} ${at(values)}`).join(", ");
    const { curves, compared } = this.figure;
    const first = `θ ${x.toFixed(1)}°: ${told(curves.slice(0, 3))}`;
    this.told.textContent = compared === null ? first : `${first}\n${compared}: ${told(curves.slice(3))}`;
  }
}
