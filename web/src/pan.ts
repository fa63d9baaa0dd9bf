// A plane seen through a canvas: drags and arrow keys pan, wheel, pinch, + and − zoom at the pointer, Home shows all. In: events. Out: the frame, and points that are
// clicked or pointed at. Units are the plane's; a frame is in CSS pixels.

/** The point of the plane in the middle of the canvas, and pixels for each unit. */
export interface Frame {
  x: number;
  y: number;
  scale: number;
}

export interface Point {
  x: number;
  y: number;
}

interface Listener {
  /** The frame is another; `busy` during a gesture. */
  framed(busy: boolean): void;
  clicked(point: Point): void;
  /** Null when the pointer leaves. */
  pointed(point: Point | null): void;
}

/** Pixels that a pointer may move in a click. */
const STILL = 4;
/** What one press of a key or a button, and one pixel of a wheel, zooms. */
const STEP = Math.SQRT2;
const WHEEL = 0.0018;
/** Around the plane when all of it is in sight. */
const MARGIN = 12;

export class Pan {
  frame: Frame = { x: 0, y: 0, scale: 1 };
  private size: Point = { x: 1, y: 1 };
  private largest = 1;
  private readonly down = new Map<number, Point>();
  private moved = 0;

  constructor(
    private readonly canvas: HTMLCanvasElement,
    private readonly listener: Listener,
  ) {
    canvas.addEventListener("pointerdown", (event) => this.press(event));
    canvas.addEventListener("pointermove", (event) => this.move(event));
    canvas.addEventListener("pointerup", (event) => this.release(event));
    canvas.addEventListener("pointercancel", (event) => this.down.delete(event.pointerId));
    canvas.addEventListener("pointerleave", () => listener.pointed(null));
    canvas.addEventListener("dblclick", (event) => this.zoom(4, offset(event, canvas)));
    canvas.addEventListener("keydown", (event) => this.key(event));
    canvas.addEventListener(
      "wheel",
      (event) => {
        event.preventDefault();
        // Lines and pages to pixels.
        const pixels = event.deltaY * [1, 16, 400][event.deltaMode]!;
        this.zoom(Math.exp(-WHEEL * pixels * (event.ctrlKey ? 5 : 1)), offset(event, canvas));
      },
      { passive: false },
    );
  }

  /** A plane of another size; `finest`: the most pixels for each unit. */
  plane(size: Point, finest: number): void {
    this.size = size;
    this.largest = finest;
    this.whole();
  }

  /** All of the plane. */
  whole(): void {
    this.frame = { x: this.size.x / 2, y: this.size.y / 2, scale: this.smallest };
    this.listener.framed(false);
  }

  /** Whether all of it is in sight. */
  get isWhole(): boolean {
    return this.frame.scale <= this.smallest * 1.0001;
  }

  /** From buttons. */
  step(inwards: boolean): void {
    this.zoom(inwards ? STEP * STEP : 1 / (STEP * STEP), { x: 0, y: 0 });
  }

  /** Keeps the frame in bounds when the canvas changes. */
  bound(): void {
    const { frame, size } = this;
    frame.scale = Math.min(Math.max(frame.scale, this.smallest), this.largest);
    // In the middle when all is in sight; else the middle of the canvas stays over the plane.
    const inside = (c: number, n: number): number => (this.isWhole ? n / 2 : Math.min(Math.max(c, 0), n));
    frame.x = inside(frame.x, size.x);
    frame.y = inside(frame.y, size.y);
  }

  private get smallest(): number {
    const fit = Math.min((this.canvas.clientWidth - 2 * MARGIN) / this.size.x, (this.canvas.clientHeight - 2 * MARGIN) / this.size.y);
    return Math.max(fit, 1e-3);
  }

  /** The point under an offset from the canvas's middle. */
  private at({ x, y }: Point): Point {
    return { x: this.frame.x + x / this.frame.scale, y: this.frame.y + y / this.frame.scale };
  }

  /** What is under the offset stays there. */
  private zoom(by: number, at: Point): void {
    const fixed = this.at(at);
    const scale = Math.min(Math.max(this.frame.scale * by, this.smallest), this.largest);
    this.frame = { x: fixed.x - at.x / scale, y: fixed.y - at.y / scale, scale };
    this.bound();
    this.listener.framed(true);
  }

  private pan(x: number, y: number): void {
    this.frame.x -= x / this.frame.scale;
    this.frame.y -= y / this.frame.scale;
    this.bound();
    this.listener.framed(true);
  }

  private press(event: PointerEvent): void {
    this.canvas.setPointerCapture(event.pointerId);
    if (this.down.size === 0) this.moved = 0;
    this.down.set(event.pointerId, offset(event, this.canvas));
    this.listener.pointed(this.at(offset(event, this.canvas)));
  }

  private move(event: PointerEvent): void {
    const now = offset(event, this.canvas);
    const before = this.down.get(event.pointerId);
    if (before && event.buttons & 1) {
      this.down.set(event.pointerId, now);
      this.moved += Math.hypot(now.x - before.x, now.y - before.y);
      const other = [...this.down].find(([id]) => id !== event.pointerId)?.[1];
      if (other) {
        const apart = (p: Point): number => Math.hypot(p.x - other.x, p.y - other.y);
        this.zoom(apart(now) / Math.max(1, apart(before)), { x: (now.x + other.x) / 2, y: (now.y + other.y) / 2 });
      } else if (this.moved > STILL) this.pan(now.x - before.x, now.y - before.y);
    }
    this.listener.pointed(this.at(now));
  }

  private release(event: PointerEvent): void {
    const isClick = this.down.size === 1 && this.moved <= STILL;
    this.down.delete(event.pointerId);
    if (isClick) this.listener.clicked(this.at(offset(event, this.canvas)));
    else this.listener.framed(false);
  }

  private key(event: KeyboardEvent): void {
    const step = 60;
    const pan = { ArrowLeft: [step, 0], ArrowRight: [-step, 0], ArrowUp: [0, step], ArrowDown: [0, -step] }[event.key];
    if (pan) this.pan(pan[0]!, pan[1]!);
    else if (event.key === "+" || event.key === "=") this.zoom(STEP, { x: 0, y: 0 });
    else if (event.key === "-") this.zoom(1 / STEP, { x: 0, y: 0 });
    else if (event.key === "Home") this.whole();
    else if (event.key === "Enter") this.listener.clicked(this.at({ x: 0, y: 0 }));
    else return;
    event.preventDefault();
  }
}

/** From the canvas's middle. */
function offset(event: MouseEvent, canvas: HTMLCanvasElement): Point {
  const box = canvas.getBoundingClientRect();
  return { x: event.clientX - box.left - box.width / 2, y: event.clientY - box.top - box.height / 2 };
}
