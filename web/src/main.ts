// The page: a file comes in by drop or dialog; its views share one incident direction.

import { type Direction, Opened, Refused } from "./core";
import { fromPolar, toPolar } from "./directions";
import { Dome } from "./dome";
import { PolarMap } from "./polar";
import { lowest, paintLegend } from "./scale";
import { showSummary } from "./summary";

function element<T extends HTMLElement>(id: string, kind: new () => T): T {
  const found = document.getElementById(id);
  if (!(found instanceof kind)) throw new Error(`the page has no ${id}`);
  return found;
}

const message = element("message", HTMLElement);
const views = element("views", HTMLElement);
const readout = element("readout", HTMLElement);
const theta = element("theta", HTMLInputElement);
const phi = element("phi", HTMLInputElement);
const side = element("side", HTMLSelectElement);
const band = element("band", HTMLSelectElement);
const edges = element("edges", HTMLInputElement);
const captions = (["reflection", "transmission"] as const).map((id) => element(`${id}-caption`, HTMLElement));

let file: Opened | null = null;
let incident: Direction = fromPolar(30, 90, true);
let pointedAt: Direction | null = null;
let pending = 0;

const dome = new Dome(element("dome", HTMLCanvasElement), (direction, moving) => show(direction, moving));
const maps = (["reflection", "transmission"] as const).map(
  (id) => new PolarMap(element(id, HTMLCanvasElement), (exitant) => {
    pointedAt = exitant;
    read();
  }),
);

/** Draws all views for an incident direction, at most once for each frame. */
function show(direction: Direction, moving: boolean): void {
  incident = direction;
  cancelAnimationFrame(pending);
  pending = requestAnimationFrame(() => draw(moving));
}

function draw(moving: boolean): void {
  if (!file) return;
  const front = incident[2] > 0;
  const { thetaDeg, phiDeg } = toPolar(incident);
  if (document.activeElement !== theta) theta.value = String(Number(thetaDeg.toFixed(3)));
  if (document.activeElement !== phi) phi.value = String(Number(phiDeg.toFixed(3)));
  side.value = front ? "front" : "back";
  const opened = file;
  const where = (exitantFront: boolean): string => (exitantFront ? "into the room (+Z)" : "to outside (−Z)");
  const fronts = [front, !front];
  const pictures = maps.map((map, k) => map.values(opened, band.selectedIndex, incident, fronts[k]!, moving));
  // NaN is never larger.
  const peaks = pictures.map((values) => values.reduce((most, value) => (value > most ? value : most), 0));
  const highest = Math.max(...peaks);
  captions.forEach((caption, k) => {
    const verb = k === 0 ? "reflected" : "transmitted";
    caption.textContent = `${verb}, ${where(fronts[k]!)}${peaks[k] === 0 ? ": nothing" : ""}`;
  });
  maps.forEach((map, k) => {
    const marks = edges.checked && !moving
      ? opened.edges(band.selectedIndex, incident, fronts[k]!, Math.round(Math.sqrt(pictures[k]!.length)))
      : null;
    map.draw(pictures[k]!, highest || 1, marks);
  });
  element("range", HTMLElement).textContent =
    highest > 0 ? `${lowest(highest).toPrecision(3)} to ${highest.toPrecision(3)} sr⁻¹` : "black";
  dome.show(incident);
  read();
}

/** The value under the pointer. */
function read(): void {
  readout.dataset["value"] = "";
  if (!file || !pointedAt) {
    readout.textContent = "Point at a map.";
    return;
  }
  const { thetaDeg, phiDeg } = toPolar(pointedAt);
  const place = `θ ${thetaDeg.toFixed(2)}°, φ ${phiDeg.toFixed(2)}°`;
  const cell = file.cell(band.selectedIndex, incident, pointedAt);
  readout.dataset["incident"] = incident.join(" ");
  readout.dataset["exitant"] = pointedAt.join(" ");
  readout.dataset["value"] = String(cell?.value ?? 0);
  readout.textContent = cell
    ? `${cell.value.toPrecision(5)} sr⁻¹ at ${place}\ncell of ${cell.projected_solid_angle.toPrecision(4)} sr, projected`
    : `nothing goes to ${place}`;
}

async function open(given: File): Promise<void> {
  message.className = "";
  message.textContent = `reading ${given.name} …`;
  const begun = performance.now();
  try {
    const opened = await Opened.open(given.name, new Uint8Array(await given.arrayBuffer()));
    file = opened;
  } catch (error) {
    message.className = "problem";
    message.textContent = error instanceof Refused ? `${given.name}: ${error.message}` : `${given.name} cannot be read: ${String(error)}`;
    return;
  }
  showSummary(element("summary", HTMLElement), given.name, file.summary);
  band.replaceChildren(...file.summary.bands.map(({ name }) => new Option(name)));
  band.hidden = file.summary.bands.length < 2;
  views.hidden = false;
  const first = file.summary.bands[0]?.components[0];
  const { thetaDeg, phiDeg } = toPolar(incident);
  show(fromPolar(thetaDeg, phiDeg, first?.incident_front ?? true), false);
  message.textContent = `${given.name}, read in ${Math.round(performance.now() - begun)} ms`;
}

function typed(): void {
  if (!theta.validity.valid || !phi.validity.valid || theta.value === "" || phi.value === "") return;
  show(fromPolar(theta.valueAsNumber, phi.valueAsNumber, side.value === "front"), false);
}

[theta, phi].forEach((input) => input.addEventListener("input", typed));
side.addEventListener("change", typed);
[band, edges].forEach((input) => input.addEventListener("change", () => show(incident, false)));
element("file", HTMLInputElement).addEventListener("change", (event) => {
  const given = (event.target as HTMLInputElement).files?.[0];
  if (given) void open(given);
});
document.addEventListener("dragover", (event) => {
  event.preventDefault();
  document.body.classList.add("dragging");
});
document.addEventListener("dragleave", () => document.body.classList.remove("dragging"));
document.addEventListener("drop", (event) => {
  event.preventDefault();
  document.body.classList.remove("dragging");
  const given = event.dataTransfer?.files[0];
  if (given) void open(given);
});
paintLegend(element("legend", HTMLCanvasElement));
