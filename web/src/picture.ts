// One exitant hemisphere as a square of values, n × n, in which nothing narrow is lost. In: an open file, an incident direction. Out: values [1/sr], NaN outside of
// the disk; of cells that are finer than pixels the largest of four places in each.

import type { Direction, Opened } from "./core";

/** Whether a file has cells that pixels, n along an edge, could miss. */
export function isFinerThan(n: number, file: Opened, band: number): boolean {
  const components = file.summary.bands[band]?.components ?? [];
  return components.some(({ form }) => form.log2_res !== undefined && 2 ** form.log2_res > n / 2);
}

export function picture(file: Opened, band: number, incident: Direction, front: boolean, n: number, isFine: boolean): Float32Array {
  return isFine ? largestOfFour(file.hemisphere(band, incident, front, 2 * n), n) : file.hemisphere(band, incident, front, n);
}

/** Half as large a picture, n × n: of four values that of the largest size, with its sign; NaN only where all are. */
export function largestOfFour(values: Float32Array, n: number): Float32Array {
  const picture = new Float32Array(n * n);
  for (let row = 0; row < n; row++) {
    for (let column = 0; column < n; column++) {
      const corner = 4 * row * n + 2 * column;
      let most = NaN;
      for (const k of [corner, corner + 1, corner + 2 * n, corner + 2 * n + 1]) {
        const value = values[k]!;
        if (Number.isNaN(most) || Math.abs(value) > Math.abs(most)) most = value;
      }
      picture[row * n + column] = most;
    }
  }
  return picture;
}

/** The largest value; NaN is never larger. */
export function peak(values: Float32Array): number {
  return values.reduce((most, value) => (value > most ? value : most), 0);
}
