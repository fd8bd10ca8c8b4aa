// What the pages of the console share: their words, requests to the dive, and changes of their text.
// `/words` has the translations of all texts that `say` gets: as literals, so that they can be listed.
"use strict";

export const STATE_MS = 500, RETRY_MS = 2000;
export const get = id => document.getElementById(id);

let words = {};
export async function learnWords() {
  words = await (await fetch("/words")).json();
}
export const say = (text, values = {}) =>
  (words[text] || text).replace(/\{(\w+)\}/g, (_, key) => String(values[key]));

// Only changes are written, so that a screen reader is quiet and the focus stays.
export function write(id, text) {
  if (get(id).textContent !== text) get(id).textContent = text;
}
const shown = {};
export function changed(name, value) {
  const text = JSON.stringify(value);
  if (shown[name] === text) return false;
  shown[name] = text;
  return true;
}
export function complain(text) {
  write("message", text);
  get("message").hidden = !text;
}
export function choices(id, options, chosen) {
  if (changed(id + "-options", options)) {
    const before = get(id).value;
    get(id).replaceChildren(...options.map(([value, text]) => new Option(text, value)));
    if (options.some(([value]) => value === before)) get(id).value = before;
  }
  // What somebody is choosing stays; a change of the dive is followed.
  if (chosen !== undefined && changed(id + "-chosen", chosen) && chosen !== null) get(id).value = chosen;
}

export async function send(path, content) {
  const answer = await fetch(path, {
    method: "POST", headers: { "Content-Type": "application/json" },
    body: JSON.stringify(content), credentials: "same-origin",
  });
  return { ok: answer.ok, status: answer.status, said: await answer.json() };
}
