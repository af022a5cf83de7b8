// Replays physical_deception.vectors.txt: node physical_deception_test.mjs
import { readFileSync } from "node:fs";
import * as policy from "./physical_deception.mjs";
let n = 0, wrong = 0;
for (const line of readFileSync("physical_deception.vectors.txt", "utf8").split("\n").filter((text) => text && text[0] !== "#")) {
  const [agent, action, ...bits] = line.split(" ");
  const x = new Float32Array(Uint32Array.from(bits, (value) => parseInt(value, 16)).buffer);
  n++;
  wrong += policy.ACT[policy.AGENTS[agent]](x) !== Number(action);
}
console.log(`${n} vectors, ${wrong} wrong`);
process.exitCode = wrong !== 0 || n === 0 ? 1 : 0;
