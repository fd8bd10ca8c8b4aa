// The dive's water on three.js: its own shader code (water.glsl) lights what glTF materials colour.
import * as THREE from "three";

const CM = 100;
const LEAF = 0.4; // share of the light on a leaf that shines through

export class Water {
  // `about` is the scene's "water": uniforms of water.glsl, those of the eye at steps of depth, and
  // the rows of the turn from the page's axes to the dive's.
  constructor(about, code, caustics) {
    this.about = about;
    this.code = code;
    this.turn = new THREE.Matrix3().set(...about.axes.flat());
    this.uniforms = {
      u_eye: { value: new THREE.Vector3() },
      u_turn: { value: this.turn },
      u_time: { value: 0 },
      u_caustics: { value: caustics },
    };
    for (const [name, value] of Object.entries(about.steady)) this.uniforms[name] = this.uniform(value);
    for (const [name, values] of Object.entries(about.by_depth)) this.uniforms[name] = this.uniform(values[0]);
  }

  uniform(value) {
    return { value: Array.isArray(value) ? new THREE.Vector3(...value) : value };
  }

  // Set the light for an eye at a place of the page, m, and the time of the dive, s.
  see(eye, seconds) {
    const u = this.uniforms;
    u.u_eye.value.copy(eye).applyMatrix3(this.turn).multiplyScalar(CM);
    u.u_time.value = seconds % this.about.tide_s;
    const at = Math.max(-u.u_eye.value.z, 0) / this.about.step_cm;
    for (const [name, rows] of Object.entries(this.about.by_depth)) {
      const k = Math.min(Math.floor(at), rows.length - 2), share = Math.min(at - k, 1);
      u[name].value.set(...rows[k].map((low, i) => low + share * (rows[k + 1][i] - low)));
    }
  }

  // A material of the same colours that this water lights.
  dress(old) {
    const material = new THREE.MeshLambertMaterial({
      name: old.name, color: old.color, map: old.map, vertexColors: old.vertexColors, side: old.side,
      transparent: old.transparent, alphaTest: Math.max(old.alphaTest, 0.05),
    });
    const leaf = old.side === THREE.DoubleSide && !old.map ? LEAF : 0;
    material.onBeforeCompile = shader => {
      Object.assign(shader.uniforms, this.uniforms);
      shader.vertexShader = shader.vertexShader
        .replace("#include <common>", "#include <common>\nuniform mat3 u_turn;\nvarying vec3 v_sea;")
        .replace("#include <project_vertex>", `#include <project_vertex>
          vec4 sea = vec4(transformed, 1.0);
          #ifdef USE_INSTANCING
            sea = instanceMatrix * sea;
          #endif
          v_sea = u_turn * (modelMatrix * sea).xyz * ${CM.toFixed(1)};`);
      shader.fragmentShader = shader.fragmentShader
        .replace("#include <common>", `#include <common>\n${this.code}\nuniform mat3 u_turn;\nvarying vec3 v_sea;`)
        .replace("#include <opaque_fragment>", `
          vec3 facing = normalize(u_turn * inverseTransformDirection(normal, viewMatrix));
          vec3 ray = v_sea - u_eye;
          float far = length(ray);
          vec3 light = light_on(v_sea, facing, 0.25);
          // What is thin glows with the light that falls on its other side.
          light += max(2.0 * (1.0 - diffuseColor.a), ${leaf.toFixed(1)}) * sunlight_at(v_sea.z) * max(dot(-facing, SUN), 0.2);
          vec3 clear = clearness(far);
          vec3 seen = EXPOSURE * diffuseColor.rgb * light * clear + water_radiance(ray / far) * (1.0 - clear);
          gl_FragColor = vec4(curved(seen), diffuseColor.a);`);
    };
    material.customProgramCacheKey = () => `water ${leaf}`;
    return material;
  }

  // A dome about the eye that shows the water beyond everything.
  background() {
    const material = new THREE.ShaderMaterial({
      uniforms: this.uniforms, side: THREE.BackSide, depthTest: false, depthWrite: false,
      vertexShader: `varying vec3 v_way;
        void main() {
          v_way = position;
          gl_Position = projectionMatrix * vec4(mat3(viewMatrix) * position, 1.0);
        }`,
      fragmentShader: `${this.code}
        uniform mat3 u_turn;
        varying vec3 v_way;
        void main() {
          gl_FragColor = vec4(curved(water_radiance(normalize(u_turn * v_way))), 1.0);
          #include <colorspace_fragment>
        }`,
    });
    const dome = new THREE.Mesh(new THREE.SphereGeometry(10, 32, 16), material);
    dome.frustumCulled = false;
    dome.renderOrder = -1;
    return dome;
  }
}
