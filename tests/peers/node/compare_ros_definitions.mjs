// SPDX-License-Identifier: Apache-2.0
// Reads the lines of print_ros_messages and compares definitions with those of ROS 2 (Humble and Jazzy), then decodes the bytes by ROS
// 2's definition and encodes them again: they must be the same.
import { readFileSync } from "node:fs";
import { parse } from "@foxglove/rosmsg";
import { ros2humble, ros2jazzy } from "@foxglove/rosmsg-msgs-common";
import { MessageReader, MessageWriter } from "@foxglove/rosmsg2-serialization";

// ROS 2 has these, but not in this package: Fast DDS is their test.
const NOT_THERE = new Set(["map_msgs/OccupancyGridUpdate", "octomap_msgs/Octomap"]);
const BASE = new Set(["builtin_interfaces/Time", "builtin_interfaces/Duration"]);

const short = (type) => type.replace("/msg/", "/");
const fieldOf = (field) => {
  let type = short(field.type);
  if (type === "time") type = "builtin_interfaces/Time";
  if (type === "duration") type = "builtin_interfaces/Duration";
  if (type === "byte") type = "uint8";
  return `${type}${field.isArray ? `[${field.arrayLength ?? ""}]` : ""} ${field.name}`;
};
const fieldsOf = (definition) => definition.definitions.filter((field) => !field.isConstant).map(fieldOf).join("\n");

/** The definition of a type with all that it is made of, as the reader takes it. */
function withParts(known, type, found = new Map()) {
  const definition = known[type];
  if (definition && !found.has(type)) {
    found.set(type, definition);
    for (const field of definition.definitions) if (field.isComplex) withParts(known, short(field.type), found);
  }
  return [...found.values()];
}

let compared = 0;
const failures = [];
for (const line of readFileSync(0, "utf8").trim().split("\n")) {
  const { type, definition, cdr } = JSON.parse(line);
  const name = short(type);
  if (BASE.has(name) || NOT_THERE.has(name)) continue;
  const ours = parse(definition, { ros2: true });
  for (const [distribution, known] of Object.entries({ ros2humble, ros2jazzy })) {
    const theirs = known[name];
    if (!theirs) {
      failures.push(`${distribution} has no ${name}`);
      continue;
    }
    const expected = fieldsOf(theirs);
    const found = fieldsOf(ours[0]);
    if (expected !== found) {
      failures.push(`${name} of ${distribution}: expected\n${expected}\nfound\n${found}`);
      continue;
    }
    const parts = withParts(known, name);
    const bytes = Buffer.from(cdr, "hex");
    const message = new MessageReader(parts).readMessage(bytes);
    const again = Buffer.from(new MessageWriter(parts).writeMessage(message));
    if (Buffer.compare(bytes, again) !== 0) {
      failures.push(`${name} of ${distribution}: bytes differ\n${bytes.toString("hex")}\n${again.toString("hex")}`);
      continue;
    }
    ++compared;
  }
}
if (failures.length > 0 || compared === 0) {
  console.error(failures.join("\n\n") || "nothing was compared");
  process.exit(1);
}
console.log(`${compared} definitions are the same, and so are the bytes of their messages`);
