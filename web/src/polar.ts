// A polar map: one exitant hemisphere as the disk of (x, y), so that equal areas are equal projected solid angles; both sides seen from
// the room. In: an open file and an incident direction. Out: a picture, and the direction under the pointer.

import type { Direction, Opened } from "./core";
import { fromDisk } from "./directions";
import { paint } from "./scale";

/** Pixels across while still, and while the incident direction moves. */
const FINE = 400;
const COARSE = 200;

export class PolarMap {
  private front = true;

  constructor(
    private readonly canvas: HTMLCanvasElement,
    pointed: (exitant: Direction | null) => void,
  ) {
    canvas.addEventListener("pointermove", (event) => pointed(this.under(event)));
    canvas.addEventListener("pointerdown", (event) => pointed(this.under(event)));
    canvas.addEventListener("pointerleave", () => pointed(null));
  }

  /** The values of the picture, so that both maps can share a scale. */
  values(file: Opened, band: number, incident: Direction, front: boolean, moving: boolean): Float32Array {
    this.front = front;
    return file.hemisphere(band, incident, front, moving ? COARSE : FINE);
  }

  draw(values: Float32Array, highest: number, edges: Uint8Array | null): void {
    const picture = paint(values, highest);
    edges?.forEach((edge, k) => {
      // Half white, half what is there.
      if (edge) for (let c = 4 * k; c < 4 * k + 3; c++) picture.data[c] = (picture.data[c]! + 255) / 2;
    });
    this.canvas.width = this.canvas.height = picture.width;
    this.canvas.getContext("2d")!.putImageData(picture, 0, 0);
  }

  private under(event: PointerEvent): Direction | null {
    const box = this.canvas.getBoundingClientRect();
    const x = (2 * (event.clientX - box.left)) / box.width - 1;
    const y = 1 - (2 * (event.clientY - box.top)) / box.height;
    return fromDisk(x, y, this.front);
  }
}
