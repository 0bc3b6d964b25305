// SPDX-License-Identifier: Apache-2.0
// usage: check_configurations.mjs WAYMARK
// The schema of configurations, as an editor uses it: yaml-language-server reads the shipped files and finds nothing, and finds
// each of some mistakes. The schema in the tree is the one that `waymark schema` prints. Exit code 77: the packages of
// package.json are missing.
import { execFileSync, spawn } from "node:child_process";
import { readFileSync, readdirSync } from "node:fs";
import { createRequire } from "node:module";
import { dirname, join, resolve } from "node:path";
import { fileURLToPath, pathToFileURL } from "node:url";

const here = dirname(fileURLToPath(import.meta.url));
const configs = resolve(here, "../../config");
const schemaFile = join(configs, "waymark.schema.json");
const modeline = "# yaml-language-server: $schema=waymark.schema.json\n";
const waymark = process.argv[2];
let failures = 0;

function check(isRight, text) {
  if (isRight) return;
  ++failures;
  console.error(`FAILED: ${text}`);
}

/// A change of config/quickstart.yaml, and a word of what the editor shows then.
const mistakes = [
  ["\nsensors:", "\nsensor:", "sensor"],
  ["plugin: odometry", "plugin: odometri", "odometry"],
  ["kind: planar", "kind: plane", "planar"],
  ["track_m:", "trak_m:", "trak_m"],
  ["particles: 25", "partcles: 25", "partcles"],
  ["particles: 25", "particles: -3", "minimum"],
  ["particles: 25", "particles: many", "integer"],
  ["plugin: tum", "plugin: tum, trajectori: a.txt", "trajectori"],
];

/// The language server as a process, with the diagnostics of each document.
class Editor {
  constructor(rpc, server) {
    this.process = spawn(process.execPath, [server, "--stdio"], { stdio: ["pipe", "pipe", "inherit"] });
    this.connection = rpc.createMessageConnection(
      new rpc.StreamMessageReader(this.process.stdout),
      new rpc.StreamMessageWriter(this.process.stdin),
    );
    this.waiting = new Map();
    this.connection.onNotification("textDocument/publishDiagnostics", ({ uri, diagnostics }) => {
      this.waiting.get(uri)?.(diagnostics);
    });
    const settings = { yaml: { validate: true, schemaStore: { enable: false } } };
    this.connection.onRequest("workspace/configuration", ({ items }) => items.map(({ section }) => settings[section] ?? {}));
    this.connection.onRequest("client/registerCapability", () => null);
    this.connection.onRequest("custom/schema/request", () => null);
    this.connection.listen();
  }

  async open() {
    const capabilities = { workspace: { configuration: true }, textDocument: { publishDiagnostics: {} } };
    await this.connection.sendRequest("initialize", { processId: process.pid, rootUri: null, capabilities });
    await this.connection.sendNotification("initialized", {});
  }

  /// What is wrong with a text as the file of this name, one message each.
  async diagnose(file, text) {
    const uri = pathToFileURL(file).href;
    const diagnostics = new Promise((done, fail) => {
      this.waiting.set(uri, done);
      setTimeout(() => fail(new Error(`no answer about ${file} within 60 s`)), 60_000).unref();
    });
    await this.connection.sendNotification("textDocument/didOpen", {
      textDocument: { uri, languageId: "yaml", version: 1, text },
    });
    return (await diagnostics).map(({ range, message }) => `line ${range.start.line + 1}: ${message}`);
  }

  async close() {
    await this.connection.sendRequest("shutdown");
    await this.connection.sendNotification("exit");
    this.connection.dispose();
  }
}

let rpc, server;
try {
  const packages = createRequire(import.meta.url);
  rpc = packages("vscode-jsonrpc/node");
  server = resolve(here, "node_modules/yaml-language-server/bin/yaml-language-server");
  readFileSync(server);
} catch {
  console.log("skipped: npm ci --prefix tests/schema installs what it needs");
  process.exit(77);
}

const printed = execFileSync(waymark, ["schema"], { encoding: "utf8", maxBuffer: 1 << 26 });
check(printed === readFileSync(schemaFile, "utf8"), `${schemaFile} is old; waymark schema > config/waymark.schema.json writes it`);

const editor = new Editor(rpc, server);
await editor.open();
const shipped = readdirSync(configs).filter((name) => name.endsWith(".yaml"));
check(shipped.length > 20, `only ${shipped.length} configurations in ${configs}`);
for (const name of shipped) {
  const text = readFileSync(join(configs, name), "utf8");
  check(text.startsWith(modeline), `${name} does not begin with ${modeline}`);
  for (const problem of await editor.diagnose(join(configs, name), text)) check(false, `${name}: ${problem}`);
}
const right = readFileSync(join(configs, "quickstart.yaml"), "utf8");
for (const [index, [from, to, word]] of mistakes.entries()) {
  check(right.includes(from), `quickstart.yaml has no ${from}`);
  const problems = await editor.diagnose(join(configs, `mistake_${index}.yaml`), right.replace(from, to));
  check(problems.some((problem) => problem.includes(word)), `"${to.trim()}" is not found: ${problems.join("; ") || "no message"}`);
}
await editor.close();
console.log(`${shipped.length} configurations, ${mistakes.length} mistakes: ${failures} failed`);
process.exit(failures === 0 ? 0 : 1);
