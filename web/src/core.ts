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
  /** In memory. */
  n_bytes: number;
  maximum: number;
  lambertian: number;
  is_coloured: boolean;
}

export interface Summary {
  name: string;
  manufacturer: string;
  /** Whether the file says that its values are standard errors. */
  has_errors: boolean;
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
  /** Where a file of standard errors is open beside. */
  standard_error?: number;
}

/** How the mosaic of a component lies: tiles beside and above each other, and how fine tiles and their pixels can be. */
export interface MosaicLayout {
  columns: number;
  rows: number;
  finest_log2_tiles: number;
  finest_log2_exitant: number;
}

/** A component of a band, its mosaic cut into 2^log2Tiles incident cells along each axis. */
export interface MosaicOf {
  band: number;
  part: string;
  log2Tiles: number;
}

/** A part of a mosaic whose tiles have 2^log2Exitant pixels along each axis [pixel], from its top left. */
export interface MosaicWindow {
  log2Exitant: number;
  x: number;
  y: number;
  width: number;
  height: number;
}

/** How a component is divided: groups of cells, and a histogram of equal ratios between two powers of ten; shares of 1. */
export interface Statistics {
  kind: "depth" | "exitant ring";
  groups: { label: string; n_cells: number; share: number; light: number }[];
  histogram: { first_decade: number; last_decade: number; n_cells: number[]; light: number[]; black: number };
}

/** How far a component of another file is from this one's. Totals are fractions of light; `relative_l1` is null where either file has none. */
export interface Difference {
  part: string;
  relative_l1: number | null;
  totals: [number, number];
  rms_total: number;
  worst_total: number;
  worst_theta_deg: number;
  worst_phi_deg: number;
}

/** How well a component is known: mean relative standard error by light, and the share of light where it is over 25 %. */
export interface ErrorByFlux {
  part: string;
  mean: number;
  uncertain: number;
}

/** What a step of long counting may take. */
const STEP_MS = 12;

/** Components as the core counts them. */
const PARTS = ["reflection_front", "reflection_back", "transmission_front", "transmission_back"];

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
  bsdftree_lobe(band: number, ix: number, iy: number, iz: number, front: number, n: number, perKnot: number): number;
  bsdftree_lobe_colours(band: number, ix: number, iy: number, iz: number, front: number, n: number, white: number, decades: number): number;
  bsdftree_slice(band: number, ix: number, iy: number, iz: number, front: number, n: number): number;
  bsdftree_totals(band: number, front: number, phi: number, n: number): number;
  bsdftree_depths(band: number, ix: number, iy: number, iz: number, front: number, n: number): number;
  bsdftree_mosaic(band: number, part: number, depth: number, log2Tiles: number, log2Exitant: number, x: number, y: number, width: number, height: number): number;
  bsdftree_mosaic_layout(band: number, part: number, log2Tiles: number): number;
  bsdftree_mosaic_at(band: number, part: number, log2Tiles: number, x: number, y: number): number;
  bsdftree_mosaic_place(band: number, part: number, log2Tiles: number, ix: number, iy: number, iz: number, ox: number, oy: number, oz: number): number;
  bsdftree_statistics(band: number, part: number): number;
  bsdftree_image(): number;
  bsdftree_forget(): void;
  bsdftree_open_beside(n: number, onlyErrors: number): number;
  bsdftree_differences(band: number, nPoints: number): number;
  bsdftree_errors_by_flux(band: number): number;
}

/** A file that the core refused, with its own words. */
export class Refused extends Error {}

let compiled: Promise<WebAssembly.Module> | undefined;

/** An open file. */
export class Opened {
  /** Whether standard errors are known. */
  hasErrors = false;

  private constructor(
    private readonly core: Exports,
    readonly name: string,
    readonly summary: Summary,
    /** Of the file [byte]. */
    readonly size: number,
  ) {}

  /** Opens the bytes of a file, XML or .bsdft. Damaged files are read as far as they can be; the summary's notes say what was done. */
  static async open(name: string, bytes: Uint8Array): Promise<Opened> {
    compiled ??= compile();
    const instance = await WebAssembly.instantiate(await compiled, {});
    const core = instance.exports as unknown as Exports;
    const told = JSON.parse(text(core, core.bsdftree_open(write(core, bytes), 1))) as Summary | { error: string };
    if ("error" in told) throw new Refused(told.error);
    return new Opened(core, name, told, bytes.length);
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

  /** Values at the knots: the largest of so many × so many places of each knot's cell. */
  lobe(band: number, [ix, iy, iz]: Direction, front: boolean, n: number, perKnot: number): Float32Array {
    return this.numbers(this.core.bsdftree_lobe(band, ix, iy, iz, Number(front), n, perKnot));
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

  /** How fine the cells of a hemisphere are, n × n: ½ log2 (π / projected solid angle), of leaves a whole number; NaN outside of the disk and where nothing goes. */
  depths(band: number, [ix, iy, iz]: Direction, front: boolean, n: number): Float32Array {
    return this.numbers(this.core.bsdftree_depths(band, ix, iy, iz, Number(front), n));
  }

  mosaicLayout({ band, part, log2Tiles }: MosaicOf): MosaicLayout {
    return JSON.parse(text(this.core, this.core.bsdftree_mosaic_layout(band, PARTS.indexOf(part), log2Tiles))) as MosaicLayout;
  }

  /** Pixels of a part of a mosaic that lies inside of it, values or depths, row by row from the top. */
  mosaic({ band, part, log2Tiles }: MosaicOf, depth: boolean, { log2Exitant, x, y, width, height }: MosaicWindow): Float32Array {
    return this.numbers(this.core.bsdftree_mosaic(band, PARTS.indexOf(part), Number(depth), log2Tiles, log2Exitant, x, y, width, height));
  }

  /** The pair of directions at a place of a mosaic, counted in tiles from the top left, and its cell. */
  mosaicAt({ band, part, log2Tiles }: MosaicOf, x: number, y: number): { incident: Direction; exitant: Direction; cell: Cell } {
    return JSON.parse(text(this.core, this.core.bsdftree_mosaic_at(band, PARTS.indexOf(part), log2Tiles, x, y))) as ReturnType<Opened["mosaicAt"]>;
  }

  /** Where a pair of directions lies in a mosaic, counted in tiles from the top left. */
  mosaicPlace({ band, part, log2Tiles }: MosaicOf, [ix, iy, iz]: Direction, [ox, oy, oz]: Direction): [number, number] {
    const place = this.numbers(this.core.bsdftree_mosaic_place(band, PARTS.indexOf(part), log2Tiles, ix, iy, iz, ox, oy, oz));
    return [place[0]!, place[1]!];
  }

  statistics(band: number, part: string): Statistics {
    return JSON.parse(text(this.core, this.core.bsdftree_statistics(band, PARTS.indexOf(part)))) as Statistics;
  }

  /** How far the components of another file are from this one's; empty if it has no band of that name. In an instance of its own, that holds both while it counts, step by
   * step, so that the page goes on; `told` has the part that is done, and says whether to go on. */
  async differences(other: Opened, band: number, told: (done: number) => boolean): Promise<Difference[]> {
    const both = await Opened.open(this.name, this.image());
    both.openBeside(other, false);
    for (let nPoints = 64; ; ) {
      const begun = performance.now();
      const found = text(both.core, both.core.bsdftree_differences(band, nPoints)) || '{ "rows": [] }';
      const { done, rows } = JSON.parse(found) as { done?: number; rows?: Difference[] };
      if (rows) return rows;
      if (!told(done!)) return [];
      nPoints = Math.max(16, Math.min(2 * nPoints, Math.round((nPoints * STEP_MS) / (performance.now() - begun))));
      await new Promise((goOn) => setTimeout(goOn));
    }
  }

  /** Takes a file for the standard errors of this one, so that cells tell theirs; false if it has none, or those of other trees. */
  takeErrors(errors: Opened): boolean {
    const areErrors = errors.summary.has_errors && errors !== this && this.openBeside(errors, true);
    if (areErrors) this.hasErrors = true;
    return areErrors;
  }

  /** How well components are known; empty without standard errors. */
  errorsByFlux(band: number): ErrorByFlux[] {
    return JSON.parse(text(this.core, this.core.bsdftree_errors_by_flux(band)) || "[]") as ErrorByFlux[];
  }

  /** As a raw .bsdft. */
  private image(): Uint8Array {
    const bytes = this.pixels(this.core.bsdftree_image());
    this.core.bsdftree_forget();
    return bytes;
  }

  private openBeside(other: Opened, onlyErrors: boolean): boolean {
    const told = JSON.parse(text(this.core, this.core.bsdftree_open_beside(write(this.core, other.image()), Number(onlyErrors)))) as { are_errors: boolean } | { error: string };
    if ("error" in told) throw new Refused(told.error);
    return told.are_errors;
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

/** Hands bytes to the core; how many. */
function write(core: Exports, bytes: Uint8Array): number {
  const place = core.bsdftree_reserve(bytes.length) >>> 0;
  new Uint8Array(core.memory.buffer, place, bytes.length).set(bytes);
  return bytes.length;
}

function text(core: Exports, length: number): string {
  return new TextDecoder().decode(new Uint8Array(core.memory.buffer, core.bsdftree_text() >>> 0, length));
}
