// A plot of values over an angle, as SVG. In: curves, axes, marks. Out: the picture, and the sample under the pointer or the keyboard's cursor.
// Of the samples that fall into one pixel the highest is drawn and read, so that nothing narrow is lost.

import { make, svg } from "./dom";

/** Values at the middles of equal steps over the range of x. */
export interface Curve {
  /** In the key; empty for those of the compared file. */
  readonly label: string;
  /** Of style.css: what kind of curve it is. */
  readonly kind: string;
  readonly values: Float32Array;
}

export interface Figure {
  readonly curves: readonly Curve[];
  /** Where a value lies, 0 (bottom) to 1. */
  readonly place: (value: number) => number;
  readonly ticks: readonly { readonly value: number; readonly text: string }[];
  /** What curves of the kind "compared" are of. */
  readonly compared: string | null;
  /** Vertical lines at values of x. */
  readonly marks: readonly { readonly x: number; readonly text: string }[];
}

export interface Axes {
  readonly x: string;
  readonly y: string;
  readonly from: number;
  readonly to: number;
  readonly step: number;
}

/** Pixels left of, above, right of and below the curves. */
const MARGIN = { left: 62, top: 22, right: 14, bottom: 42 };

export class Plot {
  readonly element = make("div", { className: "plot", tabIndex: 0 });
  private readonly svg = svg("svg", {});
  private readonly fixed = svg("g", {});
  private readonly moving = svg("g", {});
  private drawn = "";
  private readonly key = make("p", { className: "key" });
  private figure: Figure | null = null;
  private cursor: { x: number; curve: number } | null = null;

  /** `pointed` has the sample's x and its curve; null when the pointer leaves. `dragged` has the x of a drag. */
  constructor(
    private readonly axes: Axes,
    private readonly pointed: (at: { x: number; curve: number } | null) => void,
    private readonly dragged: ((x: number, moving: boolean) => void) | null = null,
  ) {
    this.element.append(this.key, make("div", { className: "curves" }));
    this.element.lastElementChild!.append(this.svg);
    this.svg.append(this.fixed, this.moving);
    this.listen();
    new ResizeObserver(() => this.paint()).observe(this.element);
  }

  draw(figure: Figure): void {
    this.figure = figure;
    this.paint();
  }

  /** The samples' middle. */
  private middle(k: number, n: number): number {
    return this.axes.from + ((this.axes.to - this.axes.from) * (k + 0.5)) / n;
  }

  private get size(): { width: number; height: number; right: number; bottom: number } {
    const { clientWidth: width, clientHeight: height } = this.svg.parentElement!;
    return { width, height, right: width - MARGIN.right, bottom: height - MARGIN.bottom };
  }

  private across(x: number): number {
    const { from, to } = this.axes;
    return MARGIN.left + ((x - from) / (to - from)) * (this.size.right - MARGIN.left);
  }

  private up(value: number): number {
    const { bottom } = this.size;
    return bottom - this.figure!.place(value) * (bottom - MARGIN.top);
  }

  private paint(): void {
    const { width, height } = this.size;
    if (!this.figure || width < 100 || height < 80) return;
    const { curves, compared, ticks } = this.figure;
    this.moving.replaceChildren(...curves.map((curve) => this.curve(curve)), ...this.marks(), ...this.cursorMarks());
    // What is about the curves changes rarely, and costs more than they do.
    const drawn = JSON.stringify([width, height, ticks, curves.map(({ label }) => label), compared]);
    if (drawn === this.drawn) return;
    this.drawn = drawn;
    this.svg.setAttribute("viewBox", `0 0 ${width} ${height}`);
    this.fixed.replaceChildren(...this.grid());
    const keys = curves.filter(({ label }) => label !== "").map(({ label, kind }) => make("span", { className: kind }, label));
    this.key.replaceChildren(...keys, ...(compared === null ? [] : [make("span", { className: "compared" }, compared)]));
  }

  private grid(): SVGElement[] {
    const { right, bottom } = this.size;
    const { from, to, step, x, y } = this.axes;
    const parts: SVGElement[] = [];
    // Words need place.
    const apart = this.across(from + step) - this.across(from) < 40 ? 2 * step : step;
    for (let at = from; at <= to; at += step) {
      const place = this.across(at);
      parts.push(line("grid", place, MARGIN.top, place, bottom));
      if ((at - from) % apart === 0) parts.push(words(`${at}°`.replace("-", "−"), place, bottom + 16));
    }
    for (const { value, text } of this.figure!.ticks) {
      const place = this.up(value);
      parts.push(line("grid", MARGIN.left, place, right, place), words(text, MARGIN.left - 6, place + 4, "end"));
    }
    const side = words(y, 0, 0);
    side.setAttribute("transform", `translate(13 ${(MARGIN.top + bottom) / 2}) rotate(-90)`);
    return [...parts, side, words(x, (MARGIN.left + right) / 2, bottom + 35)];
  }

  private curve({ kind, values }: Curve): SVGElement {
    const { right, bottom } = this.size;
    const { from, to } = this.axes;
    const n = values.length;
    const step = Math.max(1, Math.floor(n / Math.max(1, right - MARGIN.left)));
    const across = (k: number): string => (MARGIN.left + ((this.middle(k, n) - from) / (to - from)) * (right - MARGIN.left)).toFixed(1);
    const points: string[] = [];
    let [last, skipped] = [NaN, ""];
    for (let k = 0; k < n; k += step) {
      const end = Math.min(n, k + step);
      let most = values[k]!;
      for (let l = k + 1; l < end; l++) most = Math.max(most, values[l]!);
      const point = `${across((k + end - 1) / 2)} ${(bottom - this.figure!.place(most) * (bottom - MARGIN.top)).toFixed(1)}`;
      // Of a run of equal values, the ends are enough.
      if (most === last) {
        skipped = point;
        continue;
      }
      if (skipped) points.push(skipped);
      points.push(point);
      [last, skipped] = [most, ""];
    }
    if (skipped) points.push(skipped);
    return svg("path", { class: `curve ${kind}`, d: `M${points.join("L")}` });
  }

  private marks(): SVGElement[] {
    return this.figure!.marks.flatMap(({ x, text }) => {
      const place = this.across(x);
      return [line("mark", place, MARGIN.top, place, this.size.bottom), words(text, place, MARGIN.top - 7, "middle", "mark")];
    });
  }

  private cursorMarks(): SVGElement[] {
    if (!this.cursor) return [];
    const { x, curve } = this.cursor;
    const place = this.across(x);
    const dots = this.figure!.curves.map(({ values, kind }, k) => {
      const at = Math.round(((x - this.axes.from) / (this.axes.to - this.axes.from)) * values.length - 0.5);
      return svg("circle", { class: kind, cx: place, cy: this.up(values[Math.min(values.length - 1, Math.max(0, at))] ?? 0), r: k === curve ? 5 : 3 });
    });
    return [line("cursor", place, MARGIN.top, place, this.size.bottom), ...dots];
  }

  /** The highest sample near a pixel, of the curve that is nearest to the pointer there. */
  private nearest(px: number, py: number): { x: number; curve: number } | null {
    if (!this.figure) return null;
    const { right } = this.size;
    const share = (px - MARGIN.left) / (right - MARGIN.left);
    if (share < 0 || share > 1) return null;
    const found = this.figure.curves.map(({ values }, curve) => {
      const n = values.length;
      const reach = Math.floor(n / (right - MARGIN.left));
      const at = Math.min(n - 1, Math.floor(share * n));
      let best = at;
      for (let k = Math.max(0, at - reach); k <= Math.min(n - 1, at + reach); k++) if (values[k]! > values[best]!) best = k;
      return { x: this.middle(best, n), curve, distance: Math.abs(this.up(values[best] ?? 0) - py) };
    });
    const [first] = found.sort((a, b) => a.distance - b.distance);
    return first ? { x: first.x, curve: first.curve } : null;
  }

  private move(cursor: { x: number; curve: number } | null): void {
    this.cursor = cursor;
    this.paint();
    this.pointed(cursor);
  }

  private listen(): void {
    const place = (event: PointerEvent): [number, number] => {
      const box = this.svg.getBoundingClientRect();
      return [event.clientX - box.left, event.clientY - box.top];
    };
    const drag = (event: PointerEvent, moving: boolean): void => {
      const { from, to } = this.axes;
      const share = (place(event)[0] - MARGIN.left) / (this.size.right - MARGIN.left);
      this.dragged?.(from + (to - from) * Math.min(1, Math.max(0, share)), moving);
    };
    this.svg.addEventListener("pointerdown", (event) => {
      this.move(this.nearest(...place(event)));
      if (!this.dragged) return;
      this.svg.setPointerCapture(event.pointerId);
      drag(event, true);
    });
    this.svg.addEventListener("pointermove", (event) => {
      this.move(this.nearest(...place(event)));
      if (event.buttons & 1) drag(event, true);
    });
    this.svg.addEventListener("pointerup", (event) => drag(event, false));
    // A finger that is lifted has read something.
    this.svg.addEventListener("pointerleave", (event) => event.pointerType !== "touch" && this.move(null));
    this.element.addEventListener("keydown", (event) => this.press(event));
  }

  /** Left and right move the cursor by a pixel, ten with Shift; up and down change the curve. */
  private press(event: KeyboardEvent): void {
    const move = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] }[event.key];
    if (!move || !this.figure) return;
    event.preventDefault();
    const n = this.figure.curves.length;
    const { x, curve } = this.cursor ?? { x: (this.axes.from + this.axes.to) / 2, curve: 0 };
    const next = (curve + move[1]! + n) % n;
    const pixel = this.across(x) + move[0]! * (event.shiftKey ? 10 : 1);
    const share = Math.min(1, Math.max(0, (pixel - MARGIN.left) / (this.size.right - MARGIN.left)));
    const { length } = this.figure.curves[next]!.values;
    this.move({ x: this.middle(Math.min(length - 1, Math.floor(share * length)), length), curve: next });
  }
}

function line(kind: string, x1: number, y1: number, x2: number, y2: number): SVGElement {
  return svg("line", { class: kind, x1, y1, x2, y2 });
}

function words(text: string, x: number, y: number, anchor = "middle", kind = "words"): SVGElement {
  const element = svg("text", { class: kind, x, y, "text-anchor": anchor });
  element.textContent = text;
  return element;
}
