// A three-dimensional picture of what is over the device plane: renderer, camera that orbits, labels of the page that stay upright. It has one
// pane, or two of the same camera beside each other. It is drawn when something changed, once a frame, never by itself. Z is up, and towards the room.

import { type Object3D, PerspectiveCamera, Raycaster, Scene, Vector2, Vector3, WebGLRenderer } from "three";
import { OrbitControls } from "three/examples/jsm/controls/OrbitControls.js";

import { make } from "./dom";

/** A text at a place, in each pane. */
export interface Label {
  text: string;
  readonly place: Vector3;
}

/** In pixels of the page, from the upper left. */
interface Pane {
  left: number;
  top: number;
  width: number;
  height: number;
}

/** Degrees that a pane sees upwards, or across if it is narrow. */
const FIELD_DEG = 30;

export class Space {
  readonly canvas = make("canvas", { tabIndex: 0 });
  readonly element = make("div", { className: "space" }, this.canvas);
  readonly scene = new Scene();
  readonly camera = new PerspectiveCamera(FIELD_DEG, 1, 0.1, 30);
  readonly orbit: OrbitControls;
  private readonly renderer: WebGLRenderer;
  private readonly labels: Label[] = [];
  private titles: readonly string[] = [""];
  private written: HTMLElement[] = [];
  private pending = 0;

  /** `prepare` makes the scene that of a pane. */
  constructor(private readonly prepare: (pane: number) => void) {
    this.renderer = new WebGLRenderer({ canvas: this.canvas, antialias: !isSoftware(), alpha: true });
    this.renderer.setScissorTest(true);
    this.camera.up.set(0, 0, 1);
    this.camera.position.set(1.8, -4.3, 1.6);
    this.scene.add(this.camera);
    this.orbit = new OrbitControls(this.camera, this.canvas);
    this.orbit.enablePan = false;
    this.orbit.minDistance = 1.5;
    this.orbit.maxDistance = 12;
    this.orbit.addEventListener("change", () => this.redraw());
    new ResizeObserver(() => this.resize()).observe(this.element);
  }

  /** A pane for each title; a single one needs none. */
  divide(titles: readonly string[]): void {
    if (titles.join("\n") === this.titles.join("\n")) return;
    this.titles = titles;
    this.aim();
  }

  /** Draws before the next frame is shown. */
  redraw(): void {
    cancelAnimationFrame(this.pending);
    this.pending = requestAnimationFrame(() => this.draw());
  }

  /** Draws now; for those who are in a frame already. */
  draw(): void {
    cancelAnimationFrame(this.pending);
    const { clientHeight } = this.element;
    const panes = this.panes();
    panes.forEach(({ left, top, width, height }, k) => {
      this.prepare(k);
      this.renderer.setViewport(left, clientHeight - top - height, width, height);
      this.renderer.setScissor(left, clientHeight - top - height, width, height);
      this.renderer.render(this.scene, this.camera);
    });
    this.write(panes);
  }

  /** A text that stays upright; what is returned is moved and changed. */
  label(text: string, x: number, y: number, z: number): Label {
    const label = { text, place: new Vector3(x, y, z) };
    this.labels.push(label);
    return label;
  }

  /** The pane and the ray under the pointer. */
  under({ clientX, clientY }: PointerEvent): { pane: number; caster: Raycaster } {
    const box = this.canvas.getBoundingClientRect();
    const [x, y] = [clientX - box.left, clientY - box.top];
    const panes = this.panes();
    const pane = Math.max(0, panes.findIndex(({ left, top, width, height }) => x >= left && x < left + width && y >= top && y < top + height));
    const { left, top, width, height } = panes[pane]!;
    const caster = new Raycaster();
    caster.setFromCamera(new Vector2((2 * (x - left)) / width - 1, 1 - (2 * (y - top)) / height), this.camera);
    return { pane, caster };
  }

  /** Where the ray under the pointer first meets what is of its pane; null: nowhere. */
  hit(event: PointerEvent, objects: (pane: number) => Object3D[]): Vector3 | null {
    const { pane, caster } = this.under(event);
    return caster.intersectObjects(objects(pane), false)[0]?.point ?? null;
  }

  /** Beside each other, or one above the other where there is more place so. */
  private panes(): Pane[] {
    const { clientWidth, clientHeight } = this.element;
    const n = this.titles.length;
    const isWide = clientWidth >= clientHeight;
    const [width, height] = isWide ? [clientWidth / n, clientHeight] : [clientWidth, clientHeight / n];
    return this.titles.map((_, k) => ({ left: isWide ? k * width : 0, top: isWide ? 0 : k * height, width, height }));
  }

  /** Elements are kept, and touched only where they change: what is set costs painting even if it is the same. */
  private write(panes: Pane[]): void {
    const texts = panes.flatMap(({ left, top, width, height }, k) => [
      { text: this.titles[k]!, kind: "label title", x: left + width / 2, y: top + 10 },
      ...this.labels.map(({ text, place }) => {
        const { x, y, z } = place.clone().project(this.camera);
        return { text: Math.abs(z) > 1 ? "" : text, kind: "label", x: left + ((x + 1) / 2) * width, y: top + ((1 - y) / 2) * height };
      }),
    ]);
    if (texts.length !== this.written.length) {
      this.written.forEach((element) => element.remove());
      this.written = texts.map(({ kind }) => make("span", { className: kind }));
      this.element.append(...this.written);
    }
    texts.forEach(({ text, x, y }, k) => {
      const element = this.written[k]!;
      if (element.textContent !== text) element.textContent = text;
      const at = `translate(-50%, -50%) translate(${x.toFixed(1)}px, ${y.toFixed(1)}px)`;
      if (element.dataset["at"] !== at) element.style.transform = element.dataset["at"] = at;
    });
  }

  /** What matters lies within a ball; a narrow pane must be wide enough for it. */
  private aim(): void {
    const { width, height } = this.panes()[0]!;
    if (width === 0 || height === 0) return;
    const aspect = width / height;
    this.camera.aspect = aspect;
    this.camera.fov = aspect < 1 ? (2 * Math.atan(Math.tan((FIELD_DEG * Math.PI) / 360) / aspect) * 180) / Math.PI : FIELD_DEG;
    this.camera.updateProjectionMatrix();
  }

  /** New buffers, which cost more than a frame. */
  private resize(): void {
    const { clientWidth, clientHeight } = this.element;
    if (clientWidth === 0 || clientHeight === 0) return;
    this.aim();
    this.renderer.setPixelRatio(window.devicePixelRatio);
    this.renderer.setSize(clientWidth, clientHeight, false);
    this.draw();
  }
}

/** Whether there is no graphics card: then smooth borders cost a third of the frames. */
function isSoftware(): boolean {
  const gl = document.createElement("canvas").getContext("webgl2");
  const asked = gl?.getExtension("WEBGL_debug_renderer_info");
  const name = gl && asked ? String(gl.getParameter(asked.UNMASKED_RENDERER_WEBGL)) : "";
  gl?.getExtension("WEBGL_lose_context")?.loseContext();
  return /swiftshader|llvmpipe|software/i.test(name);
}
