// Depths of cells as colours: how often the square was halved along each axis until a leaf was reached, of matrices what makes patches of that size. In: depths. Out:
// pixels and labels.

import { VIRIDIS_PIXELS } from "./scale";

export class DepthScale {
  /** From 0 to `deepest`. */
  constructor(readonly deepest: number) {}

  /** The deepest of some pictures; NaN is none. */
  static of(...pictures: Float32Array[]): DepthScale {
    const deepest = pictures.map((depths) => depths.reduce((most, depth) => (depth > most ? depth : most), 0));
    return new DepthScale(Math.max(1, Math.ceil(Math.max(...deepest) - 1e-6)));
  }

  paint(depths: Float32Array, width = Math.round(Math.sqrt(depths.length))): ImageData {
    const pixels = new Uint32Array(depths.length);
    for (let k = 0; k < depths.length; k++) {
      const depth = depths[k]!;
      if (!Number.isNaN(depth)) pixels[k] = VIRIDIS_PIXELS[Math.min(255, Math.round((255 * depth) / this.deepest))]!;
    }
    return new ImageData(new Uint8ClampedArray(pixels.buffer), width);
  }

  labels(): [number, string][] {
    const step = this.deepest > 10 ? 2 : 1;
    return Array.from({ length: Math.floor(this.deepest / step) + 1 }, (_, k) => [(k * step) / this.deepest, `2${superscript(k * step)}`]);
  }
}

/** A whole number as an exponent. */
export function superscript(n: number): string {
  return [...String(n)].map((digit) => "⁰¹²³⁴⁵⁶⁷⁸⁹"[Number(digit)]).join("");
}
