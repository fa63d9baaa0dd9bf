// The whole BSDF: a tile for each incident direction, in it all exitant ones, as a map that is panned and zoomed down to one cell. In: the state. Out: the picture, the
// pair of directions under the pointer, and the incident direction of a tile that is clicked. The core says what lies where.

import { Bar } from "./bar";
import type { Direction, MosaicLayout, MosaicOf, MosaicWindow, Opened } from "./core";
import { DepthScale } from "./depth";
import { toPolar } from "./directions";
import { make } from "./dom";
import { Legend } from "./legend";
import { type Frame, Pan, type Point } from "./pan";
import { Scale, VIRIDIS_PIXELS } from "./scale";
import { showsTheSame, type State } from "./state";
import type { Set, View } from "./view";

/** Tiles along an axis that are shown at first: as fine as most trees; Klems patches are no finer than 2^5. */
const LOG2_TILES = { tree: 6, matrix: 5 };
/** The finest cell may be that large [CSS pixel]. */
const LARGEST_CELL = 160;
/** Borders of cells are drawn where the finest are that large [CSS pixel]. */
const SMALLEST_CELL = 5;
/** Pictures that take longer wait until a gesture ends [ms]. */
const QUICK = 40;
const PAUSE = 120;

/** A part of the mosaic that has been painted. */
interface Picture {
  canvas: OffscreenCanvas;
  window: MosaicWindow;
}

export class Mosaic implements View {
  readonly name = "Mosaic";
  readonly element = make("section", { id: "mosaic" });
  private readonly canvas = make("canvas", { tabIndex: 0 });
  private readonly tiles = make("select", { id: "tiles" });
  private readonly quantity = make("select", { id: "quantity" }, new Option("values", ""), new Option("depth of cells", "depth"));
  private readonly how = make("p", { className: "hint" });
  private readonly legend: Legend;
  private readonly bar = new Bar();
  private readonly pan: Pan;
  private state: State | null = null;
  /** What is shown, and what of it was painted last. */
  private shown: { file: Opened; of: MosaicOf; depth: boolean; layout: MosaicLayout } | null = null;
  private highest = 0;
  private picture: (Picture & { key: string }) | null = null;
  private cost = 0;
  private later = 0;
  private pending = 0;

  constructor(set: Set) {
    this.legend = new Legend(set);
    this.canvas.setAttribute("aria-label", "Mosaic: drag or arrow keys pan, + and − zoom, Home shows all, Enter takes the incident direction in the middle");
    this.pan = new Pan(this.canvas, {
      framed: (busy) => this.repaint(busy),
      clicked: (point) => {
        const found = this.at(point);
        if (found) set({ incident: found.incident });
      },
      pointed: (point) => {
        const found = point && this.at(point);
        set({ pointedAt: found?.exitant ?? null, pointedFrom: found?.incident ?? null });
      },
    });
    const button = (text: string, title: string, act: () => void): HTMLButtonElement => {
      const element = make("button", { type: "button", title }, text);
      element.addEventListener("click", act);
      return element;
    };
    const redraw = (): void => {
      if (this.state) this.update(this.state);
    };
    this.tiles.addEventListener("change", redraw);
    this.quantity.addEventListener("change", redraw);
    const controls = make(
      "p",
      { className: "controls" },
      make("label", {}, "shows ", this.quantity),
      make("label", { title: "incident cells along each axis; coarser ones are means" }, "tiles ", this.tiles),
      button("+", "zoom in (+)", () => this.pan.step(true)),
      button("−", "zoom out (−)", () => this.pan.step(false)),
      button("all", "show all (Home)", () => this.pan.whole()),
      this.how,
    );
    this.element.append(controls, make("div", { className: "plane" }, this.canvas), this.legend.element, this.bar.element);
    new ResizeObserver(() => {
      const wasWhole = this.pan.isWhole;
      this.pan.bound();
      if (wasWhole) this.pan.whole();
      else this.repaint(false);
    }).observe(this.canvas);
  }

  draw(state: State): void {
    if (!showsTheSame(this.state, state)) this.update(state);
    this.state = state;
  }

  private update(state: State): void {
    const fresh = this.state === null || state.first !== this.state.first || state.part !== this.state.part;
    this.state = state;
    const file = state.first!;
    const band = file.band(state.band);
    const { form, maximum } = file.summary.bands[band]!.components.find(({ part }) => part === state.part)!;
    const { finest_log2_tiles: finest } = file.mosaicLayout({ band, part: state.part, log2Tiles: 0 });
    const least = form.rank === 3 ? 1 : 0;
    if (fresh) {
      const wanted = Math.max(least, Math.min(finest, form.rank === undefined ? LOG2_TILES.matrix : LOG2_TILES.tree));
      this.tiles.replaceChildren(...Array.from({ length: finest - least + 1 }, (_, k) => new Option(tilesNamed(form.rank, least + k), String(least + k))));
      this.tiles.value = String(wanted);
    }
    const of = { band, part: state.part, log2Tiles: Number(this.tiles.value) };
    const depth = this.quantity.value !== "";
    const { shown } = this;
    const isOther = !shown || shown.file !== file || shown.of.band !== band || shown.of.part !== of.part || shown.of.log2Tiles !== of.log2Tiles;
    if (isOther || shown.depth !== depth) {
      const layout = file.mosaicLayout(of);
      this.shown = { file, of, depth, layout };
      this.picture = null;
      this.how.textContent =
        form.rank === 3
          ? "A tile is a range of incident polar angles, from normal to grazing; the light heads to the right."
          : "A tile is one incident direction, placed by where the light heads; in it, where it leaves to.";
      if (isOther) {
        // The same from afar, where pixels are means, and down to one cell.
        this.highest = maximum;
        this.pan.plane({ x: layout.columns, y: layout.rows }, LARGEST_CELL * 2 ** layout.finest_log2_exitant);
      }
    }
    this.paint(false);
  }

  /** In the next frame. */
  private repaint(busy: boolean): void {
    cancelAnimationFrame(this.pending);
    this.pending = requestAnimationFrame(() => this.paint(busy));
  }

  private at({ x, y }: Point): { incident: Direction; exitant: Direction } | null {
    if (!this.shown) return null;
    const { file, of, layout } = this.shown;
    return x >= 0 && y >= 0 && x < layout.columns && y < layout.rows ? file.mosaicAt(of, x, y) : null;
  }

  private paint(busy: boolean): void {
    const { shown, state } = this;
    if (!shown || !state || this.canvas.clientWidth === 0) return;
    const sharp = window.devicePixelRatio;
    const [width, height] = [Math.round(this.canvas.clientWidth * sharp), Math.round(this.canvas.clientHeight * sharp)];
    if (this.canvas.width !== width || this.canvas.height !== height) Object.assign(this.canvas, { width, height });
    const scale = Scale.of(state, this.highest);
    const depths = new DepthScale(shown.layout.finest_log2_exitant);
    const wait = busy && this.picture !== null && this.cost > QUICK;
    clearTimeout(this.later);
    if (wait) this.later = window.setTimeout(() => this.repaint(false), PAUSE);
    else this.renew(sharp, shown.depth ? (values, across) => depths.paint(values, across) : (values, across) => scale.paint(values, across), scale);
    const context = this.canvas.getContext("2d")!;
    context.setTransform(1, 0, 0, 1, 0, 0);
    context.clearRect(0, 0, width, height);
    const { frame } = this.pan;
    context.setTransform(sharp, 0, 0, sharp, width / 2 - frame.x * frame.scale * sharp, height / 2 - frame.y * frame.scale * sharp);
    if (this.picture) place(context, this.picture, frame, sharp);
    this.mark(context, frame, state);
    this.legend.element.hidden = shown.depth;
    this.bar.element.hidden = !shown.depth;
    if (shown.depth) this.bar.draw(VIRIDIS_PIXELS, depths.labels(), "cells along each axis");
    else this.legend.draw({ ...state, natural: false }, scale);
    this.element.dataset["highest"] = String(scale.highest);
    this.element.dataset["decades"] = String(scale.decades);
  }

  /** Paints what is in sight, unless it is painted. */
  private renew(sharp: number, colours: (values: Float32Array, width: number) => ImageData, scale: Scale): void {
    const { file, of, depth, layout } = this.shown!;
    const seen = inSight(this.pan.frame, layout, this.canvas, sharp);
    const key = JSON.stringify([seen, depth, scale.decades, scale.highest]);
    if (seen.width === 0 || seen.height === 0 || this.picture?.key === key) return;
    const begun = performance.now();
    const canvas = new OffscreenCanvas(seen.width, seen.height);
    canvas.getContext("2d")!.putImageData(colours(file.mosaic(of, depth, seen), seen.width), 0, 0);
    this.picture = { canvas, window: seen, key };
    this.cost = performance.now() - begun;
  }

  /** Borders of tiles, their directions, polar angles, and the tile of the incident direction. */
  private mark(context: CanvasRenderingContext2D, frame: Frame, state: State): void {
    const { file, of, layout } = this.shown!;
    const component = file.summary.bands[of.band]!.components.find(({ part }) => part === of.part)!;
    const isIsotropic = component.form.rank === 3;
    const { columns, rows } = layout;
    const s = frame.scale;
    const line = (x0: number, y0: number, x1: number, y1: number): void => {
      context.moveTo(x0 * s, y0 * s);
      context.lineTo(x1 * s, y1 * s);
    };
    const half = { x: this.canvas.clientWidth / 2 / s, y: this.canvas.clientHeight / 2 / s };
    const [left, right] = [Math.max(0, Math.floor(frame.x - half.x)), Math.min(columns, Math.ceil(frame.x + half.x))];
    const [top, bottom] = [Math.max(0, Math.floor(frame.y - half.y)), Math.min(rows, Math.ceil(frame.y + half.y))];
    context.lineWidth = 1;
    const pixel = s / 2 ** layout.finest_log2_exitant;
    // Single cells, where they are large enough to be told apart; of a matrix they are no squares.
    if (state.edges && pixel >= SMALLEST_CELL && component.form.rank !== undefined) {
      const seen = inSight(frame, layout, this.canvas, window.devicePixelRatio);
      context.strokeStyle = "rgba(255, 255, 255, 0.45)";
      context.stroke(leafBorders(file.mosaic(of, true, seen), seen, pixel));
    }
    if (s >= 14) {
      context.beginPath();
      for (let x = left; x <= right; x++) line(x, top, x, bottom);
      for (let y = top; y <= bottom; y++) line(left, y, right, y);
      context.strokeStyle = s >= 60 ? "rgba(255, 255, 255, 0.75)" : "rgba(255, 255, 255, 0.3)";
      context.stroke();
    }
    context.font = "12px system-ui, sans-serif";
    context.textBaseline = "top";
    if (!isIsotropic && s * columns < 4 * this.canvas.clientWidth) {
      for (const thetaDeg of [30, 60]) {
        const reach = (columns / 2) * Math.sin((thetaDeg * Math.PI) / 180);
        context.setLineDash([5, 5]);
        context.strokeStyle = "rgba(255, 255, 255, 0.8)";
        context.strokeRect((columns / 2 - reach) * s, (rows / 2 - reach) * s, 2 * reach * s, 2 * reach * s);
        context.setLineDash([]);
        label(context, `θ ${thetaDeg}°`, (columns / 2 - reach) * s + 4, (rows / 2 - reach) * s + 4);
      }
    }
    const room = isIsotropic ? 56 : 150;
    if (s >= room) {
      for (let y = top; y < bottom; y++) {
        for (let x = left; x < right; x++) {
          // In sight even where the tile is larger than the canvas.
          const [inX, inY] = [Math.max(x, frame.x - half.x), Math.max(y, frame.y - half.y)];
          if ((Math.min(x + 1, frame.x + half.x) - inX) * s < room) continue;
          const { thetaDeg, phiDeg } = toPolar(file.mosaicAt(of, x + 0.5, y + 0.5).incident);
          label(context, isIsotropic ? `θ ${thetaDeg.toFixed(1)}°` : `from θ ${thetaDeg.toFixed(1)}°, φ ${phiDeg.toFixed(1)}°`, inX * s + 4, inY * s + 4);
        }
      }
    }
    if (state.incident[2] > 0 === component.incident_front) {
      const [x, y] = file.mosaicPlace(of, state.incident, state.incident);
      context.strokeStyle = "#e69f00";
      context.lineWidth = 2;
      const grown = Math.max(0, 7 - s) / 2;
      context.strokeRect(Math.floor(x) * s - grown, Math.floor(y) * s - grown, s + 2 * grown, s + 2 * grown);
    }
  }
}

function tilesNamed(rank: number | undefined, log2: number): string {
  return rank === 3 ? `${2 ** (log2 - 1)} polar angles` : `${2 ** log2} × ${2 ** log2}`;
}

/** What of the mosaic is in sight, with about a pixel for each of the screen's, unless its cells are coarser. */
function inSight({ x, y, scale }: Frame, layout: MosaicLayout, canvas: HTMLCanvasElement, sharp: number): MosaicWindow {
  const wanted = Math.ceil(Math.log2(scale * sharp) - 0.2);
  const log2Exitant = Math.min(layout.finest_log2_exitant, Math.max(0, wanted));
  const n = 2 ** log2Exitant;
  const cut = (middle: number, seen: number, tiles: number): [number, number] => {
    const from = Math.max(0, Math.floor((middle - seen / 2 / scale) * n));
    const to = Math.min(tiles * n, Math.ceil((middle + seen / 2 / scale) * n));
    return [from, Math.max(0, to - from)];
  };
  const [[left, width], [top, height]] = [cut(x, canvas.clientWidth, layout.columns), cut(y, canvas.clientHeight, layout.rows)];
  return { log2Exitant, x: left, y: top, width, height };
}

/** Draws a picture where it lies; smoothed where its pixels are finer than the screen's, else cells with sharp borders. */
function place(context: CanvasRenderingContext2D, { canvas, window: { log2Exitant, x, y, width, height } }: Picture, { scale }: Frame, sharp: number): void {
  const pixel = scale / 2 ** log2Exitant;
  context.imageSmoothingEnabled = pixel * sharp < 1;
  context.drawImage(canvas, x * pixel, y * pixel, width * pixel, height * pixel);
}

/** Borders of the leaves in a part of the mosaic that has pixels of the finest: leaves of a size lie at multiples of it. */
function leafBorders(depths: Float32Array, { log2Exitant, x, y, width }: MosaicWindow, pixel: number): Path2D {
  const path = new Path2D();
  depths.forEach((depth, k) => {
    const edge = 2 ** (log2Exitant - depth);
    const [column, row] = [x + (k % width), y + Math.floor(k / width)];
    if (column % edge === 0) {
      path.moveTo(column * pixel, row * pixel);
      path.lineTo(column * pixel, (row + 1) * pixel);
    }
    if (row % edge === 0) {
      path.moveTo(column * pixel, row * pixel);
      path.lineTo((column + 1) * pixel, row * pixel);
    }
  });
  return path;
}

function label(context: CanvasRenderingContext2D, text: string, x: number, y: number): void {
  context.save();
  context.lineWidth = 3;
  context.strokeStyle = "rgba(0, 0, 0, 0.75)";
  context.strokeText(text, x, y);
  context.fillStyle = "white";
  context.fillText(text, x, y);
  context.restore();
}
