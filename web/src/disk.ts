// One hemisphere as a disk: a picture with rings of θ, where mirrored or straight light goes, a narrow peak, and a cursor. In: a picture, the
// state. Out: the direction under the pointer, or where arrow keys moved the cursor.

import type { Direction } from "./core";
import { fromDisk } from "./directions";
import { make, svg } from "./dom";
import type { State } from "./state";

/** What an arrow key moves the cursor by, of the radius; ten times that with Shift. */
const STEP = 0.01;

export class Disk {
  readonly element: HTMLElement;
  private readonly canvas: HTMLCanvasElement;
  private readonly caption = make("figcaption");
  private readonly mirror = new Cross("mirror", 0.05, 0.02);
  private readonly needle = svg("circle", { class: "needle", r: 0.03 });
  private readonly cursor = new Cross("cursor", 0.09, 0.03);
  private front = true;
  private incident: Direction = [0, 0, 1];
  private pointedAt: Direction | null = null;

  constructor(
    private readonly kind: "reflection" | "transmission",
    private readonly pointed: (exitant: Direction | null) => void,
    id = "",
  ) {
    this.canvas = make("canvas", { tabIndex: 0, ...(id && { id }) });
    // Two drawings, one on the other, so that rings are not drawn again with each mark.
    const look = { viewBox: "-1 -1 2 2", "aria-hidden": "true" };
    const [still, marks] = [svg("svg", look), svg("svg", look)];
    still.append(...rings());
    marks.append(this.mirror.element, this.needle, this.cursor.element);
    const disk = make("div", { className: "disk" }, this.canvas);
    disk.append(still, marks);
    this.element = make("figure", {}, this.caption, make("div", { className: "square" }, disk));
    for (const kind of ["pointermove", "pointerdown"] as const) this.canvas.addEventListener(kind, (event) => pointed(this.under(event)));
    // A finger that is lifted has read something.
    this.canvas.addEventListener("pointerleave", (event) => event.pointerType !== "touch" && pointed(null));
    this.canvas.addEventListener("keydown", (event) => this.press(event));
  }

  get width(): number {
    return this.canvas.clientWidth;
  }

  draw(front: boolean, picture: ImageData, edges: Uint8Array | null, isBlack: boolean): void {
    this.front = front;
    const verb = this.kind === "reflection" ? "reflected" : "transmitted";
    const caption = `${verb}, ${front ? "into the room (+Z)" : "to outside (−Z)"}${isBlack ? ": nothing" : ""}`;
    if (caption !== this.caption.textContent) {
      this.caption.textContent = caption;
      this.canvas.setAttribute("aria-label", `${caption}; arrow keys move a cursor`);
    }
    if (edges) mark(picture, edges);
    if (this.canvas.width !== picture.width) this.canvas.width = this.canvas.height = picture.width;
    this.canvas.getContext("2d")!.putImageData(picture, 0, 0);
  }

  /** Rings a pixel of n × n that is easily overlooked; −1: none. */
  ring(pixel: number, n: number): void {
    this.needle.setAttribute("visibility", pixel < 0 ? "hidden" : "visible");
    this.needle.setAttribute("cx", String((2 * (pixel % n) + 1) / n - 1));
    this.needle.setAttribute("cy", String((2 * Math.floor(pixel / n) + 1) / n - 1));
  }

  /** Shows where mirrored or straight light goes, and the cursor if it is on this side. */
  point({ incident, pointedAt }: State): void {
    this.incident = incident;
    this.pointedAt = pointedAt && pointedAt[2] > 0 === this.front ? pointedAt : null;
    this.mirror.move([-incident[0], -incident[1]]);
    this.cursor.move(this.pointedAt);
  }

  private under(event: PointerEvent): Direction | null {
    const box = this.canvas.getBoundingClientRect();
    return fromDisk((2 * (event.clientX - box.left)) / box.width - 1, 1 - (2 * (event.clientY - box.top)) / box.height, this.front);
  }

  private press(event: KeyboardEvent): void {
    const move = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] }[event.key];
    if (!move) return;
    event.preventDefault();
    const [x, y] = this.pointedAt ?? [-this.incident[0], -this.incident[1]];
    const step = event.shiftKey ? 10 * STEP : STEP;
    const next = fromDisk(x + step * move[0]!, y + step * move[1]!, this.front);
    if (!next) return;
    // Keys may come faster than frames.
    this.pointedAt = next;
    this.pointed(next);
  }
}

/** Four strokes about a place, which stays free; dark ones beneath, so that they are seen on any colour. */
class Cross {
  readonly element = svg("g", {});
  private readonly strokes: readonly SVGElement[];
  private at = "";

  constructor(
    kind: string,
    private readonly outer: number,
    private readonly inner: number,
  ) {
    this.strokes = ["beneath", kind].map((name) => svg("path", { class: name }));
    this.element.append(...this.strokes);
  }

  move(place: readonly number[] | null): void {
    const at = place ? this.path(place[0]!, -place[1]!) : "";
    if (at !== this.at) this.strokes.forEach((stroke) => stroke.setAttribute("d", at));
    this.at = at;
  }

  private path(x: number, y: number): string {
    const { inner, outer } = this;
    return [[1, 0], [-1, 0], [0, 1], [0, -1]].map(([u, v]) => `M${x + inner * u!} ${y + inner * v!}L${x + outer * u!} ${y + outer * v!}`).join("");
  }
}

/** Borders of cells, light on dark and dark on light. */
function mark({ data }: ImageData, edges: Uint8Array): void {
  edges.forEach((edge, k) => {
    if (!edge) return;
    const light = 0.2 * data[4 * k]! + 0.7 * data[4 * k + 1]! + 0.1 * data[4 * k + 2]! > 140 ? 0 : 255;
    for (let c = 4 * k; c < 4 * k + 3; c++) data[c] = (data[c]! + light) / 2;
  });
}

/** θ of 30° and 60°, and the axes' names. */
function rings(): SVGElement[] {
  const circles = [30, 60].flatMap((theta) => {
    const r = Math.sin((theta * Math.PI) / 180);
    return [svg("circle", { r, cx: 0, cy: 0 }), words(`${theta}°`, r * Math.SQRT1_2, -r * Math.SQRT1_2)];
  });
  return [...circles, words("X", 0.96, 0.015), words("Y", 0, -0.94)];
}

function words(text: string, x: number, y: number): SVGElement {
  const element = svg("text", { x, y });
  element.textContent = text;
  return element;
}
