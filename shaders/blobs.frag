// Darkens the sand beneath but not the haze before it: blended, that is what remains.
#ifdef PASSES
#include "show.glsl"

in vec3 v_clear;
#else
out vec4 f_colour;
#endif

in vec3 v_veil;
in vec2 v_at;
in float v_dark;

void main() {
    float inside = max(1.0 - dot(v_at, v_at), 0.0);
    float dark = v_dark * inside * inside;
#ifdef PASSES
    show(vec3(0.0), v_veil, v_clear, dark);
#else
    f_colour = vec4(v_veil, dark);
#endif
}
