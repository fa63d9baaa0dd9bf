// How fast the viewer is: seconds until a file of about 45 MB is shown, and each view of it; frames per second while the incident direction is dragged.
//
// node tests/speed.mjs [FILE…]; without files one of a glossy function is made, 2⁶ cells per axis. What it needs: harness.mjs. No test: figures are those of this machine,
// without a graphics card (software GL), in whatever else it is doing; processor time per frame, of all threads of the browser, says what it would be if it were idle.

import { existsSync, readdirSync, readFileSync, statSync } from "node:fs";
import { cpus, loadavg } from "node:os";
import { basename, join } from "node:path";

import { ask, choose, newPage, settled, withViewer } from "./harness.mjs";

const SECONDS = 3;
const MAKE = `
import sys
from bsdftree.cli import main
main(["from-function", "peak", "-c", "reflection_back", "-c", "transmission_front", "--log2-res", "6", "--tolerance", "0.5", "-o", sys.argv[1], "-e",
      "sq(x)=x*x; peak(ix,iy,iz,ox,oy,oz) = .05 + exp(-(sq(ix+ox)+sq(iy+oy))/if(iz,.02,.01))*5*(1.2+sin(3*ix+2*oy));"], standalone_mode=False)
`;

await withViewer(async (viewer) => {
  console.log(`${cpus().length} cores of ${cpus()[0].model}, load ${loadavg()[0].toFixed(1)}, software GL`);
  const files = process.argv.slice(2);
  if (files.length === 0) {
    files.push(join(viewer.folder, "glossy.xml"));
    ask(MAKE, files[0]);
  }
  for (const file of files) {
    if (!existsSync(file)) throw new Error(`${file} is not there`);
    await measure(viewer, file);
  }
});

async function measure(viewer, file) {
  const { page } = await newPage(viewer);
  // The core is compiled once; so is it for those who open a second file.
  const begun = performance.now();
  await page.setInputFiles("#file", file);
  await page.waitForFunction((name) => document.getElementById("message").textContent.startsWith(`${name}, read in`), basename(file), { timeout: 120_000 });
  const read = await page.locator("#message").textContent();
  await settled(page);
  const shown = performance.now() - begun;
  console.log(`${read} (${(statSync(file).size / 1e6).toFixed(1)} MB), shown after ${(shown / 1000).toFixed(2)} s`);
  for (const tab of await page.getByRole("tab").allTextContents()) {
    const clicked = performance.now();
    await choose(page, tab);
    const drawn = (performance.now() - clicked) / 1000;
    const before = processorSeconds();
    const { frames, seconds } = await page.evaluate(dragged, SECONDS);
    const each = (1000 * (processorSeconds() - before)) / frames;
    console.log(`  ${tab.padEnd(12)} shown after ${drawn.toFixed(2)} s, ${(frames / seconds).toFixed(1).padStart(5)} frames/s while dragging, ${each.toFixed(1)} ms of processors each`);
  }
  await page.close();
}

/** Of all that this program started, by Linux's /proc. */
function processorSeconds() {
  const processes = readdirSync("/proc").filter((name) => /^\d+$/.test(name)).flatMap((pid) => {
    try {
      // After the name in parentheses: state, parent, …, user and system time in hundredths of a second.
      const fields = readFileSync(`/proc/${pid}/stat`, "utf8").replace(/^.*\) /s, "").split(" ");
      return [{ pid: Number(pid), parent: Number(fields[1]), seconds: (Number(fields[11]) + Number(fields[12])) / 100 }];
    } catch {
      // It has ended meanwhile.
      return [];
    }
  });
  const ours = new Set([process.pid]);
  for (let n = 0; n !== ours.size; ) {
    n = ours.size;
    for (const { pid, parent } of processes) if (ours.has(parent)) ours.add(pid);
  }
  return processes.filter(({ pid }) => ours.has(pid) && pid !== process.pid).reduce((sum, { seconds }) => sum + seconds, 0);
}

/** In the page: as many frames as it can while a pointer moves over the dome. */
async function dragged(seconds) {
  const dome = document.getElementById("dome");
  const box = dome.getBoundingClientRect();
  dome.setPointerCapture = () => {};
  const send = (kind, x, y, buttons) =>
    dome.dispatchEvent(new PointerEvent(kind, { pointerId: 1, buttons, clientX: box.x + x * box.width, clientY: box.y + y * box.height }));
  send("pointerdown", 0.5, 0.45, 1);
  let frames = 0;
  const begun = performance.now();
  while (performance.now() - begun < seconds * 1000) {
    const turn = frames / 20;
    send("pointermove", 0.5 + 0.2 * Math.cos(turn), 0.5 + 0.15 * Math.sin(turn), 1);
    await new Promise(requestAnimationFrame);
    frames++;
  }
  const taken = (performance.now() - begun) / 1000;
  send("pointerup", 0.5, 0.5, 0);
  await new Promise(requestAnimationFrame);
  return { frames, seconds: taken };
}
