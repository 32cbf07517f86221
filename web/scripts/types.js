// Makes src/generated/messages.ts from the server's message models. PYTHON names the interpreter
// to ask; it needs pydantic, and finds the server's sources beside this folder.
import { execFileSync } from "node:child_process";
import { mkdirSync, readFileSync, writeFileSync } from "node:fs";
import { delimiter } from "node:path";
import { fileURLToPath } from "node:url";
import { compile } from "json-schema-to-typescript";

const python = process.env.PYTHON || "python3";
const server = fileURLToPath(new URL("../../server", import.meta.url));
const folder = new URL("../src/generated/", import.meta.url);
const target = new URL("messages.ts", folder);

const paths = [server, process.env.PYTHONPATH].filter(Boolean).join(delimiter);

/** @returns {string} the JSON Schema of all messages */
function askServer() {
  try {
    return execFileSync(python, ["-m", "wax.web.schema"], {
      env: { ...process.env, PYTHONPATH: paths },
      encoding: "utf8",
    });
  } catch {
    console.error(`The message types were not made: \`${python} -m wax.web.schema\` failed, see`);
    console.error("above; set PYTHON to a Python that has WAX's packages.");
    process.exit(1);
  }
}

/** @returns {string} what the last call made, empty when there was none */
function before() {
  try {
    return readFileSync(target, "utf8");
  } catch {
    return "";
  }
}

const { constants, ...schema } = JSON.parse(askServer());
const values = Object.entries(constants).map(
  ([name, value]) => `export const ${name} = ${JSON.stringify(value)};\n`,
);
const types = await compile(schema, "Messages", {
  additionalProperties: false,
  bannerComment: "/* Made by `npm run types` from server/wax/protocol/messages.py; do not edit. */",
  format: false,
  unreachableDefinitions: true,
});

// An unchanged file keeps its time, so that a running dev server does not reload.
const made = types + values.join("");
if (made !== before()) {
  mkdirSync(folder, { recursive: true });
  writeFileSync(target, made);
}
