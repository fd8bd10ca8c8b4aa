#include "optics.glsl"

in vec3 a_place;  // on the sand, cm
in vec4 a_lie;    // slopes along x and y, axis
in vec3 a_size;   // half length and width, cm; share of the light that is missing

out vec3 v_veil;
#ifdef PASSES
out vec3 v_clear;
#endif
out vec2 v_at;
out float v_dark;

const float LIFT_CM = 4.0;  // toward the eye, off the sand that it lies on

void main() {
    v_at = vec2(gl_VertexID & 1, gl_VertexID >> 1) * 2.0 - 1.0;
    vec2 aside = a_lie.zw * (v_at.x * a_size.x) + vec2(-a_lie.w, a_lie.z) * (v_at.y * a_size.y);
    vec3 place = a_place + vec3(aside, dot(aside, a_lie.xy));
    vec3 ray = place - u_eye;
    float distance = length(ray);
    v_veil = u_unit * open_water(ray / distance) * (1.0 - clearness(distance));
#ifdef PASSES
    v_clear = clearness(distance);
#endif
    v_dark = a_size.z;
    gl_Position = u_view_projection * vec4(place - min(LIFT_CM, 0.3 * distance) * ray / distance, 1.0);
}
