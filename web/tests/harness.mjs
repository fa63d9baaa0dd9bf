// What tests of the built viewer share: its files on loopback, a browser, files dropped into a page, answers of the core as Python has it.
//
// Needs web/dist (`make web`), Chromium (CHROMIUM, else /usr/bin/chromium), Python with bsdftree (PYTHON, else ../.venv), and real files in
// ../shared/data beside the repository or where BSDFTREE_DATA points.

import assert from "node:assert/strict";
import { execFileSync } from "node:child_process";
import { existsSync, mkdtempSync, readFileSync, rmSync, statSync } from "node:fs";
import { createServer } from "node:http";
import { tmpdir } from "node:os";
import { basename, extname, join, normalize } from "node:path";
import { fileURLToPath } from "node:url";
import { chromium } from "playwright-core";

const web = fileURLToPath(new URL("..", import.meta.url));
const dist = join(web, "dist");
export const python = process.env.PYTHON ?? join(web, "../.venv/bin/python");
const TYPES = { ".html": "text/html", ".js": "text/javascript", ".css": "text/css", ".wasm": "application/wasm" };

/** Where the real files are; the program ends, and says so, where there are none. */
export function realFiles() {
  const data = process.env.BSDFTREE_DATA ?? join(web, "../../shared/data");
  if (existsSync(data)) return data;
  console.log(`SKIPPED: ${data} is not there; set BSDFTREE_DATA to the folder of real files`);
  process.exit(0);
}

/** Hands a browser, where the viewer is, and a folder for files that are made, served at /made/, to a test, and clears up after it. */
export async function withViewer(test) {
  const folder = mkdtempSync(join(tmpdir(), "bsdftree-web-"));
  const server = createServer((request, response) => {
    const path = normalize(decodeURIComponent(new URL(request.url, "http://localhost").pathname));
    const file = path.startsWith("/made/") ? join(folder, path.slice("/made/".length)) : join(dist, path === "/" ? "index.html" : path);
    if (!existsSync(file) || !statSync(file).isFile()) return response.writeHead(404).end();
    response.writeHead(200, { "content-type": TYPES[extname(file)] ?? "application/octet-stream" });
    response.end(readFileSync(file));
  });
  await new Promise((listening) => server.listen(0, "127.0.0.1", listening));
  const browser = await chromium.launch({
    executablePath: process.env.CHROMIUM ?? "/usr/bin/chromium",
    // Software GL, so that it works without a graphics card and in containers.
    args: ["--no-sandbox", "--use-angle=swiftshader", "--enable-unsafe-swiftshader"],
  });
  try {
    await test({ browser, origin: `http://127.0.0.1:${server.address().port}`, folder });
    console.log("all is well");
  } finally {
    await browser.close();
    server.close();
    rmSync(folder, { recursive: true });
  }
}

/** A page of the viewer, or another `address`; what it complains of, or asks of others than `origin`, is gathered in `problems`. */
export async function newPage({ browser, origin, address = origin }, options = {}) {
  const problems = [];
  const page = await browser.newPage({ viewport: { width: 1280, height: 720 }, ...options });
  page.on("console", (line) => line.type() === "error" && problems.push(line.text()));
  page.on("pageerror", (error) => problems.push(String(error)));
  page.on("request", (request) => {
    // A blob is of the page itself.
    if (![origin, "data:", "blob:"].some((own) => request.url().startsWith(own))) problems.push(`asked for ${request.url()}`);
  });
  await page.goto(address);
  return { page, problems };
}

/** What a Python program prints. */
export function ask(program, ...args) {
  return execFileSync(python, ["-c", program, ...args], { encoding: "utf8" });
}

/** Values that Python's eval has for pairs of directions, as the read-out tells them: { incident, exitant }. */
export function expectedValues(path, band, pairs) {
  const program = `
import json, sys, bsdftree
bsdf = bsdftree.load(sys.argv[1], strict=False)
direction = lambda text: [float(c) for c in text.split()]
print(json.dumps([float(bsdf.eval(direction(p["incident"]), direction(p["exitant"]), band=sys.argv[3])) for p in json.loads(sys.argv[2])]))
`;
  return JSON.parse(ask(program, path, JSON.stringify(pairs), band));
}

/** Drops files, { name, bytes } each, all at once. */
export async function drop(page, ...files) {
  const transfer = await page.evaluateHandle((files) => {
    const transfer = new DataTransfer();
    for (const { name, base64 } of files) {
      transfer.items.add(new File([Uint8Array.from(atob(base64), (c) => c.charCodeAt(0))], name));
    }
    return transfer;
  }, files.map(({ name, bytes }) => ({ name, base64: bytes.toString("base64") })));
  await page.dispatchEvent("body", "drop", { dataTransfer: transfer });
}

/** Drops files and waits until they are shown. */
export async function show(page, ...paths) {
  await drop(page, ...paths.map((path) => ({ name: basename(path), bytes: readFileSync(path) })));
  await shown(page, basename(paths.at(-1)));
}

/** After a file is read and drawn; what the page complains of instead is thrown. */
export async function shown(page, name) {
  await page.waitForFunction((name) => {
    const { className, textContent } = document.getElementById("message");
    if (className === "problem") throw new Error(textContent);
    return textContent.startsWith(`${name}, read in`);
  }, name);
  await settled(page);
}

export async function choose(page, tab) {
  await page.getByRole("tab", { name: tab, exact: true }).click();
  await settled(page);
}

/** After the frame that draws. */
export async function settled(page) {
  await page.evaluate(() => new Promise((drawn) => requestAnimationFrame(() => requestAnimationFrame(drawn))));
}

/** What the read-out has as data, with the pointer at a share of an element's box. */
export async function readAt(page, selector, x, y) {
  const box = await page.locator(selector).boundingBox();
  await page.mouse.move(box.x + x * box.width, box.y + y * box.height);
  await settled(page);
  return page.locator("#readout").evaluate(({ dataset }) => ({ ...dataset }));
}

/** How many colours a part of the page has on the screen, by its picture. */
export async function coloursOnScreen(page, selector) {
  const picture = (await page.locator(selector).screenshot()).toString("base64");
  return page.evaluate(async (base64) => {
    const bitmap = await createImageBitmap(new Blob([Uint8Array.from(atob(base64), (c) => c.charCodeAt(0))]));
    const context = new OffscreenCanvas(bitmap.width, bitmap.height).getContext("2d");
    context.drawImage(bitmap, 0, 0);
    return new Set(new Uint32Array(context.getImageData(0, 0, bitmap.width, bitmap.height).data.buffer)).size;
  }, picture);
}

/** A screenshot where the variable SCREENSHOTS names a folder. */
export async function keep(page, name) {
  if (process.env.SCREENSHOTS) await page.screenshot({ path: join(process.env.SCREENSHOTS, `${name}.png`) });
}

export { assert };
