/* Draws what an agent gives as bars and arrows, and a slice through what it observes: two features vary, the others stay. */
const Slice = (page) => {
  "use strict";
  const { agents, get, element, colours, glyph, brief, seen, trace, change } = page;
  const TONES = ["#5b93d6", "#f4f1ea", "#e29a4b"]; // of an output's least, middle and most
  const [LEFT, RIGHT, TOP, BOTTOM] = [14, 118, 2, 92]; // of the plot
  const GRID = 6; // of numbers and arrows, on each axis
  const LONGEST = 7; // arrow
  let sliced = 0;
  let axes = [0, 1];
  let tone = 0;

  const unitOf = ({ unit }) => (unit && unit !== "none" ? ` ${unit}` : "");
  const named = (feature) => feature.name + (unitOf(feature) && ` (${feature.unit})`);
  const clear = (box) => (box.replaceChildren(), box);

  /** The two features that are tested together first, or else alone; those that outputs read come next. */
  function usual(number) {
    const { tree, features } = agents[number];
    const sums = (tree.sums || []).map(({ terms }) => terms);
    const pair = sums.map((terms) => terms.map(([, place]) => place).filter((place) => place >= 0)).find((places) => places.length > 1);
    const given = (tree.vectors || []).flatMap((vector) => vector.flatMap(({ terms }) => terms.map(([, place]) => place)));
    const known = [...(pair || []), ...tree.feature, ...given, ...features.keys()];
    return [...new Set(known.filter((f) => f >= 0 && f < features.length))].slice(0, 2);
  }

  function options(select, names) {
    const made = names.map((textContent, value) => Object.assign(document.createElement("option"), { value, textContent }));
    clear(select).append(...made);
  }

  /** Shows the slice of an agent, with its own features and outputs to choose from, and opens its sliders. */
  function choose(number) {
    sliced = number;
    [...get("sliders").children].forEach((box, place) => (box.open = place === number));
    const { features, outputs } = agents[number];
    axes = usual(number);
    tone = 0;
    for (const id of ["across", "up"]) options(get(id), features.map(named));
    options(get("tone"), (outputs || []).map(named));
    get("toned").hidden = !outputs || outputs.length < 2;
    get("slice").hidden = features.length < 2;
  }

  const shown = (axis) => agents[sliced].shown[axes[axis]];
  const range = (axis) => {
    const [low, high] = shown(axis);
    const at = seen()[sliced][axes[axis]];
    return [Math.min(low, at), Math.max(high, at)];
  };
  const along = (value, [low, high], from, to) => from + ((value - low) / (high - low || 1)) * (to - from);
  const toView = ([x, y]) => [along(x, range(0), LEFT, RIGHT), along(y, range(1), BOTTOM, TOP)];
  const fromView = ([x, y]) => {
    const value = (axis, share) => range(axis)[0] + Math.max(0, Math.min(1, share)) * (range(axis)[1] - range(axis)[0]);
    return [value(0, (x - LEFT) / (RIGHT - LEFT)), value(1, (BOTTOM - y) / (BOTTOM - TOP))];
  };

  /** The fill of a leaf's polygon: its action's colour, or the output's, which is linear between its bounds. */
  function fill(plot, defs, node) {
    const agent = agents[sliced];
    const { tree, outputs } = agent;
    if (!outputs) return colours.get(agent.actions[tree.action[node]]);
    const [low, high] = outputs[tone].span;
    const plane = Engine.affine(tree.vectors[tree.action[node]][tone].terms, seen()[sliced], axes);
    // in view coordinates: value = p u + q v + r
    const [[x0, y0], [x1, y1]] = [fromView([LEFT, BOTTOM]), fromView([RIGHT, TOP])];
    const at = (x, y) => plane[0] * x + plane[1] * y + plane[2];
    const p = (at(x1, y0) - at(x0, y0)) / (RIGHT - LEFT);
    const q = (at(x0, y1) - at(x0, y0)) / (TOP - BOTTOM);
    const steep = p * p + q * q;
    const base = at(x0, y0);
    const point = (value) => [LEFT + ((value - base) * p) / steep, BOTTOM + ((value - base) * q) / steep];
    const flat = !(steep > 0) || low === high;
    const ends = flat ? [[0, 0], [1, 0]] : [point(low), point(high)];
    const id = `tone-${node}`;
    const [[gx, gy], [hx, hy]] = ends;
    const made = element("linearGradient", { id, gradientUnits: "userSpaceOnUse", x1: gx, y1: gy, x2: hx, y2: hy }, defs);
    const share = low === high ? 0.5 : Math.max(0, Math.min(1, (base - low) / (high - low)));
    TONES.forEach((stop, i) => element("stop", { offset: i / 2, "stop-color": flat ? mixed(share) : stop }, made));
    return `url(#${id})`;
  }

  /** The colour at a share of the way from the least to the most. */
  function mixed(share) {
    const [from, to, part] = share < 0.5 ? [TONES[0], TONES[1], 2 * share] : [TONES[1], TONES[2], 2 * share - 1];
    const read = (text) => [1, 3, 5].map((i) => parseInt(text.slice(i, i + 2), 16));
    const parts = read(from).map((value, i) => Math.round(value + part * (read(to)[i] - value)));
    return `rgb(${parts.join(", ")})`;
  }

  /** An arrow of so many units of the view in a picture, whose y goes down. */
  function arrow(box, [x, y], [dx, dy], attributes = {}) {
    const length = Math.hypot(dx, dy);
    if (!(length > 1e-9)) return element("circle", { class: "arrow", cx: x, cy: y, r: 0.3, ...attributes }, box);
    const [ex, ey] = [x + dx, y - dy];
    const head = Math.min(2, 0.4 * length);
    const barb = (turn) => {
      const [c, s] = [Math.cos(turn), Math.sin(turn)];
      return `M${ex},${ey} l${(-head * (dx * c - dy * s)) / length},${(head * (dx * s + dy * c)) / length}`;
    };
    return element("path", { class: "arrow", d: `M${x},${y} L${ex},${ey} ${barb(0.5)} ${barb(-0.5)}`, ...attributes }, box);
  }

  /** How long arrows are beside the largest that there is. */
  function scaled(number, values, longest) {
    const { plane, outputs } = agents[number];
    const most = Math.max(1e-300, ...plane.map((place) => Math.max(...outputs[place].span.map(Math.abs))));
    return plane.map((place) => (values[place] / most) * longest);
  }

  /** What stands at a grid of points, so that nothing depends on colour alone. */
  function drawGrid(plot) {
    const agent = agents[sliced];
    for (let row = 0; row < GRID; row++) {
      for (let column = 0; column < GRID; column++) {
        const view = [LEFT + ((column + 0.5) / GRID) * (RIGHT - LEFT), TOP + ((row + 0.5) / GRID) * (BOTTOM - TOP)];
        const moved = [...seen()[sliced]];
        fromView(view).forEach((value, axis) => (moved[axes[axis]] = Engine.rounded(agent)(value)));
        const leaf = Engine.path(agent.tree, moved).pop();
        const values = agent.outputs && Engine.given(agent, agent.tree, leaf, moved);
        if (values && agent.plane) arrow(plot, view, scaled(sliced, values, LONGEST));
        else {
          const text = values ? brief(values[tone]) : glyph(agent.actions[agent.tree.action[leaf]]);
          element("text", { class: "inside", x: view[0], y: view[1] + 1.2 }, plot).textContent = text;
        }
      }
    }
  }

  function drawAxes(plot) {
    axes.forEach((f, axis) => {
      const [low, high] = range(axis).map(brief);
      const write = (x, y, anchor, text, turned) => {
        const made = element("text", { x, y, "text-anchor": anchor, ...(turned ? { transform: `rotate(-90 ${x} ${y})` } : {}) }, plot);
        made.textContent = text;
      };
      const name = named(agents[sliced].features[f]);
      const cut = name.length > 34 ? `${name.slice(0, 33)}\u2026` : name;
      if (axis === 0) {
        write(LEFT, BOTTOM + 4.5, "start", low);
        write(RIGHT, BOTTOM + 4.5, "end", high);
        write((LEFT + RIGHT) / 2, BOTTOM + 9.5, "middle", cut);
      } else {
        write(LEFT - 1, BOTTOM, "end", low);
        write(LEFT - 1, TOP + 3, "end", high);
        write(4.5, (TOP + BOTTOM) / 2, "middle", cut, true);
      }
    });
  }

  /** Draws the slice; `hovered`: the node that somebody points at. */
  function draw(hovered) {
    const agent = agents[sliced];
    if (agent.features.length < 2) return;
    for (const [id, value] of [["sliced", sliced], ["across", axes[0]], ["up", axes[1]], ["tone", tone]]) get(id).value = value;
    const plot = clear(get("plot"));
    const defs = element("defs", {}, plot);
    const { tree } = agent;
    const live = new Set(Engine.path(tree, seen()[sliced]));
    const pointed = hovered && hovered.tree === tree ? hovered.node : null;
    const { cuts, areas } = Engine.pieces(agent, tree, seen()[sliced], axes, [range(0), range(1)]);
    const corners = (polygon) => polygon.map((point) => toView(point).join(",")).join(" ");
    for (const { node, polygon } of areas) {
      if (tree.feature[node] >= 0) continue;
      element("polygon", { class: "leaf", points: corners(polygon), fill: fill(plot, defs, node) }, plot);
    }
    for (const { node, polygon } of areas) {
      if (node === pointed) element("polygon", { class: "cut pointed", points: corners(polygon), fill: "none" }, plot);
    }
    for (const { node, line: [from, to] } of cuts) {
      const [[x1, y1], [x2, y2]] = [toView(from), toView(to)];
      const kind = `cut${live.has(node) ? " live" : ""}${node === pointed ? " pointed" : ""}`;
      element("line", { class: kind, "data-node": node, x1, y1, x2, y2 }, plot);
    }
    drawGrid(plot);
    const points = trace(sliced).map((row) => toView([row[axes[0]], row[axes[1]]]).join(","));
    if (points.length) element("polyline", { class: "trace", points: points.join(" ") }, plot);
    const [cx, cy] = toView(axes.map((f) => seen()[sliced][f]));
    element("circle", { class: "here", cx, cy, r: 1.8 }, plot);
    drawAxes(plot);
  }

  /** What an agent gives, as a bar for each output between its bounds, and as an arrow. */
  function drawBars(number, values) {
    const agent = agents[number];
    const box = clear(get(`bars-${number}`));
    agent.outputs.forEach((output, place) => {
      const [low, high] = output.span;
      const svg = element("svg", { viewBox: "0 0 100 10", preserveAspectRatio: "none", role: "img" });
      const at = (value) => Math.max(0, Math.min(100, along(value, [low, high], 0, 100)));
      const zero = at(Math.max(low, Math.min(high, 0)));
      element("rect", { class: "ends", x: 0, y: 0, width: 100, height: 10 }, svg);
      const [from, to] = [zero, at(values[place])].sort((a, b) => a - b);
      element("rect", { class: "filled", x: from, y: 1.5, width: to - from, height: 7 }, svg);
      element("line", { class: "zero", x1: zero, x2: zero, y1: 0, y2: 10, "vector-effect": "non-scaling-stroke" }, svg);
      const text = `${brief(values[place])}${unitOf(output)}`;
      svg.setAttribute("aria-label", `${output.name} ${text}, between ${brief(low)} and ${brief(high)}`);
      const cell = (textContent) => Object.assign(document.createElement("span"), { textContent });
      element("title", {}, svg).textContent = svg.getAttribute("aria-label");
      box.append(cell(output.name), svg, cell(text));
    });
    if (!agent.plane) return;
    const svg = element("svg", { class: "force", viewBox: "-12 -12 24 24", role: "img", "aria-label": "The force" });
    element("circle", { class: "ends", cx: 0, cy: 0, r: 11 }, svg);
    arrow(svg, [0, 0], scaled(number, values, 11), { "stroke-width": 1 });
    box.append(svg);
  }

  function begin() {
    const wide = ({ features }) => features.length > 1;
    const testing = agents.findIndex((agent) => wide(agent) && agent.tree.feature.length > 1);
    const first = Math.max(0, testing < 0 ? agents.findIndex(wide) : testing);
    options(get("sliced"), agents.map((agent) => agent.name));
    choose(first);
    get("sliced").value = first;
    get("whose").hidden = agents.length < 2;
    get("sliced").addEventListener("change", (event) => (choose(Number(event.target.value)), draw(null)));
    get("tone").addEventListener("change", (event) => ((tone = Number(event.target.value)), draw(null)));
    ["across", "up"].forEach((id, axis) => {
      get(id).addEventListener("change", (event) => {
        const wanted = Number(event.target.value);
        if (wanted === axes[1 - axis]) axes.reverse();
        else axes[axis] = wanted;
        draw(null);
      });
    });
    const plot = get("plot");
    let dragged = false;
    const move = (event) => {
      const box = plot.getBoundingClientRect();
      const point = [((event.clientX - box.left) / box.width) * 120, ((event.clientY - box.top) / box.height) * 104];
      change(sliced, axes, fromView(point));
    };
    plot.addEventListener("pointerdown", (event) => ((dragged = true), plot.setPointerCapture(event.pointerId), move(event)));
    plot.addEventListener("pointermove", (event) => dragged && move(event));
    for (const end of ["pointerup", "pointercancel"]) plot.addEventListener(end, () => (dragged = false));
  }

  return { begin, draw, drawBars };
};
