/* Decision tree policies of 3 agents for the world physical-deception. Generated: do not edit.
 *
 * profile     d7c7e9951b353c845e3729dfb7383e9f94192c6dfd621196d4fd4879d989808d
 * made by     tests, hand-made, preset none, seed 0
 *
 * An ES module without imports. For each agent A: act_A(x) takes one observation (an array or a typed array) and
 * returns the action's number; act_A_rows(x, n) takes a typed array of n observations, one after the other, and returns
 * n numbers. finite_A(x) and in_range_A(x) check an observation, as float32. An observation has a number for each name of FEATURES[A]: another length is a RangeError, and what is not
 * of the type number (a text, a BigInt, true, null, undefined) a TypeError.
 *
 * A world state w has a number for each name of COORDINATES. observe_A(w) is what A observes there, act_world_A(w) its
 * action, act_team(w) the actions of all AGENTS. An observation is made as the reference environment makes it: added in
 * double, then rounded to float32, to nearest.
 *
 * A split goes left iff x[feature] <= threshold. Observations are float32; each threshold is written as the largest
 * double that rounds to a float32 not above it, so doubles decide as if they had been rounded to float32 first.
 * NaN compares false and so goes right; infinities follow <=.
 */

export const PROFILE = "d7c7e9951b353c845e3729dfb7383e9f94192c6dfd621196d4fd4879d989808d";
export const AGENTS = ["adversary_0", "agent_0", "agent_1"];
export const FEATURES = {
  "adversary_0": ["landmark_0_dx", "landmark_0_dy", "landmark_1_dx", "landmark_1_dy", "agent_0_dx", "agent_0_dy", "agent_1_dx", "agent_1_dy"],
  "agent_0": ["goal_dx", "goal_dy", "landmark_0_dx", "landmark_0_dy", "landmark_1_dx", "landmark_1_dy", "adversary_0_dx", "adversary_0_dy", "agent_1_dx", "agent_1_dy"],
  "agent_1": ["goal_dx", "goal_dy", "landmark_0_dx", "landmark_0_dy", "landmark_1_dx", "landmark_1_dy", "adversary_0_dx", "adversary_0_dy", "agent_0_dx", "agent_0_dy"],
};
export const ACTIONS = {
  "adversary_0": ["stay", "left", "right", "down", "up"],
  "agent_0": ["stay", "left", "right", "down", "up"],
  "agent_1": ["stay", "left", "right", "down", "up"],
};
/** The numbers of actions by their names. */
export const ACTION = {
  "adversary_0": Object.freeze({ STAY: 0, LEFT: 1, RIGHT: 2, DOWN: 3, UP: 4 }),
  "agent_0": Object.freeze({ STAY: 0, LEFT: 1, RIGHT: 2, DOWN: 3, UP: 4 }),
  "agent_1": Object.freeze({ STAY: 0, LEFT: 1, RIGHT: 2, DOWN: 3, UP: 4 }),
};
/** What each feature measures, a sum of coordinates or a function of one; null: nobody said. */
export const MEANINGS = {
  "adversary_0": ["landmark_0.x - adversary_0.x", "landmark_0.y - adversary_0.y", "landmark_1.x - adversary_0.x", "landmark_1.y - adversary_0.y", "agent_0.x - adversary_0.x", "agent_0.y - adversary_0.y", "agent_1.x - adversary_0.x", "agent_1.y - adversary_0.y"],
  "agent_0": ["goal.x - agent_0.x", "goal.y - agent_0.y", "landmark_0.x - agent_0.x", "landmark_0.y - agent_0.y", "landmark_1.x - agent_0.x", "landmark_1.y - agent_0.y", "adversary_0.x - agent_0.x", "adversary_0.y - agent_0.y", "agent_1.x - agent_0.x", "agent_1.y - agent_0.y"],
  "agent_1": ["goal.x - agent_1.x", "goal.y - agent_1.y", "landmark_0.x - agent_1.x", "landmark_0.y - agent_1.y", "landmark_1.x - agent_1.x", "landmark_1.y - agent_1.y", "adversary_0.x - agent_1.x", "adversary_0.y - agent_1.y", "agent_0.x - agent_1.x", "agent_0.y - agent_1.y"],
};
/** The least and largest float32 of each feature. */
export const RANGES = {
  "adversary_0": [[-6.300000190734863, 6.300000190734863], [-6.300000190734863, 6.300000190734863], [-6.300000190734863, 6.300000190734863], [-6.300000190734863, 6.300000190734863], [-10.600000381469727, 10.600000381469727], [-10.600000381469727, 10.600000381469727], [-10.600000381469727, 10.600000381469727], [-10.600000381469727, 10.600000381469727]],
  "agent_0": [[-6.300000190734863, 6.300000190734863], [-6.300000190734863, 6.300000190734863], [-6.300000190734863, 6.300000190734863], [-6.300000190734863, 6.300000190734863], [-6.300000190734863, 6.300000190734863], [-6.300000190734863, 6.300000190734863], [-10.600000381469727, 10.600000381469727], [-10.600000381469727, 10.600000381469727], [-10.600000381469727, 10.600000381469727], [-10.600000381469727, 10.600000381469727]],
  "agent_1": [[-6.300000190734863, 6.300000190734863], [-6.300000190734863, 6.300000190734863], [-6.300000190734863, 6.300000190734863], [-6.300000190734863, 6.300000190734863], [-6.300000190734863, 6.300000190734863], [-6.300000190734863, 6.300000190734863], [-10.600000381469727, 10.600000381469727], [-10.600000381469727, 10.600000381469727], [-10.600000381469727, 10.600000381469727], [-10.600000381469727, 10.600000381469727]],
};
/** The direction in which each action pushes; null: it has none. */
export const EFFECTS = {
  "adversary_0": [[0.0, 0.0], [-1.0, 0.0], [1.0, 0.0], [0.0, -1.0], [0.0, 1.0]],
  "agent_0": [[0.0, 0.0], [-1.0, 0.0], [1.0, 0.0], [0.0, -1.0], [0.0, 1.0]],
  "agent_1": [[0.0, 0.0], [-1.0, 0.0], [1.0, 0.0], [0.0, -1.0], [0.0, 1.0]],
};
/** What a unit action adds to a velocity per unit of time. */
export const FORCE = { "adversary_0": 5.0, "agent_0": 5.0, "agent_1": 5.0 };
export const DT = 0.1; // time of a step
export const DAMPING = 0.25; // the share of its velocity that an agent loses in a step
export const COORDINATES = [
  "adversary_0.x", // read by adversary_0, agent_0, agent_1
  "adversary_0.y", // read by adversary_0, agent_0, agent_1
  "agent_0.x", // read by adversary_0, agent_0, agent_1
  "agent_0.y", // read by adversary_0, agent_0, agent_1
  "agent_1.x", // read by adversary_0, agent_0, agent_1
  "agent_1.y", // read by adversary_0, agent_0, agent_1
  "landmark_0.x", // read by adversary_0, agent_0, agent_1
  "landmark_0.y", // read by adversary_0, agent_0, agent_1
  "landmark_1.x", // read by adversary_0, agent_0, agent_1
  "landmark_1.y", // read by adversary_0, agent_0, agent_1
  "goal.x", // read by agent_0, agent_1
  "goal.y", // read by agent_0, agent_1
  "adversary_0.vx", // not read
  "adversary_0.vy", // not read
  "agent_0.vx", // not read
  "agent_0.vy", // not read
  "agent_1.vx", // not read
  "agent_1.vy", // not read
];

/** RangeError where x is not of n, TypeError where one of them is no number: a text would be compared as one. */
function check(what, n, x) {
  if (x === null || x === undefined || x.length !== n) {
    throw new RangeError(`${what} ${n} numbers, given ${x === null || x === undefined ? x : x.length}`);
  }
  const asked = ArrayBuffer.isView(x) ? 1 : n; // all of a typed array are of one type
  for (let place = 0; place < asked; place++) {
    if (typeof x[place] !== "number") {
      throw new TypeError(`${what} ${n} numbers, given ${typeof x[place]} at ${place}`);
    }
  }
}

/** RangeError where x is no typed array of n observations of that width. */
function checkRows(agent, width, x, n) {
  if (!Number.isInteger(n)) {
    throw new RangeError(`act_rows(x, n) of ${agent}: n is the number of observations in x, given ${String(n)}`);
  }
  if (!ArrayBuffer.isView(x) || x.length !== width * n) {
    const given = ArrayBuffer.isView(x) ? x.length : typeof x;
    throw new RangeError(`${agent} observes ${width} numbers: ${n} times ${width} in a typed array, given ${given}`);
  }
}

/** adversary_0, team adversaries: 1 leaf, at most 0 comparisons. */
export function act_adversary_0(x) {
  check("adversary_0 observes", 8, x);
  return 0; // stay, leaf 0
}

/** As act_adversary_0, for n observations. */
export function act_adversary_0_rows(x, n) {
  checkRows("adversary_0", 8, x, n);
  const actions = new Int32Array(n);
  for (let row = 0; row < n; row++) {
    actions[row] = act_adversary_0(x.subarray(row * 8, (row + 1) * 8));
  }
  return actions;
}

/** Whether every number of an observation is finite, as float32. */
export function finite_adversary_0(x) {
  check("adversary_0 observes", 8, x);
  return Array.from(x, Math.fround).every(Number.isFinite);
}

/** Whether every number of an observation is within its feature's range, as float32. */
export function in_range_adversary_0(x) {
  check("adversary_0 observes", 8, x);
  return RANGES["adversary_0"].every(([low, high], place) => Math.fround(x[place]) >= low && Math.fround(x[place]) <= high);
}

/** agent_0, team defenders: 5 leaves, at most 3 comparisons. */
export function act_agent_0(x) {
  check("agent_0 observes", 10, x);
  if (x[0] <= 0.09999999776482582) { // node 0: goal_dx
    if (x[3] <= 7.006492321624085e-46) { // node 1: landmark_0_dy
      return 1; // left, leaf 2
    } else {
      return 2; // right, leaf 3
    }
  } else {
    if (x[9] <= -0.33333332836627966) { // node 4: agent_1_dy
      return 4; // up, leaf 5
    } else {
      if (x[2] <= 3.4028235677973362e+38) { // node 6: landmark_0_dx
        return 0; // stay, leaf 7
      } else {
        return 0; // stay, leaf 8
      }
    }
  }
}

/** As act_agent_0, for n observations. */
export function act_agent_0_rows(x, n) {
  checkRows("agent_0", 10, x, n);
  const actions = new Int32Array(n);
  for (let row = 0; row < n; row++) {
    actions[row] = act_agent_0(x.subarray(row * 10, (row + 1) * 10));
  }
  return actions;
}

/** Whether every number of an observation is finite, as float32. */
export function finite_agent_0(x) {
  check("agent_0 observes", 10, x);
  return Array.from(x, Math.fround).every(Number.isFinite);
}

/** Whether every number of an observation is within its feature's range, as float32. */
export function in_range_agent_0(x) {
  check("agent_0 observes", 10, x);
  return RANGES["agent_0"].every(([low, high], place) => Math.fround(x[place]) >= low && Math.fround(x[place]) <= high);
}

/** agent_1, team defenders: 4 leaves, at most 3 comparisons. */
export function act_agent_1(x) {
  check("agent_1 observes", 10, x);
  if (x[4] <= -0.04999999888241292) { // node 0: landmark_1_dx
    return 1; // left, leaf 1
  } else {
    if (x[4] <= 0.0500000026077032) { // node 2: landmark_1_dx
      if (x[5] <= 7.006492321624085e-46) { // node 3: landmark_1_dy
        return 3; // down, leaf 4
      } else {
        return 4; // up, leaf 5
      }
    } else {
      return 2; // right, leaf 6
    }
  }
}

/** As act_agent_1, for n observations. */
export function act_agent_1_rows(x, n) {
  checkRows("agent_1", 10, x, n);
  const actions = new Int32Array(n);
  for (let row = 0; row < n; row++) {
    actions[row] = act_agent_1(x.subarray(row * 10, (row + 1) * 10));
  }
  return actions;
}

/** Whether every number of an observation is finite, as float32. */
export function finite_agent_1(x) {
  check("agent_1 observes", 10, x);
  return Array.from(x, Math.fround).every(Number.isFinite);
}

/** Whether every number of an observation is within its feature's range, as float32. */
export function in_range_agent_1(x) {
  check("agent_1 observes", 10, x);
  return RANGES["agent_1"].every(([low, high], place) => Math.fround(x[place]) >= low && Math.fround(x[place]) <= high);
}

/** What adversary_0 observes in a world state: float32 numbers. */
export function observe_adversary_0(w) {
  check("a world state has", 18, w);
  return Float32Array.of(
    w[6] - w[0], // landmark_0_dx
    w[7] - w[1], // landmark_0_dy
    w[8] - w[0], // landmark_1_dx
    w[9] - w[1], // landmark_1_dy
    w[2] - w[0], // agent_0_dx
    w[3] - w[1], // agent_0_dy
    w[4] - w[0], // agent_1_dx
    w[5] - w[1], // agent_1_dy
  );
}

/** The action of adversary_0 in a world state. */
export function act_world_adversary_0(w) {
  return act_adversary_0(observe_adversary_0(w));
}

/** What agent_0 observes in a world state: float32 numbers. */
export function observe_agent_0(w) {
  check("a world state has", 18, w);
  return Float32Array.of(
    w[10] - w[2], // goal_dx
    w[11] - w[3], // goal_dy
    w[6] - w[2], // landmark_0_dx
    w[7] - w[3], // landmark_0_dy
    w[8] - w[2], // landmark_1_dx
    w[9] - w[3], // landmark_1_dy
    w[0] - w[2], // adversary_0_dx
    w[1] - w[3], // adversary_0_dy
    w[4] - w[2], // agent_1_dx
    w[5] - w[3], // agent_1_dy
  );
}

/** The action of agent_0 in a world state. */
export function act_world_agent_0(w) {
  return act_agent_0(observe_agent_0(w));
}

/** What agent_1 observes in a world state: float32 numbers. */
export function observe_agent_1(w) {
  check("a world state has", 18, w);
  return Float32Array.of(
    w[10] - w[4], // goal_dx
    w[11] - w[5], // goal_dy
    w[6] - w[4], // landmark_0_dx
    w[7] - w[5], // landmark_0_dy
    w[8] - w[4], // landmark_1_dx
    w[9] - w[5], // landmark_1_dy
    w[0] - w[4], // adversary_0_dx
    w[1] - w[5], // adversary_0_dy
    w[2] - w[4], // agent_0_dx
    w[3] - w[5], // agent_0_dy
  );
}

/** The action of agent_1 in a world state. */
export function act_world_agent_1(w) {
  return act_agent_1(observe_agent_1(w));
}

/** The actions of all AGENTS in a world state. */
export function act_team(w) {
  return [act_world_adversary_0(w), act_world_agent_0(w), act_world_agent_1(w)];
}

// by agent: each function
export const ACT = {
  "adversary_0": act_adversary_0,
  "agent_0": act_agent_0,
  "agent_1": act_agent_1,
};
export const ACT_ROWS = {
  "adversary_0": act_adversary_0_rows,
  "agent_0": act_agent_0_rows,
  "agent_1": act_agent_1_rows,
};
export const FINITE = {
  "adversary_0": finite_adversary_0,
  "agent_0": finite_agent_0,
  "agent_1": finite_agent_1,
};
export const IN_RANGE = {
  "adversary_0": in_range_adversary_0,
  "agent_0": in_range_agent_0,
  "agent_1": in_range_agent_1,
};
export const OBSERVE = {
  "adversary_0": observe_adversary_0,
  "agent_0": observe_agent_0,
  "agent_1": observe_agent_1,
};
export const ACT_WORLD = {
  "adversary_0": act_world_adversary_0,
  "agent_0": act_world_agent_0,
  "agent_1": act_world_agent_1,
};
