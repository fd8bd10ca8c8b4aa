// What stands, on a map of the distance to the sun.
#include "view.glsl"

in vec3 a_position;

void main() {
    gl_Position = u_view_projection * vec4(a_position, 1.0);
}
