// The computers and projectors of a theatre: their state, restarts and power.
import { RETRY_MS, STATE_MS, changed, complain, get, learnWords, say, send, write } from "/client.js";

const PICTURE_MS = 4000;
let fleet = null, looks = 0;
const cards = {};  // by kind and name

async function command(name, values, question = "") {
  if (question && !await sure(question)) return;
  try {
    const { ok, status, said } = await send("/api/commands", { command: name, ...values });
    if (status === 401) return void (location.href = "/");
    complain(ok ? "" : said.error);
    write("done", ok ? said.done : "");
    get("done").hidden = !ok;
    await look();
  } catch {
    complain(say("No connection to the dive; trying again"));
  }
}
// The answer to a question; Esc is a no. Not the event of closing: it comes late, in another question.
function sure(question) {
  write("question", question);
  get("ask").showModal();
  return new Promise(done => {
    get("yes").onclick = () => done(true);
    get("no").onclick = get("ask").oncancel = () => done(false);
  });
}

const language = document.documentElement.lang;
function when(seconds) {
  const date = new Date(1000 * seconds);
  return date.toDateString() === new Date().toDateString()
    ? date.toLocaleTimeString(language) : date.toLocaleString(language);
}
const number = (value, digits = 1) => value.toLocaleString(language, { maximumFractionDigits: digits });
const unknown = () => say("unknown");

const STATES = {
  on: () => say("running"), off: () => say("standby"), warming: () => say("warming up"),
  cooling: () => say("cooling down"), unknown: () => say("no answer"),
};
const PARTS = {
  fan: () => say("fan"), lamp: () => say("lamp"), temperature: () => say("temperature"),
  cover: () => say("cover"), filter: () => say("filter"), other: () => say("other part"),
};
const SEVERITY = { warning: () => say("warning"), error: () => say("error") };

// One card for each name, made when the names change, and filled with texts.
function follow(kind, names, act) {
  if (!changed(kind, names)) return;
  get(kind + "s").replaceChildren(...names.map(name => {
    const card = get(kind).content.firstElementChild.cloneNode(true);
    for (const one of card.querySelectorAll("[data-act]")) {
      one.setAttribute("aria-label", `${one.textContent} ${name}`);
      one.addEventListener("click", () => act(name, one.dataset.act));
    }
    cards[`${kind} ${name}`] = card;
    return card;
  }));
}
function fill(card, texts) {
  for (const [part, text] of Object.entries(texts)) {
    const place = card.querySelector(`[data-part=${part}]`);
    if (place.textContent !== text) place.textContent = text;
  }
}

function drawComputer(one) {
  const card = cards[`computer ${one.name}`], known = one.version !== null;
  const fault = !one.fault ? say("none")
    : one.fault_at ? say("{time}: {fault}", { time: when(one.fault_at), fault: one.fault }) : one.fault;
  card.classList.toggle("gone", !one.connected);
  card.classList.toggle("faulty", Boolean(one.fault));
  card.querySelector("[data-act=restart]").disabled = !one.connected;
  card.querySelector("[data-act=wake]").hidden = !one.wakes;
  fill(card, {
    name: one.name, fault,
    state: one.own ? say("this computer") : one.connected ? say("connected") : say("gone"),
    dark: one.own || one.pictured ? "" : say("No picture yet."),
    frame: known ? say("{mean} ms, at most {longest} ms",
      { mean: number(one.frame_ms), longest: number(one.longest_ms) }) : unknown(),
    temperature: one.temperature_c === null ? unknown() : `${number(one.temperature_c, 0)} °C`,
    disk: one.free_disk_gb === null ? unknown() : `${number(one.free_disk_gb)} GB`,
    version: known ? say("{version}, protocol {protocol}", one) : unknown(),
    system: one.system || unknown(), renderer: one.renderer || unknown(),
    connected: one.connected ? say("since {time}", { time: when(one.since) })
      : one.seen ? say("last seen {time}", { time: when(one.seen) }) : say("never seen"),
  });
}
function drawProjector(one) {
  const card = cards[`projector ${one.name}`];
  const faults = [...one.errors.map(each => `${PARTS[each.part]()}: ${SEVERITY[each.severity]()}`),
    one.fault].filter(Boolean);
  card.classList.toggle("gone", Boolean(one.fault));
  card.classList.toggle("faulty", faults.length > 0);
  fill(card, {
    name: one.name, state: STATES[one.power](), fault: faults.join(", ") || say("none"),
    lamps: one.lamps.map(lamp => say("{hours} h", { hours: number(lamp.hours) })).join(", ") || unknown(),
    seen: one.seen ? when(one.seen) : say("never"),
  });
}
function draw() {
  get("none").hidden = fleet !== null;
  get("fleet").hidden = fleet === null;
  if (fleet === null) return;
  follow("computer", fleet.nodes.map(one => one.name), (node, act) => act === "wake"
    ? command("wake", { node })
    : command("restart", { node }, say("Restart {name}? Its screens are black until it is back.", { name: node })));
  follow("projector", fleet.projectors.map(one => one.name), (name, act) => act === "on"
    ? command("projector", { name, on: true })
    : command("projector", { name, on: false }, say("Switch projector {name} off?", { name })));
  fleet.nodes.forEach(drawComputer);
  fleet.projectors.forEach(drawProjector);
  get("wake-all").hidden = !fleet.nodes.some(one => one.wakes);
  get("projector-part").hidden = fleet.projectors.length === 0;
}

// A request shows the last picture, and asks for the next one.
async function picture() {
  if (fleet !== null && !document.hidden) {
    looks += 1;
    for (const one of fleet.nodes.filter(each => each.connected)) {
      const image = cards[`computer ${one.name}`].querySelector("img");
      const path = one.own ? "/api/picture.jpg" : `/api/nodes/${one.name}.jpg`;
      if (one.own || one.pictured) {
        image.src = `${path}?${looks}`;
        image.alt = say("Picture of {name}", one);
        image.hidden = false;
      } else {
        await fetch(path, { credentials: "same-origin" }).catch(() => null);
      }
    }
  }
  setTimeout(picture, fleet !== null && fleet.nodes.every(one => one.own || one.pictured || !one.connected)
    ? PICTURE_MS : STATE_MS);
}

async function look() {
  const answer = await fetch("/api/state", { credentials: "same-origin" });
  if (answer.status === 401) return void (location.href = "/");
  if (!answer.ok) throw new Error(answer.status);
  fleet = (await answer.json()).fleet;
  write("status", answer.headers.get("Dive") === "stuck" ? say("The dive draws no pictures") : say("Connected"));
  draw();
}
async function watch() {
  let pause = 2 * STATE_MS;
  try {
    if (!document.hidden) await look();
  } catch {
    write("status", say("No connection to the dive; trying again"));
    pause = RETRY_MS;
  }
  setTimeout(watch, pause);
}

async function begin() {
  await learnWords();
  const on = (id, act) => get(id).addEventListener("click", act);
  on("restart-all", () => command("restart", { node: "all" },
    say("Restart all computers? All screens are black until they are back.")));
  on("wake-all", () => command("wake", { node: "all" }));
  on("on-all", () => command("projector", { name: "all", on: true }));
  on("off-all", () => command("projector", { name: "all", on: false }, say("Switch all projectors off?")));
  watch();
  picture();
}
begin().catch(() => setTimeout(() => location.reload(), RETRY_MS));
