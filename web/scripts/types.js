// Makes src/generated/messages.ts from the server's message models, defaults.ts from the fields that a
// message may leave out, and sentences.json from the server's sentences in English. PYTHON names the
// interpreter, which needs pydantic.
import { execFileSync } from "node:child_process";
import { existsSync, mkdirSync, readFileSync, writeFileSync } from "node:fs";
import { delimiter } from "node:path";
import { fileURLToPath } from "node:url";
import { compile } from "json-schema-to-typescript";

const python = process.env.PYTHON || "python3";
const server = fileURLToPath(new URL("../../server", import.meta.url));
const folder = new URL("../src/generated/", import.meta.url);

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

/**
 * Writes a generated file, unless it is unchanged: a running dev server would reload.
 * @param {string} name
 * @param {string} made
 */
function write(name, made) {
  const target = new URL(name, folder);
  if (existsSync(target) && readFileSync(target, "utf8") === made) return;
  mkdirSync(folder, { recursive: true });
  writeFileSync(target, made);
}

const { constants, sentences, ...schema } = JSON.parse(askServer());
const values = Object.entries(constants).map(
  ([name, value]) => `export const ${name} = ${JSON.stringify(value)} as const;\n`,
);
const banner = "/* Made by `npm run types` from server/wax/protocol; do not edit. */";
const defaults = Object.entries(schema.$defs).flatMap(([name, { properties = {} }]) => {
  const known = Object.entries(properties).filter(([, field]) => "default" in field);
  if (known.length === 0) return [];
  const fields = Object.fromEntries(known.map(([key, field]) => [key, field.default]));
  // Beside a `$ref` it would make the field's type one of its own.
  for (const [, field] of known) delete field.default;
  const keys = known.map(([key]) => JSON.stringify(key)).join(" | ");
  return [`  ${name}: (): Pick<made.${name}, ${keys}> => (${JSON.stringify(fields)}),\n`];
});
const types = await compile(schema, "Messages", {
  additionalProperties: false,
  bannerComment: banner,
  format: false,
  unreachableDefinitions: true,
});

write("messages.ts", types + values.join(""));
write(
  "defaults.ts",
  `${banner}\nimport type * as made from "./messages";\nexport const DEFAULTS = {\n${defaults.join("")}};\n`,
);
write("sentences.json", `${JSON.stringify(sentences, null, 2)}\n`);
