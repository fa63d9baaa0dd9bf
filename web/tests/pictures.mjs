// The pictures of docs/view.md and the README: `npm run pictures`, after `make web`; with names after `--`, only those. Devices are made by seeds, so that
// nothing but the viewer changes them.

import { execFileSync } from "node:child_process";
import { statSync, writeFileSync } from "node:fs";
import { join } from "node:path";
import { fileURLToPath } from "node:url";
import { choose, newPage, python, settled, show, withViewer } from "./harness.mjs";

const docs = fileURLToPath(new URL("../../docs/img", import.meta.url));
/** Bytes. */
const MOST = 250_000;
const MADE = [
  "generate --device prism --tile --log2-res 5 --samples 500 --seed 1 -o prism.xml",
  "generate --device blinds:angle=30 --tile --log2-res 4 --samples 1000 --seed 1 -o blinds.xml",
  "reduce blinds.xml -o small.xml --l1 20",
];
/** Name, colours, files, θ, φ, side, tab, and what else is pressed. */
const PICTURES = [
  ["lobes", "light", ["prism.xml"], 40, 90, "front", "Lobes"],
  ["polar", "dark", ["blinds.xml"], 40, 90, "back", "Polar maps", (page) => page.locator("#edges").check()],
  ["slice", "light", ["prism.xml"], 40, 90, "front", "Slice"],
  ["tree", "dark", ["blinds.xml"], 40, 90, "back", "Tree", (page) => page.locator("#part").selectOption("transmission_front")],
  ["compare", "light", ["blinds.xml", "small.xml"], 40, 90, "back", "Compare", (page) => page.waitForSelector("#compare tr[data-found]")],
  ["totals", "dark", ["prism.xml"], 40, 90, "front", "Totals"],
  ["mosaic", "light", ["blinds.xml"], 40, 90, "back", "Mosaic", (page) => page.locator("#part").selectOption("transmission_front")],
];

await withViewer(async (viewer) => {
  for (const line of MADE) execFileSync(python, ["-m", "bsdftree", ...line.split(" ")], { cwd: viewer.folder, stdio: "ignore" });
  const wanted = process.argv.slice(2);
  for (const [name, colorScheme, files, thetaDeg, phiDeg, side, tab, press] of PICTURES) {
    if (wanted.length > 0 && !wanted.includes(name)) continue;
    const { page } = await newPage(viewer, { colorScheme });
    await show(page, ...files.map((file) => join(viewer.folder, file)));
    await page.locator("#side").selectOption(side);
    await page.locator("#theta").fill(String(thetaDeg));
    await page.locator("#phi").fill(String(phiDeg));
    await choose(page, tab);
    await press?.(page);
    // Finer drawings follow those of drags.
    await page.waitForTimeout(500);
    await settled(page);
    const path = join(docs, `view-${name}.png`);
    writeFileSync(path, await page.screenshot());
    const { size } = statSync(path);
    console.log(`${path}: ${size} bytes`);
    if (size > MOST) throw new Error(`more than ${MOST}`);
    await page.close();
  }
});
