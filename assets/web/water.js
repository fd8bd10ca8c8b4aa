// The dive's water on three.js: its own shader code (water.glsl) lights what glTF materials colour.
import * as THREE from "three";

const CM = 100;
const LEAF = 0.4; // share of the light on a leaf that shines through
const SHAFTS = [320, 16], SAMPLES = 16; // of the map of light shafts: its size, and looks for each texel

// Stone is rough with what grows on it, as in the dive, from all three sides.
const CRUST = `
  vec3 share = facing * facing;
  share *= share;
  share /= share.x + share.y + share.z;
  vec3 slope;
  vec2 shape = relief_at(v_sea / RELIEF_CM, share, slope);
  facing = normalize(facing - slope + facing * dot(slope, facing));
  diffuseColor.rgb *= clamp(1.0 + 0.6 * shape.x, 0.35, 1.4) * (1.0 + 0.25 * shape.y);`;

// Skin of a fish scatters and mirrors light as in the dive (sunward, fish_light.glsl).
const SKIN = `
  float day = exp(u_down.g * (v_sea.z - u_eye.z));
  float silver = METAL;
  vec3 sight = normalize(u_eye - v_sea);
  float across = max(dot(facing, sight), 0.0), rim = 1.0 - across;
  rim *= rim;
  light = sunlight_at(v_sea.z) * (caustics_at(v_sea) * sunny(v_sea)) * sunward(facing)
    + mix(SANDLIGHT, SKYLIGHT, 0.5 + 0.5 * facing.z) * daylight(v_sea.z) + lamplight_on(v_sea, facing, 0.25);
  light *= 1.0 - DARK * silver;
  mirrored = (0.22 * rim * rim + mirroring(diffuseColor.rgb, silver, sheen_of(across, 0.0))) * day
    * water_radiance(reflect(-sight, platelets(facing, silver)));`;

export class Water {
  // `about` is the scene's "water": uniforms of water.glsl, those of the eye at steps of depth, and
  // the rows of the turn from the page's axes to the dive's. `textures` are its caustics and the relief of stone, `shafts` is
  // the code of their map.
  constructor(about, code, textures, shafts) {
    this.about = about;
    this.code = code;
    this.turn = new THREE.Matrix3().set(...about.axes.flat());
    this.uniforms = {
      u_eye: { value: new THREE.Vector3() },
      u_turn: { value: this.turn },
      u_time: { value: 0 },
      u_caustics: { value: textures.caustics },
      u_relief: { value: textures.relief },
    };
    for (const [name, value] of Object.entries(about.steady)) this.uniforms[name] = this.uniform(value);
    for (const [name, values] of Object.entries(about.by_depth)) this.uniforms[name] = this.uniform(values[0]);
    this.uniforms.u_samples = { value: SAMPLES };
    this.drawMap = this.mapOfShafts(shafts);
  }

  // The function that draws the map of light shafts about the sun, which all shaders of the water read.
  mapOfShafts(code) {
    const options = { type: THREE.HalfFloatType, depthBuffer: false, wrapS: THREE.RepeatWrapping };
    const map = this.map = new THREE.WebGLRenderTarget(...SHAFTS, options);
    const material = new THREE.RawShaderMaterial({
      glslVersion: THREE.GLSL3, uniforms: { ...this.uniforms }, depthTest: false, depthWrite: false,
      vertexShader: `in vec3 position;
        out vec2 v_place;
        void main() {
          v_place = position.xy;
          gl_Position = vec4(2.0 * position.xy - 1.0, 0.0, 1.0);
        }`,
      fragmentShader: `precision highp float;\nprecision highp int;\n${code}`,
    });
    const whole = new THREE.BufferGeometry();
    whole.setAttribute("position", new THREE.Float32BufferAttribute([0, 0, 0, 2, 0, 0, 0, 2, 0], 3));
    const screen = new THREE.Mesh(whole, material);
    screen.frustumCulled = false;
    const camera = new THREE.Camera();
    this.uniforms.u_shafts = { value: map.texture };
    return renderer => {
      renderer.setRenderTarget(map);
      renderer.render(screen, camera);
      renderer.setRenderTarget(null);
    };
  }

  uniform(value) {
    return { value: Array.isArray(value) ? new THREE.Vector3(...value) : value };
  }

  // Set the light for an eye at a place of the page, m, and the time of the dive, s.
  see(eye, seconds, renderer) {
    const u = this.uniforms;
    u.u_eye.value.copy(eye).applyMatrix3(this.turn).multiplyScalar(CM);
    u.u_time.value = seconds % this.about.tide_s;
    const at = Math.max(-u.u_eye.value.z, 0) / this.about.step_cm;
    for (const [name, rows] of Object.entries(this.about.by_depth)) {
      const k = Math.min(Math.floor(at), rows.length - 2), share = Math.min(at - k, 1);
      u[name].value.set(...rows[k].map((low, i) => low + share * (rows[k + 1][i] - low)));
    }
    this.drawMap(renderer);
  }

  // A material of the same colours that this water lights.
  dress(old) {
    const material = new THREE.MeshLambertMaterial({
      name: old.name, color: old.color, map: old.map, vertexColors: old.vertexColors, side: old.side,
      transparent: old.transparent, alphaTest: Math.max(old.alphaTest, 0.05),
    });
    const stone = old.name === "stone";
    const skin = Boolean(old.map), metal = old.metalnessMap;
    const leaf = old.side === THREE.DoubleSide && !old.map ? LEAF : 0;
    material.onBeforeCompile = shader => {
      Object.assign(shader.uniforms, this.uniforms, { u_metal: { value: metal } });
      shader.vertexShader = shader.vertexShader
        .replace("#include <common>", `#include <common>\n${this.code}
          uniform mat3 u_turn;
          attribute float _sway;
          varying vec3 v_sea;
          varying vec3 v_clear;
          varying vec3 v_veil;`)
        .replace("#include <project_vertex>", `
          mat4 placed = modelMatrix;
          #ifdef USE_INSTANCING
            placed *= instanceMatrix;
          #endif
          vec4 sea = placed * vec4(transformed, 1.0);
          v_sea = ${CM.toFixed(1)} * u_turn * sea.xyz;
          // What is soft sways as in the dive.
          vec3 moved = length(placed[0].xyz) * _sway * sway_at(v_sea);
          v_sea += ${CM.toFixed(1)} * moved;
          sea.xyz += moved * u_turn;
          vec4 mvPosition = viewMatrix * sea;
          gl_Position = projectionMatrix * mvPosition;
          // Haze and shafts of light change so slowly that the vertices suffice.
          vec3 ray = v_sea - u_eye;
          float far = length(ray);
          v_clear = clearness(far);
          v_veil = open_water(ray / far) * (1.0 - v_clear);`);
      shader.fragmentShader = shader.fragmentShader
        .replace("#include <common>", `#include <common>\n${this.code}
          uniform mat3 u_turn;
          uniform sampler2D u_metal;
          varying vec3 v_sea;
          varying vec3 v_clear;
          varying vec3 v_veil;`)
        .replace("#include <opaque_fragment>", `
          vec3 facing = normalize(u_turn * inverseTransformDirection(normal, viewMatrix));
          ${stone ? CRUST : ""}
          vec3 light, mirrored = vec3(0.0);
          ${skin ? SKIN.replace("METAL", metal ? "texture2D(u_metal, vMapUv).b" : "0.0")
                 : "light = light_on(v_sea, facing, 0.25);"}
          // What is thin glows with the light that falls on its other side.
          light += max(2.0 * (1.0 - diffuseColor.a), ${leaf.toFixed(1)}) * sunlight_at(v_sea.z) * max(dot(-facing, SUN), 0.2);
          vec3 seen = (EXPOSURE * diffuseColor.rgb * light + mirrored) * v_clear + v_veil;
          gl_FragColor = vec4(curved(seen), diffuseColor.a);`);
    };
    material.customProgramCacheKey = () => `water ${leaf} ${stone} ${skin} ${Boolean(metal)}`;
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
          gl_FragColor = vec4(curved(open_water(normalize(u_turn * v_way))), 1.0);
          #include <colorspace_fragment>
        }`,
    });
    const dome = new THREE.Mesh(new THREE.SphereGeometry(10, 32, 16), material);
    dome.frustumCulled = false;
    dome.renderOrder = -1;
    return dome;
  }
}
