// The dome of incident directions over the device plane, drawn in parallel projection. In: a direction. Out: another, when it is dragged or
// moved by arrow keys. The ball on the dome is where light comes from, and the arrow which way it goes.

import type { Direction } from "./core";
import { fromPolar, MOST_THETA_DEG, stepped, toPolar } from "./directions";
import { svg } from "./dom";

/** To where the eye is, over the horizon; under it for the other side. */
const EYE: Direction = [0.22, -0.72, 0.66];

type Point = readonly [number, number];

export class Dome {
  // Two drawings, one on the other, so that the ground is not drawn again with each ray.
  private readonly ground = svg("svg", { "aria-hidden": "true" });
  private readonly ray = svg("svg", { class: "incident", "aria-hidden": "true" });
  private direction: Direction = [0, 0, 1];
  /** Of what the ground was drawn for. */
  private front: boolean | null = null;

  constructor(
    private readonly element: HTMLElement,
    private readonly moved: (incident: Direction, moving: boolean) => void,
  ) {
    element.append(this.ground, this.ray);
    this.listen();
  }

  show(direction: Direction): void {
    this.direction = direction;
    const front = direction[2] > 0;
    const eye = new Eye(front);
    if (front !== this.front) {
      this.ground.replaceChildren(...ground(eye, front));
      // What is far from the horizon is seen to its side only.
      for (const picture of [this.ground, this.ray]) picture.setAttribute("viewBox", `-1.25 ${front ? -1.08 : -0.8} 2.5 1.88`);
    }
    this.front = front;
    const [x, y] = eye.project(direction);
    const length = Math.hypot(x, y) || 1;
    const [ex, ey] = [x / length, y / length];
    // The tip is half-way in.
    const [tx, ty] = [0.42 * x, 0.42 * y];
    const wing = (side: number): string => `${tx + 0.12 * ex - side * 0.05 * ey} ${ty + 0.12 * ey + side * 0.05 * ex}`;
    this.ray.replaceChildren(
      path(`M0 0L${x} ${y}`, "ray"),
      path(`M${tx} ${ty}L${wing(1)}L${wing(-1)}Z`, "head"),
      svg("circle", { cx: x, cy: y, r: 0.065 }),
    );
  }

  private listen(): void {
    const { element } = this;
    element.addEventListener("pointerdown", (event) => {
      element.setPointerCapture(event.pointerId);
      this.drag(event, true);
    });
    element.addEventListener("pointermove", (event) => {
      if (event.buttons & 1) this.drag(event, true);
    });
    element.addEventListener("pointerup", () => this.moved(this.direction, false));
    element.addEventListener("pointercancel", () => this.moved(this.direction, false));
    element.addEventListener("keydown", (event) => {
      const incident = stepped(this.direction, event.key);
      if (!incident) return;
      event.preventDefault();
      this.moved(incident, false);
    });
  }

  /** To the point of the dome under the pointer; beside it, to its border. */
  private drag(event: PointerEvent, moving: boolean): void {
    const { x, y } = new DOMPoint(event.clientX, event.clientY).matrixTransform(this.ground.getScreenCTM()!.inverse());
    const front = this.direction[2] > 0;
    const { thetaDeg, phiDeg } = toPolar(new Eye(front).onDome([x, y], front));
    this.direction = fromPolar(Math.min(thetaDeg, MOST_THETA_DEG), phiDeg, front);
    this.moved(this.direction, moving);
  }
}

/** Parallel projection to a picture with y downwards. */
class Eye {
  private readonly near: Direction;
  private readonly right: Direction;
  private readonly up: Direction;

  constructor(front: boolean) {
    const [x, y, z] = EYE;
    const length = Math.hypot(x, y, z);
    this.near = [x / length, y / length, (front ? z : -z) / length];
    const [nx, ny, nz] = this.near;
    const flat = Math.hypot(nx, ny);
    this.right = [-ny / flat, nx / flat, 0];
    const [rx, ry] = this.right;
    this.up = [-nz * ry, nz * rx, flat];
  }

  project(direction: Direction): Point {
    return [dot(direction, this.right), -dot(direction, this.up)];
  }

  /** The point of the unit sphere that is seen there, on the side asked for, down to the horizon. */
  onDome([a, b]: Point, front: boolean): Direction {
    const outside = Math.max(1, Math.hypot(a, b));
    const [u, v] = [a / outside, -b / outside];
    const w = Math.sqrt(Math.max(0, 1 - u * u - v * v));
    const [x, y, z] = [0, 1, 2].map((c) => u * this.right[c]! + v * this.up[c]! + w * this.near[c]!) as [number, number, number];
    return [x, y, z > 0 === front ? z : 0];
  }
}

/** What does not change with the direction: circles of θ, half circles of φ, the device plane, axes. */
function ground(eye: Eye, front: boolean): SVGElement[] {
  const arc = (points: Direction[]): string => `M${points.map((point) => eye.project(point).map((c) => c.toFixed(3)).join(" ")).join("L")}`;
  const circle = (thetaDeg: number): Direction[] => Array.from({ length: 73 }, (_, k) => fromPolar(thetaDeg, 5 * k, front));
  const meridian = (phiDeg: number): Direction[] => Array.from({ length: 19 }, (_, k) => fromPolar(5 * k, phiDeg, front));
  const nets = [30, 60].map((theta) => path(arc(circle(theta)), "net"));
  const meridians = Array.from({ length: 12 }, (_, k) => path(arc(meridian(30 * k)), "net"));
  const z = front ? 1 : -1;
  const axes: [Direction, string][] = [[[1.12, 0, 0], "X"], [[0, 1.12, 0], "Y"], [[0, 0, 1.12 * z], front ? "room" : "outside"]];
  const named = axes.flatMap(([end, name]) => {
    const [x, y] = eye.project(end.map((c) => c * (name.length > 1 ? 1.2 : 1.08)) as unknown as Direction);
    // Beside the vertical axis, where the ball seldom is.
    const text = svg("text", { x: x - (name.length > 1 ? 0.3 : 0), y: y + 0.045 });
    text.textContent = name;
    return [path(arc([[0, 0, 0], end]), "axis"), text];
  });
  return [path(`${arc(circle(90))}Z`, "plane"), ...nets, ...meridians, ...named];
}

function path(d: string, kind: string): SVGElement {
  return svg("path", { d, class: kind });
}

function dot(a: Direction, b: Direction): number {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}
