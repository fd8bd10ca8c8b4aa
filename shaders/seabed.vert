#include "optics.glsl"

in vec3 a_position;
in vec2 a_slope;

uniform mat4 u_view_projection;

out vec3 v_world;
out vec2 v_slope;
out vec3 v_clear;  // haze changes so slowly that the vertices suffice
out vec3 v_veil;

void main() {
    v_world = a_position;
    v_slope = a_slope;
    vec3 ray = v_world - u_eye;
    float distance = length(ray);
    v_clear = clearness(distance);
    v_veil = open_water(ray / distance) * (1.0 - v_clear);
    gl_Position = u_view_projection * vec4(a_position, 1.0);
}
