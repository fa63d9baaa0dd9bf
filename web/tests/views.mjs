// Views beyond the maps in a real browser: what slices and totals tell is what the core has as Python has it; the page serves keys, touch, small screens. What it
// needs: harness.mjs.

import { join } from "node:path";

import { ask, assert, choose, coloursOnScreen, expectedValues, keep, newPage, readAt, realFiles, settled, show, withViewer } from "./harness.mjs";

const data = realFiles();
const blinds = join(data, "pyradiance/blinds.xml");
const t3 = join(data, "pyradiance/t3.xml");

await withViewer(async (viewer) => {
  const { page, problems } = await newPage(viewer);
  for (const path of [blinds, t3]) await slicesAnswerAsTheCore(page, path);
  await totalsAnswerAsTheCore(page);
  await aHeldScaleStays(page);
  await coloursAreAsSeen(page, viewer.folder);
  await needlesAreSeen(page, viewer.folder);
  await show(page, blinds);
  await lobesAreTurnedAndLit(page);
  await keysReachEverything(page);
  for (const size of [{ width: 1280, height: 720 }, { width: 820, height: 1180 }]) await nothingScrolls(page, size);
  await touchMovesTheLight(viewer, problems);
  assert.deepEqual(problems, [], "no console errors, and nothing asked of others");
});

async function slicesAnswerAsTheCore(page, path) {
  await show(page, path);
  await choose(page, "Slice");
  const pairs = [];
  for (const x of [0.1, 0.3, 0.42, 0.5, 0.66, 0.9]) for (const y of [0.2, 0.8]) pairs.push(await readAt(page, "#slice svg", x, y));
  const expected = expectedValues(path, await page.locator("#band").inputValue(), pairs);
  assert.deepEqual(pairs.map(({ value }) => Number(value)), expected, path);
  assert.ok(expected.some((value) => value > 0), "there is light in the slice");
  // In the plane of incidence.
  for (const { incident, exitant } of pairs) {
    const [[ix, iy], [ox, oy]] = [incident, exitant].map((text) => text.split(" ").map(Number));
    assert.ok(Math.abs(ix * oy - iy * ox) < 1e-9);
  }
  await keep(page, "slice");
}

async function totalsAnswerAsTheCore(page) {
  await show(page, blinds);
  await page.locator("#side").selectOption("front");
  await choose(page, "Totals");
  for (const [k, front] of [[0, true], [1, false]]) {
    const told = await page.locator("#totals .told").nth(k).textContent();
    const [, theta, reflected, transmitted] = told.match(/θ ([\d.]+)°: reflected ([\d.]+), transmitted ([\d.]+)/).map(Number);
    const program = `
import json, math, sys, bsdftree
bsdf = bsdftree.load(sys.argv[1])
# The middle of the plot's degree.
theta, sign = math.radians(int(float(sys.argv[2])) + 0.5), float(sys.argv[3])
incident = [0.0, math.sin(theta), sign * math.cos(theta)]
print(json.dumps([float(bsdf.hemispherical(incident, part)) for part in ("reflection", "transmission")]))
`;
    const expected = JSON.parse(ask(program, blinds, String(theta), front ? "1" : "-1"));
    assert.ok(Math.abs(reflected - expected[0]) < 1e-4 && Math.abs(transmitted - expected[1]) < 1e-4, `${told}, and Python has ${expected}`);
    assert.ok(reflected > 0 && transmitted > 0);
  }
  // A click on a plot is another angle of incidence, from the side of that plot.
  const plot = page.locator("#totals svg").nth(1);
  const { width, height } = await plot.boundingBox();
  await plot.click({ position: { x: width / 2, y: height / 2 } });
  await settled(page);
  assert.equal(await page.locator("#side").inputValue(), "back");
  assert.ok(Math.abs(Number(await page.locator("#theta").inputValue()) - 45) < 6);
  await keep(page, "totals");
}

async function aHeldScaleStays(page) {
  await choose(page, "Polar maps");
  const highest = () => page.locator(".view:not([hidden]) .legend .ticks span").last().textContent();
  const turn = async (theta) => {
    await page.locator("#theta").fill(String(theta));
    await settled(page);
  };
  await turn(20);
  const first = await highest();
  await page.locator(".view:not([hidden])").getByLabel("hold scale").check();
  await turn(80);
  assert.equal(await highest(), first, "held");
  await page.locator("#scale").selectOption("linear");
  await settled(page);
  assert.equal(await page.locator(".view:not([hidden]) .legend .ticks span").first().textContent(), "0", "linear scales begin at 0");
  await page.locator("#scale").selectOption("log, 4 decades");
  await page.locator(".view:not([hidden])").getByLabel("hold scale").uncheck();
  await settled(page);
  assert.notEqual(await highest(), first, "let go");
}

/** The ball moves the light, what is beside it turns the picture alone, as do keys with Shift. */
async function lobesAreTurnedAndLit(page) {
  await choose(page, "Lobes");
  await page.locator("#side").selectOption("front");
  await page.locator("#theta").fill("30");
  await settled(page);
  const space = page.locator("#lobes .space");
  const picture = async () => (await space.screenshot()).toString("base64");
  const box = await space.boundingBox();
  const drag = async (x, y, dx, dy) => {
    await page.mouse.move(box.x + x, box.y + y);
    await page.mouse.down();
    await page.mouse.move(box.x + x + dx, box.y + y + dy, { steps: 4 });
    await page.mouse.up();
    await settled(page);
  };
  const theta = async () => Number(await page.locator("#theta").inputValue());

  let before = await picture();
  await drag(40, box.height - 40, 120, 20);
  assert.equal(await theta(), 30, "turning leaves the light");
  assert.notEqual(await picture(), before, "the picture turns");
  before = await picture();
  await page.locator("#lobes .space canvas").press("Shift+ArrowLeft");
  await settled(page);
  assert.equal(await theta(), 30);
  assert.notEqual(await picture(), before, "the picture turns by keys");
  const [x, y] = await page.evaluate(topOfTheBall, await picture());
  await drag(x, y + 8, 40, 30);
  assert.ok(Math.abs((await theta()) - 30) > 2, `the ball at ${x}, ${y} moves the light`);
}

/** In the page: the highest pixel of the ball's colour. */
async function topOfTheBall(base64) {
  const bitmap = await createImageBitmap(new Blob([Uint8Array.from(atob(base64), (c) => c.charCodeAt(0))]));
  const context = new OffscreenCanvas(bitmap.width, bitmap.height).getContext("2d");
  context.drawImage(bitmap, 0, 0);
  const { data } = context.getImageData(0, 0, bitmap.width, bitmap.height);
  for (let k = 0; k < data.length; k += 4) {
    const [r, g, b] = data.slice(k, k + 3);
    if (Math.abs(r - 0xe6) < 4 && Math.abs(g - 0x9f) < 4 && b < 8) return [(k / 4) % bitmap.width, Math.floor(k / 4 / bitmap.width)];
  }
  throw new Error("there is no ball");
}

async function keysReachEverything(page) {
  await page.locator("#tabs [aria-selected=true]").focus();
  await page.keyboard.press("3");
  await settled(page);
  assert.ok(await page.locator("#slice").isVisible(), "a digit is a view");
  await page.locator("#slice .plot").focus();
  await page.keyboard.press("ArrowRight");
  await settled(page);
  assert.match(await page.locator("#readout").textContent(), /sr⁻¹|nothing goes/, "arrow keys move the cursor of a plot");
  await page.locator("#tabs [aria-selected=true]").focus();
  await page.keyboard.press("ArrowLeft");
  await settled(page);
  assert.ok(await page.locator("#reflection").isVisible(), "arrow keys move along the tabs");
  await page.locator("#reflection").press("Shift+ArrowRight");
  await settled(page);
  const before = await page.locator("#readout").getAttribute("data-exitant");
  await page.locator("#reflection").press("ArrowRight");
  await settled(page);
  assert.notEqual(await page.locator("#readout").getAttribute("data-exitant"), before, "arrow keys move the cursor of a map");
  await page.keyboard.press("?");
  assert.ok(await page.locator("#help").isVisible(), "? is help");
  assert.match(await page.locator("#help").textContent(), /room.*away from the surface/s);
  await keep(page, "help");
  await page.keyboard.press("Escape");
  assert.ok(!(await page.locator("#help").isVisible()), "Escape ends it");
}

async function nothingScrolls(page, size) {
  await page.setViewportSize(size);
  for (const colorScheme of ["light", "dark"]) {
    await page.emulateMedia({ colorScheme });
    for (const tab of await page.getByRole("tab").allTextContents()) {
      await choose(page, tab);
      const over = await page.evaluate(() => {
        const root = document.documentElement;
        const view = document.querySelector(".view:not([hidden])");
        return { page: root.scrollHeight > innerHeight || root.scrollWidth > innerWidth, view: view.id !== "summary" && view.scrollHeight > view.clientHeight + 1 };
      });
      assert.deepEqual(over, { page: false, view: false }, `${tab} at ${size.width} × ${size.height}`);
      assert.ok((await coloursOnScreen(page, "#stage")) > 10, `${tab} is not blank`);
      await keep(page, `${tab.toLowerCase().replaceAll(" ", "-")}-${colorScheme}-${size.width}`);
    }
  }
}

/** Red where light is red; chosen components turn the light to their side. */
async function coloursAreAsSeen(page, folder) {
  const red = join(folder, "red.xml");
  const program = `
import sys
from bsdftree.cli import main
main(["from-function", "r", "g", "b", "-c", "reflection_back", "-c", "transmission_front", "--log2-res", "3", "-o", sys.argv[1],
      "-e", "r(ix,iy,iz,ox,oy,oz)=.3; g(ix,iy,iz,ox,oy,oz)=if(oy,.02,.3); b(ix,iy,iz,ox,oy,oz)=.02;"], standalone_mode=False)
`;
  ask(program, red);
  await show(page, red);
  await choose(page, "Polar maps");
  const pixel = (x, y) =>
    page.locator("#reflection").evaluate((canvas, [x, y]) => [...canvas.getContext("2d").getImageData(x * canvas.width, y * canvas.height, 1, 1).data], [x, y]);
  assert.equal(await page.locator("#natural").inputValue(), "natural", "a coloured file is shown as seen");
  await page.locator("#side").selectOption("front");
  await page.locator("#scale").selectOption("linear");
  await settled(page);
  const [up, down] = [await pixel(0.5, 0.3), await pixel(0.5, 0.7)];
  assert.ok(up[0] > 3 * up[1], `red above: ${up}`);
  assert.ok(down[1] > 0.7 * down[0] && down[0] > 2 * down[2], `yellow below: ${down}`);
  await page.locator("#part").selectOption("transmission_front");
  await settled(page);
  assert.equal(await page.locator("#side").inputValue(), "back", "light comes from the component's side");
  await page.getByRole("button", { name: "close this file" }).click();
  await settled(page);
  assert.notEqual(await page.locator("#first").inputValue(), "red.xml");
}

/** A mirror's peak, a few leaves of 2⁻⁸, is seen in lobes, in maps, where it is ringed, and beside another file. */
async function needlesAreSeen(page, folder) {
  const needle = join(folder, "needle.xml");
  const program = `
import sys
from bsdftree.cli import main
main(["from-function", "needle", "--rank", "3", "-c", "reflection_back", "--log2-res", "8", "--tolerance", "0.1", "-o", sys.argv[1],
      "-e", "sq(x)=x*x; needle(ix,iy,iz,ox,oy,oz)=.01+1000*exp(-(sq(ix+ox)+sq(iy+oy))/.00002);"], standalone_mode=False)
`;
  ask(program, needle);
  await show(page, needle);
  await page.locator("#side").selectOption("front");
  const largest = async (tab, selector) => {
    await choose(page, tab);
    return Number(await page.locator(selector).last().textContent());
  };
  const inLobes = await largest("Lobes", "#lobes .ticks span");
  const inMaps = await largest("Polar maps", ".view:not([hidden]) .legend .ticks span");
  assert.equal(await page.locator(".disk:has(#reflection) .needle").getAttribute("visibility"), "visible");
  await keep(page, "needle");
  await show(page, needle, blinds);
  const beside = await largest("Compare", "#compare .legends > :first-child .ticks span");
  assert.ok(inLobes > 50 && inMaps > 50 && beside > 50, `${inLobes}, ${inMaps} and ${beside} at the top of scales`);
}

async function touchMovesTheLight(viewer, problems) {
  const { page, problems: more } = await newPage(viewer, { viewport: { width: 820, height: 1180 }, hasTouch: true });
  await show(page, blinds);
  const before = await page.locator("#theta").inputValue();
  const { x, y, width, height } = await page.locator("#dome").boundingBox();
  await page.touchscreen.tap(x + 0.62 * width, y + 0.62 * height);
  await settled(page);
  assert.notEqual(await page.locator("#theta").inputValue(), before, "a finger on the dome moves the light");
  problems.push(...more);
}
