#include "optics.glsl"

uniform mat4 u_inverse;  // of projection and view

out vec3 v_open;

const ivec2 CELLS = ivec2(64, 36);

// A grid over the whole viewport at the far plane: the water is smooth, its vertices suffice.
void main() {
    int cell = gl_VertexID / 6;
    ivec2 corner = ivec2[6](ivec2(0, 0), ivec2(1, 0), ivec2(0, 1), ivec2(0, 1), ivec2(1, 0), ivec2(1, 1))[gl_VertexID % 6];
    vec2 place = 2.0 * vec2(ivec2(cell % CELLS.x, cell / CELLS.x) + corner) / vec2(CELLS) - 1.0;
    vec4 far = u_inverse * vec4(place, 1.0, 1.0);
    v_open = open_water(normalize(far.xyz / far.w - u_eye));
    gl_Position = vec4(place, 1.0, 1.0);
}
