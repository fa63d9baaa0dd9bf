// The Rust core: one WebAssembly instance for each file that is open, so that closing a file gives its memory back. What is asked is said in
// crates/bsdftree-wasm; nothing is looked up here. Arrays are copies: the core's memory changes with the next call.

import coreUrl from "./core.wasm";
import { coreInside, unpacked } from "./inside";

/** A unit vector away from the surface, the incident one too; +Z is the room. */
export type Direction = readonly [number, number, number];

/** A component as the core sums it up; values in 1/sr. */
export interface Component {
  part: string;
  incident_front: boolean;
  exitant_front: boolean;
  structure: string;
  form: {
    rank?: number;
    log2_res?: number;
    n_leaves?: number;
    incident_basis?: string;
    n_incident?: number;
    exitant_basis?: string;
    n_exitant?: number;
  };
  n_values: number;
  maximum: number;
  lambertian: number;
  is_coloured: boolean;
}

export interface Summary {
  name: string;
  manufacturer: string;
  bands: { name: string; components: Component[] }[];
  notes: { repaired: boolean; what: string }[];
}

/** Values in 1/sr, extent in sr. */
export interface Cell {
  value: number;
  xyz: [number, number, number];
  projected_solid_angle: number;
  key: string;
  reversed: boolean;
}

/** How bright a value is: full at `highest` [1/sr], black that many powers of ten below; 0 is brightness in proportion. */
export interface Tone {
  readonly highest: number;
  readonly decades: number;
}

interface Exports {
  memory: WebAssembly.Memory;
  bsdftree_reserve(n: number): number;
  bsdftree_text(): number;
  bsdftree_numbers(): number;
  bsdftree_pixels(): number;
  bsdftree_open(n: number, repair: number): number;
  bsdftree_cell(band: number, ix: number, iy: number, iz: number, ox: number, oy: number, oz: number): number;
  bsdftree_hemisphere(band: number, ix: number, iy: number, iz: number, front: number, n: number): number;
  bsdftree_edges(band: number, ix: number, iy: number, iz: number, front: number, n: number): number;
  bsdftree_colours(band: number, ix: number, iy: number, iz: number, front: number, n: number, white: number, decades: number): number;
  bsdftree_knots(front: number, n: number): number;
  bsdftree_lobe(band: number, ix: number, iy: number, iz: number, front: number, n: number): number;
  bsdftree_lobe_colours(band: number, ix: number, iy: number, iz: number, front: number, n: number, white: number, decades: number): number;
  bsdftree_slice(band: number, ix: number, iy: number, iz: number, front: number, n: number): number;
  bsdftree_totals(band: number, front: number, phi: number, n: number): number;
}

/** A file that the core refused, with its own words. */
export class Refused extends Error {}

let compiled: Promise<WebAssembly.Module> | undefined;

/** An open file. */
export class Opened {
  private constructor(
    private readonly core: Exports,
    readonly name: string,
    readonly summary: Summary,
  ) {}

  /** Opens the bytes of a file, XML or .bsdft. Damaged files are read as far as they can be; the summary's notes say what was done. */
  static async open(name: string, bytes: Uint8Array): Promise<Opened> {
    compiled ??= compile();
    const instance = await WebAssembly.instantiate(await compiled, {});
    const core = instance.exports as unknown as Exports;
    const place = core.bsdftree_reserve(bytes.length) >>> 0;
    new Uint8Array(core.memory.buffer, place, bytes.length).set(bytes);
    const told = JSON.parse(text(core, core.bsdftree_open(bytes.length, 1))) as Summary | { error: string };
    if ("error" in told) throw new Refused(told.error);
    return new Opened(core, name, told);
  }

  /** The number of a band, −1 if there is none of that name: then all that is asked of it is empty. */
  band(name: string): number {
    return this.summary.bands.findIndex((band) => band.name === name);
  }

  /** The cell of a pair of directions, null where nothing goes. */
  cell(band: number, [ix, iy, iz]: Direction, [ox, oy, oz]: Direction): Cell | null {
    return JSON.parse(text(this.core, this.core.bsdftree_cell(band, ix, iy, iz, ox, oy, oz)) || "null") as Cell | null;
  }

  /** Values over a hemisphere, n × n, rows from the top (+Y); NaN outside of the disk. */
  hemisphere(band: number, [ix, iy, iz]: Direction, front: boolean, n: number): Float32Array {
    return this.numbers(this.core.bsdftree_hemisphere(band, ix, iy, iz, Number(front), n));
  }

  /** The same as sRGB with alpha, 4 bytes for each pixel, transparent outside of the disk. */
  colours(band: number, [ix, iy, iz]: Direction, front: boolean, n: number, { highest, decades }: Tone): Uint8Array {
    return this.pixels(this.core.bsdftree_colours(band, ix, iy, iz, Number(front), n, highest, decades));
  }

  /** Directions of the (n + 2)² knots of a net over a hemisphere, at the middles of n × n cells and on their border, first coordinate slowest. */
  knots(front: boolean, n: number): Float32Array {
    return this.numbers(this.core.bsdftree_knots(Number(front), n));
  }

  /** Values at the knots. */
  lobe(band: number, [ix, iy, iz]: Direction, front: boolean, n: number): Float32Array {
    return this.numbers(this.core.bsdftree_lobe(band, ix, iy, iz, Number(front), n));
  }

  /** The same as sRGB with alpha, 4 bytes for each knot. */
  lobeColours(band: number, [ix, iy, iz]: Direction, front: boolean, n: number, { highest, decades }: Tone): Uint8Array {
    return this.pixels(this.core.bsdftree_lobe_colours(band, ix, iy, iz, Number(front), n, highest, decades));
  }

  /** 1 where cells meet, n × n. */
  edges(band: number, [ix, iy, iz]: Direction, front: boolean, n: number): Uint8Array {
    return this.pixels(this.core.bsdftree_edges(band, ix, iy, iz, Number(front), n));
  }

  /** Values in the incidence plane at the middles of n steps from −90° to 90°; positive angles are those of mirrored and straight light. */
  slice(band: number, [ix, iy, iz]: Direction, front: boolean, n: number): Float32Array {
    return this.numbers(this.core.bsdftree_slice(band, ix, iy, iz, Number(front), n));
  }

  /** n reflectances, then n transmittances, at the middles of n steps of the angle of incidence from 0° to 90°; φ in radians. */
  totals(band: number, front: boolean, phi: number, n: number): Float32Array {
    return this.numbers(this.core.bsdftree_totals(band, Number(front), phi, n));
  }

  private numbers(length: number): Float32Array {
    return new Float32Array(this.core.memory.buffer, this.core.bsdftree_numbers() >>> 0, length).slice();
  }

  private pixels(length: number): Uint8Array {
    return new Uint8Array(this.core.memory.buffer, this.core.bsdftree_pixels() >>> 0, length).slice();
  }
}

async function compile(): Promise<WebAssembly.Module> {
  const inside = coreInside();
  if (inside) return WebAssembly.compile(await unpacked(inside));
  return WebAssembly.compileStreaming(fetch(new URL(coreUrl, import.meta.url)));
}

function text(core: Exports, length: number): string {
  return new TextDecoder().decode(new Uint8Array(core.memory.buffer, core.bsdftree_text() >>> 0, length));
}
