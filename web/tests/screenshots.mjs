// Every view as it was: its canvases beside stored ones, by tolerance; text is left out, since fonts differ between machines.
//
// `npm run screenshots` stores what is drawn now, after which somebody looks at it. Pictures are stored an eighth as large in area: what is to be seen is
// that something else is drawn, not that another release of Chromium rounds otherwise. To be sure that this would be seen, each is also compared with what
// another incident direction gives.

import { mkdirSync, readFileSync, readdirSync, rmSync, writeFileSync } from "node:fs";
import { join } from "node:path";
import { fileURLToPath } from "node:url";
import { assert, choose, newPage, realFiles, settled, show, withViewer } from "./harness.mjs";

const stored = fileURLToPath(new URL("screenshots", import.meta.url));
const renew = process.argv.includes("--renew");
const data = realFiles();
/** Pixels across, at most. */
const WIDTH = 160;
/** A pixel differs if a channel does by more than this of 255, … */
const LEAST = 40;
/** … and a picture if more than this part of its pixels do; at another scale, without hints for fonts, up to 0.03 do. */
const MOST = 0.04;
/** Views that are looked at in dark too, as drawings and with WebGL. */
const IN_DARK = ["Lobes", "Slice"];
const NO_TEXT = ".view, .view * { -webkit-text-fill-color: transparent !important } .view svg text { visibility: hidden !important }";

await withViewer(async (viewer) => {
  const files = ["blinds.xml", "blindsT3.xml"].map((name) => join(data, "pyradiance", name));
  const taken = new Map();
  for (const colorScheme of ["light", "dark"]) {
    const { page, problems } = await newPage(viewer, { colorScheme, bypassCSP: true });
    await page.addStyleTag({ content: NO_TEXT });
    await show(page, ...files);
    const views = colorScheme === "light" ? await page.getByRole("tab").allTextContents() : IN_DARK;
    for (const [name, picture] of await canvases(page, views, 35)) taken.set(`${colorScheme}-${name}`, picture);
    if (colorScheme === "light") await wouldTell(page, taken, await canvases(page, ["Polar maps"], 75));
    assert.deepEqual(problems, []);
    await page.close();
  }
  if (renew) return store(taken);
  const names = readdirSync(stored).map((file) => file.replace(".png", ""));
  assert.deepEqual([...taken.keys()].sort(), names.sort(), "views are those stored; if others are meant: npm run screenshots");
  await areAsStored(await viewer.browser.newPage(), taken);
});

/** The pictures in views and the dome, by name, at an angle of incidence. */
async function canvases(page, views, thetaDeg) {
  await page.locator("#theta").fill(String(thetaDeg));
  await settled(page);
  const pictures = new Map([["dome", await still(page, page.locator("#dome"))]]);
  for (const tab of views) {
    await choose(page, tab);
    // Drawings over canvases are seen with these.
    const drawn = page.locator(".view:visible").locator("canvas:visible, svg:visible:not(canvas ~ svg)");
    let n = 0;
    for (const place of await drawn.all()) {
      // Bars of legends are no pictures.
      if ((await place.boundingBox()).height < 60) continue;
      pictures.set(`${tab.toLowerCase().replaceAll(/[^a-z0-9]+/g, "-")}-${++n}`, await still(page, place));
    }
  }
  return pictures;
}

/** A part of the page when it has stopped changing, as a small PNG. */
async function still(page, place) {
  let before;
  for (let n = 0; n < 20; n++) {
    const now = await place.screenshot();
    if (before?.equals(now)) break;
    before = now;
    await settled(page);
  }
  const base64 = await page.evaluate(async ({ base64, width }) => {
    const bitmap = await createImageBitmap(new Blob([Uint8Array.from(atob(base64), (c) => c.charCodeAt(0))]));
    const scale = Math.min(1, width / bitmap.width);
    const canvas = new OffscreenCanvas(Math.round(scale * bitmap.width), Math.round(scale * bitmap.height));
    const context = canvas.getContext("2d");
    context.imageSmoothingQuality = "high";
    context.drawImage(bitmap, 0, 0, canvas.width, canvas.height);
    const bytes = new Uint8Array(await (await canvas.convertToBlob()).arrayBuffer());
    return btoa(Array.from(bytes, (byte) => String.fromCharCode(byte)).join(""));
  }, { base64: before.toString("base64"), width: WIDTH });
  return Buffer.from(base64, "base64");
}

/** The part of the pixels of two pictures that differ; they may be of a little different size, as fonts beside them are. */
function difference(page, one, other) {
  return page.evaluate(async ({ pictures, least }) => {
    const bitmaps = await Promise.all(
      pictures.map((base64) => createImageBitmap(new Blob([Uint8Array.from(atob(base64), (c) => c.charCodeAt(0))]))),
    );
    const { width, height } = bitmaps[0];
    const [a, b] = bitmaps.map((bitmap) => {
      const context = new OffscreenCanvas(width, height).getContext("2d");
      context.drawImage(bitmap, 0, 0, width, height);
      return context.getImageData(0, 0, width, height).data;
    });
    let n = 0;
    for (let k = 0; k < a.length; k += 4) n += [0, 1, 2].some((c) => Math.abs(a[k + c] - b[k + c]) > least);
    return n / (width * height);
  }, { pictures: [one, other].map((picture) => picture.toString("base64")), least: LEAST });
}

/** That maps of one incident direction are farther from those of another than is tolerated. */
async function wouldTell(page, taken, others) {
  for (const [name, other] of others) {
    if (name === "dome") continue;
    const far = await difference(page, taken.get(`light-${name}`), other);
    assert.ok(far > MOST, `${name}: another direction changes ${percent(far)} of its pixels, which would not be seen`);
  }
}

async function areAsStored(page, taken) {
  const found = [];
  for (const [name, picture] of taken) found.push([await difference(page, readFileSync(join(stored, `${name}.png`)), picture), name]);
  found.sort(([a], [b]) => b - a);
  const far = found.filter(([part]) => part > MOST).map(([part, name]) => `${name}: ${percent(part)} of its pixels`);
  assert.deepEqual(far, [], "pictures are as stored, or, if they should not be: npm run screenshots");
  console.log(`${found.length} pictures are as stored; the farthest is ${found[0][1]}, by ${percent(found[0][0])} of its pixels`);
}

function store(taken) {
  rmSync(stored, { recursive: true, force: true });
  mkdirSync(stored);
  for (const [name, picture] of taken) writeFileSync(join(stored, `${name}.png`), picture);
  console.log(`stored ${taken.size} pictures; look at them`);
}

function percent(part) {
  return `${(100 * part).toFixed(2)} %`;
}
