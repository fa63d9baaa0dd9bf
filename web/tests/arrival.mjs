// How files arrive: by the address of the page on a static host, by `bsdftree view`, inside of an exported page from file://. Whichever way, values
// are the core's, nothing is asked of others, and the content security policy holds.

import { execFileSync, spawn } from "node:child_process";
import { copyFileSync, writeFileSync } from "node:fs";
import { basename, join } from "node:path";
import { pathToFileURL } from "node:url";
import { ask, assert, choose, expectedValues, newPage, python, readAt, realFiles, shown, withViewer } from "./harness.mjs";

const SOURCES = ["radiance/sawtooth.xml", "pyradiance/t3.xml", "frads/ec60.xml"];
/** All that means something in addresses or in markup. */
const ODD = "a%20b & <c>#1?=ü 100%.xml";

await withViewer(async ({ browser, folder, origin }) => {
  const paths = SOURCES.map((source) => {
    const path = join(folder, basename(source));
    copyFileSync(join(realFiles(), source), path);
    return path;
  });
  paths.push(join(folder, "packed.bsdft"));
  ask("import sys, bsdftree; bsdftree.load(sys.argv[1]).save(sys.argv[2], packed=True)", ...paths.slice(-2));
  for (const path of paths) {
    await holds(browser, `${origin}/?file=made/${basename(path)}`, origin, [path]);
  }
  paths.push(join(folder, ODD));
  copyFileSync(paths[0], paths.at(-1));
  await holds(browser, `${origin}/?file=${encodeURIComponent(`made/${encodeURIComponent(ODD)}`)}`, origin, paths.slice(-1));
  await holds(browser, `${origin}/index.html?file=made/sawtooth.xml&file=made/ec60.xml`, origin, [paths[0], paths[2]]);
  await tellsWhatDoesNotArrive(browser, folder, origin);
  await policyHolds(browser, `${origin}/?file=made/sawtooth.xml`, "sawtooth.xml");
  await isServed(browser, paths);
  await isExported(browser, folder, paths);
});

/** That the last file of an address is open, the first shown, its values are right, and all is quiet. */
async function holds(browser, address, own, paths) {
  const { page, problems } = await newPage({ browser, origin: own, address });
  await shown(page, basename(paths.at(-1)));
  assert.equal(await page.locator("#first option:checked").textContent(), basename(paths[0]));
  const compared = await page.locator("#compared option:checked").textContent();
  if (paths.length > 1) assert.equal(compared, basename(paths[1]));
  await choose(page, "Polar maps");
  const pairs = [];
  for (const map of ["#reflection", "#transmission"]) {
    for (const [x, y] of [[0.31, 0.42], [0.72, 0.66], [0.5, 0.75]]) pairs.push(await readAt(page, map, x, y));
  }
  const expected = expectedValues(paths[0], await page.locator("#band").inputValue(), pairs);
  assert.deepEqual(pairs.map((pair) => Number(pair.value)), expected, address);
  assert.ok(expected.some((value) => value > 0), `${address} has light where it was looked at`);
  assert.deepEqual(problems, [], address);
  await page.close();
  console.log(`${address.replace(/.*\//, "…/")}: ${expected.length} values agree to the bit`);
}

async function tellsWhatDoesNotArrive(browser, folder, origin) {
  writeFileSync(join(folder, "page.xml"), "<html/>");
  const cases = { "made/none.xml": /^none\.xml .* 404/, "made/page.xml": /^page\.xml: .*html/, "http://example.org/a.xml": /^a\.xml .* another host, example\.org/ };
  for (const [file, told] of Object.entries(cases)) {
    // The browser itself notes a 404.
    const { page } = await newPage({ browser, origin, address: `${origin}/?file=${encodeURIComponent(file)}&file=made/sawtooth.xml` });
    await page.waitForSelector("#message.problem");
    assert.match(await page.locator("#message").textContent(), told);
    await page.close();
  }
}

/** That scripts, connections and code from text are refused; of such a page that works otherwise. */
async function policyHolds(browser, address, name) {
  const page = await browser.newPage();
  await page.goto(address);
  await shown(page, name);
  const done = await page.evaluate(async () => {
    const refused = [];
    document.addEventListener("securitypolicyviolation", (event) => refused.push(event.effectiveDirective));
    const add = (tag, properties) => document.body.append(Object.assign(document.createElement(tag), properties));
    add("script", { textContent: "window.ran = true" });
    add("script", { src: "https://example.org/a.js" });
    add("style", { textContent: "body { color: red }" });
    add("img", { src: "https://example.org/a.png" });
    add("iframe", { src: "https://example.org/" });
    await fetch("https://example.org/").catch(() => {});
    // Later, since code of the browser's debugger, which this is, may make code of text.
    setTimeout("window.ran = true");
    await new Promise((told) => setTimeout(told, 200));
    return { ran: window.ran ?? false, refused: [...new Set(refused)].sort() };
  });
  assert.deepEqual(done, { ran: false, refused: ["connect-src", "frame-src", "img-src", "script-src", "script-src-elem", "style-src-elem"] });
  await page.close();
}

async function isServed(browser, paths) {
  const served = spawn(python, ["-m", "bsdftree", "view", "--no-browser", paths[0], paths.at(-1)], { stdio: ["ignore", "pipe", "ignore"] });
  try {
    const url = await new Promise((told, failed) => {
      served.stdout.once("data", (line) => told(String(line).trim()));
      served.once("exit", () => failed(new Error("bsdftree view ended")));
    });
    await holds(browser, url, url, [paths[0], paths.at(-1)]);
    await policyHolds(browser, url, ODD);
  } finally {
    const ended = new Promise((told) => served.once("exit", (code) => told(code)));
    served.kill("SIGINT");
    assert.equal(await ended, 0, "Ctrl-C ends it quietly");
  }
}

async function isExported(browser, folder, paths) {
  const out = join(folder, "exported.html");
  execFileSync(python, ["-m", "bsdftree", "view", paths[0], paths.at(-1), "--export", out], { stdio: ["ignore", "ignore", "ignore"] });
  const address = pathToFileURL(out).href;
  await holds(browser, address, address, [paths[0], paths.at(-1)]);
  await policyHolds(browser, address, ODD);
}
