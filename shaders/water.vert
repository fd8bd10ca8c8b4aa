#include "optics.glsl"

uniform mat4 u_inverse;  // of projection and view

out vec3 v_open;

// A grid of ACROSS_CELLS by DOWN_CELLS over the whole viewport at the far plane: the water is smooth,
// its vertices suffice.
void main() {
    ivec2 corner = ivec2(gl_VertexID % (ACROSS_CELLS + 1), gl_VertexID / (ACROSS_CELLS + 1));
    vec2 place = 2.0 * vec2(corner) / vec2(ACROSS_CELLS, DOWN_CELLS) - 1.0;
    vec4 far = u_inverse * vec4(place, 1.0, 1.0);
    v_open = open_water(normalize(far.xyz / far.w - u_eye));
    gl_Position = vec4(place, 1.0, 1.0);
}
