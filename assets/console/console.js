// The presenter's console: shows the state of the dive and sends commands.
import { RETRY_MS, STATE_MS, changed, choices, complain, get, learnWords, say, send as post, write } from "/client.js";

const PICTURE_MS = 350;
let state = null, inside = false, touched = 0, edited = null;

const readable = name => name.replaceAll("_", " ");
function span(seconds) {
  if (seconds < 90) return say("{n} s", { n: Math.round(seconds) });
  if (seconds < 5400) return say("{n} min", { n: Math.round(seconds / 60) });
  return say("{n} h", { n: (seconds / 3600).toFixed(1) });
}

async function send(path, content) {
  const answer = await post(path, content);
  if (answer.status === 401 && path !== "/login") show(false);
  return answer;
}
async function command(name, values = {}) {
  try {
    const { ok, said } = await send("/api/commands", { command: name, ...values });
    complain(ok ? "" : said.error);
    if (ok) touched = Date.now();
    await look();
    return ok;
  } catch {
    complain(say("No connection to the dive; trying again"));
    return false;
  }
}

function show(entered) {
  if (entered === inside && !(get("login").hidden && get("console").hidden)) return;
  inside = entered;
  get("console").hidden = !entered;
  get("login").hidden = entered;
  if (!entered) {
    write("status", "");
    get("token").focus();
  }
}

function draw() {
  const tours = { auto: say("Autopilot"), directed: say("Directions") };
  const fish = state.fish && `${readable(state.fish.species)} ${state.fish.number}`;
  write("scene", state.title);
  write("now", [
    state.blank && say("The screens are blank."),
    state.line_up && say("The line-up pattern is shown."),
    state.tour ? say("On tour: {name}.", { name: tours[state.tour] || state.tour }) : say("No tour."),
    !fish ? say("On the submarine.")
      : state.fish.behind ? say("Following a fish: {fish}", { fish })
      : say("Riding a fish: {fish}", { fish }),
    state.caption ? say("Caption: {text}", { text: state.caption }) : say("No caption."),
  ].filter(Boolean).join(" "));
  get("blank").setAttribute("aria-pressed", state.blank);
  get("line-up").setAttribute("aria-pressed", state.line_up);
  choices("scenario", state.scenarios.map(one => [one.name, one.title || one.name]), state.scenario);
  choices("tour", state.tours.map(name => [name, tours[name] || name]), state.tour);
  choices("fish", [["nearest", get("fish").dataset.nearest],
    ...state.species.filter(one => one.living).map(one => [one.name, `${readable(one.name)} (${one.living})`])]);
  choices("quality", ["auto", "low", "medium", "high", "ultra"].map(name => [name, name]), state.quality);
  const volume = Math.round(100 * state.volume);
  if (document.activeElement !== get("volume") || Date.now() - touched > 1500) get("volume").value = volume;
  write("volume-now", `${volume} %`);
  get("volume").setAttribute("aria-valuetext", `${volume} %`);
  get("stop-tour").disabled = !state.tour;
  get("helm").disabled = !state.fish;
  get("next-cue").disabled = state.next_cue === null;
  drawShow();
  drawCues();
  drawHealth();
  get("projectors").hidden = !state.projectors;
  get("fleet").hidden = !state.fleet;
  get("feed").disabled = state.several_computers;
  for (const id of ["scenario-form", "fish-form"])
    for (const one of get(id).querySelectorAll("button[type=submit], #ride, select"))
      one.disabled = state.several_computers;
}

function drawShow() {
  const one = state.show;
  get("show-card").hidden = !one;
  if (!one) return;
  get("next-item").disabled = !one.open;
  write("show-now", one.open
    ? say("{title}: item {item} of {items} for {time}.",
      { item: one.item, items: one.items, title: one.title, time: span(one.elapsed_s) })
    : say("{title}: closed now.", { title: one.title }));
  write("show-hours", one.hours || "");
  drawItems(one);
  drawDays(one.special_days || []);
}

function button(text, label, act) {
  const made = document.createElement("button");
  made.type = "button";
  made.textContent = text;
  made.setAttribute("aria-label", label);
  made.addEventListener("click", act);
  return made;
}
function row(words, off, ...parts) {
  const made = document.createElement("li"), text = document.createElement("span");
  text.className = off ? "words off" : "words";
  text.textContent = words;
  made.append(text, ...parts);
  return made;
}

function drawItems(one) {
  const items = one.programme || [];
  if (changed("items", items)) get("items").replaceChildren(...items.map((item, k) => {
    const number = k + 1, about = [
      item.start === "after" ? "" : item.start, item.scenario || say("the same sea"), item.tour || "",
      item.for_s ? span(item.for_s) : "", item.caption, item.on ? "" : say("not today")];
    return row(`${number}. ${about.filter(Boolean).join(", ")}`, !item.on,
      button(get("items").dataset.go, say("Go to item {number}", { number }), () => command("item", { number })),
      button(get("items").dataset.edit, say("Edit item {number}", { number }), () => edit(number, item)));
  }));
  [...get("items").children].forEach((each, k) => {
    if (k + 1 === one.item && one.open) each.setAttribute("aria-current", "true");
    else each.removeAttribute("aria-current");
    each.querySelector("button").disabled = !one.open;
  });
}
function edit(number, item) {
  edited = { number, item };
  write("item-title", say("Edit item {number}", { number }));
  get("item-start").value = item.start;
  get("item-length").value = item.for_s === null ? "" : item.for_s;
  get("item-caption").value = item.caption;
  get("item-caption").disabled = item.languages !== 1;
  get("item-form").hidden = false;
  get("item-start").focus();
}
async function save() {
  const { number, item } = edited, length = item.for_s === null ? "" : String(item.for_s);
  const values = { start: [item.start, "item-start"], for_s: [length, "item-length"],
    caption: [item.caption, "item-caption"] };
  for (const [key, [before, id]] of Object.entries(values)) {
    const value = get(id).value.trim();
    if (value !== before && !await command("edit-item", { number, key, value })) return;
  }
  get("item-form").hidden = true;
}

function drawDays(days) {
  if (!changed("days", days)) return;
  get("days").replaceChildren(...days.map((day, k) => {
    const name = day.title || day.when, hours = day.hours || say("usual hours");
    const words = [day.title, day.when, hours, day.now ? say("today") : ""].filter(Boolean).join(", ");
    return row(words, false, button(get("days").dataset.remove, say("Remove {name}", { name }),
      () => command("remove-special-day", { number: k + 1 })));
  }));
}

function drawCues() {
  get("no-cues").hidden = state.cues.length > 0;
  write("no-cues", say("This scenario has no directions."));
  if (!changed("cues", state.cues.map(one => [one.number, one.name, one.caption]))) {
    state.cues.forEach((one, k) => {
      const mark = get("cues").children[k].querySelector(".begun");
      const text = one.begun ? say("begun") : "";
      if (mark.textContent !== text) mark.textContent = text;
    });
    return;
  }
  get("cues").replaceChildren(...state.cues.map(one => {
    const name = one.name || say("Cue {number}", { number: one.number });
    const row = document.createElement("li"), text = document.createElement("span");
    const begun = document.createElement("span"), start = document.createElement("button");
    text.className = "words";
    text.textContent = one.caption ? `${name}: ${one.caption}` : name;
    begun.className = "begun";
    begun.textContent = one.begun ? say("begun") : "";
    start.type = "button";
    start.textContent = get("cues").dataset.start;
    start.setAttribute("aria-label", say("Start {name}", { name }));
    start.addEventListener("click", () => command("cue", { number: one.number }));
    row.append(text, begun, start);
    return row;
  }));
}

function drawHealth() {
  write("rate", say("{rate} pictures a second", { rate: state.pictures_a_s }));
  write("fault", state.fault
    ? say("Last fault {time} ago: {text}", { time: span(state.fault.ago_s), text: state.fault.text })
    : say("No fault since the start, {time} ago.", { time: span(state.up_s) }));
  write("refusal", state.refusal
    ? say("Last refusal {time} ago: {text}", { time: span(state.refusal.ago_s), text: state.refusal.text })
    : "");
  get("no-nodes").hidden = state.nodes.length > 0;
  document.querySelector(".scroll").hidden = state.nodes.length === 0;
  if (!changed("nodes", state.nodes)) return;
  get("nodes").replaceChildren(...state.nodes.map(one => {
    const row = document.createElement("tr"), name = document.createElement("th");
    name.scope = "row";
    name.textContent = one.name;
    const how = one.in_step ? say("in step")
      : one.connected ? say("catching up") : say("not connected");
    row.append(name, ...[how, one.last_ms.toFixed(1), one.mean_ms.toFixed(1),
      one.longest_ms.toFixed(1), one.late].map(value => {
      const cell = document.createElement("td");
      cell.textContent = value;
      return cell;
    }));
    return row;
  }));
}

async function look() {
  const answer = await fetch("/api/state", { credentials: "same-origin" });
  if (answer.status === 401) return show(false);
  if (answer.status === 429) return write("status", say("Too many requests; trying again"));
  if (!answer.ok) throw new Error(answer.status);
  state = await answer.json();
  show(true);
  get("logout").hidden = document.body.dataset.token !== "yes";
  const stuck = answer.headers.get("Dive") === "stuck";
  write("status", state.loading ? say("The dive is opening a scenario")
    : stuck ? say("The dive draws no pictures") : say("Connected"));
  draw();
}
async function watch() {
  let pause = STATE_MS;
  try {
    if (!document.hidden) await look();
  } catch {
    write("status", say("No connection to the dive; trying again"));
    pause = RETRY_MS;
  }
  setTimeout(watch, pause);
}

// One picture at a time, and none while nobody looks.
function picture() {
  const wanted = inside && !document.hidden && get("show-picture").checked;
  const again = delay => setTimeout(picture, delay);
  if (!wanted) return again(PICTURE_MS);
  const next = new Image();
  next.onload = () => { get("picture").src = next.src; again(PICTURE_MS); };
  next.onerror = () => again(RETRY_MS);
  next.src = `/api/picture.jpg?n=${Date.now()}`;
}

function listen() {
  const on = (id, event, act) => get(id).addEventListener(event, happened => {
    happened.preventDefault();
    act();
  });
  on("blank", "click", () => command("blank", { on: !state.blank }));
  on("line-up", "click", () => command("line-up", { on: !state.line_up }));
  on("tour-form", "submit", () => command("tour", { name: get("tour").value }));
  on("stop-tour", "click", () => command("stop-tour"));
  on("next-cue", "click", () => command("cue"));
  on("next-item", "click", () => command("next-item"));
  on("item-form", "submit", save);
  on("item-cancel", "click", () => { get("item-form").hidden = true; });
  on("day-form", "submit", async () => {
    const [date, title, hours] = ["day-date", "day-title", "day-hours"].map(id => get(id).value.trim());
    if (await command("special-day", { date, title, hours })) get("day-form").reset();
  });
  on("caption-form", "submit", () => command("caption", { text: get("caption").value }));
  on("clear-caption", "click", () => command("caption", { text: "" }));
  on("fish-form", "submit", () => command("follow", { fish: get("fish").value }));
  on("ride", "click", () => command("ride", { fish: get("fish").value }));
  on("helm", "click", () => command("helm"));
  on("feed", "click", () => command("feed"));
  on("scenario-form", "submit", () => command("scenario", { name: get("scenario").value }));
  on("quality", "change", () => command("quality", { quality: get("quality").value }));
  on("volume", "change", () => command("volume", { volume: get("volume").value / 100 }));
  on("login-form", "submit", () => login(get("token").value));
  on("logout", "click", async () => {
    await send("/logout", {});
    show(false);
  });
}
async function login(token) {
  const { ok } = await send("/login", { token: token.trim() });
  complain(ok ? "" : say("This is not the token."));
  get("token").value = "";
  if (ok) {
    await look();
    get("controls").focus();
  }
}

async function begin() {
  await learnWords();
  listen();
  const given = location.hash.slice(1);
  if (given.length >= 32) {  // https://ADDRESS:PORT/#TOKEN
    history.replaceState(null, "", "/");
    await login(decodeURIComponent(given));
  }
  watch();
  picture();
}
begin().catch(() => setTimeout(() => location.reload(), RETRY_MS));
