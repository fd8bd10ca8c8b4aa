// A bubble on its way from a vent to the surface (Tu §8.2): where it is follows from the time.
#include "optics.glsl"

// Per slot of a vent: its bubbles follow one another, each long gone when the next leaves.
in vec4 a_vent;  // x, y, z of the vent, largest diameter there, cm
in vec4 a_slot;  // moment of the first bubble, time between two, both s; seed of its dice; of the vent

uniform vec2 u_size;     // pixels of the viewport
uniform vec2 u_current;  // cm/s

out vec2 v_corner;  // in radii, beyond the outline at the corners
out vec3 v_world;  // of the bubble's middle
out vec3 v_veil;
out vec3 v_clear;
out float v_strength;
out float v_small;  // 1: too small for a rim
flat out vec3 v_right;  // its level axis on the picture
flat out vec3 v_up;
flat out vec4 v_shape;  // how far its lower side is flat; ripples of its outline: two waves, three; radius, pixels

const float AIR = 1030.0;  // cm of water that weigh as much as the atmosphere
const float ROOM = 0.25;  // about the outline, for ripples
const float GATHERING = 0.25;  // s, until it is fast

// Terminal speed of a bubble (Mendelson 1967), cm/s; those below a millimetre are slower.
float terminal_speed(float diameter) {
    return min(sqrt(154.0 / diameter + 495.0 * diameter), 280.0 * diameter);
}

float dice(float seed) {
    return fract(sin(seed) * 43758.5453);
}

void main() {
    vec2 corner = vec2(gl_VertexID % 2, gl_VertexID / 2) * 2.0 - 1.0;
    float cycle = floor((u_time - a_slot.x) / a_slot.y);
    float age = u_time - a_slot.x - cycle * a_slot.y;
    float seed = a_slot.z * 91.7 + mod(cycle, 64.0) * 7.31;
    vec4 chance = vec4(dice(seed), dice(seed + 1.3), dice(seed + 2.9), dice(seed + 4.1));
    float diameter = a_vent.w * (0.22 + 0.78 * chance.x * chance.x);
    // Air expands as the weight of water above it gets less; it speeds up and grows.
    float speed = terminal_speed(diameter);
    float way = speed * (age - GATHERING * (1.0 - exp(-age / GATHERING)));
    float z = a_vent.z + way;
    diameter *= pow((AIR - a_vent.z) / (AIR - min(z, 0.0)), 1.0 / 3.0);
    // Wakes shed to one side and the other bend its way; the stream of bubbles widens.
    float unrest = 1.0 - exp(-age / 0.8), turn = 6.2832 * (chance.y + 0.28 * speed / (2.0 + diameter) * age / 3.0);
    float off = 6.2832 * chance.z;
    vec2 aside = 0.9 * diameter * unrest * vec2(cos(turn), sin(turn));
    aside += vec2(cos(off), sin(off)) * (0.25 * a_vent.w + 1.6 * sqrt(way * 0.05) * sqrt(chance.w) * 2.0);
    // The stream meanders as the water about it turns over.
    aside += 0.02 * way * sin(vec2(0.9, 1.1) * (u_time - age) + a_slot.w + vec2(0.011, 0.013) * way);
    vec3 middle = vec3(a_vent.xy + u_current * age + aside, z);

    vec3 ray = middle - u_eye;
    float distance = length(ray);
    float pixels = 0.5 * diameter * u_projection[1][1] * u_size.y * 0.5 / max(distance, 1.0);
    // One smaller than a pixel or two keeps the light that it sends but not its size.
    float drawn = max(pixels, 2.2);
    v_strength = min(pixels * pixels / (drawn * drawn) , 1.0) * smoothstep(8.0, 16.0, distance);
    v_small = 1.0 - smoothstep(2.2, 8.0, pixels);
    float radius = 0.5 * diameter * drawn / max(pixels, 1e-4);
    v_strength *= step(z + 0.3 * diameter, 0.0) * smoothstep(0.0, 0.1, age);
    // Those of a few millimetres are flat and tilt as they sway; large ones are caps. All quiver.
    float oblate = mix(1.0, 0.66, smoothstep(0.25, 0.9, diameter)), cap = smoothstep(1.0, 2.2, diameter);
    float beat = age * (26.0 / (0.7 + diameter)) + off, quiver = smoothstep(0.25, 1.0, diameter);
    oblate += 0.09 * quiver * sin(beat);
    float tilt = 0.35 * quiver * (1.0 - 0.6 * cap) * sin(turn);
    vec3 right = vec3(u_view[0][0], u_view[1][0], u_view[2][0]);
    vec3 up = vec3(u_view[0][1], u_view[1][1], u_view[2][1]);
    // Flat along the vertical of the world, however the head is tilted.
    vec2 high = vec2(right.z, up.z);
    float level = length(high);
    high = level > 1e-3 ? high / level : vec2(0.0, 1.0);
    high = vec2(high.x * cos(tilt) - high.y * sin(tilt), high.x * sin(tilt) + high.y * cos(tilt));
    vec2 wide = vec2(high.y, -high.x);
    float flat_ = mix(1.0, oblate, level);
    v_shape = vec4(0.8 * cap * level, quiver * vec2(0.05 * sin(0.7 * beat + 2.0), 0.05 * sin(1.3 * beat)), pixels);
    corner *= 1.0 + ROOM * quiver * (1.0 - v_small);
    v_corner = corner;
    vec2 off_plane = corner.x * wide / sqrt(flat_) + corner.y * high * flat_ / sqrt(flat_);
    vec3 place = middle + radius * (off_plane.x * right + off_plane.y * up);
    v_right = wide.x * right + wide.y * up;
    v_up = high.x * right + high.y * up;
    v_world = middle;
    v_clear = clearness(distance);
    v_veil = water_radiance(ray / distance) * (1.0 - v_clear);
    v_strength *= smoothstep(0.02, 0.25, v_clear.g);  // far ones fade
    gl_Position = u_view_projection * vec4(place, 1.0);
    if (v_strength <= 0.0) gl_Position = vec4(0.0, 0.0, 2.0, 1.0);
}
