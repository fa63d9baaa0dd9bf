// The controls beside the views: files, direction, band, component, scale. In: the state. Out: changes of it.

import { fromPolar, toPolar } from "./directions";
import { found } from "./dom";
import type { State, Store } from "./state";

export class Controls {
  private readonly first = found("first", HTMLSelectElement);
  private readonly compared = found("compared", HTMLSelectElement);
  private readonly theta = found("theta", HTMLInputElement);
  private readonly phi = found("phi", HTMLInputElement);
  private readonly side = found("side", HTMLSelectElement);
  private readonly band = found("band", HTMLSelectElement);
  private readonly part = found("part", HTMLSelectElement);
  private readonly scale = found("scale", HTMLSelectElement);
  private readonly natural = found("natural", HTMLSelectElement);
  private readonly edges = found("edges", HTMLInputElement);

  constructor(private readonly store: Store) {
    const { set } = store;
    const file = (select: HTMLSelectElement) => store.state.files.find(({ name }) => name === select.value) ?? null;
    this.first.addEventListener("change", () => set({ first: file(this.first), held: null }));
    this.compared.addEventListener("change", () => set({ compared: file(this.compared) }));
    this.band.addEventListener("change", () => set({ band: this.band.value }));
    this.part.addEventListener("change", () => this.turnTo(this.part.value));
    found("close", HTMLButtonElement).addEventListener("click", () => this.close());
    this.scale.addEventListener("change", () => set({ decades: Number(this.scale.value) }));
    this.natural.addEventListener("change", () => set({ natural: this.natural.value !== "" }));
    this.edges.addEventListener("change", () => set({ edges: this.edges.checked }));
    [this.theta, this.phi].forEach((input) => input.addEventListener("input", () => this.typed()));
    this.side.addEventListener("change", () => this.typed());
  }

  draw(state: State): void {
    const names = state.files.map(({ name }) => name);
    fill(this.first, names, state.first?.name);
    fill(this.compared, ["", ...names.filter((name) => name !== state.first?.name)], state.compared?.name ?? "", "nothing");
    const bands = state.first?.summary.bands ?? [];
    fill(this.band, bands.map(({ name }) => name), state.band);
    fill(this.part, bands.find(({ name }) => name === state.band)?.components.map(({ part }) => part) ?? [], state.part);
    this.scale.value = String(state.decades);
    this.natural.disabled = !bands.some(({ components }) => components.some(({ is_coloured }) => is_coloured));
    this.natural.value = state.natural ? "natural" : "";
    this.edges.checked = state.edges;
    this.side.value = state.incident[2] > 0 ? "front" : "back";
    const { thetaDeg, phiDeg } = toPolar(state.incident);
    // What is being typed is left alone.
    if (document.activeElement !== this.theta) this.theta.value = String(Number(thetaDeg.toFixed(3)));
    if (document.activeElement !== this.phi) this.phi.value = String(Number(phiDeg.toFixed(3)));
  }

  /** Forgets the file that is shown; the next one takes its place. */
  private close(): void {
    const { first, compared, files } = this.store.state;
    const rest = files.filter((file) => file !== first);
    const next = compared ?? rest.at(-1) ?? null;
    this.store.set({ files: rest, first: next, compared: null, held: null, pointedAt: null });
  }

  /** Light comes from the side of a component that is chosen. */
  private turnTo(part: string): void {
    const { first, band, incident } = this.store.state;
    const front = first?.summary.bands.find(({ name }) => name === band)?.components.find((component) => component.part === part)?.incident_front;
    const [x, y, z] = incident;
    this.store.set({ part, incident: (front ?? z > 0) === z > 0 ? incident : [x, y, -z] });
  }

  private typed(): void {
    const { theta, phi } = this;
    if (!theta.validity.valid || !phi.validity.valid || theta.value === "" || phi.value === "") return;
    this.store.set({ incident: fromPolar(theta.valueAsNumber, phi.valueAsNumber, this.side.value === "front") });
  }
}

/** Options as they are now; untouched while they are the same, since an open list closes when it changes. */
function fill(select: HTMLSelectElement, values: string[], chosen: string | undefined, empty = ""): void {
  if (values.join("\n") !== [...select.options].map(({ value }) => value).join("\n") || select.options.length === 0) {
    select.replaceChildren(...values.map((value) => new Option(value.replace(/^(reflection|transmission)_/, "$1 ") || empty, value)));
  }
  select.value = chosen ?? "";
  select.disabled = values.length < 2;
}
