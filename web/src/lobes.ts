// Lobes: what is reflected and transmitted as surfaces of radius f(ω) over the device plane, with the incident light. In: the state. Out: the
// picture, the exitant direction under the pointer, and another incident direction when the ball at the end of its ray is dragged. Beside the
// ball, the camera orbits. The lobes of a compared file are in a second pane.

import {
  AmbientLight, BufferGeometry, CircleGeometry, ConeGeometry, DirectionalLight, DoubleSide, Group, type Line, LineBasicMaterial, LineLoop, LineSegments, Mesh, MeshBasicMaterial,
  Object3D, SphereGeometry, Vector3,
} from "three";

import type { Direction, Summary } from "./core";
import { fromPolar, MOST_THETA_DEG, stepped, toPolar } from "./directions";
import { make } from "./dom";
import { Legend } from "./legend";
import { type Fineness, Lobe } from "./lobe";
import { Scale, short } from "./scale";
import { type Label, Space } from "./space";
import { showsTheSame, type State } from "./state";
import type { Set, View } from "./view";

/** Cells of the net along an edge, and places asked for along it, at most: while still, and while the incident direction moves. */
const STILL = { cells: 256, places: 512 };
const MOVING = { cells: 64, places: 192 };
/** Of matrices, whose patches are no squares. */
const OF_MATRIX = 128;
const QUIET = 0x8a9099;
const LIGHT = 0xe69f00;
/** How long the incident ray is; lobes end at 1. */
const REACH = 1.15;

export class Lobes implements View {
  readonly name = "Lobes";
  readonly element = make("section", { id: "lobes" });
  private readonly space = new Space((pane) => this.groups.forEach((group, k) => (group.visible = k === pane)));
  /** Reflection and transmission of the file that is shown, and of the one compared with it. */
  private readonly lobes = [0, 1].map(() => [new Lobe(), new Lobe()] as const);
  private readonly groups = this.lobes.map((both) => new Group().add(...both.map(({ mesh }) => mesh)));
  private readonly legend: Legend;
  private readonly ray = new Group();
  private readonly ball = new Object3D();
  private readonly rings: { line: Line; label: Label }[];
  private state: State | null = null;

  constructor(private readonly set: Set) {
    const { space } = this;
    this.legend = new Legend(set);
    this.element.append(space.element, this.legend.element);
    space.canvas.setAttribute("aria-label", "Lobes: drag the ball to move the incident light, drag elsewhere to turn the picture, arrow keys move the incident light");
    const sun = new DirectionalLight(0xffffff, 1.1);
    sun.position.set(-0.6, 0.9, 1);
    space.camera.add(sun);
    space.scene.add(new AmbientLight(0xffffff, 2.2), plane(), ...this.groups, this.ray);
    this.fillRay();
    this.rings = Array.from({ length: 6 }, () => {
      const line = circle();
      space.scene.add(line);
      return { line, label: space.label("", 0, 0, 0) };
    });
    space.label("room +Z", 0, 0, 1.2);
    space.label("outside −Z", 0, 0, -1.2);
    space.label("X right", 1.18, 0, 0);
    space.label("Y up", 0, 1.18, 0);
    this.listen();
  }

  draw(state: State): void {
    const isDrawn = showsTheSame(this.state, state);
    this.state = state;
    if (isDrawn) return;
    const files = [state.first, state.compared].filter((file) => file !== null);
    const fronts = [state.incident[2] > 0, state.incident[2] <= 0] as const;
    const drawn = files.flatMap((file, f) => {
      const fine = fineness(file.summary, state);
      return this.lobes[f]!.map((lobe, k) => ({ lobe, file, front: fronts[k]!, fine, values: lobe.values(file, state, fronts[k]!, fine) }));
    });
    const largest = Math.max(...drawn.map(({ values }) => values.reduce((most, value) => Math.max(most, value), 0)));
    const scale = Scale.of(state, largest);
    drawn.forEach(({ lobe, file, front, fine, values }) => lobe.draw(file, state, front, fine, values, scale));
    this.space.divide(files.length > 1 ? files.map(({ name }) => name) : [""]);
    this.ray.quaternion.setFromUnitVectors(new Vector3(0, 0, 1), new Vector3(...state.incident));
    this.drawRings(scale);
    this.legend.draw(state, scale);
    this.space.draw();
  }

  /** Radii that are worth a label, on the device plane. */
  private drawRings(scale: Scale): void {
    const ticks = [...scale.ticks().filter((tick) => scale.place(tick) > 0.1 && scale.place(tick) < 0.85), scale.highest];
    this.rings.forEach(({ line, label }, k) => {
      const tick = ticks[k];
      line.visible = tick !== undefined;
      label.text = tick === undefined ? "" : short(tick);
      const radius = scale.place(tick ?? 0);
      line.scale.setScalar(radius || 1);
      label.place.set(radius * Math.cos(-0.6), radius * Math.sin(-0.6), 0);
    });
  }

  /** Along +Z, to be turned; light goes to the surface, from the ball. Where lobes hide it, it shines through. */
  private fillRay(): void {
    const line = new BufferGeometry().setFromPoints([new Vector3(), new Vector3(0, 0, REACH)]);
    const head = new ConeGeometry(0.035, 0.12, 16).rotateX(-Math.PI / 2).translate(0, 0, 0.75);
    this.ball.position.z = REACH;
    const handle = new SphereGeometry(0.05, 24, 16);
    for (const look of [{ color: LIGHT }, { color: LIGHT, transparent: true, opacity: 0.45, depthTest: false }]) {
      const ball = new Mesh(handle, new MeshBasicMaterial(look)).translateZ(REACH);
      this.ray.add(new LineSegments(line, new LineBasicMaterial(look)), new Mesh(head, new MeshBasicMaterial(look)), ball);
    }
    this.ray.add(this.ball);
  }

  private listen(): void {
    const { canvas, orbit } = this.space;
    orbit.listenToKeyEvents(canvas);
    let dragging = false;
    // Before those of the orbit, which must not begin.
    canvas.addEventListener("pointerdown", (event) => {
      dragging = this.onBall(event);
      orbit.enabled = !dragging;
      if (dragging) canvas.setPointerCapture(event.pointerId);
      else this.point(event);
    }, { capture: true });
    canvas.addEventListener("pointermove", (event) => {
      if (dragging) this.drag(event);
      else if (event.buttons === 0) this.point(event);
    });
    const release = (): void => {
      if (dragging) this.set({ moving: false });
      dragging = false;
      orbit.enabled = true;
    };
    canvas.addEventListener("pointerup", release);
    canvas.addEventListener("pointercancel", release);
    // A finger that is lifted has read something.
    canvas.addEventListener("pointerleave", (event) => event.pointerType !== "touch" && this.set({ pointedAt: null }));
    canvas.addEventListener("keydown", (event) => {
      // With Shift, the orbit has them.
      const incident = this.state && !event.shiftKey && stepped(this.state.incident, event.key);
      if (!incident) return;
      event.preventDefault();
      this.set({ incident });
    });
  }

  /** Whether the pointer is on the ball, or nearly: fingers are wide. */
  private onBall(event: PointerEvent): boolean {
    const centre = this.ball.getWorldPosition(new Vector3());
    return this.space.under(event).caster.ray.distanceToPoint(centre) < (event.pointerType === "touch" ? 0.16 : 0.09);
  }

  private point(event: PointerEvent): void {
    this.space.canvas.classList.toggle("grab", this.onBall(event));
    const hit = this.space.hit(event, (pane) => this.lobes[pane]!.map(({ mesh }) => mesh).filter(({ visible }) => visible));
    const exitant = hit && hit.length() > 1e-4 ? hit.normalize() : null;
    this.set({ pointedAt: exitant && [exitant.x, exitant.y, exitant.z] });
  }

  /** To where the pointer's ray comes nearest to the dome that the ball is on. */
  private drag(event: PointerEvent): void {
    if (!this.state) return;
    const { ray } = this.space.under(event).caster;
    const front = this.state.incident[2] > 0;
    const near = ray.at(Math.max(0, -ray.origin.dot(ray.direction)), new Vector3());
    const rest = REACH * REACH - near.lengthSq();
    if (rest > 0) near.addScaledVector(ray.direction, -Math.sqrt(rest));
    if (near.z > 0 !== front) near.z = 0;
    const { thetaDeg, phiDeg } = toPolar([near.x, near.y, near.z]);
    const incident: Direction = fromPolar(Math.min(thetaDeg, MOST_THETA_DEG), phiDeg, front);
    this.set({ incident, moving: true, pointedAt: null });
  }
}

/** As fine as the finest tree, so that no leaf is missed; a coarser net has the largest value of each of its cells. */
function fineness({ bands }: Summary, { band, moving }: State): Fineness {
  const components = bands.find(({ name }) => name === band)?.components ?? [];
  const finest = Math.max(64, ...components.map(({ form }) => (form.log2_res === undefined ? OF_MATRIX : 2 ** form.log2_res)));
  const { cells, places } = moving ? MOVING : STILL;
  const n = Math.min(cells, finest);
  return { n, perKnot: Math.min(places, finest) / n };
}

function plane(): Group {
  const material = new MeshBasicMaterial({ color: QUIET, transparent: true, opacity: 0.16, side: DoubleSide, depthWrite: false });
  const axes = new BufferGeometry().setFromPoints(
    [[-1.1, 0, 0], [1.1, 0, 0], [0, -1.1, 0], [0, 1.1, 0], [0, 0, -1.15], [0, 0, 1.15]].map(([x, y, z]) => new Vector3(x, y, z)),
  );
  return new Group().add(new Mesh(new CircleGeometry(1, 96), material), new LineSegments(axes, new LineBasicMaterial({ color: QUIET })));
}

function circle(): LineLoop {
  const points = Array.from({ length: 96 }, (_, k) => new Vector3(Math.cos((k / 48) * Math.PI), Math.sin((k / 48) * Math.PI), 0));
  return new LineLoop(new BufferGeometry().setFromPoints(points), new LineBasicMaterial({ color: QUIET, transparent: true, opacity: 0.7 }));
}
