// A three-dimensional picture of what is over the device plane: renderer, camera that orbits, labels of the page that stay upright. It is drawn when something
// changed, once a frame, never by itself. Z is up, and towards the room.

import { type Object3D, PerspectiveCamera, Raycaster, Scene, Vector2, Vector3, WebGLRenderer } from "three";
import { OrbitControls } from "three/examples/jsm/controls/OrbitControls.js";

import { make } from "./dom";

export class Space {
  readonly canvas = make("canvas", { tabIndex: 0 });
  readonly element = make("div", { className: "space" }, this.canvas);
  readonly scene = new Scene();
  readonly camera = new PerspectiveCamera(30, 1, 0.1, 30);
  readonly orbit: OrbitControls;
  private readonly renderer: WebGLRenderer;
  private readonly labels: { element: HTMLElement; place: Vector3 }[] = [];
  private pending = 0;

  constructor() {
    this.renderer = new WebGLRenderer({ canvas: this.canvas, antialias: !isSoftware(), alpha: true });
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

  /** Draws before the next frame is shown. */
  redraw(): void {
    cancelAnimationFrame(this.pending);
    this.pending = requestAnimationFrame(() => this.draw());
  }

  /** Draws now; for those who are in a frame already. */
  draw(): void {
    cancelAnimationFrame(this.pending);
    this.renderer.render(this.scene, this.camera);
    const { clientWidth, clientHeight } = this.element;
    for (const { element, place } of this.labels) {
      const { x, y, z } = place.clone().project(this.camera);
      element.hidden = Math.abs(z) > 1;
      element.style.transform = `translate(-50%, -50%) translate(${((x + 1) / 2) * clientWidth}px, ${((1 - y) / 2) * clientHeight}px)`;
    }
  }

  /** A text that stays upright at a place; what is returned moves and changes it. */
  label(text: string, x: number, y: number, z: number): { element: HTMLElement; place: Vector3 } {
    const label = { element: make("span", { className: "label" }, text), place: new Vector3(x, y, z) };
    this.labels.push(label);
    this.element.append(label.element);
    return label;
  }

  /** The ray under the pointer. */
  under({ clientX, clientY }: PointerEvent): Raycaster {
    const box = this.canvas.getBoundingClientRect();
    const caster = new Raycaster();
    caster.setFromCamera(new Vector2((2 * (clientX - box.left)) / box.width - 1, 1 - (2 * (clientY - box.top)) / box.height), this.camera);
    return caster;
  }

  /** How far along that ray the first of these is met, and where; null: none. */
  hit(event: PointerEvent, objects: Object3D[]): Vector3 | null {
    return this.under(event).intersectObjects(objects, false)[0]?.point ?? null;
  }

  /** New buffers, which cost more than a frame. */
  private resize(): void {
    const { clientWidth, clientHeight } = this.element;
    if (clientWidth === 0 || clientHeight === 0) return;
    this.camera.aspect = clientWidth / clientHeight;
    // What matters lies within a ball; a narrow picture must be wide enough for it.
    this.camera.fov = this.camera.aspect < 1 ? 30 / this.camera.aspect : 30;
    this.camera.updateProjectionMatrix();
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
