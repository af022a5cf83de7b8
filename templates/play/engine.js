/* The game, the trees and the claims of a page, without the page: pure functions over plain data.
 *
 * State: {position: [[x, y] of agents, then landmarks], velocity: [[x, y] of agents], goal: landmark's number or null}.
 * Numbers are doubles; the operations and their order are those of the simulator, so that episodes are the same. Claims
 * are judged exactly: where rounding could decide, in integers.
 */
const Engine = (() => {
  "use strict";
  const PUSHING_MARGINS = 746; // farther apart nobody pushes: exp(-746) is 0

  // --- exact comparisons

  const view = new DataView(new ArrayBuffer(8));

  /** [m, e] with x = m * 2**e, m a BigInt. */
  function parts(x) {
    view.setFloat64(0, x);
    const bits = view.getBigUint64(0);
    const exponent = Number((bits >> 52n) & 0x7ffn);
    const fraction = bits & 0xfffffffffffffn;
    const m = exponent ? fraction | 0x10000000000000n : fraction;
    return [bits >> 63n ? -m : m, (exponent || 1) - 1075];
  }

  /** [numerator, denominator] of "3", "-0.25" or "1/40". */
  function rational(text) {
    const [over, under] = text.replace(/"/g, "").split("/");
    const digits = over.split(".");
    const scale = 10n ** BigInt((digits[1] || "").length);
    return [BigInt(digits.join("")), under === undefined ? scale : BigInt(under) * scale];
  }

  function gcd(a, b) {
    while (b) [a, b] = [b, a % b];
    return a < 0n ? -a : a;
  }

  /** The sign of (sum of weight * value) - bound, exactly. terms: [weight as text, place in the values]. */
  function comparison(terms, boundText) {
    const numbers = [...terms.map(([weight]) => rational(weight)), rational(boundText)];
    const common = numbers.reduce((all, [, under]) => (all / gcd(all, under)) * under, 1n);
    const whole = numbers.map(([over, under]) => over * (common / under));
    const bound = whole.pop();
    const places = terms.map(([, place]) => place);
    const floats = numbers.map(([over, under]) => Number(over) / Number(under));
    const least = floats.pop();
    const doubt = (terms.length + 8) * Number.EPSILON;
    return (values) => {
      let total = -least;
      let size = Math.abs(least);
      for (let i = 0; i < places.length; i++) {
        const part = floats[i] * values[places[i]];
        total += part;
        size += Math.abs(part);
      }
      if (Math.abs(total) > doubt * size + 1e-290 && Number.isFinite(total)) return Math.sign(total);
      const read = places.map((place) => parts(values[place]));
      const lowest = read.reduce((low, [, e]) => Math.min(low, e), 0);
      let sum = -bound << BigInt(-lowest);
      read.forEach(([m, e], i) => (sum += (whole[i] * m) << BigInt(e - lowest)));
      return sum > 0n ? 1 : sum < 0n ? -1 : 0;
    };
  }

  // --- the world

  /** What the functions below need of the page's data, looked up once. */
  function prepared(data) {
    const { world, agents } = data;
    const entities = [...world.agents, ...world.landmarks];
    const names = [];
    for (const one of entities) names.push(`${one.name}.x`, `${one.name}.y`);
    if (world.goals.length) names.push("goal.x", "goal.y");
    for (const one of world.agents) names.push(`${one.name}.vx`, `${one.name}.vy`);
    const place = Object.fromEntries(names.map((name, index) => [name, index]));
    const pairs = [];
    for (let i = 0; i < world.agents.length && world.contactForce; i++) {
      for (let j = i + 1; j < entities.length; j++) {
        if (entities[i].collides && entities[j].collides) pairs.push([i, j, entities[i].size + entities[j].size]);
      }
    }
    const observed = agents.map((agent) => {
      if (agent.features.some((feature) => feature.terms === null)) return null;
      return agent.features.map((feature) => feature.terms.map(([weight, name]) => [weight, place[name]]));
    });
    return { data, world, agents, entities, names, place, pairs, observed };
  }

  /** All coordinates by place: positions, the goal's, velocities. */
  function coordinates(game, state) {
    const found = [];
    for (const [x, y] of state.position) found.push(x, y);
    if (game.world.goals.length) found.push(...state.position[game.world.agents.length + state.goal]);
    for (const [x, y] of state.velocity) found.push(x, y);
    return found;
  }

  const same = (x) => x;
  /** What rounds to the numbers that an agent observes. */
  const rounded = (agent) => (agent.numbers === "float64" ? same : Math.fround);

  /** One agent's observation: summed in double, rounded to its numbers; null where a feature has no meaning. */
  function observe(game, number, at) {
    const terms = game.observed[number];
    if (terms === null) return null;
    const { features } = game.agents[number];
    return terms.map((sum, f) => {
      if (!sum.length) return 0;
      let total = sum[0][0] * at[sum[0][1]];
      for (let i = 1; i < sum.length; i++) total += sum[i][0] * at[sum[i][1]];
      switch (features[f].function) {
        case "positive":
          return total > 0 ? 1 : 0;
        case "zero":
          return total === 0 ? 1 : 0;
        case "sign":
          return Math.sign(total);
        default:
          return rounded(game.agents[number])(total);
      }
    });
  }

  /** A sum of weighted features and sums, left to right in the tree's arithmetic; -1: of a constant; a text divides. */
  function added(terms, seen, arithmetic) {
    const round = arithmetic === "float32 steps" ? Math.fround : same;
    const value = (place) => (Array.isArray(place) ? added(place, seen, arithmetic) : seen[place]);
    const scale = (weight, seen) => (typeof weight === "string" ? seen / Number(weight) : weight * seen);
    const term = ([weight, place]) => (place === -1 ? weight : round(scale(weight, value(place))));
    let found = term(terms[0]);
    for (let i = 1; i < terms.length; i++) found = round(found + term(terms[i]));
    return found;
  }

  /** What the tests of a tree compare: an observation, then the sums of it that are tested. */
  function tested({ sums, arithmetic }, seen) {
    return sums && sums.length ? [...seen, ...sums.map(({ terms }) => added(terms, seen, arithmetic))] : seen;
  }

  /** The numbers that an agent gives at a leaf: sums, cut to bounds, then rounded once. */
  function given({ outputs }, { vectors, action, arithmetic, gives }, leaf, seen) {
    return vectors[action[leaf]].map(({ terms }, place) => {
      const { low, high } = outputs[place];
      let value = added(terms, seen, arithmetic);
      if (high !== null && value > high) value = high;
      if (low !== null && value < low) value = low;
      return gives === "float32" ? Math.fround(value) : value;
    });
  }

  /** The nodes from the root to the leaf that an observation reaches. */
  function path(tree, observation) {
    const { feature, threshold, left, right } = tree;
    const seen = tested(tree, observation);
    const found = [0];
    let node = 0;
    while (feature[node] >= 0) {
      node = seen[feature[node]] <= threshold[node] ? left[node] : right[node];
      found.push(node);
    }
    return found;
  }

  /** What an agent observes, with what it remembers after it decided. */
  function after(agent, observation) {
    const seen = [...observation];
    const action = agent.actions[agent.tree.action[path(agent.tree, observation).pop()]];
    for (const [place, kept, added] of action.updates || []) seen[place] = kept * seen[place] + added;
    return seen;
  }

  /** What a test or an output of a tree is where two features vary, `axes`, and the others stay: [a, b, c] for
   * a x + b y + c, in the reals.
   */
  function affine(terms, seen, axes) {
    const found = [0, 0, 0];
    for (const [weight, place] of terms) {
      const axis = axes.indexOf(place);
      if (Array.isArray(place)) affine(place, seen, axes).forEach((each, k) => (found[k] += weight * each));
      else if (axis >= 0) found[axis] += weight;
      else found[2] += place < 0 ? weight : weight * seen[place];
    }
    return found;
  }

  /** The parts of a convex polygon where a x + b y + c is at most 0, and above; with the line between them. */
  function parted(polygon, [a, b, c]) {
    const low = [];
    const high = [];
    const between = [];
    polygon.forEach(([x, y], i) => {
      const [u, v] = polygon[(i + 1) % polygon.length];
      const here = a * x + b * y + c;
      const next = a * u + b * v + c;
      (here <= 0 ? low : high).push([x, y]);
      if (here <= 0 === next <= 0) return;
      const share = here / (here - next);
      const crossing = [x + share * (u - x), y + share * (v - y)];
      for (const each of [low, high, between]) each.push(crossing);
    });
    return { low, high, between };
  }

  /** A tree over a rectangle of two features: the line of each test, and the polygon of each node that is met. */
  function pieces(agent, tree, seen, axes, [[left, right], [bottom, top]]) {
    const cuts = [];
    const areas = [];
    const walk = (node, polygon) => {
      if (polygon.length < 3) return;
      areas.push({ node, polygon });
      const f = tree.feature[node];
      if (f < 0) return;
      const width = agent.features.length;
      const plane = affine(f < width ? [[1, f]] : tree.sums[f - width].terms, seen, axes);
      plane[2] -= tree.threshold[node];
      const { low, high, between } = parted(polygon, plane);
      if (between.length === 2) cuts.push({ node, line: between });
      walk(tree.left[node], low);
      walk(tree.right[node], high);
    };
    walk(0, [[left, bottom], [right, bottom], [right, top], [left, top]]);
    return { cuts, areas };
  }

  /** Every agent's action, by its own tree, or by the other one of two profiles that are compared. */
  function actions(game, at, team = "tree") {
    return game.agents.map((agent, number) => {
      const found = path(agent[team], observe(game, number, at));
      return agent[team].action[found[found.length - 1]];
    });
  }

  /** The state after a step in which the agents take these actions: positions move with the old velocity. */
  function step(game, state, chosen) {
    const { world, agents } = game;
    const push = world.agents.map((entity, i) => {
      const effect = agents[i].actions[chosen[i]].effect || [0, 0];
      return [effect[0] * entity.force, effect[1] * entity.force];
    });
    for (const [i, j, touching] of game.pairs) pushApart(world, state.position, push, i, j, touching);
    const position = state.position.map((p) => [...p]);
    const velocity = state.velocity.map(([vx, vy], i) => {
      position[i][0] += vx * world.dt;
      position[i][1] += vy * world.dt;
      const kept = 1 - world.damping;
      const v = [vx * kept + push[i][0] * world.dt, vy * kept + push[i][1] * world.dt];
      const most = world.agents[i].maxSpeed;
      const speed = Math.sqrt(v[0] * v[0] + v[1] * v[1]);
      return most !== null && speed > most ? [(v[0] / speed) * most, (v[1] / speed) * most] : v;
    });
    return { position, velocity, goal: state.goal };
  }

  /** Adds the contact force of one pair; where both centres coincide there is no direction to push in. */
  function pushApart(world, position, push, i, j, touching) {
    const dx = position[i][0] - position[j][0];
    const dy = position[i][1] - position[j][1];
    const reach = touching + PUSHING_MARGINS * world.contactMargin;
    const squared = dx * dx + dy * dy;
    if (!(squared < reach * reach && squared > 0)) return;
    const distance = Math.sqrt(squared);
    const z = -(distance - touching) / world.contactMargin;
    const overlap = (z < 0 ? Math.log1p(Math.exp(z)) : z + Math.log1p(Math.exp(-z))) * world.contactMargin;
    [dx, dy].forEach((gap, axis) => {
      const force = ((world.contactForce * gap) / distance) * overlap;
      push[i][axis] += force;
      if (j < push.length) push[j][axis] -= force;
    });
  }

  /** {states, actions} of an episode; `choose(step, at)` may replace the actions. */
  function episode(game, start, steps, choose) {
    const states = [start];
    const taken = [];
    for (let t = 0; t < steps; t++) {
      const at = coordinates(game, states[t]);
      taken.push(choose ? choose(t, at) : actions(game, at));
      states.push(step(game, states[t], taken[t]));
    }
    return { states, actions: taken };
  }

  // --- claims about decisions

  /** A formula as a function of coordinates, actions by agent's number, and the goal's number. A list has each of its
   * parts once, the whole last; a number is a part's place in it.
   */
  function formula(game, node, known = []) {
    if (Number.isInteger(node)) return known[node];
    if (Array.isArray(node)) {
      for (const part of node) known.push(remembering(formula(game, part, known)));
      return known[known.length - 1];
    }
    if (node.sum) {
      const compare = comparison(node.sum.map(([weight, name]) => [weight, game.place[name]]), node.most || node.below);
      return node.below === undefined ? (at) => compare(at) <= 0 : (at) => compare(at) < 0;
    }
    if (node.agent) {
      const number = game.agents.findIndex((agent) => agent.name === node.agent);
      return (at, chosen) => chosen[number] === node.takes;
    }
    if (node.goal) {
      const number = game.world.landmarks.findIndex((landmark) => landmark.name === node.goal);
      return (at, chosen, goal) => goal === number;
    }
    if (node.not) {
      const part = formula(game, node.not, known);
      return (at, chosen, goal) => !part(at, chosen, goal);
    }
    const inner = (node.all || node.any).map((part) => formula(game, part, known));
    if (node.all) return (at, chosen, goal) => inner.every((part) => part(at, chosen, goal));
    return (at, chosen, goal) => inner.some((part) => part(at, chosen, goal));
  }

  /** The same, found once for the same actions: each state has a list of its own. */
  function remembering(part) {
    let last = null;
    let value = false;
    return (at, chosen, goal) => {
      if (chosen !== last) [last, value] = [chosen, part(at, chosen, goal)];
      return value;
    };
  }

  /** The actions that errors of at most eps in every feature can cause: a test can go either way where its cut is near.
   * An agent's `cuts`: by node, where the test divides what the feature measures; true or false where it has one answer,
   * null where nothing is measured.
   */
  function reachable(game, number, eps) {
    const { tree, features, cuts } = game.agents[number];
    const [over, under] = rational(eps);
    const sides = cuts.map((cut, node) => {
      if (cut === null || typeof cut === "boolean") return null;
      const terms = features[tree.feature[node]].terms.map(([weight, name]) => [String(weight), game.place[name]]);
      const [value, places] = rational(cut.at);
      const moved = (sign) => `${value * under + sign * over * places}/${places * under}`;
      return { least: comparison(terms, moved(1n)), most: comparison(terms, moved(-1n)) };
    });
    return (at) => {
      const observed = observe(game, number, at);
      const found = new Set();
      const walk = (node, bounds) => {
        const f = tree.feature[node];
        if (f < 0) return found.add(tree.action[node]);
        const cut = cuts[node];
        if (cut === null || typeof cut === "boolean") {
          const left = cut === null ? observed[f] <= tree.threshold[node] : cut;
          return walk(left ? tree.left[node] : tree.right[node], bounds);
        }
        const [low, high] = bounds[f] || [-Infinity, Infinity]; // ranks of the cuts that the path is between
        const least = sides[node].least(at);
        const most = sides[node].most(at);
        if (low < cut.rank && (cut.closed ? least <= 0 : least < 0)) {
          walk(tree.left[node], { ...bounds, [f]: [low, Math.min(high, cut.rank)] });
        }
        if (cut.rank < high && (cut.closed ? most > 0 : most >= 0)) {
          walk(tree.right[node], { ...bounds, [f]: [Math.max(low, cut.rank), high] });
        }
      };
      walk(0, {});
      return found;
    };
  }

  /** Every way to choose one of each. */
  function* joint(choices, upTo = choices.length) {
    if (!upTo) yield [];
    else for (const rest of joint(choices, upTo - 1)) for (const one of choices[upTo - 1]) yield [...rest, one];
  }

  /** A claim about decisions as a function of a state: whether it holds there. */
  function decisions(game, claim) {
    const holds = formula(game, claim.formula);
    if (claim.eps === null) {
      return (state, at = coordinates(game, state), chosen = actions(game, at)) => holds(at, chosen, state.goal);
    }
    const ways = game.agents.map((agent, number) =>
      agent.team === claim.team ? reachable(game, number, claim.eps) : null,
    );
    return (state, at = coordinates(game, state), chosen = actions(game, at)) => {
      const choices = ways.map((way, number) => [...new Set([...(way === null ? [] : way(at)), chosen[number]])]);
      for (const each of joint(choices)) {
        if (!holds(at, each, state.goal)) return false;
      }
      return true;
    };
  }

  // --- claims about episodes

  /** Whether the L-infinity distance of two points is at most, or at least, a radius, exactly. */
  function distances(radius) {
    const apart = comparison([["1", 0], ["-1", 1]], radius);
    const sides = ([ax, ay], [bx, by]) => [[ax, bx], [bx, ax], [ay, by], [by, ay]].map(apart);
    return {
      atMost: (a, b) => sides(a, b).every((sign) => sign <= 0),
      atLeast: (a, b) => sides(a, b).some((sign) => sign >= 0),
    };
  }

  /** Whether agents can each have a mark of their own; related[agent][mark]. */
  function matched(related) {
    const owner = new Map();
    const find = (agent, tried) =>
      related[agent].some((yes, mark) => {
        if (!yes || tried.has(mark)) return false;
        tried.add(mark);
        if (owner.has(mark) && !find(owner.get(mark), tried)) return false;
        owner.set(mark, agent);
        return true;
      });
    return related.every((_, agent) => find(agent, new Set()));
  }

  /** A claim about episodes as a function of a start: whether it holds from there, at rest. */
  function episodes(game, claim) {
    const { team, marks, pairs, steps, radius, always, apart } = claim.episode;
    const near = distances(radius);
    return (start) => {
      const rest = { ...start, velocity: start.velocity.map(() => [0, 0]) };
      const { states } = episode(game, rest, steps);
      const counted = always ? states : states.slice(-1);
      const met = (agent, mark) => {
        const test = ({ position }) => near[apart ? "atLeast" : "atMost"](position[team[agent]], position[marks[mark]]);
        return apart ? counted.every(test) : counted.some(test);
      };
      if (pairs !== null) return pairs.every(([agent, mark]) => met(agent, mark));
      return matched(team.map((_, agent) => marks.map((_, mark) => met(agent, mark))));
    };
  }

  /** That some agents take the same action in both of two profiles, as a function of a state. */
  function alike(game, claim) {
    return (state, at = coordinates(game, state), chosen = actions(game, at)) => {
      const others = actions(game, at, "other");
      return claim.alike.every((number) => chosen[number] === others[number]);
    };
  }

  /** A claim as a function of a state; null where it is about no single state. */
  function judge(game, claim) {
    if (claim.alike) return alike(game, claim);
    if (claim.episode) return episodes(game, claim);
    return claim.formula ? decisions(game, claim) : null;
  }

  /** What a run-time monitor says of a state: OK, LEAVING or OUTSIDE, by the region of a proof, rounded inward. For ever,
   * agents have to be in it where they come to rest, after `coasting` seconds at their speed: there is no LEAVING. */
  function monitor(game, region, coasting) {
    const { place, world } = game;
    const inside = within(game, region);
    return (state) => {
      const at = coordinates(game, state);
      if (!inside(at)) return "OUTSIDE";
      const after = at.slice();
      for (const { name } of world.agents) {
        for (const axis of ["x", "y"]) after[place[`${name}.${axis}`]] += (coasting || world.dt) * at[place[`${name}.v${axis}`]];
      }
      return inside(after) ? "OK" : coasting ? "OUTSIDE" : "LEAVING";
    };
  }

  /** Whether coordinates are in the region of a proof, rounded inward. */
  function within({ place }, region) {
    const gap = (at, first, second) => at[place[first]] - (second ? at[place[second]] : 0);
    return (at) =>
      region.bounds.every(([first, second, low, high]) => gap(at, first, second) >= low && gap(at, first, second) <= high) &&
      region.apart.every(([a, b, least]) => ["x", "y"].some((axis) => Math.abs(gap(at, `${a}.${axis}`, `${b}.${axis}`)) >= least)) &&
      (!region.goals.length || region.goals.some((goal) => ["x", "y"].every((axis) => at[place[`goal.${axis}`]] === at[place[`${goal}.${axis}`]])));
  }

  const OFF = 2 ** -40; // what rounding adds up to in a step, at most

  /** What a run-time monitor says of the last of the states of an episode, from its start on: whether all is as the proof
   * has it. The agents that it follows do what their trees decide, all others what they like; nobody pushes anybody.
   * What nothing has moved yet is where it was exactly: the proof knows on which side of a threshold that is. */
  function follower(game, { bounds, steps, followed }) {
    const inside = within(game, bounds);
    const led = (number, wanted, moves) => (moves ? Math.abs(number - wanted) <= OFF : number === wanted);
    const leads = (before, after) => {
      const told = actions(game, coordinates(game, before));
      const marks = ({ position }) => position.slice(game.world.agents.length).flat();
      const still = marks(before).every((number, k) => number === marks(after)[k]) && before.goal === after.goal;
      return still && game.agents.every((agent, i) => {
        const ways = followed.includes(i) ? [told[i]] : [...agent.actions.keys()];
        return ways.some((way) => {
          const { position, velocity } = step(game, before, told.map((own, j) => (j === i ? way : own)));
          return before.velocity[i].every((speed, axis) => {
            const wanted = velocity[i][axis];
            return led(after.position[i][axis], position[i][axis], speed !== 0) && led(after.velocity[i][axis], wanted, speed !== 0 || wanted !== 0);
          });
        });
      });
    };
    return (states) => {
      const starts = inside(coordinates(game, states[0])) && states[0].velocity.flat().every((speed) => speed === 0);
      const last = states.length - 1;
      if (!starts || last > steps || !states.slice(1).every((state, k) => leads(states[k], state))) return "OUTSIDE";
      return last < steps ? "OK" : "LEAVING";
    };
  }

  return { prepared, coordinates, rounded, observe, tested, given, path, after, affine, pieces, actions, step, episode, judge, monitor, follower, comparison };
})();

/* The networks that the trees were made from: two hidden layers of rectifiers. */
const Network = (() => {
  "use strict";
  const unpacked = new Map();

  function floats(text) {
    if (!unpacked.has(text)) {
      const bytes = Uint8Array.from(atob(text), (letter) => letter.charCodeAt(0));
      const view = new DataView(bytes.buffer);
      unpacked.set(text, Float64Array.from({ length: bytes.length / 4 }, (_, i) => view.getFloat32(4 * i, true)));
    }
    return unpacked.get(text);
  }

  /** The greedy action for one observation. */
  function act(layers, observation) {
    let values = observation;
    layers.forEach(({ weight, bias }, layer) => {
      const w = floats(weight);
      const found = Float64Array.from(floats(bias));
      for (let i = 0; i < values.length; i++) {
        for (let o = 0; o < found.length; o++) found[o] += values[i] * w[i * found.length + o];
      }
      values = layer < layers.length - 1 ? found.map((x) => Math.max(0, x)) : found;
    });
    return values.reduce((best, x, i) => (x > values[best] ? i : best), 0);
  }

  return { act };
})();
