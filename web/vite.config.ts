import type { Plugin } from "vite";
import { defineConfig } from "vitest/config";

/** Has the page ask for the player's worker with everything else, not when it is started. */
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

export default defineConfig({
  // A proxy may serve the page below a path.
  base: "./",
  plugins: [preloadWorker()],
  build: {
    outDir: "../server/wax/web/dist",
    emptyOutDir: true,
    target: "es2022",
    // The server's security policy allows no inline code or style.
    assetsInlineLimit: 0,
    // Parts of the first load come beside each other; every such browser knows how by itself.
    modulePreload: { polyfill: false },
    // In one file: several at once overfill a modem's queue, and what is lost there costs seconds.
    rolldownOptions: {
      output: { codeSplitting: { groups: [{ name: "first", test: /\/src\/main\.tsx$/ }] } },
    },
    // livekit-client is as large as that; it is loaded only while the robot is full.
    chunkSizeWarningLimit: 600,
  },
  server: {
    // `npm run dev` beside a running `wax`.
    proxy: { "/api": "http://localhost:8080" },
  },
  test: {
    include: ["{src,scripts}/**/*.test.{js,ts,tsx}"],
    setupFiles: ["src/testing/setup.ts"],
    restoreMocks: true,
    // For what hangs: minutes of sound take seconds to simulate on a busy machine.
    testTimeout: 60_000,
    // Files share processes, which saves half of the time. setup.ts gives each modules of its own, and
    // dom.ts a window; Preact's are among these modules, since they keep what is still to be drawn.
    isolate: false,
    alias: { "vitest-environment-dom": `${import.meta.dirname}/src/testing/dom.ts` },
    server: { deps: { inline: ["preact", "@preact"] } },
    coverage: {
      // The first watchdog: what the robot's other modules are held to by `make coverage`.
      include: ["src/drive/**"],
      thresholds: { branches: 100 },
      reporter: ["text", "json-summary"],
      reportsDirectory: "../.cache/coverage",
    },
  },
});
