// Values to colours: logarithmic over four decades below the largest value, in matplotlib's viridis, which is even in lightness and safe
// for colour-blind eyes. Nine of its colours, straight lines between.

const VIRIDIS = [0x440154, 0x472d7b, 0x3b528b, 0x2c728e, 0x21918c, 0x28ae80, 0x5ec962, 0xaddc30, 0xfde725];
const DECADES = 4;

const TABLE = Uint32Array.from({ length: 256 }, (_, k) => {
  const place = (k / 255) * (VIRIDIS.length - 1);
  const below = Math.min(Math.floor(place), VIRIDIS.length - 2);
  const channel = (shift: number): number => {
    const [a, b] = [VIRIDIS[below]! >> shift, VIRIDIS[below + 1]! >> shift].map((c) => c & 255) as [number, number];
    return Math.round(a + (b - a) * (place - below));
  };
  // Little-endian RGBA.
  return (255 << 24) | (channel(0) << 16) | (channel(8) << 8) | channel(16);
});

/** The smallest value that has a colour of its own, for a largest one. */
export function lowest(highest: number): number {
  return highest / 10 ** DECADES;
}

/** Pixels of values; NaN is transparent, what is below the lowest has the lowest colour. */
export function paint(values: Float32Array, highest: number): ImageData {
  const size = Math.round(Math.sqrt(values.length));
  const pixels = new Uint32Array(values.length);
  const floor = lowest(highest);
  const steps = 255 / (DECADES * Math.LN10);
  for (let k = 0; k < values.length; k++) {
    const value = values[k]!;
    if (Number.isNaN(value)) continue;
    const step = value > floor ? Math.log(value / floor) * steps : 0;
    pixels[k] = TABLE[Math.min(255, Math.round(step))]!;
  }
  return new ImageData(new Uint8ClampedArray(pixels.buffer), size);
}

/** The colours from left to right. */
export function paintLegend(canvas: HTMLCanvasElement): void {
  const values = Float32Array.from({ length: 256 }, (_, k) => 10 ** ((k / 255 - 1) * DECADES));
  const row = Uint32Array.from({ length: 256 * canvas.height }, (_, k) => {
    const step = (Math.log10(values[k % 256]!) / DECADES + 1) * 255;
    return TABLE[Math.round(step)]!;
  });
  canvas.getContext("2d")!.putImageData(new ImageData(new Uint8ClampedArray(row.buffer), 256), 0, 0);
}
