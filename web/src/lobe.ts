// One hemisphere as a surface of radius f(ω). In: an open file, an incident direction, a scale. Out: a mesh over the net of knots that the core gives.

import { BufferAttribute, BufferGeometry, Color, DoubleSide, DynamicDrawUsage, Mesh, MeshLambertMaterial, SRGBColorSpace, Sphere, Vector3 } from "three";

import type { Opened } from "./core";
import { type Scale, VIRIDIS_PIXELS } from "./scale";
import type { State } from "./state";

/** What three.js mixes: colours in proportion to light. */
const LINEAR = Float32Array.from({ length: 256 }, (_, c) => new Color().setRGB(c / 255, 0, 0, SRGBColorSpace).r);

/** Cells along an edge of the net, and places that are asked along an edge of each. */
export interface Fineness {
  readonly n: number;
  readonly perKnot: number;
}

/** A net, and what of it does not change with the incident direction. */
interface Net {
  geometry: BufferGeometry;
  knots: Float32Array;
}

export class Lobe {
  readonly mesh = new Mesh(new BufferGeometry(), new MeshLambertMaterial({ vertexColors: true, flatShading: true, side: DoubleSide }));
  private readonly nets = new Map<string, Net>();

  /** Values at the knots, so that both lobes can share a scale. */
  values(file: Opened, state: State, front: boolean, { n, perKnot }: Fineness): Float32Array {
    return file.lobe(file.band(state.band), state.incident, front, n, perKnot);
  }

  draw(file: Opened, state: State, front: boolean, { n }: Fineness, values: Float32Array, scale: Scale): void {
    this.mesh.visible = values.some((value) => value > 0);
    if (!this.mesh.visible) return;
    const { geometry, knots } = this.net(file, front, n);
    const places = geometry.getAttribute("position") as BufferAttribute;
    const colours = geometry.getAttribute("color") as BufferAttribute;
    const natural = state.natural ? file.lobeColours(file.band(state.band), state.incident, front, n, scale) : null;
    const [xyz, rgb] = [places.array, colours.array];
    for (let k = 0; k < values.length; k++) {
      const radius = scale.place(values[k]!);
      const pixel = VIRIDIS_PIXELS[Math.round(255 * radius)]!;
      for (let c = 0; c < 3; c++) {
        xyz[3 * k + c] = radius * knots[3 * k + c]!;
        rgb[3 * k + c] = LINEAR[natural ? natural[4 * k + c]! : (pixel >> (8 * c)) & 255]!;
      }
    }
    places.needsUpdate = colours.needsUpdate = true;
    this.mesh.geometry = geometry;
  }

  private net(file: Opened, front: boolean, n: number): Net {
    const key = `${front} ${n}`;
    const net = this.nets.get(key) ?? netOf(file.knots(front, n));
    this.nets.set(key, net);
    return net;
  }
}

function netOf(knots: Float32Array): Net {
  const edge = Math.sqrt(knots.length / 3);
  const triangles: number[] = [];
  for (let k = 0; k < edge - 1; k++) {
    for (let l = 0; l < edge - 1; l++) {
      const corner = k * edge + l;
      triangles.push(corner, corner + edge, corner + 1, corner + 1, corner + edge, corner + edge + 1);
    }
  }
  const geometry = new BufferGeometry();
  for (const name of ["position", "color"]) {
    geometry.setAttribute(name, new BufferAttribute(new Float32Array(knots.length), 3).setUsage(DynamicDrawUsage));
  }
  geometry.setIndex(triangles);
  geometry.boundingSphere = new Sphere(new Vector3(), 1);
  return { geometry, knots };
}
