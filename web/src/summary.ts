// What is in a file, as a list of terms.

import type { Component, Opened, Summary } from "./core";
import { make } from "./dom";
import type { State } from "./state";
import type { View } from "./view";

export class FileView implements View {
  readonly name = "File";
  readonly element = make("section", { id: "summary" });
  private shown: Opened[] = [];

  draw({ first, compared }: State): void {
    const files = [first, compared].filter((file) => file !== null);
    if (files.length === this.shown.length && files.every((file, k) => file === this.shown[k])) return;
    this.shown = files;
    this.element.replaceChildren(...files.map((file) => described(file.name, file.summary)));
  }
}

function described(fileName: string, summary: Summary): HTMLElement {
  const place = make("article", {}, make("h2", {}, summary.name || fileName));
  place.append(terms([["file", fileName], ["manufacturer", summary.manufacturer]]));
  const components = summary.bands.flatMap(({ name, components }) =>
    components.map((component) => make("section", {}, make("h3", {}, `${component.part.replace("_", " ")}, ${name}`), terms(figures(component)))),
  );
  place.append(make("div", { className: "components" }, ...components));
  place.append(...summary.notes.map(({ repaired, what }) => make("p", { className: "hint" }, `${repaired ? "repaired" : "note"}: ${what}`)));
  return place;
}

function figures({ form, ...component }: Component): [string, string][] {
  const shape: [string, string][] =
    form.rank === undefined
      ? [["matrix", `${form.incident_basis} (${form.n_incident}) to ${form.exitant_basis} (${form.n_exitant})`]]
      : [
          ["tree", `rank ${form.rank}, finest 2^${form.log2_res} per axis`],
          ["leaves", form.n_leaves!.toLocaleString("en")],
        ];
  return [
    ...shape,
    ["largest", `${component.maximum.toPrecision(4)} sr⁻¹`],
    ["diffuse part", `${(100 * component.lambertian).toFixed(1)} %`],
    ["colour", component.is_coloured ? "yes" : "no"],
  ];
}

function terms(pairs: [string, string][]): HTMLElement {
  const told = pairs.filter(([, text]) => text !== "");
  return make("dl", {}, ...told.flatMap(([term, text]) => [make("dt", {}, term), make("dd", {}, text)]));
}
