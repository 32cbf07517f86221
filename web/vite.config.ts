import type { Plugin } from "vite";
import { defineConfig } from "vitest/config";

/** Makes the browser load the player's worker together with the page, not when it is started. */
function preloadWorker(): Plugin {
  return {
    name: "preload-worker",
    transformIndexHtml(_html, { bundle }) {
      if (!bundle) return [];
      const worker = Object.keys(bundle).find((name) => /\bplayerWorker-[^/]*\.js$/.test(name));
      if (!worker) throw new Error("the player's worker is not among what was built");
      const attrs = { rel: "modulepreload", href: `./${worker}` };
      return [{ tag: "link", attrs, injectTo: "head" }];
    },
  };
}

/** Drops from the HTML what only its authors need: everybody loads it. */
function shorten(): Plugin {
  return {
    name: "shorten",
    apply: "build",
    transformIndexHtml: (html) =>
      html
        .replace(/<!--.*?-->/gs, "")
        .replace(/\s*\n\s*/g, "\n")
        .replaceAll(" />", ">"),
  };
}

export default defineConfig({
  // A proxy may serve the page below a path.
  base: "./",
  plugins: [preloadWorker(), shorten()],
  build: {
    outDir: "../server/wax/web/dist",
    emptyOutDir: true,
    target: "es2022",
    // The server's security policy allows no inline code or style.
    assetsInlineLimit: 0,
    // Every supported browser can preload modules without a polyfill.
    modulePreload: { polyfill: false },
    // One file: several at once overfill a modem's queue, and each lost packet costs seconds.
    rolldownOptions: {
      output: { codeSplitting: { groups: [{ name: "first", test: /\/src\/main\.tsx$/ }] } },
    },
    // livekit-client is this large; it is loaded only while the robot is full.
    chunkSizeWarningLimit: 600,
  },
  server: {
    // `npm run dev` uses a running `wax`.
    proxy: { "/api": "http://localhost:8080" },
  },
  test: {
    include: ["{src,scripts}/**/*.test.{js,ts,tsx}"],
    setupFiles: ["src/testing/setup.ts"],
    restoreMocks: true,
    // Only a test that hangs takes longer; minutes of sound take seconds to simulate.
    testTimeout: 60_000,
    // Files share processes, which saves half of the time. setup.ts gives each file its own modules, and
    // dom.ts a window. Preact is inlined so that it is among these modules: it queues what is to be drawn.
    isolate: false,
    alias: { "vitest-environment-dom": `${import.meta.dirname}/src/testing/dom.ts` },
    server: { deps: { inline: ["preact", "@preact"] } },
    coverage: {
      // The first watchdog, held to the same branch coverage as the robot's modules in `make coverage`.
      include: ["src/drive/**"],
      thresholds: { branches: 100 },
      reporter: ["text", "json-summary"],
      reportsDirectory: "../.cache/coverage",
    },
  },
});
