// The page of an exported scene: loads it, plays it, and tells which fish is which.
import * as THREE from "three";
import { GLTFLoader } from "three/addons/loaders/GLTFLoader.js";
import { Flight } from "./flight.js";
import { Fishes } from "./fishes.js";
import { Water } from "./water.js";

const FAR_M = 200, NEAR_M = 0.02;
const STEP_S = 0.1; // of the time slider by keys
const HOVER_MS = 100; // between looks at what is under the pointer
const CLICK_PX = 6; // a longer way is a drag
const SEAM_S = 0.5; // a scene that is no loop fades out before its end, and in after its begin

const part = id => document.getElementById(id);
let words = {};

// The words of the page in the first language of the browser that has some.
function speak(about) {
  const all = about.words;
  const asked = (navigator.languages || []).map(tag => tag.split("-")[0]).find(code => all[code]);
  words = all[asked] || all.en;
  document.documentElement.lang = asked || "en";
  for (const one of document.querySelectorAll("[data-word]")) one.textContent = words[one.dataset.word];
  part("sea").setAttribute("aria-label", words.sea);
  part("time").setAttribute("aria-label", words.time);
  part("progress").setAttribute("aria-label", words.loaded);
  part("message").textContent = words.loading;
  for (const one of [about, ...about.species]) one.title = words.names[one.title];
  document.title = part("title").textContent = about.title;
}

function say(text) {
  part("message").textContent = text;
  part("message").className = "alarm";
  part("message").setAttribute("role", "alert");
  part("progress").hidden = true;
  part("loading").hidden = false;
}

async function fetched(path) {
  const answer = await fetch(path, { cache: "no-cache" }); // parts of one export only
  if (!answer.ok) throw new Error(`${path}: ${answer.status}`);
  return answer;
}

// A file whose size is known, with the progress bar.
async function loaded(path, bytes) {
  const reader = (await fetched(path)).body.getReader();
  const whole = new Uint8Array(bytes);
  let got = 0;
  for (;;) {
    const { done, value } = await reader.read();
    if (done) break;
    whole.set(value, got); // a longer file than the page belongs to is an error
    got += value.length;
    part("progress").value = got / bytes;
  }
  if (got < bytes) throw new Error(`${path}: ${got} / ${bytes}`);
  return whole.buffer;
}

// A square texture that repeats, of a file that holds nothing but its texels.
async function repeating(path, Numbers, format, type) {
  const data = new Numbers(await (await fetched(path)).arrayBuffer());
  const size = Math.round(Math.sqrt(data.length / (format === THREE.RGFormat ? 2 : 4)));
  const texture = new THREE.DataTexture(data, size, size, format, type);
  texture.wrapS = texture.wrapT = THREE.RepeatWrapping;
  texture.magFilter = THREE.LinearFilter;
  texture.minFilter = THREE.LinearMipmapLinearFilter;
  texture.generateMipmaps = texture.needsUpdate = true;
  return texture;
}

const megabytes = bytes => (bytes / 1e6).toLocaleString(undefined, { maximumFractionDigits: 1 });

class Viewer {
  constructor(about, renderer, water, gltf) {
    this.about = about;
    this.renderer = renderer;
    this.water = water;
    this.seconds = this.before = 0; // of the scene now, and of the rounds that it has made before
    this.length = Math.max((about.frames - 1) / about.fps, 0);
    this.playing = false;
    this.scene = new THREE.Scene();
    this.camera = new THREE.PerspectiveCamera(50, 1, NEAR_M, FAR_M);
    this.scene.add(water.background(), gltf.scene);
    this.filmed = gltf.cameras[0];
    const dressed = new Map();
    gltf.scene.traverse(one => {
      if (!one.isMesh) return;
      if (!dressed.has(one.material)) dressed.set(one.material, water.dress(one.material));
      one.material = dressed.get(one.material);
    });
    this.mixer = new THREE.AnimationMixer(gltf.scene);
    for (const clip of gltf.animations) this.mixer.clipAction(clip).play();
    this.fishes = new Fishes(gltf.scene, about);
    this.flight = new Flight(this.camera, renderer.domElement);
    this.chosen = this.over = null;
    this.listen();
    this.list();
    this.resize();
    this.seek(0);
    this.back(); // other views begin where the film does
  }

  listen() {
    const canvas = this.renderer.domElement;
    addEventListener("resize", () => this.resize());
    part("play").addEventListener("click", () => this.play(!this.playing));
    part("time").max = this.length;
    part("time").addEventListener("input", event => this.seek(Number(event.target.value)));
    part("time").addEventListener("keydown", event => {
      const way = { ArrowLeft: -1, ArrowDown: -1, ArrowRight: 1, ArrowUp: 1 }[event.key];
      if (!way) return;
      event.preventDefault();
      this.seek(this.seconds + way * STEP_S);
    });
    for (const one of document.querySelectorAll("input[name=view]"))
      one.addEventListener("change", () => this.look(one.value));
    addEventListener("keydown", event => {
      if (event.key === "Escape") this.choose(null);
      const busy = event.target.closest("button, input, summary, a");
      if (event.code === "Space" && !busy) {
        event.preventDefault();
        this.play(!this.playing);
      }
    });
    let from = [0, 0];
    canvas.addEventListener("pointerdown", event => { from = [event.clientX, event.clientY]; });
    canvas.addEventListener("pointerup", event => {
      if (Math.hypot(event.clientX - from[0], event.clientY - from[1]) > CLICK_PX) return;
      this.choose(this.at(event));
    });
    canvas.addEventListener("pointermove", event => {
      if (event.pointerType === "mouse" && !event.buttons) this.pointer = event;
    });
    canvas.addEventListener("pointerleave", () => { this.pointer = null; this.hover(null); });
    canvas.addEventListener("webglcontextlost", event => {
      event.preventDefault();
      say(words.lost);
    });
  }

  // The list of all fishes by species, for keyboards and screen readers.
  list() {
    part("count").textContent = `(${this.fishes.all.length})`;
    this.buttons = new Map();
    this.about.species.forEach((species, k) => {
      const own = this.fishes.all.filter(fish => fish.about.species === k);
      const box = document.createElement("details");
      const title = document.createElement("summary");
      const latin = document.createElement("i");
      latin.lang = "la";
      latin.textContent = species.scientific;
      title.append(`${species.title} (${own.length}) `, latin);
      const list = document.createElement("ul");
      for (const fish of own) {
        const button = document.createElement("button");
        button.type = "button";
        button.textContent = fish.title;
        button.setAttribute("aria-pressed", "false");
        button.addEventListener("click", () => this.choose(fish));
        this.buttons.set(fish, button);
        const item = document.createElement("li");
        item.append(button);
        list.append(item);
      }
      box.append(title, list);
      part("species").append(box);
    });
  }

  resize() {
    const width = innerWidth, height = innerHeight;
    this.renderer.setPixelRatio(Math.min(devicePixelRatio, 2));
    this.renderer.setSize(width, height, false);
    this.camera.aspect = width / height;
    // A window narrower than the film loses some of its sides, and shows more above and below.
    const narrow = Math.max(this.filmed.aspect / this.camera.aspect, 1);
    const half = Math.tan(THREE.MathUtils.degToRad(this.filmed.fov / 2)) * Math.sqrt(narrow);
    this.camera.fov = THREE.MathUtils.radToDeg(2 * Math.atan(half));
    this.camera.updateProjectionMatrix();
    this.dirty = true;
  }

  play(on) {
    if (on && this.seconds >= this.length) this.seek(0);
    this.playing = on;
    part("play").textContent = on ? words.pause : words.play;
    part("play").setAttribute("aria-pressed", String(on));
    this.dirty = true; // a picture that stands is whole
  }

  // Show a moment, in seconds since the scene begins.
  seek(seconds) {
    this.seconds = Math.min(Math.max(seconds, 0), this.length);
    // At its very end a clip would begin again.
    this.mixer.setTime(Math.min(this.seconds, Math.max(this.length - 1e-5, 0)));
    part("time").value = this.seconds;
    part("time").setAttribute("aria-valuetext", `${this.seconds.toFixed(1)} s`);
    part("clock").textContent = `${this.seconds.toFixed(1)} / ${this.length.toFixed(1)} s`;
    const frame = Math.floor(this.seconds * this.about.fps + 1e-6);
    this.fishes.show(frame);
    const line = this.about.captions.find(one => one.first <= frame && frame <= one.last);
    const text = line ? line.text : "";
    if (part("caption").textContent !== text) part("caption").textContent = text;
    if (this.flight.view === "orbit" && this.chosen) this.flight.about(this.fishes.place(this.chosen), true);
    this.dirty = true;
  }

  // Choose the view "film", "orbit" or "fly".
  look(view) {
    document.querySelector(`input[name=view][value=${view}]`).checked = true;
    this.flight.choose(view, this.middle());
    this.dirty = true;
  }

  // Where an orbit turns: the chosen fish, or a place ahead of the eye.
  middle() {
    if (this.chosen) return this.fishes.place(this.chosen);
    return new THREE.Vector3(0, 0, -2).applyQuaternion(this.camera.quaternion).add(this.camera.position);
  }

  // The camera of the film.
  back() {
    this.scene.updateMatrixWorld();
    this.filmed.matrixWorld.decompose(this.camera.position, this.camera.quaternion, new THREE.Vector3());
  }

  at(event) {
    const box = this.renderer.domElement.getBoundingClientRect();
    const x = (event.clientX - box.left) / box.width * 2 - 1;
    const y = 1 - (event.clientY - box.top) / box.height * 2;
    return this.fishes.at(x, y, this.camera, event.pointerType === "touch");
  }

  hover(fish) {
    this.over = fish;
    part("sea").classList.toggle("over", fish !== null);
    this.dirty = true;
  }

  choose(fish) {
    if (this.chosen) this.buttons.get(this.chosen).setAttribute("aria-pressed", "false");
    this.chosen = fish;
    this.dirty = true;
    if (!fish) {
      part("chosen").textContent = "";
      return;
    }
    const button = this.buttons.get(fish), species = this.about.species[fish.about.species];
    button.setAttribute("aria-pressed", "true");
    part("chosen").textContent = `${fish.title} · ${species.scientific} · ${fish.about.length_cm} cm`;
    if (this.flight.view === "orbit") this.flight.about(this.fishes.place(fish));
  }

  // The name beside the fish.
  label() {
    const fish = this.over || this.chosen, box = part("name");
    const place = fish && this.fishes.place(fish).project(this.camera);
    box.hidden = !place || Math.abs(place.z) > 1;
    if (box.hidden) return;
    box.textContent = fish.title;
    const width = box.offsetWidth, y = (1 - place.y) / 2 * innerHeight;
    const x = Math.max(Math.min((place.x + 1) / 2 * innerWidth - width / 2, innerWidth - width), 0);
    box.style.transform = `translate(${x.toFixed(1)}px, ${(y - 34).toFixed(1)}px)`;
  }

  draw() {
    if (this.flight.view === "film") this.back();
    this.camera.updateMatrixWorld();
    this.water.see(this.camera.position, this.about.start_s + this.before + this.seconds, this.renderer);
    part("sea").style.opacity = this.shown();
    this.fishes.cull(this.camera);
    this.renderer.render(this.scene, this.camera);
    this.label();
    this.dirty = this.flight.moved = false;
  }

  // The opacity of the picture: the seam of a scene that is no loop is hidden in the page's colour.
  shown() {
    if (this.about.loop || !this.playing || this.length < 4 * SEAM_S) return 1;
    return Math.min(this.seconds / SEAM_S, (this.length - this.seconds) / SEAM_S, 1).toFixed(3);
  }

  // Go on by some seconds. The water has no end, so its light and what sways in it never jump.
  go(passed) {
    let seconds = this.seconds + passed;
    if (seconds >= this.length) {
      this.before += this.length;
      seconds = this.about.loop ? seconds % this.length : 0;
    }
    this.seek(seconds);
  }

  frame(now) {
    const passed = Math.min((now - (this.shownAt ?? now)) / 1000, 0.2);
    this.shownAt = now;
    if (this.playing) this.go(passed);
    this.flight.step(passed);
    if (this.pointer && !(now - this.looked < HOVER_MS)) {
      this.looked = now;
      const fish = this.at(this.pointer);
      if (fish !== this.over) this.hover(fish);
      if (!this.playing) this.pointer = null;
    }
    if (this.dirty || this.flight.moved) this.draw();
  }
}

async function main() {
  // In a frame of another page: the sea alone.
  document.body.classList.toggle("bare", new URLSearchParams(location.search).has("embed"));
  const about = await (await fetched("scene.json")).json();
  speak(about);
  part("file").textContent = words.download.replace("{size}", megabytes(about.bytes));
  let renderer;
  try {
    renderer = new THREE.WebGLRenderer({ canvas: part("sea"), antialias: true });
  } catch {
    say(words.webgl);
    return;
  }
  const text = path => fetched(path).then(answer => answer.text());
  const [code, shafts, caustics, relief, data] = await Promise.all([
    text("water.glsl"), text("shafts.glsl"),
    repeating("caustics.bin", Uint16Array, THREE.RGFormat, THREE.HalfFloatType),
    repeating("relief.bin", Uint8Array, THREE.RGBAFormat, THREE.UnsignedByteType),
    loaded(about.file, about.bytes),
  ]);
  const gltf = await new GLTFLoader().parseAsync(data, "");
  const viewer = new Viewer(about, renderer, new Water(about.water, code, { caustics, relief }, shafts), gltf);
  viewer.draw();
  part("loading").hidden = true;
  viewer.play(viewer.length > 0 && !matchMedia("(prefers-reduced-motion: reduce)").matches);
  renderer.setAnimationLoop(now => viewer.frame(now));
  window.viewer = viewer; // for the console, and for tests
}

main().catch(error => {
  console.error(error);
  say(`${words.failed || "The scene could not be loaded."} (${error.message})`);
});
