// The legend of a view: its colours, ticks with values in 1/sr, and a switch that holds the scale while the incident direction moves.

import { make } from "./dom";
import { type Scale, short, VIRIDIS_PIXELS } from "./scale";
import type { State } from "./state";
import type { Set } from "./view";

export class Legend {
  readonly element = make("div", { className: "legend" });
  private readonly bar = make("canvas", { width: 256, height: 1 });
  private readonly ticks = make("div", { className: "ticks" });
  private readonly hold = make("input", { type: "checkbox" });
  private scale: Scale | null = null;

  constructor(set: Set) {
    const label = make("label", { title: "keep this scale while directions, bands and files change" }, this.hold, " hold scale");
    this.element.append(make("div", { className: "bar" }, this.bar, this.ticks), make("span", { className: "unit" }, "sr⁻¹"), label);
    this.bar.getContext("2d")!.putImageData(new ImageData(new Uint8ClampedArray(VIRIDIS_PIXELS.buffer.slice(0)), 256), 0, 0);
    this.hold.addEventListener("change", () => set({ held: this.hold.checked ? (this.scale?.highest ?? null) : null }));
  }

  draw(state: State, scale: Scale): void {
    this.scale = scale;
    this.hold.checked = state.held !== null;
    // The highest is always told; round ones where they do not touch it.
    const rounds = scale.ticks().filter((tick) => scale.place(tick) < 0.86);
    this.ticks.replaceChildren(...[...rounds, scale.highest].map((value) => tick(scale, value)));
  }
}

function tick(scale: Scale, value: number): HTMLElement {
  const element = make("span", {}, short(value));
  element.style.left = `${100 * scale.place(value)}%`;
  return element;
}
