// Darkens the sand beneath but not the haze before it: blended, that is what remains.
#ifdef FADING
#include "fades.glsl"
#endif

in vec3 v_veil;
in float v_dark;
out vec4 f_colour;

void main() {
#ifdef FADING
    if (faded(u_fade)) discard;
#endif
    f_colour = vec4(v_veil, v_dark);
}
