// What is in a file, as a list of terms. Text goes in as text, never as markup.

import type { Component, Summary } from "./core";

export function showSummary(place: HTMLElement, fileName: string, summary: Summary): void {
  place.replaceChildren(heading(summary.name || fileName));
  place.append(terms([["file", fileName], ["manufacturer", summary.manufacturer]]));
  for (const band of summary.bands) {
    for (const component of band.components) {
      place.append(heading(`${component.part.replace("_", " ")}, ${band.name}`), terms(described(component)));
    }
  }
  for (const note of summary.notes) {
    const line = document.createElement("p");
    line.className = "hint";
    line.textContent = `${note.repaired ? "repaired" : "note"}: ${note.what}`;
    place.append(line);
  }
}

function described({ form, ...component }: Component): [string, string][] {
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

function heading(text: string): HTMLElement {
  const heading = document.createElement("h2");
  heading.textContent = text;
  return heading;
}

function terms(pairs: [string, string][]): HTMLElement {
  const list = document.createElement("dl");
  for (const [term, text] of pairs.filter(([, text]) => text !== "")) {
    const [dt, dd] = [document.createElement("dt"), document.createElement("dd")];
    dt.textContent = term;
    dd.textContent = text;
    list.append(dt, dd);
  }
  return list;
}
