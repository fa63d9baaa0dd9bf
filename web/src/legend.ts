// The legend of a view: its colours, ticks with values in 1/sr, and a switch that holds the scale while the incident direction moves.

import { make } from "./dom";
import { type Scale, short, VIRIDIS_PIXELS } from "./scale";
import type { State } from "./state";
import type { Set } from "./view";

export class Legend {
  readonly element = make("div", { className: "legend" });
  private readonly bar = make("canvas", { width: 256, height: 1 });
  private readonly ticks = make("div", { className: "ticks" });
  private readonly hold: HoldSwitch;
  private drawn = "";

  constructor(set: Set) {
    this.hold = new HoldSwitch(set);
    this.element.append(make("div", { className: "bar" }, this.bar, this.ticks), make("span", { className: "unit" }, "sr⁻¹"), this.hold.element);
  }

  draw(state: State, scale: Scale): void {
    this.hold.draw(state, scale);
    // Elements cost more than the frame that they are in.
    const drawn = `${scale.decades} ${scale.highest} ${state.natural}`;
    if (drawn === this.drawn) return;
    this.drawn = drawn;
    const greys = VIRIDIS_PIXELS.map((_, k) => 0xff000000 | (0x10101 * Math.round(255 * (k / 255) ** (1 / 2.2))));
    const pixels = state.natural ? greys : VIRIDIS_PIXELS.slice();
    this.bar.getContext("2d")!.putImageData(new ImageData(new Uint8ClampedArray(pixels.buffer), 256), 0, 0);
    // The highest is always told; round ones where they do not touch it.
    const rounds = scale.ticks().filter((tick) => scale.place(tick) < 0.86);
    this.ticks.replaceChildren(...[...rounds, scale.highest].map((value) => tick(scale, value)));
  }
}

/** A switch that holds the scale while directions, bands and files change. */
export class HoldSwitch {
  readonly element: HTMLElement;
  private readonly input = make("input", { type: "checkbox" });
  private scale: Scale | null = null;

  constructor(set: Set) {
    this.element = make("label", { title: "keep this scale while directions, bands and files change" }, this.input, " hold scale");
    this.input.addEventListener("change", () => set({ held: this.input.checked ? (this.scale?.highest ?? null) : null }));
  }

  draw(state: State, scale: Scale): void {
    this.scale = scale;
    this.input.checked = state.held !== null;
  }
}

function tick(scale: Scale, value: number): HTMLElement {
  const element = make("span", {}, short(value));
  element.style.left = `${100 * scale.place(value)}%`;
  return element;
}
