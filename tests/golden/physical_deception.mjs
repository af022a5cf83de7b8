/* Decision tree policies of 3 agents for the world physical-deception. Generated: do not edit.
 *
 * profile     d7c7e9951b353c845e3729dfb7383e9f94192c6dfd621196d4fd4879d989808d
 * made by     tests, hand-made, preset none, seed 0
 *
 * An ES module without imports. For each agent A: act_A(x) takes one observation (an array or a typed array) and
 * returns the action's number; act_A_rows(x, n) takes a typed array of n observations, one after the other, and returns
 * n numbers. An observation has a number for each name of FEATURES[A]: another length is a RangeError, and what is not
 * of the type number (a text, a BigInt, true, null, undefined) a TypeError.
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

/** RangeError where x is not of n, TypeError where one of them is no number: a text would be compared as one. */
function check(agent, n, x) {
  if (x === null || x === undefined || x.length !== n) {
    throw new RangeError(`${agent} observes ${n} numbers, given ${x === null || x === undefined ? x : x.length}`);
  }
  const asked = ArrayBuffer.isView(x) ? 1 : n; // all of a typed array are of one type
  for (let place = 0; place < asked; place++) {
    if (typeof x[place] !== "number") {
      throw new TypeError(`${agent} observes ${n} numbers, given ${typeof x[place]} at ${place}`);
    }
  }
}

/** RangeError where x is no typed array of n observations of that width. */
function checkRows(agent, width, x, n) {
  if (!Number.isInteger(n) || !ArrayBuffer.isView(x) || x.length !== width * n) {
    const given = ArrayBuffer.isView(x) ? x.length : typeof x;
    throw new RangeError(`${agent} observes ${width} numbers: ${n} times ${width} in a typed array, given ${given}`);
  }
}

/** adversary_0, team adversaries: 1 leaves, at most 0 comparisons. */
export function act_adversary_0(x) {
  check("adversary_0", 8, x);
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

/** agent_0, team defenders: 5 leaves, at most 3 comparisons. */
export function act_agent_0(x) {
  check("agent_0", 10, x);
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

/** agent_1, team defenders: 4 leaves, at most 3 comparisons. */
export function act_agent_1(x) {
  check("agent_1", 10, x);
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

export const ACT = {
  "adversary_0": act_adversary_0,
  "agent_0": act_agent_0,
  "agent_1": act_agent_1,
};
