// The dome of incident directions over the device plane. In: a direction. Out: another, when it is dragged or moved by arrow keys.

import {
  AmbientLight, ArrowHelper, CircleGeometry, Color, DoubleSide, EdgesGeometry, LineBasicMaterial, LineSegments, Mesh, MeshBasicMaterial,
  PerspectiveCamera, Raycaster, Scene, SphereGeometry, Vector2, Vector3, WebGLRenderer,
} from "three";

import type { Direction } from "./core";
import { fromPolar, MOST_THETA_DEG, stepped, toPolar } from "./directions";

export class Dome {
  private readonly renderer: WebGLRenderer;
  private readonly scene = new Scene();
  private readonly camera = new PerspectiveCamera(32, 1, 0.1, 20);
  private readonly half: LineSegments;
  private readonly arrow = new ArrowHelper(new Vector3(0, 0, 1), new Vector3(), 1, 0xe69f00, 0.12, 0.07);
  private direction: Direction = [0, 0, 1];

  constructor(
    private readonly canvas: HTMLCanvasElement,
    private readonly moved: (incident: Direction, moving: boolean) => void,
  ) {
    this.renderer = new WebGLRenderer({ canvas, antialias: true, alpha: true });
    this.camera.up.set(0, 0, 1);
    const line = new LineBasicMaterial({ color: new Color(0x8a9099), transparent: true, opacity: 0.6 });
    const sphere = new SphereGeometry(1, 24, 9, 0, 2 * Math.PI, 0, Math.PI / 2).rotateX(Math.PI / 2);
    this.half = new LineSegments(new EdgesGeometry(sphere, 1), line);
    const plane = new MeshBasicMaterial({ color: 0x8a9099, transparent: true, opacity: 0.3, side: DoubleSide });
    const axes = [new Vector3(1, 0, 0), new Vector3(0, 1, 0)].map(
      (axis, k) => new ArrowHelper(axis, new Vector3(), 1.15, k === 0 ? 0xd55e00 : 0x009e73, 0.08, 0.05),
    );
    this.scene.add(this.half, new Mesh(new CircleGeometry(1, 64), plane), this.arrow, new AmbientLight(), ...axes);
    this.listen();
    new ResizeObserver(() => this.resize()).observe(canvas);
  }

  show(direction: Direction): void {
    this.direction = direction;
    const side = direction[2] > 0 ? 1 : -1;
    this.half.scale.z = side;
    this.camera.position.set(0.9, -2.9, 2.6 * side);
    this.camera.lookAt(0, 0, 0.3 * side);
    this.arrow.setDirection(new Vector3(...direction));
    this.draw();
  }

  /** New buffers, which cost more than a frame. */
  private resize(): void {
    const edge = this.canvas.clientWidth;
    if (edge === 0) return;
    this.renderer.setPixelRatio(window.devicePixelRatio);
    this.renderer.setSize(edge, edge, false);
    this.draw();
  }

  private draw(): void {
    this.renderer.render(this.scene, this.camera);
  }

  private listen(): void {
    this.canvas.addEventListener("pointerdown", (event) => {
      this.canvas.setPointerCapture(event.pointerId);
      this.drag(event, true);
    });
    this.canvas.addEventListener("pointermove", (event) => {
      if (event.buttons & 1) this.drag(event, true);
    });
    this.canvas.addEventListener("pointerup", () => this.moved(this.direction, false));
    this.canvas.addEventListener("keydown", (event) => {
      const stepTo = stepped(this.direction, event.key);
      if (!stepTo) return;
      event.preventDefault();
      this.moved(stepTo, false);
    });
  }

  /** Where the pointer's ray first meets the dome; beside it, nothing. */
  private drag(event: PointerEvent, moving: boolean): void {
    const box = this.canvas.getBoundingClientRect();
    const place = new Vector2((2 * (event.clientX - box.left)) / box.width - 1, 1 - (2 * (event.clientY - box.top)) / box.height);
    const caster = new Raycaster();
    caster.setFromCamera(place, this.camera);
    const { origin, direction: ray } = caster.ray;
    const b = origin.dot(ray);
    const rest = b * b - origin.lengthSq() + 1;
    if (rest < 0) return;
    const hit = origin.clone().addScaledVector(ray, -b - Math.sqrt(rest)).normalize();
    const front = this.direction[2] > 0;
    const { thetaDeg, phiDeg } = toPolar([hit.x, hit.y, front === hit.z > 0 ? hit.z : 0]);
    this.moved(fromPolar(Math.min(thetaDeg, MOST_THETA_DEG), phiDeg, front), moving);
  }
}
