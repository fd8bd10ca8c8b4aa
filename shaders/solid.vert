#include "optics.glsl"

in vec3 a_position;
in vec3 a_normal;
in vec4 a_light;  // share of the sky, of the sun, depth of the hollow, cm over the sand
in vec3 a_cover;  // turf, coralline algae, sponge

uniform mat4 u_view_projection;

out vec3 v_world;
out vec3 v_normal;
out vec4 v_light;
out vec3 v_cover;
out vec3 v_clear;  // haze changes so slowly that the vertices suffice
out vec3 v_veil;

void main() {
    v_world = a_position;
    v_normal = a_normal;
    v_light = a_light;
    v_cover = a_cover;
    vec3 ray = v_world - u_eye;
    float distance = length(ray);
    v_clear = clearness(distance);
    v_veil = open_water(ray / distance) * (1.0 - v_clear);
    gl_Position = u_view_projection * vec4(a_position, 1.0);
}
