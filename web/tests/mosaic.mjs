// The mosaic in a real browser: what is under the pointer is what the core has for the pair of directions that is told, and has its colour, in sight of all and of
// one cell; a click takes a tile's direction. What it needs: harness.mjs.

import { basename, join } from "node:path";

import { assert, ask, choose, expectedValues, keep, newPage, readAt, realFiles, settled, show, withViewer } from "./harness.mjs";

const data = realFiles();
// None on a border of cells.
const PLACES = [[0.49, 0.516], [0.408, 0.33], [0.627, 0.57], [0.47, 0.71], [0.55, 0.45]];

await withViewer(async (viewer) => {
  const { page, problems } = await newPage(viewer);
  const tree = join(viewer.folder, "tree.bsdft");
  ask("import sys, bsdftree; bsdftree.load(sys.argv[1]).to_tree(4, 4).save(sys.argv[2])", join(data, "pyradiance/blinds.xml"), tree);
  for (const path of [tree, join(data, "pyradiance/t3.xml"), join(data, "frads/ec60.xml"), join(data, "radiance/sawtooth.xml")]) {
    await show(page, path);
    await choose(page, "Mosaic");
    await keep(page, `mosaic-${basename(path)}`);
    await agrees(page, path);
    await zoomsToACell(page, path);
    await page.locator("#edges").setChecked(true);
    await keep(page, `mosaic-cell-${basename(path)}`);
  }
  await takesDirections(page);
  assert.deepEqual(problems, [], "no console errors, and nothing asked of others");
});

async function agrees(page, path) {
  const pairs = [];
  for (const [x, y] of PLACES) pairs.push(await readAt(page, "#mosaic .plane canvas", x, y));
  const found = pairs.filter(({ value }) => value !== "");
  assert.ok(found.length >= 3, `${basename(path)}: most places are inside of the mosaic`);
  const expected = expectedValues(path, await page.locator("#band").inputValue(), found);
  assert.deepEqual(found.map(({ value }) => Number(value)), expected, basename(path));
  return found;
}

/** Where light that is mirrored or goes straight on lies: in a mosaic of all incident directions it keeps its tile's place. */
async function onTheDiagonal(page, tile) {
  const { width, height } = await page.locator("#mosaic .plane canvas").boundingBox();
  const n = Number((await page.locator("#tiles option:checked").textContent()).split(" ")[0]);
  const place = (n * (tile + 0.5)) / n / n + tile;
  const scale = (Math.min(width, height) - 24) / n;
  return [0.5 + ((place - n / 2) * scale) / width, 0.5 + ((place - n / 2) * scale) / height];
}

/** From all to where a cell is over 50 pixels wide, at three places; there colours are those of values. */
async function zoomsToACell(page, path) {
  let coloured = 0;
  // Of few tiles a pixel is less than a patch.
  if (path.endsWith("ec60.xml")) await page.locator("#tiles").selectOption("3");
  const places = /polar/.test(await page.locator("#tiles option:checked").textContent()) ? PLACES.slice(0, 3) : [...PLACES.slice(0, 2), await onTheDiagonal(page, 2)];
  for (const [x, y] of places) {
    await page.locator("#mosaic").getByRole("button", { name: "all" }).click();
    await readAt(page, "#mosaic .plane canvas", x, y);
    for (let k = 0; k < 60; k++) await page.mouse.wheel(0, -400);
    await page.waitForTimeout(300);
    const told = await readAt(page, "#mosaic .plane canvas", x, y);
    const [expected] = expectedValues(path, await page.locator("#band").inputValue(), [told]);
    assert.equal(Number(told.value), expected, `${basename(path)}, one cell`);
    const [highest, decades] = await page.locator("#mosaic").evaluate(({ dataset }) => [Number(dataset.highest), Number(dataset.decades)]);
    const place = expected > highest / 10 ** decades ? Math.min(1, 1 + Math.log10(expected / highest) / decades) : 0;
    const seen = await page.locator("#mosaic .plane canvas").evaluate((canvas, [x, y]) => {
      const { data } = canvas.getContext("2d").getImageData(Math.floor(x * canvas.width) - 1, Math.floor(y * canvas.height) - 1, 3, 3);
      const bar = document.querySelector("#mosaic .legend .bar canvas");
      return { pixels: [...new Uint32Array(data.buffer)], colours: [...new Uint32Array(bar.getContext("2d").getImageData(0, 0, 256, 1).data.buffer)] };
    }, [x, y]);
    const k = Math.round(255 * place);
    // Borders are a pixel wide.
    assert.ok(seen.pixels.includes(seen.colours[k]), `${basename(path)}: ${seen.pixels} have the colour of ${expected}`);
    coloured += k > 0;
  }
  assert.ok(coloured > 0, `${basename(path)} has light where it was looked at`);
  console.log(`${basename(path)}: values and colours of the mosaic agree, ${coloured} of 3 cells with light`);
}

async function takesDirections(page) {
  await page.locator("#mosaic").getByRole("button", { name: "all" }).click();
  const before = await page.locator("#theta").inputValue();
  const told = await readAt(page, "#mosaic .plane canvas", 0.4, 0.32);
  await page.mouse.down();
  await page.mouse.up();
  await settled(page);
  const [x, y, z] = told.incident.split(" ").map(Number);
  const theta = (Math.atan2(Math.hypot(x, y), Math.abs(z)) * 180) / Math.PI;
  assert.notEqual(await page.locator("#theta").inputValue(), before);
  assert.ok(Math.abs(Number(await page.locator("#theta").inputValue()) - theta) < 1e-3, "a click takes the direction of the tile");
}
