import { defineConfig } from "vitest/config";

export default defineConfig({
  build: {
    outDir: "../server/wax/web/dist",
    emptyOutDir: true,
    target: "es2022",
    // The server's security policy allows no inline code or style.
    assetsInlineLimit: 0,
    modulePreload: false,
    // livekit-client is as large as that; it is loaded only while the robot is full.
    chunkSizeWarningLimit: 600,
  },
  server: {
    // `npm run dev` beside a running `wax`.
    proxy: { "/api": "http://localhost:8080" },
  },
  test: {
    include: ["src/**/*.test.{ts,tsx}"],
    setupFiles: ["src/testing/setup.ts"],
    restoreMocks: true,
    coverage: {
      // The first watchdog: what the robot's other modules are held to by `make coverage`.
      include: ["src/drive/**"],
      thresholds: { branches: 100 },
      reporter: ["text"],
      reportsDirectory: "../.cache/coverage",
    },
  },
});
