// Line-up on the wall: moves the corners and points of a theatre's projectors.
import { RETRY_MS, STATE_MS, choices, changed, complain, get, learnWords, say, send, write } from "/client.js";

const SVG = "http://www.w3.org/2000/svg";
const NUMBERS = ["edge_soft_px", "gamma", "black", "blend_width"];
const CORNERS = {
  upper_left: () => say("upper left corner"), upper_right: () => say("upper right corner"),
  lower_right: () => say("lower right corner"), lower_left: () => say("lower left corner"),
};
let tool = null, busy = false, waiting = [], moved = [0, 0];

// One command at a time; moves that come meanwhile become one.
function command(name, values = {}) {
  waiting.push({ command: name, ...values });
  work();
}
function move(right, down) {
  moved = [moved[0] + right, moved[1] + down];
  work();
}
async function work() {
  if (busy) return;
  busy = true;
  try {
    while (waiting.length || moved.some(one => one !== 0)) {
      let content = waiting.shift();
      if (!content) {
        content = { command: "line-up-move", right: round(moved[0]), down: round(moved[1]) };
        moved = [0, 0];
      }
      const { ok, status, said } = await send("/api/commands", content);
      if (status === 401) return void (location.href = "/");
      complain(ok ? "" : said.error);
      await look();
    }
  } catch {
    [waiting, moved] = [[], [0, 0]];
    complain(say("No connection to the dive; trying again"));
  } finally {
    busy = false;
  }
}
const round = number => Math.round(1000 * number) / 1000;
const set = (key, value) => command("line-up-set", { key, value });

function nameOf(point) {
  if (CORNERS[point]) return CORNERS[point]();
  if (point.startsWith("edge:")) return say("corner {number} of the edge mask", { number: point.slice(5) });
  const [row, column] = point.split(",");
  return say("point in row {row}, column {column}", { row, column });
}

function draw() {
  get("none").hidden = tool !== null;
  get("closed").hidden = !tool || tool.open;
  get("tool").hidden = !tool || !tool.open;
  if (!tool || !tool.open) return;
  choices("channel", tool.channels.map(one => [one.name,
    `${one.number} ${one.name}${one.node && one.node !== "main" ? ` (${one.node})` : ""}${one.changed ? " *" : ""}`]),
    tool.channel);
  choices("pattern", listed("pattern"), tool.pattern);
  choices("others", listed("others"), tool.others);
  get("compare").setAttribute("aria-pressed", tool.before);
  get("undo").disabled = !tool.undo;
  get("redo").disabled = !tool.redo;
  get("save").disabled = !tool.unsaved;
  write("kept", tool.before ? say("Before: as in the theatre file.")
    : tool.unsaved ? say("Not saved yet.") : say("As in the theatre file."));
  const one = tool.adjustment;
  const grids = [[2, 2], [3, 3], [4, 4], [5, 5], [9, 9], [17, 17]];
  if (!grids.some(grid => grid.join() === tool.grid.join())) grids.push(tool.grid);
  choices("grid", grids.map(grid => [grid.join(), grid.join(" × ")]), tool.grid.join());
  choices("flip", listed("flip"), one.flip || "");
  choices("rotate", listed("rotate"), String(one.rotate));
  get("edge").setAttribute("aria-pressed", one.edge_mask !== null);
  get("edge-more").disabled = !one.edge_mask || one.edge_mask.length >= 32;
  get("edge-less").disabled = !one.edge_mask || one.edge_mask.length <= 3 || !tool.point.startsWith("edge:");
  get("blend_width").disabled = !tool.blends;
  for (const key of NUMBERS) number(key, one[key]);
  one.gain.forEach((share, k) => number(`gain-${k}`, share));
  get("straight").disabled = !one.corners_px;
  get("flat").disabled = !one.points_px;
  write("chosen", `${nameOf(tool.point)}: ${shift(one)}`);
  drawPad();
}
// The options of a list that the page itself has.
const listed = id => [...get(id).options].map(one => [one.value, one.text]);
// A number that somebody types stays; a change of the dive is followed.
function number(id, value) {
  if (changed(`${id}-number`, value) || document.activeElement !== get(id)) get(id).value = round4(value);
}
const round4 = number => Math.round(10000 * number) / 10000;

function shift(one) {
  let pair = [0, 0];
  if (CORNERS[tool.point]) pair = (one.corners_px || {})[tool.point] || pair;
  else if (tool.point.startsWith("edge:")) pair = one.edge_mask[tool.point.slice(5) - 1];
  else if (one.points_px) {
    const [row, column] = tool.point.split(",").map(Number);
    pair = one.points_px[row - 1][column - 1];
  }
  return say("{right} right, {down} down", { right: round(pair[0]), down: round(pair[1]) });
}

// The picture with room around it, for points that were moved out.
const MARGIN = 0.08;
function drawPad() {
  const [width, height] = tool.size, pad = get("pad");
  const drawn = [tool.points, tool.point, tool.grid, tool.size, tool.before];
  if (!changed("pad", drawn)) return;
  const room = MARGIN * Math.max(width, height), unit = Math.max(width, height) / 100;
  pad.setAttribute("viewBox", `${-room} ${-room} ${width + 2 * room} ${height + 2 * room}`);
  const at = Object.fromEntries(tool.points.map(one => [one.name, [one.x * width, one.y * height]]));
  const parts = [shape("rect", { class: "frame", x: 0, y: 0, width, height })];
  const [columns, rows] = tool.grid, row = [...Array(rows).keys()], column = [...Array(columns).keys()];
  const line = names => shape("polyline", { class: "net", points: names.map(name => at[name].join()).join(" ") });
  for (const r of row) parts.push(line(column.map(c => `${r + 1},${c + 1}`)));
  for (const c of column) parts.push(line(row.map(r => `${r + 1},${c + 1}`)));
  const edge = Object.keys(at).filter(name => name.startsWith("edge:"));
  if (edge.length) parts.push(shape("polygon", { class: "edge", points: edge.map(name => at[name].join()).join(" ") }));
  for (const [name, [x, y]] of Object.entries(at)) {
    const kind = CORNERS[name] ? "corner" : name.startsWith("edge:") ? "edge" : "inner";
    const chosen = name === tool.point ? " chosen" : "";
    const size = kind === "corner" ? 3 : 1.6;
    parts.push(shape("circle", { class: `point ${kind}${chosen}`, cx: x, cy: y, r: size * unit }));
  }
  const label = shape("text", { class: "number", x: width / 2, y: height / 2, "font-size": 14 * unit });
  label.textContent = tool.channels.find(one => one.name === tool.channel).number;
  parts.push(label);
  pad.replaceChildren(...parts);
}
function shape(kind, values) {
  const made = document.createElementNS(SVG, kind);
  for (const [key, value] of Object.entries(values)) made.setAttribute(key, value);
  return made;
}

// A tap chooses the nearest point. A drag moves the chosen one: a step for each of the finger's pixels.
function touch() {
  const pad = get("pad");
  let held = null;
  pad.addEventListener("pointerdown", event => {
    pad.setPointerCapture(event.pointerId);
    held = { x: event.clientX, y: event.clientY, far: false };
    pad.focus();
  });
  pad.addEventListener("pointermove", event => {
    if (!held) return;
    const x = event.clientX - held.x, y = event.clientY - held.y;
    if (!held.far && Math.hypot(x, y) < 6) return;
    Object.assign(held, { far: true, x: event.clientX, y: event.clientY });
    const step = Number(get("step").value);
    move(step * x, step * y);
  });
  pad.addEventListener("pointerup", event => {
    if (held && !held.far) choose(event);
    held = null;
  });
  pad.addEventListener("pointercancel", () => { held = null; });
}
function choose(event) {
  const frame = get("pad").getScreenCTM().inverse();
  const place = new DOMPoint(event.clientX, event.clientY).matrixTransform(frame);
  const [width, height] = tool.size;
  const away = one => Math.hypot(one.x * width - place.x, one.y * height - place.y)
    * (CORNERS[one.name] ? 0.7 : 1);  // corners are taken before the points that lie on them
  const nearest = tool.points.reduce((best, one) => away(one) < away(best) ? one : best);
  command("line-up-choose", { point: nearest.name });
}
function key(event) {
  const arrows = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] };
  if (arrows[event.key]) {
    const step = event.shiftKey ? 10 : event.altKey ? 0.1 : 1;
    move(...arrows[event.key].map(one => step * one));
  } else if (event.key === "n") command("line-up-choose", { point: "next" });
  else if (event.key === "p") command("line-up-choose", { point: "previous" });
  else return;
  event.preventDefault();
}

function mask() {
  const [width, height] = tool.size;
  set("edge_mask", tool.adjustment.edge_mask ? null : [[0, 0], [width, 0], [width, height], [0, height]]);
}
// Twice as many corners, as far as there may be.
function more() {
  const edge = tool.adjustment.edge_mask, room = 32 - edge.length;
  const finer = edge.flatMap((one, k) => {
    const after = edge[(k + 1) % edge.length];
    return k < room ? [one, [(one[0] + after[0]) / 2, (one[1] + after[1]) / 2].map(round)] : [one];
  });
  set("edge_mask", finer);
}
function less() {
  const gone = Number(tool.point.slice(5)) - 1;
  set("edge_mask", tool.adjustment.edge_mask.filter((_, k) => k !== gone));
}

async function look() {
  const answer = await fetch("/api/state", { credentials: "same-origin" });
  if (answer.status === 401) return void (location.href = "/");
  if (!answer.ok) throw new Error(answer.status);
  const state = await answer.json();
  tool = state.projectors;
  write("status", answer.headers.get("Dive") === "stuck" ? say("The dive draws no pictures") : say("Connected"));
  draw();
}
async function watch() {
  let pause = STATE_MS;
  try {
    if (!document.hidden && !busy) await look();
  } catch {
    write("status", say("No connection to the dive; trying again"));
    pause = RETRY_MS;
  }
  setTimeout(watch, pause);
}

function listen() {
  const on = (id, event, act) => get(id).addEventListener(event, act);
  on("begin", "click", () => command("line-up-edit", { on: true }));
  on("cancel", "click", () => command("line-up-edit", { on: false }));
  on("channel", "change", () => command("line-up-choose", { channel: get("channel").value }));
  on("previous", "click", () => command("line-up-choose", { channel: "previous" }));
  on("next", "click", () => command("line-up-choose", { channel: "next" }));
  on("undo", "click", () => command("line-up-undo"));
  on("redo", "click", () => command("line-up-redo"));
  on("compare", "click", () => command("line-up-compare", { on: !tool.before }));
  on("save", "click", () => command("line-up-save"));
  on("pattern", "change", () => command("line-up-show", { pattern: get("pattern").value }));
  on("others", "change", () => command("line-up-show", { others: get("others").value }));
  for (const [id, way] of Object.entries({ left: [-1, 0], right: [1, 0], up: [0, -1], down: [0, 1] }))
    on(id, "click", () => move(...way.map(one => one * Number(get("step").value))));
  on("grid", "change", () => set("grid", get("grid").value.split(",").map(Number)));
  on("flip", "change", () => set("flip", get("flip").value || null));
  on("rotate", "change", () => set("rotate", Number(get("rotate").value)));
  on("straight", "click", () => set("corners_px", null));
  on("flat", "click", () => set("points_px", null));
  on("edge", "click", mask);
  on("edge-more", "click", more);
  on("edge-less", "click", less);
  for (const id of NUMBERS) on(id, "change", () => set(id, Number(get(id).value)));
  for (const k of [0, 1, 2])
    on(`gain-${k}`, "change", () => set("gain", [0, 1, 2].map(one => Number(get(`gain-${one}`).value))));
  on("pad", "keydown", key);
  touch();
}

async function begin() {
  await learnWords();
  listen();
  watch();
}
begin().catch(() => setTimeout(() => location.reload(), RETRY_MS));
