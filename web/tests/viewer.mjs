// The built viewer in a real browser: files come in by drop, values under the pointer are those of the core as Python has it.
//
// Needs web/dist (`make web`), Chromium (CHROMIUM, else /usr/bin/chromium), Python with bsdftree (PYTHON, else ../.venv), and real files in
// ../shared/data beside the repository or where BSDFTREE_DATA points; without those it says so and ends.

import assert from "node:assert/strict";
import { execFileSync } from "node:child_process";
import { existsSync, mkdtempSync, readFileSync, rmSync } from "node:fs";
import { createServer } from "node:http";
import { tmpdir } from "node:os";
import { basename, extname, join, normalize } from "node:path";
import { fileURLToPath } from "node:url";
import { chromium } from "playwright-core";

const web = fileURLToPath(new URL("..", import.meta.url));
const data = process.env.BSDFTREE_DATA ?? join(web, "../../shared/data");
const python = process.env.PYTHON ?? join(web, "../.venv/bin/python");
const dist = join(web, "dist");
const FILES = ["radiance/sawtooth.xml", "pyradiance/t3.xml", "pyradiance/blinds.xml", "frads/ec60.xml"];

if (!existsSync(data)) {
  console.log(`SKIPPED: ${data} is not there; set BSDFTREE_DATA to the folder of real files`);
  process.exit(0);
}

const TYPES = { ".html": "text/html", ".js": "text/javascript", ".css": "text/css", ".wasm": "application/wasm" };
const server = createServer((request, response) => {
  const path = normalize(new URL(request.url, "http://localhost").pathname);
  const file = join(dist, path === "/" ? "index.html" : path);
  if (!existsSync(file)) return response.writeHead(404).end();
  response.writeHead(200, { "content-type": TYPES[extname(file)] ?? "application/octet-stream" });
  response.end(readFileSync(file));
});
await new Promise((listening) => server.listen(0, "127.0.0.1", listening));
const origin = `http://127.0.0.1:${server.address().port}`;
const folder = mkdtempSync(join(tmpdir(), "bsdftree-web-"));
const browser = await chromium.launch({
  executablePath: process.env.CHROMIUM ?? "/usr/bin/chromium",
  // Software GL, so that it works without a graphics card and in containers.
  args: ["--no-sandbox", "--use-angle=swiftshader", "--enable-unsafe-swiftshader"],
});

try {
  await everything();
  console.log("all is well");
} finally {
  await browser.close();
  server.close();
  rmSync(folder, { recursive: true });
}

async function everything() {
  const problems = [];
  const page = await browser.newPage({ viewport: { width: 1280, height: 720 } });
  page.on("console", (line) => line.type() === "error" && problems.push(line.text()));
  page.on("pageerror", (error) => problems.push(String(error)));
  page.on("request", (request) => {
    if (!request.url().startsWith(origin) && !request.url().startsWith("data:")) problems.push(`asked for ${request.url()}`);
  });
  await page.goto(origin);

  const made = ["tree.xml", "packed.bsdft", "raw.bsdft"].map((name) => join(folder, name));
  const program = `
import sys, bsdftree
tree = bsdftree.load(sys.argv[1]).to_tree(4, 4)
for path in sys.argv[2:]:
    tree.save(path, packed=path.endswith("packed.bsdft"))
`;
  ask(program, join(data, "pyradiance/blinds.xml"), ...made);
  for (const file of [...FILES.map((name) => join(data, name)), ...made]) await answersAsTheCore(page, file);
  await turnsTheDome(page);
  await refusesWhatIsNoBsdf(page);
  assert.deepEqual(problems, [], "no console errors, and nothing asked of others");
}

/** What a Python program prints. */
function ask(program, ...args) {
  return execFileSync(python, ["-c", program, ...args], { encoding: "utf8" });
}

async function drop(page, name, bytes) {
  const transfer = await page.evaluateHandle(
    ({ name, base64 }) => {
      const transfer = new DataTransfer();
      transfer.items.add(new File([Uint8Array.from(atob(base64), (c) => c.charCodeAt(0))], name));
      return transfer;
    },
    { name, base64: bytes.toString("base64") },
  );
  await page.dispatchEvent("body", "drop", { dataTransfer: transfer });
}

async function answersAsTheCore(page, path) {
  await drop(page, basename(path), readFileSync(path));
  await page.waitForFunction((name) => document.getElementById("message").textContent.startsWith(`${name}, read in`), basename(path));
  await settled(page);
  const pairs = [];
  for (const id of ["reflection", "transmission"]) {
    const box = await page.locator(`#${id}`).boundingBox();
    // The last lies where straight and mirrored light goes.
    for (const [x, y] of [[0.31, 0.42], [0.5, 0.12], [0.72, 0.66], [0.49, 0.51], [0.5, 0.75]]) {
      await page.mouse.move(box.x + x * box.width, box.y + y * box.height);
      await settled(page);
      pairs.push(await page.locator("#readout").evaluate(({ dataset }) => ({ ...dataset })));
    }
  }
  const band = await page.locator("#band").inputValue();
  const program = `
import json, sys, bsdftree
bsdf = bsdftree.load(sys.argv[1], strict=False)
direction = lambda text: [float(c) for c in text.split()]
print(json.dumps([float(bsdf.eval(direction(p["incident"]), direction(p["exitant"]), band=sys.argv[3])) for p in json.loads(sys.argv[2])]))
`;
  const expected = JSON.parse(ask(program, path, JSON.stringify(pairs), band));
  assert.deepEqual(pairs.map((pair) => Number(pair.value)), expected, basename(path));
  assert.ok(expected.some((value) => value > 0), `${basename(path)} has light where it was looked at`);
  assert.ok((await colours(page, "reflection")) + (await colours(page, "transmission")) > 4, "maps are not blank");
  console.log(`${basename(path)}: ${await page.locator("#message").textContent()}; ${expected.length} values agree to the bit`);
}

/** After the frame that draws. */
async function settled(page) {
  await page.evaluate(() => new Promise((drawn) => requestAnimationFrame(() => requestAnimationFrame(drawn))));
}

/** How many colours a map has. */
function colours(page, id) {
  return page.locator(`#${id}`).evaluate((canvas) => {
    const { data } = canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height);
    return new Set(new Uint32Array(data.buffer)).size;
  });
}

async function turnsTheDome(page) {
  const before = await page.locator("#theta").inputValue();
  const box = await page.locator("#dome").boundingBox();
  await page.mouse.move(box.x + 0.5 * box.width, box.y + 0.4 * box.height);
  await page.mouse.down();
  await page.mouse.move(box.x + 0.68 * box.width, box.y + 0.45 * box.height, { steps: 5 });
  await settled(page);
  await page.mouse.up();
  await settled(page);
  const after = await page.locator("#theta").inputValue();
  assert.notEqual(after, before, "dragging on the dome turns the incident direction");
  await page.locator("#dome").press("ArrowDown");
  await settled(page);
  assert.ok(Math.abs(Number(await page.locator("#theta").inputValue()) - Number(after) - 1) < 1e-2, "an arrow key is a degree");
  await page.locator("#edges").check();
  await settled(page);
  if (process.env.SCREENSHOTS) {
    for (const colorScheme of ["light", "dark"]) {
      await page.emulateMedia({ colorScheme });
      await page.screenshot({ path: join(process.env.SCREENSHOTS, `viewer-${colorScheme}.png`) });
    }
  }
}

async function refusesWhatIsNoBsdf(page) {
  await drop(page, "broken.xml", Buffer.from("<WindowElement><Optical></WindowElement>"));
  await page.waitForSelector("#message.problem");
  const told = await page.locator("#message").textContent();
  assert.match(told, /^broken\.xml: .*(line|byte) \d+/, "the message names file and place");
  console.log(`refused: ${told}`);
}
