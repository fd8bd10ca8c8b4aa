#include "optics.glsl"

uniform mat4 u_inverse;  // of projection and view
uniform ivec2 u_cells;   // across and down

out vec3 v_open;

// A grid over the whole viewport at the far plane: the water is smooth,
// its vertices suffice.
void main() {
    ivec2 corner = ivec2(gl_VertexID % (u_cells.x + 1), gl_VertexID / (u_cells.x + 1));
    vec2 place = 2.0 * vec2(corner) / vec2(u_cells) - 1.0;
    vec4 far = u_inverse * vec4(place, 1.0, 1.0);
    vec3 direction = normalize(far.xyz / far.w - u_eye);
    v_open = open_water(direction) + glow(direction, 1e5);
    gl_Position = vec4(place, 1.0, 1.0);
}
