// What the page shows: one state that every control changes and every view draws. In: changes. Out: one drawing for each frame at most.

import type { Direction, Opened } from "./core";
import { fromPolar } from "./directions";

export interface State {
  /** All that is open, in the order of opening. */
  readonly files: readonly Opened[];
  /** What is shown, one of `files`; null before the first file. */
  readonly first: Opened | null;
  /** What it is compared with, another of `files`, or null. */
  readonly compared: Opened | null;
  readonly incident: Direction;
  /** The exitant direction under the pointer, in whatever view. */
  readonly pointedAt: Direction | null;
  /** The incident direction of the pair under the pointer where that is not `incident`: in views of all of them. */
  readonly pointedFrom: Direction | null;
  /** Name of a band of `first`; `file.band(name)` numbers it, −1 where a compared file has none of that name. */
  readonly band: string;
  /** The component of views that show one whole component, one of `first`'s in `band`: "reflection_back" … */
  readonly part: string;
  /** Powers of ten that logarithmic scales span; 0: linear ones. */
  readonly decades: number;
  /** The value [1/sr] at the top of the scale, held by the user; null: the largest that is shown. */
  readonly held: number | null;
  /** Colours as the eye sees them, where a component has them, or the map of false ones. */
  readonly natural: boolean;
  /** Whether borders of cells are drawn. */
  readonly edges: boolean;
  /** True during a drag: draw coarser, to keep up; a drawing in full follows. */
  readonly moving: boolean;
}

export type Change = Partial<State>;

export class Store {
  private current: State = {
    files: [],
    first: null,
    compared: null,
    incident: fromPolar(30, 90, true),
    pointedAt: null,
    pointedFrom: null,
    band: "",
    part: "",
    decades: 4,
    held: null,
    natural: false,
    edges: false,
    moving: false,
  };
  private pending = 0;

  constructor(private readonly draw: (state: State) => void) {}

  get state(): State {
    return this.current;
  }

  /** Changes the state and draws in the next frame. A function, to be handed to views. */
  readonly set = (change: Change): void => {
    // Views of one incident direction say nothing of it.
    const from = "pointedAt" in change ? { pointedFrom: null } : {};
    this.current = consistent({ ...this.current, ...from, ...change });
    cancelAnimationFrame(this.pending);
    this.pending = requestAnimationFrame(() => this.draw(this.current));
  };
}

/** The same with a band and a component that the shown file has. */
function consistent(state: State): State {
  const { first } = state;
  if (!first) return state;
  const compared = state.compared === first ? null : state.compared;
  const band = first.summary.bands.find(({ name }) => name === state.band) ?? first.summary.bands[0];
  const component = band?.components.find(({ part }) => part === state.part) ?? band?.components[0];
  return { ...state, compared, band: band?.name ?? "", part: component?.part ?? "" };
}

/** Whether two states differ in nothing but what is pointed at: then a picture stays. */
export function showsTheSame(one: State | null, other: State): boolean {
  if (!one) return false;
  const pointing = new Set<keyof State>(["pointedAt", "pointedFrom"]);
  return (Object.keys(other) as (keyof State)[]).every((key) => pointing.has(key) || one[key] === other[key]);
}
