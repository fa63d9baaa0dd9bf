// Values to places between 0 and 1, and those to colours: a scale is logarithmic over some decades below its highest value, or linear from 0. Colours are
// matplotlib's viridis, which is even in lightness and safe for colour-blind eyes: nine of its colours, straight lines between.

import type { State } from "./state";

const VIRIDIS = [0x440154, 0x472d7b, 0x3b528b, 0x2c728e, 0x21918c, 0x28ae80, 0x5ec962, 0xaddc30, 0xfde725];

/** 256 pixels of RGBA, little-endian, from some colours and straight lines between. */
export function pixelsOf(colours: readonly number[]): Uint32Array {
  return Uint32Array.from({ length: 256 }, (_, k) => {
    const place = (k / 255) * (colours.length - 1);
    const below = Math.min(Math.floor(place), colours.length - 2);
    const channel = (shift: number): number => {
      const [a, b] = [colours[below]! >> shift, colours[below + 1]! >> shift].map((c) => c & 255) as [number, number];
      return Math.round(a + (b - a) * (place - below));
    };
    return (255 << 24) | (channel(0) << 16) | (channel(8) << 8) | channel(16);
  });
}

export const VIRIDIS_PIXELS = pixelsOf(VIRIDIS);

export class Scale {
  /** Up to `highest` [1/sr], which is positive, over `decades` powers of ten; none: linear. */
  constructor(
    readonly highest: number,
    readonly decades: number,
  ) {}

  /** The scale of a view whose largest value is `largest`, unless the user holds another. */
  static of({ decades, held }: State, largest: number): Scale {
    return new Scale(held ?? (largest > 0 && Number.isFinite(largest) ? largest : 1), decades);
  }

  /** The smallest value that is told from 0. */
  get lowest(): number {
    return this.decades > 0 ? this.highest / 10 ** this.decades : 0;
  }

  /** Where a value lies, 0 to 1. */
  place(value: number): number {
    if (!(value > this.lowest)) return 0;
    const place = this.decades > 0 ? 1 + Math.log10(value / this.highest) / this.decades : value / this.highest;
    return Math.min(1, place);
  }

  /** The value at a place. */
  value(place: number): number {
    return this.decades > 0 ? this.highest * 10 ** (this.decades * (place - 1)) : this.highest * place;
  }

  /** Pixels of values, of a square of them by default; NaN is transparent. */
  paint(values: Float32Array, width = Math.round(Math.sqrt(values.length))): ImageData {
    const pixels = new Uint32Array(values.length);
    const { lowest, highest, decades } = this;
    const [log, steps] = decades > 0 ? [true, 255 / (decades * Math.LN10)] : [false, 255 / highest];
    for (let k = 0; k < values.length; k++) {
      const value = values[k]!;
      if (Number.isNaN(value)) continue;
      const step = value > lowest ? (log ? Math.log(value / lowest) : value) * steps : 0;
      pixels[k] = VIRIDIS_PIXELS[Math.min(255, Math.round(step))]!;
    }
    return new ImageData(new Uint8ClampedArray(pixels.buffer), width);
  }

  /** Round values that are worth a label, from low to high. */
  ticks(): number[] {
    const { lowest, highest, decades } = this;
    if (decades > 0) {
      const first = Math.ceil(Math.log10(lowest) - 1e-9);
      const step = decades > 5 ? 2 : 1;
      return Array.from({ length: decades + 1 }, (_, k) => 10 ** (first + k * step)).filter((tick) => tick <= highest * (1 + 1e-9));
    }
    const rough = highest / 4;
    const decade = 10 ** Math.floor(Math.log10(rough));
    const step = decade * ([1, 2, 2.5, 5, 10].find((round) => round * decade >= rough) ?? 10);
    return Array.from({ length: Math.floor(highest / step + 1e-9) + 1 }, (_, k) => k * step);
  }
}

/** A value with four figures, no more characters than it needs. */
export function short(value: number): string {
  if (value === 0) return "0";
  const text = value >= 1e-3 && value < 1e5 ? String(Number(value.toPrecision(4))) : value.toExponential(2);
  return text.replace(/\.?0*e/, "e").replace("e+", "e");
}
