// Ways to look at the sea by mouse, touch and keyboard: around a place, or flying.
import * as THREE from "three";
import { OrbitControls } from "three/addons/controls/OrbitControls.js";

const SPEED = 1.2, FAST = 4; // m/s; with shift
const TURN = 1.2; // rad/s by keys
const LOOK = 0.0035; // rad for each pixel of a drag
const STEEP = 1.5; // rad; no farther up or down
const ZOOM = 1.5; // a second by keys

export class Flight {
  constructor(camera, canvas) {
    this.camera = camera;
    this.canvas = canvas;
    this.view = "film";
    this.moved = true; // since the last picture
    this.keys = new Set();
    this.fingers = new Map();
    this.orbit = new OrbitControls(camera, canvas);
    this.orbit.enabled = false;
    this.orbit.minDistance = 0.03;
    this.orbit.maxDistance = 40;
    this.orbit.addEventListener("change", () => { this.moved = true; });
    canvas.addEventListener("keydown", event => this.press(event));
    canvas.addEventListener("keyup", event => this.keys.delete(event.code));
    canvas.addEventListener("blur", () => this.keys.clear());
    canvas.addEventListener("pointerdown", event => this.touch(event));
    canvas.addEventListener("pointermove", event => this.drag(event));
    for (const end of ["pointerup", "pointercancel"])
      canvas.addEventListener(end, event => this.fingers.delete(event.pointerId));
    canvas.addEventListener("wheel", event => this.wheel(event), { passive: false });
  }

  // Change to "film", "orbit" or "fly"; `place` is what an orbit turns about.
  choose(view, place) {
    this.view = view;
    this.orbit.enabled = view === "orbit";
    if (view === "orbit") this.about(place);
    if (view === "fly") {
      const level = new THREE.Euler().setFromQuaternion(this.camera.quaternion, "YXZ");
      this.look(level.y, level.x);
    }
    this.moved = true;
  }

  // Move what the orbit turns about, and the eye with it.
  about(place, withEye = false) {
    if (withEye) this.camera.position.add(place).sub(this.orbit.target);
    this.orbit.target.copy(place);
    this.orbit.update();
    this.moved = true;
  }

  press(event) {
    if (event.ctrlKey || event.altKey || event.metaKey || this.view === "film") return;
    const known = /^(Arrow(Left|Right|Up|Down)|Key[WASDQE]|Page(Up|Down)|Equal|Minus|NumpadAdd|NumpadSubtract)$/;
    if (!known.test(event.code)) return;
    this.keys.add(event.code);
    this.fast = event.shiftKey;
    event.preventDefault();
  }

  held(...codes) {
    return codes.some(code => this.keys.has(code)) ? 1 : 0;
  }

  // Move by the pressed keys for `seconds`.
  step(seconds) {
    if (!this.keys.size) return;
    this.moved = true;
    const aside = this.held("ArrowRight") - this.held("ArrowLeft");
    const up = this.held("ArrowUp") - this.held("ArrowDown");
    if (this.view === "orbit") {
      const arm = this.camera.position.clone().sub(this.orbit.target);
      const at = new THREE.Spherical().setFromVector3(arm);
      at.theta += TURN * seconds * (aside + this.held("KeyD") - this.held("KeyA"));
      at.phi = Math.min(Math.max(at.phi - TURN * seconds * up, 0.05), Math.PI - 0.05);
      const near = this.held("Equal", "NumpadAdd", "KeyW", "PageUp");
      const far = this.held("Minus", "NumpadSubtract", "KeyS", "PageDown");
      at.radius *= ZOOM ** (2 * seconds * (far - near));
      this.camera.position.setFromSpherical(at).add(this.orbit.target);
      this.orbit.update();
      return;
    }
    this.look(this.yaw - TURN * seconds * aside, this.pitch + TURN * seconds * up);
    const way = SPEED * (this.fast ? FAST : 1) * seconds;
    this.go(new THREE.Vector3(
      way * (this.held("KeyD") - this.held("KeyA")),
      way * (this.held("KeyE", "PageUp") - this.held("KeyQ", "PageDown")),
      way * (this.held("KeyS", "Minus", "NumpadSubtract") - this.held("KeyW", "Equal", "NumpadAdd")),
    ));
  }

  look(yaw, pitch) {
    this.yaw = yaw;
    this.pitch = Math.min(Math.max(pitch, -STEEP), STEEP);
    this.camera.quaternion.setFromEuler(new THREE.Euler(this.pitch, this.yaw, 0, "YXZ"));
    this.moved = true;
  }

  go(step) {
    this.camera.position.add(step.applyQuaternion(this.camera.quaternion));
    this.moved = true;
  }

  touch(event) {
    this.fingers.set(event.pointerId, [event.clientX, event.clientY]);
    if (this.view === "fly") this.canvas.setPointerCapture(event.pointerId);
  }

  // One finger or the mouse looks around; two fingers go ahead or back.
  drag(event) {
    const before = this.fingers.get(event.pointerId);
    if (!before) return;
    const spread = () => {
      const [a, b] = [...this.fingers.values()];
      return b ? Math.hypot(a[0] - b[0], a[1] - b[1]) : 0;
    };
    const wide = spread();
    this.fingers.set(event.pointerId, [event.clientX, event.clientY]);
    if (this.view !== "fly") return;
    if (this.fingers.size === 1)
      this.look(this.yaw + LOOK * (event.clientX - before[0]), this.pitch + LOOK * (event.clientY - before[1]));
    else this.go(new THREE.Vector3(0, 0, -LOOK * (spread() - wide)));
  }

  wheel(event) {
    if (this.view !== "fly") return;
    event.preventDefault();
    this.go(new THREE.Vector3(0, 0, 0.002 * event.deltaY));
  }
}
