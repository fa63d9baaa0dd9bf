// Differences and ratios to colours: blue where the other file has less, red where more, white where both have the same; matplotlib's RdBu, which colour-blind eyes tell
// apart. In: two arrays of values at the same directions. Out: pixels and labels. Differences are logarithmic on both sides of nothing, or linear; ratios are logarithmic.

import { pixelsOf, short } from "./scale";

const RED_BLUE = [0x053061, 0x2166ac, 0x4393c3, 0x92c5de, 0xd1e5f0, 0xf7f7f7, 0xfddbc7, 0xf4a582, 0xd6604d, 0xb2182b, 0x67001f];
export const DIVERGING_PIXELS = pixelsOf(RED_BLUE);
/** Where there is no ratio, since neither has light. */
const NEITHER = 0xffb8b8b8;
/** The share of a side for what is below the smallest difference of a logarithmic scale. */
const SMALL = 0.06;
/** Ratios are drawn from a tenth to ten times. */
const MOST_RATIO = 10;

/** A place from 0 to 1 for a number; ½ is no difference. */
export interface Diverging {
  place(value: number): number;
  readonly labels: [number, string][];
}

/** Over some powers of ten on each side of nothing, or, if they are none, linear. Half as many as values have keep small differences pale. */
export function differenceScale(decades: number, largest: number): Diverging {
  const low = largest / 10 ** decades;
  const side = (size: number): number => {
    if (decades === 0) return Math.min(1, size / largest);
    if (size <= low) return (SMALL * size) / low;
    return Math.min(1, SMALL + (1 - SMALL) * (Math.log10(size / low) / decades));
  };
  const place = (value: number): number => 0.5 + 0.5 * Math.sign(value) * side(Math.abs(value));
  const labels = [-largest, 0, largest].map((value): [number, string] => [place(value), signed(Number(value.toPrecision(2)))]);
  return { place, labels };
}

export const RATIO: Diverging = {
  place: (ratio) => Math.min(1, Math.max(0, 0.5 + 0.5 * Math.log10(ratio))),
  labels: [[0, `≤ ${1 / MOST_RATIO}`], [placeOf(0.5), "0.5"], [0.5, "1"], [placeOf(2), "2"], [1, `≥ ${MOST_RATIO}`]],
};

function placeOf(ratio: number): number {
  return 0.5 + 0.5 * Math.log10(ratio);
}

/** `other` less `one`; NaN where they are. */
export function difference(one: Float32Array, other: Float32Array): Float32Array {
  return one.map((value, k) => other[k]! - value);
}

/** `other` by `one`; NaN outside of the disk, −1 where neither has light. */
export function ratio(one: Float32Array, other: Float32Array): Float32Array {
  return one.map((value, k) => (value === 0 && other[k] === 0 ? -1 : other[k]! / value));
}

/** Pixels of a square of numbers; NaN is transparent, −1 of ratios grey. */
export function paint(values: Float32Array, { place }: Diverging, isRatio: boolean): ImageData {
  const pixels = new Uint32Array(values.length);
  for (let k = 0; k < values.length; k++) {
    const value = values[k]!;
    if (Number.isNaN(value)) continue;
    pixels[k] = isRatio && value < 0 ? NEITHER : DIVERGING_PIXELS[Math.round(255 * place(value))]!;
  }
  return new ImageData(new Uint8ClampedArray(pixels.buffer), Math.round(Math.sqrt(values.length)));
}

/** With its sign, 0 without. */
export function signed(value: number): string {
  return value === 0 ? "0" : `${value < 0 ? "−" : "+"}${short(Math.abs(value))}`;
}
