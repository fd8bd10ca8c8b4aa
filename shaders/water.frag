#ifdef PASSES
#include "show.glsl"
#endif

in vec3 v_open;

#ifdef PASSES
void main() {
    show_parts(vec3(0.0), v_open, vec3(0.0), 0.0, 1.0);
}
#else
out vec4 f_colour;

void main() {
    f_colour = vec4(v_open, 1.0);
}
#endif
