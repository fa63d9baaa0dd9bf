// The slice: values in the plane of the incident direction and the normal, over the exitant angle. In: the state. Out: curves, and the exitant
// direction under the cursor. Positive angles are on the side that mirrored and straight light goes to.

import type { Direction } from "./core";
import { inPlane, toPolar } from "./directions";
import { make } from "./dom";
import { HoldSwitch } from "./legend";
import { type Curve, Plot } from "./plot";
import { Scale, short } from "./scale";
import { showsTheSame, type State } from "./state";
import type { Set, View } from "./view";

/** Samples over 180°: the finest that the core gives, less than a leaf of 2⁻¹⁰. */
const SAMPLES = 2048;

export class Slice implements View {
  readonly name = "Slice";
  readonly element = make("section", { id: "slice" });
  private readonly plot: Plot;
  private readonly hold: HoldSwitch;
  private drawn: State | null = null;
  private incident: Direction = [0, 0, 1];

  constructor(set: Set) {
    const axes = { x: "exitant angle from the normal, in the plane of incidence", y: "BSDF [sr⁻¹]", from: -90, to: 90, step: 15 };
    this.plot = new Plot(axes, (at) => set({ pointedAt: at && inPlane(this.incident, at.x, this.incident[2] > 0 === (at.curve % 2 === 0)) }));
    this.hold = new HoldSwitch(set);
    this.element.append(this.plot.element, make("p", { className: "controls" }, this.hold.element));
  }

  draw(state: State): void {
    const isDrawn = showsTheSame(this.drawn, state);
    this.drawn = state;
    if (isDrawn) return;
    this.incident = state.incident;
    const curves = [state.first, state.compared].filter((file) => file !== null).flatMap((file, k) =>
      ["reflected", "transmitted"].map((verb, lobe): Curve => {
        const front = state.incident[2] > 0 === (lobe === 0);
        const where = front ? "into the room" : "to outside";
        const values = file.slice(file.band(state.band), state.incident, front, SAMPLES);
        return { label: k === 0 ? `${verb}, ${where}` : "", kind: `${verb}${k === 0 ? "" : " compared"}`, values };
      }),
    );
    const scale = Scale.of(state, Math.max(...curves.map(({ values }) => values.reduce((most, value) => Math.max(most, value), 0))));
    const { thetaDeg } = toPolar(state.incident);
    const near = thetaDeg < 6;
    this.plot.draw({
      curves,
      place: (value) => scale.place(value),
      ticks: [...scale.ticks().filter((tick) => scale.place(tick) < 0.95), scale.highest].map((value) => ({ value, text: short(value) })),
      compared: state.compared?.name ?? null,
      marks: near
        ? [{ x: thetaDeg, text: "incident, mirrored and straight" }]
        : [{ x: -thetaDeg, text: "incident" }, { x: thetaDeg, text: "mirrored, straight" }],
    });
    this.hold.draw(state, scale);
  }
}
