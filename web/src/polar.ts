// Polar maps: the exitant hemispheres as disks of (x, y), so that equal areas are equal projected solid angles; both sides seen from the
// room. In: the state. Out: pictures, and the direction under the pointer.

import type { Direction } from "./core";
import { fromDisk } from "./directions";
import { make } from "./dom";
import { Legend } from "./legend";
import { Scale } from "./scale";
import type { State } from "./state";
import type { Set, View } from "./view";

/** Pixels across while still, and while the incident direction moves. */
const FINE = 400;
const COARSE = 200;

export class PolarMaps implements View {
  readonly name = "Polar maps";
  readonly element = make("section");
  private readonly maps: [PolarMap, PolarMap];
  private readonly legend: Legend;

  constructor(set: Set) {
    const pointed = (pointedAt: Direction | null): void => set({ pointedAt });
    this.maps = [new PolarMap("reflection", pointed), new PolarMap("transmission", pointed)];
    this.legend = new Legend(set);
    this.element.append(make("div", { className: "maps" }, ...this.maps.map(({ element }) => element)), this.legend.element);
  }

  draw(state: State): void {
    const n = state.moving ? COARSE : FINE;
    const fronts = [state.incident[2] > 0, state.incident[2] <= 0] as const;
    const file = state.first!;
    const band = file.band(state.band);
    const pictures = fronts.map((front) => file.hemisphere(band, state.incident, front, n));
    // NaN is never larger.
    const largest = pictures.map((values) => values.reduce((most, value) => (value > most ? value : most), 0));
    const scale = Scale.of(state, Math.max(...largest));
    this.maps.forEach((map, k) => {
      const edges = state.edges && !state.moving ? file.edges(band, state.incident, fronts[k]!, n) : null;
      const picture = state.natural
        ? new ImageData(new Uint8ClampedArray(file.colours(band, state.incident, fronts[k]!, n, scale)), n)
        : scale.paint(pictures[k]!);
      map.draw(fronts[k]!, picture, edges, largest[k] === 0);
    });
    this.legend.draw(state, scale);
  }
}

class PolarMap {
  readonly element: HTMLElement;
  private readonly canvas: HTMLCanvasElement;
  private readonly caption = make("figcaption");
  private front = true;

  constructor(
    private readonly id: "reflection" | "transmission",
    pointed: (exitant: Direction | null) => void,
  ) {
    this.canvas = make("canvas", { id });
    this.element = make("figure", {}, this.caption, make("div", { className: "square" }, this.canvas));
    this.canvas.addEventListener("pointermove", (event) => pointed(this.under(event)));
    this.canvas.addEventListener("pointerdown", (event) => pointed(this.under(event)));
    this.canvas.addEventListener("pointerleave", () => pointed(null));
  }

  draw(front: boolean, picture: ImageData, edges: Uint8Array | null, isBlack: boolean): void {
    this.front = front;
    const verb = this.id === "reflection" ? "reflected" : "transmitted";
    this.caption.textContent = `${verb}, ${front ? "into the room (+Z)" : "to outside (−Z)"}${isBlack ? ": nothing" : ""}`;
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
