import { fileURLToPath } from "node:url";
import { defineConfig } from "vite";

const here = (path: string) => fileURLToPath(new URL(path, import.meta.url));

/** The page of `wax replay`, built apart so that the robot's page does not load more at first. */
export default defineConfig({
  root: here("replay"),
  publicDir: here("public"),
  // It is served below a path that nobody else on this machine can guess.
  base: "./",
  build: {
    outDir: here("../server/wax/web/dist/replay"),
    emptyOutDir: true,
    target: "es2022",
    // The server's security policy allows no inline code or style.
    assetsInlineLimit: 0,
    modulePreload: false,
  },
  server: {
    // `TAPE=ADDRESS npx vite --config vite.replay.config.ts` with the address that `wax replay` prints.
    proxy: Object.fromEntries(
      ["/api", "/media"].map((path) => [path, process.env.TAPE ?? "http://localhost:8090"]),
    ),
  },
});
