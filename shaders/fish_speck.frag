// As `fishes.frag` shades, without what is too small to see.
#ifdef CAST
void main() {}
#else
#include "fades.glsl"
#include "speck_light.glsl"
#define BRIGHTEST 32.0
#include "show.glsl"

#ifdef DOT
centroid in vec4 v_light;
#else
centroid in vec3 v_sky;
centroid in float v_facing;
flat in vec3 v_sun;
centroid in vec3 v_around;
flat in float v_silver;
in vec2 v_skin;
flat in vec4 v_tone;
#endif
centroid in vec3 v_veil;
#ifdef PASSES
centroid in vec3 v_clear;
#else
const vec3 v_clear = vec3(1.0);  // in the light already
#endif
flat in float v_fade;

void main() {
    if (faded(v_fade)) discard;
#ifdef DOT
    vec4 light = v_light;
#else
    vec4 light = speck_light(v_skin, v_tone, v_silver, v_sky + v_sun * v_facing, v_around);
#endif
    show(light.rgb, v_veil, v_clear, light.a);
}
#endif
