// The value under the pointer, in words. In: the state. Out: text, and the same as data for whoever tests it.

import { signed } from "./difference";
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
  place.dataset["error"] = String(cell?.standard_error ?? "");
  const error = cell?.standard_error === undefined ? "" : ` ± ${cell.standard_error.toPrecision(2)}`;
  const value = cell
    ? `${cell.value.toPrecision(5)}${error} sr⁻¹ ${where}; cell of ${cell.projected_solid_angle.toPrecision(4)} sr, projected`
    : `nothing goes ${where}`;
  const other = compared?.cell(compared.band(band), incident, pointedAt)?.value ?? 0;
  place.textContent = compared ? `${first.name}: ${value}\n${compared.name}: ${beside(cell?.value ?? 0, other)}` : value;
}

/** What the compared file has there, and how far that is away. */
function beside(value: number, other: number): string {
  const apart = value > 0 ? `, ${signed(other - value)}, ${(other / value).toPrecision(4)} times` : "";
  return `${other.toPrecision(5)} sr⁻¹${apart}`;
}
