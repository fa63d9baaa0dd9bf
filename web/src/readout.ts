// The value under the pointer, in words. In: the state. Out: text, and the same as data for whoever tests it.

import { toPolar } from "./directions";
import type { State } from "./state";

export function read(place: HTMLElement, { first, compared, band, incident: shown, pointedAt, pointedFrom }: State): void {
  place.dataset["value"] = "";
  if (!first || !pointedAt) {
    place.textContent = "Point at a view to read values.";
    return;
  }
  const incident = pointedFrom ?? shown;
  const from = toPolar(incident);
  const { thetaDeg, phiDeg } = toPolar(pointedAt);
  const coming = pointedFrom ? `from θ ${from.thetaDeg.toFixed(2)}°, φ ${from.phiDeg.toFixed(2)}° ` : "";
  const where = `${coming}to θ ${thetaDeg.toFixed(2)}°, φ ${phiDeg.toFixed(2)}°, ${pointedAt[2] > 0 ? "room" : "outside"}`;
  const cell = first.cell(first.band(band), incident, pointedAt);
  place.dataset["incident"] = incident.join(" ");
  place.dataset["exitant"] = pointedAt.join(" ");
  place.dataset["value"] = String(cell?.value ?? 0);
  const value = cell
    ? `${cell.value.toPrecision(5)} sr⁻¹ ${where}; cell of ${cell.projected_solid_angle.toPrecision(4)} sr, projected`
    : `nothing goes ${where}`;
  const other = compared?.cell(compared.band(band), incident, pointedAt);
  place.textContent = compared ? `${first.name}: ${value}\n${compared.name}: ${(other?.value ?? 0).toPrecision(5)} sr⁻¹` : value;
}
