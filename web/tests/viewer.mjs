// The built viewer in a real browser: files come in by drop, values under the pointer are those of the core as Python has it. What it needs: harness.mjs.

import { basename, join } from "node:path";

import { ask, assert, choose, coloursOnScreen, drop, expectedValues, keep, newPage, readAt, realFiles, settled, show, withViewer } from "./harness.mjs";

const data = realFiles();
const FILES = ["radiance/sawtooth.xml", "pyradiance/t3.xml", "pyradiance/blinds.xml", "frads/ec60.xml"];

await withViewer(async (viewer) => {
  const { page, problems } = await newPage(viewer);
  const made = ["tree.xml", "packed.bsdft", "raw.bsdft"].map((name) => join(viewer.folder, name));
  const program = `
import sys, bsdftree
tree = bsdftree.load(sys.argv[1]).to_tree(4, 4)
for path in sys.argv[2:]:
    tree.save(path, packed=path.endswith("packed.bsdft"))
`;
  ask(program, join(data, "pyradiance/blinds.xml"), ...made);
  for (const file of [...FILES.map((name) => join(data, name)), ...made]) await answersAsTheCore(page, file);
  await lobesAnswerAsTheCore(page, join(data, "pyradiance/blinds.xml"));
  await twoFilesOfADropAreCompared(page);
  await turnsTheDome(page);
  await refusesWhatIsNoBsdf(page);
  assert.deepEqual(problems, [], "no console errors, and nothing asked of others");
});

async function agrees(page, path, pairs) {
  const expected = expectedValues(path, await page.locator("#band").inputValue(), pairs);
  assert.deepEqual(pairs.map((pair) => Number(pair.value)), expected, basename(path));
  assert.ok(expected.some((value) => value > 0), `${basename(path)} has light where it was looked at`);
}

async function answersAsTheCore(page, path) {
  await show(page, path);
  await choose(page, "Polar maps");
  const pairs = [];
  for (const map of ["#reflection", "#transmission"]) {
    // The last lies where straight and mirrored light goes.
    for (const [x, y] of [[0.31, 0.42], [0.5, 0.12], [0.72, 0.66], [0.49, 0.51], [0.5, 0.75]]) pairs.push(await readAt(page, map, x, y));
  }
  await agrees(page, path, pairs);
  assert.ok((await coloursOnScreen(page, "#reflection")) + (await coloursOnScreen(page, "#transmission")) > 4, "maps are not blank");
  console.log(`${basename(path)}: ${await page.locator("#message").textContent()}; ${pairs.length} values agree to the bit`);
}

async function lobesAnswerAsTheCore(page, path) {
  await show(page, path);
  await choose(page, "Lobes");
  const pairs = [];
  // Over the horizon and under it.
  for (const [x, y] of [[0.47, 0.35], [0.53, 0.4], [0.5, 0.7], [0.45, 0.75]]) pairs.push(await readAt(page, "#lobes .space", x, y));
  assert.ok(pairs.every(({ value }) => Number(value) > 0), "the pointer is on lobes");
  await agrees(page, path, pairs);
  assert.ok((await coloursOnScreen(page, "#lobes .space")) > 50, "lobes are not blank");
  await keep(page, "lobes");
}

async function twoFilesOfADropAreCompared(page) {
  await show(page, join(data, "pyradiance/blinds.xml"), join(data, "frads/ec60.xml"));
  assert.equal(await page.locator("#first").inputValue(), "blinds.xml");
  assert.equal(await page.locator("#compared").inputValue(), "ec60.xml");
  await choose(page, "Lobes");
  assert.deepEqual((await page.locator("#lobes .title").allTextContents()).sort(), ["blinds.xml", "ec60.xml"], "lobes beside each other");
  // Straight light, which the second has: over the horizon, left of the axis.
  const { incident, exitant } = await readAt(page, "#lobes .space", 0.73, 0.28);
  const [ec60] = expectedValues(join(data, "frads/ec60.xml"), "Visible", [{ incident, exitant }]);
  const told = await page.locator("#readout").textContent();
  assert.ok(ec60 > 0 && told.includes(`ec60.xml: ${ec60.toPrecision(5)} sr⁻¹`), told);
  await keep(page, "lobes-beside");
}

async function turnsTheDome(page) {
  const theta = async () => Number(await page.locator("#theta").inputValue());
  const before = await theta();
  const box = await page.locator("#dome").boundingBox();
  await page.mouse.move(box.x + 0.5 * box.width, box.y + 0.4 * box.height);
  await page.mouse.down();
  await page.mouse.move(box.x + 0.68 * box.width, box.y + 0.45 * box.height, { steps: 5 });
  await settled(page);
  await page.mouse.up();
  await settled(page);
  const after = await theta();
  assert.notEqual(after, before, "dragging on the dome turns the incident direction");
  await page.locator("#dome").press("ArrowDown");
  await settled(page);
  assert.ok(Math.abs((await theta()) - after - 1) < 1e-2, "an arrow key is a degree");
  await choose(page, "Polar maps");
  await page.locator("#edges").check();
  await settled(page);
  for (const colorScheme of ["light", "dark"]) {
    await page.emulateMedia({ colorScheme });
    await keep(page, `viewer-${colorScheme}`);
  }
}

async function refusesWhatIsNoBsdf(page) {
  await drop(page, { name: "broken.xml", bytes: Buffer.from("<WindowElement><Optical></WindowElement>") });
  await page.waitForSelector("#message.problem");
  const told = await page.locator("#message").textContent();
  assert.match(told, /^broken\.xml: .*(line|byte) \d+/, "the message names file and place");
  console.log(`refused: ${told}`);
}
