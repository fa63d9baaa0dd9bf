// src → dist: three files and the core, for any folder of any static host; a copy goes into the Python package. Types are checked before
// (`npm run build`).

import { cpSync, rmSync } from "node:fs";
import { fileURLToPath } from "node:url";
import { build } from "esbuild";

const here = fileURLToPath(new URL(".", import.meta.url));
rmSync(`${here}/dist`, { recursive: true, force: true });
await build({
  absWorkingDir: here,
  entryPoints: ["src/index.html", "src/main.ts", "src/style.css"],
  outdir: "dist",
  bundle: true,
  minify: true,
  format: "esm",
  target: "es2022",
  // The core stays a file of its own, named by its content.
  loader: { ".html": "copy", ".wasm": "file" },
  assetNames: "[name]-[hash]",
  logLevel: "info",
});
const inPackage = `${here}/../python/bsdftree/_viewer/page`;
rmSync(inPackage, { recursive: true, force: true });
cpSync(`${here}/dist`, inPackage, { recursive: true });
