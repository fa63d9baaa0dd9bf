// A bar chart as SVG: groups with a bar for each of one or two series, or a histogram. In: numbers. Out: the picture; what a bar is exactly is told when it is pointed at.

import { make } from "./dom";

export interface Series {
  /** In the key. */
  readonly name: string;
  /** Of whole.css. */
  readonly kind: string;
  readonly values: readonly number[];
}

export interface Chart {
  readonly title: string;
  readonly series: readonly Series[];
  /** One under each group, or at borders of groups where there is one more. */
  readonly labels: readonly string[];
  readonly x: string;
  /** Logarithmic from 1, or in percent from 0. */
  readonly isLog: boolean;
}

const MARGIN = { left: 52, top: 10, right: 18, bottom: 38 };
/** Pixels for each character of a label, and between two. */
const CHARACTER = 6.4;
const BETWEEN = 10;

export class Bars {
  readonly element = make("div", { className: "bars" });
  private readonly title = make("p", { className: "title" });
  private readonly svg = document.createElementNS("http://www.w3.org/2000/svg", "svg");
  private chart: Chart | null = null;

  constructor() {
    const place = make("div");
    place.append(this.svg);
    this.element.append(this.title, place);
    new ResizeObserver(() => this.paint()).observe(place);
  }

  draw(chart: Chart): void {
    this.chart = chart;
    const keys = chart.series.length > 1 ? chart.series.map(({ name, kind }) => make("span", { className: `swatch ${kind}` }, name)) : [];
    this.title.replaceChildren(make("b", {}, chart.title), ...keys);
    this.paint();
  }

  private paint(): void {
    const { clientWidth: width, clientHeight: height } = this.svg.parentElement!;
    const { chart } = this;
    if (!chart || width < 60 || height < 60) return;
    const [right, bottom] = [width - MARGIN.right, height - MARGIN.bottom];
    const most = Math.max(...chart.series.flatMap(({ values }) => values), chart.isLog ? 10 : 1e-9);
    const top = chart.isLog ? 10 ** Math.ceil(Math.log10(most) - 1e-9) : ceiling(most);
    // One is told from none.
    const share = (value: number): number => (chart.isLog ? (value < 1 ? 0 : (Math.log10(value) + 0.3) / (Math.log10(top) + 0.3)) : value / top);
    const up = (value: number): number => bottom - share(value) * (bottom - MARGIN.top);
    const parts: SVGElement[] = [];
    for (const tick of chart.isLog ? decades(top) : [0, top / 2, top]) {
      parts.push(shape("line", { x1: MARGIN.left, x2: right, y1: up(tick), y2: up(tick) }));
      parts.push(words(chart.isLog ? compact(tick) : `${Number((100 * tick).toPrecision(3))} %`, MARGIN.left - 5, up(tick) + 4, "end"));
    }
    const n = chart.series[0]!.values.length;
    const pitch = (right - MARGIN.left) / n;
    const areBorders = chart.labels.length > n;
    const gap = areBorders ? 0 : 0.15;
    chart.series.forEach(({ kind, name, values }, k) => {
      const wide = (pitch * (1 - 2 * gap)) / chart.series.length;
      values.forEach((value, group) => {
        if (value <= 0) return;
        const x = MARGIN.left + (group + gap) * pitch + k * wide;
        const bar = shape("rect", { x, y: Math.min(up(value), bottom - 1), width: Math.max(1, wide - (areBorders ? 0 : 1)), height: Math.max(1, bottom - up(value)), class: kind });
        const told = document.createElementNS("http://www.w3.org/2000/svg", "title");
        const where = areBorders ? `${chart.labels[group]!} to ${chart.labels[group + 1]!}` : chart.labels[group]!;
        told.textContent = `${where}: ${name} ${chart.isLog ? value.toLocaleString("en") : `${(100 * value).toPrecision(3)} %`}`;
        bar.append(told);
        parts.push(bar);
      });
    });
    const written = chart.labels.filter((label) => label !== "");
    const widest = CHARACTER * Math.max(...written.map(({ length }) => length)) + BETWEEN;
    const every = Math.ceil((widest * written.length) / (right - MARGIN.left));
    let shown = 0;
    chart.labels.forEach((label, k) => {
      if (label === "" || shown++ % every > 0) return;
      parts.push(words(label, MARGIN.left + (k + (areBorders ? 0 : 0.5)) * pitch, bottom + 15));
    });
    parts.push(words(chart.x, (MARGIN.left + right) / 2, bottom + 33));
    this.svg.setAttribute("viewBox", `0 0 ${width} ${height}`);
    this.svg.replaceChildren(...parts);
  }
}

/** A round share that is at least as large. */
function ceiling(value: number): number {
  const decade = 10 ** Math.floor(Math.log10(value));
  return decade * ([1, 2, 4, 6, 8, 10].find((round) => round * decade >= value * (1 - 1e-9)) ?? 10);
}

function decades(top: number): number[] {
  const n = Math.round(Math.log10(top));
  const step = Math.ceil((n + 1) / 5);
  return Array.from({ length: Math.floor(n / step) + 1 }, (_, k) => 10 ** (k * step));
}

function compact(value: number): string {
  return value >= 1e6 ? `${value / 1e6} M` : value >= 1e3 ? `${value / 1e3} k` : String(value);
}

function shape(tag: "line" | "rect" | "text", attributes: Record<string, string | number>): SVGElement {
  const element = document.createElementNS("http://www.w3.org/2000/svg", tag);
  Object.entries(attributes).forEach(([name, value]) => element.setAttribute(name, String(value)));
  return element;
}

function words(text: string, x: number, y: number, anchor = "middle"): SVGElement {
  const element = shape("text", { x, y, "text-anchor": anchor });
  element.textContent = text;
  return element;
}
