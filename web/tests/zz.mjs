import { choose, newPage, settled, show, withViewer } from "./harness.mjs";
const [tab, name, scheme, ...paths] = process.argv.slice(2);
await withViewer(async (viewer) => {
  const { page, problems } = await newPage(viewer, { colorScheme: scheme });
  await show(page, ...paths);
  await choose(page, tab); if (process.env.BOX) await page.setViewportSize(JSON.parse(process.env.BOX)); await settled(page); await page.waitForTimeout(1500);
  await page.screenshot({ path: `/tmp/w/web2/shots/${name}.png` });
  console.log(problems, await page.evaluate(() => { const v = document.querySelector(".view:not([hidden])"); return [v.scrollHeight, v.clientHeight, v.scrollWidth, v.clientWidth]; }));
});
