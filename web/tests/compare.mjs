// Two files beside each other, the tree itself and standard errors in a real browser: figures are Python's, and a file is no different from itself. What it needs: harness.mjs.

import { readFileSync } from "node:fs";
import { basename, join } from "node:path";

import { assert, ask, choose, drop, keep, newPage, readAt, realFiles, settled, show, withViewer } from "./harness.mjs";

const data = realFiles();
const t3 = join(data, "pyradiance/t3.xml");

const MAKE = `
import sys, bsdftree
source, same, small, klems, tree, errors, other = sys.argv[1:]
bsdf = bsdftree.load(source)
bsdf.save(same)
bsdf.reduce(l1=0.1, total=0.02).save(small)
bsdf.to_klems("full").save(klems)
whole = bsdf.to_klems("full").to_tree(4, 4)
whole.save(tree)
# An eighth of each value, as bsdftree fit --errors says it.
eighth = bsdftree.Bsdf.from_components({
    part: bsdftree.Tree.from_grid(0.125 * component.to_grid(component.depth)) for part, component in whole.components_of("Visible").items()
})
eighth.with_header(provenance=["Standard errors in place of values"]).save(errors)
bsdf.to_klems("full").to_tree(4, 2).with_header(provenance=["Standard errors in place of values"]).save(other)
`;

await withViewer(async (viewer) => {
  const { page, problems } = await newPage(viewer);
  const files = Object.fromEntries(["same.xml", "small.xml", "klems.xml", "tree.bsdft", "errors.xml", "errors_of_another.xml"].map((name) => [name, join(viewer.folder, name)]));
  ask(MAKE, t3, ...Object.values(files));
  await ofItselfNothing(page, files);
  for (const other of [files["small.xml"], files["klems.xml"]]) await tableIsPythons(page, t3, other);
  await keep(page, "compare");
  await leavesArePythons(page, files["tree.bsdft"]);
  await keep(page, "tree");
  await tellsErrors(page, files);
  assert.deepEqual(problems, [], "no console errors, and nothing asked of others");
});

async function ofItselfNothing(page, files) {
  await show(page, t3, files["same.xml"]);
  await choose(page, "Compare");
  for (const row of await counted(page)) {
    assert.ok(row.relative_l1 === 0 || row.relative_l1 === null);
    assert.deepEqual([row.rms_total, row.worst_total, row.totals[1] - row.totals[0]], [0, 0, 0], row.part);
  }
  // Maps of difference and of ratio have the colour of none everywhere, and nothing else but what lies outside.
  for (const k of [2, 3]) {
    const colours = await page.locator("#compare .disks canvas").nth(k).evaluate((canvas) => {
      const { data } = canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height);
      return [...new Set(new Uint32Array(data.buffer))].filter((pixel) => pixel !== 0);
    });
    assert.equal(colours.length, 1, `${colours} is one colour`);
  }
}

/** The table when it has been counted, in full. */
async function counted(page) {
  await page.waitForSelector("#compare tr[data-found]");
  return page.locator("#compare tr[data-found]").evaluateAll((rows) => rows.map(({ dataset }) => JSON.parse(dataset.found)));
}

async function tableIsPythons(page, one, other) {
  await show(page, one, other);
  await choose(page, "Compare");
  const found = await counted(page);
  const expected = JSON.parse(ask(`
import json, math, sys, bsdftree
from bsdftree.plot._compare import differences
a, b = map(bsdftree.load, sys.argv[1:])
rows = differences(a, b, "Visible")
print(json.dumps({d.part: [None if math.isnan(d.relative_l1) else d.relative_l1, d.total_a, d.total_b, d.worst_total, d.theta_deg] for d in rows}))
`, one, other));
  assert.deepEqual(found.map(({ part }) => part).sort(), Object.keys(expected).sort());
  for (const { part, relative_l1, totals, worst_total, worst_theta_deg } of found) {
    [relative_l1, ...totals, worst_total, worst_theta_deg].forEach((number, k) => {
      const python = expected[part][k];
      assert.ok(number === python || Math.abs(number - python) < 1e-9, `${part}: ${number} is ${python}`);
    });
  }
  console.log(`the table of ${found.length} components is Python's: L1 ${found.map(({ relative_l1 }) => relative_l1)}`);
}

async function leavesArePythons(page, tree) {
  await show(page, tree);
  await choose(page, "Tree");
  const part = await page.locator("#part").inputValue();
  const expected = JSON.parse(ask(`
import json, sys, bsdftree
from bsdftree._cells import cells_of
cells = cells_of(bsdftree.load(sys.argv[1]).components_of("Visible")[sys.argv[2]])
print(json.dumps([cells.counts.tolist(), cells.shares.tolist(), cells.light.tolist()]))
`, tree, part));
  const told = await page.locator("#tree .bars rect title").allTextContents();
  const numbers = (kind) => told.filter((text) => text.includes(kind)).map((text) => Number(text.match(/([\d.,e-]+)( %)?$/)[1].replaceAll(",", "")));
  assert.deepEqual(numbers(": leaves "), expected[0].filter((n) => n > 0), "leaves of each depth");
  const rounded = (shares) => shares.filter((share) => share > 0).map((share) => Number((100 * share).toPrecision(3)));
  const n = rounded(expected[1]).length;
  assert.deepEqual(numbers(": of pairs of directions ").slice(0, n), rounded(expected[1]));
  assert.deepEqual(numbers(": of scattered light ").slice(0, n), rounded(expected[2]));
}

async function tellsErrors(page, files) {
  await show(page, files["tree.bsdft"]);
  await choose(page, "Polar maps");
  await dropped(page, files["errors_of_another.xml"], /read in/);
  await show(page, files["tree.bsdft"]);
  assert.equal((await readAt(page, "#reflection", 0.4, 0.4)).error, "", "nothing is known of it yet");
  await dropped(page, files["errors.xml"], /standard errors of tree\.bsdft/);
  const told = await readAt(page, "#reflection", 0.4, 0.41);
  assert.equal(Number(told.error), Number(told.value) / 8);
  assert.match(await page.locator("#readout").textContent(), /±/);
  await choose(page, "Tree");
  assert.match(await page.locator("#tree dl").textContent(), /standard error12\.5 %/);
}

async function dropped(page, path, told) {
  await drop(page, { name: basename(path), bytes: readFileSync(path) });
  await page.waitForFunction((pattern) => new RegExp(pattern).test(document.getElementById("message").textContent), told.source);
  await settled(page);
}
