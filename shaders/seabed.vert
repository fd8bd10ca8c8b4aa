#include "optics.glsl"

in vec3 a_position;
in vec2 a_slope;

out vec3 v_world;
out vec2 v_slope;
centroid out float v_broad;  // a slow noise
centroid out vec3 v_clear;   // daylight and haze change so slowly that the vertices suffice
centroid out vec3 v_veil;

void main() {
    v_world = a_position;
    v_slope = a_slope;
    v_broad = textureLod(u_noise, a_position.xy / 870.0, 2.0).r;
    vec3 ray = v_world - u_eye;
    float distance = length(ray);
    v_clear = clearness(distance);
    v_veil = open_water(ray / distance) * (1.0 - v_clear) + glow(ray / distance, distance);
    v_clear *= EXPOSURE * daylight(v_world.z);
    gl_Position = u_view_projection * vec4(a_position, 1.0);
}
