/** The environment for tests with a DOM: happy-dom loaded once, with a new window for each file. */
import { builtinEnvironments, type Environment } from "vitest/runtime";

declare global {
  /** Replaces the window that a test file has used. */
  var renewWindow: (() => Promise<void>) | undefined;
}

const happyDom = builtinEnvironments["happy-dom"];

export default {
  name: "dom",
  viteEnvironment: "client",
  async setup(global, options) {
    let window = await happyDom.setup(global, options);
    global.renewWindow = async () => {
      await window.teardown(global);
      window = await happyDom.setup(global, options);
    };
    return { teardown: () => window.teardown(global) };
  },
} satisfies Environment;
