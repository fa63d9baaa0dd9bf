// A colour bar: 256 colours with labels under it, for what is no value of a BSDF and has no legend of its own.

import { make } from "./dom";

export class Bar {
  readonly element = make("div", { className: "legend" });
  private readonly canvas = make("canvas", { width: 256, height: 1 });
  private readonly ticks = make("div", { className: "ticks" });
  private readonly unit = make("span", { className: "unit" });

  constructor() {
    this.element.append(make("div", { className: "bar" }, this.canvas, this.ticks), this.unit);
  }

  /** Labels at places between 0 and 1. */
  draw(colours: Uint32Array, labels: readonly (readonly [number, string])[], unit: string): void {
    this.canvas.getContext("2d")!.putImageData(new ImageData(new Uint8ClampedArray(colours.slice().buffer), 256), 0, 0);
    this.unit.textContent = unit;
    this.ticks.replaceChildren(
      ...labels.map(([place, label]) => {
        const element = make("span", {}, label);
        element.style.left = `${100 * place}%`;
        return element;
      }),
    );
  }
}
