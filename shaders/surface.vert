#include "optics.glsl"

in vec2 a_place;  // on the unit disc about the eye

uniform mat4 u_view_projection;

out vec3 v_world;

// The water's surface as far as it can be seen.
void main() {
    v_world = vec3(u_eye.xy + REACH * a_place, 0.0);
    gl_Position = u_view_projection * vec4(v_world, 1.0);
}
