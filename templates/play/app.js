/* The page: draws a state, the trees that decide in it and where a claim fails, and lets a reader change the state. */
(() => {
  "use strict";
  const data = JSON.parse(document.getElementById("data").textContent);
  const game = Engine.prepared(data);
  const { world, agents, entities } = game;
  const get = (id) => document.getElementById(id);
  const placed = Slice === null; // the page knows how everybody moves
  const judges = data.claims.map((claim) => (placed ? Engine.judge(game, claim) : null));
  const LOOKS = { OK: "holds", LEAVING: "other", OUTSIDE: "fails", INVALID: "fails" };
  const worded = data.claims.some((claim) => claim.words); // of the recorded episode, in a stated system
  const monitors = data.claims.map((claim) => (placed && claim.region ? Engine.monitor(game, claim.region, claim.coasting) : null));
  const followers = data.claims.map((claim) => (placed && claim.follows ? Engine.follower(game, claim.follows) : null));
  const COLOURS = ["#c9ced6", "#8ecdf0", "#f2b84b", "#dfa5c8", "#6cc7a4", "#e8e07a", "#d98c6b", "#9aa9e8"];
  const CELLS = 120; // of the coloured ground, on each axis
  const READABLE = 0.85; // of the size of its letters, below which a tree folds
  const HALF = 60; // of the scene's view box
  const reach = 1.25 * Math.max(1e-9, ...[world.low, world.high, ...entities.flatMap((one) => one.start || [])].map(Math.abs));
  const SVG = "http://www.w3.org/2000/svg";

  // --- what is shown

  let start = null; // the state that the episode starts in
  let states = [];
  let time = 0;
  let chosen = agents.findIndex((agent) => agent.team === (data.claims[0] || {}).team);
  if (chosen < 0) chosen = 0;
  let claim = 0;
  let steering = false;
  let playing = null;
  let hovered = null; // {agent, tree, node}
  const film = placed ? null : data.recorded; // an episode of a game whose rules the page does not know
  // without places: what each agent observes
  /** As many digits as a hand on a slider means. */
  const few = (x) => Number(x.toPrecision(5));
  let seen = agents.map((agent, number) => film ? [...film.seen[number][0]] : agent.shown.map(([low, high], f) => agent.features[f].initial ?? Engine.rounded(agent)(few((low + high) / 2))));
  const remembers = !placed && !film && agents.some(({ features }) => features.some(({ initial }) => initial !== undefined));
  /** A number that an agent can observe, or remember: a whole one in its range. */
  const settle = (agent, { initial, low, high }, x) =>
    initial === undefined ? Engine.rounded(agent)(x) : Math.min(Math.max(Math.round(x), low), high);
  let retell = () => {}; // writes `seen` into sliders and fields
  // whose trees act: 0 the profile's own, 1 those of the profile that it is compared with
  const TEAMS = agents.length && agents[0].other ? ["tree", "other"] : ["tree"];
  let acting = 0;

  const now = () => states[time];

  /** The claim of that number; of one about one agent, the agent too. */
  function ask(number) {
    claim = number;
    const { alike: compared, team } = data.claims[claim] || {};
    const first = agents.findIndex((agent) => agent.team === team);
    if (compared && compared.length === 1) chosen = compared[0];
    else if (first >= 0 && agents[chosen].team !== team) chosen = first;
  }

  function restart(state) {
    start = state;
    states = [state];
    time = 0;
    pause();
    show();
  }

  /** The state of a file or of the address: coordinates by name. */
  function stateOf(position, goal) {
    const at = (one, axis) => Number(position[`${one.name}.${axis}`] || 0);
    const landmark = world.landmarks.findIndex((one) => one.name === goal);
    return {
      position: entities.map((one) => [at(one, "x"), at(one, "y")]),
      velocity: world.agents.map((one) => [at(one, "vx"), at(one, "vy")]),
      goal: world.goals.length ? Math.max(0, landmark) : null,
    };
  }

  /** A start at rest. `share`: of an entity's range, by its number and axis; `goal`: of the goals. */
  function startAt(share, goal) {
    const goals = world.goals.map((name) => world.landmarks.findIndex((one) => one.name === name));
    return {
      position: entities.map((one, i) => [0, 1].map((axis) => {
        const [low, high] = one.start || [world.low, world.high];
        return low + share(i, axis) * (high - low);
      })),
      velocity: world.agents.map(() => [0, 0]),
      goal: goals.length ? goals[Math.floor(goal * goals.length)] : null,
    };
  }
  const randomState = () => startAt(Math.random, Math.random());
  /** The same for everybody: all stand on a circle. */
  const statedState = () => startAt((i, axis) => 0.5 + 0.3 * Math.sin((2 * Math.PI * i) / entities.length + (axis ? 0 : Math.PI / 2)), 0);

  // --- the address holds the state

  function remember() {
    const { position, velocity, goal } = now();
    const text = JSON.stringify({ position, velocity, goal, claim, agent: chosen, acting });
    history.replaceState(null, "", `#${encodeURIComponent(text)}`);
  }

  /** The state that the address names: a claim's by its number in the report, or any. */
  function remembered() {
    const numbered = /^#claim-(\d+)$/.exec(location.hash);
    if (numbered && data.claims[numbered[1] - 1]) {
      ask(numbered[1] - 1);
      const stored = data.states.find((one) => one.claim === claim);
      return stored ? stateOf(stored.position, stored.goal) : statedState();
    }
    try {
      const { position, velocity, goal, claim: which, agent, acting: whose } = JSON.parse(decodeURIComponent(location.hash.slice(1)));
      const points = (some, n) => some.length === n && some.every((p) => p.length === 2 && p.every(Number.isFinite));
      const sound = points(position, entities.length) && points(velocity, world.agents.length);
      const aimed = world.goals.length ? world.goals.includes((world.landmarks[goal] || {}).name) : goal === null;
      if (!sound || !aimed) return null;
      if (data.claims[which]) claim = which;
      if (agents[agent]) chosen = agent;
      if (TEAMS[whose]) acting = whose;
      return { position, velocity, goal };
    } catch {
      return null;
    }
  }

  // --- the episode

  /** The generated code decides as the tree does, bit for bit. */
  function ensureCoded(number, observed, found) {
    const coded = Policy.ACT[agents[number].name](observed);
    const alike = Array.isArray(found) ? found.every((value, place) => Object.is(value, coded[place])) : coded === found;
    if (!alike) throw new Error(`${agents[number].name}: code and tree decide differently`);
  }

  function decided(at) {
    const found = Engine.actions(game, at, TEAMS[acting]);
    if (Policy && acting === 0) {
      agents.forEach((agent, number) => ensureCoded(number, Engine.observe(game, number, at), found[number]));
    }
    return found;
  }

  /** Adds a step after the one shown and goes there; `own`: the action of the steered agent. */
  function extend(own) {
    states.length = time + 1;
    const found = decided(Engine.coordinates(game, now()));
    if (own !== undefined) found[chosen] = own;
    states.push(Engine.step(game, now(), found));
    time += 1;
  }

  const last = () => (film ? film.seen[0].length - 1 : world.steps);

  /** Shows a step of the recorded episode. */
  function wind(to) {
    time = Math.max(0, Math.min(last(), to));
    seen = film.seen.map((rows) => [...rows[time]]);
    retell();
    show();
  }

  /** One step on, along what was played before unless somebody steers. */
  function advance(own) {
    if (film) return wind(time + 1);
    if (!placed) return recall(Engine.after);
    if (time < states.length - 1 && own === undefined) time += 1;
    else extend(own);
    show();
  }

  /** Changes what all remember. */
  function recall(change) {
    seen = agents.map((agent, number) => change(agent, seen[number]));
    retell();
    show();
  }
  const forget = () => recall(({ features }, values) => values.map((value, f) => features[f].initial ?? value));

  function pause() {
    clearInterval(playing);
    playing = null;
    get("run").textContent = "Play";
  }

  function run() {
    if (playing !== null) return pause();
    if (time >= last()) time = 0;
    get("run").textContent = "Pause";
    playing = setInterval(() => (time >= last() ? pause() : advance()), 1000 * Math.max(world.dt, 0.05) * 1.5);
  }

  // --- the arena

  const toView = ([x, y]) => [(x / reach) * HALF, (-y / reach) * HALF];
  const element = (name, attributes, parent) => {
    const made = document.createElementNS(SVG, name);
    for (const [key, value] of Object.entries(attributes)) made.setAttribute(key, value);
    if (parent) parent.append(made);
    return made;
  };
  const words = (name) => name.toLowerCase().split(/[^a-z0-9]+/).filter(Boolean);
  const IDLE = ["stay", "noop", "none", "nothing", "idle", "coast", "wait"];
  const idle = (action) => (action.effect ? action.effect.every((push) => push === 0) : words(action.name).some((word) => IDLE.includes(word)));
  const SIGNS = { left: "\u2190", right: "\u2192", down: "\u2193", up: "\u2191" };

  /** The sign of one action, by its effect or by its name; "": neither tells. */
  function sign(action) {
    if (idle(action)) return "\u00b7";
    const [x, y] = action.effect || [0, 0];
    if (action.effect) return x < 0 ? SIGNS.left : x > 0 ? SIGNS.right : y < 0 ? SIGNS.down : SIGNS.up;
    return words(action.name).map((word) => SIGNS[word]).find(Boolean) || "";
  }

  const initials = (action) => words(action.name).map((word) => word[0]).join("").slice(0, 2);
  const glyphs = new Map(); // action -> its sign, of few letters, unlike the other actions'
  const colours = new Map(); // gray is what does nothing
  for (const { actions } of agents) {
    const kinds = [sign, initials, (action) => action.name.slice(0, action.name.length > 3 ? 2 : 3), (action) => String(actions.indexOf(action))];
    const told = (kind) => actions.map(kind);
    const unlike = (signs) => signs.every(Boolean) && new Set(signs).size === signs.length;
    // pushes in a plane have their arrows, even where two of them are alike
    const chosenSigns = actions.every((action) => action.effect) ? told(sign) : kinds.map(told).find(unlike);
    const lively = actions.filter((action) => !idle(action));
    actions.forEach((action, place) => {
      glyphs.set(action, chosenSigns[place]);
      colours.set(action, COLOURS[idle(action) ? 0 : 1 + (lively.indexOf(action) % (COLOURS.length - 1))]);
    });
  }
  const glyph = (action) => glyphs.get(action);
  /** Three digits, and more where people wrote them: 23.25 stays, 1234.5 is 1235. */
  function brief(x) {
    const written = Number(x.toPrecision(6));
    const before = Math.abs(x) < 1e6 ? String(Math.trunc(Math.abs(x))).length : 0;
    return String(written === x ? written : Number(x.toPrecision(Math.max(3, before))));
  }
  const signed = (action) => (/\w/.test(glyph(action)) ? action.name : `${glyph(action)} ${action.name}`);

  const slice = placed ? null : Slice({
    agents, get, element, colours, glyph, brief,
    seen: () => seen,
    trace: (number) => (film ? film.seen[number].slice(0, time + 1) : []),
    /** Moves the features of an agent to values. */
    change: (number, axes, values) => {
      pause();
      axes.forEach((f, axis) => (seen[number][f] = settle(agents[number], agents[number].features[f], few(values[axis]))));
      retell();
      show();
    },
  });

  let drawing = 0; // the latest ground that was asked for

  /** A pattern of slanted lines. */
  const hatching = (() => {
    const tile = Object.assign(document.createElement("canvas"), { width: 12, height: 12 });
    const pen = tile.getContext("2d");
    Object.assign(pen, { strokeStyle: "#8f1d15", lineWidth: 3 });
    for (const x of [-12, 0, 12]) pen.stroke(new Path2D(`M${x - 2} 14L${x + 14} -2`));
    return pen.createPattern(tile, "repeat");
  })();

  /** Colours the ground by the chosen agent's action there, hatched where the claim fails; coarse first, then fine. */
  function drawGround() {
    const asked = ++drawing;
    const canvas = get("ground");
    const pen = canvas.getContext("2d");
    const mover = hovered ? hovered.agent : chosen;
    const tree = hovered ? hovered.tree : agents[mover][TEAMS[acting]];
    const judge = (hovered ? null : judges[claim]) || null;
    const slow = judge !== null && Boolean(data.claims[claim].episode);
    let row = 0;
    const cells = slow ? CELLS / 4 : CELLS;
    const size = canvas.width / cells;
    const base = now();
    const part = () => {
      if (asked !== drawing) return;
      const end = performance.now() + 12;
      for (; row < cells && performance.now() < end; row++) {
        for (let column = 0; column < cells; column++) drawCell(pen, base, { mover, tree, judge }, row, column, cells, size);
      }
      if (row < cells) requestAnimationFrame(part);
      else drawGlyphs(pen, base, mover, tree);
    };
    part();
  }

  const placeOf = (row, column, cells) => [
    ((column + 0.5) / cells) * 2 * reach - reach,
    reach - ((row + 0.5) / cells) * 2 * reach,
  ];

  function movedTo(base, mover, point) {
    return { ...base, position: base.position.map((p, i) => (i === mover ? point : p)) };
  }

  function drawCell(pen, base, { mover, tree, judge }, row, column, cells, size) {
    const state = movedTo(base, mover, placeOf(row, column, cells));
    const at = Engine.coordinates(game, state);
    const observed = Engine.observe(game, mover, at);
    const path = Engine.path(tree, observed);
    pen.globalAlpha = 1;
    pen.fillStyle = colours.get(agents[mover].actions[tree.action[path[path.length - 1]]]);
    if (hovered) {
      const { node } = hovered;
      const inside = tree.feature[node] < 0 ? path.includes(node) : Engine.tested(tree, observed)[tree.feature[node]] <= tree.threshold[node];
      pen.globalAlpha = inside ? 1 : 0.25;
      pen.clearRect(column * size, row * size, size, size);
    }
    pen.fillRect(column * size, row * size, Math.ceil(size), Math.ceil(size));
    if (judge === null || judge(state)) return;
    pen.fillStyle = hatching;
    pen.fillRect(column * size, row * size, Math.ceil(size), Math.ceil(size));
  }

  /** Actions as signs too, so that nothing depends on colour alone. */
  function drawGlyphs(pen, base, mover, tree) {
    const coarse = 10;
    pen.globalAlpha = 0.55;
    pen.fillStyle = "#17212e";
    pen.font = "18px system-ui, sans-serif";
    pen.textAlign = "center";
    pen.textBaseline = "middle";
    const size = get("ground").width / coarse;
    for (let row = 0; row < coarse; row++) {
      for (let column = 0; column < coarse; column++) {
        const state = movedTo(base, mover, placeOf(row, column, coarse));
        const { actions } = agents[mover];
        const path = Engine.path(tree, Engine.observe(game, mover, Engine.coordinates(game, state)));
        pen.fillText(glyph(actions[tree.action[path[path.length - 1]]]), (column + 0.5) * size, (row + 0.5) * size);
      }
    }
    pen.globalAlpha = 1;
  }

  /** `taken`: what each agent does; `others`: what it would do in the profile that it is compared with. */
  function drawScene(taken, others) {
    const scene = get("scene");
    const focused = document.activeElement && document.activeElement.dataset ? document.activeElement.dataset.entity : undefined;
    scene.replaceChildren();
    world.agents.forEach((entity, i) => {
      const points = states.slice(0, time + 1).map((state) => toView(state.position[i]).join(","));
      element("polyline", { class: "track", points: points.join(" "), stroke: teamColour(i) }, scene);
    });
    const covered = entities.flatMap((entity, i) => drawEntity(scene, entity, i, taken, others));
    entities.forEach((entity, i) => drawLabel(scene, entity, i, covered));
    if (focused !== undefined) scene.querySelector(`[data-entity="${focused}"]`).focus();
  }

  const teams = [...new Set(agents.map((agent) => agent.team))];
  const teamColour = (i) => ["#c2410c", "#1d4ed8", "#6d28d9", "#0f766e"][teams.indexOf(agents[i].team) % 4];

  const crowded = agents.length + world.landmarks.length > 12; // then names hide each other, and numbers stand for them

  const isGoal = (i) => i >= agents.length && now().goal === i - agents.length;
  const radius = (entity) => Math.max(2.2, (entity.size / reach) * HALF);
  const around = ([x, y], wide, tall = wide) => [x - wide, y - tall, x + wide, y + tall];

  /** An agent with the way that it goes now, or a landmark; the rectangles that it covers. */
  function drawEntity(scene, entity, i, taken, others) {
    const [x, y] = toView(now().position[i]);
    const agent = i < agents.length;
    const size = radius(entity);
    const title = `${entity.name}${isGoal(i) ? ", the goal" : ""} at ${now().position[i].map((c) => c.toFixed(3)).join(", ")}`;
    const group = element("g", { class: `entity${agent && i === chosen ? " chosen" : ""}`, tabindex: 0, role: "button", "data-entity": i, "aria-label": title }, scene);
    element("title", {}, group).textContent = title;
    const covered = [around([x, y], size)];
    if (!agent) {
      element("rect", { class: "ring", x: x - size, y: y - size, width: 2 * size, height: 2 * size, fill: isGoal(i) ? "#19693a" : "#55606f" }, group);
      return covered;
    }
    const heading = (action, kind) => {
      const [ex, ey] = agents[i].actions[action].effect || [0, 0];
      if (!ex && !ey) return;
      const at = (along, aside) => `${x + along * ex - aside * ey},${y - along * ey - aside * ex}`;
      const end = size + 7;
      const d = `M${at(size, 0)} L${at(end, 0)} M${at(end - 2.5, 2)} L${at(end, 0)} L${at(end - 2.5, -2)}`;
      for (const one of ["under", kind]) element("path", { class: `heading ${one}`, d, stroke: teamColour(i) }, scene);
      covered.push(around([x + ex * (end - 4), y - ey * (end - 4)], 4.5));
    };
    if (others[i] !== taken[i]) heading(others[i], "other");
    heading(taken[i], "");
    element("circle", { class: "ring", cx: x, cy: y, r: size, fill: teamColour(i) }, group);
    return covered;
  }

  /** A name beside its entity, where it covers least of what is there; it covers its place too then. */
  function drawLabel(scene, entity, i, covered) {
    const text = `${crowded ? entity.name.match(/\d*$/)[0] || entity.name : entity.name}${isGoal(i) ? " \u2605" : ""}`;
    const [x, y] = toView(now().position[i]);
    const [wide, tall] = [text.length + 1, 2];
    const shared = ([a, b, c, d]) => ([e, f, g, h]) => Math.max(0, Math.min(c, g) - Math.max(a, e)) * Math.max(0, Math.min(d, h) - Math.max(b, f));
    const area = (box) => covered.map(shared(box)).reduce((sum, part) => sum + part, 0);
    const inside = (c, half) => Math.max(half - HALF, Math.min(HALF - half, c));
    const boxes = [0, 5, 10, 16].flatMap((more) => {
      const [aside, above] = [radius(entity) + wide + more, radius(entity) + tall + more];
      return [[0, -above], [0, above], [aside, 0], [-aside, 0], [aside, -above], [-aside, above], [aside, above], [-aside, -above]];
    }).map(([dx, dy]) => around([inside(x + dx, wide), inside(y + dy, tall)], wide, tall));
    const best = boxes.reduce((one, other) => (area(other) < area(one) ? other : one));
    covered.push(best);
    element("text", { x: (best[0] + best[2]) / 2, y: best[3] - 0.8 }, scene).textContent = text;
  }

  // --- moving things

  function moved(i, point) {
    const state = now();
    const clamped = point.map((c) => Math.max(-reach, Math.min(reach, c)));
    restart({ ...state, position: state.position.map((p, j) => (j === i ? clamped : p)) });
  }

  function pointOf(event) {
    const box = get("arena").getBoundingClientRect();
    return [((event.clientX - box.left) / box.width) * 2 * reach - reach, reach - ((event.clientY - box.top) / box.height) * 2 * reach];
  }

  function aim(i) {
    const landmark = i - agents.length;
    if (landmark < 0 || !world.goals.includes(world.landmarks[landmark].name)) return;
    restart({ ...now(), goal: landmark });
  }

  function watchArena() {
    let dragged = null;
    const arena = get("arena");
    const entityOf = (event) => (event.target.closest ? event.target.closest("[data-entity]") : null);
    arena.addEventListener("pointerdown", (event) => {
      const found = entityOf(event);
      if (!found) return;
      dragged = Number(found.dataset.entity);
      if (dragged < agents.length) chosen = dragged;
      arena.setPointerCapture(event.pointerId);
    });
    arena.addEventListener("pointermove", (event) => dragged !== null && moved(dragged, pointOf(event)));
    const drop = (event) => {
      if (dragged !== null) {
        show();
        arena.releasePointerCapture(event.pointerId);
      }
      dragged = null;
    };
    arena.addEventListener("pointerup", drop);
    arena.addEventListener("pointercancel", drop);
    arena.addEventListener("dblclick", (event) => {
      const point = pointOf(event);
      const gaps = world.landmarks.map((_, j) => Math.hypot(...now().position[agents.length + j].map((c, k) => c - point[k])));
      const nearest = gaps.indexOf(Math.min(...gaps));
      if (gaps[nearest] < 0.15 * reach) aim(agents.length + nearest);
    });
    document.addEventListener("keydown", onKey);
  }

  const ARROWS = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowDown: [0, -1], ArrowUp: [0, 1] };

  function onKey(event) {
    const arrow = ARROWS[event.key];
    const inForm = event.target.closest && event.target.closest("select, input");
    if (inForm) return;
    const entity = event.target.dataset ? event.target.dataset.entity : undefined;
    const onButton = event.key === " " && event.target.closest && event.target.closest("button, summary, .folded");
    if (steering && !onButton && (arrow || event.key === " ")) {
      const wanted = arrow || [0, 0];
      const own = agents[chosen].actions.findIndex(({ effect }) => effect && effect[0] === wanted[0] && effect[1] === wanted[1]);
      if (own >= 0) {
        event.preventDefault();
        advance(own);
      }
    } else if (entity !== undefined && arrow) {
      event.preventDefault();
      const by = (event.shiftKey ? 0.01 : 0.05) * reach;
      moved(Number(entity), now().position[entity].map((c, axis) => c + by * arrow[axis]));
    } else if (entity !== undefined && (event.key === "g" || event.key === "G")) {
      aim(Number(entity));
    }
  }

  // --- the claim

  /** The word of the recorded step, as long as the reader has not changed what is observed. */
  function wordOf(words) {
    return film.seen.every((rows, agent) => rows[time].every((number, place) => number === seen[agent][place])) ? words[time] : null;
  }

  function drawClaim() {
    const badge = get("badge");
    const asked = data.claims[claim];
    if (!asked) return;
    const judge = judges[claim];
    const word = asked.words ? wordOf(asked.words) : monitors[claim] ? monitors[claim](now())
      : followers[claim] && followers[claim](states.slice(0, time + 1));
    get("word").hidden = !word;
    if (word) {
      get("word").className = `badge ${LOOKS[word]}`;
      get("word").textContent = `monitor: ${word}`;
    }
    get("sentence").textContent = `${asked.sentence}${asked.verdict ? ` \u2014 ${asked.verdict}` : ""}`;
    if (judge === null) {
      badge.className = "badge other";
      badge.textContent = asked.unjudged;
      return;
    }
    const holds = judge(asked.episode ? start : now());
    badge.className = `badge ${holds ? "holds" : "fails"}`;
    const where = asked.episode ? "from this start" : "here";
    const [yes, no] = asked.alike ? ["the same", "DIFFERENT"] : ["holds", "FAILS"];
    badge.textContent = holds ? `\u2713 ${yes} ${where}` : `\u2717 ${no} ${where}`;
  }

  // --- the trees

  const opened = new Map(); // tree -> folded nodes that the reader opened
  for (const agent of agents) for (const team of TEAMS) opened.set(agent[team], new Set());

  const LEVEL = 76; // between the levels of a tree
  const giving = agents.some((agent) => agent.outputs);
  const APART = giving ? 98 : 54; // between leaves

  const ruler = document.createElement("canvas").getContext("2d");
  ruler.font = "600 11px system-ui, sans-serif"; // as leaves have it; other nodes' letters are narrower
  const fits = (text, room) => ruler.measureText(text).width <= room;

  /** A text that ends in an ellipsis. */
  const cut = (text, room) => (fits(`${text}\u2026`, room) ? `${text}\u2026` : cut(text.slice(0, -1), room));

  /** A name in lines of at most so many units, broken behind its words where it can be; the rest is on its title. */
  function wrapped(name, room, most) {
    const lines = [""];
    for (const part of name.match(/(?:[^_ .-]|\.(?=\d))*(?:[_ -]|\.(?!\d))*/g).filter(Boolean)) {
      if (lines[lines.length - 1] && !fits(lines[lines.length - 1] + part, room)) lines.push("");
      lines[lines.length - 1] += part;
    }
    if (lines.length > most) lines.splice(most - 1, lines.length, cut(lines[most - 1], room));
    return lines.map((line) => line.trim()).map((line) => (fits(line, room) ? line : cut(line, room)));
  }

  /** What stands below each node of a tree, in words that equal parts share; children come after their parents. */
  function partsOf({ feature, threshold, left, right, action }) {
    const found = [];
    for (let node = feature.length - 1; node >= 0; node--) {
      found[node] = feature[node] < 0 ? String(action[node]) : `${feature[node]} ${threshold[node]} (${found[left[node]]}) (${found[right[node]]})`;
    }
    return found;
  }

  const alike = new Map(); // tree -> roots of parts that are the same in the other profile
  const changed = new Map(); // tree -> the first nodes that are not
  for (const agent of TEAMS.length > 1 ? agents : []) {
    const trees = TEAMS.map((team) => agent[team]);
    const parts = trees.map(partsOf);
    for (const tree of trees) for (const kind of [alike, changed]) kind.set(tree, new Set());
    const walk = (nodes) => {
      const [first, second] = nodes.map((node, which) => parts[which][node].split(" (")[0]);
      const kind = parts[0][nodes[0]] === parts[1][nodes[1]] ? alike : first !== second ? changed : null;
      if (kind) nodes.forEach((node, which) => kind.get(trees[which]).add(node));
      else for (const side of ["left", "right"]) walk(nodes.map((node, which) => trees[which][side][node]));
    };
    walk([0, 0]);
  }
  const settled = (tree, node) => alike.has(tree) && alike.get(tree).has(node) && !opened.get(tree).has(node);

  function layout(tree, live, most) {
    const shown = new Set([0]);
    for (const node of live) {
      shown.add(node);
      if (settled(tree, node)) break;
    }
    const waiting = [0];
    let ends = 1;
    for (let i = 0; i < waiting.length; i++) {
      const node = waiting[i];
      if (tree.feature[node] < 0 || settled(tree, node)) continue;
      if (ends >= most && !shown.has(tree.left[node]) && !shown.has(tree.right[node]) && !opened.get(tree).has(node)) continue;
      ends += 1;
      for (const child of [tree.left[node], tree.right[node]]) {
        shown.add(child);
        waiting.push(child);
      }
    }
    const isEnd = (node) => tree.feature[node] < 0 || !shown.has(tree.left[node]);
    const places = new Map();
    let next = 0;
    let deepest = 0;
    const order = [[0, 0]];
    const drawn = [];
    while (order.length) {
      const [node, level] = order.pop();
      drawn.push([node, level]);
      deepest = Math.max(deepest, level);
      if (!isEnd(node)) order.push([tree.right[node], level + 1], [tree.left[node], level + 1]);
      else places.set(node, APART * next++ + 0.5 * APART + 7);
    }
    for (const [node] of [...drawn].reverse()) {
      if (!places.has(node)) places.set(node, (places.get(tree.left[node]) + places.get(tree.right[node])) / 2);
    }
    return { drawn, places, isEnd, width: Math.max(140, APART * next + 20), height: LEVEL * deepest + (giving ? 66 : 56), shift: Math.max(0, 60 - 0.5 * APART * next) };
  }

  /** Of each node what stands at the leaves below it, added up. */
  function summed(tree, atLeaves) {
    const found = [...atLeaves];
    for (let node = tree.feature.length - 1; node >= 0; node--) {
      if (tree.feature[node] >= 0) found[node] = found[tree.left[node]] + found[tree.right[node]];
    }
    return found;
  }
  const leavesBelow = new Map();
  const visits = new Map();
  for (const tree of opened.keys()) {
    leavesBelow.set(tree, summed(tree, tree.feature.map(() => 1)));
    visits.set(tree, tree.visits && summed(tree, tree.visits));
  }
  // a test as people read it: the last number below 0 is "< 0"
  const tiny = 2 ** -126;
  /** The number of few digits that comes right after a threshold, of which it is what a test `x < 19.5` became. */
  function bound(x) {
    const round = Number(x.toPrecision(4));
    const [single, double] = [Float32Array.of(x), Float64Array.of(x)];
    new Int32Array(single.buffer)[0] += x > 0 ? 1 : -1;
    new BigInt64Array(double.buffer)[0] += x > 0 ? 1n : -1n;
    const near = (Math.fround(x) === x && single[0] === round) || double[0] === round;
    return Math.abs(x) > tiny ? (near ? round : null) : x < 0 ? 0 : null;
  }
  const atMost = (x) => Math.abs(x) > tiny ? x : 0;
  const test = (x) => bound(x) === null ? `\u2264 ${brief(atMost(x))}` : `< ${brief(bound(x))}`;
  const leftIf = (x) => bound(x) === null ? `at most ${atMost(x)}` : `below ${bound(x)}`;

  function drawTree(number, observed) {
    TEAMS.forEach((team, which) => {
      const box = get(`${team}-${number}`);
      if (box) drawOne(number, agents[number][team], box, observed, which);
    });
    const agent = agents[number];
    const ends = TEAMS.map((team) => leafOf(agent[team], observed));
    const given = agent.outputs && Engine.given(agent, agent.tree, ends[0], observed);
    if (Policy && !placed) ensureCoded(number, observed, given || agent.tree.action[ends[0]]);
    if (given) slice.drawBars(number, given);
    get(`says-${number}`).textContent = told(number, agent.tree, observed) + (given ? "" : besides(number, observed, ends));
  }

  const leafOf = (tree, observed) => Engine.path(tree, observed).pop();

  function drawOne(number, tree, box, observed, which) {
    const agent = agents[number];
    const live = Engine.path(tree, observed);
    const most = Math.max(4, Math.floor(box.clientWidth / (READABLE * APART))); // leaves that fit
    const { drawn, places, isEnd, width, height, shift } = layout(tree, live, most);
    const label = `tree of ${agent.name}${which ? " in the second profile" : ""}`;
    const svg = element("svg", { viewBox: `${-shift} 0 ${width} ${height}`, role: "group", "aria-label": label });
    const y = new Map(drawn.map(([node, level]) => [node, 28 + LEVEL * level]));
    const onPath = new Set(live);
    const met = visits.get(tree);
    for (const [node] of drawn) {
      if (isEnd(node)) continue;
      for (const child of [tree.left[node], tree.right[node]]) {
        const share = met ? met[child] / Math.max(1, met[0]) : 0;
        element("path", {
          class: onPath.has(child) ? "live" : "",
          d: `M${places.get(node)},${y.get(node)} L${places.get(child)},${y.get(child)}`,
          "stroke-width": onPath.has(child) ? Math.max(3, 1 + 9 * share) : 1 + 9 * share,
        }, svg);
      }
    }
    const here = (node) => ({ x: places.get(node), y: y.get(node), live: onPath.has(node), end: isEnd(node) });
    for (const [node] of drawn) drawNode(svg, number, tree, node, here(node), observed);
    svg.style.maxWidth = `${1.4 * width}px`; // a small one does not grow without end
    box.replaceChildren(svg);
  }

  /** What a test asks for: a feature, or a sum of them in words. */
  function asks({ features }, tree, node) {
    const f = tree.feature[node];
    return f < features.length ? features[f].name : tree.sums[f - features.length].words;
  }

  /** What a leaf does; of outputs, their sums in words. */
  function does({ actions, outputs }, tree, leaf) {
    if (!outputs) return signed(actions[tree.action[leaf]]);
    return outputs.map(({ name }, place) => `${name} = ${tree.vectors[tree.action[leaf]][place].words}`).join(", ");
  }

  /** What a tree does, and how near its nearest test is. */
  function told(number, tree, observed) {
    const agent = agents[number];
    const live = Engine.path(tree, observed);
    const leaf = live.pop();
    const compared = Engine.tested(tree, observed);
    const margins = live.map((node) => [Math.abs(compared[tree.feature[node]] - tree.threshold[node]), node]);
    const [least, at] = margins.length ? margins.reduce((a, b) => (b[0] < a[0] ? b : a)) : [null, 0];
    const nearest = least === null ? "" : `; nearest test: ${asks(agent, tree, at)}, ${brief(least)} away`;
    return `${does(agent, tree, leaf)}, leaf ${leaf}${nearest}`;
  }

  /** What stands beside a tree's action: the second profile's, or the expert's. */
  function besides(number, observed, [leaf, other]) {
    const { actions, tree, other: second } = agents[number];
    if (!second) return expertSays(number, observed, actions[tree.action[leaf]]);
    const action = actions[second.action[other]];
    if (second.action[other] === tree.action[leaf]) return "; the same in the second profile";
    return `; the second profile: ${signed(action)}, leaf ${other}`;
  }

  function drawNode(svg, number, tree, node, { x, y, live, end }, observed) {
    const agent = agents[number];
    const { actions, outputs } = agent;
    const split = tree.feature[node] >= 0;
    const folded = split && end;
    const other = changed.has(tree) && changed.get(tree).has(node) ? "changed " : "";
    const group = element("g", { class: `${other}${live ? "live " : ""}${folded ? "folded" : split ? "" : "leaf"}` }, svg);
    const wide = split && !folded ? 104 : giving ? 92 : 50;
    const lines = folded ? ["\u25b8", `${leavesBelow.get(tree)[node]} leaves`, ...(settled(tree, node) ? ["alike"] : [])]
      : split ? [...wrapped(asks(agent, tree, node), wide - 6, 2), test(tree.threshold[node])]
      : outputs ? tree.vectors[tree.action[node]].map((each) => wrapped(each.words, wide - 6, 1)[0]).slice(0, 4)
      : wrapped(actions[tree.action[node]].name, wide - 4, 3);
    const tall = 12 * lines.length + 8;
    const rect = element("rect", { x: x - wide / 2, y: y - tall / 2, width: wide, height: tall, rx: split ? 4 : 13 }, group);
    if (!split && !outputs) rect.setAttribute("style", `fill:${colours.get(actions[tree.action[node]])}`);
    lines.forEach((line, i) => {
      element("text", { x, y: y - tall / 2 + 13 + 12 * i }, group).textContent = line;
    });
    const met = visits.get(tree);
    const count = met ? `, ${((100 * met[node]) / Math.max(1, met[0])).toFixed(1)} % of decisions` : "";
    const value = split
      ? `${asks(agent, tree, node)} is ${brief(Engine.tested(tree, observed)[tree.feature[node]])}; left if ${leftIf(tree.threshold[node])}`
      : `${outputs ? does(agent, tree, node) : actions[tree.action[node]].name}, leaf ${node}`;
    element("title", {}, group).textContent = value + count;
    group.addEventListener("pointerenter", () => hover({ agent: number, tree, node }));
    group.addEventListener("pointerleave", () => hover(null));
    if (!folded) return;
    const open = () => {
      const box = svg.parentElement;
      opened.get(tree).add(node);
      show();
      (box.querySelector(".folded") || box.closest("details").firstElementChild).focus();
    };
    group.setAttribute("tabindex", 0);
    group.setAttribute("role", "button");
    group.addEventListener("click", open);
    group.addEventListener("keydown", (event) => ["Enter", " "].includes(event.key) && (event.preventDefault(), open()));
  }

  function hover(what) {
    hovered = what;
    if (placed) drawGround();
    else slice.draw(hovered);
  }

  function expertSays(number, observed, action) {
    const net = (data.experts || [])[number];
    if (!net) return "";
    const expert = agents[number].actions[Network.act(net, observed)];
    return expert === action ? "; its expert does the same" : `; its expert: ${signed(expert)}`;
  }

  // --- all together

  function show() {
    let observed = seen;
    if (placed) {
      const at = Engine.coordinates(game, now());
      observed = agents.map((_, number) => Engine.observe(game, number, at));
      const found = decided(at);
      drawScene(found, TEAMS.length > 1 ? Engine.actions(game, at, TEAMS[1 - acting]) : found);
      drawClaim();
      drawGround();
      remember();
    }
    if (placed || film) drawTime();
    if (worded) drawClaim();
    agents.forEach((_, number) => get(`more-${number}`).open && drawTree(number, observed[number]));
    get("agent").value = chosen;
    get("claim").value = claim;
    get("acting").value = acting;
    get("steer").setAttribute("aria-pressed", steering);
    if (!placed) slice.draw(hovered);
    drawLegend();
  }

  function drawTime() {
    get("scrub").max = film ? last() : Math.max(world.steps, states.length - 1);
    get("scrub").value = time;
    const changed = film && film.seen.some((rows, number) => rows[time].some((x, f) => x !== seen[number][f]));
    const seconds = world.dt ? `, ${brief(time * world.dt)} s` : "";
    get("time").textContent = `step ${time}${seconds}${changed ? ", changed" : ""}`;
  }

  function drawLegend() {
    const parts = agents[chosen].actions.map((action) => {
      const item = document.createElement("span");
      const swatch = document.createElement("span");
      swatch.className = "swatch";
      swatch.style.background = colours.get(action);
      swatch.textContent = glyph(action);
      item.append(swatch, glyph(action) === action.name ? "" : ` ${action.name}`);
      return item;
    });
    get("legend").replaceChildren(...parts);
  }

  function scrub(to) {
    pause();
    if (film) return wind(to);
    if (to >= states.length) time = states.length - 1;
    while (states.length <= to) extend();
    time = to;
    show();
  }

  /** The features that tests, sums and outputs of a tree read. */
  function places({ feature, sums = [], vectors = [] }) {
    const read = (terms) => terms.flatMap(([, place]) => (Array.isArray(place) ? read(place) : [place]));
    return [...feature, ...[...sums, ...vectors.flat()].flatMap(({ terms }) => read(terms))];
  }

  /** The shortest text that an agent reads as just this number: what a field says is what decides. */
  function exactly(agent, x) {
    for (let digits = 1; digits < 17; digits++) {
      if (Engine.rounded(agent)(Number(x.toPrecision(digits))) === x) return String(Number(x.toPrecision(digits)));
    }
    return String(x);
  }
  function drawSliders() {
    const writers = [];
    retell = () => writers.forEach((write) => write());
    agents.forEach((agent, number) => {
      const box = document.createElement("details");
      box.open = number === 0;
      box.append(Object.assign(document.createElement("summary"), { textContent: `What ${agent.name} observes` }));
      const unasked = document.createElement("details");
      const asked = new Set(TEAMS.flatMap((team) => places(agent[team])));
      agent.features.forEach((feature, f) => {
        const label = document.createElement("label");
        const [low, high] = agent.shown[f];
        const slider = Object.assign(document.createElement("input"), { type: "range", min: low, max: high, step: feature.initial === undefined ? "any" : 1 });
        const field = Object.assign(document.createElement("input"), { type: "number", step: "any" });
        slider.setAttribute("aria-label", `${feature.name}, slider`);
        field.setAttribute("aria-label", feature.name);
        const write = () => {
          slider.value = seen[number][f];
          if (document.activeElement !== field) field.value = exactly(agent, seen[number][f]);
        };
        const read = (from) => {
          if (from.value === "" || !Number.isFinite(Number(from.value))) return;
          pause();
          seen[number][f] = settle(agent, feature, from === slider ? few(Number(from.value)) : Number(from.value));
          write();
          show();
        };
        slider.addEventListener("input", () => read(slider));
        field.addEventListener("input", () => read(field));
        field.addEventListener("blur", write);
        writers.push(write);
        write();
        const unit = feature.unit && feature.unit !== "none" ? ` (${feature.unit})` : "";
        const called = document.createElement("span");
        for (const part of (feature.name + unit).split(/(?<=_)/)) called.append(part, document.createElement("wbr"));
        label.append(called, slider, field);
        (asked.has(f) ? box : unasked).append(label);
      });
      if (unasked.children.length) {
        const textContent = `Features that ${agent.outputs ? "nothing" : "no test"} asks for: ${unasked.children.length}`;
        unasked.prepend(Object.assign(document.createElement("summary"), { textContent }));
        box.append(unasked);
      }
      get("sliders").append(box);
    });
  }

  function option(select, value, text) {
    select.append(Object.assign(document.createElement("option"), { value, textContent: text }));
  }

  /** What a reader can try first. */
  function invitation() {
    if (!placed) return `${film ? "Step through the episode" : remembers ? "Step to what is remembered then" : "Drag the point"}, or move a slider, and see which way the tree takes.`;
    const drag = `Drag ${agents[chosen].name}, or move it with the arrow keys`;
    if (TEAMS.length > 1) return `Each button shows a state in which the two profiles act differently. ${drag}.`;
    if (!judges[claim]) return `${drag}, and see which way its tree takes.`;
    if (!judges[claim](now())) return `Here the claim fails. ${drag}, until it holds.`;
    return `${drag}, and see which way its tree takes. Hatched: there the claim would fail.`;
  }

  function begin() {
    get("live").hidden = false;
    get("still").remove();
    agents.forEach((agent, number) => {
      option(get("agent"), number, agent.name);
      const box = document.createElement("details");
      box.id = `more-${number}`;
      box.open = agents.length <= 6 || number === chosen;
      const summary = document.createElement("summary");
      const name = Object.assign(document.createElement("strong"), { textContent: agent.name });
      const says = Object.assign(document.createElement("span"), { id: `says-${number}`, className: "soft" });
      const same = TEAMS.length > 1 && alike.get(agent.tree).has(0);
      if (same) box.open = false; // there is nothing to see
      summary.append(name, agent.team === agent.name ? " " : ` ${agent.team} `, same ? "(the same tree in both) " : "", says);
      box.append(summary);
      for (const textContent of agent.machine || []) box.append(Object.assign(document.createElement("p"), { textContent, className: "soft" }));
      if (agent.outputs) box.append(Object.assign(document.createElement("div"), { id: `bars-${number}`, className: "bars" }));
      const pair = Object.assign(document.createElement("div"), { className: "pair" });
      (same ? [] : TEAMS).forEach((team, which) => {
        const part = document.createElement("div");
        const textContent = which ? "In the second profile:" : "In the first profile (dashed red: what is changed):";
        if (TEAMS.length > 1) part.append(Object.assign(document.createElement("p"), { className: "soft", textContent }));
        part.append(Object.assign(document.createElement("div"), { id: `${team}-${number}`, className: "tree" }));
        pair.append(part);
      });
      box.append(pair);
      box.addEventListener("toggle", () => show());
      get("trees").append(box);
    });
    data.claims.forEach((one, number) => option(get("claim"), number, one.title));
    data.states.forEach((state) => {
      const button = Object.assign(document.createElement("button"), { textContent: state.label });
      button.addEventListener("click", () => {
        ask(state.claim);
        restart(stateOf(state.position, state.goal));
      });
      get("states").append(button);
    });
    get("verdict").hidden = !data.claims.length || !(placed || worded);
    get("claim").addEventListener("change", (event) => (ask(Number(event.target.value)), show()));
    get("agent").addEventListener("change", (event) => ((chosen = Number(event.target.value)), show()));
    get("compared").hidden = TEAMS.length < 2;
    get("acting").addEventListener("change", (event) => ((acting = Number(event.target.value)), restart(start)));
    get("steer").addEventListener("click", () => ((steering = !steering), show()));
    get("run").addEventListener("click", run);
    get("step").addEventListener("click", () => (pause(), advance()));
    get("back").addEventListener("click", () => ((time = 0), pause(), film ? wind(0) : placed ? show() : forget()));
    get("random").addEventListener("click", () => restart(randomState()));
    get("scrub").addEventListener("input", (event) => scrub(Number(event.target.value)));
    if (data.states[0]) ask(data.states[0].claim);
    addEventListener("resize", () => requestAnimationFrame(show));
    if (placed) {
      watchArena();
      restart(remembered() || (data.states[0] ? stateOf(data.states[0].position, data.states[0].goal) : statedState()));
    } else {
      for (const id of ["arena", "look", "help", "sentence", ...(film ? ["random"] : remembers ? ["run", "random", "scrub"] : ["play"])]) get(id).hidden = true;
      get("about").append(film ? ` ${film.label}` : "");
      document.body.classList.add("unplaced");
      drawSliders();
      slice.begin();
      show();
    }
    get("try").textContent = invitation();
  }

  // for tests, and for readers with a console
  window.maviper = { game, judges, Engine, state: () => now(), restart, advance, scrub };
  begin();
})();
