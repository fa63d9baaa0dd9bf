import { defineConfig } from "vite";

// From any folder of any static host; the core stays a file of its own, which a content security policy can name.
export default defineConfig({
  base: "./",
  build: { target: "es2022", assetsInlineLimit: 0, modulePreload: { polyfill: false }, chunkSizeWarningLimit: 600 },
});
